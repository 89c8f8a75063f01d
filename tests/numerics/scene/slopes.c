/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Derivatives of random expressions against complex steps (Squire, Trapp 1998), to 1e-12. */
#include "numerics/scene/trees.h"

#include <complex.h>

#define STEP_SIZE 1e-30

static double complex complex_of(double re, double im)
{
    double complex z;
    memcpy(&z, (double[]){re, im}, sizeof z);
    return z;
}

static double complex complex_power(double complex x, double complex n)
{
    /* only integer powers are real there */
    if (cimag(n) != 0 && creal(x) <= 0)
        return complex_of(NAN, NAN);
    return creal(n) == 0 && cimag(n) == 0 ? 1 : cexp(n * clog(x));
}

static double complex complex_call(int which, const double complex *z)
{
    static const double tenth = 0.43429448190325182765; /* 1/log(10) */
    const double re = creal(z[0]);
    switch (which) {
    case SIN:
        return csin(z[0]);
    case COS:
        return ccos(z[0]);
    case TAN:
        return csin(z[0]) / ccos(z[0]);
    case ASIN:
        return complex_of(asin(re), cimag(z[0]) / sqrt(1 - re * re));
    case ACOS:
        return complex_of(acos(re), -cimag(z[0]) / sqrt(1 - re * re));
    case ATAN:
        return catan(z[0]);
    case ATAN2:
        if (fabs(re) > fabs(creal(z[1])))
            return copysign(1.57079632679489661923, re) - catan(z[1] / z[0]);
        return catan(z[0] / z[1]) + (creal(z[1]) < 0 ? copysign(3.14159265358979323846, re) : 0);
    case SINH:
        return csinh(z[0]);
    case COSH:
        return ccosh(z[0]);
    case TANH:
        return ctanh(z[0]);
    case EXP:
        return cexp(z[0]);
    case LOG:
        return clog(z[0]);
    case LOG10:
        return clog(z[0]) * tenth;
    case SQRT:
        return csqrt(z[0]);
    case CBRT:
        return re < 0 ? -cexp(clog(-z[0]) / 3) : cexp(clog(z[0]) / 3);
    case ABS:
        return re < 0 ? -z[0] : z[0];
    case HYPOT:
        return csqrt(z[0] * z[0] + z[1] * z[1]);
    case MIN:
        return re < creal(z[1]) ? z[0] : z[1];
    case MAX:
        return re > creal(z[1]) ? z[0] : z[1];
    case IF:
        return re > 0 ? z[1] : z[2];
    case MOD:
        return z[0] - z[1] * floor(re / creal(z[1]));
    case POW_CALL:
        return complex_power(z[0], z[1]);
    default:
        return functions[which].one(re); /* steps */
    }
}

static double complex complex_operation(const struct tree *t, const double complex *z)
{
    switch (t->kind) {
    case NEG:
        return -z[0];
    case ADD:
        return z[0] + z[1];
    case SUB:
        return z[0] - z[1];
    case MUL:
        return z[0] * z[1];
    case DIV:
        return z[0] / z[1];
    case POW:
        return complex_power(z[0], z[1]);
    case LESS:
        return creal(z[0]) < creal(z[1]);
    case GREATER:
        return creal(z[0]) > creal(z[1]);
    case LESS_EQUAL:
        return creal(z[0]) <= creal(z[1]);
    case GREATER_EQUAL:
        return creal(z[0]) >= creal(z[1]);
    default:
        return complex_call(t->which, z);
    }
}

static double real_operation(const struct tree *t, const double complex *z)
{
    const double x[3] = {creal(z[0]), creal(z[1]), creal(z[2])};
    return t->kind == POW                      ? short_power(x[0], x[1])
           : t->kind == CALL && t->which != IF ? call_value(t->which, x)
                                               : creal(complex_operation(t, z));
}

/* The value with its derivative; *size: the sum of the magnitudes of all that adds up to the
 * derivative, NaN where the place is too near a pole or too far out to say anything to 1e-12. */
static double complex complex_value(const struct tree *t, const double *x, int name, double *size)
{
    if (t->kind == NUMBER || t->kind == NAME) {
        const bool varies = t->kind == NAME && t->which == name;
        *size = varies;
        return complex_of(t->kind == NUMBER ? t->number : x[t->which], varies ? STEP_SIZE : 0);
    }
    double complex z[3] = {0}, part[3];
    double sizes[3];
    *size = 0;
    int count = 0;
    for (; count < 3 && t->x[count]; count++)
        z[count] = complex_value(t->x[count], x, name, &sizes[count]);
    const double complex made = complex_operation(t, z);
    const double real = real_operation(t, z);
    if (!(fabs(creal(made) - real) < 1e-9) || !(fabs(real) < 30) ||
        !(fabs(real) > 1e-3 || real == 0))
        *size = NAN;
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < 3; i++)
            part[i] = complex_of(creal(z[i]), i == k ? STEP_SIZE : 0);
        const double slope = fabs(cimag(complex_operation(t, part))) / STEP_SIZE;
        *size += slope < 100 ? slope * sizes[k] : NAN;
    }
    return complex_of(real, cimag(made)); /* the last bit matters to log near 1 */
}

TEST(test_derivatives)
{
    static struct forest f;
    f.seed = 12;
    const int rounds = is_long() ? 200000 : 6000;
    int compared = 0, zero = 0;
    for (int round = 0; round < rounds; round++) {
        struct buffer text = {0};
        struct error error = {0};
        double x[NAMES], derivative[NAMES];
        f.count = 0;
        const struct tree *tree = grow(&f, 1 + round % 5);
        write_tree(&text, tree);
        for (int j = 0; j < NAMES; j++)
            x[j] = random_between(&f.seed, 0.1, 2.9);
        struct equations *equations = equations_of((const char *const[]){text.data}, 1);
        static const int all[NAMES] = {0, 1, 2, 3, 4, 5};
        assert_true(equations_derive(equations, 0, 1, all, NAMES, &error));
        assert_int_equal(equations_count(equations), 1 + NAMES);
        evaluate_all(equations, 1, NAMES, NULL, NULL, x, 1, derivative);
        for (int j = 0; j < NAMES; j++) {
            double size;
            const double wanted = cimag(complex_value(tree, x, j, &size)) / STEP_SIZE;
            if (isnan(size) || isnan(wanted))
                continue;
            if (!(fabs(derivative[j] - wanted) <= 1e-12 * fmax(size, fabs(wanted))))
                fail_msg("%s by %c: %.17g, wanted %.17g (round %d)", text.data, 'a' + j,
                         derivative[j], wanted, round);
            compared++;
            zero += wanted == 0;
        }
        equations_destroy(equations);
        buffer_free(&text);
    }
    print_message("%d derivatives compared, %d of them 0\n", compared, zero);
    assert_true(compared - zero > rounds / 2);
}

RUN_TESTS(NULL, NULL)
