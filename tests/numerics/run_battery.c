/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Adaptive methods where they could be silently wrong: pendulums from many angles, soft springs, switches. Each answer
 * is a closed form, or says where it is from. LONG=1 takes all methods, tolerances and angles.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "unit/run_fixture.h"
#include "unit/scene_typing.h"

#include <float.h>
#include <stdlib.h>

static bool is_long(void)
{
    const char *set = getenv("LONG");
    return set && *set;
}

/* A scene of lines "var x = 1;x'' = -x". */
static struct scene typed_scene(struct typed_models *models, const char *lines)
{
    struct scene scene;
    struct text rest = text_of(lines), line;
    struct error error = {0};
    scene_init(&scene, NULL);
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene.model, &typed, &error);
        if (!model)
            fail_msg("%.*s: %s (%s)", (int)line.len, line.at, error.text, error.hint);
        scene_remodel(&scene, model);
    }
    return scene;
}

/* The run at t, however it stopped. */
static struct run *reach(const struct scene *scene, const char *method, double tol, double first, double t)
{
    const struct run_settings settings = {.dt = first, .tol = tol, .record = {RECORD_EVERY, INT64_MAX, 0}};
    struct run *run = start(scene, method, settings, t);
    go_to(run, t);
    return run;
}

/* Second order: 1e-12 takes a million steps. */
static double tightest(const char *method)
{
    return strcmp(method, "tr-bdf2") == 0 || strcmp(method, "bogacki-shampine") == 0 ? 1e-7 : 1e-12;
}

/* ---- Newton's iteration: what it accepts ---- */

/*
 * theta'' = -sin(theta) from rest: sin(theta/2) = k cd(t | k), k = sin(theta0/2). Jacobi's functions by the
 * arithmetic-geometric mean (Abramowitz, Stegun 1964, 16.4).
 */
static double pendulum_angle(double theta0, double t)
{
    enum { LEVELS = 12 };
    double a[LEVELS + 1], c[LEVELS + 1], k = sin(theta0 / 2), b = cos(theta0 / 2);
    a[0] = 1;
    c[0] = k;
    for (int i = 0; i < LEVELS; i++) {
        a[i + 1] = (a[i] + b) / 2;
        c[i + 1] = (a[i] - b) / 2;
        b = sqrt(a[i] * b);
    }
    double phi = ldexp(a[LEVELS] * t, LEVELS);
    for (int i = LEVELS; i > 0; i--)
        phi = (phi + asin(c[i] / a[i] * sin(phi))) / 2;
    const double sn = sin(phi), cn = cos(phi), dn = sqrt(1 - k * k * sn * sn);
    return 2 * asin(k * cn / dn);
}

/*
 * From 60 angles, 0.1 to 3.05 rad, to t = 50. Errors grow with the time and with how much the period depends on the
 * amplitude, which goes like 1/(pi - theta0); runs that are wrong are off by radians.
 */
static void test_pendulums(void **state)
{
    (void)state;
    static const char *const names[] = {"radau5", "tr-bdf2", "rodas5p", "dopri5"};
    static const double tols[] = {1e-4, 1e-6, 1e-7};
    int wrong = 0;
    for (size_t m = 0; m < (is_long() ? COUNT_OF(names) : 2); m++)
        for (size_t k = 0; k < COUNT_OF(tols); k++)
            for (int i = 0; i < 60; i += m == 0 || is_long() ? 1 : 7) {
                if (m == 1 && k > 1 && !is_long())
                    continue;
                struct scene scene;
                scene_init(&scene, (const struct preset *)(const void *)catalog_find(&preset_catalog,
                                                                                     TEXT("pendulum")));
                const double theta0 = 0.1 + 3.0 * i / 60;
                scene.value[scene_param(&scene, "length")] = 9.81;
                scene.value[scene_param(&scene, "theta0")] = theta0;
                struct run *run = reach(&scene, names[m], tols[k], 1e-6, 50);
                const double error = fabs(run->y[0] - pendulum_angle(theta0, 50)) / tols[k];
                if (run->stop != STOP_END || !(error < 300 / (M_PI - theta0))) {
                    print_message("%s, tol %g, from %g rad: %s, error %.3g tol\n", names[m], tols[k], theta0,
                                  stop_name(run->stop), error);
                    wrong++;
                }
                run_destroy(run);
            }
    assert_int_equal(wrong, 0);
}

