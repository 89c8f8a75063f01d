/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Switches: places where |u|, sign(u), u < v, if(), min(), max(), step(), floor(), ceil(), round(),
 * mod() go from one smooth branch to another. equations_freeze() makes equations whose branches are
 * values of names, so that they are smooth across the switch. */
#include <math.h>
#include <stdlib.h>

#include "scene/formula/program/program.h"

struct freezing {
    struct equations *e;
    struct switches *found;
    int *map;     /* [nodes] the frozen node of each node */
    bool *moving; /* [nodes] the frozen node depends on t or the state */
    bool *always; /* [nodes] the node is needed whatever branch an if() takes */
};

/* Returns the node of an operation on frozen nodes. */
static int frozen_node(struct freezing *f, enum node_kind kind, int a, int b, int c)
{
    return graph_apply(&f->e->graph, kind, a, b, c);
}

/* Returns true if two arguments are negatives of each other, as in sign(x) = (0 < x) - (x < 0). */
static bool opposite(const struct freezing *f, int a, int b)
{
    const struct node *x = &f->e->graph.node[a], *y = &f->e->graph.node[b];
    return (x->kind == NODE_NEG && x->operand[0] == b) ||
           (y->kind == NODE_NEG && y->operand[0] == a) ||
           (x->kind == NODE_SUB && y->kind == NODE_SUB && x->operand[0] == y->operand[1] &&
            x->operand[1] == y->operand[0]);
}

/* Returns the name of the branch of a switch with argument u, as a node: an existing one if it has
 * this argument or its negative, else a new one. Returns 0, and sets found->full, if there are too
 * many. */
static int branch_node(struct freezing *f, int u, enum switch_kind kind)
{
    struct switches *found = f->found;
    for (int i = 0; i < found->count; i++) {
        const int name = graph_name(&f->e->graph, found->name + i);
        if (found->kind[i] != kind)
            continue;
        if (found->argument[i] == u)
            return name;
        if (kind == SWITCH_SIGN && opposite(f, found->argument[i], u))
            return frozen_node(f, NODE_SUB, graph_number(&f->e->graph, 1), name, 0);
    }
    if (found->count == LIMIT_TYPED_SWITCHES) {
        found->full = true;
        return 0;
    }
    found->argument[found->count] = u;
    found->kind[found->count] = kind;
    return graph_name(&f->e->graph, found->name + found->count++);
}

/* Returns the branch that is the largest integer not above u. */
static int floor_node(struct freezing *f, int u)
{
    return branch_node(f, u, SWITCH_WHOLE);
}

/* Returns the frozen node of a function of one argument, or -1 if it is smooth. */
static int freeze_one(struct freezing *f, const struct node *node, int x)
{
    struct graph *g = &f->e->graph;
    if (node->one == function_sign)
        return frozen_node(f, NODE_IF, branch_node(f, x, SWITCH_SIGN), graph_number(g, 1),
                           graph_number(g, -1));
    if (node->one == function_step)
        return branch_node(f, x, SWITCH_SIGN);
    if (node->one == floor)
        return floor_node(f, x);
    if (node->one == ceil)
        return frozen_node(f, NODE_NEG, floor_node(f, frozen_node(f, NODE_NEG, x, 0, 0)), 0, 0);
    if (node->one == round)
        return floor_node(f, frozen_node(f, NODE_ADD, x, graph_number(g, 0.5), 0));
    return -1;
}

/* Returns the frozen node of a function of two arguments, or -1 if it is smooth. */
static int freeze_two(struct freezing *f, const struct node *node, int a, int b)
{
    if (node->two == function_min || node->two == function_max) {
        const int less = branch_node(f, frozen_node(f, NODE_SUB, b, a, 0), SWITCH_SIGN);
        return node->two == function_min ? frozen_node(f, NODE_IF, less, a, b)
                                         : frozen_node(f, NODE_IF, less, b, a);
    }
    if (node->two == function_mod)
        return frozen_node(
            f, NODE_SUB, a,
            frozen_node(f, NODE_MUL, b, floor_node(f, frozen_node(f, NODE_DIV, a, b, 0)), 0), 0);
    return -1;
}

