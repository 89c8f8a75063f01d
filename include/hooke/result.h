/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * result: what leaves a command: lines and records, tables for people, documents, errors with their
 * place.
 *
 * Nothing here knows what the numbers mean, and nothing prints: a struct sink takes what is said.
 */
#ifndef HOOKE_RESULT_H
#define HOOKE_RESULT_H

#include <hooke/base.h>

/* ---- tables ---- */

enum table_format {
    TABLE_CSV,
    TABLE_TSV,
    TABLE_JSON,
    TABLE_MARKDOWN,
    TABLE_HTML,
    TABLE_LATEX,
};

struct table_column {
    const char *name, *unit;
    const double *value; /* [rows], or NULL and `text` */
    const char *const *text;
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
    const struct cancel *cancel; /* ends its writing; NULL: nobody can */
};

/* struct row at the enum's place: csv, tsv, json, md, html, tex */
extern const struct catalog table_format_catalog;

/* Every double reads back bit for bit; `.` and newline whatever the locale. Text cells that could
 * be a formula or contain the separator are quoted. */
void table_format(const struct table *table, enum table_format format, struct buffer *out);
bool table_write(const struct table *table, enum table_format format, const char *path,
                 struct write_policy policy, struct error *error);
bool table_send(const struct table *table, enum table_format format, struct writer *writer,
                struct error *error); /* to a file that is open, which is closed in every case */
/* Whether it begins as a table in CSV, TSV or JSON that has keys. */
bool table_recognise(struct text text);
/* Reads such a text back: the same doubles and texts. ERROR_IO: it is damaged. `cancel` goes into
 * the table, too. */
bool table_parse(struct text text, const struct cancel *cancel, struct arena *arena,
                 struct table *table, struct error *error);
void buffer_json_text(struct buffer *out, struct text text); /* quoted and escaped, valid UTF-8 */
void buffer_json_real(struct buffer *out, double value);     /* null where not finite */

/* ---- tables by kind ----
 *
 * The last result of each kind. Records become rows of such tables: a field is a column, those of
 * objects and arrays are called by their path, "halves.gamma.1"; of an object in an array its name
 * stands for the number, where "name" is its first field. */

struct column_growth; /* private: columns that grow */

struct stored_table {
    const char *kind; /* "compare"; lives as long as the arena, or longer */
    struct arena arena;
    struct table table;
    struct column_growth *growth; /* NULL: the table is whole, records add nothing */
};

struct table_store {
    struct stored_table **of; /* [count] allocated */
    int count;
    struct stored_table *row; /* private: takes the cells of the present record */
};

void table_store_free(struct table_store *store);
/* NULL: none */
struct stored_table *table_store_find(const struct table_store *store, struct text kind);
/* A whole table, which replaces that of the same kind; the arena that it lives in is taken over.
 * False: no memory, nothing has changed. */
bool table_store_put(struct table_store *store, const char *kind, struct arena *arena,
                     const struct table *table);
/* Takes over those that are wanted, in the place of those of the same kind; `from` is empty then.
 * wanted() may add keys to the table. Without memory a table is lost. */
void table_store_take(struct table_store *store, struct table_store *from,
                      bool (*wanted)(void *context, struct stored_table *stored), void *context);
/* What reply_begin() to reply_end() do where records are collected. */
void store_row_begin(struct table_store *store, const char *kind);
void store_cell_none(struct table_store *store, const char *name);
void store_cell_real(struct table_store *store, const char *name, const char *unit, double value);
void store_cell_text(struct table_store *store, const char *name, const char *text);
void store_row_end(struct table_store *store);

/* ---- reply: what a command says ----
 *
 * Lines are for people, records for programs. FORMAT_TEXT writes lines and ignores records;
 * FORMAT_JSON writes one object a line, and the lines of a command that made no record as {kind,
 * text}; FORMAT_CSV writes rows with a header whenever the kind changes, lines without a record as
 * comments.
 */

enum output_format { FORMAT_TEXT, FORMAT_CSV, FORMAT_JSON };

struct source; /* where a line comes from: below */

struct sink {
    /* results; false: they cannot be written (closed, full device) */
    bool (*out)(void *context, struct text text);
    bool (*err)(void *context, struct text text); /* messages */
    void *context;
};

#define REPLY_DEPTH 8
#define REPLY_NAME 48 /* [byte] of an object in an array, for its columns */

struct reply {
    struct sink sink;
    bool quiet; /* lines are left out (option -q); records, warnings and errors stay */
    enum output_format format; /* follows the session's setting, statement by statement */
    bool failed;               /* the sink refused results; nothing more is written there */
    struct buffer json;        /* the record under construction */
    struct buffer header, row; /* its CSV form */
    struct buffer lines;       /* lines of a command that may yet make a record */
    struct buffer last_header; /* what stands above the last CSV row */
    const char *kind;          /* of the record */
    bool begun;                /* there was a table in CSV */
    /* Told, with the sink's context, that another table in CSV begins; NULL: a blank line and a
     * comment with its kind stand before it. */
    void (*part)(void *context, const char *kind);
    /* Told, likewise, of each error beside its message; column: in the line at `where`, from 1, 0:
     * nowhere in it. NULL: nobody is. */
    void (*error)(void *context, const struct error *error, const struct source *where,
                  size_t column);
    bool recorded;             /* this command made a record */
    bool muted;                /* lines and records are not written, only collected */
    struct table_store *store; /* records are rows of its tables, too; NULL: they are not */
    int depth;                 /* objects and arrays open in the record */
    struct {
        const char *key;
        bool array, empty;
        int element;           /* of an array: the present one, from 1 */
        char name[REPLY_NAME]; /* of an object in an array: its first field, where that is "name" */
    } level[REPLY_DEPTH];
};

