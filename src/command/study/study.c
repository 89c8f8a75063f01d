/* SPDX-License-Identifier: GPL-3.0-or-later */
/* compare */
#ifndef COMMAND_ROWS
#include "command/internal.h"

#include <math.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>

static void period_cell(struct text_table *table, struct measured period)
{
    struct buffer text = {0};
    if (!isfinite(period.value))
        buffer_char(&text, '-');
    else
        buffer_measured(&text, period, QUANTITY_TIME, 6);
    cell_take(table, &text);
}

static void angle_cell(struct text_table *table, double radians)
{
    struct buffer text = {0};
    buffer_phase(&text, radians);
    cell_take(table, &text);
}

static void setting_cell(struct text_table *table, const struct run *run)
{
    struct buffer text = {0};
    if (run->plan.adaptive)
        buffer_format(&text, "tol %.3g", run->settings.tol);
    else
        buffer_quantity(&text, run->settings.dt, QUANTITY_TIME, 4);
    cell_take(table, &text);
}

/* Which columns say something: of a scene that does not swing, and without a recording, some do not. */
struct columns {
    bool energy, data, period, phase, timed;
    bool mixed; /* not all of them timed by the same code */
};

static struct columns columns_for(const struct session *session, const struct comparison *rows, int count,
                                  struct measured *period, struct arena *arena)
{
    struct columns columns = {.data = session_recording(session) != NULL};
    for (int i = 0; i < count; i++) {
        if (!run_period(rows[i].run, arena, &period[i]))
            period[i] = (struct measured){NAN, NAN};
        columns.period |= isfinite(period[i].value);
        columns.phase |= isfinite(rows[i].errors.phase);
        columns.timed |= isfinite(rows[i].time.minimum);
        columns.mixed |= rows[i].path != rows[0].path;
        columns.energy |= isfinite(rows[i].ledger.error_max) || stop_is_failure(rows[i].run->stop);
    }
    return columns;
}

/* Marked where the times of other rows are by other code. */
static void step_time_cell(struct text_table *table, const struct comparison *row, bool mixed)
{
    struct buffer text = {0};
    buffer_step_time(&text, timing_step_ns(&row->time, row->run->steps));
    if (mixed && row->path == KERNEL_GENERAL)
        buffer_put(&text, TEXT(" (!)"));
    cell_take(table, &text);
}

/* Which rows took extra steps: they are not the methods as they are printed. */
static void put_turning(const struct comparison *rows, int count, struct buffer *out)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        const int64_t turns = rows[i].run->cost.turns;
        if (turns > 0)
            buffer_format(out, "%s%s %lld", any ? ", " : rows[i].run->system.switches > rows[i].run->system.dry
                                           ? "extra steps that end at switches (set turning off): "
                                           : "extra steps that end at turning points (set turning off): ",
                          rows[i].run->method->row.name, (long long)turns);
        any |= turns > 0;
    }
    if (any)
        buffer_char(out, '\n');
}

/* Which rows have times that do not compare with the rest. */
static void put_general(const struct comparison *rows, int count, struct buffer *out)
{
    struct buffer names = {0};
    const struct method *last = NULL;
    for (int i = 0; i < count; i++) {
        if (rows[i].path == KERNEL_GENERAL && rows[i].run->method != last)
            buffer_format(&names, "%s%s", names.len ? ", " : "", rows[i].run->method->row.name);
        last = rows[i].run->method;
    }
    buffer_format(out,
                  "(!) timed by the general code: %s\n"
                  "    The others have code made for the method and these forces: do not rank by time\n"
                  "    what is marked against what is not.\n",
                  buffer_view(&names));
    buffer_free(&names);
}

static void distance_cell(struct text_table *table, const struct session *session, const struct run *run)
{
    const struct data_distance data = run_data_distance(run, session_recording(session));
    cell_quantity(table, data.rms, data.quantity, 3);
}

