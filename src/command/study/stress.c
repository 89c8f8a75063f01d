/* SPDX-License-Identifier: GPL-3.0-or-later */
/* stress */
#ifndef COMMAND_ROWS
#include <hooke/study/stability.h>
#include <hooke/command/handler.h>

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NAME_WIDTH 22
#define SCREEN_WIDTH 80
#define TOGETHER 5 /* letters without a gap */

static const char *letter(enum stress_verdict verdict)
{
    return catalog_row(&stress_verdict_catalog, verdict)->unit;
}

/* Rows stand case by case; NULL: not finished. */
static const struct stress_row *row_of(const struct stress *stress, int index, int method,
                                       int methods)
{
    const int i = index * methods + method;
    return i < stress->rows ? &stress->row[i] : NULL;
}

static void put_gap(struct buffer *out, int column)
{
    if (column % TOGETHER == 0)
        buffer_char(out, ' ');
}

/* Methods down, cases across, as many as the width holds; their numbers stand above, tens and ones.
 */
static void put_block(const struct stress *stress, const struct method *const *method, int methods,
                      int from, int to, struct buffer *out)
{
    for (int digit = 10; digit >= 1; digit /= 10) {
        buffer_format(out, "%-*s", NAME_WIDTH, digit == 1 ? "method" : "case");
        for (int c = from; c < to; c++) {
            put_gap(out, c - from);
            buffer_format(out, "%c", digit == 10 && c + 1 < 10 ? ' ' : '0' + (c + 1) / digit % 10);
        }
        buffer_char(out, '\n');
    }
    for (int m = 0; m < methods; m++) {
        buffer_format(out, "%-*s", NAME_WIDTH, method[m]->row.name);
        for (int c = from; c < to; c++) {
            const struct stress_row *row = row_of(stress, c, m, methods);
            put_gap(out, c - from);
            buffer_put(out, row ? text_of(letter(row->verdict)) : TEXT(" "));
        }
        buffer_char(out, '\n');
    }
}

/* Words in lines of at most `width` columns: the first begins at `first`, the others at `rest`. */
static void put_wrapped(struct buffer *out, struct text text, int width, int first, int rest)
{
    struct text word;
    int column = first;
    buffer_format(out, "%*s", first, "");
    for (bool begun = false; text_split(&text, ' ', &word); begun = true) {
        const int w = text_width(word);
        if (begun && column + 1 + w > width) {
            buffer_format(out, "\n%*s", rest, "");
            column = rest;
        } else if (begun) {
            buffer_char(out, ' ');
            column++;
        }
        buffer_put(out, word);
        column += w;
    }
    buffer_char(out, '\n');
}

/* Past the method's name and everything that belongs to a number. */
static const char *skip(const char *at, const char *name)
{
    const size_t len = strlen(name);
    for (;;) {
        if (strncmp(at, name, len) == 0)
            at += len;
        else if (*at && strchr("0123456789.+-", *at))
            at++;
        else if (*at == 'e' && at[1] && strchr("0123456789+-", at[1]))
            at++;
        else
            return at;
    }
}

/* The same for the same reason but for names and numbers (FNV-1a; Fowler, Noll, Vo 1991), of the
 * same verdict. */
static uint64_t kind_of(const struct stress_row *row)
{
    uint64_t sum = 0xCBF29CE484222325u + (uint64_t)row->verdict;
    for (const char *at = row->reason; *(at = skip(at, row->method->row.name)); at++)
        sum = (sum ^ (unsigned char)*at) * 0x100000001B3u;
    return sum;
}

/* What is not good, by reason: the first method that has it, and how many more. kind: [methods]
 * scratch. */
static void put_case(const struct stress *stress, int index, int methods, int width, uint64_t *kind,
                     struct buffer *out)
{
    const struct stress_case *what = &stress->cases[index];
    struct buffer line = {0};
    buffer_format(&line, "%d %s: %s", index + 1, what->name, what->brief);
    put_wrapped(out, buffer_text(&line), width, index + 1 < 10, 3);
    for (int m = 0; m < methods; m++) {
        const struct stress_row *row = row_of(stress, index, m, methods);
        kind[m] = row && row->reason[0] ? kind_of(row) : 0;
    }
    for (int m = 0; m < methods; m++) {
        const struct stress_row *row = row_of(stress, index, m, methods);
        bool before = false;
        int more = 0;
        if (!row || !row->reason[0])
            continue;
        for (int i = 0; i < methods; i++) {
            const bool same = i != m && kind[i] == kind[m];
            before |= same && i < m;
            more += same && i > m;
        }
        if (before)
            continue;
        buffer_clear(&line);
        buffer_format(&line, "%s %s", letter(row->verdict), row->method->row.name);
        if (more > 0)
            buffer_format(&line, " and %d more", more);
        buffer_format(&line, ": %s", row->reason);
        put_wrapped(out, buffer_text(&line), width, 3, 5);
    }
    buffer_free(&line);
}

