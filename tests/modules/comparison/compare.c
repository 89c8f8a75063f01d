/* SPDX-License-Identifier: GPL-3.0-or-later */
/* compare: rows, errors, orders, verdicts, refusals before any work, cancellation; timing that is
 * really taken. */
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

static struct compare_request request_for(struct scene *scene, struct method_choice *choice,
                                          const char *const *names, int count)
{
    scene_init(scene, NULL);
    for (int i = 0; i < count; i++) {
        choice[i] = (struct method_choice){method_named(names[i]), DRAG_DEFAULT};
    }
    static const double dt[] = {0.01};
    return (struct compare_request){
        .scene = scene, .choice = choice, .choices = count, .dt = dt, .dts = 1, .duration = 10};
}

static void close_to(double value, double wanted, double relative)
{
    if (!(fabs(value - wanted) <= relative * fabs(wanted))) {
        print_error("%.17g is not %.17g within %g\n", value, wanted, relative);
        fail();
    }
}

TEST(test_the_labs_comparison)
{
    static const char *const names[] = {"euler", "backward-euler", "symplectic-euler"};
    struct scene scene;
    struct method_choice choice[3];
    struct compare_request request = request_for(&scene, choice, names, 3);
    struct comparison row[3];
    int count;
    struct error error = {0};
    assert_true(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 3);
    double x2 = 75 * 0.01 * 0.01; /* (omega dt)^2 */
    close_to(row[0].energy_factor, pow(1 + x2, 1000), 1e-9);
    close_to(row[0].predicted_factor, pow(1 + x2, 1000), 1e-9);
    close_to(row[1].energy_factor, pow(1 + x2, -1000), 1e-9);
    assert_true(fabs(row[2].energy_factor - 1) < 0.1);
    assert_non_null(strstr(row[0].verdict, "as predicted"));
    assert_null(strstr(row[0].verdict, "NOT"));
    assert_non_null(strstr(row[1].verdict, "as predicted"));
    assert_non_null(strstr(row[2].verdict, "bounded, as predicted"));
    /* it does swing: the ellipse allows 0.09, far above rounding */
    assert_true(row[2].ledger.error_max > 0.04);
    assert_true(isnan(row[0].time.minimum)); /* TIMING_OFF: nothing is timed */
    for (int i = 0; i < count; i++) {
        assert_int_equal(row[i].run->steps, 1000);
        assert_int_equal(row[i].run->cost.evals, 1000);
        comparison_free(&row[i]);
    }
}

TEST(test_observed_orders)
{
    static const char *const names[] = {"symplectic-euler", "verlet", "rk4"};
    static const double order[] = {1, 2, 4};
    static const double dt[] = {0.008, 0.004, 0.002};
    struct scene scene;
    struct method_choice choice[3];
    struct compare_request request = request_for(&scene, choice, names, 3);
    request.dt = dt;
    request.dts = 3;
    struct comparison row[9];
    int count;
    struct error error = {0};
    assert_true(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 9);
    for (int i = 0; i < 9; i++) {
        if (i % 3 == 0) {
            assert_true(isnan(row[i].order));
        } else {
            close_to(row[i].order, order[i / 3], 0.05);
        }
    }
    for (int i = 0; i < 9; i++) {
        comparison_free(&row[i]);
    }
}

/* Without a closed form errors are measured against a reference, and the verdict says what the
 * energy did. */
TEST(test_without_a_closed_form)
{
    static const char *const names[] = {"verlet", "rk4"};
    static const double dt[] = {0.008, 0.004};
    struct scene scene;
    struct method_choice choice[2];
    struct compare_request request = request_for(&scene, choice, names, 2);
    const struct row *drag = catalog_find(&preset_catalog, TEXT("drag"));
    assert_non_null(drag);
    scene_init(&scene, (const struct preset *)(const void *)drag);
    request.dt = dt;
    request.dts = 2;
    request.duration = 9.984; /* whole numbers of steps, and grid times between them */
    struct comparison row[4];
    int count;
    struct error error = {0};
    assert_true(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 4);
    close_to(row[1].order, 2, 0.02);
    close_to(row[3].order, 4, 0.02);
    for (int i = 0; i < count; i++) {
        assert_non_null(row[i].reference[0]);
        assert_ptr_not_equal(row[i].reference[0], row[i].reference[1]);
        assert_true(row[i].errors.floor > 0 && row[i].errors.floor < 1e-8);
        assert_non_null(strstr(row[i].verdict, "energy balance within"));
        assert_non_null(strstr(row[i].verdict, "of the amplitude"));
        comparison_free(&row[i]);
    }
}

