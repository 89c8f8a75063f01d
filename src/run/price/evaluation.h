/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prices of evaluations, in instructions. */
#pragma once

#include <hooke/method.h>

/* One evaluation of the forces, compiled into a kernel; called term by term, as diagnoses do. */
double evaluation_price(const struct system *system);
double evaluation_price_called(const struct system *system);
/* One evaluation with its part of the step around it: iterations, linear solves, error control. */
double solver_evaluation_price(const struct system *system, const struct method *method,
                               bool adaptive);
/* One state of the closed form. */
double exact_state_price(const struct system *system);
