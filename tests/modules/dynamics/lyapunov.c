/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lyapunov exponents against closed forms, multipliers and published values. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/chaos.h"

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

/* From the scene's start; duration 0: chosen. */
static struct lyapunov exponents(const struct scene *scene, double duration)
{
    struct lyapunov found;
    struct error error = {0};
    const struct lyapunov_request request = {.scene = scene, .duration = duration, .skip = -1};
    if (!lyapunov_find(&request, &found, &error))
        fail_msg("%s", error.text);
    if (found.count == found.n && found.time > 0)
        close_to(found.sum, found.divergence, 1e-9);
    return found;
}

static struct scene lorenz(double x, double y, double z)
{
    char start[3][64];
    for (int i = 0; i < 3; i++)
        snprintf(start[i], sizeof start[i], "var %c = %.17g", "xyz"[i],
                 i == 0   ? x
                 : i == 1 ? y
                          : z);
    return TYPED(start[0], start[1], start[2], "x' = 10*(y-x)", "y' = x*(28-z)-y",
                 "z' = x*y-8/3*z");
}

/* Time of an average: as long as the exact values need, less than what would be chosen. */
#define TIME 1000

/* What is regular has its exponents to rounding of the steps, and the error says so. */
static void test_closed_forms(void **state)
{
    (void)state;
    static const struct {
        const char *line[3];
        double value[2], time;
    } cases[] = {
        {{"x' = 0.5*x", "v' = -0.7*v"}, {0.5, -0.7}, TIME},
        {{"x' = -x+v", "v' = -3*v"}, {-1, -3}, TIME},
        {{"x' = v", "v' = -x-0.3*v"}, {-0.15, -0.15}, TIME},
        {{"x' = v", "v' = -2*0.1*2*v-2^2*x+cos(1.5*t)"}, {-0.2, -0.2}, 4 * TIME},
        /* steps are short where rates are large: not to be counted more */
        {{"x' = x*(0.05+30*cos(t)^9)", "v' = -v"}, {0.05, -1}, 150 * TWO_PI},
        /* van der Pol: the logarithm of the multiplier 8.596950636e-4 a period */
        {{"x' = v", "v' = (1-x^2)*v-x"}, {0, -1.0593769948419}, TIME},
        /* comes to rest at 1: the linear part there, -0.1 +- i 1.41 */
        {{"x' = v", "v' = x-x^3-0.2*v"}, {-0.1, -0.1}, 2 * TIME},
    };
    for (size_t k = 0; k < COUNT_OF(cases); k++) {
        const struct scene scene =
            TYPED("var x = 1.5", "var v = 0.3", cases[k].line[0], cases[k].line[1]);
        const struct lyapunov found = exponents(&scene, cases[k].time);
        assert_true(found.determined);
        assert_true(found.regular);
        for (int i = 0; i < 2; i++) {
            close_to(found.exponent[i].value, cases[k].value[i], 2e-12);
            close_to(found.exponent[i].value, cases[k].value[i], 4 * found.exponent[i].error);
        }
        assert_true(found.exponent[0].error < 1e-8);
    }
}

static void near_by(struct exponent found, double wanted, double uncertainty)
{
    close_to(found.value, wanted, 4 * hypot(found.error, uncertainty));
    assert_true(found.error < 0.1);
}

/* Means over 8 starts by two other integrators; Sprott 2003. */
static void test_chaos(void **state)
{
    (void)state;
    struct scene scene = lorenz(1, 1, 1);
    const struct lyapunov l = exponents(&scene, is_long() ? 0 : 100);
    near_by(l.exponent[0], 0.9055, 0.0003);
    near_by(l.exponent[1], 0, 0);
    near_by(l.exponent[2], -14.5721, 0.0003);
    close_to(l.sum, -41.0 / 3, 1e-9);
    near_by(l.dimension, 2.0621, 0.0001);
    assert_false(l.regular);

    scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = -0.2*v+x-x^3+0.3*cos(t)");
    const struct lyapunov d = exponents(&scene, is_long() ? 0 : 1000);
    near_by(d.exponent[0], 0.1578, 0.0007);
    near_by(d.exponent[1], -0.3578, 0.0007);
    close_to(d.sum, -0.2, 1e-11);
    assert_true(d.strobe < 1e-11);
    close_to(d.period, TWO_PI, 1e-14);

    /* winds round and round */
    scene = TYPED("var q = 1", "var v = 0", "q' = v", "v' = -v/2-sin(q)+1.5*cos(2*t/3)");
    const struct lyapunov p = exponents(&scene, is_long() ? 0 : 1000);
    near_by(p.exponent[0], 0.1125, 0.0004);
    near_by(p.exponent[1], -0.6125, 0.0004);
    assert_true(p.strobe < 1e-11);
}

