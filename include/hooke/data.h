/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * data: recordings from instruments (formats, units, windows) and tables written to files.
 */
#ifndef HOOKE_DATA_H
#define HOOKE_DATA_H

#include <hooke/base.h>

/* ---- series: what analysis works on, whether measured or simulated ---- */

struct series {
    const double *t; /* [s] increasing */
    const double *y; /* SI; no NaN */
    size_t n;
    enum quantity quantity;      /* of y */
    const struct cancel *cancel; /* ends what is done with it; NULL: nobody can */
    double pace; /* relative uncertainty that all its times have in common; 0: none is known */
};

/* ---- recordings ---- */

struct column {
    char name[LIMIT_NAME + 1]; /* as in the file, made safe: "distance", "Dist Error" */
    char unit[16];             /* as in the file, "" if it says nothing */
    enum quantity quantity;    /* QUANTITY_OTHER: unit unknown, values taken as they are */
    double factor;             /* SI value = number in the file * factor */
    double *value;             /* [rows] numbers as in the file; NAN: missing */
    int run;                   /* of recording.run, where runs stand side by side; -1: of all */
};

enum time_source {
    TIME_COLUMN,
    TIME_INDEX /* an index column and rate= */,
    TIME_RATE /* no column at all */
};

/*
 * What is known of lines that were collected as they came: the file has the time at which each
 * arrived before it. Where the device sends no times of its own, those of the samples lie on the
 * robust line through the arrivals, unless these are too uneven for one.
 */
enum collected_clock { CLOCK_DEVICE, CLOCK_ARRIVAL, CLOCK_UNEVEN };

/* What a sensor reads, and what is true: the straight line through two points. Compared and kept
 * byte by byte: what is not used is 0. */
struct calibration {
    double read[2], truth[2]; /* numbers in these units: */
    char unit[2][16];         /* of both readings and of both truths; "": none */
    bool known;               /* else values are as they come */
    bool decided;             /* somebody has said so */
};

struct collected {
    enum collected_clock clock;
    size_t lines;    /* that came, but for blank ones: the sum of the next five */
    size_t samples;  /* rows with a value */
    size_t skipped;  /* before the first sample: text, a heading, half a line */
    size_t garbled;  /* later ones that are no sample, or have none in the chosen column */
    size_t repeated; /* with the time of the one before */
    size_t remarks;
    size_t lost;     /* that must have been between those that came … */
    bool lost_known; /* … if that can be told; else there may be more */
    bool by_rate;    /* nobody sends times: those of rate= */
    /* [Hz] of the samples; value NAN: not known. [s] of the arrivals about the line: standard
     * deviation, and the largest */
    struct measured rate;
    double jitter, largest;
    double last;           /* [s] arrival of the last line */
    struct text statement; /* that collected it, as its file says; empty: nobody has said */
    struct calibration calibration; /* as its file says */
};

/* One of several recordings in a file, side by side (columns) or below each other (blocks). */
struct recording_run {
    char name[LIMIT_NAME + 1]; /* as users see it: "Run #2", "Latest", "segment 3" */
};

struct recording {
    char name[LIMIT_NAME + 1]; /* what users call it */
    char *path;
    char format[32];       /* the row that read it */
    const char *container; /* what it was packed in ("zip", "xlsx" …); NULL: plain text */
    uint64_t sum;          /* bytes_sum() of its file; 0: that is larger than SUMMED_BYTES */
    size_t rows;           /* after what was dropped */
    size_t dropped;        /* rows in the file that could not be used */
    struct column *column;
    int columns;
    struct recording_run *run;
    int runs, taken; /* runs 0: the file knows of none; taken: the one that was read */
    int time, value; /* chosen columns; time -1: TIME_RATE */
    enum time_source source;
    double rate;         /* [1/s] 1/dt */
    double header_rate;  /* [1/s] what the file says above its table, 0: nothing */
    double header_start; /* [s] and when the first sample was taken */
    /* these are better than the times beside the values, which are rounded or counts */
    bool header_rules;
    double dt; /* [s] of the line through all stamps where they are even, else the mean step */
    /* relative standard uncertainty of dt that rounded stamps leave; 0: they are exact */
    double pace;
    int header_lines;
    char separator;       /* '\t' ',' ';' ' ', '\n': a single column */
    char decimal;         /* '.' ',' */
    char **warning;       /* sentences: what is odd about the file, with counts and line numbers */
    int warnings;         /* at most 10, and one that says how many more kinds there are */
    int unsaid;           /* these */
    double window[2];     /* [s] the part in use, in the file's time; the whole file by default */
    double zero;          /* SI, subtracted from the value; 0 by default */
    struct measured mass; /* [kg] of what hung on the spring; 0: nobody has said */
    /* name of the recording that holds the sensor's velocities; "": none */
    char velocity[LIMIT_NAME + 1];
    size_t repeated, backward; /* rows among the dropped ones whose time repeats or goes back */
    const struct findings *findings; /* NULL: nobody has looked yet */
    bool cleaned;                    /* what the findings mask is left out */
    double *t;                       /* [rows] time [s], rising; NAN never */
    double *y;      /* [rows] chosen value in SI, zero not yet subtracted; NAN: missing */
    uint32_t *line; /* [rows] line of the file, counted from 1 */
    const struct collected *collected; /* NULL: it was not */
    struct calibration calibration;    /* that its values have gone through */
    const struct cancel *cancel;       /* as when it was loaded */
    struct arena arena; /* owns all but the arrays of rows: column[].value, t, y, line */
};

