/* SPDX-License-Identifier: GPL-3.0-or-later */
/* equilibria */
#ifndef COMMAND_ROWS
#include <hooke/base/numeric.h>
#include <hooke/report.h>
#include <hooke/study/dynamics.h>
#include "command/internal.h"

#include <math.h>

#define WIDER 0.5 /* of what was seen, to either side */
#define TINY 1e-6

/* ---- the box ---- */

static void include(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* What runs of this scene have shown, and its natural sizes about 0, widened. */
static bool usual_box(const struct session *session, const struct system *system,
                      struct arena *arena, double box[][2], struct error *error)
{
    const struct run *run =
        session->current_run >= 0 ? session->run[session->current_run]->run : NULL;
    const bool same = run && run->scene.model == system->model;
    const size_t rows = same ? trace_count(run->trace) : 0;
    double *column = arena_array(arena, rows + 1, sizeof *column);
    if (!column)
        return error_memory(error);
    double most = 0;
    for (int i = 0; i < system->n; i++)
        most = fmax(most, system->scale[i]);
    for (int i = 0; i < system->n; i++) {
        /* what the scene's start leaves at rest has no size of its own */
        const double size = system->scale[i] < TINY * most ? most : system->scale[i];
        double range[] = {-size, size};
        include(range, system->start[i]);
        if (rows > 0)
            run_variable_column(run, i, column);
        for (size_t k = 0; k < rows; k++)
            include(range, column[k]);
        const double by = WIDER * (range[1] - range[0]);
        box[i][0] = range[0] - by;
        box[i][1] = range[1] + by;
    }
    return true;
}

static bool read_side(struct session *session, const struct arguments *args, struct text argument,
                      const struct system *system, double box[][2], struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, argument};
    const struct text name = peek_name(argument);
    const int i = name.len > 0 ? model_state(system->model, name) : -1;
    struct item item = {0};
    if (text_starts(argument, TEXT("--")))
        return error_at(error, argument, "equilibria has no option '%.*s'",
                        (int)(argument.len < 64 ? argument.len : 64) - 2, argument.at + 2);
    if (i < 0) {
        error_at(error, name.len > 0 ? name : argument, "'%.*s' is no variable of the scene",
                 (int)argument.len, argument.at);
        return error_hint(error, "a side of the box is NAME=FROM:TO, for example %s=-1:1",
                          system->model->variable[0].name);
    }
    parser.rest = text_trim((struct text){argument.at + name.len, argument.len - name.len});
    if (!text_starts(parser.rest, TEXT("=")))
        return error_at(error, argument, "%.*s needs a range, as in %.*s=-1:1", (int)name.len,
                        name.at, (int)name.len, name.at);
    parser.rest = text_trim((struct text){parser.rest.at + 1, parser.rest.len - 1});
    const struct variable variable = system_variable(system, i);
    if (!parse_range(&parser, variable.name, variable.quantity, &item, error) ||
        !refuse_rest(&parser, NULL, error))
        return false;
    for (int k = 0; k < 2; k++)
        box[i][k] = isnan(item.range[k]) ? box[i][k] : item.range[k];
    return box[i][0] < box[i][1] ||
           error_at(error, argument, "%s: a range goes from a smaller to a larger value",
                    variable.name);
}

/* ---- what they are ---- */

static const char *type_of(const struct solution *s, bool conservative)
{
    double size = 0;
    int zero = 0, turning = 0;
    for (int i = 0; i < s->values; i++)
        size = fmax(size, hypot(s->value[i].re, s->value[i].im));
    for (int i = 0; i < s->values; i++) {
        zero += fabs(s->value[i].re) <= 1e-10 * size;
        turning += s->value[i].im != 0;
    }
    if (zero > 0 && zero < s->values && s->unstable > 0 && conservative)
        return "saddle";
    if (zero > 0)
        return conservative && turning == s->values ? "centre" : "degenerate";
    if (s->unstable > 0 && s->unstable < s->values)
        return "saddle";
    if (s->values > 2)
        return s->unstable == 0 ? "stable" : "unstable";
    if (turning > 0)
        return s->unstable == 0 ? "stable focus" : "unstable focus";
    return s->unstable == 0 ? "stable node" : "unstable node";
}

static void put_eigenvalue(struct buffer *out, const struct eigenvalue *value, const char *sign)
{
    if (value->im == 0)
        buffer_format(out, "%.5g", value->re);
    else if (value->re == 0)
        buffer_format(out, "%s%.5gi", sign, fabs(value->im));
    else
        buffer_format(out, "%.5g %s %.5gi", value->re, sign, fabs(value->im));
}

/* Pairs once. */
static void cell_eigenvalues(struct text_table *table, const struct solution *s)
{
    struct buffer out = {0};
    for (int i = 0; i < s->values; i++) {
        const bool pair = s->value[i].im != 0 && i + 1 < s->values;
        if (i > 0)
            buffer_put(&out, TEXT(", "));
        put_eigenvalue(&out, &s->value[i], "+-");
        i += pair;
    }
    cell_take(table, &out);
}

