/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The real program under a pseudo-terminal: what a person types and sees. Waits for text, never
 * sleeps. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <time.h>
#include <utmp.h>

#include "terminal/terminal.h"
#include "terminal/folder.h"

/* a text that has not come by then will not come; generous for sanitizers on a busy machine */
#define PATIENCE_MS 60000

struct person {
    pid_t program;
    int fd;
    struct buffer seen;
    size_t read_up_to; /* expect() looks only behind what it found last */
    struct termios before;
};

static char state_folder[] = "/tmp/hooke-prompt-XXXXXX";

/* Processor time of the program so far [ns]. */
static int64_t work_ns(pid_t program)
{
    clockid_t clock;
    struct timespec used = {0, 0};
    assert_int_equal(clock_getcpuclockid(program, &clock), 0);
    assert_int_equal(clock_gettime(clock, &used), 0);
    return (int64_t)used.tv_sec * 1000000000 + used.tv_nsec;
}

static void begin(struct person *p, const char *locale)
{
    *p = (struct person){.fd = -1};
    struct winsize size = {.ws_row = 24, .ws_col = 80};
    int slave;
    assert_int_equal(openpty(&p->fd, &slave, NULL, NULL, &size), 0);
    assert_int_equal(tcgetattr(slave, &p->before), 0);
    p->program = fork();
    assert_true(p->program >= 0);
    if (p->program == 0) {
        close(p->fd);
        login_tty(slave);
        setenv("TERM", "xterm-256color", 1);
        setenv("LC_ALL", locale, 1);
        setenv("XDG_STATE_HOME", state_folder, 1);
        setenv("XDG_CONFIG_HOME", state_folder, 1);
        setenv("INPUTRC", "/dev/null", 1);
        const char *hooke = getenv("HOOKE");
        execl(hooke ? hooke : "build/hooke", "hooke", "--plain", (char *)NULL);
        _exit(127);
    }
    close(slave);
}

/* Reads what the program writes for up to `ms`; false: nothing more to come. */
static bool pump(struct person *p, int ms)
{
    struct pollfd ready = {.fd = p->fd, .events = POLLIN};
    char chunk[4096];
    if (poll(&ready, 1, ms) <= 0) {
        return false;
    }
    ssize_t got = read(p->fd, chunk, sizeof chunk);
    if (got <= 0) {
        return false;
    }
    buffer_put(&p->seen, (struct text){chunk, (size_t)got});
    return true;
}

static void expect(struct person *p, const char *text)
{
    int64_t deadline = clock_ns() + (int64_t)PATIENCE_MS * 1000000;
    for (;;) {
        const char *found = p->seen.data ? strstr(p->seen.data + p->read_up_to, text) : NULL;
        if (found) {
            p->read_up_to = (size_t)(found - p->seen.data) + strlen(text);
            return;
        }
        if (clock_ns() > deadline || !pump(p, PATIENCE_MS)) {
            print_message("# waited in vain for '%s', saw: %s\n", text,
                          p->seen.data ? p->seen.data + p->read_up_to : "");
            kill(p->program, SIGKILL);
            waitpid(p->program, NULL, 0);
            fail();
        }
    }
}

static void type(struct person *p, const char *keys)
{
    assert_int_equal(write(p->fd, keys, strlen(keys)), (ssize_t)strlen(keys));
}

/* Waits for the end; the terminal must be as it was. Returns the wait status. */
static int end(struct person *p)
{
    int status;
    while (pump(p, 0)) {
    }
    int64_t deadline = clock_ns() + (int64_t)PATIENCE_MS * 1000000;
    pid_t ended;
    while ((ended = waitpid(p->program, &status, WNOHANG)) == 0 && clock_ns() < deadline) {
        pump(p, 20);
    }
    if (ended == 0) {
        kill(p->program, SIGKILL);
        waitpid(p->program, &status, 0);
        fail_msg("the program did not end");
    }
    struct termios after;
    if (tcgetattr(p->fd, &after) == 0) {
        assert_int_equal(after.c_lflag, p->before.c_lflag);
        assert_int_equal(after.c_iflag, p->before.c_iflag);
        assert_int_equal(after.c_oflag, p->before.c_oflag);
        assert_memory_equal(after.c_cc, p->before.c_cc, sizeof after.c_cc);
    }
    close(p->fd);
    buffer_free(&p->seen);
    return status;
}

