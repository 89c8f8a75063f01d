/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Expressions: values against C's own arithmetic, where they stop, what is said about mistakes,
 * hostile input. */
#include <hooke/base/number.h>
#include "long_form.h"
#include "unit/scene/names.h"
#include "unit/cpu_time.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Compiles from a copy of exactly this length, so that a sanitizer sees every byte read too many.
 */
static double value_of(const char *source, size_t *used)
{
    struct arena arena = {0};
    struct error error = {0};
    size_t len = strlen(source);
    char *copy = malloc(len ? len : 1);
    assert_non_null(copy);
    memcpy(copy, source, len);
    const struct expr *expr = expr_compile((struct text){copy, len}, &scope, &arena, used, &error);
    if (!expr)
        fail_msg("'%s': %s", source, error.text);
    double value = expr_value(expr, &scope);
    arena_reset(&arena);
    free(copy);
    return value;
}

TEST(test_values)
{
    static const double pi = 3.14159265358979323846;
    const struct {
        const char *source;
        double value;
    } cases[] = {
        {"1 + 2 * 3", 7},
        {"(1 + 2) * 3", 9},
        {"2 - 3 - 4", -5},
        {"2 / 4 / 2", 0.25},
        {"2^3^2", 512},
        {"-2^2", -4},
        {"2^-2", 0.25},
        {"2^-2^2", 0.0625},
        {"2^-3*4", 0.5},
        {"--3", 3},
        {"-3 + 5", 2},
        {"3 - -5", 8},
        {"3--5", 8},
        {"3*-5", -15},
        {"+4", 4},
        {"3 + + 4", 7},
        {"-(2 + 3)^2", -25},
        {"1e3", 1000},
        {".5", 0.5},
        {"1.5e-3*2", 3e-3},
        {"pi", pi},
        {"y", 2},
        {"v", -3},
        {"y + v", -1},
        {"y*v^2", 18},
        {"-v^2", -9},
        {"(y)", 2},
        {"((((y))))", 2},
        {"T0/200", 0.02},
        {"x_1", 0.5},
        {"phase-error", 11},
        {"phase - error", 2},
        {"phase -error", 2},
        {"y-v", 5},
        {"y-phase-error", -9},
        {"phase-error-error", 6},
        {"phase-gamma", 6.75},
        {"error-phase", -2},
        {"y-1", 1},
        {"phase-1", 6},
        {"sin(1)", sin(1)},
        {"cos(y)", cos(2)},
        {"tan (y)", tan(2)},
        {"asin(0.5)", asin(0.5)},
        {"acos(0.5)", acos(0.5)},
        {"atan(y)", atan(2)},
        {"atan2(v, y)", atan2(-3, 2)},
        {"sinh(1)", sinh(1)},
        {"cosh(1)", cosh(1)},
        {"tanh(1)", tanh(1)},
        {"sqrt(2)", sqrt(2)},
        {"cbrt(-8)", -2},
        {"exp(1)", exp(1)},
        {"log(10)", log(10)},
        {"log10(1000)", 3},
        {"abs(v)", 3},
        {"hypot(3, 4)", 5},
        {"min(y, v)", -3},
        {"max(y, v)", 2},
        {"pow(y, 10)", 1024},
        {"floor(-1.5)", -2},
        {"ceil(-1.5)", -1},
        {"round(2.5)", 3},
        {"sign(v)", -1},
        {"sign(0)", 0},
        {"step(0)", 1},
        {"step(v)", 0},
        {"if(v, 1, 2)", 2},
        {"if(y, 1, 2)", 1},
        {"if(0, 1, 2)", 2},
        {"max(1, 2)^2 + min(3, (1 + 1))", 6},
        {"hypot(max(3, y), min(4, 5) )", 5},
        {"if(y - 1, if(v, 1, 2), 3)", 2},
        {"1/0", HUGE_VAL},
        {"-1/0", -HUGE_VAL},
        {"sqrt(-1)", NAN},
        {"nan_ + 1", NAN},
        {"min(1, nan_)", NAN},
        {"min(nan_, 1)", NAN},
        {"max(nan_, 1)", NAN},
        {"max(1, nan_)", NAN},
        {"step(nan_)", NAN},
        {"sign(nan_)", NAN},
        {"if(nan_, 1, 2)", NAN},
        {"(v < y)", 1},
        {"(v>y) + (y >= 2) + (2 <= y)", 2},
        {"if(y + 1 < 2 + 1, 5, 6)", 6},
        {"if(y<=2, 5, 6)*(1 < 2)", 5},
        {"-(v < 1)*3", -3},
        {"(nan_ < 1)", NAN},
        {"(1 >= nan_)", NAN},
        {"mod(7, 3)", 1},
        {"mod(-7, 3)", 2},
        {"mod(7, v)", -2},
        {"mod(6, v)", 0},
        {"mod(1, 0)", NAN},
        {"v^3", -27},
        {"v^-2", 1.0 / 9},
        {"y^15", 32768},
        {"y^1.5", 2 * sqrt(2)},
        {"v^0.5", NAN},
        {"y^0.3", pow(2, 0.3)},
        {"0^0", 1},
        {"y^0.5", sqrt(2)},
        {"\t1 \t+\t2", 3},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        size_t used = 0;
        double value = value_of(cases[i].source, &used);
        if (!(value == cases[i].value || (isnan(value) && isnan(cases[i].value))))
            fail_msg("'%s' = %.17g, wanted %.17g", cases[i].source, value, cases[i].value);
        if (used != strlen(cases[i].source))
            fail_msg("'%s' read only to %zu", cases[i].source, used);
    }
}

