/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study as text and as records: a table per method, and a ranking of the fastest
 * methods for each error. */
#include <hooke/base/safe_text.h>
#include "modules/comparison/comparison.h"
#include <hooke/report.h>

#include <math.h>
#include <stdio.h>

/* width [cell] from which tables also show errors at the end, of phase and of amplitude */
#define WIDE_TABLE_CELLS 110

/* ---- a method ---- */

/* Appends the measured slope of a curve beside the claimed one, or the reason why there is none. */
static void put_slope(const struct precision_curve *curve, struct buffer *output)
{
    if (curve->fitted == 0) {
        buffer_format(output, "no slope: %s\n",
                      isnan(curve->expected) ? "the method makes no error in this scene"
                                             : "fewer than 3 errors lie between 5 % and rounding");
        return;
    }
    if (isnan(curve->slope)) {
        buffer_format(output, "no slope: its %d errors do not depend on the steps\n",
                      curve->fitted);
        return;
    }
    if (curve->adaptive)
        buffer_format(output, "error ~ tol^%.2f", curve->slope);
    else
        buffer_format(output, "order %.2f", curve->slope);
    buffer_format(output, " (%d points, R^2 %.4f)", curve->fitted, curve->r2);
    if (curve->differs)
        buffer_format(output, curve->adaptive ? ", NOT proportional to tol" : ", but %g is claimed",
                      curve->expected);
    buffer_char(output, '\n');
}

/* Returns true if one of the points [first, first + count) was timed. */
static bool is_timed(const struct precision *precision, int first, int count)
{
    bool timed = false;
    for (int i = first; i < first + count; i++)
        timed |= isfinite(precision->point[i].time.minimum);
    return timed;
}

/* Returns true if some points ran specialised code and others general code, so that their times are
 * not comparable. */
static bool is_mixed(const struct precision *precision)
{
    bool mixed = false;
    for (int i = 1; i < precision->points; i++)
        mixed |= precision->point[i].path != precision->point[0].path;
    return mixed;
}

/* Writes one table of points per method, or only that of the method `only`. */
void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *output)
{
    const struct precision_row *rows = precision_rows(precision, arena);
    for (int c = 0; rows && c < precision->curves; c++) {
        const struct precision_curve *curve = &precision->curve[c];
        if (only && curve->choice.method != only)
            continue;
        struct text_table table = {.arena = arena, .gap = 2, .indent = 2, .max = width};
        buffer_format(output, "%c  %s", precision_letter(c), curve->choice.method->row.name);
        if (curve->choice.drag != DRAG_DEFAULT && precision->system.velocity)
            buffer_format(output, " drag=%s", contender_drag(&curve->choice));
        if (is_timed(precision, curve->first, curve->count) && is_mixed(precision))
            buffer_format(output, " (timed by %s code)",
                          catalog_row(&kernel_catalog, precision->point[curve->first].path)->name);
        buffer_put(output, TEXT(": "));
        put_slope(curve, output);
        columns_text(&precision_columns, rows + curve->first, (size_t)curve->count,
                     width >= WIDE_TABLE_CELLS, &table);
        text_table_put(&table, output);
        if (curve->cut)
            buffer_put(output, TEXT("  stopped early: its share of the time was used up\n"));
    }
}

/* Writes one line per method: its letter, name, number of settings and slope. */
void precision_overview(const struct precision *precision, struct buffer *output)
{
    for (int c = 0; c < precision->curves; c++) {
        const struct precision_curve *curve = &precision->curve[c];
        buffer_format(output, "%c  %s, %d settings: ", precision_letter(c),
                      curve->choice.method->row.name, curve->count);
        put_slope(curve, output);
    }
}

/* Writes the letters of all curves with their methods, as in "a euler b verlet". */
void precision_legend(const struct precision *precision, int width, struct buffer *output)
{
    int used = 0;
    for (int c = 0; c < precision->curves; c++) {
        const char *name = precision->curve[c].choice.method->row.name;
        const int more = text_width(text_of(name)) + 4;
        if (used > 0 && used + more > width) {
            buffer_char(output, '\n');
            used = 0;
        }
        buffer_format(output, "%s%c %s", used ? "  " : "", precision_letter(c), name);
        used += more;
    }
    buffer_char(output, '\n');
}

/* ---- what is fastest ---- */

#define PRECISION_LEVELS 13 /* errors of tables and records: 1e-1 down to 1e-13 */

