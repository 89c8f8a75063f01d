/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Words that follow a number in the place of a unit but are not units: which word that is, and the
 * error with advice. */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/unit_word.h>

#include <string.h>

/* Returns the word as far as it could be a unit, with / and ^ inside. */
struct text unit_word(struct text text)
{
    struct text word = peek_word(text, "+-*()<>=,:");
    for (size_t i = 0; i + 1 < word.len; i++) {
        const char next = word.data[i + 1];
        const bool digit = next >= '0' && next <= '9';
        if ((word.data[i] == '/' && !is_name_start(next)) || (word.data[i] == '^' && !digit))
            word.len = i;
    }
    if (word.len > 0 && strchr("/^", word.data[word.len - 1]))
        word.len--;
    return word;
}

/* Returns the unit that the word spells out or shortens in another way, as grams and sec do; NULL
 * if there is none. */
static const struct unit *spelled_unit(struct text word)
{
    const size_t len = word.len - (word.len > 3 && word.data[word.len - 1] == 's');
    for (size_t i = 0; i < unit_catalog.count; i++) {
        const struct row *row = catalog_row(&unit_catalog, i);
        if (len >= 3 && !strchr(row->brief, ' ') &&
            text_starts(text_of(row->brief), (struct text){word.data, len}))
            return unit_from(row);
    }
    return NULL;
}

/* Returns true if the word begins with a name, function or pi that could be a factor, as in 2pi. */
static bool is_factor(const struct expr_scope *scope, struct text word)
{
    const struct text name = peek_name(word);
    int slot;
    return text_is(name, "pi") || catalog_find(&function_catalog, name) ||
           (scope && scope->find(scope->context, name, &slot));
}

/* Sets the error for a word that is not a unit here, with the likeliest correction as a hint. */
bool refuse_unit_word(const struct expr_scope *scope, struct text word, struct text number,
                      enum quantity quantity, struct error *error)
{
    const struct unit *spelled = spelled_unit(word), *known = unit_match(word);
    const bool factor = is_factor(scope, word);
    const int shown = (int)(number.len < 80 ? number.len : 80), length = (int)word.len;
    if (known && word.len == strlen(known->row.name)) {
        error_at(error, word, "a number without a unit is needed here; '%.*s' is a unit (%s)",
                 length, word.data, quantity_name(known->quantity));
        return known->quantity == QUANTITY_TIME &&
               error_hint(error, "'run %.*s %.*s' runs for that long", shown, number.data, length,
                          word.data);
    }
    catalog_unknown(&unit_catalog, word, error);
    if (spelled || factor)
        error->hint[0] = '\0';
    if (spelled)
        error_hint(error, "write %.*s %s", shown, number.data, spelled->row.name);
    else if (factor)
        error_hint(error, "write products with *: %.*s*%.*s", shown, number.data, length,
                   word.data);
    struct buffer units = {0};
    quantity_units(quantity, &units);
    const enum hint_kind previous_kind = error->hint_kind;
    if (units.len > 0)
        error_hint(error, "units of %s are %s", quantity_name(quantity), buffer_view(&units));
    error->hint_kind = previous_kind == HINT_NONE ? HINT_LIST : previous_kind;
    buffer_free(&units);
    return false;
}
