/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study in text: tables, what is fastest, what was predicted. */
#include <hooke/report.h>

#include <math.h>
#include <string.h>

#define WIDE 110 /* [cell] from here on end, phase and amplitude errors are shown, too */

/* ---- a method ---- */

static void put_slope(const struct precision_curve *curve, struct buffer *out)
{
    if (curve->fitted == 0) {
        buffer_format(out, "no slope: %s\n",
                      isnan(curve->expected) ? "it makes no error of its own"
                                             : "fewer than 3 errors between 5 % and rounding");
        return;
    }
    if (isnan(curve->slope)) {
        buffer_format(out, "no slope: its %d errors are all the same, whatever the steps\n",
                      curve->fitted);
        return;
    }
    if (curve->adaptive)
        buffer_format(out, "error ~ tol^%.2f", curve->slope);
    else
        buffer_format(out, "order %.2f", curve->slope);
    buffer_format(out, " (%d points, R^2 %.4f)", curve->fitted, curve->r2);
    if (curve->differs)
        buffer_format(out, curve->adaptive ? ", NOT proportional to tol" : ", but %g is claimed",
                      curve->expected);
    buffer_char(out, '\n');
}

static bool is_timed(const struct precision *precision, int first, int count)
{
    bool timed = false;
    for (int i = first; i < first + count; i++)
        timed |= isfinite(precision->point[i].time.minimum);
    return timed;
}

/* Are some points timed by other code than the rest? */
static bool is_mixed(const struct precision *precision)
{
    bool mixed = false;
    for (int i = 1; i < precision->points; i++)
        mixed |= precision->point[i].path != precision->point[0].path;
    return mixed;
}

void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *out)
{
    const struct precision_row *rows = precision_rows(precision, arena);
    for (int c = 0; rows && c < precision->curves; c++) {
        const struct precision_curve *curve = &precision->curve[c];
        if (only && curve->by.method != only)
            continue;
        struct text_table table = {.arena = arena, .gap = 2, .indent = 2, .max = width};
        buffer_format(out, "%c  %s", precision_letter(c), curve->by.method->row.name);
        if (curve->by.drag != DRAG_DEFAULT && precision->system.velocity)
            buffer_format(out, " drag=%s",
                          catalog_row(&drag_catalog, (size_t)curve->by.drag - 1)->name);
        if (is_timed(precision, curve->first, curve->count) && is_mixed(precision))
            buffer_format(out, " (timed by %s code)",
                          path_name(precision->point[curve->first].path));
        buffer_put(out, TEXT(": "));
        put_slope(curve, out);
        columns_text(&precision_columns, rows + curve->first, (size_t)curve->count, width >= WIDE,
                     &table);
        text_table_put(&table, out);
        if (curve->cut)
            buffer_put(out, TEXT("  not swept further: its share of the time was used up\n"));
    }
}

void precision_overview(const struct precision *precision, struct buffer *out)
{
    for (int c = 0; c < precision->curves; c++) {
        const struct precision_curve *curve = &precision->curve[c];
        buffer_format(out, "%c  %s, %d settings: ", precision_letter(c), curve->by.method->row.name,
                      curve->count);
        put_slope(curve, out);
    }
}

void precision_legend(const struct precision *precision, int width, struct buffer *out)
{
    int used = 0;
    for (int c = 0; c < precision->curves; c++) {
        const char *name = precision->curve[c].by.method->row.name;
        const int more = text_width(text_of(name)) + 4;
        if (used > 0 && used + more > width) {
            buffer_char(out, '\n');
            used = 0;
        }
        buffer_format(out, "%s%c %s", used ? "  " : "", precision_letter(c), name);
        used += more;
    }
    buffer_char(out, '\n');
}

/* ---- what is fastest ---- */

static const char *name_of(const struct precision *precision, const struct precision_cost *cost)
{
    return precision->curve[cost->curve].by.method->row.name;
}

/* The fastest with those that tie, its time, and the next. */
static void winner_cells(const struct precision *precision, const struct precision_cost *cost,
                         int count, struct text_table *table)
{
    struct buffer best = {0}, next = {0};
    int index = 0;
    for (; index < count && (index == 0 || cost[index].tied); index++)
        buffer_format(&best, "%s%s", index ? " = " : "", name_of(precision, &cost[index]));
    cell_take(table, &best);
    cell_seconds(table, cost->minimum);
    if (index < count)
        buffer_format(&next, "%s x %.2g", name_of(precision, &cost[index]),
                      cost[index].minimum / cost->minimum);
    cell_take(table, &next);
}

static void fewest_cell(const struct precision *precision, const struct precision_cost *cost,
                        int count, struct text_table *table)
{
    const struct precision_cost *best = cost;
    for (int i = 1; i < count; i++)
        if (cost[i].evals < best->evals)
            best = &cost[i];
    struct buffer text = {0};
    buffer_format(&text, "%s (%.3g)", name_of(precision, best), best->evals);
    cell_take(table, &text);
}

/* Which methods were left out of a row, and why. */
static void put_left_out(const struct precision *precision, const bool *left_out,
                         struct buffer *out)
{
    struct buffer names = {0};
    for (int c = 0; c < precision->curves; c++)
        if (left_out[c])
            buffer_format(&names, "%s%s", names.len ? ", " : "",
                          precision->curve[c].by.method->row.name);
    if (names.len)
        buffer_format(out,
                      "  not ranked after methods that have specialised code: %s, timed by the "
                      "general code,\n"
                      "  whose times do not compare; only where the general code is ahead all the "
                      "same is it named\n",
                      buffer_view(&names));
    buffer_free(&names);
}

