/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the lines of a sensor into a file, in a thread of its own, so that nothing the session
 * does delays them. Complete lines are in the file after 20 ms and on the disk after half a second.
 * The session reads the file, and the state of the feed by sensor_feed.look(). */
#define _GNU_SOURCE /* pipe2 */
#include "modules/collect/lines.h"
#include <hooke/base/cancel.h>
#include "modules/collect/terminal/sensor.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GATHER_NS 20000000 /* [ns] lines are written together after this time */
#define SYNC_NS 500000000  /* [ns] and synchronised with the disk after this time */
/* [ns] a serial line that sends before this was in the middle of a line */
#define HALF_NS 500000000
#define GROWTH_MS 20 /* [ms] interval between two readings of a file that grows */
#define FEED_CHUNK_BYTES 65536u

/* A feed: state shared by its thread and the session. */
struct feed {
    struct device device;
    /* descriptor of the file, and a pipe that ends the thread */
    int file, wake[2];
    /* limit of the number of lines */
    uint64_t max;
    double t_begin; /* [s] */
    int64_t begun;  /* [clock_ns] */
    pthread_t thread;
    pthread_mutex_t lock; /* protects the members below, except `part` and `lines` */
    struct feed_look look;
    double t_end; /* [s] the feed ends at the first later line */
    bool paused, stopping;
    /* members used by the thread alone */
    struct buffer part;  /* beginning of the incomplete line, at most COLLECTED_LINE + 1 bytes */
    struct buffer lines; /* complete lines that are not in the file yet */
    uint64_t count;      /* number of these lines */
    size_t written;      /* [byte] of the file */
    bool rested;         /* it was paused since the last line */
    bool half;           /* the incomplete line may lack its beginning */
    /* the file was written to since it was synchronised */
    bool dirty;
    int64_t flushed, synced; /* [clock_ns] */
};

/* Returns the time [s] of the recording at `now` [clock_ns]. */
static double seconds_of(const struct feed *feed, int64_t now)
{
    return feed->t_begin + 1e-9 * (double)(now - feed->begun);
}

/* Notes why the feed ends, unless it has ended already. */
static void feed_finish(struct feed *feed, enum feed_end how, const char *failure)
{
    pthread_mutex_lock(&feed->lock);
    if (feed->look.end == FEED_GOES_ON) {
        feed->look.end = how;
        snprintf(feed->look.failure, sizeof feed->look.failure, "%.*s",
                 (int)sizeof feed->look.failure - 1, failure);
    }
    pthread_mutex_unlock(&feed->lock);
}

/* Appends the complete lines to the file, and synchronises it with the disk if `sync` is set or
 * that is due. */
static void write_lines(struct feed *feed, int64_t now, bool sync)
{
    struct error error = {0};
    sync = sync || now - feed->synced >= SYNC_NS;
    if (feed->lines.len == 0 && !(sync && feed->dirty))
        return;
    if (feed->lines.failed || !append_lines(feed->file, buffer_text(&feed->lines), sync, &error)) {
        feed_finish(feed, FEED_FAILED, feed->lines.failed ? "out of memory" : error.text);
        return;
    }
    feed->written += feed->lines.len;
    feed->dirty = !sync;
    feed->synced = sync ? now : feed->synced;
    feed->flushed = now;
    pthread_mutex_lock(&feed->lock);
    feed->look.lines += feed->count;
    pthread_mutex_unlock(&feed->lock);
    feed->count = 0;
    buffer_clear(&feed->lines);
}

/* Adds the incomplete line, which is complete now, to the lines to be written. `cut` marks it as
 * garbled. */
