/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The static program at a terminal, in a root that holds nothing but it and a recording: panes and
 * prompt without terminfo, locales or a list of users. */
#include <hooke/base/file.h>
#include "cmocka_testing.h"

#include "long_form.h"
#include "terminal/person.h"

static char root[] = "/tmp/hooke-bare-XXXXXX";

static bool copy(const char *from, const char *name, mode_t mode)
{
    struct buffer content = {0};
    struct error error;
    char path[64];
    snprintf(path, sizeof path, "%s/%s", root, name);
    const int to = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    const bool done = to >= 0 && file_read(from, (size_t)1 << 26, &content, &error) &&
                      write(to, content.data, content.len) == (ssize_t)content.len;
    buffer_free(&content);
    return close(to) == 0 && done;
}

static bool root_possible(void)
{
    int status = 1;
    const pid_t child = fork();
    if (child == 0)
        _exit(!enter_root(root));
    return waitpid(child, &status, 0) == child && status == 0;
}

/* The root, or a word why there is none. */
static void fill_root(void)
{
    static bool filled;
    const char *program = getenv("STATIC");
    if (!program || !*program) {
        print_message("# no static program belongs to this build (make static)\n");
        skip();
    }
    if (!root_possible()) {
        print_message("# neither root nor user namespaces: no other root can be entered\n");
        skip();
    }
    if (filled)
        return;
    assert_true(copy(program, "hooke", 0755));
    assert_true(copy("examples/lab/bare.txt", "bare.txt", 0644));
    unsetenv("TERMINFO");
    unsetenv("TERMINFO_DIRS");
    unsetenv("TERMCAP");
    filled = true;
}

static const char *const terminals[] = {"xterm-256color", "screen", "vt100", "xterm",
                                        "tmux",           "linux",  "vt220"};

/* All of the lab's first steps on the panes; what the screen shows is what `screenshot` says. */
static void test_panes(void **state)
{
    (void)state;
    fill_root();
    for (size_t i = 0; i < (is_long() ? COUNT_OF(terminals) : 3); i++) {
        struct person p;
        print_message("# TERM=%s\n", terminals[i]);
        start_panes(&p, (struct start){.root = root, .term = terminals[i], .argument = {"-n"}});
        const bool utf8 = strcmp(terminals[i], "linux") != 0;
        expect(&p, utf8 ? "\xE2\x94\x8C\xE2\x94\x80 y [cm]" : "+- y [cm]");
        enter(&p, "m = 200 g; load bare.txt");
        expect(&p, "1000 rows");
        enter(&p, "measure period of bare"); /* short: what fills the log is read on its own */
        expect(&p, "T = 0.72");
        enter(&p, "speed max; gamma = 0");
        enter(&p, "method verlet dt=10ms");
        enter(&p, "run 9.99 s");
        expect(&p, "999 steps");
        type(&p, "print 5/4 + x\xC3\xA9\x1B" /* é, then back by a word and on */
                 "b\x0B\x7F\x7F\x7F");
        expect_prompt(&p, "hooke> print 5/4");
        type(&p, "\r");
        expect(&p, "1.25");
        quit(&p);
    }
}

static void test_prompt(void **state)
{
    (void)state;
    fill_root();
    for (size_t i = 0; i < COUNT_OF(terminals); i++) {
        struct person p;
        print_message("# TERM=%s\n", terminals[i]);
        begin(&p,
              (struct start){.root = root, .term = terminals[i], .argument = {"-n", "--plain"}});
        expect(&p, "hooke>");
        type(&p, "prunt 5/4\x01\x06\x06\x04i\r"); /* to the beginning, two on, i for u */
        expect(&p, "1.25");
        type(&p, "load ~no-one/ba\t\x15plot phas\t\r");
        expect(&p, "plot phase");
        quit(&p);
    }
}

/* A kind of terminal that nobody describes is still told. */
static void test_unknown_terminal(void **state)
{
    (void)state;
    fill_root();
    struct person p;
    begin(&p, (struct start){.root = root, .term = "nobodys", .argument = {"-n"}});
    expect(&p, "the type of the terminal is unknown (TERM=nobodys)");
    expect(&p, "hooke>");
    quit(&p);
}

/* The charset is the one that the environment names, whether or not the locale is there. */
static void test_charset(void **state)
{
    (void)state;
    fill_root();
    static const struct {
        const char *locale;
        bool utf8;
    } cases[] = {{"de_DE.UTF-8", true}, {"ja_JP.utf8", true}, {"C", false}, {"de_DE", false}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct person p;
        start_panes(&p,
                    (struct start){.root = root, .locale = cases[i].locale, .argument = {"-n"}});
        expect(&p, cases[i].utf8 ? "\xE2\x94\x8C\xE2\x94\x80 y [cm]" : "+- y [cm]");
        type(&p, "# \xC5\xBC\xC3\xB3\xE6\xBC\xA2"); /* of two bytes, and wide of three */
        expect_prompt(&p, cases[i].utf8 ? "hooke> # \xC5\xBC\xC3\xB3\xE6\xBC\xA2" : "hooke> # ???");
        quit(&p);
    }
}

int main(void)
{
    if (!make_folder(root) || !make_folder(state_folder))
        return 2;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_panes),
        cmocka_unit_test(test_prompt),
        cmocka_unit_test(test_unknown_terminal),
        cmocka_unit_test(test_charset),
    };
    return cmocka_run_group_tests_name("a root that holds nothing else", tests, NULL, NULL);
}
