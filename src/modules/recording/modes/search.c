/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the start of a fit of several modes, one mode after the other. The next is searched at the
 * lines of the residuals, and by splitting each mode that was found, since lines closer than the
 * width of the window have a common peak. Linear parameters are always solved for (variable
 * projection). */
#include <hooke/base/cancel.h>
#include "modules/recording/modes/modes.h"
#include "modules/recording/fit/curve_problem.h"

#include <math.h>
#include <string.h>

enum {
    /* Samples that are used, in a normal and in a quick search. */
    THIN = 2048,
    THIN_QUICK = 400,
    /* Lines of the residuals that are tried; trials that are refined; iterations of a
     * refinement. */
    LINES = 4,
    TRIED = 3,
    ITERATIONS = 25,
    ITERATIONS_QUICK = 10
};

/* A quick search continues if the first mode leaves at most this share of the sum of squares. */
#define QUICK_LEFT 0.8

/* Smallest number of samples per period of the fastest line after averaging. */
#define A_PERIOD 8

/* Computes the sum of modes at t [n], value [n], and, unless NULL, its derivatives [n x parameters]
 * by the parameters x, in the form that struct fit_curve expects; context is a struct mode_curve.
 * Returns false if a value is not finite or if cancelled. */
static bool evaluate_modes(void *context, const double *x, const double *t, size_t n, double *value,
                           double *derivative)
{
    const struct mode_curve *c = context;
    for (size_t i = 0; i < n; i++) {
        const double s = t[i] - c->origin;
        double *d = derivative ? derivative + i * (size_t)c->curve.parameters : NULL, sum;
        sum = x[MODES_OFFSET] + x[MODES_SLOPE] * s;
        if (d) {
            d[MODES_OFFSET] = 1;
            d[MODES_SLOPE] = s;
        }
        for (int k = 0; k < c->modes; k++) {
            const double *mode = x + MODES_FIRST + k * MODE_PARAMETERS,
                         angle = mode[MODE_OMEGA] * s;
            const double decay = exp(-0.5 * mode[MODE_GAMMA] * s), u = decay * cos(angle),
                         v = decay * sin(angle);
            const double here = mode[MODE_A] * u + mode[MODE_B] * v;
            sum += here;
            if (!d)
                continue;
            double *slope = d + MODES_FIRST + k * MODE_PARAMETERS;
            slope[MODE_OMEGA] = s * (mode[MODE_B] * u - mode[MODE_A] * v);
            slope[MODE_GAMMA] = -0.5 * s * here;
            slope[MODE_A] = u;
            slope[MODE_B] = v;
        }
        value[i] = sum;
        if (!isfinite(sum) || cancelled_at(c->cancel, i))
            return false;
    }
    return true;
}

/* All but the frequencies and dampings of the modes are linear parameters. */
void mode_curve_init(struct mode_curve *c, int modes, const struct series *series)
{
    static const char *const names[CURVE_PARAMETERS] = {
        "offset", "slope", "omega1", "gamma1", "a1", "b1", "omega2", "gamma2",
        "a2",     "b2",    "omega3", "gamma3", "a3", "b3", "omega4", "gamma4",
        "a4",     "b4",    "omega5", "gamma5", "a5", "b5"};
    *c = (struct mode_curve){.modes = modes, .origin = series->t[0], .cancel = series->cancel};
    c->curve = (struct fit_curve){MODES_FIRST + modes * MODE_PARAMETERS, names, c, evaluate_modes};
    for (int j = 0; j < c->curve.parameters; j++)
        c->linear[j] = j < MODES_FIRST || (j - MODES_FIRST) % MODE_PARAMETERS >= MODE_A;
}

/* Relative rounding of a sum of squares; smaller ones are meaningless. */
#define SQUARES_ROUNDING_RELATIVE 1e-20

/* ---- fewer samples ---- */

/* Returns the frequency [Hz] of the fastest line that stands out, or 0 if there is none. */
static double fastest_line(const struct samples *x, struct arena *arena)
{
    const struct series series = {.t = x->t, .y = x->y, .n = x->n, .cancel = x->cancel};
    struct spectrum_peak peak[LINES];
    bool memory;
    double omega[LINES], max = 0;
    const int peaks = series_peaks(&series, arena, peak, LINES);
    const int candidates = spectrum_candidates(x, omega, LINES, &memory);
    for (int i = 0; i < peaks; i++)
        max = fmax(max, peak[i].frequency.value);
    for (int i = 0; i < candidates; i++)
        max = fmax(max, omega[i] / TWO_PI);
    return max;
}

/* Averages neighbours down to about `wanted` samples, as far as the fastest line permits. Returns
 * false if out of memory. */
