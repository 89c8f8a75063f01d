/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes plots of a session into figures: collects curves, chooses the window of time, labels and
 * axes. */
#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/figure/layout.h>
#include <hooke/session/series_tools.h>
#include <hooke/plot/drawing.h>
#include <hooke/plot.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <string.h>

const struct observable *observable_named(const char *name)
{
    return observable_by_name(text_of(name));
}

static const struct run *request_run(const struct drawing *d, int i)
{
    return d->session->runs.slot[d->request->run[i]]->run;
}

/* Returns the observable that is drawn, or NULL for states. It is the kinetic energy if a run has
 * no potential for its forces. */
static const struct observable *drawn_observable(const struct drawing *d)
{
    const struct plot_row *row = kind_of(d);
    if (!row->observable)
        return NULL;
    for (int i = 0; i < d->request->runs && row->energy; i++)
        if (!request_run(d, i)->system.energy)
            return observable_energy(&request_run(d, i)->system);
    return observable_named(row->observable);
}

/* Returns true if the energy that is drawn is the kinetic one. */
static bool is_kinetic(const struct drawing *d)
{
    const struct observable *drawn = kind_of(d)->energy ? drawn_observable(d) : NULL;
    return drawn && !(drawn->needs & NEED_ENERGY);
}

/* Finds the model of all runs. Returns false with an error if they differ or fit no such plot. */
static bool find_model(struct drawing *d)
{
    const struct figure_request *request = d->request;
    const struct run *first = request_run(d, 0);
    d->model = first->system.model;
    for (int i = 1; i < request->runs; i++) {
        const struct run *run = request_run(d, i);
        if (!models_alike(run->system.model, d->model))
            return error_set(
                d->error, ERROR_COMMAND,
                "run %d (%s) and run %d (%s) have different variables, so no plot shows both",
                first->number, first->scene.preset->row.name, run->number,
                run->scene.preset->row.name);
    }
    if (request->columns)
        return drawing_columns(d, &first->system);
    if (!plot_fits(request->kind, d->model)) {
        error_set(d->error, ERROR_COMMAND, "%s has no %s: %s", first->scene.preset->row.name,
                  kind_of(d)->row.name, kind_of(d)->needs);
        return d->model->n > 1 ? error_hint(d->error, "plot %s against %s",
                                            d->model->variable[1].name, d->model->variable[0].name)
                               : false;
    }
    if (kind_of(d)->coordinates && request->runs == 1 && !recording_of(d))
        d->coordinates = plot_coordinates(d->model);
    return true;
}

/* ---- curves ---- */

/* Returns a run's label in the arena: its name or method, with its number if that is not unique. */
const char *drawing_run_label(const struct drawing *d, const struct run *run)
{
    const char *name = run->name[0] ? run->name : run->method->row.name;
    bool alone = true;
    for (int i = 0; i < d->request->runs; i++) {
        const struct run *other = request_run(d, i);
        const char *its = other->name[0] ? other->name : other->method->row.name;
        alone &= other == run || strcmp(its, name) != 0;
    }
    struct buffer text = {0};
    buffer_put(&text, text_of(name));
    if (!alone)
        buffer_format(&text, " (%d)", run->number);
    const char *label = arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return label;
}

/* Returns true if magnitudes are drawn: errors have both signs, on a logarithmic axis. */
static bool draws_magnitude(const struct drawing *d)
{
    return kind_of(d)->log_label && d->request->log;
}

/* Sets y [rows->n] to the values of the plotted quantity, or of its `coordinate`, at these rows. */
static bool vertical_values(struct drawing *d, const struct run *run, int coordinate,
                            const struct chosen_rows *rows, double *y)
{
    const enum plot_kind kind = d->request->kind;
    if (d->request->columns)
        return chosen_at_rows(run, &d->column[coordinate], rows, d->arena, y, d->error);
    if (plot_row(kind)->observable) {
        if (!values_at_rows(run, drawn_observable(d), rows, d->arena, y, d->error))
            return false;
        for (size_t i = 0; i < rows->n && draws_magnitude(d); i++)
            y[i] = fabs(y[i]);
        return true;
    }
    state_at_rows(run, (int)(vertical_variable(d->model, kind) - d->model->variable) + coordinate,
                  rows, y);
    for (size_t i = 0; i < rows->n && d->omega0 != 1; i++)
        y[i] /= d->omega0;
    return true;
}

