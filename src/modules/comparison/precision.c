/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command `precision`: has study_precision() sweep each method from coarse to fine steps, and
 * shows errors against time as a diagram and in tables. */
#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/comparison/comparison.h"

#include <math.h>
#include <stdlib.h>

/* Appends to the buffer `context` that a method was left out, with the reason, which mostly begins
 * with the name of the method already. */
static void note_absent(void *context, const char *method, const char *reason)
{
    struct buffer *text = context;
    buffer_put(text, TEXT("left out: "));
    if (!text_starts(text_of(reason), text_of(method)))
        buffer_format(text, "%s: ", method);
    buffer_format(text, "%s\n", reason);
}

/* Sets the two ends of a sweep from the argument dt= or tol=, or to NAN if the argument is not
 * given. */
static void take_range(const struct argument_value *range, double limits[2])
{
    limits[0] = limits[1] = NAN;
    for (int i = 0; i < 2 && range->count; i++)
        limits[i] = range->item->range[i];
}

/* Returns false with an error, which shows `example`, if the argument is given and an end of it is
 * not above 0. */
static bool check_range(const struct argument_value *range, const char *example,
                        struct error *error)
{
    if (range->count == 0)
        return true;
    const double *ends = range->item->range;
    if (ends[0] > 0 && ends[1] > 0)
        return true;
    return error_at(error, range->where, "a sweep needs two ends above 0, as in %s", example);
}

/* Appends a line for each mark that occurs in the tables of the study. If `brief`, lines about how
 * the study was timed are left out. */
static void put_marks(struct buffer *text, const struct precision *precision, bool brief)
{
    const bool resolved = !precision->reference.dissenting_method[0];
    double others = 0;
    struct {
        bool any;
        const char *words;
    } mark[] = {
        {false, "*  in the fit of the slope\n"},
        {false, "<  below the accuracy of the reference, so not better than the others there\n"},
        {false, "~  not ranked: the shortest times differ by more than 10 %\n"},
        {false, "!  fewer samples than the others\n"},
        {false,
         resolved ? "lost: the error is as large as the motion\n"
                  : "apart: differs from the reference by the size of the motion; cause unknown\n"},
        {false, "probe: lost in the most active 1/256 of the time; the rest was not solved\n"},
        {false, "+  time of 30000 steps, scaled; one setting per method was timed completely\n"}};
    for (int i = 0; i < precision->points; i++) {
        const struct precision_point *point = &precision->point[i];
        others = fmax(others, point->time.others);
        mark[0].any |= point->asymptotic;
        mark[1].any |= point->is_below_reference;
        mark[2].any |= point->time.spread > TIMING_SPREAD;
        mark[3].any |= point->time.few;
        mark[4].any |= point->stop == STOP_END && !point->refused && !precision_meaningful(point);
        mark[5].any |= point->probed;
        mark[6].any |= point->timed_steps > 0 && !brief;
    }
    for (size_t i = 0; i < COUNT_OF(mark); i++)
        if (mark[i].any)
            buffer_put(text, text_of(mark[i].words));
    if (!brief)
        timing_put_machine(others, text);
}

/* Appends the diagram, `width` times `height` in cells, or nothing if out of memory. */
static void put_figure(const struct session *session, const struct precision *precision, int width,
                       int height, struct arena *arena, struct buffer *text)
{
    struct figure figure;
    struct error ignored;
    if (precision_figure(precision, arena, &figure, &ignored))
        figure_print(&figure, width, height, session_charset(session), false, text);
}

/* Describes the study in a line: numbers of methods and settings, duration, computing time [s], and
 * the reference. */
static void put_subject(const struct session *session, const struct precision *precision,
                        double seconds, struct buffer *text)
{
    buffer_format(text, "%d method%s, %d setting%s, %s of the scene", precision->curves,
                  plural_s(precision->curves), precision->points, plural_s(precision->points),
                  SHOWN_QUANTITY(precision->duration, QUANTITY_TIME, 4));
    if (session->setup.settings.timing != TIMING_OFF)
        buffer_format(text, ", in %.2g s", seconds);
    buffer_put(text, TEXT("; errors against "));
    reference_describe(&precision->reference, text);
    buffer_put(text, precision->reference.stored ? TEXT(", computed earlier\n") : TEXT("\n"));
}

