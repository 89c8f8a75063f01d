/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What only programs need that hooke has written; no part of hooke. The number of variables is that
 * of `size`; derivatives() and jacobian() are the program's. */
#ifndef HOOKE_MODULES_PROGRAMS_OWN_H
#define HOOKE_MODULES_PROGRAMS_OWN_H

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* x^n by multiplications: n whole or half of that, |n| <= 16 */
static double power(double x, double n)
{
    const int whole = (int)fabs(n);
    int bit = 16;
    while (bit > whole)
        bit /= 2;
    double result = whole > 0 ? x : 1;
    while ((bit /= 2) > 0) {
        result *= result;
        if (whole & bit)
            result *= x;
    }
    if (fabs(n) > whole)
        result *= sqrt(x);
    return n < 0 ? 1 / result : result;
}

/* ---- linear scenes ---- */

#define BLOCK 32
static double propagate_row[BLOCK][2][3] = {{{0}}}; /* of j + 1 steps: by y, by v, what is added */
static long double propagate_last[2][3] = {{0}};    /* the last of them with all digits */

/* Powers of the matrix of one step, which is found by stepping unit vectors. */
static void propagate_prepare(double h, bool symplectic)
{
    double shift[2] = {0, 0}, column[2][2] = {{1, 0}, {0, 1}};
    long double m[2][2], taken[2][2] = {{1, 0}, {0, 1}}, sum[2] = {0, 0}, next[2][2], next_sum[2];
    step(0, h, shift);
    step(0, h, column[0]);
    step(0, h, column[1]);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
            m[i][j] = (long double)column[j][i] - (long double)shift[i];
    const long double determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    if (symplectic && fabsl(determinant - 1) < 1e-6L)
        for (int i = 0; i < 4; i++)
            m[i / 2][i % 2] *= 1 / sqrtl(determinant);
    for (int j = 0; j < BLOCK; j++) {
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < 2; k++)
                next[i][k] = m[i][0] * taken[0][k] + m[i][1] * taken[1][k];
            next_sum[i] = m[i][0] * sum[0] + m[i][1] * sum[1] + (long double)shift[i];
        }
        memcpy(taken, next, sizeof taken);
        memcpy(sum, next_sum, sizeof sum);
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < 2; k++) {
                propagate_last[i][k] = taken[i][k];
                propagate_row[j][i][k] = (double)taken[i][k];
            }
            propagate_last[i][2] = sum[i];
            propagate_row[j][i][2] = (double)sum[i];
        }
    }
}

/* The state after step i, from that where its block of steps began. */
static void propagate(long i, double state[2])
{
    static double y, v;
    if (i % BLOCK == 0) {
        y = state[0];
        v = state[1];
    }
    for (int k = 0; k < 2; k++) {
        const double *by = propagate_row[i % BLOCK][k];
        const long double *last = propagate_last[k];
        state[k] = i % BLOCK < BLOCK - 1 ? by[0] * y + by[1] * v + by[2]
                                         : (double)(last[0] * y + last[1] * v + last[2]);
    }
}

/* ---- forces that bend where the velocity turns ---- */

/* A time since the start of the step, velocity and acceleration there. */
struct moment {
    double x, v, a;
};

static struct moment moment_at(double t, double x, const double state[])
{
    return (struct moment){x, state[1], acceleration_at(t + x, state)};
}

/* Where v = 0 between two moments: cubic Hermite interpolation of the time as a function of v. */
static double turning_time(const struct moment *p, const struct moment *q)
{
    const double rise = q->v - p->v, u = -p->v / rise, r = 1 - u;
    const double x =
        p->x + (q->x - p->x) * (u * u * (3 - 2 * u)) + rise * u * r * (r / p->a - u / q->a);
    return (x - p->x) * (q->x - x) > 0 ? x : p->x + (q->x - p->x) / 2;
}

