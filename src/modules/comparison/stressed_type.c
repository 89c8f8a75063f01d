/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The type of arguments of `stress`: methods, and the names of its cases. */
#include <hooke/language/complete.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/compute/stability.h"

#include <string.h>

/* Reads a word that is a method or a case: item->row is the method's row, or NULL for a case.
 * Returns false with an error, which suggests a similar name, if it is neither. */
static bool read_stressed(struct parser *parser, const struct argument *argument, const char *stops,
                          struct item *item, struct error *error)
{
    const struct text begun = parser->rest;
    struct stress_case one;
    if (!parse_word(parser, stops, item, error))
        return false;
    struct suggestion suggestion = {.wanted = item->text};
    for (size_t i = 0; stress_case_at(i, &one); i++) {
        if (text_is(item->text, one.name))
            return true;
        suggestion_offer(&suggestion, one.name);
    }
    parser->rest = begun;
    if (argument_type_row(TYPE_CHOICE)->read(parser, argument, stops, item, error))
        return true;
    if (!error->hint[0])
        suggestion_hint(&suggestion, error);
    return error->hint[0] ? false
                          : error_hint(error, "use methods, and cases listed by 'stress --full'");
}

/* Offers the names of methods and of cases, except those that would have to be quoted. */
static void complete_stressed(struct completion *c, const struct argument *argument,
                              struct text preceding)
{
    struct stress_case one;
    UNUSED(preceding);
    complete_catalog(c, argument->choices);
    for (size_t i = 0; stress_case_at(i, &one); i++)
        if (!strchr(one.name, ' ')) /* it would have to be quoted */
            complete_offer(c, one.name, one.brief);
}

const struct argument_type_row stressed_type = {.name = "STRESSED",
                                                .shown = "METHOD|CASE",
                                                .read = read_stressed,
                                                .complete = complete_stressed,
                                                .flags = TYPE_IS_LIST | TYPE_BEFORE_WORDS};
