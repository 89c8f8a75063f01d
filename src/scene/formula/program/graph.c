/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Expressions as a graph: equal nodes are one (hash-consing, Ershov 1958), and each is simplified
 * when it is made. No simplification changes a bit of the result, except for one rule of scenes: a
 * term whose coefficient is 0 is absent. If x depends on an input, 0 x is absent, and so is a/x if
 * a is a known name that is 0; sums leave out absent terms, but not numbers that are 0. Names are
 * known only when they are bound, so the rule is applied then. It does not hold without
 * graph->has_terms. */
#include <stdlib.h>
#include <string.h>

#include "scene/formula/program/program.h"

/* ---- nodes ---- */

/* Returns the number of operands; 0 for numbers and names. */
int node_arity(enum node_kind kind)
{
    static const signed char arity[NODE_KINDS] = {
        [NODE_NEG] = 1,        [NODE_ABS] = 1,     [NODE_SQRT] = 1,    [NODE_ADD] = 2,
        [NODE_SUB] = 2,        [NODE_MUL] = 2,     [NODE_DIV] = 2,     [NODE_LESS] = 2,
        [NODE_LESS_EQUAL] = 2, [NODE_IF] = 3,      [NODE_ONE] = 1,     [NODE_TWO] = 2,
        [NODE_MUL_ADD] = 3,    [NODE_MUL_SUB] = 3, [NODE_SUB_MUL] = 3, [NODE_NEG_MUL] = 2,
    };
    return kind < NODE_KINDS ? arity[kind] : 0;
}

/* Returns the bits of the number or of the function's address, which share their memory. */
static uint64_t payload(const struct node *node)
{
    uint64_t bits;
    memcpy(&bits, &node->number, sizeof bits); /* the function pointers share its place */
    return bits;
}

/* Returns a hash of a node. Any spread will do; the multiplier is that of splitmix64 (Steele, Lea,
 * Flood 2014). */
static unsigned node_hash(const struct node *node)
{
    uint64_t hash = (uint64_t)node->kind;
    for (int i = 0; i < 3; i++)
        hash = (hash ^ (uint64_t)node->operand[i]) * 0xBF58476D1CE4E5B9u;
    hash = (hash ^ payload(node)) * 0x94D049BB133111EBu;
    return (unsigned)(hash >> 32) ^ (unsigned)(hash >> 58);
}

/* Returns true if two nodes are the same operation. */
static bool node_equal(const struct node *a, const struct node *b)
{
    return a->kind == b->kind && a->operand[0] == b->operand[0] && a->operand[1] == b->operand[1] &&
           a->operand[2] == b->operand[2] && payload(a) == payload(b);
}

/* ---- the table ---- */

/* Puts node i into the hash table, which has a free slot. */
static void table_put(int *table, unsigned slots, const struct node *node, int i)
{
    unsigned slot = node_hash(&node[i]) & (slots - 1);
    while (table[slot])
        slot = (slot + 1) & (slots - 1);
    table[slot] = i;
}

/* Doubles the memory of nodes and of their hash table. Returns false if out of memory. */
static bool graph_grow(struct graph *g)
{
    int capacity = g->capacity ? 2 * g->capacity : 64;
    unsigned slots = 2 * (unsigned)capacity; /* so that the table is at most half full */
    struct node *node = arena_array(g->arena, (size_t)capacity, sizeof *node);
    int *table = arena_array(g->arena, slots, sizeof *table);
    if (!node || !table)
        return false;
    if (g->count)
        memcpy(node, g->node, (size_t)g->count * sizeof *node);
    for (int i = 1; i < g->count; i++)
        table_put(table, slots, node, i);
    g->node = node;
    g->table = table;
    g->slots = slots;
    g->capacity = capacity;
    return true;
}

/* Returns the index of a node, which is added if the graph has none that is equal. Returns 0, and
 * sets g->failed, if out of memory or if there are too many. */
