/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Texts, which are pointers with a length and own no memory: comparing, splitting, trimming, and
 * the distance between spellings. */
#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>

#include <limits.h>
#include <string.h>

struct text text_of(const char *z)
{
    return z ? (struct text){z, strlen(z)} : (struct text){"", 0};
}

bool text_equal(struct text a, struct text b)
{
    return a.len == b.len && (a.len == 0 || memcmp(a.data, b.data, a.len) == 0);
}

bool text_is(struct text a, const char *z)
{
    if (z && a.len > 0 && *z != *a.data) /* settles most comparisons quickly */
        return false;
    return text_equal(a, text_of(z));
}

bool text_starts(struct text a, struct text prefix)
{
    return a.len >= prefix.len && text_equal((struct text){a.data, prefix.len}, prefix);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Returns the part of a path behind its last '/'. */
struct text text_last_component(struct text path)
{
    size_t begin = path.len;
    while (begin > 0 && path.data[begin - 1] != '/')
        begin--;
    return text_after(path, begin);
}

/* Returns the ending of a file name without its dot, or an empty text; a leading dot is no
 * ending. */
struct text text_ending(struct text path)
{
    const struct text name = text_last_component(path);
    size_t dot = name.len;
    while (dot > 0 && name.data[dot - 1] != '.')
        dot--;
    return dot > 1 ? text_after(name, dot) : TEXT("");
}

/* Returns the text without blanks at both ends. */
struct text text_trim(struct text a)
{
    while (a.len > 0 && is_blank(a.data[a.len - 1]))
        a.len--;
    while (a.len > 0 && is_blank(a.data[0])) {
        a.data++;
        a.len--;
    }
    return a;
}

/* Takes the text up to the separator off *rest into *head. Returns false at the end: *rest is NULL
 * after the last piece, so that an empty piece at the end is found, too. */
bool text_split(struct text *rest, char separator, struct text *head)
{
    if (rest->data == NULL)
        return false;
    const char *cut = rest->len ? memchr(rest->data, separator, rest->len) : NULL;
    if (cut) {
        *head = (struct text){rest->data, (size_t)(cut - rest->data)};
        *rest = (struct text){cut + 1, rest->len - head->len - 1};
    } else {
        *head = *rest;
        *rest = (struct text){NULL, 0};
    }
    return true;
}

static int int_min(int a, int b)
{
    return a < b ? a : b;
}

/* Returns the number of edits (insert, delete, replace, transpose) between two spellings. The
 * optimal string alignment needs the last three rows only (Boytsov 2011, section 2.1). */
int text_distance(struct text a, struct text b)
{
    size_t longer = a.len > b.len ? a.len : b.len;
    if (longer > LIMIT_NAME)
        return longer > INT_MAX ? INT_MAX : (int)longer;

    int rows[3][LIMIT_NAME + 1];
    for (size_t j = 0; j <= b.len; j++)
        rows[0][j] = (int)j;
    for (size_t i = 1; i <= a.len; i++) {
        const int *transposition_row = rows[(i + 1) % 3], *previous_row = rows[(i - 1) % 3];
        int *row = rows[i % 3];
        row[0] = (int)i;
        for (size_t j = 1; j <= b.len; j++) {
            int replaced = previous_row[j - 1] + (a.data[i - 1] != b.data[j - 1]);
            row[j] = int_min(replaced, int_min(previous_row[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && a.data[i - 1] == b.data[j - 2] && a.data[i - 2] == b.data[j - 1])
                row[j] = int_min(row[j], transposition_row[j - 2] + 1);
        }
    }
    return rows[a.len % 3][b.len];
}
