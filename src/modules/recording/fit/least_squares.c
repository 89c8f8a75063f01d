/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Levenberg-Marquardt steps (with Moré's scaling) from the triangle of each point. Linear
 * parameters are projected out (Golub & Pereyra 2003, Inverse Problems 19 R1; derivatives in
 * Kaufman's form, BIT 15, 1975): the rows of the triangle below theirs are the problem in the
 * others. */
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include "modules/recording/fit/least_squares.h"

#include <gsl/gsl_linalg.h>
#include <math.h>
#include <string.h>

/* Spacing of doubles at 1. */
static const double epsilon = 2.220446049250313e-16;

/* ---- the triangle ---- */

/* Adds rows of the block to the triangle of a QR factorisation. The block has room for the
 * triangle, n + 1 rows, before the new ones, and is overwritten. */
void triangle_add(struct triangle *t, double *block, size_t rows)
{
    const size_t w = (size_t)t->n + 1;
    double work[TRIANGLE_COLUMNS];
    gsl_matrix_view a = gsl_matrix_view_array(block, w + rows, w);
    gsl_vector_view tau = gsl_vector_view_array(work, w);
    for (size_t i = 0; i < w; i++)
        for (size_t j = 0; j < w; j++)
            block[i * w + j] = j < i ? 0 : t->r[i][j];
    gsl_linalg_QR_decomp(&a.matrix, &tau.vector);
    for (size_t i = 0; i < w; i++)
        memcpy(&t->r[i][i], block + i * w + i, (w - i) * sizeof *block);
}

/* Computes the triangle from the products [n + 1][width] of n columns and the residual, by a
 * Cholesky factorisation with columns scaled to length 1. Returns false if a pivot is below
 * `independent`, so that a column depends on others. */
bool triangle_of_products(struct triangle *t, int n, int width, const double *product,
                          double independent)
{
    double scale[TRIANGLE_COLUMNS];
    bool all = true;
    t->n = n;
    for (int i = 0; i <= n; i++) {
        const double square = product[i * width + i];
        scale[i] = i < n && square > 0 ? sqrt(square) : 1;
        all = all && (square > 0 || i == n) && isfinite(square);
    }
    for (int i = 0; i <= n; i++) {
        double pivot = 0;
        for (int j = i; j <= n; j++) {
            double sum = product[i * width + j] / (scale[i] * scale[j]);
            for (int k = 0; k < i; k++)
                sum -= t->r[k][i] * t->r[k][j];
            if (j == i) {
                const double min = i < n ? independent : 0;
                pivot = sum > min ? sqrt(sum) : 0;
                all = all && (pivot > 0 || i == n);
                t->r[i][i] = pivot;
            } else {
                t->r[i][j] = pivot > 0 ? sum / pivot : 0;
            }
        }
    }
    for (int i = 0; i < n; i++)
        for (int j = i; j < n; j++)
            t->r[i][j] *= scale[j];
    return all;
}

/* Sums the squares of the last column below the rows that are solved. */
double triangle_squares(const struct triangle *t, int solved)
{
    double sum = 0;
    for (int i = solved; i <= t->n; i++)
        sum += t->r[i][t->n] * t->r[i][t->n];
    return sum;
}

/* Computes inverse [n][width], the inverse of the normal equations, by back substitution. Returns
 * false if the triangle is singular. */
bool triangle_inverse(const struct triangle *t, int width, double *inverse)
{
    double turned[CURVE_PARAMETERS][CURVE_PARAMETERS] = {{0}};
    for (int j = 0; j < t->n; j++) {
        if (t->r[j][j] == 0)
            return false;
        turned[j][j] = 1 / t->r[j][j];
        for (int i = j - 1; i >= 0; i--) {
            for (int k = i + 1; k <= j; k++)
                turned[i][j] -= t->r[i][k] * turned[k][j];
            turned[i][j] /= t->r[i][i];
        }
    }
    for (int i = 0; i < t->n; i++)
        for (int j = 0; j < t->n; j++) {
            double sum = 0;
            for (int k = i > j ? i : j; k < t->n; k++)
                sum += turned[i][k] * turned[j][k];
            inverse[i * width + j] = sum;
        }
    return true;
}

double quadratic_form(int n, int width, const double *a, const double *matrix, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum += a[i] * matrix[i * width + j] * b[j];
    return sum;
}

/* ---- the linear problem ---- */

/* Returns the Euclidean norm of column j. */
static double column_length(const struct triangle *t, int j)
{
    double length = 0;
    for (int i = 0; i <= j; i++)
        length = hypot(length, t->r[i][j]);
    return length;
}

/* Decomposes the columns of the triangle from `first` on, without those held, scaled by `scale`
 * (NULL for their lengths), by singular values into *p. */
void linear_problem_of(const struct triangle *t, int first, const bool *held, const double *scale,
                       struct linear_problem *p)
{
    const int n = t->n, rows = n - first;
    double a[CURVE_PARAMETERS * CURVE_PARAMETERS];
    *p = (struct linear_problem){.first = first};
    for (int j = first; j < n; j++)
        if (!(held && held[j])) {
            const double length = scale ? scale[j] : column_length(t, j);
            p->scale[p->free] = length > 0 ? length : 1;
            p->index[p->free++] = j;
        }
    const int m = p->free;
    if (m == 0)
        return;
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < m; k++)
            a[i * m + k] = p->index[k] < first + i ? 0 : t->r[first + i][p->index[k]] / p->scale[k];
    gsl_matrix_view u = gsl_matrix_view_array(a, (size_t)rows, (size_t)m),
                    v = gsl_matrix_view_array(p->v, (size_t)m, (size_t)m);
    gsl_vector_view s = gsl_vector_view_array(p->s, (size_t)m);
    /* The other algorithm of GSL allocates memory and does not check for failure; one-sided
     * rotations (Jacobi) do not allocate. */
    gsl_linalg_SV_decomp_jacobi(&u.matrix, &v.matrix, &s.vector);
    for (int k = 0; k < m; k++)
        for (int i = 0; i < rows; i++)
            p->turned[k] += a[i * m + k] * t->r[first + i][n];
    p->min = fmin(8 * epsilon * (double)(t->rows + (size_t)m), 1e-10) * p->s[0];
}

/* Adds to step[] the Levenberg-Marquardt step for that damping along each singular direction that
 * the data determine. Returns the reduction of the sum of squares that the step predicts. */
double linear_problem_step(const struct linear_problem *p, double damping, double *step)
{
    double gain = 0;
    for (int k = 0; k < p->free; k++) {
        if (!(p->s[k] > p->min))
            continue;
        const double square = p->s[k] * p->s[k] + damping, kept = damping / square,
                     part = p->turned[k] * p->s[k] / square;
        for (int i = 0; i < p->free; i++)
            step[p->index[i]] += p->v[i * p->free + k] * part / p->scale[i];
        gain += p->turned[k] * p->turned[k] * (1 - kept * kept);
    }
    return gain;
}

/* ---- the descent ---- */

/* Compares the distance from either bound with a tolerance in the parameter's unit. */
bool on_bound(const struct least_squares *m, int j, double x, double *inward)
{
    const double tolerance = 1e-7 * (m->unit ? m->unit[j] : 1);
    const bool low = m->low && x - m->low[j] <= tolerance,
               high = m->high && m->high[j] - x <= tolerance;
    *inward = low ? 1 : -1;
    return low || high;
}

/* Moves the linear parameters of x to their minimum by back substitution in the triangle at x.
 * Returns the sum of squares then, or NAN if the model has no value or they are not determined. */
double solve_linears(const struct least_squares *m, double *x, struct triangle *t)
{
    const int solved = m->linears;
    double step[CURVE_PARAMETERS] = {0};
    if (!m->linearise(m->context, x, t->n, t))
        return NAN;
    for (int i = solved - 1; i >= 0; i--) {
        double sum = t->r[i][t->n];
        for (int j = i + 1; j < solved; j++)
            sum -= t->r[i][j] * step[j];
        step[i] = sum / t->r[i][i];
        x[i] += step[i];
    }
    const double rss = triangle_squares(t, solved);
    for (int i = 0; i < solved; i++)
        if (!isfinite(x[i]) || !(fabs(t->r[i][i]) > 1e-12 * column_length(t, i)))
            return NAN; /* is not determined */
    return rss;
}

/* Work of a descent at its present point. */
struct descent_work {
    const struct least_squares *model;
    bool forgets; /* scale is that of the present columns, instead of the largest so far */
    double scale[CURVE_PARAMETERS];
    bool held[CURVE_PARAMETERS]; /* parameters held on their bounds */
    struct linear_problem problem;
};

/* Prepares the linear problem at the present point: holds parameters that are on a bound and pulled
 * outward, and updates the scales. */
static void prepare_linear_problem(struct descent_work *w, const struct descent *d)
{
    const struct least_squares *m = w->model;
    const struct triangle *t = &d->triangle;
    for (int j = m->linears; j < m->parameters; j++) {
        double inward, pull = 0;
        w->held[j] = on_bound(m, j, d->x[j], &inward);
        if (w->held[j]) {
            for (int i = 0; i <= j; i++)
                pull += t->r[i][j] * t->r[i][t->n];
            w->held[j] = !(inward * pull > 0);
        }
        w->scale[j] = fmax(w->forgets ? 0 : w->scale[j], column_length(t, j));
    }
    linear_problem_of(t, m->linears, w->held, w->scale, &w->problem);
}

/* Moves the free parameters of x by step, within the bounds; `variance` is that of a residual.
 * Returns the largest component of the step, relative to the value or, if larger, its
 * uncertainty. */
static double least_squares_move(const struct least_squares *m, const struct linear_problem *p,
                                 const double *step, double variance, double *x)
{
    double length = 0;
    for (int k = 0; k < p->free; k++) {
        const int j = p->index[k];
        double inverse = 0;
        for (int i = 0; i < p->free; i++)
            if (p->s[i] > p->min)
                inverse = hypot(inverse, p->v[k * p->free + i] / p->s[i]);
        length =
            fmax(length, fabs(step[j]) / fmax(fabs(x[j]), sqrt(variance) * inverse / p->scale[k]));
        x[j] += step[j];
        x[j] = m->low ? fmax(x[j], m->low[j]) : x[j];
        x[j] = m->high ? fmin(x[j], m->high[j]) : x[j];
    }
    return length;
}

/* Returns the length of a step with each component scaled as in the damping. */
static double scaled_length(const struct descent_work *w, const double *step)
{
    double length = 0;
    for (int k = 0; k < w->problem.free; k++)
        length = hypot(length, w->problem.scale[k] * step[w->problem.index[k]]);
    return length;
}

/* Adds half the geodesic acceleration to the step from x (Transtrum & Sethna 2012). Returns false
 * if the model has no value there or the acceleration is too large beside the step. */
static bool accelerate(const struct descent_work *w, const double *x, double damping, double *step)
{
    static const double ratio_max = 0.75;
    const struct least_squares *m = w->model;
    struct triangle t;
    struct linear_problem bent;
    double more[CURVE_PARAMETERS] = {0};
    if (!m->curvature(m->context, x, step, &t))
        return false;
    linear_problem_of(&t, 0, w->held, w->scale, &bent);
    linear_problem_step(&bent, damping, more);
    if (!(2 * scaled_length(w, more) <= ratio_max * scaled_length(w, step)))
        return false;
    for (int k = 0; k < bent.free; k++)
        step[bent.index[k]] += 0.5 * more[bent.index[k]];
    return true;
}

/* Returns the factor of the damping after a successful step; ratio is actual over predicted gain
 * (Nielsen 1999, IMM-REP-1999-05). */
static double relaxation(double ratio)
{
    const double excess = 2 * ratio - 1;
    return fmax(1.0 / 3, 1 - excess * excess * excess);
}

/* Descends by the Levenberg-Marquardt method from d->x: each round solves the linear problem, tries
 * the step, and accepts it if the sum of squares falls, else raises the damping. Near the end, full
 * steps are refined. d->converged tells the success. Returns false if the model has no value at the
 * start or if cancelled. */
bool least_squares_descend(const struct least_squares *m, const struct descent_options *o,
                           struct descent *d)
{
    enum { SMALL_MAX = 4 };
    static const double tolerance = 1e-8, damping_max = 1e16, damping_kink = 1e8, stalls = 1e2;
    struct descent_work w = {.model = m, .forgets = o->rescaled};
    double damping = o->damping, raise = 2, shortest = INFINITY;
    bool refused = false, /* the full step that should have been one of the last */
        fresh = false;    /* derivatives are those at the present linear parameters */
    int small = 0;        /* steps in a row that gain less than a hundredth of a variance */
    d->converged = false;
    d->triangle.n = m->parameters;
    d->rss = solve_linears(m, d->x, &d->triangle);
    if (!isfinite(d->rss))
        return false;
    prepare_linear_problem(&w, d);
    while (d->iterations < o->iterations && damping <= damping_max) {
        struct descent trial = *d;
        double full[CURVE_PARAMETERS] = {0}, step[CURVE_PARAMETERS] = {0};
        /* unit is the variance of a residual, left the gain that the full step promises. */
        const double unit = d->rss / (double)d->triangle.rows,
                     left = linear_problem_step(&w.problem, 0, full);
        const bool exact = o->exact > 0,
                   last = !exact && left <= fmax(o->trust * unit, o->rounding),
                   ends = exact && !refused && left <= fmax(tolerance * unit, o->rounding);
        if (cancelled(o->cancel))
            return false;
        const double promised = linear_problem_step(&w.problem, ends ? 0 : damping, step);
        /* If the acceleration fails (bends), the step counts as one without a value. */
        const bool bends = o->accelerated && !ends && !accelerate(&w, d->x, damping, step);
        const double length = least_squares_move(m, &w.problem, last ? full : step, unit, trial.x);
        if (last) {
            memcpy(d->x, trial.x, sizeof d->x);
            d->rss = fmax(d->rss - left, 0);
        }
        d->converged = last || (ends && (length <= o->exact || (length >= 0.9 * shortest &&
                                                                length <= stalls * o->exact)));
        if (d->converged)
            break;
        trial.rss = bends ? NAN : solve_linears(m, trial.x, &trial.triangle);
        const double gained = d->rss - trial.rss;
        /* Accept the step if it gains; near the end, if it loses no more than rounding. */
        if (gained >= (ends ? -(o->rounding + 1e-12 * d->rss) : 0)) {
            small = gained < 0.01 * unit ? small + 1 : 0;
            shortest = ends ? length : INFINITY;
            refused = fresh = false;
            if (!ends)
                damping = damping > 1e-12 ? damping * relaxation(gained / promised) : 0;
            raise = 2;
            trial.iterations++;
            *d = trial;
            prepare_linear_problem(&w, d);
        } else if (ends) {
            d->converged = length <= stalls * o->exact;
            refused = true;
        } else if (m->linears > 0 && !fresh) {
            /* the derivatives by the others are those with the linear parameters before */
            d->rss = solve_linears(m, d->x, &d->triangle);
            prepare_linear_problem(&w, d);
            fresh = true;
        } else {
            damping = fmax(raise * damping, 1e-6);
            raise *= 2;
        }
        d->converged = d->converged || (o->kinks && (damping > damping_kink || small >= SMALL_MAX));
        if (d->converged)
            break;
    }
    return true;
}
