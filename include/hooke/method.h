/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * method: the integrators as rows of a catalog, one step of each, many steps, step-size control and
 * linear stability.
 *
 * To integrate by hand: method_applies(), fill a struct step whose work memory has
 * method_work_size() doubles, method_begin(); then method_step() for fixed steps, or method_adapt()
 * with a struct controller for adaptive ones; method_dense() inside the last step; method_end(). A
 * run (<hooke/run.h>) does all of this. The general steps call force terms through
 * pointers and define the result; a kernel, a faster form of a step for one kind of scene, must
 * give the same bits.
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

/* Type of a function that takes one step; its contract is that of method_step(). */
typedef enum step_status step_function(const struct method *method, struct step *step);
/* Type of a function that takes several accepted adaptive steps; its contract is that of
 * method_adapt_many(). */
typedef int64_t controlled_function(struct step *step, struct controller *controller, double t_end,
                                    int64_t count, double *row, enum step_status *status);

/* Sign of the stiffness of a linear oscillator: the force at a displacement points towards
 * equilibrium, is 0, or points away from it. */
enum stiffness_sign { STIFFNESS_POSITIVE, STIFFNESS_ZERO, STIFFNESS_NEGATIVE };

double stiffness_sign_value(enum stiffness_sign sign); /* Returns 1, 0 or -1. */

/* Variants of drag: "exact", "implicit" and "explicit", struct row at index (enum drag) - 1. */
extern const struct catalog drag_catalog;

/* Counts of the work of all steps so far; each step adds to them. */
struct cost {
    int64_t evals;     /* evaluations of the right-hand side */
    int64_t jacobians; /* evaluations of the Jacobian */
    int64_t solves;    /* solutions of linear or closed-form equations */
    int64_t rejected;  /* rejected steps; their evaluations are counted above */
    int64_t turns;     /* steps that ended at a turning point or switch, see method_turns() */
    int64_t poles;     /* fixed steps across a time at which a derivative is infinite */
};

/* Input and output of one step of a method. The caller owns the struct and all that its members
 * point to, except `library`. Set system, drag, t, h, y and work, and zero the other members. */
struct step {
    /* The differential equation. */
    const struct system *system;
    /* Variant of drag, as resolved by method_applies(): DRAG_DEFAULT only if the method has no
     * variants. */
    enum drag drag;
    /* Time [s] at which the step begins, and length of the step [s], which may be negative but not
     * 0. */
    double t, h;
    /* [n] state: that at t on entry, that at t + h on return. */
    double *y,
        /* [n] receives the estimate of the local error in units of y; NULL if it is not needed. */
        *error,
        /* Work memory of method_work_size() doubles. */
        *work;
    /* [n] rounding errors of y that compensated sums carry along (Kahan 1965), or NULL for plain
     * sums. */
    double *low;
    /* `work` contains values of the previous step that the next step reuses (the last stage, or
     * the history of a multistep method). method_step() sets the flag; code that changes y, the
     * system or t (by more than rounding) between steps must clear it. */
    bool warm;
    /* State of the external library of a METHOD_EXTERNAL; method_begin() allocates it and
     * method_end() frees it. NULL for other methods. */
    void *library;
    /* Kernel, the method's step compiled for this kind of system, as method_step_kernel() returns
     * it; NULL for the general step. */
    step_function *kernel;
    /* Kernel for accepted adaptive steps, as method_controlled_kernel() returns it, or NULL. */
    controlled_function *controlled;
    /* The previous attempt at this step, with a larger h, was rejected, so that the evaluations at
     * t and y are still valid. method_adapt() sets this flag, `tol`, `scale` and `square`. */
    bool again;
    /* Tolerance of an adaptive step: an error whose RMS, relative to max(scale_i, |y_i|), is tol is
     * acceptable. Iterations of implicit methods end accordingly. 0 marks a fixed step. */
    double tol;
    /* [n] sizes of the variables along the run (see struct controller), or NULL for those of the
     * system. */
    const double *scale;
    /* Receives the sum of (error_i / max(scale_i, |y_i|))^2 if the method's step computes it, else
     * is unchanged. */
    double square;
    struct cost cost; /* Work of this step and all previous ones. */
    /* Receives the counts `slides`, `piles` and `crossings` of fixed steps, or NULL. */
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
    /* Method of an external library, for comparison. Has adaptive steps only, and is last in the
     * catalog. */
    METHOD_EXTERNAL = 4096,
    /* Has kernels compiled for this method alone, because it is common or a reference for speed. */
    METHOD_UNROLLED = 8192,
    METHOD_CONTROLLED = 16384, /* Has kernels for accepted adaptive steps, because it is common. */
};

