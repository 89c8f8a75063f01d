/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command `compare`: chooses methods and settings, has study_compare() run them, shows the
 * table with a verdict for each run, and gives the runs to the session. */
#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include <hooke/base/safe_text.h>
#include <hooke/report.h>
#include "modules/comparison/comparison.h"

#include <math.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>

/* Fills in rows for display from the finished runs: also the period of each, and its distance from
 * the present recording if there is one. Periods and distances are left out when cancelled. */
static void fill_rows(const struct session *session, const struct comparison *compared, int count,
                      struct arena *arena, struct compared_row *rows)
{
    struct recording *recording = session_recording(session);
    for (int i = 0; i < count; i++) {
        const struct run *run = compared[i].run;
        struct compared_row *row = &rows[i];
        compared_init(row, &compared[i]);
        const bool stopped = cancelled(session->front.cancel),
                   arrived = !stop_is_failure(run->stop) && run->stop != STOP_GIVEN_UP;
        if (stopped || !arrived || run->system.n == 1 || !run_period(run, arena, &row->period))
            row->period = (struct measured){NAN, NAN};
        for (int k = 0; k < count; k++)
            row->mixed |= compared[k].path != compared[0].path;
        if (!recording || stopped)
            continue;
        const struct data_distance data = run_data_distance(run, recording);
        const int derivative = recorded_derivative(recording, run);
        row->data_rms = data.rms;
        row->data_quantity = data.quantity;
        snprintf(row->data_heading, sizeof row->data_heading, "rms(%s-data)",
                 run_derivative(run, derivative > 0 ? derivative : 0).name);
    }
}

/* Lists the methods that took extra steps ending at turning points or switches, with the number of
 * such steps, since they were not run as they are published. */
static void put_turning(const struct comparison *rows, int count, struct buffer *output)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        const int64_t turns = rows[i].run->cost.turns;
        if (turns > 0)
            buffer_format(output, "%s%s %lld",
                          any ? ", "
                          : rows[i].run->system.switches > rows[i].run->system.dry
                              ? "extra steps, added so that a step ends where the equations switch "
                                "('set turning off' avoids them): "
                              : "extra steps, added so that a step ends at each turning point "
                                "('set turning off' avoids them): ",
                          rows[i].run->method->row.name, (long long)turns);
        any |= turns > 0;
    }
    if (any)
        buffer_char(output, '\n');
}

/* Lists the methods that were timed with general code, whose times are not comparable with the
 * others. */
static void put_general(const struct comparison *rows, int count, struct buffer *output)
{
    struct buffer names = {0};
    const struct method *last = NULL;
    for (int i = 0; i < count; i++) {
        if (rows[i].path == KERNEL_GENERAL && rows[i].run->method != last)
            buffer_format(&names, "%s%s", names.len ? ", " : "", rows[i].run->method->row.name);
        last = rows[i].run->method;
    }
    buffer_format(
        output,
        "(!) timed with general code: %s\n"
        "The others have specialised code, so times marked (!) are not comparable with theirs.\n",
        buffer_view(&names));
    buffer_free(&names);
}

/* Appends a line per row with its verdict in words, if it has one. The line also names the setting
 * (step or tolerance) if a method has several rows, which follow each other. */
static void put_verdicts(const struct compared_row *rows, int count, struct buffer *text)
{
    bool several = false;
    for (int i = 1; i < count; i++)
        several |= rows[i].method == rows[i - 1].method;
    for (int i = 0; i < count; i++) {
        if (!rows[i].comparison.verdict[0])
            continue;
        buffer_put(text, text_of(rows[i].method->row.name));
        if (several) {
            buffer_char(text, ' ');
            compared_setting(&rows[i], text);
        }
        buffer_format(text, ": %s\n", rows[i].comparison.verdict);
    }
}

/* Says which two methods made the reference, unless errors are against the closed form or
 * unknown. */
static void put_reference(const struct comparison *first, struct buffer *text)
{
    if (!first->reference[0])
        return;
    buffer_format(text, "errors against %s and %s, which agree to %s",
                  first->reference[0]->row.name, first->reference[1]->row.name,
                  SHOWN_SHORT(first->errors.floor, 2));
    buffer_put(text, first->reference_stored ? TEXT(", computed earlier\n") : TEXT("\n"));
}

