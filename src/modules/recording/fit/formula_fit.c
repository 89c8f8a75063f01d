/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits a formula (formula_fit()), with a search for starts that are not given: linear parameters
 * are solved for, the others are tried on the scales of the series, and the best trials are
 * refined. */
#include <hooke/base/cancel.h>
#include "modules/recording/fit/formula.h"
#include "modules/recording/fit/curve_problem.h"

#include <string.h>

/* Samples of the thinned series; random starts; starts that are refined; scales at most. */
enum { THIN = 400, TRIALS = 3000, REFINED = 12, SCALES_MAX = 40 };

/* State of the search for starts. */
struct formula_search {
    struct formula formula; /* the formula, with its columns thinned like the series */
    struct series thin;     /* the thinned series */
    struct fit_curve curve;
    struct curve_problem problem;            /* least-squares problem of the thinned series */
    int unknown[CURVE_PARAMETERS], unknowns; /* parameters that are neither linear nor given */
    double scale[SCALES_MAX];                /* sizes that parameters may have */
    int scales;
    uint64_t state; /* state of the random numbers */
};

/* A trial start and its sum of squares on the thinned series. */
struct formula_trial {
    double x[CURVE_PARAMETERS], rss;
};

static double random_uniform(struct formula_search *s)
{
    return random_fraction(&s->state);
}

/* Thins the series and the formula's columns to THIN samples, at random places within even
 * intervals so that no frequency is hidden by aliasing, and sets up their least-squares problem.
 * Returns false if out of memory. */
static bool thin_out(struct formula_search *s, const struct series *series, struct arena *arena)
{
    size_t n = series->n < THIN ? series->n : THIN, columns = (size_t)s->formula.columns;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    double *values = arena_array(arena, n * (columns + 1), sizeof *values);
    struct formula_column *column = arena_array(arena, columns + 1, sizeof *column);
    if (!t || !y || !values || !column)
        return false;
    for (size_t i = 0; i < n; i++) {
        size_t begin = series->n * i / n, end = series->n * (i + 1) / n;
        size_t index = begin + (size_t)(random_uniform(s) * (double)(end - begin));
        t[i] = series->t[index];
        y[i] = series->y[index];
        for (size_t k = 0; k < columns; k++)
            values[k * n + i] =
                s->formula.column[k].value ? s->formula.column[k].value[index] : t[i];
    }
    for (size_t k = 0; k < columns; k++)
        column[k] = (struct formula_column){s->formula.column[k].name, values + k * n};
    s->formula.column = column;
    s->thin = (struct series){
        .t = t, .y = y, .n = n, .quantity = series->quantity, .cancel = series->cancel};
    s->curve =
        (struct fit_curve){s->formula.parameters, s->formula.name, &s->formula, formula_evaluate};
    return curve_problem_init(&s->problem, &s->curve, s->formula.linear, &s->thin, arena);
}

/* Collects sizes that parameters of a curve through these samples tend to have, as starting values
 * of the fit: frequencies, spans, ranges, and plain numbers. They are appended to s->scale; those
 * that are 0 or not finite are left out. */
static void find_scales(struct formula_search *s, const struct series *series, struct arena *arena)
{
    double low = HUGE_VAL, high = -HUGE_VAL, first = HUGE_VAL, last = -HUGE_VAL;
    for (size_t i = 0; i < series->n; i++) {
        low = fmin(low, series->y[i]);
        high = fmax(high, series->y[i]);
        first = fmin(first, series->t[i]);
        last = fmax(last, series->t[i]);
    }
    double span = last - first, omega = series->n >= 8 ? series_peak_frequency(series, arena) : NAN;
    const double sizes[] = {1,
                            2,
                            0.5,
                            omega,
                            omega / TWO_PI,
                            TWO_PI / omega,
                            0.1 / span,
                            1 / span,
                            3 / span,
                            10 / span,
                            30 / span,
                            100 / span,
                            0.1 * span,
                            0.3 * span,
                            span,
                            3 * span,
                            first,
                            last,
                            high,
                            high - low,
                            low,
                            0.5 * (first + last)};
    for (size_t i = 0; i < COUNT_OF(sizes); i++)
        if (isfinite(sizes[i]) && sizes[i] != 0)
            s->scale[s->scales++] = sizes[i];
}

/* Returns a random value to try: a scale of the series or a size between 1e-5 and 1e3, of either
 * sign. */
static double start_value_pick(struct formula_search *s)
{
    const double size = random_uniform(s) < 0.6 ? s->scale[(size_t)(random_uniform(s) * s->scales)]
                                                : pow(10, 8 * random_uniform(s) - 5);
    return random_uniform(s) < 0.3 ? -size : size;
}

/* Tries random starts of the unknown parameters; `started` has the values of the given ones. Fills
 * best [REFINED], sorted by sum of squares, and returns the number of entries. */
static int try_scales(struct formula_search *s, const struct cancel *cancel, const double *started,
                      struct formula_trial *best)
{
    int candidates = 0, trials = s->unknowns > 0 ? TRIALS : 1;
    for (int k = 0; k < trials && !cancelled(cancel); k++) {
        struct formula_trial trial;
        memcpy(trial.x, started, sizeof trial.x);
        for (int i = 0; i < s->unknowns; i++)
            trial.x[s->unknown[i]] = start_value_pick(s);
        trial.rss = curve_solve_linears(&s->problem, trial.x);
        if (!isfinite(trial.rss))
            continue;
        int position = candidates;
        while (position > 0 && best[position - 1].rss > trial.rss)
            position--;
        /* The same minimum was found before, with other values of redundant parameters. */
        bool twin = position > 0 && best[position - 1].rss >= trial.rss * (1 - 1e-9);
        if (position == REFINED || twin)
            continue;
        candidates = candidates < REFINED ? candidates + 1 : candidates;
        memmove(best + position + 1, best + position,
                (size_t)(candidates - position - 1) * sizeof *best);
        best[position] = trial;
    }
    return candidates;
}

