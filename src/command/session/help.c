/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands help and apropos. */
#ifndef COMMAND_ROWS
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/method/coefficients.h>
#include <hooke/report.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>
#include "command/finding.h"
#include "command/session/topics.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>

#define HELP_WIDTH 80 /* [cell] width of help without a terminal */

/* ---- help for one thing ---- */

/* Appends the lines, indented by two spaces. */
static void put_indented(struct buffer *text, const char *lines)
{
    struct text rest = text_of(lines), line;
    while (text_split(&rest, '\n', &line))
        if (line.len > 0)
            buffer_format(text, "  %.*s\n", (int)line.len, line.data);
}

/* Appends the choices of arguments that are too many for the usage. */
static void put_choices(const struct command *command, struct buffer *text)
{
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        const struct catalog *choices = argument->choices;
        bool shown = false;
        for (int k = 0; k < i; k++)
            shown |= command->argument[k].choices == choices;
        if (shown || !choices || choices->count <= USAGE_CHOICES || choices->count > HELP_CHOICES)
            continue;
        buffer_format(text, "\n%s:", argument->name);
        for (size_t k = 0; k < choices->count; k++)
            buffer_format(text, "%s %s", k ? "," : "", catalog_row(choices, k)->name);
    }
}

/* Explains a command: usage, text, examples, related commands. */
static void help_command(const struct row *row, struct buffer *text)
{
    const struct command *command = command_at(row);
    buffer_put(text, TEXT("usage: "));
    command_usage(command, text);
    buffer_format(text, "\n%s", row->brief);
    if (row->alias)
        buffer_format(text, " (also: %s)", row->alias);
    buffer_char(text, '\n');
    buffer_put(text, text_of(command->text));
    put_choices(command, text);
    buffer_put(text, TEXT("\nexamples:\n"));
    put_indented(text, command->examples);
    buffer_put(text, TEXT("see also:"));
    struct text see = text_of(command->see), word;
    while (text_split(&see, ' ', &word))
        if (catalog_find(&command_catalog, word)) /* not of a module that was left out */
            buffer_format(text, " %.*s", (int)word.len, word.data);
}

/* Appends "NAME [UNIT], KIND of MODEL: BRIEF" for a row; the oscillator is not named as model. */
static void put_kind(struct buffer *text, const struct row *row, const char *kind,
                     const struct model *model)
{
    buffer_format(text, "%s [%s], %s", row->name, *row->unit ? row->unit : "1", kind);
    if (model != &oscillator_model)
        buffer_format(text, " of %s", model->row.name);
    buffer_format(text, ": %s\n", row->brief);
}

/* Explains a parameter: default, limit, units. */
static void help_param(const struct model *model, const struct row *row, struct buffer *text)
{
    const struct param_row *param = (const struct param_row *)(const void *)row;
    put_kind(text, row, "a parameter", model);
    buffer_put(text, TEXT("default "));
    buffer_quantity(text, param->initial, param->quantity, 0);
    if (isfinite(param->min))
        buffer_format(text, ", %s %g", param->min_excluded ? "more than" : "at least", param->min);
    struct buffer units = {0};
    quantity_units(param->quantity, &units);
    if (units.len > 0)
        buffer_format(text, "; units: %s", buffer_view(&units));
    struct buffer value = {0};
    buffer_quantity(&value, param->initial, param->quantity, 0);
    buffer_format(text, "\nexamples:\n  %s = %s\n  show %s\nsee also: set show", row->name,
                  buffer_view(&value), row->name);
    buffer_free(&value);
    buffer_free(&units);
}

/* Explains a derived quantity. */
static void help_derived(const struct model *model, const struct row *row, struct buffer *text)
{
    const struct derived_row *derived = (const struct derived_row *)(const void *)row;
    put_kind(text, row, "a derived quantity", model);
    if (derived->inverse)
        buffer_format(text, "setting it sets %s\n", derived->target);
    buffer_format(text, "examples:\n  print %s\n  show %s\nsee also: show set", row->name,
                  row->name);
}

