/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Studies of stability: growth per step and longest stable step of methods on a scene
 * (study_stability), and stiff and extreme cases for all methods (study_stress). */
#pragma once

#include "modules/comparison/compute/compare.h"

struct cancel;
struct catalog;

/* ---- stability: predicted from the method, verified by running it ----
 *
 * Each eigenvalue lambda of the scene's Jacobian is treated as an oscillator of its own: omega =
 * |lambda|, zeta = -Re lambda/omega. This is exact for a linear scene. Otherwise eigenvalues are
 * taken at the start and along the run, and the limit is an estimate.
 */

/* One eigenvalue of the Jacobian, or a pair, as an oscillator. */
struct mode {
    /* [1/s] and [1]; zeta > 1 means two real eigenvalues, zeta < 0 that it grows */
    double omega, zeta;
    double t; /* [s] time of the state whose Jacobian it belongs to */
    /* Sign s of the force in y'' + 2 zeta omega y' + s omega^2 y = 0. If it is 0, omega only sets
     * the unit of zeta. */
    enum stiffness_sign sign;
};

/* Computes the two eigenvalues [1/s]: the real parts, the larger one first, and the imaginary part
 * of the first; that of the second is -*im. */
void mode_eigenvalues(const struct mode *mode, double re[2], double *im);

/* Input of study_stability(). Pointers are the caller's. */
struct stability_request {
    const struct scene *scene;
    struct method_choice choice;
    double dt, duration; /* [s] */
    const struct cancel *cancel;
};

/* A check of the prediction: the mode alone, run with one step size. */
struct stability_check {
    /* Growth per step; the measured one is from the envelopes of the second and the last
     * quarter. */
    double dt, predicted, measured;
    int64_t steps;
    bool agrees;
};

/* Verdict on a step size; the catalog explains each. */
enum stability_verdict { STABILITY_STABLE, STABILITY_MARGINAL, STABILITY_UNSTABLE };

extern const struct catalog stability_verdict_catalog;

#define STABILITY_MODES 48 /* largest number of modes of a study */

/* Result of study_stability(): what the method does to a scene at one step size. */
struct stability {
    struct method_choice choice;
    double dt;
    /* the scene is linear, and grows by itself somewhere, which no step is required to prevent */
    bool linear, grows;
    struct mode mode[STABILITY_MODES]; /* first those at the start, then those along the run */
    int modes, at_start;               /* number of modes, and of those at the start */
    struct mode worst;                 /* mode that grows most at dt */
    struct mode tightest;              /* mode whose limit is dt_max */
    /* [s] supremum of the stable steps, modes that grow by themselves left out: HUGE_VAL if all are
     * stable, 0 if none is, NAN if no mode decides it. */
    double dt_max;
    bool scalar;  /* one equation of first order, which has a rate instead of omega and zeta */
    bool refused; /* dt_max is the longest step that the method accepts, whether stable or not */
    /* factor per step of dt, of the worst mode */
    double growth_predicted, growth_measured, growth_exact;
    double energy_factor;            /* square of growth_predicted */
    struct stability_check check[3]; /* dt, a little below dt_max, a little above */
    int checks;
    bool agrees; /* all checks, and the run of the scene itself, confirm what was predicted */
    enum stability_verdict verdict;
    double doubling; /* steps until the amplitude doubles, or HUGE_VAL if it never does */
    double weak[2];  /* growth - 1 is about weak[0] (omega dt)^weak[1], or NAN if it is not weak */
    /* [s], [s], [1] Begin and end of a narrow resonance and the largest growth in it, or NAN if
     * there is none. */
    double window[3];
    enum stop stop;          /* stop of a run of the scene itself with dt, if it is not linear */
    double reached, largest; /* [s] end of that run, and its largest amplitude in natural sizes */
};

extern const struct result_columns stability_columns; /* columns of struct stability */
/* Appends a growth per step, with digits that show a small deviation from 1: "1.00012",
 * "1+2.3e-06". */
void buffer_growth(struct buffer *output, double growth);

/* Predicts growth and limit from the method's formulas and verifies them by running. Returns false
 * with an error if the method does not apply, dt is invalid, out of memory, or cancelled. */
