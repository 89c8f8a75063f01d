/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits to a series: any curve by least squares, typed formulas, damped sines, laws of damping and
 * restoring force, several modes; and the mean of repeated measurements. */
#pragma once

#include <hooke/base/row.h>
#include "modules/recording/period/period.h"

struct cancel;
struct catalog;
struct expr_scope;

/* ---- least squares for any curve ----
 *
 * y = f(parameters, t) with exact derivatives.
 */

/* Largest number of parameters of a curve. */
#define CURVE_PARAMETERS 24

/* A curve to be fitted, as a function with derivatives. */
struct fit_curve {
    int parameters;          /* number of parameters, at most CURVE_PARAMETERS */
    const char *const *name; /* [parameters] names for messages */
    void *context;           /* passed to evaluate */
    /* Computes values [n] at the times t [n] and, unless NULL, derivatives [n][parameters]. Returns
     * false if there is no value or the evaluation was cancelled. */
    bool (*evaluate)(void *context, const double *parameter, const double *t, size_t n,
                     double *value, double *derivative);
};

/* Options of curve_fit(); all zero is a plain least-squares fit without bounds. */
struct curve_options {
    /* [parameters] bounds or NULL; -INFINITY and INFINITY leave a side open. */
    const double *low, *high;
    /* [parameters] true for those in which the curve is linear, all together, so that their start
     * does not matter; NULL if unknown */
    const bool *linear;
    /* Weights for outliers: soft-L1 first, then bisquare with 4.685 robust standard deviations.
     * Samples far from the curve get no weight, and are counted as rejected. */
    bool robust;
    /* The answer is only the start of another fit: the last digits and the judgement are
     * skipped. */
    bool rough;
    /* An evaluation takes long, for example because it integrates a motion: digits far below the
     * uncertainties are not refined. */
    bool costly;
    /* Number of consecutive samples that a robust fit judges by their own scatter if this is larger
     * than that of all samples. A misfit of the curve that lasts is then not taken for outliers. 0
     * judges all samples together. */
    size_t stretch;
    int iterations; /* maximum; 0 means 500 */
    int bootstrap;  /* number of parametric bootstrap samples for the intervals, may be 0 */
    uint64_t seed;  /* start of the bootstrap's random numbers */
    const struct cancel *cancel;
};

/* The answer of curve_fit(), with its uncertainties and diagnostics. */
struct curve_fit {
    int parameters;
    /* Fitted values. Uncertainties are widened for correlated residuals, and NAN if not
     * determined. */
    struct measured value[CURVE_PARAMETERS];
    double formal[CURVE_PARAMETERS]; /* uncertainties as if residuals were independent */
    /* 95 % intervals by Student's t, or by the bootstrap if it was asked for. */
    double interval[CURVE_PARAMETERS][2];
    double covariance[CURVE_PARAMETERS][CURVE_PARAMETERS]; /* widened */
    double correlation[CURVE_PARAMETERS][CURVE_PARAMETERS];
    bool determined[CURVE_PARAMETERS]; /* true if the data determine the parameter */
    bool bound[CURVE_PARAMETERS];      /* the parameter lies on its bound and has no uncertainty */
    bool converged; /* small_step and small_gradient hold, and every parameter is determined */
    /* The next full step would change no parameter by more than 1e-8 of its value or
     * uncertainty. */
    bool small_step;
    /* The residuals are orthogonal to the derivatives, to 1e-6 or to rounding. */
    bool small_gradient;
    int iterations;
    double rss, sigma;      /* (weighted) sum of squares; standard deviation of the residuals */
    size_t used, rejected;  /* numbers of samples with weight and without */
    double autocorrelation; /* lag 1 of the residuals */
    /* Number of runs of equal sign, in standard deviations from what chance gives; below -3 the
     * residuals are systematic. */
    double runs;
    int bootstrapped; /* number of bootstrap fits that converged */
    double *residual; /* [n] y - f, from the arena */
    double *weight;   /* [n] 1, or the robust ones */
    char said[200];   /* the verdict in words: "converged: …", "did not converge: …" */
};

