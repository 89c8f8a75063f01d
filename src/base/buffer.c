/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Growing byte strings. A failed allocation sets `failed`, after which nothing is added; the caller
 * checks it once, at the end. */
#include <hooke/base/safe_text.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes room for extra more bytes and the NUL, by doubling. Returns false if memory runs out, now
 * or earlier. */
static bool buffer_make_room(struct buffer *buffer, size_t extra)
{
    if (buffer->failed)
        return false;
    size_t needed;
    if (__builtin_add_overflow(buffer->len + 1, extra, &needed)) {
        buffer->failed = true;
        return false;
    }
    if (needed <= buffer->cap)
        return true;
    size_t cap = buffer->cap > SIZE_MAX / 2 ? needed : buffer->cap * 2;
    cap = cap < needed ? needed : cap;
    cap = cap < 64 ? 64 : cap;
    char *data = realloc(buffer->data, cap);
    if (!data) {
        buffer->failed = true;
        return false;
    }
    buffer->data = data;
    buffer->cap = cap;
    return true;
}

/* Appends text and keeps a NUL behind it. */
void buffer_put(struct buffer *buffer, struct text text)
{
    if (!buffer_make_room(buffer, text.len))
        return;
    if (text.len)
        memcpy(buffer->data + buffer->len, text.data, text.len);
    buffer->len += text.len;
    buffer->data[buffer->len] = '\0';
}

void buffer_char(struct buffer *buffer, char c)
{
    buffer_put(buffer, (struct text){&c, 1});
}

/* Appends a code point as UTF-8; surrogates and numbers above U+10FFFF become CODEPOINT_INVALID. */
void buffer_codepoint(struct buffer *buffer, uint32_t codepoint)
{
    static const unsigned char lead[] = {0, 0x00, 0xC0, 0xE0, 0xF0};
    if (codepoint > 0x10FFFF || (codepoint >= 0xD800 && codepoint <= 0xDFFF))
        codepoint = CODEPOINT_INVALID;
    size_t len;
    if (codepoint < 0x80)
        len = 1;
    else if (codepoint < 0x800)
        len = 2;
    else
        len = codepoint < 0x10000 ? 3 : 4;
    char bytes[4];
    for (size_t i = len; i-- > 1; codepoint >>= 6)
        bytes[i] = (char)(0x80 | (codepoint & 0x3F));
    bytes[0] = (char)(lead[len] | codepoint);
    buffer_put(buffer, (struct text){bytes, len});
}

/* Appends formatted text. It formats twice: once to learn the length, then into the room made for
 * it. */
void buffer_vformat(struct buffer *buffer, const char *format, va_list args)
{
    va_list again;
    va_copy(again, args);
    int len = vsnprintf(NULL, 0, format, again);
    va_end(again);
    if (len < 0)
        buffer->failed = true;
    if (len < 0 || !buffer_make_room(buffer, (size_t)len))
        return;
    vsnprintf(buffer->data + buffer->len, (size_t)len + 1, format, args);
    buffer->len += (size_t)len;
}

void buffer_format(struct buffer *buffer, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    buffer_vformat(buffer, format, args);
    va_end(args);
}

/* Empties the buffer and keeps its memory; also clears the mark of a failure. */
void buffer_clear(struct buffer *buffer)
{
    buffer->len = 0;
    buffer->failed = false;
    if (buffer->data)
        buffer->data[0] = '\0';
}

void buffer_free(struct buffer *buffer)
{
    free(buffer->data);
    *buffer = (struct buffer){0};
}

struct text buffer_text(const struct buffer *buffer)
{
    return buffer->data ? (struct text){buffer->data, buffer->len} : (struct text){"", 0};
}

/* Returns the bytes as a string that the buffer owns, or a message in their place if memory ran
 * out. */
const char *buffer_view(const struct buffer *buffer)
{
    if (buffer->failed)
        return "(out of memory)";
    return buffer->data ? buffer->data : "";
}

/* Appends bytes in base64, four digits for three bytes, padded by '='. */
void buffer_base64(struct buffer *output, struct text bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *byte = (const unsigned char *)bytes.data;
    for (size_t i = 0; i < bytes.len; i += 3) {
        const size_t n = bytes.len - i < 3 ? bytes.len - i : 3;
        const unsigned middle = n > 1 ? (unsigned)byte[i + 1] << 8 : 0;
        const unsigned word =
            (unsigned)byte[i] << 16 | middle | (n > 2 ? (unsigned)byte[i + 2] : 0);
        for (size_t k = 0; k < 4; k++)
            buffer_char(output, k <= n ? digits[word >> (18 - 6 * k) & 63] : '=');
    }
}
