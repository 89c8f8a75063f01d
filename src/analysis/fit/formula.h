/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas as curves. */
#ifndef HOOKE_ANALYSIS_FIT_FORMULA_H
#define HOOKE_ANALYSIS_FIT_FORMULA_H

#include "analysis/internal.h"

/* A formula (the context) as struct fit_curve wants it. */
bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative);

#endif
