/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits of two or more damped sines at once (series_modes()): normal modes, beats, coupling; and
 * whether a series has two lines. */
#include <hooke/base/cancel.h>
#include "modules/recording/fit/least_squares.h"
#include "modules/recording/modes/modes.h"

#include <math.h>

/* Robust standard deviations from which on a sample is rejected. */
#define REJECTED_ROBUST_SIGMAS 5.0
/* Smaller deviations, relative to the amplitude, are rounding of a simulation. */
#define AMPLITUDE_ROUNDING_RELATIVE 1e-9
/* Standard deviations that an amplitude must have; more if the slowest mode has fewer than
 * SLOW_MODE_PERIODS, as a random walk looks like that. */
#define MODE_SURE_SIGMAS 3.0
#define SURE_SLOW 5.0
#define MODE_CLEAR_NOISE_RATIO 6.0 /* smallest amplitude over the noise beside the line */
#define BIC_DECIDES 6.0            /* difference of BIC that decides */
/* [1/span] distance of frequencies from which on they are resolved */
#define RESOLVED_LINE_WIDTHS 1.5
/* A line in the residuals is reported above this number of standard deviations, and above this
 * share of the smallest mode. */
#define LEFT_LINE_SIGMAS 8.0
#define LEFT_MIN 0.02
#define POOR_RESIDUAL_RATIO 0.10 /* rms of the residuals over that of the signal */
#define SLOW_MODE_PERIODS 3.0    /* fewer periods are hard to separate from the offset */
#define OVERTONE_LINE_WIDTHS 0.1 /* [1/span] distance from a multiple of a slower frequency */
/* Largest share of the sum of squares that a second line may leave; a sway leaves more. */
#define TWO_RATHER 0.3

/* State of a fit of modes. */
struct modes_fitting {
    const struct series *series;
    struct samples samples;
    struct mode_curve curve;
    struct curve_fit fit;
    double covariance[CURVE_PARAMETERS][CURVE_PARAMETERS]; /* widened for correlated residuals */
    double *residual; /* [n] data minus curve, of all samples */
    double *scratch;  /* [n] work space */
    struct arena *arena;
    const struct cancel *cancel;
};

/* Sets *used to the samples in use. Returns false if out of memory. */
static bool used_series(struct modes_fitting *f, struct series *used)
{
    double *t = arena_array(f->arena, f->series->n, sizeof *t),
           *y = arena_array(f->arena, f->series->n, sizeof *y);
    if (!t || !y)
        return false;
    *used = (struct series){.t = t, .y = y, .quantity = f->series->quantity, .cancel = f->cancel};
    for (size_t i = 0; i < f->series->n; i++)
        if (f->samples.use[i]) {
            t[used->n] = f->series->t[i];
            y[used->n++] = f->series->y[i];
        }
    return true;
}

/* Fits the samples in use from the start x, which becomes the answer, and computes all residuals.
 * Returns false with the error. */
static bool fit_from(struct modes_fitting *f, double *x, struct error *error)
{
    const struct curve_options options = {.cancel = f->cancel};
    const struct fit_curve *curve = &f->curve.curve;
    struct series used;
    if (!used_series(f, &used))
        return error_memory(error);
    if (!curve_fit(curve, &used, x, &options, f->arena, &f->fit, error))
        return false;
    for (int j = 0; j < curve->parameters; j++)
        x[j] = f->fit.value[j].value;
    curve->evaluate(curve->context, x, f->series->t, f->series->n, f->scratch, NULL);
    for (size_t i = 0; i < f->series->n; i++)
        f->residual[i] = f->series->y[i] - f->scratch[i];
    return true;
}

/* Updates `use`: rejects samples far off the curve, unless they are too many, and counts them.
 * Returns true if a sample changed sides. */
