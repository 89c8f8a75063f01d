/* SPDX-License-Identifier: GPL-3.0-or-later */
/* typed: scenes whose equations a user types, one line at a time, and switches (points at which a
 * force changes its formula), which typed equations and dry friction have. */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>

struct cancel;

/*
 * ---- typed scenes ----
 *
 * A typed model is made of lines:
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
 * Adding a force removes a typed potential, because that was the potential of the forces before; on
 * a built-in scene a typed potential is that of the typed forces.
 *
 * Expressions may contain t, variables, velocities, parameters and observed quantities, which must
 * be defined when a line uses them. Initial values are parameters: x0 of x, vy0 of vy, x1_0 of x1;
 * so is t0. The mass is the parameter m if there is one, else 1. If every variable has a
 * second-order equation the scene is of second order: positions, then velocities; else it is of
 * first order: variables in the order of declaration, then velocities.
 *
 * Summands of a second derivative are sorted into forces that depend on positions (and time) and
 * drag, which depends on velocities, so that splittings apply with drag=explicit. A summand with a
 * factor that is a parameter of value 0 is absent. Jacobians are derivatives of the expressions.
 * Without a typed potential the potential of the summands that depend on positions only is found if
 * it exists; what depends on time alone is a drive, whose work is counted, like that of drag. Other
 * forces have no energy: then only the kinetic energy is known.
 *
 * A model is immutable: a new line makes a new model. Models live until typed_sweep() finds them
 * unused, or until typed_destroy(). An incomplete model (a variable without an equation) can be
 * shown and set; scene_bind() reports what is missing. The natural size of a variable is the larger
 * of its
 * initial value| and its largest |value| in a short trial run of about one time constant (many, for
 * a linear system), or 1 if these are 0.
 *
 * A second-order equation in y whose right-hand side is written as a0 + a1 y + a2 y' + a3 |y'| y' +
 * a4 cos(a5 t + a6) (or with sin), with a3 <= 0 for the current parameters, is the oscillator with
 * these coefficients: it has the natural sizes, exact solution, exact drag and derived quantities
 * of the built-in one. The same holds with forces added to it.
 */

/* Returns true if each evaluation of the potential energy is a numerical integral along a path,
 * because no potential was typed and none was found in closed form. */
bool typed_potential_is_integrated(const struct system *system);

/* Kind of a typed line. */
enum typed_kind {
    TYPED_VAR,
    TYPED_PARAM,
    TYPED_EQUATION,
    TYPED_FORCE,
    TYPED_POTENTIAL,
    TYPED_OBSERVE
};

/* One typed line; its texts belong to the model or, as an argument, to the caller. */
struct typed_line {
    enum typed_kind kind;
    /* Name. For TYPED_VAR, y' means the initial velocity of y; for TYPED_FORCE, "" means the first
     * coordinate. */
    struct text name;
    int order; /* Order of a TYPED_EQUATION, 1 or 2. */
    /* Expression of all kinds but TYPED_VAR and TYPED_PARAM, with nothing behind it. */
    struct text expr;
    double value;           /* Value [SI] of TYPED_VAR and TYPED_PARAM. */
    enum quantity quantity; /* Quantity of the value; QUANTITY_NUMBER if it has no unit. */
};

/* Returns true if a variable, a parameter or an observed quantity may have this name; else sets
 * `error`. */
bool typed_name_fits(struct text name, struct error *error);

struct typed_models; /* all typed models of a session, which owns them */

/* Creates an empty set of models. Returns NULL with `error` set if out of memory. */
struct typed_models *typed_create(struct error *error);
/* Frees all models; no scene may use them any more. NULL is allowed. */
void typed_destroy(struct typed_models *models);
#define SWEEP_FROM 32 /* Number of models below which typed_sweep() frees none. */
/* Frees the models for which used() returns false, once there are SWEEP_FROM more than twice the
 * number left by the last call. */
void typed_sweep(struct typed_models *models,
                 bool (*used)(const void *context, const struct model *model), const void *context);
/* Creates a model without lines and with this name, or "" for a typed one; models made from it by
 * adding lines keep the name. Returns NULL with `error` set. */
const struct model *typed_new(struct typed_models *models, struct text name, struct error *error);
/* Returns a model with the lines of `source` and `line`, which replaces one of the same kind and
 * name. If `source` is a built-in model, var and equations begin an empty one, other kinds add to
 * it. Texts are copied. Returns NULL with `error` set, whose `where` lies in line->expr or
 * line->name. */
const struct model *typed_add(struct typed_models *models, const struct model *source,
                              const struct typed_line *line, struct error *error);
/* Returns a model with all `count` lines, which need not be valid one by one. Texts are copied.
 * Returns NULL with `error` set, also if cancelled. */
const struct model *typed_make(struct typed_models *models, struct text name,
                               const struct typed_line *line, int count,
                               const struct cancel *cancel, struct error *error);
/* Returns a model with the lines of `source` without that line; with a variable its equation and
 * initial velocity are removed, too. The result may be the built-in model below. Returns NULL with
 * `error` set if there is no such line or if others use it. */
const struct model *typed_remove(struct typed_models *models, const struct model *source,
                                 enum typed_kind kind, struct text name, struct error *error);
/* Returns the number of lines of a model, 0 for a built-in one; typed_line() returns line i. They
 * are in an order in which they can be typed again. */
