/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The damped sine y = c + d s + exp(-gamma s/2) (a cos(omega s) + b sin(omega s)): variable
 * projection with Levenberg–Marquardt.
 *
 * One pass over the samples accumulates the products of the columns [u v 1 s | dy/domega dy/dgamma
 * | r]. The Cholesky factor of that small matrix is the R of the QR factorisation of the n-row
 * problem: its last rows are the problem in (omega, gamma) after the linear parameters have been
 * projected out (Kaufman's variable projection, Golub & Pereyra 2003, Inverse Problems 19 R1,
 * section 4). Forming products squares the condition number, which is small here: the columns are
 * scaled, the origin lies at the weight of the amplitude, what is fitted is the residual of the
 * current model (so rounding is corrected by the next iteration), and a factor worse than PIVOT_MIN
 * is refused. No matrix with n rows is ever stored.
 */
#include <hooke/base/cancel.h>
#include "modules/recording/fit/least_squares.h"
#include "modules/recording/series/internal.h"

#include <math.h>
#include <string.h>

/* Samples that are summed at once, columns of the problem, and iterations at most. */
enum { CHUNK = 64, COLUMNS = HARMONIC_PARAMETERS + 1, PASSES = 40 };

#define PIVOT_MIN 1e-10 /* squared sine of the angle between a column and those before it */

typedef double four __attribute__((vector_size(32)));

/* Values of one chunk of samples, as numbers and as vectors. */
union block {
    double d[CHUNK];
    four p[CHUNK / 4];
};

/* exp((-gamma/2 + i omega) k dt) for the samples k of a chunk. Each chunk starts from an exact
 * phase, so that no error accumulates along the series. */
struct phase_table {
    double re[CHUNK], im[CHUNK];
};

/* Returns the scalar product of two blocks. Eight accumulators let additions overlap; the order of
 * the sums is fixed, so that every compiler gives the same bits. */
static inline double block_dot(const union block *x, const union block *y)
{
    four a = {0, 0, 0, 0}, b = a;
    for (int k = 0; k < CHUNK / 4; k += 2) {
        a += x->p[k] * y->p[k];
        b += x->p[k + 1] * y->p[k + 1];
    }
    return ((a[0] + a[2]) + (b[0] + b[2])) + ((a[1] + a[3]) + (b[1] + b[3]));
}

/* Fills the phase table for samples that are dt apart. */
static void phase_table_init(struct phase_table *turn, const struct harmonic *h, double dt)
{
    double e = exp(-0.5 * h->gamma * dt), re = e * cos(h->omega * dt), im = e * sin(h->omega * dt);
    turn->re[0] = 1;
    turn->im[0] = 0;
    for (int k = 1; k < CHUNK; k++) {
        turn->re[k] = turn->re[k - 1] * re - turn->im[k - 1] * im;
        turn->im[k] = turn->re[k - 1] * im + turn->im[k - 1] * re;
    }
}

/* Fills u + i v = exp((-gamma/2 + i omega) s) and s = t - origin for the CHUNK samples from `first`
 * on, of which `count` exist. At equal steps the table `turn` of phases replaces sines and
 * cosines. */
static inline void fill_basis(const struct samples *x, size_t first, int count,
                              const struct harmonic *h, const struct phase_table *turn,
                              union block *u, union block *v, union block *s)
{
    if (x->uniform) {
        double start = x->t0 + (double)first * x->dt - h->origin, e = exp(-0.5 * h->gamma * start);
        double re = e * cos(h->omega * start), im = e * sin(h->omega * start);
        for (int k = 0; k < CHUNK; k++) {
            u->d[k] = re * turn->re[k] - im * turn->im[k];
            v->d[k] = re * turn->im[k] + im * turn->re[k];
            s->d[k] = start + (double)k * x->dt;
        }
        return;
    }
    for (int k = 0; k < CHUNK; k++) {
        double time = k < count ? x->t[first + (size_t)k] - h->origin : 0,
               e = exp(-0.5 * h->gamma * time);
        u->d[k] = e * cos(h->omega * time);
        v->d[k] = e * sin(h->omega * time);
        s->d[k] = time;
    }
}

/* Computes the products of the model's first `unknowns` columns and of the residual (the last
 * column) over all samples in use, and unless NULL the residuals. Returns the number of samples
 * used, or 0 if cancelled. */
