/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Recognizes typed equations by their graph: whether they are linear in the state as written, and
 * whether they are one oscillator, with its coefficients. A graph tells more than derivatives:
 * sign(v) has the derivative 0 and is not linear.
 */
#include <hooke/base/elementary.h>

#include <math.h>
#include <stdlib.h>

#include "scene/formula/program/program.h"
#include "scene/typed/typed.h"

/* ---- linearity ---- */

/* Returns the degree in the state of an operation with operands of degrees a, b, c: 0 (constant), 1
 * (linear), or 2 for anything that is not linear. */
static int degree(enum node_kind kind, int a, int b, int c)
{
    switch (kind) {
    case NODE_NEG:
        return a;
    case NODE_ADD:
    case NODE_SUB:
        return a > b ? a : b;
    case NODE_MUL:
        return a + b < 2 ? a + b : 2;
    case NODE_DIV:
        return b == 0 ? a : 2;
    case NODE_IF:
        if (a > 0)
            return 2;
        return b > c ? b : c;
    default:
        return a + b + c == 0 ? 0 : 2;
    }
}

/* Returns true for |x|, sign(x), x < 0 of the name x. */
static bool has_kink(const struct node *all, const struct node *node, int name)
{
    const struct node *a = &all[node->operand[0]], *b = &all[node->operand[1]];
    if (b->kind == NODE_NAME)
        b = a, a = &all[node->operand[1]];
    const bool compares = node->kind == NODE_LESS || node->kind == NODE_LESS_EQUAL;
    return a->kind == NODE_NAME && a->operand[0] == name &&
           (node->kind == NODE_ABS || (compares && b->kind == NODE_NUMBER && b->number == 0));
}

/* Finds the degree of each node in the state; outputs of degree below 2 are linear. */
bool typed_look(const struct typed *typed, const struct program *program, bool *affine, bool *kinks,
                struct error *error)
{
    const size_t nodes = (size_t)program->nodes;
    signed char *node_degree = malloc(nodes);
    bool *needed = calloc(nodes, sizeof *needed); /* others were made on the way */
    const bool allocated = node_degree && needed;
    *affine = true;
    *kinks = false;
    for (int i = 0; allocated && i < program->outputs; i++)
        needed[program->result[i]] = true;
    if (allocated)
        graph_reach(program->node, program->nodes, needed);
    for (int i = 0; allocated && i < program->nodes; i++) {
        const struct node *node = &program->node[i];
        const int arity = node_arity(node->kind), *x = node->operand;
        int d[3] = {0};
        for (int k = 0; k < arity; k++)
            d[k] = node_degree[x[k]];
        if (node->kind == NODE_NAME)
            node_degree[i] = x[0] >= 1 && x[0] <= typed->model.n;
        else
            node_degree[i] = (signed char)degree(node->kind, d[0], d[1], d[2]);
        *kinks = *kinks || (needed[i] && arity > 0 && has_kink(program->node, node, 2));
    }
    for (int i = 0; allocated && i < program->outputs; i++)
        *affine = *affine && node_degree[program->result[i]] < 2;
    free(node_degree);
    free(needed);
    return allocated || error_memory(error);
}

/* ---- one oscillator ---- */

/* Functions of which the acceleration of an oscillator is a sum. */
enum affine_part { CONSTANT, BY_T, BY_Q, BY_V, BY_SPEED, BY_SQUARE, DRIVE, PARTS };

#define BIT(part) (1u << (part))

/*
 * The value of a node as the sum of part[CONSTANT], [BY_T] t, [BY_Q] q, [BY_V] v, [BY_SPEED] |v|,
 * [BY_SQUARE] |v| v and [DRIVE] cos(omega t + phase). The parts t and |v| occur only in operands of
 * a cosine and of |v| v.
 */
struct affine_form {
    double part[PARTS], omega, phase;
    bool known; /* the value is such a sum */
};

#define NODES_MAX 256 /* larger graphs are not examined; nobody types such an oscillator */

static const struct affine_form unknown;

/* Returns true if the form has no other parts. */
static bool has_only_parts(const struct affine_form *f, unsigned parts)
{
    for (int i = 0; i < PARTS; i++)
        if (!(parts & BIT(i)) && f->part[i] != 0)
            return false;
    return f->known;
}

