/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The order of every row from its coefficients alone. Runge-Kutta: all rooted trees up to order 8 (Butcher 1963;
 * Hairer, Norsett, Wanner I, II.2). Splittings: exp(h(A + B)) word by word in the free algebra (Hairer, Lubich, Wanner,
 * III.5). An order must EQUAL the claim: the conditions one order higher must fail.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "../../src/method/step.h"
#include "method_testing.h"

#define HOLDS 2e-14 /* rounding of the coefficients */
#define FAILS 1e-8  /* what a condition that does not hold is at least off by */

enum { ORDERS = 9, TREES = 1024, STAGES = 64, WORDS = 10 };

/* ---- rooted trees ----
 *
 * A tree is a smaller tree with one more branch at its root. Written so that branches never grow (in table order), each
 * tree appears once.
 */

struct tree {
    int order, trunk, branch; /* trunk < 0: the single node */
    double density;           /* gamma(t) */
};

struct forest {
    int count, first[ORDERS + 2]; /* first[p]: where the trees of order p begin */
    struct tree tree[TREES];
};

/* The density belongs to the whole tree: gamma = order * product of the branches' gamma. */
static double trunk_product(const struct forest *forest, int i)
{
    return forest->tree[i].density / forest->tree[i].order;
}

static void forest_grow(struct forest *forest)
{
    forest->tree[0] = (struct tree){1, -1, -1, 1};
    forest->count = 1;
    forest->first[1] = 0;
    forest->first[2] = 1;
    for (int order = 2; order <= ORDERS; order++) {
        for (int trunk = 0; trunk < forest->first[order]; trunk++)
            for (int branch = 0; branch < forest->first[order]; branch++) {
                const struct tree *t = &forest->tree[trunk], *b = &forest->tree[branch];
                if (t->order + b->order != order || (t->branch >= 0 && branch > t->branch))
                    continue;
                assert_true(forest->count < TREES);
                double density = order * trunk_product(forest, trunk) * b->density;
                forest->tree[forest->count++] = (struct tree){order, trunk, branch, density};
            }
        forest->first[order + 1] = forest->count;
    }
}

/* weight[tree][stage]: product over the branches of sum_j a_ij weight[branch][j] */
static void stage_weights(const struct forest *forest, const struct tableau *tableau, double weight[TREES][STAGES])
{
    for (int t = 0; t < forest->count; t++)
        for (int i = 0; i < tableau->stages; i++) {
            const struct tree *tree = &forest->tree[t];
            weight[t][i] = 1;
            if (tree->trunk < 0)
                continue;
            double sum = 0;
            for (int j = 0; j < i; j++)
                sum += tableau_row(tableau, i)[j] * weight[tree->branch][j];
            weight[t][i] = weight[tree->trunk][i] * sum;
        }
}

/* Largest violation of sum_i b_i weight_i = theta^order / density among the trees of one order. */
static double violation(const struct forest *forest, const struct tableau *tableau, double weight[TREES][STAGES],
                        const double *b, int order, double theta)
{
    double largest = 0;
    for (int t = forest->first[order]; t < forest->first[order + 1]; t++) {
        double sum = 0;
        for (int i = 0; i < tableau->stages; i++)
            sum += b[i] * weight[t][i];
        largest = fmax(largest, fabs(sum - pow(theta, order) / forest->tree[t].density));
    }
    return largest;
}

static void assert_order(const char *what, const struct forest *forest, const struct tableau *tableau,
                         double weight[TREES][STAGES], const double *b, int claim, double theta)
{
    assert_in_range(claim, 1, ORDERS - 1);
    for (int order = 1; order <= claim; order++)
        assert_below(what, violation(forest, tableau, weight, b, order, theta), HOLDS);
    assert_above(what, violation(forest, tableau, weight, b, claim + 1, theta), FAILS);
}

static struct forest forest;
static double weight[TREES][STAGES];

static void test_number_of_trees(void **state)
{
    (void)state;
    static const int known[ORDERS + 1] = {0, 1, 1, 2, 4, 9, 20, 48, 115, 286};
    forest_grow(&forest);
    for (int order = 1; order <= ORDERS; order++)
        assert_int_equal(forest.first[order + 1] - forest.first[order], known[order]);
    /* The bushy tree of order p has density p, the tall one p!. */
    double least = HUGE_VAL, most = 0;
    for (int t = forest.first[5]; t < forest.first[6]; t++) {
        least = fmin(least, forest.tree[t].density);
        most = fmax(most, forest.tree[t].density);
    }
    assert_near("bushy", least, 5, 0);
    assert_near("tall", most, 120, 0);
}

static void test_tableau_orders(void **state)
{
    (void)state;
    int tableaus = 0;
    forest_grow(&forest);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau)
            continue;
        tableaus++;
        assert_true(tableau->stages <= STAGES);
        stage_weights(&forest, tableau, weight);
        assert_order(method->row.name, &forest, tableau, weight, tableau->b, method->order, 1);
        assert_int_equal(method->embedded > 0, tableau->companion != NULL);
        assert_int_equal(method->embedded > 0, !!(method->flags & METHOD_ADAPTIVE));
        if (tableau->companion)
            assert_order(method->row.name, &forest, tableau, weight, tableau->companion, method->embedded, 1);
    }
    assert_true(tableaus >= 5);
}

