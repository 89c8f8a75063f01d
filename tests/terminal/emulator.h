/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A terminal in memory: what ncurses sends for xterm and its kin becomes a screen that tests can
 * look at. */
#pragma once

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/safe_text.h>

#define EMULATOR_PARAMETERS 8

struct emulator {
    int width, height, x, y, top, bottom;
    int saved_x, saved_y;
    bool wrap;  /* the cursor stands behind the last column */
    bool eager; /* a terminal that goes to the next row at once instead */
    uint32_t *cell;
    uint32_t last;                       /* character, for REP */
    bool second_screen, pasting, hidden; /* modes 1049, 2004, 25 */
    int questions;                       /* ESC[5n */
    int colors;                          /* SGR parameters that choose a colour */
    int unknown;                         /* sequences that it does not know */
    char unknown_text[64];
    char sequence[64]; /* escape sequence or UTF-8 character under way */
    size_t len;
};

static inline void emulator_blank(struct emulator *e, int x0, int y0, int x1, int y1)
{
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            e->cell[y * e->width + x] = ' ';
        }
    }
}

static inline void emulator_size(struct emulator *e, int width, int height)
{
    uint32_t *cell = malloc((size_t)width * (size_t)height * sizeof *cell);
    if (!cell) {
        abort();
    }
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            cell[y * width + x] =
                e->cell && x < e->width && y < e->height ? e->cell[y * e->width + x] : ' ';
        }
    }
    free(e->cell);
    e->cell = cell;
    e->width = width;
    e->height = height;
    e->top = 0;
    e->bottom = height - 1;
    e->x = e->x < width ? e->x : width - 1;
    e->y = e->y < height ? e->y : height - 1;
    e->wrap = false;
}

static inline void emulator_free(struct emulator *e)
{
    free(e->cell);
    e->cell = NULL;
}

/* Moves rows from..to up by n (down if negative), blanks what becomes free. */
static inline void emulator_roll(struct emulator *e, int from, int to, int n)
{
    const int rows = to - from + 1, by = abs(n) < rows ? abs(n) : rows;
    const size_t w = (size_t)e->width;
    if (n > 0) {
        memmove(e->cell + (size_t)from * w, e->cell + (size_t)(from + by) * w,
                (size_t)(rows - by) * w * sizeof *e->cell);
        emulator_blank(e, 0, to + 1 - by, e->width, to + 1);
    } else {
        memmove(e->cell + (size_t)(from + by) * w, e->cell + (size_t)from * w,
                (size_t)(rows - by) * w * sizeof *e->cell);
        emulator_blank(e, 0, from, e->width, from + by);
    }
}

static inline void emulator_down(struct emulator *e)
{
    if (e->y == e->bottom) {
        emulator_roll(e, e->top, e->bottom, 1);
    } else if (e->y < e->height - 1) {
        e->y++;
    }
}

static inline void emulator_put(struct emulator *e, uint32_t c)
{
    const int width = codepoint_width(c);
    if (width == 0) {
        return;
    }
    if (e->wrap || e->x + width > e->width) {
        e->x = 0;
        e->wrap = false;
        emulator_down(e);
    }
    e->cell[e->y * e->width + e->x] = c;
    if (width == 2 && e->x + 1 < e->width) {
        e->cell[e->y * e->width + e->x + 1] = 0;
    }
    e->last = c;
    e->x += width;
    if (e->x >= e->width) {
        e->x = e->eager ? 0 : e->width - 1;
        e->wrap = !e->eager;
        if (e->eager) {
            emulator_down(e);
        }
    }
}

/* Moves a row's tail by n cells from the cursor on. */
static inline void emulator_shift(struct emulator *e, int n)
{
    uint32_t *row = e->cell + e->y * e->width;
    const int capacity = e->width - e->x, by = abs(n) < capacity ? abs(n) : capacity;
    const size_t bytes = (size_t)(capacity - by) * sizeof *row;
    if (n > 0) {
        memmove(row + e->x + by, row + e->x, bytes);
        emulator_blank(e, e->x, e->y, e->x + by, e->y + 1);
    } else {
        memmove(row + e->x, row + e->x + by, bytes);
        emulator_blank(e, e->width - by, e->y, e->width, e->y + 1);
    }
}

