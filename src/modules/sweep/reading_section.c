/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads `at EVENT` of a sweep: an event of the session, the period of the drive, or an
 * expression. */
#include <hooke/base/statement.h>
#include <hooke/scene/formula.h>
#include <hooke/session/events.h>
#include "modules/sweep/compute/sweep.h"
#include <hooke/command/handler.h>
#include "modules/sweep/reading.h"

#include <string.h>

/* Returns the text of an event: up to the next of the keys skip=, keep=, measure=, or an option
 * with --. */
static struct text section_text(struct text rest)
{
    static const char *const keys[] = {"skip", "keep", "measure"};
    size_t end = 1;
    for (; end < rest.len; end++) {
        const struct text remaining = {rest.data + end, rest.len - end},
                          name = peek_name(remaining);
        struct text tail = {remaining.data + name.len, remaining.len - name.len};
        bool key = false;
        if (!strchr(" \t", rest.data[end - 1]))
            continue;
        text_skip_blanks(&tail);
        for (size_t k = 0; k < COUNT_OF(keys); k++)
            key |= text_is(name, keys[k]) && text_starts(tail, TEXT("="));
        if (key || text_starts(remaining, TEXT("--")))
            break;
    }
    return (struct text){rest.data, end < rest.len ? end : rest.len};
}

/* Removes `at EVENT` from the begin of *rest and returns the event's text. */
struct text next_section(struct text *rest)
{
    *rest = (struct text){rest->data + 2, rest->len - 2};
    const struct text section = section_text(*rest);
    *rest = (struct text){rest->data + section.len, rest->len - section.len};
    return text_trim(section);
}

/* ---- names: values of the point, or numbers ---- */

/* Returns the slot of a sweep for a slot of names_scope(), or < 0 if its value is constant. */
int slot_of_point(const struct expr_scope *scope, int slot)
{
    const int own = scope->moving(scope->context, slot);
    bool derived;
    const int place = names_of_scene(slot, &derived);
    if (own >= 0 || place < 0)
        return own;
    return place + (int)(derived ? SWEEP_SLOT_DERIVED : SWEEP_SLOT_PARAM);
}

/* Calls slot_of_point() for expr_settle(). */
static int point_slot(void *context, int slot)
{
    return slot_of_point(context, slot);
}

/* Compiles an expression for all points: names that do not depend on the point become numbers.
 * Returns NULL with an error if out of memory. */
static const struct expr *expr_of_point(const struct expr *expr, struct expr_scope *scope,
                                        struct arena *arena, struct error *error)
{
    const struct expr *settled = expr_settle(expr, scope, point_slot, scope, arena);
    if (!settled)
        error_memory(error);
    return settled;
}

/* ---- what is typed ---- */

/* Reads what follows the left side of EXPR = EXPR, or of EXPR rising VALUE, into the event's right
 * side and direction. Returns false with an error, also if both sides have a direction or a
 * comparison. */
static bool read_side(struct parser *parser, const struct expr_scope *scope, struct event *event,
                      struct error *error)
{
    struct event other = {.stop = false};
    size_t used;
    if (!event_compile(parser->rest, scope, parser->arena, &other, &used, error))
        return names_explain(parser->session, error);
    const bool turns = other.direction != 0 || other.touching;
    if (other.right || (turns && (event->direction != 0 || event->touching)))
        return error_at(error, parser->rest, "both sides of a section must be expressions");
    if (!expr_compare(event->left, &other.left, parser->arena, error))
        return false;
    event->right = other.left;
    event->direction = turns ? other.direction : event->direction;
    event->touching |= other.touching;
    parser->rest = text_trim(text_after(parser->rest, used));
    return true;
}

/* Reads an event from the parser's text, to its end. Returns false with an error. */
static bool read_event_text(struct parser *parser, const struct expr_scope *scope,
                            struct event *event, struct error *error)
{
    size_t used;
    const struct text all = parser->rest;
    if (!event_compile(all, scope, parser->arena, event, &used, error))
        return names_explain(parser->session, error);
    parser->rest = text_trim(text_after(all, used));
    const bool equals = text_starts(parser->rest, TEXT("="));
    if (equals && !event->right)
        parser->rest = text_trim(text_after(parser->rest, 1));
    if (!event->right && (equals || (event->direction != 0 && parser->rest.len > 0)) &&
        !read_side(parser, scope, event, error))
        return false;
    return refuse_rest(parser, NULL, error);
}

/* Reads an event and compiles it for all points of the sweep: that of a line of the session, or if
 * `line` is NULL that of the parser's text. Returns false with an error. */
