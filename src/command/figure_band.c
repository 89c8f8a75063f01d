/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The band of an adopted fit's uncertainty about the run of what was adopted. */
#include "figure_drawing.h"

#include <math.h>

#define NORMAL_95 1.959963984540054 /* standard deviations on each side of 95 % */
#define TIMES_MOST 1000000

static bool refuse(const struct drawing *d, const char *why)
{
    error_at(d->error, d->request->band, "%s", why);
    return error_hint(d->error, "fit; adopt; run; plot position --band");
}

static bool refuse_value(const struct drawing *d, const struct run *run, int place)
{
    const struct scene *adopted = &d->session->adopted.scene;
    const struct param_row *row = param_at(adopted, place);
    struct buffer text = {0};
    buffer_format(&text, "%s is ", row->row.name);
    buffer_quantity(&text, run->scene.value[place], row->quantity, 6);
    buffer_format(&text, " in run %d, and ", run->number);
    buffer_quantity(&text, adopted->value[place], row->quantity, 6);
    buffer_put(&text, TEXT(" in the adopted fit"));
    error_at(d->error, d->request->band, "%s",
             text.data && !text.failed ? text.data : "it is another scene");
    buffer_free(&text);
    return error_hint(d->error, "adopt; run; plot position --band");
}

/* Whether it is one motion of one scene: a jump of the state is two rows at one time. */
static bool is_one_motion(const struct run *run)
{
    const size_t rows = trace_count(run->trace);
    for (size_t i = 1; i < rows; i++)
        if (trace_time(run->trace, i) == trace_time(run->trace, i - 1) ||
            run_system_to(run, i) != run_system_to(run, 1))
            return false;
    return run_never_changed(run);
}

/* Whether the run is one of just what was adopted. */
static bool is_adopted(const struct drawing *d, const struct run *run)
{
    const struct adopted_fit *adopted = &d->session->adopted;
    if (!adopted->scene.model)
        return refuse(d, "there is no adopted fit whose uncertainty could be drawn");
    if (run->scene.model != adopted->scene.model)
        return refuse(d, "the adopted fit is one of another scene than the run");
    for (int i = 0; i < (int)scene_params(&run->scene)->count; i++)
        if (run->scene.value[i] != adopted->scene.value[i])
            return refuse_value(d, run, i);
    if (!is_one_motion(run))
        return refuse(d, "the run was changed on its way");
    if (run_goes_back(run))
        return refuse(d, "the run goes back in time: the band is that of a run forwards");
    return adopted->count > 0 || refuse(d, "the adopted fit states no uncertainties");
}

static bool add_band(struct drawing *d, const struct run *run, int coordinate, struct curve *curve)
{
    const struct adopted_fit *adopted = &d->session->adopted;
    double *spread = arena_array(d->arena, curve->n, sizeof *spread);
    const struct spread_request request = {.scene = &run->scene,
                                           .place = adopted->place,
                                           .count = adopted->count,
                                           .covariance = adopted->covariance,
                                           .variable = coordinate,
                                           .t = curve->x,
                                           .n = curve->n,
                                           .cancel = d->session->front.cancel};
    if (!spread)
        return error_memory(d->error);
    if (!study_spread(&request, d->arena, spread, d->error))
        return false;
    for (size_t i = 0; i < curve->n; i++)
        spread[i] *= NORMAL_95;
    curve->spread = spread;
    curve->spread_label = coordinate == 0 ? "95 % of the fit" : NULL;
    return true;
}

bool drawing_band(struct drawing *d)
{
    const struct figure_request *request = d->request;
    if (request->kind != PLOT_POSITION || request->columns > 0 || request->at.len > 0)
        return refuse(d, "--band is for positions over time");
    if (request->runs != 1)
        return refuse(d, "--band needs one run, that of an adopted fit");
    const struct run *run = d->session->run[request->run[0]]->run;
    if (!is_adopted(d, run))
        return false;
    if (d->curve[0].n > TIMES_MOST) {
        error_at(d->error, request->band, "a band of %zu rows is too long", d->curve[0].n);
        return error_hint(d->error, "choose a part: plot position --band window=FROM:TO");
    }
    for (int i = 0; i < d->coordinates; i++)
        if (d->curve[i].n > 0 && !add_band(d, run, i, &d->curve[i]))
            return false;
    return true;
}
