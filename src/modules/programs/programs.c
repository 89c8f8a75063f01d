/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The present scene with its method as a program of its own. In C it has hooke's bits: forces,
 * steps and times are computed in the same order. What hooke does beyond a step (pieces at
 * switches, events) is not written, and such a scene is refused.
 */
#include "modules/programs/program.h"

#include <hooke/module.h>
#include <hooke/session/events.h>
#include <math.h>
#include <string.h>

/* ---- words ---- */

/* One that the program does not use itself, and no other of the scene has. */
static void put_free_name(struct scene_program *p, const char *own, struct buffer *name)
{
    const struct written *w = &p->written;
    buffer_put(name, text_of(own));
    for (bool taken = program_takes(p->syntax->dialect, own); taken && !name->failed;) {
        buffer_char(name, '_');
        taken = false;
        for (int i = 0; i < w->names; i++)
            taken = taken || text_is(buffer_text(name), w->name[i]);
    }
}

static bool make_names(struct scene_program *p)
{
    struct written *w = &p->written;
    const size_t count = (size_t)(w->names + p->slopes.parts);
    p->name = arena_array(p->arena, count, sizeof *p->name);
    p->reads = arena_array(p->arena, count, sizeof *p->reads);
    for (size_t i = 0; p->name && p->reads && i < count; i++) {
        struct buffer name = {0};
        if (i >= (size_t)w->names)
            buffer_format(&name, "part%zu", i - (size_t)w->names + 1);
        else
            put_free_name(p, w->name[i], &name);
        p->name[i] = name.failed ? NULL : arena_text(p->arena, buffer_text(&name));
        buffer_free(&name);
        if (!p->name[i])
            return error_memory(p->error);
    }
    return (p->name && p->reads) || error_memory(p->error);
}

/* ---- numbers and expressions ---- */

/* The fraction with the smallest denominator that is this double; false: none below a million. */
static bool fraction_of(double x, long *top, long *bottom)
{
    long p0 = 0, q0 = 1, p1 = 1, q1 = 0;
    double rest = fabs(x);
    for (int i = 0; i < 20; i++) {
        const double whole = floor(rest);
        const long p2 = (long)whole * p1 + p0, q2 = (long)whole * q1 + q0;
        if (whole > 1e6 || p2 > 1000000 || q2 > 1000000)
            return false;
        if ((double)p2 / (double)q2 == fabs(x)) {
            *top = x < 0 ? -p2 : p2;
            *bottom = q2;
            return true;
        }
        p0 = p1, q0 = q1, p1 = p2, q1 = q2;
        rest = 1 / (rest - whole);
    }
    return false;
}

void program_weight(const struct scene_program *p, double weight)
{
    char z[REAL_TEXT_SIZE];
    long top, bottom;
    if (real_format(weight, z) <= 4 || !fraction_of(weight, &top, &bottom))
        buffer_put(p->out, text_of(z));
    else
        buffer_format(p->out, "(%ld%s/%ld)", top, p->syntax->dialect == DIALECT_C ? ".0" : "",
                      bottom);
}

void program_expr(struct scene_program *p, const struct expr *expr)
{
    struct written *w = &p->written;
    if (!expr_reads(expr, w->zero, p->reads) ||
        !expr_text(expr, p->syntax->dialect, (const char *const *)p->name, w->zero, p->out))
        p->out->failed = true;
}

void program_comment(const struct scene_program *p, const char *indent, const char *text)
{
    buffer_format(p->out, "%s%s%s%s\n", indent, p->syntax->comment, text, p->syntax->comment_end);
}

/* ---- what is refused ---- */

static bool refuse_events(struct scene_program *p)
{
    const struct events *events = p->session->setup.events;
    for (int i = 0; events && i < events->count; i++)
        if (events->line[i].action != EVENT_RECORD)
            return error_set(p->error, ERROR_COMMAND, "event %s %s, which the program would not do",
                             events->line[i].name,
                             events->line[i].action == EVENT_STOP ? "stops runs"
                                                                  : "executes commands");
    return true;
}

