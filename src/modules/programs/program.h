/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene with its method as a program: what its writers share. */
#ifndef HOOKE_MODULES_PROGRAMS_PROGRAM_H
#define HOOKE_MODULES_PROGRAMS_PROGRAM_H

#include <hooke/method/table.h>
#include <hooke/report.h>
#include <hooke/run.h>
#include <hooke/scene.h>

/* How statements look in a language. */
struct syntax {
    enum dialect dialect;
    const char *comment, *comment_end;
    const char *variable, *constant; /* before the name of a new one that changes, that does not */
    const char *global;              /* of one outside of all functions */
    const char *function, *begin, *result, *end; /* "… NAME(…) {", "return", "}" */
    const char *none;                            /* arguments of a function without any */
    const char *stop;                            /* behind a statement */
    const char *count;                           /* of steps after this one, a number */
    const char *last;                            /* is this step the last one? */
    const char *newline;                         /* in the middle of a statement */
    const char *if_then, *if_end;                /* "if (", ") " */
};

struct scene_program {
    const struct session *session;
    const struct scene *scene;
    const struct method *method;
    enum drag drag;
    struct run_settings settings;
    struct plan plan;
    double duration;
    struct written written;
    struct written_slopes slopes; /* of backward Euler */
    const struct syntax *syntax;
    char **name;      /* [written.names + slopes.parts] in this language */
    char **argument;  /* what functions are called with; NULL: the names */
    const char *step; /* what a step's length is called */
    bool partial;     /* the last step is shorter */
    bool raises;      /* in Python: where in other languages numbers end */
    bool turns;       /* steps end where the velocity turns */
    struct buffer *out;
    struct arena *arena;
    struct error *error;
    bool *reads; /* [written.names] parameters that the text reads: found while it is written */
};

const struct syntax *program_syntax(enum dialect dialect);
/* Does a program use that name itself, or its language? */
bool program_takes(enum dialect dialect, const char *name);
/* Would a constant of that name in C hide a function? */
bool program_shadows(const char *name);

/* ---- names and numbers (program.c) ---- */

static inline int program_n(const struct scene_program *p)
{
    return p->written.system.n;
}

static inline bool program_moves(const struct scene_program *p) /* positions and velocities */
{
    return p->written.system.order == 2;
}

/* The text of state variable i. */
static inline const char *program_state(const struct scene_program *p, int i)
{
    return p->name[1 + i];
}

/* A weight of a method as it stands in books, 35/384, where that is the same double. */
void program_weight(const struct scene_program *p, double weight);
void program_expr(struct scene_program *p, const struct expr *expr);
/* A coefficient by the names of the spring scene, one or one/over, where it is that number; else
 * the number. */
void program_coefficient(struct scene_program *p, double value, const char *one, const char *over);
void program_comment(const struct scene_program *p, const char *indent, const char *text);

/* ---- forces (forces.c) ---- */

enum part { PART_ALL, PART_FORCE, PART_DRAG };

/* Functions for the rows that there are. */
void program_functions(struct scene_program *p, enum part part);
/* "acceleration(t + 0.5*dt, y_2, v_2)"; time: NULL: t, suffix: behind each variable, NULL: none.
 * False: nothing is added to that row. */
bool program_call(struct scene_program *p, enum part part, int row, const char *time,
                  const char *suffix);

/* ---- steps (steps.c, implicit.c) ---- */

/* What stands before the loop, and in it. */
void program_before(struct scene_program *p, const char *indent);
void program_step(struct scene_program *p, const char *indent);
void program_implicit_functions(struct scene_program *p);
void program_implicit_step(struct scene_program *p, const char *indent);

/* derivatives() of the state as one; `size`, the sizes of its variables; acceleration_at() */
void program_derivatives(struct scene_program *p);
void program_sizes(struct scene_program *p);
void program_acceleration_at(struct scene_program *p);
/* Ends the program, or goes on behind the rows, where the state is not what a run goes on with. */
void program_bounds(struct scene_program *p, const char *indent);

/* ---- steps whose size follows the error (adaptive.c): C and Python ---- */

bool program_refuse_adaptive(struct scene_program *p);
void program_adaptive_constants(struct scene_program *p);
void program_adaptive_functions(struct scene_program *p);
void program_adaptive_loop_c(struct scene_program *p);
void program_adaptive_loop_python(struct scene_program *p);

/* ---- whole files ---- */

void program_front(struct scene_program *p);
void program_constants(struct scene_program *p);
void program_title(struct scene_program *p);    /* what is computed, in lines */
bool program_computes(struct scene_program *p); /* C, Python, Octave (frame.c) */
bool program_xpp(struct scene_program *p);
bool program_tex(struct scene_program *p);
/* Puts the functions that the text calls behind it and what declares them at `declared`; in Python
 * all of it there. */
void program_helpers(struct scene_program *p, size_t declared);

#endif
