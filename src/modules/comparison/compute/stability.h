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
    /* of y'' + 2 zeta omega y' +, 0, - omega^2 y = 0: where it is not the first, omega is a unit */
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
    /* growth a step; measured: envelope of the last quarter over that of the second */
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
    /* [s] supremum of the steps in which nothing grows but what does so by itself; HUGE_VAL:
     * every, 0: none, NAN: nothing decides it */
    double dt_max;
    bool scalar;  /* one equation of first order: it has a rate, no omega or zeta */
    bool refused; /* dt_max is the longest step that the method takes, stable or not */
    double growth_predicted, growth_measured, growth_exact; /* a step of dt, of the worst mode */
    double energy_factor;                                   /* a step */
    struct stability_check check[3]; /* dt, a little below dt_max, a little above */
    int checks;
    bool agrees;
    enum stability_verdict verdict;
    double doubling; /* steps until the amplitude doubles; HUGE_VAL: never */
    double weak[2];  /* growth - 1 is about weak[0] (omega dt)^weak[1]; NAN: not weak */
    /* [s], [s], 1: begin and end of a narrow resonance and the largest growth in it, or NAN if
     * there is none */
    double window[3];
    enum stop stop;          /* of the scene itself, run with dt where it is not linear */
    double reached, largest; /* [s] and amplitude of that run over the natural one */
};

extern const struct result_columns stability_columns; /* of struct stability */
/* A growth a step for people: "1.00012", "1+2.3e-06". */
void buffer_growth(struct buffer *output, double growth);

bool study_stability(const struct stability_request *request, struct stability *stability,
                     struct error *error);
/* Growth a step on y' = lambda y with z = lambda dt (and its conjugate). NAN: the method does not
 * apply there. */
double stability_growth(const struct method_choice *choice, double re, double im);

/* ---- stress: the stiff and the extreme, each method, one verdict each ---- */

enum stress_verdict {
    STRESS_EXACT,    /* error at rounding, or at what can be known */
    STRESS_ACCURATE, /* error below 1 % */
    STRESS_BOUNDED,  /* wrong, but no larger than the motion */
    STRESS_DAMPED,   /* what should swing is gone */
    STRESS_SINGULAR, /* the solution itself goes to infinity on the way */
    STRESS_REFUSED,  /* with the reason: does not apply, out of budget, no solution … */
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
    const struct stress_scene *stress_scene; /* that scene; NULL: the preset */
    enum { STRESS_AS_IT_IS, STRESS_STEP, STRESS_PARAM, STRESS_START } change;
    int param; /* PARAM: its place */
    /* SI, of the parameter or of the initial values; STEP: dt in units of the method's own limit */
    double value;
    double span; /* [s], 0: ten seconds */
    bool fixed;  /* the case is about its dt: methods that adapt take it too */
    double dt;   /* [s] where fixed, else span/1024 */
    double tol;  /* 0: 1e-6 for methods that adapt */
};

/* Fills in a case: the table's, then every preset that calls itself stiff or extreme. Returns false
 * beyond the last. */
bool stress_case_at(size_t index, struct stress_case *result);

struct stress_row {
    int index;         /* of the case */
    const char *scene; /* its name */
    const struct method *method;
    enum stress_verdict verdict;
    double error; /* NAN: did not arrive, or nothing to measure against */
    int64_t steps;
    double seconds; /* of computing */
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
    struct stress_row *row; /* [rows], case by case, the methods in order; owned: stress_free() */
    int rows;
    int count_of[STRESS_VERDICTS];
    double seconds;
};

/* scene NULL: the cases that are always there. only: one of them, by its name or its number from
 * 1; empty: all. False also when cancelled: the finished rows are kept. stress_free() in every
 * case. */
bool study_stress(const struct stress_scene *scene, struct text only,
                  const struct method *const *methods, int count, const struct cancel *cancel,
                  struct stress *stress, struct error *error);
void stress_free(struct stress *stress);
