/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes made of lines that a user types. */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>

struct cancel;

/* ---- typed scenes ----
 *
 * A model made of lines that a user types:
 *   var x = 2              a variable and its initial value
 *   var y' = 0.5           of a second-order one also its velocity
 *   param mu = 1000        a parameter, used by name: changing it acts at once
 *   x' = EXPR              first order
 *   y'' = EXPR             second order: y' or vy in expressions is its velocity
 *   force EXPR             [N], divided by the mass: added to the first coordinate
 *   force x = EXPR         the same for the coordinate x
 *   potential EXPR         [J], of the forces that depend on positions only
 *   observe E = EXPR       a quantity to look at, and a name for the lines below it
 *
 * A potential that was typed for the forces before goes when a force is added; on a built-in scene
 * it is that of the typed forces.
 *
 * Names in expressions: t, variables, velocities, parameters, observed quantities. They have to be
 * there when a line uses them.
 *
 * Initial values are parameters: x0 of x and vy0 of vy, x1_0 of x1. So is t0. The mass is the
 * parameter m where there is one, else 1. If every variable has an equation of second order the
 * scene is of second order: positions, then velocities; else of first order: variables as they were
 * declared, then velocities.
 *
 * Summands of a second derivative are sorted into forces that depend on positions (and time) and
 * drag, which depends on velocities, so that splittings apply with drag=explicit. A summand whose
 * factor is a parameter that is 0 is absent. Jacobians are derivatives of the expressions. Without
 * a typed potential the summands that depend on positions only get one where there is one; what
 * depends on time alone is a drive, whose work counts, like that of drag. All other forces have no
 * energy: the kinetic one is all that is known.
 *
 * A model is immutable: a line makes a new one. They live until typed_sweep() finds one that
 * nothing uses, all of them until typed_destroy(). An incomplete one (a variable without an
 * equation) can be looked at and set; scene_bind() says what is missing. Natural sizes: the largest
 * |initial value| and |value| on a short trial run of about one time constant (of linear systems:
 * many); where all are 0, 1.
 *
 * What is a second-order equation in y with a0 + a1 y + a2 y' + a3 |y'| y' + a4 cos(a5 t + a6) on
 * its right, as it is written (or with sin), with the present parameters and a3 <= 0, is the
 * oscillator with these coefficients: natural sizes, exact solution, exact drag and derived
 * quantities are those of the built-in one. So are forces on top of it.
 */

/* Returns true if the energy of a state takes a quadrature: no potential was typed, and the one
 * that was found is an integral along a path. */
bool typed_potential_is_integrated(const struct system *system);

enum typed_kind {
    TYPED_VAR,
    TYPED_PARAM,
    TYPED_EQUATION,
    TYPED_FORCE,
    TYPED_POTENTIAL,
    TYPED_OBSERVE
};

struct typed_line {
    enum typed_kind kind;
    /* name; for TYPED_VAR, y' means a velocity's initial value; for TYPED_FORCE, "" is the first
     * coordinate */
    struct text name;
    int order;        /* TYPED_EQUATION: 1 or 2 */
    struct text expr; /* all but TYPED_VAR and TYPED_PARAM; a whole expression, nothing behind it */
    double value;     /* TYPED_VAR, TYPED_PARAM: SI */
    enum quantity quantity; /* The same; QUANTITY_NUMBER if it has no unit. */
};

/* Returns true if a variable, a parameter or an observable may have this name. */
bool typed_name_fits(struct text name, struct error *error);

struct typed_models; /* all of a session */

struct typed_models *typed_create(struct error *error); /* Returns NULL if out of memory */
/* Frees all models; nothing may use them any more. */
void typed_destroy(struct typed_models *models);
#define SWEEP_FROM 32 /* smallest number of models that is searched for unused ones */
/* Frees the models that nobody uses, once there are twice as many as were left the last time. */
void typed_sweep(struct typed_models *models,
                 bool (*used)(const void *context, const struct model *model), const void *context);
/* Creates a scene without a line under this name, or "" for a typed one. Lines that are added to it
 * keep the name. Returns NULL if an error is set. */
const struct model *typed_new(struct typed_models *models, struct text name, struct error *error);
/*
 * Returns `source` with one more line, which replaces a line of the same kind and name. On a
 * built-in model var and equations begin an empty scene, the others add to it. Texts are copied.
 * Returns NULL on an error, whose `where` lies in line->expr or line->name.
 */
const struct model *typed_add(struct typed_models *models, const struct model *source,
                              const struct typed_line *line, struct error *error);
/* All lines at once, which do not have to make sense one by one. Texts are copied. Returns NULL if
 * an error is set. */
const struct model *typed_make(struct typed_models *models, struct text name,
                               const struct typed_line *line, int count,
                               const struct cancel *cancel, struct error *error);
/* Returns `source` without that line. A variable takes its equation and its initial velocity along.
 * The result may be the built-in model itself. Returns NULL if the line does not exist, or if
 * others use it. */
