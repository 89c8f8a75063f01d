/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of an explicit method, statement by statement, with the operations of
 * src/method/step/rk_body.h and split_body.h. */
#include "modules/programs/program.h"

#include <math.h>
#include <string.h>

/* ---- words ---- */

static bool begins_as_counted(const char *name, char letter)
{
    return name[0] == letter &&
           (name[1] == '\0' || name[1] == '_' || strspn(name + 1, "0123456789"));
}

/* "a" for accelerations, unless the scene has such names. */
static const char *slope_word(const struct scene_program *p)
{
    if (!program_moves(p))
        return "slope";
    for (int i = 0; i < p->written.names; i++)
        if (begins_as_counted(p->name[i], 'a'))
            return "slope";
    return "a";
}

/* The slope of a row at a stage, 0: the only one. */
static void put_slope(const struct scene_program *p, int row, int stage)
{
    buffer_put(p->out, text_of(slope_word(p)));
    if (stage > 0)
        buffer_format(p->out, "%d", stage);
    if (p->written.rows > 1)
        buffer_format(p->out, "_%s", program_state(p, row));
}

static void put_weighted(const struct scene_program *p, double weight)
{
    if (weight != 1) {
        program_weight(p, weight);
        buffer_char(p->out, '*');
    }
    buffer_put(p->out, text_of(p->step));
}

static void begin(const struct scene_program *p, const char *indent, const char *word)
{
    buffer_format(p->out, "%s%s", indent, word);
}

static void end(const struct scene_program *p)
{
    buffer_format(p->out, "%s\n", p->syntax->stop);
}

/* Is the variable an argument of some force? */
static bool is_read(const struct scene_program *p, int i)
{
    const struct written *w = &p->written;
    bool *reads = arena_array(p->arena, (size_t)w->names, sizeof *reads);
    for (int row = 0; reads && row < w->rows && !cancelled(w->cancel); row++)
        if (w->all[row] && !expr_reads(w->all[row], w->zero, reads))
            return true;
    for (int k = w->observed; reads && k < w->names; k++)
        if (!expr_reads(w->observe[k - w->observed], w->zero, reads))
            return true;
    return !reads || reads[1 + i];
}

/* ---- Runge-Kutta methods ---- */

enum { NEW = -1 }; /* stage: the state after the step */

static void put_state(const struct scene_program *p, int i, int stage)
{
    buffer_put(p->out, text_of(program_state(p, i)));
    if (stage == NEW)
        buffer_put(p->out, TEXT("_new"));
    else if (stage > 1)
        buffer_format(p->out, "_at%d", stage);
}

/* What changes variable i at a stage: a velocity, or a slope. */
static void put_rate(const struct scene_program *p, int i, int stage)
{
    const int positions = program_n(p) - p->written.rows;
    if (i < positions)
        put_state(p, i + positions, stage);
    else
        put_slope(p, i - positions, stage);
}

/* y + (h w_1 k_1 + ...) */
static void put_combination(const struct scene_program *p, int i, const double *w, int count)
{
    int terms = 0;
    size_t line = p->out->len;
    for (int j = 0; j < count; j++)
        terms += w[j] != 0;
    buffer_put(p->out, text_of(program_state(p, i)));
    buffer_put(p->out, terms > 1 ? TEXT(" + (") : TEXT(""));
    for (int j = 0, done = 0; j < count; j++) {
        if (w[j] == 0)
            continue;
        if (done++ > 0 || terms == 1)
            buffer_put(p->out, TEXT(" + "));
        if (p->out->len - line > 60 && done > 1) {
            p->out->len--;
            buffer_put(p->out, text_of(p->syntax->newline));
            line = p->out->len;
        }
        buffer_put(p->out, text_of(p->step));
        if (w[j] != 1) {
            buffer_char(p->out, '*');
            program_weight(p, w[j]);
        }
        buffer_char(p->out, '*');
        put_rate(p, i, j + 1);
    }
    buffer_put(p->out, terms > 1 ? TEXT(")") : TEXT(""));
}

static void put_stage_time(const struct scene_program *p, double c, struct buffer *text)
{
    struct scene_program at = *p;
    at.out = text;
    buffer_put(text, TEXT("t"));
    if (c == 0)
        return;
    buffer_put(text, TEXT(" + "));
    put_weighted(&at, c);
}

static void put_slopes(struct scene_program *p, const char *indent, int stage, int state, double c,
                       const char *word)
{
    struct buffer time = {0}, suffix = {0};
    put_stage_time(p, c, &time);
    if (state == NEW)
        buffer_put(&suffix, TEXT("_new"));
    else if (state > 1)
        buffer_format(&suffix, "_at%d", state);
    for (int row = 0; row < p->written.rows; row++) {
        begin(p, indent, word);
        put_slope(p, row, stage);
        buffer_put(p->out, TEXT(" = "));
        program_call(p, PART_ALL, row, buffer_view(&time), buffer_view(&suffix));
        end(p);
    }
    p->out->failed |= time.failed || suffix.failed;
    buffer_free(&time);
    buffer_free(&suffix);
}

