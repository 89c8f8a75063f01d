/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Implicit Runge-Kutta methods whose stages are solved one by one, for one width of vector:
 * included by steps.h. The operations are those of irk_body.h, oscillator_stage() and
 * motion_stage() in their order. Lanes iterate until all are there; one whose iteration does not go
 * straight to the solution beside the guess takes the whole step again, alone.
 */
FAST vector WITH(root)(vector x)
{
    double each[WIDE];
    memcpy(each, &x, sizeof each);
    for (int i = 0; i < WIDE; i++)
        each[i] = sqrt(each[i]);
    memcpy(&x, each, sizeof each);
    return x;
}

FAST vector WITH(cosine)(vector x)
{
    WITH(bits) doubt = {0};
    const vector value = WITH(circle)(x, 1, &doubt);
    return WITH(none)(doubt) ? value : WITH(one_by_one)(x, false);
}

FAST WITH(bits) WITH(infinite)(vector a, vector b)
{
    return ~((WITH(magnitude)(a) <= DBL_MAX) & (WITH(magnitude)(b) <= DBL_MAX));
}

FAST bool WITH(any_moves)(int parts, const WITH(bits) * moving)
{
    WITH(bits) any = {0};
    UNROLL for (int q = 0; q < parts; q++) any |= moving[q];
    return !WITH(none)(any);
}

/* ---- derivatives of the forces by position and velocity ---- */

#define LANE_SLOPES(name, by_position, by_velocity)                                                \
    FAST void WITH(name##_slopes)(UNUSED const vector *c, UNUSED const vector *y,                  \
                                  UNUSED vector *p, UNUSED vector *v)                              \
    {                                                                                              \
        by_position;                                                                               \
        by_velocity;                                                                               \
    }
LANE_SLOPES(spring, *p -= c[0], )
LANE_SLOPES(damping, , *v -= c[0])
LANE_SLOPES(drag, , *v -= 2 * c[0] * WITH(magnitude)(y[1]))
LANE_SLOPES(drive, , )
LANE_SLOPES(cubic, *p -= 3 * c[0] * y[0] * y[0], )
LANE_SLOPES(vanderpol, *p -= 2 * c[0] * (y[0] * c[1]) * c[1] * y[1],
            *v += c[0] * (1 - y[0] * c[1] * (y[0] * c[1])))
LANE_SLOPES(weight, *p -= c[0] * WITH(cosine)(y[0]), )

typedef void WITH(slopes)(int parts, const struct WITH(known) * known, vector y[2][PARTS],
                          vector jacobian[2][PARTS]);

