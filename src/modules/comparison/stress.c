/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command `stress`: runs methods on stiff and extreme cases by study_stress(), and lists how
 * many of their answers are right, reported as failures, or wrong without a message. */
#include <hooke/base/numeric.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include "modules/comparison/comparison.h"
#ifndef COMMAND_ROWS
#include "modules/comparison/compute/stability.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* ---- a line for each method ---- */

enum stress_class { CLASS_RIGHT, CLASS_REPORTED, CLASS_WRONG, CLASSES };

/* Returns whether an answer with this verdict is right, a failure that the method or the program
 * reports, or wrong without any message. */
static enum stress_class verdict_class(enum stress_verdict verdict)
{
    if (verdict == STRESS_EXACT || verdict == STRESS_ACCURATE)
        return CLASS_RIGHT;
    const bool wrong =
        verdict == STRESS_BOUNDED || verdict == STRESS_DAMPED || verdict == STRESS_UNEXPLAINED;
    return wrong ? CLASS_WRONG : CLASS_REPORTED;
}

/* The answers of one method to all cases, as a line of the table. */
struct stress_total {
    const struct method *method;
    int count[CLASSES];          /* number of cases in each class */
    const struct stress *stress; /* study that the line belongs to */
    /* slowest by time, else by steps, or NULL if nothing was finished */
    const struct stress_row *slowest;
};

/* Returns true if a row took longer than another, which may be NULL, or made more steps if nothing
 * was timed. */
static bool is_slower(const struct stress_row *row, const struct stress_row *other)
{
    return !other ||
           (isnan(row->seconds) ? row->steps > other->steps : row->seconds > other->seconds);
}

/* Orders lines for qsort(): most wrong answers first, then as in the list of methods. */
static int compare_totals(const void *a, const void *b)
{
    const struct stress_total *one = a, *other = b;
    if (one->count[CLASS_WRONG] != other->count[CLASS_WRONG])
        return other->count[CLASS_WRONG] - one->count[CLASS_WRONG];
    return (one->method > other->method) - (one->method < other->method);
}

/* Writes the name of the slowest case with its time, or its number of steps if nothing was
 * timed. */
static void slowest_cell(struct text_table *table, const void *row)
{
    const struct stress_total *total = row;
    const struct stress_row *slowest = total->slowest;
    struct buffer text = {0};
    if (slowest)
        buffer_format(&text, "%s, ", total->stress->cases[slowest->index].name);
    if (slowest && isnan(slowest->seconds))
        buffer_format(&text, "%lld steps", (long long)slowest->steps);
    else if (slowest)
        buffer_quantity(&text, slowest->seconds, QUANTITY_TIME, 2);
    cell_take(table, &text);
}

#define COUNTED(class) .kind = COLUMN_INT, .offset = offsetof(struct stress_total, count[class])

static const struct result_column of_total[] = {
    {.heading = "method",
     .kind = COLUMN_ROW,
     .offset = offsetof(struct stress_total, method),
     .index = 1},
    {.heading = "right", COUNTED(CLASS_RIGHT), .index = 2},
    {.heading = "reported", COUNTED(CLASS_REPORTED), .index = 3},
    {.heading = "wrong", COUNTED(CLASS_WRONG), .index = 4},
    {.heading = "slowest case", .kind = COLUMN_NAME, .cell = slowest_cell, .index = 5},
};

static const struct result_columns total_columns = RESULT_COLUMNS(of_total, struct stress_total);

/* Appends the names of the methods that are wrong in no case, from total [methods], in lines of
 * `width` cells. */
static void put_right(const struct stress_total *total, int methods, int width,
                      struct buffer *output)
{
    struct buffer line = {0};
    for (int i = 0; i < methods; i++)
        if (total[i].count[CLASS_WRONG] == 0)
            buffer_format(&line, "%s %s",
                          line.len ? "" : "no wrong cases:", total[i].method->row.name);
    buffer_folded(output, buffer_text(&line), width);
    if (line.len > 0)
        buffer_char(output, '\n');
    output->failed |= line.failed;
    buffer_free(&line);
}

/* Appends a table with a line for each method that is wrong in some case, the worst first, within
 * `rows` rows of `width` cells, then the names of the methods that are right. Methods that do not
 * fit are counted in a line "... n more". If no method is wrong, all have a line if there is room.
 * Sets output->failed if out of memory. */
