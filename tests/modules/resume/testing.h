/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions that are kept and come back. Included after <cmocka.h>. */
#pragma once

#include "modules/resume/store.h"
#include "unit/command/testing.h"

static inline bool bench_add(void *context, struct text record, struct error *error)
{
    (void)error;
    buffer_put(context, record);
    return true;
}

/* Appends what has changed since the last time. */
static inline void bench_store(struct session *session, struct stored *stored, struct buffer *file)
{
    struct error error = {0};
    if (file->len == 0)
        buffer_put(file, TEXT(STORE_HEADER));
    if (!session_store(session, stored, &(struct store_sink){file, bench_add, NULL, 0}, &error))
        fail_msg("it is not stored: %s", error.text);
    assert_false(file->failed);
}

/* In a new session. False: nothing could be restored. */
static inline bool bench_restore(struct bench *again, struct text file, struct buffer *notes)
{
    struct error error;
    bench_open(again, false);
    return session_restore(again->session, file, "kept", NULL, notes, &error);
}

/* The session as --resume finds it, all of it. */
static inline void bench_resume(const struct bench *b, struct bench *again)
{
    struct stored stored = {0};
    struct buffer file = {0}, notes = {0};
    bench_store(b->session, &stored, &file);
    if (!bench_restore(again, buffer_text(&file), &notes) || notes.len > 0)
        fail_msg("it does not come back: %s", said(&notes));
    stored_free(&stored);
    buffer_free(&file);
    buffer_free(&notes);
}
