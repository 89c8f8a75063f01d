/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels: marches of explicit Runge-Kutta methods and of METHOD_UNROLLED splittings where the
 * compiler knows both the row and the shape, so that loops unroll, zeros vanish and the state stays
 * in registers. Other pairs would not gain: longer splittings do not wait for their weights
 * (shape.c), other methods hide the call of the force (typed.c).
 */
#define UNROLL _Pragma("GCC unroll 32")
#include "method/kernel/kernel.h"

/* Names of rows and kernels, made unique by the line at which a row ends. */
#define RK_ROW JOIN(rk_, __LINE__)
#define RK_NAME(shape) JOIN(shape##_rk_, __LINE__)
#define SPLIT_ROW JOIN(split_, __LINE__)
#define SPLIT_NAME(shape) JOIN(shape##_split_, __LINE__)

/* Returns true if a row has its own kernel for the shape: for METHOD_UNROLLED rows, and for forces
 * so short that a call would take longer. */
INLINE bool has_own_kernel(const struct method *method, int shape)
{
    return method->flags & METHOD_UNROLLED || shape == SHAPE_spring || shape == SHAPE_damped ||
           shape == SHAPE_henon_heiles;
}

/* Defines the kernel of RK_ROW for one shape. */
#define RK_KERNEL(shape)                                                                           \
    static int64_t RK_NAME(shape)(const struct method *method, const struct march *march)          \
    {                                                                                              \
        struct shape_forces forces;                                                                \
        if (!has_own_kernel(&RK_ROW, SHAPE_##shape))                                               \
            return typed_kernel(method, march->step->system, DRAG_DEFAULT)(method, march);         \
        forces_take(&forces, march->step->system, 0 TERMS_OF_##shape(ONE_MORE));                   \
        return rk_march(&RK_ROW, SIZE_##shape, shape##_slope, &forces, march);                     \
    }
#define RUNGE_KUTTA(id, ...)                                                                       \
    static const struct method RK_ROW = {.step = rk_step, __VA_ARGS__};                            \
    ALL_SHAPES(RK_KERNEL)
#include "method/rows/rk.def"
#undef RUNGE_KUTTA

/* Calls the march of SPLIT_ROW with a constant drag variant if that is the one wanted. */
#define DRAG_VARIANT(shape, variant)                                                               \
    if (drag == variant && (variant == DRAG_DEFAULT || SPLIT_ROW.drags & 1u << variant))           \
        return split_march(&SPLIT_ROW, SIZE_##shape, variant, shape##_force, shape##_drag,         \
                           &forces, march);
/* Defines the kernel of SPLIT_ROW for one shape. */
#define SPLIT_KERNEL(shape)                                                                        \
    static int64_t SPLIT_NAME(shape)(const struct method *method, const struct march *march)       \
    {                                                                                              \
        const bool velocity = (0 TERMS_OF_##shape(HAS_VELOCITY)) != 0;                             \
        const enum drag drag = velocity ? march->step->drag : DRAG_DEFAULT;                        \
        struct shape_forces forces;                                                                \
        if (!(SPLIT_ROW.flags & METHOD_UNROLLED))                                                  \
            return shape_split(SHAPE_##shape)(method, march);                                      \
        forces_take(&forces, march->step->system, 0 TERMS_OF_##shape(ONE_MORE));                   \
        if (!velocity)                                                                             \
            DRAG_VARIANT(shape, DRAG_DEFAULT)                                                      \
        DRAG_VARIANT(shape, DRAG_EXACT)                                                            \
        DRAG_VARIANT(shape, DRAG_EXPLICIT)                                                         \
        return shape_split(SHAPE_##shape)(method, march);                                          \
    }
#define SPLITTING(id, ...)                                                                         \
    static const struct method SPLIT_ROW = {.step = split_step, __VA_ARGS__};                      \
    ALL_SHAPES(SPLIT_KERNEL)
#include "method/rows/split.def"
#undef SPLITTING

/* ---- the table ---- */

#define RK_ENTRY(shape) RK_NAME(shape),
#define SPLIT_ENTRY(shape) SPLIT_NAME(shape),

static march_function *const runge_kutta[][SHAPE_COUNT] = {
    {NULL},
#define RUNGE_KUTTA(...) {ALL_SHAPES(RK_ENTRY)},
#include "method/rows/rk.def"
};
static march_function *const splittings[][SHAPE_COUNT] = {
    {NULL},
#define SPLITTING(...) {ALL_SHAPES(SPLIT_ENTRY)},
#include "method/rows/split.def"
};

/* Returns the fastest kernel for method and system: for row and shape, for the shape, or for any
 * scene; NULL if there is none. */
march_function *method_kernel(const struct method *method, const struct system *system,
                              enum drag drag)
{
    if (system->model && system->model->typed)
        return typed_kernel(method, system, drag);
    const int shape = shape_of(system);
    if (shape < 0 && system->order != 2)
        return NULL;
    if (shape < 0)
        return method->tableau ? typed_kernel(method, system, drag) : any_kernel(method);
    if (has_own_kernel(method, shape) && (method->step == rk_step || method->step == split_step))
        return (method->step == rk_step ? runge_kutta : splittings)[method->index][shape];
    if (method->splitting)
        return shape_split(shape);
    return method->tableau ? typed_kernel(method, system, drag) : implicit_kernel(method, system);
}
