/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energy ledger against closed forms and against the order of the method. */
#include "run/private.h"
#include "unit/run/fixture.h"

static struct ledger ledger_of(const struct scene *scene, const char *method, double dt,
                               double span)
{
    struct run *run = start(scene, method, (struct run_settings){.dt = dt}, span);
    struct ledger ledger;
    go_to(run, scene->value[param_index("t0")] + span);
    run_ledger(run, &ledger);
    run_destroy(run);
    return ledger;
}

/* With x = omega dt, each step of forward Euler multiplies the energy by 1 + x^2, each step of
 * backward Euler divides it by that; implicit midpoint conserves it, and verlet's oscillates by
 * x^2/4. */
TEST(test_undamped_closed_forms)
{
    struct scene scene = spring();
    double dt = 0.01, x2 = 75 * dt * dt;
    static const int counts[] = {1, 10, 1000};
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        int n = counts[i];
        struct ledger ledger = ledger_of(&scene, "euler", dt, n * dt);
        double growth = expm1(n * log1p(x2));
        assert_close(ledger.error, growth, 1e-12 * (1 + growth));
        assert_close(ledger.error_max, growth, 1e-12 * (1 + growth));
        assert_true(ledger.work == 0);
        assert_close(ledger.initial, 0.5 * 15 * 0.05 * 0.05, 1e-17);
        assert_close(ledger_of(&scene, "backward-euler", dt, n * dt).error, expm1(-n * log1p(x2)),
                     1e-12);
    }
    assert_close(ledger_of(&scene, "implicit-midpoint", dt, 100).error_max, 0, 1e-11);
    double max = ledger_of(&scene, "verlet", dt, 100).error_max;
    assert_close(max, x2 / 4, 0.05 * x2 / 4); /* bounded oscillation by x^2/4 */
}

/* With drag and drive the ledger shows the method's error only: it falls with the method's order.
 */
TEST(test_balance_has_the_order_of_the_method)
{
    static const struct {
        const char *method;
        double dt, order, max; /* slope at least, error at dt/2 at most */
        const char *param;
        double value;
    } row[] = {
        {"euler", 1e-3, 0.9, 0.1, "gamma", 0.4},
        {"heun", 1e-2, 1.9, 2e-3, "gamma", 0.4},
        {"verlet", 1e-2, 1.9, 2e-2, "gamma", 0.4},
        {"implicit-midpoint", 1e-2, 1.9, 1e-2, "gamma", 0.4},
        {"rk4", 1e-3, 3.9, 1e-10, "gamma",
         0.4}, /* above 5 ms its dissipation of order 5 hides this */
        {"rk4", 1e-3, 3.9, 1e-9, "F0", 0.1},
        {"rk4", 1e-3, 2.9, 1e-9, "C", 4}, /* |v| v is only once differentiable */
        {"dopri5", 1e-2, 4.8, 1e-7, "gamma", 0.4},
    };
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        struct scene scene = spring();
        set(&scene, row[i].param, row[i].value);
        double coarse = ledger_of(&scene, row[i].method, row[i].dt, 5).error_max;
        double fine = ledger_of(&scene, row[i].method, row[i].dt / 2, 5).error_max;
        double order = log2(coarse / fine);
        if (!(order > row[i].order) || !(fine < row[i].max))
            fail_msg("%s with %s: order %.3f, error %.3g", row[i].method, row[i].param, order,
                     fine);
    }
}

/* Forward Euler gains energy that no force gave: positive; backward Euler loses: negative. */
TEST(test_sign)
{
    struct scene scene = spring();
    set(&scene, "gamma", 0.4);
    assert_true(ledger_of(&scene, "euler", 0.01, 5).error > 0.1);
    assert_true(ledger_of(&scene, "backward-euler", 0.01, 5).error < -0.1);
}

/* An accurate run: the work is what the exact energies say, drag and drive apart. */
TEST(test_work_is_right)
{
    struct scene scene = spring();
    set(&scene, "gamma", 0.4);
    set(&scene, "F0", 0.1);
    set(&scene, "omega", 8.5);
    struct run *run = start(&scene, "dopri5", (struct run_settings){.dt = 1e-3}, 20);
    go_to(run, 20);
    struct ledger ledger;
    run_ledger(run, &ledger);
    assert_close(ledger.error_max, 0, 5e-11);
    assert_close(ledger.final - ledger.initial, ledger.work, 1e-12);
    assert_true(ledger.work > 0);
    /* dissipated = integral of m gamma v^2, here by Simpson over the rows */
    double sum = 0;
    for (size_t i = 0; i + 2 < trace_count(run->trace); i += 2) {
        double v[3];
        for (size_t j = 0; j < 3; j++)
            v[j] = trace_state(run->trace, i + j)[1];
        sum += 1e-3 / 3 * 0.2 * 0.4 * (v[0] * v[0] + 4 * v[1] * v[1] + v[2] * v[2]);
    }
    double dissipated = run_observable(run, observable_named("dissipated"));
    assert_close(dissipated, sum, 1e-10);
    assert_close(run_observable(run, observable_named("work")), ledger.work, 1e-16);
    assert_close(run_observable(run, observable_named("energy-error")), ledger.error, 1e-16);
    run_destroy(run);
}

