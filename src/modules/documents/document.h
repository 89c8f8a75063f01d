/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Markup of documents and tables in HTML and LaTeX. */
#pragma once

#include "modules/documents/documents.h"

/* Replacement for a character that could be markup. */
struct sign {
    char c;
    const char *as;
};
void buffer_replaced(struct buffer *output, struct text text, const struct sign *signs,
                     size_t count);
/* Append text in which characters that could be markup are escaped. */
void buffer_html(struct buffer *output, struct text text);
void buffer_markdown(struct buffer *output, struct text text);
/* The same in LaTeX; letters that pdflatex does not know stay. */
void buffer_latex(struct buffer *output, struct text text);
/* Texts from templates.txt. They are the style of an HTML document, the beginning of an HTML table,
 * and that of a LaTeX document up to \begin{document}. */
extern const char document_style[], document_table[], document_preamble[];

/* Nothing in it is a command; letters that pdflatex does not know become a question mark. */
void buffer_tex(struct buffer *output, struct text text);
/* Puts the beginning of a table of so many columns before the heading that stands at `begin`.
 * Returns false if out of memory. */
bool begin_longtable(struct buffer *output, size_t begin, int columns);
void put_tex_code(struct buffer *output, struct text code); /* line by line */
