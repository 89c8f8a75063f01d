/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Potentials of typed forces for which none was typed: minus the integral of the force, as a
 * formula if one is found, else along a path (work.c). In one coordinate there always is one. In
 * several, the Jacobian has to be symmetric, perhaps with masses of their own (x2'' = (x1 -
 * 2*x2)/3); and the integral between pairs of points has to be the difference of their potentials,
 * which excludes a whirl about a pole and forces with a jump. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* ---- potentials ---- */

/* Returns the potential of a linear force a(q) = a(0) + A q. */
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

/* Returns the potential by the parts of a formula, less those at a point: the origin for point = 1,
 * the unit point for 2, none for 0. NAN if there is no formula. */
static double parts_potential(const struct program *program, const double *c, const double *y,
                              int point)
{
    const int rows = typed_rows(typed_term_of(c)->typed);
    double part[3 * LIMIT_VARIABLES], mass[LIMIT_VARIABLES], sum = 0;
    if (!program)
        return NAN;
    typed_masses(c, mass);
    typed_evaluate(program, c, 0, y, part);
    for (int i = 0; i < rows; i++)
        sum += mass[i] * (point > 0 ? part[i] - part[point * rows + i] : part[i]);
    return sum;
}

static double formula_from_origin(const double *c, const double *y)
{
    return parts_potential(typed_term_of(c)->parts, c, y, 1);
}

static double formula_along_axes(const double *c, const double *y)
{
    return parts_potential(typed_term_of(c)->axes, c, y, 0);
}

static double formula_from_infinity(const double *c, const double *y)
{
    return parts_potential(typed_term_of(c)->parts, c, y, 0);
}

static double formula_from_unit(const double *c, const double *y)
{
    return parts_potential(typed_term_of(c)->parts, c, y, 2);
}

static double origin_potential(const double *c, const double *y)
{
    double size;
    return -typed_work(c, PATH_FROM_ORIGIN, NULL, y, &size);
}

static double infinity_potential(const double *c, const double *y)
{
    double size;
    return -typed_work(c, PATH_FROM_INFINITY, NULL, y, &size);
}

static double around_potential(const double *c, const double *y)
{
    double size;
    return -typed_work(c, PATH_AROUND_ORIGIN, NULL, y, &size);
}

/* Potentials in the order in which they are tried; the first is for linear forces. */
static double (*const potentials[TYPED_FOUND])(const double *c, const double *y) = {
    linear_potential,  formula_from_origin, formula_along_axes, formula_from_infinity,
    formula_from_unit, origin_potential,    infinity_potential, around_potential};
enum { FIRST_QUADRATURE = 5 };

/* Makes one row for each way to find a potential. */
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
        for (int i = FIRST_QUADRATURE; i < TYPED_FOUND; i++)
            if (system->term[t].row->potential == potentials[i])
                return true;
    return false;
}

/* ---- existence of a potential ---- */

#define CURL_POINTS 8
#define SAMPLE_REACH 3.0 /* Test points lie within this many natural sizes of 0. */

/* A coordinate that the trial run did not reach is tested up to this part of the largest scale. */
#define UNREACHED_SCALE 1.0

/* Returns the largest natural size of the positions. */
static double largest_scale(const struct system *system)
{
    double largest = 0;
    for (int i = 0; i < system->n / 2; i++)
        largest = fmax(largest, system->scale[i]);
    return largest;
}

/* Chooses random points at which the force is finite, at most CURL_POINTS. Returns how many were
 * found. */
static int choose_points(const struct system *system, const struct typed_term *term,
                         const double *c, double point[][LIMIT_VARIABLES])
{
    const int rows = system->n / 2;
    const double side = UNREACHED_SCALE * largest_scale(system);
    uint64_t random = 1;
    int count = 0;
    for (int tries = 0; tries < 4 * CURL_POINTS && count < CURL_POINTS; tries++) {
        double a[LIMIT_VARIABLES];
        bool finite = true;
        memset(point[count], 0, sizeof point[count]);
        for (int i = 0; i < rows; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            point[count][i] =
                SAMPLE_REACH * fmax(system->scale[i], side) * ldexp((double)(int64_t)random, -63);
        }
        typed_evaluate(term->add, c, 0, point[count], a);
        for (int i = 0; i < rows; i++)
            finite = finite && isfinite(a[i]);
        count += finite;
    }
    return count;
}

