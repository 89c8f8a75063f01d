/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The variational equations as a system. df/dp is a central difference of the terms that the
 * parameter changes, each by itself: where a term is linear in the parameter this is exact but for
 * rounding, and rounding of the other terms does not contribute. */
#include "modules/solving/compute/variation.h"

#include <string.h>
#include <stdlib.h>

#define DIFFERENCE_STEP 1e-6 /* step of differences, relative to the size of the variable */
/* Smallest size assumed for a parameter (SI), unless it must be positive, and for a variable, as a
 * fraction of its scale. */
#define PARAMETER_SIZE_MIN 1e-3
/* Smallest size assumed for a positive parameter, as a fraction of its default. */
#define INITIAL_FRACTION_MIN 1e-6

/* Returns the system's term of that row, or NULL if it has none. */
static const struct bound_term *term_of(const struct system *system, const struct term_row *row)
{
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row == row)
            return &system->term[i];
    return NULL;
}

/* Lists in d->change the terms that only one of the two systems has, or whose coefficients
 * differ. */
static void find_changes(const struct system side[2], struct parameter_change *d)
{
    for (int s = 0; s < 2; s++) {
        for (int i = 0; i < side[s].terms; i++) {
            const struct bound_term *term = &side[s].term[i],
                                    *other = term_of(&side[1 - s], term->row);
            if (other && (s == 1 || bound_term_equal(term, other)))
                continue;
            struct term_change *change = &d->change[d->changes++];
            *change = (struct term_change){.row = term->row};
            change->is_present[s] = true;
            memcpy(change->c[s], term->c, sizeof term->c);
            if (other) {
                change->is_present[1 - s] = true;
                memcpy(change->c[1 - s], other->c, sizeof other->c);
            }
        }
    }
}

/* Binds the scene with the parameter a little above its value, as side[0], and a little below, as
 * side[1], and sets *d to the changes between them. At a bound of the parameter the value itself
 * replaces the side that is not allowed. Returns false if the scene cannot be bound. */
static bool find_between(const struct scene *scene, int index, struct system side[2],
                         struct parameter_change *d)
{
    const struct param_row *row = param_at(scene, index);
    const double value = scene->value[index],
                 size =
                     fmax(fabs(value), row->min_excluded ? INITIAL_FRACTION_MIN * fabs(row->initial)
                                                         : PARAMETER_SIZE_MIN);
    struct scene trial = *scene;
    double point[2];
    for (int s = 0; s < 2; s++) {
        trial.value[index] = point[s] =
            value + (s == 0 ? DIFFERENCE_STEP : -DIFFERENCE_STEP) * size;
        if (scene_bind_rates(&trial, &side[s]))
            continue;
        trial.value[index] = point[s] = value; /* a one-sided difference at a bound */
        if (!scene_bind_rates(&trial, &side[s]))
            return false;
    }
    *d = (struct parameter_change){.apart = point[0] - point[1]};
    if (!(d->apart > 0))
        return false;
    find_changes(side, d);
    d->t0 = (side[0].t0 - side[1].t0) / d->apart;
    d->starts = d->t0 != 0;
    for (int i = 0; i < side[0].n; i++) {
        d->start[i] = (side[0].start[i] - side[1].start[i]) / d->apart;
        d->starts = d->starts || d->start[i] != 0;
    }
    return true;
}

/* Finds what a parameter changes in the scene. */
bool direction_find(const struct scene *scene, int index, struct parameter_change *d)
{
    struct system *side = malloc(2 * sizeof *side);
    const bool found = side && find_between(scene, index, side, d);
    free(side);
    return found;
}

/* Sets slope [n] to df/dp for the parameter direction d at t and y: the difference of the right
 * sides at two values of p, divided by the distance of these. Only the terms that p changes are
 * computed. */
static void slope_by_parameter(const struct variation *v, const struct parameter_change *d,
                               double t, const double *y, double *slope)
{
    const struct system *base = &v->base;
    double sum[2][LIMIT_VARIABLES / 2];
    const int rows = base->order == 2 ? base->n / 2 : base->n, positions = base->n - rows;
    int row = 0;
    do /* there is at least one */
        sum[0][row] = sum[1][row] = 0;
    while (++row < rows);
    for (int k = 0; k < d->changes; k++)
        for (int s = 0; s < 2; s++)
            if (d->change[k].is_present[s] && v->dry != 0 && d->change[k].row->flags & TERM_DRY)
                sum[s][0] -= v->dry * d->change[k].c[s][0];
            else if (d->change[k].is_present[s])
                d->change[k].row->add(d->change[k].c[s], t, y, sum[s]);
    for (int i = 0; i < positions; i++)
        slope[i] = 0;
    for (int i = 0; i < rows; i++)
        slope[positions + i] = (sum[0][i] - sum[1][i]) / d->apart;
}

