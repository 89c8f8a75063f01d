/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Archives, workbooks and documents made byte by byte: what tests of containers share. */
#pragma once

#include "modules/recording/data/archive_writers.h"
#include "modules/recording/data/fixture.h"

#ifdef HAVE_ARCHIVE
#define ARCHIVES true
#else
#define ARCHIVES false
#endif
#ifdef HAVE_EXPAT
#define XML true
#else
#define XML false
#endif

/* Deflate, fixed codes (RFC 1951, 3.2.6): a table, then copies of 258 bytes from 1 back: blank
 * lines; 13 bits for each copy. */
static inline void put_bomb(struct buffer *out, size_t copies)
{
    uint64_t bits = 0;
    int count = 0;
    buffer_put(out, (struct text){"\x1F\x8B\x08\0\0\0\0\0\0\xFF", 10});
#define PUT(value, n)                                                                              \
    for (bits |= (uint64_t)(value) << count, count += (n); count >= 8; count -= 8, bits >>= 8)     \
        buffer_char(out, (char)(bits & 0xFF));
    PUT(3, 3) /* the last block, fixed codes */
    for (const char *c = table; *c; c++)
        for (int bit = 8; bit-- > 0;) /* a literal's code, its first bit first */
            PUT((0x30 + *c) >> bit & 1, 1)
    for (size_t i = 0; i < copies; i++) {
        PUT(0xA3, 8) /* length 258: 11000101, its first bit first */
        PUT(0, 5)
    }
    PUT(0, 7)
    PUT(0, 7)
#undef PUT
    put_number(out, 0, 8);
}

static inline struct recording *load_bytes(const struct buffer *bytes, const char *options,
                                           struct error *error)
{
    assert_false(bytes->failed);
    return fixture_load(bytes->data, bytes->len, options, error);
}

static inline bool refused(struct recording *recording, const struct error *error, const char *part)
{
    const bool right = !recording && error->code == ERROR_IO && strstr(error->text, part);
    if (!right)
        print_message("expected a refusal with '%s', got %s\n", part,
                      recording ? "a recording" : error->text);
    recording_destroy(recording);
    return right;
}
