/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The period from phases: the slope of the weighted line through them. What disturbs them (noise of
 * any colour, jitter, a baseline that wanders) shows in their scatter, which is what the
 * uncertainty is taken from.
 */
#include "analysis/period/track.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PHASES_MIN = 4, POWERS = 3 };

#define FAR_OFF 6.0         /* robust standard deviations */
#define GAP_DISTANCES 2.5   /* usual distances between phases */
#define NORMAL_95 1.96      /* standard deviations of a 95 % interval */
#define SCATTER_CHANCE 1e-5 /* the chance of scatter so small that it is none */
#define BENDS_AT 4.0        /* standard deviations of the curvature */
#define RISES_AT 3.0        /* standard deviations of the curvature of log A */
#define BENDS_MIN 1e-4 /* relative change of the period over the recording that is worth a word */

struct phases {
    double *t, *phase, *sigma, *residual; /* [n]; t from -1 to 1 */
    size_t n;
    double middle, half; /* [s] */
};

struct phase_polynomial {
    double coefficient[POWERS], sigma[POWERS]; /* phase = c0 + c1 t + c2 t^2 */
    double variance;                           /* of the residuals over the phases' own, widened */
    size_t used;
};

static bool solve_polynomial(double a[POWERS][POWERS + 1], int terms, double inverse[POWERS])
{
    double full[POWERS][2 * POWERS + 1] = {{0}};
    for (int i = 0; i < terms; i++) {
        for (int j = 0; j < terms; j++) {
            full[i][j] = a[i][j];
        }
        full[i][terms] = a[i][POWERS];
        full[i][terms + 1 + i] = 1;
    }
    for (int i = 0; i < terms; i++) {
        if (!(full[i][i] > 0)) {
            return false;
        }
        for (int j = 0; j < terms; j++) {
            const double factor = j == i ? 0 : full[j][i] / full[i][i];
            for (int k = 0; k <= 2 * terms && factor != 0; k++) {
                full[j][k] -= factor * full[i][k];
            }
        }
    }
    for (int i = 0; i < terms; i++) {
        a[i][POWERS] = full[i][terms] / full[i][i];
        inverse[i] = full[i][terms + 1 + i] / full[i][i];
    }
    return true;
}

/* Residuals in their own standard deviations, scaled by the scatter; neighbours that hang together
 * widen it. */
static double scatter(const struct phases *p, const unsigned char *use, int terms)
{
    double square = 0, product = 0, before = 0, n = 0;
    for (size_t i = 0; i < p->n; i++) {
        if (!use[i]) {
            continue;
        }
        const double z = p->residual[i] / p->sigma[i];
        square += z * z;
        product += z * before;
        before = z;
        n++;
    }
    const double rho = square > 0 ? product / square : 0, chance = 1 / sqrt(n);
    const double variance = square / fmax(n - terms, 1);
    return variance *
           fmax(rho > chance ? autocorrelation_factor(rho) : 1, line_correlation_factor(rho, n));
}

/* Least squares through the phases in use; scratch [n]: the size of the residuals in their standard
 * deviations. */
static bool weigh_polynomial(const struct phases *p, int terms, double *scratch,
                             const unsigned char *use, struct phase_polynomial *out)
{
    double a[POWERS][POWERS + 1] = {{0}}, inverse[POWERS];
    out->used = 0;
    for (size_t i = 0; i < p->n; i++) {
        const double w = use[i] / (p->sigma[i] * p->sigma[i]),
                     x[POWERS] = {1, p->t[i], p->t[i] * p->t[i]};
        for (int j = 0; j < terms; j++) {
            for (int k = 0; k < terms; k++) {
                a[j][k] += w * x[j] * x[k];
            }
            a[j][POWERS] += w * x[j] * p->phase[i];
        }
        out->used += use[i];
    }
    if (out->used < (size_t)terms + 1 || !solve_polynomial(a, terms, inverse)) {
        return false;
    }
    for (size_t i = 0; i < p->n; i++) {
        const double t = p->t[i];
        p->residual[i] =
            p->phase[i] - a[0][POWERS] - t * (a[1][POWERS] + (terms > 2 ? t * a[2][POWERS] : 0));
        scratch[i] = fabs(p->residual[i] / p->sigma[i]);
    }
    out->variance = scatter(p, use, terms);
    for (int j = 0; j < terms; j++) {
        out->coefficient[j] = a[j][POWERS];
        out->sigma[j] = sqrt(inverse[j] * out->variance);
    }
    return true;
}