TEST(test_where_it_ends)
{
    /* The bar is where the expression ends. */
    static const char *const cases[] = {
        "5 cm|",       "5cm|",   "0.25 1/s|",    "(3+1) s|", "30 deg|", "199.9| +- 0.1 g",
        "5|+-1",       "y| < 3", "y|<=3",        "1|:2",     "1|,2",    "1|; 2",
        "1| # 2",      "2|)",    "3*gamma| # x", "1| = 2",   "(2)|(3)", "5|,3 cm",
        "min(1,2)|,3", "2|\n",   "(y < 3)| < 4",
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char source[64];
        size_t bar = strcspn(cases[i], "|"), used = 0;
        snprintf(source, sizeof source, "%.*s%s", (int)bar, cases[i], cases[i] + bar + 1);
        (void)value_of(source, &used);
        if (used != bar)
            fail_msg("'%s' ends at %zu, wanted %zu", source, used, bar);
    }
}

static void expect_mistake(const char *source, const char *sentence, const char *where,
                           const char *hint)
{
    struct arena arena = {0};
    struct error error = {0};
    size_t used;
    struct text text = text_of(source);
    assert_null(expr_compile(text, &scope, &arena, &used, &error));
    arena_reset(&arena);
    if (strcmp(error.text, sentence) != 0)
        fail_msg("'%s' says '%s', wanted '%s'", source, error.text, sentence);
    assert_true(error.where.data >= source &&
                error.where.data + error.where.len <= source + text.len);
    if (!text_is(error.where, where))
        fail_msg("'%s' points at '%.*s', wanted '%s'", source, (int)error.where.len,
                 error.where.data, where);
    if (!strstr(error.hint, hint) || (!*hint && *error.hint))
        fail_msg("'%s' hints '%s', wanted '%s'", source, error.hint, hint);
    assert_int_equal(error.code, ERROR_COMMAND);
}

