/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Measured order of every method and drag variant on six problems, against a reference that shares no code with the
 * library: RK4 in long double, 2^14 steps, on forces written out here. |slope - claim| <= 0.05.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "method_testing.h"

typedef long double real;

struct problem {
    const char *name;
    struct system system;
    real (*acceleration)(real t, real q, real v);
    double t0, span, start[2];
    double wanted[2]; /* reference */
};

static real undamped_force(real t, real q, real v)
{
    (void)t, (void)v;
    return -1.5L * q;
}

static real damped_force(real t, real q, real v)
{
    (void)t;
    return -1.5L * q - 0.5L * v;
}

static real drag_force(real t, real q, real v)
{
    (void)t;
    return -1.5L * q - 0.25L * v - 0.75L * fabsl(v) * v;
}

static real driven_force(real t, real q, real v)
{
    return -1.5L * q - 0.5L * v - 0.25L + 0.75L * cosl(2 * t + 0.5L);
}

static real duffing_force(real t, real q, real v)
{
    (void)t, (void)v;
    return -q - 0.5L * q * q * q;
}

static real pushed_force(real t, real q, real v)
{
    (void)v;
    return -sinl(q) + 0.25L * cosl(t);
}

/* q'' = -sin q + c cos t: nonlinear and dependent on time */
static void pushed_add(const double *c, double t, const double *y, double *a)
{
    a[0] += c[0] * cos(t) - sin(y[0]);
}

static void pushed_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t;
    jac[0] -= cos(y[0]);
}

static const struct term_row pushed_row = {
    .row = {"pushed", "m/s^2", "", "", NULL}, .flags = TERM_TIME, .add = pushed_add, .jacobian = pushed_jacobian};

static void solve_reference(struct problem *problem)
{
    const int n = 1 << 14;
    real h = (real)problem->span / n, q = (real)problem->start[0], v = (real)problem->start[1];
    for (int i = 0; i < n; i++) {
        real t = (real)problem->t0 + i * h;
        real q1 = v, v1 = problem->acceleration(t, q, v);
        real q2 = v + h / 2 * v1, v2 = problem->acceleration(t + h / 2, q + h / 2 * q1, q2);
        real q3 = v + h / 2 * v2, v3 = problem->acceleration(t + h / 2, q + h / 2 * q2, q3);
        real q4 = v + h * v3, v4 = problem->acceleration(t + h, q + h * q3, q4);
        q += h / 6 * (q1 + 2 * q2 + 2 * q3 + q4);
        v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    }
    problem->wanted[0] = (double)q;
    problem->wanted[1] = (double)v;
}

enum { UNDAMPED, DAMPED, DRAG, DRIVEN, DUFFING, PUSHED, PROBLEMS };

static struct problem problems[PROBLEMS];

/* clang-format off */
static int set_up(void **state)
{
    (void)state;
    /* C rho area / m = 0.75; it is only C^1 at v = 0, so that arc has no turning point. */
    problems[UNDAMPED] = (struct problem){"undamped", SPRING({"m", 1}, {"k", 1.5}), undamped_force,
                                          0, 3, {1, 0.5}, {0}};
    problems[DAMPED] = (struct problem){"damped", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}), damped_force,
                                        0, 3, {1, 0.5}, {0}};
    problems[DRAG] = (struct problem){
        "quadratic drag", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.25}, {"C", 0.75}, {"rho", 1}, {"area", 1}),
        drag_force, 0, 1.5, {1, -0.5}, {0}};
    problems[DRIVEN] = (struct problem){
        "driven", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}, {"g", 0.25}, {"F0", 0.75}, {"omega", 2}, {"phase", 0.5}),
        driven_force, 0.5, 3, {1, 0.5}, {0}};
    problems[DUFFING] = (struct problem){"duffing", duffing(0.5), duffing_force, 0, 3, {1, 0.5}, {0}};
    problems[PUSHED] = (struct problem){"pushed pendulum", other_system(&pushed_row, 0.25), pushed_force,
                                        0.5, 3, {1, 0.5}, {0}};
    for (int p = 0; p < PROBLEMS; p++) {
        problems[p].system.scale[0] = problems[p].system.scale[1] = 1;
        solve_reference(&problems[p]);
    }
    return 0;
}
/* clang-format on */

