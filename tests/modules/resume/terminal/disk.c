/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The session's file on file systems as those of networks: without locks, slow or unable to put
 * anything on the disk; and how large it gets. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <stdatomic.h>
#include <sys/syscall.h>
#include <time.h>

#include "long_form.h"
#include "modules/resume/terminal/autosave.h"
#include "unit/command/testing.h"

/* ---- the file system ---- */

static struct {
    int lock, sync;           /* errno of what it cannot do, 0: it can */
    int64_t sync_ns;          /* each takes so long, < 0: none at all */
    atomic_bool stuck;        /* none ends; a minute at most */
    atomic_int syncs, synced; /* begun, ended */
} disk;

#define PATIENCE_NS 60000000000

int flock(int fd, int operation)
{
    errno = disk.lock;
    return disk.lock ? -1 : (int)syscall(SYS_flock, fd, operation);
}

int fcntl(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    if (disk.lock && (command == F_OFD_SETLK || command == F_OFD_GETLK)) {
        errno = disk.lock;
        return -1;
    }
    return (int)syscall(SYS_fcntl, fd, command, argument);
}

int fdatasync(int fd)
{
    const struct timespec slow = {(time_t)(disk.sync_ns / 1000000000),
                                  (long)(disk.sync_ns % 1000000000)};
    disk.syncs++;
    if (disk.sync_ns < 0)
        return 0;
    nanosleep(&slow, NULL);
    const struct timespec moment = {0, 1000000};
    for (const int64_t until = clock_ns() + PATIENCE_NS; disk.stuck && clock_ns() < until;)
        nanosleep(&moment, NULL);
    disk.synced++;
    errno = disk.sync;
    return disk.sync ? -1 : (int)syscall(SYS_fdatasync, fd);
}

/* ---- a session that saves itself ---- */

struct saving {
    struct bench b;
    struct autosave autosave;
    int words; /* said about it */
    char said[1024];
};

static void keep(struct saving *saving, bool line)
{
    struct error error = {0};
    if (autosave_keep(&saving->autosave, line, &error))
        return;
    saving->words++;
    snprintf(saving->said, sizeof saving->said, "%s", error.text);
}

static void executed(void *context)
{
    keep(context, true);
}

/* Names of files are of a second and a process: those of the session before go. */
static void begin(struct saving *saving)
{
    assert_int_equal(system("rm -rf \"$XDG_STATE_HOME/hooke\""), 0); /* a test may */
    *saving = (struct saving){.words = 0};
    bench_open(&saving->b, true);
    autosave_begin(&saving->autosave, saving->b.session);
    saving->b.session->front.executed = executed;
    saving->b.session->front.context = saving;
}

static void end(struct saving *saving)
{
    autosave_end(&saving->autosave);
    bench_close(&saving->b);
}

static off_t size_of(const struct saving *saving)
{
    struct stat status;
    assert_int_equal(stat(saving->autosave.path, &status), 0);
    return status.st_size;
}

/* In a new session: the file of that name, or the newest of those that have ended. */
static bool resume(struct bench *again, const char *name)
{
    struct buffer messages = {0};
    struct error error;
    bench_open(again, true);
    const bool ok = autosave_resume(&again->session, name, &messages, &error);
    buffer_free(&messages);
    return ok;
}

/* So many milliseconds at the prompt. */
static void wait_at_prompt(struct saving *saving, int ms)
{
    const int64_t until = clock_ns() + ms * 1000000LL;
    do {
        const int64_t due = autosave_due(&saving->autosave);
        const int64_t left = (due < until ? due : until) - clock_ns();
        const struct timespec pause = {0, left > 0 && left < 100000000 ? (long)left : 10000000};
        nanosleep(&pause, NULL);
        keep(saving, false);
    } while (clock_ns() < until);
}

static int enter_state(void **state)
{
    const int status = enter_folder(state);
    setenv("XDG_STATE_HOME", bench_folder, 1);
    return status;
}

static int leave_state(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -r '%s'", bench_folder);
    return system(command); /* a test may */
}

/* ---- what has to hold ---- */

TEST(without_locks_it_goes_on)
{
    static const int numbers[] = {ENOLCK, EOPNOTSUPP, EINVAL};
    for (size_t i = 0; i < COUNT_OF(numbers); i++) {
        struct saving saving;
        struct bench again;
        disk.lock = numbers[i];
        begin(&saving);
        type_ok(&saving.b, "let A1 = 6");
        wait_at_prompt(&saving, 20);
        type_ok(&saving.b, "let B1 = 7; run 10 ms");
        wait_at_prompt(&saving, (int)(AUTOSAVE_SECONDS * 1000) + 20);
        assert_int_equal(saving.words, 1);
        assert_true(strstr(saving.said, "cannot be locked") != NULL);
        assert_true(resume(&again, strrchr(saving.autosave.path, '/') + 1));
        type_ok(&again, "print A1*B1");
        assert_says(&again.out, "42");
        bench_close(&again);
        type_ok(&saving.b, "let C1 = 8");
        assert_int_equal(saving.words, 1);
        end(&saving);
        disk.lock = 0;
    }
}

