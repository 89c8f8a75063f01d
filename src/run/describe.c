/* SPDX-License-Identifier: GPL-3.0-or-later */
/* plan_describe(): the text of the command `plan`, which says what a run will compute and what is
 * left out, like the EXPLAIN of a database. Each function appends one or more lines, a heading of
 * ten columns first. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/run/price.h>

#include "run/private.h"

#include <math.h>

/* Appends the heading of a line, padded to ten columns. */
static void description_key_put(struct buffer *text, const char *name)
{
    buffer_format(text, "%-10s", name);
}

static const char *step_word(double count)
{
    return count == 1 ? "step" : "steps";
}

/* Appends the parameters of the oscillator that was recognised in the equations that the user typed
 * (omega0 or k/m, gamma, drag, constant force, drive); appends nothing for other scenes. */
static void describe_recognised(const struct system *system, struct buffer *text)
{
    const struct oscillator *o = &system->oscillator;
    if (!system->model->typed || !o->whole)
        return;
    description_key_put(text, "which is");
    buffer_format(text, "an oscillator: ");
    if (o->stiffness > 0) {
        buffer_format(text, "omega0 = ");
        buffer_quantity(text, sqrt(o->stiffness), QUANTITY_ANGULAR_FREQUENCY, 6);
    } else {
        buffer_format(text, "k/m = ");
        buffer_short(text, o->stiffness, 6);
        buffer_format(text, " 1/s^2");
    }
    buffer_format(text, ", gamma = ");
    buffer_quantity(text, o->damping, QUANTITY_RATE, 6);
    const struct {
        const char *prefix;
        double value;
        const char *suffix;
    } more[] = {{", drag ", o->quadratic, " |v| v"},
                {", constant ", -o->gravity, ""},
                {", drive ", o->drive, ""}};
    for (size_t i = 0; i < COUNT_OF(more); i++)
        if (more[i].value != 0) {
            buffer_put(text, text_of(more[i].prefix));
            buffer_short(text, more[i].value, 6);
            buffer_put(text, text_of(more[i].suffix));
        }
    if (o->drive != 0) {
        buffer_put(text, TEXT(" cos(omega t + phase) with omega = "));
        buffer_quantity(text, o->omega, QUANTITY_ANGULAR_FREQUENCY, 6);
    }
    buffer_char(text, '\n');
}

/* Describes the state variables, the kind of the equations, and the forces with their formulas. */
static void describe_scene(const struct scene *scene, const struct system *system,
                           struct buffer *text)
{
    description_key_put(text, "scene");
    buffer_format(text, "%s: state", scene->preset ? scene->preset->row.name : "typed");
    for (int i = 0; i < system->n; i++)
        buffer_format(text, "%s %s", i ? "," : "", system_variable(system, i).name);
    const char *const driven = system->autonomous ? "autonomous" : "driven by time";
    buffer_format(text, "; %s, %s", system->linear ? "linear" : "not linear", driven);
    buffer_format(text, system->conservative ? ", conservative\n" : "\n");
    for (int i = 0; i < system->terms; i++) {
        const struct row *row = &system->term[i].row->row;
        description_key_put(text, i ? "" : "terms");
        buffer_format(text, "%s: %s\n", row->name, row->brief);
    }
    describe_recognised(system, text);
}

/* Appends the predicted number of force evaluations, which may need a trial of the first steps. */
static void describe_evaluations(const struct scene *scene, const struct system *system,
                                 const struct method *method, const struct run_settings *settings,
                                 const struct plan *plan, struct buffer *text)
{
    const struct run_scenario scenario = {.scene = scene,
                                          .system = system,
                                          .method = method,
                                          .settings = settings,
                                          .plan = plan,
                                          .span = HUGE_VAL};
    struct run_work work;
    run_work_count(&scenario, &work);
    buffer_format(text, "about %.6g", round(work.force_evals));
    if (work.tried > 0 && (double)work.tried < plan->steps)
        buffer_format(text, " (estimated from the first %lld steps)", (long long)work.tried);
    else if (work.failed)
        buffer_format(text, " at least");
}

