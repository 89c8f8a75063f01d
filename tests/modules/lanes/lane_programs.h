/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs of formulas on many lanes at once, beside what one evaluation gives. */
#pragma once

#include "cmocka_testing.h"

#include "modules/lanes/lanes.h"

#define COMPARE_LANES(program, input, count, output)                                               \
    compare_lanes(program, outputs, input, count, output)

static inline void compare_lanes(const struct program *program, int outputs, const double *input,
                                 int count, const double *output);

#include "numerics/scene/trees.h"

/* input [count][NAMES], output [count][outputs]: count is at most PROGRAM_LANES. */
static inline void compare_lanes(const struct program *program, int outputs, const double *input,
                                 int count, const double *output)
{
    double *lanes = room_of(program_frame_lanes(program));
    double *in = room_of(NAMES * PROGRAM_LANES), *out = room_of((size_t)outputs * PROGRAM_LANES);
    unsigned char known[NAMES];
    assert_true(program_frame(program) <= program_frame_lanes(program));
    for (int j = 0; j < NAMES; j++) {
        known[j] = LANES_ALIKE | (j % 2 ? LANES_FIXED : 0);
        for (int k = 0; k < PROGRAM_LANES; k++) {
            in[j * PROGRAM_LANES + k] = input[(k % count) * NAMES + j];
            if (memcmp(&in[j * PROGRAM_LANES + k], &in[j * PROGRAM_LANES], sizeof *in) != 0)
                known[j] &= LANES_FIXED;
        }
    }
    program_prepare_lanes(program, in, known, lanes);
    program_eval_lanes(program, out, lanes);
    program_eval_lanes(program, out, lanes);
    for (int k = 0; k < count; k++)
        for (int i = 0; i < outputs; i++)
            if (!same(output[k * outputs + i], out[i * PROGRAM_LANES + k]))
                fail_msg("output %d: %.17g, in lanes %.17g", i, output[k * outputs + i],
                         out[i * PROGRAM_LANES + k]);
    free(lanes);
    free(in);
    free(out);
}