static void complete_line(struct feed *feed, double arrival, bool cut)
{
    if (cut)
        buffer_put(&feed->part, TEXT("\\..."));
    if (feed->rested)
        buffer_put(&feed->lines, TEXT(COLLECTED_PAUSE "\n"));
    feed->rested = false;
    collected_put(&feed->lines, arrival, buffer_text(&feed->part));
    feed->count++;
    buffer_clear(&feed->part);
    pthread_mutex_lock(&feed->lock);
    feed->look.first = isnan(feed->look.first) ? arrival : feed->look.first;
    feed->look.last = arrival;
    const bool full = feed->look.lines + feed->count >= feed->max ||
                      feed->written + feed->lines.len + 2 * COLLECTED_LINE > LIMIT_FILE;
    pthread_mutex_unlock(&feed->lock);
    if (full)
        feed_finish(feed, FEED_FULL, "");
}

/* Splits received bytes into lines; during a pause they are dropped. Ends the feed after t_end. */
static void split_bytes(struct feed *feed, struct text piece, int64_t now)
{
    const double arrival = seconds_of(feed, now);
    pthread_mutex_lock(&feed->lock);
    feed->look.bytes += piece.len;
    const bool paused = feed->paused, late = arrival > feed->t_end;
    pthread_mutex_unlock(&feed->lock);
    if (late) {
        feed_finish(feed, FEED_IN_TIME, "");
        return;
    }
    if (paused) {
        buffer_clear(&feed->part);
        feed->half = feed->rested = true;
        return;
    }
    for (size_t i = 0, begin = 0; i <= piece.len; i++) {
        const bool ends = i < piece.len && (piece.data[i] == '\n' || piece.data[i] == '\r');
        if (!ends && i < piece.len)
            continue;
        const size_t room = COLLECTED_LINE + 1 - feed->part.len, len = i - begin;
        buffer_put(&feed->part, (struct text){piece.data + begin, len < room ? len : room});
        begin = i + 1;
        if (ends && feed->part.len > 0)
            complete_line(feed, arrival, feed->half);
        feed->half &= !ends;
        if (feed->look.end == FEED_FULL)
            return;
    }
}

/* Reads the available bytes. Returns false if the feed has ended. */
static bool read_some(struct feed *feed)
{
    char piece[FEED_CHUNK_BYTES];
    const ssize_t got = read(feed->device.fd, piece, sizeof piece);
    const int64_t now = clock_ns();
    if (got > 0) {
        feed->half |= feed->look.bytes == 0 && feed->device.serial && now - feed->begun < HALF_NS;
        split_bytes(feed, (struct text){piece, (size_t)got}, now);
        return feed->look.end == FEED_GOES_ON;
    }
    if (got < 0 && (errno == EAGAIN || errno == EINTR))
        return true;
    if (got == 0 && feed->device.grows)
        return true;
    const char *const reason = got < 0 ? strerror(errno) : "";
    feed_finish(feed, got < 0 || feed->device.serial ? FEED_UNPLUGGED : FEED_ENDED, reason);
    return false;
}

static bool is_stopping(struct feed *feed)
{
    pthread_mutex_lock(&feed->lock);
    const bool stopping = feed->stopping || feed->look.end != FEED_GOES_ON;
    pthread_mutex_unlock(&feed->lock);
    return stopping;
}

/* Thread of the feed: waits for bytes, reads and writes them until the feed ends. */
static void *feed_thread_run(void *context)
{
    struct feed *feed = context;
    bool more = true;
    while (more && !is_stopping(feed)) {
        /* a file is always ready to read, so it is looked at every GROWTH_MS */
        struct pollfd ready[2] = {{.fd = feed->wake[0], .events = POLLIN},
                                  {.fd = feed->device.fd, .events = POLLIN}};
        const nfds_t count = feed->device.grows ? 1 : 2;
        int wait;
        if (feed->device.grows)
            wait = GROWTH_MS;
        else if (feed->lines.len > 0)
            wait = GATHER_NS / 1000000;
        else
            wait = feed->dirty ? SYNC_NS / 1000000 : -1;
        const int got = poll(ready, count, wait);
        if (feed->device.grows) {
            for (uint64_t old_bytes = UINT64_MAX; more && old_bytes != feed->look.bytes;) {
                old_bytes = feed->look.bytes;
                more = read_some(feed);
            }
        } else if (got > 0 && ready[1].revents) {
            more = read_some(feed);
        }
        const int64_t now = clock_ns();
        if (now - feed->flushed >= GATHER_NS)
            write_lines(feed, now, false);
    }
    if (feed->part.len > 0 && feed->look.end == FEED_ENDED)
        complete_line(feed, seconds_of(feed, clock_ns()), true);
    write_lines(feed, clock_ns(), true);
    pthread_mutex_lock(&feed->lock);
    feed->look.unwritten = feed->count;
    pthread_mutex_unlock(&feed->lock);
    return NULL;
}

