/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Measured order of every method and drag variant on seven problems, against a reference that
 * shares no code with the library: RK4 in long double, 2^16 steps, on forces written out here.
 * |slope - claim| <= 0.05. Compensated sums lower rounding far enough for order 8.
 */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

#define LIMIT 0.05

typedef long double real;

struct problem {
    const char *name;
    struct system system;
    real (*acceleration)(real t, real q, real v);
    double t0, span, start[2];
    real wanted[2]; /* reference */
};

static real undamped_force(real t, real q, real v)
{
    (void)t, (void)v;
    return -1.5L * q;
}

static real damped_force(real t, real q, real v)
{
    (void)t;
    return -1.5L * q - 0.5L * v;
}

static real drag_force(real t, real q, real v)
{
    (void)t;
    return -1.5L * q - 0.25L * v - 0.75L * fabsl(v) * v;
}

static real driven_force(real t, real q, real v)
{
    return -1.5L * q - 0.5L * v - 0.25L + 0.75L * cosl(2 * t + 0.5L);
}

static real duffing_force(real t, real q, real v)
{
    (void)t, (void)v;
    return -q - 0.5L * q * q * q;
}

static real weak_duffing_force(real t, real q, real v)
{
    (void)t, (void)v;
    return -q - 0.02L * q * q * q;
}

static real pushed_force(real t, real q, real v)
{
    (void)v;
    return -sinl(q) + 0.25L * cosl(t);
}

/* q'' = -sin q + c cos t: nonlinear and dependent on time */
static void pushed_add(const double *c, double t, const double *y, double *a)
{
    a[0] += c[0] * cos(t) - sin(y[0]);
}

static void pushed_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t;
    jac[0] -= cos(y[0]);
}

static const struct term_row pushed_row = {.row = {"pushed", "m/s^2", "", "", NULL},
                                           .flags = TERM_TIME,
                                           .add = pushed_add,
                                           .jacobian = pushed_jacobian};

static void solve_reference(struct problem *problem)
{
    const int n = 1 << 16;
    real h = (real)problem->span / n, q = (real)problem->start[0], v = (real)problem->start[1];
    for (int i = 0; i < n; i++) {
        real t = (real)problem->t0 + i * h;
        real q1 = v, v1 = problem->acceleration(t, q, v);
        real q2 = v + h / 2 * v1, v2 = problem->acceleration(t + h / 2, q + h / 2 * q1, q2);
        real q3 = v + h / 2 * v2, v3 = problem->acceleration(t + h / 2, q + h / 2 * q2, q3);
        real q4 = v + h * v3, v4 = problem->acceleration(t + h, q + h * q3, q4);
        q += h / 6 * (q1 + 2 * q2 + 2 * q3 + q4);
        v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    }
    problem->wanted[0] = q;
    problem->wanted[1] = v;
}

enum { UNDAMPED, DAMPED, DRAG, DRIVEN, DUFFING, PUSHED, WEAK_DUFFING, PROBLEMS };

static struct problem problems[PROBLEMS];

/* clang-format off */
static int set_up(void **state)
{
    (void)state;
    /* C rho area / m = 0.75; it is only C^1 at v = 0, so that arc has no turning point. */
    problems[UNDAMPED] = (struct problem){"undamped", SPRING({"m", 1}, {"k", 1.5}), undamped_force,
                                          0, 3, {1, 0.5}, {0}};
    problems[DAMPED] = (struct problem){"damped", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}), damped_force,
                                        0, 3, {1, 0.5}, {0}};
    problems[DRAG] = (struct problem){
        "quadratic drag", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.25}, {"C", 0.75}, {"rho", 1}, {"area", 1}),
        drag_force, 0, 1.5, {1, -0.5}, {0}};
    problems[DRIVEN] = (struct problem){
        "driven", SPRING({"m", 1}, {"k", 1.5}, {"gamma", 0.5}, {"g", 0.25}, {"F0", 0.75}, {"omega", 2}, {"phase", 0.5}),
        driven_force, 0.5, 3, {1, 0.5}, {0}};
    problems[DUFFING] = (struct problem){"duffing", duffing(0.5), duffing_force, 0, 3, {1, 0.5}, {0}};
    problems[PUSHED] = (struct problem){"pushed pendulum", other_system(&pushed_row, 0.25), pushed_force,
                                        0.5, 3, {1, 0.5}, {0}};
    problems[WEAK_DUFFING] = (struct problem){"weak duffing", duffing(0.02), weak_duffing_force, 0, 4, {1, 0}, {0}};
    for (int p = 0; p < PROBLEMS; p++) {
        problems[p].system.scale[0] = problems[p].system.scale[1] = 1;
        solve_reference(&problems[p]);
    }
    return 0;
}
/* clang-format on */

/* With compensated sums, where the method has them. NAN: this many steps cannot be taken. */
static double error_of(const struct method *method, enum drag drag, const struct problem *problem,
                       long n)
{
    static double work[WORK_CAPACITY];
    double y[2] = {problem->start[0], problem->start[1]}, low[2] = {0, 0},
           h = problem->span / (double)n;
    struct error error = {0};
    if (!method_applies(method, &problem->system, &drag, &error) ||
        !method_fits(method, &problem->system, drag, h, &error))
        return NAN;
    struct step step = step_begin(&problem->system, drag, problem->t0, h, y, work);
    step.low = low;
    for (long i = 0; i < n; i++) {
        step.t = problem->t0 + (double)i * h;
        if (method_step(method, &step) != STEP_OK)
            return NAN;
    }
    return hypot((double)((real)y[0] + (real)low[0] - problem->wanted[0]),
                 (double)((real)y[1] + (real)low[1] - problem->wanted[1]));
}

