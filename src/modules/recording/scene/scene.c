/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits the scene's own equation of motion to a series (study_fit_scene()): finds a start, descends
 * in growing parts of the series, and adds the uncertainties of held values. */
#include <hooke/base/numeric.h>
#include <hooke/base/unit.h>
#include "modules/recording/scene/curve.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Residuals over noise above which the fit misses something. */
#define RESIDUAL_NOISE_RATIO 1.5
#define PHASE_LOST 0.5         /* residuals over spread at which the curve is out of phase */
#define FIRST_PERIODS 1.25     /* [periods] first part, with which a lost fit begins */
#define FIRST_SHARE 0.02       /* share of the series instead, if its period is unknown */
#define PART_GROWTH_FACTOR 1.7 /* growth from part to part */
#define ITERATIONS_MAX 40
/* Largest relative residuals of a simulation, which has no spikes but is not random. */
#define NEGLIGIBLE_RELATIVE 1e-6
#define TOLERANCE_MIN 1e-11 /* bounds of the integration's tolerance */
#define TOLERANCE_MAX 1e-7

/* ---- the start ---- */

/* Returns true if all parameters of the scene's start are fitted, so that t0 can be moved. */
static bool start_is_free(const struct scene_curve *c)
{
    struct parameter_change *d = malloc(sizeof *d);
    bool free_all = d != NULL;
    for (int i = 0; free_all && i < (int)scene_params(&c->scene)->count; i++) {
        bool fitted = i == scene_param(&c->scene, "t0");
        for (int j = 0; j < c->frees; j++)
            fitted = fitted || c->index[j] == i;
        if (!fitted && direction_find(&c->scene, i, d) && d->starts && d->changes == 0)
            free_all = false;
    }
    free(d);
    return free_all;
}

static double value_of(const struct scene *scene, const char *name)
{
    const int index = scene_param(scene, name);
    return index >= 0 ? scene->value[index] : 0;
}

static int free_index(const struct scene_curve *c, const char *name)
{
    for (int j = 0; j < c->frees; j++)
        if (c->index[j] == scene_param(&c->scene, name))
            return j;
    return -1;
}

/* Sets start j and the scene to a value, unless j is negative or the value not allowed. */
static void propose_start(struct scene_curve *c, int j, double value, double *start)
{
    struct scene trial = c->scene;
    struct error ignored;
    if (j < 0 || !isfinite(value) ||
        !scene_set(&trial, c->index[j], (struct measured){value, 0}, &ignored))
        return;
    start[j] = value;
    c->scene = trial;
}

/* Sets in start[] the initial state and a spring's parameters from a damped sine's fit. */
static void improve_start(struct scene_curve *c, const struct fit *fit, double *start)
{
    struct system system;
    struct error ignored;
    const double gamma = isfinite(fit->gamma.value) ? fit->gamma.value : 0,
                 omega = fit->omega.value;
    if (c->scene.model == &oscillator_model && value_of(&c->scene, "k") > 0) {
        const struct measured mass = {value_of(&c->scene, "m"), 0};
        const bool other_drag = value_of(&c->scene, "C") > 0 || value_of(&c->scene, "mu") != 0;
        if (value_of(&c->scene, "k3") == 0)
            propose_start(c, free_index(c, "k"), fit_stiffness(fit, mass).value, start);
        propose_start(c, free_index(c, "gamma"), other_drag ? 0.5 * gamma : gamma, start);
    }
    if (!scene_bind(&c->scene, &system, &ignored) || system.order != 2)
        return;
    /* Each derivative of A exp(-gamma t/2) cos(omega t + phi) is larger by the factor `growth` and
     * earlier by the phase `turn`. */
    const int order = c->rate ? 2 : c->variable > 0;
    const double growth = hypot(0.5 * gamma, omega), turn = atan2(omega, -0.5 * gamma),
                 t = system.t0 - fit->t0;
    const double A = fit->amplitude.value * exp(-0.5 * gamma * t) / pow(growth, order);
    const double phi = fit->phase.value + omega * t - order * turn;
    const struct oscillator *o = &system.oscillator;
    const double middle = o->whole && o->stiffness != 0 ? -o->gravity / o->stiffness : 0;
    const double wanted[2] = {A * cos(phi) + (c->offset || order > 0 ? middle : fit->offset.value),
                              A * (-0.5 * gamma * cos(phi) - omega * sin(phi))};
    struct parameter_change *d = malloc(sizeof *d);
    for (int j = 0; d && j < c->frees; j++) {
        if (!direction_find(&c->scene, c->index[j], d) || d->changes > 0 || d->t0 != 0)
            continue;
        for (int half = 0; half < 2; half++) {
            const int i = half * system.n / 2;
            if (d->start[i] != 0)
                propose_start(c, j, start[j] + (wanted[half] - system.start[i]) / d->start[i],
                              start);
        }
    }
    free(d);
    if (c->offset)
        start[c->frees] = fit->offset.value - (order == 0 ? middle : 0);
}

