/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equilibria, periodic orbits, how both change with a parameter (branches), and the special points
 * at which they change their kind. First call equilibria_find() or orbit_find(), then
 * branch_follow() and branch_verify() from one of the solutions. All state and parameters are in SI
 * units. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/scene/model.h>
#include <hooke/base/numeric.h>
#include <hooke/run/attractor.h>

struct catalog;

/* Largest number of variables of a scene whose orbits can be followed. */
#define DYNAMICS_VARIABLES ATTRACTOR_VARIABLES

/* Kinds of solutions that branches consist of. */
enum solution_kind {
    SOLUTION_EQUILIBRIUM,
    SOLUTION_ORBIT,   /* has a period of its own */
    SOLUTION_RESPONSE /* has the period of the drive, or a multiple of it */
};

/* An equilibrium or a periodic orbit, at the parameters' values. */
struct solution {
    enum solution_kind kind;
    int n;
    double param[2]; /* SI; values of the branch's parameters, where it varies any */
    double state[DYNAMICS_VARIABLES]; /* SI; for an orbit, a state on it */
    double period;                    /* [s] 0 for an equilibrium */
    /* number of drive periods in the period, or 0 if it is not driven */
    int multiple;
    /* Eigenvalues [1/s] of the Jacobian, or multipliers without the trivial one of an autonomous
     * orbit. */
    int values; /* number of them; 0 if none could be computed */
    struct eigenvalue value[DYNAMICS_VARIABLES];
    int unstable;    /* number of values that grow */
    double noise;    /* multipliers smaller than this are below the rounding errors */
    double trivial;  /* |M f - f| / |f|, M the monodromy matrix, f the flow; NAN if there is none */
    double residual; /* largest residual of the equations, relative to natural sizes */
    double top[DYNAMICS_VARIABLES], bottom[DYNAMICS_VARIABLES]; /* extrema along the orbit */
};

/* Returns true if the stability is known. It is not for orbits on which the equations jump, which
 * have no multipliers. */
static inline bool solution_is_known(const struct solution *solution)
{
    return solution->kind == SOLUTION_EQUILIBRIUM || solution->values > 0 ||
           solution->trivial == solution->trivial;
}

/* Returns true if no eigenvalue or multiplier grows. */
static inline bool solution_stable(const struct solution *solution)
{
    return solution->unstable == 0;
}

#define SOLUTION_ONE 1e-5 /* distance from 1 below which a multiplier counts as 1 */
/* Returns the number of multipliers, besides the trivial one, that are 1: the orbit is a member of
 * a family or a fold. 0 for an equilibrium. */
int solution_ones(const struct solution *solution);

/* ---- equilibria ---- */

/* Type of an equilibrium by its eigenvalues; the first five in two variables. */
enum equilibrium_type {
    EQUILIBRIUM_STABLE_NODE,
    EQUILIBRIUM_STABLE_FOCUS,
    EQUILIBRIUM_UNSTABLE_NODE,
    EQUILIBRIUM_UNSTABLE_FOCUS,
    EQUILIBRIUM_SADDLE,
    EQUILIBRIUM_CENTRE,     /* Hamiltonian or reversible, as linear theory alone does not decide */
    EQUILIBRIUM_DEGENERATE, /* linear theory does not decide */
    EQUILIBRIUM_STABLE,     /* stable, with three variables or more */
    EQUILIBRIUM_UNSTABLE,
};

extern const struct catalog equilibrium_catalog; /* rows in the order of the enum */

/* Type, index and eigenvectors of an equilibrium. */
struct equilibrium_form {
    enum equilibrium_type type;
    int index; /* Poincare-Hopf index: the sign of det J, or 0 if unknown */
    /* [eigenvalue][n] Eigenvectors, real and imaginary part, of length 1 in SI units. The second
     * one of a conjugate pair is the conjugate. NAN marks a missing eigenvector. */
    double re[DYNAMICS_VARIABLES][DYNAMICS_VARIABLES], im[DYNAMICS_VARIABLES][DYNAMICS_VARIABLES];
};

