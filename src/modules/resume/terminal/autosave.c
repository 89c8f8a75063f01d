/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions save themselves: records of what has changed are appended to the session's file after
 * each executed line, unless lines follow so closely that writing would delay them, and every
 * AUTOSAVE_SECONDS while a line executes. The file is created at the first change and locked as
 * long as the session lives. What was written survives the program; a thread puts it on the disk,
 * at most once a second, so that nobody waits for that. When the file has doubled in size, another
 * is written with what is still needed, and replaces it once that is on the disk; what was appended
 * meanwhile is copied. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include "modules/resume/terminal/autosave.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* [byte] size beyond the doubled one at which the file is written anew */
#define COMPACT_BYTES ((uint64_t)4 << 20)
#define SYNC_NS 1000000000           /* least time between two syncs */
#define PART_NS 3000000              /* time for which rows are written before keys are checked */
#define EMPTY_SECONDS 60             /* age at which an empty file is deleted */
#define SYNC_STACK ((size_t)1 << 17) /* [byte] stack of the thread, more than it needs */

/* ---- bytes ---- */

/* Writes all bytes. Returns false with an error. */
static bool bytes_write(int fd, struct text bytes, struct error *error)
{
    int failure = 0;
    return write_all(fd, bytes, &failure) || error_set(error, ERROR_IO, "%s", strerror(failure));
}

/* Writes a record to the file *context, for struct store_sink. */
static bool store_record_write(void *context, struct text record, struct error *error)
{
    return bytes_write(*(const int *)context, record, error);
}

/* ---- onto the disk, beside the session ---- */

/* Puts the fresh file, or else the session's, on the disk; run by the thread. */
static void *sync_file(void *context)
{
    struct autosave *autosave = context;
    const int fd = autosave->fresh.fd >= 0 ? autosave->fresh.fd : autosave->fd;
    atomic_store(&autosave->sync_failure, fdatasync(fd) == 0 ? 0 : errno);
    atomic_store(&autosave->synced, true);
    return NULL;
}

/* Waits for the thread, if it runs. */
static void sync_wait(struct autosave *autosave)
{
    if (autosave->syncing)
        pthread_join(autosave->thread, NULL);
    autosave->syncing = false;
}

/* The session that is saved. Pictures are drawn by a copy of the process, which inherits every lock
 * that another thread holds at that moment and would wait for it forever (as in AddressSanitizer's
 * allocator), so that the thread must not run at a fork. */
static struct autosave *autosave_of_process;

/* Waits for the thread before each fork. */
static void wait_before_fork(void)
{
    if (autosave_of_process)
        sync_wait(autosave_of_process);
}

/* Deletes the fresh file, if there is one. */
static void fresh_drop(struct fresh_file *fresh)
{
    if (fresh->fd >= 0) {
        unlink(fresh->path);
        close(fresh->fd);
    }
    free(fresh->path);
    *fresh = (struct fresh_file){.fd = -1};
}

/* ---- the file ---- */

