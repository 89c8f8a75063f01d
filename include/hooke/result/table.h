/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables of results, their files, and the last of each kind. */
#pragma once

#include <hooke/base/error.h>

struct cancel;
struct write_policy; /* hooke/base/file.h */
struct writer;

/* ---- tables ---- */

struct table_column {
    const char *name, *unit;
    const double *value; /* [rows], or NULL and `text` */
    const char *const *text;
    bool detail; /* left out of documents; meant for programs */
};

struct table_key {
    const char *key, *value; /* "dt", "10 ms" */
};

struct table {
    const struct table_key *key; /* written as `# key = value` lines, or as an object in JSON */
    int keys;
    const struct table_column *column;
    int columns;
    size_t rows;
    const struct cancel *cancel; /* ends its writing; NULL if nobody can */
    int digits; /* that documents show of a number that is not whole; 0 shows all */
};

/* Returns the column of that name, or NULL if name is NULL or no column is called so. */
const struct table_column *table_column_named(const struct table *table, const char *name);

/* Every double reads back bit for bit; `.` and newline whatever the locale. Text cells that could
 * be a formula or contain the separator are quoted. */
struct outlet; /* hooke/result/outlet.h */
typedef void table_format(const struct table *table, struct outlet *outlet);
table_format table_csv, table_tsv, table_json; /* others are those of modules */
void table_put(const struct table *table, table_format *format, struct buffer *output);
bool table_write(const struct table *table, table_format *format, const char *path,
                 struct write_policy policy, struct error *error);
bool table_send(const struct table *table, table_format *format, struct writer *writer,
                struct error *error); /* The open file is always closed. */
/* Returns true if the text begins as a table in CSV, TSV or JSON that has keys. */
bool table_recognise(struct text text);
/* Reads such a text back, with the same doubles and texts. Fails with ERROR_IO if it is damaged.
 * The table keeps `cancel`, too. */
bool table_parse(struct text text, const struct cancel *cancel, struct arena *arena,
                 struct table *table, struct error *error);
void buffer_json_text(struct buffer *output,
                      struct text text);                    /* quoted and escaped, valid UTF-8 */
void buffer_json_real(struct buffer *output, double value); /* null where not finite */

/* ---- tables by kind ----
 *
 * The last result of each kind. Records become rows of such tables: a field is a column, those of
 * objects and arrays are called by their path, "halves.gamma.1"; of an object in an array its name
 * stands for the number, where "name" is its first field. */

struct column_growth; /* Columns of a table that grows; private. */

struct stored_table {
    const char *kind; /* "compare"; lives as long as the arena, or longer */
    struct arena arena;
    struct table table;
    struct column_growth *growth; /* NULL if the table is complete: records add nothing to it */
};

struct table_store {
    struct stored_table **table; /* [count] allocated */
    int count;
    /* the table that takes the cells of the present record; private */
    struct stored_table *row;
};

void table_store_free(struct table_store *store);
/* Returns NULL if there is none */
struct stored_table *table_store_find(const struct table_store *store, struct text kind);
/* Stores a complete table, which replaces that of the same kind, and takes over the arena that it
 * lives in. Returns false if out of memory, with nothing changed. */
bool table_store_put(struct table_store *store, const char *kind, struct arena *arena,
                     const struct table *table);
/* Takes over those that are wanted, in the place of those of the same kind; `source` is empty then.
 * wanted() may add keys to the table. Without memory a table is lost. */
void table_store_take(struct table_store *store, struct table_store *source,
                      bool (*wanted)(void *context, struct stored_table *stored), void *context);
/* Collect a record: reply_begin() to reply_end() call these. */
void store_row_begin(struct table_store *store, const char *kind);
void store_cell_none(struct table_store *store, const char *name);
void store_cell_real(struct table_store *store, const char *name, const char *unit, double value);
void store_cell_text(struct table_store *store, const char *name, const char *text);
void store_row_end(struct table_store *store);
