/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of the functions of one argument, of their first and of their second derivatives:
 * jet_one(). Each series_NAME() returns those of the function NAME over an interval of its
 * argument. */
#include "scene/formula/jet.h"

/* Bound of errors of elementary functions, in units of the last place: 0.9 of the value at an end
 * of the interval and 0.9 of a value inside. */
static const double function_units = 2;

/* Bounds of a function f and of f', f'' over an interval. */
struct interval_jet {
    struct interval f, first, second;
};

static struct interval interval_one(void)
{
    return interval_point(1);
}

static struct interval interval_scaled(double factor, struct interval a)
{
    return interval_mul(interval_point(factor), a);
}

/* Returns the bounds of a function that grows with x. */
static struct interval increasing_bounds(double (*function)(double), struct interval x)
{
    return interval_wide(function(x.lo), function(x.hi), function_units);
}

/* Returns the square root, which is rounded once. */
static struct interval interval_sqrt(struct interval x)
{
    const struct interval wide = interval_wide(sqrt(x.lo), sqrt(x.hi), 0.5);
    return (struct interval){fmax(wide.lo, 0), wide.hi};
}

static const struct interval_jet unknown = {{NAN, NAN}, {NAN, NAN}, {NAN, NAN}};

/* Cuts x to the domain of a function, from lo to hi; empty if it is outside. Returns true if x was
 * inside, so that slopes are known. */
static bool domain_clip(struct interval *x, double lo, double hi)
{
    const bool whole = x->lo >= lo && x->hi <= hi;
    if (x->hi < lo || x->lo > hi)
        *x = interval_none;
    else if (!whole)
        *x = (struct interval){fmax(x->lo, lo), fmin(x->hi, hi)};
    return whole;
}

/* Returns bounds f with any slope. */
static struct interval_jet unknown_slopes(struct interval f)
{
    return (struct interval_jet){f, interval_all, interval_all};
}

/* ---- circular ---- */

/* Returns true if x contains (k + shift) pi for an even k (odd or any k for parts 1 and 2), or if
 * that cannot be excluded. */
static bool contains_multiple(struct interval x, double shift, int part)
{
    const double tolerance = 4 * 0x1p-52 * fmax(fabs(x.lo), fabs(x.hi));
    const double period = part == 2 ? M_PI : 2 * M_PI;
    const double first = (part == 1 ? shift + 1 : shift) * M_PI;
    return floor((x.hi + tolerance - first) / period) >= ceil((x.lo - tolerance - first) / period);
}

/* Returns the bounds of a sine or cosine, whose maxima are at (2 k + shift) pi. */
static struct interval interval_wave(double (*function)(double), struct interval x, double shift)
{
    if (!(x.hi - x.lo < 2 * M_PI) || fmax(fabs(x.lo), fabs(x.hi)) > 0x1p40)
        return (struct interval){-1, 1};
    const double p = function(x.lo), q = function(x.hi);
    struct interval f = interval_wide(fmin(p, q), fmax(p, q), function_units);
    f.hi = contains_multiple(x, shift, 0) || f.hi > 1 ? 1 : f.hi;
    f.lo = contains_multiple(x, shift, 1) || f.lo < -1 ? -1 : f.lo;
    return f;
}

static struct interval_jet series_sin(struct interval x)
{
    const struct interval f = interval_wave(fixed_sin, x, 0.5);
    return (struct interval_jet){f, interval_wave(fixed_cos, x, 0), interval_neg(f)};
}

static struct interval_jet series_cos(struct interval x)
{
    const struct interval f = interval_wave(fixed_cos, x, 0);
    return (struct interval_jet){f, interval_neg(interval_wave(fixed_sin, x, 0.5)),
                                 interval_neg(f)};
}

