/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Basins of attraction against single runs, and against what is known of them. */
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

static struct basins_request square(const struct scene *scene, double half, int count)
{
    return (struct basins_request){.scene = scene,
                                   .axis = {{0, -half, half, count}, {1, -half, half, count}}};
}

static struct basins find(const struct basins_request *request)
{
    struct basins basins;
    struct error error = {0};
    if (!basins_find(request, &basins, &error))
        fail_msg("%s", error.text);
    return basins;
}

/* By an integrator of the test's own: the sign of x long after. */
static double run_alone(const struct scene *scene, double x, double v, double time, double h)
{
    struct system system;
    struct error error = {0};
    assert_true(scene_bind(scene, &system, &error));
    double y[2] = {x, v}, k[4][2], z[2];
    static const double share[] = {0, 0.5, 0.5, 1};
    const long steps = lround(time / h);
    for (long s = 0; s < steps; s++) {
        for (int j = 0; j < 4; j++) {
            for (int i = 0; i < 2; i++)
                z[i] = y[i] + (j > 0 ? share[j] * h * k[j - 1][i] : 0);
            system_derivative(&system, system.t0 + ((double)s + share[j]) * h, z, k[j]);
        }
        for (int i = 0; i < 2; i++)
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
    }
    return y[0];
}

/* Random starts: each ends where a run of its own says. */
static void cross_check(const struct basins_request *request, const struct basins *basins)
{
    uint64_t seed = 3;
    int wrong = 0;
    const int starts = is_long() ? 1000 : 40;
    for (int k = 0; k < starts; k++) {
        const int64_t i = (int64_t)(random_fraction(&seed) * (double)basins->total),
                      up = request->axis[1].count;
        const int fate = basins->fate[i];
        assert_in_range(fate, 0, basins->count - 1);
        const double x = run_alone(request->scene, basins_value(request, 0, i / up),
                                   basins_value(request, 1, i % up), 30 * TWO_PI, TWO_PI / 300);
        wrong += x * basins->basin[fate].state[0] < 0;
    }
    if (is_long())
        print_message("%d of %d differ from single runs\n", wrong, starts);
    assert_in_range(wrong, 0, starts / 200);
}

static void test_wells(void **state)
{
    (void)state;
    const int count = is_long() ? 400 : 40;
    struct scene scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = x-x^3-0.2*v");
    struct basins_request request = square(&scene, 2, count);
    struct basins basins = find(&request);
    assert_int_equal(basins.count, 2);
    assert_int_equal(basins.escaping + basins.undecided, 0);
    assert_int_equal(basins.basin[0].count, basins.basin[1].count); /* symmetric */
    for (int k = 0; k < 2; k++) {
        assert_int_equal(basins.basin[k].kind, BASIN_EQUILIBRIUM);
        close_to(fabs(basins.basin[k].state[0]), 1, 1e-12);
        close_to(basins.basin[k].growth, -0.1, 1e-12);
    }
    cross_check(&request, &basins);
    basins_free(&basins);

    scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = x-x^3-0.2*v+0.1*cos(t)");
    request = square(&scene, 2, count);
    request.threads = 1;
    basins = find(&request);
    assert_int_equal(basins.count, 2);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(basins.basin[k].kind, BASIN_RESPONSE);
        assert_int_equal(basins.basin[k].multiple, 1);
        /* a pair: the product of both multipliers is exp(-0.2 2 pi) */
        close_to(basins.basin[k].growth, exp(-0.2 * PI), 1e-6);
    }
    cross_check(&request, &basins);
    request.threads = 2;
    struct basins again = find(&request);
    assert_memory_equal(again.fate, basins.fate, (size_t)basins.total);
    if (is_long())
        print_message("400 x 400: %.2f s by one thread, %.2f s by two\n", basins.seconds,
                      again.seconds);
    basins_free(&again);
    basins_free(&basins);
}

/* What leaves, a limit cycle, angles, motion that does not repeat. */
static void test_kinds(void **state)
{
    (void)state;
    struct scene scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = -x+x^3-0.2*v");
    struct basins_request request = square(&scene, 2, 30);
    struct basins basins = find(&request);
    assert_int_equal(basins.count, 1);
    assert_true(basins.escaping > 300);
    assert_int_equal(basins.basin[0].count + basins.escaping, basins.total);
    basins_free(&basins);

    scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = (1-x^2)*v-x");
    request = square(&scene, 3, 20);
    basins = find(&request);
    assert_int_equal(basins.count, 1);
    assert_int_equal(basins.basin[0].kind, BASIN_ORBIT);
    close_to(basins.basin[0].period, 6.6632868593231, 1e-6);
    close_to(basins.basin[0].growth, 8.596950636e-4, 1e-7);
    assert_int_equal(basins.basin[0].count, basins.total);
    basins_free(&basins);

    /* rest at a multiple of 2 pi is one */
    scene = TYPED("var q = 1", "var v = 0", "q' = v", "v' = -sin(q)-0.2*v");
    request = square(&scene, 6, 20);
    basins = find(&request);
    assert_int_equal(basins.count, 1);
    assert_int_equal(basins.basin[0].count, basins.total);
    basins_free(&basins);

    scene = TYPED("var x = 1", "var v = 0", "x' = v", "v' = x-x^3-0.2*v+0.3*cos(t)");
    request = square(&scene, 2, 12);
    basins = find(&request);
    assert_int_equal(basins.count, 1);
    assert_int_equal(basins.basin[0].kind, BASIN_IRREGULAR);
    basins_free(&basins);
}

/* Three magnets at the corners of a triangle: the middle's symmetry is that of the shares. */
static void test_magnets(void **state)
{
    (void)state;
    const struct scene scene = TYPED(
        "var x = 0", "var y = 0", "var u = 0", "var v = 0", "x' = u", "y' = v",
        "u' = -0.5*x-0.4*u-(x-1)/((x-1)^2+y^2+0.1)^1.5-(x+0.5)/((x+0.5)^2+(y-0.8660254037844386)^2+"
        "0.1)^1.5-(x+0.5)/((x+0.5)^2+(y+0.8660254037844386)^2+0.1)^1.5",
        "v' = -0.5*y-0.4*v-y/((x-1)^2+y^2+0.1)^1.5-(y-0.8660254037844386)/((x+0.5)^2+(y-"
        "0.8660254037844386)^2+0.1)^1.5-(y+0.8660254037844386)/((x+0.5)^2+(y+0.8660254037844386)^2+"
        "0.1)^1.5");
    const struct basins_request request = square(&scene, 2, 31);
    struct basins basins = find(&request);
    assert_int_equal(basins.escaping + basins.undecided, 0);
    int stable = 0;
    for (int k = 0; k < basins.count; k++) {
        stable += basins.basin[k].stable;
        if (basins.basin[k].stable)
            close_to((double)basins.basin[k].count / (double)basins.total, 1.0 / 3, 0.05);
    }
    assert_int_equal(stable, 3);
    basins_free(&basins);
}

static void test_refused(void **state)
{
    (void)state;
    static const char *const line[] = {"v' = -x", "v' = -x-v+sin(t)*sin(sqrt(2)*t)"};
    for (size_t k = 0; k < COUNT_OF(line); k++) {
        const struct scene scene = TYPED("var x = 1", "var v = 0", "x' = v", line[k]);
        const struct basins_request request = square(&scene, 2, 10);
        struct basins basins;
        struct error error = {0};
        assert_false(basins_find(&request, &basins, &error));
        basins_free(&basins);
    }
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_wells), cmocka_unit_test(test_kinds),
                                       cmocka_unit_test(test_magnets),
                                       cmocka_unit_test(test_refused)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
