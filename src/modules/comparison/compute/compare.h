/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Studies that compare methods: how long solves take, references that errors are measured against,
 * precision (error against time), compare (a few runs), order (slope of the errors) and selftest.
 * Each study is one call with a request; what it fills in is freed by the function beside it. */
#pragma once

#include <hooke/figure.h>
#include <hooke/result.h>
#include <hooke/run.h>
#include "modules/comparison/compute/solve_timing.h"
#include "modules/solving/compute/solve.h"
#include <hooke/run/timing.h>

struct cancel;
struct catalog;

/* ---- reference: what errors are measured against ----
 *
 * On a common grid of 257 times, so that a coarse method is not sampled kindly: the closed form
 * where one is known, else the same problem solved by two methods of different kinds (explicit,
 * splitting, implicit, Rosenbrock), with compensated sums. What they agree to is the accuracy, and
 * nothing below it is claimed; a contestant at a tighter tolerance alone would be no reference.
 * Distances are those of the positions (of all variables in a first-order scene), each divided by
 * its amplitude, the largest |y_i| on the grid.
 */

/* A reference solution and how far it can be trusted. */
struct reference {
    double *y;     /* [STUDY_TIMES][n] states on the grid, owned; release with reference_free() */
    int n, scored; /* number of variables, and of the first of them that errors are measured in */
    double span;   /* [s] */
    double amplitude[LIMIT_VARIABLES]; /* > 0 */
    bool exact;                        /* y is the closed form */
    /* unless exact, the method that made y and the one that confirmed it */
    const struct method *method[2];
    /* distance between both, or the uncertainty that rounding leaves in the closed form
     * [amplitudes] */
    double accuracy;
    /* end of the solution, if that is why there is no reference; t is NAN otherwise */
    struct singularity singular;
    /* [s] time after t0 from which the two methods differ by more than 1e-3, or span if they never
     * do */
    double meaning;
    bool sudden; /* they separate by a jump from one grid time to the next, not as rounding grows */
    /* [s] duration of the shortest burst of the forces that steps were fitted to, 0 if there was
     * none */
    double shortest;
    double bound; /* [s] longest step of all methods but the first */
    bool again;   /* computed by references_again(), because runs with finer steps disagreed */
    /* Two methods whose finest runs agree with each other and not with the reference, which is then
     * doubtful, or NULL. */
    const struct method *dissenting_method[2];
    double apart; /* [amplitudes] distance of their runs from the reference */
    bool stored;  /* taken from an earlier study of the same scene */
};

/* Computes a reference at bounded cost (up to about 4e7 evaluations per solution), to be freed by
 * reference_free(). Returns false with an error, and nothing to free, if no two methods of
 * different kinds reach the end, if out of memory, or if cancelled. If the solution itself ends
 * early, reference->singular tells when. */
bool study_reference(const struct system *system, double span, const struct cancel *cancel,
                     struct reference *reference, struct error *error);
/* Does the same as study_reference() with steps of at most `step` [s] in all methods. */
bool study_reference_again(const struct system *system, double span, double step,
                           const struct cancel *cancel, struct reference *reference,
                           struct error *error);
/* Frees the states and sets them to NULL. */
void reference_free(struct reference *reference);
/* Appends what the reference is and how accurate, as in "dop853 and gauss6, which agree to 1e-12",
 * with its doubts. */
void reference_describe(const struct reference *reference, struct buffer *text);

/* The references of the REFERENCES_STORED scenes that were studied last, so that the next study of
 * one of them need not compute it; it is also stored that a scene has none. Zeroed at first,
 * released with references_free(). Entries are valid as long as the typed models of their
 * scenes. */
#define REFERENCES_STORED 4

struct references {
    struct stored_reference {
        struct scene scene;
        double span; /* [s] */
        struct reference reference;
        struct error why; /* reason why there is none; y is then NULL */
        uint64_t used;    /* number of the latest use, or 0 if nothing is stored here */
    } stored[REFERENCES_STORED];
    uint64_t uses; /* number of uses so far */
};

/* Gets the stored reference of the scene, which is bound to `system`, or computes it by
 * study_reference() and stores it. A scene with any other parameter, initial value, tolerance or
 * span is another one. *reference is the caller's copy to free. With references NULL nothing is
 * stored. Returns false with an error as study_reference() does. */
