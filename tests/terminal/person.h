/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A person at a terminal: types, looks at the screen, waits for what should appear there. Never
 * sleeps. */
#pragma once

#include <hooke/base/cancel.h>
#include <time.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <time.h>
#include <utmp.h>

#include "terminal/emulator.h"
#include "terminal/folder.h"

/* what has not come by then will not come; generous for sanitizers on a busy machine */
#define PATIENCE_NS (getenv("HASTE") ? 3000000000 : 60000000000)
#define MS 1000000

struct person {
    pid_t program; /* or the shell that stands before it */
    int stopped; /* a byte comes from here whenever the program has stopped, and when it goes on */
    int fd;
    struct emulator screen;
    struct buffer raw; /* everything the program sent */
    bool silent;       /* the terminal does not answer questions */
    int answered;
    long rate;         /* [byte/s] of the link, 0: as fast as can be */
    int64_t link_free; /* [clock_ns] when the link can carry the next byte */
    bool hung_up;
    struct termios before;
};

/* How the program is started; zero means as usual. */
struct start {
    const char *term, *locale, *state, *environment; /* environment: one more NAME=value */
    const char *argument[6];
    const char *root; /* all that it sees of the system, and the program in it */
    int width, height;
    bool silent;
    /* a shell stands between that sees the program stop: without one the system ignores Ctrl-Z */
    bool shell;
};

static char state_folder[] = "/tmp/hooke-panes-XXXXXX";

/* The least of a shell: starts the program in the foreground, says when it stops, continues it on
 * SIGUSR1, ends as it does. */
static inline void be_shell(int report)
{
    sigset_t usr1;
    int status = 0;
    sigemptyset(&usr1);
    sigaddset(&usr1, SIGUSR1);
    sigprocmask(SIG_BLOCK, &usr1, NULL);
    static const int ignored[] = {SIGTTOU, SIGINT, SIGQUIT, SIGTSTP};
    for (size_t i = 0; i < COUNT_OF(ignored); i++) {
        signal(ignored[i], SIG_IGN);
    }
    const pid_t program = fork();
    if (program == 0) {
        setpgid(0, 0);
        tcsetpgrp(STDIN_FILENO, getpid());
        for (size_t i = 0; i < COUNT_OF(ignored); i++) {
            signal(ignored[i], SIG_DFL);
        }
        sigprocmask(SIG_UNBLOCK, &usr1, NULL);
        return;
    }
    setpgid(program, program);
    while (waitpid(program, &status, WUNTRACED) == program && WIFSTOPPED(status)) {
        tcsetpgrp(STDIN_FILENO, getpid());
        if (write(report, "", 1) != 1) {
            break;
        }
        int number;
        sigwait(&usr1, &number);
        tcsetpgrp(STDIN_FILENO, program);
        kill(program, SIGCONT);
        if (write(report, "", 1) != 1) {
            break;
        }
    }
    _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 126);
}

/* Made the root of all paths: by root, or in a user namespace where those are allowed. */
static inline bool enter_root(const char *path)
{
    return (geteuid() == 0 || unshare(CLONE_NEWUSER) == 0) && chroot(path) == 0 && chdir("/") == 0;
}

static inline void begin(struct person *p, struct start start)
{
    *p = (struct person){.fd = -1, .silent = start.silent};
    struct winsize size = {.ws_row = (unsigned short)(start.height ? start.height : 24),
                           .ws_col = (unsigned short)(start.width ? start.width : 80)};
    int slave;
    emulator_size(&p->screen, size.ws_col, size.ws_row);
    p->screen.eager = start.term && strcmp(start.term, "ansi") == 0;
    assert_int_equal(openpty(&p->fd, &slave, NULL, NULL, &size), 0);
    assert_int_equal(tcgetattr(slave, &p->before), 0);
    int report[2];
    assert_int_equal(pipe(report), 0);
    p->stopped = report[0];
    p->program = fork();
    assert_true(p->program >= 0);
    if (p->program == 0) {
        close(p->fd);
        close(report[0]);
        login_tty(slave);
        if (start.shell) {
            be_shell(report[1]);
        }
        close(report[1]);
        if (start.term && !*start.term) {
            unsetenv("TERM");
        } else {
            setenv("TERM", start.term ? start.term : "xterm-256color", 1);
        }
        setenv("LC_ALL", start.locale ? start.locale : "C.UTF-8", 1);
        setenv("XDG_STATE_HOME", start.state ? start.state : state_folder, 1);
        setenv("XDG_CONFIG_HOME", state_folder, 1);
        setenv("INPUTRC", "/dev/null", 1);
        unsetenv("NO_COLOR");
        if (start.environment) {
            putenv(strdup(start.environment));
        }
        const char *hooke = start.root ? "/hooke" : getenv("HOOKE");
        if (start.root && !enter_root(start.root)) {
            _exit(127);
        }
        char *argv[8] = {strdup("hooke")};
        for (size_t i = 0; i < COUNT_OF(start.argument) && start.argument[i]; i++) {
            argv[i + 1] = strdup(start.argument[i]);
        }
        execv(hooke ? hooke : "build/hooke", argv);
        _exit(127);
    }
    close(slave);
    close(report[1]);
}

