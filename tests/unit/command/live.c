/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs that a person watches: pace, pauses, what may be typed meanwhile, and that the samples are
 * those of a batch run.
 */
#include "cmocka_testing.h"
#include <time.h>

#include <hooke/base/file.h>
#include <hooke/base/cancel.h>

#include "modules/resume/testing.h"

/* A front end whose slice executes a line at some of its calls, or once the run has got so far. */
struct watcher {
    struct bench bench;
    struct {
        int at; /* number of the call, counted from 1; 0: the first at or after this step */
        int64_t step;
        const char *line; /* NULL: returns false, which pauses */
        bool done;
    } script[12];
    int lines, calls;
    enum live_state seen; /* during the last call */
    bool failed;          /* a line failed */
    struct cancel cancel;
    int cancel_at; /* number of the call that sets it, 0: none */
    long pause_ns; /* how long a slice takes */
};

static bool watch(void *context, struct session *session, int64_t until)
{
    struct watcher *w = context;
    (void)until;
    w->calls++;
    w->seen = session->live.state;
    nanosleep(&(struct timespec){.tv_nsec = w->pause_ns}, NULL);
    if (w->calls == w->cancel_at)
        atomic_store(&w->cancel.requested, 1);
    for (int i = 0; i < w->lines; i++) {
        const struct run *run = session->runs.slot[session->runs.current]->run;
        const bool due = w->script[i].at ? w->script[i].at == w->calls
                                         : !w->script[i].done && run->steps >= w->script[i].step;
        if (!due)
            continue;
        w->script[i].done = true;
        if (!w->script[i].line)
            return false;
        /* The same reply as that of the command that goes on. */
        if (!command_exec(session, text_of(w->script[i].line), NULL, &w->bench.reply))
            w->failed = true;
    }
    return true;
}

static void watcher_open(struct watcher *w)
{
    *w = (struct watcher){.lines = 0};
    const struct front front = {
        .interactive = true, .watched = true, .context = w, .slice = watch, .cancel = &w->cancel};
    w->bench.session = session_create(&front);
    reply_init(&w->bench.reply, (struct sink){bench_out, bench_err, &w->bench});
    assert_non_null(w->bench.session);
    type_ok(&w->bench, "speed max; method rk4");
}

static void at(struct watcher *w, int call, const char *line)
{
    w->script[w->lines].at = w->calls + call;
    w->script[w->lines++].line = line;
}

static void from_step(struct watcher *w, int64_t step, const char *line)
{
    w->script[w->lines].step = step;
    w->script[w->lines++].line = line;
}

static void assert_same_files(const char *a, const char *b)
{
    struct buffer one = {0}, two = {0};
    struct error error;
    assert_true(file_read(a, 1 << 28, &one, &error) && file_read(b, 1 << 28, &two, &error));
    assert_true(one.len > 100);
    assert_int_equal(one.len, two.len);
    assert_memory_equal(one.data, two.data, one.len);
    buffer_free(&one);
    buffer_free(&two);
}

/* Commands before, export after, in a session without a screen. */
static void batch(const char *lines, const char *file)
{
    struct bench b;
    char line[80];
    bench_open(&b, false);
    type_ok(&b, lines);
    snprintf(line, sizeof line, "export %s y,v,energy,work --force", file);
    type_ok(&b, line);
    bench_close(&b);
}

/*
 * Few rows, so that the files are small. At speed 1 it cannot be over before somebody has paused
 * it. Not by the propagator: that does not give the same bits after going back to a row in the
 * middle of its block.
 */
#define LONG_RUN "set kernel specialised; set record every 20; gamma = 0.1; dt = 1e-4; run 20 s"

/* Few rows of many steps. */
#define ENDLESS "set record every 1000; dt = 1e-6; run 1000 s"

