/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scripts, exit statuses, refused output, records. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>
#include <hooke/data.h>
#include <sys/stat.h>

#include "unit/command/testing.h"

static bool run_script(struct bench *b, const char *name, const char *bytes, size_t len)
{
    write_file(name, bytes, len);
    buffer_clear(&b->out);
    buffer_clear(&b->err);
    return script_file(b->session, name, NULL, &b->reply);
}

#define SCRIPT(bench, literal) run_script((bench), "s.hk", (literal), sizeof(literal) - 1)

TEST(dialects_of_text_files)
{
    struct bench b;
    bench_open(&b, false);
    assert_true(SCRIPT(&b, "\xEF\xBB\xBFm\t=\t300 g\r\n\trun 1 s \\\r\n\r\n# c \\\nmethod \\\n  "
                           "rk4 \\\n dt=5ms\r\nprint m; print dt"));
    assert_says(&b.out, "m = 300 g");
    assert_says(&b.out, "dt = 5 ms");
    assert_says(&b.out, "\n300 g\n5 ms\n");
    assert_true(SCRIPT(&b, ""));
    assert_true(SCRIPT(&b, "\n\n#\n"));
    assert_int_equal(b.session->execution.status, 0);
    bench_close(&b);
}

TEST(a_script_stops_at_its_first_error)
{
    struct bench b;
    bench_open(&b, false);
    assert_false(SCRIPT(&b, "m = 300 g\nrun 1 s\n\nset gama 3; echo no\nm = 400 g\n"));
    assert_says(&b.err, "s.hk:4:5: error: unknown parameter 'gama'\n    set gama 3; echo no\n      "
                        "  ^~~~\n  did you mean 'gamma'?");
    assert_says(&b.err, "s.hk: stopped at line 4 (2 commands run, run 1 kept)\n");
    assert_null(strstr(said(&b.out), "no\n"));
    assert_true(b.session->setup.scene.value[param_index("m")] == 0.3);
    assert_int_equal(b.session->execution.status, 1);
    bench_close(&b);
}

/* Where it stands in the file: behind what indents it, on the line that continues another. */
TEST(an_error_has_its_place_in_the_file)
{
    static const struct {
        const char *script, *said;
    } cases[] = {
        {"scene new\nvar x = 1\n\t x' = -x*\\\n   2*\\\n    zz\n",
         "s.hk:5:5: error: unknown name 'zz'\n    zz\n    ^~\n"},
        {"  \tset gama 3",
         "s.hk:1:8: error: unknown parameter 'gama'\n    set gama 3\n        ^~~~\n"},
        {"let p = 3; \\\n let q = 2 + cc",
         "s.hk:2:14: error: unknown name 'cc'\n    let q = 2 + cc\n                ^~\n"},
        {"let \xC5\xBC = 3",
         "s.hk:1:5: error: '\xC5\xBC' is not a name\n    let \xC5\xBC = 3\n        ^\n"},
        {"var x = 1\n  x' =  \\\n x + sin(x\n", "s.hk:3:6: error: missing ')'"},
    };
    (void)state;
    struct bench b;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        bench_open(&b, false);
        assert_false(run_script(&b, "s.hk", cases[i].script, strlen(cases[i].script)));
        assert_says(&b.err, cases[i].said);
        bench_close(&b);
    }
}

/* The note on a drive that is off comes at the end, and only if the drive is still off. */
TEST(a_script_may_set_the_frequency_before_the_force)
{
    static const struct {
        const char *script;
        int notes;
    } cases[] = {
        {"scene spring\nomega = 9.06\n", 1},
        {"scene spring\nomega = 9\nomega = 10\nF0 = 1 mN\n", 0},
        {"scene spring\nomega = 9; F0 = 1 mN\n", 0},
        {"scene spring\nF0 = 1 mN\nomega = 9\nF0 = 0\n", 1},
        {"scene spring\nomega = 9\nundo\n", 0},
        {"scene spring\nk = 20 N/m\n", 0},
        {"scene driven\nomega = 9\n", 0},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct bench b;
        int notes = 0;
        bench_open(&b, false);
        assert_true(run_script(&b, "s.hk", cases[i].script, strlen(cases[i].script)));
        for (const char *s = said(&b.err); (s = strstr(s, "drive, which is off")); s++)
            notes++;
        if (notes != cases[i].notes)
            fail_msg("%s: %d notes", cases[i].script, notes);
        bench_close(&b);
    }
}

