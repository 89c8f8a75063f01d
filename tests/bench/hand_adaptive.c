/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Adaptive solves by hand: dop853 and rodas5p written for one problem, with the classical
 * controller of Hairer and Wanner's codes. Coefficients come from hooke's tables, where the
 * compiler can see them; the loops unroll.
 */
#include "bench/bench.h"
#include "method/rows/rows.h"

#define INLINE static inline __attribute__((always_inline))
#define UNROLL _Pragma("GCC unroll 32")

static const struct method explicit_rows[] = {
#define RUNGE_KUTTA(id, ...) {.row.name = #id, __VA_ARGS__},
#include "method/rows/rk.def"
};
static const struct method rosenbrock_rows[] = {
#define ROSENBROCK(id, ...) {.row.name = #id, __VA_ARGS__},
#include "method/rows/rosenbrock.def"
};
/* Both are the last of their file; bench_adaptive() looks at the names. */
#define DOP853 (explicit_rows[COUNT_OF(explicit_rows) - 1])
#define RODAS5P (rosenbrock_rows[COUNT_OF(rosenbrock_rows) - 1])

typedef void slope_of(const double *y, double *dydt);
typedef void jacobian_of(const double *y, double *jac);

INLINE double larger(double a, double b)
{
    return a > b ? a : b;
}

INLINE double next_step(double h, double error, double exponent)
{
    const double factor = error > 0 ? 0.9 * pow(error, -exponent) : 6;
    return h * (factor < 1. / 3 ? 1. / 3 : factor > 6 ? 6 : factor);
}

/* ---- dop853 (Hairer, Norsett, Wanner 1993, II.10) ---- */

INLINE bool dop853(int n, slope_of *slope, const struct problem *problem, double tol,
                   const double *start, double *end)
{
    const struct tableau *m = DOP853.tableau;
    double y[4], z[4], k[13][4], t = 0, h = 0.01;
    for (int i = 0; i < n; i++)
        y[i] = start[i];
    slope(y, k[0]);
    for (int steps = 0; t < problem->span; steps++) {
        if (steps > 1000000 || !(h > 1e-14))
            return false;
        const bool last = t + 1.01 * h >= problem->span;
        if (last)
            h = problem->span - t;
        UNROLL for (int s = 1; s < 13; s++)
        {
            const double *a = m->a + s * (s - 1) / 2;
            UNROLL for (int i = 0; i < n; i++)
            {
                double sum = -0.0;
                UNROLL for (int j = 0; j < s; j++) if (a[j] != 0) sum += a[j] * k[j][i];
                z[i] = y[i] + h * sum;
            }
            slope(z, k[s]);
        }
        double fine = 0, rough = 0;
        UNROLL for (int i = 0; i < n; i++)
        {
            double e5 = -0.0, e3 = -0.0;
            UNROLL for (int j = 0; j < 12; j++)
            {
                if (m->b[j] != m->b_hat[j])
                    e5 += (m->b[j] - m->b_hat[j]) * k[j][i];
                if (m->b[j] != m->rough[j])
                    e3 += (m->b[j] - m->rough[j]) * k[j][i];
            }
            const double size =
                1 / (tol * larger(problem->scale[i], larger(fabs(y[i]), fabs(z[i]))));
            fine += e5 * size * (e5 * size);
            rough += e3 * size * (e3 * size);
        }
        const double both = fine + 0.01 * rough, error = both > 0 ? h * fine / sqrt(n * both) : 0;
        if (error <= 1) {
            t = last ? problem->span : t + h;
            for (int i = 0; i < n; i++) {
                y[i] = z[i];
                k[0][i] = k[12][i];
            }
        }
        h = next_step(h, error, 1. / 8);
    }
    for (int i = 0; i < n; i++)
        end[i] = y[i];
    return true;
}

INLINE void oscillator(const double *y, double *dydt)
{
    dydt[0] = y[1];
    dydt[1] = -y[0];
}

INLINE void kepler(const double *y, double *dydt)
{
    const double square = y[0] * y[0] + y[1] * y[1], pull = 1 / (square * sqrt(square));
    dydt[0] = y[2];
    dydt[1] = y[3];
    dydt[2] = -pull * y[0];
    dydt[3] = -pull * y[1];
}

bool hand_dop853_oscillator(const struct problem *problem, double tol, const double *start,
                            double *end)
{
    return dop853(2, oscillator, problem, tol, start, end);
}

bool hand_dop853_kepler(const struct problem *problem, double tol, const double *start, double *end)
{
    return dop853(4, kepler, problem, tol, start, end);
}

/* ---- rodas5p (Steinebach 2023), with the inverse in closed form ---- */

INLINE void invert2(const double *a, double *b)
{
    const double d = 1 / (a[0] * a[3] - a[1] * a[2]);
    b[0] = a[3] * d;
    b[1] = -a[1] * d;
    b[2] = -a[2] * d;
    b[3] = a[0] * d;
}