/* Sets low and high [parameters] to the ranges of the parameters, open ends moved in. */
static void parameter_bounds(const struct scene_curve *c, const double *start, double *low,
                             double *high)
{
    for (int j = 0; j < c->frees + c->offset; j++) {
        const struct param_row *row = j < c->frees
                                          ? (const struct param_row *)(const void *)catalog_row(
                                                scene_params(&c->scene), (size_t)c->index[j])
                                          : NULL;
        high[j] = INFINITY;
        low[j] = row && row->min > -HUGE_VAL ? row->min : -INFINITY;
        if (row && row->min_excluded)
            low[j] += 1e-9 * fabs(start[j] - row->min);
    }
}

/* ---- the fit ---- */

/* State of a fit. */
struct scene_fitting {
    const struct scene_fit_request *request;
    struct scene_curve *curve;
    struct fit_curve as_curve;
    struct curve_options options;
    struct arena *arena;
    double spread;     /* standard deviation of the series */
    double sigma;      /* the same of the last fit's residuals */
    double *parameter; /* [parameters] current point */
    size_t stretch;    /* samples judged together, see struct curve_options */
};

static double spread_of(const struct series *series)
{
    double mean = 0, square = 0;
    for (size_t i = 0; i < series->n; i++)
        mean += series->y[i] / (double)series->n;
    for (size_t i = 0; i < series->n; i++)
        square += (series->y[i] - mean) * (series->y[i] - mean) / (double)series->n;
    return sqrt(square);
}

/* Fits the first n samples from f->parameter, which becomes the answer. All but the last fit are
 * rough. Returns false with the error. */
static bool fit_part(struct scene_fitting *f, size_t n, bool last, struct curve_fit *fit,
                     struct error *error)
{
    struct series part = *f->request->series;
    struct curve_options options = f->options;
    part.n = n;
    options.robust = last && f->request->robust && f->sigma > NEGLIGIBLE_RELATIVE * f->spread;
    options.rough = !last;
    options.costly = true;
    options.stretch = f->stretch;
    options.bootstrap = last ? f->request->bootstrap : 0;
    options.iterations = ITERATIONS_MAX;
    struct arena scratch = {0}; /* nothing but values is wanted of what is not the last */
    const bool ok = scene_curve_mesh(f->curve, f->parameter, &part, error) &&
                    curve_fit(&f->as_curve, &part, f->parameter, &options,
                              last ? f->arena : &scratch, fit, error);
    arena_reset(&scratch);
    if (!ok)
        return false;
    for (int j = 0; j < fit->parameters; j++)
        f->parameter[j] = fit->value[j].value;
    f->sigma = fit->sigma;
    return true;
}

/* Fits all samples at once if the start is good enough; else a few periods [s] first, then longer
 * parts, so that the phase is never lost. Returns false with *error. */
static bool approach_by_parts(struct scene_fitting *f, double period, struct error *error)
{
    const struct series *series = f->request->series;
    double start[CURVE_PARAMETERS], direct[CURVE_PARAMETERS];
    struct curve_fit fit;
    const size_t bytes = (size_t)f->as_curve.parameters * sizeof *start;
    memcpy(start, f->parameter, bytes);
    if (!fit_part(f, series->n, false, &fit, error)) {
        if (error->code != ERROR_COMMAND)
            return false;
        fit.sigma = INFINITY;
        memcpy(f->parameter, start, bytes);
    }
    if (fit.sigma < PHASE_LOST * f->spread)
        return true;
    const double sigma = fit.sigma;
    memcpy(direct, f->parameter, bytes);
    memcpy(f->parameter, start, bytes);
    const size_t min = 4 * (size_t)f->as_curve.parameters;
    const double span = series->t[series->n - 1] - series->t[0];
    const double first = isfinite(period) ? FIRST_PERIODS * period : FIRST_SHARE * span;
    size_t n = min;
    while (n < series->n && series->t[n] < series->t[0] + first)
        n++;
    for (bool all = false; !all; n = (size_t)(PART_GROWTH_FACTOR * (double)n)) {
        all = n >= series->n;
        *error = (struct error){0};
        if (!fit_part(f, all ? series->n : n, false, &fit, error)) {
            if (error->code != ERROR_COMMAND)
                return false;
            fit.sigma = INFINITY;
            break;
        }
    }
    if (!(fit.sigma < sigma))
        memcpy(f->parameter, direct, bytes);
    *error = (struct error){0};
    return true;
}

