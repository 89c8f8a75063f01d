/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes: what was typed, what became of it, and the programs that evaluate it. */
#pragma once

#include <stdatomic.h>

#include <hooke/base/catalog.h>
#include "scene/formula/program/program.h"

struct cancel;

#define TYPED_NAME_MAX (LIMIT_SYMBOL - 3) /* so that there is room for vNAME_0 */
#define TYPED_READS (TERM_VALUES - 2)     /* parameters that expressions may read */
/* Number of names that expressions can have: t, the mass, the state, the parameters that are read
 * and the observed quantities; typed_names() counts those of one scene. */
#define TYPED_NAMES_MAX (2 + LIMIT_VARIABLES + TYPED_READS + LIMIT_OBSERVED)

/*
 * Forces by what they depend on: FORCE on positions only, WORK on time, too, DRAG on velocities. A
 * scene of first order has all in WORK, and so have forces on a built-in scene without a typed
 * potential.
 */
enum typed_group { GROUP_FORCE, GROUP_WORK, GROUP_DRAG, GROUPS };

/*
 * Names of the expressions, as equations count them: t, the state, the mass, the parameters that
 * are read, what is observed. A bound term's values from 1 on are the mass, the parameters that are
 * read, and what programs keep of them.
 */
struct typed {
    struct typed *next;          /* next of all models */
    const struct cancel *cancel; /* while it is compiled */
    struct arena arena;
    struct model model;
    struct preset preset; /* settings under the name of the model */
    char name[LIMIT_SYMBOL + 1];
    const struct model *base; /* NULL if all is typed */
    struct typed_line *line;  /* lines in the order of typing */
    int lines;
    struct term_row *row; /* [terms of the base + GROUPS] the groups that are there */
    struct catalog params, terms, derived;
    /* parameter of each state variable; where all is typed, like the next two */
    int initial[LIMIT_VARIABLES];
    /* places in the state of a variable and of its velocity, -1 if there is none */
    int velocity[LIMIT_VARIABLES];
    int t0, mass;                 /* parameters, mass -1: it is 1 */
    int incomplete;               /* line of a variable without an equation, -1 if there is none */
    int read[TYPED_READS], reads; /* parameters */
    struct variable *observed;
    const struct expr **observe;
    int observes;
    const struct expr *
        /* [rows], each with NULL where the group has nothing; NULL if it has nothing at all */
        *group[GROUPS];
    const struct expr *potential;
    struct typed_parts *parts;
};

/* Rows of what is added to: accelerations or derivatives. */
static inline int typed_rows(const struct typed *typed)
{
    return typed->model.order == 2 ? typed->model.n / 2 : typed->model.n;
}

static inline int typed_mass_name(const struct typed *typed)
{
    return 1 + typed->model.n;
}

/* Returns the name of the first parameter that is read; the others follow it. */
static inline int typed_first_read(const struct typed *typed)
{
    return typed_mass_name(typed) + 1;
}

/* Returns the name of the first observed quantity; the others follow it. */
static inline int typed_first_observed(const struct typed *typed)
{
    return typed_first_read(typed) + typed->reads;
}

/* Returns the number of names, at most TYPED_NAMES_MAX. */
static inline int typed_names(const struct typed *typed)
{
    return typed_first_observed(typed) + typed->observes;
}

/* Makes it from its base and its lines; error->where may lie in a line's texts. */
bool typed_compile(struct typed *typed, struct error *error);

/* ---- sums (typed_sums.c) ---- */

/* Returns a and b, in this order, followed by the operation; b is NULL if it has one operand.
 * Returns NULL if out of memory or if the expression is too deep. */
const struct expr *typed_join(struct arena *arena, const struct expr *a, const struct expr *b,
                              enum op_kind op, struct error *error);
const struct expr *typed_value(struct arena *arena, struct op op);
struct typed_sort {
    struct arena *arena;
    struct error *error;
    const unsigned *depends; /* bits of enum typed_dependence for each name */
    bool positions;          /* expressions of positions only form a group of their own */
};

enum typed_dependence { DEPENDS_TIME = 1, DEPENDS_POSITION = 2, DEPENDS_VELOCITY = 4 };

unsigned typed_depends(const struct expr *expr, const unsigned *depends);
/* The summands of an expression by groups, each group in the order of writing; NULL where there are
 * none. */
bool typed_sort(const struct typed_sort *sort, const struct expr *expr,
                const struct expr *group[GROUPS]);

/* ---- programs (typed_parts.c) ---- */

#define TYPED_FOUND 8 /* ways to a potential (typed_potential.c) */

/* Programs of a group, or of all of them, with those parameters known that are 0. */
struct typed_term {
    const struct typed *typed;
    struct typed_part *part;
    struct term_row row; /* row with the flags that hold here */
    struct program *add, *jacobian;
    /* NULL where there is none. slope is that of the potential. */
    struct program *potential, *slope, *observe;
    /* Parts of a potential that nobody typed, as equations_integrate() makes them: of all
     * antiderivatives, and along the axes. NULL if none were found. */
    struct program *parts, *axes;
};

struct typed_part {
    struct typed_part *next;
    uint64_t zeros; /* bits of the parameters that are 0 */
    struct typed_term term[GROUPS], all;
    /* all, with the branches of switches as given values; add NULL: no switches */
    struct typed_term frozen;
    struct program *argument; /* argument of each switch */
    struct switches switches;
    bool turns_only; /* as typed_turns_only() says */
    /* rows of GROUP_FORCE with a potential that was found, one for each way to find it */
    struct term_row found[TYPED_FOUND];
    /* values of a bound term behind the first: the mass, the parameters, what its programs keep */
    int steady;
    atomic_bool checked; /* force and potential agree */
};

