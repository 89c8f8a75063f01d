/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs some of whose names are given: what depends on these only is computed once, and changes
 * no bit. */
#include "numerics/scene/trees.h"
#include "scene/formula/program/program.h"

/* Evaluates the same program on many lanes at once: defined by tests of the module that has them.
 */
#ifndef GIVEN_LANES
#define GIVEN_LANES(program, input, first, steady, wanted)
#endif

enum { OUTPUTS = 4, GIVEN = 3 * NAMES, UNUSED_PLACES = 2 };

static struct program *given_program(const struct equations *equations, int count, int first,
                                     int max, bool native)
{
    const struct steady_names steady = {first, NAMES - first + UNUSED_PLACES, max};
    struct error error = {0};
    struct program *program =
        program_create_keeping(equations, 0, count, NULL, NULL, &steady, native, &error);
    if (!program)
        fail_msg("%s", error.text);
    return program;
}

/* input [NAMES]; the same with all names moving is `wanted`. */
static void compare(const struct program *program, const double *input, int first,
                    const double *wanted, const char *text)
{
    double steady[GIVEN + 64], output[OUTPUTS], *frame = room_of(program_frame(program));
    assert_true(program->names <= first + (int)COUNT_OF(steady));
    memset(steady, 0xFF, sizeof steady);
    memcpy(steady, input + first, (size_t)(NAMES - first) * sizeof *steady);
    program_keep(program, steady);
    program_prepare(program, frame);
    program_run(program, input[0], input + 1, steady, output, frame);
    for (int i = 0; i < program->outputs; i++)
        if (!same(output[i], wanted[i]))
            fail_msg("%s: output %d from name %d on given: %.17g, wanted %.17g", text, i, first,
                     output[i], wanted[i]);
    free(frame);
    GIVEN_LANES(program, input, first, steady, wanted);
}

static double any_value(struct forest *f)
{
    static const double special[] = {0, -0.0, 1, -1, 2, 0.5, 1e200, 1e-200, INFINITY, NAN};
    return pick(f, 4) ? random_between(&f->seed, -3, 3) : special[pick(f, (int)COUNT_OF(special))];
}

TEST(test_random_expressions)
{
    static struct forest f;
    f.seed = 77;
    const int rounds = is_long() ? 200000 : 5000;
    int kept = 0;
    for (int round = 0; round < rounds; round++) {
        struct buffer text[OUTPUTS] = {{0}};
        const char *texts[OUTPUTS];
        double input[NAMES], wanted[OUTPUTS];
        const int outputs = 1 + pick(&f, OUTPUTS), first = 1 + pick(&f, NAMES - 1);
        for (int i = 0; i < outputs; i++) {
            f.count = 0;
            write_tree(&text[i], grow(&f, 1 + round % 5));
            texts[i] = text[i].data;
        }
        for (int i = 0; i < NAMES; i++)
            input[i] = any_value(&f);
        struct equations *equations = equations_of(texts, outputs);
        struct program *plain = program_of(equations, 0, outputs, NULL, NULL, false);
        evaluate(plain, input, wanted);
        for (int way = 0; way < 4; way++) {
            struct program *program =
                given_program(equations, outputs, first, way & 2 ? 40 : 1, way & 1);
            compare(program, input, first, wanted, texts[0]);
            kept += program->keeps;
            assert_true(program_operations(program) <= program_operations(plain));
            program_destroy(program);
        }
        program_destroy(plain);
        equations_destroy(equations);
        for (int i = 0; i < outputs; i++)
            buffer_free(&text[i]);
    }
    assert_true(kept > rounds);
}

/* What is kept and what remains. */
TEST(test_what_is_kept)
{
    static const char *const text[] = {"-d/e*a - 2*sqrt(d/e)*f*b", "sin(f) + 3*d"};
    struct equations *equations = equations_of(text, 2);
    struct program *program = given_program(equations, 2, 3, 8, false);
    assert_int_equal(program->keeps, 3); /* -d/e or d/e, the damping, the whole second output */
    assert_int_equal(program_operations(program), 2); /* two products and their difference */
    assert_true(program_depends(program, 0, 1, 3) && program_depends_on(program, 1, 1, 3, 3));
    assert_false(program_depends_on(program, 1, 1, 0, 3));
    program_destroy(program);
    program = given_program(equations, 2, 3, 2, false); /* no room: nothing is kept */
    assert_int_equal(program->keeps, 0);
    program_destroy(program);
    equations_destroy(equations);
}

RUN_TESTS(NULL, NULL)
