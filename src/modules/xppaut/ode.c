/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Turns .ode files into lines of typed scenes: chooses names, applies values, and writes
 * formulas. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/base/safe_text.h>
#include "modules/xppaut/net.h"
#include "modules/xppaut/statements.h"

#include <stdio.h>
#include <string.h>

/* ---- names ---- */

/* Returns true if name is that of the initial value of the variable. */
static bool is_initial_of(struct text name, struct text variable)
{
    const char last = variable.data[variable.len - 1];
    const struct text end = last >= '0' && last <= '9' ? TEXT("_0") : TEXT("0");
    return name.len == variable.len + end.len && text_starts(name, variable) &&
           memcmp(name.data + variable.len, end.data, end.len) == 0;
}

/* Returns true if the symbol can be called name in the scene: the name is valid, is not a word of
 * the program (options->taken) and differs from other symbols and from their initial values. */
static bool is_free(const struct ode *ode, const struct ode_symbol *symbol,
                    const struct ode_options *options, struct text name)
{
    struct error ignored;
    if (!typed_name_fits(name, &ignored) || text_is(name, "t0") ||
        (options->taken && options->taken(name)))
        return false;
    for (int i = 0; i < ode->symbols; i++) {
        const struct ode_symbol *other = &ode->symbol[i];
        if (other != symbol && other->as && text_is(name, other->as))
            return false;
        if (other->kind == ODE_VARIABLE && is_initial_of(name, other->name))
            return false;
        /* a symbol that will be named later keeps its own name */
        if (other != symbol && other->kind < symbol->kind && text_equal(name, other->name))
            return false;
    }
    return true;
}

/* Chooses the name of the symbol in the scene: the one in the file, with invalid characters
 * replaced by _ and an n before a first character that is no letter, followed by _1, _2, ... if
 * that name is taken. Adds a note if the name differs from the file's. Returns false with an error.
 */
static bool choose_name(struct ode_statements *s, struct ode_symbol *symbol,
                        const struct ode_options *options)
{
    char name[LIMIT_SYMBOL + 16], plain[LIMIT_SYMBOL + 1];
    size_t len = 0;
    for (size_t i = 0; i < symbol->name.len && len + 8 < sizeof plain; i++) {
        const char c = symbol->name.data[i];
        const bool digit = c >= '0' && c <= '9', letter = c >= 'a' && c <= 'z';
        if (len == 0 && !letter)
            plain[len++] = 'n';
        plain[len++] = (char)(digit || letter ? c : '_');
    }
    plain[len] = '\0';
    snprintf(name, sizeof name, "%s", plain);
    for (int i = 1; !is_free(&s->ode, symbol, options, text_of(name)); i++) {
        if (i > 9999 || len == 0)
            return ode_error(s->ode.error, symbol->line, "no free name was found for '%.*s'",
                             (int)(symbol->name.len < 40 ? symbol->name.len : 40),
                             symbol->name.data);
        snprintf(name, sizeof name, "%s_%d", plain, i);
    }
    symbol->as = arena_text(s->ode.arena, text_of(name));
    if (!symbol->as)
        return error_memory(s->ode.error);
    char safe[SAFE_NAME_SIZE];
    return text_is(symbol->name, name) || ode_note(s, symbol->line, false, "%s is called %s here",
                                                   safe_name(symbol->name, safe), name);
}

/* Chooses the names of all symbols that are not functions. Returns false with an error. */
static bool choose_names(struct ode_statements *s, const struct ode_options *options)
{
    for (enum ode_kind kind = ODE_VARIABLE; kind < ODE_FUNCTION; kind++)
        for (int i = 0; i < s->ode.symbols; i++)
            if (s->ode.symbol[i].kind == kind && !choose_name(s, &s->ode.symbol[i], options))
                return false;
    return true;
}

/* ---- values ---- */

/* Gives variables the initial values that the file lists. Returns false with an error if a name is
 * not a variable. */
static bool set_initials(struct ode_statements *s)
{
    for (int i = 0; i < s->initials; i++) {
        const struct ode_value *initial = &s->initial[i];
        struct ode_symbol *symbol = ode_find(&s->ode, initial->name);
        if (!symbol || symbol->kind != ODE_VARIABLE)
            return ode_error(s->ode.error, initial->line, "there is no variable '%.*s'",
                             (int)(initial->name.len < 40 ? initial->name.len : 40),
                             initial->name.data);
        symbol->value = initial->value;
    }
    return true;
}

bool ode_stopped(const struct ode *ode)
{
    return cancelled(ode->cancel) &&
           !error_set(ode->error, ERROR_CANCELLED, "stopped: nothing was loaded");
}

/* Applies the NAME=VALUE pairs of a named set to parameters and initial values of variables; other
 * names are settings. Returns false with an error. */
static bool apply_set(struct ode_statements *s, const struct ode_set *set)
{
    struct text rest = set->values, name, value;
    const char *note;
    while (ode_pair(&rest, &name, &value)) {
        struct ode_symbol *symbol = ode_find(&s->ode, name);
        double number;
        if (!symbol) {
            if (!ode_setting(&s->settings, set->line, name, value, &note, s->ode.error))
                return false;
        } else if (symbol->kind != ODE_VARIABLE && symbol->kind != ODE_PARAM) {
            return ode_error(s->ode.error, set->line, "'%.*s' cannot be set",
                             (int)(name.len < 40 ? name.len : 40), name.data);
        } else {
            if (!ode_number(set->line, name, value, &number, s->ode.error))
                return false;
            symbol->value = number;
        }
    }
    return true;
}

/* Lists the names of all sets of the file in *scene and applies the one called `wanted`, unless
 * that is empty. Returns false with an error, which suggests a similar name, if there is no such
 * set. */
