/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs: equations with some names known, as operations on places of a frame. The scalar form. */
#include "program.h"

#include <stdlib.h>
#include <string.h>

/* ---- binding: the graph once more, with numbers for names ---- */

/* All that the outputs need, of known names their value. result [outputs]: where the outputs are. */
static bool bind(const struct equations *e, int first, const bool *bound, const double *value, struct graph *g,
                 int *result, int outputs)
{
    bool *mark = calloc((size_t)e->graph.count, sizeof *mark);
    int *map = calloc((size_t)e->graph.count, sizeof *map);
    const bool fine = mark && map;
    for (int i = 0; fine && i < outputs; i++)
        mark[e->output[first + i]] = true;
    if (fine)
        graph_reach(e->graph.node, e->graph.count, mark);
    for (int i = 0; fine && i < e->graph.count; i++) {
        const struct node *node = &e->graph.node[i];
        const int name = node->operand[0];
        if (!mark[i])
            continue;
        if (node->kind == NODE_NUMBER)
            map[i] = graph_number(g, node->number);
        else if (node->kind == NODE_NAME)
            map[i] = bound && bound[name] ? graph_number(g, value[name]) : graph_name(g, name);
        else
            map[i] = graph_copy(g, node, map);
    }
    for (int i = 0; fine && i < outputs; i++)
        result[i] = map[e->output[first + i]];
    free(mark);
    free(map);
    return fine;
}

/* ---- scheduling ---- */

/* What is known of each node of the bound graph. */
struct usage {
    int uses;  /* by operations and outputs */
    int place; /* in the frame */
    int output; /* that it is, the last one of them; -1: none */
    bool fused;
};

struct schedule {
    struct program *program;
    struct usage *usage;
    int *free_place; /* a stack */
    int free_places;
};

/* A product that is used once, by a sum, a difference or a minus sign, becomes part of it. */
static void fuse(struct node *node, const struct node *all, struct usage *usage)
{
    if (node->kind != NODE_ADD && node->kind != NODE_SUB && node->kind != NODE_NEG)
        return;
    for (int k = 0; k < node_arity(node->kind); k++) {
        const int product = node->operand[k], other = node->operand[!k];
        if (all[product].kind != NODE_MUL || usage[product].uses != 1)
            continue;
        node->kind = node->kind == NODE_NEG   ? NODE_NEG_MUL
                     : node->kind == NODE_ADD ? NODE_MUL_ADD
                     : k == 0                 ? NODE_MUL_SUB
                                              : NODE_SUB_MUL;
        node->operand[0] = all[product].operand[0];
        node->operand[1] = all[product].operand[1];
        node->operand[2] = other;
        usage[product].fused = true;
        return;
    }
}

/* What nothing needs any more gives its place back. */
static void release(struct schedule *s, const struct node *node, struct instruction *instruction)
{
    const int constant = s->program->names + s->program->numbers;
    for (int k = 0; k < node_arity(node->kind); k++) {
        struct usage *usage = &s->usage[node->operand[k]];
        if (--usage->uses > 0 || usage->place < constant)
            continue;
        instruction->last[k] = true;
        s->free_place[s->free_places++] = usage->place;
    }
}

static void emit(struct schedule *s, const struct node *node, int i)
{
    struct program *p = s->program;
    struct instruction *instruction = &p->code[p->count++];
    *instruction = (struct instruction){.node = *node, .output = s->usage[i].uses == 1 ? s->usage[i].output : -1};
    if (instruction->output >= 0)
        p->written[instruction->output] = true;
    for (int k = 0; k < 3; k++) /* an operand that it does not have: any that is there */
        instruction->node.operand[k] = s->usage[node->operand[k < node_arity(node->kind) ? k : 0]].place;
    instruction->out = s->free_places > 0 ? s->free_place[--s->free_places] : p->places++;
    s->usage[i].place = instruction->out;
    release(s, node, instruction);
}

/* Counts uses, finds what is fused, gives places to names and numbers. False: no memory. */
static bool prepare(struct program *p, struct usage *usage, struct node *fused)
{
    for (int i = 0; i < p->nodes; i++)
        usage[i].output = -1;
    for (int i = 0; i < p->outputs; i++) {
        usage[p->result[i]].uses++;
        usage[p->result[i]].output = i;
    }
    for (int i = p->nodes - 1; i >= 0; i--)
        for (int k = 0; usage[i].uses > 0 && k < node_arity(p->node[i].kind); k++)
            usage[p->node[i].operand[k]].uses++;
    int operations = 0;
    for (int i = 0; i < p->nodes; i++) {
        fused[i] = p->node[i];
        if (usage[i].uses == 0)
            continue;
        fuse(&fused[i], p->node, usage);
        p->numbers += fused[i].kind == NODE_NUMBER;
        p->uses += fused[i].kind == NODE_NAME;
        operations += fused[i].kind > NODE_NAME;
    }
    p->number = arena_array(&p->arena, (size_t)p->numbers + 1, sizeof *p->number);
    p->used = arena_array(&p->arena, (size_t)p->uses + 1, sizeof *p->used);
    p->code = arena_array(&p->arena, (size_t)operations + 1, sizeof *p->code);
    if (!p->number || !p->used || !p->code)
        return false;
    p->places = p->names;
    p->uses = 0;
    for (int i = 0; i < p->nodes; i++) {
        if (usage[i].uses > 0 && fused[i].kind == NODE_NUMBER) {
            p->number[p->places - p->names] = fused[i].number;
            usage[i].place = p->places++;
        } else if (usage[i].uses > 0 && fused[i].kind == NODE_NAME) {
            usage[i].place = p->used[p->uses++] = fused[i].operand[0];
        }
    }
    return true;
}

