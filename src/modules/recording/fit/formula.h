/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Evaluation of compiled formulas as curves: call formula_ready(), then formula_evaluate() any
 * number of times, then formula_done(). */
#pragma once

#include "modules/recording/series/internal.h"

/* Makes the programs that compute the formula and its derivatives. formula_done() frees the
 * programs; other memory is the arena's. Returns false with the error if a derivative cannot be
 * made or if out of memory; nothing has to be freed then. */
bool formula_ready(struct formula *formula, struct arena *arena, struct error *error);
/* Frees the programs of a formula that formula_ready() prepared. */
void formula_done(struct formula *formula);
/* Evaluates a formula that is ready (the context), in the form that struct fit_curve expects.
 * Returns false if a value is not finite or if cancelled. */
bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative);
