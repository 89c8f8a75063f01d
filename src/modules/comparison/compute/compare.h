/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Methods compared: timing, references, precision, order, selftest. */
#pragma once

#include <hooke/figure.h>
#include <hooke/result.h>
#include <hooke/run.h>
#include "modules/solving/compute/solve.h"
#include <hooke/run/timing.h>

struct cancel;
struct catalog;

/* ---- timing: how long a solve takes, nothing recorded ----
 *
 * Repeats are chained through the data (a start that depends on the last result), batched until a
 * sample is long enough for the clock, and reported as minimum and median. One warm-up solve is
 * discarded. Nothing is allocated or written in the timed region.
 */

#define TIMING_SAMPLES 15

/* Processor time of one solve, in seconds; NAN if it was not timed. */
struct timing_result {
    double minimum, median;
    double spread; /* relative difference of the second shortest sample from the shortest */
    /* Mean number of other threads that ran meanwhile. Where some did, the time may be up to
     * TIMING_CONTENTION times too long: processors share units, caches and memory. */
    double others;
    int samples;
    bool few; /* fewer samples than asked for */
};

#define TIMING_SPREAD 0.1 /* spread above which a time is flagged and not ranked */

/* Fewest samples that show whether a time is sound. */
enum { TIMING_SAMPLES_MIN = 3 };

/* Largest factor by which other threads may change a time, and the mean number of them that is
 * negligible. */
#define TIMING_CONTENTION 2.2
#define TIMING_OTHERS 0.25

/* Adds a line that says how busy the machine was, if it was. */
void timing_put_machine(double others, struct buffer *text);

/* Returns true if at least three samples were taken and the two shortest agree. */
bool timing_is_sound(const struct timing_result *time);

/* Returns the shortest time per step [ns], or NAN if it was not timed. */
double timing_step_ns(const struct timing_result *time, int64_t steps);

/* ---- reference: what errors are measured against ----
 *
 * On a common grid of 257 times, so that a coarse method is not sampled kindly: the closed form
 * where one is known, else the same problem solved by two methods of different kinds (explicit,
 * splitting, implicit, Rosenbrock), with compensated sums. What they agree to is the accuracy, and
 * nothing below it is claimed; a contestant at a tighter tolerance alone would be no reference.
 * Distances are those of the positions (of all variables in a first-order scene), each divided by
 * its amplitude, the largest |y_i| on the grid.
 */

struct reference {
    double *y; /* [STUDY_TIMES][n], owned; release with reference_free() */
    int n, scored;
    double span;                       /* [s] */
    double amplitude[LIMIT_VARIABLES]; /* > 0 */
    bool exact;
    const struct method *method[2]; /* unless exact: the solution, and what confirmed it */
    double accuracy; /* distance between both, or the conditioning floor of the closed form */
    struct singularity singular; /* the end of the solution, if that is why there is no reference */
    /* [s] time after t0 from which the two methods differ by more than 1e-3, or span if they
     * do not */
    double meaning;
    bool sudden; /* they separate within 1/256 of the span, not as rounding grows */
    /* [s] the shortest stretch that its steps had to be cut for, 0 if there is none */
    double shortest;
    double bound; /* [s] longest step, except of one of the two methods */
    bool again;   /* computed again, in shorter steps, because finer runs disagreed with it */
    /* Methods whose finest runs agree with each other and not with the reference, so that it is not
     * resolved, or NULL. */
    const struct method *dissenting_method[2];
    double apart; /* [amplitudes] their distance from it */
    bool stored;  /* computed by an earlier study of the same scene */
};

/* Computes a reference at bounded cost (up to about 4e7 evaluations per solution). Returns false if
 * cancelled, or if no two methods agree or reach the end; reference->singular then tells why. */
bool study_reference(const struct system *system, double span, const struct cancel *cancel,
                     struct reference *reference, struct error *error);
/* Does the same as study_reference() with steps of any method of at most `step` [s]. */
bool study_reference_again(const struct system *system, double span, double step,
                           const struct cancel *cancel, struct reference *reference,
                           struct error *error);
