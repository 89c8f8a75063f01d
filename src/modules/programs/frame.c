/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs that compute: C, Python, Octave. The forces, one loop. */
#include "modules/programs/program.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- the loop ---- */

static void put_start(struct scene_program *p, const char *indent)
{
    const struct system *system = &p->written.system;
    const struct syntax *s = p->syntax;
    for (int i = -1; i < system->n; i++) {
        const char *unit = i < 0 ? "s" : quantity_unit(system->model->variable[i].quantity);
        const double value = i < 0 ? system->t0 : system->start[i];
        char z[REAL_TEXT_SIZE];
        real_format(value, z);
        const bool whole = s->dialect == DIALECT_PYTHON && !strpbrk(z, ".eni");
        buffer_format(p->out, "%s%s%s = ", indent, s->variable, p->name[1 + i]);
        buffer_format(p->out, "%s%s%s", z, whole ? ".0" : "", s->stop);
        if (unit[0])
            buffer_format(p->out, "%s%s[%s]%s", s->dialect == DIALECT_PYTHON ? "  " : " ",
                          s->comment, unit, s->comment_end);
        buffer_char(p->out, '\n');
    }
}

/* "t, y, v" */
static void put_row(struct scene_program *p)
{
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_format(p->out, "%s%s", i ? ", " : "", p->name[i]);
}

static void put_heading(struct scene_program *p)
{
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_format(p->out, "%s%s", i ? "," : "", p->written.name[i]);
}

static void put_printf(struct scene_program *p, const char *indent)
{
    buffer_put(p->out, text_of(indent));
    buffer_put(p->out, TEXT("printf(\""));
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_format(p->out, "%s%%.17g", i ? "," : "");
    buffer_put(p->out, TEXT("\\n\", "));
    put_row(p);
    buffer_put(p->out, TEXT(");\n"));
}

/* Before a step: its length, where the last one is shorter. */
static void put_length(struct scene_program *p, const char *indent)
{
    const struct syntax *s = p->syntax;
    if (!p->partial)
        return;
    const double end = p->written.system.t0 + p->duration;
    char z[REAL_TEXT_SIZE];
    real_format(end, z);
    if (s->dialect == DIALECT_C)
        buffer_format(p->out, "%sconst double h = %s ? %s - t : dt;\n", indent, s->last, z);
    else if (s->dialect == DIALECT_PYTHON)
        buffer_format(p->out, "%sh = %s - t if %s else dt\n", indent, z, s->last);
    else
        buffer_format(p->out, "%sh = dt;\n%sif %s\n%s    h = %s - t;\n%send\n", indent, indent,
                      s->last, indent, z, indent);
}

/* The time after a step. */
static void put_time(struct scene_program *p, const char *indent)
{
    const struct syntax *s = p->syntax;
    const double t0 = p->written.system.t0, end = t0 + p->duration;
    const double found = t0 + (double)p->plan.whole * p->settings.dt;
    buffer_format(p->out, "%st = %s%s*dt%s\n", indent, t0 != 0 ? "t0 + " : "", s->count, s->stop);
    if (!p->partial && found == end)
        return;
    char z[REAL_TEXT_SIZE];
    real_format(end, z);
    buffer_format(p->out, "%s%s%s%st = %s%s\n", indent, s->if_then, s->last, s->if_end, z, s->stop);
    if (s->dialect == DIALECT_OCTAVE)
        buffer_format(p->out, "%send\n", indent);
}

/* Is the state what a run goes on with? */
void program_bounds(struct scene_program *p, const char *indent)
{
    const struct system *system = &p->written.system;
    const bool c = p->syntax->dialect == DIALECT_C, octave = p->syntax->dialect == DIALECT_OCTAVE;
    buffer_format(p->out, "%sif %s(", indent, c ? "(!" : octave ? "~" : "not ");
    for (int i = 0; i < system->n; i++) {
        buffer_format(p->out, "%s%s(%s) <= ",
                      i == 0        ? ""
                      : c || octave ? " && "
                                    : " and ",
                      c ? "fabs" : "abs", program_state(p, i));
        buffer_real(p->out, c ? run_bound(system, i) : 1e150);
    }
    if (c)
        buffer_format(p->out,
                      ")) {\n%s    fprintf(stderr, \"diverged after t = %%g\\n\", t);\n"
                      "%s    return 3;\n%s}\n",
                      indent, indent, indent);
    else if (octave)
        buffer_format(p->out,
                      ")\n%s    warning('diverged after t = %%g', t);\n%s    break\n%send\n",
                      indent, indent, indent);
    else
        buffer_format(p->out,
                      "):\n%s    print(\"diverged after t =\", t, file=sys.stderr)\n%s    break\n",
                      indent, indent);
}

