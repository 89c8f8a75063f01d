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
 *   var y' = 0.5           the initial velocity of y, if y has a second-order equation
 *   param mu = 1000        a parameter, used by name: changing it acts at once
 *   x' = EXPR              first order
 *   y'' = EXPR             second order: y' or vy in expressions is its velocity
 *   force EXPR             [N], divided by the mass: added to the first coordinate
 *   force x = EXPR         [N], divided by the mass: added to the coordinate x
 *   potential EXPR         [J], of the forces that depend on positions only
 *   observe E = EXPR       a quantity to look at, and a name for the lines below it
 *
 * Adding a force removes a typed potential, which does not include the new force. If lines are
 * added to a built-in scene, a typed potential is that of the typed forces alone.
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
 * it exists. A summand that depends on time alone is a drive, whose work is counted, like that of
 * drag. For other forces no energy is defined: then only the kinetic energy is known.
 *
 * A model is immutable: a new line makes a new model. Models live until typed_sweep() finds them
 * unused, or until typed_destroy(). An incomplete model (a variable without an equation) can be
 * shown and set; scene_bind() reports what is missing. The natural size of a variable is the
 * largest magnitude that it has at the start and in a short trial run of about one time constant
 * (many, for a linear system), or 1 if it is always 0.
 *
 * A second-order equation in y whose right-hand side is written as a0 + a1 y + a2 y' + a3 |y'| y' +
 * a4 cos(a5 t + a6) (or with sin), with a3 <= 0 for the current parameters, is the oscillator with
 * these coefficients: it has the natural sizes, exact solution, exact drag and derived quantities
 * of the built-in one, also after forces have been added to it.
 */

/* Returns true if each evaluation of the potential energy is a numerical integral along a path,
 * because no potential was typed and none was found in closed form. */
bool typed_potential_is_integrated(const struct system *system);

/* Kind of a typed line, after its first word; equations have none. */
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
    /* Name that the line defines or belongs to. For TYPED_VAR, y' means the initial velocity of y;
     * for TYPED_FORCE, "" means the first coordinate. */
    struct text name;
    int order; /* Order of a TYPED_EQUATION, 1 or 2. */
    /* Expression, with no text behind it; unused for TYPED_VAR and TYPED_PARAM. */
    struct text expr;
    double value;           /* Value [SI] of TYPED_VAR and TYPED_PARAM. */
    enum quantity quantity; /* Quantity of the value; QUANTITY_NUMBER if it has no unit. */
};

/* Returns true if a variable, a parameter or an observed quantity may have this name; else sets
 * `error`. */
bool typed_name_fits(struct text name, struct error *error);

struct typed_models; /* All typed models of a session, which owns them. */

/* Creates an empty set of models. Returns NULL with `error` set if out of memory. */
struct typed_models *typed_create(struct error *error);
/* Frees all models; no scene may use them any more. NULL is allowed. */
void typed_destroy(struct typed_models *models);
#define SWEEP_FROM 32 /* typed_sweep() frees none of fewer models than this. */
/* Frees the models for which used(context, model) returns false. Does nothing until there are
 * SWEEP_FROM more models than twice the number that its last call left. */
void typed_sweep(struct typed_models *models,
                 bool (*used)(const void *context, const struct model *model), const void *context);
/* Creates a model without lines. `name` is the name of a scene of which this is the model, or "" if
 * the user types it line by line; models made from it by adding lines keep the name. Returns NULL
 * with `error` set. */
const struct model *typed_new(struct typed_models *models, struct text name, struct error *error);
/* Returns a model with the lines of `source` and `line`, which replaces one of the same kind and
 * name. If `source` is a built-in model, lines of kind var or equation begin a new model without
 * it, other kinds are added to it. Texts are copied. Returns NULL with `error` set, whose `where`
 * lies in line->expr or line->name. */
const struct model *typed_add(struct typed_models *models, const struct model *source,
                              const struct typed_line *line, struct error *error);
/* Returns a model with the lines line [count], which are checked only together, so that one may use
 * names that a later one defines. Texts are copied. Returns NULL with `error` set, also if
 * cancelled. */
const struct model *typed_make(struct typed_models *models, struct text name,
                               const struct typed_line *line, int count,
                               const struct cancel *cancel, struct error *error);
/* Returns a model with the lines of `source` but the one of this kind and name; with a variable its
 * equation and initial velocity are removed, too. If no line remains, the result is the built-in
 * model to which the lines had been added. Returns NULL with `error` set if there is no such line
 * or if other lines use its name. */
const struct model *typed_remove(struct typed_models *models, const struct model *source,
                                 enum typed_kind kind, struct text name, struct error *error);
/* Returns the number of lines of a model, 0 for a built-in one; typed_line() returns line i. Lines
 * are in an order in which a user can type them again. */
int typed_lines(const struct model *model);
const struct typed_line *typed_line(const struct model *model, int i);
/* Appends a line as a user types it, such as "y'' = -k*y". */
void typed_describe(const struct typed_line *line, struct buffer *text);
/* Returns the built-in model to which the lines were added, the model itself if that is built in,
 * or NULL if all of it is typed. */
const struct model *typed_base(const struct model *model);
/* Returns true if the user has added only parameters to a built-in model, and that model has a
 * parameter or variable of this name. Typing a parameter of this name then begins a new model
 * without the built-in one, with the typed parameters. */
bool typed_base_has(const struct model *model, struct text name);

/* Returns the preset (name and settings) of a model all of whose equations are typed, else NULL. */
const struct preset *typed_preset(const struct model *model);

