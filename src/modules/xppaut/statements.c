/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Takes the lines of .ode files apart: statements that begin with a word, and definitions. */
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include "modules/xppaut/statements.h"
#include "modules/xppaut/net.h"

#include <stdio.h>
#include <string.h>

/* Returns the text from a position on, without blanks at its ends. */
static struct text statement_tail(struct text text, size_t position)
{
    return text_trim(text_after(text, position));
}

/* Returns the number of characters of a text that errors show. */
static int shown_length(struct text text)
{
    return (int)(text.len < 60 ? text.len : 60);
}

/* Makes room for one more entry in an array of count entries of `size` bytes in the arena. `array`
 * is the address of the pointer to its first entry, which is replaced when *capacity is reached.
 * Returns false with an error if out of memory. */
bool ode_grow(struct ode *ode, void *array, int count, int *capacity, size_t size)
{
    void *old, *more;
    if (count < *capacity)
        return true;
    memcpy(&old, array, sizeof old);
    more = arena_array(ode->arena, 2 * (size_t)count + 32, size);
    if (!more)
        return error_memory(ode->error);
    if (count > 0)
        memcpy(more, old, (size_t)count * size);
    memcpy(array, &more, sizeof more);
    *capacity = 2 * count + 32;
    return true;
}

/* Adds a note about a line of the file; `warns` shows it as a warning. Equal notes are added once.
 * The note after the first ODE_NOTES tells that more are omitted. Returns false with an error if
 * out of memory. */
bool ode_note(struct ode_statements *s, int line, bool warns, const char *format, ...)
{
    char text[300];
    if (s->notes > ODE_NOTES)
        return true;
    const int used = snprintf(text, sizeof text, "line %d: ", line);
    va_list args;
    va_start(args, format);
    vsnprintf(text + used, sizeof text - (size_t)used, format, args);
    va_end(args);
    if (s->notes == ODE_NOTES)
        snprintf(text, sizeof text, "more notes for line %d and later lines are omitted", line);
    for (int i = 0; i < s->notes; i++)
        if (strcmp(s->note[i].text, text) == 0)
            return true;
    if (!ode_grow(&s->ode, &s->note, s->notes, &s->note_capacity, sizeof *s->note))
        return false;
    s->note[s->notes] = (struct ode_note){arena_text(s->ode.arena, text_of(text)), warns};
    return s->note[s->notes++].text || error_memory(s->ode.error);
}

/* ---- names ---- */

/* Returns true if the text can be a name. */
static bool is_name(struct text name)
{
    for (size_t i = 0; i < name.len; i++) {
        const char c = name.data[i];
        if (!((c >= 'a' && c <= 'z') || c == '_' || (i > 0 && c >= '0' && c <= '9')))
            return false;
    }
    return name.len > 0;
}

/* Adds a symbol of a kind, defined in that line as name=text. Returns NULL with an error if the
 * name is invalid or defined twice, or if there are too many. Auxiliary quantities (ODE_AUX) can
 * have any name, as formulas cannot read them. */
static struct ode_symbol *ode_symbol_add(struct ode_statements *s, enum ode_kind kind, int line,
                                         struct text name, struct text text)
{
    struct ode *ode = &s->ode;
    if (kind != ODE_AUX && !is_name(name)) {
        ode_error(ode->error, line, "'%.*s' is not a name", shown_length(name), name.data);
        return NULL;
    }
    const struct ode_symbol *other = kind == ODE_AUX ? NULL : ode_find(ode, name);
    if (other)
        ode_error(ode->error, line, "'%.*s' is defined twice: in line %d", shown_length(name),
                  name.data, other->line);
    else if (kind != ODE_AUX && (text_is(name, "t") || text_is(name, "pi")))
        ode_error(ode->error, line, "'%.*s' already means something", shown_length(name),
                  name.data);
    else if (ode->symbols == ODE_SYMBOLS)
        ode_error(ode->error, line, "the file has more than %d names", ODE_SYMBOLS);
    else if (ode_grow(ode, &ode->symbol, ode->symbols, &ode->capacity, sizeof *ode->symbol))
        other = NULL;
    else
        return NULL;
    if (ode->error->code != ERROR_NONE)
        return NULL;
    struct ode_symbol *symbol = &ode->symbol[ode->symbols++];
    *symbol = (struct ode_symbol){
        .name = name, .kind = kind, .index = ode->count[kind]++, .line = line, .text = text};
    return symbol;
}

