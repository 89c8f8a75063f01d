/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Binding: which terms are there, natural scales, guards; and what a bound system computes. */
#include <hooke/base/catalog.h>
#include "unit/scene/testing.h"

#include <math.h>
#include <string.h>

TEST(test_only_what_is_needed)
{
    struct system spring = BOUND({"k", 15});
    assert_int_equal(spring.terms, 1);
    assert_string_equal(spring.term[0].row->row.name, "spring");
    assert_true(spring.linear && spring.autonomous && spring.conservative && !spring.velocity &&
                spring.oscillator.whole);
    assert_true(spring.n == 2 && spring.order == 2 && spring.start[0] == 0.05 &&
                spring.start[1] == 0 && spring.mass == 0.2);

    struct system damped = BOUND({"gamma", 0.25}, {"g", 9.81});
    assert_int_equal(damped.terms, 3);
    assert_true(damped.linear && damped.autonomous && !damped.conservative && damped.velocity);

    struct system drag = BOUND({"C", 0.5});
    assert_true(!drag.linear && drag.velocity && !drag.conservative);

    struct system driven = BOUND({"F0", 1}, {"k", 0});
    assert_int_equal(driven.terms, 1);
    assert_true(driven.linear && !driven.autonomous && !driven.velocity && !driven.conservative);

    struct system duffing = BOUND({"k3", 2});
    assert_true(!duffing.linear && duffing.conservative && !duffing.velocity &&
                !duffing.oscillator.whole && duffing.oscillator.drag_whole);
    struct system vanderpol = BOUND({"mu", 2});
    assert_true(!vanderpol.conservative && vanderpol.velocity && !vanderpol.oscillator.whole &&
                !vanderpol.oscillator.drag_whole);
    assert_true(drag.oscillator.whole && drag.oscillator.drag_whole);

    struct system free = BOUND({"k", 0});
    assert_int_equal(free.terms, 0);
    assert_true(free.linear && free.conservative && free.autonomous);
}

TEST(test_spring_is_one_multiplication)
{
    /* Kernels rely on it: the coefficient is k/m, rounded once, and the acceleration is -(k/m) y,
     * rounded once. */
    uint64_t seed = 4;
    for (int i = 0; i < 1000; i++) {
        double k = random_between(&seed, 0.1, 100), m = random_between(&seed, 0.01, 2),
               gamma = random_between(&seed, 0, 3);
        struct system spring = BOUND({"k", k}, {"m", m}),
                      damped = BOUND({"k", k}, {"m", m}, {"gamma", gamma});
        double y[2] = {random_between(&seed, -1, 1), random_between(&seed, -1, 1)}, a[1], dydt[2];
        double omega2 = k / m;
        system_acceleration(&spring, 0, y, a);
        assert_true(a[0] == -omega2 * y[0] && spring.oscillator.stiffness == omega2);
        system_derivative(&damped, 0, y, dydt);
        assert_true(dydt[0] == y[1] && dydt[1] == -omega2 * y[0] - gamma * y[1]);
    }
}

TEST(test_parts_add_up)
{
    struct system all = BOUND({"gamma", 0.3}, {"C", 20}, {"g", 9.81}, {"F0", 2}, {"phase", 0.5},
                              {"k3", 40}, {"mu", 0.2}, {"friction", 0.1});
    assert_int_equal(all.terms, term_catalog.count);
    uint64_t seed = 5;
    for (int i = 0; i < 100; i++) {
        double t = random_between(&seed, 0, 9),
               y[2] = {random_between(&seed, -1, 1), random_between(&seed, -1, 1)};
        double whole[1], force[1], drag[1], dydt[2], jac[4];
        system_acceleration(&all, t, y, whole);
        system_force(&all, t, y, force);
        system_drag(&all, t, y, drag);
        assert_true(fabs(whole[0] - force[0] - drag[0]) < 1e-13 && fabs(drag[0]) > 1e-6);
        double still[2] = {y[0], 0}, rest[1];
        system_drag(&all, t, still, rest);
        assert_true(rest[0] == 0);
        system_derivative(&all, t, y, dydt);
        assert_true(dydt[0] == y[1] && dydt[1] == whole[0]);

        system_jacobian(&all, t, y, jac);
        assert_true(jac[0] == 0 && jac[1] == 1);
        for (int j = 0; j < 2; j++) {
            double up[2] = {y[0], y[1]}, down[2] = {y[0], y[1]}, a[1], b[1], h = 1e-5;
            up[j] += h;
            down[j] -= h;
            system_acceleration(&all, t, up, a);
            system_acceleration(&all, t, down, b);
            assert_true(fabs(jac[2 + j] - (a[0] - b[0]) / (2 * h)) < 1e-4 * (1 + fabs(jac[2 + j])));
        }

        /* dE/dt = P: the energy's slope along the motion is the power of what has no potential. */
        double later[2], earlier[2], h = 1e-6;
        for (int j = 0; j < 2; j++) {
            later[j] = y[j] + h * dydt[j];
            earlier[j] = y[j] - h * dydt[j];
        }
        double slope = (system_kinetic(&all, later) + system_potential(&all, later) -
                        system_kinetic(&all, earlier) - system_potential(&all, earlier)) /
                       (2 * h);
        double power = system_power(&all, t, y);
        assert_true(fabs(slope - power) < 1e-7 * (1 + fabs(power)));
        double drive = 2 * cos(8 * t + 0.5) * y[1];
        assert_true(fabs(system_dissipation(&all, t, y) - (power - drive)) <
                    1e-14 * (1 + fabs(power)));
        /* 0.3 1/s damp more than 0.2 drive */
        assert_true(system_dissipation(&all, t, y) < 0 && fabs(y[0]) < 1);
    }
}

