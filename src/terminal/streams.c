/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Standard output and standard error as a sink of replies, and the pager. A failed write is
 * remembered for the exit status. */
#define _GNU_SOURCE /* O_PATH, pipe2 */
#include <hooke/base/safe_text.h>
#include "terminal/terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

/* [byte] output is written in pieces of this size */
#define GATHER_BYTES ((size_t)1 << 16)
/* [byte] longer output is not held back for the pager */
#define HELD_BYTES_MAX ((size_t)1 << 24)
/* words of $PAGER */
#define PAGER_WORDS 16

void streams_reserve(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
            /* open() takes the lowest free number; reads and writes of it fail */
            (void)open("/", O_PATH);
}

bool write_all(int fd, struct text text, int *failure)
{
    *failure = file_put(fd, &text);
    return *failure == 0;
}

/* Writes the gathered output. Returns false if standard output has failed. */
bool streams_flush(struct streams *streams)
{
    if (streams->output.failed) {
        streams->broken = true;
        streams->failure = ENOMEM;
    }
    if (!streams->broken &&
        !write_all(STDOUT_FILENO, buffer_text(&streams->output), &streams->failure)) {
        streams->broken = true;
    }
    buffer_clear(&streams->output);
    return !streams->broken;
}

/* Adds text to the log, which panes or a screenshot show later. */
static void log_shown_text(struct streams *streams, struct text text)
{
    if (streams->log) {
        log_add(streams->log, text);
    }
}

/* Sink function for results: to the files of --split, or gathered for standard output. Returns
 * false once writing has failed. */
static bool streams_put_output(void *context, struct text text)
{
    struct streams *streams = context;
    log_shown_text(streams, text);
    if (streams->split && split_takes(streams->split, text))
        return true;
    buffer_put(&streams->output, text);
    const size_t limit = streams->holding ? HELD_BYTES_MAX : GATHER_BYTES;
    return streams->output.len < limit ? !streams->broken : streams_flush(streams);
}

/* Sink function for messages, written after the results before them. While output is held back for
 * the pager, messages join it. */
static bool streams_put_error(void *context, struct text text)
{
    struct streams *streams = context;
    log_shown_text(streams, text);
    if (streams->holding && isatty(STDERR_FILENO)) {
        buffer_put(&streams->output, text);
        return true;
    }
    streams_flush(streams);
    int ignored;
    return write_all(STDERR_FILENO, text, &ignored);
}

struct sink streams_sink(struct streams *streams)
{
    return (struct sink){streams_put_output, streams_put_error, streams};
}

void streams_free(struct streams *streams)
{
    buffer_free(&streams->output);
}

/* ---- the pager ---- */

/* Splits $PAGER at its blanks; words holds a copy. */
static void pager_command(char **argv, struct buffer *words)
{
    const char *pager = getenv("PAGER");
    buffer_put(words, text_of(pager && pager[strspn(pager, " \t")] ? pager : "less"));
    char *rest = words->failed ? NULL : words->data, *word;
    int count = 0;
    while (rest && count < PAGER_WORDS && (word = strsep(&rest, " \t")) != NULL)
        if (*word)
            argv[count++] = word;
    argv[count] = NULL;
}

/* Starts the pager with input_fd as its standard input and default signal handling. Returns false
 * if it cannot be started. */
static bool pager_start(char *const *argv, int input_fd, pid_t *pid)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, ours;
    sigemptyset(&none);
    sigemptyset(&ours);
    sigaddset(&ours, SIGPIPE); /* ignored here; the pager would inherit that */
    sigaddset(&ours, SIGXFSZ);
    if (posix_spawn_file_actions_init(&actions) != 0)
        return false;
    if (posix_spawnattr_init(&attributes) != 0) {
        posix_spawn_file_actions_destroy(&actions);
        return false;
    }
    /* as git does: short output is shown without waiting, colours are kept */
    setenv("LESS", "FRX", 0);
    const short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
    const bool ok = posix_spawn_file_actions_adddup2(&actions, input_fd, STDIN_FILENO) == 0 &&
                    posix_spawnattr_setsigmask(&attributes, &none) == 0 &&
                    posix_spawnattr_setsigdefault(&attributes, &ours) == 0 &&
                    posix_spawnattr_setflags(&attributes, flags) == 0 &&
                    posix_spawnp(pid, argv[0], &actions, &attributes, argv, environ) == 0;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return ok;
}

/* Shows text in the pager and waits for it. Returns false if it could not be started or failed. */
static bool pager_run(struct text text)
{
    char *argv[PAGER_WORDS + 1];
    struct buffer words = {0};
    struct termios modes;
    int ends[2], status = -1, ignored;
    pid_t pid = 0;
    bool started = false;
    pager_command(argv, &words);
    const bool modes_known = tcgetattr(STDIN_FILENO, &modes) == 0;
    if (argv[0] && pipe2(ends, O_CLOEXEC) == 0) {
        started = pager_start(argv, ends[0], &pid);
        close(ends[0]);
        if (started)
            write_all(ends[1], text, &ignored); /* the user may leave it before the end */
        close(ends[1]);
        while (started && waitpid(pid, &status, 0) < 0 && errno == EINTR)
            if (signals_ending())
                kill(pid, SIGTERM);
        if (started && modes_known)
            tcsetattr(STDIN_FILENO, TCSANOW, &modes);
    }
    buffer_free(&words);
    return started && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* Returns the number of rows that the text takes on a terminal of this width, counted only up to
 * about `max`. */
static int terminal_rows(struct text text, int width, int max)
{
    struct text line;
    int rows = 0;
    while (rows <= max && text.len > 0 && text_split(&text, '\n', &line)) {
        const int cells = text_width(line);
        rows += cells > width ? (cells + width - 1) / width : 1;
    }
    return rows;
}

/* Stops holding output back: shows it in the pager if it is longer than the screen, else writes it.
 */
void streams_page(struct streams *streams, int width, int height)
{
    streams->holding = false;
    if (width > 0 && height > 0 && !streams->output.failed && isatty(STDOUT_FILENO) &&
        isatty(STDIN_FILENO) &&
        terminal_rows(buffer_text(&streams->output), width, height) >= height &&
        pager_run(buffer_text(&streams->output)))
        buffer_clear(&streams->output);
    streams_flush(streams);
}