static bool reject_outlying(struct modes_fitting *f, size_t *rejected)
{
    size_t count = 0, n = f->series->n, far = 0;
    for (size_t i = 0; i < n; i++)
        if (f->samples.use[i])
            f->scratch[count++] = fabs(f->residual[i]);
    const struct measured *mode = f->fit.value + MODES_FIRST;
    const double rounding =
        AMPLITUDE_ROUNDING_RELATIVE * hypot(mode[MODE_A].value, mode[MODE_B].value);
    const double limit = fmax(
        REJECTED_ROBUST_SIGMAS * MAD_TO_SIGMA * values_quantile(f->scratch, count, 0.5), rounding);
    for (size_t i = 0; i < n; i++)
        far += !(fabs(f->residual[i]) <= limit);
    const bool any = limit > 0 && far > 0 && !fit_discards_much(far, n);
    bool changed = false;
    for (size_t i = 0; i < n && any; i++) {
        const bool use = fabs(f->residual[i]) <= limit;
        changed |= use != f->samples.use[i];
        f->samples.use[i] = use;
    }
    *rejected = 0;
    for (size_t i = 0; i < n; i++)
        *rejected += !f->samples.use[i];
    return changed;
}

/* ---- results ---- */

/* Compares the frequencies of modes i and j: negative, zero or positive. */
static int compare_frequency(const double *x, int i, int j)
{
    const double a = x[MODES_FIRST + i * MODE_PARAMETERS], b = x[MODES_FIRST + j * MODE_PARAMETERS];
    return a < b ? -1 : a > b;
}

/* Sets order [modes] to the modes by ascending frequency. */
static void order_by_frequency(const double *x, int modes, int *order)
{
    for (int i = 0; i < modes; i++) {
        int position = i;
        for (; position > 0 && compare_frequency(x, i, order[position - 1]) < 0; position--)
            order[position] = order[position - 1];
        order[position] = i;
    }
}

/* Returns the standard deviation of a linear combination of a mode's parameters, which begin at
 * `first`. */
static double combination_deviation(const struct modes_fitting *f, int first,
                                    const double gradient[MODE_PARAMETERS])
{
    const double *covariance = &f->covariance[first][first];
    return sqrt(
        fmax(quadratic_form(MODE_PARAMETERS, CURVE_PARAMETERS, gradient, covariance, gradient), 0));
}

/* Computes the covariances, each parameter widened by its factor for correlated residuals. */
static void widen_all(struct modes_fitting *f)
{
    const struct curve_fit *fit = &f->fit;
    double widen[CURVE_PARAMETERS] = {0};
    widen[MODES_OFFSET] = widen[MODES_SLOPE] =
        autocorrelation_factor(residual_autocorrelation(&f->samples, f->residual));
    for (int k = 0; k < f->curve.modes; k++) {
        const int first = MODES_FIRST + k * MODE_PARAMETERS;
        const struct measured *x = f->fit.value + first;
        const struct oscillation o = {x[MODE_A].value, x[MODE_B].value, x[MODE_OMEGA].value,
                                      x[MODE_GAMMA].value, f->curve.origin};
        const struct widening w = residual_widening(&f->samples, f->residual, &o, 2);
        widen[first + MODE_OMEGA] = w.phase;
        widen[first + MODE_GAMMA] = w.amplitude;
        widen[first + MODE_A] = widen[first + MODE_B] = fmax(w.amplitude, w.phase);
    }
    for (int i = 0; i < fit->parameters; i++)
        for (int j = 0; j < fit->parameters; j++)
            f->covariance[i][j] = fit->correlation[i][j] * fit->formal[i] * fit->formal[j] *
                                  sqrt(widen[i] * widen[j]);
}

/* Returns mode k in terms of frequency, damping, amplitude and phase, with uncertainties. */
static struct normal_mode mode_of(const struct modes_fitting *f, int k)
{
    const int first = MODES_FIRST + k * MODE_PARAMETERS;
    const struct measured *x = f->fit.value + first;
    const double a = x[MODE_A].value, b = x[MODE_B].value, amplitude = hypot(a, b),
                 square = amplitude * amplitude;
    const double phase = atan2(-b, a);
    const double one[2][MODE_PARAMETERS] = {{[MODE_OMEGA] = 1 / TWO_PI}, {[MODE_GAMMA] = 1}};
    const double of_amplitude[MODE_PARAMETERS] = {
        [MODE_A] = a / amplitude, [MODE_B] = b / amplitude};
    const double of_phase[MODE_PARAMETERS] = {[MODE_A] = b / square, [MODE_B] = -a / square};
    return (struct normal_mode){
        .frequency = {x[MODE_OMEGA].value / TWO_PI, combination_deviation(f, first, one[0])},
        .gamma = {x[MODE_GAMMA].value, combination_deviation(f, first, one[1])},
        .amplitude = {amplitude, combination_deviation(f, first, of_amplitude)},
        .phase = {phase <= -PI ? PI : phase, combination_deviation(f, first, of_phase)}};
}

