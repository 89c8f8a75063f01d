/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Series: what is known over time, whether measured or simulated. */
#ifndef HOOKE_DATA_SERIES_H
#define HOOKE_DATA_SERIES_H

#include <hooke/base/quantity.h>
#include <hooke/base/text.h>

struct cancel;

struct series {
    const double *t; /* [s] increasing */
    const double *y; /* SI; no NaN */
    size_t n;
    enum quantity quantity;      /* of y */
    const struct cancel *cancel; /* ends what is done with it; NULL if nobody can */
    double pace; /* relative uncertainty that all its times have in common; 0: none is known */
};

/* The part [from, to] of a series; shares memory. */
struct series series_window(struct series series, double from, double to);
/* Standard deviation of the noise of a smooth motion, from sixth differences; NAN if there are too
 * few samples, or if out of memory. */
double series_noise(const struct series *series, struct arena *arena);

/* ---- what is found in one ---- */

/* What the series looks like before any model: NaN-free, robust. */
struct overview {
    /* offset (mid of the robust extremes, or mean over whole periods), extremes */
    double mean, low, high;
    double noise;   /* standard deviation of the noise, from differences */
    double period;  /* [s] first estimate from the spectrum, refined; NAN: does not oscillate */
    double periods; /* how many of them the series holds */
    bool oscillates;
    char reason[160]; /* why not */
};

struct crossing {
    double t, uncertainty; /* [s] */
    bool up;
};

struct period {
    struct measured period; /* [s] */
    double periods;         /* whole periods between first and last crossing used */
    double first, last;     /* [s] */
    double level;
    const char *how;   /* what it was read from, for messages */
    char warning[160]; /* what makes one number for the whole doubtful; "": nothing */
};

struct spectrum_peak {
    struct measured frequency; /* [Hz] */
    struct measured amplitude; /* as y */
};

/* Of an energy m v^2/2 + k y^2/2 from samples with noise sigma of y and gain sigma of v; all 0: of
 * a simulation. */
struct energy_noise {
    double floor; /* [J] what the noise adds on average: sigma^2 (k + m gain^2)/2 */
    /* [J^1/2] a sample of E scatters by spread sqrt(E) about that: 2 sigma sqrt(k) */
    double spread;
};

/* ---- a series with a mask, on an even grid where its times are one ---- */

struct samples {
    const double *t, *y;
    size_t n;
    double t0, dt; /* [s] where uniform: t = t0 + i dt */
    bool uniform;
    double pace;                 /* relative standard uncertainty that all times have in common */
    unsigned char *use;          /* [n] 1: takes part in fits, 0: rejected */
    bool resampled;              /* made of a very uneven series, which no sensor sends */
    const struct cancel *cancel; /* ends fits; NULL if nobody can */
};

/* Returns true if a tenth of the steps are far shorter than the mean one, as those of a stiff
 * adaptive run are. */
bool series_is_uneven(const struct series *series);
/* Prepares a series. One that series_is_uneven() is replaced by as many samples on an even grid.
 * Returns false if out of memory. */
bool samples_init(struct samples *samples, const struct series *series, struct arena *arena);
/* Sets out[length] to the values at t0, t0 + dt, ..., by straight lines. Returns their sum. */
double series_fill_grid(const struct series *series, double t0, double dt, size_t length,
                        double *out);
/* Standard deviation of the noise, from sixth differences; scratch [n]. Returns NAN if there are
 * too few samples. */
double samples_noise(const struct samples *samples, double *scratch);

#endif
