/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Linear multistep rows: order from the coefficients, each step against its own difference
 * equation, the start, what a changed step does, costs. (Measured orders are in method_order.c,
 * stability in method_stability.c.)
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "method/step/step.h"
#include "numerics/method/testing.h"

enum { STEPS_MAX = 6 };

static double work[2][WORK_CAPACITY];

/* Every multistep row, in turn. */
static const struct method *next_row(size_t *i)
{
    while (*i < method_catalog.count) {
        const struct method *method = method_at((*i)++);
        if (method->multistep)
            return method;
    }
    return NULL;
}

#define EACH_ROW(method)                                                                           \
    size_t row_index = 0;                                                                          \
    for (const struct method *method; (method = next_row(&row_index)) != NULL;)

/* ---- order: exact on polynomials up to t^order, not on the next one (Hairer, Norsett, Wanner I,
 * III.2) ---- */

static double power(double t, int q)
{
    return q == 0 ? 1 : pow(t, q);
}

/* 1/(q+1), the integral of t^q over the step from 0 to 1, minus what the weights of f at first,
 * first - 1, … say */
static double quadrature_violation(const double *b, int count, int first, int q)
{
    double sum = 0;
    for (int j = 0; j < count; j++)
        sum += b[j] * power(first - j, q);
    return fabs(sum - 1.0 / (q + 1));
}

/* The derivative of t^q at 1 minus what the differences say. */
static double difference_violation(const double *v, int steps, int q)
{
    double sum = 0;
    for (int j = 0; j <= steps; j++)
        sum += v[j] * power(1 - j, q);
    return fabs(sum - q);
}

TEST(test_orders)
{
    int rows = 0;
    EACH_ROW(method)
    {
        const struct multistep *m = method->multistep;
        rows++;
        for (int q = 0; q <= method->order; q++) {
            double off = 0;
            if (m->values)
                off = difference_violation(m->values, m->steps, q);
            else
                off = quadrature_violation(m->correct ? m->correct : m->predict, m->steps,
                                           m->correct != NULL, q);
            if (q < method->order + (m->values != NULL))
                assert_below(method->row.name, off, 1e-12);
            else
                assert_above(method->row.name, off, 1e-3);
            if (m->correct && q < method->order) /* the predictor may be one order lower */
                assert_below(method->row.name, quadrature_violation(m->predict, m->steps, 0, q),
                             1e-12);
        }
        if (m->values)
            assert_above(method->row.name,
                         difference_violation(m->values, m->steps, method->order + 1), 1e-3);
    }
    assert_true(rows >= 14);
}

/* ---- stepping ---- */

static struct system pushed_spring(void)
{
    struct system system = SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}, {"C", 0.75}, {"rho", 1},
                                  {"area", 1}, {"F0", 0.75}, {"omega", 2});
    return system;
}

/* y_n+1 of the difference equation from the states before (the newest last), as it stands in the
 * textbook. */
static double equation_error(const struct multistep *m, const struct system *system, double t,
                             double h, double y[][2], int n)
{
    double f[STEPS_MAX + 1][2], largest = 0;
    for (int j = 0; j <= m->steps; j++)
        system_derivative(system, t + (1 - j) * h, y[n + 1 - j], f[j]);
    for (int i = 0; i < 2; i++) {
        double off = 0;
        if (m->values) {
            for (int j = 0; j <= m->steps; j++)
                off += m->values[j] * y[n + 1 - j][i];
            off -= h * f[0][i];
        } else {
            off = y[n + 1][i] - y[n][i];
            if (m->correct) {
                double predicted[2], at[2];
                for (int k = 0; k < 2; k++) {
                    predicted[k] = y[n][k];
                    for (int j = 0; j < m->steps; j++)
                        predicted[k] += h * m->predict[j] * f[1 + j][k];
                }
                system_derivative(system, t + h, predicted, at);
                off -= h * m->correct[0] * at[i];
                for (int j = 1; j < m->steps; j++)
                    off -= h * m->correct[j] * f[j][i];
            } else {
                for (int j = 0; j < m->steps; j++)
                    off -= h * m->predict[j] * f[1 + j][i];
            }
        }
        largest = fmax(largest, fabs(off));
    }
    return largest;
}