/* "rms(y-data)", of what the recording holds. */
static const char *rms_heading(const struct session *session, const struct run *run, char out[LIMIT_NAME + 16])
{
    const int derivative = recorded_derivative(session_recording(session), run);
    snprintf(out, LIMIT_NAME + 16, "rms(%s-data)", run_derivative(run, derivative > 0 ? derivative : 0).name);
    return out;
}

static void reply_table(const struct session *session, const struct comparison *rows, int count, struct arena *arena,
                        struct reply *reply)
{
    struct measured *period = arena_array(arena, (size_t)count, sizeof *period);
    const char **settings = arena_array(arena, (size_t)count, sizeof *settings);
    if (!period || !settings)
        return;
    const struct columns columns = columns_for(session, rows, count, period, arena);
    int width, height;
    session_size(session, &width, &height);
    struct text_table table = {.arena = arena,
                               .columns = 5 + columns.timed + columns.energy + columns.data + columns.period + columns.phase,
                               .gap = 3,
                               .most = width};
    /* The setting is part of a row's name where one method has several. */
    bool several = false;
    for (int i = 1; i < count; i++)
        several |= rows[i].run->method == rows[i - 1].run->method;
    char rms[LIMIT_NAME + 16];
    const struct {
        const char *name;
        bool shown;
    } heading[] = {{"method", true},
                   {"dt", true},
                   {"steps", true},
                   {"|dE/E0|", columns.energy},
                   {"max error", true},
                   {columns.data ? rms_heading(session, rows[0].run, rms) : "", columns.data},
                   {"period T", columns.period},
                   {"phase err", columns.phase},
                   {"time", true},
                   {"ns/step", columns.timed}};
    for (size_t c = 0; c < COUNT_OF(heading); c++)
        if (heading[c].shown)
            cell_text(&table, heading[c].name);
    for (int i = 0; i < count; i++) {
        const struct run *run = rows[i].run;
        cell_text(&table, run->method->row.name);
        setting_cell(&table, run);
        settings[i] = cell_last(&table);
        cell_count(&table, run->steps);
        if (columns.energy && (stop_is_failure(run->stop) || run->stop == STOP_GIVEN_UP))
            cell_text(&table, stop_name(run->stop));
        else if (columns.energy)
            cell_quantity(&table, rows[i].ledger.error_max, QUANTITY_NUMBER, 3);
        cell_quantity(&table, rows[i].errors.max, QUANTITY_NUMBER, 3);
        if (columns.data)
            distance_cell(&table, session, run);
        if (columns.period)
            period_cell(&table, period[i]);
        if (columns.phase)
            angle_cell(&table, rows[i].errors.phase);
        cell_seconds(&table, rows[i].time.minimum);
        if (columns.timed)
            step_time_cell(&table, &rows[i], columns.mixed);
    }
    struct buffer text = {0};
    text_table_put(&table, &text);
    if (columns.timed && columns.mixed)
        put_general(rows, count, &text);
    put_turning(rows, count, &text);
    for (int i = 0; i < count; i++)
        if (rows[i].verdict[0])
            buffer_format(&text, "%s%s%s: %s\n", rows[i].run->method->row.name, several ? " " : "",
                          several ? settings[i] : "", rows[i].verdict);
    if (rows[0].reference[0]) {
        buffer_format(&text, "errors against %s and %s, which agree to ", rows[0].reference[0]->row.name,
                      rows[0].reference[1]->row.name);
        buffer_short(&text, rows[0].errors.floor, 2);
        buffer_put(&text, rows[0].reference_kept ? TEXT(", as found before\n") : TEXT("\n"));
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

static void reply_comparison(const struct comparison *row, struct reply *reply)
{
    const struct run *run = row->run;
    reply_begin(reply, "compare");
    reply_string(reply, "method", run->method->row.name);
    reply_real(reply, "dt", run->plan.adaptive ? NAN : run->settings.dt);
    reply_real(reply, "tol", run->plan.adaptive ? run->settings.tol : NAN);
    reply_int(reply, "steps", run->steps);
    reply_int(reply, "evals", run->cost.evals);
    reply_int(reply, "turning_steps", run->cost.turns);
    reply_real(reply, "error", row->errors.max);
    reply_real(reply, "energy_error", row->ledger.error_max);
    reply_real(reply, "energy_factor", row->energy_factor);
    reply_real(reply, "predicted_factor", row->predicted_factor);
    reply_real(reply, "order", row->order);
    reply_real(reply, "phase_error", row->errors.phase);
    reply_real(reply, "time_min", row->time.minimum);
    reply_real(reply, "time_median", row->time.median);
    reply_real(reply, "ns_per_step", timing_step_ns(&row->time, row->run->steps));
    reply_string(reply, "path", path_name(row->path));
    reply_string(reply, "status", stop_name(run->stop));
    reply_bool(reply, "reference_kept", row->reference_kept);
    reply_string(reply, "verdict", row->verdict[0] ? row->verdict : NULL);
    reply_int(reply, "run", run->number);
    reply_end(reply);
}

/* ---- the command ---- */

static double *values_of(const struct given *given, struct arena *arena)
{
    double *values = arena_array(arena, (size_t)given->count + 1, sizeof *values);
    for (int i = 0; values && i < given->count; i++)
        values[i] = given->item[i].value.value;
    return values;
}

static bool make_contenders(const struct session *session, const struct arguments *given, struct contender *contender,
                            struct error *error)
{
    const struct given *methods = given_for(given, "METHOD"), *drag = given_for(given, "drag");
    for (int i = 0; i < methods->count; i++) {
        contender[i].method = (const struct method *)(const void *)methods->item[i].row;
        contender[i].drag = drag->count == 1                ? (enum drag)(drag->item[0].index + 1)
                            : drag->count == methods->count ? (enum drag)(drag->item[i].index + 1)
                                                            : session->setup.drag;
        if (drag->count == 0 && !(contender[i].method->drags & (1u << contender[i].drag)))
            contender[i].drag = DRAG_DEFAULT;
        /* One drag= for all of them holds for those that know it. */
        if (drag->count == 1 && methods->count > 1 && !(contender[i].method->drags & (1u << contender[i].drag)))
            contender[i].drag = DRAG_DEFAULT;
    }
    return drag->count <= 1 || drag->count == methods->count ||
           error_at(error, drag->where, "drag= takes one variant for all methods or one for each");
}

/* The session takes the runs over; after a failure those that it has not taken are gone. */
static bool keep_runs(struct session *session, struct comparison *rows, int count, struct error *error)
{
    bool ok = true;
    for (int i = 0; i < count; i++) {
        if (ok)
            ok = session_add_run(session, rows[i].run, error);
        else
            comparison_free(&rows[i]);
    }
    return ok;
}

/* The panes show what was compared on the same axes: the last as the present run, those before it over it. */
static void overlay_runs(struct view *view, const struct comparison *rows, int count)
{
    view->overlays = 0;
    for (int i = count > LIMIT_OVERLAY ? count - 1 - LIMIT_OVERLAY : 0; i + 1 < count; i++)
        view->overlay[view->overlays++] = rows[i].run->number;
}

static void reply_saved(const struct comparison *rows, int count, struct reply *reply)
{
    struct buffer numbers = {0};
    for (int i = 0; i < count; i++)
        buffer_format(&numbers, "%s%d", i ? " " : "", rows[i].run->number);
    reply_line(reply, "saved as run%s %s   ('runs', 'plot energy run %s', 'export runs.csv run %s')",
               count == 1 ? "" : "s", buffer_view(&numbers), buffer_view(&numbers), buffer_view(&numbers));
    buffer_free(&numbers);
}

static bool contenders_adapt(const struct compare_request *request)
{
    for (int c = 0; c < request->contenders && request->tols > 0; c++)
        if (request->contender[c].method->flags & METHOD_ADAPTIVE)
            return true;
    return false;
}

HANDLER(compare)
{
    const struct given *methods = given_for(given, "METHOD"), *dt = given_for(given, "dt"),
                       *tol = given_for(given, "tol");
    const struct settings *settings = &session->setup.settings;
    const int most = methods->count * (tol->count ? tol->count : dt->count ? dt->count : 1);
    struct contender *contender = arena_array(given->arena, (size_t)methods->count, sizeof *contender);
    struct comparison *rows = arena_array(given->arena, (size_t)most, sizeof *rows);
    double *dts = values_of(dt, given->arena), *tols = values_of(tol, given->arena);
    if (!contender || !rows || !dts || !tols)
        return error_memory(error);
    const bool adapts = !tol->count && !dt->count && settings->tol > 0; /* those that can */
    if (dt->count == 0)
        dts[0] = settings->dt;
    if (tol->count && dt->count > 1)
        return error_at(error, dt->where,
                        "with tol= at most one dt is given: the first step, and the step of methods that do not adapt");
    if (session->runs + most > LIMIT_RUNS) {
        error_set(error, ERROR_COMMAND, "this makes %d runs, %d exist and %d are the most", most, session->runs,
                  LIMIT_RUNS);
        return error_hint(error, "drop some: drop N.. or drop all");
    }
    if (!make_contenders(session, given, contender, error))
        return false;
    const struct compare_request request = {.scene = &session->setup.scene,
                                            .contender = contender,
                                            .contenders = methods->count,
                                            .dt = dts,
                                            .dts = dt->count ? dt->count : 1,
                                            .tol = adapts ? &settings->tol : tol->count ? tols : NULL,
                                            .tols = adapts ? 1 : tol->count,
                                            .first = dt->count ? 0 : session_first_step(session),
                                            .duration = settings->duration,
                                            .compensated = session_run_settings(session).compensated,
                                            .record = settings->record,
                                            .timing = (enum timing)settings->timing,
                                            .references = &session->references,
                                            .cancel = session->front.cancel};
    double steps, seconds;
    if (!study_compare_plan(&request, &steps, &seconds, error) ||
        !allow_long(session, seconds, steps, is_given(given, "force"), error))
        return false;
    int count = 0;
    struct error study = {0};
    reply_assumed(session, contenders_adapt(&request), true, reply);
    reply_shorter(session, reply);
    const bool ok = study_compare(&request, rows, &count, &study);
    if (!keep_runs(session, rows, count, error))
        return false;
    if (count > 0) {
        overlay_runs(&session->view, rows, count);
        reply_table(session, rows, count, given->arena, reply);
        for (int i = 0; i < count && reply->format != FORMAT_TEXT; i++)
            reply_comparison(&rows[i], reply);
        for (int i = 0; i < count; i++)
            reply_unsound(rows[i].run, reply);
        reply_saved(rows, count, reply);
    }
    if (!ok)
        *error = study;
    return ok;
}
#endif

COMMAND(compare, .row = {"compare", "", "several methods on the same scene: error, energy, time", "", NULL},
        .group = "STUDY",
        .text =
            "Each method runs for the setting 'duration', however long the last run was. Methods that adapt do so, with "
            "the setting\n"
            "'tol', unless dt= is given; the others run with each dt. The error is the largest distance from the exact "
            "solution,\n"
            "divided by the amplitude; without a closed form, from a reference that two methods of different kinds "
            "agree on. ns/step\n"
            "is the shortest time of a solve that records nothing, by its steps; what is timed by the general code is "
            "marked, where\n"
            "others have code of their own. The runs are kept; a method that diverges is a result, not a failure, and "
            "so is one that\n"
            "adapts and has not arrived after 2e6 steps (status given-up).",
        .examples = "compare euler symplectic-euler\ncompare euler verlet rk4 dt=10ms,5ms",
        .see = "precision method runs plot timing", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("METHOD", TYPE_CHOICE, .flags = ARG_REQUIRED | ARG_MANY, .choices = &method_catalog),
                  KEY("dt", TYPE_VALUE, .flags = ARG_MANY, .quantity = QUANTITY_TIME),
                  KEY("tol", TYPE_VALUE, .flags = ARG_MANY, .quantity = QUANTITY_NUMBER),
                  KEY("drag", TYPE_CHOICE, .flags = ARG_MANY, .choices = &drag_catalog), OPTION("force", TYPE_NONE)))
