/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes typed as equations against built-in ones; their kernels, splittings and ledger.
 * command_references.c has what they reach. */
#include "cmocka_testing.h"

#include "unit/cpu_time.h"
#include "unit/scene/typing.h"
#include <hooke/base/catalog.h>
#include <hooke/run.h>

static const struct method *method(const char *name)
{
    return method_by_name(text_of(name));
}

static bool type_lines(struct typed_models *models, struct scene *scene, const char *lines)
{
    struct text rest = text_of(lines), line;
    struct error error = {0};
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene->model, &typed, &error);
        if (!model) {
            print_message("%.*s: %s (%s)\n", (int)line.len, line.data, error.text, error.hint);
            return false;
        }
        scene_remodel(scene, model);
    }
    return true;
}

static struct run *typed_run(const struct scene *scene, const struct method *by, enum drag drag)
{
    const struct run_settings settings = {.dt = 0.05, .drag = drag};
    struct error error;
    struct run *run = run_create(scene, by, &settings, 50, &error);
    const struct run_target target = {.t = 50, .steps = -1};
    if (run)
        run_advance(run, &target, 0, NULL);
    return run;
}

/* Every symplectic method that takes Henon and Heiles' star takes the typed one, too, and to the
 * same bits. */
TEST(test_symplectic)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    struct scene typed, built_in;
    int count = 0;
    bool fine = true;
    scene_init(&typed, NULL);
    scene_init(&built_in, preset_by_name(TEXT("henon-heiles")));
    assert_true(type_lines(models, &typed,
                           "var x = 0;var y = 0;var x' = 0.24;var y' = 0.32;x'' = -(x + 2*x*y);"
                           "y'' = -(y + (x^2 - y^2));"
                           "potential (x^2 + y^2)/2 + (x^2 - y^2/3)*y"));
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *by = method_at(i);
        if (!(by->flags & METHOD_SYMPLECTIC) || by->flags & METHOD_IMPLICIT)
            continue;
        struct run *one = typed_run(&typed, by, DRAG_DEFAULT),
                   *other = typed_run(&built_in, by, DRAG_DEFAULT);
        if (!one != !other)
            print_message("%s takes one only\n", by->row.name);
        fine &= !one == !other;
        for (int k = 0; one && other && k < 4; k++) {
            fine &= one->y[k] == other->y[k];
            if (one->y[k] != other->y[k])
                print_message("%s: %.17g is not %.17g\n", by->row.name, one->y[k], other->y[k]);
        }
        count += one != NULL;
        struct ledger ledger;
        if (one) {
            run_ledger(one, &ledger);
            fine &= fabs(ledger.error_max) < 0.1 && one->plan.ledger == false;
        }
        run_destroy(one);
        run_destroy(other);
    }
    typed_destroy(models);
    assert_true(fine);
    assert_true(count >= 10);
}

/* Quadratic drag typed so that hooke does not recognise it: splittings refuse it and point to
 * drag=explicit. */
TEST(test_splitting_with_drag)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(
        type_lines(models, &scene, "var x = 1;x'' = -x - 0.1*x'*max(x', -x');potential x^2/2"));
    const struct run_settings settings = {.dt = 0.001};
    assert_null(run_create(&scene, method("verlet"), &settings, 10, &error));
    assert_non_null(strstr(error.hint, "drag=explicit"));
    const struct run_settings explicit = {.dt = 0.001, .drag = DRAG_EXPLICIT};
    struct run *run = run_create(&scene, method("verlet"), &explicit, 10, &error);
    assert_non_null(run);
    const struct run_target target = {.t = 10, .steps = -1};
    run_advance(run, &target, 0, NULL);
    /* references.csv, quadratic drag b = 0.1 */
    assert_true(fabs(run->y[0] - -6.038516824236533039553e-1) < 1e-3);
    struct ledger ledger;
    run_ledger(run, &ledger);
    assert_true(fabs(ledger.error_max) < 1e-3 && ledger.work < -0.1);
    run_destroy(run);
    typed_destroy(models);
}

/* The energy balance of a force without a potential: all of it is work. */
TEST(test_ledger)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    scene_init(&scene, preset_by_name(TEXT("damped")));
    assert_true(type_lines(models, &scene, "force -40*y^3 + 0.1*cos(2*t)"));
    const struct run_settings settings = {.dt = 0.001};
    struct run *run = run_create(&scene, method("rk4"), &settings, 10, &error);
    assert_non_null(run);
    const struct run_target target = {.t = 10, .steps = -1};
    run_advance(run, &target, 0, NULL);
    struct ledger ledger;
    run_ledger(run, &ledger);
    assert_true(fabs(ledger.error_max) < 1e-8 && fabs(ledger.work) > 1e-4);
    run_destroy(run);
    typed_destroy(models);
}

/* A search for what no step has seen takes no more than the run did, and 1e8 instructions or so:
 * also where bounds of a force that turns often prove nothing; 100 pulses are found in nine tenths
 * of the runs that see nothing of them. */
TEST(test_search_of_bursts)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct burst missed;
    for (int turns = 1000; turns <= 1000000; turns *= 10) {
        struct scene scene;
        char lines[80];
        scene_init(&scene, NULL);
        snprintf(lines, sizeof lines, "var x = 0;x' = sin(%d.3*t)^2", turns);
        assert_true(type_lines(models, &scene, lines));
        const struct run_settings settings = {.dt = 0.01, .tol = 1e-4};
        struct run *run = run_create(&scene, method("odex"), &settings, 1, &error);
        assert_non_null(run);
        const struct run_target target = {.t = 1, .steps = -1};
        const int64_t begin = cpu_ns();
        run_advance(run, &target, 0, NULL);
        const int64_t between = cpu_ns();
        assert_false(run_missed_burst(run, &missed));
        const double own = (double)(between - begin) * 1e-9,
                     search = (double)(cpu_ns() - between) * 1e-9;
        if (search > 2 * own + 0.3)
            fail_msg("sin(%d t)^2: %g s of search in a run of %g s", turns, search, own);
        run_destroy(run);
    }
    int found = 0, all = 0;
    for (int i = 0; i < 100; i++) {
        struct scene scene;
        char lines[120];
        scene_init(&scene, NULL);
        snprintf(lines, sizeof lines,
                 "var x = 0;var v = 0;x' = v;v' = sin(%d*t) - x + 100*exp(-((t - %.3f)/%.2g)^2)",
                 1 + i % 7, 1.003 + 0.17 * i, 1e-3 * pow(0.93, i));
        assert_true(type_lines(models, &scene, lines));
        const struct run_settings settings = {.dt = 0.02};
        struct run *run = run_create(&scene, method("rk4"), &settings, 20, &error);
        assert_non_null(run);
        const struct run_target target = {.t = 20, .steps = -1};
        run_advance(run, &target, 0, NULL);
        found += run_missed_burst(run, &missed);
        all++;
        run_destroy(run);
    }
    print_message("%d of %d pulses found\n", found, all);
    assert_true(found >= 90);
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
