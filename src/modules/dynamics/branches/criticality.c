/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The first Lyapunov coefficient of a Hopf point, from differences of the Jacobian in the
 * directions that it needs. */
#include <math.h>
#include <string.h>

#include "modules/dynamics/branches/walk.h"

/* Solves (A - i im) x = b, written as a real system of twice the size; x [2 n] is b on entry.
 * Returns false if it is singular. */
static bool solve_shifted(int n, const double *a, double im, double *x)
{
    double m[4 * FIELD_VARIABLES * FIELD_VARIABLES];
    const int all = 2 * n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const double side = i == j ? im : 0;
            m[i * all + j] = m[(n + i) * all + n + j] = a[i * n + j];
            m[i * all + n + j] = side;
            m[(n + i) * all + j] = -side;
        }
    return matrix_solve(all, m, x);
}

/* ---- derivatives of second and third order along directions ---- */

/* The state at which derivatives are taken, and the step of their differences. */
struct taylor {
    struct vector_field *field;
    const double *state;
    double step; /* relative to natural sizes */
};

/* Sets result [n] to the product of a Jacobian and v [n]. The Jacobian is that at the state
 * t->state moved by `step` along u [n]; differences of such products give higher derivatives. */
static void jacobian_times(const struct taylor *t, const double *u, double step, const double *v,
                           double *result)
{
    const int n = t->field->n;
    double y[FIELD_VARIABLES] = {0}, jacobian[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int i = 0; i < n; i++)
        y[i] = t->state[i] + step * u[i];
    field_jacobian(t->field, y, jacobian);
    for (int i = 0; i < n; i++) {
        result[i] = 0;
        for (int j = 0; j < n; j++)
            result[i] += jacobian[i * n + j] * v[j];
    }
}

/* Returns the step along u that moves some variable by t->step of its natural size. */
static double step_along(const struct taylor *t, const double *u)
{
    double most = 0;
    for (int i = 0; i < t->field->n; i++)
        most = fmax(most, fabs(u[i]) / t->field->size[i]);
    return most > 0 ? t->step / most : 1;
}

/* Computes the second derivative B(u, v) by differences of fourth order. */
static void second_derivative(const struct taylor *t, const double *u, const double *v,
                              double *result)
{
    const double h = step_along(t, u);
    double derivative[4][FIELD_VARIABLES];
    static const double place[] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++)
        jacobian_times(t, u, place[k] * h, v, derivative[k]);
    for (int i = 0; i < t->field->n; i++)
        result[i] =
            (8 * (derivative[2][i] - derivative[1][i]) - (derivative[3][i] - derivative[0][i])) /
            (12 * h);
}

/* Computes the third derivative C(u, u, v) by differences of fourth order. */
static void third_derivative(const struct taylor *t, const double *u, const double *v,
                             double *result)
{
    const double h = step_along(t, u);
    double derivative[5][FIELD_VARIABLES];
    for (int k = 0; k < 5; k++)
        jacobian_times(t, u, (k - 2) * h, v, derivative[k]);
    for (int i = 0; i < t->field->n; i++)
        result[i] = (16 * (derivative[1][i] + derivative[3][i]) -
                     (derivative[0][i] + derivative[4][i]) - 30 * derivative[2][i]) /
                    (12 * h * h);
}

static void transpose(int n, const double *a, double *b)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            b[j * n + i] = a[i * n + j];
}

/* Returns the real part of <p + i q, x + i y>, the first factor conjugated. */
static double real_product(int n, const double *p, const double *q, const double *x,
                           const double *y)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += p[i] * x[i] + q[i] * y[i];
    return sum;
}

/* Computes the adjoint eigenvector p + i q with A^T (p + i q) = -i omega (p + i q) and <p + i q, a
 * + i b> = 1. Returns false if it is not found. */
static bool adjoint(int n, const double *jacobian, double omega, const double *a, const double *b,
                    double *p, double *q)
{
    double turned[FIELD_VARIABLES * FIELD_VARIABLES] = {0};
    transpose(n, jacobian, turned);
    if (!matrix_eigenvector(n, turned, (struct eigenvalue){0, -omega}, p, q))
        return false;
    const double re = real_product(n, p, q, a, b);
    double im = 0;
    for (int i = 0; i < n; i++)
        im += p[i] * b[i] - q[i] * a[i];
    const double square = re * re + im * im;
    /* <p/c, w> = <p, w>/conj(c): c = conj(re + i im) */
    for (int i = 0; i < n; i++) {
        const double x = p[i], y = q[i];
        p[i] = (x * re - y * im) / square;
        q[i] = (y * re + x * im) / square;
    }
    return square > 0;
}

