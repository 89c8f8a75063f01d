/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * scene: expressions, force terms, parameters, presets, exact solutions.
 *
 * A scene is what the user sets (parameters by name, in lab notation). scene_bind() turns it into a system: the terms
 * that are really there with their coefficients, which is all that integrators see. A term whose coefficient is zero is
 * not in the system and costs nothing.
 *
 * State vector of n variables: a second-order scene holds n/2 positions, then n/2 velocities; a first-order scene holds
 * n values. The spring is n = 2: y [m], v [m/s].
 */
#ifndef HOOKE_SCENE_H
#define HOOKE_SCENE_H

#include <hooke/base.h>

/* ---- expressions ----
 *
 * + - * / ^ ( ), unary -, numbers, pi, functions, and names that a scope knows. Compiled once (operator precedence
 * parsing with constant folding) into a stack program; values are SI numbers. `^` binds tighter than unary minus and to
 * the right: -2^2 = -4. A name may have a hyphen inside (phase-error) where the scope knows it as a whole. Inside of
 * parentheses and calls < <= > >= compare, to 1 or 0: (x < 0)*k*x. A NaN operand of a comparison gives NaN.
 *
 * x^n is multiplications where n is an integer or half of one and |n| <= 16, rounded after each: the bits of |n| from
 * the highest down, r r for each and r x for a 1, for the half times sqrt(x), and 1/that for n < 0; else pow().
 */

struct expr_scope {
    const void *context;
    /* Slot of a name; false: unknown. */
    bool (*find)(const void *context, struct text name, int *slot);
    double (*load)(const void *context, int slot);
    /* Offers every known name for "did you mean"; may be NULL. */
    void (*offer)(const void *context, struct suggestion *suggestion);
    /* Where a run's names are wrapped: the slot in its own scope (run_scope), -1: of what does not move; NULL: as is. */
    int (*moving)(const void *context, int slot);
};

struct expr;

extern const struct catalog function_catalog; /* sin, cos, …: help and completion */

/*
 * Compiles the longest expression at the start of `text`; *used [byte] is where it stops (at a unit, a comma, a colon,
 * "+-", a comparison or the end). Memory from `arena`. scope may be NULL (constants only). Errors: unknown name with
 * suggestion, malformed number, missing operand or parenthesis, depth and size limits.
 */
const struct expr *expr_compile(struct text text, const struct expr_scope *scope, struct arena *arena, size_t *used,
                                struct error *error);
double expr_value(const struct expr *expr, const struct expr_scope *scope); /* NaN and infinities pass through */
bool expr_constant(const struct expr *expr, double *value);                 /* no names inside */
/* The value and its exact partial derivatives [count] with respect to the names in these slots: dual numbers, not
 * differences. A step (sign, floor …) has derivative 0, a corner (abs, min, if) that of the branch taken. */
double expr_gradient(const struct expr *expr, const struct expr_scope *scope, const int *slot, int count,
                     double *gradient);
/* Is it, as it is written, linear in these names together: a0 + a1 x1 + a2 x2 with other names only in the a? */
bool expr_linear(const struct expr *expr, const int *slot, int count);

/* ---- bounds ---- */

/* All numbers from lo to hi; both NAN: none, because the value is not a number. */
struct interval {
    double lo, hi;
};

/* Bounds of a function of one argument on a stretch of it, of its first and of its second derivative there. */
struct jet {
    struct interval value, slope, bend;
};

/*
 * The bounds that follow from those of the names, jet [slot]; rounding is inside. At a jump the slope is unbounded, at
 * a corner the second derivative (Moore 1966, Interval Analysis; natural extension, forward mode).
 */
struct jet expr_jet(const struct expr *expr, const struct jet *jet);
/*
 * Where a function of x passes through 0 on a stretch: every place, which its bounds prove, or it says from where on
 * they do not.
 */
struct root_search {
    void *context;
    double (*value)(void *context, double x);
    struct jet (*bounds)(void *context, double a, double b);
    /* In the order of x: the sign beyond, 0 where it only touches. False: no more are looked for. */
    bool (*found)(void *context, double x, int sign);
    bool (*touches)(void *context, double x); /* is the value 0 there, within errors? NULL: who touches is not asked */
    double least; /* stretches are not cut below this length */
    int budget;   /* bounds asked for, beside some for each root */

