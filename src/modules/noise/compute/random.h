/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random numbers that are functions of their place: no thread waits for another one. */
#pragma once

#include <stdint.h>

/* Encrypts a counter with a key: Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, SC11). */
void noise_philox_block(const uint32_t counter[4], const uint32_t key[2], uint32_t block[4]);

/*
 * Fills normal [count] with independent standard normal numbers (Box, Muller 1958) that depend on
 * nothing but the seed, the path (below 2^32), the step and their index: the same bits in any
 * order, on any machine.
 */
void noise_normal_numbers(uint64_t seed, uint64_t path, uint64_t step, int count, double *normal);
