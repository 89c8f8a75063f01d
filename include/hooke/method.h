/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * method: the integrators as rows of a catalog, one step of each, many steps, step-size control and
 * linear stability.
 *
 * To integrate by hand: method_applies(), fill a struct step whose work memory has
 * method_work_size() doubles, method_begin(); then method_step() for fixed steps, or method_adapt()
 * with a struct controller for adaptive ones; method_dense() inside the last step; method_end(). A
 * run (<hooke/run.h>) does all of this. The steps here call force terms through pointers and define
 * the result; a kernel, a faster form of a step for one kind of scene, must give the same bits.
 */
#pragma once

#include <hooke/method/drag.h>
#include <hooke/scene/model.h>

struct catalog;
struct controller;
struct method;
struct step;
struct switches_state;

/* Result of a step. Unless it is STEP_OK, the state y is unchanged, bit for bit. */
enum step_status {
    /* The step was taken. */
    STEP_OK,
    STEP_NONFINITE,   /* The new state is not finite. */
    STEP_NO_SOLUTION, /* The implicit equation was not solved. */
    /* The tolerance requires a step below the rounding of t (method_adapt() only). */
    STEP_STALLED,
};

/* One step of a method, as method_step(). */
typedef enum step_status step_function(const struct method *method, struct step *step);
/* Several accepted adaptive steps, as method_adapt_many(). */
typedef int64_t controlled_function(struct step *step, struct controller *controller, double t_end,
                                    int64_t count, double *row, enum step_status *status);

/* Sign of the stiffness of a linear oscillator: the force at a displacement points towards
 * equilibrium, is 0, or points away from it. */
enum stiffness_sign { STIFFNESS_POSITIVE, STIFFNESS_ZERO, STIFFNESS_NEGATIVE };

double stiffness_sign_value(enum stiffness_sign sign); /* Returns 1, 0 or -1. */

/* Variants of drag: "exact", "implicit" and "explicit", struct row at index (enum drag) - 1. */
extern const struct catalog drag_catalog;

/* Counts of the work of steps, which accumulate. */
struct cost {
    int64_t evals;     /* evaluations of the right-hand side */
    int64_t jacobians; /* evaluations of the Jacobian */
    int64_t solves;    /* solutions of linear or closed-form equations */
    int64_t rejected;  /* rejected steps; their evaluations are counted above */
    int64_t turns;     /* steps that ended at a turning point, see method_turns() */
    int64_t poles;     /* fixed steps across a time at which a derivative is infinite */
};

/* Input and output of one step of a method, owned by the caller with all that it points to but
 * `library`. Set system, drag, h, y and work; zero the rest. */
struct step {
    /* The differential equation. */
    const struct system *system;
    /* Variant of drag, as resolved by method_applies(): DRAG_DEFAULT only if the method has no
     * variants. */
    enum drag drag;
    /* [s] time at which the step begins, and its length: of any sign, not 0. */
    double t, h;
    /* [n] state: at t on entry, at t + h on return. [n] estimate of the local error in units of y,
     * or NULL if not wanted. Work memory of method_work_size() doubles. */
    double *y, *error, *work;
    /* [n] rounding errors lost from y (compensated sums, Kahan 1965), or NULL for plain sums. */
    double *low;
    /* `work` holds the values that the previous step of the same method left there (first same as
     * last, history). method_step() sets it; code that changes y, the system or t (by more than
     * rounding) between steps must clear it. */
    bool warm;
    /* State of an external solver, created by method_begin() and freed by method_end(). */
    void *library;
    /* The kernel, which is the method's step compiled for this kind of system, from
     * method_step_kernel(), or NULL for the general step. */
    step_function *kernel;
    /* Kernel for accepted adaptive steps, from method_controlled_kernel(), or NULL. */
    controlled_function *controlled;
    /* The previous try of this step was rejected: what was evaluated at t and y is still valid. Set
     * by method_adapt(), as are tol, scale and square. */
    bool again;
    /* Tolerance, such that an error with an RMS of tol max(scale_i, |y_i|) is acceptable, which
     * bounds the iterations of implicit methods. 0 marks a fixed step. */
    double tol;
    /* [n] sizes of the variables along the run (see struct controller), or NULL for those of the
     * system. */
    const double *scale;
    /* Sum of (error_i / max(scale_i, |y_i|))^2 if the method's step computes it; otherwise
     * unchanged. */
    double square;
    struct cost cost; /* Work of this step and all before. */
    /* Receives the counts of sliding and piled-up switches of fixed steps, or NULL. */
    struct switches_state *switches;
};