static void put_table(struct buffer *out, const struct system *system,
                      const struct equilibria *found, struct arena *arena)
{
    struct text_table table = {.arena = arena, .gap = 2, .indent = 2, .columns = system->n + 3};
    cell_text(&table, "");
    for (int i = 0; i < system->n; i++)
        cell_text(&table, system_variable(system, i).name);
    cell_text(&table, "type");
    cell_text(&table, "eigenvalues [1/s]");
    for (int k = 0; k < found->count; k++) {
        cell_count(&table, k + 1);
        for (int i = 0; i < system->n; i++)
            cell_quantity(&table, found->of[k].state[i], system_variable(system, i).quantity, 7);
        cell_text(&table, type_of(&found->of[k], system->conservative));
        cell_eigenvalues(&table, &found->of[k]);
    }
    text_table_put(&table, out);
}

static void put_box(struct buffer *out, const struct system *system, double box[][2])
{
    for (int i = 0; i < system->n; i++) {
        const struct variable variable = system_variable(system, i);
        buffer_format(out, "%s%s = ", i > 0 ? ", " : "", variable.name);
        buffer_quantity(out, box[i][0], variable.quantity, 3);
        buffer_put(out, TEXT(" .. "));
        buffer_quantity(out, box[i][1], variable.quantity, 3);
    }
}

static void put_found(struct buffer *out, const struct system *system, double box[][2],
                      const struct equilibria *found, struct arena *arena)
{
    if (found->count == 0)
        buffer_put(out, found->complete ? TEXT("no equilibrium in ") : TEXT("none found in "));
    else
        buffer_format(out, "%d equilibri%s in ", found->count, found->count == 1 ? "um" : "a");
    put_box(out, system, box);
    if (found->complete)
        buffer_put(out, found->count > 0 ? TEXT(": proven that there are no others\n")
                                         : TEXT(": proven\n"));
    else
        buffer_format(out, ": may be incomplete (%s)\n", found->reason);
    if (found->forced)
        buffer_put(out, TEXT("of the mean over the drive's period: with the drive nothing rests "
                             "there\n"));
    if (found->count > 0)
        put_table(out, system, found, arena);
}

static void reply_equilibria(const struct system *system, const struct equilibria *found,
                             struct reply *reply)
{
    for (int k = 0; k < found->count; k++) {
        const struct solution *s = &found->of[k];
        reply_begin(reply, "equilibrium");
        reply_int(reply, "n", k + 1);
        reply_object(reply, "state");
        for (int i = 0; i < system->n; i++)
            reply_real(reply, system_variable(system, i).name, s->state[i]);
        reply_close(reply);
        reply_string(reply, "type", type_of(s, system->conservative));
        reply_bool(reply, "stable", solution_stable(s));
        reply_array(reply, "eigenvalues");
        for (int i = 0; i < s->values; i++) {
            reply_array(reply, NULL);
            reply_real(reply, NULL, s->value[i].re);
            reply_real(reply, NULL, s->value[i].im);
            reply_close(reply);
        }
        reply_close(reply);
        reply_real(reply, "residual", s->residual);
        reply_end(reply);
    }
    reply_begin(reply, "equilibria");
    reply_int(reply, "count", found->count);
    reply_bool(reply, "complete", found->complete);
    reply_string(reply, "reason", found->complete ? NULL : found->reason);
    reply_end(reply);
}

HANDLER(equilibria)
{
    const struct argument_value *sides = argument_value(args, "NAME=FROM:TO");
    struct equilibria_request request = {.scene = &session->setup.scene,
                                         .cancel = session->front.cancel};
    struct system system;
    struct equilibria found;
    double box[LIMIT_VARIABLES][2];
    if (!scene_bind(&session->setup.scene, &system, error) ||
        !usual_box(session, &system, args->arena, box, error))
        return false;
    struct text rest = sides->count ? sides->item->text : TEXT("");
    for (rest = text_trim(rest); rest.len > 0; rest = text_trim(rest))
        if (!read_side(session, args, next_key_argument(&rest), &system, box, error))
            return false;
    for (int i = 0; i < system.n && i < DYNAMICS_VARIABLES; i++)
        for (int k = 0; k < 2; k++)
            request.box[i][k] = box[i][k];
    if (!equilibria_find(&request, &found, error))
        return false;
    struct buffer text = {0};
    put_found(&text, &system, box, &found, args->arena);
    reply_text(reply, text_trim(buffer_text(&text)));
    buffer_free(&text);
    reply_equilibria(&system, &found, reply);
    equilibria_free(&found);
    return true;
}
#endif

COMMAND(equilibria,
        .row = {"equilibria", "", "where the scene rests: all of them in a box, with their kind",
                "", NULL},
        .group = "DYNAMICS",
        .text =
            "All states in a box at which nothing changes, found by bounds of the equations: "
            "none is missed and none\n"
            "invented, or it says that there may be more. NAME=FROM:TO is a side of the box, of "
            "a variable; without it\n"
            "what runs have shown, widened. Kinds follow from the eigenvalues of the Jacobian. "
            "Of a scene with a drive\n"
            "those of the mean over its period.",
        .examples = "var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v; equilibria x=-2:2 v=-2:2\n"
                    "equilibria > rests.csv",
        .see = "stability plot run", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("NAME=FROM:TO", TYPE_REST)))
