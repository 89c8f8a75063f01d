/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The session as it is, as records of a file that only grows, and back. Nothing that was computed
 * is computed again: rows of runs, results, fits and tables are there as bits.
 *
 * The file, version 2. Numbers are in the byte order of the machine that wrote it.
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
 * Where a head does not fit its checksum, reading goes on at the next one that does; a record whose
 * content does not fit its own, or of a kind that is not known, is skipped and named. Kinds:
 *
 *     D  the bytes of a recording's file, or the times and values of the curve of a fit, once:
 *        fields sum, content
 *     R  a run without its rows: fields id, number, method, scene, events, note, asked (each thing
 *        that was asked of it), state (hooke/run/store.h). The last one of an id counts.
 *     W  rows of a run: 4 numbers of 8 bytes (id, the first row, how many, bytes of a row), rows.
 *        All of that run's from the first on are replaced.
 *     L  what was typed since: fields from (the first entry), text_from, entries, text
 *     T  what was said since, for the log pane: lines
 *     B  one thing that was found of the equations, once: fields id, kind (equilibria, orbit,
 *        branch), value (of the parameters), and its own
 *     S  all the rest, as fields, in a few thousand bytes. Records count once an S follows them:
 *        what stands after the last one was being written when the program ended.
 *
 * Fields are those of hooke/base/fields.h: one that is missing, or has another size than this
 * program's, is left out, and what needs it is named. S has the set-up as commands; beside arrays
 * that have an item a parameter stand the names of the parameters: a program that has more of
 * them, or in another order, reads them.
 */
#pragma once

#include <hooke/session/stored.h>

struct cancel;

#define STORE_HEADER "hooke session 2\n"
/* [byte] rows of runs beyond it are not kept: those of the oldest run go first */
#define STORE_ROW_BYTES ((size_t)512 << 20)
/* [byte] recordings that are larger are read from where they were */
#define STORE_RECORDING_BYTES ((size_t)64 << 20)

struct store_sink {
    void *context;
    bool (*write)(void *context, struct text record, struct error *error);
    const struct cancel *cancel; /* NULL if nobody stops it */
    int64_t deadline; /* [clock_ns] when further rows are left to another time; 0: never */
};

void stored_free(struct stored *stored); /* and forgets: all is written again, to another file */
/* Writes what has changed since the last time; where it is stopped, `unfinished` is set, and what
 * was written does not count yet. Returns false if it cannot be written, or no memory. */
bool session_store(struct session *session, struct stored *stored, const struct store_sink *sink,
                   struct error *error);

/*
 * Into a new session. name: of the file; temporary: folder for what only files can be read from,
 * NULL: /tmp. notes: a line for each part that could not be restored, and why. Returns false if
 * there is nothing that could be restored.
 */
bool session_restore(struct session *session, struct text content, const char *name,
                     const char *temporary, struct buffer *notes, struct error *error);
