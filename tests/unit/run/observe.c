/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Observables against formulas written out by hand, and names in expressions. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/run.h>
#include <hooke/scene/formula.h>
#include "unit/run/fixture.h"

#include <malloc.h>
#include <stdlib.h>

static double now(const struct run *run, const char *name)
{
    return run_observable(run, observable_named(name));
}

TEST(test_formulas)
{
    struct scene scene = spring();
    double m = 0.25, k = 16, gamma = 0.3, C = 2, rho = 1.2, area = 0.01, g = 9.81, F0 = 0.5,
           omega = 5, phase = 0.4;
    set(&scene, "m", m);
    set(&scene, "k", k);
    set(&scene, "gamma", gamma);
    set(&scene, "C", C);
    set(&scene, "rho", rho);
    set(&scene, "area", area);
    set(&scene, "g", g);
    set(&scene, "F0", F0);
    set(&scene, "omega", omega);
    set(&scene, "phase", phase);
    set(&scene, "v0", -0.7);
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 1);
    double energy0 = now(run, "energy");
    go_to(run, 0.321);
    double t = run->t, y = run->y[0], v = run->y[1];
    double drag = -m * gamma * v - C * rho * area * fabs(v) * v,
           drive = F0 * cos(omega * t + phase);
    assert_bits(now(run, "t"), 0.321);
    assert_bits(now(run, "y"), y);
    assert_bits(now(run, "v"), v);
    assert_close(now(run, "a"), (-k * y + drag + drive - m * g) / m, 1e-12);
    assert_close(now(run, "kinetic"), 0.5 * m * v * v, 1e-15);
    assert_close(now(run, "potential"), 0.5 * k * y * y + m * g * y, 1e-14);
    assert_close(now(run, "energy"), 0.5 * m * v * v + 0.5 * k * y * y + m * g * y, 1e-14);
    assert_close(now(run, "power"), (drag + drive) * v, 1e-14);
    assert_close(now(run, "momentum"), m * v, 1e-16);
    assert_close(now(run, "amplitude"), hypot(y + m * g / k, v / 8), 1e-14);
    assert_close(now(run, "energy-error"),
                 (now(run, "energy") - energy0 - now(run, "work")) / energy0, 1e-15);
    assert_close(now(run, "energy-error"), 0, 1e-10);
    assert_true(now(run, "dissipated") > 0);
    /* quadratic drag: no closed form */
    assert_true(isnan(now(run, "exact")) && isnan(now(run, "error")));

    /* A column is the same function of each row. */
    size_t rows = trace_count(run->trace);
    double *column = calloc(rows, sizeof *column);
    assert_non_null(column);
    struct error error;
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct observable *o = observable_at(i);
        if (!run_column(run, o, column, &error)) {
            assert_true(isnan(run_observable(run, o)));
            assert_non_null(strstr(error.text, o->row.name));
        } else if (!(o->needs & NEED_WORK)) {
            assert_bits(column[rows - 1], run_observable(run, o));
        } else {
            assert_close(column[rows - 1], run_observable(run, o), 1e-15);
        }
        assert_string_equal(
            o->row.unit, o->quantity == QUANTITY_OTHER ? o->row.unit : quantity_unit(o->quantity));
    }
    free(column);
    run_destroy(run);
}

/* Symplectic Euler with steps h on the undamped oscillator, x = w h: a step turns by the angle
 * 2 asin(x/2), so that the frequency is too high by x^2/24, and v^2 + w^2 q^2 - h w^2 q v is
 * constant. */
TEST(test_errors_of_symplectic_euler)
{
    struct scene scene = spring();
    double omega0 = sqrt(75), dt = 2 * M_PI / omega0 / 400, x = omega0 * dt, span = 4000 * dt;
    struct run *run = start(&scene, "symplectic-euler", (struct run_settings){.dt = dt}, span);
    go_to(run, span);
    struct run_errors errors;
    run_errors(run, &errors);
    /* the exact angle of a step is 2 asin(x/2) */
    double phase = omega0 * span * (2 / x * asin(x / 2) - 1);
    assert_close(errors.phase, phase, 0.05 * fabs(phase));
    assert_close(now(run, "phase-error"), errors.phase, 1e-12);
    assert_true(fabs(errors.amplitude) < x);
    assert_true(errors.max >= errors.end && errors.max < 2 * x + fabs(phase));
    assert_true(errors.floor > 0 && errors.floor < 1e-12);
    double *exact = calloc(trace_count(run->trace), sizeof *exact),
           *error = calloc(trace_count(run->trace), sizeof *error);
    struct error failure;
    assert_true(run_column(run, observable_named("exact"), exact, &failure));
    assert_true(run_column(run, observable_named("error"), error, &failure));
    double max = 0;
    for (size_t i = 0; i < trace_count(run->trace); i++) {
        double t = (double)i * dt;
        assert_close(exact[i], 0.05 * cos(omega0 * t), 1e-14);
        assert_close(error[i], trace_state(run->trace, i)[0] - exact[i], 1e-17);
        max = fmax(max, fabs(error[i]));
    }
    assert_close(errors.max, max / 0.05, 1e-14);
    free(exact);
    free(error);
    run_destroy(run);
}

