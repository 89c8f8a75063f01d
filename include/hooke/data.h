/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * data: recordings, which are measured rows from a file or a sensor, and their faults.
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
    char unit[16]; /* Unit as in the file, "" if the file gives none. */
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
    TIME_COLUMN, /* A column of times. */
    TIME_INDEX,  /* A column of indices, divided by the sampling rate of the option rate=. */
    TIME_RATE    /* The number of the row, divided by a sampling rate; no column. */
};

/* Source of the times of a recording that was collected from a sensor. CLOCK_DEVICE stands for
 * times that the device sent, CLOCK_ARRIVAL for a robust straight line through the arrival times of
 * the samples, CLOCK_UNEVEN for the arrival times themselves, which are too uneven for a line. */
enum collected_clock { CLOCK_DEVICE, CLOCK_ARRIVAL, CLOCK_UNEVEN };

/* Facts about a recording that was collected from a sensor. Its file has the arrival time before
 * each line. */
struct collected {
    enum collected_clock clock; /* Source of the times. */
    size_t lines;               /* Lines received, without blank ones: the sum of the next five. */
    size_t samples;  /* Number of samples, which are lines with a value in the chosen column. */
    size_t skipped;  /* Lines before the first sample, such as text, a heading, half a line. */
    size_t garbled;  /* Later lines without a value in the chosen column. */
    size_t repeated; /* Lines with the same time as the previous one. */
    size_t remarks;  /* Comment lines. */
    size_t lost;     /* Number of lines that must have been lost between those received. */
    bool lost_known; /* No more than `lost` lines were lost; otherwise there may be more. */
    bool by_rate;    /* Times follow from the option rate=, since lines contain none. */
    /* Rate of the samples [Hz], NAN if unknown. Below it, the standard and the largest deviation
     * [s] of arrival times from the straight line of CLOCK_ARRIVAL. */
    struct measured rate;
    double jitter, largest; /* Standard and largest deviation [s]. */
    double last;            /* Arrival time [s] of the last line. */
    /* Statement that collected the recording, as its file quotes it; empty if there is none. */
    struct text statement;
    struct calibration calibration; /* Calibration that the file of the recording states. */
};

/* One of several runs of an experiment in a file, side by side (columns) or below each other
 * (blocks). */
struct recording_run {
    char name[LIMIT_NAME + 1]; /* Name for users: "Run #2", "Latest", "segment 3". */
};

/* A recording. Rows that could not be used are dropped; times increase. */
struct recording {
    char name[LIMIT_NAME + 1]; /* Name of the recording in commands. */
    /* Path of the file; the arena's. */
    char *path;
    char format[32];       /* Name of the format by which the file was read. */
    const char *container; /* Container of the file ("zip", "xlsx", …), or NULL for plain text. */
    /* bytes_sum() of the file, or 0 if the file has more than SUMMED_BYTES bytes. */
    uint64_t sum;
    size_t rows;    /* Number of rows, without dropped ones. */
    size_t dropped; /* Number of rows in the file that could not be used. */
    /* [columns] columns of the file. */
    struct column *column;
    int columns;
    /* [runs] runs (repetitions of the experiment) in the file. */
    struct recording_run *run;
    /* Number of runs (0 if the file does not separate runs), and index of the run that was read. */
    int runs, taken;
    int time, value; /* Indices of the chosen columns; time is -1 with TIME_RATE. */
    enum time_source source;
    double rate;         /* Sampling rate [1/s], 1/dt. */
    double header_rate;  /* Sampling rate [1/s] that the header of the file states, or 0. */
    double header_start; /* Time [s] of the first sample that the header states. */
    /* Times follow from header_rate instead of the column of times, because the column is rounded
     * or counts samples. */
    bool header_rules;
    /* Sampling interval [s]: the slope of the line through all time stamps if they are even, else
     * the mean step. */
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
    int warnings;         /* Number of sentences: at most 10, and one that counts further ones. */
    int unsaid;           /* Number of kinds of warnings beyond these 10. */
    double window[2];     /* Begin and end [s] of the part in use, in the file's time. */
    double zero;          /* Value [SI] that is subtracted from the values; 0 by default. */
    struct measured mass; /* Mass [kg] on the spring; 0 if not set. */
    /* Name of the recording that holds the sensor's velocities, or "" if there is none. */
    char velocity[LIMIT_NAME + 1];
    size_t repeated, backward;       /* Numbers of dropped rows whose time repeats or goes back. */
    const struct findings *findings; /* Faults; NULL if they have not been searched for. */
    bool cleaned;                    /* Samples that findings->mask marks are left out. */
    double *t;                       /* [rows] time [s], increasing, never NAN; owned */
    double *y; /* [rows] chosen value [SI] before `zero` is subtracted, NAN if missing; owned */
    uint32_t *line; /* [rows] line of the file, counted from 1; owned */
    /* Facts about the collection from a sensor; NULL for a recording of another origin. */
    const struct collected *collected;
    struct calibration calibration; /* Calibration that was applied to the values. */
    const struct cancel *cancel; /* Flag that stops computations with the recording; may be NULL. */
    /* Owner of all memory except the arrays of rows: column[].value, t, y, line. */
    struct arena arena;
};

