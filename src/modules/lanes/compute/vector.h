/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Vectors of four lanes, as wide as a register of most machines: compilers keep wider ones in
 * memory. Functions that use them are compiled for several kinds of processors (CLONES). */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif
#ifdef __GNUC__
/* vectors as arguments are only passed to inlined functions */
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

/* lanes in a vector */
enum { WIDE = 4 };

typedef double four __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));
/* Conditions in lanes, 0 (false) or -1 (all bits set, true). */
typedef int64_t lane_mask;
typedef lane_mask four_masks __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));

/* Returns an array of numbers as vectors. */
INLINE four *fours(double *x)
{
    return (four *)(void *)x;
}

/* Returns an array of conditions as vectors. */
INLINE four_masks *masks(lane_mask *x)
{
    return (four_masks *)(void *)x;
}

/* Returns the absolute values. */
INLINE four four_magnitude(four x)
{
    return (four)((four_masks)x & INT64_MAX);
}

/* Returns b in the lanes of `second`, a in the others. */
INLINE four four_either(four_masks second, four a, four b)
{
    return (four)(((four_masks)a & ~second) | ((four_masks)b & second));
}

/* Returns the larger numbers; b where one is NAN. */
INLINE four four_larger(four a, four b)
{
    return four_either(a > b, b, a);
}

/* Returns the square roots. */
INLINE four four_root(four x)
{
    for (int i = 0; i < WIDE; i++)
        x[i] = sqrt(x[i]);
    return x;
}

/* Returns true if no lane is set. */
INLINE bool four_none(four_masks so)
{
    return (so[0] | so[1] | so[2] | so[3]) == 0;
}
