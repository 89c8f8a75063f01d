/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The arguments that choose a figure, which plot and describe share. */
#include <hooke/base/unit.h>
#include <hooke/command/figure_arguments.h>

#include <hooke/report.h>

#include <math.h>
#include <string.h>

/* Sets request->run [request->runs] to the indices of the runs to plot: those named by run=, all
 * for run=all, or the current run if neither a run nor a recording is named. Sets
 * request->recording to the recording named by data=, to the default one of this kind of plot, or
 * to -1. The array is in the arena. Returns false with the error set if nothing is left to plot or
 * the kind of plot does not show recordings. */
static bool choose_runs(struct session *session, const struct arguments *args,
                        struct figure_request *request, struct error *error)
{
    const struct argument_value *runs = argument_value(args, "run"),
                                *data = argument_value(args, "data");
    int *index = arena_array(args->arena, LIMIT_RUNS + (size_t)runs->count + 1, sizeof *index);
    if (!index)
        return error_memory(error);
    request->run = index;
    for (int i = 0; i < runs->count; i++) {
        const bool all = runs->item[i].index < 0;
        for (int r = 0; r < session->runs.count; r++) {
            bool listed = false;
            for (int j = 0; j < request->runs; j++)
                listed |= index[j] == r;
            if ((all || runs->item[i].index == r) && !listed)
                index[request->runs++] = r;
        }
    }
    if (runs->count == 0 && data->count == 0 && session->runs.current >= 0)
        index[request->runs++] = session->runs.current;
    if (data->count)
        request->recording = data->item->index;
    else
        request->recording = (runs->count && !plot_row(request->kind)->residual) || request->columns
                                 ? -1
                                 : figure_recording(session, request->kind);
    if (request->runs == 0 && request->recording >= 0 && !plot_of_recordings(request->kind))
        return error_at(error, data->where, "recordings cannot be plotted as %s",
                        plot_row(request->kind)->row.name);
    if (request->runs > 0 || request->recording >= 0)
        return true;
    if (session_recording(session)) {
        error_at(error, argument_value(args, "WHAT")->where,
                 "only a run or a recording of positions has that plot");
        return error_hint(error, "type: run");
    }
    error_set(error, ERROR_COMMAND, "nothing to plot: there is no run and no recording");
    return error_hint(error, "type: run, or: load FILE");
}

/* Returns true if the item is the name of a method. */
static bool is_method(const struct item *item)
{
    return item->row && item->row == catalog_find(&method_catalog, item->text);
}

/* Reads a study's plot and the methods behind its name into request->kind and request->method
 * [request->methods], each method once. Returns false with the error set if another word follows or
 * if out of memory. */
static bool choose_methods(const struct arguments *args, struct figure_request *request,
                           struct error *error)
{
    const struct argument_value *what = argument_value(args, "WHAT");
    const struct row **method = arena_array(args->arena, (size_t)what->count, sizeof *method);
    if (!method)
        return error_memory(error);
    for (int i = 1; i < what->count; i++) {
        if (!is_method(&what->item[i]))
            return error_at(error, what->item[i].text, "'%.*s' is not a method",
                            (int)what->item[i].text.len, what->item[i].text.data);
        bool is_repeated = false;
        for (int k = 0; k < request->methods; k++)
            is_repeated |= method[k] == what->item[i].row;
        if (!is_repeated)
            method[request->methods++] = what->item[i].row;
    }
    request->kind = (enum plot_kind)what->item->index;
    request->method = method;
    return true;
}

/* Executes the study whose figure is drawn, which keeps its table as a result. Its output is
 * dropped, except for notes. */
static bool make_study(struct session *session, const struct figure_request *request,
                       struct reply *reply, struct error *error)
{
    const struct plot_row *row = plot_row(request->kind);
    struct table_store said = {0}, *outer = reply->store;
    const bool muted = reply->muted, recorded = reply->recorded;
    reply->store = &said;
    reply->muted = true;
    const bool ok = row->study(session, request->method, request->methods, reply, error);
    reply_flush(reply);
    reply->store = outer;
    reply->muted = muted;
    reply->recorded = recorded;
    session_keep_results(session, &said, row->row.name);
    return ok;
}

