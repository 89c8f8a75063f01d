/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Parts that every format of the data layer shares: the lines of a file, the search for the table,
 * and the reading of its rows. A new format is one file NAME.def (its probe and read, static, then
 * its row) and its line in formats.def. Its read finds the table (text->layout, or table_find()
 * from a line of its own), corrects names and units, and calls table_rows().
 */
#pragma once

#include "modules/recording/table/load.h"

#define HEAD_LINES 4096        /* lines looked at to find the table … */
#define HEAD_BYTES (1u << 20)  /* … and bytes */
#define SHORT_NAME 48          /* a name from outside, cut for a message */
#define WARNINGS_MAX 10        /* sentences kept in a recording; more are counted */
#define TABLE_BLOCKS_MAX 1024  /* blocks of a file that are told apart */
#define TABLE_BYTES (1u << 30) /* most memory that the columns of a recording take */

struct table_line {
    struct text text; /* text without the line end */
    size_t number;    /* number in the file, counted from 1 */
};

struct table_layout {
    char separator, decimal;
    int columns;              /* 0 means that there is no table */
    const char *begin;        /* the first row … */
    size_t line;              /* … and its line, counted from 1 */
    struct text names, units; /* header lines, empty if there are none */
    char name_separator;      /* separator in these lines */
    int fields_above;         /* number of fields in the line above the rows, or 0 */
    bool ambiguous;           /* the commas could be decimal marks … */
    bool unclear;             /* … and nothing speaks against it */
    bool grouped; /* the other mark stands between thousands, also where there is only one: 1.020 */
    struct text stem; /* first part of the names of columns without one; empty means "column" */
    /* Column, counted from 1, whose decimals are not padded (0.20 is 20 of unpadded_parts = 1000
     * parts); 0 means none. */
    int unpadded;
    double unpadded_parts;
};

struct table_text {
    const char *name;        /* name of the file, made safe, for messages */
    struct text text;        /* the whole file without its byte order mark, or a block of it */
    size_t first, header;    /* numbers of its first line and of its header's, counted from 1 */
    struct table_line *head; /* the first lines */
    size_t heads;
    struct table_layout layout; /* layout of the first table */
    struct error problem;       /* reason if there is none */
};

/* Place at which a table ends and another may begin, in files that have them below each other. */
struct table_block {
    const char *begin;   /* a line of the header */
    size_t line, header; /* number of that line, counted from 1, and of the header's first line */
    size_t len;          /* bytes to the end of its rows */
    struct text name;    /* name of the run, empty if it has none */
    struct text head[3]; /* lines of the header, as the format needs them */
};

enum cell_kind { CELL_NUMBER, CELL_EMPTY, CELL_WORD, CELL_STAMP /* a date or a time of day */ };

/* Cuts the next line off *rest (lines.c). LF, CRLF, CR CR LF and CR end a line. Returns false if
 * nothing is left. */
bool table_line(struct text *rest, struct text *line);
/* Returns true for comments: # …, % …, or "; word" as sigrok-cli writes them. */
bool table_comment(struct text line);
/* Returns true for blank lines, comments, and a line drawn below the names. */
bool table_skipped(struct text line);
/* Cuts the next field off *rest, trimmed and without its quotes. Separator ' ' is any number of
 * blanks. Returns false if nothing is left. */
bool table_field(struct text *rest, char separator, struct text *field);
/* Reads a cell. *value is a number ("inf" is one), a stamp in seconds since 1970 or midnight, or
 * NAN. */
enum cell_kind table_cell(struct text field, char decimal, double *value);
/* Reads a number with marks between thousands. Returns false if it is none. */
bool table_grouped(struct text field, char decimal, double *value);
/* Returns the number of bytes of whole characters, up to `max`. */
size_t text_fitting(struct text text, size_t max);
/* Writes the text, cut and safe to show, into `output`, and returns it. */
const char *short_name(struct text text, char output[SHORT_NAME]);

/* Returns false with the error if the text is binary or empty (intake.c). */
bool refuse_binary(struct text text, const char *name, struct error *error);
/* Returns true if a table begins in the first lines (recording.c). */
bool table_begins(struct text content, const char *shown, const struct load_options *options,
                  struct error *error);

bool table_head(struct table_text *text, struct arena *arena); /* splits the first lines */

/* Calibrates the numbers of the value unless they are calibrated (calibrated.c). It is an error if
 * they were calibrated as another quantity. */
bool recording_calibrate(struct recording *recording, const struct calibration *calibration,
                         struct error *error);
/* Finds the first table at or after head[from] (layout.c). */
bool table_find(const struct table_text *text, size_t first_line,
                const struct load_options *options, struct table_layout *layout,
                struct error *error);

