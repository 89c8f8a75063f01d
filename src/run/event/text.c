/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events from text. */
#include <hooke/scene/formula.h>
#include "run/private.h"

static size_t blanks(struct text text, size_t at)
{
    while (at < text.len && (text.at[at] == ' ' || text.at[at] == '\t'))
        at++;
    return at;
}

static struct text from(struct text text, size_t at)
{
    return (struct text){text.at + at, text.len - at};
}

/* An expression at text[*at]. */
static const struct expr *side(struct text text, size_t *at, const struct expr_scope *scope,
                               struct arena *arena, struct error *error)
{
    size_t used;
    const struct expr *expr = expr_compile(from(text, *at), scope, arena, &used, error);
    *at = expr ? blanks(text, *at + used) : *at;
    return expr;
}

/* The word at text[*at], if it is there. */
static bool take_word(struct text text, size_t *at, struct text word)
{
    const struct text rest = from(text, *at);
    if (!text_starts(rest, word) ||
        (rest.len > word.len && rest.at[word.len] != ' ' && rest.at[word.len] != '\t'))
        return false;
    *at += word.len;
    return true;
}

bool event_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                   struct event *event, size_t *used, struct error *error)
{
    size_t at = 0;
    struct event made = {.left = side(text, &at, scope, arena, error), .scope = scope};
    if (!made.left)
        return false;
    if (at < text.len && (text.at[at] == '<' || text.at[at] == '>')) {
        made.direction = text.at[at] == '<' ? -1 : 1;
        at++;
        at += at < text.len && text.at[at] == '=';
        made.right = side(text, &at, scope, arena, error);
        if (!made.right || !expr_compare(made.left, &made.right, arena, error))
            return false;
    }
    const size_t word = at;
    const int direction = take_word(text, &at, TEXT("rising"))    ? 1
                          : take_word(text, &at, TEXT("falling")) ? -1
                                                                  : 0;
    made.touching = direction == 0 && take_word(text, &at, TEXT("touching"));
    if ((direction != 0 || made.touching) && made.right)
        return error_at(error, (struct text){text.at + word, at - word},
                        "a comparison happens where it becomes true; rising, falling and touching "
                        "are for expressions");
    made.direction = direction != 0 ? direction : made.direction;
    memcpy(made.name, event->name, sizeof made.name);
    made.stop = event->stop;
    *event = made;
    *used = at;
    return true;
}
