/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lyapunov exponents, which measure how fast neighbouring motions separate, and basins of
 * attraction, the sets of starts that end in the same attractor. */
#pragma once

#include "modules/dynamics/dynamics.h"
#include <hooke/run/attractor.h>

/* ---- Lyapunov exponents ----  Mean rates [1/s] at which tangents grow along a motion, by QR
 * (Benettin, Galgani, Giorgilli, Strelcyn 1980) of the variational equations, which are integrated
 * in the same steps as the motion (dop853, tolerance 1e-12). Means are over time, in bins of equal
 * length; of a drive with a period in bins that begin where it does. */
struct lyapunov_request {
    const struct scene *scene;
    int count;       /* number of exponents, the largest ones, or 0 for all */
    double duration; /* [s] time to average over, or 0 for about two million evaluations */
    double skip;     /* [s] time before that, or -1 for a tenth of it */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

/* One exponent with its error. */
struct exponent {
    double value, error; /* [1/s] standard error, or NAN if not determined */
};

/* The exponents of a motion. */
struct lyapunov {
    int n, count;
    struct exponent exponent[DYNAMICS_VARIABLES]; /* [1/s] the largest first */
    double sum; /* [1/s] sum of the exponents; that of all n is the growth rate of volumes */
    /* [1/s] mean of tr df/dy over the same time, equal to the sum of all n exponents */
    double divergence;
    /* Kaplan and Yorke 1979; NAN if too few exponents were requested */
    struct exponent dimension;
    double time, skip; /* [s] time that was averaged over, and time before it */
    double period;     /* [s] period of the drive; 0 if autonomous, NAN if it has no period */
    /* [1/s] For a driven scene, the largest difference between the exponents of the last periods by
     * the flow and by derivatives of the stroboscopic map, or NAN if not compared. */
    double strobe;
    bool determined; /* false if no mean has converged; `reason` tells why */
    bool regular;    /* not chaotic: means converge faster than any power of the time */
    bool rests;      /* the motion has come to rest, so that no exponent of the flow has to be 0 */
    bool conservative; /* energy is conserved: exponents come in pairs of opposite sign */
    int batches;       /* number of bins that the errors are estimated from */
    double condition;  /* largest condition number of the tangents between orthonormalisations */
    bool cancelled;
    const char *reason; /* reason why it is not determined or ends early, or NULL */
    int64_t evals;
    const char *method; /* method by which the motion and its tangents were solved */
    double tol;         /* its tolerance */
    double seconds;
};

/* Computes the exponents of the motion from the scene's start. Returns false with *error if no
 * result is possible or if out of memory. If cancelled, results are those of the time so far. */
bool lyapunov_find(const struct lyapunov_request *request, struct lyapunov *found,
                   struct error *error);

/* ---- basins of attraction ----  Motions begin on a grid of two variables, the others at the
 * scene's start. Their states are checked once per period of the drive, else once per natural time
 * of the scene, until each is on an attractor. Attractors need not be given; they are recognized: a
 * state or a few states that recur, a closed orbit, or, with up to three variables, a region that
 * is not left. Steps are those of rk4, with several motions at once in the lanes of vector
 * instructions where possible. */
#define BASINS_MOST 26 /* largest number of attractors: each has a letter */

/* Fates of starts that reach no attractor; missing ones were not finished. */
enum { BASIN_ESCAPES = -1, BASIN_UNDECIDED = -2, BASIN_MISSING = -3 };

/* The grid of starts. */
struct basins_request {
    const struct scene *scene;
    struct {
        int variable;
        double low, high; /* SI */
        int count;        /* number of starts along it, including both ends */
    } axis[2];
    int threads; /* 0 uses all processors */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

/* Attractors and the fate of each start. */
struct basins {
    int count;
    struct basin basin[BASINS_MOST];              /* the largest first */
    int64_t total, finished, escaping, undecided; /* numbers of starts */
    /* [total] index in `basin`, or one of the values above; the second axis varies fastest */
    signed char *fate;
    double strobe; /* [s] time between two checks of a motion */
    int steps; /* number of steps between two checks, or 0 if steps are adaptive, one start each */
    int64_t checks; /* number of checks of all starts together */
    int threads;    /* number of threads that were used */
    double seconds;
    bool cancelled;
};

/* Finds the basins. Returns false with *error if the scene has none or if out of memory. If
 * cancelled, *basins holds what is finished. basins_free() must be called in all cases. */
bool basins_find(const struct basins_request *request, struct basins *basins, struct error *error);
void basins_free(struct basins *basins);
/* Returns the value of an axis at the index `place`. */
double basins_value(const struct basins_request *request, int axis, int64_t place);
/* Returns one standard error of the share count/total, as if the starts were drawn at random. */
double basins_error(int64_t count, int64_t total);

/* Finds what the motion from the scene's own start ends in. It is a find_attractor
 * (hooke/run/attractor.h), which `sweep measure=attractor` calls. */
double attractor_of(const struct scene *scene, const struct cancel *cancel, struct basin *basin);
