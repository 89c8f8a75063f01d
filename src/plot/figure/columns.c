/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plots of columns that were asked for by name (plot NAME against NAME), over time or at events. */
#include <hooke/run.h>
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>
#include <hooke/session/events.h>
#include <hooke/scene/typed.h>
#include <hooke/session/subject.h>

#include <string.h>

#define MARKS_MAX 100 /* number of points above which they are drawn as a cloud of dots */

/* Finds the columns that a request names. Returns false with an error if one is unknown, if there
 * are too many, or if their units differ, since they share an axis. */
bool drawing_columns(struct drawing *d, const struct system *system)
{
    const struct figure_request *request = d->request;
    const bool plane = plot_is_plane(request->kind);
    d->coordinates = request->columns;
    if (request->columns > DRAWN_COLUMNS || (request->columns > 1 && request->runs > 1))
        return error_at(d->error, request->column[1],
                        request->runs > 1 ? "from several runs only one column can be drawn"
                                          : "at most %d columns in one plot",
                        DRAWN_COLUMNS);
    if (plane &&
        !chosen_find(d->model, request->horizontal_column, &d->horizontal_column, d->error))
        return false;
    for (int i = 0; i < request->columns; i++) {
        if (!chosen_find(d->model, request->column[i], &d->column[i], d->error))
            return false;
        const char *unit = chosen_unit(system, &d->column[0]),
                   *its = chosen_unit(system, &d->column[i]);
        if (strcmp(unit, its) == 0)
            continue;
        const struct variable first = chosen_variable(system, &d->column[0]),
                              one = chosen_variable(system, &d->column[i]);
        const char *const second_unit = its[0] ? its : "1";
        error_at(d->error, request->column[i], "%s [%s] and %s [%s] do not share an axis",
                 first.name, unit[0] ? unit : "1", one.name, second_unit);
        return error_hint(d->error, "plot %s against %s", one.name, first.name);
    }
    return true;
}

/* Returns the label of curve i of one run: a variable's or column's name, or NULL if out of memory.
 */
const char *drawing_label(const struct drawing *d, int i)
{
    /* a recording without a run has no model */
    const struct model *model = d->model ? d->model : &oscillator_model;
    if (!d->request->columns)
        return vertical_variable(model, d->request->kind)[i].name;
    const struct run *run = d->session->runs.slot[d->request->run[0]]->run;
    return arena_text(d->arena, text_of(chosen_variable(&run->system, &d->column[i]).name));
}

/* Computes a column (observable, variable or observed expression) at the chosen rows of a run.
 * Returns false with an error if out of memory or cancelled. */
bool chosen_at_rows(const struct run *run, const struct chosen_column *column,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error)
{
    if (column->observable)
        return values_at_rows(run, column->observable, rows, arena, values, error);
    if (column->variable < run->system.n) {
        state_at_rows(run, column->variable, rows, values);
        return true;
    }
    double *all = arena_array(arena, trace_count(run->trace), sizeof *all);
    if (!all)
        return error_memory(error);
    run_observed_column(run, column->variable - run->system.n, all);
    for (size_t i = 0; i < rows->n; i++)
        values[i] = all[rows->row[i]];
    return true;
}

/* ---- at events ---- */

/* Computes a column at event record i of a run. Returns false with an error for an observable that
 * needs more than the state at the event. */
static bool column_value_at_event(const struct run *run, const struct chosen_column *column,
                                  size_t i, double *value, struct error *error)
{
    const struct event_record *record = run_event_record(run, i);
    const struct sample sample = {
        .run = run, .system = &run->system, .t = record->t, .y = run_event_record_state(run, i)};
    const int n = run->system.n;
    if (column->observable && (column->observable->needs & ~(unsigned)(NEED_MECHANICS | NEED_LINE |
                                                                       NEED_POWER | NEED_ENERGY) ||
                               !observable_defined(column->observable, &run->system, false)))
        return error_set(error, ERROR_COMMAND, "%s has no value at events",
                         column->observable->row.name);
    if (column->observable)
        *value = column->observable->value(&sample);
    else
        *value = column->variable < n
                     ? sample.y[column->variable]
                     : system_observe(&run->system, column->variable - n, sample.t, sample.y);
    return true;
}

/* Adds a curve of points for each column, one point for each time that the event happened. Returns
 * false with an error if it never did in the window. */
bool drawing_event_records(struct drawing *d, const struct run_slot *slot)
{
    const struct run *run = slot->run;
    const struct figure_request *request = d->request;
    const size_t capacity = run_event_records(run) + 1;
    const struct chosen_column time = {observable_by_name(TEXT("t")), -1};
    double *x = arena_array(d->arena, capacity, sizeof *x);
    for (int c = 0; c < d->coordinates; c++) {
        double *y = arena_array(d->arena, capacity, sizeof *y);
        const char *label = d->coordinates > 1 ? drawing_label(d, c) : drawing_run_label(d, run);
        size_t n = 0, seen = 0;
        if (!x || !y || !label)
            return error_memory(d->error);
        for (size_t i = 0; i + 1 < capacity; i++) {
            const struct event_record *record = run_event_record(run, i);
            if (!text_is(request->event, slot->events->line[record->event].name) ||
                record->t < d->window[0] || record->t > d->window[1])
                continue;
            double y_value = 0;
            if (!column_value_at_event(run,
                                       plot_is_plane(request->kind) ? &d->horizontal_column : &time,
                                       i, &x[seen], d->error) ||
                !column_value_at_event(run, &d->column[c], i, &y_value, d->error))
                return false;
            seen++;
            /* Return map: y belongs to the event after the one of x. */
            if (!request->next || seen > 1)
                y[n++] = y_value;
        }
        if (seen == 1 && n == 0)
            return error_at(
                d->error, request->event,
                "only one of these events happened in this time, so there is no next one");
        if (n == 0) {
            error_at(d->error, request->event, "run %d has no event '%.*s' in this time",
                     run->number, (int)(request->event.len < 64 ? request->event.len : 64),
                     request->event.data);
            return error_hint(d->error, "'list events' shows what happened");
        }
        d->curve[d->curves++] = (struct curve){
            .label = label, .x = x, .y = y, .n = n, .points = true, .cloud = n > MARKS_MAX};
    }
    return true;
}
