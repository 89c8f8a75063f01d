/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names and units of columns from header lines: "Time (s)", "y [cm]", "Weg / mm", "Position (m) Run
 * #1", "elapsed_ms", or units on a line of their own. An unknown unit is kept and shown, and the
 * numbers are taken unchanged. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include "modules/recording/table/table.h"

#include <string.h>
#include <strings.h>

static bool is_header_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (unsigned char)c >= 0x80;
}

static bool is_same_word(struct text a, struct text b)
{
    return a.len == b.len && (a.len == 0 || strncasecmp(a.data, b.data, a.len) == 0);
}

/* Returns true if the word is one of the blank-separated words, in any case. */
static bool is_listed_word(struct text word, const char *words)
{
    struct text rest = text_of(words), one;
    while (text_split(&rest, ' ', &one))
        if (is_same_word(word, one))
            return true;
    return false;
}

/* Returns true if the name, or a word in it, is in the list `words`, separated by blanks. */
bool name_has_word(const char *name, const char *words)
{
    if (is_listed_word(text_of(name), words))
        return true;
    for (const char *cursor = name; *cursor;) {
        size_t len = 0;
        while (is_header_letter(cursor[len]))
            len++;
        if (len > 0 && is_listed_word((struct text){cursor, len}, words))
            return true;
        cursor += len ? len : 1;
    }
    return false;
}

/* Splits the next field off a line of the header. A unit in brackets or after '/' is joined to the
 * name before it if blanks separate the fields. Returns false at the end. */
bool header_field(struct text *rest, char separator, struct text *field)
{
    if (!table_field(rest, separator, field))
        return false;
    /* If blanks separate the fields, "Time (s)" was cut in two, but "[s] [cm]" are two units. */
    struct text ahead = separator == ' ' && !(field->len > 0 && strchr("([", field->data[0]))
                            ? *rest
                            : (struct text){NULL, 0},
                next;
    const char *start = field->data;
    while (table_field(&ahead, separator, &next) && strchr("([/", next.data[0])) {
        const char closing = next.data[0] == '(' ? ')' : ']';
        const bool open =
            next.data[0] == '/' ? next.len == 1 : !memchr(next.data, closing, next.len);
        if (open && !table_field(&ahead, separator, &next))
            break;
        *field = (struct text){start, (size_t)(next.data + next.len - start)};
        *rest = ahead;
    }
    return true;
}

/* Units as instruments spell them, the unit of the table, and the factor that leads to it. */
static const struct {
    const char *spelled, *unit;
    double factor;
} spellings[] = {
    {"sec secs second seconds Sekunden Sekunde", "s", 1},
    {"msec millis millisecond milliseconds", "ms", 1},
    {"us µs μs micros usec microsecond microseconds", "s", 1e-6},
    {"minute minutes", "min", 1},
    {"h hour hours", "min", 60},
    {"um µm μm micrometer micrometers micrometre micrometres micron microns", "m", 1e-6},
    {"in inch inches", "m", 0.0254},
    {"ft foot feet", "m", 0.3048},
    {"meter meters metre metres metri", "m", 1},
    {"centimeter centimeters centimetre centimetres", "cm", 1},
    {"millimeter millimeters millimetre millimetres", "mm", 1},
    {"° degree degrees grad", "deg", 1},
    {"radian radians", "rad", 1},
    {"m/s² m/s2 m/s/s m/s^2", "m/s^2", 1},
    {"cm/s² cm/s2 cm/s/s cm/s^2", "m/s^2", 1e-2},
    {"mm/s² mm/s2 mm/s^2", "m/s^2", 1e-3},
    {"m/sec", "m/s", 1},
    {"cm/sec", "cm/s", 1},
    {"°/s deg/s", "rad/s", 0.017453292519943295},
    {"rad/sec", "rad/s", 1},
    {"newton newtons", "N", 1},
    {"volt volts", "V", 1},
    {"millivolt millivolts", "mV", 1},
    {"uV µV μV microvolt microvolts", "V", 1e-6},
};

/* Returns the unit in any spelling, or NULL if it is unknown. Sets *factor to the factor to SI. */
static const struct unit *find_unit(struct text text, double *factor)
{
    const struct unit *unit = unit_find(text);
    *factor = 1;
    for (size_t i = 0; i < COUNT_OF(spellings) && !unit; i++)
        if (is_listed_word(text, spellings[i].spelled)) {
            unit = unit_find(text_of(spellings[i].unit));
            *factor = spellings[i].factor;
        }
    *factor *= unit ? unit->factor : 1;
    return unit;
}

/* Sets *unit to a copy, in the arena, of the unit that the text names, spelled as in the file; NULL
 * if it is unknown. Returns false if out of memory. */