/* In pairs +-, all of them 0 where the motion is regular. */
static void test_hamiltonian(void **state)
{
    (void)state;
    const struct scene scene = scene_with("henon-heiles", NO_SETTINGS);
    const struct lyapunov found = exponents(&scene, 500);
    assert_true(found.conservative);
    for (int i = 0; i < 4; i++)
        close_to(found.exponent[i].value + found.exponent[3 - i].value, 0,
                 4 * (found.exponent[i].error + found.exponent[3 - i].error));
    close_to(found.dimension.value, 4, 0);
}

/* A kink does not matter; a jump of the equations does, and what leaves. */
static void test_limits(void **state)
{
    (void)state;
    struct scene scene = TYPED("var x = 0.1", "var y = 0", "var z = 0",
                               "x' = 15.6*(y-x-(-0.714*x+0.5*(-0.429)*(abs(x+1)-abs(x-1))))",
                               "y' = x-y+z", "z' = -28*y");
    struct lyapunov found = exponents(&scene, 100);
    assert_true(found.exponent[0].value > 0.2);
    scene = TYPED("var x = 1", "var y = 1", "x' = y", "y' = -x-sign(y)+2*cos(t)");
    found = exponents(&scene, 100);
    assert_false(found.determined);
    assert_non_null(strstr(found.reason, "jump"));
    scene = TYPED("var x = 1", "x' = x^2");
    found = exponents(&scene, 100);
    assert_false(found.determined);
    assert_non_null(strstr(found.reason, "escapes"));
    scene = lorenz(1, 1, 1);
    found = exponents(&scene, 5);
    assert_false(found.determined);
    assert_true(isnan(found.exponent[1].error));
    assert_non_null(strstr(found.reason, "short"));
}

/* Fewer tangents: the same largest exponents, for less. */
static void test_largest(void **state)
{
    (void)state;
    const struct scene scene = TYPED("var x = 2", "var y = 0", "x' = y", "y' = (1-x^2)*y-x");
    const struct lyapunov_request request = {
        .scene = &scene, .count = 1, .duration = 1000, .skip = 50};
    struct lyapunov found;
    struct error error = {0};
    assert_true(lyapunov_find(&request, &found, &error));
    assert_int_equal(found.count, 1);
    close_to(found.exponent[0].value, 0, 1e-11);
    assert_true(isnan(found.dimension.value));
    close_to(found.divergence, -1.0593769948419, 1e-11);
}

/* The 95 % interval of one start covers what all of them find; its width is that of their scatter.
 */
static void test_coverage(void **state)
{
    (void)state;
    const int starts = is_long() ? 200 : 8;
    const double time = is_long() ? 500 : 60;
    uint64_t seed = 5;
    double mean = 0, square = 0, error = 0;
    int covered = 0;
    for (int k = 0; k < starts; k++) {
        const double x = 20 * random_fraction(&seed) - 10, y = 20 * random_fraction(&seed) - 10;
        const struct scene scene = lorenz(x, y, 10 + 20 * random_fraction(&seed));
        const struct lyapunov found = exponents(&scene, time);
        const struct exponent *e = found.exponent;
        assert_true(found.determined);
        covered += fabs(e->value - 0.9056) <= 2 * e->error;
        mean += e->value / starts;
        square += e->value * e->value / starts;
        error += e->error / starts;
    }
    const double scatter = sqrt(square - mean * mean);
    if (is_long())
        print_message("covered %d of %d, mean %.5f, scatter %.5f, standard error %.5f\n", covered,
                      starts, mean, scatter, error);
    assert_in_range(covered, is_long() ? 180 : 6, is_long() ? 198 : 8);
    close_to(mean, 0.9056, 4 * scatter / sqrt(starts));
    /* of short times both ends add to it */
    assert_true(error > 0.5 * scatter && error < (is_long() ? 1.5 : 6) * scatter);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_chaos),
        cmocka_unit_test(test_hamiltonian),  cmocka_unit_test(test_limits),
        cmocka_unit_test(test_largest),      cmocka_unit_test(test_coverage)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