    int sign; /* in: of the value before, where it was last not 0; out: at the end */

    int used, count;
    bool unsure;        /* the bounds did not decide from here on */
    double unsure_from;
    bool nonzero;       /* some value inside was not 0; only ever set */
    bool stopped, touched;
    double last_touch;
};

/*
 * The root between a and b, where the values fa and fb have different signs: inverse quadratic interpolation where that
 * is safe, else bisection (Chandrupatla 1997, Adv. Eng. Software 28:145). It is known to `least`; where it returns, the
 * value is 0 or has the sign of fb.
 */
double root_between(double (*value)(void *context, double x), void *context, double a, double fa, double b, double fb,
                    double least);

/* From a, where the value is fa, to b. */
void roots_find(struct root_search *roots, double a, double fa, double b, double fb);

/*
 * The same expression where the names that move have the slots that `slot` says, and others, for which it is < 0, are
 * the numbers that they are now. NULL: no memory.
 */
const struct expr *expr_settle(const struct expr *expr, const struct expr_scope *scope,
                               int (*slot)(void *context, int slot), void *context, struct arena *arena);

/* ---- programs ----
 *
 * Expressions that are evaluated often. Equations hold several in the same names (0 … names - 1, the slots of their
 * scope) as a graph: what they share is computed once; derivatives are added to it. A program is some of them with some
 * names known and the rest as inputs; making it again for other values takes microseconds. It has three forms that give
 * the same bits: operations on the doubles of a frame, on lanes of doubles, and, where the machine can, machine code.
 *
 * The result is that of expr_value() bit for bit but for the rule of the scene that a term whose coefficient is 0 is
 * absent: where a factor or a numerator is the number 0 once the known names are in (not a variable that happens to be
 * 0), the product is the number 0 even for an infinite or NaN rest, and adding or subtracting it leaves no trace, not
 * even in the sign of a zero.
 */

#define PROGRAM_SIZE (1 << 17) /* operations of equations with their derivatives */
#define PROGRAM_LANES 64

struct equations;
struct program;

/* After a failure no more can be added; what there is stays good. NULL: no memory. */
struct equations *equations_create(int names, struct error *error);
void equations_destroy(struct equations *equations);
/* From here on the name means this expression of those before. */
bool equations_let(struct equations *equations, int name, const struct expr *expr, struct error *error);
/* One more output. */
bool equations_add(struct equations *equations, const struct expr *expr, struct error *error);
/* More outputs: for each of `count` outputs from `first` its partial derivatives by the names, [count][names]. Those of
 * abs, sign, min, max, step, if, comparisons and roundings are those of the branch taken; abs has 0 at 0. */
bool equations_derive(struct equations *equations, int first, int count, const int *name, int names,
                      struct error *error);
int equations_count(const struct equations *equations); /* outputs */

/*
 * `count` outputs from `first`, at least one. bound, value [names]: which names are known, and their values (NULL:
 * none). native: as machine code where possible. The equations may change or go away afterwards. NULL: no memory, or
 * too large.
 */
struct program *program_create(const struct equations *equations, int first, int count, const bool *bound,
                               const double *value, bool native, struct error *error);
void program_destroy(struct program *program);
bool program_native(const struct program *program);
int program_operations(const struct program *program); /* a product and the sum that it goes into count as one */
bool program_constant(const struct program *program, int output, double *value); /* depends on no input */
/* Does any of `count` outputs from `first` depend on the input, as it is written? */
bool program_depends(const struct program *program, int first, int count, int name);

/* Doubles of a frame. It serves one thread at a time. */
size_t program_frame(const struct program *program);
/* Once for each frame; costs nothing where the program is machine code. */
void program_prepare(const struct program *program, double *frame);
/* input [names], those of known names are not read; it may be the frame itself. output [count], apart from the input.
 * Returns the first output. Never allocates. */
double program_eval(const struct program *program, const double *input, double *output, double *frame);

/*
 * A program's own function, for kernels: names 0, 1, 2 as numbers, so that a state of two needs no memory; name i >= 3
 * is state[i - 1], those that are given (of a typed term: the values behind t and the state) follow in an array of
 * their own. Outputs 0 and 1 are returned, as calling conventions do it (of a single one the second is anything), the
 * others stored. What has no such names or outputs may be NULL.
 */
