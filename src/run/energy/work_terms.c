/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Work and energy of oscillators and of the pendulum, for blocks of steps in loops that vectorise.
 * They use the functions of terms.def, but only for the terms that the scene has. work.c has the
 * formulas, with the same names, and handles all other systems. */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"
#include "scene/model/params.h"
#include "run/energy/work.h"

#include <math.h>

/* ---- terms ---- */

/* Index of each term in struct oscillator_terms, in the order of terms.def. */
enum {
#define CONSERVATIVE_TERM(name, ...) PLACE_##name,
#define POWERED_TERM(name, ...) PLACE_##name,
#include "scene/model/terms.def"
    OSCILLATOR_PLACES,
    /* weight of the pendulum, whose damping and drive are those of the oscillator */
    PLACE_weight = OSCILLATOR_PLACES,
    PLACES
};

#define HAS(name) (1u << PLACE_##name)
/* Terms that block_work() supports. */
#define OSCILLATOR_TERMS                                                                           \
    (HAS(spring) | HAS(damping) | HAS(drag) | HAS(gravity) | HAS(drive) | HAS(cubic) |             \
     HAS(vanderpol) | HAS(friction))
#define PENDULUM_TERMS (HAS(weight) | HAS(damping) | HAS(drive))
#define POWERED_TERMS (HAS(damping) | HAS(drag) | HAS(drive) | HAS(vanderpol) | HAS(friction))

/* Coefficients of the terms that the scene has; those of the others are 0. */
struct oscillator_terms {
    double c[PLACES][TERM_COEFFICIENTS];
    double mass; /* [kg] */
};

/* Index of the term with the same formula as row i of the pendulum's terms; later rows have no
 * such term. */
static const int pendulum_index[] = {PLACE_weight, PLACE_damping, PLACE_drive};

/* Returns the index of a term of the system among those above, or PLACES if it is none of them. */
static ptrdiff_t term_index(const struct system *system, const struct term_row *row)
{
    const struct term_row *rows =
        (const struct term_row *)(const void *)catalog_row(system->model->terms, 0);
    const ptrdiff_t position = row - rows;
    if (system->model == &pendulum_model)
        return position >= 0 && position < (ptrdiff_t)COUNT_OF(pendulum_index)
                   ? pendulum_index[position]
                   : PLACES;
    return system->model->terms == &term_catalog && position >= 0 && position < OSCILLATOR_PLACES
               ? position
               : PLACES;
}

/* Returns the terms of an oscillator or a pendulum, one bit HAS() each, and fills *line. Returns 0
 * if the system has other terms. */
static unsigned terms_of(const struct system *system, struct oscillator_terms *line)
{
    unsigned terms = 0;
    memset(line, 0, sizeof *line);
    line->mass = system->mass;
    if (system->n != 2 || system->typed.row)
        return 0;
    for (int i = 0; i < system->terms; i++) {
        const ptrdiff_t index = term_index(system, system->term[i].row);
        if (index == PLACES || !((OSCILLATOR_TERMS | PENDULUM_TERMS) & 1u << index))
            return 0;
        terms |= 1u << index;
        memcpy(line->c[index], system->term[i].c, sizeof line->c[index]);
    }
    return terms;
}

/* States and steps of a block, an array for each quantity, so that loops vectorise. Index k is the
 * state after k steps, or step k. */
struct work_block {
    double q[WORK_BLOCK + 1], v[WORK_BLOCK + 1], a[WORK_BLOCK + 1]; /* scaled motion */
    double p[WORK_BLOCK + 1], d[WORK_BLOCK + 1]; /* power of the drive and of drag */
    double h[WORK_BLOCK], rate[WORK_BLOCK];      /* step [s] and 1/h */
    /* cosine of the drive, at the states and at both inner points of the steps */
    double cosine[3][WORK_BLOCK + 1];
    /* sines of the pendulum's angle and of half of it */
    double sine[WORK_BLOCK + 1], half[WORK_BLOCK + 1];
};

/* Sets sine [count] to the sines of factor times x [count]. */
static void take_sines(int count, const double *restrict x, double factor, double *restrict sine)
{
    for (int k = 0; k < count; k++)
        sine[k] = x[k] * factor;
    fixed_sines(count, sine, sine);
}

/* Returns the acceleration by the terms in the order of terms.def, whose rounding it has. The
 * cosine of the drive and the sine of the pendulum's angle are computed by the caller. */