/* A kind of plot, or columns of runs: over time, or against another. */
bool choose_figure(const struct arguments *args, struct figure_request *request,
                   struct error *error)
{
    const struct argument_value *what = argument_value(args, "WHAT"),
                                *against_argument = argument_value(args, "against"),
                                *event_argument = argument_value(args, "at"),
                                *table_argument = argument_value(args, "of"),
                                *data = argument_value(args, "data");
    if (table_argument->count && (!against_argument->count || event_argument->count ||
                                  data->count || has_argument(args, "run"))) {
        error_at(error, table_argument->where, "in a table, plot one column against another");
        return error_hint(error, "plot COLUMN against COLUMN of %s",
                          table_argument->item->row->name);
    }
    if (what->count && what->item->index >= 0 && !against_argument->count &&
        !event_argument->count && plot_row((enum plot_kind)what->item->index)->study)
        return choose_methods(args, request, error);
    for (int i = 0; i < what->count; i++)
        if (is_method(&what->item[i]) && !table_argument->count) {
            error_at(error, what->item[i].text, "'%s' is a method, not a column",
                     what->item[i].row->name);
            return error_hint(error, "plot order %s", what->item[i].row->name);
        }
    /* a variable or a column of what is drawn may follow its name */
    const bool branches = what->count == 2 && what->item->index >= 0 &&
                          plot_row((enum plot_kind)what->item->index)->takes_column;
    if ((what->count == 1 || branches) && what->item->index >= 0 && !against_argument->count &&
        !event_argument->count) {
        request->column = branches ? &what->item[1].text : NULL;
        request->columns = branches;
        request->kind = (enum plot_kind)what->item->index;
        return true;
    }
    struct text *name = arena_array(args->arena, (size_t)what->count, sizeof *name);
    if (!name)
        return error_memory(error);
    for (int i = 0; i < what->count; i++)
        name[i] = what->item[i].text;
    request->kind = against_argument->count ? PLOT_ORBIT : PLOT_POSITION;
    request->column = name;
    request->columns = what->count;
    if (event_argument->count)
        request->event = event_argument->item->text;
    request->next = has_argument(args, "next");
    if (request->next && !(against_argument->count && event_argument->count)) {
        error_at(error, argument_value(args, "next")->where,
                 "--next needs one column against another at an event");
        return error_hint(error, "for example: plot y against y at top --next");
    }
    if (against_argument->count) {
        request->horizontal_column = against_argument->item->text;
        request->trail = HUGE_VAL;
    }
    return !data->count ||
           error_at(error, data->where, "recordings have no columns to plot against each other");
}

/* Reads the ranges of the axes; that of x also limits the times that are drawn if the plot is
 * against time. */
static bool choose_ranges(const struct arguments *args, struct figure_request *request,
                          struct error *error)
{
    const struct argument_value *axis[2] = {argument_value(args, "x"), argument_value(args, "y")};
    struct figure_range *range = arena_array(args->arena, 2, sizeof *range);
    if (!range)
        return error_memory(error);
    for (int i = 0; i < 2; i++) {
        if (axis[i]->count == 0)
            continue;
        if (plot_row(request->kind)->whole)
            return error_at(error, axis[i]->where, "the axes of '%s' always show all points",
                            plot_row(request->kind)->row.name);
        const struct item *item = axis[i]->item;
        range[i] = (struct figure_range){{item->range[0], item->range[1]},
                                         item->unit ? item->unit->quantity : QUANTITY_OTHER,
                                         axis[i]->where};
        *(i ? &request->y : &request->x) = &range[i];
    }
    if (request->x && plot_is_timed(request->kind) && !has_argument(args, "window"))
        memcpy(request->window, request->x->end, sizeof request->window);
    return true;
}

/* Adds an axis of a portrait: a variable of the scene with its range. Returns false with the error
 * set. */
static bool add_side(const struct session *session, struct figure_request *request,
                     struct text name, struct text where, const double range[2],
                     struct error *error)
{
    const int variable = model_state(session->setup.scene.model, name);
    if (variable < 0)
        return error_at(error, where, "'%.*s' is not a variable of the scene", (int)name.len,
                        name.data);
    if (request->sides == 2)
        return error_at(error, where, "a portrait has two axes");
    if (!(range[0] < range[1]))
        return error_at(error, where,
                        "%.*s: the first value of a range must be smaller than the second",
                        (int)name.len, name.data);
    struct figure_side *side = &request->side[request->sides++];
    side->variable = variable;
    memcpy(side->range, range, sizeof side->range);
    return true;
}

/* Reads the axes of a portrait, in the order of typing. x= and y= mean variables of these names
 * here. Returns false with the error set. */
