/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What every implicit Runge-Kutta row claims, from its coefficients alone: order (also of the error
 * estimate), row sums, the transformation that its solver uses, symplecticity, symmetry, A- and
 * L-stability, stiff accuracy.
 */
#include "cmocka_testing.h"

#include <complex.h>

#include "method/step/step.h"
#include "numerics/trees.h"

enum { MOST = 8 };

static struct forest forest;
static struct tree_weights weights;

static const struct implicit_tableau *tableau_at(size_t i, const char **name)
{
    *name = method_at(i)->row.name;
    return method_at(i)->implicit;
}

static bool has(size_t i, enum method_flag flag)
{
    return method_at(i)->flags & flag;
}

/* The tableau with the start as a stage before the others: the error estimate of radau5 uses its
 * slope. */
static void with_start(const struct implicit_tableau *row, double *a)
{
    int s = row->stages;
    memset(a, 0, (size_t)((s + 1) * (s + 1)) * sizeof *a);
    for (int i = 0; i < s; i++)
        for (int j = 0; j < s; j++)
            a[(i + 1) * (s + 1) + j + 1] = row->a[i * s + j];
}

/* b and what the estimate, without its filter, adds: (h f(t, y) + sum_i estimate_i z_i) / real */
static void estimate_weights(const struct implicit_tableau *row, double *b)
{
    int s = row->stages;
    b[0] = 1 / row->real;
    for (int j = 0; j < s; j++) {
        b[j + 1] = row->b[j];
        for (int i = 0; i < s; i++)
            b[j + 1] += row->estimate[i] * row->a[i * s + j] / row->real;
    }
}

TEST(test_orders)
{
    int rows = 0;
    forest_grow(&forest);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const char *name;
        const struct implicit_tableau *row = tableau_at(m, &name);
        if (!row)
            continue;
        rows++;
        tree_weigh(&forest, row->stages, row->a, row->a, &weights);
        int order = method_at(m)->order, embedded = method_at(m)->embedded;
        assert_tree_order(name, &forest, &weights, row->b, order, 1);
        assert_int_equal(embedded > 0, row->b_hat || row->estimate);
        assert_int_equal(embedded > 0, has(m, METHOD_ADAPTIVE));
        /* Where the companion is of a higher order than the method, the estimate is that of the
         * method's error. */
        if (row->b_hat)
            assert_tree_order(name, &forest, &weights, row->b_hat,
                              embedded == order ? order + 1 : embedded, 1);
        if (row->estimate) {
            double a[MOST * MOST], b[MOST];
            with_start(row, a);
            estimate_weights(row, b);
            tree_weigh(&forest, row->stages + 1, a, a, &weights);
            assert_tree_order(name, &forest, &weights, b, embedded, 1);
        }
    }
    assert_true(rows >= 9);
}

/* A typo in the last digits of one coefficient is seen. */
TEST(test_a_typo_is_seen)
{
    const struct implicit_tableau *row = method_named("radau5")->implicit;
    double a[9];
    memcpy(a, row->a, sizeof a);
    a[4] += 1e-12;
    forest_grow(&forest);
    tree_weigh(&forest, 3, a, a, &weights);
    double max = 0;
    for (int order = 1; order <= 5; order++)
        max = fmax(max, tree_violation(&forest, &weights, row->b, order, 1));
    assert_above("typo", max, 5 * TREE_HOLDS);
}

static bool same_last_row(const struct implicit_tableau *row)
{
    return memcmp(row->a + (row->stages - 1) * row->stages, row->b,
                  (size_t)row->stages * sizeof *row->b) == 0;
}

TEST(test_shape)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const char *name;
        const struct implicit_tableau *row = tableau_at(m, &name);
        if (!row)
            continue;
        int s = row->stages;
        for (int i = 0; i < s; i++) {
            double sum = 0;
            for (int j = 0; j < s; j++)
                sum += row->a[i * s + j];
            assert_near(name, sum, row->c[i], 1e-15);
        }
        assert_true(has(m, METHOD_IMPLICIT));
        if (has(m, METHOD_L_STABLE))
            assert_true(same_last_row(row));
        if (row->fsal) {
            assert_true(same_last_row(row));
            assert_near(name, row->a[0], 0, 0);
        }
        for (int i = 0; i < s && row->diagonal != 0; i++)
            for (int j = i; j < s; j++)
                if (i > 0 || j > 0 || row->a[0] != 0)
                    assert_near(name, row->a[i * s + j], i == j ? row->diagonal : 0, 0);
    }
}

/* d a = b; a T Lambda = T and left a T = 1, for the eigenvalues and vectors that the solver uses.
 */
TEST(test_transformation)
{
    int rows = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const char *name;
        const struct implicit_tableau *row = tableau_at(m, &name);
        if (!row || row->diagonal != 0)
            continue;
        rows++;
        int s = row->stages, pair = row->real != 0;
        assert_in_range(s, 2, 3);
        assert_int_equal(s, pair + 2);
        double lambda[9] = {0}, at[9];
        lambda[0] = row->real;
        lambda[pair * s + pair] = lambda[(pair + 1) * s + pair + 1] = row->alpha;
        lambda[pair * s + pair + 1] = -row->beta;
        lambda[(pair + 1) * s + pair] = row->beta;
        for (int i = 0; i < s; i++)
            for (int j = 0; j < s; j++) {
                at[i * s + j] = 0;
                for (int k = 0; k < s; k++)
                    at[i * s + j] += row->a[i * s + k] * row->right[k * s + j];
            }
        for (int i = 0; i < s; i++) {
            double b = 0;
            for (int j = 0; j < s; j++) {
                double vectors = 0, unit = 0;
                b += row->d[j] * row->a[j * s + i];
                for (int k = 0; k < s; k++) {
                    vectors += at[i * s + k] * lambda[k * s + j];
                    unit += row->left[i * s + k] * at[k * s + j];
                }
                assert_near(name, vectors, row->right[i * s + j], 1e-15);
                assert_near(name, unit, i == j, 2e-14);
            }
            assert_near(name, b, row->b[i], 1e-15);
        }
    }
    assert_true(rows >= 4);
}

