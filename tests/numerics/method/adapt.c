/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Step-size control and dense output: accuracy follows the tolerance, nothing is lost when a step
 * fails. */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

struct advance {
    double y[2], work[WORK_CAPACITY];
    struct step step;
    struct controller controller;
    int64_t accepted;
};

static void advance_begin(struct advance *advance, const struct system *system, double t,
                          double tol)
{
    *advance =
        (struct advance){.y = {system->start[0], system->start[1]}, .controller = {.tol = tol}};
    advance->step = step_begin(system, DRAG_DEFAULT, t, 0, advance->y, advance->work);
}

static enum step_status travel(struct advance *advance, const struct method *method, double t_end)
{
    while (advance->step.t != t_end) {
        enum step_status status = method_adapt(method, &advance->step, &advance->controller, t_end);
        if (status != STEP_OK)
            return status;
        assert_true(++advance->accepted < 10000000);
    }
    return STEP_OK;
}

static struct advance shared;

/* Largest distance from the exact solution at the end of each of `segments` equal parts. */
static double advance_error(const struct method *method, const struct system *system, double tol,
                            double t_end, int legs)
{
    double largest = 0;
    advance_begin(&shared, system, system->t0, tol);
    for (int i = 1; i <= legs; i++) {
        double exact[2], t = i == legs ? t_end : system->t0 + (t_end - system->t0) * i / legs;
        assert_int_equal(travel(&shared, method, t), STEP_OK);
        system_exact(system, system->t0, system->start, t, exact, NULL);
        largest = fmax(largest, distance(system, shared.y, exact));
    }
    return largest;
}

enum {
    /* 1e-4 … 1e-10, but not where rounding adds up over more steps than that */
    TOLERANCES = 7,
    STEPS = 100000
};

/* log error = slope log tol + constant, up to a factor of scatter; ratio: error/tol midway */
struct line {
    double slope, scatter, ratio;
};

static struct line fit_line(const double *error, const double *tol, int count)
{
    double x = 0, y = 0, xx = 0, xy = 0, max = 0;
    for (int i = 0; i < count; i++) {
        x += log(tol[i]) / count;
        y += log(error[i]) / count;
    }
    for (int i = 0; i < count; i++) {
        xx += (log(tol[i]) - x) * (log(tol[i]) - x);
        xy += (log(tol[i]) - x) * (log(error[i]) - y);
    }
    for (int i = 0; i < count; i++)
        max = fmax(max, fabs(log(error[i]) - y - xy / xx * (log(tol[i]) - x)));
    return (struct line){xy / xx, exp(max), exp(y - x)};
}

/*
 * The error is proportional to the tolerance, with little scatter, and at most ten times it for
 * every method. On this linear scene some are of an order more than they claim, which lifts the
 * slope by up to a fifth.
 */
TEST(test_error_follows_tolerance)
{
    struct system system = SPRING({NULL, 0});
    int wrong = 0;
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_ADAPTIVE))
            continue;
        double tol[TOLERANCES], error[TOLERANCES], max = 0;
        bool bad = false;
        int count = 0;
        for (int i = 0; i < TOLERANCES && (i == 0 || shared.accepted < STEPS); i++, count++) {
            tol[i] = pow(10, -4 - i);
            error[i] = advance_error(method, &system, tol[i], 10, 1);
            max = fmax(max, error[i] / tol[i]);
            bad = bad || (double)shared.step.cost.rejected > 2 + 0.02 * (double)shared.accepted;
        }
        struct line line = fit_line(error, tol, count);
        bad = bad || count < 4 || max > 10 || line.slope < 0.9 || line.slope > 1.2 ||
              line.scatter > 2;
        if (bad || getenv("VERBOSE"))
            print_message("%-18s slope %.3f, scatter %.2f, error/tol %.3g, at most %.3g%s\n",
                          method->row.name, line.slope, line.scatter, line.ratio, max,
                          bad ? ": wrong" : "");
        wrong += bad;
    }
    assert_int_equal(wrong, 0);
}

/* The error of a harmonic oscillation is the same in every step: once it is right, h stays as it
 * is, bit for bit. */
