/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes and events that a user types: what defines them can be saved, undone, replayed and
 * completed. */
#include "cmocka_testing.h"

#include <hooke/plot.h>
#include "modules/resume/testing.h"

#include <hooke/session/log.h>
#include "unit/cpu_time.h"

static const char *const systems[] = {
    /* the first: the scene of the start makes room for k */
    "param rate = 2.0(1); param k = 3; var x = 1; x' = -rate*x - k",
    "var x = 2; var y = 0; param mu = 5; x' = y; y' = mu*(1 - x^2)*y - x",
    "var y = 5 cm; param k = 15 N/m; param m = 199.9 +- 0.1 g; y'' = -k/m*y - 0.1*y'; var y' = "
    "0.1; observe p = m*y'",
    "var a = 1; var b = 0.5; var q1 = 3; a'' = -a; b' = a*b - t; q1' = -q1; a0 = 0.1; q1_0 = 4",
    "var x = 1; param one = 1; x' = one*x; param two = 3; observe twice = two*x; x' = -twice*one; "
    "var x = 3",
    "scene damped; param stiff = 40; force -stiff*y^3; potential 10*y^4; stiff = 40; observe up = "
    "step(y)",
    "scene driven; force 0.01*sin(3*t); gamma = 0.2",
    "var x = 0.1; var y = 0.2; x'' = -x - 2*x*y; y'' = -y - (x^2 - y^2); force x = 0.01*sin(t); "
    "force y = -0.01*y'",
};

static void start(struct bench *b, const char *system)
{
    bench_open(b, false);
    type_ok(b, system);
}

static void assert_same_state(const struct session *a, const struct session *b, const char *what)
{
    const struct run *one = a->runs.slot[a->runs.current]->run,
                     *other = b->runs.slot[b->runs.current]->run;
    if (one->steps != other->steps || one->t != other->t ||
        memcmp(one->y, other->y, (size_t)one->system.n * sizeof *one->y) != 0)
        fail_msg("%s: step %lld at %.17g, y[0] = %.17g; other: step %lld at %.17g, %.17g", what,
                 (long long)one->steps, one->t, one->y[0], (long long)other->steps, other->t,
                 other->y[0]);
}

/* Sourcing what save writes gives the same model: the same scene, the same bits of a run. */
TEST(saved_lines_recreate_the_scene)
{
    for (size_t i = 0; i < COUNT_OF(systems); i++) {
        struct bench b, other;
        struct buffer saved = {0}, again = {0};
        start(&b, systems[i]);
        type_ok(&b, "method rk4 dt=10ms");
        session_save(b.session, &saved);
        write_file("typed.hk", saved.data, saved.len);
        bench_open(&other, false);
        type_ok(&other, "var old = 1; old' = old"); /* it begins anew */
        type_ok(&other, "source typed.hk");
        session_save(other.session, &again);
        assert_string_equal(saved.data, again.data);
        type_ok(&b, "run 1 s");
        type_ok(&other, "run 1 s");
        assert_same_state(b.session, other.session, systems[i]);
        bench_close(&b);
        bench_close(&other);
        buffer_free(&saved);
        buffer_free(&again);
    }
}

/* Resuming brings back the runs of several models, with their events. */
TEST(autosaves_bring_back_runs)
{
    struct bench b, other;
    bench_open(&b, false);
    type_ok(&b, "method dop853 tol=1e-9");
    for (size_t i = 0; i < COUNT_OF(systems); i++) {
        type_ok(&b, systems[i]);
        type_ok(&b, "event quarter when t - 0.25 do record; event half when t - 0.5 do 'print t'; "
                    "event half off");
        type_ok(&b, "run 1 s");
    }
    type_ok(&b, "event half when t - 0.5 do 'print t'; event more when t > 0.7 do stop; run 1 s; "
                "continue; continue");
    bench_resume(&b, &other);
    assert_int_equal(other.session->runs.count, b.session->runs.count);
    for (int r = 0; r < b.session->runs.count; r++) {
        const struct run *one = b.session->runs.slot[r]->run,
                         *two = other.session->runs.slot[r]->run;
        b.session->runs.current = other.session->runs.current = r;
        assert_same_state(b.session, other.session, one->scene.preset->row.name);
        assert_true(run_event_records(one) > 0);
        assert_int_equal(run_event_records(one), run_event_records(two));
        for (size_t i = 0; i < run_event_records(one); i++)
            assert_true(run_event_record(one, i)->t == run_event_record(two, i)->t);
    }
    bench_close(&b);
    bench_close(&other);
}

