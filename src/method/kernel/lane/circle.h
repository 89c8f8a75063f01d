/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Sine and cosine of vectors, for one width of them: included by steps.h. The operations of
 * fixed_sines() and fixed_cosines() in their order, but the two polynomials are one, whose
 * coefficients each lane chooses: the same bits with half of the products. Where all of pi's digits
 * are needed, lanes go one by one.
 */
FAST vector WITH(either)(WITH(bits) second, vector a, vector b)
{
    return (vector)(((WITH(bits))a & ~second) | ((WITH(bits))b & second));
}

/* Is it so nowhere? */
FAST bool WITH(none)(WITH(bits) so)
{
    int64_t each[WIDE], any = 0;
    memcpy(each, &so, sizeof each);
    for (int i = 0; i < WIDE; i++)
        any |= each[i];
    return any == 0;
}

/* sin(r + low), cos(r + low), the latter where odd. */
FAST vector WITH(sine_of)(vector r, vector low)
{
#define GIVE(sine, cosine) (sine)
    const vector s = r * r, q = s * s, sum = CIRCLE_SERIES(GIVE, s, q);
#undef GIVE
    return r + (r * s * sum + low * (1 - s * (0.5 - s * (1. / 24))));
}

FAST vector WITH(cosine_of)(vector r, vector low)
{
#define GIVE(sine, cosine) (cosine)
    const vector s = r * r, q = s * s, half = s * 0.5, most = 1 - half,
                 sum = CIRCLE_SERIES(GIVE, s, q);
#undef GIVE
    return most + (q * sum + (((1 - most) - half) - low * (r - r * s * (1. / 6))));
}

FAST vector WITH(either_of)(WITH(bits) odd, vector r, vector low)
{
#define GIVE(sine, cosine) WITH(either)(odd, (sine) - (vector){0}, (cosine) - (vector){0})
    const vector s = r * r, q = s * s, rs = r * s, half = s * 0.5, most = 1 - half,
                 sum = CIRCLE_SERIES(GIVE, s, q);
#undef GIVE
    const vector slope = low * WITH(either)(odd, 1 - s * (0.5 - s * (1. / 24)), r - rs * (1. / 6));
    const vector rest =
        WITH(either)(odd, rs, q) * sum + WITH(either)(odd, slope, ((1 - most) - half) - slope);
    return WITH(either)(odd, r, most) + rest;
}

/* |x| = n pi/2 + r + low */
FAST vector WITH(reduce)(vector size, vector n, vector *low)
{
    const vector near = size - n * HALF_PI_1, step = n * HALF_PI_2, r = near - step;
    *low = ((near - r) - step) - n * HALF_PI_3;
    return r;
}

/* sin(|x| + quarters pi/2); what is not to be used is marked in *doubt. */
FAST vector WITH(circle)(vector x, int64_t quarters, WITH(bits) * doubt)
{
    const vector size = WITH(magnitude)(x), turned = size * TWO_OVER_PI + WHOLE, n = turned - WHOLE;
    vector low;
    const vector r = WITH(reduce)(size, n, &low);
    *doubt |= ~((size <= CIRCLE_FAR) & (WITH(magnitude)(r) >= n * CIRCLE_CLOSE));
    const WITH(bits) quarter = (WITH(bits))turned + quarters, odd = -(quarter & 1);
    return (vector)((WITH(bits))WITH(either_of)(odd, r, low) ^ (quarter & 2) << 62);
}

TARGET static __attribute__((noinline, cold)) vector WITH(one_by_one)(vector x, bool sine)
{
    double each[WIDE];
    memcpy(each, &x, sizeof each);
    for (int i = 0; i < WIDE; i++)
        each[i] = sine ? fixed_sin(each[i]) : fixed_cos(each[i]);
    memcpy(&x, each, sizeof each);
    return x;
}

FAST vector WITH(sine)(vector x)
{
    WITH(bits) doubt = {0};
    const vector value = WITH(circle)(x, 0, &doubt);
    return WITH(none)(doubt) ? (vector)((WITH(bits))value ^ ((WITH(bits))x & INT64_MIN))
                             : WITH(one_by_one)(x, true);
}

#define GROUP_PARTS (LANE_GROUP / WIDE)