/* ---- first order: a row made here, dy/dt = -c y for two variables ---- */

static void decay_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    for (int i = 0; i < 2; i++)
        a[i] -= c[0] * y[i];
}

static void decay_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    (void)y;
    jac[0] -= c[0];
    jac[3] -= c[0];
}

TEST(test_first_order)
{
    const struct term_row row = {.row = {"decay", "", "", "", NULL},
                                 .flags = TERM_LINEAR,
                                 .add = decay_add,
                                 .jacobian = decay_jacobian};
    struct system system = {.n = 2, .order = 1, .terms = 1, .term = {{.row = &row, .c = {3}}}};
    double y[2] = {2, -1}, dydt[2], jac[4];
    system_derivative(&system, 0, y, dydt);
    assert_true(dydt[0] == -6 && dydt[1] == 3);
    system_jacobian(&system, 0, y, jac);
    assert_true(jac[0] == -3 && jac[1] == 0 && jac[2] == 0 && jac[3] == -3);
    assert_true(system_kinetic(&system, y) == 0);
    assert_false(system_has_exact(&system));
}

TEST(test_variables)
{
    const struct system system = BOUND({"k", 1});
    assert_string_equal(system_variable(&system, 0).name, "y");
    assert_int_equal(system_variable(&system, 0).quantity, QUANTITY_LENGTH);
    assert_string_equal(system_variable(&system, 1).name, "v");
    assert_int_equal(system_variable(&system, 1).quantity, QUANTITY_VELOCITY);
}

static void expect_scale(struct system system, double length, double speed)
{
    if (!(fabs(system.scale[0] / length - 1) < 1e-12 && fabs(system.scale[1] / speed - 1) < 1e-12))
        fail_msg("scale %.17g, %.17g; wanted %.17g, %.17g", system.scale[0], system.scale[1],
                 length, speed);
}

TEST(test_scale)
{
    double omega = sqrt(75);
    expect_scale(BOUND({"y0", -0.05}), 0.05, 0.05 * omega);
    expect_scale(BOUND({"y0", 0.01}, {"v0", -2}), 2 / omega, 2);
    expect_scale(BOUND({"y0", 0}, {"g", 9.81}), 9.81 / 75, 9.81 / omega);
    expect_scale(BOUND({"k", -15}), 0.05, 0.05 * omega);
    expect_scale(BOUND({"k", 0}, {"v0", 3}), 3, 3);                 /* 1 s stands in for a period */
    expect_scale(BOUND({"k", 0}, {"v0", 3}, {"gamma", 6}), 0.5, 3); /* stopping distance */
    expect_scale(BOUND({"y0", 1e-310}), 1e-290, 1e-290);            /* the floor */
    expect_scale(BOUND({"y0", 0}), 1, 1);
    expect_scale(BOUND({"y0", 0}, {"F0", 0.02}, {"omega", 0}), 0.1 / 75, 0.1 / omega);
    expect_scale(BOUND({"y0", 0}, {"F0", 0.02}, {"omega", 100}), 0.1 / (1e4 - 75), 10 / (1e4 - 75));
    expect_scale(BOUND({"y0", 0}, {"F0", 0.02}, {"omega", omega}), 0.1 / 7.5, 0.1 / 7.5 * omega);
    expect_scale(BOUND({"k", -20}, {"k3", 80}, {"y0", 0.01}), 0.5, 5); /* a well */
    expect_scale(BOUND({"k", 0}, {"k3", 0.4}, {"y0", 0.2}), 0.2, 0.04 * sqrt(2));
    /* 2 y^4/4 = v^2/2 */
    expect_scale(BOUND({"k", 0}, {"k3", 0.4}, {"y0", 0}, {"v0", 1}), 1, sqrt(2));
    expect_scale(BOUND({"mu", 0.1}, {"width", 0.5}), 1, omega); /* the limit cycle */
    expect_scale(BOUND({"mu", 750}, {"width", 0.5}), 1, 0.1);   /* creeps as k y/(m mu) */
    expect_scale(BOUND({"mu", -2}), 0.05, 0.05 * omega);
}