CLONES static size_t gram_products(const struct samples *x, int unknowns, const struct harmonic *h,
                                   double gram[COLUMNS][COLUMNS], double *residual)
{
    union block u, v, mask, s, drift = {{0}}, by_omega, by_gamma, r;
    const union block *column[COLUMNS] = {&u, &v, &mask, &drift, &by_omega, &by_gamma};
    struct phase_table turn;
    size_t used = 0;
    column[unknowns] = &r;
    if (x->uniform)
        phase_table_init(&turn, h, x->dt);
    memset(gram, 0, sizeof(double[COLUMNS][COLUMNS]));
    for (size_t first = 0; first < x->n; first += CHUNK) {
        if (first % LOOK_EACH_ROWS == 0 && cancelled(x->cancel))
            return 0;
        int count = x->n - first < CHUNK ? (int)(x->n - first) : CHUNK;
        fill_basis(x, first, count, h, &turn, &u, &v, &s);
        for (int k = 0; k < count; k++) {
            r.d[k] = x->y[first + (size_t)k] - h->c - h->d * s.d[k] - h->a * u.d[k] - h->b * v.d[k];
            mask.d[k] = x->use[first + (size_t)k];
            used += x->use[first + (size_t)k];
        }
        if (residual)
            memcpy(residual + first, r.d, (size_t)count * sizeof(double));
        for (int k = count; k < CHUNK; k++)
            r.d[k] = mask.d[k] = 0;
        for (int k = 0; k < CHUNK / 4; k++) {
            u.p[k] *= mask.p[k];
            v.p[k] *= mask.p[k];
            r.p[k] *= mask.p[k];
        }
        for (int k = 0; k < CHUNK / 4 && unknowns > RATE_OMEGA; k++)
            by_omega.p[k] = s.p[k] * (h->b * u.p[k] - h->a * v.p[k]);
        for (int k = 0; k < CHUNK / 4 && unknowns > RATE_GAMMA; k++)
            by_gamma.p[k] = -0.5 * s.p[k] * (h->a * u.p[k] + h->b * v.p[k]);
        for (int k = 0; k < CHUNK / 4 && h->drifts; k++)
            drift.p[k] = s.p[k] * mask.p[k];
        for (int i = 0; i <= unknowns; i++)
            for (int j = i; j <= unknowns; j++)
                if (h->drifts || (column[i] != &drift && column[j] != &drift))
                    gram[i][j] += block_dot(column[i], column[j]);
    }
    if (unknowns > LINEAR_D && !h->drifts)
        gram[LINEAR_D][LINEAR_D] = 1; /* a column that touches no other */
    return used;
}

double harmonic_sigma(const struct harmonic *h, int unknowns)
{
    size_t fitted = (size_t)unknowns - !h->drifts;
    return h->used > fitted ? sqrt(h->rss / (double)(h->used - fitted)) : NAN;
}

bool harmonic_residuals(const struct samples *x, const struct harmonic *harmonic, double *residual)
{
    return gram_products(x, 0, harmonic, (double[COLUMNS][COLUMNS]){{0}}, residual) > 0;
}

/* Context of the least-squares problem of one damped sine. */
struct harmonic_problem {
    const struct samples *samples;
    const struct harmonic *start; /* origin, and whether it drifts */
    double span;                  /* [s] */
};

/* Returns the harmonic with the parameters x, and origin and drift as in `start`. */
static struct harmonic harmonic_at(const struct harmonic *start, const double *x)
{
    struct harmonic h = *start;
    h.a = x[LINEAR_A];
    h.b = x[LINEAR_B];
    h.c = x[LINEAR_C];
    h.d = x[LINEAR_D];
    h.omega = x[RATE_OMEGA];
    h.gamma = x[RATE_GAMMA];
    return h;
}

/* Fills the triangle of the first `columns` parameters at x (see struct least_squares). Returns
 * false for parameters that are not physical, or where the columns are not independent. */
static bool linearise(void *context, const double *x, int columns, struct triangle *t)
{
    const struct harmonic_problem *p = context;
    const struct harmonic h = harmonic_at(p->start, x);
    double gram[COLUMNS][COLUMNS];
    /* exp(600) is near the largest double */
    if (!(h.omega > 0) || !(fabs(h.gamma) * p->span < 600))
        return false;
    t->rows = gram_products(p->samples, columns, &h, gram, NULL);
    return t->rows > (size_t)columns - !h.drifts &&
           triangle_of_products(t, columns, COLUMNS, &gram[0][0], PIVOT_MIN);
}

/* Solves for the linear parameters a, b, c, d alone, at given omega and gamma. Returns false if
 * they are not determined. */