/* One line that was typed needs no word about where it stopped. */
TEST(a_typed_line_just_fails)
{
    struct bench b;
    struct script script;
    bench_open(&b, true);
    script_begin(&script, b.session, NULL, NULL);
    assert_false(script_feed(&script, b.session, TEXT("set gama 3"), &b.reply));
    assert_false(script_end(&script, b.session, &b.reply));
    assert_says(&b.err, "did you mean 'gamma'?");
    assert_null(strstr(said(&b.err), "stopped"));
    bench_close(&b);
}

TEST(keep_going_goes_on)
{
    struct bench b;
    bench_open(&b, false);
    b.session->options.keep_going = true;
    assert_false(SCRIPT(&b, "m = -1\nload nofile\nm = 400 g\n"));
    assert_true(b.session->setup.scene.value[param_index("m")] == 0.4);
    assert_int_equal(b.session->execution.status, 1);
    assert_null(strstr(said(&b.err), "stopped"));
    bench_close(&b);
}

TEST(the_status_says_what_failed)
{
    static const struct {
        const char *line;
        int status;
    } cases[] = {
        {"echo fine", 0},
        {"m = -1", 1},
        {"foo", 1},
        {"source nofile.hk", 2},
        {"load nofile.txt", 4},
        {"run 1 s; export /nofolder/x.csv", 4},
        {"save s.hk; save s.hk", 4},
        {"dt = 0.5; method euler; run 1e5", 3},
        {"dt = 0.5; method euler; run 1e5 # a comment", 3},
        {"y0 = 0; run 1 s; fit", 1},
        {"method verlet dt=0.5; compare euler verlet", 0},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct bench b;
        if (is_left_out(cases[i].line))
            continue;
        bench_open(&b, false);
        unlink("s.hk");
        type(&b, cases[i].line);
        if (b.session->execution.status != cases[i].status)
            fail_msg("'%s': status %d, not %d: %s", cases[i].line, b.session->execution.status,
                     cases[i].status, said(&b.err));
        bench_close(&b);
    }
}

TEST(a_diverged_run_is_kept_and_explained)
{
    struct bench b;
    bench_open(&b, false);
    assert_false(type(&b, "method verlet; dt = 0.5; run 1000; echo never"));
    assert_says(&b.err, "diverged at t =");
    assert_says(&b.err, "above the stability limit");
    assert_says(&b.err, "try dt <=");
    assert_int_equal(b.session->runs.count, 1);
    type_ok(&b, "undo");
    assert_int_equal(b.session->runs.count, 0);
    bench_close(&b);
}

