/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Solves without recording: the same state as a run, samples on the common grid, kernels in bulk,
 * limits. */
#include "cmocka_testing.h"

#include <string.h>

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/solving/compute/solve.h"

static struct scene scene;
static struct system spring;

static const struct method *method_named(const char *name)
{
    const struct row *row = catalog_find(&method_catalog, text_of(name));
    assert_non_null(row);
    return method_from(row);
}

static struct solver solver_for(const char *name, double dt, double tol, double span)
{
    const struct method *method = method_named(name);
    struct run_settings settings = {.dt = dt, .tol = tol};
    struct solver solver;
    struct error error = {0};
    scene_init(&scene, NULL);
    assert_true(scene_bind(&scene, &spring, &error));
    assert_true(method_applies(method, &spring, &settings.drag, &error));
    assert_true(solver_init(&solver, &spring, method, &settings, span));
    return solver;
}

/* Whole steps, a partial last one, adaptive: to the bit where a run gets. */
TEST(test_like_a_run)
{
    static const struct {
        const char *method;
        double dt, tol, span;
    } cases[] = {{"rk4", 0.01, 0, 1},
                 {"verlet", 0.01, 0, 0.995},
                 {"dopri5", 0.01, 1e-6, 1},
                 {"euler", 1, 0, 0.3}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct solver solver =
            solver_for(cases[i].method, cases[i].dt, cases[i].tol, cases[i].span);
        struct error error = {0};
        const struct run_settings settings = {
            .dt = cases[i].dt, .tol = cases[i].tol, .kernel = KERNEL_GENERAL};
        struct run *run = run_create(&scene, solver.method, &settings, cases[i].span, &error);
        const struct run_target target = {.t = cases[i].span, .steps = -1};
        assert_non_null(run);
        while (run_advance(run, &target, 0, NULL)) {
        }
        assert_int_equal(solver_run(&solver, NULL, NULL), STOP_END);
        assert_int_equal(solver.steps, run->steps);
        assert_int_equal(solver.step.cost.evals, run->cost.evals);
        assert_memory_equal(solver.y, run->y, 2 * sizeof(double));
        run_destroy(run);
        solver_free(&solver);
    }
}

/* Between steps the method itself goes to the grid times: no interpolation stands in the way of a
 * high order. */
TEST(test_samples_between_steps)
{
    static const struct {
        const char *method;
        double dt, tol, max; /* of |y - exact| / amplitude */
    } cases[] = {{"rk4", 0.0173, 0, 1e-4},
                 {"dopri5", 0.05, 0, 1e-4},
                 {"rk4", 0.25, 0, 1},
                 {"dopri5", 1, 1e-9, 1e-7}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct solver solver = solver_for(cases[i].method, cases[i].dt, cases[i].tol, 1);
        double grid[STUDY_TIMES * 2], max = 0;
        assert_int_equal(solver_run(&solver, grid, NULL), STOP_END);
        for (int k = 0; k < STUDY_TIMES; k++) {
            assert_true(isfinite(grid[2 * k]) != 0);
            max = fmax(max, fabs(grid[2 * k] / 0.05 - cos(sqrt(75) * k / (STUDY_TIMES - 1))));
        }
        if (!(max < cases[i].max)) {
            print_error("%s: off by %g\n", cases[i].method, max);
            fail();
        }
        assert_true(grid[2 * (STUDY_TIMES - 1)] == solver.y[0]);
        solver_free(&solver);
    }
    /* Looking does not change where it goes, and is not counted. */
    struct solver plain = solver_for("rk4", 0.0173, 0, 1),
                  watched = solver_for("rk4", 0.0173, 0, 1);
    double grid[STUDY_TIMES * 2];
    assert_int_equal(solver_run(&plain, NULL, NULL), STOP_END);
    assert_int_equal(solver_run(&watched, grid, NULL), STOP_END);
    assert_memory_equal(plain.y, watched.y, 2 * sizeof(double));
    assert_int_equal(plain.step.cost.evals, watched.step.cost.evals);
    solver_free(&plain);
    solver_free(&watched);
}

static int64_t marched;

static int64_t march_of_rk4(const struct method *method, const struct march *march)
{
    for (int64_t i = 0; i < march->count; i++) {
        march->step->t = march->origin + (double)(march->first + i) * march->step->h;
        assert_int_equal(method_step(method, march->step), STEP_OK);
        memcpy(march->row + 2 * i, march->step->y, 2 * sizeof(double));
    }
    marched += march->count;
    return march->count;
}

TEST(test_kernels_in_bulk)
{
    static const double spans[] = {1, 20.473, 0.0005};
    for (size_t i = 0; i < COUNT_OF(spans); i++) {
        struct solver plain = solver_for("rk4", 0.001, 0, spans[i]),
                      bulk = solver_for("rk4", 0.001, 0, spans[i]);
        plain.kernel = NULL;
        bulk.kernel = march_of_rk4;
        marched = 0;
        assert_int_equal(solver_run(&plain, NULL, NULL), STOP_END);
        assert_int_equal(solver_run(&bulk, NULL, NULL), STOP_END);
        assert_memory_equal(plain.y, bulk.y, 2 * sizeof(double));
        assert_int_equal(plain.steps, bulk.steps);
        assert_int_equal(marched, (int64_t)floor(spans[i] / 0.001 + 1e-6));
        solver_free(&plain);
        solver_free(&bulk);
    }
}

TEST(test_limits)
{
    struct cancel cancel = {0};
    atomic_store(&cancel.requested, 1);
    static const double tolerances[] = {0, 1e-10};
    for (size_t i = 0; i < COUNT_OF(tolerances); i++) {
        struct solver solver = solver_for("dopri5", 1e-4, tolerances[i], 1000);
        solver.max = 20000;
        assert_int_equal(solver_run(&solver, NULL, NULL), STOP_FULL);
        assert_true(solver_cost(&solver) < 30000);
        solver_start(&solver);
        assert_int_equal(solver_cost(&solver), 0);
        assert_int_equal(solver_run(&solver, NULL, &cancel), STOP_CANCELLED);
        assert_true(solver.steps < 1000);
        solver_free(&solver);
    }
    struct solver solver = solver_for("euler", 10, 0, 1e5); /* omega dt = 87 */
    assert_int_equal(solver_run(&solver, NULL, NULL), STOP_DIVERGED);
    solver_free(&solver);
}

/* Compensated sums take most of the rounding away: of the energy, whose truncation error is 1e-20
 * here. */
TEST(test_compensated)
{
    double off[2];
    for (int compensated = 0; compensated < 2; compensated++) {
        struct solver solver = solver_for("rk4", 20.0 / (1 << 20), 0, 20);
        solver.compensated = compensated;
        solver.kernel = NULL;
        assert_int_equal(solver_run(&solver, NULL, NULL), STOP_END);
        off[compensated] = fabs(
            (75 * solver.y[0] * solver.y[0] + solver.y[1] * solver.y[1]) / (75 * 0.05 * 0.05) - 1);
        solver_free(&solver);
    }
    if (!(off[1] < 2e-15 && off[0] > 5e-15)) {
        print_error("plain %g, compensated %g\n", off[0], off[1]);
        fail();
    }
}

RUN_TESTS(NULL, NULL)
