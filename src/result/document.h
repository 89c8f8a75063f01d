/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What documents are in LaTeX. */
#ifndef HOOKE_RESULT_DOCUMENT_H
#define HOOKE_RESULT_DOCUMENT_H

#include <hooke/result.h>

extern const char preamble[]; /* to \begin{document} */

/* Nothing in it is a command; letters that pdflatex does not know become a question mark. */
void buffer_tex(struct buffer *out, struct text text);
/* Puts the beginning of a table of so many columns before the heading that stands at `from`. False:
 * no memory. */
bool begin_longtable(struct buffer *out, size_t from, int columns);
void put_tex_code(struct buffer *out, struct text code); /* line by line */

#endif
