/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * method: integrators as rows, one step of each, step-size control, linear stability.
 *
 * This is level 0, the specification: tables and step bodies that call the terms through pointers.
 * A faster kernel may replace a step only if it gives the same bits.
 */
#pragma once

#include <hooke/method/drag.h>
#include <hooke/scene/model.h>

struct catalog;
struct controller;
struct method;
struct step;

enum step_status {
    STEP_OK,
    STEP_NONFINITE,   /* the new state is not finite; y is unchanged */
    STEP_NO_SOLUTION, /* the implicit equation was not solved; y is unchanged */
    /* the tolerance asks for a step below the rounding of t; y is unchanged (method_adapt only) */
    STEP_STALLED,
};

typedef enum step_status step_function(const struct method *method, struct step *step);
/* Accepted steps, as method_adapt_many(). */
typedef int64_t controlled_function(struct step *step, struct controller *controller, double t_end,
                                    int64_t count, double *row, enum step_status *status);

/* The force at a displacement: towards rest, none, away from it. */
enum stiffness_sign { STIFFNESS_POSITIVE, STIFFNESS_ZERO, STIFFNESS_NEGATIVE };

double stiffness_sign_value(enum stiffness_sign sign); /* 1, 0, -1 */

/* struct row: "exact", "implicit", "explicit" at their enum's place - 1 */
extern const struct catalog drag_catalog;

struct cost {
    int64_t evals;     /* force evaluations (right-hand sides) */
    int64_t jacobians; /* Jacobians */
    int64_t solves;    /* linear solves or closed-form solves */
    int64_t rejected;  /* rejected steps, their evaluations counted above */
    int64_t turns;     /* steps that were ended at a turning point, see method_turns() */
    int64_t poles;     /* fixed steps across a time at which a slope is infinite */
};

/*
 * Input and output of one step.
 *
 *     y     [n]  on entry the state at t, on return that at t + h; bit for bit unchanged
 *                unless STEP_OK is returned.
 *     h     [s]  any sign, not 0.
 *     error [n]  local error estimate in units of y; NULL if it is not wanted or not available.
 *     work       method_work_size() doubles, owned by the caller.
 *
 * `warm` is true if work holds the values that the previous step of the same method left (first
 * same as last, history). method_step() sets it; code that changes y, the system or t (by more than
 * rounding) between steps clears it.
 */
struct switches_state;

struct step {
    const struct system *system;
    /* resolved by method_applies(): DRAG_DEFAULT only where the method has no variants */
    enum drag drag;
    double t, h;
    double *y, *error, *work;
    /* [n] optional: rounding errors lost from y (compensated sums, Kahan 1965), or NULL for
     * plain sums */
    double *low;
    bool warm;
    void *library; /* state of an external solver, created by method_begin() */
    /* Step of the method compiled for this system, from method_step_kernel(), or NULL for the
     * general one. */
    step_function *kernel;
    controlled_function
        *controlled; /* and accepted ones, by method_controlled_kernel(); NULL if there is none */
    /* Set by method_adapt(): */
    /* the last step was taken back: what was evaluated at t and y before it still holds */
    bool again;
    /* An error with an RMS of tol max(scale_i, |y_i|) is acceptable, which bounds iterations. 0
     * marks a fixed step. */
    double tol;
    /* [n] sizes along the run, see struct controller, or NULL for those of the system */
    const double *scale;
    /* sum of (error_i / max(scale_i, |y_i|))^2, where the step has it; else as it was */
    double square;
    struct cost cost; /* accumulates */
    /* Counts sliding and accumulating switches of fixed steps, or NULL if they are not
     * counted. */
    struct switches_state *switches;
};

enum method_flag {
    METHOD_IMPLICIT = 1,
    METHOD_SYMPLECTIC = 2, /* symplectic for separable conservative scenes */
    METHOD_SYMMETRIC = 4,  /* a step of h, then one of -h, restores the state */
    METHOD_ENERGY = 8,     /* keeps the energy of an undamped linear oscillator exactly */
    METHOD_A_STABLE = 16,
    METHOD_L_STABLE = 32,
    METHOD_ADAPTIVE = 64,      /* has an error estimate */
    METHOD_SECOND_ORDER = 128, /* only for q'' = a(t, q, q') */
    METHOD_EXACT = 256,        /* propagates the exact solution: needs system_has_exact() */
    METHOD_NO_VELOCITY = 512,  /* only for q'' = a(t, q): no force may depend on velocity */
    METHOD_POTENTIAL = 1024,   /* every force but drag needs a potential */
    METHOD_MULTISTEP =
        2048, /* uses previous steps: starts with a one-step method, needs a constant step */
    METHOD_EXTERNAL =
        4096, /* external library, for comparison: adaptive only, last in the catalogue */
    METHOD_UNROLLED = 8192,    /* has its own kernels, since it is common or a yardstick */
    METHOD_CONTROLLED = 16384, /* has its own kernels for accepted steps, since it is common */
};

