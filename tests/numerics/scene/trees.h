/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the tests of programs share: names, programs in all forms, random expressions. */
#pragma once

#include <hooke/base/number.h>
#include "hooke/base/elementary.h"
#include "long_form.h"
#include "unit/scene/testing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- names: a b c … ---- */

enum { NAMES = 6 };

static inline bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = name.len == 1 && name.data[0] >= 'a' && name.data[0] < 'a' + NAMES ? name.data[0] - 'a'
                                                                               : -1;
    return *slot >= 0;
}

static inline const struct expr *compiled(const char *text, struct arena *arena)
{
    struct expr_scope scope = {.find = find};
    struct error error = {0};
    size_t used = 0;
    const struct expr *expr = expr_compile(text_of(text), &scope, arena, &used, &error);
    if (!expr || used != strlen(text))
        fail_msg("%s: %s", text, error.text);
    return expr;
}

static inline bool same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

/* ---- programs in all forms ---- */

static inline struct equations *equations_of(const char *const *text, int count)
{
    struct arena arena = {0};
    struct error error = {0};
    struct equations *equations = equations_create(NAMES, &error);
    assert_non_null(equations);
    for (int i = 0; i < count; i++)
        if (!equations_add(equations, compiled(text[i], &arena), &error))
            fail_msg("%s: %s", text[i], error.text);
    arena_reset(&arena);
    return equations;
}

static inline struct program *program_of(const struct equations *equations, int first, int count,
                                         const bool *bound, const double *value, bool native)
{
    struct error error = {0};
    struct program *program = program_create(equations, first, count, bound, value, native, &error);
    if (!program)
        fail_msg("%s", error.text);
    return program;
}

/* NaN: what was not set is seen. */
static inline double *room_of(size_t count)
{
    double *capacity = aligned_alloc(64, (count * sizeof *capacity + 64) / 64 * 64);
    assert_non_null(capacity);
    memset(capacity, 0xFF, count * sizeof *capacity);
    return capacity;
}

static inline void evaluate(const struct program *program, const double *input, double *output)
{
    double *frame = room_of(program_frame(program));
    program_prepare(program, frame);
    program_eval(program, input, output, frame);
    free(frame);
}

/* Compares the outputs with those of many lanes at once, where there are some: tests of the module
 * that has them define it before this file. */
#ifndef COMPARE_LANES
#define COMPARE_LANES(program, input, count, output)
#endif

/* The outputs of all forms, which must agree. input [count][NAMES], output [count][outputs], count
 * at most lanes. */
static inline void evaluate_all(const struct equations *equations, int first, int outputs,
                                const bool *bound, const double *value, const double *input,
                                int count, double *output)
{
    struct program *registers = program_of(equations, first, outputs, bound, value, false);
    struct program *native = program_of(equations, first, outputs, bound, value, true);
    double *row = room_of((size_t)outputs);
    for (int k = 0; k < count; k++) {
        evaluate(registers, input + k * NAMES, output + k * outputs);
        evaluate(native, input + k * NAMES, row);
        for (int i = 0; i < outputs; i++) {
            if (!same(output[k * outputs + i], row[i]))
                fail_msg("output %d: %.17g, as machine code %.17g", i, output[k * outputs + i],
                         row[i]);
        }
    }
    COMPARE_LANES(registers, input, count, output);
    free(row);
    program_destroy(registers);
    program_destroy(native);
}

/* ---- random trees, which know what they are worth ---- */

enum kind {
    NUMBER,
    NAME,
    NEG,
    ADD,
    SUB,
    MUL,
    DIV,
    POW,
    LESS,
    GREATER,
    LESS_EQUAL,
    GREATER_EQUAL,
    CALL
};

static inline double own_min(double a, double b)
{
    return isnan(a) || isnan(b) ? NAN : a < b ? a : b;
}

static inline double own_max(double a, double b)
{
    return isnan(a) || isnan(b) ? NAN : b < a ? a : b;
}

static inline double own_step(double x)
{
    return isnan(x) ? NAN : x >= 0;
}

static inline double own_sign(double x)
{
    return isnan(x) ? NAN : (x > 0) - (x < 0);
}

static inline double own_mod(double a, double b)
{
    const double rest = fmod(a, b);
    return rest != 0 && signbit(rest) != signbit(b) ? rest + b : rest;
}

enum { SIN, COS, TAN, ASIN, ACOS, ATAN, SINH, COSH, TANH, EXP, LOG, LOG10, SQRT, CBRT, ABS };
enum { STEP = ABS + 1, SIGN, FLOOR, CEIL, ROUND, ATAN2, HYPOT, MIN, MAX, MOD, POW_CALL, IF };

