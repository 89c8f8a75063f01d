/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Coefficients and functions shared by the steps of all methods. Rows of methods are in the .def
 * files of rows/; rows/catalog.c joins them into one table.
 *
 * The arithmetic of a step is fixed here once and for all, because faster kernels must give the
 * same bits: the operations in the order written, no contraction, and a coefficient that is zero is
 * skipped, not multiplied. Sums begin with -0.0, which is neutral in additions, so that a sum of
 * one term is that term, to the bit, and a compiler may omit the addition.
 */
#pragma once

#include <hooke/method.h>
#include <math.h>
#include <string.h>

/*
 * k_i = f(t + c_i h, y + h sum_j a_ij k_j), y' = y + h sum_i b_i k_i, error e = h sum_i (b_i -
 * b_hat_i) k_i; where there is a rough embedded method too, e |e| / sqrt(|e|^2 + |e_rough|^2 /
 * 100), which is of a higher order.
 *
 * Interpolant of a method with fsal, from y and y' and the slopes there, with d_m = h sum_i
 * dense_mi k_i: y(t + theta h) = y + theta (rise + (1 - theta) (h k_1 - rise + theta (2 rise - h
 * k_1 - h k_last
 *                    + (1 - theta) (d_1 + theta (d_2 + (1 - theta) (d_3 + ...)))))): cubic Hermite,
 * bent.
 */
struct tableau {
    int stages;
    int extra;           /* stages after these that only the interpolant needs */
    bool fsal;           /* the last stage is f(t + h, y'): the next step's first */
    const double *c;     /* [stages + extra] */
    const double *a;     /* strictly lower triangle, row by row: a21, a31 a32, … */
    const double *b;     /* [stages] */
    const double *b_hat; /* [stages] weights of the embedded method, NULL if there is none */
    /* [stages] weights of a second one, of lower order, NULL if there is none */
    const double *rough;
    int bends;
    const double *dense; /* [bends][stages + extra] */
};

/* Row i (counted from 0) of the triangle. */
static inline const double *tableau_row(const struct tableau *tableau, int i)
{
    return tableau->a + i * (i - 1) / 2;
}

/* Computes the derivative of a system, as a slope_function. */
static inline void step_slope(const void *system, double t, const double *y, double *dydt)
{
    system_derivative(system, t, y, dydt);
}

/* Computes the Jacobian of a system, as a jacobian_function. */
static inline void step_jacobian(const void *system, double t, const double *y, double *jac)
{
    system_jacobian(system, t, y, jac);
}

/* Returns sum_j w_j k_j[i] over the weights that are not zero, from the first to the last; k is
 * [count][n]. */
static inline double weighted_sum(const double *w, int count, const double *k, int n, int i)
{
    double sum = -0.0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0)
            sum += w[j] * k[j * n + i];
    return sum;
}

/* Returns sum_j (w_j - u_j) k_j[i] over the weights that differ. */
static inline double weighted_difference(const double *w, const double *u, int count,
                                         const double *k, int n, int i)
{
    double sum = -0.0;
    for (int j = 0; j < count; j++)
        if (w[j] != u[j])
            sum += (w[j] - u[j]) * k[j * n + i];
    return sum;
}

/* Returns the sizes [n] of variables to which errors of a step are relative, unless the values are
 * larger. */
static inline const double *step_scale(const struct step *step)
{
    return step->scale ? step->scale : step->system->scale;
}

/* Returns the sum of the squares of x_i / max(scale_i, |y_i|, |z_i|), for errors x of the states y
 * and z. */
static inline double scaled_square(int n, const double *scale, const double *x, const double *y,
                                   const double *z)
{
    double sum[2] = {0, 0}; /* separate sums over even and odd i make a shorter chain */
    for (int i = 0; i < n; i++) {
        double size = fabs(y[i]) > fabs(z[i]) ? fabs(y[i]) : fabs(z[i]);
        double ratio = x[i] / (size > scale[i] ? size : scale[i]);
        sum[i % 2] += ratio * ratio;
    }
    return sum[0] + sum[1];
}

