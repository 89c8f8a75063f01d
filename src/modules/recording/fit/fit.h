/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves, formulas and laws fitted to a series; the same quantity measured again. */
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

#define CURVE_PARAMETERS 24

struct fit_curve {
    int parameters;
    const char *const *name; /* [parameters] for messages */
    void *context;
    /* Computes values [n] at the times t [n] and, unless NULL, derivatives [n][parameters]. Returns
     * false if there is no value or the evaluation was cancelled. */
    bool (*evaluate)(void *context, const double *parameter, const double *t, size_t n,
                     double *value, double *derivative);
};

struct curve_options {
    const double *low,
        *high; /* [parameters] bounds or NULL; -INFINITY and INFINITY leave a side open */
    /* [parameters] true for those in which the curve is linear, all together, so that their start
     * does not matter; NULL if unknown */
    const bool *linear;
    /* soft-L1, then bisquare (4.685 robust sigma): what is far off has no weight, and is counted */
    bool robust;
    /* a start for another fit is wanted: neither the last digits nor what is determined */
    bool rough;
    /* an evaluation takes long, as where a motion is integrated: digits far below the
     * uncertainties are not looked for */
    bool costly;
    /* number of samples in a row that a robust fit judges by their own scatter if it is larger than
     * that of all, as what the curve misses for long is no outlier; 0 judges all together */
    size_t stretch;
    int iterations; /* maximum; 0 means 500 */
    int bootstrap;  /* number of parametric bootstrap samples for the intervals, may be 0 */
    uint64_t seed;  /* start of the bootstrap's random numbers */
    const struct cancel *cancel;
};

struct curve_fit {
    int parameters;
    /* uncertainties are widened for correlated residuals, and NAN if not determined */
    struct measured value[CURVE_PARAMETERS];
    double formal[CURVE_PARAMETERS]; /* the same as if residuals were independent */
    /* 95 % (Student's t; of the bootstrap where it was asked for) */
    double interval[CURVE_PARAMETERS][2];
    double covariance[CURVE_PARAMETERS][CURVE_PARAMETERS]; /* widened */
    double correlation[CURVE_PARAMETERS][CURVE_PARAMETERS];
    bool determined[CURVE_PARAMETERS]; /* true if the data determine the parameter */
    bool bound[CURVE_PARAMETERS];      /* the parameter lies on its bound and has no uncertainty */
    bool converged; /* small_step and small_gradient hold, and every parameter is determined */
    /* the next full step would change no parameter by more than 1e-8 of itself or its
     * uncertainty */
    bool small_step;
    /* the residuals are orthogonal to the derivatives to 1e-6, or to rounding */
    bool small_gradient;
    int iterations;
    double rss, sigma; /* (weighted) sum of squares; standard deviation of the residuals */
    size_t used, rejected;
    double autocorrelation; /* lag 1 of the residuals */
    /* Number of runs of equal sign, in standard deviations from what chance gives; below -3 the
     * residuals are systematic. */
    double runs;
    int bootstrapped; /* samples that converged */
    double *residual; /* [n] y - f, from the arena */
    double *weight;   /* [n] 1, or the robust ones */
    char said[200];   /* the verdict in words: "converged: …", "did not converge: …" */
};

/*
 * Fits the curve by least squares from the start [parameters]. Returns true if there is an answer;
 * `converged` and `said` tell what it is worth (the caller decides on ERROR_NUMERICAL). Returns
 * false with ERROR_COMMAND (fewer samples than parameters, no value of the curve at the start),
 * ERROR_CANCELLED, or if out of memory.
 */
bool curve_fit(const struct fit_curve *curve, const struct series *series, const double *start,
               const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
               struct error *error);

/* Returns true if more than a fifth of the samples are left out, be they bad echoes or flat tops: a
 * fit of any kind that leaves out as many has not converged. */
static inline bool fit_discards_much(size_t rejected, size_t samples)
{
    return (double)rejected > 0.2 * (double)samples;
}

/* ---- formulas ----
 *
 * A formula in t as the user types it; unknown names are its parameters.
 */

struct formula_column {
    const char *name;
    const double *value; /* [n] values at the times of the series; where value is NULL, the times */
};

