/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Programs: random expressions in all forms against an evaluator of this file's own, bit for bit;
 * sharing, binding, limits.
 */
#include "numerics/scene/trees.h"
#include <hooke/base/numeric.h>
#include "unit/cpu_time.h"

/* What a 0 is: a number, a known name, a term whose coefficient is 0. */
enum { OF_NUMBER, OF_NAME, OF_TERM };

struct worth {
    double value;
    bool known; /* depends on no input */
    int zero;   /* of a known 0 */
};

static const struct worth absent = {0, true, OF_TERM};

static int smaller_of(int a, int b)
{
    return a < b ? a : b;
}

/* What the 0 is that known operands give. */
static int zero_of(enum kind kind, const struct worth *x)
{
    if (kind == NEG || kind == DIV)
        return x[0].zero;
    if (kind == MUL)
        return x[0].zero + x[1].zero - smaller_of(x[0].zero, x[1].zero);
    return kind == ADD || kind == SUB ? smaller_of(x[0].zero, x[1].zero) : OF_NUMBER;
}

/* As documented: with all operands known ordinary arithmetic, else what is multiplied by a known 0
 * is absent, as is what a known name that is 0 is divided by. */
static struct worth worth_of(const struct tree *t, const bool *bound, const double *value)
{
    struct worth x[3] = {{0}};
    if (t->kind == NUMBER)
        return (struct worth){t->number, true, OF_NUMBER};
    if (t->kind == NAME)
        return (struct worth){value[t->which], bound[t->which],
                              bound[t->which] && value[t->which] == 0 ? OF_NAME : OF_NUMBER};
    int count = 0;
    bool known = true;
    for (; count < 3 && t->x[count]; count++) {
        x[count] = worth_of(t->x[count], bound, value);
        known = known && x[count].known;
    }
    const double a = x[0].value, b = x[1].value;
    const double result = t->kind == NEG   ? -a
                          : t->kind == ADD ? a + b
                          : t->kind == SUB ? a - b
                          : t->kind == MUL ? a * b
                                           : a / b;
    const bool sums = t->kind == ADD || t->kind == SUB;
    /* a known 0 */
    const bool first = x[0].known && a == 0, second = count > 1 && x[1].known && b == 0;
    if (!known && sums && x[1].zero == OF_TERM)
        return x[0];
    if (!known && sums && x[0].zero == OF_TERM)
        return t->kind == ADD ? x[1] : (struct worth){-b, false, OF_NUMBER};
    if (!known && t->kind == MUL && (first || second))
        return absent;
    if (!known && t->kind == DIV && first && x[0].zero != OF_NUMBER)
        return absent;
    switch (t->kind) {
    case NEG:
    case ADD:
    case SUB:
    case MUL:
    case DIV:
        return (struct worth){result, known,
                              known && result == 0 ? zero_of(t->kind, x) : OF_NUMBER};
    case LESS:
        return (struct worth){isnan(a) || isnan(b) ? NAN : a < b, known, OF_NUMBER};
    case GREATER:
        return (struct worth){isnan(a) || isnan(b) ? NAN : a > b, known, OF_NUMBER};
    case LESS_EQUAL:
        return (struct worth){isnan(a) || isnan(b) ? NAN : a <= b, known, OF_NUMBER};
    case GREATER_EQUAL:
        return (struct worth){isnan(a) || isnan(b) ? NAN : a >= b, known, OF_NUMBER};
    default:
        break;
    }
    const bool power = t->kind == POW || t->which == POW_CALL;
    if (power)
        return second ? (struct worth){1, true, OF_NUMBER}
                      : (struct worth){short_power(a, b), known, OF_NUMBER};
    if (t->which == IF && x[0].known && !known)
        return isnan(a) ? x[0] : a > 0 ? x[1] : x[2];
    if (t->which == IF && known)
        return (struct worth){isnan(a) ? NAN : a > 0 ? b : x[2].value, true, OF_NUMBER};
    if (t->which == IF)
        return (struct worth){isnan(a) ? NAN : a > 0 ? b : x[2].value, false, OF_NUMBER};
    return (struct worth){call_value(t->which, (double[]){a, b}), known, OF_NUMBER};
}