/* Returns the standard deviation of a quantity from its derivatives by the frequency and the
 * damping of two modes. */
static double pair_deviation(const struct modes_fitting *f, const int mode[2],
                             double derivative[2][2])
{
    double all[CURVE_PARAMETERS] = {0};
    for (int p = 0; p < 4; p++)
        all[MODES_FIRST + mode[p / 2] * MODE_PARAMETERS + p % 2] = derivative[p / 2][p % 2];
    const double square =
        quadratic_form(f->fit.parameters, CURVE_PARAMETERS, all, &f->covariance[0][0], all);
    return sqrt(fmax(square, 0));
}

/* Computes splitting and coupling for two equal oscillators, each with k/m, coupled by kc: omega0^2
 * is k/m if they move alike and (k + 2 kc)/m if they move against each other (French, Vibrations
 * and Waves (1971), chapter 5), where omega0^2 = omega^2 + gamma^2/4. */
static void coupling_set(const struct modes_fitting *f, const int order[2], struct modes_fit *modes)
{
    const struct measured *x[2];
    double square[2];
    for (int i = 0; i < 2; i++) {
        x[i] = f->fit.value + MODES_FIRST + order[i] * MODE_PARAMETERS;
        square[i] = x[i][MODE_OMEGA].value * x[i][MODE_OMEGA].value +
                    0.25 * x[i][MODE_GAMMA].value * x[i][MODE_GAMMA].value;
    }
    double apart[2][2] = {{-1 / TWO_PI, 0}, {1 / TWO_PI, 0}};
    modes->splitting = (struct measured){(x[1][MODE_OMEGA].value - x[0][MODE_OMEGA].value) / TWO_PI,
                                         pair_deviation(f, order, apart)};
    double ratio[2][2], stiff[2][2];
    for (int i = 0; i < 2; i++) {
        const double of_ratio = i ? 0.5 / square[0] : -0.5 * square[1] / (square[0] * square[0]);
        for (int p = 0; p < 2; p++) {
            const double slope = p ? 0.5 * x[i][MODE_GAMMA].value : 2 * x[i][MODE_OMEGA].value;
            ratio[i][p] = of_ratio * slope;
            stiff[i][p] = (i ? 0.5 : -0.5) * slope;
        }
    }
    modes->coupling =
        (struct measured){0.5 * (square[1] / square[0] - 1), pair_deviation(f, order, ratio)};
    modes->stiffness =
        (struct measured){0.5 * (square[1] - square[0]), pair_deviation(f, order, stiff)};
}

/* ---- what should be known about it ---- */

/* Returns true if the faster frequency is a multiple of the slower within `width`, so that it may
 * be an overtone. */
static bool is_overtone(double slow, double fast, double width)
{
    const double n = nearbyint(fast / slow);
    return n >= 2 && fabs(fast - n * slow) < width;
}

/* Adds warnings to the fit about modes that are hardly resolved within the window (span [s]), that
 * are overtones of another one, too slow for the window, or growing. */
