/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equations as a graph of operations without repetitions, and the programs that graphs become.
 * equations_create(), equations_add() for each expression, equations_derive(), equations_freeze()
 * or equations_integrate() for further outputs, then program_create_keeping(). The public part is
 * in <hooke/scene/formula.h>. */
#pragma once

#include "scene/formula/expr.h"

#include <stdlib.h>

/* ---- the graph ----
 *
 * A node is a number, a name, or an operation on earlier nodes; equal nodes are one, and each is
 * simplified when it is made.
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
 * term whose coefficient is 0, which is absent from sums. */
enum zero_mark { ZERO_NUMBER, ZERO_NAME, ZERO_TERM };

struct node {
    enum node_kind kind;
    /* indices of earlier nodes; the first is the name of a NODE_NAME, or the zero_mark of a
     * NODE_NUMBER */
    int operand[3];
    union {
        double number;
        double (*one)(double);
        double (*two)(double, double);
    };
};

/* Node 0 is the number 0. After a failure `failed` is set and every new node is node 0, so that
 * callers check once at the end, by graph_check(). */
struct graph {
    struct arena *arena;
    struct node *node; /* [count] operands come before the nodes that use them */
    int count, capacity;
    int *table;     /* [slots] hash table of node indices, 0 where free */
    unsigned slots; /* a power of two */
    bool binds;     /* names are being replaced by their values: powers become multiplications */
    bool has_terms; /* terms whose coefficient is 0 are absent */
    bool limits;    /* a factor of 0 beside an infinite one gives 0 in derivatives */
    enum { GRAPH_FINE, GRAPH_NO_MEMORY, GRAPH_FULL } failed;
};

/* Makes a graph with node 0, in memory of the arena. */
void graph_init(struct graph *graph, struct arena *arena, bool binds);
/* Return the node of a number, of a known name with this value, and of a name. */
int graph_number(struct graph *graph, double number);
int graph_known(struct graph *graph, double value);
int graph_name(struct graph *graph, int name);
/* Returns the node of an operation from NODE_NEG to NODE_IF on nodes; those it does not have are
 * 0. */
int graph_apply(struct graph *graph, enum node_kind kind, int a, int b, int c);
/* Return the node of a function's value at one or two nodes. */
int graph_one(struct graph *graph, double (*one)(double), int a);
int graph_two(struct graph *graph, double (*two)(double, double), int a, int b);
/* Returns the node of the same operation on operands map[i] instead of i; `node` may be one of
 * another graph. */
int graph_copy(struct graph *graph, const struct node *node, const int *map);
/* Returns false, with an error, if the graph has failed. */
bool graph_check(const struct graph *graph, struct error *error);
/* Marks, among the first `count` nodes, all that the marked ones need. */
void graph_reach(const struct node *node, int count, bool *mark);
/* Returns the number of operands of an operation; 0 for numbers and names. */
int node_arity(enum node_kind kind);

/* Returns the value of an operation with these operands. Callers pass `kind` as a constant where
 * this is the body of a loop. */
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

/* Expands CASE for each kind of operation, so that each has a loop or code of its own. */
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

/* Sets slope[i], for each of the first `count` nodes that is marked, to the node of its partial
 * derivative by the name. */
void graph_derive(struct graph *graph, int name, const bool *mark, int count, int *slope);

/* ---- equations and programs ---- */

struct equations {
    struct arena arena;
    struct graph graph;
    int names;
    int *meaning; /* [names] the node of a name: itself, or that of its definition */
    int *output;  /* [outputs] nodes of the outputs */
    int outputs, capacity;
    bool exact; /* set by equations_exact() */
};

/* Makes room for `more` outputs; returns false if out of memory. */
bool equations_reserve(struct equations *e, int more);

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

/* Kinds of the branch of a switch, as a function of its argument: 1 above 0 and 0 below; or the
 * largest integer not above it. */
enum switch_kind { SWITCH_SIGN, SWITCH_WHOLE };

