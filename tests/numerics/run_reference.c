/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The table of reference solutions (references.csv beside the recordings) against what the scenes give when they are
 * run: each problem as a scene, by every method named for it, at every time that it can afford.
 */
#include "numerics/references.h"

#include <float.h>

/* A problem of the table as a scene, and who solves it up to when and how well, relative to the solution's size. */
struct known {
    const char *problem, *parameters; /* a part of them */
    const char *preset;
    struct {
        const char *name;
        double value;
    } set[12];
    double dt;        /* of rk4; 0: too stiff for it */
    double until;     /* [s] for dopri5; 0: too stiff */
    double tolerance; /* for both */
};

#define UNIT                                                                                                           \
    {"m", 1}, {"k", 1},                                                                                                \
    {                                                                                                                  \
        "y0", 1                                                                                                        \
    }
#define QUADRATIC(b, c)                                                                                                \
    UNIT, {"C", (b)}, {"rho", 1}, {"area", 1},                                                                         \
    {                                                                                                                  \
        "gamma", (c)                                                                                                   \
    }
#define HALF_PI 1.57079632679489661923

static const struct known known[] = {
    {"damped_oscillator", "(undamped)", "spring", {UNIT}, 1e-3, 1e9, 1e-10},
    {"damped_oscillator", "gamma=0.1 ", "spring", {UNIT, {"gamma", 0.1}}, 1e-3, 1e9, 1e-11},
    {"damped_oscillator", "zeta=1+1e-12", "spring", {UNIT, {"gamma", 2.000000000002}}, 1e-3, 1e9, 1e-11},
    {"damped_oscillator", "zeta=1-1e-12", "spring", {UNIT, {"gamma", 1.999999999998}}, 1e-3, 1e9, 1e-11},
    {"damped_oscillator", "gamma=1e9", "stiff-damped", {{NULL, 0}}, 0, 0, 0},
    {"damped_oscillator", "stiff spring", "stiff-spring", {{NULL, 0}}, 0, 0, 0},
    {"damped_oscillator", "gamma=-0.1", "spring", {UNIT, {"gamma", -0.1}}, 1e-3, 1e9, 1e-11},
    {"forced_oscillator", "", "spring", {UNIT, {"gamma", 0.1}, {"F0", 0.5}, {"omega", 1.2}}, 1e-3, 1e9, 1e-10},
    {"resonance", "", "resonance", {{NULL, 0}}, 1e-3, 1e9, 1e-9},
    {"quadratic_drag_oscillator", "qdrag_b0.1,", "spring", {QUADRATIC(0.1, 0)}, 5e-4, 1e9, 1e-9},
    {"quadratic_drag_oscillator", "qdrag_b1,", "spring", {QUADRATIC(1, 0)}, 5e-4, 1e9, 1e-9},
    {"quadratic_drag_oscillator", "lin0.05", "spring", {QUADRATIC(0.1, 0.05)}, 5e-4, 1e9, 1e-9},
    {"duffing_free", "", "duffing", {{NULL, 0}}, 1e-3, 1e9, 1e-9},
    {"duffing_chaotic", "", "duffing-driven", {{NULL, 0}}, 1e-3, 1e9, 1e-8},
    {"pendulum", "", "pendulum", {{"m", 1}, {"g", 1}, {"theta0", HALF_PI}}, 1e-3, 1e9, 1e-9},
    {"kepler", "", "kepler-eccentric", {{NULL, 0}}, 1e-4, 1e9, 1e-7},
    {"vdp_mu1", "", "vanderpol", {{NULL, 0}}, 1e-3, 1e9, 1e-10},
    {"vdpol", "mu=1000 unscaled", "stiff-vanderpol", {{NULL, 0}}, 0, 2000, 1e-11},
    {"vdpol", "eps=1e-6 ", "stiff-vanderpol", {{"k", 1e6}, {"mu", 1e6}}, 0, 1, 1e-11},
    {"prothero_robinson", "", "prothero-robinson", {{"lambda", -1}}, 1e-3, 1e9, 1e-11},
    {"rober", "", "robertson", {{NULL, 0}}, 1e-4, 40, 1e-11},
    {"orego", "", "orego", {{NULL, 0}}, 0, 30, 1e-11},
    {"DETEST-E2", "", "vanderpol", {{NULL, 0}}, 1e-3, 1e9, 1e-10},
    {"DETEST-E3",
     "",
     "duffing",
     {{"k3", -1. / 6}, {"F0", 2}, {"omega", 2.78535}, {"phase", -HALF_PI}, {"y0", 0}},
     1e-3,
     1e9,
     1e-9},
    {"DETEST-E4", "", "spring", {QUADRATIC(0.4, 0), {"k", 0}, {"g", -0.032}, {"y0", 30}}, 1e-3, 1e9, 1e-10},
};

static bool is_of(const struct reference *row, const struct known *problem)
{
    return text_starts(text_of(row->problem), text_of(problem->problem)) &&
           (!strstr(row->problem, "_drag") || strstr(problem->problem, "_drag")) &&
           strstr(row->parameters, problem->parameters);
}

/* ---- solving ---- */

