/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions that save themselves as they go, in files session-DATE-TIME-PID.hks (see
 * modules/resume/store.h). autosave_begin() comes first, then autosave_keep() whenever it is due
 * and after each line, and autosave_end(); autosave_resume() restores a session. */
#pragma once

#include "modules/resume/store.h"
#include "terminal/parts.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#define AUTOSAVE_PREFIX "session-"
#define AUTOSAVE_ENDING ".hks"
#define AUTOSAVE_SECONDS 0.5 /* seconds between two writes, unless HOOKE_AUTOSAVE is set */
/* number of files of ended sessions that are not deleted */
#define AUTOSAVE_KEPT 5

/* A session file in the folder. */
struct autosaved {
    char name[64];
    time_t time; /* time of its last change */
    bool living; /* the session is still running */
    bool empty;  /* its session ended before it had written anything */
};

struct saved_list {
    struct autosaved *item; /* the newest first */
    int count;
};

/* Lists the session files in a folder. The caller frees item. */
struct saved_list saved_list(const char *folder);
/* Locks the file to show that this session is alive. Returns false if the file system has no
 * locks. */
bool saved_lock(int fd);

/* A new file with only the records that are still needed, which replaces the old one once it is on
 * the disk. */
struct fresh_file {
    char *path;
    int fd;         /* -1 if there is none */
    int64_t offset; /* offset in the old file of the first byte that is not copied yet */
    uint64_t bytes; /* size so far */
};

/* The file of a running session. */
struct autosave {
    struct session *session;
    char *path;           /* NULL before the first write */
    int fd;               /* -1 before the first write */
    struct stored stored; /* content of the file */
    struct fresh_file fresh;
    uint64_t whole;   /* [byte] size of the file when it was written anew */
    uint64_t slack;   /* [byte] size that it may have beyond twice that before it is written anew */
    int64_t interval; /* [ns] */
    bool wished;      /* the interval was set by the user, so that lines wait for it, too */
    int64_t written;  /* [clock_ns] time of the last write */
    int64_t spent;    /* [ns] duration of the last write */
    uint64_t saved;   /* session->changes at the last complete write */
    bool warned;      /* it was reported that the file cannot be written */
    /* locks do not work; it was reported that they do not, or that the disk cannot be waited for */
    bool unlocked, said_unlocked, said_unsynced;
    pthread_t thread;        /* puts the file on the disk, while `syncing` */
    bool syncing, unsynced;  /* `unsynced` means that more was written since */
    atomic_bool synced;      /* the thread has finished */
    atomic_int sync_failure; /* errno */
    int64_t sync_due;        /* [clock_ns] earliest time of the next sync */
};

/* Prepares saving of a session, which writes nothing yet. Deletes what ended sessions left:
 * temporary files, and all but the last AUTOSAVE_KEPT session files. */
void autosave_begin(struct autosave *autosave, struct session *session);
/* Puts the file on the disk and closes it. */
void autosave_end(struct autosave *autosave);
/* Returns the time [clock_ns] at which autosave_write is due, or INT64_MAX if nothing has
 * changed. */
int64_t autosave_due(const struct autosave *autosave);
/* Writes if that is due. `line` is true after an executed line, which makes it due unless writing
 * takes long. Ctrl-C postpones the remainder to the next call. Returns false with an error as
 * autosave_write() does. */
bool autosave_keep(struct autosave *autosave, bool line, struct error *error);
/* Writes now if anything has changed. Returns false, with the reason, if something is not in the
 * file; that it cannot be written at all is reported once per session. */
bool autosave_write(struct autosave *autosave, struct error *error);
/* Replaces the session by a saved one, or by the newest if name is NULL. The session is
 * unchanged unless all of it could be restored. `messages` receives a report. */
bool autosave_resume(struct session **session, const char *name, struct buffer *messages,
                     struct error *error);
