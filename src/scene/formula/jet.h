/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of operations and functions with their derivatives by one argument. */
#pragma once

#include "scene/formula/expr.h"
#include <hooke/scene/interval.h>

struct jet jet_number(double number);
struct jet jet_add(struct jet a, struct jet b);
/* bounds of a function of expressions (functions.c) */
struct jet jet_one(double (*function)(double), struct jet x);

/* Returns bounds of a branch that is not known: values in between, with any slope. A branch that
 * may not be a number has the same bounds. */
struct jet jet_jump(double lo, double hi);

/* The operation on bounds of its arguments x. */
struct jet jet_apply(const struct op *op, const struct jet *x);
