/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Along a family of periodic orbits (of conservative motion): its direction is what the equations
 * of shooting leave free, (M - 1) dx + f dT = 0 and f dx = 0, with M the derivative of the motion
 * over a period and f the velocity (Munoz-Almaraz, Freire, Galan, Doedel, Vanderbauwhede 2003). Of
 * more than one such direction the one that changes the period most is taken, and kept.
 */
#include <math.h>
#include <string.h>

#include <hooke/base/numeric.h>

#include "modules/dynamics/orbits/solutions.h"

#define STEP 0.25     /* of the orbit's extent and of its period together, at most */
#define SHORTEST 0.01 /* of that */
#define STEPS 300     /* in each sense */
#define FREE 1e-10    /* square of a singular value, of 1, that counts as 0 */
#define ROUNDING 1e-6 /* of the largest equation: another may be none */
#define LEVEL 0.02    /* a direction in which the period does not change */
#define SMALL 1e-4    /* of the sizes: swings that vanish */
#define WIDE 500      /* of the sizes: residuals are not small beside them any more */
#define SLOW 10       /* times the first period */
#define EQUAL 1e-8    /* relative: periods that are one */
#define MET 1e-12     /* relative: the period wanted */

struct member {
    struct found_orbit orbit;
    double extent;                         /* in units of size */
    double direction[FIELD_VARIABLES + 1]; /* states in units of size and extent, ln T; length 1 */
};

enum family_end { FAMILY_LOST, FAMILY_SMALL, FAMILY_WIDE, FAMILY_SLOW };

struct family {
    struct orbit_search *s;
    double wanted, least, most; /* [s] */
    double slow;                /* [s] */
    enum family_end end[2];
    int ends;
};

/* ---- its direction ---- */

/* What of the vector the equations leave free, of length 1; false: nothing. */
static bool project(const double *a, int n, double *v)
{
    double square[(FIELD_VARIABLES + 1) * (FIELD_VARIABLES + 1)], size = 0;
    for (int twice = 0; twice < 2; twice++) {
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                square[i * n + j] = i == j ? FREE : 0;
                for (int k = 0; k < n; k++)
                    square[i * n + j] += a[k * n + i] * a[k * n + j];
            }
            v[i] *= FREE;
        }
        if (!matrix_solve(n, square, v))
            return false;
    }
    for (int i = 0; i < n; i++)
        size = hypot(size, v[i]);
    for (int i = 0; i < n; i++)
        v[i] /= size;
    return size > LEVEL && isfinite(size);
}

/* The equations, each of length 1. */
static bool equations(struct family *f, const struct member *m, double *a)
{
    struct vector_field *field = &f->s->field;
    const struct solution *at = &m->orbit.solution;
    const int n = field->n, all = n + 1;
    double end[FIELD_VARIABLES], rate[FIELD_VARIABLES];
    struct flow_slopes slopes;
    if (!field_flow(field, field->system.t0, at->state, at->period, end, &slopes))
        return false;
    field_rate(field, at->state, rate);
    memset(a, 0, (size_t)(all * all) * sizeof *a);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            a[i * all + j] = slopes.by_start[i * n + j] - (i == j);
        a[i * all + n] = rate[i] * at->period / (field->size[i] * m->extent);
        a[n * all + i] = rate[i] / field->size[i];
    }
    double size[FIELD_VARIABLES + 1], largest = 0;
    for (int i = 0; i < all; i++) {
        size[i] = 0;
        for (int j = 0; j < all; j++)
            size[i] = hypot(size[i], a[i * all + j]);
        largest = fmax(largest, size[i]);
    }
    for (int i = 0; i < all; i++) /* what is rounding stays small */
        for (int j = 0; j < all; j++)
            a[i * all + j] /= fmax(size[i], ROUNDING * largest);
    return largest > 0;
}

/* That of the member before goes on; NULL: towards a larger period, else outwards. */
static bool aim(struct family *f, struct member *m, const double *before)
{
    const struct vector_field *field = &f->s->field;
    const struct solution *at = &m->orbit.solution;
    const int n = field->n;
    double a[(FIELD_VARIABLES + 1) * (FIELD_VARIABLES + 1)], *v = m->direction;
    if (!equations(f, m, a))
        return false;
    memset(v, 0, sizeof m->direction);
    if (before)
        memcpy(v, before, sizeof m->direction);
    else
        v[n] = 1;
    if (project(a, n + 1, v) || before)
        return true;
    for (int i = 0; i < n; i++)
        v[i] = (at->state[i] - (at->top[i] + at->bottom[i]) / 2) / (field->size[i] * m->extent);
    v[n] = 0;
    return project(a, n + 1, v);
}

/* ---- along it ---- */

/* Another orbit of it, from a guess that is at most `near` (extents, and ln T) away, in the plane
 * across the direction. */
static bool reach(struct family *f, const double *state, double period, double near,
                  const double *across, struct member *m)
{
    const struct vector_field *field = &f->s->field;
    struct orbit_search alone = *f->s;
    alone.extent = 0;
    m->orbit = (struct found_orbit){.samples = 0};
    const bool fine = orbit_close(&alone, state, period, 0, across, &m->orbit);
    f->s->field.evals = alone.field.evals;
    const struct solution *at = &m->orbit.solution;
    if (!fine || fabs(at->period / period - 1) > near)
        return false;
    m->extent = orbit_extent(field, at);
    double off = 0;
    for (int i = 0; i < field->n; i++)
        off = fmax(off, fabs(at->state[i] - state[i]) / (field->size[i] * m->extent));
    return off < near;
}