static void rk_before(struct scene_program *p, const struct runge_kutta *table, const char *indent)
{
    if (!table->fsal)
        return;
    program_comment(p, indent, "the last stage of a step is the first one of the next");
    put_slopes(p, indent, 1, 1, 0, p->syntax->variable);
}

static void rk_step(struct scene_program *p, const struct runge_kutta *table, const char *indent)
{
    const int n = program_n(p), stages = table->stages, positions = n - p->written.rows;
    const struct syntax *s = p->syntax;
    if (!table->fsal)
        put_slopes(p, indent, 1, 1, 0, s->constant);
    for (int stage = 1; stage < stages; stage++) {
        const double *a = table->a + stage * (stage - 1) / 2;
        const int at = table->fsal && stage == stages - 1 ? NEW : stage + 1;
        for (int i = 0; i < n; i++) {
            if (at != NEW && !(i >= positions && program_moves(p)) && !is_read(p, i))
                continue;
            begin(p, indent, s->constant);
            put_state(p, i, at);
            buffer_put(p->out, TEXT(" = "));
            put_combination(p, i, a, stage);
            end(p);
        }
        put_slopes(p, indent, stage + 1, at, table->c[stage], s->constant);
    }
    for (int i = 0; i < n; i++) {
        begin(p, indent, program_state(p, i));
        buffer_put(p->out, TEXT(" = "));
        if (table->fsal)
            put_state(p, i, NEW);
        else
            put_combination(p, i, table->b, stages);
        end(p);
    }
    for (int row = 0; table->fsal && row < p->written.rows; row++) {
        begin(p, indent, "");
        put_slope(p, row, 1);
        buffer_put(p->out, TEXT(" = "));
        put_slope(p, row, stages);
        end(p);
    }
}

/* ---- splittings ---- */

static void put_forces(struct scene_program *p, const char *indent, const char *word,
                       const char *time)
{
    for (int row = 0; row < p->written.rows; row++) {
        begin(p, indent, word);
        put_slope(p, row, 0);
        buffer_put(p->out, TEXT(" = "));
        program_call(p, PART_FORCE, row, time, NULL);
        end(p);
    }
}

static bool drags(const struct scene_program *p, enum drag drag)
{
    return p->written.system.velocity && p->drag == drag;
}

/* v' = v + w a, or with the drag at v. */
static void put_kick(struct scene_program *p, const char *indent, double weight, int kick,
                     const char *time)
{
    const int rows = p->written.rows;
    const bool drag = drags(p, DRAG_EXPLICIT);
    for (int row = 0; drag && rows > 1 && row < rows; row++) {
        begin(p, indent, p->syntax->constant);
        buffer_format(p->out, "drag%d_%s = ", kick, program_state(p, row));
        program_call(p, PART_DRAG, row, time, NULL);
        end(p);
    }
    for (int row = 0; row < rows; row++) {
        const char *v = program_state(p, rows + row);
        buffer_format(p->out, "%s%s = %s + ", indent, v, v);
        put_weighted(p, weight);
        buffer_put(p->out, drag ? TEXT("*(") : TEXT("*"));
        put_slope(p, row, 0);
        if (drag && rows > 1) {
            buffer_format(p->out, " + drag%d_%s)", kick, program_state(p, row));
        } else if (drag) {
            buffer_put(p->out, TEXT(" + "));
            program_call(p, PART_DRAG, row, time, NULL);
            buffer_char(p->out, ')');
        }
        end(p);
    }
}

static void put_drift(const struct scene_program *p, const char *indent, double weight)
{
    for (int row = 0; row < p->written.rows; row++) {
        const char *q = program_state(p, row);
        buffer_format(p->out, "%s%s = %s + ", indent, q, q);
        put_weighted(p, weight);
        buffer_format(p->out, "*%s", program_state(p, p->written.rows + row));
        end(p);
    }
}