bool unit_spelled(struct text text, struct arena *arena, const struct unit **unit)
{
    double factor;
    const struct unit *known = find_unit(text, &factor);
    struct unit *copy = known ? arena_alloc(arena, sizeof *copy) : NULL;
    *unit = copy;
    if (!copy)
        return known == NULL;
    *copy = *known;
    copy->row.name = arena_text(arena, text);
    copy->factor = factor;
    copy->use = UNIT_READ;
    return copy->row.name != NULL;
}

/* Returns true for "in", which is an inch only in brackets: V_in is an input. */
static bool is_word_in(struct text text)
{
    return is_same_word(text, TEXT("in"));
}

/* Sets unit, quantity and factor to SI of a column; an unknown unit is stored as it is spelled. An
 * accelerometer's g is not taken for grams. */
void column_unit(struct column *column, struct text unit)
{
    double factor;
    const struct unit *known = find_unit(unit, &factor);
    size_t len = text_fitting(unit, sizeof column->unit - 1);
    memcpy(column->unit, unit.data, len);
    column->unit[len] = '\0';
    /* An accelerometer's g is no gram. */
    if (known && known->quantity == QUANTITY_MASS &&
        !name_has_word(column->name, "mass m masa masse massa weight"))
        known = NULL;
    column->quantity = known ? known->quantity : QUANTITY_OTHER;
    column->factor = known ? factor : 1;
}

/* Reads a number that is followed by a known unit, as in "5 cm". Returns false if the field is
 * anything else. */
bool number_with_unit(struct text field, char decimal, double *value, struct text *unit)
{
    enum { SPELLED_MAX = 16 };
    double number, factor;
    size_t used = 0;
    const enum real_status status = real_scan(field, decimal, &number, &used);
    if ((status != REAL_OK && status != REAL_UNDERFLOW) || used == 0 || used == field.len)
        return false;
    *unit = text_trim(text_after(field, used));
    if (unit->len == 0 || unit->len > SPELLED_MAX || !find_unit(*unit, &factor))
        return false;
    *value = number;
    return true;
}

/* Sets output to the text as UTF-8 that is safe to show; bytes that are not UTF-8 are taken for
 * Latin-1 (m/s², °C). Returns false if out of memory. */
static bool text_clean(struct text text, struct buffer *output)
{
    struct buffer utf8 = {0};
    for (size_t used; text.len > 0; text.data += used, text.len -= used) {
        uint32_t codepoint = text_codepoint(text, &used);
        unsigned char byte = (unsigned char)text.data[0];
        if (codepoint == CODEPOINT_INVALID && used == 1 && byte >= 0xA0)
            buffer_codepoint(&utf8, byte);
        else
            buffer_put(&utf8, (struct text){text.data, used});
    }
    buffer_clear(output);
    safe_text(output, buffer_text(&utf8), false);
    output->failed |= utf8.failed;
    buffer_free(&utf8);
    return !output->failed;
}

/* Finds the unit in the last brackets of a name, the text before (stem) and after it (suffix).
 * Returns false if there is none that can be a unit. */
static bool find_bracket(struct text text, struct text *stem, struct text *unit,
                         struct text *suffix)
{
    for (size_t close = text.len; close-- > 1;) {
        if (text.data[close] != ')' && text.data[close] != ']')
            continue;
        const char open = text.data[close] == ')' ? '(' : '[';
        for (size_t index = close; index-- > 0;)
            if (text.data[index] == open) {
                *unit = text_trim((struct text){text.data + index + 1, close - index - 1});
                *stem = text_trim((struct text){text.data, index});
                *suffix = text_trim(text_after(text, close + 1));
                return unit->len > 0 && unit->len < 16 && !memchr(unit->data, ' ', unit->len);
            }
    }
    return false;
}

/* Finds the unit after "in" or a comma, as in "Weg in cm" or "Zeit, s", and the text before it
 * (stem). Returns false if there is none. */
static bool find_spoken(struct text text, struct text *stem, struct text *unit)
{
    double factor;
    for (size_t index = text.len; index-- > 0;) {
        const struct text rest = {text.data + index, text.len - index};
        const bool starts_with_in =
            text_starts(rest, TEXT("in ")) && (index == 0 || text.data[index - 1] == ' ');
        if (!starts_with_in && (!text_starts(rest, TEXT(", ")) || index == 0))
            continue;
        *stem = text_trim((struct text){text.data, index});
        const size_t skipped = starts_with_in ? 3 : 2;
        *unit = text_trim(text_after(rest, skipped));
        return unit->len > 0 && !is_word_in(*unit) && find_unit(*unit, &factor);
    }
    return false;
}

/* Finds the unit after '_' or '/', as in "elapsed_ms", "Weg / mm", "v/m/s", and the text before it
 * (stem). Returns false if there is none. */
