/* SPDX-License-Identifier: GPL-3.0-or-later */
/* outlet: the destination of a table's text, for functions of type table_format
 * (<hooke/result/table.h>). For each row they call outlet_goes_on(), append the row to outlet->text
 * and call outlet_pass(), so that a large table is written in pieces of
 * OUTLET_CHUNK bytes. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/result.h>

struct writer;

#define OUTLET_CHUNK 65536u /* Size [byte] of the pieces in which a table is written. */

/* Destination of a table's text; does not own buffer and writer. */
struct outlet {
    /* Text that has not been passed to the writer. */
    struct buffer *text;
    /* File that receives the text, or NULL if all of it remains in `text`. */
    struct writer *writer;
};

#define OUTLET_ROWS 4096 /* Number of rows between two calls of cancelled(). */

/* Returns true if row number `row` is to be written. Returns false, with sink->text->failed, if
 * table->cancel was set or if memory ran out. Call it before each row. */
static inline bool outlet_goes_on(struct outlet *sink, const struct table *table, size_t row)
{
    if (row % OUTLET_ROWS == OUTLET_ROWS - 1 && cancelled(table->cancel))
        sink->text->failed = true;
    return !sink->text->failed;
}

/* Moves all of sink->text to the writer, if there is a writer and the text is longer than `max`
 * bytes. */
void outlet_pass(struct outlet *sink, size_t max);
/* Returns true if a spreadsheet would execute the cell as a formula, also after leading
 * apostrophes. */
bool cell_is_formula(struct text cell);
/* Appends a cell of CSV or TSV, in quotes if `quoted` or if it contains the separator, a quote or a
 * line end. */
void buffer_cell(struct buffer *output, struct text cell, char separator, bool quoted);