static bool fit_linear(struct harmonic_problem *p, struct descent *d)
{
    const struct least_squares model = {
        .linears = FREE_LINEAR, .context = p, .linearise = linearise};
    d->triangle.n = FREE_LINEAR;
    d->rss = solve_linears(&model, d->x, &d->triangle);
    d->converged = isfinite(d->rss);
    return d->converged;
}

/* Fits the free parameters (`wanted`) of a damped sine with offset to the samples in use; *result
 * is the start and becomes the result. Without a start (amplitude 0) the linear parameters are
 * found first. Sets residual [n] unless NULL. Returns false if not determined or cancelled. */
bool harmonic_fit(const struct samples *x, enum harmonic_free wanted, struct harmonic *result,
                  double *residual)
{
    /* A step of less than a thousandth of a standard deviation, or one that only changes rounding
     * errors, is the last. */
    static const double trust = 1e-6, rounding = 1e-26;
    const int unknowns = (int)wanted;
    const bool linear = wanted == FREE_LINEAR, cold = result->a == 0 && result->b == 0;
    if (x->n == 0 || cancelled(x->cancel))
        return false;
    struct harmonic_problem p = {x, result, x->t[x->n - 1] - x->t[0]};
    struct descent d = {
        .x = {result->a, result->b, result->c, result->d, result->omega, result->gamma}};
    if (cold)
        d.x[LINEAR_C] = x->y[0];
    /* If there is no start, a linear fit is made first: later residuals are then small, and so is
     * their rounding. */
    if ((cold && !fit_linear(&p, &d)) || (linear && !(cold && !residual) && !fit_linear(&p, &d)))
        return false;
    const double size = d.x[LINEAR_A] * d.x[LINEAR_A] + d.x[LINEAR_B] * d.x[LINEAR_B] +
                        d.x[LINEAR_C] * d.x[LINEAR_C];
    const struct least_squares model = {
        .parameters = unknowns, .linears = FREE_LINEAR, .context = &p, .linearise = linearise};
    const struct descent_options options = {.trust = trust,
                                            .rounding = rounding * (double)x->n * size,
                                            .iterations = PASSES,
                                            .cancel = x->cancel};
    if (!linear && !least_squares_descend(&model, &options, &d))
        return false;
    struct harmonic h = harmonic_at(result, d.x);
    h.rss = d.rss;
    h.used = d.triangle.rows;
    h.iterations = d.iterations;
    h.converged = d.converged;
    memset(h.inverse, 0, sizeof h.inverse);
    if (!triangle_inverse(&d.triangle, HARMONIC_PARAMETERS, &h.inverse[0][0]))
        return false;
    if (!h.drifts)
        h.inverse[LINEAR_D][LINEAR_D] = 0;
    if (residual && !harmonic_residuals(x, &h, residual))
        return false;
    *result = h;
    return true;
}

/* Returns the correlation of neighbouring residuals: the mean of their products relative to the
 * mean square; 0 if there are none. */
double residual_autocorrelation(const struct samples *x, const double *residual)
{
    double product = 0, square = 0;
    size_t pairs = 0, used = x->n > 0 && x->use[0];
    for (size_t i = 0; i < x->n && !cancelled_at(x->cancel, i); i++) {
        square += x->use[i] ? residual[i] * residual[i] : 0;
        if (i > 0 && x->use[i]) {
            used++;
            if (x->use[i - 1]) {
                pairs++;
                product += residual[i] * residual[i - 1];
            }
        }
    }
    return square > 0 && pairs > 0 ? (product / (double)pairs) / (square / (double)used) : 0;
}

/* A negative rho counts as 0; the upper limit keeps the factor finite. */
double autocorrelation_factor(double rho)
{
    rho = fmin(fmax(rho, 0), 0.9999);
    return (1 + rho) / (1 - rho);
}

/* Returns the factor by which the variance of the slope of a line through n samples is larger than
 * for independent residuals, from their lag-1 correlation rho: 1 if rho may be chance, that of a
 * random walk if rho is near 1, else that of an autoregressive process. */
double line_correlation_factor(double rho, double n)
{
    /* A correlation below two standard deviations is chance; one near that of a random walk is
     * treated as one. The variance of a random walk about a line is n/15 of that of a step. */
    static const double chance = 2, walk_factor = 1.5;
    const double walk = 1 - 7.5 / n;
    if (!(rho > chance / sqrt(n)))
        return 1;
    return rho > 0.7 * walk ? fmax(walk_factor * n, autocorrelation_factor(rho))
                            : autocorrelation_factor(rho);
}