#define LANE_JACOBIAN_TERM(i, name)                                                                \
    WITH(name##_slopes)(known[q].c[i], y, &jacobian[0][q], &jacobian[1][q]);
#define LANE_JACOBIAN(shape)                                                                       \
    FAST void WITH(shape##_jacobian)(int parts, UNUSED const struct WITH(known) * known,           \
                                     vector z[2][PARTS], vector jacobian[2][PARTS])                \
    {                                                                                              \
        UNROLL for (int q = 0; q < parts; q++)                                                     \
        {                                                                                          \
            UNUSED const vector y[2] = {z[0][q], z[1][q]};                                         \
            jacobian[0][q] = jacobian[1][q] = (vector){0};                                         \
            TERMS_OF_##shape(LANE_JACOBIAN_TERM)                                                   \
        }                                                                                          \
    }                                                                                              \
    TARGET static void WITH(shape##_jacobian_called)(int parts, const struct WITH(known) * known,  \
                                                     vector z[2][PARTS],                           \
                                                     vector jacobian[2][PARTS])                    \
    {                                                                                              \
        (void)parts;                                                                               \
        WITH(shape##_jacobian)(ANY_PARTS, known, z, jacobian);                                     \
    }
AUTONOMOUS_SHAPES(LANE_JACOBIAN)
LANE_JACOBIAN(driven_duffing)
LANE_JACOBIAN(driven_pendulum)

/* ---- one stage ---- */

/* A stage over h from y at its time: the increments and the new state; lanes whose step is to be
 * taken alone, evaluations. */
struct WITH(stage) {
    vector y[2][PARTS], z[2][PARTS], sum[2][PARTS];
    WITH(bits) alone[PARTS], evals[PARTS];
};

/* oscillator_stage() */
FAST void WITH(solve_closed)(bool dragged, int parts, int from, WITH(force) * force,
                             const struct WITH(known) * known, const struct lanes *lanes,
                             const vector *step, struct WITH(stage) * of)
{
    vector pull[PARTS];
    force(parts, known, of->y, pull);
    UNROLL for (int q = 0; q < parts; q++)
    {
        const vector damping = WITH(load)(lanes->damping, from + q),
                     stiffness = WITH(load)(lanes->stiffness, from + q),
                     quadratic = WITH(load)(lanes->quadratic, from + q), h = step[q];
        const vector a = 1 + damping * h + stiffness * h * h, inverse = 1 / a,
                     r = of->y[1][q] + h * pull[q], u = r * inverse;
        vector v = u, drag = -(vector){0}, lost = -(vector){0};
        if (dragged) {
            const vector bend = 4 * (quadratic * h * inverse) * inverse;
            v = 2 * u / (1 + WITH(root)(1 + bend * WITH(magnitude)(r)));
            drag = quadratic * h * WITH(magnitude)(v);
            lost = drag * v;
        }
        const vector restoring = h * (stiffness * h + damping) * v;
        const WITH(bits) small = WITH(magnitude)(a - 1 + drag) < 1;
        of->z[0][q] = h * v;
        of->z[1][q] = WITH(either)(small, v - of->y[1][q], (h * pull[q] - restoring) - lost);
        of->sum[0][q] = of->y[0][q] + of->z[0][q];
        of->sum[1][q] = WITH(either)(small, v, of->y[1][q] + of->z[1][q]);
        of->alone[q] |= WITH(infinite)(a, r) | WITH(infinite)(v, v);
        of->evals[q] += 1;
    }
}

/* motion_factor(): lanes that have no next iterate are added to `none`. */
FAST void WITH(factor)(int parts, WITH(slopes) * slopes, const struct WITH(known) * known,
                       const vector *h, vector at[2][PARTS], vector *inverse, WITH(bits) * none)
{
    vector jacobian[2][PARTS];
    slopes(parts, known, at, jacobian);
    UNROLL for (int q = 0; q < parts; q++)
    {
        inverse[q] = 1 / (1 - h[q] * (h[q] * jacobian[0][q] + jacobian[1][q]));
        none[q] |= (inverse[q] == 0) | WITH(infinite)(inverse[q], inverse[q]);
    }
}

FAST vector WITH(larger)(vector a, vector b)
{
    return WITH(either)(a > b, b, a);
}

/* motion_stage(), where newton_follow() is not needed */
FAST void WITH(solve_motion)(int parts, int from, WITH(force) * both, WITH(slopes) * slopes,
                             const struct WITH(known) * known, const struct lanes *lanes,
                             const vector *h, struct WITH(stage) * of)
{
    vector x[PARTS], weight[PARTS], inverse[PARTS], last[PARTS], off[PARTS], a[PARTS];
    vector sum[2][PARTS];
    WITH(bits) active[PARTS], again[PARTS];
    UNROLL for (int q = 0; q < parts; q++)
    {
        vector each[2];
        for (int i = 0; i < 2; i++)
            each[i] = 1 / WITH(larger)(WITH(magnitude)(of->y[i][q]),
                                       WITH(load)(lanes->scale[i], from + q));
        weight[q] = WITH(larger)(each[1], h[q] * each[0]);
        x[q] = (vector){0};
        last[q] = off[q] = HUGE_VAL - (vector){0};
    }
    WITH(factor)(parts, slopes, known, h, of->y, inverse, of->alone);
    UNROLL for (int q = 0; q < parts; q++)
    {
        of->alone[q] |= ~(inverse[q] > 0);
        active[q] = ~of->alone[q];
    }
    for (int iteration = 0; iteration < ITERATIONS && WITH(any_moves)(parts, active); iteration++) {
        UNROLL for (int q = 0; q < parts; q++)
        {
            sum[1][q] = of->y[1][q] + x[q];
            sum[0][q] = of->y[0][q] + h[q] * sum[1][q];
        }
        both(parts, known, sum, a);
        UNROLL for (int q = 0; q < parts; q++)
        {
            const vector rest = h[q] * a[q] - x[q], rest_size = WITH(magnitude)(rest) * weight[q];
            const vector move = rest * inverse[q], size = WITH(magnitude)(move) * weight[q];
            of->evals[q] += active[q] & 1;
            of->alone[q] |= active[q] & (~(rest_size < off[q]) & (last[q] > STANDSTILL));
            if (iteration == 0)
                of->alone[q] |= active[q] & WITH(infinite)(rest, rest);
            x[q] = WITH(either)(active[q], x[q], x[q] + move);
            of->alone[q] |= active[q] & (size > CONTRACTS * last[q]) & (size > STANDSTILL);
            WITH(bits)
            done = (size <= DBL_EPSILON / 2) | ((size >= last[q]) & (size <= STANDSTILL));
            if (iteration > 0)
                done |= size * size <= LOST * last[q];
            of->alone[q] |= active[q] & done & ~(inverse[q] > 0);
            active[q] &= ~done & ~of->alone[q];
            again[q] = active[q] & (size > SLOW * last[q]);
            last[q] = size;
            off[q] = rest_size;
        }
        if (WITH(any_moves)(parts, again)) {
            vector next[PARTS];
            WITH(bits) none[PARTS];
            UNROLL for (int q = 0; q < parts; q++)
            {
                sum[1][q] = of->y[1][q] + x[q];
                sum[0][q] = of->y[0][q] + h[q] * sum[1][q];
                none[q] = (WITH(bits)){0};
            }
            WITH(factor)(parts, slopes, known, h, sum, next, none);
            UNROLL for (int q = 0; q < parts; q++)
            {
                inverse[q] = WITH(either)(again[q], inverse[q], next[q]);
                of->alone[q] |= again[q] & none[q];
                active[q] &= ~of->alone[q];
            }
        }
    }
    UNROLL for (int q = 0; q < parts; q++)
    {
        of->alone[q] |= active[q];
        of->z[1][q] = x[q];
        of->z[0][q] = h[q] * (of->y[1][q] + x[q]);
        for (int i = 0; i < 2; i++)
            of->sum[i][q] = of->y[i][q] + of->z[i][q];
    }
}

/* ---- steps ---- */

/* What a shape has for stages; slopes: NULL, where they are solved in closed form. */
struct WITH(implicit) {
    WITH(force) * both, *force;
    WITH(slopes) * slopes;
    bool dragged;
};

/* y + h sum_j w_j k_j */
FAST void WITH(stage_base)(int parts, const double *w, int count, const vector *h,
                           vector (*k)[2][PARTS], vector y[2][PARTS], vector base[2][PARTS])
{
    for (int i = 0; i < 2; i++)
        UNROLL for (int q = 0; q < parts; q++)
        {
            vector sum = -(vector){0};
            for (int j = 0; j < count; j++)
                if (w[j] != 0)
                    sum += w[j] * k[j][i][q];
            base[i][q] = y[i][q] + h[q] * sum;
        }
}

/* Those that are to be taken alone. */
FAST void WITH(take_alone)(int parts, int from, struct lanes *lanes, const struct lane_march *march,
                           int64_t number, vector y[2][PARTS], vector first[2][PARTS],
                           vector z[2][PARTS], vector last[2][PARTS], struct WITH(stage) * of)
{
    struct lane_step step;
    int64_t alone[LANES], evals[LANES];
    for (int j = 0; j < 2; j++) {
        WITH(end)(parts, 0, y[j], step.before[j]);
        WITH(end)(parts, 0, z[j], step.after[j]);
        WITH(end)(parts, 0, first[j], step.first[j]);
        WITH(end)(parts, 0, last[j], step.last[j]);
    }
    memcpy(alone, of->alone, (size_t)parts * sizeof *of->alone);
    memcpy(evals, of->evals, (size_t)parts * sizeof *of->evals);
    lanes_alone(lanes, from * WIDE, parts * WIDE, march->first + number, alone, evals, &step);
    memcpy(of->evals, evals, (size_t)parts * sizeof *of->evals);
    for (int j = 0; j < 2; j++) {
        WITH(begin)(parts, 0, step.after[j], z[j]);
        WITH(begin)(parts, 0, step.last[j], last[j]);
    }
}

/* one: there is one stage. */
FAST void WITH(irk)(bool one, int parts, int from, const struct WITH(implicit) * solver,
                    enum drive_known drive, struct lanes *lanes, const struct lane_march *march)
{
    const struct implicit_tableau *const tableau = lanes->method->implicit;
    const int stages = one ? 1 : tableau->stages;
    const bool fsal = !one && tableau->fsal, accurate = march->accurate;
    const double twice = tableau->b[0] / tableau->diagonal;
    vector y[2][PARTS], k[IMPLICIT_STAGES][2][PARTS], before[2][PARTS], h[PARTS], solved[PARTS];
    WITH(bits) evals[PARTS];
    struct WITH(stage) of;
    struct WITH(known) known[PARTS];
    WITH(take)(known, parts, from, lanes);
    WITH(begin)(parts, from, lanes->own_h, h);
    UNROLL for (int q = 0; q < parts; q++) solved[q] = tableau->diagonal * h[q];
    memcpy(evals, lanes->more + from * WIDE, (size_t)parts * sizeof *evals);
    for (int i = 0; i < 2; i++) {
        WITH(begin)(parts, from, lanes->y[i], y[i]);
        WITH(begin)(parts, from, lanes->carried[i], k[stages - 1][i]);
    }
    for (int64_t i = 0; i < march->count; i++) {
        const bool warm = lanes->step > 0 || i > 0;
        UNROLL for (int q = 0; q < parts; q++)
        {
            of.alone[q] = of.evals[q] = (WITH(bits)){0};
            for (int j = 0; j < 2; j++)
                before[j][q] = k[stages - 1][j][q];
        }
        for (int s = 0; s < stages; s++) {
            const double *const row = tableau->a + s * stages;
            if (row[s] == 0 && fsal && warm) {
                memcpy(k[s], before, sizeof before);
                continue;
            }
            WITH(look)(known, parts, from, drive, march, i, s);
            if (row[s] == 0) {
                WITH(slope)(parts, solver->both, known, y, k[s]);
                UNROLL for (int q = 0; q < parts; q++) of.evals[q] += 1;
                continue;
            }
            if (s > 0)
                WITH(stage_base)(parts, row, s, h, k, y, of.y);
            for (int j = 0; j < 2 && s == 0; j++)
                UNROLL for (int q = 0; q < parts; q++) of.y[j][q] = y[j][q];
            if (solver->slopes)
                WITH(solve_motion)
            (parts, from, solver->both, solver->slopes, known, lanes, solved, &of);
            else WITH(solve_closed)(solver->dragged, parts, from, solver->force, known, lanes,
                                    solved, &of);
            for (int j = 0; j < 2 && !one; j++)
                UNROLL for (int q = 0; q < parts; q++) k[s][j][q] = of.z[j][q] / solved[q];
        }
        if (!accurate && one) {
            for (int j = 0; j < 2; j++)
                UNROLL for (int q = 0; q < parts; q++) of.sum[j][q] = y[j][q] + twice * of.z[j][q];
        } else if (!accurate) {
            WITH(stage_base)(parts, tableau->b, stages, h, k, y, of.sum);
        }
        if (WITH(any_moves)(parts, of.alone))
            WITH(take_alone)
        (parts, from, lanes, march, i, y, before, of.sum, k[stages - 1], &of);
        for (int j = 0; j < 2; j++) {
            UNROLL for (int q = 0; q < parts; q++) y[j][q] = of.sum[j][q];
            if (march->row)
                WITH(end)(parts, from, y[j], march->row + (2 * i + j) * LANES);
        }
        UNROLL for (int q = 0; q < parts; q++) evals[q] += of.evals[q];
    }
    memcpy(lanes->more + from * WIDE, evals, (size_t)parts * sizeof *evals);
    for (int i = 0; i < 2; i++) {
        WITH(end)(parts, from, y[i], lanes->y[i]);
        if (fsal)
            WITH(end)(parts, from, k[stages - 1][i], lanes->carried[i]);
    }
}
