/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Standard output and standard error as the two ends of a sink; no failed write is forgotten. */
#define _GNU_SOURCE /* O_PATH */
#include "terminal/terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

#define GATHER ((size_t)1 << 16)

void streams_reserve(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
            (void)open("/", O_PATH); /* the lowest number that is free; reads and writes fail */
}

bool write_all(int fd, struct text text, int *failure)
{
    *failure = file_put(fd, &text);
    return *failure == 0;
}

bool streams_flush(struct streams *streams)
{
    if (streams->out.failed) {
        streams->broken = true;
        streams->failure = ENOMEM;
    }
    if (!streams->broken &&
        !write_all(STDOUT_FILENO, buffer_text(&streams->out), &streams->failure)) {
        streams->broken = true;
    }
    buffer_clear(&streams->out);
    return !streams->broken;
}

/* Panes or a screenshot may follow at any time: they show the last lines of what was said. */
static void keep(struct streams *streams, struct text text)
{
    if (streams->log) {
        log_add(streams->log, text);
    }
}

static bool out(void *context, struct text text)
{
    struct streams *streams = context;
    keep(streams, text);
    if (streams->split && split_takes(streams->split, text))
        return true;
    buffer_put(&streams->out, text);
    return streams->out.len < GATHER ? !streams->broken : streams_flush(streams);
}

static bool err(void *context, struct text text)
{
    keep(context, text);
    streams_flush(context);
    int ignored;
    return write_all(STDERR_FILENO, text, &ignored);
}

struct sink streams_sink(struct streams *streams)
{
    return (struct sink){out, err, streams};
}

void streams_free(struct streams *streams)
{
    buffer_free(&streams->out);
}
