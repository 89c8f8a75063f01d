/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The program's SVG pictures, read back: texts with the boxes they fill, paths as points. Included
 * after <cmocka.h>.
 */
#pragma once

#include "modules/pictures/surface/surface.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SVG_POINTS 200000

struct svg_path {
    double x[SVG_POINTS], y[SVG_POINTS];
    bool joined[SVG_POINTS]; /* by a line to the point before */
    int n, circles;          /* of a circle the point is its middle */
    bool closed;
};

struct svg_element {
    bool is_text, filled, turned;
    char stroke[8]; /* "#0072b2", or "" */
    double width;   /* of the line */
    double size;    /* of text */
    char text[400];
    double left, right, top, bottom; /* of text, from the widths of a font */
};

static inline const char *svg_attribute(const char *at, const char *end, const char *name)
{
    const char *value = strstr(at, name);
    return value && value < end ? value + strlen(name) : NULL;
}

static inline double svg_number(const char *at, const char *end, const char *name, double absent)
{
    const char *value = svg_attribute(at, end, name);
    return value ? strtod(value, NULL) : absent;
}

static inline void svg_read_path(const char *d, struct svg_path *path)
{
    double x = 0, y = 0, number[7];
    char command = 0;
    path->n = path->circles = 0;
    path->closed = false;
    for (char *at = (char *)(uintptr_t)d; *at != '"';) {
        if (strchr("Mlhaz", *at)) {
            command = *at++;
            path->closed |= command == 'z';
            continue;
        }
        if (*at == ' ') {
            at++;
            continue;
        }
        const int want = command == 'a' ? 7 : command == 'h' ? 1 : 2;
        for (int i = 0; i < want; i++) {
            char *after;
            number[i] = strtod(at, &after);
            assert_true(after > at);
            at = after;
        }
        if (command == 'a') { /* two halves: the first goes to the right end */
            if (number[5] > 0) {
                path->x[path->n - 1] = x + number[5] / 2;
                path->circles++;
            }
            continue;
        }
        x = number[0] + (command != 'M' ? x : 0);
        y = command == 'h' ? y : number[1] + (command != 'M' ? y : 0);
        assert_true(path->n < SVG_POINTS);
        path->x[path->n] = x;
        path->y[path->n] = y;
        path->joined[path->n++] = command != 'M';
    }
}

static inline void svg_read_text(const char *at, const char *end, double usual,
                                 struct svg_element *out)
{
    static const struct {
        const char *name;
        char c;
    } entities[] = {{"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}};
    const char *anchor = svg_attribute(at, end, "text-anchor=\"");
    const double align = !anchor ? 0 : *anchor == 'm' ? 0.5 : 1;
    const double x = svg_number(at, end, " x=\"", NAN), y = svg_number(at, end, " y=\"", NAN);
    size_t n = 0;
    for (const char *from = end + 1; *from != '<'; n++) {
        assert_true(n < sizeof out->text - 1);
        out->text[n] = *from;
        size_t used = 1;
        for (size_t i = 0; i < COUNT_OF(entities); i++)
            if (strncmp(from, entities[i].name, strlen(entities[i].name)) == 0) {
                out->text[n] = entities[i].c;
                used = strlen(entities[i].name);
            }
        from += used;
    }
    out->text[n] = '\0';
    out->size = svg_number(at, end, "font-size=\"", usual);
    out->turned = svg_attribute(at, end, "rotate(-90") != NULL;
    const double width = out->size * text_advance(text_of(out->text)), before = align * width,
                 ascent = 0.76 * out->size, descent = 0.2 * out->size;
    out->left = out->turned ? x - ascent : x - before;
    out->right = out->turned ? x + descent : x - before + width;
    out->top = out->turned ? y + before - width : y - ascent;
    out->bottom = out->turned ? y + before : y + descent;
}

/* The value of a number as it is printed: "−2.5", "10⁻³", "2×10⁵". */
static inline double svg_value(const char *text)
{
    static const char *const superscript[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    const bool minus = strncmp(text, "−", strlen("−")) == 0;
    char *at;
    double value = strtod(text + (minus ? strlen("−") : 0), &at);
    if (strncmp(at, "×10", strlen("×10")) == 0)
        at += strlen("×10");
    else if (value == 10)
        value = 1;
    else
        return minus ? -value : value;
    const bool small = strncmp(at, "⁻", strlen("⁻")) == 0;
    const char *digits = at + (small ? strlen("⁻") : 0);
    int power = 0;
    bool any = false;
    for (int d = 0; d < 10; d++)
        if (strncmp(digits, superscript[d], strlen(superscript[d])) == 0) {
            power = 10 * power + d;
            digits += strlen(superscript[d]);
            any = true;
            d = -1;
        }
    return (minus ? -1 : 1) * (any ? value * pow(10, small ? -power : power) : 10);
}

/* The next text or path, and of a path its points; false at the end. */
static inline bool svg_next(const char *svg, const char **at, struct svg_element *out,
                            struct svg_path *path)
{
    for (*at = *at ? *at + 1 : svg; (*at = strchr(*at, '<')); ++*at) {
        const char *end = strchr(*at, '>'), *stroke = svg_attribute(*at, end, "stroke=\"");
        *out = (struct svg_element){.is_text = strncmp(*at, "<text", 5) == 0};
        if (!out->is_text && strncmp(*at, "<path", 5) != 0)
            continue;
        out->filled = !out->is_text && svg_attribute(*at, end, " fill=\"") != NULL;
        out->width = svg_number(*at, end, "stroke-width=\"", 0);
        if (stroke)
            snprintf(out->stroke, sizeof out->stroke, "%.7s", stroke);
        if (out->is_text)
            svg_read_text(*at, end, svg_number(svg, strchr(svg, '>'), "font-size=\"", NAN), out);
        else
            svg_read_path(svg_attribute(*at, end, " d=\""), path);
        return true;
    }
    return false;
}