/* Returns true if a setting of the method reached the end with an error below 1. */
static bool has_result(const struct precision *precision, const struct precision_curve *curve)
{
    for (int i = curve->first; i < curve->first + curve->count; i++)
        if (precision_meaningful(&precision->point[i]))
            return true;
    return false;
}

/* Lists the methods of which no setting gave a result, with the reason and what a whole solve would
 * take. */
static void put_without_result(const struct precision *precision, struct buffer *text)
{
    const size_t begin = text->len;
    for (int c = 0; c < precision->curves; c++) {
        const struct precision_curve *curve = &precision->curve[c];
        const struct precision_point *last = &precision->point[curve->first + curve->count - 1];
        if (curve->count == 0 || has_result(precision, curve))
            continue;
        buffer_format(text, "%s%s %s", text->len > begin ? ", " : "without a result: ",
                      curve->choice.method->row.name, precision_failure(precision, last));
        if (last->part < 1 && last->part > 0 && last->seconds > 0)
            buffer_format(text, " (about %s a solve)",
                          SHOWN_QUANTITY(last->seconds / last->part, QUANTITY_TIME, 2));
    }
    if (text->len > begin)
        buffer_char(text, '\n');
}

/* Appends the usual answer: the diagram, as high as the other lines leave room for, then the
 * fastest methods. The legend of letters is left out where there is little room, as the table of
 * the fastest methods names them, too. Small screens have fewer winners without a heading,
 * and no subject. */
static void put_short(const struct session *session, const struct precision *precision, int width,
                      double seconds, struct arena *arena, struct buffer *text)
{
    enum { FIGURE_ROWS_MIN = 7 };
    struct buffer table = {0}, rest = {0}, legend = {0}, paragraph = {0};
    const bool is_small = short_answer_rows(session) < SMALL_ANSWER_ROWS;
    precision_winners(precision, is_small ? 6 : 3, false, width, arena, &table);
    struct text shown = buffer_text(&table), heading;
    if (is_small)
        text_split(&shown, '\n', &heading);
    buffer_put(&rest, shown);
    const int winners = text_rows(buffer_text(&rest), width);
    precision_legend(precision, width, &legend);
    if (text_rows(buffer_text(&legend), width) + winners + FIGURE_ROWS_MIN + 1 >
        answer_rows(session))
        buffer_clear(&legend);
    if (!is_small) {
        put_without_result(precision, &paragraph);
        put_subject(session, precision, seconds, &paragraph);
    }
    put_folded_lines(&paragraph, width, &rest);
    buffer_put(&rest, width < 60
                          ? TEXT("fastest per error; 'precision table'\n")
                          : TEXT("'precision table [METHOD]': slopes, values; --full: all\n"));
    const int room = answer_rows(session) - text_rows(buffer_text(&rest), width) -
                     text_rows(buffer_text(&legend), width);
    put_figure(session, precision, width, room > FIGURE_ROWS_MIN ? room : FIGURE_ROWS_MIN, arena,
               text);
    buffer_put(text, buffer_text(&legend));
    buffer_put(text, buffer_text(&rest));
    text->failed |= rest.failed;
    buffer_free(&table);
    buffer_free(&rest);
    buffer_free(&legend);
    buffer_free(&paragraph);
}

/* Adds the study to the reply as text: the short answer, or with --full everything. `absent` holds
 * lines on methods that were left out; `seconds` is what the study took. */
static void reply_study(const struct session *session, const struct arguments *args,
                        const struct precision *precision, const struct buffer *absent,
                        double seconds, struct reply *reply)
{
    if (!reply_wants_text(reply))
        return;
    struct buffer *text = reply_buffer(reply);
    int width, height;
    session_size(session, &width, &height);
    if (!asks_full(args)) {
        put_short(session, precision, width, seconds, args->arena, text);
        return;
    }
    put_figure(session, precision, width, height, args->arena, text);
    precision_legend(precision, width, text);
    precision_winners(precision, 1, true, width, args->arena, text);
    put_without_result(precision, text);
    put_subject(session, precision, seconds, text);
    buffer_put(text, buffer_text(absent));
    precision_tables(precision, NULL, width, args->arena, text);
    put_marks(text, precision, false);
}

/* Moves the study into the session, where it replaces the one before. Out of memory, nothing
 * changes and *precision still owns the study. */
