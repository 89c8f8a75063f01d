/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every scene under the names of its own model. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include "modules/resume/testing.h"

static void collect(void *context, const char *candidate, const char *brief)
{
    (void)brief;
    buffer_format(context, " %s ", candidate);
}

/* What it has can be listed, set, completed, saved and read again. */
TEST(every_scene_has_its_parameters)
{
    struct bench b, other;
    bench_open(&b, false);
    for (size_t p = 0; p < preset_catalog.count; p++) {
        char line[200];
        snprintf(line, sizeof line, "scene %s", preset_at(p)->row.name);
        type_ok(&b, line);
        const struct scene *scene = &b.session->setup.scene, before = *scene;
        struct buffer offered = {0}, saved = {0};
        size_t start;
        command_complete(b.session, TEXT("set "), 4, &start, collect, &offered);
        for (size_t i = 0; i < scene_params(scene)->count; i++) {
            const char *name = catalog_row(scene_params(scene), i)->name;
            type_ok(&b, "list parameters");
            assert_says(&b.out, name);
            snprintf(line, sizeof line, " %s ", name);
            assert_says(&offered, line);
            snprintf(line, sizeof line, "%s = 1*%s; show scene", name, name);
            type_ok(&b, line);
            snprintf(line, sizeof line, "%s = ", name);
            assert_says(&b.out, line);
            assert_true(scene->chosen[i] && scene->value[i] == before.value[i]);
        }
        session_save(b.session, &saved);
        write_file("set.hk", saved.data, saved.len);
        bench_open(&other, false);
        type_ok(&other, "source set.hk");
        assert_true(other.session->setup.scene.preset == preset_at(p));
        assert_memory_equal(other.session->setup.scene.value, scene->value, sizeof scene->value);
        assert_memory_equal(other.session->setup.scene.chosen, scene->chosen, sizeof scene->chosen);
        bench_close(&other);
        buffer_free(&saved);
        buffer_free(&offered);
    }
    bench_close(&b);
}

/* What only another scene has is refused, and that scene is named. */
TEST(foreign_names_are_explained)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t p = 0; p < preset_catalog.count; p++) {
        char line[200];
        snprintf(line, sizeof line, "scene %s", preset_at(p)->row.name);
        type_ok(&b, line);
        const struct scene *scene = &b.session->setup.scene;
        for (const struct model *const *model = scene_models; *model; model++)
            for (size_t i = 0; i < (*model)->params->count; i++) {
                const char *name = catalog_row((*model)->params, i)->name;
                if (scene_param(scene, name) >= 0 ||
                    catalog_find(scene_derived(scene), text_of(name)) ||
                    catalog_find(&command_catalog, text_of(name)))
                    continue;
                snprintf(line, sizeof line, "%s = 1", name);
                assert_false(type(&b, line));
                snprintf(line, sizeof line, "%s has no parameter '%s'", preset_at(p)->row.name,
                         name);
                assert_says(&b.err, line);
                assert_says(&b.err, "belongs to another scene: scene ");
            }
    }
    bench_close(&b);
}

/* A run is said, printed, exported and drawn under the names of its variables; plots it cannot have
 * are refused. */
TEST(every_run_can_be_looked_at)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "set format json; method rk4 dt=1e-9");
    for (size_t p = 0; p < preset_catalog.count; p++) {
        char line[200], wanted[80], value[REAL_TEXT_SIZE];
        snprintf(line, sizeof line, "scene %s; run --steps 200", preset_at(p)->row.name);
        type_ok(&b, line);
        const struct run *run = b.session->runs.slot[b.session->runs.current]->run;
        const struct model *model = run->system.model;
        struct buffer names = {0};
        for (int i = 0; i < model->n; i++) {
            const char *name = model->variable[i].name;
            real_format(run->y[i], value);
            type_ok(&b, "show run");
            snprintf(wanted, sizeof wanted, "\"%s\":%s", name, value);
            assert_says(&b.out, wanted);
            snprintf(line, sizeof line, "print %s", name);
            type_ok(&b, line);
            snprintf(wanted, sizeof wanted, "\"value\":%s,", value);
            assert_says(&b.out, wanted);
            buffer_format(&names, ",\"%s\"", name);
        }
        type_ok(&b, "export run.csv --force");
        buffer_put(&names, model->order == 2 ? TEXT(",\"energy\"]") : TEXT("]"));
        assert_says(&b.out, names.data);
        buffer_free(&names);
        static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_VELOCITY, PLOT_PHASE, PLOT_ORBIT,
                                               PLOT_ENERGY};
        for (size_t k = 0; k < COUNT_OF(kinds); k++) {
            const bool plane = kinds[k] != PLOT_ORBIT || model->n == 4;
            const bool fits = kinds[k] == PLOT_POSITION ||
                              (kinds[k] == PLOT_PHASE && model->n > 1) ||
                              (model->order == 2 && plane);
            snprintf(line, sizeof line, "plot %s", catalog_row(&plot_catalog, kinds[k])->name);
            if (type(&b, line) != fits)
                fail_msg("%s of %s: %s", line, preset_at(p)->row.name, said(&b.err));
        }
        type_ok(&b, "drop all");
    }
    bench_close(&b);
}