TEST(watched_run_exports_the_same_bytes)
{
    struct watcher w;
    watcher_open(&w);
    from_step(&w, 200, NULL);
    type_ok(&w.bench, "speed 1; " LONG_RUN);
    assert_says(&w.bench.out, "'speed max' runs as fast as possible");
    assert_says(&w.bench.out, "paused at t = ");
    assert_int_equal(w.seen, LIVE_RUNNING);
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    const struct run *run = w.bench.session->runs.slot[0]->run;
    assert_true(run->steps >= 200 && run->t < 20);
    from_step(&w, run->steps + 100, "pause");
    type_ok(&w.bench, "continue");
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    type_ok(&w.bench, "step 3");
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    type_ok(&w.bench, "back 2");
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    type_ok(&w.bench, "speed max; continue");
    assert_int_equal(w.bench.session->live.state, LIVE_IDLE);
    assert_true(run->t == 20);
    type_ok(&w.bench, "export watched.csv y,v,energy,work --force");
    bench_close(&w.bench);
    batch("method rk4; " LONG_RUN, "batch.csv");
    assert_same_files("watched.csv", "batch.csv");
}

TEST(adaptive_and_until_go_on_after_a_pause)
{
    static const char *const runs[] = {
        "set record every 20; method dopri5 tol=1e-13; gamma = 0.01; run 300 s",
        "set record every 20; dt = 1e-6; run until t > 0.23456789"};
    for (size_t i = 0; i < COUNT_OF(runs); i++) {
        struct watcher w;
        char line[120];
        watcher_open(&w);
        at(&w, 1, NULL);
        type_ok(&w.bench, runs[i]);
        assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
        type_ok(&w.bench, "continue");
        assert_int_equal(w.bench.session->live.state, LIVE_IDLE);
        type_ok(&w.bench, "export watched.csv --force");
        bench_close(&w.bench);
        struct bench b;
        bench_open(&b, false);
        snprintf(line, sizeof line, "method rk4; %s; export batch.csv --force", runs[i]);
        type_ok(&b, line);
        bench_close(&b);
        assert_same_files("watched.csv", "batch.csv");
    }
}

/* At speed 2, 0.3 simulated seconds take about 0.15 s; at most one step more than the clock allows
 * is there at any time. */
TEST(follows_the_clock)
{
    struct watcher w;
    watcher_open(&w);
    type_ok(&w.bench, "speed 2; dt = 5ms");
    const struct session *session = w.bench.session;
    int calls = 0;
    for (int tries = 0; tries < 5 && calls <= 20; tries++) { /* it catches up with what it missed */
        const int before = w.calls;
        const int64_t begin = clock_ns();
        type_ok(&w.bench, "run 0.3 s");
        const double took = (double)(clock_ns() - begin) * 1e-9;
        assert_true(took > 0.14);
        assert_true(session->runs.slot[session->runs.count - 1]->run->t == 0.3);
        calls = w.calls - before;
    }
    assert_true(calls > 20);
    /* A file is not waited for. */
    write_file("quick.hk", "run 1000 s\n", 11);
    type_ok(&w.bench, "source quick.hk");
    assert_true(session->runs.slot[session->runs.count - 1]->run->t == 1000);
    bench_close(&w.bench);
}

TEST(says_what_it_achieves)
{
    struct watcher w;
    watcher_open(&w);
    w.pause_ns = 30000000; /* a slow front end */
    type_ok(&w.bench, "set kernel general; dt = 1e-8; speed 100");
    at(&w, 25, "pause");
    type_ok(&w.bench, "run 1000 s");
    const struct live *live = &w.bench.session->live;
    const struct run *run = w.bench.session->runs.slot[0]->run;
    assert_true(run->t < 100);
    assert_true(live->achieved > 0 && live->achieved < 100);
    assert_true(live->fraction > 0 && live->fraction < 0.1);
    bench_close(&w.bench);
}

TEST(refuses_what_would_disturb)
{
    static const char *const refused[] = {
        "run 1 s", "scene damped",  "method verlet", "source x.hk", "load x.txt",
        "adopt",   "compare euler", "fit",           "reset",       "undo",
        "redo",    "restore",       "step",          "back",        "continue",
        "drop 1",  "drop all",      "use 1",         "plain"};
    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        struct watcher w;
        if (is_left_out(refused[i]))
            continue;
        watcher_open(&w);
        at(&w, 1, refused[i]);
        at(&w, 2, "pause");
        type_ok(&w.bench, ENDLESS);
        assert_true(w.failed);
        assert_says(&w.bench.err, "run 1 is still in progress");
        assert_int_equal(w.bench.session->runs.count, 1);
        bench_close(&w.bench);
    }
}

