/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Each allocation on the way from text to program fails once, and from there for ever: an error, or
 * a right result. */
#include "unit/scene/testing.h"

#include "faults/failing_malloc.h"

#include <stdlib.h>

enum { NAMES = 2 };

static bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = text_is(name, "x") ? 0 : text_is(name, "k") ? 1 : -1;
    return *slot >= 0;
}

/* Enough for the graph to grow several times. */
static const char source[] =
    "k*(sin(x)*exp(x) - cos(x)/(1 + x^2) + hypot(x, 3)*tanh(x)^3 + min(x, k)*atan2(x, 2)"
    " + asin(x/5)*log(x + 2)*sqrt(x + 1)*cbrt(x + 7)*abs(x - 1) + mod(x, 3)^2.5)";

static bool whole_way(double *output, struct error *error)
{
    struct arena arena = {0};
    size_t used;
    const double value[NAMES] = {0.7, 2};
    const bool bound[NAMES] = {false, true};
    const struct expr_scope scope = {.find = find};
    struct equations *equations = NULL;
    struct program *program = NULL;
    const struct expr *expr = expr_compile(text_of(source), &scope, &arena, &used, error);
    if (expr)
        equations = equations_create(NAMES, error);
    if (equations && equations_let(equations, 1, expr, error) &&
        equations_add(equations, expr, error) &&
        equations_derive(equations, 0, 1, (const int[]){0, 1}, 2, error) &&
        equations_derive(equations, 1, 1, (const int[]){0}, 1, error))
        program = program_create(equations, 0, 4, bound, value, true, error);
    double frame[200];
    if (program) {
        assert_true(program_frame(program) <= COUNT_OF(frame));
        program_prepare(program, frame);
        assert_true(program_eval(program, value, output, frame) == output[0]);
    }
    const bool done = program;
    program_destroy(program);
    equations_destroy(equations);
    arena_reset(&arena);
    return done;
}

TEST(test_each_allocation)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    struct error error = {0};
    double right[4], output[4];
    malloc_calls = 0;
    assert_true(whole_way(right, &error));
    const long calls = malloc_calls;
    assert_true(calls > 10);
    for (long i = 0; i < 2 * calls; i++) {
        malloc_calls = 0;
        malloc_fail_for_ever = i >= calls;
        malloc_fail_at = i % calls;
        error.code = ERROR_NONE;
        const bool done = whole_way(output, &error);
        malloc_fail_at = -1;
        if (done) /* without machine code */
            assert_memory_equal(output, right, sizeof right);
        else
            assert_true(error.code == ERROR_COMMAND || error.code == ERROR_NUMERICAL ||
                        error.code == ERROR_IO);
    }
}

/* Evaluation never allocates. */
TEST(test_evaluation)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    struct arena arena = {0};
    struct error error;
    size_t used;
    const struct expr_scope scope = {.find = find};
    struct equations *equations = equations_create(NAMES, &error);
    assert_true(equations_add(
        equations, expr_compile(text_of(source), &scope, &arena, &used, &error), &error));
    struct program *program = program_create(equations, 0, 1, NULL, NULL, false, &error);
    assert_non_null(program);
    double *frame = malloc(program_frame(program) * sizeof *frame), input[NAMES], output[1];
    assert_non_null(frame);
    malloc_calls = 0;
    for (size_t i = 0; i < COUNT_OF(input); i++)
        input[i] = 0.5;
    program_prepare(program, frame);
    program_eval(program, input, output, frame);
    assert_int_equal(malloc_calls, 0);
    free(frame);
    program_destroy(program);
    equations_destroy(equations);
    arena_reset(&arena);
}

RUN_TESTS(NULL, NULL)
