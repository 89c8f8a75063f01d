/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Several damped sines at once: 95 % intervals of every parameter cover the truth in 90 to 99 % of
 * the recordings of each kind, down to 1.5 line widths 1/T apart, or a warning says that the lines
 * are too near; what does not have so many frequencies is refused.
 */
#include <string.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#define PI 3.14159265358979323846

enum { F1, F2, GAMMA1, GAMMA2, A1, A2, PHASE1, PHASE2, SPLITTING, COUPLING, QUANTITIES };

struct beat {
    double f[2], gamma[2], amplitude[2], phase[2];
    double t0, dt;
    size_t n;
    double *t, *y;
};

static double coupling_of(const struct beat *b)
{
    double square[2];
    for (int k = 0; k < 2; k++)
        square[k] = pow(2 * PI * b->f[k], 2) + b->gamma[k] * b->gamma[k] / 4;
    return 0.5 * (square[1] / square[0] - 1);
}

/* apart: in line widths 1/T. */
static struct beat beat_make(double apart)
{
    const double periods = random_between(8, 60), samples = random_between(12, 40);
    struct beat b = {.t0 = random_between(0, 5), .dt = 0.01, .n = (size_t)(periods * samples) + 1};
    const double span = (double)(b.n - 1) * b.dt;
    b.f[0] = periods / span;
    b.f[1] = b.f[0] + apart / span;
    for (int k = 0; k < 2; k++) {
        b.gamma[k] = random_between(0, 3) / span;
        b.amplitude[k] = k ? random_between(0.4, 1) : 1;
        b.phase[k] = random_between(-PI, PI);
    }
    b.t = malloc(b.n * sizeof *b.t);
    b.y = malloc(b.n * sizeof *b.y);
    if (!b.t || !b.y)
        abort();
    for (size_t i = 0; i < b.n; i++) {
        const double s = (double)i * b.dt;
        b.t[i] = b.t0 + s;
        b.y[i] = 20;
        for (int k = 0; k < 2; k++)
            b.y[i] +=
                b.amplitude[k] * exp(-b.gamma[k] * s / 2) * cos(2 * PI * b.f[k] * s + b.phase[k]);
    }
    return b;
}

static void white(struct beat *b)
{
    const double sigma = random_between(0.01, 0.08);
    for (size_t i = 0; i < b->n; i++)
        b->y[i] += sigma * random_normal();
}

static void autoregressive(struct beat *b)
{
    double at = 0;
    for (size_t i = 0; i < b->n; i++)
        b->y[i] += at = 0.9 * at + 0.01 * random_normal();
}

static void walking(struct beat *b)
{
    double at = 0;
    for (size_t i = 0; i < b->n; i++)
        b->y[i] += (at += 0.004 * random_normal()) + 0.02 * random_normal();
}

static void gaps(struct beat *b)
{
    size_t n = 0;
    const double span = b->t[b->n - 1] - b->t0, from = b->t0 + random_between(0.3, 0.6) * span;
    white(b);
    for (size_t i = 0; i < b->n; i++)
        if (b->t[i] < from || b->t[i] > from + 0.15 * span || i + 1 == b->n) {
            b->t[n] = b->t[i];
            b->y[n++] = b->y[i];
        }
    b->n = n;
}

static void echoes(struct beat *b)
{
    white(b);
    for (size_t i = 0; i < b->n; i++)
        b->y[i] = random_uniform() < 0.02 ? 0 : b->y[i];
}

static void stepped(struct beat *b)
{
    for (size_t i = 0; i < b->n; i++)
        b->y[i] = nearbyint((b->y[i] + 0.02 * random_normal()) * 20) / 20;
}

static const struct {
    const char *name;
    double min, max; /* apart */
    void (*disturb)(struct beat *b);
    int runs; /* of the quick form */
} rows[] = {{"white, 1.5 to 2 line widths apart", 1.5, 2, white, 20},
            {"white, 2 to 12", 2, 12, white, 20},
            {"white, 0.5 to 1.4: too near", 0.5, 1.4, white, 10},
            {"AR(1), 1.6 to 8", 1.6, 8, autoregressive, 12},
            {"random walk, 1.6 to 8", 1.6, 8, walking, 12},
            {"gap, 1.6 to 8", 1.6, 8, gaps, 10},
            {"missed echoes, 1.6 to 8", 1.6, 8, echoes, 10},
            {"steps of 5 %, 1.6 to 8", 1.6, 8, stepped, 10}};

