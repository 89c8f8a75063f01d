/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs: creation and destruction, going back to a recorded row, and changing the scene or the state
 * on the way. advance.c makes the steps. */
#include "run/event/watch.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define LOOK_FIRST 4096 /* step at which run_creeps() examines an adaptive run first */

/* Position [m] above which a run has diverged; the square, in its energy, is still finite. */
#define AMPLITUDE_MAX 1e150

/* Returns the word for a stop in JSON. */
const char *stop_name(enum stop stop)
{
    static const char *const name[] = {
        [STOP_NONE] = "ok",
        [STOP_END] = "ok",
        [STOP_CONDITION] = "ok",
        [STOP_DIVERGED] = "diverged",
        [STOP_CANCELLED] = "cancelled",
        [STOP_NO_SOLUTION] = "no-solution",
        [STOP_STALLED] = "stalled",
        [STOP_FULL] = "full",
        [STOP_SINGULAR] = "singular",
        [STOP_GIVEN_UP] = "given-up",
    };
    return name[stop];
}

/* Velocities have a bound in proportion to the scene's natural velocity at the same amplitude. */
double run_bound(const struct system *system, int i)
{
    const int half = system->n / 2;
    const bool velocity = system->order == 2 && i >= half;
    const double bound =
        AMPLITUDE_MAX * (velocity ? system->scale[i] / system->scale[i - half] : 1);
    return bound < AMPLITUDE_MAX ? AMPLITUDE_MAX : fmin(bound, DBL_MAX);
}

/* Sets the magnitudes above which the run has diverged, from the system in force. */
static void set_bounds(struct run *run)
{
    for (int i = 0; i < run->system.n; i++)
        run->private_state->bound[i] = run_bound(&run->system, i);
}

/* Returns the power of two by which states are multiplied before their energies are computed, so
 * that squares of 1e-200 or 1e200 stay in range. It is 1 unless energy is quadratic in the state,
 * where it changes no ratio of energies: forces must be linear and homogeneous, and a typed
 * potential, which may have a constant in it, is excluded. */
static double energy_factor(const struct system *system)
{
    const struct oscillator *o = &system->oscillator;
    int exponent;
    frexp(system->scale[0], &exponent);
    if (!system->linear || !o->whole || system->model->typed || o->gravity != 0 || o->drive != 0 ||
        abs(exponent) < 300)
        return 1;
    return ldexp(1, exponent < -1000 ? 1000 : -exponent);
}

struct epoch *run_push_epoch(struct run *run)
{
    struct run_private *p = run->private_state;
    const bool fits = array_reserve(&p->epoch, sizeof *p->epoch, p->epochs, &p->epoch_capacity);
    return fits ? &p->epoch[p->epochs++] : NULL;
}

/* Begins an epoch at the present step, with that system; `start` [n] is the state at which its
 * exact solution begins. Returns false if out of memory. */
static bool epoch_begin(struct run *run, const struct scene *scene, const struct system *system,
                        const double *start)
{
    struct epoch *epoch = run_push_epoch(run);
    if (!epoch)
        return false;
    epoch->first = run->steps;
    epoch->t = run->t;
    system_copy(&epoch->system, system);
    epoch->plan = run->plan;
    epoch->drag = run->settings.drag;
    copy_state(epoch->start, start, system->n);
    memcpy(epoch->value, scene->value, sizeof epoch->value);
    return true;
}

const struct system *run_system_to(const struct run *run, size_t row)
{
    return &run_epoch(run, trace_step(run->trace, row))->system;
}

/* Finds the last epoch that begins before the step, by bisection. */
const struct epoch *run_epoch(const struct run *run, int64_t step)
{
    const struct run_private *p = run->private_state;
    size_t low = 0, high = p->epochs;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (p->epoch[middle].first < step)
            low = middle;
        else
            high = middle;
    }
    return &p->epoch[low];
}

/* Returns true if states inside of a step are found by shorter steps of the method (inside.c): a
 * cubic through the ends would be of a lower order than the method, or it would not hold because
 * the step is made in pieces that end at switches. */
static bool needs_side_steps(const struct run *run)
{
    static const int cubic_order = 4;
    const int order = run->method->order; /* order; 0 if the method is exact */
    if (run->plan.adaptive)
        return !run->method->dense;
    return run->system.pieces || (!run->method->dense && (order == 0 || order > cubic_order));
}

/* Allocates the private part of a new run, its trace and the memory of its method, and records the
 * first state. Returns false if out of memory; the caller then frees with run_destroy() what has
 * been allocated. */