bool references_get(struct references *references, const struct scene *scene,
                    const struct system *system, double span, const struct cancel *cancel,
                    struct reference *reference, struct error *error);
/* Computes a reference again that runs with smaller errors disagreed with, and replaces *reference
 * and its stored copy. Steps are at most `step` [s], and at most half as long as before. Returns
 * false if that fails (ERROR_NUMERICAL) or if cancelled; *reference is then unchanged. */
bool references_again(struct references *references, const struct scene *scene,
                      const struct system *system, double span, double step,
                      const struct cancel *cancel, struct reference *reference,
                      struct error *error);
/* Returns the stored reference of the scene, or NULL if none is stored or there is none. */
const struct reference *references_find(struct references *references, const struct scene *scene,
                                        double span);
/* Frees all stored references and zeroes the structure. */
void references_free(struct references *references);

/* Errors of a solve against the reference, in amplitudes unless another unit is given. */
struct study_errors {
    double end, max; /* error at the end, and the largest on the grid */
    /* largest |E - E_reference| / largest |E_reference|; NAN for first-order scenes */
    double energy;
    /* [rad] and relative, at the end; NAN unless it is a linear oscillator */
    double phase, amplitude;
};

/* ---- precision: error against run time ---- */

/* A method with a variant of its treatment of drag. */
struct method_choice {
    const struct method *method;
    enum drag drag; /* DRAG_DEFAULT selects the method's own */
};

/* Returns the name of the drag variant, or NULL for the method's own. */
const char *contender_drag(const struct method_choice *choice);

/* Input of study_precision(). Pointers are the caller's. */
struct precision_request {
    const struct scene *scene;
    const struct method_choice *choice;
    int choices;
    /* [s] ends of the sweep of fixed steps, in any order, or NAN to choose them. If given without
     * tol, methods that adapt take fixed steps, too. */
    double dt[2];
    double tol[2];    /* ends of the sweep of methods that adapt, or NAN to choose them */
    double duration;  /* [s] */
    bool compensated; /* sums of fixed steps */
    enum timing timing;
    double seconds; /* [s] approximate time of everything but the reference, or 0 to choose it */
    bool recording; /* time a run that records, too */
    struct references *references; /* kept between studies, or NULL */
    const struct cancel *cancel;
};

/* One setting of one method: a step or tolerance, what its solve cost, and its errors. */
struct precision_point {
    int curve;      /* index in precision.curve */
    double dt, tol; /* dt = duration / 2^k [s], tol = 0; an adaptive solve has tol > 0, dt = 0 */
    int64_t steps;
    struct cost cost;
    enum stop stop; /* reason for the end of the solve */
    bool refused;   /* the method takes no steps of this size here */
    struct study_errors errors;
    /* error 1 was exceeded already in the 1/256 of the time in which the motion is fastest, and
     * only that was solved: steps, cost and error are of that part */
    bool probed;
    /* [s] processor time of the first solve, from which errors were computed */
    double seconds;
    /* fraction of the duration that was solved, below 1 if it was given up or probed */
    double part;
    bool costly; /* so expensive that the first solve counts as its time and is not repeated */
    /* Number of timed steps if the time was scaled from a part of the solve, or 0. */
    int64_t timed_steps;
    /* log(error ratio)/log(dt or tol ratio) to the point before, NAN if there is none */
    double order;
    bool is_below_reference; /* the error is below the accuracy of the reference */
    bool asymptotic;         /* takes part in the fit of the slope */
    enum kernel path;        /* as study_path() */
    struct timing_result time;
    /* [s] time of a run that records every step, the shortest of three, or NAN if not asked for. */
    double recording;
};

/* One method: its points from coarse to fine, and the line through the asymptotic ones. */
struct precision_curve {
    struct method_choice choice;
    bool adaptive;    /* swept over tolerances, not steps */
    int first, count; /* range of its points in precision.point */
    /* slope of log error over log dt (or log tol), or NAN for fewer than three points */
    double slope, r2;
    int fitted; /* number of points in the fit of the slope, or 0 */
    /* Expected slope: the order, or 1 for tol (error proportional to tolerance), or NAN for exact
     * methods. */
    double expected;
    /* slope differs from what is expected by more than PRECISION_SLOPE (by expected/20 for orders
     * above 6) */
    bool differs;
    /* the sweep ended because its share of the time was used up, not by rounding or cost */
    bool cut;
};

