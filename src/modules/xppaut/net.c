/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables of .ode files, and networks that are weighted sums over neighbours (`special`). */
#include <hooke/base/number.h>
#include "modules/xppaut/net.h"

#include <string.h>

/* largest number of points of a table, and of quantities of a network */
enum { POINTS = 1000 };

/* Splits a number off the begin of a text. Returns false if there is none. */
static bool take_number(struct text *rest, double *number)
{
    size_t used;
    *rest = text_trim(*rest);
    if (real_scan(*rest, '.', number, &used) != REAL_OK || used == 0)
        return false;
    *rest = (struct text){rest->data + used, rest->len - used};
    return true;
}

/* ---- table NAME % POINTS FROM TO FORMULA(t) ---- */

/* Reads a table from the symbol's text, % POINTS FROM TO FORMULA, into symbol->table. Its values
 * are computed when it is first used. Returns false with an error. */
bool ode_table_read(struct ode *ode, struct ode_symbol *symbol)
{
    struct text rest = symbol->text;
    double points;
    struct ode_table *table = arena_alloc(ode->arena, sizeof *table);
    if (!table)
        return error_memory(ode->error);
    *table = (struct ode_table){.points = 0};
    symbol->table = table;
    if (rest.len == 0 || rest.data[0] != '%')
        return ode_error(ode->error, symbol->line,
                         "the numbers of the table are in another file; use a formula of t: table "
                         "NAME %% POINTS FROM TO FORMULA");
    rest = text_after(rest, 1);
    if (!take_number(&rest, &points) || !take_number(&rest, &table->x_low) ||
        !take_number(&rest, &table->x_high) || !(points >= 2 && points <= POINTS) ||
        !(table->x_high > table->x_low))
        return ode_error(ode->error, symbol->line,
                         "write a table as table NAME %% POINTS FROM TO FORMULA, 2 to %d points",
                         (int)POINTS);
    table->points = (int)points;
    table->formula = text_trim(rest);
    return true;
}

/* Returns the argument of point i. */
static double point_of(const struct ode_table *table, int i)
{
    return table->x_low + i * ((table->x_high - table->x_low) / (table->points - 1));
}

/* Computes a table's formula at t, with all parameters as numbers. Sets *value. Returns false with
 * an error if the result is no finite number. */
static bool find_value(struct ode *ode, const struct ode_symbol *symbol,
                       const struct ode_node *formula, double t, double *value)
{
    struct buffer text = {0};
    struct arena arena = {0};
    struct error why;
    size_t used = 0;
    const bool fine = ode_formula_at(ode, symbol, formula, t, &text);
    const struct expr *expr =
        fine ? expr_compile(buffer_text(&text), NULL, &arena, &used, &why) : NULL;
    *value = expr && used == text.len ? expr_value(expr, NULL) : NAN;
    arena_reset(&arena);
    buffer_free(&text);
    if (fine && !isfinite(*value))
        ode_error(ode->error, symbol->line, "the table has no number at %g", t);
    return fine && isfinite(*value);
}

/* Computes all values of a table when it is used for the first time, with the parameters' values in
 * the file. Returns false with an error if a value cannot be computed, if out of memory, or if the
 * table is used in its own formula (table->begun). */
static bool find_values(struct ode *ode, struct ode_symbol *symbol)
{
    struct ode_table *table = symbol->table;
    if (table->value)
        return true;
    if (table->begun)
        return ode_error(ode->error, symbol->line, "the table depends on itself");
    table->begun = true;
    const struct ode_node *const formula =
        ode_parse(ode->arena, symbol->line, table->formula, ode->error);
    double *const value = arena_array(ode->arena, (size_t)table->points, sizeof *value);
    if (!formula || !value)
        return formula && error_memory(ode->error);
    for (int i = 0; i < table->points; i++)
        if (!find_value(ode, symbol, formula, point_of(table, i), &value[i]))
            return false;
    table->value = value;
    return true;
}