/* Returns the smooth node in place of a switch whose operands move, or -1 if the node is smooth
 * itself. x holds the frozen operands. */
static int freeze(struct freezing *f, const struct node *node, const int *x, bool condition_moves)
{
    switch (node->kind) {
    case NODE_ABS:
        return frozen_node(f, NODE_IF, branch_node(f, x[0], SWITCH_SIGN), x[0],
                           frozen_node(f, NODE_NEG, x[0], 0, 0));
    case NODE_LESS:
    case NODE_LESS_EQUAL:
        return branch_node(f, frozen_node(f, NODE_SUB, x[1], x[0], 0), SWITCH_SIGN);
    case NODE_IF:
        return condition_moves
                   ? frozen_node(f, NODE_IF, branch_node(f, x[0], SWITCH_SIGN), x[1], x[2])
                   : -1;
    case NODE_ONE:
        return freeze_one(f, node, x[0]);
    case NODE_TWO:
        return freeze_two(f, node, x[0], x[1]);
    default:
        return -1;
    }
}

/* Returns true if the node is this number. */
static bool operand_is_number(const struct freezing *f, int node, double number)
{
    const struct node *n = &f->e->graph.node[node];
    return n->kind == NODE_NUMBER && n->number == number;
}

/* Returns true for |u| and max(u, 0), that is u < 0 ? 0 : u, which are never below 0; their frozen
 * branches are, beyond the switch. */
static bool never_below(const struct freezing *f, int node)
{
    const struct node *n = &f->e->graph.node[node], *less = &f->e->graph.node[n->operand[0]];
    return n->kind == NODE_ABS ||
           (n->kind == NODE_IF && less->kind == NODE_LESS && less->operand[0] == n->operand[2] &&
            less->operand[1] == n->operand[1] &&
            (operand_is_number(f, n->operand[1], 0) || operand_is_number(f, n->operand[2], 0)));
}

/* Returns true if the node is a function of arguments above 0 only: a root, a logarithm, or a power
 * whose exponent is not a whole number. */
static bool wants_positive(const struct freezing *f, const struct node *node)
{
    if (node->kind != NODE_TWO || node->two != function_power)
        return node->kind == NODE_SQRT ||
               (node->kind == NODE_ONE && (node->one == fixed_log || node->one == fixed_log10));
    const struct node *power = &f->e->graph.node[node->operand[1]];
    return power->kind == NODE_NUMBER && power->number != floor(power->number);
}

/* Continues a branch beyond its switch, by |y| in place of an argument y that has to be above 0. A
 * step that ends at a switch evaluates the branch beyond it, where sqrt(y) of if(y > 0, sqrt(y),
 * 0), or the branch y of max(y, 0)^1.5, is not a number. Under if(), the function may have no value
 * on this side either, which `extended` notes: the step then evaluates the equations themselves. */
static void branch_continue_beyond(struct freezing *f, int node, const struct node *kind, int *map)
{
    const int operand = kind->operand[0];
    const bool power = kind->kind == NODE_TWO && kind->two == function_power;
    const bool inside = never_below(f, operand) && (power || wants_positive(f, kind));
    if (!inside && (f->always[node] || !wants_positive(f, kind)))
        return;
    f->found->extended = f->found->extended || !inside;
    map[operand] = frozen_node(f, NODE_ABS, map[operand], 0, 0);
}

/* Marks the nodes that are needed whatever branches if() takes: all operands, but for the last two
 * of if(). */
static void mark_always(struct freezing *f, int count)
{
    const struct node *node = f->e->graph.node;
    for (int i = count - 1; i >= 0; i--)
        for (int k = 0;
             f->always[i] && k < (node[i].kind == NODE_IF ? 1 : node_arity(node[i].kind)); k++)
            f->always[node[i].operand[k]] = true;
}

