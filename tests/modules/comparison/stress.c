/* SPDX-License-Identifier: GPL-3.0-or-later */
/* stress: every case of every method ends with a verdict that is explained; well-known ones are
 * what they must be. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

#include "modules/comparison/compute/verify.h"
#include "unit/scene/typing.h"
#include "modules/solving/testing.h"

static struct stress stress;
static int methods;

static int set_up(void **state)
{
    (void)state;
    const struct method *all[512];
    struct error error;
    for (size_t i = 0; i < method_catalog.count && methods < 512; i++)
        if (!(method_at(i)->flags & METHOD_EXTERNAL))
            all[methods++] = method_at(i);
    return study_stress(NULL, TEXT(""), all, methods, NULL, &stress, &error) ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    stress_free(&stress);
    return 0;
}

static const struct stress_row *row_of(const char *scene, const char *method)
{
    for (int i = 0; i < stress.rows; i++)
        if (strcmp(stress.cases[stress.row[i].index].name, scene) == 0 &&
            strcmp(stress.row[i].method->row.name, method) == 0)
            return &stress.row[i];
    fail_msg("%s on %s is missing", method, scene);
    return NULL;
}

TEST(test_nothing_is_unexplained)
{
    int counted = 0;
    assert_int_equal(stress.rows, stress.count * methods);
    for (int i = 0; i < stress.rows; i++) {
        const struct stress_row *row = &stress.row[i];
        const bool good = row->verdict == STRESS_EXACT || row->verdict == STRESS_ACCURATE;
        if (row->verdict == STRESS_UNEXPLAINED || row->verdict == STRESS_UNKNOWN)
            fail_msg("%s on %s: unexplained %s", row->method->row.name,
                     stress.cases[row->index].name, row->reason);
        if (good ? !(row->error <= 1e-2) : !row->reason[0])
            fail_msg("%s on %s: error %g, reason '%s'", row->method->row.name,
                     stress.cases[row->index].name, row->error, row->reason);
    }
    for (int v = 0; v < STRESS_VERDICTS; v++)
        counted += stress.count_of[v];
    assert_int_equal(counted, stress.rows);
}

TEST(test_every_stiff_and_extreme_preset_is_there)
{
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct row *row = catalog_row(&preset_catalog, i);
        bool found = false;
        if (strncmp(row->name, "stiff-", 6) != 0 && strncmp(row->name, "extreme-", 8) != 0)
            continue;
        for (int c = 0; c < stress.count; c++)
            found |= strcmp(stress.cases[c].preset, row->name) == 0;
        if (!found)
            fail_msg("%s is in no case", row->name);
    }
}

TEST(test_known_verdicts)
{
    /* clang-format off */
    static const struct {
        const char *scene, *method;
        enum stress_verdict verdict;
    } known[] = {
        {"stiff-vanderpol", "euler", STRESS_DIVERGED},   {"stiff-vanderpol", "rodas5p", STRESS_ACCURATE},
        {"stiff-vanderpol", "radau5", STRESS_ACCURATE},  {"stiff-vanderpol-1e6", "rodas5p", STRESS_ACCURATE},
        {"stiff-vanderpol-1e6", "dopri5", STRESS_REFUSED}, {"robertson", "rodas5p", STRESS_ACCURATE},
        {"robertson", "verlet", STRESS_REFUSED},         {"orego", "rodas5p", STRESS_ACCURATE},
        {"stiff-spring coarse", "rk4", STRESS_DIVERGED}, {"stiff-spring coarse", "implicit-midpoint", STRESS_BOUNDED},
        {"damping huge", "verlet", STRESS_BOUNDED},      {"damping huge", "euler", STRESS_DIVERGED},
        {"damping huge", "backward-euler", STRESS_EXACT}, {"dt far above", "backward-euler", STRESS_DAMPED},
        {"dt far above", "implicit-midpoint", STRESS_BOUNDED}, {"dt far above", "verlet", STRESS_DIVERGED},
        {"dt above limit", "verlet", STRESS_DIVERGED},   {"undamped long", "euler", STRESS_DIVERGED},
        {"undamped long", "verlet", STRESS_BOUNDED},     {"undamped long", "kahan-li8", STRESS_ACCURATE},
        {"undamped long", "exact", STRESS_EXACT},        {"critical above", "exact", STRESS_EXACT},
        {"critical", "dopri5", STRESS_ACCURATE},         {"denormal", "rk4", STRESS_ACCURATE},
        {"squares overflow", "verlet", STRESS_ACCURATE}, {"k < 0", "rk4", STRESS_ACCURATE},
        {"gamma < 0", "rk4", STRESS_ACCURATE},           {"k = 0", "heun", STRESS_ACCURATE},
        {"drag huge", "ruth3", STRESS_REFUSED},          {"drag huge", "dopri5", STRESS_ACCURATE},
        {"at rest", "rk4", STRESS_EXACT},                {"free", "euler", STRESS_EXACT},
        {"T/dt = 1e12", "rk4", STRESS_REFUSED},          {"dt = 0", "rk4", STRESS_REFUSED},
        {"m = 1e-310", "rk4", STRESS_REFUSED},           {"phase lost", "exact", STRESS_BOUNDED},
    };
    /* clang-format on */
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct stress_row *row = row_of(known[i].scene, known[i].method);
        if (row->verdict != known[i].verdict)
            fail_msg("%s on %s: %s (error %g) %s", known[i].method, known[i].scene,
                     catalog_row(&stress_verdict_catalog, row->verdict)->name, row->error,
                     row->reason);
    }
    assert_non_null(strstr(row_of("T/dt = 1e12", "rk4")->reason, "1e+12 steps"));
    assert_non_null(strstr(row_of("dt = 0", "rk4")->reason, "dt must be > 0"));
    assert_non_null(strstr(row_of("m = 1e-310", "rk4")->reason, "overflows"));
    assert_non_null(strstr(row_of("dt above limit", "verlet")->reason, "2 s of verlet"));
}

