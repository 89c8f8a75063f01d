/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The lab's spring, 1000 steps of 10 ms, against independently computed values; and single steps
 * against the formulas.
 */
#include "cmocka_testing.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "numerics/method/testing.h"

struct reference {
    const char *method;
    enum drag drag;
    double gamma, y, v; /* at t = 10 s */
};

static const struct reference references[] = {
    {"euler", DRAG_DEFAULT, 0, -0.01424539097, 18.15590981},
    {"backward-euler", DRAG_DEFAULT, 0, -8.102509707e-06, 0.01032673907},
    {"symplectic-euler", DRAG_DEFAULT, 0, 0.009575321296, 0.4214226485},
    {"symplectic-euler-kick", DRAG_DEFAULT, 0, 0.01378954778, 0.4214226485},
    {"midpoint", DRAG_DEFAULT, 0, 0.01568394931, 0.4143746573},
    {"heun", DRAG_DEFAULT, 0, 0.01568394931, 0.4143746573},
    {"verlet", DRAG_DEFAULT, 0, 0.01168243454, 0.4206324811},
    {"implicit-midpoint", DRAG_DEFAULT, 0, 0.007703029796, 0.427843137},
    {"trapezoid", DRAG_DEFAULT, 0, 0.007703029796, 0.427843137},
    {"rk4", DRAG_DEFAULT, 0, 0.01035947771, 0.4236153845},
    {"euler", DRAG_DEFAULT, 0.25, 0.04680327285, 5.220876392},
    {"symplectic-euler", DRAG_EXPLICIT, 0.25, 0.003172313154, 0.1192053318},
    {"backward-euler", DRAG_DEFAULT, 0.25, -4.733909478e-05, 0.00296867486},
};

static double digits9(double value)
{
    return 1e-9 * fabs(value);
}

TEST(test_spring_after_10_s)
{
    for (size_t i = 0; i < COUNT_OF(references); i++) {
        const struct reference *r = &references[i];
        struct system system = SPRING({"gamma", r->gamma});
        double y[2] = {system.start[0], system.start[1]};
        assert_int_equal(advance_as(method_named(r->method), r->drag, &system, 0, 0.01, 1000, y),
                         STEP_OK);
        assert_near(r->method, y[0], r->y, digits9(r->y));
        assert_near(r->method, y[1], r->v, digits9(r->v));
    }
    struct system system = SPRING({NULL, 0});
    double y[2] = {0.05, 0}, omega = sqrt(75);
    assert_int_equal(advance(method_named("exact"), &system, 0.01, 1000, y), STEP_OK);
    assert_near("exact", y[0], 0.05 * cos(10 * omega), 1e-14);
    assert_near("exact", y[1], -0.05 * omega * sin(10 * omega), 1e-13);
}

/* One step of each drag variant against its formula, with linear and quadratic drag. */
static double flow_of(const struct oscillator *oscillator, double v, double h)
{
    const struct drag_flow flow = oscillator_drag_flow(oscillator, h);
    return drag_flow_apply(&flow, v);
}

