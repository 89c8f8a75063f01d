/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Exact solutions of q'' + gamma q' + w2 q = -g + f cos(omega t + phase), w2 and gamma of any sign.
 * Other linear systems: exact_linear.c.
 *
 * With the roots a, b of z^2 + gamma z + w2 every part of the solution is a divided difference of z
 * -> exp(z t):
 *
 *   impulse response                 h(t) = E[a, b]
 *   from rest under exp(c t)         E[a, b, c]              (c = 0: constant, i omega: a drive)
 *   its velocity                     a E[a, b, c] + E[b, c]  (Leibniz)
 *
 * so that critical damping (a = b), resonance (c = a) and k = 0 (a = 0) are nothing but nodes that
 * meet, for which divided differences have a limit: close nodes take the Taylor series, distant
 * ones the quotient, and neither cancels. The idea is that of McCurdy, Ng, Parlett, Math. Comp. 43
 * (1984) 501.
 *
 * Everything is evaluated in long double: where it has 64 bits of mantissa and 15 of exponent (x86,
 * and more elsewhere) the result is good to half an ulp of the amplitude for phases up to 1000 and
 * grows by 1e-19 per radian, and amplitudes near both ends of double need no scaling.
 */
#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "scene/model/exact.h"

typedef long double real; /* private to this file, for the width of the formulas */
typedef complex long double node;

/* Exponentials that were computed for one time, so that equal and conjugate arguments take one
 * evaluation. */
struct exponentials {
    int count;
    struct {
        node z, value;
    } entry[4];
};

/* Returns exp(z). Takes the value from `known` if z or its conjugate was an argument before, and
 * adds it there otherwise, if there is room. For large real parts the magnitude is limited below
 * overflow but still grows with the real part, so that a growing motion ends as infinity and not as
 * the difference of two infinities, which is NAN. */
static node exponential(struct exponentials *known, node z)
{
    const real max = LDBL_MAX_EXP / 2;
    for (int i = 0; i < known->count; i++) {
        if (known->entry[i].z == z)
            return known->entry[i].value;
        if (known->entry[i].z == conjl(z))
            return conjl(known->entry[i].value);
    }
    node held = z;
    real x = creall(z);
    if (x > max)
        held += max * (1.1L - 0.1L * max / x) - x;
    const node value = cexpl(held);
    if (known->count < (int)COUNT_OF(known->entry)) {
        known->entry[known->count].z = z;
        known->entry[known->count++].value = value;
    }
    return value;
}

/* Returns the sum over k of h_k / (k + n)!, where h_k are the complete homogeneous symmetric
 * polynomials of nodes whose sum is 0 and whose other elementary symmetric polynomials are e2 and
 * e3: h_k = -e2 h_(k-2) + e3 h_(k-3). The nodes must be within 1 of 0. */
static node taylor(node e2, node e3, int n)
{
    node h[3] = {1, 0, 0}, sum = 0; /* h_k, h_(k-1), h_(k-2) */
    real factorial = n;             /* n is 1 or 2 */
    for (int k = 0; k < 20; k++) {
        sum += h[0] / factorial;
        factorial *= k + n + 1;
        node next = -e2 * h[1] + e3 * h[2];
        h[2] = h[1], h[1] = h[0], h[0] = next;
    }
    return sum;
}

/* Returns E[a, b], the divided difference of z -> exp(z t). */
static node divided2(struct exponentials *known, node a, node b, real t)
{
    if (cabsl((a - b) * t) >= 1)
        return (exponential(known, a * t) - exponential(known, b * t)) / (a - b);
    node x = (a - b) / 2 * t;
    return t * exponential(known, (a + b) / 2 * t) * taylor(-x * x, 0, 1);
}

/* Returns E[a, b, c], divided along the longer way to c: if even that is short, all three are near
 * each other and the Taylor series is used. */
static node divided3(struct exponentials *known, node a, node b, node c, real t)
{
    if (cabsl(b - c) > cabsl(a - c)) {
        node keep = a;
        a = b, b = keep;
    }
    if (cabsl((a - c) * t) >= 1)
        return (divided2(known, a, b, t) - divided2(known, b, c, t)) / (a - c);
    node mean = (a + b + c) / 3;
    a = (a - mean) * t, b = (b - mean) * t, c = (c - mean) * t;
    return t * t * exponential(known, mean * t) * taylor(a * b + b * c + c * a, a * b * c, 2);
}

/* Returns true if the system is one linear oscillator, perhaps with a drive. */
static bool is_linear_oscillator(const struct system *system)
{
    return system->order == 2 && system->n == 2 && system->linear && system->oscillator.whole;
}

bool system_has_exact(const struct system *system)
{
    return (system->model && system->model->exact) || is_linear_oscillator(system) ||
           dry_has_exact(system) || linear_has_exact(system);
}

/* The roots a, b of z^2 + gamma z + w2; a is the one of lesser magnitude if they are real. */
struct roots {
    node a, b;
    real w2, gamma; /* [1/s^2], [1/s] */
    real r;         /* half of the distance of the roots */
};

