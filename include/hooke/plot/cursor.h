/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors: what they stand on and how they move. */
#ifndef HOOKE_PLOT_CURSOR_H
#define HOOKE_PLOT_CURSOR_H

#include <hooke/plot.h>

/* From an up-crossing of the equilibrium to the next down-crossing. */
struct hill {
    double from, uncertainty, to; /* [s] to NAN: it does not end */
    int number;                   /* of the up-crossing, counted in periods from 1 for the first */
};

/* What the cursors stand on; memory from the arena. */
struct ground {
    char name[LIMIT_NAME + 16];
    bool data; /* a recording */
    struct series series;
    struct overview overview;
    struct hill *hill; /* [hills] */
    size_t hills;
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
/* To the next (forward) or previous crossing, or peak where cursors snap to peaks. False: there is
 * none, with error. */
bool cursor_jump(struct cursors *cursors, const struct ground *ground, bool forward,
                 struct error *error);
/* B to A + n periods. */
bool cursor_span(struct cursors *cursors, const struct ground *ground, double n,
                 struct error *error);
/* The first and the last place to snap to, else both ends. */
void cursor_spread(struct cursors *cursors, const struct ground *ground);
/* What follows from the two places: periods, amplitudes. */
void cursor_settle(struct cursors *cursors, const struct ground *ground);

#endif