/* Adds (df/dy) s to the result. */
static inline __attribute__((always_inline)) void add_product(int n, const double *jacobian,
                                                              const double *s, double *result)
{
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++)
            sum += jacobian[i * n + j] * s[j];
        result[i] += sum;
    }
}

/* Computes the time derivative of s = dy/dp for one direction d of the parameters: result [n] = J s
 * + df/dp, with the Jacobian J [n x n] at t and state y. Fixed n lets the compiler unroll the
 * common cases. */
static void variation_rate(const struct variation *v, const struct parameter_change *d, double t,
                           const double *y, const double *jacobian, const double *s, double *result)
{
    const int n = v->base.n;
    if (d->changes > 0)
        slope_by_parameter(v, d, t, y, result);
    else
        for (int i = 0; i < n; i++)
            result[i] = 0;
    if (n == 2)
        add_product(2, jacobian, s, result);
    else if (n == 3)
        add_product(3, jacobian, s, result);
    else
        add_product(n, jacobian, s, result);
}

/* ---- as a term of a system ----
 *
 * All that a bound term sees of its surroundings are its coefficients: here they hold the
 * variation's address.
 */

/* Returns the variation whose address the coefficients of its term hold. */
static const struct variation *variation_of(const double *c)
{
    const struct variation *variation;
    memcpy(&variation, c, sizeof variation);
    return variation;
}

#define BASE_MAX (LIMIT_VARIABLES / 2)

/* Adds the derivatives of all variables of the extended system to a: the base, its sensitivities,
 * and with v->trace the trace of the Jacobian. c holds the address of the variation. */
static void variation_add(const double *c, double t, const double *y, double *a)
{
    const struct variation *v = variation_of(c);
    const int n = v->base.n;
    double jacobian[BASE_MAX * BASE_MAX], rate[LIMIT_VARIABLES];
    system_derivative(&v->base, t, y, rate);
    system_jacobian(&v->base, t, y, jacobian);
    for (int j = 0; j < v->directions; j++)
        variation_rate(v, &v->direction[j], t, y, jacobian, y + n * (j + 1), rate + n * (j + 1));
    if (v->trace) {
        rate[v->whole.n - 1] = 0;
        for (int i = 0; i < n; i++)
            rate[v->whole.n - 1] += jacobian[i * n + i];
    }
    for (int i = 0; i < v->whole.n; i++)
        a[i] += rate[i];
}

/* Adds the Jacobian of the whole system to jac [all][all], as terms do, for implicit methods on
 * stiff scenes. The system is y' = f and, for each direction, S' = (df/dy) S + df/dp: the blocks on
 * the diagonal are df/dy, and those of the rows of S in the columns of y are derivatives of S' by
 * y, as central differences. The row of the trace has no entries. */
