/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the step bodies share. Rows stand in rk.def, split.def and algorithms.def; catalog.c makes them one table.
 *
 * The arithmetic of a step is fixed here once and for all, because faster kernels must give the same bits:
 * the operations in the order written, no contraction, and a coefficient that is zero is skipped, not multiplied.
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

enum step_status rk_step(const struct method *method, struct step *step);
size_t rk_work(const struct method *method, int n);
void rk_dense(const struct method *method, const struct step *step, double theta, double *y);
/* |h| times an estimate of the Jacobian's norm from the last step's two stages at t + h; 0: there is no such pair. */
double rk_stiffness(const struct method *method, const struct step *step);

enum step_status split_step(const struct method *method, struct step *step);
size_t split_work(const struct method *method, int n);
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