/* ---- formulas ---- */

/* Makes a node for a number. Returns NULL with an error if out of memory. */
static struct ode_node *number_of(struct ode *ode, double number)
{
    struct ode_node *made = arena_alloc(ode->arena, sizeof *made);
    if (made)
        *made = (struct ode_node){.kind = NODE_NUMBER, .number = number};
    else
        error_memory(ode->error);
    return made;
}

/* Makes a node a op b, or max(a, b) for op 'm'. Returns NULL with an error if out of memory, or if
 * a or b is NULL. */
static const struct ode_node *net_node_join(struct ode *ode, char op, const struct ode_node *a,
                                            const struct ode_node *b)
{
    struct ode_node *made = a && b ? number_of(ode, 0) : NULL;
    const struct ode_node **both = made ? arena_array(ode->arena, 2, sizeof *both) : NULL;
    if (!made)
        return NULL;
    if (!both) {
        error_memory(ode->error);
        return NULL;
    }
    both[0] = a;
    both[1] = b;
    *made = (struct ode_node){.kind = op == 'm' ? NODE_CALL : NODE_JOIN,
                              .op = op,
                              .name = TEXT("max"),
                              .argument = both,
                              .arguments = 2};
    return made;
}

/* Makes factor*max(argument - x, 0) if it `bends`, otherwise factor*(argument - x). */
static const struct ode_node *ramp_node(struct ode *ode, double factor,
                                        const struct ode_node *argument, double x, bool bends)
{
    const struct ode_node *excess = net_node_join(ode, '-', argument, number_of(ode, x));
    if (bends)
        excess = net_node_join(ode, 'm', excess, number_of(ode, 0));
    return net_node_join(ode, '*', number_of(ode, factor), excess);
}

/* Returns the table's value at `argument` as a formula: linear interpolation, written as the value
 * at the first point, plus a line with the first slope, plus a ramp for each change of slope
 * (`bend`). Returns NULL with an error. */
const struct ode_node *ode_table_at(struct ode *ode, struct ode_symbol *symbol,
                                    const struct ode_node *argument)
{
    const struct ode_table *const table = symbol->table;
    if (!find_values(ode, symbol))
        return NULL;
    const double *y = table->value, dx = point_of(table, 1) - table->x_low;
    const struct ode_node *sum =
        net_node_join(ode, '+', number_of(ode, y[0]),
                      ramp_node(ode, (y[1] - y[0]) / dx, argument, table->x_low, false));
    for (int i = 1; i + 1 < table->points && sum; i++) {
        const double bend = ((y[i + 1] - y[i]) - (y[i] - y[i - 1])) / dx;
        if (bend != 0)
            sum = net_node_join(ode, '+', sum,
                                ramp_node(ode, bend, argument, point_of(table, i), true));
    }
    return sum;
}

/* ---- special NAME=conv(EDGE,COUNT,REACH,TABLE,FIRST) ---- */

/* Reads a text that is an integer from 0 to `most`. Returns false if it is not. */
static bool take_whole(struct text text, int most, int *whole)
{
    double value;
    if (!take_number(&text, &value) || text_trim(text).len > 0 || !(value >= 0 && value <= most))
        return false;
    *whole = (int)value;
    return true;
}

/* Reads a network, conv(EDGE,COUNT,REACH,TABLE,FIRST), from the symbol's text into symbol->net: a
 * weighted sum over neighbours up to REACH among COUNT quantities, the first of which is FIRST.
 * Returns false with an error. */
