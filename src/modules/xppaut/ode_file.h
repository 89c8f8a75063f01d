/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes of other programs: XPPAUT's .ode files. */
#pragma once

#include <hooke/scene/typed.h>

struct cancel;

/*
 * Converts an .ode file to lines of a typed scene: parameters, initial values, right-hand sides
 * with functions written out, derived parameters, and hidden and auxiliary quantities as observed
 * ones. Names are in lower case, since XPPAUT ignores case, and are changed where hooke needs them
 * itself. Expressions are grouped as in XPPAUT: comparisons bind as tightly as powers, and powers
 * from the left (B. Ermentrout, Simulating, Analyzing, and Animating Dynamical Systems, SIAM 2002,
 * chapter 3 and appendix; priorities measured with XPPAUT 6.11).
 *
 * Tables of a formula are interpolated and extrapolated linearly. special NAME=conv(...), weighted
 * sums over neighbours, are written out.
 *
 * Not supported, and reported with the line and the reason, are noise, Markov variables, delays,
 * other networks, tables in files, integral and algebraic equations, maps, values from C libraries,
 * random numbers, functions that expressions do not have.
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
    /* times [s]; tol 0 if not given; every is the number of steps from one row to the next */
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

/* Reads the file; all results are in the arena. Returns false with an error that begins with the
 * line. */
bool ode_read(struct text file, const struct ode_options *options, struct arena *arena,
              struct ode_scene *scene, struct error *error);