void reference_free(struct reference *reference);
/* Appends "dop853 and gauss6, which agree …". */
void reference_describe(const struct reference *reference, struct buffer *text);

/*
 * References of the scenes that were studied last, so that the next study of one of them does not
 * compute it again; also that there is none. Owned by the caller, zeroed at first,
 * references_free(). They hold as long as the typed models that they are of.
 */
#define REFERENCES_STORED 4

struct references {
    struct stored_reference {
        struct scene scene;
        double span; /* [s] */
        struct reference reference;
        struct error why; /* reason why there is none; y is then NULL */
        uint64_t used;    /* number of the latest use, or 0 if nothing is stored here */
    } stored[REFERENCES_STORED];
    uint64_t uses;
};

/*
 * As study_reference() of the scene bound to `system`, which keeps it there: any other value of a
 * parameter, start, tolerance of a variable, typed line or span is another scene. A copy, the
 * caller's own. references NULL: nothing is kept.
 */
bool references_get(struct references *references, const struct scene *scene,
                    const struct system *system, double span, const struct cancel *cancel,
                    struct reference *reference, struct error *error);
/* Computes a suspect reference again in steps of at most `step` [s], and stores it instead. Returns
 * false if that fails (ERROR_NUMERICAL), so that the old one stays, or if cancelled. */
bool references_again(struct references *references, const struct scene *scene,
                      const struct system *system, double span, double step,
                      const struct cancel *cancel, struct reference *reference,
                      struct error *error);
/* Returns the stored reference of the scene, or NULL if none is stored or there is none. */
const struct reference *references_find(struct references *references, const struct scene *scene,
                                        double span);
void references_free(struct references *references);

struct study_errors {
    double end, max; /* error at the end, and the largest on the grid */
    /* largest |E - E_reference| / largest |E_reference|; NAN for first-order scenes */
    double energy;
    double phase, amplitude; /* [rad] and relative, at the end, of an oscillator; NAN */
};

/* ---- precision: error against run time ---- */

struct method_choice {
    const struct method *method;
    enum drag drag; /* DRAG_DEFAULT selects the method's own */
};

/* Returns the name of the drag, or NULL for the method's own. */
const char *contender_drag(const struct method_choice *choice);

