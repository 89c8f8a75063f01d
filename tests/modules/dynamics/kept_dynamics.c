/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is kept of the equations: how long, under which labels, how much of it, and back from the
 * session's file. */
#include "cmocka_testing.h"

#include "modules/resume/testing.h"
#include "modules/solving/compute/start.h"
#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/dynamics_results.h"

static const char duffing[] =
    "scene new; var x = 1; var v = 0; param d = 0.2; param F = 0; x' = v; "
    "v' = x-x^3-d*v+F*0";

static void keep_orbit(struct bench *b, double period)
{
    struct error error = {0};
    const double sample[] = {0, 1, 0, period, 1, 0};
    const struct solution orbit = {.kind = SOLUTION_ORBIT,
                                   .n = 2,
                                   .state = {1, 0},
                                   .top = {1, 1},
                                   .bottom = {-1, -1},
                                   .period = period,
                                   .values = 1};
    assert_non_null(dynamics_store_orbit(b->session, &orbit, 2, sample, &error));
}

/* A branch of three points, the middle one special. */
static const struct stored_branch *keep_branch(struct bench *b, double at, enum special special)
{
    struct error error = {0};
    struct stored_branch like = {.params = 1, .origin = "equilibrium 1", .low = {0}, .high = {9}};
    like.param[0] = scene_param(&b->session->setup.scene, "d");
    like.branch.count = 3;
    like.branch.point = calloc(3, sizeof *like.branch.point);
    assert_non_null(like.branch.point);
    for (int i = 0; i < 3; i++) {
        struct branch_point *point = &like.branch.point[i];
        point->solution =
            (struct solution){.n = 2, .param = {at + i - 1}, .state = {0.25, 0.5}, .values = 2};
        point->special = i == 1 ? special : SPECIAL_NONE;
    }
    const struct stored_branch *kept =
        dynamics_store_branch(b->session, &like, b->session->setup.scene.value, &error);
    assert_non_null(kept);
    return kept;
}

static const struct stored_point *point(const struct bench *b, const char *label)
{
    const struct stored_branch *branch;
    return dynamics_point(session_dynamics(b->session), text_of(label), &branch);
}

TEST(nothing_is_there_before_it_is_found)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, duffing);
    type_ok(&b, "list orbits; list branches; list points; list equilibria; run 1 s");
    assert_null(session_part_if_made(b.session, &dynamics_module));
    type_ok(&b, "equilibria x=-2:2 v=-1:1");
    assert_non_null(session_dynamics(b.session));
    bench_close(&b);
}

/* Values are none of the equations, and undo brings back what was of them before. */
TEST(labels_live_as_long_as_the_equations)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, duffing);
    keep_branch(&b, 0.5, SPECIAL_HOPF);
    keep_branch(&b, 0.7, SPECIAL_HOPF);
    keep_branch(&b, 0.7, SPECIAL_FOLD);
    assert_non_null(point(&b, "HB1"));
    assert_non_null(point(&b, "hb2"));
    assert_non_null(point(&b, "LP1"));
    assert_null(point(&b, "HB3"));
    assert_null(point(&b, "HB"));
    assert_null(point(&b, "HB11"));
    type_ok(&b, "d = 0.3; x0 = 2; var x = 3; param d = 0.25");
    assert_non_null(point(&b, "HB2"));
    type_ok(&b, "v' = x-x^3-d*v");
    assert_null(session_dynamics(b.session));
    type_ok(&b, "undo");
    assert_non_null(point(&b, "HB2"));
    type_ok(&b, "v' = x-x^3-d*v");
    keep_branch(&b, 0.5, SPECIAL_HOPF);
    assert_non_null(point(&b, "HB1"));
    assert_null(point(&b, "HB2"));
    type_ok(&b, "undo");
    assert_null(session_dynamics(b.session));
    bench_close(&b);
}

/* What is found again has the label that it had: not so at other values of what does not vary. */
TEST(the_same_point_has_one_label)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, duffing);
    assert_int_equal(keep_branch(&b, 0.5, SPECIAL_HOPF)->special[0].number, 1);
    assert_int_equal(keep_branch(&b, 0.6, SPECIAL_HOPF)->special[0].number, 2);
    assert_int_equal(keep_branch(&b, 0.5 * (1 + 1e-10), SPECIAL_HOPF)->special[0].number, 1);
    assert_int_equal(keep_branch(&b, 0.5, SPECIAL_FOLD)->special[0].number, 1);
    type_ok(&b, "d = 7");
    assert_int_equal(keep_branch(&b, 0.5, SPECIAL_HOPF)->special[0].number, 1);
    type_ok(&b, "F = 7");
    assert_int_equal(keep_branch(&b, 0.5, SPECIAL_HOPF)->special[0].number, 3);
    bench_close(&b);
}

