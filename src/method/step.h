/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the step bodies share. Rows stand in rk.def, split.def and algorithms.def; catalog.c makes them one table.
 *
 * The arithmetic of a step is fixed here once and for all, because faster kernels must give the same bits:
 * the operations in the order written, no contraction, and a coefficient that is zero is skipped, not multiplied.
 * Sums begin with -0.0, the number that changes nothing when something is added to it: so a sum of one is that one, to
 * the bit, and a compiler may leave the addition out.
 */
#ifndef HOOKE_METHOD_STEP_H
#define HOOKE_METHOD_STEP_H

#include <hooke/method.h>
#include <math.h>
#include <string.h>

/*
 * k_i = f(t + c_i h, y + h sum_j a_ij k_j), y' = y + h sum_i b_i k_i, error h sum_i (b_i - companion_i) k_i,
 * y(t + theta h) = y + h sum_i k_i sum_m dense_im theta^m, m = 1 … degree.
 */
struct tableau {
    int stages;
    bool fsal;               /* the last stage is f(t + h, y'): the next step's first */
    const double *c;         /* [stages] */
    const double *a;         /* strictly lower triangle, row by row: a21, a31 a32, … */
    const double *b;         /* [stages] */
    const double *companion; /* [stages] weights of the embedded method, NULL: none */
    int degree;
    const double *dense; /* [stages][degree], NULL: none */
};

/* Row i (counted from 0) of the triangle. */
static inline const double *tableau_row(const struct tableau *tableau, int i)
{
    return tableau->a + i * (i - 1) / 2;
}

/* Drifts q += w h v and kicks v += w h F(q)/m in turn. The clock goes with the drifts. */
struct splitting {
    bool kick_first;
    int count;
    const double *weight; /* [count] */
};

/*
 * q'' = a(t, q): k_i = a(t + c_i h, q + c_i h v + h^2 sum_j a_ij k_j), q' = q + h v + h^2 sum_i b_i k_i,
 * v' = v + h sum_i d_i k_i.
 */
struct nystrom {
    int stages;
    bool fsal;
    const double *c;           /* [stages] */
    const double *a;           /* strictly lower triangle, row by row */
    const double *b;           /* [stages] position */
    const double *d;           /* [stages] velocity */
    const double *companion_b; /* [stages] of the embedded method, NULL: none */
    const double *companion_d;
};

/* k_i = f(t + c_i h, y + h sum_j a_ij k_j) with a full matrix, y' = y + h sum_i b_i k_i. */
struct implicit_tableau {
    int stages;
    const double *c;         /* [stages] */
    const double *a;         /* [stages][stages] */
    const double *b;         /* [stages] */
    const double *companion; /* [stages] weights of the embedded method, NULL: none */
};

/*
 * (1/(gamma h) - J) u_i = f(t + alpha_i h, y + sum_j a_ij u_j) + sum_j (c_ij/h) u_j + d_i h df/dt,
 * y' = y + sum_i m_i u_i (Hairer, Wanner 1996, IV.7).
 */
struct rosenbrock {
    int stages;
    double gamma;
    const double *alpha;     /* [stages] */
    const double *d;         /* [stages] */
    const double *a, *c;     /* strictly lower triangles, row by row */
    const double *m;         /* [stages] */
    const double *companion; /* [stages], NULL: none */
};

/* The newest first. */
struct multistep {
    int steps;
    const double *predict; /* [steps] of f_n, f_n-1, … (Adams-Bashforth), NULL: none */
    const double *correct; /* [steps] of f_n+1, f_n, … (Adams-Moulton), NULL: none */
    const double *values;  /* [steps + 1] of y_n+1, y_n, … (backward differentiation), NULL: none */
};

enum step_status rk_step(const struct method *method, struct step *step);
size_t rk_work(const struct method *method, int n);
void rk_dense(const struct method *method, const struct step *step, double theta, double *y);
/* |h| times an estimate of the Jacobian's norm from the last step's two stages at t + h; 0: there is no such pair. */
double rk_stiffness(const struct method *method, const struct step *step);

enum step_status nystrom_step(const struct method *method, struct step *step);
size_t nystrom_work(const struct method *method, int n);

enum step_status implicit_step(const struct method *method, struct step *step);
size_t implicit_work(const struct method *method, int n);

enum step_status rosenbrock_step(const struct method *method, struct step *step);
size_t rosenbrock_work(const struct method *method, int n);

enum step_status multistep_step(const struct method *method, struct step *step);
size_t multistep_work(const struct method *method, int n);
double multistep_growth(const struct method *method, double x, double zeta);

enum step_status split_step(const struct method *method, struct step *step);
size_t split_work(const struct method *method, int n);
bool split_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                struct error *error);
bool split_applies(const struct method *method, const struct system *system, enum drag drag, struct error *error);

/*
 * Solves z = y + h f(t, z). y and z [n] are different; work: the last n (n + 4) doubles of newton_work().
 * A whole oscillator, linear and quadratic drag included, is solved in closed form, the rest by Newton's iteration.
 */
enum step_status implicit_euler_solve(struct step *step, double t, double h, const double *y, double *z, double *work);
size_t newton_work(const struct method *method, int n); /* two states and the solver's own */

size_t state_work(const struct method *method, int n); /* one state */

/*
 * The root of a v + c |v| v = r that goes over into r/a as c -> 0; NaN: there is none. Divided by a, so that nothing
 * overflows or cancels: v + (c/a) |v| v = r/a.
 */
static inline double drag_root(double a, double c, double r)
{
    double u = r / a;
    return 2 * u / (1 + sqrt(1 + 4 * (c / a) * fabs(u)));
}

/* The end of every step: y becomes z if all of z is finite. */
static inline enum step_status step_finish(struct step *step, const double *z)
{
    int n = step->system->n;
    for (int i = 0; i < n; i++)
        if (!isfinite(z[i]))
            return STEP_NONFINITE;
    memcpy(step->y, z, (size_t)n * sizeof *z);
    return STEP_OK;
}

#define ALGORITHM(name, ...) enum step_status name##_step(const struct method *method, struct step *step);
#include "algorithms.def"
#undef ALGORITHM

#endif
