/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Arc functions, atan2, hypot and cbrt, with the same bits on every machine. Each has a polynomial
 * for the difference from its leading term, which is added last. */
#include <hooke/base/text.h>
#include <stdbool.h>

#include "base/elementary/wide.h"

#define ATAN_CENTRES 16 /* The table has atan(j/ATAN_CENTRES). */
static const struct wide centre_angle[] = {
    {0, 0},
    {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};

/* Constants as sums of two doubles. */
static const struct wide half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54},
                         pi = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/* Largest |x| for which angle_rest() is accurate. */
#define ATAN_POLYNOMIAL_MAX 0.1875
/* Returns atan x - x for |x| <= ATAN_POLYNOMIAL_MAX, by a polynomial (Remez exchange in 400 bits),
 * with an error of 2^-64.5 of atan x. */
static double angle_rest(double x)
{
    const double s = x * x, q = s * s;
    const double low = (-0x1.5555555555553p-2 + s * 0x1.9999999998bf9p-3) +
                       q * (-0x1.249249238b4a7p-3 + s * 0x1.c71c709407039p-4);
    const double high = (-0x1.745cb3ef1dca2p-4 + s * 0x1.3b00e9ecf7c34p-4) +
                        q * (-0x1.0efef093a3da2p-4 + s * 0x1.a2202f3a1672ep-5);
    return x * s * (low + q * q * high);
}

/* Returns a - b, rounded once. */
static double wide_less(struct wide a, struct wide b)
{
    const struct wide sum = ordered_sum(a.high, -b.high);
    return sum.high + (sum.low + (a.low - b.low));
}

/* Returns the angle of the point (x, y), 0 <= y <= x, as the sum of two angles: with c = j/16 next
 * to y/x, atan c from the table and atan t with t = (y - c x)/(x + c y), |t| < 0.034. Products c x
 * are exact, in two parts. For a small y/x the angle is found from y/x alone. */
INLINE struct wide first_angle(double y, double x)
{
    const double ratio = y / x;
    if (ratio <= ATAN_POLYNOMIAL_MAX) {
        const struct wide numerator = {y, 0}, denominator = {x, 0},
                          parts = wide_quotient(numerator, denominator),
                          t = ordered_sum(parts.high, parts.low);
        return (struct wide){t.high, t.low + angle_rest(t.high)};
    }
    const double j = (ratio * ATAN_CENTRES + ROUND_TO_INTEGER) - ROUND_TO_INTEGER,
                 c = j / ATAN_CENTRES, upper = upper_part(x);
    const double t = ((y - c * upper) - c * (x - upper)) / (x + c * y);
    const struct wide centre = centre_angle[(int)j], leading = ordered_sum(centre.high, t);
    return (struct wide){leading.high, leading.low + (centre.low + angle_rest(t))};
}

/* Returns the angle from 0 to pi of a point with y >= 0, both coordinates of normal size. */
static double point_angle(double y, double x)
{
    const double x_size = fabs(x);
    const bool steep = y > x_size;
    const struct wide a = steep ? first_angle(x_size, y) : first_angle(y, x_size);
    struct wide base = {0, 0};
    if (steep)
        base = half_pi;
    else if (x < 0)
        base = pi;
    const double sign = steep == (x < 0) ? 1 : -1;
    const struct wide sum = ordered_sum(base.high, sign * a.high);
    return sum.high + (sum.low + (base.low + sign * a.low));
}

/* Returns atan x: the sum of the angles of a centre c = j/16 near |x| (or near 1/|x| if |x| > 1)
 * and of a small remainder, as first_angle() does. */