/* A step over h in pieces that meet where the velocity turns. */
static void turning_step(double t, double h, double state[])
{
    double rest = h;
    for (int pieces = 1;; pieces++) {
        const double before[2] = {state[0], state[1]};
        double x = rest;
        step(t, rest, state);
        bool turned = false;
        if (pieces < 8 && ((before[1] < 0 && state[1] > 0) || (before[1] > 0 && state[1] < 0))) {
            const double near = 1e-8 * fabs(rest);
            struct moment first = moment_at(t, 0, before), last = moment_at(t, rest, state);
            const double at = turning_time(&first, &last);
            turned = fabs(at) > near && fabs(rest - at) > near;
            x = turned ? at : rest;
            for (int i = 0; turned && i < 12; i++) {
                state[0] = before[0];
                state[1] = before[1];
                step(t, x, state);
                const struct moment here = moment_at(t, x, state);
                if (fabs(here.v) <= near * fabs(here.a))
                    break;
                *((here.v < 0) == (first.v < 0) ? &first : &last) = here;
                if (i < 11)
                    x = turning_time(&first, &last);
            }
        }
        rest -= x;
        t += x;
        if (!turned)
            return;
    }
}

/* ---- implicit steps ---- */

#define SIZE ((int)(sizeof(size) / sizeof(size[0])))
#define EPSILON 0x1p-52
#define STANDSTILL 1e-10 /* a relative increment this small that shrinks no more is rounding */

/* The factors of 1 - h J at s + z: a [SIZE + 1][SIZE]. False: there are none. */
static bool newton_factors(double t, double h, const double s[], const double z[], double a[])
{
    double at[SIZE], by[SIZE * SIZE];
    for (int i = 0; i < SIZE; i++)
        at[i] = s[i] + z[i];
    jacobian(t, at, by);
    for (int i = 0; i < SIZE * SIZE; i++)
        a[i] = (i % (SIZE + 1) == 0) - h * by[i];
    return lu_factor_size(SIZE, a);
}

/* What z is off by. */
static void newton_off(double t, double h, const double s[], const double z[], double rest[])
{
    double at[SIZE];
    for (int i = 0; i < SIZE; i++)
        at[i] = s[i] + z[i];
    derivatives(t, at, rest);
    for (int i = 0; i < SIZE; i++)
        rest[i] = h * rest[i] - z[i];
}

/* The largest of x, each by its weight; NaN if one is. */
static double newton_largest(const double weight[], const double x[])
{
    double largest = 0;
    for (int i = 0; i < SIZE; i++) {
        const double part = fabs(x[i]) * weight[i];
        if (!(part <= largest))
            largest = part;
        if (part != part)
            return part;
    }
    return largest;
}

static void newton_weigh(const double s[], double weight[])
{
    for (int i = 0; i < SIZE; i++)
        weight[i] = 1 / (fabs(s[i]) > size[i] ? fabs(s[i]) : size[i]);
}

/* Increments that are at most half as long as the one before: the solution beside z. */
static bool newton_contracts(double t, double h, const double s[], double z[],
                             const double weight[])
{
    double last = HUGE_VAL, a[SIZE * (SIZE + 1)], move[SIZE], now[SIZE];
    for (int iteration = 0; iteration < 30; iteration++) {
        if (!newton_factors(t, h, s, z, a) || lu_negative(SIZE, a))
            return false;
        newton_off(t, h, s, z, move);
        lu_solve_size(SIZE, a, move);
        for (int i = 0; i < SIZE; i++) {
            z[i] += move[i];
            now[i] = fmin(weight[i], 1 / fabs(s[i] + z[i]));
        }
        const double moved = newton_largest(now, move);
        if (!isfinite(moved) || (moved > 0.5 * last && moved > STANDSTILL))
            return false;
        if (moved <= EPSILON / 2 || (moved >= last && moved <= STANDSTILL))
            return true;
        last = moved;
    }
    return last <= STANDSTILL;
}

/* The solution that is reached from h = 0 in parts of h; z is unchanged where there is none. */
static bool newton_followed(double t, double h, const double s[], double z[], const double weight[])
{
    double at[SIZE], next[SIZE], done = 0, part = 0.25;
    memset(at, 0, sizeof at);
    for (int i = 0; i < 100 && done < 1 && part >= 1e-5; i++) {
        const double to = fmin(1, done + part);
        memcpy(next, at, sizeof at);
        if (newton_contracts(t, to * h, s, next, weight)) {
            memcpy(at, next, sizeof at);
            done = to;
            part *= 2;
        } else {
            part /= 4;
        }
    }
    if (done >= 1)
        memcpy(z, at, sizeof at);
    return done >= 1;
}