struct leading {
    double first, second;
};
typedef struct leading program_function(const struct program *program, double x0, double x1, double x2,
                                        const double *state, const double *given, double *output, double *frame);
program_function *program_code(const struct program *program);

/*
 * The same with PROGRAM_LANES doubles for each name and output. The frame is prepared for one place of input [names].
 * lanes [names]: what is known of the names; those that are fixed have their values already. NULL: nothing. Best
 * aligned to 64 bytes, all of them.
 */
enum program_lanes {
    LANES_ALIKE = 1, /* the same value in all lanes, whenever it is evaluated */
    LANES_FIXED = 2, /* the same values from here on */
};

size_t program_frame_lanes(const struct program *program);
void program_prepare_lanes(const struct program *program, const double *input, const unsigned char *lanes,
                           double *frame);
void program_eval_lanes(const struct program *program, double *output, double *frame);

/* A comparison `expr < expr` (also <= > >=), as in `run until y < 0`. The sides may carry units: y < 1 cm. */
struct condition {
    const struct expr *left, *right;
    double left_factor, right_factor; /* of the units */
    bool less, or_equal;
};

bool condition_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                       struct condition *condition, size_t *used, struct error *error);
/* left - right, with the sign such that the condition holds where the value is < 0 (or <= 0). */
double condition_value(const struct condition *condition, const struct expr_scope *scope);
bool condition_holds(const struct condition *condition, double value);

/* ---- parameters ----
 *
 * src/scene/terms.def lists each force term with its parameters; the table comes from there. A parameter is known by
 * its row; its place in the table indexes scene.value.
 */

#define PARAM_MAX 192 /* of a typed scene: an initial value for each variable, t0 and its own */

struct param_row {
    struct row row; /* name, SI unit, brief */
    enum quantity quantity;
    double initial;      /* default, SI */
    double least;        /* smallest value allowed, -HUGE_VAL: any */
    bool least_excluded; /* value > least */
};

extern const struct catalog param_catalog; /* those of the oscillator: struct param_row, at most PARAM_MAX */

int param_index(const char *name); /* of a name that exists in that table (asserted) */

struct model;

struct scene {
    const struct model *model;
    const struct preset *preset;
    double value[PARAM_MAX];       /* SI */
    double uncertainty[PARAM_MAX]; /* one standard uncertainty, 0: exact */
    bool given[PARAM_MAX];         /* set by the user since the preset */
    bool across;                   /* methods step across kinks at turning points, as they are printed */
    double atol[LIMIT_VARIABLES];  /* [n] errors of adaptive methods that do not matter, SI; 0: not given */
};

