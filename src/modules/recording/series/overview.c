/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Examines a series before any model, and fits the robust damped sine with which every analysis of
 * an oscillation starts (struct motion). */
#include <hooke/base/cancel.h>
#include "modules/recording/period/track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Limits of what counts as an oscillation. */
#define PERIODS_MIN 1.8 /* [periods] with fewer nothing repeats */
#define DECREMENT_MAX                                                                              \
    3.2 /* largest |gamma| T/2, at which the amplitude changes 25-fold in a period */
#define WEAKLY_DAMPED 0.01    /* gamma/omega: the amplitude changes by 6 % in two periods */
#define SAMPLES_A_PERIOD 2.02 /* samples per period, above the Nyquist limit of 2 */
/* A record of few periods does not oscillate if the sine leaves more than this share of the power,
 * more than this multiple of the noise, and residuals of at least this autocorrelation. */
#define FEW_PERIODS 4
#define FEW_LEAVE 0.1
#define FEW_NOISES 2.0
#define FEW_TOGETHER 0.5
/* standard deviations from which on a slope of the offset is fitted */
#define DRIFT_SLOPE_SIGMAS 3.0
/* Smallest -ln(probability), per frequency, that noise looks the same: large for records that
 * wander, smaller if residuals are hardly correlated. */
#define CHANCE_LOG 20.0
#define WHITE_CHANCE 11.0
#define WHITE_CORRELATION 0.2
#define GONE_DECAY_EXPONENT 6.0 /* gamma times span: the amplitude has fallen to a twentieth */

static void refuse_overview(struct overview *overview, const char *format, ...) PRINTF_LIKE(2, 3);

/* Notes the reason for which a series counts as not oscillating, formatted as by printf(). */
static void refuse_overview(struct overview *overview, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(overview->reason, sizeof overview->reason, format, args);
    va_end(args);
    overview->oscillates = false;
    overview->period = overview->periods = NAN;
}

/* Computes low, high and mean of the samples in use. */
static void overview_extremes(struct motion *m)
{
    struct overview *o = &m->overview;
    double sum = 0;
    size_t used = 0;
    o->low = HUGE_VAL;
    o->high = -HUGE_VAL;
    for (size_t i = 0; i < m->samples.n && !cancelled_at(m->samples.cancel, i); i++) {
        if (m->samples.use[i]) {
            o->low = fmin(o->low, m->samples.y[i]);
            o->high = fmax(o->high, m->samples.y[i]);
            sum += m->samples.y[i];
            used++;
        }
    }
    o->mean = used ? sum / (double)used : NAN;
}

bool overview_is_constant(const struct overview *o)
{
    return !(o->high - o->low > 1e-12 * fmax(fabs(o->high), fabs(o->low)));
}

/* Returns the mean time, weighted by energy, of exp(-gamma t/2) cos; the parameters are least
 * correlated with their origin there. */
static double centre(const struct samples *x, double gamma)
{
    double span = x->t[x->n - 1] - x->t[0], g = gamma * span;
    double position = fabs(g) < 1e-3 ? 0.5 - g / 12 : 1 / g - 1 / expm1(g);
    return x->t[0] + position * span;
}

/* Sets the harmonic to the best of a few damping rates, from none to a decay within a hundredth of
 * the record, at that frequency. Returns false if none can be fitted. */
static bool start_gamma(struct motion *m, double omega)
{
    static const double rates[] = {0, 2, 6, 18, 54, 162};
    double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
    bool found = false;
    for (size_t i = 0; i < COUNT_OF(rates); i++) {
        struct harmonic trial = {.omega = omega, .gamma = rates[i] / span};
        trial.origin = centre(&m->samples, trial.gamma);
        if (!harmonic_fit(&m->samples, FREE_LINEAR, &trial, NULL))
            continue;
        if (found && trial.rss > m->harmonic.rss)
            break;
        m->harmonic = trial;
        found = true;
    }
    return found;
}

/* Refuses an oscillation that noise could have produced: tests the variance ratio of the damped
 * sine against the residuals about a straight line; correlated residuals count as fewer. */
