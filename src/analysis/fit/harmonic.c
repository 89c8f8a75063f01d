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
#include "analysis/internal.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 64, COLUMNS = HARMONIC_PARAMETERS + 1, PASSES = 40 };

#define PIVOT_MIN 1e-10 /* squared sine of the angle between a column and those before it */

typedef double four __attribute__((vector_size(32)));

union block {
    double d[CHUNK];
    four p[CHUNK / 4];
};

/* exp((-gamma/2 + i omega) k dt): a chunk starts from an exact phase, so no error accumulates along
 * the series. */
struct phase_table {
    double re[CHUNK], im[CHUNK];
};

/* Eight accumulators, so that additions overlap; the order of the sums is fixed, whatever the
 * compiler makes of it. */
static inline double dot(const union block *x, const union block *y)
{
    four a = {0, 0, 0, 0}, b = a;
    for (int k = 0; k < CHUNK / 4; k += 2) {
        a += x->p[k] * y->p[k];
        b += x->p[k + 1] * y->p[k + 1];
    }
    return ((a[0] + a[2]) + (b[0] + b[2])) + ((a[1] + a[3]) + (b[1] + b[3]));
}

static void turn_init(struct phase_table *turn, const struct harmonic *h, double dt)
{
    double e = exp(-0.5 * h->gamma * dt), re = e * cos(h->omega * dt), im = e * sin(h->omega * dt);
    turn->re[0] = 1;
    turn->im[0] = 0;
    for (int k = 1; k < CHUNK; k++) {
        turn->re[k] = turn->re[k - 1] * re - turn->im[k - 1] * im;
        turn->im[k] = turn->re[k - 1] * im + turn->im[k - 1] * re;
    }
}

/* u + i v = exp((-gamma/2 + i omega) s) and s for the samples from `at` on; `count` of them exist.
 */
static inline void fill_basis(const struct samples *x, size_t at, int count,
                              const struct harmonic *h, const struct phase_table *turn,
                              union block *u, union block *v, union block *s)
{
    if (x->uniform) {
        double start = x->t0 + (double)at * x->dt - h->origin, e = exp(-0.5 * h->gamma * start);
        double re = e * cos(h->omega * start), im = e * sin(h->omega * start);
        for (int k = 0; k < CHUNK; k++) {
            u->d[k] = re * turn->re[k] - im * turn->im[k];
            v->d[k] = re * turn->im[k] + im * turn->re[k];
            s->d[k] = start + (double)k * x->dt;
        }
        return;
    }
    for (int k = 0; k < CHUNK; k++) {
        double time = k < count ? x->t[at + (size_t)k] - h->origin : 0,
               e = exp(-0.5 * h->gamma * time);
        u->d[k] = e * cos(h->omega * time);
        v->d[k] = e * sin(h->omega * time);
        s->d[k] = time;
    }
}

/* Products of the model's first `unknowns` columns and of the residual (the last column). Returns
 * the number of samples used. */
CLONES static size_t products(const struct samples *x, int unknowns, const struct harmonic *h,
                              double gram[COLUMNS][COLUMNS], double *residual)
{
    union block column[COLUMNS], s, mask;
    struct phase_table turn;
    union block *u = &column[LINEAR_A], *v = &column[LINEAR_B], *r = &column[unknowns];
    size_t used = 0;
    if (x->uniform) {
        turn_init(&turn, h, x->dt);
    }
    memset(gram, 0, sizeof(double[COLUMNS][COLUMNS]));
    for (size_t at = 0; at < x->n; at += CHUNK) {
        if (at % LOOK_EACH_ROWS == 0 && cancelled(x->cancel)) {
            return 0;
        }
        int count = x->n - at < CHUNK ? (int)(x->n - at) : CHUNK;
        fill_basis(x, at, count, h, &turn, u, v, &s);
        for (int k = 0; k < count; k++) {
            r->d[k] = x->y[at + (size_t)k] - h->c - h->d * s.d[k] - h->a * u->d[k] - h->b * v->d[k];
            mask.d[k] = x->use[at + (size_t)k];
            used += x->use[at + (size_t)k];
        }
        if (residual) {
            memcpy(residual + at, r->d, (size_t)count * sizeof(double));
        }
        for (int k = count; k < CHUNK; k++) {
            r->d[k] = mask.d[k] = 0;
        }
        for (int k = 0; k < CHUNK / 4; k++) {
            u->p[k] *= mask.p[k];
            v->p[k] *= mask.p[k];
            r->p[k] *= mask.p[k];
        }
        if (unknowns > RATE_OMEGA) {
            union block *w = &column[RATE_OMEGA];
            for (int k = 0; k < CHUNK / 4; k++) {
                w->p[k] = s.p[k] * (h->b * u->p[k] - h->a * v->p[k]);
            }
        }
        if (unknowns > RATE_GAMMA) {
            union block *g = &column[RATE_GAMMA];
            for (int k = 0; k < CHUNK / 4; k++) {
                g->p[k] = -0.5 * s.p[k] * (h->a * u->p[k] + h->b * v->p[k]);
            }
        }
        column[LINEAR_C] = mask;
        for (int k = 0; k < CHUNK / 4 && h->drifts; k++) {
            column[LINEAR_D].p[k] = s.p[k] * mask.p[k];
        }
        for (int i = 0; i <= unknowns; i++) {
            for (int j = i; j <= unknowns; j++) {
                if (h->drifts || (i != LINEAR_D && j != LINEAR_D)) {
                    gram[i][j] += dot(&column[i], &column[j]);
                }
            }
        }
    }
    gram[LINEAR_D][LINEAR_D] += !h->drifts; /* a column that touches no other */
    return used;
}