TEST(test_mistakes)
{
    expect_mistake("3 * gama", "unknown name 'gama'", "gama", "did you mean 'gamma'?");
    expect_mistake("y - gama", "unknown name 'gama'", "gama", "'gamma'");
    expect_mistake("y-gama", "unknown name 'gama'", "gama", "'gamma'");
    expect_mistake("y' + 1", "unknown name 'y''", "y'", "did you mean 'y'?");
    expect_mistake("squirt", "unknown name 'squirt'", "squirt", "'sqrt'");
    expect_mistake("squrt(2)", "unknown function 'squrt'", "squrt", "'sqrt'");
    expect_mistake("y(2)", "unknown function 'y'", "y", "");
    expect_mistake("sin", "sin is a function; write sin(x)", "sin", "");
    expect_mistake("atan2 + 1", "atan2 is a function; write atan2(y, x)", "atan2", "");
    expect_mistake("(1 + 2", "missing ')' for '('", "(", "");
    expect_mistake("2*sin(1 + 2", "missing ')' for 'sin('", "sin(", "");
    expect_mistake("(1, 2)", "missing ')' for '('", "(", "");
    expect_mistake("(5 foo)", "unknown unit 'foo'", "foo", "");
    expect_mistake("(5 foo bar)", "missing ')' for '('", "(", "'foo' is not a unit");
    expect_mistake("5 + 1 cm",
                   "'5' (number) and '1 cm' (length) do not add: a unit belongs to the number "
                   "before it",
                   "5 + 1 cm", "write (5 + 1) cm, or 5 m + 1 cm");
    expect_mistake("1 cm + 5",
                   "'1 cm' (length) and '5' (number) do not add: a unit belongs to the number "
                   "before it",
                   "1 cm + 5", "write 1 cm + 5 cm");
    expect_mistake("2^3 cm", "an exponent needs a number, not '3 cm' (length)", "3 cm",
                   "this means 2^(3 cm); if you mean (2^3) cm, write the parentheses");
    expect_mistake("y cm", "a unit may follow a number or a parenthesis, not 'y'", "cm", "(y) cm");
    expect_mistake("(5 cm) mm", "a value has one unit: '(5 cm)' has cm", "mm", "");
    expect_mistake("5 kg/m", "unknown unit 'kg/m': kg is one", "kg/m", "put blanks around it");
    expect_mistake("5 N / m", "the unit N/m is written without blanks", "N / m", "");
    expect_mistake("2 cm^3", "unknown unit 'cm^3': cm is one", "cm^3", "(2 cm)^3");
    expect_mistake("2 cm ^ 3", "unknown unit 'cm^3': cm is one", "cm ^ 3", "(2 cm)^3");
    expect_mistake("2 cm^(3)", "unknown unit 'cm^': cm is one", "cm^", "(2 cm)^");
    expect_mistake("9.81 m/s2", "unknown unit 'm/s2'", "m/s2", "the unit is written m/s^2");
    expect_mistake("sin(3 cm)", "sin needs a number, not '3 cm' (length)", "3 cm", "");
    expect_mistake("sin()", "sin takes 1 argument", "sin()", "");
    expect_mistake("2 + sin(1, 2) + 3", "sin takes 1 argument", "sin(1,", "");
    expect_mistake("hypot(1)", "hypot takes 2 arguments", "hypot(1)", "");
    expect_mistake("sin(5,3)", "sin takes 1 argument", "sin(5,", "");
    expect_mistake("", "a number or a name is missing", "", "");
    expect_mistake("1 +", "a number or a name is missing after '+'", "", "");
    expect_mistake("1 + * 2", "a number or a name is missing after '+'", "*", "");
    expect_mistake("2 ** 3", "a number or a name is missing after '*'", "*",
                   "write powers with ^, as in 2^3");
    expect_mistake("3 * )", "a number or a name is missing after '*'", ")", "");
    expect_mistake("()", "a number or a name is missing after '('", ")", "");
    expect_mistake("max(1,)", "a number or a name is missing after 'max('", ")", "");
    expect_mistake("+-3", "a number or a name is missing", "+", "");
    expect_mistake("(1 < y < 3)", "comparisons do not chain: for a < b < c write (a < b)*(b < c)",
                   "<", "");
    expect_mistake("if(1 < 2 >= 3, 4, 5)",
                   "comparisons do not chain: for a < b < c write (a < b)*(b < c)", ">=", "");
    expect_mistake("(y <)", "a number or a name is missing after '<'", ")", "");
    expect_mistake("-", "a number or a name is missing after '-'", "", "");
    expect_mistake(".", "malformed number", ".", "");
    expect_mistake("1e400", "the number 1e400 is too large", "1e400", "");
    expect_mistake("\xff", "a number or a name is missing", "\xff", "");
    expect_mistake("2*\xe2\x88\x92x", "a number or a name is missing after '*'", "\xe2",
                   "write names and signs in ASCII: - * / and a to z");
}

