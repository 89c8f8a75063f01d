/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What is said of a run that failed, against what its solution does by a closed form: it goes to
 * infinity at a known time, its slope does, it grows without bound, or it goes on. Adaptive methods
 * at tolerances from 1e-3 to 1e-9, and methods of fixed steps. LONG=1 takes all combinations.
 */
#include "numerics/battery.h"

#include <stdio.h>

enum truth {
    POLE,  /* the solution goes to infinity at `t` */
    SLOPE, /* its slope does, and there is no solution beyond */
    GAP,   /* its slope does, at a time of its own: the solution goes on beyond */
    GROWS, /* it leaves the range of numbers, but at no finite time of its own */
    GOES_ON
};

static const struct failing {
    const char *lines;
    enum truth truth;
    double t, span;
} cases[] = {
    {"var x = 1;x' = x^2", POLE, 1, 3},
    {"var x = 1e8;x' = x^2", POLE, 1e-8, 3e-8},
    {"var x = 1e-6;x' = 1e-3*x^2", POLE, 1e9, 3e9},
    {"var x = 1;x' = x^3", POLE, 0.5, 2},
    {"var x = 0;x' = 1 + x^2", POLE, 1.5707963267948966, 3},
    {"var x = 1;var v = 2;x' = v;v' = 6*x^2", POLE, 1, 3},
    {"var x = 0;x' = 1/(1 - t)^2", POLE, 1, 2},
    {"var x = 0;x' = 1/(0.7 - t)^3", POLE, 0.7, 2},
    {"var x = 1;x' = x/(1.3 - t)", POLE, 1.3, 2},
    {"var x = 1;x' = x/(1.3e6 - t)", POLE, 1.3e6, 2e6},
    {"var x = 0;x' = 1/cos(t)^2", POLE, 1.5707963267948966, 3},
    {"var x = 1;x' = -1/x", SLOPE, 0.5, 2},
    {"var x = 2;x' = -x/(x - 1)", SLOPE, 0.3068528194400547, 2},
    {"var x = 0;x' = 1/sqrt(abs(1 - t))", GAP, 1, 2},
    {"var x = 0;x' = log(abs(t - 1))", GAP, 1, 2},
    {"var x = 1;x' = -x + 1/abs(t - 0.7)^0.6", GAP, 0.7, 2},
    {"var x = 1;x' = x", GROWS, NAN, 1000},
    {"var x = 2;x' = x*log(x)", GROWS, NAN, 30},
    {"var x = 1;x' = x*sqrt(1 + sin(x)^2)", GROWS, NAN, 1000},
    {"var x = 1e200;x' = -x", GOES_ON, NAN, 1},
    {"var x = 1e-310;x' = -x", GOES_ON, NAN, 1},
    {"var x = 1e-310;var v = 0;x' = v;v' = -x", GOES_ON, NAN, 1},
    {"var x = 1;x' = -1e308*x", GOES_ON, NAN, 1},
    {"var x = 1;x' = -1e6*(x - cos(t))", GOES_ON, NAN, 2},
    {"var x = 1;x' = 50*(cos(x) - x^3)", GOES_ON, NAN, 20},
    {"var x = 1;var v = 0;x' = v;v' = 1e4*(1 - x^2)*v - x", GOES_ON, NAN, 2},
};

static bool says(const char *words, const char *phrase)
{
    return strstr(words, phrase) != NULL;
}

/* The words are judged by what they claim, true for none of the other cases. */
static void judge(const struct failing *c, const struct run *run, const char *words,
                  const char *what)
{
    const bool infinite = says(words, "goes to infinity"), slope = says(words, "infinite slope"),
               grows = says(words, "itself grows"), on = says(words, "the solution continues");
    const bool near = fabs(run->singular.t - c->t) <= 1e-3 * fabs(c->t);
    const bool false_words =
        (infinite && !(c->truth == POLE && near)) ||
        (slope && !((c->truth == SLOPE || c->truth == GAP) && near)) ||
        (grows && c->truth != GROWS) || (on && c->truth != GOES_ON && c->truth != GROWS) ||
        (says(words, "larger tol") && run->settings.tol >= 1e-11) ||
        (says(words, "smaller tol") && c->truth != GOES_ON) || says(words, "seems to leave");
    if (false_words)
        fail_msg("%s: %s", what, words);
}

/* One that got to its end has passed what it cannot have passed, or has found nothing. */
static bool passed(const struct failing *c, const struct run *run)
{
    return c->truth == POLE && run->plan.adaptive && run->stop == STOP_END;
}

TEST(test_words)
{
    static const char *const adaptive[] = {"dopri5", "radau5",           "dop853", "rodas5p",
                                           "odex",   "bogacki-shampine", "tsit5"};
    static const char *const fixed[] = {"rk4",    "euler", "backward-euler", "gauss4",
                                        "rodas4", "bdf2",  "trapezoid"};
    static const double tols[] = {1e-3, 1e-6, 1e-9};
    struct typed_models *models = typed_create(&(struct error){0});
    int failures = 0, runs = 0, named = 0;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct scene scene = typed_scene(models, cases[i].lines);
        for (size_t k = 0; k < COUNT_OF(adaptive) * COUNT_OF(tols) + 2 * COUNT_OF(fixed); k++) {
            if (!is_long() && (i + k) % 3 != 0)
                continue;
            const bool adapts = k < COUNT_OF(adaptive) * COUNT_OF(tols);
            const size_t m = adapts ? k / COUNT_OF(tols) : k - COUNT_OF(adaptive) * COUNT_OF(tols);
            const char *by = adapts ? adaptive[m] : fixed[m / 2];
            const double tol = adapts ? tols[k % COUNT_OF(tols)] : 0,
                         dt = cases[i].span / (adapts  ? 1000
                                               : m % 2 ? 200
                                                       : 317.3);
            const struct run_target target = {.t = cases[i].span, .steps = 30000};
            struct run *run =
                start(&scene, by, (struct run_settings){.dt = dt, .tol = tol}, cases[i].span);
            while (run_advance(run, &target, 0, NULL)) {
            }
            run_diagnose(run);
            struct buffer words = {0};
            char what[300];
            snprintf(what, sizeof what, "%s by %s, dt = %g, tol = %g", cases[i].lines, by, dt, tol);
            run_explain(run, &words);
            runs++;
            if (passed(&cases[i], run) && run->t == cases[i].span)
                fail_msg("%s: passed the pole", what);
            if (stop_is_failure(run->stop)) {
                failures++;
                named += run->stop == STOP_SINGULAR;
                judge(&cases[i], run, buffer_view(&words), what);
            }
            buffer_free(&words);
            run_destroy(run);
        }
    }
    typed_destroy(models);
    print_message("%d runs, %d failed, %d with a singularity named\n", runs, failures, named);
    assert_true(failures > runs / 3 && named > runs / 4);
}

RUN_TESTS(NULL, NULL)
