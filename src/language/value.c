/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads values with units and uncertainties, ranges, whole numbers and sizes of pictures, and
 * explains what is wrong if they are malformed. */
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/figure.h>
#include <hooke/language.h>
#include <hooke/scene/dimension.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/unit_word.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Removes the first `count` characters of a text. */
static void text_skip(struct text *text, size_t count)
{
    *text = (struct text){text->data + count, text->len - count};
}

/* Returns the text from begin to end, without outer blanks. */
static struct text text_between(const char *begin, const char *end)
{
    struct text text = {begin, (size_t)(end - begin)};
    return text_trim(text);
}

/* Returns the number of bytes of a text that a message quotes. */
static int shown_length(struct text text)
{
    return (int)(text.len < 80 ? text.len : 80);
}

/* Returns true if the text begins with "+-" or its Unicode sign. */
static bool starts_uncertainty(struct text text)
{
    return text_starts(text, TEXT("+-")) || text_starts(text, TEXT("\u00b1"));
}

/* Returns the text up to the first option (a blank, "--" and a name), or all of it. */
struct text before_option(struct text text)
{
    for (size_t i = 1; i + 2 < text.len; i++)
        if (strchr(" \t", text.data[i - 1]) && text_starts(text_after(text, i), TEXT("--")) &&
            (is_name_start(text.data[i + 2]) || strchr(" \t", text.data[i + 2])))
            return (struct text){text.data, i};
    return text;
}

/* One side of VALUE +- UNCERTAINTY, as it was typed. */
struct number_part {
    double number; /* SI value, or the typed value if it has no unit */
    struct dimension dimension;
    const struct expr *expr;
    /* uncertainty of the last digits, such as 0.1 of 200.0(1); in the same unit */
    double last_digits;
};

/* Takes the uncertainty in parentheses directly behind a typed number off the text and returns it:
 * 200.0(1) is 200.0 +- 0.1. Returns 0, and takes nothing, if none follows. */
static double take_last_digits(struct text typed, struct text *rest)
{
    size_t end = 1, decimals = 0, i = typed.len;
    double digits = 0, unit = 1;
    while (i > 0 && typed.data[i - 1] >= '0' && typed.data[i - 1] <= '9')
        i--;
    if (i > 0 && typed.data[i - 1] == '.')
        decimals = typed.len - i;
    if (typed.len == 0 || rest->len < 3 || rest->data[0] != '(' ||
        strspn(typed.data, "0123456789.+-") < typed.len)
        return 0;
    while (end < rest->len && end < 10 && rest->data[end] >= '0' && rest->data[end] <= '9')
        digits = 10 * digits + (rest->data[end++] - '0');
    if (end == 1 || end >= rest->len || rest->data[end] != ')')
        return 0;
    text_skip(rest, end + 1);
    while (decimals-- > 0)
        unit *= 10;
    return digits / unit;
}

/* Takes the power of ten behind an uncertainty in parentheses off the text, as in 1.50(2)e-3, and
 * multiplies the number and its uncertainty by it. Takes nothing if none follows. */
static void take_exponent(struct text typed, struct number_part *part, struct text *rest)
{
    size_t end = 1, used;
    char whole[LIMIT_NAME + 16];
    double power;
    if (rest->len < 2 || (rest->data[0] != 'e' && rest->data[0] != 'E') || typed.len > LIMIT_NAME)
        return;
    end += strchr("+-", rest->data[1]) != NULL;
    const size_t first = end;
    while (end < rest->len && end < 8 && rest->data[end] >= '0' && rest->data[end] <= '9')
        end++;
    snprintf(whole, sizeof whole, "%.*s%.*s", (int)typed.len, typed.data, (int)end, rest->data);
    if (end == first || real_scan(text_of(whole), '.', &part->number, &used) != REAL_OK)
        return;
    snprintf(whole, sizeof whole, "1%.*s", (int)end, rest->data);
    if (real_scan(text_of(whole), '.', &power, &used) == REAL_OK)
        part->last_digits *= power;
    text_skip(rest, end);
}

