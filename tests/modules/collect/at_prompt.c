/* SPDX-License-Identifier: GPL-3.0-or-later */
/* collect at a serial line and in panes: the line is left as it was found, what was unplugged is
 * kept, and while it comes one can type. */
#include "cmocka_testing.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "long_form.h"
#include "terminal/person.h"
#include "terminal/terminal.h"

static char work[] = "/tmp/hooke-collect-XXXXXX";

static const char *in_work(const char *name)
{
    static char path[4][100];
    static int which;
    which = (which + 1) % 4;
    snprintf(path[which], sizeof path[which], "%s/%s", work, name);
    return path[which];
}

/* A process that writes a swing, 800 lines a second that say they are 5 ms apart, so many of them
 * (0: until it is killed). */
static pid_t sensor(int fd, int lines)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0)
        return child;
    alarm(280); /* also where the test ends early */
    signal(SIGALRM, SIG_DFL);
    const int64_t begin = clock_ns();
    for (int i = 0; lines == 0 || i < lines; i++) {
        char line[64];
        const double t = 0.005 * i;
        const int len =
            snprintf(line, sizeof line, "%.3f\t%.3f\r\n", t, 20 + 5 * exp(-0.05 * t) * cos(9 * t));
        if (write(fd, line, (size_t)len) != len)
            break;
        const int64_t left = begin + (int64_t)(i + 1) * 5 * MS / 4 - clock_ns();
        const struct timespec rest = {(time_t)(left / 1000000000), (long)(left % 1000000000)};
        if (left > 0)
            nanosleep(&rest, NULL);
    }
    _exit(0);
}

static pid_t launch(const char *command, int out)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const char *hooke = getenv("HOOKE");
        dup2(out, STDOUT_FILENO);
        dup2(out, STDERR_FILENO);
        execl(hooke ? hooke : "build/hooke", "hooke", "-n", "-c", command, (char *)NULL);
        _exit(127);
    }
    return child;
}

