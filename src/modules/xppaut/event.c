/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads events of .ode files, global SIGN {CONDITION} {NAME=FORMULA;…}. */
#include <hooke/base/statement.h>
#include <string.h>

#include "modules/xppaut/ode.h"

/* Splits the first item off *rest: the text in {braces} if *rest begins with '{', otherwise the
 * text before the next '{' (a condition may be written without braces). Sets *inside to the item
 * without braces and blanks. Returns false if a '}' is missing or if the item without braces is
 * empty. */
static bool take_braced(struct text *rest, struct text *inside)
{
    *rest = text_trim(*rest);
    const char *open = rest->len > 0 ? memchr(rest->data, '{', rest->len) : NULL;
    if (open != rest->data) {
        *inside = text_trim((struct text){rest->data, open ? (size_t)(open - rest->data) : 0});
        *rest = (struct text){rest->data + inside->len, rest->len - inside->len};
        return inside->len > 0;
    }
    const char *close = open ? memchr(open, '}', rest->len) : NULL;
    if (!close)
        return false;
    *inside = (struct text){open + 1, (size_t)(close - open - 1)};
    *rest = (struct text){close + 1, rest->len - (size_t)(close + 1 - rest->data)};
    return true;
}

/* Appends to output the command for `reset`, one NAME=FORMULA of an event. NAME arret (XPPAUT's
 * word for stopping the run) appends nothing and sets *stops. Returns false with an error, also if
 * NAME is neither a variable nor a parameter. */
static bool add_reset(const struct ode_reader *reader, struct text reset, bool *stops,
                      struct buffer *output)
{
    struct error *error = reader->ode->error;
    const char *equals = memchr(reset.data, '=', reset.len);
    if (!equals)
        return ode_error(error, reader->line, "an event needs NAME=FORMULA");
    const struct text name = text_trim((struct text){reset.data, (size_t)(equals - reset.data)}),
                      formula = {equals + 1, reset.len - (size_t)(equals + 1 - reset.data)};
    if (text_is(name, "out_put") || text_is(name, "no_interp"))
        return ode_error(error, reader->line, "events cannot use '%.*s'", (int)name.len, name.data);
    if (text_is(name, "arret")) {
        *stops = true;
        return true;
    }
    const struct ode_symbol *symbol = ode_find(reader->ode, name);
    if (!symbol || (symbol->kind != ODE_VARIABLE && symbol->kind != ODE_PARAM))
        return ode_error(error, reader->line,
                         "an event can set a variable or a parameter, but not '%.*s'",
                         (int)(name.len < 40 ? name.len : 40), name.data);
    buffer_format(output, "%s = ", symbol->as);
    if (!ode_formula(reader, formula, output))
        return false;
    buffer_put(output, TEXT("; "));
    return true;
}

/* Reads an event from the text behind `global`: SIGN {CONDITION} {NAME=FORMULA;...}. Sign 1 becomes
 * "rising" and -1 "falling"; sign 0, which means both in XPPAUT, is refused. The run continues
 * after the event unless one of its resets is arret. Returns false with an error. */
bool ode_event(struct ode *ode, const struct ode_line *line, struct text rest,
               struct ode_event *event)
{
    const struct ode_reader reader = {.ode = ode, .line = line->number};
    struct text condition, resets, reset;
    const struct text sign = peek_word(rest, "{");
    rest = text_after(rest, sign.len);
    if (text_is(sign, "0"))
        return ode_error(ode->error, line->number, "an event needs the sign 1 or -1");
    if (!(text_is(sign, "1") || text_is(sign, "-1") || text_is(sign, "+1")) ||
        !take_braced(&rest, &condition) || !take_braced(&rest, &resets))
        return ode_error(ode->error, line->number,
                         "write an event as global 1 {CONDITION} {NAME=FORMULA;...}, or -1");
    struct buffer when = {0}, commands = {0};
    bool stops = false, fine = ode_formula(&reader, condition, &when);
    buffer_put(&when, text_is(sign, "-1") ? TEXT(" falling") : TEXT(" rising"));
    while (fine && text_split(&resets, ';', &reset))
        fine = text_trim(reset).len == 0 || add_reset(&reader, text_trim(reset), &stops, &commands);
    if (!stops)
        buffer_put(&commands, TEXT("continue"));
    *event = (struct ode_event){line->number, arena_text(ode->arena, buffer_text(&when)),
                                arena_text(ode->arena, buffer_text(&commands))};
    if (fine && (when.failed || commands.failed || !event->when || !event->commands))
        fine = error_memory(ode->error);
    buffer_free(&when);
    buffer_free(&commands);
    return fine;
}
