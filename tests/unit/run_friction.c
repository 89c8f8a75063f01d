/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dry friction in runs: against closed forms, by every method, with what sticks and breaks away. */
#include "run_fixture.h"

#include <hooke/method.h>

/*
 * Free swings with friction f = F/m from rest at A > 0: half a period is pi/omega, each takes 2 f/omega^2 off the
 * amplitude, and where it ends within f/omega^2 of the middle the body stays.
 */
static void closed_form(double omega, double f, double A, double t, double *y)
{
    const double half = 3.14159265358979323846 / omega, shift = f / (omega * omega);
    double side = 1;
    while (t > half && A > shift) {
        t -= half;
        A -= 2 * shift;
        side = -side;
    }
    const double swing = A > shift ? A - shift : 0;
    y[0] = side * (A > shift ? shift + swing * cos(omega * t) : A);
    y[1] = -side * swing * omega * sin(omega * t);
}

static struct scene rubbing(double friction)
{
    struct scene scene = spring();
    set(&scene, "friction", friction);
    return scene;
}

static double largest_error(const struct run *run, double friction)
{
    double largest = 0, y[2];
    const double m = 0.2, k = 15;
    for (size_t i = 0; i < trace_count(run->trace); i++) {
        closed_form(sqrt(k / m), friction / m, 0.05, trace_time(run->trace, i), y);
        largest = fmax(largest, fabs(trace_state(run->trace, i)[0] - y[0]));
    }
    return largest / 0.05;
}

#define FRICTION 0.02 /* [N]: 19 half periods, then at rest at y = 2/3 mm */
#define REST (0.05 / 75)

static struct run *rub(const struct method *method, double dt, double tol)
{
    const struct scene scene = rubbing(FRICTION);
    const struct run_settings settings = {.dt = dt, .tol = tol};
    struct error error = {0};
    struct run *run = run_create(&scene, method, &settings, 9, &error);
    if (!run)
        fail_msg("%s: %s", method->row.name, error.text);
    go_to(run, 9);
    assert_int_equal(run->stop, STOP_END);
    return run;
}

#define EACH_METHOD(method)                                                                                            \
    (size_t i = 0; i < method_catalog.count; i++)                                                                      \
        for (const struct method *method = (const void *)catalog_row(&method_catalog, i); method; method = NULL)

/* Fixed steps keep their order through 19 turning points and into rest, where the velocity is exactly 0. */
static void test_every_method_keeps_its_order(void **state)
{
    (void)state;
    for EACH_METHOD(method) {
        if (method->flags & METHOD_YARDSTICK)
            continue;
        double error[2];
        for (int half = 0; half < 2; half++) {
            struct run *run = rub(method, half ? 0.00125 : 0.0025, 0);
            error[half] = largest_error(run, FRICTION);
            assert_true(run->y[1] == 0 || method->order == 1);
            if (method->order != 1 && run->cost.turns != 19)
                fail_msg("%s: %d ends at turning points", method->row.name, (int)run->cost.turns);
            run_destroy(run);
        }
        /* Order 1 gains or loses so much that it turns another number of times. */
        const double wanted = method->order == 1 ? 1.3 : pow(2, method->order - 0.4);
        if (error[1] > 1e-11 && error[0] / error[1] < wanted)
            fail_msg("%s: errors %.3g, %.3g fall by less than %.3g", method->row.name, error[0], error[1], wanted);
    }
}

static void test_adaptive_methods_keep_the_tolerance(void **state)
{
    (void)state;
    for EACH_METHOD(method)
        for (double tol = 1e-5; method->flags & METHOD_ADAPTIVE && tol > 1e-8; tol /= 100) {
            struct run *run = rub(method, 0.001, tol);
            const double error = largest_error(run, FRICTION);
            if (!(error < 30 * tol))
                fail_msg("%s: error %.3g at tol = %.3g", method->row.name, error, tol);
            assert_true(run->y[1] == 0);
            assert_close(run->y[0], REST, 30 * tol * 0.05);
            run_destroy(run);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_method_keeps_its_order),
        cmocka_unit_test(test_adaptive_methods_keep_the_tolerance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