static bool thin_out(const struct samples *x, size_t wanted, struct arena *arena,
                     struct series *thin)
{
    const double span = x->t[x->n - 1] - x->t[0], dt = span / (double)(x->n - 1);
    size_t each = x->n / wanted;
    const double max = each > 1 ? 1 / (A_PERIOD * fastest_line(x, arena) * dt) : 1;
    if ((double)each >= max)
        each = (size_t)max;
    return samples_average(x, max >= 2 && each > 1 ? each : 1, arena, thin);
}

/* ---- trials ---- */

/* Frequency and damping of a mode, the parameters in which a sum is not linear. */
struct rates {
    double omega, gamma; /* [rad/s] [1/s] */
};

/* A trial start and its sum of squares. */
struct modes_trial {
    struct rates rates[MODES_MAX];
    double rss;
};

/* State of the search; `best` has the best `count` trials with the present number of modes. */
struct modes_search {
    struct series series;
    double span; /* [s] length of the series */
    struct arena *arena;
    const struct cancel *cancel;
    bool quick;
    int modes; /* number of modes of a trial */
    struct mode_curve curve;
    struct curve_problem problem;
    struct modes_trial best[TRIED];
    int count;
};

/* Sets the nonlinear parameters of x. */
static void put_rates(const struct modes_search *s, const struct rates *rates, double *x)
{
    for (int k = 0; k < s->modes; k++) {
        x[MODES_FIRST + k * MODE_PARAMETERS + MODE_OMEGA] = rates[k].omega;
        x[MODES_FIRST + k * MODE_PARAMETERS + MODE_GAMMA] = rates[k].gamma;
    }
}

/* Tries a start with each of a few damping rates for the modes from number `fresh` on, and stores
 * it in s->best, ordered by rss, if it is among the best. */
static void try_rates(struct modes_search *s, const struct rates *rates, int fresh)
{
    const double damping[] = {0, 4, 16};
    for (size_t i = 0; i < COUNT_OF(damping); i++) {
        struct modes_trial trial;
        double x[CURVE_PARAMETERS];
        memcpy(trial.rates, rates, sizeof trial.rates);
        for (int k = fresh; k < s->modes; k++)
            trial.rates[k].gamma = damping[i] / s->span;
        put_rates(s, trial.rates, x);
        trial.rss = curve_solve_linears(&s->problem, x);
        if (!isfinite(trial.rss))
            continue;
        int rank = s->count < TRIED ? s->count++ : TRIED;
        for (; rank > 0 && trial.rss < s->best[rank - 1].rss; rank--)
            if (rank < TRIED)
                s->best[rank] = s->best[rank - 1];
        if (rank < TRIED)
            s->best[rank] = trial;
    }
}

/* Tries each line in the spectrum of the residuals as the next mode, beside the known ones. */
static void try_lines(struct modes_search *s, const struct rates *known, const double *residual)
{
    const struct series left = {.t = s->series.t, .y = residual, .n = s->series.n};
    struct samples x;
    struct rates rates[MODES_MAX];
    double omega[LINES];
    bool memory;
    if (!samples_init(&x, &left, s->arena))
        return;
    const int lines = spectrum_candidates(&x, omega, LINES, &memory);
    memcpy(rates, known, sizeof rates);
    for (int i = 0; i < lines; i++) {
        rates[s->modes - 1].omega = omega[i];
        try_rates(s, rates, s->modes - 1);
    }
}

/* Tries each known mode as two modes that are a certain number of line widths (1/span) apart. */
static void try_splits(struct modes_search *s, const struct rates *known)
{
    static const double apart[] = {0.8, 1.6};
    for (int k = 0; k + 1 < s->modes; k++) {
        for (size_t i = 0; i < COUNT_OF(apart); i++) {
            struct rates rates[MODES_MAX];
            const double shift = PI * apart[i] / s->span;
            memcpy(rates, known, sizeof rates);
            rates[s->modes - 1] = (struct rates){known[k].omega + shift, known[k].gamma};
            rates[k].omega -= shift;
            if (rates[k].omega > 0)
                try_rates(s, rates, s->modes);
        }
    }
}

/* Stores the answer of a fit as the best start, and its residuals. */
static void keep_start(const struct modes_search *s, const struct curve_fit *fit,
                       struct mode_start *start, double *residual)
{
    for (int j = 0; j < fit->parameters; j++)
        start->value[j] = fit->value[j].value;
    start->rss = fit->rss;
    start->autocorrelation = fit->autocorrelation;
    memcpy(residual, fit->residual, s->series.n * sizeof *residual);
}