/* Coefficients of methods, a struct for each family; private to src/method. */
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
    /* Order of the embedded method, whose difference is the error estimate; 0 if there is none. */
    int embedded;
    /* Fraction of the tolerance that the error estimate of a step may reach (see method_adapt()); 0
     * stands for 1/3. */
    double fraction;
    int evals; /* Evaluations of the right-hand side in each step after the first. */
    /* Flags of enum method_flag. */
    unsigned flags;
    /* Index of the row in the .def file of its family. Kernels include the file again and find
     * their row by this index. */
    int index;
    /* Default variant of drag. DRAG_DEFAULT means that drag is part of the right-hand side, without
     * variants. */
    enum drag drag;
    unsigned drags; /* Bits 1 << d for each variant d (enum drag) that the method supports. */
    /* Takes one step of any system that the method applies to. Contract of method_step(). */
    enum step_status (*step)(const struct method *method, struct step *step);
    /* Returns the number of doubles of work memory for n variables. */
    size_t (*work)(const struct method *method, int n);
    /* Computes the state y [n] at the fraction theta (0 to 1) of the last step. If NULL, the dense
     * output is the cubic Hermite polynomial through both ends. */
    void (*dense)(const struct method *method, const struct step *step, double theta, double *y);
    /* Returns the amplitude growth per step (spectral radius) for q'' + 2 zeta q' + q = 0, or with
     * the stiffness of this sign, at x = dt. If NULL, the growth follows from the one-step matrix.
     */
    double (*growth)(const struct method *method, double x, double zeta, enum stiffness_sign sign);
    /* Functions of a METHOD_EXTERNAL, else NULL. begin() creates the library's state,
     * step->library, or returns NULL if out of memory; end() frees it. adapt() takes an adaptive
     * step whose size the library controls; its contract is that of method_adapt(). */
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
/* Returns the method with this name or alias, or NULL if there is none in this build. */
const struct method *method_by_name(struct text name);
/* Returns method i of the catalog. */
const struct method *method_at(size_t i);
/* Returns the method whose struct row this is; it must be in method_catalog. */
const struct method *method_from(const struct row *row);
/* Does the same for a name that ends with a NUL. */
const struct method *method_find(const char *name);

/* Returns true if the method can step this system with the variant *drag, and replaces DRAG_DEFAULT
 * in *drag by the method's default. Otherwise returns false with the reason in `error`. */
bool method_applies(const struct method *method, const struct system *system, enum drag *drag,
                    struct error *error);
/* Returns true if the method can take steps of h [s] on this system, else false with the reason in
 * `error`. Splittings of higher order have backward substeps, which strong drag makes unstable. */
bool method_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                 struct error *error);
/* Returns the number of doubles of work memory for n variables. */
size_t method_work_size(const struct method *method, int n);
/* Begin and end the use of a struct step, whose `system` must be set before. Only methods of
 * external libraries allocate memory here, for the n of the system, and may allocate more in their
 * first step. method_begin() returns false if out of memory. */
bool method_begin(const struct method *method, struct step *step);
void method_end(const struct method *method, struct step *step);
/* Returns true if fixed steps of this method must end at the switches of this system. Such steps
 * are taken by method_turning_step(), in pieces. */