static void warn_lines(const struct modes_fit *modes, double span, struct fit *fit)
{
    for (int k = 0; k + 1 < modes->modes; k++) {
        const struct normal_mode *a = &modes->mode[k], *b = a + 1;
        const double apart = (b->frequency.value - a->frequency.value) * span;
        if (apart < RESOLVED_LINE_WIDTHS)
            fit_warn(
                fit,
                "%.5g and %.5g Hz differ by only %.2g line widths (1/%.3g s): they may be one mode "
                "with sway, a drifting period or another law of drag; a longer recording tells",
                a->frequency.value, b->frequency.value, apart, span);
        for (int j = k + 1; j < modes->modes; j++) {
            const struct measured f = modes->mode[j].frequency;
            const double n = nearbyint(f.value / a->frequency.value);
            const double doubt = 2 * hypot(f.uncertainty, n * a->frequency.uncertainty) +
                                 OVERTONE_LINE_WIDTHS / span;
            if (is_overtone(a->frequency.value, f.value, doubt))
                fit_warn(fit,
                         "%.5g Hz is %g times %.5g Hz: probably an overtone of that oscillation, "
                         "not a separate mode",
                         f.value, n, a->frequency.value);
        }
    }
    if (modes->mode[0].frequency.value * span < SLOW_MODE_PERIODS)
        fit_warn(fit,
                 "the window has only %.2g periods of the slowest mode, which is poorly separated "
                 "from the offset",
                 modes->mode[0].frequency.value * span);
    for (int k = 0; k < modes->modes; k++)
        if (modes->mode[k].gamma.value < -2 * modes->mode[k].gamma.uncertainty)
            fit_warn(fit,
                     "the mode of %.5g Hz grows; check that neither a hand nor a drive acts on it",
                     modes->mode[k].frequency.value);
}

/* Warns of lines in the residuals, of a poor fit, and of rejected samples. */
static void warn_residuals(const struct modes_fitting *f, const struct modes_fit *modes,
                           struct fit *fit)
{
    const struct series left = {.t = f->series->t, .y = f->residual, .n = f->series->n};
    struct spectrum_peak line;
    double smallest = HUGE_VAL, signal = 0;
    for (int k = 0; k < modes->modes; k++)
        smallest = fmin(smallest, modes->mode[k].amplitude.value);
    if (series_peaks(&left, f->arena, &line, 1) == 1 &&
        line.amplitude.value >
            fmax(LEFT_LINE_SIGMAS * line.amplitude.uncertainty, LEFT_MIN * smallest))
        fit_warn(fit, "the residuals contain another line, at %.5g Hz%s", line.frequency.value,
                 modes->modes < MODES_MAX ? "; try one more mode" : "");
    for (size_t i = 0; i < f->series->n; i++) {
        const double moves = f->series->y[i] - f->residual[i] - f->fit.value[MODES_OFFSET].value;
        signal += f->samples.use[i] ? moves * moves : 0;
    }
    const double poor = sqrt(f->fit.rss / signal);
    if (poor > POOR_RESIDUAL_RATIO)
        fit_warn(fit, "the model fits poorly: its residuals are %.0f %% of the signal (rms)",
                 100 * poor);
    if (fit->rejected > 0)
        fit_warn(fit,
                 "%zu of %zu samples rejected (missed echoes, spikes): off by more than 5 robust "
                 "standard deviations",
                 fit->rejected, f->series->n);
}

/* Fills *modes with the result of the fit: the modes in order of frequency, offset, uncertainties
 * (widened for correlated residuals), for two modes also their coupling, and warnings. `rejected`
 * is the number of samples left out. */
static void modes_report(struct modes_fitting *f, size_t rejected, struct modes_fit *modes)
{
    static const struct measured none = {NAN, NAN};
    struct fit *fit = &modes->fit;
    double x[CURVE_PARAMETERS] = {0};
    int order[MODES_MAX] = {0};
    const double t0 = f->series->t[0], end = f->series->t[f->series->n - 1];
    for (int j = 0; j < f->fit.parameters; j++)
        x[j] = f->fit.value[j].value;
    order_by_frequency(x, f->curve.modes, order);
    widen_all(f);
    *modes = (struct modes_fit){
        .modes = f->curve.modes, .splitting = none, .coupling = none, .stiffness = none};
    *fit = (struct fit){.model = "modes",
                        .period = none,
                        .omega = none,
                        .gamma = none,
                        .amplitude = none,
                        .phase = none,
                        .halves = {none, none},
                        .half_periods = {none, none},
                        .t0 = t0,
                        .window = {t0, end},
                        .used = f->fit.used,
                        .rejected = rejected,
                        .converged = f->fit.converged,
                        .iterations = f->fit.iterations,
                        .autocorrelation = f->fit.autocorrelation};
    fit->rms = sqrt(f->fit.rss / (double)f->fit.used);
    fit->offset =
        (struct measured){x[MODES_OFFSET], sqrt(f->covariance[MODES_OFFSET][MODES_OFFSET])};
    fit->drift = (struct measured){x[MODES_SLOPE], sqrt(f->covariance[MODES_SLOPE][MODES_SLOPE])};
    for (int k = 0; k < modes->modes; k++)
        modes->mode[k] = mode_of(f, order[k]);
    if (modes->modes == 2)
        coupling_set(f, order, modes);
    modes->residual = f->residual;
    warn_lines(modes, end - t0, fit);
    warn_residuals(f, modes, fit);
}

