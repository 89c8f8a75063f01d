/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Programs on many lanes at once: each operation is a loop that the compiler turns into vector instructions, so that
 * what it costs to find out which operation comes next is shared by all lanes.
 */
#ifndef __clang__
#pragma GCC optimize("O3") /* vectors */
#endif
#include <string.h>

#include "program.h"

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define CLONES
#endif

void program_prepare_lanes(const struct program *p, double *frame)
{
    double *lane = frame + (size_t)p->names * PROGRAM_LANES;
    for (int i = 0; i < p->numbers; i++)
        for (int k = 0; k < PROGRAM_LANES; k++)
            *lane++ = p->number[i];
}

static inline __attribute__((always_inline)) void apply(const struct node *node, double *restrict out,
                                                        const double *restrict a, const double *restrict b,
                                                        const double *restrict c)
{
#define CASE(name)                                                                                                     \
    case name:                                                                                                         \
        for (int i = 0; i < PROGRAM_LANES; i++)                                                                        \
            out[i] = node_value(name, node, a[i], b[i], c[i]);                                                         \
        break;
    switch (node->kind) {
        OPERATIONS(CASE)
    default: /* no operations */
        break;
    }
#undef CASE
}

static void copy(double *to, const double *from)
{
    memcpy(to, from, PROGRAM_LANES * sizeof *to);
}

CLONES void program_eval_lanes(const struct program *p, const double *input, double *output, double *frame)
{
    if (input != frame)
        for (int i = 0; i < p->uses; i++)
            copy(frame + p->used[i] * PROGRAM_LANES, input + p->used[i] * PROGRAM_LANES);
    for (const struct instruction *i = p->code, *end = i + p->count; i < end; i++) {
        const int *place = i->node.operand;
        apply(&i->node, frame + (size_t)i->out * PROGRAM_LANES, frame + (size_t)place[0] * PROGRAM_LANES,
              frame + (size_t)place[1] * PROGRAM_LANES, frame + (size_t)place[2] * PROGRAM_LANES);
    }
    for (int i = 0; i < p->outputs; i++)
        copy(output + i * PROGRAM_LANES, frame + p->output[i] * PROGRAM_LANES);
}
