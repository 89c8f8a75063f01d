/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Antiderivatives as symbols: nodes that are added to the graph, by equations_integrate(). A sum is
 * integrated summand by summand. A summand is a product of powers and calls; one of them, f(u), is
 * integrated by its argument if the others are a constant multiple of du/dx, else a factor that is
 * a sum is multiplied out. Integrals that this does not find are left to quadrature. */
#include <string.h>

#include "scene/formula/program/program.h"

#define NUMBER(x) graph_number(g, x)
#define ABS(a) graph_apply(g, NODE_ABS, a, 0, 0)
#define ADD(a, b) graph_apply(g, NODE_ADD, a, b, 0)
#define SUB(a, b) graph_apply(g, NODE_SUB, a, b, 0)
#define MUL(a, b) graph_apply(g, NODE_MUL, a, b, 0)
#define DIV(a, b) graph_apply(g, NODE_DIV, a, b, 0)
#define LESS(a, b) graph_apply(g, NODE_LESS, a, b, 0)
#define IF(c, a, b) graph_apply(g, NODE_IF, c, a, b)
#define CALL(function, a) graph_one(g, function, a)
#define POWER(a, b) graph_two(g, function_power, a, b)

enum {
    FACTORS_MAX = 8,
    SUMMANDS_MAX = 4096,
    EXPANSIONS_MAX = 512,
    GRAPH_MAX = PROGRAM_SIZE / 8 /* number of nodes above which nothing is integrated */
};

struct integration {
    struct graph *g;
    int name; /* name of the variable x */
    /* [GRAPH_MAX] 1 if the node depends on x; valid for the first `known` nodes */
    unsigned char *has;
    int known;
    bool *mark;     /* [GRAPH_MAX] work memory of mark_reach() */
    int *map;       /* [GRAPH_MAX] work memory of substitute() and derivative() */
    double *value;  /* [GRAPH_MAX] work memory of trial_quotient() */
    int *summand;   /* [SUMMANDS_MAX] nodes of antiderivatives of all rows so far */
    int summands;   /* number of them */
    int earlier;    /* number of those of earlier rows */
    int expansions; /* sums that were multiplied out */
    bool distinct;  /* a summand that an earlier row has is left out */
};

/* A factor of a product: base^power, or base^exponent if the node `exponent` is > 0. */
struct factor {
    int base, exponent;
    double power;
};

/* The product of a number, a node without x, and factors that depend on x. */
struct product {
    double number;
    int constant, count;
    struct factor factor[FACTORS_MAX];
};

/* Returns true if the graph has failed or is so large that nothing more is integrated. */
static bool is_full(const struct integration *integration)
{
    return integration->g->failed || integration->g->count > GRAPH_MAX - 256;
}

/* Returns true if node i depends on x. */
static bool depends_on_x(struct integration *integration, int i)
{
    for (; integration->known <= i; integration->known++) {
        const struct node *node = &integration->g->node[integration->known];
        integration->has[integration->known] =
            node->kind == NODE_NAME && node->operand[0] == integration->name;
        for (int k = 0; k < node_arity(node->kind); k++)
            integration->has[integration->known] |= integration->has[node->operand[k]];
    }
    return integration->has[i];
}

/* Marks node i and everything that it needs. */
static void mark_reach(struct integration *integration, int i)
{
    memset(integration->mark, 0, (size_t)i + 1);
    integration->mark[i] = true;
    graph_reach(integration->g->node, i + 1, integration->mark);
}

/* Returns node i with numbers in the place of `count` names. */
static int substitute(struct integration *integration, int i, const int *name, const double *number,
                      int count)
{
    struct graph *g = integration->g;
    mark_reach(integration, i);
    for (int k = 0; k <= i; k++) {
        const struct node node = g->node[k];
        integration->map[k] = k;
        if (!integration->mark[k])
            continue;
        for (int j = 0; j < count && node.kind == NODE_NAME; j++)
            if (node.operand[0] == name[j])
                integration->map[k] = NUMBER(number[j]);
        bool changed = false;
        for (int j = 0; j < node_arity(node.kind); j++)
            changed |= integration->map[node.operand[j]] != node.operand[j];
        if (changed)
            integration->map[k] = graph_copy(g, &node, integration->map);
    }
    return integration->map[i];
}

