/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Rooted trees up to order 9 and the order conditions on them: sum_i b_i weight_i(tree) =
 * theta^order / density. For explicit, implicit and linearly implicit Runge-Kutta methods. Sources:
 * Butcher 1963; Hairer, Norsett, Wanner I, II.2; Hairer, Wanner II, IV.7.
 *
 * A tree is a smaller tree (its trunk) with one more branch at its root. Written so that branches
 * never grow (in table order), each tree appears once. Include after cmocka and method_testing.h;
 * one static struct forest and one static struct tree_weights (1 MB) are enough for a test program.
 */
#pragma once

#include "numerics/method/testing.h"

#define TREE_HOLDS 2e-14 /* rounding of the coefficients, in units of the largest terms */
#define TREE_FAILS 1e-8  /* what a condition that does not hold is at least off by */

enum { TREE_ORDERS = 9, TREES = 512, TREE_STAGES = 64 };

struct tree {
    int order, trunk, branch; /* trunk < 0: the single node */
    double density;           /* gamma(t) */
};

struct forest {
    int count, first[TREE_ORDERS + 2]; /* first[p]: where the trees of order p begin */
    struct tree tree[TREES];
};

static inline void forest_grow(struct forest *forest)
{
    forest->tree[0] = (struct tree){1, -1, -1, 1};
    forest->count = 1;
    forest->first[1] = 0;
    forest->first[2] = 1;
    for (int order = 2; order <= TREE_ORDERS; order++) {
        for (int trunk = 0; trunk < forest->first[order]; trunk++)
            for (int branch = 0; branch < forest->first[order]; branch++) {
                const struct tree *t = &forest->tree[trunk], *b = &forest->tree[branch];
                if (t->order + b->order != order || (t->branch >= 0 && branch > t->branch))
                    continue;
                assert_true(forest->count < TREES);
                /* The density belongs to the whole tree: gamma = order * product of the branches'
                 * gamma. */
                double density = order * (t->density / t->order) * b->density;
                forest->tree[forest->count++] = (struct tree){order, trunk, branch, density};
            }
        forest->first[order + 1] = forest->count;
    }
}

/* A sum, and the sum of its terms' sizes: rounding is measured against that. */
struct tree_weight {
    double value, size;
};

struct tree_weights {
    int stages;
    struct tree_weight of[TREES][TREE_STAGES]; /* of each tree at each stage */
    /* the same where more branches will follow at the root */
    struct tree_weight among[TREES][TREE_STAGES];
};

static inline struct tree_weight tree_branch(int stages, const double *row,
                                             const struct tree_weight *branch)
{
    struct tree_weight sum = {0, 0};
    for (int j = 0; j < stages; j++) {
        sum.value += row[j] * branch[j].value;
        sum.size += fabs(row[j]) * branch[j].size;
    }
    return sum;
}

/*
 * Product over the branches of sum_j a_ij weight_j(branch), for a [stages][stages]. A root with
 * only one branch takes `single` instead of `a`: alpha + gamma where alpha is `a` in Rosenbrock
 * methods (IV.7, eq. 7.11'), `a` itself else.
 */
static inline void tree_weigh(const struct forest *forest, int stages, const double *a,
                              const double *single, struct tree_weights *weights)
{
    assert_in_range(stages, 1, TREE_STAGES);
    weights->stages = stages;
    for (int t = 0; t < forest->count; t++)
        for (int i = 0; i < stages; i++) {
            const struct tree *tree = &forest->tree[t];
            struct tree_weight *of = &weights->of[t][i], *among = &weights->among[t][i];
            if (tree->trunk < 0) {
                *of = *among = (struct tree_weight){1, 1};
                continue;
            }
            const struct tree_weight *trunk = &weights->among[tree->trunk][i],
                                     *branch = weights->of[tree->branch];
            struct tree_weight factor = tree_branch(stages, a + i * stages, branch);
            *among = (struct tree_weight){trunk->value * factor.value, trunk->size * factor.size};
            *of = tree->trunk > 0 ? *among : tree_branch(stages, single + i * stages, branch);
        }
}

/*
 * Largest violation among the trees of one order, for weights b [stages] of the state at t + theta
 * h. In units of the terms' size where that is more than 1.
 */
static inline double tree_violation(const struct forest *forest, const struct tree_weights *weights,
                                    const double *b, int order, double theta)
{
    double largest = 0;
    for (int t = forest->first[order]; t < forest->first[order + 1]; t++) {
        struct tree_weight sum = tree_branch(weights->stages, b, weights->of[t]);
        double wanted = pow(theta, order) / forest->tree[t].density;
        largest = fmax(largest, fabs(sum.value - wanted) / fmax(1, sum.size));
    }
    return largest;
}

/* The order of the weights b equals the claim: the conditions one order higher must fail. */
static inline void assert_tree_order(const char *what, const struct forest *forest,
                                     const struct tree_weights *weights, const double *b, int claim,
                                     double theta)
{
    assert_in_range(claim, 1, TREE_ORDERS - 1);
    for (int order = 1; order <= claim; order++)
        assert_below(what, tree_violation(forest, weights, b, order, theta), TREE_HOLDS);
    assert_above(what, tree_violation(forest, weights, b, claim + 1, theta), TREE_FAILS);
}