static void quit(struct person *p)
{
    type(p, "quit\r");
    int status = end(p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

#define PROMPT "hooke> "

static void test_types_and_answers(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "m = 250 g\r");
    expect(&p, "\n");
    expect(&p, "m = 250 g");
    expect(&p, PROMPT);
    type(&p, "print 6*7\r");
    expect(&p, "42");
    expect(&p, PROMPT);
    type(&p, "met rk4\r"); /* prefixes hold at the prompt */
    expect(&p, "rk4");
    type(&p, "plain\r");
    expect(&p, "this is already the plain prompt");
    type(&p, "clear\r");
    expect(&p, "\033[H\033[2J");
    quit(&p);
}

static void test_interrupt_clears_the_line(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "print 111\x03");
    expect(&p, "^C");
    expect(&p, PROMPT);
    type(&p, "\x03"); /* at an empty prompt: does not leave */
    expect(&p, PROMPT);
    type(&p, "print 2*11\r");
    expect(&p, "22");
    expect(&p, PROMPT);
    /* in a history search */
    type(&p, "\x12"
             "pri\x03");
    expect(&p, PROMPT);
    type(&p, "print 3*11\r");
    expect(&p, "33");
    quit(&p);
}

static void test_interrupt_stops_a_run(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "method rk4 dt=1ms\r");
    expect(&p, PROMPT);
    type(&p, "run 20000000 s\r"); /* asked for first */
    expect(&p, "this will take about");
    expect(&p, "[y/N] ");
    type(&p, "n\r");
    expect(&p, "not run");
    expect(&p, PROMPT);
    type(&p, "run 20000000 s\r");
    expect(&p, "[y/N] ");
    type(&p, "y\r");
    expect(&p, "steps"); /* the progress line */
    type(&p, "\x03");
    expect(&p, PROMPT);
    type(&p, "print t > 0\b\b\b\b \r");
    expect(&p, PROMPT);
    type(&p, "runs\r");
    expect(&p, "rk4");
    quit(&p);
}

/* A map says how long it takes and how fast it is; stopped, it goes on. */
static void test_progress_of_a_sweep(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "scene pendulum; method rodas5p; tol = 1e-9; duration = 20 s\r");
    expect(&p, PROMPT);
    type(&p, "sweep gamma=0:1:0.00001 --threads 1 --force\r");
    expect(&p, "s left");
    expect(&p, "points/s");
    type(&p, "\x03");
    expect(&p, "'continue' computes the other points");
    expect(&p, PROMPT);
    type(&p, "continue\r");
    expect(&p, "points/s");
    type(&p, "\x03");
    expect(&p, "'continue' computes the other points");
    expect(&p, PROMPT);
    quit(&p);
}

/* The prompt is back in the time in which a person does not notice that it was away. */
static void interrupted_in_time(struct person *p, const char *line, bool stopped)
{
    type(p, line);
    type(p, "\r");
    expect(p, line);
    expect(p, "\n");
    const int64_t begun = work_ns(p->program);
    type(p, "\x03");
    if (stopped) {
        expect(p, "error: "); /* interrupted before it began, or on the way */
    }
    expect(p, PROMPT);
    const double took = (double)(work_ns(p->program) - begun) * 1e-6;
    print_message("# Ctrl-C in '%s': the prompt is back after %.1f ms of work\n", line, took);
    assert_true(took < (getenv("CONFIG") && strcmp(getenv("CONFIG"), "asan") == 0 ? 3000 : 300));
    type(p, "print 123*1001\r");
    expect(p, "123123");
    expect(p, PROMPT);
}

static void test_interrupt_stops_long_commands(void **state)
{
    (void)state;
    char path[sizeof state_folder + 32], line[sizeof path + 32];
    struct person p;
    snprintf(path, sizeof path, "%s/long.txt", state_folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "t [s]\ty [cm]\n");
    for (int i = 0; i < 50000; i++) { /* eight minutes at the sensor's rate */
        fprintf(file, "%.2f\t%.4f\n", i * 0.01, 22 + 5 * exp(-i * 1e-5) * cos(i * 0.0835));
    }
    fclose(file);
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "set duration 20000 s; set timing full\r");
    expect(&p, "timing = full");
    expect(&p, PROMPT);
    interrupted_in_time(&p, "compare euler verlet rk4 dt=1ms,0.5ms", true);
    snprintf(line, sizeof line, "load %s\r", path);
    type(&p, line);
    expect(&p, "50000 rows");
    expect(&p, PROMPT);
    /* late in a fit the key comes too late: its end is near */
    interrupted_in_time(&p, "fit damped", false);
    quit(&p);
    unlink(path);
}

static void test_completion(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "meth\t");
    expect(&p, "method ");
    type(&p, "symplectic-euler-\t");
    expect(&p, "kick");
    type(&p, "\r");
    expect(&p, PROMPT);
    type(&p, "set gam\t");
    expect(&p, "gamma");
    type(&p, "\x03");
    expect(&p, PROMPT);
    type(&p, "compare eul\t");
    expect(&p, "euler");
    type(&p, "\x03");
    expect(&p, PROMPT);
    quit(&p);
}