static const struct {
    const char *name;
    double (*one)(double);
    double (*two)(double, double);
} functions[] = {[SIN] = {"sin", fixed_sin, NULL},
                 [COS] = {"cos", fixed_cos, NULL},
                 [TAN] = {"tan", fixed_tan, NULL},
                 [ASIN] = {"asin", fixed_asin, NULL},
                 [ACOS] = {"acos", fixed_acos, NULL},
                 [ATAN] = {"atan", fixed_atan, NULL},
                 [SINH] = {"sinh", fixed_sinh, NULL},
                 [COSH] = {"cosh", fixed_cosh, NULL},
                 [TANH] = {"tanh", fixed_tanh, NULL},
                 [EXP] = {"exp", fixed_exp, NULL},
                 [LOG] = {"log", fixed_log, NULL},
                 [LOG10] = {"log10", fixed_log10, NULL},
                 [SQRT] = {"sqrt", sqrt, NULL},
                 [CBRT] = {"cbrt", fixed_cbrt, NULL},
                 [ABS] = {"abs", fabs, NULL},
                 [STEP] = {"step", own_step, NULL},
                 [SIGN] = {"sign", own_sign, NULL},
                 [FLOOR] = {"floor", floor, NULL},
                 [CEIL] = {"ceil", ceil, NULL},
                 [ROUND] = {"round", round, NULL},
                 [ATAN2] = {"atan2", NULL, fixed_atan2},
                 [HYPOT] = {"hypot", NULL, fixed_hypot},
                 [MIN] = {"min", NULL, own_min},
                 [MAX] = {"max", NULL, own_max},
                 [MOD] = {"mod", NULL, own_mod},
                 [POW_CALL] = {"pow", NULL, short_power},
                 [IF] = {"if", NULL, NULL}};

static inline int arguments_of(int which)
{
    return functions[which].one ? 1 : functions[which].two ? 2 : 3;
}

static inline double call_value(int which, const double *x)
{
    return functions[which].one ? functions[which].one(x[0]) : functions[which].two(x[0], x[1]);
}

static const char *const signs[] = {"", "", "-", "+", "-", "*", "/", "^", "<", ">", "<=", ">="};

struct tree {
    enum kind kind;
    int which; /* name, function */
    double number;
    const struct tree *x[3];
};

struct forest {
    struct tree tree[4000];
    int count;
    uint64_t seed;
};

static inline int pick(struct forest *f, int below)
{
    return (int)random_between(&f->seed, 0, below);
}

static inline const struct tree *grow(struct forest *f, int depth)
{
    struct tree *t = &f->tree[f->count++];
    static const double numbers[] = {0, 1, 2, 3, 0.5, 4, 10, 1.5, 0.1, 7};
    const int kind = depth == 0 ? pick(f, 3) : pick(f, 24);
    *t = (struct tree){.kind = NAME, .which = pick(f, NAMES)};
    if (kind == 0) {
        *t = (struct tree){.kind = NUMBER, .number = numbers[pick(f, (int)COUNT_OF(numbers))]};
    } else if (kind >= 3 && kind < 16) {
        t->kind = (enum kind[]){
            NEG, ADD, SUB, MUL, DIV, POW, ADD, SUB, MUL, MUL, MUL, ADD, LESS}[kind - 3];
        if (t->kind == LESS)
            t->kind += (enum kind)pick(f, 4);
        t->x[0] = grow(f, depth - 1);
        t->x[1] = t->kind == NEG ? NULL : grow(f, t->kind == POW ? pick(f, 2) : depth - 1);
    } else if (kind >= 16) {
        t->kind = CALL;
        t->which = pick(f, (int)COUNT_OF(functions));
        for (int i = 0; i < arguments_of(t->which); i++)
            t->x[i] = grow(f, depth - 1);
    }
    return t;
}

static inline void write_tree(struct buffer *out, const struct tree *t)
{
    if (t->kind == NUMBER) {
        buffer_real(out, t->number);
    } else if (t->kind == NAME) {
        buffer_char(out, (char)('a' + t->which));
    } else if (t->kind == CALL) {
        buffer_format(out, "%s(", functions[t->which].name);
        for (int i = 0; i < arguments_of(t->which); i++) {
            buffer_put(out, text_of(i ? ", " : ""));
            write_tree(out, t->x[i]);
        }
        buffer_char(out, ')');
    } else {
        buffer_char(out, '(');
        if (t->x[1])
            write_tree(out, t->x[0]);
        buffer_put(out, text_of(signs[t->kind]));
        write_tree(out, t->x[t->x[1] ? 1 : 0]);
        buffer_char(out, ')');
    }
}
