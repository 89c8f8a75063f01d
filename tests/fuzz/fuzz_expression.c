/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an expression and as a condition: an error or a value, never a crash. */
#include <hooke/scene.h>

#define CORPUS "fuzz_expression"
#include "replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct text text = {(const char *)data, size};
    struct arena arena = {0};
    struct error error = {0};
    size_t used = 0;
    const struct expr *expr = expr_compile(text, NULL, &arena, &used, &error);
    if (expr) {
        volatile double value = expr_value(expr, NULL);
        (void)value;
    }
    struct condition condition;
    if (condition_compile(text, NULL, &arena, &condition, &used, &error)) {
        condition_holds(&condition, condition_value(&condition, NULL));
    }
    arena_reset(&arena);
    return 0;
}
