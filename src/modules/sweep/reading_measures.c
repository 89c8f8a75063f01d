/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads `measure=` of a sweep: names of measures, and expressions of them and of columns of the
 * run, such as max(y) - min(y), rms(v), mean(y^2)/k. */
#include <hooke/scene/dimension.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>
#include "modules/sweep/reading.h"

#include <ctype.h>
#include <string.h>

/* ---- the measures that are computed ---- */

/* Does the same as sweep_measure_find(), and finds the module that provides attractors. Returns
 * false with an error also if it is not built in. */
static bool find_measure(const struct model *model, struct text name, struct sweep_measure *measure,
                         struct error *error)
{
    if (!sweep_measure_find(model, name, measure, error))
        return false;
    for (size_t i = 0; module_list[i] && measure->kind == SWEEP_ATTRACTOR; i++)
        if (module_list[i]->attractor)
            measure->attractor = module_list[i]->attractor;
    return measure->kind != SWEEP_ATTRACTOR || measure->attractor ||
           module_is_in("sweep measure=attractor", name, error);
}

/* Returns true if both measure the same. */
static bool same_measure(const struct sweep_measure *a, const struct sweep_measure *b)
{
    return a->kind == b->kind && a->column == b->column && a->variable == b->variable &&
           a->observable == b->observable && a->expression == b->expression;
}

/* Adds a measure unless it is there already. Returns its index, or -1 with `error` filled if there
 * are too many. */
static int add_measure(struct sweep_request *request, const struct sweep_measure *measure,
                       struct text where, struct error *error)
{
    for (int m = 0; m < request->measures; m++)
        if (same_measure(&request->measure[m], measure))
            return m;
    if (request->measures == SWEEP_MEASURES) {
        error_at(error, where, "a sweep can have at most %d measures", SWEEP_MEASURES);
        return -1;
    }
    request->measure[request->measures] = *measure;
    return request->measures++;
}

/* ---- expressions of the columns of a run ---- */

/* Context of column_slot(). */
struct column_slots {
    struct expr_scope *scope;
    struct sweep_expression *expression;
    const struct model *model;
    bool many; /* true if there are more than SWEEP_COLUMNS */
};

/* Translates a slot of names_scope() for an expression: into a column of the run (added if it is
 * new), or into a slot of the scene's values, from SWEEP_SLOT_PARAM on. Returns a negative value if
 * the name is to become a number. Sets slots->many if there are too many columns. */
static int column_slot(void *context, int slot)
{
    struct column_slots *slots = context;
    struct sweep_expression *expression = slots->expression;
    const int place = slot_of_point(slots->scope, slot),
              observable = place - slots->model->n - model_observed(slots->model);
    if (place < 0 || place >= SWEEP_SLOT_PARAM)
        return place;
    const struct row *row =
        observable >= 0 ? catalog_row(&observable_catalog, (size_t)observable) : NULL;
    expression->works |= row && (observable_from(row))->needs & NEED_WORK;
    for (int c = 0; c < expression->columns; c++)
        if (expression->column[c] == place)
            return c;
    slots->many |= expression->columns == SWEEP_COLUMNS;
    if (slots->many)
        return 0;
    expression->column[expression->columns] = place;
    return expression->columns++;
}

/* Returns the quantity of an expression, by the units of its names. */
static enum quantity quantity_of(const struct expr *expr)
{
    const enum quantity quantity = dimension_quantity(expr_dimension(expr));
    return quantity == QUANTITY_OTHER ? QUANTITY_NUMBER : quantity;
}

/* Compiles an expression of quantities of a run, as in mean(x^2), in the arena. Returns NULL with
 * an error. */
static const struct sweep_expression *read_column(struct parser *parser, struct text text,
                                                  struct error *error)
{
    const struct names names = {.session = parser->session, .expects_run = true};
    struct expr_scope scope = names_scope(&names);
    struct sweep_expression *expression = arena_alloc(parser->arena, sizeof *expression);
    struct column_slots slots = {&scope, expression, parser->session->setup.scene.model, false};
    size_t used;
    const struct expr *expr =
        expression ? expr_compile(text, &scope, parser->arena, &used, error) : NULL;
    if (!expr) {
        if (!expression)
            error_memory(error);
        return NULL;
    }
    const struct text rest = text_trim(text_after(text, used));
    if (rest.len > 0) {
        error_at(error, rest, "the expression ends before this");
        return NULL;
    }
    expression->quantity = quantity_of(expr);
    expression->expr = expr_settle(expr, &scope, column_slot, &slots, parser->arena);
    if (slots.many)
        error_at(error, text, "the expression has more than %d columns", SWEEP_COLUMNS);
    else if (!expression->expr)
        error_memory(error);
    return !slots.many && expression->expr ? expression : NULL;
}

