/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps: the same numbers in lanes and alone, in shards and whole, whatever the number of threads;
 * what is measured. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include "long_form.h"
#include "unit/cpu_time.h"
#include "modules/sweep/compute/sweep.h"
#include "modules/solving/testing.h"

#include <string.h>

static struct sweep_axis axis_of(const struct scene *scene, const char *name, double from,
                                 double to, int count)
{
    struct sweep_axis axis = {.begin = from, .end = to, .count = count};
    assert_true(sweep_axis_find(scene, text_of(name), &axis));
    return axis;
}

/* Measures separated by blanks. */
static struct sweep_request request_of(const struct scene *scene, const char *method, double dt,
                                       double duration, const char *measures)
{
    struct sweep_request request = {.scene = scene,
                                    .method = method_named(method),
                                    .settings = {.dt = dt, .kernel = KERNEL_SPECIALISED},
                                    .duration = duration,
                                    .shard = 1,
                                    .shards = 1};
    struct text rest = text_of(measures), name;
    struct error error = {0};
    while (text_split(&rest, ' ', &name))
        if (request.measures == SWEEP_MEASURES ||
            !sweep_measure_find(scene->model, name, &request.measure[request.measures++], &error))
            fail_msg("%s", error.text);
    return request;
}

static struct sweep sweep_of(const struct sweep_request *request)
{
    struct sweep sweep;
    struct error error = {0};
    if (!study_sweep(request, &sweep, &error))
        fail_msg("%s", error.text);
    return sweep;
}

static void assert_same(const struct sweep *a, const struct sweep *b, int64_t first,
                        const char *what)
{
    for (int64_t i = 0; i < b->count; i++) {
        const int64_t k = i + b->first - first;
        if (a->status[k] != b->status[i])
            fail_msg("%s, point %lld: status %d and %d", what, (long long)k, a->status[k],
                     b->status[i]);
        for (int m = 0; m < a->measures; m++)
            if (memcmp(&a->value[k * a->measures + m], &b->value[i * b->measures + m],
                       sizeof(double)) != 0)
                fail_msg("%s, point %lld, measure %d: %.17g and %.17g", what, (long long)k, m,
                         a->value[k * a->measures + m], b->value[i * b->measures + m]);
    }
}

/* ---- lanes are the same numbers: every method that has them, every kind of oscillator, with and
 * without a rest ---- */

TEST(test_lanes_equal_runs)
{
    static const struct {
        const char *preset, *axis;
        double from, to;
    } cases[] = {{"spring", "k", 2, 40},
                 {"damped", "gamma", 0, 3},
                 {"drag", "C", 0, 4},
                 {"driven", "omega", 6, 12},
                 /* angles of one quarter, of several, of all of pi's digits, below 0 */
                 {"driven", "omega", 8, 8.001},
                 {"driven", "omega", 0, 1e6},
                 {"driven", "phase", -3, 3},
                 {"driven", "gamma", 0.1, 1},
                 {"duffing", "y0", 0.1, 3},
                 {"duffing-driven", "F0", 0, 1},
                 {"vanderpol", "mu", -0.5, 3},
                 {"pendulum", "theta0", 0.1, 3},
                 {"spring", "y0", -0.1, 0.1},
                 {"spring", "v0", -0.5, 0.5},
                 {"overdamped", "m", 0.1, 3},
                 {"pendulum-driven", "F0", 0.3, 2},
                 {"pendulum-driven", "omega", 0.3, 2},
                 /* each point has its own times, from here on */
                 {"driven", "dt", 0.005, 0.03},
                 {"driven", "t0", -2, 3},
                 {"drag", "dt", 0.005, 0.03},
                 {"damped", "dt", 0.005, 0.03},
                 {"duffing-driven", "dt", 0.005, 0.03},
                 {"pendulum", "dt", 0.3, 0.003},
                 {"vanderpol", "t0", -2, 3}};
    const size_t clocks = COUNT_OF(cases) - 7;
    int64_t side_by_side = 0;
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        for (size_t m = 0; m < method_catalog.count; m++)
            for (int rest = 0; rest < 2; rest++) {
                const struct method *method = method_at(m);
                if (!method->tableau && !method->splitting &&
                    !(method->implicit && method->order < 3))
                    continue;
                if (c >= clocks && !is_long() && (c + m) % 4 != 0)
                    continue;
                const struct scene scene = scene_with(cases[c].preset, NO_SETTINGS);
                struct sweep_request request =
                    request_of(&scene, method->row.name, 0.01, rest ? 4.0037 : 4,
                               "amplitude period mean max min steps evals reached y v energy");
                request.axis[0] =
                    axis_of(&scene, cases[c].axis, cases[c].from, cases[c].to,
                            scene.model == &oscillator_model ? 5 : 21); /* fewer go alone */
                request.axes = 1;
                struct sweep lanes, alone;
                struct error error = {0};
                const bool ok = study_sweep(&request, &lanes, &error);
                request.settings.kernel = KERNEL_GENERAL; /* never in lanes */
                assert_int_equal(study_sweep(&request, &alone, &error), ok);
                assert_int_equal(alone.side_by_side, 0);
                assert_same(&lanes, &alone, 0, method->row.name);
                side_by_side += lanes.side_by_side;
                sweep_free(&lanes);
                sweep_free(&alone);
            }
    print_message("# %lld points went in lanes\n", (long long)side_by_side);
    assert_true(side_by_side > 1500);
}