/* What half a step does to v of v' = -gamma v - c |v| v: oscillator_drag_flow(). */
static void put_flow(struct scene_program *p, const char *indent)
{
    const struct oscillator *o = &p->written.system.oscillator;
    const struct syntax *s = p->syntax;
    const char *exp = s->dialect == DIALECT_C ? "fixed_exp" : "exp",
               *expm1 = s->dialect == DIALECT_C ? "fixed_expm1" : "expm1";
    struct buffer gamma = {0}, *out = p->out;
    p->out = &gamma;
    program_coefficient(p, fabs(o->damping), "gamma", NULL);
    p->out = out;
    program_comment(p, indent, "v' = -gamma v - c |v| v has a closed form: of half a step");
    buffer_format(p->out, "%s%skeep = %s(-(%s*(%s/2)))%s\n", indent, s->constant, exp,
                  buffer_view(&gamma), p->step, s->stop);
    if (o->quadratic != 0) {
        buffer_format(p->out, "%s%shalf = ", indent, s->constant);
        buffer_real(p->out, o->quadratic);
        if (o->damping != 0)
            buffer_format(p->out, "*(-%s(-(%s*(%s/2)))/%s)", expm1, buffer_view(&gamma), p->step,
                          buffer_view(&gamma));
        else
            buffer_format(p->out, "*(%s/2)", p->step);
        end(p);
    }
    buffer_free(&gamma);
}

static void put_half_drag(const struct scene_program *p, const char *indent)
{
    const struct oscillator *o = &p->written.system.oscillator;
    const char *abs = p->syntax->dialect == DIALECT_C ? "fabs" : "abs";
    const bool grows = o->damping < 0;
    for (int row = 0; row < p->written.rows; row++) {
        const char *v = program_state(p, p->written.rows + row);
        buffer_format(p->out, "%s%s = %s", indent, v, v);
        if (!grows)
            buffer_put(p->out, TEXT("*keep"));
        if (o->quadratic != 0)
            buffer_format(p->out, "/(%s + half*%s(%s))", grows ? "keep" : "1", abs, v);
        else if (grows)
            buffer_put(p->out, TEXT("/keep"));
        end(p);
    }
}

static void split_before(struct scene_program *p, const double *weight, int count, bool kick_first,
                         const char *indent)
{
    (void)weight;
    if (drags(p, DRAG_EXACT) && !p->partial)
        put_flow(p, indent);
    if (kick_first && count % 2 == 1)
        put_forces(p, indent, p->syntax->variable, "t");
}

static void split_step(struct scene_program *p, const double *weight, int count, bool kick_first,
                       const char *indent)
{
    const bool around = drags(p, DRAG_EXACT), continues = kick_first && count % 2 == 1;
    struct buffer time = {0};
    buffer_put(&time, TEXT("t"));
    if (around && p->partial)
        put_flow(p, indent);
    if (around)
        put_half_drag(p, indent);
    for (int i = 0, kicks = 0; i < count; i++) {
        if ((i % 2 == 0) == kick_first) {
            if (!(continues && i == 0))
                put_forces(p, indent, !continues && kicks == 0 ? p->syntax->variable : "",
                           buffer_view(&time));
            put_kick(p, indent, weight[i], ++kicks, buffer_view(&time));
        } else {
            struct scene_program at = *p;
            put_drift(p, indent, weight[i]);
            buffer_put(&time, TEXT(" + "));
            at.out = &time;
            put_weighted(&at, weight[i]);
        }
    }
    if (around)
        put_half_drag(p, indent);
    p->out->failed |= time.failed;
    buffer_free(&time);
}

/* ---- any ---- */

void program_before(struct scene_program *p, const char *indent)
{
    struct runge_kutta table;
    double weight[SPLITTING_WEIGHTS];
    bool kick_first;
    const int count = method_splitting(p->method, weight, &kick_first);
    if (method_runge_kutta(p->method, &table))
        rk_before(p, &table, indent);
    else if (count > 0)
        split_before(p, weight, count, kick_first, indent);
}

/* A last step that is shorter begins anew. */
static bool begins_anew(const struct scene_program *p, const struct runge_kutta *table, int count,
                        bool kick_first)
{
    return p->partial && !p->written.system.autonomous &&
           (count > 0 ? kick_first && count % 2 == 1 : table->fsal);
}

void program_step(struct scene_program *p, const char *indent)
{
    struct runge_kutta table = {0};
    double weight[SPLITTING_WEIGHTS];
    bool kick_first;
    const int count = method_splitting(p->method, weight, &kick_first);
    const bool rk = method_runge_kutta(p->method, &table);
    if (begins_anew(p, &table, count, kick_first))
        for (int row = 0; row < p->written.rows; row++) {
            buffer_format(p->out, "%s%s%s%s", indent, p->syntax->if_then, p->syntax->last,
                          p->syntax->if_end);
            put_slope(p, row, rk ? 1 : 0);
            buffer_put(p->out, TEXT(" = "));
            program_call(p, rk ? PART_ALL : PART_FORCE, row, "t", NULL);
            end(p);
            buffer_put(p->out, p->syntax->dialect == DIALECT_OCTAVE ? TEXT("    end\n") : TEXT(""));
        }
    if (rk)
        rk_step(p, &table, indent);
    else if (count > 0)
        split_step(p, weight, count, kick_first, indent);
    else
        program_implicit_step(p, indent);
}
