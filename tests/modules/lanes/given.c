/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The tests of programs with given names once more, on many lanes, too. */
#include "modules/lanes/lane_programs.h"

#include "scene/formula/program/program.h"

#define GIVEN_LANES(program, input, first, steady, wanted)                                         \
    given_lanes(program, input, first, steady, wanted)

/* steady: values of the names from `first` on; wanted [program->outputs]. */
static void given_lanes(const struct program *program, const double *input, int first,
                        const double *steady, const double *wanted)
{
    double *in = room_of((size_t)program->names * PROGRAM_LANES),
           *lanes = room_of(program_frame_lanes(program)),
           *row = room_of((size_t)program->outputs * PROGRAM_LANES);
    for (int i = 0; i < program->names; i++)
        for (int k = 0; k < PROGRAM_LANES; k++)
            in[i * PROGRAM_LANES + k] = i < first ? input[i] : steady[i - first];
    program_prepare_lanes(program, in, NULL, lanes);
    program_eval_lanes(program, row, lanes);
    for (int i = 0; i < program->outputs; i++)
        assert_true(same(row[i * PROGRAM_LANES + 7], wanted[i]));
    free(in);
    free(row);
    free(lanes);
}

#include "numerics/scene/given.c"