/* Adds the uncertainties of held values (the mass …) to those of the fit: a change dq moves the
 * answer by (J^T W J)^-1 J^T W dF/dq dq. Returns false with the error if out of memory. */
static bool add_held(struct scene_fitting *f, struct scene_fit *fit, struct error *error)
{
    const struct series *series = f->request->series;
    struct scene_curve both = *f->curve;
    struct curve_fit *curve = &fit->curve;
    const int fitted_frees = f->curve->frees;
    for (int i = 0; i < (int)scene_params(&both.scene)->count && both.frees < CURVE_PARAMETERS - 1;
         i++) {
        struct parameter_change d;
        bool is_free = both.scene.uncertainty[i] == 0;
        for (int j = 0; j < fitted_frees; j++)
            is_free = is_free || both.index[j] == i;
        if (!is_free && direction_find(&both.scene, i, &d) && (d.changes > 0 || d.starts))
            both.index[both.frees++] = i;
    }
    if (both.frees == fitted_frees || both.variation->base.n * (both.frees + 1) > LIMIT_VARIABLES)
        return true;
    const int total = both.frees + both.offset;
    const size_t columns = (size_t)total;
    double parameter[CURVE_PARAMETERS],
        *value = arena_array(f->arena, series->n, sizeof *value),
        *slope = arena_array(f->arena, series->n * columns, sizeof *slope);
    both.work = calloc(method_work_size(both.method, both.variation->base.n * (both.frees + 1)) + 1,
                       sizeof *both.work);
    if (!value || !slope || !both.work) {
        free(both.work);
        return error_memory(error);
    }
    for (int j = 0; j < both.frees; j++)
        parameter[j] = j < fitted_frees ? curve->value[j].value : both.scene.value[both.index[j]];
    parameter[both.frees] = both.offset ? curve->value[fitted_frees].value : 0;
    const bool there = scene_curve_evaluate(&both, parameter, series->t, series->n, value, slope);
    both.mesh = NULL; /* owned by the other curve */
    both.linear = NULL;
    scene_curve_free(&both);
    for (int q = fitted_frees; q < both.frees && there; q++) {
        double pull[CURVE_PARAMETERS] = {0}, moved[CURVE_PARAMETERS] = {0};
        for (size_t i = 0; i < series->n; i++)
            for (int j = 0; j < curve->parameters; j++) /* the offset comes after held values */
                pull[j] += curve->weight[i] *
                           slope[i * columns + (size_t)(j < fitted_frees ? j : both.frees)] *
                           slope[i * columns + (size_t)q];
        /* The inverse of J^T W J is the covariance divided by the widened variance. */
        for (int j = 0; j < curve->parameters; j++) {
            const double wide = curve->value[j].uncertainty / curve->formal[j];
            for (int l = 0; l < curve->parameters && wide > 0; l++)
                moved[j] -=
                    curve->covariance[j][l] / (wide * wide * curve->sigma * curve->sigma) * pull[l];
        }
        for (int j = 0; j < curve->parameters; j++) {
            struct measured *p = &curve->value[j];
            const double old_sigma = p->uncertainty,
                         more = moved[j] * both.scene.uncertainty[both.index[q]];
            if (!(old_sigma > 0))
                continue;
            p->uncertainty = hypot(old_sigma, more);
            for (int side = 0; side < 2; side++)
                curve->interval[j][side] =
                    p->value + (curve->interval[j][side] - p->value) * p->uncertainty / old_sigma;
        }
    }
    return true;
}

/* Chooses the variable, or the derivative of one, that the series shows. Returns false with the
 * error. */
static bool choose_variable(struct scene_curve *c, const struct system *system,
                            enum quantity quantity, struct error *error)
{
    const enum quantity first = system->model->variable[0].quantity;
    if (quantity == first || quantity == QUANTITY_OTHER || first == QUANTITY_NUMBER)
        return true;
    if (system->order == 2 && quantity == system->model->variable[system->n / 2].quantity) {
        c->variable = system->n / 2;
        return true;
    }
    if (quantity == QUANTITY_ACCELERATION && first == QUANTITY_LENGTH && system->order == 2) {
        c->variable = system->n / 2;
        c->rate = true;
        return true;
    }
    error_set(error, ERROR_COMMAND, "the quantity of the series is %s, but the scene computes %s",
              quantity_name(quantity), quantity_name(first));
    return error_hint(error, quantity == QUANTITY_VOLTAGE || quantity == QUANTITY_FORCE
                                 ? "use 'fit', 'fit drag' or 'fit law', which work with volts and "
                                   "newtons; 'adopt' then gives positions per volt or newton"
                                 : "choose another scene, or another column of the file");
}

