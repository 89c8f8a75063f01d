/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dry friction in runs: against closed forms, by every method, with what sticks and breaks away. */
#include "unit/run/fixture.h"

#include <hooke/method.h>
#include <hooke/scene/typed.h>

/*
 * Free swings with friction f = F/m from rest at A > 0: half a period is pi/omega, each takes 2
 * f/omega^2 off the amplitude, and where it ends within f/omega^2 of the middle the body stays.
 */
static void closed_form(double omega, double f, double A, double t, double *y)
{
    const double half = 3.14159265358979323846 / omega, shift = f / (omega * omega);
    double side = 1;
    while (t > half && A > shift) {
        t -= half;
        A -= 2 * shift;
        side = -side;
    }
    const double swing = A > shift ? A - shift : 0;
    y[0] = side * (A > shift ? shift + swing * cos(omega * t) : A);
    y[1] = -side * swing * omega * sin(omega * t);
}

static struct scene rubbing(double friction)
{
    struct scene scene = spring();
    set(&scene, "friction", friction);
    return scene;
}

static double largest_error(const struct run *run, double friction)
{
    double largest = 0, y[2];
    const double m = 0.2, k = 15;
    for (size_t i = 0; i < trace_count(run->trace); i++) {
        closed_form(sqrt(k / m), friction / m, 0.05, trace_time(run->trace, i), y);
        largest = fmax(largest, fabs(trace_state(run->trace, i)[0] - y[0]));
    }
    return largest / 0.05;
}

#define FRICTION 0.02 /* [N]: 19 half periods, then at rest at y = 2/3 mm */
#define REST (0.05 / 75)

static struct run *rub(const struct method *method, double dt, double tol)
{
    const struct scene scene = rubbing(FRICTION);
    const struct run_settings settings = {.dt = dt, .tol = tol};
    struct error error = {0};
    struct run *run = run_create(&scene, method, &settings, 9, &error);
    if (!run)
        fail_msg("%s: %s", method->row.name, error.text);
    go_to(run, 9);
    assert_int_equal(run->stop, STOP_END);
    return run;
}

#define EACH_METHOD(method)                                                                        \
    (size_t i = 0; i < method_catalog.count;                                                       \
     i++) for (const struct method *method = (const void *)catalog_row(&method_catalog, i);        \
               method; method = NULL)

/* Fixed steps keep their order through 19 turning points and into rest, where the velocity is
 * exactly 0. */
TEST(test_every_method_keeps_its_order)
{
    for
        EACH_METHOD(method)
        {
            if (method->flags & METHOD_EXTERNAL)
                continue;
            double error[2];
            for (int half = 0; half < 2; half++) {
                struct run *run = rub(method, half ? 0.00125 : 0.0025, 0);
                error[half] = largest_error(run, FRICTION);
                assert_true(run->y[1] == 0 || method->order == 1);
                if (method->order != 1 && run->cost.turns != 19)
                    fail_msg("%s: %d ends at turning points", method->row.name,
                             (int)run->cost.turns);
                run_destroy(run);
            }
            /* Order 1 gains or loses so much that it turns another number of times. */
            const double wanted = method->order == 1 ? 1.3 : pow(2, method->order - 0.4);
            if (error[1] > 1e-11 && error[0] / error[1] < wanted)
                fail_msg("%s: errors %.3g, %.3g fall by less than %.3g", method->row.name, error[0],
                         error[1], wanted);
        }
}

/* Adaptive methods pass 19 turning points and come to rest with errors below 30 tol of the initial
 * amplitude, 0.05 m, at an exact velocity of 0. */
TEST(test_adaptive_methods_keep_the_tolerance)
{
    for
        EACH_METHOD(method)
    for (double tol = 1e-5; method->flags & METHOD_ADAPTIVE && tol > 1e-8; tol /= 100) {
        if (method->flags & METHOD_EXTERNAL) /* steps over turning points by its own control */
            break;
        struct run *run = rub(method, 0.001, tol);
        const double error = largest_error(run, FRICTION);
        if (!(error < 30 * tol))
            fail_msg("%s: error %.3g at tol = %.3g", method->row.name, error, tol);
        assert_true(run->y[1] == 0);
        assert_close(run->y[0], REST, 30 * tol * 0.05);
        run_destroy(run);
    }
}