/* Points with adaptive steps that are computed in lanes, each with its own step, have the same bits
 * as points that are computed alone, for all measures. A fourth of the scenes (c % 4 == 1) also has
 * an absolute tolerance. Case 10 (inverted) runs longer than the others. */
TEST(test_adaptive_lanes_equal_runs)
{
    static const struct {
        const char *preset, *axis;
        double from, to;
    } cases[] = {{"spring", "k", 2, 40},
                 {"damped", "gamma", 0, 3},
                 {"drag", "C", 0, 4},
                 {"driven", "omega", 6, 12},
                 {"driven", "gamma", 0.1, 1},
                 {"duffing", "y0", 0.1, 3},
                 {"duffing-driven", "F0", 0, 1},
                 {"vanderpol", "mu", -0.5, 30},
                 {"pendulum", "theta0", 0.1, 3},
                 {"overdamped", "m", 0.1, 3},
                 {"inverted", "k", -15, 15},
                 {"pendulum-driven", "omega", 0.3, 2},
                 {"duffing-driven", "tol", 1e-9, 1e-5},
                 {"duffing-driven", "dt", 1e-3, 1e-1}};
    static const char *const methods[] = {"dopri5", "bogacki-shampine", "tsit5",
                                          "dop853", "rodas5p",          "rodas4"};
    int64_t side_by_side = 0;
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        for (size_t m = 0; m < COUNT_OF(methods); m++) {
            struct scene scene = scene_with(cases[c].preset, NO_SETTINGS);
            if (c % 4 == 1)
                scene_set_atol(&scene, 0, 1e-7);
            struct sweep_request request =
                request_of(&scene, methods[m], 0.01, c == 10 ? 40 : 4,
                           "amplitude period mean max min steps evals reached y v energy");
            request.settings.tol = m % 2 ? 1e-5 : 1e-7;
            request.axis[0] = axis_of(&scene, cases[c].axis, cases[c].from, cases[c].to, 70);
            request.axes = 1;
            struct sweep lanes = sweep_of(&request);
            request.settings.kernel = KERNEL_GENERAL; /* never in lanes */
            struct sweep alone = sweep_of(&request);
            assert_int_equal(alone.side_by_side, 0);
            assert_same(&lanes, &alone, 0, methods[m]);
            side_by_side += lanes.side_by_side;
            sweep_free(&lanes);
            sweep_free(&alone);
        }
    print_message("# %lld points went in lanes\n", (long long)side_by_side);
    assert_true(side_by_side > 2000);
}