static bool read_event_in(struct parser *parser, struct expr_scope *scope,
                          const struct event_line *line, struct event *event, struct error *error)
{
    if (line)
        parser->rest = text_of(line->when);
    if (!read_event_text(parser, scope, event, error)) {
        if (line) {
            error->where = (struct text){NULL, 0};
            error_hint(error, "in the event %s", line->name);
        }
        return false;
    }
    event->left = expr_of_point(event->left, scope, parser->arena, error);
    if (event->left && event->right)
        event->right = expr_of_point(event->right, scope, parser->arena, error);
    else if (event->left)
        return true;
    return event->left && event->right;
}

/* Reads an event in a scope that knows the names of a run, which replaces the parser's scope
 * meanwhile. Returns false with an error. */
static bool read_event_of(struct parser *parser, const struct event_line *line, struct event *event,
                          struct error *error)
{
    const struct names names = {
        .session = parser->session, .expects_run = true, .saved_only = line != NULL};
    const struct expr_scope *saved = parser->scope;
    struct expr_scope scope = names_scope(&names);
    parser->scope = &scope;
    const bool ok = read_event_in(parser, &scope, line, event, error);
    parser->scope = saved;
    return ok;
}

/* Returns true if the scene has a drive with one period; otherwise sets an error. */
static bool is_driven(const struct session *session, struct text where, struct error *error)
{
    struct system system;
    if (!scene_bind_motion(&session->setup.scene, &system, error))
        return false;
    if (system_drive(&system) > 0)
        return true;
    error_at(error, where, "this scene has no drive with a period");
    return error_hint(error,
                      "a section may also be where an expression passes a value: at v = 0 falling");
}

/* Reads the event of a section: the word `period` (once per period of the drive, section->strobe),
 * the name of an event of the session, or an expression. Returns false with an error. */
bool read_section(struct session *session, const struct arguments *args, struct text text,
                  struct sweep_section *section, struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, text};
    const struct events *events = session->setup.events;
    const struct event_line *line = NULL;
    if (text.len == 0)
        return error_at(error, text, "'at' needs an event: at period, at v = 0 falling");
    for (int i = 0; events && i < events->count; i++)
        if (text_is(text, events->line[i].name))
            line = &events->line[i];
    section->wanted = true;
    section->text = arena_text(args->arena, text);
    if (!section->text)
        return error_memory(error);
    section->strobe = !line && text_is(text, "period");
    return section->strobe ? is_driven(session, text, error)
                           : read_event_of(&parser, line, &section->event, error);
}

/* ---- what is kept there ---- */

/* Makes all state variables the measures. Returns false with an error. */
static bool all_variables(const struct model *model, struct sweep_request *request,
                          struct error *error)
{
    request->measures = 0;
    for (int k = 0; k < model->n && k < SWEEP_MEASURES; k++)
        if (!sweep_measure_find(model, text_of(model->variable[k].name),
                                &request->measure[request->measures++], error))
            return false;
    return true;
}

/* Sets usual values of skip= and keep= where not given, and checks the section. Without `measured`
 * (no measure= was typed) all variables are recorded. Returns false with an error. */
bool finish_section(struct sweep_request *request, bool measured, struct error *error)
{
    const struct sweep_section *section = &request->section;
    if (!section->wanted)
        return section->skip < 0 && section->keep < 0
                   ? true
                   : error_set(
                         error, ERROR_COMMAND,
                         "skip= and keep= work only with sections: sweep ... at period skip=100");
    request->section.skip = section->skip < 0 ? SWEEP_SKIP_USUAL : section->skip;
    request->section.keep = section->keep < 0 ? SWEEP_KEEP_USUAL : section->keep;
    if (section->skip + section->keep > LIMIT_EVENT_RECORDS)
        return error_set(error, ERROR_COMMAND, "the sum of skip= and keep= must be at most %d",
                         LIMIT_EVENT_RECORDS);
    if (request->columns > 0)
        return error_set(error, ERROR_COMMAND,
                         "at a section only columns can be kept, not expressions: measure=%s",
                         request->scene->model->variable[0].name);
    for (int m = 0; m < request->measures && measured; m++)
        if (!sweep_at_section(&request->measure[m])) {
            error_set(error, ERROR_COMMAND, "'%s' has no value at a single moment",
                      sweep_measure_name(&request->measure[m]));
            return error_hint(error, "at a section only columns can be kept: measure=%s",
                              request->scene->model->variable[0].name);
        }
    return measured || all_variables(request->scene->model, request, error);
}