bool ode_net_read(struct ode *ode, struct ode_symbol *symbol)
{
    const struct text all = symbol->text;
    struct ode_net *net = arena_alloc(ode->arena, sizeof *net);
    struct text part[5], inside;
    const char *open = all.len > 0 ? memchr(all.data, '(', all.len) : NULL;
    int parts = 0;
    if (!net)
        return error_memory(ode->error);
    *net = (struct ode_net){.count = 0};
    symbol->net = net;
    if (!open || !text_is(text_trim((struct text){all.data, (size_t)(open - all.data)}), "conv") ||
        all.data[all.len - 1] != ')')
        return ode_error(ode->error, symbol->line,
                         "scenes have no networks (special) other than conv()");
    inside = (struct text){open + 1, (size_t)(all.data + all.len - 1 - (open + 1))};
    for (; parts < 5 && text_split(&inside, ',', &part[parts]); parts++)
        part[parts] = text_trim(part[parts]);
    if (parts < 5 || inside.len > 0 || part[0].len == 0 || !strchr("ep0z", part[0].data[0]) ||
        !take_whole(part[1], POINTS, &net->count) || !take_whole(part[2], POINTS, &net->reach) ||
        net->reach >= net->count)
        return ode_error(
            ode->error, symbol->line,
            "write a network as special NAME=conv(even|periodic|0,COUNT,REACH,TABLE,FIRST)");
    net->edge = part[0].data[0];
    net->weights = part[3];
    net->first = part[4];
    return true;
}

/* Returns the index of a quantity of the network, where indices beyond the ends are mirrored or
 * wrapped, or -1 if there is none. */
static int neighbour(const struct ode_net *net, int i)
{
    if (i >= 0 && i < net->count)
        return i;
    if (net->edge == 'p')
        return (i + net->count) % net->count;
    if (net->edge != 'e')
        return -1;
    return i < 0 ? -i : 2 * (net->count - 1) - i;
}

/* Makes a node for the quantity that is defined i places after `first`, among those of the same
 * kind. Returns NULL without an error if there is none, and with an error if out of memory. */
static const struct ode_node *quantity_node(struct ode *ode, const struct ode_symbol *first, int i)
{
    for (int k = 0; k < ode->symbols; k++) {
        const struct ode_symbol *const symbol = &ode->symbol[k];
        if (symbol->kind != first->kind || symbol->index != first->index + i)
            continue;
        struct ode_node *made = number_of(ode, 0);
        if (made)
            *made = (struct ode_node){.kind = NODE_NAME, .name = symbol->name};
        return made;
    }
    return NULL;
}

/* Returns the value of a network at index `place` as a formula: the sum of its neighbours' values
 * by their weights, which is 0 outside of the network. Returns NULL with an error. */
const struct ode_node *ode_net_at(struct ode *ode, struct ode_symbol *symbol, double place)
{
    const struct ode_net *const net = symbol->net;
    struct ode_symbol *const weights = ode_find(ode, net->weights);
    const struct ode_symbol *const first = ode_find(ode, net->first);
    const struct ode_node *sum = NULL;
    if (!weights || weights->kind != ODE_TABLE || weights->table->points != 2 * net->reach + 1) {
        ode_error(ode->error, symbol->line, "its weights must be a table of %d points",
                  2 * net->reach + 1);
        return NULL;
    }
    if (!first || first->kind >= ODE_FUNCTION || !quantity_node(ode, first, net->count - 1)) {
        if (ode->error->code == ERROR_NONE)
            ode_error(ode->error, symbol->line, "there are fewer than %d quantities from '%.*s' on",
                      net->count, (int)(net->first.len < 40 ? net->first.len : 40),
                      net->first.data);
        return NULL;
    }
    if (!find_values(ode, weights) || !(place >= 0 && place < net->count))
        return ode->error->code == ERROR_NONE ? number_of(ode, 0) : NULL;
    for (int j = -net->reach; j <= net->reach; j++) {
        const int k = neighbour(net, (int)place + j);
        const double weight = weights->table->value[j + net->reach];
        if (k < 0 || weight == 0)
            continue;
        const struct ode_node *const term =
            net_node_join(ode, '*', number_of(ode, weight), quantity_node(ode, first, k));
        sum = sum ? net_node_join(ode, '+', sum, term) : term;
        if (!sum)
            return NULL;
    }
    return sum ? sum : number_of(ode, 0);
}
