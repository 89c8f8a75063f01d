/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the commands of the module dynamics share: they read arguments and write
 * results. */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/run/timing.h>
#include "modules/dynamics/handlers.h"

#include <stdio.h>

/* ---- arguments ---- */

bool take_equals(struct parser *parser, struct text argument, struct text name)
{
    const struct text rest = text_trim(text_after(argument, name.len));
    if (!text_starts(rest, TEXT("=")))
        return false;
    parser->rest = text_trim(text_after(rest, 1));
    return true;
}

/* The name may end in ', as that of a derivative does. */
int read_variable(struct parser *parser, struct text argument, const struct system *system,
                  const char *command, const char *example, struct error *error)
{
    struct text name = peek_name(argument);
    name.len += name.len > 0 && name.len < argument.len && argument.data[name.len] == '\'';
    const int i = name.len > 0 ? model_state(system->model, name) : -1;
    const int shown = (int)(argument.len < 64 ? argument.len : 64);
    if (text_starts(argument, TEXT("--"))) {
        error_at(error, argument, "%s has no option '%.*s'", command, shown - 2, argument.data + 2);
    } else if (i < 0) {
        const struct text named = name.len > 0 ? name : (struct text){argument.data, (size_t)shown};
        error_at(error, named, "'%.*s' is not a variable of the scene", (int)named.len, named.data);
        error_hint(error, "%s takes variables, as in %s=%s", command,
                   system->model->variable[0].name, example);
    } else if (!take_equals(parser, argument, name)) {
        error_at(error, argument, "%.*s needs a value, as in %.*s=%s", (int)name.len, name.data,
                 (int)name.len, name.data, example);
    } else {
        return i;
    }
    return -1;
}

/* ---- results ---- */

void put_seconds(struct buffer *output, const struct session *session, double seconds)
{
    if (session->setup.settings.timing != TIMING_OFF)
        buffer_format(output, ", %s", SHOWN_QUANTITY(seconds, QUANTITY_TIME, 3));
}

void reply_state(struct reply *reply, const struct system *system, const char *key,
                 const double *state)
{
    reply_object(reply, key);
    for (int i = 0; i < system->n; i++)
        reply_real(reply, system_variable(system, i).name, state[i]);
    reply_close(reply);
}

void reply_exponent(struct reply *reply, double value, double uncertainty)
{
    reply_object(reply, NULL);
    reply_real(reply, "value", value);
    reply_real(reply, "uncertainty", uncertainty);
    reply_string(reply, "unit", "1/s");
    reply_close(reply);
}

void put_variable(struct buffer *output, const struct system *system, int i, double value,
                  int digits)
{
    const struct variable variable = system_variable(system, i);
    buffer_format(output, "%s = %s", variable.name,
                  SHOWN_QUANTITY(value, variable.quantity, digits));
}

const char *shown_range(struct value_text *text, double begin, double end, enum quantity quantity,
                        int digits)
{
    snprintf(text->data, sizeof text->data, "%s .. %s", SHOWN_QUANTITY(begin, quantity, digits),
             SHOWN_QUANTITY(end, quantity, digits));
    return text->data;
}

void reply_values(struct reply *reply, const char *key, const struct solution *s)
{
    reply_array(reply, key);
    for (int i = 0; i < s->values; i++)
        reply_reals(reply, NULL, (const double[]){s->value[i].re, s->value[i].im}, 2, "");
    reply_close(reply);
}

/* Writes null if the stability is unknown, or neutral in a family of orbits. */
void reply_stable(struct reply *reply, const struct solution *s, bool family)
{
    const bool stable = solution_stable(s);
    if (!solution_is_known(s) || (stable && family))
        reply_null(reply, "stable");
    else
        reply_bool(reply, "stable", stable);
}

void reply_own_solver(const struct session *session, const char *solver, struct reply *reply)
{
    const struct setup *setup = &session->setup;
    if (setup->method_chosen || setup->settings.tol_chosen || setup->settings.dt_chosen)
        reply_line(reply, "solved by %s ('method', 'dt' and 'tol' do not matter here)", solver);
}

/* ---- tables ---- */

/* Adds a column without values, whose name is name and suffix. Returns NULL, with b->failed, if out
 * of memory. */
static struct table_column *add_column(struct table_builder *b, const char *name,
                                       const char *suffix)
{
    if (!b->column)
        b->column = arena_array(&b->arena, TABLE_BUILDER_COLUMNS, sizeof *b->column);
    struct buffer full = {0};
    buffer_format(&full, "%s%s", name, suffix);
    const char *copy = full.failed ? NULL : arena_text(&b->arena, buffer_text(&full));
    buffer_free(&full);
    b->failed = b->failed || !b->column || !copy;
    if (b->failed)
        return NULL;
    struct table_column *column = &b->column[b->count++];
    *column = (struct table_column){.name = copy, .unit = ""};
    return column;
}

/* The name is copied; the values are left for the caller to fill. */
double *table_add_reals(struct table_builder *b, const char *name, const char *suffix,
                        enum quantity quantity)
{
    struct table_column *column = add_column(b, name, suffix);
    double *value = column ? arena_array(&b->arena, b->rows + 1, sizeof *value) : NULL;
    b->failed = !value;
    if (value) {
        column->value = value;
        column->unit = quantity_unit(quantity);
    }
    return value;
}

/* The texts are left for the caller to fill; they have to live as long as the table. */
const char **table_add_texts(struct table_builder *b, const char *name)
{
    struct table_column *column = add_column(b, name, "");
    const char **text = column ? arena_array(&b->arena, b->rows + 1, sizeof *text) : NULL;
    b->failed = !text;
    if (text)
        column->text = text;
    return text;
}

void table_finish(struct table_builder *b, struct reply *reply, const char *kind)
{
    const struct table table = {.column = b->column, .columns = b->count, .rows = b->rows};
    if (!b->failed && reply->store)
        table_store_put(reply->store, kind, &b->arena, &table);
    arena_reset(&b->arena);
}
