/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Series of values over time, measured or simulated. */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/base/text.h>

struct cancel;

struct series {
    const double *t; /* [s] increasing */
    const double *y; /* SI; no NaN */
    size_t n;
    enum quantity quantity;      /* quantity of y */
    const struct cancel *cancel; /* ends calculations with it; NULL if nobody can */
    double pace; /* relative uncertainty that all its times have in common, or 0 if unknown */
};

/* Returns the part [from, to] of a series, which shares the memory of the whole. */
struct series series_window(struct series series, double t_begin, double t_end);
/* Standard deviation of the noise of a smooth motion, from sixth differences; NAN if there are too
 * few samples, or if out of memory. */
double series_noise(const struct series *series, struct arena *arena);

/* ---- what is found in one ---- */

/* Robust description of a series before any model is fitted. */
struct overview {
    /* offset (mid of the robust extremes, or mean over whole periods), extremes */
    double mean, low, high;
    double noise;   /* standard deviation of the noise, from differences */
    double period;  /* [s] refined estimate from the spectrum, or NAN without an oscillation */
    double periods; /* number of periods in the series, or NAN */
    bool oscillates;
    char reason[160]; /* the reason why it does not oscillate */
};

struct crossing {
    double t, uncertainty; /* [s] */
    bool rising;
};

struct period {
    struct measured period; /* [s] */
    double periods;         /* whole periods between first and last crossing used */
    double first, last;     /* [s] */
    double level;
    const char *how;   /* method of the reading, for messages */
    char warning[160]; /* reason to doubt one period for the whole series, or "" */
};

struct spectrum_peak {
    struct measured frequency; /* [Hz] */
    struct measured amplitude; /* as y */
};

/* Noise of an energy m v^2/2 + k y^2/2 from samples with noise sigma of y and gain sigma of v; all
 * members are 0 for a simulation. */
struct energy_noise {
    double floor; /* [J] mean energy that the noise adds: sigma^2 (k + m gain^2)/2 */
    /* [J^1/2] samples of an energy E scatter by spread sqrt(E): 2 sigma sqrt(k) */
    double spread;
};

/* ---- a series with a mask, on an even grid where its times are one ---- */

struct samples {
    const double *t, *y;
    size_t n;
    double t0, dt; /* [s] where uniform: t = t0 + i dt */
    bool uniform;
    double pace;                 /* relative standard uncertainty that all times have in common */
    unsigned char *use;          /* [n] 1 for samples that are fitted, 0 for rejected ones */
    bool resampled;              /* made of a very uneven series, which no sensor sends */
    const struct cancel *cancel; /* ends fits; NULL if nobody can */
};

/* Returns true if a tenth of the steps are far shorter than the mean one, as those of a stiff
 * adaptive run are. */
bool series_is_uneven(const struct series *series);
/* Prepares a series. One that series_is_uneven() is replaced by as many samples on an even grid.
 * Returns false if out of memory. */
bool samples_init(struct samples *samples, const struct series *series, struct arena *arena);
/* Sets samples[length] to the values at t0, t0 + dt, ..., by straight lines. Returns their sum. */
double series_fill_grid(const struct series *series, double t0, double dt, size_t length,
                        double *samples);
/* Standard deviation of the noise, from sixth differences; scratch [n]. Returns NAN if there are
 * too few samples. */
double samples_noise(const struct samples *samples, double *scratch);
