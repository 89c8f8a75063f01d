/* SPDX-License-Identifier: GPL-3.0-or-later */
/* list methods: a table of the methods, all of them or those with the properties that are asked
 * for. */
#include "command/session/list_methods.h"
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/command/handler.h>

#include <math.h>

/* A word that chooses methods with any of these flags and none of those. */
#define FILTER(word, says, any_of, none_of)                                                        \
    {                                                                                              \
        .row = {word, "", says, "", NULL}, .any = any_of, .none = none_of                          \
    }

static const struct method_filter {
    struct row row;
    unsigned any, none;
} filters[] = {
    FILTER("stiff", "for stiff scenes", METHOD_L_STABLE | METHOD_A_STABLE, METHOD_EXTERNAL),
    FILTER("symplectic", "for long runs without drag", METHOD_SYMPLECTIC, 0),
    FILTER("symmetric", "reversible in time", METHOD_SYMMETRIC, 0),
    FILTER("adaptive", "chooses its steps by tol", METHOD_ADAPTIVE, METHOD_EXTERNAL),
    FILTER("implicit", "solves equations at each step", METHOD_IMPLICIT, METHOD_EXTERNAL),
    FILTER("explicit", "only evaluates forces", ~0u,
           METHOD_IMPLICIT | METHOD_EXACT | METHOD_EXTERNAL),
    FILTER("multistep", "uses earlier steps", METHOD_MULTISTEP, METHOD_EXTERNAL),
    FILTER("exact", "the exact solution", METHOD_EXACT, 0),
};
const struct catalog method_kind_catalog = CATALOG("kind of method", filters);

/* Properties that the methods in the list have; each filter must choose a method. */
struct wanted_methods {
    unsigned any[COUNT_OF(filters)], none[COUNT_OF(filters)];
    int filters, order; /* an order of 0 stands for any */
};

/* Reads words such as "stiff" and "order 4". Returns false with the error set if one is unknown. */
static bool read_wanted(struct text words, struct wanted_methods *wanted, struct error *error)
{
    while ((words = text_trim(words)).len > 0) {
        const struct text word = peek_word(words, "");
        words = text_after(words, word.len);
        if (text_is(word, "order")) {
            words = text_trim(words);
            const struct text number = peek_word(words, "");
            double order;
            if (real_parse(number, &order) != REAL_OK || order < 1 || order > 99)
                return error_at(error, number.len ? number : word,
                                "order needs a number: list methods order 4");
            wanted->order = (int)order;
            words = text_after(words, number.len);
            continue;
        }
        const struct row *row = catalog_find(&method_kind_catalog, word);
        if (!row) {
            catalog_unknown(&method_kind_catalog, word, error);
            return error_hint(error, "(or 'order N')");
        }
        const struct method_filter *filter = (const struct method_filter *)(const void *)row;
        if (wanted->filters < (int)COUNT_OF(filters)) {
            wanted->any[wanted->filters] = filter->any;
            wanted->none[wanted->filters++] = filter->none;
        }
    }
    return true;
}

/* Returns true if the method has all properties. */
static bool is_wanted(const struct wanted_methods *wanted, const struct method *method)
{
    bool is = wanted->order == 0 ||
              (wanted->order == method->order && !(method->flags & METHOD_EXTERNAL));
    for (int i = 0; i < wanted->filters; i++)
        is = is && (wanted->any[i] == ~0u || (method->flags & wanted->any[i])) &&
             !(method->flags & wanted->none[i]);
    return is;
}

/* Returns the usual purpose of a method, by its properties. */
static const char *use_of(const struct method *method)
{
    const unsigned flags = method->flags;
    if (flags & METHOD_EXTERNAL)
        return "an independent check";
    if (flags & METHOD_EXACT)
        return "scenes with a closed form";
    if (flags & METHOD_L_STABLE)
        return flags & METHOD_ADAPTIVE ? "stiff scenes, by tol" : "stiff scenes";
    if (flags & METHOD_A_STABLE)
        return "any step; undamped, stiff";
    if (flags & METHOD_NO_VELOCITY)
        return flags & METHOD_ADAPTIVE ? "no drag, many digits" : "no drag, smooth forces";
    if (flags & METHOD_SYMPLECTIC)
        return "long runs, bounded energy";
    if (flags & METHOD_ADAPTIVE)
        return method->order >= 8 ? "many digits, by tol" : "accuracy by tol";
    if (flags & METHOD_IMPLICIT)
        return "stiff scenes, fixed steps";
    if (flags & METHOD_MULTISTEP)
        return "expensive forces, fixed steps";
    return method->order == 1 ? "for teaching: errors grow" : "short runs, fixed steps";
}

/* Appends the largest stable omega0 dt in its column. */
static void put_stable(double limit, struct buffer *line)
{
    if (limit == 0)
        buffer_put(line, TEXT("no dt    "));
    else if (isinf(limit))
        buffer_put(line, TEXT("any dt   "));
    else if (isnan(limit))
        buffer_put(line, TEXT("-        "));
    else
        buffer_format(line, "%-8.3g ", limit);
}

/* Replies with a table of the methods that have all properties named in `words` (all methods if it
 * is empty), and calls record() for each, where `stable` is the largest stable omega0 dt. Returns
 * false with the error set if a word is unknown, no method has the properties, or the computation
 * is cancelled. */
bool list_methods(struct text words, const struct cancel *cancel,
                  void (*record)(const struct row *row, double stable, struct reply *reply),
                  struct reply *reply, struct error *error)
{
    struct wanted_methods wanted = {.filters = 0};
    int count = 0;
    if (!read_wanted(words, &wanted, error))
        return false;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct row *row = catalog_row(&method_catalog, i);
        const struct method *method = method_from(row);
        if (!is_wanted(&wanted, method))
            continue;
        if (cancelled(cancel))
            return error_set(error, ERROR_CANCELLED, "stopped");
        const double stable = method_stable_limit(method, DRAG_DEFAULT, 0);
        if (count++ == 0)
            reply_line(reply, "%-22s order forces stable to adapts use", "method");
        struct buffer line = {0};
        buffer_format(&line, "%-22s ", row->name);
        if (method->order > 0)
            buffer_format(&line, "%5d ", method->order);
        else
            buffer_put(&line, TEXT("exact "));
        buffer_format(&line, "%6d ", method->evals);
        put_stable(stable, &line);
        buffer_format(&line, "%-6s %s", method->flags & METHOD_ADAPTIVE ? "yes" : "-",
                      use_of(method));
        reply_text(reply, buffer_text(&line));
        buffer_free(&line);
        record(row, stable, reply);
    }
    if (count > 0)
        reply_line(
            reply,
            "stable to: largest omega0 dt without damping; 'help NAME' has formula and source");
    return count > 0 ||
           error_at(error, words,
                    "no method has all of these properties; 'list methods' shows all methods");
}
