/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Running out of memory ends a command, not the session: allocations of a long script fail one by
 * one, once and for ever. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "long_form.h"
#include "faults/failing_malloc.h"
#include "unit/command/testing.h"

static const char *const lines[] = {
    "m = 199.9 +- 0.1 g; k = 15.1; y0 = 5 cm",
    "set gama 3",
    "set m 5 cm",
    "let A = 4.2 cm; A = 2*A; print sqrt(A)/max(1, 2)",
    "scene damped; show; show all",
    "method verlet dt=10ms; plan",
    "run 3 s; continue 1 s; step 3; back 2; print energy",
    "run until y < 1 cm",
    "undo 2; redo",
    "duration = 1 s; timing off; compare euler verlet rk4",
    "compare dopri5 tol=1e-5",
    "runs; use 1; rename 1 first; note a note; drop 2",
    "checkpoint a; k = 20; restore a",
    "export x.csv --force; export y.tsv run all y,exact every=100ms --force; export t.json table "
    "--force",
    "compare euler verlet > r.csv --force; load r.csv; plot error against dt of loaded",
    "export r.json table of run --force; load r.json; export x.html table of loaded --force",
    "load x.csv as=x; data list; data window 0.5:2.5; data zero 1 mm",
    "fit to x; adopt; run 3 s",
    "measure period; measure decay; measure amplitude windows=3; measure energy; measure k; "
    "measure reynolds",
    "list measurements; export m.csv measurements --force",
    "plot position; plot phase run all; plot energy window=0:1; plot position > p.txt --force",
    "save s.hk --force; source s.hk",
    "record r.hk; echo 'one'; record off; history",
    "help; help run; help verlet; apropos Hairer; list methods; list commands",
    "set format json; run 3 s; fit; measure period; data; show all; set format csv; run 1 s; runs; "
    "set format text",
    "data drop x; drop all; undo; unset k; unset A",
    "scene new decay; var x = 1 m; param rate = 0.5 1/s; x' = -rate*x; observe E = x^2; scene "
    "pendulum; scene decay",
    "x' = -rate*xx",
    "var y = 2; y'' = -y - 0.1*y'; y'' = -y; observe E off",
    "scene new both; var x = 1; x'' = -x; force x = 1; force x = off",
    "force -0.1*x^3 + 0.2*sin(t); potential x^2/2 + 0.025*x^4; force -0.1*x^3; potential x^2/2 + "
    "0.025*x^4; plan; scene",
    "event low when x falling do record; event top when x' falling do record; event low when x < "
    "-0.5 do stop; method dop853; run 5 s; continue",
    "event low when x < -0.5 do \"x' = -x'; print t; continue\"; run 5 s; list events; undo 3; "
    "redo 2; step 3; back 4",
    "change x 0.7; continue 1 s; export e.csv events --force; export f.csv --force; event top off; "
    "event off",
    "timing off; method rk4 dt=10ms; stability; order rk4; run 2 s; save t.hk --force; source t.hk",
    "param a = 2; x'' = -a*x; duration = 1 s; sweep a=1:3; stress scene rk4; undo 4; redo",
    "event e when x + do stop",
    "scene spring; force -5*y^3; run 1 s; force off; undo; scene decay; list scenes",
};

/* The whole script; false if some command failed that does not always fail. */
static int run_all(struct bench *b)
{
    int failures = 0;
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        buffer_clear(&b->out);
        buffer_clear(&b->err);
        failures += !command_exec(b->session, text_of(lines[i]), NULL, &b->reply);
    }
    return failures;
}

static struct session *open_session(struct bench *b)
{
    *b = (struct bench){.full = false};
    b->session = session_create(&(struct front){.interactive = false});
    reply_init(&b->reply, (struct sink){bench_out, bench_err, b});
    return b->session;
}

/* After a failure the session still does what it is told, and its parts fit together. */
static void assert_alive(struct bench *b)
{
    malloc_fail_at = -1;
    b->reply.failed = b->out.failed = b->err.failed = false;
    buffer_free(&b->out);
    buffer_free(&b->err);
    type_ok(b, "set format text");
    type_ok(b, "scene spring; event off; method rk4 dt=10ms; run 1 s; print t");
    assert_says(&b->out, "1 s");
    while (b->session->undos > 0)
        type_ok(b, "undo");
    while (b->session->redos > 0)
        type_ok(b, "redo");
    type_ok(b, "print t");
    struct buffer saved = {0};
    session_save(b->session, &saved);
    assert_false(saved.failed);
    buffer_free(&saved);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has an allocator of its own\n");
        skip();
    }
    struct bench b;
    assert_non_null(open_session(&b));
    malloc_calls = 0;
    const int usual = run_all(&b);
    const long calls = malloc_calls;
    bench_close(&b);
    assert_int_equal(usual, 4); /* the mistakes */
    assert_true(calls > 500);
    const long step = is_long() ? 1 : calls / 10;
    long noticed = 0;
    for (int for_ever = 0; for_ever < 2; for_ever++)
        for (long at = for_ever; at < calls; at += step) {
            malloc_fail_at = at;
            malloc_fail_for_ever = for_ever != 0;
            malloc_calls = 0;
            if (open_session(&b)) {
                noticed += run_all(&b) > usual;
                assert_alive(&b);
                bench_close(&b);
            }
            malloc_fail_at = -1;
        }
    print_message("%ld allocations, %ld failures seen as failed commands\n", calls, noticed);
    assert_true(noticed > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