static void variation_jacobian(const double *c, double t, const double *y, double *jac)
{
    const struct variation *v = variation_of(c);
    const int n = v->base.n, all = v->whole.n;
    double jacobian[2][BASE_MAX * BASE_MAX], state[BASE_MAX], rate[2][BASE_MAX];
    system_jacobian(&v->base, t, y, jacobian[0]);
    for (int block = 0; block <= v->directions; block++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                jac[(block * n + i) * all + block * n + j] += jacobian[0][i * n + j];
    memcpy(state, y, (size_t)n * sizeof *state);
    for (int l = 0; l < n; l++) {
        const double delta =
            DIFFERENCE_STEP * fmax(fabs(y[l]), PARAMETER_SIZE_MIN * v->base.scale[l]);
        for (int s = 0; s < 2; s++) {
            state[l] = s == 0 ? y[l] + delta : y[l] - delta;
            system_jacobian(&v->base, t, state, jacobian[s]);
        }
        for (int j = 0; j < v->directions; j++) {
            for (int s = 0; s < 2; s++) {
                state[l] = s == 0 ? y[l] + delta : y[l] - delta;
                variation_rate(v, &v->direction[j], t, state, jacobian[s], y + n * (j + 1),
                               rate[s]);
            }
            for (int i = 0; i < n; i++)
                jac[((j + 1) * n + i) * all + l] += (rate[0][i] - rate[1][i]) / (2 * delta);
        }
        state[l] = y[l];
    }
}

static const struct term_row variation_row = {
    .row = {"variation", "", "the scene and its derivatives by its parameters", "", NULL},
    .flags = TERM_VELOCITY | TERM_TIME,
    .add = variation_add,
    .jacobian = variation_jacobian};

/* Makes the extended system of base and `directions` sensitivities, of first order. The caller sets
 * the initial values of the sensitivities. */
static void frame(struct variation *v, int directions)
{
    const struct system *base = &v->base;
    const struct variation *address = v;
    v->directions = directions;
    v->dry = 0;
    v->trace = false;
    v->whole = (struct system){.model = base->model,
                               .n = base->n * (directions + 1),
                               .order = 1,
                               .terms = 1,
                               .term = {{.row = &variation_row}},
                               .velocity = true,
                               .autonomous = base->autonomous,
                               .mass = base->mass,
                               .t0 = base->t0};
    memcpy(v->whole.term[0].c, &address, sizeof address);
    for (int i = 0; i < v->whole.n; i++)
        v->whole.scale[i] = base->scale[i % base->n];
    memcpy(v->whole.start, base->start, (size_t)base->n * sizeof *base->start);
}

/* Makes v the system of the scene's motion and its derivatives by the `count` parameters index[].
 * The derivatives start at those of the initial state, less the rate times that of the initial
 * time. Returns false if the scene cannot be bound or if a derivative cannot be found. */
bool variation_bind(struct variation *v, const struct scene *scene, const int *index, int count)
{
    struct error ignored;
    double rate[LIMIT_VARIABLES];
    if (!scene_bind_motion(scene, &v->base, &ignored))
        return false;
    const struct system *base = &v->base;
    frame(v, count);
    system_derivative(base, base->t0, base->start, rate);
    for (int j = 0; j < count; j++) {
        const struct parameter_change *d = &v->direction[j];
        if (!direction_find(scene, index[j], &v->direction[j]))
            return false;
        for (int i = 0; i < base->n; i++)
            v->whole.start[base->n * (j + 1) + i] = d->start[i] - rate[i] * d->t0;
    }
    return true;
}

void variation_of_start(struct variation *v, const struct system *base, const double *size)
{
    variation_of_tangents(v, base, size, base->n);
}

/* Prepares derivatives by the start of the first `count` variables, in units of size. */
void variation_of_tangents(struct variation *v, const struct system *base, const double *size,
                           int count)
{
    const int n = base->n;
    v->base = *base;
    frame(v, count);
    for (int j = 0; j < count; j++) {
        v->direction[j].changes = 0;
        v->direction[j].apart = 1;
        for (int i = 0; i < n; i++)
            v->whole.start[n * (j + 1) + i] = i == j ? size[j] : 0;
    }
}

/* Adds the derivative by one more parameter, at a fixed initial state. Returns false if there are
 * too many variables or if the derivative cannot be found. */
bool variation_add_parameter(struct variation *v, const struct scene *scene, int index)
{
    const int n = v->base.n;
    if (n * (v->directions + 2) > LIMIT_VARIABLES ||
        !direction_find(scene, index, &v->direction[v->directions]))
        return false;
    for (int i = 0; i < n; i++) {
        v->whole.start[v->whole.n + i] = 0;
        v->whole.scale[v->whole.n + i] = v->base.scale[i];
    }
    v->whole.n += n;
    v->directions++;
    return true;
}

/* Appends a variable that starts at 0: the integral over time of the trace of df/dy, which is the
 * logarithm of the determinant of the derivatives by the initial state. Returns false if there are
 * LIMIT_VARIABLES already. */
bool variation_add_trace(struct variation *v)
{
    if (v->whole.n == LIMIT_VARIABLES)
        return false;
    v->whole.start[v->whole.n] = 0;
    v->whole.scale[v->whole.n] = 1;
    v->whole.n++;
    v->trace = true;
    return true;
}
