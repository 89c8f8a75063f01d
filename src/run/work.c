/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Work between states one step apart: the integral of the power of drag and drive along the quintic through position,
 * velocity and acceleration at both ends, by Lobatto's rule with four points (Abramowitz and Stegun 1964, 25.4.32).
 * Its ends are states of the neighbours too, so a step costs one acceleration and three powers. Both are of order 6.
 *
 * At Lobatto's inner points s = (1 -+ 1/sqrt 5)/2 the quintic Hermite polynomial of q0, v0, a0, q1, v1, a1 is
 *
 *   q = (q0 + q1)/2 + 0.12 h (v0 - v1) + 0.01 h^2 (a0 + a1)
 *       -+ (0.82 (q1 - q0) - 0.16 h (v0 + v1) - 0.01 h^2 (a0 - a1)) / sqrt 5
 *   v = 1.2 (q1 - q0)/h - 0.1 (v0 + v1) +- (0.7 (v0 - v1) + 0.1 h (a0 + a1)) / sqrt 5
 *
 * Oscillators go by blocks of steps in loops that vectorise, with the functions of terms.def and only those terms that
 * the scene has; whatever else there is goes step by step through the system's functions.
 */
#include "../scene/params.h"
#include "private.h"

#include <math.h>

#if defined(__GNUC__)
#define ALWAYS_INLINE static inline __attribute__((always_inline))
#else
#define ALWAYS_INLINE static inline
#endif

#define SQRT5 2.236067977499789696
#define INNER 0.276393202250021030 /* the first inner point of Lobatto's rule on [0, 1] */

static double time_of(const struct work *work, int k)
{
    return work->t ? work->t[k] : work->origin + (double)(work->index + k) * work->h;
}

static double length_of(const struct work *work, int k)
{
    return work->t ? work->t[k + 1] - work->t[k] : work->h;
}

/* ---- powers ---- */

struct power {
    double all, drag;
};

/* Is all power that of drag? */
static bool drags_only(const struct system *system)
{
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->power && (system->term[i].row->flags & (TERM_TIME | TERM_VELOCITY)) != TERM_VELOCITY)
            return false;
    return true;
}

static struct power power_at(const struct system *system, bool drags, double t, const double *y)
{
    const double all = system_power(system, t, y);
    return (struct power){all, drags ? all : system_dissipation(system, t, y)};
}

/* ---- where drag has a kink: a step across a turning point in two parts ---- */

/* One coordinate between two states. */
struct quintic {
    double h, q0, v0, a0, q1, v1, a1;
};

/* At the share s of the step. */
static void quintic_at(const struct quintic *p, double s, double *q, double *v)
{
    const double r = 1 - s, rs = r * s, rise = s * s * s * (10 + s * (6 * s - 15)), h = p->h;
    *q = p->q0 + rise * (p->q1 - p->q0) + rs * h * (r * r * (1 + 3 * s) * p->v0 - s * s * (1 + 3 * r) * p->v1) +
         rs * rs / 2 * h * h * (r * p->a0 + s * p->a1);
    *v = 30 * rs * rs * (p->q1 - p->q0) / h + r * r * (1 + s * (2 - 15 * s)) * p->v0 +
         s * s * (1 + r * (2 - 15 * r)) * p->v1 +
         rs / 2 * h * (r * (2 - 5 * s) * p->a0 - s * (2 - 5 * r) * p->a1);
}

#define NEAR_REST 1e-9 /* of the velocities: the power there goes with their square or cube */

/* Where the velocity, of different signs at the ends, is 0: by secants and bisections (Illinois). */
static double turning_point(const struct quintic *p)
{
    const double rest = NEAR_REST * (fabs(p->v0) + fabs(p->v1));
    double a = 0, b = 1, fa = p->v0, fb = p->v1, s = 0.5, q, v = HUGE_VAL;
    for (int i = 0; i < 60 && fabs(v) > rest; i++) {
        s = i % 4 == 3 ? (a + b) / 2 : a + (b - a) * (fa / (fa - fb));
        quintic_at(p, s, &q, &v);
        if (signbit(v) == signbit(p->v0)) {
            a = s;
            fa = v;
            fb /= 2;
        } else {
            b = s;
            fb = v;
            fa /= 2;
        }
    }
    return s;
}