/* Takes the unit behind an uncertainty in parentheses, as in 200.0(1) g, and converts the number
 * and its uncertainty to SI units. Takes nothing if none follows. */
static void take_unit(struct parser *parser, struct number_part *part)
{
    struct text following = parser->rest;
    text_skip_blanks(&following);
    const struct unit *unit = unit_match(following);
    if (!unit)
        return;
    parser->rest = following;
    text_skip(&parser->rest, strlen(unit->row.name));
    part->dimension = dimension_of_unit(unit);
    unit_convert(unit, unit->quantity, part->number, &part->number);
    unit_convert(unit, unit->quantity, part->last_digits, &part->last_digits);
}

/* Reads an expression with its unit, and digits of uncertainty in parentheses. Returns false with
 * an error if the expression does not compile. */
static bool parse_number_part(struct parser *parser, struct number_part *part, struct error *error)
{
    size_t used;
    text_skip_blanks(&parser->rest);
    const struct text start = parser->rest;
    part->expr = expr_compile(before_option(start), parser->scope, parser->arena, &used, error);
    if (!part->expr)
        return names_explain(parser->session, error);
    /* The compiler also consumed the blanks behind the expression. */
    while (used > 0 && strchr(" \t", start.data[used - 1]))
        used--;
    part->number = expr_value(part->expr, parser->scope);
    part->dimension = *expr_dimension(part->expr);
    text_skip(&parser->rest, used);
    part->last_digits = take_last_digits((struct text){start.data, used}, &parser->rest);
    if (part->last_digits > 0) {
        take_exponent((struct text){start.data, used}, part, &parser->rest);
        take_unit(parser, part);
    }
    return true;
}

/* Fills `error` if a value has another quantity (`is`) than the argument needs. Returns false. */
static bool report_wrong_quantity(const char *what, enum quantity wanted,
                                  const struct dimension *is, struct text typed,
                                  struct error *error)
{
    struct buffer units = {0}, name = {0};
    dimension_put(is, &name);
    quantity_units(wanted, &units);
    if (wanted == QUANTITY_NUMBER)
        error_at(error, typed, "%s needs a pure number, got '%.*s' (%s)", what, shown_length(typed),
                 typed.data, buffer_view(&name));
    else
        error_at(error, typed, "%s needs %s %s (%s), got '%.*s' (%s)", what,
                 quantity_article(wanted), quantity_name(wanted), buffer_view(&units),
                 shown_length(typed), typed.data, buffer_view(&name));
    buffer_free(&units);
    buffer_free(&name);
    return false;
}

/* Returns the unit that a number without one takes over from the other side of +-, or NULL. Sets
 * *unclear if that side was computed from several numbers, so that its unit is ambiguous. */
static const struct unit *borrowed_unit(const struct number_part *part,
                                        const struct number_part *other, bool *unclear)
{
    const bool bare = part->dimension.kind == DIMENSION_BARE && part->number != 0;
    const struct unit *unit = bare ? other->dimension.unit : NULL;
    *unclear = unit && !other->dimension.is_single;
    return unit;
}

/* Converts `part`, one side of VALUE +- UNCERTAINTY, to SI units in *si; `other` is the other side.
 * A bare number has the unit of the other side, or the SI unit. `what` names the value and `typed`
 * is its text, both for messages. Returns false with an error if the dimension does not fit
 * `wanted` or if it is unclear which unit a bare side has; a hint explains Hz against rad/s. */
static bool convert_to_si(const struct number_part *part, const struct number_part *other,
                          const char *what, enum quantity wanted, struct text typed, double *si,
                          struct error *error)
{
    bool unclear;
    int turns;
    const struct unit *unit = borrowed_unit(part, other, &unclear);
    const struct dimension is = unit ? dimension_of_unit(unit) : part->dimension;
    *si = part->number;
    if (unclear)
        return error_at(error, typed, "%s: both sides of +- need their units in '%.*s'", what,
                        shown_length(typed), typed.data);
    if (!dimension_fits(&is, wanted, &turns)) {
        const double angle = dimension_angle_factor(&is, wanted);
        report_wrong_quantity(what, wanted, &is, typed, error);
        if (angle != 0)
            return error_hint(error,
                              angle > 0 ? "Hz counts cycles: 2*pi*(%.*s) counts radians"
                                        : "rad/s counts radians: (%.*s)/(2*pi) counts cycles",
                              shown_length(typed), typed.data);
        return expr_hint_readings(part->expr, error);
    }
    if (unit)
        unit_convert(unit, unit->quantity, part->number, si);
    *si = dimension_turned(*si, turns);
    return true;
}

