/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The work of typed forces along a path, by adaptive Gauss-Kronrod quadrature between switches. */
#include <hooke/base/elementary.h>

#include <math.h>
#include <string.h>

#include "scene/typed/typed.h"

/* ---- quadrature ---- */

/* Seven and fifteen points (Piessens et al. 1983, QUADPACK, qk15). Odd places and the last are
 * Gauss's, too. */
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
    const double *mass, *from, *to; /* [rows] */
    /* q and dq/ds [rows] */
    void (*at)(const struct force_path *path, double s, double *q, double *along);
};

static double force_along(const struct force_path *path, double s)
{
    const int rows = path->rows;
    double q[LIMIT_VARIABLES], along[LIMIT_VARIABLES], a[LIMIT_VARIABLES], sum = 0;
    memset(q + rows, 0, (size_t)rows * sizeof *q);
    path->at(path, s, q, along);
    typed_evaluate(path->term->add, path->c, 0, q, a);
    for (int i = 0; i < rows; i++)
        sum += path->mass[i] * along[i] * a[i];
    return sum;
}

/* *size: of the integral of |f|, *error: about how wrong it is. */
static double piece(const struct force_path *path, double from, double to, double *size,
                    double *error)
{
    const double half = (to - from) / 2, middle = (from + to) / 2;
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

/* Returns true if the branches are *first, which are those just beyond `from`. */
static bool same_branches(const struct force_path *path, double s, const double *first)
{
    const struct typed_part *part = path->term->part;
    double q[LIMIT_VARIABLES], along[LIMIT_VARIABLES], branch[LIMIT_TYPED_SWITCHES];
    memset(q + path->rows, 0, (size_t)path->rows * sizeof *q);
    path->at(path, s, q, along);
    typed_branches_at(part, path->c, q, branch);
    for (int i = 0; i < part->switches.count; i++)
        if (branch[i] != first[i])
            return false;
    return true;
}

/* Returns the position of the first switch beyond `from`, to the last place, or 1 if there is
 * none. */
static double next_switch(const struct force_path *path, double from)
{
    const struct typed_part *part = path->term->part;
    double q[LIMIT_VARIABLES], along[LIMIT_VARIABLES], first[LIMIT_TYPED_SWITCHES];
    double a = from + (1 - from) * BRANCH_OFFSET, b = a;
    if (part->switches.count == 0)
        return 1;
    memset(q + path->rows, 0, (size_t)path->rows * sizeof *q);
    path->at(path, a, q, along);
    typed_branches_at(part, path->c, q, first);
    for (int k = 1; k <= SWITCH_CHECKS && a == b; k++) {
        const double s = k < SWITCH_CHECKS ? from + (1 - from) * k / SWITCH_CHECKS : 1;
        b = s;
        if (same_branches(path, s, first))
            a = s;
    }
    for (double s = a + (b - a) / 2; s > a && s < b; s = a + (b - a) / 2)
        *(same_branches(path, s, first) ? &a : &b) = s;
    return b;
}

struct quadrature {
    double value, size; /* integral so far, and that of the magnitude */
    double total;       /* approximate integral of the whole magnitude */
    int pieces;
};

/* Adds the integral from `from` to `to`, between which the force is smooth. Returns false if it
 * does not converge. */
static bool add_smooth(const struct force_path *path, double from, double to,
                       struct quadrature *sums)
{
    double ends[INTERVAL_HALVINGS_MAX + 1] = {to}, part, error;
    for (int depth = 0; sums->pieces < WORK_INTERVALS_MAX; sums->pieces++) {
        const double value = piece(path, from, ends[depth], &part, &error);
        sums->total = fmax(sums->total, sums->size + part);
        if (!isfinite(value))
            return false;
        if (error <= QUADRATURE_TOLERANCE * sums->total) {
            sums->value += value;
            sums->size += part;
            from = ends[depth];
            if (depth-- == 0)
                return true;
        } else if (depth == INTERVAL_HALVINGS_MAX) {
            return false;
        } else {
            ends[depth + 1] = (from + ends[depth]) / 2;
            depth++;
        }
    }
    return false;
}

/* The integral over s from 0 to 1, and that of its magnitude; NAN if it does not converge. */
static double integral(const struct force_path *path, double *size)
{
    struct quadrature sums = {0};
    double from = 0;
    while (from < 1) {
        const double to = next_switch(path, from);
        if (!add_smooth(path, from, to, &sums))
            return NAN;
        from = to;
    }
    *size = sums.size;
    return sums.value;
}

/* ---- paths ---- */

static void straight(const struct force_path *path, double s, double *q, double *along)
{
    for (int i = 0; i < path->rows; i++) {
        along[i] = path->to[i] - path->from[i];
        q[i] = path->from[i] + s * along[i];
    }
}

static void from_origin(const struct force_path *path, double s, double *q, double *along)
{
    for (int i = 0; i < path->rows; i++) {
        q[i] = s * path->to[i];
        along[i] = path->to[i];
    }
}

static void from_infinity(const struct force_path *path, double s, double *q, double *along)
{
    for (int i = 0; i < path->rows; i++) {
        q[i] = path->to[i] / s;
        along[i] = -path->to[i] / (s * s);
    }
}

static double length(const double *q, int rows)
{
    double r = 0;
    for (int i = 0; i < rows; i++)
        r = fixed_hypot(r, q[i]);
    return r;
}

/*
 * Goes around 0 and not through it, from (1, 0, ...) or, in one coordinate, from the 1 of the same
 * sign: the logarithm of the radius and the angle grow evenly. With q = r (cos, sin u) the unit
 * vector u is across the first axis.
 */
static void around_origin(const struct force_path *path, double s, double *q, double *along)
{
    const int rows = path->rows;
    const double r = length(path->to, rows), across = length(path->to + 1, rows - 1),
                 rate = fixed_log(r), at = fixed_pow(r, s);
    const double turn = rows > 1 ? fixed_atan2(across, path->to[0]) : 0,
                 sign = rows == 1 && path->to[0] < 0 ? -1 : 1;
    q[0] = sign * at * fixed_cos(s * turn);
    along[0] = rate * q[0] - sign * at * turn * fixed_sin(s * turn);
    for (int i = 1; i < rows; i++) {
        const double u = across > 0 ? path->to[i] / across : i == 1;
        q[i] = at * fixed_sin(s * turn) * u;
        along[i] = rate * q[i] + at * turn * fixed_cos(s * turn) * u;
    }
}

double typed_work(const double *c, enum typed_path shape, const double *from, const double *to,
                  double *size)
{
    static void (*const along[])(const struct force_path *path, double s, double *q,
                                 double *along) = {
        [PATH_STRAIGHT] = straight,
        [PATH_FROM_ORIGIN] = from_origin,
        [PATH_FROM_INFINITY] = from_infinity,
        [PATH_AROUND_ORIGIN] = around_origin,
    };
    const struct typed_term *term = typed_term_of(c);
    double mass[LIMIT_VARIABLES];
    typed_masses(c, mass);
    const struct force_path path = {term, c, typed_rows(term->typed), mass, from, to, along[shape]};
    return integral(&path, size);
}