/* f' = 1 + f^2, f'' = 2 f f'; unbounded if x may contain a pole */
static struct interval_jet series_tan(struct interval x)
{
    if (!(x.hi - x.lo < M_PI) || fmax(fabs(x.lo), fabs(x.hi)) > 0x1p40 ||
        contains_multiple(x, 0.5, 2))
        return unknown_slopes(interval_all);
    const struct interval f = increasing_bounds(fixed_tan, x),
                          first = interval_add(interval_one(), interval_square(f));
    return (struct interval_jet){f, first, interval_scaled(2, interval_mul(f, first))};
}

/* f' = 1/sqrt(1 - x^2), f'' = x/(1 - x^2)^(3/2) */
static struct interval_jet series_asin(struct interval x)
{
    const bool whole = domain_clip(&x, -1, 1);
    if (interval_empty(x))
        return unknown;
    const struct interval f = increasing_bounds(fixed_asin, x);
    const struct interval rest =
        interval_mul(interval_sub(interval_one(), x), interval_add(interval_one(), x));
    if (!whole || !(rest.lo > 0))
        return unknown_slopes(f);
    const struct interval first = interval_div(interval_one(), interval_sqrt(rest));
    return (struct interval_jet){f, first, interval_div(interval_mul(x, first), rest)};
}

/* f = pi/2 - asin(x) */
static struct interval_jet series_acos(struct interval x)
{
    struct interval_jet s = series_asin(x);
    if (interval_empty(s.f))
        return s;
    domain_clip(&x, -1, 1);
    return (struct interval_jet){interval_wide(fixed_acos(x.hi), fixed_acos(x.lo), function_units),
                                 interval_neg(s.first), interval_neg(s.second)};
}

static struct interval_jet series_atan(struct interval x)
{
    const struct interval first =
        interval_div(interval_one(), interval_add(interval_one(), interval_square(x)));
    return (struct interval_jet){increasing_bounds(fixed_atan, x), first,
                                 interval_scaled(-2, interval_mul(x, interval_square(first)))};
}

/* ---- exponential ---- */

/* Returns the bounds of cosh(x), which is 1 at 0 and grows to both sides. */
static struct interval cosh_of(struct interval x)
{
    const double p = fixed_cosh(x.lo), q = fixed_cosh(x.hi);
    return interval_wide(interval_has(x, 0) ? 1 : fmin(p, q), fmax(p, q), function_units);
}

static struct interval_jet series_sinh(struct interval x)
{
    const struct interval f = increasing_bounds(fixed_sinh, x);
    return (struct interval_jet){f, cosh_of(x), f};
}

static struct interval_jet series_cosh(struct interval x)
{
    const struct interval f = cosh_of(x);
    return (struct interval_jet){f, increasing_bounds(fixed_sinh, x), f};
}

static struct interval_jet series_tanh(struct interval x)
{
    const struct interval f = increasing_bounds(fixed_tanh, x),
                          first = interval_div(interval_one(), interval_square(cosh_of(x)));
    return (struct interval_jet){f, first, interval_scaled(-2, interval_mul(f, first))};
}

static struct interval_jet series_exp(struct interval x)
{
    struct interval f = increasing_bounds(fixed_exp, x);
    f.lo = fmax(f.lo, 0);
    return (struct interval_jet){f, f, f};
}

/* Returns the bounds of a logarithm, f' = factor/x, where the factor is 1/ln of the base. */
static struct interval_jet logarithm(double (*function)(double), struct interval x, double factor)
{
    const bool whole = domain_clip(&x, 0, HUGE_VAL);
    if (interval_empty(x))
        return unknown;
    const struct interval f = increasing_bounds(function, x);
    if (!whole || !(x.lo > 0))
        return unknown_slopes(f);
    const struct interval first = interval_div(interval_wide(factor, factor, 1), x);
    return (struct interval_jet){f, first, interval_neg(interval_div(first, x))};
}

static struct interval_jet series_log(struct interval x)
{
    return logarithm(fixed_log, x, 1);
}

