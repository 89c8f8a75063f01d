/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Steps of fixed size in typed equations that switch (if, abs, sign, ...): each ends at a switch,
 * so that methods keep their order, unless they go across. Solutions in closed form, piece by
 * piece.
 */
#include "long_form.h"
#include "numerics/references.h"
#include "unit/scene/typing.h"

#include <hooke/base/fields.h>

struct problem {
    const char *const *lines;
    double span;
    void (*truth)(double t, double *y);
};

/* A spring ten times as stiff on one side: half a period pi and half a period pi/10. */
static void two_springs(double t, double *y)
{
    const double half = M_PI, rest = fmod(t + half / 2, half * 1.1);
    const bool soft = rest < half;
    y[0] = soft ? sin(rest) : -0.1 * sin(10 * (rest - half));
    y[1] = soft ? cos(rest) : -cos(10 * (rest - half));
}

/* Growth at a rate that jumps at x = 2. */
static void two_rates(double t, double *y)
{
    const double at = log(2);
    y[0] = t < at ? exp(t) : 2 * exp(-0.7 * (t - at));
}

/* Thrown up under a weight that jumps with the position: parts of cosines about other centres. */
static void two_weights(double t, double *y)
{
    const double turn = 2 * acos(0.5 / 1.5), rest = fmod(t, 2 * turn), sign = rest < turn ? 1 : -1;
    const double s = rest < turn ? rest : rest - turn, phase = acos(0.5 / 1.5);
    y[0] = sign * (1.5 * cos(s - phase) - 0.5);
    y[1] = -sign * 1.5 * sin(s - phase);
}

static const struct problem problems[] = {
    {(const char *const[]){"var x = 1", "var v = 0", "x' = v", "v' = -x - if(x < 0, 99*x, 0)",
                           NULL},
     10, two_springs},
    {(const char *const[]){"var x = 1", "x'' = -x - if(x < 0, 99*x, 0)", NULL}, 10, two_springs},
    {(const char *const[]){"var x = 1", "x' = if(t < log(2), x, -0.7*x)", NULL}, 3, two_rates},
    {(const char *const[]){"var x = 0", "var x' = 1.4142135623730951", "x'' = -x - 0.5*sign(x)",
                           NULL},
     7, two_weights},
};

static struct run *begin(struct typed_models *models, const struct problem *problem,
                         const struct method *method, struct run_settings settings, bool across)
{
    struct scene scene;
    struct error error;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, problem->lines));
    scene.steps_across_kinks = across;
    return run_create(&scene, method, &settings, problem->span, &error);
}

static struct run *solve(struct typed_models *models, const struct problem *problem,
                         const struct method *method, int steps, bool across)
{
    const struct run_settings settings = {.dt = problem->span / steps, .compensated = true};
    struct run *run = begin(models, problem, method, settings, across);
    const struct run_target target = {.t = problem->span, .steps = -1};
    if (run)
        run_advance(run, &target, 0, NULL);
    return run;
}

static double end_error(struct typed_models *models, const struct problem *problem,
                        const struct method *method, int steps, bool across, bool *meets)
{
    struct run *run = solve(models, problem, method, steps, across);
    double y[2], error = NAN;
    *meets = false;
    if (!run)
        return NAN;
    *meets = across || method_meets_switches(method, &run->system);
    problem->truth(problem->span, y);
    if (run->stop == STOP_END) {
        error = fabs(run->y[0] - y[0]);
        if (run->system.n == 2)
            error = fmax(error, fabs(run->y[1] - y[1]));
    }
    run_destroy(run);
    return error;
}

#define DOUBLINGS 2

/* NAN: the method does not take it, or goes across; HUGE_VAL: it is right to rounding. */
static double order_of(struct typed_models *models, const struct problem *problem,
                       const struct method *method, bool across)
{
    double error[DOUBLINGS + 1];
    bool meets;
    for (int k = 0; k <= DOUBLINGS; k++) {
        error[k] =
            end_error(models, problem, method,
                      (method->order > 5 && !(method->flags & METHOD_MULTISTEP) ? 100 : 800) << k,
                      across, &meets);
        if (!meets)
            return NAN;
    }
    return error[DOUBLINGS] < 1e-11 ? HUGE_VAL : log2(error[0] / error[DOUBLINGS]) / DOUBLINGS;
}