static void require_significant(struct motion *m)
{
    const struct samples *x = &m->samples;
    double n = 0, st = 0, sy = 0, stt = 0, sty = 0, syy = 0, t0 = m->harmonic.origin,
           y0 = m->harmonic.c;
    for (size_t i = 0; i < x->n; i++) {
        double use = x->use[i], t = x->t[i] - t0, y = x->y[i] - y0;
        n += use;
        st += use * t;
        sy += use * y;
        stt += use * t * t;
        sty += use * t * y;
        syy += use * y * y;
    }
    double vt = stt - st * st / n, vy = syy - sy * sy / n, c = sty - st * sy / n,
           total = vy - c * c / vt;
    double explained = total - m->harmonic.rss,
           independent = n / autocorrelation_factor(m->autocorrelation);
    const bool wanders = m->autocorrelation > 0.5;
    const double chance = m->autocorrelation < WHITE_CORRELATION ? WHITE_CHANCE : CHANCE_LOG;
    /* This is no white noise but a wandering offset, with 1/k^2 of its variance in k periods. */
    if (wanders)
        independent = fmax(independent, m->overview.periods * m->overview.periods);
    if (wanders && explained < m->harmonic.rss) {
        refuse_overview(
            &m->overview,
            "one damped sine explains less than half of it (steps, drift, several frequencies)");
    } else if (!(0.5 * independent * explained > (log(0.5 * n) + chance) * m->harmonic.rss)) {
        refuse_overview(&m->overview, "no oscillation is above the noise");
    }
}

/* Decides by the fitted harmonic whether the series oscillates, and sets the period. */
static void judge_oscillation(struct motion *m)
{
    struct overview *o = &m->overview;
    const struct harmonic *h = &m->harmonic;
    double span = m->samples.t[m->samples.n - 1] - m->samples.t[0],
           decrement = PI * h->gamma / h->omega;
    o->period = TWO_PI / h->omega;
    o->periods = span / o->period;
    if (o->periods < PERIODS_MIN) {
        refuse_overview(o, "the window of %.3g s has only %.2g periods; two are needed", span,
                        o->periods);
    } else if (o->period < SAMPLES_A_PERIOD * m->samples.dt) {
        refuse_overview(o, "fewer than %.2g samples per period", SAMPLES_A_PERIOD);
    } else if (fabs(decrement) > DECREMENT_MAX) {
        refuse_overview(o, "it decays within one cycle");
    } else {
        o->oscillates = true;
        o->mean = h->c;
        require_significant(m);
    }
}

/* Refuses a series of which the damped sine leaves out too many samples. */
static void judge_rejected(struct motion *m)
{
    if (fit_discards_much(m->rejected, m->samples.n)) {
        refuse_overview(&m->overview, "a damped sine would leave out %zu of %zu samples",
                        m->rejected, m->samples.n);
    }
}

/* Refuses few periods that a damped sine does not explain, as a random walk may look like two
 * periods. */
static void judge_few(struct motion *m)
{
    const struct samples *x = &m->samples;
    const double left = harmonic_sigma(&m->harmonic, FREE_GAMMA);
    double power = 0;
    for (size_t i = 0; i < x->n; i++)
        power += x->use[i] ? (x->y[i] - m->harmonic.c) * (x->y[i] - m->harmonic.c) : 0;
    if (m->overview.periods < FEW_PERIODS && m->autocorrelation > FEW_TOGETHER &&
        left > FEW_NOISES * m->overview.noise && m->harmonic.rss > FEW_LEAVE * power) {
        refuse_overview(&m->overview, "a damped sine does not explain %.0f %% of the %.2g periods",
                        100 * sqrt(m->harmonic.rss / power), m->overview.periods);
    }
}

/* Gives the offset a slope if that is significant beside the residuals which then remain. */
static void find_drift(struct motion *m)
{
    struct harmonic drifting = m->harmonic;
    drifting.drifts = true;
    if (harmonic_fit(&m->samples, FREE_GAMMA, &drifting, m->scratch) && drifting.converged) {
        double widen = autocorrelation_factor(residual_autocorrelation(&m->samples, m->scratch));
        double sigma = harmonic_sigma(&drifting, FREE_GAMMA) *
                       sqrt(widen * drifting.inverse[LINEAR_D][LINEAR_D]);
        double span = m->samples.t[m->samples.n - 1] - m->samples.t[0],
               exact = 1e-9 * hypot(drifting.a, drifting.b);
        if (fabs(drifting.d) > DRIFT_SLOPE_SIGMAS * sigma && fabs(drifting.d) * span > exact) {
            m->harmonic = drifting;
            memcpy(m->residual, m->scratch, m->samples.n * sizeof(double));
        }
    }
}

/* Returns true if the first damped sine leaves more than half of the variance beyond noise: no
 * better start would make it describe the series. */