TEST(allows_what_looks)
{
    static const char *const allowed[] = {"show k",
                                          "print t",
                                          "plot position",
                                          "layout duo",
                                          "focus phase",
                                          "help run",
                                          "export seen.csv --force",
                                          "gamma = 0.3",
                                          "set dt 5ms",
                                          "T0 = 0.7 s",
                                          "speed max",
                                          "zoom 2",
                                          "measure drift",
                                          "list methods"};
    for (size_t i = 0; i < COUNT_OF(allowed); i++) {
        struct watcher w;
        watcher_open(&w);
        at(&w, 2, allowed[i]);
        at(&w, 4, "pause");
        type_ok(&w.bench, ENDLESS);
        if (w.failed)
            fail_msg("'%s' while a run goes on: %s", allowed[i], said(&w.bench.err));
        assert_says(&w.bench.out, "paused at");
        bench_close(&w.bench);
    }
}

TEST(cursor_and_quit_pause)
{
    static const char *const lines[] = {"cursor", "quit"};
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        struct watcher w;
        watcher_open(&w);
        at(&w, 5, lines[i]);
        type_ok(&w.bench, ENDLESS);
        assert_false(w.failed);
        assert_int_equal(w.calls, 5);
        assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
        assert_true(w.bench.session->execution.quit == (i == 1));
        bench_close(&w.bench);
    }
}

TEST(cancel_pauses)
{
    struct watcher w;
    watcher_open(&w);
    w.cancel_at = 2;
    type_ok(&w.bench, ENDLESS);
    assert_int_equal(w.calls, 2);
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    assert_int_equal(w.bench.session->execution.status, 0);
    atomic_store(&w.cancel.requested, 0);
    at(&w, 1, "pause");
    type_ok(&w.bench, "continue");
    bench_close(&w.bench);
}

/* A scene of one's own, with an event that makes it jump: what is changed while it goes on and
 * while it is paused, lines that are typed between, all of it comes back from what is saved. */
TEST(a_typed_scene_changes_on_the_way)
{
    struct watcher w;
    watcher_open(&w);
    type_ok(
        &w.bench,
        "scene new ball; var y = 1; param g = 9.81; param r = 0.9; y'' = -g; dt = 1e-4; speed 2");
    type_ok(&w.bench, "event bounce when y falling do \"y' = -r*y'; continue\"");
    from_step(&w, 100, "g = 5");
    from_step(&w, 200, "change y 0.9");
    from_step(&w, 300, "change vy -3*r");
    from_step(&w, 2000, "r = 0.8");
    from_step(&w, 9000, NULL);
    type_ok(&w.bench, "run 5 s");
    assert_false(w.failed);
    assert_int_equal(w.bench.session->live.state, LIVE_PAUSED);
    assert_int_equal(w.bench.session->live.mark_count, 2);
    type_ok(&w.bench, "param c = 0; g = 6; speed max");
    assert_says(&w.bench.out, "g = 6 from t = ");
    type_ok(&w.bench, "c = 1");
    assert_null(strstr(said(&w.bench.out), "from t"));
    type(&w.bench, "change c 2");
    assert_says(&w.bench.err, "run 1 has no c, which was defined later");
    type_ok(&w.bench, "continue");
    const struct run *run = w.bench.session->runs.slot[0]->run;
    assert_true(run->t == 5 && run_event_records(run) > 1);
    struct bench b;
    bench_resume(&w.bench, &b);
    const struct run *again = b.session->runs.slot[0]->run;
    assert_true(again->steps == run->steps && again->t == run->t && again->y[0] == run->y[0] &&
                again->y[1] == run->y[1]);
    bench_close(&b);
    type_ok(&w.bench, "scene pendulum");
    type(&w.bench, "change g 3");
    assert_says(&w.bench.err, "run 1 belongs to ball, but the scene is now pendulum");
    bench_close(&w.bench);
}

/* The rest of a line, of a file and of the file that sourced it waits for the run, and is left out
 * if that is paused.
 */
