/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings from files: reading, describing, looking for what is wrong with them. */
#pragma once

#include <hooke/base/row.h>
#include <hooke/data.h>

struct cancel;
struct catalog;
struct unit;

#define SUMMED_BYTES ((size_t)128 << 20)

struct load_options {
    /* column name, or number counted from 1; empty lets the program choose */
    struct text time, value;
    const struct unit *unit, *time_unit; /* NULL takes what the file gives */
    double rate;                         /* [Hz] 0: not given */
    char decimal, separator;             /* 0 detects it */
    struct text name;                    /* as=NAME; empty takes the name of the file */
    const struct cancel *cancel;         /* may be NULL */
    /* replaces what the file gives unless NULL */
    const struct calibration *calibration;
    struct text run; /* run=NAME or number; empty takes the first with data in it */
};

/* One format is one file, src/modules/NAME/formats/FORMAT.def, that ends in its row. */
struct table_text; /* the file's text and lines, private */
struct format {
    struct row row;
    bool any;   /* the format takes what no other does */
    bool whole; /* read() also chooses the columns and makes the times */
    int (*probe)(const struct table_text *text); /* returns 0 (another format) to 100 (certain) */
    bool (*read)(const struct table_text *text, const struct load_options *options,
                 struct recording *recording, struct error *error);
};

extern const struct catalog format_catalog;
/* finds by exact name or alias; NULL if there is none */
const struct format *format_by_name(struct text name);
const struct format *format_at(size_t i);

/* Reads a file. Binary files, files without a table, without time and rate are refused with the
 * reason and what to type. */
struct recording *recording_load(const char *path, const struct load_options *options,
                                 struct error *error);
/* "swing3.txt: distance [cm], 480 rows, 0..9.58 s, 50 Hz; tab, 2 header lines" and the warnings, a
 * line each. */
void recording_describe(const struct recording *recording, struct buffer *text);
/*
 * Finds the uncertainties of all samples of the recording in the file's column of errors of the
 * value, by its name (error, yerr, uncertainty, sigma, sd …) and unit. The result is NULL without
 * such a column, and where 100 samples or more have the same: that is a calibration, no scatter
 * (the lab's sensor writes 0.239 cm on every row). The array is from `arena`. Returns false if out
 * of memory.
 */
bool recording_errors(const struct recording *recording, const struct series *series,
                      struct arena *arena, const double **half);
/* Begins the text of a file of what was collected. */
#define COLLECTED_HEAD "# hooke collect 1"
/* Reads text of such a file, all of it or its head and its last lines. */
struct recording *collected_read(struct text text, const struct load_options *options,
                                 struct error *error);

/* ---- what is wrong with a recording ---- */

enum remedy {
    REMEDY_MASK,
    REMEDY_WINDOW,
    REMEDY_KEEP,
    REMEDY_DROPPED /* when the file was read */
};

struct finding_row {
    struct row row; /* name, unit "", and description */
    enum remedy remedy;
    const char *done; /* the remedy in words */
};

extern const struct catalog finding_catalog; /* Kinds of findings, in the order of the enum. */

/*
 * Examines the whole file, whatever its window is, once; the result belongs to the recording.
 * period [s] is that of the oscillation to a few percent; if it is NAN only defects that need no
 * period are searched for, and `still` tells why. Returns false if out of memory or if cancelled.
 */
bool recording_inspect(struct recording *recording, double period, const char *still,
                       struct error *error);
/* Discards what was found at the ends, so that the window is the whole file. */
void recording_keep_ends(struct recording *recording);
/* Masks the samples of the findings; the window becomes theirs, unless the user has chosen one.
 * Values are never invented. */
void recording_clean(struct recording *recording);
/* Appends "cleaned: 7 of 523 samples masked (5 in spikes, 2 in stuck)" and a newline, or nothing if
 * the recording was not cleaned. */
void recording_describe_masked(const struct recording *recording, struct buffer *text);

/* Finds a unit in any spelling that headers of files have ("in", "um", "m/s²"), in the arena, or
 * NULL if there is none. Returns false if out of memory. */
bool unit_spelled(struct text text, struct arena *arena, const struct unit **unit);

/* Samples of a motion; those count whose mask [n] is `wanted`. */
struct motion_rows {
    const double *t, *y;
    const unsigned char *mask;
    unsigned char wanted;
    size_t n;
};

/* Returns the first sample from which on no motion is visible, for at least two periods and two
 * after the start, or n if there is none. */
size_t motion_quiet(const struct motion_rows *rows, double period);

/* Returns the same only if a damped sine through the samples before would still be visible there,
 * so that dry friction, a hand or a stop has ended the motion; else n. */
size_t motion_rest(const struct motion_rows *rows, double period);