/* Describes the order, the evaluations and the properties of the method. */
static void describe_method(const struct method *method, bool compensated, struct buffer *text)
{
    static const struct {
        unsigned flag;
        const char *word;
    } property[] = {{METHOD_EXACT, "exact"},           {METHOD_IMPLICIT, "implicit"},
                    {METHOD_SYMPLECTIC, "symplectic"}, {METHOD_SYMMETRIC, "symmetric"},
                    {METHOD_ENERGY, "keeps energy"},   {METHOD_A_STABLE, "A-stable"},
                    {METHOD_L_STABLE, "L-stable"}};
    description_key_put(text, "method");
    buffer_format(text, "%s", method->row.name);
    if (method->order)
        buffer_format(text, ", order %d", method->order);
    buffer_format(text, ", %d evaluation%s per step", method->evals, method->evals == 1 ? "" : "s");
    for (size_t i = 0; i < COUNT_OF(property); i++) {
        if (method->flags & property[i].flag)
            buffer_format(text, ", %s", property[i].word);
    }
    buffer_format(text, compensated ? ", compensated sums\n" : "\n");
}

/* Describes how the method evaluates linear drag, and returns the drag variant that it uses for
 * `asked`; DRAG_DEFAULT stays if the method has no variants. Appends nothing if drag is evaluated
 * like any other force. */
static enum drag describe_drag(const struct system *system, const struct method *method,
                               enum drag asked, struct buffer *text)
{
    enum drag drag = asked;
    struct error ignored;
    if (!system->velocity) {
        description_key_put(text, "drag");
        buffer_format(text, system->dry ? "none but dry friction\n"
                                        : "none: no force depends on velocity\n");
    } else if (method_applies(method, system, &drag, &ignored) && drag != DRAG_DEFAULT) {
        description_key_put(text, "drag");
        buffer_format(text, "%s%s\n", catalog_row(&drag_catalog, (size_t)drag - 1)->name,
                      asked == DRAG_DEFAULT ? " (the method's default)" : "");
    } /* else it is a part of the force, as any other */
    return drag;
}

/* Returns a text about the behaviour of steps where forces jump or bend, or NULL if there is
 * nothing to report. */
static const char *about_turns(const struct system *system, const struct method *method,
                               bool adaptive)
{
    if (system->dry)
        return "steps end where the body turns, sticks and breaks away ('set turning off' steps "
               "across)";
    if (system->oscillator.friction != 0)
        return "turning points: crossed (turning off), the order is lost there: dry friction jumps";
    if (system->switches > 0 && (system->pieces || system->steps_across_kinks) && !adaptive) {
        if (method_meets_switches(method, system))
            return "steps end at switches (if, abs, sign, ...) ('set turning off' steps across)";
        return system->steps_across_kinks
                   ? "switches (if, abs, sign, ...): crossed (turning off), the order is lost there"
                   : "switches (if, abs, sign, ...): crossed by this method, the order is lost "
                     "there";
    }
    if (!system->kinks || method->order <= 2)
        return NULL;
    if (method_turns(method, system))
        return "turning points: located by extra steps ('set turning off' steps across)";
    return system->steps_across_kinks
               ? "turning points: crossed (turning off), the order is lost there"
               : "order is lost at turning points: quadratic drag is only C^1 there";
}

/* Describes adaptive steps: their tolerance, the first guess, and absolute tolerances that are
 * set. */
static void describe_tolerance(const struct system *system, const struct run_settings *settings,
                               struct buffer *text)
{
    buffer_format(text, "chosen by the error estimate, tol = ");
    buffer_short(text, settings->tol, 3);
    buffer_format(text, " relative to the natural size of each variable; first dt = ");
    buffer_quantity(text, settings->dt, QUANTITY_TIME, 6);
    for (int i = 0; i < system->n; i++)
        if (system->atol[i] > 0) {
            buffer_format(text, "\n%-10satol %s = ", "", system_variable(system, i).name);
            buffer_quantity(text, system->atol[i], system_variable(system, i).quantity, 6);
        }
    buffer_char(text, '\n');
}

/* Describes fixed steps: their number, and how the last of them meets the end. */
static void describe_grid(const struct method *method, const struct run_settings *settings,
                          const struct plan *plan, struct buffer *text)
{
    if (isnan(plan->steps))
        buffer_format(text, "no end is set, fixed dt = ");
    else
        buffer_format(text, "%lld %s of fixed dt = ", (long long)plan->whole,
                      step_word((double)plan->whole));
    buffer_quantity(text, settings->dt, QUANTITY_TIME, 6);
    if (plan->partial > 0) {
        buffer_format(text, "\n%-10sone last step of ", "");
        buffer_quantity(text, plan->partial, QUANTITY_TIME, 6);
        if (method->flags & METHOD_SYMPLECTIC)
            buffer_format(text, "; %s is symplectic only with constant steps", method->row.name);
    } else if (plan->exact_end) {
        buffer_format(text, ", the last of which ends exactly on time");
    }
    buffer_char(text, '\n');
}

/* Describes drag, turning points, steps, the kernel, and for fixed steps the evaluations and the
 * estimated time. */