/* y'' = 1000 (1 - y^2) y' - y over h, in steps that resolve its fastest rate. */
static void creep_and_jump(double h, double *y)
{
    const int steps = 16 + (int)(fabs(h) * 1000 * 4 * 8);
    const double part = h / steps;
    for (int i = 0; i < steps; i++) {
        double slope[4][2], at[2] = {y[0], y[1]};
        for (int s = 0; s < 4; s++) {
            slope[s][0] = at[1];
            slope[s][1] = 1000 * (1 - at[0] * at[0]) * at[1] - at[0];
            for (int k = 0; k < 2 && s < 3; k++)
                at[k] = y[k] + (s < 2 ? part / 2 : part) * slope[s][k];
        }
        for (int k = 0; k < 2; k++)
            y[k] += part / 6 * (slope[0][k] + 2 * slope[1][k] + 2 * slope[2][k] + slope[3][k]);
    }
}

/*
 * Where stiff van der Pol jumps, its energy rises to 4.4e5 times that at the start, and a tolerance
 * of 1e-6 leaves a tenth of the latter. That is the solver's: what its steps differ by, in energy,
 * from the solution from where each began adds up to as much, and no quadrature of the work is
 * involved in it. The balance is no more than that.
 */
TEST(test_a_jump_is_the_solvers)
{
    static const struct {
        const char *method;
        double tol;
    } row[] = {{"dopri5", 1e-6}, {"radau5", 1e-6}, {"radau5", 1e-8}, {"rodas5p", 1e-6}};
    struct scene scene;
    scene_init(&scene, preset_by_name(TEXT("stiff-vanderpol")));
    for (size_t r = 0; r < COUNT_OF(row); r++) {
        struct run *run =
            start(&scene, row[r].method, (struct run_settings){.tol = row[r].tol, .dt = 1e-4}, 808);
        go_to(run, 808);
        double own = 0, own_most = 0;
        const struct trace *trace = run->trace;
        for (size_t i = 0; i + 1 < trace_count(trace); i++) {
            const double *from = trace_state(trace, i), *to = trace_state(trace, i + 1);
            const double h = trace_time(trace, i + 1) - trace_time(trace, i);
            double y[2] = {from[0], from[1]};
            if (trace_time(trace, i) < 806.5) /* it creeps */
                continue;
            assert_int_equal(trace_step(trace, i + 1), trace_step(trace, i) + 1);
            creep_and_jump(h, y);
            own += (to[0] * to[0] + to[1] * to[1] - y[0] * y[0] - y[1] * y[1]) / 2;
            own_most = fmax(own_most, fabs(own));
        }
        struct ledger ledger;
        run_ledger(run, &ledger);
        const double peak = run_energy_peak(run, &ledger),
                     missing = ledger.error_max * ledger.initial;
        /* Van der Pol 1926: the jump goes from 1 to -2 at a speed of up to 1000 (2/3 + 2/3) =
         * 4000/3. */
        assert_close(peak / (4000. / 3 * (4000. / 3) / 2 / ledger.initial), 1, 0.01);
        if (!(missing <= 2 * own_most) || !(missing < 10 * row[r].tol * peak * ledger.initial))
            fail_msg("%s, tol = %g: %g J are missing, %g J by its steps alone, the peak is %g J",
                     row[r].method, row[r].tol, missing, own_most, peak * ledger.initial);
        run_destroy(run);
    }
}

/* A force whose power depends on the position too: P = y^3 v has the work (y^4 - y0^4)/4. */
static double cubic_power(const double *c, double t, const double *y)
{
    (void)c;
    (void)t;
    return y[0] * y[0] * y[0] * y[1];
}