static bool find_tail(struct text text, struct text *stem, struct text *unit)
{
    double factor;
    for (size_t index = text.len; index-- > 1;) {
        if (text.data[index] != '_' && text.data[index] != '/')
            continue;
        *stem = text_trim((struct text){text.data, index});
        *unit = text_trim(text_after(text, index + 1));
        if (stem->len > 0 && unit->len > 0 && !is_word_in(*unit) && find_unit(*unit, &factor) &&
            (text.data[index] == '_' || text.data[index - 1] == ' '))
            return true;
        if (text.data[index] == '_')
            break;
    }
    /* "v/m/s" is the form of ISO 80000-1, but the unit "m/s" alone is not; "s/mm" is a path s in
     * mm, as no unit is a time by a length. */
    *unit = text;
    if (!text_split(unit, '/', stem) || stem->len == 0)
        return false;
    const struct unit *known_unit = find_unit(*unit, &factor);
    return known_unit &&
           (!unit_find(*stem) || (text_is(*stem, "s") && known_unit->quantity == QUANTITY_LENGTH));
}

/* Returns true for a name that is a unit, such as "ms" or "cm". A single letter (s, m, g) may be a
 * quantity's symbol and does not count. */
static bool is_unit_name(struct text name)
{
    double factor;
    const struct unit *unit = name.len >= 2 && !is_word_in(name) ? find_unit(name, &factor) : NULL;
    return unit && (unit->quantity == QUANTITY_TIME || unit->quantity == QUANTITY_LENGTH ||
                    unit->quantity == QUANTITY_ANGLE);
}

/* Returns true if all names are units, single letters included, as in "s cm". */
static bool all_unit_names(const struct table_layout *layout)
{
    struct text names = layout->names, name;
    double factor;
    int units = 0, long_units = 0;
    while (header_field(&names, layout->name_separator, &name) && name.len > 0) {
        if (!find_unit(name, &factor))
            return false;
        long_units += is_unit_name(name);
        units++;
    }
    return units >= 2 && long_units > 0;
}

/* Sets the column's name to stem and suffix. */
static void set_name(struct column *column, struct text stem, struct text suffix)
{
    const struct text parts[] = {stem, stem.len && suffix.len ? TEXT(" ") : TEXT(""), suffix};
    size_t len = 0;
    for (size_t i = 0; i < COUNT_OF(parts); i++) {
        size_t fits = text_fitting(parts[i], LIMIT_NAME - len);
        memcpy(column->name + len, parts[i].data, fits);
        len += fits;
    }
    column->name[len] = '\0';
}

/* Sets name and unit of a column from its header field and, if not empty, its field in the line of
 * units. `units` tells that all names are units. Returns false if out of memory. */
static bool name_column(struct column *column, struct text field, struct text unit_field,
                        bool units, struct buffer *scratch)
{
    struct text stem, unit, suffix = TEXT(""), none = TEXT("");
    if (!text_clean(field, scratch))
        return false;
    struct text whole = buffer_text(scratch);
    double factor;
    bool has_unit = find_bracket(whole, &stem, &unit, &suffix) || find_tail(whole, &stem, &unit) ||
                    find_spoken(whole, &stem, &unit);
    /* If units have a line of their own, brackets in the name may hold something else. */
    has_unit = has_unit && (unit_field.len == 0 || find_unit(unit, &factor));
    if (has_unit && stem.len + suffix.len == 0) {
        stem = unit; /* a name that is only "(s)" is kept as the name */
        suffix = none;
    }
    if (!has_unit && unit_field.len == 0 && (units || is_unit_name(whole))) {
        stem = unit = whole; /* a name that is a unit is one */
        suffix = none;
        has_unit = true;
    }
    if (!has_unit) {
        stem = whole;
        suffix = unit = none;
    }
    set_name(column, stem, suffix);
    column_unit(column, unit);
    if (unit_field.len == 0)
        return true;
    if (!text_clean(unit_field, scratch))
        return false;
    unit = buffer_text(scratch);
    if (find_bracket(unit, &stem, &suffix, &whole))
        unit = suffix;
    column_unit(column, unit);
    return true;
}

/* Allocates the recording's columns and names them by the fields of the header, as far as these
 * reach. Returns false with the error if out of memory. */
bool table_columns(const struct table_layout *layout, struct recording *recording,
                   struct error *error)
{
    struct text names = layout->names, units = layout->units, name, unit;
    struct buffer scratch = {0};
    const bool all_units = units.len == 0 && all_unit_names(layout);
    bool done = true;
    recording->columns = layout->columns;
    recording->column =
        arena_array(&recording->arena, (size_t)layout->columns, sizeof *recording->column);
    for (int i = 0; i < recording->columns && recording->column && done; i++) {
        struct column *column = &recording->column[i];
        if (!header_field(&names, layout->name_separator, &name))
            name = TEXT("");
        if (!header_field(&units, layout->name_separator, &unit))
            unit = TEXT("");
        column->run = -1;
        done = name_column(column, name, unit, all_units, &scratch);
    }
    buffer_free(&scratch);
    return (done && recording->column) || error_memory(error);
}
