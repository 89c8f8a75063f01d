/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Undo, redo, checkpoints, save and continue give back exactly what was there. */
#include "cmocka_testing.h"

#include "unit/command/testing.h"

struct end {
    double t, y[2];
    int64_t steps;
    size_t rows;
};

static struct end end_of(const struct bench *bench)
{
    const struct run *run = bench->session->runs.slot[bench->session->runs.current]->run;
    return (struct end){run->t, {run->y[0], run->y[1]}, run->steps, trace_count(run->trace)};
}

static void assert_same_end(struct end a, struct end b)
{
    assert_memory_equal(&a.t, &b.t, sizeof a.t);
    assert_memory_equal(a.y, b.y, sizeof a.y);
    assert_int_equal(a.steps, b.steps);
    assert_int_equal(a.rows, b.rows);
}

static const char *const methods[] = {"euler",  "verlet", "rk4", "implicit-midpoint",
                                      "dopri5", "exact"};

/* Taken back and advanced again, a run has the same bits: fixed and adaptive steps, ends on and off
 * the grid. */
TEST(undo_and_redo_keep_bits)
{
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        struct bench b;
        char line[80];
        bench_open(&b, false);
        snprintf(line, sizeof line, "method %s; gamma = 0.1", methods[i]);
        type_ok(&b, line);
        type_ok(&b, "run 1.2345 s");
        const struct end one = end_of(&b);
        type_ok(&b, "continue 2.5 s");
        const struct end two = end_of(&b);
        type_ok(&b, "step 7");
        const struct end three = end_of(&b);
        assert_true(two.steps > one.steps && three.steps == two.steps + 7);
        type_ok(&b, "undo");
        assert_same_end(end_of(&b), two);
        type_ok(&b, "undo");
        assert_same_end(end_of(&b), one);
        type_ok(&b, "redo");
        assert_same_end(end_of(&b), two);
        type_ok(&b, "redo");
        assert_same_end(end_of(&b), three);
        type_ok(&b, "undo 3");
        assert_int_equal(b.session->runs.count, 0);
        type_ok(&b, "redo 3");
        assert_same_end(end_of(&b), three);
        bench_close(&b);
    }
}

/* What a change made of the plan goes with it: kernels round differently, and there is an exact
 * solution again. */
TEST(an_undone_change_leaves_no_trace)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "run 0.275 s");
    type_ok(&b, "continue 0.119 s");
    const struct end end = end_of(&b);
    type_ok(&b, "change mu 0.2");
    assert_false(session_run(b.session)->plan.exact_known);
    type_ok(&b, "undo");
    assert_true(session_run(b.session)->plan.exact_known);
    type_ok(&b, "undo");
    type_ok(&b, "redo");
    assert_same_end(end_of(&b), end);
    bench_close(&b);
}

/* Also from the middle of the way, where the way is a grid of steps. */
TEST(undo_of_back_and_reset_keeps_bits)
{
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        struct bench b;
        char line[80];
        /* what its step control remembered on the way is not recorded */
        if (strcmp(methods[i], "dopri5") == 0)
            continue;
        bench_open(&b, false);
        snprintf(line, sizeof line, "method %s; gamma = 0.1; run 1 s; continue 1 s; step 7",
                 methods[i]);
        type_ok(&b, line);
        const struct end end = end_of(&b);
        type_ok(&b, "back 9");
        assert_int_equal(end_of(&b).steps, end.steps - 9);
        type_ok(&b, "undo");
        assert_same_end(end_of(&b), end);
        type_ok(&b, "reset");
        assert_int_equal(end_of(&b).steps, 0);
        type_ok(&b, "undo");
        assert_same_end(end_of(&b), end);
        bench_close(&b);
    }
}

TEST(a_split_run_equals_a_long_one)
{
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        struct bench b;
        char line[80];
        /* its steps end where it is told to stop */
        if (strcmp(methods[i], "dopri5") == 0)
            continue;
        bench_open(&b, false);
        snprintf(line, sizeof line, "method %s; gamma = 0.1; run 3 s", methods[i]);
        type_ok(&b, line);
        const struct end whole = end_of(&b);
        type_ok(&b, "run 1 s; continue 0.5 s; step 20; continue 1.3 s");
        assert_same_end(end_of(&b), whole);
        bench_close(&b);
    }
}

/* The set-up as undo sees it, without what a front end decides. */
static void assert_same_setup(const struct setup *a, const struct setup *b)
{
    assert_ptr_equal(a->scene.preset, b->scene.preset);
    assert_memory_equal(a->scene.value, b->scene.value, sizeof a->scene.value);
    assert_memory_equal(a->scene.uncertainty, b->scene.uncertainty, sizeof a->scene.uncertainty);
    assert_memory_equal(a->scene.chosen, b->scene.chosen, sizeof a->scene.chosen);
    assert_ptr_equal(a->method, b->method);
    assert_int_equal(a->drag, b->drag);
    assert_int_equal(a->fixed, b->fixed);
    assert_memory_equal(&a->settings, &b->settings, sizeof a->settings);
    assert_int_equal(a->lets, b->lets);
    assert_memory_equal(a->let, b->let, (size_t)a->lets * sizeof a->let[0]);
}