/* The gram matrix with columns scaled to length one: gram = S R^T R S with R upper triangular, r
 * last. */
struct factor {
    double r[COLUMNS][COLUMNS], scale[COLUMNS];
};

static bool factorise(double gram[COLUMNS][COLUMNS], int unknowns, struct factor *f)
{
    for (int i = 0; i < unknowns; i++) {
        f->scale[i] = sqrt(gram[i][i]);
        if (!(f->scale[i] > 0) || !isfinite(f->scale[i])) {
            return false;
        }
    }
    f->scale[unknowns] = 1;
    for (int i = 0; i <= unknowns; i++) {
        for (int j = i; j <= unknowns; j++) {
            double sum = gram[i][j] / (f->scale[i] * f->scale[j]);
            for (int k = 0; k < i; k++) {
                sum -= f->r[k][i] * f->r[k][j];
            }
            if (j > i) {
                f->r[i][j] = sum / f->r[i][i];
            } else if (i < unknowns) {
                if (!(sum > PIVOT_MIN)) {
                    return false;
                }
                f->r[i][i] = sqrt(sum);
            } else {
                f->r[i][i] = sqrt(fmax(sum, 0)); /* what no step can remove */
            }
        }
    }
    return true;
}

/* (R^T R + lambda D) x = R^T r for the one or two rates; D from R^T R as Moré (1978) has it. */
static void damped_step(const struct factor *f, int unknowns, double lambda, double step[COLUMNS])
{
    step[RATE_OMEGA] = step[RATE_GAMMA] = 0;
    const double *w = f->r[RATE_OMEGA], *g = f->r[RATE_GAMMA];
    double a = w[RATE_OMEGA] * w[RATE_OMEGA], p = w[RATE_OMEGA] * w[unknowns];
    if (unknowns == FREE_OMEGA) {
        step[RATE_OMEGA] = p / (a * (1 + lambda)) / f->scale[RATE_OMEGA];
        return;
    }
    double b = w[RATE_OMEGA] * w[RATE_GAMMA],
           d = w[RATE_GAMMA] * w[RATE_GAMMA] + g[RATE_GAMMA] * g[RATE_GAMMA];
    double q = w[RATE_GAMMA] * w[unknowns] + g[RATE_GAMMA] * g[unknowns];
    a *= 1 + lambda;
    d *= 1 + lambda;
    double det = a * d - b * b;
    step[RATE_OMEGA] = (d * p - b * q) / det / f->scale[RATE_OMEGA];
    step[RATE_GAMMA] = (a * q - b * p) / det / f->scale[RATE_GAMMA];
}

/* (J^T J)^-1 = S^-1 R^-1 R^-T S^-1 */
static void invert(const struct factor *f, int unknowns, bool drifts,
                   double out[HARMONIC_PARAMETERS][HARMONIC_PARAMETERS])
{
    double inverse[COLUMNS][COLUMNS] = {{0}};
    memset(out, 0, sizeof(double[HARMONIC_PARAMETERS][HARMONIC_PARAMETERS]));
    for (int j = 0; j < unknowns; j++) {
        inverse[j][j] = 1 / f->r[j][j];
        for (int i = j - 1; i >= 0; i--) {
            double sum = 0;
            for (int k = i + 1; k <= j; k++) {
                sum -= f->r[i][k] * inverse[k][j];
            }
            inverse[i][j] = sum / f->r[i][i];
        }
    }
    for (int i = 0; i < unknowns; i++) {
        for (int j = 0; j < unknowns; j++) {
            double sum = 0;
            for (int k = i > j ? i : j; k < unknowns; k++) {
                sum += inverse[i][k] * inverse[j][k];
            }
            out[i][j] = sum / (f->scale[i] * f->scale[j]);
        }
    }
    if (!drifts) {
        out[LINEAR_D][LINEAR_D] = 0;
    }
}

double harmonic_sigma(const struct harmonic *h, int unknowns)
{
    size_t fitted = (size_t)unknowns - !h->drifts;
    return h->used > fitted ? sqrt(h->rss / (double)(h->used - fitted)) : NAN;
}