static inline int emulator_clamp(int value, int max)
{
    return value < 0 ? 0 : value > max ? max : value;
}

static inline void emulator_modes(struct emulator *e, const int *p, int n, bool on)
{
    for (int i = 0; i < n; i++) {
        if (p[i] == 1049) {
            e->second_screen = on; /* what the first one showed is not kept */
            emulator_blank(e, 0, 0, e->width, e->height);
        } else if (p[i] == 2004) {
            e->pasting = on;
        } else if (p[i] == 25) {
            e->hidden = !on;
        }
    }
}

static inline void emulator_colors(struct emulator *e, const int *p, int n)
{
    for (int i = 0; i < n; i++) {
        e->colors += (p[i] >= 30 && p[i] <= 49) || (p[i] >= 90 && p[i] <= 107);
    }
}

static inline void emulator_unknown(struct emulator *e)
{
    e->unknown++;
    snprintf(e->unknown_text, sizeof e->unknown_text, "%.*s", (int)e->len, e->sequence);
}

/* A whole CSI sequence: ESC [ (?) numbers final. */
static inline void emulator_control(struct emulator *e)
{
    int p[EMULATOR_PARAMETERS] = {0}, n = 0;
    const bool private_mode = e->sequence[2] == '?' || e->sequence[2] == '>';
    const char final = e->sequence[e->len - 1];
    for (size_t i = private_mode ? 3 : 2; i + 1 < e->len; i++) {
        if (isdigit((unsigned char)e->sequence[i])) {
            p[n] = p[n] * 10 + (e->sequence[i] - '0');
        } else if (n + 1 < EMULATOR_PARAMETERS) {
            n++;
        }
    }
    n++;
    const int one = p[0] > 0 ? p[0] : 1;
    const int right = e->width - 1, low = e->height - 1;
    if (private_mode) {
        if (final == 'h' || final == 'l') {
            emulator_modes(e, p, n, final == 'h');
        } else if (final != 'c' && final != 'm') {
            emulator_unknown(e);
        }
        return;
    }
    if (final != 'm') {
        e->wrap = false;
    }
    switch (final) {
    case 'A':
        e->y = emulator_clamp(e->y - one, low);
        break;
    case 'B':
        e->y = emulator_clamp(e->y + one, low);
        break;
    case 'C':
        e->x = emulator_clamp(e->x + one, right);
        break;
    case 'D':
        e->x = emulator_clamp(e->x - one, right);
        break;
    case 'G':
        e->x = emulator_clamp(one - 1, right);
        break;
    case 'd':
        e->y = emulator_clamp(one - 1, low);
        break;
    case 'H':
    case 'f':
        e->y = emulator_clamp(one - 1, low);
        e->x = emulator_clamp((p[1] > 0 ? p[1] : 1) - 1, right);
        break;
    case 'J':
        if (p[0] == 0) {
            emulator_blank(e, e->x, e->y, e->width, e->y + 1);
            emulator_blank(e, 0, e->y + 1, e->width, e->height);
        } else if (p[0] == 1) {
            emulator_blank(e, 0, 0, e->width, e->y);
            emulator_blank(e, 0, e->y, e->x + 1, e->y + 1);
        } else {
            emulator_blank(e, 0, 0, e->width, e->height);
        }
        break;
    case 'K':
        emulator_blank(e, p[0] == 0 ? e->x : 0, e->y, p[0] == 1 ? e->x + 1 : e->width, e->y + 1);
        break;
    case 'X':
        emulator_blank(e, e->x, e->y, emulator_clamp(e->x + one, e->width), e->y + 1);
        break;
    case '@':
        emulator_shift(e, one);
        break;
    case 'P':
        emulator_shift(e, -one);
        break;
    case 'L':
        emulator_roll(e, e->y, e->bottom, -one);
        break;
    case 'M':
        emulator_roll(e, e->y, e->bottom, one);
        break;
    case 'S':
        emulator_roll(e, e->top, e->bottom, one);
        break;
    case 'T':
        emulator_roll(e, e->top, e->bottom, -one);
        break;
    case 'Z':
        e->x = emulator_clamp((e->x - 1) / 8 * 8, right);
        break;
    case 'b':
        for (int i = 0; i < one; i++) {
            emulator_put(e, e->last);
        }
        break;
    case 'r':
        e->top = emulator_clamp(one - 1, low);
        e->bottom = p[1] > 0 ? emulator_clamp(p[1] - 1, low) : low;
        e->x = e->y = 0;
        break;
    case 'm':
        emulator_colors(e, p, n);
        break;
    case 'n':
        e->questions += p[0] == 5;
        break;
    case 'h':
    case 'l':
    case 't':
        break;
    default:
        emulator_unknown(e);
    }
}