/* Replaces the model of a scene. Parameters and absolute tolerances that both models have keep
 * their values, except parameters whose default value differs between the two. */
void scene_remodel(struct scene *scene, const struct model *model);

/* Returns the term that is the complete right-hand side of a scene all of whose equations are
 * typed, or NULL if there are several terms or if the scene has a built-in model. */
const struct bound_term *system_whole(const struct system *system);

/* Returns the program of a typed term. Its inputs are t, y [n], then *values parameters, which are
 * term->c[1] to term->c[*values]. Returns NULL for a built-in term. */
const struct program *term_program(const struct bound_term *term, int *values);

/*
 * ---- switches ----
 *
 * A switch is an expression at whose sign, or integer part, a force changes its formula: in typed
 * equations the argument of abs(), sign(), if(), <, min(), max(), step(), floor() or mod(); for dry
 * friction the velocity. The formulas on the two sides of a switch are its branches, which numbers
 * of type double denote: the sign or the integer part. A frozen system uses the same branches for
 * all states, so that it is smooth; each switch has a guard, a value that is > 0 as long as its
 * frozen branch is the one that belongs to the state. There are at most LIMIT_SWITCHES switches.
 */

/* Computes the branches branch [system->switches] of all switches at (t [s], y). */
void system_branches(const struct system *system, double t, const double *y, double *branch);
/* Makes *frozen the system on the branches branch [system->switches], which it uses whatever its
 * state is. */
void system_freeze(const struct system *system, const double *branch, struct system *frozen);
/* Computes the guards guard [system->switches] of a frozen system at (t [s], y). */
void system_guards(const struct system *frozen, double t, const double *y, double *guard);
/* Sliding is motion along `count` switches at once: the forces on both sides of each push towards
 * it, so that the motion stays where the argument of the switch has its value. The derivatives are
 * a weighted mean of those on the two sides, with weights that keep all arguments constant
 * (Filippov 1988; for several switches the equivalent control of Utkin 1992, to which each
 * contributes a term). The guard of such a switch is > 0 as long as both of its weights are. If
 * crossing the switch changes only the rate of its argument, as a force does for a position, the
 * second derivative of the argument is kept 0. */
#define LIMIT_SLIDING 4
/* State of a sliding motion. system_slide() fills it, sliding_free() frees it. */
struct sliding {
    /* Number of switches along which the motion slides, and their indices. */
    int count;
    int switch_index[LIMIT_SLIDING];
    /* Value [count] that the argument of each switch has at the switch. */
    double level[LIMIT_SLIDING];
    /* Time difference [s] for derivatives of the arguments by finite differences. */
    double time_shift;
    /* [LIMIT_SLIDING + 1] frozen systems: side[0] is on the lower branch of all switches, side[1 +
     * k] on the upper branch of switch k alone. Owned; NULL before the first use. */
    struct system *side;
};

/* Makes *frozen the system on the branches branch [system->switches] that slides along each switch
 * i for which slides[i] is true; `slides` has [system->switches]. *frozen points to *sliding, which
 * must be zeroed or have been filled before, and whose time_shift becomes time_offset [s]. Returns
 * false if there are more than LIMIT_SLIDING such switches or if out of memory. */
bool system_slide(const struct system *system, const double *branch, const bool *slides,
                  double time_offset, struct sliding *sliding, struct system *frozen);
/* Frees the systems of *sliding. */
void sliding_free(struct sliding *sliding);
/* Moves the state y, which errors of steps have moved off the switches along which it slides, back
 * onto them. Returns true if y has changed. */
bool sliding_return(const struct sliding *sliding, double t, double *y);
/* Returns true if the motion at (t [s], y) crosses switch i instead of sliding along it: the rate
 * of its argument is larger than what the forces on its two sides can change within `tolerance`
 * [s]. Always false if crossing the switch changes more than the rate of its argument, and for dry
 * friction. */
bool sliding_passes(const struct sliding *sliding, int i, double t, const double *y,
                    double tolerance);

/* Moves a state y that is at switch i, up to rounding, exactly onto the switch if that is possible:
 * for dry friction it sets the velocity to 0. At other switches y remains unchanged. */
void system_end_at_switch(const struct system *frozen, int i, double *y);

/* Returns the branch of switch i that follows when its guard becomes 0 at (t, y). */
double system_next_branch(const struct system *frozen, int i, double t, const double *y);

/* Returns the lower one of the two branches that meet at switch i, for a state (t, y) at this
 * switch. */
double system_lower_branch(const struct system *frozen, int i, double t, const double *y);
/* Returns true if the argument of switch i depends on this state variable at (t, y). */
bool system_switch_sees(const struct system *system, int i, double t, const double *y,
                        int variable);

/* Computes bounds rate [n] of the derivatives for all states in the intervals box [n], and bounds
 * jacobian [n][n] of their Jacobian; `jacobian` may be NULL. Drives are left out, so that the
 * bounds hold for means over their period. Returns false if not all equations of the scene are
 * typed or if its forces are not periodic in time. */
bool system_bounds(const struct system *system, const struct interval *box, struct interval *rate,
                   struct interval *jacobian);

/* Returns the number of observed quantities of a model; they have the indices 0 to count - 1. */
int model_observed(const struct model *model);
/* Returns name and quantity of observed quantity i. */
struct variable model_observed_variable(const struct model *model, int i);
/* Returns the value [SI] of observed quantity i at (t [s], y). */
double system_observe(const struct system *system, int i, double t, const double *y);
