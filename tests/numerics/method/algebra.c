/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The order of every Runge-Kutta and Runge-Kutta-Nystrom row from its coefficients alone: rooted
 * trees (trees.h) and special Nystrom trees (Hairer, Norsett, Wanner I, II.14). An order must EQUAL
 * the claim: the conditions one order higher must fail.
 */
#include "cmocka_testing.h"

#include "method/step/step.h"
#include "numerics/trees.h"

static struct forest forest;
static struct tree_weights weights;

static int grow(void **state)
{
    (void)state;
    forest_grow(&forest);
    return 0;
}

TEST(test_number_of_trees)
{
    static const int known[TREE_ORDERS + 1] = {0, 1, 1, 2, 4, 9, 20, 48, 115, 286};
    for (int order = 1; order <= TREE_ORDERS; order++)
        assert_int_equal(forest.first[order + 1] - forest.first[order], known[order]);
    /* The bushy tree of order p has density p, the tall one p!. */
    double min = HUGE_VAL, max = 0;
    for (int t = forest.first[5]; t < forest.first[6]; t++) {
        min = fmin(min, forest.tree[t].density);
        max = fmax(max, forest.tree[t].density);
    }
    assert_near("bushy", min, 5, 0);
    assert_near("tall", max, 120, 0);
}

/* The triangle of all stages as a full matrix. */
static void weigh(const struct tableau *tableau)
{
    static double a[TREE_STAGES * TREE_STAGES];
    int all = tableau->stages + tableau->extra;
    assert_in_range(all, 1, TREE_STAGES);
    for (int i = 0; i < all; i++)
        for (int j = 0; j < all; j++)
            a[i * all + j] = j < i ? tableau_row(tableau, i)[j] : 0;
    tree_weigh(&forest, all, a, a, &weights);
}

/* Weights of the stages, and none of the extra ones. */
static const double *padded(const struct tableau *tableau, const double *b,
                            double capacity[TREE_STAGES])
{
    for (int i = 0; i < tableau->stages + tableau->extra; i++)
        capacity[i] = i < tableau->stages ? b[i] : 0;
    return capacity;
}

TEST(test_tableau_orders)
{
    int tableaus = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau)
            continue;
        tableaus++;
        double b[TREE_STAGES];
        weigh(tableau);
        assert_tree_order(method->row.name, &forest, &weights, padded(tableau, tableau->b, b),
                          method->order, 1);
        assert_int_equal(method->embedded > 0, tableau->b_hat != NULL);
        assert_int_equal(method->embedded > 0, !!(method->flags & METHOD_ADAPTIVE));
        if (!tableau->b_hat)
            continue;
        /* With a rough embedded method the estimate is e^2/e_rough: the order is that of the
         * quotient. */
        int fine = method->embedded, rough = 3;
        if (tableau->rough) {
            fine = (method->embedded + 1 + (rough + 1)) / 2 - 1;
            assert_int_equal(2 * (fine + 1) - (rough + 1), method->embedded + 1);
            assert_tree_order(method->row.name, &forest, &weights,
                              padded(tableau, tableau->rough, b), rough, 1);
        }
        assert_tree_order(method->row.name, &forest, &weights, padded(tableau, tableau->b_hat, b),
                          fine, 1);
    }
    assert_true(tableaus >= 10);
}

TEST(test_tableau_shape)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau)
            continue;
        int stages = tableau->stages;
        for (int i = 0; i < stages + tableau->extra; i++) {
            double sum = 0, size = 1;
            for (int j = 0; j < i; j++) {
                sum += tableau_row(tableau, i)[j];
                size = fmax(size, fabs(tableau_row(tableau, i)[j]));
            }
            assert_near(method->row.name, sum, tableau->c[i], TREE_HOLDS * size);
        }
        if (tableau
                ->fsal) { /* the last stage is the new state, so the two must be the same numbers */
            assert_near(method->row.name, tableau->c[stages - 1], 1, 0);
            assert_near(method->row.name, tableau->b[stages - 1], 0, 0);
            for (int j = 0; j < stages - 1; j++)
                assert_near(method->row.name, tableau_row(tableau, stages - 1)[j], tableau->b[j],
                            0);
        }
        /* the interpolant takes the slope at the end from there */
        assert_true(!method->dense || tableau->fsal);
        assert_int_equal(method->evals, stages - tableau->fsal);
    }
}

/* Weights of the interpolant, from its definition in step.h. */
static void interpolant(const struct tableau *tableau, double theta, double weight[TREE_STAGES])
{
    int all = tableau->stages + tableau->extra;
    for (int i = 0; i < all; i++) {
        double b = i < tableau->stages ? tableau->b[i] : 0, first = i == 0,
               last = i == tableau->stages - 1;
        double power = theta * (1 - theta); /* theta (1 - theta) theta … */
        weight[i] = theta * b + power * (first - b);
        power *= theta;
        weight[i] += power * (2 * b - first - last);
        for (int m = 0; m < tableau->bends; m++) {
            power *= m % 2 == 0 ? 1 - theta : theta;
            weight[i] += power * tableau->dense[m * all + i];
        }
    }
}

