/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes: the lines that were typed, the model that becomes of them, and the programs that
 * evaluate it. typed_compile() makes the model of its lines; typed_bind() binds it to values of
 * its parameters, with programs that typed_part_create() makes for each set of parameters that
 * are 0. */
#pragma once

#include <stdatomic.h>

#include <hooke/base/catalog.h>
#include "scene/formula/program/program.h"

struct cancel;

#define TYPED_NAME_MAX (LIMIT_SYMBOL - 3) /* letters of a name, so that vNAME_0 fits */
#define TYPED_READS (TERM_VALUES - 2)     /* largest number of parameters in expressions */
/* Number of names that expressions can have: t, the mass, the state, the parameters that are read
 * and the observed quantities; typed_names() counts those of one scene. */
#define TYPED_NAMES_MAX (2 + LIMIT_VARIABLES + TYPED_READS + LIMIT_OBSERVED)

/*
 * Groups of summands by what they depend on: FORCE on positions only, WORK on time, too, DRAG on
 * velocities. All summands of a scene of first order are in WORK, and so are forces that were added
 * to a built-in scene without a potential.
 */
enum typed_group { GROUP_FORCE, GROUP_WORK, GROUP_DRAG, GROUPS };

/*
 * A typed scene. The names of its expressions are numbered in the order t, the state, the mass, the
 * parameters that are read, the observed quantities. The values of a bound term are, from 1 on, the
 * mass, the parameters that are read, and retained values of programs; value 0 is the address of
 * its struct typed_term.
 */
struct typed {
    struct typed *next;          /* next in struct typed_models */
    const struct cancel *cancel; /* may end the compilation; NULL otherwise */
    struct arena arena;
    struct model model;
    struct preset preset; /* a preset with the name of the model */
    char name[LIMIT_SYMBOL + 1];
    const struct model *base; /* built-in model to which forces were added; NULL if all is typed */
    struct typed_line *line;  /* [lines] in the order of typing */
    int lines;
    struct term_row *row; /* terms of the base, then one for each group with summands */
    struct catalog params, terms, derived;
    /* The next three are used if all is typed. */
    int initial[LIMIT_VARIABLES];  /* parameter of the initial value of each state variable */
    int velocity[LIMIT_VARIABLES]; /* index of each one's velocity in the state; -1 if none */
    int t0, mass;                  /* parameters; mass is -1 if there is none, and is 1 then */
    int incomplete;                /* line of a variable without an equation; -1 if there is none */
    int read[TYPED_READS], reads;  /* [reads] parameters that expressions read */
    struct variable *observed;     /* [observes] observed quantities */
    const struct expr **observe;   /* [observes] their expressions */
    int observes;
    /* [rows] sums of each group, NULL if a row has no summand; NULL if the group has none */
    const struct expr **group[GROUPS];
    const struct expr *potential; /* typed potential [J]; NULL if there is none */
    struct typed_parts *parts;    /* programs made so far (bind.c) */
};

/* Returns the number of rows: accelerations, or derivatives of a scene of first order. */
static inline int typed_rows(const struct typed *typed)
{
    return typed->model.order == 2 ? typed->model.n / 2 : typed->model.n;
}

/* Returns the name of the mass. */
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

/* Makes the model from its base and its lines. Returns false with an error, which may point into
 * the texts of a line. */
bool typed_compile(struct typed *typed, struct error *error);

/* ---- sums (sums.c) ---- */

/* Returns the expression `a op b`, or the operation on a if b is NULL. Returns NULL, with an error,
 * if out of memory or if the expression is too deep. */
const struct expr *typed_join(struct arena *arena, const struct expr *a, const struct expr *b,
                              enum op_kind op, struct error *error);
/* Returns the expression of a number or a name; NULL if out of memory. */
const struct expr *typed_value(struct arena *arena, struct op op);
/* Input of typed_sort(). */
struct typed_sort {
    struct arena *arena;
    struct error *error;
    const unsigned *depends; /* [names] bits of enum typed_dependence for each name */
    bool positions;          /* GROUP_FORCE is used; else its summands are in GROUP_WORK */
};

enum typed_dependence { DEPENDS_TIME = 1, DEPENDS_POSITION = 2, DEPENDS_VELOCITY = 4 };

