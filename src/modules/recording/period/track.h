/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * An oscillation followed window by window: phase and amplitude of local least-squares sines on a
 * local parabola, the frequency of one window taken from the phases of those before. Nothing is
 * assumed about the whole: frequency, amplitude and baseline may drift, and the motion may come to
 * rest.
 */
#pragma once

#include "modules/recording/period/cycle.h"

struct track_window {
    size_t begin, end; /* samples [from, to) */
    double t;          /* [s] its middle */
    double omega;      /* [rad/s] of the sine that was fitted */
    double amplitude;  /* as y */
    double phase;      /* [rad] at t, counted through */
    double sigma;      /* [rad] of the phase, from the residuals of the window */
    /* [rad] phase less that expected from the windows before, or NAN if nothing was expected */
    double phase_error;
    double mean;      /* mean of the samples */
    double explained; /* sum of squares by which the sine reduces the residuals of the parabola */
    double rss;       /* sum of squares that is left */
    size_t used;
    bool clear;     /* the sine stands out of what is left */
    bool after_gap; /* nothing was recorded for a while before it */
};

struct track {
    struct track_window *window; /* [windows] */
    size_t windows, clear;
    double periods; /* requested periods per window */
    double omega;   /* [rad/s] mean over the clear windows, by their phases */
    /* mean cosine of `off`, weighted by amplitude: 1 for an oscillation, about 0 for chance */
    double coherence;
    /* Share of the variance about the baseline, in the windows from the first to the last clear
     * one. */
    double fraction;
    double explained; /* sum of squares */
};

/*
 * Follows the oscillation in windows of `periods` periods of omega (more if there are few samples
 * per period). Returns false if out of memory.
 */
bool track_follow(const struct samples *samples, double omega, double periods, struct arena *arena,
                  struct track *track);

/*
 * Follows the oscillation of the recording, starting from the peaks of its spectrum, in the
 * narrowest windows that show one; omega is NAN if none does. Returns false if out of memory.
 */
bool track_find(const struct samples *samples, struct arena *arena, struct track *track);

bool track_is_oscillation(const struct track *track);

enum { LONG_RECORD = 4096 }; /* rows from which on a recording is followed by track_long() */

/* Follows a long recording by a part of it and by means of neighbours, in one pass over all
 * samples. Returns false if out of memory. */
bool track_long(const struct samples *samples, struct arena *arena, struct track *track);

/*
 * Reads the period from the phases of the clear windows, with a warning where these bend, or where
 * the decay speeds up as under dry friction, which delays phases. Returns false if they are too
 * few, or if out of memory.
 */
bool track_period(const struct track *track, struct arena *arena, struct period *period);