/* What needs the whole run is measured of runs that are given the steps of the lanes. */
TEST(test_replays_equal_runs)
{
    static const struct {
        const char *preset, *axis, *measures;
        double from, to;
    } cases[] = {
        {"driven", "omega", "error energy_error max(v) min(energy) mean(v) y evals steps", 6, 12},
        {"damped", "gamma", "error energy_error work phase-error period(v) mean evals", 0, 3},
        {"drag", "C", "energy_error dissipated amplitude(v) max(power) max evals", 0, 4},
        {"duffing-driven", "F0", "max(v) amplitude(a) mean(kinetic) energy-error period", 0, 1},
        {"pendulum", "theta0", "energy_error max(v) period(v) energy", 0.1, 3},
        {"inverted", "k", "energy_error max(v) reached steps", -1500, 15},
        {"driven", "dt", "error energy_error max(v) y evals steps", 0.005, 0.03},
        {"damped", "t0", "error energy_error mean(v)", -2, 3}};
    static const char *const methods[] = {"rk4", "verlet", "symplectic-euler", "dopri5",
                                          "implicit-midpoint"};
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        for (size_t m = 0; m < 2 * COUNT_OF(methods); m++) {
            const struct scene scene = scene_with(cases[c].preset, NO_SETTINGS);
            struct sweep_request request =
                request_of(&scene, methods[m / 2], 0.01, m % 2 ? 4.0037 : 4, cases[c].measures);
            request.axis[0] = axis_of(&scene, cases[c].axis, cases[c].from, cases[c].to, 21);
            request.axes = 1;
            struct sweep lanes = sweep_of(&request);
            request.settings.kernel = KERNEL_GENERAL;
            struct sweep alone = sweep_of(&request);
            assert_int_equal(alone.side_by_side, 0);
            assert_true(lanes.side_by_side > 0);
            assert_same(&lanes, &alone, 0, cases[c].preset);
            sweep_free(&lanes);
            sweep_free(&alone);
        }
}

/* Runs that are longer than what is kept of them are given it piece by piece. */
TEST(test_long_replays_equal_runs)
{
    static const struct {
        const char *axis;
        double from, to;
    } cases[] = {{"gamma", 0.1, 1}, {"omega", 6, 12}, {"dt", 1e-3, 7e-4}, {"k", -150, 15}};
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        for (int rest = 0; rest < 2; rest++) {
            const struct scene scene = scene_with(c == 3 ? "inverted" : "driven", NO_SETTINGS);
            struct sweep_request request =
                request_of(&scene, rest ? "verlet" : "rk4", 1e-3, rest ? 16.3844 : 16.384,
                           c == 3 ? "energy_error work energy steps reached"
                                  : "energy_error work energy steps evals reached");
            request.axis[0] = axis_of(&scene, cases[c].axis, cases[c].from, cases[c].to, 7);
            request.axes = 1;
            struct sweep lanes = sweep_of(&request);
            assert_true(lanes.side_by_side > (c == 3 ? 0 : 3)); /* others diverge */
            request.settings.kernel = KERNEL_GENERAL;
            struct sweep alone = sweep_of(&request);
            assert_same(&lanes, &alone, 0, cases[c].axis);
            sweep_free(&lanes);
            sweep_free(&alone);
        }
}

/* Lanes lie along the axis that leaves the times as they are, or along both kinds of times. */
TEST(test_two_clocks)
{
    static const char *const axes[][2] = {
        {"dt", "gamma"}, {"gamma", "dt"}, {"dt", "t0"}, {"t0", "omega"}, {"t0", "dt"}};
    for (size_t c = 0; c < COUNT_OF(axes); c++) {
        const struct scene scene = scene_with("driven", NO_SETTINGS);
        struct sweep_request request =
            request_of(&scene, "rk4", 0.01, 3.0037, "amplitude period mean max steps y");
        for (int a = 0; a < 2; a++) {
            const bool step = axes[c][a][0] == 'd';
            request.axis[a] = axis_of(&scene, axes[c][a], step ? 0.003 : 0.1, step ? 0.05 : 2, 9);
            request.axis[a].log = step;
        }
        request.axes = 2;
        struct sweep lanes = sweep_of(&request);
        assert_int_equal(lanes.side_by_side, 81);
        request.settings.kernel = KERNEL_GENERAL;
        struct sweep alone = sweep_of(&request);
        assert_same(&lanes, &alone, 0, axes[c][0]);
        sweep_free(&alone);
        request.settings.kernel = KERNEL_SPECIALISED;
        for (request.shard = 1, request.shards = 3; request.shard <= 3; request.shard++) {
            struct sweep part = sweep_of(&request);
            assert_same(&lanes, &part, 0, axes[c][1]);
            sweep_free(&part);
        }
        sweep_free(&lanes);
    }
}