/* Largest difference of a measured slope from the expected one that is not reported. */
#define PRECISION_SLOPE 0.3

/* Result of study_precision(). Release with precision_free(). */
struct precision {
    struct scene scene;
    struct system system; /* that scene with its parameters bound */
    struct reference reference;
    double duration;               /* [s] */
    bool compensated;              /* sums of fixed steps */
    struct precision_point *point; /* [points] owned, those of a curve together */
    int points;
    struct precision_curve *curve; /* [choices] owned, of which `curves` are finished */
    int curves;                    /* finished */
    bool by_evals;                 /* draw evaluations instead of times; set by the caller */
};

/* Sweeps each choice from coarse steps to the floor of rounding (or the ends given), measures the
 * errors, then times all points together. Failed settings are points, too; of several in a row only
 * the last is kept. Returns false with an error before anything runs if a choice does not apply to
 * the scene; also if cancelled: finished curves are kept (curves > 0), times may be missing. Call
 * precision_free() in every case. */
bool study_precision(const struct precision_request *request, struct precision *precision,
                     struct error *error);
/* Frees everything that the study owns and zeroes it. */
void precision_free(struct precision *precision);

/* A point with its curve and study: a row of the table of results. */
struct precision_row {
    struct precision_point point;
    struct precision_curve curve;
    double accuracy; /* accuracy of the reference */
    bool stored;     /* the reference was computed by an earlier study */
    bool resolved;   /* the reference is not contradicted by the finest runs of two methods */
    const struct precision *precision;
};

/* Makes a row for each point, in the arena; they are valid as long as `precision`. Returns NULL if
 * out of memory. */
const struct precision_row *precision_rows(const struct precision *precision, struct arena *arena);
extern const struct result_columns precision_columns; /* columns of struct precision_row */

/* Returns true if the point's solve reached the end with an error below 1, so that the error means
 * something. */
bool precision_meaningful(const struct precision_point *point);
/* Returns why a point has no meaningful error ("lost", "too long", "diverged", ..), or "" if it has
 * one. Tables, records and the diagram use this word. */
const char *precision_failure(const struct precision *precision,
                              const struct precision_point *point);

/* Cost of an error, read off a curve between its points (straight lines in logarithms). */
struct precision_cost {
    int curve;
    enum kernel path;
    double evals, minimum, median; /* [s], NAN without times */
    bool timed;                    /* true if the times are reliable */
    /* Its minimum is inside of [minimum, median] of the fastest, or within PRECISION_TIE of its
     * minimum. */
    bool tied;
};

/* Times whose ratio is at most this tie: minima of the same solve differ so much between
 * processes. */
#define PRECISION_TIE 1.05

/* Computes what an error costs with one method. Returns false if no point of the curve reaches it,
 * or if it is below the accuracy of the reference. */
bool precision_cost_at(const struct precision *precision, int curve, double error,
                       struct precision_cost *cost);
/*
 * Lists the curves that reach this error, the fastest first (by evaluations if there are no times).
 * Returns the number of ranked ones. Those with general code that are not faster than all
 * specialised ones follow, *others of them: specialised code might bring them anywhere ahead. (A
 * faster one keeps its rank, because it could only gain.) costs has [curves]; others may be NULL.
 */
int precision_fastest(const struct precision *precision, double error, struct precision_cost *costs,
                      int *others);

/*
 * Returns the number of force evaluations that an error needs on an undamped linear oscillator,
 * predicted from the method's amplification matrix: phase, amplitude and shape of M^n against the
 * rotation. Returns NAN for another scene, adaptive steps, or a method without such
 * a matrix.
 */
double precision_predict(const struct precision *precision, int curve, double error);
/* Returns true for an undamped, undriven linear oscillator, for which precision_predict() works. */
bool precision_predicts(const struct system *system);

/* Returns true if the Jacobian at the start times the duration [s] is so large that explicit
 * methods choose their steps for stability alone. */
