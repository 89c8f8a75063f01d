/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Of several solutions of an implicit step, the one that belongs to the state it starts from: where
 * Newton's iteration from there finds another, or none, in long steps.
 */
#include "unit/run/fixture.h"
#include "unit/scene/typing.h"

/* The state after `span` in steps of dt. */
static enum stop state_after(const struct scene *scene, const char *method, double dt, double span,
                             double *y, double *min)
{
    struct run *run =
        start(scene, method, (struct run_settings){.dt = dt, .record = {.rule = RECORD_ALL}}, span);
    go_to(run, run->system.t0 + span);
    const enum stop stop = run->stop;
    memcpy(y, run->y, (size_t)run->system.n * sizeof *y);
    *min = HUGE_VAL;
    for (size_t i = 0; i < trace_count(run->trace); i++)
        for (int k = 0; k < run->system.n; k++)
            *min = fmin(*min, trace_state(run->trace, i)[k]);
    run_destroy(run);
    return stop;
}

/*
 * Robertson's y2' = 0.04 y1 - 1e4 y2 y3 - 3e7 y2^2: a step of backward Euler has a root on either
 * side of 0, and the negative one leads away. Concentrations are not negative where the method
 * damps what is stiff.
 */
TEST(test_concentrations_stay_positive)
{
    static const char *const methods[] = {"backward-euler", "bdf1",   "bdf2",   "bdf3",  "bdf4",
                                          "tr-bdf2",        "sdirk2", "radau3", "radau5"};
    static const double steps[] = {1e-3, 2e-3, 5e-3, 7e-3, 1e-2, 2e-2, 5e-2, 0.1};
    struct scene scene;
    scene_init(&scene, preset_by_name(TEXT("robertson")));
    double y[LIMIT_VARIABLES], min;
    for (size_t m = 0; m < COUNT_OF(methods); m++)
        for (size_t i = 0; i < COUNT_OF(steps); i++) {
            const enum stop stop = state_after(&scene, methods[m], steps[i], 1, y, &min);
            /* y1(1) = 0.96645973733 (radau5, tol = 1e-12); backward Euler in ten steps is 5e-4 off.
             */
            if (stop != STOP_END || !(min >= 0) || fabs(y[0] - 0.96645973733) > 1e-3 ||
                fabs(y[1] - 3.0746e-5) > 1e-7)
                fail_msg("%s, dt = %g: %s, y1 = %.9g, y2 = %g, least %g", methods[m], steps[i],
                         stop_name(stop), y[0], y[1], min);
        }
}

/* Those that do not damp ring, but have a solution. */
TEST(test_there_is_a_solution)
{
    static const char *const methods[] = {"trapezoid", "implicit-midpoint", "gauss4", "gauss6"};
    static const double steps[] = {1e-3, 1e-2, 2e-2, 5e-2, 0.1};
    struct scene scene;
    scene_init(&scene, preset_by_name(TEXT("robertson")));
    double y[LIMIT_VARIABLES], min;
    for (size_t m = 0; m < COUNT_OF(methods); m++)
        for (size_t i = 0; i < COUNT_OF(steps); i++) {
            const enum stop stop = state_after(&scene, methods[m], steps[i], 1, y, &min);
            if (stop != STOP_END || fabs(y[0] - 0.96645973733) > 4e-3 || fabs(y[1]) > 8e-5)
                fail_msg("%s, dt = %g: %s, y1 = %.9g, y2 = %g", methods[m], steps[i],
                         stop_name(stop), y[0], y[1]);
        }
}

/* The root of a step of backward Euler in one variable, by a fine continuation in h. */
static double followed(double (*f)(double), double (*slope)(double), double x, double h)
{
    const int parts = 10000;
    double root = x;
    for (int i = 1; i <= parts; i++) {
        const double part = h * i / parts;
        for (int k = 0; k < 4; k++)
            root -= (root - x - part * f(root)) / (1 - part * slope(root));
    }
    return root;
}

static double riccati(double x)
{
    return -x * x;
}
static double riccati_slope(double x)
{
    return -2 * x;
}
static double wells(double x)
{
    return x - x * x * x;
}
static double wells_slope(double x)
{
    return 1 - 3 * x * x;
}
static double pitch(double x)
{
    return 5 * sin(3 * x) - x;
}
static double pitch_slope(double x)
{
    return 15 * cos(3 * x) - 1;
}

TEST(test_one_step_belongs_to_its_start)
{
    static const struct {
        const char *start, *line;
        double (*f)(double), (*slope)(double);
        double x, longest;
    } cases[] = {
        {"var x = 1", "x' = -x^2", riccati, riccati_slope, 1, 1e4},
        {"var x = 1e-3", "x' = -x^2", riccati, riccati_slope, 1e-3, 1e4},
        {"var x = 0.1", "x' = x - x^3", wells, wells_slope, 0.1, 300},
        {"var x = -0.01", "x' = x - x^3", wells, wells_slope, -0.01, 300},
        {"var x = 3", "x' = x - x^3", wells, wells_slope, 3, 300},
        {"var x = 0.1", "x' = 5*sin(3*x) - x", pitch, pitch_slope, 0.1, 3},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene scene;
        scene_init(&scene, NULL);
        assert_true(
            type_scene(models, &scene, (const char *const[]){cases[i].start, cases[i].line, NULL}));
        for (double h = 0.01; h <= cases[i].longest; h *= 1.7) {
            double y[LIMIT_VARIABLES], min;
            const enum stop stop = state_after(&scene, "backward-euler", h, h, y, &min);
            const double root = followed(cases[i].f, cases[i].slope, cases[i].x, h);
            if (stop != STOP_END || !(fabs(y[0] - root) <= 1e-9 * (1 + fabs(root))))
                fail_msg("%s from %g, h = %g: %s, %.12g in place of %.12g", cases[i].line,
                         cases[i].x, h, stop_name(stop), y[0], root);
        }
    }
    typed_destroy(models);
}