/* Returns false with an error if the uncertainty and the value have different dimensions. */
static bool check_spread(const struct number_part *number, const struct number_part *spread,
                         struct text typed, struct error *error)
{
    struct dimension sum;
    int turns;
    const bool bare =
        number->dimension.kind == DIMENSION_BARE || spread->dimension.kind == DIMENSION_BARE;
    return bare ||
           (dimension_sum(&number->dimension, &spread->dimension, &sum, &turns) && turns == 0) ||
           error_at(error, typed, "the two sides of +- are of different dimensions");
}

/* Returns the unit in which a value is repeated to the user: as typed, or that of the computed
 * quantity; NULL if it has none. */
static const struct unit *unit_of_value(const struct dimension *dimension)
{
    const enum quantity quantity = dimension_quantity(dimension);
    if (!dimension->unit || dimension->is_single || dimension->unit->quantity == quantity)
        return dimension->unit;
    return unit_find(text_of(quantity_unit(quantity)));
}

/* Returns the quantity of an expression that is a single name, such as v or y', else
 * QUANTITY_OTHER. */
static enum quantity quantity_of_name(const struct parser *parser, struct text typed)
{
    const size_t used = peek_name(typed).len;
    const bool whole = used == typed.len ||
                       (used > 0 && used + 1 == typed.len && typed.data[used] == '\''); /* y' */
    return whole ? name_quantity(parser->scope, typed) : QUANTITY_OTHER;
}

/* Reads VALUE [+- UNCERTAINTY] or VALUE(DIGITS) into item->value, in SI units. `what` names it in
 * messages; `wanted` is its quantity, or QUANTITY_OTHER for any. Returns false with an error if it
 * is malformed or not finite. */
bool parse_value(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error)
{
    text_skip_blanks(&parser->rest);
    const char *start = parser->rest.data;
    struct number_part number = {0}, spread = {0};
    if (parser->rest.len == 0) {
        error_at(error, parser->rest, "%s needs a value", what);
        return false;
    }
    if (!parse_number_part(parser, &number, error))
        return false;
    struct text following = parser->rest;
    text_skip_blanks(&following);
    const bool signs = starts_uncertainty(following), uncertain = signs || number.last_digits > 0;
    if (number.last_digits > 0)
        spread = (struct number_part){number.last_digits, number.dimension, number.expr, 0};
    if (signs) {
        parser->rest = following;
        text_skip(&parser->rest, 2);
        if (!parse_number_part(parser, &spread, error))
            return false;
    }
    const struct text typed = text_between(start, parser->rest.data);
    item->text = typed;
    item->expr = number.expr;
    const struct dimension *is = number.dimension.unit ? &number.dimension : &spread.dimension;
    item->unit = unit_of_value(is);
    item->value = (struct measured){0, 0};
    if (!check_spread(&number, &spread, typed, error) ||
        !convert_to_si(&number, &spread, what, wanted, typed, &item->value.value, error) ||
        (uncertain &&
         !convert_to_si(&spread, &number, what, wanted, typed, &item->value.uncertainty, error)))
        return false;
    if (wanted != QUANTITY_OTHER)
        item->quantity = wanted;
    else
        item->quantity = is->unit ? dimension_quantity(is) : quantity_of_name(parser, typed);
    if (!isfinite(item->value.value))
        return error_at(error, typed, "%s: '%.*s' is not a finite number", what,
                        shown_length(typed), typed.data);
    if (!isfinite(item->value.uncertainty) || item->value.uncertainty < 0)
        return error_at(error, typed,
                        "%s: the uncertainty after +- must be a number that is not negative", what);
    return true;
}