bool precision_is_stiff(const struct system *system, double duration);
/* Chooses up to PRECISION_DEFAULTS methods that apply to the system, by its stiffness, and returns
 * their number. absent() is called, unless NULL, for each other candidate, with the reason. */
#define PRECISION_DEFAULTS 12
int precision_defaults(const struct system *system, double duration, struct method_choice *choice,
                       void (*absent)(void *context, const char *method, const char *reason),
                       void *context);

/* ---- compare ---- */

/* Input of study_compare(). Pointers are the caller's. */
struct compare_request {
    const struct scene *scene;
    const struct method_choice *choice;
    int choices;
    const double *dt; /* [s] [dts]; with tol[] given: first guesses, one is enough */
    int dts;
    const double *tol; /* [tols] adaptive where the method can; fixed-step methods use dt */
    int tols;
    double first;     /* [s] first step of methods that adapt, or 0 for dt[0] */
    double duration;  /* [s] */
    bool compensated; /* sums of fixed steps */
    struct recording_rule record;
    enum timing timing;
    struct references *references; /* kept between studies, or NULL */
    const struct cancel *cancel;
};

/* One method at one setting: a run and what was measured of it. */
struct comparison {  /* one method at one setting */
    struct run *run; /* created by study_compare(), owned by the caller */
    /* Errors against the closed form; where there is none, end, max and floor are against the
     * reference. */
    struct run_errors errors;
    double duration; /* [s] asked for */
    const struct method
        *reference[2]; /* methods of that reference, or NULL if it is not needed or there is none */
    bool reference_stored; /* the reference was computed by an earlier study */
    struct ledger ledger;  /* energy balance at the end */
    /* log(error ratio)/log(dt ratio) to the row before of the same method, NAN for the first */
    double order;
    double energy_factor; /* E/E0 at the end */
    /* E/E0 predicted by the method's amplification matrix, or NAN if that does not apply. */
    double predicted_factor;
    /* The method's matrix predicts that the amplitude grows where the solution does not, or that
     * less than a tenth of its energy remains. */
    bool grows, shrinks;
    enum kernel path; /* as study_path() */
    struct timing_result time;
    /* the result in words, as "energy x 1.76e+03 in 10 s, as predicted: 1.0075 a step" */
    char verdict[200];
};

/* Predicts the number of steps and the computing time [s] of all runs with fixed steps; those of
 * adaptive ones are unknown and left out. Returns false with an error where study_compare() would
 * refuse to run. */
bool study_compare_plan(const struct compare_request *request, double *steps, double *seconds,
                        struct error *error);
/* Runs every choice at every setting, in order, into rows [*count], which has room for choices *
 * max(dts, 1), or choices * tols. Returns false with an error before anything runs if a method does
 * not apply or a setting is invalid; also if cancelled: finished rows are kept and *count > 0. A
 * diverged run is a result. */
bool study_compare(const struct compare_request *request, struct comparison *rows, int *count,
                   struct error *error);
/* Destroys the run, if it is still there. */
void comparison_free(struct comparison *row); /* destroys the run if it is still there */

/* A comparison as a row of a table, which outlives the run. */
struct compared_row {
    struct comparison comparison; /* its run NULL */
    const struct method *method;
    double dt, tol; /* [s] and a number; the one that is not used is NAN */
    int64_t steps;
    struct cost cost;
    enum stop stop;
    int number;                         /* number of the run */
    struct measured period;             /* [s] NAN if there is none, or it was not measured */
    double data_rms;                    /* distance from a recording, or NAN if there is none */
    enum quantity data_quantity;        /* quantity of the recording */
    char data_heading[LIMIT_NAME + 16]; /* "rms(y-data)", or empty without a recording */
    bool too_long;                      /* it was not run, the steps are those that it would take */
    bool mixed;                         /* the rows are not all timed by the same code */
    bool balanced; /* drag or a drive changes the energy, so that its error is one of the balance */
};

/* Fills in a row from a finished comparison. Period, data and `mixed` remain to be filled in. */
void compared_init(struct compared_row *row, const struct comparison *comparison);
/* Makes the row of a method that was not run because it would take `seconds` [s]. */
void compared_too_long(struct compared_row *row, const struct method_choice *choice, double dt,
                       double steps, double seconds);