/* Sets the window [s] of one run: in a plane the last periods before its own end. */
static void run_window(const struct drawing *d, const struct run *run, double window[2])
{
    const double end = trace_time(run->trace, trace_count(run->trace) - 1);
    memcpy(window, d->window, sizeof d->window);
    if (!plot_is_plane(d->request->kind) || !isnan(d->request->window[0]) ||
        !isnan(d->request->window[1]))
        return;
    window[0] = run_goes_back(run) ? end : end - d->shown;
    window[1] = run_goes_back(run) ? end + d->shown : end;
}

/* Adds a curve for each coordinate through the chosen rows. */
static bool add_rows(struct drawing *d, const struct run *run, const struct chosen_rows *rows,
                     const char *label, bool thinned)
{
    const bool plane = plot_is_plane(d->request->kind);
    double *x = arena_array(d->arena, rows->n + 1, sizeof *x);
    if (!x)
        return error_memory(d->error);
    if (plane && d->request->columns) {
        if (!chosen_at_rows(run, &d->horizontal_column, rows, d->arena, x, d->error))
            return false;
    } else if (plane) {
        state_at_rows(run, 0, rows, x);
    }
    double *t = plane ? arena_array(d->arena, rows->n + 1, sizeof *t) : x;
    if (!t)
        return error_memory(d->error);
    for (size_t i = 0; i < rows->n; i++)
        t[i] = trace_time(run->trace, rows->row[i]);
    for (int i = 0; i < d->coordinates; i++) {
        double *y = arena_array(d->arena, rows->n + 1, sizeof *y);
        const char *name = d->coordinates > 1 ? drawing_label(d, i) : label;
        if (!y || !name)
            return error_memory(d->error);
        if (!vertical_values(d, run, i, rows, y))
            return false;
        d->curve[d->curves++] = (struct curve){.label = name,
                                               .x = x,
                                               .y = y,
                                               .n = rows->n,
                                               .t = plane ? t : NULL,
                                               .thinned = d->request->follow || thinned};
    }
    return true;
}

/* Adds the curves of a run. Returns false with an error. */
static bool add_run(struct drawing *d, const struct run *run)
{
    struct curve *curve = &d->curve[d->curves];
    const char *label = drawing_run_label(d, run);
    *curve = (struct curve){.label = label};
    if (!label)
        return error_memory(d->error);
    if (kind_of(d)->run_curve) {
        d->curves++;
        return kind_of(d)->run_curve(d, run, curve);
    }
    double window[2];
    run_window(d, run, window);
    struct arena arena = {0}; /* the numbers of the rows are given back before the curve is read */
    struct chosen_rows rows;
    const struct row_request part = drawing_rows(d, window);
    bool drawn = false;
    const bool ok = choose_rows(run, &part, &arena, &rows, d->error) &&
                    drawing_smooth(d, run, &rows, label, &drawn) &&
                    (drawn || add_rows(d, run, &rows, label, part.count > 0));
    arena_reset(&arena);
    return ok;
}

/* ---- axes ---- */

static double curve_value_max(const struct curve *curve, const double *x)
{
    double max = 0;
    for (size_t i = 0; curve_goes_on(curve, i); i++)
        max = isfinite(x[i]) ? fmax(max, fabs(x[i])) : max;
    return max;
}

static double curves_size(const struct drawing *d, bool x)
{
    double size = 0;
    for (int i = 0; i < d->curves; i++)
        size = fmax(size, curve_value_max(&d->curve[i], x ? d->curve[i].x : d->curve[i].y));
    return size;
}

/* Returns true if so many periods are shown that they run together. In a picture curves of points
 * never do, and lines only if a period has fewer columns than in text. */
