/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Interface of the module documents: tables and documents as Markdown, HTML and LaTeX. A document
 * is begun, filled with blocks, ended and freed; its texts are in md, html and tex. */
#pragma once

#include <hooke/result.h>

/* Write a table as a file that ends in .md, .html or .tex. */
table_format documents_markdown, documents_html, documents_latex;

/* Appends a value with its unit for siunitx: "15.100 +- 0.008 N/m" becomes \\SI{15.100 +-
 * 0.008}{\\newton\\per\\metre}. */
void buffer_siunitx(struct buffer *output, struct text measured);

/* ---- documents ----
 *
 * A document written three times at once, as Markdown (CommonMark with tables), as HTML5 that loads
 * nothing from outside, and as LaTeX (pdflatex with siunitx, version 2 or 3). Own words are
 * escaped; what came from users or files (names, notes, paths) goes through document_name() and can
 * become nothing but code.
 */

/* Kinds of blocks of a document. */
enum block {
    BLOCK_TITLE,
    BLOCK_PART,
    BLOCK_SECTION,
    BLOCK_QUESTION,
    BLOCK_TOGETHER, /* its content is not divided between pages */
    BLOCK_PARAGRAPH,
    BLOCK_LIST, /* contains items */
    BLOCK_ITEM,
    BLOCK_TABLE, /* contains rows: the heading first, closed by document_heading_ends() */
    BLOCK_ROW,
    BLOCK_CELL,
    BLOCK_HEAD, /* a cell of the heading */
};

/* A document that is being written. */
struct document {
    struct buffer md, html, tex;
    size_t table;  /* offset at which the LaTeX table began */
    int heads;     /* cells of the heading under construction */
    int cells;     /* cells of the row under construction */
    bool in_table; /* inside a table, where a bar ends a cell */
};

/* Writes the beginning of a document with its title. Failures are in the buffers. */
void document_begin(struct document *document, const char *title);
/* Writes the end of a document. */
void document_end(struct document *document);
void document_free(struct document *document);
/* Opens a block; blocks nest as their comments tell. */
void document_open(struct document *document, enum block block);
/* Closes the block opened last. */
void document_close(struct document *document, enum block block);
/* Writes words of the program, escaped; "+-" becomes the sign. */
void document_say(struct document *document, const char *format, ...) PRINTF_LIKE(2, 3);
/* Writes a value with its unit, as buffer_measured() does; LaTeX uses siunitx. */
void document_measured(struct document *document, struct measured value, enum quantity quantity,
                       int digits);
/* Writes a name that a user has chosen, as code. */
void document_name(struct document *document, struct text name);
/* Writes a link to a file; LaTeX shows only the words. */
void document_link(struct document *document, const char *file, const char *words);
/* Writes a block of words of the program. */
void document_put(struct document *document, enum block block, const char *words);
/* Ends the heading row of a table. */
void document_heading_ends(struct document *document);
/* A figure for a document. */
struct document_picture {
    const char *name;        /* base name of its files, which end in .svg, .txt and .pdf */
    const char *alternative; /* description in words, written by the program */
    struct text svg, text;
    bool pdf; /* a PDF exists; else LaTeX gets the text */
};
/* Writes a figure: Markdown refers to its files, HTML contains it, LaTeX includes the PDF. */
void document_figure(struct document *document, const struct document_picture *picture);
/* Writes preformatted text. */
void document_code(struct document *document, struct text code);
/* Writes an empty space for an answer. */
void document_answer(struct document *document);
