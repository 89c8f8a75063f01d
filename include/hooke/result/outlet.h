/* SPDX-License-Identifier: GPL-3.0-or-later */
/* result: where the text of a table goes, for functions that write one. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/result.h>

struct writer;

#define OUTLET_CHUNK 65536u /* [byte] */

struct outlet {
    struct buffer *text;
    struct writer *writer; /* NULL if everything stays in `text` */
};

#define OUTLET_ROWS 4096 /* rows from one look at the cancel flag to the next */

/* Looks at the cancel flag; called before each row. Returns false if writing has ended, in which
 * case the text fails. */
static inline bool outlet_goes_on(struct outlet *sink, const struct table *table, size_t row)
{
    if (row % OUTLET_ROWS == OUTLET_ROWS - 1 && cancelled(table->cancel))
        sink->text->failed = true;
    return !sink->text->failed;
}

/* Passes the text on to the writer, all of it, if it is longer than `max` bytes. */
void outlet_pass(struct outlet *sink, size_t max);
/* Returns true if a spreadsheet would run the cell, or would run it without its leading '. */
bool cell_is_formula(struct text cell);
/* Appends a cell of CSV or TSV: in quotes if wanted, or if it holds a separator, a quote or a line
 * end. */
void buffer_cell(struct buffer *output, struct text cell, char separator, bool quoted);