static bool is_smeared(const struct drawing *d)
{
    const int width = d->request->width;
    const bool picture = width == PICTURE_COLUMNS;
    bool lines = false;
    for (int i = 0; i < d->curves; i++)
        lines |= !d->curve[i].points;
    return (lines || !picture) && isfinite(d->period) && kind_of(d)->periods &&
           d->shown * (picture ? PERIOD_COLUMNS_PICTURE : PERIOD_COLUMNS_DOTS) >
               d->period * (width - FRAME_COLUMNS);
}

/* Returns the note below the plot: the part of the time shown, or an envelope; NULL for none. */
static const char *make_note(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    const bool wanted = !isnan(request->window[0]) || !isnan(request->window[1]),
               part = !wanted && d->shown < d->total * (1 - 1e-9);
    struct buffer text = {0};
    if (plot_is_plane(request->kind) && part)
        buffer_format(&text, "last %.4g T", drawing_trail(d));
    else if (request->follow && part && !request->running)
        buffer_format(&text, "last %.4g of %.4g s", d->shown, d->total);
    else if (part)
        buffer_format(&text, "last %.4g s", d->shown);
    else if (drawing_shows_spiral(d))
        buffer_format(&text, "%.3g turns", d->total / d->period);
    else if (is_smeared(d))
        buffer_format(&text, "%.0f periods: envelope", d->shown / d->period);
    else if (kind_of(d)->note)
        kind_of(d)->note(d, &text);
    else if (kind_of(d)->energy && d->motion.n > 0)
        buffer_put(&text, text_of(d->motion.how_k));
    drawing_put_delay(d, &text);
    const char *note = text.len ? arena_text(d->arena, buffer_text(&text)) : NULL;
    buffer_free(&text);
    return note;
}

static bool shows_recorded_values(const struct drawing *d, const struct recording *recording)
{
    const struct run *run = d->request->runs > 0 ? request_run(d, 0) : NULL;
    return recording_shows(recording, run, d->request->kind);
}

bool drawing_needs_motion(const struct drawing *d, const struct recording *recording)
{
    return kind_of(d)->of_motion && !shows_recorded_values(d, recording);
}

/* Returns true if the plot cannot show what the recording holds, such as positions. */
static bool holds_other_quantity(const struct drawing *d, const struct recording *recording)
{
    const struct plot_row *row = kind_of(d);
    return row->recorded && !row->any_recording && !row->of_motion && !recorded_bare(recording) &&
           !quantity_is_scaled(recording->column[recording->value].quantity) &&
           !shows_recorded_values(d, recording);
}

static enum quantity vertical_quantity(const struct drawing *d)
{
    const struct recording *recording = recording_of(d);
    const enum plot_kind kind = d->request->kind;
    const bool own =
        d->request->runs == 0 || (plot_row(kind)->residual && !recorded_bare(recording));
    if (recording && own && !drawing_needs_motion(d, recording))
        return recording->column[recording->value].quantity;
    if (d->model && d->omega0 != 1)
        return d->model->variable[0].quantity;
    if (d->request->columns)
        return chosen_variable(&request_run(d, 0)->system, &d->column[0]).quantity;
    if (plot_row(kind)->observable)
        return model_quantity(d->model, drawn_observable(d));
    return vertical_variable(d->model, kind)->quantity;
}

/* Returns the label of the curves in a panel: "y", "x, y", "v/omega0", "E". Returns NULL if out of
 * memory. */
const char *drawing_y_label(const struct drawing *d, int panel)
{
    const struct plot_row *row = kind_of(d);
    if (is_kinetic(d))
        return "E kin";
    if (draws_magnitude(d))
        return row->log_label;
    if (row->label && (!d->model || !row->coordinates))
        return row->label;
    struct buffer text = {0};
    for (int i = 0; i < d->coordinates; i++) {
        const char *name = drawing_label(d, i);
        if (d->coordinates > 1 && d->curve[i].panel != panel)
            continue;
        const char *const next = d->request->next ? "next " : "";
        buffer_format(&text, "%s%s", text.len ? ", " : "", next);
        buffer_put(&text, text_of(name));
    }
    buffer_put(&text, d->omega0 != 1 ? TEXT("/omega0") : TEXT(""));
    const char *label = text.failed ? NULL : arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return label;
}

