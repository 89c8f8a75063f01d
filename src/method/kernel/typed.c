/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels of typed scenes of up to four variables: marches of explicit Runge-Kutta methods compiled
 * for each row, with the forces called as programs.
 */
#define UNROLL _Pragma("GCC unroll 32")
/* Largest number of variables, for march_body.h. */
enum { MOST = 4 };
#include "method/kernel/typed.h"
#include "method/rows/rows.h"

/* Names of rows and kernels, made unique by the line at which a row ends. */
#define RK_ROW JOIN(rk_, __LINE__)
#define RK_NAME(shape) JOIN(shape##_rk_, __LINE__)

#define RK_KERNEL(name, n)                                                                         \
    static int64_t RK_NAME(name)(const struct method *method, const struct march *march)           \
    {                                                                                              \
        struct typed_forces known;                                                                 \
        (void)method;                                                                              \
        known_take(&known, march->step->system);                                                   \
        return rk_march(&RK_ROW, n, name##_slope, &known, march);                                  \
    }
#define RUNGE_KUTTA(id, ...)                                                                       \
    static const struct method RK_ROW = {.step = rk_step, __VA_ARGS__};                            \
    TYPED_MOTIONS(RK_KERNEL)                                                                       \
    TYPED_FLOWS(RK_KERNEL)
#include "method/rows/rk.def"
#undef RUNGE_KUTTA

#define RK_ENTRY(name, n) RK_NAME(name),
static march_function *const kernels[][TYPED_COUNT] = {
    {NULL},
#define RUNGE_KUTTA(...) {TYPED_MOTIONS(RK_ENTRY) TYPED_FLOWS(RK_ENTRY)},
#include "method/rows/rk.def"
};

/* Returns the march compiled for typed scenes of this shape, that is order and number of variables
 * (TYPED_MOTIONS, TYPED_FLOWS). Systems of other shapes, and splittings whose drag is not explicit,
 * get the one for any number of variables. Returns NULL if the method has none of these; its step
 * function is then called for each step. */
march_function *typed_kernel(const struct method *method, const struct system *system,
                             enum drag drag)
{
    const int shape = typed_shape(system, method->splitting != NULL);
    if (shape < 0 || (method->splitting && system->velocity && drag != DRAG_EXPLICIT))
        return any_kernel(method);
    if (method->splitting)
        return typed_split(shape);
    return method->step == rk_step ? kernels[method->index][shape] : NULL;
}