static void put_stress(const struct session *session, const struct stress *stress,
                       const struct method *const *method, int methods, struct buffer *out)
{
    int width, height;
    session_size(session, &width, &height);
    const int max = (width - NAME_WIDTH) * TOGETHER / (TOGETHER + 1);
    const int columns = max < TOGETHER ? TOGETHER : max;
    const int finished = methods ? (stress->rows + methods - 1) / methods : 0;
    for (int from = 0; from < finished; from += columns) {
        put_block(stress, method, methods, from,
                  from + columns < finished ? from + columns : finished, out);
        buffer_char(out, '\n');
    }
    for (enum stress_verdict v = 0; v < STRESS_VERDICTS; v++)
        if (stress->count_of[v])
            buffer_format(out, "%s %4d %s: %s\n", letter(v), stress->count_of[v],
                          catalog_row(&stress_verdict_catalog, v)->name,
                          catalog_row(&stress_verdict_catalog, v)->brief);
    buffer_char(out, '\n');
    uint64_t *kind = calloc((size_t)methods + 1, sizeof *kind);
    for (int c = 0; c < finished && kind; c++)
        put_case(stress, c, methods, width, kind, out);
    out->failed |= !kind;
    free(kind);
    buffer_format(out, "%d method%s, %d case%s", methods, methods == 1 ? "" : "s", finished,
                  finished == 1 ? "" : "s");
    if (!isnan(stress->seconds))
        buffer_format(out, ", %.1f s", stress->seconds);
    buffer_char(out, '\n');
}

/* ---- the short form ---- */

enum stress_class { CLASS_RIGHT, CLASS_SAID, CLASS_WRONG, CLASSES };

static enum stress_class class_of(enum stress_verdict verdict)
{
    if (verdict == STRESS_EXACT || verdict == STRESS_ACCURATE)
        return CLASS_RIGHT;
    const bool wrong =
        verdict == STRESS_BOUNDED || verdict == STRESS_DAMPED || verdict == STRESS_UNEXPLAINED;
    return wrong ? CLASS_WRONG : CLASS_SAID;
}

struct stress_total {
    const struct method *method;
    int count[CLASSES];
    const struct stress_row *slowest; /* by time, else by steps; NULL: nothing was finished */
};

static bool is_slower(const struct stress_row *row, const struct stress_row *than)
{
    return !than || (isnan(row->seconds) ? row->steps > than->steps : row->seconds > than->seconds);
}

/* Most wrong answers first; the order of the list among equals. */
static int compare_totals(const void *a, const void *b)
{
    const struct stress_total *one = a, *other = b;
    if (one->count[CLASS_WRONG] != other->count[CLASS_WRONG])
        return other->count[CLASS_WRONG] - one->count[CLASS_WRONG];
    return (one->method > other->method) - (one->method < other->method);
}

static void total_cells(const struct stress *stress, const struct stress_total *total,
                        struct text_table *table)
{
    cell_text(table, total->method->row.name);
    for (enum stress_class c = 0; c < CLASSES; c++)
        cell_count(table, total->count[c]);
    struct buffer text = {0};
    const struct stress_row *slowest = total->slowest;
    if (slowest) {
        buffer_format(&text, "%s, ", stress->cases[slowest->index].name);
        if (isnan(slowest->seconds))
            buffer_format(&text, "%lld steps", (long long)slowest->steps);
        else
            buffer_quantity(&text, slowest->seconds, QUANTITY_TIME, 2);
    }
    cell_take(table, &text);
}

/* Those that are never wrong. */
static void put_right(const struct stress_total *total, int methods, int width, struct buffer *out)
{
    struct buffer line = {0};
    buffer_put(&line, TEXT("nothing wrong:"));
    const size_t begin = line.len;
    for (int i = 0; i < methods; i++)
        if (total[i].count[CLASS_WRONG] == 0)
            buffer_format(&line, " %s", total[i].method->row.name);
    if (line.len > begin)
        put_wrapped(out, buffer_text(&line), width, 0, 3);
    out->failed |= line.failed;
    buffer_free(&line);
}