/* Fits the curve by least squares, starting from start [parameters]; options may be NULL. Residuals
 * and weights of the answer come from the arena. Returns true if there is an answer: `converged`
 * and `said` tell whether it can be used, and the caller decides on ERROR_NUMERICAL. Returns false
 * with ERROR_COMMAND (fewer samples than parameters, no value of the curve at the start),
 * ERROR_CANCELLED, or if out of memory. */
bool curve_fit(const struct fit_curve *curve, const struct series *series, const double *start,
               const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
               struct error *error);

/* Returns true if more than a fifth of the samples are left out, as outliers or as clipped. Any fit
 * that leaves out so many counts as not converged. */
static inline bool fit_discards_much(size_t rejected, size_t samples)
{
    return (double)rejected > 0.2 * (double)samples;
}

/* ---- formulas ----
 *
 * A formula in t as the user types it; unknown names are its parameters.
 */

/* A variable of a formula besides t: another column of the recording. */
struct formula_column {
    const char *name;
    /* [n] values at the times of the series; NULL stands for the times themselves */
    const double *value;
};

/* A compiled formula and the starts of its parameters. All pointers are borrowed or the arena's. */
struct formula {
    const struct expr *expr;
    const struct cancel *cancel; /* ends its evaluation unless NULL */
    int parameters;
    const char *name[CURVE_PARAMETERS];  /* names in the order in which they first appear */
    bool linear[CURVE_PARAMETERS];       /* the formula is linear in these together */
    bool started[CURVE_PARAMETERS];      /* the user gave a start */
    double start[CURVE_PARAMETERS];      /* starts that were given */
    const struct formula_column *column; /* variables besides t, which always exists */
    int columns;
    double *constant;                /* values of the known names, from the arena */
    struct formula_program *program; /* program of the formula, set during a fit */
};

/*
 * Compiles the longest formula at the start of `text` (see expr_compile()). `known` has the names
 * that are constants, with their present values, or is NULL; `column` has variables besides t, or
 * is NULL. Returns false with the error unless it has 1 to CURVE_PARAMETERS parameters.
 */
bool formula_compile(struct text text, const struct expr_scope *known,
                     const struct formula_column *column, int columns, struct arena *arena,
                     struct formula *formula, size_t *used, struct error *error);
/* Sets the start of a parameter by name. Returns false, with a suggestion, if the formula has no
 * such parameter. */
bool formula_start(struct formula *formula, struct text name, double start, struct error *error);
/*
 * Fits the formula; the result is that of curve_fit(). Starts that are not given are searched for:
 * parameters in which the formula is linear are solved for exactly, the others tried on scales that
 * the series suggests (its spectrum, span, range), and the best are refined.
 */
bool formula_fit(const struct formula *formula, const struct series *series,
                 const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
                 struct error *error);
/* ---- fits ---- */

/* Laws of damping, terms of y'' + gamma y' + b|y'|y' + f sign(y') + omega0^2 y = 0, and their
 * sums. */
enum drag_law {
    LAW_NONE = 0,
    LAW_LINEAR = 1,
    LAW_QUADRATIC = 2,
    LAW_DRY = 4,
    LAW_UNDECIDED = 8, /* the data do not decide between laws */
    DRAG_LAWS = 7,     /* number of laws and their sums, which are 1 to 7 */
    DRAG_RATES = 3     /* number of terms */
};

struct drag_law_row {
    struct row row; /* linear, linear+quadratic, …; the citation is its equation */
    enum drag_law law;
};

extern const struct catalog drag_law_catalog;

/* Name and units of the coefficient of one term of damping. */
struct drag_rate {
    const char *name; /* gamma, b, f */
    const char *unit; /* unit for a position in metres */
    const char *bare; /* unit for an angle or a plain number */
};

/* Rates in the order of the bits of enum drag_law. */
extern const struct drag_rate drag_rates[DRAG_RATES];

