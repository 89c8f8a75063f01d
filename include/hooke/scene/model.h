/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * model: the model of a scene (variables, parameters, force terms), the scene that users set up
 * (struct scene), the system that integrators see (struct system), energies and exact solutions.
 *
 * scene_init(), scene_set() for parameters, then scene_bind() makes a system, of which system_…()
 * compute derivatives, energies and exact solutions. Scenes and systems are plain values that can
 * be copied; they point to models, which outlive them. Nothing in a system is freed.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/limit.h>
#include <hooke/base/quantity.h>
#include <hooke/base/row.h>

struct catalog;

/*
 * ---- parameters ----
 *
 * src/scene/model/terms.def lists the force terms of the oscillator with their parameters, from
 * which the catalog is made. The index of a parameter in the catalog of its model is its index in
 * scene.value.
 */

/* Largest number of switches (points where a force changes its formula) of typed equations, and of
 * all, with that of dry friction. */
#define LIMIT_TYPED_SWITCHES 12
#define LIMIT_SWITCHES (LIMIT_TYPED_SWITCHES + 1)
/* Largest number of parameters of a model. */
#define PARAM_MAX LIMIT_PARAMETERS

/* A parameter of a model. */
struct param_row {
    struct row row; /* Name, SI unit and description. */
    enum quantity quantity;
    double initial;    /* Default value [SI]. */
    double min;        /* Smallest allowed value [SI], or -HUGE_VAL. */
    bool min_excluded; /* `min` itself is not allowed. */
};

/* Parameters of the oscillator (struct param_row), at most PARAM_MAX. */
extern const struct catalog param_catalog;

/* Returns the index of a parameter of the oscillator; the name must exist, which is asserted. */
int param_index(const char *name);

struct model;

/* The equation of motion that the user sets up: a model and the values of its parameters. A plain
 * value. */
struct scene {
    /* The model, not owned. */
    const struct model *model;
    /* The preset from which the scene was made, or that of a typed scene; not owned. */
    const struct preset *preset;
    double value[PARAM_MAX];       /* Values [SI], at the index in the model's parameters. */
    double uncertainty[PARAM_MAX]; /* Standard uncertainties [SI], 0 if exact. */
    bool chosen[PARAM_MAX];        /* The user has set the value; it is not the preset's. */
    /* Methods take steps across kinks of a force at turning points, as in textbooks, instead of
     * ending a step there. */
    bool steps_across_kinks;
    /* [n] absolute error per step [SI] that adaptive methods may make in each variable; 0 if not
     * set. */
    double atol[LIMIT_VARIABLES];
};

/* A named scene: a model and values of some of its parameters. A row of preset_catalog. */
struct preset {
    /* Name, "", description, source. */
    struct row row;
    const struct model *model; /* NULL stands for the oscillator. */
    struct {
        const char *param; /* Name of a parameter; NULL ends the list. */
        double value;      /* SI */
    } value[16];           /* Values [SI] that differ from the parameters' defaults. */
    /* Duration [s] of a run that shows the effect, tolerance that it needs, and first step [s] of
     * adaptive methods. 0 stands for preset_duration(), preset_tol() and the setting dt. */
    double duration, tol, first;
};

#define LAB_DURATION 10.0 /* Duration [s] of a run if the preset sets none. */
/* Tolerance of adaptive methods if the preset sets none. */
#define LAB_TOL 1e-6

/* Returns the duration [s] of a run of the preset. */
static inline double preset_duration(const struct preset *preset)
{
    return preset->duration > 0 ? preset->duration : LAB_DURATION;
}

/* Returns the tolerance of adaptive methods for the preset. */
static inline double preset_tol(const struct preset *preset)
{
    return preset->tol > 0 ? preset->tol : LAB_TOL;
}

/* All presets (struct preset). */
extern const struct catalog preset_catalog;
/* Returns the preset with exactly this name or alias, or NULL. */
const struct preset *preset_by_name(struct text name);
/* Returns preset i of the catalog. */
const struct preset *preset_at(size_t i);
/* Returns the preset whose struct row this is; it must be in preset_catalog. */
const struct preset *preset_from(const struct row *row);

/* Return the catalogs of the parameters (struct param_row), whose index is that in scene.value, and
 * of the derived quantities (struct derived_row) of the scene's model. */
