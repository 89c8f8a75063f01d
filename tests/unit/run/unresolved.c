/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces that repeat between the points of a step, and pulses in a step, are said to be missed, and
 * no others are. */
#include "unit/run/fixture.h"

#include <hooke/base/numeric.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/typed.h>

#include "unit/scene/typing.h"

static bool misses(const char *force, const char *method, double dt, double end, double *shorter)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene = spring();
    const struct typed_line typed = typing_line(text_of(force));
    const struct model *model = typed_add(models, scene.model, &typed, &error);
    assert_non_null(model);
    scene_remodel(&scene, model);
    struct run *run = start(&scene, method, (struct run_settings){.dt = dt}, end);
    go_to(run, end);
    const bool missed = run_force_unresolved(run, shorter);
    run_destroy(run);
    typed_destroy(models);
    return missed;
}

/* 20 frequencies, 3 forms and 4 methods; steps of whole periods and of a twentieth. */
TEST(test_steps_of_whole_periods)
{
    static const char *const methods[] = {"euler", "heun", "rk4", "gauss6"};
    for (int i = 0; i < 20; i++)
        for (size_t form = 0; form < 3; form++) {
            const double f = pow(10, 0.3 + 0.2 * i), period = 1 / f;
            const char *method = methods[(i + (int)form) % (int)COUNT_OF(methods)];
            char force[80];
            double shorter, none;
            snprintf(force, sizeof force,
                     form == 0   ? "force 0.1*sin(%.17g*t)^2"
                     : form == 1 ? "force 0.1*cos(%.17g*t)"
                                 : "force 0.1 + y*sin(%.17g*t + 1)",
                     2 * PI * f);
            if (!misses(force, method, (1 + i % 3) * period, 60 * period, &shorter))
                fail_msg("%s, %s: nothing is said", force, method);
            if (!(shorter < 0.5 * period))
                fail_msg("%s, %s: dt <= %g is no help", force, method, shorter);
            if (misses(force, method, period / 20, 10 * period, &none))
                fail_msg("%s, %s: a twentieth of a period is enough", force, method);
        }
}

/* What a pulse does to the spring until the end, in units of the amplitude: an integral over it by
 * the midpoint rule, which has all digits there. kick [2] of y and v/omega. */
static void pulse_response(bool bell, double force, double middle, double width, double end,
                           double *kick)
{
    enum { PIECES = 20000 };
    const double omega = sqrt(75), mass = 0.2, by = end / PIECES;
    kick[0] = kick[1] = 0;
    for (int k = 0; k < PIECES; k++) {
        const double t = (k + 0.5) * by, x = (t - middle) / width,
                     f = force * (bell ? exp(-x * x) : 1 / (1 + x * x * x * x)),
                     part = f / (mass * omega) * by / 0.05;
        kick[0] += part * sin(omega * (end - t));
        kick[1] += part * cos(omega * (end - t));
    }
}

/* Returns how far what a run makes of the pulse is from that, and whether it is said. */
static double off_by_pulse(const char *line, const char *method, double dt, double end,
                           const double *kick, bool *said)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene = spring();
    struct run *without = start(&scene, method, (struct run_settings){.dt = dt}, end);
    const struct typed_line typed = typing_line(text_of(line));
    const struct model *model = typed_add(models, scene.model, &typed, &error);
    assert_non_null(model);
    scene_remodel(&scene, model);
    struct run *with = start(&scene, method, (struct run_settings){.dt = dt}, end);
    struct burst missed;
    double shorter;
    go_to(without, end);
    go_to(with, end);
    *said = run_force_unresolved(with, &shorter) || run_missed_burst(with, &missed);
    const double y = (with->y[0] - without->y[0]) / 0.05 - kick[0],
                 v = (with->y[1] - without->y[1]) / sqrt(75) / 0.05 - kick[1];
    run_destroy(with);
    run_destroy(without);
    typed_destroy(models);
    return hypot(y, v);
}

/* Methods whose steps of 50 ms have next to no error of their own. */
TEST(test_pulses)
{
    static const char *const methods[] = {"rk4", "rk38", "gauss4", "gauss6"};
    uint64_t seed = 5;
    int wrong = 0, right = 0;
    for (int i = 0; i < 160; i++) {
        const double dt = i % 2 ? 0.01 : 0.05, end = 5, middle = 1 + 3 * random_fraction(&seed),
                     width = dt * pow(10, -1.3 + 1.8 * random_fraction(&seed)),
                     force = 0.004 / width;
        const bool bell = i % 3 != 0;
        const char *method = methods[i / 2 % (int)COUNT_OF(methods)];
        char line[160];
        double kick[2];
        bool said;
        snprintf(line, sizeof line,
                 bell ? "force %.17g*exp(-((t - %.17g)/%.17g)^2)"
                      : "force %.17g/(1 + ((t - %.17g)/%.17g)^4)",
                 force, middle, width);
        pulse_response(bell, force, middle, width, end, kick);
        const double off = off_by_pulse(line, method, dt, end, kick, &said);
        wrong += off > 0.05;
        right += off < 0.001;
        if (off > 0.05 && !said)
            fail_msg("%s, dt = %g, %s: off by %g, and nothing is said", method, dt, line, off);
        if (off < 0.001 && said)
            fail_msg("%s, dt = %g, %s: off by %g, and called missed", method, dt, line, off);
    }
    print_message("# %d wrong, %d right\n", wrong, right);
    assert_true(wrong >= 20 && right >= 60);
}

RUN_TESTS(NULL, NULL)
