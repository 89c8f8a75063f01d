/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Programs on many lanes at once: each operation is a loop that the compiler turns into vector
 * instructions, so that what it costs to find out which operation comes next is shared by all
 * lanes. Where its operands are is found out beforehand: names where the caller has them, outputs
 * where they are wanted. A function of what is the same in all lanes is called once.
 */
#ifndef __clang__
#pragma GCC optimize("O3") /* vectors */
#endif
#include <hooke/base/numeric.h>

#include <string.h>

#include "modules/lanes/lanes.h"
#include "scene/formula/program/program.h"

struct lane_operation {
    enum node_kind kind; /* NODE_KINDS stands for a copy */
    bool once;           /* a function of what is the same in all lanes */
    bool known;          /* its value for `argument` */
    double argument[2], value;
    double *target; /* NULL for output number `output` */
    int output;
    const double *operand[3];
    const struct node *node;
    void (*many)(int n, const double *x, double *result); /* NULL if it takes one at a time */
};

/* The frame: numbers and intermediate values, room for those that are fixed, then the operations.
 */
size_t program_frame_lanes(const struct program *p)
{
    const size_t values = (size_t)(p->slots - p->names + p->count) * PROGRAM_LANES;
    const size_t operations = 1 + (size_t)(p->count + p->copies);
    return values + (operations * sizeof(struct lane_operation) + 63) / 64 * (64 / sizeof(double));
}

static struct lane_operation *operations(const struct program *p, double *frame)
{
    return (struct lane_operation *)(void *)(frame + (size_t)(p->slots - p->names + p->count) *
                                                         PROGRAM_LANES);
}

static bool same_bits(double a, double b)
{
    uint64_t x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    return x == y;
}

/* A function of what is the same in all lanes, which may be the same as last time. */
static double value_once(struct lane_operation *operation)
{
    const double a = *operation->operand[0], b = *operation->operand[1];
    if (operation->known && same_bits(a, operation->argument[0]) &&
        same_bits(b, operation->argument[1]))
        return operation->value;
    operation->known = true;
    operation->argument[0] = a;
    operation->argument[1] = b;
    return operation->value =
               operation->kind == NODE_ONE ? operation->node->one(a) : operation->node->two(a, b);
}

static inline __attribute__((always_inline)) void
apply(const struct lane_operation *operation, double *restrict result, const double *restrict a,
      const double *restrict b, const double *restrict c)
{
#define CASE(name)                                                                                 \
    case name:                                                                                     \
        for (int i = 0; i < PROGRAM_LANES; i++)                                                    \
            result[i] = node_value(name, operation->node, a[i], b[i], c[i]);                       \
        break;
    switch (operation->kind) {
        OPERATIONS(CASE)
    case NODE_KINDS:
        memcpy(result, a, PROGRAM_LANES * sizeof *result);
        break;
    default: /* no operations */
        break;
    }
#undef CASE
}

CLONES static void lane_operations_run(struct lane_operation *i, double *output)
{
    for (; i->node; i++) {
        double *result = i->target ? i->target : output + i->output * PROGRAM_LANES;
        if (i->many) {
            i->many(PROGRAM_LANES, i->operand[0], result);
            continue;
        }
        if (!i->once) {
            apply(i, result, i->operand[0], i->operand[1], i->operand[2]);
            continue;
        }
        const double value = value_once(i);
        for (int lane = 0; lane < PROGRAM_LANES; lane++)
            result[lane] = value;
    }
}

/* ---- preparing ---- */

static void (*many_of(double (*one)(double)))(int n, const double *x, double *result)
{
    return one == fixed_sin   ? fixed_sines
           : one == fixed_cos ? fixed_cosines
           : one == fixed_exp ? fixed_exponentials
                              : NULL;
}

/* Knowledge about the value in a slot. */
struct slot_value {
    unsigned lanes;       /* enum program_lanes */
    const double *values; /* address at which it will be stored */
};

/* Returns the slot of an intermediate value, stored where its values would be. */
static struct slot_value *value_in_slot(const struct program *p, double *frame, int slot)
{
    return (struct slot_value *)(void *)(frame + (size_t)(slot - p->names) * PROGRAM_LANES);
}

static struct slot_value slot_lookup(const struct program *p, const double *input,
                                     const unsigned char *lanes, double *frame, int slot)
{
    if (slot < p->names)
        return (struct slot_value){lanes ? lanes[slot] : 0, input + (size_t)slot * PROGRAM_LANES};
    if (slot < p->names + p->numbers)
        return (struct slot_value){LANES_ALIKE | LANES_FIXED,
                                   frame + (size_t)(slot - p->names) * PROGRAM_LANES};
    return *value_in_slot(p, frame, slot);
}

void program_prepare_lanes(const struct program *p, const double *input,
                           const unsigned char *lanes_of, double *frame)
{
    static const struct node copy = {.kind = NODE_KINDS};
    const struct lane_operation end = {.node = NULL};
    double *fixed = frame + (size_t)(p->slots - p->names) * PROGRAM_LANES;
    struct lane_operation *next = operations(p, frame);
    for (int i = 0; i < p->numbers; i++)
        for (int k = 0; k < PROGRAM_LANES; k++)
            frame[i * PROGRAM_LANES + k] = p->number[i];
    for (const struct instruction *i = p->code; i < p->code + p->count; i++) {
        unsigned lanes = LANES_ALIKE | LANES_FIXED;
        *next =
            (struct lane_operation){.kind = i->node.kind, .output = i->output, .node = &i->node};
        for (int j = 0; j < 3; j++) {
            const struct slot_value operand =
                slot_lookup(p, input, lanes_of, frame, i->node.operand[j]);
            next->operand[j] = operand.values;
            lanes &= operand.lanes; /* one that it does not have is the first one again */
        }
        next->once = lanes & LANES_ALIKE && (next->kind == NODE_ONE || next->kind == NODE_TWO);
        next->many = next->kind == NODE_ONE && !next->once ? many_of(i->node.one) : NULL;
        const bool now = lanes & LANES_FIXED && i->output < 0;
        double *target = now ? fixed : frame + (size_t)(i->target_slot - p->names) * PROGRAM_LANES;
        *value_in_slot(p, frame, i->target_slot) = (struct slot_value){lanes, target};
        next->target = i->output < 0 ? target : NULL;
        if (!now) {
            next++;
            continue;
        }
        next[1] = end;
        lane_operations_run(next, NULL);
        fixed += PROGRAM_LANES;
    }
    for (int i = 0; i < p->outputs; i++) {
        const struct slot_value output = slot_lookup(p, input, lanes_of, frame, p->output[i]);
        if (!p->written[i])
            *next++ =
                (struct lane_operation){.kind = NODE_KINDS,
                                        .output = i,
                                        .operand = {output.values, output.values, output.values},
                                        .node = &copy};
    }
    *next = end;
}

void program_eval_lanes(const struct program *p, double *output, double *frame)
{
    lane_operations_run(operations(p, frame), output);
}