static int status_of(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

static void said(int fd, struct buffer *text)
{
    char chunk[4096];
    ssize_t got;
    while ((got = read(fd, chunk, sizeof chunk)) > 0)
        buffer_put(text, (struct text){chunk, (size_t)got});
    close(fd);
}

static void contains(const struct buffer *text, const char *part)
{
    if (!strstr(buffer_view(text), part))
        fail_msg("'%s' is not in: %s", part, buffer_view(text));
}

static int lines_in(const char *path)
{
    struct buffer text = {0};
    struct error error;
    int lines = 0;
    if (file_read(path, 1 << 24, &text, &error))
        for (size_t i = 0; i < text.len; i++)
            lines += text.data[i] == '\n';
    buffer_free(&text);
    return lines;
}

/* Until the file has so many lines. */
static void await_lines(const char *path, int lines)
{
    for (const int64_t until = clock_ns() + PATIENCE_NS; clock_ns() < until; poll(NULL, 0, 10))
        if (lines_in(path) >= lines)
            return;
    fail_msg("%s has no %d lines", path, lines);
}

static bool is_raw(int slave)
{
    struct termios modes;
    return tcgetattr(slave, &modes) == 0 && !(modes.c_lflag & ICANON);
}

static void await_raw(int slave)
{
    const int64_t until = clock_ns() + PATIENCE_NS;
    while (!is_raw(slave)) {
        assert_true(clock_ns() < until);
        poll(NULL, 0, 5);
    }
}

struct line {
    int master, slave;
    char name[100];
    struct termios before;
};

static void make_line(struct line *line)
{
    assert_int_equal(openpty(&line->master, &line->slave, line->name, NULL, NULL), 0);
    fcntl(line->master, F_SETFD, FD_CLOEXEC); /* the program would hold its own line open */
    fcntl(line->slave, F_SETFD, FD_CLOEXEC);
    assert_int_equal(tcgetattr(line->slave, &line->before), 0);
}

static bool as_before(const struct line *line)
{
    struct termios after;
    return tcgetattr(line->slave, &after) == 0 && line->before.c_iflag == after.c_iflag &&
           line->before.c_oflag == after.c_oflag && line->before.c_cflag == after.c_cflag &&
           line->before.c_lflag == after.c_lflag &&
           memcmp(line->before.c_cc, after.c_cc, sizeof after.c_cc) == 0;
}

static void drop_line(struct line *line)
{
    close(line->slave);
    close(line->master);
}

static void test_serial_line(void **state)
{
    (void)state;
    for (int unplugged = 0; unplugged < 2; unplugged++) {
        int out[2];
        char command[300];
        struct line line;
        struct buffer text = {0};
        make_line(&line);
        assert_int_equal(pipe(out), 0);
        const char *path = in_work(unplugged ? "gone.txt" : "whole.txt");
        snprintf(command, sizeof command, "collect %s for=%s unit=cm to=%s; fit damped", line.name,
                 unplugged ? "60s" : "1.6s", path);
        const pid_t program = launch(command, out[1]);
        close(out[1]); /* or the device would hold it open */
        await_raw(line.slave);
        const pid_t device = sensor(line.master, 0);
        if (unplugged) {
            await_lines(path, 320);
            kill(device, SIGKILL);
            status_of(device);
            drop_line(&line);
        }
        said(out[0], &text);
        assert_int_equal(status_of(program), 0);
        contains(&text, unplugged ? "(unplugged)" : "(ok)");
        contains(&text, "T = 0.698");
        if (!unplugged) {
            kill(device, SIGKILL);
            status_of(device);
            assert_true(as_before(&line));
            drop_line(&line);
        }
        buffer_free(&text);
    }
}

/* Whatever ends the program gives the line back; only SIGKILL cannot be answered. */
static void test_ending_signals(void **state)
{
    (void)state;
    static const int few[] = {SIGINT,  SIGTERM, SIGHUP,  SIGQUIT, SIGSEGV,
                              SIGABRT, SIGUSR1, SIGALRM, SIGXCPU, SIGSYS};
    const int most[] = {SIGILL,  SIGTRAP, SIGBUS, SIGFPE,    SIGUSR2,  SIGVTALRM,
                        SIGPROF, SIGPOLL, SIGPWR, SIGSTKFLT, SIGRTMIN, SIGRTMAX};
    const size_t count = COUNT_OF(few) + (is_long() ? COUNT_OF(most) : 0);
    for (size_t i = 0; i < count; i++) {
        const int number = i < COUNT_OF(few) ? few[i] : most[i - COUNT_OF(few)];
        struct line line;
        struct buffer text = {0};
        char command[300];
        int out[2], status;
        make_line(&line);
        assert_int_equal(pipe(out), 0);
        snprintf(command, sizeof command, "collect %s to=%s", line.name, in_work("ended.txt"));
        const pid_t program = launch(command, out[1]);
        close(out[1]);
        await_raw(line.slave);
        const pid_t device = sensor(line.master, 0);
        await_lines(in_work("ended.txt"), 20);
        kill(program, number);
        said(out[0], &text);
        assert_int_equal(waitpid(program, &status, 0), program);
        kill(device, SIGKILL);
        status_of(device);
        if (!as_before(&line))
            fail_msg("signal %d: the line is not as it was", number);
        await_lines(in_work("ended.txt"), 20); /* and what came is there */
        unlink(in_work("ended.txt"));
        buffer_free(&text);
        drop_line(&line);
    }
}

static void test_two_programs(void **state)
{
    (void)state;
    struct line line;
    struct buffer first = {0}, second = {0};
    char command[300];
    int out[2], other[2];
    make_line(&line);
    assert_int_equal(pipe2(out, O_CLOEXEC), 0);
    assert_int_equal(pipe2(other, O_CLOEXEC), 0);
    snprintf(command, sizeof command, "collect %s to=%s", line.name, in_work("one.txt"));
    const pid_t program = launch(command, out[1]);
    await_raw(line.slave);
    snprintf(command, sizeof command, "collect %s to=%s", line.name, in_work("two.txt"));
    const pid_t late = launch(command, other[1]);
    close(out[1]);
    close(other[1]);
    said(other[0], &second);
    assert_int_equal(status_of(late), 4);
    contains(&second, "another program is collecting from it");
    assert_int_equal(access(in_work("two.txt"), F_OK), -1);
    assert_true(is_raw(line.slave)); /* the first one's modes stay */
    kill(program, SIGINT);
    said(out[0], &first);
    status_of(program);
    assert_true(as_before(&line));
    buffer_free(&first);
    buffer_free(&second);
    drop_line(&line);
}

/* A board that is plugged in again starts its clock again. */
static void test_plugged_in_again(void **state)
{
    (void)state;
    char link[100], command[400], path[100];
    snprintf(link, sizeof link, "%s", in_work("board"));
    snprintf(path, sizeof path, "%s", in_work("board.txt"));
    for (int again = 0; again < 2; again++) {
        struct line line;
        struct buffer text = {0};
        int out[2];
        make_line(&line);
        unlink(link);
        assert_int_equal(symlink(line.name, link), 0);
        assert_int_equal(pipe2(out, O_CLOEXEC), 0);
        if (again)
            snprintf(command, sizeof command, "load %s unit=cm; collect continue", path);
        else
            snprintf(command, sizeof command, "collect %s unit=cm tunit=s to=%s", link, path);
        const pid_t program = launch(command, out[1]);
        close(out[1]);
        await_raw(line.slave);
        const int there = again ? lines_in(path) : 0;
        poll(NULL, 0, 1000); /* what comes sooner may lack its beginning */
        const pid_t device = sensor(line.master, 0);
        await_lines(path, there + 160);
        kill(device, SIGKILL);
        status_of(device);
        drop_line(&line);
        said(out[0], &text);
        assert_int_equal(status_of(program), 0);
        contains(&text, "(unplugged)");
        if (again)
            contains(&text, "restarted 1 time");
        assert_null(strstr(buffer_view(&text), "goes back"));
        assert_null(strstr(buffer_view(&text), "garbled"));
        buffer_free(&text);
    }
}

static void test_panes(void **state)
{
    (void)state;
    struct person p;
    char line[300];
    char pipe[100];
    snprintf(pipe, sizeof pipe, "%s", in_work("sensor"));
    assert_int_equal(mkfifo(pipe, 0600), 0);
    const int fd = open(pipe, O_RDWR);
    const pid_t device = sensor(fd, 0);
    start_panes(&p, (struct start){.width = 100, .height = 30});
    snprintf(line, sizeof line, "collect %s unit=cm to=%s\r", pipe, in_work("panes.txt"));
    type(&p, line);
    expect(&p, "COLLECTING");
    expect(&p, "T=");
    expect(&p, " ms late"); /* beneath the panes of velocities: the state line is often full */
    type(&p, "print 6*7\r");
    expect(&p, "42");
    type(&p, "run 1 s\r");
    expect(&p, "run is not possible now");
    type(&p, "m = 200 g; fit damped --live\r"); /* the scene is laid over it, too */
    expect(&p, "fit T=0.698");
    expect(&p, " k=16.");
    expect(&p, "-- spring");
    type(&p, "k = 17 N/m\r");
    expect(&p, "k = 17 N/m");
    type(&p, "collect pause\r");
    expect(&p, "PAUSED");
    type(&p, "collect continue\r");
    expect(&p, "COLLECTING");
    type(&p, "measure period\r");
    expect(&p, "T = 0.698");
    type(&p, "stop\r");
    expect(&p, "(stopped)");
    expect(&p, "q: panes)>"); /* it is more than the log has room for */
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "data\r");
    expect(&p, "panes ");
    snprintf(line, sizeof line, "collect %s unit=cm to=%s\r", pipe, in_work("again.txt"));
    type(&p, line);
    expect(&p, "COLLECTING");
    await_lines(in_work("again.txt"), 30);
    type(&p, "\x03");
    expect(&p, "again.txt: ");
    expect(&p, "q: panes)>");
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
    kill(device, SIGKILL);
    status_of(device);
    close(fd);
}

