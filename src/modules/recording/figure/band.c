/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The 95 % band around the run of an adopted fit, for figures, panes and plans. */
#include <hooke/base/unit.h>
#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"
#include "modules/recording/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Standard deviations on each side of a 95 % interval. */
#define NORMAL_95 1.959963984540054
/* Points of a band at most. */
#define TIMES_MAX 1000000

/* Sets the error with the reason and a hint. Returns false. */
static bool refuse_band(struct text where, struct error *error, const char *why)
{
    error_at(error, where, "%s", why);
    return error_hint(error, "fit; adopt; run; plot position --band");
}

/* Sets the error for a parameter that differs between the run and the adopted fit. Returns
 * false. */
static bool refuse_value(const struct session *session, const struct run *run, int index,
                         struct text where, struct error *error)
{
    const struct scene *adopted = &fits_of(session)->adopted.scene;
    const struct param_row *row = param_at(adopted, index);
    error_at(error, where, "%s is %s in run %d, and %s in the adopted fit", row->row.name,
             SHOWN_QUANTITY(run->scene.value[index], row->quantity, 6), run->number,
             SHOWN_QUANTITY(adopted->value[index], row->quantity, 6));
    return error_hint(error, "adopt; run; plot position --band");
}

/* Returns true if the run is one motion of one scene. A jump of the state would show as two rows at
 * one time. */
static bool is_one_motion(const struct run *run)
{
    const size_t rows = trace_count(run->trace);
    for (size_t i = 1; i < rows; i++)
        if (trace_time(run->trace, i) == trace_time(run->trace, i - 1) ||
            run_system_to(run, i) != run_system_to(run, 1))
            return false;
    return run_never_changed(run);
}

/* Returns true if the run has an uncertainty band: its scene has the values of the adopted fit, it
 * was not changed and goes forwards. Otherwise returns false with the error at `where`. */
bool band_of_run(const struct session *session, const struct run *run, struct text where,
                 struct error *error)
{
    const struct adopted_fit *adopted = &fits_of(session)->adopted;
    if (!adopted->scene.model)
        return refuse_band(where, error, "there is no adopted fit, so no uncertainty can be drawn");
    if (run->scene.model != adopted->scene.model)
        return refuse_band(where, error, "the adopted fit belongs to another scene than the run");
    for (int i = 0; i < (int)scene_params(&run->scene)->count; i++)
        if (run->scene.value[i] != adopted->scene.value[i])
            return refuse_value(session, run, i, where, error);
    if (!is_one_motion(run))
        return refuse_band(where, error, "the run was changed after its start");
    if (run_goes_back(run))
        return refuse_band(where, error,
                           "the run goes back in time; a band exists only for runs forwards");
    return adopted->known.count > 0 ||
           refuse_band(where, error, "the adopted fit states no uncertainties");
}

/* Sets half [n] to the half width of the 95 % band of a variable of the run at the times t [n].
 * Returns false with the error if there are too many times or if it cannot be computed. */
bool band_half(const struct session *session, const struct run *run, int variable, const double *t,
               size_t n, struct arena *arena, double *half, struct error *error)
{
    const struct adopted_fit *adopted = &fits_of(session)->adopted;
    const struct spread_request request = {.scene = &run->scene,
                                           .known = &adopted->known,
                                           .variable = variable,
                                           .t = t,
                                           .n = n,
                                           .cancel = session->front.cancel};
    if (n > TIMES_MAX) {
        error_set(error, ERROR_COMMAND, "a band cannot have %zu rows", n);
        return error_hint(error, "choose a shorter part: plot position --band window=FROM:TO");
    }
    if (n > 0 && !study_spread(&request, arena, half, error))
        return false;
    for (size_t i = 0; i < n; i++)
        half[i] *= NORMAL_95;
    return true;
}

/* ---- in a figure ---- */

/* Returns the state variable that the plot draws as its first coordinate, or -1 if it draws
 * none. */
static int first_variable(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    if (request->columns > 0 || request->event.len > 0)
        return -1;
    if (!kind_of(d)->coordinates || (!d->model && kind_of(d)->vertical != VERTICAL_FIRST))
        return -1;
    return d->model ? (int)(vertical_variable(d->model, request->kind) - d->model->variable) : 0;
}

/* Returns the label of the band of a coordinate; only the first has one. */
static const char *label_of(int coordinate)
{
    return coordinate == 0 ? "95 % of the fit" : NULL;
}

/* Returns an array for half the band's width at each point of curve i, or NULL with the error. */
static double *new_spread(struct drawing *d, int i, bool named)
{
    struct curve *curve = &d->curve[i];
    double *half = arena_array(d->arena, curve->n + 1, sizeof *half);
    if (!half)
        error_memory(d->error);
    curve->spread = half;
    curve->spread_label = named ? label_of(i) : NULL;
    return half;
}

/* Computes the uncertainty band of each curve of the figure, for the argument --band. Returns false
 * with d->error unless the figure shows positions and velocities over time of exactly one run of
 * the adopted scene. */
bool drawing_band(struct drawing *d)
{
    const struct figure_request *request = d->request;
    const int first = first_variable(d);
    if (first < 0)
        return refuse_band(request->band, d->error,
                           "--band works only for positions and velocities over time");
    if (request->runs != 1)
        return refuse_band(request->band, d->error,
                           "--band needs exactly one run, made after 'adopt'");
    const struct run *run = d->session->runs.slot[request->run[0]]->run;
    if (!band_of_run(d->session, run, request->band, d->error))
        return false;
    for (int i = 0; i < d->coordinates; i++) {
        const struct curve *curve = &d->curve[i];
        double *half = new_spread(d, i, true);
        if (!half ||
            !band_half(d->session, run, first + i, curve->x, curve->n, d->arena, half, d->error))
            return false;
    }
    return true;
}