static bool says(const struct modes_fit *fit, const char *word)
{
    for (int i = 0; i < fit->fit.warnings; i++)
        if (strstr(fit->fit.warning[i], word))
            return true;
    return false;
}

static void judge(const struct beat *b, const struct modes_fit *fit, int covered[QUANTITIES])
{
    const double truth[QUANTITIES] = {b->f[0],           b->f[1],         b->gamma[0], b->gamma[1],
                                      b->amplitude[0],   b->amplitude[1], b->phase[0], b->phase[1],
                                      b->f[1] - b->f[0], coupling_of(b)};
    const struct normal_mode *m = fit->mode;
    const struct measured found[QUANTITIES] = {
        m[0].frequency, m[1].frequency, m[0].gamma, m[1].gamma,     m[0].amplitude,
        m[1].amplitude, m[0].phase,     m[1].phase, fit->splitting, fit->coupling};
    for (int q = 0; q < QUANTITIES; q++) {
        double off = found[q].value - truth[q];
        if (q == PHASE1 || q == PHASE2)
            off = remainder(off, 2 * PI);
        covered[q] += fabs(off) <= 1.96 * found[q].uncertainty;
    }
}

TEST(intervals_cover_or_a_warning_says_why_not)
{
    bool all_well = true;
    random_state = 12;
    for (size_t k = 0; k < COUNT_OF(rows); k++) {
        const int runs = is_long() ? 240 : rows[k].runs;
        int covered[QUANTITIES] = {0}, warned = 0, refused = 0, sum = 0, min = runs;
        for (int run = 0; run < runs; run++) {
            struct beat b = beat_make(random_between(rows[k].min, rows[k].max));
            rows[k].disturb(&b);
            const struct series series = {
                .t = b.t, .y = b.y, .n = b.n, .quantity = QUANTITY_LENGTH};
            struct arena arena = {0};
            struct error error = {0};
            struct modes_fit fit = {.modes = 0};
            if (!series_modes(&series, 2, &arena, NULL, &fit, &error) || !fit.fit.converged) {
                refused++;
                if (getenv("SHOW"))
                    print_message("%s\n", error.text);
            } else if (says(&fit, "may be one mode") || says(&fit, "another line")) {
                warned++;
            } else {
                judge(&b, &fit, covered);
            }
            arena_reset(&arena);
            free(b.t);
            free(b.y);
        }
        const int judged = runs - warned - refused;
        for (int q = 0; q < QUANTITIES; q++) {
            sum += covered[q];
            min = covered[q] < min ? covered[q] : min;
        }
        const double all = judged ? 100.0 * sum / judged / QUANTITIES : 100;
        print_message(
            "%-34s %3d judged, %4.1f %% covered, worst quantity %5.1f %%; %d warned, %d refused\n",
            rows[k].name, judged, all, judged ? 100.0 * min / judged : 100.0, warned, refused);
        /* Each quantity within what chance does to so few, all of them together as promised. */
        const double chance = 3 * sqrt(0.95 * 0.05 * judged);
        const bool near = rows[k].max < 1.5;
        all_well = all_well && min >= 0.9 * judged - chance && all >= 90 &&
                   all <= 99 + 100 * near && (near ? 10 * judged <= runs : 4 * judged >= 3 * runs);
    }
    assert_true(all_well);
}

/* ---- what has fewer frequencies ---- */