static double random_value(struct forest *f)
{
    static const double special[] = {0, -0.0, 1, -1, 2, 0.5, 1e200, 1e-200, INFINITY, NAN};
    return pick(f, 4) ? random_between(&f->seed, -3, 3) : special[pick(f, (int)COUNT_OF(special))];
}

static double load_name(const void *context, int slot)
{
    return ((const double *)context)[slot];
}

/* What is observed is what print says of the expression. */
static void expect_ieee(const char *text, const double *x, double output)
{
    struct arena arena = {0};
    const struct expr_scope loaded = {.context = x, .load = load_name};
    const double wanted = expr_value(compiled(text, &arena), &loaded);
    if (!same(output, wanted))
        fail_msg("%s is observed as %.17g, printed as %.17g", text, output, wanted);
    arena_reset(&arena);
}

TEST(test_random_expressions)
{
    static struct forest f;
    f.seed = 2026;
    enum { POINTS = 5 };
    const int rounds = is_long() ? 1000000 : 5000;
    int finite = 0;
    for (int round = 0; round < rounds; round++) {
        struct buffer text = {0};
        bool bound[NAMES];
        double input[POINTS][NAMES], output[POINTS];
        f.count = 0;
        const struct tree *tree = grow(&f, 1 + round % 6);
        write_tree(&text, tree);
        for (int j = 0; j < NAMES; j++) {
            bound[j] = pick(&f, 3) == 0;
            const double value = random_value(&f);
            for (int k = 0; k < POINTS; k++)
                input[k][j] = bound[j] ? value : random_value(&f);
        }
        struct equations *equations = equations_of((const char *const[]){text.data}, 1);
        evaluate_all(equations, 0, 1, bound, input[0], input[0], POINTS, output);
        for (int k = 0; k < POINTS; k++) {
            const double wanted = worth_of(tree, bound, input[k]).value;
            if (!same(output[k], wanted))
                fail_msg("%s = %.17g, wanted %.17g (round %d)", text.data, output[k], wanted,
                         round);
            finite += isfinite(wanted);
        }
        equations_exact(equations, true);
        evaluate_all(equations, 0, 1, bound, input[0], input[0], POINTS, output);
        for (int k = 0; k < POINTS; k++)
            expect_ieee(text.data, input[k], output[k]);
        equations_destroy(equations);
        buffer_free(&text);
    }
    assert_true(finite > rounds * POINTS / 2);
}

/* ---- what is promised in words ---- */

static double value_of(const char *text, const bool *bound, const double *x)
{
    double output;
    struct equations *equations = equations_of(&text, 1);
    evaluate_all(equations, 0, 1, bound, x, x, 1, &output);
    equations_destroy(equations);
    return output;
}

TEST(test_absent_terms)
{
    static const bool first[NAMES] = {true}; /* a is known */
    const double x[NAMES] = {0, INFINITY, NAN, -0.0, -1, 4};
    static const struct {
        const char *text;
        double value;
    } cases[] = {{"a*b", 0},         {"f + a*c", 4},
                 {"c*a - f", -4},    {"a/c", 0},
                 {"a*c + d", -0.0},  {"d - a*c", -0.0},
                 {"0/c", NAN},       {"1/(a - d)", INFINITY},
                 {"d + a", 0},       {"2/(0 - d)", INFINITY},
                 {"(1 - 1)*c", 0},   {"(a - 0)*sqrt(e) + 1", 1},
                 {"d*b", NAN},       {"f*0*b", 0},
                 {"c^a", 1},         {"if(a, c, 2)", 2},
                 {"if(1, f, c)", 4}, {"min(a, f)*c", NAN},
                 {"min(a, 3)*c", 0}, {"(f < a)*3", 0},
                 {"(e < f)*3", 3},   {"if(e < a, 5, 6)", 5},
                 {"(c < f)", NAN},   {"(f >= 4) + (f > 4)", 1},
                 {"mod(-1, f)", 3},  {"mod(7, -f)", -1},
                 {"f^-0.5", 0.5},    {"f^1.5", 8}};
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        if (!same(value_of(cases[i].text, first, x), cases[i].value))
            fail_msg("%s = %g, wanted %g", cases[i].text, value_of(cases[i].text, first, x),
                     cases[i].value);
}