/* Sets f->map to the frozen nodes of the first `count` nodes that are reached, in their order. */
static void freeze_nodes(struct freezing *f, int count, const bool *reached)
{
    for (int i = 0; i < count && !f->e->graph.failed && !f->found->full; i++) {
        const struct node node = f->e->graph.node[i]; /* a copy: the graph grows */
        const int arity = node_arity(node.kind);
        int x[3] = {0, 0, 0}, frozen = -1;
        bool moving = node.kind == NODE_NAME && node.operand[0] < f->found->moving;
        f->map[i] = i;
        if (!reached[i])
            continue;
        for (int k = 0; k < arity; k++) {
            x[k] = f->map[node.operand[k]];
            moving = moving || f->moving[node.operand[k]];
        }
        if (arity > 0 && moving)
            frozen = freeze(f, &node, x, f->moving[node.operand[0]]);
        if (frozen >= 0) /* a switch moves no more where it is only a number on each branch */
            moving = node.kind == NODE_ABS || node.kind == NODE_IF || node.kind == NODE_TWO;
        else if (arity > 0) {
            const int operand = f->map[node.operand[0]];
            if (moving)
                branch_continue_beyond(f, i, &node, f->map);
            frozen = graph_copy(&f->e->graph, &node, f->map);
            f->map[node.operand[0]] = operand;
        }
        f->moving[i] = moving;
        f->map[i] = frozen >= 0 ? frozen : i;
    }
}

/* Makes the frozen nodes of the outputs, and adds these behind the arguments of the switches. */
bool equations_freeze(struct equations *e, int first, int count, struct switches *found,
                      struct error *error)
{
    const int nodes = e->graph.count;
    struct freezing f = {e, found, calloc((size_t)nodes, sizeof *f.map),
                         calloc((size_t)nodes, sizeof *f.moving),
                         calloc((size_t)nodes, sizeof *f.always)};
    bool *reached = calloc((size_t)nodes, sizeof *reached);
    const bool allocated = f.map && f.moving && f.always && reached &&
                           equations_reserve(e, count + LIMIT_TYPED_SWITCHES);
    found->count = 0;
    found->full = false;
    for (int i = 0; allocated && i < count; i++)
        reached[e->output[first + i]] = f.always[e->output[first + i]] = true;
    found->extended = false;
    if (allocated) {
        mark_always(&f, nodes);
        graph_reach(e->graph.node, nodes, reached);
        freeze_nodes(&f, nodes, reached);
    }
    if (found->full)
        found->count = 0;
    for (int i = 0; allocated && i < found->count; i++)
        e->output[e->outputs++] = found->argument[i];
    for (int i = 0; allocated && found->count > 0 && i < count; i++)
        e->output[e->outputs++] = f.map[e->output[first + i]];
    free(f.map);
    free(f.moving);
    free(f.always);
    free(reached);
    return allocated ? graph_check(&e->graph, error) : error_memory(error);
}

/* ---- finding switches in a formula ---- */

/* Returns true if an operation is a switch; its operands may be constant. */
static bool is_switch(const struct op *op)
{
    static double (*const one[])(double) = {fabs, function_sign, function_step, floor, ceil, round};
    static double (*const two[])(double, double) = {function_min, function_max, function_mod};
    bool found = op->kind == OP_LESS || op->kind == OP_GREATER || op->kind == OP_LESS_EQUAL ||
                 op->kind == OP_GREATER_EQUAL;
    if (op->kind != OP_CALL)
        return found;
    found = op->function->three != NULL;
    for (size_t i = 0; i < COUNT_OF(one); i++)
        found = found || (op->function->one && op->function->one == one[i]);
    for (size_t i = 0; i < COUNT_OF(two); i++)
        found = found || (op->function->two && op->function->two == two[i]);
    return found;
}

bool expr_switches(const struct expr *expr)
{
    for (size_t i = 0; expr && i < expr->count; i++)
        if (is_switch(&expr->op[i]))
            return true;
    return false;
}