/* ---- expressions of measures ---- */

enum { REDUCTIONS_MAX = 32 }; /* largest number of reductions in an expression */

/* A part of an expression that reduces a column to a number, such as max(y). In the copy of the
 * text a name of the same length replaces it. */
struct reduction {
    const char *cursor; /* begin in the copy */
    size_t len;
    int place;              /* index of its measure in the request */
    bool root;              /* it is rms, the root of the mean square that is measured */
    enum quantity quantity; /* quantity of the root */
};

/* State of reading an expression of measures. */
struct formula_reader {
    struct parser *parser;
    struct sweep_request *request;
    struct text text; /* as it was typed */
    char *copy;       /* copy of the text in which reductions are replaced by names */
    struct reduction reduction[REDUCTIONS_MAX];
    int reductions;
    struct names names;
    struct error *error;
};

/* Returns true for characters of names, which may have primes. */
static bool is_word_char(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '\'';
}

/* Returns true if the text is a name. */
static bool is_plain(struct text text)
{
    bool plain = text.len > 0 && !isdigit((unsigned char)text.data[0]);
    for (size_t i = 0; i < text.len; i++)
        plain &= is_word_char(text.data[i]);
    return plain;
}

/* Returns the index of the matching ')', or text.len if none matches. Sets *one if it encloses a
 * single argument. */
static size_t find_closing_paren(struct text text, size_t open, bool *one)
{
    int depth = 0;
    *one = true;
    for (size_t i = open; i < text.len; i++) {
        depth += (text.data[i] == '(') - (text.data[i] == ')');
        *one &= !(depth == 1 && text.data[i] == ',');
        if (depth == 0)
            return i;
    }
    return text.len;
}

static struct text text_between(struct text text, size_t begin, size_t end)
{
    return (struct text){text.data + begin, end - begin};
}

/* Adds the measure of word(inner), whose text is `whole`, to the request and fills in *made.
 * word(end) is a measure at the end; inner may be an expression of columns. Returns false with an
 * error. */
static bool read_reduction(struct formula_reader *r, struct text whole, struct text word,
                           struct text inner, struct reduction *made)
{
    struct sweep_measure measure = {.kind = SWEEP_MEAN, .column = SWEEP_FORMULA};
    const struct model *model = r->request->scene->model;
    const bool root = text_is(word, "rms");
    if (text_is(inner, "end")) {
        if (!find_measure(model, word, &measure, r->error))
            return false;
    } else if (is_plain(inner) && !root) {
        if (!find_measure(model, whole, &measure, r->error))
            return false;
    } else {
        struct sweep_measure kind;
        struct error ignored = {0};
        struct buffer square = {0};
        measure.expression = read_column(r->parser, inner, r->error);
        if (!measure.expression)
            return false;
        made->quantity = measure.expression->quantity;
        buffer_format(&square, "(%.*s)^2", (int)inner.len, inner.data);
        const char *text = root ? arena_text(r->parser->arena, buffer_text(&square)) : "";
        buffer_free(&square);
        if (root)
            measure.expression = text ? read_column(r->parser, text_of(text), r->error) : NULL;
        if (!measure.expression)
            return text ? false : error_memory(r->error);
        if (!root && find_measure(model, word, &kind, &ignored))
            measure.kind = kind.kind;
    }
    made->root = root;
    made->place = add_measure(r->request, &measure, whole, r->error);
    return made->place >= 0;
}

/* Finds all reductions in the text, such as max(y) or x(end), adds their measures and overwrites
 * each in r->copy by q characters, so that it parses as a name. Returns false with an error. */
static bool find_reductions(struct formula_reader *r)
{
    static const char *const words[] = {"amplitude", "period", "mean", "max", "min", "rms"};
    const struct text text = r->text;
    for (size_t i = 0; i < text.len; i++) {
        size_t end = i;
        while (end < text.len && is_word_char(text.data[end]))
            end++;
        if (end == i)
            continue;
        size_t open = end;
        while (open < text.len && text.data[open] == ' ')
            open++;
        bool one, reduces = false;
        const size_t close = open < text.len && text.data[open] == '('
                                 ? find_closing_paren(text, open, &one)
                                 : text.len;
        const struct text word = text_between(text, i, end);
        i = end - 1;
        if (close == text.len)
            continue;
        const struct text inner = text_trim(text_between(text, open + 1, close));
        for (size_t w = 0; w < COUNT_OF(words); w++)
            reduces |= text_is(word, words[w]) && one;
        if (!reduces && !(text_is(inner, "end") && is_plain(word)))
            continue;
        const size_t begin = (size_t)(word.data - text.data), len = close + 1 - begin;
        struct reduction *made = &r->reduction[r->reductions];
        if (r->reductions == REDUCTIONS_MAX)
            return error_at(r->error, word, "the expression has more than %d reductions",
                            REDUCTIONS_MAX);
        if (!read_reduction(r, text_between(text, begin, close + 1), word, inner, made))
            return false;
        r->reductions++;
        made->cursor = r->copy + begin;
        made->len = len;
        memset(r->copy + begin, 'q', len);
        i = close;
    }
    return true;
}