ALWAYS_INLINE double acceleration(unsigned terms, const struct oscillator_terms *line, double q,
                                  double v, double cosine, double sine)
{
    const double y[2] = {q, v};
    double a = -0.0;
    if (terms & HAS(spring))
        spring_add(line->c[PLACE_spring], 0, y, &a);
    if (terms & HAS(weight))
        a -= line->c[PLACE_weight][0] * sine;
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
    /* the last term, as in terms.def, because at rest friction balances all others */
    if (terms & HAS(friction))
        friction_add(line->c[PLACE_friction], 0, y, &a);
    return a;
}

/* Returns the power of all terms that depend on velocity. */
ALWAYS_INLINE double drag_power_of(unsigned terms, const struct oscillator_terms *line, double q,
                                   double v)
{
    const double y[2] = {q, v};
    double a = 0;
    if (terms & HAS(damping))
        damping_add(line->c[PLACE_damping], 0, y, &a);
    if (terms & HAS(drag))
        drag_add(line->c[PLACE_drag], 0, y, &a);
    if (terms & HAS(vanderpol))
        vanderpol_add(line->c[PLACE_vanderpol], 0, y, &a);
    if (terms & HAS(friction))
        a -= v != 0 ? copysign(line->c[PLACE_friction][0], v) : 0;
    return line->mass * a * v;
}

/* Returns kinetic and potential energy; `half` is the sine of half the pendulum's angle. */
ALWAYS_INLINE double energy_at(unsigned terms, const struct oscillator_terms *line, double q,
                               double v, double half)
{
    const double y[2] = {q, v};
    double potential = 0;
    if (terms & HAS(spring))
        potential += spring_potential(line->c[PLACE_spring], y);
    if (terms & HAS(gravity))
        potential += gravity_potential(line->c[PLACE_gravity], y);
    if (terms & HAS(cubic))
        potential += cubic_potential(line->c[PLACE_cubic], y);
    if (terms & HAS(weight))
        potential += 2 * line->c[PLACE_weight][1] * half * half;
    return 0.5 * line->mass * v * v + potential;
}

/* Scales the states after each step and enters them into the block. The stride is a constant in the
 * common case, so that the loop vectorises. */
ALWAYS_INLINE void block_rows_scale(const struct work *work, size_t stride,
                                    struct work_block *restrict b)
{
    const double factor = work->factor;
    for (int k = 0; k < work->count; k++) {
        b->q[k + 1] = work->row[(size_t)k * stride] * factor;
        b->v[k + 1] = work->row[(size_t)k * stride + 1] * factor;
    }
}

/* Enters the states before and after all steps into the block. */
ALWAYS_INLINE void block_states_scale(const struct work *work, struct work_block *restrict b)
{
    b->q[0] = work->initial_state[0] * work->factor;
    b->v[0] = work->initial_state[1] * work->factor;
    if (work->stride == 2)
        block_rows_scale(work, 2, b);
    else
        block_rows_scale(work, work->stride, b);
}

/* Enters the steps and their inverses into the block, in loops without branches, so that they
 * vectorise. */
ALWAYS_INLINE void block_steps_set(const struct work *work, struct work_block *restrict b)
{
    const double h = work->h, rate = 1 / h;
    if (!work->t) {
        for (int k = 0; k < work->count; k++) {
            b->h[k] = h;
            b->rate[k] = rate;
        }
        return;
    }
    for (int k = 0; k < work->count; k++) {
        b->h[k] = work->t[k + 1] - work->t[k];
        b->rate[k] = b->h[k] != 0 ? 1 / b->h[k] : 0;
    }
}

/* Computes energies and work of a block, for a set of terms that is a constant where this is
 * inlined. The integral of the power in each step is Lobatto's rule at the two ends and the two
 * inner points of the quintic, q -+ dq and v +- dv. */