const struct catalog *scene_params(const struct scene *scene);
const struct catalog *scene_derived(const struct scene *scene);
/* Return the index of the parameter of this name or alias, or -1 if the scene has none. */
int scene_param(const struct scene *scene, const char *name);
int scene_param_at(const struct scene *scene, struct text name);
/* Returns parameter `index` of the scene's model. */
const struct param_row *param_at(const struct scene *scene, int index);
/* Returns the value [SI] of a parameter, or NAN if the scene has none of this name. */
double param_value(const struct scene *scene, const char *name);
/* Returns true if the scene has the parameter and the user has set it. */
bool param_chosen(const struct scene *scene, const char *name);
/* Returns true if the model is the oscillator, with or without typed forces. */
bool is_oscillator(const struct scene *scene);
/* Returns true if the model is the pendulum with a rigid rod. */
bool is_pendulum(const struct scene *scene);

/* Makes *scene the scene of a preset, or the preset "spring" if `preset` is NULL. */
void scene_init(struct scene *scene, const struct preset *preset);
/* Sets parameter `param` to a value [SI] with its uncertainty. Returns false, with `error` set and
 * the scene unchanged, if the value is outside its range (m > 0, …), not finite, or not possible
 * with the other parameters (k/m overflows). */
bool scene_set(struct scene *scene, int param, struct measured value, struct error *error);
/* Sets the absolute tolerance [SI] of a variable; 0 means none. */
void scene_set_atol(struct scene *scene, int variable, double atol);
/* Sets a parameter back to the preset's value, or to its default. */
void scene_unset(struct scene *scene, int param);

/* A quantity that follows from the parameters: omega0, T0, f0, zeta, Q, omega_d, T_d, equilibrium,
 * … */
struct derived_row {
    struct row row;
    enum quantity quantity;
    /* Returns the value [SI] and its propagated uncertainty; NAN where it is not defined. */
    struct measured (*value)(const struct scene *scene);
    /* Returns the value [SI] of the parameter `target` that gives this value (omega0, T0 and f0 set
     * k). NULL if the quantity cannot be set. */
    double (*inverse)(const struct scene *scene, double value);
    /* Name of the parameter that setting the quantity changes, or NULL. */
    const char *target;
};

extern const struct catalog derived_catalog; /* Derived quantities of the oscillator. */

/* Sets the row's target parameter so that the quantity has this value [SI]; the uncertainty is
 * propagated. Returns false, with `error` set and the scene unchanged, if that is not possible. */
bool scene_set_derived(struct scene *scene, const struct derived_row *row, struct measured value,
                       struct error *error);

/* scene_reynolds() returns the Reynolds number rho v length / eta for a speed v [m/s], or NAN
 * unless the scene is an oscillator. reynolds_regime() returns the name of the regime of a Reynolds
 * number: "laminar", "transitional" or "turbulent". */
double scene_reynolds(const struct scene *scene, double speed);
const char *reynolds_regime(double reynolds);

/*
 * ---- models: variables and their laws ----
 *
 * A built-in model has a file src/scene/model/NAME.c with its variables, parameters and terms,
 * which ends in its struct model, and a line in models.c. The oscillator, to which most forces
 * belong, is in terms.def. A typed model is made of the user's lines (<hooke/scene/typed.h>).
 */

struct system;

/* Name and quantity of a state variable or another column. */
struct variable {
    char name[LIMIT_SYMBOL + 1];
    enum quantity quantity;
};

