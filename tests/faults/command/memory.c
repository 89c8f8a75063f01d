/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Running out of memory ends a command, not the session: allocations of a long script, and of the
 * examples of commands that do not occur in it, fail one by one, once and for ever. */
#include "cmocka_testing.h"

#include <gsl/gsl_errno.h>

#include "long_form.h"
#include "faults/failing_malloc.h"
#include "terminal/folder.h"
#include "unit/command/testing.h"

/* NULL: what follows is done in a session of its own. */
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
    NULL,
    "run 3 s; layout quad; focus phase; range y -1:1; zoom 2; pan 1 s; window 1 s; overlay off",
    "trail 3; scroll 3; cursor; cursor A 1 s; cursor off; describe phase; clear",
    "screenshot s.txt --force; pause; speed 2; reset; step 5",
    "redraw",
    "plain",
    "panes",
    NULL,
    "lab resonance; hint; check 8.7 rad/s; skip; again; recipe start",
    NULL,
    "load swing.txt; m = 200 g; fit damped; report first --force",
    NULL,
    "var x = 1; param r = -1; equation x' = r*x-x^3; atol x=1e-9; method dopri5; run 1 s",
    "equilibria; branch r=-1:1; list branches; export b.csv table of branch --force",
    NULL,
    "scene new well; var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v; equilibria x=-2:2 v=-2:2",
    "lyapunov 1 over 5 s; start x=1,v=0; plot portrait > q.txt --force; start clear",
    NULL,
    "scene vanderpol; orbit; list orbits; equilibria; run 1 s; plot phase > o.txt --force",
    NULL,
    "scene new well; var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v; basins x=-1:1:1 v=-1:1:1",
    NULL,
    "timing off; precision rk4 verlet dt=50ms:100ms",
    NULL,
    "collect counts.txt for=1s; calibrate y 20 cm 40 cm; zero; stop",
    "quit",
    NULL,
};

/* For the long form. */
static const char *const slow_lines[] = {"selftest", NULL};

/* Returns how many lines fail up to the next NULL. */
static int run_chapter(struct bench *b, const char *const *line)
{
    int failures = 0;
    for (; *line; line++) {
        buffer_clear(&b->out);
        buffer_clear(&b->err);
        failures += !command_exec(b->session, text_of(*line), NULL, &b->reply);
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
    b->session->execution.quit = b->reply.failed = b->out.failed = b->err.failed = false;
    buffer_free(&b->out);
    buffer_free(&b->err);
    type_ok(b, "set format text");
    type_ok(b, "scene spring; event off; method rk4 dt=10ms; run 1 s; print t");
    assert_says(&b->out, "1 s");
    while (b->session->undo.undos > 0)
        type_ok(b, "undo");
    while (b->session->undo.redos > 0)
        type_ok(b, "redo");
    type_ok(b, "print t");
    struct buffer saved = {0};
    session_save(b->session, &saved);
    assert_false(saved.failed);
    buffer_free(&saved);
}

/* Files that the script reads. */
static void write_files(void)
{
    FILE *swing = fopen("swing.txt", "w"), *counts = fopen("counts.txt", "w");
    assert_non_null(swing);
    assert_non_null(counts);
    fputs("time\tdistance\ns\tcm\n", swing);
    for (int i = 0; i < 200; i++) {
        const double t = 0.02 * i, y = 20 + 5 * exp(-0.1 * t) * cos(8.66 * t);
        fprintf(swing, "%.2f\t%.4f\n", t, y);
        fprintf(counts, "%.2f,%.3f\n", t, y);
    }
    fclose(swing);
    fclose(counts);
}

struct tally {
    int mistakes;
    long calls, noticed;
};

/* Fails allocations of the lines up to the next NULL, each time in a session of its own. */
static void fail_chapter(const char *const *line, struct tally *tally)
{
    enum { POINTS = 7 };
    struct bench b;
    assert_non_null(open_session(&b));
    malloc_calls = 0;
    const int mistakes = run_chapter(&b, line);
    const long calls = malloc_calls, step = is_long() || calls < POINTS ? 1 : calls / POINTS;
    bench_close(&b);
    for (int for_ever = 0; for_ever < 2; for_ever++)
        for (long at = for_ever; at < calls; at += step) {
            malloc_fail_at = at;
            malloc_fail_for_ever = for_ever != 0;
            malloc_calls = 0;
            if (open_session(&b)) {
                tally->noticed += run_chapter(&b, line) > mistakes;
                assert_alive(&b);
                bench_close(&b);
            }
            malloc_fail_at = -1;
        }
    tally->mistakes += mistakes;
    tally->calls += calls;
}

/* If any allocation fails, once or from then on, commands fail with an error, and the session
 * remains usable. Without failures the lines contain 8 intended mistakes. */
TEST(every_allocation_may_fail)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has an allocator of its own\n");
        skip();
    }
    struct tally tally = {.calls = 0};
    write_files();
    for (size_t i = 0; i < COUNT_OF(lines); i++)
        if (i == 0 || !lines[i - 1])
            fail_chapter(&lines[i], &tally);
    if (is_long())
        fail_chapter(slow_lines, &tally);
    print_message("%ld allocations, %ld failures seen as failed commands\n", tally.calls,
                  tally.noticed);
    assert_int_equal(tally.mistakes, 4 + 3 + 1); /* three want a terminal, one is quit */
    assert_true(tally.calls > 500);
    assert_true(tally.noticed > 0);
}

/* Returns true if a statement of the line begins with the word. */
static bool has_statement(const char *line, struct text name)
{
    struct text rest = text_of(line), statement;
    while (text_split(&rest, ';', &statement)) {
        statement = text_trim(statement);
        if (text_starts(statement, name) &&
            (statement.len == name.len || statement.data[name.len] == ' '))
            return true;
    }
    return false;
}

static bool is_in_script(struct text name)
{
    bool found = has_statement(slow_lines[0], name);
    for (size_t i = 0; i < COUNT_OF(lines) && !found; i++)
        found = lines[i] && has_statement(lines[i], name);
    return found;
}

/* The examples of a command's row as a chapter: each runs by itself. */
static void fail_examples(const struct command *command, struct tally *tally)
{
    struct arena arena = {0};
    struct text examples = text_of(command->examples), line;
    while (text_split(&examples, '\n', &line)) {
        const char *const chapter[] = {arena_text(&arena, line), NULL};
        fail_chapter(chapter, tally);
    }
    arena_reset(&arena);
}

/* A command that is new is tested without a line here. */
TEST(every_allocation_of_examples_may_fail)
{
    if (!MALLOC_CAN_FAIL)
        skip();
    struct tally tally = {.calls = 0};
    struct buffer names = {0};
    for (size_t i = 0; i < command_catalog.count; i++) {
        const struct row *row = catalog_row(&command_catalog, i);
        if (is_in_script(text_of(row->name)))
            continue;
        fail_examples(command_at(row), &tally);
        buffer_format(&names, " %s", row->name);
    }
    print_message("%ld allocations, %ld failures seen as failed commands:%s\n", tally.calls,
                  tally.noticed, said(&names));
    buffer_free(&names);
    assert_int_equal(tally.mistakes, 0);
}

/* GSL's own handler ends the program, and it is called where memory is out. */
TEST(gsl_returns_its_errors)
{
    gsl_error_handler_t *const first = gsl_set_error_handler_off(), *const off =
                                                                        gsl_set_error_handler_off();
    assert_true(first == off);
}

/* With the folder of the report. */
static int leave_folders(void **state)
{
    nftw("first", remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    return leave_folder(state);
}

RUN_TESTS(enter_folder, leave_folders)