/* Reads FROM:TO into item->range, in SI units; an end that is left out is NAN. Returns false with
 * an error if the colon is missing, the range is empty, or the units of the ends differ in kind. */
bool parse_range(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error)
{
    struct item end;
    const struct unit *lacks = NULL;
    text_skip_blanks(&parser->rest);
    const char *start = parser->rest.data;
    item->range[0] = item->range[1] = NAN;
    if (parser->rest.len > 0 && parser->rest.data[0] != ':') {
        if (!parse_value(parser, what, wanted, &end, error))
            return false;
        item->range[0] = end.value.value;
        item->unit = end.unit;
        item->quantity = end.quantity;
    }
    struct text following = parser->rest;
    text_skip_blanks(&following);
    if (following.len == 0 || following.data[0] != ':') {
        error_at(error, text_between(start, parser->rest.data), "%s needs a range from:to", what);
        return error_hint(error, "for example %s=2:8, or 2: for everything after 2", what);
    }
    parser->rest = following;
    text_skip(&parser->rest, 1);
    /* Only a number continues a range after a blank, so that `3: of run 1` can be written. */
    struct text next = parser->rest;
    text_skip_blanks(&next);
    const bool open = next.len == 0 || (next.data != parser->rest.data &&
                                        !is_digit_char(next.data[0]) && next.data[0] != '.');
    if (!open) {
        if (!parse_value(parser, what, wanted, &end, error))
            return false;
        item->range[1] = end.value.value;
        if (item->unit && end.unit && item->unit->quantity != end.unit->quantity)
            return error_at(error, text_between(start, parser->rest.data),
                            "%s: the ends of the range have different units, %s and %s", what,
                            item->unit->row.name, end.unit->row.name);
        /* A unit at the second end only is the likely cause of an empty range. */
        lacks = !item->unit && end.unit && !isnan(item->range[0]) ? end.unit : NULL;
        item->unit = end.unit ? end.unit : item->unit;
        item->quantity =
            end.unit || item->quantity == QUANTITY_OTHER ? end.quantity : item->quantity;
    }
    item->text = text_between(start, parser->rest.data);
    if (!(item->range[0] >= item->range[1]))
        return true;
    error_at(error, item->text, "%s: the range '%.*s' is empty", what, shown_length(item->text),
             item->text.data);
    return lacks ? error_hint(error, "each end needs its own unit: write %s at the first one, too",
                              lacks->row.name)
                 : false;
}

/* Reads a whole number, from 1 up or, if `negative` is set, of any sign, into item->value. `what`
 * names it in messages. Returns false with an error if it is none or too large. */
bool parse_integer(struct parser *parser, const char *what, bool negative, struct item *item,
                   struct error *error)
{
    text_skip_blanks(&parser->rest);
    size_t used = 0;
    double value = 0;
    const enum real_status status = real_scan(parser->rest, '.', &value, &used);
    struct text word = peek_word(parser->rest, ",");
    if (status != REAL_OK || used == 0 || value != nearbyint(value) || fabs(value) > LIMIT_STEPS ||
        (used < parser->rest.len && is_name_char(parser->rest.data[used])) ||
        (!negative && value < 1)) {
        const struct text shown = word.len ? word : parser->rest;
        return error_at(error, shown, "%s needs a whole number%s, got '%.*s'", what,
                        negative ? "" : " from 1 up", shown_length(shown), shown.data);
    }
    item->text = (struct text){parser->rest.data, used};
    item->value = (struct measured){value, 0};
    item->quantity = QUANTITY_NUMBER;
    text_skip(&parser->rest, used);
    return true;
}