TEST(nul_bytes_and_long_lines_are_errors)
{
    struct bench b;
    bench_open(&b, false);
    assert_false(SCRIPT(&b, "m = 300 g\nrun\0 1 s\n"));
    assert_says(&b.err, "line 2 contains a NUL byte");
    assert_int_equal(b.session->execution.status, 2);
    assert_true(b.session->setup.scene.value[param_index("m")] == 0.2);
    assert_false(command_exec(b.session, (struct text){"echo a\0b", 8}, NULL, &b.reply));
    assert_says(&b.err, "a NUL byte");

    char *line = malloc(LIMIT_LINE + 2);
    assert_non_null(line);
    memset(line, 'x', LIMIT_LINE + 2);
    memcpy(line, "echo ", 5);
    buffer_clear(&b.err);
    assert_true(command_exec(b.session, (struct text){line, LIMIT_LINE}, NULL, &b.reply));
    assert_false(command_exec(b.session, (struct text){line, LIMIT_LINE + 1}, NULL, &b.reply));
    assert_says(&b.err, "the line is longer than 1048576 bytes");
    /* The caret of a long line comes with its neighbourhood only. */
    buffer_clear(&b.err);
    memset(line, ' ', LIMIT_LINE);
    memcpy(line, "print 1", 7);
    memcpy(line + LIMIT_LINE - 10, "x y", 3);
    assert_false(command_exec(b.session, (struct text){line, LIMIT_LINE}, NULL, &b.reply));
    assert_true(b.err.len < 1000);
    /* Lines joined by backslashes come under the same limit. */
    struct script script;
    script_begin(&script, b.session, "joined", NULL);
    memset(line, 'y', LIMIT_LINE);
    memcpy(line, "echo ", 5);
    line[LIMIT_LINE / 2] = '\\';
    buffer_clear(&b.err);
    for (int i = 0; i < 4; i++)
        script_feed(&script, b.session, (struct text){line, LIMIT_LINE / 2 + 1}, &b.reply);
    assert_false(script_end(&script, b.session, &b.reply));
    assert_says(&b.err, "the line is longer than");
    free(line);
    bench_close(&b);
}

TEST(files_source_files)
{
    struct bench b;
    bench_open(&b, false);
    write_file("inner.hk", "k = 20\nfoo\n", 11);
    assert_false(SCRIPT(&b, "m = 1 kg\nsource inner.hk\nm = 2 kg\n"));
    assert_says(&b.err, "inner.hk:2:1: error: unknown command 'foo'");
    assert_says(&b.err, "sourced at s.hk:2");
    assert_says(&b.err, "s.hk: stopped at line 2");
    assert_true(b.session->setup.scene.value[param_index("k")] == 20);
    write_file("inner.hk", "source s.hk\n", 12);
    assert_false(SCRIPT(&b, "source inner.hk\n"));
    assert_says(&b.err, "s.hk would source itself");
    assert_says(&b.err, "inner.hk:1, sourced at s.hk:1");
    for (int i = 1; i <= LIMIT_SOURCE_DEPTH + 1; i++) {
        char name[16], content[32];
        snprintf(name, sizeof name, "n%d.hk", i);
        snprintf(content, sizeof content, "source n%d.hk\n", i + 1);
        write_file(name, content, strlen(content));
    }
    write_file("n16.hk", "echo bottom\n", 12);
    type_ok(&b, "source n1.hk");
    assert_says(&b.out, "bottom");
    write_file("n16.hk", "source n17.hk\n", 14);
    write_file("n17.hk", "echo bottom\n", 12);
    assert_false(type(&b, "source n1.hk"));
    assert_says(&b.err, "more than 16 deep");
    bench_close(&b);
}

/* Beside the file that names it, where the path as it stands leads nowhere. */
TEST(a_script_finds_what_lies_beside_it)
{
    static const char step[] = "load swing.txt", outer[] = "source inner/step.hk\n";
    static const char near[] = "t [s]\ty [cm]\n0\t1\n1\t2\n2\t3\n",
                      far[] = "t [s]\ty [cm]\n0\t1\n1\t2\n";
    (void)state;
    struct bench b;
    bench_open(&b, false);
    assert_int_equal(mkdir("beside", 0700), 0);
    assert_int_equal(mkdir("beside/inner", 0700), 0);
    write_file("beside/inner/swing.txt", near, sizeof near - 1);
    write_file("beside/inner/step.hk", step, sizeof step - 1);
    assert_true(run_script(&b, "beside/outer.hk", outer, sizeof outer - 1));
    assert_says(&b.out, "swing.txt: y [cm], 3 rows");
    assert_string_equal(b.session->recording[0]->recording->path, "beside/inner/swing.txt");
    write_file("swing.txt", far, sizeof far - 1); /* what the path says comes first */
    assert_true(run_script(&b, "beside/outer.hk", outer, sizeof outer - 1));
    assert_says(&b.out, "swing.txt: y [cm], 2 rows");
    assert_false(run_script(&b, "beside/outer.hk", "load none.txt", 13));
    assert_says(&b.err, "none.txt");
    assert_null(strstr(said(&b.err), "beside/none.txt"));
    assert_false(type(&b, "load inner/swing.txt")); /* a line that no file holds */
    unlink("swing.txt");
    unlink("beside/outer.hk");
    unlink("beside/inner/step.hk");
    unlink("beside/inner/swing.txt");
    assert_int_equal(rmdir("beside/inner") | rmdir("beside"), 0);
    bench_close(&b);
}