/* Steps that are known before are those that are taken. */
TEST(test_predicted_steps)
{
    const struct scene scene = scene_with("driven", NO_SETTINGS);
    struct sweep_request request = request_of(&scene, "rk4", 0.01, 5, "y");
    for (int log = 0; log < 2; log++) {
        request.axis[0] = axis_of(&scene, "dt", 1e-4, 0.1, 40);
        request.axis[0].log = log;
        request.axis[1] = axis_of(&scene, "gamma", 0.1, 1, 3);
        request.axes = 2;
        double steps, seconds;
        study_sweep_predict(&request, &steps, &seconds);
        struct sweep sweep = sweep_of(&request);
        assert_true(fabs(steps / sweep.steps - 1) < 0.01 && seconds > 0);
        sweep_free(&sweep);
    }
}

/* ---- what diverges is a result ---- */

TEST(test_divergence)
{
    const struct scene scene = scene_with("inverted", NO_SETTINGS);
    struct sweep_request request = request_of(&scene, "rk4", 0.01, 60, "y steps reached amplitude");
    request.axis[0] = axis_of(&scene, "k", -15, 15, 101);
    request.axes = 1;
    struct sweep lanes = sweep_of(&request);
    request.settings.kernel = KERNEL_GENERAL;
    struct sweep alone = sweep_of(&request);
    assert_same(&lanes, &alone, 0, "inverted");
    assert_int_equal(lanes.status[0], STOP_DIVERGED);
    assert_true(isnan(lanes.value[0]));
    assert_true(lanes.value[1] > 1000 && lanes.value[1] < 6000);
    close_to(lanes.value[2], lanes.value[1] * 0.01, 1e-9);
    assert_int_equal(lanes.status[100], STOP_END);
    assert_true(lanes.failed > 5 && lanes.failed < 95);
    assert_true(lanes.side_by_side > 5);
    assert_int_equal(lanes.finished, 101);
    sweep_free(&lanes);
    sweep_free(&alone);
}

/* ---- shards, threads ---- */

/* Any stretch, along either axis, and what a stopped sweep had finished: the same bits. */
TEST(test_stretches)
{
    const struct scene scene = scene_with("driven", NO_SETTINGS);
    static const char *const methods[] = {"verlet", "dopri5"}; /* in lanes, alone */
    for (size_t m = 0; m < COUNT_OF(methods); m++) {
        struct sweep_request request = request_of(&scene, methods[m], 0.01, 2, "amplitude y");
        request.axis[0] = axis_of(&scene, "gamma", 0, 1, 150);
        request.axis[1] = axis_of(&scene, "omega", 6, 12, 13);
        request.axes = 2;
        struct sweep whole = sweep_of(&request), stretch;
        static const int64_t part[][2] = {{0, 1},     {1949, 1},   {5, 8},      {12, 2},
                                          {100, 900}, {640, 1310}, {1000, 950}, {0, 1950}};
        for (size_t p = 0; p < COUNT_OF(part); p++) {
            request.first = part[p][0];
            request.count = part[p][1];
            stretch = sweep_of(&request);
            assert_int_equal(stretch.first, part[p][0]);
            assert_int_equal(stretch.finished, part[p][1]);
            assert_same(&whole, &stretch, 0, "stretch");
            sweep_free(&stretch);
        }
        assert_true(study_sweep_batch(&request) > 0);
        request.first = request.count = 0;
        struct sweep before = sweep_of(&request);
        for (int64_t i = 0; i < before.count; i += 1 + i % 7) {
            before.status[i] = SWEEP_MISSING;
            before.value[2 * i] = before.value[2 * i + 1] = NAN;
        }
        request.previous = &before;
        stretch = sweep_of(&request);
        assert_same(&whole, &stretch, 0, "goes on");
        assert_true(stretch.steps > 0 && stretch.steps < 0.9 * whole.steps);
        sweep_free(&stretch);
        sweep_free(&before);
        sweep_free(&whole);
    }
}

/* ---- the measures ---- */

/* Amplitude of the forced motion: F0/m / hypot(omega0^2 - omega^2, gamma omega). */
TEST(test_resonance)
{
    const struct scene scene = scene_with("driven", SETTINGS({"gamma", 1}));
    struct sweep_request request = request_of(&scene, "rk4", 0.01, 60, "amplitude period");
    request.axis[0] = axis_of(&scene, "omega", 5, 12, 71);
    request.axes = 1;
    struct sweep sweep = sweep_of(&request);
    assert_int_equal(sweep.side_by_side, 71);
    for (int i = 0; i < 71; i++) {
        const double omega = sweep_axis_value(&request.axis[0], i);
        const double wanted = 0.1 / hypot(75 - omega * omega, omega);
        close_to(sweep.value[2 * i], wanted, 2e-5 * wanted);
        close_to(sweep.value[2 * i + 1], 6.283185307179586 / omega, 2e-5);
    }
    sweep_free(&sweep);
}

