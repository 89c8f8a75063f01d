/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random numbers that are the same everywhere. */
#pragma once

#include <math.h>
#include <stdint.h>

/* 53 bits: splitmix64 (Steele, Lea, Flood 2014) */
static inline double random_bits(uint64_t *state)
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11);
}

static inline double uniform_from(uint64_t *state) /* in (0, 1) */
{
    return (random_bits(state) + 0.5) * 0x1p-53;
}

/* Standard normal: Box, Muller 1958 */
static inline double normal_from(uint64_t *state)
{
    const double r = sqrt(-2 * log(uniform_from(state)));
    return r * cos(6.283185307179586 * uniform_from(state));
}

static uint64_t random_state = 1;

static inline double random_uniform(void) /* in [0, 1) */
{
    return random_bits(&random_state) * 0x1p-53;
}

static inline double random_normal(void)
{
    const double u = 1 - random_uniform(), v = random_uniform();
    return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}
