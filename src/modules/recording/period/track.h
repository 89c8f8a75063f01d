/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An oscillation followed window by window: phase and amplitude of local least-squares sines on a
 * local parabola; the frequency of a window is taken from the phases of the windows before it.
 * Nothing is assumed about the whole: frequency, amplitude and baseline may drift, and the motion
 * may come to rest. */
#pragma once

#include "modules/recording/period/cycle.h"

/* The sine in one window. */
struct track_window {
    size_t begin, end; /* samples begin to end - 1 */
    double t;          /* [s] middle of the window */
    double omega;      /* [rad/s] of the sine that was fitted */
    double amplitude;  /* unit of y */
    double phase;      /* [rad] at t, continued from window to window */
    double sigma;      /* [rad] uncertainty of the phase, from the residuals of the window */
    /* [rad] phase minus the one expected from earlier windows, or NAN if none was expected */
    double phase_error;
    double mean;      /* mean of the samples */
    double explained; /* sum of squares by which the sine reduces the residuals of the parabola */
    double rss;       /* sum of squares of the residuals */
    size_t used;
    bool clear;     /* the sine stands out of the residuals */
    bool after_gap; /* a pause of recording precedes it */
};

/* An oscillation as a sequence of windows. */
struct track {
    struct track_window *window; /* [windows] */
    size_t windows, clear;       /* numbers of all windows, and of clear ones */
    double periods;              /* requested periods per window */
    double omega;                /* [rad/s] mean over the clear windows, by their phases */
    /* Mean cosine of phase_error, weighted by amplitude: 1 for an oscillation, about 0 for
     * chance. */
    double coherence;
    /* Share of the variance about the baseline that is explained, in the windows from the first to
     * the last clear one. */
    double fraction;
    double explained; /* sum of squares that the sines explain */
};

/* Follows an oscillation of about omega [rad/s] in windows of `periods` periods (more if there are
 * few samples per period). Returns false if out of memory. */
bool track_follow(const struct samples *samples, double omega, double periods, struct arena *arena,
                  struct track *track);

/* Searches the oscillation of a recording, starting from the peaks of its spectrum, in the
 * narrowest windows that show one; track->omega is NAN if none does. Returns false if out of
 * memory. */
bool track_find(const struct samples *samples, struct arena *arena, struct track *track);

/* Returns true if the phases are so coherent that the windows show an oscillation and not
 * chance. */
bool track_is_oscillation(const struct track *track);

/* Number of rows above which a recording is followed by track_long(). */
enum { LONG_RECORD = 4096 };

/* Follows a long recording: finds its frequency in a part of it and in means of neighbours, then
 * makes one pass over all samples. Returns false if out of memory. */
bool track_long(const struct samples *samples, struct arena *arena, struct track *track);

/* Measures the period from the phases of the clear windows, with a warning if these bend, or if the
 * decay speeds up as under dry friction, which delays phases. Returns false if they are too few, or
 * if out of memory. */
bool track_period(const struct track *track, struct arena *arena, struct period *period);