/*
 * Drifts q += w h v and kicks v += w h F(q)/m in turn; time advances with the drifts. The form
 * tells which weights are written: all of them; the first half and the middle of a palindrome; or
 * the first half and the middle of the Verlet steps of which it is composed, whose adjacent kicks
 * are joined.
 */
enum splitting_form { SPLITTING_WHOLE, SPLITTING_PALINDROME, SPLITTING_VERLET_STEPS };

struct splitting {
    enum splitting_form form;
    bool kick_first;
    int count; /* drifts and kicks of a step */
    const double *weight;
};

/* Returns the weight of drift or kick i, counted from 0. */
static inline double splitting_weight(const struct splitting *splitting, int i)
{
    if (splitting->form == SPLITTING_WHOLE)
        return splitting->weight[i];
    int k = i < splitting->count / 2 ? i : splitting->count - 1 - i;
    if (splitting->form == SPLITTING_PALINDROME)
        return splitting->weight[k];
    const double *g = splitting->weight + k / 2;
    return k % 2 == 1 ? g[0] : k == 0 ? g[0] / 2 : (g[-1] + g[0]) / 2;
}

/*
 * q'' = a(t, q): k_i = a(t + c_i h, q + c_i h v + h^2 sum_j a_ij k_j), q' = q + h v + h^2 sum_i b_i
 * k_i, v' = v + h sum_i d_i k_i.
 */
struct nystrom {
    int stages;
    bool fsal;
    const double *c;          /* [stages] */
    const double *a;          /* strictly lower triangle, row by row */
    const double *b;          /* [stages] position */
    const double *d;          /* [stages] velocity */
    const double *embedded_b; /* [stages] of the embedded method, NULL if there is none */
    const double *embedded_d;
};

/*
 * z_i = y + h sum_j a_ij f(t + c_j h, z_j), y' = y + h sum_i b_i f(t + c_i h, z_i).
 *
 * Solved stage by stage if a is lower triangular with this diagonal (its first element may be 0).
 * The estimated error is (1 - diagonal h J)^-1 h sum_i (b_i - b_hat_i) f_i.
 *
 * Otherwise (diagonal 0) all stages are solved at once, by the eigenvalues of a^-1. One is real (0
 * if there is none), two are alpha +- i beta. With T the real and imaginary parts of the
 * eigenvectors, so that a^-1 T = T diag(real, [alpha -beta; beta alpha]), left = T^-1 a^-1, right =
 * T; y' = y + sum_i d_i (z_i - y). The estimated error, for a method with the slope at the start as
 * one more stage, is (real - h J)^-1 (h f(t, y) + sum_i estimate_i (z_i - y)) (Hairer, Wanner 1996,
 * IV.8).
 */
struct implicit_tableau {
    int stages;      /* all at once: 3 at most */
    double diagonal; /* 0 solves all stages at once */
    bool fsal;       /* the first stage is y, and its slope the last stage's of the step before */
    const double *c; /* [stages] */
    const double *a; /* [stages][stages] */
    const double *b; /* [stages] */
    const double *b_hat;        /* [stages] weights of the embedded method, NULL if there is none */
    const double *d, *estimate; /* [stages] */
    double real, alpha, beta;
    const double *left, *right; /* [stages][stages] */
};

enum { ROSENBROCK_DEGREE = 4 }; /* highest degree */

/*
 * (1/(gamma h) - J) u_i = f(t + alpha_i h, y + sum_j a_ij u_j) + sum_j (c_ij/h) u_j + d_i h df/dt,
 * y' = y + sum_i m_i u_i (Hairer, Wanner 1996, IV.7),
 * y(t + theta h) = (1 - theta) y + theta y' + theta (1 - theta) sum_i u_i sum_m dense_mi theta^m, m
 * = 0 … degree - 1.
 */
