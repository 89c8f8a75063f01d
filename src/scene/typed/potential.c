/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The potential of typed forces for which nobody typed one: minus the integral of the force along a
 * path, by adaptive Gauss-Kronrod quadrature. In one coordinate there always is one. In several the
 * Jacobian has to be symmetric, which masses of their own may make it (x2'' = (x1 - 2*x2)/3); and
 * the integral between pairs of points has to be the difference of their potentials, which a whirl
 * about a pole or a force with a jump has not.
 */
#include <hooke/base/elementary.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* ---- quadrature ---- */

/* Seven and fifteen points (Piessens et al. 1983, QUADPACK, qk15). Odd places and the last are
 * Gauss's, too. */
#define NODES 8
static const double node[NODES] = {
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
    0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
    0.586087235467691130294144691693312, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0};
static const double kronrod[NODES] = {
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
    0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
    0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
static const double gauss[NODES / 2] = {
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
    for (int k = 0; k < NODES; k++) {
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

/* of the difference between both rules, which is that of the coarser one */
#define ACCURACY 1e-11
#define DEPTH 48 /* halvings of a stretch: a jump that nobody located is enclosed that closely */
#define PIECES 400
#define LOOKS 32     /* at switches, at even parts of what is left of a path */
#define BEHIND 1e-12 /* of it: where a branch is told that begins at a switch */

/* False: others than *first, which are those behind `from`. */
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

/* Where the first switch behind `from` is, to the last place; 1: there is none. */
static double next_switch(const struct force_path *path, double from)
{
    const struct typed_part *part = path->term->part;
    double q[LIMIT_VARIABLES], along[LIMIT_VARIABLES], first[LIMIT_TYPED_SWITCHES];
    double a = from + (1 - from) * BEHIND, b = a;
    if (part->switches.count == 0)
        return 1;
    memset(q + path->rows, 0, (size_t)path->rows * sizeof *q);
    path->at(path, a, q, along);
    typed_branches_at(part, path->c, q, first);
    for (int k = 1; k <= LOOKS && a == b; k++) {
        const double s = k < LOOKS ? from + (1 - from) * k / LOOKS : 1;
        b = s;
        if (same_branches(path, s, first))
            a = s;
    }
    for (double s = a + (b - a) / 2; s > a && s < b; s = a + (b - a) / 2)
        *(same_branches(path, s, first) ? &a : &b) = s;
    return b;
}

struct quadrature {
    double value, size; /* of the integral so far, and of its magnitude */
    double total;       /* of the magnitude of all of it, about */
    int pieces;
};

/* Adds the integral from `from` to `to`, between which the force is smooth. False: it does not
 * converge. */
static bool add_smooth(const struct force_path *path, double from, double to,
                       struct quadrature *sums)
{
    double ends[DEPTH + 1] = {to}, part, error;
    for (int depth = 0; sums->pieces < PIECES; sums->pieces++) {
        const double value = piece(path, from, ends[depth], &part, &error);
        sums->total = fmax(sums->total, sums->size + part);
        if (!isfinite(value))
            return false;
        if (error <= ACCURACY * sums->total) {
            sums->value += value;
            sums->size += part;
            from = ends[depth];
            if (depth-- == 0)
                return true;
        } else if (depth == DEPTH) {
            return false;
        } else {
            ends[depth + 1] = (from + ends[depth]) / 2;
            depth++;
        }
    }
    return false;
}

/* The integral over s from 0 to 1, and that of its magnitude; NAN: it does not converge. */
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
 * About 0 and not through it, from (1, 0, ...) or, in one coordinate, from the 1 of the same sign:
 * the logarithm of the radius and the angle grow evenly. With q = r (cos, sin u) the unit vector u
 * is across the first axis.
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

/* ---- potentials ---- */

static double along_path(const double *c, const double *y,
                         void (*at)(const struct force_path *path, double s, double *q,
                                    double *along),
                         double *size)
{
    const struct typed_term *term = typed_term_of(c);
    double mass[LIMIT_VARIABLES];
    typed_masses(c, mass);
    const struct force_path path = {term, c, typed_rows(term->typed), mass, NULL, y, at};
    return -integral(&path, size);
}

/* a(q) = a(0) + A q */
static double linear_potential(const double *c, const double *y)
{
    const struct typed_term *term = typed_term_of(c);
    const int rows = typed_rows(term->typed);
    double q[LIMIT_VARIABLES] = {0}, at0[LIMIT_VARIABLES], a[LIMIT_VARIABLES],
           mass[LIMIT_VARIABLES], sum = 0;
    typed_masses(c, mass);
    typed_evaluate(term->add, c, 0, q, at0);
    memcpy(q, y, (size_t)rows * sizeof *q);
    typed_evaluate(term->add, c, 0, q, a);
    for (int i = 0; i < rows; i++)
        sum += mass[i] * q[i] * (at0[i] + a[i]);
    return -sum / 2;
}

static double origin_potential(const double *c, const double *y)
{
    double size;
    return along_path(c, y, from_origin, &size);
}

static double infinity_potential(const double *c, const double *y)
{
    double size;
    return along_path(c, y, from_infinity, &size);
}

static double around_potential(const double *c, const double *y)
{
    double size;
    return along_path(c, y, around_origin, &size);
}

/* In the order in which they are tried; the first is for linear forces. */
static double (*const potentials[TYPED_FOUND])(const double *c, const double *y) = {
    linear_potential, origin_potential, infinity_potential, around_potential};

void typed_found_rows(struct typed_part *part)
{
    for (int i = 0; i < TYPED_FOUND; i++) {
        part->found[i] = part->term[GROUP_FORCE].row;
        part->found[i].flags |= TERM_CONSERVATIVE;
        part->found[i].potential = potentials[i];
        part->found[i].power = NULL;
    }
}

bool typed_potential_is_integrated(const struct system *system)
{
    for (int t = 0; t < system->terms; t++)
        for (int i = 1; i < TYPED_FOUND; i++)
            if (system->term[t].row->potential == potentials[i])
                return true;
    return false;
}

/* ---- is there one? ---- */

#define POINTS 8
#define REACH 3.0 /* natural sizes */

/* of the largest: a coordinate that the trial run did not reach is tried so far */
#define SIDE 1.0

static double largest_scale(const struct system *system)
{
    double largest = 0;
    for (int i = 0; i < system->n / 2; i++)
        largest = fmax(largest, system->scale[i]);
    return largest;
}

/* Points where the force is finite. Returns how many were found. */
static int choose_points(const struct system *system, const struct typed_term *term,
                         const double *c, double point[][LIMIT_VARIABLES])
{
    const int rows = system->n / 2;
    const double side = SIDE * largest_scale(system);
    uint64_t random = 1;
    int count = 0;
    for (int tries = 0; tries < 4 * POINTS && count < POINTS; tries++) {
        double a[LIMIT_VARIABLES];
        bool finite = true;
        memset(point[count], 0, sizeof point[count]);
        for (int i = 0; i < rows; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            point[count][i] =
                REACH * fmax(system->scale[i], side) * ldexp((double)(int64_t)random, -63);
        }
        typed_evaluate(term->add, c, 0, point[count], a);
        for (int i = 0; i < rows; i++)
            finite = finite && isfinite(a[i]);
        count += finite;
    }
    return count;
}

/* Is m_i d a_i/d q_j = m_j d a_j/d q_i in jac [rows][n]? ratio [rows]: of the masses */
static bool is_symmetric(int rows, int n, const double *jac, const double *ratio)
{
    const double tolerated = 1e-12;
    double size = 0, twist = 0;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++) {
            size = fmax(size, fabs(ratio[i] * jac[i * n + j]));
            twist = fmax(twist, fabs(ratio[i] * jac[i * n + j] - ratio[j] * jac[j * n + i]));
        }
    return isfinite(size) && twist <= tolerated * size;
}

/*
 * Ratios of masses from pairs that act on each other, from the first coordinate on; the first of
 * those that nothing connects to it has its mass.
 */
static void find_ratios(int rows, int n, const double *jac, int count, double *ratio)
{
    int queue[LIMIT_VARIABLES], known = 0;
    for (int i = 0; i < rows; i++)
        ratio[i] = 0;
    for (int first = 0; first < rows; first++) {
        if (ratio[first] > 0)
            continue;
        ratio[first] = 1;
        queue[known++] = first;
        for (int next = known - 1; next < known; next++)
            for (int j = 0, i = queue[next]; j < rows; j++)
                for (int k = 0; k < count && ratio[j] == 0; k++) {
                    const double *at = jac + (size_t)k * (size_t)(rows * n), forth = at[i * n + j],
                                 back = at[j * n + i];
                    if (forth / back > 0 && isfinite(forth / back)) {
                        ratio[j] = ratio[i] * (forth / back);
                        queue[known++] = j;
                    }
                }
    }
}

/* Masses with which the Jacobian is symmetric at all points; true, and 1: it is so without. */
static bool find_masses(const struct typed_term *term, const double *c,
                        double point[][LIMIT_VARIABLES], int count, double *ratio)
{
    const int rows = typed_rows(term->typed), n = term->typed->model.n, size = rows * n;
    double *jac = calloc((size_t)(count * size + 1), sizeof *jac);
    bool alike = jac, found = jac;
    for (int i = 0; i < rows; i++)
        ratio[i] = 1;
    for (int k = 0; jac && k < count; k++) {
        typed_evaluate(term->jacobian, c, 0, point[k], jac + k * size);
        alike = alike && is_symmetric(rows, n, jac + k * size, ratio);
    }
    if (jac && !alike && typed_ratios_fit(term)) {
        find_ratios(rows, n, jac, count, ratio);
        for (int k = 0; k < count; k++)
            found = found && is_symmetric(rows, n, jac + k * size, ratio);
    } else {
        found = alike;
    }
    free(jac);
    return found;
}

static void set_masses(struct system *system, const double *ratio)
{
    const int rows = system->n / 2;
    bool alike = true;
    for (int i = 0; i < rows; i++)
        alike = alike && ratio[i] == 1;
    for (int i = 0; i < rows && !alike; i++) {
        system->ratio[i] = ratio[i];
        for (int k = 0; k < system->terms; k++)
            system->term[k].c[TERM_VALUES - 1 - i] = ratio[i];
    }
}

/* Is the integral from a to b what the potential says? */
static bool fits_between(const struct typed_term *term, const double *c, const double *a,
                         const double *b, double potential_a, double potential_b)
{
    const double tolerated = 1e-8;
    double mass[LIMIT_VARIABLES];
    typed_masses(c, mass);
    const struct force_path path = {term, c, typed_rows(term->typed), mass, a, b, straight};
    double size = 0;
    const double fall = integral(&path, &size);
    return fabs(potential_a - potential_b - fall) <=
           tolerated * (fabs(potential_a) + fabs(potential_b) + size);
}

static bool is_potential(double (*potential)(const double *c, const double *y),
                         const struct typed_term *term, const double *c,
                         double point[][LIMIT_VARIABLES], int count)
{
    double value[POINTS];
    for (int k = 0; k < count; k++) {
        value[k] = potential(c, point[k]);
        if (!isfinite(value[k]))
            return false;
    }
    for (int k = 0; typed_rows(term->typed) > 1 && k < count; k++)
        if (!fits_between(term, c, point[k], point[(k + 1) % count], value[k],
                          value[(k + 1) % count]))
            return false;
    return true;
}

bool typed_find_potential(struct system *system)
{
    const struct typed_part *part = typed_term_of(system->typed.c)->part;
    const struct typed_term *term = &part->term[GROUP_FORCE];
    struct bound_term *bound = NULL;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row == &term->row && !term->row.potential)
            bound = &system->term[i];
    if (!bound || system->order != 2 || term->typed->base)
        return false;
    double point[POINTS][LIMIT_VARIABLES];
    const int count = choose_points(system, term, bound->c, point);
    double ratio[LIMIT_VARIABLES];
    const struct system before = *system;
    if (system->n > 2 && !find_masses(term, bound->c, point, count, ratio))
        return false;
    if (system->n > 2)
        set_masses(system, ratio);
    const bool linear = term->row.flags & TERM_LINEAR;
    for (int i = linear ? 0 : 1; i < (linear ? 1 : TYPED_FOUND) && count > 0; i++)
        if (linear || is_potential(potentials[i], term, bound->c, point, count)) {
            bound->row = &part->found[i];
            return true;
        }
    *system = before;
    return false;
}

/* Nothing is left of it at rest. */
static bool is_drag(const struct system *system, const struct bound_term *bound)
{
    const struct typed_term *term = typed_term_of(bound->c);
    double point[POINTS][LIMIT_VARIABLES], a[LIMIT_VARIABLES];
    const int count = choose_points(system, term, bound->c, point);
    for (int k = 0; k < count; k++) {
        typed_evaluate(term->add, bound->c, system->t0, point[k], a);
        for (int i = 0; i < system->n / 2; i++)
            if (a[i] != 0)
                return false;
    }
    return true;
}

bool typed_has_energy(const struct system *system)
{
    for (int i = 0; i < system->terms && !typed_base(system->model); i++) {
        const struct term_row *row = system->term[i].row;
        if (row->potential || (!row->jacobian && !(row->flags & TERM_VELOCITY)))
            continue;
        if (!(row->flags & TERM_VELOCITY) || !is_drag(system, &system->term[i]))
            return false;
    }
    return true;
}
