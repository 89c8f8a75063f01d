/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of operations and functions with their derivatives by one argument. */
#ifndef HOOKE_SCENE_FORMULA_JET_H
#define HOOKE_SCENE_FORMULA_JET_H

#include "scene/formula/expr.h"
#include <hooke/scene/interval.h>

struct jet jet_number(double number);
struct jet jet_add(struct jet a, struct jet b);
struct jet jet_one(double (*function)(double), struct jet x); /* of expressions (functions.c) */

/* Of a branch that is not known: in between, with any slope; of one that may not be a number, the
 * same. */
struct jet jet_jump(double lo, double hi);

/* The operation on bounds of its arguments x. */
struct jet jet_apply(const struct op *op, const struct jet *x);

#endif
