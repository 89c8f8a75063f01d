/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines of a spectrum: each is fitted as a sine by least squares and subtracted before the next is
 * searched; then all are fitted together (CLEAN, Hogbom 1974; refinement of all components as
 * Foster, Astron. J. 109 (1995) 1889). Uncertainties are those of least squares, which for a steady
 * tone are the Cramer-Rao bound (Rife and Boorstyn, IEEE Trans. Inf. Theory 20 (1974) 591, with
 * twice the variance of their complex tone; Kay, Fundamentals of Statistical Signal Processing I
 * (1993), example 3.14). They use the variance of the residuals, or their power beside the line if
 * it is larger: a decay, an unsteady period or a neighbour leaks into it. */
#include <hooke/base/cancel.h>
#include "modules/recording/series/internal.h"

#include <math.h>
#include <string.h>

/* Bins on each side of a line that are its surroundings. */
#define SURROUNDING_BINS 4
/* [bins] Half width of a line's foot, within which no second line is accepted. */
#define LINE_FOOT_BINS 1.5
/* Rounds in which each line is fitted again beside the others. */
#define REFIT_ROUNDS 6
/* Smallest amplitude relative to the first line. */
#define LINE_MIN_FRACTION 0.01
/* Standard deviations by which a line exceeds its surroundings: none of 10^4 bins does by
 * chance. */
#define LINE_CLEAR_SIGMAS 8
/* The same for the first line above white noise; its own foot counts as noise, as it may be
 * broad. */
#define FIRST_LINE_CLEAR_SIGMAS 6
/* Smallest decrease of the sum of squares by damping, in variances of a residual. */
#define DAMPED_BETTER 12.0

/* Returns the variance of the residuals at frequencies near omega [rad/s]: the mean power in a few
 * bins on both sides, 0 if cancelled. */
double variance_beside(const struct samples *x, const double *residual, double omega)
{
    const double bin = TWO_PI / (x->t[x->n - 1] - x->t[0]);
    double power = 0, used = 0, bins = 0;
    for (int k = -SURROUNDING_BINS; k <= SURROUNDING_BINS; k++) {
        const double w = omega + k * bin;
        double c = 0, s = 0, n = 0;
        for (size_t i = 0; i < x->n && k != 0 && w > 0.5 * bin; i++) {
            if (i % LOOK_EACH_ROWS == 0 && cancelled(x->cancel))
                return 0;
            if (!x->use[i])
                continue;
            c += residual[i] * cos(w * (x->t[i] - x->t[0]));
            s += residual[i] * sin(w * (x->t[i] - x->t[0]));
            n++;
        }
        power += c * c + s * s;
        used += n;
        bins += n > 0;
    }
    return bins > 0 ? power / used : 0;
}

/* Returns the mean of a line's envelope over the samples, relative to its value at the origin. */
static double mean_envelope(const struct samples *x, const struct harmonic *h)
{
    double sum = 0, used = 0;
    for (size_t i = 0; i < x->n && !cancelled_at(x->cancel, i); i++)
        if (x->use[i]) {
            sum += exp(-0.5 * h->gamma * (x->t[i] - h->origin));
            used++;
        }
    return sum / used;
}

/* Sets amplitude and frequency of a line with their uncertainties. Returns true if it stands out of
 * `residual`, what all lines leave. `first` tells that it is the first line. */
static bool line_stands_out(const struct samples *x, const struct harmonic *h,
                            enum harmonic_free unknowns, const double *residual, bool first,
                            struct spectrum_peak *peak)
{
    const double amplitude = hypot(h->a, h->b) * (h->gamma == 0 ? 1 : mean_envelope(x, h)),
                 n = (double)h->used, white = harmonic_sigma(h, (int)unknowns);
    const double variance = fmax(white * white, variance_beside(x, residual, h->omega));
    peak->amplitude = (struct measured){amplitude, sqrt(2 * variance / n)};
    peak->frequency = (struct measured){
        h->omega / TWO_PI, sqrt(variance * h->inverse[RATE_OMEGA][RATE_OMEGA]) / TWO_PI};
    const double chance = first ? FIRST_LINE_CLEAR_SIGMAS * white * sqrt(2 / n)
                                : LINE_CLEAR_SIGMAS * peak->amplitude.uncertainty;
    return amplitude > chance;
}

/* Fits a sine near omega [rad/s]. Returns false if it fails or moves by more than one bin. */
static bool fit_line(const struct samples *x, double omega, enum harmonic_free unknowns,
                     struct harmonic *h, double *residual)
{
    const double span = x->t[x->n - 1] - x->t[0];
    *h = (struct harmonic){.omega = omega, .origin = x->t[0] + 0.5 * span};
    return omega > 0 && harmonic_fit(x, unknowns, h, residual) &&
           fabs(h->omega - omega) <= TWO_PI / span;
}

/* Fits `count` lines together: each in turn again to what the others leave. `unknowns` are the free
 * parameters of a line; residual [n] is updated, work [n] is scratch space. Returns false if a line
 * is lost or if cancelled. */