static void put_fastest(const struct precision *precision, struct arena *arena, struct buffer *out)
{
    const bool timed = is_timed(precision, 0, precision->points);
    struct text_table table = {.arena = arena, .columns = timed ? 5 : 2, .gap = 2, .indent = 2};
    struct precision_cost *cost = arena_array(arena, (size_t)precision->curves + 1, sizeof *cost);
    bool *left_out = arena_array(arena, (size_t)precision->curves + 1, sizeof *left_out);
    if (!cost || !left_out)
        return;
    static const char *const heading[] = {"error", "fastest", "in", "then", "fewest evaluations"};
    for (size_t i = 0; i < COUNT_OF(heading); i++)
        if (timed || i == 0 || i + 1 == COUNT_OF(heading))
            cell_text(&table, heading[i]);
    for (int level = 1; level <= LEVELS; level++) {
        int others = 0;
        const int count = precision_fastest(precision, pow(10, -level), cost, &others);
        for (int i = count; i < count + others; i++)
            left_out[cost[i].curve] = true;
        if (count == 0)
            continue;
        struct buffer name = {0};
        buffer_format(&name, "1e-%d", level);
        cell_take(&table, &name);
        if (timed)
            winner_cells(precision, cost, count, &table);
        fewest_cell(precision, cost, count + others, &table);
    }
    if (table.cells == table.columns)
        return;
    buffer_put(
        out, timed ? TEXT("fastest method for an error (= : the times [minimum, median] overlap)\n")
                   : TEXT("cheapest method for an error\n"));
    text_table_put(&table, out);
    put_left_out(precision, left_out, out);
}

/* Names of those that tie, as many as the width holds. */
static void put_tied(const struct precision *precision, const struct precision_cost *cost, int tied,
                     int width, struct buffer *out)
{
    int shown = 0, used = 0;
    for (; shown < tied; shown++) {
        const char *name = name_of(precision, &cost[shown]);
        used += text_width(text_of(name)) + 3;
        if (shown > 0 && used > width)
            break;
        buffer_format(out, "%s%s", shown ? " = " : "", name);
    }
    if (shown < tied)
        buffer_format(out, " = %d more", tied - shown);
}

void precision_winners(const struct precision *precision, int width, struct arena *arena,
                       struct buffer *out)
{
    /* decades between two errors; columns of a line beside the names of those that tie */
    enum { STEP = 3, BESIDE = 50 };
    struct text_table table = {.arena = arena, .columns = 4, .gap = 2, .max = width};
    struct precision_cost *cost = arena_array(arena, (size_t)precision->curves + 1, sizeof *cost);
    const bool timed = is_timed(precision, 0, precision->points);
    static const char *const heading[2][4] = {{"error", "fewest evaluations", "", "then"},
                                              {"error", "fastest", "in", "then"}};
    for (int i = 0; i < 4; i++)
        cell_text(&table, heading[timed][i]);
    for (int level = STEP; cost && level <= LEVELS; level += STEP) {
        struct buffer name = {0}, best = {0}, value = {0}, next = {0};
        int others = 0, tied = 1;
        const int count = precision_fastest(precision, pow(10, -level), cost, &others);
        if (count == 0)
            continue;
        while (tied < count && cost[tied].tied && timed)
            tied++;
        buffer_format(&name, "1e-%d", level);
        put_tied(precision, cost, tied, width - BESIDE, &best);
        if (!timed)
            buffer_format(&value, "%.3g", cost->evals);
        if (tied < count)
            buffer_format(&next, "%s x %.2g", name_of(precision, &cost[tied]),
                          timed ? cost[tied].minimum / cost->minimum
                                : cost[tied].evals / cost->evals);
        cell_take(&table, &name);
        cell_take(&table, &best);
        if (timed)
            cell_seconds(&table, cost->minimum);
        else
            cell_take(&table, &value);
        cell_take(&table, &next);
        buffer_free(&value);
    }
    if (table.cells > table.columns)
        text_table_put(&table, out);
}

/* ---- predicted against measured ---- */

static void put_predictions(const struct precision *precision, struct arena *arena,
                            struct buffer *out)
{
    static const int levels[] = {2, 4, 6, 8, 10};
    struct text_table table = {
        .arena = arena, .columns = 1 + (int)COUNT_OF(levels), .gap = 2, .indent = 2};
    if (!precision_predicts(&precision->system))
        return;
    cell_text(&table, "method");
    for (size_t i = 0; i < COUNT_OF(levels); i++) {
        struct buffer name = {0};
        buffer_format(&name, "1e-%d", levels[i]);
        cell_take(&table, &name);
    }
    for (int c = 0; c < precision->curves; c++) {
        if (isnan(precision_predict(precision, c, 1e-2)))
            continue;
        cell_text(&table, precision->curve[c].by.method->row.name);
        for (size_t i = 0; i < COUNT_OF(levels); i++) {
            const double error = pow(10, -levels[i]);
            struct precision_cost cost;
            struct buffer text = {0};
            buffer_format(&text, "%.3g", precision_predict(precision, c, error));
            if (precision_cost_at(precision, c, error, &cost))
                buffer_format(&text, "/%.3g", cost.evals);
            cell_take(&table, &text);
        }
    }
    if (table.cells == table.columns)
        return;
    buffer_put(
        out, TEXT("evaluations for an error: predicted from the amplification matrix/measured\n"));
    text_table_put(&table, out);
}

void precision_summary(const struct precision *precision, struct arena *arena, struct buffer *out)
{
    put_fastest(precision, arena, out);
    put_predictions(precision, arena, out);
}