/* A line for each method that is wrong somewhere, as many as fit. */
static void put_totals(const struct stress *stress, struct stress_total *total, int methods,
                       int width, int rows, struct arena *arena, struct buffer *out)
{
    static const char *const heading[] = {"method", "right", "said so", "wrong", "slowest case"};
    struct text_table table = {.arena = arena, .columns = CLASSES + 2, .gap = 2};
    struct buffer right = {0};
    int wrong = 0;
    qsort(total, (size_t)methods, sizeof *total, compare_totals);
    while (wrong < methods && total[wrong].count[CLASS_WRONG] > 0)
        wrong++;
    put_right(total, methods, width, &right);
    const int room = rows - 1 - text_rows(buffer_text(&right), width);
    const int shown = wrong <= room ? wrong : room - 1 > 1 ? room - 1 : 1;
    for (size_t i = 0; i < COUNT_OF(heading); i++)
        cell_text(&table, heading[i]);
    for (int i = 0; i < (wrong > 0 ? shown : methods < room ? methods : 0); i++)
        total_cells(stress, &total[i], &table);
    if (table.cells > table.columns)
        text_table_put(&table, out);
    if (shown < wrong)
        buffer_format(out, "... %d more methods, wrong in at most %d cases: --full\n",
                      wrong - shown, total[shown].count[CLASS_WRONG]);
    buffer_put(out, buffer_text(&right));
    buffer_free(&right);
}

/* Which of them each verdict was given to: the cases of one method, the methods of one case. */
static void put_verdicts(const struct stress *stress, int methods, int width, struct buffer *out)
{
    struct buffer line = {0};
    for (enum stress_verdict v = 0; v < STRESS_VERDICTS; v++) {
        bool first = true;
        buffer_clear(&line);
        buffer_format(&line, "%s:", catalog_row(&stress_verdict_catalog, v)->name);
        for (int i = 0; i < stress->rows; i++) {
            const struct stress_row *row = &stress->row[i];
            if (row->verdict != v)
                continue;
            buffer_format(&line, "%s %s", first || methods > 1 ? "" : ",",
                          methods > 1 ? row->method->row.name : stress->cases[row->index].name);
            first = false;
        }
        if (!first)
            put_wrapped(out, buffer_text(&line), width, 0, 3);
    }
    out->failed |= line.failed;
    buffer_free(&line);
}

/* [methods]; NULL: no memory */
static struct stress_total *count_totals(const struct stress *stress,
                                         const struct method *const *method, int methods,
                                         struct arena *arena)
{
    struct stress_total *total = arena_array(arena, (size_t)methods + 1, sizeof *total);
    for (int m = 0; m < methods && total; m++) {
        total[m] = (struct stress_total){.method = method[m]};
        for (int i = m; i < stress->rows; i += methods) {
            const struct stress_row *row = &stress->row[i];
            total[m].count[class_of(row->verdict)]++;
            if (is_slower(row, total[m].slowest))
                total[m].slowest = row;
        }
    }
    return total;
}

static void put_short(const struct session *session, const struct stress *stress,
                      const struct method *const *method, int methods, struct arena *arena,
                      struct buffer *out)
{
    int width, height;
    struct stress_total *total = count_totals(stress, method, methods, arena);
    struct buffer end = {0};
    session_size(session, &width, &height);
    if (!total) {
        out->failed = true;
        return;
    }
    buffer_format(&end, "%d method%s, %d case%s", methods, methods == 1 ? "" : "s", stress->count,
                  stress->count == 1 ? "" : "s");
    if (!isnan(stress->seconds))
        buffer_format(&end, ", %.1f s", stress->seconds);
    buffer_put(&end, TEXT("; wrong: an error above 1 % without a word (bounded, damped away); "
                          "said so: refused, diverged ...\n"));
    buffer_put(&end, stress->count > 1 && methods > 1
                         ? TEXT("'stress METHOD', 'stress CASE': verdict by verdict; --full: "
                                "the matrix, with reasons\n")
                         : TEXT("the reasons: --full\n"));
    if (stress->count > 1 && methods > 1)
        put_totals(stress, total, methods, width,
                   answer_rows(session) - text_rows(buffer_text(&end), width), arena, out);
    else if (stress->count > 1)
        put_totals(stress, total, methods, width, 4, arena, out);
    if (stress->count == 1)
        buffer_format(out, "%s: %s\n", stress->cases[0].name, stress->cases[0].brief);
    if (stress->count == 1 || methods == 1)
        put_verdicts(stress, methods, width, out);
    buffer_put(out, buffer_text(&end));
    buffer_free(&end);
}

struct stress_record {
    const struct stress *stress;
    struct stress_row row;
};

static const char *scene_of(const void *row)
{
    const struct stress_record *record = row;
    return record->stress->cases[record->row.index].name;
}

static const char *method_of(const void *row)
{
    return ((const struct stress_record *)row)->row.method->row.name;
}

