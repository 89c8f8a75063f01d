/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period as the slope of the line through the times of cycles against their numbers. Whatever
 * disturbs the times (coloured noise, jitter, a wandering baseline) shows in their scatter, from
 * which the uncertainty is taken. */
#include "modules/recording/period/cycle.h"

#include <float.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdio.h>

/* Largest number of powers and of steps after gaps in a line. */
enum { POWERS_MAX = 3, GAPS_MAX = 6, TERMS_MAX = POWERS_MAX + GAPS_MAX };

/* Times farther off the line, in robust standard deviations, are left out. */
static const double far_off = 6;

/* Places the four arrays of numbers in one block, and the two of flags in another. */
bool cycle_times_init(struct cycle_times *x, size_t capacity, struct arena *arena)
{
    double *all = arena_array(arena, 4 * capacity + 1, sizeof *all);
    *x = (struct cycle_times){.t = all, .use = arena_alloc(arena, 2 * capacity + 1)};
    if (!all || !x->use)
        return false;
    x->after_gap = x->use + capacity;
    x->sigma = all + capacity;
    x->number = x->sigma + capacity;
    x->deviation = x->number + capacity;
    return true;
}

void cycle_times_add(struct cycle_times *x, double t, double sigma, double number, bool after_gap)
{
    x->after_gap[x->n] = after_gap;
    x->t[x->n] = t;
    x->sigma[x->n] = sigma;
    x->use[x->n] = 1;
    x->number[x->n++] = number;
}

/* A line through times: t = sum of value[k] u^k, u = (number - middle)/half, plus a step after each
 * gap. */
struct times_line {
    int powers, gaps;
    size_t gap[GAPS_MAX]; /* index of the first time after each gap */
    double middle, half;  /* middle and half range of the numbers, for scaling */
    double value[TERMS_MAX], sigma[TERMS_MAX];
    double slope_formal; /* uncertainty of value[1] by the stated uncertainties of the times */
    double variance;     /* variance about the line in units of the stated ones, widened */
    size_t used;         /* number of times in use */
};

/* Sets middle and half range of the numbers. */
static void set_scale(const struct cycle_times *x, struct times_line *line)
{
    line->middle = 0.5 * (x->number[0] + x->number[x->n - 1]);
    line->half = 0.5 * (x->number[x->n - 1] - x->number[0]);
}

/* Sets term to the factors of value[] for time i. */
static void set_terms(const struct times_line *line, const struct cycle_times *x, size_t i,
                      double *term)
{
    const double u = (x->number[i] - line->middle) / line->half;
    for (int k = 0; k < line->powers; k++)
        term[k] = k == 0 ? 1 : u * term[k - 1];
    for (int k = 0; k < line->gaps; k++)
        term[line->powers + k] = i >= line->gap[k];
}

/* Returns the variance about the line in units of the stated variances, widened if neighbouring
 * deviations are correlated. `terms` is the number of fitted values. */
static double times_variance(const struct cycle_times *x, int terms)
{
    double square = 0, product = 0, previous = 0, n = 0;
    for (size_t i = 0; i < x->n; i++)
        if (x->use[i]) {
            const double z = x->deviation[i] / x->sigma[i];
            square += z * z;
            product += z * previous;
            previous = z;
            n++;
        }
    const double rho = square > 0 ? product / square : 0, chance = 1 / sqrt(n);
    return square / fmax(n - terms, 1) *
           fmax(rho > chance ? autocorrelation_factor(rho) : 1, line_correlation_factor(rho, n));
}

/* Fits the line (with powers and steps in gaps) to the times in use by weighted least squares, and
 * sets their deviations. Returns false if they are too few, or if out of memory. */
static bool fit_weighted(struct cycle_times *x, struct times_line *line)
{
    const size_t terms = (size_t)(line->powers + line->gaps), last = x->n - 1;
    const double start = x->t[0], slope = (x->t[last] - start) / (x->number[last] - x->number[0]);
    double chi2, term[TERMS_MAX];
    size_t n = 0;
    for (size_t i = 0; i < x->n; i++)
        n += x->use[i];
    line->used = n;
    if (n < terms)
        return false;
    gsl_matrix *a = gsl_matrix_alloc(n, terms), *inverse = gsl_matrix_alloc(terms, terms);
    gsl_vector *y = gsl_vector_alloc(n), *weight = gsl_vector_alloc(n),
               *value = gsl_vector_alloc(terms);
    gsl_multifit_linear_workspace *work = gsl_multifit_linear_alloc(n, terms);
    bool fitted = a && inverse && y && weight && value && work;
    n = 0;
    for (size_t i = 0; i < x->n && fitted; i++) {
        if (!x->use[i])
            continue;
        set_terms(line, x, i, term);
        for (size_t k = 0; k < terms; k++)
            gsl_matrix_set(a, n, k, term[k]);
        /* The line through the ends is subtracted, so that no digits are lost. */
        gsl_vector_set(y, n, x->t[i] - start - slope * (x->number[i] - x->number[0]));
        gsl_vector_set(weight, n++, 1 / (x->sigma[i] * x->sigma[i]));
    }
    fitted = fitted && !gsl_multifit_wlinear(a, weight, y, value, inverse, &chi2, work);
    for (size_t i = 0; i < x->n && fitted; i++) {
        set_terms(line, x, i, term);
        x->deviation[i] = x->t[i] - start - slope * (x->number[i] - x->number[0]);
        for (size_t k = 0; k < terms; k++)
            x->deviation[i] -= gsl_vector_get(value, k) * term[k];
    }
    if (fitted) {
        line->variance = n > terms ? times_variance(x, (int)terms) : 1;
        for (size_t k = 0; k < terms; k++) {
            line->value[k] = gsl_vector_get(value, k);
            line->sigma[k] = sqrt(gsl_matrix_get(inverse, k, k) * line->variance);
        }
        line->value[1] += slope * line->half;
        line->slope_formal = sqrt(gsl_matrix_get(inverse, 1, 1));
    }
    gsl_matrix_free(a);
    gsl_matrix_free(inverse);
    gsl_vector_free(y);
    gsl_vector_free(weight);
    gsl_vector_free(value);
    gsl_multifit_linear_free(work);
    return fitted;
}

