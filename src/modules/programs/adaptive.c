/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steps whose size follows the error: the method's table, the tolerance, the loop. What the loop
 * calls is own_adaptive.h and own.py. */
#include "modules/programs/program.h"

#include <math.h>
#include <string.h>

#define NEAR "8*2.3e-16" /* of t: rows so near are one, as nearness() of src/run/even.c has it */

/* ---- tables ---- */

static bool in_c(const struct scene_program *p)
{
    return p->syntax->dialect == DIALECT_C;
}

/* As they stand in books, without brackets. */
static void put_weights(const struct scene_program *p, const double *weight, int count)
{
    struct buffer all = {0};
    const size_t wide = 90;
    size_t line = 0;
    for (int i = 0; i < count; i++) {
        struct buffer one = {0};
        struct scene_program plain = *p;
        plain.out = &one;
        program_weight(&plain, weight[i]);
        const struct text text = buffer_text(&one);
        const bool bracket = text.len > 0 && text.at[0] == '(', ends = all.len - line > wide;
        buffer_put(&all, i == 0 ? TEXT("") : ends ? TEXT(",\n    ") : TEXT(", "));
        line = ends ? all.len - 4 : line;
        buffer_put(&all, bracket ? (struct text){text.at + 1, text.len - 2} : text);
        all.failed |= one.failed;
        buffer_free(&one);
    }
    buffer_put(p->out, buffer_text(&all));
    p->out->failed |= all.failed;
    buffer_free(&all);
}

static void put_row(const struct scene_program *p, const char *name, const double *weight,
                    int count, const char *what)
{
    program_comment(p, "", what);
    if (in_c(p))
        buffer_format(p->out, "static const double %s[%d] = {\n    ", name, count);
    else
        buffer_format(p->out, "%s = [\n    ", name);
    put_weights(p, weight, count);
    buffer_put(p->out, in_c(p) ? TEXT("};\n") : TEXT("]\n"));
}

static void put_table(const struct scene_program *p, const struct runge_kutta *table)
{
    const int stages = table->stages;
    const bool c = in_c(p);
    put_row(p, "stage_time", table->c, stages, "where in a step its stages are");
    program_comment(p, "", "what they are made of; the last row is the state after the step");
    if (c)
        buffer_format(p->out, "static const double stage_weight[%d][%d] = {\n", stages, stages);
    else
        buffer_put(p->out, TEXT("stage_weight = [\n"));
    for (int s = 0; s < stages; s++) {
        buffer_put(p->out, c ? TEXT("    {") : TEXT("    ["));
        put_weights(p, table->a + s * (s - 1) / 2, s);
        buffer_put(p->out, c && s == 0             ? TEXT("0")
                           : !c && s == stages - 1 ? TEXT(", 0")
                                                   : TEXT(""));
        buffer_put(p->out, c ? TEXT("},\n") : TEXT("],\n"));
    }
    buffer_put(p->out, c ? TEXT("};\n") : TEXT("]\n"));
    put_row(p, "weight_low", table->b_hat, stages,
            "the same of a method of lower order: the difference is the error");
    if (p->settings.record.rule == RECORD_TIMES)
        put_row(p, "weight_inside", table->bend, stages,
                "by which the state bends inside of a step");
}

static void put_number(const struct scene_program *p, const char *name, double value,
                       const char *what)
{
    char z[REAL_TEXT_SIZE];
    real_format(value, z);
    const bool whole = !in_c(p) && !strpbrk(z, ".eni");
    buffer_format(p->out,
                  in_c(p) ? "static const double %s = %s%s; /* %s */\n" : "%s = %s%s  # %s\n", name,
                  z, whole ? ".0" : "", what);
}