/* Creates and locks a file that does not exist. Returns its descriptor, or -1. */
static int create_locked(struct autosave *autosave, const char *path)
{
    const int fd = open(path, O_RDWR | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
    autosave->unlocked = fd >= 0 && !saved_lock(fd);
    return fd;
}

/* Chooses autosave->path from the time and a number, at first that of the process. Returns false
 * with an error. */
static bool choose_name(struct autosave *autosave, long number, struct error *error)
{
    const time_t now = time(NULL);
    struct tm local;
    char stamp[32] = "", name[64];
    localtime_r(&now, &local);
    strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
    snprintf(name, sizeof name, AUTOSAVE_PREFIX "%s-%ld" AUTOSAVE_ENDING, stamp, number);
    free(autosave->path);
    autosave->path = state_path(name, true);
    return autosave->path || error_set(error, ERROR_IO, "HOME is not set");
}

/* Chooses autosave->path, and creates and locks a file under another, hidden name in the same
 * folder, which is appended to `hidden`; the file gets its own name when it is complete. Writes the
 * header. Returns false with an error. */
static bool open_new(struct autosave *autosave, struct buffer *hidden, struct error *error)
{
    char random[STRAY_NAME_SIZE];
    if (!choose_name(autosave, (long)getpid(), error))
        return false;
    const char *name = strrchr(autosave->path, '/') + 1;
    if (stray_name(random, name, STRAY_NEW))
        buffer_format(hidden, "%.*s%s", (int)(name - autosave->path), autosave->path, random);
    autosave->fd = hidden->len > 0 && !hidden->failed ? create_locked(autosave, hidden->data) : -1;
    if (autosave->fd < 0)
        return error_set(error, ERROR_IO, "%s", strerror(errno));
    stored_free(&autosave->stored);
    autosave->whole = 0;
    return bytes_write(autosave->fd, TEXT(STORE_HEADER), error);
}

/* Gives the new file its name, with another number if it is taken, as several machines may share
 * the folder. Returns false with an error. */
static bool link_new_name(struct autosave *autosave, const char *hidden, struct error *error)
{
    int number = EEXIST;
    for (long tries = 0; tries < 100 && number == EEXIST; tries++) {
        if (tries > 0 && !choose_name(autosave, (long)getpid() + tries, error))
            return false;
        number = link(hidden, autosave->path) == 0 ? 0 : errno;
    }
    if (number == 0)
        unlink(hidden);
    else if (number != EEXIST &&
             rename(hidden, autosave->path) == 0) /* the file system has no links */
        number = 0;
    return number == 0 || error_set(error, ERROR_IO, "%s", strerror(number));
}

/* Closes the file and drops the fresh one. */
static void close_file(struct autosave *autosave)
{
    sync_wait(autosave);
    fresh_drop(&autosave->fresh);
    if (autosave->fd >= 0)
        close(autosave->fd);
    autosave->fd = -1;
}

/* Appends what has changed in the session to the file, or makes the file on the first call. If the
 * data cannot be written completely, an existing file is truncated to its previous end, a new one
 * is removed, and the next call makes another. A first write that `cancel` stops is removed, too,
 * but is no failure. Returns false with *error if writing fails. */
static bool autosave_append(struct autosave *autosave, const struct cancel *cancel,
                            struct error *error)
{
    struct buffer hidden = {0};
    const bool first = autosave->fd < 0;
    bool ok = !first || open_new(autosave, &hidden, error);
    const off_t old_end = ok ? lseek(autosave->fd, 0, SEEK_END) : 0;
    const struct store_sink target = {&autosave->fd, store_record_write, cancel,
                                      first || !cancel ? 0 : clock_ns() + PART_NS};
    ok = ok && session_store(autosave->session, &autosave->stored, &target, error);
    const bool given_up = first && autosave->stored.unfinished;
    ok = ok && (!first || given_up || !hidden.data || link_new_name(autosave, hidden.data, error));
    if (!ok || given_up) {
        if (first && hidden.len > 0)
            unlink(hidden.data);
        else if (!first && ftruncate(autosave->fd, old_end) != 0)
            unlink(autosave->path);
        close_file(autosave); /* the next write makes another file, with everything */
    }
    buffer_free(&hidden);
    return ok;
}

/* Returns true if the file is to be written anew, which takes too long while a live run is
 * drawn. */
static bool is_bloated(const struct autosave *autosave)
{
    return autosave->session->live.state != LIVE_RUNNING &&
           autosave->stored.bytes > 2 * autosave->whole + autosave->slack;
}

/* Begins a new file with only the records that are still needed, which will replace the present one
 * when it is on the disk. If it cannot be written or takes too long, it is dropped and the present
 * file remains; after a failure autosave->slack doubles, so that the next attempt comes later. */
static void fresh_begin(struct autosave *autosave, const struct cancel *cancel)
{
    struct stored stored = {0};
    struct buffer path = {0};
    struct error ignored;
    char hidden[STRAY_NAME_SIZE];
    struct fresh_file *fresh = &autosave->fresh;
    const char *name = strrchr(autosave->path, '/') + 1;
    const bool named = stray_name(hidden, name, STRAY_NEW);
    buffer_format(&path, "%.*s%s", (int)(name - autosave->path), autosave->path, hidden);
    fresh->path = path.data;
    fresh->fd = !named || path.failed ? -1 : create_locked(autosave, path.data);
    fresh->offset = lseek(autosave->fd, 0, SEEK_END);
    const struct store_sink target = {&fresh->fd, store_record_write, cancel, 0};
    if (fresh->fd < 0 || !bytes_write(fresh->fd, TEXT(STORE_HEADER), &ignored) ||
        !session_store(autosave->session, &stored, &target, &ignored)) {
        fresh_drop(fresh);
        autosave->slack *= 2;
    } else if (stored.unfinished) {
        fresh_drop(fresh);
    }
    fresh->bytes = stored.bytes;
    stored_free(&stored);
}

/* ---- another in its place ---- */

/* Appends to the fresh file what the session's file has got meanwhile, and replaces the latter.
 * Returns false if that fails. */
static bool fresh_take(struct autosave *autosave)
{
    struct fresh_file *fresh = &autosave->fresh;
    char bytes[1 << 14];
    struct error ignored;
    ssize_t got;
    while ((got = pread(autosave->fd, bytes, sizeof bytes, fresh->offset)) > 0) {
        if (!bytes_write(fresh->fd, (struct text){bytes, (size_t)got}, &ignored))
            return false;
        fresh->offset += got;
        fresh->bytes += (uint64_t)got;
    }
    if (got < 0 || rename(fresh->path, autosave->path) != 0)
        return false;
    close(autosave->fd);
    autosave->fd = fresh->fd;
    autosave->stored.bytes = autosave->whole = fresh->bytes;
    fresh->fd = -1;
    return true;
}

/* Replaces the file by the fresh one after the thread has put that on the disk, or drops it after a
 * failure. */
static void fresh_end(struct autosave *autosave)
{
    if (autosave->fresh.fd >= 0 &&
        (atomic_load(&autosave->sync_failure) != 0 || !fresh_take(autosave)))
        autosave->slack *= 2; /* so that it is not tried again at once */
    fresh_drop(&autosave->fresh);
}

/* Starts the thread that puts the file on the disk (fsync), if data are unsynced and SYNC_NS has
 * passed since the last time, and a fresh file if the present one is too large. Signals are blocked
 * in that thread, since the thread that owns the session handles them. */
static void sync_begin(struct autosave *autosave, const struct cancel *cancel)
{
    sigset_t all, saved;
    const int64_t now = clock_ns();
    const bool waits = autosave->fresh.fd < 0 && !is_bloated(autosave);
    if (autosave->fd < 0 || !autosave->unsynced || (waits && now < autosave->sync_due))
        return;
    autosave->sync_due = now + SYNC_NS;
    if (autosave->syncing && !atomic_load(&autosave->synced))
        return;
    sync_wait(autosave);
    fresh_end(autosave);
    if (is_bloated(autosave))
        fresh_begin(autosave, cancel);
    atomic_store(&autosave->synced, false);
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &saved);
    autosave->syncing = pthread_create(&autosave->thread, NULL, sync_file, autosave) == 0;
    autosave->unsynced = !autosave->syncing || autosave->fresh.fd >= 0;
    pthread_sigmask(SIG_SETMASK, &saved, NULL);
}