/* Fits a line with that number of powers (2 for a straight one), leaving out times that are far
 * off. scratch [n] is work space. Returns false if there are too few times. */
static bool fit_times(struct cycle_times *x, int powers, double *scratch, struct times_line *line)
{
    enum { PASSES = 3 };
    line->powers = powers;
    for (int pass = 0; pass < PASSES; pass++) {
        if (!fit_weighted(x, line))
            return false;
        for (size_t i = 0; i < x->n; i++)
            scratch[i] = fabs(x->deviation[i] / x->sigma[i]);
        const double limit = far_off * MAD_TO_SIGMA * values_quantile(scratch, x->n, 0.5);
        for (size_t i = 0; i < x->n; i++)
            x->use[i] = fabs(x->deviation[i] / x->sigma[i]) <= fmax(limit, DBL_EPSILON);
    }
    return true;
}

/* Counts the cycles in gaps anew, so that the times before and after lie on one curve. If they do
 * not for any number, the clock was set: the line gets a step there. Returns the time before the
 * longest of these gaps, or NAN. */
static double recount_gaps(struct cycle_times *x, struct times_line *line)
{
    static const double gap_distances = 2.5, jump_sigmas = 5, jump_min = 0.04, known = 0.2;
    const double mean = (x->t[x->n - 1] - x->t[0]) / (double)(x->n - 1);
    struct times_line steps = *line;
    double t_gap = NAN, longest = 0;
    for (size_t i = 1; i < x->n && steps.gaps < GAPS_MAX; i++)
        if (x->after_gap[i] || x->t[i] - x->t[i - 1] > gap_distances * mean)
            steps.gap[steps.gaps++] = i;
    steps.powers = x->n > 2 * (size_t)(steps.gaps + POWERS_MAX) ? 3 : 2;
    if (steps.gaps == 0 || x->n < (size_t)(steps.gaps + 4) || !fit_weighted(x, &steps))
        return t_gap;
    const double T = steps.value[1] / steps.half;
    for (int k = 0; k < steps.gaps; k++) {
        const size_t first = steps.gap[k];
        const double step = steps.value[steps.powers + k], sigma = steps.sigma[steps.powers + k],
                     whole = nearbyint(step / T), left = fabs(step - whole * T);
        if (!(sigma < known * T))
            continue;
        for (size_t i = first; i < x->n; i++)
            x->number[i] += whole;
        if (x->after_gap[first] && left > jump_sigmas * sigma && left > jump_min * T) {
            line->gap[line->gaps++] = first;
            if (x->t[first] - x->t[first - 1] > longest) {
                longest = x->t[first] - x->t[first - 1];
                t_gap = x->t[first - 1];
            }
        }
    }
    set_scale(x, line);
    return t_gap;
}

/* Returns half a 95 % interval of the slope, divided by 1.96. A few times may lie closer to their
 * line by chance than their uncertainties say; only if they lie closer than chance explains is the
 * scatter believed, as for a series without noise (exact). */
static double slope_sigma(const struct times_line *line, bool exact)
{
    static const double normal_95 = 1.96, scatter_chance = 1e-5;
    const double freedom = (double)line->used - line->powers - line->gaps;
    double variance = line->variance;
    if (exact && freedom < 2)
        variance = fmax(variance, 1);
    if (!exact && freedom > 0) {
        const bool chance = variance * freedom > gsl_cdf_chisq_Pinv(scatter_chance, freedom);
        variance *= pow(gsl_cdf_tdist_Pinv(0.975, freedom) / normal_95, 2);
        variance = chance ? fmax(variance, 1) : variance;
    }
    return line->slope_formal * sqrt(variance);
}

/* Warns if the times, by the quadratic fit `bent`, curve against their numbers, and widens the
 * uncertainty to cover the periods at both ends. */
