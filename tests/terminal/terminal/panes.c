/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Panes on a terminal in memory: editing, keys, sizes, signals, ends. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "terminal/terminal.h"
#include "terminal/person.h"

#define CLEAN "\x03\x15" /* Ctrl-C, Ctrl-U */

/* ---- typing
 * -----------------------------------------------------------------------------------------------
 */

static void test_types_and_answers(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    assert_true(p.screen.second_screen);
    assert_true(p.screen.pasting);
    enter(&p, "m = 250 g");
    expect(&p, "m=250 g"); /* the state line */
    enter(&p, "print 6*7");
    expect(&p, "42");
    expect(&p, "hooke> print 6*7"); /* the log says what was typed */
    type(&p, "set gama 1\r");
    expect(&p, "did you mean");
    quit(&p);
}

static void test_edits_like_readline(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    /* to the beginning, six forward */
    type(&p, "print 3*11\x01"
             "\x06\x06\x06\x06\x06\x06"
             "1");
    expect_prompt(&p, "hooke> print 13*11");
    type(&p, "\r");
    expect(&p, "143");
    type(&p, "\x1b[A");
    expect_prompt(&p, "hooke> print 13*11");
    type(&p, CLEAN "meth\t");
    expect_prompt(&p, "hooke> method");
    type(&p, "rk4\x01\x0b");
    expect_prompt(&p, EMPTY_PROMPT);
    /* history search */
    type(&p, "\x12"
             "13");
    expect(&p, "reverse-i-search");
    expect(&p, "print 13*11");
    type(&p, "\r");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "set ga\t\t"); /* the only one */
    expect_prompt(&p, "hooke> set gamma");
    type(&p, CLEAN "e\t\t");
    expect(&p, "export");
    type(&p, CLEAN);
    quit(&p);
}

static void test_multibyte_text(void **state)
{
    (void)state;
    static const char *const locales[] = {"C.UTF-8", "C", "xx_YY.UTF-8"};
    for (size_t i = 0; i < COUNT_OF(locales); i++) {
        struct person p;
        start_panes(&p, (struct start){.locale = locales[i]});
        type(&p, "echo \xc5\xbc\xc3\xb3\xc5\x82\xc4\x87 \xe6\x97\xa5\xe6\x9c\xac");
        if (strcmp(locales[i], "C") != 0) {
            expect_prompt(&p,
                          "hooke> echo \xc5\xbc\xc3\xb3\xc5\x82\xc4\x87 \xe6\x97\xa5\xe6\x9c\xac");
            type(&p, "\x7f\x02\x02\x7f"); /* rub out 本, go before ć... */
            expect_prompt(&p, "hooke> echo \xc5\xbc\xc3\xb3\xc5\x82 \xe6\x97\xa5");
        }
        type(&p, CLEAN);
        expect_prompt(&p, EMPTY_PROMPT);
        type(&p, "echo \xff\xfe!"); /* not UTF-8 */
        expect(&p, "!");
        type(&p, CLEAN);
        enter(&p, "print 1/4");
        expect(&p, "0.25");
        quit(&p);
    }
}

/* ---- Ctrl-C
 * -----------------------------------------------------------------------------------------------
 */

static void test_interrupt(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "print 111");
    expect_prompt(&p, "hooke> print 111");
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "\x03\x03"); /* at an empty prompt: does not leave */
    enter(&p, "print 111*222");
    expect(&p, "24642");
    type(&p, "\x12"
             "pri");
    expect(&p, "reverse-i-search");
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "print 111*333"); /* the search is over */
    expect(&p, "36963");
    type(&p, "e\t\t");
    expect(&p, "export");
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
}

/* Searches say how far they are; what a branch has when it is stopped is kept, with its label. */
static void test_interrupt_of_searches(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){.width = 120, .height = 50});
    enter(&p, "var x = 2; var y = 0; param mm = 1; x' = y; y' = mm*(1-x^2)*y-x");
    enter(&p, "orbit"); /* alone: with the lines before it fills the log, and is read on its own */
    expect(&p, "orbit 1: T = 6.66328685932 s");
    type(&p, "branch mm=0.1:100 of orbit step=0.0001 max=20000\r");
    expect(&p, " s left (Ctrl-C stops)");
    type(&p, "\x03");
    expect(&p, "cancelled; the points found so far are kept");
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "list points");
    expect(&p, "  EP1  end  mm = 0.");
    enter(&p, "branch mm=0.1:100 of orbit from EP1 --forward max=3");
    expect(&p, "branch 2: 4 orbits");
    quit(&p);
}