/* Properties of methods. */
enum method_flag {
    /* Solves equations in each step. */
    METHOD_IMPLICIT = 1,
    METHOD_SYMPLECTIC = 2, /* Symplectic for separable conservative scenes. */
    METHOD_SYMMETRIC = 4,  /* Time-symmetric: a step of h, then one of -h, restores the state. */
    METHOD_ENERGY = 8,     /* Conserves the energy of an undamped linear oscillator exactly. */
    /* A-stable: stable for every step if all eigenvalues have real parts <= 0. */
    METHOD_A_STABLE = 16,
    /* L-stable: also damps infinitely fast modes within one step. */
    METHOD_L_STABLE = 32,
    METHOD_ADAPTIVE = 64,      /* Has an error estimate, so that steps can be adaptive. */
    METHOD_SECOND_ORDER = 128, /* Only for second-order scenes, q'' = a(t, q, q'). */
    METHOD_EXACT = 256,        /* Follows the exact solution; needs system_has_exact(). */
    METHOD_NO_VELOCITY = 512,  /* Only for q'' = a(t, q): no force may depend on velocity. */
    METHOD_POTENTIAL = 1024,   /* Every force but drag must have a potential. */
    /* Uses previous steps: starts with a one-step method and needs a constant step. */
    METHOD_MULTISTEP = 2048,
    /* Method of an external library, for comparison: adaptive only, last in the catalog. */
    METHOD_EXTERNAL = 4096,
    /* Has kernels of its own, because it is common or a reference for speed. */
    METHOD_UNROLLED = 8192,
    METHOD_CONTROLLED = 16384, /* Has kernels for accepted adaptive steps, because it is common. */
};

/* Coefficients of methods, private to this layer: a struct for each family. */
struct tableau;          /* explicit Runge-Kutta */
struct splitting;        /* drifts and kicks */
struct nystrom;          /* Runge-Kutta-Nystrom */
struct implicit_tableau; /* implicit Runge-Kutta */
struct rosenbrock;       /* linearly implicit Runge-Kutta */
struct multistep;        /* Adams, backward differentiation */
struct controller;
struct switches_state;

/* An integrator: a row of method_catalog. */
struct method {
    struct row row;      /* Name, "", description, source, aliases. */
    const char *formula; /* Formula of one step in textbook notation, for help. */
    int order;           /* Order of convergence, or 0 if exact. */
    int embedded;        /* Order of the embedded method of the error estimate, or 0. */
    /* Fraction of the tolerance that the error estimate of a step may reach (see method_adapt()); 0
     * stands for 1/3. */
    double fraction;
    int evals; /* Evaluations per step after the first. */
    /* Flags of enum method_flag. */
    unsigned flags;
    /* Index in the .def file of its family, by which kernels, which compile the rows again, find
     * their row. */
    int index;
    /* Default variant of drag. DRAG_DEFAULT means that drag is part of the right-hand side, without
     * variants. */
    enum drag drag;
    unsigned drags; /* Bit 1 << enum drag for each variant that it supports. */
    /* Takes one step in general form. */
    enum step_status (*step)(const struct method *method, struct step *step);
    /* Returns the number of doubles of work memory for n variables. */
    size_t (*work)(const struct method *method, int n);
    /* Computes the state y [n] at the fraction theta (0 to 1) of the last step. NULL stands for the
     * cubic Hermite polynomial through both ends. */
    void (*dense)(const struct method *method, const struct step *step, double theta, double *y);
    /* Returns the amplitude growth per step (spectral radius) for q'' + 2 zeta q' + q = 0 at x =
     * dt. NULL stands for that of the one-step matrix. */
    double (*growth)(const struct method *method, double x, double zeta, enum stiffness_sign sign);
    /* Only for METHOD_EXTERNAL: create and free the memory of the library (begin() returns NULL if
     * out of memory), and take an adaptive step under its own control. */
    void *(*begin)(const struct method *method, const struct step *step);
    void (*end)(void *library);
    enum step_status (*adapt)(const struct method *method, struct step *step,
                              struct controller *controller, double t_end);
    /* Coefficients of the method's family; the other pointers are NULL. */
    const struct tableau *tableau;
    const struct splitting *splitting;
    const struct nystrom *nystrom;
    const struct implicit_tableau *implicit;
    const struct rosenbrock *rosenbrock;
    const struct multistep *multistep;
};

