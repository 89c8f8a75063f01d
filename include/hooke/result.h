/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * result: what leaves a command: lines and records, tables for people, errors with their place.
 *
 * Nothing here knows what the numbers mean, and nothing prints: a struct sink takes what is said.
 */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/result/table.h>

struct cancel;
struct catalog;

/* ---- reply: what a command says ----
 *
 * Lines are for people, records for programs. FORMAT_TEXT writes lines and ignores records;
 * FORMAT_JSON writes one object a line, and the lines of a command that made no record as {kind,
 * text}; FORMAT_CSV writes rows with a header whenever the kind changes, lines without a record as
 * comments.
 */

enum output_format { FORMAT_TEXT, FORMAT_CSV, FORMAT_JSON };

struct source; /* position of a line in its source, defined below */

struct sink {
    /* Writes results. Returns false if they cannot be written (closed, full device). */
    bool (*output)(void *context, struct text text);
    bool (*err)(void *context, struct text text); /* messages */
    void *context;
};

/* Takes what nobody wants to see: the sink of results, or of messages, of a reply whose other half
 * is read. */
bool sink_nothing(void *context, struct text text);

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
    struct buffer last_header; /* header above the last CSV row */
    const char *kind;          /* kind of the record */
    bool begun;                /* there was a table in CSV */
    /* Called, with the sink's context, when another table in CSV begins. If NULL, a blank line
     * and a comment with the table's kind are written. */
    void (*part)(void *context, const char *kind);
    /* Called, with the sink's context, for each error, in addition to its message. column counts
     * from 1 in the line at `where`, 0 if unknown. May be NULL. */
    void (*error)(void *context, const struct error *error, const struct source *where,
                  size_t column);
    bool recorded;             /* this command made a record */
    bool muted;                /* lines and records are not written, only collected */
    struct table_store *store; /* records are rows of its tables, too; NULL if they are not */
    int depth;                 /* objects and arrays open in the record */
    struct {
        const char *key;
        bool array, empty;
        int element;           /* current element of an array, from 1 */
        char name[REPLY_NAME]; /* first field of an object in an array, if that is "name" */
    } level[REPLY_DEPTH];
};