/* Returns "linear+dry", "not distinguishable" …, or NULL for LAW_NONE. */
const char *drag_law_name(enum drag_law law);

enum {
    /* Indices of the parameters of struct equation. */
    EQUATION_START,
    EQUATION_SPEED,
    EQUATION_OMEGA,
    EQUATION_RATE, /* gamma, b, f */
    EQUATION_CUBIC = EQUATION_RATE + DRAG_RATES,
    EQUATION_OFFSET,
    EQUATION_PARAMETERS
};

/* Restoring force omega0^2 y, omega0^2 y + beta y^3 (Duffing) or omega0^2 sin(y) (pendulum, y is an
 * angle). */
enum restoring_force { RESTORING_LINEAR, RESTORING_CUBIC, RESTORING_SINE, RESTORING_FORCES };

/* Returns "linear", "Duffing" or "pendulum". */
const char *restoring_name(enum restoring_force force);

/* A motion under laws of damping and restoring force. */
struct equation {
    /* y and y' at t0 (without the offset), omega0 [rad/s], gamma, b, f, beta, offset. */
    double value[EQUATION_PARAMETERS];
    double t0; /* [s] time of the initial values */
    /* Order of the derivative that the series shows: 0 is the position, 1 the velocity, 2 the
     * acceleration. */
    int order;
    enum restoring_force force;
};

/* Computes values [n] at ascending times t >= t0, offset included, and unless NULL their
 * derivatives [n][EQUATION_PARAMETERS]. Integrates to rounding, through turning points and into
 * rest. Returns false if the integration does not reach the last time. */
bool equation_solve(const struct equation *equation, const double *t, size_t n, double *value,
                    double *derivative);

/* Order of the Taylor series, and its columns: the solution and derivatives by each parameter. */
enum { EQUATION_ORDER = 18, EQUATION_COLUMNS = EQUATION_OFFSET + 1 };

/* Derivatives that an evaluation computes: none, all but that by b where b is 0, or all. */
enum equation_slopes { EQUATION_VALUES, EQUATION_SLOPES_BUT_B, EQUATION_SLOPES };

/* State of an integration that is evaluated forwards, some samples at a time. */
struct equation_walk {
    enum restoring_force force;
    int order;
    /* True if derivatives by the parameters are computed. */
    bool slopes;
    /* True if the law has quadratic drag, or if the derivative by b is computed. */
    bool quadratic;
    double t0, omega, offset; /* as in struct equation */
    double g, b, f, cubic;    /* rates in the time unit 1/omega */
    double side;              /* sign of the velocity, or 0 if it stays at rest */
    double phase;             /* [rad] phase at the start of the step */
    /* Taylor coefficients of y, and of its derivatives by the parameters */
    double c[EQUATION_ORDER + 1][EQUATION_COLUMNS];
};

/* Starts an integration at equation->t0. Returns false if its parameters are not usable. Call
 * equation_values() next, with ascending times. */
bool equation_begin(const struct equation *equation, enum equation_slopes slopes,
                    struct equation_walk *walk);
/* Continues the integration and computes values [n] and, if slopes were asked for, derivatives
 * [n][EQUATION_PARAMETERS] at the ascending times t [n]. Returns false if the integration fails. */
bool equation_values(struct equation_walk *walk, const double *t, size_t n, double *value,
                     double *derivative);