static void add_part(const struct system *system, bool drags, const struct quintic *p, double t, double from,
                     double to, double *work, double *drag)
{
    const double at[] = {0, INNER, 1 - INNER, 1}, weight[] = {1. / 12, 5. / 12, 5. / 12, 1. / 12};
    for (int i = 0; i < 4; i++) {
        const double s = from + at[i] * (to - from), share = weight[i] * (to - from) * p->h;
        double y[2];
        quintic_at(p, s, &y[0], &y[1]);
        const struct power power = power_at(system, drags, t + s * p->h, y);
        *work += share * power.all;
        *drag += share * power.drag;
    }
}

static void across(const struct system *system, const struct quintic *p, double t, double *work, double *drag)
{
    const double s = turning_point(p);
    const bool drags = drags_only(system);
    *work = *drag = 0;
    add_part(system, drags, p, t, 0, s, work, drag);
    add_part(system, drags, p, t, s, 1, work, drag);
}

/* ---- any system ---- */

/* Both inner points of one step. */
static void inner_states(int half, double h, const double *y0, const double *a0, const double *y1, const double *a1,
                         double *first, double *second)
{
    for (int i = 0; i < half; i++) {
        const double v0 = y0[i + half], v1 = y1[i + half], rise = y1[i] - y0[i];
        const double q = (y0[i] + y1[i]) / 2 + h * (0.12 * (v0 - v1) + 0.01 * h * (a0[i] + a1[i]));
        const double dq = (0.82 * rise - h * (0.16 * (v0 + v1) + 0.01 * h * (a0[i] - a1[i]))) / SQRT5;
        const double v = 1.2 * (rise / h) - 0.1 * (v0 + v1);
        const double dv = (0.7 * (v0 - v1) + 0.1 * h * (a0[i] + a1[i])) / SQRT5;
        first[i] = q - dq;
        second[i] = q + dq;
        first[i + half] = v + dv;
        second[i + half] = v - dv;
    }
}

static void scaled_state(const struct work *work, int k, double *y)
{
    const double *state = k == 0 ? work->before : work->row + (size_t)(k - 1) * work->stride;
    for (int i = 0; i < work->system->n; i++)
        y[i] = state[i] * work->factor;
}

static void work_of_any(const struct work *work, struct work_done *done)
{
    const struct system *system = work->system;
    double y[2][LIMIT_VARIABLES], a[2][LIMIT_VARIABLES], first[LIMIT_VARIABLES], second[LIMIT_VARIABLES];
    struct power p[2];
    const bool drags = drags_only(system);
    scaled_state(work, 0, y[0]);
    if (!system->conservative) {
        system_acceleration(system, time_of(work, 0), y[0], a[0]);
        p[0] = power_at(system, drags, time_of(work, 0), y[0]);
    }
    for (int k = 0; k < work->count; k++) {
        const int from = k & 1, to = from ^ 1;
        scaled_state(work, k + 1, y[to]);
        done->energy[k] = system_energy(system, y[to]);
        done->work[k] = done->drag[k] = 0;
        if (system->conservative)
            continue;
        const double t = time_of(work, k), h = length_of(work, k);
        system_acceleration(system, time_of(work, k + 1), y[to], a[to]);
        p[to] = power_at(system, drags, time_of(work, k + 1), y[to]);
        if (h == 0)
            continue;
        if (system->kinks && y[from][1] * y[to][1] < 0) {
            const struct quintic quintic = {h, y[from][0], y[from][1], a[from][0], y[to][0], y[to][1], a[to][0]};
            across(system, &quintic, t, &done->work[k], &done->drag[k]);
            continue;
        }
        inner_states(system->n / 2, h, y[from], a[from], y[to], a[to], first, second);
        const struct power b = power_at(system, drags, t + INNER * h, first),
                           c = power_at(system, drags, t + (1 - INNER) * h, second);
        done->work[k] = h * ((p[from].all + p[to].all) + 5 * (b.all + c.all)) / 12;
        done->drag[k] = h * ((p[from].drag + p[to].drag) + 5 * (b.drag + c.drag)) / 12;
    }
}