struct rosenbrock {
    int stages;
    double gamma;
    const double *alpha; /* [stages] */
    const double *d;     /* [stages] */
    const double *a, *c; /* strictly lower triangles, row by row */
    const double *m;     /* [stages] */
    const double *b_hat; /* [stages], NULL if there is none */
    int degree;
    const double *dense; /* [degree][stages], NULL if there is none */
};

/* Weights of a linear multistep method, those of the newest values first. */
struct multistep {
    int steps;
    const double *predict; /* [steps] of f_n, f_n-1, … (Adams-Bashforth), NULL if there is none */
    const double *correct; /* [steps] of f_n+1, f_n, … (Adams-Moulton), NULL if there is none */
    /* [steps + 1] of y_n+1, y_n, … (backward differentiation), NULL if there is none */
    const double *values;
};

/* Part of a step within which a turning point is at its end (below rounding); tries to find one, of
 * which two or three suffice if the acceleration is not 0; most segments of a fixed step. */
#define TURN_NEAR 1e-8
enum { TURN_TRIES = 12, TURN_PIECES = 8 };
/*
 * Ends a step from y_begin at t of a method that turns (method_turns()). A step across a turning
 * point is taken again up to that point; *turned is then true and step->h shorter. low holds
 * step->low as it was before, if there is one.
 */
enum step_status turn_step(const struct method *method, struct step *step, double t,
                           const double *y_begin, const double *low, bool *turned);

/* Computes dydt [n] at t and y; forces is data of the function. */
typedef void slope_function(const void *forces, double t, const double *y, double *dydt);

/*
 * Steps and work sizes [double] of the families of methods, for rows of the catalog (struct
 * method).
 */
enum step_status rk_step(const struct method *method, struct step *step);
/* Returns the kernel of a method for a typed scene (kernel/typed.c), or NULL if its family has no
 * kernels. */
march_function *typed_kernel(const struct method *method, const struct system *system,
                             enum drag drag);
/* Returns the kernel of an implicit method (kernel/implicit.c), or NULL if the system has none. */
march_function *implicit_kernel(const struct method *method, const struct system *system);
/* Return the kernel of all splittings for a shape of kernel/kernel.h or of kernel/typed.h
 * (kernel/shape.c). */
march_function *shape_split(int shape);
march_function *typed_split(int shape);
/* Return kernels for any number of variables (kernel/any.c), and for Rosenbrock methods
 * (kernel/rosenbrock.c), or NULL. */
march_function *any_kernel(const struct method *method);
step_function *any_step_kernel(const struct method *method);
step_function *rosenbrock_step_kernel(const struct method *method, const struct system *system);
size_t rk_work(const struct method *method, int n);
void rk_dense(const struct method *method, const struct step *step, double theta, double *y);
/* Compute the polynomial of variable i over the last step, as method_polynomial(). */
void rk_polynomial(const struct method *method, const struct step *step, int i,
                   struct dense_polynomial *polynomial);
void rosenbrock_polynomial(const struct method *method, const struct step *step, int i,
                           struct dense_polynomial *polynomial);

enum step_status nystrom_step(const struct method *method, struct step *step);
size_t nystrom_work(const struct method *method, int n);

enum step_status implicit_step(const struct method *method, struct step *step);
size_t implicit_work(const struct method *method, int n);
void implicit_dense(const struct method *method, const struct step *step, double theta, double *y);
size_t avf_work(const struct method *method, int n);
size_t structural_work(const struct method *method, int n);
double structural_growth(const struct method *method, double x, double zeta,
                         enum stiffness_sign sign);

enum step_status rosenbrock_step(const struct method *method, struct step *step);
size_t rosenbrock_work(const struct method *method, int n);
void rosenbrock_dense(const struct method *method, const struct step *step, double theta,
                      double *y);

