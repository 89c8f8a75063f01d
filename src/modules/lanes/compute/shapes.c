/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps in lanes of the most common oscillators, by splittings and by the classical
 * Runge-Kutta method: forces are the texts of terms.def on vectors, so that stages stay in
 * registers. Other scenes use programs (fixed.c). The operations are those of rk_body.h,
 * split_body.h and turn.c in the same order, which gives the same bits. */
#define UNROLL _Pragma("GCC unroll 16")
#include "method/kernel/kernel.h"
#include "modules/lanes/compute/state.h"

#include <hooke/base/elementary.h>
#include <hooke/base/numeric.h>

#include <float.h>

/* Loads four numbers. */
INLINE four four_load(const double *x)
{
    return *(const four *)(const void *)x;
}

/* ---- forces ---- */

/* Functions of four numbers, for rows of terms.def that no shape uses. */
#define OF_EACH_LANE(name)                                                                         \
    UNUSED INLINE four four_##name(four x)                                                         \
    {                                                                                              \
        for (int lane = 0; lane < WIDE; lane++)                                                    \
            x[lane] = fixed_##name(x[lane]);                                                       \
        return x;                                                                                  \
    }
OF_EACH_LANE(sin)
OF_EACH_LANE(cos)

#define abs(x) four_magnitude(x)
#define sin(x) four_sin(x)
#define cos(x) four_cos(x)
#define FORCE(name, expression)                                                                    \
    UNUSED INLINE four name##_of_four(UNUSED four c0, UNUSED four c1, UNUSED four c2,              \
                                      UNUSED four t, UNUSED four q, UNUSED four v)                 \
    {                                                                                              \
        return (expression);                                                                       \
    }
#define SLOPES(...)
#define POTENTIAL(...)
#include FORCE_TERMS
#undef abs
#undef sin
#undef cos

/* Function that returns the sum of the terms whose flags under `mask` are `wanted`. c has the
 * coefficients [terms][TERM_COEFFICIENTS][LANE_COUNT] from the first lane on, `cosine` is that of
 * the drive. */
typedef four lane_force(unsigned mask, unsigned wanted, const double *c, four q, four v,
                        four cosine);

