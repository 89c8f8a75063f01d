/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The period of a wave of any shape in two stages: the shift at which the series is most like
 * itself, tested against its multiples and parts, and then the times of its cycles.
 */
#pragma once

#include "modules/recording/series/internal.h"

/* ---- cycle_times.c ---- */

/* Times that rise with their numbers: whole numbers of cycles, or phases over 2 pi. */
struct cycle_times {
    double *t, *sigma, *number; /* [n] [s], [s] */
    double *deviation;          /* [n] [s] off the line */
    unsigned char *use;         /* [n] those on the line */
    unsigned char *after_gap;   /* [n] those before which nothing was recorded for a while */
    size_t n;
};

/* Allocates `capacity` times. Returns false if out of memory. */
bool cycle_times_init(struct cycle_times *times, size_t capacity, struct arena *arena);
void cycle_times_add(struct cycle_times *times, double t, double sigma, double number,
                     bool after_gap);
/*
 * Sets the period, its uncertainty, first, last and periods by the line through the times, leaving
 * out times far off it. The cycles in gaps are counted anew. Warns where the times bend, or where
 * the clock was set in a gap. If exact, the uncertainties of the times are rounding only. Returns
 * false if fewer than two are left, or if out of memory.
 */
bool times_period(struct cycle_times *times, bool exact, struct arena *arena,
                  struct period *period);
/* Returns the second derivative of t by number if it exceeds this number of standard deviations, or
 * 0 otherwise. */
double times_curvature(struct cycle_times *times, double sigmas);
/* Does the same as times_period() for crossings that are about `guess` [s] apart. Sets *used to the
 * number of those on the line. */
bool crossings_period(const struct crossing *time, size_t count, double guess, bool exact,
                      struct arena *arena, struct period *period, size_t *used);

/* ---- crossing_period.c ---- */

/* Returns false with the reason if there are fewer than two up-crossings of the mean. */
bool crossing_period(const struct series *series, const struct overview *o, struct arena *arena,
                     struct period *period, struct error *error);

enum wave_kind {
    WAVE_EXACT, /* a wave without noise, whose crossings repeat to 1 % */
    /* a perhaps noisy wave: at least 7 crossings that repeat to 1e-4, as those of noise never do */
    WAVE_NOISY,
    /* the same with any number of crossings, if nothing else is known: coarse rows of a run */
    WAVE_FEW,
};

/*
 * Reads the period of a wave of any shape: the pattern of its up-crossings of the middle between
 * its extremes repeats. Where an exact wave settles only in the course of the series, the period is
 * that of the end, with a warning. Returns false if nothing repeats or if out of memory.
 */
bool wave_period(const struct series *series, enum wave_kind kind, struct arena *arena,
                 struct period *period);

/* ---- smooth_period.c ---- */

/*
 * Reads the period of a smooth series without noise, at even times, whose crossings of one level
 * are all equally far apart: free oscillations that decay or grow, and steady waves. Returns false
 * if it is anything else, which costs a pass or two over its rows, or if out of memory.
 */
bool smooth_period(const struct series *series, struct arena *arena, struct period *period);

/* ---- lags.c ---- */

enum {
    SINC_REACH = 8,  /* samples on either side from which a value between two is computed */
    SINC_PLACES = 7, /* positions between two samples at which a peak is searched for */
};

struct lags {
    double *correlation; /* [n] autocorrelation of the series, by shift */
    double *y;           /* [n] values of the series at equal times, less a straight line */
    size_t n;
    double dt; /* [s] */
    double weight[SINC_PLACES][2 * SINC_REACH];
};

/*
 * Tabulates the correlation at all shifts: of all rows, or where a period [s] is known (not NAN) of
 * as many as show what it is after a few of them. Returns false if out of memory.
 */
bool lags_init(const struct series *series, double period, struct arena *arena, struct lags *lags);

/* Returns the shortest shift at which the series is as much like itself as at any, up to half its
 * length [s]; NAN if it is like itself at none. */
double lags_period(const struct lags *lags);

/* Returns true if the series is much like itself after a period, more than a little earlier. */
bool lags_support(const struct lags *lags, double period);

/* Returns the whole number of periods, or one over such a number, after which the series is clearly
 * more like itself than after one, or as much; 1 if it is the period itself. */
double lags_multiple(const struct lags *lags, double period);

/* ---- cycle.c ---- */

enum { CYCLES_MIN = 3 }; /* fewer cycles prove nothing */

struct cycle {
    double t, sigma;     /* [s] start of the cycle, and its uncertainty */
    double mean, height; /* y = mean + height f(phase) */
    double square, left; /* variances about its mean and about the mean cycle */
    /* rows of the mean cycle, and the sums of squares of it and of its derivative */
    double rows, power, slope;
};

struct cycles {
    const struct samples *samples;
    double period;       /* [s] */
    struct cycle *cycle; /* [count] */
    size_t count;
    double *shape;  /* [-1 to bins + 1] the mean cycle, continued around its ends */
    double *weight; /* [bins] */
    size_t bins;
};

/* Places all cycles of about `guess` [s] against their mean, roughly only where that explains far
 * less of them than share_min. Returns false if they are too few, or if out of memory. */
bool cycles_find(struct cycles *c, const struct samples *x, double guess, double share_min,
                 struct arena *arena);
/* Returns the share of the power that the mean of the other cycles explains of each. */
double cycles_explained_share(const struct cycles *c);
/* Returns the share from which on that number of cycles is alike: drift, steps and random walks
 * stay below it (tests/modules/recording/analysis/detect.c). */
double cycles_share_needed(size_t cycles);

/*
 * Reads the period from the times of whole cycles of about `guess` [s], each placed against the
 * mean of all. Returns false if the cycles are not alike, or too few, or if out of memory.
 */
bool cycle_period(const struct series *series, double guess, struct arena *arena,
                  struct period *period);

/* ---- doubt.c ---- */

/*
 * Judges a period by its cycles, one by one. Where every second or third of them differs from the
 * others, T becomes a multiple, or if chance may do so, a warning says that it may be. Widens T
 * where the cycles come at times that scatter by more than the noise.
 */
void period_doubt(const struct series *series, struct arena *arena, struct period *period);

/* ---- waves.c ---- */

/*
 * Counts the waves of a series, one by one. Where T holds several whose times differ and do not
 * repeat, or another number than it should, their mean takes its place, with a warning; where each
 * comes some random time after the one before, T is widened.
 */
void period_check_waves(const struct series *series, struct arena *arena, struct period *period);

/* Takes the mean time between the waves of a series for its period, with a warning. Returns false
 * if they come at no rhythm, or if out of memory. */
bool waves_period(const struct series *series, struct arena *arena, struct period *period);