/* ---- closed form ---- */

static struct system bound(const struct scene *scene)
{
    struct system system;
    struct error error;
    assert_true(scene_bind(scene, &system, &error));
    return system;
}

/*
 * Against fine steps of another kind: swings, critical and strong damping, growth, no spring, two
 * of a kind of unstable ones, with weight; from rest and from a push. And back from there, unless
 * the body stuck.
 */
TEST(test_closed_form)
{
    static const struct {
        double k, gamma, g, friction, y0, v0;
    } cases[] = {
        {15, 0, 0, 0.02, 0.05, 0},
        {15, 0.25, 0, 0.01, 0.05, 0},
        {15, 0.25, 9.81, 0.01, -0.1, 0.3},
        {15, 30, 0, 0.05, 0.05, -2},
        {15, 17.3205080757, 0, 0.05, 0.05, -2},
        {15, -0.3, 0, 0.01, 0.05, 0},
        {15, -0.3, 0, 0.05, 0.02, 0},
        {0, 0, 0, 0.05, 0.05, 1},
        {0, 0.5, 0, 0.05, 0.05, -1},
        {-15, 0.2, 0, 0.05, 0.02, 0},
        {-15, 0.2, 0, 0.05, 0.02, -0.15},
        {15, 0, 0, 0.02, 1e-3, 0},
        {15, 0.1, 0, 0.3, 0.01, 0.4},
        {0, 0, 9.81, 0.05, 0, 1},
        {0, 0, 0.1, 0.05, 0, 1},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct scene scene = rubbing(cases[i].friction);
        set(&scene, "k", cases[i].k);
        set(&scene, "gamma", cases[i].gamma);
        set(&scene, "g", cases[i].g);
        set(&scene, "y0", cases[i].y0);
        set(&scene, "v0", cases[i].v0);
        const struct system system = bound(&scene);
        assert_true(system_has_exact(&system));
        struct run *run = start(&scene, "dop853", (struct run_settings){.dt = 0.002}, 2.5);
        double moved = -1;
        for (int step = 0; step < 25; step++) {
            double y[2], back[2], floor[2];
            go_to(run, 0.1 * (step + 1));
            system_exact(&system, 0, system.start, run->t, y, floor);
            const double size = fabs(run->y[0]) + fabs(run->y[1]) / 10 + 0.05;
            if (fabs(y[0] - run->y[0]) > 1e-12 * size || fabs(y[1] - run->y[1]) > 1e-11 * size)
                fail_msg("case %zu at %g s: %.17g %.17g, wanted %.17g %.17g", i, run->t, y[0], y[1],
                         run->y[0], run->y[1]);
            assert_true(floor[0] > 0 && floor[0] < 1e-12 * size);
            if (run->y[1] == 0)
                continue;
            moved = run->t;
            system_exact(&system, run->t, y, 0, back, NULL);
            /* Backwards damping is growth, and so is an unstable fall there and back. */
            const double rate = fabs(cases[i].gamma) + (cases[i].k < 0 ? 18 : 0),
                         lost = 1e-11 * exp(rate * run->t);
            if (fabs(back[0] - cases[i].y0) > lost || fabs(back[1] - cases[i].v0) > 10 * lost)
                fail_msg("case %zu back from %g s: %.17g %.17g", i, run->t, back[0], back[1]);
        }
        if (cases[i].v0 == 0 &&
            fabs(cases[i].k * cases[i].y0 + 0.2 * cases[i].g) <= cases[i].friction)
            assert_true(moved < 0); /* it was held from the beginning */
        run_destroy(run);
    }
}

/* Far ahead in one step: 1e5 half swings by the formula are those by steps of one half swing each.
 */