/* Forces change on the way, the start does not. */
TEST(what_can_change_on_the_way)
{
    static const char *const starts[] = {"t0", "y0",  "v0",  "theta0",   "rate0",
                                         "x0", "vx0", "vy0", "stretch0", "e"};
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method rk4 dt=1e-9");
    for (size_t p = 0; p < preset_catalog.count; p++) {
        char line[200];
        snprintf(line, sizeof line, "scene %s; run --steps 5", preset_at(p)->row.name);
        type_ok(&b, line);
        const struct scene *scene = &session_run(b.session)->scene;
        for (size_t i = 0; i < scene_params(scene)->count; i++) {
            const char *name = catalog_row(scene_params(scene), i)->name;
            bool is_start = false;
            for (size_t s = 0; s < COUNT_OF(starts); s++)
                is_start |= strcmp(name, starts[s]) == 0;
            snprintf(line, sizeof line, "change %s 1*%s", name, name);
            if (type(&b, line) != !is_start)
                fail_msg("%s of %s: %s", line, preset_at(p)->row.name, said(&b.err));
            if (is_start)
                assert_says(&b.err, "is an initial value");
            else
                assert_says(&b.out, " from t = ");
        }
        type_ok(&b, "drop all");
    }
    bench_close(&b);
}

/* A session with runs of several models, one changed on the way, gives the same exports after
 * autosave and undo. */
TEST(sessions_with_several_models)
{
    static const char *const files[] = {"1.csv", "2.csv", "3.csv"};
    struct bench b, other;
    bench_open(&b, false);
    type_ok(&b, "let e = 2; method rk4; scene pendulum; length = 2 m; run 3 s; change g 5 m/s^2; "
                "continue to 5 s");
    type_ok(&b, "scene kepler; e = 0.3; run until y < 0; scene robertson; method radau5; run 1 s; "
                "scene henon-heiles");
    bench_resume(&b, &other);
    type_ok(&b, "undo 2; redo 2");
    assert_true(b.session->setup.scene.preset == other.session->setup.scene.preset);
    assert_int_equal(other.session->setup.lets, 1);
    for (int i = 0; i < 3; i++) {
        char line[80];
        struct buffer a = {0}, c = {0};
        struct error error;
        snprintf(line, sizeof line, "export %s run %d --force", files[i], i + 1);
        type_ok(&b, line);
        assert_true(file_read(files[i], 1 << 24, &a, &error));
        type_ok(&other, line);
        assert_true(file_read(files[i], 1 << 24, &c, &error));
        assert_true(a.len > 200 && text_equal(buffer_text(&a), buffer_text(&c)));
        buffer_free(&a);
        buffer_free(&c);
    }
    bench_close(&b);
    bench_close(&other);
}

/* However few rows a screen takes of a long run, no coordinate loses its extremes. */
TEST(long_runs_keep_every_envelope)
{
    struct bench b;
    struct arena arena = {0};
    struct figure figure;
    struct error error;
    bench_open(&b, false);
    type_ok(&b, "scene kepler; method verlet dt=1ms; run 500 s");
    const struct run *run = b.session->runs.slot[0]->run;
    const int index = 0;
    const struct figure_request request = {.kind = PLOT_POSITION,
                                           .run = &index,
                                           .runs = 1,
                                           .recording = -1,
                                           .window = {0, 500},
                                           .width = 80,
                                           .charset = &charset_ascii,
                                           .follow = true};
    assert_true(session_figure(b.session, &request, &arena, &figure, &error));
    assert_int_equal(figure.curves, 2);
    assert_true(figure.curve[0].n < trace_count(run->trace) / 50);
    /* In each part of 10 s, longer than a turn. */
    for (int i = 0; i < 2; i++) {
        double all[50][2] = {{0}}, shown[50][2] = {{0}};
        for (size_t row = 0; row + 1 < trace_count(run->trace); row++) {
            double *part = all[(int)(trace_time(run->trace, row) / 10)];
            part[0] = fmin(part[0], trace_state(run->trace, row)[i]);
            part[1] = fmax(part[1], trace_state(run->trace, row)[i]);
        }
        for (size_t row = 0; row < figure.curve[i].n; row++) {
            if (!(figure.curve[i].x[row] < 500))
                continue;
            double *part = shown[(int)(figure.curve[i].x[row] / 10)];
            part[0] = fmin(part[0], figure.curve[i].y[row]);
            part[1] = fmax(part[1], figure.curve[i].y[row]);
        }
        for (int part = 0; part < 50; part++)
            if (!(shown[part][0] < 0.99 * all[part][0] && shown[part][1] > 0.99 * all[part][1]))
                fail_msg("%s, part %d: %g..%g of %g..%g", figure.curve[i].label, part,
                         shown[part][0], shown[part][1], all[part][0], all[part][1]);
    }
    arena_reset(&arena);
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
