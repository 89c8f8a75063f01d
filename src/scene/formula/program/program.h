/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Expressions as a graph without repetitions, and the program that it becomes. */
#pragma once

#include "scene/formula/expr.h"

#include <stdlib.h>

/* ---- the graph ----
 *
 * A node is a number, a name, or an operation on earlier nodes; equal nodes are one. Made simpler
 * as it grows.
 */

enum node_kind {
    NODE_NUMBER,
    NODE_NAME,
    NODE_NEG,
    NODE_ABS,
    NODE_SQRT,
    NODE_ADD,
    NODE_SUB,
    NODE_MUL,
    NODE_DIV,
    NODE_LESS,
    NODE_LESS_EQUAL,
    NODE_IF, /* a > 0 ? b : c */
    NODE_ONE,
    NODE_TWO,
    /* Only in programs; rounded twice, as two operations: a b + c, a b - c, c - a b, -(a b) */
    NODE_MUL_ADD,
    NODE_MUL_SUB,
    NODE_SUB_MUL,
    NODE_NEG_MUL,
    NODE_KINDS
};

/* Source of a number that is 0: it was typed or computed, is the value of a known name, or is a
 * term whose coefficient is 0. */
enum zero_mark { ZERO_NUMBER, ZERO_NAME, ZERO_TERM };

struct node {
    enum node_kind kind;
    int operand[3]; /* nodes, earlier ones; of a name: the name; of a number: its zero_mark */
    union {
        double number;
        double (*one)(double);
        double (*two)(double, double);
    };
};

/* Node 0 is the number 0. After a failure `failed` is set and everything is node 0: check once at
 * the end. */
struct graph {
    struct arena *arena;
    struct node *node;
    int count, capacity;
    int *table; /* hashed nodes, 0 where free; `slots` is a power of two */
    unsigned slots;
    bool binds;     /* known names are numbers: powers become multiplications */
    bool has_terms; /* those whose coefficient is 0 are absent */
    bool limits;    /* a factor of 0 beside an infinite one gives 0 in derivatives */
    enum { GRAPH_FINE, GRAPH_NO_MEMORY, GRAPH_FULL } failed;
};

void graph_init(struct graph *graph, struct arena *arena, bool binds);
int graph_number(struct graph *graph, double number);
/* Returns the node of a known name with this value. */
int graph_known(struct graph *graph, double value);
int graph_name(struct graph *graph, int name);
/* NODE_NEG … NODE_IF */
int graph_apply(struct graph *graph, enum node_kind kind, int a, int b, int c);
int graph_one(struct graph *graph, double (*one)(double), int a);
int graph_two(struct graph *graph, double (*two)(double, double), int a, int b);
/* the operation, on the map's nodes */
int graph_copy(struct graph *graph, const struct node *node, const int *map);
bool graph_check(const struct graph *graph, struct error *error);
/* Marks [count] what the marked nodes need. */
void graph_reach(const struct node *node, int count, bool *mark);
int node_arity(enum node_kind kind);

/* The value of an operation of this kind, which is a constant where this is the body of a loop. */
static inline __attribute__((always_inline)) double
node_value(enum node_kind kind, const struct node *node, double a, double b, double c)
{
    switch (kind) {
    case NODE_NUMBER:
    case NODE_NAME:
    case NODE_KINDS:
        break;
    case NODE_NEG:
        return -a;
    case NODE_ABS:
        return fabs(a);
    case NODE_SQRT:
        return sqrt(a);
    case NODE_ADD:
        return a + b;
    case NODE_SUB:
        return a - b;
    case NODE_MUL:
        return a * b;
    case NODE_DIV:
        return a / b;
    case NODE_LESS:
        return less_than(a, b);
    case NODE_LESS_EQUAL:
        return less_equal(a, b);
    case NODE_IF:
        return a > 0 ? b : a <= 0 ? c : a;
    case NODE_ONE:
        return node->one(a);
    case NODE_TWO:
        return node->two(a, b);
    case NODE_MUL_ADD:
        return a * b + c;
    case NODE_MUL_SUB:
        return a * b - c;
    case NODE_SUB_MUL:
        return c - a * b;
    case NODE_NEG_MUL:
        return -(a * b);
    }
    return node->number;
}

/* A case for each operation, so that its loop or its code is its own. */
#define OPERATIONS(CASE)                                                                           \
    CASE(NODE_NEG)                                                                                 \
    CASE(NODE_ABS)                                                                                 \
    CASE(NODE_SQRT)                                                                                \
    CASE(NODE_ADD)                                                                                 \
    CASE(NODE_SUB)                                                                                 \
    CASE(NODE_MUL)                                                                                 \
    CASE(NODE_DIV)                                                                                 \
    CASE(NODE_LESS)                                                                                \
    CASE(NODE_LESS_EQUAL)                                                                          \
    CASE(NODE_IF)                                                                                  \
    CASE(NODE_ONE)                                                                                 \
    CASE(NODE_TWO)                                                                                 \
    CASE(NODE_MUL_ADD)                                                                             \
    CASE(NODE_MUL_SUB)                                                                             \
    CASE(NODE_SUB_MUL)                                                                             \
    CASE(NODE_NEG_MUL)

/* ---- derivatives (derive.c) ---- */

/* slope [count]: for each of the first `count` nodes that is marked, its partial derivative by the
 * name, as a node. */
void graph_derive(struct graph *graph, int name, const bool *mark, int count, int *slope);

