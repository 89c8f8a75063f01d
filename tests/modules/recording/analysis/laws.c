/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * All seven laws under everything that recordings suffer from: which law `fit drag` finds. A case
 * is distinguishable where noise-free data refute, by more than chance in the noise at hand, every
 * law that lacks a term of the truth.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#include <string.h>

enum { RATE = 40 };

#define OMEGA 8.37
#define GAIN 30.0 /* chi-square by which the noise-free truth must beat a rival */

struct law_case {
    enum drag_law law;
    double rate[DRAG_RATES], amplitude, span, noise;
};

/* ---- a motion, by classical Runge-Kutta with twelve steps a sample ---- */

static double acceleration(const double rate[DRAG_RATES], double y, double v)
{
    return -rate[0] * v - rate[1] * fabs(v) * v -
           (v > 0   ? rate[2]
            : v < 0 ? -rate[2]
                    : 0) -
           OMEGA * OMEGA * y;
}

/* Rest where the spring no longer overcomes the friction: the sign of v would flutter about 0. */
static void advance(const double rate[DRAG_RATES], double h, double *y, double *v)
{
    const double before = *v;
    if (*v == 0 && OMEGA * OMEGA * fabs(*y) <= rate[2])
        return;
    const double y1 = *v, v1 = acceleration(rate, *y, *v);
    const double y2 = *v + h / 2 * v1, v2 = acceleration(rate, *y + h / 2 * y1, y2);
    const double y3 = *v + h / 2 * v2, v3 = acceleration(rate, *y + h / 2 * y2, y3);
    const double y4 = *v + h * v3, v4 = acceleration(rate, *y + h * y3, y4);
    *y += h / 6 * (y1 + 2 * (y2 + y3) + y4);
    *v += h / 6 * (v1 + 2 * (v2 + v3) + v4);
    if (before * *v < 0 && OMEGA * OMEGA * fabs(*y) <= rate[2])
        *v = 0;
}

static double student_2(void)
{
    const double u = random_uniform() - 0.5, a = 1 - 4 * u * u;
    return 2 * u * sqrt(2 / a);
}

/* ---- what recordings suffer from ---- */

enum ill { WHITE, ROUNDED, WALK, BOWL, GAPS, JITTER, STUDENT, AUTOREGRESSIVE, ILLS };

static const char *const ills[ILLS] = {
    "white", "1 mm steps", "random-walk baseline", "quadratic baseline",
    "gaps",  "jitter",     "Student t, 2",         "AR(1)"};

static struct synthetic make(const struct law_case *c, enum ill ill)
{
    enum { STEPS = 12 };
    const size_t max = (size_t)(c->span * RATE) + 1;
    struct synthetic s = {.t = malloc(max * sizeof(double)), .y = malloc(max * sizeof(double))};
    if (!s.t || !s.y)
        abort();
    double y = c->amplitude, v = 0, walk = 0, slow = 0, time = 0;
    const double h = 1.0 / (STEPS * RATE), gap = random_between(0.2, 0.7) * c->span;
    size_t n = 0;
    for (size_t i = 0; i < max; i++) {
        double noise = c->noise * random_normal(), at = (double)i / RATE, value;
        if (ill == JITTER && i > 0 && i + 1 < max)
            at += random_between(-0.3, 0.3) / RATE;
        while (time < at - 1e-12) {
            const double step = fmin(h, at - time);
            advance(c->rate, step, &y, &v);
            time += step;
        }
        walk += ill == WALK ? 0.5 * c->noise * random_normal() : 0;
        slow = 0.8 * slow + 0.6 * noise;
        noise = ill == STUDENT          ? 0.7 * c->noise * student_2()
                : ill == AUTOREGRESSIVE ? slow
                                        : noise;
        value = 0.21 + y + noise + walk;
        value += ill == BOWL ? 0.5 * c->amplitude * pow(2 * at / c->span - 1, 2) : 0;
        if (ill == GAPS && (fabs(at - gap) < 0.05 * c->span || random_uniform() < 0.05))
            continue;
        s.t[n] = 3 + at;
        s.y[n++] = ill == ROUNDED ? nearbyint(value * 1000) / 1000 : value;
    }
    s.series = (struct series){.t = s.t, .y = s.y, .n = n, .quantity = QUANTITY_LENGTH};
    return s;
}