static void test_tableau_shape(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau)
            continue;
        int stages = tableau->stages;
        for (int i = 0; i < stages; i++) {
            double sum = 0;
            for (int j = 0; j < i; j++)
                sum += tableau_row(tableau, i)[j];
            assert_near(method->row.name, sum, tableau->c[i], HOLDS);
        }
        if (tableau->fsal) { /* the last stage is the new state, so the two must be the same numbers */
            assert_near(method->row.name, tableau->c[stages - 1], 1, 0);
            assert_near(method->row.name, tableau->b[stages - 1], 0, 0);
            for (int j = 0; j < stages - 1; j++)
                assert_near(method->row.name, tableau_row(tableau, stages - 1)[j], tableau->b[j], 0);
        }
        assert_int_equal(method->evals, stages - tableau->fsal);
    }
}

/* An interpolant is of order p - 1 at least, everywhere inside, and meets the step's end. */
static void test_dense_orders(void **state)
{
    (void)state;
    int interpolants = 0;
    forest_grow(&forest);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau || !tableau->dense)
            continue;
        interpolants++;
        assert_non_null(method->dense);
        stage_weights(&forest, tableau, weight);
        for (double theta = 0.1; theta < 1.05; theta += 0.1) {
            double b[STAGES];
            for (int i = 0; i < tableau->stages; i++) {
                b[i] = 0;
                for (int k = tableau->degree; k-- > 0;)
                    b[i] = (b[i] + tableau->dense[i * tableau->degree + k]) * theta;
                if (theta > 0.95)
                    assert_near(method->row.name, b[i], tableau->b[i], HOLDS);
            }
            for (int order = 1; order < method->order; order++)
                assert_below(method->row.name, violation(&forest, tableau, weight, b, order, theta), HOLDS);
        }
    }
    assert_true(interpolants >= 1);
}

/* A typo in the last digits of one coefficient is seen. */
static void test_a_typo_is_seen(void **state)
{
    (void)state;
    const struct tableau *rk4 = method_named("rk4")->tableau;
    double b[] = {rk4->b[0], rk4->b[1] + 1e-12, rk4->b[2], rk4->b[3]};
    forest_grow(&forest);
    stage_weights(&forest, rk4, weight);
    assert_above("typo", violation(&forest, rk4, weight, b, 1, 1), 10 * HOLDS);
}

/* ---- splittings: coefficients of all words in A (0) and B (1) up to WORDS letters ---- */

struct series {
    double word[WORDS + 1][1 << WORDS]; /* [length][letters as bits, the last letter lowest] */
};

/* series times exp(w letter) */
static void series_times(struct series *series, unsigned letter, double w)
{
    for (int length = WORDS; length >= 1; length--)
        for (unsigned word = 0; word < 1u << length; word++) {
            double factor = 1;
            for (int j = 1; j <= length && (word >> (j - 1) & 1u) == letter; j++) {
                factor *= w / j;
                series->word[length][word] += factor * series->word[length - j][word >> j];
            }
        }
}

/* Largest difference from exp(A + B), whose words of length k all have the coefficient 1/k!. */
static double series_violation(const struct series *series, int length)
{
    double want = 1, largest = 0;
    for (int k = 2; k <= length; k++)
        want /= k;
    for (unsigned word = 0; word < 1u << length; word++)
        largest = fmax(largest, fabs(series->word[length][word] - want));
    return largest;
}

static void test_splitting_orders(void **state)
{
    (void)state;
    static struct series series;
    int splittings = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct splitting *splitting = method->splitting;
        if (!splitting)
            continue;
        splittings++;
        memset(&series, 0, sizeof series);
        series.word[0][0] = 1;
        for (int i = 0; i < splitting->count; i++)
            series_times(&series, (i % 2 == 0) == splitting->kick_first, splitting->weight[i]);
        assert_in_range(method->order, 1, WORDS - 1);
        for (int order = 1; order <= method->order; order++)
            assert_below(method->row.name, series_violation(&series, order), HOLDS);
        assert_above(method->row.name, series_violation(&series, method->order + 1), FAILS);
    }
    assert_true(splittings >= 4);
}

static void test_palindromes(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct splitting *splitting = method->splitting;
        if (!splitting)
            continue;
        int count = splitting->count;
        bool palindrome = count % 2 == 1;
        for (int i = 0; i < count / 2; i++)
            palindrome = palindrome && splitting->weight[i] == splitting->weight[count - 1 - i];
        assert_int_equal(palindrome, !!(method->flags & METHOD_SYMMETRIC));
        int kicks = (count + splitting->kick_first) / 2;
        assert_int_equal(method->evals, kicks - (splitting->kick_first && count % 2 == 1));
        assert_true(method->flags & METHOD_SECOND_ORDER && method->flags & METHOD_SYMPLECTIC);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_number_of_trees), cmocka_unit_test(test_tableau_orders),
        cmocka_unit_test(test_tableau_shape),   cmocka_unit_test(test_dense_orders),
        cmocka_unit_test(test_a_typo_is_seen),  cmocka_unit_test(test_splitting_orders),
        cmocka_unit_test(test_palindromes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
