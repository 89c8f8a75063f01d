/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of the lines that define scenes and events, and of the expressions in them. */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/scene/typed.h>
#include <hooke/command/complete.h>
#include <hooke/command/handler.h>

#include <string.h>

/* ---- lines of a scene ---- */

/* Offers the names that expressions of the scene can use, whatever runs have been made. */
static void offer_names(struct completion *c)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < model->n; i++)
        complete_offer(c, model->variable[i].name, quantity_name(model->variable[i].quantity));
    for (int i = 0; i < model_observed(model); i++)
        complete_offer(c, model_observed_variable(model, i).name, "observed");
    complete_catalog(c, scene_params(&c->session->setup.scene));
    complete_catalog(c, &function_catalog);
}

/* Offers the names of typed lines of that kind, which a new line of the same name would replace. */
static void offer_lines(struct completion *c, enum typed_kind kind)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < typed_lines(model); i++) {
        const struct typed_line *line = typed_line(model, i);
        char name[LIMIT_NAME + 1] = "";
        if (line->kind != kind || line->name.len > LIMIT_NAME)
            continue;
        memcpy(name, line->name.data, line->name.len);
        complete_offer(c, name, "as typed last time");
    }
}

/* Returns true if the scene has a typed line of that kind. */
static bool has_line(const struct completion *c, enum typed_kind kind)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < typed_lines(model); i++)
        if (typed_line(model, i)->kind == kind)
            return true;
    return false;
}

/* Finds the text behind the first '='; returns false if there is none. */
static bool behind_equals(struct text text, struct text *value)
{
    const char *equals = memchr(text.data, '=', text.len);
    if (equals)
        *value = (struct text){equals + 1, (size_t)(text.data + text.len - equals - 1)};
    return equals;
}

/* Offers completions for the arguments of `event`: NAME when EXPR [rising|falling|touching] do
 * stop|record|COMMANDS. `rest` is the line after the word `event`, up to the cursor. */
static void complete_event(struct completion *c, struct text rest)
{
    const int words = count_words(rest);
    if (words == 0) {
        complete_events(c);
        complete_offer(c, "off", "remove all");
        return;
    }
    if (words == 1) {
        complete_offer(c, "when", "");
        complete_offer(c, "off", "remove it");
        return;
    }
    text_skip_blanks(&rest);
    struct text word = peek_word(rest, ""), value = {word.data + word.len, rest.len - word.len};
    text_skip_blanks(&value);
    if (!text_is(peek_word(value, ""), "when"))
        return;
    value = text_after(value, 4);
    struct text last = {0}, left = value;
    while (text_skip_blanks(&left), left.len > 0) {
        last = peek_word(left, "");
        const size_t used = last.len ? last.len : 1;
        left = text_after(left, used);
        if (text_is(last, "do") && text_trim(left).len > 0)
            return;
    }
    const bool turned =
        text_is(last, "rising") || text_is(last, "falling") || text_is(last, "touching");
    if (text_is(last, "do")) {
        complete_offer(c, "stop", "stop the run there");
        complete_offer(c, "record", "add a row to 'list events'");
        return;
    }
    if (!turned)
        complete_value(c, value, QUANTITY_OTHER, offer_names);
    if (last.len == 0 || value_is_open(value) || strchr("<>", last_letter(value)))
        return;
    if (!turned) {
        complete_offer(c, "rising", "when it passes 0 upwards");
        complete_offer(c, "falling", "when it passes 0 downwards");
        complete_offer(c, "touching", "also when it only touches 0");
    }
    complete_offer(c, "do", "");
}

/* Offers completions for a command that defines a line of the scene or an event; `rest` is the line
 * after the command's name, up to the cursor. Before the '=' the names of existing lines of that
 * kind are offered, behind it names for the expression; `force` and `potential` have no '=', so
 * that their expression begins at once. */
void complete_formula(struct completion *c, const struct command *command, struct text rest)
{
    const bool var = command->completes == COMPLETES_VARIABLE,
               param = command->completes == COMPLETES_PARAMETER,
               observe = command->completes == COMPLETES_OBSERVED,
               force = command->completes == COMPLETES_FORCE;
    const bool bare = force || command->completes == COMPLETES_POTENTIAL;
    struct text value = rest;
    if (command->completes == COMPLETES_EVENT) {
        complete_event(c, rest);
    } else if (behind_equals(rest, &value) || bare) {
        if (bare && text_trim(rest).len == 0 && has_line(c, force ? TYPED_FORCE : TYPED_POTENTIAL))
            complete_offer(c, "off", "remove it");
        complete_value(c, value, var || param ? QUANTITY_OTHER : QUANTITY_COUNT, offer_names);
    } else if (count_words(rest) == 0) {
        enum typed_kind kind;
        if (param)
            kind = TYPED_PARAM;
        else
            kind = observe ? TYPED_OBSERVE : TYPED_VAR;
        offer_lines(c, kind);
    } else if ((var || param || observe) && count_words(rest) == 1) {
        complete_offer(c, "off", "remove it");
    }
}