TEST(pause_ends_line_and_file)
{
    struct watcher w;
    watcher_open(&w);
    type_ok(&w.bench, "dt = 1e-6; run 0.5 s; let after = t");
    assert_true(w.bench.session->setup.let[0].value == 0.5);
    at(&w, 1, NULL);
    type_ok(&w.bench, "run 100 s; let never = 1; let more = 2");
    assert_says(&w.bench.err, "not executed, because the run was paused: let never = 1; ...");
    assert_int_equal(w.bench.session->setup.lets, 1);
    write_file("inner.hk", "run 100 s\nlet inner = 1\n", 24);
    write_file("outer.hk", "source inner.hk\nlet outer = 1\n", 30);
    at(&w, 1, NULL);
    type(&w.bench, "source outer.hk; let last = 1");
    assert_says(&w.bench.err, "stopped at line 1");
    assert_says(&w.bench.err, "not executed, because the run was paused: let last = 1");
    assert_int_equal(w.bench.session->setup.lets, 1);
    assert_int_equal(w.bench.session->execution.status, 0);
    type_ok(&w.bench, "let again = 1"); /* the next line is a new one */
    bench_close(&w.bench);
}

TEST(parameter_changes_on_the_way)
{
    struct watcher w;
    struct error error;
    struct buffer file = {0};
    watcher_open(&w);
    type_ok(&w.bench,
            "record story.hk; set kernel specialised; set record every 20; dt = 1e-4; speed 1");
    from_step(&w, 100, "gamma = 0.5");
    from_step(&w, 200, "set dt 1ms");
    from_step(&w, 300, NULL);
    const int undos = w.bench.session->undo.undos;
    type_ok(&w.bench, "run 5 s");
    assert_false(w.failed);
    assert_int_equal(w.bench.session->undo.undos, undos + 1);
    assert_says(&w.bench.out, "gamma = 0.5 1/s from t = ");
    const struct session *session = w.bench.session;
    assert_int_equal(session->live.mark_count, 1);
    assert_true(session->live.marks[0] > 0 && session->live.marks[0] < 5);
    type_ok(&w.bench, "k = 20; speed max; continue"); /* a paused run follows too */
    assert_true(session->runs.slot[0]->run->t == 5);
    assert_int_equal(session->live.mark_count, 2);
    assert_true(session->runs.slot[0]->run->system.oscillator.damping == 0.5);
    assert_true(session->runs.slot[0]->run->system.oscillator.stiffness == 100);
    type_ok(&w.bench, "export changed.csv y,v,energy,work --force; record off");
    assert_true(file_read("changed.csv", 1 << 28, &file, &error));
    assert_says(&file, "# changed = gamma 0.5 1/s at t = ");
    assert_says(&file, "; k 20 N/m at t = ");
    buffer_free(&file);
    /* What was recorded tells the same story. */
    batch("method rk4; source story.hk", "again.csv");
    assert_same_files("changed.csv", "again.csv");
    /* One undo takes the run back, and what was changed while it went on. */
    type_ok(&w.bench, "k = 30; undo");
    type_ok(&w.bench, "undo 3");
    assert_int_equal(session->runs.count, 0);
    type_ok(&w.bench, "redo 3");
    type_ok(&w.bench, "export changed.csv y,v,energy,work --force");
    assert_same_files("changed.csv", "again.csv");
    bench_close(&w.bench);
}

/* A line typed during a run must not spoil what the run says: neither its record nor its form. */
TEST(replies_stay_apart)
{
    struct watcher w;
    watcher_open(&w);
    type_ok(&w.bench, "set format json; dt = 1e-4; speed 1");
    from_step(&w, 100, "print 1 + 1");
    from_step(&w, 200, "speed max");
    type_ok(&w.bench, "run 3 s");
    struct text rest = buffer_text(&w.bench.out), line;
    int prints = 0, runs = 0;
    while (text_split(&rest, '\n', &line)) {
        prints += text_starts(line, TEXT("{\"kind\":\"print\",\"text\":\"2\""));
        runs += text_starts(line, TEXT("{\"kind\":\"run\",\"run\":1,\"method\":\"rk4\""));
        assert_true(line.len == 0 || (line.data[0] == '{' && line.data[line.len - 1] == '}'));
    }
    assert_int_equal(prints, 1);
    assert_int_equal(runs, 1);
    type_ok(&w.bench, "set format text; speed 1");
    from_step(&w, 100, "set format json");
    from_step(&w, 200, "print 1 + 1");
    from_step(&w, 300, "speed max");
    type_ok(&w.bench, "run 3 s");
    assert_says(&w.bench.out, "{\"kind\":\"print\"");
    assert_says(&w.bench.out, "t = 3 s, 30000 steps, rk4"); /* it began in text */
    bench_close(&w.bench);
}

RUN_TESTS(enter_folder, leave_folder)