static bool fit_together(const struct samples *x, struct harmonic *line, int count,
                         enum harmonic_free unknowns, double *residual, double *work)
{
    struct samples one = *x;
    one.y = work;
    for (int k = 0; k < REFIT_ROUNDS * count; k++) {
        struct harmonic *h = &line[k % count];
        const double a = h->a, b = h->b, omega = h->omega, origin = h->origin, gamma = h->gamma;
        for (size_t i = 0; i < x->n; i++) {
            if (i % LOOK_EACH_ROWS == 0 && cancelled(x->cancel))
                return false;
            const double elapsed = x->t[i] - origin, phase = omega * elapsed;
            work[i] = residual[i] + exp(-0.5 * gamma * elapsed) * (a * cos(phase) + b * sin(phase));
        }
        if (!fit_line(&one, omega, unknowns, h, residual))
            return false;
    }
    return true;
}

/* Searches the next line in `left` [n], what `found` lines leave, and fits all together. Returns
 * true if every line then stands out and is separate from the others. */
static bool next_spectrum_line(const struct samples *x, struct harmonic *line, int found,
                               struct spectrum_peak *peak, double *left, double *work)
{
    bool memory;
    struct samples rest = *x;
    rest.y = found > 0 ? left : x->y;
    const double omega = peak_frequency(&rest, &memory), bin = TWO_PI / (x->t[x->n - 1] - x->t[0]);
    if (!fit_line(&rest, omega, FREE_OMEGA, &line[found], work))
        return false;
    memcpy(left, work, x->n * sizeof *left);
    if (found > 0 && !fit_together(x, line, found + 1, FREE_OMEGA, left, work))
        return false;
    bool good = true;
    for (int i = 0; i <= found && good; i++) {
        good = line_stands_out(x, &line[i], FREE_OMEGA, left, found == 0, &peak[i]) &&
               hypot(line[i].a, line[i].b) >= LINE_MIN_FRACTION * hypot(line[0].a, line[0].b);
        for (int j = 0; j < i; j++)
            good &= fabs(line[i].omega - line[j].omega) > LINE_FOOT_BINS * bin;
    }
    return good;
}

/* Fits all spectral lines together as damped sines, starting from the undamped ones in line
 * [count], and replaces peak [count] if these describe the series clearly better, since a decaying
 * line leaves residuals beside its own frequency that make it seem less certain. `left` receives
 * the residuals and `work` is scratch space, each with an element per sample or more. */
static void fit_damped_lines(const struct samples *x, struct harmonic *line, int count,
                             struct spectrum_peak *peak, double *left, double *work)
{
    double steady = 0, damped = 0;
    for (size_t i = 0; i < x->n; i++) {
        left[i] = x->y[i] - line[0].c;
        for (int k = 0; k < count; k++) {
            const double phase = line[k].omega * (x->t[i] - line[k].origin);
            left[i] -= line[k].a * cos(phase) + line[k].b * sin(phase);
        }
        steady += x->use[i] * left[i] * left[i];
    }
    if (!fit_together(x, line, count, FREE_GAMMA, left, work))
        return;
    for (size_t i = 0; i < x->n; i++)
        damped += x->use[i] * left[i] * left[i];
    if (!(damped * (1 + DAMPED_BETTER * count / (double)x->n) < steady))
        return;
    for (int k = 0; k < count; k++)
        if (!line[k].converged)
            return;
    for (int k = 0; k < count; k++)
        line_stands_out(x, &line[k], FREE_GAMMA, left, k == 0, &peak[k]);
}

/* Sets peak[] to the significant lines of the spectrum, at most `max`, strongest first: adds lines
 * one by one as long as all are significant, then tries damped ones. Returns their number. */
int series_peaks(const struct series *series, struct arena *arena, struct spectrum_peak *peak,
                 int max)
{
    struct samples x;
    struct spectrum_peak *now = arena_array(arena, (size_t)max, sizeof *now);
    struct harmonic *line = arena_array(arena, (size_t)max, sizeof *line),
                    *found = arena_array(arena, (size_t)max, sizeof *found);
    double *left = arena_array(arena, series->n + 1, sizeof *left);
    double *work = arena_array(arena, series->n + 1, sizeof *work);
    int count = 0;
    if (series->n < 8 || !now || !line || !found || !left || !work ||
        !samples_init(&x, series, arena))
        return 0;
    samples_flag_spikes(&x, work);
    for (; count < max && !cancelled(x.cancel) &&
           next_spectrum_line(&x, line, count, now, left, work);
         count++) {
        memcpy(peak, now, (size_t)(count + 1) * sizeof *peak);
        memcpy(found, line, (size_t)(count + 1) * sizeof *found);
    }
    if (count > 0 && !cancelled(x.cancel))
        fit_damped_lines(&x, found, count, peak, left, work);
    for (int k = 0; k < count && x.pace > 0; k++)
        peak[k].frequency = measured_at_pace(peak[k].frequency, x.pace);
    return count;
}
