/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A document written twice at once, as Markdown (CommonMark with tables) and as HTML5. Own words are escaped; what came
 * from users or files (names, notes, paths) goes through document_name() and can become nothing but code.
 */
#ifndef HOOKE_COMMAND_DOCUMENT_H
#define HOOKE_COMMAND_DOCUMENT_H

#include "internal.h"

enum block {
    BLOCK_TITLE,
    BLOCK_PART,
    BLOCK_SECTION,
    BLOCK_QUESTION,
    BLOCK_TOGETHER, /* on one page, where there are pages */
    BLOCK_PARAGRAPH,
    BLOCK_LIST, /* of items */
    BLOCK_ITEM,
    BLOCK_TABLE, /* of rows: the heading first, closed by document_heading_ends() */
    BLOCK_ROW,
    BLOCK_CELL,
    BLOCK_HEAD, /* a cell of the heading */
};

struct document {
    struct buffer md, html;
    int heads;     /* cells of the heading under construction */
    bool in_table; /* where a bar ends a cell */
};

void document_begin(struct document *document, const char *title);
void document_end(struct document *document);
void document_free(struct document *document);
void document_open(struct document *document, enum block block);
void document_close(struct document *document, enum block block);
/* Own words; "+-" becomes the sign. */
void document_say(struct document *document, const char *format, ...) PRINTF_LIKE(2, 3);
void document_name(struct document *document, struct text name);
void document_link(struct document *document, const char *file, const char *words);
/* A block of own words. */
void document_put(struct document *document, enum block block, const char *words);
void document_heading_ends(struct document *document);
/* A picture from a file, NULL: there is none, the text stands for it. */
void document_figure(struct document *document, const char *picture, const char *alternative, struct text text);
void document_code(struct document *document, struct text code);
void document_answer(struct document *document); /* an empty place */

#endif