static void test_history_is_kept(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "print 7*13\r");
    expect(&p, "91");
    quit(&p);
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "\x1b[A\x1b[A"); /* above the quit */
    expect(&p, "print 7*13");
    type(&p, "\r");
    expect(&p, "91");
    quit(&p);
    char path[sizeof state_folder + 32];
    snprintf(path, sizeof path, "%s/hooke/history", state_folder);
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_mode & 0777, 0600);
}

static void test_paste_stops_at_the_error(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "\x1b[200~print 1001\nprint 1002\nset gama 1\nprint 1004\n\x1b[201~\r");
    expect(&p, "1001");
    expect(&p, "paste:3:");
    expect(&p, "did you mean");
    expect(&p, PROMPT);
    assert_null(strstr(p.seen.data + p.read_up_to, "1004"));
    quit(&p);
}

/* Readline's paste has no end then: a sanitizer sees what is read beyond it. */
static void test_input_ends_in_a_paste(void **state)
{
    (void)state;
    struct person p;
    int status = 0;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "print 1001");
    type(&p, "\x1b[200~ + 1\nprint 1002");
    while (pump(&p, 300)) {
    }
    close(p.fd);
    assert_int_equal(waitpid(p.program, &status, 0), p.program);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 128 + SIGHUP);
    buffer_free(&p.seen);
}

static void test_multibyte_text(void **state)
{
    (void)state;
    static const char *const locales[] = {"C.UTF-8", "C", "xx_YY.UTF-8"};
    for (size_t i = 0; i < COUNT_OF(locales); i++) {
        struct person p;
        begin(&p, locales[i]);
        expect(&p, PROMPT);
        type(&p, "echo \xc5\xbc\xc3\xb3\xc5\x82\xc4\x87 \xe6\x97\xa5\r");
        expect(&p, PROMPT);
        type(&p, "print 1/4\r");
        expect(&p, "0.25");
        quit(&p);
    }
}

static void ended_by(int number)
{
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "print 5*5\r");
    expect(&p, "25");
    expect(&p, PROMPT);
    kill(p.program, number);
    int status = end(&p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 128 + number);
}

static void test_hangup_and_terminate(void **state)
{
    (void)state;
    ended_by(SIGHUP);
    ended_by(SIGTERM);
}

static void test_end_of_input_leaves(void **state)
{
    (void)state;
    struct person p;
    begin(&p, "C.UTF-8");
    expect(&p, PROMPT);
    type(&p, "\x04");
    int status = end(&p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

/* Sixteen sessions side by side: no line lost, none interleaved. */
static void test_history_under_a_lock(void **state)
{
    (void)state;
    enum { SESSIONS = 16, LINES = 100 };
    char folder[] = "/tmp/hooke-history-XXXXXX";
    assert_non_null(make_folder(folder));
    setenv("XDG_STATE_HOME", folder, 1);
    for (int s = 0; s < SESSIONS; s++) {
        if (fork() == 0) {
            for (int i = 0; i < LINES; i++) {
                char line[64];
                snprintf(line, sizeof line, "print %d + 0.%03d", s, i);
                assert_true(history_append(line, &(struct error){0}));
            }
            _exit(0);
        }
    }
    int status;
    while (wait(&status) > 0) {
        assert_int_equal(status, 0);
    }
    char path[64];
    snprintf(path, sizeof path, "%s/hooke/history", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[256];
    bool found[SESSIONS][LINES] = {{false}};
    int count = 0;
    while (fgets(line, sizeof line, file)) {
        int s;
        int i;
        assert_int_equal(sscanf(line, "print %d + 0.%d\n", &s, &i), 2);
        found[s][i] = true;
        count++;
    }
    fclose(file);
    assert_int_equal(count, SESSIONS * LINES);
    for (int s = 0; s < SESSIONS; s++) {
        for (int i = 0; i < LINES; i++) {
            assert_true(found[s][i]);
        }
    }
}

int main(void)
{
    if (!make_folder(state_folder)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types_and_answers),
        cmocka_unit_test(test_interrupt_clears_the_line),
        cmocka_unit_test(test_interrupt_stops_a_run),
        cmocka_unit_test(test_progress_of_a_sweep),
        cmocka_unit_test(test_completion),
        cmocka_unit_test(test_interrupt_stops_long_commands),
        cmocka_unit_test(test_history_is_kept),
        cmocka_unit_test(test_paste_stops_at_the_error),
        cmocka_unit_test(test_input_ends_in_a_paste),
        cmocka_unit_test(test_multibyte_text),
        cmocka_unit_test(test_hangup_and_terminate),
        cmocka_unit_test(test_end_of_input_leaves),
        cmocka_unit_test(test_history_under_a_lock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