enum step_status multistep_step(const struct method *method, struct step *step);
size_t multistep_work(const struct method *method, int n);
double multistep_growth(const struct method *method, double x, double zeta,
                        enum stiffness_sign sign);

void *cvode_begin(const struct method *method, const struct step *step);
void cvode_end(void *library);
enum step_status cvode_step(const struct method *method, struct step *step);
enum step_status cvode_adapt(const struct method *method, struct step *step,
                             struct controller *controller, double t_end);
void cvode_dense(const struct method *method, const struct step *step, double theta, double *y);

size_t odex_work(const struct method *method, int n);

enum step_status split_step(const struct method *method, struct step *step);
size_t split_work(const struct method *method, int n);
bool split_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                struct error *error);
bool split_applies(const struct method *method, const struct system *system, enum drag drag,
                   struct error *error);

/*
 * Solves z = y + h f(t, z). y and z [n] are different; work points to the last newton_work() - 2 n
 * doubles of newton_work(). A whole oscillator, linear and quadratic drag included, is solved in
 * closed form, the rest by Newton's iteration.
 */
enum step_status implicit_euler_solve(struct step *step, double t, double h, const double *y,
                                      double *z, double *work);
size_t newton_work(const struct method *method, int n); /* two states and the solver's own */

size_t state_work(const struct method *method, int n); /* one state */

/*
 * Returns the root of a v + c |v| v = r that goes over into r/a as c -> 0, or NaN if there is none.
 * The equation is divided by a, so that nothing overflows or cancels: v + (c/a) |v| v = r/a.
 */
static inline double drag_root(double a, double c, double r)
{
    double u = r / a;
    /* the formula below gives the same */
    if (c == 0)
        return u;
    return 2 * u / (1 + sqrt(1 + 4 * (c / a) * fabs(u)));
}

/*
 * Adds the increment to *y. *low holds what rounding has taken from *y so far; it is added, too,
 * and set to the rounding error of this sum (Kahan 1965, Commun. ACM 8:40, with the exact error of
 * a sum by Knuth, TAOCP 2, 4.2.2, which does not ask for |increment| <= |y|). If low is NULL, the
 * increment alone is added.
 */
static inline void step_add(double *y, double *low, double increment)
{
    if (!low) {
        *y += increment;
        return;
    }
    double add = increment + *low, sum = *y + add, added = sum - *y;
    *low = (*y - (sum - added)) + (add - added);
    *y = sum;
}

/* Does the work of method_step(), inlined for callers in which the call would take time. */
static inline enum step_status step_take(const struct method *method, struct step *step)
{
    const enum step_status status = (step->kernel ? step->kernel : method->step)(method, step);
    step->warm = status == STEP_OK;
    step->again = false;
    if (status == STEP_OK)
        step->t += step->h;
    return status;
}

/* Ends a step: y becomes z if all of z is finite, else it stays and STEP_NONFINITE is returned. */
static inline enum step_status step_finish(struct step *step, const double *z)
{
    int n = step->system->n;
    for (int i = 0; i < n; i++)
        if (!isfinite(z[i]))
            return STEP_NONFINITE;
    memcpy(step->y, z, (size_t)n * sizeof *z);
    return STEP_OK;
}

/* Ends a step by y += increment [n], with low parts if there are any, unless it is not finite. */
static inline enum step_status step_increase_all(struct step *step, int n, const double *increment)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(step->y[i] + increment[i]))
            return STEP_NONFINITE;
    for (int i = 0; i < n; i++)
        step_add(&step->y[i], step->low ? &step->low[i] : NULL, increment[i]);
    return STEP_OK;
}

/* Does the same as step_increase_all() for all variables of the system. */
static inline enum step_status step_increase(struct step *step, const double *increment)
{
    return step_increase_all(step, step->system->n, increment);
}

#define ALGORITHM(name, ...)                                                                       \
    enum step_status name##_step(const struct method *method, struct step *step);
#include "method/rows/algorithms.def"
#undef ALGORITHM