/* Returns the derivative of node i by x. */
static int derivative(struct integration *integration, int i)
{
    mark_reach(integration, i);
    graph_derive(integration->g, integration->name, integration->mark, i + 1, integration->map);
    return integration->map[i];
}

/* ---- quotients that do not depend on x ---- */

/* Returns true if node i of the graph is an analytic function of x, so that a value that is
 * constant at some x is constant everywhere: none of its operations on x is a step, a comparison,
 * an absolute value or similar. */
static bool is_analytic(struct integration *integration, int i)
{
    static double (*const steps[])(double) = {floor, ceil, round, function_sign, function_step};
    depends_on_x(integration, i);
    mark_reach(integration, i);
    for (int k = 0; k <= i; k++) {
        const struct node *node = &integration->g->node[k];
        if (!integration->mark[k] || !integration->has[k])
            continue;
        if (node->kind == NODE_ABS || node->kind == NODE_LESS || node->kind == NODE_LESS_EQUAL ||
            (node->kind == NODE_IF && integration->has[node->operand[0]]) ||
            (node->kind == NODE_TWO && node->two != function_power && node->two != fixed_hypot))
            return false;
        for (size_t s = 0; s < COUNT_OF(steps) && node->kind == NODE_ONE; s++)
            if (node->one == steps[s])
                return false;
    }
    return true;
}

/* Returns the value of node a over node b for certain values of all names: 1 in trial 0, else
 * spread values of x; other names change with every third trial. */
static double trial_quotient(struct integration *integration, int a, int b, int trial)
{
    static const double spread[] = {-1.37, 0.83, 2.19, -0.41, 1.7, 0.29, -2.6, 0.57, 1.13};
    const int last = a > b ? a : b;
    for (int k = 0; k <= last; k++) {
        const struct node *node = &integration->g->node[k];
        const bool x = node->kind == NODE_NAME && node->operand[0] == integration->name;
        const double *value = integration->value;
        if (node->kind == NODE_NAME && trial == 0)
            integration->value[k] = 1;
        else if (node->kind == NODE_NAME)
            integration->value[k] =
                x ? spread[trial - 1]
                  : 0.6 + 0.7 * fmod((node->operand[0] + 1) * 0.618 + 0.377 * ((trial - 1) / 3), 1);
        else
            integration->value[k] = node_value(node->kind, node, value[node->operand[0]],
                                               value[node->operand[1]], value[node->operand[2]]);
    }
    return integration->value[a] / integration->value[b];
}

/* Returns true if two values are equal but for rounding. */
static bool is_near(double a, double b)
{
    return fabs(a - b) <= 1e-12 * fabs(b);
}

/* Returns a/b as a node without x; -1 if it depends on x, or is not known to be constant. That is
 * found by evaluating it at several values of x. */
static int constant_quotient(struct integration *integration, int a, int b)
{
    struct graph *g = integration->g;
    if (b == 0 || is_full(integration))
        return -1;
    if (!depends_on_x(integration, a) && !depends_on_x(integration, b))
        return DIV(a, b);
    if (!is_analytic(integration, a) || !is_analytic(integration, b))
        return -1;
    double q[10];
    bool by_x = true, all = true;
    for (int trial = 0; trial < 10; trial++) {
        q[trial] = trial_quotient(integration, a, b, trial);
        const double *first = &q[trial < 2 ? 0 : 1 + (trial - 1) / 3 * 3];
        by_x &= trial == 0 || (isfinite(q[trial]) && (trial < 2 || is_near(q[trial], *first)));
        all &= trial < 2 || is_near(q[trial], q[1]);
    }
    if (!by_x)
        return -1;
    if (all)
        return NUMBER(is_near(q[0], q[1]) ? q[0] : q[1]);
    const double some = 0.75;
    const int top = substitute(integration, a, &integration->name, &some, 1);
    return DIV(top, substitute(integration, b, &integration->name, &some, 1));
}

/* ---- products ---- */

/* Multiplies the product by base^power, or base^exponent. Returns false if it has too many
 * factors. */
