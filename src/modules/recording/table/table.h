/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that all formats share: the lines of a file, the search for the table, and the reading
 * of its rows. A new format is one file NAME.def (its probe and read, static, then its row). Its
 * read function finds the table (text->layout, or table_find() from a line it knows), corrects
 * names and units, and calls table_rows(). */
#pragma once

#include "modules/recording/table/load.h"

/* Lines, and bytes, that are searched for the start of the table. */
#define HEAD_LINES 4096
#define HEAD_BYTES (1u << 20)
#define SHORT_NAME 48          /* bytes of a foreign name in a message, with the final 0 */
#define WARNINGS_MAX 10        /* warnings kept in a recording; more are counted */
#define TABLE_BLOCKS_MAX 1024  /* blocks of a file that are distinguished */
#define TABLE_BYTES (1u << 30) /* largest memory for the columns of a recording */

/* A line of a file. */
struct table_line {
    struct text text; /* text without the line end */
    size_t number;    /* number in the file, counted from 1 */
};

/* Position of a table in its file, and the way its rows are written. */
struct table_layout {
    char separator, decimal;
    int columns; /* 0 if there is no table */
    /* First row, and the number of its line, counted from 1. */
    const char *begin;
    size_t line;
    struct text names, units; /* header lines, empty if there are none */
    char name_separator;      /* separator within the header lines */
    int fields_above;         /* number of fields in the line above the rows, 0 if none */
    /* The commas may be decimal marks: if ambiguous, they are read as separators with a warning; if
     * unclear, the table is refused. */
    bool ambiguous;
    bool unclear;
    /* The other mark separates thousands, even if there is only one: 1.020 is 1020. */
    bool grouped;
    /* First part of the names of unnamed columns; empty means "column". */
    struct text stem;
    /* Column, counted from 1, whose decimals are not padded (0.20 is 20 of 1000 unpadded_parts); 0
     * if there is none. */
    int unpadded;
    double unpadded_parts;
};

/* A file's text, or a block of it, as formats read it. */
struct table_text {
    const char *name;           /* name of the file for messages, safe to show */
    struct text text;           /* the text, starting after a byte order mark */
    size_t first, header;       /* numbers of its first line and of its header's, from 1 */
    struct table_line *head;    /* the first lines */
    size_t heads;               /* number of lines in head */
    struct table_layout layout; /* layout of the first table */
    struct error problem;       /* the reason if there is no table */
};

/* One of several tables that follow each other in a file. */
struct table_block {
    const char *begin;   /* the first line of its text */
    size_t line, header; /* numbers of that line and of the first header line, from 1 */
    size_t len;          /* bytes up to the end of its rows */
    struct text name;    /* name of the run, empty if it has none */
    struct text head[3]; /* header lines, as the format uses them */
};

/* Content of a cell; a stamp is a date or a time of day. */
enum cell_kind { CELL_NUMBER, CELL_EMPTY, CELL_WORD, CELL_STAMP };

/* Cuts the next line off *rest (lines.c). A line ends in LF, CRLF, CR CR LF or CR. Returns false if
 * nothing remains. */
bool table_line(struct text *rest, struct text *line);
/* Returns true for comments: # …, % …, or "; word" as sigrok-cli writes them. */
bool table_comment(struct text line);
/* Returns true for blank lines, comments, and a rule (-----) below the names. */
bool table_skipped(struct text line);
/* Cuts the next field off *rest, trimmed and without its quotes. Separator ' ' stands for any
 * number of blanks. Returns false if nothing remains. */
bool table_field(struct text *rest, char separator, struct text *field);
/* Classifies a cell. Sets *value to the number (which may be infinite), to a stamp in seconds since
 * 1970 or since midnight, or to NAN. */
enum cell_kind table_cell(struct text field, char decimal, double *value);
/* Reads a number with marks between thousands. Returns false if it is not one. */
bool table_grouped(struct text field, char decimal, double *value);
/* Returns the number of bytes, at most `max`, that contain whole characters. */
size_t text_fitting(struct text text, size_t max);
/* Writes the text, shortened and safe to show, into `output`, and returns it. */
const char *short_name(struct text text, char output[SHORT_NAME]);

/* Returns false with the error if the text is binary or empty (container/intake.c). */
bool refuse_binary(struct text text, const char *name, struct error *error);
/* Returns true if the content is a table or a format that finds its own (load.c). `shown` is its
 * name for messages. Returns false with the error otherwise. */
bool table_begins(struct text content, const char *shown, const struct load_options *options,
                  struct error *error);

/* Splits the first lines into text->head. Returns false if out of memory. */
bool table_head(struct table_text *text, struct arena *arena);

/* Applies a calibration to the numbers of the value column, unless they are calibrated already
 * (calibrated.c). Returns false with the error if it is for another quantity. */
bool recording_calibrate(struct recording *recording, const struct calibration *calibration,
                         struct error *error);
/* Finds the first table at or after head[first_line] (layout.c). Returns false with the error if
 * there is none. */
bool table_find(const struct table_text *text, size_t first_line,
                const struct load_options *options, struct table_layout *layout,
                struct error *error);

/* Returns true if `mark` separates thousands in the table's first lines (marks.c). */
bool is_grouped(const struct table_text *text, const struct table_layout *layout, char mark);
/* Sets layout->unpadded and its parts (marks.c). */
void find_unpadded(const struct table_text *text, struct table_layout *layout);
/* Returns the number in a field of the column layout->unpadded, or NAN if it is not written so. */
double unpadded_value(struct text field, const struct table_layout *layout);

/* Cuts the next field of a header line off *rest, as table_field() does, but keeps "Time (s)"
 * together between blanks. */