/* Balls that bounce, cells that fire: with what events do to them, runs come back bit for bit from
 * what is saved, what is recorded, and what is undone. */
TEST(jumps_are_done_again)
{
    static const char *const scenes[] = {
        "var y = 1; y'' = -9.81; event bounce when y falling do \"y' = -0.8*y'; continue\"",
        "var u = 0; param I = 1.5; u' = I - u; event fire when u > 1 do 'u = 0; I = 1.01*I; "
        "continue'",
        ("var y = 1; var x = 0; x'' = 0; y'' = -1; event wall when abs(x) > 0.3 do 'vx = -vx; "
         "continue'; var x' = 1; "
         "event floor when y < 0 do 'vy = -vy; y = 0; continue'; event count when x do 'print t; "
         "continue'"),
        "var y = 1; y'' = -9.81; event bounce when y falling do 'print t'"};
    static const char *const methods[] = {"rk4 dt=10ms", "dop853 tol=1e-9", "heun dt=7ms",
                                          "abm4 dt=10ms"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(scenes) * COUNT_OF(methods); i++) {
        struct bench b, other, told;
        char method[40];
        start(&b, scenes[i % COUNT_OF(scenes)]);
        snprintf(method, sizeof method, "method %s", methods[i / COUNT_OF(scenes)]);
        remove("told.hk");
        type_ok(&b, "save scene.hk --force");
        type_ok(&b, "record told.hk");
        type_ok(&b, method);
        type_ok(&b, "run 2 s; continue 1 s; step 3; run 1.5 s --steps 7; continue");
        const struct run *run = session_run(b.session);
        const int64_t steps = run->steps;
        const double y = run->y[0], t = run->t;
        type_ok(&b, "record off");
        bench_resume(&b, &other);
        bench_open(&told, false);
        type_ok(&told, "source scene.hk; source told.hk");
        for (int r = 0; r < b.session->runs.count; r++) {
            b.session->runs.current = other.session->runs.current = told.session->runs.current = r;
            assert_same_state(b.session, other.session, scenes[i % COUNT_OF(scenes)]);
            assert_same_state(b.session, told.session, scenes[i % COUNT_OF(scenes)]);
        }
        type_ok(&b, "undo 2");
        assert_int_equal(b.session->runs.count, 1);
        type_ok(&b, "undo 2; redo 4");
        run = session_run(b.session);
        if (run->steps != steps || run->y[0] != y || run->t != t)
            fail_msg(
                "%s, %s: undone, done again: step %lld of %lld at %.17g, y[0] = %.17g, not %.17g",
                methods[i / COUNT_OF(scenes)], scenes[i % COUNT_OF(scenes)], (long long)run->steps,
                (long long)steps, run->t, run->y[0], y);
        bench_close(&b);
        bench_close(&other);
        bench_close(&told);
    }
}

static void assert_scene_is(struct bench *b, const char *wanted)
{
    struct buffer saved = {0};
    session_save(b->session, &saved);
    assert_string_equal(saved.data, wanted);
    buffer_free(&saved);
}

/* [s] -1: there is no run */
static double time_of(const struct bench *b)
{
    return session_run(b->session) ? session_run(b->session)->t : -1;
}

