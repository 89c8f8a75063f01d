/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings from files: recording_load() reads one, recording_inspect() looks for defects in it,
 * recording_clean() masks them. Formats of instruments are rows of format_catalog. */
#pragma once

#include <hooke/base/row.h>
#include <hooke/data.h>

struct cancel;
struct catalog;
struct unit;

/* Largest file [byte] whose checksum is computed. */
#define SUMMED_BYTES ((size_t)128 << 20)

/* Choices of the user for a file; empty or 0 leaves a choice to the program. */
struct load_options {
    /* Name of the column of times and of values, or its number counted from 1; empty lets the
     * program choose. */
    struct text time, value;
    const struct unit *unit, *time_unit; /* NULL takes the file's units */
    double rate;                         /* [Hz] sampling rate; 0 if not given */
    char decimal, separator;             /* 0 lets the program detect it */
    struct text name;                    /* name of the recording; empty takes that of the file */
    const struct cancel *cancel;         /* may be NULL */
    /* Replaces the calibration of the file unless NULL. */
    const struct calibration *calibration;
    struct text run; /* name or number of a run; empty takes the first one with data */
};

/* The file's text and lines (table.h). */
struct table_text;
/* A file format. Each is one file, src/modules/NAME/formats/FORMAT.def, that ends in its row. */
struct format {
    struct row row;
    bool any;   /* takes a table that no other format recognises */
    bool whole; /* read() also chooses the columns and makes the times */
    int (*probe)(const struct table_text *text); /* returns 0 (another format) to 100 (certain) */
    bool (*read)(const struct table_text *text, const struct load_options *options,
                 struct recording *recording, struct error *error);
};

extern const struct catalog format_catalog;
/* Finds a format by exact name or alias. Returns NULL if there is none. */
const struct format *format_by_name(struct text name);
/* Returns row i of the catalog, or NULL past its end. */
const struct format *format_at(size_t i);

/* Reads a file; options may be NULL. Binary files and files without a table, or without times and
 * rate, are refused with the reason and a hint what to type. Returns NULL with the error if it
 * cannot be read. The caller destroys the recording. */
struct recording *recording_load(const char *path, const struct load_options *options,
                                 struct error *error);
/* Appends a description, such as "swing3.txt: distance [cm], 480 rows, 0..9.58 s, 50 Hz; tab, 2
 * header lines", then columns, runs and warnings, each on a line. */
void recording_describe(const struct recording *recording, struct buffer *text);
/* Sets *half [n] to the standard uncertainties of the series' samples (SI), from the file's column
 * of errors, which is recognised by its name (error, yerr, uncertainty, sigma, sd …) and quantity.
 * Sets it to NULL if there is no such column, or if 100 samples or more have the same error: that
 * is an uncertainty of calibration and no scatter. The array is from `arena`. Returns false if out
 * of memory. */
bool recording_errors(const struct recording *recording, const struct series *series,
                      struct arena *arena, const double **half);
/* First line of files that `collect` writes. */
#define COLLECTED_HEAD "# hooke collect 1"
/* Reads text of such a file: all of it, or its head and its last lines. Returns NULL with the
 * error. */
struct recording *collected_read(struct text text, const struct load_options *options,
                                 struct error *error);

/* ---- what is wrong with a recording ---- */

/* Action taken on the rows of a finding: masked, cut off by the window, none, or dropped when the
 * file was read. */
enum remedy { REMEDY_MASK, REMEDY_WINDOW, REMEDY_KEEP, REMEDY_DROPPED };

/* A kind of defect. */
struct finding_row {
    struct row row; /* name, unit "", and description */
    enum remedy remedy;
    const char *done; /* the remedy in words */
};

/* Kinds of findings, in the order of the enum. */
extern const struct catalog finding_catalog;

/* Searches the whole file for defects, whatever the window is. It is done once; the findings belong
 * to the recording. period [s] is that of the oscillation to a few percent; with NAN, only defects
 * that need no period are searched for, and `still` tells why. Returns false with the error if out
 * of memory or cancelled. */
bool recording_inspect(struct recording *recording, double period, const char *still,
                       struct error *error);
/* Discards the findings at the ends, so that the window is the whole file. */
void recording_keep_ends(struct recording *recording);
/* Masks the samples of the findings and cuts the window to the findings at the ends, unless the
 * user has chosen one. Values are never invented. */
void recording_clean(struct recording *recording);
/* Appends a line such as "cleaned: 7 of 523 samples masked (5 in spikes, 2 in stuck)", or nothing
 * if the recording was not cleaned. */
void recording_describe_masked(const struct recording *recording, struct buffer *text);

/* Finds a unit in any spelling that headers of files use ("in", "um", "m/s²"). Sets *unit to a copy
 * in the arena, or to NULL if the spelling is unknown. Returns false if out of memory. */
bool unit_spelled(struct text text, struct arena *arena, const struct unit **unit);

/* Samples of a motion [n]; those whose mask equals `wanted` count. */
struct motion_rows {
    const double *t, *y;
    const unsigned char *mask;
    unsigned char wanted;
    size_t n;
};

/* Returns the first sample from which on no motion is visible, at least two periods long and two
 * periods after the start, or n if there is none. period is in seconds. */
size_t motion_quiet(const struct motion_rows *rows, double period);

/* Returns the same sample, but only if a damped sine fitted to the samples before would still be
 * visible there, so that dry friction, a hand or a stop has ended the motion; else n. */
size_t motion_rest(const struct motion_rows *rows, double period);
