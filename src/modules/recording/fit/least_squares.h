/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Least squares of any model: rows of derivatives and residuals are reduced to a triangle, some at
 * a time, so that nothing of the length of a recording has to be stored; the triangle gives the
 * steps, the parameters in which the model is linear, and the covariances.
 */
#pragma once

#include "modules/recording/fit/fit.h"

struct cancel;

enum { TRIANGLE_COLUMNS = CURVE_PARAMETERS + 1, TRIANGLE_ROWS = 128 };

/*
 * R of the QR factorisation of rows [n + 1]: derivatives by n parameters, then the residual data -
 * model. The squares of the last column add up to the sum of squares; below row k they are what is
 * left of it when the first k parameters are solved for.
 */
struct triangle {
    int n;
    size_t rows; /* that count */
    double r[TRIANGLE_COLUMNS][TRIANGLE_COLUMNS];
};

/* Takes up to TRIANGLE_ROWS more rows [rows][n + 1], which stand in `block` from row n + 1 on; the
 * space before is overwritten, too (Golub & Van Loan, 5.3.2). */
void triangle_add(struct triangle *triangle, double *block, size_t rows);
/*
 * The same from the products [n + 1][width] of all columns (their upper part), by Cholesky. A
 * column whose part independent of those before it is less than `independent` of its square has a
 * row of zeros. Returns false if there is one, or a product is no number.
 */
bool triangle_of_products(struct triangle *triangle, int n, int width, const double *product,
                          double independent);
/* Sum of squares once the first `solved` parameters are solved for. */
double triangle_squares(const struct triangle *triangle, int solved);
/* Sets inverse [n][width] to (R^T R)^-1. Returns false where columns are not independent. */
bool triangle_inverse(const struct triangle *triangle, int width, double *inverse);

/* Returns a^T M b of vectors [n] and a matrix [n][width]: covariances of linear combinations. */
double quadratic_form(int n, int width, const double *a, const double *matrix, const double *b);

/* The linear problem of a triangle in its free parameters, from `first` on: singular values. */
struct linear_problem {
    int first, free, index[CURVE_PARAMETERS];
    double scale[CURVE_PARAMETERS];                       /* divisors of the columns */
    double s[CURVE_PARAMETERS], turned[CURVE_PARAMETERS]; /* U^T r */
    double v[CURVE_PARAMETERS * CURVE_PARAMETERS];        /* [free][free] */
    double min; /* singular values below are those of directions that no column has */
};

/* held [n], or NULL: parameters that stay. scale [n], or NULL: the columns' lengths. */
void linear_problem_of(const struct triangle *triangle, int first, const bool *held,
                       const double *scale, struct linear_problem *problem);
/* Adds the step of Levenberg and Marquardt, the full one where damping is 0, to step [n]. Returns
 * by how much it lowers the sum of squares of the linear problem. */
double linear_problem_step(const struct linear_problem *problem, double damping, double *step);

struct least_squares {
    int parameters;
    /* number of leading parameters in which it is linear; they are solved for at each point */
    int linears;
    const double *low, *high; /* [parameters] or NULL */
    const double *unit; /* [parameters] sizes of which 1e-7 counts as being on a bound, or NULL */
    void *context;
    /* Fills the triangle of the first `columns` parameters at x [parameters]. Returns false if the
     * model has no value there. */
    bool (*linearise)(void *context, const double *x, int columns, struct triangle *triangle);
    /* The same with the second derivative of the residuals along a step in place of these. NULL for
     * models that are never accelerated. */
    bool (*curvature)(void *context, const double *x, const double *step,
                      struct triangle *triangle);
};

struct descent_options {
    /* A full step that promises less than `trust` variances of a residual, or less than `rounding`
     * of the sum of squares, is taken unchecked, and is the last. */
    double trust, rounding;
    double exact; /* relative length to which full steps are refined as long as they shrink, or 0 */
    double damping;   /* damping of the first step */
    bool accelerated; /* steps follow the model's curvature */
    bool rescaled;    /* damping is that of the present columns, else of the longest so far */
    bool kinks;     /* a minimum may lie in a kink of the sum of squares, where no step is small */
    int iterations; /* largest number of iterations */
    const struct cancel *cancel;
};

struct descent {
    double x[CURVE_PARAMETERS]; /* the start, then the answer */
    double rss;
    bool converged;
    int iterations;           /* steps, which are counted on */
    struct triangle triangle; /* triangle of the latest evaluation, before a last step to x */
};

/* Goes from x to the nearest minimum. Returns false if the model has no value at the start, or if
 * cancelled. */
bool least_squares_descend(const struct least_squares *model, const struct descent_options *options,
                           struct descent *descent);
/* Sets the linear parameters at x to the best for the others. Returns the sum of squares, NAN where
 * the model has no value. */
double solve_linears(const struct least_squares *model, double *x, struct triangle *triangle);
/* `inward` is the direction away from the bound, 1 or -1. */
bool on_bound(const struct least_squares *model, int j, double x, double *inward);