/* A model; immutable. */
struct model {
    /* Name, "", description, source. */
    struct row row;
    int order; /* 2 if the state is n/2 positions, then their velocities; else 1. */
    /* Number of state variables. */
    int n;
    const struct variable *variable; /* [n] state variables. */
    /* Rows of struct param_row, struct term_row and struct derived_row. */
    const struct catalog *params, *terms, *derived;
    /* Checks rules that concern several parameters [SI]; returns false with `error` set. NULL if
     * there are none. */
    bool (*coherent)(const double *param, struct error *error);
    /* Sets t0, start, mass and scale (natural sizes, > 0) of a system whose terms are bound; param
     * [PARAM_MAX] are the values of the parameters [SI]. */
    void (*begin)(const double *param, struct system *system);
    /* Computes the exact solution as system_exact() does. NULL if there is none, or if it is that
     * of the linear oscillator. */
    void (*exact)(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
    const struct typed *typed; /* The user's lines of a typed model, or NULL for a built-in one. */
};

/* The oscillator, the model of most presets. */
extern const struct model oscillator_model;
/* All built-in models, the oscillator first; NULL ends the list. */
extern const struct model *const scene_models[];

/* ---- terms and the bound system ---- */

/* Largest number of coefficients of a built-in term. */
#define TERM_COEFFICIENTS 6
/* Largest number of coefficients of a typed term: a pointer to the term, and up to 63 parameters.
 */
#define TERM_VALUES 64
/* Largest number of terms of a system. */
#define TERM_MAX 16
/* Largest number of accelerations or derivatives of a built-in model. */
#define LIMIT_MODEL_ROWS 3

/* Properties of a force term. */
enum term_flag {
    TERM_LINEAR = 1,       /* Linear in the state, or independent of it. */
    TERM_VELOCITY = 2,     /* Depends on a velocity. */
    TERM_TIME = 4,         /* Depends on time. */
    TERM_CONSERVATIVE = 8, /* Has a potential; otherwise it has a power. */
    TERM_KINK = 16,        /* Not smooth where the velocity is 0, in a scene of one coordinate. */
    /* Dry friction, always the last term, in a scene of one coordinate. Its coefficients are c[0] =
     * F/m [m/s^2] and c[1] = F [N]. */
    TERM_DRY = 32,
};

/*
 * The system as one oscillator,
 *
 *   q'' = -stiffness q - damping q' - quadratic |q'| q' - friction sign(q') - gravity
 *         + drive cos(omega t + phase).
 *
 * Closed-form steps and exact solutions use it if `whole` is true: no other force acts. The exact
 * flow of drag needs only drag_whole; with several coordinates it is v_i' = -damping v_i for each.
 */
struct oscillator {
    double stiffness; /* [1/s^2] k/m, any sign */
    double damping;   /* [1/s] gamma */
    double quadratic; /* [1/m] C rho area / m */
    /* [m/s^2] F/m of dry friction: the acceleration while the body moves, and its largest value at
     * rest. If the direction of the friction is frozen it is 0 here and part of `gravity`. */
    double friction;
    double gravity;      /* [m/s^2] */
    double drive;        /* [m/s^2] F0/m */
    double omega, phase; /* [rad/s] [rad] of the drive */
    /* No other force acts. */
    bool whole;
    /* No other force depends on velocity; `quadratic` acts in scenes of one coordinate only. */
    bool drag_whole;
};

/* A force term of a model, in the table of its terms. */
struct term_row {
    struct row row; /* Name, unit of what add() adds, description, source. */
    /* Flags of enum term_flag. */
    unsigned flags;
    /* Expressions that the term adds to each acceleration or derivative, as a user would type them:
     * velocities are x', parameters are called by their names. NULL adds nothing. */
    const char *equation[LIMIT_MODEL_ROWS];
    /* The expressions of `equation` in the order of operations of add(), for programs that must
     * give the same bits; NULL if `equation` has this order. */
    const char *ordered[LIMIT_MODEL_ROWS];
    /* Value of enum force (src/scene/model/forces.h), by which kernels recognise a force that is
     * compiled into them. */
    int force;
    /* Computes the coefficients c [TERM_COEFFICIENTS] from the parameters [SI], and adds the term
     * to *oscillator. Returns false if the term is absent because its coefficient is 0. NULL for
     * typed terms. */
    bool (*bind)(const double *param, double *c, struct oscillator *oscillator);
    /* Adds the term with the coefficients c of bind() at (t [s], y [n]) to the accelerations a
     * [n/2] or, in a first-order scene, to the derivatives a [n]. */
    void (*add)(const double *c, double t, const double *y, double *a);
    /* Adds the derivatives da/dy of the term, row-major with n columns, to jac. NULL if the term
     * does not depend on the state. */
    void (*jacobian)(const double *c, double t, const double *y, double *jac);
    /* Returns the potential energy [J]; NULL unless TERM_CONSERVATIVE. */
    double (*potential)(const double *c, const double *y);
    /* Returns the power [W] of a typed term without a potential; else NULL. */
    double (*power)(const double *c, double t, const double *y);
    /* Expression of the force of one coordinate as FORCE of src/scene/model/forces.h has it, or
     * NULL if only add() computes it. */
    const char *text;
};

extern const struct catalog term_catalog; /* Terms of the oscillator. */

/* Returns true for a term of a second-order scene without a potential, whose work the energy
 * balance counts. */
static inline bool term_has_power(const struct term_row *row)
{
    return row->power || (row->bind && !(row->flags & TERM_CONSERVATIVE));
}

/* A term with the coefficients of one scene. */
struct bound_term {
    const struct term_row *row;
    double c[TERM_VALUES]; /* Coefficients; of a built-in term only TERM_COEFFICIENTS are set. */
};

/* Returns true if both have the same row and coefficients. */
bool bound_term_equal(const struct bound_term *a, const struct bound_term *b);

/* A scene with its coefficients: the differential equation that is integrated. Made by
 * scene_bind(). */
struct system {
    const struct model *model;
    int n;     /* Number of state variables, at most LIMIT_VARIABLES. */
    int order; /* 2 or 1, as the model's. */
    /* Number of terms with coefficients other than 0. */
    int terms;
    struct bound_term term[TERM_MAX];
    /* Sum of all typed terms of a typed scene; its row is NULL if there are none. */
    struct bound_term typed;
    bool linear;     /* Every term is linear: y' = A y + b(t). */
    bool autonomous; /* No term depends on time. */
    /* Some force depends on a velocity. Dry friction counts only if `dry` is false. */
    bool velocity;
    bool conservative; /* Every term has a potential: the energy is constant. */
    /* Kinetic and potential energy are known. False if typed forces have no potential: then only
     * the kinetic energy is. */
    bool energy;
    /* Number of switches: expressions at whose sign or integer part a force changes its formula,
     * first those of typed equations, then that of dry friction. The formulas on the two sides of a
     * switch are its branches. A system that system_freeze() made uses one branch of each switch
     * for all states, so that it is smooth. */
    int switches;
    /* Frozen on one branch: its formula is also evaluated beyond the switch, where the real
     * equations may be undefined; whether a state is valid is tested on the unfrozen system. */
    bool extended;
    bool dry; /* The last switch is that of dry friction, at v = 0; false if steps go across it. */
    /* Steps of fixed size end at switches, as adaptive ones do, so that each piece of a step is on
     * one branch. False if steps go across switches, or if the system is frozen. */
    bool pieces;
    /* The motion along the switches on which a frozen system slides (keeps the argument of the
     * switch at 0), or NULL; owned by the maker of the system. */
    const struct sliding *sliding;
    bool kinks; /* n = 2, and some force has a kink at v = 0 and is not frozen there. */
    /* Methods take steps across the kinks of `kinks` instead of ending a step there, as in
     * textbooks. */
    bool steps_across_kinks;
    double mass; /* [kg] or its equivalent in other models: the kinetic energy is mass v^2/2. */
    /* Ratio of each coordinate's mass to `mass` if typed masses differ; 0 stands for 1. */
    double ratio[LIMIT_VARIABLES / 2];
    struct oscillator oscillator;
    double start[LIMIT_VARIABLES]; /* Initial state [n] at t0. */
    double t0;                     /* Initial time [s]. */
    /* Natural size [n] of each variable (amplitude, amplitude omega), > 0, by which errors are
     * measured. */
    double scale[LIMIT_VARIABLES];
    double atol[LIMIT_VARIABLES]; /* Absolute tolerances [n] of the scene. */
};

/* Makes the system of a scene. Returns false, with `error` set, if equations are incomplete,
 * parameters contradict each other, or forces at the start are not finite. */
bool scene_bind(const struct scene *scene, struct system *system, struct error *error);
/* Makes the system as scene_bind() does, but without finding the potential of typed forces, which
 * takes about a thousand evaluations: for callers that bind many scenes and need no energy. */
bool scene_bind_motion(const struct scene *scene, struct system *system, struct error *error);
/* Makes the system as scene_bind() does, for callers that only evaluate derivatives: variables of
 * typed scenes have scales of 1 instead of those of a trial run, and the start is not checked.
 * Returns false if equations are incomplete or parameters contradict each other. */
bool scene_bind_rates(const struct scene *scene, struct system *system);

/* Copies a system without the unused part of its array of terms, to save time: a struct system has
 * ten kilobytes, most of them unused. */
void system_copy(struct system *target, const struct system *source);

/* Makes methods end steps at kinks and at all switches, that of dry friction included, even if the
 * scene has asked for steps across them. */
void system_turn_at_kinks(struct system *system);

/* Computes the accelerations a [n/2] of a second-order system at (t [s], y [n]). */
void system_acceleration(const struct system *system, double t, const double *y, double *a);
/* Computes the derivatives dydt [n] at (t [s], y [n]). */
void system_derivative(const struct system *system, double t, const double *y, double *dydt);
/* Returns true if the derivatives depend on this variable and have its period 2 pi, as tested at
 * eight random states. */
bool variable_is_angle(const struct system *system, int variable);
/* Computes the accelerations a [n/2] of the terms that do not depend on velocity. */
void system_force(const struct system *system, double t, const double *y, double *a);
/* Computes the accelerations a [n/2] of the terms that depend on velocity. */
void system_drag(const struct system *system, double t, const double *y, double *a);
/* Coefficients of the exact flow of v' = -gamma v - c |v| v over a step h (Hairer, Lubich, Wanner
 * 2006, II.5), computed once for many v: v becomes v keep/(min + pull |v|). The flow keeps the sign
 * of v and is exact at v = 0. For h < 0 quadratic drag has a pole, beyond which the result is
 * infinite. */
struct drag_flow {
    double keep, min, pull;
};

/* Returns the coefficients for a step h [s] of any sign. */
struct drag_flow oscillator_drag_flow(const struct oscillator *oscillator, double h);

/* Returns the velocity after the step for which `flow` was made, for a velocity v before it. */
static inline double drag_flow_apply(const struct drag_flow *flow, double v)
{
    double denominator = flow->pull == 0 ? flow->min : flow->min + flow->pull * fabs(v);
    if (!(denominator > 0))
        return copysign(HUGE_VAL, v);
    return flow->min == 1 && flow->pull == 0 ? v * flow->keep : v * flow->keep / denominator;
}
/* Computes the Jacobian d y'/d y [n][n], row-major, at (t [s], y [n]). */
void system_jacobian(const struct system *system, double t, const double *y, double *jac);
/* Computes the Jacobian in new memory, which the caller frees: for 64 variables it has 32 kB, too
 * much for the stack of a thread. Returns NULL if out of memory. */
double *system_new_jacobian(const struct system *system, double t, const double *y);

/* An interval in time that adaptive steps must not step over. */
struct burst {
    double t_begin, t_end; /* [s] */
};

/* Finds the bursts between t[0] and t[1] [s]: short intervals in which a typed equation changes
 * faster than samples can show. The motion between the states y_begin and y_end is assumed to be
 * smooth, and bounds of the equation on each interval are compared with samples in it. Each burst
 * is shorter than 1/32 of t[1] - t[0]. The array burst [max] holds `count` bursts already; a new
 * one is merged with those that it overlaps, else appended, or dropped if the array is full. With
 * `sure`, which warnings need, smooth forces never give a burst; otherwise some may be reported
 * without need, which only costs steps. Returns the new count. */
int system_bursts(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, struct burst *burst, int count, int max);

/* Returns the kinetic energy [J]. */
double system_kinetic(const struct system *system, const double *y);
/* Returns the potential energy [J] of all terms that have one. */
double system_potential(const struct system *system, const double *y);
/* Returns true if every term that does not depend on velocity has a potential. */
bool system_has_potential(const struct system *system);
/* Returns the power [W] of all terms without a potential. */
double system_power(const struct system *system, double t, const double *y);
/* Returns the power [W] of drag: terms that depend on velocity and not on time. */
double system_dissipation(const struct system *system, double t, const double *y);

/* Returns the common period [s] of all forces that depend on time, as their expressions show it; 0
 * if none depends on time, NAN if some are not periodic or have no common period. */
double system_drive(const struct system *system);

/* Returns name and quantity of state variable i. */
struct variable system_variable(const struct system *system, int i);
/* Returns the index in the state of the variable of this name (y' is the velocity of y), or -1 if
 * there is none. */
int model_state(const struct model *model, struct text name);

/*
 * ---- exact solutions ----
 *
 * They exist for linear oscillators, typed or not, in every regime (under-, critically and
 * overdamped, k = 0, k < 0, gamma < 0, constant force, driven, resonant), by formulas without
 * cancellation; for linear oscillators with dry friction and no drive; for models with a closed
 * form of their own; and, by the matrix exponential, for other linear systems of up to 16 variables
 * with constant coefficients.
 */

/* Returns true if there is an exact solution. */
bool system_has_exact(const struct system *system);
/* Computes the state y [n] at t [s] of the solution that has the state start [n] at t0; t may be
 * before t0. Values that exceed the range of doubles are infinite. floor [n], which may be NULL,
 * receives the change of the result for a change of the coefficients by one unit in the last place
 * (in models with a closed form, of the start). It is about eps omega |t - t0| times the amplitude,
 * and errors below it mean nothing. */
void system_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
struct exact_table; /* Private to src/scene/model/exact.c. */
/* Makes a table for exact solutions at many times `h` [s] apart, which cost a fraction of
 * system_exact(): the solution is evaluated at some times, and continued between these by the
 * one-step map in long double. The results agree with system_exact() to one unit in the last place,
 * also at times between. Returns NULL if a table has no advantage for this system or step, or if
 * out of memory. The system must outlive the table. */
struct exact_table *exact_table_create(const struct system *system, double t0, const double *start,
                                       double h);
/* Computes the state y [n] at t [s], as system_exact() does. */
void exact_table_at(struct exact_table *table, double t, double *y);
/* Frees a table; NULL is allowed. */
void exact_table_free(struct exact_table *table);