static bool add_factor(struct product *p, int base, double power, int exponent)
{
    for (int k = 0; k < p->count; k++) {
        struct factor *f = &p->factor[k];
        if (f->base != base || f->exponent || exponent)
            continue;
        f->power += power;
        if (f->power == 0)
            *f = p->factor[--p->count];
        return true;
    }
    if (p->count == FACTORS_MAX)
        return false;
    p->factor[p->count++] = (struct factor){base, exponent, power};
    return true;
}

/* Multiplies the product *p by node i of the graph to the given power: splits products, quotients,
 * signs, roots and powers into factors; what does not depend on x goes into p->number and
 * p->constant. Returns false if *p has too many factors. */
static bool product_multiply(struct integration *integration, int i, double power,
                             struct product *p)
{
    struct graph *g = integration->g;
    const struct node node = g->node[i];
    const int a = node.operand[0], b = node.operand[1];
    const bool whole = power == floor(power);
    if (!depends_on_x(integration, i)) {
        if (node.kind == NODE_NUMBER)
            p->number *= function_power(node.number, power);
        else if (fabs(power) == 1)
            p->constant = power > 0 ? MUL(p->constant, i) : DIV(p->constant, i);
        else
            p->constant = MUL(p->constant, POWER(i, NUMBER(power)));
        return true;
    }
    if (whole && node.kind == NODE_NEG) {
        p->number *= fmod(power, 2) != 0 ? -1 : 1;
        return product_multiply(integration, a, power, p);
    }
    if (whole && (node.kind == NODE_MUL || node.kind == NODE_DIV))
        return product_multiply(integration, a, power, p) &&
               product_multiply(integration, b, node.kind == NODE_MUL ? power : -power, p);
    if (node.kind == NODE_SQRT)
        return product_multiply(integration, a, power / 2, p);
    if (node.kind == NODE_TWO && node.two == fixed_hypot)
        return add_factor(p, ADD(MUL(a, a), MUL(b, b)), power / 2, 0);
    if (node.kind == NODE_TWO && node.two == function_power && !depends_on_x(integration, b)) {
        if (g->node[b].kind == NODE_NUMBER)
            return product_multiply(integration, a, power * g->node[b].number, p);
        if (fabs(power) == 1)
            return add_factor(p, a, 1, power > 0 ? b : graph_apply(g, NODE_NEG, b, 0, 0));
    }
    return add_factor(p, i, power, 0);
}

/* Returns the node of a factor. */
static int factor_node(struct graph *g, const struct factor *f)
{
    if (f->exponent)
        return POWER(f->base, f->exponent);
    if (f->power == 1)
        return f->base;
    return f->power == -1 ? DIV(NUMBER(1), f->base) : POWER(f->base, NUMBER(f->power));
}

/* Returns the node of all factors but number `but`, without the number and the constant. */
static int other_factors(struct graph *g, const struct product *p, int but)
{
    int made = NUMBER(1);
    for (int k = 0; k < p->count; k++)
        if (k != but)
            made = MUL(made, factor_node(g, &p->factor[k]));
    return made;
}

/* Returns the antiderivative of a call by its argument v; -1 if unknown. Those that are even begin
 * with the square of v, free of cancellation. */
static int call_integral(struct graph *g, const struct node *call)
{
    const int v = call->operand[0], half = MUL(NUMBER(0.5), v);
    if (call->kind == NODE_ABS)
        return MUL(half, ABS(v));
    if (call->kind != NODE_ONE)
        return -1;
    if (call->one == fixed_sin)
        return MUL(NUMBER(2), POWER(CALL(fixed_sin, half), NUMBER(2)));
    if (call->one == fixed_cos)
        return CALL(fixed_sin, v);
    if (call->one == fixed_exp)
        return CALL(fixed_expm1, v);
    if (call->one == fixed_sinh)
        return MUL(NUMBER(2), POWER(CALL(fixed_sinh, half), NUMBER(2)));
    if (call->one == fixed_cosh)
        return CALL(fixed_sinh, v);
    if (call->one == fixed_tanh) { /* log cosh */
        const int small = CALL(fixed_exp, MUL(NUMBER(-2), ABS(v)));
        return ADD(ABS(v), CALL(fixed_log, MUL(NUMBER(0.5), ADD(NUMBER(1), small))));
    }
    if (call->one == fixed_log)
        return SUB(MUL(v, CALL(fixed_log, v)), v);
    if (call->one == fixed_atan)
        return SUB(MUL(v, CALL(fixed_atan, v)),
                   MUL(NUMBER(0.5), CALL(fixed_log, ADD(NUMBER(1), MUL(v, v)))));
    return call->one == function_sign ? ABS(v) : -1;
}