/* Returns true if `mark` stands between thousands in the table, also alone in a number. */
bool is_grouped(const struct table_text *text, const struct table_layout *layout, char mark);
/* Sets layout->unpadded. */
void find_unpadded(const struct table_text *text, struct table_layout *layout);
/* The number in a field of the column layout->unpadded; NAN if it is written in another way. */
double unpadded_value(struct text field, const struct table_layout *layout);

/* Functions of header.c. A header line has fields ("Time (s)" is one, also between blanks); the two
 * header lines give names and units of the columns. */
bool header_field(struct text *rest, char separator, struct text *field);
bool table_columns(const struct table_layout *layout, struct recording *recording,
                   struct error *error);
void column_unit(struct column *column, struct text unit); /* as a file spells it */
/* Reads a number that a known unit follows, as in "29.00 cm". Returns false if the cell is anything
 * else, a plain number too. */
bool number_with_unit(struct text field, char decimal, double *value, struct text *unit);
/* one of the blank-separated words, any case */
bool name_has_word(const char *name, const char *words);
/* Names of columns of uncertainties; those of another axis than the value's. */
#define ERROR_WORDS "error err xerr yerr uncertainty unc sigma sd"
#define ERROR_WORDS_ACROSS "xerr terr time t x"

/* Returns the sampling rate [Hz] that a line above the table gives ("# Sample rate: 50 Hz"), or 0
 * if none does (rate.c). */
double table_rate(const struct table_text *text);
/* Finds the number behind `key` in one of the first lines, any case, such as "Sample Interval" of
 * "Sample Interval,0.02". */
bool head_number(const struct table_text *text, const char *key, double *value, struct text *rest);

/* Reads columns and rows of the layout into the recording (rows.c); t gets the number of each row,
 * counted from 0. */
bool table_rows(const struct table_text *text, const struct table_layout *layout,
                struct recording *recording, struct error *error);
/* The read function of a format that is nothing but a table. */
bool table_read(const struct table_text *text, const struct load_options *options,
                struct recording *recording, struct error *error);

/* Separates several recordings in a file (runs.c). `part` finds the run's name in a column's name.
 */
bool runs_of_columns(struct recording *recording, bool (*part)(struct text name, struct text *run),
                     struct error *error);
bool run_find(const struct recording *recording, struct text wanted, int *run, struct error *error);
/* "Run #1 = taken, Run #2" */
void run_list(const struct recording *recording, struct buffer *text);
/* Runs below each other without a header between them: the clock goes back to where it began. Keeps
 * the rows of the run that is wanted, else of the first. Needs the times [s]. */
bool take_run_below(struct recording *recording, const struct load_options *options,
                    struct error *error);
typedef int table_blocks(const struct table_text *text, struct table_block *block,
                         struct load_options *options);
typedef bool table_block_read(const struct table_text *part, const struct table_block *block,
                              struct recording *recording, struct error *error);
/* Reads tables below each other. `find` gives the blocks (at most TABLE_BLOCKS_MAX, or 0 for an
 * ordinary table) and what the header says about separators; the one wanted, else the first with a
 * table, is given to `read` as a text of its own. */
bool runs_of_blocks(const struct table_text *text, const struct load_options *options,
                    struct recording *recording, table_blocks *find, table_block_read *read,
                    struct error *error);

/* Functions of choose.c and time.c choose the columns and take time [s] and value [SI] from them.
 */
/* Returns the format that is surest of the text, except `but`, which may be NULL. */
const struct format *format_of(const struct table_text *text, const struct format *but);
bool recording_choose(struct recording *recording, const struct load_options *options,
                      struct error *error);
/* Returns the column that is a clock by its name or unit, else the first if it has no name, or -1
 * if there is none. */
int recording_clock(const struct recording *recording);
/* returns the column that counts the rows, or -1 */
int recording_counter(struct recording *recording);
bool enough_rows(const struct recording *recording, struct error *error); /* two are the least */
/* Returns true if the numbers rise in every row, by nearly the same step in nine of ten. */
bool rises_evenly(const double *value, size_t n);
/* Returns true if they never fall and lie along a straight line over the rows, as the stamps of a
 * coarse clock do, which repeat. */
bool is_along_line(const double *value, size_t n);
/* Returns true if a count starts again whenever it is full, as one of 8 bits does: it does not
 * number the rows. */
bool count_wraps(const double *value, size_t n);
/* Moves on the times behind a clock that was set back, where the rows before and after are evenly
 * apart, and adds a warning. */
void mend_clock_jumps(struct recording *recording);
/* Lets the counts of a clock continue where it started again because it was full, and says so. A
 * column below 0 is none. */
void unwrap_clock(struct recording *recording, int column);
double recording_median_step(const struct recording *recording); /* [s]; the times are numbers */
/* Sets dt from all stamps. */
void recording_set_step(struct recording *recording);
void recording_reverse(struct recording *recording); /* the last row first */
bool recording_time(struct recording *recording, const struct load_options *options,
                    struct error *error);

void recording_warn(struct recording *recording, const char *format, ...) PRINTF_LIKE(2, 3);
