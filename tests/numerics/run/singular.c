/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Solutions that go to infinity in finite time, against their closed forms; and what must not be
 * taken for one. */
#include "cmocka_testing.h"

#include "unit/scene/typing.h"
#include <hooke/run.h>

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846
#define CREEPING 131072 /* steps, a power of two: methods of low order are looked into at those */

static const struct method *method(const char *name)
{
    return method_by_name(text_of(name));
}

static void typed_scene(struct typed_models *models, struct scene *scene, const char *lines)
{
    struct text rest = text_of(lines), line;
    struct error error = {0};
    scene_init(scene, NULL);
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene->model, &typed, &error);
        if (!model)
            fail_msg("%s: %s", lines, error.text);
        scene_remodel(scene, model);
    }
}

/* Runs it for `span` and says why it ended. */
static struct run *ended(const struct scene *scene, const char *by, double dt, double tol,
                         double span)
{
    const struct run_settings settings = {.dt = dt, .tol = tol};
    struct error error = {0};
    struct run *run = run_create(scene, method(by), &settings, span, &error);
    if (!run)
        fail_msg("%s: %s", by, error.text);
    const struct run_target target = {.t = run->system.t0 + span, .steps = -1};
    while (run_advance(run, &target, 0, NULL)) {
    }
    run_diagnose(run);
    return run;
}

/* The integral of dx / sqrt(2 (E - V)) for x'' = -x + x^3 from x = v = 1: E - V = 3/4 - x^2/2 +
 * x^4/4. x = 1/u. */
static double duffing_time(void)
{
    const int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; i++) { /* midpoint rule; the integrand is smooth in u */
        const double u = (i + 0.5) / n;
        sum += 1 / sqrt(2 * (0.75 * u * u * u * u - 0.5 * u * u + 0.25)) / n;
    }
    return sum;
}

TEST(test_closed_forms)
{
    static const struct {
        const char *lines;
        double at; /* NAN: duffing_time() */
        bool second;
    } scenes[] = {
        {"var x = 1;x' = x^2", 1, false},
        {"var x = 1;x' = x^3", 0.5, false},
        {"var x = 0;x' = 1 + x^2", PI / 2, false},
        {"var x = 0;x' = exp(x)", 1, false},
        {"var x = 1e-6;x' = 1e-3*x^2", 1e9, false},
        {"var x = 1;var y = 1;x' = x*y;y' = x*y", 1, false},
        {"var x = 1;var x' = 2;x'' = 6*x^2", 1, true},
        {"var x = 1;var x' = 1;x'' = x^3 - x", NAN, true},
        {"var x = 100;var x' = 0;x'' = -2*x' - x + x^3", 0,
         true}, /* no closed form: only that it is seen */
    };
    static const char *const adaptive[] = {"dopri5", "dop853",  "tsit5",  "bogacki-shampine",
                                           "odex",   "rodas5p", "rodas4", "radau5",
                                           "radau3", "tr-bdf2"};
    static const char *const fixed[] = {
        "rk4", "euler", "heun", "backward-euler", "implicit-midpoint", "gauss4", "bdf2"};
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        struct scene scene;
        typed_scene(models, &scene, scenes[i].lines);
        const double at = isnan(scenes[i].at) ? duffing_time() : scenes[i].at,
                     span = at > 0 ? 3 * at : 1;
        for (size_t m = 0; m < COUNT_OF(adaptive) + COUNT_OF(fixed); m++) {
            const bool adapts = m < COUNT_OF(adaptive);
            const char *by = adapts ? adaptive[m] : fixed[m - COUNT_OF(adaptive)];
            struct run *run =
                method(by) ? ended(&scene, by, span / 3000, adapts ? 1e-8 : 0, span) : NULL;
            if (!run)
                continue;
            if (run->stop != STOP_SINGULAR)
                fail_msg("%s, %s: %s at %g, not singular", scenes[i].lines, by,
                         stop_name(run->stop), run->t);
            if (run->stop == STOP_SINGULAR && at > 0 && fabs(run->singular.t / at - 1) > 1e-7)
                fail_msg("%s, %s: at %.12g, not %.12g", scenes[i].lines, by, run->singular.t, at);
            assert_false(run->singular.finite);
            if (run->steps > CREEPING)
                fail_msg("%s, %s: %lld steps", scenes[i].lines, by,
                         (long long)run->steps); /* it creeps */
            run_destroy(run);
        }
    }
    typed_destroy(models);
}