struct lines_case {
    const char *lines;
    double t, x; /* x there */
    double most; /* error in units of the tolerance */
};

/* Wrong at exit status 0 while Newton's iteration went by the rate of the first step.. */
static void test_smooth_scenes_of_radau(void **state)
{
    (void)state;
    static const struct lines_case cases[] = {
        {"var x = 2.5;x'' = -sin(x) - 0.05*x'", 100, 0.1345, 1e3},
        {"var x = 0.9;x'' = -x + x^3", 50, -0.2968, 1e3},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct scene scene = typed_scene(models, cases[i].lines);
        struct run *judge = reach(&scene, "dop853", 1e-13, 1e-3, cases[i].t);
        assert_close(judge->y[0], cases[i].x, 6e-5);
        static const char *const names[] = {"radau5", "tr-bdf2", "rodas4"};
        for (size_t m = 0; m < COUNT_OF(names); m++)
            for (double tol = 1e-4; tol > tightest(names[m]); tol /= 10)
                for (double first = 1e-12; first < 2e3; first *= 1e5) {
                    struct run *run = reach(&scene, names[m], tol, first, cases[i].t);
                    assert_int_equal(run->stop, STOP_END);
                    if (!(fabs(run->y[0] - judge->y[0]) < cases[i].most * tol))
                        fail_msg("%s by %s, tol %g, first step %g: %.17g", cases[i].lines, names[m], tol, first,
                                 run->y[0]);
                    run_destroy(run);
                }
        run_destroy(judge);
    }
    typed_destroy(models);
}

/* ---- switches ---- */

static double jump(double t)
{
    return t < 3.3 ? t : 3.3 - 2 * (t - 3.3);
}

static double rectified(double t)
{
    const double whole = floor(t);
    return (2 * whole + 1 - cos(M_PI * (t - whole))) / M_PI;
}

/*
 * Switches that the equations do not show: what is left is the method's own estimate of the error, which did not see
 * the last twelfth of a step.
 */
static void test_odex_sees_hidden_switches(void **state)
{
    (void)state;
    static const struct {
        const char *lines;
        double t, (*exact)(double t);
    } hidden[] = {
        {"var x = 0;x' = 1.5*tanh(1e200*(3.3 - t)) - 0.5", 10, jump},
        {"var x = 0;x' = sqrt(sin(pi*t)^2)", 20.3, rectified},
    };
    struct error error;
    struct typed_models *models = typed_create(&error);
    int wrong = 0;
    for (size_t i = 0; i < COUNT_OF(hidden); i++) {
        const struct scene scene = typed_scene(models, hidden[i].lines);
        for (double tol = 1e-3; tol > 0.9e-12; tol /= 10)
            for (double first = 1e-9; first < 20; first *= is_long() ? 3 : 100) {
                struct run *run = reach(&scene, "odex", tol, first, hidden[i].t);
                const double off = fabs(run->y[0] - hidden[i].exact(hidden[i].t)) / fmax(tol, 1e-13);
                if (run->stop != STOP_END || !(off < 1e3)) {
                    print_message("%s, tol %g, first step %g: %s, error %.3g tol, %lld steps\n", hidden[i].lines, tol,
                                  first, stop_name(run->stop), off, (long long)run->steps);
                    wrong++;
                }
                run_destroy(run);
            }
    }
    typed_destroy(models);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pendulums),
        cmocka_unit_test(test_smooth_scenes_of_radau),
        cmocka_unit_test(test_odex_sees_hidden_switches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