/* Terms that share the loss, none of them less than a fifth; the amplitude falls by 2 to 10. */
static struct law_case draw(enum drag_law law)
{
    struct law_case c = {
        .law = law, .amplitude = random_between(0.03, 0.08), .span = random_between(30, 90)};
    const double fall = random_between(0.7, 2.3), gamma = 2 * fall / c.span,
                 mean = c.amplitude / fall * -expm1(-fall);
    const double alone[DRAG_RATES] = {gamma, gamma * 3 * 3.14159265 / (8 * OMEGA * mean),
                                      gamma * 0.785398 * OMEGA * mean};
    double fraction[DRAG_RATES], all = 0;
    for (int k = 0; k < DRAG_RATES; k++)
        all += fraction[k] = law >> k & 1 ? random_between(0.35, 1) : 0;
    for (int k = 0; k < DRAG_RATES; k++)
        c.rate[k] = fraction[k] / all * alone[k];
    c.noise = 1e-4 * pow(10, random_uniform());
    return c;
}

/* By how much, in chi-square, the truth beats the best law that lacks one of its terms. */
static double evidence_of(const struct law_case *c, double sigma)
{
    struct law_case clean = *c;
    struct fit fit;
    struct error error = {0};
    clean.noise = 0;
    struct synthetic s = make(&clean, WHITE);
    double min = 1e9;
    if (!fit_named("drag", &s.series, &fit, &error))
        fail_msg("%s", error.text);
    for (int i = 0; i < fit.drag.candidates; i++) {
        const struct drag_candidate *rival = &fit.drag.candidate[i];
        if ((rival->law & c->law) != c->law && rival->converged)
            min = fmin(min, (double)s.series.n * rival->rms * rival->rms / (sigma * sigma));
    }
    synthetic_free(&s);
    return min;
}

struct tally {
    /* excluded: undecided, and the truth is not among those that remain */
    int all, clear, right, wrong, undecided, excluded, refused;
};

static bool says(const struct fit *fit, const char *word)
{
    for (int i = 0; i < fit->warnings; i++)
        if (strstr(fit->warning[i], word))
            return true;
    return false;
}

static bool is_poor(const struct fit *fit)
{
    return says(fit, "poor");
}

static void judge(const struct law_case *c, enum ill ill, struct tally *tally)
{
    /* what one sample's noise is worth at the oscillation's frequency: of AR(1) its spectrum there,
     * of rounding the steps, of t with 2 degrees what robust rejection leaves, of a walk what a
     * cycle does not average out */
    static const double worth[ILLS] = {
        [WHITE] = 1,  [ROUNDED] = 1, [WALK] = 2.6,    [BOWL] = 1,
        [GAPS] = 1.2, [JITTER] = 1,  [STUDENT] = 1.7, [AUTOREGRESSIVE] = 2.3};
    const double sigma =
        worth[ill] * (ill == ROUNDED ? hypot(c->noise, 1e-3 / sqrt(12)) : c->noise);
    struct synthetic s = make(c, ill);
    struct fit fit;
    struct error error = {0};
    const bool clear = evidence_of(c, sigma) > GAIN,
               found = fit_named("drag", &s.series, &fit, &error);
    const bool claimed = found && fit.preferred != LAW_UNDECIDED && !is_poor(&fit);
    if (found && ill == BOWL && fit.drag.wander > 0)
        assert_true(says(&fit, "the offset wanders"));
    tally->all++;
    tally->clear += clear;
    tally->right += clear && claimed && fit.preferred == c->law;
    tally->wrong += claimed && fit.preferred != c->law;
    tally->undecided += clear && found && fit.preferred == LAW_UNDECIDED;
    tally->excluded += found && !claimed && !(fit.drag.remaining >> (c->law - 1) & 1);
    tally->refused += !found;
    if (claimed && fit.preferred != c->law)
        print_message("  %s, truth %s, noise %g of %g over %g s: %s\n", ills[ill],
                      drag_law_name(c->law), c->noise, c->amplitude, c->span, fit.drag.said);
    else if (found && !claimed &&
             (!(fit.drag.remaining >> (c->law - 1) & 1) || (clear && getenv("VERBOSE"))))
        print_message("  %s, truth %s, noise %g of %g over %g s: %s %s\n", ills[ill],
                      drag_law_name(c->law), c->noise, c->amplitude, c->span,
                      is_poor(&fit) ? "poor" : "", fit.drag.said);
    else if (!found)
        print_message("  %s, truth %s, noise %g of %g over %g s: %s\n", ills[ill],
                      drag_law_name(c->law), c->noise, c->amplitude, c->span, error.text);
    synthetic_free(&s);
}

