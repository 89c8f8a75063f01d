/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scope with a few names, one of them with a hyphen, for the tests of expressions and conditions.
 */
#pragma once

#include <hooke/base/catalog.h>
#include "unit/scene/testing.h"

#include <math.h>

static const struct {
    const char *name;
    double value;
} names[] = {{"y", 2},     {"v", -3},    {"gamma", 0.25},
             {"phase", 7}, {"error", 5}, {"phase-error", 11},
             {"T0", 4},    {"x_1", 0.5}, {"nan_", NAN}};

static bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    for (int i = 0; i < (int)COUNT_OF(names); i++)
        if (text_is(name, names[i].name)) {
            *slot = i;
            return true;
        }
    return false;
}

static double load(const void *context, int slot)
{
    (void)context;
    return names[slot].value;
}

static void offer(const void *context, struct suggestion *suggestion)
{
    (void)context;
    for (size_t i = 0; i < COUNT_OF(names); i++)
        suggestion_offer(suggestion, names[i].name);
}

static enum quantity quantity(const void *context, int slot)
{
    (void)context;
    (void)slot;
    return QUANTITY_OTHER;
}

static const struct expr_scope scope = {
    .find = find, .load = load, .offer = offer, .quantity = quantity};