bool header_field(struct text *rest, char separator, struct text *field);
/* Makes the recording's columns with names and units from the header lines (header.c). Returns
 * false with the error if out of memory. */
bool table_columns(const struct table_layout *layout, struct recording *recording,
                   struct error *error);
/* Sets the unit of a column as the file spells it; an unknown unit is kept with factor 1. */
void column_unit(struct column *column, struct text unit);
/* Reads a number followed by a known unit, as in "29.00 cm". Returns false for anything else,
 * including a plain number. */
bool number_with_unit(struct text field, char decimal, double *value, struct text *unit);
/* Returns true if the name, or a word in it, is one of the blank-separated words, in any case. */
bool name_has_word(const char *name, const char *words);
/* Names of columns of uncertainties, and of those that belong to another axis than the value's. */
#define ERROR_WORDS "error err xerr yerr uncertainty unc sigma sd"
#define ERROR_WORDS_ACROSS "xerr terr time t x"

/* Returns the sampling rate [Hz] that a line above the table gives ("# Sample rate: 50 Hz"), or 0
 * if none does (rate.c). */
double table_rate(const struct table_text *text);
/* Finds the number after `key`, in any case, in one of the first lines, such as "Sample Interval"
 * in "Sample Interval,0.02". *rest becomes the text after the number. Returns false if there is
 * none. */
bool head_number(const struct table_text *text, const char *key, double *value, struct text *rest);

/* Reads columns and rows of the layout into the recording (rows.c); recording->t gets the number of
 * each row, counted from 0. Returns false with the error if there is no table, or if cancelled or
 * out of memory. */
bool table_rows(const struct table_text *text, const struct table_layout *layout,
                struct recording *recording, struct error *error);
/* Reads a format that is nothing but a table. */
bool table_read(const struct table_text *text, const struct load_options *options,
                struct recording *recording, struct error *error);

/* Assigns the columns to runs of the recording (runs.c). `part` finds the run's name within a
 * column's name, and returns false if the column belongs to all runs. Returns false if out of
 * memory. */
bool runs_of_columns(struct recording *recording, bool (*part)(struct text name, struct text *run),
                     struct error *error);
/* Sets *run to the run with that name, number in its name, or position in the file. Returns false
 * with an error that lists the runs. */
bool run_find(const struct recording *recording, struct text wanted, int *run, struct error *error);
/* Appends the runs: "Run #1 = used, Run #2". */
void run_list(const struct recording *recording, struct buffer *text);
/* Finds runs that follow each other without a header, where the clock goes back to the start
 * (runs_below.c). Keeps only the rows of the requested run, by default the first. Needs the times
 * [s]. Returns false with the error if there is no such run. */
bool take_run_below(struct recording *recording, const struct load_options *options,
                    struct error *error);
/* Fills block [TABLE_BLOCKS_MAX] and corrects the separators in the options by what the file says.
 * Returns the number of blocks, or 0 for an ordinary table. */
typedef int table_blocks(const struct table_text *text, struct table_block *block,
                         struct load_options *options);
/* Reads the text of one block. */
typedef bool table_block_read(const struct table_text *part, const struct table_block *block,
                              struct recording *recording, struct error *error);
/* Reads a file with tables below each other (runs.c): finds the blocks, and reads the requested
 * one, by default the first with a table. */
bool runs_of_blocks(const struct table_text *text, const struct load_options *options,
                    struct recording *recording, table_blocks *find, table_block_read *read,
                    struct error *error);

/* Functions of choose.c and time.c choose the columns and take time [s] and value [SI] from them.
 */
/* Returns the format that is surest to recognise the text, except `but`, which may be NULL
 * (load.c). */
const struct format *format_of(const struct table_text *text, const struct format *but);
/* Chooses the columns of time and value (choose.c). Returns false with the error if that is not
 * possible. */
bool recording_choose(struct recording *recording, const struct load_options *options,
                      struct error *error);
/* Returns the column that is a clock by its name or unit, else the first one if it has no name, or
 * -1 if there is none (choose.c). */
int recording_clock(const struct recording *recording);
/* Returns the column that numbers the rows, or -1 if there is none (choose.c). */
int recording_counter(struct recording *recording);
/* Returns false with the error if there are fewer than two rows. */
bool enough_rows(const struct recording *recording, struct error *error);
/* Returns true if the numbers rise in every row, nine of ten by nearly the same step
 * (clock_shape.c). */
bool rises_evenly(const double *value, size_t n);
/* Returns true if the numbers never fall and lie along a straight line over the rows, as the stamps
 * of a coarse clock do, which repeat. */
bool is_along_line(const double *value, size_t n);
/* Returns true if a count starts again when it is full, as one of 8 bits does; it does not number
 * the rows then. */
bool count_wraps(const double *value, size_t n);
/* Shifts the times after each jump of a clock that was set back while rows came at even times, and
 * adds a warning (clock_jump.c). */
void mend_clock_jumps(struct recording *recording);
/* Continues the counts of a clock that restarted because its counter was full, and adds a warning.
 * Does nothing if column is negative. */
void unwrap_clock(struct recording *recording, int column);
/* Returns the median time step [s]; all times must be numbers. */
double recording_median_step(const struct recording *recording);
/* Sets dt from all time stamps. */
void recording_set_step(struct recording *recording);
/* Reverses the rows of a file that has the last row first, and adds a warning. */
void recording_reverse(struct recording *recording);
/* Makes rising times [s] and values [SI] from the chosen columns (time.c). Returns false with the
 * error. */
bool recording_time(struct recording *recording, const struct load_options *options,
                    struct error *error);

/* Adds a warning to the recording, formatted as by printf(); at most WARNINGS_MAX are kept. */
void recording_warn(struct recording *recording, const char *format, ...) PRINTF_LIKE(2, 3);