/* Period of a pendulum: 2 pi sqrt(l/g) / agm(1, cos(theta0/2)); with large steps of an adaptive
 * method, too. */
TEST(test_pendulum_period)
{
    const struct scene scene = scene_with("pendulum", NO_SETTINGS);
    const double g = scene.value[scene_param(&scene, "g")],
                 l = scene.value[scene_param(&scene, "length")];
    for (int adaptive = 0; adaptive < 2; adaptive++) {
        struct sweep_request request =
            request_of(&scene, adaptive ? "dopri5" : "rk4", 0.01, 60, "period amplitude");
        request.settings.tol = adaptive ? 1e-8 : 0;
        request.axis[0] = axis_of(&scene, "theta0", 0.1, 3, 10);
        request.axes = 1;
        struct sweep sweep = sweep_of(&request);
        for (int i = 0; i < 10; i++) {
            const double theta = sweep_axis_value(&request.axis[0], i);
            double a = 1, b = cos(theta / 2);
            for (int k = 0; k < 8; k++) {
                const double mean = (a + b) / 2;
                b = sqrt(a * b);
                a = mean;
            }
            const double wanted = 6.283185307179586 * sqrt(l / g) / a;
            close_to(sweep.value[2 * i], wanted, (adaptive ? 2e-3 : 1e-5) * wanted);
            close_to(sweep.value[2 * i + 1], theta, (adaptive ? 1e-3 : 1e-5) * theta);
        }
        sweep_free(&sweep);
    }
}

/* The same as a run says of itself. */
TEST(test_against_a_run)
{
    const struct scene scene = scene_with("damped", NO_SETTINGS);
    struct sweep_request request = request_of(
        &scene, "verlet", 0.01, 7, "error energy_error y energy steps evals phase-error work");
    request.axis[0] = axis_of(&scene, "gamma", 0.25, 1, 2);
    request.axes = 1;
    struct sweep sweep = sweep_of(&request);
    struct error error = {0};
    const struct run_settings settings = {.dt = 0.01, .kernel = KERNEL_SPECIALISED};
    struct run *run = run_create(&scene, method_named("verlet"), &settings, 7, &error);
    const struct run_target target = {.t = 7, .steps = -1};
    while (run_advance(run, &target, 0, NULL)) {
    }
    struct run_errors errors;
    struct ledger ledger;
    run_errors(run, &errors);
    run_ledger(run, &ledger);
    const double wanted[] = {errors.max,   ledger.error_max,   run->y[0],
                             ledger.final, (double)run->steps, (double)run->cost.evals,
                             errors.phase, ledger.work};
    for (size_t m = 0; m < COUNT_OF(wanted); m++)
        close_to(sweep.value[m], wanted[m], 1e-14);
    run_destroy(run);
    sweep_free(&sweep);
}

/* Sweeps of what is not a plain parameter: dt (10, 1 and 0.1 thousand steps in 10 s, errors of rk4
 * falling with dt^4), T0, which sets k, and tol. */
TEST(test_other_axes)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    struct sweep_request request = request_of(&scene, "rk4", 0.01, 10, "error steps");
    request.axis[0] = axis_of(&scene, "dt", 0.001, 0.1, 3);
    request.axis[0].log = true;
    request.axes = 1;
    struct sweep sweep = sweep_of(&request);
    close_to(sweep.value[1], 10000, 0);
    close_to(sweep.value[3], 1000, 0);
    close_to(sweep.value[5], 100, 0);
    close_to(log10(sweep.value[4] / sweep.value[2]), 4, 0.1);
    sweep_free(&sweep);
    request.axis[0] = axis_of(&scene, "T0", 1, 2, 2);
    request.duration = 20;
    request.measures = 0;
    struct error error = {0};
    assert_true(sweep_measure_find(scene.model, TEXT("period"),
                                   &request.measure[request.measures++], &error));
    sweep = sweep_of(&request);
    close_to(sweep.value[0], 1, 1e-5);
    close_to(sweep.value[1], 2, 1e-5);
    sweep_free(&sweep);
    request.method = method_named("dopri5");
    request.settings.tol = 1e-6;
    request.axis[0] = axis_of(&scene, "tol", 1e-9, 1e-5, 2);
    assert_true(sweep_measure_find(scene.model, TEXT("steps"), &request.measure[0], &error));
    sweep = sweep_of(&request);
    assert_true(sweep.value[0] > 2 * sweep.value[1]);
    sweep_free(&sweep);
}