static void put_steps(struct scene_program *p)
{
    static const char *const loop[] = {[DIALECT_C] = "    for (long i = 0; i < steps; i++) {\n",
                                       [DIALECT_PYTHON] = "for i in range(steps):\n",
                                       [DIALECT_OCTAVE] = "for i = 1:steps\n"};
    const bool c = p->syntax->dialect == DIALECT_C;
    const char *indent = c || p->raises ? "        " : "    ";
    if (!p->turns)
        program_before(p, c ? "    " : "");
    buffer_put(p->out, p->raises ? TEXT("try:\n    ") : TEXT(""));
    buffer_put(p->out, text_of(loop[p->syntax->dialect]));
    put_length(p, indent);
    if (p->turns)
        buffer_format(p->out, "%s%s, %s = turning_step(t, %s, [%s, %s])\n", indent,
                      program_state(p, 0), program_state(p, 1), p->step, program_state(p, 0),
                      program_state(p, 1));
    else
        program_step(p, indent);
    program_bounds(p, indent);
    put_time(p, indent);
}

void program_acceleration_at(struct scene_program *p)
{
    const bool c = p->syntax->dialect == DIALECT_C;
    const char *y = program_state(p, 0), *v = program_state(p, 1);
    buffer_format(p->out,
                  c ? "static double acceleration_at(double t, const double state[])\n{\n"
                      "    const double %s = state[0], %s = state[1];\n"
                      "    (void)t, (void)%s, (void)%s;\n    return "
                    : "def acceleration_at(t, state):\n    %s, %s = state\n    return ",
                  y, v, y, v);
    program_call(p, PART_ALL, 0, "t", NULL);
    buffer_put(p->out, c ? TEXT(";\n}\n\n") : TEXT("\n\n\n"));
}

/* One step as a function of a state of two, which others call with lengths of their own. */
static void put_step_function(struct scene_program *p)
{
    const bool c = p->syntax->dialect == DIALECT_C;
    struct scene_program whole = *p;
    const char *y = program_state(p, 0), *v = program_state(p, 1);
    whole.step = "h";
    whole.partial = true; /* its length may be any */
    if (c)
        buffer_format(p->out,
                      "/* One step of %s. */\n"
                      "static void step(double t, double h, double state[])\n{\n"
                      "    double %s = state[0], %s = state[1];\n    (void)t;\n",
                      p->method->row.name, y, v);
    else
        buffer_format(p->out, "def step(t, h, state):  # of %s\n    %s, %s = state\n",
                      p->method->row.name, y, v);
    program_before(&whole, "    ");
    program_step(&whole, "    ");
    buffer_format(p->out,
                  c ? "    state[0] = %s;\n    state[1] = %s;\n}\n\n" : "    return [%s, %s]\n\n\n",
                  y, v);
    if (p->turns)
        program_acceleration_at(p);
}

/* A step of the loop: hooke multiplies by powers of the matrix of one step, or takes pieces. */
static void put_stepping_c(struct scene_program *p)
{
    if (p->turns)
        buffer_format(p->out, "        turning_step(t, %s, state);\n", p->step);
    else if (p->partial)
        buffer_format(p->out,
                      "        if (%s)\n            step(t, h, state);\n"
                      "        else\n            propagate(i, state);\n",
                      p->syntax->last);
    else
        buffer_put(p->out, TEXT("        propagate(i, state);\n"));
}