/* The order of the interpolants everywhere inside is p - 1, and 3 at least. */
TEST(test_dense_orders)
{
    int interpolants = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct tableau *tableau = method->tableau;
        if (!tableau || !method->dense)
            continue;
        interpolants++;
        weigh(tableau);
        for (double theta = 0.1; theta < 0.95; theta += 0.1) {
            double b[TREE_STAGES];
            interpolant(tableau, theta, b);
            int claim = method->order > 4 ? method->order - 1 : 3;
            for (int order = 1; order <= claim; order++)
                assert_below(method->row.name, tree_violation(&forest, &weights, b, order, theta),
                             TREE_HOLDS);
            assert_above(method->row.name, tree_violation(&forest, &weights, b, claim + 1, theta),
                         TREE_FAILS);
        }
    }
    assert_true(interpolants >= 4);
}

/* Hairer, Norsett, Wanner, eq. II.10.17: |e5|^2 / sqrt(|e5|^2 + |e3|^2/100), in the direction of
 * e5. */
TEST(test_rough_estimate)
{
    const struct method *dop853 = method_named("dop853");
    const struct tableau *tableau = dop853->tableau;
    const struct system system = SPRING({"v0", 0.3});
    double y[2] = {system.start[0], system.start[1]}, error[2], e5[2], e3[2], work[256], fine = 0,
           rough = 0;
    assert_true(method_work_size(dop853, 2) <= COUNT_OF(work));
    struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.1, y, work);
    step.error = error;
    assert_int_equal(method_step(dop853, &step), STEP_OK);
    for (int i = 0; i < 2; i++) {
        double size = fmax(system.scale[i], fmax(fabs(y[i]), fabs(system.start[i])));
        e5[i] = e3[i] = 0;
        for (int s = 0; s < tableau->stages; s++) {
            e5[i] += 0.1 * (tableau->b[s] - tableau->b_hat[s]) * work[2 * s + i];
            e3[i] += 0.1 * (tableau->b[s] - tableau->rough[s]) * work[2 * s + i];
        }
        fine += e5[i] / size * (e5[i] / size);
        rough += e3[i] / size * (e3[i] / size);
    }
    assert_above("rough", rough, 4 * fine);
    for (int i = 0; i < 2; i++)
        assert_near("error", error[i] / (e5[i] * sqrt(fine / (fine + rough / 100))), 1, 1e-9);
}

/* A typo in the last digits of one coefficient is seen. */
TEST(test_a_typo_is_seen)
{
    const struct tableau *rk4 = method_named("rk4")->tableau;
    double b[] = {rk4->b[0], rk4->b[1] + 1e-12, rk4->b[2], rk4->b[3]};
    weigh(rk4);
    assert_above("typo", tree_violation(&forest, &weights, b, 1, 1), 10 * TREE_HOLDS);
}

/* ---- special Nystrom trees ----
 *
 * Derivatives of q'' = a(t, q): a node a, from which grow leaves (q' once, it becomes c) and nodes
 * again (q'', which becomes sum_j a_ij ...), the latter two edges up. Written as trunk and branch
 * like rooted trees; branch -1: a leaf.
 */

enum { NYSTROM_ORDERS = 7, NYSTROM_TREES = 128 };

struct nystrom_tree {
    int order, trunk, branch; /* trunk < 0: the single node; order of the velocity condition */
    double exact;             /* weight of the exact solution at time tau: exact tau^(order - 1) */
    struct tree_weight at[TREE_STAGES];
};

struct nystrom_forest {
    int count, first[NYSTROM_ORDERS + 2];
    struct nystrom_tree tree[NYSTROM_TREES];
};

static void nystrom_forest_grow(struct nystrom_forest *grown)
{
    grown->tree[0] = (struct nystrom_tree){.order = 1, .trunk = -1, .branch = -1, .exact = 1};
    grown->count = 1;
    grown->first[1] = 0;
    grown->first[2] = 1;
    for (int order = 2; order <= NYSTROM_ORDERS; order++) {
        for (int trunk = 0; trunk < grown->first[order]; trunk++)
            for (int branch = -1; branch < grown->first[order]; branch++) {
                const struct nystrom_tree *t = &grown->tree[trunk],
                                          *b = branch < 0 ? NULL : &grown->tree[branch];
                if (t->order + (b ? b->order + 1 : 1) != order ||
                    (t->trunk >= 0 && branch > t->branch))
                    continue;
                assert_true(grown->count < NYSTROM_TREES);
                /* q = double integral of tau^(order - 1) */
                double exact = t->exact * (b ? b->exact / (b->order * (b->order + 1)) : 1);
                grown->tree[grown->count++] = (struct nystrom_tree){
                    .order = order, .trunk = trunk, .branch = branch, .exact = exact};
            }
        grown->first[order + 1] = grown->count;
    }
}

