/* SPDX-License-Identifier: GPL-3.0-or-later */
/* precision: sweeps, slopes and what flags them, failures, reading off costs, ties, predictions,
 * cancellation. */
#include "cmocka_testing.h"

#include <string.h>

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/solving/compute/solve.h"
#include "modules/comparison/compute/verify.h"

static const struct method *method_named(const char *name)
{
    const struct row *row = catalog_find(&method_catalog, text_of(name));
    assert_non_null(row);
    return method_from(row);
}

static struct precision_request request_for(struct scene *scene, const struct method_choice *choice,
                                            int count)
{
    return (struct precision_request){.scene = scene,
                                      .choice = choice,
                                      .choices = count,
                                      .dt = {NAN, NAN},
                                      .tol = {NAN, NAN},
                                      .duration = 2};
}

static void run_study(const struct precision_request *request, struct precision *precision)
{
    struct error error = {0};
    if (!study_precision(request, precision, &error)) {
        print_error("%s\n", error.text);
        fail();
    }
}

static void near(double value, double wanted, double relative)
{
    if (!(fabs(value - wanted) <= relative * fabs(wanted))) {
        print_error("%.17g is not %.17g within %g\n", value, wanted, relative);
        fail();
    }
}

TEST(test_slopes_and_a_wrong_claim)
{
    struct scene scene;
    struct precision precision;
    struct method liar = *method_named("rk4");
    liar.order = 5; /* the negative control */
    const struct method_choice choice[] = {{method_named("symplectic-euler"), DRAG_DEFAULT},
                                           {method_named("verlet"), DRAG_DEFAULT},
                                           {method_named("rk4"), DRAG_DEFAULT},
                                           {&liar, DRAG_DEFAULT},
                                           {method_named("dopri5"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    const struct precision_request request = request_for(&scene, choice, 5);
    run_study(&request, &precision);
    assert_int_equal(precision.curves, 5);
    static const double order[] = {1, 2, 4, 4};
    for (int c = 0; c < 4; c++) {
        const struct precision_curve *curve = &precision.curve[c];
        assert_true(curve->fitted >= 3 && curve->r2 > 0.999);
        assert_true(fabs(curve->slope - order[c]) < 0.1);
        assert_int_equal(curve->differs, c == 3);
    }
    const struct precision_curve *adaptive = &precision.curve[4];
    assert_true(adaptive->adaptive && adaptive->fitted >= 5);
    assert_true(fabs(adaptive->slope - 1) < 0.2 && !adaptive->differs);
    /* The three regimes of rk4: nothing said, slope, floor. */
    const struct precision_point *point = &precision.point[precision.curve[2].first];
    const int last = precision.curve[2].count - 1;
    assert_false(precision_meaningful(&point[0]));
    assert_true(precision_meaningful(&point[1]));
    assert_true(point[last].errors.max < 1e-12);
    assert_false(point[last].asymptotic);
    for (int i = 0; i <= last; i++) {
        assert_true(point[i].errors.end <= point[i].errors.max || !isfinite(point[i].errors.max));
        assert_true(isnan(point[i].time.minimum)); /* TIMING_OFF */
        assert_int_equal(point[i].cost.evals, 4 * point[i].steps);
    }
    precision_free(&precision);
}

TEST(test_ranges_meet_the_grid)
{
    struct scene scene;
    struct precision precision;
    const struct method_choice choice[] = {{method_named("dopri5"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 1);
    request.dt[0] = 1e-3;
    request.dt[1] = 20e-3;
    run_study(&request, &precision);
    /* 2 s / 128, 256, 512, 1024: with dt given the method takes fixed steps */
    assert_int_equal(precision.points, 4);
    assert_true(precision.point[0].dt == 2.0 / 128 && precision.point[3].dt == 2.0 / 1024);
    assert_int_equal(precision.point[3].steps, 1024);
    precision_free(&precision);

    request.dt[0] = request.dt[1] = 5e-3;
    run_study(&request, &precision);
    assert_int_equal(precision.points, 1);
    assert_true(precision.point[0].dt == 2.0 / 512);
    precision_free(&precision);

    request.dt[0] = request.dt[1] = NAN;
    request.tol[0] = 1e-8;
    request.tol[1] = 1e-5;
    run_study(&request, &precision);
    assert_int_equal(precision.points, 4);
    near(precision.point[0].tol, 1e-5, 1e-12);
    near(precision.point[3].tol, 1e-8, 1e-12);
    precision_free(&precision);

    struct error error = {0};
    request.tol[0] = -1;
    assert_false(study_precision(&request, &precision, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    precision_free(&precision);
}

/* Errors, phase and amplitude of symplectic Euler and Verlet are known in closed form. */
TEST(test_known_errors)
{
    struct scene scene;
    struct precision precision;
    const struct method_choice choice[] = {{method_named("verlet"), DRAG_DEFAULT},
                                           {method_named("heun"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 2);
    request.dt[0] = request.dt[1] = 2.0 / 256;
    run_study(&request, &precision);
    const double omega = sqrt(75), x = omega * 2 / 256;
    const struct study_errors *verlet = &precision.point[0].errors,
                              *heun = &precision.point[1].errors;
    /* y = cos(n theta): numerical minus exact phase */
    const double turn = 256 * (2 * asin(x / 2) - x);
    double max = 0;
    for (int n = 0; n <= 256; n++)
        max = fmax(max, fabs(cos(2 * n * asin(x / 2)) - cos(n * x)));
    /* Scaled by the largest |y| on the grid, which is the start. */
    near(verlet->max, max, 1e-9);
    near(verlet->energy, 0.25 * x * x, 0.05); /* v^2 + omega^2 q^2 (1 - x^2/4) is what it keeps */
    assert_true(fabs(verlet->phase - turn) < x * x / 8);
    near(heun->amplitude, pow(1 + x * x * x * x / 4, 128) - 1, 1e-6);
    near(heun->phase, 256 * (atan2(x, 1 - x * x / 2) - x), 1e-6);
    precision_free(&precision);
}

TEST(test_failures_are_results)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    const struct method_choice choice[] = {{method_named("euler"), DRAG_DEFAULT},
                                           {method_named("rk4"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    /* omega = 8660 */
    assert_true(scene_set(&scene, scene_param(&scene, "k"), (struct measured){1.5e7, 0}, &error));
    struct precision_request request = request_for(&scene, choice, 2);
    request.dt[0] = request.dt[1] = 2.0 / 256;
    run_study(&request, &precision);
    assert_int_equal(precision.points, 2);
    for (int i = 0; i < 2; i++) {
        struct precision_cost cost;
        assert_int_equal(precision.point[i].stop, STOP_DIVERGED);
        assert_false(precision_meaningful(&precision.point[i]));
        assert_true(isnan(precision.curve[i].slope));
        assert_false(precision_cost_at(&precision, i, 0.1, &cost));
    }
    struct precision_cost costs[2];
    assert_int_equal(precision_fastest(&precision, 0.1, costs, NULL), 0);
    precision_free(&precision);

    /* Of the steps too coarse to say anything a sweep keeps the last. */
    assert_true(scene_set(&scene, scene_param(&scene, "k"), (struct measured){15, 0}, &error));
    request = request_for(&scene, choice, 2);
    run_study(&request, &precision);
    for (int c = 0; c < precision.curves; c++) {
        assert_false(precision_meaningful(&precision.point[precision.curve[c].first]));
        assert_true(precision_meaningful(&precision.point[precision.curve[c].first + 1]));
    }
    precision_free(&precision);
}

/* Made-up points: costs are read between them, ties are overlapping intervals, what is below the
 * reference does not count. */
TEST(test_reading_costs)
{
    struct precision_point point[6] = {{0}};
    struct precision_curve curve[3] = {
        {{method_named("rk4"), DRAG_DEFAULT}, .first = 0, .count = 2},
        {{method_named("heun"), DRAG_DEFAULT}, .first = 2, .count = 2},
        {{method_named("euler"), DRAG_DEFAULT}, .first = 4, .count = 2}};
    static const double error[] = {1e-2, 1e-4, 1e-2, 1e-4, 1e-2, 1e-4},
                        minimum[] = {1, 100, 1.1, 110, 3, 300},
                        median[] = {1.3, 130, 1.2, 120, 4, 400};
    for (int i = 0; i < 6; i++) {
        point[i].curve = i / 2;
        point[i].stop = STOP_END;
        point[i].errors.max = error[i];
        point[i].cost.evals = i % 2 ? 1000 : 10;
        point[i].time =
            (struct timing_result){.minimum = minimum[i], .median = median[i], .samples = 15};
    }
    const struct precision precision = {
        .reference = {.accuracy = 1e-9}, .point = point, .points = 6, .curve = curve, .curves = 3};
    struct precision_cost cost[3];
    assert_int_equal(precision_fastest(&precision, 1e-3, cost, NULL), 3);
    assert_int_equal(cost[0].curve, 0);
    near(cost[0].minimum, 10, 1e-12); /* half way in logarithms */
    near(cost[0].evals, 100, 1e-12);
    assert_int_equal(cost[1].curve, 1);
    assert_true(cost[1].tied);
    assert_int_equal(cost[2].curve, 2);
    assert_false(cost[2].tied);
    for (int i = 0; i < 6;
         i++) /* samples of one process that do not scatter: another one takes 5 % more or less */
        point[i].time.median = point[i].time.minimum = minimum[i % 2] * (i < 2   ? 1
                                                                         : i < 4 ? 1.04
                                                                                 : 1.06);
    assert_int_equal(precision_fastest(&precision, 1e-3, cost, NULL), 3);
    assert_true(cost[0].curve == 0 && cost[1].tied && !cost[2].tied);
    assert_int_equal(precision_fastest(&precision, 1e-5, cost, NULL), 0);
    struct precision coarse = precision;
    coarse.reference.accuracy = 1e-3;
    assert_int_equal(precision_fastest(&coarse, 1e-4, cost, NULL), 0);
    point[1].stop = STOP_DIVERGED;
    assert_int_equal(precision_fastest(&precision, 1e-3, cost, NULL), 2);
}

/* On the undamped oscillator the prediction is the measurement, to a few percent, over the whole
 * catalogue. */
TEST(test_predictions)
{
    struct scene scene;
    struct error error = {0};
    int compared = 0;
    scene_init(&scene, NULL);
    for (size_t i = 0; i < method_catalog.count; i++) {
        struct precision precision;
        const struct method_choice choice = {method_at(i), DRAG_DEFAULT};
        struct precision_request request = request_for(&scene, &choice, 1);
        request.duration = 10;
        request.dt[0] = 10.0 / 1024;
        request.dt[1] = 10.0 / 64;
        if (!study_precision(&request, &precision, &error)) {
            precision_free(&precision);
            continue;
        }
        for (int p = 0; p < precision.points; p++) {
            const struct precision_point *point = &precision.point[p];
            const double predicted = precision_predict(&precision, 0, point->errors.max);
            if (!precision_meaningful(point) || point->errors.max > 0.03 ||
                point->errors.max < 1e-11 || !isfinite(predicted) || point->cost.evals == 0)
                continue;
            const double steps = predicted / choice.method->evals;
            if (!(fabs(steps / (double)point->steps - 1) < 0.06)) {
                print_error("%s at dt = %g: error %g, %g steps predicted, %lld taken\n",
                            choice.method->row.name, point->dt, point->errors.max, steps,
                            (long long)point->steps);
                fail();
            }
            compared++;
        }
        precision_free(&precision);
    }
    assert_true(compared >= 10);
}

TEST(test_cancelled_keeps_what_is_finished)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    struct cancel cancel = {0};
    const struct method_choice choice[] = {{method_named("rk4"), DRAG_DEFAULT},
                                           {method_named("heun"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 2);
    request.cancel = &cancel;
    atomic_store(&cancel.requested, 1);
    assert_false(study_precision(&request, &precision, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_int_equal(precision.curves, 0);
    assert_int_equal(precision.points, 0);
    precision_free(&precision);
}

static struct cancel quitting;

static enum step_status quitting_step(const struct method *method, struct step *step)
{
    atomic_store(&quitting.requested, 1);
    return method_named("rk4")->step(method, step);
}

TEST(test_cancelled_in_the_second)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    struct method quitter = *method_named("rk4");
    quitter.step = quitting_step;
    const struct method_choice choice[] = {{method_named("rk4"), DRAG_DEFAULT},
                                           {&quitter, DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 2);
    request.cancel = &quitting;
    atomic_store(&quitting.requested, 0);
    assert_false(study_precision(&request, &precision, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_non_null(strstr(error.text, "1 of 2"));
    assert_int_equal(precision.curves, 1);
    assert_int_equal(precision.points, precision.curve[0].count);
    assert_true(fabs(precision.curve[0].slope - 4) < 0.1);
    precision_free(&precision);
}

TEST(test_refused_before_anything_runs)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    const struct method_choice choice[] = {{method_named("rk4"), DRAG_DEFAULT},
                                           {method_named("exact"), DRAG_DEFAULT}};
    const struct row *drag = catalog_find(&preset_catalog, TEXT("drag"));
    assert_non_null(drag);
    scene_init(&scene, (const struct preset *)(const void *)drag);
    const struct precision_request request = request_for(&scene, choice, 2);
    assert_false(study_precision(&request, &precision, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_non_null(strstr(error.text, "exact"));
    assert_int_equal(precision.curves, 0);
    precision_free(&precision);
}

static void count_absent(void *context, const char *method, const char *reason)
{
    assert_non_null(method);
    assert_true(reason[0] != '\0');
    (*(int *)context)++;
}

/* Every preset gets methods that apply, each once. */
TEST(test_defaults)
{
    for (size_t i = 0; i < preset_catalog.count; i++) {
        struct scene scene;
        struct system system;
        struct error error = {0};
        struct method_choice choice[PRECISION_DEFAULTS];
        int absent = 0;
        scene_init(&scene, preset_at(i));
        if (!scene_bind(&scene, &system, &error))
            continue;
        const int count = precision_defaults(&system, 10, choice, count_absent, &absent);
        assert_true(count >= 3 && count <= PRECISION_DEFAULTS);
        for (int c = 0; c < count; c++) {
            enum drag drag = choice[c].drag;
            assert_true(method_applies(choice[c].method, &system, &drag, &error));
            for (int other = 0; other < c; other++)
                assert_ptr_not_equal(choice[c].method, choice[other].method);
        }
    }
}

/* What is timed by the general code is ranked only while no specialised one is ahead of it. */
TEST(test_paths_are_not_ranked_against_each_other)
{
    static const char *const names[] = {"rk4", "radau5", "gauss4", "dopri5"};
    static const enum kernel paths[] = {KERNEL_SPECIALISED, KERNEL_GENERAL, KERNEL_GENERAL,
                                        KERNEL_SPECIALISED};
    static const double minimum[] = {2, 3, 1, 4};
    struct precision_point point[4] = {{0}};
    struct precision_curve curve[4];
    for (int i = 0; i < 4; i++) {
        curve[i] = (struct precision_curve){
            {method_named(names[i]), DRAG_DEFAULT}, .first = i, .count = 1};
        point[i] = (struct precision_point){
            .curve = i, .stop = STOP_END, .path = paths[i], .errors = {.max = 1e-6}};
        point[i].cost.evals = 100 - i;
        point[i].time = (struct timing_result){
            .minimum = minimum[i], .median = 1.1 * minimum[i], .samples = 15};
    }
    const struct precision precision = {
        .reference = {.accuracy = 1e-9}, .point = point, .points = 4, .curve = curve, .curves = 4};
    struct precision_cost cost[4];
    int others = -1;
    assert_int_equal(precision_fastest(&precision, 1e-5, cost, &others), 3);
    assert_int_equal(others, 1);
    /* gauss4 is ahead though general, radau5 is not */
    static const int first_general[] = {2, 0, 3, 1};
    for (int i = 0; i < 4; i++)
        assert_int_equal(cost[i].curve, first_general[i]);
    point[2].time.minimum = 2.5;
    assert_int_equal(precision_fastest(&precision, 1e-5, cost, &others), 2);
    assert_int_equal(others, 2);
    assert_int_equal(cost[0].curve, 0);
    assert_int_equal(cost[1].curve, 3);
    for (int i = 0; i < 4; i++) /* evaluations compare, whatever the code */
        point[i].time.minimum = point[i].time.median = NAN;
    assert_int_equal(precision_fastest(&precision, 1e-5, cost, &others), 4);
    assert_int_equal(others, 0);
    assert_int_equal(cost[0].curve, 3);
}

/* That times are taken, not how long they are. */
TEST(test_times)
{
    struct scene scene;
    struct precision precision;
    const struct method_choice choice[] = {{method_named("rk4"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 1);
    request.dt[0] = request.dt[1] = 2.0 / 64;
    request.timing = TIMING_FULL;
    request.recording = true;
    run_study(&request, &precision);
    const struct precision_point *point = &precision.point[0];
    assert_true(point->time.minimum > 0 && point->time.minimum <= point->time.median);
    assert_true(point->time.samples >= TIMING_SAMPLES && !point->time.few);
    assert_true(point->time.spread >= 0 && point->recording > 0);
    precision_free(&precision);
}

static struct precision stiff_study(const struct method_choice *choice, int count)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    const struct row *stiff = catalog_find(&preset_catalog, TEXT("stiff-vanderpol"));
    assert_non_null(stiff);
    scene_init(&scene, (const struct preset *)(const void *)stiff);
    assert_true(scene_set(&scene, scene_param(&scene, "mu"), (struct measured){1000, 0}, &error));
    struct precision_request request = request_for(&scene, choice, count);
    request.duration = 2000;
    run_study(&request, &precision);
    return precision;
}

/* Steps that jump the wrong way are found out on 1/256 of the motion; explicit solves are given up
 * by forecast. */
TEST(test_lost_rows_cost_little)
{
    const struct method_choice choice[] = {{method_named("trapezoid"), DRAG_DEFAULT},
                                           {method_named("ros3p"), DRAG_DEFAULT},
                                           {method_named("dopri5"), DRAG_DEFAULT},
                                           {method_named("dop853"), DRAG_DEFAULT}};
    struct precision precision = stiff_study(choice, 4);
    for (int i = 0; i < precision.points; i++) {
        const struct precision_point *point = &precision.point[i];
        if (precision_meaningful(point))
            continue;
        const int64_t work =
            point->cost.evals + point->cost.jacobians + point->cost.solves + point->steps;
        if (!(work < 400000)) {
            print_error("%s: %lld for nothing\n", choice[point->curve].method->row.name,
                        (long long)work);
            fail();
        }
    }
    precision_free(&precision);
}

/* With quick timing a solve of more than 30000 steps is timed over its first 30000 steps only, and
 * timed_steps tells that number; 0 means that the whole solve was timed. */
TEST(test_quick_times_are_of_a_part)
{
    struct scene scene;
    struct precision precision;
    const struct method_choice choice[] = {{method_named("rk4"), DRAG_DEFAULT}};
    scene_init(&scene, NULL);
    struct precision_request request = request_for(&scene, choice, 1);
    request.dt[0] = ldexp(2, -17);
    request.dt[1] = ldexp(2, -8);
    request.timing = TIMING_QUICK;
    run_study(&request, &precision);
    assert_int_equal(precision.points, 10);
    for (int i = 0; i < precision.points; i++) {
        const struct precision_point *point = &precision.point[i];
        assert_true(point->time.minimum > 0);
        assert_int_equal(point->timed_steps, point->steps > 30000 ? 30000 : 0);
    }
    precision_free(&precision);
}

RUN_TESTS(NULL, NULL)
