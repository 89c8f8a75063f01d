/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equations: expressions in the same names, and their derivatives, in one graph. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "scene/formula/program/program.h"

/* Creates equations without outputs, in which each name means itself. */
struct equations *equations_create(int names, struct error *error)
{
    struct equations *e = calloc(1, sizeof *e);
    if (!e) {
        error_memory(error);
        return NULL;
    }
    graph_init(&e->graph, &e->arena, false);
    e->names = names;
    e->meaning = arena_array(&e->arena, (size_t)names + 1, sizeof *e->meaning);
    for (int i = 0; e->meaning && i < names; i++)
        e->meaning[i] = graph_name(&e->graph, i);
    if (!e->meaning || !graph_check(&e->graph, error)) {
        error_memory(error);
        equations_destroy(e);
        return NULL;
    }
    return e;
}

void equations_destroy(struct equations *e)
{
    if (e)
        arena_reset(&e->arena);
    free(e);
}

/* ---- from postfix order ---- */

/* Returns the node of a function of the nodes x. */
static int add_call(struct graph *g, const struct function *f, const int *x)
{
    if (f->one)
        return graph_one(g, f->one, x[0]);
    return f->two ? graph_two(g, f->two, x[0], x[1]) : graph_apply(g, NODE_IF, x[0], x[1], x[2]);
}

/* Returns the node of an operation of an expression on the nodes x. */
static int add_operation(struct graph *g, const struct op *op, const int *x)
{
    switch (op->kind) {
    case OP_NEG:
        return graph_apply(g, NODE_NEG, x[0], 0, 0);
    case OP_LESS:
        return graph_apply(g, NODE_LESS, x[0], x[1], 0);
    case OP_GREATER:
        return graph_apply(g, NODE_LESS, x[1], x[0], 0);
    case OP_LESS_EQUAL:
        return graph_apply(g, NODE_LESS_EQUAL, x[0], x[1], 0);
    case OP_GREATER_EQUAL:
        return graph_apply(g, NODE_LESS_EQUAL, x[1], x[0], 0);
    case OP_ADD:
        return graph_apply(g, NODE_ADD, x[0], x[1], 0);
    case OP_SUB:
        return graph_apply(g, NODE_SUB, x[0], x[1], 0);
    case OP_MUL:
        return graph_apply(g, NODE_MUL, x[0], x[1], 0);
    case OP_DIV:
        return graph_apply(g, NODE_DIV, x[0], x[1], 0);
    case OP_POW:
        return graph_two(g, function_power, x[0], x[1]);
    case OP_CALL:
        return add_call(g, op->function, x);
    case OP_NUMBER: /* values */
    case OP_NAME:
        break;
    }
    return 0;
}

/* Adds an expression to the graph, with names replaced by their definitions, and returns its
 * node. */
static int add_expr(struct equations *e, const struct expr *expr)
{
    enum { BOTTOM = 3 }; /* zeros below the stack, as many as a function takes */
    int stack[BOTTOM + LIMIT_EXPR_DEPTH] = {0}, *top = stack + BOTTOM;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER) {
            *top++ = graph_number(&e->graph, op->number);
        } else if (op->kind == OP_NAME) {
            assert(op->slot >= 0 && op->slot < e->names);
            *top++ = e->meaning[op->slot];
        } else {
            top -= op_arity(op);
            *top = add_operation(&e->graph, op, top);
            top++;
        }
    }
    return stack[BOTTOM];
}

/* Defines a name by an expression: later expressions that use the name contain it. */
bool equations_let(struct equations *e, int name, const struct expr *expr, struct error *error)
{
    const int node = add_expr(e, expr);
    if (!graph_check(&e->graph, error))
        return false;
    e->meaning[name] = node;
    return true;
}

/* Makes room for `more` outputs; returns false if out of memory. */
bool equations_reserve(struct equations *e, int more)
{
    if (e->outputs + more <= e->capacity)
        return true;
    const int capacity = 2 * e->capacity + more;
    int *output = arena_array(&e->arena, (size_t)capacity, sizeof *output);
    if (!output)
        return false;
    if (e->outputs)
        memcpy(output, e->output, (size_t)e->outputs * sizeof *output);
    e->output = output;
    e->capacity = capacity;
    return true;
}

/* Adds the expression to the graph and its node to the outputs. */
bool equations_add(struct equations *e, const struct expr *expr, struct error *error)
{
    const int node = add_expr(e, expr);
    if (!graph_check(&e->graph, error))
        return false;
    if (!equations_reserve(e, 1))
        return error_memory(error);
    e->output[e->outputs++] = node;
    return true;
}

void equations_keep_limits(struct equations *e)
{
    e->graph.limits = true;
}

void equations_exact(struct equations *e, bool exact)
{
    e->exact = exact;
}

int equations_count(const struct equations *e)
{
    return e->outputs;
}

/* Adds the derivatives of `count` outputs from `first` on by each name, output by output. */
bool equations_derive(struct equations *e, int first, int count, const int *name, int names,
                      struct error *error)
{
    const int node_count = e->graph.count;
    if (names > 0 && count > PROGRAM_SIZE / names)
        e->graph.failed = GRAPH_FULL;
    if (!graph_check(&e->graph, error))
        return false;
    bool *mark = calloc((size_t)node_count, sizeof *mark);
    int *slope = malloc((size_t)node_count * sizeof *slope);
    const bool fine = mark && slope && equations_reserve(e, count * names);
    for (int i = 0; fine && i < count; i++)
        mark[e->output[first + i]] = true;
    if (fine)
        graph_reach(e->graph.node, node_count, mark);
    for (int j = 0; fine && j < names && !e->graph.failed; j++) {
        graph_derive(&e->graph, name[j], mark, node_count, slope);
        for (int i = 0; i < count; i++)
            e->output[e->outputs + i * names + j] = slope[e->output[first + i]];
    }
    free(mark);
    free(slope);
    if (!fine)
        return error_memory(error);
    if (!graph_check(&e->graph, error))
        return false;
    e->outputs += count * names;
    return true;
}
