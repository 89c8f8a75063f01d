/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The words that the rows in the .def files are written with. */
#ifndef HOOKE_METHOD_ROWS_ROWS_H
#define HOOKE_METHOD_ROWS_ROWS_H

#include "method/step/step.h"

/* clang-format off */
#define REALS(...) (const double[]){__VA_ARGS__}
#define TABLEAU(...) .tableau = &(const struct tableau){__VA_ARGS__}
#define WEIGHTS(...) .splitting = &(const struct splitting){__VA_ARGS__}
#define NYSTROM_TABLEAU(...) .nystrom = &(const struct nystrom){__VA_ARGS__}
#define IMPLICIT_TABLEAU(...) .implicit = &(const struct implicit_tableau){__VA_ARGS__}
#define LINEARLY_IMPLICIT(...) .rosenbrock = &(const struct rosenbrock){__VA_ARGS__}
#define STEPS(...) .multistep = &(const struct multistep){__VA_ARGS__}
#define DRAG_VARIANTS (1u << DRAG_EXACT | 1u << DRAG_IMPLICIT | 1u << DRAG_EXPLICIT)
/* clang-format on */

#endif