/* undo and redo go through the states of a definition one by one, with the runs between them. */
TEST(undo_takes_lines_back)
{
    static const char *const lines[] = {"var x = 1",
                                        "x' = -x",
                                        "event half when x - 0.5 do record",
                                        "method rk4 dt=0.01",
                                        "run 1 s",
                                        "param rate = 2",
                                        "x' = -rate*x",
                                        "run 2 s",
                                        "event third when x < 1/3 do stop",
                                        "run 3 s",
                                        "continue to 3 s",
                                        "scene pendulum"};
    struct bench b;
    char *saved[COUNT_OF(lines) + 1];
    double t[COUNT_OF(lines) + 1];
    bench_open(&b, false);
    for (size_t i = 0; i <= COUNT_OF(lines); i++) {
        struct buffer text = {0};
        session_save(b.session, &text);
        saved[i] = text.data;
        t[i] = time_of(&b);
        if (i < COUNT_OF(lines))
            type_ok(&b, lines[i]);
    }
    assert_true(t[10] > 0.5 && t[10] < 0.6 && t[11] == 3.0);
    for (size_t i = COUNT_OF(lines); i > 0; i--) {
        type_ok(&b, "undo");
        assert_scene_is(&b, saved[i - 1]);
        assert_true(t[i - 1] == time_of(&b));
    }
    for (size_t i = 1; i <= COUNT_OF(lines); i++) {
        type_ok(&b, "redo");
        assert_scene_is(&b, saved[i]);
        assert_true(t[i] == time_of(&b));
    }
    for (size_t i = 0; i <= COUNT_OF(lines); i++)
        free(saved[i]);
    bench_close(&b);
}

static void collect(void *context, const char *candidate, const char *brief)
{
    (void)brief;
    buffer_format(context, " %s ", candidate);
}

static void assert_offers(struct bench *b, const char *line, const char *wanted, size_t from)
{
    struct buffer offered = {0};
    size_t begin;
    command_complete(b->session, text_of(line), strlen(line), &begin, collect, &offered);
    assert_says(&offered, wanted);
    assert_int_equal(begin, from);
    buffer_free(&offered);
}

/* The user's names are offered wherever they can stand. */
TEST(names_are_completed)
{
    struct bench b;
    start(
        &b,
        "var angle = 1; param stiffness = 2; angle'' = -stiffness*angle; observe spread = angle^2");
    assert_offers(&b, "angle'' = -sti", " stiffness ", 11);
    assert_offers(&b, "angle'' = -stiffness*an", " angle ", 21);
    assert_offers(&b, "observe more = 2*(spr", " spread ", 18);
    assert_offers(&b, "event top when vang", " vangle ", 15);
    assert_offers(&b, "force -stiff", " stiffness ", 7);
    assert_offers(&b, "set sti", " stiffness ", 4);
    assert_offers(&b, "set angle", " angle0 ", 4);
    assert_offers(&b, "sti", " stiffness ", 0);
    assert_offers(&b, "print spr", " spread ", 6);
    assert_offers(&b, "param stiffness o", " off ", 16);
    assert_offers(&b, "var angle of", " off ", 10);
    if (!is_left_out("sweep")) {
        assert_offers(&b, "sweep stiffness=1:2 measure=mi", " min ", 28);
        assert_offers(&b, "sweep stiffness=1:2 measure=max(spr", " spread ", 32);
        assert_offers(&b, "sweep stiffness=1:2 measure=min,max(vang", " vangle ", 36);
    }
    assert_offers(&b, "run until angl", " angle ", 10);
    type_ok(&b, "method rk4; run 1 s");
    assert_offers(&b, "export f.csv spr", " spread ", 13);
    bench_close(&b);
}