/* ESC and one or two more characters. True: complete. */
static inline bool emulator_escape(struct emulator *e)
{
    const char kind = e->sequence[1];
    const char final = e->sequence[e->len - 1];
    if (kind == '[') {
        if (e->len > 2 && final >= '@' && final <= '~') {
            emulator_control(e);
            return true;
        }
        return false;
    }
    if (kind == '(' || kind == ')') {
        return e->len == 3;
    }
    if (kind == ']') {
        return final == '\a' || (e->len > 2 && final == '\\' && e->sequence[e->len - 2] == '\033');
    }
    switch (kind) {
    case '7':
        e->saved_x = e->x;
        e->saved_y = e->y;
        break;
    case '8':
        e->x = e->saved_x;
        e->y = e->saved_y;
        e->wrap = false;
        break;
    case 'M':
        if (e->y == e->top) {
            emulator_roll(e, e->top, e->bottom, -1);
        } else if (e->y > 0) {
            e->y--;
        }
        break;
    case 'D':
        emulator_down(e);
        break;
    case 'E':
        e->x = 0;
        emulator_down(e);
        break;
    case '=':
    case '>':
    case 'H':
    case 'c':
        break;
    default:
        emulator_unknown(e);
    }
    return true;
}

static inline void emulator_feed(struct emulator *e, char c)
{
    if (e->len == 0 || e->sequence[0] != '\033') {
        switch (c) {
        case '\033':
            e->sequence[0] = c;
            e->len = 1;
            return;
        case '\r':
            e->x = 0;
            e->wrap = false;
            return;
        case '\n':
            emulator_down(e);
            e->wrap = false;
            return;
        case '\b':
            e->x = emulator_clamp(e->x - 1, e->width - 1);
            e->wrap = false;
            return;
        case '\t':
            e->x = emulator_clamp((e->x / 8 + 1) * 8, e->width - 1);
            return;
        case '\a':
        case '\016':
        case '\017':
        case '\0':
            return;
        default:
            break;
        }
    }
    if (c == '\033' && e->len > 1 && e->sequence[1] != ']') { /* a sequence that was cut off */
        e->len = 0;
    }
    if (e->len < sizeof e->sequence - 1) {
        e->sequence[e->len++] = c;
    }
    if (e->sequence[0] == '\033') {
        if (e->len >= 2 && emulator_escape(e)) {
            e->len = 0;
        }
        return;
    }
    const unsigned char first = (unsigned char)e->sequence[0];
    const size_t want = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    if (e->len >= want) {
        size_t used;
        emulator_put(e, text_codepoint((struct text){e->sequence, e->len}, &used));
        e->len = 0;
    }
}

/* A row as UTF-8 without blanks at its end. */
static inline void emulator_row(const struct emulator *e, int y, struct buffer *row)
{
    int end = e->width;
    while (end > 0 && e->cell[y * e->width + end - 1] == ' ') {
        end--;
    }
    for (int x = 0; x < end; x++) {
        if (e->cell[y * e->width + x]) {
            buffer_codepoint(row, e->cell[y * e->width + x]);
        }
    }
    buffer_put(row, TEXT(""));
}

/* All rows, a line each. */
static inline void emulator_text(const struct emulator *e, struct buffer *text)
{
    for (int y = 0; y < e->height; y++) {
        emulator_row(e, y, text);
        buffer_char(text, '\n');
    }
}