/* Explains a setting: default and choices. */
static void help_setting(const struct row *row, struct buffer *text)
{
    const struct setting *setting = setting_from(row);
    struct settings defaults;
    session_default_settings(&defaults);
    buffer_format(text, "%s, a setting: %s\ndefault ", row->name, row->brief);
    setting_show(setting, &defaults, text);
    for (size_t i = 0; setting->choices && i < setting->choices->count; i++)
        buffer_format(text, "\n  %-8s %s", catalog_row(setting->choices, i)->name,
                      catalog_row(setting->choices, i)->brief);
    buffer_format(text, "\nexamples:\n  set %s ", row->name);
    setting_exact(setting, &defaults, text);
    buffer_format(text, "\n  show %s\nsee also: set unset show", row->name);
}

/* Appends the largest stable step of the method on the undamped oscillator. */
static void put_stable_limit(const struct method *method, struct buffer *text)
{
    enum drag drag = DRAG_DEFAULT;
    struct system system;
    struct scene scene;
    struct error ignored;
    scene_init(&scene, NULL);
    if (!scene_bind(&scene, &system, &ignored) || !method_applies(method, &system, &drag, &ignored))
        return;
    const double limit = method_stable_limit(method, drag, 0);
    if (isnan(limit)) /* it chooses its own steps */
        return;
    buffer_put(text, TEXT("\nstability: on the undamped oscillator "));
    if (isinf(limit))
        buffer_put(text, TEXT("stable for every dt"));
    else if (limit == 0)
        buffer_put(text, TEXT("no dt is stable"));
    else {
        buffer_put(text, TEXT("stable for omega0 dt < "));
        buffer_short(text, limit, 5);
    }
}

/* Appends a method's help: formula, coefficients, order, properties, drag variants, source. */
static void help_method(const struct row *row, struct buffer *text)
{
    static const struct {
        unsigned flag;
        const char *word;
    } words[] = {{METHOD_IMPLICIT, "implicit"},
                 {METHOD_SYMPLECTIC, "symplectic"},
                 {METHOD_SYMMETRIC, "symmetric (reversible)"},
                 {METHOD_ENERGY, "conserves the energy of a linear oscillator"},
                 {METHOD_A_STABLE, "A-stable"},
                 {METHOD_L_STABLE, "L-stable"},
                 {METHOD_ADAPTIVE, "adaptive"},
                 {METHOD_EXACT, "exact"},
                 {METHOD_EXTERNAL, "an external solver, not part of hooke"}};
    const struct method *method = method_from(row);
    struct coefficient_row row_of;
    buffer_format(text, "%s, a method: %s\n", row->name, row->brief);
    put_indented(text, method->formula);
    if (!coefficients_text(method, HELP_WIDTH, text) && method_coefficients(method, 0, &row_of))
        buffer_format(text, "coefficients: export method %s FILE.csv\n", row->name);
    if (method->order > 0)
        buffer_format(text, "%s %d", method->flags & METHOD_EXTERNAL ? "orders up to" : "order",
                      method->order);
    else
        buffer_put(text, TEXT("exact"));
    buffer_format(text, ", %d force evaluation%s per step", method->evals,
                  method->evals == 1 ? "" : "s");
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (method->flags & words[i].flag)
            buffer_format(text, ", %s", words[i].word);
    put_stable_limit(method, text);
    for (enum drag d = DRAG_EXACT; d < DRAG_COUNT; d++)
        if (method->drags & (1u << d)) {
            buffer_put(text, method->drags & ((1u << d) - 1) ? TEXT(", ") : TEXT("\ndrag: "));
            buffer_put(text, text_of(catalog_row(&drag_catalog, (size_t)d - 1)->name));
            buffer_put(text, d == method->drag ? TEXT(" (default)") : TEXT(""));
        }
    if (*row->citation)
        buffer_format(text, "\nsource: %s", row->citation);
    buffer_format(text,
                  "\nexamples:\n  method %s\n  compare euler %s\nsee also: method list compare",
                  row->name, row->name);
}

