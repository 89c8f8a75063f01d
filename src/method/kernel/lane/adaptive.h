/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Steps whose size follows the error, each lane by its own control, for one width of vector:
 * included by steps.h. The operations are those of rk_body.h, rk_error.h and adapt_body.h in their
 * order. All lanes attempt a step at once; who was rejected tries again from where it was while the
 * others go on. First and last steps, those across turning points and whatever yields no number are
 * taken alone (march.c).
 */

/* factor_log2() */
FAST vector WITH(log2)(vector x)
{
    const double shift = 0x1.8p52;
    const vector magic = shift - (vector){0};
    const WITH(bits) near_half = (WITH(bits))x - 0x3fe6a09e667f3bcd, whole = near_half >> 52;
    const vector m = (vector)((WITH(bits))x - (whole << 52));
    const vector s = (m - 1) / (m + 1), u = s * s;
    const vector series = (0.961796693925976 + u * 0.577078016355585) +
                          u * u * (0.412198583111132 + u * 0.320598897975325);
    return ((vector)(whole + (WITH(bits))magic) - shift) + s * (2.885390081777927 + u * series);
}

/* factor_exp2() */
FAST vector WITH(exp2)(vector x)
{
    const vector above = WITH(either)(x < -1000, x, -1000 - (vector){0}),
                 within = WITH(either)(above > 1000, above, 1000 - (vector){0});
    const double shift = 0x1.8p52;
    const vector near = within + shift, f = within - (near - shift), g = f * f;
    const vector power = (vector)(((WITH(bits))near << 52) + 0x3ff0000000000000);
    const vector low =
        (1 + f * 0.693147180559945) + g * (0.240226506959101 + f * 0.0555041086648216);
    const vector high = (0.00961812910762848 + f * 0.00133335581464284) +
                        g * (0.000154035303933816 + f * 1.52527338040598e-5) +
                        g * g * 1.32154867901443e-6;
    return power * (low + g * g * high);
}

/* factor_atan() */
FAST vector WITH(atan)(vector x)
{
    const vector size = WITH(either)(x < 0, x, -x), z = WITH(either)(size > 1, x, 1 / x), u = z * z;
    const vector angle =
        z * (0.9998660 + u * (-0.3302995 + u * (0.1801410 + u * (-0.0851330 + u * 0.0208351))));
    const vector quarter = 1.5707963267948966 - (vector){0};
    return WITH(either)(size <= 1, WITH(either)(x < 0, quarter, -quarter) - angle, angle);
}

/* factor_limited() */
FAST vector WITH(limited)(vector x)
{
    const vector u = x * x;
    const vector low =
        (1 + 0.6931488410800936 * x) + u * (0.240226502974211 - 0.0555933829372098 * x);
    const vector high = (-0.1058275956503550 - 0.0320318947604718 * x) +
                        u * (0.0284870670868496 + 0.0239926464967005 * x);
    const WITH(bits) within = (x >= -0.5) & (x <= 0.5);
    const vector near = low + u * u * high;
    if (WITH(none)(~within))
        return near;
    return WITH(either)(within, 1 + WITH(atan)(WITH(exp2)(x) - 1), near);
}

/* follow(): what errors are relative to */
FAST void WITH(follow)(struct lane_control *control, int part, const vector y[2], vector scale[2])
{
    const vector t = WITH(load)(control->t, part),
                 by = WITH(magnitude)(t - WITH(load)(control->sampled, part)),
                 elapsed = WITH(load)(control->elapsed, part) + by, rate = 1 / elapsed;
    memcpy(control->sampled + part * WIDE, &t, sizeof t);
    memcpy(control->elapsed + part * WIDE, &elapsed, sizeof t);
    for (int i = 0; i < 2; i++) {
        const vector min = WITH(load)(control->min[i], part), size = WITH(magnitude)(y[i]),
                     given = WITH(load)(control->given[i], part);
        vector excess = WITH(load)(control->excess[i], part), mean = 1 - (vector){0};
        const WITH(bits) larger = size > min;
        if (!WITH(none)(larger))
            excess = WITH(either)(larger, excess,
                                  excess + by * (WITH(root)(WITH(root)(size / min)) - 1));
        mean = WITH(either)(excess > 0, mean, mean + excess * rate);
        mean *= mean;
        mean *= mean;
        const vector sized = min * mean;
        scale[i] = WITH(either)(sized < DBL_MAX, min, sized);
        scale[i] = WITH(either)(given > 0, scale[i], given);
        memcpy(control->excess[i] + part * WIDE, &excess, sizeof excess);
    }
}