struct precision_request {
    const struct scene *scene;
    const struct method_choice *choice;
    int choices;
    /* [s] ends of the sweep, or NAN to choose them. If given, methods that adapt take fixed steps,
     * too. */
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

struct precision_point {
    int curve;
    double dt, tol; /* dt = duration / 2^k [s]; tol > 0: adaptive, then dt = 0 */
    int64_t steps;
    struct cost cost;
    enum stop stop;
    bool refused; /* the method takes no steps of this size here */
    struct study_errors errors;
    /* lost already where the motion goes furthest: steps, cost and error are of that 1/256 alone */
    bool probed;
    /* [s] of the processor, for the one solve that was measured, sampling included */
    double seconds;
    double part; /* part of the duration that it covers, below 1 if it was given up or probed */
    bool costly; /* so long that this one solve is its time and is not repeated */
    /* Number of steps that were timed, scaled to all of them, or 0 for whole solves. */
    int64_t timed_steps;
    double order; /* log(error ratio)/log(dt or tol ratio) to the point before, NAN for the first */
    bool is_below_reference; /* the error is below the accuracy of the reference */
    bool asymptotic;         /* takes part in the fit */
    enum kernel path;        /* as study_path() */
    struct timing_result time;
    /* [s] the same with all rows recorded, the shortest of three, or NAN if not asked for. */
    double recording;
};

/* One method: its points from coarse to fine, and the line through the asymptotic ones. */
struct precision_curve {
    struct method_choice choice;
    bool adaptive;
    int first, count;
    /* slope of log error over log dt (or log tol), or NAN for fewer than three points */
    double slope, r2;
    int fitted;
    /* Expected slope: the order, or 1 for tol (error proportional to tolerance), or NAN for exact
     * methods. */
    double expected;
    /* slope is further than PRECISION_SLOPE (for orders above 6: a 20th) from what is expected */
    bool differs;
    bool cut; /* ended by the time allowed, not by rounding or cost */
};

#define PRECISION_SLOPE 0.3

struct precision {
    struct scene scene;
    struct system system;
    struct reference reference;
    double duration;
    bool compensated;
    struct precision_point *point;
    int points;
    struct precision_curve *curve;
    int curves;    /* finished */
    bool by_evals; /* its diagram is over evaluations, whatever was timed */
};

/*
 * Sweeps each choice from coarse steps to the floor of rounding (or the ends given), measures
 * the errors, then times all points together. Failed points are results; of those before the first
 * success only the last is kept. A choice that does not apply is an error before anything runs.
 * False also when cancelled: what is finished is kept (curves > 0), times may be missing.
 * precision_free() in every case.
 */
bool study_precision(const struct precision_request *request, struct precision *precision,
                     struct error *error);
void precision_free(struct precision *precision);

/* A point with what it belongs to: a row of its result. */
struct precision_row {
    struct precision_point point;
    struct precision_curve curve;
    double accuracy; /* accuracy of the reference */
    bool stored;     /* the reference was computed by an earlier study */
    bool resolved;   /* it is not contradicted by the finest runs of two methods */
    const struct precision *precision;
};

/* One for each point, from the arena; they hold as long as `precision`. Returns NULL if out of
 * memory. */
const struct precision_row *precision_rows(const struct precision *precision, struct arena *arena);
extern const struct result_columns precision_columns; /* columns of struct precision_row */

/* A point that says something: it reached the end, with an error below 1. */
bool precision_meaningful(const struct precision_point *point);
/* Returns why a point says nothing ("lost", "too long", "diverged", ..), or "" if it says
 * something: the same word in tables, records and the diagram. */
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

/* Ratio of minima of the same solve in different processes. */
#define PRECISION_TIE 1.05

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
 * rotation (NUMERICS 1.5). Returns NAN for another scene, adaptive steps, or a method without such
 * a matrix.
 */
double precision_predict(const struct precision *precision, int curve, double error);
bool precision_predicts(const struct system *system);

/* Returns true if natural rates times duration are so large that explicit methods choose their
 * steps for stability alone. */
bool precision_is_stiff(const struct system *system, double duration);
/* Chooses a dozen methods that apply to the system, by its stiffness, and returns their number.
 * absent() is called with each other method that was considered, and the reason. */
#define PRECISION_DEFAULTS 12
int precision_defaults(const struct system *system, double duration, struct method_choice *choice,
                       void (*absent)(void *context, const char *method, const char *reason),
                       void *context);

/* ---- compare ---- */

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

struct comparison {  /* one method at one setting */
    struct run *run; /* owned by the caller after study_compare */
    /* Errors against the exact solution; without one, end, max and floor are against the
     * reference. */
    struct run_errors errors;
    double duration; /* [s] asked for */
    const struct method
        *reference[2]; /* methods of that reference, or NULL if it is not needed or there is none */
    bool reference_stored; /* the reference was computed by an earlier study */
    struct ledger ledger;
    /* log(error ratio)/log(dt ratio) to the row before of the same method, NAN for the first */
    double order;
    double energy_factor; /* E/E0 at the end */
    /* E/E0 predicted by the method's amplification matrix, or NAN if that does not apply. */
    double predicted_factor;
    /* The matrix says that steps of this size grow where the solution does not, or shrink to less
     * than a tenth of its energy. */
    bool grows, shrinks;
    enum kernel path; /* as study_path() */
    struct timing_result time;
    /* the result in words, as "energy x 1.76e+03 in 10 s, as predicted: 1.0075 a step" */
    char verdict[200];
};

/* Steps and computing time [s] that all of it will take; false where study_compare would refuse. */
bool study_compare_plan(const struct compare_request *request, double *steps, double *seconds,
                        struct error *error);
/*
 * Runs every choice at every setting, in order. rows has room for choices * max(dts, 1) (or
 * tols); *count says how many were finished. A method that does not apply to the scene, or a
 * setting that is refused, is an error before anything runs. A diverged run is a result. False also
 * when cancelled: the finished rows are kept and *count > 0.
 */
bool study_compare(const struct compare_request *request, struct comparison *rows, int *count,
                   struct error *error);
void comparison_free(struct comparison *row); /* destroys the run if it is still there */

/* A comparison as it is shown, written and kept: without the run, which has a life of its own. */
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

/* Takes over what is known; period, data and `mixed` are to be filled in. */
void compared_init(struct compared_row *row, const struct comparison *comparison);
/* Makes the row of a method that was not run, because it would take too long [s]. */
void compared_too_long(struct compared_row *row, const struct method_choice *choice, double dt,
                       double steps, double seconds);
/* "10 ms", "tol 1e-06" */
void compared_setting(const struct compared_row *row, struct buffer *text);
extern const struct result_columns compared_columns; /* columns of struct compared_row */

/* ---- order: how fast the error falls with the step ----
 *
 * Fixed steps of duration/N with compensated sums, errors of the whole state at the end. The order
 * is the slope over the asymptotic part: below the errors that are too large to say anything, above
 * rounding and the accuracy of the reference; there the finest few points whose local slopes agree.
 */

struct order_request {
    const struct scene *scene;
    struct method_choice choice;
    double dt[2];                  /* [s] ends of the sweep, or NAN to choose them */
    double duration;               /* [s] */
    struct references *references; /* kept between studies, or NULL */
    const struct cancel *cancel;
};

struct order_point {
    double dt; /* [s] */
    int64_t steps;
    enum stop stop;
    bool refused; /* the method takes no steps of this size here */
    /* Largest error of a variable in units of its amplitude, or NAN if it did not reach the end. */
    double error;
    double slope;  /* slope to the point before, or NAN */
    int64_t turns; /* extra steps that end at turning points */
    bool fitted;
};

#define ORDER_POINTS 64
#define ORDER_BAND 0.05 /* a slope that close to the claim agrees with it */

enum order_verdict {
    ORDER_AGREES,
    ORDER_LOWER,
    ORDER_HIGHER,
    ORDER_ERRATIC,
    ORDER_NO_RANGE,
    ORDER_EXACT
};

extern const struct catalog order_verdict_catalog; /* struct row at the enum's place */

struct order {
    struct method_choice choice;
    int claimed; /* order that the row claims; explicit drag claims 1 on a scene with drag */
    /* `guard` is the reach of local slopes and of the line's own uncertainty, or NAN without a
     * range. */
    double slope, guard, r2;
    struct order_point point[ORDER_POINTS];
    int points, fitted;
    double floor;          /* errors below are not claimed */
    bool reference_stored; /* the reference was computed by an earlier study */
    enum order_verdict verdict;
    bool switches;   /* the forces switch, beside dry friction */
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

/* Fills in a row for each point; returns how many. */
size_t order_rows(const struct order *order, struct order_row *rows);

/* Columns of struct order, struct order_point and struct order_row. */
extern const struct result_columns order_columns, order_point_columns, order_row_columns;

/* Measures the order. Returns false if the method does not apply, if there is no reference, or if
 * cancelled; finished points are kept (points > 0). */
bool study_order(const struct order_request *request, struct order *order, struct error *error);

/* ---- selftest: what the rows claim, measured on this machine ---- */

enum selftest_check {
    SELFTEST_ORDER,
    SELFTEST_AREA,
    SELFTEST_REVERSAL,
    SELFTEST_STABILITY,
    SELFTEST_CHECKS
};

extern const struct catalog selftest_catalog;

struct selftest_result {
    bool applies, passed;
    /* order; area factor - 1; distance from the start; growth around the limit; NAN */
    double value, wanted;
};

struct selftest_row {
    const struct method *method;
    struct selftest_result check[SELFTEST_CHECKS];
    bool passed;
};

/* Checks the claims of one method's row. Returns false if out of memory or cancelled. */
bool selftest_method(const struct method *method, const struct cancel *cancel,
                     struct selftest_row *row);