/* Returns what the expression depends on, given that of its names. */
unsigned typed_depends(const struct expr *expr, const unsigned *depends);
/* Splits an expression into sums of its summands in each group, in the order of writing; a group
 * without summands gets NULL. Returns false with an error. */
bool typed_sort(const struct typed_sort *sort, const struct expr *expr,
                const struct expr *group[GROUPS]);

/* ---- programs (parts.c) ---- */

#define TYPED_FOUND 8 /* ways to find a potential (potential.c) */

/* Programs of a group, or of all of them together. Each but `add` may be NULL. */
struct typed_term {
    const struct typed *typed;
    struct typed_part *part;
    struct term_row row;            /* row of the term, with the flags that hold for it */
    struct program *add, *jacobian; /* NULL if nothing is added */
    struct program *potential;      /* typed potential, */
    struct program *slope;          /* and its derivatives by the positions */
    struct program *observe;        /* observed quantities */
    /* Parts of a potential that was not typed, as equations_integrate() makes them: of all
     * antiderivatives, and along the axes. NULL if none were found. */
    struct program *parts, *axes;
};

/* All programs of a typed scene for one set of parameters that are 0, which are known to be 0 in
 * the programs. The others are values of bound terms. */
struct typed_part {
    struct typed_part *next;
    uint64_t zeros;                 /* bit i is set if parameter read[i] is 0 */
    struct typed_term term[GROUPS]; /* programs of each group */
    struct typed_term all;          /* programs of the sum of all groups */
    /* The sum of all groups with the branches of its switches as values; add is NULL if there are
     * no switches. */
    struct typed_term frozen;
    struct program *argument; /* argument of each switch */
    struct switches switches;
    bool turns_only; /* result of typed_turns_only() */
    /* rows of GROUP_FORCE with a potential that was found, one for each way to find it */
    struct term_row found[TYPED_FOUND];
    /* number of values of a bound term without the first: mass, parameters, retained values */
    int steady;
    atomic_bool checked; /* typed_check() has found that force and potential agree */
};

/* Computes the outputs of a program at the state y [n] at t; c are the values of a bound term of
 * the part that the program belongs to. Sets NAN if out of memory. */
void typed_evaluate(const struct program *program, const double *c, double t, const double *y,
                    double *result);
/* Returns the term to which the values c of a bound term belong. */
const struct typed_term *typed_term_of(const double *c);
/* Functions add and jacobian of a term's row. They add NaN if out of memory. */
void typed_add_force(const double *c, double t, const double *y, double *a);
void typed_add_jacobian(const double *c, double t, const double *y, double *jac);
/* Returns true if ratios of masses fit behind the values of a bound term: the last value is the
 * ratio of the first coordinate, the one before it that of the second, and so on. */
static inline bool typed_ratios_fit(const struct typed_term *term)
{
    return term->part && 1 + term->part->steady <= TERM_VALUES - typed_rows(term->typed);
}
/* Sets mass [rows] to the mass of each coordinate: that of the scene, unless typed_find_potential()
 * found that they differ. */
void typed_masses(const double *c, double *mass);

/* Makes all programs for the set `zeros` of parameters that are 0. Returns NULL with an error. */
struct typed_part *typed_part_create(const struct typed *typed, uint64_t zeros,
                                     struct error *error);
void typed_part_destroy(struct typed_part *part);

/* ---- switches (switch.c) ---- */

/* Makes the frozen programs of the part, if the scene has switches. Returns false with an error. */
bool typed_freeze(const struct typed *typed, uint64_t zeros, struct typed_part *part,
                  struct error *error);
enum switch_kind typed_switch_kind(const struct system *system, int i);
/* Computes the arguments of the typed switches of a frozen system that does not slide. */
void typed_arguments(const struct system *system, double t, const double *y, double *argument);
/* Computes those of a system that is not frozen, each on the branches of the switches before. */
void typed_unfrozen_arguments(const struct system *system, double t, const double *y,
                              double *argument);
/* Returns the branch of typed switch i on which the system is frozen. */
double typed_branch(const struct system *frozen, int i);
/* Sets branch [switches] to the branches of the equations at y and time 0, for the values `bound`
 * of a bound term of the part. */
void typed_branches_at(const struct typed_part *part, const double *bound, const double *y,
                       double *branch);
