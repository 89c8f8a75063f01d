/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tab completes names of files in quotes, behind a backslash and behind ~, so that they can be
 * read; at the prompt and in the panes. */
#include "cmocka_testing.h"

#include <stdio.h>
#include <string.h>

#include "terminal/terminal.h"
#include "terminal/person.h"

static void make_file(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", state_folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(strstr(name, ".ode") ? "x'=-x\ndone\n" : "t [s],y [cm]\n0,1\n1,2\n2,1\n3,2\n", file);
    assert_int_equal(fclose(file), 0);
}

static void make_files(void)
{
    static const char *const names[] = {"my file.txt", "it's.txt", "se;mi.txt", "qu\"o.txt",
                                        "ba\\ck.txt",  "k=5.txt",  "wave.ode",  "wave.txt"};
    char path[256];
    snprintf(path, sizeof path, "%s/a dir", state_folder);
    assert_int_equal(mkdir(path, 0700), 0);
    for (size_t i = 0; i < COUNT_OF(names); i++)
        make_file(names[i]);
    make_file("a dir/inside.txt");
}

/* What is typed before the Tab, behind "load " and with % for the folder; what it becomes. */
static const char *const cases[][3] = {
    {"\"%/my f", "my file.txt\"", "my file.txt:"}, {"'%/my f", "my file.txt'", "my file.txt:"},
    {"%/my", "my\\ file.txt", "my file.txt:"},     {"%/my\\ f", "my\\ file.txt", "my file.txt:"},
    {"%/it", "it's.txt\"", "it's.txt:"},           {"%/se", "se;mi.txt'", "se;mi.txt:"},
    {"%/qu", "qu\"o.txt'", "qu\"o.txt:"},          {"\"%/qu", "qu\\\"o.txt\"", "qu\"o.txt:"},
    {"%/ba", "ba\\ck.txt'", "ba\\ck.txt:"},        {"%/k", "k=5.txt'", "k=5.txt:"},
    {"\"%/a d\t", "inside.txt\"", "inside.txt:"},  {"%/a\\ d\t", "inside.txt", "inside.txt:"},
    {"~/my", "my\\ file.txt", "my file.txt:"},     {"scene %/wa", "wave.ode", "scene wave:"},
    {"scene \"%/wa", "wave.ode\"", "scene wave:"},
};

static void complete_files(const char *argument)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct person p;
        char home[64], typed[128] = "load ";
        snprintf(home, sizeof home, "HOME=%s", state_folder);
        begin(&p, (struct start){
                      .argument = {argument}, .environment = home, .width = 160, .height = 30});
        expect(&p, EMPTY_PROMPT);
        for (const char *c = cases[i][0]; *c; c++)
            snprintf(typed + strlen(typed), sizeof typed - strlen(typed), "%.*s",
                     *c == '%' ? (int)strlen(state_folder) : 1, *c == '%' ? state_folder : c);
        type(&p, typed);
        type(&p, "\t");
        expect(&p, cases[i][1]);
        type(&p, "\r");
        expect(&p, cases[i][2]);
        assert_false(shows(&p, "error"));
        quit(&p);
    }
}

static void test_prompt(void **state)
{
    (void)state;
    complete_files("--plain");
}

static void test_panes(void **state)
{
    (void)state;
    complete_files(NULL);
}

/* It ended the program where it was typed. */
static void test_no_end(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "load \"my f\t\t\r");
    expect(&p, "is not closed");
    type(&p, "save --f\t\x15print 6*7\r");
    expect(&p, "42");
    type(&p, "save --f\t");
    expect_prompt(&p, "hooke> save --force");
    type(&p, "\x15list methods stiff ad\t");
    expect_prompt(&p, "hooke> list methods stiff adaptive");
    quit(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_prompt), cmocka_unit_test(test_panes),
                                       cmocka_unit_test(test_no_end)};
    if (!make_folder(state_folder))
        return 1;
    make_files();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