TEST(test_steps_settle)
{
    struct system system = SPRING({NULL, 0});
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_ADAPTIVE) || !method->tableau)
            continue;
        double settled = 0;
        int steps = 0;
        advance_begin(&shared, &system, 0, 1e-7);
        for (; steps < 60; steps++) {
            assert_int_equal(method_adapt(method, &shared.step, &shared.controller, 100), STEP_OK);
            if (steps == 20)
                settled = shared.step.h;
            if (steps > 20)
                assert_near(method->row.name, shared.step.h, settled, 0);
        }
    }
}

/* The tolerance is relative: the same problem in other units takes the same steps, bit for bit. */
TEST(test_tolerance_has_no_unit)
{
    struct system metre = SPRING({"y0", 0.05}, {"gamma", 0.2}),
                  small = SPRING({"y0", ldexp(0.05, -40)}, {"gamma", 0.2});
    const struct method *dopri5 = method_named("dopri5");
    advance_begin(&shared, &metre, 0, 1e-7);
    assert_int_equal(travel(&shared, dopri5, 10), STEP_OK);
    double y = shared.y[0], v = shared.y[1];
    int64_t evals = shared.step.cost.evals;
    advance_begin(&shared, &small, 0, 1e-7);
    assert_int_equal(travel(&shared, dopri5, 10), STEP_OK);
    assert_true(shared.y[0] == ldexp(y, -40) && shared.y[1] == ldexp(v, -40));
    assert_int_equal(shared.step.cost.evals, evals);
}

/* Sizes that were guessed too small, even by 1e12, cost a few steps at first; peaks do not stay. */
TEST(test_sizes_follow_the_solution)
{
    struct system known = SPRING({"y0", 0.05}), small = known;
    for (int i = 0; i < 2; i++)
        small.scale[i] *= 1e-12;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_ADAPTIVE))
            continue;
        const double tol = method->order < 4 ? 1e-4 : 1e-8;
        /* a library's own control */
        if (method->begin)
            continue;
        advance_begin(&shared, &known, 0, tol);
        assert_int_equal(travel(&shared, method, 20), STEP_OK);
        const double evals = (double)shared.step.cost.evals;
        for (int i = 0; i < 2; i++)
            assert_near("as it was", shared.controller.scale[i], known.scale[i],
                        1e-3 * known.scale[i]);
        advance_begin(&shared, &small, 0, tol);
        assert_int_equal(travel(&shared, method, 20), STEP_OK);
        assert_below(method->row.name, (double)shared.step.cost.evals, 1.6 * evals);
        for (int i = 0; i < 2; i++)
            assert_near(method->row.name, shared.controller.scale[i] / known.scale[i], 0.546, 0.03);
        assert_null(shared.step.scale); /* nothing is left for steps of fixed size */
    }
}

TEST(test_costs_are_counted)
{
    struct system system = SPRING({"F0", 0.3}, {"omega", 40}, {"gamma", 2});
    advance_begin(&shared, &system, 0, 1e-8);
    shared.controller.h = 1; /* far too long: must be rejected first */
    assert_int_equal(travel(&shared, method_named("dopri5"), 3), STEP_OK);
    struct cost cost = shared.step.cost;
    assert_true(cost.rejected > 0);
    /* Six for each attempt, one more for the first: what was known at the start of a rejected step
     * still holds. */
    assert_int_equal(cost.evals, 6 * (shared.accepted + cost.rejected) + 1);
}

TEST(test_end_is_met_exactly)
{
    struct system system = SPRING({"gamma", 0.2});
    const struct method *dopri5 = method_named("dopri5");
    advance_begin(&shared, &system, 0, 1e-6);
    assert_int_equal(travel(&shared, dopri5, 1.0 / 3), STEP_OK);
    assert_true(shared.step.t == 1.0 / 3);
    double planned = shared.controller.h;
    assert_above("natural step", planned, 0.01);
    /* A tiny segment neither shortens the plan nor confuses the error history. */
    assert_int_equal(method_adapt(dopri5, &shared.step, &shared.controller, 1.0 / 3 + 1e-9),
                     STEP_OK);
    assert_true(shared.step.t == 1.0 / 3 + 1e-9);
    assert_true(shared.controller.h == planned);
    int64_t rejected = shared.step.cost.rejected;
    assert_int_equal(method_adapt(dopri5, &shared.step, &shared.controller, 10), STEP_OK);
    assert_near("next step", shared.step.h, planned, 0);
    assert_int_equal(shared.step.cost.rejected, rejected);
    /* Nothing to do at the end. */
    struct cost cost = shared.step.cost;
    assert_int_equal(method_adapt(dopri5, &shared.step, &shared.controller, shared.step.t),
                     STEP_OK);
    assert_int_equal(shared.step.cost.evals, cost.evals);
}