/* An observed order, and how much it may still change: more than the limit where double has no
 * asymptotic range. */
struct slope {
    double value, unrest;
};

/*
 * From n, 2n and 4n steps, the finest whose error is still far above rounding: there the leading
 * term rules. The slope deviates in proportion to h, so that extrapolation takes the deviation out.
 */
static struct slope slope(const struct method *method, enum drag drag,
                          const struct problem *problem)
{
    enum { MOST = 16 };
    double error[MOST + 1] = {0};
    int fine = 0;
    for (int k = 0; k <= MOST; k++) {
        double n = (double)(1L << k);
        error[k] = error_of(method, drag, problem, 1L << k);
        if (error[k] < (method->flags & METHOD_IMPLICIT ? fmax(1e-13, 5e-15 * n) : 1e-13))
            break;
        fine = k;
    }
    if (fine < 3)
        return (struct slope){NAN, HUGE_VAL};
    double first = log2(error[fine - 3] / error[fine - 2]),
           coarse = log2(error[fine - 2] / error[fine - 1]);
    double next = log2(error[fine - 1] / error[fine]);
    return (struct slope){2 * next - coarse,
                          2 * fmax(fabs(next - coarse), fabs(coarse - first) / 2)};
}

struct verdict {
    int right, wrong;
};

/* Says every row that fails, not only the first. */
static void judge(const struct method *method, enum drag drag, const struct problem *problem,
                  int claim, struct verdict *verdict)
{
    struct slope got = slope(method, drag, problem);
    bool right = fabs(got.value - claim) <= LIMIT;
    /* On a linear problem the leading term may be so small that a higher one is seen. */
    bool open = isnan(got.value) || fabs(got.value - claim) <= LIMIT + got.unrest ||
                (problem->system.linear && got.value > claim);
    const char *state = right ? "" : open ? " open" : " wrong";
    if (getenv("VERBOSE"))
        print_message("%-22s %d %-16s %d %6.3f +- %.3f%s\n", method->row.name, drag, problem->name,
                      claim, got.value, got.unrest, state);
    if (!right && !open)
        print_error("%s drag %d on %s: order %.3f, want %d\n", method->row.name, drag,
                    problem->name, got.value, claim);
    verdict->right += right;
    verdict->wrong += !right && !open;
}

TEST(test_every_row)
{
    int wrong = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct verdict linear = {0, 0}, nonlinear = {0, 0};
        if (method->order == 0 || method->flags & METHOD_EXTERNAL)
            continue;
        for (int p = 0; p < PROBLEMS; p++)
            if (applies(method, &problems[p].system, DRAG_DEFAULT))
                judge(method, DRAG_DEFAULT, &problems[p], method->order,
                      problems[p].system.linear ? &linear : &nonlinear);
        /* of which double leaves no asymptotic range */
        bool shown = nonlinear.right > 0 || method->order > 8;
        if (!shown)
            print_error("%s: no nonlinear problem shows its order\n", method->row.name);
        wrong += linear.wrong + nonlinear.wrong + !shown;
    }
    assert_int_equal(wrong, 0);
}

/* Explicit drag makes a second-order splitting first order; exact and implicit do not. */
TEST(test_drag_variants)
{
    static const int with_drag[] = {DAMPED, DRAG, DRIVEN};
    struct verdict verdict = {0, 0};
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int variant = DRAG_EXACT; variant < DRAG_COUNT; variant++)
            for (size_t p = 0; p < COUNT_OF(with_drag); p++) {
                const struct method *method = method_at(m);
                const struct problem *problem = &problems[with_drag[p]];
                enum drag drag = (enum drag)variant;
                if (applies(method, &problem->system, drag))
                    judge(method, drag, problem, drag == DRAG_EXPLICIT ? 1 : method->order,
                          &verdict);
            }
    assert_int_equal(verdict.wrong, 0);
    assert_true(verdict.right >= 30);
}

/* Every row that is only for forces without velocity says so, and with what to go on. */
TEST(test_velocity_is_refused)
{
    int refused = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_NO_VELOCITY))
            continue;
        refused++;
        enum drag drag = DRAG_DEFAULT;
        struct error error = {0};
        assert_false(method_applies(method, &problems[DAMPED].system, &drag, &error));
        assert_non_null(strstr(error.text, method->row.name));
        assert_non_null(strstr(error.text, "velocity"));
        assert_true(error.hint[0] != '\0');
        assert_true(applies(method, &problems[DUFFING].system, DRAG_DEFAULT));
        assert_true(applies(method, &problems[PUSHED].system, DRAG_DEFAULT));
    }
    assert_true(refused >= 3);
}

TEST(test_exact_has_no_error)
{
    const struct method *exact = method_named("exact");
    for (int p = 0; p < PROBLEMS; p++) {
        if (!applies(exact, &problems[p].system, DRAG_DEFAULT))
            continue;
        assert_int_equal(exact->order, 0);
        assert_below(problems[p].name, error_of(exact, DRAG_DEFAULT, &problems[p], 1), 1e-15);
        assert_below(problems[p].name, error_of(exact, DRAG_DEFAULT, &problems[p], 100), 2e-14);
    }
}

/* Through a turning point quadratic drag is only C^1: high order is lost there, which is why the
 * arc above has none. */
TEST(test_order_is_lost_at_turning_points)
{
    struct problem swing = problems[DRAG];
    swing.span = 3.7;
    solve_reference(&swing);
    struct slope got = slope(method_named("dopri5"), DRAG_DEFAULT, &swing);
    if (fabs(got.value - 5) <= LIMIT)
        fail_msg("order %.3f through a turning point", got.value);
}

RUN_TESTS(set_up, NULL)
