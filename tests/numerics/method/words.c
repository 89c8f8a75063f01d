/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The order of every splitting from its weights alone: exp(h(A + B)) word by word in the free
 * algebra (Hairer, Lubich, Wanner, III.5), which holds for any two flows A and B, so also for kicks
 * that contain linear drag. Splittings for q'' = F(t, q) alone (METHOD_NO_VELOCITY): the conditions
 * of Nystrom's trees (Hairer, Norsett, Wanner I, II.14). An order must EQUAL the claim: the
 * conditions one order higher must fail.
 */
#include "cmocka_testing.h"

#include "method/step/step.h"
#include "numerics/method/testing.h"

#define HOLDS 2e-14 /* rounding of the weights */
#define FAILS 1e-8  /* what a condition that does not hold is at least off by */

enum { WORDS = 10, TREES = 128, POWERS = 8, KICKS = 32 };

static bool only_positions(const struct method *method)
{
    return method->flags & METHOD_NO_VELOCITY;
}

/* ---- coefficients of all words in A (0, drift) and B (1, kick) up to WORDS letters ---- */

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

/* The step with one weight moved. */
static const struct series *series_of(const struct splitting *splitting, int moved, double by)
{
    static struct series series;
    memset(&series, 0, sizeof series);
    series.word[0][0] = 1;
    for (int i = 0; i < splitting->count; i++) {
        double w = splitting_weight(splitting, i) + (i == moved ? by : 0);
        series_times(&series, (i % 2 == 0) == splitting->kick_first, w);
    }
    return &series;
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

/* General splittings have their order word by word, those for positions alone only up to 4 (checked
 * here to be so). */
TEST(test_word_orders)
{
    int general = 0, special = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!method->splitting)
            continue;
        *(only_positions(method) ? &special : &general) += 1;
        int claim = only_positions(method) ? 4 : method->order;
        const struct series *series = series_of(method->splitting, -1, 0);
        assert_in_range(claim, 1, WORDS - 1);
        for (int order = 1; order <= claim; order++)
            assert_below(method->row.name, series_violation(series, order), HOLDS);
        assert_above(method->row.name, series_violation(series, claim + 1), FAILS);
    }
    assert_true(general >= 17 && special >= 2);
}

/* Residuals of the first conditions that fail, from an independent computation with 50 digits. */
TEST(test_known_residuals)
{
    static const struct {
        const char *name;
        int degree;
        double residual;
    } rows[] = {
        {"ruth3", 4, 0.028},
        {"forest-ruth", 5, 0.10},
        {"suzuki4", 5, 0.0045},
        {"mclachlan4", 5, 0.0034},
        {"mclachlan5", 5, 0.00076},
        {"pefrl", 5, 0.0028},
        {"blanes-moan4", 5, 0.00058},
        {"blanes-moan4s", 5, 0.00019},
        {"blanes-moan6", 7, 1.1e-5},
        {"verlet", 3, 0.17},
        {"blanes-moan6-11", 5, 1.5e-5},
        {"blanes-moan6-14", 5, 6.1e-5},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        const struct series *series = series_of(method_named(rows[i].name)->splitting, -1, 0);
        double got = series_violation(series, rows[i].degree);
        assert_near(rows[i].name, got / rows[i].residual, 1, 0.05);
    }
}

/* A typo in the last digits of any weight is seen. */
TEST(test_a_typo_is_seen)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        for (int i = 0; method->splitting && i < method->splitting->count; i++) {
            const struct series *series = series_of(method->splitting, i, 1e-12);
            assert_above(method->row.name, series_violation(series, 1), 10 * HOLDS);
        }
    }
}

/* ---- Nystrom's trees ----
 *
 * A kick at q + c h v + h^2 sum_j a_j k_j, expanded in F: F itself, or a tree with one more branch
 * at its root, which is v (factor c, one power of h) or a tree (factor sum_j a_j weight_j, two more
 * powers than it has). Written so that branches never grow (in table order, v before all), each
 * tree appears once. On the exact solution a tree of power r is exact theta^r: v gives 1, a tree
 * exact/((r + 1)(r + 2)).
 */

enum { NOTHING = -2, VELOCITY = -1 };

struct tree {
    int power, trunk, branch;
    double exact;
};

struct forest {
    int count, first[POWERS + 1]; /* first[r]: where the trees of power r begin */
    struct tree tree[TREES];
};

static void forest_grow(struct forest *forest)
{
    forest->tree[0] = (struct tree){0, NOTHING, NOTHING, 1};
    forest->count = 1;
    forest->first[0] = 0;
    for (int power = 1; power < POWERS; power++) {
        forest->first[power] = forest->count;
        for (int trunk = 0; trunk < forest->first[power]; trunk++)
            for (int branch = VELOCITY; branch < forest->first[power]; branch++) {
                const struct tree *t = &forest->tree[trunk];
                int r = branch == VELOCITY ? -1 : forest->tree[branch].power;
                if (t->power + r + 2 != power || (trunk > 0 && branch > t->branch))
                    continue;
                assert_true(forest->count < TREES);
                double factor =
                    branch == VELOCITY ? 1 : forest->tree[branch].exact / ((r + 1) * (r + 2));
                forest->tree[forest->count++] =
                    (struct tree){power, trunk, branch, t->exact * factor};
            }
    }
    forest->first[POWERS] = forest->count;
}

