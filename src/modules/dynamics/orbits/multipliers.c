/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Multipliers of an orbit from the maps of its segments. The product of the maps is not formed,
 * since where differences first grow and then decay it would lose the small ones. Instead a basis
 * is carried around the orbit until it is that of the eigenvectors, fastest first, as in the
 * periodic QR algorithm (Bojanczyk, Golub, Van Dooren 1992): the logarithms of what each segment
 * does to it are accurate however different the multipliers are. For an autonomous orbit the
 * direction of motion is projected out at both ends of each segment, and with it the trivial
 * multiplier. */
#include "modules/dynamics/orbits/multipliers.h"

#include <math.h>
#include <string.h>

#include "modules/solving/compute/algebra.h"

#define QR_SWEEPS 6                    /* times that the basis is carried around the orbit */
#define SIGN_NOISE_MAX 0.5             /* uncertainty above which the sign of a test is unknown */
#define MULTIPLIER_KNOWN_RELATIVE 1e-3 /* largest relative uncertainty of a known multiplier */

typedef double square[FIELD_VARIABLES * FIELD_VARIABLES];

/* Computes the product of a [rows][inner] and b [inner][columns]. */
static void multiply(int rows, int inner, int columns, const double *a, const double *b,
                     double *product)
{
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            double sum = 0;
            for (int k = 0; k < inner; k++)
                sum += a[i * inner + k] * b[k * columns + j];
            product[i * columns + j] = sum;
        }
}

/* Computes an orthonormal basis [n][n - 1] of the directions across the rate: all columns but the
 * first of the Householder reflection that takes the rate to the first axis. */
static void transverse_basis(int n, const double *rate, double *basis)
{
    double v[FIELD_VARIABLES];
    memcpy(v, rate, (size_t)n * sizeof *v);
    v[0] += copysign(vector_length(n, v), v[0]);
    const double half = vector_length(n, v) * vector_length(n, v) / 2;
    for (int i = 0; i < n; i++)
        for (int j = 1; j < n; j++)
            basis[i * (n - 1) + j - 1] = (i == j) - v[i] * v[j] / half;
}

/* Computes the map of a segment between the directions across the motion at both of its ends, [n -
 * 1][n - 1]. `first` and `last` are the rates there. */
static void transverse_map(int n, const double *map, const double *first, const double *last,
                           double *reduced)
{
    double first_basis[FIELD_VARIABLES * FIELD_VARIABLES],
        last_basis[FIELD_VARIABLES * FIELD_VARIABLES], moved[FIELD_VARIABLES * FIELD_VARIABLES],
        turned[FIELD_VARIABLES * FIELD_VARIABLES];
    transverse_basis(n, first, first_basis);
    transverse_basis(n, last, last_basis);
    multiply(n, n, n - 1, map, first_basis, moved);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n - 1; j++)
            turned[j * n + i] = last_basis[i * (n - 1) + j];
    multiply(n - 1, n, n - 1, turned, moved, reduced);
}

/* Computes the relative error of each segment in carrying the direction of motion along. Returns
 * their sum, or NAN if no multiplier is trivial; all errors are then 0. */
static double direction_errors(const struct orbit_maps *o, double *each)
{
    const int n = o->n;
    double sum = 0, moved[FIELD_VARIABLES];
    memset(each, 0, (size_t)o->segments * sizeof *each);
    for (int i = 0; o->rate && i < o->segments; i++) {
        const double *next = o->rate + (i + 1) % o->segments * n;
        multiply(n, n, 1, o->map + i * n * n, o->rate + i * n, moved);
        for (int k = 0; k < n; k++)
            moved[k] -= next[k];
        sum += each[i] = vector_length(n, moved) / vector_length(n, next);
    }
    return o->rate ? sum : NAN;
}

/* Factors a [n][n] = q r by the Gram-Schmidt process, applied twice; q replaces a. */
static void orthogonalise(int n, double *a, double *r)
{
    memset(r, 0, (size_t)(n * n) * sizeof *r);
    for (int j = 0; j < n; j++) {
        for (int pass = 0; pass < 2; pass++)
            for (int k = 0; k < j; k++) {
                double projection = 0;
                for (int i = 0; i < n; i++)
                    projection += a[i * n + k] * a[i * n + j];
                for (int i = 0; i < n; i++)
                    a[i * n + j] -= projection * a[i * n + k];
                r[k * n + j] += projection;
            }
        double length = 0;
        for (int i = 0; i < n; i++)
            length = hypot(length, a[i * n + j]);
        r[j * n + j] = length;
        for (int i = 0; i < n && length > 0; i++)
            a[i * n + j] /= length;
    }
}

/* Carries the basis q once around the orbit. r becomes the product of the maps of all segments,
 * upper triangular. errors [segments] are relative errors of the maps, and uncertain [n] becomes
 * the relative uncertainty of the diagonal of r. */
static void carry_basis(int n, int segments, const double *map, const double *errors, double *q,
                        double *r, double *uncertain)
{
    square moved, triangle, product;
    for (int i = 0; i < n * n; i++)
        r[i] = i % (n + 1) == 0;
    memset(uncertain, 0, (size_t)n * sizeof *uncertain);
    for (int s = 0; s < segments; s++) {
        multiply(n, n, n, map + s * n * n, q, moved);
        orthogonalise(n, moved, triangle);
        memcpy(q, moved, (size_t)(n * n) * sizeof *q);
        multiply(n, n, n, triangle, r, product);
        memcpy(r, product, (size_t)(n * n) * sizeof *r);
        for (int k = 0; k < n; k++)
            uncertain[k] += errors[s] / triangle[k * n + k];
    }
}