static bool run_allocate(struct run *run)
{
    size_t n = (size_t)run->system.n, work = method_work_size(run->method, run->system.n);
    struct run_private *p = run->private_state = malloc(sizeof *p);
    if (p)
        *p = (struct run_private){.work = NULL};
    run->trace =
        trace_create(run->system.n, run->plan.adaptive, run->settings.record, run->settings.memory);
    if (!p || !run->trace)
        return false;
    const bool side = needs_side_steps(run);
    p->work = calloc((side ? 2 : 1) * work + 5 * n, sizeof *p->work);
    if (!p->work || !epoch_begin(run, &run->scene, &run->system, run->y) ||
        !trace_reserve_grids(run->trace, 1))
        return false;
    p->previous_state = p->work + work;
    p->bound = p->previous_state + n;
    p->low_before = p->bound + n;
    p->gap = p->low_before + 2 * n;
    p->side = side ? p->gap + n : NULL;
    p->batch = 16;
    p->look = LOOK_FIRST;
    p->factor = energy_factor(&run->system);
    p->step = (struct step){
        .system = &run->system, .drag = run->settings.drag, .y = run->y, .work = p->work};
    p->step.switches = run->plan.adaptive ? NULL : &run->controller.switches;
    if (run->settings.compensated && !run->plan.adaptive)
        p->step.low = p->low_before + n;
    if (!method_begin(run->method, &p->step))
        return false;
    const bool thinned =
        run->settings.record.rule == RECORD_TIMES ||
        (run->settings.record.rule == RECORD_EVERY && run->settings.record.every > 1);
    if (run->system.order == 2 && !ledger_waits(run) && thinned &&
        !trace_mark_rows(run->trace, run->plan.ledger))
        return false;
    return trace_record(run->trace, 0, run->t, run->y);
}

/* Chooses the kernel for fixed steps of the system in force, and drops the propagator, which is
 * made again when it is needed. */
static void choose_kernel(struct run *run)
{
    struct run_private *p = run->private_state;
    const bool general = run->settings.kernel == KERNEL_GENERAL;
    p->kernel = general ? NULL : method_kernel(run->method, &run->system, run->settings.drag);
    free(p->propagator);
    p->propagator = NULL;
}

/* Binds the scene, makes the plan, and allocates the run at its start. */
struct run *run_create(const struct scene *scene, const struct method *method,
                       const struct run_settings *settings, double span, struct error *error)
{
    struct run *run = malloc(sizeof *run);
    if (!run) {
        error_memory(error);
        return NULL;
    }
    /* Scene and system are set below; they are large, so they are not cleared first. */
    memset(run, 0, offsetof(struct run, scene));
    memset((char *)run + offsetof(struct run, method), 0,
           sizeof *run - offsetof(struct run, method));
    run->scene = *scene;
    run->method = method;
    run->settings = *settings;
    if (!scene_bind(scene, &run->system, error) ||
        !plan_make(&run->system, method, settings, span, &run->plan, error) ||
        !method_applies(method, &run->system, &run->settings.drag, error)) {
        run_destroy(run);
        return NULL;
    }
    run->t = run->system.t0;
    memcpy(run->y, run->system.start, (size_t)run->system.n * sizeof *run->y);
    if (!run_allocate(run)) {
        run_destroy(run);
        error_memory(error);
        return NULL;
    }
    double h = span < 0 ? -settings->dt : settings->dt;
    trace_regrid(run->trace, (struct time_grid){.first = 0, .origin = run->t, .h = h});
    trace_present(run->trace, 0, run->t, run->y);
    run->controller = (struct controller){.tol = settings->tol, .h = h};
    run->private_state->probed = run->t;
    set_bounds(run);
    choose_kernel(run);
    ledger_back(run);
    opinion_forget(run);
    return run;
}

/* Frees the run with everything that it owns. */
void run_destroy(struct run *run)
{
    if (!run)
        return;
    trace_destroy(run->trace);
    if (run->private_state) {
        opinion_forget(run);
        method_end(run->method, &run->private_state->step);
        free(run->private_state->work);
        free(run->private_state->scratch);
        free(run->private_state->work_before);
        free(run->private_state->propagator);
        free(run->private_state->epoch);
        events_watch_destroy(run->private_state->watch);
        free(run->private_state->event_records.record);
        free(run->private_state->event_records.state);
        free(run->private_state->kick);
        responses_free(&run->private_state->responses);
        free(run->private_state->saved);
        ledger_forget_thinning(run->private_state);
        free(run->private_state);
    }
    free(run);
}