#define SUMMED_BYTES ((size_t)128 << 20)

struct load_options {
    struct text time, value;             /* column name, or number counted from 1; empty: choose */
    const struct unit *unit, *time_unit; /* NULL: what the file says */
    double rate;                         /* [Hz] 0: not given */
    char decimal, separator;             /* 0: find out */
    struct text name;                    /* as=NAME; empty: from the file name */
    const struct cancel *cancel;         /* NULL: nobody ends it */
    /* instead of what its file says; NULL: that */
    const struct calibration *calibration;
    struct text run; /* run=NAME or number; empty: the first with data in it */
};

/* One format = one file in src/data ending in its row. */
struct table_text; /* the file's text and lines, private */
struct format {
    struct row row;
    bool any;   /* takes what no other does */
    bool whole; /* its read chooses the columns and makes the times, too */
    int (*probe)(const struct table_text *text); /* 0: not mine … 100: certain */
    bool (*read)(const struct table_text *text, const struct load_options *options,
                 struct recording *recording, struct error *error);
};

extern const struct catalog format_catalog;

/* Reads a file. Binary files, files without a table, without time and rate are refused with the
 * reason and what to type. */
struct recording *recording_load(const char *path, const struct load_options *options,
                                 struct error *error);
void recording_destroy(struct recording *recording);
/* "swing3.txt: distance [cm], 480 rows, 0..9.58 s, 50 Hz; tab, 2 header lines" and the warnings, a
 * line each. */
void recording_describe(const struct recording *recording, struct buffer *text);
bool recording_window(struct recording *recording, double from, double to, struct error *error);
void recording_restore(struct recording *recording); /* whole file, every sample, zero 0 */
/* The part in use without missing or masked values, zero subtracted; arrays from `arena`. At least
 * `min` samples or an error. */
bool recording_series(const struct recording *recording, struct arena *arena, size_t min,
                      struct series *series, struct error *error);
/*
 * The uncertainties of these samples, all of the recording: of the file's column of errors of the
 * value, by its name (error, yerr, uncertainty, sigma, sd …) and unit. NULL without one, and where
 * 100 samples or more have the same: that is a calibration, no scatter (the lab's sensor writes
 * 0.239 cm on every row). Array from `arena`; false: no memory.
 */
bool recording_errors(const struct recording *recording, const struct series *series,
                      struct arena *arena, const double **half);

/* ---- files of what was collected ----
 *
 * COLLECTED_HEAD and a version, a comment with the statement that made it, then each line as
 * "ARRIVAL<TAB>LINE", seconds since the first of them began to be waited for. Bytes of a line that
 * are no text stand as \xHH, what was cut off as "\...": such a line is garbled.
 */

#define COLLECTED_HEAD "# hooke collect 1"
#define COLLECTED_STATEMENT "# statement: "
#define COLLECTED_CALIBRATION "# calibration: " /* the last one counts */
#define COLLECTED_PAUSE "# pause"               /* between lines: what came there was not wanted */
#define COLLECTED_LINE 1024                     /* [byte] of a line that are kept */

/* Appends one that came, without its end, to the text of the file. */
void collected_put(struct buffer *file, double arrival, struct text line);
/* From text of such a file, all of it or its head and its last lines. */
struct recording *collected_read(struct text text, const struct load_options *options,
                                 struct error *error);

#define GROWING_ROWS 16384 /* beyond them every second one goes, again and again */

/* Where a recording that grows has come to. */
struct lengthening {
    size_t stride;           /* so many rows came for each that is kept */
    size_t capacity;         /* [row] of its arrays */
    size_t last_row;         /* counted from 0: the newest that came … */
    uint32_t line;           /* … its line */
    double t;                /* [s] and its time */
    struct collected *known; /* of the recording */
};

/* Clocks that count from the first line that was read, dates among them: they count as those did by
 * which that line of the file was at t [s]. */
