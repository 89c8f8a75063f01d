/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * data: recordings, which are measured rows from a file or a sensor, and what is wrong with them.
 *
 * The module `recording` makes a struct recording from a file, chooses its time and value columns,
 * and finds its faults (struct findings). recording_window() selects the part in use,
 * recording_series() copies it as a series; recording_destroy() frees a recording with all that it
 * owns.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/limit.h>
#include <hooke/data/calibration.h>
#include <hooke/data/series.h>

struct cancel;
struct unit;

/* ---- recordings ---- */

/* A column of the file. */
struct column {
    /* Name as in the file, without control characters: "distance", "Dist Error". */
    char name[LIMIT_NAME + 1];
    char unit[16]; /* Unit as in the file, "" if it gives none. */
    /* Quantity of the values. With QUANTITY_OTHER the unit is unknown and values are not converted.
     */
    enum quantity quantity;
    double factor; /* SI value = number in the file * factor. */
    double *value; /* [rows] numbers as in the file, NAN if missing; owned. */
    /* Index of the run in recording.run if the file has its runs in columns side by side; -1 for a
     * column of all runs. */
    int run;
};

/* Source of the times of a recording. */
enum time_source {
    /* A column of times. */
    TIME_COLUMN,
    /* An index column and the option rate=. */
    TIME_INDEX,
    TIME_RATE /* No column: the row number and a rate. */
};

/* Clock of a recording that was collected from a sensor: times sent by the device; a robust line
 * through the arrival times of the lines; or the arrival times themselves, if they are too uneven
 * for a line. */
enum collected_clock { CLOCK_DEVICE, CLOCK_ARRIVAL, CLOCK_UNEVEN };

/* Facts about a recording that was collected from a sensor. Its file has the arrival time before
 * each line. */
struct collected {
    enum collected_clock clock;
    size_t lines;    /* Lines received, without blank ones: the sum of the next five. */
    size_t samples;  /* Number of samples, which are rows with a value. */
    size_t skipped;  /* Lines before the first sample: text, a heading, half a line. */
    size_t garbled;  /* Later lines that are no sample, or have none in the chosen column. */
    size_t repeated; /* Lines with the same time as the previous one. */
    /* Comment lines. */
    size_t remarks;
    size_t lost;     /* Number of lines that must have been lost between those received. */
    bool lost_known; /* `lost` is certain; otherwise there may be more. */
    bool by_rate;    /* There are no times: they follow from the option rate=. */
    /* [Hz] rate of the samples; its value is NAN if unknown. [s] standard and largest deviation of
     * the arrivals from the line. */
    struct measured rate;
    double jitter, largest;
    double last; /* [s] arrival time of the last line */
    /* Statement that collected it, according to its file; empty if the file has none. */
    struct text statement;
    struct calibration calibration; /* Calibration according to its file. */
};

/* One of several runs of an experiment in a file, side by side (columns) or below each other
 * (blocks). */
struct recording_run {
    char name[LIMIT_NAME + 1]; /* Name for users: "Run #2", "Latest", "segment 3". */
};

