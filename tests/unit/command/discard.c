/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A fit that leaves out more than a fifth of the samples describes none: no kind of fit says of it
 * that it converged. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"
#include "modules/recording/analysis/testing.h"

enum { SAMPLES = 600 };

#define RATE 40.0
#define MOST 0.2

static double uniform;

static double swing(double t)
{
    return 5 * exp(-0.02 * t) * cos(2 * 3.14159265358979323846 * t / 0.9 + 0.4);
}

static double cut_one(double t) /* 37 % of the time */
{
    return fmin(swing(t), 2);
}

static double cut_little(double t) /* 27 % */
{
    return fmin(swing(t), 3);
}

static double cut_both(double t)
{
    return fmax(fmin(swing(t), 3.5), -3.5);
}

static double echoes(double t) /* a third of them comes from the wall */
{
    return uniform < 0.33 ? 40 : swing(t);
}

static double some_echoes(double t) /* fewer than a fifth in all, but near it */
{
    return uniform < 0.22 ? 12 : swing(t);
}

static double anywhere(double t)
{
    return uniform < 0.28 ? -80 + 600 * uniform : swing(t);
}

static double zeros(double t) /* a third of the time nothing */
{
    return fmod(t, 3) > 2 ? 0 : swing(t);
}

static double rubbish(double t) /* from two thirds on */
{
    return t > 10 ? 60 * uniform - 30 : swing(t);
}

static double bump(double t)
{
    return 5 * exp(-(t - 7) * (t - 7) / 0.5);
}

static double two_levels(double t)
{
    return swing(t) + (uniform < 0.4 ? 9 : 0);
}

static double peaks(double t) /* far from any sine */
{
    return exp(2.5 * cos(7 * t));
}

static const struct shape {
    const char *name;
    double (*at)(double t);
} shapes[] = {{"cut on one side", cut_one},
              {"cut a little", cut_little},
              {"cut on both sides", cut_both},
              {"echoes", echoes},
              {"some echoes", some_echoes},
              {"anywhere", anywhere},
              {"zeros", zeros},
              {"rubbish at the end", rubbish},
              {"one bump", bump},
              {"two levels", two_levels},
              {"peaks", peaks}};

static const char *const fits[] = {
    "fit",
    "fit sine",
    "fit drag",
    "fit law",
    "fit modes 1",
    "fit modes 2",
    "fit scene",
    "fit scene --robust",
    "fit scene free=k,gamma,y0,v0 --robust",
    "fit a*exp(-b*t)*cos(w*t+p)+c a=5 b=0.01 w=6.98 p=0.4 c=0",
    "fit a*exp(-b*t)*cos(w*t+p)+c a=5 b=0.01 w=6.98 p=0.4 c=0 --robust",
    "fit c+0*t c=1 --robust",
};

static void write_recording(const struct shape *shape)
{
    FILE *file = fopen("rec.csv", "w");
    assert_non_null(file);
    random_state = 5;
    fprintf(file, "t (s),y (cm)\n");
    for (int i = 0; i < SAMPLES; i++) {
        uniform = 0.5 * erfc(random_normal() / sqrt(2.0));
        fprintf(file, "%.3f,%.4f\n", i / RATE, shape->at(i / RATE) + 0.02 * random_normal());
    }
    assert_int_equal(fclose(file), 0);
}

/* The number behind "key": in a line of JSON; NAN: there is none. */
static double number(const char *json, const char *key)
{
    char quoted[32];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(json, quoted);
    return at ? strtod(at + strlen(quoted), NULL) : NAN;
}