/* ---- when ---- */

/* Deletes temporary files, empty files older than EMPTY_SECONDS, and session files of ended
 * sessions but for the newest AUTOSAVE_KEPT. */
static void delete_old_files(void)
{
    char *folder = state_path("", true);
    if (!folder)
        return;
    strays_sweep_path(folder);
    struct saved_list list = saved_list(folder);
    for (int i = 0, kept = 0; i < list.count; i++) {
        struct buffer path = {0};
        const struct autosaved *saved = &list.item[i];
        buffer_format(&path, "%s%s", folder, saved->name);
        /* a file that was just created may not be locked yet */
        const bool goes =
            saved->empty ? time(NULL) - saved->time > EMPTY_SECONDS : ++kept > AUTOSAVE_KEPT;
        if (goes && !saved->living && !path.failed)
            unlink(path.data);
        buffer_free(&path);
    }
    free(list.item);
    free(folder);
}

/* Prepares saving of a session and deletes what ended sessions left. HOOKE_AUTOSAVE sets the
 * interval [s], if it is a number from 0.1 to 86400. */
void autosave_begin(struct autosave *autosave, struct session *session)
{
    const char *wish = getenv("HOOKE_AUTOSAVE");
    double seconds;
    *autosave = (struct autosave){.session = session,
                                  .saved = session->changes,
                                  .fd = -1,
                                  .fresh = {.fd = -1},
                                  .slack = COMPACT_BYTES,
                                  .interval = (int64_t)(AUTOSAVE_SECONDS * 1e9)};
    if (wish && real_parse(text_of(wish), &seconds) == REAL_OK && seconds >= 0.1 &&
        seconds <= 86400) {
        autosave->interval = (int64_t)(seconds * 1e9);
        autosave->wished = true;
    }
    if (!autosave_of_process)
        pthread_atfork(wait_before_fork, NULL, NULL);
    autosave_of_process = autosave;
    delete_old_files();
}

/* Puts the file on the disk and closes it. */
void autosave_end(struct autosave *autosave)
{
    if (autosave->fd >= 0)
        fdatasync(autosave->fd);
    close_file(autosave);
    autosave_of_process = NULL;
    stored_free(&autosave->stored);
    free(autosave->path);
    autosave->path = NULL;
}

/* Returns true if there is something to write. */
static bool has_changed(const struct autosave *autosave)
{
    const struct session *session = autosave->session;
    return session->changes != autosave->saved || session->live.state == LIVE_RUNNING ||
           autosave->stored.unfinished ||
           (autosave->fd >= 0 && session->history.count != autosave->stored.entries);
}