/* The same without those that are far off. */
static bool fit_polynomial(const struct phases *p, int terms, double *scratch, unsigned char *use,
                           struct phase_polynomial *out)
{
    for (int pass = 0; pass < 3; pass++) {
        if (!weigh_polynomial(p, terms, scratch, use, out)) {
            return false;
        }
        const double limit = FAR_OFF * MAD_TO_SIGMA * quantile(scratch, p->n, 0.5);
        for (size_t i = 0; i < p->n; i++) {
            use[i] = fabs(p->residual[i] / p->sigma[i]) <= limit;
        }
    }
    return true;
}

static bool gather(const struct track *track, struct arena *arena, struct phases *p)
{
    const struct track_window *first = NULL, *last = NULL;
    double *all = arena_array(arena, 4 * (track->windows + 1), sizeof *all);
    *p = (struct phases){.t = all};
    if (!all) {
        return false;
    }
    p->phase = all + track->windows;
    p->sigma = p->phase + track->windows;
    p->residual = p->sigma + track->windows;
    for (size_t k = 0; k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        if (!w->clear || !(w->sigma < 1)) {
            continue;
        }
        first = first ? first : w;
        last = w;
        p->t[p->n] = w->t;
        p->phase[p->n] = w->phase - first->phase;
        p->sigma[p->n++] = fmax(w->sigma, 1e-9);
    }
    if (p->n < PHASES_MIN) {
        return false;
    }
    p->middle = 0.5 * (first->t + last->t);
    p->half = 0.5 * (last->t - first->t);
    for (size_t i = 0; i < p->n; i++) {
        p->t[i] = (p->t[i] - p->middle) / p->half;
    }
    return true;
}

/* The variance of all phases about a straight line, with so many turns more from phase `at` on;
 * NAN: no line. */
static double variance_with(const struct phases *p, size_t at, int turns, double *scratch,
                            unsigned char *use)
{
    struct phase_polynomial line;
    memset(use, 1, p->n);
    for (size_t i = at; i < p->n; i++) {
        p->phase[i] += turns * TWO_PI;
    }
    const bool fitted = weigh_polynomial(p, 2, scratch, use, &line);
    for (size_t i = at; i < p->n; i++) {
        p->phase[i] -= turns * TWO_PI;
    }
    return fitted ? line.variance : NAN;
}

/* Across a gap the frequency before it may not be good enough to count the periods: the count that
 * makes the line straightest. */
static void count_across_gaps(struct phases *p, double *scratch, unsigned char *use)
{
    enum { TURNS = 4, SIDE = 512 }; /* so many phases on each side tell, however many there are */
    for (size_t i = 1; i < p->n && p->n > PHASES_MIN; i++) {
        /* at least that of a window: gaps take some of the time */
        const double width = 2.0 / (double)(p->n - 1);
        const size_t from = i > SIDE ? i - SIDE : 0, to = i + SIDE < p->n ? i + SIDE : p->n;
        const struct phases near = {.t = p->t + from,
                                    .phase = p->phase + from,
                                    .sigma = p->sigma + from,
                                    .residual = p->residual + from,
                                    .n = to - from};
        double min = HUGE_VAL;
        int best = 0;
        for (int turns = -TURNS; turns <= TURNS && p->t[i] - p->t[i - 1] > GAP_DISTANCES * width;
             turns++) {
            const double variance = variance_with(&near, i - from, turns, scratch, use);
            best = variance < min ? turns : best;
            min = fmin(min, variance);
        }
        for (size_t j = i; j < p->n && best != 0; j++) {
            p->phase[j] += best * TWO_PI;
        }
    }
}

/* The up-crossing of the baseline nearest to a window's middle [s]. */
static double crossing_near(const struct track_window *w)
{
    return w->t - remainder(w->phase + 0.5 * PI, TWO_PI) / w->omega;
}

/*
 * Half a 95 % interval of the slope, over 1.96. A few phases lie closer to their line by chance
 * than they should; so close as chance does not bring them they lie where the windows' residuals
 * repeat (harmonics), and are believed.
 */