static bool is_hopeless(const struct motion *m)
{
    static const double left_max = 0.5;
    const struct harmonic *h = &m->harmonic;
    double sum = 0, square = 0, used = 0;
    for (size_t i = 0; i < m->samples.n; i++)
        if (m->samples.use[i]) {
            const double deviation = m->samples.y[i] - h->c;
            sum += deviation;
            square += deviation * deviation;
            used++;
        }
    const double noise = used * m->overview.noise * m->overview.noise,
                 power = square - sum * sum / used;
    return h->rss - noise > left_max * (power - noise);
}

/* Policy for a first sine that is hopeless: fit anyway, or give up. */
enum sine_hope { SINE_TRIED_ANYWAY, SINE_TRIED_IF_NEAR };

/* Fits the damped sine to all samples, starting from omega [rad/s], and decides whether they
 * oscillate. Returns false if out of memory. */
static bool fit_all_samples(struct motion *m, double omega, enum sine_hope hope,
                            struct arena *arena)
{
    struct overview *o = &m->overview;
    m->harmonic = (struct harmonic){.omega = omega};
    if (!isfinite(omega)) {
        refuse_overview(o, "its spectrum has no peak besides drift");
        return true;
    }
    /* The start shows outliers after two periods, unless the amplitude changes much by then. */
    bool found = start_gamma(m, omega);
    if (found && hope == SINE_TRIED_IF_NEAR && is_hopeless(m)) {
        refuse_overview(o, "one damped sine explains less than half of it");
        return true;
    }
    if (found && m->harmonic.gamma > WEAKLY_DAMPED * omega)
        found = harmonic_fit(&m->samples, FREE_GAMMA, &m->harmonic, NULL);
    if (found && !reject_outliers(m, arena))
        return false;
    if (!found || !harmonic_fit(&m->samples, FREE_GAMMA, &m->harmonic, m->residual)) {
        refuse_overview(o, "no damped sine can be fitted to it");
        return true;
    }
    m->autocorrelation = residual_autocorrelation(&m->samples, m->residual);
    overview_extremes(m);
    judge_oscillation(m); /* drift comes later, as it could make wandering look like this */
    if (!o->oscillates)
        return true;
    find_drift(m);
    if (!censor_clipped(m, arena))
        return false;
    judge_rejected(m);
    if (!o->oscillates)
        return true;
    m->autocorrelation = residual_autocorrelation(&m->samples, m->residual);
    overview_extremes(m);
    o->mean = m->harmonic.c;
    o->period = TWO_PI / m->harmonic.omega;
    o->periods = (m->samples.t[m->samples.n - 1] - m->samples.t[0]) / o->period;
    judge_few(m);
    return true;
}

/* Takes a series as oscillating that no single damped sine describes, but that was followed window
 * by window at the mean frequency omega. The period is the mean over the recording, the harmonic
 * the nearest one. Returns false if out of memory. */
static bool fit_tracked(struct motion *m, double omega, double noise, struct arena *arena)
{
    struct overview *o = &m->overview;
    o->noise = noise;
    if (!fit_all_samples(m, omega, SINE_TRIED_ANYWAY, arena))
        return false;
    m->harmonic.converged = m->harmonic.converged && !fit_discards_much(m->rejected, m->samples.n);
    m->tracked = true;
    o->oscillates = true;
    o->reason[0] = 0;
    o->period = TWO_PI / omega;
    o->periods = (m->samples.t[m->samples.n - 1] - m->samples.t[0]) / o->period;
    return true;
}

/* Fits with the frequency of the first 1/part of the samples, because an oscillation that decays
 * within a few periods has no peak in the spectrum of the whole. Does nothing if a fit with that
 * frequency was refused already. Returns false if out of memory. */
static bool fit_beginning(struct motion *m, size_t part, double noise, double refused_omega,
                          struct arena *arena)
{
    struct samples beginning = samples_part(&m->samples, 0, m->samples.n / part);
    bool memory;
    const double omega = peak_frequency(&beginning, &memory);
    const double span = m->samples.t[m->samples.n - 1] - m->samples.t[0],
                 resolution = TWO_PI * (double)part / span;
    if (!memory || !isfinite(omega) || fabs(omega - refused_omega) < resolution)
        return memory;
    struct overview *o = &m->overview;
    char reason[sizeof o->reason];
    memcpy(reason, o->reason, sizeof reason);
    o->noise = noise;
    memory = fit_all_samples(m, omega, SINE_TRIED_IF_NEAR, arena);
    if (o->oscillates && !(m->harmonic.gamma * span > GONE_DECAY_EXPONENT))
        refuse_overview(o, "%s", reason);
    if (!o->oscillates)
        memcpy(o->reason, reason, sizeof reason);
    return memory;
}