TEST(test_steps_solve_their_equation)
{
    struct system system = pushed_spring();
    EACH_ROW(method)
    {
        enum { N = 40 };
        const double h = 0.03125;
        double y[N + 1][2] = {{1, 0.3}}, now[2] = {1, 0.3};
        struct step step = step_begin(&system, DRAG_DEFAULT, 0.5, h, now, work[0]);
        for (int n = 0; n < N; n++) {
            assert_int_equal(method_step(method, &step), STEP_OK);
            memcpy(y[n + 1], now, sizeof now);
            if (n + 1 >= method->multistep->steps)
                assert_below(method->row.name,
                             equation_error(method->multistep, &system, 0.5 + n * h, h, y, n),
                             4e-15);
        }
    }
}

/* The first steps - 1 steps come from a method of higher order: their error is far below the
 * method's own. */
TEST(test_start_is_accurate)
{
    struct system system = SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}, {"y0", 1});
    EACH_ROW(method)
    {
        const int k = method->multistep->steps;
        double y[2] = {1, 0}, exact[2];
        if (k < 2)
            continue;
        assert_int_equal(advance(method, &system, 0.05, k - 1, y), STEP_OK);
        system_exact(&system, 0, system.start, (k - 1) * 0.05, exact, NULL);
        assert_below(method->row.name, hypot(y[0] - exact[0], y[1] - exact[1]), 1e-10);
    }
}

/* A step that is longer or shorter is taken alone, as the first one is; then the history begins
 * anew. */
TEST(test_changed_step_starts_again)
{
    struct system system = pushed_spring();
    EACH_ROW(method)
    {
        double a[2] = {1, 0.3}, b[2];
        struct step one = step_begin(&system, DRAG_DEFAULT, 0, 0.03125, a, work[0]);
        for (int i = 0; i < 10; i++)
            assert_int_equal(method_step(method, &one), STEP_OK);
        memcpy(b, a, sizeof b);
        struct step two = step_begin(&system, DRAG_DEFAULT, one.t, 0.0125, b, work[1]);
        one.h = 0.0125;
        for (int i = 0; i < 10; i++) {
            assert_int_equal(method_step(method, &one), STEP_OK);
            assert_int_equal(method_step(method, &two), STEP_OK);
            assert_memory_equal(a, b, sizeof a);
        }
    }
}

TEST(test_costs)
{
    struct system system = pushed_spring();
    EACH_ROW(method)
    {
        double y[2] = {1, 0.3}, z[2] = {1, 0.3};
        bool stiff = method->multistep->values;
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.03125, y, work[0]);
        struct step one = step_begin(&system, DRAG_DEFAULT, 0, 0.03125, z, work[1]);
        one.error = (double[2]){0}; /* the start looks at the estimate */
        assert_int_equal(method_step(method_named(stiff ? "radau5" : "dop853"), &one), STEP_OK);
        for (int i = 1; i < method->multistep->steps;
             i++) { /* the one-step method, and f of the history */
            int64_t before = step.cost.evals;
            assert_int_equal(method_step(method, &step), STEP_OK);
            assert_int_equal(step.cost.evals - before, one.cost.evals + !stiff);
        }
        for (int i = 0; i < 5; i++) {
            struct cost before = step.cost;
            assert_int_equal(method_step(method, &step), STEP_OK);
            assert_int_equal(step.cost.evals - before.evals, method->evals);
            assert_int_equal(step.cost.solves - before.solves, method->multistep->values != NULL);
        }
    }
}

/* y' = -1e6 (y - cos t) - sin t (Prothero, Robinson 1974), off the smooth solution at first. */
static void smooth_add(const double *c, double t, const double *y, double *a)
{
    a[0] += -c[0] * (y[0] - cos(t)) - sin(t);
}

static void smooth_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t, (void)y;
    jac[0] -= c[0];
}

static const struct term_row smooth_row = {.row = {"smooth", "1/s", "", "", NULL},
                                           .flags = TERM_TIME,
                                           .add = smooth_add,
                                           .jacobian = smooth_jacobian};

