/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One judgement of which part of a recording is the free oscillation: every command that works on a
 * window announces the one of 'data clean', for the same reason, and nothing where there is nothing
 * to say.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"
#include "modules/recording/analysis/testing.h"

enum { SAMPLES = 1500, SAMPLES_SHORT = 750 };

#define RATE 50.0
#define PERIOD 0.9
#define LAST ((SAMPLES - 1) / RATE)

static double swing(double t)
{
    return 20 + 5 * exp(-0.02 * t) * cos(2 * 3.14159265358979323846 * t / PERIOD + 0.4);
}

static double free_swing(double t)
{
    return swing(t);
}

static double held_first(double t) /* a hand holds it, then lets go */
{
    return t < 4 ? 25 : swing(t);
}

static double noise_first(double t) /* started long before the release */
{
    return t < 6 ? 20 : swing(t - 6);
}

static double rest_last(double t)
{
    return t > 20 ? 20 : swing(t);
}

static double hand_last(double t) /* caught and put away */
{
    return t > 24 ? 20 + 9 * (t - 24) * (t - 24) / 36 : swing(t);
}

static double both_ends(double t)
{
    return t < 4 ? 25 : t > 25 ? 12 : swing(t);
}

static double bump(double t) /* somebody pushes the table */
{
    return swing(t) + 6 * exp(-50 * (t - 14) * (t - 14));
}

static double jump(double t) /* the sensor is moved */
{
    return swing(t) + (t > 15 ? 3 : 0);
}

static double flat(double t)
{
    return fmin(swing(t), 22.5);
}

static double coarse(double t) /* a resolution of 1 cm is no clipping */
{
    return nearbyint(swing(t));
}

static double beats(double t)
{
    return 20 + 2.5 * (cos(6.9 * t) + cos(7.4 * t));
}

static const struct shape {
    const char *name;
    double (*at)(double t);
    /* [s] of the truth, 0 and LAST: all of it; NAN: anything, as long as all say the same */
    double from, to;
} shapes[] = {
    {"free", free_swing, 0, LAST},
    {"held first", held_first, 4, LAST},
    {"noise first", noise_first, 6, LAST},
    {"rest last", rest_last, 0, 20},
    {"hand last", hand_last, 0, 24},
    {"both ends", both_ends, 4, 25},
    {"bump", bump, NAN, NAN},
    {"jump", jump, NAN, NAN},
    {"flat", flat, 0, LAST},
    {"coarse", coarse, 0, LAST},
    {"beats", beats, 0, LAST},
};

static const char *const commands[] = {
    "fit",
    "fit sine",
    "fit drag",
    "fit law",
    "fit modes 2",
    "fit scene",
    "measure period",
    "measure decay",
    "measure frequency",
    "measure amplitude",
    "measure repeat rec windows=2",
};

/* Of the same length in both forms. */
static void write_recording(const struct shape *shape)
{
    const int samples = is_long() ? SAMPLES : SAMPLES_SHORT;
    FILE *file = fopen("rec.csv", "w");
    assert_non_null(file);
    random_state = 17;
    fprintf(file, "t (s),y (cm)\n");
    for (int i = 0; i < samples; i++) {
        const double t = LAST * i / (samples - 1);
        fprintf(file, "%.5f,%.4f\n", t, shape->at(t) + 0.02 * random_normal());
    }
    assert_int_equal(fclose(file), 0);
}

/* Reads the window behind `word`, whose ends are separated by `mark`. Returns false if there is
 * none. */
static bool announced(const char *text, const char *word, const char *mark, double window[2])
{
    const char *at = strstr(text, word), *dots = at ? strstr(at, mark) : NULL;
    char first[32] = "";
    if (!dots || dots - at - (ptrdiff_t)strlen(word) >= (ptrdiff_t)sizeof first)
        return false;
    /* "0..20": strtod takes the first dot */
    memcpy(first, at + strlen(word), (size_t)(dots - at) - strlen(word));
    window[0] = strtod(first, NULL);
    window[1] = strtod(dots + strlen(mark), NULL);
    return true;
}

static bool judged(struct bench *bench, double window[2])
{
    type(bench, "data clean");
    window[0] = 0;
    window[1] = LAST;
    return announced(said(&bench->out), "use the window ", "..", window) &&
           (window[0] > 0 || window[1] < LAST);
}

TEST(every_command_announces_the_same_window)
{
    for (size_t k = 0; k < COUNT_OF(shapes); k++) {
        struct bench bench;
        double wanted[2], window[2];
        write_recording(&shapes[k]);
        bench_open(&bench, false);
        type(&bench, "scene spring; m = 200 g; load rec.csv");
        const bool narrow = judged(&bench, wanted);
        if (!isnan(shapes[k].from) && (fabs(wanted[0] - shapes[k].from) > 2 * PERIOD ||
                                       fabs(wanted[1] - shapes[k].to) > 2 * PERIOD))
            fail_msg("%s: data clean judges %g..%g s, the truth is %g..%g s", shapes[k].name,
                     wanted[0], wanted[1], shapes[k].from, shapes[k].to);
        for (size_t i = 0; i < COUNT_OF(commands); i++) {
            /* Each with one of them; laws, which take a second, are judged as drag is. */
            if ((i % 12 != k % 12 || strcmp(commands[i], "fit law") == 0) && !is_long())
                continue;
            const bool done = type(&bench, commands[i]);
            const bool knows_rest = strstr(commands[i], "drag") || strstr(commands[i], "law");
            const bool told = announced(said(&bench.err), "try window=", ":", window);
            if (!done && !told) /* refused, which is an answer */
                continue;
            if (told && (!narrow || window[0] != wanted[0] || window[1] != wanted[1]))
                fail_msg("%s, %s: window %g..%g s, data clean judges %g..%g s", shapes[k].name,
                         commands[i], window[0], window[1], wanted[0], wanted[1]);
            if (!told && narrow && !(knows_rest && shapes[k].at == rest_last))
                fail_msg("%s, %s says nothing of the window %g..%g s:\n%s%s", shapes[k].name,
                         commands[i], wanted[0], wanted[1], said(&bench.out), said(&bench.err));
        }
        /* What was announced is taken, and then there is nothing more to say. */
        type(&bench, "data clean apply; fit");
        if (announced(said(&bench.err), "try window=", ":", window))
            fail_msg("%s: after data clean apply still %g..%g s", shapes[k].name, window[0],
                     window[1]);
        bench_close(&bench);
    }
}

RUN_TESTS(enter_folder, leave_folder)