TEST(test_power_of_position)
{
    struct scene scene = spring();
    set(&scene, "gamma", 0.4);
    struct run *run = start(&scene, "dopri5", (struct run_settings){.dt = 1e-2}, HUGE_VAL);
    struct term_row cubic = *run->system.term[1].row;
    cubic.power = cubic_power;
    run->private_state->epoch[0].system.term[1].row = &cubic;
    go_steps(run, 77);
    assert_close(run_observable(run, observable_named("work")),
                 (pow(run->y[0], 4) - pow(0.05, 4)) / 4, 1e-14);
    run_destroy(run);
}

/* The value at the present state is carried along; it is the one that a pass over all rows gives,
 * decimated or not. */
TEST(test_running_balance)
{
    struct scene scene = spring();
    set(&scene, "gamma", 0.1);
    struct run *run =
        start(&scene, "rk4", (struct run_settings){.dt = 1e-3, .memory = 4000 * 24}, HUGE_VAL);
    for (int i = 0; i < 60; i++) {
        struct ledger ledger;
        go_steps(run, 317);
        if (i % 13 == 7)
            run_back(run, 100);
        run_ledger(run, &ledger);
        assert_close(run_observable(run, observable_named("energy-error")), ledger.error, 1e-15);
        assert_true(ledger.error_max < 1e-8); /* rows up to 16 steps apart, 725 steps a period */
    }
    assert_true(trace_decimated(run->trace));
    run_destroy(run);
}

/* Squares of 1e-200 and 1e200 leave the range of double, ratios of energies do not. */
TEST(test_extreme_amplitudes)
{
    static const double sizes[] = {1e-310, 1e-250, 1e-160, 1, 1e140};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        struct scene scene = spring();
        set(&scene, "gamma", 0.4);
        set(&scene, "y0", sizes[i]);
        struct ledger euler = ledger_of(&scene, "euler", 0.01, 5),
                      rk4 = ledger_of(&scene, "rk4", 0.01, 5);
        struct scene same = spring();
        set(&same, "gamma", 0.4);
        struct ledger wanted = ledger_of(&same, "euler", 0.01, 5);
        assert_close(euler.error, wanted.error,
                     1e-9 * fabs(wanted.error) + (sizes[i] < 1e-300 ? 1e-2 : 0));
        assert_true(rk4.error_max < (sizes[i] < 1e-300 ? 1e-6 : 1e-4));
    }
    /* Changing the scene gives the scaling up; what was carried along starts again. */
    struct scene large = spring();
    set(&large, "gamma", 0.4);
    set(&large, "y0", 1e140);
    struct run *run = start(&large, "rk4", (struct run_settings){.dt = 0.01}, 2);
    struct ledger now;
    struct error error;
    go_to(run, 1);
    assert_close(run_observable(run, observable_named("energy-error")), 0, 1e-4);
    set(&large, "gamma", 0.5);
    assert_true(run_rebind(run, &large, &error));
    go_to(run, 2);
    run_ledger(run, &now);
    assert_close(now.error, 0, 1e-4);
    assert_close(run_observable(run, observable_named("energy-error")), now.error, 1e-15);
    run_destroy(run);

    /* From rest at the equilibrium E0 is 0: the largest energy is the unit. */
    struct scene scene = spring();
    set(&scene, "y0", 0);
    set(&scene, "F0", 0.1);
    struct ledger ledger = ledger_of(&scene, "rk4", 0.001, 5);
    assert_true(ledger.initial == 0 && ledger.error_max < 1e-9 && ledger.error_max > 0);
    set(&scene, "F0", 0);
    assert_true(isnan(ledger_of(&scene, "rk4", 0.001, 1).error));
}

/* A change of the scene that is taken back between two recorded rows leaves the balance of that
 * step. */
TEST(test_change_taken_back)
{
    static const enum record_rule rules[] = {RECORD_ALL, RECORD_EVERY};
    for (size_t i = 0; i < COUNT_OF(rules); i++) {
        struct scene scene = spring();
        set(&scene, "gamma", 0.5);
        struct run *run =
            start(&scene, "rk4",
                  (struct run_settings){.dt = 1e-3, .record = {.rule = rules[i], .every = 20}}, 1);
        struct ledger now;
        struct error error;
        go_steps(run, 438);
        set(&scene, "k", 30);
        assert_true(run_rebind(run, &scene, &error));
        run_unbind(run);
        go_steps(run, 12);
        assert_true(run_rebind(run, &scene, &error));
        go_steps(run, 300);
        run_ledger(run, &now);
        assert_true(now.error_max < 1e-7);
        run_destroy(run);
    }
}

RUN_TESTS(NULL, NULL)
