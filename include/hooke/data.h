/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * data: recordings from instruments (formats, units, windows) and tables written to files.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/limit.h>
#include <hooke/data/calibration.h>
#include <hooke/data/series.h>

struct cancel;
struct unit;

/* ---- recordings ---- */

struct column {
    char name[LIMIT_NAME + 1]; /* as in the file, made safe: "distance", "Dist Error" */
    char unit[16];             /* as in the file, "" if it says nothing */
    /* Quantity of the values. With QUANTITY_OTHER the unit is unknown and the values are not
     * converted. */
    enum quantity quantity;
    double factor; /* SI value = number in the file * factor */
    double *value; /* [rows] numbers as in the file; NAN if missing */
    /* Index into recording.run where runs are columns beside each other, or -1 for a column of
     * all runs. */
    int run;
};

enum time_source {
    TIME_COLUMN,
    TIME_INDEX /* an index column and rate= */,
    TIME_RATE /* no column at all */
};

/*
 * Facts about lines that were collected as they arrived; the file has the arrival time before each
 * line. Where the device sends no times of its own, the sample times lie on a robust line through
 * the arrivals, unless these are too uneven.
 */
enum collected_clock { CLOCK_DEVICE, CLOCK_ARRIVAL, CLOCK_UNEVEN };

struct collected {
    enum collected_clock clock;
    size_t lines;    /* that came, but for blank ones: the sum of the next five */
    size_t samples;  /* rows with a value */
    size_t skipped;  /* lines before the first sample: text, a heading, half a line */
    size_t garbled;  /* later ones that are no sample, or have none in the chosen column */
    size_t repeated; /* lines with the same time as the previous one */
    size_t remarks;
    size_t lost;     /* that must have been between those that came … */
    bool lost_known; /* … if that can be told; else there may be more */
    bool by_rate;    /* nobody sends times: those of rate= */
    /* [Hz] of the samples; value NAN: not known. [s] of the arrivals about the line: standard
     * deviation, and the largest */
    struct measured rate;
    double jitter, largest;
    double last; /* [s] arrival of the last line */
    /* Statement that collected it, according to its file, or empty if the file has none. */
    struct text statement;
    struct calibration calibration; /* as its file says */
};

/* One of several recordings in a file, side by side (columns) or below each other (blocks). */
struct recording_run {
    char name[LIMIT_NAME + 1]; /* as users see it: "Run #2", "Latest", "segment 3" */
};

struct recording {
    char name[LIMIT_NAME + 1]; /* name that users call it by */
    char *path;
    char format[32];       /* the row that read it */
    const char *container; /* packing of the file ("zip", "xlsx" …), or NULL for plain text */
    uint64_t sum;          /* bytes_sum() of its file; 0 if that is larger than SUMMED_BYTES */
    size_t rows;           /* rows that are left after the dropped ones */
    size_t dropped;        /* rows in the file that could not be used */
    struct column *column;
    int columns;
    struct recording_run *run;
    /* runs is the number of runs in the file, or 0 if it has no runs; taken is the one that was
     * read. */
    int runs, taken;
    int time, value; /* chosen columns; time -1: TIME_RATE */
    enum time_source source;
    double rate;         /* [1/s] 1/dt */
    double header_rate;  /* [1/s] what the file says above its table, 0 if there is nothing */
    double header_start; /* [s] and when the first sample was taken */
    /* these are better than the times beside the values, which are rounded or counts */
    bool header_rules;
    double dt; /* [s] of the line through all stamps where they are even, else the mean step */
    /* relative standard uncertainty of dt that rounded stamps leave; 0 if they are exact */
    double pace;
    int header_lines;
    char separator;   /* '\t' ',' ';' ' ', '\n': a single column */
    char decimal;     /* '.' ',' */
    char **warning;   /* sentences about peculiarities of the file, with counts and line numbers */
    int warnings;     /* number of sentences: at most 10, and one that counts the remaining kinds */
    int unsaid;       /* remaining kinds of warnings */
    double window[2]; /* [s] the part in use, in the file's time; the whole file by default */
    double zero;      /* SI, subtracted from the value; 0 by default */
    struct measured mass; /* [kg] of what hung on the spring; 0 if nobody has said */
    /* Name of the recording that holds the sensor's velocities, or "" if there is none. */
    char velocity[LIMIT_NAME + 1];
    size_t repeated, backward; /* rows among the dropped ones whose time repeats or goes back */
    const struct findings *findings; /* NULL if nobody has looked yet */
    bool cleaned;                    /* samples that the findings mask are left out */
    double *t;                       /* [rows] time [s], rising; NAN never */
    double *y;      /* [rows] chosen value in SI, zero not yet subtracted; NAN if missing */
    uint32_t *line; /* [rows] line of the file, counted from 1 */
    const struct collected *collected; /* NULL if it was not */
    struct calibration calibration;    /* that its values have gone through */
    const struct cancel *cancel;       /* as when it was loaded */
    struct arena arena; /* owns all but the arrays of rows: column[].value, t, y, line */
};

void recording_destroy(struct recording *recording);
bool recording_window(struct recording *recording, double t_begin, double t_end,
                      struct error *error);
void recording_restore(struct recording *recording); /* whole file, every sample, zero 0 */
/* The part in use without missing or masked values, zero subtracted; arrays from `arena`. At least
 * `min` samples or an error. */
bool recording_series(const struct recording *recording, struct arena *arena, size_t min,
                      struct series *series, struct error *error);

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

#define FINDING_STRETCHES 3

struct finding {
    size_t count;     /* samples; of gaps and times: rows */
    size_t stretches; /* stretches that they form */
    /* [s] where the first of these begin; NAN where there are fewer */
    double first[FINDING_STRETCHES];
    /* Size in SI: the largest deviation; the level of a clipped top, the size of steps, the
     * length of a gap [s], or the modulation of sway (rms, relative). NAN if it does not apply. */
    double size;
};

struct findings {
    struct finding finding[FINDINGS];
    unsigned char *mask; /* [rows] 0: fine; else 1 + the kind that masks it */
    size_t masked;
    double window[2];   /* [s] the part in which it swings freely */
    double rests;       /* [s] from when on nothing moves any more; NAN if it moves to the end */
    double period;      /* [s] it was inspected with; NAN if there is none */
    double sway_period; /* [s] NAN: not known */
    /* The reason why it does not oscillate, or "" if it does or has not been inspected. */
    char still[160];
};
