/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A unit that is unknown is what the message names, wherever it is written in an expression. */
#include "unit/scene/names.h"
#include "unit/random_testing.h"

#include <hooke/scene/unit_word.h>

#include <stdio.h>
#include <string.h>

/* Lengths, of which one number has an unknown unit. */
struct writing {
    struct buffer text;
    int numbers, unknown; /* written so far; the one whose unit is unknown, counted from 0 */
    const char *word;
    size_t word_begin, word_end;
};

static int random_below(int n)
{
    return (int)(random_uniform() * n);
}

static void write_blank(struct writing *w)
{
    if (random_below(2))
        buffer_format(&w->text, " ");
}

static void write_number(struct writing *w)
{
    static const char *const units[] = {"m", "cm", "mm"};
    buffer_format(&w->text, "%.*f", random_below(3), 1 + 20 * random_uniform());
    write_blank(w);
    const bool unknown = w->numbers++ == w->unknown;
    w->word_begin = unknown ? w->text.len : w->word_begin;
    buffer_format(&w->text, "%s", unknown ? w->word : units[random_below(COUNT_OF(units))]);
    w->word_end = unknown ? w->text.len : w->word_end;
}

static void write_sum(struct writing *w, int depth);

/* Writes a length: a number with its unit, or what has the dimension of its only length. */
static void write_length(struct writing *w, int depth)
{
    const int kind = depth > 0 ? random_below(6) : 0;
    if (kind < 3) {
        write_number(w);
        return;
    }
    buffer_format(&w->text, "%s", kind == 3 ? "(" : kind == 4 ? "2*(" : "max(");
    write_sum(w, depth - 1);
    if (kind == 5) {
        buffer_format(&w->text, ",");
        write_blank(w);
        write_sum(w, depth - 1);
    }
    buffer_format(&w->text, kind == 3 ? ")/3" : ")");
}

static void write_sum(struct writing *w, int depth)
{
    const int terms = 1 + random_below(3);
    for (int i = 0; i < terms; i++) {
        if (i > 0) {
            write_blank(w);
            buffer_format(&w->text, random_below(2) ? "+" : "-");
            write_blank(w);
        }
        write_length(w, depth);
    }
}

/* Compiles it. What is read of it may end before the word, else the message names the word. */
static void check(const struct writing *w, int *named)
{
    struct arena arena = {0};
    struct error error = {0};
    char wanted[60];
    size_t used = 0;
    const struct text text = buffer_text(&w->text),
                      rest = {text.data + w->word_begin, text.len - w->word_begin};
    snprintf(wanted, sizeof wanted, "unknown unit '%s'", w->word);
    const bool read = expr_compile(text, &scope, &arena, &used, &error) != NULL;
    if (!text_is(unit_word(rest), w->word))
        fail_msg("'%s': the word is '%.*s'", text.data, (int)unit_word(rest).len, rest.data);
    if (read && strspn(text.data + used, " ") + used != w->word_begin)
        fail_msg("'%s' was read up to %zu", text.data, used);
    if (!read && (strcmp(error.text, wanted) != 0 || error.where.data != rest.data ||
                  error.where.len != strlen(w->word)))
        fail_msg("'%s' says '%s', wanted '%s'", text.data, error.text, wanted);
    *named += !read;
    arena_reset(&arena);
}

TEST(an_unknown_unit_is_named)
{
    static const char *const words[] = {"um", "UM", "yards", "km", "ft/s", "um^2", "inches"};
    enum { CASES = 3000 };
    int named = 0, written = 0;
    random_state = 30;
    for (int i = 0; i < CASES; i++) {
        struct writing w = {.unknown = random_below(4),
                            .word = words[random_below(COUNT_OF(words))]};
        write_sum(&w, 3);
        if (w.numbers > w.unknown) {
            check(&w, &named);
            written++;
        }
        buffer_free(&w.text);
    }
    print_message("%d expressions with an unknown unit, %d refused for it\n", written, named);
    assert_true(written > CASES / 2 && named > written / 2);
}

RUN_TESTS(NULL, NULL)