/* Returns true if a is the better answer: converged before not converged, then the smaller sum of
 * squares. */
static bool is_better_fit(const struct curve_fit *a, const struct curve_fit *b)
{
    return a->converged != b->converged ? a->converged : a->rss < b->rss;
}

/* Refinement of starts by full fits; `fit` is the best answer so far. */
struct refining {
    const struct formula *formula;
    const struct series *series;
    const struct curve_options *options;
    struct arena *arena;
    struct curve_fit *fit;
    bool found; /* true if fit holds an answer */
    /* Set if nothing is found; also if cancelled or out of memory, which ends the search. */
    struct error *error;
};

/* Copies a trial, which lives in a temporary arena, into the memory of the answer. Returns false if
 * out of memory. */
static bool keep_formula_fit(struct refining *r, const struct curve_fit *trial)
{
    const size_t n = r->series->n;
    double *residual = r->found ? r->fit->residual : arena_array(r->arena, n, sizeof *residual);
    double *weight = r->found ? r->fit->weight : arena_array(r->arena, n, sizeof *weight);
    if (!residual || !weight)
        return error_memory(r->error);
    memcpy(residual, trial->residual, n * sizeof *residual);
    memcpy(weight, trial->weight, n * sizeof *weight);
    *r->fit = *trial;
    r->fit->residual = residual;
    r->fit->weight = weight;
    r->found = true;
    return true;
}

/* Fits the whole series from the start x and keeps the result if it is the best so far. With
 * `projected`, linear parameters are solved for first, so that their start does not matter. Returns
 * false if the search has to end (cancelled, out of memory); a fit that fails only leaves its
 * error, for when no other is found. */
static bool refine(struct refining *r, const double *x, bool projected)
{
    struct arena scratch = {0};
    struct formula evaluated = *r->formula;
    struct fit_curve curve = {evaluated.parameters, evaluated.name, &evaluated, formula_evaluate};
    struct curve_options options = *r->options;
    struct curve_fit trial;
    struct error local = {0};
    options.linear = projected ? evaluated.linear : NULL;
    bool continues = curve_fit(&curve, r->series, x, &options, &scratch, &trial, &local);
    if (continues) {
        continues = (r->found && !is_better_fit(&trial, r->fit)) || keep_formula_fit(r, &trial);
    } else {
        *r->error = r->found && local.code == ERROR_COMMAND ? *r->error : local;
        continues = local.code == ERROR_COMMAND;
    }
    arena_reset(&scratch);
    return continues;
}

/* Fits a formula that is ready (formula_ready()): from the given starts if there are all, else from
 * the best of a search. Returns false with the error if there is no answer. */
static bool fit_from_starts(const struct formula *formula, const struct series *series,
                            const struct curve_options *options, struct arena *arena,
                            struct curve_fit *fit, struct error *error)
{
    static const struct curve_options none;
    struct curve_options o = options ? *options : none;
    struct formula_search s = {.formula = *formula, .state = 20180920};
    struct refining r = {formula, series, &o, arena, fit, false, error};
    struct formula_trial best[REFINED + 1];
    double answer[CURVE_PARAMETERS];
    bool all = true;
    o.bootstrap = 0;
    for (int j = 0; j < formula->parameters; j++) {
        all = all && formula->started[j];
        if (!formula->linear[j] && !formula->started[j])
            s.unknown[s.unknowns++] = j;
    }
    /* The start that was asked for comes first: the minimum it leads to is what was asked for. */
    if (all && !refine(&r, formula->start, false))
        return false;
    if (!(r.found && fit->converged)) {
        if (!thin_out(&s, series, arena))
            return error_memory(error);
        find_scales(&s, series, arena);
        int candidates = try_scales(&s, o.cancel, formula->start, best);
        for (int k = 0; k < candidates; k++)
            if (!refine(&r, best[k].x, true) || !refine(&r, best[k].x, false))
                return false;
    }
    if (cancelled(o.cancel))
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    if (!r.found && error->code == ERROR_NONE)
        error_set(error, ERROR_COMMAND,
                  "no start values were found for which the formula is finite everywhere");
    if (!r.found)
        return error_hint(error, "give starts: fit 'a*exp(-b*t)' a=5 b=0.1");
    /* The bootstrap is run once, for the answer only. */
    *error = (struct error){0};
    if (!options || options->bootstrap <= 0 || !fit->converged)
        return true;
    for (int j = 0; j < formula->parameters; j++)
        answer[j] = fit->value[j].value;
    o.bootstrap = options->bootstrap;
    r.found = false;
    return refine(&r, answer, false);
}

/* Fits a copy of the formula, compiled for this fit only. */
bool formula_fit(const struct formula *formula, const struct series *series,
                 const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
                 struct error *error)
{
    struct formula ready = *formula;
    ready.cancel = series->cancel;
    if (!enough_samples(series, formula->parameters, error) || !formula_ready(&ready, arena, error))
        return false;
    const bool fitted = fit_from_starts(&ready, series, options, arena, fit, error);
    formula_done(&ready);
    return fitted;
}