/* Freezes the terms of the system on these branches, into *frozen, whose other members are those of
 * the system already. */
void typed_branches_take(const struct system *system, const double *branch, int count,
                         struct system *frozen);
/* Sets the guards of the switches along which the motion slides; the other guards stay. */
void sliding_guards(const struct sliding *s, double t, const double *y, double *guard);
/* Returns the branch to which a motion that slides along switch i leaves it; NAN if it does not
 * slide along it. */
double sliding_leaves(const struct sliding *s, int i, double t, const double *y);
/* Returns true if the only switch is that of a speed, across which the force is continuous. */
bool typed_turns_only(const struct system *system);
/* Returns the number of typed switches at which steps end, and sets system->extended. It is 0 for
 * an oscillator, whose kinks are turning points. */
int typed_switches(struct system *system);

/* ---- switches of all kinds (switches.c) ---- */

/* Returns the branch of a switch for a value of its argument. */
double switch_branch(enum switch_kind kind, double argument);
enum switch_kind switch_kind_of(const struct system *system, int i);
/* Computes the arguments of all switches of a frozen system that does not slide. */
void switch_arguments(const struct system *system, double t, const double *y, double *argument);
/* Returns true if the motion slides along the switch of dry friction only: the body sticks. */
bool sliding_rests(const struct sliding *sliding);
/* Removes all forces from a system whose body sticks. */
void sliding_freeze_rest(struct system *frozen);
/* Sets the properties of a system that follow from the flags of its terms (system.c). */
void system_sum_up(struct system *system);

/* ---- binding (bind.c) ---- */

/* Creates an empty set of programs; returns NULL if out of memory. */
struct typed_parts *typed_parts_create(void);
void typed_parts_destroy(struct typed_parts *parts);
/* Adds the typed terms, with these values of the parameters, to a system whose mass is set. Returns
 * false with an error. */
bool typed_bind(const struct typed *typed, const double *param, struct system *system,
                struct error *error);
/* Returns true if the typed force is minus the slope of the typed potential, or if there is no
 * potential; otherwise sets an error. Start and scale have to be set. */
bool typed_check(const struct system *system, struct error *error);

/* ---- work along a path (work.c) ---- */

/* Paths to q_end [rows]. */
enum typed_path {
    PATH_STRAIGHT,      /* straight, from q_begin */
    PATH_FROM_ORIGIN,   /* straight, from the origin */
    PATH_FROM_INFINITY, /* straight, from infinity along the radius of q_end */
    /* a curve from (1, 0, ...) that avoids the origin; in one coordinate from 1 or -1 */
    PATH_AROUND_ORIGIN
};

/* Returns the work of the forces of a bound term along the path, and sets *size to the integral of
 * its magnitude. Returns NAN if the integral does not converge. */
double typed_work(const double *c, enum typed_path shape, const double *q_begin,
                  const double *q_end, double *size);

/* ---- potentials that were not typed (potential.c) ---- */

/* Fills part->found, after the terms of the part were made. */
void typed_found_rows(struct typed_part *part);
/* Looks for a potential of forces that depend on positions only, and gives their term a row with
 * it. Start and scale have to be set. Returns false if none is found or needed. */
bool typed_find_potential(struct system *system);
/* Returns true if all forces have a potential, are drag, or are drives that depend on time
 * alone. */
bool typed_has_energy(const struct system *system);

/* ---- recognising equations (linear.c) ---- */

/* Sets *affine to true if all outputs are linear in the state in the form in which they are
 * written; their coefficients may depend on time. Sets *kinks to true if some have a kink where the
 * second variable, a velocity, is 0. Returns false if out of memory. */
bool typed_look(const struct typed *typed, const struct program *program, bool *affine, bool *kinks,
                struct error *error);
/* Adds the coefficients of the term, with the values c, to those of the oscillator, or clears
 * oscillator->whole if the term is not one of an oscillator. */
void typed_recognise(const struct typed_term *term, const double *c, struct oscillator *oscillator);

/* ---- natural sizes (scale.c) ---- */

/* Sets the start of a system and its natural sizes, by a trial run (struct model's begin). */
void typed_begin(const double *param, struct system *system);
/* Sets the start, and natural sizes of 1, which takes no time. */
void typed_start(const double *param, struct system *system);