static bool schedule(struct program *p)
{
    const size_t nodes = (size_t)p->nodes;
    struct schedule s = {.program = p, .usage = calloc(nodes, sizeof *s.usage)};
    struct node *fused = malloc(nodes * sizeof *fused);
    s.free_place = malloc(nodes * sizeof *s.free_place);
    const bool fine = s.usage && fused && s.free_place && prepare(p, s.usage, fused);
    for (int i = 0; fine && i < p->nodes; i++)
        if (s.usage[i].uses > 0 && !s.usage[i].fused && fused[i].kind > NODE_NAME)
            emit(&s, &fused[i], i);
    for (int i = 0; fine && i < p->outputs; i++) {
        p->output[i] = s.usage[p->result[i]].place;
        p->copies += !p->written[i];
    }
    free(s.usage);
    free(fused);
    free(s.free_place);
    return fine;
}

/* The scalar form. */
static double interpret(const struct program *p, const double *input, double *output, double *frame)
{
    if (input != frame)
        for (int i = 0; i < p->uses; i++)
            frame[p->used[i]] = input[p->used[i]];
#define CASE(kind)                                                                                                     \
    case kind:                                                                                                         \
        frame[i->out] = node_value(kind, &i->node, frame[place[0]], frame[place[1]], frame[place[2]]);                 \
        break;
    for (const struct instruction *i = p->code, *end = i + p->count; i < end; i++) {
        const int *place = i->node.operand;
        switch (i->node.kind) {
            OPERATIONS(CASE)
        default: /* no operations */
            break;
        }
    }
#undef CASE
    for (int i = 0; i < p->outputs; i++)
        output[i] = frame[p->output[i]];
    return output[0];
}

struct program *program_create(const struct equations *e, int first, int count, const bool *bound, const double *value,
                               bool native, struct error *error)
{
    struct program *p = calloc(1, sizeof *p);
    if (!p) {
        error_memory(error);
        return NULL;
    }
    p->names = e->names;
    p->outputs = count;
    p->output = arena_array(&p->arena, 2 * (size_t)count + 1, sizeof *p->output);
    p->result = p->output + count;
    p->written = arena_array(&p->arena, (size_t)count, sizeof *p->written);
    struct graph graph;
    graph_init(&graph, &p->arena, true);
    bool fine = p->output && p->written && bind(e, first, bound, value, &graph, p->result, count);
    if (!fine)
        error_memory(error);
    fine = fine && graph_check(&graph, error);
    p->node = graph.node;
    p->nodes = graph.count;
    if (fine && !schedule(p))
        fine = error_memory(error);
    if (!fine) {
        program_destroy(p);
        return NULL;
    }
    p->run = interpret;
    p->native = native ? native_create(p, &p->run) : NULL;
    return p;
}

void program_destroy(struct program *p)
{
    if (!p)
        return;
    native_destroy(p->native);
    arena_reset(&p->arena);
    free(p);
}

/* ---- questions ---- */

bool program_native(const struct program *p)
{
    return p->native;
}

int program_operations(const struct program *p)
{
    return p->count;
}

bool program_constant(const struct program *p, int output, double *value)
{
    const struct node *node = &p->node[p->result[output]];
    if (node->kind == NODE_NUMBER)
        *value = node->number;
    return node->kind == NODE_NUMBER;
}

bool program_depends(const struct program *p, int first, int count, int name)
{
    bool *mark = calloc((size_t)p->nodes, sizeof *mark), found = !mark;
    for (int i = 0; mark && i < count; i++)
        mark[p->result[first + i]] = true;
    if (mark)
        graph_reach(p->node, p->nodes, mark);
    for (int i = 0; mark && !found && i < p->nodes; i++)
        found = mark[i] && p->node[i].kind == NODE_NAME && p->node[i].operand[0] == name;
    free(mark);
    return found;
}

/* ---- evaluation ---- */

size_t program_frame(const struct program *p)
{
    return (size_t)p->places;
}

void program_prepare(const struct program *p, double *frame)
{
    if (!p->native) /* machine code has them beside it */
        memcpy(frame + p->names, p->number, (size_t)p->numbers * sizeof *frame);
}

double program_eval(const struct program *p, const double *input, double *output, double *frame)
{
    return p->run(p, input, output, frame);
}