/* A phase error of several turns is counted, not wrapped: coarse backward Euler lags by x^2/3 of
 * its phase. */
TEST(test_phase_counts_turns)
{
    struct scene scene = spring();
    double x = 0.3, dt = x / sqrt(75);
    struct run *run =
        start(&scene, "implicit-midpoint", (struct run_settings){.dt = dt}, 4000 * dt);
    go_to(run, 4000 * dt);
    struct run_errors errors;
    run_errors(run, &errors);
    double wanted = 4000 * (2 * atan(x / 2) - x); /* a step turns by the angle 2 atan(x/2) */
    assert_true(wanted < -2 * M_PI);
    assert_close(errors.phase, wanted, 1e-8);
    assert_close(now(run, "phase-error"), remainder(wanted, 2 * M_PI), 1e-8);
    assert_close(errors.amplitude, 0, 1e-12);
    run_destroy(run);
}

TEST(test_undefined_says_why)
{
    struct scene scene = spring();
    set(&scene, "k", -1);
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 1);
    double out[2];
    struct error error;
    assert_false(run_column(run, observable_named("amplitude"), out, &error));
    assert_non_null(strstr(error.text, "k > 0"));
    struct run_errors errors;
    run_errors(run, &errors);
    assert_true(isnan(errors.phase) && isnan(errors.amplitude) && errors.max == 0);
    run_destroy(run);
    scene = spring();
    set(&scene, "C", 1);
    run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 1);
    assert_false(run_column(run, observable_named("error"), out, &error));
    assert_non_null(strstr(error.text, "closed-form"));
    run_errors(run, &errors);
    assert_true(isnan(errors.max) && isnan(errors.end) && isnan(errors.floor));
    run_destroy(run);
}

TEST(test_scope)
{
    struct scene scene = spring();
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 1);
    go_to(run, 0.1);
    struct expr_scope scope;
    struct arena arena = {0};
    struct error error;
    size_t used;
    assert_true(run_scope(run, &scope));
    const struct expr *expr =
        expr_compile(TEXT("2*y + v - t + energy_error*0 + kinetic"), &scope, &arena, &used, &error);
    assert_non_null(expr);
    double y = run->y[0], v = run->y[1];
    assert_close(expr_value(expr, &scope), 2 * y + v - 0.1 + 0.1 * v * v, 1e-15);
    assert_null(expr_compile(TEXT("enrgy"), &scope, &arena, &used, &error));
    assert_non_null(strstr(error.hint, "energy"));
    int slot;
    for (size_t i = 0; i < observable_catalog.count; i++) {
        assert_true(
            scope.find(scope.context, text_of(catalog_row(&observable_catalog, i)->name), &slot));
        assert_true(slot >= 0 && slot < run_scope_slots(run));
    }
    assert_false(scope.find(scope.context, TEXT("gamma"), &slot)); /* parameters are the caller's */
    arena_reset(&arena);
    run_destroy(run);
}

/* Each of these kept a table of the exact solution. */
TEST(test_stopped_columns_hold_nothing)
{
    struct scene scene = spring();
    struct cancel cancel = {0};
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 1);
    go_to(run, 0.3);
    run->cancel = &cancel;
    atomic_store(&cancel.requested, 1);
    double *column = calloc(trace_count(run->trace), sizeof *column);
    assert_non_null(column);
    const size_t before = mallinfo2().uordblks;
    for (int i = 0; i < 50; i++) {
        struct run_errors errors;
        struct error error = {0};
        run_errors(run, &errors);
        assert_true(isnan(errors.end));
        assert_false(run_column(run, observable_named("error"), column, &error));
        assert_int_equal(error.code, ERROR_CANCELLED);
    }
    assert_int_equal(mallinfo2().uordblks, before);
    free(column);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
