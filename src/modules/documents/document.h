/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Markup that documents and tables share: escaping, and parts of LaTeX. */
#pragma once

#include "modules/documents/documents.h"

/* Replacement for a character that could be markup. */
struct sign {
    char c;
    const char *as;
};
/* Appends text in which each of the `count` signs is replaced. */
void buffer_replaced(struct buffer *output, struct text text, const struct sign *signs,
                     size_t count);
/* Append text in which characters that could be markup are escaped. */
void buffer_html(struct buffer *output, struct text text);
void buffer_markdown(struct buffer *output, struct text text);
/* Appends text escaped for LaTeX; letters that pdflatex does not know are unchanged. */
void buffer_latex(struct buffer *output, struct text text);
/* Texts from templates.txt. They are the style of an HTML document, the beginning of an HTML table,
 * and that of a LaTeX document up to \begin{document}. */
extern const char document_style[], document_table[], document_preamble[];

/* Appends text escaped for LaTeX, with a question mark for letters that pdflatex does not know. */
void buffer_tex(struct buffer *output, struct text text);
/* Inserts the beginning of a table of `columns` columns before its heading, which begins at offset
 * `begin` of the output. Returns false if out of memory. */
bool begin_longtable(struct buffer *output, size_t begin, int columns);
/* Appends preformatted text in LaTeX, line by line. */
void put_tex_code(struct buffer *output, struct text code);
