/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads ranges of values, FROM:TO[:STEP], for arguments NAME=... of sweeps and maps. */
#include <hooke/base/statement.h>
#include <hooke/language/grid.h>

#include <math.h>
#include <string.h>

/* Removes one NAME=... argument, which may contain blanks, from the start of *rest and returns it
 * without outer blanks. The argument ends before the next NAME=, --option or the word `at`. *rest
 * must not be blank. */
struct text next_key_argument(struct text *rest)
{
    text_skip_blanks(rest);
    size_t end = 1;
    for (; end < rest->len; end++) {
        struct text following = {rest->data + end, rest->len - end};
        if (!strchr(" \t", rest->data[end - 1]))
            continue;
        const struct text name = peek_name(following);
        if (text_starts(following, TEXT("--")) || text_is(name, "at"))
            break;
        struct text remainder = {following.data + name.len, following.len - name.len};
        text_skip_blanks(&remainder);
        if (name.len > 0 && text_starts(remainder, TEXT("=")))
            break;
    }
    if (end > rest->len)
        end = rest->len;
    const struct text argument = {rest->data, end};
    *rest = (struct text){rest->data + end, rest->len - end};
    return text_trim(argument);
}

/* Reads one end of the range into *value (in SI units), with the blanks around it. */
static bool read_range_end(struct parser *parser, const struct value_grid *grid, double *value,
                           struct error *error)
{
    struct item item = {0};
    text_skip_blanks(&parser->rest);
    if (!parse_value(parser, grid->name, grid->quantity, &item, error))
        return false;
    *value = item.value.value;
    text_skip_blanks(&parser->rest);
    return true;
}

/* Skips a colon and the blanks after it. Returns false if there is no colon. */
static bool skip_colon(struct parser *parser)
{
    const bool there = text_starts(parser->rest, TEXT(":"));
    if (there)
        parser->rest = text_after(parser->rest, 1);
    text_skip_blanks(&parser->rest);
    return there;
}

/* Computes the number of values of a grid, first, first + step ... or first, first * step ... for a
 * logarithmic one. Moves the last value to the last step unless it is a whole number of steps away,
 * up to rounding. Returns false with an error if the steps lead nowhere or past the end. */
static bool count_values(struct value_grid *grid, double step, struct text where,
                         struct error *error)
{
    const double steps =
        grid->log ? log(grid->last / grid->first) / log(step) : (grid->last - grid->first) / step;
    if (grid->first == grid->last) {
        grid->count = 1;
        return true;
    }
    if (!(steps > 0) || !(steps < 1e9)) {
        error_at(error, where, "%s: these steps do not lead from one end to the other%s",
                 grid->name, steps > 0 ? " in less than 1e9" : "");
        return error_hint(error, "%s=1:10:0.5 adds 0.5, %s=1:100:x10 multiplies by 10", grid->name,
                          grid->name);
    }
    grid->count = 1 + (int)floor(steps + 1e-6);
    /* A step beyond the end is probably meant as the number of points: the hint shows the step for
     * it. */
    if (grid->count == 1)
        return error_at(error, where,
                        "%s: the first step is longer than the range, so only %s = %.6g is left "
                        "and no sweep is needed",
                        grid->name, grid->name, grid->first) ||
               (!grid->log && step >= 2 && step == floor(step) &&
                error_hint(error, "for %.0f points: %s=%.6g:%.6g:%.12g", step, grid->name,
                           grid->first, grid->last, (grid->last - grid->first) / (step - 1)));
    if (fabs(steps - (grid->count - 1)) > 1e-6)
        grid->last = grid->log ? grid->first * pow(step, grid->count - 1)
                               : grid->first + step * (grid->count - 1);
    return true;
}

/* Reads FROM:TO, FROM:TO:STEP, or FROM:TO:xFACTOR into a grid whose name and quantity are set.
 * Returns false with an error and an example if it is malformed. */
bool parse_grid(struct parser *parser, struct value_grid *grid, struct error *error)
{
    const struct text range = parser->rest;
    if (!read_range_end(parser, grid, &grid->first, error))
        return false;
    if (!skip_colon(parser)) {
        error_at(error, text_trim(range), "%s needs a range from:to", grid->name);
        return error_hint(error, "for example %s=1:10:0.5, or %s=1:100:x10 for factors of 10",
                          grid->name, grid->name);
    }
    if (!read_range_end(parser, grid, &grid->last, error))
        return false;
    if (!skip_colon(parser)) {
        grid->count = grid->first == grid->last ? 1 : GRID_VALUES_USUAL;
        return refuse_rest(parser, NULL, error);
    }
    struct item step = {0};
    grid->log = text_starts(parser->rest, TEXT("x")) && parser->rest.len > 1 &&
                strchr("0123456789.", parser->rest.data[1]);
    if (grid->log)
        parser->rest = text_after(parser->rest, 1);
    if (!parse_value(parser, grid->name, grid->log ? QUANTITY_NUMBER : grid->quantity, &step,
                     error) ||
        !refuse_rest(parser, &step, error))
        return false;
    if (grid->log && !(grid->first * grid->last > 0))
        return error_at(error, text_trim(range),
                        "%s: factors lead from one end to the other only on one side of 0",
                        grid->name);
    return count_values(grid, step.value.value, text_trim(range), error);
}