/* The ranking of methods for one error. */
struct fastest_row {
    double error;
    const struct precision *precision; /* study that is ranked */
    struct precision_cost *cost;       /* [curves] ranked, then others */
    /* numbers of ranked curves, of curves that follow them unranked, and of the best ranked ones
     * that tie, at least 1 */
    int ranked, others, tied;
    int width; /* width for the names of tied methods [cell] */
};

/* Returns the name of the method at index i of the ranking. */
static const char *precision_name_of(const struct fastest_row *row, int i)
{
    return row->precision->curve[row->cost[i].curve].choice.method->row.name;
}

static const char *best_of(const void *row)
{
    return precision_name_of(row, 0);
}

/* Returns the time of the fastest method [s], or NAN if nothing was timed. */
static double time_of(const void *row)
{
    return ((const struct fastest_row *)row)->cost->minimum;
}

/* Adds the names of the methods that tie with the best, without the best, as an array of that
 * key. */
static void put_tied(struct reply *reply, const char *key, const void *row_data)
{
    const struct fastest_row *row = row_data;
    reply_array(reply, key);
    for (int i = 1; i < row->tied; i++)
        reply_string(reply, NULL, precision_name_of(row, i));
    reply_close(reply);
}

/* Returns the name of the best method that does not tie with the fastest, or NULL if all tie. */
static const char *next_of(const void *row_data)
{
    const struct fastest_row *row = row_data;
    return row->tied < row->ranked ? precision_name_of(row, row->tied) : NULL;
}

/* Returns how many times as long that method takes as the fastest, or how many times as many
 * evaluations it needs if nothing was timed; NAN if all tie. */
static double next_times(const void *row_data)
{
    const struct fastest_row *row = row_data;
    const struct precision_cost *best = row->cost, *next = row->cost + row->tied;
    if (row->tied == row->ranked)
        return NAN;
    return isnan(best->minimum) ? next->evals / best->evals : next->minimum / best->minimum;
}

/* Writes an error that is a power of ten, as in 1e-6. */
static void error_cell(struct text_table *table, double error)
{
    char text[16];
    snprintf(text, sizeof text, "1e%.0f", log10(error));
    cell_text(table, text);
}

static const char *best_head(const void *row)
{
    return isnan(time_of(row)) ? "fewest evaluations" : "fastest";
}

/* Writes the names of the tied methods, as many as the width holds, and the number of evaluations
 * if nothing was timed. */
static void best_cell(struct text_table *table, const void *row_data)
{
    const struct fastest_row *row = row_data;
    struct buffer text = {0};
    int shown = 0, used = 0;
    for (; shown < row->tied; shown++) {
        used += text_width(text_of(precision_name_of(row, shown))) + 5;
        if (shown > 0 && used > row->width)
            break;
        buffer_format(&text, "%s%c %s", shown ? " = " : "",
                      precision_letter(row->cost[shown].curve), precision_name_of(row, shown));
    }
    if (shown < row->tied)
        buffer_format(&text, " = %d more", row->tied - shown);
    if (isnan(row->cost->minimum))
        buffer_format(&text, " (%.3g)", row->cost->evals);
    cell_take(table, &text);
}

/* Writes the next method and its ratio to the fastest, as in "verlet x 1.3". */
static void next_cell(struct text_table *table, const void *row)
{
    struct buffer text = {0};
    if (next_of(row))
        buffer_format(&text, "%s x %.2g", next_of(row), next_times(row));
    cell_take(table, &text);
}

/* Writes the method with the fewest evaluations, ranked by time or not, and that number. */
static void fewest_cell(struct text_table *table, const void *row_data)
{
    const struct fastest_row *row = row_data;
    struct buffer text = {0};
    int best = 0;
    for (int i = 1; i < row->ranked + row->others; i++)
        best = row->cost[i].evals < row->cost[best].evals ? i : best;
    buffer_format(&text, "%s (%.3g)", precision_name_of(row, best), row->cost[best].evals);
    cell_take(table, &text);
}

static bool is_row_timed(const void *row)
{
    return isfinite(time_of(row));
}

static bool has_room_for_next(const void *row)
{
    enum { BEST_CELLS = 10 /* room of the names of those that tie */ };
    return ((const struct fastest_row *)row)->width >= BEST_CELLS;
}