/* Adds the table, notes and verdicts to the reply. The first `count` rows belong to the finished
 * runs `compared`; left_out rows of methods that were not run follow them. If `brief`, verdicts
 * that do not fit on the screen are left out. */
static void reply_table(const struct session *session, const struct comparison *compared,
                        const struct compared_row *rows, int count, int left_out, bool brief,
                        struct arena *arena, struct reply *reply)
{
    enum { BELOW = 5 /* [row] the reference, the machine, the runs' numbers */ };
    int width, height;
    session_size(session, &width, &height);
    struct buffer text = {0}, lines = {0};
    struct text_table table = {.arena = arena, .gap = 3, .max = width};
    columns_text(&compared_columns, rows, (size_t)(count + left_out), true, &table);
    text_table_put(&table, &text);
    bool timed = false;
    for (int i = 0; i < count; i++)
        timed |= isfinite(compared[i].time.minimum);
    const bool is_small = brief && short_answer_rows(session) < SMALL_ANSWER_ROWS;
    if (timed && rows[0].mixed && !is_small)
        put_general(compared, count, &lines);
    put_turning(compared, count, &lines);
    put_folded_lines(&lines, width, &text);
    const size_t table_end = text.len;
    put_verdicts(rows, count + left_out, &lines);
    put_folded_lines(&lines, width, &text);
    if (is_small)
        text.len = table_end;
    else if (brief && text.len > table_end &&
             text_rows(buffer_text(&text), width) > short_answer_rows(session) - BELOW) {
        text.len = table_end;
        buffer_put(&text, TEXT("... a description of each run: --full\n"));
    }
    put_reference(&compared[0], &lines);
    put_folded_lines(&lines, width, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    buffer_free(&lines);
}

/* Stores the rows, those of methods that were left out included, as the result "compare", for plots
 * and files, and adds them to the reply as records. The result notes the reference: two methods
 * that agree, or the closed form. */
static void reply_comparison(const struct session *session, const struct compared_row *rows,
                             int count, struct reply *reply)
{
    const struct comparison *first = &rows[0].comparison;
    struct buffer reference = {0};
    if (first->reference[0])
        buffer_format(&reference, "%s and %s, which agree to %s", first->reference[0]->row.name,
                      first->reference[1]->row.name, SHOWN_SHORT(first->errors.floor, 2));
    else if (isfinite(first->errors.max))
        buffer_put(&reference, TEXT("the closed form"));
    reply_result(session, reply, "compare", &compared_columns, rows, (size_t)count, NULL,
                 buffer_view(&reference));
    buffer_free(&reference);
    reply_records(reply, "compare", &compared_columns, rows, (size_t)count);
}

/* ---- the command ---- */

/* Returns the numbers of an argument as an array from the arena, with room for one more, or NULL if
 * out of memory. */
static double *values_of(const struct argument_value *args, struct arena *arena)
{
    double *values = arena_array(arena, (size_t)args->count + 1, sizeof *values);
    for (int i = 0; values && i < args->count; i++)
        values[i] = args->item[i].value.value;
    return values;
}

/* Moves the runs of rows [count] into the session, which owns them then. Returns false with an
 * error if that fails; runs that were not moved are freed then. */
static bool move_runs(struct session *session, struct comparison *rows, int count,
                      struct error *error)
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

/* Lets the panes draw the compared runs on the same axes: the last one is the current run, those
 * before it become overlays. */
static void overlay_runs(struct view *view, const struct comparison *rows, int count)
{
    view->overlays = 0;
    for (int i = count > LIMIT_OVERLAY ? count - 1 - LIMIT_OVERLAY : 0; i + 1 < count; i++)
        view->overlay[view->overlays++] = rows[i].run->number;
}

/* Says under which numbers the runs were saved, and which commands show them, if the screen is wide
 * enough. */
static void reply_saved(const struct session *session, const struct comparison *rows, int count,
                        struct reply *reply)
{
    enum { NUMBERS_MAX = 4 /* that are named one by one */, HINT_CELLS = 60 };
    struct buffer numbers = {0};
    int width, height;
    session_size(session, &width, &height);
    for (int i = 0; i < count && count <= NUMBERS_MAX; i++)
        buffer_format(&numbers, "%s%d", i ? " " : "", rows[i].run->number);
    if (count > NUMBERS_MAX)
        buffer_format(&numbers, "%d to %d", rows[0].run->number, rows[count - 1].run->number);
    const char *shown = buffer_view(&numbers), *which = count > NUMBERS_MAX ? "all" : shown;
    if (width < HINT_CELLS)
        reply_line(reply, "saved as run%s %s", plural_s(count), shown);
    else
        reply_line(reply, "saved as run%s %s   ('runs', 'plot energy run %s')", plural_s(count),
                   shown, which);
    buffer_free(&numbers);
}

/* Returns true if tolerances are given and some method adapts its steps to them. */
static bool choices_adapt(const struct compare_request *request)
{
    for (int c = 0; c < request->choices && request->tols > 0; c++)
        if (request->choice[c].method->flags & METHOD_ADAPTIVE)
            return true;
    return false;
}

/* Says which times are uncertain and how busy the machine was, or nothing. */
static void reply_machine(const struct session *session, const struct comparison *rows, int count,
                          struct reply *reply)
{
    struct buffer text = {0}, lines = {0};
    double others = 0;
    int width, height;
    session_size(session, &width, &height);
    for (int i = 0; i < count; i++) {
        const struct timing_result *time = &rows[i].time;
        if (isnan(time->minimum))
            continue;
        others = time->others;
        if (!timing_is_sound(time))
            buffer_format(
                &lines,
                "the time of %s is uncertain because its shortest samples differ by %.0f %%\n",
                rows[i].run->method->row.name, 100 * time->spread);
    }
    timing_put_machine(others, &lines);
    put_folded_lines(&lines, width, &text);
    buffer_free(&lines);
    if (text.len > 0)
        reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

/* Takes the methods that the statement names, without repetitions, or else the defaults of
 * `precision` that suit the scene, into choice [*count]. Returns false with an error if the scene
 * or a drag variant is invalid. */
static bool choose_compared(const struct session *session, const struct arguments *args,
                            struct method_choice *choice, int *count, struct reply *reply,
                            struct error *error)
{
    const struct setup *setup = &session->setup;
    struct system system;
    if (argument_value(args, "METHOD")->count == 0) {
        if (!scene_bind(&setup->scene, &system, error))
            return false;
        *count = precision_defaults(&system, setup->settings.duration, choice, NULL, NULL);
    }
    if (!choose_methods(args, setup->drag, choice, count, error))
        return false;
    *count = drop_repeated(choice, *count, reply);
    return true;
}

/* Removes the methods that would take too long from the request and its array `choice`, and fills
 * row [i] for each, which says so. If that would leave none, all stay, so that the whole study is
 * refused. Returns the number of removed methods. */
static int leave_out_long(struct compare_request *request, struct method_choice *choice,
                          struct compared_row *row)
{
    int left = 0, omitted = 0;
    for (int c = 0; c < request->choices; c++) {
        struct compare_request alone = *request;
        struct error ignored;
        double steps, seconds;
        alone.choice = &choice[c];
        alone.choices = 1;
        if (study_compare_plan(&alone, &steps, &seconds, &ignored) && takes_long(seconds))
            compared_too_long(&row[omitted++], &choice[c], request->dt[0], steps, seconds);
        else
            choice[left++] = choice[c];
    }
    if (left == 0)
        return 0;
    request->choices = left;
    return omitted;
}

/* Replies with the compared runs, rows [count], and sets up overlays, warnings and hints.
 * `compared` has room for the rows that are shown: the first `count` are filled in here, the
 * left_out ones behind them are ready. */
static void reply_compared(struct session *session, const struct arguments *args,
                           const struct comparison *rows, int count, struct compared_row *compared,
                           int left_out, struct reply *reply)
{
    overlay_runs(&session->view, rows, count);
    fill_rows(session, rows, count, args->arena, compared);
    if (reply_wants_text(reply))
        reply_table(session, rows, compared, count, left_out, !asks_full(args), args->arena, reply);
    reply_comparison(session, compared, count + left_out, reply);
    for (int i = 0; i < count; i++)
        reply_unsound(rows[i].run, reply);
    if (asks_full(args) || short_answer_rows(session) >= SMALL_ANSWER_ROWS)
        reply_machine(session, rows, count, reply);
    reply_saved(session, rows, count, reply);
}

/* Executes `compare`. What would take too long is refused or left out without --force; finished
 * runs are kept if the study fails or is stopped. */
HANDLER(compare)
{
    const struct argument_value *dt = argument_value(args, "dt"),
                                *tol = argument_value(args, "tol");
    const struct settings *settings = &session->setup.settings;
    const size_t most = (size_t)argument_value(args, "METHOD")->count + PRECISION_DEFAULTS;
    struct method_choice *choice = arena_array(args->arena, most, sizeof *choice);
    double *dts = values_of(dt, args->arena), *tols = values_of(tol, args->arena);
    int choices = 0, count = 0;
    if (!choice || !dts || !tols)
        return error_memory(error);
    /* methods that can adapt use the tolerance that is set, if the statement gives neither dt nor
     * tol */
    const bool adapts = !tol->count && !dt->count && settings->tol > 0;
    const double first = dt->count ? 0 : session_first_step(session);
    if (dt->count == 0)
        dts[0] = settings->dt;
    if (adapts)
        tols[0] = settings->tol;
    if (tol->count && dt->count > 1)
        return error_at(error, dt->where,
                        "with tol= only one dt is allowed: the first step, and the step of methods "
                        "that are not adaptive");
    if (!choose_compared(session, args, choice, &choices, reply, error))
        return false;
    const int max = choices * int_max(tol->count ? tol->count : dt->count, 1);
    struct comparison *rows = arena_array(args->arena, (size_t)max, sizeof *rows);
    struct compared_row *compared =
                            arena_array(args->arena, (size_t)(max + choices), sizeof *compared),
                        *omitted = arena_array(args->arena, (size_t)choices, sizeof *omitted);
    if (!rows || !compared || !omitted)
        return error_memory(error);
    if (session->runs.count + max > LIMIT_RUNS) {
        error_set(error, ERROR_COMMAND, "this would make %d runs, but %d exist and %d is the limit",
                  max, session->runs.count, LIMIT_RUNS);
        return error_hint(error, "delete some: drop N.. or drop all");
    }
    struct compare_request request = {.scene = &session->setup.scene,
                                      .choice = choice,
                                      .choices = choices,
                                      .dt = dts,
                                      .dts = int_max(dt->count, 1),
                                      .tol = tols,
                                      .tols = adapts ? 1 : tol->count,
                                      .first = first,
                                      .duration = settings->duration,
                                      .compensated = session_run_settings(session).compensated,
                                      .record = settings->record,
                                      .timing = (enum timing)settings->timing,
                                      .references = session_references(session),
                                      .cancel = session->front.cancel};
    const bool force = has_argument(args, "force");
    const int left_out = force ? 0 : leave_out_long(&request, choice, omitted);
    double steps, seconds;
    if (!study_compare_plan(&request, &steps, &seconds, error) ||
        !allow_long(session, seconds, steps, force, error))
        return false;
    struct error study = {0};
    reply_assumed(session, choices_adapt(&request), true, reply);
    reply_shorter(session, reply);
    const bool ok = study_compare(&request, rows, &count, &study);
    if (!move_runs(session, rows, count, error))
        return false;
    memcpy(compared + count, omitted, (size_t)left_out * sizeof *omitted);
    if (count > 0)
        reply_compared(session, args, rows, count, compared, left_out, reply);
    if (!ok)
        *error = study;
    return ok;
}
#endif

COMMAND(compare, .group = "STUDY", .flags = COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(WORD("all", TYPE_NONE),
                  PLACE("METHOD", TYPE_CHOICE, .flags = ARG_MANY, .choices = &method_catalog),
                  KEY("dt", TYPE_VALUE, .flags = ARG_MANY, .quantity = QUANTITY_TIME),
                  KEY("tol", TYPE_VALUE, .flags = ARG_MANY, .quantity = QUANTITY_NUMBER),
                  KEY("drag", TYPE_CHOICE, .flags = ARG_MANY, .choices = &drag_catalog),
                  OPTION("force", TYPE_NONE), OPTION("full", TYPE_NONE)))
