/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The oscillator's own forces below what was typed, in lanes: the functions of terms.def in loops
 * for vectors. */
#define UNROLL
#include "method/kernel/kernel.h"

#include "method/kernel/lanes.h"

#include <hooke/base/numeric.h>

#define LANE_TERM(name)                                                                            \
    CLONES static void name##_lanes(const double *restrict c, double t, const double *restrict y,  \
                                    double *restrict a)                                            \
    {                                                                                              \
        for (int lane = 0; lane < LANES; lane++) {                                                 \
            double own[TERM_COEFFICIENTS], sum = a[lane];                                          \
            const double state[N] = {y[lane], y[LANES + lane]};                                    \
            for (int j = 0; j < TERM_COEFFICIENTS; j++)                                            \
                own[j] = c[j * LANES + lane];                                                      \
            name##_add(own, t, state, &sum);                                                       \
            a[lane] = sum;                                                                         \
        }                                                                                          \
    }
#define CONSERVATIVE_TERM(name, ...) LANE_TERM(name)
#define POWERED_TERM(name, ...) LANE_TERM(name)
#include FORCE_TERMS

lane_term_function *lane_term(const struct term_row *row)
{
    static lane_term_function *const add[FORCE_TERMS_END] = {
#define CONSERVATIVE_TERM(name, ...) [FORCE_##name] = name##_lanes,
#define POWERED_TERM(name, ...) [FORCE_##name] = name##_lanes,
#include FORCE_TERMS
    };
    return row->force < FORCE_TERMS_END ? add[row->force] : NULL;
}