/* ---- columns ---- */

TEST(test_columns)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    struct sweep_request request =
        request_of(&scene, "rk4", 0.002, 20,
                   "max(v) min(v) amplitude(v) period(v) min max(y) min(y) mean(potential) "
                   "amplitude(kinetic) max(kinetic) min(kinetic) period(potential)");
    request.axis[0] = axis_of(&scene, "k", 5, 20, 2);
    request.axes = 1;
    struct sweep sweep = sweep_of(&request);
    for (int i = 0; i < 2; i++) {
        const double k = i ? 20 : 5, omega = sqrt(k / 0.2), y = 0.05, v = y * omega,
                     e = k * y * y / 2;
        const double wanted[] = {v,     -v, v, 2 * M_PI / omega, -y, y, -y, e / 2,
                                 e / 2, e,  0, M_PI / omega};
        for (size_t m = 0; m < COUNT_OF(wanted); m++)
            close_to(sweep.value[(size_t)i * COUNT_OF(wanted) + m], wanted[m],
                     m == 7    ? 0.1 * e /* not whole periods */
                     : m == 10 ? 1e-4 * e
                               : 1e-4 * fabs(wanted[m]));
    }
    assert_int_equal(sweep.side_by_side, 0);
    sweep_free(&sweep);
    /* The means of a decay are known: of y over the last third. */
    struct scene drifting = scene_with("spring", NO_SETTINGS);
    struct error error = {0};
    assert_true(
        scene_set(&drifting, scene_param(&drifting, "k"), (struct measured){1e-9, 0}, &error));
    assert_true(
        scene_set(&drifting, scene_param(&drifting, "v0"), (struct measured){0.3, 0}, &error));
    request = request_of(&drifting, "rk4", 0.01, 3, "mean mean(y) mean(v) max(y) amplitude");
    request.axis[0] = axis_of(&drifting, "m", 1, 2, 2);
    request.axes = 1;
    sweep = sweep_of(&request);
    const double wanted[] = {0.05 + 0.3 * 2.5, 0.05 + 0.3 * 2.5, 0.3, 0.05 + 0.3 * 3, 0.15};
    /* the window opens at a step */
    for (size_t m = 0; m < COUNT_OF(wanted); m++)
        close_to(sweep.value[m], wanted[m], 1e-2 * 0.3);
    sweep_free(&sweep);
}

/* ---- refusals, cancelling ---- */

static struct cancel stop;

static void stop_after_a_while(void *context, double fraction)
{
    assert_true(fraction >= 0 && fraction <= 1);
    if (context && !stop.requested)
        *(double *)context = fraction;
    atomic_store(&stop.requested, 1);
}

TEST(test_cancelling)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    struct sweep_request request = request_of(&scene, "rk4", 1e-4, 10, "y");
    struct sweep sweep;
    struct error error = {0};
    request.axis[0] = axis_of(&scene, "k", 1, 20, 1000000);
    request.axes = 1;
    request.cancel = &stop;
    request.progress = stop_after_a_while;
    const int64_t begin = cpu_ns();
    assert_false(study_sweep(&request, &sweep, &error));
    assert_true(cpu_ns() - begin < 20000000000);
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_true(sweep.finished < sweep.count);
    for (int64_t i = 0, there = 0; i < sweep.count; i++) {
        assert_int_equal(isnan(sweep.value[i]), sweep.status[i] == SWEEP_MISSING);
        there += sweep.status[i] == STOP_END;
        if (i == sweep.count - 1)
            assert_int_equal(there, sweep.finished);
    }
    /* Gone on with, how far it is says nothing of what was there before. */
    struct sweep rest;
    double first = NAN;
    memset(sweep.status, STOP_END, 900000);
    request.previous = &sweep;
    request.context = &first;
    atomic_store(&stop.requested, 0);
    assert_false(study_sweep(&request, &rest, &error));
    assert_true(rest.finished >= 900000 && rest.finished < rest.count);
    assert_true(first >= 0 && first < 0.5);
    sweep_free(&rest);
    sweep_free(&sweep);
}

RUN_TESTS(NULL, NULL)