/* Each method on one of the problems; LONG=1: on all of them. */
TEST(test_methods_keep_their_order)
{
    struct typed_models *models = *state;
    int count = 0, wrong = 0;
    for (size_t i = 0; i < method_catalog.count; i++)
        for (size_t k = 0; k < COUNT_OF(problems); k++) {
            const struct method *method = method_at(i);
            if (method->flags & METHOD_EXTERNAL || (!is_long() && k != i % COUNT_OF(problems)))
                continue;
            const double order = order_of(models, &problems[k], method, false);
            if (isnan(order))
                continue;
            const bool bad = !(order > method->order - 0.5);
            if (bad || getenv("VERBOSE"))
                print_message("%-18s %zu: order %d, measured %.2f%s\n", method->row.name, k,
                              method->order, order, bad ? ": wrong" : "");
            wrong += bad;
            count++;
        }
    assert_true(count >= 30);
    assert_int_equal(wrong, 0);
}

static const struct method *method_of(const char *name)
{
    return method_by_name(text_of(name));
}

/* Across the jump they are of the first order at best. */
TEST(test_across)
{
    struct typed_models *models = *state;
    bool ignored;
    const struct method *rk4 = method_of("rk4");
    assert_true(order_of(models, &problems[2], rk4, true) < 2);
    assert_true(end_error(models, &problems[2], rk4, 700, true, &ignored) > 1e-5);
    assert_true(end_error(models, &problems[2], rk4, 700, false, &ignored) < 1e-11);
}

/* Both sides lead back: x stays where it is, and the run knows. */
TEST(test_slides)
{
    struct typed_models *models = *state;
    static const char *const names[] = {"euler",          "rk4",    "dopri5",  "dop853",
                                        "backward-euler", "gauss4", "rodas5p", "ab4"};
    const struct problem slide = {(const char *const[]){"var x = 0.503", "var y = 0",
                                                        "x' = 0.5 - sign(x)", "y' = 1 + x", NULL},
                                  3, NULL};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (int steps = 7; steps < 300; steps *= 5) {
            struct run *run = solve(models, &slide, method_of(names[i]), steps, false);
            assert_non_null(run);
            assert_int_equal(run->stop, STOP_END);
            assert_true(fabs(run->y[0]) < 1e-14);
            if (method_of(names[i])->order > 1) /* 0.503 of area until then */
                assert_true(fabs(run->y[1] - 3 - 0.503 * 1.006 / 2) < 1e-12);
            assert_true(run->controller.switches.slides > 0);
            assert_true(fabs(run->controller.switches.slid - 1.006) < 1e-12);
            run_destroy(run);
        }
}

/*
 * Forces that draw to a switch from both sides change the velocity, not the position that the
 * switch is in: at rest on it the motion stays there as long as they hold it.
 */
static void rest(double t, double *y)
{
    (void)t;
    y[0] = 0;
}

static void rest_beside(double t, double *y)
{
    (void)t;
    y[0] = 0.7;
}

/* The mean of the sign along y = 0 is 0.4 x. */
static void rest_across(double t, double *y)
{
    y[0] = 0.28 * (1 - cos(t));
    y[1] = 0.7 * sin(t);
    y[2] = 0.7 * cos(t);
    y[3] = y[4] = 0;
}

static void too_strong(double t, double *y)
{
    y[0] = 0.3 * (1 - cos(t));
}

static void breaks_away(double t, double *y)
{
    y[0] = t < 2.5 ? 0 : 0.2 * pow(t - 2.5, 3) / 6;
}

static void goes_along(double t, double *y)
{
    y[0] = t;
}

static void on_a_circle(double t, double *y)
{
    y[0] = cos(t);
    y[1] = sin(t);
    y[2] = -sin(t);
    y[3] = cos(t);
}

#define RESTS(...)                                                                                 \
    (const char *const[])                                                                          \
    {                                                                                              \
        __VA_ARGS__, NULL                                                                          \
    }

