/* SPDX-License-Identifier: GPL-3.0-or-later */
/* table: tables of columns (struct table), their text in CSV, TSV and JSON, and the last table of
 * each kind of result (struct table_store). */
#pragma once

#include <hooke/base/error.h>

struct cancel;
struct write_policy; /* hooke/base/file.h */
struct writer;

/* ---- tables ---- */

/* A column of numbers or of texts; the table's creator owns all that it points to. */
struct table_column {
    /* Name, and unit or "". */
    const char *name, *unit;
    const double *value; /* [rows] numbers, NAN for a missing one; NULL for a column of texts. */
    /* [rows] texts, if `value` is NULL. */
    const char *const *text;
    /* The column is left out of documents (.md, .html, .tex), because it is meant for programs. */
    bool detail;
};

/* A fact about the whole table, written above it. */
struct table_key {
    const char *key, *value; /* Name and value, such as "dt" and "10 ms". */
};

/* A table. All pointers belong to its creator, often an arena. */
struct table {
    /* [keys] facts about the table, written as lines `# key = value`, or as an object in JSON. */
    const struct table_key *key;
    int keys;
    /* [columns] columns, each with `rows` cells. */
    const struct table_column *column;
    int columns;
    size_t rows;
    const struct cancel *cancel; /* Flag that stops writing the table, or NULL. */
    int digits; /* Significant digits of numbers other than integers in documents; 0 shows all. */
};

/* Returns the column of this name, or NULL if there is none or if name is NULL. */
const struct table_column *table_column_named(const struct table *table, const char *name);

struct outlet; /* <hooke/result/outlet.h> */
/* Writes a table as text to an outlet. Every double reads back with the same bits; the decimal
 * point is `.` and lines end with a newline in every locale. Texts that a spreadsheet could execute
 * as a formula are quoted and preceded by an apostrophe. */
typedef void table_format(const struct table *table, struct outlet *outlet);
table_format table_csv, table_tsv, table_json; /* Modules define further formats. */
/* Appends a table to `output`. Sets output->failed if out of memory or if table->cancel was set. */
void table_put(const struct table *table, table_format *format, struct buffer *output);
/* Writes a table to a new file. Returns false with `error` set, also if table->cancel was set. */
bool table_write(const struct table *table, table_format *format, const char *path,
                 struct write_policy policy, struct error *error);
/* Writes a table to an open file and commits it. Returns false, with `error` set and the file
 * abandoned, on failure; the writer is closed in every case. */
bool table_send(const struct table *table, table_format *format, struct writer *writer,
                struct error *error);
/* Returns true if the text begins like a table with keys that table_write() wrote as CSV, TSV or
 * JSON. */
bool table_recognise(struct text text);
/* Reads such a text into *table, with the same doubles and texts; memory is the arena's. Returns
 * false, with `error` set to ERROR_IO if the text is damaged, or to ERROR_CANCELLED if `cancel` was
 * set. Also sets table->cancel to `cancel`. */
bool table_parse(struct text text, const struct cancel *cancel, struct arena *arena,
                 struct table *table, struct error *error);
void buffer_json_text(struct buffer *output,
                      struct text text); /* Appends a text as a JSON string in valid UTF-8. */
/* Appends a number as JSON, null if it is not finite. */
void buffer_json_real(struct buffer *output, double value);

/*
 * ---- tables by kind: the last result of each kind, such as "compare" or "sweep" ----
 *
 * Records become rows of such tables, and fields become columns. The column of a field in nested
 * objects and arrays has the path of the field as its name, such as "halves.gamma.1". An element of
 * an array appears in the path by its number or, if it is an object whose first field is "name", by
 * the value of that field.
 */

struct column_growth; /* Columns of a table while records are added to it; private. */

/* The last table of one kind; owns its memory. */
struct stored_table {
    const char *kind;   /* Kind, such as "compare"; in the arena or a constant. */
    struct arena arena; /* Owner of the memory of `table`. */
    struct table table;
    /* State of a table to which records are still added; NULL if it is complete. */
    struct column_growth *growth;
};

/* Tables by kind; zero-initialise it, and end with table_store_free(). */
struct table_store {
    struct stored_table **table; /* [count] tables, owned. */
    int count;
    struct stored_table *row; /* Table to which the current record is added; private. */
};

/* Frees all tables. */
void table_store_free(struct table_store *store);
/* Returns the table of this kind, or NULL if there is none. */
struct stored_table *table_store_find(const struct table_store *store, struct text kind);
/* Stores a complete table in place of the one of the same kind and takes over its arena, which is
 * then empty. Returns false, with nothing changed, if out of memory. */
bool table_store_put(struct table_store *store, const char *kind, struct arena *arena,
                     const struct table *table);
/* Completes the tables of `source` and moves those for which wanted() returns true to `store`, in
 * place of those of the same kind; frees the others and empties `source`. `context` is the first
 * argument of wanted(), which may add keys to a table. If out of memory, tables are dropped. */
void table_store_take(struct table_store *store, struct table_store *source,
                      bool (*wanted)(void *context, struct stored_table *stored), void *context);
/* Add a record as a row to the table of its kind: store_row_begin(), a call of store_cell_…() for
 * each field, store_row_end(). store_cell_none() adds a missing value. The functions reply_…() call
 * them. A table for which memory ran out is dropped by table_store_take(). */
void store_row_begin(struct table_store *store, const char *kind);
void store_cell_none(struct table_store *store, const char *name);
void store_cell_real(struct table_store *store, const char *name, const char *unit, double value);
void store_cell_text(struct table_store *store, const char *name, const char *text);
void store_row_end(struct table_store *store);
