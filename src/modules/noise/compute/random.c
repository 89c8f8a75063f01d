/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The counter-based generator Philox, and normal numbers made of its bits. */
#include "modules/noise/compute/random.h"

#include <hooke/base/elementary.h>
#include <hooke/base/numeric.h>

/* Sets block to 128 random bits for a counter and a key by Philox 4x32 (ten rounds of
 * multiplication and exchange). */
void noise_philox_block(const uint32_t counter[4], const uint32_t key[2], uint32_t block[4])
{
    /* Multipliers and Weyl constants of the paper's table 2. */
    enum { ROUNDS = 10 };
    static const uint64_t multiplier[2] = {0xD2511F53u, 0xCD9E8D57u};
    static const uint32_t weyl[2] = {0x9E3779B9u, 0xBB67AE85u};
    uint32_t c[4] = {counter[0], counter[1], counter[2], counter[3]};
    uint32_t k[2] = {key[0], key[1]};
    for (int i = 0; i < ROUNDS; i++) {
        const uint64_t a = multiplier[0] * c[0], b = multiplier[1] * c[2];
        const uint32_t c1 = c[1], c3 = c[3];
        c[0] = (uint32_t)(b >> 32) ^ c1 ^ k[0];
        c[1] = (uint32_t)b;
        c[2] = (uint32_t)(a >> 32) ^ c3 ^ k[1];
        c[3] = (uint32_t)a;
        k[0] += weyl[0];
        k[1] += weyl[1];
    }
    for (int i = 0; i < 4; i++)
        block[i] = c[i];
}

/* Returns the middle of one of 2^52 equal parts of (0, 1), so that neither end occurs. */
static double open_fraction(uint32_t high, uint32_t low)
{
    const uint64_t part = ((uint64_t)high << 32 | low) >> 12;
    return ((double)part + 0.5) * 0x1p-52;
}

/* Sets normal [count] to independent normal numbers that depend only on seed, path and step. Each
 * block of random bits gives two (Box, Muller). */
void noise_normal_numbers(uint64_t seed, uint64_t path, uint64_t step, int count, double *normal)
{
    const uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    for (int i = 0; i < count; i += 2) {
        const uint32_t counter[4] = {(uint32_t)step, (uint32_t)(step >> 32), (uint32_t)path,
                                     (uint32_t)i};
        uint32_t block[4];
        noise_philox_block(counter, key, block);
        const double radius = sqrt(-2 * fixed_log(open_fraction(block[0], block[1])));
        const double angle = TWO_PI * open_fraction(block[2], block[3]);
        normal[i] = radius * fixed_cos(angle);
        if (i + 1 < count)
            normal[i + 1] = radius * fixed_sin(angle);
    }
}