/* Evaluates a program of the part that c is from. */
void typed_evaluate(const struct program *program, const double *c, double t, const double *y,
                    double *result);
const struct typed_term *typed_term_of(const double *c);
/* Functions of a term's row: add, and jacobian. They add NaN if there is no memory for large
 * ones. */
void typed_add_force(const double *c, double t, const double *y, double *a);
void typed_add_jacobian(const double *c, double t, const double *y, double *jac);
/* Returns true if ratios of masses have room behind the values of a bound term. The last ratio is
 * that of the first coordinate. */
static inline bool typed_ratios_fit(const struct typed_term *term)
{
    return term->part && 1 + term->part->steady <= TERM_VALUES - typed_rows(term->typed);
}
/* The mass of each coordinate [rows]: that of the scene, unless typed_find_potential() found that
 * they differ. */
void typed_masses(const double *c, double *mass);

struct typed_part *typed_part_create(const struct typed *typed, uint64_t zeros,
                                     struct error *error);
void typed_part_destroy(struct typed_part *part);

/* ---- switches (typed_switch.c) ---- */

bool typed_freeze(const struct typed *typed, uint64_t zeros, struct typed_part *part,
                  struct error *error);
enum switch_kind typed_switch_kind(const struct system *system, int i);
/* Computes arguments of the typed switches of a frozen system, not of one that slides. */
void typed_arguments(const struct system *system, double t, const double *y, double *argument);
void typed_unfrozen_arguments(const struct system *system, double t, const double *y,
                              double *argument);
double typed_branch(const struct system *frozen, int i);
/* The branches [switches] of a bound term's part at time 0, of the whole equations. */
void typed_branches_at(const struct typed_part *part, const double *bound, const double *y,
                       double *branch);
/* Puts the terms on these branches; the rest of *frozen is a copy of *system already. */
void typed_branches_take(const struct system *system, const double *branch, int count,
                         struct system *frozen);
/* sliding_guards() writes the guards of the switches along which the motion slides into those of
 * all. sliding_leaves() returns the branch that switch i goes to, or NAN if it goes to none. */
void sliding_guards(const struct sliding *s, double t, const double *y, double *guard);
double sliding_leaves(const struct sliding *s, int i, double t, const double *y);
/* Returns true if the only switch is that of a speed, across which the force is continuous. */
bool typed_turns_only(const struct system *system);
/* that are located: 0 for an oscillator, which has turning points */
int typed_switches(struct system *system);

/* ---- switches of all kinds (switches.c) ---- */

double switch_branch(enum switch_kind kind, double argument);
enum switch_kind switch_kind_of(const struct system *system, int i);
/* Computes arguments of all switches of a frozen system, not of one that slides. */
void switch_arguments(const struct system *system, double t, const double *y, double *argument);
/* Returns true if all there is is dry friction that sticks; then nothing moves. */
bool sliding_rests(const struct sliding *sliding);
void sliding_freeze_rest(struct system *frozen);
void system_sum_up(struct system *system); /* sums up the properties of its terms (system.c) */

/* ---- binding (typed_bind.c) ---- */

struct typed_parts *typed_parts_create(void); /* Returns NULL if out of memory */
void typed_parts_destroy(struct typed_parts *parts);
/* Adds what is typed to a system whose mass is set. */
bool typed_bind(const struct typed *typed, const double *param, struct system *system,
                struct error *error);
/* Returns true if the force is the slope of the potential. Start and scale have to be known. */
bool typed_check(const struct system *system, struct error *error);

/* ---- work along a path (work.c) ---- */

/* Straight between two points; to `q_end` from the origin, from infinity along its radius, or from
 * (1, 0, ...) about the origin and not through it: in one coordinate from the 1 of the same sign.
 */
enum typed_path { PATH_STRAIGHT, PATH_FROM_ORIGIN, PATH_FROM_INFINITY, PATH_AROUND_ORIGIN };

/* Returns the work of the forces of a bound term, and in *size that of their magnitude. Returns NAN
 * if the integral does not converge. */
double typed_work(const double *c, enum typed_path shape, const double *q_begin,
                  const double *q_end, double *size);

/* ---- potentials that were not typed (typed_potential.c) ---- */

void typed_found_rows(struct typed_part *part); /* once its terms are made */
/* Once start and scale are known: forces that depend on positions only get a potential where there
 * is one. Returns false if there is none, or nothing to look for. */
bool typed_find_potential(struct system *system);
/* Returns true if all forces have a potential, are drag, or are drives that depend on time
 * alone. */
bool typed_has_energy(const struct system *system);

/* ---- what they are (typed_linear.c) ---- */

/* Sets *affine if all outputs are linear in the state, as they are written; the coefficients may
 * still depend on time. Sets *kinks if some have a kink where the second variable, a velocity, is
 * 0. */
bool typed_look(const struct typed *typed, const struct program *program, bool *affine, bool *kinks,
                struct error *error);
/* Adds what the term is, with its values, to the oscillator, or notes that it is nothing of that
 * kind. */
void typed_recognise(const struct typed_term *term, const double *c, struct oscillator *oscillator);

/* ---- natural sizes (typed_scale.c) ---- */

void typed_begin(const double *param, struct system *system); /* struct model's begin */
/* The same but for natural sizes, which are 1. */
void typed_start(const double *param, struct system *system);
