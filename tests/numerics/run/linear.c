/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs of typed oscillators are those of built-in ones: plans, steps by every method, errors;
 * linear systems, too. */
#include "cmocka_testing.h"

#include "unit/scene/typing.h"
#include <hooke/base/catalog.h>
#include <hooke/run.h>

#include <stdlib.h>

static const struct method *method(const char *name)
{
    return method_by_name(text_of(name));
}

static void set(struct scene *scene, const char *name, double value)
{
    struct error error;
    assert_true(scene_set(scene, scene_param(scene, name), (struct measured){value, 0}, &error));
}

struct pair {
    const char *const *lines;
    struct {
        const char *name;
        double value;
    } given[8]; /* of the built-in scene, on m = 1, k = 16 */
};

#define LINES(...)                                                                                 \
    (const char *const[])                                                                          \
    {                                                                                              \
        __VA_ARGS__, NULL                                                                          \
    }

/* Parameters are powers of two and the like: coefficients are the same to the bit. */
static const struct pair pairs[] = {
    {LINES("var y = 0.05", "var y' = 0.25", "param k = 16", "y'' = -k*y", "potential k*y^2/2"),
     {{"v0", 0.25}}},
    {LINES("var y = 0.05", "param k = 16", "y'' = -k*y - 0.5*y'", "potential k*y^2/2"),
     {{"gamma", 0.5}}},
    {LINES("var y = 0.05", "y'' = -16*y - 0.5*y' - 2*abs(y')*y'", "potential 8*y^2"),
     {{"gamma", 0.5}, {"C", 2}}},
    {LINES("var y = 0.05", "y'' = -16*y - 16*y' + 0.125*cos(3*t + 1) - 2"),
     {{"gamma", 16}, {"F0", 0.125}, {"omega", 3}, {"phase", 1}, {"g", 2}}},
    {LINES("force -0.5*v - 2*v*abs(v)"), {{"gamma", 0.5}, {"C", 2}}},
    {LINES("force -0.5*v + 0.125*cos(3*t)"), {{"gamma", 0.5}, {"F0", 0.125}, {"omega", 3}}},
};

static void make(const struct pair *pair, struct typed_models *models, struct scene *typed,
                 struct scene *built_in)
{
    scene_init(typed, NULL);
    scene_init(built_in, NULL);
    struct scene *const both[] = {typed, built_in};
    for (int i = 0; i < 2; i++) {
        set(both[i], "m", 1);
        set(both[i], "k", 16);
        set(both[i], "rho", 1);
        set(both[i], "area", 1);
    }
    assert_true(type_scene(models, typed, pair->lines));
    for (size_t i = 0; i < COUNT_OF(pair->given) && pair->given[i].name; i++)
        set(built_in, pair->given[i].name, pair->given[i].value);
}

static bool agree(const char *what, const char *by, double a, double b, double tolerance)
{
    if ((isnan(a) && isnan(b)) || a == b || fabs(a - b) <= tolerance)
        return true;
    print_message("%s, %s: %.17g is not %.17g\n", by, what, a, b);
    return false;
}

/* Every method, every way of drag, fixed steps and adaptive ones, by the propagator and without it.
 */
TEST(test_runs_are_the_same)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    bool fine = true;
    int runs = 0;
    for (size_t i = 0; i < COUNT_OF(pairs) * method_catalog.count; i++) {
        const struct method *by = method_at(i / COUNT_OF(pairs));
        struct scene scene[2];
        make(&pairs[i % COUNT_OF(pairs)], models, &scene[0], &scene[1]);
        for (int way = 0; way < 12; way++) {
            const bool adaptive = way % 3 == 2;
            const struct run_settings settings = {.dt = 0.01,
                                                  .drag = (enum drag)(way / 3),
                                                  .tol = adaptive ? 1e-6 : 0,
                                                  .kernel =
                                                      way % 3 ? KERNEL_GENERAL : KERNEL_PROPAGATOR};
            struct run *run[2];
            struct run_errors errors[2];
            if (by->flags & METHOD_EXTERNAL)
                continue;
            for (int k = 0; k < 2; k++)
                run[k] = run_create(&scene[k], by, &settings, 5, &error);
            if (!run[0] != !run[1]) {
                print_message("%s refuses one of pair %zu: %s\n", by->row.name, i % COUNT_OF(pairs),
                              error.text);
                fine = false;
            }
            for (int k = 0; k < 2 && run[0] && run[1]; k++) {
                const struct run_target target = {.t = 5, .steps = -1};
                run_advance(run[k], &target, 0, NULL);
                run_errors(run[k], &errors[k]);
            }
            if (run[0] && run[1]) {
                const struct plan *p = &run[0]->plan, *q = &run[1]->plan;
                const double scale = run[0]->system.scale[0];
                runs++;
                fine &= p->exact_known == q->exact_known && p->propagates == q->propagates &&
                        agree("steps", by->row.name, p->steps, q->steps, 0) &&
                        p->adaptive == q->adaptive && p->ledger == q->ledger;
                fine &= agree("growth", by->row.name, p->growth, q->growth, 0) &&
                        agree("limit", by->row.name, p->limit, q->limit, 0);
                fine &= run[0]->stop == run[1]->stop && run[0]->t == run[1]->t;
                if (!adaptive || run[0]->steps == run[1]->steps) {
                    const double rounding = adaptive ? 1e-9 : 1e-12;
                    fine &=
                        agree("y", by->row.name, run[0]->y[0], run[1]->y[0], rounding * scale) &&
                        agree("error", by->row.name, errors[0].max, errors[1].max, rounding) &&
                        agree("phase", by->row.name, errors[0].phase, errors[1].phase, rounding) &&
                        agree("floor", by->row.name, errors[0].floor, errors[1].floor, 0);
                } else {
                    print_message("%s takes %lld and %lld steps\n", by->row.name,
                                  (long long)run[0]->steps, (long long)run[1]->steps);
                    fine = false;
                }
                if (!fine)
                    fail_msg("pair %zu, way %d", i % COUNT_OF(pairs), way);
            }
            run_destroy(run[0]);
            run_destroy(run[1]);
        }
    }
    assert_true(runs > 1000);
    typed_destroy(models);
}