static bool choose_set(struct ode_statements *s, struct text wanted, struct ode_scene *scene)
{
    struct text *names = arena_array(s->ode.arena, (size_t)s->sets + 1, sizeof *names);
    if (!names)
        return error_memory(s->ode.error);
    const struct ode_set *found = NULL;
    struct suggestion suggestion = {.wanted = wanted};
    char name[SAFE_NAME_SIZE];
    for (int i = 0; i < s->sets; i++) {
        names[i] = s->set[i].name;
        suggestion_offer(&suggestion, safe_name(names[i], name));
        if (text_equal(names[i], wanted))
            found = &s->set[i];
    }
    scene->set = names;
    scene->sets = s->sets;
    if (wanted.len == 0 || found)
        return !found || apply_set(s, found);
    error_set(s->ode.error, ERROR_IO, "the file has no set '%s'", safe_name(wanted, name));
    suggestion_hint(&suggestion, s->ode.error);
    return false;
}

/* ---- lines of a scene ---- */

/* Returns the right-hand side of a symbol as a formula of typed scenes, in the arena, or NULL with
 * an error. Derived parameters and hidden quantities can read only names that are defined before
 * them. */
static const char *right_side(struct ode *ode, const struct ode_symbol *symbol)
{
    const bool ordered = symbol->kind == ODE_DERIVED || symbol->kind == ODE_FIXED;
    const struct ode_reader reader = {ode, ordered ? symbol : NULL, symbol->line};
    struct buffer text = {0};
    const char *copy = NULL;
    if (ode_formula(&reader, symbol->text, &text)) {
        ode->bytes += text.len;
        if (ode->bytes > ODE_TEXT)
            ode_error(ode->error, symbol->line, "the formulas are longer than %zu bytes", ODE_TEXT);
        else if (!(copy = arena_text(ode->arena, buffer_text(&text))))
            error_memory(ode->error);
    }
    buffer_free(&text);
    return copy;
}

/* Adds to the scene one line of kind `as` for each symbol of the given kind: with its formula for
 * equations and observed quantities, with its value for parameters and variables. Returns false
 * with an error. */
static bool add_lines(struct ode *ode, enum ode_kind kind, enum typed_kind as,
                      struct ode_scene *scene)
{
    for (int i = 0; i < ode->symbols; i++) {
        const struct ode_symbol *symbol = &ode->symbol[i];
        struct typed_line line = {.kind = as, .name = text_of(symbol->as), .order = 1};
        if (symbol->kind != kind)
            continue;
        if (ode_stopped(ode))
            return false;
        if (as == TYPED_EQUATION || as == TYPED_OBSERVE) {
            const char *copy = right_side(ode, symbol);
            if (!copy)
                return false;
            line.expr = text_of(copy);
        } else {
            line.value = symbol->value;
        }
        scene->line[scene->lines++] = line;
    }
    return true;
}

/* Reads all events. Returns false with an error. */
static bool add_events(struct ode_statements *s, struct ode_scene *scene)
{
    for (int i = 0; i < s->events; i++)
        if (!ode_event(&s->ode, &s->event[i], s->event[i].text, &scene->event[scene->events++]))
            return false;
    return true;
}

/* Notes which tables have parameters in them and keep their numbers when these are changed, as in
 * XPPAUT. Returns false with an error if out of memory. */
static bool note_tables(struct ode_statements *s)
{
    for (int i = 0; i < s->ode.symbols; i++) {
        const struct ode_symbol *symbol = &s->ode.symbol[i];
        char safe[SAFE_NAME_SIZE];
        if (symbol->kind == ODE_TABLE && symbol->table->reads &&
            !ode_note(s, symbol->line, false,
                      "the table %s keeps its numbers when its parameters change",
                      safe_name(symbol->name, safe)))
            return false;
    }
    return true;
}

/* Reads the text of a file into *scene. */
bool ode_read(struct text file, const struct ode_options *options, struct arena *arena,
              struct ode_scene *scene, struct error *error)
{
    struct ode_statements s = {.ode = {.arena = arena, .error = error, .cancel = options->cancel}};
    struct ode_line *line;
    *scene = (struct ode_scene){.lines = 0};
    *error = (struct error){.code = ERROR_NONE};
    if (!ode_lines(file, arena, &line, &s.lines, error))
        return false;
    s.line = line;
    if (!ode_statements(&s, error) || !set_initials(&s) || !choose_set(&s, options->set, scene))
        return false;
    if (s.ode.count[ODE_VARIABLE] == 0)
        return error_set(error, ERROR_IO, "there is no equation x'=FORMULA or dx/dt=FORMULA");
    struct ode *ode = &s.ode;
    scene->line = arena_array(arena, 2 * (size_t)ode->symbols + 1, sizeof *scene->line);
    scene->event = arena_array(arena, (size_t)s.events + 1, sizeof *scene->event);
    if (!scene->line || !scene->event)
        return error_memory(error);
    if (!ode_method(&s.settings, scene, error) || !choose_names(&s, options) ||
        !add_lines(ode, ODE_PARAM, TYPED_PARAM, scene) ||
        !add_lines(ode, ODE_VARIABLE, TYPED_VAR, scene) ||
        !add_lines(ode, ODE_DERIVED, TYPED_OBSERVE, scene) ||
        !add_lines(ode, ODE_FIXED, TYPED_OBSERVE, scene) ||
        !add_lines(ode, ODE_AUX, TYPED_OBSERVE, scene) ||
        !add_lines(ode, ODE_VARIABLE, TYPED_EQUATION, scene) || !add_events(&s, scene) ||
        !note_tables(&s))
        return false;
    scene->note = s.note;
    scene->notes = s.notes;
    return true;
}