static void put_totals(const struct stress *stress, const struct method *const *method, int methods,
                       int width, int rows, struct arena *arena, struct buffer *output)
{
    struct text_table table = {.arena = arena, .gap = 2};
    struct stress_total *total = arena_array(arena, (size_t)methods + 1, sizeof *total);
    struct buffer right = {0};
    int wrong = 0;
    for (int m = 0; m < methods && total; m++) {
        total[m] = (struct stress_total){.method = method[m], .stress = stress};
        for (int i = m; i < stress->rows; i += methods) {
            const struct stress_row *row = &stress->row[i];
            total[m].count[verdict_class(row->verdict)]++;
            if (is_slower(row, total[m].slowest))
                total[m].slowest = row;
        }
        wrong += total[m].count[CLASS_WRONG] > 0;
    }
    if (!total) {
        output->failed = true;
        return;
    }
    qsort(total, (size_t)methods, sizeof *total, compare_totals);
    put_right(total, methods, width, &right);
    const int room = rows - 1 - text_rows(buffer_text(&right), width);
    const int shown = wrong <= room ? wrong : int_max(room - 1, 1);
    int lines = methods < room ? methods : 0;
    if (wrong > 0)
        lines = shown;
    columns_text(&total_columns, total, (size_t)lines, true, &table);
    if (lines > 0)
        text_table_put(&table, output);
    if (shown < wrong)
        buffer_format(
            output,
            "... %d more methods with at most %d wrong cases ('stress --full' lists them)\n",
            wrong - shown, total[shown].count[CLASS_WRONG]);
    buffer_put(output, buffer_text(&right));
    buffer_free(&right);
}

/* ---- verdict by verdict ---- */

/* Appends a line for each verdict that occurs among rows [begin, end), which lists methods if
 * `by_method`, otherwise cases. With `reasons`, the first reason is added. */
static void put_verdicts(const struct stress *stress, int begin, int end, bool by_method, int width,
                         bool reasons, struct buffer *output)
{
    struct buffer line = {0};
    for (enum stress_verdict v = 0; v < STRESS_VERDICTS; v++) {
        const char *reason = "";
        buffer_clear(&line);
        for (int i = begin; i < end; i++) {
            const struct stress_row *row = &stress->row[i];
            if (row->verdict != v)
                continue;
            if (line.len == 0)
                buffer_format(&line, "%s:", catalog_row(&stress_verdict_catalog, v)->name);
            else if (!by_method)
                buffer_char(&line, ',');
            buffer_format(&line, " %s",
                          by_method ? row->method->row.name : stress->cases[row->index].name);
            reason = *reason ? reason : row->reason;
        }
        if (reasons && *reason)
            buffer_format(&line, " (%s)", reason);
        buffer_folded(output, buffer_text(&line), width);
        if (line.len > 0)
            buffer_char(output, '\n');
    }
    output->failed |= line.failed;
    buffer_free(&line);
}

/* Appends the numbers of methods and cases, and the computing time. */
static void put_count(const struct stress *stress, int methods, int cases, struct buffer *output)
{
    buffer_format(output, "%d method%s, %d case%s", methods, plural_s(methods), cases,
                  plural_s(cases));
    if (!isnan(stress->seconds))
        buffer_format(output, ", %.1f s", stress->seconds);
}

/* Appends the answer to --full: the table of methods, each case with its verdicts and reasons, and
 * how often each verdict was given. */
static void put_full(const struct session *session, const struct stress *stress,
                     const struct method *const *method, int methods, struct arena *arena,
                     struct buffer *output)
{
    int width, height;
    session_size(session, &width, &height);
    put_totals(stress, method, methods, width, INT_MAX, arena, output);
    const int finished = (stress->rows + methods - 1) / methods;
    for (int c = 0; c < finished; c++) {
        const int begin = c * methods, end = begin + methods;
        buffer_format(output, "\n%d %s: %s\n", c + 1, stress->cases[c].name,
                      stress->cases[c].brief);
        put_verdicts(stress, begin, end < stress->rows ? end : stress->rows, true, width, true,
                     output);
    }
    buffer_char(output, '\n');
    for (enum stress_verdict v = 0; v < STRESS_VERDICTS; v++)
        if (stress->count_of[v])
            buffer_format(output, "%4d %s: %s\n", stress->count_of[v],
                          catalog_row(&stress_verdict_catalog, v)->name,
                          catalog_row(&stress_verdict_catalog, v)->brief);
    put_count(stress, methods, finished, output);
}

/* Appends the usual answer: the table of methods that fits on the screen, or the verdicts if only
 * one case or one method was asked for. */
static void put_short(const struct session *session, const struct stress *stress,
                      const struct method *const *method, int methods, struct arena *arena,
                      struct buffer *output)
{
    enum { ROWS_OF_ONE = 4 /* rows of the table of one method */ };
    int width, height;
    struct buffer end = {0};
    session_size(session, &width, &height);
    put_count(stress, methods, stress->count, &end);
    buffer_format(
        &end,
        "; wrong: an error above 1 %% without any message (bounded, damped away); reported: "
        "refused, diverged ...\n%s",
        stress->count > 1 && methods > 1
            ? "'stress METHOD' or 'stress CASE' lists verdicts, --full all with reasons\n"
            : "reasons: --full\n");
    if (stress->count > 1)
        put_totals(stress, method, methods, width,
                   methods > 1 ? answer_rows(session) - text_rows(buffer_text(&end), width)
                               : ROWS_OF_ONE,
                   arena, output);
    else
        buffer_format(output, "%s: %s\n", stress->cases[0].name, stress->cases[0].brief);
    if (stress->count == 1 || methods == 1)
        put_verdicts(stress, 0, stress->rows, methods > 1, width, false, output);
    buffer_put(output, buffer_text(&end));
    buffer_free(&end);
}

