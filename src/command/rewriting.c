/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recognises the notation of other programs (m: 0.2, y(0) = 5, quit(), np.sin(x), dx/dt = v) and
 * translates it for hints. */
#include <hooke/base/statement.h>
#include <hooke/scene/typed.h>
#include "command/finding.h"
#include <hooke/command/handler.h>

#include <stdio.h>
#include <string.h>

/* Returns the text behind `sign`, which has to come first, or {NULL, 0} if it does not. */
static struct text behind_sign(struct text text, const char *sign)
{
    text_skip_blanks(&text);
    return text_starts(text, text_of(sign)) ? text_behind(text, strlen(sign))
                                            : (struct text){NULL, 0};
}

/* Appends the suggestion 'NAME = VALUE'. */
static void put_suggested(struct buffer *text, const char *name, struct text value)
{
    value = text_trim(value);
    buffer_format(text, "'%s%s%.*s'", name, value.len ? " = " : "", (int)value.len, value.data);
}

/* Returns the name of a number that `NAME = VALUE` can set, or NULL. */
static const char *settable(const struct session *session, struct text name)
{
    const struct catalog *const catalogs[] = {scene_params(&session->setup.scene),
                                              scene_derived(&session->setup.scene),
                                              &setting_catalog};
    const struct row *row = NULL;
    for (size_t i = 0; i < COUNT_OF(catalogs) && !row; i++)
        row = catalog_find(catalogs[i], name);
    return row ? row->name : NULL;
}

/* Returns the parameter for the initial value of a variable, or NULL: y0 or y_0 (vy0 or vy_0 for
 * y'), else v0 for any velocity. */
const char *start_of(const struct session *session, struct text name)
{
    const struct scene *scene = &session->setup.scene;
    const struct model *model = scene->model;
    char parameter[LIMIT_NAME + 4];
    const bool primed = name.len > 1 && name.data[name.len - 1] == '\'';
    name.len -= primed;
    if (name.len == 1 && strchr("xyzqu", name.data[0]) && model_variable(model, name) < 0 &&
        model->n > 0)
        name = text_of(model->variable[0].name);
    if (name.len > LIMIT_NAME || model_variable(model, name) < 0)
        return NULL;
    static const char *const endings[] = {"0", "_0"};
    for (size_t i = 0; i < COUNT_OF(endings); i++) {
        snprintf(parameter, sizeof parameter, "%s%.*s%s", primed ? "v" : "", (int)name.len,
                 name.data, endings[i]);
        const int index = scene_param(scene, parameter);
        if (index >= 0)
            return param_at(scene, index)->row.name;
    }
    const int v0 = primed ? scene_param(scene, "v0") : -1;
    return v0 < 0 ? NULL : param_at(scene, v0)->row.name;
}

/* Translates initial values: y(0) = 5 cm, y[0] = 5 cm, y'(0) = 0. Returns false for other
 * statements. */
static bool put_start(const struct session *session, struct text statement, struct buffer *text)
{
    struct text name = peek_name(statement);
    if (name.len < statement.len && statement.data[name.len] == '\'')
        name.len++;
    struct text rest = text_behind(statement, name.len);
    rest = rest.len > 0 && strchr("([", rest.data[0]) ? behind_sign(text_behind(rest, 1), "0")
                                                      : (struct text){NULL, 0};
    if (!rest.data || rest.len == 0 || !strchr(")]", rest.data[0]))
        return false;
    const struct text value = behind_sign(text_behind(rest, 1), "=");
    const char *start = value.data ? start_of(session, name) : NULL;
    if (start)
        put_suggested(text, start, value);
    return start;
}

/* Translates assignments: m 0.2, m: 0.2, m := 0.2; par gamma = 0.2, init y = 0.05, @ dt = 0.01.
 * Returns false for other statements. */