static volatile sig_atomic_t second;

static void go_second(int number)
{
    (void)number;
    second = 1;
}

/* A process that reads 19.6 cm, and 39.1 cm after SIGUSR1: 100 lines a second. */
static pid_t holder(int fd)
{
    signal(SIGUSR1, go_second);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) {
        signal(SIGUSR1, SIG_DFL);
        return child;
    }
    alarm(120);
    signal(SIGALRM, SIG_DFL);
    for (int i = 0;; i++) {
        char line[64];
        const int len =
            snprintf(line, sizeof line, "%.2f\t%.2f\r\n", 0.01 * i, second ? 39.1 : 19.6);
        if (write(fd, line, (size_t)len) != len)
            _exit(0);
        poll(NULL, 0, 10);
    }
}

/* Two points are taken while it is collected: what it was before is read by them, too. */
static void test_calibrate(void **state)
{
    (void)state;
    struct person p;
    char line[300], name[100];
    char path[100];
    snprintf(path, sizeof path, "%s", in_work("held.txt"));
    snprintf(name, sizeof name, "%s", in_work("held"));
    assert_int_equal(mkfifo(name, 0600), 0);
    const int fd = open(name, O_RDWR);
    const pid_t device = holder(fd);
    start_panes(&p, (struct start){.width = 100, .height = 30});
    snprintf(line, sizeof line, "collect %s unit=cm to=%s\r", name, path);
    type(&p, line);
    expect(&p, "COLLECTING");
    await_lines(path, 150);
    type(&p, "calibrate y 20 cm 40 cm\r");
    expect(&p, "hold it at 20 cm, then type: calibrate take");
    type(&p, "calibrate take\r");
    expect(&p, "hold it at 40 cm, then type: calibrate take");
    kill(device, SIGUSR1);
    await_lines(path, 600); /* the last second is all of the second level */
    type(&p, "calibrate take\r");
    expect(&p, "1.02564 cm for each cm");
    type(&p, "zero\r");
    expect(&p, "means 0 cm; 1.02564 cm for each cm");
    type(&p, "stop\r");
    expect(&p, "(stopped)");
    expect(&p, "q: panes)>");
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
    kill(device, SIGKILL);
    status_of(device);
    close(fd);
    int out[2];
    struct buffer text = {0};
    assert_int_equal(pipe(out), 0);
    snprintf(line, sizeof line, "load %s", path);
    const pid_t program = launch(line, out[1]);
    close(out[1]);
    said(out[0], &text);
    status_of(program);
    contains(&text, "calibrated: 19.6 cm -20 cm 39.1 cm 0 cm");
    buffer_free(&text);
}