/* Frees a recording with everything that it owns; NULL is allowed. */
void recording_destroy(struct recording *recording);
/* Selects the part from t_begin to t_end [s] for use; NAN stands for the first or last time.
 * Returns false, with `error` set and nothing changed, if the part has no samples. */
bool recording_window(struct recording *recording, double t_begin, double t_end,
                      struct error *error);
/* Selects the whole file with all samples, sets the zero to 0 and forgets the sensor's velocities.
 */
void recording_restore(struct recording *recording);
/* Copies the part in use, without missing or masked values and with the zero subtracted, to a
 * series in the arena. Returns false, with `error` set, if the series has fewer than `min`
 * samples or if out of memory. */
bool recording_series(const struct recording *recording, struct arena *arena, size_t min,
                      struct series *series, struct error *error);

/* ---- faults of a recording ---- */

/* Kinds of faults. */
enum finding_kind {
    FINDING_SPIKES,    /* Missed echoes: one or two samples far from their neighbours. */
    FINDING_SHOULDERS, /* Double echoes: more far samples in a row, all on the same side. */
    FINDING_STUCK,     /* A value that repeats although the motion continues. */
    FINDING_CLIPPED,   /* Flat tops, where the range of the sensor ends. */
    FINDING_QUANTISED, /* Few different values, since the resolution is coarse. */
    FINDING_START,     /* Rest, a hand or the release before the free oscillation. */
    FINDING_END,       /* Rest or a hand after the free oscillation. */
    FINDING_GAPS,      /* Gaps in time. */
    FINDING_MISSING,   /* Rows without a value. */
    FINDING_REPEATED,  /* Times that repeat. */
    FINDING_BACKWARD,  /* Times that go back. */
    FINDING_SWAY,      /* Swaying, by which the amplitude rises and falls. */
    FINDINGS           /* Number of kinds. */
};

/* Number of stretches of each kind whose times are stored. */
#define FINDING_STRETCHES 3

/* The faults of one kind. */
struct finding {
    size_t count;     /* Number of faulty samples; of rows for gaps and times. */
    size_t stretches; /* Number of stretches of successive samples that they form. */
    /* Times [s] at which the first stretches begin; NAN if there are fewer stretches. */
    double first[FINDING_STRETCHES];
    /* Size of the fault, by its kind: the largest deviation [SI], the level of a clipped top [SI],
     * the resolution [SI], the length of a gap [s], or the relative modulation by sway (rms). NAN
     * for other kinds. */
    double size;
};

/* The result of a search for faults of a recording, which owns it. */
struct findings {
    struct finding finding[FINDINGS];
    unsigned char *mask; /* [rows] 0 for a good sample, else 1 + enum finding_kind. */
    size_t masked;       /* Number of samples that are not good. */
    double window[2];    /* Begin and end [s] of the free oscillation. */
    double rests;        /* Time [s] from which the body is at rest; NAN if it moves to the end. */
    double period;       /* Period [s] that the search assumed; NAN if there is none. */
    double sway_period;  /* Period [s] of the sway; NAN if unknown. */
    /* Reason why the body does not oscillate, or "" if it does or has not been examined. */
    char still[160];
};