/* An operand where one can stand, a unit after a number, nothing where nothing fits. */
TEST(expressions_are_completed)
{
    static const struct {
        const char *line, *with, *without;
        size_t start;
    } cases[] = {
        {"print 2*na", " natural ", " angle ", 8},
        {"print 2 * na", " natural ", " angle ", 10},
        {"print hypot(1, na", " natural ", " angle ", 15},
        {"print (", " angle ", " m ", 7},
        {"print sqrt(ang", " angle ", " sqrt ", 11},
        {"print 3 ", " kg ", " angle ", 8},
        {"print vangle-an", " angle ", " vangle ", 13},
        {"print 2*phase-er", " phase-error ", " energy ", 8},
        {"stiffness = 2*", " angle ", " kg ", 14},
        {"stiffness = natural ", "", " angle ", 20},
        {"let z = natural/sti", " stiffness ", " angle ", 16},
        {"run until angle < sti", " stiffness ", " angle ", 18},
        {"run until angle*", " stiffness ", " s ", 16},
        {"run 2*", " natural ", " s ", 6},
        {"force -stiffness*angle^", " stiffness ", " kg ", 23},
        {"force ", " off ", " rising ", 6},
        {"force -stiffness*angle ", "", " angle ", 23},
        {"angle'' = (", " vangle ", " off ", 11},
        {"angle''=-angle-sti", " stiffness ", " angle ", 15},
        {"angle'' = angle ", "", " angle ", 16},
        {"param stiffness = 2 ", " N/m ", " angle ", 20},
        {"param ", " stiffness ", " spread ", 6},
        {"var ", " angle ", " stiffness ", 4},
        {"observe ", " spread ", " angle ", 8},
        {"observe spread ", " off ", " angle ", 15},
        {"observe more = ", " spread ", " off ", 15},
        {"event ", " top ", " when ", 6},
        {"event top ", " when ", " do ", 10},
        {"event x when ", " angle ", " do ", 13},
        {"event x when angle ", " falling ", " stop ", 19},
        {"event x when angle - ", " spread ", " do ", 21},
        {"event x when angle falling ", " do ", " rising ", 27},
        {"event x when angle do ", " record ", " do ", 22},
        {"event x when angle do stop ", "", " stop ", 27},
        {"event x when angle do 'pri", " print ", " run ", 23},
        {"event x when angle do 'print a; stif", " stiffness ", " angle ", 32},
        {"scene ", " new ", " angle ", 6},
        {"scene new ", "", " damped ", 10},
        {"scene p", " pendulum ", " damped ", 6},
    };
    (void)state;
    struct bench b;
    start(&b, "var angle = 1; param stiffness = 2; param natural = 1; angle'' = -stiffness*angle");
    type_ok(&b, "observe spread = angle^2; force -angle; event top when vangle do record");
    type_ok(&b, "method rk4; run 1 s");
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer offered = {0};
        size_t begin = 0;
        command_complete(b.session, text_of(cases[i].line), strlen(cases[i].line), &begin, collect,
                         &offered);
        buffer_put(&offered, TEXT(""));
        if (!strstr(offered.data, cases[i].with) || strstr(offered.data, cases[i].without) ||
            begin != cases[i].start || (!cases[i].with[0] && offered.len > 0))
            fail_msg("'%s': start %zu:%s", cases[i].line, begin, offered.data);
        buffer_free(&offered);
    }
    bench_close(&b);
}

/* Whatever is typed gets its answer at once, and leaves the session as it was. */
TEST(hostile_lines_are_refused_quickly)
{
    enum { MANY = 1000000 };
    const char *config = getenv("CONFIG");
    /* [ns] of work: ten times what it takes */
    const int64_t limit = config && strcmp(config, "asan") == 0 ? 20000000000 : 2000000000;
    static const struct {
        const char *before, *repeated, *after;
    } hostile[] = {{"x' = ", "(", ""},
                   {"x' = ", "(", "1"},
                   {"x' = ", "-", "x"},
                   {"x' = ", "x^", "x"},
                   {"x' = ", "sin(", "x"},
                   {"x' = ", "x+", "x"},
                   {"x' = ", "x", ""},
                   {"x", "'", " = x"},
                   {"observe E = ", "if(x,", "1"},
                   {"force ", "(", "y"},
                   {"potential ", "1+", "y"},
                   {"event e when ", "(", " do stop"},
                   {"event e when x do '", "a", "'"},
                   {"var ", "v", " = 1"},
                   {"param ", "p", " = 1"},
                   {"var z = ", "(", "1"},
                   {"event ", "e", " when x do stop"}};
    struct bench b;
    start(&b, "var x = 1; x' = -x");
    struct buffer saved = {0};
    session_save(b.session, &saved);
    for (size_t i = 0; i < COUNT_OF(hostile); i++) {
        struct buffer line = {0};
        buffer_put(&line, text_of(hostile[i].before));
        while (line.len < MANY)
            buffer_put(&line, text_of(hostile[i].repeated));
        buffer_put(&line, text_of(hostile[i].after));
        const int64_t begin = cpu_ns();
        assert_false(line.failed || command_exec(b.session, buffer_text(&line), NULL, &b.reply));
        if (cpu_ns() - begin > limit)
            fail_msg("%s%s… took %.0f ms", hostile[i].before, hostile[i].repeated,
                     (double)(cpu_ns() - begin) * 1e-6);
        assert_scene_is(&b, saved.data);
        buffer_free(&line);
    }
    buffer_free(&saved);
    bench_close(&b);
}

