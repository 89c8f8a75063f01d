/* SPDX-License-Identifier: GPL-3.0-or-later */
/* $PAGER at the plain prompt: only where it was asked for by typing, only with what is longer than
 * the screen, and whatever becomes of it what was said is seen and the terminal is as it was. */
#include "cmocka_testing.h"

#include <stdio.h>
#include <stdlib.h>

#include "terminal/terminal.h"
#include "terminal/person.h"

/* A pager that says that it ran, with its arguments, LESS and what it was given. */
static void make_pager(const char *name, const char *script)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", state_folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "#!/bin/sh\n%s\n", script);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0700), 0);
}

static void start(struct person *p, const char *pager, const char *option)
{
    static char environment[256];
    snprintf(environment, sizeof environment, "PAGER=%s%s", pager[0] == '/' ? state_folder : "",
             pager);
    begin(p, (struct start){.argument = {"--plain", option}, .environment = environment});
    expect(p, EMPTY_PROMPT);
}

static void set_on(struct person *p)
{
    type(p, "set pager on\r");
    expect(p, "pager = on");
}

static void test_paged(void **state)
{
    (void)state;
    struct person p;
    make_pager("fake",
               "echo \"PAGED $1 $2 LESS=$LESS $(wc -l) lines\"; stty -echo -icanon </dev/tty");
    start(&p, "/fake  -a $HOME;b", NULL);
    type(&p, "help\r"); /* off, unless it is asked for */
    expect(&p, "apropos recipe list");
    assert_false(shows(&p, "PAGED"));
    set_on(&p);
    type(&p, "print 6*7\r");
    expect(&p, "42");
    assert_false(shows(&p, "PAGED"));
    type(&p, "help commands\r");
    expect(&p, "PAGED -a $HOME;b LESS=FRX"); /* no shell has seen it */
    assert_false(shows(&p, "list everything of a kind"));
    type(&p, "print 6*8\r");
    expect(&p, "48");
    quit(&p); /* which finds the terminal's modes as they were */
}

/* It is not there, cannot run, fails or dies: what was said is written. */
static void test_failing(void **state)
{
    (void)state;
    static const char *const pagers[] = {"/missing", "/fails", "/dies", "no-such-pager-anywhere"};
    make_pager("fails", "exit 3");
    make_pager("dies", "kill -9 $$");
    for (size_t i = 0; i < COUNT_OF(pagers); i++) {
        struct person p;
        start(&p, pagers[i], NULL);
        set_on(&p);
        type(&p, "list units\r");
        expect(&p, "millivolt"); /* the end of it, which stays on the screen */
        type(&p, "print 6*8\r");
        expect(&p, "48");
        quit(&p);
    }
}

/* It is left before it has read all, as less is by q. */
static void test_left(void **state)
{
    (void)state;
    struct person p;
    make_pager("leaves", "head -n 1; exit 0");
    start(&p, "/leaves", NULL);
    set_on(&p);
    type(&p, "run; plot position; plot velocity; list methods; list units; history; show all\r");
    expect(&p, "t = 10 s");
    type(&p, "print 6*8\r");
    expect(&p, "48");
    assert_false(shows(&p, "sbdf"));
    quit(&p);
}

static void refused(const char *line, const char *says, const char *option)
{
    struct person p;
    start(&p, "/fake", option);
    type(&p, line);
    expect(&p, says);
    type(&p, "\rlist units\r");
    expect(&p, "millivolt");
    assert_false(shows(&p, "PAGED"));
    quit(&p);
}

/* Files run no program, not even what the user has allowed at the prompt. */
static void test_refused(void **state)
{
    (void)state;
    char path[256], line[300];
    make_pager("fake", "echo PAGED; cat");
    snprintf(path, sizeof path, "%s/sets.hk", state_folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("set pager on\n", file);
    assert_int_equal(fclose(file), 0);
    snprintf(line, sizeof line, "source %s\r", path);
    refused(line, "must not run programs", NULL);
    refused("set pager on\r", "--safe allows no other programs", "--safe");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_paged), cmocka_unit_test(test_failing),
                                       cmocka_unit_test(test_left), cmocka_unit_test(test_refused)};
    return make_folder(state_folder) ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
}