static double slope_sigma(const struct phase_polynomial *line)
{
    const double freedom = (double)line->used - 2;
    const double widen = gsl_cdf_tdist_Pinv(0.975, freedom) / NORMAL_95;
    const bool chance = line->variance * freedom > gsl_cdf_chisq_Pinv(SCATTER_CHANCE, freedom);
    return line->sigma[1] * fmax(widen, chance ? 1 / sqrt(line->variance) : 0);
}

double friction_delay(double rise, double omega, double span)
{
    static const double late = 1.8; /* 1.4 to 1.8 in recordings whose motion is known */
    return late * rise / (omega * omega * span);
}

void period_widen_by_friction(struct period *period, double late)
{
    if (late > NORMAL_95 * period->period.uncertainty && !period->warning[0])
        snprintf(period->warning, sizeof period->warning,
                 "the decay speeds up, as under dry friction, which delays the phases: T may be up "
                 "to %.2g s too long ('fit drag' knows)",
                 late);
    period->period.uncertainty = hypot(period->period.uncertainty, late / NORMAL_95);
}

/* Returns how much longer the period may seem than it is, relative to it, by the bend of ln A. */
static double delay_of_friction(const struct track *track, struct phases *p, double omega,
                                double *scratch, unsigned char *use)
{
    struct phase_polynomial decay;
    size_t n = 0;
    for (size_t k = 0; k < track->windows && n < p->n; k++) {
        const struct track_window *w = &track->window[k];
        if (w->clear && w->sigma < 1) {
            p->phase[n++] = log(w->amplitude);
        }
    }
    memset(use, 1, p->n);
    if (p->n <= PHASES_MIN || !weigh_polynomial(p, 3, scratch, use, &decay) ||
        !(decay.coefficient[2] < -RISES_AT * decay.sigma[2])) {
        return 0;
    }
    const double rise = -4 * decay.coefficient[2] / p->half; /* [1/s] */
    return friction_delay(rise, omega, 2 * p->half);
}

bool track_period(const struct track *track, struct arena *arena, struct period *out)
{
    struct phases p;
    struct phase_polynomial line, bent;
    double weight = 0, level = 0;
    if (!gather(track, arena, &p)) {
        return false;
    }
    double *scratch = arena_array(arena, p.n, sizeof *scratch);
    unsigned char *use = arena_alloc(arena, p.n);
    if (!scratch || !use) {
        return false;
    }
    count_across_gaps(&p, scratch, use);
    memset(use, 1, p.n);
    const bool bends = p.n > PHASES_MIN && fit_polynomial(&p, 3, scratch, use, &bent) &&
                       fabs(bent.coefficient[2]) > BENDS_AT * bent.sigma[2];
    for (size_t i = 0; i < p.n; i++) {
        use[i] = use[i] || bends;
    }
    if (!fit_polynomial(&p, 2, scratch, use, &line)) {
        return false;
    }
    const struct track_window *first = NULL, *last = NULL;
    for (size_t k = 0; k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        if (w->clear) {
            first = first ? first : w;
            last = w;
            level += w->mean * (double)w->used;
            weight += (double)w->used;
        }
    }
    if (!first) {
        return false;
    }
    const double omega = line.coefficient[1] / p.half, period = TWO_PI / omega;
    *out = (struct period){.period = {period, period * slope_sigma(&line) / p.half / omega},
                           .first = crossing_near(first),
                           .last = crossing_near(last),
                           .level = level / weight,
                           .how = "phases"};
    out->periods = nearbyint((out->last - out->first) / period);
    if (bends) {
        const double from = TWO_PI * p.half / (bent.coefficient[1] - 2 * bent.coefficient[2]),
                     to = TWO_PI * p.half / (bent.coefficient[1] + 2 * bent.coefficient[2]);
        if (fabs(to / from - 1) > BENDS_MIN) {
            snprintf(out->warning, sizeof out->warning,
                     "the period changes along the recording, from about %.5g to %.5g s", from, to);
            out->period.uncertainty = fmax(out->period.uncertainty, 0.25 * fabs(to - from));
        }
    }
    const double late = delay_of_friction(track, &p, omega, scratch, use) * period;
    period_widen_by_friction(out, late);
    return out->period.value > 0;
}
