/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * study: reports that run many. Here: several methods and step sizes on one scene, with error, energy, cost and honest
 * times.
 */
#ifndef HOOKE_STUDY_H
#define HOOKE_STUDY_H

#include <hooke/figure.h>

/* ---- timing: how long a solve takes, nothing recorded ----
 *
 * Repeats are chained through the data (a start that depends on the last result), batched until a sample is long enough
 * for the clock, and reported as minimum and median. One warm-up solve is discarded. Nothing is allocated or written in
 * the timed region.
 */

enum timing { TIMING_OFF, TIMING_QUICK /* about 2 ms a point */, TIMING_FULL /* NUMERICS: >= 15 samples of >= 1 ms */ };

extern const struct catalog timing_catalog; /* struct row at the enum's place: off, quick, full */

struct timing_result {
    double minimum, median; /* [s] for one solve; NAN: not timed */
    double spread;          /* median absolute deviation / median */
    int samples;
};

/* tol > 0: adaptive. Solves from system->t0 over `span`. */
void time_solve(const struct system *system, const struct method *method, const struct run_settings *settings,
                double span, enum timing timing, const struct cancel *cancel, struct timing_result *result);

/* ---- compare ---- */

struct contender {
    const struct method *method;
    enum drag drag; /* DRAG_DEFAULT: the method's own */
};

struct compare_request {
    const struct scene *scene;
    const struct contender *contender;
    int contenders;
    const double *dt; /* [s] [dts]; with tol[] given: first guesses, one is enough */
    int dts;
    const double *tol; /* [tols] adaptive where the method can; fixed-step methods use dt */
    int tols;
    double duration; /* [s] */
    struct recording_rule record;
    enum timing timing;
    const struct cancel *cancel;
};

struct comparison {           /* one method at one setting */
    struct run *run;          /* owned by the caller after study_compare */
    struct run_errors errors; /* against the exact solution, NAN where none is known */
    struct ledger ledger;
    double order;         /* log(error ratio)/log(dt ratio) to the row before of the same method, NAN for the first */
    double energy_factor; /* E/E0 at the end */
    double predicted_factor; /* what the method's amplification matrix says of E/E0; NAN where it does not apply */
    struct timing_result time;
    char verdict[200]; /* in words: "energy x 1.76e+03 in 10 s, as predicted: 1.0075 a step" */
};

/* Steps and computing time [s] that all of it will take; false where study_compare would refuse. */
bool study_compare_plan(const struct compare_request *request, double *steps, double *seconds, struct error *error);
/*
 * Runs every contender at every setting, in order. rows has room for contenders * max(dts, 1) (or tols); *count says
 * how many were finished. A method that does not apply to the scene, or a setting that is refused, is an error before
 * anything runs. A diverged run is a result. False also when cancelled: the finished rows are kept and *count > 0.
 */
bool study_compare(const struct compare_request *request, struct comparison *rows, int *count, struct error *error);
void comparison_free(struct comparison *row); /* destroys the run if it is still there */

#endif
