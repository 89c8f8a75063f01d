/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Evaluates programs of formulas for many lanes at once. Each operation is a loop over lanes that
 * the compiler turns into vector instructions, so that the cost of finding the next operation is
 * shared. Addresses of operands are found beforehand: names are read where the caller has them,
 * outputs written where they are wanted. A function of numbers that are the same in all lanes is
 * called once. */
#ifndef __clang__
/* - */
#pragma GCC optimize("O3") /* vectors */
#endif
#include <hooke/base/numeric.h>

#include <string.h>

#include "modules/lanes/lanes.h"
#include "scene/formula/program/program.h"

/* One operation of a prepared program. */
struct lane_operation {
    enum node_kind kind; /* NODE_KINDS stands for a copy */
    bool once;           /* function whose arguments are the same in all lanes: it is called once */
    /* `value` is the result for `argument`, of a function that is called once */
    bool known;
    double argument[2], value;
    double *target; /* address of the result, or NULL for output number `output` */
    int output;
    const double *operand[3];
    const struct node *node;
    /* function on many numbers at once, or NULL if there is none */
    void (*many)(int n, const double *x, double *result);
};

/* Returns the size [double] of a frame: constants and intermediate values, results that are
 * computed when preparing, then the operations with an end mark. */
size_t program_frame_lanes(const struct program *p)
{
    const size_t values = (size_t)(p->slots - p->names + p->count) * PROGRAM_LANES;
    const size_t operations = 1 + (size_t)(p->count + p->copies);
    return values + (operations * sizeof(struct lane_operation) + 63) / 64 * (64 / sizeof(double));
}

/* Returns the operations within a frame. */
static struct lane_operation *operations(const struct program *p, double *frame)
{
    return (struct lane_operation *)(void *)(frame + (size_t)(p->slots - p->names + p->count) *
                                                         PROGRAM_LANES);
}

/* Returns true if both numbers have the same bits (0 and -0 differ, equal NANs do not). */
static bool same_bits(double a, double b)
{
    uint64_t x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    return x == y;
}

/* Returns the value of a function whose arguments are the same in all lanes, or the previous value
 * if the arguments have not changed. */
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

/* Computes one operation in all lanes: result = operation(a, b, c). */
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

/* Runs the operations from `i` up to the end mark, whose node is NULL. output
 * [outputs][PROGRAM_LANES] receives results that have no target address. An operation runs for all
 * lanes at once, or once if its arguments are the same in all lanes. */
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

/* Returns the function that computes a whole array for one of the fixed functions, or NULL. */
static void (*many_of(double (*one)(double)))(int n, const double *x, double *result)
{
    if (one == fixed_sin)
        return fixed_sines;
    if (one == fixed_cos)
        return fixed_cosines;
    return one == fixed_exp ? fixed_exponentials : NULL;
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

/* Returns where the value of a slot is stored (input, constant or intermediate value) and whether
 * it is fixed or the same in all lanes. `lanes` tells that of the names, or is NULL. */
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

/* Prepares a frame for the program. `input` [names][PROGRAM_LANES] are the values of the names, and
 * lanes_of [names] is what is known of them (enum program_lanes), or NULL. Writes the list of
 * operations with the addresses of their operands and results, and computes those of fixed values
 * at once instead of listing them. */
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
            /* an operation with fewer operands repeats its first one */
            lanes &= operand.lanes;
        }
        next->once = lanes & LANES_ALIKE && (next->kind == NODE_ONE || next->kind == NODE_TWO);
        next->many = next->kind == NODE_ONE && !next->once ? many_of(i->node.one) : NULL;
        /* A result of fixed values is computed here and gets a place that later operations do not
         * overwrite. */
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
        /* Outputs that no operation writes (a name, a constant) are copied. */
        if (!p->written[i])
            *next++ =
                (struct lane_operation){.kind = NODE_KINDS,
                                        .output = i,
                                        .operand = {output.values, output.values, output.values},
                                        .node = &copy};
    }
    *next = end;
}

/* Evaluates a prepared program; output is [outputs][PROGRAM_LANES]. */
void program_eval_lanes(const struct program *p, double *output, double *frame)
{
    lane_operations_run(operations(p, frame), output);
}