/*
 * A step of the methods of structural dynamics from rest: y+ = y + beta h^2 a+ + h^2 (1/2 - beta) a
 * over theta h, a+ by a fine continuation in h; then the step of h. NAN where that turns back.
 */
struct structure {
    const char *name;
    double theta, alpha_m, alpha_f, beta, gamma;
};

static double structure_step(const struct structure *s, double (*f)(double),
                             double (*slope)(double), double x, double h)
{
    const int parts = 20000;
    const double a = f(x);
    double ahead = a;
    for (int i = 1; i <= parts; i++) {
        const double tau = s->theta * h * i / parts, fraction = 1 - s->alpha_f;
        for (int k = 0; k < 4; k++) {
            const double at = x + fraction * tau * tau * ((0.5 - s->beta) * a + s->beta * ahead);
            const double by = 1 - s->alpha_m - slope(at) * fraction * s->beta * tau * tau;
            if (!(by > 0))
                return NAN;
            ahead -= ((1 - s->alpha_m) * ahead + s->alpha_m * a - f(at)) / by;
        }
    }
    ahead = a + (ahead - a) / s->theta;
    return x + h * h * ((0.5 - s->beta) * a + s->beta * ahead);
}

static double trough(double x)
{
    return 5 * sin(3 * x) - 5 * x;
}
static double trough_slope(double x)
{
    return 15 * cos(3 * x) - 5;
}
static double step_down(double x)
{
    return -20 * tanh(8 * x);
}
static double step_down_slope(double x)
{
    return -160 / (cosh(8 * x) * cosh(8 * x));
}

TEST(test_structural_steps_belong_to_their_start)
{
    static const struct structure methods[] = {
        {"newmark", 1, 0, 0, 0.25, 0.5},
        {"hht", 1, 0, 0.1, 0.3025, 0.6},
        {"generalised-alpha", 1, 1. / 3, 4. / 9, 25. / 81, 11. / 18},
        {"wilson-theta", 1.4, 0, 0, 1. / 6, 0.5},
    };
    static const struct {
        const char *start, *line;
        double (*f)(double), (*slope)(double);
        double x, longest;
    } cases[] = {
        {"var x = 3", "x'' = 5*sin(3*x) - 5*x", trough, trough_slope, 3, 0.5},
        {"var x = 2", "x'' = -20*tanh(8*x)", step_down, step_down_slope, 2, 40},
        {"var x = 3", "x'' = x - x^3", wells, wells_slope, 3, 100},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene scene;
        scene_init(&scene, NULL);
        assert_true(
            type_scene(models, &scene, (const char *const[]){cases[i].start, cases[i].line, NULL}));
        for (size_t m = 0; m < COUNT_OF(methods); m++)
            for (double h = 0.01; h <= cases[i].longest; h *= 1.7) {
                double y[LIMIT_VARIABLES], min;
                const enum stop stop = state_after(&scene, methods[m].name, h, h, y, &min);
                const double root =
                    structure_step(&methods[m], cases[i].f, cases[i].slope, cases[i].x, h);
                if (!isnan(root) &&
                    (stop != STOP_END || !(fabs(y[0] - root) <= 1e-9 * (1 + fabs(root)))))
                    fail_msg("%s by %s, h = %g: %s, %.12g in place of %.12g", cases[i].line,
                             methods[m].name, h, stop_name(stop), y[0], root);
            }
    }
    typed_destroy(models);
}

/*
 * A creeping solution is followed to the jump at 807 s, beyond which such long steps have none
 * beside it. (Wilson's method rings by itself here: it carries an acceleration that nothing damps.)
 */
TEST(test_no_jump_before_its_time)
{
    static const char *const methods[] = {
        "backward-euler", "bdf2",    "trapezoid", "tr-bdf2",
        "radau5",         "newmark", "hht",       "generalised-alpha"};
    struct scene scene;
    scene_init(&scene, preset_by_name(TEXT("stiff-vanderpol")));
    for (size_t m = 0; m < COUNT_OF(methods); m++) {
        struct run *run = start(&scene, methods[m], (struct run_settings){.dt = 1}, 1000);
        go_to(run, 1000);
        if (run->stop == STOP_NO_SOLUTION ? !(run->t >= 799) : run->stop != STOP_END)
            fail_msg("%s: %s at %g s", methods[m], stop_name(run->stop), run->t);
        run_destroy(run);
    }
}

RUN_TESTS(NULL, NULL)