INLINE void invert3(const double *a, double *b)
{
    const double x = a[4] * a[8] - a[5] * a[7], y = a[5] * a[6] - a[3] * a[8],
                 z = a[3] * a[7] - a[4] * a[6];
    const double d = 1 / (a[0] * x + a[1] * y + a[2] * z);
    b[0] = x * d;
    b[1] = (a[2] * a[7] - a[1] * a[8]) * d;
    b[2] = (a[1] * a[5] - a[2] * a[4]) * d;
    b[3] = y * d;
    b[4] = (a[0] * a[8] - a[2] * a[6]) * d;
    b[5] = (a[2] * a[3] - a[0] * a[5]) * d;
    b[6] = z * d;
    b[7] = (a[1] * a[6] - a[0] * a[7]) * d;
    b[8] = (a[0] * a[4] - a[1] * a[3]) * d;
}

INLINE bool rodas5p(int n, slope_of *slope, jacobian_of *jacobian, const struct problem *problem,
                    double tol, const double *start, double *end)
{
    const struct rosenbrock *m = RODAS5P.rosenbrock;
    double y[3], z[3], u[8][3], jac[9] = {0}, matrix[9], inverse[9], f[3], first[3] = {0}, t = 0,
                                h = 1e-4;
    bool again = false;
    for (int i = 0; i < n; i++)
        y[i] = start[i];
    for (int steps = 0; t < problem->span; steps++) {
        if (steps > 1000000 || !(h > 1e-14))
            return false;
        const bool last = t + 1.01 * h >= problem->span;
        if (last)
            h = problem->span - t;
        if (!again) {
            jacobian(y, jac);
            slope(y, first);
        }
        for (int i = 0; i < n * n; i++)
            matrix[i] = (i % (n + 1) == 0 ? 1 / (m->gamma * h) : 0) - jac[i];
        n == 2 ? invert2(matrix, inverse) : invert3(matrix, inverse);
        const double rate = 1 / h;
        UNROLL for (int s = 0; s < 8; s++)
        {
            const double *a = m->a + s * (s - 1) / 2, *c = m->c + s * (s - 1) / 2;
            double right[3];
            UNROLL for (int i = 0; i < n; i++)
            {
                double sum = y[i];
                UNROLL for (int j = 0; j < s; j++) if (a[j] != 0) sum += a[j] * u[j][i];
                z[i] = sum;
            }
            if (s == 0)
                for (int i = 0; i < n; i++)
                    f[i] = first[i];
            else
                slope(z, f);
            UNROLL for (int i = 0; i < n; i++)
            {
                double sum = -0.0;
                UNROLL for (int j = 0; j < s; j++) if (c[j] != 0) sum += c[j] * u[j][i];
                right[i] = f[i] + rate * sum;
            }
            UNROLL for (int i = 0; i < n; i++)
            {
                double sum = -0.0;
                UNROLL for (int j = 0; j < n; j++) sum += inverse[i * n + j] * right[j];
                u[s][i] = sum;
            }
        }
        double square = 0;
        for (int i = 0; i < n;
             i++) { /* the last stage is the error, and what makes z the new state */
            z[i] += u[7][i];
            const double e = u[7][i] / larger(problem->scale[i], larger(fabs(y[i]), fabs(z[i])));
            square += e * e;
        }
        const double error = sqrt(square / n) / tol;
        if (error <= 1) {
            t = last ? problem->span : t + h;
            for (int i = 0; i < n; i++)
                y[i] = z[i];
        }
        again = !(error <= 1);
        h = error <= 1e300 ? next_step(h, error, 1. / 5) : h / 4;
    }
    for (int i = 0; i < n; i++)
        end[i] = y[i];
    return true;
}

INLINE void vanderpol(const double *y, double *dydt)
{
    dydt[0] = y[1];
    dydt[1] = 1000 * (1 - y[0] * y[0]) * y[1] - y[0];
}

INLINE void vanderpol_jacobian(const double *y, double *jac)
{
    jac[0] = 0;
    jac[1] = 1;
    jac[2] = -2000 * y[0] * y[1] - 1;
    jac[3] = 1000 * (1 - y[0] * y[0]);
}

INLINE void robertson(const double *y, double *dydt)
{
    const double burn = 3e7 * y[1] * y[1];
    dydt[0] = 1e4 * y[1] * y[2] - 0.04 * y[0];
    dydt[1] = -dydt[0] - burn;
    dydt[2] = burn;
}

INLINE void robertson_jacobian(const double *y, double *jac)
{
    jac[0] = -0.04;
    jac[1] = 1e4 * y[2];
    jac[2] = 1e4 * y[1];
    jac[3] = 0.04;
    jac[4] = -jac[1] - 6e7 * y[1];
    jac[5] = -jac[2];
    jac[6] = jac[8] = 0;
    jac[7] = 6e7 * y[1];
}

bool hand_rodas5p_vanderpol(const struct problem *problem, double tol, const double *start,
                            double *end)
{
    return rodas5p(2, vanderpol, vanderpol_jacobian, problem, tol, start, end);
}

bool hand_rodas5p_robertson(const struct problem *problem, double tol, const double *start,
                            double *end)
{
    return rodas5p(3, robertson, robertson_jacobian, problem, tol, start, end);
}