static const char *verdict_of(const void *row)
{
    return catalog_row(&stress_verdict_catalog, ((const struct stress_record *)row)->row.verdict)
        ->name;
}

#define AT(member) .at = offsetof(struct stress_record, row.member)

static const struct result_column of_stress[] = {
    {.name = "scene", .kind = COLUMN_NAME, .text = scene_of},
    {.name = "method", .kind = COLUMN_NAME, .text = method_of},
    {.name = "verdict", .kind = COLUMN_NAME, .text = verdict_of},
    {.name = "error", AT(error)},
    {.name = "steps", .kind = COLUMN_COUNT, AT(steps)},
    {.name = "time", AT(seconds), .quantity = QUANTITY_TIME},
    {.name = "reason", .kind = COLUMN_CHARS, AT(reason)},
};

static const struct result_columns stress_columns = RESULT_COLUMNS(of_stress, struct stress_record);

/* Initial values, and what else acts, of the present scene. */
static bool this_scene(const struct session *session, struct arena *arena, struct stress_scene *of,
                       struct error *error)
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
    *of = (struct stress_scene){scene, session->setup.settings.duration, start, matter};
    return true;
}

/* Lists the methods that are named, or all where none is, and the case. Returns their number; 0
 * with an error where two cases are named. */
static int list_stressed(const struct argument_value *wanted, const struct method **method,
                         struct text *only, struct error *error)
{
    int methods = 0;
    for (int i = 0; i < wanted->count; i++) {
        const struct item *item = &wanted->item[i];
        if (item->row) {
            method[methods++] = (const struct method *)(const void *)item->row;
        } else if (only->len > 0) {
            error_at(error, item->text, "one case at a time");
            return 0;
        } else {
            *only = item->text;
        }
    }
    const bool all = methods == 0;
    for (size_t i = 0; i < method_catalog.count && all; i++) {
        const struct method *row =
            (const struct method *)(const void *)catalog_row(&method_catalog, i);
        if (!(row->flags & METHOD_EXTERNAL)) /* somebody else's: only when named */
            method[methods++] = row;
    }
    return methods;
}

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
    struct stress_scene of;
    const bool present = has_argument(args, "scene");
    if (present && !this_scene(session, args->arena, &of, error))
        return false;
    const bool ok = study_stress(present ? &of : NULL, only, method, methods, session->front.cancel,
                                 stress, error);
    struct buffer text = {0};
    if (session->setup.settings.timing == TIMING_OFF) {
        stress->seconds = NAN;
        for (int i = 0; i < stress->rows; i++)
            stress->row[i].seconds = NAN;
    }
    if (stress->rows > 0 && asks_full(args)) {
        struct stress_total *total = count_totals(stress, method, methods, args->arena);
        if (total)
            put_totals(stress, total, methods, SCREEN_WIDTH, INT_MAX, args->arena, &text);
        buffer_char(&text, '\n');
        put_stress(session, stress, method, methods, &text);
    } else if (stress->rows > 0)
        put_short(session, stress, method, methods, args->arena, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    for (int i = 0; i < stress->rows; i++) {
        const struct stress_record record = {stress, stress->row[i]};
        reply_records(reply, "stress", &stress_columns, &record, 1);
    }
    stress_free(stress);
    return ok;
}
#endif

COMMAND(
    stress,
    .row = {"stress", "", "the stiff and the extreme: each method, one verdict each", "", NULL},
    .group = "STUDY",
    .text =
        "Stiff scenes, extremes of scale, critical damping, steps far above the limit, "
        "inputs that make no sense: "
        "each method\n"
        "(or those named) on each of them, with a budget of steps; methods that adapt with "
        "tol = 1e-6, the others "
        "in 1024 steps.\n"
        "A line a method: how many are right, how many it refuses or reports itself, how many "
        "are wrong; of one method, or of one case (by name or number), the verdicts. "
        "--full: a letter each, then the reasons. The present scene is not changed; with 'scene' "
        "the cases are made of "
        "it, over its\n"
        "duration: steps around each method's limit, parameters 1e6 times smaller and "
        "larger, 0 and with the other "
        "sign, initial\n"
        "values of 1e-310, 1e-150 and 1e150.",
    .examples = "stress euler rk4 radau5; stress orego\nscene pendulum; stress scene rk4 "
                "verlet dop853",
    .see = "stability compare precision", .flags = COMMAND_TABLES,
    ARGUMENTS(WORD("scene", TYPE_NONE),
              PLACE("METHOD|CASE", TYPE_STRESSED, .flags = ARG_MANY, .choices = &method_catalog),
              KEY("case", TYPE_TEXT), OPTION("full", TYPE_NONE)))