TEST(save_recreates_the_setup_exactly)
{
    static const char *const setups[] = {
        "echo nothing",
        "m = 199.9 +- 0.1 g; k = 1/3; gamma = 1e-17; y0 = pi/100; v0 = -1e-300; phase = 30 deg; "
        "omega = 1.7 Hz",
        "scene damped; method dopri5 dt=1/7; T0 = 0.731 +- 0.002 s",
        "method verlet drag=implicit; C = 0.5; duration = 2/3; set record every 7; tol = 1e-9; "
        "timing off; set digits "
        "12",
        "method dopri5 tol=3e-5; let A = 5 cm +- (1/3) mm; let B = 0.1+0.2; set phase-axes raw; "
        "set "
        "record all; tol = "
        "off",
    };
    for (size_t i = 0; i < COUNT_OF(setups); i++) {
        struct bench a, b;
        struct buffer first = {0}, second = {0};
        bench_open(&a, false);
        bench_open(&b, false);
        type_ok(&a, setups[i]);
        session_save(a.session, &first);
        struct text rest = buffer_text(&first), line;
        while (text_split(&rest, '\n', &line))
            if (!command_exec(b.session, line, NULL, &b.reply))
                fail_msg("%.*s: %s", (int)line.len, line.data, said(&b.err));
        assert_same_setup(&a.session->setup, &b.session->setup);
        session_save(b.session, &second);
        assert_string_equal(first.data, second.data);
        buffer_free(&first);
        buffer_free(&second);
        bench_close(&a);
        bench_close(&b);
    }
}

/* A statement that fails changes nothing, whatever it is. */
TEST(failed_statements_change_nothing)
{
    static const char *const failing[] = {
        "m = -1",
        "m = 5 cm",
        "k = 1e305; m = 1e-6",
        "method rk4 tol=1e-3",
        "method dopri5 dt=-1",
        "method verlet drag=foo",
        "dt = 0",
        "set record every 0",
        "set size 5",
        "let m = 4",
        "run 1e300",
        "run until y < 1 kg",
        "continue -1",
        "step 0",
        "compare euler dt=0",
        "compare euler verlet dt=1ms,2ms tol=1e-3",
        "use 9",
        "rename 1 2x",
        "drop 9",
        "drop 1 9",
        "load nofile",
        "data use x",
        "fit to x",
        "unset foo",
        "scene foo",
        "restore foo",
        "source nofile.hk",
        "measure k of run 9",
        "set format xml",
        "timing slow",
    };
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "m = 0.3; method verlet; run 1 s; checkpoint");
    for (size_t i = 0; i < COUNT_OF(failing); i++) {
        const struct setup before = b.session->setup;
        const int runs = b.session->runs.count, undos = b.session->undo.undos;
        const struct end end = end_of(&b);
        const char *last = strrchr(failing[i], ';');
        if (type(&b, failing[i]))
            fail_msg("'%s' should fail", failing[i]);
        if (last) /* the statement before it may have changed something: take that back */
            type_ok(&b, "undo");
        assert_same_setup(&before, &b.session->setup);
        assert_int_equal(b.session->runs.count, runs);
        assert_int_equal(b.session->undo.undos, undos);
        assert_same_end(end_of(&b), end);
    }
    bench_close(&b);
}

TEST(undo_keeps_the_last_levels)
{
    struct bench b;
    bench_open(&b, false);
    for (int i = 1; i <= LIMIT_UNDO + 5; i++) {
        char line[32];
        snprintf(line, sizeof line, "k = %d", i);
        type_ok(&b, line);
    }
    assert_int_equal(b.session->undo.undos, LIMIT_UNDO);
    type_ok(&b, "undo 1000");
    assert_says(&b.err, "warning");
    assert_true(b.session->setup.scene.value[param_index("k")] == 5);
    type_ok(&b, "redo 1000");
    assert_true(b.session->setup.scene.value[param_index("k")] == LIMIT_UNDO + 5);
    bench_close(&b);
}

/* What entries share stays as it was in all of them: a list of many changes that goes on in two
 * ways, each to its end and back, has the bits of the run that went there at once. */