struct formula {
    const struct expr *expr;
    const struct cancel *cancel; /* ends its evaluation unless NULL */
    int parameters;
    const char *name[CURVE_PARAMETERS]; /* names in the order in which they first appear */
    bool linear[CURVE_PARAMETERS];      /* the formula is linear in these together */
    bool started[CURVE_PARAMETERS];     /* a start was given */
    double start[CURVE_PARAMETERS];
    const struct formula_column *column; /* variables; t is always one */
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

/* Laws of damping, terms of y'' + gamma y' + b|y'|y' + f sign(y') + omega0^2 y = 0, and their sums.
 */
enum drag_law {
    LAW_NONE = 0,
    LAW_LINEAR = 1,
    LAW_QUADRATIC = 2,
    LAW_DRY = 4,
    LAW_UNDECIDED = 8,
    DRAG_LAWS = 7, /* the sums: 1 .. 7 */
    DRAG_RATES = 3
};

struct drag_law_row {
    struct row row; /* linear, linear+quadratic, …; the citation is its equation */
    enum drag_law law;
};

extern const struct catalog drag_law_catalog;

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

/* A motion under such a law: y and y' at t0 [without the offset], omega0, gamma, b, f, beta, and
 * the offset. */
struct equation {
    double value[EQUATION_PARAMETERS];
    double t0;
    /* order of the observed derivative: 0 is the position, 1 its velocity, 2 its acceleration */
    int order;
    enum restoring_force force;
};

/*
 * Computes values [n] at ascending times t >= t0, offset included, and unless NULL their
 * derivatives [n][EQUATION_PARAMETERS]. Integrates to rounding, through turning points and into
 * rest. Returns false if it cannot be integrated that far.
 */
bool equation_solve(const struct equation *equation, const double *t, size_t n, double *value,
                    double *derivative);

enum { EQUATION_ORDER = 18, EQUATION_COLUMNS = EQUATION_OFFSET + 1 };

/* Derivatives that an evaluation computes: none, all but that by b where b is 0, or all. */
enum equation_slopes { EQUATION_VALUES, EQUATION_SLOPES_BUT_B, EQUATION_SLOPES };

/* State of an integration that is evaluated forwards, some samples at a time. */
struct equation_walk {
    enum restoring_force force;
    int order;
    bool slopes;    /* derivatives are wanted, and */
    bool quadratic; /* the law has quadratic drag, or the derivative by it is computed */
    double t0, omega, offset;
    double g, b, f, cubic; /* rates in the time unit 1/omega */
    double side;           /* sign of the velocity, or 0 if it stays at rest */
    double phase;          /* [rad] phase at the start of the step */
    /* Taylor coefficients of y, and of its derivatives by the parameters */
    double c[EQUATION_ORDER + 1][EQUATION_COLUMNS];
};

bool equation_begin(const struct equation *equation, enum equation_slopes slopes,
                    struct equation_walk *walk);
bool equation_values(struct equation_walk *walk, const double *t, size_t n, double *value,
                     double *derivative);

/* The whole oscillation under each law, integrated. */
struct drag_fit {
    struct drag_candidate {
        enum drag_law law;
        bool converged;
        /* gamma [1/s], b [1/m], f [m/s^2] if y is a length; 0 if the law has no such term */
        struct measured rate[DRAG_RATES];
        double bic; /* BIC with that number of `independent` residuals */
        double rms;
    } candidate[DRAG_LAWS];
    int candidates;     /* 0 if the fit was not one of drag */
    enum drag_law best; /* the simplest that remains: the law that the fit's values are those of */
    /* bit i: the data do not exclude candidate[i]; more than one: not distinguishable */
    unsigned remaining;
    double independent; /* residuals, after allowing for their correlation in the amplitude */
    double delta;       /* BIC of the next best law less that of the best */
    double p_value; /* F-test of the last term of a sum, or of a second one beside a single law */
    struct equation motion;
    struct measured start, speed; /* y and y' at t0 */
    struct restoring_candidate {
        bool converged;
        double bic;
    } restoring[RESTORING_FORCES];
    int forces;                 /* 0 if only the spring was tried */
    enum restoring_force force; /* the simplest that remains */
    /* bit i: the data do not exclude force i; more than one: not distinguishable */
    unsigned forces_remaining;
    struct measured cubic; /* beta [1/(s^2 y^2)] of a Duffing spring */
    double signal;         /* rms of the motion alone */
    double wander;  /* standard deviation between blocks of the baseline; 0 if it does not wander */
    char said[240]; /* the choice in words, with the numbers */
};

/*
 * Covariances of what a fit determined, widened as its uncertainties are: of amplitude, phase,
 * omega, gamma of a damped sine; of the equation's parameters, the offset left out, of a law; of a
 * scene's free parameters by ascending place.
 */
struct fit_covariance {
    int n; /* 0 if unknown */
    double entry[CURVE_PARAMETERS][CURVE_PARAMETERS];
};

enum { SINE_AMPLITUDE, SINE_PHASE, SINE_OMEGA, SINE_GAMMA, SINE_PARAMETERS };

/* Scales a row and its column, so that the standard deviation becomes this. */
void fit_covariance_widen(struct fit_covariance *covariance, int i, double uncertainty);

struct fit {
    const char *model;
    /* SI; period = 2 pi/omega (the damped one) */
    struct measured period, omega, gamma, amplitude, phase, offset;
    double rms; /* rms of the residuals of the samples used */
    size_t used, rejected;
    double window[2]; /* [s] */
    /* gamma of the two halves of the window, NAN where a half determines nothing */
    struct measured halves[2];
    struct measured half_periods[2]; /* [s] */
    /* law of damping, or LAW_NONE if the laws were not compared (fit drag compares them) */
    enum drag_law preferred;
    bool converged;
    int iterations;
    double autocorrelation; /* lag 1 of the residuals */
    char warning[8][200];
    int warnings;
    double t0; /* [s] time of the first sample: t in the model counts from here */
    /* [y/s] drift of the offset, which is given at t0; 0 if it does not drift */
    struct measured drift;
    struct drag_fit drag;
    struct fit_covariance covariance;
};

/* Kind of fit: by the row's own function, of a scene, or of several modes. */
enum fit_by { FIT_OWN, FIT_SCENE, FIT_MODES };

struct fit_model {
    struct row row; /* damped, sine, … */
    enum fit_by kind;
    bool (*fit)(const struct series *series, struct arena *arena, const struct cancel *cancel,
                struct fit *fit, struct error *error);
};

/*
 * Models of fits; none needs a starting guess. "damped", the first, is the default. "law" is "drag"
 * under the restoring force that BIC prefers. The values of "drag" are those of the best law (by
 * BIC); `preferred` is LAW_UNDECIDED where the data do not decide. Uncertainties are those of least
 * squares, widened for what the residuals share with each parameter (sway, wandering), and for
 * period, omega and gamma by half the difference of the window's halves if it exceeds 2.5 standard
 * deviations. A fit returns false with ERROR_COMMAND if the series does not oscillate, with
 * ERROR_NUMERICAL if it does not converge. GSL's error handler is off (base/numeric.c).
 */
extern const struct catalog fit_catalog;
/* Finds a row by exact name or alias. Returns NULL if there is none. */
const struct fit_model *fit_model_by_name(struct text name);
const struct fit_model *fit_model_at(size_t i);
/* Returns the fit_model that row, one of the catalog's, belongs to. */
const struct fit_model *fit_model_from(const struct row *row);

/* Computes the model's values [n] at n ascending times t [s], not counted from t0. Values are NAN
 * from where the motion of a law cannot be integrated. */
void fit_values(const struct fit *fit, const double *t, size_t n, double *value);
/* Returns k = m (omega^2 + gamma^2/4) with the uncertainties of the mass and the fit. */
struct measured fit_stiffness(const struct fit *fit, struct measured mass);

/* ---- modes: several damped sines at once ---- */

#define MODES_MAX LIMIT_MODES

struct normal_mode {
    struct measured frequency; /* [Hz] the damped one: omega/(2 pi) */
    struct measured gamma;     /* [1/s] its amplitude falls as exp(-gamma t/2) */
    struct measured amplitude; /* as y */
    struct measured phase;     /* [rad] at the first sample */
};

struct modes_fit {
    /* Offset, its drift, rms, warnings and the like; values that each mode has of its own are
     * NAN. */
    struct fit fit;
    int modes;
    struct normal_mode mode[MODES_MAX]; /* the slowest first */
    /* The next three belong to two modes, and are NAN for any other number. */
    struct measured splitting; /* [Hz] */
    /* kc/k of two equal oscillators coupled by kc: omega0^2 = k/m and (k + 2 kc)/m */
    struct measured coupling;
    struct measured stiffness; /* [1/s^2] kc/m */
    double *residual;          /* [n] y - model, from the arena */
};

/*
 * Fits y = c + d t + the sum of `modes` damped sines by least squares, without guesses.
 * Uncertainties are widened, as those of fit_catalog's rows, for what the residuals share with each
 * parameter. Fails with ERROR_NUMERICAL if fewer frequencies stand out of the noise. If it returns
 * true, fit.converged must be checked; a warning tells if two lie too near to each other.
 */
bool series_modes(const struct series *series, int modes, struct arena *arena,
                  const struct cancel *cancel, struct modes_fit *fit, struct error *error);

/* ---- the same quantity, measured several times ---- */

struct repeat {
    int n;
    struct measured mean; /* unweighted, with uncertainty scatter/sqrt(n) */
    double scatter;       /* standard deviation of one */
    /* weighted by the stated uncertainties, and what follows from these alone; NAN if one states
     * none */
    struct measured weighted;
    double birge;  /* sqrt(chi2/(n - 1)): how many times the scatter is what was stated */
    double chance; /* that stated uncertainties which are right scatter so much */
    /* standard deviation to be added to each, so that they explain the scatter; may be 0 */
    double excess_scatter;
    struct measured quote; /* weighted with both: what should be quoted */
    double interval;       /* half of its 95 % interval (Student) */
};

/* Averages repeated values (Birge 1932, Paule and Mandel 1982). Returns false for fewer than two.
 */
bool repeat_values(const struct measured *x, int n, struct repeat *repeat);