TEST(quit_ends_a_script_without_error)
{
    struct bench b;
    bench_open(&b, false);
    assert_true(SCRIPT(&b, "m = 1 kg\nquit; m = 2 kg\nfoo\n"));
    assert_true(b.session->execution.quit);
    assert_true(b.session->setup.scene.value[param_index("m")] == 1);
    assert_int_equal(b.session->execution.status, 0);
    bench_close(&b);
}

TEST(a_full_output_ends_with_status_4)
{
    struct bench b;
    bench_open(&b, false);
    b.full = true;
    assert_false(SCRIPT(&b, "echo one\nm = 300 g\n"));
    assert_int_equal(b.session->execution.status, 4);
    assert_says(&b.err, "could not be written");
    assert_true(b.session->setup.scene.value[param_index("m")] == 0.2);
    bench_close(&b);
}

TEST(cancelling_stops_a_run_and_the_script)
{
    struct bench b;
    struct cancel cancel = {1};
    bench_open(&b, false);
    b.session->front.cancel = &cancel;
    assert_false(type(&b, "m = 300 g"));
    assert_int_equal(b.session->execution.status, 130);
    bench_close(&b);
}

static bool refuse(void *context, const char *question)
{
    snprintf(context, 200, "%s", question);
    return false;
}

TEST(prefixes_and_questions_are_for_the_prompt)
{
    struct bench b;
    char question[200] = "";
    bench_open(&b, true);
    type_ok(&b, "meth backw");
    assert_says(&b.out, "backward-euler");
    assert_false(type(&b, "method ba"));  /* methods need three letters */
    assert_false(type(&b, "method sym")); /* two begin so */
    assert_false(SCRIPT(&b, "meth backward-euler\n"));
    b.session->front.context = question;
    b.session->front.confirm = refuse;
    assert_false(type(&b, "run 1e9"));
    assert_non_null(strstr(question, "this will take about"));
    bench_close(&b);
}

/* What came from outside cannot command the terminal. */
TEST(control_characters_become_visible)
{
    struct bench b;
    bench_open(&b, false);
    write_file("e\033[2J.hk", "foo\n", 4);
    type(&b, "echo '\033[31mred\a'");
    assert_null(strchr(said(&b.out), '\033'));
    type(&b, "print '\033]0;x\a'");
    assert_null(strchr(said(&b.out), '\033'));
    type(&b, "\033[2Jfoo");
    assert_null(strchr(said(&b.err), '\033'));
    type(&b, "m = 5 \033[2J");
    assert_null(strchr(said(&b.err), '\033'));
    type(&b, "source 'e\033[2J.hk'");
    assert_null(strchr(said(&b.err), '\033'));
    type(&b, "run 1 s; note \033[2J; runs");
    assert_null(strchr(said(&b.out), '\033'));
    type(&b, "history");
    assert_null(strchr(said(&b.out), '\033'));
    unlink("e\033[2J.hk");
    bench_close(&b);
}

TEST(lines_are_shown_where_it_is_asked_for)
{
    struct bench b;
    bench_open(&b, false);
    write_file("inner.hk", "let two = 2\n", 12);
    b.session->options.verbose = true;
    assert_true(SCRIPT(&b, "let one = 1\nsource inner.hk"));
    assert_string_equal(said(&b.err), "+ let one = 1\n+ source inner.hk\n+ let two = 2\n");
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