/* Returns true for a long recording in which each sample is mostly noise, and means of neighbours
 * do not oscillate as a whole or in part. Only a fast oscillation that is in neither could
 * remain. */
static bool is_buried(const struct motion *m, double noise, struct arena *arena)
{
    enum { ROWS_LONG = 65536, MEANS = 8192 };
    static const double noise_share = 0.9; /* least noise, in standard deviations of the samples */
    const struct samples *x = &m->samples;
    double sum = 0, square = 0, used = 0;
    for (size_t i = 0; i < x->n && x->n > ROWS_LONG && !cancelled_at(x->cancel, i); i++)
        if (x->use[i]) {
            sum += x->y[i] - x->y[0];
            square += (x->y[i] - x->y[0]) * (x->y[i] - x->y[0]);
            used++;
        }
    if (!(used > 0 && noise > noise_share * sqrt((square - sum * sum / used) / used)))
        return false;
    struct series means;
    struct motion few;
    struct swing swing;
    return samples_average(x, x->n / MEANS, arena, &means) &&
           motion_init(&few, &means, arena, x->cancel) && !few.overview.oscillates &&
           !find_swing(&means, &swing);
}

/* Fits with the frequency of means of neighbours, if they oscillate. Returns false if out of
 * memory. */
static bool fit_as_means(struct motion *m, const struct series *means, double noise,
                         struct arena *arena)
{
    struct motion few;
    if (!motion_init(&few, means, arena, m->samples.cancel))
        return false;
    if (few.overview.oscillates && few.tracked)
        return fit_tracked(m, TWO_PI / few.overview.period, noise, arena);
    m->overview.noise = noise;
    return !few.overview.oscillates ||
           fit_all_samples(m, few.harmonic.omega, SINE_TRIED_ANYWAY, arena);
}

/* Searches an oscillation that the spectrum of the whole did not show: in means, at the beginning,
 * window by window. use [n] is the mask from before the first fit. If nothing is found, the earlier
 * reason stays. Returns false if out of memory. */
static bool search_hidden_oscillation(struct motion *m, const unsigned char *use,
                                      struct arena *arena)
{
    const double seen = samples_noise(&m->samples, m->scratch),
                 noise = fmax(seen, m->quantum / sqrt(12.0));
    const double refused = fit_discards_much(m->rejected, m->samples.n) ? m->harmonic.omega : NAN;
    const struct series all = {
        .t = m->samples.t, .y = m->samples.y, .n = m->samples.n, .cancel = m->samples.cancel};
    struct series means;
    struct track track;
    memcpy(m->samples.use, use, m->samples.n);
    m->buried = is_buried(m, seen, arena);
    if (m->buried)
        return true;
    if (!series_thin(&all, use, THIN_KEEPS_LINES, arena, &means))
        return false;
    if (means.n < all.n)
        return fit_as_means(m, &means, noise, arena);
    for (size_t part = 2; part <= 16 && !m->overview.oscillates; part *= 2) {
        memcpy(m->samples.use, use, m->samples.n);
        if (!fit_beginning(m, part, noise, refused, arena))
            return false;
    }
    if (m->overview.oscillates || cancelled(m->samples.cancel))
        return true;
    memcpy(m->samples.use, use, m->samples.n);
    const bool long_record = all.n > LONG_RECORD;
    if (long_record ? !track_long(&m->samples, arena, &track)
                    : !track_find(&m->samples, arena, &track))
        return false;
    return !(track.omega > 0) || (long_record && !track_is_oscillation(&track)) ||
           fit_tracked(m, track.omega, noise, arena);
}

/* Prepares the samples and fits one damped sine to all of them. *use [n] receives the mask from
 * before the fit, unless the series is refused. Returns false if out of memory or cancelled. */