/* Explains a unit and lists others of the same quantity. */
static void help_unit(const struct row *row, struct buffer *text)
{
    const struct unit *unit = unit_from(row);
    struct buffer units = {0};
    quantity_units(unit->quantity, &units);
    buffer_format(text, "%s, a unit of %s: %s = ", row->name, quantity_name(unit->quantity),
                  row->brief);
    buffer_real(text, unit->factor);
    buffer_format(text,
                  " %s\nunits of %s: %s\nexamples:\n  print 1 %s\n  list units\nsee also: set",
                  row->unit, quantity_name(unit->quantity), buffer_view(&units), row->name);
    buffer_free(&units);
}

static void help_observable(const struct row *row, struct buffer *text)
{
    buffer_format(text,
                  "%s [%s], of a run: %s\nexamples:\n  run; print %s\n  run; export run.csv "
                  "t,%s\nsee also: export print run",
                  row->name, *row->unit ? row->unit : "1", row->brief, row->name, row->name);
}

/* Explains a preset: state variables and parameters. */
static void help_preset(const struct row *row, struct buffer *text)
{
    const struct preset *preset = preset_from(row);
    const struct model *model = preset->model ? preset->model : &oscillator_model;
    buffer_format(text, "%s, a scene: %s\n  state", row->name, row->brief);
    for (int i = 0; i < model->n; i++)
        buffer_format(text, "%s %s", i ? "," : "", model->variable[i].name);
    for (size_t i = 0; i < COUNT_OF(preset->value) && preset->value[i].param; i++) {
        const struct param_row *param = (const struct param_row *)(const void *)catalog_find(
            model->params, text_of(preset->value[i].param));
        buffer_format(text, "%s%s = ", i ? ", " : "\n  ", preset->value[i].param);
        buffer_quantity(text, preset->value[i].value, param->quantity, 0);
    }
    if (*row->citation)
        buffer_format(text, "\nsource: %s", row->citation);
    buffer_format(text, "\nexamples:\n  scene %s\n  scene %s; plan\nsee also: scene list",
                  row->name, row->name);
}

/* Appends the guide, but only its lines if a command or a method of that name has been
 * explained. */
static void help_guide(const struct row *row, struct buffer *text)
{
    const struct guide_topic *topic = (const struct guide_topic *)(const void *)row;
    if (text->len > 0)
        buffer_put(text, TEXT("the lines of this topic:\n"));
    else
        buffer_format(text, "%s: %s\n%s\n", row->name, row->brief, topic->text);
    put_indented(text, topic->recipe);
    buffer_format(text, "'recipe %s' runs them", row->name);
}

/* Catalogs that help explains, and the function that explains a row. */
static const struct topic {
    const struct catalog *catalog;
    void (*help)(const struct row *row, struct buffer *text); /* NULL if one line is enough */
} topics[] = {
    {&command_catalog, help_command},
    {&setting_catalog, help_setting},
    {&method_catalog, help_method},
    {&observable_catalog, help_observable},
    {&preset_catalog, help_preset},
    {&unit_catalog, help_unit},
    {&quantity_catalog, NULL},
    {&function_catalog, NULL},
    {&plot_catalog, NULL},
    {&drag_catalog, NULL},
    {&layout_catalog, NULL},
    {&snap_catalog, NULL},
    {&term_catalog, NULL},
    {&table_format_catalog, NULL},
    {&result_catalog, NULL},
    {&guide_catalog, help_guide},
    {&word_catalog, NULL},
};

/* Returns the i-th topic: those above, then those of modules, then one without a catalog. */
static struct topic topic_at(size_t i)
{
    if (i < COUNT_OF(topics))
        return topics[i];
    i -= COUNT_OF(topics);
    for (const struct module *const *module = module_list; *module; module++)
        for (const struct catalog *const *own = (*module)->catalogs; own && *own; own++)
            if (i-- == 0)
                return (struct topic){*own, NULL};
    return (struct topic){NULL, NULL};
}

const struct catalog *help_catalog(int i)
{
    return topic_at((size_t)i).catalog;
}

/* Explains a row, in one line if its catalog has no function. */
static void help_topic(const struct topic *topic, const struct row *row, struct buffer *text)
{
    buffer_put(text, text->len ? TEXT("\n\n") : TEXT(""));
    if (topic->help)
        topic->help(row, text);
    else
        buffer_format(text, "%s (%s): %s%s%s", row->name, topic->catalog->kind, row->brief,
                      *row->citation ? "\nsource: " : "", row->citation);
}

