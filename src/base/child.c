/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs work in a child process, so that a crash or an endless loop in it cannot harm the program:
 * child_run() forks, the child writes output and a struct child_answer into a pipe, the parent
 * reads both. The only file of the library that makes a process or changes signals. */
#define _GNU_SOURCE /* pipe2 */
#include <hooke/base/safe_text.h>
#include <hooke/base/child.h>
#include "base/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

/* [byte] Most output of the child that is read at once. */
#define REPLY_CHUNK_BYTES 8192
#define LOOK_MS 20 /* [ms] between two looks at cancellation and at the child */

/* Follows the output of the child, of len bytes, in the pipe; if it is missing the child has
 * died. */
struct child_answer {
    size_t done, len;
    struct error error;
};

/* ---- in the child ---- */

/* Makes the system kill this process when its parent ends, and forbids core files. Returns false if
 * the parent has ended already. */
static bool die_with_parent(pid_t parent)
{
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_DUMPABLE, 0); /* no core, also where a program takes those */
#endif
    return getppid() == parent;
}

/* Detaches the child from terminal, standard streams (reads and writes of them then fail), signal
 * handlers and core files. */
static void detach_child(void)
{
    const struct rlimit none = {0, 0};
    const struct sigaction usual = {.sa_handler = SIG_DFL};
    const int nothing = open("/", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    sigset_t open_set;
    setsid();
    setrlimit(RLIMIT_CORE, &none);
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (nothing < 0 || dup2(nothing, fd) < 0)
            close(fd);
    for (int number = 1; number <= SIGRTMAX; number++)
        sigaction(number, &usual, NULL);
    sigemptyset(&open_set);
    sigprocmask(SIG_SETMASK, &open_set, NULL);
}

/* Does the work of the child and writes output and answer into the pipe's end. Exits with 0 if both
 * were written; never returns. */
static _Noreturn void child_work(const struct child *child, int end, pid_t parent)
{
    struct buffer output = {0};
    struct child_answer answer;
    const int descriptor = fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    memset(&answer, 0, sizeof answer); /* padding between the members is written, too */
    detach_child();
    if (descriptor < 0 || !die_with_parent(parent))
        _exit(1);
    answer.done = child->work(child->context, &output, &answer.error) &&
                  (!output.failed || error_memory(&answer.error));
    answer.len = answer.done ? output.len : 0;
    answer.error.where = (struct text){0};
    struct text part[] = {{output.data, answer.len}, {(const char *)&answer, sizeof answer}};
    _exit(file_put(descriptor, &part[0]) != 0 || file_put(descriptor, &part[1]) != 0);
}

/* ---- in the parent ---- */

/* The child as the parent sees it. */
struct process {
    pid_t pid;
    int descriptor, status; /* end of the pipe; wait status */
    bool ended;             /* its status is known */
};

/* Sets the error "WORK: why". Returns false. */
static bool child_fail(const struct child *child, struct error *error, const char *why)
{
    return error_set(error, ERROR_IO, "%s: %s", child->what, why);
}

/* Reads the output of the child until the pipe ends, or until the process has ended while others
 * still hold the pipe open. Returns false with the error set if the user cancels, the time allowed
 * is over, or reading fails. */
static bool read_output(const struct child *child, struct process *process, struct buffer *all,
                        struct error *error)
{
    double looks_left = child->patience * 1000 / LOOK_MS;
    char chunk[REPLY_CHUNK_BYTES];
    for (;;) {
        if (child->stopped && child->stopped(child->context))
            return error_set(error, ERROR_CANCELLED, "%s: stopped", child->what);
        struct pollfd ready = {.fd = process->descriptor, .events = POLLIN};
        const int count = poll(&ready, 1, LOOK_MS);
        const ssize_t got = count > 0 ? read(process->descriptor, chunk, sizeof chunk) : -1;
        if (got == 0 || (count == 0 && process->ended))
            return true;
        if (count == 0 && !(--looks_left > 0))
            return child_fail(child, error, "it took too long");
        if (count == 0) /* output written until then is still to be read */
            process->ended = waitpid(process->pid, &process->status, WNOHANG) != 0;
        else if (got < 0 && errno != EINTR)
            return child_fail(child, error, system_message(errno));
        if (got > 0)
            buffer_put(all, (struct text){chunk, (size_t)got});
        if (all->failed)
            return error_memory(error);
    }
}

/* Sets the error that tells from the wait status why the child ended without an answer. Returns
 * false. */
static bool child_error_set(const struct child *child, int status, struct error *error)
{
    if (!WIFSIGNALED(status))
        return child_fail(child, error, "its process ended early");
    if (WTERMSIG(status) == SIGXCPU)
        return child_fail(child, error, "it took more processor time than allowed");
    if (WTERMSIG(status) == SIGKILL)
        return child_fail(child, error, "its process was killed, perhaps because memory ran out");
    return error_set(error, ERROR_IO, "%s: its process crashed (signal %d)", child->what,
                     WTERMSIG(status));
}

/* Takes the answer off the end of the output that follows the first old_len bytes. Returns false
 * with the error set if it is missing or reports a failure. */
static bool read_answer(const struct child *child, int status, size_t old_len,
                        struct buffer *output, struct error *error)
{
    struct child_answer answer = {0};
    const size_t len = output->len - old_len;
    if (len >= sizeof answer)
        memcpy(&answer, output->data + output->len - sizeof answer, sizeof answer);
    if (len < sizeof answer || len - sizeof answer != answer.len)
        return child_error_set(child, status, error);
    output->len -= sizeof answer;
    if (!answer.done)
        *error = answer.error;
    return answer.done;
}

/* Collects output and answer of the child and waits for its end; kills it on failure. Returns false
 * with the error set and output unchanged if the work was not done. */
static bool child_collect(const struct child *child, pid_t pid, int descriptor,
                          struct buffer *output, struct error *error)
{
    const size_t old_len = output->len;
    struct process process = {.pid = pid, .descriptor = descriptor};
    bool ok = read_output(child, &process, output, error);
    if (!ok && !process.ended)
        kill(pid, SIGKILL);
    while (!process.ended && waitpid(pid, &process.status, 0) < 0 && errno == EINTR)
        ;
    ok = ok && read_answer(child, process.status, old_len, output, error);
    if (!ok)
        output->len = old_len;
    if (output->data)
        output->data[output->len] = '\0';
    return ok;
}

/* Forks with all signals blocked, so that no handler of the program runs in the child. */
bool child_run(const struct child *child, struct buffer *output, struct error *error)
{
    int ends[2];
    sigset_t all, old_mask;
    const pid_t parent = getpid();
    if (pipe2(ends, O_CLOEXEC) != 0)
        return child_fail(child, error, system_message(errno));
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old_mask);
    const pid_t pid = fork();
    const int number = errno;
    if (pid == 0)
        child_work(child, ends[1], parent);
    pthread_sigmask(SIG_SETMASK, &old_mask, NULL);
    close(ends[1]);
    const bool ok = pid < 0 ? child_fail(child, error, system_message(number))
                            : child_collect(child, pid, ends[0], output, error);
    close(ends[0]);
    return ok;
}