static void warn_bend(const struct times_line *bent, struct period *period)
{
    /* smallest relative change over the recording that is reported */
    static const double change_min = 1e-4;
    const double first_period = (bent->value[1] - 2 * bent->value[2]) / bent->half,
                 last_period = (bent->value[1] + 2 * bent->value[2]) / bent->half;
    if (fabs(last_period / first_period - 1) <= change_min)
        return;
    snprintf(period->warning, sizeof period->warning,
             "the period changes along the recording, from about %.5g to %.5g s", first_period,
             last_period);
    period->period.uncertainty =
        fmax(period->period.uncertainty, 0.25 * fabs(last_period - first_period));
}

/* Reads the period from the times of cycles against their numbers: counts cycles in gaps, tests
 * whether the period changes, and fits the straight line without outliers. `exact` is set for
 * series without noise. Returns false if there are too few. */
bool times_period(struct cycle_times *x, bool exact, struct arena *arena, struct period *period)
{
    enum { BENDS_TIMES_MIN = 5 };
    static const double bends_at = 4; /* standard deviations of the curvature */
    double *scratch = arena_array(arena, x->n + 1, sizeof *scratch);
    struct times_line line = {.gaps = 0};
    size_t first = 0, last = x->n;
    if (!scratch || x->n < 2)
        return false;
    set_scale(x, &line);
    const double jump = exact ? NAN : recount_gaps(x, &line);
    struct times_line bent = line;
    const bool bends = !exact && x->n >= BENDS_TIMES_MIN + (size_t)bent.gaps &&
                       fit_times(x, 3, scratch, &bent) &&
                       fabs(bent.value[2]) > bends_at * bent.sigma[2];
    for (size_t i = 0; i < x->n; i++)
        x->use[i] = x->use[i] || bends;
    if (!fit_times(x, 2, scratch, &line))
        return false;
    while (first + 1 < last && !x->use[first])
        first++;
    while (last > first + 1 && !x->use[last - 1])
        last--;
    period->period =
        (struct measured){line.value[1] / line.half, slope_sigma(&line, exact) / line.half};
    period->first = x->t[first];
    period->last = x->t[last - 1];
    period->periods = nearbyint((period->last - period->first) / period->period.value);
    if (bends)
        warn_bend(&bent, period);
    if (isfinite(jump))
        snprintf(period->warning, sizeof period->warning,
                 "the phase jumps in the gap after t = %.6g s, perhaps because a clock was set; T "
                 "is measured between the gaps",
                 jump);
    return period->period.value > 0;
}

/* Fits a parabola to the times and tests its second derivative. */
double times_curvature(struct cycle_times *x, double sigmas)
{
    struct times_line line = {.powers = 3};
    set_scale(x, &line);
    return fit_weighted(x, &line) && fabs(line.value[2]) > sigmas * line.sigma[2]
               ? 2 * line.value[2] / (line.half * line.half)
               : 0;
}

/* Returns the time from which cycles are counted: the phase on which the first crossings agree, so
 * that a spike does not shift the count. Only the first few are used, as a small error of `guess`
 * would spread the phases of many. */
static double counting_origin(const struct crossing *rising, size_t count, double guess)
{
    enum { ASKED = 15 }; /* crossings that are used */
    double c = 0, s = 0;
    for (size_t i = 0; i < count && i < ASKED; i++) {
        const double angle = TWO_PI * (rising[i].t - rising[0].t) / guess;
        c += cos(angle);
        s += sin(angle);
    }
    return rising[0].t + guess * atan2(s, c) / TWO_PI;
}

/* Reads the period from `count` rising crossings, numbered by multiples of `guess` [s], leaving out
 * those off the common phase. *used becomes the number of crossings fitted. Returns false if fewer
 * than two are left. */
bool crossings_period(const struct crossing *rising, size_t count, double guess, bool exact,
                      struct arena *arena, struct period *period, size_t *used)
{
    static const double off_max = 0.1; /* [periods] largest distance from the phase of most */
    const double origin = count > 0 ? counting_origin(rising, count, guess) : 0;
    double *phase = arena_array(arena, count + 1, sizeof *phase);
    struct cycle_times x;
    if (!phase || !cycle_times_init(&x, count, arena))
        return false;
    for (size_t i = 0; i < count; i++)
        phase[i] = rising[i].t - guess * nearbyint((rising[i].t - origin) / guess);
    const double middle = count > 0 ? values_quantile(phase, count, 0.5) : 0;
    for (size_t i = 0; i < count; i++) {
        const double number = nearbyint((rising[i].t - origin) / guess),
                     sigma = fmax(rising[i].uncertainty, 1e-15 * (fabs(rising[i].t) + guess));
        if (fabs(rising[i].t - middle - guess * number) <= off_max * guess)
            cycle_times_add(&x, rising[i].t, sigma, number, false);
    }
    const bool found = times_period(&x, exact, arena, period);
    *used = 0;
    for (size_t i = 0; i < x.n; i++)
        *used += x.use[i];
    return found && *used >= 2;
}
