/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Writes a session as records of a file that only grows, and restores it. Nothing is computed
 * again: rows of runs, results, fits and tables are stored bit for bit.
 *
 * The format of the file is version 2. Numbers are in the byte order of the machine that wrote it.
 *
 *     16 bytes     "hooke session 2\n"
 *     records, one after the other:
 *         4 bytes  "\xF0HR\n"
 *         4        kind, a letter
 *         8        bytes of content that follow the head
 *         8        checksum of the content (bytes_sum())
 *         8        checksum of the 24 bytes above
 *         content
 *
 * If a head does not match its checksum, reading continues at the next one that does. A record of
 * an unknown kind, or whose content does not match its checksum, is skipped and named. The kinds
 * are:
 *
 *     D  the bytes of a recording's file, or the times and values of the curve of a fit, stored
 *        once, as fields sum, content
 *     R  a run without its rows, as fields id, number, method, scene, events, note, asked (each
 *        result that was requested), state (hooke/run/store.h). The last one of an id counts.
 *     W  rows of a run, as 4 numbers of 8 bytes (id, the first row, number of rows, bytes of a
 *        row), then the rows. They replace all rows of that run from the first one on.
 *     L  input typed since the last one, as fields from (the first entry), text_from, entries, text
 *     T  output printed since the last one, for the log pane, as lines
 *     B  one result about the equations, stored once, as fields id, kind (equilibria, orbit,
 *        branch), value (of the parameters), and its own
 *     S  everything else, as fields, in a few thousand bytes. Records are valid only if an S
 *        follows them; records after the last S were being written when the program ended.
 *
 * The format of fields is in hooke/base/fields.h. A field that is missing, or has a different size
 * than in this program, is left out, and the parts that need it are named. S has the set-up as
 * commands. Arrays with one item per parameter are stored with the names of the parameters, so that
 * programs with more of them, or with another order, can read them.
 */
#pragma once

#include <hooke/session/stored.h>

struct cancel;

#define STORE_HEADER "hooke session 2\n"
/* [byte] largest size of the rows of runs; beyond it those of the oldest runs are left out */
#define STORE_ROW_BYTES ((size_t)512 << 20)
/* [byte] largest size of a recording that is stored; larger ones are read from their files again */
#define STORE_RECORDING_BYTES ((size_t)64 << 20)

/* A receiver of the bytes that session_store() writes. */
struct store_sink {
    void *context;
    bool (*write)(void *context, struct text record, struct error *error);
    const struct cancel *cancel; /* stops writing, or NULL */
    /* [clock_ns] time after which further rows are left to the next call, or 0 for none */
    int64_t deadline;
};

/* Frees *stored and zeroes it, so that the next session_store() writes everything. */
void stored_free(struct stored *stored);
/* Writes what has changed since the last call; *stored remembers what the file has. If writing is
 * stopped (by sink->cancel or the deadline), stored->unfinished is set and the function returns
 * true: the next call continues, and until it completes, a reader of the file ignores the new
 * records. Returns false with an error if the sink refuses a record or if out of memory. */
bool session_store(struct session *session, struct stored *stored, const struct store_sink *sink,
                   struct error *error);

/* Restores the session from the content of the file `name` into a new session. `temporary` is a
 * folder for data that can only be read from files; NULL stands for /tmp. notes receives a line
 * for each part that could not be restored, with the reason. Returns false if nothing could be
 * restored. */
bool session_restore(struct session *session, struct text content, const char *name,
                     const char *temporary, struct buffer *notes, struct error *error);