/* The switches of some equations. The caller sets `name` and `moving`. */
struct switches {
    int name;   /* the first of LIMIT_TYPED_SWITCHES names for branches */
    int moving; /* number of the first names that move: t and the state */
    int count;
    /* [count] nodes of the arguments, with earlier switches frozen */
    int argument[LIMIT_TYPED_SWITCHES];
    enum switch_kind kind[LIMIT_TYPED_SWITCHES];
    bool full; /* there are more than LIMIT_TYPED_SWITCHES */
    /* Functions under if() were continued beyond the switch that ends their domain, so that frozen
     * equations may have a value where the equations have none. */
    bool extended;
};

/*
 * Adds the arguments of all switches as outputs, then the `count` outputs from `first` on again,
 * with every switch frozen: its branch is the value of a name. Adds nothing if there are no
 * switches, or too many. Returns false with an error.
 */
bool equations_freeze(struct equations *e, int first, int count, struct switches *found,
                      struct error *error);
/* Returns true if the formula contains a switch; false for NULL. */
bool expr_switches(const struct expr *expr);

/* One operation of a program. A place is the index of a double in the frame. An operation never
 * writes to a place of its own operands. */
struct instruction {
    struct node node; /* the operands are places in the frame */
    int target_slot;  /* place of the result */
    /* index of the output that this computes in lanes, which no operation reads; -1 if there is
     * none */
    int output;
    bool last[3]; /* the operand is not used afterwards */
};

enum { LEADING = 3 }; /* number of the first names, which a program's function takes as arguments */

/* The frame has places for names, then numbers, then intermediate values, whose places are used
 * again. */
struct program {
    program_function *run; /* interpreter or machine code */
    struct arena arena;
    int moving;               /* number of the first names that move: t and the state */
    int names, numbers;       /* places of names and of numbers */
    int slots;                /* all places */
    int keeps;                /* the last names are retained values, this many */
    struct program *keep;     /* program that computes these; NULL if there are none */
    double *number;           /* [numbers] */
    struct instruction *code; /* [count] */
    int count;
    int *used; /* [uses] names that are read */
    int uses;
    int *output; /* [outputs] places */
    int outputs;
    bool *written;     /* [outputs] in lanes, the operation itself writes the output */
    int copies;        /* number of the other outputs, which are copied */
    struct node *node; /* [nodes] the graph of the program, for program_depends() and others */
    int nodes;
    int *result;           /* [outputs] nodes of the outputs */
    struct native *native; /* machine code; NULL if there is none */
    /* Number of calls whose argument depends on t only: they remember it and their value, in two
     * places each behind those of the operations. */
    int remembered;
};
/* The bits of an argument that no call has, for places that remember nothing yet. */
#define PROGRAM_NO_ARGUMENT UINT64_C(0x7FF8DEADBEEF0001)

/*
 * Steady names, those from `first` on, keep their values for many evaluations. Values that depend
 * on them only are retained: program_keep() computes them once, and they become further names,
 * steady[retained] and on, if there are at most `max` of them and their program has at most
 * PROGRAM_KEEP places.
 */
struct steady_names {
    int first, retained, max;
};
#define PROGRAM_KEEP 4096

/* Creates the program of `count` outputs from `first` on. Names with bound[name] are replaced by
 * value[name]; bound may be NULL. steady may be NULL. Machine code is made if `native` and if this
 * machine has it. Returns NULL with an error. */
struct program *program_create_keeping(const struct equations *e, int first, int count,
                                       const bool *bound, const double *value,
                                       const struct steady_names *steady, bool native,
                                       struct error *error);
/* Same as program_depends() for any of these names. */
bool program_depends_on(const struct program *p, int first, int count, int name, int names);
/* Computes the retained values from the values of steady names, and writes them behind these. Is
 * called once for each set of values. */
void program_keep(const struct program *program, double *steady);

#define PROGRAM_FEW 128

/* Returns memory for the frame: `few`, which the caller has on its stack, if that is enough, else
 * allocated memory that the caller frees, or NULL if out of memory. */
static inline double *program_place(const struct program *p, double few[PROGRAM_FEW])
{
    return program_frame(p) <= PROGRAM_FEW ? few : malloc(program_frame(p) * sizeof *few);
}

/* Computes all outputs at t and a state [moving - 1], with the values of steady names. */
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
