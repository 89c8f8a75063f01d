/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an expression, a condition and a program: an error or a value, the same in all
 * forms, never a crash. */
#include <hooke/scene.h>

#include <stdlib.h>
#include <string.h>

#define CORPUS "expression"
#define UNIT "expressions"
#include "fuzz/replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { NAMES = 4 };

static bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = name.len == 1 && name.data[0] >= 'u' && name.data[0] < 'u' + NAMES ? name.data[0] - 'u'
                                                                               : -1;
    return *slot >= 0;
}

static double load(const void *context, int slot)
{
    return ((const double *)context)[slot];
}

static const double x[NAMES] = {-0.7, 3, 0, 1e200};
static enum quantity quantity(const void *context, int slot)
{
    (void)context;
    return slot % 2 ? QUANTITY_LENGTH : QUANTITY_OTHER;
}

static const struct expr_scope scope = {
    .context = x, .find = find, .load = load, .quantity = quantity};

static void check(bool fine)
{
    if (!fine)
        abort();
}

/* The expression and its derivatives by the first two names; the last two are known. */
static void compare_forms(const struct expr *expr)
{
    struct error error = {0};
    static const bool bound[NAMES] = {[2] = true, [3] = true};
    struct equations *equations = equations_create(NAMES, &error);
    struct program *form[2] = {NULL};
    double output[2][3];
    if (equations && equations_add(equations, expr, &error) &&
        equations_derive(equations, 0, 1, (const int[]){0, 1}, 2, &error)) {
        for (int native = 0; native < 2; native++) {
            form[native] = program_create(equations, 0, 3, bound, x, native, &error);
            double *frame =
                form[native] ? calloc(program_frame(form[native]) + 1, sizeof *frame) : NULL;
            check(frame);
            program_prepare(form[native], frame);
            program_eval(form[native], x, output[native], frame);
            free(frame);
            program_destroy(form[native]);
        }
        for (int i = 0; i < 3; i++)
            check(memcmp(&output[0][i], &output[1][i], sizeof output[0][i]) == 0 ||
                  (isnan(output[0][i]) && isnan(output[1][i])));
    }
    equations_destroy(equations);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct text text = {(const char *)data, size};
    struct arena arena = {0};
    struct error error = {0};
    size_t used = 0;
    const struct expr *expr = expr_compile(text, &scope, &arena, &used, &error);
    if (expr) {
        volatile double value = expr_value(expr, &scope);
        (void)value;
        compare_forms(expr);
    }
    struct condition condition;
    if (condition_compile(text, &scope, &arena, &condition, &used, &error)) {
        condition_holds(&condition, condition_value(&condition, &scope));
    }
    arena_reset(&arena);
    return 0;
}
