/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines of a sensor as they came: their file, recordings of them, and how these grow. */
#pragma once

#include "modules/recording/table/table.h"

/* ---- files of what was collected ----
 *
 * COLLECTED_HEAD and a version, a comment with the statement that made it, then each line as
 * "ARRIVAL<TAB>LINE", seconds since the first of them began to be waited for. Bytes of a line that
 * are no text stand as \xHH, what was cut off as "\...": such a line is garbled.
 */

#define COLLECTED_STATEMENT "# statement: "
#define COLLECTED_CALIBRATION "# calibration: " /* the last one counts */
/* mark between lines: lines that came there were left out on purpose */
#define COLLECTED_PAUSE "# pause"
#define COLLECTED_LINE 1024 /* [byte] of a line that are kept */

/* Appends one that came, without its end, to the text of the file. */
void collected_put(struct buffer *file, double arrival, struct text line);
#define GROWING_ROWS                                                                               \
    16384 /* number of rows above which every second one is dropped, repeatedly                    \
           */

/* State of a growing recording. */
struct lengthening {
    size_t stride;           /* so many rows came for each that is kept */
    size_t capacity;         /* [row] of its arrays */
    size_t last_row;         /* counted from 0: the newest that came … */
    uint32_t line;           /* … its line */
    double t;                /* [s] and its time */
    struct collected *known; /* facts about the recording's lines */
};

/* Clocks that count from the first line that was read, dates among them: they count as those did by
 * which that line of the file was at t [s]. */
void recording_join_clock(struct recording *more, uint32_t line, double t);
/* Begins with a recording that was read completely. Returns false if out of memory. */
bool growth_begin(struct lengthening *growth, struct recording *recording);
/*
 * Adds what came: `more` was read from the last lines of the same file, which overlap with those of
 * before; its line numbers count from the file's beginning. Where the samples have no times of
 * their own, the overlap takes the newer ones. *other: these are other columns, nothing was added.
 * Returns false if out of memory.
 */
bool recording_grow(struct recording *recording, struct lengthening *growth, struct recording *more,
                    bool *other);

/* ---- times of samples from the arrivals of their lines ---- */

struct arrivals {
    const double *arrival; /* [n] [s] */
    const double *order;   /* [n] of the lines that came, rising; lost ones are not counted */
    size_t n;
    bool counted; /* the device counts its lines, so lost ones are counted in `order` */
    /* [n] true if the collection was paused before the line, so that none are lost there; NULL
     * if never */
    const bool *pause;
};
/* clock.c: [count/s] of a device's clock v [n] by the arrivals; NAN if they do not say. scratch
 * [n]. */
double clock_pace(const struct arrivals *arrivals, const double *v, double *scratch);
struct clock_mended {
    size_t starts, wraps; /* it started again, was full */
    size_t wrong;         /* stamps that are NAN now */
    bool *is_restart;     /* [n] the first one after a new start */
};
/* Lets stamps v [n] that go back continue instead if they are those of a clock (a sawtooth only if
 * `trusted`); garbled ones become NAN. Returns false if out of memory. */
bool clock_mend(const struct arrivals *arrivals, bool trusted, struct arena *arena, double *v,
                struct clock_mended *mended);
/* Lines lost between the times t [n], rising, but not before those `is_restart` (NULL if there is
 * none) a new start; not known where the steps are uneven. */
size_t clock_lost(const struct arrivals *arrivals, const double *t, const bool *is_restart,
                  double *scratch, bool *known);

/* Times [n] of the samples: fills clock, lost, rate and jitter of what is known of them. Scratch
 * from `arena`; returns false if out of memory. */
bool arrival_times(const struct arrivals *arrivals, struct arena *arena,
                   struct collected *collected, double *t);

/* Reads such a file, as its format wants it. */
bool collected_lines(const struct table_text *text, const struct load_options *options,
                     struct recording *recording, struct error *error);
