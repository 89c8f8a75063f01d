/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Methods as one would write them for one scene, over REAL: a double, or a vector of two for motion
 * in a plane. The force, what drag does (its flow, its constants) and so the whole loop are known
 * to the compiler.
 */

#define NAME_(method, real) method##_##real
#define NAME__(method, real) NAME_(method, real)
#define NAME(method) NAME__(method, REAL)

typedef REAL NAME(force)(const struct known *f, double t, REAL y, REAL v);
typedef REAL NAME(flow)(const struct known *f, double h, REAL v);

#define LOOP_BEGIN                                                                                 \
    const struct known known = *given, *const f = &known;                                          \
    REAL y, v;                                                                                     \
    memcpy(&y, state, sizeof y);                                                                   \
    memcpy(&v, state + sizeof y / sizeof *state, sizeof v);
#define STEP_END                                                                                   \
    memcpy(row, &y, sizeof y);                                                                     \
    memcpy(row + sizeof y / sizeof *row, &v, sizeof v);                                            \
    row += 2 * sizeof y / sizeof *row;
#define LOOP_END                                                                                   \
    memcpy(state, &y, sizeof y);                                                                   \
    memcpy(state + sizeof y / sizeof *state, &v, sizeof v);
#define ARGUMENTS                                                                                  \
    NAME(force) * force, NAME(flow) * flow, bool damped, const struct known *given, double h,      \
        int64_t first, int64_t count, double *state, double *row

INLINE void NAME(euler)(ARGUMENTS)
{
    (void)flow, (void)damped;
    LOOP_BEGIN
    for (int64_t i = 0; i < count; i++) {
        const REAL a = force(f, (double)(first + i) * h, y, v);
        y += h * v;
        v += h * a;
        STEP_END
    }
    LOOP_END
}

INLINE void NAME(symplectic_euler)(ARGUMENTS)
{
    (void)flow, (void)damped;
    LOOP_BEGIN
    for (int64_t i = 0; i < count; i++) {
        y += h * v;
        v += h * force(f, (double)(first + i + 1) * h, y, v);
        STEP_END
    }
    LOOP_END
}

/* Kick, drift, kick; the drag's flow over h/2 at both ends. */
INLINE void NAME(verlet)(ARGUMENTS)
{
    (void)damped;
    struct known with = *given;
    with.fade = exp(-with.gamma * h / 2); /* may set errno: no compiler takes it out of the loop */
    given = &with;
    LOOP_BEGIN
    const REAL rest = {0};
    REAL a = force(f, (double)first * h, y, rest);
    for (int64_t i = 0; i < count; i++) {
        v = flow(f, h / 2, v) + h / 2 * a;
        y += h * v;
        a = force(f, (double)(first + i + 1) * h, y, rest);
        v = flow(f, h / 2, v + h / 2 * a);
        STEP_END
    }
    LOOP_END
}

/* Omelyan, Mryglod, Folk 2002; linear damping exactly within each kick. */
INLINE void NAME(pefrl)(ARGUMENTS)
{
    (void)flow;
    LOOP_BEGIN
    const double xi = 0.178617895844809067, lambda = -0.212341831062605404,
                 chi = -0.0662645826698184962;
    const double outer = (1 - 2 * lambda) / 2 * h, inner = lambda * h,
                 middle = (1 - 2 * (chi + xi)) * h;
    const double keep_outer = exp(-f->gamma * outer), keep_inner = exp(-f->gamma * inner);
    const double pull_outer = damped ? (1 - keep_outer) / f->gamma : outer;
    const double pull_inner = damped ? (1 - keep_inner) / f->gamma : inner;
    const REAL rest = {0};
#define KICK(part, at)                                                                             \
    v = (damped ? keep_##part * v : v) + pull_##part * force(f, t + (at)*h, y, rest)
    for (int64_t i = 0; i < count; i++) {
        const double t = (double)(first + i) * h;
        y += xi * h * v;
        KICK(outer, xi);
        y += chi * h * v;
        KICK(inner, xi + chi);
        y += middle * v;
        KICK(inner, 1 - xi - chi);
        y += chi * h * v;
        KICK(outer, 1 - xi);
        y += xi * h * v;
        STEP_END
    }
#undef KICK
    LOOP_END
}

INLINE void NAME(rk4)(ARGUMENTS)
{
    (void)flow, (void)damped;
    LOOP_BEGIN
    for (int64_t i = 0; i < count; i++) {
        const double t = (double)(first + i) * h, half = h / 2;
        const REAL y1 = v, v1 = force(f, t, y, v);
        const REAL y2 = v + half * v1, v2 = force(f, t + half, y + half * y1, y2);
        const REAL y3 = v + half * v2, v3 = force(f, t + half, y + half * y2, y3);
        const REAL y4 = v + h * v3, v4 = force(f, t + h, y + h * y3, y4);
        y += h / 6 * (y1 + 2 * y2 + 2 * y3 + y4);
        v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
        STEP_END
    }
    LOOP_END
}

/* Dormand, Prince 1980: six stages, the seventh is the next step's first. */
INLINE void NAME(dopri5)(ARGUMENTS)
{
    (void)flow, (void)damped;
    LOOP_BEGIN
    REAL y1 = v, v1 = force(f, (double)first * h, y, v);
    for (int64_t i = 0; i < count; i++) {
        const double t = (double)(first + i) * h;
        const REAL y2 = v + h * (1. / 5 * v1), v2 = force(f, t + h / 5, y + h * (1. / 5 * y1), y2);
        const REAL y3 = v + h * (3. / 40 * v1 + 9. / 40 * v2),
                   v3 = force(f, t + 3. / 10 * h, y + h * (3. / 40 * y1 + 9. / 40 * y2), y3);
        const REAL y4 = v + h * (44. / 45 * v1 - 56. / 15 * v2 + 32. / 9 * v3),
                   v4 = force(f, t + 4. / 5 * h,
                              y + h * (44. / 45 * y1 - 56. / 15 * y2 + 32. / 9 * y3), y4);
        const REAL y5 = v + h * (19372. / 6561 * v1 - 25360. / 2187 * v2 + 64448. / 6561 * v3 -
                                 212. / 729 * v4),
                   v5 = force(f, t + 8. / 9 * h,
                              y + h * (19372. / 6561 * y1 - 25360. / 2187 * y2 +
                                       64448. / 6561 * y3 - 212. / 729 * y4),
                              y5);
        const REAL y6 = v + h * (9017. / 3168 * v1 - 355. / 33 * v2 + 46732. / 5247 * v3 +
                                 49. / 176 * v4 - 5103. / 18656 * v5),
                   v6 = force(f, t + h,
                              y + h * (9017. / 3168 * y1 - 355. / 33 * y2 + 46732. / 5247 * y3 +
                                       49. / 176 * y4 - 5103. / 18656 * y5),
                              y6);
        y += h * (35. / 384 * y1 + 500. / 1113 * y3 + 125. / 192 * y4 - 2187. / 6784 * y5 +
                  11. / 84 * y6);
        v += h * (35. / 384 * v1 + 500. / 1113 * v3 + 125. / 192 * v4 - 2187. / 6784 * v5 +
                  11. / 84 * v6);
        y1 = v;
        v1 = force(f, t + h, y, v);
        STEP_END
    }
    LOOP_END
}

#undef NAME_
#undef NAME__
#undef NAME