static int node_intern(struct graph *g, struct node node)
{
    if (g->failed)
        return 0;
    unsigned slot = node_hash(&node) & (g->slots - 1);
    for (; g->table[slot]; slot = (slot + 1) & (g->slots - 1))
        if (node_equal(&g->node[g->table[slot]], &node))
            return g->table[slot];
    if (g->count == PROGRAM_SIZE) {
        g->failed = GRAPH_FULL;
        return 0;
    }
    if (g->count == g->capacity) {
        if (!graph_grow(g)) {
            g->failed = GRAPH_NO_MEMORY;
            return 0;
        }
        return node_intern(g, node);
    }
    g->table[slot] = g->count;
    g->node[g->count] = node;
    return g->count++;
}

/* Makes an empty graph, whose node 0 is the number 0. */
void graph_init(struct graph *g, struct arena *arena, bool binds)
{
    *g = (struct graph){.arena = arena, .binds = binds, .has_terms = binds};
    if (!graph_grow(g)) {
        g->failed = GRAPH_NO_MEMORY;
        return;
    }
    g->node[g->count++] = (struct node){.kind = NODE_NUMBER};
}

/* Sets the error if the graph has run out of memory or become too large. */
bool graph_check(const struct graph *g, struct error *error)
{
    if (g->failed == GRAPH_NO_MEMORY)
        return error_memory(error);
    if (g->failed)
        return error_set(error, ERROR_COMMAND,
                         "the equations and their derivatives have more than %d operations",
                         PROGRAM_SIZE);
    return true;
}

void graph_reach(const struct node *node, int count, bool *mark)
{
    for (int i = count - 1; i >= 0; i--)
        for (int k = 0; mark[i] && k < node_arity(node[i].kind); k++)
            mark[node[i].operand[k]] = true;
}

/* ---- making nodes ---- */

int graph_number(struct graph *g, double number)
{
    struct node node = {.kind = NODE_NUMBER, .number = number};
    return payload(&node) == 0 ? 0 : node_intern(g, node);
}

int graph_name(struct graph *g, int name)
{
    return node_intern(g, (struct node){.kind = NODE_NAME, .operand = {name}});
}

/* Returns the node of a number that is 0, of either sign, with its source. */
static int zero_node(struct graph *g, enum zero_mark mark, double number)
{
    return mark == ZERO_NUMBER ? graph_number(g, number)
                               : node_intern(g, (struct node){.operand = {(int)mark},
                                                              .number = number}); /* NODE_NUMBER */
}

int graph_known(struct graph *g, double value)
{
    return value == 0 && g->has_terms ? zero_node(g, ZERO_NAME, value) : graph_number(g, value);
}

/* Returns true if node i is a number. */
static bool node_is_number(const struct graph *g, int i)
{
    return !g->failed && g->node[i].kind == NODE_NUMBER;
}

/* Returns true if node i is this number. */
static bool is_node_value(const struct graph *g, int i, double number)
{
    return node_is_number(g, i) && g->node[i].number == number;
}

/* Returns the source of a node that is the number 0. */
static enum zero_mark mark_of(const struct graph *g, int i)
{
    return node_is_number(g, i) ? (enum zero_mark)g->node[i].operand[0] : ZERO_NUMBER;
}

/* Returns true if node i is a term whose coefficient is 0. */
static bool is_absent(const struct graph *g, int i)
{
    return mark_of(g, i) == ZERO_TERM;
}

/* Returns true if node i is a coefficient 0, so that a product with it is absent. */
static bool is_coefficient_zero(const struct graph *g, int i)
{
    return g->has_terms && is_node_value(g, i, 0);
}

/* Returns the zero_mark of the result of an operation whose value is the number 0, by those of its
 * operands: a product with an absent term is absent, too, while a sum is only if both summands are.
 */
static enum zero_mark mark_of_result(const struct graph *g, const struct node *node)
{
    const enum zero_mark a = mark_of(g, node->operand[0]);
    if (node->kind == NODE_NEG || node->kind == NODE_DIV)
        return a;
    const enum zero_mark b = node_arity(node->kind) > 1 ? mark_of(g, node->operand[1]) : a;
    if (node->kind == NODE_MUL)
        return a > b ? a : b;
    if (node->kind == NODE_ADD || node->kind == NODE_SUB)
        return a < b ? a : b;
    return ZERO_NUMBER;
}