#define LANE_COEFFICIENT(i, j) four_load(c + ((i)*TERM_COEFFICIENTS + (j)) * LANE_COUNT)
#define LANE_TERM(i, name)                                                                         \
    if ((name##_flags & mask) == wanted && name##_flags & TERM_TIME)                               \
        a += LANE_COEFFICIENT(i, 0) * cosine;                                                      \
    else if ((name##_flags & mask) == wanted)                                                      \
        a += name##_of_four(LANE_COEFFICIENT(i, 0), LANE_COEFFICIENT(i, 1), (four){0}, (four){0},  \
                            q, v);
#define LANE_FORCE(shape)                                                                          \
    INLINE four shape##_in_lanes(unsigned mask, unsigned wanted, const double *c, UNUSED four q,   \
                                 UNUSED four v, UNUSED four cosine)                                \
    {                                                                                              \
        four a = -(four){0};                                                                       \
        TERMS_OF_##shape(LANE_TERM) return a;                                                      \
    }
#define LANE_SHAPES(S) SHAPES(S) LINEAR_SHAPES(S)
#define LANE_FLAG(i, name) | (name##_flags)
#define LANE_FLAGS(shape) (0 TERMS_OF_##shape(LANE_FLAG))
LANE_SHAPES(LANE_FORCE)

/* ---- the drive: its cosines are computed ahead for many steps ---- */

/* The drive is FORCE(drive, c0 * cos(c1 * t + c2)). Returns the angles of four lanes at time t. */
INLINE four drive_angle(const struct lane_drive *drive, int lane, four t)
{
    return four_load(drive->c1 + lane) * t + four_load(drive->c2 + lane);
}

/* Computes the drive's cosine at one stage of the coming steps; `place` is the index of the stage.
 * If all lanes have the same drive, stores one number in value[place]. If they have their own,
 * computes a row of numbers, to which value_rows[place] points. A stage at the same time as the one
 * before
 * (`again`) shares its row. */
CLONES static void store_drive_cosine(struct lane_drive *drive, int64_t place,
                                      struct lane_time stage_time)
{
    const size_t size = (stage_time.t ? LANE_COUNT : 1) * sizeof *stage_time.t;
    const double *const t = stage_time.t ? stage_time.t : &stage_time.all;
    double *row = drive->value + drive->rows * LANE_COUNT, angle[LANE_COUNT];
    four now = stage_time.all - (four){0};
    if (!drive->own) {
        drive->value[place] = fixed_cos(drive_angle(drive, 0, now)[0]);
        return;
    }
    const bool again = drive->rows > 0 && memcmp(t, drive->time, size) == 0;
    drive->value_rows[place] = again ? row - LANE_COUNT : row;
    if (again)
        return;
    memcpy(drive->time, t, size);
    for (int lane = 0; lane < LANE_COUNT; lane += WIDE) {
        if (stage_time.t)
            now = four_load(t + lane);
        *fours(angle + lane) = drive_angle(drive, lane, now);
    }
    fixed_cosines(LANE_COUNT, angle, row);
    drive->rows++;
}

/* Computes the drive at all stages of step lanes->step, which have the indices from `place` on. */
static void store_drive_of_step(struct lanes *lanes, int64_t place)
{
    const struct splitting *splitting = lanes->method->splitting;
    double time[LANE_COUNT];
    struct lane_time stage_time = lanes_time(lanes, 0, time);
    for (int i = 0; i < lanes->drive.places; i++, place++)
        if (!splitting)
            store_drive_cosine(&lanes->drive, place,
                               lanes_time(lanes, lanes->method->tableau->c[i], time));
        else if ((i % 2 == 0) == splitting->kick_first)
            store_drive_cosine(&lanes->drive, place, stage_time);
        else
            lanes_time_add(lanes, splitting_weight(splitting, i), &stage_time, time);
}

/* Computes the drive for the next steps. Returns their number, at most `count`. Values that are the
 * same in all lanes are kept for the next call, which often needs the same. */
static int64_t store_drive_ahead(struct lanes *lanes, int64_t count)
{
    struct lane_drive *const drive = &lanes->drive;
    const int64_t first = lanes->step;
    if (!drive->c1)
        return count;
    const int64_t max = (drive->own ? DRIVE_ROWS : DRIVE_VALUES) / drive->places;
    const struct driven_by driver = {drive->own ? NULL : lanes->method,
                                     {*drive->c1, *drive->c2, lanes->t0, lanes->h}};
    if (drive->own || memcmp(&driver, &drive->driver, sizeof driver) != 0 || first < drive->begin ||
        first > drive->end || first - drive->begin >= max) {
        drive->driver = driver;
        drive->begin = drive->end = first;
        drive->rows = 0;
    }
    const int64_t end = first + count < drive->begin + max ? first + count : drive->begin + max;
    for (; drive->end < end; drive->end++) {
        lanes->step = drive->end;
        store_drive_of_step(lanes, (drive->end - drive->begin) * drive->places);
    }
    lanes->step = first;
    drive->next = drive->value + (first - drive->begin) * drive->places;
    return end - first;
}

/* Compile-time knowledge of a kernel: no drive, one cosine for all lanes, or one for each. */
enum drive_known { DRIVE_NONE, DRIVE_ALIKE, DRIVE_OWN };

/* Returns the cosine of the drive at an index of the next steps. */
INLINE four cosine_at(enum drive_known known, const struct lane_drive *drive, int64_t place,
                      int lane)
{
    if (known == DRIVE_OWN)
        return four_load(drive->value_rows[place] + lane);
    return (known == DRIVE_ALIKE ? drive->next[place] : 0) - (four){0};
}

/* ---- the classical method ---- */

/* weights of the four stages in the sum, then of each of the first three in the next stage */
enum { RK_WEIGHTS = 7 };

/* Computes the weights of the classical method times h. */
INLINE void classical_weights(const struct tableau *tableau, four h, four w[RK_WEIGHTS])
{
    for (int s = 0; s < 4; s++)
        w[s] = h * tableau->b[s];
    for (int s = 1; s < 4; s++)
        w[3 + s] = h * tableau_row(tableau, s)[s - 1];
}

/* Makes a step of the classical method from y to z; w are weights times h, cosine is the drive at
 * each stage. */
INLINE void classical_step(lane_force *force, const double *c, const four w[RK_WEIGHTS],
                           const four cosine[4], const four y[2], four z[2])
{
    four sum[2] = {-(four){0}, -(four){0}};
    z[0] = y[0];
    z[1] = y[1];
    UNROLL for (int s = 0; s < 4; s++)
    {
        const four slope[2] = {z[1], force(0, 0, c, z[0], z[1], cosine[s])};
        for (int j = 0; j < 2; j++) {
            const four next = w[4 + s % 3] * slope[j];
            sum[j] += w[s] * slope[j];
            z[j] = y[j] + (s < 3 ? next : sum[j]);
        }
    }
}

/* Members of a point on the way to a turning point, as in turn.c. */
enum { TURN_TIME, TURN_SPEED, TURN_SLOPE, TURN_NUMBERS };

/* Returns the time at which the velocity passes zero between two points, by inverse cubic
 * interpolation, or the middle if that lies outside. */
INLINE four turning_time(const four *p, const four *q)
{
    const four begin = p[TURN_TIME], size = q[TURN_TIME] - begin,
               rise = q[TURN_SPEED] - p[TURN_SPEED], u = -p[TURN_SPEED] / rise, r = 1 - u;
    const four x = begin + size * (u * u * (3 - 2 * u)) +
                   rise * u * r * (r / p[TURN_SLOPE] - u / q[TURN_SLOPE]);
    return four_either((x - begin) * (q[TURN_TIME] - x) > 0, begin + size / 2, x);
}

/* Returns the lanes in which the number changes its sign. */
INLINE four_masks sign_changes(four first, four second)
{
    return ((first < 0) & (second > 0)) | ((first > 0) & (second < 0));
}

/* Returns the lanes in which a number is not finite. */
INLINE four_masks is_infinite(const four z[2])
{
    return ~((four_magnitude(z[0]) <= DBL_MAX) & (four_magnitude(z[1]) <= DBL_MAX));
}

/* Copies `count` vectors in the lanes of `which`. */
INLINE void fours_select(four_masks which, int count, const four *source, four *target)
{
    for (int j = 0; j < count; j++)
        target[j] = four_either(which, target[j], source[j]);
}

/* Repeats the step in the lanes of a vector whose velocity changes its sign between y and z, in
 * pieces that end at turning points, as method_turning_step() does. z becomes the state after the
 * step, NAN where it fails. `rest` is the length of the step. Returns the additional evaluations.
 */
INLINE four_masks turn_lanes(lane_force *force, const double *c, const struct tableau *tableau,
                             four rest, four y[2], four z[2])
{
    four t[2] = {z[0], z[1]}, w[RK_WEIGHTS];
    const four none[4] = {0};
    four_masks moving = sign_changes(y[1], z[1]), failed = {0}, evals = {0};
    for (int piece = 1;; piece++) {
        if (piece > 1) {
            classical_weights(tableau, rest, w);
            classical_step(force, c, w, none, y, t);
            evals += moving & 4;
        }
        failed |= moving & is_infinite(t);
        fours_select(moving, 2, t, z);
        moving &= ~failed & sign_changes(y[1], t[1]);
        if (piece == TURN_PIECES || four_none(moving))
            break;
        evals += moving & 2;
        /* Finds the turning point between the start and the end of the piece. */
        four first[TURN_NUMBERS] = {{0}, y[1], force(0, 0, c, y[0], y[1], rest)},
             last[TURN_NUMBERS] = {rest, t[1], force(0, 0, c, t[0], t[1], rest)};
        const four tolerance = TURN_NEAR * four_magnitude(rest);
        four x = turning_time(first, last), used = x;
        moving &= ~((four_magnitude(x) <= tolerance) | (four_magnitude(rest - x) <= tolerance));
        four_masks trying = moving;
        for (int i = 0; i < TURN_TRIES && !four_none(trying); i++) {
            classical_weights(tableau, x, w);
            classical_step(force, c, w, none, y, t);
            const four here[TURN_NUMBERS] = {x, t[1], force(0, 0, c, t[0], t[1], rest)};
            evals += trying & 4;
            failed |= trying & is_infinite(t);
            fours_select(trying, 2, t, z);
            fours_select(trying, 1, &x, &used);
            trying &= ~(four_magnitude(here[TURN_SPEED]) <=
                        tolerance * four_magnitude(here[TURN_SLOPE])) &
                      ~failed;
            const four_masks is_early = ~((here[TURN_SPEED] < 0) ^ (y[1] < 0));
            fours_select(trying & is_early, TURN_NUMBERS, here, first);
            fours_select(trying & ~is_early, TURN_NUMBERS, here, last);
            x = four_either(trying, x, turning_time(first, last));
        }
        moving &= ~failed;
        if (four_none(moving))
            break;
        rest -= used;
        fours_select(moving, 2, z, y);
    }
    t[0] = t[1] = NAN - (four){0};
    fours_select(failed, 2, t, z);
    return evals;
}

/* Makes `count` steps of the classical Runge-Kutta method, each of lanes->own_h [s], with a
 * compiled force. lanes->y holds the states before and after; row, unless NULL, receives the states
 * after each step, [count][2][LANE_COUNT]. `flags` are those of all terms. */
INLINE void march_classical(lane_force *force, enum drive_known drive, unsigned flags,
                            struct lanes *lanes, int64_t count, double *row)
{
    const struct tableau *tableau = lanes->method->tableau;
    /* the coefficients of the terms follow the time and the N state variables */
    const double *c = lanes->input + (1 + N) * LANE_COUNT;
    four w[LANE_COUNT][RK_WEIGHTS]; /* weights of every fourth lane */
    for (int lane = 0; lane < LANE_COUNT; lane += WIDE)
        classical_weights(tableau, four_load(lanes->own_h + lane), w[lane]);
    for (int64_t i = 0; i < count; i++, row += row ? 2 * LANE_COUNT : 0)
        for (int lane = 0; lane < LANE_COUNT; lane += WIDE) {
            four y[2] = {four_load(lanes->y + lane), four_load(lanes->y + LANE_COUNT + lane)}, z[2],
                 cosine[4];
            UNROLL for (int s = 0; s < 4; s++) cosine[s] =
                cosine_at(drive, &lanes->drive, 4 * i + s, lane);
            classical_step(force, c + lane, w[lane], cosine, y, z);
            /* Negative in lanes whose velocity has changed its sign, because the sign bits differ.
             * Forces with a kink there (TERM_KINK) need steps that end at the turning point. */
            const four_masks turned = (four_masks)y[1] ^ (four_masks)z[1];
            if (flags & TERM_KINK && lanes->turns &&
                (turned[0] | turned[1] | turned[2] | turned[3]) < 0) {
                const four_masks evals =
                    turn_lanes(force, c + lane, tableau, four_load(lanes->own_h + lane), y, z);
                for (int k = 0; k < WIDE; k++)
                    lanes->evals[lane + k] += evals[k];
            }
            for (int j = 0; j < 2; j++) {
                *fours(lanes->y + j * LANE_COUNT + lane) = z[j];
                if (row)
                    *fours(row + j * LANE_COUNT + lane) = z[j];
            }
        }
    memcpy(lanes->state, lanes->y, 2 * LANE_COUNT * sizeof *lanes->y);
}

/* ---- splittings ---- */

/* number of vectors that are stepped together, so that one is computed while others wait for
 * results */
enum { SPLIT_PARTS = 4 };

/* Loads numbers [count][LANE_COUNT] of SPLIT_PARTS vectors from one lane on. */
INLINE void parts_load(int count, const double *source, four *target)
{
    UNROLL for (int j = 0; j < count * SPLIT_PARTS; j++) target[j] =
        four_load(source + j / SPLIT_PARTS * LANE_COUNT + j % SPLIT_PARTS * WIDE);
}

/* Stores what parts_load() loads. */
INLINE void parts_store(int count, const four *source, double *target)
{
    UNROLL for (int j = 0; j < count * SPLIT_PARTS; j++) *
        fours(target + j / SPLIT_PARTS * LANE_COUNT + j % SPLIT_PARTS * WIDE) = source[j];
}

/* Applies the exact flow of the drag over half a step to the velocities, with the bits of
 * drag_flow_apply(), which has no pole forward in time: v keep / (min + pull |v|). `half` points to
 * the first of these lanes in the array keep, min, pull [3][LANE_COUNT]. */
INLINE void fours_drag_flow(const double *half, four v[SPLIT_PARTS])
{
    UNROLL for (int p = 0; p < SPLIT_PARTS; p++, half += WIDE) v[p] =
        v[p] * four_load(half) /
        (four_load(half + LANE_COUNT) + four_load(half + 2 * LANE_COUNT) * four_magnitude(v[p]));
}

/* Changes the velocities z[1] by the accelerations `pull` without drag over the times w [s], with
 * the bits of split_kick(). Drag acts as `variant` tells: exactly within the kick, by the array
 * `lost` [2][LANE_COUNT] of lost fraction and weight of the pull (unless it acts at the ends of the
 * step), explicitly by the force at positions z[0] and coefficients `c`, or not at all. The arrays
 * point to the first of these lanes. */
INLINE void fours_kick(enum drag variant, bool drag_at_ends, lane_force *force, const double *c,
                       const double *lost, const four w[SPLIT_PARTS], const four pull[SPLIT_PARTS],
                       four z[2][SPLIT_PARTS])
{
    UNROLL for (int p = 0; p < SPLIT_PARTS; p++, c += WIDE, lost += WIDE)
    {
        four *const v = &z[1][p];
        if (variant == DRAG_EXACT && !drag_at_ends)
            *v += pull[p] * four_load(lost + LANE_COUNT) - *v * four_load(lost);
        else if (variant == DRAG_EXPLICIT)
            *v += w[p] * (pull[p] + force(TERM_VELOCITY, TERM_VELOCITY, c, z[0][p], *v, w[p]));
        else
            *v += w[p] * pull[p];
    }
}

/* Makes `count` steps of a splitting with a compiled force, SPLIT_PARTS vectors of lanes at a time.
 * `drive` tells whether there is a drive and whether all lanes share it, `flags` which terms the
 * force has (TERM_VELOCITY means drag). row [count][2][LANE_COUNT] receives the states after the
 * steps unless it is NULL. */
INLINE void march_splitting(lane_force *force, enum drive_known drive, unsigned flags,
                            struct lanes *lanes, int64_t count, double *row)
{
    const struct split_way *way = &lanes->way;
    const enum drag variant = flags & TERM_VELOCITY ? way->drag : DRAG_DEFAULT;
    const bool drag_at_ends = variant == DRAG_EXACT && way->drag_at_ends,
               continues = way->continues;
    const int places = way->splitting->count;
    const double *c = lanes->input + (1 + N) * LANE_COUNT;
    for (int lane = 0; lane < LANE_COUNT; lane += SPLIT_PARTS * WIDE, c += SPLIT_PARTS * WIDE) {
        four z[2][SPLIT_PARTS], pull[SPLIT_PARTS], w[WEIGHTS_MAX][SPLIT_PARTS];
        bool known = continues && lanes->step > 0;
        for (int i = 0; i < places; i++)
            for (int p = 0; p < SPLIT_PARTS; p++)
                w[i][p] =
                    splitting_weight(way->splitting, i) * four_load(lanes->own_h + lane + p * WIDE);
        parts_load(2, lanes->state + lane, z[0]);
        parts_load(1, lanes->pull + lane, pull);
        for (int64_t i = 0; i < count; i++) {
            if (drag_at_ends)
                fours_drag_flow(lanes->half + lane, z[1]);
            for (int index = 0; index < places; index++) {
                if ((index % 2 == 0) != way->splitting->kick_first) {
                    UNROLL for (int p = 0; p < SPLIT_PARTS; p++) z[0][p] += w[index][p] * z[1][p];
                    continue;
                }
                if (!known)
                    UNROLL for (int p = 0; p < SPLIT_PARTS; p++) pull[p] =
                        force(TERM_VELOCITY, 0, c + p * WIDE, z[0][p], z[1][p],
                              cosine_at(drive, &lanes->drive, places * i + index, lane + p * WIDE));
                known = continues && index == places - 1;
                fours_kick(variant, drag_at_ends, force, c,
                           lanes->frozen + 2 * index * LANE_COUNT + lane, w[index], pull, z);
            }
            if (drag_at_ends)
                fours_drag_flow(lanes->half + lane, z[1]);
            if (row)
                parts_store(2, z[0], row + 2 * i * LANE_COUNT + lane);
        }
        parts_store(2, z[0], lanes->state + lane);
        parts_store(1, pull, lanes->pull + lane);
    }
}

/* ---- the kernels ---- */

typedef void march_lanes(struct lanes *lanes, int64_t count, double *row);

/* Defines the two kernels of a shape. AVX-512 adds nothing to vectors of four numbers. */
#define LANE_KERNEL(shape, name)                                                                   \
    CLONES_FOR("avx2") static void shape##name(struct lanes *lanes, int64_t count, double *row)    \
    {                                                                                              \
        const unsigned flags = LANE_FLAGS(shape);                                                  \
        if (!(flags & TERM_TIME))                                                                  \
            march##name(shape##_in_lanes, DRIVE_NONE, flags, lanes, count, row);                   \
        else if (lanes->drive.own)                                                                 \
            march##name(shape##_in_lanes, DRIVE_OWN, flags, lanes, count, row);                    \
        else                                                                                       \
            march##name(shape##_in_lanes, DRIVE_ALIKE, flags, lanes, count, row);                  \
    }
#define LANE_KERNELS(shape)                                                                        \
    LANE_KERNEL(shape, _classical)                                                                 \
    LANE_KERNEL(shape, _splitting)
LANE_SHAPES(LANE_KERNELS)

#define LANE_ENTRY(shape) [SHAPE_##shape] = {shape##_classical, shape##_splitting},
static march_lanes *const kernels[SHAPE_COUNT][2] = {LANE_SHAPES(LANE_ENTRY)};

/* Returns true for methods of four stages, each of which depends only on the one before. */
static bool is_classical(const struct lanes *lanes)
{
    const struct weights *w = lanes->weights;
    return lanes->method->tableau && lanes->method->tableau->stages == 4 && w[0].count == 4 &&
           w[1].count == 1 && w[2].count == 1 && w[2].stage[0] == 1 && w[3].count == 1 &&
           w[3].stage[0] == 2;
}

/* Makes `count` steps by the kernel for the system's shape (a common combination of forces, whose
 * kernel is compiled). Returns false, without a step, if there is none. */
bool lanes_march_shape(struct lanes *lanes, int64_t count, double *row)
{
    const struct system *system = lanes->system[0];
    const struct splitting *splitting = lanes->method->splitting;
    const int shape = splitting || is_classical(lanes) ? shape_of(system) : -1;
    march_lanes *const kernel = shape >= 0 ? kernels[shape][splitting != NULL] : NULL;
    struct lane_drive *const drive = &lanes->drive;
    if (!kernel)
        return false;
    /* Kernels read the cosines of a drive from memory; they are computed for as many steps as there
     * is room. */
    drive->own = lanes->own;
    drive->places = splitting ? splitting->count : 4;
    drive->c1 = NULL;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->flags & TERM_TIME) {
            drive->c1 = lanes->input + (1 + N + i * TERM_COEFFICIENTS + 1) * LANE_COUNT;
            drive->c2 = drive->c1 + LANE_COUNT;
        }
    for (int lane = 1; drive->c1 && lane < LANE_COUNT; lane++)
        drive->own |= drive->c1[lane] != drive->c1[0] || drive->c2[lane] != drive->c2[0];
    for (int64_t some; count > 0; count -= some) {
        some = store_drive_ahead(lanes, count);
        kernel(lanes, some, row);
        lanes->step += some;
        row = row ? row + some * 2 * LANE_COUNT : NULL;
    }
    return true;
}