/* Coefficients, private to the layer: each family of methods has one kind. */
struct tableau;          /* explicit Runge-Kutta */
struct splitting;        /* drifts and kicks */
struct nystrom;          /* Runge-Kutta-Nystrom */
struct implicit_tableau; /* implicit Runge-Kutta */
struct rosenbrock;       /* linearly implicit Runge-Kutta */
struct multistep;        /* Adams, backward differentiation */
struct controller;
struct switches_state;

struct method {
    struct row row;      /* name, "", brief, citation, aliases */
    const char *formula; /* one step, as text with textbook letters, for help */
    int order;           /* order of convergence, or 0 if exact */
    int embedded;        /* order of the embedded method, 0 if there is none */
    /* Fraction of the tolerance that a step's error estimate may reach (see method_adapt); 0
     * stands for 1/3. */
    double fraction;
    int evals; /* force evaluations per step (once warm) */
    unsigned flags;
    /* Index in the file of its family, by which kernels, which compile rows again, find their
     * row. */
    int index;
    /* Default variant. With DRAG_DEFAULT drag is part of the right-hand side and has no
     * variants. */
    enum drag drag;
    unsigned drags; /* bit 1 << enum drag for each variant offered */
    enum step_status (*step)(const struct method *method, struct step *step);
    size_t (*work)(const struct method *method, int n); /* doubles */
    /* Computes the state at t + theta h (0 <= theta <= 1) after a successful step. If NULL, a
     * cubic Hermite polynomial through both ends is used. */
    void (*dense)(const struct method *method, const struct step *step, double theta, double *y);
    /* Computes the growth per step (spectral radius) on q'' + 2 zeta q' + q = 0 at x = dt. If
     * NULL, that of the one-step matrix is used. */
    double (*growth)(const struct method *method, double x, double zeta, enum stiffness_sign sign);
    /* Only for yardsticks: create and free the memory that their library owns (begin returns
     * NULL if out of memory), and take a step under the library's own control. */
    void *(*begin)(const struct method *method, const struct step *step);
    void (*end)(void *library);
    enum step_status (*adapt)(const struct method *method, struct step *step,
                              struct controller *controller, double t_end);
    /* Coefficients of the method's family; the others are NULL. */
    const struct tableau *tableau;
    const struct splitting *splitting;
    const struct nystrom *nystrom;
    const struct implicit_tableau *implicit;
    const struct rosenbrock *rosenbrock;
    const struct multistep *multistep;
};

extern const struct catalog method_catalog;
/* Finds a method by its exact name or alias; returns NULL if there is none. */
const struct method *method_by_name(struct text name);
const struct method *method_at(size_t i);
/* Returns the method of a row of the catalog. */
const struct method *method_from(const struct row *row);
const struct method *method_find(const char *name); /* NULL if not in this build */

/* Returns true if this method can step this system with this drag variant, else false with the
 * reason in error. Resolves DRAG_DEFAULT. */
bool method_applies(const struct method *method, const struct system *system, enum drag *drag,
                    struct error *error);
/* Returns true if the method can take steps of h [s] on this system, else false with the reason
 * in error. Splittings of higher order step backwards, which strong drag makes unstable. */
bool method_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                 struct error *error);
size_t method_work_size(const struct method *method, int n);
/*
 * Whoever owns the work memory calls these, too, with the system known to the step. Our own methods
 * need nothing more; an external library allocates here, for this system's n, and may again in its
 * first step. Returns false if out of memory.
 */
bool method_begin(const struct method *method, struct step *step);
void method_end(const struct method *method, struct step *step);
/* Steps of fixed size end at switches, in pieces by method_turning_step(). */
bool method_meets_switches(const struct method *method, const struct system *system);
/*
 * A step across a kink of a force at v = 0 loses its order (unless the system asks to step across).
 * Methods above order 2 that may change their step therefore end a step at each turning point:
 * method_adapt() does so by itself, and method_turning_step() splits steps of fixed size.
 */
