/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module programs: writes the session's scene with its method as a program that students can
 * read: the force, the step, the loop. In C fixed steps have hooke's order of operations. Scenes
 * that need more than steps (division at switches, events) are refused. */
#include "modules/programs/program.h"

#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/module.h>
#include <hooke/session/events.h>
#include <math.h>
#include <string.h>

/* ---- names ---- */

/* Appends the name, with underscores if the program uses it itself, so that no other name of the
 * scene is the same. */
static void put_free_name(struct scene_program *p, const char *own, struct buffer *name)
{
    const struct written *w = &p->written;
    buffer_put(name, text_of(own));
    for (bool taken = program_takes(p->dialect, own); taken && !name->failed;) {
        buffer_char(name, '_');
        taken = false;
        for (int i = 0; i < w->names; i++)
            taken = taken || text_is(buffer_text(name), w->name[i]);
    }
}

/* Appends the arguments of a function of the state, "(t, y, v)". */
static void put_arguments(const struct scene_program *p, struct buffer *output)
{
    for (int i = 0; i <= program_n(p); i++)
        buffer_format(output, "%s%s", i ? ", " : "(", p->name[i]);
    buffer_char(output, ')');
}

/* Chooses p->name, all names in the language. An observed quantity is a function in Octave, so that
 * its name is a call. Returns false with an error if out of memory. */
static bool make_names(struct scene_program *p)
{
    struct written *w = &p->written;
    const bool computes = p->dialect < DIALECT_XPP;
    p->rates = p->observed = "";
    p->name = arena_array(p->arena, (size_t)w->names, sizeof *p->name);
    for (int i = 0; p->name && i < w->names; i++) {
        struct buffer name = {0};
        if (computes && i > 0)
            put_free_name(p, w->name[i], &name);
        else
            buffer_put(&name, text_of(w->name[i]));
        if (p->dialect == DIALECT_OCTAVE && i >= w->observed)
            put_arguments(p, &name);
        p->name[i] = name.failed ? NULL : arena_text(p->arena, buffer_text(&name));
        buffer_free(&name);
        if (!p->name[i])
            return error_memory(p->error);
    }
    return p->name || error_memory(p->error);
}

/* ---- formulas ---- */

void program_expr(struct scene_program *p, const struct expr *expr)
{
    if (!expr_text(expr, p->dialect, (const char *const *)p->name, p->written.zero, p->output))
        p->output->failed = true;
}

/* Appends the right-hand side of a row of the equations of motion. Drag that a splitting solves
 * exactly is left out, and dry friction is added by the function with_friction(). */
static void put_row(struct scene_program *p, int row)
{
    const struct written *w = &p->written;
    const bool splits = p->method->splitting && w->system.velocity;
    const struct expr *expr;
    if (!splits)
        expr = w->all[row];
    else
        expr = p->drag == DRAG_EXACT ? w->force[row] : w->split[row];
    buffer_put(p->output, w->dry ? TEXT("with_friction(") : TEXT(""));
    if (expr)
        program_expr(p, expr);
    else
        buffer_char(p->output, '0');
    if (!w->dry)
        return;
    buffer_put(p->output, TEXT(", "));
    program_expr(p, w->dry);
    buffer_format(p->output, ", %s)", program_state(p, program_n(p) / 2));
}

/* Appends the derivatives of all variables in the form of the language: assignments to rate[i] in
 * C, the list that the function returns in Python, a function that returns a vector in Octave. The
 * derivatives of positions are the velocities. */
static void put_rates(struct scene_program *p)
{
    const int n = program_n(p), positions = n - p->written.rows;
    const bool c = p->dialect == DIALECT_C, octave = p->dialect == DIALECT_OCTAVE, lines = n > 2;
    const char *const python_between = lines ? ",\n        " : ", ";
    if (octave) {
        buffer_put(p->output, TEXT("equations = @"));
        put_arguments(p, p->output);
        buffer_put(p->output, TEXT(" [ ...\n    "));
    } else if (!c) {
        buffer_put(p->output, lines ? TEXT("    return [\n        ") : TEXT("    return ["));
    }
    for (int i = 0; i < n && !cancelled(p->written.cancel); i++) {
        const char *separator;
        if (!i)
            separator = "";
        else if (c)
            separator = ";\n";
        else
            separator = octave ? "; ...\n    " : python_between;
        buffer_put(p->output, text_of(separator));
        if (c)
            buffer_format(p->output, "    rate[%d] = ", i);
        if (i < positions)
            buffer_put(p->output, text_of(program_state(p, i + positions)));
        else
            put_row(p, i - positions);
    }
    const char *closing;
    if (c)
        closing = ";";
    else if (octave)
        closing = "];\n";
    else
        closing = lines ? ",\n    ]" : "]";
    buffer_put(p->output, text_of(closing));
    for (int i = 0; octave && i < n; i++)
        buffer_format(p->output, "%s, state(%d)", i ? "" : "derivatives = @(t, state) equations(t",
                      i + 1);
    buffer_put(p->output, octave ? TEXT(");") : TEXT(""));
}

