/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads XPPAUT's .ode files: ode_read() turns a file into lines from which typed_make() makes a
 * scene. */
#pragma once

#include <hooke/scene/typed.h>

struct cancel;

/* An event of the file, as `event` has it. */
struct ode_event {
    int line;             /* line in the file */
    const char *when;     /* "x - 1 rising" */
    const char *commands; /* "x = 0; continue" */
};

/* A remark on what was read. */
struct ode_note {
    const char *text; /* "line 7: …" */
    bool warns;       /* something was left out; otherwise a name was changed */
};

/* A file that was read. All memory is from the arena. */
struct ode_scene {
    struct typed_line *line; /* [lines] of a typed scene */
    int lines;
    struct ode_event *event; /* [events] */
    int events;
    /* Times [s] and tolerance, which is 0 if not given. */
    double t0, total, dt, tol;
    int every;                   /* number of steps from one recorded row to the next */
    const char *method;          /* hooke's */
    bool adapts;                 /* the method adapts its steps */
    const char *meant;           /* description of XPPAUT's method if it is another one, or NULL */
    const struct ode_note *note; /* [notes] */
    int notes;
    const struct text *set; /* [sets] names of the file's sets of values */
    int sets;
};

/* Options of reading. */
struct ode_options {
    struct text set; /* name of the set whose values are taken, or "" */
    /* Returns true if the program needs this lower-case name itself, so that the scene may not have
     * it. May be NULL. */
    bool (*taken)(struct text name);
    const struct cancel *cancel;
};

/* Reads the text of a file into *scene, with memory from the arena. Returns false with an error
 * that begins with the line. */
bool ode_read(struct text file, const struct ode_options *options, struct arena *arena,
              struct ode_scene *scene, struct error *error);
