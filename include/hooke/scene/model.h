/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Models: parameters, force terms, exact solutions. */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/limit.h>
#include <hooke/base/quantity.h>
#include <hooke/base/row.h>

struct catalog;

/* ---- parameters ----
 *
 * src/scene/model/terms.def lists each force term with its parameters; the table comes from there.
 * A parameter is known by its row; its place in the table indexes scene.value.
 */

/* Largest number of switches of typed equations (scene/typed.h), and with that of dry friction. */
#define LIMIT_TYPED_SWITCHES 12
#define LIMIT_SWITCHES (LIMIT_TYPED_SWITCHES + 1)
#define PARAM_MAX LIMIT_PARAMETERS

struct param_row {
    struct row row; /* name, SI unit, brief */
    enum quantity quantity;
    double initial;    /* default, SI */
    double min;        /* smallest value allowed, -HUGE_VAL: any */
    bool min_excluded; /* value > min */
};

/* those of the oscillator: struct param_row, at most PARAM_MAX */
extern const struct catalog param_catalog;

int param_index(const char *name); /* the name has to exist in that table (asserted) */

struct model;

struct scene {
    const struct model *model;
    const struct preset *preset;
    double value[PARAM_MAX];       /* SI */
    double uncertainty[PARAM_MAX]; /* one standard uncertainty; 0 if exact */
    bool chosen[PARAM_MAX];        /* set by the user since the preset */
    bool steps_across_kinks; /* methods step across kinks at turning points, as they are printed */
    /* [n] errors of adaptive methods that do not matter, SI; 0 if not given */
    double atol[LIMIT_VARIABLES];
};

/* Settings of a model under a name. */
struct preset {
    struct row row;
    const struct model *model; /* NULL stands for the oscillator */
    struct {
        const char *param; /* NULL ends the list */
        double value;      /* SI */
    } value[16];           /* values that differ from the parameters' defaults */
    /* Time [s] that the shown effect takes, the tolerance that it needs, and a first step [s] of
     * adaptive methods. 0 stands for the lab's value (preset_duration() and so on; for the first
     * step the setting dt). */
    double duration, tol, first;
};

#define LAB_DURATION 10.0 /* [s] */
#define LAB_TOL 1e-6

static inline double preset_duration(const struct preset *preset)
{
    return preset->duration > 0 ? preset->duration : LAB_DURATION;
}

static inline double preset_tol(const struct preset *preset)
{
    return preset->tol > 0 ? preset->tol : LAB_TOL;
}

extern const struct catalog preset_catalog;
/* finds it by exact name or alias; NULL if there is none */
const struct preset *preset_by_name(struct text name);
const struct preset *preset_at(size_t i);
const struct preset *preset_from(const struct row *row); /* row has to be one of the catalog's */

/* The parameters and derived quantities of the scene's model; places in them index scene.value. */
const struct catalog *scene_params(const struct scene *scene);
const struct catalog *scene_derived(const struct scene *scene);
/* place, -1 if this scene has no such parameter */
int scene_param(const struct scene *scene, const char *name);
int scene_param_at(const struct scene *scene, struct text name);
const struct param_row *param_at(const struct scene *scene, int index);
/* Returns NAN if the scene has no such parameter */
double param_value(const struct scene *scene, const char *name);
bool param_chosen(const struct scene *scene, const char *name);
bool is_oscillator(const struct scene *scene); /* also with forces that were typed */
bool is_pendulum(const struct scene *scene);   /* true for one with a rigid rod */

/* Initializes the scene from a preset, or as "spring" with the lab's defaults if it is NULL */
void scene_init(struct scene *scene, const struct preset *preset);
/* Checks the range (m > 0, …, finite) and that k/m does not overflow; the scene is unchanged on
 * error. */
bool scene_set(struct scene *scene, int param, struct measured value, struct error *error);
void scene_set_atol(struct scene *scene, int variable, double atol); /* atol 0 if not given */
void scene_unset(struct scene *scene, int param); /* back to the preset's value */

/* Quantities that follow from the parameters: omega0, T0, f0, zeta, Q, omega_d, T_d, equilibrium …
 * NaN where not defined. */