/* Symplectic: b_i a_ij + b_j a_ji = b_i b_j (HLW VI.4.3); symmetric: a_s+1-i,s+1-j + a_ij = b_j
 * (HLW V.2.3). */
TEST(test_geometry)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const char *name;
        const struct implicit_tableau *row = tableau_at(m, &name);
        if (!row)
            continue;
        int s = row->stages;
        double symplectic = 0, symmetric = 0;
        for (int i = 0; i < s; i++)
            for (int j = 0; j < s; j++) {
                double ij = row->a[i * s + j], ji = row->a[j * s + i],
                       mirror = row->a[(s - 1 - i) * s + s - 1 - j];
                symplectic =
                    fmax(symplectic, fabs(row->b[i] * ij + row->b[j] * ji - row->b[i] * row->b[j]));
                symmetric = fmax(symmetric, fabs(mirror + ij - row->b[j]));
            }
        has(m, METHOD_SYMPLECTIC) ? assert_below(name, symplectic, 1e-15)
                                  : assert_above(name, symplectic, 1e-3);
        has(m, METHOD_SYMMETRIC) ? assert_below(name, symmetric, 1e-15)
                                 : assert_above(name, symmetric, 1e-3);
    }
}

/* R(z) = 1 + z b (1 - z a)^-1 1, by Gaussian elimination */
static double complex stability(int s, const double *a, const double *b, double complex z)
{
    double complex matrix[MOST * MOST], x[MOST], value = 1;
    for (int i = 0; i < s; i++) {
        x[i] = 1;
        for (int j = 0; j < s; j++)
            matrix[i * s + j] = (i == j) - z * a[i * s + j];
    }
    for (int p = 0; p < s; p++)
        for (int i = 0; i < s; i++) {
            if (i == p)
                continue;
            double complex factor = matrix[i * s + p] / matrix[p * s + p];
            for (int j = 0; j < s; j++)
                matrix[i * s + j] -= factor * matrix[p * s + j];
            x[i] -= factor * x[p];
        }
    for (int i = 0; i < s; i++)
        value += z * b[i] * (x[i] / matrix[i * s + i]);
    return value;
}

static double most_on_the_axis(int s, const double *a, const double *b, double *min)
{
    double max = 0;
    *min = HUGE_VAL;
    for (double y = 1e-3; y < 1e5; y *= 1.01) {
        double size = cabs(stability(s, a, b, (double complex)I * y));
        max = fmax(max, size);
        *min = fmin(*min, size);
    }
    return max;
}

/* No poles on the left: the rows' |R| has its maximum on the axis (all their eigenvalues have
 * positive real parts). */
TEST(test_stability)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const char *name;
        const struct implicit_tableau *row = tableau_at(m, &name);
        if (!row)
            continue;
        double min, max = most_on_the_axis(row->stages, row->a, row->b, &min);
        assert_int_equal(max <= 1 + 1e-9, has(m, METHOD_A_STABLE));
        assert_int_equal(max - min < 1e-9, has(m, METHOD_ENERGY));
        assert_int_equal(cabs(stability(row->stages, row->a, row->b, -1e9)) < 1e-6,
                         has(m, METHOD_L_STABLE));
    }
    const double rk4[16] = {[4] = 0.5, [9] = 0.5, [14] = 1}, b[] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
    double min;
    assert_above("rk4 is not A-stable", most_on_the_axis(4, rk4, b, &min), 2);
}

/* Leading terms of phase and amplitude error a step on the undamped oscillator. */
TEST(test_leading_errors)
{
    const struct {
        const char *name;
        int order;
        double frequency, damping; /* of x^order; of x^(order or order + 1 or 2) */
        int damping_order;
    } known[] = {
        {"backward-euler", 2, -1. / 3, -1. / 2, 2}, {"implicit-midpoint", 2, -1. / 12, 0, 2},
        {"trapezoid", 2, -1. / 12, 0, 2},           {"gauss4", 4, -1. / 720, 0, 4},
        {"gauss6", 6, -1. / 100800, 0, 6},          {"radau3", 4, -1. / 270, -1. / 72, 4},
        {"radau5", 6, -1. / 42000, -1. / 7200, 6},  {"sdirk2", 2, -0.0404401, -0.00367966, 4},
        {"tr-bdf2", 2, -0.0404401, -0.00367966, 4},
    };
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct implicit_tableau *row = method_named(known[i].name)->implicit;
        double x = known[i].order == 6 ? 0.2 : 0.02;
        double complex r = stability(row->stages, row->a, row->b, (double complex)I * x);
        double frequency = (carg(r) / x - 1) / pow(x, known[i].order);
        double damping = log(cabs(r)) / pow(x, known[i].damping_order);
        assert_near(known[i].name, frequency, known[i].frequency, 0.01 * fabs(known[i].frequency));
        assert_near(known[i].name, damping, known[i].damping, 0.01 * fabs(known[i].damping) + 1e-8);
    }
}

RUN_TESTS(NULL, NULL)
