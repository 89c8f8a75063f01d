/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The yardsticks, where this build has them: that a library with a memory of its own behaves like a
 * method. */
#include "unit/run/fixture.h"

#include <hooke/method.h>
#include <hooke/run.h>
#include <hooke/scene/formula.h>

static const char *const names[] = {"cvode-adams", "cvode-bdf"};

static bool is_there(void)
{
    if (catalog_find(&method_catalog, text_of(names[0])))
        return true;
    print_message("built without SUNDIALS\n");
    skip();
    return false;
}

static struct run *begin(const struct scene *scene, const char *name, double tol)
{
    return start(scene, name, (struct run_settings){.dt = 1e-3, .tol = tol}, HUGE_VAL);
}

/* Errors follow the tolerance; costs are counted. */
TEST(test_error_follows_tolerance)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        struct scene scene = spring();
        double before = HUGE_VAL;
        set(&scene, "gamma", 0.1);
        for (double tol = 1e-4; tol > 1e-13; tol /= 1e3) {
            struct run *run = begin(&scene, names[k], tol);
            struct run_errors errors;
            go_to(run, 10);
            assert_int_equal(run->stop, STOP_END);
            assert_true(run->t == 10);
            run_errors(run, &errors);
            assert_true(errors.end < 1e4 * tol && errors.end < before / 20);
            before = errors.end;
            const bool stiff = run->method->flags & METHOD_IMPLICIT;
            assert_true(run->cost.evals >= run->steps && run->cost.evals < 4 * run->steps);
            assert_true(stiff ? run->cost.jacobians > 0 && run->cost.solves >= run->steps
                              : run->cost.jacobians == 0 && run->cost.solves == 0);
            run_destroy(run);
        }
    }
}

/* A time on the way is met exactly, without a new start; a change of the scene and a turn are new
 * starts. */
TEST(test_stops_turns_and_changes)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        struct scene scene = spring();
        struct error error;
        struct run *run = begin(&scene, names[k], 1e-10), *direct = begin(&scene, names[k], 1e-10);
        for (int i = 1; i <= 10; i++) {
            go_to(run, i * 0.5);
            assert_true(run->t == i * 0.5 && run->stop == STOP_END);
        }
        go_to(direct, 5);
        assert_close(run->y[0], direct->y[0], 1e-7 * 0.05);
        assert_true(run->steps < 2 * direct->steps); /* a new start takes some hundred steps more */
        run_destroy(direct);
        go_to(run, 0);
        assert_true(run->t == 0);
        assert_close(run->y[0], 0.05, 1e-6 * 0.05);
        assert_close(run->y[1], 0, 1e-6 * 0.5);
        set(&scene, "k", 60);
        assert_true(run_rebind(run, &scene, &error));
        go_to(run, 3);
        assert_close(run->y[0], 0.05 * cos(sqrt(300) * 3), 2e-6 * 0.05);
        /* Backwards from the start, and on without an end. */
        struct run *past = begin(&scene, names[k], 1e-10);
        go_to(past, -3);
        assert_close(past->y[0], 0.05 * cos(sqrt(300) * 3), 2e-6 * 0.05);
        run_destroy(past);
        go_steps(run, 100);
        assert_true(run->t > 3 && run->stop == STOP_END);
        run_destroy(run);
    }
}

/* y = 0 inside a step; cos(omega t) = 0. */
TEST(test_condition_is_located)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        struct scene scene = spring();
        struct run *run = begin(&scene, names[k], 1e-11);
        struct expr_scope scope;
        struct arena arena = {0};
        struct condition condition;
        struct error error;
        size_t used;
        assert_true(run_scope(run, &scope));
        assert_true(condition_compile(TEXT("y < 0"), &scope, &arena, &condition, &used, &error));
        struct run_target target = {.t = 10, .steps = -1, .condition = &condition, .scope = &scope};
        assert_false(run_advance(run, &target, 0, NULL));
        assert_int_equal(run->stop, STOP_CONDITION);
        assert_close(run->t, acos(0) / sqrt(75), 1e-8);
        assert_close(run->y[0], 0, 1e-8 * 0.05);
        go_to(run, 10);
        assert_close(run->y[0], 0.05 * cos(sqrt(75) * 10), 1e-7 * 0.05);
        arena_reset(&arena);
        run_destroy(run);
    }
}

/* Between the ends of a step it is the polynomial of its own memory; asked for or not, the next
 * step is the same. */
