/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Executes files, -c texts and standard input without a prompt. */
#include "terminal/terminal.h"
#include <hooke/base/cancel.h>

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

/* Reports that standard input cannot be read (errno `number`) and sets the exit status. */
static void refuse_input(struct session *session, int number, struct reply *reply)
{
    struct error error;
    error_set(&error, ERROR_IO, "cannot read standard input: %s", strerror(number));
    reply_error(reply, &error, NULL, (struct text){NULL, 0});
    session->execution.status = ERROR_IO;
}

/* Executes standard input line by line, so that the results of a line are written before the next
 * arrives. Ends at the end of input, at an error without --keep-going, or at a signal. */
static void run_input(struct session *session, struct reply *reply, struct streams *streams)
{
    struct script script;
    script_begin(&script, session, "-", NULL);
    struct buffer line = {0};
    char chunk[1 << 14];
    bool open = true;
    bool going = true;
    while (open && going && !signals_ending()) {
        streams_flush(streams);
        ssize_t got = read(STDIN_FILENO, chunk, sizeof chunk);
        if (got < 0 && errno == EINTR && !cancelled(&interrupt)) {
            continue;
        }
        open = got > 0;
        if (got < 0 && errno != EINTR) {
            refuse_input(session, errno, reply);
        }
        struct text rest = {chunk, got > 0 ? (size_t)got : 0};
        while (going && rest.len > 0) {
            const char *end = memchr(rest.data, '\n', rest.len);
            size_t len = end ? (size_t)(end - rest.data) : rest.len;
            /* A line without end is cut one byte above the limit, so that the interpreter refuses
             * it. */
            size_t left = LIMIT_LINE + 1 > line.len ? LIMIT_LINE + 1 - line.len : 0;
            buffer_put(&line, (struct text){rest.data, len < left ? len : left});
            rest = end ? (struct text){end + 1, rest.len - len - 1}
                       : (struct text){rest.data + len, 0};
            if (end) {
                going = script_feed(&script, session, buffer_text(&line), reply);
                buffer_clear(&line);
            }
        }
    }
    if (going && line.len > 0) {
        script_feed(&script, session, buffer_text(&line), reply);
    }
    script_end(&script, session, reply);
    buffer_free(&line);
}

/* Executes the tasks of the command line in order, then standard input if `input` is set. Stops at
 * the first error unless --keep-going is set. */
void batch_run(struct session *session, const struct options *options, bool input,
               struct reply *reply, struct streams *streams)
{
    for (int i = 0; i < options->tasks && !session->execution.quit; i++) {
        const struct task *task = &options->task[i];
        if (task->kind == TASK_COMMAND) {
            lines_run(session, "-c", text_of(task->text), reply);
        } else if (strcmp(task->text, "-") == 0) {
            run_input(session, reply, streams);
        } else {
            script_file(session, task->text, NULL, reply);
        }
        if (session->execution.status != 0 && !session->options.keep_going) {
            return;
        }
    }
    if (input && !session->execution.quit) {
        run_input(session, reply, streams);
    }
}