/* A recording. Rows that could not be used are dropped; times increase. */
struct recording {
    char name[LIMIT_NAME + 1]; /* Name by which users call it. */
    /* Path of the file; the arena's. */
    char *path;
    char format[32];       /* Name of the format that read it. */
    const char *container; /* Container of the file ("zip", "xlsx", …), or NULL for plain text. */
    uint64_t sum;          /* bytes_sum() of its file, or 0 if that has more than SUMMED_BYTES. */
    size_t rows;           /* Number of rows, without dropped ones. */
    size_t dropped;        /* Number of rows in the file that could not be used. */
    /* [columns] columns of the file. */
    struct column *column;
    int columns;
    /* [runs] runs in the file. */
    struct recording_run *run;
    /* Number of runs in the file (0 if it has no runs), and index of the one that was read. */
    int runs, taken;
    int time, value; /* Indices of the chosen columns; time is -1 with TIME_RATE. */
    enum time_source source;
    double rate;         /* [1/s] sampling rate, 1/dt */
    double header_rate;  /* [1/s] sampling rate that the header of the file states, or 0 */
    double header_start; /* [s] time of the first sample that the header states */
    /* The header's rate is better than the column of times, which is rounded or counts samples. */
    bool header_rules;
    /* [s] sampling interval: slope of the line through all time stamps if they are even, else the
     * mean step */
    double dt;
    /* Relative standard uncertainty of dt due to the rounding of time stamps; 0 if they are exact.
     */
    double pace;
    /* Number of lines above the table. */
    int header_lines;
    char separator; /* Separator of cells: '\t', ',', ';', ' ', or '\n' for a single column. */
    char decimal;   /* Decimal sign, '.' or ','. */
    /* [warnings] sentences about peculiarities of the file, with counts and line numbers. */
    char **warning;
    int warnings; /* Number of sentences: at most 10, and one that counts the remaining kinds. */
    int unsaid;   /* Number of remaining kinds of warnings. */
    double window[2];     /* [s] part in use, in the file's time; the whole file by default */
    double zero;          /* [SI] zero that is subtracted from the values; 0 by default */
    struct measured mass; /* [kg] mass on the spring; 0 if not set */
    /* Name of the recording that holds the sensor's velocities, or "" if there is none. */
    char velocity[LIMIT_NAME + 1];
    size_t repeated, backward;       /* Numbers of dropped rows whose time repeats or goes back. */
    const struct findings *findings; /* Faults; NULL if they have not been searched for. */
    bool cleaned;                    /* Samples masked by the findings are left out. */
    double *t;                       /* [rows] time [s], increasing, never NAN; owned */
    double *y; /* [rows] chosen value [SI] before `zero` is subtracted, NAN if missing; owned */
    uint32_t *line; /* [rows] line of the file, counted from 1; owned */
    /* Facts of collecting, or NULL if it was loaded from another file. */
    const struct collected *collected;
    struct calibration calibration; /* Calibration that was applied to its values. */
    const struct cancel *cancel;    /* Flag that stops computations with it; may be NULL. */
    /* Owner of everything but the arrays of rows: column[].value, t, y, line. */
    struct arena arena;
};

/* Frees a recording with everything that it owns; NULL is allowed. */
void recording_destroy(struct recording *recording);
/* Selects the part from t_begin to t_end [s]; NAN stands for the first or last time. Returns false,
 * with `error` set and nothing changed, if it has no samples. */
bool recording_window(struct recording *recording, double t_begin, double t_end,
                      struct error *error);
/* Selects the whole file with all samples, sets the zero to 0 and forgets the sensor's velocities.
 */
void recording_restore(struct recording *recording);
/* Copies the part in use, without missing or masked values and with the zero subtracted, to a
 * series in the arena. Returns false, with `error` set, if it has fewer than `min` samples or if
 * out of memory. */
bool recording_series(const struct recording *recording, struct arena *arena, size_t min,
                      struct series *series, struct error *error);

/* ---- faults of a recording ---- */

/* Kinds of faults. */
enum finding_kind {
    FINDING_SPIKES,    /* Missed echoes: one or two samples far from their neighbours. */
    FINDING_SHOULDERS, /* Double echoes: more of them in a row, on one side. */
    FINDING_STUCK,     /* The same value repeated while it should change. */
    FINDING_CLIPPED,   /* Flat tops. */
    FINDING_QUANTISED, /* Few different values: coarse resolution. */
    FINDING_START,     /* Rest, hand or release before the free oscillation. */
    FINDING_END,       /* Rest or a hand after it. */
    /* Gaps in time. */
    FINDING_GAPS,
    FINDING_MISSING, /* Rows without a value. */
    /* Times that repeat. */
    FINDING_REPEATED,
    /* Times that go back. */
    FINDING_BACKWARD,
    FINDING_SWAY, /* The amplitude rises and falls: swaying. */
    /* Number of kinds. */
    FINDINGS
};

/* Number of places that are remembered of each kind. */
#define FINDING_STRETCHES 3

/* The faults of one kind. */
struct finding {
    size_t count;     /* Number of samples, or of rows for gaps and times. */
    size_t stretches; /* Number of contiguous stretches that they form. */
    /* [s] beginnings of the first stretches, NAN beyond their number */
    double first[FINDING_STRETCHES];
    /* Size [SI]: the largest deviation; the level of a clipped top; the size of steps; the length
     * of a gap [s]; or the relative modulation of sway (rms). NAN if it does not apply. */
    double size;
};

/* The result of a search for faults; part of its recording. */
struct findings {
    struct finding finding[FINDINGS];
    unsigned char *mask; /* [rows] 0 for a good sample, else 1 + the kind that masks it */
    /* Number of masked samples. */
    size_t masked;
    double window[2];   /* [s] part in which it swings freely */
    double rests;       /* [s] time from which it is at rest; NAN if it moves to the end */
    double period;      /* [s] period that the search assumed; NAN if there is none */
    double sway_period; /* [s] period of the sway; NAN if unknown */
    /* Reason why it does not oscillate, or "" if it does or has not been examined. */
    char still[160];
};
