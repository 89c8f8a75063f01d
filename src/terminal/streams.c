/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Standard output and standard error as the two ends of a sink; no failed write is forgotten. */
#include "terminal/terminal.h"

#include <errno.h>
#include <unistd.h>

#define GATHER ((size_t)1 << 16)

bool write_all(int fd, struct text text, int *failure)
{
    while (text.len > 0) {
        ssize_t done = write(fd, text.at, text.len);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            *failure = errno;
            return false;
        }
        text.at += done;
        text.len -= (size_t)done;
    }
    return true;
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