static struct scene scene_for(const struct known *problem)
{
    struct scene scene;
    struct error error;
    const struct row *preset = catalog_find(&preset_catalog, text_of(problem->preset));
    assert_non_null(preset);
    scene_init(&scene, (const struct preset *)(const void *)preset);
    for (size_t i = 0; i < COUNT_OF(problem->set) && problem->set[i].name; i++)
        if (!scene_set(&scene, scene_param(&scene, problem->set[i].name), (struct measured){problem->set[i].value, 0},
                       &error))
            fail_msg("%s: %s", problem->problem, error.text);
    return scene;
}

/* Largest error over the rows of the problem up to `until`, in units of each variable's size; -1: there are none. */
static double worst_error(const struct known *problem, const char *method, struct run_settings settings, double until,
                          const struct reference *table, size_t count)
{
    struct scene scene = scene_for(problem);
    double worst = -1, t = 0;
    settings.record = (struct recording_rule){RECORD_EVERY, INT64_MAX};
    struct run *run = start(&scene, method, settings, HUGE_VAL);
    for (;;) {
        double next = HUGE_VAL;
        for (size_t i = 0; i < count; i++)
            if (is_of(&table[i], problem) && table[i].t > t)
                next = fmin(next, table[i].t);
        if (!(next <= until))
            break;
        t = next;
        go_to(run, t);
        if (run->stop != STOP_END)
            fail_msg("%s by %s: %s at t = %g", problem->problem, method, stop_name(run->stop), run->t);
        for (size_t i = 0; i < count; i++) {
            int k = place_of(&table[i]);
            if (!is_of(&table[i], problem) || table[i].t != t)
                continue;
            assert_true(k < run->system.n);
            double size = fmax(fabs(table[i].value), run->system.scale[k]);
            worst = fmax(worst, fabs(run->y[k] - table[i].value) / size);
        }
    }
    run_destroy(run);
    return worst;
}

static void test_references_are_reached(void **state)
{
    (void)state;
    size_t count = 0, compared = 0;
    struct reference *table = read_table(&count);
    if (!table) {
        print_message("no references.csv beside HOOKE_DATA: nothing to compare with\n");
        skip();
    }
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct known *p = &known[i];
        const bool chatty = getenv("VERBOSE");
        struct scene scene = scene_for(p);
        struct system system;
        struct error error;
        assert_true(scene_bind(&scene, &system, &error));
        struct {
            const char *method;
            struct run_settings settings;
            double until, tolerance;
        } tries[] = {
            {"dopri5", {.dt = 1e-6, .tol = 1e-12}, p->until, p->tolerance},
            {"rk4", {.dt = p->dt}, p->dt > 0 ? fmin(p->until, 100) : 0, p->tolerance},
            /* One step: what is left is the rounding of the start and the coefficients, times their conditioning. */
            {"exact", {.dt = 1e9}, system_has_exact(&system) ? DBL_MAX : 0, 1e-11},
        };
        for (size_t k = 0; k < COUNT_OF(tries); k++) {
            if (tries[k].until == 0)
                continue;
            double error_of = worst_error(p, tries[k].method, tries[k].settings, tries[k].until, table, count);
            if (chatty)
                print_message("%s %s by %s: %.2g\n", p->problem, p->parameters, tries[k].method, error_of);
            if (!(error_of >= 0 && error_of <= tries[k].tolerance))
                fail_msg("%s %s by %s: error %.3g, allowed %.3g", p->problem, p->parameters, tries[k].method, error_of,
                         tries[k].tolerance);
            compared++;
        }
    }
    assert_true(compared > 40);
    /* The comparison can fail: another problem's solution is not this one's. */
    struct known wrong = known[0];
    wrong.set[1].value = 1.0001;
    assert_true(worst_error(&wrong, "dopri5", (struct run_settings){.dt = 1e-6, .tol = 1e-12}, 1e9, table, count) >
                1e-5);
    free(table);
}

/* The pendulum's period from rest at 90 degrees: 2 pi / agm(1, cos(theta0/2)); a quarter of it to the bottom. */
static void test_period_of_the_pendulum(void **state)
{
    (void)state;
    static const struct known pendulum = {"pendulum", "", "pendulum", {{"m", 1}, {"g", 1}, {"theta0", HALF_PI}},
                                          0,          0,  0};
    struct scene scene = scene_for(&pendulum);
    struct run *run = start(&scene, "dopri5", (struct run_settings){.dt = 1e-3, .tol = 1e-12}, HUGE_VAL);
    struct expr_scope scope;
    struct arena arena = {0};
    struct condition condition;
    struct error error;
    size_t used;
    assert_true(run_scope(run, &scope));
    assert_true(condition_compile(TEXT("theta < 0"), &scope, &arena, &condition, &used, &error));
    struct run_target target = {.t = 10, .steps = -1, .condition = &condition, .scope = &scope};
    assert_false(run_advance(run, &target, 0, NULL));
    assert_int_equal(run->stop, STOP_CONDITION);
    assert_close(run->t, 7.41629870920548767 / 4, 1e-11);
    arena_reset(&arena);
    run_destroy(run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_references_are_reached),
        cmocka_unit_test(test_period_of_the_pendulum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