/* What no method can run is refused to all of them. */
TEST(test_nonsense_is_refused)
{
    static const char *const nonsense[] = {
        "m = 0",    "k = nan",  "y0 = inf",          "dt = 0",       "dt < 0",
        "dt = nan", "dt = inf", "dt below rounding", "T/dt = 1e300", "duration = nan"};
    for (size_t i = 0; i < COUNT_OF(nonsense); i++)
        for (int m = 0; m < methods; m++)
            assert_int_equal(row_of(nonsense[i], stress.row[m].method->row.name)->verdict,
                             STRESS_REFUSED);
}

TEST(test_cancelled_keeps_what_is_finished)
{
    struct cancel cancel = {1};
    struct stress none;
    struct error error;
    const struct method *one[] = {method_named("rk4")};
    assert_false(study_stress(NULL, TEXT(""), one, 1, &cancel, &none, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_int_equal(none.rows, 0);
    stress_free(&none);
}

/* A decay y' = -k y of one's own: limits, signs and sizes give the verdicts that they must. */
TEST(test_a_typed_scene)
{
    static const struct {
        const char *name, *method;
        enum stress_verdict verdict;
    } known[] = {
        {"as it is", "rk4", STRESS_ACCURATE},     {"dt x 0.99", "euler", STRESS_BOUNDED},
        {"dt x 2", "euler", STRESS_DIVERGED},     {"dt x 10", "backward-euler", STRESS_BOUNDED},
        {"k x 1e6", "rk4", STRESS_DIVERGED},      {"k x 1e6", "radau5", STRESS_EXACT},
        {"k = 0", "euler", STRESS_EXACT},         {"k x -1", "radau5", STRESS_ACCURATE},
        {"start 1e-310", "rk4", STRESS_ACCURATE}, {"start 1e150", "rk4", STRESS_ACCURATE},
        {"as it is", "verlet", STRESS_REFUSED}};
    (void)state;
    const struct method *one[] = {method_named("rk4"), method_named("euler"),
                                  method_named("backward-euler"), method_named("radau5"),
                                  method_named("verlet")};
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    const char *const lines[] = {"var y = 1", "param k = 4", "y' = -k*y", NULL};
    bool start[PARAM_MAX] = {false}, matter[PARAM_MAX] = {false};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    start[scene_param(&scene, "y0")] = matter[scene_param(&scene, "k")] = true;
    const struct stress_scene of = {&scene, 10, start, matter};
    struct stress made;
    assert_true(study_stress(&of, TEXT(""), one, COUNT_OF(one), NULL, &made, &error));
    assert_int_equal(made.count, 1 + 6 + 4 + 3);
    assert_int_equal(made.count_of[STRESS_UNEXPLAINED] + made.count_of[STRESS_UNKNOWN], 0);
    for (size_t i = 0; i < COUNT_OF(known); i++)
        for (int r = 0; r < made.rows; r++)
            if (strcmp(made.cases[made.row[r].index].name, known[i].name) == 0 &&
                strcmp(made.row[r].method->row.name, known[i].method) == 0 &&
                made.row[r].verdict != known[i].verdict)
                fail_msg("%s on %s: %d, error %g, %s", known[i].method, known[i].name,
                         (int)made.row[r].verdict, made.row[r].error, made.row[r].reason);
    stress_free(&made);
    typed_destroy(models);
}

RUN_TESTS(set_up, tear_down)