/* Nothing predicts the energy of a pendulum or a hardening spring: Verlet keeps it, Heun and Euler
 * do not. */
TEST(test_words_for_nonlinear_scenes)
{
    static const char *const names[] = {"verlet", "heun", "euler", "backward-euler"};
    static const char *const said[] = {"energy bounded", "energy drifts", "driven up by the method",
                                       "damped away by the method"};
    const struct row *duffing = catalog_find(&preset_catalog, TEXT("duffing"));
    if (!duffing) {
        print_message("no nonlinear conservative scene\n");
        skip();
    }
    struct scene scene;
    struct method_choice choice[4];
    struct compare_request request = request_for(&scene, choice, names, 4);
    scene_init(&scene, (const struct preset *)(const void *)duffing);
    static const double dt[] = {0.02};
    request.dt = dt;
    request.duration = 20;
    struct comparison row[4];
    int count;
    struct error error = {0};
    assert_true(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 4);
    for (int i = 0; i < count; i++) {
        if (!strstr(row[i].verdict, said[i])) {
            print_error("%s: %s\n", names[i], row[i].verdict);
            fail();
        }
        comparison_free(&row[i]);
    }
}

TEST(test_divergence_is_a_result)
{
    static const char *const names[] = {"verlet", "rk4"};
    static const double dt[] = {0.5}; /* omega dt = 4.3: above the limits 2 and 2.83 */
    struct scene scene;
    struct method_choice choice[2];
    struct compare_request request = request_for(&scene, choice, names, 2);
    request.dt = dt;
    request.duration = 2000;
    struct comparison row[2];
    int count;
    struct error error = {0};
    assert_true(study_compare(&request, row, &count, &error));
    assert_int_equal(row[0].run->stop, STOP_DIVERGED);
    assert_non_null(strstr(row[0].verdict, "diverged"));
    comparison_free(&row[0]);
    comparison_free(&row[1]);
}

TEST(test_refusals_come_first)
{
    static const char *const names[] = {"rk4", "exact"};
    struct scene scene;
    struct method_choice choice[2];
    struct compare_request request = request_for(&scene, choice, names, 2);
    struct comparison row[2];
    int count = -1;
    struct error error = {0};
    static const double bad[] = {-1.0};
    request.dt = bad;
    assert_false(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 0);
    assert_int_equal(error.code, ERROR_COMMAND);

    request = request_for(&scene, choice, names, 2);
    /* no closed form: `exact` is refused */
    assert_true(scene_set(&scene, param_index("C"), (struct measured){1, 0}, &error));
    assert_true(scene_set(&scene, param_index("area"), (struct measured){0.01, 0}, &error));
    assert_false(study_compare(&request, row, &count, &error));
    assert_int_equal(count, 0);
}

TEST(test_cancelled)
{
    static const char *const names[] = {"rk4"};
    struct scene scene;
    struct method_choice choice[1];
    struct compare_request request = request_for(&scene, choice, names, 1);
    struct cancel cancel = {0};
    atomic_store(&cancel.requested, 1);
    request.cancel = &cancel;
    struct comparison row[1];
    int count;
    struct error error = {0};
    assert_false(study_compare(&request, row, &count, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_int_equal(count, 0);
}

static struct timing_result time_of(const struct system *system, const struct method *method,
                                    const struct run_settings *settings, double span)
{
    struct solver solver;
    struct timing_result result;
    assert_true(solver_init(&solver, system, method, settings, span));
    time_solvers(&solver, &result, 1, TIMING_QUICK, 0, NULL);
    solver_free(&solver);
    return result;
}

TEST(test_times_grow_with_the_work)
{
    struct scene scene;
    scene_init(&scene, NULL);
    struct system system;
    struct error error = {0};
    assert_true(scene_bind(&scene, &system, &error));
    struct run_settings settings = {.dt = 0.01};
    enum drag drag = DRAG_DEFAULT;
    const struct method *rk4 = method_named("rk4");
    assert_true(method_applies(rk4, &system, &drag, &error));
    settings.drag = drag;
    struct timing_result few;
    struct timing_result many;
    few = time_of(&system, rk4, &settings, 1);
    many = time_of(&system, rk4, &settings, 100);
    assert_true(few.samples >= 1 && few.minimum > 0 && few.minimum <= few.median);
    /* A hundred times the steps: the factor says only that work is timed, not how fast the machine
     * is. */
    assert_true(many.minimum > 10 * few.minimum);
}

RUN_TESTS(NULL, NULL)