/* At least 95 % of those that can be told apart; of so few, less what chance does to them. */
static bool right_enough(const struct tally *tally)
{
    return tally->right >= 0.95 * tally->clear - 3 * sqrt(0.95 * 0.05 * tally->clear);
}

TEST(the_right_law_or_none)
{
    const char *seed = getenv("SEED");
    const int each = is_long() ? 60 : 1;
    struct tally all = {0};
    bool all_well = true;
    random_state = seed ? strtoull(seed, NULL, 10) : 41;
    for (int ill = 0; ill < ILLS; ill++) {
        struct tally tally = {0};
        for (int i = 0; i < each * DRAG_LAWS; i++) {
            const struct law_case c = draw((enum drag_law)(i % DRAG_LAWS + 1));
            if (!is_long() && (i + ill) % 3 != 0) /* each law under two or three */
                continue;
            judge(&c, (enum ill)ill, &tally);
        }
        print_message("%-22s %d recordings, %d distinguishable: %d right, %d not distinguishable; "
                      "%d wrong, %d excluded, %d refused\n",
                      ills[ill], tally.all, tally.clear, tally.right, tally.undecided, tally.wrong,
                      tally.excluded, tally.refused);
        all_well = all_well && (each == 1 || right_enough(&tally));
        all.all += tally.all;
        all.clear += tally.clear;
        all.right += tally.right;
        all.wrong += tally.wrong;
        all.excluded += tally.excluded;
        all.refused += tally.refused;
    }
    print_message("%d recordings, %d distinguishable: %d right (%.1f %%); %d wrong, %d excluded, "
                  "%d refused\n",
                  all.all, all.clear, all.right, 100.0 * all.right / all.clear, all.wrong,
                  all.excluded, all.refused);
    assert_true(all.clear > all.all / 2);
    assert_true(all_well && (each > 1 ? all.right >= 0.95 * all.clear : right_enough(&all)));
    /* noise alone may hide a term by three standard deviations */
    assert_true(1000 * all.wrong <= all.all && 1000 * all.excluded <= all.all);
    assert_true(all.refused == 0);
}

/* ---- which force pulls back ---- */

static double pull(enum restoring_force force, double beta, double y)
{
    return force == RESTORING_SINE ? OMEGA * OMEGA * sin(y)
                                   : OMEGA * OMEGA * y + (force ? beta * y * y * y : 0);
}

/* With linear damping; leapfrog, 100 steps a sample. */
static struct synthetic swing(enum restoring_force force, double beta, double amplitude,
                              double noise)
{
    enum { STEPS = 100, SAMPLES = 1200 };
    struct synthetic s = {.t = malloc(SAMPLES * sizeof(double)),
                          .y = malloc(SAMPLES * sizeof(double))};
    if (!s.t || !s.y)
        abort();
    const double h = 1.0 / (STEPS * RATE), gamma = 0.08;
    double y = amplitude, v = 0;
    for (int i = 0; i < SAMPLES; i++) {
        s.t[i] = 1 + (double)i / RATE;
        s.y[i] = y + noise * random_normal();
        for (int k = 0; k < STEPS; k++) {
            v = (v * (1 - gamma * h / 4) - h / 2 * pull(force, beta, y)) / (1 + gamma * h / 4);
            y += h * v;
            v = (v * (1 - gamma * h / 4) - h / 2 * pull(force, beta, y)) / (1 + gamma * h / 4);
        }
    }
    s.series = (struct series){.t = s.t, .y = s.y, .n = SAMPLES, .quantity = QUANTITY_ANGLE};
    return s;
}