/* ---- records ---- */

#define AT(member) .offset = offsetof(struct stress_row, member)

static const struct result_column of_stress[] = {
    {.name = "scene", .kind = COLUMN_NAME, AT(scene)},
    {.name = "method", .kind = COLUMN_ROW, AT(method)},
    {.name = "verdict", .kind = COLUMN_CHOICE, AT(verdict), .choices = &stress_verdict_catalog},
    {.name = "error", AT(error)},
    {.name = "steps", .kind = COLUMN_COUNT, AT(steps)},
    {.name = "time", AT(seconds), .quantity = QUANTITY_TIME},
    {.name = "reason", .kind = COLUMN_CHARS, AT(reason)},
};

static const struct result_columns stress_columns = RESULT_COLUMNS(of_stress, struct stress_row);

/* Fills in *result from the session's scene: which parameters are initial values, and which of the
 * others have an effect. Memory is from the arena. Returns false with an error if the scene is
 * invalid or if out of memory. */
static bool stress_scene_make(const struct session *session, struct arena *arena,
                              struct stress_scene *result, struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    const size_t params = scene_params(scene)->count;
    bool *start = arena_array(arena, params, sizeof *start),
         *matter = arena_array(arena, params, sizeof *matter);
    struct system system;
    if (!start || !matter)
        return error_memory(error);
    if (!scene_bind(scene, &system, error))
        return false;
    for (int i = 0; i < (int)params; i++) {
        const bool begins = param_is_start(scene, i);
        start[i] = begins && i != scene_param(scene, "t0");
        matter[i] = !begins && param_matters(scene, i);
    }
    *result = (struct stress_scene){scene, session->setup.settings.duration, start, matter};
    return true;
}

/* Sorts the words of the statement into methods and a case. Without methods, all but those of
 * external libraries are listed. Sets *only to the name of the case, if any. Returns the number of
 * methods, or 0 with an error if two cases are named. */
static int list_stressed(const struct argument_value *wanted, const struct method **method,
                         struct text *only, struct error *error)
{
    int methods = 0;
    for (int i = 0; i < wanted->count; i++) {
        const struct item *item = &wanted->item[i];
        if (item->row) {
            method[methods++] = method_from(item->row);
        } else if (only->len > 0) {
            error_at(error, item->text, "one case at a time");
            return 0;
        } else {
            *only = item->text;
        }
    }
    const bool all = methods == 0;
    for (size_t i = 0; i < method_catalog.count && all; i++) {
        const struct method *row = method_at(i);
        if (!(row->flags & METHOD_EXTERNAL)) /* somebody else's: only when named */
            method[methods++] = row;
    }
    return methods;
}

/* Executes `stress`, on the built-in cases or, with the word `scene`, on those made of the
 * session's scene. */
HANDLER(stress)
{
    const struct argument_value *wanted = argument_value(args, "METHOD|CASE");
    const struct argument_value *one = argument_value(args, "case");
    const struct method **method =
        arena_array(args->arena, method_catalog.count + (size_t)wanted->count, sizeof *method);
    struct stress *stress = arena_array(args->arena, 1, sizeof *stress);
    struct text only = one->count ? one->item->text : TEXT("");
    if (!method || !stress)
        return error_memory(error);
    const int methods = list_stressed(wanted, method, &only, error);
    if (methods == 0)
        return false;
    struct stress_scene stress_scene;
    const bool present = has_argument(args, "scene");
    if (present && !stress_scene_make(session, args->arena, &stress_scene, error))
        return false;
    const bool ok = study_stress(present ? &stress_scene : NULL, only, method, methods,
                                 session->front.cancel, stress, error);
    if (session->setup.settings.timing == TIMING_OFF) {
        stress->seconds = NAN;
        for (int i = 0; i < stress->rows; i++)
            stress->row[i].seconds = NAN;
    }
    if (stress->rows > 0 && reply_wants_text(reply))
        (asks_full(args) ? put_full : put_short)(session, stress, method, methods, args->arena,
                                                 reply_buffer(reply));
    reply_records(reply, "stress", &stress_columns, stress->row, (size_t)stress->rows);
    stress_free(stress);
    return ok;
}
#endif

COMMAND(stress, .group = "STUDY", .flags = COMMAND_TABLES,
        ARGUMENTS(WORD("scene", TYPE_NONE),
                  PLACE("METHOD|CASE", TYPE_CHOICE, .own_type = &stressed_type, .flags = ARG_MANY,
                        .choices = &method_catalog),
                  KEY("case", TYPE_TEXT), OPTION("full", TYPE_NONE)))