static struct interval_jet series_log10(struct interval x)
{
    return logarithm(fixed_log10, x, M_LOG10E);
}

/* ---- roots ---- */

/* f' = 1/(2 f), f'' = -f'/(2 x); slopes are unknown at 0 */
static struct interval_jet series_sqrt(struct interval x)
{
    const bool whole = domain_clip(&x, 0, HUGE_VAL);
    if (interval_empty(x))
        return unknown;
    const struct interval f = interval_sqrt(x);
    if (!whole || !(x.lo > 0))
        return unknown_slopes(f);
    const struct interval first = interval_div(interval_point(0.5), f);
    return (struct interval_jet){f, first, interval_scaled(-0.5, interval_div(first, x))};
}

/* f' = 1/(3 f^2), f'' = -2/3 f'/x */
static struct interval_jet series_cbrt(struct interval x)
{
    const struct interval f = increasing_bounds(fixed_cbrt, x);
    const struct interval first =
        interval_div(interval_one(), interval_scaled(3, interval_square(f)));
    return (struct interval_jet){
        f, first, interval_div(interval_scaled(-2. / 3, interval_wide(first.lo, first.hi, 2)), x)};
}

/* ---- corners and jumps ---- */

/* Returns bounds f of a function with a constant slope. */
static struct interval_jet constant_slope(struct interval f, double slope)
{
    return (struct interval_jet){f, interval_point(slope), interval_point(0)};
}

static struct interval_jet series_abs(struct interval x)
{
    if (x.lo >= 0 || x.hi <= 0)
        return x.lo >= 0 ? constant_slope(x, 1) : constant_slope(interval_neg(x), -1);
    return (struct interval_jet){{0, fmax(-x.lo, x.hi)}, {-1, 1}, interval_all};
}

/* Returns the bounds of a function that grows and is constant between its jumps. */
static struct interval_jet step_bounds(double (*function)(double), struct interval x)
{
    const struct interval f = {function(x.lo), function(x.hi)};
    return f.lo == f.hi ? constant_slope(f, 0) : unknown_slopes(f);
}

#define STAIRS(name, function)                                                                     \
    static struct interval_jet name(struct interval x)                                             \
    {                                                                                              \
        return step_bounds(function, x);                                                           \
    }
STAIRS(series_sign, function_sign)
STAIRS(series_step, function_step)
STAIRS(series_floor, floor)
STAIRS(series_ceil, ceil)
STAIRS(series_round, round)

/* ---- the table ---- */

static const struct {
    double (*function)(double);
    struct interval_jet (*series)(struct interval x);
} rows[] = {
    {fixed_sin, series_sin},      {fixed_cos, series_cos},     {fixed_tan, series_tan},
    {fixed_asin, series_asin},    {fixed_acos, series_acos},   {fixed_atan, series_atan},
    {fixed_sinh, series_sinh},    {fixed_cosh, series_cosh},   {fixed_tanh, series_tanh},
    {sqrt, series_sqrt},          {fixed_cbrt, series_cbrt},   {fixed_exp, series_exp},
    {fixed_log, series_log},      {fixed_log10, series_log10}, {fabs, series_abs},
    {function_sign, series_sign}, {floor, series_floor},       {ceil, series_ceil},
    {function_step, series_step}, {round, series_round},
};

/* Finds the function's row, and applies the chain rule. */
struct jet jet_one(double (*function)(double), struct jet x)
{
    size_t i = 0;
    while (i < COUNT_OF(rows) && rows[i].function != function)
        i++;
    if (interval_empty(x.value))
        return jet_jump(NAN, NAN);
    if (i == COUNT_OF(rows))
        return jet_jump(-HUGE_VAL, HUGE_VAL);
    const struct interval_jet s = rows[i].series(x.value);
    return (struct jet){s.f, interval_mul(s.first, x.slope),
                        interval_add(interval_mul(s.second, interval_square(x.slope)),
                                     interval_mul(s.first, x.bend))};
}