/* ---- equations and programs ---- */

struct equations {
    struct arena arena;
    struct graph graph;
    int names;
    int *meaning; /* [names] the node of a name: itself, or what it was defined as */
    int *output;  /* [outputs] nodes */
    int outputs, capacity;
    bool exact; /* equations_exact() */
};

bool equations_reserve(struct equations *e, int more); /* room for more outputs */

/* ---- antiderivatives (integrate.c) ----
 *
 * Adds the parts of a potential, where `count` outputs from `first` on are the forces along the
 * coordinates `name` for a mass of 1. Each coordinate has a part, and the potential is the sum of
 * the masses times their parts. The parts are minus the sums of all antiderivatives, each of which
 * is counted once even if it occurs in several rows. They are followed by the parts at the origin
 * and at (1, 0, ...) or, for one coordinate, at 1 with its sign, which makes [3][count] outputs.
 * With `along_axes` they are the integrals from the origin along one axis after another, [count]
 * outputs. Returns false and adds nothing if an antiderivative was not found, or with an error.
 */
bool equations_integrate(struct equations *e, int first, int count, const int *name,
                         bool along_axes, struct error *error);

/* ---- switches (program_switch.c) ---- */

/* A branch is 1 where the argument is above 0 and 0 where it is below; or the largest integer not
 * above it. */
enum switch_kind { SWITCH_SIGN, SWITCH_WHOLE };

struct switches {
    int name;   /* the first of LIMIT_TYPED_SWITCHES names for branches */
    int moving; /* the first names are t and the state: so many */
    int count;
    /* nodes, themselves frozen; each depends on the branches before only */
    int argument[LIMIT_TYPED_SWITCHES];
    enum switch_kind kind[LIMIT_TYPED_SWITCHES];
    bool full; /* there are more */
    /* functions under if() go on beyond the switch that ends their domain, and so might on this
     * side of it */
    bool extended;
};

/*
 * Adds the switches' arguments as outputs, then `count` that are those from `first` on with every
 * switch frozen. Nothing where there are no switches, or too many.
 */
bool equations_freeze(struct equations *e, int first, int count, struct switches *found,
                      struct error *error);
bool expr_switches(const struct expr *expr); /* false for NULL */

/* One operation: places are doubles in the frame. What an operation writes is none of its operands.
 */
struct instruction {
    struct node node; /* the operands are places in the frame */
    int target_slot;
    /* index of the output that this computes in lanes, which no operation reads; -1 if there is
     * none */
    int output;
    bool last[3]; /* the operand's place is free afterwards */
};

enum { LEADING = 3 }; /* names that a program's function takes as numbers */

/* The frame: names, numbers, then intermediate values whose places are used again. */
struct program {
    program_function *run;
    struct arena arena;
    int moving, names, numbers, slots;
    int keeps;            /* the last names: what depends on given ones only */
    struct program *keep; /* their values, from the names before; NULL if there are none */
    double *number;
    struct instruction *code;
    int count;
    int *used; /* names that are read */
    int uses;
    int *output; /* [outputs] places */
    int outputs;
    bool *written;     /* [outputs] in lanes by the operation itself */
    int copies;        /* the others */
    struct node *node; /* the graph it came from, and there the outputs: for questions */
    int nodes, *result;
    struct native *native; /* NULL if there is none */
    /* Calls whose argument depends on t only remember it and their value in two places each,
     * behind those of the operations. */
    int remembered;
};
/* An argument that no call has: its value is not a number, as that of any such argument. */
#define PROGRAM_NO_ARGUMENT UINT64_C(0x7FF8DEADBEEF0001)

/*
 * Names from `first` on are given: they stay as they are for many evaluations. What depends on them
 * only is computed by program_keep() and becomes more names, given[kept] and on, if they and all it
 * takes fit (most; PROGRAM_KEEP doubles).
 */
struct steady_names {
    int first, retained, max;
};
#define PROGRAM_KEEP 4096

struct program *program_create_keeping(const struct equations *e, int first, int count,
                                       const bool *bound, const double *value,
                                       const struct steady_names *steady, bool native,
                                       struct error *error);
/* Same as program_depends() for any of these names. */
bool program_depends_on(const struct program *p, int first, int count, int name, int names);
/* Once for each set of given values. */
void program_keep(const struct program *program, double *steady);

#define PROGRAM_FEW 128

/* A frame: those few doubles if they are enough; else memory, to be given back, or NULL: there is
 * none. */
static inline double *program_place(const struct program *p, double few[PROGRAM_FEW])
{
    return program_frame(p) <= PROGRAM_FEW ? few : malloc(program_frame(p) * sizeof *few);
}

/* The outputs, where `moving` names are t and a state. */
static inline void program_run(const struct program *p, double t, const double *state,
                               const double *steady, double *output, double *frame)
{
    const struct leading leading =
        p->run(p, t, state[0], p->moving > 2 ? state[1] : 0, state, steady, output, frame);
    output[0] = leading.first;
    if (p->outputs > 1)
        output[1] = leading.second;
}

/* ---- machine code (native_x86.c; elsewhere always NULL) ---- */

/* Translates a program to machine code. *run is then the code, and *remembered the number of calls
 * that remember. Returns NULL if this machine is not supported, if out of memory, or if the system
 * does not allow it. */
struct native *native_create(const struct program *program, program_function **run,
                             int *remembered);
void native_destroy(struct native *native);
