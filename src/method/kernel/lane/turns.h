/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Steps across turning points (turn.c, whose operations these are in their order), many lanes at
 * once, for one width of vector: included by steps.h. Those that turn in a step are packed
 * into vectors and step to v = 0 side by side, each by its own shares of the step, until all are
 * there. For forces that do not depend on the time and methods whose four stages follow from the
 * one before.
 */
struct WITH(moment) {
    vector x, v, a;
};

FAST vector WITH(turning_time)(const struct WITH(moment) * p, const struct WITH(moment) * q)
{
    const vector rise = q->v - p->v, u = -p->v / rise, r = 1 - u;
    const vector x =
        p->x + (q->x - p->x) * (u * u * (3 - 2 * u)) + rise * u * r * (r / p->a - u / q->a);
    return WITH(either)((x - p->x) * (q->x - x) > 0, p->x + (q->x - p->x) / 2, x);
}

FAST WITH(bits) WITH(crosses)(vector before, vector after)
{
    return ((before < 0) & (after > 0)) | ((before > 0) & (after < 0));
}

/* A step of h, lane by lane; first: its first slope. */
FAST void WITH(chain_step)(int parts, WITH(force) * force, const struct WITH(known) * known,
                           const struct tableau *tableau, const vector *h, vector y[2][PARTS],
                           vector first[2][PARTS], vector z[2][PARTS])
{
    vector k[4][2][PARTS];
    UNROLL for (int q = 0; q < parts; q++) for (int i = 0; i < 2; i++) k[0][i][q] = first[i][q];
    UNROLL for (int s = 1; s < 4; s++)
    {
        const double w = tableau_row(tableau, s)[s - 1];
        for (int i = 0; i < 2; i++)
            UNROLL for (int q = 0; q < parts; q++) z[i][q] = y[i][q] + h[q] * w * k[s - 1][i][q];
        WITH(slope)(parts, force, known, z, k[s]);
    }
    const double *const b = tableau->b;
    for (int i = 0; i < 2; i++)
        UNROLL for (int q = 0; q < parts; q++)
        {
            vector sum = h[q] * b[0] * k[0][i][q];
            UNROLL for (int s = 1; s < 4; s++) sum += h[q] * b[s] * k[s][i][q];
            z[i][q] = y[i][q] + sum;
        }
}

/* What goes on in `parts` vectors of lanes. */
struct WITH(turning) {
    vector y[2][PARTS], first[2][PARTS]; /* where the piece begins, its first slope */
    vector z[2][PARTS];                  /* where it ends */
    vector rest[PARTS], x[PARTS];        /* of the step; up to the turning point */
    WITH(bits) moving[PARTS], failed[PARTS], evals[PARTS];
};

/* From y to the turning point before z: both are there then. */
FAST void WITH(approach)(int parts, WITH(force) * force, const struct WITH(known) * known,
                         const struct tableau *tableau, struct WITH(turning) * of,
                         struct WITH(moment) * p, struct WITH(moment) * last)
{
    vector t[2][PARTS], a[PARTS], used[PARTS], near[PARTS];
    WITH(bits) trying[PARTS];
    UNROLL for (int q = 0; q < parts; q++)
    {
        trying[q] = of->moving[q];
        near[q] = TURN_NEAR * WITH(magnitude)(of->rest[q]);
        used[q] = of->x[q];
    }
    for (int i = 0; i < TURN_TRIES && WITH(any_moves)(parts, trying); i++) {
        WITH(chain_step)(parts, force, known, tableau, of->x, of->y, of->first, t);
        force(parts, known, t, a);
        UNROLL for (int q = 0; q < parts; q++)
        {
            const struct WITH(moment) here = {of->x[q], t[1][q], a[q]};
            of->evals[q] += trying[q] & 4;
            of->failed[q] |= trying[q] & WITH(infinite)(t[0][q], t[1][q]);
            for (int j = 0; j < 2; j++)
                of->z[j][q] = WITH(either)(trying[q], of->z[j][q], t[j][q]);
            used[q] = WITH(either)(trying[q], used[q], of->x[q]);
            trying[q] &=
                ~(WITH(magnitude)(here.v) <= near[q] * WITH(magnitude)(here.a)) & ~of->failed[q];
            const WITH(bits) before = ~((here.v < 0) ^ (p[q].v < 0));
            p[q].x = WITH(either)(trying[q] & before, p[q].x, here.x);
            p[q].v = WITH(either)(trying[q] & before, p[q].v, here.v);
            p[q].a = WITH(either)(trying[q] & before, p[q].a, here.a);
            last[q].x = WITH(either)(trying[q] & ~before, last[q].x, here.x);
            last[q].v = WITH(either)(trying[q] & ~before, last[q].v, here.v);
            last[q].a = WITH(either)(trying[q] & ~before, last[q].a, here.a);
            of->x[q] = WITH(either)(trying[q], of->x[q], WITH(turning_time)(&p[q], &last[q]));
        }
    }
    UNROLL for (int q = 0; q < parts; q++)
    {
        of->moving[q] &= ~of->failed[q];
        of->rest[q] -= used[q];
        for (int j = 0; j < 2; j++)
            of->y[j][q] = of->z[j][q];
    }
}