void program_adaptive_functions(struct scene_program *p)
{
    struct runge_kutta table;
    double most;
    int order;
    method_runge_kutta(p->method, &table);
    method_error_control(p->method, p->settings.tol, &most, &order);
    put_number(p, "error_most", most, "that a step is accepted with, of the size of the state");
    buffer_format(p->out,
                  in_c(p) ? "enum { error_order = %d }; /* in the step's size */\n"
                          : "error_order = %d  # in the step's size\n",
                  order);
    program_sizes(p);
    put_table(p, &table);
    buffer_put(p->out, in_c(p) ? TEXT("\n") : TEXT("\n\n"));
    program_functions(p, PART_ALL);
    program_derivatives(p);
    if (p->turns)
        program_acceleration_at(p);
}

/* ---- what is refused ---- */

bool program_refuse_adaptive(struct scene_program *p)
{
    struct runge_kutta table;
    const struct system *system = &p->written.system;
    const char *name = p->method->row.name;
    double most;
    int order;
    const bool ode45 = p->syntax->dialect == DIALECT_OCTAVE;
    if (ode45 && method_runge_kutta(p->method, &table))
        return true;
    if (ode45 || !method_runge_kutta(p->method, &table) ||
        !method_error_control(p->method, p->settings.tol, &most, &order)) {
        error_set(p->error, ERROR_COMMAND, "steps of %s that follow the error are not written",
                  name);
        return error_hint(p->error,
                          "those of dopri5, tsit5, bogacki-shampine are; method %s dt=10ms "
                          "takes steps of one size",
                          name);
    }
    if (p->settings.record.rule == RECORD_TIMES && !table.bend) {
        error_set(p->error, ERROR_COMMAND, "rows inside of steps of %s are not written", name);
        return error_hint(p->error, "'set record all' keeps the ends of steps");
    }
    for (int i = 0; i < system->n; i++)
        if (system->atol[i] > 0)
            return error_set(p->error, ERROR_COMMAND, "the tolerance of %s alone is not written",
                             system_variable(system, i).name);
    return true;
}

/* ---- the loop ---- */

static bool at_times(const struct scene_program *p)
{
    return p->settings.record.rule == RECORD_TIMES;
}

static int64_t every(const struct scene_program *p)
{
    return p->settings.record.rule == RECORD_EVERY ? p->settings.record.every : 1;
}

static void put_variables(const struct scene_program *p)
{
    for (int i = 0; i < program_n(p); i++)
        buffer_format(p->out, "%s%s", i ? ", " : "", program_state(p, i));
}

/* "t0 + (double)row*interval" */
static void put_due(const struct scene_program *p, const char *row)
{
    buffer_format(p->out, "%s%s%s*interval", p->written.system.t0 != 0 ? "t0 + " : "",
                  in_c(p) ? "(double)" : "", row);
}

void program_adaptive_constants(struct scene_program *p)
{
    const double t0 = p->written.system.t0;
    put_number(p, "dt", p->settings.dt, "[s] first step");
    if (t0 != 0 && at_times(p))
        put_number(p, "t0", t0, "[s] start");
    put_number(p, "t_end", t0 + p->duration, "[s] end");
    if (at_times(p))
        put_number(p, "interval", p->settings.record.interval, "[s] from row to row");
}

static void put_printf(struct scene_program *p, const char *indent, const char *inside)
{
    buffer_format(p->out, "%s%s(\"", indent, "printf");
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_put(p->out, i ? TEXT(",%.17g") : TEXT("%.17g"));
    buffer_put(p->out, TEXT("\\n\", "));
    if (inside)
        put_due(p, "row");
    else
        buffer_put(p->out, text_of(p->name[0]));
    for (int i = 0; i < program_n(p); i++)
        if (inside)
            buffer_format(p->out, ", %s[%d]", inside, i);
        else
            buffer_format(p->out, ", %s", program_state(p, i));
    buffer_put(p->out, TEXT(");\n"));
}