/* Until the one session that is saved knows of that. */
static void await_saved(struct person *p, const char *what)
{
    const int64_t until = clock_ns() + PATIENCE_NS;
    char pattern[128];
    snprintf(pattern, sizeof pattern, "%s/hooke/session-*.hks", state_folder);
    for (bool there = false; !there; pump(p, 20)) {
        glob_t found = {0};
        struct buffer text = {0};
        struct error error;
        if (glob(pattern, 0, NULL, &found) == 0 &&
            file_read(found.gl_pathv[0], 1 << 24, &text, &error))
            there = memmem(text.data, text.len, what, strlen(what)) != NULL;
        buffer_free(&text);
        globfree(&found);
        assert_true(clock_ns() < until);
    }
}

/* Killed in the panes: the next session has all that came. */
static void test_killed(void **state)
{
    (void)state;
    struct person p;
    char line[300];
    char pipe[100];
    snprintf(state_folder, sizeof state_folder, "%s", "/tmp/hooke-panes-XXXXXX");
    assert_true(make_folder(state_folder)); /* of this test alone */
    snprintf(pipe, sizeof pipe, "%s", in_work("killed"));
    assert_int_equal(mkfifo(pipe, 0600), 0);
    const int fd = open(pipe, O_RDWR);
    const pid_t device = sensor(fd, 0);
    start_panes(&p, (struct start){.width = 100, .height = 30});
    snprintf(line, sizeof line, "collect %s unit=cm to=%s\r", pipe, in_work("lost.txt"));
    type(&p, line);
    expect(&p, "COLLECTING");
    await_lines(in_work("lost.txt"), 400);
    await_saved(&p, "lost.txt");
    kill(p.program, SIGKILL);
    wait_end(&p);
    forget(&p);
    start_panes(&p, (struct start){.width = 100, .height = 30, .argument = {"--resume"}});
    expect(&p, "1 recording");
    snprintf(line, sizeof line, "collect continue\r");
    type(&p, line);
    expect(&p, "COLLECTING");
    type(&p, "stop\r");
    expect(&p, "(stopped)");
    expect(&p, "q: panes)>");
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
    kill(device, SIGKILL);
    status_of(device);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_serial_line),  cmocka_unit_test(test_ending_signals),
        cmocka_unit_test(test_two_programs), cmocka_unit_test(test_plugged_in_again),
        cmocka_unit_test(test_panes),        cmocka_unit_test(test_calibrate),
        cmocka_unit_test(test_killed)};
    signal(SIGPIPE, SIG_IGN);
    return make_folder(state_folder) && make_folder(work)
               ? cmocka_run_group_tests(tests, NULL, NULL)
               : 1;
}
