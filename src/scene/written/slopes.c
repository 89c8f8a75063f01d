/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jacobians as expressions: out of the graph by which typed scenes get theirs, and of built-in
 * terms where they are computed in another order. */
#include <stdlib.h>
#include <string.h>

#include "scene/formula/program/program.h"
#include "scene/written/written_terms.h"

struct taking {
    struct written *written;
    struct equations *equations;
    int *entry; /* [rows][n] nodes, 0: nothing */
    int *uses;  /* [nodes] */
    int *part;  /* [nodes] name of what is used more than once, 0: it is not */
    struct error *error;
};

/* ---- sums of derivatives ---- */

static bool add_expr(struct taking *t, const struct expr *expr, int *node)
{
    if (!equations_add(t->equations, expr, t->error))
        return false;
    *node = t->equations->output[t->equations->outputs - 1];
    return true;
}

static bool add_term(struct taking *t, const struct bound_term *term)
{
    struct written *w = t->written;
    const int n = w->system.n;
    int state[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        state[i] = 1 + i;
    for (int row = 0; row < w->rows; row++) {
        const struct expr *expr;
        int node;
        if (!written_term_row(w, term, row, false, &expr, t->error))
            return false;
        if (!expr)
            continue;
        if (cancelled(w->cancel))
            return error_set(t->error, ERROR_CANCELLED, "stopped: nothing was written");
        if (!add_expr(t, expr, &node) ||
            !equations_derive(t->equations, t->equations->outputs - 1, 1, state, n, t->error))
            return false;
        int *const by = t->equations->output + t->equations->outputs - n;
        for (int i = 0; i < n; i++) {
            const char *const own = term->row->bind ? term->row->slope[row * n + i] : NULL;
            const struct expr *const text = own ? written_slope_text(w, own, t->error) : NULL;
            int slope = by[i], *sum = &t->entry[row * n + i];
            if (own && (!text || !add_expr(t, text, &slope)))
                return false;
            if (slope)
                *sum = *sum ? graph_apply(&t->equations->graph, NODE_ADD, *sum, slope, 0) : slope;
        }
    }
    return true;
}

/* ---- nodes as expressions ---- */

static const struct function *function_of(const struct node *node)
{
    for (size_t i = 0; i < function_catalog.count; i++) {
        const struct function *f =
            (const struct function *)(const void *)catalog_row(&function_catalog, i);
        if ((node->kind == NODE_ONE && f->one == node->one) ||
            (node->kind == NODE_TWO && f->two == node->two) ||
            (node->kind == NODE_ABS && f->one == fabs) ||
            (node->kind == NODE_SQRT && f->one == sqrt) || (node->kind == NODE_IF && f->three))
            return f;
    }
    return NULL;
}

static struct op op_of(const struct node *node)
{
    static const enum op_kind kind[] = {[NODE_NEG] = OP_NEG,
                                        [NODE_ADD] = OP_ADD,
                                        [NODE_SUB] = OP_SUB,
                                        [NODE_MUL] = OP_MUL,
                                        [NODE_DIV] = OP_DIV,
                                        [NODE_LESS] = OP_LESS,
                                        [NODE_LESS_EQUAL] = OP_LESS_EQUAL};
    const struct function *const function = function_of(node);
    if (function)
        return (struct op){.kind = OP_CALL, .function = function};
    return (struct op){.kind = kind[node->kind]};
}

/* Each level leaves at most two values on the stack of an expression. */
enum { DEPTH_MAX = LIMIT_EXPR_DEPTH / 2 };

/* The node's own operation, its operands before it; names for parts, unless it is one itself. What
 * is too long or too deep ends at LIMIT_EXPR_SIZE. */
static size_t put_node(const struct taking *t, int node, int depth, struct op *op, size_t count)
{
    const struct node *const at = &t->equations->graph.node[node];
    struct op own = {.kind = OP_NUMBER, .number = at->number};
    if (at->kind == NODE_NAME)
        own = (struct op){.kind = OP_NAME, .slot = at->operand[0]};
    else if (at->kind != NODE_NUMBER && depth > 0 && t->part[node])
        own = (struct op){.kind = OP_NAME, .slot = t->part[node]};
    else if (at->kind != NODE_NUMBER) {
        if (depth == DEPTH_MAX)
            return LIMIT_EXPR_SIZE;
        for (int i = 0; i < node_arity(at->kind) && count < LIMIT_EXPR_SIZE; i++)
            count = put_node(t, at->operand[i], depth + 1, op, count);
        own = op_of(at);
    }
    if (count >= LIMIT_EXPR_SIZE)
        return LIMIT_EXPR_SIZE;
    op[count] = own;
    return count + 1;
}

static const struct expr *expr_of(struct taking *t, int node, bool itself)
{
    struct op *op = malloc((LIMIT_EXPR_SIZE + 1) * sizeof *op);
    struct arena *const arena = &t->written->arena;
    struct expr *expr = op ? arena_alloc(arena, sizeof *expr) : NULL;
    const size_t count = expr ? put_node(t, node, itself ? 0 : 1, op, 0) : 0;
    struct op *own = count > 0 ? arena_array(arena, count, sizeof *own) : NULL;
    if (own)
        memcpy(own, op, count * sizeof *own);
    free(op);
    if (!own)
        return error_memory(t->error), NULL;
    *expr = (struct expr){.op = own, .count = count, .capacity = count};
    if (count < LIMIT_EXPR_SIZE)
        return expr;
    error_set(t->error, ERROR_COMMAND,
              "the derivatives have more than %d operations, or more than %d inside of each other",
              LIMIT_EXPR_SIZE, DEPTH_MAX);
    return NULL;
}

static void count_uses(const struct taking *t, int entries)
{
    const struct graph *g = &t->equations->graph;
    bool *reached = calloc((size_t)g->count, sizeof *reached);
    for (int i = 0; reached && i < entries; i++) {
        reached[t->entry[i]] = true;
        t->uses[t->entry[i]]++;
    }
    if (reached)
        graph_reach(g->node, g->count, reached);
    for (int i = 0; reached && i < g->count; i++)
        for (int k = 0; reached[i] && k < node_arity(g->node[i].kind); k++)
            t->uses[g->node[i].operand[k]]++;
    free(reached);
}

static bool take(struct taking *t, struct written_slopes *slopes)
{
    struct written *w = t->written;
    const struct graph *g = &t->equations->graph;
    const int entries = w->rows * w->system.n;
    if (!graph_check(g, t->error))
        return false;
    t->uses = arena_array(&w->arena, (size_t)g->count, sizeof *t->uses);
    t->part = arena_array(&w->arena, (size_t)g->count, sizeof *t->part);
    slopes->entry = arena_array(&w->arena, (size_t)entries, sizeof(const struct expr *));
    slopes->part = arena_array(&w->arena, (size_t)g->count, sizeof(const struct expr *));
    if (!t->uses || !t->part || !slopes->entry || !slopes->part)
        return error_memory(t->error);
    bool *zero = arena_array(&w->arena, (size_t)(w->names + g->count), sizeof *zero);
    if (!zero)
        return error_memory(t->error);
    memcpy(zero, w->zero, (size_t)w->names * sizeof *zero);
    w->zero = zero;
    count_uses(t, entries);
    for (int i = 1; i < g->count; i++) {
        const enum node_kind kind = g->node[i].kind;
        if (t->uses[i] < 2 || kind == NODE_NUMBER || kind == NODE_NAME || kind == NODE_NEG)
            continue;
        if (!(slopes->part[slopes->parts] = expr_of(t, i, true)))
            return false;
        zero[w->names + slopes->parts] = expr_absent(slopes->part[slopes->parts], zero);
        t->part[i] = w->names + slopes->parts++;
    }
    for (int i = 0; i < entries; i++)
        if (t->entry[i] && !(slopes->entry[i] = expr_of(t, t->entry[i], false)))
            return false;
    return true;
}

bool written_slopes(struct written *w, struct written_slopes *slopes, struct error *error)
{
    struct taking t = {.written = w, .error = error};
    *slopes = (struct written_slopes){0};
    t.entry = arena_array(&w->arena, (size_t)(w->rows * w->system.n), sizeof *t.entry);
    if (!t.entry)
        return error_memory(error);
    t.equations = equations_create(w->names, error);
    bool fine = t.equations;
    for (int i = w->observed; fine && i < w->names; i++)
        fine = equations_let(t.equations, i, w->observe[i - w->observed], error);
    for (int i = 0; fine && i < w->system.terms; i++)
        fine = w->system.term[i].row->flags & TERM_DRY || add_term(&t, &w->system.term[i]);
    fine = fine && take(&t, slopes);
    equations_destroy(t.equations);
    return fine;
}