/* h sum_j (w_j - u_j) k_j */
FAST vector WITH(difference)(vector h, const double *w, const double *u, int count,
                             vector (*k)[2][PARTS], int component, int q)
{
    vector sum = -(vector){0};
    for (int j = 0; j < count; j++)
        if (w[j] != u[j])
            sum += (w[j] - u[j]) * k[j][component][q];
    return h * sum;
}

FAST vector WITH(scaled_square)(const vector scale[2], const vector x[2], const vector y[2],
                                const vector z[2])
{
    vector sum[2];
    for (int i = 0; i < 2; i++) {
        const vector size = WITH(larger)(WITH(magnitude)(y[i]), WITH(magnitude)(z[i]));
        const vector ratio = x[i] / WITH(larger)(size, scale[i]);
        sum[i] = 0 + ratio * ratio;
    }
    return sum[0] + sum[1];
}

/* rk_estimate() */
FAST vector WITH(estimate)(const struct tableau *tableau, vector h, vector (*k)[2][PARTS], int q,
                           const vector scale[2], const vector y[2], const vector z[2])
{
    vector error[2], rough[2];
    for (int i = 0; i < 2; i++)
        error[i] = WITH(difference)(h, tableau->b, tableau->b_hat, tableau->stages, k, i, q);
    const vector square = WITH(scaled_square)(scale, error, y, z);
    if (!tableau->rough)
        return square;
    for (int i = 0; i < 2; i++)
        rough[i] = WITH(difference)(h, tableau->b, tableau->rough, tableau->stages, k, i, q);
    const vector part = square / (square + 0.01 * WITH(scaled_square)(scale, rough, y, z));
    return square * WITH(either)(square > 0, (vector){0}, part);
}

FAST WITH(bits) WITH(load_bits)(const int64_t *from, int part)
{
    WITH(bits) x;
    memcpy(&x, from + part * WIDE, sizeof x);
    return x;
}

FAST void WITH(store_bits)(WITH(bits) x, int part, int64_t *to)
{
    memcpy(to + part * WIDE, &x, sizeof x);
}

/* Where `when`, the number becomes this. */
FAST void WITH(change)(WITH(bits) when, vector value, int part, double *number)
{
    const vector now = WITH(either)(when, WITH(load)(number, part), value);
    memcpy(number + part * WIDE, &now, sizeof now);
}

/* plan_next(), plan_again(); error: in units of the aim, at least MIN_ERROR; squared */
FAST vector WITH(next_step)(const struct lane_control *control, int part, vector h, vector error,
                            WITH(bits) good)
{
    const vector one = 1 - (vector){0}, log = WITH(log2)(error),
                 ratio = WITH(magnitude)(h / WITH(load)(control->last, part));
    const WITH(bits) changes =
        (error < KEEP_MIN * KEEP_MIN) | (error > KEEP_MAX * KEEP_MAX) | (ratio < FALLS);
    vector rho = one;
    if (!WITH(none)(changes)) {
        const vector history =
            WITH(log2)(WITH(load)(control->previous, part)) * control->by_previous -
            WITH(log2)(ratio) * control->by_ratio;
        rho = WITH(either)(changes, one, WITH(limited)(log * control->by_error + history));
    }
    rho = WITH(either)(WITH(load_bits)(control->rejected, part) & ~(rho < 1), rho, one);
    if (WITH(none)(~good))
        return h * rho;
    const vector factor = WITH(exp2)(log * control->elementary);
    return WITH(either)(good, h * WITH(larger)(factor, SHRINK - (vector){0}), h * rho);
}