/* Appends the step or tolerance, as in "10 ms" or "tol 1e-06". */
void compared_setting(const struct compared_row *row, struct buffer *text);
extern const struct result_columns compared_columns; /* columns of struct compared_row */

/* ---- order: how fast the error falls with the step ----
 *
 * Fixed steps of duration/N with compensated sums, errors of the whole state at the end. The order
 * is the slope over the asymptotic part: below the errors that are too large to say anything, above
 * rounding and the accuracy of the reference; there the finest few points whose local slopes agree.
 */

/* Input of study_order(). Pointers are the caller's. */
struct order_request {
    const struct scene *scene;
    struct method_choice choice;
    double dt[2];                  /* [s] ends of the sweep, or NAN to choose them */
    double duration;               /* [s] */
    struct references *references; /* kept between studies, or NULL */
    const struct cancel *cancel;
};

/* One step size of the sweep. */
struct order_point {
    double dt; /* [s] */
    int64_t steps;
    enum stop stop;
    bool refused; /* the method takes no steps of this size here */
    /* Largest error of a variable in units of its amplitude, or NAN if it did not reach the end. */
    double error;
    double slope;  /* slope to the point before, or NAN */
    int64_t turns; /* extra steps that end at turning points */
    bool fitted;   /* the line is fitted to it */
};

#define ORDER_POINTS 64
#define ORDER_BAND 0.05 /* a slope that close to the claim agrees with it */

/* Comparison of the fitted slope with the claimed order; the catalog explains each. */
enum order_verdict {
    ORDER_AGREES,
    ORDER_LOWER,
    ORDER_HIGHER,
    ORDER_ERRATIC,
    ORDER_NO_RANGE,
    ORDER_EXACT
};

extern const struct catalog order_verdict_catalog; /* struct row at the enum's place */

/* A measured order with its sweep. */
struct order {
    struct method_choice choice;
    int claimed; /* order that the row claims; explicit drag claims 1 on a scene with drag */
    /* `guard` is the reach of local slopes and of the line's own uncertainty, or NAN without a
     * range. */
    double slope, guard, r2;
    struct order_point point[ORDER_POINTS];
    int points, fitted;    /* number of points, and of those in the fit */
    double floor;          /* accuracy of the reference: smaller errors mean nothing */
    bool reference_stored; /* the reference was computed by an earlier study */
    enum order_verdict verdict;
    bool switches;   /* the forces have switches other than dry friction */
    bool unsettled;  /* there are points to fit, but their slopes have not reached one value */
    char words[300]; /* reason why the scene spoils the order, or "" */
};

/* A point with what it belongs to: a row of the study's table. */
struct order_row {
    struct order_point point; /* comes first: columns of a point are those of a row, too */
    const struct method *method;
    double order; /* slope of the fitted line; NAN if no line was fitted */
    double line;  /* error on that line at dt; NAN beside the fitted points */
};

/* Fills in a row for each point and returns their number; rows has room for ORDER_POINTS. */
size_t order_rows(const struct order *order, struct order_row *rows);

/* Columns of struct order, struct order_point and struct order_row. */
extern const struct result_columns order_columns, order_point_columns, order_row_columns;

/* Measures the order. Returns false if the method does not apply, if there is no reference, or if
 * cancelled; finished points are kept (points > 0). */
bool study_order(const struct order_request *request, struct order *order, struct error *error);

/* ---- selftest: what the rows claim, measured on this machine ---- */

/* Checks of a method's row; the catalog explains each. */
enum selftest_check {
    SELFTEST_ORDER,
    SELFTEST_AREA,
    SELFTEST_REVERSAL,
    SELFTEST_STABILITY,
    SELFTEST_CHECKS
};

extern const struct catalog selftest_catalog;

/* Result of one check. */
struct selftest_result {
    bool applies, passed; /* the method claims the property, and has it */
    /* order, area factor - 1, distance from the start, or growth around the limit, and what was
     * claimed; NAN where the check has no such number */
    double value, wanted;
};

/* The checks of one method. */
struct selftest_row {
    const struct method *method;
    struct selftest_result check[SELFTEST_CHECKS];
    bool passed;
};

/* Checks the claims of one method's row. Returns false if out of memory or cancelled. */
bool selftest_method(const struct method *method, const struct cancel *cancel,
                     struct selftest_row *row);