/* ---- statements that begin with a word ---- */

/* Adds parameters NAME=VALUE, which are 0 without a value. Returns false with an error. */
static bool take_params(struct ode_statements *s, int line, struct text rest)
{
    struct text name, value;
    while (ode_pair(&rest, &name, &value)) {
        struct ode_symbol *symbol = ode_symbol_add(s, ODE_PARAM, line, name, TEXT(""));
        if (!symbol ||
            (value.len > 0 && !ode_number(line, name, value, &symbol->value, s->ode.error)))
            return false;
    }
    return true;
}

/* Adds an initial value. Returns false with an error if it is no number. */
static bool take_initial(struct ode_statements *s, int line, struct text name, struct text value)
{
    if (!ode_grow(&s->ode, &s->initial, s->initials, &s->initial_capacity, sizeof *s->initial))
        return false;
    struct ode_value *initial = &s->initial[s->initials++];
    *initial = (struct ode_value){.name = name, .line = line};
    if (value.len == 0 || real_parse(value, &initial->value) == REAL_OK)
        return true;
    return ode_error(s->ode.error, line, "%.*s(0)=%.*s: an initial value must be a number",
                     shown_length(name), name.data, shown_length(value), value.data);
}

/* Adds initial values NAME=VALUE. Returns false with an error. */
static bool take_initials(struct ode_statements *s, int line, struct text rest)
{
    struct text name, value;
    while (ode_pair(&rest, &name, &value))
        if (!take_initial(s, line, name, value))
            return false;
    return true;
}

/* Adds an auxiliary quantity. Returns false with an error. */
static bool take_aux(struct ode_statements *s, int line, struct text rest)
{
    const char *equals = rest.len > 0 ? memchr(rest.data, '=', rest.len) : NULL;
    if (!equals)
        return ode_error(s->ode.error, line, "write an auxiliary quantity as aux NAME=FORMULA");
    return ode_symbol_add(s, ODE_AUX, line,
                          text_trim((struct text){rest.data, (size_t)(equals - rest.data)}),
                          statement_tail(rest, (size_t)(equals + 1 - rest.data)));
}

/* Adds a table. Returns false with an error. */
static bool take_table(struct ode_statements *s, int line, struct text rest)
{
    const struct text name = peek_word(rest, "%");
    struct ode_symbol *symbol =
        ode_symbol_add(s, ODE_TABLE, line, name, statement_tail(rest, name.len));
    return symbol && ode_table_read(&s->ode, symbol);
}

/* Adds a network. Returns false with an error. */
static bool take_special(struct ode_statements *s, int line, struct text rest)
{
    const char *equals = rest.len > 0 ? memchr(rest.data, '=', rest.len) : NULL;
    if (!equals)
        return ode_error(s->ode.error, line, "write a network as special NAME=conv(...)");
    struct ode_symbol *symbol = ode_symbol_add(
        s, ODE_NET, line, text_trim((struct text){rest.data, (size_t)(equals - rest.data)}),
        statement_tail(rest, (size_t)(equals + 1 - rest.data)));
    return symbol && ode_net_read(&s->ode, symbol);
}

/* Adds a set of values. Returns false with an error if it has no name. */
static bool take_set(struct ode_statements *s, int line, struct text rest)
{
    const struct text name = peek_word(rest, "{");
    if (name.len == 0)
        return ode_error(s->ode.error, line, "write a set as set NAME {NAME=VALUE,...}");
    s->set[s->sets++] = (struct ode_set){name, statement_tail(rest, name.len), line};
    return true;
}

/* Adds the line of an event, which is read when all names are known. Returns false with an error if
 * there are too many. */
static bool take_global(struct ode_statements *s, int line, struct text rest)
{
    if (s->events == ODE_EVENTS)
        return ode_error(s->ode.error, line, "the file has more than %d events", ODE_EVENTS);
    s->event[s->events++] = (struct ode_line){rest, line};
    return true;
}

/* Notes that boundary conditions are left out. */
static bool take_boundary(struct ode_statements *s, int line, struct text rest)
{
    (void)rest;
    return ode_note(s, line, true,
                    "boundary conditions are ignored; the scene starts from its initial values");
}