static inline void type(struct person *p, const char *keys)
{
    size_t len = strlen(keys);
    while (len > 0) {
        const ssize_t n = write(p->fd, keys, len);
        assert_true(n > 0);
        keys += n;
        len -= (size_t)n;
    }
}

/* Processor time of the program so far [ns]: what it does in answer is bounded by work, not by the
 * clock. */
static inline int64_t work_ns(pid_t program)
{
    clockid_t clock;
    struct timespec used = {0, 0};
    assert_int_equal(clock_getcpuclockid(program, &clock), 0);
    assert_int_equal(clock_gettime(clock, &used), 0);
    return (int64_t)used.tv_sec * 1000000000 + used.tv_nsec;
}

/* The most [ns] of it between a Ctrl-C and the answer. */
static inline int64_t work_most(void)
{
    const char *config = getenv("CONFIG");
    return (config && strcmp(config, "asan") == 0 ? 3000 : 300) * (int64_t)MS;
}

/* Reads what the program sends, for up to `ms`. False: nothing came, or it has ended. */
static inline bool pump(struct person *p, int ms)
{
    struct pollfd ready = {.fd = p->fd, .events = POLLIN};
    char chunk[4096];
    size_t max = sizeof chunk;
    if (p->rate > 0) { /* a slow link: a few bytes at a time, no earlier than it can carry them */
        const int64_t wait = p->link_free - clock_ns();
        if (wait > 0 && poll(NULL, 0, (int)(wait / MS) + 1) < 0) {
            return true;
        }
        max = 32;
    }
    if (p->hung_up || poll(&ready, 1, ms) <= 0) {
        return false;
    }
    const ssize_t got = read(p->fd, chunk, max);
    if (got <= 0) {
        p->hung_up = true;
        return false;
    }
    const int64_t now = clock_ns();
    if (p->rate > 0) {
        p->link_free =
            (p->link_free > now - 10 * MS ? p->link_free : now) + got * 1000000000 / p->rate;
    }
    buffer_put(&p->raw, (struct text){chunk, (size_t)got});
    for (ssize_t i = 0; i < got; i++) {
        emulator_feed(&p->screen, chunk[i]);
    }
    while (!p->silent && p->answered < p->screen.questions) {
        p->answered++;
        type(p, "\033[0n");
    }
    return true;
}

static inline bool shows(const struct person *p, const char *text)
{
    struct buffer row = {0};
    bool found = false;
    for (int y = 0; y < p->screen.height && !found; y++) {
        buffer_clear(&row);
        emulator_row(&p->screen, y, &row);
        found = strstr(row.data, text) != NULL;
    }
    buffer_free(&row);
    return found;
}

static inline void show_screen(const struct person *p)
{
    struct buffer row = {0};
    print_message("# the screen, cursor at %d,%d:\n", p->screen.x, p->screen.y);
    for (int y = 0; y < p->screen.height; y++) {
        buffer_clear(&row);
        emulator_row(&p->screen, y, &row);
        print_message("# %s\n", row.data);
    }
    buffer_free(&row);
}

static inline void wait_for(struct person *p, const char *text, bool there)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    while (shows(p, text) != there) {
        if (clock_ns() > deadline || p->hung_up) {
            print_message("# waited in vain for '%s' to %s%s\n", text, there ? "appear" : "go",
                          p->hung_up ? ": the program has ended" : "");
            show_screen(p);
            fail();
        }
        pump(p, 200);
    }
}

static inline void expect(struct person *p, const char *text)
{
    wait_for(p, text, true);
}

/* The last row. */
static inline void prompt_row(const struct person *p, struct buffer *row)
{
    buffer_clear(row);
    emulator_row(&p->screen, p->screen.height - 1, row);
}

/* Waits until the prompt row is exactly that. */
static inline void expect_prompt(struct person *p, const char *text)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    struct buffer row = {0};
    prompt_row(p, &row);
    while (strcmp(row.data, text) != 0) {
        if (clock_ns() > deadline || p->hung_up) {
            print_message("# waited in vain for the prompt '%s', it is '%s'\n", text, row.data);
            show_screen(p);
            fail();
        }
        pump(p, 200);
        prompt_row(p, &row);
    }
    buffer_free(&row);
}

#define EMPTY_PROMPT "hooke>"

static inline void start_panes(struct person *p, struct start start)
{
    begin(p, start);
    expect_prompt(p, EMPTY_PROMPT);
}

/* Waits until the prompt row ends with `text`: what was typed has been taken. */
static inline void expect_typed(struct person *p, const char *text)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    const size_t len = strlen(text);
    struct buffer row = {0};
    prompt_row(p, &row);
    while (row.len < len || strcmp(row.data + row.len - len, text) != 0) {
        if (clock_ns() > deadline || p->hung_up) {
            print_message("# waited in vain for '%s' at the prompt, it is '%s'\n", text, row.data);
            show_screen(p);
            fail();
        }
        pump(p, 200);
        prompt_row(p, &row);
    }
    buffer_free(&row);
}