/* All methods of this build (struct method). */
extern const struct catalog method_catalog;
/* Returns the method with this name or alias, or NULL if there is none. */
const struct method *method_by_name(struct text name);
/* Returns method i of the catalog. */
const struct method *method_at(size_t i);
/* Returns the method whose struct row this is; it must be in method_catalog. */
const struct method *method_from(const struct row *row);
/* Returns the method of this name, or NULL if this build does not have it. */
const struct method *method_find(const char *name);

/* Returns true if the method can step this system with this variant of drag, and replaces
 * DRAG_DEFAULT by the method's default. Otherwise returns false with the reason in `error`. */
bool method_applies(const struct method *method, const struct system *system, enum drag *drag,
                    struct error *error);
/* Returns true if the method can take steps of h [s] on this system, else false with the reason in
 * `error`. Splittings of higher order have backward substeps, which strong drag makes unstable. */
bool method_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                 struct error *error);
/* Returns the number of doubles of work memory for n variables. */
size_t method_work_size(const struct method *method, int n);
/* The owner of the work memory calls method_begin() after step->system is set, and method_end() at
 * the end. Only external libraries allocate memory, for this n, and may allocate more in their
 * first step. method_begin() returns false if out of memory. */
bool method_begin(const struct method *method, struct step *step);
void method_end(const struct method *method, struct step *step);
/* Returns true if fixed steps of this method end at the switches of this system:
 * method_turning_step() then takes each step in pieces. */
bool method_meets_switches(const struct method *method, const struct system *system);
/* Returns true if steps of this method end at turning points (v = 0) of this system. A step across
 * a kink of a force at v = 0 loses its order; methods above order 2 that may change their step
 * therefore end one there, unless the system asks to step across: method_adapt() does so by itself,
 * method_turning_step() splits steps of fixed size. */
bool method_turns(const struct method *method, const struct system *system);
/* Takes one step. On STEP_OK y is the state at t + h, and t has advanced; otherwise y and t are
 * unchanged, bit for bit. Never allocates. */
enum step_status method_step(const struct method *method, struct step *step);
/* Does the same in pieces that end at turning points and switches, where method_turns() or
 * method_meets_switches(). The dense output is then that of the last piece. */
enum step_status method_turning_step(const struct method *method, struct step *step);
/* Returns the degree in theta of the dense output, at most DENSE_DEGREE, or 0 if it is no
 * polynomial. */
#define DENSE_DEGREE 12
int method_dense_degree(const struct method *method);
/* Computes the state y [n] at the fraction theta of the last step, from t - h to t; y_begin [n] is
 * the state at its start. */
void method_dense(const struct method *method, const struct step *step, const double *y_begin,
                  double theta, double *y);

/*
 * The dense output of one variable over the last step as a polynomial in theta (0 at its start, 1
 * at its end), prepared once for many theta:
 *   end - h (1 - theta) (rise - theta (first + theta (twist + (1 - theta) (bend_0 + theta (bend_1 +
 * …)))))
 */
enum { DENSE_BENDS = 4 };

/* Coefficients, of which `end` is the value at the end, h the length of the step [s], the others
 * are derivatives; `bends` of bend[] are used. */
struct dense_polynomial {
    double end, h, rise, first, twist, bend[DENSE_BENDS];
    int bends;
};

/* Returns the value at the fraction theta of the step. */
static inline double dense_polynomial_at(const struct dense_polynomial *p, double theta)
{
    const double rest = 1 - theta;
    double bend = 0;
    for (int m = p->bends; m-- > 0;)
        bend = (m % 2 == 0 ? rest : theta) * (p->bend[m] + bend);
    return p->end - p->h * (rest * (p->rise - theta * (p->first + theta * (p->twist + bend))));
}

/* Computes the polynomial of variable i over the last step. Only for explicit Runge-Kutta and
 * Rosenbrock methods with a dense output of their own. */
void method_polynomial(const struct method *method, const struct step *step, int i,
                       struct dense_polynomial *polynomial);

/*
 * ---- many steps of one size ----
 *
 * A march is a series of `count` fixed steps of step->h in one call; step i = first, first + 1, …
 * begins at origin + i h. The states after the steps go to row [count][n], the last one also to
 * step->y. There are no compensated sums and no error estimates.
 */

