/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * An oscillation followed window by window: phase and amplitude of local least-squares sines on a
 * local parabola, the frequency of one window taken from the phases of those before. Nothing is
 * assumed about the whole: frequency, amplitude and baseline may drift, and the motion may come to
 * rest.
 */
#ifndef HOOKE_ANALYSIS_PERIOD_TRACK_H
#define HOOKE_ANALYSIS_PERIOD_TRACK_H

#include "analysis/internal.h"

struct track_window {
    size_t from, to;  /* samples [from, to) */
    double t;         /* [s] its middle */
    double omega;     /* [rad/s] of the sine that was fitted */
    double amplitude; /* as y */
    double phase;     /* [rad] at t, counted through */
    double sigma;     /* [rad] of the phase, from the residuals of the window */
    /* [rad] of the phase from where the windows before expected it; NAN: nothing was expected */
    double off;
    double mean;      /* of the samples */
    double explained; /* sum of squares that the sine takes off what the parabola left */
    double rss;       /* sum of squares that is left */
    size_t used;
    bool clear; /* the sine stands out of what is left */
};

struct track {
    struct track_window *window; /* [windows] */
    size_t windows, clear;
    double periods; /* per window, as asked for */
    double omega;   /* [rad/s] mean over the clear windows, by their phases */
    /* mean cosine of `off`, weighted by amplitude: 1 for an oscillation, about 0 for chance */
    double coherence;
    /* of the variance about the baseline, in the windows from the first to the last clear one */
    double fraction;
    double explained; /* sum of squares */
};

/*
 * Windows of so many periods of omega (more where there are few samples a period). False: no
 * memory.
 */
bool track_follow(const struct samples *samples, double omega, double periods, struct arena *arena,
                  struct track *track);

/*
 * The oscillation of the recording, from the peaks of its spectrum on, in the narrowest windows
 * that show one; omega is NAN where there is none. False: no memory.
 */
bool track_find(const struct samples *samples, struct arena *arena, struct track *track);

/* One pass over all samples with the frequency that they have at the time `at`. False: no memory.
 */
bool track_from(const struct samples *samples, double omega, double periods, double at,
                struct arena *arena, struct track *track);

bool track_is_oscillation(const struct track *track);

/* Of a long recording, from a part of it and from means of neighbours: one pass over all samples.
 * False: no memory. */
bool track_long(const struct samples *samples, struct arena *arena, struct track *track);

/*
 * The period from the weighted line through the phases of the clear windows; its uncertainty from
 * their scatter about the line, whatever made it. A warning where the phases bend. False: too few
 * windows.
 */
bool track_period(const struct track *track, struct arena *arena, struct period *period);

/*
 * Returns how much longer the period of a span [s] may seem than it is, relative to it, where the
 * decay rate r = -A'/A rises by `rise` [1/s] over it: as under dry friction, which delays the phase
 * by up to 1.8 r/omega (linear and quadratic drag do not).
 */
double friction_delay(double rise, double omega, double span);

/* Adds to the uncertainty that the period may be up to `late` [s] too long, with a warning where
 * that is most of it. */
void period_widen_by_friction(struct period *period, double late);

#endif