bool method_meets_switches(const struct method *method, const struct system *system);
/* Returns true if steps of this method end at turning points (v = 0) of this system. A step across
 * a kink of a force at v = 0 loses its order; methods above order 2 that may change their step
 * therefore end a step at the kink, unless steps_across_kinks of the system is set. method_adapt()
 * ends its steps there; fixed steps are split by method_turning_step(). */
bool method_turns(const struct method *method, const struct system *system);
/* Takes one step. On STEP_OK y is the state at t + h, and t has advanced; otherwise y and t are
 * unchanged, bit for bit. Never allocates. */
enum step_status method_step(const struct method *method, struct step *step);
/* Does the same in pieces that end at turning points and switches. For methods and systems for
 * which method_turns() or method_meets_switches() returns true. The dense output is that of the
 * last piece. */
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
 * The dense output of one variable over the last step as a polynomial in theta (0 at the start of
 * the step, 1 at its end), prepared once for many theta:
 *   y(theta) = end - h (1 - theta) (rise - theta (first + theta twisted)),
 *   twisted = twist + (1 - theta) (bend_0 + theta (bend_1 + (1 - theta) (bend_2 + …)))
 */

/* Largest number of terms bend_i. */
enum { DENSE_BENDS = 4 };

/* Coefficients of the polynomial. For explicit Runge-Kutta methods with the slopes k at the start
 * and l at the end of the step, first = k - rise and twist = 2 rise - k - l, so that the polynomial
 * without the terms bend_i is the cubic Hermite polynomial. */
struct dense_polynomial {
    double end,            /* Value at the end of the step. */
        h,                 /* Length of the step [s], or 1 if the other coefficients contain it. */
        rise,              /* Mean slope: (value at the end - value at the start) / h. */
        first,             /* Quadratic term. */
        twist,             /* Cubic term. */
        bend[DENSE_BENDS]; /* [bends] terms of higher degree. */
    int bends;
};

/* Returns the value of polynomial *p at the fraction theta of the step. */
static inline double dense_polynomial_at(const struct dense_polynomial *p, double theta)
{
    const double rest = 1 - theta;
    double bend = 0;
    for (int m = p->bends; m-- > 0;)
        bend = (m % 2 == 0 ? rest : theta) * (p->bend[m] + bend);
    return p->end - p->h * (rest * (p->rise - theta * (p->first + theta * (p->twist + bend))));
}

/* Computes the polynomial of variable i over the last step. The method must be an explicit
 * Runge-Kutta or Rosenbrock method with method->dense set. */
void method_polynomial(const struct method *method, const struct step *step, int i,
                       struct dense_polynomial *polynomial);

/*
 * ---- many steps of one size ----
 *
 * A march is a series of `count` fixed steps of h = step->h in one call. The steps are numbered
 * from `first` on; step i begins at the time origin + i h. The states after the steps are written
 * to row [count][n], the last one also to step->y. A march has no compensated sums and no error
 * estimates.
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

/* Kernel of a march: takes the steps of method_march(), with the same bits, by code compiled for
 * one method and one kind of scene. Returns the number of steps taken, which is less than `count`
 * if the next step has no solution. Nothing else is checked, so that states may become infinite or
 * NaN. A kernel is kept in the program only while `make bench` shows its gain. */
typedef int64_t march_function(const struct method *method, const struct march *march);

/* Returns the kernel for marches of this method and kind of system with this variant of drag, or
 * NULL if there is none. */
march_function *method_kernel(const struct method *method, const struct system *system,
                              enum drag drag);
/* Returns the kernel for single steps with an error estimate, which serves all variants of drag, or
 * NULL if there is none. */
step_function *method_step_kernel(const struct method *method, const struct system *system);
/* Returns the kernel for accepted adaptive steps of a method with METHOD_CONTROLLED, or NULL if
 * there is none. */
