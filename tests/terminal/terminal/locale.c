/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Locales: numbers never follow them, and text that does not fit them harms nothing. */
#include <hooke/base/file.h>
#include "cmocka_testing.h"
#include <locale.h>

#include "terminal/person.h"

#define COMMA "de_DE.UTF-8"

static char locales[] = "/tmp/hooke-locale-XXXXXX";

static int run_program(const char *const *argv)
{
    int status = -1;
    const pid_t child = fork();
    if (child == 0) {
        const int nowhere = open("/dev/null", O_RDWR);
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
        execvp(argv[0], (char *const *)(uintptr_t)argv);
        _exit(127);
    }
    return child > 0 && waitpid(child, &status, 0) == child ? status : -1;
}

/* Builds a locale with a decimal comma and makes it the one that programs find. */
static bool build_comma_locale(void)
{
    char folder[sizeof locales + 16];
    snprintf(folder, sizeof folder, "%s/" COMMA, locales);
    run_program((const char *const[]){"localedef", "-i", "de_DE", "-f", "UTF-8", folder, NULL});
    setenv("LOCPATH", locales, 1);
    const bool there = setlocale(LC_ALL, COMMA) && strcmp(localeconv()->decimal_point, ",") == 0;
    setlocale(LC_ALL, "C");
    return there;
}

static void read_and_remove(const char *path, struct buffer *content)
{
    struct error error;
    if (!file_read(path, (size_t)1 << 22, content, &error)) {
        fail_msg("%s", error.text);
    }
    unlink(path);
}

/* What a locale could change: the exported numbers and every cell of the screen. */
struct work {
    struct buffer table, screen;
};

static void work_in(const char *locale, struct work *work)
{
    char table[64], screen[64], line[128];
    struct person p;
    snprintf(table, sizeof table, "%s/table.csv", state_folder);
    snprintf(screen, sizeof screen, "%s/screen.txt", state_folder);
    *work = (struct work){0};
    start_panes(&p, (struct start){.locale = locale});
    enter(&p, "set timing off; method verlet dt=12.5ms; speed max; m = 0.25; gamma = 0.1 1/s");
    enter(&p, "run 2.5 s");
    expect(&p, "t = 2.5 s");
    enter(&p, "print 5/4");
    expect(&p, "1.25");
    enter(&p, "print 1,5"); /* a comma stays a mistake */
    expect(&p, "error: ");
    expect(&p, "1.5");
    enter(&p, "measure period");
    expect(&p, "periods");
    snprintf(line, sizeof line, "export %s t,y,v,energy", table);
    enter(&p, line);
    expect(&p, "rows of t,y,v,energy");
    snprintf(line, sizeof line, "screenshot %s", screen);
    enter(&p, line);
    expect(&p, "screen written");
    quit(&p);
    read_and_remove(table, &work->table);
    read_and_remove(screen, &work->screen);
}

static void test_comma_locale(void **state)
{
    (void)state;
    if (!build_comma_locale()) {
        print_message("# " COMMA " cannot be built: localedef or its sources are missing\n");
        skip();
    }
    struct work comma, point;
    work_in(COMMA, &comma);
    work_in("C.UTF-8", &point);
    assert_non_null(strstr(point.table.data, "\n0.0125,"));
    assert_string_equal(comma.table.data, point.table.data);
    assert_non_null(strstr(point.screen.data, "T = 0.8"));
    assert_string_equal(comma.screen.data, point.screen.data);
    buffer_free(&comma.table);
    buffer_free(&comma.screen);
    buffer_free(&point.table);
    buffer_free(&point.screen);
}

/* Without a prompt: results in each form. What `run` records holds the computing time and is no
 * part of it. */
static void test_comma_locale_in_batch(void **state)
{
    (void)state;
    if (!build_comma_locale()) {
        print_message("# " COMMA " cannot be built: localedef or its sources are missing\n");
        skip();
    }
    static const struct {
        const char *format, *from, *number;
    } cases[] = {{"text", "t = ", "0.8108"},
                 {"csv", "measure", "0.0015"},
                 {"json", "\"measure\"", "\"value\":0.0015"}};
    static const char *const names[] = {COMMA, "C.UTF-8"};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct person p[2];
        for (size_t j = 0; j < COUNT_OF(names); j++) {
            begin(&p[j], (struct start){
                             .locale = names[j],
                             .argument = {"-b", "--format", cases[i].format, "-c",
                                          "m = 0.25; set timing off; method verlet dt=12.5ms; "
                                          "run 2.5 s; measure period; plot energy; print 1.5e-3"}});
            assert_int_equal(wait_end(&p[j]), 0);
        }
        const char *comma = strstr(p[0].raw.data, cases[i].from),
                   *point = strstr(p[1].raw.data, cases[i].from);
        assert_true(comma && point && strstr(comma, cases[i].number));
        assert_string_equal(comma, point);
        forget(&p[0]);
        forget(&p[1]);
    }
}

/* A locale that does not exist: UTF-8 where its name says so, else plain ASCII; never a refusal. */
static void test_missing_locale(void **state)
{
    (void)state;
    static const struct {
        const char *locale;
        bool utf8;
    } cases[] = {{"xx_YY.UTF-8", true},
                 {"xx_YY.utf8", true},
                 {"xx_YY", false},
                 {"C", false},
                 {"nonsense", false}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct person p;
        start_panes(&p, (struct start){.locale = cases[i].locale});
        assert_int_equal(shows(&p, "\xE2\x94\x8C"), cases[i].utf8); /* a corner of the frame */
        assert_int_equal(shows(&p, "+- y [cm]"), !cases[i].utf8);
        type(&p, "echo \xC5\xBC\xC3\xB3");
        expect(&p, cases[i].utf8 ? "hooke> echo \xC5\xBC\xC3\xB3" : "hooke> echo ");
        type(&p, "\r");
        expect_prompt(&p, EMPTY_PROMPT);
        enter(&p, "print 5/4");
        expect(&p, "1.25");
        quit(&p);
    }
}

/* Bytes that are no text are shown as what they are, can be edited, and never reach the terminal.
 */
static void test_invalid_bytes(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    type(&p, "echo a\xFF"
             "b");
    expect_prompt(&p, "hooke> echo a\\xFFb");
    type(&p, "\x02\x7f"); /* before b; rub the byte out */
    expect_prompt(&p, "hooke> echo ab");
    type(&p, "\x05\xC3("); /* the beginning of a character that does not come: readline drops it */
    expect_prompt(&p, "hooke> echo ab(");
    type(&p, "\r");
    expect_prompt(&p, EMPTY_PROMPT);
    /* and found again in the history */
    type(&p, "\x12"
             "ab");
    expect(&p, "reverse-i-search"); /* the log shows the line already */
    expect(&p, "echo ab(");
    type(&p, "\x03");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "set \xFE\xFE 1\r"); /* an error quotes it */
    expect(&p, "is not a name");
    expect(&p, "\\xfe 1");
    enter(&p, "print 6*7");
    expect(&p, "42");
    for (size_t i = 0; i < p.raw.len; i++) {
        const unsigned char byte = (unsigned char)p.raw.data[i];
        assert_true(byte < 0xFE);
        assert_false(byte == 0xC3 && i + 1 < p.raw.len && p.raw.data[i + 1] == '(');
    }
    quit(&p);
}

int main(void)
{
    if (!make_folder(state_folder) || !make_folder(locales)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_comma_locale),
        cmocka_unit_test(test_comma_locale_in_batch),
        cmocka_unit_test(test_missing_locale),
        cmocka_unit_test(test_invalid_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