/* What the control makes of an attempt in one vector of lanes; who goes on. Marks in `alone` those
 * that are left as they were. */
FAST WITH(bits) WITH(judge)(struct lane_control *control, int part, bool turns, const vector y[2],
                            const vector z[2], vector estimate, WITH(bits) evals)
{
    const vector t = WITH(load)(control->t, part), h = WITH(load)(control->h, part);
    const WITH(bits) running = WITH(load_bits)(control->running, part);
    const vector square = estimate * WITH(load)(control->accepted, part),
                 error = WITH(larger)(square * control->aims, MIN_ERROR * MIN_ERROR - (vector){0});
    const WITH(bits) good = square <= 1;
    const vector next = WITH(next_step)(control, part, h, error, good);
    WITH(bits)
    alone = WITH(infinite)(z[0], z[1]) | WITH(infinite)(square, next) |
            (WITH(load)(control->previous, part) == 0) |
            (WITH(magnitude)(h) * STRETCH >= WITH(magnitude)(control->t_end - t)) |
            ~(next > LANE_SHORT * WITH(magnitude)(t) + LANE_SHORTEST);
    if (turns)
        alone |= WITH(crosses)(y[1], z[1]);
    const WITH(bits) moves = running & ~alone, goes = moves & good;
    /* advance_clock() */
    const vector by = h + WITH(load)(control->t_low, part), sum = t + by, gone = sum - t,
                 low = (t - (sum - gone)) + (by - gone);
    const WITH(bits) failed =
        goes & ((WITH(magnitude)(z[0]) > LANE_FAR) | (WITH(magnitude)(z[1]) > LANE_FAR) |
                (next < control->creep * WITH(magnitude)(sum - control->t0)));
    WITH(change)(goes, sum, part, control->t);
    WITH(change)(goes, low, part, control->t_low);
    WITH(change)(goes, h, part, control->last);
    WITH(change)(goes, error, part, control->previous);
    WITH(change)(moves, next, part, control->h);
    WITH(store_bits)
    (WITH(load_bits)(control->evals, part) + (moves & evals), part, control->evals);
    WITH(store_bits)(WITH(load_bits)(control->steps, part) - goes, part, control->steps);
    WITH(store_bits)
    ((WITH(load_bits)(control->rejected, part) | (moves & ~good)) & ~goes, part, control->rejected);
    WITH(store_bits)(WITH(load_bits)(control->failed, part) | failed, part, control->failed);
    WITH(store_bits)(running & ~failed, part, control->running);
    WITH(store_bits)(running & alone, part, control->alone);
    return goes;
}

