/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The steps of LANES trajectories at once, written for one width of vector: included once for each,
 * with
 *
 *   WIDE         doubles in a vector
 *   TARGET       attributes of the functions: instructions that they may use
 *   WITH(name)   the name of something here
 *
 * The operations are those of rk_body.h and split_body.h, in their order, on every lane: the same
 * bits.
 */
typedef double WITH(vector) __attribute__((vector_size(WIDE * 8), aligned(WIDE * 8)));
typedef int64_t WITH(bits) __attribute__((vector_size(WIDE * 8), aligned(WIDE * 8)));
#define vector WITH(vector)
#define PARTS (LANES / WIDE)
#define FAST static inline __attribute__((always_inline)) TARGET

FAST vector WITH(magnitude)(vector x)
{
    return (vector)((WITH(bits))x & INT64_MAX);
}

FAST vector WITH(load)(const double *from, int part)
{
    vector x;
    memcpy(&x, from + part * WIDE, sizeof x);
    return x;
}

#include "method/kernel/lane/circle.h"

/* ---- forces: the terms that shapes are made of, by the operations of terms.def and weight.def
 * ---- */

#define LANE_TERM(name, change)                                                                    \
    FAST void WITH(name##_add)(UNUSED const vector *c, UNUSED vector cosine,                       \
                               UNUSED const vector *y, vector *a)                                  \
    {                                                                                              \
        *a change;                                                                                 \
    }
LANE_TERM(spring, -= c[0] * y[0])
LANE_TERM(damping, -= c[0] * y[1])
LANE_TERM(drag, -= c[0] * WITH(magnitude)(y[1]) * y[1])
LANE_TERM(drive, += c[0] * cosine)
LANE_TERM(cubic, -= c[0] * y[0] * y[0] * y[0])
LANE_TERM(vanderpol, += c[0] * (1 - y[0] * c[1] * (y[0] * c[1])) * y[1])
LANE_TERM(weight, -= c[0] * WITH(sine)(y[0]))

/* What one part of the lanes knows of the forces. */
struct WITH(known) {
    vector c[SHAPE_TERMS][LANE_COEFFICIENTS];
    vector cosine;
};

#define ANY_PARTS (WIDE == 8 ? 8 : 4)

/* a: of the first `parts` vectors of the states z */
typedef void WITH(force)(int parts, const struct WITH(known) * known, vector z[2][PARTS],
                         vector *a);

/* Those of a shape for who does not know it. */
struct WITH(forces) {
    WITH(force) * both, *force, *drag;
    unsigned flags;
};

