/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait against closed forms and published values. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/portrait.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>

static struct typed_models *models;

static struct scene typed(const char *const *lines)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    return scene;
}

#define TYPED(...) typed((const char *const[]){__VA_ARGS__, NULL})

static struct portrait make(const struct scene *scene, double x0, double x1, double y0, double y1,
                            bool energy)
{
    const struct portrait_request request = {
        .scene = scene, .variable = {0, 1}, .box = {{x0, x1}, {y0, y1}}, .energy = energy};
    struct portrait portrait;
    struct error error = {0};
    if (!portrait_make(&request, &portrait, &error))
        fail_msg("%s", error.text);
    return portrait;
}

/* Where a separatrix of the saddle first has that value of a variable; NAN: nowhere. */
static double crossing(const struct portrait *portrait, int saddle, bool stable, int variable,
                       double value, double sign)
{
    for (int i = 0; i < portrait->separatrices; i++) {
        const struct separatrix *s = &portrait->separatrix[i];
        for (int k = 0; k < s->crossings && s->equilibrium == saddle && s->stable == stable; k++)
            if (s->crossing[k].variable == variable && fabs(s->crossing[k].value - value) < 1e-9 &&
                s->crossing[k].other * sign > 0)
                return s->crossing[k].other;
    }
    return NAN;
}

static void relative(double value, double wanted, double tolerance)
{
    close_to(value, wanted, tolerance * fabs(wanted));
}

/* The speed that just reaches the top (13 digits), and the unstable manifold of a damped double
 * well; without damping both are closed forms. */
static void test_separatrices(void **state)
{
    (void)state;
    const struct scene pendulum = TYPED("var q = 1", "var v = 0", "param w0 = 1", "param c = 0.2",
                                        "q' = v", "v' = -w0^2*sin(q)-c*v");
    struct portrait portrait = make(&pendulum, -PI, PI, -3, 3, false);
    assert_int_equal(portrait.found.count, 2);
    assert_int_equal(portrait.separatrices, 4);
    relative(crossing(&portrait, 1, true, 0, 0, 1), 2.41493821760558, 2e-13);
    relative(crossing(&portrait, 1, true, 0, 0, -1), -2.41493821760558, 2e-13);
    portrait_free(&portrait);
    struct scene well =
        TYPED("var x = 1", "var v = 0", "param c = 0.2", "x' = v", "v' = x-x^3-c*v");
    portrait = make(&well, -2, 2, -2, 2, false);
    assert_int_equal(portrait.found.count, 3);
    relative(crossing(&portrait, 1, false, 1, 0, 1), 1.326676841845354, 2e-13);
    for (int i = 0; i < portrait.separatrices; i++)
        if (!portrait.separatrix[i].stable) {
            assert_string_equal(portrait.separatrix[i].end, "equilibrium");
            assert_int_equal(portrait.separatrix[i].target,
                             portrait.separatrix[i].side > 0 ? 2 : 0);
        }
    portrait_free(&portrait);
    well.value[scene_param(&well, "c")] = 0;
    portrait = make(&well, -2, 2, -2, 2, false);
    relative(crossing(&portrait, 1, false, 0, 1, 1), sqrt(0.5), 2e-13);
    relative(crossing(&portrait, 1, false, 1, 0, 1), sqrt(2), 2e-13);
    portrait_free(&portrait);
}

/* How far points of a line are from a closed form, and how far it goes. */
static double off(const struct polyline *line, double (*form)(double x, double y))
{
    double most = 0;
    for (size_t i = 0; i < line->n; i++)
        if (isfinite(line->x[i]))
            most = fmax(most, fabs(form(line->x[i], line->y[i])));
    return most;
}

static int pieces(const struct polyline *line)
{
    int count = 0;
    for (size_t i = 0; i < line->n; i++)
        count += !isfinite(line->x[i]);
    return count;
}

static double cubic(double x, double y)
{
    return y - (x - x * x * x / 3 + 0.5);
}

static double straight(double x, double y)
{
    return x + 0.7 - 0.8 * y;
}

static double islands(double x, double y)
{
    return fmin(fabs(hypot(x - 0.111, y - 0.222) - 0.004), fabs(hypot(x + 0.5, y) - 1));
}

/* All branches, those that are much smaller than a cell, too; each in one piece. */
static void test_nullclines(void **state)
{
    (void)state;
    const struct scene fitzhugh =
        TYPED("var v = 1", "var w = 0", "v' = v-v^3/3-w+0.5", "w' = 0.08*(v+0.7-0.8*w)");
    struct portrait portrait = make(&fitzhugh, -2.5, 2.5, -1.5, 2, false);
    const struct polyline *line = portrait.line;
    assert_true(line[PORTRAIT_NULLCLINE].n > 100 && line[PORTRAIT_NULLCLINE_UP].n > 100);
    assert_true(off(&line[PORTRAIT_NULLCLINE], cubic) < 1e-12);
    assert_true(off(&line[PORTRAIT_NULLCLINE_UP], straight) < 1e-12);
    assert_int_equal(pieces(&line[PORTRAIT_NULLCLINE_UP]), 1);
    portrait_free(&portrait);
    const struct scene small =
        TYPED("var x = 1", "var y = 0", "x' = ((x-0.111)^2+(y-0.222)^2-0.004^2)*((x+0.5)^2+y^2-1)",
              "y' = x+y+10");
    portrait = make(&small, -2, 2, -2, 2, false);
    assert_true(off(&portrait.line[PORTRAIT_NULLCLINE], islands) < 1e-12);
    assert_int_equal(pieces(&portrait.line[PORTRAIT_NULLCLINE]), 2);
    assert_int_equal(portrait.line[PORTRAIT_NULLCLINE_UP].n, 0);
    portrait_free(&portrait);
    /* what changes its sign at a pole is no nullcline */
    const struct scene pole = TYPED("var x = 1", "var y = 0", "x' = 1/(x-0.1234)", "y' = -y");
    portrait = make(&pole, -2, 2, -2, 2, false);
    assert_int_equal(portrait.line[PORTRAIT_NULLCLINE].n, 0);
    portrait_free(&portrait);
}

static double level_spread(const struct polyline *line)
{
    double first = NAN, most = 0;
    for (size_t i = 0; i < line->n; i++) {
        const double e = line->x[i] * line->x[i] * 7.5 + line->y[i] * line->y[i] * 0.1;
        if (isnan(e))
            first = NAN;
        else if (isnan(first))
            first = e;
        else
            most = fmax(most, fabs(e - first) / first);
    }
    return most;
}

/* Lines of equal energy are that; forced scenes have no separatrices. */
static void test_energy(void **state)
{
    (void)state;
    struct scene spring;
    scene_init(&spring, NULL);
    struct portrait portrait = make(&spring, -0.1, 0.1, -0.8, 0.8, true);
    assert_true(portrait.line[PORTRAIT_ENERGY].n > 200);
    assert_true(level_spread(&portrait.line[PORTRAIT_ENERGY]) < 1e-11);
    portrait_free(&portrait);
    const struct preset *driven = preset_by_name(TEXT("duffing-driven"));
    scene_init(&spring, driven);
    portrait = make(&spring, -2, 2, -2, 2, false);
    assert_int_equal(portrait.found.count, 3);
    assert_true(portrait.found.forced);
    assert_int_equal(portrait.separatrices, 0);
    portrait_free(&portrait);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_separatrices),
        cmocka_unit_test(test_nullclines),
        cmocka_unit_test(test_energy),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