bool method_turns(const struct method *method, const struct system *system);
/* One step: STEP_OK, and t has advanced by h; else y and t are as they were, bit for bit. Never
 * allocates. */
enum step_status method_step(const struct method *method, struct step *step);
/* The same, where method_turns() in pieces that meet at the turning points; a dense output is that
 * of the last one. */
enum step_status method_turning_step(const struct method *method, struct step *step);
/* The degree in theta of the dense output, 0 if it is no polynomial; most: DENSE_DEGREE. */
#define DENSE_DEGREE 12
int method_dense_degree(const struct method *method);
/* Computes the state inside the last step, [t - h, t]; y_begin [n] is the state at its start. */
void method_dense(const struct method *method, const struct step *step, const double *y_begin,
                  double theta, double *y);

/*
 * One variable of the dense output of the last step, prepared once for many theta (0 at its start,
 * 1 at its end): end - h (1 - theta) (rise - theta (first + theta (twist + (1 - theta) (bend_0 +
 * theta (bend_1 + …))))).
 */
enum { DENSE_BENDS = 4 };

struct dense_polynomial {
    double end, h, rise, first, twist, bend[DENSE_BENDS];
    int bends;
};

static inline double dense_polynomial_at(const struct dense_polynomial *p, double theta)
{
    const double rest = 1 - theta;
    double bend = 0;
    for (int m = p->bends; m-- > 0;)
        bend = (m % 2 == 0 ? rest : theta) * (p->bend[m] + bend);
    return p->end - p->h * (rest * (p->rise - theta * (p->first + theta * (p->twist + bend))));
}

/* Computes the polynomial of variable i over the last step. Only for explicit Runge-Kutta and
 * Rosenbrock methods with their own dense output. */
void method_polynomial(const struct method *method, const struct step *step, int i,
                       struct dense_polynomial *polynomial);

/* ---- many steps of one size ----
 *
 * A march takes `count` steps of step->h; step i = first, first + 1, … begins at origin + i h. The
 * states after them go to row [count][n], the last one also to step->y. Without compensated sums
 * and error estimates.
 */
struct march {
    struct step *step;
    double origin; /* [s] */
    int64_t first, count;
    double *row;
};

/*
 * Kernels take the same steps, to the bit, in code made for one method and one kind of scene. They
 * return the number of steps taken, which is less than `count` if the next one has no solution.
 * They check nothing else, so states may become infinite or NaN. A kernel is kept only while `make
 * bench` shows its gain.
 */
typedef int64_t march_function(const struct method *method, const struct march *march);

march_function *method_kernel(const struct method *method, const struct system *system,
                              enum drag drag); /* or NULL */
/* The same for single steps with an error estimate, whatever the drag variant. */
/* or NULL */
step_function *method_step_kernel(const struct method *method, const struct system *system);
/* And for accepted steps of rows that are METHOD_CONTROLLED. */
controlled_function *method_controlled_kernel(const struct method *method,
                                              const struct system *system); /* or NULL */
/* Both for step->system, where `special`. */
void method_choose_kernels(const struct method *method, struct step *step, bool special);
/* As method_march(), by method_turning_step() where the method turns; a kernel takes the steps
 * between. */
int64_t method_turning_march(const struct method *method, march_function *kernel,
                             const struct march *march, enum step_status *status);
/* Steps taken; fewer than count: *status says why, and the step is where it was before the one that
 * failed. */
int64_t method_march(const struct method *method, march_function *kernel, const struct march *march,
                     enum step_status *status);

/* ---- step-size control ----
 *
 * One accepted step of an adaptive method with |error_i| <= share tol max(scale_i, |y_i|) in the
 * RMS sense (tol^(k/p) where the estimate goes with h^k and the method is of another order p), by
 * digital filters (Soderlind 2003). tol is relative to the scene's own sizes, never to raw SI
 * numbers: scale_i = (mean of max(|y_i|, s_i)^(1/4))^4 over the time of the run so far, where s_i
 * is the system's. So a size that was guessed too small does no harm, and none is 0 or infinite;
 * and a short peak, of which a relaxation oscillation is full, does not make what is between peaks
 * inaccurate, as the largest |y_i| seen would (the phase of the Oregonator was off by 3e-7 at tol
 * 1e-13). Where the scene gives an atol_i it takes the place of that: tol scale_i = atol_i. The
 * row's share makes all methods alike: after some ten periods of an oscillation the error that has
 * added up is at most ten times tol.
 *
 * Steps towards t_end (either side of t), never past it; a step that reaches it sets t = t_end
 * exactly and leaves the proposal as it was, and so does one to a turning point. step->h is then
 * the step taken. A state that is not finite is retried with h/4, up to 20 times. Anything but
 * STEP_OK leaves y, t and the controller as they were.
 */