static void put_called_c(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    const bool symplectic = p->method->flags & METHOD_SYMPLECTIC && system->conservative;
    const char *y = program_state(p, 0), *v = program_state(p, 1);
    put_step_function(p);
    buffer_put(p->out, p->turns
                           ? TEXT("/* The force bends where the velocity turns: steps end there "
                                  "('set turning off': not). */\n")
                           : TEXT("/* The scene is linear: hooke takes 32 steps at once by powers "
                                  "of the matrix of one\n"
                                  " * ('set kernel specialised': one by one). */\n"));
    buffer_put(p->out, TEXT("int main(void)\n{\n"));
    put_start(p, "    ");
    buffer_format(p->out, "    double state[] = {%s, %s};\n    puts(\"", y, v);
    put_heading(p);
    buffer_put(p->out, TEXT("\");\n"));
    put_printf(p, "    ");
    if (!p->turns)
        buffer_format(p->out, "    propagate_prepare(dt, %s);\n", symplectic ? "true" : "false");
    buffer_put(p->out, TEXT("    for (long i = 0; i < steps; i++) {\n"));
    put_length(p, "        ");
    put_stepping_c(p);
    buffer_format(p->out, "        %s = state[0];\n        %s = state[1];\n", y, v);
    program_bounds(p, "        ");
    put_time(p, "        ");
    put_printf(p, "        ");
    buffer_put(p->out, TEXT("    }\n    return 0;\n}\n"));
}

static void put_main_c(struct scene_program *p)
{
    if (!p->plan.adaptive && (p->plan.propagates || p->turns)) {
        put_called_c(p);
        return;
    }
    buffer_put(p->out, TEXT("int main(void)\n{\n"));
    put_start(p, "    ");
    buffer_put(p->out, TEXT("    puts(\""));
    put_heading(p);
    buffer_put(p->out, TEXT("\");\n"));
    put_printf(p, "    ");
    if (p->plan.adaptive) {
        program_adaptive_loop_c(p);
        return;
    }
    put_steps(p);
    put_printf(p, "        ");
    buffer_put(p->out, TEXT("    }\n    return 0;\n}\n"));
}

static void put_main_python(struct scene_program *p)
{
    if (p->turns && !p->plan.adaptive)
        put_step_function(p);
    put_start(p, "");
    buffer_put(p->out, TEXT("rows = [("));
    put_row(p);
    buffer_put(p->out, TEXT(")]\n"));
    if (p->plan.adaptive) {
        program_adaptive_loop_python(p);
    } else {
        put_steps(p);
        buffer_put(p->out, p->raises ? TEXT("        rows.append((") : TEXT("    rows.append(("));
        put_row(p);
        buffer_put(p->out, TEXT("))\n"));
        buffer_put(p->out, p->raises
                               ? TEXT("except (OverflowError, ValueError, ZeroDivisionError):\n"
                                      "    print(\"diverged after t =\", t, file=sys.stderr)\n")
                               : TEXT(""));
    }
    buffer_put(p->out, TEXT("\nif \"--plot\" in sys.argv:\n"
                            "    import matplotlib.pyplot as plt\n\n"
                            "    plt.plot([row[0] for row in rows], [row[1] for row in rows])\n"));
    const struct variable first = p->written.system.model->variable[0];
    const char *unit = quantity_unit(first.quantity);
    buffer_format(p->out,
                  "    plt.xlabel(\"t [s]\")\n    plt.ylabel(\"%s%s%s%s\")\n    plt.show()\n",
                  first.name, unit[0] ? " [" : "", unit, unit[0] ? "]" : "");
    buffer_put(p->out, TEXT("else:\n    print(\""));
    put_heading(p);
    buffer_put(p->out, TEXT("\")\n    for row in rows:\n        print(*row, sep=\",\")\n"));
}

static void put_octave_rows(struct scene_program *p, const char *rows)
{
    buffer_put(p->out, TEXT("printf('"));
    put_heading(p);
    buffer_put(p->out, TEXT("\\n');\nprintf('"));
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_format(p->out, "%s%%.17g", i ? "," : "");
    buffer_format(p->out, "\\n', %s');\n", rows);
}

