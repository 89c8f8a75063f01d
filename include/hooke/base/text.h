/* SPDX-License-Identifier: GPL-3.0-or-later */
/* text: slices of text, text that grows, and memory that is freed all at once. */
#pragma once

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
/* Those of <math.h> are floats, which -Wdouble-promotion warns of wherever they are used. */
#undef NAN
#define NAN (__builtin_nan(""))
#undef INFINITY
#define INFINITY (__builtin_inf())

#define PRINTF_LIKE(position, first) __attribute__((__format__(__printf__, position, first)))

/* ---- text: a slice that somebody else owns ---- */

struct text {
    const char *data; /* not NUL-terminated */
    size_t len;       /* [byte] */
};

#define TEXT(literal) ((struct text){(literal), sizeof(literal) - 1})

/* Returns true for the digits 0 to 9, whatever the locale; isdigit() of <ctype.h> wants an unsigned
 * character. */
static inline bool is_digit_char(char c)
{
    return c >= '0' && c <= '9';
}

/* Returns what follows the first `count` bytes of a text, a slice of the same memory. The text has
 * at least as many bytes: nothing checks it. */
static inline struct text text_after(struct text text, size_t count)
{
    return (struct text){text.data + count, text.len - count};
}

/* Returns the text up to the NUL; NULL gives the empty text. */
struct text text_of(const char *z);
bool text_equal(struct text a, struct text b);
bool text_is(struct text a, const char *z);
bool text_starts(struct text a, struct text prefix);
struct text text_trim(struct text a); /* drops blanks, tabs and CR at both ends */
/* Returns what follows the last slash, or all of the path. */
struct text text_last_component(struct text path);
/* Returns what follows the last point of a file's name, or the empty text if the name has no point
 * other than its first character. */
struct text text_ending(struct text path);
/* Moves the text up to the next separator from *rest to *head. Returns false if *rest is empty. */
bool text_split(struct text *rest, char separator, struct text *head);

/* ---- memory ----
 *
 * An arena hands out memory that is freed all at once. Every function that allocates may return
 * NULL; the caller then reports error_memory() and leaves its object as it was.
 */

struct cancel;

struct arena {
    struct arena_block *blocks;
};

/* Returns zeroed memory aligned for any type, or NULL if there is none. */
void *arena_alloc(struct arena *arena, size_t size);
/* The same for `count` items; also NULL if their size overflows. */
void *arena_array(struct arena *arena, size_t count, size_t size);
char *arena_text(struct arena *arena,
                 struct text text);    /* returns a NUL-terminated copy, or NULL */
void arena_reset(struct arena *arena); /* frees everything; the arena can be used again */
/* Makes `target` the owner of all memory that `source` has handed out. */
void arena_move(struct arena *source, struct arena *target);
/* Does the same as arena_reset() and stops when cancelled: gigabytes take 0.1 s. */
void arena_give_back(struct arena *arena, const struct cancel *cancel);

/* Text that grows. After a failed allocation `failed` is set and later writes are ignored: check
 * once at the end. */
struct buffer {
    char *data; /* always NUL-terminated when not NULL */
    size_t len, cap;
    bool failed;
};

void buffer_put(struct buffer *buffer, struct text text);
void buffer_char(struct buffer *buffer, char c);
void buffer_codepoint(struct buffer *buffer, uint32_t codepoint); /* as UTF-8 */
void buffer_format(struct buffer *buffer, const char *format, ...) PRINTF_LIKE(2, 3);
void buffer_vformat(struct buffer *buffer, const char *format, va_list args) PRINTF_LIKE(2, 0);
void buffer_base64(struct buffer *buffer, struct text bytes); /* RFC 4648, on one line */
void buffer_clear(struct buffer *buffer);
void buffer_free(struct buffer *buffer);
struct text buffer_text(const struct buffer *buffer);
/* Returns the text NUL-terminated, "out of memory" if the buffer has failed; never NULL. */
const char *buffer_view(const struct buffer *buffer);
