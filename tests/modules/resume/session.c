/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session from its file gives the same exports. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>

#include "modules/resume/testing.h"

static void assert_same_files(const char *a, const char *b, const char *what)
{
    struct buffer one = {0}, two = {0};
    struct error error;
    assert_true(file_read(a, 1 << 28, &one, &error) && file_read(b, 1 << 28, &two, &error));
    if (!text_equal(buffer_text(&one), buffer_text(&two)))
        fail_msg("%s: the exports differ", what);
    buffer_free(&one);
    buffer_free(&two);
}

static void write_recording(void)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("time\tdistance\ns\tcm\n"));
    for (int i = 0; i < 400; i++)
        buffer_format(&text, "%.2f\t%.4f\n", 0.02 * i, 20 + 5 * cos(8.66 * 0.02 * i));
    write_file("swing.txt", text.data, text.len);
    buffer_free(&text);
}

static void export_all(struct bench *b, const char *prefix)
{
    char line[120];
    snprintf(line, sizeof line, "export %sruns.csv run all t,y,v,energy,work --force", prefix);
    type_ok(b, line);
    snprintf(line, sizeof line, "export %sone.csv --force", prefix);
    type_ok(b, line);
    for (int i = 0; i < b->session->runs.count; i++) { /* with its own header */
        snprintf(line, sizeof line, "export %srun%d.csv run %d --force", prefix, i,
                 b->session->runs.slot[i]->run->number);
        type_ok(b, line);
    }
}

TEST(resumed_sessions_export_the_same)
{
    static const char *const sessions[] = {
        "run 1.2345 s",
        "m = 199.9 +- 0.1 g; gamma = 0.07; method rk4; run 3 s; continue 0.777 s; step 5; note "
        "first; rename 1 a; k = "
        "20; method verlet dt=3ms; run; use 1",
        "method dopri5 tol=1e-9; run 2 s; step 3; continue 1 s; back 4; continue 2 s",
        "method dopri5; run 5 s --steps 17; continue; step; reset; step 3",
        "run until y < 0; continue until v > 0; continue 1 s",
        "scene damped; run 3.2 s; change gamma 0.5 1/s; continue to 6 s; change k 20; continue 1 s",
        "run 10 s --steps 400; change gamma 0.3; continue; step 2; change T0 0.5",
        "t0 = 2; run to -3; continue 1 s; step 4",
        "compare euler verlet rk4 dt=10ms,5ms; compare dopri5 tol=1e-6,1e-9; drop 2; run; drop 4",
        "method euler; dt = 2; duration = 1e5; compare euler; duration = 10; run 1 s",
        "gamma = 0.2; method verlet drag=implicit; run 2 s; record all; set record every 3; run 2 "
        "s; set record auto; "
        "run 1 s",
        "run 1 s; reset; change gamma 0.2; continue 2 s",
        "set record every 70 ms; method dop853 tol=1e-9; run 2 s; continue 0.1 s; back 3; continue "
        "1 s; change k 20; "
        "step 2; back 1; back 2",
        "set record every 70 ms; dt = 3 ms; method rk4; run 2 s; back 5; continue 1 s; back 2; "
        "change k 20; step 2; "
        "continue 1 s",
        "set record every 50 ms; method verlet; run 2.003 s; back 5; continue 1 s",
        "run 5 s; back 100; continue 2 s; back 3",
        "run 1 s; reset",
        "load swing.txt as=x; data window 1:4; data zero 0.2; run 1 s; layout duo; window 5; trail "
        "all; focus energy "
        "full; range y 0:1mJ",
        ("set fps 5; run 1 s; load swing.txt; load swing.txt as=z; data use swing; let A = 4.2 cm; "
         "set digits 4"),
    };
    write_recording();
    for (size_t i = 0; i < COUNT_OF(sessions); i++) {
        struct bench b, again;
        char other[32];
        if (is_left_out(sessions[i]))
            continue;
        bench_open(&b, false);
        b.session->options.keep_going = true;
        struct text rest = text_of(sessions[i]), statement;
        while (text_split(
            &rest, ';', &statement)) { /* one by one: a run that diverges is part of the session */
            char line[200];
            snprintf(line, sizeof line, "%.*s", (int)statement.len, statement.data);
            type(&b, line);
            if (b.session->execution.status != 0 && !strstr(said(&b.err), "diverged") &&
                !strstr(line, "record all"))
                fail_msg("'%s': %s", line, said(&b.err));
            b.session->execution.status = 0;
        }
        export_all(&b, "a");
        bench_resume(&b, &again);
        assert_int_equal(again.session->runs.count, b.session->runs.count);
        export_all(&again, "b");
        assert_same_files("aruns.csv", "bruns.csv", sessions[i]);
        assert_same_files("aone.csv", "bone.csv", sessions[i]);
        for (int r = 0; r < b.session->runs.count; r++) {
            char mine[32];
            snprintf(mine, sizeof mine, "arun%d.csv", r);
            snprintf(other, sizeof other, "brun%d.csv", r);
            assert_same_files(mine, other, sessions[i]);
        }
        assert_int_equal(again.session->data_is_latest, b.session->data_is_latest);
        assert_int_equal(again.session->recordings, b.session->recordings);
        assert_int_equal(again.session->current_recording, b.session->current_recording);
        assert_int_equal(again.session->view.layout, b.session->view.layout);
        assert_int_equal(again.session->view.full, b.session->view.full);
        assert_true(again.session->view.trail == b.session->view.trail &&
                    again.session->view.window == b.session->view.window);
        bench_close(&b);
        bench_close(&again);
    }
}

/* `save` is the set-up only, and no view where there is nothing particular. */
TEST(save_has_no_runs)
{
    struct bench b;
    struct buffer text = {0};
    bench_open(&b, false);
    type_ok(&b, "run 1 s; gamma = 0.1");
    session_save(b.session, &text);
    assert_null(strstr(said(&text), "run"));
    assert_null(strstr(said(&text), "layout"));
    assert_says(&text, "gamma = 0.1 1/s");
    buffer_clear(&text);
    type_ok(&b, "layout log");
    session_save(b.session, &text);
    assert_says(&text, "layout log\n");
    buffer_free(&text);
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