/* z = h f(t, s + z), until increments stop decreasing. */
static bool solve_stage(bool linear, double t, double h, const double s[], double z[])
{
    double last = HUGE_VAL, off = HUGE_VAL;
    double weight[SIZE], a[SIZE * (SIZE + 1)], rest[SIZE], move[SIZE];
    bool near = true, found = false;
    memset(move, 0, sizeof move);
    newton_weigh(s, weight);
    if (!newton_factors(t, h, s, z, a))
        return false;
    near = !lu_negative(SIZE, a);
    for (int iteration = 0, halvings = 0; iteration < 30 && !found;) {
        newton_off(t, h, s, z, rest);
        const double left = newton_largest(weight, rest);
        if (iteration == 0 && !isfinite(left))
            return false;
        if (!(left < off) && last > STANDSTILL) { /* no nearer: half of the last increment */
            near = false;
            if (++halvings > 8)
                break;
            for (int i = 0; i < SIZE; i++) {
                move[i] /= 2;
                z[i] -= move[i];
            }
            continue;
        }
        memcpy(move, rest, sizeof move);
        lu_solve_size(SIZE, a, move);
        for (int i = 0; i < SIZE; i++)
            z[i] += move[i];
        const double moved = newton_largest(weight, move);
        near = near && !(moved > 0.5 * last && moved > STANDSTILL);
        found = linear || moved <= EPSILON / 2 || (moved >= last && moved <= STANDSTILL);
        if (!found && moved > 0.1 * last && !newton_factors(t, h, s, z, a)) {
            last = HUGE_VAL;
            break;
        }
        last = moved;
        off = left;
        halvings = 0;
        iteration++;
    }
    if (linear || (found && near && !lu_negative(SIZE, a)))
        return found;
    return newton_followed(t, h, s, z, weight) || found || last <= STANDSTILL;
}

/* The inverse of 1 - h (h da/dy + da/dv) at s. */
static bool motion_inverse(double t, double h, const double s[], double *inverse, bool *positive)
{
    double by[4];
    jacobian(t, s, by);
    *inverse = 1 / (1 - h * (h * by[2] + by[3]));
    *positive = *inverse > 0;
    return *inverse != 0 && isfinite(*inverse);
}

/* The same for one coordinate: an equation in x = v' - v. *status: 1 found, 0 not, -1 no number. */
static void motion_iterate(double t, double h, const double s[], double weight, double *x,
                           bool *near, int *status)
{
    double inverse, last = HUGE_VAL, off = HUGE_VAL, move = 0, at[2] = {s[0], s[1]}, rate[2];
    bool positive;
    *status = 0;
    *near = false;
    if (!motion_inverse(t, h, at, &inverse, &positive))
        return;
    *near = positive;
    for (int iteration = 0, halvings = 0; iteration < 30;) {
        at[1] = s[1] + *x;
        at[0] = s[0] + h * at[1];
        derivatives(t, at, rate);
        const double rest = h * rate[1] - *x, left = fabs(rest) * weight;
        if (iteration == 0 && !isfinite(rest)) {
            *status = -1;
            return;
        }
        if (!(left < off) && last > STANDSTILL) { /* no nearer: half of the last increment */
            if (++halvings > 8)
                return;
            *near = false;
            move /= 2;
            *x -= move;
            continue;
        }
        move = rest * inverse;
        const double moved = fabs(move) * weight;
        *x += move;
        if (moved > 0.5 * last && moved > STANDSTILL)
            *near = false;
        if (moved <= EPSILON / 2 || (moved >= last && moved <= STANDSTILL) ||
            (iteration > 0 && moved * moved <= EPSILON / 32 * last)) {
            *near = *near && positive;
            *status = 1;
            return;
        }
        if (moved > 0.1 * last) {
            at[1] = s[1] + *x;
            at[0] = s[0] + h * at[1];
            if (!motion_inverse(t, h, at, &inverse, &positive))
                return;
        }
        last = moved;
        off = left;
        halvings = 0;
        iteration++;
    }
    *near = false;
    *status = last <= STANDSTILL;
}

static bool solve_motion(double t, double h, const double s[], double z[])
{
    double weight[SIZE], x = 0;
    bool near;
    int status;
    newton_weigh(s, weight);
    const double by_position = fabs(h) * weight[0];
    motion_iterate(t, h, s, weight[1] > by_position ? weight[1] : by_position, &x, &near, &status);
    z[1] = x;
    z[0] = h * (s[1] + x);
    if (status >= 0 && !(status == 1 && near) && newton_followed(t, h, s, z, weight))
        return true;
    return status == 1;
}

#endif