double fixed_atan(double x)
{
    const double size = fabs(x);
    if (!(size > ATAN_POLYNOMIAL_MAX))
        return size < 0x1p-27 || x != x ? x : x + angle_rest(x);
    if (size > 0x1p60)
        return copysign(half_pi.high, x);
    const bool is_inverted = size > 1;
    const double ratio = is_inverted ? 1 / size : size,
                 j = (ratio * ATAN_CENTRES + ROUND_TO_INTEGER) - ROUND_TO_INTEGER;
    const double c = ratio > ATAN_POLYNOMIAL_MAX ? j / ATAN_CENTRES : 0, upper = upper_part(size),
                 lower = size - upper;
    const double t =
        is_inverted ? ((1 - c * upper) - c * lower) / (size + c) : (size - c) / (1 + c * size);
    const struct wide centre = centre_angle[(int)(c * ATAN_CENTRES)],
                      leading = ordered_sum(centre.high, t),
                      found = {leading.high, leading.low + (centre.low + angle_rest(t))};
    return copysign(is_inverted ? wide_less(half_pi, found) : found.high + found.low, x);
}

/* Returns the angle of the point (x, y), from -pi to pi. Zeros, infinities and extreme ratios are
 * treated first; both coordinates are scaled if one of them is extreme. */
double fixed_atan2(double y, double x)
{
    if (x != x || y != y)
        return x + y;
    double x_size = fabs(x), y_size = fabs(y);
    if (y_size == 0 || (x_size == HUGE_VAL && y_size < HUGE_VAL))
        return copysign(signbit(x) ? pi.high : 0, y);
    if (x_size == 0 || y_size == HUGE_VAL || y_size > x_size * 0x1p60) {
        const double eighth = x_size == HUGE_VAL ? half_pi.high / 2 : 0;
        if (eighth == 0)
            return copysign(half_pi.high, y);
        return copysign(x > 0 ? eighth : 3 * eighth, y);
    }
    if (y_size < x_size * 0x1p-60)
        return copysign(x < 0 ? pi.high : y_size / x_size, y);
    const double scale = power_of_two(x_size > 1 || y_size > 1 ? -500 : 500);
    if (!(x_size > 0x1p-400 && y_size > 0x1p-400 && x_size < 0x1p400 && y_size < 0x1p400)) {
        x_size *= scale;
        y_size *= scale;
    }
    return copysign(point_angle(y_size, x < 0 ? -x_size : x_size), y);
}

/* Returns asin x - x for |x| <= 1/2, by a polynomial (Remez exchange in 400 bits), with an error of
 * 2^-59.9 of asin x. */
static double arc_rest(double x)
{
    const double s = x * x, q = s * s, p = q * q;
    const double low = (0x1.5555555555577p-3 + s * 0x1.333333332e089p-4) +
                       q * (0x1.6db6db721a113p-5 + s * 0x1.f1c71a9213e51p-6);
    const double middle = (0x1.6e8bdf31ec1cep-6 + s * 0x1.1c49ea8c925f8p-6) +
                          q * (0x1.ca201b2f0494ep-7 + s * 0x1.7580ecd3344cdp-7);
    const double high = (0x1.6156e2ff7f089p-7 + s * 0x1.e4600ba8a0358p-9) +
                        q * (0x1.641a1bab40dddp-6 - s * 0x1.58b2aa90f948fp-6);
    return x * s * (low + p * (middle + p * (high + p * 0x1.0b8072c58c6f9p-5)));
}

/* Returns acos(x)/2 = asin sqrt((1 - x)/2) for 1/2 <= x <= 1, as the root and its correction. */
static struct wide half_arc(double x)
{
    const double square = (1 - x) * 0.5, root = sqrt(square);
    if (root == 0)
        return (struct wide){0, 0};
    const struct wide p = wide_product(root, root);
    return (struct wide){root, ((square - p.high) - p.low) / (2 * root) + arc_rest(root)};
}

/* Returns asin x, or NaN beyond [-1, 1]: by the polynomial up to 1/2, beyond it as pi/2 - acos
 * |x|. */
double fixed_asin(double x)
{
    const double size = fabs(x);
    if (!(size <= 1))
        return x != x ? x : (double)NAN;
    if (size <= 0.5)
        return size < 0x1p-27 ? x : x + arc_rest(x);
    const struct wide half = half_arc(size);
    return copysign(wide_less(half_pi, (struct wide){2 * half.high, 2 * half.low}), x);
}