/* An error points at its place in the line. */
TEST(errors_have_their_caret)
{
    static const struct {
        const char *line, *caret;
    } wrong[] = {
        {"x' = -rat*x", "    x' = -rat*x\n          ^~~"},
        {"y' = 3", "    y' = 3\n    ^"},
        {"observe E = x*(1 + zz)", "    observe E = x*(1 + zz)\n                       ^~"},
        {"event top when 2*q do stop", "    event top when 2*q do stop\n                     ^"},
        {"var pi = 3", "    var pi = 3\n        ^~"},
        {"x' = x x", "    x' = x x\n           ^"}};
    struct bench b;
    start(&b, "var x = 1; param rate = 2");
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        assert_false(type(&b, wrong[i].line));
        assert_says(&b.err, wrong[i].caret);
    }
    bench_close(&b);
}

/* What `record` and the story write leads to the same runs: commands of events are executed once.
 */
TEST(recorded_sessions_are_the_same)
{
    struct bench b, other;
    bench_open(&b, false);
    type_ok(&b, "record kept.hk");
    type_ok(
        &b,
        "var y = 1; y'' = -y; param grow = 0; event low when y < 0 do 'change grow 1; print grow'");
    type_ok(&b, "y'' = -y + grow*y'; method rk4 dt=0.01; run 3 s");
    assert_says(&b.out, "grow = 1");
    type_ok(&b, "continue 1 s");
    type_ok(&b, "record off");
    bench_open(&other, false);
    type_ok(&other, "source kept.hk");
    assert_int_equal(other.session->runs.count, 1);
    assert_same_state(b.session, other.session, "recorded");
    struct buffer script = {0};
    history_put(b.session, 0, HISTORY_SCRIPT, &script);
    write_file("story.hk", script.data, script.len);
    buffer_free(&script);
    bench_close(&other);
    bench_open(&other, false);
    type_ok(&other, "source story.hk");
    assert_same_state(b.session, other.session, "story");
    bench_close(&other);
    bench_close(&b);
}

/* The steps of dop853 are long; what is drawn goes through what lies between them. Observed
 * quantities keep to rows. */
TEST(adaptive_curves_are_smooth)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b,
            "scene spring; var x = 1; x'' = -x; observe E = x^2 + x'^2; method dop853; run 6 s");
    for (int k = 0; k < 3; k++) {
        struct arena arena = {0};
        struct figure figure;
        struct error error;
        const int run = 0;
        const struct text name = TEXT("E");
        const struct figure_request request = {.kind = k == 1 ? PLOT_PHASE : PLOT_POSITION,
                                               .column = k == 2 ? &name : NULL,
                                               .columns = k == 2,
                                               .run = &run,
                                               .runs = 1,
                                               .recording = -1,
                                               .width = 80,
                                               .window = {NAN, NAN}};
        assert_true(session_figure(b.session, &request, &arena, &figure, &error));
        const struct curve *curve = &figure.curve[0];
        assert_true(k == 2 ? curve->n < 50 : curve->n > 200);
        for (size_t i = 0; i < curve->n; i++) {
            const double wanted =
                k == 0   ? cos(curve->x[i])
                : k == 1 ? copysign(sqrt(fmax(0, 1 - curve->x[i] * curve->x[i])), curve->y[i])
                         : 1;
            assert_true(fabs(curve->y[i] - wanted) < (k == 2 ? 1e-5 : k ? 0.05 : 2e-3));
        }
        arena_reset(&arena);
    }
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