bool study_stability(const struct stability_request *request, struct stability *stability,
                     struct error *error);
/* Returns the growth per step on y' = lambda y with z = lambda dt (and its conjugate), or NAN if
 * the method does not apply. */
double stability_growth(const struct method_choice *choice, double re, double im);

/* ---- stress: the stiff and the extreme, each method, one verdict each ---- */

/* Verdict on one method in one case. */
enum stress_verdict {
    STRESS_EXACT,    /* error at rounding, or at what can be known */
    STRESS_ACCURATE, /* error below 1 % */
    STRESS_BOUNDED,  /* wrong, but no larger than the motion */
    STRESS_DAMPED,   /* the oscillation has vanished */
    STRESS_SINGULAR, /* the solution itself goes to infinity on the way */
    STRESS_REFUSED,  /* not run, with the reason: does not apply, out of budget, no solution … */
    STRESS_DIVERGED, /* grew beyond the motion */
    STRESS_UNKNOWN,  /* arrived, but there is no reference to measure its error against */
    STRESS_UNEXPLAINED, /* none of these: must not happen */
    STRESS_VERDICTS
};

extern const struct catalog stress_verdict_catalog;

/* One case: a preset with some parameters set, or the caller's scene with one thing changed. */
struct stress_case {
    const char *name, *brief; /* name that the user types, and a line about it */
    const char *preset;       /* name of the preset, or NULL in a case of the caller's scene */
    struct {
        const char *param;
        double value;                        /* SI */
    } set[8];                                /* parameters that differ from the preset's */
    const struct stress_scene *stress_scene; /* the caller's scene, or NULL for the preset */
    /* the change that is made in the caller's scene */
    enum { STRESS_AS_IT_IS, STRESS_STEP, STRESS_PARAM, STRESS_START } change;
    int param; /* index of the parameter for STRESS_PARAM */
    /* SI value of the parameter or the initial values; for STRESS_STEP, dt in units of the method's
     * own limit. */
    double value;
    double span; /* [s] 0 means ten seconds */
    bool fixed;  /* the case is about its dt, so that methods that adapt take fixed steps, too */
    double dt;   /* [s] where fixed, else span/1024 */
    double tol;  /* tolerance of methods that adapt; 0 means 1e-6 */
};

/* Fills in the built-in case of this index: first those of the table in stress_run.c, then every
 * other preset whose name begins with "stiff-" or "extreme-". Returns false beyond the last. */
bool stress_case_at(size_t index, struct stress_case *result);

/* The result of one method in one case. */
struct stress_row {
    int index;         /* index of the case */
    const char *scene; /* name of the case */
    const struct method *method;
    enum stress_verdict verdict;
    double error; /* NAN if it did not reach the end, or if there is no reference */
    int64_t steps;
    double seconds;   /* [s] computing time */
    char reason[240]; /* explains the verdict, or is empty */
};

#define STRESS_MAX 300 /* largest number of cases */

/* The caller's scene, from which cases are made by changing its step, parameters and initial
 * values. */
struct stress_scene {
    const struct scene *scene;
    double span;        /* [s] */
    const bool *start;  /* [parameters] true for initial values */
    const bool *matter; /* [parameters] true for other parameters that have an effect */
};

/* Result of study_stress(). */
struct stress {
    struct stress_case cases[STRESS_MAX];
    int count;
    struct arena text;      /* memory of names of the cases of the caller's scene */
    struct stress_row *row; /* [rows] by case, then by method; owned, release with stress_free() */
    int rows;
    int count_of[STRESS_VERDICTS]; /* number of rows with each verdict */
    double seconds;
};

/* Runs every method in every case: cases of the given scene, or the built-in ones if it is NULL.
 * `only` selects one case by its name or its number from 1; if it is empty, all are run. Returns
 * false with an error if there is no such case, if out of memory, or if cancelled; finished rows
 * are kept. Call stress_free() in every case. */
bool study_stress(const struct stress_scene *scene, struct text only,
                  const struct method *const *methods, int count, const struct cancel *cancel,
                  struct stress *stress, struct error *error);
/* Frees the rows and the names of the cases. */
void stress_free(struct stress *stress);
