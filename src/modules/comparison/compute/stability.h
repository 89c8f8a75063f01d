/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stability of methods, and the stress of extreme scenes. */
#pragma once

#include "modules/comparison/compute/compare.h"

struct cancel;
struct catalog;

/* ---- stability: predicted from the method, verified by running it ----
 *
 * Each eigenvalue lambda of the scene's Jacobian is an oscillator of its own: omega = |lambda|,
 * zeta = -Re lambda/omega. On a linear scene that is the whole truth; else it is taken at the start
 * and along the run, and is an estimate.
 */

struct mode {
    double omega, zeta; /* [1/s]; zeta > 1: a pair of real eigenvalues; < 0: it grows */
    double t;           /* [s] where it was met */
    /* Sign s of y'' + 2 zeta omega y' + s omega^2 y = 0; if it is not positive, omega is a unit. */
    enum stiffness_sign sign;
};

/* [1/s] The two eigenvalues, that with the larger real part first; im of the first, the second is
 * conjugate. */
void mode_eigenvalues(const struct mode *mode, double re[2], double *im);

struct stability_request {
    const struct scene *scene;
    struct method_choice choice;
    double dt, duration; /* [s] */
    const struct cancel *cancel;
};

struct stability_check { /* one step size, run for so many steps */
    /* Growth per step; the measured one is from the envelopes of the second and the last
     * quarter. */
    double dt, predicted, measured;
    int64_t steps;
    bool agrees;
};

enum stability_verdict { STABILITY_STABLE, STABILITY_MARGINAL, STABILITY_UNSTABLE };

extern const struct catalog stability_verdict_catalog;

#define STABILITY_MODES 48

struct stability {
    struct method_choice choice;
    double dt;
    bool linear, grows; /* the scene itself grows somewhere: no step is asked to prevent that */
    struct mode mode[STABILITY_MODES]; /* those at the start first */
    int modes, at_start;
    struct mode worst;    /* grows most at dt */
    struct mode tightest; /* sets dt_max */
    /* [s] supremum of the steps in which nothing grows but what does so by itself: HUGE_VAL for all
     * steps, 0 for none, NAN if nothing decides it. */
    double dt_max;
    bool scalar;  /* one equation of first order: it has a rate, no omega or zeta */
    bool refused; /* dt_max is the longest step that the method takes, stable or not */
    double growth_predicted, growth_measured, growth_exact; /* a step of dt, of the worst mode */
    double energy_factor;                                   /* a step */
    struct stability_check check[3]; /* dt, a little below dt_max, a little above */
    int checks;
    bool agrees;
    enum stability_verdict verdict;
    double doubling; /* steps until the amplitude doubles, or HUGE_VAL if it never does */
    double weak[2];  /* growth - 1 is about weak[0] (omega dt)^weak[1], or NAN if it is not weak */
    /* [s], [s], [1] Begin and end of a narrow resonance and the largest growth in it, or NAN if
     * there is none. */
    double window[3];
    enum stop stop;          /* stop of a run of the scene itself with dt, if it is not linear */
    double reached, largest; /* [s] and amplitude of that run over the natural one */
};

extern const struct result_columns stability_columns; /* columns of struct stability */
/* A growth a step for people: "1.00012", "1+2.3e-06". */
void buffer_growth(struct buffer *output, double growth);

bool study_stability(const struct stability_request *request, struct stability *stability,
                     struct error *error);
/* Returns the growth per step on y' = lambda y with z = lambda dt (and its conjugate), or NAN if
 * the method does not apply. */
double stability_growth(const struct method_choice *choice, double re, double im);

/* ---- stress: the stiff and the extreme, each method, one verdict each ---- */

enum stress_verdict {
    STRESS_EXACT,    /* error at rounding, or at what can be known */
    STRESS_ACCURATE, /* error below 1 % */
    STRESS_BOUNDED,  /* wrong, but no larger than the motion */
    STRESS_DAMPED,   /* the oscillation has vanished */
    STRESS_SINGULAR, /* the solution itself goes to infinity on the way */
    STRESS_REFUSED,  /* not run, with the reason: does not apply, out of budget, no solution … */
    STRESS_DIVERGED,
    STRESS_UNKNOWN,     /* arrived, but no two references do */
    STRESS_UNEXPLAINED, /* none of these: must not happen */
    STRESS_VERDICTS
};

extern const struct catalog stress_verdict_catalog;

/* A preset with some parameters set, or a scene of the caller's with one thing changed. */
struct stress_case {
    const char *name, *brief;
    const char *preset;
    struct {
        const char *param;
        double value; /* SI */
    } set[8];
    const struct stress_scene *stress_scene; /* the typed scene, or NULL for the preset */
    enum { STRESS_AS_IT_IS, STRESS_STEP, STRESS_PARAM, STRESS_START } change;
    int param; /* index of the parameter for STRESS_PARAM */
    /* SI value of the parameter or the initial values; for STRESS_STEP, dt in units of the method's
     * own limit. */
    double value;
    double span; /* [s] 0 means ten seconds */
    bool fixed;  /* the case is about its dt: methods that adapt take it too */
    double dt;   /* [s] where fixed, else span/1024 */
    double tol;  /* 0 means 1e-6 for methods that adapt */
};

/* Fills in a case: the table's, then every preset that calls itself stiff or extreme. Returns false
 * beyond the last. */
bool stress_case_at(size_t index, struct stress_case *result);

struct stress_row {
    int index;         /* index of the case */
    const char *scene; /* name of the case */
    const struct method *method;
    enum stress_verdict verdict;
    double error; /* NAN if it did not reach the end, or if there is no reference */
    int64_t steps;
    double seconds; /* [s] computing time */
    char reason[240];
};

#define STRESS_MAX 300 /* cases */

/* A scene that is driven to extremes: steps, parameters, initial values. */
struct stress_scene {
    const struct scene *scene;
    double span;        /* [s] */
    const bool *start;  /* [parameters] which are initial values */
    const bool *matter; /* [parameters] which others act */
};

struct stress {
    struct stress_case cases[STRESS_MAX];
    int count;
    struct arena text;      /* names of the cases of a scene */
    struct stress_row *row; /* [rows] by case, then by method; owned, release with stress_free() */
    int rows;
    int count_of[STRESS_VERDICTS];
    double seconds;
};

/* Runs the cases, of the scene or, if it is NULL, the built-in ones. `only` selects one of them by
 * its name or its number from 1; if empty, all are run. Returns false with the error also if
 * cancelled: finished rows are kept. Call stress_free() in every case. */
bool study_stress(const struct stress_scene *scene, struct text only,
                  const struct method *const *methods, int count, const struct cancel *cancel,
                  struct stress *stress, struct error *error);
void stress_free(struct stress *stress);
