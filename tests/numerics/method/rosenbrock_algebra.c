/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Rosenbrock rows: the order from the coefficients alone, by conditions on rooted trees where a
 * vertex with one branch takes alpha + Gamma and one with more takes alpha (Hairer, Wanner II,
 * IV.7, theorem 7.4); and what a step reuses.
 */
#include "cmocka_testing.h"

#include "method/step/step.h"
#include "numerics/trees.h"

enum { STAGES_MAX = 8 };

static struct forest forest;
static struct tree_weights weights;

/* The textbook's matrices: Gamma^-1 = 1/gamma - C, alpha = A Gamma, b = m Gamma. */
struct textbook {
    int stages;
    double gamma[STAGES_MAX * STAGES_MAX], alpha[STAGES_MAX * STAGES_MAX],
        beta[STAGES_MAX * STAGES_MAX];
};

static double lower(const double *triangle, int i, int j)
{
    return triangle[i * (i - 1) / 2 + j];
}

/* w Gamma */
static void times_gamma(const struct textbook *book, const double *w, double *b)
{
    for (int j = 0; j < book->stages; j++) {
        b[j] = 0;
        for (int i = j; i < book->stages; i++)
            b[j] += w[i] * book->gamma[i * book->stages + j];
    }
}

static struct textbook textbook_of(const struct rosenbrock *row)
{
    struct textbook book = {.stages = row->stages};
    int n = row->stages;
    assert_in_range(n, 1, STAGES_MAX);
    /* Forward substitution: Gamma_i. / gamma - sum_j c_ij Gamma_j. = e_i */
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++) {
            double sum = i == k;
            for (int j = k; j < i; j++)
                sum += lower(row->c, i, j) * book.gamma[j * n + k];
            book.gamma[i * n + k] = row->gamma * sum;
        }
    for (int i = 0; i < n; i++) {
        double a[STAGES_MAX] = {0};
        for (int j = 0; j < i; j++)
            a[j] = lower(row->a, i, j);
        times_gamma(&book, a, book.alpha + i * n);
        for (int j = 0; j < n; j++)
            book.beta[i * n + j] = book.alpha[i * n + j] + book.gamma[i * n + j];
    }
    return book;
}

static const struct rosenbrock *rosenbrock_at(size_t i, const char **name)
{
    *name = method_at(i)->row.name;
    return method_at(i)->rosenbrock;
}

static struct textbook weigh(const struct rosenbrock *row)
{
    struct textbook book = textbook_of(row);
    forest_grow(&forest);
    tree_weigh(&forest, row->stages, book.alpha, book.beta, &weights);
    return book;
}

/* The conditions of order, one for each rooted tree, hold up to the method's order for its weights,
 * and up to the embedded order for the embedded weights, which adaptive methods alone have. */
TEST(test_orders)
{
    int rows = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name;
        const struct rosenbrock *row = rosenbrock_at(i, &name);
        if (!row)
            continue;
        rows++;
        struct textbook book = weigh(row);
        double b[STAGES_MAX];
        times_gamma(&book, row->m, b);
        assert_tree_order(name, &forest, &weights, b, method_at(i)->order, 1);
        assert_int_equal(row->b_hat != NULL, method_at(i)->embedded > 0);
        assert_int_equal(row->b_hat != NULL, !!(method_at(i)->flags & METHOD_ADAPTIVE));
        if (!row->b_hat)
            continue;
        times_gamma(&book, row->b_hat, b);
        assert_tree_order(name, &forest, &weights, b, method_at(i)->embedded, 1);
    }
    assert_true(rows >= 4);
}

/* alpha_i and d_i are the row sums: the same method for scenes that depend on time. */
TEST(test_row_sums)
{
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name;
        const struct rosenbrock *row = rosenbrock_at(i, &name);
        if (!row)
            continue;
        struct textbook book = textbook_of(row);
        for (int s = 0; s < row->stages; s++) {
            double alpha = 0, gamma = 0;
            for (int j = 0; j < row->stages; j++) {
                alpha += book.alpha[s * row->stages + j];
                gamma += book.gamma[s * row->stages + j];
            }
            assert_near(name, row->alpha[s], alpha, 1e-14);
            assert_near(name, row->d[s], gamma, 1e-14);
        }
    }
}

/* R(infinity) = 1 - b beta^-1 1: 0 where the row says L-stable, and only there; inside the unit
 * circle everywhere. */
TEST(test_damping_at_infinity)
{
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name;
        const struct rosenbrock *row = rosenbrock_at(i, &name);
        if (!row)
            continue;
        struct textbook book = textbook_of(row);
        double b[STAGES_MAX], x[STAGES_MAX], r = 1;
        times_gamma(&book, row->m, b);
        for (int s = 0; s < row->stages; s++) {
            x[s] = 1;
            for (int j = 0; j < s; j++)
                x[s] -= book.beta[s * row->stages + j] * x[j];
            x[s] /= row->gamma;
            r -= b[s] * x[s];
        }
        assert_below(name, fabs(r), 1);
        assert_int_equal(fabs(r) < 1e-12, !!(method_at(i)->flags & METHOD_L_STABLE));
    }
}

/* A companion with the same stability function sees no error at all on linear scenes, as that of
 * ros3p does. */