/* Ignores a statement that has no effect on the motion. */
static bool take_nothing(struct ode_statements *s, int line, struct text rest)
{
    (void)s, (void)line, (void)rest;
    return true;
}

/* Statements that begin with a word. */
static const struct word {
    const char *full; /* full word; the file may have only its begin, of at least `min` letters */
    size_t min;
    bool (*take)(struct ode_statements *s, int line, struct text rest); /* NULL if not supported */
    const char *why; /* reason if it is not supported */
} words[] = {
    {"parameters", 1, take_params, NULL},
    {"params", 1, take_params, NULL},
    {"numbers", 1, take_params, NULL},
    {"initial", 1, take_initials, NULL},
    {"auxiliary", 2, take_aux, NULL},
    {"set", 2, take_set, NULL},
    {"global", 1, take_global, NULL},
    {"bdry", 1, take_boundary, NULL},
    {"bndry", 1, take_boundary, NULL},
    {"boundary", 1, take_boundary, NULL},
    {"only", 2, take_nothing, NULL},
    {"wiener", 1, NULL, "scenes have no noise (wiener)"},
    {"markov", 2, NULL, "scenes have no Markov variables"},
    {"special", 2, take_special, NULL},
    {"solve", 2, NULL, "scenes have no algebraic equations (solve, 0=)"},
    {"table", 2, take_table, NULL},
    {"tabular", 2, take_table, NULL},
    {"export", 2, NULL, "scenes have no values computed by a C library (export)"},
    {"vector", 3, NULL, "scenes have no networks (vector)"},
    {"volterra", 1, NULL, "scenes have no integral equations (volt)"},
    {"options", 2, NULL, "its settings are in another file (options); insert them here"},
};

/* Takes a line that begins with a word of `end` letters. Returns false with an error if it is
 * unknown or not supported. */
static bool ode_keyword_take(struct ode_statements *s, const struct ode_line *line, size_t end)
{
    const struct text word = {line->text.data, end}, rest = statement_tail(line->text, end);
    for (size_t i = 0; i < COUNT_OF(words); i++) {
        if (word.len < words[i].min || !text_starts(text_of(words[i].full), word))
            continue;
        return words[i].take ? words[i].take(s, line->number, rest)
                             : ode_error(s->ode.error, line->number, "%s", words[i].why);
    }
    return ode_error(s->ode.error, line->number, "unknown statement '%.*s'", shown_length(word),
                     word.data);
}

/* ---- statements that begin with a name ---- */

/* Returns true if the word occurs in the text. */
static bool text_holds(struct text text, const char *word)
{
    const size_t len = strlen(word);
    for (size_t i = 0; i + len <= text.len; i++)
        if (memcmp(text.data + i, word, len) == 0)
            return true;
    return false;
}

/* Returns true if the text, without its blanks, equals `what`. */
static bool is_inside(struct text inside, const char *what)
{
    for (size_t i = 0; i < inside.len; i++)
        if (inside.data[i] != ' ' && *what++ != inside.data[i])
            return false;
    return *what == '\0';
}

/* Adds the function name(inside)=text, where `inside` lists the names of its arguments. Returns
 * false with an error. */
static bool take_function(struct ode_statements *s, int line, struct text name, struct text inside,
                          struct text text)
{
    struct text argument;
    struct ode_symbol *function = ode_symbol_add(s, ODE_FUNCTION, line, name, text);
    if (!function)
        return false;
    while (text_split(&inside, ',', &argument)) {
        if (function->arguments == ODE_ARGUMENTS || !is_name(text_trim(argument)))
            return ode_error(s->ode.error, line, "a function has up to %d names as its arguments",
                             ODE_ARGUMENTS);
        function->argument[function->arguments++] = text_trim(argument);
    }
    return true;
}

/* Reads a line NAME(...)=..., whose '(' has index `open`: an initial value NAME(0), or a function.
 * Returns false with an error for maps, NAME(t+1), and integral equations. */
