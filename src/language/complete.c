/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of words at the prompt: offers names of each kind (units, settings, observables,
 * events, operands of expressions) that begin with the word being typed. */
#include <hooke/run.h>
#include <hooke/base/unit.h>
#include <hooke/language/complete.h>
#include <hooke/scene/typed.h>

#include <stdio.h>
#include <string.h>

/* Offers a candidate if it begins with the word being typed. */
void complete_offer(struct completion *c, const char *candidate, const char *brief)
{
    if (text_starts(text_of(candidate), c->word))
        c->offer(c->context, candidate, brief);
}

/* Adapts complete_offer() to names_each(). */
static void offer_name(void *context, const char *name, const char *brief)
{
    complete_offer(context, name, brief);
}

void complete_catalog(struct completion *c, const struct catalog *catalog)
{
    for (size_t i = 0; i < catalog->count; i++)
        complete_offer(c, catalog_row(catalog, i)->name, catalog_row(catalog, i)->brief);
}

/* Offers prefix + name + suffix as one word. */
void complete_affixed(struct completion *c, const char *prefix, const char *name,
                      const char *suffix, const char *brief)
{
    char z[LIMIT_NAME + 8];
    snprintf(z, sizeof z, "%s%s%s", prefix, name, suffix);
    complete_offer(c, z, brief);
}

/* Offers the units of a quantity, or all units for QUANTITY_OTHER. */
void complete_units(struct completion *c, enum quantity quantity)
{
    for (size_t i = 0; i < unit_catalog.count; i++) {
        const struct unit *unit = unit_at(i);
        if (quantity == QUANTITY_OTHER || unit->quantity == quantity)
            complete_offer(c, unit->row.name, unit->row.brief);
    }
}

/* Offers everything that NAME = VALUE may set: parameters, derived quantities that determine a
 * parameter, settings, and variables of `let`. */
void complete_settable(struct completion *c)
{
    const struct catalog *derivable = scene_derived(&c->session->setup.scene);
    complete_catalog(c, scene_params(&c->session->setup.scene));
    for (size_t i = 0; i < derivable->count; i++) {
        const struct derived_row *derived =
            (const struct derived_row *)(const void *)catalog_row(derivable, i);
        if (derived->inverse)
            complete_offer(c, derived->row.name, derived->row.brief);
    }
    complete_catalog(c, &setting_catalog);
    for (int i = 0; i < c->session->setup.lets; i++)
        complete_offer(c, c->session->setup.let[i].name, "variable");
}

void complete_names(struct completion *c)
{
    names_each(c->session, offer_name, c);
}

void complete_operands(struct completion *c)
{
    complete_names(c);
    complete_catalog(c, &function_catalog);
}

bool ends_in_digit(struct text preceding)
{
    const struct text t = text_trim(preceding);
    return t.len > 0 && t.data[t.len - 1] >= '0' && t.data[t.len - 1] <= '9';
}

/* Offers what a plot can show of the latest run or the scene: variables, observed expressions, and
 * observables except those that `besides` offers already (or NULL). */
void complete_columns(struct completion *c, const struct catalog *besides)
{
    const struct run *run = session_run(c->session);
    const struct model *moving = run ? run->system.model : c->session->setup.scene.model;
    for (int i = 0; i < moving->n; i++)
        if (!catalog_find(&observable_catalog, text_of(moving->variable[i].name)))
            complete_offer(c, moving->variable[i].name,
                           quantity_name(moving->variable[i].quantity));
    for (int i = 0; i < model_observed(moving); i++)
        complete_offer(c, model_observed_variable(moving, i).name, "observed");
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct row *row = catalog_row(&observable_catalog, i);
        if (model_offers(moving, observable_from(row)) &&
            !(besides && catalog_find(besides, text_of(row->name))))
            complete_offer(c, row->name, row->brief);
    }
}

void complete_events(struct completion *c)
{
    const struct events *events = c->session->setup.events;
    for (int i = 0; events && i < events->count; i++)
        complete_offer(c, events->line[i].name, events->line[i].when);
}

/* ---- expressions ---- */

/* Returns the last character of a text without trailing blanks, or 0 if it is blank. */
char last_letter(struct text text)
{
    const struct text t = text_trim(text);
    return t.len > 0 ? t.data[t.len - 1] : 0;
}

/* Returns true if an expression is incomplete: a parenthesis is open or it ends in an operator. */
bool value_is_open(struct text value)
{
    const char last = last_letter(value);
    int depth = 0;
    for (size_t i = 0; i < value.len; i++)
        depth += (value.data[i] == '(') - (value.data[i] == ')');
    return depth > 0 || (last && strchr("+-*/^", last));
}

static bool is_operator(char c)
{
    return strchr("+-*/^()<>,", c);
}

/* Counts candidates instead of offering them. */
static void count_offer(void *context, const char *candidate, const char *brief)
{
    int *count = context;
    (void)candidate;
    (void)brief;
    ++*count;
}

/* Returns the index in c->word at which the operand being typed begins. A hyphen may belong to a
 * name, as in phase-error: it does if `names` then offers a candidate. */
static size_t operand_start(const struct completion *c, void (*names)(struct completion *c))
{
    const struct text word = c->word;
    size_t begin = word.len;
    while (begin > 0 && !is_operator(word.data[begin - 1]))
        begin--;
    if (begin < 2 || word.data[begin - 1] != '-' || is_operator(word.data[begin - 2]))
        return begin;
    size_t first = begin - 1;
    int count = 0;
    while (first > 0 && !is_operator(word.data[first - 1]))
        first--;
    struct completion whole = {
        c->session, {word.data + first, word.len - first}, count_offer, &count, false};
    names(&whole);
    return count > 0 ? first : begin;
}

/* Completes an expression: offers operands where one may begin (`names`), units after a number.
 * `value` is the text of the expression before the current word. */
void complete_value(struct completion *c, struct text value, enum quantity quantity,
                    void (*names)(struct completion *c))
{
    if (text_starts(c->word, TEXT("--"))) /* an option */
        return;
    const size_t operand_begin = operand_start(c, names);
    const char last = last_letter(value);
    c->word = text_after(c->word, operand_begin);
    if (operand_begin > 0 || !last || strchr("<>=:,", last) || value_is_open(value))
        names(c);
    else if (last >= '0' && last <= '9')
        complete_units(c, quantity);
}
