/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every signal that ends the program: the terminal is as it was, the session can be resumed. */
#include "cmocka_testing.h"

#include <glob.h>

#include "long_form.h"
#include "terminal/terminal.h"
#include "terminal/person.h"

/* What the program does not survive, and what it does with a word or without one. */
static const int ending[] = {SIGHUP,    SIGTERM,   SIGQUIT, SIGILL,  SIGTRAP, SIGABRT,
                             SIGBUS,    SIGFPE,    SIGUSR1, SIGSEGV, SIGUSR2, SIGALRM,
                             SIGXCPU,   SIGVTALRM, SIGPROF, SIGIO,   SIGPWR,  SIGSYS,
#ifdef SIGSTKFLT
                             SIGSTKFLT,
#endif
                             40 /* one of those for real time */};
static const int survived[] = {SIGINT,  SIGINT, SIGPIPE,  SIGXFSZ,
                               SIGCHLD, SIGURG, SIGWINCH, SIGCONT};

/* Until the session's file is there, whole. */
static void await_saved(struct person *p)
{
    char pattern[128];
    off_t size = 0, before = -1;
    snprintf(pattern, sizeof pattern, "%s/hooke/session-*.hks", state_folder);
    for (int64_t deadline = clock_ns() + PATIENCE_NS; size == 0 || size != before;) {
        glob_t found = {0};
        struct stat file = {.st_size = 0};
        before = size;
        if (glob(pattern, 0, NULL, &found) == 0)
            assert_int_equal(stat(found.gl_pathv[0], &file), 0);
        size = file.st_size;
        globfree(&found);
        assert_true(clock_ns() < deadline);
        pump(p, 40);
    }
}

static void begin_at(struct person *p, bool plain, bool running, bool saved)
{
    begin(p, (struct start){.argument = {plain ? "--plain" : NULL},
                            .environment = "HOOKE_AUTOSAVE=0.1"});
    expect(p, "hooke>");
    type(p, "m = 321 g; print 9*7\r");
    expect(p, "63");
    if (saved)
        await_saved(p);
    if (running) {
        type(p, plain ? "method verlet; run 1e7 s --force\r" : "run 1000 s\r");
        expect(p, plain ? "1e7 s --force" : "RUNNING");
    }
}

/* Without a prompt: what was set is there. The file goes. */
static void expect_resumable(void)
{
    char line[256], said[64] = "";
    const char *hooke = getenv("HOOKE");
    snprintf(line, sizeof line, "XDG_STATE_HOME=%s %s -n --resume -c 'print m' 2>/dev/null",
             state_folder, hooke ? hooke : "build/hooke");
    FILE *program = popen(line, "r");
    assert_non_null(program);
    while (fgets(said, sizeof said, program)) {
    }
    assert_int_equal(pclose(program), 0);
    assert_string_equal(said, "321 g\n");
    snprintf(line, sizeof line, "rm -f %s/hooke/session-*.hks", state_folder);
    assert_int_equal(system(line), 0);
}

static void end_by(int number, bool plain, bool running, bool saved)
{
    struct person p;
    if (number == SIGALRM && plain && !running)
        return; /* the prompt's own clock: it saves */
    begin_at(&p, plain, running, saved);
    assert_int_equal(kill(p.program, number), 0);
    const int status = end(&p);
    const bool with_a_word = number == SIGHUP || number == SIGTERM;
    if (with_a_word ? !WIFEXITED(status) || WEXITSTATUS(status) != 128 + number
                    : !WIFSIGNALED(status) || WTERMSIG(status) != number)
        fail_msg("%s: signal %d, wait status %d", plain ? "plain" : "panes", number, status);
    if (saved)
        expect_resumable();
}

static void test_ending(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT_OF(ending); i++)
        for (size_t plain = 0; plain < 2; plain++)
            for (size_t running = 0; running < 2; running++)
                if (is_long() || (i + plain + running) % 2 == 0)
                    end_by(ending[i], plain, running, is_long() || (i % 8 == 3 && running));
}

static void test_survived(void **state)
{
    (void)state;
    for (size_t plain = 0; plain < 2; plain++) {
        struct person p;
        begin_at(&p, plain, false, false);
        for (size_t i = 0; i < COUNT_OF(survived); i++)
            assert_int_equal(kill(p.program, survived[i]), 0);
        for (int64_t deadline = clock_ns() + PATIENCE_NS; !shows(&p, "4242");) {
            settle(&p, 20);
            type(&p, "\025print 42*101\r"); /* what was typed before a Ctrl-C is found is lost */
            pump(&p, 100);
            assert_true(clock_ns() < deadline);
        }
        quit(&p);
    }
}

int main(int argc, char **argv)
{
    if (!make_folder(state_folder)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ending),
        cmocka_unit_test(test_survived),
    };
    if (argc > 1) {
        cmocka_set_test_filter(argv[1]);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