static bool take_call(struct ode_statements *s, const struct ode_line *line, size_t open)
{
    const struct text all = line->text, name = text_trim((struct text){all.data, open});
    const char *close = memchr(all.data + open, ')', all.len - open);
    const char *equals = close ? memchr(close, '=', all.len - (size_t)(close - all.data)) : NULL;
    if (!equals)
        return ode_error(s->ode.error, line->number, "NAME(...)=FORMULA is incomplete");
    const struct text inside = {all.data + open + 1, (size_t)(close - all.data) - open - 1},
                      right = statement_tail(all, (size_t)(equals + 1 - all.data));
    if (is_inside(inside, "t+1"))
        return ode_error(s->ode.error, line->number,
                         "scenes have continuous time, so maps are not possible");
    if (is_inside(inside, "0"))
        return take_initial(s, line->number, name, right);
    if (is_inside(inside, "t") && (text_holds(right, "int{") || text_holds(right, "int[")))
        return ode_error(s->ode.error, line->number,
                         "scenes have no integral equations (Volterra)");
    return take_function(s, line->number, name, inside, right);
}

/* Adds the symbol `name` with the text behind the next '=' as its right-hand side. Returns false
 * with an error. */
static bool take_right(struct ode_statements *s, const struct ode_line *line, enum ode_kind kind,
                       struct text name, size_t position)
{
    const char *equals = memchr(line->text.data + position, '=', line->text.len - position);
    if (!equals)
        return ode_error(s->ode.error, line->number, "a '=' is missing");
    return ode_symbol_add(s, kind, line->number, text_trim(name),
                          statement_tail(line->text, (size_t)(equals + 1 - line->text.data)));
}

/* Reads the settings of a line @, with warnings about those without effect. Returns false with an
 * error. */
static bool take_settings(struct ode_statements *s, const struct ode_line *line)
{
    struct text rest = line->text, name, value;
    const struct text first = peek_word(rest, ",");
    const char *note;
    rest = text_after(rest, first.len);
    if (first.len > 1 &&
        !ode_note(s, line->number, true,
                  "XPPAUT ignores a setting directly after @, and so does this program"))
        return false;
    while (ode_pair(&rest, &name, &value))
        if (!ode_setting(&s->settings, line->number, name, value, &note, s->ode.error) ||
            (note && !ode_note(s, line->number, true, "%s", note)))
            return false;
    return true;
}

/* Reads a statement of any kind, which the character after its first word tells: = for parameters
 * !NAME and hidden quantities, / or ' for equations, ( for calls, none for keywords. Returns false
 * with an error. */
static bool ode_line_take(struct ode_statements *s, const struct ode_line *line)
{
    const struct text text = line->text;
    size_t end = 0;
    if (text.data[0] == '@')
        return take_settings(s, line);
    while (end < text.len && !strchr(" =/'(", text.data[end]))
        end++;
    const struct text rest = statement_tail(text, end), name = {text.data, end};
    char mark = end < text.len ? text.data[end] : '\0';
    if (mark == ' ' && (rest.len == 0 || rest.data[0] == '='))
        mark = '=';
    if (text_is(name, "0") && mark == '=')
        return ode_error(s->ode.error, line->number, "scenes have no algebraic equations (0=)");
    switch (mark) {
    case '=':
        return text.data[0] == '!' ? take_right(s, line, ODE_DERIVED, statement_tail(name, 1), end)
                                   : take_right(s, line, ODE_FIXED, name, end);
    case '/':
        if (text.data[0] != 'd' || end < 2 || !text_starts(rest, TEXT("/dt")))
            return ode_error(s->ode.error, line->number,
                             "write an equation as dx/dt=FORMULA or x'=...");
        return take_right(s, line, ODE_VARIABLE, statement_tail(name, 1), end);
    case '\'':
        return take_right(s, line, ODE_VARIABLE, name, end);
    case '(':
        return take_call(s, line, end);
    default:
        return ode_keyword_take(s, line, end);
    }
}

/* Reads all lines s->line of the file into symbols, sets, events and settings of s. Returns false
 * with an error, also if cancelled. */
bool ode_statements(struct ode_statements *s, struct error *error)
{
    struct arena *arena = s->ode.arena;
    const size_t lines = (size_t)s->lines + 1;
    s->ode.error = error;
    s->set = arena_array(arena, lines, sizeof *s->set);
    s->event = arena_array(arena, ODE_EVENTS, sizeof *s->event);
    if (!s->set || !s->event)
        return error_memory(error);
    for (int i = 0; i < s->lines; i++) {
        if (i % ODE_LOOK == ODE_LOOK - 1 && ode_stopped(&s->ode))
            return false;
        if (!ode_line_take(s, &s->line[i]))
            return false;
    }
    return true;
}