/* t + (t_end - t) is often not t_end. */
TEST(test_end_is_met_in_spite_of_rounding)
{
    struct system system = SPRING({NULL, 0});
    for (int i = 1; i < 100; i++) {
        double t_end = 0.3 / i;
        advance_begin(&shared, &system, -0.1 / i, 1);
        shared.controller.h = 10;
        assert_int_equal(
            method_adapt(method_named("dopri5"), &shared.step, &shared.controller, t_end), STEP_OK);
        assert_true(shared.step.t == t_end);
    }
}

TEST(test_backwards)
{
    struct system system = SPRING({"gamma", 0.2});
    const struct method *dopri5 = method_named("dopri5");
    assert_below("from 0 to -5", advance_error(dopri5, &system, 1e-9, -5, 1), 1e-6);
    advance_begin(&shared, &system, 0, 1e-10);
    assert_int_equal(travel(&shared, dopri5, 5), STEP_OK);
    /* turns round with the same controller */
    assert_int_equal(travel(&shared, dopri5, 0), STEP_OK);
    assert_below("there and back", distance(&system, shared.y, system.start), 1e-7);
}

/* Adaptive steps start from a state of zeros, where no size of the variables is known: with a drive
 * they reach the tolerance, without one the body stays exactly at rest, in few steps. */
TEST(test_starts_at_rest)
{
    const struct method *dopri5 = method_named("dopri5");
    struct system driven = SPRING({"y0", 0}, {"F0", 0.02}, {"omega", 8.2}, {"gamma", 0.3});
    assert_below("driven from rest", advance_error(dopri5, &driven, 1e-8, 10, 7), 1e-6);
    struct system nothing = SPRING({"y0", 0});
    advance_begin(&shared, &nothing, 0, 1e-6);
    assert_int_equal(travel(&shared, dopri5, 10), STEP_OK);
    assert_true(shared.y[0] == 0 && shared.y[1] == 0);
    assert_below("steps of nothing", (double)shared.accepted, 50);
}

TEST(test_tolerance_zero_is_clamped)
{
    struct system system = SPRING({NULL, 0});
    assert_below("tol 0", advance_error(method_named("dopri5"), &system, 0, 1, 1), 1e-12);
}

/* Accelerations that are NaN beyond the wall at q = c. */
static void wall_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += y[0] > c[0] ? NAN : 1;
}
static const struct term_row wall_row = {.row = {"wall", "m/s^2", "", "", NULL}, .add = wall_add};

/* The motion before the wall is a parabola, which dopri5 follows without error: it would leap at
 * the wall again. */
TEST(test_no_growth_after_a_rejection)
{
    struct system system = other_system(&wall_row, 1);
    system.start[1] = 1;
    advance_begin(&shared, &system, 0, 1e-6);
    shared.controller.h = 0.8;
    assert_int_equal(method_adapt(method_named("dopri5"), &shared.step, &shared.controller, 100),
                     STEP_OK);
    assert_int_equal(shared.step.cost.rejected, 1);
    assert_near("step", shared.step.h, 0.2, 0);
    assert_near("proposal", shared.controller.h, 0.2, 0);
    assert_int_equal(method_adapt(method_named("dopri5"), &shared.step, &shared.controller, 0.4),
                     STEP_OK);
    assert_above("then it grows again", shared.controller.h, 0.22);
}

