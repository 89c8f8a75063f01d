/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Four lanes in a vector, as wide as a register of most machines: compilers keep wider ones in
 * memory. Functions that use them are for each kind of processor (CLONES). */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wpsabi" /* all of them are inlined */
#endif

enum { WIDE = 4 };

typedef double four __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));
/* Conditions are 0 or -1. */
typedef int64_t lane_mask;
typedef lane_mask four_masks __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));

INLINE four *fours(double *x)
{
    return (four *)(void *)x;
}

INLINE four_masks *masks(lane_mask *x)
{
    return (four_masks *)(void *)x;
}

INLINE four four_magnitude(four x)
{
    return (four)((four_masks)x & INT64_MAX);
}

INLINE four four_either(four_masks second, four a, four b)
{
    return (four)(((four_masks)a & ~second) | ((four_masks)b & second));
}

INLINE four four_larger(four a, four b)
{
    return four_either(a > b, b, a);
}

INLINE four four_root(four x)
{
    for (int i = 0; i < WIDE; i++)
        x[i] = sqrt(x[i]);
    return x;
}

INLINE bool four_none(four_masks so)
{
    return (so[0] | so[1] | so[2] | so[3]) == 0;
}