TEST(test_constants)
{
    struct arena arena = {0};
    struct error error;
    size_t used;
    const struct expr *expr = expr_compile(TEXT("2*pi/sqrt(4)"), NULL, &arena, &used, &error);
    assert_non_null(expr);
    assert_true(expr_value(expr, NULL) == 3.14159265358979323846);
    assert_null(expr_compile(TEXT("y"), NULL, &arena, &used, &error));
    arena_reset(&arena);
}

/* ---- random expressions: this writer knows their value ---- */

struct valued {
    double value;
    int precedence; /* 1 sum, 2 product, 3 sign, 4 power, 5 whole */
};

static void put(struct buffer *out, const char *z)
{
    buffer_put(out, text_of(z));
}

/* Appends an operand, in parentheses where it binds less tightly than `min`. */
static double write_expr(struct buffer *out, uint64_t *seed, int depth, int min);

static struct valued write_bare(struct buffer *out, uint64_t *seed, int depth)
{
    int kind = depth == 0 ? (int)random_between(seed, 0, 2) : (int)random_between(seed, 0, 10);
    double a, b;
    if (kind == 0) {
        a = floor(random_between(seed, 0, 100)) / 8;
        buffer_real(out, a);
        return (struct valued){a, 5};
    }
    if (kind == 1) {
        size_t i = (size_t)random_between(seed, 0, 5);
        put(out, names[i].name);
        return (struct valued){names[i].value, 5};
    }
    if (kind == 2) {
        put(out, "-");
        return (struct valued){-write_expr(out, seed, depth - 1, 3), 3};
    }
    if (kind == 3) {
        put(out, "max(");
        a = write_expr(out, seed, depth - 1, 1);
        put(out, ",");
        b = write_expr(out, seed, depth - 1, 1);
        put(out, ")");
        return (struct valued){a > b || isnan(a) ? a : b, 5};
    }
    static const char *const signs[] = {" + ", " - ", "*", " /", "^ "};
    static const int precedence[] = {1, 1, 2, 2, 4};
    int op = (kind - 4) % 5, own = precedence[op];
    a = write_expr(out, seed, depth - 1, op == 4 ? 5 : own);
    put(out, signs[op]);
    b = write_expr(out, seed, depth - 1, op == 4 ? 3 : own + 1);
    double values[] = {a + b, a - b, a * b, a / b, short_power(a, b)};
    return (struct valued){values[op], own};
}

static double write_expr(struct buffer *out, uint64_t *seed, int depth, int min)
{
    struct buffer inner = {0};
    struct valued made = write_bare(&inner, seed, depth);
    bool wrap = made.precedence < min;
    put(out, wrap ? "( " : "");
    buffer_put(out, buffer_text(&inner));
    put(out, wrap ? ")" : "");
    buffer_free(&inner);
    return made.value;
}

TEST(test_random_expressions)
{
    uint64_t seed = 6;
    int finite = 0, rounds = is_long() ? 200000 : 5000;
    for (int i = 0; i < rounds; i++) {
        struct buffer source = {0};
        size_t used = 0;
        double wanted = write_expr(&source, &seed, 1 + i % 6, 1),
               value = value_of(source.data, &used);
        if (memcmp(&value, &wanted, sizeof value) != 0 && !(isnan(value) && isnan(wanted)))
            fail_msg("'%s' = %.17g, wanted %.17g", source.data, value, wanted);
        assert_int_equal(used, source.len);
        finite += isfinite(wanted);
        buffer_free(&source);
    }
    assert_true(finite > rounds / 2);
}

/* ---- hostile input ---- */

