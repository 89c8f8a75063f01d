/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * result: everything that a command writes: lines and records (struct reply), tables for people
 * (struct text_table), results described by columns (struct result_columns), and errors with their
 * position.
 *
 * The functions do not depend on the meaning of the numbers, and print nothing themselves: a struct
 * sink receives the finished output. The interpreter calls reply_init() once, reply_command_begin()
 * and reply_command_end() around each command, and reply_free(); handlers call the functions in
 * between.
 */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/result/table.h>

struct cancel;
struct catalog;

/*
 * ---- reply: everything that a command writes ----
 *
 * Lines are for people, records for programs. FORMAT_TEXT writes lines and ignores records.
 * FORMAT_JSON writes each record as one object per line, and the lines of a command without a
 * record as {kind, text}. FORMAT_CSV writes records as rows, with a header whenever the columns
 * change, and the lines of a command without a record as comments.
 */

/* Form of the results, chosen by the option --format. */
enum output_format { FORMAT_TEXT, FORMAT_CSV, FORMAT_JSON };

struct source; /* position of a line in its source, defined below */

/* Receiver of finished output; copied by reply_init(). */
struct sink {
    /* Writes results. Returns false if they cannot be written (closed stream, full device). */
    bool (*output)(void *context, struct text text);
    /* Writes warnings, notes and errors; returns false if that fails, which is ignored. */
    bool (*err)(void *context, struct text text);
    void *context; /* First argument of both functions. */
};

/* Discards the text and returns true. For sinks whose results or messages are not needed. */
bool sink_nothing(void *context, struct text text);

/* Largest nesting of objects and arrays in a record. */
#define REPLY_DEPTH 8
#define REPLY_NAME 48 /* Size [byte] of the name of an object in an array. */

/* Output of commands and its state. Handlers only pass it to functions. Front ends set `muted`,
 * `store`, `part` and `error`; all other members are private to src/result and the interpreter. */
struct reply {
    struct sink sink; /* Receives all output. */
    bool quiet;       /* Lines are not written (option -q); records, warnings and errors are. */
    enum output_format format; /* Form of the results of the current statement. */
    bool failed;        /* The sink could not write results; no more results are sent to it. */
    struct buffer json; /* The record that is being made, as JSON. */
    struct buffer header, row; /* This record as the header and the row of a CSV table. */
    /* Lines that are written later, since with JSON and CSV they are dropped if the command makes a
     * record. */
    struct buffer lines;
    struct buffer last_header; /* Header of the last CSV row that was written. */
    const char *kind;          /* Kind of the record, such as "fit"; a constant. */
    bool begun;                /* A CSV table has been written. */
    /* Called as part(sink.context, kind) when a CSV table with other columns than the one before
     * begins. If NULL, a blank line and a comment with the kind of the table separate them. */
    void (*part)(void *context, const char *kind);
    /* Called for each error, in addition to writing its message, with sink.context as the first
     * argument. `column` is the position in the line at `where`, from 1, or 0 if unknown. May be
     * NULL. */
    void (*error)(void *context, const struct error *error, const struct source *where,
                  size_t column);
    bool recorded; /* The current command has made a record. */
    bool muted;    /* Lines and records are not written; records are only added to `store`. */
    struct table_store *store; /* Tables to which records are added as rows, or NULL; not owned. */
    int depth;                 /* Number of objects and arrays that are open in the record. */
    struct {
        const char *key; /* Key of the open object or array. */
        bool array;      /* The level is an array, not an object. */
        bool empty;      /* The object or array has no element yet. */
        /* Number of the current element of an array, from 1. */
        int element;
        /* Value of the field "name" of an object whose first field it is; in tables, names of the
         * object's columns contain this value. Otherwise "". */
        char name[REPLY_NAME];
    } level[REPLY_DEPTH];
};

/* Initialises a reply that writes to `sink`; reply_free() ends it. */
void reply_init(struct reply *reply, struct sink sink);
/* Frees the memory of a reply. */
void reply_free(struct reply *reply);
/* Writes one or more lines of formatted text; the format must not end with a newline. Control
 * characters are made visible. */