static bool choose_sides(const struct session *session, const struct arguments *args,
                         struct figure_request *request, struct error *error)
{
    const struct argument_value *named = argument_value(args, "NAME"),
                                *axis[2] = {argument_value(args, "x"), argument_value(args, "y")};
    for (int k = 0; k < 2; k++)
        if (axis[k]->count && !add_side(session, request, text_of(k ? "y" : "x"), axis[k]->where,
                                        axis[k]->item->range, error))
            return false;
    for (int i = 0; i < named->count; i++)
        if (!add_side(session, request, named->item[i].text, named->where, named->item[i].range,
                      error))
            return false;
    if (request->sides == 2 && axis[0]->count + axis[1]->count + named->count == 2 &&
        named->count == 1 && named->where.data < axis[axis[0]->count == 0]->where.data) {
        const struct figure_side first = request->side[0];
        request->side[0] = request->side[1];
        request->side[1] = first;
    }
    if (session->runs.current >= 0) {
        int *index = arena_array(args->arena, 1, sizeof *index);
        if (!index)
            return error_memory(error);
        *index = session->runs.current;
        request->run = index;
        request->runs = 1;
    }
    request->recording = -1;
    return true;
}

/* Returns true unless NAME=FROM:TO was given to a plot that is not a portrait; then sets an
 * error. */
static bool refuse_sides(const struct arguments *args, const struct figure_request *request,
                         struct error *error)
{
    const struct argument_value *named = argument_value(args, "NAME");
    if (!named->count || plot_row(request->kind)->of_scene)
        return true;
    error_at(error, named->where, "%s has no argument '%.*s'", plot_row(request->kind)->row.name,
             (int)named->item->text.len, named->item->text.data);
    const struct plot_row *row = plot_row(request->kind);
    if (row->study && text_is(named->item->text, "dt"))
        return error_hint(error, "'%s dt=FROM:TO; plot %s' draws a study with these steps",
                          row->row.name, row->row.name);
    return error_hint(error, "ranges of axes are x=FROM:TO and y=FROM:TO");
}

/* Chooses what the figure shows: a result (into export), a study, which is executed, sides of a
 * portrait, or runs and recordings. Returns false with the error set. */
static bool choose_source(struct session *session, const struct arguments *args,
                          struct figure_request *request, struct export *export,
                          struct reply *reply, struct error *error)
{
    const struct argument_value *table_argument = argument_value(args, "of");
    const struct plot_row *row = plot_row(request->kind);
    if (table_argument->count)
        return export_result(session, table_argument->item->row, export, error);
    if (row->study)
        return make_study(session, request, reply, error);
    if (row->of_study)
        return true;
    return row->of_scene ? choose_sides(session, args, request, error)
                         : choose_runs(session, args, request, error);
}

/* Chooses the source of the figure (a result, a study, the scene, or runs and recordings), then
 * makes it. */
bool make_figure(struct session *session, const struct arguments *args,
                 struct figure_request *request, struct figure *figure, struct reply *reply,
                 struct error *error)
{
    const struct argument_value *window = argument_value(args, "window"),
                                *table_argument = argument_value(args, "of");
    struct export export = {.arena = args->arena};
    request->whole_spiral = request->trail == 0 && session->view.trail == VIEW_TRAIL_PERIODS;
    request->trail = request->trail > 0 ? request->trail : session->view.trail;
    request->log = has_argument(args, "log");
    request->full = has_argument(args, "full");
    request->window[0] = request->window[1] = NAN;
    if (has_argument(args, "band"))
        request->band = argument_value(args, "band")->where;
    if (window->count)
        memcpy(request->window, window->item->range, sizeof request->window);
    if (!refuse_sides(args, request, error) ||
        (!plot_row(request->kind)->of_scene && !choose_ranges(args, request, error)))
        return false;
    if (!choose_source(session, args, request, &export, reply, error))
        return false;
    if (table_argument->count) {
        struct table *table = arena_alloc(args->arena, sizeof *table);
        if (!table)
            return error_memory(error);
        *table = export.table;
        request->table = table;
        request->title = table_argument->item->row->name;
    }
    if (session_figure(session, request, args->arena, figure, error))
        return true;
    if (!error->where.data) /* the window has no rows, unless memory ran out */
        error->where = window->where;
    return false;
}

bool label_curves(const struct session *session, const struct figure_request *request,
                  struct arena *arena, struct figure *figure, struct error *error)
{
    const struct plot_row *row = plot_row(request->kind);
    return !row->name_curves || row->name_curves(session, arena, figure, error);
}