void reply_init(struct reply *reply, struct sink sink);
void reply_free(struct reply *reply);
/* one or more lines, without the last newline */
void reply_line(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
void reply_text(struct reply *reply, struct text text); /* the same, ready-made */
/* the same, broken between words into lines of at most `width` columns */
void reply_paragraph(struct reply *reply, struct text text, int width);
/* What was asked for as it is: also when quiet, and among records in CSV. */
void reply_data(struct reply *reply, const char *kind, struct text text);
void reply_warning(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
/* a message on the error stream, as it is */
void reply_note(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);

/* Whether anybody wants records: where they cost much. */
bool reply_wants_records(const struct reply *reply);
/* A record. key NULL: the next element of an array. Numbers that are not finite become null. */
void reply_begin(struct reply *reply, const char *kind);
void reply_string(struct reply *reply, const char *key, const char *value); /* NULL: null */
void reply_real(struct reply *reply, const char *key, double value);
/* the same; its column has that unit */
void reply_quantity(struct reply *reply, const char *key, double value, const char *unit);
void reply_int(struct reply *reply, const char *key, int64_t value);
void reply_bool(struct reply *reply, const char *key, bool value);
void reply_null(struct reply *reply, const char *key);
void reply_in_unit(struct reply *reply, const char *key, struct measured value, const char *unit);
void reply_measured(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity);
void reply_object(struct reply *reply, const char *key);
void reply_array(struct reply *reply, const char *key);
void reply_close(struct reply *reply); /* the innermost object or array */
void reply_end(struct reply *reply);   /* the record */
/* `count` rows of a table, a record each. Not headed: their names stand above an earlier part of
 * the table, in another output. */
void reply_table_rows(struct reply *reply, const char *kind, const struct table *table,
                      size_t first, size_t count, bool headed);

/* ---- how the interpreter brackets what a command says ---- */

void reply_command_begin(struct reply *reply, enum output_format format);
/* Lines of a command that made no record: as {kind, text}, or as comments of the CSV. */
void reply_command_end(struct reply *reply, const char *kind);

/* ---- where a line comes from ---- */

/* Of a line of a file, which may be continued on others: where a piece of it comes from. */
struct source_piece {
    size_t at;        /* in the line as it is executed */
    int line, indent; /* indent: characters left out before it */
};

struct source {
    const char *name;            /* "lab1.hk", "-c", "-" ; NULL: typed at the prompt */
    int line;                    /* counted from 1 */
    const struct source *parent; /* who sourced it */
    const struct source_piece *piece;
    int pieces;
};

/* Writes an error the way users see it: position, line, caret, hint; or as JSON. where may be NULL,
 * line may be empty.
 */
void reply_error(struct reply *reply, const struct error *error, const struct source *where,
                 struct text line);

/* ---- text for people ---- */

/* "199.9 +- 0.1 g", "1.9373 +- 0.0002 s": in the unit that shows the value well. */
void buffer_measured(struct buffer *buffer, struct measured value, enum quantity quantity,
                     int digits);
/* The value as a command that reads back exactly: "0.2 kg", "199.9 +- 0.1 g". */
void buffer_exact(struct buffer *buffer, struct measured value, enum quantity quantity);
/* A word of a command line, quoted where it has to be. */
void buffer_word(struct buffer *buffer, struct text word);

/* ---- tables for people ---- */

#define TABLE_COLUMNS_MAX 24

struct text_table {
    struct arena *arena;
    int columns, gap, indent;
    int max; /* [cell] the width to fit: gaps shrink, columns of one value fold; 0 means any */
    int cells, capacity;
    const char **cell; /* row by row, the heading first */
    bool failed;       /* no memory: cells are missing */
};

void cell_text(struct text_table *table, const char *text); /* copied; NULL: an empty cell */
/* the same from a buffer, which is freed */
void cell_take(struct text_table *table, struct buffer *text);
/* "-": not finite */
void cell_quantity(struct text_table *table, double value, enum quantity quantity, int digits);
void cell_error(struct text_table *table, double value); /* 1.3e-05 */
void cell_count(struct text_table *table, int64_t value);
void cell_seconds(struct text_table *table, double seconds); /* with us below a millisecond */
/* The heading, NAME [UNIT], and the first rows of the first columns of a table. */
void table_cells(const struct table *from, size_t rows, struct text_table *table);
void text_table_put(const struct text_table *table, struct buffer *out);

/* ---- columns: what a result consists of, described once beside its struct ----
 *
 * A result is an array of structs; a column says where a value of such a struct is, what it is
 * called by programs and by people, and how people see it. Records, tables to files and tables for
 * people are made of the same columns.
 */

enum column_kind {
    COLUMN_REAL,  /* double; NAN: there is none */
    COLUMN_INT,   /* int */
    COLUMN_COUNT, /* int64_t */
    COLUMN_BOOL,
    COLUMN_NAME,     /* const char *; NULL: there is none */
    COLUMN_MEASURED, /* struct measured of `quantity`; value NAN: there is none. Only in records */
    COLUMN_CHARS,    /* an array of char, ended by 0; empty: there is none */
};

enum column_flag {
    COLUMN_NO_RECORD = 1,
    COLUMN_NO_FILE = 2,
    COLUMN_IF_ANY =
        4, /* for people only where a row has a value, not 0 where it is a number of things */
    COLUMN_WIDE = 8, /* for people only where there is much room */
};

struct result_column {
    const char *name;                       /* key of records, column of files */
    const char *heading;                    /* for people */
    const char *(*head)(const void *first); /* the same where it depends on the first row */
    int index; /* among the columns for people, from 1; 0: it is not there */
    unsigned flags;
    enum column_kind kind;
    enum quantity quantity; /* of a real */
    /* where rows differ; files have the first row's unit */
    enum quantity (*quantity_of)(const void *row);
    size_t at;                            /* offset in the struct */
    double (*real)(const void *row);      /* or what gives the value: */
    int64_t (*number)(const void *row);   /* COLUMN_COUNT */
    const char *(*text)(const void *row); /* COLUMN_NAME */
    bool (*any)(const void *row);         /* COLUMN_IF_ANY: where that is more than a value */
    bool (*defined)(const void *row);     /* without it the record has no such key */
    /* Of an object or an array: only records have it. */
    void (*record)(struct reply *reply, const char *key, const void *row);
    int digits; /* for people, of a real; 0: 3 */
    /* a real for people, cell_error for one */
    void (*look)(struct text_table *table, double value);
    void (*cell)(struct text_table *table, const void *row); /* or the whole cell */
};

struct result_columns {
    const struct result_column *column;
    int count;
    size_t size; /* [byte] of a row's struct */
};

#define RESULT_COLUMNS(array, type)                                                                \
    {                                                                                              \
        array, (int)COUNT_OF(array), sizeof(type)                                                  \
    }

/* Fields of one row in the object that is open; reply_records(): each row as a record of that kind.
 */
void reply_columns(struct reply *reply, const struct result_columns *columns, const void *row);
void reply_records(struct reply *reply, const char *kind, const struct result_columns *columns,
                   const void *rows, size_t count);
/* The table to files, without keys, from the arena; it holds when the rows are gone, as long as
 * what their names point to. False: no memory. */
bool columns_table(const struct result_columns *columns, const void *rows, size_t count,
                   struct arena *arena, struct table *table);
/* Adds heading and cells to a table that is empty; its `columns` is counted here. A failure is in
 * table->failed. */
void columns_text(const struct result_columns *columns, const void *rows, size_t count, bool wide,
                  struct text_table *table);

/* "15.100 +- 0.008 N/m" as \SI{15.100 +- 0.008}{\newton\per\metre}. */
void buffer_siunitx(struct buffer *out, struct text measured);

/* ---- documents ----
 *
 * A document written three times at once, as Markdown (CommonMark with tables), as HTML5 that loads
 * nothing from outside, and as LaTeX (pdflatex with siunitx, version 2 or 3). Own words are
 * escaped; what came from users or files (names, notes, paths) goes through document_name() and can
 * become nothing but code.
 */

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
    struct buffer md, html, tex;
    size_t table;  /* where that of the LaTeX began */
    int heads;     /* cells of the heading under construction */
    int cells;     /* of the row under construction */
    bool in_table; /* where a bar ends a cell */
};

void document_begin(struct document *document, const char *title);
void document_end(struct document *document);
void document_free(struct document *document);
void document_open(struct document *document, enum block block);
void document_close(struct document *document, enum block block);
/* Own words; "+-" becomes the sign. */
void document_say(struct document *document, const char *format, ...) PRINTF_LIKE(2, 3);
/* A value with its unit, as buffer_measured() writes it; LaTeX sets it by siunitx. */
void document_measured(struct document *document, struct measured value, enum quantity quantity,
                       int digits);
void document_name(struct document *document, struct text name);
void document_link(struct document *document, const char *file, const char *words);
/* A block of own words. */
void document_put(struct document *document, enum block block, const char *words);
void document_heading_ends(struct document *document);
struct document_picture {
    const char *name;        /* of its files, which end in .svg, .txt and .pdf */
    const char *alternative; /* in words; own ones */
    struct text svg, text;
    bool pdf; /* there is such a file; else LaTeX has the text */
};
/* Markdown names the files, HTML has them in itself, LaTeX includes the PDF. */
void document_figure(struct document *document, const struct document_picture *picture);
void document_code(struct document *document, struct text code);
void document_answer(struct document *document); /* an empty place */

#endif