/* What one pass says about a point (omega, gamma): best linear parameters there, its sum of
 * squares, its factor. */
static bool look(const struct samples *x, int unknowns, struct harmonic *h, struct factor *f,
                 double *residual)
{
    double gram[COLUMNS][COLUMNS], step[COLUMNS] = {0};
    h->used = products(x, unknowns, h, gram, residual);
    if (h->used <= (size_t)unknowns - !h->drifts || !factorise(gram, unknowns, f)) {
        return false;
    }
    h->rss = f->r[unknowns][unknowns] * f->r[unknowns][unknowns];
    for (int i = FREE_LINEAR; i < unknowns; i++) {
        h->rss += f->r[i][unknowns] * f->r[i][unknowns];
    }
    /* Projecting out a, b, c, d first: their part of R is the leading block. */
    for (int i = LINEAR_D; i >= 0; i--) {
        double sum = f->r[i][unknowns];
        for (int j = i + 1; j <= LINEAR_D; j++) {
            sum -= f->r[i][j] * step[j];
        }
        step[i] = sum / f->r[i][i];
    }
    h->a += step[LINEAR_A] / f->scale[LINEAR_A];
    h->b += step[LINEAR_B] / f->scale[LINEAR_B];
    h->c += step[LINEAR_C] / f->scale[LINEAR_C];
    h->d += h->drifts ? step[LINEAR_D] / f->scale[LINEAR_D] : 0;
    return isfinite(h->rss);
}

bool harmonic_fit(const struct samples *x, enum harmonic_free wanted, struct harmonic *out,
                  double *residual)
{
    struct harmonic best = *out;
    struct factor factor = {0};
    int unknowns = (int)wanted;
    best.converged = false;
    if (x->n == 0 || cancelled(x->cancel)) {
        return false;
    }
    /* no start: work around a first answer, so that rounding is that of the residuals */
    bool cold = best.a == 0 && best.b == 0;
    if (cold) {
        best.c = x->y[0];
        if (!look(x, FREE_LINEAR, &best, &factor, NULL)) {
            return false;
        }
    }
    if ((!cold || unknowns > FREE_LINEAR || residual) &&
        !look(x, unknowns, &best, &factor, residual)) {
        return false;
    }
    if (!cold && unknowns == FREE_LINEAR && residual &&
        !look(x, unknowns, &best, &factor, residual)) {
        return false; /* the first look's residuals were those of the start */
    }
    double span = x->t[x->n - 1] - x->t[0], lambda = 0, floor = 0;
    bool stale = false; /* the residuals are those of a step that was not taken */
    for (int pass = 0; pass < PASSES && unknowns > FREE_LINEAR; pass++) {
        if (cancelled(x->cancel)) {
            return false;
        }
        double gain = 0; /* what a full step promises */
        for (int i = FREE_LINEAR; i < unknowns; i++) {
            gain += factor.r[i][unknowns] * factor.r[i][unknowns];
        }
        /* A step of less than a thousandth of a standard deviation, or one that only stirs rounding
         * noise. */
        floor = 1e-26 * (double)best.used * (best.a * best.a + best.b * best.b + best.c * best.c);
        if (gain <= 1e-6 * best.rss / (double)best.used || gain <= floor) {
            best.converged = true;
            break;
        }
        double step[COLUMNS];
        damped_step(&factor, unknowns, lambda, step);
        struct harmonic trial = best;
        struct factor trial_factor = {0};
        trial.omega += step[RATE_OMEGA];
        trial.gamma += step[RATE_GAMMA];
        trial.iterations = ++best.iterations;
        bool sane = trial.omega > 0 && fabs(trial.gamma) * span < 600;
        if (sane && look(x, unknowns, &trial, &trial_factor, residual) &&
            trial.rss <= best.rss + floor) {
            best = trial;
            factor = trial_factor;
            stale = false;
            lambda = lambda > 1e-3 ? 0.2 * lambda : 0;
        } else {
            stale = true;
            lambda = fmax(0.1, 8 * lambda);
            if (lambda > 1e12) {
                break;
            }
        }
    }
    best.converged = best.converged || unknowns == FREE_LINEAR;
    if (stale && !look(x, unknowns, &best, &factor, residual)) {
        return false;
    }
    invert(&factor, unknowns, best.drifts, best.inverse);
    *out = best;
    return true;
}

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

double autocorrelation_factor(double rho)
{
    rho = fmin(fmax(rho, 0), 0.9999);
    return (1 + rho) / (1 - rho);
}

double line_correlation_factor(double rho, double n)
{
    /* The variance of a random walk about a line is n/15 of that of a step. */
    static const double chance = 2, walk_factor = 1.5;
    const double walk = 1 - 7.5 / n;
    if (!(rho > chance / sqrt(n)))
        return 1;
    return rho > 0.7 * walk ? fmax(walk_factor * n, autocorrelation_factor(rho))
                            : autocorrelation_factor(rho);
}