static void test_interrupt_pauses_a_run(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    enter(&p, "method verlet");
    enter(&p, "run 1000 s");
    expect(&p, "RUNNING");
    enter(&p, "print 321*321"); /* commands are executed on the way */
    expect(&p, "103041");
    type(&p, "print 99"); /* a line that is being typed survives the pause */
    expect_prompt(&p, "hooke> print 99");
    assert_false(shows(&p, "PAUSED"));
    const int64_t begun = work_ns(p.program);
    type(&p, "\x03");
    expect(&p, "PAUSED");
    assert_true(work_ns(p.program) - begun <= work_most());
    expect_prompt(&p, "hooke> print 99");
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "\x1b[15~"); /* F5 goes on, and pauses again */
    expect(&p, "RUNNING");
    type(&p, "\x1b[15~");
    expect(&p, "PAUSED");
    quit(&p);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* From the key to the screen that says so, again and again in the same run. */
static void test_interrupts_are_prompt(void **state)
{
    (void)state;
    enum { QUICK = 100, MOST = 1000 };
    double after[MOST];
    const int times = is_long() ? MOST : QUICK;
    struct person p;
    start_panes(&p, (struct start){0});
    enter(&p, "method verlet; run 10000 s");
    for (int i = 0; i < times; i++) {
        expect(&p, "RUNNING");
        const int64_t begun = work_ns(p.program);
        type(&p, "\x03");
        expect(&p, "PAUSED");
        after[i] = (double)(work_ns(p.program) - begun) / MS;
        expect_prompt(&p, EMPTY_PROMPT);
        enter(&p, "continue");
    }
    qsort(after, (size_t)times, sizeof after[0], by_size);
    const double late = after[times * 99 / 100 - 1];
    print_message("# %d interrupts from the panes: paused after %.1f ms of work (median), %.1f ms "
                  "(99th percentile)\n",
                  times, after[times / 2], late);
    assert_true(late <= (double)work_most() / MS);
    quit(&p);
}

static void test_interrupt_stops_long_commands(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    enter(&p, "set duration 20000 s; timing full");
    type(&p, "compare euler verlet rk4 dt=1ms,0.5ms,0.2ms\r");
    expect(&p, "hooke> compare");
    const int64_t begun = clock_ns();
    type(&p, "\x03");
    type(&p, "print 123*1001\r");
    expect(&p, "123123");
    print_message("# Ctrl-C stops compare after %.1f ms\n", (double)(clock_ns() - begun) * 1e-6);
    quit(&p);
}

/* ---- pastes
 * -----------------------------------------------------------------------------------------------
 */

static void test_pastes(void **state)
{
    (void)state;
    struct person p;
    struct buffer text = {0};
    start_panes(&p, (struct start){0});
    /* 10 kB in one line. */
    buffer_put(&text, TEXT("\033[200~print 0"));
    for (int i = 0; i < 2500; i++) {
        buffer_put(&text, TEXT(" + 1"));
    }
    buffer_put(&text, TEXT("\033[201~"));
    type(&p, text.data);
    expect(&p, "+ 1");
    type(&p, "\r");
    expect_prompt(&p, EMPTY_PROMPT);
    expect(&p, "2500");
    /* 200 lines with a mistake in the third. */
    buffer_clear(&text);
    buffer_put(&text, TEXT("\033[200~print 1001\rprint 1002\rset gama 1\r"));
    for (int i = 4; i <= 200; i++) {
        buffer_put(&text, TEXT("print 7000+4\r"));
    }
    buffer_put(&text, TEXT("\033[201~"));
    type(&p, text.data);
    expect(&p, "several lines");
    type(&p, "\r");
    expect(&p, "paste:3:");
    expect(&p, "paste: stopped");
    assert_false(shows(&p, "7004"));
    expect(&p, "q: panes)>"); /* with its hint it is longer than the log */
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    buffer_free(&text);
    quit(&p);
}

