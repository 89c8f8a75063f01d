/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a wave of any shape in two stages: the lag at which the series resembles itself
 * most, tested against its multiples and fractions, and then the times of its cycles.
 * series_period() in period.c calls the functions below. */
#pragma once

#include "modules/recording/series/internal.h"

/* ---- cycle_times.c ---- */

/* Times that rise with their numbers, which count cycles: whole numbers, or phases over 2 pi. */
struct cycle_times {
    /* [n] times [s], their uncertainties [s], and their numbers. */
    double *t, *sigma, *number;
    double *deviation;        /* [n] [s] distance from the line */
    unsigned char *use;       /* [n] 1 for times that are not far off the line */
    unsigned char *after_gap; /* [n] 1 for times with a pause of recording before them */
    size_t n;
};

/* Allocates `capacity` times, none of them set. Returns false if out of memory. */
bool cycle_times_init(struct cycle_times *times, size_t capacity, struct arena *arena);
/* Appends a time; there must be capacity for it. */
void cycle_times_add(struct cycle_times *times, double t, double sigma, double number,
                     bool after_gap);
/* Sets the period, its uncertainty, first, last and periods by the straight line through the times,
 * leaving out times far off it. Cycles in gaps are counted anew. Warns if the times bend, or if the
 * clock was set in a gap. If `exact`, the uncertainties of the times are rounding only. Returns
 * false if fewer than two times are left, or if out of memory. */
bool times_period(struct cycle_times *times, bool exact, struct arena *arena,
                  struct period *period);
/* Returns the second derivative of t by number if it exceeds that number of standard deviations,
 * else 0. */
double times_curvature(struct cycle_times *times, double sigmas);
/* Does the same as times_period() for `count` crossings about `guess` [s] apart. Sets *used to the
 * number of crossings on the line. */
bool crossings_period(const struct crossing *time, size_t count, double guess, bool exact,
                      struct arena *arena, struct period *period, size_t *used);

/* ---- crossing_period.c ---- */

/* Reads the period from the up-crossings of the mean. Returns false with the error if there are
 * fewer than two. */
bool crossing_period(const struct series *series, const struct overview *o, struct arena *arena,
                     struct period *period, struct error *error);

/* Regularity that wave_period() requires. */
enum wave_kind {
    WAVE_EXACT, /* a wave without noise, whose crossings repeat to 1 % */
    /* A wave that may be noisy: at least 7 crossings that repeat to 1e-4, which noise never
     * does. */
    WAVE_NOISY,
    /* The same with any number of crossings, if nothing else is known: coarse rows of a run. */
    WAVE_FEW,
};

/* Reads the period of a wave of any shape, if the pattern of its up-crossings of the middle between
 * its extremes repeats. If an exact wave becomes regular only in the course of the series, the
 * period is that of the end, with a warning. Returns false if nothing repeats or if out of
 * memory. */
bool wave_period(const struct series *series, enum wave_kind kind, struct arena *arena,
                 struct period *period);

/* ---- smooth_period.c ---- */

/* Reads the period of a smooth series without noise, at even times, whose crossings of one level
 * are all equally far apart: free oscillations that decay or grow, and steady waves. Returns false
 * for anything else, which costs one or two passes over the rows, or if out of memory. */
bool smooth_period(const struct series *series, struct arena *arena, struct period *period);

/* ---- lags.c ---- */

enum {
    SINC_REACH = 8,  /* samples on either side that are used to interpolate */
    SINC_PLACES = 7, /* positions between two samples at which a peak is searched */
};

/* Autocorrelation of a series. */
struct lags {
    double *correlation; /* [n] autocorrelation of the series, by shift */
    double *y;           /* [n] values at equal times, less a straight line */
    size_t n;
    double dt; /* [s] */
    /* Weights of the interpolation at each of the positions. */
    double weight[SINC_PLACES][2 * SINC_REACH];
};

/* Computes the correlation at all lags: of all rows or, if a period [s] is known (not NAN), of a
 * selection that shows what the series resembles after a few periods. Returns false if out of
 * memory or if there are too few rows. */
bool lags_init(const struct series *series, double period, struct arena *arena, struct lags *lags);

/* Returns the shortest lag [s] at which the series resembles itself as much as at any lag up to
 * half its length, or NAN if it never does. */
double lags_period(const struct lags *lags);

/* Returns true if the series resembles itself after a period [s], more than a little earlier. */
bool lags_support(const struct lags *lags, double period);

/* Returns the whole number n of periods, or the fraction 1/n of a period, after which the series
 * clearly resembles itself more than after one (or, for a fraction, as much); 1 if it is the period
 * itself. */
double lags_multiple(const struct lags *lags, double period);

/* ---- cycle.c ---- */

/* Smallest number of cycles that can show a period. */
enum { CYCLES_MIN = 3 };

/* One cycle, placed against the mean cycle. */
struct cycle {
    double t, sigma;     /* [s] start of the cycle, and its uncertainty */
    double mean, height; /* y = mean + height f(phase), f the mean cycle */
    double square, left; /* variance of its rows about their mean, and about the mean cycle */
    /* Number of its rows; sums over them of the mean cycle squared and of its derivative
     * squared. */
    double rows, power, slope;
};

/* All cycles of a series, and their mean shape. */
struct cycles {
    const struct samples *samples;
    double period;       /* [s] */
    struct cycle *cycle; /* [count] */
    size_t count;
    double *shape;  /* [-1 to bins + 1] the mean cycle, continued around its ends */
    double *weight; /* [bins] weight of the rows in each bin */
    size_t bins;
};

/* Places all cycles of about `guess` [s] against their mean; only roughly if that explains far less
 * of them than share_min. Returns false if they are too few, or if out of memory. */
bool cycles_find(struct cycles *c, const struct samples *x, double guess, double share_min,
                 struct arena *arena);
/* Returns the share of the power of each cycle that the mean of the others explains. */
double cycles_explained_share(const struct cycles *c);
/* Returns the share from which on that number of cycles counts as alike: drift, steps and random
 * walks stay below it (tests/modules/recording/analysis/detect.c). */
double cycles_share_needed(size_t cycles);

/* Reads the period from the times of whole cycles of about `guess` [s], each placed against the
 * mean of all. Returns false if the cycles are not alike or too few, or if out of memory. */
bool cycle_period(const struct series *series, double guess, struct arena *arena,
                  struct period *period);

/* ---- doubt.c ---- */

/* Judges a period by its cycles, one by one. If every second or third of them differs from the
 * others, T becomes a multiple or, if that may be chance, a warning says so. Widens T if the times
 * of the cycles scatter by more than the noise. */
void period_doubt(const struct series *series, struct arena *arena, struct period *period);

/* ---- waves.c ---- */

/* Counts the waves of a series, one by one. If T contains several whose times differ and do not
 * repeat, or another number than it should, their mean time replaces T, with a warning. If each
 * wave comes a random time after the previous one, T is widened. */
void period_check_waves(const struct series *series, struct arena *arena, struct period *period);

/* Takes the mean time between the waves of a series as its period, with a warning. Returns false if
 * the waves have no rhythm, or if out of memory. */
bool waves_period(const struct series *series, struct arena *arena, struct period *period);
