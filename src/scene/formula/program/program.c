/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs: equations in which some names have known values, as a list of operations on places of a
 * frame; the interpreter of that list; and retained values. program_create_keeping() binds the
 * names, schedules the operations and lets native_create() translate them. */
#include "scene/formula/program/program.h"

#include <stdlib.h>
#include <string.h>

/* ---- binding: the graph once more, with numbers for names ---- */

/* Copies all that the outputs from `first` on need into the graph g, with the values of bound names
 * in their place. Sets result [outputs] to their nodes there. Returns false if out of memory. */
static bool outputs_bind(const struct equations *e, int first, const bool *bound,
                         const double *value, struct graph *g, int *result, int outputs)
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
            map[i] = bound && bound[name] ? graph_known(g, value[name]) : graph_name(g, name);
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

/* Facts about each node of the bound graph. */
struct usage {
    int uses;   /* number of uses by operations and outputs that follow */
    int slot;   /* its place in the frame */
    int output; /* index of the last output that it is; -1 if it is none */
    bool fused; /* it is a product that has become part of the operation that uses it */
};

/* State while the operations of a program are put in order and get their places. */
struct schedule {
    struct program *program;
    struct usage *usage; /* [nodes] */
    struct node *node;   /* [nodes] copies; retained values become names, then products are fused */
    int *free_slot;      /* [free_slots] places that can be used again, as a stack */
    int free_slots;
};

/* Makes a product that is used once, by this sum, difference or minus sign, a part of it. */
static void product_fuse(struct node *node, const struct node *all, struct usage *usage)
{
    if (node->kind != NODE_ADD && node->kind != NODE_SUB && node->kind != NODE_NEG)
        return;
    for (int k = 0; k < node_arity(node->kind); k++) {
        const int product = node->operand[k], other = node->operand[!k];
        if (all[product].kind != NODE_MUL || usage[product].uses != 1)
            continue;
        if (node->kind == NODE_NEG)
            node->kind = NODE_NEG_MUL;
        else if (node->kind == NODE_ADD)
            node->kind = NODE_MUL_ADD;
        else
            node->kind = k == 0 ? NODE_MUL_SUB : NODE_SUB_MUL;
        node->operand[0] = all[product].operand[0];
        node->operand[1] = all[product].operand[1];
        node->operand[2] = other;
        usage[product].fused = true;
        return;
    }
}

/* Counts the uses of this node's operands down. An operand that has no other use left is the last,
 * and its place becomes free, unless it holds a name or a number. */
static void release(struct schedule *s, const struct node *node, struct instruction *instruction)
{
    const int constant = s->program->names + s->program->numbers;
    for (int k = 0; k < node_arity(node->kind); k++) {
        struct usage *usage = &s->usage[node->operand[k]];
        instruction->last[k] = --usage->uses == 0;
        if (instruction->last[k] && usage->slot >= constant)
            s->free_slot[s->free_slots++] = usage->slot;
    }
}

/* Appends the operation of node i to the program, with a place for its result. */
static void instruction_emit(struct schedule *s, const struct node *node, int i)
{
    struct program *p = s->program;
    struct instruction *instruction = &p->code[p->count++];
    *instruction = (struct instruction){.node = *node,
                                        .output = s->usage[i].uses == 1 ? s->usage[i].output : -1};
    if (instruction->output >= 0)
        p->written[instruction->output] = true;
    for (int k = 0; k < 3; k++) /* operands that it does not have are the first one again */
        instruction->node.operand[k] =
            s->usage[node->operand[k < node_arity(node->kind) ? k : 0]].slot;
    instruction->target_slot = s->free_slots > 0 ? s->free_slot[--s->free_slots] : p->slots++;
    s->usage[i].slot = instruction->target_slot;
    release(s, node, instruction);
}

/* Counts how often each node is used, fuses products with sums, and assigns slots to the names and
 * numbers in use; allocates the program's arrays. Returns false if out of memory. */