TEST(test_sharing)
{
    /* Two bodies under an inverse square law: the cube of the distance is computed once for both.
     */
    static const char *const text[] = {"-c*a/(a^2 + b^2)^1.5", "-c*b/(b^2 + a^2)^1.5", "a^2 + b^2"};
    struct equations *equations = equations_of(text, 3);
    const double x[NAMES] = {0.6, 0.8, 2};
    const bool bound[NAMES] = {[2] = true};
    double output[3];
    evaluate_all(equations, 0, 3, bound, x, x, 1, output);
    assert_true(fabs(output[0] + 1.2) < 1e-15 && fabs(output[1] + 1.6) < 1e-15);
    struct program *one = program_of(equations, 0, 1, bound, x, false),
                   *all = program_of(equations, 0, 3, bound, x, false);
    /* b^2, a^2 + b^2, root, cube, -c a, quotient; two more for the second body, none for the third
     * output. */
    assert_int_equal(program_operations(one), 6);
    assert_int_equal(program_operations(all), 8);
    assert_true(program_depends(all, 0, 2, 1) && program_depends(all, 2, 1, 0));
    assert_false(program_depends(all, 0, 3, 2) || program_depends(all, 0, 3, 3));
    program_destroy(one);
    program_destroy(all);
    equations_destroy(equations);
}

TEST(test_linear_and_separable)
{
    /* a: position, b: velocity, c: damping; the derivatives say what kind of scene it is. */
    static const char *const text[] = {"-4*a - c*b"};
    struct equations *equations = equations_of(text, 1);
    struct error error;
    double x[NAMES] = {0}, value;
    const bool bound[NAMES] = {[2] = true};
    assert_true(equations_derive(equations, 0, 1, (const int[]){0, 1, 2}, 3, &error));
    struct program *separable = program_of(equations, 0, 4, bound, x, true);
    assert_false(program_depends(separable, 0, 1, 1));
    assert_true(program_constant(separable, 1, &value) && value == -4);
    assert_true(program_constant(separable, 2, &value) && value == 0);
    assert_false(program_constant(separable, 3, &value)); /* -b */
    x[2] = 0.5;
    struct program *damped = program_of(equations, 0, 4, bound, x, true);
    assert_true(program_depends(damped, 0, 1, 1));
    assert_true(program_constant(damped, 2, &value) && value == -0.5);
    program_destroy(separable);
    program_destroy(damped);
    equations_destroy(equations);
}

TEST(test_definitions)
{
    struct arena arena = {0};
    struct error error;
    struct equations *equations = equations_create(NAMES, &error);
    assert_true(equations_let(equations, 5, compiled("a^2 + b", &arena), &error));
    assert_true(equations_let(equations, 4, compiled("2*f", &arena), &error));
    assert_true(equations_add(equations, compiled("e*f - a", &arena), &error));
    assert_true(equations_derive(equations, 0, 1, (const int[]){0, 5}, 2, &error));
    const double x[NAMES] = {3, 1, 0, 0, 100, 100};
    double output[3];
    evaluate_all(equations, 0, 3, NULL, NULL, x, 1, output);
    assert_true(output[0] == 2 * 10 * 10 - 3 && output[1] == 4 * 10 * 6 - 1 && output[2] == 0);
    equations_destroy(equations);
    arena_reset(&arena);
}

/* More values alive at once than there are registers, and calls in between. */
TEST(test_many_values)
{
    struct buffer text = {0};
    for (int i = 0; i < 60; i++)
        buffer_format(&text, "(%d.5*a + b*%d)*", i + 1, 60 - i);
    buffer_put(&text, TEXT("sin(c"));
    for (int i = 0; i < 60; i++)
        buffer_format(&text, " - (%d.5*a + b*%d)", i + 1, 60 - i);
    buffer_char(&text, ')');
    const double x[NAMES] = {0.01, 0.007, 0.3};
    struct arena arena = {0};
    double product = 1, sum = 0.3, sine;
    for (int i = 0; i < 60; i++) {
        const double term = (i + 1.5) * x[0] + x[1] * (60 - i);
        product = i ? product * term : term;
        sum -= term;
    }
    sine = product * fixed_sin(sum);
    assert_true(same(value_of(text.data, NULL, x), sine));
    buffer_free(&text);
    arena_reset(&arena);
}

