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

/* What is more than `max` bytes goes on to the writer, all of it. */
void outlet_pass(struct outlet *sink, size_t max);
/* Markdown, HTML, LaTeX (table_markup.c). */
void table_put_markup(const struct table *table, enum table_format format, struct outlet *sink);

/* What a spreadsheet would run, also behind the ' that keeps it from that. */
bool cell_is_formula(struct text cell);
/* What could be markup as text; of a document, too. */
void buffer_html(struct buffer *out, struct text text);
#endif