static bool prepare(struct schedule *s)
{
    struct program *p = s->program;
    struct usage *usage = s->usage;
    struct node *node = s->node;
    for (int i = 0; i < p->nodes; i++)
        usage[i].output = -1;
    for (int i = 0; i < p->outputs; i++) {
        usage[p->result[i]].uses++;
        usage[p->result[i]].output = i;
    }
    for (int i = p->nodes - 1; i >= 0; i--)
        for (int k = 0; usage[i].uses > 0 && k < node_arity(node[i].kind); k++)
            usage[node[i].operand[k]].uses++;
    int operations = 0;
    for (int i = 0; i < p->nodes; i++) {
        if (usage[i].uses == 0)
            continue;
        product_fuse(&node[i], node, usage);
        p->numbers += node[i].kind == NODE_NUMBER;
        p->uses += node[i].kind == NODE_NAME;
        operations += node[i].kind > NODE_NAME;
    }
    p->number = arena_array(&p->arena, (size_t)p->numbers + 1, sizeof *p->number);
    p->used = arena_array(&p->arena, (size_t)p->uses + 1, sizeof *p->used);
    p->code = arena_array(&p->arena, (size_t)operations + 1, sizeof *p->code);
    if (!p->number || !p->used || !p->code)
        return false;
    p->slots = p->names;
    p->uses = 0;
    for (int i = 0; i < p->nodes; i++) {
        if (usage[i].uses > 0 && node[i].kind == NODE_NUMBER) {
            p->number[p->slots - p->names] = node[i].number;
            usage[i].slot = p->slots++;
        } else if (usage[i].uses > 0 && node[i].kind == NODE_NAME) {
            usage[i].slot = p->used[p->uses++] = node[i].operand[0];
        }
    }
    return true;
}

/* Makes the operations of the program from its graph. The nodes `retained` [p->keeps], unless NULL,
 * become the last names. Returns false if out of memory. */
static bool schedule(struct program *p, const int *retained)
{
    const size_t nodes = (size_t)p->nodes;
    struct schedule s = {.program = p, .usage = calloc(nodes, sizeof *s.usage)};
    s.node = malloc(nodes * sizeof *s.node);
    s.free_slot = malloc(nodes * sizeof *s.free_slot);
    bool fine = s.usage && s.node && s.free_slot;
    if (fine)
        memcpy(s.node, p->node, nodes * sizeof *s.node);
    for (int i = 0; fine && retained && i < p->keeps; i++)
        s.node[retained[i]] =
            (struct node){.kind = NODE_NAME, .operand = {p->names - p->keeps + i}};
    fine = fine && prepare(&s);
    for (int i = 0; fine && i < p->nodes; i++)
        if (s.usage[i].uses > 0 && !s.usage[i].fused && s.node[i].kind > NODE_NAME)
            instruction_emit(&s, &s.node[i], i);
    for (int i = 0; fine && i < p->outputs; i++) {
        p->output[i] = s.usage[p->result[i]].slot;
        p->copies += !p->written[i];
    }
    free(s.usage);
    free(s.node);
    free(s.free_slot);
    return fine;
}

/* ---- the scalar form ---- */

/* Runs the program by interpretation: loads the names in use into the frame (x0, x1, x2 are the
 * first three, `state` those that move, `steady` the others), applies the operations, and returns
 * the first two outputs; further ones are written to output. */
static struct leading interpret(const struct program *p, double x0, double x1, double x2,
                                const double *state, const double *steady, double *output,
                                double *frame)
{
    const double leading[LEADING] = {x0, x1, x2};
    for (int i = 0; i < p->uses; i++) {
        const int name = p->used[i];
        frame[name] = name >= p->moving ? steady[name - p->moving]
                      : name < LEADING  ? leading[name]
                                        : state[name - 1];
    }
#define CASE(kind)                                                                                 \
    case kind:                                                                                     \
        frame[i->target_slot] =                                                                    \
            node_value(kind, &i->node, frame[slot[0]], frame[slot[1]], frame[slot[2]]);            \
        break;
    for (const struct instruction *i = p->code, *end = i + p->count; i < end; i++) {
        const int *slot = i->node.operand;
        switch (i->node.kind) {
            OPERATIONS(CASE)
        default: /* no operations */
            break;
        }
    }
#undef CASE
    for (int i = 2; i < p->outputs; i++)
        output[i] = frame[p->output[i]];
    return (struct leading){frame[p->output[0]], frame[p->output[p->outputs > 1]]};
}