/* Types a line and waits until it has been taken: an empty prompt says so only when the line has
 * stood there, by its end at least. */
static inline void enter(struct person *p, const char *line)
{
    const size_t len = strlen(line);
    type(p, line);
    expect_typed(p, line + (len > 6 ? len - 6 : 0));
    type(p, "\r");
    expect_prompt(p, EMPTY_PROMPT);
}

static inline void resize(struct person *p, int width, int height)
{
    const struct winsize size = {.ws_row = (unsigned short)height, .ws_col = (unsigned short)width};
    emulator_size(&p->screen, width, height);
    assert_int_equal(ioctl(p->fd, TIOCSWINSZ, &size), 0);
}

/* It has read what was typed and waits for something, as far as the system knows. */
static inline bool is_waiting(const struct person *p)
{
    char path[32], state = 'S';
    int left = 0;
    snprintf(path, sizeof path, "/proc/%ld/stat", (long)p->program);
    FILE *file = fopen(path, "r");
    if (file && fscanf(file, "%*[^)]) %c", &state) != 1)
        state = 'S';
    if (file)
        fclose(file);
    const int slave = p->fd < 0 ? -1 : open(ptsname(p->fd), O_RDONLY | O_NONBLOCK | O_NOCTTY);
    if (slave >= 0) {
        ioctl(slave, FIONREAD, &left);
        close(slave);
    }
    return left == 0 && strchr("RD", state) == NULL;
}

/* Everything that comes until nothing has come for `ms`; longer where the program is kept from its
 * work. */
static inline void settle(struct person *p, int ms)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    while (pump(p, ms) || (!p->hung_up && !is_waiting(p) && clock_ns() < deadline)) {
    }
}

/* Until so many frames more have been asked about; false: they do not come. */
static inline bool await_frames(struct person *p, int frames)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    while (p->screen.questions < frames && clock_ns() < deadline && !p->hung_up)
        pump(p, 200);
    return p->screen.questions >= frames;
}

static inline void same_modes(const struct person *p)
{
    struct termios now;
    assert_int_equal(tcgetattr(p->fd, &now), 0);
    assert_int_equal(now.c_lflag, p->before.c_lflag);
    assert_int_equal(now.c_iflag, p->before.c_iflag);
    assert_int_equal(now.c_oflag, p->before.c_oflag);
    assert_int_equal(now.c_cflag, p->before.c_cflag);
    assert_memory_equal(now.c_cc, p->before.c_cc, sizeof now.c_cc);
}

static inline void forget(struct person *p)
{
    close(p->stopped);
    if (p->fd >= 0) {
        close(p->fd);
    }
    buffer_free(&p->raw);
    emulator_free(&p->screen);
}

/* Waits until the program has stopped and its last words have come. */
static inline void expect_stop(struct person *p)
{
    struct pollfd stop = {.fd = p->stopped, .events = POLLIN};
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    char byte;
    while (poll(&stop, 1, 0) == 0 && clock_ns() < deadline) {
        pump(p, 50);
    }
    if (poll(&stop, 1, 0) != 1 || read(p->stopped, &byte, 1) != 1) {
        fail_msg("the program did not stop");
    }
    settle(p, 50);
}

/* Continues it, as `fg` would; returns when it has the terminal. */
static inline void continue_program(struct person *p)
{
    char byte;
    assert_int_equal(kill(p->program, SIGUSR1), 0);
    assert_int_equal(read(p->stopped, &byte, 1), 1);
}

/* Waits for the end of the program; returns its wait status. */
static inline int wait_end(struct person *p)
{
    int status = 0;
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    pid_t ended;
    while ((ended = waitpid(p->program, &status, WNOHANG)) == 0 && clock_ns() < deadline) {
        if (p->fd < 0 || !pump(p, 10)) {
            poll(NULL, 0, 5);
        }
    }
    if (ended == 0) {
        show_screen(p);
        kill(p->program, SIGKILL);
        waitpid(p->program, &status, 0);
        fail_msg("the program did not end");
    }
    while (p->fd >= 0 && pump(p, 0)) {
    }
    return status;
}

/* The end, and a terminal that is as it was. */
static inline int end(struct person *p)
{
    const int status = wait_end(p);
    same_modes(p);
    assert_false(p->screen.second_screen);
    assert_false(p->screen.pasting);
    assert_false(p->screen.hidden);
    if (p->screen.unknown > 0) {
        fail_msg("the emulator does not know %d sequences, the last is ESC%s", p->screen.unknown,
                 p->screen.unknown_text + 1);
    }
    forget(p);
    return status;
}

static inline void quit(struct person *p)
{
    type(p, "\x03\x15quit\r");
    const int status = end(p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}