ALWAYS_INLINE void block_work(unsigned terms, const struct oscillator_terms *line,
                              const struct work *work, struct work_block *restrict b,
                              struct work_done *restrict done)
{
    const int count = work->count;
    block_states_scale(work, b);
    const double force = line->c[PLACE_drive][3];
    if (terms & HAS(weight))
        take_sines(count, b->q + 1, 0.5, b->half + 1);
    for (int k = 0; k < count; k++)
        done->energy[k] = energy_at(terms, line, b->q[k + 1], b->v[k + 1],
                                    terms & HAS(weight) ? b->half[k + 1] : 0);
    if (!(terms & POWERED_TERMS)) {
        memset(done->work, 0, (size_t)count * sizeof *done->work);
        memset(done->drag, 0, (size_t)count * sizeof *done->drag);
        return;
    }
    block_steps_set(work, b);
    if (terms & HAS(weight))
        take_sines(count + 1, b->q, 1, b->sine);
    for (int k = 0; k <= count; k++) {
        const double cosine = terms & HAS(drive) ? b->cosine[0][k] : 0;
        const double sine = terms & HAS(weight) ? b->sine[k] : 0;
        b->a[k] = acceleration(terms, line, b->q[k], b->v[k], cosine, sine);
        b->d[k] = drag_power_of(terms, line, b->q[k], b->v[k]);
        b->p[k] = terms & HAS(drive) ? force * cosine * b->v[k] : 0;
    }
    for (int k = 0; k < count; k++) {
        const double h = b->h[k], q0 = b->q[k], q1 = b->q[k + 1], v0 = b->v[k], v1 = b->v[k + 1],
                     a0 = b->a[k], a1 = b->a[k + 1];
        const double v = 1.2 * ((q1 - q0) * b->rate[k]) - 0.1 * (v0 + v1);
        const double dv = (0.7 * (v0 - v1) + 0.1 * h * (a0 + a1)) * (1 / SQRT_5);
        const double q = (q0 + q1) / 2 + h * (0.12 * (v0 - v1) + 0.01 * h * (a0 + a1));
        const double dq =
            (0.82 * (q1 - q0) - h * (0.16 * (v0 + v1) + 0.01 * h * (a0 - a1))) * (1 / SQRT_5);
        const double drag =
            drag_power_of(terms, line, q - dq, v + dv) + drag_power_of(terms, line, q + dq, v - dv);
        done->drag[k] = h * ((b->d[k] + b->d[k + 1]) + 5 * drag) * (1. / 12);
        if (terms & HAS(drive)) {
            const double drive = force * (b->cosine[1][k] * (v + dv) + b->cosine[2][k] * (v - dv));
            done->work[k] = done->drag[k] + h * ((b->p[k] + b->p[k + 1]) + 5 * drive) * (1. / 12);
        } else {
            done->work[k] = done->drag[k];
        }
    }
    int64_t coarse = 0;
    for (int k = 0; k < count; k++)
        coarse |= work_coarse(b->h[k], b->v[k], b->v[k + 1], b->a[k], b->a[k + 1]);
    done->any_coarse = coarse != 0;
    for (int k = 0; coarse && k < count; k++)
        done->coarse[k] = work_coarse(b->h[k], b->v[k], b->v[k + 1], b->a[k], b->a[k + 1]);
}

/* Defines block_NAME(), which is block_work() compiled for a set of terms. Wider vectors than those
 * of AVX2 gain nothing, because the loops wait for memory. */
#define KIND(name, terms)                                                                          \
    CLONES_FOR("avx2")                                                                             \
    static void block_##name(const struct oscillator_terms *line, const struct work *work,         \
                             struct work_block *restrict b, struct work_done *restrict done)       \
    {                                                                                              \
        block_work((terms), line, work, b, done);                                                  \
    }

/* Sets of terms with a function of their own. The first one that contains all terms of a scene is
 * used; terms that the scene does not have get the coefficient 0. */
#define KINDS(K)                                                                                   \
    K(elastic, HAS(spring) | HAS(gravity) | HAS(cubic))                                            \
    K(damped, HAS(spring) | HAS(damping) | HAS(gravity))                                           \
    K(dragged, HAS(spring) | HAS(damping) | HAS(gravity) | HAS(drag))                              \
    K(driven, HAS(spring) | HAS(damping) | HAS(gravity) | HAS(drive) | HAS(cubic))                 \
    K(vanderpol, HAS(spring) | HAS(vanderpol))                                                     \
    K(rubbed, HAS(spring) | HAS(damping) | HAS(gravity) | HAS(drag) | HAS(friction))               \
    K(all, OSCILLATOR_TERMS)                                                                       \
    K(swinging, HAS(weight))                                                                       \
    K(pendulum, PENDULUM_TERMS)

KINDS(KIND)