TEST(test_dense_output)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        const struct method *method = method_named(names[k]);
        struct scene scene = spring();
        struct system system;
        struct error error;
        assert_true(scene_bind(&scene, &system, &error));
        double y[2][2], work[2][8], before[2], inside[2], exact[2], e[2];
        struct step step[2];
        struct controller controller[2] = {{.tol = 1e-9}, {.tol = 1e-9}};
        for (int i = 0; i < 2; i++) {
            memcpy(y[i], system.start, sizeof y[i]);
            step[i] =
                (struct step){.system = &system, .y = y[i], .work = work[i], .error = i ? e : NULL};
            assert_true(method_begin(method, &step[i]));
        }
        for (int i = 0; i < 300; i++) {
            memcpy(before, y[1], sizeof before);
            assert_int_equal(method_adapt(method, &step[0], &controller[0], 5), STEP_OK);
            assert_int_equal(method_adapt(method, &step[1], &controller[1], 5), STEP_OK);
            assert_memory_equal(y[0], y[1], sizeof y[0]);
            assert_true(step[0].t == step[1].t && fabs(e[0]) <= 1e-8 && fabs(e[1]) <= 1e-7);
            method_dense(method, &step[1], before, 0, inside);
            assert_close(inside[0], before[0], 2e-9 * 0.05 * 10);
            method_dense(method, &step[1], before, 1, inside);
            assert_close(inside[0], y[1][0], 1e-15);
            system_exact(&system, 0, system.start, step[1].t - 0.3 * step[1].h, exact, NULL);
            method_dense(method, &step[1], before, 0.7, inside);
            assert_close(inside[0], exact[0], 1e-6 * 0.05);
        }
        for (int i = 0; i < 2; i++)
            method_end(method, &step[i]);
        assert_null(step[0].library);
    }
}

/* ---- failure ---- */

static void wall_add(const double *c, double t, const double *y, double *a)
{
    (void)c, (void)t;
    a[0] += y[0] > 1 ? NAN : 1;
}
static void flat_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t, (void)y, (void)jac;
}
static const struct term_row wall = {
    .row = {"wall", "m/s^2", "", "", NULL}, .add = wall_add, .jacobian = flat_jacobian};

/* A failed step leaves the state before it, bit for bit; so does one without the library's memory.
 */
TEST(test_failure)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        const struct method *method = method_named(names[k]);
        struct system system = {.n = 2, .order = 2, .terms = 1, .mass = 1, .scale = {1, 1}};
        system.term[0] = (struct bound_term){&wall, {0}};
        double y[2] = {0, 0}, before[2] = {0, 0}, work[8], t = 0;
        struct step step = {.system = &system, .y = y, .work = work, .h = 0.1};
        struct controller controller = {.tol = 1e-6};
        assert_int_equal(method_adapt(method, &step, &controller, 9), STEP_NO_SOLUTION);
        assert_int_equal(method_step(method, &step), STEP_NO_SOLUTION);
        assert_true(method_begin(method, &step));
        enum step_status status = STEP_OK;
        for (int i = 0; i < 100000 && status == STEP_OK; i++) {
            memcpy(before, y, sizeof y);
            t = step.t;
            status = method_adapt(method, &step, &controller, 9);
        }
        assert_int_equal(status, STEP_NONFINITE);
        assert_memory_equal(y, before, sizeof y);
        assert_true(step.t == t && y[0] <= 1 && y[0] > 0.9);
        method_end(method, &step);
    }
}

/* CVODE refuses a fixed dt; a growing solution ends as diverged. */
TEST(test_refusals_and_ends)
{
    if (!is_there())
        return;
    for (size_t k = 0; k < COUNT_OF(names); k++) {
        struct scene scene = spring();
        struct error error = {0};
        struct run_settings fixed = {.dt = 1e-3};
        assert_null(run_create(&scene, method_named(names[k]), &fixed, 1, &error));
        assert_non_null(strstr(error.text, "chooses its steps itself"));
        assert_true(isnan(method_growth(method_named(names[k]), DRAG_DEFAULT, 0.1, 0)));
        assert_true(isnan(method_stable_limit(method_named(names[k]), DRAG_DEFAULT, 0)));

        /* Negative drag: grows until it is too large, in finite time. */
        set(&scene, "gamma", -20);
        struct run *run = begin(&scene, names[k], 1e-6);
        go_to(run, 1e4);
        assert_true(run->stop == STOP_DIVERGED && isfinite(run->y[0]));
        run_destroy(run);
    }
}

RUN_TESTS(NULL, NULL)
