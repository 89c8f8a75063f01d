/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines of a sensor: the file that keeps them as they arrived, recordings made of them, and how
 * these grow. collected_put() writes a line; collected_lines() reads a file; growth_begin() and
 * recording_grow() extend a recording. */
#pragma once

#include "modules/recording/table/table.h"

/* ---- files of collected lines: COLLECTED_HEAD and a version, a comment with the statement that
 * made the file, then each line as "ARRIVAL<TAB>LINE"; an arrival is in seconds since collecting
 * began. Bytes that are no text are written as \xHH, the cut end of a line as "\...": such lines
 * are garbled. ---- */

#define COLLECTED_STATEMENT "# statement: "
#define COLLECTED_CALIBRATION "# calibration: " /* the last one in the file holds */
/* mark of a pause; lines that came during it were dropped on purpose */
#define COLLECTED_PAUSE "# pause"
#define COLLECTED_LINE 1024 /* [byte] longer lines are cut */

/* Appends a line that arrived at `arrival` [s], without its end, to the text of the file. */
void collected_put(struct buffer *file, double arrival, struct text line);
#define GROWING_ROWS                                                                               \
    16384 /* number of rows above which every second one is dropped, repeatedly                    \
           */

/* State of a growing recording. */
struct lengthening {
    size_t stride;           /* number of rows that came for each row that is kept */
    size_t capacity;         /* [row] of its arrays */
    size_t last_row;         /* number of the newest row that came, counted from 0 */
    uint32_t line;           /* line of the newest row */
    double t;                /* [s] time of the newest row */
    struct collected *known; /* facts about the recording's lines */
};

/* Shifts the times of `more`, whose clock counts from the first line that was read, so that the
 * given line of the file is at t [s]. */
void recording_join_clock(struct recording *more, uint32_t line, double t);
/* Begins with a recording that was read completely. Returns false if out of memory. */
bool growth_begin(struct lengthening *growth, struct recording *recording);
/* Adds new rows: `more` was read from the last lines of the same file, which overlap with those
 * before; its line numbers count from the file's beginning. If the samples have no times of their
 * own, the overlap gets the newer times. Sets *other, and adds nothing, if the columns are others.
 * Returns false if out of memory. */
bool recording_grow(struct recording *recording, struct lengthening *growth, struct recording *more,
                    bool *other);

/* ---- times of samples from the arrivals of their lines ---- */

/* Arrivals of the lines of samples. */
struct arrivals {
    const double *arrival; /* [n] [s] */
    const double *order;   /* [n] of the lines that came, rising; lost ones are not counted */
    size_t n;
    bool counted; /* the device counts its lines, so lost ones are counted in `order` */
    /* [n] true if the collection was paused before the line, so that none are lost there; NULL
     * if never */
    const bool *pause;
};
/* Returns the rate [count/s] of a device's clock v [n], measured by the arrivals, or NAN if
 * unknown. scratch is [n]. (clock.c) */
double clock_pace(const struct arrivals *arrivals, const double *v, double *scratch);
/* Results of clock_mend(). */
struct clock_mended {
    size_t starts, wraps; /* number of new starts, and of overflows of the counter */
    size_t wrong;         /* number of stamps that were replaced by NAN */
    bool *is_restart;     /* [n] the first one after a new start */
};
/* Lets stamps v [n] that go back continue instead if they are those of a clock (a sawtooth only if
 * `trusted`); garbled ones become NAN. Returns false if out of memory. */
bool clock_mend(const struct arrivals *arrivals, bool trusted, struct arena *arena, double *v,
                struct clock_mended *mended);
/* Returns the number of lines lost between the times t [n], which rise, except before a new start
 * (is_restart, or NULL). Sets *known to false if the steps are too uneven to tell. */
size_t clock_lost(const struct arrivals *arrivals, const double *t, const bool *is_restart,
                  double *scratch, bool *known);

/* Computes the times t [n] of samples from the arrivals of their lines, and sets clock, lost, rate
 * and jitter. Scratch memory comes from the arena. Returns false if out of memory. */
bool arrival_times(const struct arrivals *arrivals, struct arena *arena,
                   struct collected *collected, double *t);

/* Reads a file of collected lines into a recording, as its format. Returns false with an error. */
bool collected_lines(const struct table_text *text, const struct load_options *options,
                     struct recording *recording, struct error *error);