TEST(restoring_forces_are_found)
{
    static const struct {
        enum restoring_force force;
        double beta, amplitude;
    } cases[] = {{RESTORING_LINEAR, 0, 0.5},
                 {RESTORING_SINE, 0, 1.2},
                 {RESTORING_SINE, 0, 0.5},
                 {RESTORING_CUBIC, 25, 0.8},
                 {RESTORING_CUBIC, -30, 0.6}};
    random_state = 51;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct synthetic s = swing(cases[i].force, cases[i].beta, cases[i].amplitude, 0.002);
        struct fit fit;
        struct error error = {0};
        if (!fit_named("law", &s.series, &fit, &error))
            fail_msg("case %zu: %s", i, error.text);
        print_message("%s: omega0 %.5f +- %.1g, beta %.4g +- %.2g; %s\n",
                      restoring_name(fit.drag.force), fit.omega.value, fit.omega.uncertainty,
                      fit.drag.cubic.value, fit.drag.cubic.uncertainty, fit.drag.said);
        assert_int_equal(fit.drag.force, cases[i].force);
        assert_int_equal(fit.drag.forces_remaining, 1u << cases[i].force);
        assert_true(close_to(fit.omega.value, OMEGA, 5 * fit.omega.uncertainty + 1e-4 * OMEGA));
        assert_true(close_to(fit.drag.cubic.value, cases[i].beta, 4 * fit.drag.cubic.uncertainty));
        assert_true(close_to(fit.rms, 0.002, 2e-4));
        synthetic_free(&s);
    }
}

/* Large swings have one force, small ones often more that remain: never a wrong one alone, nor the
 * right one excluded.
 */
TEST(the_right_force_or_several)
{
    const char *seed = getenv("SEED");
    const int each = is_long() ? 60 : 1;
    random_state = seed ? strtoull(seed, NULL, 10) : 52;
    for (int large = 0; large < 2; large++) {
        int right = 0, wrong = 0, several = 0, all = 0;
        for (int i = 0; i < each * RESTORING_FORCES; i++) {
            const enum restoring_force force = (enum restoring_force)(i % RESTORING_FORCES);
            const double amplitude = large ? random_between(0.4, 1) : random_between(0.02, 0.2);
            const double fraction = random_between(0.1, 0.3) * (random_uniform() < 0.5 ? 1 : -0.5);
            struct synthetic s = swing(force, fraction * OMEGA * OMEGA / (amplitude * amplitude),
                                       amplitude, random_between(0.001, 0.01));
            struct fit fit;
            struct error error = {0};
            if (!fit_named("law", &s.series, &fit, &error))
                fail_msg("%s, %g rad: %s", restoring_name(force), amplitude, error.text);
            const unsigned truth = 1u << force, remain = fit.drag.forces_remaining;
            right += remain == truth;
            wrong += !(remain & truth);
            several += remain != truth && remain & truth;
            all++;
            if (!(remain & truth))
                print_message("  %s at %g rad: %s, BIC %.1f %.1f %.1f\n", restoring_name(force),
                              amplitude, restoring_name(fit.drag.force), fit.drag.restoring[0].bic,
                              fit.drag.restoring[1].bic, fit.drag.restoring[2].bic);
            synthetic_free(&s);
        }
        print_message("%s swings: %d of %d right, %d not distinguishable, %d wrong\n",
                      large ? "large" : "small", right, all, several, wrong);
        assert_true(100 * wrong <= all && (!large || right >= 0.95 * all));
    }
}

RUN_TESTS(NULL, NULL)