TEST(test_nan_is_a_rejected_step)
{
    struct system system = other_system(&wall_row, 1);
    system.start[1] = 1;
    advance_begin(&shared, &system, 0, 1e-6);
    shared.controller.h = 0.5;
    const struct method *dopri5 = method_named("dopri5");
    enum step_status status = STEP_OK;
    double y[2] = {0}, t = 0;
    int64_t rejected = 0;
    while (status == STEP_OK && shared.step.t < 5) {
        memcpy(y, shared.y, sizeof y);
        t = shared.step.t;
        rejected = shared.step.cost.rejected;
        status = method_adapt(dopri5, &shared.step, &shared.controller, 5);
    }
    assert_int_equal(status, STEP_NONFINITE);
    assert_memory_equal(y, shared.y, sizeof y);
    assert_true(shared.step.t == t);
    assert_in_range(shared.step.cost.rejected - rejected, 1, 21);
    assert_near("stops at the wall", y[0], 1, 1e-9); /* q = t + t^2/2 = 1 at t = sqrt(3) - 1 */
    assert_near("stops at the wall", t, sqrt(3) - 1, 1e-9);
}

/* No step is small enough for a force that is noise. */
static void noise_add(const double *c, double t, const double *y, double *a)
{
    (void)y;
    a[0] += c[0] * sin(1e17 * t);
}
static const struct term_row noise_row = {
    .row = {"noise", "m/s^2", "", "", NULL}, .flags = TERM_TIME, .add = noise_add};

TEST(test_stall)
{
    struct system system = other_system(&noise_row, 1e20);
    advance_begin(&shared, &system, 1, 1e-6);
    enum step_status status = travel(&shared, method_named("dopri5"), 2);
    assert_int_equal(status, STEP_STALLED);
    assert_true(shared.step.t < 2 && isfinite(shared.y[0]) && isfinite(shared.y[1]));
}

/* A rejected step leaves nothing behind: the same path as with the step size that was accepted, bit
 * for bit. */
TEST(test_rejection_leaves_no_trace)
{
    struct system system = SPRING({NULL, 0});
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_ADAPTIVE) || !(method->tableau || method->nystrom))
            continue;
        double low[2] = {1e-20, -1e-19}, direct_low[2] = {1e-20, -1e-19};
        advance_begin(&shared, &system, 0, 1e-6);
        shared.step.low = low;
        shared.controller.h = 3;
        assert_int_equal(method_adapt(method, &shared.step, &shared.controller, 100), STEP_OK);
        assert_true(shared.step.cost.rejected > 0);
        double h = shared.step.h, y[2] = {shared.y[0], shared.y[1]};
        advance_begin(&shared, &system, 0, 1e-6);
        shared.step.low = direct_low;
        shared.step.h = h;
        assert_int_equal(method_step(method, &shared.step), STEP_OK);
        assert_memory_equal(y, shared.y, sizeof y);
        assert_memory_equal(low, direct_low, sizeof low);
    }
}

/* ---- turning points (what they do for the order: run_kinks.c) ---- */

/* Deceleration 1, not defined between two velocities: a step across may be, one of its pieces not.
 */
static void hole_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += y[1] > c[0] && y[1] < c[1] ? NAN : -1;
}
static const struct term_row hole_row = {
    .row = {"hole", "m/s^2", "", "", NULL}, .flags = TERM_VELOCITY | TERM_KINK, .add = hole_add};

TEST(test_a_piece_that_fails_leaves_nothing)
{
    static const struct {
        bool kinks;
        double from, to;
        enum step_status status;
    } cases[] = {{false, -0.2, 0.2, STEP_OK},
                 {true, -0.2, 0.2, STEP_NONFINITE},   /* at the end of the first piece */
                 {true, -0.3, -0.2, STEP_NONFINITE}}; /* in the middle of the second */
    const struct method *rk4 = method_named("rk4");
    const double start[2] = {0.3, 1}, low[2] = {1e-20, -1e-19};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct system system = other_system(&hole_row, cases[i].from);
        double after[2] = {low[0], low[1]};
        system.term[0].c[1] = cases[i].to;
        memcpy(system.start, start, sizeof start);
        system.kinks = cases[i].kinks;
        advance_begin(&shared, &system, 5, 0);
        shared.step.low = after;
        shared.step.h = 1.5;
        assert_int_equal(method_turns(rk4, &system), cases[i].kinks);
        assert_int_equal(method_turning_step(rk4, &shared.step), cases[i].status);
        assert_true(shared.step.h == 1.5);
        if (cases[i].status == STEP_OK)
            continue;
        assert_memory_equal(shared.y, start, sizeof start);
        assert_memory_equal(after, low, sizeof low);
        assert_true(shared.step.t == 5);
    }
}