static bool refuse_method(struct scene_program *p)
{
    struct runge_kutta table;
    double weight[SPLITTING_WEIGHTS];
    bool kick;
    const char *name = p->method->row.name;
    if (!method_runge_kutta(p->method, &table) && !method_splitting(p->method, weight, &kick) &&
        !method_is_backward_euler(p->method)) {
        error_set(p->error, ERROR_COMMAND, "%s is not written as a program", name);
        return error_hint(p->error, "what is: explicit Runge-Kutta methods, splittings and "
                                    "backward-euler ('list methods')");
    }
    const struct system *system = &p->written.system;
    if (p->syntax->dialect == DIALECT_OCTAVE && method_is_backward_euler(p->method) &&
        !(system->n == 2 && system->oscillator.whole))
        return error_set(p->error, ERROR_COMMAND,
                         "%s of these equations is written in C and Python only", name);
    if (p->plan.adaptive && !program_refuse_adaptive(p))
        return false;
    if (p->method->splitting && p->written.system.velocity &&
        (p->drag == DRAG_IMPLICIT || (p->drag == DRAG_EXACT && p->method->order != 2))) {
        error_set(p->error, ERROR_COMMAND, "%s with this drag is not written as a program", name);
        return error_hint(p->error, "verlet with drag=exact is, and any with drag=explicit");
    }
    return true;
}

static bool refuse_pieces(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    if (p->settings.compensated && !p->plan.adaptive)
        return error_set(p->error, ERROR_COMMAND,
                         "compensated sums are not written ('set sums "
                         "plain')");
    struct runge_kutta table;
    p->turns = method_turns(p->method, system) && method_runge_kutta(p->method, &table) &&
               (p->plan.adaptive || system->autonomous || !table.fsal) &&
               p->syntax->dialect != DIALECT_OCTAVE;
    const bool pieces = p->plan.adaptive ? system->switches > 0 : system->pieces;
    if (!pieces && (p->turns || !method_turns(p->method, system)))
        return true;
    error_set(p->error, ERROR_COMMAND,
              system->dry ? "steps end where the body turns, sticks and breaks away, which is not "
                            "written as a program"
              : pieces
                  ? "steps end where the forces jump or bend, which is not written as a program"
                  : "steps of %s end where the velocity turns, because the force bends there, "
                    "which is not written as a program",
              p->method->row.name);
    if (p->plan.adaptive && pieces && !system->dry)
        return error_hint(p->error,
                          "steps of one size, 'method %s dt=10ms' after 'set turning off', step "
                          "across, and that is",
                          p->method->row.name);
    return error_hint(p->error, "'set turning off' steps across, and that is");
}

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
    p->partial = !p->plan.adaptive && p->plan.partial != 0;
    p->step = p->partial ? "h" : "dt";
    if (isfinite(p->duration) && (p->plan.adaptive || p->plan.whole < INT32_MAX))
        return true;
    error_set(p->error, ERROR_COMMAND, "%.4g steps are more than the program would count",
              p->duration / p->settings.dt);
    return error_hint(p->error, "set a shorter duration, or a longer dt");
}

static bool write_computing(struct scene_program *p)
{
    if (!refuse_pieces(p) || !refuse_method(p) || !refuse_events(p))
        return false;
    if (method_is_backward_euler(p->method) && !written_slopes(&p->written, &p->slopes, p->error))
        return false;
    return make_names(p) && program_computes(p);
}

static bool write(const struct session *session, size_t kind, struct arena *arena,
                  struct buffer *out, struct error *error)
{
    const enum dialect dialect = (enum dialect)kind;
    struct scene_program p = {.session = session,
                              .scene = &session->setup.scene,
                              .out = out,
                              .arena = arena,
                              .error = error};
    const bool as_typed = dialect == DIALECT_TEX || dialect == DIALECT_XPP;
    p.syntax = program_syntax(dialect);
    bool fine = written_make(&p.written, p.scene, as_typed, error);
    p.written.cancel = session->front.cancel;
    fine = fine && !cancelled(p.written.cancel) && make_plan(&p);
    if (fine)
        fine = dialect == DIALECT_TEX   ? make_names(&p) && program_tex(&p)
               : dialect == DIALECT_XPP ? make_names(&p) && program_xpp(&p)
                                        : write_computing(&p);
    written_free(&p.written);
    if (cancelled(session->front.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped: nothing was written");
    return fine && (!out->failed || error_memory(error));
}

const struct module programs_module = {
    .row = {"programs", "", "scenes written as C, Python, Octave, LaTeX or XPPAUT", "", NULL},
    .needs = "",
    .writer =
        {
            .endings = ".c .py .m .tex .ode",
            .kinds = &dialect_catalog,
            .write = write,
        },
};