/* of: y, first and z of the whole step, and who moves, are there; z becomes the states after it. */
FAST void WITH(turn)(int parts, WITH(force) * force, const struct WITH(known) * known,
                     const struct tableau *tableau, struct WITH(turning) * of)
{
    vector z[2][PARTS], a[PARTS];
    struct WITH(moment) p[PARTS], last[PARTS];
    for (int j = 0; j < 2; j++)
        UNROLL for (int q = 0; q < parts; q++) z[j][q] = of->z[j][q];
    for (int piece = 1;; piece++) {
        if (piece > 1) {
            WITH(slope)(parts, force, known, of->y, of->first);
            WITH(chain_step)(parts, force, known, tableau, of->rest, of->y, of->first, z);
        }
        force(parts, known, z, a);
        UNROLL for (int q = 0; q < parts; q++)
        {
            const WITH(bits) moves = of->moving[q];
            of->evals[q] += moves & (piece > 1 ? 4 : 0);
            of->failed[q] |= moves & WITH(infinite)(z[0][q], z[1][q]);
            for (int j = 0; j < 2; j++)
                of->z[j][q] = WITH(either)(moves, of->z[j][q], z[j][q]);
            const WITH(bits) crosses = moves & ~of->failed[q] &
                                       WITH(crosses)(of->y[1][q], z[1][q]) &
                                       -(int64_t)(piece < TURN_PIECES);
            const vector near = TURN_NEAR * WITH(magnitude)(of->rest[q]);
            of->evals[q] += crosses & 2;
            p[q] = (struct WITH(moment)){{0}, of->y[1][q], of->first[1][q]};
            last[q] = (struct WITH(moment)){of->rest[q], z[1][q], a[q]};
            of->x[q] = WITH(turning_time)(&p[q], &last[q]);
            of->moving[q] = crosses & ~((WITH(magnitude)(of->x[q]) <= near) |
                                        (WITH(magnitude)(of->rest[q] - of->x[q]) <= near));
        }
        if (!WITH(any_moves)(parts, of->moving))
            return;
        WITH(approach)(parts, force, known, tableau, of, p, last);
    }
}

/* The lanes in list [count], at most those of `parts` vectors; the last one fills them up. */
FAST void WITH(turn_some)(int parts, WITH(force) * force, struct lanes *lanes, int first,
                          const int *list, int count, struct lane_step *step)
{
    struct WITH(turning) of;
    struct WITH(known) known[PARTS];
    double y[2][LANES], slope[2][LANES], z[2][LANES], h[LANES],
        c[SHAPE_TERMS][LANE_COEFFICIENTS][LANES];
    for (int i = 0; i < parts * WIDE; i++) {
        const int lane = list[i < count ? i : count - 1];
        h[i] = lanes->own_h[first + lane];
        for (int j = 0; j < 2; j++) {
            y[j][i] = step->before[j][lane];
            slope[j][i] = step->first[j][lane];
            z[j][i] = step->after[j][lane];
        }
        for (int t = 0; t < SHAPE_TERMS; t++)
            for (int j = 0; j < LANE_COEFFICIENTS; j++)
                c[t][j][i] = lanes->c[t][j][first + lane];
    }
    UNROLL for (int q = 0; q < parts; q++)
    {
        for (int t = 0; t < SHAPE_TERMS; t++)
            for (int j = 0; j < LANE_COEFFICIENTS; j++)
                known[q].c[t][j] = WITH(load)(c[t][j], q);
        known[q].cosine = (vector){0};
        of.rest[q] = WITH(load)(h, q);
        of.moving[q] = ~(WITH(bits)){0};
        of.failed[q] = of.evals[q] = (WITH(bits)){0};
    }
    for (int j = 0; j < 2; j++) {
        WITH(begin)(parts, 0, y[j], of.y[j]);
        WITH(begin)(parts, 0, slope[j], of.first[j]);
        WITH(begin)(parts, 0, z[j], of.z[j]);
    }
    WITH(turn)(parts, force, known, lanes->method->tableau, &of);
    int64_t evals[LANES], failed[LANES];
    memcpy(evals, of.evals, (size_t)parts * sizeof of.evals[0]);
    memcpy(failed, of.failed, (size_t)parts * sizeof of.failed[0]);
    for (int j = 0; j < 2; j++)
        WITH(end)(parts, 0, of.z[j], z[j]);
    for (int i = 0; i < count; i++) {
        lanes->more[first + list[i]] += evals[i];
        for (int j = 0; j < 2; j++)
            step->after[j][list[i]] = failed[i] ? (double)NAN : z[j][i];
    }
}

/* Of `count` lanes from `first` on, those that turned. */
FAST void WITH(turn_packed)(WITH(force) * force, struct lanes *lanes, int first, int count,
                            struct lane_step *step)
{
    int list[LANES], turned = 0;
    for (int i = 0; i < count; i++) {
        list[turned] = i;
        turned += lane_turns(step->before[1][i], step->after[1][i]);
    }
    for (int i = 0; i < turned;) {
        const bool few = turned - i <= WIDE;
        const int most = (few ? 1 : 4) * WIDE, some = turned - i < most ? turned - i : most;
        if (few)
            WITH(turn_some)(1, force, lanes, first, list + i, some, step);
        else
            WITH(turn_some)(4, force, lanes, first, list + i, some, step);
        i += some;
    }
}