/* Appends the definition, in the language of the program, of the observed quantity whose name has
 * the index i, followed by p->observed, the definitions of later quantities, which may read it. */
static void put_observed(struct scene_program *p, int i)
{
    const char *const name = p->name[i];
    if (p->dialect == DIALECT_OCTAVE)
        buffer_format(p->output, "%.*s = @%s ", (int)strcspn(name, "("), name, strchr(name, '('));
    else
        buffer_format(p->output, "    %s%s = ", p->dialect == DIALECT_C ? "const double " : "",
                      name);
    program_expr(p, p->written.observe[i - p->written.observed]);
    buffer_put(p->output, p->dialect == DIALECT_PYTHON ? TEXT("") : TEXT(";"));
    buffer_format(p->output, "%s%s", p->observed[0] ? "\n" : "", p->observed);
}

/* Moves the text of p->output to the arena and returns it, or "" if out of memory. */
const char *program_take_text(struct scene_program *p)
{
    const char *text = p->output->failed ? NULL : arena_text(p->arena, buffer_text(p->output));
    buffer_clear(p->output);
    p->output->failed = !text;
    return text ? text : "";
}

/* Makes the texts p->rates and p->observed. Returns false if out of memory. */
static bool make_formulas(struct scene_program *p)
{
    const struct written *w = &p->written;
    put_rates(p);
    p->rates = program_take_text(p);
    for (int i = w->names; i-- > w->observed && !p->output->failed && !cancelled(w->cancel);)
        if (program_reads(p, i)) {
            put_observed(p, i);
            p->observed = program_take_text(p);
        }
    return !p->output->failed;
}

/* Appends a label, a value and its unit. */
static void put_name_and_unit(struct buffer *output, const char *label, double value,
                              const char *unit)
{
    buffer_put(output, text_of(label));
    buffer_real(output, value);
    buffer_format(output, "%s%s", unit[0] ? " " : "", unit);
}

/* Appends lines that describe what the program computes (scene, equations, method, times), each
 * begun by `prefix`, which makes it a comment. */
void program_title(struct scene_program *p, const char *prefix)
{
    const struct written *w = &p->written;
    const struct row *row = &p->scene->preset->row;
    const double t0 = w->system.t0;
    buffer_format(p->output, "%s%s: %s\n", prefix, row->name, row->brief);
    for (int i = 0; i < w->rows; i++) {
        buffer_format(p->output, "%s   %s%s = ", prefix, w->name[1 + i],
                      program_moves(p) ? "''" : "'");
        if (!w->all[i])
            buffer_char(p->output, '0');
        else if (!expr_text(w->all[i], DIALECT_XPP, w->name, w->zero, p->output))
            p->output->failed = true;
        buffer_put(p->output, w->dry ? TEXT(", and dry friction\n") : TEXT("\n"));
    }
    buffer_format(p->output, "%sby %s: %s\n%s", prefix, p->method->row.name, p->method->row.brief,
                  prefix);
    if (p->plan.adaptive)
        put_name_and_unit(p->output, "tol = ", p->settings.tol, "");
    else
        put_name_and_unit(p->output, "dt = ", p->settings.dt, "s");
    put_name_and_unit(p->output, ", from t = ", t0, "s");
    put_name_and_unit(p->output, " to ", t0 + p->duration, "s");
    buffer_format(p->output, "; written by hooke %s", HOOKE_VERSION);
}

/* ---- what is refused ---- */

/* Returns true unless the session has events that stop runs or execute commands; otherwise sets an
 * error. */
static bool refuse_events(struct scene_program *p)
{
    const struct events *events = p->session->setup.events;
    for (int i = 0; events && i < events->count; i++)
        if (events->line[i].action != EVENT_RECORD)
            return error_set(p->error, ERROR_COMMAND, "event %s %s, which programs cannot do",
                             events->line[i].name,
                             events->line[i].action == EVENT_STOP ? "stops runs"
                                                                  : "executes commands");
    return true;
}

/* Returns true if adaptive steps of the method can be written in the language (all methods but in
 * C, where only those with a table and error control can); otherwise sets an error. */
static bool refuse_adaptive(struct scene_program *p)
{
    struct runge_kutta table;
    double most;
    int order;
    if (p->dialect != DIALECT_C ||
        (method_runge_kutta(p->method, &table) &&
         method_error_control(p->method, p->settings.tol, &most, &order)))
        return true;
    error_set(p->error, ERROR_COMMAND, "adaptive steps of %s cannot be written in C",
              p->method->row.name);
    return error_hint(p->error,
                      "possible are dopri5, tsit5 and bogacki-shampine, and all methods in Python");
}

/* Returns true if the method and its drag variant can be written as a program; otherwise sets an
 * error. */