TEST(nothing_that_discards_a_fifth_converges)
{
    int answers = 0, refused = 0, bad = 0;
    for (size_t k = 0; k < COUNT_OF(shapes); k++) {
        struct bench bench;
        write_recording(&shapes[k]);
        bench_open(&bench, false);
        type_ok(&bench,
                "scene spring; m = 200 g; k = 9.7 N/m; y0 = 4 cm; load rec.csv; set format json");
        for (size_t i = 0; i < COUNT_OF(fits); i++) {
            const bool always = k == 0 && i > 0 && i < 4; /* sine, drag and law reject the most */
            if (!always && (i + k) % 8 != 0 && !is_long())
                continue;
            const bool done = type(&bench, fits[i]);
            const char *out = said(&bench.out);
            const double used = number(out, "used"), rejected = number(out, "rejected");
            const bool converged = done && !strstr(out, "\"converged\":false");
            refused += !done && strstr(said(&bench.err), "leave out") != NULL;
            if (isnan(used))
                continue;
            answers++;
            if (converged && rejected > MOST * (used + rejected)) {
                print_error("%s, %s: converged, %g of %g samples left out\n", shapes[k].name,
                            fits[i], rejected, used + rejected);
                bad++;
            }
        }
        bench_close(&bench);
    }
    assert_int_equal(bad, 0);
    assert_true(answers >= 10 && refused >= 3); /* of all kinds */
}

/* The count in front of " bad sample"; 0 if nothing was left out, NAN if nothing was compared. */
static double bad_samples(const char *text)
{
    const char *rms = strstr(text, "rms(y-data)"), *at = rms ? strstr(rms, " (") : NULL;
    if (!rms)
        return NAN;
    return at && strstr(at, "bad sample") ? strtod(at + 2, NULL) : 0;
}

/* Writes a damped swing about `offset` [cm] with noise and missed echoes. */
static void write_far_recording(double offset, double omega, double spikes)
{
    FILE *file = fopen("far.csv", "w");
    assert_non_null(file);
    fprintf(file, "t (s),y (cm)\n");
    for (int i = 0; i < SAMPLES; i++) {
        const double t = i / RATE, y = offset + 5 * exp(-0.02 * t) * cos(omega * t);
        const double echo = offset + 200 * (random_uniform() - 0.5);
        fprintf(file, "%.3f,%.4f\n", t,
                random_uniform() < spikes ? echo : y + 0.05 * random_normal());
    }
    assert_int_equal(fclose(file), 0);
}

/* A run, however inaccurate, must leave out exactly the samples that the fit rejects. The hint must
 * show the true offset. */
TEST(runs_and_fits_agree_on_the_bad_samples)
{
    const int cases = 20;
    int refused = 0;
    random_state = 21;
    for (int i = 0; i < cases; i++) {
        const double offset = 40 * random_uniform() + 10, omega = 5 + 6 * random_uniform(),
                     spikes = 0.1 * random_uniform();
        char line[200];
        struct bench bench;
        write_far_recording(offset, omega, spikes);
        bench_open(&bench, false);
        snprintf(line, sizeof line,
                 "scene spring; m = 200 g; k = %.6f N/m; y0 = 5 cm; gamma = 0.04; load far.csv",
                 0.2 * omega * omega);
        type_ok(&bench, line);
        type_ok(&bench, "method rk4; dt = 10 ms; run 15 s");
        const double near = bad_samples(said(&bench.out));
        const char *hint = strstr(said(&bench.out), "far is on average ");
        if (!hint || fabs(strtod(hint + 18, NULL) - offset) > 0.006 * offset + 0.05)
            fail_msg("case %d, offset %g: %s", i, offset, hint ? hint : "no hint");
        type_ok(&bench, "method euler; run 15 s");
        const double gone = bad_samples(said(&bench.out));
        if (!type(&bench, "fit; set format json; fit")) { /* it refuses, and judges nothing */
            refused++;
            bench_close(&bench);
            continue;
        }
        const double rejected = number(said(&bench.out), "rejected");
        if (near != rejected || gone != rejected)
            fail_msg("case %d: %g and %g bad samples, the fit rejects %g", i, near, gone, rejected);
        type_ok(&bench, "adopt; method rk4; set format text; run 15 s");
        if (bad_samples(said(&bench.out)) != rejected || strstr(said(&bench.out), "on average"))
            fail_msg("case %d, after the fit: %s", i, said(&bench.out));
        bench_close(&bench);
    }
    assert_true(refused * 20 <= cases);
}

RUN_TESTS(enter_folder, leave_folder)