/* ---- keys
 * -------------------------------------------------------------------------------------------------
 */

static void test_keys(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "method");
    type(&p, "\033OP"); /* F1 */
    expect(&p, "see also: list compare");
    type(&p, CLEAN);
    type(&p, "compare  \033OP"); /* behind blanks, of the word before them */
    expect(&p, "usage: compare");
    type(&p, CLEAN);
    enter(&p, "speed max");
    type(&p, "\033[15~"); /* F5 */
    expect(&p, "t=10.00 s");
    type(&p, "\033[17~"); /* F6 */
    expect(&p, "layout duo");
    type(&p, "\x18l");
    expect(&p, "layout single");
    type(&p, "\x18s");
    expect(&p, "t = 10.01 s");
    type(&p, "\0334\x18s"); /* prefix argument */
    expect(&p, "t = 10.05 s");
    type(&p, "\x18"
             "2");
    expect(&p, "focus phase full");
    type(&p, "\x18"
             "2");
    expect(&p, "focus phase:");
    type(&p, "\x18"
             "1\x18"
             "1\x18+");
    expect(&p, "hooke> zoom 2");
    type(&p, "\x18<");
    expect(&p, "hooke> pan -");
    type(&p, "\x18"
             "a");
    expect(&p, "set charset block");
    type(&p, "help\r"); /* longer than the log: on the whole screen */
    expect(&p, "q: panes)>");
    expect(&p, "timing clear quit");
    type(&p, "/fit\r");
    expect(&p, "n next");
    type(&p, "/zwiebel\r");
    expect(&p, "no line has 'zwiebel'");
    type(&p, "q");
    expect_prompt(&p, "hooke>");
    expect(&p, "F1 help");
    type(&p, "help\r");
    expect(&p, "q: panes)>");
    type(&p, "print 7*6\r"); /* any other key begins a command */
    expect(&p, "42");
    expect(&p, "F1 help");
    type(&p, "\033[5~");
    expect(&p, "newer lines");
    type(&p, "\x18\033[F");
    wait_for(&p, "newer lines", false);
    enter(&p, "scroll 5000"); /* beyond the oldest line */
    expect(&p, "hooke 0");
    type(&p, "\033[6~"); /* PgDn moves at once */
    wait_for(&p, "hooke 0", false);
    type(&p, "\x18\033[F");
    wait_for(&p, "newer lines", false);
    type(&p, "plot energy\r");
    expect(&p, "energy E ["); /* its first row */
    expect(&p, "'focus energy full' keeps it in a pane");
    type(&p, "q");
    type(&p, "\033[18~"); /* F7: the cursors have the keys */
    expect(&p, "cursors (q leaves");
    type(&p, "n\t\033[C\r");
    expect(&p, "kept");    /* as a measurement */
    type(&p, "n\xc2\xa0"); /* no key at all */
    type(&p, ":print 5*11\r");
    expect_prompt(&p, "cursors (q leaves, : types a command)>");
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    expect(&p, "55");
    enter(&p, "nothing-of-the-kind");
    type(&p, "\x0c"); /* C-l */
    expect(&p, "unknown command");
    quit(&p);
}

/* The user's own bindings are left alone. */
static void test_inputrc_wins(void **state)
{
    (void)state;
    char rc[64];
    char setting[80];
    snprintf(rc, sizeof rc, "%s/inputrc", state_folder);
    FILE *file = fopen(rc, "w");
    assert_non_null(file);
    fputs("\"\\e[17~\": \"print 9*9\\C-m\"\n", file);
    fclose(file);
    snprintf(setting, sizeof setting, "INPUTRC=%s", rc);
    struct person p;
    start_panes(&p, (struct start){.environment = setting});
    type(&p, "\033[17~");
    expect(&p, "81");
    type(&p, "\x18l");
    expect(&p, "layout duo");
    quit(&p);
}

/* ---- sizes
 * ------------------------------------------------------------------------------------------------
 */