controlled_function *method_controlled_kernel(const struct method *method,
                                              const struct system *system);
/* Sets step->kernel and step->controlled to the kernels for step->system, or NULL if there are
 * none. If `special` is false, both become NULL, so that the general steps are taken. */
void method_choose_kernels(const struct method *method, struct step *step, bool special);
/* Does the same as method_march(), and takes steps that end at turning points or switches by
 * method_turning_step(). The kernel, which may be NULL, takes the other steps. */
int64_t method_turning_march(const struct method *method, march_function *kernel,
                             const struct march *march, enum step_status *status);
/* Takes the steps of a march by the kernel, or by method_step() if `kernel` is NULL. Returns the
 * number of steps taken; if it is less than march->count, *status is the reason and step->y the
 * state before the failed step. */
int64_t method_march(const struct method *method, march_function *kernel, const struct march *march,
                     enum step_status *status);

/*
 * ---- step-size control ----
 *
 * method_adapt() takes one accepted step: the RMS of error_i / max(scale_i, |y_i|) over the
 * variables is at most `fraction` tol, with the `fraction` of struct method. If the error estimate
 * is of order k and the method of order p, tol^(k/p) replaces tol. Step sizes follow from digital
 * filters (Soderlind 2003).
 *
 * tol is relative to sizes of the scene, never to raw SI numbers: scale_i = (mean of max(|y_i|,
 * s_i)^(1/4))^4 over the time of the run so far, where s_i is the system's natural size
 * (system->scale). An s_i that is too small does no harm, and no scale_i is 0 or infinite. Short
 * peaks of a relaxation oscillation hardly raise the mean, so that the motion between peaks remains
 * accurate; the maximum of |y_i| as the scale made the phase of the Oregonator wrong by 3e-7 at tol
 * 1e-13. If the scene gives an atol_i, scale_i = atol_i / tol. The fraction of each method makes
 * methods comparable: after some ten periods of an oscillation the accumulated error is at most ten
 * times tol.
 *
 * Steps go towards t_end, which may lie before or after t, and never past it. A step that reaches
 * t_end sets t = t_end exactly. A step that is shortened to end at t_end or at a turning point can
 * only raise the proposed length of the next step. step->h receives the length of the step.
 * If the new state is not finite, the step is tried again with h/4, up to 20 times. Unless the
 * result is STEP_OK, y, t and the controller are unchanged.
 */

/* State of the switches of a system between steps. A switch is a place in state space at which a
 * force changes its branch (its smooth expression); a guard is a function that is 0 there. A step
 * is taken with all branches frozen and ends where a guard becomes 0; the motion has then passed
 * the switch. Where the forces of both branches lead back to the switch, the motion slides along
 * it. Where switches are passed in ever shorter times they pile up, and the motion then slides
 * along all switches passed last. To detect this, the passed switches are counted in blocks of a
 * fixed number. Zero-initialise the struct; only steps change it. */
struct switches_state {
    bool known,     /* `branch` is valid at time t. */
        begins,     /* The last step ended at a switch: the next one has to find its branches. */
        piled;      /* Switches have piled up: sliding is to begin. */
    int fresh;      /* Index of the switch at which the last step ended, or -1. */
    double t;       /* Time [s] at the end of the last step. */
    unsigned count; /* Number of switches passed so far. */
    /* Number of successive blocks each of which took much less time than the block before. */
    int shorter;
    double t_block,              /* Time [s] at which the current block began. */
        block;                   /* Duration [s] of the previous block. */
    bool recent[LIMIT_SWITCHES]; /* Switches that were passed in the current block. */
    /* Branch of each switch for the next step, see system_branches(). */
    double branch[LIMIT_SWITCHES];
    bool slides_along[LIMIT_SWITCHES]; /* Switches along which the next step slides. */
    /* Switch along which the motion slid until it left it at the end of the last step, or -1. */
    int released;
    /* Time [s] over which the guards of these switches are differentiated numerically. */
    double slide_step;
    /* `branch` and slides_along as they were in the last step. */
    double taken[LIMIT_SWITCHES];
    bool slid_along[LIMIT_SWITCHES];
    int64_t slides, /* Number of times that sliding has begun. */
        piles;      /* Number of times that switches have piled up. */
    /* Number of steps taken across a switch, because neither branch leads away from the switch and
     * sliding has no solution. */
    int64_t crossings;
    double slid; /* Time [s] of the first slide or crossing. */
    int first;   /* Switch of the first slide. */
};

