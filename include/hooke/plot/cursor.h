/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors: what they stand on and how they move. */
#pragma once

#include <hooke/plot.h>

/* A point that cursors snap to. */
struct snap_point {
    double t, uncertainty, y; /* [s] [s] SI */
    /* counted in periods from 1 for the first up-crossing, 0 if there is none */
    int crossing;
};

/* Data under the cursors; memory from the arena. */
struct ground {
    char name[LIMIT_NAME + 16];
    bool data; /* a recording */
    struct series series;
    struct overview overview;
    struct snap_point *crossing, *peak; /* upward, of the equilibrium; found if asked for */
    size_t crossings, peaks;
    struct arena *arena;
};

/* A run or a recording, as session->view.cursors.on_data says; the other where there is only that.
 */
bool ground_open(struct session *session, struct arena *arena, struct ground *ground,
                 struct error *error);
double ground_spacing(const struct ground *ground); /* [s] between samples */
/* Puts cursor `which` to t, or to the place it snaps to if that is within `reach` [s]. */
void cursor_put(struct cursors *cursors, const struct ground *ground, int which, double t,
                double reach);
/* Moves to the next (forward) or previous crossing, or to a peak if cursors snap to peaks.
 * Returns false if there is none, with error. */
bool cursor_jump(struct cursors *cursors, const struct ground *ground, bool forward,
                 struct error *error);
/* B to A + n periods. */
bool cursor_span(struct cursors *cursors, const struct ground *ground, double n,
                 struct error *error);
/* The first and the last place to snap to, else both ends. */
void cursor_spread(struct cursors *cursors, const struct ground *ground);
/* Puts both where they are, on the ground that they stand on now. */
void cursors_put_again(struct cursors *cursors, const struct ground *ground);
/* Updates the values that follow from the two positions: periods and amplitudes. */
void cursor_settle(struct cursors *cursors, const struct ground *ground);
