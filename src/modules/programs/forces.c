/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces as functions of what they depend on. */
#include "modules/programs/program.h"

#include <stdlib.h>
#include <string.h>

static const struct expr *expr_of(const struct scene_program *p, enum part part, int row)
{
    const struct written *w = &p->written;
    return part == PART_ALL ? w->all[row] : part == PART_FORCE ? w->force[row] : w->drag[row];
}

/* Marks what the expression reads, also by what is observed. */
static void mark_reads(const struct scene_program *p, const struct expr *expr, bool *reads)
{
    const struct written *w = &p->written;
    if (!expr_reads(expr, w->zero, reads))
        p->out->failed = true;
    for (int i = w->names; i-- > w->observed;)
        if (reads[i] && !expr_reads(w->observe[i - w->observed], w->zero, reads))
            p->out->failed = true;
}

static bool is_dry(const struct scene_program *p, enum part part)
{
    return p->written.dry && part != PART_FORCE;
}

/* What a row of a part reads: its arguments are t and the state's. NULL: no memory. */
static bool *reads_of(const struct scene_program *p, enum part part, int row)
{
    const struct written *w = &p->written;
    bool *reads = arena_array(p->arena, (size_t)w->names, sizeof *reads);
    const struct expr *expr = expr_of(p, part, row);
    if (!reads) {
        p->out->failed = true;
        return NULL;
    }
    if (expr)
        mark_reads(p, expr, reads);
    if (is_dry(p, part))
        reads[1 + program_n(p) / 2] = true;
    return reads;
}

/* The name of the function: of a single coordinate without that of the coordinate. */
static void put_name(const struct scene_program *p, enum part part, int row)
{
    const bool splits = p->method->splitting && p->written.system.velocity;
    buffer_put(p->out, !program_moves(p)   ? TEXT("slope")
                       : part == PART_DRAG ? TEXT("drag")
                       : splits            ? TEXT("force")
                                           : TEXT("acceleration"));
    if (p->written.rows > 1)
        buffer_format(p->out, "_%s", program_state(p, row));
}

/* Quantities of the user's own as names of their own. */
static void put_observed(struct scene_program *p, const bool *reads)
{
    const struct written *w = &p->written;
    for (int i = w->observed; i < w->names; i++) {
        if (!reads[i])
            continue;
        buffer_format(p->out, "    %s%s = ", p->syntax->constant, p->name[i]);
        program_expr(p, w->observe[i - w->observed]);
        buffer_format(p->out, "%s\n", p->syntax->stop);
    }
}

/* With dry friction: what is left of the other forces. */
static void put_dry(struct scene_program *p, const struct expr *expr)
{
    const struct syntax *s = p->syntax;
    const bool c = s->dialect == DIALECT_C;
    const char *v = program_state(p, program_n(p) / 2);
    buffer_format(p->out, "    %spull = ", s->constant);
    if (expr)
        program_expr(p, expr);
    else
        buffer_char(p->out, '0');
    buffer_format(p->out, "%s\n    %sfriction_most = ", s->stop, s->constant);
    program_expr(p, p->written.dry);
    buffer_format(p->out, "%s\n", s->stop);
    if (c)
        buffer_format(p->out,
                      "    if (%s == 0 && fabs(pull) <= friction_most)\n"
                      "        return 0; /* at rest it takes what pulls */\n"
                      "    return pull - copysign(friction_most, %s != 0 ? %s : pull);\n",
                      v, v, v);
    else
        buffer_format(p->out,
                      "    if %s == 0 and abs(pull) <= friction_most:\n"
                      "        return 0.0  # at rest it takes what pulls\n"
                      "    return pull - copysign(friction_most, %s if %s != 0 else pull)\n",
                      v, v, v);
}

static void put_arguments(const struct scene_program *p, const bool *reads, const char *type)
{
    int count = 0;
    for (int i = 0; i < 1 + program_n(p); i++)
        if (reads[i])
            buffer_format(p->out, "%s%s%s", count++ ? ", " : "", type, p->name[i]);
    if (count == 0)
        buffer_put(p->out, text_of(p->syntax->none));
}