/* By the library's own Dormand-Prince pair. */
static void put_ode45(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    const int n = system->n, positions = n - p->written.rows;
    char z[REAL_TEXT_SIZE], text[16], *argument[1 + LIMIT_VARIABLES] = {p->name[0]};
    struct scene_program called = *p;
    called.argument = argument;
    buffer_put(p->out, TEXT("slopes = @(t, s) ["));
    for (int i = 0; i < n; i++) {
        snprintf(text, sizeof text, "s(%d)", i + 1);
        argument[1 + i] = arena_text(p->arena, text_of(text));
        if (!argument[1 + i]) {
            p->out->failed = true;
            return;
        }
    }
    for (int i = 0; i < n; i++) {
        buffer_put(p->out, i ? TEXT("; ") : TEXT(""));
        if (i < positions)
            buffer_put(p->out, text_of(argument[1 + i + positions]));
        else
            program_call(&called, PART_ALL, i - positions, "t", NULL);
    }
    real_format(p->settings.tol, z);
    buffer_format(p->out, "];\ntol = odeset('RelTol', %s, 'AbsTol', %s*[", z, z);
    for (int i = 0; i < n; i++) {
        real_format(system->scale[i], z);
        buffer_format(p->out, "%s%s", i ? ", " : "", z);
    }
    real_format(system->t0, z);
    buffer_format(p->out, "]);\n[t, s] = ode45(slopes, [%s, ", z);
    real_format(system->t0 + p->duration, z);
    buffer_format(p->out, "%s], [", z);
    for (int i = 0; i < n; i++) {
        real_format(system->start[i], z);
        buffer_format(p->out, "%s%s", i ? "; " : "", z);
    }
    buffer_put(p->out, TEXT("], tol);\n"));
    put_octave_rows(p, "[t, s]");
}

static void put_main_octave(struct scene_program *p)
{
    if (p->plan.adaptive) {
        put_ode45(p);
        return;
    }
    put_start(p, "");
    buffer_format(p->out, "rows = zeros(steps + 1, %d);\nrows(1, :) = [", 1 + program_n(p));
    put_row(p);
    buffer_put(p->out, TEXT("];\n"));
    put_steps(p);
    buffer_put(p->out, TEXT("    rows(i + 1, :) = ["));
    put_row(p);
    buffer_put(p->out, TEXT("];\nend\n"));
    put_octave_rows(p, "rows");
    buffer_put(p->out, TEXT("% plot(rows(:, 1), rows(:, 2)); xlabel('t [s]');\n"));
}

static void put_functions(struct scene_program *p)
{
    const bool splits = p->method->splitting != NULL;
    if (method_is_backward_euler(p->method)) {
        program_implicit_functions(p);
        return;
    }
    if (p->plan.adaptive && p->syntax->dialect != DIALECT_OCTAVE) {
        program_adaptive_functions(p);
        return;
    }
    program_functions(p, splits ? PART_FORCE : PART_ALL);
    if (splits && p->written.system.velocity && p->drag == DRAG_EXACT) {
        struct buffer flow = {0}, *out = p->out; /* what it reads is a constant above it */
        p->out = &flow;
        program_coefficient(p, fabs(p->written.system.oscillator.damping), "gamma", NULL);
        p->out = out;
        buffer_free(&flow);
    }
    if (splits && p->written.system.velocity && p->drag == DRAG_EXPLICIT)
        program_functions(p, PART_DRAG);
}

/* Python's functions give no infinity and no NaN: they raise. */
static bool calls_partial(const char *functions)
{
    static const char *const partial[] = {"exp(",  "cosh(", "sinh(", "log(",  "log10(",
                                          "sqrt(", "acos(", "asin(", "power("};
    for (size_t i = 0; i < COUNT_OF(partial); i++)
        if (strstr(functions, partial[i]))
            return true;
    return false;
}

bool program_computes(struct scene_program *p)
{
    struct buffer functions = {0}, *out = p->out;
    const enum dialect dialect = p->syntax->dialect;
    p->out = &functions;
    put_functions(p);
    p->out = out;
    p->raises =
        dialect == DIALECT_PYTHON && !p->plan.adaptive && calls_partial(buffer_view(&functions));
    program_front(p);
    if (dialect == DIALECT_C)
        buffer_put(out, TEXT("#include <math.h>\n#include <stdio.h>\n"));
    const size_t declared = out->len;
    buffer_char(out, '\n');
    program_constants(p);
    buffer_put(out, dialect == DIALECT_PYTHON ? TEXT("\n\n") : TEXT("\n"));
    buffer_put(out, buffer_text(&functions));
    if (dialect == DIALECT_OCTAVE)
        buffer_char(out, '\n');
    out->failed |= functions.failed;
    buffer_free(&functions);
    dialect == DIALECT_C        ? put_main_c(p)
    : dialect == DIALECT_PYTHON ? put_main_python(p)
                                : put_main_octave(p);
    program_helpers(p, declared);
    return true;
}