/* Returns the coefficient with the step of *t, or NAN if eigenvectors are not found. */
static double coefficient(const struct taylor *t, double omega)
{
    const int n = t->field->n;
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], a[FIELD_VARIABLES], b[FIELD_VARIABLES],
        p[FIELD_VARIABLES], q[FIELD_VARIABLES];
    field_jacobian(t->field, t->state, jacobian);
    if (!matrix_eigenvector(n, jacobian, (struct eigenvalue){0, omega}, a, b) ||
        !adjoint(n, jacobian, omega, a, b, p, q))
        return NAN;
    double aa[FIELD_VARIABLES], ab[FIELD_VARIABLES], bb[FIELD_VARIABLES], aaa[FIELD_VARIABLES],
        bba[FIELD_VARIABLES], aab[FIELD_VARIABLES], bbb[FIELD_VARIABLES];
    second_derivative(t, a, a, aa);
    second_derivative(t, a, b, ab);
    second_derivative(t, b, b, bb);
    third_derivative(t, a, a, aaa);
    third_derivative(t, b, a, bba);
    third_derivative(t, a, b, aab);
    third_derivative(t, b, b, bbb);
    /* C(q, q, conj q) = C(aaa) + C(abb) + i (C(aab) + C(bbb)) */
    double re[FIELD_VARIABLES] = {0}, im[FIELD_VARIABLES] = {0};
    for (int i = 0; i < n; i++) {
        re[i] = aaa[i] + bba[i];
        im[i] = aab[i] + bbb[i];
    }
    double sum = real_product(n, p, q, re, im);
    /* -2 B(q, A^-1 B(q, conj q)) */
    double still[FIELD_VARIABLES], work[FIELD_VARIABLES * FIELD_VARIABLES], x[FIELD_VARIABLES],
        y[FIELD_VARIABLES];
    for (int i = 0; i < n; i++)
        still[i] = aa[i] + bb[i];
    memcpy(work, jacobian, sizeof work);
    if (!matrix_solve(n, work, still))
        return NAN;
    second_derivative(t, a, still, x);
    second_derivative(t, b, still, y);
    sum -= 2 * real_product(n, p, q, x, y);
    /* B(conj q, (2 i omega - A)^-1 B(q, q)): B(q, q) = aa - bb + 2 i ab */
    double twice[2 * FIELD_VARIABLES];
    for (int i = 0; i < n; i++) {
        twice[i] = -(aa[i] - bb[i]);
        twice[n + i] = -2 * ab[i];
    }
    if (!solve_shifted(n, jacobian, 2 * omega, twice))
        return NAN;
    double xa[FIELD_VARIABLES], xb[FIELD_VARIABLES], ya[FIELD_VARIABLES], yb[FIELD_VARIABLES];
    second_derivative(t, a, twice, xa);
    second_derivative(t, b, twice, xb);
    second_derivative(t, a, twice + n, ya);
    second_derivative(t, b, twice + n, yb);
    for (int i = 0; i < n; i++) { /* (a - i b)(x + i y) */
        re[i] = xa[i] + yb[i];
        im[i] = ya[i] - xb[i];
    }
    return (sum + real_product(n, p, q, re, im)) / (2 * omega);
}

#define DIFFERENCE_STEP_SIZES 2e-3 /* first step in natural sizes */
/* The step grows by this factor where the difference is lost in rounding because a variable has not
 * moved. */
#define STEP_GROWTH_FACTOR 100
#define STEP_MAX_FRACTION 0.1         /* longest step, relative to the largest natural size */
#define VALUE_ERROR_MAX_RELATIVE 1e-3 /* A larger relative error of the value is too large. */
/* Values of two steps agree if they differ by less than this part. */
#define VALUES_AGREE_RELATIVE 0.03

/* Returns the largest natural size, relative to the sizes of the variables that the eigenvector
 * moves. */
static double room_for_steps(struct vector_field *field, const double *state, double omega)
{
    const struct taylor one = {field, state, 1};
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], a[FIELD_VARIABLES], b[FIELD_VARIABLES],
        largest = 0;
    field_jacobian(field, state, jacobian);
    if (!matrix_eigenvector(field->n, jacobian, (struct eigenvalue){0, omega}, a, b))
        return 1;
    for (int i = 0; i < field->n; i++)
        largest = fmax(largest, field->size[i]);
    return largest / fmin(step_along(&one, a), step_along(&one, b));
}

/* The result is accepted if doubling the step of the differences changes it little. Otherwise the
 * step is increased, since the difference may be lost in rounding, until two successive values
 * agree. If none do, it is the value with the first step, and *error says how uncertain it is. */
double lyapunov_coefficient(struct vector_field *field, const double *state, double omega,
                            double *error)
{
    const double longest = STEP_MAX_FRACTION * room_for_steps(field, state, omega);
    double first = NAN, first_error = NAN, last = NAN;
    for (double step = DIFFERENCE_STEP_SIZES; step == DIFFERENCE_STEP_SIZES || step < longest;
         step *= STEP_GROWTH_FACTOR) {
        const struct taylor fine = {field, state, step}, coarse = {field, state, 2 * step};
        const double value = coefficient(&fine, omega);
        *error = fabs(coefficient(&coarse, omega) - value);
        const bool known = value != 0 && *error <= VALUE_ERROR_MAX_RELATIVE * fabs(value);
        if (known && (step == DIFFERENCE_STEP_SIZES ||
                      fabs(value - last) <= VALUES_AGREE_RELATIVE * fabs(value)))
            return value;
        if (step == DIFFERENCE_STEP_SIZES) {
            first = value;
            first_error = *error;
        }
        last = known ? value : NAN;
    }
    *error = first_error;
    return first;
}