/* ---- the fit ---- */

/* Sets the error for more modes than are above the noise. Returns false. */
static bool refuse_too_many(int wanted, int found, struct error *error)
{
    if (found == 0)
        return error_set(error, ERROR_NUMERICAL, "no oscillation is above the noise");
    error_set(error, ERROR_NUMERICAL, "only %d frequenc%s above the noise, not %d", found,
              found == 1 ? "y is" : "ies are", wanted);
    return found == 1 ? error_hint(error, "type: fit damped")
                      : error_hint(error, "type: fit modes %d", found);
}

/* Returns the standard deviation of a mode's amplitude in noise as strong as that beside its line.
 * It refers to the start of the window, where a decaying mode is larger than its rms. */
static double noise_beside(const struct modes_fitting *f, const struct normal_mode *mode)
{
    const double variance =
        variance_beside(&f->samples, f->residual, TWO_PI * mode->frequency.value);
    const double decays = mode->gamma.value * (f->series->t[f->series->n - 1] - f->series->t[0]);
    const double rms = fabs(decays) > 1e-6 ? sqrt(-expm1(-decays) / decays) : 1;
    return sqrt(2 * variance / (double)f->fit.used) / rms;
}

/* Returns true if all amplitudes are certain and above the noise; else sets the error, and returns
 * false. */
static bool modes_are_certain(const struct modes_fitting *f, const struct modes_fit *modes,
                              struct error *error)
{
    const double span = f->series->t[f->series->n - 1] - f->series->t[0];
    const double sure =
        modes->mode[0].frequency.value * span < SLOW_MODE_PERIODS ? SURE_SLOW : MODE_SURE_SIGMAS;
    for (int k = 0; k < modes->modes; k++) {
        const struct measured a = modes->mode[k].amplitude;
        if (!(a.value > sure * a.uncertainty)) {
            error_set(error, ERROR_NUMERICAL,
                      "the mode of %.5g Hz is not determined; its amplitude is %.3g +- %.2g",
                      modes->mode[k].frequency.value, a.value, a.uncertainty);
            return error_hint(error, "record longer, or fit fewer modes");
        }
        if (!(a.value > MODE_CLEAR_NOISE_RATIO * noise_beside(f, &modes->mode[k]))) {
            error_set(error, ERROR_NUMERICAL,
                      "the line at %.5g Hz is not above the noise around it",
                      modes->mode[k].frequency.value);
            return error_hint(error, "type: plot spectrum");
        }
    }
    return true;
}

/* Returns the number, up to `count`, of modes above the noise, -1 if out of memory or cancelled. */
static int count_modes(const struct samples *x, int count, const struct cancel *cancel,
                       struct mode_start *start)
{
    /* One mode more is searched for: a missing one would look like correlated noise. */
    const int max = count < MODES_MAX ? count + 1 : count;
    int sure = 0;
    for (int wanted = count; wanted <= max && sure < count; wanted++) {
        double samples;
        const int found = modes_search(x, wanted, false, cancel, start, &samples);
        if (found < 0)
            return found;
        for (sure = 0; sure < found && sure < count &&
                       modes_evidence(start, sure + 1, found, samples) > BIC_DECIDES;)
            sure++;
    }
    return sure;
}