/* An attempt of the lanes from vector `from` on. */
FAST void WITH(attempt)(int parts, int from, const struct WITH(forces) * of, struct lanes *lanes,
                        struct WITH(known) * known)
{
    const struct tableau *const tableau = lanes->method->tableau;
    struct lane_control *const control = &lanes->control;
    const int stages = tableau->stages;
    const bool timed = of->flags & TERM_TIME, turns = of->flags & TERM_KINK && lanes->turns;
    vector y[2][PARTS], z[2][PARTS], k[STAGES_MAX][2][PARTS], h[PARTS], t[PARTS];
    WITH(begin)(parts, from, control->h, h);
    WITH(begin)(parts, from, control->t, t);
    for (int i = 0; i < 2; i++) {
        WITH(begin)(parts, from, lanes->y[i], y[i]);
        WITH(begin)(parts, from, lanes->carried[i], k[0][i]);
    }
    for (int s = 1; s < stages; s++) {
        const double *const w = tableau_row(tableau, s);
        vector sum[2][PARTS];
        for (int i = 0; i < 2; i++)
            UNROLL for (int q = 0; q < parts; q++) sum[i][q] = -(vector){0};
        for (int j = 0; j < s; j++) {
            if (w[j] == 0)
                continue;
            UNROLL for (int q = 0; q < parts; q++)
            {
                const vector hw = h[q] * w[j];
                sum[0][q] += hw * k[j][0][q];
                sum[1][q] += hw * k[j][1][q];
            }
        }
        for (int i = 0; i < 2; i++)
            UNROLL for (int q = 0; q < parts; q++) z[i][q] = y[i][q] + sum[i][q];
        for (int q = 0; q < parts && timed && tableau->c[s] != tableau->c[s - 1]; q++)
            known[q].cosine =
                WITH(cosine)(WITH(load)(lanes->omega, from + q) * (t[q] + tableau->c[s] * h[q]) +
                             WITH(load)(lanes->phase, from + q));
        WITH(slope)(parts, of->both, known, z, k[s]);
    }
    for (int q = 0; q < parts; q++) {
        const vector start[2] = {y[0][q], y[1][q]}, end[2] = {z[0][q], z[1][q]};
        vector scale[2];
        WITH(follow)(control, from + q, start, scale);
        const vector square = WITH(estimate)(tableau, h[q], k, q, scale, start, end);
        const WITH(bits) goes =
            WITH(judge)(control, from + q, turns, start, end, square, stages - 1 + (WITH(bits)){0});
        for (int i = 0; i < 2; i++) {
            WITH(change)(goes, end[i], from + q, lanes->y[i]);
            WITH(change)(goes, k[stages - 1][i][q], from + q, lanes->carried[i]);
        }
    }
}

/* few_inverse() of two unknowns, whose Jacobian's first row is (0, 1), for 1/(gamma h); marks who
 * is too large or too small for it. */
FAST WITH(bits)
    WITH(inverse)(vector diagonal, vector by_position, vector by_velocity, vector column[2][2])
{
    const vector a = diagonal - 0, d = diagonal - by_velocity, det = a * d - 1 * by_position,
                 size = WITH(magnitude)(det), over = 1 / det;
    column[0][0] = d * over;
    column[0][1] = by_position * over;
    column[1][0] = 1 * over;
    column[1][1] = a * over;
    return ~((size > 1e-290) & (size < 1e290));
}

/* sum_j w_j u_j */
FAST vector WITH(weighted)(const double *w, int count, vector (*u)[2][PARTS], int component, int q)
{
    vector sum = -(vector){0};
    for (int j = 0; j < count; j++)
        if (w[j] != 0)
            sum += w[j] * u[j][component][q];
    return sum;
}