/* Marks the end of curve 0 if it is the run's current state, not only the end of a window. */
static void mark_current_state(const struct drawing *d, struct figure *figure)
{
    if (d->request->runs == 0 || d->curve[0].n == 0)
        return;
    const struct curve *curve = &d->curve[0];
    const struct trace *trace = request_run(d, 0)->trace;
    const double *t = curve->t ? curve->t : curve->x;
    figure->has_point = t[curve->n - 1] == trace_time(trace, trace_count(trace) - 1);
    figure->point[0] = curve->x[curve->n - 1];
    figure->point[1] = curve->y[curve->n - 1];
}

/* Adds the scene, integrated to now, over a recording that is being collected. */
static bool add_model(struct drawing *d, const struct recording *recording)
{
    const struct growing *now = d->session->growing;
    const int first = d->curves;
    if (d->request->runs > 0 || !session_grows(d->session, recording) || !now->model ||
        !(shows_recorded_values(d, recording) || drawing_needs_motion(d, recording)))
        return true;
    d->model = now->model->system.model;
    if (!add_run(d, now->model))
        return false;
    for (int i = first; i < d->curves; i++) {
        struct curve *curve = &d->curve[i];
        double *y = arena_array(d->arena, curve->n + 1, sizeof *y);
        if (!y)
            return error_memory(d->error);
        for (size_t k = 0; k < curve->n; k++)
            y[k] = curve->y[k] + (kind_of(d)->recorded == RECORDED_POSITION ? now->offset : 0);
        curve->y = y;
        curve->label = now->model->scene.preset->row.name;
    }
    return true;
}

static double measured_run_period(const struct drawing *d, const struct run *run)
{
    struct measured period;
    return run_period(run, d->arena, &period) ? period.value : NAN;
}

/* Adds the confidence band of an adopted fit, if it is asked for. */
static bool add_band(struct drawing *d)
{
    const struct figure_request *request = d->request;
    const struct series_tools *tools = series_tools();
    if (request->band.len)
        return (tools = series_tools_for("--band", request->band, d->error)) && tools->draw_band(d);
    return !request->stored_band || !tools || tools->draw_stored_band(d);
}

/* Collects all curves: runs, bands, the recording. Returns false with an error if there are none.
 */
static bool gather_curves(struct drawing *d, const struct plot_row *row)
{
    const struct figure_request *request = d->request;
    const struct session *session = d->session;
    struct error *error = d->error;
    if (request->runs > 0 && !find_model(d))
        return false;
    if (request->runs > 0) {
        const struct run *run = request_run(d, 0);
        const double stiffness = run->system.oscillator.stiffness; /* the one in force */
        d->period = request->event.len ? NAN : run_rhythm(run);
        if (row->scaled && session->setup.settings.phase_axes == PHASE_SCALED && stiffness > 0)
            d->omega0 = sqrt(stiffness);
    }
    const struct recording *recording = recording_of(d);
    if (recording && drawing_needs_motion(d, recording) && !drawing_find_motion(d, recording))
        return false;
    drawing_window(d);
    /* The scene gives no period: it is measured. */
    if (row->horizontal == ACROSS_FREQUENCY && request->runs > 0 && isnan(d->period) &&
        !request->follow)
        d->period = measured_run_period(d, request_run(d, 0));
    if (row->residual && !recording)
        return error_set(error, ERROR_COMMAND, "a residual needs a recording");
    if (recording && holds_other_quantity(d, recording))
        return error_set(error, ERROR_COMMAND, "%s cannot be computed from %s", row->row.name,
                         recording->name);
    for (int i = 0; i < request->runs && !row->residual; i++)
        if (!(request->event.len ? drawing_event_records(d, session->runs.slot[request->run[i]])
                                 : add_run(d, request_run(d, i))))
            return false;
    if (!add_band(d))
        return false;
    if (recording && !row->residual && !add_model(d, recording))
        return false;
    if (recording && !(row->residual ? row->residual : drawing_recording)(d, recording))
        return false;
    size_t points = 0;
    for (int i = 0; i < d->curves; i++) {
        points += d->curve[i].n;
        d->curve[i].cancel = request->follow ? NULL : session->front.cancel;
    }
    return points > 0 || request->follow ||
           error_set(error, ERROR_COMMAND, "nothing was recorded in this time window");
}