/* Adds a drive to that of the oscillator. Returns false if their frequencies differ. */
static bool add_drive(struct oscillator *o, double drive, double omega, double phase)
{
    if (drive == 0)
        return true;
    if (o->drive != 0 && o->omega != omega)
        return false;
    if (o->drive != 0 && o->phase == phase) {
        drive += o->drive;
    } else if (o->drive != 0) {
        const double cosine_part = o->drive * fixed_cos(o->phase) + drive * fixed_cos(phase);
        const double sine_part = o->drive * fixed_sin(o->phase) + drive * fixed_sin(phase);
        drive = fixed_hypot(cosine_part, sine_part);
        phase = fixed_atan2(sine_part, cosine_part);
    }
    o->drive = drive;
    o->omega = omega;
    o->phase = phase;
    return true;
}

/* Returns a + sign b. */
static struct affine_form affine_sum(const struct affine_form *a, double sign,
                                     const struct affine_form *b)
{
    struct oscillator both = {.drive = a->part[DRIVE], .omega = a->omega, .phase = a->phase};
    if (!add_drive(&both, sign * b->part[DRIVE], b->omega, b->phase))
        return unknown;
    struct affine_form made = {.omega = both.omega, .phase = both.phase, .known = true};
    for (int i = 0; i < DRIVE; i++)
        made.part[i] = a->part[i] + sign * b->part[i];
    made.part[DRIVE] = both.drive;
    return made;
}

/* Returns the form times factor / divisor, one of which is 1. Coefficients are rounded as those of
 * the built-in terms are: k/m is a quotient. */
static struct affine_form scaled(struct affine_form f, double factor, double divisor)
{
    for (int i = 0; i < PARTS; i++)
        f.part[i] = divisor == 1 ? f.part[i] * factor : f.part[i] / divisor;
    return f;
}

/* Returns a b if one is a constant, or for (constant + |v|) v. */
static struct affine_form product(const struct affine_form *a, const struct affine_form *b)
{
    if (has_only_parts(b, BIT(CONSTANT)))
        return scaled(*a, b->part[CONSTANT], 1);
    if (has_only_parts(a, BIT(CONSTANT)))
        return scaled(*b, a->part[CONSTANT], 1);
    const struct affine_form *rate = a->part[BY_SPEED] != 0 ? a : b;
    const struct affine_form *v = rate == a ? b : a;
    if (!has_only_parts(rate, BIT(CONSTANT) | BIT(BY_SPEED)) || !has_only_parts(v, BIT(BY_V)))
        return unknown;
    struct affine_form made = {.known = true};
    made.part[BY_V] = rate->part[CONSTANT] * v->part[BY_V];
    made.part[BY_SQUARE] = rate->part[BY_SPEED] * v->part[BY_V];
    return made;
}

/* Returns the form of cos(angle + ahead), where `ahead` is a constant phase [rad] (0 for cos, -pi/2
 * for sin), or `unknown` if the angle is not linear in time. */
static struct affine_form affine_wave(const struct affine_form *angle, double ahead)
{
    if (!has_only_parts(angle, BIT(CONSTANT) | BIT(BY_T)))
        return unknown;
    const double omega = angle->part[BY_T], phase = angle->part[CONSTANT] + ahead;
    struct affine_form made = {
        .omega = fabs(omega), .phase = omega < 0 ? -phase : phase, .known = true};
    made.part[DRIVE] = 1;
    return made;
}

/* Returns a constant. */
static struct affine_form number(double value)
{
    return (struct affine_form){.part = {[CONSTANT] = value}, .known = true};
}

/* Returns the result of the node's operation on operands with the affine forms a, b, c, as such a
 * form, or `unknown` if the result is not a sum of the functions in enum affine_part. */
static struct affine_form affine_of_node(const struct node *node, const struct affine_form *a,
                                         const struct affine_form *b, const struct affine_form *c)
{
    static const double quarter = 1.57079632679489661923;
    const unsigned constant = BIT(CONSTANT);
    if (node->kind == NODE_IF && has_only_parts(a, constant) && !isnan(a->part[CONSTANT]))
        return a->part[CONSTANT] > 0 ? *b : *c;
    if (!a->known || !b->known || !c->known)
        return unknown;
    if (has_only_parts(a, constant) && has_only_parts(b, constant) && has_only_parts(c, constant))
        return number(
            node_value(node->kind, node, a->part[CONSTANT], b->part[CONSTANT], c->part[CONSTANT]));
    switch (node->kind) {
    case NODE_NEG:
        return scaled(*a, -1, 1);
    case NODE_ABS:
        return has_only_parts(a, BIT(BY_V))
                   ? (struct affine_form){.part = {[BY_SPEED] = fabs(a->part[BY_V])}, .known = true}
                   : unknown;
    case NODE_ADD:
        return affine_sum(a, 1, b);
    case NODE_SUB:
        return affine_sum(a, -1, b);
    case NODE_MUL:
        return product(a, b);
    case NODE_DIV:
        return has_only_parts(b, constant) ? scaled(*a, 1, b->part[CONSTANT]) : unknown;
    case NODE_ONE:
        if (node->one == fixed_cos)
            return affine_wave(a, 0);
        return node->one == fixed_sin ? affine_wave(a, -quarter) : unknown;
    default:
        return unknown;
    }
}