/* Fills `error` for a decimal comma, as in 0,5; rest begins with the comma. Returns false. */
static bool report_decimal_comma(struct text rest, struct error *error)
{
    /* rest.data[-1] is the last digit of the number before the comma. */
    const char *begin = rest.data, *end = rest.data + 1;
    while (is_digit_char(begin[-1]) || begin[-1] == '-' || begin[-1] == '.')
        begin--;
    while (end < rest.data + rest.len && is_digit_char(*end))
        end++;
    error_at(error, text_between(begin, end),
             "decimal comma in '%.*s': the decimal mark is a point", (int)(end - begin), begin);
    return error_hint(error, "write %.*s.%.*s", (int)(rest.data - begin), begin,
                      (int)(end - rest.data - 1), rest.data + 1);
}

/* Returns true if no unit follows the last number of an item, which is its uncertainty if it has
 * one. */
static bool lacks_unit(const struct item *number)
{
    struct text last = number->text;
    double value;
    while (last.len > 2 && !starts_uncertainty(last))
        last = text_after(last, 1);
    if (last.len <= 2)
        return !number->unit;
    return real_parse(text_trim(text_after(last, 2)), &value) == REAL_OK;
}

/* Returns true if no text remains in the statement. Otherwise returns false with an error that
 * names the likely reason: decimal comma, unknown unit, a second unit, or a word too many. `number`
 * is the item before the remaining text, or NULL if that item was no number. */
bool refuse_rest(const struct parser *parser, const struct item *number, struct error *error)
{
    struct text rest = parser->rest;
    if (rest.len == 0)
        return true;
    if (number && rest.len >= 2 && rest.data[0] == ',' && is_digit_char(rest.data[1]) &&
        is_digit_char(rest.data[-1]))
        return report_decimal_comma(rest, error);
    text_skip_blanks(&rest);
    if (rest.len == 0)
        return true;
    if (number && is_name_start(rest.data[0]) && lacks_unit(number))
        return refuse_unit_word(parser->scope, unit_word(rest), number->text, number->quantity,
                                error);
    struct text word = peek_word(rest, "");
    if (word.len == 0)
        word = rest;
    error_at(error, word, "unexpected '%.*s'", shown_length(word), word.data);
    if (!number || !number->unit)
        return false;
    return unit_match(word) && error_hint(error, "a value has one unit, and '%.*s' has one already",
                                          shown_length(number->text), number->text.data);
}

/* Reads "12" or "120mm"; the unit is cm unless a unit of length follows. */
static bool read_length(struct text text, double *side)
{
    size_t used;
    if (real_scan(text, '.', side, &used) != REAL_OK || used == 0)
        return false;
    const struct text name = text_trim(text_after(text, used));
    const struct unit *unit = name.len ? unit_find(name) : unit_find(TEXT("cm"));
    *side *= unit && unit->quantity == QUANTITY_LENGTH ? unit->factor : NAN;
    return !isnan(*side);
}

/* Reads WIDTHxHEIGHT into item->range [m], in cm unless a unit is given. Returns false with an
 * error if it is malformed or outside of the sizes allowed for pictures. */
bool parse_sides(struct parser *parser, const char *what, const char *stops, struct item *item,
                 struct error *error)
{
    if (!parse_word(parser, stops, item, error))
        return false;
    const char *cross = memchr(item->text.data, 'x', item->text.len);
    const size_t first = cross ? (size_t)(cross - item->text.data) : 0;
    if (!cross || !read_length((struct text){item->text.data, first}, &item->range[0]) ||
        !read_length((struct text){cross + 1, item->text.len - first - 1}, &item->range[1])) {
        error_at(error, item->text, "%s must be WIDTHxHEIGHT in cm, not '%.*s'", what,
                 (int)(item->text.len < 64 ? item->text.len : 64), item->text.data);
        return error_hint(error, "for example %s=12x8, or %s=120mmx80mm", what, what);
    }
    for (int i = 0; i < 2; i++)
        if (!(item->range[i] >= PICTURE_MIN && item->range[i] <= PICTURE_MAX))
            return error_at(error, item->text,
                            "%s: the sides of a picture must be %g to %g cm, not %.4g cm", what,
                            100 * PICTURE_MIN, 100 * PICTURE_MAX, 100 * item->range[i]);
    return true;
}