TEST(test_stiff_start)
{
    struct system system = other_system(&smooth_row, 1e6);
    system.n = system.order = 1;
    EACH_ROW(method)
    {
        if (!method->multistep->values)
            continue;
        double y = 2;
        assert_int_equal(advance(method, &system, 0.01, 200, &y), STEP_OK);
        assert_near(method->row.name, y, cos(2), 1e-8);
    }
}

/* Steps of h that succeed, at most `count`, with states below `bound` natural sizes. */
static int steps_taken(const struct method *method, const struct system *system, double h,
                       int count, double bound)
{
    double y[LIMIT_VARIABLES];
    enum drag drag = DRAG_DEFAULT;
    struct error error;
    if (!method_applies(method, system, &drag, &error))
        return 0;
    memcpy(y, system->start, (size_t)system->n * sizeof *y);
    struct step step = step_begin(system, drag, system->t0, h, y, work[0]);
    for (int i = 0; i < count; i++) {
        if (method_step(method, &step) != STEP_OK)
            return i;
        for (int k = 0; k < system->n; k++)
            if (!(fabs(y[k]) <= bound * system->scale[k]))
                return i;
    }
    return count;
}

#define SOUND 1e6 /* natural sizes; a companion that is beyond has not come as far */

/*
 * Every row takes the steps of its start wherever one-step methods of its kind, implicit or
 * explicit, come as far; in the stiff scenes of first order, which backward differentiation is for,
 * also its first own step, where its first order takes it.
 */
static int compare_starts(const char *scene, const struct system *system, double dt)
{
    static const char *const embedded_weights[2][2] = {{"rk4", "heun"}, {"bdf1", "trapezoid"}};
    int compared = 0;
    EACH_ROW(method)
    {
        const bool implicit = method->multistep->values;
        const int steps = method->multistep->steps, max = steps + 1;
        const int first =
            steps_taken(method_named(embedded_weights[implicit][0]), system, dt, max, SOUND);
        const int second =
            steps_taken(method_named(embedded_weights[implicit][1]), system, dt, max, SOUND);
        const int wanted = implicit && system->order == 1 && first == max ? steps
                           : first == max || second == max                ? steps - 1
                                                                          : 0;
        const int own = steps_taken(method, system, dt, wanted, HUGE_VAL);
        if (own < wanted)
            fail_msg("%s on %s with dt = %g s takes only %d steps", method->row.name, scene, dt,
                     own);
        compared += wanted > 0;
    }
    return compared;
}

TEST(test_starts_where_companions_do)
{
    int compared = 0;
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct preset *preset = preset_at(i);
        struct scene scene;
        struct system system;
        struct error error;
        scene_init(&scene, preset);
        assert_true(scene_bind(&scene, &system, &error));
        if (system.dry) /* its force jumps: runs step from branch to branch, never over the jump */
            continue;
        for (double dt = 1e-5; dt < (is_long() ? 20 : 2); dt *= !is_long() || dt < 4e-3 ? 10 : 2)
            compared += compare_starts(preset->row.name, &system, dt);
    }
    assert_true(compared > (is_long() ? 1000 : 250));
}

/* A failed step leaves all as it was; the next one starts again. */
TEST(test_failure_forgets)
{
    struct system system = pushed_spring(), broken = system;
    broken.term[0].c[0] = NAN;
    EACH_ROW(method)
    {
        double y[2] = {1, 0.3}, before[2];
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.03125, y, work[0]);
        for (int i = 0; i < 10; i++)
            assert_int_equal(method_step(method, &step), STEP_OK);
        memcpy(before, y, sizeof y);
        step.system = &broken;
        broken.oscillator.stiffness = broken.oscillator.damping = NAN;
        assert_int_not_equal(method_step(method, &step), STEP_OK);
        assert_memory_equal(y, before, sizeof y);
        assert_false(step.warm);
        step.system = &system;
        assert_int_equal(method_step(method, &step), STEP_OK);
    }
}

RUN_TESTS(NULL, NULL)