/* Returns the operand of node i if that is a negation, else -1. */
static int negation_operand(const struct graph *g, int i)
{
    return !g->failed && g->node[i].kind == NODE_NEG ? g->node[i].operand[0] : -1;
}

/* Returns true if 1/x is exact: x is a power of two, and neither it nor its inverse is denormal. */
static bool has_exact_inverse(double x)
{
    int exponent;
    return isfinite(x) && fabs(frexp(x, &exponent)) == 0.5 && abs(exponent) < 1000;
}

/* Returns the node of x^n by the operations of function_power(). */
static int power_node(struct graph *g, int x, double n)
{
    int whole = (int)fabs(n), bit = POWER_MAX;
    while (bit > whole)
        bit /= 2;
    int made = whole > 0 ? x : graph_number(g, 1);
    while ((bit /= 2) > 0) {
        made = graph_apply(g, NODE_MUL, made, made, 0);
        if (whole & bit)
            made = graph_apply(g, NODE_MUL, made, x, 0);
    }
    if (fabs(n) > whole)
        made = graph_apply(g, NODE_MUL, made, graph_apply(g, NODE_SQRT, x, 0, 0), 0);
    return n < 0 ? graph_apply(g, NODE_DIV, graph_number(g, 1), made, 0) : made;
}

/* Returns a simpler node of the same value, or -1 if there is none. */
static int node_simplify(struct graph *g, struct node node)
{
    const int a = node.operand[0], b = node.operand[1], c = node.operand[2];
    switch (node.kind) {
    case NODE_NEG:
        if (g->binds && g->node[a].kind == NODE_MUL && node_is_number(g, g->node[a].operand[0]))
            return graph_apply(g, NODE_MUL, graph_number(g, -g->node[g->node[a].operand[0]].number),
                               g->node[a].operand[1], 0);
        return negation_operand(g, a);
    case NODE_ABS:
        if (negation_operand(g, a) >= 0)
            return graph_apply(g, NODE_ABS, negation_operand(g, a), 0, 0);
        return !g->failed && g->node[a].kind == NODE_ABS ? a : -1;
    case NODE_ADD:
        if (is_absent(g, a) || is_absent(g, b))
            return is_absent(g, a) ? b : a;
        if (negation_operand(g, b) >= 0)
            return graph_apply(g, NODE_SUB, a, negation_operand(g, b), 0);
        if (negation_operand(g, a) >= 0)
            return graph_apply(g, NODE_SUB, b, negation_operand(g, a), 0);
        return a == b ? graph_apply(g, NODE_MUL, graph_number(g, 2), a, 0) : -1;
    case NODE_SUB:
        if (is_absent(g, a) || is_absent(g, b))
            return is_absent(g, b) ? a : graph_apply(g, NODE_NEG, b, 0, 0);
        if (g->binds && is_node_value(g, b, 0) && !signbit(g->node[b].number))
            return a; /* also -0 */
        return negation_operand(g, b) >= 0 ? graph_apply(g, NODE_ADD, a, negation_operand(g, b), 0)
                                           : -1;
    case NODE_MUL:
        if (is_coefficient_zero(g, a) || is_coefficient_zero(g, b))
            return zero_node(g, ZERO_TERM, 0);
        if (is_node_value(g, a, 1) || is_node_value(g, b, 1))
            return is_node_value(g, a, 1) ? b : a;
        if (is_node_value(g, a, -1) || is_node_value(g, b, -1))
            return graph_apply(g, NODE_NEG, is_node_value(g, a, -1) ? b : a, 0, 0);
        if (g->binds && (negation_operand(g, a) >= 0 ||
                         negation_operand(g, b) >= 0)) { /* no 0: its sign might come out wrong */
            const bool first = negation_operand(g, a) >= 0;
            const int other = first ? b : a;
            const int inner = negation_operand(g, first ? a : b);
            if (node_is_number(g, other))
                return graph_apply(g, NODE_MUL, graph_number(g, -g->node[other].number), inner, 0);
            return graph_apply(g, NODE_NEG, graph_apply(g, NODE_MUL, inner, other, 0), 0, 0);
        }
        return -1;
    case NODE_DIV:
        if (mark_of(g, a) != ZERO_NUMBER)
            return zero_node(g, ZERO_TERM, 0);
        if (is_node_value(g, b, 1))
            return a;
        if (node_is_number(g, b) && has_exact_inverse(g->node[b].number))
            return graph_apply(g, NODE_MUL, a, graph_number(g, 1 / g->node[b].number), 0);
        return -1;
    case NODE_IF:
        if (!node_is_number(g, a))
            return -1;
        if (isnan(g->node[a].number))
            return a;
        return g->node[a].number > 0 ? b : c;
    case NODE_ONE:
        return -1;
    case NODE_TWO:
        if (node.two != function_power || !node_is_number(g, b))
            return -1;
        if (is_node_value(g, b, 0) || is_node_value(g, b, 1))
            return is_node_value(g, b, 1) ? a : graph_number(g, 1);
        return g->binds && power_is_short(g->node[b].number) ? power_node(g, a, g->node[b].number)
                                                             : -1;
    default:
        return -1;
    }
}