/* As large as an expression may be, all its derivatives, and equations beyond what is allowed:
 * quick, or refused. */
TEST(test_limits)
{
    struct buffer text = {0};
    struct arena arena = {0};
    struct error error = {0};
    for (int i = 0; i < 580; i++) /* 4059 operations */
        buffer_format(&text, "%ssin(%d*a)*%c", i ? "+" : "", i + 2, 'b' + i % 5);
    const struct expr *expr = compiled(text.data, &arena);
    int64_t start = cpu_ns();
    struct equations *equations = equations_create(NAMES, &error);
    assert_true(equations_add(equations, expr, &error));
    assert_true(equations_derive(equations, 0, 1, (const int[]){0, 1, 2, 3, 4, 5}, 6, &error));
    struct program *program = program_of(equations, 0, 7, NULL, NULL, true);
    const double seconds = 1e-9 * (double)(cpu_ns() - start);
    print_message("4000 operations and 6 derivatives: %.2f ms\n", 1e3 * seconds);
    assert_true(seconds < 0.5);
    program_destroy(program);
    /* Products of ever more factors: derivatives of derivatives grow without end. */
    bool refused = false;
    start = cpu_ns();
    for (int order = 0, first = 1, count = 6; order < 9 && !refused;
         order++, first += count, count *= 6)
        refused =
            !equations_derive(equations, first, count, (const int[]){0, 1, 2, 3, 4, 5}, 6, &error);
    assert_true(refused && strstr(error.text, "more than"));
    assert_true(1e-9 * (double)(cpu_ns() - start) < 5);
    equations_destroy(equations);
    buffer_free(&text);
    arena_reset(&arena);
}

TEST(test_machine_code_is_there)
{
    struct equations *equations = equations_of((const char *const[]){"a + 1"}, 1);
    struct program *program = program_of(equations, 0, 1, NULL, NULL, true);
#if defined(__x86_64__) && defined(__linux__)
    if (!program_native(program)) {
        print_message("this system does not let a program make code\n");
        program_destroy(program);
        equations_destroy(equations);
        skip();
    }
#else
    assert_false(program_native(program));
#endif
    program_destroy(program);
    equations_destroy(equations);
}

/* Machine code remembers calls whose argument depends on the first name only: their bits are those
 * of the other form, whatever came before. */
TEST(test_remembered_calls)
{
    static const char *const text[] = {
        "b*sin(a) + cos(2*a)^2 + exp(-a^2)", "tan(a) + atan(a)*b", "sinh(a) + cosh(a)*c + tanh(a)",
        "log(abs(a)) + sin(3*a) + sin(4*a) + sin(5*a)", "sin(a*b) + sin(-a)"};
    enum { OUTPUTS = COUNT_OF(text), FRAME_MOST = 200 };
    static const double first[] = {0, -0.0, 0, 1, 1, NAN, NAN, 1, -1, INFINITY, 2, 2, 1e-300};
    struct equations *equations = equations_of(text, OUTPUTS);
    struct program *form[] = {program_of(equations, 0, OUTPUTS, NULL, NULL, false),
                              program_of(equations, 0, OUTPUTS, NULL, NULL, true)};
    double frame[2][FRAME_MOST], output[2][OUTPUTS];
    uint64_t random = 1;
    for (int k = 0; k < 2; k++) {
        assert_true(program_frame(form[k]) <= FRAME_MOST);
        program_prepare(form[k], frame[k]);
    }
    for (int i = 0; i < 10000; i++) {
        const double x[NAMES] = {
            first[(size_t)(random_fraction(&random) * (double)COUNT_OF(first))],
            random_fraction(&random), random_fraction(&random)};
        for (int k = 0; k < 2; k++)
            program_eval(form[k], x, output[k], frame[k]);
        for (int j = 0; j < OUTPUTS; j++)
            if (!(isnan(output[0][j]) && isnan(output[1][j])) &&
                memcmp(&output[0][j], &output[1][j], sizeof output[0][j]) != 0)
                fail_msg("%s at a = %g: %.17g, not %.17g", text[j], x[0], output[1][j],
                         output[0][j]);
    }
    program_destroy(form[0]);
    program_destroy(form[1]);
    equations_destroy(equations);
}

RUN_TESTS(NULL, NULL)