/* Every change of the scene or of the state makes the method forget earlier steps. */
void run_use_epoch(struct run *run)
{
    struct run_private *p = run->private_state;
    const struct epoch *epoch = &p->epoch[p->epochs - 1];
    system_copy(&run->system, &epoch->system);
    run->plan = epoch->plan;
    run->plan.exact_known &= p->kicks == 0;
    run->plan.ledger |= p->kicks > 0;
    p->step.drag = run->settings.drag = epoch->drag;
    p->step.warm = false;
    forget_rounding(p, run->system.n);
    set_bounds(run);
    choose_kernel(run);
}

/* Returns the time since which dry friction has held the body; NAN if it does not. */
double run_rest(const struct run *run)
{
    const struct trace *trace = run->trace;
    double a[LIMIT_VARIABLES];
    if (!run->system.dry || run->y[1] != 0)
        return NAN;
    system_acceleration(&run->system, run->t, run->y, a);
    size_t row = trace_count(trace);
    while (a[0] == 0 && row > 0 && trace_state(trace, row - 1)[1] == 0)
        row--;
    if (a[0] != 0)
        return NAN;
    return row < trace_count(trace) ? trace_time(trace, row) : run->t;
}

/* Goes back by rows; everything after the row is dropped, and the method begins anew. */
bool run_back(struct run *run, int64_t rows)
{
    struct run_private *p = run->private_state;
    struct trace *trace = run->trace;
    size_t last = trace_count(trace) - 1;
    bool enough = rows <= 0 || (uint64_t)rows <= last;
    size_t row;
    if (rows <= 0)
        row = last;
    else
        row = enough ? last - (size_t)rows : 0;
    for (size_t i = p->kicks; i > 0 && row > 0 && rows > 0; i--)
        row -= p->kick[i - 1].step == trace_step(trace, row) + 1 &&
               p->kick[i - 1].t == trace_time(trace, row);
    if (row == last && rows <= 0)
        return true;
    /* The first step of an adaptive run from there has the size of the step that led there, because
     * the controller's memory is not recorded. */
    if (run->plan.adaptive)
        ledger_will_not_repeat(run);
    else
        ledger_demand(run);
    double h = row > 0 ? trace_time(trace, row) - trace_time(trace, row - 1) : run->settings.dt;
    trace_truncate(trace, row);
    events_forget_sizes(run);
    p->searched = row < p->searched ? row : p->searched;
    run->steps = trace->now_step;
    run->t = trace->now_t;
    memcpy(run->y, trace->now, (size_t)run->system.n * sizeof *run->y);
    if (trace->interval > 0) {
        /* The distance of rows at even times says nothing about the step, and no step of the grid
         * may end at such a row. */
        if (!run->plan.adaptive && !even_present(trace, grid_time(trace_grid(trace), run->steps)))
            trace_regrid(trace, (struct time_grid){run->steps, run->t, trace_grid(trace)->h});
        event_records_truncate(run, h);
        h = copysign(run->settings.dt, h);
    }
    run->controller = (struct controller){.tol = run->settings.tol, .h = h};
    run->stop = STOP_NONE;
    event_records_truncate(run, 0);
    while (p->kicks > 0 && p->kick[p->kicks - 1].step > run->steps)
        p->kicks--;
    responses_truncate(run);
    while (p->epochs > 1 && p->epoch[p->epochs - 1].first > run->steps)
        p->epochs--;
    run_use_epoch(run);
    ledger_back(run);
    opinion_forget(run);
    return enough;
}

/* Returns true if later steps or rows depend on more than the present state. */
bool run_remembers(const struct run *run)
{
    /* Methods that use earlier steps, compensated sums, a decimated trace, which stays coarse, and
     * blocks of the propagator whose beginning need not be a recorded row. */
    return run->method->flags & (METHOD_MULTISTEP | METHOD_EXTERNAL | METHOD_IMPLICIT) ||
           (run->settings.compensated && !run->plan.adaptive) || trace_decimated(run->trace) ||
           (run->plan.propagates && trace_count(run->trace) <= (size_t)run->steps);
}