/* Returns true if the name is a parameter of a typed scene, which comes before an observable of
 * that name. */
static bool is_own_parameter(const struct scene *scene, struct text name)
{
    return scene->model->typed && model_state(scene->model, name) < 0 &&
           catalog_find(scene_params(scene), name);
}

/* Finds a name in an expression of a sweep and sets *slot: a reduction, a measure or a column at
 * the end of the run (a slot of struct sweep_formula, below 2 * SWEEP_MEASURES), or a name that the
 * session knows (its slot plus 2 * SWEEP_MEASURES). Measures are added to the request. context
 * points to a struct formula_reader pointer. Returns false if the name is unknown or there is no
 * room. */
static bool formula_find(const void *context, struct text name, int *slot)
{
    struct formula_reader *r = *(struct formula_reader *const *)context;
    struct sweep_measure measure;
    struct error ignored = {0};
    const struct expr_scope scope = names_scope(&r->names);
    for (int k = 0; k < r->reductions; k++)
        if (name.data == r->reduction[k].cursor && name.len == r->reduction[k].len) {
            *slot = r->reduction[k].place + (r->reduction[k].root ? SWEEP_MEASURES : 0);
            return true;
        }
    if (!is_own_parameter(r->request->scene, name) &&
        find_measure(r->request->scene->model, name, &measure, &ignored)) {
        *slot = add_measure(r->request, &measure, name, r->error);
        return *slot >= 0;
    }
    if (!scope.find(scope.context, name, slot))
        return false;
    *slot += 2 * SWEEP_MEASURES;
    return true;
}

/* Returns the value of a slot now, NAN for measures. */
static double formula_load(const void *context, int slot)
{
    const struct formula_reader *r = *(struct formula_reader *const *)context;
    const struct expr_scope scope = names_scope(&r->names);
    return slot < 2 * SWEEP_MEASURES ? NAN : scope.load(scope.context, slot - 2 * SWEEP_MEASURES);
}

/* Returns the quantity of a slot. */
static enum quantity formula_quantity(const void *context, int slot)
{
    const struct formula_reader *r = *(struct formula_reader *const *)context;
    const struct expr_scope scope = names_scope(&r->names);
    if (slot >= 2 * SWEEP_MEASURES)
        return scope.quantity(scope.context, slot - 2 * SWEEP_MEASURES);
    for (int k = 0; k < r->reductions; k++)
        if (r->reduction[k].root && r->reduction[k].place == slot - SWEEP_MEASURES)
            return r->reduction[k].quantity;
    return sweep_measure_quantity(&r->request->measure[slot], r->request->scene->model);
}

/* Offers names for a suggestion: measures, and names that the session knows. */
static void formula_offer(const void *context, struct suggestion *suggestion)
{
    const struct formula_reader *r = *(struct formula_reader *const *)context;
    const struct expr_scope scope = names_scope(&r->names);
    for (size_t i = 0; i < sweep_measure_catalog.count; i++)
        suggestion_offer(suggestion, catalog_row(&sweep_measure_catalog, i)->name);
    scope.offer(scope.context, suggestion);
}

/* Returns the slot of a sweep for a slot of formula_find(), negative if the name is to become a
 * number. */
static int formula_slot(void *context, int slot)
{
    struct formula_reader *r = context;
    struct expr_scope scope = names_scope(&r->names);
    return slot < 2 * SWEEP_MEASURES ? slot : slot_of_point(&scope, slot - 2 * SWEEP_MEASURES);
}

/* Compiles the text of `r` as an expression of measures, in the arena. Returns NULL with an error,
 * which points into the typed text. */