/* Settings of a model under a name. */
struct preset {
    struct row row;
    const struct model *model; /* NULL: the oscillator */
    struct {
        const char *param; /* NULL: end */
        double value;      /* SI */
    } value[16];           /* what differs from the parameters' defaults */
    /* How long what it shows takes [s], the tolerance it needs, and a first step [s] of methods that adapt. 0: the
     * lab's (preset_duration() and so on; 0 for the first step: the setting dt). */
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

/* The parameters and derived quantities of the scene's model; places in them index scene.value. */
const struct catalog *scene_params(const struct scene *scene);
const struct catalog *scene_derived(const struct scene *scene);
int scene_param(const struct scene *scene, const char *name); /* place, -1: this scene has no such parameter */

void scene_init(struct scene *scene, const struct preset *preset); /* NULL: "spring" with the lab's defaults */
/* Checks the range (m > 0, …, finite) and that k/m does not overflow; the scene is unchanged on error. */
bool scene_set(struct scene *scene, int param, struct measured value, struct error *error);
void scene_set_atol(struct scene *scene, int variable, double atol); /* 0: not given */
void scene_unset(struct scene *scene, int param); /* back to the preset's value */

/* Quantities that follow from the parameters: omega0, T0, f0, zeta, Q, omega_d, T_d, equilibrium … NaN where not
 * defined. */
struct derived_row {
    struct row row;
    enum quantity quantity;
    struct measured (*value)(const struct scene *scene); /* with the propagated uncertainty */
    /* Setting it sets this parameter (omega0, T0 and f0 set k); NULL: cannot be set. */
    double (*inverse)(const struct scene *scene, double value);
    const char *target;
};

extern const struct catalog derived_catalog; /* those of the oscillator */

/* Sets the row's target parameter so that the quantity takes this value; the uncertainty goes with it. */
bool scene_set_derived(struct scene *scene, const struct derived_row *row, struct measured value, struct error *error);

/* Re = rho v length / eta for a speed [m/s], NaN unless the scene is an oscillator; regime in words: "laminar",
 * "transitional", "turbulent". */
double scene_reynolds(const struct scene *scene, double speed);
const char *reynolds_regime(double reynolds);

/* ---- models: what moves, and by which laws ----
 *
 * A model is one file, src/scene/model_NAME.c, that ends in its struct model, and a line in models.c: its variables,
 * parameters and terms. The oscillator (the spring and all that can be hung on it) is terms.def.
 */

struct system;

#define LIMIT_SYMBOL 31 /* bytes in the name of a variable */

struct variable {
    char name[LIMIT_SYMBOL + 1];
    enum quantity quantity;
};

struct model {
    struct row row;
    int order; /* 2: positions, then velocities; 1 */
    int n;
    const struct variable *variable;                /* [n] */
    const struct catalog *params, *terms, *derived; /* struct param_row, struct term_row, struct derived_row */
    bool (*coherent)(const double *param, struct error *error); /* rules beyond each parameter's range; NULL: none */
    /* Fills t0, start, mass and scale (natural sizes, > 0) once the terms are bound. */
    void (*begin)(const double *param, struct system *system);
    /* As system_exact(); NULL: no closed form, or that of the linear oscillator. */
    void (*exact)(const struct system *system, double t0, const double *start, double t, double *y, double *floor);
    const struct typed *typed; /* what a user typed; NULL: one of scene_models */
};

extern const struct model oscillator_model;
extern const struct model *const scene_models[]; /* all of them, the oscillator first; NULL: end */

/* ---- terms and the bound system ---- */

#define TERM_COEFFICIENTS 6
#define TERM_VALUES 64 /* of a typed term: what it is, and up to 63 parameters that it reads */
#define TERM_MAX 16

enum term_flag {
    TERM_LINEAR = 1,       /* linear in the state, or independent of it */
    TERM_VELOCITY = 2,     /* depends on velocity */
    TERM_TIME = 4,         /* depends on time */
    TERM_CONSERVATIVE = 8, /* has a potential; otherwise it has a power */
    TERM_KINK = 16,        /* in a scene of one coordinate: not smooth where its velocity is 0 */
    TERM_DRY = 32,         /* dry friction: the last term, that of one coordinate, c[0] [m/s^2], c[1] [N] */
};

/*
 * The scene as one oscillator, where it is one:
 *   q'' = -stiffness q - damping q' - quadratic |q'| q' - friction sign(q') - gravity + drive cos(omega t + phase)
 * Closed-form steps and exact solutions use it where it is `whole`: nothing else acts. Exact drag flows need no more
 * than `drag_whole`; with several coordinates it is that of each: v_i' = -damping v_i.
 */
struct oscillator {
    double stiffness;    /* [1/s^2] k/m, any sign */
    double damping;      /* [1/s] gamma */
    double quadratic;    /* [1/m] C rho area / m */
    double friction;     /* [m/s^2] F/m, at rest what it takes; frozen on a branch it is part of gravity */
    double gravity;      /* [m/s^2] */
    double drive;        /* [m/s^2] F0/m */
    double omega, phase; /* [rad/s] [rad] */
    bool whole;
    bool drag_whole; /* no force depends on velocity but damping and quadratic (the latter with one coordinate only) */
};

struct term_row {
    struct row row; /* name, unit of what `add` adds, brief, citation */
    unsigned flags;
    /* Coefficients from the parameters, also added into `oscillator`; false: the term is absent (its coefficient is
     * zero). */
    bool (*bind)(const double *param, double *c, struct oscillator *oscillator);
    /* Adds to the accelerations [n/2] or, in a first-order scene, to the derivatives [n]. */
    void (*add)(const double *c, double t, const double *y, double *a);
    /* Adds d a / d y, a row of n for each a, row-major; NULL: the term does not depend on the state. */
    void (*jacobian)(const double *c, double t, const double *y, double *jac);
    double (*potential)(const double *c, const double *y);       /* [J], NULL unless TERM_CONSERVATIVE */
    double (*power)(const double *c, double t, const double *y); /* [W], NULL if TERM_CONSERVATIVE or first order */
};

extern const struct catalog term_catalog; /* those of the oscillator */

struct bound_term {
    const struct term_row *row;
    double c[TERM_VALUES]; /* set: TERM_COEFFICIENTS, all of a typed term */
};

bool bound_term_equal(const struct bound_term *a, const struct bound_term *b); /* the same row and coefficients */

struct system {
    const struct model *model;
    int n;     /* state variables, at most LIMIT_VARIABLES */
    int order; /* 2 or 1 */
    int terms;
    struct bound_term term[TERM_MAX];
    struct bound_term typed; /* of a typed scene: all that was typed at once; row NULL: not there */
    bool linear;       /* every term TERM_LINEAR: y' = A y + b(t) */
    bool autonomous;   /* no TERM_TIME */
    bool velocity;     /* some force depends on velocity, but for dry friction that is located */
    bool conservative; /* every term has a potential: energy is constant */
    bool energy;       /* kinetic and potential; false: kinetic is all there is, of typed forces without a potential */
    int switches;      /* of typed equations, then that of dry friction: with branches that can be frozen */
    bool dry;          /* the last of them is that of dry friction, at v = 0 */
    bool pieces;       /* steps of fixed size, too, end at switches: unless they go across, or it is frozen */
    const struct sliding *sliding; /* of a frozen system; NULL: along none of them */
    bool kinks;        /* n = 2, and some force is not smooth at v = 0, where it is not frozen */
    bool across;       /* methods step across such kinks, as they are printed */
    double mass;       /* [kg] or what takes its place: kinetic energy = mass v^2 / 2 */
    double ratio[LIMIT_VARIABLES / 2]; /* of the mass of each coordinate to it, where typed ones differ; 0: 1 */
    struct oscillator oscillator;
    double start[LIMIT_VARIABLES]; /* state at t0 */
    double t0;                     /* [s] */
    double scale[LIMIT_VARIABLES]; /* natural size of each variable (amplitude, amplitude * omega): error norms; > 0 */
    double atol[LIMIT_VARIABLES];  /* as the scene's */
};

bool scene_bind(const struct scene *scene, struct system *system, struct error *error);
/* Without looking for the potential of typed forces, which takes about a thousand evaluations: for those who bind many
 * and ask for no energy. */
bool scene_bind_motion(const struct scene *scene, struct system *system, struct error *error);

/* As if methods did not step across kinks. */
void system_turn_at_kinks(struct system *system);

void system_acceleration(const struct system *system, double t, const double *y, double *a);  /* [n/2], order 2 only */
void system_derivative(const struct system *system, double t, const double *y, double *dydt); /* [n] */
/* Only the terms that do not depend on velocity. */
void system_force(const struct system *system, double t, const double *y, double *a);
/* Only the terms that do depend on velocity. */
void system_drag(const struct system *system, double t, const double *y, double *a);
/*
 * Exact flow of v' = -gamma v - c |v| v over h (Hairer, Lubich, Wanner 2006, II.5), prepared once for many v:
 * v keep/(least + pull |v|). Sign-preserving, exact at v = 0. Backwards in time quadratic drag has a pole: infinite
 * beyond it.
 */
struct drag_flow {
    double keep, least, pull;
};

struct drag_flow oscillator_drag_flow(const struct oscillator *oscillator, double h);

static inline double drag_flow_apply(const struct drag_flow *flow, double v)
{
    double below = flow->pull == 0 ? flow->least : flow->least + flow->pull * fabs(v);
    if (!(below > 0))
        return copysign(HUGE_VAL, v);
    return flow->least == 1 && flow->pull == 0 ? v * flow->keep : v * flow->keep / below;
}
void system_jacobian(const struct system *system, double t, const double *y,
                     double *jac); /* d y'/d y, [n][n] row-major */

/*
 * Short times at which a typed equation does something that samples would miss, as bounds of it prove, along the
 * smooth way from one state to another: between t[0] and t[1] [s], shorter than 1/32 of it each. Appended to those
 * there are, and those that meet become one; the new count, at most `most`. sure: of smooth forces none, as a warning
 * has to be true; else some where a force has no bend, which costs steps and no more.
 */
struct burst {
    double from, to; /* [s] */
};

int system_bursts(const struct system *system, const double t[2], const double *from, const double *to,
                  bool sure, struct burst *burst, int count, int most);

double system_kinetic(const struct system *system, const double *y);         /* [J] */
double system_potential(const struct system *system, const double *y);       /* [J] */
bool system_has_potential(const struct system *system);                      /* all forces but drag have one */
double system_power(const struct system *system, double t, const double *y); /* [W] of the non-conservative terms */
double system_dissipation(const struct system *system, double t,
                          const double *y); /* [W] of the drag terms alone, <= 0 */

struct variable system_variable(const struct system *system, int i); /* of state variable i */
/* Place in the state of a variable's name; y' is the velocity of y. -1: there is none. */
int model_state(const struct model *model, struct text name);

/* ---- exact solutions ----
 *
 * For linear oscillators in every regime (under-, critically and overdamped, k = 0, k < 0, gamma < 0, constant force,
 * driven, resonance, with formulas that do not cancel), typed or not; for models that bring their own; by the matrix
 * exponential for other linear systems with constant coefficients and up to 16 variables; for linear oscillators with dry
 * friction, without a drive. From `start` at t0 to t
 * (before or after t0); growth beyond double ends as infinity. floor [n], or NULL: what one ulp in the coefficients (of
 * other models: in the start) does to the answer, about eps * omega * |t - t0| times the amplitude: no error below it
 * means anything.
 */
bool system_has_exact(const struct system *system);
void system_exact(const struct system *system, double t0, const double *start, double t, double *y, double *floor);
/*
 * The same for many times that are h apart but for rounding, [s] in the direction of h, at a fraction of the cost: found
 * anew from time to time, and from there on by what each step does, in long double. Good to an ulp of system_exact();
 * times elsewhere are right too. NULL: not of use for this system or step, or no memory. The system has to stay.
 */
struct exact_table;
struct exact_table *exact_table_create(const struct system *system, double t0, const double *start, double h);
void exact_table_at(struct exact_table *table, double t, double *y);
void exact_table_free(struct exact_table *table);

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
 * A potential that was typed for the forces before goes when a force is added; on a built-in scene it is that of the
 * typed forces.
 *
 * Names in expressions: t, variables, velocities, parameters, observed quantities. They have to be there when a line
 * uses them.
 *
 * Initial values are parameters: x0 of x and vy0 of vy, x1_0 of x1. So is t0. The mass is the parameter m where there
 * is one, else 1. If every variable has an equation of second order the scene is of second order: positions, then
 * velocities; else of first order: variables as they were declared, then velocities.
 *
 * Summands of a second derivative are sorted into forces that depend on positions (and time) and drag, which depends on
 * velocities, so that splittings apply with drag=explicit. A summand whose factor is a parameter that is 0 is absent.
 * Jacobians are derivatives of the expressions. Without a typed
 * potential the summands that depend on positions only get one where there is one; what depends on time alone is a
 * drive, whose work counts, like that of drag. All other forces have no energy: the kinetic one is all that is known.
 *
 * A model is immutable: a line makes a new one. All of them live until typed_destroy(). An incomplete one (a variable
 * without an equation) can be looked at and set; scene_bind() says what is missing. Natural sizes: the largest |initial
 * value| and |value| on a short trial run of about one time constant (of linear systems: many); where all are 0, 1.
 *
 * What is a second-order equation in y with a0 + a1 y + a2 y' + a3 |y'| y' + a4 cos(a5 t + a6) on its right, as it is
 * written (or with sin), with the present parameters and a3 <= 0, is the oscillator with these coefficients: natural
 * sizes, exact solution, exact drag and derived quantities are those of the built-in one. So are forces on top of it.
 */

enum typed_kind { TYPED_VAR, TYPED_PARAM, TYPED_EQUATION, TYPED_FORCE, TYPED_POTENTIAL, TYPED_OBSERVE };

struct typed_line {
    enum typed_kind kind;
    struct text name;       /* of a velocity's initial value: y' (TYPED_VAR); force: "" is the first coordinate */
    int order;              /* TYPED_EQUATION: 1 or 2 */
    struct text expr;       /* all but TYPED_VAR and TYPED_PARAM; a whole expression, nothing behind it */
    double value;           /* TYPED_VAR, TYPED_PARAM: SI */
    enum quantity quantity; /* the same; QUANTITY_NUMBER: no unit */
};

struct typed_models; /* all of a session */

struct typed_models *typed_create(struct error *error); /* NULL: no memory */
void typed_destroy(struct typed_models *models);        /* with every model: nothing may use them any more */
/* A scene without a line under this name ("": typed); lines that are added to it keep the name. NULL: error. */
const struct model *typed_new(struct typed_models *models, struct text name, struct error *error);
/*
 * `from` with one more line; a line of the same kind and name is replaced. On a built-in model var and equations begin
 * an empty scene, the others add to it. Texts are copied. NULL: error, whose `where` lies in line->expr or line->name.
 */
const struct model *typed_add(struct typed_models *models, const struct model *from, const struct typed_line *line,
                              struct error *error);
/* Without that line; a variable takes its equation and its initial velocity along. What is left may be the built-in
 * model itself. NULL: it is not there, or others use it. */
const struct model *typed_remove(struct typed_models *models, const struct model *from, enum typed_kind kind,
                                 struct text name, struct error *error);
/* The lines as they were typed, in the order in which they can be typed again. 0 of a built-in model. */
int typed_lines(const struct model *model);
const struct typed_line *typed_line(const struct model *model, int i);
void typed_describe(const struct typed_line *line, struct buffer *text); /* "y'' = -k*y", as one types it */
const struct model *typed_base(const struct model *model); /* the built-in model below; NULL: none, all is typed */

/* Settings under the name of a scene that is all typed; NULL: it is not. */
const struct preset *typed_preset(const struct model *model);

/* The scene with another model: values stay with the names of their parameters, unless the line gave a new one. */
void scene_remodel(struct scene *scene, const struct model *model);

/* The term that is the whole right-hand side of a scene that is all typed. NULL: there are several. */
const struct bound_term *system_whole(const struct system *system);

/*
 * What a typed term adds, as a program of t, y and the values behind them [*values], which are term->c from 1 on. NULL:
 * a built-in term.
 */
const struct program *term_program(const struct bound_term *term, int *values);

/*
 * Switches of typed equations: where abs(), sign(), if(), <, min(), max(), step(), floor(), mod() go from one branch to
 * another; and of dry friction, where the velocity is 0. A frozen system stays on its branches and is smooth; its guards are above 0 as long as they are the right
 * ones. branch, guard: [system->switches].
 */
#define LIMIT_TYPED_SWITCHES 12
#define LIMIT_SWITCHES (LIMIT_TYPED_SWITCHES + 1)
void system_branches(const struct system *system, double t, const double *y, double *branch);
void system_freeze(const struct system *system, const double *branch, struct system *frozen);
void system_guards(const struct system *frozen, double t, const double *y, double *guard);
/*
 * Sliding along `count` switches at once: the field that keeps all their arguments where they are, between those on the
 * two sides of each (Filippov 1988; with more than one switch the equivalent control of Utkin 1992, to which each adds
 * its own part). The guard of such a switch is above 0 as long as the share of either side is.
 */
#define LIMIT_SLIDING 4
struct sliding {
    int count;
    int at[LIMIT_SLIDING];
    double level[LIMIT_SLIDING];           /* of the argument, at the switch */
    double near;                           /* [s] over which arguments are differentiated */
    struct system side[LIMIT_SLIDING + 1]; /* below all of them, then above each alone */
};

/* `slides` [system->switches]: along which; false: too many. *frozen refers to *sliding. */
bool system_slide(const struct system *system, const double *branch, const bool *slides, double near,
                  struct sliding *sliding, struct system *frozen);
/* Puts the state back on the switches from which it is off by what steps leave; false: it is there. */
bool sliding_return(const struct sliding *sliding, double t, double *y);

/* A state that is on switch i but for rounding is put there, where it is known how: where dry friction turns. */
void system_end_at_switch(const struct system *frozen, int i, double *y);

/* Of switch i, beyond the guard that is 0 at (t, y). */
double system_next_branch(const struct system *frozen, int i, double t, const double *y);

/* The branch below switch i, where the motion slides along it. */
double system_lower_branch(const struct system *frozen, int i, double t, const double *y);
/* Does the argument of switch i change with this variable? */
bool system_switch_sees(const struct system *system, int i, double t, const double *y, int variable);

#define LIMIT_OBSERVED 64 /* quantities that a typed scene observes */

/* These are 0 … count - 1. */
int model_observed(const struct model *model);
struct variable model_observed_variable(const struct model *model, int i);
double system_observe(const struct system *system, int i, double t, const double *y);

#endif