void reply_line(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
/* Writes a text, which may contain several lines, unchanged. */
void reply_text(struct reply *reply, struct text text);
/* Returns a buffer to which a handler can append lines. They are written, with a newline at their
 * end, before any other output or when the command ends. The buffer belongs to the reply. */
struct buffer *reply_buffer(struct reply *reply);
/* Writes a text, broken between words into lines of at most `width` columns. */
void reply_paragraph(struct reply *reply, struct text text, int width);
/* Writes a text unchanged as the result of the command, even with the option -q. In CSV the text
 * counts as a table of this kind. */
void reply_data(struct reply *reply, const char *kind, struct text text);
/* Writes "warning: TEXT" to the messages, or a record {kind: "warning", text} in JSON. */
void reply_warning(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
/* Writes a line to the messages without "warning: ", in every format. */
void reply_note(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);

/* Return false if records, or lines, would not be written or stored, so that a handler need not
 * make them. */
bool reply_wants_records(const struct reply *reply);
bool reply_wants_text(const struct reply *reply);
/* Begins a record of this kind. Until reply_end(), the functions below add a field with a key to
 * the innermost open object or, with key = NULL, an element to the innermost open array. Keys are
 * constants of the program. Numbers that are not finite become null. Sets reply->failed if out of
 * memory, as the other functions do. */
void reply_begin(struct reply *reply, const char *kind);
/* Adds a text; NULL gives null. */
void reply_string(struct reply *reply, const char *key, const char *value);
/* Adds a number without a unit. */
void reply_real(struct reply *reply, const char *key, double value);
/* Adds a number, which is in `unit`; records omit the unit, tables have it in the column's heading.
 */
void reply_quantity(struct reply *reply, const char *key, double value, const char *unit);
/* Adds an integer. */
void reply_int(struct reply *reply, const char *key, int64_t value);
/* Adds true or false. */
void reply_bool(struct reply *reply, const char *key, bool value);
/* Adds null. */
void reply_null(struct reply *reply, const char *key);
/* Adds an object {value, uncertainty, unit}; `value` is in `unit`. In tables it is two columns, KEY
 * and KEY_uncertainty. */
void reply_in_unit(struct reply *reply, const char *key, struct measured value, const char *unit);
/* Does the same with a value in the SI unit of its quantity. */
void reply_measured(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity);
/* Does the same as reply_measured(), or adds null if the value is not finite. */
void reply_if_known(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity);
/* Opens an object in the record; reply_close() ends it. */
void reply_object(struct reply *reply, const char *key);
/* Opens an array in the record; reply_close() ends it. */
void reply_array(struct reply *reply, const char *key);
/* Adds an array of `count` numbers, all in `unit`. */
void reply_reals(struct reply *reply, const char *key, const double *value, int count,
                 const char *unit);
void reply_close(struct reply *reply); /* Closes the innermost open object or array. */
void reply_end(struct reply *reply);   /* Closes all that is open and writes the record. */
/* Writes `count` rows of a table from row `first` on, each as a record of this kind. CSV has a
 * header line before them only if `headed`, which is false if an earlier part of the table was
 * written. Returns false if table->cancel was set; some of the rows may have been written. */
bool reply_table_rows(struct reply *reply, const char *kind, const struct table *table,
                      size_t first, size_t count, bool headed);

/* ---- for the interpreter: before and after each command ---- */

/* Begins the output of a command in this format. */
void reply_command_begin(struct reply *reply, enum output_format format);
/* Writes the lines that were appended to reply_buffer(), if the format is text. */
void reply_flush(struct reply *reply);
/* Ends the output of a command. If it made no record, its lines are written as a record {kind,
 * text} in JSON, or as comments in CSV. */
void reply_command_end(struct reply *reply, const char *kind);

/* ---- where a line comes from ---- */

/* A piece of a statement that was joined from several lines of a file. Tells to which line and
 * column of the file an offset in the joined statement belongs. */
struct source_piece {
    size_t position; /* Offset [byte] of the piece in the joined statement. */
    int line,        /* Number, from 1, of the line of the file. */
        indent;      /* Number of characters at the beginning of that line that the piece omits. */
};

/* Origin of a line that is executed; sources of nested scripts are linked. */
struct source {
    /* File name, "-c", or "-" for standard input; NULL for a line typed at the prompt. */
    const char *name;
    int line;                    /* Line number, counted from 1. */
    const struct source *parent; /* Line whose `source` command executes this file, or NULL. */
    /* [pieces] for a line that was joined from several, or NULL. */
    const struct source_piece *piece;
    int pieces;
};

/* Writes an error as users see it: position, line with a caret, message and hint; or as a record in
 * JSON. `where` may be NULL and `line` empty if they are unknown. */
void reply_error(struct reply *reply, const struct error *error, const struct source *where,
                 struct text line);

/* ---- text for people ---- */

/* SHOWN_…() give values [SI] as texts for %s: SHOWN_QUANTITY(0.2, QUANTITY_MASS, 3) is "200 g".
 * `digits` is the number of significant digits. The text is in a temporary struct value_text, which
 * lives until the end of the enclosing block; nothing is allocated. SHOWN_SHORT() has no unit.
 * SHOWN_VALUE() and SHOWN_MEASURED() write as buffer_measured() does, with times from 0.1 s on in
 * seconds. */
/* Memory for the text of one value, large enough for any. */
struct value_text {
    char data[128];
};
/* Functions of the macros below; they write into *text and return text->data. */
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
const char *plural_s(int64_t count); /* Returns the plural ending "s", or "" for a count of 1. */

/* Appends a value [SI] in a suitable unit: "199.9 +- 0.1 g", "1.9373 +- 0.0002 s". An uncertainty
 * below the last of `digits` significant digits is left out. */
void buffer_measured(struct buffer *buffer, struct measured value, enum quantity quantity,
                     int digits);
/* Appends a value [SI] so that a command reads back the same bits: "0.2 kg", "199.9 +- 0.1 g". */
void buffer_exact(struct buffer *buffer, struct measured value, enum quantity quantity);
/* Appends a word as it is typed in a command line, in quotes where it needs them. */
void buffer_word(struct buffer *buffer, struct text word);

/* ---- tables for people ---- */

/* Largest number of columns of a table for people. */
#define TABLE_COLUMNS_MAX 24
/* Rank of columns that a table that is too wide leaves out without listing them. */
#define TABLE_RANK_WIDE 4

/* A table as aligned text. Set arena, columns, gap, indent, max and rank; add the headings and then
 * the cells row by row with cell_…(); end with text_table_put(). */
struct text_table {
    /* Owner of all cells. */
    struct arena *arena;
    /* Number of columns, of blanks between two columns, and of blanks before the first column. */
    int columns, gap, indent;
    /* Width [column] into which the table has to fit, or 0 for any. If it is too wide, the gaps
     * shrink, then columns with the same value in all rows are replaced by a line below the table,
     * then columns are left out, which another line lists. */
    int max;
    /* [columns] order in which columns are left out, the largest first; columns of rank 0 are
     * always shown. */
    int rank[TABLE_COLUMNS_MAX];
    /* Number of cells that were added, with the headings, and for which there is memory. */
    int cells, capacity;
    const char **cell; /* [cells] texts, row by row, headings first; owned by the arena. */
    bool failed;       /* Memory has run out: cells are missing. */
};

/* Adds a cell with a copy of the text; NULL gives an empty cell. */
void cell_text(struct text_table *table, const char *text);
/* Adds a cell with formatted text. */
void cell_format(struct text_table *table, const char *format, ...) PRINTF_LIKE(2, 3);
/* Adds a cell with the content of a buffer, which is freed. */
void cell_take(struct text_table *table, struct buffer *text);
/* Adds a value [SI] with a suitable unit, or "-" if it is not finite. */
void cell_quantity(struct text_table *table, double value, enum quantity quantity, int digits);
/* Adds an error with two significant digits, such as "1.3e-05"; "-" if it is not finite. */
void cell_error(struct text_table *table, double value);
/* Adds an integer. */
void cell_count(struct text_table *table, int64_t value);
/* Adds a time, given in s; times below a millisecond are shown in us. */
void cell_seconds(struct text_table *table, double seconds);
/* Adds to *table the headings, NAME [UNIT], and the first `rows` rows of the first table->columns
 * columns of *source. */
void table_cells(const struct table *source, size_t rows, struct text_table *table);
/* Appends the table as lines of text, followed by a line for columns that have the same value in
 * all rows, and one that lists columns left out, if there are such columns. */
void text_table_put(const struct text_table *table, struct buffer *output);

/*
 * ---- columns: the description of a result's struct, for all forms of output ----
 *
 * A result is an array of structs (rows). A struct result_column says where a value of such a
 * struct is, its name for programs and for people, and its form. Records, tables in files and
 * tables for people are made from the same columns.
 */

/* Type of the member that a column shows. */
enum column_kind {
    COLUMN_REAL,  /* A double; NAN means that there is no value. */
    COLUMN_INT,   /* An int. */
    COLUMN_COUNT, /* An int64_t. */
    /* A bool. */
    COLUMN_BOOL,
    COLUMN_NAME, /* A const char *; NULL means that there is none. */
    /* A struct measured of `quantity`, shown in records only; NAN as its value gives null. */
    COLUMN_MEASURED,
    COLUMN_CHARS, /* An array of char with a NUL at its end; empty means that there is none. */
    /* A pointer to a row of a catalog, of which the name is shown; NULL means that there is none.
     */
    COLUMN_ROW,
    COLUMN_CHOICE, /* An enum, shown by the name of the row (value - choice_first) of `choices`. */
    /* A struct described by `part`, shown as an object in records only. */
    COLUMN_OBJECT,
    /* An array of structs described by `part`, which list() returns, shown in records only. */
    COLUMN_LIST,
};

/* Properties of columns, combined by |. */
enum column_flag {
    /* Left out of records. */
    COLUMN_NO_RECORD = 1,
    /* Left out of tables in files. */
    COLUMN_NO_FILE = 2,
    /* Shown to people only if some row has a value (for a count, one other than 0). */
    COLUMN_IF_ANY = 4,
    COLUMN_WIDE = 8,    /* Shown to people only if columns_text() is called with `wide`. */
    COLUMN_DETAIL = 16, /* Left out of documents (.md, .html, .tex). */
};

/* One column of a result. Members that are 0 or NULL are not used. */
struct result_column {
    const char *name;    /* Key in records and name of the column in files. */
    const char *heading; /* Heading in tables for people. */
    /* Returns the heading if it depends on the result; `first` is the first row. */
    const char *(*head)(const void *first);
    /* Position among the columns for people, from 1; 0 means that people do not see it. */
    int index;
    /* Order in which columns are left out of a table that is too wide: those of the largest rank
     * first, and of the same rank the rightmost first. 0 stands for 2, or for 4 with COLUMN_WIDE;
     * columns of rank 4 are not listed below the table. The first column is always shown. */
    int rank;
    /* Flags of enum column_flag. */
    unsigned flags;
    enum column_kind kind;
    enum quantity quantity; /* Quantity of a COLUMN_REAL or COLUMN_MEASURED. */
    /* Returns the quantity if it differs between rows; files use that of the first row. */
    enum quantity (*quantity_of)(const void *row);
    /* Offset of the member in the row's struct, or in the struct to which a pointer of the row
     * points. */
    size_t offset;
    /* COLUMN_IN of that pointer, or 0 if the member is in the row's struct itself. */
    size_t pointer_offset;
    /* Functions that return the value for a row, if it is not that of a member. */
    double (*real)(const void *row);      /* COLUMN_REAL */
    int64_t (*number)(const void *row);   /* COLUMN_COUNT */
    const char *(*text)(const void *row); /* COLUMN_NAME */
    const struct catalog *choices;        /* Names of the values of a COLUMN_CHOICE. */
    int choice_first;                     /* Value of the enum for the first row of `choices`. */
    /* Columns of the structs of COLUMN_OBJECT and COLUMN_LIST. */
    const struct result_columns *part;
    /* Returns the array of a COLUMN_LIST and sets *count to the number of its elements. */
    const void *(*list)(const void *row, size_t *count);
    /* Returns true if the row has a value in the sense of COLUMN_IF_ANY; NULL if the value itself
     * tells this. */
    bool (*any)(const void *row);
    /* Returns false if the record of this row omits the column; NULL if no record does. */
    bool (*defined)(const void *row);
    /* Adds the field `key` to the record, for values that no column_kind describes. */
    void (*record)(struct reply *reply, const char *key, const void *row);
    int digits; /* Significant digits of a COLUMN_REAL for people; 0 stands for 3. */
    /* Function such as cell_error() that adds the cell of a COLUMN_REAL for people; NULL for the
     * usual form. */
    void (*look)(struct text_table *table, double value);
    /* Adds the cell for people of a column of any kind; NULL for the usual form. */
    void (*cell)(struct text_table *table, const void *row);
};

/* Value of pointer_offset for the member `pointer` of struct `type`. */
#define COLUMN_IN(type, pointer) (offsetof(type, pointer) + 1)

/* All columns of a result. */
struct result_columns {
    const struct result_column *column; /* [count] */
    int count;
    size_t size; /* Size [byte] of a row's struct. */
    int digits;  /* Significant digits of numbers other than integers in documents; 0 shows all. */
};

/* Initialiser for an array of columns that describe structs of `type`. */
#define RESULT_COLUMNS(array, type)                                                                \
    {                                                                                              \
        array, (int)COUNT_OF(array), sizeof(type), 0                                               \
    }

/* Adds the columns of one row to the open object. */
void reply_columns(struct reply *reply, const struct result_columns *columns, const void *row);
/* Writes each of `count` rows as a record of this kind. */
void reply_records(struct reply *reply, const char *kind, const struct result_columns *columns,
                   const void *rows, size_t count);
/* Makes a table for files, without keys, in the arena. The table does not refer to the rows, but
 * still refers to the names to which the rows point. Returns false if out of memory. */
bool columns_table(const struct result_columns *columns, const void *rows, size_t count,
                   struct arena *arena, struct table *table);
/* Adds the headings and the cells of all rows to an empty text table and sets its `columns`; `wide`
 * shows columns with COLUMN_WIDE. A failure is noted in table->failed. */
void columns_text(const struct result_columns *columns, const void *rows, size_t count, bool wide,
                  struct text_table *table);
