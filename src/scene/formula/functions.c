/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of expressions, and their catalog. A NaN argument gives NaN, also where libm's fmin
 * and fmax would ignore it. */
#include <hooke/base/catalog.h>
#include <math.h>

#include "scene/formula/expr.h"

double function_min(double a, double b)
{
    return a < b || isnan(a) ? a : b;
}

double function_max(double a, double b)
{
    return a > b || isnan(a) ? a : b;
}

double function_sign(double x)
{
    return less_than(0, x) - less_than(x, 0);
}

double function_step(double x)
{
    return less_equal(0, x);
}

/* Returns `yes` for a condition above 0, else `no`. */
static double function_choose(double condition, double yes, double no)
{
    if (isnan(condition))
        return condition;
    return condition > 0 ? yes : no;
}

/* fmod is exact, and has the sign of a. */
double function_mod(double a, double b)
{
    double rest = fmod(a, b);
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

/* The multiplications are those of struct expr in <hooke/scene/formula.h>. */
double function_power(double x, double n)
{
    if (!power_is_short(n))
        return fixed_pow(x, n);
    int whole = (int)fabs(n), bit = POWER_MAX;
    while (bit > whole)
        bit /= 2;
    double power = whole > 0 ? x : 1;
    while ((bit /= 2) > 0) {
        power *= power;
        if (whole & bit)
            power *= x;
    }
    if (fabs(n) > whole)
        power *= sqrt(x);
    return n < 0 ? 1 / power : power;
}

static const struct function rows[] = {
    {{"sin", "", "sin(x): sine of an angle in radians", "", NULL},
     .dimension = FUNCTION_ANGLE,
     .one = fixed_sin},
    {{"cos", "", "cos(x): cosine of an angle in radians", "", NULL},
     .dimension = FUNCTION_ANGLE,
     .one = fixed_cos},
    {{"tan", "", "tan(x): tangent of an angle in radians", "", NULL},
     .dimension = FUNCTION_ANGLE,
     .one = fixed_tan},
    {{"asin", "", "asin(x): angle whose sine is x, -pi/2 to pi/2", "", "arcsin"},
     .one = fixed_asin},
    {{"acos", "", "acos(x): angle whose cosine is x, 0 to pi", "", "arccos"}, .one = fixed_acos},
    {{"atan", "", "atan(x): angle whose tangent is x, -pi/2 to pi/2", "", "arctan"},
     .one = fixed_atan},
    {{"atan2", "", "atan2(y, x): angle of the point (x, y), -pi to pi", "", "arctan2"},
     .dimension = FUNCTION_SIGN,
     .two = fixed_atan2},
    {{"sinh", "", "sinh(x): hyperbolic sine", "", NULL}, .one = fixed_sinh},
    {{"cosh", "", "cosh(x): hyperbolic cosine", "", NULL}, .one = fixed_cosh},
    {{"tanh", "", "tanh(x): hyperbolic tangent", "", NULL}, .one = fixed_tanh},
    {{"sqrt", "", "sqrt(x): square root", "", NULL},
     .dimension = FUNCTION_SQUARE_ROOT,
     .one = sqrt},
    {{"cbrt", "", "cbrt(x): cube root, also of negative numbers", "", NULL},
     .dimension = FUNCTION_CUBE_ROOT,
     .one = fixed_cbrt},
    {{"exp", "", "exp(x): e to the power x", "", NULL}, .one = fixed_exp},
    {{"log", "", "log(x): natural logarithm", "", "ln"}, .one = fixed_log},
    {{"log10", "", "log10(x): logarithm to the base 10", "", NULL}, .one = fixed_log10},
    {{"pow", "", "pow(x, n): x to the power n, the same as x^n", "", NULL},
     .dimension = FUNCTION_POWER,
     .two = function_power},
    {{"hypot", "", "hypot(x, y): sqrt(x^2 + y^2) without overflow", "", NULL},
     .dimension = FUNCTION_SAME,
     .two = fixed_hypot},
    {{"abs", "", "abs(x): absolute value", "", "fabs"}, .dimension = FUNCTION_SAME, .one = fabs},
    {{"sign", "", "sign(x): -1, 0 or 1", "", "sgn"},
     .dimension = FUNCTION_SIGN,
     .one = function_sign},
    {{"step", "", "step(x): 0 for x < 0, else 1", "", "heaviside heav"},
     .dimension = FUNCTION_SIGN,
     .one = function_step},
    {{"min", "", "min(a, b): the smaller of two", "", NULL},
     .dimension = FUNCTION_SAME,
     .two = function_min},
    {{"max", "", "max(a, b): the larger of two", "", NULL},
     .dimension = FUNCTION_SAME,
     .two = function_max},
    {{"mod", "", "mod(a, b): remainder of a divided by b, between 0 and b", "", NULL},
     .dimension = FUNCTION_SAME,
     .two = function_mod},
    {{"floor", "", "floor(x): largest integer <= x", "", NULL}, .one = floor},
    {{"ceil", "", "ceil(x): smallest integer >= x", "", NULL}, .one = ceil},
    {{"round", "", "round(x): nearest integer, halves away from 0", "", NULL}, .one = round},
    {{"if", "", "if(c, a, b): a where c > 0 (or where c, as x < 1, is true), else b", "", NULL},
     .dimension = FUNCTION_CHOICE,
     .three = function_choose},
};

const struct catalog function_catalog = CATALOG("function", rows);
