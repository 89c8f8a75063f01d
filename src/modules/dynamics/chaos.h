/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lyapunov exponents, which measure how fast neighbouring motions separate, and basins of
 * attraction, the sets of starts that end in the same attractor. */
#pragma once

#include "modules/dynamics/dynamics.h"
#include <hooke/run/attractor.h>

/* ---- Lyapunov exponents ----
 *
 * Mean rates [1/s] at which tangents grow along a motion, by QR (Benettin, Galgani, Giorgilli,
 * Strelcyn 1980) of the variational equations, which are integrated in the same steps as the motion
 * (dop853, tolerance 1e-12). Means are over time, in bins of equal length; of a drive with a period
 * in bins that begin where it does.
 */
struct lyapunov_request {
    const struct scene *scene;
    int count;       /* number of largest exponents, or 0 for all */
    double duration; /* [s] 0: about two million evaluations */
    double skip; /* [s] before, or -1 for a tenth of the duration or about as many evaluations */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

struct exponent {
    double value, error; /* [1/s] standard error, or NAN if not determined */
};

struct lyapunov {
    int n, count;
    struct exponent exponent[DYNAMICS_VARIABLES]; /* [1/s] the largest first */
    double sum; /* [1/s] sum of the exponents; that of all n is the growth rate of volumes */
    /* [1/s] mean of tr df/dy over the same time, equal to the sum of all n exponents */
    double divergence;
    /* Kaplan and Yorke 1979; NAN if too few exponents were requested */
    struct exponent dimension;
    double time, skip; /* [s] averaged, and skipped before */
    double period;     /* [s] of the drive; 0 if autonomous, NAN if it has no period */
    /* [1/s] For a driven scene, the largest difference between the exponents of the last periods by
     * the flow and by derivatives of the stroboscopic map, or NAN if not compared. */
    double strobe;
    bool determined;
    bool regular; /* Not chaotic: means converge faster than any power of the time. */
    bool rests;   /* The motion has come to rest, so that no exponent of the flow has to be 0. */
    bool conservative;
    int batches;
    double condition; /* largest condition number of the tangents between orthonormalisations */
    bool cancelled;
    const char *reason; /* reason why it is not determined or ends early, or NULL */
    int64_t evals;
    const char *method; /* method by which the motion and its tangents were solved */
    double tol;         /* its tolerance */
    double seconds;
};

/* Returns false with the reason if no result is possible or if out of memory. If cancelled, results
 * are those of the time so far. */
bool lyapunov_find(const struct lyapunov_request *request, struct lyapunov *found,
                   struct error *error);

/* ---- basins of attraction ----
 *
 * Where motions end that begin on a grid of two variables, the others at the scene's start. They
 * are looked at once a period of the drive, else once a time that is natural to the scene. What
 * they end in is found by itself: a state or a few that come again, a closed orbit, or, of up to
 * three variables, a region that is not left. Steps are those of rk4, side by side in lanes where
 * that can be.
 */
#define BASINS_MOST 26

enum { BASIN_ESCAPES = -1, BASIN_UNDECIDED = -2, BASIN_MISSING = -3 };

struct basins_request {
    const struct scene *scene;
    struct {
        int variable;
        double low, high; /* SI */
        int count;
    } axis[2];
    int threads; /* 0 uses all processors */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* may be NULL */
    void *context;
};

struct basins {
    int count;
    struct basin basin[BASINS_MOST]; /* the largest first */
    int64_t total, finished, escaping, undecided;
    /* [total] index in `basin`, or one of the values above; the second axis varies fastest */
    signed char *fate;
    double strobe; /* [s] between looks */
    int steps;     /* steps of a look; 0 if they adapt and starts go alone */
    int64_t looks; /* looks at all starts together */
    int threads;
    double seconds;
    bool cancelled;
};

/* Returns false if there are no such basins or if out of memory. If cancelled, it holds what is
 * finished. basins_free() must be called after both. */
bool basins_find(const struct basins_request *request, struct basins *basins, struct error *error);
void basins_free(struct basins *basins);
/* The value of an axis at its place. */
double basins_value(const struct basins_request *request, int axis, int64_t place);
/* Returns one standard error of the share count/total, as if the starts were drawn at random. */
double basins_error(int64_t count, int64_t total);

/* Finds what the motion from the scene's own start ends in: a find_attractor. */
double attractor_of(const struct scene *scene, const struct cancel *cancel, struct basin *basin);