static bool fit_first_sine(struct motion *m, const struct series *series, struct arena *arena,
                           const struct cancel *cancel, enum sine_hope hope, unsigned char **use)
{
    *m = (struct motion){.overview = {.period = NAN, .periods = NAN, .noise = NAN}};
    m->residual = arena_array(arena, series->n + 1, sizeof(double));
    m->scratch = arena_array(arena, series->n + 1, sizeof(double));
    if (!m->residual || !m->scratch || !samples_init(&m->samples, series, arena))
        return false;
    m->samples.cancel = cancel ? cancel : series->cancel;
    struct overview *o = &m->overview;
    overview_extremes(m);
    if (cancelled(m->samples.cancel))
        return false;
    if (series->n < 8 || !(m->samples.dt > 0)) {
        refuse_overview(o, "it has only %zu samples", series->n);
        return true;
    }
    if (overview_is_constant(o)) {
        o->noise = 0;
        refuse_overview(o, "it is constant");
        return true;
    }
    m->quantum = samples_quantum(&m->samples);
    if (cancelled(m->samples.cancel))
        return false;
    o->noise = fmax(samples_noise(&m->samples, m->scratch), m->quantum / sqrt(12.0));
    samples_flag_spikes(&m->samples, m->scratch);
    *use = arena_alloc(arena, m->samples.n + 1);
    if (!*use || cancelled(m->samples.cancel))
        return false;
    memcpy(*use, m->samples.use, m->samples.n);
    bool memory;
    const double omega = peak_frequency(&m->samples, &memory);
    return memory && fit_all_samples(m, omega, hope, arena);
}

bool motion_one_sine(struct motion *m, const struct series *series, struct arena *arena)
{
    unsigned char *use;
    return fit_first_sine(m, series, arena, NULL, SINE_TRIED_IF_NEAR, &use);
}

bool motion_init(struct motion *m, const struct series *series, struct arena *arena,
                 const struct cancel *cancel)
{
    unsigned char *use = NULL;
    if (!fit_first_sine(m, series, arena, cancel, SINE_TRIED_ANYWAY, &use))
        return false;
    if (!m->overview.oscillates && use && !cancelled(m->samples.cancel) &&
        !search_hidden_oscillation(m, use, arena)) {
        return false;
    }
    if (m->overview.oscillates)
        m->samples.pace = hypot(m->samples.pace, quantum_pace(m));
    return true;
}

bool motion_find(struct motion *m, const struct series *series, struct arena *arena,
                 const struct cancel *cancel, struct error *error)
{
    const bool memory = motion_init(m, series, arena, cancel);
    if (cancelled(m->samples.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped");
    return memory || error_memory(error);
}

bool motion_refuse_known(const struct motion *m, const struct mode_pair *pair,
                         const struct swing *swing, struct error *error)
{
    if (pair) {
        error_set(error, ERROR_COMMAND,
                  "it has two frequencies, T = %.5g and %.5g s, which one sine cannot fit",
                  pair->period[0], pair->period[1]);
        return error_hint(error, "type: fit modes 2");
    }
    if (swing) {
        error_set(error, ERROR_COMMAND,
                  "only part of it is an oscillation: T = %.4g s from t = %.6g to %.6g s",
                  swing->period, swing->window[0], swing->window[1]);
        return error_hint(error, "add: window=%.9g:%.9g", swing->window[0], swing->window[1]);
    }
    error_set(error, ERROR_COMMAND, "the signal does not oscillate: %s", m->overview.reason);
    return error_hint(error, "choose another window or column; at least two periods are needed");
}

/* Finds out whether the series has two frequencies or a part that oscillates, and sets the error.
 * Returns false. */
static bool motion_refuse(const struct motion *m, const struct series *series, struct error *error)
{
    struct mode_pair pair;
    struct swing swing;
    if (overview_is_constant(&m->overview) || m->buried)
        return motion_refuse_known(m, NULL, NULL, error);
    if (two_lines(&m->samples, &pair))
        return motion_refuse_known(m, &pair, NULL, error);
    return motion_refuse_known(m, NULL, find_swing(series, &swing) ? &swing : NULL, error);
}

bool motion_require(struct motion *m, const struct series *series, struct arena *arena,
                    const struct cancel *cancel, struct error *error)
{
    return motion_find(m, series, arena, cancel, error) &&
           (m->overview.oscillates || motion_refuse(m, series, error));
}

void series_overview(const struct series *series, struct arena *arena, struct overview *overview)
{
    struct motion motion;
    if (!motion_init(&motion, series, arena, NULL) || cancelled(series->cancel)) {
        motion.overview = (struct overview){
            .mean = NAN, .low = NAN, .high = NAN, .noise = NAN, .period = NAN, .periods = NAN};
        refuse_overview(&motion.overview, cancelled(series->cancel) ? "stopped" : "out of memory");
    }
    *overview = motion.overview;
}