static int found_two(double second, double noise, int runs)
{
    int found = 0;
    for (int run = 0; run < runs; run++) {
        struct beat b = beat_make(random_between(2, 10));
        for (size_t i = 0; i < b.n; i++) {
            const double s = (double)i * b.dt;
            b.y[i] = cos(2 * PI * b.f[0] * s) + second * cos(2 * PI * b.f[1] * s) +
                     noise * random_normal();
        }
        const struct series series = {.t = b.t, .y = b.y, .n = b.n, .quantity = QUANTITY_LENGTH};
        struct arena arena = {0};
        struct error error = {0};
        struct modes_fit fit;
        found += series_modes(&series, 2, &arena, NULL, &fit, &error) && fit.fit.converged;
        arena_reset(&arena);
        free(b.t);
        free(b.y);
    }
    return found;
}

TEST(one_frequency_is_not_two)
{
    random_state = 5;
    assert_int_equal(found_two(0, 0.05, is_long() ? 200 : 6), 0);
    assert_int_equal(found_two(0.2, 0.05, 6), 6);
}

TEST(noise_has_no_frequency)
{
    random_state = 6;
    for (int run = 0; run < (is_long() ? 200 : 6); run++) {
        struct beat b = beat_make(3);
        double at = 0;
        for (size_t i = 0; i < b.n; i++)
            b.y[i] = run % 2 ? random_normal() : (at += random_normal());
        const struct series series = {.t = b.t, .y = b.y, .n = b.n, .quantity = QUANTITY_LENGTH};
        struct arena arena = {0};
        struct error error = {0};
        struct modes_fit fit;
        assert_false(series_modes(&series, 2, &arena, NULL, &fit, &error) && fit.fit.converged);
        arena_reset(&arena);
        free(b.t);
        free(b.y);
    }
}

/* ---- without noise, and more of them ---- */

TEST(three_modes_are_found_to_rounding)
{
    static const double f[] = {0.8, 1.1, 2.5}, gamma[] = {0.1, 0.05, 0.3}, a[] = {1, 0.3, 0.6},
                        phase[] = {0.5, -2, 3};
    enum { N = 1500 };
    double t[N], y[N];
    for (int i = 0; i < N; i++) {
        t[i] = 3 + 0.02 * i;
        y[i] = 7 + 0.01 * (t[i] - 3);
        for (int k = 0; k < 3; k++)
            y[i] +=
                a[k] * exp(-gamma[k] * (t[i] - 3) / 2) * cos(2 * PI * f[k] * (t[i] - 3) + phase[k]);
    }
    const struct series series = {.t = t, .y = y, .n = N, .quantity = QUANTITY_LENGTH};
    struct arena arena = {0};
    struct error error = {0};
    struct modes_fit fit;
    assert_true(series_modes(&series, 3, &arena, NULL, &fit, &error));
    assert_true(fit.fit.converged);
    for (int k = 0; k < 3; k++) {
        assert_true(close_to(fit.mode[k].frequency.value, f[k], 1e-9));
        assert_true(close_to(fit.mode[k].gamma.value, gamma[k], 1e-8));
        assert_true(close_to(fit.mode[k].amplitude.value, a[k], 1e-8));
        assert_true(close_to(remainder(fit.mode[k].phase.value - phase[k], 2 * PI), 0, 1e-8));
    }
    assert_true(close_to(fit.fit.offset.value, 7, 1e-8));
    assert_true(close_to(fit.fit.drift.value, 0.01, 1e-9));
    assert_int_equal(fit.fit.warnings, 0);
    assert_true(isnan(fit.splitting.value));
    arena_reset(&arena);
}

/* ---- what the fit of one oscillation says of two ---- */

static bool fit_says(const struct beat *b, const char *word)
{
    const struct series series = {.t = b->t, .y = b->y, .n = b->n, .quantity = QUANTITY_LENGTH};
    struct fit fit = {.warnings = 0};
    struct error error = {0};
    fit_named("damped", &series, &fit, &error);
    for (int i = 0; i < fit.warnings; i++)
        if (strstr(fit.warning[i], word))
            return true;
    const bool found = strstr(error.text, word) || strstr(error.hint, word);
    if (!found && getenv("SHOW"))
        print_message("no '%s': %s %s %s, 1/T apart %g, %zu samples\n", word,
                      fit.warnings ? fit.warning[0] : "-", error.text, error.hint,
                      (b->f[1] - b->f[0]) * (b->t[b->n - 1] - b->t[0]), b->n);
    return found;
}