TEST(test_closed_form_far_ahead)
{
    struct scene scene = rubbing(3e-6);
    set(&scene, "gamma", 1e-6);
    const struct system system = bound(&scene);
    double y[2] = {system.start[0], 0}, far[2];
    const double half = 3.14159265358979323846 / sqrt(75 - 0.25e-12);
    for (int i = 0; i < 100000; i++) {
        double next[2];
        system_exact(&system, 0, y, half, next, NULL);
        y[0] = next[0];
        y[1] = 0;
    }
    system_exact(&system, 0, system.start, 100000 * half, far, NULL);
    assert_close(far[0], y[0], 1e-11);
    /* and it sticks where it should: A_n = 0.05 - 2 n f without damping */
    struct scene plain = rubbing(FRICTION);
    const struct system rubs = bound(&plain);
    system_exact(&rubs, 0, rubs.start, 1e9, far, NULL);
    assert_close(far[0], REST, 1e-17);
    assert_true(far[1] == 0);
}

/* ---- sticking and breaking away under a drive ---- */

/*
 * Held until k y0 + F0 cos(omega t + phase) exceeds the friction: a force that grows from 0 breaks
 * the body away when it should, by steps of every size and kind.
 */
TEST(test_breaks_away_on_time)
{
    static const char *const names[] = {"rk4",  "verlet", "dopri5", "radau5",
                                        "bdf3", "exact",  "gauss4", "newmark"};
    struct scene scene = rubbing(0.1);
    set(&scene, "y0", 0);
    set(&scene, "F0", 0.2);
    set(&scene, "omega", 1);
    set(&scene, "phase", -1.57079632679489662);
    const double leaves = asin(0.5); /* 0.2 sin t = 0.1 */
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (int adaptive = 0; adaptive < 2; adaptive++) {
            if (adaptive && !(method_named(names[i])->flags & METHOD_ADAPTIVE))
                continue;
            struct run *run = start(
                &scene, names[i], (struct run_settings){.dt = 0.01, .tol = adaptive ? 1e-8 : 0}, 3);
            go_to(run, leaves - 1e-3);
            assert_true(run->y[0] == 0 && run->y[1] == 0);
            assert_true(run_rest(run) == 0);
            /* then m q'' = 0.2 cos(leaves) s: q = 0.2 cos(leaves) s^3 / (6 m) */
            go_to(run, leaves + 1e-3);
            const double wanted = 0.2 * cos(leaves) * 1e-9 / (6 * 0.2);
            assert_true(run->y[1] > 0 && isnan(run_rest(run)));
            if (method_named(names[i])->order != 2)
                assert_close(run->y[0], wanted, 0.02 * wanted);
            run_destroy(run);
        }
}

/* Stick-slip: the same motion by methods of different kinds, which stop and start again many times.
 */
TEST(test_stick_slip)
{
    struct scene scene = rubbing(0.15);
    set(&scene, "y0", 0);
    set(&scene, "F0", 0.2);
    set(&scene, "omega", 2.5);
    static const struct {
        const char *name;
        double dt, tol, off;
    } by[] = {{"dop853", 0.01, 0, 0},    {"dop853", 0.01, 1e-10, 1e-8},
              {"exact", 0.01, 0, 1e-11}, {"radau5", 0.01, 1e-8, 1e-6},
              {"rk4", 0.005, 0, 1e-6},   {"verlet", 0.001, 0, 1e-3},
              {"ab5", 0.002, 0, 1e-5}};
    double wanted[40];
    for (size_t i = 0; i < COUNT_OF(by); i++) {
        struct run *run =
            start(&scene, by[i].name, (struct run_settings){.dt = by[i].dt, .tol = by[i].tol}, 20);
        int rests = 0;
        for (int k = 0; k < 40; k++) {
            go_to(run, 0.5 * (k + 1));
            rests += run->y[1] == 0;
            if (i == 0)
                wanted[k] = run->y[0];
            else
                assert_close(run->y[0], wanted[k], by[i].off * 0.02);
        }
        assert_true(rests > 5 && rests < 35);
        run_destroy(run);
    }
}

/* ---- energy ---- */

