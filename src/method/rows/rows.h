/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Macros that the rows in the .def files are written with. A row begins with its identifier, by
 * which catalog.c finds its text in methods.txt. */
#pragma once

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

/* Numbers of the rows in their files, from 1 on; 0 is used for methods of other files. A row is
 * identified by the line at which it ends. */
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define AT(family) JOIN(family##_AT_, __LINE__)
enum {
    RK_AT_NONE,
#define RUNGE_KUTTA(...) AT(RK),
#include "method/rows/rk.def"
#undef RUNGE_KUTTA
};
enum {
    SPLIT_AT_NONE,
#define SPLITTING(...) AT(SPLIT),
#include "method/rows/split.def"
#undef SPLITTING
};
enum {
    IRK_AT_NONE,
#define IMPLICIT_RUNGE_KUTTA(...) AT(IRK),
#include "method/rows/irk.def"
#undef IMPLICIT_RUNGE_KUTTA
};
enum {
    ROSENBROCK_AT_NONE,
#define ROSENBROCK(...) AT(ROSENBROCK),
#include "method/rows/rosenbrock.def"
#undef ROSENBROCK
};
