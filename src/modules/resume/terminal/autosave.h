/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions that save themselves, and how one is taken up again. */
#pragma once

#include "modules/resume/store.h"
#include "terminal/parts.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

/* session-DATE-TIME-PID.hks, a file of modules/resume/store.h */

#define AUTOSAVE_PREFIX "session-"
#define AUTOSAVE_ENDING ".hks"
#define AUTOSAVE_SECONDS 0.5 /* unless HOOKE_AUTOSAVE says otherwise */
#define AUTOSAVE_KEPT 5

struct autosaved {
    char name[64];
    time_t time;
    bool living; /* the session is still there */
    bool empty;  /* it was killed before it had written anything */
};

struct saved_list {
    struct autosaved *item; /* the newest first */
    int count;
};

/* Caller frees item. */
struct saved_list saved_list(const char *folder);
/* Locks the file to show that this session is alive. Returns false if the file system has no
 * locks. */
bool saved_lock(int fd);

/* New file with the records that are still needed, which replaces the old one once it is on the
 * disk. */
struct fresh_file {
    char *path;
    int fd;         /* -1 if there is none */
    int64_t offset; /* offset in the old file of the first byte that is not copied yet */
    uint64_t bytes; /* that it has */
};

struct autosave {
    struct session *session;
    char *path;           /* NULL before the first write */
    int fd;               /* -1 before the first write */
    struct stored stored; /* content of the file */
    struct fresh_file fresh;
    uint64_t whole;   /* [byte] of the file when it was written anew */
    uint64_t slack;   /* [byte] so many more it may have */
    int64_t interval; /* [ns] */
    bool wished;      /* that somebody asked for: lines wait for it, too */
    int64_t written;  /* [clock_ns] the last time, and */
    int64_t spent;    /* [ns] what it took */
    uint64_t saved;   /* session->changes then */
    bool warned;      /* that it cannot be written: said once */
    bool unlocked, said_unlocked, said_unsynced; /* likewise what the file system cannot do */
    pthread_t thread;                            /* puts the file on the disk while `syncing` */
    bool syncing, unsynced; /* unsynced is true if there is more to put there */
    atomic_bool synced;
    atomic_int sync_failure; /* errno */
    int64_t sync_due;        /* [clock_ns] not before */
};

/* Clears away what dead sessions left: temporaries, and all but the last AUTOSAVE_KEPT files. */
void autosave_begin(struct autosave *autosave, struct session *session);
void autosave_end(struct autosave *autosave);
/* Returns the time [clock_ns] at which autosave_write is due, or INT64_MAX if nothing has
 * changed. */
int64_t autosave_due(const struct autosave *autosave);
/* Writes if that is due. `line` is true after an executed line, which makes it due unless
 * writing takes long. A Ctrl-C postpones the rest until the next call. */
bool autosave_keep(struct autosave *autosave, bool line, struct error *error);
/* Writes now if anything has changed. Returns false, with the reason, if something is not in the
 * file; that it cannot be written at all is reported once per session. */
bool autosave_write(struct autosave *autosave, struct error *error);
/* Replaces the session by a saved one, or by the newest if name is NULL. The session is
 * unchanged unless all of it could be restored. `messages` receives a report. */
bool autosave_resume(struct session **session, const char *name, struct buffer *messages,
                     struct error *error);