#define LANE_ALWAYS(i, name) WITH(name##_add)(known[q].c[i], known[q].cosine, y, &sum);
#define LANE_IF_FORCE(i, name)                                                                     \
    if (!(name##_flags & TERM_VELOCITY))                                                           \
    LANE_ALWAYS(i, name)
#define LANE_IF_DRAG(i, name)                                                                      \
    if (name##_flags & TERM_VELOCITY)                                                              \
    LANE_ALWAYS(i, name)
#define LANE_FORCE(shape, which, TERM)                                                             \
    FAST void WITH(shape##which)(int parts, UNUSED const struct WITH(known) * known,               \
                                 vector z[2][PARTS], vector * a)                                   \
    {                                                                                              \
        UNROLL for (int q = 0; q < parts; q++)                                                     \
        {                                                                                          \
            UNUSED const vector y[2] = {z[0][q], z[1][q]};                                         \
            vector sum = -(vector){0};                                                             \
            TERMS_OF_##shape(TERM) a[q] = sum;                                                     \
        }                                                                                          \
    }                                                                                              \
    TARGET static void WITH(shape##which##_called)(int parts, const struct WITH(known) * known,    \
                                                   vector z[2][PARTS], vector * a)                 \
    {                                                                                              \
        (void)parts;                                                                               \
        WITH(shape##which)(ANY_PARTS, known, z, a);                                                \
    }
#define LANE_FORCES(shape)                                                                         \
    LANE_FORCE(shape, _both, LANE_ALWAYS)                                                          \
    LANE_FORCE(shape, _force, LANE_IF_FORCE)                                                       \
    LANE_FORCE(shape, _drag, LANE_IF_DRAG)                                                         \
    static const struct WITH(forces)                                                               \
        WITH(shape##_forces) = {WITH(shape##_both_called), WITH(shape##_force_called),             \
                                WITH(shape##_drag_called), LANE_FLAGS(shape)};
LANE_SHAPES(LANE_FORCES)

/* Those of the vectors from `from` on. */
FAST void WITH(take)(struct WITH(known) * known, int parts, int from, const struct lanes *lanes)
{
    for (int i = 0; i < SHAPE_TERMS; i++)
        for (int j = 0; j < LANE_COEFFICIENTS; j++)
            UNROLL for (int q = 0; q < parts; q++) known[q].c[i][j] =
                WITH(load)(lanes->c[i][j], from + q);
    UNROLL for (int q = 0; q < parts; q++) known[q].cosine = (vector){0};
}

FAST void WITH(begin)(int parts, int from, const double *numbers, vector *x)
{
    UNROLL for (int q = 0; q < parts; q++) x[q] = WITH(load)(numbers, from + q);
}

FAST void WITH(end)(int parts, int from, const vector *x, double *numbers)
{
    UNROLL for (int q = 0; q < parts; q++) memcpy(numbers + (from + q) * WIDE, &x[q], sizeof x[q]);
}

/* The drive at the place-th time of step i. */
FAST void WITH(look)(struct WITH(known) * known, int parts, int from, enum drive_known drive,
                     const struct lane_march *march, int64_t i, int place)
{
    const int64_t at = i * march->times + place;
    if (drive == DRIVE_ALIKE) {
        UNROLL for (int q = 0; q < parts; q++) known[q].cosine = march->cosine[at] - (vector){0};
    } else if (drive == DRIVE_OWN) {
        const double *own = march->cosine + march->row_of[at] * LANES;
        UNROLL for (int q = 0; q < parts; q++) known[q].cosine = WITH(load)(own, from + q);
    }
}

/* ---- explicit Runge-Kutta ---- */

/* Times each lane's own step; h: NULL, where the weight has it already. */
FAST vector WITH(of_step)(double weight, const vector *h, int q)
{
    return h ? h[q] * weight : weight - (vector){0};
}

/* z = y + sum_j (h w_j) k_j */
FAST void WITH(combine)(int parts, const struct weights *weights, const vector *h, int count,
                        int only, vector (*k)[2][PARTS], int component, const vector *y, vector *z)
{
    vector sum[PARTS];
    UNROLL for (int q = 0; q < parts; q++) sum[q] = -(vector){0};
    UNROLL for (int j = 0; j < count; j++) UNROLL for (int q = 0; q < parts; q++) sum[q] +=
        WITH(of_step)(weights->weight[j], h, q) *
        k[only < 0 ? weights->stage[j] : only + j][component][q];
    UNROLL for (int q = 0; q < parts; q++) z[q] = y[q] + sum[q];
}

FAST void WITH(slope)(int parts, WITH(force) * force, const struct WITH(known) * known,
                      vector z[2][PARTS], vector k[2][PARTS])
{
    UNROLL for (int q = 0; q < parts; q++) k[0][q] = z[1][q];
    force(parts, known, z, k[1]);
}

/* Has any lane's number changed its sign? */
FAST bool WITH(turned)(int parts, const vector *before, const vector *after)
{
    WITH(bits) turned = {0};
    uint64_t bits[WIDE], any = 0;
    UNROLL for (int q = 0; q < parts; q++) turned |= (WITH(bits))before[q] ^ (WITH(bits))after[q];
    memcpy(bits, &turned, sizeof bits);
    for (int i = 0; i < WIDE; i++)
        any |= bits[i];
    return any >> 63;
}

#include "method/kernel/lane/implicit.h"
#include "method/kernel/lane/turns.h"
#include "method/kernel/lane/adaptive.h"

/* `parts` vectors from `from` on. own: each lane has its own step. chain: four stages, each from
 * the one before. */
FAST void WITH(rk)(bool own, bool chain, int parts, int from, WITH(force) * force,
                   enum drive_known drive, lane_turner *turn, struct lanes *lanes,
                   const struct lane_march *march)
{
    const int stages = chain ? 4 : lanes->method->tableau->stages;
    const bool fsal = !chain && lanes->method->tableau->fsal;
    double *const row = march->row;
    vector y[2][PARTS], z[2][PARTS], k[STAGES_MAX][2][PARTS], size[PARTS];
    const vector *const h = own ? size : NULL;
    struct WITH(known) known[PARTS];
    WITH(take)(known, parts, from, lanes);
    if (own)
        WITH(begin)(parts, from, lanes->own_h, size);
    for (int i = 0; i < 2; i++)
        WITH(begin)(parts, from, lanes->y[i], y[i]);
    if (fsal && lanes->step > 0) {
        for (int i = 0; i < 2; i++)
            WITH(begin)(parts, from, lanes->carried[i], k[stages - 1][i]);
    } else if (fsal) {
        WITH(look)(known, parts, from, drive, march, 0, 0);
        WITH(slope)(parts, force, known, y, k[stages - 1]);
    }
    for (int64_t i = 0; i < march->count; i++) {
        if (fsal) {
            for (int j = 0; j < 2; j++)
                UNROLL for (int q = 0; q < parts; q++) k[0][j][q] = k[stages - 1][j][q];
        } else {
            WITH(look)(known, parts, from, drive, march, i, 0);
            WITH(slope)(parts, force, known, y, k[0]);
        }
        for (int s = 1; s < stages; s++) {
            const struct weights *weights = &march->weights[s];
            for (int j = 0; j < 2; j++)
                WITH(combine)
            (parts, weights, h, chain ? 1 : weights->count, chain ? s - 1 : -1, k, j, y[j], z[j]);
            WITH(look)(known, parts, from, drive, march, i, s);
            WITH(slope)(parts, force, known, z, k[s]);
        }
        for (int j = 0; j < 2 && !fsal; j++)
            WITH(combine)
        (parts, &march->weights[0], h, chain ? 4 : march->weights[0].count, chain ? 0 : -1, k, j,
         y[j], z[j]);
        if (turn && WITH(turned)(parts, y[1], z[1])) {
            struct lane_step step;
            for (int j = 0; j < 2; j++) {
                WITH(end)(parts, 0, y[j], step.before[j]);
                WITH(end)(parts, 0, z[j], step.after[j]);
                WITH(end)(parts, 0, k[0][j], step.first[j]);
                WITH(end)(parts, 0, k[stages - 1][j], step.last[j]);
            }
            turn(lanes, from * WIDE, parts * WIDE, march->first + i, &step);
            for (int j = 0; j < 2; j++) {
                WITH(begin)(parts, 0, step.after[j], z[j]);
                WITH(begin)(parts, 0, step.last[j], k[stages - 1][j]);
            }
        }
        for (int j = 0; j < 2; j++)
            UNROLL for (int q = 0; q < parts; q++) y[j][q] = z[j][q];
        for (int j = 0; j < 2 && row; j++)
            WITH(end)(parts, from, y[j], row + (2 * i + j) * LANES);
    }
    for (int i = 0; i < 2; i++) {
        WITH(end)(parts, from, y[i], lanes->y[i]);
        if (fsal)
            WITH(end)(parts, from, k[stages - 1][i], lanes->carried[i]);
    }
}

/* ---- splittings ---- */

/* drag_flow_apply(), where it has no pole */
FAST void WITH(flow)(int parts, int from, const struct lanes *lanes, vector *v)
{
    UNROLL for (int q = 0; q < parts; q++)
    {
        const vector pull = WITH(load)(lanes->pull, from + q) * WITH(magnitude)(v[q]);
        v[q] = v[q] * WITH(load)(lanes->keep, from + q);
        if (lanes->divides)
            v[q] = v[q] / (WITH(load)(lanes->min, from + q) + pull);
    }
}

FAST void WITH(kick)(const struct split_way *way, int parts, int from, WITH(force) * drag,
                     const struct WITH(known) * known, const struct lanes *lanes, int index,
                     double weight, const vector *h, const vector *pull, vector z[2][PARTS])
{
    vector a[PARTS];
    if (way->drag == DRAG_EXPLICIT)
        drag(parts, known, z, a);
    UNROLL for (int q = 0; q < parts; q++)
    {
        const vector w = WITH(of_step)(weight, h, q);
        if (way->drag == DRAG_EXPLICIT) {
            z[1][q] += w * (pull[q] + a[q]);
        } else if (way->drag == DRAG_EXACT && !way->around) {
            z[1][q] += pull[q] * WITH(load)(lanes->frozen[index].pull, from + q) -
                       z[1][q] * WITH(load)(lanes->frozen[index].lost, from + q);
        } else {
            z[1][q] += w * pull[q];
        }
    }
}

/* euler: a drift, then a kick. */
FAST void WITH(split)(bool own, bool euler, enum drag variant, int parts, int from,
                      WITH(force) * force, WITH(force) * drag, enum drive_known drive,
                      struct lanes *lanes, const struct lane_march *march)
{
    struct split_way way;
    split_choose(&way, lanes->method, variant);
    if (euler)
        way.around = way.continues = false;
    const int count = euler ? 2 : way.splitting->count;
    const bool kick_first = !euler && way.splitting->kick_first;
    const double weights[2] = {march->weight[0], march->weight[1]}; /* in registers */
    vector z[2][PARTS], pull[PARTS], size[PARTS];
    const vector *const h = own ? size : NULL;
    struct WITH(known) known[PARTS];
    WITH(take)(known, parts, from, lanes);
    if (own)
        WITH(begin)(parts, from, lanes->own_h, size);
    for (int i = 0; i < 2; i++)
        WITH(begin)(parts, from, lanes->y[i], z[i]);
    WITH(begin)(parts, from, lanes->carried[0], pull);
    for (int64_t i = 0; i < march->count; i++) {
        if (way.around)
            WITH(flow)(parts, from, lanes, z[1]);
        for (int index = 0; index < count; index++) {
            const double w = euler ? weights[index] : march->weight[index];
            if ((index % 2 == 0) == kick_first) {
                if (!(index == 0 && way.continues && (lanes->step > 0 || i > 0))) {
                    WITH(look)(known, parts, from, drive, march, i, index);
                    force(parts, known, z, pull);
                }
                WITH(kick)(&way, parts, from, drag, known, lanes, index, w, h, pull, z);
            } else {
                UNROLL for (int q = 0; q < parts; q++) z[0][q] += WITH(of_step)(w, h, q) * z[1][q];
            }
        }
        if (way.around)
            WITH(flow)(parts, from, lanes, z[1]);
        for (int j = 0; j < 2 && march->row; j++)
            WITH(end)(parts, from, z[j], march->row + (2 * i + j) * LANES);
    }
    for (int i = 0; i < 2; i++)
        WITH(end)(parts, from, z[i], lanes->y[i]);
    if (way.continues)
        WITH(end)(parts, from, pull, lanes->carried[0]);
}

/* ---- the kernels ---- */

TARGET static __attribute__((noinline)) void
WITH(any_rk)(const struct WITH(forces) * of, struct lanes *lanes, const struct lane_march *march)
{
    const bool timed = of->flags & TERM_TIME;
    lane_turner *const turn = of->flags & TERM_KINK && lanes->turns ? lanes_turn : NULL;
    const enum drive_known drive = timed ? march->drive : DRIVE_NONE;
    for (int from = 0; from < PARTS && lanes->own; from += ANY_PARTS)
        WITH(rk)(true, false, ANY_PARTS, from, of->both, drive, turn, lanes, march);
    for (int from = 0; from < PARTS && !lanes->own; from += ANY_PARTS)
        WITH(rk)(false, false, ANY_PARTS, from, of->both, drive, turn, lanes, march);
}

TARGET static __attribute__((noinline)) void
WITH(any_split)(const struct WITH(forces) * of, struct lanes *lanes, const struct lane_march *march)
{
    const bool timed = of->flags & TERM_TIME;
    const enum drive_known drive = timed ? march->drive : DRIVE_NONE;
    const enum drag drag = of->flags & TERM_VELOCITY ? lanes->drag : DRAG_DEFAULT;
    for (int from = 0; from < PARTS && lanes->own; from += ANY_PARTS)
        WITH(split)(true, false, drag, ANY_PARTS, from, of->force, of->drag, drive, lanes, march);
    for (int from = 0; from < PARTS && !lanes->own; from += ANY_PARTS)
        WITH(split)(false, false, drag, ANY_PARTS, from, of->force, of->drag, drive, lanes, march);
}

/* Implicit ones are waited for by their stages: the compiler knows whether there is one alone. */
TARGET static __attribute__((noinline)) void WITH(any_irk)(const struct WITH(implicit) * solver,
                                                           struct lanes *lanes,
                                                           const struct lane_march *march)
{
    for (int from = 0; from < PARTS; from += ANY_PARTS)
        WITH(irk)(march->chain, ANY_PARTS, from, solver, march->drive, lanes, march);
}

/* The commonest methods where the compiler knows how they go and what they step; all others. */
#define RK_PARTS 4
#define SPLIT_PARTS 4
#define EULER_PARTS 8
#define LANE_DRIVE(shape, drive) (LANE_FLAGS(shape) & TERM_TIME ? (drive) : DRIVE_NONE)
#define LANE_RK4(shape, own, drive)                                                                \
    for (int from = 0; from < PARTS; from += RK_PARTS)                                             \
        WITH(rk)                                                                                   \
    (own, true, RK_PARTS, from, WITH(shape##_both), LANE_DRIVE(shape, drive),                      \
     LANE_FLAGS(shape) & TERM_KINK && lanes->turns ? WITH(shape##_turn) : NULL, lanes, march)
#define LANE_PARTED(shape, drive, euler, variant, parts)                                           \
    for (int from = 0; from < PARTS; from += parts)                                                \
        WITH(split)                                                                                \
    (false, euler, LANE_FLAGS(shape) & TERM_VELOCITY ? variant : DRAG_DEFAULT, parts, from,        \
     WITH(shape##_force), WITH(shape##_drag), LANE_DRIVE(shape, drive), lanes, march)
#define LANE_KERNELS(shape)                                                                        \
    TARGET static __attribute__((noinline)) void WITH(shape##_turn)(                               \
        struct lanes * lanes, int first, int count, int64_t number, struct lane_step *step)        \
    {                                                                                              \
        (void)number;                                                                              \
        if ((LANE_FLAGS(shape) & (TERM_KINK | TERM_TIME)) == TERM_KINK)                            \
            WITH(turn_packed)(WITH(shape##_both), lanes, first, count, step);                      \
    }                                                                                              \
    TARGET static void WITH(shape##_rk)(struct lanes * lanes, const struct lane_march *march)      \
    {                                                                                              \
        const bool alike = !(LANE_FLAGS(shape) & TERM_TIME && march->drive == DRIVE_OWN);          \
        if (WIDE >= WIDE_UNROLLED && march->chain && lanes->own)                                   \
            LANE_RK4(shape, true, DRIVE_OWN);                                                      \
        else if (WIDE >= WIDE_UNROLLED && march->chain && alike)                                   \
            LANE_RK4(shape, false, DRIVE_ALIKE);                                                   \
        else if (WIDE >= WIDE_UNROLLED && march->chain)                                            \
            LANE_RK4(shape, false, DRIVE_OWN);                                                     \
        else                                                                                       \
            WITH(any_rk)(&WITH(shape##_forces), lanes, march);                                     \
    }                                                                                              \
    TARGET static void WITH(shape##_split)(struct lanes * lanes, const struct lane_march *march)   \
    {                                                                                              \
        const bool alike = !(LANE_FLAGS(shape) & TERM_TIME && march->drive == DRIVE_OWN);          \
        const bool drags = LANE_FLAGS(shape) & TERM_VELOCITY;                                      \
        const bool euler = march->chain && (!drags || lanes->drag == DRAG_EXPLICIT);               \
        if (WIDE < WIDE_UNROLLED || lanes->own || (!alike && !euler))                              \
            WITH(any_split)(&WITH(shape##_forces), lanes, march);                                  \
        else if (!alike)                                                                           \
            LANE_PARTED(shape, DRIVE_OWN, true, DRAG_EXPLICIT, SPLIT_PARTS);                       \
        else if (euler)                                                                            \
            LANE_PARTED(shape, DRIVE_ALIKE, true, DRAG_EXPLICIT, EULER_PARTS);                     \
        else                                                                                       \
            LANE_PARTED(shape, DRIVE_ALIKE, false, lanes->drag, SPLIT_PARTS);                      \
    }
LANE_SHAPES(LANE_KERNELS)

#define LANE_IRK(shape, by)                                                                        \
    TARGET static void WITH(shape##_irk)(struct lanes * lanes, const struct lane_march *march)     \
    {                                                                                              \
        static const struct WITH(implicit)                                                         \
            solver = {WITH(shape##_both_called), WITH(shape##_force_called), by,                   \
                      (LANE_FLAGS(shape) & TERM_KINK) != 0};                                       \
        WITH(any_irk)(&solver, lanes, march);                                                      \
    }
#define LANE_IRK_CLOSED(shape) LANE_IRK(shape, NULL)
#define LANE_IRK_MOTION(shape) LANE_IRK(shape, WITH(shape##_jacobian_called))
CLOSED_SHAPES(LANE_IRK_CLOSED)
MOTION_SHAPES(LANE_IRK_MOTION)

#define LANE_STEPS(shape)                                                                          \
    TARGET static void WITH(shape##_adaptive)(struct lanes * lanes,                                \
                                              const struct lane_march *march)                      \
    {                                                                                              \
        WITH(any_adaptive)(&WITH(shape##_forces), NULL, lanes, march);                             \
    }
LANE_SHAPES(LANE_STEPS)

#define LANE_ROSENBROCK(shape)                                                                     \
    TARGET static void WITH(shape##_rosenbrock)(struct lanes * lanes,                              \
                                                const struct lane_march *march)                    \
    {                                                                                              \
        WITH(any_adaptive)                                                                         \
        (&WITH(shape##_forces), WITH(shape##_jacobian_called), lanes, march);                      \
    }
AUTONOMOUS_SHAPES(LANE_ROSENBROCK)

#define LANE_ENTRY(shape)                                                                          \
    [LANE_##shape] = {WITH(shape##_rk), WITH(shape##_split), WITH(shape##_irk),                    \
                      WITH(shape##_adaptive)},
#define LANE_LAST_ENTRY(shape) [LANE_##shape] = WITH(shape##_rosenbrock),

static lane_kernel *const WITH(kernels)[LANE_SHAPE_COUNT][LANE_FAMILIES] = {
    LANE_SHAPES(LANE_ENTRY)};
static lane_kernel *const WITH(rosenbrocks)[LANE_SHAPE_COUNT] = {
    AUTONOMOUS_SHAPES(LANE_LAST_ENTRY)};

#undef vector
#undef PARTS
#undef FAST
#undef WIDE
#undef TARGET
#undef WITH
#undef LANE_TERM
#undef LANE_ALWAYS
#undef LANE_IF_FORCE
#undef LANE_IF_DRAG
#undef LANE_FORCE
#undef LANE_FORCES
#undef ANY_PARTS
#undef RK_PARTS
#undef SPLIT_PARTS
#undef EULER_PARTS
#undef LANE_DRIVE
#undef LANE_RK4
#undef LANE_PARTED
#undef LANE_KERNELS
#undef LANE_ENTRY
#undef LANE_STEPS
#undef LANE_ROSENBROCK
#undef LANE_LAST_ENTRY
#undef LANE_SLOPES
#undef LANE_JACOBIAN_TERM
#undef LANE_JACOBIAN
#undef LANE_IRK
#undef LANE_IRK_CLOSED
#undef LANE_IRK_MOTION