/* Arguments of a march. */
struct march {
    /* Step with the state at the beginning; receives the last state. */
    struct step *step;
    double origin; /* Time [s] of step 0 of the grid. */
    /* Index of the first step, and number of steps. */
    int64_t first, count;
    /* [count][n] states after the steps. */
    double *row;
};

/* A kernel of a march takes the same steps, with the same bits, by code compiled for one method and
 * one kind of scene. Returns the number of steps taken, less than `count` if the next one has no
 * solution. It checks nothing else, so that states may become infinite or NaN. A kernel is kept in
 * the program only while `make bench` shows its gain. */
typedef int64_t march_function(const struct method *method, const struct march *march);

/* Returns the kernel for marches of this method, kind of system and variant of drag, or NULL if
 * there is none. */
march_function *method_kernel(const struct method *method, const struct system *system,
                              enum drag drag);
/* Returns the kernel for single steps with an error estimate, whatever the variant of drag, or
 * NULL. */
step_function *method_step_kernel(const struct method *method, const struct system *system);
/* Returns the kernel for accepted adaptive steps of a method with METHOD_CONTROLLED, or NULL. */
controlled_function *method_controlled_kernel(const struct method *method,
                                              const struct system *system);
/* Sets step->kernel and step->controlled for step->system if `special`, else to NULL. */
void method_choose_kernels(const struct method *method, struct step *step, bool special);
/* Does the same as method_march(), with method_turning_step() where steps end at turning points or
 * switches; the kernel, which may be NULL, takes the steps between. */
int64_t method_turning_march(const struct method *method, march_function *kernel,
                             const struct march *march, enum step_status *status);
/* Takes the steps of a march by the kernel, or by method_step() if that is NULL. Returns the number
 * of steps taken; if it is less than march->count, *status is the reason and step->y the state
 * before the failed step. */
int64_t method_march(const struct method *method, march_function *kernel, const struct march *march,
                     enum step_status *status);

/*
 * ---- step-size control ----
 *
 * method_adapt() takes one accepted step with |error_i| <= fraction tol max(scale_i, |y_i|) in the
 * RMS sense, where fraction is that of struct method. If the estimate is of order k and the method
 * of order p, tol^(k/p) replaces tol. Step sizes follow from digital filters (Soderlind 2003).
 *
 * tol is relative to sizes of the scene, never to raw SI numbers: scale_i = (mean of max(|y_i|,
 * s_i)^(1/4))^4 over the time of the run so far, where s_i is the system's natural size. So a size
 * that was guessed too small does no harm, and no size is 0 or infinite. A short peak, as of a
 * relaxation oscillation, does not make the motion between peaks inaccurate; the maximum of |y_i|
 * as a scale would (the phase of the Oregonator was wrong by 3e-7 at tol 1e-13). If the scene gives
 * an atol_i, tol scale_i = atol_i instead. The fraction of each row makes methods comparable: after
 * some ten periods of an oscillation the accumulated error is at most ten times tol.
 *
 * A step goes towards t_end, on either side of t, and never past it; one that reaches it sets t =
 * t_end exactly and keeps the proposal for the next step, as does one to a turning point. step->h
 * becomes the step taken. A state that is not finite is tried again with h/4, up to 20 times.
 * Unless the result is STEP_OK, y, t and the controller are unchanged.
 */

/* State of the switches of a system between steps: a step is taken on frozen branches and ends
 * where the guard of one becomes 0. Where both branches lead back to the switch, the motion slides
 * along it. Where switches follow each other in ever shorter times (a block is a fixed number of
 * them) they have piled up, and the motion slides along all of them. Zero-initialise it; steps do
 * the rest. */
