/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Work in a process of its own: whatever happens there, here it is done or an error. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>
#include <hooke/base/child.h>

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define LARGE 3000000
#define BEFORE "there before; "

typedef bool child_work(const void *context, struct buffer *out, struct error *error);

static volatile sig_atomic_t handled; /* signals that reached a handler of this program */

static void on_signal(int number)
{
    handled = number;
}

/* What comes back, behind what was there. */
static bool run(child_work *work, const void *context, struct buffer *out, struct error *error)
{
    const struct child child = {
        .work = work, .context = context, .what = "it was not made", .patience = 20};
    *error = (struct error){0};
    *out = (struct buffer){0};
    buffer_put(out, TEXT(BEFORE));
    const bool ok = child_run(&child, out, error);
    int status;
    assert_int_equal(waitpid(-1, &status, WNOHANG), -1); /* nobody is left behind */
    assert_int_equal(errno, ECHILD);
    return ok;
}

static void expect_failure(child_work *work, const void *context, enum error_code code,
                           const char *wanted)
{
    struct buffer out;
    struct error error;
    assert_false(run(work, context, &out, &error));
    assert_int_equal(error.code, code);
    if (!strstr(error.text, wanted))
        fail_msg("'%s' does not say '%s'", error.text, wanted);
    assert_string_equal(out.data, BEFORE);
    buffer_free(&out);
}

static bool says(const void *context, struct buffer *out, struct error *error)
{
    (void)error;
    buffer_put(out, text_of(context));
    return true;
}

static bool makes_much(const void *context, struct buffer *out, struct error *error)
{
    (void)context, (void)error;
    for (int i = 0; i < LARGE; i++)
        buffer_char(out, (char)(i * 7));
    return true;
}

TEST(what_is_made_comes_whole)
{
    static const char *const made[] = {"", "a picture"};
    struct buffer out;
    struct error error;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(made); i++) {
        assert_true(run(says, made[i], &out, &error));
        assert_memory_equal(out.data, BEFORE, sizeof BEFORE - 1);
        assert_string_equal(out.data + sizeof BEFORE - 1, made[i]);
        buffer_free(&out);
    }
    assert_true(run(makes_much, NULL, &out, &error));
    assert_int_equal(out.len, sizeof BEFORE - 1 + LARGE);
    for (size_t i = 0; i < LARGE; i++)
        if (out.data[sizeof BEFORE - 1 + i] != (char)(i * 7))
            fail_msg("byte %zu is another", i);
    buffer_free(&out);
}

static bool refuses(const void *context, struct buffer *out, struct error *error)
{
    (void)context;
    buffer_put(out, TEXT("half of it"));
    error_set(error, ERROR_NUMERICAL, "there is no such thing");
    return error_hint(error, "try another");
}

static bool has_no_memory(const void *context, struct buffer *out, struct error *error)
{
    (void)context, (void)error;
    return out->failed = true;
}

TEST(what_fails_says_why)
{
    struct buffer out;
    struct error error;
    (void)state;
    expect_failure(refuses, NULL, ERROR_NUMERICAL, "there is no such thing");
    assert_false(run(refuses, NULL, &out, &error));
    assert_string_equal(error.hint, "try another");
    buffer_free(&out);
    expect_failure(has_no_memory, NULL, ERROR_COMMAND, "out of memory");
}

static bool dies(const void *context, struct buffer *out, struct error *error)
{
    (void)error;
    buffer_put(out, TEXT("half of it"));
    raise(*(const int *)context);
    return true; /* not if it is a signal that ends a process */
}

static bool leaves(const void *context, struct buffer *out, struct error *error)
{
    (void)out, (void)error;
    _exit(*(const int *)context);
}

/* Every signal that ends a process, whatever this program makes of it. */
TEST(what_dies_is_an_error)
{
    static const int ending[] = {SIGSEGV, SIGABRT, SIGBUS,  SIGFPE,  SIGILL,  SIGKILL, SIGTERM,
                                 SIGINT,  SIGHUP,  SIGPIPE, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM,
                                 SIGPROF, SIGXCPU, SIGXFSZ, SIGTRAP, SIGIO};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(ending); i++) {
        void (*before)(int) = ending[i] == SIGKILL ? SIG_DFL : signal(ending[i], on_signal);
        expect_failure(dies, &ending[i], ERROR_IO, "it was not made: ");
        if (ending[i] != SIGKILL)
            signal(ending[i], before);
    }
    assert_int_equal(handled, 0);
    expect_failure(dies, &(int){SIGSEGV}, ERROR_IO, "crashed (signal 11)");
    expect_failure(dies, &(int){SIGKILL}, ERROR_IO, "its process was killed");
    expect_failure(dies, &(int){SIGXCPU}, ERROR_IO, "more processor time than allowed");
    for (int status = 0; status < 2; status++)
        expect_failure(leaves, &status, ERROR_IO, "ended early");
}

static bool never_ends(const void *context, struct buffer *out, struct error *error)
{
    (void)context, (void)out, (void)error;
    while (pause())
        ;
    return true;
}

static bool stopped_later(const void *context)
{
    int *looks = (int *)(uintptr_t)context;
    return --*looks < 0;
}

