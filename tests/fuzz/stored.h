/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session's file, in memory. */
#pragma once

#include <hooke/report.h>
#include "modules/resume/store.h"

static inline bool stored_add(void *context, struct text record, struct error *error)
{
    (void)error;
    buffer_put(context, record);
    return true;
}

/* All of it; aborts where that fails. */
static inline void stored_put(struct session *session, struct buffer *file)
{
    struct stored stored = {0};
    struct error error = {0};
    buffer_put(file, TEXT(STORE_HEADER));
    if (!session_store(session, &stored, &(struct store_sink){file, stored_add, NULL, 0}, &error)) {
        fprintf(stderr, "it is not stored: %s\n", error.text);
        abort();
    }
    stored_free(&stored);
}

/* Into a new session, as --resume does it. */
static inline bool stored_take(struct session *session, struct text file, struct buffer *notes)
{
    struct error error = {0};
    const bool ok = session_restore(session, file, "kept", NULL, notes, &error);
    if (!ok)
        buffer_format(notes, "%s\n", error.text);
    return ok;
}