/* Returns the node of an operation: its value if all operands are numbers, a simpler one, or
 * itself. */
static int graph_node_make(struct graph *g, struct node node)
{
    if (g->failed)
        return 0;
    const int arity = node_arity(node.kind);
    double value[3] = {0};
    int numbers = 0;
    for (int k = 0; k < arity; k++) {
        value[k] = g->node[node.operand[k]].number;
        numbers += node_is_number(g, node.operand[k]);
    }
    if (numbers == arity) {
        const double result = node_value(node.kind, &node, value[0], value[1], value[2]);
        return result == 0 ? zero_node(g, mark_of_result(g, &node), result)
                           : graph_number(g, result);
    }
    const int other = node_simplify(g, node);
    if (other >= 0 || g->failed)
        return other >= 0 ? other : 0;
    /* Their operands may change places: a number to the front. */
    const int first = node.operand[0], second = node.operand[1];
    if ((node.kind == NODE_ADD || node.kind == NODE_MUL) &&
        (node_is_number(g, second) || (first > second && !node_is_number(g, first)))) {
        node.operand[0] = second;
        node.operand[1] = first;
    }
    return node_intern(g, node);
}

int graph_apply(struct graph *g, enum node_kind kind, int a, int b, int c)
{
    return graph_node_make(g, (struct node){.kind = kind, .operand = {a, b, c}});
}

/* Replaces functions that are operations by these: fabs, sqrt, sign and step. */
int graph_one(struct graph *g, double (*one)(double), int a)
{
    if (one == fabs || one == sqrt)
        return graph_apply(g, one == fabs ? NODE_ABS : NODE_SQRT, a, 0, 0);
    if (one == function_sign)
        return graph_apply(g, NODE_SUB, graph_apply(g, NODE_LESS, 0, a, 0),
                           graph_apply(g, NODE_LESS, a, 0, 0), 0);
    if (one == function_step)
        return graph_apply(g, NODE_LESS_EQUAL, 0, a, 0);
    return graph_node_make(g, (struct node){.kind = NODE_ONE, .operand = {a}, .one = one});
}

/* Replaces min and max by a comparison and a choice. */
int graph_two(struct graph *g, double (*two)(double, double), int a, int b)
{
    if (two == function_min)
        return graph_apply(g, NODE_IF, graph_apply(g, NODE_LESS, a, b, 0), a, b);
    if (two == function_max)
        return graph_apply(g, NODE_IF, graph_apply(g, NODE_LESS, b, a, 0), a, b);
    return graph_node_make(g, (struct node){.kind = NODE_TWO, .operand = {a, b}, .two = two});
}

/* Returns the node of the same operation on the operands map[i]. */
int graph_copy(struct graph *g, const struct node *node, const int *map)
{
    struct node copy = *node;
    for (int k = 0; k < node_arity(node->kind); k++)
        copy.operand[k] = map[node->operand[k]];
    return graph_node_make(g, copy);
}