/* What a screen of this size shows after a repaint is what it shows now. */
static void expect_true_screen(struct person *p)
{
    struct buffer before = {0}, after = {0};
    settle(p, 300);
    emulator_text(&p->screen, &before);
    emulator_blank(&p->screen, 0, 0, p->screen.width, p->screen.height);
    type(p, "\x0c");
    settle(p, 300);
    emulator_text(&p->screen, &after);
    assert_string_equal(before.data, after.data);
    buffer_free(&before);
    buffer_free(&after);
}

static void test_sizes(void **state)
{
    (void)state;
    struct person p;
    static const int sizes[][2] = {{20, 6}, {300, 100}, {1, 1}, {2, 40}, {200, 1}, {80, 24}};
    start_panes(&p, (struct start){0});
    enter(&p, "method verlet; gamma = 0.05");
    enter(&p, "run 2000 s");
    expect(&p, "RUNNING");
    type(&p, "print 1");
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        resize(&p, sizes[i][0], sizes[i][1]);
        type(&p, "+1");
        for (int n = 0; n < 4; n++) {
            pump(&p, 100);
        }
    }
    expect_prompt(&p, "hooke> print 1+1+1+1+1+1+1");
    expect(&p, "RUNNING");
    type(&p, "\r");
    expect(&p, "7");
    type(&p, "\x03");
    expect(&p, "PAUSED");
    expect_true_screen(&p);
    quit(&p);
}

static void test_suspend(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){.shell = true});
    enter(&p, "print 6*7");
    expect(&p, "42");
    type(&p, "print 5"); /* half a line */
    expect_prompt(&p, "hooke> print 5");
    type(&p, "\x1a");
    expect_stop(&p);
    same_modes(&p);
    assert_false(p.screen.second_screen);
    assert_false(p.screen.pasting);
    resize(&p, 100, 30);
    continue_program(&p);
    expect_prompt(&p, "hooke> print 5");
    assert_true(p.screen.second_screen);
    assert_true(p.screen.pasting);
    expect(&p, "42");
    expect_true_screen(&p);
    type(&p, "*5\r");
    expect(&p, "25");
    quit(&p);
}

/* Nobody looks at the terminal then: the handler does it. */
static void test_suspend_in_a_long_command(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){.shell = true});
    enter(&p, "set duration 20000 s; timing full");
    type(&p, "compare euler verlet rk4 dt=1ms,0.5ms,0.2ms\r");
    expect(&p, "hooke> compare");
    type(&p, "\x1a");
    expect_stop(&p);
    same_modes(&p);
    assert_false(p.screen.second_screen);
    assert_false(p.screen.pasting);
    resize(&p, 90, 20);
    continue_program(&p);
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    assert_true(p.screen.second_screen);
    assert_true(p.screen.pasting);
    expect_true_screen(&p);
    quit(&p);
}

/* ---- ends
 * -------------------------------------------------------------------------------------------------
 */

static void test_end_of_input_leaves(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "\x04");
    const int status = end(&p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

static void test_plain_and_back(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "print 2*21\r");
    expect(&p, "42");
    type(&p, "plain\rprint 5*11\r"); /* typed ahead */
    expect(&p, "Tab completes, F1 explains, Ctrl-D leaves");
    expect(&p, "55");
    assert_false(p.screen.second_screen);
    type(&p, "panes\r");
    expect(&p, "F1 help");
    assert_true(p.screen.second_screen);
    enter(&p, "print 6*11");
    expect(&p, "66");
    quit(&p);
}

int main(int argc, char **argv)
{
    if (!make_folder(state_folder)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types_and_answers),
        cmocka_unit_test(test_edits_like_readline),
        cmocka_unit_test(test_multibyte_text),
        cmocka_unit_test(test_interrupt),
        cmocka_unit_test(test_interrupt_of_searches),
        cmocka_unit_test(test_interrupt_pauses_a_run),
        cmocka_unit_test(test_interrupts_are_prompt),
        cmocka_unit_test(test_interrupt_stops_long_commands),
        cmocka_unit_test(test_pastes),
        cmocka_unit_test(test_keys),
        cmocka_unit_test(test_inputrc_wins),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_suspend),
        cmocka_unit_test(test_suspend_in_a_long_command),
        cmocka_unit_test(test_end_of_input_leaves),
        cmocka_unit_test(test_plain_and_back),
    };
    if (argc > 1) {
        cmocka_set_test_filter(argv[1]);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