/* What friction takes is force times path, whatever the steps; nothing is left over. */
TEST(test_energy_balance)
{
    for (int drives = 0; drives < 2; drives++)
        for
            EACH_METHOD(method)
            {
                /* avf is for forces with a potential, and a drive has none */
                if (method->flags & METHOD_EXTERNAL || method->order == 1 ||
                    (drives && method->flags & METHOD_POTENTIAL))
                    continue;
                struct scene scene = rubbing(0.02);
                set(&scene, "F0", drives ? 0.05 : 0);
                struct run *run =
                    start(&scene, method->row.name, (struct run_settings){.dt = 0.0025}, 6);
                struct ledger ledger;
                go_to(run, 6);
                run_ledger(run, &ledger);
                const double max = method->order == 0 || method->order > 5 ? 1e-9
                                   : method->order == 5                    ? 1e-6
                                   : method->order < 4                     ? 5e-3
                                                                           : 1e-4;
                if (!(ledger.error_max < max))
                    fail_msg("%s: the balance is off by %.3g", method->row.name, ledger.error_max);
                if (!drives && method->order == 4)
                    assert_close(ledger.initial - ledger.final,
                                 0.5 * 15 * (0.05 * 0.05 - run->y[0] * run->y[0]) -
                                     0.5 * 0.2 * run->y[1] * run->y[1],
                                 1e-12);
                run_destroy(run);
            }
}

/* ---- rows between steps, kernels and slices ---- */

TEST(test_rows_inside_of_steps)
{
    static const char *const names[] = {"rk4", "dop853", "dopri5", "verlet"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (int adaptive = 0; adaptive < 2; adaptive++) {
            const struct method *method = method_named(names[i]);
            if (adaptive && !(method->flags & METHOD_ADAPTIVE))
                continue;
            const struct scene scene = rubbing(FRICTION);
            struct run_settings settings = {.dt = 0.002, .tol = adaptive ? 1e-9 : 0};
            settings.record = (struct recording_rule){RECORD_TIMES, 1, 0.0007};
            struct run *run = start(&scene, names[i], settings, 8);
            go_to(run, 8);
            assert_true(largest_error(run, FRICTION) < (method->order == 2 ? 1e-3 : 1e-6));
            run_destroy(run);
        }
}

TEST(test_kernels_give_the_same_bits)
{
    for
        EACH_METHOD(method)
        {
            if (method->flags & METHOD_EXTERNAL)
                continue;
            struct scene scene = rubbing(0.03);
            set(&scene, "gamma", method->flags & METHOD_NO_VELOCITY ? 0 : 0.1);
            struct run *run[2];
            for (int k = 0; k < 2; k++) {
                struct run_settings settings = {.dt = 0.003,
                                                .kernel = k ? KERNEL_GENERAL : KERNEL_SPECIALISED};
                run[k] = start(&scene, method->row.name, settings, 5);
                go_to(run[k], 5);
            }
            assert_same_trace(run[0], run[1]);
            run_destroy(run[0]);
            run_destroy(run[1]);
        }
}

/* The same law typed: sticking from rest, a release that grows from 0, grazing turning points. Not
 * by shaking. */
TEST(test_typed_friction_takes_few_steps)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    const struct typed_line lines[] = {
        {.kind = TYPED_VAR, .name = TEXT("x"), .value = 0},
        {.kind = TYPED_EQUATION,
         .name = TEXT("x"),
         .order = 2,
         .expr = TEXT("0.1*t-x-0.5*sign(x')")},
    };
    const struct model *model = typed_new(models, TEXT(""), &error);
    for (size_t i = 0; model && i < COUNT_OF(lines); i++)
        model = typed_add(models, model, &lines[i], &error);
    assert_non_null(model);
    struct scene scene;
    scene_init(&scene, typed_preset(model));
    struct run *run = start(&scene, "dopri5", (struct run_settings){.dt = 0.01, .tol = 1e-9}, 30);
    go_to(run, 5 - 1e-6);
    assert_close(run->y[0], 0, 1e-12);
    go_to(run, 10); /* x = 0.1 (s - sin s) from t = 5 on */
    assert_close(run->y[0], 0.1 * (5 - sin(5)), 1e-7);
    go_to(run, 30);
    assert_true(run->steps < 2000);
    run_destroy(run);
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