/* x = sqrt(1 - 2 t) ends at 1/2 with an infinite slope: methods bounce there for ever. */
TEST(test_end_of_a_root)
{
    static const char *const methods[] = {"dopri5",  "tsit5", "dop853",        "radau5",
                                          "rodas5p", "rk4",   "backward-euler"};
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    typed_scene(models, &scene, "var x = 1;x' = -1/x");
    for (size_t m = 0; m < COUNT_OF(methods); m++) {
        struct run *run = ended(&scene, methods[m], 1e-2, 1e-6, 3);
        if (run->stop != STOP_SINGULAR || !run->singular.finite ||
            fabs(run->singular.t - 0.5) > 1e-8)
            fail_msg("%s: %s at %.9g, %s at %.9g", methods[m], stop_name(run->stop), run->t,
                     singularity_text(&run->singular), run->singular.t);
        assert_true(run->steps < 20000);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* Adaptive steps of a loose tolerance jump across an infinite slope, or bounce beyond it, and get
 * where they should. */
TEST(test_loose_tolerances)
{
    static const struct {
        const char *lines;
        double at;
    } scenes[] = {
        {"var x = 1;x' = -1/x", 0.5},
        {"var x = 1;x'' = -1/x^2", PI / 2.8284271247461903},
        {"var x = 1;x'' = -1/x", 1.2533141373155003}, /* sqrt(pi/2) */
        {"var x = 1;x' = -1/sqrt(x)", 2 / 3.},
        {"var x = 1;x' = -sqrt(x) - 1", 0.6137056388801094}, /* 2 - 2 log(2) */
        {"var x = 2.718281828459045;x' = -1/log(x)", 1},
        {"var x = 0;x' = 1/cos(x)", 1},
        {"var x = 1;x' = x^2", 1},
        {"var x = 1;x' = x*sqrt(x)", 2},
        {"var x = 1;var y = 1;x' = -1/x;y' = x - y", 0.5},
    };
    static const char *const methods[] = {"bogacki-shampine", "dopri5", "tsit5",  "dop853", "odex",
                                          "tr-bdf2",          "radau5", "rodas4", "rodas5p"};
    static const double tolerances[] = {0.1, 0.01, 1e-3, 1e-5};
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(scenes) * COUNT_OF(methods) * COUNT_OF(tolerances); i++) {
        const size_t s = i % COUNT_OF(scenes), m = i / COUNT_OF(scenes) % COUNT_OF(methods);
        const double tol = tolerances[i / COUNT_OF(scenes) / COUNT_OF(methods)];
        struct scene scene;
        typed_scene(models, &scene, scenes[s].lines);
        struct run *run =
            method(methods[m]) ? ended(&scene, methods[m], 0.01, tol, 1.5 * scenes[s].at) : NULL;
        if (!run)
            continue;
        if (run->stop == STOP_END ||
            (run->stop == STOP_SINGULAR && fabs(run->singular.t / scenes[s].at - 1) > 1e-4))
            fail_msg("%s by %s, tol = %g: %s at %g, singular at %g", scenes[s].lines, methods[m],
                     tol, stop_name(run->stop), run->t, run->singular.t);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* A pole that comes after a long time of its own, beyond what one search from the start would
 * reach. */
TEST(test_late)
{
    static const char *const methods[] = {"dopri5", "radau5", "rodas5p", "rk4"};
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    typed_scene(models, &scene, "var x = 1e-2;var c = 1;var s = 0;c' = -100*s;s' = 100*c;x' = x^2");
    for (size_t m = 0; m < COUNT_OF(methods); m++) {
        struct run *run = ended(&scene, methods[m], 1e-2, 1e-7, 110);
        /* of fixed steps the end is that of what they have made of the solution */
        if (run->stop != STOP_SINGULAR ||
            fabs(run->singular.t - 100) > (run->plan.adaptive ? 1e-3 : 1e-2))
            fail_msg("%s: %s at %.9g, %.9g", methods[m], stop_name(run->stop), run->t,
                     run->singular.t);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* The built-in soft spring beyond its barrier, whatever integrates it, forwards and backwards. */
TEST(test_built_in)
{
    static const char *const methods[] = {"euler",          "symplectic-euler", "verlet", "rk4",
                                          "backward-euler", "dop853",           "radau5"};
    static const struct {
        const char *name;
        double value;
    } set[] = {{"m", 1}, {"k", 1}, {"k3", -1}, {"y0", 1}, {"v0", 1}};
    const double at = duffing_time();
    struct error error;
    struct scene scene;
    scene_init(&scene, NULL);
    for (size_t i = 0; i < COUNT_OF(set); i++)
        assert_true(scene_set(&scene, scene_param(&scene, set[i].name),
                              (struct measured){set[i].value, 0}, &error));
    for (size_t m = 0; m < COUNT_OF(methods); m++)
        for (int adapts = 0; adapts < 2; adapts++) {
            struct run *run = ended(&scene, methods[m], 1e-3, adapts ? 1e-6 : 0, 5);
            if (run->stop != STOP_SINGULAR || fabs(run->singular.t - at) > 1e-8)
                fail_msg("%s: %s at %.9g, singular at %.12g, not %.12g", methods[m],
                         stop_name(run->stop), run->t, run->singular.t, at);
            run_destroy(run);
        }
    assert_true(scene_set(&scene, scene_param(&scene, "v0"), (struct measured){-1, 0}, &error));
    struct run *run = ended(&scene, "rk4", 1e-3, 0, -5);
    assert_int_equal(run->stop, STOP_SINGULAR);
    assert_true(fabs(run->singular.t + at) < 1e-8);
    run_destroy(run);
}

/* Methods of fixed steps that get past the end of a solution, and go on. */
TEST(test_steps_across)
{
    const struct {
        const char *lines;
        double at;
    } scenes[] = {
        {"var x = 1;x' = x^2", 1},
        {"var x = 1;x' = -1/x", 0.5},
        {"var x = 1;x' = -1/x^2", 1 / 3.},
        {"var x = 1;var v = 0;x' = v;v' = -1/x^2", PI / sqrt(8)},
    };
    static const char *const methods[] = {"ros3p", "rodas4",         "rodas5p",  "rk4",
                                          "ab4",   "backward-euler", "trapezoid"};
    static const double steps[] = {1.3e-4, 1e-3, 7e-3, 1e-2, 3e-2};
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(scenes) * COUNT_OF(methods) * COUNT_OF(steps); i++) {
        const size_t s = i % COUNT_OF(scenes), m = i / COUNT_OF(scenes) % COUNT_OF(methods);
        const double dt = steps[i / COUNT_OF(scenes) / COUNT_OF(methods)];
        struct scene scene;
        typed_scene(models, &scene, scenes[s].lines);
        struct run *run = ended(&scene, methods[m], dt, 0, 2);
        if (run->stop != STOP_SINGULAR || fabs(run->singular.t - scenes[s].at) > 2 * dt)
            fail_msg("%s by %s, dt = %g: %s at %g, singular at %g", scenes[s].lines, methods[m], dt,
                     stop_name(run->stop), run->t, run->singular.t);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* A single step of a long run jumps across a pole, while the steps before and after it are smooth.
 * The pole must be found although only one row in a hundred is examined. */
TEST(test_one_step_of_many)
{
    static const char *const methods[] = {"ros3p", "rodas4", "rodas5p"};
    static const double steps[] = {1.7e-5, 1.3e-5, 0.9e-5};
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    typed_scene(models, &scene, "var x = 1;x' = x^2");
    for (size_t m = 0; m < COUNT_OF(methods); m++)
        for (size_t i = 0; i < COUNT_OF(steps); i++) {
            struct run *run = ended(&scene, methods[m], steps[i], 0, 2);
            if (run->stop != STOP_SINGULAR || fabs(run->singular.t - 1) > 2 * steps[i])
                fail_msg("%s, dt = %g: %s at %g, singular at %g", methods[m], steps[i],
                         stop_name(run->stop), run->t, run->singular.t);
            run_destroy(run);
        }
    typed_destroy(models);
}

/* Steps of fixed size that leave nothing of the values are seen, others are not taken for such. */
TEST(test_unsound_steps)
{
    static const struct {
        const char *lines, *preset, *by;
        double dt, span;
        bool unsound;
    } cases[] = {
        {NULL, "robertson", "ros3p", 5e-3, 1, true},
        {NULL, "robertson", "ros3p", 0.1, 1, true},
        {NULL, "robertson", "ros3p", 1, 1, true},
        {NULL, "robertson", "rodas4", 1e-2, 1, true},
        {NULL, "robertson", "trapezoid", 0.1, 1, true}, /* it rings across 0 */
        {NULL, "stiff-vanderpol", "ros3p", 0.1, 1000, true},
        {NULL, "robertson", "ros3p", 1e-4, 1, false},
        {NULL, "robertson", "rodas5p", 1e-3, 1, false},
        {NULL, "robertson", "backward-euler", 1e-2, 1, false},
        {NULL, "robertson", "backward-euler", 1, 10, false},
        {NULL, "robertson", "radau5", 0.1, 1, false},
        {NULL, "kepler", "euler", 0.05, 10, false},
        {NULL, "pendulum", "euler", 0.1, 10, false},
        {NULL, "vanderpol", "backward-euler", 0.1, 40, false},
        {NULL, "duffing", "symplectic-euler", 0.01, 20, false},
        {"var x = 0;x'' = 1 - x^3", NULL, "symplectic-euler", 0.01, 20, false}, /* begins at 0 */
        {"var x = 0;var v = 0;var a = 0;x' = v;v' = a;a' = 1 + 0*x^2", NULL, "backward-euler", 0.1,
         5, false},
        {"var x = 1;x' = -1e4*(x^3 - cos(t))", NULL, "backward-euler", 1e-2, 20, false},
        /* 1500 swings a step: more than the solution is followed for, so nothing is known */
        {"var x = 1;x'' = -1e12*sin(x)", NULL, "backward-euler", 0.01, 0.1, false},
        {"var x = 1;x'' = -1e12*x - x^3", NULL, "backward-euler", 0.01, 0.1, false},
        {"var x = 1;x'' = -1e12*sin(x)", NULL, "ros3p", 0.01, 0.1, false},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene scene;
        if (cases[i].lines)
            typed_scene(models, &scene, cases[i].lines);
        else
            scene_init(&scene, preset_by_name(text_of(cases[i].preset)));
        struct run *run = ended(&scene, cases[i].by, cases[i].dt, 0, cases[i].span);
        if (run->stop != STOP_END || (run->unsound.times > 0) != cases[i].unsound)
            fail_msg("%s by %s, dt = %g: %s, %g in place of %g at %g s",
                     cases[i].lines ? cases[i].lines : cases[i].preset, cases[i].by, cases[i].dt,
                     stop_name(run->stop), run->unsound.value, run->unsound.solution,
                     run->unsound.t);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* A method that is unstable, a scene that grows on and on, a step that is too large: none of them
 * is a blow-up. */
TEST(test_others)
{
    static const struct {
        const char *lines, *preset, *by;
        double dt, tol, span;
        enum stop stop;
    } cases[] = {
        {NULL, "spring", "euler", 0.01, 0, 2000, STOP_DIVERGED},
        {NULL, "spring", "rk4", 0.4, 0, 1e5, STOP_DIVERGED},
        {NULL, "inverted", "rk4", 0.01, 0, 1000, STOP_DIVERGED},
        {NULL, "inverted", "dop853", 0.01, 1e-6, 1000, STOP_DIVERGED},
        {NULL, "duffing", "rk4", 2, 0, 1e3, STOP_DIVERGED},
        {NULL, "duffing", "euler", 0.1, 0, 1e3, STOP_DIVERGED},
        {NULL, "vanderpol", "rk4", 1, 0, 100, STOP_DIVERGED},
        {NULL, "stiff-vanderpol", "rk4", 0.01, 0, 10, STOP_DIVERGED},
        {NULL, "robertson", "dopri5", 0.01, 0, 10, STOP_DIVERGED},
        {NULL, "robertson", "ros3p", 0.01, 0, 1,
         STOP_END}, /* what becomes of its first step would end */
        {NULL, "robertson", "ros3p", 0.1, 0, 1, STOP_END},
        {NULL, "kepler", "euler", 0.5, 0, 10, STOP_END},
        {NULL, "stiff-vanderpol", "radau5", 1e-4, 1e-6, 4000, STOP_END},
        {NULL, "stiff-vanderpol", "rodas5p", 1e-4, 1e-4, 4000, STOP_END},
        {NULL, "stiff-vanderpol", "tr-bdf2", 1e-4, 1e-3, 4000, STOP_END},
        {NULL, "vanderpol", "dopri5", 1e-2, 1e-3, 100, STOP_END},
        {NULL, "robertson", "radau5", 1e-4, 1e-6, 1e11, STOP_END},
        {NULL, "robertson", "tr-bdf2", 1e-4, 1e-3, 1e11, STOP_END},
        {NULL, "orego", "radau5", 1e-4, 1e-4, 360, STOP_END},
        {NULL, "orego", "rodas4", 1e-4, 1e-3, 360, STOP_END},
        {NULL, "extreme-comet", "dop853", 1e-6, 1e-8, 20, STOP_END},
        {NULL, "extreme-comet", "radau5", 1e-6, 1e-6, 20, STOP_END},
        {NULL, "kepler-eccentric", "dopri5", 1e-4, 1e-6, 20, STOP_END},
        {NULL, "extreme-wall", "radau5", 1e-3, 1e-6, 10, STOP_END},
        {NULL, "pendulum-driven", "gauss4", 0.1, 0, 100, STOP_END},
        {NULL, "drag", "trapezoid", 0.5, 0, 100, STOP_END},
        {"var x = 1;var v = 0;x' = v;v' = 1e4*(1 - x^2)*v - x", NULL, "radau5", 1e-4, 1e-6, 2e4,
         STOP_END},
        {"var x = 1;var v = 0;x' = v;v' = -sign(x)", NULL, "radau5", 1e-2, 1e-6, 50, STOP_END},
        {"var x = 1;var v = 0;x' = v;v' = -sign(x)", NULL, "rk4", 1e-1, 0, 50, STOP_END},
        {"var x = 1;x' = -1e4*(x^3 - cos(t))", NULL, "trapezoid", 1e-2, 0, 20, STOP_END},
        {"var x = 1;x' = -1e4*(x^3 - cos(t))", NULL, "radau5", 1e-2, 1e-3, 20, STOP_END},
        {"var x = 0.001;x' = 1e3*x*(1 - x)", NULL, "radau5", 1e-4, 1e-4, 10,
         STOP_END}, /* from nothing to all */
        {"var x = 0.001;x' = x^2 - x^3", NULL, "radau5", 1e-2, 1e-4, 3000,
         STOP_END}, /* the flame */
        {"var x = 1e-4;x' = x^2 - x^3", NULL, "tr-bdf2", 1e-2, 1e-4, 3e4, STOP_END},
        {"var x = 2;x' = x*log(x)", NULL, "dopri5", 0.01, 1e-6, 30, STOP_DIVERGED}, /* exp(exp t) */
        {"var x = 1;x' = x", NULL, "dopri5", 0.01, 1e-6, 1000, STOP_DIVERGED},
        {"var x = 1;x' = x*sqrt(1 + sin(x)^2)", NULL, "rk4", 0.01, 0, 1000, STOP_DIVERGED},
        {"var x = 1;x' = 50*(cos(x) - x^3)", NULL, "euler", 0.2, 0, 100, STOP_DIVERGED},
        /* Steep, or with an infinite slope that is passed. */
        {"var x = -3;x' = 1/(1e-8 + x^2)", NULL, "dop853", 0.01, 1e-3, 20, STOP_END},
        {"var x = -3;x' = 1/(1e-8 + x^2)", NULL, "rodas5p", 0.01, 1e-6, 20, STOP_END},
        {"var x = 1;x' = -1/(abs(x) + 1e-6)", NULL, "radau5", 0.01, 0.1, 1, STOP_END},
        {"var x = 1;x' = -x/(1e-12 + x^2)", NULL, "rodas5p", 0.01, 0.1, 2, STOP_END},
        {"var x = 1;x'' = -sign(x)/sqrt(abs(x))", NULL, "radau5", 0.01, 0.1, 5, STOP_END},
        {"var x = 0.01;x' = 0.001*exp(30*x)*(1 - x)", NULL, "rodas5p", 0.01, 1e-3, 100, STOP_END},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene scene;
        if (cases[i].lines)
            typed_scene(models, &scene, cases[i].lines);
        else
            scene_init(&scene, preset_by_name(text_of(cases[i].preset)));
        struct run *run = ended(&scene, cases[i].by, cases[i].dt, cases[i].tol, cases[i].span);
        if (run->stop != cases[i].stop)
            fail_msg("%s, %s: %s at t = %g", cases[i].lines ? cases[i].lines : cases[i].preset,
                     cases[i].by, stop_name(run->stop), run->t);
        run_destroy(run);
    }
    typed_destroy(models);
}

/* A pole ahead does not loosen the tolerance: sizes of a scene are not those that a trial meets
 * next to the pole. */
TEST(test_accuracy_before_a_pole)
{
    static const struct {
        const char *lines;
        double pole, power; /* x = (pole / (pole - t))^power from x = 1 */
    } solutions[] = {
        {"var x = 1;x' = x^2", 1, 1},
        {"var x = 1;x' = x^3", 0.5, 0.5},
        {"var x = 1;x' = 3 * x^1.5", 2 / 3.0, 2},
    };
    static const char *const methods[] = {"dopri5", "dop853", "odex", "radau5", "rodas5p"};
    const double tol = 1e-6;
    (void)state;
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < 3 * sizeof methods / sizeof *methods; i++) {
        struct scene scene;
        const double pole = solutions[i % 3].pole, power = solutions[i % 3].power;
        typed_scene(models, &scene, solutions[i % 3].lines);
        struct run *run = ended(&scene, methods[i / 3], 1e-3, tol, 0.8 * pole);
        /* A small change of the start has grown by dx/dx0 / x = 5 there, of each of some ten steps.
         */
        const double exact = pow(5, power), off = fabs(run->y[0] / exact - 1);
        if (run->stop != STOP_END || !(off < 100 * tol))
            fail_msg("%s, %s: %g in place of %g", solutions[i % 3].lines, methods[i / 3], run->y[0],
                     exact);
        run_destroy(run);
    }
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