/* Finds the roots of an oscillator, without cancellation near critical damping. */
static struct roots roots_of(const struct oscillator *o)
{
    struct roots z = {.w2 = (real)o->stiffness, .gamma = (real)o->damping};
    const real s = z.gamma / 2;
    /* one rounding: exact however near critical damping */
    const real discriminant = fmal(-s, s, z.w2);
    z.r = sqrtl(fabsl(discriminant));
    if (discriminant > 0) {
        z.a = -s + z.r * (node)I;
        z.b = conjl(z.a);
    } else {
        z.b = s >= 0 ? -(s + z.r) : z.r - s;
        z.a = z.b != 0 ? z.w2 / z.b : 0;
    }
    return z;
}

/* The free motion q = q0 g + v0 h over a time, where g' = -w2 h. */
struct flow {
    real g, h, h_rate;
};

/* Computes the free motion over a time. */
static struct flow flow_over(struct exponentials *known, const struct roots *z, real time)
{
    const real h = creall(divided2(known, z->a, z->b, time)), a = creall(z->a);
    return (struct flow){creall(exponential(known, z->a * time)) - a * h, h,
                         creall(exponential(known, z->b * time)) + a * h};
}

/* Returns the response from rest to a drive exp(c t), and its rate. */
static node drive_response(struct exponentials *known, const struct roots *z, node c, real time,
                           node *rate)
{
    const node from_rest = divided3(known, z->a, z->b, c, time);
    *rate = z->a * from_rest + divided2(known, z->b, c, time);
    return from_rest;
}

/* The state at a time, as the sum of a free and a driven part. */
struct parts {
    real q, v;        /* the part without the drive */
    struct flow flow; /* free motion since the start */
    node p, p_rate;   /* complex envelopes of the driven part, whose real parts are added to q, v */
    node drive;       /* complex drive at that time */
};

/* Computes the parts of the solution at t from the state `start` at t0. */
static struct parts oscillator_solve(const struct oscillator *o, const struct roots *z, double t0,
                                     const double *start, double t)
{
    const real q0 = (real)start[0], v0 = (real)start[1], begin = (real)t0,
               elapsed = (real)t - begin;
    const real gravity = (real)o->gravity;
    struct exponentials known = {0};
    struct parts made = {.flow = flow_over(&known, z, elapsed)};
    made.q = q0 * made.flow.g + v0 * made.flow.h;
    if (gravity != 0) /* a constant force adds its step response */
        made.q -= gravity * creall(divided3(&known, z->a, z->b, 0, elapsed));
    made.v = v0 * made.flow.h_rate - (z->w2 * q0 + gravity) * made.flow.h;
    if (o->drive != 0) {
        const node c = (real)o->omega * (node)I;
        const node drive =
            (real)o->drive * cexpl(((real)o->omega * begin + (real)o->phase) * (node)I);
        made.p = drive * drive_response(&known, z, c, elapsed, &made.p_rate);
        made.p_rate *= drive;
        made.drive = drive * cexpl(c * elapsed);
    }
    return made;
}

/* Chooses the exact solution by the kind of the system. */
void system_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor)
{
    if (system->model && system->model->exact) {
        system->model->exact(system, t0, start, t, y, floor);
        return;
    }
    if (is_linear_oscillator(system))
        oscillator_exact(&system->oscillator, t0, start, t, y, floor);
    else if (dry_has_exact(system))
        dry_exact(system, t0, start, t, y, floor);
    else
        linear_exact(system, t0, start, t, y, floor);
}

/* Computes the state at t and, unless NULL, its floor. */
void oscillator_exact(const struct oscillator *o, double t0, const double *start, double t,
                      double *y, double *floor)
{
    const struct roots z = roots_of(o);
    const struct parts made = oscillator_solve(o, &z, t0, start, t);
    y[0] = (double)(made.q + creall(made.p));
    y[1] = (double)(made.v + creall(made.p_rate));
    if (!floor)
        return;

    /*
     * A relative change eps of the time scale moves q by eps |t| v, v without the cancellation
     * between its parts; where v happens to be 0 the acceleration over a rate stands in, where that
     * is 0 the velocity: together an envelope. A change of one coefficient alone moves roots that
     * nearly meet by more: by a factor |b| / 2r, and never by more than |b t| / 6.
     */
    const real eps = (real)DBL_EPSILON, time = fabsl((real)t - (real)t0), fast = cabsl(z.b),
               gravity = (real)o->gravity;
    const real q = made.q, v = made.v, v0 = (real)start[1],
               forced = (z.w2 * (real)start[0] + gravity) * made.flow.h;
    real a_free = -z.w2 * q - z.gamma * v - gravity,
         v_free = fabsl(v0 * made.flow.h_rate) + fabsl(forced);
    real v_top = hypotl(v_free, a_free * fminl(1 / fast, time)),
         a_top = hypotl(a_free, cabsl(z.a) * v_free);
    real stretch = 1 + fast * fminl(0.5L / z.r, time / 6);
    real v_drive = cabsl(made.p_rate),
         a_drive = cabsl(made.drive - z.w2 * made.p - z.gamma * made.p_rate);
    floor[0] = (double)(eps * (fabsl(q) + cabsl(made.p) + time * stretch * (v_top + v_drive)));
    floor[1] = (double)(eps * (fabsl(v) + v_drive + time * stretch * (a_top + a_drive)));
}