const struct model *typed_remove(struct typed_models *models, const struct model *source,
                                 enum typed_kind kind, struct text name, struct error *error);
/* The lines as they were typed, in the order in which they can be typed again. 0 of a built-in
 * model. */
int typed_lines(const struct model *model);
const struct typed_line *typed_line(const struct model *model, int i);
/* "y'' = -k*y", as one types it */
void typed_describe(const struct typed_line *line, struct buffer *text);
/* Returns the built-in model below, which may be the model itself, or NULL if all is typed. */
const struct model *typed_base(const struct model *model);
/* Returns true for a built-in scene with this parameter or variable where only parameters were
 * typed. A parameter of that name then begins an empty scene, with those that were typed. */
bool typed_base_has(const struct model *model, struct text name);

/* Settings under the name of a scene that is all typed; NULL if it is not. */
const struct preset *typed_preset(const struct model *model);

/* The scene with another model: values stay with the names of their parameters, unless the line
 * gave a new one. */
void scene_remodel(struct scene *scene, const struct model *model);

/* The term that is the whole right-hand side of a scene that is all typed. Returns NULL if there
 * are several. */
const struct bound_term *system_whole(const struct system *system);

/*
 * Returns the right-hand side that a typed term adds, as a program of t, y and the *values values
 * behind them, which are term->c from 1 on. Returns NULL for a built-in term.
 */
const struct program *term_program(const struct bound_term *term, int *values);

/*
 * Switches of typed equations: where abs(), sign(), if(), <, min(), max(), step(), floor(), mod()
 * go from one branch to another; and of dry friction, where the velocity is 0. A frozen system
 * stays on its branches and is smooth; its guards are above 0 as long as they are the right ones.
 * branch, guard: [system->switches <= LIMIT_SWITCHES].
 */
void system_branches(const struct system *system, double t, const double *y, double *branch);
void system_freeze(const struct system *system, const double *branch, struct system *frozen);
void system_guards(const struct system *frozen, double t, const double *y, double *guard);
/*
 * Sliding along `count` switches at once: the field that keeps all their arguments where they are,
 * between those on the two sides of each (Filippov 1988; with more than one switch the equivalent
 * control of Utkin 1992, to which each adds its own part). The guard of such a switch is above 0 as
 * long as the share of either side is. Where jumps change the rate of an argument only, as forces
 * do that of a position, its second derivative is kept 0.
 */
#define LIMIT_SLIDING 4
struct sliding {
    int count;
    int switch_index[LIMIT_SLIDING];
    double level[LIMIT_SLIDING]; /* value of the argument at the switch */
    double time_shift;           /* [s] over which arguments are differentiated */
    /* Systems [LIMIT_SLIDING + 1]: below all switches, then above each alone. Made by
     * system_slide() and freed by sliding_free(). NULL if the motion slides along none. */
    struct system *side;
};

/* Freezes the system so that it slides along the switches i with slides[i]; `slides` has
 * [system->switches]. *frozen refers to *sliding, which is {0} or made before. Returns false if
 * there are too many, or if out of memory. */
bool system_slide(const struct system *system, const double *branch, const bool *slides,
                  double time_offset, struct sliding *sliding, struct system *frozen);
void sliding_free(struct sliding *sliding);
/* Puts the state back on the switches from which it is off by what steps leave; returns false if it
 * is there. */
bool sliding_return(const struct sliding *sliding, double t, double *y);
/*
 * Returns true if the motion leaves across switch i, along which it was to slide: if jumps change
 * only the rate of its argument, and this rate is more than they change in `tolerance` [s].
 */
bool sliding_passes(const struct sliding *sliding, int i, double t, const double *y,
                    double tolerance);

/* A state that is on switch i but for rounding is put there, where it is known how: where dry
 * friction turns. */
void system_end_at_switch(const struct system *frozen, int i, double *y);

/* Returns the branch of switch i beyond the guard that is 0 at (t, y). */
double system_next_branch(const struct system *frozen, int i, double t, const double *y);

/* The branch below switch i, where the motion slides along it. */
double system_lower_branch(const struct system *frozen, int i, double t, const double *y);
/* Returns true if the argument of switch i depends on this variable. */
bool system_switch_sees(const struct system *system, int i, double t, const double *y,
                        int variable);

/*
 * Computes bounds of the derivatives rate [n] on a box [n] of states, and of their derivatives by
 * the state [n][n], NULL if not wanted. Drives are left out, which gives means over their period.
 * Returns false for a scene that is not all typed, or whose forces do not repeat.
 */
bool system_bounds(const struct system *system, const struct interval *box, struct interval *rate,
                   struct interval *jacobian);

/* These are 0 … count - 1. */
int model_observed(const struct model *model);
struct variable model_observed_variable(const struct model *model, int i);
double system_observe(const struct system *system, int i, double t, const double *y);