/* Changes the scene at the present step: a new epoch, or the present one if it has no step yet. */
bool run_rebind(struct run *run, const struct scene *scene, struct error *error)
{
    struct run_private *p = run->private_state;
    struct system system;
    struct plan plan;
    enum drag drag = run->settings.drag;
    if (!scene_bind(scene, &system, error))
        return false;
    if (system.model != run->system.model)
        return error_set(error, ERROR_COMMAND, "a run of %s cannot continue as %s",
                         run->system.model->row.name, system.model->row.name);
    if (!method_applies(run->method, &system, &drag, error) ||
        !plan_make(&system, run->method, &run->settings, HUGE_VAL, &plan, error))
        return false;

    ledger_demand(run);
    if (trace_marked(run->trace) && !trace_mark_rows(run->trace, true))
        return error_memory(error);
    struct epoch *last = &p->epoch[p->epochs - 1];
    double start[LIMIT_VARIABLES];
    const bool exact = (run->plan.exact_known || run->steps == 0) && plan.exact_known &&
                       !responses_moment_moves(run);
    memcpy(start, last->start, sizeof start);
    if (last->first != run->steps) {
        if (p->epochs > LIMIT_CHANGES) {
            error_set(error, ERROR_COMMAND, "run %d has already been changed %d times", run->number,
                      LIMIT_CHANGES);
            return error_hint(error, "start a new one: run");
        }
        if (exact)
            system_exact(&last->system, last->t, last->start, run->t, start, NULL);
        if (!epoch_begin(run, scene, &system, start))
            return error_memory(error);
        last = &p->epoch[p->epochs - 1];
    }
    system_copy(&last->system, &system);
    memcpy(last->value, scene->value, sizeof last->value);
    last->drag = drag;
    last->plan.exact_known = exact;
    last->plan.ledger = true; /* changing a parameter does work */
    last->plan.propagates = plan.propagates;
    last->plan.growth = plan.growth;
    last->plan.limit = plan.limit;
    ledger_rescale(run, 1);
    if (run->steps == 0)
        ledger_back(run);
    run_use_epoch(run);
    return true;
}

/* Removes the epoch that run_rebind() has just begun. */
void run_unbind(struct run *run)
{
    struct run_private *p = run->private_state;
    struct error ignored;
    if (p->epoch[p->epochs - 1].first != run->steps)
        return;
    if (p->epochs == 1) {
        run_rebind(run, &run->scene, &ignored); /* this scene was accepted when the run began */
        return;
    }
    /* The energy balance has not entered the new epoch yet, so nothing else has to be undone. */
    p->epochs--;
    run_use_epoch(run);
}

/* Gives variable i a new value, in a step of no length. */
bool run_kick(struct run *run, int i, double value, struct error *error)
{
    struct run_private *p = run->private_state;
    const struct system *system = &run->system;
    const double previous_value = run->y[i],
                 previous_energy = system->order == 2 ? system_energy(system, run->y) : 0;
    if (run->method->flags & METHOD_EXTERNAL)
        return error_set(error, ERROR_COMMAND,
                         "%s has internal state, so the state of the run cannot be changed",
                         run->method->row.name);
    if (!(fabs(value) <= p->bound[i]))
        return error_set(error, ERROR_COMMAND, "%s cannot become %g",
                         system_variable(system, i).name, value);
    ledger_demand(run);
    if (!array_reserve(&p->kick, sizeof *p->kick, p->kicks, &p->kick_capacity) ||
        !trace_reserve_grids(run->trace, 1) || !ledger_ready(run) ||
        (trace_marked(run->trace) && !trace_mark_rows(run->trace, true)))
        return error_memory(error);
    run->y[i] = value;
    run->steps++;
    if (!responses_add_jump(run, i, previous_value) ||
        !trace_record(run->trace, run->steps, run->t, run->y)) {
        run->y[i] = previous_value;
        run->steps--;
        responses_truncate(run);
        return error_set(error, ERROR_COMMAND, "the trace has no room for more rows");
    }
    if (!run->plan.adaptive)
        trace_regrid(run->trace, (struct time_grid){run->steps, run->t, trace_grid(run->trace)->h});
    trace_present(run->trace, run->steps, run->t, run->y);
    p->kick[p->kicks++] =
        (struct kick){run->steps, run->t,
                      system->order == 2 ? system_energy(system, run->y) - previous_energy : 0};
    /* The motion is another one, so the step control begins with the initial step again. */
    run->controller = (struct controller){.tol = run->settings.tol,
                                          .h = copysign(run->settings.dt, run->controller.h)};
    ledger_rescale(run, 1);
    ledger_take(run, run->y, run->plan.adaptive ? &run->t : NULL, (size_t)run->system.n, 1);
    p->step.warm = false;
    forget_rounding(p, system->n);
    run->plan.ledger = true;
    run->plan.exact_known = false;
    return true;
}