TEST(test_drag_variants_by_formula)
{
    struct system system = SPRING({"gamma", 0.8}, {"C", 3}, {"area", 0.2});
    const struct oscillator *o = &system.oscillator;
    const double W = o->stiffness, G = o->damping, C = o->quadratic, h = 0.03, q = 0.04, v = -0.7;
    assert_above("drag matters", C, 1);

    double y[2] = {q, v};
    assert_int_equal(
        advance_as(method_named("symplectic-euler"), DRAG_EXPLICIT, &system, 0, h, 1, y), STEP_OK);
    double q1 = q + h * v;
    assert_near("symplectic-euler explicit q", y[0], q1, 1e-16);
    assert_near("symplectic-euler explicit v", y[1], v + h * (-W * q1 - G * v - C * fabs(v) * v),
                1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(
        advance_as(method_named("symplectic-euler"), DRAG_IMPLICIT, &system, 0, h, 1, y), STEP_OK);
    assert_near("symplectic-euler implicit v", y[1],
                v + h * (-W * q1 - G * y[1] - C * fabs(y[1]) * y[1]), 1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(
        advance_as(method_named("symplectic-euler-kick"), DRAG_IMPLICIT, &system, 0, h, 1, y),
        STEP_OK);
    assert_near("symplectic-euler-kick implicit v", y[1],
                v + h * (-W * q - G * y[1] - C * fabs(y[1]) * y[1]), 1e-15);
    assert_near("symplectic-euler-kick implicit q", y[0], q + h * y[1], 1e-16);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(advance_as(method_named("verlet"), DRAG_EXPLICIT, &system, 0, h, 1, y),
                     STEP_OK);
    double half = v + h / 2 * (-W * q - G * v - C * fabs(v) * v), q2 = q + h * half;
    assert_near("verlet explicit q", y[0], q2, 1e-16);
    assert_near("verlet explicit v", y[1],
                half + h / 2 * (-W * q2 - G * half - C * fabs(half) * half), 1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(advance_as(method_named("verlet"), DRAG_IMPLICIT, &system, 0, h, 1, y),
                     STEP_OK);
    assert_near("verlet implicit q", y[0], q2, 1e-16);
    assert_near("verlet implicit v", y[1],
                half + h / 2 * (-W * q2 - G * y[1] - C * fabs(y[1]) * y[1]), 1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(advance_as(method_named("verlet"), DRAG_EXACT, &system, 0, h, 1, y), STEP_OK);
    double u = flow_of(o, v, h / 2);
    half = u - h / 2 * W * q;
    q2 = q + h * half;
    assert_near("verlet exact q", y[0], q2, 1e-16);
    assert_near("verlet exact v", y[1], flow_of(o, half - h / 2 * W * q2, h / 2), 1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(advance_as(method_named("position-verlet"), DRAG_EXACT, &system, 0, h, 1, y),
                     STEP_OK);
    q2 = q + h / 2 * u;
    u -= h * W * q2;
    assert_near("position-verlet exact q", y[0], q2 + h / 2 * u, 1e-16);
    assert_near("position-verlet exact v", y[1], flow_of(o, u, h / 2), 1e-15);

    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(
        advance_as(method_named("position-verlet"), DRAG_IMPLICIT, &system, 0, h, 1, y), STEP_OK);
    q2 = q + h / 2 * v;
    double mid = (v + y[1]) / 2;
    assert_near("position-verlet implicit v", y[1],
                v + h * (-W * q2 - G * mid - C * fabs(mid) * mid), 1e-15);
    assert_near("position-verlet implicit q", y[0], q2 + h / 2 * y[1], 1e-16);

    struct system linear = SPRING({"gamma", 0.8});
    memcpy(y, (double[]){q, v}, sizeof y);
    assert_int_equal(advance_as(method_named("symplectic-euler"), DRAG_EXACT, &linear, 0, h, 1, y),
                     STEP_OK);
    double e = exp(-G * h);
    assert_near("symplectic-euler exact v", y[1], v * e - W * q1 * (1 - e) / G, 1e-15);
}

/* The implicit equations hold for what the closed forms return, with every term of the oscillator
 * at once. */
TEST(test_implicit_equations)
{
    struct system system =
        SPRING({"gamma", 0.8}, {"C", 3}, {"area", 0.2}, {"g", 9.81}, {"F0", 0.3}, {"omega", 5});
    const double h = 0.07, t = 1.3, y0[2] = {0.04, -0.7};
    double f0[2], f[2], y[2];
    system_derivative(&system, t, y0, f0);

    memcpy(y, y0, sizeof y);
    assert_int_equal(advance_as(method_named("backward-euler"), DRAG_DEFAULT, &system, t, h, 1, y),
                     STEP_OK);
    system_derivative(&system, t + h, y, f);
    for (int i = 0; i < 2; i++)
        assert_near("backward-euler", y[i], y0[i] + h * f[i], 1e-15);

    memcpy(y, y0, sizeof y);
    assert_int_equal(
        advance_as(method_named("implicit-midpoint"), DRAG_DEFAULT, &system, t, h, 1, y), STEP_OK);
    system_derivative(&system, t + h / 2, (double[]){(y0[0] + y[0]) / 2, (y0[1] + y[1]) / 2}, f);
    for (int i = 0; i < 2; i++)
        assert_near("implicit-midpoint", y[i], y0[i] + h * f[i], 1e-15);

    memcpy(y, y0, sizeof y);
    assert_int_equal(advance_as(method_named("trapezoid"), DRAG_DEFAULT, &system, t, h, 1, y),
                     STEP_OK);
    system_derivative(&system, t + h, y, f);
    for (int i = 0; i < 2; i++)
        assert_near("trapezoid", y[i], y0[i] + h / 2 * (f0[i] + f[i]), 1e-15);
}

/* The closed form and Newton's iteration are two ways to the same root. */
TEST(test_newton_agrees_with_closed_form)
{
    static const char *const names[] = {"backward-euler", "implicit-midpoint", "trapezoid"};
    struct system closed = SPRING({"gamma", 0.8}, {"C", 3}, {"area", 0.2}, {"F0", 0.3}),
                  iterated = closed;
    iterated.oscillator.whole = false;
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (double h = 1e-3; h < 100; h *= 7) {
            double a[2] = {0.04, -0.7}, b[2] = {0.04, -0.7};
            assert_int_equal(advance(method_named(names[i]), &closed, h, 1, a), STEP_OK);
            assert_int_equal(advance(method_named(names[i]), &iterated, h, 1, b), STEP_OK);
            assert_below(names[i], distance(&closed, a, b), 1e-13 * (1 + h));
        }
}

/* k = 1e300: backward Euler goes to rest at once, it does not overflow to NaN. */
TEST(test_extreme_stiffness)
{
    struct system system = SPRING({"k", 1e300}, {"gamma", 0.8}, {"C", 3}, {"area", 0.2});
    double y[2] = {0.05, 0};
    assert_int_equal(advance(method_named("backward-euler"), &system, 0.01, 2, y), STEP_OK);
    assert_below("position", fabs(y[0]), 1e-15);
    double ring[2] = {0.05, 0};
    assert_int_equal(advance(method_named("implicit-midpoint"), &system, 0.01, 1, ring), STEP_OK);
    assert_near("implicit midpoint rings", ring[0], -0.05, 1e-12);
    /* omega^2 h^2 overflows: a failure, not a spring that stands still */
    double far[2] = {0.05, 0};
    assert_int_equal(advance(method_named("backward-euler"), &system, 1e5, 1, far), STEP_NONFINITE);
}

static int gsl_force(double t, const double y[], double dydt[], void *params)
{
    system_derivative((const struct system *)params, t, y, dydt);
    return GSL_SUCCESS;
}

/* GSL's RK4 answers with two half steps (the whole one is for its error estimate). */
TEST(test_rk4_agrees_with_gsl)
{
    const int n = 1000;
    const double h = 0.02;
    struct system system = SPRING({"gamma", 0.3}, {"C", 1}, {"F0", 0.2});
    gsl_odeiv2_system ode = {gsl_force, NULL, 2, &system};
    gsl_odeiv2_step *gsl = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk4, 2);
    assert_non_null(gsl);
    double theirs[2] = {0.05, 0.1}, ours[2] = {0.05, 0.1}, error[2];
    for (int i = 0; i < n; i++)
        assert_int_equal(gsl_odeiv2_step_apply(gsl, i * h, h, theirs, error, NULL, NULL, &ode),
                         GSL_SUCCESS);
    gsl_odeiv2_step_free(gsl);
    assert_int_equal(advance(method_named("rk4"), &system, h / 2, 2 * n, ours), STEP_OK);
    assert_below("rk4 - GSL's", distance(&system, ours, theirs), 4 * DBL_EPSILON * n);
    assert_above("and it moved", distance(&system, ours, (double[]){0.05, 0.1}), 0.1);
}

RUN_TESTS(NULL, NULL)