static void nystrom_weigh(struct nystrom_forest *grown, const struct nystrom *nystrom)
{
    assert_in_range(nystrom->stages, 1, TREE_STAGES);
    for (int t = 0; t < grown->count; t++)
        for (int i = 0; i < nystrom->stages; i++) {
            struct nystrom_tree *tree = &grown->tree[t];
            struct tree_weight factor = {nystrom->c[i], nystrom->c[i]};
            if (tree->branch >= 0)
                factor = tree_branch(i, nystrom->a + i * (i - 1) / 2, grown->tree[tree->branch].at);
            const struct tree_weight *trunk =
                tree->trunk < 0 ? NULL : &grown->tree[tree->trunk].at[i];
            tree->at[i] =
                trunk ? (struct tree_weight){trunk->value * factor.value, trunk->size * factor.size}
                      : (struct tree_weight){1, 1};
        }
}

/* Largest violation of the conditions of one order: that of v by trees of this order, of q by those
 * one below. */
static double nystrom_violation(const struct nystrom_forest *grown, int stages, const double *b,
                                const double *d, int order)
{
    double largest = 0;
    for (int t = grown->first[order]; t < grown->first[order + 1]; t++) {
        struct tree_weight v = tree_branch(stages, d, grown->tree[t].at);
        largest = fmax(largest, fabs(v.value - grown->tree[t].exact / order) / fmax(1, v.size));
    }
    for (int t = order > 1 ? grown->first[order - 1] : 0; order > 1 && t < grown->first[order];
         t++) {
        struct tree_weight q = tree_branch(stages, b, grown->tree[t].at);
        largest = fmax(largest, fabs(q.value - grown->tree[t].exact / (order * (order - 1))) /
                                    fmax(1, q.size));
    }
    return largest;
}

static void assert_nystrom_order(const char *what, const struct nystrom_forest *grown, int stages,
                                 const double *b, const double *d, int claim)
{
    assert_in_range(claim, 1, NYSTROM_ORDERS - 1);
    for (int order = 1; order <= claim; order++)
        assert_below(what, nystrom_violation(grown, stages, b, d, order), TREE_HOLDS);
    assert_above(what, nystrom_violation(grown, stages, b, d, claim + 1), TREE_FAILS);
}

/* The trees of each order are as many as Hairer, Norsett, Wanner I tell, and the order of each
 * Nystrom method equals its claim. */
TEST(test_nystrom_orders)
{
    static const int known[NYSTROM_ORDERS + 1] = {
        0, 1, 1, 2, 3, 6, 10, 20}; /* Hairer, Norsett, Wanner I, section II.14, table 14.3 */
    static struct nystrom_forest grown;
    int rows = 0;
    nystrom_forest_grow(&grown);
    for (int order = 1; order <= NYSTROM_ORDERS; order++)
        assert_int_equal(grown.first[order + 1] - grown.first[order], known[order]);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        const struct nystrom *nystrom = method->nystrom;
        if (!nystrom)
            continue;
        rows++;
        const char *name = method->row.name;
        int stages = nystrom->stages;
        nystrom_weigh(&grown, nystrom);
        assert_nystrom_order(name, &grown, stages, nystrom->b, nystrom->d, method->order);
        assert_int_equal(method->embedded > 0, nystrom->embedded_b && nystrom->embedded_d);
        assert_int_equal(method->embedded > 0, !!(method->flags & METHOD_ADAPTIVE));
        if (method->embedded > 0)
            assert_nystrom_order(name, &grown, stages, nystrom->embedded_b, nystrom->embedded_d,
                                 method->embedded);
        for (int i = 0; i < stages; i++) /* q = c^2/2 with a constant acceleration */
            assert_near(name, tree_branch(i, nystrom->a + i * (i - 1) / 2, grown.tree[0].at).value,
                        nystrom->c[i] * nystrom->c[i] / 2, TREE_HOLDS);
        if (nystrom->fsal) {
            assert_near(name, nystrom->c[stages - 1], 1, 0);
            assert_near(name, nystrom->b[stages - 1], 0, 0);
            for (int j = 0; j < stages - 1; j++)
                assert_near(name, nystrom->a[(stages - 1) * (stages - 2) / 2 + j], nystrom->b[j],
                            0);
        }
        assert_int_equal(method->evals, stages - nystrom->fsal);
        assert_int_equal(method->flags & (METHOD_SECOND_ORDER | METHOD_NO_VELOCITY),
                         METHOD_SECOND_ORDER | METHOD_NO_VELOCITY);
    }
    assert_true(rows >= 3);
}

RUN_TESTS(grow, NULL)