struct derived_row {
    struct row row;
    enum quantity quantity;
    /* computes the value and its propagated uncertainty */
    struct measured (*value)(const struct scene *scene);
    /* Returns the value of the target parameter that gives this value (omega0, T0 and f0 set k).
     * NULL if the value cannot be set. */
    double (*inverse)(const struct scene *scene, double value);
    const char *target;
};

extern const struct catalog derived_catalog; /* those of the oscillator */

/* Sets the row's target parameter so that the quantity takes this value; the uncertainty goes with
 * it. */
bool scene_set_derived(struct scene *scene, const struct derived_row *row, struct measured value,
                       struct error *error);

/* Re = rho v length / eta for a speed [m/s], NaN unless the scene is an oscillator; regime in
 * words: "laminar", "transitional", "turbulent". */
double scene_reynolds(const struct scene *scene, double speed);
const char *reynolds_regime(double reynolds);

/* ---- models: moving things and their laws ----
 *
 * A model has one file, src/scene/model/NAME.c, with its variables, parameters and terms, which
 * ends in its struct model, and one line in models.c. The oscillator (the spring and all that can
 * be hung on it) is terms.def.
 */

struct system;

struct variable {
    char name[LIMIT_SYMBOL + 1];
    enum quantity quantity;
};

struct model {
    struct row row;
    int order; /* 2 if positions come first, then velocities; otherwise 1 */
    int n;
    const struct variable *variable; /* [n] */
    const struct catalog *params, *terms,
        *derived; /* struct param_row, struct term_row, struct derived_row */
    /* rules beyond each parameter's range; NULL if there is none */
    bool (*coherent)(const double *param, struct error *error);
    /* Fills t0, start, mass and scale (natural sizes, > 0) once the terms are bound. */
    void (*begin)(const double *param, struct system *system);
    /* Computes the same as system_exact(). NULL if there is no closed form, or that of the linear
     * oscillator. */
    void (*exact)(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
    const struct typed *typed; /* lines typed by a user; NULL for one of scene_models */
};

extern const struct model oscillator_model;
/* all models, the oscillator first; NULL ends the list */
extern const struct model *const scene_models[];

/* ---- terms and the bound system ---- */

#define TERM_COEFFICIENTS 6
/* coefficients of a typed term: the term itself, and up to 63 parameters that it reads */
#define TERM_VALUES 64
#define TERM_MAX 16
#define LIMIT_MODEL_ROWS 3 /* accelerations or derivatives of a built-in model */

enum term_flag {
    TERM_LINEAR = 1,       /* linear in the state, or independent of it */
    TERM_VELOCITY = 2,     /* depends on velocity */
    TERM_TIME = 4,         /* depends on time */
    TERM_CONSERVATIVE = 8, /* has a potential; otherwise it has a power */
    TERM_KINK = 16,        /* not smooth where the velocity is 0, in a scene of one coordinate */
    TERM_DRY = 32, /* dry friction: the last term, that of one coordinate, c[0] [m/s^2], c[1] [N] */
};

/*
 * The scene as one oscillator, where it is one:
 *   q'' = -stiffness q - damping q' - quadratic |q'| q' - friction sign(q') - gravity
 *         + drive cos(omega t + phase).
 * Closed-form steps and exact solutions use it where it is `whole`: nothing else acts. Exact drag
 * flows need no more than `drag_whole`; with several coordinates it is that of each: v_i' =
 * -damping v_i.
 */
struct oscillator {
    double stiffness; /* [1/s^2] k/m, any sign */
    double damping;   /* [1/s] gamma */
    double quadratic; /* [1/m] C rho area / m */
    /* [m/s^2] F/m, at rest what it takes; frozen on a branch it is part of gravity */
    double friction;
    double gravity;      /* [m/s^2] */
    double drive;        /* [m/s^2] F0/m */
    double omega, phase; /* [rad/s] [rad] */
    bool whole;
    /* no force depends on velocity but damping and quadratic (the latter with one coordinate
     * only) */
    bool drag_whole;
};

struct term_row {
    struct row row; /* name, unit of what `add` adds, brief, citation */
    unsigned flags;
    /* Expressions that the term adds to each row, as a user would type them. Velocities are x', and
     * parameters go by their names. NULL adds nothing. */
    const char *equation[LIMIT_MODEL_ROWS];
    /* The same in the order of `add`, where a text in the order of `equation` would be rounded in
     * another way, else NULL. */
    const char *ordered[LIMIT_MODEL_ROWS];
    /* enum force of src/scene/model/forces.h, whose text is compiled again by kernels */
    int force;
    /* Computes the coefficients from the parameters, and adds them to `oscillator`, too. Returns
     * false if the term is absent because its coefficient is zero. */
    bool (*bind)(const double *param, double *c, struct oscillator *oscillator);
    /* Adds to the accelerations [n/2] or, in a first-order scene, to the derivatives [n]. */
    void (*add)(const double *c, double t, const double *y, double *a);
    /* Adds d a / d y, a row of n for each a, row-major. NULL if the term does not depend on the
     * state. */
    void (*jacobian)(const double *c, double t, const double *y, double *jac);
    double (*potential)(const double *c, const double *y); /* [J], NULL unless TERM_CONSERVATIVE */
    /* [W] of typed terms without a potential; NULL otherwise */
    double (*power)(const double *c, double t, const double *y);
    /* Expression that a term of one coordinate adds, as FORCE of src/scene/model/forces.h has it.
     * NULL if only `add` knows it. */
    const char *text;
};

extern const struct catalog term_catalog; /* those of the oscillator */

/* Returns true for a term of a scene of second order whose work counts: it has no potential. */
static inline bool term_has_power(const struct term_row *row)
{
    return row->power || (row->bind && !(row->flags & TERM_CONSERVATIVE));
}

struct bound_term {
    const struct term_row *row;
    double c[TERM_VALUES]; /* set: TERM_COEFFICIENTS, all of a typed term */
};

/* the same row and coefficients */
bool bound_term_equal(const struct bound_term *a, const struct bound_term *b);

struct system {
    const struct model *model;
    int n;     /* state variables, at most LIMIT_VARIABLES */
    int order; /* 2 or 1 */
    int terms;
    struct bound_term term[TERM_MAX];
    /* All typed terms at once, in a typed scene. Its row is NULL if there is no such term. */
    struct bound_term typed;
    bool linear;       /* every term TERM_LINEAR: y' = A y + b(t) */
    bool autonomous;   /* no TERM_TIME */
    bool velocity;     /* some force depends on velocity, but for dry friction that is located */
    bool conservative; /* every term has a potential: energy is constant */
    /* True if both kinetic and potential energy are known. False if typed forces have no potential,
     * which leaves the kinetic energy only. */
    bool energy;
    /* Number of switches, with branches that can be frozen: first those of typed equations, then
     * that of dry friction. */
    int switches;
    /* A frozen branch may have values where the equations have none; the system that is not frozen
     * decides. */
    bool extended;
    bool dry; /* the last of them is that of dry friction, at v = 0 */
    /* steps of fixed size, too, end at switches: unless they go across, or it is frozen */
    bool pieces;
    /* Sliding along switches of a frozen system; NULL if it slides along none. */
    const struct sliding *sliding;
    bool kinks; /* n = 2, and some force is not smooth at v = 0, where it is not frozen */
    bool steps_across_kinks; /* methods step across such kinks, as they are printed */
    double mass;             /* [kg] or what takes its place: kinetic energy = mass v^2 / 2 */
    /* Ratio of the mass of each coordinate to `mass`, where typed masses differ. 0 stands for 1. */
    double ratio[LIMIT_VARIABLES / 2];
    struct oscillator oscillator;
    double start[LIMIT_VARIABLES]; /* state at t0 */
    double t0;                     /* [s] */
    /* natural size of each variable (amplitude, amplitude * omega): error norms; > 0 */
    double scale[LIMIT_VARIABLES];
    double atol[LIMIT_VARIABLES]; /* as the scene's */
};

bool scene_bind(const struct scene *scene, struct system *system, struct error *error);
/* Binds the scene without looking for the potential of typed forces, which takes about a thousand
 * evaluations. It suits callers that bind many scenes and ask for no energy. */
bool scene_bind_motion(const struct scene *scene, struct system *system, struct error *error);
/* Binds the scene for rates only: typed variables have scales of 1 (others cost a trial run), and
 * any start will do. */
bool scene_bind_rates(const struct scene *scene, struct system *system);

/* Copies what is set of a system: its terms leave most of its ten kilobytes unused. */
void system_copy(struct system *target, const struct system *source);

/* As if methods did not step across kinks. */
void system_turn_at_kinks(struct system *system);

/* [n/2], order 2 only */
void system_acceleration(const struct system *system, double t, const double *y, double *a);
/* [n] */
void system_derivative(const struct system *system, double t, const double *y, double *dydt);
/* Returns true if everything repeats when this variable grows by 2 pi, as checked at some
 * states. */
bool variable_is_angle(const struct system *system, int variable);
/* Only the terms that do not depend on velocity. */
void system_force(const struct system *system, double t, const double *y, double *a);
/* Only the terms that do depend on velocity. */
void system_drag(const struct system *system, double t, const double *y, double *a);
/*
 * Exact flow of v' = -gamma v - c |v| v over h (Hairer, Lubich, Wanner 2006, II.5), prepared once
 * for many v: v keep/(min + pull |v|). Sign-preserving, exact at v = 0. Backwards in time
 * quadratic drag has a pole: infinite beyond it.
 */
struct drag_flow {
    double keep, min, pull;
};

struct drag_flow oscillator_drag_flow(const struct oscillator *oscillator, double h);

static inline double drag_flow_apply(const struct drag_flow *flow, double v)
{
    double denominator = flow->pull == 0 ? flow->min : flow->min + flow->pull * fabs(v);
    if (!(denominator > 0))
        return copysign(HUGE_VAL, v);
    return flow->min == 1 && flow->pull == 0 ? v * flow->keep : v * flow->keep / denominator;
}
/* d y'/d y, [n][n] row-major */
void system_jacobian(const struct system *system, double t, const double *y, double *jac);
/* The same as new memory, to be given back by free(); NULL if there is none. For 64 variables it
 * would be half a stack. */
double *system_new_jacobian(const struct system *system, double t, const double *y);

/*
 * Finds short intervals between t[0] and t[1] [s] in which a typed equation changes faster than
 * samples can show, along the smooth path from one state to another, by bounds of the equation.
 * Each is shorter than 1/32 of the whole. Appends them to the list, merges those that overlap, and
 * returns the new count, at most `max`. With `sure`, needed for warnings, smooth forces never give
 * one; otherwise some may be reported without need, which only costs steps.
 */
struct burst {
    double t_begin, t_end; /* [s] */
};

int system_bursts(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, struct burst *burst, int count, int max);

double system_kinetic(const struct system *system, const double *y);   /* [J] */
double system_potential(const struct system *system, const double *y); /* [J] */
bool system_has_potential(const struct system *system); /* all forces but drag have one */
/* [W] of the non-conservative terms */
double system_power(const struct system *system, double t, const double *y);
/* [W] of the drag terms alone, <= 0 */
double system_dissipation(const struct system *system, double t, const double *y);

/* Returns the period [s] with which all forces repeat in time, as the expressions show it. Returns
 * 0 if none depends on time, and NAN if some do not repeat, or not together. */
double system_drive(const struct system *system);

/* describes state variable i */
struct variable system_variable(const struct system *system, int i);
/* Place in the state of a variable's name; y' is the velocity of y. Returns -1 if there is none. */
int model_state(const struct model *model, struct text name);

/* ---- exact solutions ----
 *
 * For linear oscillators in every regime (under-, critically and overdamped, k = 0, k < 0, gamma <
 * 0, constant force, driven, resonance, with formulas that do not cancel), typed or not; for models
 * that bring their own; by the matrix exponential for other linear systems with constant
 * coefficients and up to 16 variables; for linear oscillators with dry friction, without a drive.
 * From `start` at t0 to t (before or after t0); growth beyond double ends as infinity. floor [n],
 * or NULL: what one ulp in the coefficients (of other models: in the start) does to the answer,
 * about eps * omega * |t - t0| times the amplitude: no error below it means anything.
 */
bool system_has_exact(const struct system *system);
void system_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
/*
 * Computes the same for many times that are h [s] apart but for rounding, at a fraction of the
 * cost: it evaluates the solution anew from time to time and continues from there by the one-step
 * map in long double. Accurate to an ulp of system_exact(); other times are accurate, too. Returns
 * NULL if it has no advantage for this system or step, or if out of memory. The system must outlive
 * the table.
 */
struct exact_table;
struct exact_table *exact_table_create(const struct system *system, double t0, const double *start,
                                       double h);
void exact_table_at(struct exact_table *table, double t, double *y);
void exact_table_free(struct exact_table *table);