/* Sets names, units and scales of both axes. Returns false with d->error if out of memory. */
static bool label_axes(const struct drawing *d, const struct plot_row *row,
                       const struct variable *x_variable, struct figure *figure)
{
    const struct figure_request *request = d->request;
    const char *x_name = arena_text(d->arena, text_of(x_variable->name));
    if (!x_name)
        return error_memory(d->error);
    if (figure->plane)
        figure->x = quantity_axis(x_name, x_variable->quantity, curves_size(d, true));
    else
        figure->x = row->axis ? row->axis(d) : quantity_axis("t", QUANTITY_TIME, d->window[1]);
    figure->y = quantity_axis(drawing_y_label(d, 0), vertical_quantity(d), curves_size(d, false));
    if (!figure->y.label)
        return error_memory(d->error);
    if (request->columns && figure->y.unit[0] == 0)
        figure->y.unit = chosen_unit(&request_run(d, 0)->system, &d->column[0]);
    if (figure->equal) {
        figure->y.factor = figure->x.factor;
        figure->y.unit = figure->x.unit;
    }
    if (request->follow && plot_is_timed(request->kind))
        figure->x = request->shared ? request->shared->axis : time_axis(d->window);
    return true;
}

/* Makes the figure of a request, in the arena. Returns false with an error. */
bool session_figure(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure *figure, struct error *error)
{
    struct drawing d = {.session = session,
                        .request = request,
                        .arena = arena,
                        .error = error,
                        .coordinates = 1,
                        .omega0 = 1,
                        .period = NAN};
    const struct plot_row *row = kind_of(&d);
    d.curve = arena_array(arena, (size_t)request->runs + LIMIT_OVERLAY + 2, sizeof *d.curve);
    if (!d.curve)
        return error_memory(error);
    if (request->table)
        return drawing_table(&d, figure);
    if (row->picture)
        return drawing_study(&d, row->picture, figure);
    if (row->figure)
        return row->figure(&d, figure);
    if (!gather_curves(&d, row))
        return false;
    const bool plane = plot_is_plane(request->kind);
    const bool values = request->columns || (d.model && d.model->order == 1 && row->coordinates);
    struct variable x_variable = {.quantity = QUANTITY_NUMBER};
    if (plane && request->columns)
        x_variable = chosen_variable(&request_run(&d, 0)->system, &d.horizontal_column);
    else if (plane && d.model)
        x_variable = d.model->variable[0];
    const char *title;
    if (values)
        title = "values";
    else
        title = is_kinetic(&d) ? "kinetic" : row->row.name;
    *figure = (struct figure){.title = title,
                              .curve = d.curve,
                              .curves = d.curves,
                              .plane = plane,
                              .zero_line = !row->from_zero,
                              .equal = (row->scaled && d.omega0 != 1) ||
                                       (row->equal && !request->columns),
                              .note = make_note(&d)};
    if (!label_axes(&d, row, &x_variable, figure) || !drawing_label_turns(&d, figure))
        return false;
    if (!row->residual && !row->run_curve && !request->event.len)
        mark_current_state(&d, figure);
    enum quantity horizontal;
    if (plane)
        horizontal = x_variable.quantity;
    else
        horizontal = row->horizontal == ACROSS_FREQUENCY ? QUANTITY_FREQUENCY : QUANTITY_TIME;
    const enum quantity quantities[2] = {horizontal, vertical_quantity(&d)};
    return drawing_scales(&d, figure, quantities) &&
           (request->follow || !cancelled(session->front.cancel) ||
            error_set(error, ERROR_CANCELLED, "stopped"));
}