/* Returns the antiderivative of base^power by the base, of which a factor goes into *number. */
static int power_integral(struct graph *g, const struct factor *f, double *number)
{
    if (f->exponent) {
        const int more = ADD(f->exponent, NUMBER(1));
        return IF(ABS(more), DIV(POWER(f->base, more), more), CALL(fixed_log, ABS(f->base)));
    }
    if (f->power == -1)
        return CALL(fixed_log, ABS(f->base));
    *number /= f->power + 1;
    return POWER(f->base, NUMBER(f->power + 1));
}

/* Adds number constant node to the summands, unless an earlier row has it. Returns false if there
 * are too many. */
static bool put_summand(struct integration *integration, double number, int constant, int node)
{
    struct graph *g = integration->g;
    if (g->node[constant].kind == NODE_NUMBER) {
        number *= g->node[constant].number;
        constant = NUMBER(1);
    }
    const int made = MUL(NUMBER(number), MUL(constant, node));
    for (int k = 0; k < integration->earlier && integration->distinct; k++)
        if (integration->summand[k] == made)
            return true;
    if (integration->summands == SUMMANDS_MAX || is_full(integration))
        return false;
    integration->summand[integration->summands++] = made;
    return true;
}

/* ---- sums ---- */

static bool node_integrate(struct integration *integration, int i, double sign);

/* Integrates the product *p by substitution: looks for a factor f(u) such that the remaining
 * factors are a constant multiple of du/dx, and adds the integral as a summand. Calls are tried
 * first, then powers. Returns false if there is no such factor. */
static bool substitute_factor(struct integration *integration, const struct product *p)
{
    struct graph *g = integration->g;
    for (int k = 0; k < 2 * p->count; k++) { /* calls first */
        const struct factor *f = &p->factor[k % p->count];
        const struct node node = g->node[f->base];
        const bool call = k < p->count;
        double number = p->number;
        if (call && (f->exponent || f->power != 1))
            continue;
        const int argument = call ? node.operand[0] : f->base;
        if (!is_analytic(integration,
                         argument)) /* it may jump, which its derivative does not say */
            continue;
        const int made = call ? call_integral(g, &node) : power_integral(g, f, &number);
        if (made < 0)
            continue;
        const int slope = derivative(integration, argument);
        const int ratio = constant_quotient(integration, other_factors(g, p, k % p->count), slope);
        if (ratio < 0)
            continue;
        if (g->node[ratio].kind == NODE_NUMBER)
            return put_summand(integration, number * g->node[ratio].number, p->constant, made);
        return put_summand(integration, number, MUL(p->constant, ratio), made);
    }
    return false;
}

/* Integrates a product by multiplying out a factor that is a sum. Returns false if there is none,
 * or the parts cannot be integrated. */
static bool product_expand(struct integration *integration, struct product *p, double sign)
{
    struct graph *g = integration->g;
    for (int k = 0; k < p->count; k++) {
        struct factor *f = &p->factor[k];
        const struct node sum = g->node[f->base];
        if ((sum.kind != NODE_ADD && sum.kind != NODE_SUB) || f->exponent || f->power < 1 ||
            f->power != floor(f->power) || ++integration->expansions > EXPANSIONS_MAX ||
            is_full(integration))
            continue;
        const int fewer = f->power > 1 ? POWER(f->base, NUMBER(f->power - 1)) : NUMBER(1);
        const int others =
            MUL(MUL(NUMBER(p->number), p->constant), MUL(other_factors(g, p, k), fewer));
        return node_integrate(integration, MUL(others, sum.operand[0]), sign) &&
               node_integrate(integration, MUL(others, sum.operand[1]),
                              sum.kind == NODE_ADD ? sign : -sign);
    }
    return false;
}