static void put_rows_c(struct scene_program *p)
{
    if (at_times(p)) {
        buffer_put(p->out, TEXT("        for (; adaptive_row(t, state, "));
        put_due(p, "row");
        buffer_put(p->out, TEXT(", inside); row++)\n"));
        put_printf(p, "            ", "inside");
    } else if (every(p) > 1) {
        buffer_format(p->out, "        if (++row %% %lld == 0 || t == t_end)\n",
                      (long long)every(p));
        put_printf(p, "            ", NULL);
    } else {
        put_printf(p, "        ", NULL);
    }
    buffer_put(p->out, TEXT("    }\n"));
    if (!at_times(p))
        return;
    /* the end is a row, too */
    buffer_put(p->out, TEXT("    if (t - ("));
    put_due(p, "(row - 1)");
    buffer_format(p->out, ") > %s*fabs(t))\n", NEAR);
    put_printf(p, "        ", NULL);
}

void program_adaptive_loop_c(struct scene_program *p)
{
    const int n = program_n(p);
    buffer_put(p->out, TEXT("    double state[] = {"));
    put_variables(p);
    buffer_format(p->out, at_times(p) ? "}, inside[%d];\n" : "};\n", n);
    if (at_times(p) || every(p) > 1)
        buffer_format(p->out, "    long row = %d;\n", at_times(p));
    buffer_format(p->out,
                  "    while (t < t_end) {\n"
                  "        int good;\n"
                  "        adaptive_begin(t, state);\n"
                  "        do {\n"
                  "            adaptive_try(t_end, state);\n"
                  "%s"
                  "        } while ((good = adaptive_accepts(&t, t_end, state)) == 0);\n"
                  "        if (good < 0) {\n"
                  "            fprintf(stderr, \"no step is good after t = %%g\\n\", t);\n"
                  "            return 3;\n"
                  "        }\n",
                  p->turns ? "            adaptive_turn(state);\n" : "");
    for (int i = 0; i < n; i++)
        buffer_format(p->out, "        %s = state[%d];\n", program_state(p, i), i);
    program_bounds(p, "        ");
    put_rows_c(p);
    buffer_put(p->out, TEXT("    return 0;\n}\n"));
}

static void put_rows_python(struct scene_program *p)
{
    if (at_times(p)) {
        buffer_put(p->out, TEXT("    while (inside := control.row("));
        put_due(p, "row");
        buffer_put(p->out, TEXT(")) is not None:\n        rows.append(("));
        put_due(p, "row");
        buffer_put(p->out, TEXT(", *inside))\n        row += 1\nif t - ("));
        put_due(p, "(row - 1)");
        buffer_format(p->out, ") > %s*abs(t):\n    ", NEAR);
    } else if (every(p) > 1) {
        buffer_format(p->out, "    row += 1\n    if row %% %lld == 0 or t == t_end:\n        ",
                      (long long)every(p));
    } else {
        buffer_put(p->out, TEXT("    "));
    }
    buffer_format(p->out, "rows.append((%s, ", p->name[0]);
    put_variables(p);
    buffer_put(p->out, TEXT("))\n"));
}

void program_adaptive_loop_python(struct scene_program *p)
{
    buffer_put(p->out, TEXT("control = Adaptive(t, dt, ["));
    put_variables(p);
    buffer_put(p->out, TEXT("])\n"));
    if (at_times(p) || every(p) > 1)
        buffer_format(p->out, "row = %d\n", at_times(p));
    buffer_put(p->out, TEXT("while t < t_end:\n    control.begin(t, ["));
    put_variables(p);
    buffer_format(p->out,
                  "])\n"
                  "    good = 0\n"
                  "    while good == 0:\n"
                  "        control.attempt(t_end)\n"
                  "%s"
                  "        good = control.accepts(t_end)\n"
                  "    if good < 0:\n"
                  "        print(\"no step is good after t =\", t, file=sys.stderr)\n"
                  "        break\n"
                  "    ",
                  p->turns ? "        turn(control)\n" : "");
    put_variables(p);
    buffer_put(p->out,
               program_n(p) == 1 ? TEXT(", = control.after\n") : TEXT(" = control.after\n"));
    program_bounds(p, "    ");
    buffer_put(p->out, TEXT("    t = control.ends\n"));
    put_rows_python(p);
}