static const struct kind {
    unsigned terms;
    void (*work)(const struct oscillator_terms *line, const struct work *work,
                 struct work_block *restrict b, struct work_done *restrict done);
} kinds[] = {
#define KIND_ROW(name, terms) {(terms), block_##name},
    KINDS(KIND_ROW)};

/* Computes the cosines of the drive at even times: the angle at the beginning of the block, and
 * from there on sums of angles. A table holds the multiples of omega h, so that each value is one
 * product away from the library's. c is that of the drive: its amplitude, angular frequency and
 * phase. */
static void drive_cosines_even(const struct work *work, const double *c, struct work_block *b)
{
    struct turns *turns = work->turns;
    if (turns->omega != c[1] || turns->h != work->h) {
        *turns = (struct turns){.omega = c[1], .h = work->h};
        for (int k = 0; k <= WORK_BLOCK; k++) {
            turns->cosine[k] = fixed_cos((double)k * (c[1] * work->h));
            turns->sine[k] = fixed_sin((double)k * (c[1] * work->h));
        }
    }
    const int64_t whole = work->index - (work->index & (WORK_BLOCK - 1));
    const int base = (int)(work->index - whole);
    const double angle = c[1] * (work->origin + (double)whole * work->h) + c[2],
                 x = fixed_cos(angle), y = fixed_sin(angle);
    const double inner = c[1] * (LOBATTO_INNER * work->h),
                 outer = c[1] * ((1 - LOBATTO_INNER) * work->h);
    const double cos1 = fixed_cos(inner), sin1 = fixed_sin(inner), cos2 = fixed_cos(outer),
                 sin2 = fixed_sin(outer);
    for (int k = 0; k <= work->count; k++) {
        const double cosine = x * turns->cosine[base + k] - y * turns->sine[base + k],
                     sine = y * turns->cosine[base + k] + x * turns->sine[base + k];
        b->cosine[0][k] = cosine;
        b->cosine[1][k] = cosine * cos1 - sine * sin1;
        b->cosine[2][k] = cosine * cos2 - sine * sin2;
    }
}

/* Computes the cosines of the drive at the states and inner points of a block; c is that of
 * drive_cosines_even(). */
static void drive_cosines(const struct work *work, const double *c, struct work_block *b)
{
    if (!work->t) {
        drive_cosines_even(work, c, b);
        return;
    }
    for (int k = 0; k <= work->count; k++) {
        b->cosine[0][k] = fixed_cos(c[1] * work->t[k] + c[2]);
        if (k < work->count) {
            const double h = work->t[k + 1] - work->t[k];
            b->cosine[1][k] = fixed_cos(c[1] * (work->t[k] + LOBATTO_INNER * h) + c[2]);
            b->cosine[2][k] = fixed_cos(c[1] * (work->t[k] + (1 - LOBATTO_INNER) * h) + c[2]);
        }
    }
}

/* Computes the work anew for steps in which the velocity changes its sign, in two parts, and marks
 * those in which the force jumps. */
static void turning_steps_correct(const struct work *work, const struct work_block *b,
                                  struct work_done *done)
{
    for (int k = 0; k < work->count; k++) {
        done->jumps[k] = false;
        if (work_turns(work->system, b->v[k], b->v[k + 1]) && b->h[k] != 0) {
            const struct quintic p = {b->h[k],     b->q[k],     b->v[k],    b->a[k],
                                      b->q[k + 1], b->v[k + 1], b->a[k + 1]};
            done->jumps[k] =
                work_turn(work->system, &p, work_time(work, k), &done->work[k], &done->drag[k]);
        }
        done->any_jumps |= done->jumps[k];
    }
}

/* Runs the smallest set of terms that contains those of the scene; returns false for other
 * scenes. */
bool work_of_terms(const struct work *work, struct work_done *done)
{
    struct oscillator_terms line;
    struct work_block b;
    const unsigned terms = terms_of(work->system, &line);
    if (!terms)
        return false;
    if (terms & HAS(drive))
        drive_cosines(work, line.c[PLACE_drive], &b);
    const struct kind *kind = kinds;
    while (terms & ~kind->terms)
        kind++;
    if (kind->terms & ~terms & HAS(drive))
        memset(b.cosine, 0, sizeof b.cosine);
    kind->work(&line, work, &b, done);
    if (work->system->kinks)
        turning_steps_correct(work, &b, done);
    return true;
}