/* Fits from each of the best trials (only the first if s->quick), and stores the best minimum in
 * *start and its residuals in residual [n]. Returns false if no fit succeeds with positive
 * frequencies. */
static bool refine(struct modes_search *s, struct mode_start *start, double *residual)
{
    const struct curve_options options = {.rough = true,
                                          .linear = s->curve.linear,
                                          .iterations = s->quick ? ITERATIONS_QUICK : ITERATIONS,
                                          .cancel = s->cancel};
    bool found = false;
    for (int i = 0; i < s->count && i < (s->quick ? 1 : TRIED); i++) {
        double x[CURVE_PARAMETERS] = {0};
        struct curve_fit fit;
        struct error ignored = {0};
        put_rates(s, s->best[i].rates, x);
        if (!curve_fit(&s->curve.curve, &s->series, x, &options, s->arena, &fit, &ignored))
            continue;
        bool sound = true;
        for (int k = 0; k < s->modes; k++)
            sound = sound && fit.value[MODES_FIRST + k * MODE_PARAMETERS + MODE_OMEGA].value > 0;
        if (sound && !(found && !(fit.rss < start->rss))) {
            found = true;
            keep_start(s, &fit, start, residual);
        }
    }
    return found;
}

/* Searches one mode more than in `start`, from lines of the residuals or by splitting a mode,
 * stores the result in *next and replaces the residuals. Returns false if none is found. */
static bool add_mode(struct modes_search *s, const struct mode_start *start,
                     struct mode_start *next, double *residual)
{
    struct rates known[MODES_MAX] = {{0, 0}};
    for (int k = 0; k < s->modes; k++) {
        const double *mode = start->value + MODES_FIRST + k * MODE_PARAMETERS;
        known[k] = (struct rates){mode[MODE_OMEGA], mode[MODE_GAMMA]};
    }
    s->modes++;
    s->count = 0;
    mode_curve_init(&s->curve, s->modes, &s->series);
    if (!curve_problem_init(&s->problem, &s->curve.curve, s->curve.linear, &s->series, s->arena))
        return false;
    try_lines(s, known, residual);
    try_splits(s, known);
    return refine(s, next, residual);
}

/* Fits the straight line (no mode), with which the search for modes begins. Stores its parameters
 * in *start and the residuals in residual [n]. Returns false if the fit fails. */
static bool straight_line(struct modes_search *s, struct mode_start *start, double *residual)
{
    struct curve_fit fit;
    struct error ignored = {0};
    const struct curve_options options = {.rough = true, .cancel = s->cancel};
    const double x[MODES_FIRST] = {0, 0};
    mode_curve_init(&s->curve, 0, &s->series);
    if (!curve_fit(&s->curve.curve, &s->series, x, &options, s->arena, &fit, &ignored))
        return false;
    keep_start(s, &fit, start, residual);
    return true;
}

/* Searches up to `modes` modes: thins the samples, fits a straight line, and adds modes one by one.
 * start[k] becomes the best fit of k modes, *samples the number of samples that it used. `quick`
 * saves time where only a hint is needed. Returns the number found, or -1 if out of memory or
 * cancelled. */
int modes_search(const struct samples *x, int modes, bool quick, const struct cancel *cancel,
                 struct mode_start *start, double *samples)
{
    struct arena arena = {0};
    struct modes_search s = {
        .arena = &arena, .quick = quick, .cancel = cancel, .span = x->t[x->n - 1] - x->t[0]};
    int found = -1;
    double *residual = NULL;
    if (thin_out(x, quick ? THIN_QUICK : THIN, &arena, &s.series) &&
        curve_part(&s.series, &arena, &s.series) && s.series.n > MODES_FIRST)
        residual = arena_array(&arena, s.series.n, sizeof *residual);
    if (residual && straight_line(&s, start, residual))
        found = 0;
    *samples = (double)s.series.n;
    while (found >= 0 && found < modes &&
           s.series.n > (size_t)(MODES_FIRST + (found + 1) * MODE_PARAMETERS) &&
           (!quick || found != 1 || start[1].rss < QUICK_LEFT * start[0].rss) &&
           add_mode(&s, &start[found], &start[found + 1], residual))
        found++;
    arena_reset(&arena);
    return cancelled(cancel) ? -1 : found;
}

double modes_evidence(const struct mode_start *start, int k, int found, double samples)
{
    const double n = samples / autocorrelation_factor(start[found].autocorrelation);
    const double rounding = SQUARES_ROUNDING_RELATIVE * start[0].rss;
    return n * log(fmax(start[k - 1].rss, rounding) / fmax(start[k].rss, rounding)) -
           MODE_PARAMETERS * log(n) - 2 * log(n / 2);
}