static const struct {
    struct problem problem;
    int compared;
    bool slides;
} resting[] = {
    {{RESTS("var x = 0", "x'' = -x - 0.5*sign(x)"), 5, rest}, 1, true},
    {{RESTS("var x = 0", "x'' = -x - 0.5*sign(x) + 0.2"), 5, rest}, 1, true},
    {{RESTS("var x = 0", "var v = 0", "x' = v", "v' = -x - if(x > 0, 0.7, -0.3)"), 5, rest},
     1,
     true},
    {{RESTS("var x = 0", "x'' = -x - 0.5*sign(x) + 0.2*cos(3*t)"), 5, rest}, 1, true},
    {{RESTS("var x = 0.7", "x'' = -x - 0.5*sign(x - 0.7) + 0.6"), 5, rest_beside}, 1, true},
    {{RESTS("var z = 0", "var x = 0", "var u = 0.7", "var y = 0", "var w = 0", "z' = sign(y)",
            "x' = u", "u' = -x", "y' = w", "w' = -0.5*sign(y) + 0.2*x"),
      5, rest_across},
     5,
     true},
    {{RESTS("var x = 0", "x'' = -x - 0.5*sign(x) + 0.8"), 5, too_strong}, 1, false},
    {{RESTS("var x = 0", "x'' = -0.5*sign(x) + 0.2*t"), 5, breaks_away}, 1, true},
    {{RESTS("var x = 0", "var x' = 1", "x'' = 0.2 - 0.5*sign(x - t)"), 5, goes_along}, 1, true},
    {{RESTS("var x = 1", "var y = 0", "var u = 0", "var w = 1", "x' = u", "y' = w",
            "u' = -20*x*sign(x^2 + y^2 - 1)", "w' = -20*y*sign(x^2 + y^2 - 1)"),
      5, on_a_circle},
     4,
     true},
    {{RESTS("var x = 0", "var x' = 1", "x'' = -sign(x) - 0.5*sign(x')"), 5, rest}, 1, true},
};

static int test_rest(struct typed_models *models, const struct method *method, size_t k, double tol)
{
    const struct problem *problem = &resting[k].problem;
    const struct run_settings fixed = {.dt = problem->span / 200},
                              adaptive = {.dt = 0.01, .tol = tol};
    struct run *run = begin(models, problem, method, tol > 0 ? adaptive : fixed, false);
    const struct run_target target = {.t = problem->span, .steps = 20000};
    double y[LIMIT_VARIABLES], off = 0;
    if (!run)
        return 0;
    run_advance(run, &target, 0, NULL);
    problem->truth(problem->span, y);
    for (int i = 0; i < resting[k].compared; i++)
        off = fmax(off, fabs(run->y[i] - y[i]));
    const double h = problem->span / 200,
                 max = tol > 0 ? 100 * tol
                               : fmax((method->order == 1 ? 10 : 2) * pow(h, method->order), 1e-9);
    const struct switches_state *switches = &run->controller.switches;
    const bool slides = switches->slides + switches->piles > 0, piles = k + 1 == COUNT_OF(resting);
    /* whose paths are no parabolas */
    const bool said = slides == resting[k].slides || (piles && method->order == 1);
    const bool bad = run->stop != STOP_END || !(off < max) || !said || switches->crossings > 0;
    if (bad || getenv("VERBOSE"))
        print_message("%s, tol %g, scene %zu: t = %g s after %lld steps, off by %.3g, slides %lld, "
                      "across %lld\n",
                      method->row.name, tol, k, run->t, (long long)run->steps, off,
                      (long long)switches->slides, (long long)switches->crossings);
    run_destroy(run);
    return bad;
}

/* Returns true for methods whose error at a switch is tested with scene k: all of them in the long
 * form, a third in the quick one. The choice depends on the name only, so that another method in
 * the catalogue changes nothing. Methods from outside step over switches in their own way. */
static bool is_sampled(const struct method *method, size_t k)
{
    const struct text name = text_of(method->row.name);
    return method->flags & METHOD_ADAPTIVE && !(method->flags & METHOD_NO_VELOCITY) &&
           !(method->flags & METHOD_EXTERNAL) && (is_long() || (bytes_sum(name) + k) % 3 == 0);
}