int typed_lines(const struct model *model);
const struct typed_line *typed_line(const struct model *model, int i);
/* Appends a line as it is typed: "y'' = -k*y". */
void typed_describe(const struct typed_line *line, struct buffer *text);
/* Returns the built-in model to which the lines were added, the model itself if that is built in,
 * or NULL if all of it is typed. */
const struct model *typed_base(const struct model *model);
/* Returns true if only parameters were typed on a built-in model that has a parameter or variable
 * of this name. Typing a parameter of the name then begins an empty model with the typed
 * parameters. */
bool typed_base_has(const struct model *model, struct text name);

/* Returns the preset (name and settings) of a model that is all typed, else NULL. */
const struct preset *typed_preset(const struct model *model);

/* Replaces the model of a scene. Parameters that both models have keep their values, unless the new
 * model has another initial value for them. */
void scene_remodel(struct scene *scene, const struct model *model);

/* Returns the term that is the whole right-hand side of a scene that is all typed, or NULL if there
 * are several terms. */
const struct bound_term *system_whole(const struct system *system);

/* Returns the program of a typed term, whose inputs are t, y and *values values behind them, which
 * are term->c from index 1. Returns NULL for a built-in term. */
const struct program *term_program(const struct bound_term *term, int *values);

/*
 * ---- switches ----
 *
 * A switch is an expression at whose sign, or integer part, a force changes its formula: in typed
 * equations abs(), sign(), if(), <, min(), max(), step(), floor() and mod(); and the velocity for
 * dry friction. The formulas on the two sides are its branches. A frozen system uses the same
 * branches for all states, so that it is smooth; each switch has a guard, a value that is > 0 as
 * long as its frozen branch is the right one. Arrays `branch` and `guard` have [system->switches],
 * at most LIMIT_SWITCHES.
 */

/* Computes the branches of all switches at (t [s], y). */
void system_branches(const struct system *system, double t, const double *y, double *branch);
/* Makes *frozen the system on these branches. */
void system_freeze(const struct system *system, const double *branch, struct system *frozen);
/* Computes the guards of a frozen system at (t [s], y). */
void system_guards(const struct system *frozen, double t, const double *y, double *guard);
/* Sliding is motion along `count` switches at once, when the forces on both sides push towards the
 * switch. The field is a mean of those on the sides, weighted so that all arguments remain constant
 * (Filippov 1988; for several switches the equivalent control of Utkin 1992, to which each
 * contributes a term). The guard of such a switch is > 0 as long as both weights are. If crossing
 * the switch changes only the rate of its argument, as a force does for a position, the second
 * derivative of the argument is kept 0. */
#define LIMIT_SLIDING 4
/* State of a sliding motion. system_slide() fills it, sliding_free() frees it. */
struct sliding {
    /* Number of switches along which the motion slides, and their indices. */
    int count;
    int switch_index[LIMIT_SLIDING];
    double level[LIMIT_SLIDING]; /* Value of each argument at its switch. */
    double time_shift;           /* Time [s] over which arguments are differentiated numerically. */
    /* [LIMIT_SLIDING + 1] systems: the one below all switches, then for each switch the one above
     * it alone. Owned; NULL before the first use. */
    struct system *side;
};

/* Makes *frozen the system on these branches that slides along the switches i with slides[i];
 * `slides` has [system->switches], time_offset [s] becomes time_shift. *frozen points to *sliding,
 * which is zeroed or was filled before. Returns false if there are more than LIMIT_SLIDING or if
 * out of memory. */
bool system_slide(const struct system *system, const double *branch, const bool *slides,
                  double time_offset, struct sliding *sliding, struct system *frozen);
/* Frees the systems of *sliding. */
void sliding_free(struct sliding *sliding);
/* Moves the state y back onto the switches from which errors of steps have moved it. Returns true
 * if it has changed the state. */
bool sliding_return(const struct sliding *sliding, double t, double *y);
/* Returns true if the motion crosses switch i instead of sliding along it. Only possible where
 * jumps change only the rate of its argument: if this rate is larger than what the jumps change in
 * `tolerance` [s]. */
bool sliding_passes(const struct sliding *sliding, int i, double t, const double *y,
                    double tolerance);

/* Moves a state that is at switch i but for rounding exactly onto it, if that is known how: for dry
 * friction it sets the velocity to 0. */
void system_end_at_switch(const struct system *frozen, int i, double *y);

/* Returns the branch of switch i that follows when its guard becomes 0 at (t, y). */
double system_next_branch(const struct system *frozen, int i, double t, const double *y);

/* Returns the branch below switch i at a state (t, y) from which the motion slides along it. */
double system_lower_branch(const struct system *frozen, int i, double t, const double *y);
/* Returns true if the argument of switch i depends on this state variable at (t, y). */
bool system_switch_sees(const struct system *system, int i, double t, const double *y,
                        int variable);

/* Computes bounds of the derivatives rate [n] for all states in a box [n], and of their Jacobian
 * [n][n], which may be NULL. Drives are left out, which gives means over their period. Returns
 * false if the scene is not all typed or if its forces are not periodic in time. */
bool system_bounds(const struct system *system, const struct interval *box, struct interval *rate,
                   struct interval *jacobian);

/* Returns the number of observed quantities of a model; they have the indices 0 to count - 1. */
int model_observed(const struct model *model);
/* Returns name and quantity of observed quantity i. */
struct variable model_observed_variable(const struct model *model, int i);
/* Returns the value [SI] of observed quantity i at (t [s], y). */
double system_observe(const struct system *system, int i, double t, const double *y);
