/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How motions that begin near each other go apart: Lyapunov exponents. */
#ifndef HOOKE_STUDY_CHAOS_H
#define HOOKE_STUDY_CHAOS_H

#include <hooke/study/dynamics.h>

/* ---- Lyapunov exponents ----
 *
 * Mean rates [1/s] at which tangents grow along a motion, by QR (Benettin, Galgani, Giorgilli,
 * Strelcyn 1980) of the variational equations, which are integrated in the same steps as the motion
 * (dop853, tolerance 1e-12). Means are over time, in bins of equal length; of a drive with a period
 * in bins that begin where it does.
 */
struct lyapunov_request {
    const struct scene *scene;
    int count;       /* of the largest, 0: all */
    double duration; /* [s] 0: about two million evaluations */
    double skip;     /* [s] before, -1: a tenth of the duration, or about as many evaluations */
    const struct cancel *cancel;
    void (*progress)(void *context, double fraction); /* NULL: nobody wants to know */
    void *context;
};

struct exponent {
    double value, error; /* [1/s] standard error, NAN: not determined */
};

struct lyapunov {
    int n, count;
    struct exponent exponent[DYNAMICS_VARIABLES]; /* falling */
    double sum;                /* [1/s] of these; all: the rate at which volumes grow, which is */
    double divergence;         /* [1/s] the mean of tr df/dy over the same time */
    struct exponent dimension; /* Kaplan, Yorke 1979; NAN: too few exponents were asked for */
    double time, skip;         /* [s] as they were */
    double period;             /* [s] of the drive; 0: autonomous; NAN: there is none */
    /* of the drive: largest difference [1/s] between exponents of the last periods by the flow and
     * by derivatives of the stroboscopic map; NAN: not compared */
    double strobe;
    bool determined;
    bool regular; /* not chaotic: means converge faster than any power of time */
    bool rests;   /* has come to rest: no exponent of a flow has to be 0 */
    bool conservative;
    int batches;
    double condition; /* largest of the tangents, between orthonormalisations */
    bool cancelled;
    const char *reason; /* why it is not determined, or ends early; NULL: it does not */
    int64_t evals;
    double seconds;
};

/* False: nothing can be said, and why; or out of memory. Cancelled: of the time so far. */
bool lyapunov_find(const struct lyapunov_request *request, struct lyapunov *found,
                   struct error *error);

#endif
