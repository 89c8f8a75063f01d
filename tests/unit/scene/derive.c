/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exact derivatives of expressions against differences of high order, and which names an expression
 * is linear in. */
#include "cmocka_testing.h"

#include <hooke/base/catalog.h>
#include <hooke/scene.h>

#include <stdio.h>
#include <string.h>

enum { NAMES = 12 };

static bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = name.len == 1 && name.data[0] >= 'a' && name.data[0] < 'a' + NAMES ? name.data[0] - 'a'
                                                                               : -1;
    return *slot >= 0;
}

static double load(const void *context, int slot)
{
    return ((const double *)context)[slot];
}

static const int slots[NAMES] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};

static const struct expr *compiled(const char *text, struct arena *arena)
{
    struct expr_scope scope = {.find = find};
    struct error error = {0};
    size_t used;
    const struct expr *expr = expr_compile(text_of(text), &scope, arena, &used, &error);
    if (!expr || used != strlen(text))
        fail_msg("%s: %s", text, error.text);
    return expr;
}

static double value_at(const struct expr *expr, const double *at, int slot, double shift)
{
    double x[NAMES];
    memcpy(x, at, sizeof x);
    x[slot] += shift;
    struct expr_scope scope = {.context = x, .load = load};
    return expr_value(expr, &scope);
}

/* Eighth order central differences. */
static double difference(const struct expr *expr, const double *at, int slot)
{
    static const double weight[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
    double h = 1e-2 * fmax(fabs(at[slot]), 0.1), sum = 0;
    for (int k = 0; k < 4; k++)
        sum += weight[k] *
               (value_at(expr, at, slot, (k + 1) * h) - value_at(expr, at, slot, -(k + 1) * h));
    return sum / h;
}

/* The value and the derivatives, as fits of formulas have them. */
static double gradient_of(const struct expr *expr, const double *at, double *gradient)
{
    struct error error = {0};
    double frame[200], value[1 + NAMES];
    struct equations *equations = equations_create(NAMES, &error);
    assert_non_null(equations);
    equations_keep_limits(equations);
    assert_true(equations_add(equations, expr, &error) &&
                equations_derive(equations, 0, 1, slots, NAMES, &error));
    struct program *program = program_create(equations, 0, 1 + NAMES, NULL, NULL, false, &error);
    assert_non_null(program);
    assert_true(program_frame(program) <= COUNT_OF(frame));
    program_prepare(program, frame);
    program_eval(program, at, value, frame);
    memcpy(gradient, value + 1, NAMES * sizeof *gradient);
    program_destroy(program);
    equations_destroy(equations);
    return value[0];
}

static void check(const char *text, const double *at)
{
    struct arena arena = {0};
    const struct expr *expr = compiled(text, &arena);
    struct expr_scope scope = {.context = at, .load = load};
    double gradient[NAMES];
    double value = gradient_of(expr, at, gradient);
    assert_true(value == expr_value(expr, &scope)); /* bit for bit */
    for (int j = 0; j < NAMES; j++) {
        double expected = difference(expr, at, j);
        if (!(fabs(gradient[j] - expected) <= 1e-9 * fmax(1, fabs(expected))))
            fail_msg("%s by %c: %.15g, differences give %.15g", text, 'a' + j, gradient[j],
                     expected);
    }
    arena_reset(&arena);
}

/* A function that is added to the catalogue without a derivative fails here. */
TEST(every_function)
{
    static const double at[NAMES] = {0.37, 0.62, 0.81};
    for (size_t i = 0; i < function_catalog.count; i++) {
        const struct row *row = catalog_row(&function_catalog, i);
        char text[100];
        int arguments = 1;
        for (const char *c = row->brief; *c && *c != ')'; c++)
            arguments += *c == ',';
        const char *list[] = {"", "(a)", "(a, b)", "(a, b, c)"};
        snprintf(text, sizeof text, "%s%s", row->name, list[arguments]);
        check(text, at);
        snprintf(text, sizeof text, "a*%s%s^2 - b", row->name, list[arguments]);
        check(text, at);
    }
}

TEST(compositions)
{
    static const double at[NAMES] = {1.3, -0.7, 0.4, 2.1, 0.9, -1.1, 0.3, 0.8, 1.7, 0.2, 0.6, 1.9};
    /* more names than one pass holds */
    check("a*exp(-c*d)*cos(e*d + f)/(1 + g*h^2) - i*j*k*l", at);
    check("-b^2 + b^3 - 2^b + a^c^d", at);
    check("if(b, a*c, d/a) + max(a, b)*min(c, d) + abs(b)", at);
    check("atan2(b, a) - hypot(a, b)*pow(a, 2.5) + sqrt(exp(sin(a*b)))", at);
    check("a - -b + floor(d)*c + step(b)", at);
}

TEST(limits_are_no_nan)
{
    static const double at[NAMES] = {0, 2, 3};
    static const struct {
        const char *text;
        double by[3];
    } cases[] = {{"a^2", {0, 0, 0}},
                 {"a^b", {0, 0, 0}},
                 {"a^1 + sqrt(a)*0 + b", {NAN, 1, 0}},
                 {"b + c*sqrt(4)", {0, 1, 2}},
                 {"(-2)^c*b", {0, -8, NAN}},
                 {"hypot(a, a)", {0, 0, 0}},
                 {"(a + b)^0", {0, 0, 0}},
                 {"sqrt(a*b)", {NAN, 0, 0}}, /* an infinite slope of what does not depend on b */
                 {"exp(-c/a)*b", {NAN, 0, 0}}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        double gradient[NAMES];
        gradient_of(compiled(cases[i].text, &arena), at, gradient);
        for (int j = 0; j < 3; j++)
            if (!isnan(cases[i].by[j]) && gradient[j] != cases[i].by[j])
                fail_msg("%s by %c: %g", cases[i].text, 'a' + j, gradient[j]);
        arena_reset(&arena);
    }
}

TEST(linearity)
{
    static const struct {
        const char *text;
        int count; /* in a, in a and b, … */
        bool linear;
    } cases[] = {
        {"a*exp(-c*d) + b", 2, true}, {"a*b", 1, true},       {"a*b", 2, false},
        {"exp(a)", 1, false},         {"c/a", 1, false},      {"(a + b*c)/d - 2*a", 2, true},
        {"-(a - b)*sin(c)", 2, true}, {"a^1", 1, false},      {"if(a, b, c)", 1, false},
        {"3 + c", 2, true},           {"a/(1 + b)", 2, false}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        if (expr_linear(compiled(cases[i].text, &arena), slots, cases[i].count) != cases[i].linear)
            fail_msg("%s", cases[i].text);
        arena_reset(&arena);
    }
}

RUN_TESTS(NULL, NULL)
