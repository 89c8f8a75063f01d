/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes values with units, for people with few digits and for commands exactly, and quotes words
 * so that commands read them back. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

#include <math.h>
#include <string.h>

/* Returns the unit in which a value is readable. Times from 0.1 s on stay in seconds, because the
 * students' worksheet asks for 0.7226 s and not 722.6 ms. */
static const struct unit *unit_for(enum quantity quantity, double value)
{
    return unit_display(quantity, quantity == QUANTITY_TIME && fabs(value) >= 0.1 ? 1 : value);
}

/* Appends a value with its uncertainty and unit, rounded to `digits` digits. */
void buffer_measured(struct buffer *buffer, struct measured value, enum quantity quantity,
                     int digits)
{
    const struct unit *unit = unit_for(quantity, value.value);
    const double factor = unit ? unit->factor : 1, shown = value.value / factor + 0.0; /* no -0 */
    /* An uncertainty below the digits shown (rounding of a simulation) is left out. */
    if (value.uncertainty > 0 && value.uncertainty > pow(10, -digits) * fabs(value.value))
        buffer_uncertain(buffer, shown, value.uncertainty / factor);
    else
        buffer_short(buffer, shown, digits);
    const char *name = unit ? unit->row.name : quantity_unit(quantity);
    if (*name)
        buffer_format(buffer, " %s", name);
}

/* Returns a buffer on the memory of a value_text, which is large enough for every value, so that it
 * never grows. */
static struct buffer fixed_buffer(struct value_text *text)
{
    return (struct buffer){.data = text->data, .cap = sizeof text->data};
}

/* Writes a number with `digits` significant digits into *text. Returns text->data. */
const char *value_text_short(struct value_text *text, double value, int digits)
{
    struct buffer output = fixed_buffer(text);
    buffer_short(&output, value, digits);
    return text->data;
}

/* Does the same in the unit in which this quantity is shown, and appends the unit. */
const char *value_text_quantity(struct value_text *text, double value, enum quantity quantity,
                                int digits)
{
    struct buffer output = fixed_buffer(text);
    buffer_quantity(&output, value, quantity, digits);
    return text->data;
}

/* Does the same for a value with its uncertainty. */
const char *value_text_measured(struct value_text *text, struct measured value,
                                enum quantity quantity, int digits)
{
    struct buffer output = fixed_buffer(text);
    buffer_measured(&output, value, quantity, digits);
    return text->data;
}

const char *plural_s(int64_t count)
{
    return count == 1 ? "" : "s";
}

/* Appends a value so that a command reads the same double and uncertainty. */
void buffer_exact(struct buffer *buffer, struct measured value, enum quantity quantity)
{
    if (value.uncertainty > 0) {
        buffer_real(buffer, value.value);
        buffer_put(buffer, TEXT(" +- "));
        buffer_real(buffer, value.uncertainty);
        if (*quantity_unit(quantity))
            buffer_format(buffer, " %s", quantity_unit(quantity));
    } else {
        buffer_quantity(buffer, value.value, quantity, 0);
    }
}

/* Appends a word so that a statement reads it back: unquoted if it has no special characters, else
 * in '...' or, if it contains ' or a line end, in "..." with escapes. */
void buffer_word(struct buffer *buffer, struct text word)
{
    bool plain = word.len > 0 && word.data[0] != '#';
    bool raw = true;
    for (size_t i = 0; i < word.len; i++) {
        plain &= !strchr(" \t\r\n;'\"\\,=>", word.data[i]);
        raw &= word.data[i] != '\'' && word.data[i] != '\n';
    }
    if (plain) {
        buffer_put(buffer, word);
    } else if (raw) {
        buffer_format(buffer, "'%.*s'", (int)word.len, word.data);
    } else {
        buffer_char(buffer, '"');
        for (size_t i = 0; i < word.len; i++) {
            if (word.data[i] == '\n') {
                buffer_put(buffer, TEXT("\\n"));
                continue;
            }
            if (strchr("\"\\", word.data[i]))
                buffer_char(buffer, '\\');
            buffer_char(buffer, word.data[i]);
        }
        buffer_char(buffer, '"');
    }
}