/* `unit` over and over until `size` bytes, between a beginning and an end. */
static void expect_quick(const char *begin, const char *unit, size_t size, const char *end,
                         const char *sentence)
{
    struct buffer source = {0};
    put(&source, begin);
    while (source.len < size)
        put(&source, unit);
    put(&source, end);
    assert_false(source.failed);
    struct arena arena = {0};
    struct error error = {0};
    size_t used;
    int64_t start = cpu_ns();
    const struct expr *expr = expr_compile(buffer_text(&source), &scope, &arena, &used, &error);
    double seconds = 1e-9 * (double)(cpu_ns() - start);
    if (sentence && (expr || !strstr(error.text, sentence)))
        fail_msg("'%s...' says '%s', wanted '%s'", unit, expr ? "fine" : error.text, sentence);
    if (!sentence && !expr)
        fail_msg("'%s...' says '%s'", unit, error.text);
    if (seconds > 0.5) /* a sanitizer on a busy machine; ordinarily milliseconds */
        fail_msg("'%s...' took %g s", unit, seconds);
    arena_reset(&arena);
    buffer_free(&source);
}

TEST(test_hostile)
{
    expect_quick("", "(", 1000000, "", "nested deeper than 200");
    expect_quick("", "-", 1000000, "", "nested deeper than 200");
    expect_quick("", "sin(", 1000000, "", "nested deeper than 200");
    expect_quick("", "2^", 1000000, "2", "nested deeper than 200");
    expect_quick("", "max(1,", 1000000, "", "nested deeper than 200");
    expect_quick("", "y+(", 1000000, "", "nested deeper than 200");
    expect_quick("", "1+", 65536, "1", NULL); /* folds to one number */
    expect_quick("", "y+", 65536, "1", "more than 4096 operations");
    expect_quick("", "y-", 65536, "y", "more than 4096 operations");
    expect_quick("", "y-y", 65536, "", "unknown name");
    expect_quick("", "a", 1000000, "", "unknown name");
    expect_quick("", "a-", 1000000, "b", "unknown name");
    expect_quick("", "aa-bb_", 1000000, "b", "unknown name");
    expect_quick("", "7", 1000000, "", "too large");
    expect_quick("(", "(1<1)+", 65536, "1)", NULL);
    expect_quick("(", "1<", 65536, "1)", "do not chain");
    expect_quick("", "max(1,1)+", 65536, "1", NULL);
    expect_quick("1", ")", 1000000, "", NULL);
    expect_quick("max(", "1,", 1000000, "1)", "max takes 2 arguments");
    expect_quick("", "\xc3\xa9", 65536, "", "missing");
    expect_quick("", " ", 1000000, "", "missing");
}

TEST(test_depth_limit_is_sharp)
{
    char whole[2000] = "";
    for (int i = 0; i < 150; i++) /* fewer levels than the limit, but two values wait in each */
        memcpy(whole + 7 * i, "if(y,y,", 8);
    memset(whole + 7 * 150, ')', 151);
    whole[7 * 150] = 'y';
    expect_quick(whole, "+y", sizeof whole, "", "nested deeper than 200");
    for (int levels = LIMIT_EXPR_DEPTH - 1; levels <= LIMIT_EXPR_DEPTH + 1; levels++) {
        struct buffer source = {0};
        for (int i = 0; i < levels; i++)
            put(&source, "(");
        put(&source, "y");
        for (int i = 0; i < levels; i++)
            put(&source, ")");
        struct arena arena = {0};
        struct error error;
        size_t used;
        const struct expr *expr = expr_compile(buffer_text(&source), &scope, &arena, &used, &error);
        assert_true((expr != NULL) == (levels <= LIMIT_EXPR_DEPTH));
        arena_reset(&arena);
        buffer_free(&source);
    }
}

TEST(test_function_table)
{
    /* Each brief begins with the call, which compiles with that many arguments. */
    for (size_t i = 0; i < function_catalog.count; i++) {
        const struct row *row = catalog_row(&function_catalog, i);
        struct buffer source = {0};
        buffer_format(&source, "%s(", row->name);
        assert_true(text_starts(text_of(row->brief), buffer_text(&source)));
        put(&source, "1");
        for (const char *z = row->brief; *z != ':'; z++)
            if (*z == ',')
                put(&source, ",1");
        put(&source, ")");
        size_t used;
        (void)value_of(source.data, &used);
        assert_int_equal(used, source.len);
        buffer_free(&source);
    }
}

RUN_TESTS(NULL, NULL)