/* In a language whose functions are one expression, what is observed is a function itself, and its
 * name from there on a call. */
static void put_observed_functions(struct scene_program *p, enum part part)
{
    const struct written *w = &p->written;
    bool *needed = arena_array(p->arena, (size_t)w->names, sizeof *needed);
    for (int row = 0; needed && row < w->rows; row++)
        if (expr_of(p, part, row))
            mark_reads(p, expr_of(p, part, row), needed);
    for (int i = w->observed; needed && i < w->names; i++) {
        bool *reads = arena_array(p->arena, (size_t)w->names, sizeof *reads);
        struct buffer call = {0};
        struct scene_program calls = *p;
        if (!needed[i] || strchr(p->name[i], '(') || !reads)
            continue;
        mark_reads(p, w->observe[i - w->observed], reads);
        calls.out = &call;
        buffer_format(&call, "%s(", p->name[i]);
        put_arguments(&calls, reads, "");
        buffer_char(&call, ')');
        buffer_format(p->out, "%s = @(", p->name[i]);
        put_arguments(p, reads, "");
        buffer_put(p->out, TEXT(") "));
        program_expr(p, w->observe[i - w->observed]);
        buffer_put(p->out, TEXT(";\n"));
        char *name = call.failed ? NULL : arena_text(p->arena, buffer_text(&call));
        p->out->failed |= !name;
        p->name[i] = name ? name : p->name[i];
        buffer_free(&call);
    }
    p->out->failed |= !needed;
}

static void put_function(struct scene_program *p, enum part part, int row)
{
    const struct syntax *s = p->syntax;
    const struct expr *expr = expr_of(p, part, row);
    bool *reads = reads_of(p, part, row);
    if (!reads)
        return;
    for (int i = 1 + program_n(p); i < p->written.names; i++)
        p->reads[i] |= reads[i];
    if (s->dialect == DIALECT_OCTAVE) {
        put_name(p, part, row);
        buffer_put(p->out, TEXT(" = @("));
        put_arguments(p, reads, "");
        buffer_put(p->out, TEXT(") "));
        program_expr(p, expr);
        buffer_put(p->out, TEXT(";\n"));
        return;
    }
    buffer_put(p->out, text_of(s->function));
    put_name(p, part, row);
    buffer_char(p->out, '(');
    put_arguments(p, reads, s->dialect == DIALECT_C ? "double " : "");
    buffer_format(p->out, ")%s", s->begin);
    put_observed(p, reads);
    if (is_dry(p, part)) {
        put_dry(p, expr);
    } else {
        buffer_format(p->out, "    %s ", s->result);
        program_expr(p, expr);
        buffer_format(p->out, "%s\n", s->stop);
    }
    buffer_format(p->out, "%s\n", s->end);
}

void program_functions(struct scene_program *p, enum part part)
{
    if (p->syntax->dialect == DIALECT_OCTAVE)
        put_observed_functions(p, part);
    for (int row = 0; row < p->written.rows && !cancelled(p->session->front.cancel); row++)
        if (expr_of(p, part, row) || is_dry(p, part))
            put_function(p, part, row);
}

bool program_call(struct scene_program *p, enum part part, int row, const char *time,
                  const char *suffix)
{
    if (!expr_of(p, part, row) && !is_dry(p, part)) {
        buffer_put(p->out, TEXT("0"));
        return false;
    }
    const bool *reads = reads_of(p, part, row);
    int count = 0;
    put_name(p, part, row);
    buffer_char(p->out, '(');
    for (int i = 0; reads && i < 1 + program_n(p); i++) {
        if (!reads[i])
            continue;
        buffer_format(p->out, "%s%s%s", count++ ? ", " : "",
                      i == 0 && time ? time
                      : p->argument  ? p->argument[i]
                                     : p->name[i],
                      i > 0 && suffix ? suffix : "");
    }
    buffer_char(p->out, ')');
    return true;
}
