/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The work of typed forces along a path, by adaptive Gauss-Kronrod quadrature between switches. */
#include <hooke/base/elementary.h>

#include <math.h>
#include <string.h>

#include "scene/typed/typed.h"

/* ---- quadrature ---- */

/* Nodes and weights of Gauss's rule with seven points and Kronrod's with fifteen (Piessens et al.
 * 1983, QUADPACK, qk15). Gauss's nodes are those with odd index. */
#define KRONROD_NODES 8
static const double node[KRONROD_NODES] = {
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691693312, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0};
static const double kronrod[KRONROD_NODES] = {
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
static const double gauss[KRONROD_NODES / 2] = {
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
    0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

/* The force along a path q(s), 0 <= s <= 1. */
struct force_path {
    const struct typed_term *term;
    const double *c;
    int rows;
    const double *mass, *q_begin, *q_end; /* [rows] */
    /* computes q(s) and its tangent dq/ds [rows] */
    void (*evaluate)(const struct force_path *path, double s, double *q, double *tangent);
};

/* Returns the force along the path, mass times acceleration times tangent [J], at s. */
static double force_along(const struct force_path *path, double s)
{
    const int rows = path->rows;
    double q[LIMIT_VARIABLES], tangent[LIMIT_VARIABLES], a[LIMIT_VARIABLES], sum = 0;
    memset(q + rows, 0, (size_t)rows * sizeof *q);
    path->evaluate(path, s, q, tangent);
    typed_evaluate(path->term->add, path->c, 0, q, a);
    for (int i = 0; i < rows; i++)
        sum += path->mass[i] * tangent[i] * a[i];
    return sum;
}

/* Returns the integral of the force from s_begin to s_end by Kronrod's rule. Sets *size to the
 * integral of its magnitude and *error to its difference from Gauss's rule. */
static double kronrod_integral(const struct force_path *path, double s_begin, double s_end,
                               double *size, double *error)
{
    const double half = (s_end - s_begin) / 2, middle = (s_begin + s_end) / 2;
    double fine = 0, coarse = 0, sum = 0;
    for (int k = 0; k < KRONROD_NODES; k++) {
        const double a = force_along(path, middle - half * node[k]),
                     b = node[k] > 0 ? force_along(path, middle + half * node[k]) : 0;
        fine += kronrod[k] * (a + b);
        sum += kronrod[k] * (fabs(a) + fabs(b));
        coarse += k % 2 ? gauss[k / 2] * (a + b) : 0;
    }
    *size = half * sum;
    *error = half * fabs(fine - coarse);
    return half * fine;
}

/* Tolerance for the difference between both rules, which is the error of the coarser one. */
#define QUADRATURE_TOLERANCE 1e-11
/* Halvings of an interval; they enclose a jump that no switch located. */
#define INTERVAL_HALVINGS_MAX 48
#define WORK_INTERVALS_MAX 400
/* Number of equal parts of the remaining path at which switches are checked. */
#define SWITCH_CHECKS 32
/* Part of the remaining path after which the branch that begins at a switch is evaluated. */
#define BRANCH_OFFSET 1e-12

/* Returns true if the branches of all switches at s are `first`. */
static bool same_branches(const struct force_path *path, double s, const double *first)
{
    const struct typed_part *part = path->term->part;
    double q[LIMIT_VARIABLES], tangent[LIMIT_VARIABLES], branch[LIMIT_TYPED_SWITCHES];
    memset(q + path->rows, 0, (size_t)path->rows * sizeof *q);
    path->evaluate(path, s, q, tangent);
    typed_branches_at(part, path->c, q, branch);
    for (int i = 0; i < part->switches.count; i++)
        if (branch[i] != first[i])
            return false;
    return true;
}

/* Returns the position of the first switch beyond `s_begin`, to the last place, or 1 if there is
 * none. */
static double next_switch(const struct force_path *path, double s_begin)
{
    const struct typed_part *part = path->term->part;
    double q[LIMIT_VARIABLES], tangent[LIMIT_VARIABLES], first[LIMIT_TYPED_SWITCHES];
    double a = s_begin + (1 - s_begin) * BRANCH_OFFSET, b = a;
    if (part->switches.count == 0)
        return 1;
    memset(q + path->rows, 0, (size_t)path->rows * sizeof *q);
    path->evaluate(path, a, q, tangent);
    typed_branches_at(part, path->c, q, first);
    for (int k = 1; k <= SWITCH_CHECKS && a == b; k++) {
        const double s = k < SWITCH_CHECKS ? s_begin + (1 - s_begin) * k / SWITCH_CHECKS : 1;
        b = s;
        if (same_branches(path, s, first))
            a = s;
    }
    for (double s = a + (b - a) / 2; s > a && s < b; s = a + (b - a) / 2)
        *(same_branches(path, s, first) ? &a : &b) = s;
    return b;
}

/* Sums of an integral. */
struct quadrature {
    double value, size; /* integral so far, and that of the magnitude */
    double total;       /* approximate integral of the whole magnitude */
    int pieces;
};

/* Adds the integral from `s_begin` to `s_end`, between which the force is smooth. Returns false if
 * it does not converge. */
static bool add_smooth(const struct force_path *path, double s_begin, double s_end,
                       struct quadrature *sums)
{
    double ends[INTERVAL_HALVINGS_MAX + 1] = {s_end}, part, error;
    for (int depth = 0; sums->pieces < WORK_INTERVALS_MAX; sums->pieces++) {
        const double value = kronrod_integral(path, s_begin, ends[depth], &part, &error);
        sums->total = fmax(sums->total, sums->size + part);
        if (!isfinite(value))
            return false;
        if (error <= QUADRATURE_TOLERANCE * sums->total) {
            sums->value += value;
            sums->size += part;
            s_begin = ends[depth];
            if (depth-- == 0)
                return true;
        } else if (depth == INTERVAL_HALVINGS_MAX) {
            return false;
        } else {
            ends[depth + 1] = (s_begin + ends[depth]) / 2;
            depth++;
        }
    }
    return false;
}

/* Returns the integral over s from 0 to 1, and sets *size to that of the magnitude; NAN if it does
 * not converge. */
static double path_integral(const struct force_path *path, double *size)
{
    struct quadrature sums = {0};
    double s_begin = 0;
    while (s_begin < 1) {
        const double s_end = next_switch(path, s_begin);
        if (!add_smooth(path, s_begin, s_end, &sums))
            return NAN;
        s_begin = s_end;
    }
    *size = sums.size;
    return sums.value;
}

/* ---- paths ---- */

/* The straight line from q_begin to q_end. */
static void straight(const struct force_path *path, double s, double *q, double *tangent)
{
    for (int i = 0; i < path->rows; i++) {
        tangent[i] = path->q_end[i] - path->q_begin[i];
        q[i] = path->q_begin[i] + s * tangent[i];
    }
}

/* The straight line from the origin to q_end. */
static void from_origin(const struct force_path *path, double s, double *q, double *tangent)
{
    for (int i = 0; i < path->rows; i++) {
        q[i] = s * path->q_end[i];
        tangent[i] = path->q_end[i];
    }
}

/* The ray that ends at q_end, by q_end / s. */
static void from_infinity(const struct force_path *path, double s, double *q, double *tangent)
{
    for (int i = 0; i < path->rows; i++) {
        q[i] = path->q_end[i] / s;
        tangent[i] = -path->q_end[i] / (s * s);
    }
}

/* Returns the length of q [rows]. */
static double position_length(const double *q, int rows)
{
    double r = 0;
    for (int i = 0; i < rows; i++)
        r = fixed_hypot(r, q[i]);
    return r;
}

/* Sets q and tangent [rows] to the point at s (0 to 1) of a path to path->q_end that goes around 0,
 * not through it, and to the derivative by s. The path begins at (1, 0, ...) or, in one coordinate,
 * at the 1 of the same sign; the logarithm of the radius and the angle grow evenly. With q = r
 * (cos, sin u) the unit vector u is across the first axis. */
static void around_origin(const struct force_path *path, double s, double *q, double *tangent)
{
    const int rows = path->rows;
    const double r = position_length(path->q_end, rows),
                 transverse = position_length(path->q_end + 1, rows - 1), rate = fixed_log(r),
                 radius = fixed_pow(r, s);
    const double turn = rows > 1 ? fixed_atan2(transverse, path->q_end[0]) : 0;
    const double sign = rows == 1 && path->q_end[0] < 0 ? -1 : 1;
    q[0] = sign * radius * fixed_cos(s * turn);
    tangent[0] = rate * q[0] - sign * radius * turn * fixed_sin(s * turn);
    for (int i = 1; i < rows; i++) {
        const double u = transverse > 0 ? path->q_end[i] / transverse : i == 1;
        q[i] = radius * fixed_sin(s * turn) * u;
        tangent[i] = rate * q[i] + radius * turn * fixed_cos(s * turn) * u;
    }
}

/* Integrates the force along a path of this shape. */
double typed_work(const double *c, enum typed_path shape, const double *q_begin,
                  const double *q_end, double *size)
{
    static void (*const evaluators[])(const struct force_path *path, double s, double *q,
                                      double *tangent) = {
        [PATH_STRAIGHT] = straight,
        [PATH_FROM_ORIGIN] = from_origin,
        [PATH_FROM_INFINITY] = from_infinity,
        [PATH_AROUND_ORIGIN] = around_origin,
    };
    const struct typed_term *term = typed_term_of(c);
    double mass[LIMIT_VARIABLES];
    typed_masses(c, mass);
    const struct force_path path = {term,    c,     typed_rows(term->typed), mass,
                                    q_begin, q_end, evaluators[shape]};
    return path_integral(&path, size);
}