/* State of the step-size control of an adaptive integration. Set `tol`, and h if a first step is
 * known, and zero the other members. */
struct controller {
    double tol;                    /* Relative tolerance, at least 10 eps. */
    double scale[LIMIT_VARIABLES]; /* [n] scale_i above: size of each variable along the run. */
    /* [n] integral over time [s] of max((|y_i|/s_i)^(1/4) - 1, 0), from which scale_i follows. */
    double excess[LIMIT_VARIABLES];
    double elapsed, /* Time [s] since the first step. */
        sampled;    /* Time t [s] up to which `excess` is integrated. */
    bool sampling;  /* `sampled` is valid. */
    double h; /* Proposed length [s] of the next step, or 0 if a first step has to be chosen. */
    /* [s] sum of the rounding errors of t (compensated sum, Neumaier 1974), to be added to t. */
    double t_low;
    double last; /* Length [s] of the last accepted step. */
    /* Square of the error of that step divided by the allowed error; 0 before the first step. */
    double previous;
    bool rejected; /* The last attempt at a step was rejected. */
    struct switches_state switches;
};

/* Takes one accepted step towards t_end [s], as described above. */
enum step_status method_adapt(const struct method *method, struct step *step,
                              struct controller *controller, double t_end);
/* Returns true if the next steps can be taken by method_adapt_many(): the method has a kernel for
 * this system, and no step ends at a switch or turning point. */
bool method_adapts_many(const struct step *step, const struct controller *controller);
/* Takes up to `count` > 0 of the steps that method_adapt() would take, with the same bits, and
 * writes state and time after each step to row [count][n + 1], unless `row` is NULL. Ends early if
 * t is within rounding of t_end. Returns the number of steps taken. *status is STEP_OK, or the
 * result of the step that failed after them. */
int64_t method_adapt_many(struct step *step, struct controller *controller, double t_end,
                          int64_t count, double *row, enum step_status *status);
/* Returns the system that the last adaptive step integrated. Returns `system` if it has no
 * switches or if their branches are unknown. Otherwise fills *frozen with the system on the
 * branches of the step, or along the switches on which it slid, and returns `frozen`. *frozen may
 * refer to *sliding, which the caller zeroes before and frees by sliding_free(). */
const struct system *method_adapted(const struct system *system,
                                    const struct controller *controller, struct sliding *sliding,
                                    struct system *frozen);

/*
 * ---- linear stability ----
 *
 * The functions refer to q'' + gamma q' + omega^2 q = 0 in the scaled state (q, v/omega), with x =
 * omega dt and zeta = gamma / (2 omega). If the sign of the stiffness is zero or negative, the term
 * omega^2 q is replaced by 0 or -omega^2 q, and omega is only a unit of frequency.
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
/* Returns the stable limit: the largest x such that all steps below x have growth <= 1. Returns
 * HUGE_VAL if every step is stable, 0 if none is, NAN if the method or variant of drag does not
 * apply. A growth above 1 by up to 1e-12 counts as rounding, unless it rises as a power of x. */
double method_stable_limit(const struct method *method, enum drag drag, double zeta);
/* Does the same for a stiffness of this sign. */
double method_stable_limit_signed(const struct method *method, enum drag drag, double zeta,
                                  enum stiffness_sign sign);
