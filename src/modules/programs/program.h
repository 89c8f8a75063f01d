/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the writers of programs share: a scene with its method, and the program
 * that is written. */
#pragma once

#include <hooke/report.h>
#include <hooke/run.h>
#include <hooke/scene.h>
#include "modules/programs/compute/table.h"
#include "modules/programs/compute/written.h"

/* A program that is written. */
struct scene_program {
    const struct session *session;
    const struct scene *scene;
    const struct method *method;
    enum drag drag;
    struct run_settings settings;
    struct plan plan; /* plan of the run that it repeats */
    double duration;  /* [s] */
    struct written written;
    enum dialect dialect;
    char **name;           /* [written.names] each name in this language */
    bool turns;            /* steps end at turning points */
    const char *rates;     /* text of the derivatives */
    const char *observed;  /* text of the observed quantities that these read */
    struct buffer *output; /* receives the program */
    struct arena *arena;
    struct error *error;
};

/* Returns the number of state variables. */
static inline int program_n(const struct scene_program *p)
{
    return p->written.system.n;
}

/* Returns true if the state is positions and velocities. */
static inline bool program_moves(const struct scene_program *p) /* positions and velocities */
{
    return p->written.system.order == 2;
}

/* Returns the name of state variable i in the program. */
static inline const char *program_state(const struct scene_program *p, int i)
{
    return p->name[1 + i];
}

/* Appends an expression in the names of the program. */
void program_expr(struct scene_program *p, const struct expr *expr);
/* Appends lines, each begun by `prefix`, that say what the program computes: scene, equations,
 * method, steps and times. */
void program_title(struct scene_program *p, const char *prefix);

/* ---- programs that compute (template.c, words.c) ---- */

/* Returns true if programs in that language cannot have a variable of that name, as the language or
 * the program itself uses it. */
bool program_takes(enum dialect dialect, const char *name);
/* Appends to p->output the text of a program in C, Python or for Octave that computes the run,
 * made from the template of p->dialect. Returns false if out of memory or if cancelled. */
bool program_write(struct scene_program *p);
/* Returns true if the formulas have that word, followed by next_char unless it is '\0'. */
bool program_uses(const struct scene_program *p, const char *name, char next_char);
/* Moves the text of p->output to the arena and returns it, or "" if out of memory
 * (p->output->failed is set then). */
const char *program_take_text(struct scene_program *p);
/* Returns true if the formulas read name i of the scene. */
bool program_reads(const struct scene_program *p, int i);
/* Appends the text that a word of a template denotes. Returns false if there is no such word. */
bool program_word(struct scene_program *p, struct text word);

/* ---- documents.c ---- */

/* Appends a scene for XPPAUT. Returns false with an error. */
bool program_xpp(struct scene_program *p);
/* Appends a LaTeX document with equations, parameters and initial values. Returns false with an
 * error. */
bool program_tex(struct scene_program *p);
