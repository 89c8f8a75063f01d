/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas as curves. */
#pragma once

#include "modules/recording/series/internal.h"

/* Its programs, which formula_done() frees; the rest is the arena's. */
bool formula_ready(struct formula *formula, struct arena *arena, struct error *error);
void formula_done(struct formula *formula);
/* A formula that is ready (the context) as struct fit_curve wants it. */
bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative);