/* Sets up the curve of the scene with its free parameters. Returns false with the error. */
static bool set_up_curve(const struct scene_fit_request *request, struct scene_curve *c,
                         struct arena *arena, struct error *error)
{
    struct system system;
    const double first = request->series->t[0];
    c->scene = *request->scene;
    c->frees = request->frees;
    c->offset = request->offset;
    c->cancel = request->cancel;
    memcpy(c->index, request->free, (size_t)c->frees * sizeof *c->index);
    c->variation = arena_alloc(arena, sizeof *c->variation);
    if (!c->variation)
        return error_memory(error);
    const int t0 = scene_param(&c->scene, "t0");
    if (t0 >= 0 && free_index(c, "t0") < 0 && start_is_free(c) &&
        !scene_set(&c->scene, t0, (struct measured){first, 0}, error))
        return false;
    if (!scene_bind(&c->scene, &system, error) ||
        !choose_variable(c, &system, request->series->quantity, error))
        return false;
    if (system.n * (c->frees + 1) > LIMIT_VARIABLES || c->frees + c->offset > CURVE_PARAMETERS ||
        c->frees < 1)
        return error_set(
            error, ERROR_COMMAND, "from 1 to %d parameters of this scene can be free, not %d",
            LIMIT_VARIABLES / system.n - 1 < CURVE_PARAMETERS - 1 ? LIMIT_VARIABLES / system.n - 1
                                                                  : CURVE_PARAMETERS - 1,
            c->frees);
    if (first >= system.t0)
        return true;
    error_set(error, ERROR_COMMAND,
              "the first sample, at %g s, is before the scene's start t0 = %g s", first, system.t0);
    return error_hint(error, "set t0, or choose a window");
}

/* Returns a tolerance such that errors of the integration add at most a tenth of the noise's phase
 * error. */
static double tolerance(const struct scene_fitting *f, const struct overview *overview)
{
    const double periods = isfinite(overview->period) ? fmax(overview->periods, 1) : 100;
    const double known = overview->noise / (f->spread * sqrt((double)f->request->series->n));
    return fmin(fmax(0.1 * known / periods, TOLERANCE_MIN), TOLERANCE_MAX);
}

/* Accepts a fit of a simulation as converged if all parameters are determined. Its residuals are
 * errors of two integrations, with which the sum of squares is too rough for the last digits. */
static void accept_simulation(const struct scene_fitting *f, struct curve_fit *fit)
{
    bool determined = fit->sigma < NEGLIGIBLE_RELATIVE * f->spread;
    for (int j = 0; j < fit->parameters; j++) {
        determined = determined &&
                     (fit->bound[j] || (fit->determined[j] && isfinite(fit->value[j].uncertainty)));
        for (int i = 0; i < j; i++)
            determined = determined && fabs(fit->correlation[j][i]) < 1 - NEGLIGIBLE_RELATIVE;
    }
    if (fit->converged || !determined ||
        fit_discards_much(fit->rejected, fit->used + fit->rejected))
        return;
    fit->converged = true;
    snprintf(fit->said, sizeof fit->said,
             "converged in %d iterations; the residual is %.1e of the motion", fit->iterations,
             fit->sigma / f->spread);
}

/* Returns the number of samples in two periods. An error of the scene's law over such a stretch, as
 * in a loud start, is no outlier; bad echoes are few in it. */
static size_t stretch_of(const struct series *series, const struct overview *overview)
{
    enum { LEAST = 40, PARTS = 20 };
    const double n = (double)series->n;
    return (size_t)fmax(LEAST, overview->oscillates ? 2 * n / overview->periods : n / PARTS);
}

/* Searches from the proposed start, and with friction changed by about half a swing, if more than
 * noise is left: each number of half swings before a body sticks has a minimum of its own. */
