/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rings of oscillators by hand: x_i'' = k (x_i+1 - 2 x_i + x_i-1) - b x_i^3, their number known to
 * the compiler. */
#include "bench/bench.h"

#include <string.h>

#define INLINE static inline __attribute__((always_inline))

INLINE void accelerate(int n, const struct known *f, const double *x, double *a)
{
    a[0] = f->k * (x[1] - 2 * x[0] + x[n - 1]) - f->b * x[0] * x[0] * x[0];
    for (int i = 1; i < n - 1; i++)
        a[i] = f->k * (x[i + 1] - 2 * x[i] + x[i - 1]) - f->b * x[i] * x[i] * x[i];
    a[n - 1] = f->k * (x[0] - 2 * x[n - 1] + x[n - 2]) - f->b * x[n - 1] * x[n - 1] * x[n - 1];
}

enum { CHAIN_MAX = 32 };

/* z = y + part k, both the positions and the velocities; then the slope there */
INLINE void stage(int n, const struct known *f, const double *y, double part, const double *k,
                  double *slope)
{
    double z[2 * CHAIN_MAX];
    for (int i = 0; i < 2 * n; i++)
        z[i] = y[i] + part * k[i];
    memcpy(slope, z + n, (size_t)n * sizeof *z);
    accelerate(n, f, z, slope + n);
}

INLINE void rk4(int n, const struct known *given, double h, int64_t count, double *state,
                double *row)
{
    const struct known known = *given, *const f = &known;
    double y[2 * CHAIN_MAX], k1[2 * CHAIN_MAX], k2[2 * CHAIN_MAX], k3[2 * CHAIN_MAX],
        k4[2 * CHAIN_MAX];
    memcpy(y, state, 2 * (size_t)n * sizeof *y);
    for (int64_t i = 0; i < count; i++, row += 2 * n) {
        memcpy(k1, y + n, (size_t)n * sizeof *y);
        accelerate(n, f, y, k1 + n);
        stage(n, f, y, h / 2, k1, k2);
        stage(n, f, y, h / 2, k2, k3);
        stage(n, f, y, h, k3, k4);
        for (int j = 0; j < 2 * n; j++)
            y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
        memcpy(row, y, 2 * (size_t)n * sizeof *y);
    }
    memcpy(state, y, 2 * (size_t)n * sizeof *y);
}

#define CHAIN(n)                                                                                   \
    static void chain_##n(const struct known *f, double h, int64_t first, int64_t count,           \
                          double *state, double *row)                                              \
    {                                                                                              \
        (void)first;                                                                               \
        rk4(n, f, h, count, state, row);                                                           \
    }
CHAIN(4)
CHAIN(8)
CHAIN(16)
CHAIN(32)

hand_loop *hand_chain(int n)
{
    return n == 4 ? chain_4 : n == 8 ? chain_8 : n == 16 ? chain_16 : n == 32 ? chain_32 : NULL;
}