TEST(test_error_estimates_see_linear_motion)
{
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name;
        const struct rosenbrock *row = rosenbrock_at(i, &name);
        if (!row || !row->b_hat)
            continue;
        struct textbook book = textbook_of(row);
        /* of the terms in z^(embedded + 1) */
        double w[STAGES_MAX], b[STAGES_MAX], power[STAGES_MAX], difference = 0;
        for (int s = 0; s < row->stages; s++) {
            w[s] = row->m[s] - row->b_hat[s];
            power[s] = 1;
        }
        times_gamma(&book, w, b);
        for (int k = 0; k < method_at(i)->embedded; k++) {
            double next[STAGES_MAX] = {0};
            for (int s = 0; s < row->stages; s++)
                for (int j = 0; j <= s; j++)
                    next[s] += book.beta[s * row->stages + j] * power[j];
            memcpy(power, next, sizeof power);
        }
        for (int s = 0; s < row->stages; s++)
            difference += b[s] * power[s];
        assert_above(name, fabs(difference), 1e-5);
    }
}

/* y(theta) = (1 - theta) y + theta y' + theta (1 - theta) sum_m theta^m D_m: of order p - 1
 * everywhere. */
TEST(test_dense_orders)
{
    int interpolants = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name;
        const struct rosenbrock *row = rosenbrock_at(i, &name);
        if (!row || !row->dense)
            continue;
        interpolants++;
        struct textbook book = weigh(row);
        for (double theta = 0.1; theta < 0.95; theta += 0.1) {
            double w[STAGES_MAX], b[STAGES_MAX];
            for (int s = 0; s < row->stages; s++) {
                double bend = 0;
                for (int m = row->degree; m-- > 0;)
                    bend = bend * theta + row->dense[m * row->stages + s];
                w[s] = theta * row->m[s] + theta * (1 - theta) * bend;
            }
            times_gamma(&book, w, b);
            assert_tree_order(name, &forest, &weights, b, method_at(i)->order - 1, theta);
        }
    }
    assert_true(interpolants >= 2);
}

/* A typo in the last digits of one coefficient is seen. */
TEST(test_a_typo_is_seen)
{
    struct rosenbrock row = *method_named("rodas4")->rosenbrock;
    double m[STAGES_MAX], b[STAGES_MAX];
    memcpy(m, row.m, (size_t)row.stages * sizeof *m);
    m[1] += 1e-11;
    struct textbook book = weigh(&row);
    times_gamma(&book, m, b);
    assert_above("typo", tree_violation(&forest, &weights, b, 2, 1), TREE_HOLDS);
}

/* ---- the step ---- */

/* Copies of q'' = -q^3 - q'/2: positions, then velocities. */
enum { COPIES = 5 };

static void copies_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    int n = (int)c[0];
    for (int i = 0; i < n; i++)
        a[i] -= y[i] * y[i] * y[i] + y[n + i] / 2;
}

static void copies_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    int n = (int)c[0];
    for (int i = 0; i < n; i++) {
        jac[i * 2 * n + i] -= 3 * y[i] * y[i];
        jac[i * 2 * n + n + i] -= 0.5;
    }
}

static const struct term_row copies_row = {.row = {"copies", "m/s^2", "", "", NULL},
                                           .flags = TERM_VELOCITY,
                                           .add = copies_add,
                                           .jacobian = copies_jacobian};

/* Few unknowns are solved in another way than many. */
TEST(test_many_variables)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system one = other_system(&copies_row, 1), many = other_system(&copies_row, COPIES);
        double y[2] = {1, 0.2}, z[2 * COPIES];
        if (!method->rosenbrock)
            continue;
        many.n = 2 * COPIES;
        for (int i = 0; i < many.n; i++) {
            many.scale[i] = 1;
            z[i] = i < COPIES ? y[0] : y[1];
        }
        assert_int_equal(advance(method, &one, 0.1, 50, y), STEP_OK);
        assert_int_equal(advance(method, &many, 0.1, 50, z), STEP_OK);
        for (int i = 0; i < many.n; i++)
            assert_near(method->row.name, z[i], i < COPIES ? y[0] : y[1], 1e-13);
    }
}

/* A step that is tried again, shorter, takes f, J and df/dt from the work space, and comes out the
 * same to the bit. */
TEST(test_again)
{
    static double work[2][WORK_CAPACITY];
    const struct system systems[] = {SPRING({"gamma", 0.4}, {"F0", 0.1}), duffing(1)};
    for (size_t m = 0; m < method_catalog.count; m++)
        for (size_t s = 0; s < COUNT_OF(systems); s++) {
            const struct method *method = method_at(m);
            double y[2] = {0.3, 0.2}, z[2] = {0.3, 0.2};
            if (!method->rosenbrock)
                continue;
            struct step first = step_begin(&systems[s], DRAG_DEFAULT, 0, 0.5, y, work[0]);
            assert_int_equal(method_step(method, &first), STEP_OK);
            y[0] = 0.3, y[1] = 0.2;
            struct step again = step_begin(&systems[s], DRAG_DEFAULT, 0, 0.1, y, work[0]);
            struct step fresh = step_begin(&systems[s], DRAG_DEFAULT, 0, 0.1, z, work[1]);
            again.again = true;
            assert_int_equal(method_step(method, &again), STEP_OK);
            assert_int_equal(method_step(method, &fresh), STEP_OK);
            assert_memory_equal(y, z, sizeof y);
            assert_int_equal(again.cost.evals, fresh.cost.evals - 1);
            assert_int_equal(again.cost.jacobians, 0);
        }
}

RUN_TESTS(NULL, NULL)