/* Replies with lines broken to the width, but not indented ones, nor any if a log pane breaks
 * them. */
static void reply_wrapped(const struct session *session, struct text text, struct reply *reply)
{
    const int width = session->front.width ? session->front.width : HELP_WIDTH;
    struct buffer output = {0};
    struct text line;
    int indent;
    if (session->front.watched) {
        reply_text(reply, text);
        return;
    }
    while (text_split(&text, '\n', &line)) {
        const int columns = text_starts(line, TEXT("  ")) ? INT_MAX : width;
        size_t begin = 0;
        do {
            const struct text row = log_row(line, &begin, columns, &indent);
            buffer_format(&output, "%*s%.*s\n", indent, "", (int)row.len, row.data);
        } while (begin < line.len);
    }
    reply_text(reply, buffer_text(&output));
    buffer_free(&output);
}

/* ---- names of models ---- */

/* Explains a name of the model: in full if *known is not set yet, else in a line. */
static void help_model(const struct model *model, struct text name, bool *known,
                       struct buffer *text)
{
    const struct catalog *const own[] = {model->params, model->derived};
    const int variable = model_variable(model, name);
    for (size_t i = 0; i < COUNT_OF(own); i++) {
        const struct row *row = catalog_find(own[i], name);
        if (!row)
            continue;
        if (*known) {
            buffer_format(text, "\n%s of %s: %s", own[i]->kind, model->row.name, row->brief);
            continue;
        }
        buffer_put(text, text->len ? TEXT("\n\n") : TEXT(""));
        (i == 0 ? help_param : help_derived)(model, row, text);
        *known = true;
    }
    if (variable >= 0 && model != &oscillator_model) { /* y and v are observables, too */
        const struct variable *moves = &model->variable[variable];
        const char *const unit = quantity_unit(moves->quantity);
        buffer_put(text, text->len ? TEXT("\n") : TEXT(""));
        buffer_format(text, "%s [%s], a state variable of %s", moves->name, *unit ? unit : "1",
                      model->row.name);
    }
    for (int i = 0; i < typed_lines(model); i++) {
        const struct typed_line *line = typed_line(model, i);
        if (line->kind != TYPED_OBSERVE || !text_equal(line->name, name))
            continue;
        buffer_put(text, text->len ? TEXT("\n") : TEXT(""));
        typed_describe(line, text);
    }
}

/* Explains the name in all models, the present one first, and offers their names as suggestions. */
static void help_models(const struct model *present, struct text name,
                        struct suggestion *suggestion, struct buffer *text)
{
    bool known = false;
    help_model(present, name, &known, text);
    for (const struct model *const *model = scene_models; *model; model++) {
        if (*model != present)
            help_model(*model, name, &known, text);
        for (size_t i = 0; i < (*model)->params->count; i++)
            suggestion_offer(suggestion, catalog_row((*model)->params, i)->name);
        for (size_t i = 0; i < (*model)->derived->count; i++)
            suggestion_offer(suggestion, catalog_row((*model)->derived, i)->name);
    }
}

