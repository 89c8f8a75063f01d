/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prices in instructions of an evaluation of the forces, of a solver's step around it, and of the
 * exact solution. price.c adds them up for `plan`; the second opinion limits its work by them. */
#pragma once

#include <hooke/method.h>

/* Returns the price of one evaluation of the forces in a kernel. */
double evaluation_price(const struct system *system);
/* Returns the price of one evaluation that calls each term, or the program of typed equations. */
double evaluation_price_called(const struct system *system);
/* Returns the price of one evaluation in a kernel with its share of the step around it: iterations,
 * linear solves, error control. */
double solver_evaluation_price(const struct system *system, const struct method *method,
                               bool adaptive);
/* Returns the price of one state of the closed form. */
double exact_state_price(const struct system *system);