/* ---- retained values ---- */

/* Finds the nodes that depend on steady names only and are used by other nodes or are outputs. Sets
 * `retained` to them and returns their number, or -1 if out of memory. */
static int find_retained(const struct program *p, int *retained)
{
    bool *steady = calloc((size_t)p->nodes, sizeof *steady),
         *mark = calloc((size_t)p->nodes, sizeof *mark);
    int count = steady && mark ? 0 : -1;
    for (int i = 0; count == 0 && i < p->outputs; i++)
        mark[p->result[i]] = true;
    for (int i = 0; count == 0 && i < p->nodes; i++) {
        const struct node *node = &p->node[i];
        steady[i] = node->kind != NODE_NAME || node->operand[0] >= p->moving;
        for (int k = 0; k < node_arity(node->kind); k++)
            steady[i] = steady[i] && steady[node->operand[k]];
    }
    for (int i = p->nodes - 1; count == 0 && i >= 0; i--) /* steady ones pass no mark on */
        for (int k = 0; mark[i] && !steady[i] && k < node_arity(p->node[i].kind); k++)
            mark[p->node[i].operand[k]] = true;
    for (int i = 0; count >= 0 && i < p->nodes; i++)
        if (mark[i] && steady[i] && p->node[i].kind > NODE_NAME)
            retained[count++] = i;
    free(steady);
    free(mark);
    return count;
}

/* Makes p->keep, the program that computes the nodes `retained` [count], unless it would be too
 * large. Returns false if out of memory. */
static bool make_retained(struct program *p, const struct steady_names *steady, const int *retained,
                          int count)
{
    struct program *keep = calloc(1, sizeof *keep);
    if (!keep)
        return false;
    *keep = (struct program){
        .run = interpret, .moving = p->moving, .names = p->names, .outputs = count};
    keep->node = p->node;
    keep->nodes = p->nodes;
    keep->result = arena_array(&keep->arena, 2 * (size_t)count, sizeof *keep->result);
    keep->written = arena_array(&keep->arena, (size_t)count, sizeof *keep->written);
    bool fine = keep->result && keep->written;
    if (fine) {
        keep->output = keep->result + count;
        memcpy(keep->result, retained, (size_t)count * sizeof *retained);
        fine = schedule(keep, NULL);
    }
    if (!fine || keep->slots > PROGRAM_KEEP) {
        program_destroy(keep);
        return fine;
    }
    p->keep = keep;
    p->keeps = count;
    p->names = steady->first + steady->retained + count;
    return true;
}

/* Schedules the program, with its retained values in a program of their own if there are any and
 * not too many. Returns false if out of memory. */
static bool schedule_in_parts(struct program *p, const struct steady_names *steady)
{
    if (!steady || steady->max <= 0)
        return schedule(p, NULL);
    int *retained = malloc((size_t)p->nodes * sizeof *retained);
    const int count = retained ? find_retained(p, retained) : -1;
    bool fine = count >= 0;
    if (count > 0 && count <= steady->max)
        fine = make_retained(p, steady, retained, count);
    fine = fine && schedule(p, retained);
    free(retained);
    return fine;
}

/* Runs the program of retained values, whose results follow the steady names. */
void program_keep(const struct program *p, double *steady)
{
    double few[PROGRAM_FEW], *frame = p->keep ? program_place(p->keep, few) : few;
    struct leading leading = {NAN, NAN};
    if (!p->keep)
        return;
    double *const retained = steady + p->names - p->keeps - p->moving;
    for (int i = 0; !frame && i < p->keeps; i++)
        retained[i] = NAN;
    if (frame) {
        program_prepare(p->keep, frame);
        leading = p->keep->run(p->keep, 0, 0, 0, NULL, steady, retained, frame);
    }
    retained[0] = leading.first;
    if (p->keeps > 1)
        retained[1] = leading.second;
    if (frame != few)
        free(frame);
}