/* What is nearly linear is run as such: dry friction has no one-step matrix, and an implicit step
 * iterates. */
TEST(test_friction_is_not_linear)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, LINES("var y = 1", "y'' = -y - 0.1*sign(y')")));
    double end[2];
    for (int k = 0; k < 2; k++) {
        const struct run_settings settings = {.dt = 1e-3,
                                              .kernel = k ? KERNEL_GENERAL : KERNEL_PROPAGATOR};
        struct run *run = run_create(&scene, method("rk4"), &settings, 5, &error);
        assert_non_null(run);
        assert_false(run->plan.propagates || run->plan.exact_known);
        const struct run_target target = {.t = 3, .steps = -1};
        run_advance(run, &target, 0, NULL);
        end[k] = run->y[0];
        run_destroy(run);
    }
    assert_true(end[0] == end[1]);
    /* half a swing about the shifted equilibrium */
    assert_true(fabs(end[0] - (0.1 + 0.9 * cos(3))) < 1e-3);
    typed_destroy(models);
}

/* Two equations of first order by powers of the one-step matrix: within rounding of the steps, and
 * of the exact end. */
TEST(test_first_order_propagates)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    int propagated = 0;
    scene_init(&scene, NULL);
    assert_true(type_scene(
        models, &scene, LINES("var a = 1", "var b = 2", "a' = -3*a + 2*b + 0.25", "b' = a - 2*b")));
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *by = method_at(i);
        double end[2][2];
        bool applies = true;
        for (int k = 0; k < 2 && applies; k++) {
            const struct run_settings settings = {.dt = 0.01,
                                                  .kernel = k ? KERNEL_GENERAL : KERNEL_PROPAGATOR};
            struct run *run = run_create(&scene, by, &settings, 10, &error);
            applies = run && !(by->flags & METHOD_EXTERNAL);
            if (applies) {
                const struct run_target target = {.t = 10, .steps = -1};
                run_advance(run, &target, 0, NULL);
                propagated += run->plan.propagates;
                assert_true(run->stop == STOP_END);
                memcpy(end[k], run->y, sizeof end[k]);
            }
            run_destroy(run);
        }
        for (int j = 0; applies && j < 2; j++)
            if (!agree("state", by->row.name, end[0][j], end[1][j], 2e-13))
                fail();
    }
    assert_true(propagated > 20);
    typed_destroy(models);
}

/* Coupled masses: `exact` steps to the normal modes, errors are known, and stay so when a parameter
 * changes. */
TEST(test_coupled)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene,
                           LINES("var a = 1", "var b = 0", "param j = 3", "a'' = -a + j*(b - a)",
                                 "b'' = -b + j*(a - b)")));
    const struct {
        const char *name;
        double error;
    } by[] = {{"exact", 1e-13}, {"rk4", 1e-6}, {"verlet", 1e-3}, {"gauss6", 1e-10}};
    for (size_t i = 0; i < COUNT_OF(by); i++) {
        const struct run_settings settings = {.dt = 0.01};
        struct run *run = run_create(&scene, method(by[i].name), &settings, 20, &error);
        assert_non_null(run);
        assert_true(run->plan.exact_known);
        struct run_target target = {.t = 10, .steps = -1};
        struct run_errors errors;
        run_advance(run, &target, 0, NULL);
        const double wanted = (cos(10) + cos(10 * sqrt(7))) / 2;
        assert_true(fabs(run->y[0] - wanted) < 10 * by[i].error);
        struct scene changed = scene;
        set(&changed, "j", 4);
        assert_true(run_rebind(run, &changed, &error));
        assert_true(run->plan.exact_known);
        target.t = 20;
        run_advance(run, &target, 0, NULL);
        run_errors(run, &errors);
        if (!(errors.max < 20 * by[i].error && errors.max > (i ? 1e-13 : -1)) ||
            !(errors.floor < 1e-13))
            fail_msg("%s: error %g, floor %g", by[i].name, errors.max, errors.floor);
        run_destroy(run);
    }
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