static bool put_assignment(const struct session *session, struct text statement,
                           struct buffer *text)
{
    const struct text word = peek_word(statement, ":="), name = peek_name(word),
                      rest = text_behind(statement, word.len);
    struct text value = rest, inner = peek_name(rest);
    while (value.len > 0 && strchr(":= \t", value.data[0]))
        value = text_behind(value, 1);
    const char *known = settable(session, name);
    if (known && name.len == word.len && value.len > 0 && strchr("0123456789.+-", value.data[0])) {
        put_suggested(text, known, value);
        return true;
    }
    value = inner.len ? behind_sign(text_behind(rest, inner.len), "=") : (struct text){NULL, 0};
    known = value.data ? settable(session, inner) : NULL;
    if (value.data && !known)
        known = start_of(session, inner);
    if (known)
        put_suggested(text, known, value);
    const struct row *row = known || !value.data || catalog_find(&word_catalog, word)
                                ? NULL
                                : catalog_find(&word_catalog, inner);
    buffer_put(text, row ? text_of(row->brief) : TEXT(""));
    return known || row;
}

/* Returns the number of characters from `begin` on that are among `characters`. */
static size_t text_span_length(struct text text, size_t begin, const char *characters)
{
    size_t len = 0;
    while (begin + len < text.len && strchr(characters, text.data[begin + len]))
        len++;
    return len;
}

/* Translates equations: dx/dt = EXPR, d2x/dt2 = EXPR, d^2x/dt^2 = EXPR; advises on x'' + x = 0.
 * Returns false for other statements. */
static bool put_equation(struct text statement, struct buffer *text)
{
    const struct text word = peek_word(statement, "=");
    struct text name = peek_name(statement);
    const size_t primes = text_span_length(statement, name.len, "'");
    if (name.len > 0 && (primes == 1 || primes == 2) &&
        memchr(statement.data, '=', statement.len)) {
        const int shown = (int)(name.len + primes);
        buffer_format(text, "write only %.*s on the left side: %.*s = EXPR", shown, name.data,
                      shown, name.data);
        return true;
    }
    const char *slash = memchr(word.data, '/', word.len);
    const size_t power = text_span_length(word, 1, "^2");
    if (!slash || word.data[0] != 'd' || slash + 2 >= word.data + word.len || slash[1] != 'd' ||
        slash <= word.data + 1 + power)
        return false;
    name = (struct text){word.data + 1 + power, (size_t)(slash - word.data) - 1 - power};
    const struct text value = behind_sign(text_behind(statement, word.len), "=");
    const int shown = (int)name.len;
    const char *marks = power ? "\'\'" : "\'";
    if (peek_name(name).len < name.len)
        return false;
    buffer_format(text, "an equation is written %.*s%s = EXPR", shown, name.data, marks);
    if (value.len > 0)
        buffer_format(text, ": %.*s%s = %.*s", shown, name.data, marks, (int)value.len, value.data);
    return true;
}

/* Returns the name of the function that the statement calls, such as plot of plt.plot(t, y) or
 * ode45 of [t,y] = ode45(..). Sets *whole to the call without prefix and *arguments to the text in
 * its parentheses. Returns {NULL, 0} if nothing is called. */
static struct text called(struct text statement, struct text *whole, struct text *arguments)
{
    const char *end = statement.len && statement.data[0] == '['
                          ? memchr(statement.data, ']', statement.len)
                          : NULL;
    if (end)
        statement = behind_sign(text_behind(statement, (size_t)(end + 1 - statement.data)), "=");
    struct text name = statement.data ? peek_name(statement) : (struct text){NULL, 0};
    struct text rest = name.len ? text_behind(statement, name.len) : name;
    while (name.len > 0 && rest.len > 1 && rest.data[0] == '.' && is_name_start(rest.data[1])) {
        name = peek_name(text_behind(rest, 1));
        rest = (struct text){name.data + name.len,
                             (size_t)(statement.data + statement.len - name.data) - name.len};
    }
    size_t close = rest.len;
    while (close > 0 && rest.data[close - 1] != ')')
        close--;
    if (name.len == 0 || rest.len == 0 || rest.data[0] != '(' || close < 2)
        return (struct text){NULL, 0};
    *arguments = text_trim((struct text){rest.data + 1, close - 2});
    *whole = (struct text){name.data, (size_t)(rest.data + close - name.data)};
    return name;
}

/* Translates calls of functions: quit(), plot(t, y), np.sin(x). Returns false for other
 * statements. */
