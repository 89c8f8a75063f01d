/* SPDX-License-Identifier: GPL-3.0-or-later */
/* cursor: the two cursors A and B: the run or recording on which they are, and their movements.
 * Call ground_open(), move them, then cursor_settle(). */
#pragma once

#include <hooke/plot.h>

/* A point to which cursors snap: a crossing or a peak. */
struct snap_point {
    double t, uncertainty, y; /* Time [s], its uncertainty [s], and value [SI]. */
    /* Number of the up-crossing, from 1, or 0. */
    int crossing;
};

/* The run or recording on which the cursors are; memory is the arena's. */
struct ground {
    /* Name, such as "run 1" or "data swing3". */
    char name[LIMIT_NAME + 16];
    bool data;                /* True for a recording, false for a run. */
    struct series series;     /* Values that the cursors read. */
    struct overview overview; /* Period, noise and extremes of the series. */
    /* [crossings] upward crossings of the equilibrium, and [peaks] peaks, each searched for only if
     * cursors snap to them. */
    struct snap_point *crossing, *peak;
    size_t crossings, peaks; /* Numbers of points found. */
    struct arena *arena;     /* Owner of these arrays. */
};

/* Fills *ground with the current recording if session->view.cursors.on_data, else with the current
 * run, or with the other one if only that exists. Returns false, with `error` set, if there is
 * neither. */
bool ground_open(struct session *session, struct arena *arena, struct ground *ground,
                 struct error *error);
double ground_spacing(const struct ground *ground); /* Returns the mean time [s] between samples. */
/* Moves cursor `which` (0 for A, 1 for B) to time t [s], or to the nearest point to which cursors
 * snap if that is within `reach` [s] of t. */
void cursor_put(struct cursors *cursors, const struct ground *ground, int which, double t,
                double reach);
/* Moves the active cursor to the next (forward) or previous crossing, or to a peak if cursors snap
 * to peaks. Returns false, with `error` set, if there is none. */
bool cursor_jump(struct cursors *cursors, const struct ground *ground, bool forward,
                 struct error *error);
/* Moves B to n periods after A. Returns false, with `error` set, if the series has no period or is
 * too short. */
bool cursor_span(struct cursors *cursors, const struct ground *ground, double n,
                 struct error *error);
/* Moves A and B to the first and the last point to which they snap or, without such points, to both
 * ends of the series. */
void cursor_spread(struct cursors *cursors, const struct ground *ground);
/* Moves both cursors to their times on a series that has changed, and to the nearest points if they
 * were at crossings. */
void cursors_put_again(struct cursors *cursors, const struct ground *ground);
/* Updates the members of *cursors that follow from the two positions: periods and amplitudes. */
void cursor_settle(struct cursors *cursors, const struct ground *ground);
