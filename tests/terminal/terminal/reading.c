/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is longer than the log, read on the whole screen: footers that fit, a recipe that a key
 * runs, sizes that change, what was half typed. */
#include "cmocka_testing.h"

#include <stdio.h>
#include <string.h>

#include "terminal/terminal.h"
#include "terminal/person.h"

#define WIDE "(space: more, PgUp, / find, n next, q: panes)>"
#define WIDE_RECIPE "(space: more, PgUp, / find, n next, ! runs it, q: panes)>"

/* Where the page has a recipe the footer says so, whole at every size. */
static void test_footers(void **state)
{
    (void)state;
    static const struct {
        int width, height;
        const char *recipe, *none;
    } cases[] = {{80, 24, WIDE_RECIPE, WIDE},
                 {200, 24, WIDE_RECIPE, WIDE},
                 {60, 20, "(space, ! runs it, q)>", WIDE},
                 {40, 12, "(space, ! runs it, q)>", "(space, q)>"},
                 {20, 10, "(!, q)>", "(space, q)>"}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct person p;
        start_panes(&p, (struct start){.width = cases[i].width, .height = cases[i].height});
        type(&p, "help start\r");
        expect(&p, cases[i].recipe);
        type(&p, "q");
        expect_prompt(&p, EMPTY_PROMPT);
        type(&p, "help commands\r");
        expect(&p, cases[i].none);
        assert_false(shows(&p, "! runs it"));
        type(&p, "q");
        expect_prompt(&p, EMPTY_PROMPT);
        quit(&p);
    }
}

/* Each line with its prompt, up to the first error; the scene is as if they had been typed. */
static void test_recipe(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "help start\r");
    expect(&p, "! runs it");
    type(&p, "!");
    expect(&p, "hooke> scene damped; m = 200 g"); /* the beginning of what was said */
    type(&p, "q");
    expect(&p, "damped  m=200 g"); /* the line of state */
    type(&p, "\x1b[A");            /* it is remembered */
    expect_prompt(&p, "hooke> recipe start");
    type(&p, "\x15");
    enter(&p, "scene spring");
    type(&p, "help gamma; help verlet\r"); /* a page without one: a key as any other */
    expect(&p, WIDE);
    type(&p, "!");
    expect_prompt(&p, "hooke> !");
    quit(&p);
}

/* The page begins where it did, at whatever size. */
static void test_sizes(void **state)
{
    (void)state;
    struct person p;
    struct buffer row = {0};
    start_panes(&p, (struct start){.width = 40, .height = 12});
    type(&p, "help commands\r");
    expect(&p, "(space, q)>");
    type(&p, "/plan\r");
    settle(&p, 300);
    emulator_row(&p.screen, 0, &row);
    char top[16];
    snprintf(top, sizeof top, "%.10s", row.data);
    buffer_free(&row);
    static const int sizes[][2] = {{80, 24}, {25, 9}, {200, 30}, {40, 12}};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        resize(&p, sizes[i][0], sizes[i][1]);
        expect(&p, "q");
        expect(&p, ")>");
        struct buffer first = {0};
        settle(&p, 200);
        emulator_row(&p.screen, 0, &first);
        if (strncmp(first.data, top, strlen(top)) != 0)
            fail_msg("at %dx%d the page begins with '%s', not with '%s'", sizes[i][0], sizes[i][1],
                     first.data, top);
        buffer_free(&first);
    }
    type(&p, "/a-word-that-stands-nowhere-in-all-of-this\r");
    expect(&p, "not found (space, q)>");
    quit(&p);
}

/* F1 in the middle of a line: the page has the keys, the line comes back. */
static void test_half_typed(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "compare euler dt=1ms\x02\x02\x02\x02\x02\x02\x02\x1bOP"); /* C-b: on euler */
    expect(&p, WIDE);
    type(&p, "/euler\rnq");
    expect_prompt(&p, "hooke> compare euler dt=1ms");
    type(&p, "\x1bOP");
    expect(&p, WIDE);
    type(&p, "\x03"); /* C-c leaves the page */
    expect_prompt(&p, "hooke> compare euler dt=1ms");
    type(&p, "\x1bOP");
    expect(&p, WIDE);
    type(&p, "X"); /* goes on where the cursor was */
    expect_prompt(&p, "hooke> compare eulerX dt=1ms");
    quit(&p);
}

/* Without panes F1 explains, too, and the line stays. */
static void test_plain_help(void **state)
{
    (void)state;
    struct person p;
    begin(&p, (struct start){.argument = {"--plain"}});
    expect(&p, EMPTY_PROMPT);
    type(&p, "compare euler dt=5\x1bOP");
    expect(&p, "an argument of compare: time");
    expect(&p, "see also: set unset show");
    type(&p, "ms\r");
    expect(&p, "hooke> compare euler dt=5ms");
    expect(&p, "as predicted");
    quit(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_footers), cmocka_unit_test(test_recipe), cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_half_typed), cmocka_unit_test(test_plain_help)};
    return make_folder(state_folder) ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
}
