/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The file of a session that somebody has changed, checksums and all. */
#pragma once

#include "modules/resume/store/reading.h"

#include <stddef.h>
#include <string.h>

static inline size_t next_record(const uint8_t *data, size_t size, size_t from)
{
    for (; from + sizeof(struct record_head) <= size; from++)
        if (memcmp(data + from, RECORD_MAGIC, sizeof RECORD_MAGIC - 1) == 0)
            return from;
    return size;
}

/* Every record ends where the next begins, and its sums are right. */
static inline void mend(uint8_t *data, size_t size)
{
    const size_t first = sizeof STORE_HEADER - 1;
    memcpy(data, STORE_HEADER, first);
    for (size_t at = next_record(data, size, first), next; at < size; at = next) {
        struct record_head head;
        const size_t content = at + sizeof head;
        next = next_record(data, size, content);
        memcpy(&head, data + at, sizeof head);
        head.bytes = next - content;
        head.sum = bytes_sum((struct text){(const char *)data + content, next - content});
        head.own = bytes_sum((struct text){(const char *)&head, offsetof(struct record_head, own)});
        memcpy(data + at, &head, sizeof head);
    }
}