/* ---- for the session ---- */

/* Closes everything and frees the feed. */
static void feed_destroy(struct feed *feed)
{
    device_close(&feed->device);
    for (int i = 0; i < 2; i++)
        if (feed->wake[i] >= 0)
            close(feed->wake[i]);
    if (feed->file >= 0)
        close(feed->file);
    pthread_mutex_destroy(&feed->lock);
    buffer_free(&feed->part);
    buffer_free(&feed->lines);
    free(feed);
}

/* Starts the thread with all signals blocked. Returns 0, or the errno of pthread_create(). */
static int start_thread(struct feed *feed)
{
    sigset_t all, old_mask;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old_mask);
    const int number = pthread_create(&feed->thread, NULL, feed_thread_run, feed);
    pthread_sigmask(SIG_SETMASK, &old_mask, NULL);
    return number;
}

/* Opens the source and starts the thread. Takes over request->file. Returns NULL with an error. */
static struct feed *open_feed(const struct feed_request *request, struct error *error)
{
    struct feed *feed = calloc(1, sizeof *feed);
    if (!feed) {
        close(request->file);
        error_memory(error);
        return NULL;
    }
    *feed = (struct feed){.file = request->file,
                          .wake = {-1, -1},
                          .max = request->max,
                          .t_end = HUGE_VAL,
                          .t_begin = request->t_begin,
                          .look = {.first = NAN, .last = NAN}};
    pthread_mutex_init(&feed->lock, NULL);
    bool ok = device_open(&feed->device, request->source, request->baud, request->safe, error);
    feed->begun = feed->flushed = feed->synced = clock_ns();
    if (ok && (pipe2(feed->wake, O_CLOEXEC) != 0 || start_thread(feed) != 0))
        ok = error_set(error, ERROR_IO, "a thread for collecting could not be started: %s",
                       strerror(errno));
    if (ok)
        return feed;
    feed_destroy(feed);
    return NULL;
}

/* Copies the state of the feed. */
static void feed_look_at(struct feed *feed, struct feed_look *look)
{
    pthread_mutex_lock(&feed->lock);
    *look = feed->look;
    pthread_mutex_unlock(&feed->lock);
    look->now = seconds_of(feed, clock_ns());
}

static void pause_feed(struct feed *feed, bool pause)
{
    pthread_mutex_lock(&feed->lock);
    feed->paused = pause;
    pthread_mutex_unlock(&feed->lock);
}

static void limit_feed(struct feed *feed, double t_end)
{
    pthread_mutex_lock(&feed->lock);
    feed->t_end = t_end;
    pthread_mutex_unlock(&feed->lock);
}

/* Ends the thread, copies the final state and frees the feed. */
static void close_feed(struct feed *feed, struct feed_look *look)
{
    pthread_mutex_lock(&feed->lock);
    feed->stopping = true;
    pthread_mutex_unlock(&feed->lock);
    const ssize_t ignored = write(feed->wake[1], "", 1);
    (void)ignored;
    pthread_join(feed->thread, NULL);
    feed_look_at(feed, look);
    feed_destroy(feed);
}

/* Clears a Ctrl-C that has ended the collection. */
static void clear_interrupt(void)
{
    if (!signals_ending())
        atomic_store(&interrupt.requested, 0);
}

const struct feed_access sensor_feed = {.open = open_feed,
                                        .look = feed_look_at,
                                        .pause = pause_feed,
                                        .limit = limit_feed,
                                        .close = close_feed,
                                        .heeded = clear_interrupt};
