/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Nonlinear least squares for any model. Rows of derivatives and residuals are reduced to a
 * triangle (the R of a QR factorisation) in blocks, so that no matrix of a recording's length is
 * stored. The triangle yields the steps, the parameters in which the model is linear, and the
 * covariances. */
#pragma once

#include "modules/recording/fit/fit.h"

struct cancel;

/* Columns of a triangle (parameters and the residual), and rows that are added at once. */
enum { TRIANGLE_COLUMNS = CURVE_PARAMETERS + 1, TRIANGLE_ROWS = 128 };

/* R of the QR factorisation of rows [n + 1]: the derivatives by n parameters, then the residual
 * data - model. The squares of the last column add up to the sum of squares; those from row k on
 * are the sum of squares that remains if the first k parameters are solved for. */
struct triangle {
    int n;       /* number of parameters */
    size_t rows; /* number of samples with weight that were added */
    double r[TRIANGLE_COLUMNS][TRIANGLE_COLUMNS];
};

/* Adds up to TRIANGLE_ROWS rows [rows][n + 1] to the triangle. They are stored in `block` from row
 * n + 1 on; the space before them is work space, and all of it is overwritten (Golub & Van Loan,
 * 5.3.2). */
void triangle_add(struct triangle *triangle, double *block, size_t rows);
/* Computes the triangle from the products [n + 1][width] of all columns (upper part), by Cholesky
 * factorisation. `independent` is the smallest share of a column's square that must be independent
 * of the columns before it; a column with less gets a row of zeros. Returns false if there is such
 * a column, or if a product is not finite. */
bool triangle_of_products(struct triangle *triangle, int n, int width, const double *product,
                          double independent);
/* Returns the sum of squares that remains if the first `solved` parameters are solved for. */
double triangle_squares(const struct triangle *triangle, int solved);
/* Sets inverse [n][width] to (R^T R)^-1. Returns false if a column is zero or depends on the
 * others. */
bool triangle_inverse(const struct triangle *triangle, int width, double *inverse);

/* Returns a^T M b of vectors [n] and a matrix [n][width]: covariances of linear combinations. */
double quadratic_form(int n, int width, const double *a, const double *matrix, const double *b);

/* The linearised problem of a triangle in its free parameters with index >= first, by singular
 * value decomposition. */
struct linear_problem {
    /* Number of free parameters, and their indices in the triangle. */
    int first, free, index[CURVE_PARAMETERS];
    double scale[CURVE_PARAMETERS];                       /* divisors of the columns */
    double s[CURVE_PARAMETERS], turned[CURVE_PARAMETERS]; /* singular values; U^T r */
    double v[CURVE_PARAMETERS * CURVE_PARAMETERS];        /* right singular vectors [free][free] */
    double min; /* Singular values below this count as 0, as if no column had their direction. */
};

/* Decomposes the triangle's problem in the parameters from `first` on. held [n], or NULL, marks
 * parameters that do not move. scale [n], or NULL for the columns' lengths, divides the columns. */
void linear_problem_of(const struct triangle *triangle, int first, const bool *held,
                       const double *scale, struct linear_problem *problem);
/* Adds the Levenberg-Marquardt step to step [n]; it is the full (Gauss-Newton) step if damping is
 * 0. Returns by how much it lowers the sum of squares of the linear problem. */
double linear_problem_step(const struct linear_problem *problem, double damping, double *step);

/* A model as the descent sees it. */
struct least_squares {
    int parameters;
    /* Number of leading parameters in which the model is linear; they are solved for at each
     * point. */
    int linears;
    const double *low, *high; /* [parameters] bounds, or NULL */
    /* [parameters] sizes of the parameters, or NULL for 1: within 1e-7 of them a parameter is on
     * its bound. */
    const double *unit;
    void *context;
    /* Fills the triangle of the first `columns` parameters at x [parameters]. Returns false if the
     * model has no value there. */
    bool (*linearise)(void *context, const double *x, int columns, struct triangle *triangle);
    /* Fills the triangle with the derivatives at x, and with the second derivative of the residuals
     * along `step` in place of the residuals. NULL for models without acceleration. */
    bool (*curvature)(void *context, const double *x, const double *step,
                      struct triangle *triangle);
};

/* Options of least_squares_descend(). */
struct descent_options {
    /* A full step that promises to gain less than `trust` variances of a residual, or less than
     * `rounding` (in units of the sum of squares), is taken unchecked and is the last. */
    double trust, rounding;
    /* Relative length down to which full steps are refined as long as they shrink, or 0 for the
     * rule above. */
    double exact;
    double damping;   /* Levenberg-Marquardt damping of the first step */
    bool accelerated; /* steps get a geodesic acceleration by the model's curvature */
    bool rescaled;    /* damping scales with the present columns instead of the longest so far */
    /* a minimum may lie in a kink of the sum of squares, where steps do not become small */
    bool kinks;
    int iterations; /* largest number of iterations */
    const struct cancel *cancel;
};

/* State of a descent: the caller sets x and iterations, the rest is the answer. */
struct descent {
    double x[CURVE_PARAMETERS]; /* the start, then the answer */
    double rss;                 /* sum of squares at x */
    bool converged;
    int iterations; /* number of steps, added to what it was */
    /* Triangle of the latest evaluation, which may be one step before x. */
    struct triangle triangle;
};

/* Descends from x to the nearest minimum by Levenberg-Marquardt steps. Returns false if the model
 * has no value at the start, or if cancelled; `converged` tells whether it reached the minimum. */
bool least_squares_descend(const struct least_squares *model, const struct descent_options *options,
                           struct descent *descent);
/* Sets the linear parameters of x to the least-squares values for the given others, and fills the
 * triangle of its first triangle->n parameters. Returns the sum of squares, or NAN if the model has
 * no value or a parameter is not determined. */
double solve_linears(const struct least_squares *model, double *x, struct triangle *triangle);
/* Returns true if x, the value of parameter j, lies on a bound. Sets *inward to the direction away
 * from the bound, 1 or -1. */
bool on_bound(const struct least_squares *model, int j, double x, double *inward);