struct switches_state {
    /* `branch` is known; a branch has changed at t; switches have piled up. */
    bool known, begins, piled;
    int fresh;      /* Switch at which the last step ended, or -1. */
    double t;       /* Time [s] to which the state belongs. */
    unsigned count; /* Number of switches passed so far. */
    int shorter; /* Number of successive blocks that were each much shorter than the one before. */
    /* [s] time at which the current block began, and duration of the last one. */
    double t_block, block;
    bool recent[LIMIT_SWITCHES]; /* Switches that were passed in this block. */
    /* Branch of each switch, see system_branches(). */
    double branch[LIMIT_SWITCHES];
    /* Switches along which the motion slides, in steps of about slide_step [s]. */
    bool slides_along[LIMIT_SWITCHES];
    int released; /* Switch along which it slid until the last step, or -1. */
    double slide_step;
    double taken[LIMIT_SWITCHES]; /* `branch` and slides_along of the last step. */
    bool slid_along[LIMIT_SWITCHES];
    int64_t slides, piles; /* Numbers of times that sliding and piling up have begun. */
    /* Steps taken across a switch because neither branch leads on and the motion does not slide. */
    int64_t crossings;
    double slid; /* Time [s] at which the first of all these began, and its switch. */
    int first;
};

/* State of the step-size control of an adaptive integration. Initialise `tol`, and h if known, and
 * zero the rest. */
struct controller {
    double tol;                    /* Relative tolerance, at least 10 eps. */
    double scale[LIMIT_VARIABLES]; /* [n] size of each variable along the run, scale_i above. */
    /* [n] integral over time [s] of (|y_i|/s_i)^(1/4) - 1 where that is positive, from which
     * scale_i follows. */
    double excess[LIMIT_VARIABLES];
    double elapsed, sampled; /* [s] time since the first step; t of the last sample of sizes. */
    /* A first sample has been taken. */
    bool sampling;
    double h; /* Proposal [s] for the next step, or 0 if a first step has to be chosen. */
    /* [s] rounding error lost from t so far (Neumaier 1974), so that equal steps are rounded alike.
     */
    double t_low;
    double last; /* Length [s] of the last accepted step. */
    /* Square of its error relative to the allowed one; 0 if there is no history. */
    double previous;
    /* The last try was rejected. */
    bool rejected;
    struct switches_state switches;
};

/* Takes one accepted step towards t_end [s], as described above. */
enum step_status method_adapt(const struct method *method, struct step *step,
                              struct controller *controller, double t_end);
/* Returns true if the next steps can be taken by method_adapt_many(): the method has a kernel for
 * this system, and no step ends at a switch or turning point. */
bool method_adapts_many(const struct step *step, const struct controller *controller);
/* Takes up to `count` > 0 steps, the same as method_adapt(), and writes state and time after each
 * to row [count][n + 1], unless that is NULL. Ends early within rounding of t_end. Returns the
 * number of steps taken; *status is the result of the next one if it was tried. */
int64_t method_adapt_many(struct step *step, struct controller *controller, double t_end,
                          int64_t count, double *row, enum step_status *status);
/* Returns the system on which the last adaptive step was taken: with switches *frozen, which may
 * refer to *sliding (zeroed before; freed by sliding_free()), else `system`. */
const struct system *method_adapted(const struct system *system,
                                    const struct controller *controller, struct sliding *sliding,
                                    struct system *frozen);

/*
 * ---- linear stability ----
 *
 * They refer to q'' + gamma q' + omega^2 q = 0 in the scaled state (q, v/omega), with x = omega dt
 * and zeta = gamma / (2 omega). If the sign of the stiffness is zero or negative, the last term is
 * 0 or -omega^2 q, and omega is only a unit of frequency.
 */

/* Computes the one-step matrix, row-major, by stepping the two unit vectors. Returns false if the
 * method does not apply or has no such matrix. */
bool method_amplification(const struct method *method, enum drag drag, double x, double zeta,
                          double matrix[4]);
/* Returns the largest magnitude of the eigenvalues of a 2 by 2 matrix. */
double matrix_spectral_radius(const double matrix[4]);
/* Returns the amplitude growth per step (spectral radius), also of methods without a one-step
 * matrix, or NAN if the method does not apply. */
double method_growth(const struct method *method, enum drag drag, double x, double zeta);
/* Does the same for a stiffness of this sign. */
double method_growth_signed(const struct method *method, enum drag drag, double x, double zeta,
                            enum stiffness_sign sign);
/* Returns the supremum of the x such that all steps from 0 to it have growth <= 1: HUGE_VAL if
 * every step is stable, 0 if none is, NAN if the method or variant does not apply. Growth of up to
 * 1e-12 counts as rounding, unless it rises as a power of x. */
double method_stable_limit(const struct method *method, enum drag drag, double zeta);
/* Does the same for a stiffness of this sign. */
double method_stable_limit_signed(const struct method *method, enum drag drag, double zeta,
                                  enum stiffness_sign sign);
