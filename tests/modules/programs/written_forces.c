/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Forces as text: of every built-in scene and of typed ones the expressions have the bits of what
 * integrators are given; texts in C and LaTeX read as they should.
 */
#include <hooke/base/catalog.h>
#include "modules/programs/compute/written.h"
#include "faults/failing_malloc.h"
#include "unit/scene/testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct place {
    const struct written *written;
    double value[1 + LIMIT_VARIABLES + PARAM_MAX + LIMIT_OBSERVED];
};

static double load(const void *context, int slot)
{
    const struct place *place = context;
    const struct written *w = place->written;
    const struct expr_scope scope = {.context = context, .load = load};
    return slot >= w->observed ? expr_value(w->observe[slot - w->observed], &scope)
                               : place->value[slot];
}

static void same(const char *what, const char *of, double got, double wanted)
{
    if (!(got == wanted) && !(isnan(got) && isnan(wanted)))
        fail_msg("%s: %s is %.17g, not %.17g", of, what, got, wanted);
}

static void compare(const struct scene *scene, uint64_t *seed, const char *of)
{
    struct written w;
    struct error error = {0};
    if (!written_make(&w, scene, false, &error))
        fail_msg("%s: %s", of, error.text);
    struct place place = {.written = &w};
    const struct expr_scope scope = {.context = &place, .load = load};
    for (int trial = 0; trial < 50; trial++) {
        double y[LIMIT_VARIABLES], rate[LIMIT_VARIABLES];
        place.value[0] = random_between(seed, 0, 10);
        for (int i = 0; i < w.system.n; i++)
            place.value[1 + i] = y[i] = w.system.scale[i] * random_between(seed, -1, 1);
        for (int i = 0; i < w.observed - w.params; i++)
            place.value[w.params + i] = scene->value[i];
        system_derivative(&w.system, place.value[0], y, rate);
        for (int row = 0; row < w.rows; row++) {
            double got = w.all[row] ? expr_value(w.all[row], &scope) : 0;
            if (w.dry && y[1] != 0)
                got -= copysign(expr_value(w.dry, &scope), y[1]);
            same("an acceleration", of, got, rate[w.system.n - w.rows + row]);
        }
    }
    written_free(&w);
}

TEST(test_built_in)
{
    uint64_t seed = 20;
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct preset *preset = (const struct preset *)catalog_row(&preset_catalog, i);
        struct scene scene;
        scene_init(&scene, preset);
        compare(&scene, &seed, preset->row.name);
        for (size_t k = 0; k < scene_params(&scene)->count; k++)
            if (scene.value[k] == 0)
                scene.value[k] = random_between(&seed, 0.1, 0.4);
        struct system system;
        struct error error;
        if (scene_bind(&scene, &system, &error)) /* not where it overflows */
            compare(&scene, &seed, preset->row.name);
    }
}

static void put(struct written *w, enum dialect dialect, const char *wanted)
{
    struct buffer text = {0};
    if (w->all[0])
        assert_true(expr_text(w->all[0], dialect, w->name, w->zero, &text));
    else /* nothing is added */
        buffer_put(&text, TEXT("0"));
    assert_string_equal(buffer_view(&text), wanted);
    buffer_free(&text);
}

TEST(test_typed)
{
    static const struct {
        const char *equation, *c, *tex;
    } rows[] = {
        {"-k*y-c*y'+2*y^3", "-k*y + 2*(y*y*y) - c*vy", "-k y + 2 y^{3} - c vy"},
        {"-(y-c)/(k+y)", "-(y - c)/(k + y)", "-\\frac{y - c}{k + y}"},
        {"-sin(y)^2*0*k", "0", "0"},
        {"if(y<0,-k*y,abs(y)^1.5)", "(((double)(y < 0)) > 0 ? -k*y : power(fabs(y), 1.5))", NULL},
        {"-y^k+k^(-y)", "-pow(y, k) + pow(k, -y)", NULL},
        {"k-(c-y)-(-y*k)", "k - (c - y) + y*k", NULL},
        {"E*k+zero*exp(y)", "E*k", NULL},
    };
    uint64_t seed = 7;
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        struct error error = {0};
        struct typed_models *models = typed_create(&error);
        const struct typed_line line[] = {
            {.kind = TYPED_VAR, .name = TEXT("y"), .value = 1},
            {.kind = TYPED_PARAM, .name = TEXT("k"), .value = 3},
            {.kind = TYPED_PARAM, .name = TEXT("c"), .value = 0.1},
            {.kind = TYPED_PARAM, .name = TEXT("zero"), .value = 0},
            {.kind = TYPED_OBSERVE, .name = TEXT("E"), .expr = TEXT("y*y+k")},
            {.kind = TYPED_EQUATION,
             .name = TEXT("y"),
             .order = 2,
             .expr = {rows[i].equation, strlen(rows[i].equation)}}};
        const struct model *model =
            typed_make(models, TEXT("made"), line, (int)COUNT_OF(line), NULL, &error);
        if (!model)
            fail_msg("%s: %s", rows[i].equation, error.text);
        struct scene scene;
        scene_init(&scene, typed_preset(model));
        compare(&scene, &seed, rows[i].equation);
        struct written w;
        assert_true(written_make(&w, &scene, false, &error));
        put(&w, DIALECT_C, rows[i].c);
        if (rows[i].tex)
            put(&w, DIALECT_TEX, rows[i].tex);
        written_free(&w);
        typed_destroy(models);
    }
}

/* A text is whole, or there is none. */
TEST(test_no_memory)
{
    struct scene scene;
    struct written w;
    struct error error = {0};
    bool failed = MALLOC_CAN_FAIL;
    scene_init(&scene, (const struct preset *)catalog_find(&preset_catalog, TEXT("duffing")));
    assert_true(written_make(&w, &scene, false, &error));
    for (long i = 0; failed; i++) {
        struct buffer text = {0};
        malloc_calls = 0;
        malloc_fail_at = i;
        const bool fine = expr_text(w.all[0], DIALECT_C, w.name, w.zero, &text);
        malloc_fail_at = -1;
        failed = malloc_calls > i;
        assert_int_equal(fine, !failed);
        if (fine)
            assert_string_equal(buffer_view(&text), "-k/m*y - k3/m*y*y*y");
        buffer_free(&text);
    }
    written_free(&w);
}

RUN_TESTS(NULL, NULL)
