/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where the text of a table goes. */
#ifndef HOOKE_RESULT_OUTLET_H
#define HOOKE_RESULT_OUTLET_H

#include <hooke/result.h>

#define OUTLET_CHUNK 65536u /* [byte] */

struct outlet {
    struct buffer *text;
    struct writer *writer; /* NULL: everything stays in `text` */
};

#define OUTLET_ROWS 4096 /* between two looks; fewer are written whatever happens */

/* Before a row. False: the writing is ended, and the text fails. */
static inline bool outlet_goes_on(struct outlet *sink, const struct table *table, size_t row)
{
    if (row % OUTLET_ROWS == OUTLET_ROWS - 1 && cancelled(table->cancel))
        sink->text->failed = true;
    return !sink->text->failed;
}

/* What is more than `max` bytes goes on to the writer, all of it. */
void outlet_pass(struct outlet *sink, size_t max);
/* Markdown, HTML, LaTeX (table_markup.c). */
void table_put_markup(const struct table *table, enum table_format format, struct outlet *sink);

/* What a spreadsheet would run, also behind the ' that keeps it from that. */
bool cell_is_formula(struct text cell);
/* What could be markup as text; of a document, too. */
void buffer_html(struct buffer *out, struct text text);
#endif
