/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Many trajectories at once: the same steps on LANES systems of one kind, in vectors as wide as the machine has. The
 * latency of one trajectory's sums, which is what a single one waits for, is hidden by the others.
 *
 * Not target_clones: a vector type has its width from the instructions that its function may use, and one that is wider
 * than they are lives in memory. So the text is included for each width, and the widest that runs here is taken.
 */
#define UNROLL _Pragma("GCC unroll 16")
#include "kernel.h"

#include <stdlib.h>

enum { LANE_COEFFICIENTS = 2 };

typedef double scalar;

static inline scalar scalar_magnitude(scalar x)
{
    return fabs(x);
}

struct lane_march {
    int64_t first, count;
    const double *cosine; /* [count][places] of the drive, where it is the same for all; NULL: each its own */
    int places;
    double *row;
};

struct lanes {
    const struct method *method;
    enum drag drag;
    int shape;
    double t0, h;
    bool warm;    /* `kept` holds what the next step begins with */
    bool divides; /* the flow of the drag has a divisor other than 1 */
    bool together; /* all are driven alike */
    double *cosine; /* [ROOM] of the drive */
    int64_t tabled, tables; /* steps in it: from, how many */
    double omega[LANES], phase[LANES];
    double c[SHAPE_TERMS][LANE_COEFFICIENTS][LANES];
    double y[2][LANES];
    double kept[2][LANES];                     /* the last stage's slope, or the last force */
    double keep[LANES], least[LANES], pull[LANES]; /* the drag's flow over h/2 */
    struct {
        double lost[LANES], pull[LANES];
    } frozen[WEIGHTS_MAX]; /* of each kick */
};

typedef void lane_kernel(struct lanes *lanes, const struct lane_march *march);

/* ---- shapes: those of the kernels, and the linear ones, for which a single trajectory has the propagator ---- */

#define TERMS_OF_spring(T) T(0, spring)
#define TERMS_OF_damped(T) T(0, spring) T(1, damping)
#define LANE_SHAPES(S) S(spring) S(damped) SHAPES(S)

#define LANE_PLACE(shape) LANE_##shape,
enum { LANE_SHAPES(LANE_PLACE) LANE_SHAPE_COUNT };

#define LANE_FLAG(i, name) | (name##_flags)
#define LANE_FLAGS(shape) (0 TERMS_OF_##shape(LANE_FLAG))

static void lanes_cosine(const struct lanes *lanes, double t, double *cosine)
{
    for (int lane = 0; lane < LANES; lane++)
        cosine[lane] = cos(lanes->omega[lane] * t + lanes->phase[lane]);
}

/* ---- the widths ---- */

#define WIDE 2
#define TARGET
#define WITH(name) name##_2
#include "kernel_lanes.h"

#ifdef __x86_64__
#define WIDE 4
#define TARGET __attribute__((target("avx2")))
#define WITH(name) name##_4
#include "kernel_lanes.h"

#define WIDE 8
#define TARGET __attribute__((target("avx512f")))
#define WITH(name) name##_8
#include "kernel_lanes.h"
#endif

static lane_kernel *kernel_of(const struct lanes *lanes)
{
    const int family = lanes->method->splitting != NULL;
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f"))
        return kernels_8[lanes->shape][family];
    if (__builtin_cpu_supports("avx2"))
        return kernels_4[lanes->shape][family];
#endif
    return kernels_2[lanes->shape][family];
}
