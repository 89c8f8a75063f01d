/* SPDX-License-Identifier: GPL-3.0-or-later */
/* text: the types on which everything is built: slices of text (struct text), memory that is freed
 * all at once (struct arena) and text that grows (struct buffer). */
#pragma once

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Number of elements of an array (not of a pointer). */
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
/* NAN and INFINITY as doubles: those of <math.h> are floats, whose conversion -Wdouble-promotion
 * reports. */
#undef NAN
#define NAN (__builtin_nan(""))
#undef INFINITY
#define INFINITY (__builtin_inf())

/* Attribute of functions with a printf format: position of the format and of its first argument. */
#define PRINTF_LIKE(position, first) __attribute__((__format__(__printf__, position, first)))

/* ---- text: a slice of memory that somebody else owns ---- */

/* A slice of text: it does not own its bytes and may be copied freely. */
struct text {
    const char *data; /* Bytes, usually UTF-8, without a NUL at the end; NULL if unset. */
    size_t len;       /* Length [byte]. */
};

/* A string literal as a struct text. */
#define TEXT(literal) ((struct text){(literal), sizeof(literal) - 1})

/* Returns true for the digits 0 to 9, whatever the locale. Unlike isdigit() it takes a signed char.
 */
static inline bool is_digit_char(char c)
{
    return c >= '0' && c <= '9';
}

/* Returns the slice after the first `count` bytes of a text; count <= text.len, which is not
 * checked. */
static inline struct text text_after(struct text text, size_t count)
{
    return (struct text){text.data + count, text.len - count};
}

/* Returns a NUL-terminated string as a slice without its NUL; NULL gives the empty text. */
struct text text_of(const char *z);
/* Returns true if both texts have the same bytes. */
bool text_equal(struct text a, struct text b);
/* Returns true if the text has the bytes of the string z, which may be NULL for the empty text. */
bool text_is(struct text a, const char *z);
/* Returns true if the text begins with `prefix`. */
bool text_starts(struct text a, struct text prefix);
/* Returns the text without blanks, tabs and CR at both ends. */
struct text text_trim(struct text a);
/* Returns the part of a path after the last slash, or all of it if there is no slash. */
struct text text_last_component(struct text path);
/* Returns the extension of a file's name without its dot, or the empty text if the name has no dot
 * other than its first character. */
struct text text_ending(struct text path);
/* Moves the text before the next separator, or all that remains, from the beginning of *rest
 * to *head, and drops the separator. Returns false when everything, including a last empty
 * piece, has been returned: rest->data is then NULL. */
bool text_split(struct text *rest, char separator, struct text *head);

/*
 * ---- memory ----
 *
 * An arena owns blocks of memory, from which arena_alloc() returns parts; arena_reset() frees them
 * all. Start with a zeroed struct arena. A function that allocates may return NULL; its caller then
 * reports error_memory() and leaves its object unchanged.
 */

struct cancel;

/* List of the blocks that the arena owns; zero-initialise it. */
struct arena {
    struct arena_block *blocks;
};

/* Returns zeroed memory of `size` bytes, aligned for any type, which lives until arena_reset().
 * Returns NULL if out of memory. */
void *arena_alloc(struct arena *arena, size_t size);
/* Returns zeroed memory for `count` items of `size` bytes. Returns NULL if out of memory or if the
 * product overflows. */
void *arena_array(struct arena *arena, size_t count, size_t size);
/* Returns a NUL-terminated copy of the text, or NULL if out of memory. */
char *arena_text(struct arena *arena, struct text text);
void arena_reset(struct arena *arena); /* Frees all memory of the arena, which can be used again. */
/* Moves all memory of `source` to `target`, which frees it later; pointers stay valid. */
void arena_move(struct arena *source, struct arena *target);
/* Frees all memory of the arena as arena_reset() does, but may stop early when cancelled, because
 * freeing gigabytes takes 0.1 s; `cancel` may be NULL. */
void arena_give_back(struct arena *arena, const struct cancel *cancel);

/* Text that grows; zero-initialise it, and end with buffer_free(). After a failed allocation
 * `failed` is set and later writes are ignored, so that callers check once, at the end. */
struct buffer {
    char *data; /* Bytes with a NUL at the end, owned; NULL before the first write. */
    /* Length without the NUL, and allocated size [byte]. */
    size_t len, cap;
    /* Memory has run out, or a format was invalid: the text is incomplete. */
    bool failed;
};

/* Appends a text. */
void buffer_put(struct buffer *buffer, struct text text);
/* Appends one byte. */
void buffer_char(struct buffer *buffer, char c);
/* Appends a code point as UTF-8; surrogates and values above U+10FFFF become U+FFFD. */
void buffer_codepoint(struct buffer *buffer, uint32_t codepoint);
/* Appends formatted text, as printf() does. */
void buffer_format(struct buffer *buffer, const char *format, ...) PRINTF_LIKE(2, 3);
/* Appends formatted text, as vprintf() does. */
void buffer_vformat(struct buffer *buffer, const char *format, va_list args) PRINTF_LIKE(2, 0);
/* Appends bytes in base64 (RFC 4648) on one line. */
void buffer_base64(struct buffer *buffer, struct text bytes);
/* Makes the text empty and clears `failed`; the memory is kept for further use. */
void buffer_clear(struct buffer *buffer);
/* Frees the memory and zeroes the struct. */
void buffer_free(struct buffer *buffer);
/* Returns the content as a slice, which is valid until the next write. */
struct text buffer_text(const struct buffer *buffer);
/* Returns the content as a NUL-terminated string, valid until the next write. Never NULL: "" if
 * nothing was written, "(out of memory)" if the buffer has failed. */
const char *buffer_view(const struct buffer *buffer);