/* The branches of a system's switches at t, where the next step begins. */
struct switches_state {
    /* begins is true if switches have changed at t; piled is true if too many have changed in
     * too short a time */
    bool known, begins, piled;
    int fresh;             /* the one at which the last step ended, -1 if there is none */
    double t;              /* [s] */
    unsigned count;        /* number of switches */
    int shorter;           /* number of successive blocks, each much shorter than the one before */
    double t_block, block; /* [s] where this block began, and how long the last one took */
    bool recent[LIMIT_SWITCHES]; /* changed in this block */
    double branch[LIMIT_SWITCHES];
    /* The motion slides along these switches in steps of about `slide_step`; see branch below. */
    bool slides_along[LIMIT_SWITCHES];
    int released; /* the one along which it slid until the last step, -1 if there is none */
    double slide_step;
    double taken[LIMIT_SWITCHES]; /* branch and along of the last step */
    bool slid_along[LIMIT_SWITCHES];
    int64_t slides, piles; /* number of times that sliding and piling up have begun */
    int64_t crossings;     /* steps taken across, because no branch leads on and no sliding does */
    double slid;           /* [s] where the first of all these began, */
    int first;             /* and the switch */
};

struct controller {
    double tol;                    /* relative tolerance, at least 10 eps */
    double scale[LIMIT_VARIABLES]; /* [n] size of each variable along the run, see below */
    /* [n] [s] by how much it was larger than the system's, integrated */
    double excess[LIMIT_VARIABLES];
    double elapsed, sampled; /* [s] since the first step; t of the last sample */
    bool sampling;
    double h; /* [s] proposal for the next step, or 0 to choose a first one */
    /* [s] what rounding has taken from t so far (Neumaier 1974): equal steps are rounded alike */
    double t_low;
    double last; /* [s] the last accepted step */
    /* the square of its error, in units of what is aimed at; 0 if there is no history */
    double previous;
    bool rejected;
    struct switches_state switches;
};

enum step_status method_adapt(const struct method *method, struct step *step,
                              struct controller *controller, double t_end);
/* Returns true if the next steps can be taken by method_adapt_many(). */
bool method_adapts_many(const struct step *step, const struct controller *controller);
/* Takes up to `count` > 0 steps, the same ones as method_adapt(), and writes the state and the time
 * after each to row [count][n + 1], unless that is NULL. Ends early within rounding of t_end.
 * Returns how many were taken; *status says what became of the next one, if it was tried. */
int64_t method_adapt_many(struct step *step, struct controller *controller, double t_end,
                          int64_t count, double *row, enum step_status *status);
/* The system that the last adaptive step was taken of: frozen, if it has switches. */
const struct system *method_adapted(const struct system *system,
                                    const struct controller *controller, struct sliding *sliding,
                                    struct system *frozen);

/* ---- linear stability ----
 *
 * q'' + gamma q' + omega^2 q = 0 in the scaled state (q, v/omega), with x = omega dt, zeta = gamma
 * / (2 omega). Where nothing pulls back the last term is 0 or - omega^2 q, and omega is no more
 * than a unit of frequency.
 */

/* Computes the one-step matrix, row-major, by stepping the two unit vectors. Returns false if
 * the method does not apply. */
bool method_amplification(const struct method *method, enum drag drag, double x, double zeta,
                          double matrix[4]);
double matrix_spectral_radius(const double matrix[4]);
/* Amplitude factor a step, the spectral radius: also for methods that have no one-step matrix.
 * Returns NAN if it does not apply. */
double method_growth(const struct method *method, enum drag drag, double x, double zeta);
/* The same where the stiffness has that sign. */
double method_growth_signed(const struct method *method, enum drag drag, double x, double zeta,
                            enum stiffness_sign sign);
/*
 * Supremum of the x with growth <= 1 counted from 0: HUGE_VAL where every step is stable, 0 where
 * none is, NAN where the method or variant does not apply. Growth of up to 1e-12 is taken for
 * rounding, unless it rises as a power of x.
 */
double method_stable_limit(const struct method *method, enum drag drag, double zeta);
double method_stable_limit_signed(const struct method *method, enum drag drag, double zeta,
                                  enum stiffness_sign sign);