/* ---- at many times, a step apart ----
 *
 * exact_table_at() computes the solution anew at a time, the base, and from there on by the free
 * motions over multiples of the step, which the table has.
 */

#define TABLE_MAX 64 /* largest number of multiples */
/* Largest |b t| of them, because rounding grows by exp(|b t|). */
#define TABLE_TURN 4.0
#define TABLE_MIN 8 /* fewer multiples save nothing */
/* Largest |b dt| by which a time may be off its multiple: terms in dt^2 are below half an ulp. */
#define TABLE_OFF 1e-9

struct exact_table {
    const struct system *system;
    double t0, start[2], h;
    struct roots roots;
    real fast; /* the larger one of |b| and omega [1/s] */
    int count; /* multiples in the table */
    struct {
        struct flow flow;
        real response; /* response to a constant force from rest */
        /* response to a drive that is 1 at the base, its rate, and the drive at that multiple */
        node p, p_rate, turn;
    } entry[TABLE_MAX];
    bool known; /* there is a base, at t [s], with the state q, v and the complex drive */
    double t;
    real q, v;
    node drive;
};

/* Fills the table; returns NULL if there is no use for one or out of memory. */
struct exact_table *exact_table_create(const struct system *system, double t0, const double *start,
                                       double h)
{
    const struct oscillator *o = &system->oscillator;
    if ((system->model && system->model->exact) || !is_linear_oscillator(system) || h == 0)
        return NULL;
    const struct roots z = roots_of(o);
    const node c = (real)o->omega * (node)I;
    const real fast = fmaxl(cabsl(z.b), o->drive != 0 ? cabsl(c) : 0);
    const double steps = TABLE_TURN / (double)(fast * fabsl((real)h));
    struct exact_table *table = steps >= TABLE_MIN ? calloc(1, sizeof *table) : NULL;
    if (!table)
        return NULL;
    *table = (struct exact_table){.system = system,
                                  .t0 = t0,
                                  .start = {start[0], start[1]},
                                  .h = h,
                                  .roots = z,
                                  .fast = fast};
    table->count = steps < TABLE_MAX ? (int)steps : TABLE_MAX;
    for (int i = 0; i < table->count; i++) {
        const real time = (real)i * (real)h;
        struct exponentials known = {0};
        table->entry[i].flow = flow_over(&known, &z, time);
        table->entry[i].response =
            o->gravity != 0 ? creall(divided3(&known, z.a, z.b, 0, time)) : 0;
        if (o->drive != 0) {
            table->entry[i].p = drive_response(&known, &z, c, time, &table->entry[i].p_rate);
            table->entry[i].turn = cexpl(c * time);
        }
    }
    return table;
}

void exact_table_free(struct exact_table *table)
{
    free(table);
}

/* Computes the state at t from the base, or anew if t is not among the multiples; then t is the
 * base. */
void exact_table_at(struct exact_table *table, double t, double *y)
{
    const struct oscillator *o = &table->system->oscillator;
    const real elapsed = (real)t - (real)table->t;
    const double ratio = round((double)(elapsed / (real)table->h));
    if (!table->known || !(ratio >= 0 && ratio < table->count)) {
        const struct parts made = oscillator_solve(o, &table->roots, table->t0, table->start, t);
        table->known = true;
        table->t = t;
        table->q = made.q + creall(made.p);
        table->v = made.v + creall(made.p_rate);
        table->drive = made.drive;
        y[0] = (double)table->q;
        y[1] = (double)table->v;
        return;
    }
    const int i = (int)ratio;
    const real offset = elapsed - (real)i * (real)table->h;
    if (!(fabsl(offset) * table->fast <= (real)TABLE_OFF)) {
        system_exact(table->system, table->t0, table->start, t, y, NULL);
        return;
    }
    /* As oscillator_solve() from the base, and to first order in the rounding of t. */
    const struct flow *flow = &table->entry[i].flow;
    const real w2 = table->roots.w2, gravity = (real)o->gravity;
    real q = table->q * flow->g + table->v * flow->h - gravity * table->entry[i].response,
         force = -gravity;
    real v = table->v * flow->h_rate - (w2 * table->q + gravity) * flow->h;
    if (o->drive != 0) {
        q += creall(table->drive * table->entry[i].p);
        v += creall(table->drive * table->entry[i].p_rate);
        force += creall(table->drive * table->entry[i].turn);
    }
    const real a = force - w2 * q - table->roots.gamma * v;
    y[0] = (double)(q + v * offset);
    y[1] = (double)(v + a * offset);
}