/* LONG=1: at more tolerances. */
TEST(test_rests)
{
    static const char *const fixed[] = {"rk4", "euler",  "dopri5", "gauss4", "backward-euler",
                                        "ab4", "rodas5p"};
    static const double tols[] = {1e-7, 1e-4, 1e-10};
    int wrong = 0;
    for (size_t k = 0; k < COUNT_OF(resting); k++) {
        for (size_t m = 0; m < method_catalog.count; m++)
            for (size_t i = 0; i < (is_long() ? COUNT_OF(tols) : 1); i++)
                if (is_sampled(method_at(m), k) && (method_at(m)->order > 2 || tols[i] > 1e-8))
                    wrong += test_rest(*state, method_at(m), k, tols[i]);
        for (size_t m = is_long() ? 0 : k % 2; m < COUNT_OF(fixed); m += is_long() ? 1 : 2)
            wrong += test_rest(*state, method_of(fixed[m]), k, 0);
    }
    assert_int_equal(wrong, 0);
}

/*
 * First steps far too long or too short: what a step that is wrong as a whole says about a switch
 * inside it counts for nothing. The first scene, by dop853 with 30 s, was taken for over at once in
 * each of 200 000 steps; its end is by DOP853 of SciPy from switch to switch, at 1e-12.
 */
static void wall_at_20(double t, double *y)
{
    (void)t;
    y[0] = -0.0329981341;
    y[1] = 0.0183662491;
}

static const struct problem wall = {
    (const char *const[]){
        "var x = 0.3799", "var w = 0.409", "x' = w",
        "w' = -4.317*x + 0.2316*(1 - x^2)*w - 0.4857*w - 22.38*max(x - 0.4017, 0)", NULL},
    20, wall_at_20};

TEST(test_first_steps)
{
    struct typed_models *models = *state;
    static const double first[] = {1e-12, 1e-6, 1e-3, 0.1, 3, 30, 1e3}, tol = 1e-5;
    const struct problem *const switching[] = {&wall, &problems[0]};
    int wrong = 0, count = 0;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (size_t k = 0; k < COUNT_OF(switching) * COUNT_OF(first); k++) {
            const struct problem *problem = switching[k % 2];
            const double dt = first[k / 2];
            if (!(method_at(m)->flags & METHOD_ADAPTIVE) ||
                method_at(m)->flags & METHOD_NO_VELOCITY)
                continue;
            struct run *run = begin(models, problem, method_at(m),
                                    (struct run_settings){.dt = dt, .tol = tol}, false);
            const struct run_target steps = {.t = problem->span, .steps = 100000};
            double y[2];
            assert_non_null(run);
            run_advance(run, &steps, 0, NULL);
            problem->truth(problem->span, y);
            const double off = fmax(fabs(run->y[0] - y[0]), fabs(run->y[1] - y[1]));
            if (run->stop != STOP_END || run->t != problem->span || !(off < 100 * tol)) {
                print_message("%s, first step %g s: t = %g s after %lld steps, off by %.3g\n",
                              method_at(m)->row.name, dt, run->t, (long long)run->steps, off);
                wrong++;
            }
            count++;
            run_destroy(run);
        }
    assert_true(wrong == 0 && count > 0);
}

/* A run that is advanced step by step, in 100 calls, has the same rows as one advanced in a single
 * call. */
TEST(test_calls)
{
    struct typed_models *models = *state;
    static const char *const names[] = {"rk4", "dop853", "gauss6", "ab4", "verlet"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct run *whole = solve(models, &problems[1], method_of(names[i]), 100, false);
        struct run *parts = solve(models, &problems[1], method_of(names[i]), 100, false);
        assert_true(whole && parts);
        run_back(parts, 100);
        for (int k = 0; k < 100; k++)
            go_steps(parts, 1);
        assert_same_trace(whole, parts);
        run_destroy(whole);
        run_destroy(parts);
    }
}

static int setup(void **state)
{
    struct error error;
    *state = typed_create(&error);
    return *state ? 0 : -1;
}

static int teardown(void **state)
{
    typed_destroy(*state);
    return 0;
}

RUN_TESTS(setup, teardown)