TEST(a_disk_that_fails_is_said_once)
{
    struct saving saving;
    struct bench again;
    disk.sync = EIO;
    disk.synced = 0;
    begin(&saving);
    const int64_t until = clock_ns() + PATIENCE_NS;
    for (int i = 0; i < 3; i++) {
        type_ok(&saving.b, i == 2 ? "let B1 = 7" : "let A1 = 6");
        do
            wait_at_prompt(&saving, 30);
        while (disk.synced < i + 1 && clock_ns() < until);
        wait_at_prompt(&saving, 30);
    }
    assert_int_equal(saving.words, 1);
    assert_true(strstr(saving.said, "may not be on the disk") != NULL);
    struct error error;
    autosave_write(&saving.autosave, &error); /* as at the end of the program */
    end(&saving);
    disk.sync = 0;
    assert_true(resume(&again, NULL));
    type_ok(&again, "print A1*B1");
    assert_says(&again.out, "42");
    bench_close(&again);
}

/* Nobody waits for the disk, but for the end; and the last write gets there, too. */
TEST(a_slow_disk_is_not_waited_for)
{
    struct saving saving;
    disk.stuck = true;
    disk.syncs = disk.synced = 0;
    begin(&saving);
    const int64_t begun = clock_ns();
    for (int i = 0; i < 20; i++)
        type_ok(&saving.b, "run 10 ms; drop all");
    while (disk.syncs == 0 && clock_ns() - begun < PATIENCE_NS)
        wait_at_prompt(&saving, 10);
    assert_int_equal(disk.synced, 0);
    disk.stuck = false;
    while ((autosave_due(&saving.autosave) < INT64_MAX || disk.syncs < 2) &&
           clock_ns() - begun < PATIENCE_NS)
        wait_at_prompt(&saving, 100);
    assert_true(autosave_due(&saving.autosave) == INT64_MAX);
    assert_in_range(disk.syncs, 2, 2 + (clock_ns() - begun) / 1000000000); /* once a second */
    assert_int_equal(saving.words, 0);
    end(&saving);
}

/* What is collected is counted when it is in the file, also where its end is seen before. */
TEST(collected_on_a_slow_disk)
{
    struct bench b;
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    for (int i = 0; i < 20; i++)
        assert_true(dprintf(ends[1], "%d,%d\n", 10 * i, i) > 0);
    close(ends[1]);
    const int input = dup(STDIN_FILENO);
    dup2(ends[0], STDIN_FILENO);
    close(ends[0]);
    bench_open(&b, true);
    terminal_offer(&b.session->front, NULL);
    if (!b.session->front.feed) {
        bench_close(&b);
        skip();
    }
    b.session->front.input = true;
    disk.sync_ns = 400000000;
    type_ok(&b, "collect - to=lines.txt tunit=ms");
    disk.sync_ns = 0;
    assert_says(&b.out, "20 lines, 20 samples (ok)");
    bench_close(&b);
    dup2(input, STDIN_FILENO);
    close(input);
}

static bool count_bytes(void *context, struct text record, struct error *error)
{
    (void)error;
    *(uint64_t *)context += record.len;
    return true;
}

/* What is no longer read goes: the file is as large as the session, not as its past. */
TEST(the_file_is_as_large_as_the_session)
{
    struct saving saving;
    struct bench again;
    disk.sync_ns = -1;
    begin(&saving);
    saving.autosave.interval = 0; /* each line is written */
    off_t most = 0;
    for (int i = 0; i < (is_long() ? 20000 : 600); i++) {
        type_ok(&saving.b, i % 3 ? "run 100 ms; measure energy; change k 17; step 2; drop all"
                                 : "force -3*y; run 1 ms; note good; drop all; undo; force off");
        const struct timespec moment = {0, 100000};
        while (saving.autosave.syncing && !atomic_load(&saving.autosave.synced))
            nanosleep(&moment, NULL); /* a loaded machine */
        type_ok(&saving.b, "drop all");
        most = size_of(&saving) > most ? size_of(&saving) : most;
    }
    /* Twice what is written anew, and what some lines wrote while that was put on the disk: each
     * has most of a session anew. */
    struct stored stored = {0};
    struct error error;
    uint64_t live = 0;
    assert_true(session_store(saving.b.session, &stored,
                              &(struct store_sink){&live, count_bytes, NULL, 0}, &error));
    stored_free(&stored);
    if ((uint64_t)most > 10 * live + (4 << 20) || live > 3 << 20)
        fail_msg("%lld bytes for %llu that are read", (long long)most, (unsigned long long)live);
    type_ok(&saving.b, "let A1 = 42");
    end(&saving);
    disk.sync_ns = 0;
    assert_true(resume(&again, NULL));
    type_ok(&again, "print A1");
    assert_says(&again.out, "42");
    bench_close(&again);
}

RUN_TESTS(enter_state, leave_state)
