/* SPDX-License-Identifier: GPL-3.0-or-later */
/* series: values of one quantity over time, measured or simulated, and the results of measurements
 * on them. A series owns nothing: its arrays belong to an arena or a run. */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/base/text.h>

struct cancel;

/* Times and values of one quantity. */
struct series {
    const double *t; /* [n] times [s], increasing */
    const double *y; /* [n] values [SI], never NAN */
    size_t n;
    enum quantity quantity;      /* Quantity of y. */
    const struct cancel *cancel; /* Flag that stops calculations with the series; may be NULL. */
    /* Relative standard uncertainty that all times t have in common, such as that of the sampling
     * rate; 0 if unknown. */
    double pace;
};

/* Returns the part of a series from t_begin to t_end [s], which shares the memory of the series. */
struct series series_window(struct series series, double t_begin, double t_end);
/* Returns the standard deviation of the noise on a smooth motion, from sixth differences, or NAN if
 * there are too few samples or if out of memory. Work memory is the arena's. */
double series_noise(const struct series *series, struct arena *arena);

/* ---- results of measurements on a series ---- */

/* Robust description of a series before any model is fitted. */
struct overview {
    /* Offset (middle of the robust extremes, or mean over whole periods), and extremes. */
    double mean, low, high;
    double noise;     /* Standard deviation of the noise, from differences of samples. */
    double period;    /* Period [s], estimated from the spectrum; NAN without an oscillation. */
    double periods;   /* Number of periods in the series, or NAN. */
    bool oscillates;  /* An oscillation was found. */
    char reason[160]; /* Reason why no oscillation was found, or "". */
};

/* A crossing of a level. */
struct crossing {
    double t, uncertainty; /* Time [s] and its standard uncertainty [s]. */
    bool rising;           /* The crossing is upwards. */
};

/* A measured period. */
struct period {
    struct measured period; /* Period [s]. */
    double periods;         /* Number of periods between the first and the last crossing used. */
    double first, last;     /* Times [s] of these crossings. */
    /* Level [SI] whose crossings were used. */
    double level;
    const char *how;   /* Method of the measurement, for messages; a constant. */
    char warning[160]; /* Reason to doubt that one period describes the whole series, or "". */
};

/* A line of a spectrum. */
struct spectrum_peak {
    struct measured frequency; /* [Hz] */
    struct measured amplitude; /* Amplitude, in the unit of y. */
};

/* Noise of an energy m v^2/2 + k y^2/2 that is computed from samples whose noise has the standard
 * deviations sigma of y and gain*sigma of v. All members are 0 for a simulation. */
struct energy_noise {
    double floor; /* [J] mean energy that the noise adds: sigma^2 (k + m gain^2)/2 */
    /* [J^1/2] samples of an energy E scatter by spread sqrt(E): 2 sigma sqrt(k) */
    double spread;
};

/* ---- samples: a series with a mask, on an even grid of times if its times are even ---- */

/* A series as fits use it; its arrays are the series' or the arena's. */
struct samples {
    /* [n] times [s] and values [SI]. */
    const double *t, *y;
    size_t n;
    double t0, dt;               /* First time and step [s] if `uniform`. */
    bool uniform;                /* The times are even: sample i has the time t0 + i dt. */
    double pace;                 /* Relative standard uncertainty that all times have in common. */
    unsigned char *use;          /* [n] 1 for samples that are fitted, 0 for rejected ones */
    bool resampled;              /* Samples were interpolated, see series_is_uneven(). */
    const struct cancel *cancel; /* Flag that stops fits; may be NULL. */
};

/* Returns true if more than a tenth of the steps are shorter than 1/20 of the mean step, as in
 * stiff adaptive runs. */
bool series_is_uneven(const struct series *series);
/* Fills *samples from a series. If series_is_uneven() returns true, the samples are interpolated on
 * an even grid with the same number of samples. Memory is the arena's or the series'. Returns false
 * if out of memory or if cancelled. */
bool samples_init(struct samples *samples, const struct series *series, struct arena *arena);
/* Sets samples [length] to the values of a series at t0, t0 + dt, … [s], by linear interpolation.
 * Beyond the ends of the series the first or last value is used. Returns the sum of the samples. */
double series_fill_grid(const struct series *series, double t0, double dt, size_t length,
                        double *samples);
/* Returns the standard deviation of the noise, from the median of sixth differences, which ignores
 * single spikes, or NAN if there are too few samples. scratch [n] is work memory. */
double samples_noise(const struct samples *samples, double *scratch);
