/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The steps of LANES trajectories at once, written for one width of vector: included once for each, with
 *
 *   WIDE         doubles in a vector
 *   TARGET       attributes of the functions: instructions that they may use
 *   WITH(name)   the name of something here
 *
 * The operations are those of rk_body.h and split_body.h, in their order, on every lane: the same bits.
 */
typedef double WITH(vector) __attribute__((vector_size(WIDE * 8), aligned(WIDE * 8)));
typedef int64_t WITH(bits) __attribute__((vector_size(WIDE * 8), aligned(WIDE * 8)));
#define vector WITH(vector)
#define PARTS (LANES / WIDE)
#define FAST static inline __attribute__((always_inline)) TARGET

/* ---- forces: what terms.def adds, once more. Its `double` is here what stands right of it, cos() is prepared ---- */

FAST vector WITH(magnitude)(vector x)
{
    return (vector)((WITH(bits))x & INT64_MAX);
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#ifdef __clang__
#pragma GCC diagnostic ignored "-Wkeyword-macro"
#pragma GCC diagnostic ignored "-Wgnu-auto-type"
#endif
#undef TERM_ADD
#undef TERM_BIND
#undef TERM_JACOBIAN
#undef TERM_POTENTIAL
#undef TERM_POWER
#define TERM_ADD(name)                                                                                                 \
    FAST void WITH(name##_add)(UNUSED const vector *c, UNUSED vector cosine, UNUSED const vector *y, vector *a)
/* Not wanted, but they stand in between. */
#define TERM_BIND(name)                                                                                                \
    static bool WITH(name##_bind)(UNUSED const scalar *param, UNUSED scalar *c, UNUSED struct oscillator *oscillator)
#define TERM_JACOBIAN(name)                                                                                            \
    static void WITH(name##_jacobian)(UNUSED const scalar *c, UNUSED const scalar *y, scalar *jac)
#define TERM_POTENTIAL(name) static scalar WITH(name##_potential)(const scalar *c, const scalar *y)
#define TERM_POWER(name)                                                                                               \
    static scalar WITH(name##_power)(const scalar *c, UNUSED scalar cosine, UNUSED const scalar *y)
#define double __auto_type
#define fabs(x) _Generic((x), vector: WITH(magnitude), default: scalar_magnitude)(x)
#define cos(x) (cosine)
#define TERM_BODIES
#include FORCE_TERMS
#undef TERM_BODIES
#undef double
#undef fabs
#undef cos
#pragma GCC diagnostic pop

/* What one part of the lanes knows of the forces. */
struct WITH(known) {
    vector c[SHAPE_TERMS][LANE_COEFFICIENTS];
    vector cosine;
};

typedef void WITH(force)(const struct WITH(known) *known, const vector *y, vector *a);

#define LANE_ALWAYS(i, name) WITH(name##_add)(known->c[i], known->cosine, y, a);
#define LANE_IF_FORCE(i, name)                                                                                         \
    if (!(name##_flags & TERM_VELOCITY))                                                                               \
        WITH(name##_add)(known->c[i], known->cosine, y, a);
#define LANE_IF_DRAG(i, name)                                                                                          \
    if (name##_flags & TERM_VELOCITY)                                                                                  \
        WITH(name##_add)(known->c[i], known->cosine, y, a);
#define LANE_FORCE(shape, which, TERM)                                                                                 \
    FAST void WITH(shape##which)(UNUSED const struct WITH(known) *known, UNUSED const vector *y, vector *a)            \
    {                                                                                                                  \
        *a = -(vector){0};                                                                                             \
        TERMS_OF_##shape(TERM)                                                                                         \
    }
#define LANE_FORCES(shape)                                                                                             \
    LANE_FORCE(shape, _both, LANE_ALWAYS)                                                                              \
    LANE_FORCE(shape, _force, LANE_IF_FORCE)                                                                           \
    LANE_FORCE(shape, _drag, LANE_IF_DRAG)
LANE_SHAPES(LANE_FORCES)

FAST vector WITH(load)(const double *from, int part)
{
    vector x;
    memcpy(&x, from + part * WIDE, sizeof x);
    return x;
}

FAST void WITH(take)(struct WITH(known) *known, const struct lanes *lanes)
{
    for (int i = 0; i < SHAPE_TERMS; i++)
        for (int j = 0; j < LANE_COEFFICIENTS; j++)
            UNROLL for (int q = 0; q < PARTS; q++)
                known[q].c[i][j] = WITH(load)(lanes->c[i][j], q);
}

/* The drive at the place-th time of step i: prepared for all lanes alike, or the cosine of each. */
FAST void WITH(look)(struct WITH(known) *known, bool timed, const struct lanes *lanes, const struct lane_march *march,
                     int64_t i, int place, double t)
{
    if (!timed)
        return;
    double own[LANES] __attribute__((aligned(64)));
    if (!march->cosine)
        lanes_cosine(lanes, t, own);
    UNROLL for (int q = 0; q < PARTS; q++)
        known[q].cosine =
            march->cosine ? march->cosine[i * march->places + place] - (vector){0} : WITH(load)(own, q);
}

/* ---- explicit Runge-Kutta ---- */

/* z = y + sum_j (h w_j) k_j */
FAST void WITH(combine)(double h, const double *w, int count, vector k[][2][PARTS], int component,
                        const vector *y, vector *z)
{
    vector sum[PARTS];
    UNROLL for (int q = 0; q < PARTS; q++)
        sum[q] = -(vector){0};
    for (int j = 0; j < count; j++)
        if (w[j] != 0) {
            const double share = h * w[j];
            UNROLL for (int q = 0; q < PARTS; q++)
                sum[q] += share * k[j][component][q];
        }
    UNROLL for (int q = 0; q < PARTS; q++)
        z[q] = y[q] + sum[q];
}

FAST void WITH(slope)(WITH(force) *force, const struct WITH(known) *known, vector z[2][PARTS], vector k[2][PARTS])
{
    UNROLL for (int q = 0; q < PARTS; q++)
    {
        const vector y[2] = {z[0][q], z[1][q]};
        k[0][q] = y[1];
        force(&known[q], y, &k[1][q]);
    }
}

FAST void WITH(rk)(const struct tableau *tableau, int stages, bool fsal, WITH(force) *force, bool timed,
                   struct lanes *lanes, const struct lane_march *march)
{
    const double h = lanes->h;
    vector y[2][PARTS], z[2][PARTS], k[STAGES_MAX][2][PARTS];
    struct WITH(known) known[PARTS];
    WITH(take)(known, lanes);
    memcpy(y, lanes->y, sizeof y);
    if (fsal && lanes->step > 0) {
        memcpy(k[stages - 1], lanes->kept, sizeof k[0]);
    } else if (fsal) {
        WITH(look)(known, timed, lanes, march, 0, 0, lanes->t0 + (double)march->first * h);
        WITH(slope)(force, known, y, k[stages - 1]);
    }
    for (int64_t i = 0; i < march->count; i++) {
        const double t = lanes->t0 + (double)(march->first + i) * h;
        if (fsal) {
            memcpy(k[0], k[stages - 1], sizeof k[0]);
        } else {
            WITH(look)(known, timed, lanes, march, i, 0, t);
            WITH(slope)(force, known, y, k[0]);
        }
        for (int s = 1; s < stages; s++)
        {
            WITH(combine)(h, tableau_row(tableau, s), s, k, 0, y[0], z[0]);
            WITH(combine)(h, tableau_row(tableau, s), s, k, 1, y[1], z[1]);
            WITH(look)(known, timed, lanes, march, i, s, t + tableau->c[s] * h);
            WITH(slope)(force, known, z, k[s]);
        }
        if (fsal) {
            memcpy(y, z, sizeof y);
        } else {
            WITH(combine)(h, tableau->b, stages, k, 0, y[0], y[0]);
            WITH(combine)(h, tableau->b, stages, k, 1, y[1], y[1]);
        }
        if (march->row)
            memcpy(march->row + i * 2 * LANES, y, sizeof y);
    }
    memcpy(lanes->y, y, sizeof y);
    if (fsal)
        memcpy(lanes->kept, k[stages - 1], sizeof k[0]);
}

/* ---- splittings ---- */

/* drag_flow_apply(), where it has no pole */
FAST void WITH(flow)(const struct lanes *lanes, vector *v)
{
    UNROLL for (int q = 0; q < PARTS; q++)
    {
        const vector pull = WITH(load)(lanes->pull, q) * WITH(magnitude)(v[q]);
        v[q] = v[q] * WITH(load)(lanes->keep, q);
        if (lanes->divides)
            v[q] = v[q] / (WITH(load)(lanes->least, q) + pull);
    }
}

FAST void WITH(kick)(const struct split_way *way, WITH(force) *drag, const struct WITH(known) *known,
                     const struct lanes *lanes, int place, double w, const vector *pull, vector z[2][PARTS])
{
    UNROLL for (int q = 0; q < PARTS; q++)
    {
        if (way->drag == DRAG_EXPLICIT) {
            const vector y[2] = {z[0][q], z[1][q]};
            vector a;
            drag(&known[q], y, &a);
            z[1][q] += w * (pull[q] + a);
        } else if (way->drag == DRAG_EXACT && !way->around) {
            z[1][q] += pull[q] * WITH(load)(lanes->frozen[place].pull, q) -
                       z[1][q] * WITH(load)(lanes->frozen[place].lost, q);
        } else {
            z[1][q] += w * pull[q];
        }
    }
}

FAST void WITH(split)(const struct method *method, int count, bool kick_first, enum drag variant, WITH(force) *force,
                      WITH(force) *drag, bool timed, struct lanes *lanes, const struct lane_march *march)
{
    const double h = lanes->h;
    struct split_way way;
    split_choose(&way, method, variant);
    const struct splitting *splitting = way.splitting;
    vector z[2][PARTS], pull[PARTS];
    struct WITH(known) known[PARTS];
    WITH(take)(known, lanes);
    memcpy(z, lanes->y, sizeof z);
    memcpy(pull, lanes->kept, sizeof pull);
    for (int64_t i = 0; i < march->count; i++) {
        double t = lanes->t0 + (double)(march->first + i) * h;
        if (way.around)
            WITH(flow)(lanes, z[1]);
        for (int place = 0; place < count; place++)
        {
            const double w = splitting_weight(splitting, place) * h;
            if ((place % 2 == 0) == kick_first) {
                if (!(place == 0 && way.continues && (lanes->step > 0 || i > 0))) {
                    WITH(look)(known, timed, lanes, march, i, place, t);
                    UNROLL for (int q = 0; q < PARTS; q++)
                    {
                        const vector y[2] = {z[0][q], z[1][q]};
                        force(&known[q], y, &pull[q]);
                    }
                }
                WITH(kick)(&way, drag, known, lanes, place, w, pull, z);
            } else {
                UNROLL for (int q = 0; q < PARTS; q++) z[0][q] += w * z[1][q];
                t += w;
            }
        }
        if (way.around)
            WITH(flow)(lanes, z[1]);
        if (march->row)
            memcpy(march->row + i * 2 * LANES, z, sizeof z);
    }
    memcpy(lanes->y, z, sizeof z);
    memcpy(lanes->kept, pull, sizeof pull);
}

/* ---- the kernels ---- */

/* The shortest splittings, where the compiler knows how they go; all others. */
#define LANE_SPLIT(shape, count, kick_first)                                                                           \
    WITH(split)(lanes->method, count, kick_first, LANE_FLAGS(shape) & TERM_VELOCITY ? lanes->drag : DRAG_DEFAULT,      \
                WITH(shape##_force), WITH(shape##_drag), LANE_FLAGS(shape) & TERM_TIME, lanes, march)
#define LANE_RK(shape, stages, fsal)                                                                                   \
    WITH(rk)(tableau, stages, fsal, WITH(shape##_both), LANE_FLAGS(shape) & TERM_TIME, lanes, march)
#define LANE_KERNELS(shape)                                                                                            \
    TARGET static void WITH(shape##_rk)(struct lanes * lanes, const struct lane_march *march)                          \
    {                                                                                                                  \
        const struct tableau *tableau = lanes->method->tableau;                                                        \
        if (tableau->stages == 4 && !tableau->fsal)                                                                    \
            LANE_RK(shape, 4, false);                                                                                  \
        else                                                                                                           \
            LANE_RK(shape, tableau->stages, tableau->fsal);                                                            \
    }                                                                                                                  \
    TARGET static void WITH(shape##_split)(struct lanes * lanes, const struct lane_march *march)                       \
    {                                                                                                                  \
        const struct splitting *splitting = lanes->method->splitting;                                                  \
        if (splitting->count == 2 && !splitting->kick_first)                                                           \
            LANE_SPLIT(shape, 2, false);                                                                               \
        else                                                                                                           \
            LANE_SPLIT(shape, splitting->count, splitting->kick_first);                                                \
    }
LANE_SHAPES(LANE_KERNELS)

#define LANE_ENTRY(shape) {WITH(shape##_rk), WITH(shape##_split)},

static lane_kernel *const WITH(kernels)[LANE_SHAPE_COUNT][2] = {LANE_SHAPES(LANE_ENTRY)};

#undef vector
#undef PARTS
#undef FAST
#undef WIDE
#undef TARGET
#undef WITH
#undef LANE_ALWAYS
#undef LANE_IF_FORCE
#undef LANE_IF_DRAG
#undef LANE_FORCE
#undef LANE_FORCES
#undef LANE_SPLIT
#undef LANE_RK
#undef LANE_KERNELS
#undef LANE_ENTRY