TEST(the_oldest_go)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, duffing);
    for (int i = 0; i < LIMIT_ORBITS; i++)
        keep_orbit(&b, 1 + i);
    keep_orbit(&b, 1); /* known already */
    const struct dynamics *d = session_dynamics(b.session);
    assert_int_equal(d->orbits, LIMIT_ORBITS);
    assert_non_null(dynamics_orbit(d, 1));
    keep_orbit(&b, 0.5);
    assert_int_equal(d->orbits, LIMIT_ORBITS);
    assert_null(dynamics_orbit(d, 2));
    assert_non_null(dynamics_orbit(d, 1));
    assert_non_null(dynamics_orbit(d, LIMIT_ORBITS + 1));
    for (int i = 0; i < LIMIT_BRANCHES; i++)
        keep_branch(&b, 1 + i, SPECIAL_HOPF);
    assert_int_equal(d->branches, LIMIT_BRANCHES);
    assert_non_null(point(&b, "HB1"));
    keep_branch(&b, 0.5, SPECIAL_HOPF);
    assert_int_equal(d->branches, LIMIT_BRANCHES);
    assert_null(point(&b, "HB1"));
    assert_non_null(point(&b, "HB33"));
    bench_close(&b);
}

TEST(a_point_becomes_the_scene)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, duffing);
    keep_branch(&b, 0.5, SPECIAL_HOPF);
    keep_orbit(&b, 6);
    type_ok(&b, "d = 0.125; use HB1");
    assert_says(&b.out, "d = 0.5");
    const struct scene *scene = &b.session->setup.scene;
    assert_true(param_value(scene, "d") == 0.5);
    assert_true(param_value(scene, "x0") == 0.25 && param_value(scene, "v0") == 0.5);
    type_ok(&b, "undo");
    assert_true(param_value(scene, "d") == 0.125 && param_value(scene, "x0") == 1);
    type_ok(&b, "x0 = 9; use orbit 1");
    assert_true(param_value(scene, "d") == 0.2 && param_value(scene, "x0") == 1);
    type_ok(&b, "equilibria x=-2:2 v=-1:1; use equilibrium 1");
    assert_true(fabs(param_value(scene, "x0") + 1) < 1e-12);
    assert_false(type(&b, "use equilibrium 4"));
    assert_says(&b.err, "there are equilibria 1 to 3");
    assert_false(type(&b, "use HB7"));
    assert_says(&b.err, "there is no point 'HB7'");
    assert_false(type(&b, "use orbit 2"));
    assert_false(type(&b, "use 1"));
    assert_says(&b.err, "there is no run yet");
    bench_close(&b);
}

/* Angles and positions of built-in scenes, too. */
TEST(built_in_scenes_start_there)
{
    static const char *const scenes[] = {"spring", "pendulum", "duffing", "vanderpol", "driven"};
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        struct scene scene;
        struct system system;
        struct error error = {0};
        const struct row *row = catalog_find(&preset_catalog, text_of(scenes[i]));
        const double start[] = {0.21, -0.34};
        scene_init(&scene, preset_from(row));
        if (!scene_start_at(&scene, start, &error))
            fail_msg("%s: %s", scenes[i], error.text);
        assert_true(scene_bind(&scene, &system, &error));
        for (int k = 0; k < 2; k++)
            if (!(fabs(system.start[k] - start[k]) <= 1e-15))
                fail_msg("%s: %g", scenes[i], system.start[k]);
    }
}

/* Branches, orbits and equilibria of a session that was stored and restored are listed as in the
 * first session, and numbers of points continue (HB33 is the next). The file is only appended to:
 * what is stored is not written a second time, and a session that exceeds LIMIT_BRANCHES has lost
 * the first branch. */
TEST(it_comes_back_from_the_file)
{
    struct bench b, again;
    struct stored stored = {0};
    struct buffer file = {0}, notes = {0};
    bench_open(&b, false);
    type_ok(&b, duffing);
    keep_branch(&b, 0.5, SPECIAL_HOPF);
    keep_orbit(&b, 6);
    bench_store(b.session, &stored, &file);
    const size_t first = file.len;
    keep_branch(&b, 0.75, SPECIAL_FOLD);
    type_ok(&b, "equilibria x=-2:2 v=-1:1");
    for (int i = 0; i < LIMIT_BRANCHES - 1; i++) /* so many that the first branch is dropped */
        keep_branch(&b, 2 + i, SPECIAL_HOPF);
    bench_store(b.session, &stored, &file);
    const size_t second = file.len;
    type_ok(&b, "d = 0.5");
    bench_store(b.session, &stored, &file);
    assert_true(
        file.len - second <
        first); /* appends less than the first part, since nothing is written a second time */
    assert_true(bench_restore(&again, buffer_text(&file), &notes));
    assert_string_equal(said(&notes), "");
    const struct dynamics *d = session_dynamics(again.session);
    assert_non_null(d);
    assert_int_equal(d->branches, LIMIT_BRANCHES);
    assert_int_equal(d->equilibria.count, 3);
    assert_null(point(&again, "HB1"));
    assert_non_null(point(&again, "LP1"));
    static const char *const lines[] = {"list equilibria",
                                        "list orbits",
                                        "list branches",
                                        "list points",
                                        "set format json; list points",
                                        "use LP1",
                                        "use orbit 1"};
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        type_ok(&b, lines[i]);
        type_ok(&again, lines[i]);
        assert_string_equal(said(&b.out), said(&again.out));
    }
    keep_branch(&again, 77, SPECIAL_HOPF);
    assert_non_null(point(&again, "HB33"));
    bench_close(&again);
    bench_close(&b);
    stored_free(&stored);
    buffer_free(&file);
    buffer_free(&notes);
}

RUN_TESTS(NULL, NULL)