/* ---- oscillators ---- */

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define TERM_BODIES
#include "../scene/terms.def"
#undef TERM_BODIES
#pragma GCC diagnostic pop

enum {
#define CONSERVATIVE_TERM(name, ...) PLACE_##name,
#define POWERED_TERM(name, ...) PLACE_##name,
#include "../scene/terms.def"
    PLACES
};

#define HAS(name) (1u << PLACE_##name)

/* Coefficients of the terms that are there; those of the others are 0. */
struct line {
    double c[PLACES][TERM_COEFFICIENTS];
    double mass;
};

/* The terms of an oscillator, one bit each; 0: it is something else. */
static unsigned terms_of(const struct system *system, struct line *line)
{
    unsigned terms = 0;
    const struct term_row *rows = (const struct term_row *)(const void *)catalog_row(&term_catalog, 0);
    memset(line, 0, sizeof *line);
    line->mass = system->mass;
    if (system->n != 2 || system->model->terms != &term_catalog || system->typed.row)
        return 0;
    for (int i = 0; i < system->terms; i++) {
        const ptrdiff_t place = system->term[i].row - rows;
        if (place < 0 || place >= PLACES)
            return 0;
        terms |= 1u << place;
        memcpy(line->c[place], system->term[i].c, sizeof line->c[place]);
    }
    return terms;
}

/* States and times of a block, each quantity for itself. */
struct block {
    double q[WORK_BLOCK + 1], v[WORK_BLOCK + 1], a[WORK_BLOCK + 1], p[WORK_BLOCK + 1], d[WORK_BLOCK + 1];
    double h[WORK_BLOCK], rate[WORK_BLOCK]; /* 1/h */
    double cosine[3][WORK_BLOCK + 1];       /* of the drive, at the states and at the inner points of the steps */
};

/* Terms in the order of terms.def; that of the drive by the cosine that is already there. */
ALWAYS_INLINE double acceleration(unsigned terms, const struct line *line, double q, double v, double cosine)
{
    const double y[2] = {q, v};
    double a = -0.0;
    if (terms & HAS(spring))
        spring_add(line->c[PLACE_spring], 0, y, &a);
    if (terms & HAS(damping))
        damping_add(line->c[PLACE_damping], 0, y, &a);
    if (terms & HAS(drag))
        drag_add(line->c[PLACE_drag], 0, y, &a);
    if (terms & HAS(gravity))
        gravity_add(line->c[PLACE_gravity], 0, y, &a);
    if (terms & HAS(drive))
        a += line->c[PLACE_drive][0] * cosine;
    if (terms & HAS(cubic))
        cubic_add(line->c[PLACE_cubic], 0, y, &a);
    if (terms & HAS(vanderpol))
        vanderpol_add(line->c[PLACE_vanderpol], 0, y, &a);
    return a;
}

ALWAYS_INLINE double drag_power_of(unsigned terms, const struct line *line, double q, double v)
{
    const double y[2] = {q, v};
    double power = 0;
    if (terms & HAS(damping))
        power += damping_power(line->c[PLACE_damping], 0, y);
    if (terms & HAS(drag))
        power += drag_power(line->c[PLACE_drag], 0, y);
    if (terms & HAS(vanderpol))
        power += vanderpol_power(line->c[PLACE_vanderpol], 0, y);
    return power;
}

ALWAYS_INLINE double energy_at(unsigned terms, const struct line *line, double q, double v)
{
    const double y[2] = {q, v};
    double potential = 0;
    if (terms & HAS(spring))
        potential += spring_potential(line->c[PLACE_spring], y);
    if (terms & HAS(gravity))
        potential += gravity_potential(line->c[PLACE_gravity], y);
    if (terms & HAS(cubic))
        potential += cubic_potential(line->c[PLACE_cubic], y);
    return 0.5 * line->mass * v * v + potential;
}

