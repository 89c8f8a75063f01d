/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random sessions: what is saved comes back, what is undone is as it was, what was recorded does it
 * again. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>
#include <hooke/base/file.h>

#include "long_form.h"
#include "modules/resume/testing.h"
#include "unit/command/random_session.h"

static int sessions(void)
{
    return is_long() ? 300 : 20;
}

/* ---- what has to hold ---- */

static void save(const struct session *session)
{
    struct buffer text = {0};
    session_save(session, &text);
    assert_false(text.failed);
    write_file("saved.hk", text.data, text.len);
    buffer_free(&text);
}

/* In a new session. */
static void read_back(struct bench *again, const struct buffer *typed)
{
    struct buffer content = {0};
    struct error error;
    struct text rest, line;
    assert_true(file_read("saved.hk", 1 << 20, &content, &error));
    bench_open(again, false);
    rest = buffer_text(&content);
    while (text_split(&rest, '\n', &line))
        if (!command_exec(again->session, line, NULL, &again->reply)) {
            fprintf(stderr, "%s\n", said(typed));
            fail_msg("saved.hk: %s", said(&again->err));
        }
    buffer_free(&content);
}

TEST(what_is_saved_comes_back)
{
    struct buffer typed = {0}, wanted = {0}, got = {0};
    write_recordings();
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        bench_open(&b, false);
        play(&b, (uint64_t)i, &typed);
        const unsigned view = !b.session->view.focus ? PART_VIEW : 0;
        save(b.session);
        read_back(&again, &typed);
        describe(b.session, PART_SETUP | PART_RECORDINGS | view, &wanted);
        describe(again.session, PART_SETUP | PART_RECORDINGS | view, &got);
        assert_same(&wanted, &got, "saved", &typed);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

static void assert_step(struct bench *b, const char *statement, unsigned parts,
                        const struct buffer *wanted, const struct buffer *typed)
{
    struct buffer now = {0};
    type_ok(b, statement);
    describe(b->session, parts, &now);
    if (wanted->len > 0)
        assert_same(wanted, &now, statement, typed);
    buffer_free(&now);
}

TEST(a_resumed_session_is_the_same)
{
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_CURRENT | PART_NOTES;
    struct buffer typed = {0}, wanted = {0}, got = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        bench_open(&b, false);
        play(&b, 2000 + (uint64_t)i, &typed);
        const unsigned view = b.session->runs.count > 0 || !b.session->view.focus ? PART_VIEW : 0;
        bench_resume(&b, &again);
        describe(b.session, parts | view, &wanted);
        describe(again.session, parts | view, &got);
        assert_same(&wanted, &got, "resumed", &typed);
        for (int r = 0; r < b.session->runs.count; r++)
            if (stop_is_pause(b.session->runs.slot[r]->run->stop) &&
                !stop_is_pause(again.session->runs.slot[r]->run->stop))
                fail_msg("run %d was paused", b.session->runs.slot[r]->run->number);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

TEST(undo_and_redo_go_through_the_same_states)
{
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_CURRENT | PART_STOPS;
    static struct buffer at[LINES * 4 + 1];
    struct buffer typed = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b;
        bench_open(&b, false);
        random_state = 1000 + (uint64_t)i;
        buffer_clear(&typed);
        /* empty: in the middle of a line */
        for (int s = 0; s <= LINES * 4; s++)
            buffer_clear(&at[s]);
        describe(b.session, parts, &at[0]);
        for (int s = 0; s < LINES; s++) {
            play_statement(&b, &typed);
            describe(b.session, parts, &at[b.session->undo.undos]);
        }
        const int steps = b.session->undo.undos;
        for (int s = steps; s > 0; s--)
            assert_step(&b, "undo", parts, &at[s - 1], &typed);
        for (int s = 1; s <= steps; s++)
            assert_step(&b, "redo", parts, &at[s], &typed);
        bench_close(&b);
    }
    for (size_t i = 0; i < COUNT_OF(at); i++)
        buffer_free(&at[i]);
    buffer_free(&typed);
}

static void interrupt_it(void *context, const struct run *run, double fraction)
{
    (void)run;
    if (fraction <= 1) /* 2: it is over */
        atomic_store(&((struct cancel *)context)->requested, 1);
}

/* What a person abbreviates stands in the file as it was understood; a run that ended in an error
 * is not in it, and such sessions are left out here. */
TEST(what_was_recorded_does_it_again)
{
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_VIEW | PART_STOPS;
    struct buffer typed = {0}, wanted = {0}, got = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        remove("kept.hk");
        bench_open(&b, true);
        type_ok(&b, "record kept.hk");
        type_ok(&b, "meth verlet; set kernel gen");
        play(&b, 3000 + (uint64_t)i, &typed);
        type_ok(&b, "record off");
        bench_open(&again, false);
        if (!history_fails(b.session) && !type(&again, "source kept.hk")) {
            fprintf(stderr, "%s\n", said(&typed));
            fail_msg("kept.hk: %s", said(&again.err));
        }
        describe(b.session, parts, &wanted);
        describe(again.session, parts, &got);
        if (!history_fails(b.session))
            assert_same(&wanted, &got, "recorded", &typed);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

#define TABLE "time\tdistance\ns\tcm\n0\t1\n0.1\t2\n0.2\t1\n0.3\t2\n"

static void move_file(const char *from, const char *to)
{
    assert_int_equal(rename(from, to), 0);
}

/* A recording that has changed since is told; one that was moved is found, if it is the same. */
TEST(saved_recordings_are_known_again)
{
    struct bench b, again;
    write_recordings();
    write_file("./gone.txt", TABLE "0.4\t1\n", strlen(TABLE) + 6);
    bench_open(&b, false);
    type_ok(&b, "load swing.txt as=one; load ./gone.txt as=two");
    save(b.session);
    bench_close(&b);
    bench_open(&again, false);
    type_ok(&again, "source saved.hk");
    assert_string_equal(said(&again.err), "");
    move_file("gone.txt", "there.txt");
    assert_false(type(&again, "source saved.hk"));
    assert_says(&again.err, "cannot read");
    assert_says(&again.err, "next to the command file");
    move_file("there.txt", "gone.txt");
    write_file("swing.txt", TABLE "0.4\t1\n", strlen(TABLE) + 6);
    type_ok(&again, "source saved.hk");
    assert_says(&again.err, "one has changed since");
    assert_null(strstr(said(&again.err), "two has changed"));
    assert_false(type(&again, "load gone.txt sum=12"));
    assert_says(&again.err, "16 digits");
    bench_close(&again);
    remove("gone.txt");
}

/* The folder that a session was saved in, with its recordings, under another name. */
TEST(moved_recordings_are_found)
{
    struct bench b, again;
    char command[128];
    assert_int_equal(system("rm -rf first second; mkdir first first/data"), 0); /* a test may */
    write_file("first/data/r.txt", TABLE "0.4\t1\n", strlen(TABLE) + 6);
    bench_open(&b, false);
    snprintf(command, sizeof command, "load %s/first/data/r.txt as=two", bench_folder);
    type_ok(&b, command);
    save(b.session);
    bench_close(&b);
    assert_int_equal(system("mv first second; mv saved.hk second/data"), 0);
    bench_open(&again, false);
    type_ok(&again, "source second/data/saved.hk");
    assert_says(&again.err, "found as second/data/r.txt");
    write_file("second/data/r.txt", TABLE "0.4\t9\n", strlen(TABLE) + 6);
    assert_false(type(&again, "source second/data/saved.hk")); /* another one */
    bench_close(&again);
    assert_int_equal(system("rm -r second"), 0);
}

/* A parameter that is not chosen any more is not chosen where the file is read, either, also where
 * it changed a run that waits. */
TEST(what_is_unset_is_recorded_so)
{
    struct bench b, again;
    struct buffer wanted = {0}, got = {0};
    remove("kept.hk");
    bench_open(&b, true);
    type_ok(&b, "record kept.hk");
    type_ok(&b, "k = 20; event at when t > 0.3 do stop; run 1 s; step 1");
    assert_true(stop_is_pause(b.session->runs.slot[0]->run->stop));
    type_ok(&b, "unset k");
    type_ok(&b, "continue 0.1 s; record off");
    bench_open(&again, false);
    type_ok(&again, "source kept.hk");
    describe(b.session, PART_SETUP | PART_RUNS, &wanted);
    describe(again.session, PART_SETUP | PART_RUNS, &got);
    assert_same(&wanted, &got, "recorded", &wanted);
    bench_close(&again);
    bench_close(&b);
    buffer_free(&wanted);
    buffer_free(&got);
}

/* An interrupted run is an error that leaves a run: the file has it as far as it went, so that what
 * goes on with it does so. */
TEST(an_interrupted_run_is_recorded)
{
    struct cancel cancel = {0};
    struct bench b, again;
    remove("kept.hk");
    bench_open(&b, false);
    b.session->front.cancel = &cancel;
    b.session->front.context = &cancel;
    b.session->front.progress = interrupt_it;
    type_ok(&b, "record kept.hk");
    assert_false(type(&b, "dt = 1e-6; run 1000 s --force"));
    atomic_store(&cancel.requested, 0);
    type_ok(&b, "step 3");
    type_ok(&b, "record off");
    bench_open(&again, false);
    type_ok(&again, "source kept.hk");
    assert_int_equal(again.session->runs.slot[0]->run->steps, b.session->runs.slot[0]->run->steps);
    bench_close(&again);
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