static bool refuse_method(struct scene_program *p)
{
    struct runge_kutta table;
    double weight[SPLITTING_WEIGHTS];
    bool kick;
    const char *name = p->method->row.name;
    if (p->plan.adaptive)
        return refuse_adaptive(p);
    if (!method_runge_kutta(p->method, &table) && !method_splitting(p->method, weight, &kick) &&
        !method_is_backward_euler(p->method)) {
        error_set(p->error, ERROR_COMMAND, "%s cannot be written as a program", name);
        return error_hint(p->error, "possible are explicit Runge-Kutta methods, splittings and "
                                    "backward-euler ('list methods')");
    }
    if (p->method->splitting && p->written.system.velocity &&
        (p->drag == DRAG_IMPLICIT || (p->drag == DRAG_EXACT && p->method->order != 2))) {
        error_set(p->error, ERROR_COMMAND, "%s with this drag cannot be written as a program",
                  name);
        return error_hint(p->error,
                          "possible are verlet with drag=exact, and any method with drag=explicit");
    }
    if (p->settings.compensated)
        return error_set(p->error, ERROR_COMMAND,
                         "compensated sums cannot be written ('set sums plain' avoids them)");
    return true;
}

/* Returns true if steps need not be divided where forces jump or bend, or only where the velocity
 * turns, which programs can do; otherwise sets an error. Sets p->turns. */
static bool refuse_pieces(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    struct runge_kutta table;
    const bool pieces = p->plan.adaptive ? system->switches > 0 : system->pieces;
    p->turns = !p->plan.adaptive && method_turns(p->method, system);
    if (!pieces &&
        (!p->turns || (method_runge_kutta(p->method, &table) && p->dialect != DIALECT_OCTAVE)))
        return true;
    if (system->dry)
        error_set(
            p->error, ERROR_COMMAND,
            "the scene cannot be written as a program: its steps must end where the body turns, "
            "sticks and breaks away");
    else if (pieces)
        error_set(
            p->error, ERROR_COMMAND,
            "the scene cannot be written as a program: its steps must end where forces jump or "
            "bend");
    else
        error_set(
            p->error, ERROR_COMMAND,
            "the scene cannot be written as a program: steps of %s must end where the velocity "
            "changes its sign, because the force bends there",
            p->method->row.name);
    if (p->plan.adaptive && pieces && !system->dry)
        return error_hint(p->error,
                          "fixed steps ('set turning off', then 'method %s dt=10ms') step across "
                          "these points and can be written",
                          p->method->row.name);
    return error_hint(p->error,
                      "after 'set turning off' steps cross these points and can be written");
}

/* ---- all ---- */

/* Takes method, settings and duration of the session and plans the run in p->plan. Returns false
 * with an error if it cannot be run, or if a program could not count its steps. */
static bool make_plan(struct scene_program *p)
{
    const struct setup *setup = &p->session->setup;
    p->method = setup->method;
    p->settings = session_run_settings(p->session);
    p->duration = setup->settings.duration;
    p->drag = setup->drag;
    if (!plan_make(&p->written.system, p->method, &p->settings, p->duration, &p->plan, p->error) ||
        !method_applies(p->method, &p->written.system, &p->drag, p->error))
        return false;
    if (isfinite(p->duration) && (p->plan.adaptive || p->plan.whole < INT32_MAX))
        return true;
    error_set(p->error, ERROR_COMMAND, "%.4g steps are more than the program could count",
              p->duration / p->settings.dt);
    return error_hint(p->error, "set a shorter duration, or a longer dt");
}

/* Appends the session's scene in the dialect `kind`. Returns false with an error; output->failed
 * means that it is out of memory. */
static bool write_program(const struct session *session, size_t kind, struct arena *arena,
                          struct buffer *output, struct error *error)
{
    struct buffer text = {0};
    struct scene_program p = {.session = session,
                              .scene = &session->setup.scene,
                              .dialect = (enum dialect)kind,
                              .output = &text,
                              .arena = arena,
                              .error = error};
    const bool computes = p.dialect < DIALECT_XPP;
    bool fine = written_make(&p.written, p.scene, !computes, error);
    p.written.cancel = session->front.cancel;
    fine = fine && !cancelled(p.written.cancel) && make_plan(&p) &&
           (!computes || (refuse_pieces(&p) && refuse_method(&p) && refuse_events(&p))) &&
           make_names(&p);
    if (fine) {
        if (p.dialect == DIALECT_TEX)
            fine = program_tex(&p);
        else
            fine =
                p.dialect == DIALECT_XPP ? program_xpp(&p) : make_formulas(&p) && program_write(&p);
    }
    written_free(&p.written);
    buffer_put(output, buffer_text(&text));
    output->failed |= text.failed;
    buffer_free(&text);
    if (cancelled(session->front.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped; nothing was written");
    return (fine || output->failed) && (!output->failed || error_memory(error));
}

const struct module programs_module = {
    .row = {"programs", "", "scenes written as C, Python, Octave, LaTeX or XPPAUT", "", NULL},
    .needs = "documents",
    .writer =
        {
            .endings = ".c .py .m .tex .ode",
            .kinds = &dialect_catalog,
            .write = write_program,
        },
};