static bool put_call(struct text statement, struct buffer *text)
{
    struct text whole, arguments = {NULL, 0};
    const struct text name = called(statement, &whole, &arguments);
    const struct row *command = name.len ? catalog_find(&command_catalog, name) : NULL;
    if (name.len && !command && catalog_find(&function_catalog, name))
        buffer_format(text, "'print %.*s'", (int)whole.len, whole.data);
    if (!command)
        return text->len > 0;
    const struct text horizontal = peek_name(arguments),
                      vertical = behind_sign(text_behind(arguments, horizontal.len), ",");
    if (strcmp(command->name, "plot") == 0 && horizontal.len && vertical.data &&
        peek_name(vertical).len)
        buffer_format(text, "'plot %.*s against %.*s'", (int)peek_name(vertical).len, vertical.data,
                      (int)horizontal.len, horizontal.data);
    else
        buffer_format(text, "'%s%s%.*s'", command->name, arguments.len ? " " : "",
                      (int)arguments.len, arguments.data);
    return true;
}

struct text called_word(struct text statement)
{
    struct text whole, arguments;
    return called(statement, &whole, &arguments);
}

/* Translates statements such as "method: rk4". Returns false for other statements. */
static bool put_command(struct text statement, struct buffer *text)
{
    const struct text name = peek_name(statement), rest = text_behind(statement, name.len);
    const struct row *row = name.len ? catalog_find(&command_catalog, name) : NULL;
    if (!row || rest.len < 2 || rest.data[0] != ':')
        return false;
    const struct text value = text_behind(rest, 1 + text_span_length(rest, 1, "="));
    buffer_format(text, "'%s %.*s'", row->name, (int)value.len, value.data);
    return true;
}

/* Appends the statement in this program's notation, by the first translation that fits. Returns
 * false if none does. */
bool put_rewritten(const struct session *session, struct text statement, struct buffer *text)
{
    return put_start(session, statement, text) || put_equation(statement, text) ||
           put_call(statement, text) || put_command(statement, text) ||
           put_assignment(session, statement, text);
}

/* Suggests param in equations, with the value of a variable of let if there is one, else let. */
void put_named(const struct session *session, bool law, struct text name, struct buffer *text)
{
    const struct setup *setup = &session->setup;
    const char *kind;
    struct error ignored;
    struct buffer value = {0};
    if (law ? !typed_name_fits(name, &ignored) : name_is_taken(session, name, &kind))
        return;
    for (int i = 0; law && i < setup->lets; i++)
        if (text_is(name, setup->let[i].name))
            buffer_measured(&value,
                            (struct measured){setup->let[i].value, setup->let[i].uncertainty},
                            setup->let[i].quantity, setup->settings.digits);
    const char *const shown = value.len ? buffer_view(&value) : "VALUE";
    if (law)
        buffer_format(text, "'param %.*s = %s' defines it for equations", (int)name.len, name.data,
                      shown);
    else
        buffer_format(text, "'let %.*s = %s' defines it here", (int)name.len, name.data, shown);
    buffer_free(&value);
}

/* Appends the text with NAME, VALUE and EXPR replaced by what the statement has: the arguments of a
 * call, or NAME = VALUE behind its first word. */
void put_filled(const char *brief, struct text statement, struct buffer *text)
{
    static const char *const words[] = {"NAME", "VALUE", "EXPR"};
    struct text whole, arguments = {NULL, 0}, name = {NULL, 0}, value = {NULL, 0};
    if (called(statement, &whole, &arguments).len == 0) {
        const struct text rest = text_behind(statement, peek_word(statement, "").len);
        name = peek_name(rest);
        value = name.len ? behind_sign(text_behind(rest, name.len), "=") : value;
    }
    const struct text fill[] = {value.data ? name : value, value,
                                arguments.len && arguments.data[0] != '"' ? arguments : value};
    while (*brief) {
        size_t used = 0;
        for (size_t i = 0; i < COUNT_OF(words) && used == 0; i++)
            if (fill[i].len > 0 && text_starts(text_of(brief), text_of(words[i]))) {
                used = strlen(words[i]);
                buffer_put(text, fill[i]);
            }
        if (used == 0)
            buffer_char(text, *brief);
        brief += used ? used : 1;
    }
}