TEST(beats_are_called_two_frequencies)
{
    const int runs = is_long() ? 200 : 20;
    int said = 0, sways = 0;
    random_state = 9;
    for (int run = 0; run < runs; run++) {
        struct beat b = beat_make(random_between(2, 6));
        white(&b);
        said += fit_says(&b, "fit modes 2");
        sways += fit_says(&b, "sway");
        free(b.t);
        free(b.y);
    }
    print_message("two frequencies: %d of %d, sway: %d\n", said, runs, sways);
    assert_true(said >= 0.95 * runs);
    assert_int_equal(sways, 0);
}

TEST(a_sway_is_not_called_two_frequencies)
{
    const int runs = is_long() ? 200 : 20;
    int said = 0;
    random_state = 10;
    for (int run = 0; run < runs; run++) {
        const struct truth truth = {.amplitude = 5,
                                    .offset = 30,
                                    .period = random_between(0.6, 1.5),
                                    .gamma = random_between(0.01, 0.1),
                                    .phase = random_between(-PI, PI),
                                    .rate = 50,
                                    .span = random_between(15, 40),
                                    .noise = 0.05,
                                    .sway = random_between(0, 0.3),
                                    .sway_period = random_between(4, 12),
                                    .sway_phase = random_between(-PI, PI)};
        struct synthetic s = synthetic_make(&truth);
        const struct beat b = {.t = s.t, .y = s.y, .n = s.series.n};
        said += fit_says(&b, "two frequencies");
        synthetic_free(&s);
    }
    print_message("two frequencies said of a sway: %d of %d\n", said, runs);
    assert_true(said <= 0.05 * runs);
}

/* ---- lines of a spectrum ---- */

static bool holds(const struct spectrum_peak *peak, double f, double amplitude, double width)
{
    return fabs(peak->frequency.value - f) <= width * peak->frequency.uncertainty &&
           fabs(peak->amplitude.value - amplitude) <= width * peak->amplitude.uncertainty;
}

/* Steady tones with their frequencies and amplitudes; nearer to each other than four bins they are
 * one line. */
TEST(lines_are_where_the_tones_are)
{
    enum { RUNS = 100 };
    int both = 0, covered = 0, near = 0;
    random_state = 21;
    for (int run = 0; run < 2 * RUNS; run++) {
        struct beat b = beat_make(run < RUNS ? random_between(6, 15) : random_between(2, 3.5));
        for (size_t i = 0; i < b.n; i++) {
            const double s = (double)i * b.dt;
            b.y[i] = 20 + 0.02 * random_normal();
            for (int k = 0; k < 2; k++)
                b.y[i] += b.amplitude[k] * cos(2 * PI * b.f[k] * s + b.phase[k]);
        }
        const struct series series = {.t = b.t, .y = b.y, .n = b.n, .quantity = QUANTITY_LENGTH};
        struct arena arena = {0};
        struct spectrum_peak peak[2];
        const int count = series_peaks(&series, &arena, peak, 2);
        const int first = count == 2 && peak[0].frequency.value > peak[1].frequency.value;
        if (run >= RUNS) { /* one of the two, no further off than it says, or between both */
            near += count >= 1 &&
                    (holds(&peak[0], b.f[0], b.amplitude[0], 3) ||
                     holds(&peak[0], b.f[1], b.amplitude[1], 3) ||
                     (peak[0].frequency.value > b.f[0] && peak[0].frequency.value < b.f[1]));
        } else if (count == 2) {
            both++;
            covered += holds(&peak[first], b.f[0], b.amplitude[0], 1.96);
            covered += holds(&peak[1 - first], b.f[1], b.amplitude[1], 1.96);
        }
        arena_reset(&arena);
        free(b.t);
        free(b.y);
    }
    print_message("both lines in %d of %d, covered %d of %d; near ones %d of %d\n", both, RUNS,
                  covered, 2 * both, near, RUNS);
    assert_true(both >= 0.95 * RUNS);
    assert_true(covered >= 0.9 * 2 * both);
    assert_true(near >= 0.9 * RUNS);
}

RUN_TESTS(NULL, NULL)
