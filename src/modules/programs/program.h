/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene with its method as a program: what its writers share. */
#pragma once

#include <hooke/report.h>
#include <hooke/run.h>
#include <hooke/scene.h>
#include "modules/programs/compute/table.h"
#include "modules/programs/compute/written.h"

struct scene_program {
    const struct session *session;
    const struct scene *scene;
    const struct method *method;
    enum drag drag;
    struct run_settings settings;
    struct plan plan;
    double duration;
    struct written written;
    enum dialect dialect;
    char **name;       /* [written.names] in this language */
    bool turns;        /* steps end where the velocity turns */
    const char *rates; /* text of the derivatives, and of what is observed for them */
    const char *observed;
    struct buffer *output;
    struct arena *arena;
    struct error *error;
};

static inline int program_n(const struct scene_program *p)
{
    return p->written.system.n;
}

static inline bool program_moves(const struct scene_program *p) /* positions and velocities */
{
    return p->written.system.order == 2;
}

/* Returns the text of state variable i. */
static inline const char *program_state(const struct scene_program *p, int i)
{
    return p->name[1 + i];
}

/* Appends an expression in the names of the program. */
void program_expr(struct scene_program *p, const struct expr *expr);
/* Appends what is computed, in lines that begin with that text. */
void program_title(struct scene_program *p, const char *prefix);

/* ---- programs that compute (template.c, words.c) ---- */

/* Returns true if programs in that language cannot have a variable of that name, as the language or
 * the program itself uses it. */
bool program_takes(enum dialect dialect, const char *name);
/* Appends a program in C, Python or for Octave. Returns false with `error` filled. */
bool program_computes(struct scene_program *p);
/* Returns true if the formulas have that word with that character behind it, '\0' for any. */
bool program_uses(const struct scene_program *p, const char *name, char next_char);
/* Returns the text that was written to p->out, which is empty then, in the arena. */
const char *program_take_text(struct scene_program *p);
/* Returns true if the formulas read name i of the scene. */
bool program_reads(const struct scene_program *p, int i);
/* Appends the text that a word of a template stands for. Returns false if there is no such word. */
bool program_word(struct scene_program *p, struct text word);

/* ---- documents.c ---- */

bool program_xpp(struct scene_program *p);
bool program_tex(struct scene_program *p);