/* Returns true if m_i d a_i/d q_j = m_j d a_j/d q_i for the Jacobian jac [rows][n] and masses in
 * the ratio [rows]. */
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

/* Finds ratios of masses, ratio [rows], with which the actions of pairs of coordinates on each
 * other are equal, so that the forces can have a potential. jac holds `count` Jacobians [rows][n]
 * at several states. Coordinates connected to each other get ratios to the first one of them, which
 * is 1. */
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
                    const double *jacobian = jac + (size_t)k * (size_t)(rows * n),
                                 forth = jacobian[i * n + j], back = jacobian[j * n + i];
                    if (forth / back > 0 && isfinite(forth / back)) {
                        ratio[j] = ratio[i] * (forth / back);
                        queue[known++] = j;
                    }
                }
    }
}

/* Finds masses, ratio [rows], that make the Jacobian of the term with coefficients c symmetric at
 * all `count` points; all 1 if it is symmetric already. Returns false if there are none or if out
 * of memory. */
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

/* Enters the ratios of masses into the system and its terms, unless all are 1. */
static void ratios_enter(struct system *system, const double *ratio)
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

/* Returns true if the integral from a to b agrees with the difference of the potential. */
static bool fits_between(const double *c, const double *a, const double *b, double potential_a,
                         double potential_b)
{
    const double tolerated = 1e-8;
    double size = 0;
    const double fall = typed_work(c, PATH_STRAIGHT, a, b, &size);
    return fabs(potential_a - potential_b - fall) <=
           tolerated * (fabs(potential_a) + fabs(potential_b) + size);
}

/* Returns true if the formula is about 0 at infinity. */
static bool vanishes_at_infinity(const double *c, const double *y, double value)
{
    const double far = 1e6, small = 1e-3;
    double away[LIMIT_VARIABLES] = {0};
    for (int i = 0; i < typed_rows(typed_term_of(c)->typed); i++)
        away[i] = far * y[i];
    return fabs(formula_from_infinity(c, away)) <= small * fabs(value);
}

/* Returns true if a function is a potential of the force: finite at all points, and with the right
 * differences between them. */
static bool is_potential(double (*potential)(const double *c, const double *y),
                         const struct typed_term *term, const double *c,
                         double point[][LIMIT_VARIABLES], int count)
{
    double value[CURL_POINTS];
    for (int k = 0; k < count; k++) {
        value[k] = potential(c, point[k]);
        if (!isfinite(value[k]) ||
            (potential == formula_from_infinity && !vanishes_at_infinity(c, point[k], value[k])))
            return false;
    }
    for (int k = 0; typed_rows(term->typed) > 1 && k < count; k++)
        if (!fits_between(c, point[k], point[(k + 1) % count], value[k], value[(k + 1) % count]))
            return false;
    return true;
}

/* Tries the ways in turn, after finding masses with which the force can have a potential. */
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
    double point[CURL_POINTS][LIMIT_VARIABLES];
    const int count = choose_points(system, term, bound->c, point);
    double ratio[LIMIT_VARIABLES] = {0};
    const struct system saved = *system;
    if (system->n > 2 && !find_masses(term, bound->c, point, count, ratio))
        return false;
    if (system->n > 2)
        ratios_enter(system, ratio);
    const bool linear = term->row.flags & TERM_LINEAR;
    for (int i = linear ? 0 : 1; i < (linear ? 1 : TYPED_FOUND) && count > 0; i++)
        if (linear || is_potential(potentials[i], term, bound->c, point, count)) {
            bound->row = &part->found[i];
            return true;
        }
    *system = saved;
    return false;
}

/* Returns true if the term is 0 at rest, so that it is drag. */
static bool is_drag(const struct system *system, const struct bound_term *bound)
{
    const struct typed_term *term = typed_term_of(bound->c);
    double point[CURL_POINTS][LIMIT_VARIABLES], a[LIMIT_VARIABLES];
    const int count = choose_points(system, term, bound->c, point);
    for (int k = 0; k < count; k++) {
        typed_evaluate(term->add, bound->c, system->t0, point[k], a);
        for (int i = 0; i < system->n / 2; i++)
            if (a[i] != 0)
                return false;
    }
    return true;
}

/* Returns true if every term has a potential, is drag, or depends on time alone. */
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