TEST(shared_lists_stay_as_they_were)
{
    enum { CHANGES = 40 };
    struct end at[CHANGES + 1], other;
    struct bench b, once;
    char line[80];
    bench_open(&b, false);
    bench_open(&once, false);
    type_ok(&b, "method rk4; run 0.1 s");
    type_ok(&once, "method rk4; run 0.1 s");
    at[0] = end_of(&b);
    for (int i = 1; i <= CHANGES; i++) {
        snprintf(line, sizeof line, "change k %d; continue %d ms; step; step", 10 + i, 7 * i);
        type_ok(&b, line);
        at[i] = end_of(&b);
    }
    for (int way = 0; way < 2; way++) {
        snprintf(line, sizeof line, "undo %d", 4 * (CHANGES - 20));
        type_ok(&b, line);
        assert_same_end(end_of(&b), at[20]);
        if (way == 0) {
            snprintf(line, sizeof line, "redo %d", 4 * (CHANGES - 20));
            type_ok(&b, line);
            assert_same_end(end_of(&b), at[CHANGES]);
        }
    }
    static const char *const onwards[] = {"step", "change m 0.3", "continue 0.2 s", "step 3"};
    for (size_t i = 0; i < COUNT_OF(onwards); i++)
        type_ok(&b, onwards[i]);
    for (int i = 1; i <= 20; i++) {
        snprintf(line, sizeof line, "change k %d; continue %d ms; step 2", 10 + i, 7 * i);
        type_ok(&once, line);
    }
    type_ok(&once, "step; change m 0.3; continue 0.2 s; step 3");
    other = end_of(&once);
    assert_same_end(end_of(&b), other);
    type_ok(&b, "undo 4");
    assert_same_end(end_of(&b), at[20]);
    type_ok(&b, "undo 80");
    assert_same_end(end_of(&b), at[0]);
    type_ok(&b, "redo 84");
    assert_same_end(end_of(&b), other);
    bench_close(&b);
    bench_close(&once);
}

TEST(a_run_dropped_lives_as_long_as_undo_needs_it)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b,
            "method verlet; run 1 s; checkpoint x; run 2 s; rename 2 two; note hello; drop all");
    assert_int_equal(b.session->runs.count, 0);
    type_ok(&b, "restore x");
    assert_int_equal(b.session->runs.count, 1);
    type_ok(&b, "undo; undo; runs");
    assert_says(&b.out, "two");
    assert_says(&b.out, "hello");
    type_ok(&b, "run 1 s");
    assert_says(&b.out, "t = 1 s");
    bench_close(&b);
}

static const char *field(const struct bench *b, const struct setting *setting)
{
    assert_true(setting->bytes > 0);
    return (const char *)&b->session->setup.settings + setting->offset;
}

/* Sets it to something else, in one statement. */
static void change_setting(struct bench *b, const struct setting *setting)
{
    static const char *const values[] = {"0.37", "7", "33x11", "every 7"};
    const struct settings before = b->session->setup.settings;
    char line[160];
    for (size_t i = 0; i < 16; i++) {
        const bool choice = setting->choices && i < setting->choices->count;
        snprintf(line, sizeof line, "set %s %s", setting->row.name,
                 choice ? catalog_row(setting->choices, i)->name : values[i % COUNT_OF(values)]);
        type(b, line);
        if (memcmp(field(b, setting), (const char *)&before + setting->offset, setting->bytes) != 0)
            return;
    }
    fail_msg("no other value of %s was found", setting->row.name);
}

/* undo gives a setting its value back, or, where it only shows, passes it over and says what it
 * took back instead. */
TEST(undo_of_every_setting_does_what_it_says)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        /* it is set back to read the answers */
        const bool is_format = setting->choices == &format_choice_catalog;
        struct bench b;
        bench_open(&b, setting->typed); /* some are taken from a person only */
        type_ok(&b, "k = 20");
        const struct settings before = b.session->setup.settings;
        change_setting(&b, setting);
        const struct settings after = b.session->setup.settings;
        type_ok(&b, "set format text; undo");
        assert_says(&b.out, setting->display ? "undone: k = 20" : "undone: set ");
        const double k = b.session->setup.scene.value[scene_param(&b.session->setup.scene, "k")];
        if (k != (setting->display ? 15 : 20))
            fail_msg("%s: k = %g after undo", setting->row.name, k);
        const struct settings *wanted = setting->display ? &after : &before;
        if (!is_format &&
            memcmp(field(&b, setting), (const char *)wanted + setting->offset, setting->bytes) != 0)
            fail_msg("%s is not what it should be after undo", setting->row.name);
        type_ok(&b, "redo");
        if (!is_format &&
            memcmp(field(&b, setting), (const char *)&after + setting->offset, setting->bytes) != 0)
            fail_msg("%s is not what it was after redo", setting->row.name);
        bench_close(&b);
    }
}

/* Nothing to go back to: no entry, whatever the command. */
TEST(what_changes_nothing_is_no_step_of_undo)
{
    static const char *const lines[] = {
        "set charset ascii", "unset charset",   "note x",      "use 1",
        "set k 20",          "set duration 10", "method euler"};
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method euler; k = 20; set duration 10; run 1 s");
    const int undos = b.session->undo.undos;
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        type_ok(&b, lines[i]);
        if (b.session->undo.undos != undos)
            fail_msg("'%s' made an entry", lines[i]);
    }
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