static void describe_steps(const struct scene *scene, const struct system *system,
                           const struct method *method, const struct run_settings *settings,
                           const struct plan *plan, struct buffer *text)
{
    const enum drag drag = describe_drag(system, method, settings->drag, text);
    const char *turns = about_turns(system, method, plan->adaptive);
    if (turns)
        buffer_format(text, "%-10s%s\n", "", turns);
    description_key_put(text, "steps");
    if (plan->adaptive) {
        describe_tolerance(system, settings, text);
        return;
    }
    describe_grid(method, settings, plan, text);
    description_key_put(text, "kernel");
    if (plan->propagates)
        buffer_format(text, "propagator: powers of the one-step matrix, no forces are evaluated\n");
    else if (settings->kernel != KERNEL_GENERAL && !settings->compensated &&
             method_kernel(method, system, drag))
        buffer_format(text, "specialised for %s and these forces\n", method->row.name);
    else
        buffer_format(text, "general code, which calls each force at each stage\n");
    if (!isnan(plan->steps)) {
        description_key_put(text, "evals");
        describe_evaluations(scene, system, method, settings, plan, text);
        buffer_format(text, ", estimated time ");
        buffer_quantity(text, plan->seconds, QUANTITY_TIME, 1);
        buffer_char(text, '\n');
    }
}

/* Describes which columns are recorded, at which steps or times, and how much memory they take. */
static void describe_record(const struct system *system, const struct run_settings *settings,
                            const struct plan *plan, struct buffer *text)
{
    description_key_put(text, "record");
    for (int i = 0; i < system->n; i++)
        buffer_format(text, "%s%s", i ? ", " : "", system_variable(system, i).name);
    const bool timed = settings->record.rule == RECORD_TIMES;
    buffer_format(text, plan->adaptive || timed ? ", t" : "");
    if (settings->record.rule == RECORD_EVERY)
        buffer_format(text, " every %lld steps", (long long)settings->record.every);
    else if (timed)
        buffer_format(text, " every %.6g s and at the end, by dense output within steps",
                      settings->record.interval);
    else if (settings->record.rule == RECORD_AUTO && !(plan->steps < LIMIT_SAMPLES))
        buffer_format(text, ", every step up to %u rows, then decimated (peaks are kept)",
                      LIMIT_SAMPLES);
    else
        buffer_format(text, " every step");
    if (!isnan(plan->bytes))
        buffer_format(text, ": %.4g kB", plan->bytes / 1e3);
    buffer_format(text, plan->adaptive || timed ? "\n" : "; times are computed, not stored\n");
}

/* Describes the growth of the amplitude per step and the largest stable step, if they are known:
 * for the linear oscillator only. */
static void describe_prediction(const struct system *system, const struct method *method,
                                const struct run_settings *settings, const struct plan *plan,
                                struct buffer *text)
{
    if (isnan(plan->growth))
        return;
    double limit = plan_stable_limit(system, method, settings->drag);
    description_key_put(text, "predicted");
    buffer_format(text, "amplitude times ");
    buffer_short(text, plan->growth, 10);
    buffer_format(text, " per step");
    if (limit == 0) {
        buffer_format(text, "; %s is unstable here for every dt", method->row.name);
    } else if (isinf(limit)) {
        buffer_format(text, "; stable for every dt");
    } else if (!isnan(limit)) {
        buffer_format(text, "; stable up to dt = ");
        buffer_quantity(text, limit, QUANTITY_TIME, 4);
        buffer_format(text, settings->dt > limit ? " (exceeded)" : "");
    }
    buffer_char(text, '\n');
}

/* Appends the whole text of `plan`. */
void plan_describe(const struct scene *scene, const struct system *system,
                   const struct method *method, const struct run_settings *settings,
                   const struct plan *plan, struct buffer *text)
{
    describe_scene(scene, system, text);
    describe_method(method, settings->compensated && !plan->adaptive, text);
    describe_steps(scene, system, method, settings, plan, text);
    describe_record(system, settings, plan, text);
    describe_prediction(system, method, settings, plan, text);
    description_key_put(text, "exact");
    if (!plan->exact_known)
        buffer_put(text, TEXT("no closed form: no error column\n"));
    else if (system->oscillator.whole || system->model->exact)
        buffer_put(text, TEXT("closed form known: no reference integration\n"));
    else
        buffer_put(text, TEXT("known by the matrix exponential: no reference integration\n"));
    if (system->order == 2 && !system->energy) {
        description_key_put(text, "energy");
        buffer_format(text,
                      "unknown: the typed forces have no potential; only kinetic is available\n");
    }
}