/* ---- making and destroying ---- */

/* Binds names that are known, schedules the operations, and translates them to machine code. */
struct program *program_create_keeping(const struct equations *e, int first, int count,
                                       const bool *bound, const double *value,
                                       const struct steady_names *steady, bool native,
                                       struct error *error)
{
    struct program *p = calloc(1, sizeof *p);
    if (!p) {
        error_memory(error);
        return NULL;
    }
    p->names = e->names;
    p->moving = steady ? steady->first : e->names;
    p->outputs = count;
    p->output = arena_array(&p->arena, 2 * (size_t)count + 1, sizeof *p->output);
    p->result = p->output + count;
    p->written = arena_array(&p->arena, (size_t)count, sizeof *p->written);
    struct graph graph;
    graph_init(&graph, &p->arena, true);
    graph.has_terms = !e->exact;
    bool fine =
        p->output && p->written && outputs_bind(e, first, bound, value, &graph, p->result, count);
    if (!fine)
        error_memory(error);
    fine = fine && graph_check(&graph, error);
    p->node = graph.node;
    p->nodes = graph.count;
    if (fine && !schedule_in_parts(p, steady))
        fine = error_memory(error);
    if (!fine) {
        program_destroy(p);
        return NULL;
    }
    p->run = interpret;
    p->native = native ? native_create(p, &p->run, &p->remembered) : NULL;
    return p;
}

struct program *program_create(const struct equations *e, int first, int count, const bool *bound,
                               const double *value, bool native, struct error *error)
{
    return program_create_keeping(e, first, count, bound, value, NULL, native, error);
}

/* Frees the program with everything that it owns. */
void program_destroy(struct program *p)
{
    if (!p)
        return;
    program_destroy(p->keep);
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

/* Returns true, with its value, if an output is a number. */
bool program_constant(const struct program *p, int output, double *value)
{
    const struct node *node = &p->node[p->result[output]];
    if (node->kind == NODE_NUMBER)
        *value = node->number;
    return node->kind == NODE_NUMBER;
}

/* Marks what the outputs need, and looks for the names among it. */
bool program_depends_on(const struct program *p, int first, int count, int name, int names)
{
    bool *mark = calloc((size_t)p->nodes, sizeof *mark), found = !mark;
    for (int i = 0; mark && i < count; i++)
        mark[p->result[first + i]] = true;
    if (mark)
        graph_reach(p->node, p->nodes, mark);
    for (int i = 0; mark && !found && i < p->nodes; i++)
        found = mark[i] && p->node[i].kind == NODE_NAME && p->node[i].operand[0] >= name &&
                p->node[i].operand[0] < name + names;
    free(mark);
    return found;
}

bool program_depends(const struct program *p, int first, int count, int name)
{
    return program_depends_on(p, first, count, name, 1);
}

/* ---- evaluation ---- */

program_function *program_code(const struct program *p)
{
    return p->run;
}

size_t program_frame(const struct program *p)
{
    return (size_t)p->slots + 2 * (size_t)p->remembered;
}

/* Writes the program's numbers into a frame, and clears remembered arguments. */
void program_prepare(const struct program *p, double *frame)
{
    if (!p->native) /* machine code has the numbers in its page */
        memcpy(frame + p->names, p->number, (size_t)p->numbers * sizeof *frame);
    const uint64_t none = PROGRAM_NO_ARGUMENT;
    for (int i = 0; i < 2 * p->remembered; i++)
        memcpy(&frame[p->slots + i], &none, sizeof none);
}

/* Runs the program on the values of all its names. Returns output 0. */
double program_eval(const struct program *p, const double *input, double *output, double *frame)
{
    double x[LEADING] = {0};
    for (int i = 0; i < LEADING && i < p->names; i++)
        x[i] = input[i];
    const double *const state = input + (p->names > 1), *const steady = input + p->moving;
    const struct leading leading = p->run(p, x[0], x[1], x[2], state, steady, output, frame);
    output[0] = leading.first;
    if (p->outputs > 1)
        output[1] = leading.second;
    return leading.first;
}
