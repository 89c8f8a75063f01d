/* SPDX-License-Identifier: GPL-3.0-or-later */
/* event_compile(): an event from its text, EXPR [rising|falling|touching] or a comparison. */
#include <hooke/scene/formula.h>
#include "run/private.h"

/* Returns the position of the first character from `position` on that is not a blank. */
static size_t blanks(struct text text, size_t position)
{
    while (position < text.len && (text.data[position] == ' ' || text.data[position] == '\t'))
        position++;
    return position;
}

/* Compiles the expression at text[*position], and moves *position behind it and the blanks that
 * follow. Returns NULL, with an error, if there is none. */
static const struct expr *event_side_compile(struct text text, size_t *position,
                                             const struct expr_scope *scope, struct arena *arena,
                                             struct error *error)
{
    size_t used;
    const struct expr *expr = expr_compile(text_after(text, *position), scope, arena, &used, error);
    *position = expr ? blanks(text, *position + used) : *position;
    return expr;
}

/* Returns true if `word` stands at text[*position], and moves *position behind it. */
static bool take_word(struct text text, size_t *position, struct text word)
{
    const struct text rest = text_after(text, *position);
    if (!text_starts(rest, word) ||
        (rest.len > word.len && rest.data[word.len] != ' ' && rest.data[word.len] != '\t'))
        return false;
    *position += word.len;
    return true;
}

/* Reads an expression, perhaps a comparison with another one, then rising, falling or touching. */
bool event_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                   struct event *event, size_t *used, struct error *error)
{
    size_t position = 0;
    struct event made = {.left = event_side_compile(text, &position, scope, arena, error),
                         .scope = scope};
    if (!made.left)
        return false;
    if (position < text.len && (text.data[position] == '<' || text.data[position] == '>')) {
        made.direction = text.data[position] == '<' ? -1 : 1;
        position++;
        position += position < text.len && text.data[position] == '=';
        made.right = event_side_compile(text, &position, scope, arena, error);
        if (!made.right || !expr_compare(made.left, &made.right, arena, error))
            return false;
    }
    const size_t word = position;
    int direction;
    if (take_word(text, &position, TEXT("rising")))
        direction = 1;
    else
        direction = take_word(text, &position, TEXT("falling")) ? -1 : 0;
    made.touching = direction == 0 && take_word(text, &position, TEXT("touching"));
    if ((direction != 0 || made.touching) && made.right)
        return error_at(error, (struct text){text.data + word, position - word},
                        "an event with < or > happens when the comparison becomes true; rising, "
                        "falling and touching need an expression without < and >");
    made.direction = direction != 0 ? direction : made.direction;
    memcpy(made.name, event->name, sizeof made.name);
    made.stop = event->stop;
    *event = made;
    *used = position;
    return true;
}