/* Returns the magnitude of an eigenvalue. */
static double size_of(struct eigenvalue value)
{
    return hypot(value.re, value.im);
}

/* Sorts eigenvalues by falling magnitude. */
static void eigenvalues_sort(int n, struct eigenvalue *value)
{
    for (int i = 1; i < n; i++)
        for (int j = i; j > 0 && size_of(value[j]) > size_of(value[j - 1]); j--) {
            const struct eigenvalue swap = value[j];
            value[j] = value[j - 1];
            value[j - 1] = swap;
        }
}

/* Replaces the smallest multiplier, value[n - 1], by the product of all (log_determinant is its
 * logarithm, by Liouville's formula) divided by the others, if it is real and that is more
 * accurate. uncertain [n] are the relative errors; that of the smallest one is updated. */
static void correct_smallest(int n, double log_determinant, struct eigenvalue *value,
                             double *uncertain)
{
    double log_others = 0, sign = 1, error_sum = 0;
    for (int i = 0; i < n - 1; i++) {
        log_others += log(size_of(value[i]));
        error_sum += uncertain[i];
        if (value[i].im == 0)
            sign *= copysign(1, value[i].re);
    }
    if (value[n - 1].im == 0 && error_sum < uncertain[n - 1]) {
        value[n - 1].re = sign * exp(log_determinant - log_others);
        uncertain[n - 1] = error_sum;
    }
}

/* Projects out the direction of motion, carries a basis around, and takes the eigenvalues of the
 * result. */
bool orbit_multipliers(const struct orbit_maps *o, double tol, struct multipliers *m)
{
    const int n = o->rate ? o->n - 1 : o->n;
    double map[CURVE_MAX * FIELD_VARIABLES], errors[CURVE_MAX];
    *m = (struct multipliers){.count = n, .trivial = direction_errors(o, errors)};
    if (n == 0)
        return true;
    /* Directions across the orbit are no better known than the direction of motion: where this
     * turns, little may be left across of what has grown. */
    for (int s = 0; s < o->segments; s++)
        errors[s] = (errors[s] + tol) * vector_length(o->n * o->n, o->map + s * o->n * o->n);
    square q, r, turned, basis_change;
    double uncertain[FIELD_VARIABLES], first[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int s = 0; s < o->segments; s++) {
        const double *given = o->map + s * o->n * o->n;
        if (o->rate)
            transverse_map(o->n, given, o->rate + s * o->n, o->rate + (s + 1) % o->segments * o->n,
                           map + s * n * n);
        else
            memcpy(map + s * n * n, given, (size_t)(n * n) * sizeof *given);
    }
    for (int i = 0; i < n * n; i++)
        q[i] = i % (n + 1) == 0;
    for (int sweep = 0; sweep < (n > 1 ? QR_SWEEPS : 1); sweep++) {
        memcpy(first, q, sizeof first);
        carry_basis(n, o->segments, map, errors, q, r, uncertain);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            turned[i * n + j] = first[j * n + i];
    multiply(n, n, n, turned, q, basis_change);
    multiply(n, n, n, basis_change, r, turned);
    if (!matrix_eigenvalues(n, turned, m->value))
        return false;
    eigenvalues_sort(n, m->value);
    correct_smallest(n, o->log_determinant, m->value, uncertain);
    m->log_determinant = o->log_determinant;
    for (int k = 0; k < n; k++)
        if (!(uncertain[k] < MULTIPLIER_KNOWN_RELATIVE))
            m->noise = fmax(m->noise, size_of(m->value[k]));
    return true;
}

/* Returns x - reference, divided by |x| if that exceeds 1, so that products of many do not
 * overflow. */
static double bounded_difference(double x, double reference)
{
    return (x - reference) / fmax(1, fabs(x));
}

/* Returns the product of (multiplier + 1) over all, scaled to avoid overflow. */
double multipliers_doubling(const struct multipliers *m)
{
    double product = m->noise > SIGN_NOISE_MAX ? NAN : 1;
    for (int i = 0; i < m->count; i++) {
        const struct eigenvalue v = m->value[i];
        product *=
            v.im == 0 ? bounded_difference(v.re, -1) : hypot(v.re + 1, v.im) / fmax(1, size_of(v));
    }
    return product;
}

/* Returns the product of (product of two - 1) over all pairs, scaled to avoid overflow. */
double multipliers_torus(const struct multipliers *m)
{
    double product = m->noise > SIGN_NOISE_MAX ? NAN : 1;
    if (m->count == 2) /* exact where volumes are kept: it is 0 all along */
        return product * bounded_difference(exp(m->log_determinant), 1);
    for (int i = 0; i < m->count; i++)
        for (int j = i + 1; j < m->count; j++) {
            const struct eigenvalue a = m->value[i], b = m->value[j];
            const double re = a.re * b.re - a.im * b.im, im = a.re * b.im + a.im * b.re;
            const bool pair = a.re == b.re && a.im == -b.im;
            product *= pair || im == 0 ? bounded_difference(re, 1)
                                       : hypot(re - 1, im) / fmax(1, hypot(re, im));
        }
    return product;
}