TEST(what_does_not_end_is_ended)
{
    int looks = 3;
    struct child child = {never_ends, NULL, NULL, "it was not made", 0.1};
    struct buffer out = {0};
    struct error error = {0};
    (void)state;
    const int64_t begin = clock_ns();
    assert_false(child_run(&child, &out, &error));
    assert_string_equal(error.text, "it was not made: it took too long");
    assert_int_equal(error.code, ERROR_IO);
    child = (struct child){never_ends, stopped_later, &looks, "it was not made", 1e9};
    assert_false(child_run(&child, &out, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_true(clock_seconds(begin) < 60);
    assert_int_equal(out.len, 0);
    buffer_free(&out);
}

/* Numbers of a limit's signal, of descriptors and of a process, as the child has them. */
static bool looks_around(const void *context, struct buffer *out, struct error *error)
{
    struct rlimit core;
    struct sigaction action;
    sigset_t blocked;
    (void)context, (void)error;
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        char byte = 'x';
        buffer_format(out, "%d%d ", read(fd, &byte, 1) > 0, write(fd, &byte, 1) > 0);
    }
    const int terminal = open("/dev/tty", O_RDWR);
    getrlimit(RLIMIT_CORE, &core);
    sigaction(SIGINT, NULL, &action);
    sigprocmask(SIG_BLOCK, NULL, &blocked);
    buffer_format(out, "%d %d %d %d %d", terminal >= 0, core.rlim_cur != 0,
                  action.sa_handler != SIG_DFL, sigismember(&blocked, SIGINT),
                  getpgrp() != getpid());
    return true;
}

/* The child reads and writes nothing on the standard streams, has no terminal, no core dumps,
 * default signal handling and no blocked signals, and leads a process group of its own. */
TEST(the_child_has_nothing_of_ours)
{
    struct buffer out;
    struct error error;
    struct sigaction action;
    sigset_t blocked;
    (void)state;
    void (*before)(int) = signal(SIGINT, on_signal);
    assert_true(run(looks_around, NULL, &out, &error));
    assert_string_equal(out.data, BEFORE "00 00 00 0 0 0 0 0");
    buffer_free(&out);
    sigaction(SIGINT, NULL, &action);
    assert_ptr_equal(action.sa_handler, on_signal);
    sigprocmask(SIG_BLOCK, NULL, &blocked);
    assert_false(sigismember(&blocked, SIGINT));
    signal(SIGINT, before);
}

static FILE *stream;

static void at_end(void)
{
    fputs("said twice", stream);
    fflush(stream);
}

/* What a stream holds is written once, by us, and action at the end is done once. */
TEST(streams_are_not_flushed_twice)
{
    struct buffer out;
    struct error error;
    int status;
    char said[100] = "";
    (void)state;
    const pid_t pid = fork();
    assert_true(pid >= 0);
    stream = tmpfile();
    assert_non_null(stream);
    if (pid == 0) {
        atexit(at_end);
        fputs("said once", stream);
        const bool ok = run(says, "a picture", &out, &error);
        fseek(stream, 0, SEEK_END); /* flushes */
        const long length = ftell(stream);
        rewind(stream);
        _exit(!ok || length != 9 || fread(said, 1, sizeof said, stream) != 9 ||
              strcmp(said, "said once") != 0);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
    fclose(stream);
}

/* A process that nobody waits for says that it was done as well. */
TEST(ignored_children_are_heard)
{
    struct buffer out;
    struct error error;
    (void)state;
    void (*before)(int) = signal(SIGCHLD, SIG_IGN);
    assert_true(run(says, "a picture", &out, &error));
    assert_string_equal(out.data, BEFORE "a picture");
    buffer_free(&out);
    signal(SIGCHLD, before);
}

static bool tells_its_number(const void *context, struct buffer *out, struct error *error)
{
    const int *end = context;
    const pid_t pid = getpid();
    if (write(end[1], &pid, sizeof pid) != sizeof pid)
        _exit(1);
    return never_ends(NULL, out, error);
}

/* It has left another behind, which keeps the pipe open. */
static bool leaves_another(const void *context, struct buffer *out, struct error *error)
{
    const pid_t pid = fork();
    if (pid == 0) {
        alarm(20);
        return never_ends(NULL, out, error);
    }
    return pid > 0 && says(context, out, error);
}

TEST(nobody_else_is_waited_for)
{
    struct buffer out;
    struct error error;
    (void)state;
    const int64_t begin = clock_ns();
    assert_true(run(leaves_another, "a picture", &out, &error));
    assert_string_equal(out.data, BEFORE "a picture");
    assert_true(clock_seconds(begin) < 15);
    buffer_free(&out);
}

/* The program is killed: its child does not go on for ever. */
TEST(it_dies_with_us)
{
    int ends[2], status;
    pid_t child = 0;
    struct buffer out;
    struct error error;
    char byte;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        _exit(run(tells_its_number, ends, &out, &error));
    close(ends[1]);
    assert_int_equal(read(ends[0], &child, sizeof child), sizeof child);
    kill(pid, SIGKILL);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(read(ends[0], &byte, 1), 0); /* waits until the child has closed it, too */
    close(ends[0]);
}

TEST(no_process_is_an_error)
{
    struct rlimit before, none;
    struct buffer out;
    struct error error;
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    none = before;
    none.rlim_cur = 0;
    setrlimit(RLIMIT_NOFILE, &none);
    const bool ok = run(says, "a picture", &out, &error);
    setrlimit(RLIMIT_NOFILE, &before);
    assert_false(ok);
    assert_int_equal(error.code, ERROR_IO);
    assert_string_equal(error.text, "it was not made: Too many open files");
    buffer_free(&out);
}

RUN_TESTS(NULL, NULL)