static bool try_other_swings(struct scene_fitting *f, const double *proposed, double noise,
                             struct error *error)
{
    static const double factors[] = {0, 0.85, 0.93, 1.08, 1.18}; /* 0 means from the given start */
    const int friction = free_index(f->curve, "friction");
    const size_t bytes = (size_t)f->as_curve.parameters * sizeof *proposed;
    double best[CURVE_PARAMETERS], found[CURVE_PARAMETERS], sigma = f->sigma;
    memcpy(found, f->parameter, bytes);
    memcpy(best, f->parameter, bytes);
    for (size_t k = 0;
         k < COUNT_OF(factors) && friction >= 0 && sigma > RESIDUAL_NOISE_RATIO * noise; k++) {
        struct curve_fit fit;
        memcpy(f->parameter, k == 0 ? proposed : found, bytes);
        f->parameter[friction] *= k == 0 ? 1 : factors[k];
        *error = (struct error){0};
        const bool done = fit_part(f, f->request->series->n, false, &fit, error);
        if (!done && error->code != ERROR_COMMAND)
            return false;
        if (done && f->sigma < sigma) {
            sigma = f->sigma;
            memcpy(best, f->parameter, bytes);
        }
    }
    memcpy(f->parameter, best, bytes);
    f->sigma = sigma;
    *error = (struct error){0};
    return true;
}

/* Moves whole turns of a pendulum from the angle to the offset. */
static void take_off_turns(struct scene_fitting *f)
{
    const struct scene_curve *c = f->curve;
    const int angle = is_pendulum(&c->scene) && c->offset ? free_index(c, "theta0") : -1;
    const double turns = angle < 0 ? 0 : TWO_PI * nearbyint(f->parameter[angle] / TWO_PI);
    if (turns != 0) {
        f->parameter[angle] -= turns;
        f->parameter[c->frees] += turns;
    }
}

/* Fits a damped sine, the scene in parts, then all samples. Returns false with the error. */
static bool fit_in_stages(struct scene_fitting *f, struct scene_fit *fit, struct error *error)
{
    const struct series *series = f->request->series;
    struct overview overview;
    struct fit *motion = arena_alloc(f->arena, sizeof *motion);
    struct error ignored = {0};
    struct arena scratch = {0}; /* large, and not needed when the motion is known */
    double proposed[CURVE_PARAMETERS];
    if (!motion)
        return error_memory(error);
    memcpy(proposed, f->parameter, (size_t)f->as_curve.parameters * sizeof *proposed);
    series_overview(series, &scratch, &overview);
    f->stretch = stretch_of(series, &overview);
    f->curve->tol = tolerance(f, &overview);
    if (overview.oscillates) {
        const struct fit_model *row = fit_model_by_name(TEXT("damped"));
        if (row->fit(series, &scratch, f->request->cancel, motion, &ignored) && motion->converged)
            improve_start(f->curve, motion, f->parameter);
    }
    arena_reset(&scratch);
    if (!approach_by_parts(f, overview.oscillates ? overview.period : NAN, error) ||
        !try_other_swings(f, proposed, overview.noise, error))
        return false;
    take_off_turns(f);
    if (!fit_part(f, series->n, true, &fit->curve, error))
        return false;
    accept_simulation(f, &fit->curve);
    return add_held(f, fit, error);
}

bool study_fit_scene(const struct scene_fit_request *request, struct arena *arena,
                     struct scene_fit *fit, struct error *error)
{
    double low[CURVE_PARAMETERS], high[CURVE_PARAMETERS], parameter[CURVE_PARAMETERS] = {0};
    struct scene_curve curve = {.frees = 0};
    *fit = (struct scene_fit){.scene = *request->scene};
    if (!set_up_curve(request, &curve, arena, error))
        return false;
    const int count = curve.frees + curve.offset;
    for (int j = 0; j < count; j++) {
        fit->index[j] = j < curve.frees ? curve.index[j] : -1;
        fit->name[j] = j < curve.frees
                           ? catalog_row(scene_params(&curve.scene), (size_t)curve.index[j])->name
                           : "offset";
        parameter[j] = j < curve.frees ? curve.scene.value[curve.index[j]] : 0;
    }
    struct scene_fitting f = {
        .request = request,
        .curve = &curve,
        .as_curve = {count, fit->name, &curve, scene_curve_evaluate},
        .options = {.low = low, .high = high, .seed = request->seed, .cancel = request->cancel},
        .arena = arena,
        .spread = spread_of(request->series),
        .parameter = parameter};
    parameter_bounds(&curve, parameter, low, high);
    const bool ok = fit_in_stages(&f, fit, error);
    scene_curve_free(&curve);
    if (!ok)
        return false;
    fit->method = curve.method;
    fit->steps = curve.points;
    fit->scene = curve.scene;
    for (int j = 0; j < curve.frees; j++) {
        fit->scene.value[fit->index[j]] = fit->curve.value[j].value;
        fit->scene.uncertainty[fit->index[j]] = fmax(fit->curve.value[j].uncertainty, 0);
        fit->scene.chosen[fit->index[j]] = true;
    }
    return true;
}