/* Returns acos x, or NaN beyond [-1, 1]: as pi/2 - asin x up to 1/2, beyond it by half_arc(). */
double fixed_acos(double x)
{
    if (!(fabs(x) <= 1))
        return x != x ? x : (double)NAN;
    if (fabs(x) <= 0.5)
        return wide_less(half_pi, (struct wide){x, arc_rest(x)});
    const struct wide half = half_arc(fabs(x)), arc = {2 * half.high, 2 * half.low};
    return x > 0 ? arc.high + arc.low : wide_less(pi, arc);
}

/* Returns sqrt(a^2 + b^2) for a >= b whose squares are normal, corrected by the rounding errors of
 * squares and root. */
static double hypotenuse(double a, double b)
{
    const struct wide aa = wide_product(a, a), bb = wide_product(b, b),
                      sum = ordered_sum(aa.high, bb.high);
    const double square = sum.high, rest = sum.low + (aa.low + bb.low), root = sqrt(square);
    const struct wide p = wide_product(root, root);
    return root + ((square - p.high) - p.low + rest) / (2 * root);
}

/* Returns sqrt(x^2 + y^2); the sides are scaled if their squares would overflow or underflow. */
double fixed_hypot(double x, double y)
{
    const double p = fabs(x), q = fabs(y);
    const bool swaps = p < q;
    const double a = swaps ? q : p;
    const double b = swaps ? p : q;
    if (a < 0x1p500 && b > 0x1p-400)
        return hypotenuse(a, b);
    if (p == HUGE_VAL || q == HUGE_VAL)
        return HUGE_VAL;
    if (x != x || y != y)
        return x + y;
    if (b <= a * 0x1p-60)
        return a + b;
    const double scale = a > 0x1p450 ? 0x1p-600 : 0x1p600;
    return hypotenuse(a * scale, b * scale) / scale;
}

/* Returns the cube root of x = u 2^3k, 1 <= u < 8. A polynomial (Remez exchange, to 2^-14.7)
 * estimates u^(-1/3), which a Newton step improves to 2^-28. The root u y^2 is cut to 26 bits, so
 * that its square is exact, and corrected by what its cube lacks. */
double fixed_cbrt(double x)
{
    static const double shrunk[] = {1, 0x1.965fea53d6e3dp-1, 0x1.428a2f98d728bp-1}; /* 2^(-i/3) */
    const double size = fabs(x);
    if (!(size > 0 && size < HUGE_VAL))
        return x;
    const bool tiny = size < 0x1p-1022;
    const uint64_t bits = to_bits(tiny ? size * 0x1p54 : size), one = to_bits(1),
                   fraction = bits & ((UINT64_C(1) << EXPONENT_SHIFT) - 1);
    const unsigned power =
                       (unsigned)(bits >> EXPONENT_SHIFT) + (tiny ? 1200 - 1023 - 54 : 1200 - 1023),
                   third = power / 3, left = power % 3;
    const double m = from_bits(fraction | one),
                 u = from_bits((fraction | one) + ((uint64_t)left << EXPONENT_SHIFT)), q = m * m;
    const double estimate = shrunk[left] * ((0x1.ab8596af04ee3p+0 - m * 0x1.2c41f3a38517ap+0) +
                                            q * (0x1.6416732975902p-1 - m * 0x1.c5189e25e481dp-3) +
                                            q * q * 0x1.d46fcca0c71dap-6);
    const double y = estimate + estimate * (1. / 3) * (1 - u * estimate * (estimate * estimate));
    const double root = upper_part(u * y * y), square = root * root, upper = upper_part(square);
    const double correction = ((u - upper * root) - (square - upper) * root) * (1 / (3 * square));
    return copysign((root + (correction - correction * correction * y)) *
                        power_of_two((int64_t)third - 400),
                    x);
}