static const struct sweep_formula *read_formula(struct formula_reader *r)
{
    struct formula_reader *self = r;
    const struct expr_scope scope = {&self,         formula_find, formula_load,
                                     formula_offer, NULL,         formula_quantity};
    struct sweep_formula *formula = arena_alloc(r->parser->arena, sizeof *formula);
    const char *text = arena_text(r->parser->arena, r->text);
    r->copy = arena_alloc(r->parser->arena, r->text.len + 1);
    if (!formula || !text || !r->copy) {
        error_memory(r->error);
        return NULL;
    }
    memcpy(r->copy, text, r->text.len);
    if (!find_reductions(r))
        return NULL;
    size_t used;
    const struct text copy = {r->copy, r->text.len};
    const struct expr *expr = expr_compile(copy, &scope, r->parser->arena, &used, r->error);
    if (expr && text_trim(text_between(copy, used, copy.len)).len > 0) {
        error_at(r->error, text_trim(text_between(copy, used, copy.len)),
                 "the expression ends before this");
        expr = NULL;
    }
    /* errors are to point into what was typed, not into the copy */
    const char *where = r->error->where.data;
    if (!expr && where && where >= r->copy && where <= r->copy + copy.len)
        r->error->where.data = r->text.data + (where - r->copy);
    if (!expr)
        return NULL;
    *formula =
        (struct sweep_formula){.text = text,
                               .expr = expr_settle(expr, &scope, formula_slot, r, r->parser->arena),
                               .quantity = quantity_of(expr)};
    if (!formula->expr)
        error_memory(r->error);
    return formula->expr ? formula : NULL;
}

/* ---- the list ---- */

/* Splits the next item off the list *rest, up to a comma outside parentheses, and removes blanks
 * and quotes around it. Returns false if *rest is empty. */
static bool next_item(struct text *rest, struct text *item)
{
    int depth = 0;
    size_t end = 0;
    if (rest->len == 0)
        return false;
    for (; end < rest->len && !(depth <= 0 && rest->data[end] == ','); end++)
        depth += (rest->data[end] == '(') - (rest->data[end] == ')');
    *item = text_trim(text_between(*rest, 0, end));
    *rest = text_between(*rest, end < rest->len ? end + 1 : end, rest->len);
    const char quote = item->len > 0 && strchr("\"'", item->data[0]) ? item->data[0] : '"';
    if (item->len > 0 && item->data[0] == quote)
        *item = text_trim(text_between(*item, 1, item->len));
    if (item->len > 0 && item->data[item->len - 1] == quote)
        *item = text_trim(text_between(*item, 0, item->len - 1));
    return true;
}

/* Returns true if the item looks like an expression, false if like a name or NAME(COLUMN). */
static bool is_formula(struct text item)
{
    bool one;
    const char *paren = memchr(item.data, '(', item.len);
    const size_t open = paren ? (size_t)(paren - item.data) : item.len;
    if (!paren || find_closing_paren(item, open, &one) != item.len - 1)
        return !is_plain(item) && item.len > 0;
    const struct text word = text_trim(text_between(item, 0, open)),
                      inner = text_trim(text_between(item, open + 1, item.len - 1));
    return !catalog_find(&sweep_measure_catalog, word) || !is_plain(inner) || text_is(inner, "end");
}

/* Adds an item of the list behind measure= to the request's columns: a measure or an expression of
 * measures. Returns false with an error. */
static bool read_item(struct parser *parser, struct text item, struct sweep_request *request,
                      struct error *error)
{
    struct sweep_measure *shown = &request->shown[request->columns];
    struct error why = {0};
    if (request->columns == SWEEP_MEASURES)
        return error_at(error, item, "a sweep can have at most %d measures", SWEEP_MEASURES);
    if (find_measure(request->scene->model, item, shown, &why)) {
        request->place[request->columns++] = add_measure(request, shown, item, error);
        return request->place[request->columns - 1] >= 0;
    }
    if (!is_formula(item)) {
        *error = why;
        return false;
    }
    struct formula_reader reader = {.parser = parser,
                                    .request = request,
                                    .text = item,
                                    .names = {.session = parser->session, .expects_run = true},
                                    .error = error};
    *shown = (struct sweep_measure){.kind = SWEEP_FORMULA, .column = SWEEP_VARIABLE};
    shown->formula = read_formula(&reader);
    request->columns += shown->formula != NULL;
    return shown->formula;
}

/* Reads the list behind `measure=` into the request. If no item is an expression, the items are the
 * measures themselves and request->columns is 0. Returns false with an error. */
bool read_measures(struct parser *parser, struct sweep_request *request, struct error *error)
{
    struct text rest = text_trim(parser->rest), item;
    bool formulas = false;
    request->measures = request->columns = 0;
    while (next_item(&rest, &item))
        if (!read_item(parser, item, request, error))
            return false;
    if (request->columns == 0)
        return error_at(error, parser->rest, "measure= needs a name, as in measure=amplitude");
    for (int c = 0; c < request->columns; c++)
        formulas |= request->shown[c].formula != NULL;
    if (formulas)
        return true;
    memcpy(request->measure, request->shown, sizeof request->shown);
    request->measures = request->columns;
    request->columns = 0;
    return true;
}