/* Result of fitting the whole oscillation, integrated, under each law of damping. */
struct drag_fit {
    struct drag_candidate {
        enum drag_law law;
        bool converged;
        /* gamma [1/s], b [1/m], f [m/s^2] if y is a length; 0 if the law has no such term */
        struct measured rate[DRAG_RATES];
        /* Bayesian information criterion, computed with `independent` residuals. */
        double bic;
        double rms; /* root mean square of the residuals */
    } candidate[DRAG_LAWS];
    int candidates; /* number of laws compared; 0 if the fit did not compare laws */
    /* simplest law that the data do not exclude; the fit's values are of this law */
    enum drag_law best;
    /* Bit i is set if the data do not exclude candidate[i]. With more than one bit, the laws are
     * not distinguishable. */
    unsigned remaining;
    /* number of independent residuals, after allowing for their correlation in the amplitude */
    double independent;
    double delta; /* BIC of the second-best law minus that of the best */
    /* p value of the F-test of the last term of a sum, or of a second term beside a single law */
    double p_value;
    struct equation motion;       /* the fitted motion under the best law */
    struct measured start, speed; /* y and y' at t0 */
    struct restoring_candidate {
        bool converged;
        double bic;
    } restoring[RESTORING_FORCES];
    int forces; /* number of restoring forces compared; 0 if only the linear one was tried */
    enum restoring_force force; /* simplest force that the data do not exclude */
    /* Bit i is set if the data do not exclude force i. With more than one bit, the forces are not
     * distinguishable. */
    unsigned forces_remaining;
    struct measured cubic; /* beta [1/(s^2 y^2)] of a Duffing spring */
    double signal;         /* rms of the motion alone */
    double wander;  /* standard deviation of the baseline between blocks; 0 if it does not wander */
    char said[240]; /* the choice in words, with its numbers */
};

/* Covariances of fitted parameters, widened as their uncertainties are. The parameters are
 * amplitude, phase, omega, gamma for a damped sine; those of the equation without the offset for a
 * law; the free parameters of the scene, by ascending index, for a fit of the scene. */
struct fit_covariance {
    int n; /* number of parameters, 0 if unknown */
    double entry[CURVE_PARAMETERS][CURVE_PARAMETERS];
};

/* Order of a damped sine's parameters in struct fit_covariance. */
enum { SINE_AMPLITUDE, SINE_PHASE, SINE_OMEGA, SINE_GAMMA, SINE_PARAMETERS };

/* Scales row and column i so that the standard deviation of parameter i becomes `uncertainty`. */
void fit_covariance_widen(struct fit_covariance *covariance, int i, double uncertainty);

/* Result of a row of fit_catalog. Values that a model does not have are NAN. */
struct fit {
    const char *model; /* name of the row */
    /* Values in SI units; period = 2 pi/omega, with the frequency of the damped motion. */
    struct measured period, omega, gamma, amplitude, phase, offset;
    double rms;            /* rms of the residuals of the samples used */
    size_t used, rejected; /* numbers of samples */
    double window[2];      /* [s] */
    /* gamma of each half of the window, NAN where a half does not determine it. */
    struct measured halves[2];
    struct measured half_periods[2]; /* [s] period of each half */
    /* law of damping, or LAW_NONE if the laws were not compared (fit drag compares them) */
    enum drag_law preferred;
    bool converged;
    int iterations;
    double autocorrelation; /* lag 1 of the residuals */
    char warning[8][200];
    int warnings;
    double t0; /* [s] time of the first sample, from which t in the model counts */
    /* [y/s] drift of the offset, which is given at t0; 0 if it does not drift */
    struct measured drift;
    struct drag_fit drag;
    struct fit_covariance covariance;
};

/* Kind of fit: by the row's own function, by integrating the scene, or of several modes. */
enum fit_by { FIT_OWN, FIT_SCENE, FIT_MODES };

/* A row of fit_catalog; `fit` is NULL unless kind is FIT_OWN. The function fits the series, with
 * memory of the arena. */
struct fit_model {
    struct row row; /* damped, sine, … */
    enum fit_by kind;
    bool (*fit)(const struct series *series, struct arena *arena, const struct cancel *cancel,
                struct fit *fit, struct error *error);
};

/* Models of fits; none needs a starting guess, and "damped", the first, is the default. "drag"
 * compares laws of damping and takes its values from the best one by BIC; `preferred` is
 * LAW_UNDECIDED if the data do not decide. "law" also compares restoring forces. Uncertainties are
 * those of least squares, widened for what the residuals have in common with each parameter (sway,
 * wandering), and for period, omega and gamma by half the difference between the window's halves if
 * it exceeds 2.5 standard deviations. A fit returns false with ERROR_COMMAND if the series does not
 * oscillate, with ERROR_NUMERICAL if it does not converge. GSL's error handler is off
 * (base/numeric.c). */