/* The kicks as stages: weights, times, and weight[tree][kick]. */
struct stages {
    int count;
    double b[KICKS], c[KICKS], weight[TREES][KICKS];
};

static void stages_of(const struct splitting *splitting, const struct forest *forest,
                      struct stages *stages)
{
    double c = 0;
    stages->count = 0;
    for (int i = 0; i < splitting->count; i++) {
        double w = splitting_weight(splitting, i);
        if ((i % 2 == 0) != splitting->kick_first) {
            c += w;
            continue;
        }
        assert_true(stages->count < KICKS);
        stages->b[stages->count] = w;
        stages->c[stages->count++] = c;
    }
    for (int t = 0; t < forest->count; t++)
        for (int i = 0; i < stages->count; i++) {
            const struct tree *tree = &forest->tree[t];
            double sum = 0;
            for (int j = 0; tree->branch >= 0 && j < i; j++)
                sum +=
                    stages->b[j] * (stages->c[i] - stages->c[j]) * stages->weight[tree->branch][j];
            double factor = tree->branch == NOTHING    ? 1
                            : tree->branch == VELOCITY ? stages->c[i]
                                                       : sum;
            stages->weight[t][i] = factor * (tree->trunk >= 0 ? stages->weight[tree->trunk][i] : 1);
        }
}

/* Largest violation among the conditions of one order: velocity by trees of power order - 1,
 * position order - 2. */
static double tree_violation(const struct forest *forest, const struct stages *stages, int order)
{
    double largest = 0;
    for (int t = 0; t < forest->count; t++) {
        int r = forest->tree[t].power;
        double v = 0, q = 0;
        for (int i = 0; i < stages->count; i++) {
            v += stages->b[i] * stages->weight[t][i];
            q += stages->b[i] * (1 - stages->c[i]) * stages->weight[t][i];
        }
        if (r == order - 1)
            largest = fmax(largest, fabs(v - forest->tree[t].exact / (r + 1)));
        if (r == order - 2)
            largest = fmax(largest, fabs(q - forest->tree[t].exact / ((r + 1) * (r + 2))));
    }
    return largest;
}

static struct forest forest;
static struct stages stages;

TEST(test_number_of_trees)
{
    /* Hairer, Norsett, Wanner I, table II.14.2 */
    static const int known[] = {1, 1, 2, 3, 6, 10, 20};
    forest_grow(&forest);
    for (int r = 0; r < (int)COUNT_OF(known); r++)
        assert_int_equal(forest.first[r + 1] - forest.first[r], known[r]);
}

/* The words imply the trees, so every row is checked; for those of positions alone it is the only
 * proof. */
TEST(test_tree_orders)
{
    forest_grow(&forest);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!method->splitting)
            continue;
        stages_of(method->splitting, &forest, &stages);
        for (int order = 1; order <= method->order; order++)
            assert_below(method->row.name, tree_violation(&forest, &stages, order), HOLDS);
        if (only_positions(method)) {
            assert_in_range(method->order, 5, POWERS - 2);
            assert_above(method->row.name, tree_violation(&forest, &stages, method->order + 1),
                         FAILS);
        }
    }
}

/* ---- shape ---- */

/* The weights of a splitting read the same backwards exactly if the method is marked as symmetric.
 * Its evaluations are its kicks, less one if the first kick reuses the last force of the step
 * before. */
TEST(test_palindromes)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct splitting *splitting = method->splitting;
        if (!splitting)
            continue;
        int count = splitting->count;
        bool palindrome = count % 2 == 1;
        for (int i = 0; i < count / 2; i++)
            palindrome = palindrome && splitting_weight(splitting, i) ==
                                           splitting_weight(splitting, count - 1 - i);
        assert_int_equal(palindrome, !!(method->flags & METHOD_SYMMETRIC));
        int kicks = (count + splitting->kick_first) / 2;
        assert_int_equal(method->evals, kicks - (splitting->kick_first && count % 2 == 1));
        assert_true(method->flags & METHOD_SECOND_ORDER && method->flags & METHOD_SYMPLECTIC);
    }
}

/* The closed forms behind the decimals. */
TEST(test_closed_forms)
{
    double root2 = cbrt(2), root4 = cbrt(4), root19 = sqrt(19), root471 = sqrt(471);
    const struct {
        const char *name;
        int i;
        double weight;
    } rows[] = {
        {"forest-ruth", 0, 0.5 / (2 - root2)},
        {"forest-ruth", 2, (1 - root2) / (2 - root2) / 2},
        {"forest-ruth", 3, -root2 / (2 - root2)},
        {"suzuki4", 0, 0.5 / (4 - root4)},
        {"suzuki4", 2, 1 / (4 - root4)},
        {"suzuki4", 4, (1 - root4) / (4 - root4) / 2},
        {"suzuki4", 5, -root4 / (4 - root4)},
        {"mclachlan4", 0, (642 + root471) / 3924},
        {"mclachlan4", 2, 121 * (12 - root471) / 3924},
        {"mclachlan5", 0, (14 - root19) / 108},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        assert_near(rows[i].name,
                    splitting_weight(method_named(rows[i].name)->splitting, rows[i].i),
                    rows[i].weight, 1e-15);
}

RUN_TESTS(NULL, NULL)