/* Fits `count` damped modes, rejects outliers in up to three rounds; false with the error. */
bool series_modes(const struct series *series, int count, struct arena *arena,
                  const struct cancel *cancel, struct modes_fit *modes, struct error *error)
{
    struct modes_fitting f = {.series = series, .arena = arena, .cancel = cancel};
    struct mode_start start[MODES_MAX + 2];
    size_t rejected = 0;
    f.residual = arena_array(arena, series->n + 1, sizeof *f.residual);
    f.scratch = arena_array(arena, series->n + 1, sizeof *f.scratch);
    if (!f.residual || !f.scratch || !samples_init(&f.samples, series, arena))
        return error_memory(error);
    if (!enough_samples(series, MODES_FIRST + count * MODE_PARAMETERS, error))
        return false;
    samples_flag_spikes(&f.samples, f.scratch);
    const int sure = count_modes(&f.samples, count, cancel, start);
    if (sure < 0)
        return cancelled(cancel) ? error_set(error, ERROR_CANCELLED, "the fit was stopped")
                                 : error_memory(error);
    if (sure < count)
        return refuse_too_many(count, sure, error);
    mode_curve_init(&f.curve, count, series);
    double *x = start[count].value;
    if (!fit_from(&f, x, error))
        return false;
    for (int round = 0; round < 3 && reject_outlying(&f, &rejected); round++)
        if (!fit_from(&f, x, error))
            return false;
    modes_report(&f, rejected, modes);
    return !modes->fit.converged || modes_are_certain(&f, modes, error);
}

/* Returns true if two lines, however damped, may hold most of the power. */
static bool may_be_two_lines(const struct samples *x)
{
    /* least share of the power, and half width of a line, relative to its frequency */
    static const double share_min = 0.5, width = 0.15;
    struct arena arena = {0};
    const bool may = power_share_of_peaks(x, 2, width, &arena) > share_min;
    arena_reset(&arena);
    return may;
}

/* Searches two lines quickly, in thinned samples. Returns the number found, or -1. start[k] becomes
 * the fit of k lines, *samples the number of samples used. */
static int search_two_lines(const struct samples *x, struct mode_start start[3], double *samples)
{
    const struct series all = {.t = x->t, .y = x->y, .n = x->n, .cancel = x->cancel};
    struct arena arena = {0};
    struct series thin;
    struct samples few = *x;
    int found = -1;
    if (series_thin(&all, x->use, THIN_FOR_HINTS, &arena, &thin) &&
        (thin.n == x->n || samples_init(&few, &thin, &arena)))
        found = modes_search(&few, 2, true, x->cancel, start, samples);
    arena_reset(&arena);
    return found;
}

/* Returns true, and sets *pair, if the samples have two resolved modes, both with evidence. */
bool two_lines(const struct samples *x, struct mode_pair *pair)
{
    struct mode_start start[3];
    double samples;
    /* There are not more samples than parameters. */
    if (x->n <= MODES_FIRST + 2 * MODE_PARAMETERS)
        return false;
    const double width = 1 / (x->t[x->n - 1] - x->t[0]);
    if (!may_be_two_lines(x) || search_two_lines(x, start, &samples) < 2 ||
        !(modes_evidence(start, 1, 2, samples) > BIC_DECIDES) ||
        !(modes_evidence(start, 2, 2, samples) > BIC_DECIDES) ||
        !(start[2].rss < TWO_RATHER * start[1].rss))
        return false;
    const double *mode = start[2].value + MODES_FIRST;
    const double one = mode[MODE_OMEGA] / TWO_PI,
                 other = mode[MODE_PARAMETERS + MODE_OMEGA] / TWO_PI;
    const double slow = fmin(one, other), fast = fmax(one, other);
    double sum = 0, square = 0, used = 0;
    for (size_t i = 0; i < x->n; i++) {
        const double y = x->use[i] ? x->y[i] - x->y[0] : 0;
        sum += y;
        square += y * y;
        used += x->use[i];
    }
    *pair = (struct mode_pair){
        {1 / slow, 1 / fast}, 1 / (fast - slow), start[2].rss / (square - sum * sum / used)};
    return fast - slow > RESOLVED_LINE_WIDTHS * width && slow > RESOLVED_LINE_WIDTHS * width &&
           !is_overtone(slow, fast, width);
}