void recording_join_clock(struct recording *more, uint32_t line, double t);
/* From a recording that was read whole. False: no memory. */
bool growth_begin(struct lengthening *growth, struct recording *recording);
/*
 * Adds what came: `more` was read from the last lines of the same file, which overlap with those of
 * before; its line numbers count from the file's beginning. Where the samples have no times of
 * their own, the overlap takes the newer ones. *other: these are other columns, nothing was added.
 * False: no memory.
 */
bool recording_grow(struct recording *recording, struct lengthening *growth, struct recording *more,
                    bool *other);

/* Numbers with or without a unit, NULL, at the beginning of *rest, which then begins behind them;
 * how many, `max` at most. */
int calibration_values(struct text *rest, double *value, const struct unit **unit, int max);
/* From READ1 TRUE1 READ2 TRUE2. Error: units of different kinds, no two points. */
bool calibration_make(const double value[4], const struct unit *const unit[4],
                      struct calibration *calibration, struct error *error);
/* "19.6 cm 20 cm 39.1 cm 40 cm", "off" */
void calibration_put(const struct calibration *calibration, struct buffer *text);
/* From what that wrote; anything else: off. */
void calibration_take_line(struct text line, struct calibration *calibration);
/* Truth for each reading, in their units. */
double calibration_gain(const struct calibration *calibration);

/* ---- what is wrong with a recording ---- */

enum finding_kind {
    FINDING_SPIKES,    /* missed echoes: one or two samples far from their neighbours */
    FINDING_SHOULDERS, /* double echoes: more of them in a row, on one side */
    FINDING_STUCK,     /* the same value again and again while it should move */
    FINDING_CLIPPED,   /* flat tops */
    FINDING_QUANTISED, /* few different values */
    FINDING_START,     /* rest, hand or release before the free oscillation */
    FINDING_END,       /* rest or a hand after it */
    FINDING_GAPS,
    FINDING_MISSING, /* rows without a value */
    FINDING_REPEATED,
    FINDING_BACKWARD,
    FINDING_SWAY, /* the amplitude goes up and down */
    FINDINGS
};

enum remedy {
    REMEDY_MASK,
    REMEDY_WINDOW,
    REMEDY_KEEP,
    REMEDY_DROPPED /* when the file was read */
};

struct finding_row {
    struct row row; /* name, unit "", what it is */
    enum remedy remedy;
    const char *done; /* in words */
};

extern const struct catalog finding_catalog; /* at the enum's place */

#define FINDING_STRETCHES 3

struct finding {
    size_t count;     /* samples; of gaps and times: rows */
    size_t stretches; /* stretches that they form */
    /* [s] where the first of these begin; NAN where there are fewer */
    double first[FINDING_STRETCHES];
    /* SI: largest deviation; of a clipped top its level, of steps their size, of a gap its
     * length [s], of sway the modulation (rms, relative); NAN: does not apply */
    double size;
};

struct findings {
    struct finding of[FINDINGS];
    unsigned char *mask; /* [rows] 0: fine; else 1 + the kind that masks it */
    size_t masked;
    double window[2];   /* [s] the part in which it swings freely */
    double rests;       /* [s] from when on nothing moves any more; NAN: it moves to the end */
    double period;      /* [s] it was inspected with; NAN: none */
    double sway_period; /* [s] NAN: not known */
    char still[160];    /* why it does not oscillate; "": it does, or nobody has said */
};

/*
 * Looks at the whole file, whatever its window is, once; the result belongs to the recording.
 * period [s]: about that of the oscillation (to a few percent); NAN: it has none, then only what
 * needs none is looked for, and `still` says why. False: no memory.
 */
bool recording_inspect(struct recording *recording, double period, const char *still,
                       struct error *error);
/* Takes back what was found at the ends: the window is then the whole file. */
void recording_keep_ends(struct recording *recording);
/* Masks what the findings say; the window becomes theirs, unless somebody has chosen one. Values
 * are never invented. */
void recording_clean(struct recording *recording);
/* "cleaned: 7 of 523 samples masked (5 in spikes, 2 in stuck)" and a newline; nothing where it was
 * not cleaned. */
void recording_describe_masked(const struct recording *recording, struct buffer *text);

/* A unit in any spelling that headers of files have ("in", "um", "m/s²"), in the arena; NULL: none.
 * False: no memory. */
bool unit_spelled(struct text text, struct arena *arena, const struct unit **unit);

/* Samples of a motion; those count whose mask [n] is `wanted`. */
struct motion_rows {
    const double *t, *y;
    const unsigned char *mask;
    unsigned char wanted;
    size_t n;
};

/* The first sample from which on nothing is seen to move, for two periods at least and two after
 * the start; n: none. */
size_t motion_quiet(const struct motion_rows *rows, double period);

/* The same where a damped sine through what was before would still be seen: dry friction, a hand, a
 * stop. n: none. */
size_t motion_rest(const struct motion_rows *rows, double period);

#endif