static const struct row band_rows[] = {
    {"off", "", "panes show only the runs", "", NULL},
    {"on", "",
     "panes show the 95 % band around a run that follows 'adopt', computed once after the run", "",
     NULL},
};
const struct catalog recording_band_catalog = CATALOG("kind of band", band_rows);

/* Returns true if the user has switched on the band in panes. */
static bool band_is_shown(const struct session *session)
{
    return setting_of_module(&session->setup.settings, "band") > 0;
}

/* Adds the stored band, interpolated at their points, to the curves if it belongs to the first run
 * of the figure. Returns false if out of memory. */
bool drawing_stored_band(struct drawing *d)
{
    const struct fit_band *band = &fits_of(d->session)->band;
    const int first = first_variable(d);
    if (!band_is_shown(d->session) || first < 0 || d->request->runs < 1 || band->n == 0 ||
        d->session->runs.slot[d->request->run[0]]->run->number != band->run)
        return true;
    for (int i = 0; i < d->coordinates; i++) {
        double *half = new_spread(d, i, first == 0);
        if (!half)
            return false;
        for (size_t k = 0; k < d->curve[i].n; k++)
            half[k] = stored_band_at(band, first + i, d->curve[i].x[k]);
    }
    return true;
}

/* ---- kept for the panes ---- */

/* Points a period of the stored band: straight lines between them are off by 0.1 %. Smallest and
 * largest number of points. */
#define A_PERIOD 64
#define KEPT_MIN 500
#define KEPT_MAX 20000

/* Interpolates linearly between the neighbouring values stored. */
double stored_band_at(const struct fit_band *band, int variable, double t)
{
    const double index = (t - band->t_begin) / band->step;
    if (variable >= band->variables || !(index > -1e-6) || !(index < (double)band->n - 1 + 1e-6))
        return NAN;
    const double *half = band->half + (size_t)variable * band->n;
    const size_t i = index <= 0 ? 0 : (size_t)fmin(index, (double)(band->n - 2));
    return half[i] + (index - (double)i) * (half[i + 1] - half[i]);
}

/* Returns the number of points of the stored band. */
static size_t band_points(const struct run *run, double span)
{
    const double rhythm = run_rhythm(run);
    const double n = rhythm > 0 ? ceil(A_PERIOD * span / rhythm) : 8 * KEPT_MIN;
    return (size_t)fmin(fmax(n, KEPT_MIN), KEPT_MAX) + 1;
}

/* Computes the stored band of a run for all variables at equally spaced times. Returns false if
 * that fails; band->half may then be allocated. */
static bool find_band(struct session *session, const struct run *run, struct fit_band *band,
                      struct arena *arena)
{
    struct error ignored = {0};
    const double span = run->t - trace_time(run->trace, 0);
    const size_t n = band_points(run, span);
    double *t = arena_array(arena, n, sizeof *t);
    band->half = calloc(n * (size_t)run->system.n, sizeof *band->half);
    if (!t || !band->half)
        return false;
    band->t_begin = trace_time(run->trace, 0);
    band->step = span / (double)(n - 1);
    band->variables = run->system.n;
    for (size_t i = 0; i < n; i++)
        t[i] = i + 1 < n ? band->t_begin + (double)i * band->step : run->t;
    for (int v = 0; v < run->system.n; v++)
        if (!band_half(session, run, v, t, n, arena, band->half + (size_t)v * n, &ignored))
            return false;
    band->n = n;
    return true;
}

/* Computes the uncertainty band of the session's current run and stores it with the fits, if the
 * run or the adopted fit has changed since the last time. Does nothing while a run is computed or
 * if no band is shown. Without a band, e.g. if the run is not of the adopted scene, n is 0. */
void session_store_band(struct session *session)
{
    const struct run *run = session_run(session);
    struct fits *fits = fits_made(session);
    struct error ignored = {0};
    if (!fits || !band_is_shown(session) || fits->adopted.known.count == 0 || !run ||
        session->live.state == LIVE_RUNNING)
        return;
    struct fit_band *band = &fits->band;
    const size_t rows = trace_count(run->trace);
    if (band->run == run->number && band->rows == rows && band->end == run->t &&
        memcmp(&band->adopted, &fits->adopted, sizeof band->adopted) == 0)
        return;
    fits_drop_band(fits);
    band->run = run->number;
    band->rows = rows;
    band->end = run->t;
    memcpy(&band->adopted, &fits->adopted, sizeof band->adopted);
    struct arena arena = {0};
    if (rows > 1 && band_of_run(session, run, TEXT(""), &ignored) &&
        !find_band(session, run, band, &arena)) {
        free(band->half);
        band->half = NULL;
        band->n = 0;
    }
    arena_reset(&arena);
}

/* ---- plan ---- */

/* Appends for `plan` which runs or equations a band of the scene takes, unless the adopted fit does
 * not give it one. */
void band_plan(const struct session *session, struct buffer *text)
{
    struct system system;
    struct error ignored;
    const struct adopted_fit *adopted = &fits_of(session)->adopted;
    const struct scene *scene = &session->setup.scene;
    const int count = adopted->known.count;
    if (count == 0 || adopted->scene.model != scene->model || !scene_bind(scene, &system, &ignored))
        return;
    const int n = system.n;
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        if (scene->value[i] != adopted->scene.value[i])
            return;
    buffer_put(
        text,
        TEXT("band      95 % band of the adopted fit, only on request (--band, 'set band on'): "));
    if (system.switches > 0)
        buffer_format(text, "%d runs of dop853 to 1e-10, two for each uncertain parameter\n",
                      2 * count);
    else
        buffer_format(text,
                      "%d variational equations beside the %d of the motion, once, to 1e-10\n",
                      n * count, n);
}