static double error_of(const struct method *method, enum drag drag, const struct problem *problem, long n)
{
    double y[2] = {problem->start[0], problem->start[1]}, h = problem->span / (double)n;
    assert_int_equal(advance_as(method, drag, &problem->system, problem->t0, h, n, y), STEP_OK);
    return hypot(y[0] - problem->wanted[0], y[1] - problem->wanted[1]);
}

/* Enough steps for the leading term to rule, few enough for rounding not to. */
static long steps_for(int order)
{
    static const long steps[] = {0, 1 << 14, 1 << 10, 1 << 8, 1 << 6, 1 << 5};
    assert_in_range(order, 1, COUNT_OF(steps) - 1);
    return steps[order];
}

/* From n, 2n and 4n steps: the slope deviates in proportion to h, so that extrapolation takes the deviation out. */
static double slope(const struct method *method, enum drag drag, const struct problem *problem, int order)
{
    long n = steps_for(order);
    double coarse = error_of(method, drag, problem, n), middle = error_of(method, drag, problem, 2 * n);
    double fine = error_of(method, drag, problem, 4 * n);
    return 2 * log2(middle / fine) - log2(coarse / middle);
}

static void check_order(const struct method *method, enum drag drag, const struct problem *problem, int claim)
{
    char what[120];
    snprintf(what, sizeof what, "%s drag %d on %s", method->row.name, drag, problem->name);
    assert_near(what, slope(method, drag, problem, claim), claim, 0.05);
}

static void test_every_row(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int p = 0; p < PROBLEMS; p++) {
            const struct method *method = method_at(m);
            if (method->order > 0 && applies(method, &problems[p].system, DRAG_DEFAULT))
                check_order(method, DRAG_DEFAULT, &problems[p], method->order);
        }
}

/* Explicit drag makes a second-order splitting first order; exact and implicit do not. */
static void test_drag_variants(void **state)
{
    (void)state;
    static const int with_drag[] = {DAMPED, DRAG, DRIVEN};
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int variant = DRAG_EXACT; variant < DRAG_COUNT; variant++)
            for (size_t p = 0; p < COUNT_OF(with_drag); p++) {
                const struct method *method = method_at(m);
                const struct problem *problem = &problems[with_drag[p]];
                enum drag drag = (enum drag)variant;
                if (applies(method, &problem->system, drag))
                    check_order(method, drag, problem, drag == DRAG_EXPLICIT ? 1 : method->order);
            }
}

static void test_exact_has_no_error(void **state)
{
    (void)state;
    const struct method *exact = method_named("exact");
    for (int p = 0; p < PROBLEMS; p++) {
        if (!applies(exact, &problems[p].system, DRAG_DEFAULT))
            continue;
        assert_int_equal(exact->order, 0);
        assert_below(problems[p].name, error_of(exact, DRAG_DEFAULT, &problems[p], 1), 1e-15);
        assert_below(problems[p].name, error_of(exact, DRAG_DEFAULT, &problems[p], 100), 2e-14);
    }
}

/* Through a turning point quadratic drag is only C^1: high order is lost there, which is why the arc above has none. */
static void test_order_is_lost_at_turning_points(void **state)
{
    (void)state;
    struct problem swing = problems[DRAG];
    swing.span = 3.7;
    solve_reference(&swing);
    double got = slope(method_named("dopri5"), DRAG_DEFAULT, &swing, 5);
    if (fabs(got - 5) <= 0.05)
        fail_msg("order %.3f through a turning point", got);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_row),
        cmocka_unit_test(test_drag_variants),
        cmocka_unit_test(test_exact_has_no_error),
        cmocka_unit_test(test_order_is_lost_at_turning_points),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