extern const struct catalog fit_catalog;
/* Finds a row by exact name or alias. Returns NULL if there is none. */
const struct fit_model *fit_model_by_name(struct text name);
/* Returns row i of the catalog, or NULL past its end. */
const struct fit_model *fit_model_at(size_t i);
/* Returns the fit_model that row, one of the catalog's, belongs to. */
const struct fit_model *fit_model_from(const struct row *row);

/* Computes the model's values [n] at n ascending times t [s], which are absolute, not counted from
 * t0. Values are NAN if the motion of a law cannot be integrated. */
void fit_values(const struct fit *fit, const double *t, size_t n, double *value);
/* Returns the spring constant k = m (omega^2 + gamma^2/4), with the uncertainties of mass and
 * fit. */
struct measured fit_stiffness(const struct fit *fit, struct measured mass);

/* ---- modes: several damped sines at once ---- */

/* Largest number of modes that one fit takes. */
#define MODES_MAX LIMIT_MODES

/* One damped sine of a sum of several. */
struct normal_mode {
    struct measured frequency; /* [Hz] frequency of the damped motion: omega/(2 pi) */
    struct measured gamma;     /* [1/s]; the amplitude falls as exp(-gamma t/2) */
    struct measured amplitude; /* unit of y */
    struct measured phase;     /* [rad] at the first sample */
};

/* Result of series_modes(). */
struct modes_fit {
    /* Offset, its drift, rms, warnings and so on; values that belong to one mode are NAN here. */
    struct fit fit;
    int modes;
    struct normal_mode mode[MODES_MAX]; /* the slowest first */
    /* The next three belong to two modes, and are NAN for any other number. */
    struct measured splitting; /* [Hz] difference of the two frequencies */
    /* kc/k of two equal oscillators, each with spring k, coupled by a spring kc: the squared
     * frequencies are k/m and (k + 2 kc)/m. */
    struct measured coupling;
    struct measured stiffness; /* [1/s^2] kc/m */
    double *residual;          /* [n] y - model, from the arena */
};

/* Fits y = c + d t + the sum of `modes` damped sines by least squares, without guesses.
 * Uncertainties are widened, as those of fit_catalog's rows, for what the residuals share with each
 * parameter. Returns false with ERROR_NUMERICAL if fewer frequencies stand out of the noise. If it
 * returns true, fit.converged must still be checked; a warning tells if two frequencies are too
 * close to each other. */
bool series_modes(const struct series *series, int modes, struct arena *arena,
                  const struct cancel *cancel, struct modes_fit *fit, struct error *error);

/* ---- the same quantity, measured several times ---- */

/* Statistics of a quantity that was measured several times. */
struct repeat {
    int n;                /* number of values */
    struct measured mean; /* unweighted, with uncertainty scatter/sqrt(n) */
    double scatter;       /* standard deviation of one value */
    /* Mean weighted by the stated uncertainties, with the uncertainty that follows from them alone.
     * NAN if a value states none. */
    struct measured weighted;
    double birge;  /* Birge ratio sqrt(chi2/(n - 1)): observed scatter over stated uncertainty */
    double chance; /* probability of so much scatter if the stated uncertainties are right */
    /* Standard deviation to be added in quadrature to each value's uncertainty so that the scatter
     * is explained; may be 0. */
    double excess_scatter;
    struct measured quote; /* the value to quote: weighted with stated and excess scatter */
    double interval;       /* half width of its 95 % interval (Student) */
};

/* Computes the statistics of n repeated values (Birge 1932; Paule and Mandel 1982). Returns false
 * for fewer than two. */
bool repeat_values(const struct measured *x, int n, struct repeat *repeat);