/* Returns the form of a program's first output, with the values c of a bound term. */
static struct affine_form form_of(const struct program *program, const double *c)
{
    struct affine_form form[NODES_MAX], one = number(1);
    if (program->nodes > NODES_MAX)
        return unknown;
    for (int i = 0; i < program->nodes; i++) {
        const struct node *node = &program->node[i];
        const int arity = node_arity(node->kind), *x = node->operand;
        form[i] = one;
        if (node->kind == NODE_NUMBER)
            form[i].part[CONSTANT] = node->number;
        else if (node->kind == NODE_NAME && x[0] < 3) /* t, q, v */
            form[i].part[CONSTANT] = 0, form[i].part[BY_T + x[0]] = 1;
        else if (node->kind == NODE_NAME) /* the mass and what is read */
            form[i].part[CONSTANT] = c[x[0] - 2];
        else
            form[i] = affine_of_node(node, &form[x[0]], arity > 1 ? &form[x[1]] : &one,
                                     arity > 2 ? &form[x[2]] : &one);
    }
    return form[program->result[0]];
}

/* Adds a term of one coordinate to the oscillator, or clears whole, and drag_whole for drag, if it
 * is not of the oscillator's form or if coefficients overflow. */
static void linear_term_add(const struct typed_term *term, const double *c, struct oscillator *o)
{
    const bool drag = term->row.flags & TERM_VELOCITY;
    const struct affine_form f = form_of(term->add, c);
    const unsigned velocity = BIT(BY_V) | BIT(BY_SQUARE),
                   rest = BIT(CONSTANT) | BIT(BY_Q) | BIT(DRIVE);
    struct oscillator combined = *o;
    combined.stiffness -= f.part[BY_Q];
    combined.damping -= f.part[BY_V];
    combined.quadratic -= f.part[BY_SQUARE];
    combined.gravity -= f.part[CONSTANT];
    const double coefficient[] = {combined.stiffness, combined.damping, combined.quadratic,
                                  combined.gravity,   f.omega,          f.phase};
    bool fits = has_only_parts(&f, drag ? velocity : rest) && !(f.part[BY_SQUARE] > 0) &&
                add_drive(&combined, f.part[DRIVE], f.omega, f.phase) && isfinite(combined.drive);
    for (size_t i = 0; i < COUNT_OF(coefficient); i++)
        fits = fits && isfinite(coefficient[i]);
    if (fits) {
        *o = combined;
        return;
    }
    o->whole = false;
    o->drag_whole = o->drag_whole && !drag;
}

/* Adds the drag of several coordinates if it is v_i' = -gamma v_i with one gamma; otherwise clears
 * drag_whole. */
static void add_drag(const struct typed_term *term, const double *c, struct oscillator *o)
{
    const int n = term->typed->model.n, rows = n / 2;
    double a[LIMIT_VARIABLES], rest[LIMIT_VARIABLES] = {0};
    double *jac = malloc((size_t)(rows * n) * sizeof *jac);
    bool fits = jac && term->row.flags & TERM_LINEAR && !(term->row.flags & TERM_TIME);
    if (fits) {
        typed_evaluate(term->jacobian, c, 0, rest, jac);
        typed_evaluate(term->add, c, 0, rest, a);
    }
    for (int i = 0; fits && i < rows; i++) {
        fits = a[i] == 0 && isfinite(jac[rows]);
        for (int j = 0; fits && j < n; j++)
            fits = jac[i * n + j] == (j == rows + i ? jac[rows] : 0);
    }
    if (fits)
        o->damping -= jac[rows];
    else
        o->drag_whole = false;
    free(jac);
}

/* Adds the term to the oscillator, or only its drag if there are several coordinates. */
void typed_recognise(const struct typed_term *term, const double *c, struct oscillator *o)
{
    const struct model *model = &term->typed->model;
    if (model->order == 2 && model->n == 2) {
        linear_term_add(term, c, o);
        return;
    }
    o->whole = false;
    if (term->row.flags & TERM_VELOCITY)
        add_drag(term, c, o);
}