/* clang-format off */
static const struct result_column of_fastest[] = {
    {.name = "error", .offset = offsetof(struct fastest_row, error),
     .index = 1, .heading = "error", .look = error_cell},
    {.name = "method", .kind = COLUMN_NAME, .text = best_of,
     .index = 2, .head = best_head, .cell = best_cell},
    {.name = "time_min", .real = time_of,
     .index = 3, .heading = "in", .look = cell_seconds, .flags = COLUMN_IF_ANY},
    {.name = "tied_with", .record = put_tied},
    {.name = "next", .kind = COLUMN_NAME, .text = next_of,
     .index = 4, .heading = "then", .cell = next_cell, .any = has_room_for_next,
     .flags = COLUMN_IF_ANY},
    {.name = "next_times", .real = next_times},
    {.kind = COLUMN_NAME, .text = best_of, .index = 5, .heading = "fewest evaluations",
     .cell = fewest_cell, .any = is_row_timed,
     .flags = COLUMN_NO_RECORD | COLUMN_IF_ANY | COLUMN_WIDE},
};
/* clang-format on */

static const struct result_columns fastest_columns = RESULT_COLUMNS(of_fastest, struct fastest_row);

/* Ranks the methods for errors that are `step` decades apart, from 10^-step down to 1e-13. Errors
 * that no method reaches are left out. `width` is that of a line [cell]. Returns [*count] rows from
 * the arena, or NULL if out of memory. */
static struct fastest_row *fastest_rows_rank(const struct precision *precision, int step, int width,
                                             struct arena *arena, size_t *count)
{
    enum { BESIDE = 50 /* columns of a line beside the names of those that tie */ };
    struct fastest_row *row = arena_array(arena, PRECISION_LEVELS, sizeof *row);
    *count = 0;
    for (int level = step; row && level <= PRECISION_LEVELS; level += step) {
        struct fastest_row *one = &row[*count];
        *one = (struct fastest_row){
            .error = pow(10, -level),
            .precision = precision,
            .cost = arena_array(arena, (size_t)precision->curves + 1, sizeof *one->cost),
            .tied = 1,
            .width = width - BESIDE};
        if (!one->cost)
            return NULL;
        one->ranked = precision_fastest(precision, one->error, one->cost, &one->others);
        while (one->tied < one->ranked && one->cost[one->tied].tied && is_row_timed(one))
            one->tied++;
        *count += one->ranked > 0;
    }
    return row;
}

/* Lists the methods that were not ranked because they ran general code, with that reason. */
static void put_left_out(const struct precision *precision, const struct fastest_row *row,
                         size_t count, struct buffer *output)
{
    struct buffer names = {0};
    for (int c = 0; c < precision->curves; c++) {
        bool is_left_out = false;
        for (size_t i = 0; i < count; i++)
            for (int k = row[i].ranked; k < row[i].ranked + row[i].others; k++)
                is_left_out |= row[i].cost[k].curve == c && row[i].cost[k].path == KERNEL_GENERAL;
        if (is_left_out)
            buffer_format(&names, "%s%s", names.len ? ", " : "",
                          precision->curve[c].choice.method->row.name);
    }
    if (names.len)
        buffer_format(
            output,
            "  not ranked against methods with specialised code: %s, timed with general code;\n  a "
            "method with general code is named only where it is faster even so\n",
            buffer_view(&names));
    buffer_free(&names);
}

/* Writes a table with the fastest methods for errors that are `step` decades apart. */
void precision_winners(const struct precision *precision, int step, bool all, int width,
                       struct arena *arena, struct buffer *output)
{
    size_t count;
    struct text_table table = {.arena = arena, .gap = 2, .indent = all ? 2 : 0, .max = width};
    const struct fastest_row *row = fastest_rows_rank(precision, step, width, arena, &count);
    if (!row || count == 0)
        return;
    if (all)
        buffer_put(output, is_row_timed(row)
                               ? TEXT("fastest method for an error (= marks methods "
                                      "whose times [minimum, median] overlap)\n")
                               : TEXT("method with the fewest evaluations for an error\n"));
    columns_text(&fastest_columns, row, count, all, &table);
    text_table_put(&table, output);
    if (all)
        put_left_out(precision, row, count, output);
}

/* Adds the records of all points and of the fastest methods to the reply, and stores the points. */
void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply)
{
    const struct precision_row *points = precision_rows(precision, arena);
    struct buffer reference = {0};
    size_t count;
    const struct fastest_row *row = fastest_rows_rank(precision, 1, 0, arena, &count);
    if (!points || !row)
        return;
    reference_describe(&precision->reference, &reference);
    reply_result(session, reply, "precision", &precision_columns, points, (size_t)precision->points,
                 NULL, buffer_view(&reference));
    buffer_free(&reference);
    reply_records(reply, "precision", &precision_columns, points, (size_t)precision->points);
    if (count > 0 && is_row_timed(row))
        reply_records(reply, "fastest", &fastest_columns, row, count);
}