/* Adds the antiderivative of sign times node i to the summands. Returns false if it is not
 * found. */
static bool node_integrate(struct integration *integration, int i, double sign)
{
    struct graph *g = integration->g;
    const struct node node = g->node[i];
    if (is_full(integration))
        return false;
    if (node.kind == NODE_NEG)
        return node_integrate(integration, node.operand[0], -sign);
    if (depends_on_x(integration, i) && (node.kind == NODE_ADD || node.kind == NODE_SUB))
        return node_integrate(integration, node.operand[0], sign) &&
               node_integrate(integration, node.operand[1], node.kind == NODE_ADD ? sign : -sign);
    if (i == 0)
        return true;
    struct product p = {.number = 1, .constant = NUMBER(1)};
    if (!product_multiply(integration, i, 1, &p))
        return false;
    struct product signed_product = p;
    signed_product.number *= sign;
    if (p.count == 0)
        return put_summand(integration, signed_product.number, p.constant,
                           graph_name(g, integration->name));
    return substitute_factor(integration, &signed_product) || product_expand(integration, &p, sign);
}

/* Returns minus the sum of the summands from `first` on. */
static int minus_sum(const struct integration *integration, int first)
{
    struct graph *g = integration->g;
    int sum = 0;
    for (int k = first; k < integration->summands; k++)
        sum = sum ? ADD(sum, integration->summand[k]) : integration->summand[k];
    return sum ? graph_apply(g, NODE_NEG, sum, 0, 0) : 0;
}

static const double zeros[LIMIT_VARIABLES]; /* the origin */

/* Integrates the forces `integrand` [count] along the coordinates `name`, into made: the parts of
 * the potential [3][count], or [count] along the axes, as equations_integrate() says. Returns false
 * if one is not found. */
static bool integrate_rows(struct integration *integration, const int *integrand, const int *name,
                           int count, bool along_axes, int *made)
{
    struct graph *g = integration->g;
    double unit[LIMIT_VARIABLES] = {1};
    integration->distinct = !along_axes;
    for (int i = 0; i < count; i++) {
        integration->name = name[i];
        integration->known = 0;
        const int first = integration->earlier = integration->summands;
        const int row =
            along_axes ? substitute(integration, integrand[i], name + i + 1, zeros, count - i - 1)
                       : integrand[i];
        if (!node_integrate(integration, row, 1))
            return false;
        const int part = made[i] = minus_sum(integration, first);
        if (along_axes) {
            made[i] = SUB(part, substitute(integration, part, name + i, zeros, 1));
            continue;
        }
        made[count + i] = substitute(integration, part, name, zeros, count);
        made[2 * count + i] = substitute(integration, part, name, unit, count);
        if (count == 1) {
            const double other = -1;
            made[2] = IF(LESS(graph_name(g, name[0]), 0),
                         substitute(integration, part, name, &other, 1), made[2]);
        }
        if (is_full(integration))
            return false;
    }
    return true;
}

bool equations_integrate(struct equations *e, int first, int count, const int *name,
                         bool along_axes, struct error *error)
{
    struct integration integration = {.g = &e->graph};
    const int outputs = along_axes ? count : 3 * count;
    int made[3 * LIMIT_VARIABLES];
    integration.has = malloc(GRAPH_MAX * sizeof *integration.has);
    integration.mark = malloc(GRAPH_MAX * sizeof *integration.mark);
    integration.map = malloc(GRAPH_MAX * sizeof *integration.map);
    integration.value = malloc(GRAPH_MAX * sizeof *integration.value);
    integration.summand = malloc(SUMMANDS_MAX * sizeof *integration.summand);
    bool fine = integration.has && integration.mark && integration.map && integration.value &&
                integration.summand && !is_full(&integration) &&
                integrate_rows(&integration, e->output + first, name, count, along_axes, made) &&
                equations_reserve(e, outputs);
    free(integration.has);
    free(integration.mark);
    free(integration.map);
    free(integration.value);
    free(integration.summand);
    if (!graph_check(&e->graph, error) || !fine)
        return false;
    memcpy(e->output + e->outputs, made, (size_t)outputs * sizeof *made);
    e->outputs += outputs;
    return true;
}
