/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Counter-based random numbers: each is a function of seed, path, step and index, so that threads
 * need not share a generator. */
#pragma once

#include <stdint.h>

/* Encrypts a counter with a key: Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, SC11). */
void noise_philox_block(const uint32_t counter[4], const uint32_t key[2], uint32_t block[4]);

/* Fills normal [count] with independent standard normal numbers (Box, Muller 1958). They depend
 * only on the seed, the path (below 2^32), the step and their index, and have the same bits on
 * every machine. */
void noise_normal_numbers(uint64_t seed, uint64_t path, uint64_t step, int count, double *normal);