static void store_precision(struct session *session, struct precision *precision)
{
    struct comparison_part *part = session_part(session, &comparison_module);
    struct precision *stored = part ? malloc(sizeof *stored) : NULL;
    if (!stored)
        return;
    *stored = *precision;
    *precision = (struct precision){0};
    if (part->precision)
        precision_free(part->precision);
    free(part->precision);
    part->precision = stored;
}

/* Answers `precision table` from the latest study: the slope of each method, or all values of the
 * named methods, or with --full of all. Returns false with an error if there is no study or a
 * method was not part of it. */
static bool reply_tables(const struct session *session, const struct arguments *args,
                         struct reply *reply, struct error *error)
{
    const struct argument_value *methods = argument_value(args, "METHOD");
    const struct precision *precision = session_precision(session);
    struct buffer text = {0};
    int width, height;
    session_size(session, &width, &height);
    if (!precision) {
        error_set(error, ERROR_COMMAND, "there is no precision study yet");
        return error_hint(error, "'precision' makes one");
    }
    for (int i = 0; i < methods->count; i++) {
        const size_t old_len = text.len;
        const struct row *row = methods->item[i].row;
        precision_tables(precision, method_from(row), width, args->arena, &text);
        if (text.len == old_len) {
            buffer_free(&text);
            return error_at(error, methods->item[i].text, "%s was not part of the last study",
                            row->name);
        }
    }
    const bool full = asks_full(args);
    if (methods->count == 0 && full)
        precision_tables(precision, NULL, width, args->arena, &text);
    else if (methods->count == 0) {
        precision_overview(precision, &text);
        put_without_result(precision, &text);
    }
    if (methods->count > 0 || full)
        put_marks(&text, precision, !full);
    if (methods->count == 0 && full)
        precision_winners(precision, 1, true, width, args->arena, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

/* Executes `precision` and `precision table`. What is finished when the study is stopped is shown
 * and kept. */
HANDLER(precision)
{
    const struct argument_value *dt = argument_value(args, "dt"),
                                *tol = argument_value(args, "tol");
    const size_t capacity = (size_t)argument_value(args, "METHOD")->count + PRECISION_DEFAULTS;
    struct method_choice *choice = arena_array(args->arena, capacity, sizeof *choice);
    struct buffer absent = {0};
    struct system system;
    int count = 0;
    if (!choice)
        return error_memory(error);
    if (has_argument(args, "table"))
        return reply_tables(session, args, reply, error);
    struct precision_request request = {.scene = &session->setup.scene,
                                        .choice = choice,
                                        .duration = session->setup.settings.duration,
                                        .timing = (enum timing)session->setup.settings.timing,
                                        .compensated = session_run_settings(session).compensated,
                                        .recording = has_argument(args, "recording"),
                                        .references = session_references(session),
                                        .cancel = session->front.cancel};
    take_range(dt, request.dt);
    take_range(tol, request.tol);
    bool ok = check_range(dt, "dt=1ms:100ms", error) && check_range(tol, "tol=1e-10:1e-3", error) &&
              scene_bind(&session->setup.scene, &system, error);
    if (ok && argument_value(args, "METHOD")->count == 0)
        count = precision_defaults(&system, request.duration, choice, note_absent, &absent);
    ok = ok && choose_methods(args, DRAG_DEFAULT, choice, &count, error);
    if (!ok) {
        buffer_free(&absent);
        return false;
    }
    request.choices = count;
    struct precision precision;
    const int64_t begin = clock_ns();
    reply_assumed(session, false, true, reply);
    reply_shorter(session, reply);
    ok = study_precision(&request, &precision, error);
    precision.by_evals = has_argument(args, "evaluations");
    if (precision.curves > 0) {
        reply_study(session, args, &precision, &absent, clock_seconds(begin), reply);
        reply_precision(session, &precision, args->arena, reply);
        store_precision(session, &precision);
    }
    buffer_free(&absent);
    precision_free(&precision);
    return ok;
}
#endif

COMMAND(precision, .group = "STUDY", .flags = COMMAND_TABLES,
        ARGUMENTS(WORD("table", TYPE_NONE), WORD("evaluations", TYPE_NONE),
                  PLACE("METHOD", TYPE_CHOICE, .flags = ARG_MANY, .choices = &method_catalog),
                  KEY("dt", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  KEY("tol", TYPE_RANGE, .quantity = QUANTITY_NUMBER),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog),
                  OPTION("recording", TYPE_NONE), OPTION("full", TYPE_NONE)))