/* The same of a Rosenbrock method (rosenbrock_small_step()), where nothing depends on the time. */
FAST void WITH(rosenbrock_attempt)(int parts, int from, const struct WITH(forces) * of,
                                   WITH(slopes) * slopes, struct lanes *lanes,
                                   struct WITH(known) * known)
{
    const struct rosenbrock *const method = lanes->method->rosenbrock;
    struct lane_control *const control = &lanes->control;
    const int stages = method->stages;
    const bool turns = of->flags & TERM_KINK && lanes->turns;
    vector y[2][PARTS], z[2][PARTS], f[2][PARTS], u[ROSENBROCK_STAGES][2][PARTS], h[PARTS];
    vector jacobian[2][PARTS], column[PARTS][2][2];
    WITH(bits) beyond[PARTS];
    int64_t evals = 0;
    WITH(begin)(parts, from, control->h, h);
    for (int i = 0; i < 2; i++)
        WITH(begin)(parts, from, lanes->y[i], y[i]);
    slopes(parts, known, y, jacobian);
    WITH(slope)(parts, of->both, known, y, f);
    for (int q = 0; q < parts; q++)
        beyond[q] =
            WITH(inverse)(1 / (method->gamma * h[q]), jacobian[0][q], jacobian[1][q], column[q]);
    for (int s = 0; s < stages; s++) {
        const double *const a = method->a + s * (s - 1) / 2, *const c = method->c + s * (s - 1) / 2;
        if (s > 0 && !rosenbrock_same_point(method, a, s)) {
            for (int i = 0; i < 2; i++)
                UNROLL for (int q = 0; q < parts; q++)
                {
                    z[i][q] = y[i][q] + WITH(weighted)(a, s - 1, u, i, q);
                    if (a[s - 1] != 0)
                        z[i][q] += a[s - 1] * u[s - 1][i][q];
                }
            WITH(slope)(parts, of->both, known, z, f);
            evals++;
        }
        UNROLL for (int q = 0; q < parts; q++)
        {
            vector right[2];
            for (int i = 0; i < 2; i++)
                right[i] = f[i][q] + WITH(weighted)(c, s, u, i, q) * (1 / h[q]);
            for (int i = 0; i < 2; i++)
                u[s][i][q] = -(vector){0} + right[0] * column[q][0][i] + right[1] * column[q][1][i];
        }
    }
    for (int q = 0; q < parts; q++) {
        const vector start[2] = {y[0][q], y[1][q]};
        vector scale[2], error[2], end[2];
        for (int i = 0; i < 2; i++) {
            error[i] = -(vector){0};
            for (int s = 0; s < stages; s++)
                if (method->m[s] != method->b_hat[s])
                    error[i] += (method->m[s] - method->b_hat[s]) * u[s][i][q];
            end[i] = start[i] + WITH(weighted)(method->m, stages, u, i, q);
        }
        WITH(follow)(control, from + q, start, scale);
        vector square = WITH(scaled_square)(scale, error, start, end);
        square = WITH(either)(beyond[q], square, NAN - (vector){0});
        /* at a second attempt the slope and the Jacobian at y are known */
        const WITH(bits) known_first = WITH(load_bits)(control->rejected, from + q);
        const WITH(bits) goes =
            WITH(judge)(control, from + q, turns, start, end, square, evals + 1 + known_first);
        for (int i = 0; i < 2; i++)
            WITH(change)(goes, end[i], from + q, lanes->y[i]);
    }
}

FAST bool WITH(any_marked)(int parts, int from, const int64_t *marks)
{
    WITH(bits) any = {0};
    UNROLL for (int q = 0; q < parts; q++) any |= WITH(load_bits)(marks, from + q);
    return !WITH(none)(any);
}

/* march->count attempts; row [count][t, y, v][LANES] after them */
TARGET static __attribute__((noinline)) void WITH(any_adaptive)(const struct WITH(forces) * of,
                                                                WITH(slopes) * slopes,
                                                                struct lanes *lanes,
                                                                const struct lane_march *march)
{
    enum { SIZE = ANY_PARTS * WIDE };
    struct WITH(known) known[PARTS];
    for (int from = 0; from < PARTS; from += ANY_PARTS) {
        const int lane = from * WIDE;
        WITH(take)(known, ANY_PARTS, from, lanes);
        for (int64_t i = 0; i < march->count; i++) {
            const bool runs = WITH(any_marked)(ANY_PARTS, from, lanes->control.running);
            if (!runs && !march->row)
                break;
            if (runs && slopes)
                WITH(rosenbrock_attempt)(ANY_PARTS, from, of, slopes, lanes, known);
            else if (runs)
                WITH(attempt)(ANY_PARTS, from, of, lanes, known);
            if (runs && WITH(any_marked)(ANY_PARTS, from, lanes->control.alone))
                lanes_attempt_alone(lanes, lane, SIZE);
            if (!march->row)
                continue;
            double *const row = march->row + 3 * i * LANES + lane;
            memcpy(row, lanes->control.t + lane, SIZE * sizeof *row);
            memcpy(row + LANES, lanes->y[0] + lane, SIZE * sizeof *row);
            memcpy(row + 2 * LANES, lanes->y[1] + lane, SIZE * sizeof *row);
        }
    }
}