/* A search for equilibria. */
struct equilibria_request {
    const struct scene *scene;
    double box[DYNAMICS_VARIABLES][2]; /* SI; lower and upper end of the region for each variable */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

/* Result of a search for equilibria, freed by equilibria_free(). */
struct equilibria {
    int count;
    struct solution *solution;     /* [count] in the order of the first variable */
    struct equilibrium_form *form; /* [count] */
    /* They are equilibria of the mean over the drive's period, at which the motion does not
     * rest. */
    bool forced;
    bool complete;    /* It is proven that the box holds no others. */
    char reason[192]; /* reason why it is not complete, with the place */
    int boxes;        /* number of boxes that were examined */
    double seconds;
};

/* Finds all equilibria in the box and tries to prove that there are no others. The two ends of an
 * angle whose range is one turn (2 pi) are the same point. Returns false with `error` filled if the
 * scene is refused or out of memory. */
bool equilibria_find(const struct equilibria_request *request, struct equilibria *found,
                     struct error *error);
void equilibria_free(struct equilibria *found);

/* ---- periodic orbits ---- */

/* A search for a periodic orbit. */
struct orbit_request {
    const struct scene *scene;
    double state[DYNAMICS_VARIABLES], t; /* SI; the search begins there, at this time [s] */
    double period;                       /* [s] approximate period; 0 takes it from the motion */
    double span;                         /* [s] length of motion that is examined first, > 0 */
    bool
        settles; /* the motion is followed until it settles, so that an attracting orbit is found */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* fraction is 0 if unknown; may be NULL */
    void *context;
};

/* Result of a search for an orbit, freed by orbit_free(). */
struct found_orbit {
    struct solution solution;
    bool family; /* True if a multiplier is 1, as in a family of orbits and at a fold. */
    /* [s] period of the orbit from which it was followed to this one, or 0 */
    double family_from;
    bool given_up; /* the orbit is unstable, and the search for a stable one was given up */
    double error;  /* error of states and period, relative to natural sizes; NAN for a family */
    /* Smallest distance from the requested state as a part of the extent, or NAN. */
    double away;      /* the extent is that of the orbit */
    double energy_in; /* [J] work of the drive over a period; NAN if there is no energy */
    int samples;      /* number of samples over one period */
    /* [samples][n + 1] time since the start [s], state; denser where the equations jump */
    double *sample;
    int64_t evals;
    double seconds;
};

/* Finds a periodic orbit near a state, or the one that the motion from there settles on. Shorter
 * periods are tried first; with a drive they are multiples of its period. Returns false with *error
 * if none is found, or if out of memory or cancelled; orbit_free() must be called in both cases. */
bool orbit_find(const struct orbit_request *request, struct found_orbit *found,
                struct error *error);
void orbit_free(struct found_orbit *found);

/* ---- branches ---- */

/* Kinds of special points of branches; comments give the labels. */
enum special {
    SPECIAL_NONE,
    SPECIAL_FOLD,     /* LP, where the branch turns back */
    SPECIAL_HOPF,     /* HB, where an orbit is born */
    SPECIAL_CROSSING, /* BP, where another branch crosses */
    SPECIAL_DOUBLING, /* PD, where an orbit of twice the period branches off */
    SPECIAL_TORUS,    /* NS: Neimark-Sacker */
    SPECIAL_END,      /* EP */
    /* The following occur on curves of special points in two parameters. */
    SPECIAL_CUSP,   /* CP, where two folds meet */
    SPECIAL_DOUBLE, /* BT: Bogdanov-Takens, two eigenvalues are 0 */
    SPECIAL_BAUTIN, /* GH, generalised Hopf, where the first Lyapunov coefficient is 0 */
    SPECIAL_COUNT
};

extern const struct catalog special_catalog; /* struct row: LP HB BP PD NS EP CP BT GH, from 1 on */

/* One point of a branch. */
struct branch_point {
    struct solution solution;
    enum special special;
    /* first Lyapunov coefficient of a Hopf point (Kuznetsov 2004, 5.62), else NAN */
    double criticality;
    double accuracy;                        /* relative accuracy of a special point's parameter */
    int verified;                           /* enum branch_verdict (branches/verdict.h) */
    double tangent[2 + DYNAMICS_VARIABLES]; /* direction of the branch there (private) */
};

/* Second parameter of a curve of special points: index in the scene and range. */
struct branch_axis {
    int param;
    double low, high; /* SI */
};

/* A branch that is to be followed. */
struct branch_request {
    const struct scene *scene;
    int param;        /* index of the scene's parameter that varies */
    double low, high; /* SI; its range */
    const struct solution *start;
    /* If not NULL, the start is this crossing, doubling or Hopf point, and the branch that leaves
     * its own one there is followed. */
    const struct branch_point *leave;
    /* If not NULL, the curve of points like `leave` (LP, HB, PD, NS) in both parameters is
     * followed. */
    const struct branch_axis *second;
    double step;  /* first step as a fraction of the range, or 0 to choose it */
    int max;      /* largest number of points in each direction; 0 stands for 1000 */
    bool forward; /* only in the direction in which the parameter grows at the start */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

/* A branch that was followed, freed by branch_free(). */
struct branch {
    enum solution_kind kind;
    int count;
    struct branch_point *point; /* [count] in the order along the branch */
    int64_t evals;
    double seconds;
    bool closed; /* the branch returns to where it began */
    bool cancelled;
    char ends[2][96]; /* reason why each end is where it is */
};

/* Follows a branch from its start in both directions and locates its special points. Returns false
 * with *error if no point was found: the start is no solution, or one of a family at one value, or
 * it was cancelled or out of memory. Otherwise a branch that was cancelled holds what was found so
 * far. */
bool branch_follow(const struct branch_request *request, struct branch *branch,
                   struct error *error);
/* Compares the special points with runs on both sides of them. If cancelled, the remaining ones are
 * unchanged. */
void branch_verify(const struct branch_request *request, struct branch *branch);
void branch_free(struct branch *branch);
