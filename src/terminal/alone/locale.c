/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two locales without files for the static program, in place of the C library's: C, and UTF-8 where
 * the environment names any locale of that charset. The library's own locales are files that
 * another system lacks or has in another format. These are the functions that readline and ncurses
 * call; each behaves as POSIX.1-2017 describes it. */
#undef _FORTIFY_SOURCE /* its inline forms would replace the functions defined here */
#define _GNU_SOURCE    /* strcasestr, wcwidth */
#include <hooke/base/safe_text.h>

#include <errno.h>
#include <langinfo.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>
#include <wctype.h>

#define MULTIBYTE_INVALID ((size_t)-1)
#define MULTIBYTE_PARTIAL ((size_t)-2)
#define SURROGATE(c) ((c) >= 0xD800 && (c) < 0xE000)

static bool utf8;

/* Returns the locale that the environment names, or "C". */
static const char *environment_locale(void)
{
    static const char *const variable[] = {"LC_ALL", "LC_CTYPE", "LANG"};
    for (size_t i = 0; i < COUNT_OF(variable); i++) {
        const char *value = getenv(variable[i]);
        if (value && *value)
            return value;
    }
    return "C";
}

char *__wrap_setlocale(int category, const char *name);
/* Chooses a locale for LC_CTYPE or LC_ALL, or returns the present one if name is NULL. It is linked
 * in place of setlocale (option --wrap), whose object file also contains what newlocale needs. */
char *__wrap_setlocale(int category, const char *name)
{
    static char plain[] = "C", unicode[] = "C.UTF-8";
    if (category != LC_CTYPE && category != LC_ALL)
        return plain;
    if (name) {
        name = *name ? name : environment_locale();
        utf8 = strcasestr(name, "UTF-8") || strcasestr(name, "UTF8");
    }
    return utf8 ? unicode : plain;
}

char *nl_langinfo(nl_item item)
{
    static char plain[] = "ANSI_X3.4-1968", unicode[] = "UTF-8", none[] = "";
    if (item != CODESET)
        return none;
    return utf8 ? unicode : plain;
}

size_t __ctype_get_mb_cur_max(void)
{
    return utf8 ? 4 : 1;
}

/* Returns the length in bytes of the UTF-8 sequence that begins with this byte, or 0 if none does.
 */
static int sequence_length(unsigned char first)
{
    if (first < 0x80)
        return 1;
    if (!utf8 || first < 0xC2 || first > 0xF4)
        return 0;
    if (first < 0xE0)
        return 2;
    return first < 0xF0 ? 3 : 4;
}

/* The state holds the number of bytes that are missing (low 3 bits of __count), the length of the
 * sequence, and the bits read so far. */
size_t mbrtowc(wchar_t *restrict wide, const char *restrict bytes, size_t count,
               mbstate_t *restrict state)
{
    /* Smaller code points need a shorter sequence, so that longer ones are invalid. */
    static const unsigned smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    static mbstate_t own;
    state = state ? state : &own;
    if (!bytes)
        return mbrtowc(NULL, "", 1, state);
    for (size_t i = 0; i < count; i++) {
        const unsigned char byte = (unsigned char)bytes[i];
        int left = state->__count & 7, length = state->__count >> 3;
        unsigned bits = state->__value.__wch;
        if (length == 0) {
            length = left = sequence_length(byte);
            bits = length > 1 ? byte & (0x7FU >> length) : byte;
        } else if ((byte & 0xC0) == 0x80) {
            bits = bits << 6 | (byte & 0x3F);
        } else {
            left = 0;
        }
        left--;
        *state = (mbstate_t){0};
        if (left < 0 ||
            (left == 0 && (bits < smallest[length] || bits > 0x10FFFF || SURROGATE(bits)))) {
            errno = EILSEQ;
            return MULTIBYTE_INVALID;
        }
        if (left == 0) {
            if (wide)
                *wide = (wchar_t)bits;
            return bits ? i + 1 : 0;
        }
        state->__count = length << 3 | left;
        state->__value.__wch = bits;
    }
    return MULTIBYTE_PARTIAL;
}