/* Do both begin on the same side of their middle? */
static bool same_side(const struct vector_field *field, const struct solution *a,
                      const struct solution *b)
{
    double sum = 0;
    for (int i = 0; i < field->n; i++)
        sum += (a->state[i] - (a->top[i] + a->bottom[i]) / 2) *
               (b->state[i] - (b->top[i] + b->bottom[i]) / 2) / (field->size[i] * field->size[i]);
    return sum > 0;
}

static bool step(struct family *f, const struct member *from, double by, struct member *to)
{
    const struct vector_field *field = &f->s->field;
    double state[FIELD_VARIABLES], across[FIELD_VARIABLES + 1];
    for (int i = 0; i < field->n; i++)
        across[i] = from->direction[i] / (from->extent * field->size[i]);
    across[field->n] = from->direction[field->n];
    for (int i = 0; i < field->n; i++)
        state[i] =
            from->orbit.solution.state[i] + by * from->extent * from->direction[i] * field->size[i];
    const double period = from->orbit.solution.period * exp(by * from->direction[field->n]);
    return reach(f, state, period, fabs(by), across, to) &&
           same_side(field, &from->orbit.solution, &to->orbit.solution) &&
           aim(f, to, from->direction);
}

/* Between two members whose periods lie on both sides of it. */
static bool meet(struct family *f, const struct member *a, const struct member *b,
                 struct found_orbit *met)
{
    const struct solution *from = &a->orbit.solution, *to = &b->orbit.solution;
    const double share = (f->wanted - from->period) / (to->period - from->period);
    double state[FIELD_VARIABLES] = {0}, across[FIELD_VARIABLES + 1] = {0};
    struct member m;
    across[from->n] = 1;
    for (int i = 0; i < from->n; i++)
        state[i] = from->state[i] + share * (to->state[i] - from->state[i]);
    if (!reach(f, state, f->wanted, 2 * STEP, across, &m))
        return false;
    *met = m.orbit;
    return true;
}

/* One way, until it is met (true) or the family ends. */
static bool walk(struct family *f, const struct member *seed, int sense, struct found_orbit *met)
{
    struct member at = *seed, next = *seed;
    double by = STEP / 4;
    enum family_end *end = &f->end[f->ends++];
    *end = FAMILY_LOST;
    for (int k = 0; k < STEPS && !cancelled(f->s->request->cancel); k++) {
        if (f->s->request->progress)
            f->s->request->progress(f->s->request->context, 0);
        while (by > SHORTEST * STEP && !step(f, &at, sense * by, &next))
            by /= 2;
        if (by <= SHORTEST * STEP) {
            /* near motion that takes for ever the least difference matters */
            *end = at.orbit.solution.period > 2 * seed->orbit.solution.period ? FAMILY_SLOW
                                                                              : FAMILY_LOST;
            return false;
        }
        const double period[] = {at.orbit.solution.period, next.orbit.solution.period};
        if ((period[0] < f->wanted) != (period[1] < f->wanted) && meet(f, &at, &next, met))
            return true;
        f->least = fmin(f->least, period[1]);
        f->most = fmax(f->most, period[1]);
        *end = next.extent < SMALL   ? FAMILY_SMALL
               : next.extent > WIDE  ? FAMILY_WIDE
               : period[1] > f->slow ? FAMILY_SLOW
                                     : FAMILY_LOST;
        if (*end != FAMILY_LOST)
            return false;
        at = next;
        by = fmin(1.5 * by, STEP);
    }
    return false;
}

static bool refuse(const struct family *f, struct error *error)
{
    static const char *const ends[] = {[FAMILY_LOST] = "where it is lost",
                                       [FAMILY_SMALL] = "swings that vanish",
                                       [FAMILY_WIDE] = "swings of hundreds of the scene's sizes",
                                       [FAMILY_SLOW] = "near motion that takes for ever"};
    if (f->most - f->least < EQUAL * f->most)
        return error_set(error, ERROR_COMMAND, "every orbit of this family has the period %.10g s",
                         f->most);
    error_set(error, ERROR_COMMAND,
              "no orbit of this family with the period %.6g s was found: they have %.6g s to "
              "%.6g s",
              f->wanted, f->least, f->most);
    return error_hint(error, "it was followed from %.6g s to %s and to %s",
                      f->s->found->solution.period, ends[f->end[0]], ends[f->end[1]]);
}

bool orbit_of_period(struct orbit_search *s, double wanted, struct error *error)
{
    const double first = s->found->solution.period;
    struct family f = {.s = s, .wanted = wanted, .least = first, .most = first};
    struct member seed = {.orbit = *s->found};
    f.slow = fmax(SLOW * first, 1.5 * wanted);
    if (fabs(first / wanted - 1) < MET)
        return true;
    seed.extent = orbit_extent(&s->field, &s->found->solution);
    if (!aim(&f, &seed, NULL))
        return error_set(error, ERROR_COMMAND,
                         "no orbit with this period was found: there is one with %.10g s", first);
    const int sense = wanted > first ? 1 : -1;
    if (!walk(&f, &seed, sense, s->found) && !walk(&f, &seed, -sense, s->found))
        return cancelled(s->request->cancel) ? error_set(error, ERROR_CANCELLED, "cancelled")
                                             : refuse(&f, error);
    s->found->family_from = first;
    return true;
}