/* Those of a group, all of whose angles are that many quarters, and what is left of them; false:
 * all of pi's digits are needed. */
FAST bool WITH(cosines_of_quarter)(const vector *x, double n, uint64_t quarter, double *cosine)
{
    WITH(bits) doubt = {0};
    vector value[GROUP_PARTS], r[GROUP_PARTS], low[GROUP_PARTS];
    UNROLL for (int q = 0; q < GROUP_PARTS; q++)
    {
        r[q] = WITH(reduce)(x[q], n - (vector){0}, &low[q]);
        doubt |= ~(WITH(magnitude)(r[q]) >= n * CIRCLE_CLOSE);
    }
    if (quarter & 1)
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) value[q] = WITH(cosine_of)(r[q], low[q]);
    else
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) value[q] = WITH(sine_of)(r[q], low[q]);
    if (quarter & 2)
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) value[q] = -value[q];
    if (WITH(none)(doubt))
        UNROLL for (int q = 0; q < GROUP_PARTS; q++)
            memcpy(cosine + q * WIDE, &value[q], sizeof value[q]);
    return WITH(none)(doubt);
}

/* Those of any angles of a group. */
FAST void WITH(any_cosines)(const vector *x, double *cosine)
{
    WITH(bits) doubt = {0};
    vector value[GROUP_PARTS];
    UNROLL for (int q = 0; q < GROUP_PARTS; q++) value[q] = WITH(circle)(x[q], 1, &doubt);
    for (int q = 0; q < GROUP_PARTS && !WITH(none)(doubt); q++)
        value[q] = WITH(one_by_one)(x[q], false);
    UNROLL for (int q = 0; q < GROUP_PARTS; q++)
        memcpy(cosine + q * WIDE, &value[q], sizeof value[q]);
}

/* cosine [LANES]: of the drives at t. Where the angles of a group, which lie between those of its
 * least and its largest numbers, are of one quarter, there is one polynomial and nothing to choose.
 */
TARGET static void WITH(drives)(const struct lanes *lanes, double t, double *cosine)
{
    for (int group = 0; group < LANES / LANE_GROUP; group++, cosine += LANE_GROUP) {
        const struct lane_range *range = &lanes->range[group];
        const double least = range->omega[0] * t + range->phase[0],
                     most = range->omega[1] * t + range->phase[1];
        const double turned = least * TWO_OVER_PI + WHOLE;
        vector x[GROUP_PARTS];
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) x[q] =
            WITH(load)(lanes->omega, group * GROUP_PARTS + q) * t +
            WITH(load)(lanes->phase, group * GROUP_PARTS + q);
        if (t >= 0 && least >= 0 && most <= CIRCLE_FAR && turned == most * TWO_OVER_PI + WHOLE) {
            uint64_t quarter;
            memcpy(&quarter, &turned, sizeof quarter);
            if (WITH(cosines_of_quarter)(x, turned - WHOLE, quarter + 1, cosine))
                continue;
        }
        WITH(any_cosines)(x, cosine);
    }
}

/* The same where each lane has its own time: t [LANES]. */
TARGET static void WITH(own_drives)(const struct lanes *lanes, const double *t, double *cosine)
{
    for (int from = 0; from < PARTS; from += GROUP_PARTS, cosine += LANE_GROUP) {
        vector x[GROUP_PARTS];
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) x[q] =
            WITH(load)(lanes->omega, from + q) * WITH(load)(t, from + q) +
            WITH(load)(lanes->phase, from + q);
        const double turned = x[0][0] * TWO_OVER_PI + WHOLE;
        WITH(bits) other = {0};
        UNROLL for (int q = 0; q < GROUP_PARTS; q++) other |=
            (x[q] * TWO_OVER_PI + WHOLE != turned) | ~(x[q] >= 0) | ~(x[q] <= CIRCLE_FAR);
        if (WITH(none)(other)) {
            uint64_t quarter;
            memcpy(&quarter, &turned, sizeof quarter);
            if (WITH(cosines_of_quarter)(x, turned - WHOLE, quarter + 1, cosine))
                continue;
        }
        WITH(any_cosines)(x, cosine);
    }
}
#undef GROUP_PARTS