/* Writes a character in UTF-8. Returns its length, or MULTIBYTE_INVALID with errno set. */
size_t wcrtomb(char *restrict bytes, wchar_t wide, mbstate_t *restrict state)
{
    const unsigned c = (unsigned)wide;
    (void)state; /* UTF-8 has no shift state */
    if (!bytes)
        return 1;
    if (c > (utf8 ? 0x10FFFF : 0x7F) || SURROGATE(c)) {
        errno = EILSEQ;
        return MULTIBYTE_INVALID;
    }
    size_t length;
    if (c < 0x80)
        length = 1;
    else if (c < 0x800)
        length = 2;
    else
        length = c < 0x10000 ? 3 : 4;
    const unsigned head = length > 1 ? 0xF00U >> length & 0xFF : 0;
    for (size_t i = 0; i < length; i++) {
        const unsigned bits = c >> 6 * (length - 1 - i);
        bytes[i] = (char)(i > 0 ? 0x80 | (bits & 0x3F) : head | bits);
    }
    return length;
}

int mbtowc(wchar_t *restrict wide, const char *restrict bytes, size_t count)
{
    mbstate_t state = {0};
    const size_t used = bytes ? mbrtowc(wide, bytes, count, &state) : 0;
    return used == MULTIBYTE_INVALID || used == MULTIBYTE_PARTIAL ? -1 : (int)used;
}

int mblen(const char *bytes, size_t count)
{
    return mbtowc(NULL, bytes, count);
}

/* Converts a string to wide characters, at most `count`, or only counts them if wide is NULL. */
size_t mbstowcs(wchar_t *restrict wide, const char *restrict bytes, size_t count)
{
    mbstate_t state = {0};
    size_t n = 0;
    for (wchar_t c; !wide || n < count; n++) {
        const size_t used = mbrtowc(&c, bytes, MB_CUR_MAX, &state);
        if (used == MULTIBYTE_INVALID || used == MULTIBYTE_PARTIAL)
            return MULTIBYTE_INVALID;
        if (wide)
            wide[n] = used ? c : 0;
        if (used == 0)
            break;
        bytes += used;
    }
    return n;
}

/* Converts wide characters to a string of at most `count` bytes, or only counts the bytes if
 * `bytes` is NULL. *wide becomes the first character not converted, NULL at the end. */
size_t wcsrtombs(char *restrict bytes, const wchar_t **restrict wide, size_t count,
                 mbstate_t *restrict state)
{
    const wchar_t *source = *wide;
    size_t n = 0;
    char one[4];
    for (; *source; source++) {
        const size_t length = wcrtomb(one, *source, state);
        if (length == MULTIBYTE_INVALID)
            return MULTIBYTE_INVALID;
        if (bytes && n + length > count)
            break;
        if (bytes)
            memcpy(bytes + n, one, length);
        n += length;
    }
    if (bytes && !*source && n < count) {
        bytes[n] = 0;
        source = NULL;
    }
    if (bytes)
        *wide = source;
    return n;
}

size_t wcstombs(char *restrict bytes, const wchar_t *restrict wide, size_t count)
{
    const wchar_t *source = wide;
    return wcsrtombs(bytes, &source, count, NULL);
}

wint_t btowc(int byte)
{
    return byte >= 0 && byte < 0x80 ? (wint_t)byte : WEOF;
}

int wctob(wint_t wide)
{
    return wide < 0x80 ? (int)wide : EOF;
}

int wcwidth(wchar_t wide)
{
    const unsigned c = (unsigned)wide, last = utf8 ? 0x10FFFF : 0x7F;
    if (c < ' ' || (c >= 0x7F && c < 0xA0) || c > last)
        return c == 0 ? 0 : -1;
    return codepoint_width(c);
}

int iswprint(wint_t wide)
{
    return wide != 0 && wcwidth((wchar_t)wide) >= 0;
}

/* Returns true for ASCII letters and digits and for all characters beyond ASCII except signs and
 * blanks, which is enough for moving by words. */
int iswalnum(wint_t wide)
{
    const unsigned c = wide | 0x20;
    return (wide >= '0' && wide <= '9') || (c >= 'a' && c <= 'z') ||
           (utf8 && wide >= 0xC0 && wide != 0xD7 && wide != 0xF7 &&
            (wide < 0x2000 || wide >= 0x2E80) && iswprint(wide));
}