/* Row i of the states is y[i stride]. */
ALWAYS_INLINE void take_rows(const struct work *work, size_t stride, struct block *restrict b)
{
    const double factor = work->factor;
    for (int k = 0; k < work->count; k++) {
        b->q[k + 1] = work->row[(size_t)k * stride] * factor;
        b->v[k + 1] = work->row[(size_t)k * stride + 1] * factor;
    }
}

ALWAYS_INLINE void take_states(const struct work *work, struct block *restrict b)
{
    b->q[0] = work->before[0] * work->factor;
    b->v[0] = work->before[1] * work->factor;
    if (work->stride == 2)
        take_rows(work, 2, b);
    else
        take_rows(work, work->stride, b);
}

static void take_lengths(const struct work *work, struct block *b)
{
    const double rate = 1 / work->h;
    for (int k = 0; k < work->count; k++) {
        b->h[k] = work->t ? work->t[k + 1] - work->t[k] : work->h;
        b->rate[k] = work->t ? (b->h[k] != 0 ? 1 / b->h[k] : 0) : rate;
    }
}

ALWAYS_INLINE void block_work(unsigned terms, const struct line *line, const struct work *work,
                              struct block *restrict b, struct work_done *restrict done)
{
    const int count = work->count;
    take_states(work, b);
    const double force = line->c[PLACE_drive][3];
    for (int k = 0; k < count; k++)
        done->energy[k] = energy_at(terms, line, b->q[k + 1], b->v[k + 1]);
    if (!(terms & (HAS(damping) | HAS(drag) | HAS(drive) | HAS(vanderpol)))) {
        memset(done->work, 0, (size_t)count * sizeof *done->work);
        memset(done->drag, 0, (size_t)count * sizeof *done->drag);
        return;
    }
    take_lengths(work, b);
    for (int k = 0; k <= count; k++) {
        const double cosine = terms & HAS(drive) ? b->cosine[0][k] : 0;
        b->a[k] = acceleration(terms, line, b->q[k], b->v[k], cosine);
        b->d[k] = drag_power_of(terms, line, b->q[k], b->v[k]);
        b->p[k] = terms & HAS(drive) ? force * cosine * b->v[k] : 0;
    }
    for (int k = 0; k < count; k++) {
        const double h = b->h[k], q0 = b->q[k], q1 = b->q[k + 1], v0 = b->v[k], v1 = b->v[k + 1], a0 = b->a[k],
                     a1 = b->a[k + 1];
        const double v = 1.2 * ((q1 - q0) * b->rate[k]) - 0.1 * (v0 + v1);
        const double dv = (0.7 * (v0 - v1) + 0.1 * h * (a0 + a1)) * (1 / SQRT5);
        const double q = (q0 + q1) / 2 + h * (0.12 * (v0 - v1) + 0.01 * h * (a0 + a1));
        const double dq = (0.82 * (q1 - q0) - h * (0.16 * (v0 + v1) + 0.01 * h * (a0 - a1))) * (1 / SQRT5);
        const double drag = drag_power_of(terms, line, q - dq, v + dv) + drag_power_of(terms, line, q + dq, v - dv);
        done->drag[k] = h * ((b->d[k] + b->d[k + 1]) + 5 * drag) * (1. / 12);
        if (terms & HAS(drive)) {
            const double drive = force * (b->cosine[1][k] * (v + dv) + b->cosine[2][k] * (v - dv));
            done->work[k] = done->drag[k] + h * ((b->p[k] + b->p[k + 1]) + 5 * drive) * (1. / 12);
        } else {
            done->work[k] = done->drag[k];
        }
    }
}

#define KIND(name, terms)                                                                                              \
    CLONES static void block_##name(const struct line *line, const struct work *work, struct block *restrict b,        \
                                    struct work_done *restrict done)                                                   \
    {                                                                                                                  \
        block_work((terms), line, work, b, done);                                                                      \
    }