/* Collects what all catalogs know of the word; suggests similar words if they know nothing. */
HANDLER(help)
{
    const struct argument_value *word = argument_value(args, "WORD");
    const struct command *topic_command = NULL;
    struct suggestion suggestion = {
        .wanted = word->count ? help_topic_of(word->item->text, &topic_command) : TEXT("")};
    struct buffer text = {0};
    const struct row *guide = word->count ? catalog_find(&guide_catalog, suggestion.wanted) : NULL;
    session->view.recipe = guide ? guide->name : NULL;
    if (word->count == 0 || text_is(suggestion.wanted, "commands")) {
        (word->count ? help_commands : help_all)(&text);
        reply_wrapped(session, buffer_text(&text), reply);
        buffer_free(&text);
        return true;
    }
    /* the first guide has priority over a command of that name */
    const bool begins = guide && guide == catalog_row(&guide_catalog, 0);
    if (begins)
        help_guide(guide, &text);
    if (topic_command)
        help_given(topic_command, &suggestion.wanted, &text);
    struct topic topic;
    for (size_t i = 0; suggestion.wanted.len > 0 && (topic = topic_at(i)).catalog; i++) {
        const struct row *row = catalog_find(topic.catalog, suggestion.wanted);
        if (row && !(begins && row == guide))
            help_topic(&topic, row, &text);
        for (size_t j = 0; j < topic.catalog->count; j++)
            suggestion_offer(&suggestion, catalog_row(topic.catalog, j)->name);
        if (i == 0) /* commands, then parameters */
            help_models(session->setup.scene.model, suggestion.wanted, &suggestion, &text);
    }
    if (text.len == 0 && topic_command && !suggestion.count)
        help_topic(&topics[0], &topic_command->row, &text); /* a value: what takes it */
    const bool found = text.len > 0;
    if (found)
        reply_wrapped(session, buffer_text(&text), reply);
    buffer_free(&text);
    if (found)
        return true;
    for (size_t i = 0; topic_at(i).catalog; i++)
        if (catalog_absent(topic_at(i).catalog, suggestion.wanted, error))
            return false;
    char name[LIMIT_NAME + 1];
    snprintf(name, sizeof name, "%.*s",
             (int)(suggestion.wanted.len < LIMIT_NAME ? suggestion.wanted.len : LIMIT_NAME),
             suggestion.wanted.data);
    if (!module_is_in(name, suggestion.wanted, error))
        return false;
    error_at(error, suggestion.wanted, "there is no help for '%.*s'",
             (int)(suggestion.wanted.len < 64 ? suggestion.wanted.len : 64),
             suggestion.wanted.data);
    error->unknown = "";
    suggestion_hint(&suggestion, error);
    if (catalog_find(&list_catalog, suggestion.wanted))
        error_hint(error, "'list %.*s' shows them", (int)suggestion.wanted.len,
                   suggestion.wanted.data);
    return error_hint(error, "('apropos WORD' searches, 'help' lists the commands)");
}

/* ---- apropos ---- */

/* Returns true if each of the words occurs in the row's name, description, source or text. */
static bool row_mentions(const struct catalog *catalog, const struct row *row, struct text words)
{
    const char *text;
    if (catalog == &command_catalog)
        text = command_at(row)->text;
    else
        text = catalog == &guide_catalog ? ((const struct guide_topic *)(const void *)row)->text
                                         : NULL;
    const char *const said[] = {row->name, row->brief, row->citation, text};
    bool all = true;
    while (words.len > 0 && all) {
        const struct text word = peek_word(words, "");
        size_t i = 0;
        while (i < COUNT_OF(said) && !text_mentions(said[i], word))
            i++;
        all = i < COUNT_OF(said);
        words = text_after(words, word.len);
        text_skip_blanks(&words);
    }
    return all;
}

/* Lists the rows of a catalog that speak of the words. Returns how many. */
static int catalog_search(const struct catalog *catalog, struct text words, struct reply *reply)
{
    int found = 0;
    for (size_t i = 0; i < catalog->count; i++) {
        const struct row *row = catalog_row(catalog, i);
        if (row_mentions(catalog, row, words)) {
            reply_line(reply, "%-18s %-10s %s", row->name, catalog->kind, row->brief);
            found++;
        }
    }
    return found;
}

/* Lists all rows that mention the words. */
HANDLER(apropos)
{
    UNUSED(session);
    const struct text word = argument_value(args, "WORD")->item->text;
    int found = 0;
    for (int i = 0; help_catalog(i); i++)
        found += catalog_search(help_catalog(i), word, reply);
    for (const struct model *const *model = scene_models; *model; model++)
        found += catalog_search((*model)->params, word, reply) +
                 catalog_search((*model)->derived, word, reply);
    return found > 0 || error_at(error, word, "nothing was found for '%.*s'",
                                 (int)(word.len < 64 ? word.len : 64), word.data);
}
#endif

COMMAND(help, .row.alias = "h ?", .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME,
        .completes = COMPLETES_TOPICS, ARGUMENTS(PLACE("WORD", TYPE_REST)))

COMMAND(apropos, .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("WORD", TYPE_REST, .flags = ARG_REQUIRED)))
