/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas as curves. */
#ifndef HOOKE_MODULES_RECORDING_FIT_FORMULA_H
#define HOOKE_MODULES_RECORDING_FIT_FORMULA_H

#include "modules/recording/series/internal.h"

/* Its programs, which formula_done() frees; the rest is the arena's. */
bool formula_ready(struct formula *formula, struct arena *arena, struct error *error);
void formula_done(struct formula *formula);
/* A formula that is ready (the context) as struct fit_curve wants it. */
bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative);

#endif