/* The first that has all terms of a scene is taken; coefficients of terms that are not there are 0. */
#define KINDS(K)                                                                                                       \
    K(elastic, HAS(spring) | HAS(gravity) | HAS(cubic))                                                                \
    K(damped, HAS(spring) | HAS(damping) | HAS(gravity))                                                               \
    K(dragged, HAS(spring) | HAS(damping) | HAS(gravity) | HAS(drag))                                                  \
    K(driven, HAS(spring) | HAS(damping) | HAS(gravity) | HAS(drive) | HAS(cubic))                                     \
    K(vanderpol, HAS(spring) | HAS(vanderpol))                                                                         \
    K(all, (1u << PLACES) - 1)

KINDS(KIND)

static const struct kind {
    unsigned terms;
    void (*work)(const struct line *line, const struct work *work, struct block *restrict b,
                 struct work_done *restrict done);
} kinds[] = {
#define KIND_ROW(name, terms) {(terms), block_##name},
    KINDS(KIND_ROW)};

/*
 * Cosines of the drive at even times: the angle of the block's beginning, and from there on the sums of angles. A table
 * holds the multiples of omega h, so that each value is one product away from the library's.
 */
static void even_cosines(const struct work *work, const double *c, struct block *b)
{
    struct turns *turns = work->turns;
    if (turns->omega != c[1] || turns->h != work->h) {
        *turns = (struct turns){.omega = c[1], .h = work->h};
        for (int k = 0; k <= WORK_BLOCK; k++) {
            turns->cosine[k] = cos((double)k * (c[1] * work->h));
            turns->sine[k] = sin((double)k * (c[1] * work->h));
        }
    }
    const int64_t whole = work->index - (work->index & (WORK_BLOCK - 1));
    const int at = (int)(work->index - whole);
    const double angle = c[1] * (work->origin + (double)whole * work->h) + c[2], x = cos(angle), y = sin(angle);
    const double inner = c[1] * (INNER * work->h), outer = c[1] * ((1 - INNER) * work->h);
    const double cos1 = cos(inner), sin1 = sin(inner), cos2 = cos(outer), sin2 = sin(outer);
    for (int k = 0; k <= work->count; k++) {
        const double cosine = x * turns->cosine[at + k] - y * turns->sine[at + k],
                     sine = y * turns->cosine[at + k] + x * turns->sine[at + k];
        b->cosine[0][k] = cosine;
        b->cosine[1][k] = cosine * cos1 - sine * sin1;
        b->cosine[2][k] = cosine * cos2 - sine * sin2;
    }
}

static void cosines(const struct work *work, const double *c, struct block *b)
{
    if (!work->t) {
        even_cosines(work, c, b);
        return;
    }
    for (int k = 0; k <= work->count; k++) {
        b->cosine[0][k] = cos(c[1] * work->t[k] + c[2]);
        if (k < work->count) {
            const double h = work->t[k + 1] - work->t[k];
            b->cosine[1][k] = cos(c[1] * (work->t[k] + INNER * h) + c[2]);
            b->cosine[2][k] = cos(c[1] * (work->t[k] + (1 - INNER) * h) + c[2]);
        }
    }
}

static void turn_across(const struct work *work, const struct block *b, struct work_done *done)
{
    for (int k = 0; k < work->count; k++)
        if (b->v[k] * b->v[k + 1] < 0 && b->h[k] != 0) {
            const struct quintic p = {b->h[k], b->q[k], b->v[k], b->a[k], b->q[k + 1], b->v[k + 1], b->a[k + 1]};
            across(work->system, &p, time_of(work, k), &done->work[k], &done->drag[k]);
        }
}

void work_between(const struct work *work, struct work_done *done)
{
    struct line line;
    struct block b;
    const unsigned terms = terms_of(work->system, &line);
    if (!terms) {
        work_of_any(work, done);
        return;
    }
    if (terms & HAS(drive))
        cosines(work, line.c[PLACE_drive], &b);
    const struct kind *kind = kinds;
    while (terms & ~kind->terms)
        kind++;
    if (kind->terms & ~terms & HAS(drive))
        memset(b.cosine, 0, sizeof b.cosine);
    kind->work(&line, work, &b, done);
    if (work->system->kinks)
        turn_across(work, &b, done);
}
