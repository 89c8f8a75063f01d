/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The band of an adopted fit as two columns (low, high) beside each variable of its run in an
 * exported table. */
#include "modules/recording/known/known.h"
#include "modules/recording/plots.h"

#include <stdio.h>

/* Returns the run of the table, or NULL if there are several. */
static const struct run *only_run(const struct session *session, const struct argument_value *runs)
{
    if (runs->count == 0)
        return session_run(session);
    if (runs->count == 1 && runs->item[0].index >= 0)
        return session->runs.slot[runs->item[0].index]->run;
    return session->runs.count == 1 ? session->runs.slot[0]->run : NULL;
}

/* Returns a column with one edge of the band; its name or value is NULL if out of memory. */
static struct table_column side_of(const struct table_column *column, const char *side,
                                   const double *half, double sign, size_t rows,
                                   struct arena *arena)
{
    char name[LIMIT_NAME + 8];
    double *value = arena_array(arena, rows, sizeof *value);
    snprintf(name, sizeof name, "%s_%s", column->name, side);
    for (size_t i = 0; value && i < rows; i++)
        value[i] = column->value[i] + sign * half[i];
    return (struct table_column){
        .name = arena_text(arena, text_of(name)), .unit = column->unit, .value = value};
}

/* Inserts two columns, the lower and upper edge of the uncertainty band, after each column of a
 * state variable in export->table. `runs` must be one run of an adopted fit; `where` is the text of
 * --band for messages. Returns false with *error if there is no such run or column, or the band
 * cannot be computed. */
bool export_band(const struct session *session, const struct argument_value *runs,
                 struct text where, struct export *export, struct error *error)
{
    const struct run *run = only_run(session, runs);
    struct arena *arena = export->arena;
    const struct table *table = &export->table;
    if (!run)
        return error_at(error, where, "--band needs one run that follows 'adopt'");
    if (!band_of_run(session, run, where, error))
        return false;
    struct table_column *result = arena_array(arena, 3 * (size_t)table->columns, sizeof *result);
    double *half = arena_array(arena, table->rows + 1, sizeof *half);
    if (!result || !half)
        return error_memory(error);
    int columns = 0, banded = 0;
    for (int c = 0; c < table->columns; c++) {
        const struct table_column *column = &table->column[c];
        const int variable = model_variable(run->system.model, text_of(column->name));
        result[columns++] = *column;
        if (variable < 0 || variable >= run->system.n)
            continue;
        if (!band_half(session, run, variable, table->column[0].value, table->rows, arena, half,
                       error))
            return false;
        result[columns++] = side_of(column, "low", half, -1, table->rows, arena);
        result[columns++] = side_of(column, "high", half, 1, table->rows, arena);
        if (!result[columns - 1].name || !result[columns - 1].value || !result[columns - 2].value)
            return error_memory(error);
        banded++;
    }
    export->table.column = result;
    export->table.columns = columns;
    return banded > 0 ||
           error_at(error, where,
                    "--band needs a column that is a state variable; none of these is");
}