void reply_init(struct reply *reply, struct sink sink);
void reply_free(struct reply *reply);
/* one or more lines, without the last newline */
void reply_line(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
void reply_text(struct reply *reply, struct text text); /* the same, ready-made */
/* Returns the buffer to which lines for people can be appended. They are written, with a newline at
 * their end, before anything else that the command says, or when it ends. */
struct buffer *reply_buffer(struct reply *reply);
/* the same, broken between words into lines of at most `width` columns */
void reply_paragraph(struct reply *reply, struct text text, int width);
/* Writes data that was asked for without changes, also when quiet and among records in CSV. */
void reply_data(struct reply *reply, const char *kind, struct text text);
void reply_warning(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
/* a message on the error stream, as it is */
void reply_note(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);

/* Return true if the records of a command, or its lines of text, are wanted. A command that
 * makes records may skip its text. */
bool reply_wants_records(const struct reply *reply);
bool reply_wants_text(const struct reply *reply);
/* A record. key NULL: the next element of an array. Numbers that are not finite become null. */
void reply_begin(struct reply *reply, const char *kind);
/* a NULL value is written as null */
void reply_string(struct reply *reply, const char *key, const char *value);
void reply_real(struct reply *reply, const char *key, double value);
/* the same; its column has that unit */
void reply_quantity(struct reply *reply, const char *key, double value, const char *unit);
void reply_int(struct reply *reply, const char *key, int64_t value);
void reply_bool(struct reply *reply, const char *key, bool value);
void reply_null(struct reply *reply, const char *key);
void reply_in_unit(struct reply *reply, const char *key, struct measured value, const char *unit);
void reply_measured(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity);
/* the same; null where the value is not finite */
void reply_if_known(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity);
void reply_object(struct reply *reply, const char *key);
void reply_array(struct reply *reply, const char *key);
/* an array of numbers */
void reply_reals(struct reply *reply, const char *key, const double *value, int count,
                 const char *unit);
void reply_close(struct reply *reply); /* the innermost object or array */
void reply_end(struct reply *reply);   /* the record */
/* `count` rows of a table, a record each. Not headed: their names stand above an earlier part of
 * the table, in another output. Returns false if the table's writing was cancelled. */
bool reply_table_rows(struct reply *reply, const char *kind, const struct table *table,
                      size_t first, size_t count, bool headed);

/* ---- how the interpreter brackets what a command says ---- */

void reply_command_begin(struct reply *reply, enum output_format format);
void reply_flush(struct reply *reply); /* writes what reply_buffer() was given */
/* Lines of a command that made no record: as {kind, text}, or as comments of the CSV. */
void reply_command_end(struct reply *reply, const char *kind);

/* ---- where a line comes from ---- */

/* Part of a line of a file that may be continued on others, with its position in the file. */
struct source_piece {
    size_t position;  /* offset in the line as executed */
    int line, indent; /* indent is the number of characters left out before it */
};

struct source {
    const char *name;            /* "lab1.hk", "-c", "-"; NULL if typed at the prompt */
    int line;                    /* counted from 1 */
    const struct source *parent; /* file or line that sourced it */
    const struct source_piece *piece;
    int pieces;
};

/* Writes an error the way users see it: position, line, caret, hint; or as JSON. where may be NULL,
 * line may be empty.
 */
void reply_error(struct reply *reply, const struct error *error, const struct source *where,
                 struct text line);

/* ---- text for people ---- */

/*
 * Values as arguments of formats, for %s: SHOWN_QUANTITY(0.2, QUANTITY_MASS, 3) is "200 g". Nothing
 * is allocated; the text lives as long as the block that it stands in. SHOWN_VALUE() and
 * SHOWN_MEASURED() are as buffer_measured(): times from 0.1 s on stay in seconds.
 */
struct value_text {
    char data[128];
};
const char *value_text_short(struct value_text *text, double value, int digits);
const char *value_text_quantity(struct value_text *text, double value, enum quantity quantity,
                                int digits);
const char *value_text_measured(struct value_text *text, struct measured value,
                                enum quantity quantity, int digits);
#define SHOWN_SHORT(value, digits) value_text_short(&(struct value_text){""}, value, digits)
#define SHOWN_QUANTITY(value, quantity, digits)                                                    \
    value_text_quantity(&(struct value_text){""}, value, quantity, digits)
#define SHOWN_MEASURED(measured, quantity, digits)                                                 \
    value_text_measured(&(struct value_text){""}, measured, quantity, digits)
#define SHOWN_VALUE(value, quantity, digits)                                                       \
    SHOWN_MEASURED(((struct measured){value, 0}), quantity, digits)
const char *plural_s(int64_t count); /* returns "s", or "" for one */

/* Appends a measured value in the unit that suits it: "199.9 +- 0.1 g", "1.9373 +- 0.0002 s". */
void buffer_measured(struct buffer *buffer, struct measured value, enum quantity quantity,
                     int digits);
/* The value as a command that reads back exactly: "0.2 kg", "199.9 +- 0.1 g". */
void buffer_exact(struct buffer *buffer, struct measured value, enum quantity quantity);
/* A word of a command line, quoted where it has to be. */
void buffer_word(struct buffer *buffer, struct text word);

/* ---- tables for people ---- */

#define TABLE_COLUMNS_MAX 24
#define TABLE_RANK_WIDE 4 /* the rank of columns with COLUMN_WIDE */

struct text_table {
    struct arena *arena;
    int columns, gap, indent;
    /* [cell] the width to fit, or 0 for any: gaps shrink, columns of one value fold, then others
     * are left out, and a line below says which */
    int max;
    int rank[TABLE_COLUMNS_MAX]; /* like that of struct result_column, but columns of rank 0 stay */
    int cells, capacity;
    const char **cell; /* row by row, the heading first */
    bool failed;       /* no memory: cells are missing */
};

/* copies the text; NULL makes an empty cell */
void cell_text(struct text_table *table, const char *text);
void cell_format(struct text_table *table, const char *format, ...) PRINTF_LIKE(2, 3);
/* the same from a buffer, which is freed */
void cell_take(struct text_table *table, struct buffer *text);
/* Adds a quantity, or "-" if it is not finite. */
void cell_quantity(struct text_table *table, double value, enum quantity quantity, int digits);
void cell_error(struct text_table *table, double value); /* 1.3e-05 */
void cell_count(struct text_table *table, int64_t value);
void cell_seconds(struct text_table *table, double seconds); /* uses us below a millisecond */
/* The heading, NAME [UNIT], and the first rows of the first columns of a table. */
void table_cells(const struct table *source, size_t rows, struct text_table *table);
void text_table_put(const struct text_table *table, struct buffer *output);

/* ---- columns: what a result consists of, described once beside its struct ----
 *
 * A result is an array of structs; a column says where a value of such a struct is, what it is
 * called by programs and by people, and how people see it. Records, tables to files and tables for
 * people are made of the same columns.
 */

enum column_kind {
    COLUMN_REAL,  /* double; NAN if there is none */
    COLUMN_INT,   /* int */
    COLUMN_COUNT, /* int64_t */
    COLUMN_BOOL,
    COLUMN_NAME,     /* const char *; NULL if there is none */
    COLUMN_MEASURED, /* struct measured of `quantity`; value NAN: there is none. Only in records */
    COLUMN_CHARS,    /* array of char ended by 0; absent if empty */
    COLUMN_ROW,      /* pointer to what begins with a struct row: its name; NULL if there is none */
    COLUMN_CHOICE,   /* an enum: name of that row of `choices`, where its first has choice_first */
    /* An object of struct `part`, or an array of them, which list() returns. Only in records */
    COLUMN_OBJECT,
    COLUMN_LIST,
};

enum column_flag {
    COLUMN_NO_RECORD = 1,
    COLUMN_NO_FILE = 2,
    COLUMN_IF_ANY = 4,  /* shown to people only if a row has a value (other than 0 for a count) */
    COLUMN_WIDE = 8,    /* shown to people only if there is much room */
    COLUMN_DETAIL = 16, /* left out of documents (.md, .html, .tex) */
};

struct result_column {
    const char *name;                       /* key of records, column of files */
    const char *heading;                    /* heading for people */
    const char *(*head)(const void *first); /* the same where it depends on the first row */
    int index; /* index among the columns for people, from 1; 0 if it is not shown to them */
    /* Rank that decides which columns are left out if a table is too wide: the largest rank first,
     * and within a rank from the right; the first column is always shown. 0 stands for 2, and
     * COLUMN_WIDE for 4, whose columns are dropped silently; others are named below the table. */
    int rank;
    unsigned flags;
    enum column_kind kind;
    enum quantity quantity; /* quantity of a real */
    /* Quantity where rows differ; files use the first row's unit. */
    enum quantity (*quantity_of)(const void *row);
    size_t offset;         /* offset in the struct, or in what a pointer in it points to: */
    size_t pointer_offset; /* COLUMN_IN of that pointer; 0 if there is none */
    double (*real)(const void *row);      /* or what gives the value: */
    int64_t (*number)(const void *row);   /* COLUMN_COUNT */
    const char *(*text)(const void *row); /* COLUMN_NAME */
    const struct catalog *choices;        /* COLUMN_CHOICE */
    int choice_first;
    const struct result_columns *part; /* COLUMN_OBJECT, COLUMN_LIST */
    const void *(*list)(const void *row, size_t *count);
    /* Returns true if COLUMN_IF_ANY shows the column, where that needs more than a value. */
    bool (*any)(const void *row);
    /* Returns true if the row has this value; otherwise the record omits the key. */
    bool (*defined)(const void *row);
    /* Writes an object or an array, which only records have. */
    void (*record)(struct reply *reply, const char *key, const void *row);
    int digits; /* digits of a real for people; 0 stands for 3 */
    /* a real for people, cell_error for one */
    void (*look)(struct text_table *table, double value);
    void (*cell)(struct text_table *table, const void *row); /* or the whole cell */
};

#define COLUMN_IN(type, pointer) (offsetof(type, pointer) + 1)

struct result_columns {
    const struct result_column *column;
    int count;
    size_t size; /* [byte] of a row's struct */
    int digits;  /* that documents show of a number that is not whole; 0 shows all */
};

#define RESULT_COLUMNS(array, type)                                                                \
    {                                                                                              \
        array, (int)COUNT_OF(array), sizeof(type), 0                                               \
    }

/* reply_columns() adds the fields of one row to the open object; reply_records() writes each row
 * as a record of that kind. */
void reply_columns(struct reply *reply, const struct result_columns *columns, const void *row);
void reply_records(struct reply *reply, const char *kind, const struct result_columns *columns,
                   const void *rows, size_t count);
/* The table to files, without keys, from the arena; it holds when the rows are gone, as long as
 * what their names point to. Returns false if out of memory. */
bool columns_table(const struct result_columns *columns, const void *rows, size_t count,
                   struct arena *arena, struct table *table);
/* Adds heading and cells to a table that is empty; its `columns` is counted here. A failure is in
 * table->failed. */
void columns_text(const struct result_columns *columns, const void *rows, size_t count, bool wide,
                  struct text_table *table);
