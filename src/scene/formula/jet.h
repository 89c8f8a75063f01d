/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of operations and functions with their first and second derivatives by one argument
 * (struct jet). jet.c has the operations, jet_functions.c the functions of one argument; expr_jet()
 * uses them. */
#pragma once

#include "scene/formula/expr.h"
#include <hooke/scene/interval.h>

/* Returns the bounds of a constant. */
struct jet jet_number(double number);
struct jet jet_add(struct jet a, struct jet b);
/* Returns the bounds of a function of one argument (functions.c); no bounds if it has no row in
 * jet_functions.c. */
struct jet jet_one(double (*function)(double), struct jet x);

/* Returns bounds of a function that may jump: values from lo to hi, with any slope. */
struct jet jet_jump(double lo, double hi);

/* Returns the bounds of an operation's value, given those of its operands x. */
struct jet jet_apply(const struct op *op, const struct jet *x);
