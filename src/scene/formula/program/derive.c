/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Partial derivatives as symbols: nodes that are added to the graph, by graph_derive(). Forward
 * mode, so that the branch that an if() does not take stays out of its derivative. The derivatives
 * of functions are in slopes.def. */
#include "scene/formula/program/program.h"

#define NUMBER(x) graph_number(g, x)
#define NEG(a) graph_apply(g, NODE_NEG, a, 0, 0)
#define ABS(a) graph_apply(g, NODE_ABS, a, 0, 0)
#define SQRT(a) graph_apply(g, NODE_SQRT, a, 0, 0)
#define ADD(a, b) graph_apply(g, NODE_ADD, a, b, 0)
#define SUB(a, b) graph_apply(g, NODE_SUB, a, b, 0)
#define MUL(a, b) graph_apply(g, NODE_MUL, a, b, 0)
#define DIV(a, b) graph_apply(g, NODE_DIV, a, b, 0)
#define LESS(a, b) graph_apply(g, NODE_LESS, a, b, 0)
#define LESS_EQUAL(a, b) graph_apply(g, NODE_LESS_EQUAL, a, b, 0)
#define IF(c, a, b) graph_apply(g, NODE_IF, c, a, b)
#define CALL(function, a) graph_one(g, function, a)
#define CALL2(function, a, b) graph_two(g, function, a, b)

/* Returns the derivative of a function at node X, where its value is node U; 0 if it is constant
 * between jumps. */
static int slope_one(struct graph *g, double (*function)(double), int X, int U)
{
#define ONE(name, by_x)                                                                            \
    if (function == (name))                                                                        \
        return by_x;
#define TWO(name, by_x, by_y)
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
    return 0;
}

/* Returns the derivative of a function of X and Y by the first argument, or by the second. */
static int slope_two(struct graph *g, double (*function)(double, double), int X, int Y, int U,
                     bool second)
{
#define ONE(name, by_x)
#define TWO(name, by_x, by_y)                                                                      \
    if (function == (name))                                                                        \
        return second ? by_y : by_x;
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
    return 0;
}

/* Returns the sum of two derivatives. Node 0, the number 0, stands for one that is 0 everywhere; it
 * is left out, also in the next two. */
static int sum_node(struct graph *g, int a, int b)
{
    if (a && b)
        return ADD(a, b);
    return a ? a : b;
}

static int difference(struct graph *g, int a, int b)
{
    if (a && b)
        return SUB(a, b);
    return b ? NEG(b) : a;
}

/* Returns a factor times a derivative. With graph->limits, a factor or derivative of 0 gives 0 even
 * if the other is infinite. */
static int product(struct graph *g, int factor, int slope)
{
    if (!slope || !g->limits)
        return slope ? MUL(factor, slope) : 0;
    return IF(ABS(factor), IF(ABS(slope), MUL(factor, slope), 0), 0);
}

/* Returns the derivative of node i, given those of its operands in `slope`; 0 for numbers and
 * comparisons. graph_derive() handles names. */
static int derivative(struct graph *g, const struct node *node, int i, const int *slope)
{
    const int a = node->operand[0], b = node->operand[1], c = node->operand[2];
    const int da = slope[a], db = slope[b], dc = slope[c];
    switch (node->kind) {
    case NODE_NEG:
        return da ? NEG(da) : 0;
    case NODE_ABS:
        return da ? product(g, slope_one(g, fabs, a, i), da) : 0;
    case NODE_SQRT:
        return da ? product(g, slope_one(g, sqrt, a, i), da) : 0;
    case NODE_ADD:
        return sum_node(g, da, db);
    case NODE_SUB:
        return difference(g, da, db);
    case NODE_MUL:
        return sum_node(g, product(g, b, da), product(g, a, db));
    case NODE_DIV: /* (a/b)' = (a' - (a/b) b')/b */
        return da || db ? DIV(difference(g, da, product(g, i, db)), b) : 0;
    case NODE_IF:
        return db || dc ? IF(a, db, dc) : 0;
    case NODE_ONE:
        return da ? product(g, slope_one(g, node->one, a, i), da) : 0;
    case NODE_TWO:
        return sum_node(g, da ? product(g, slope_two(g, node->two, a, b, i, false), da) : 0,
                        db ? product(g, slope_two(g, node->two, a, b, i, true), db) : 0);
    default: /* numbers and comparisons; names are seen to */
        return 0;
    }
}

/* Goes through the nodes in their order, so that operands have their derivatives before. */
void graph_derive(struct graph *g, int name, const bool *mark, int count, int *slope)
{
    for (int i = 0; i < count; i++) {
        const struct node node = g->node[i]; /* the nodes may move */
        if (node.kind == NODE_NAME)
            slope[i] = node.operand[0] == name ? NUMBER(1) : 0;
        else
            slope[i] = mark[i] ? derivative(g, &node, i, slope) : 0;
    }
}
