/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes of other programs: XPPAUT's .ode files. */
#pragma once

#include <hooke/scene/typed.h>

struct cancel;

/*
 * What an .ode file says, as lines of a typed scene: parameters, initial values, right-hand sides
 * with functions written out, derived parameters, hidden and auxiliary quantities as observed ones.
 * Names are in lower case, as XPPAUT does not tell them apart, and another one where hooke needs it
 * itself; expressions are grouped as XPPAUT groups them: comparisons bind as tightly as powers, and
 * powers from the left (B. Ermentrout, Simulating, Analyzing, and Animating Dynamical Systems, SIAM
 * 2002, chapter 3 and appendix; priorities measured with XPPAUT 6.11).
 *
 * Tables of a formula are straight between their points, and beyond; special NAME=conv(...), sums
 * over neighbours weighted by one, are written out.
 *
 * Refused, with the line and the reason: noise, Markov variables, delays, other networks, tables in
 * files, integral and algebraic equations, maps, values from C libraries, random numbers, functions
 * that expressions do not have.
 */
struct ode_event {
    int line;
    const char *when;     /* "x - 1 rising" */
    const char *commands; /* "x = 0; continue" */
};

struct ode_note {
    const char *text; /* "line 7: …" */
    bool warns;       /* something is left out; else a name is another one */
};

struct ode_scene {
    struct typed_line *line;
    int lines;
    struct ode_event *event;
    int events;
    /* times [s]; tol 0: none; every: steps from one row to the next */
    double t0, total, dt, tol;
    int every;
    const char *method; /* hooke's */
    bool adapts;        /* its steps follow from tol */
    const char *meant;  /* XPPAUT's where it is another one, or NULL */
    const struct ode_note *note;
    int notes;
    const struct text *set; /* names of its sets of values */
    int sets;
};

struct ode_options {
    struct text set; /* values of this one, or "" for none */
    /* Returns true if the variable or parameter with this lower-case name is needed. May be NULL if
     * none is. */
    bool (*taken)(struct text name);
    const struct cancel *cancel;
};

/* All in the arena. False: error, which begins with the line. */
bool ode_read(struct text file, const struct ode_options *options, struct arena *arena,
              struct ode_scene *scene, struct error *error);