/* Returns the time [clock_ns] at which writing is due, or INT64_MAX if nothing has changed. */
int64_t autosave_due(const struct autosave *autosave)
{
    if (autosave->stored.unfinished)
        return autosave->written;
    if (has_changed(autosave))
        return autosave->written + autosave->interval;
    return autosave->fd >= 0 && autosave->unsynced ? autosave->sync_due : INT64_MAX;
}

/* Reports, once each, that the file cannot be locked or synchronized to the disk. Returns false
 * with such an error. */
static bool has_all(struct autosave *autosave, struct error *error)
{
    const int failure = atomic_exchange(&autosave->sync_failure, 0);
    if (autosave->unlocked && !autosave->said_unlocked) {
        autosave->said_unlocked = true;
        error_set(
            error, ERROR_IO,
            "the session's file cannot be locked, so other sessions will treat this one as ended");
        return false;
    }
    if (failure != 0 && !autosave->said_unsynced) {
        autosave->said_unsynced = true;
        error_set(error, ERROR_IO,
                  "the session's file was written, but may not be on the disk yet: %s",
                  strerror(failure));
        return false;
    }
    return true;
}

/* Returns true unless rows of more runs than `left_out` had no room; then sets an error. */
static bool has_room(const struct autosave *autosave, int left_out, struct error *error)
{
    const int now = autosave->stored.left_out;
    if (now > left_out)
        error_set(
            error, ERROR_IO,
            "the rows of the oldest %d run%s are not saved: a session's file is limited to %zu MiB",
            now, now == 1 ? "" : "s", STORE_ROW_BYTES >> 20);
    return now <= left_out;
}

/* Writes what has changed, until cancelled, and starts a sync. Returns false with an error to be
 * shown; an error of writing is shown once. */
static bool write_until(struct autosave *autosave, const struct cancel *cancel, struct error *error)
{
    struct error why = {0};
    const int64_t begun = clock_ns();
    if (!has_changed(autosave)) {
        sync_begin(autosave, cancel);
        return has_all(autosave, error);
    }
    const uint64_t changes = autosave->session->changes;
    const int left_out = autosave->stored.left_out;
    const bool ok = autosave_append(autosave, cancel, &why),
               whole = ok && !autosave->stored.unfinished;
    if (whole) {
        autosave->saved = changes;
        autosave->unsynced = true;
        sync_begin(autosave, cancel);
    }
    autosave->written = clock_ns();
    autosave->spent = autosave->written - begun;
    if (ok)
        return !whole || (has_room(autosave, left_out, error) && has_all(autosave, error));
    const bool tell = !autosave->warned;
    autosave->warned = true;
    if (tell)
        error_set(error, ERROR_IO, "the session cannot be saved automatically: %s", why.text);
    return !tell;
}

bool autosave_write(struct autosave *autosave, struct error *error)
{
    return write_until(autosave, NULL, error);
}

/* Writes the session to its file if that is due. `line` is true directly after a line was executed,
 * false at other times (autosave_due()). Returns false with an error to be shown. */
bool autosave_keep(struct autosave *autosave, bool line, struct error *error)
{
    /* Lines wait after a write for as long as that write took, so that writing uses at most half of
     * the time, or for `interval` if that is shorter or was set by the user. A write that was begun
     * but not finished (`begun`) continues at once. */
    const bool waits = autosave->wished || autosave->spent > autosave->interval;
    const int64_t pace = waits ? autosave->interval : autosave->spent;
    const bool begun = autosave->stored.unfinished;
    const int64_t due = line && !begun ? autosave->written + pace : autosave_due(autosave);
    return clock_ns() < due || write_until(autosave, &interrupt, error);
}

/* ---- for the program ---- */

static struct autosave own;

static void keep_begin(struct session *session)
{
    autosave_begin(&own, session);
}

static void keep_end(void)
{
    autosave_end(&own);
}

static int64_t keep_due(void)
{
    return autosave_due(&own);
}

static bool autosave_line_keep(bool line, struct error *error)
{
    return autosave_keep(&own, line, error);
}

static bool keep_now(struct error *error)
{
    return autosave_write(&own, error);
}

static bool is_kept_name(const char *word)
{
    return strncmp(word, AUTOSAVE_PREFIX, strlen(AUTOSAVE_PREFIX)) == 0;
}

const struct terminal_part resume_terminal = {
    .keeper =
        {
            .word = "resume",
            .begin = keep_begin,
            .end = keep_end,
            .due = keep_due,
            .keep = autosave_line_keep,
            .write = keep_now,
            .is_name = is_kept_name,
            .resume = autosave_resume,
        },
};