/* An accepted step ends where the velocity is 0, or has its sign throughout; the proposal stays. */
TEST(test_steps_end_at_turning_points)
{
    struct system system = SPRING({"C", 3});
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_ADAPTIVE) || !method_turns(method, &system))
            continue;
        int turns = 0;
        advance_begin(&shared, &system, 0, 1e-9);
        while (shared.step.t < 5) {
            const double before = shared.y[1], tiny = 2e-5 * system.scale[1],
                         planned = shared.controller.h;
            const int64_t rejected = shared.step.cost.rejected;
            assert_int_equal(method_adapt(method, &shared.step, &shared.controller, 5), STEP_OK);
            const bool turned = fabs(shared.y[1]) < tiny && fabs(before) > tiny;
            turns += turned;
            if (turned && shared.step.cost.rejected == rejected)
                assert_true(planned == 0 || shared.controller.h >= planned);
            if (fabs(before) > tiny && fabs(shared.y[1]) > tiny && before * shared.y[1] < 0)
                fail_msg("%s goes across a turning point at t = %g", method->row.name,
                         shared.step.t);
        }
        assert_in_range(turns, 13, 14); /* half a period is 0.363 s */
    }
}

/* ---- dense output ---- */

/* Largest error inside one step of h from the start. */
static double dense_error(const struct method *method, const struct system *system, double h)
{
    static double work[WORK_CAPACITY];
    double y[2] = {system->start[0], system->start[1]}, largest = 0;
    enum drag drag = DRAG_DEFAULT;
    struct error error;
    assert_true(method_applies(method, system, &drag, &error));
    struct step step = step_begin(system, drag, system->t0, h, y, work);
    assert_int_equal(method_step(method, &step), STEP_OK);
    for (double theta = 0.05; theta < 1; theta += 0.1) {
        double inside[2], exact[2];
        method_dense(method, &step, system->start, theta, inside);
        system_exact(system, system->t0, system->start, system->t0 + theta * h, exact, NULL);
        largest = fmax(largest, distance(system, inside, exact));
    }
    return largest;
}

/*
 * Local order: h^p for own interpolants of methods above order 4 (not collocation, whose three
 * stages give h^4), all others h^4, never better than the step, h^(p+1).
 */
TEST(test_dense_orders)
{
    const struct system systems[] = {SPRING({"gamma", 2}, {"v0", 0.3}, {"F0", 0.2}, {"omega", 5}),
                                     SPRING({"v0", 0.3}, {"F0", 0.2}, {"omega", 5}),
                                     SPRING({"v0", 0.3})};
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        const struct system system = first_fit(method, systems, 3);
        const int p = method->order;
        /* it remembers more than the state, so that the first step says nothing of the others */
        if (method->growth)
            continue;
        int want = p > 4 && method->dense && !method->implicit ? p : p == 0 || p > 3 ? 4 : p + 1;
        double h = want > 5 ? 2e-2 : 1e-3; /* an error far above rounding */
        double coarse = dense_error(method, &system, 4 * h),
               middle = dense_error(method, &system, 2 * h);
        double fine = dense_error(method, &system, h);
        assert_near(method->row.name, 2 * log2(middle / fine) - log2(coarse / middle), want, 0.1);
    }
}

TEST(test_dense_meets_both_ends)
{
    static double work[WORK_CAPACITY];
    const struct system systems[] = {SPRING({"gamma", 2}, {"v0", 0.3}), SPRING({"v0", 0.3})};
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        const struct system system = first_fit(method, systems, 2);
        for (int sign = -1; sign <= 1; sign += 2) {
            double y[2] = {system.start[0], system.start[1]}, at[2];
            enum drag drag = DRAG_DEFAULT;
            struct error error;
            assert_true(method_applies(method, &system, &drag, &error));
            struct step step = step_begin(&system, drag, 0, sign * 0.05, y, work);
            assert_int_equal(method_step(method, &step), STEP_OK);
            method_dense(method, &step, system.start, 0, at);
            assert_below(method->row.name, distance(&system, at, system.start), 1e-15);
            method_dense(method, &step, system.start, 1, at);
            assert_below(method->row.name, distance(&system, at, y), 1e-15);
        }
    }
}

RUN_TESTS(NULL, NULL)