static void expect_refused(const char *sentence, const struct setting *settings, size_t count)
{
    struct scene scene;
    struct system system = {.n = 77};
    struct error error = {0};
    scene_init(&scene, NULL);
    for (size_t i = 0; i < count; i++)
        scene.value[param_index(settings[i].param)] = settings[i].value;
    assert_false(scene_bind(&scene, &system, &error));
    if (!strstr(error.text, sentence))
        fail_msg("'%s' does not say '%s'", error.text, sentence);
    assert_int_equal(error.code, ERROR_COMMAND);
}

#define REFUSED(sentence, ...)                                                                     \
    expect_refused(sentence, (const struct setting[]){__VA_ARGS__},                                \
                   COUNT_OF(((const struct setting[]){__VA_ARGS__})))

TEST(test_overflow_is_refused)
{
    REFUSED("k/m overflows", {"m", 1e-310});
    REFUSED("k/m overflows", {"m", 1e-310}, {"k", 1e-10}); /* finite, but with few digits */
    REFUSED("k/m overflows", {"k", 1e300}, {"m", 1e-20});
    REFUSED("the spring force overflows at y = 1e9 m", {"k", 1e300}, {"y0", 1e9});
    /* at full swing, not at the start */
    REFUSED("the spring force overflows", {"k", 1e300}, {"v0", 1e159});
    REFUSED("a coefficient of the drag term overflows", {"C", 1e300}, {"m", 1e-20}, {"k", 0});
    REFUSED("a coefficient of the drive term overflows", {"F0", 1e300}, {"m", 1e-10}, {"k", 0});
    REFUSED("the drag force overflows", {"C", 0.5}, {"v0", 1e160});
    REFUSED("the cubic force overflows at y = 1e110 m", {"k3", 1}, {"y0", 1e110});
    (void)BOUND({"k", 1e300});
    (void)BOUND({"y0", 1e300});
}

/* ---- the drag flow ---- */

/* v' = -gamma v - c |v| v by the midpoint rule with Richardson extrapolation. */
static double integrated(double gamma, double c, double v0, double h)
{
    double result[2];
    for (int k = 0; k < 2; k++) {
        int n = 20000 << k;
        double v = v0, dt = h / n;
        for (int i = 0; i < n; i++) {
            double mid = v - dt / 2 * (gamma * v + c * fabs(v) * v);
            v -= dt * (gamma * mid + c * fabs(mid) * mid);
        }
        result[k] = v;
    }
    return (4 * result[1] - result[0]) / 3;
}

static double flow_of(const struct oscillator *oscillator, double v, double h)
{
    const struct drag_flow flow = oscillator_drag_flow(oscillator, h);
    return drag_flow_apply(&flow, v);
}

TEST(test_drag_flow)
{
    static const double gammas[] = {0, 1e-12, 0.3, 5, -0.3, -4}, quadratics[] = {0, 0.2, 3},
                        times[] = {0.1, 1.5, -0.1};
    for (size_t i = 0; i < COUNT_OF(gammas); i++)
        for (size_t j = 0; j < COUNT_OF(quadratics); j++)
            for (size_t k = 0; k < COUNT_OF(times); k++)
                for (double v = -1.5; v <= 1.5; v += 0.75) {
                    struct oscillator o = {
                        .damping = gammas[i], .quadratic = quadratics[j], .whole = true};
                    double h = times[k], flow = flow_of(&o, v, h),
                           wanted = integrated(gammas[i], quadratics[j], v, h);
                    if (!(fabs(flow - wanted) <= 1e-9 * fabs(wanted)))
                        fail_msg("gamma %g c %g v %g h %g: %.17g, integrated %.17g", gammas[i],
                                 quadratics[j], v, h, flow, wanted);
                    assert_true(v == 0 ? flow == 0 : flow * v > 0);
                    double there_and_back = flow_of(&o, flow, -h);
                    assert_true(fabs(there_and_back - v) <= 1e-13 * fabs(v));
                }
    struct oscillator hard = {.damping = 1e9, .quadratic = 1e9},
                      growing = {.damping = -1e4, .quadratic = 2}, quadratic = {.quadratic = 1};
    assert_true(flow_of(&hard, 1, 1e3) == 0);
    assert_true(flow_of(&growing, -1e-3, 1) == -5e3); /* gamma/c: where growth and drag balance */
    assert_true(flow_of(&quadratic, 1e150, 1e10) == 1e-10);
    assert_true(isinf(flow_of(&quadratic, 1, -2))); /* behind the pole */
    quadratic.quadratic = 0;
    assert_true(flow_of(&quadratic, 0.1, 0.3) == 0.1);
}

RUN_TESTS(NULL, NULL)
