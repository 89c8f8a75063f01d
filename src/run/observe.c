/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Observables: quantities that are computed from a row of a run when something asks for them. A new
 * one is a row of observables.def, which gives its name, unit, needs and value. This file computes
 * columns of them, errors against the exact solution, and the names that expressions of a run may
 * use. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/base/elementary.h>
#include <hooke/scene/typed.h>
#include "run/private.h"

#include <float.h>
#include <math.h>

/* Returns the velocities [n / 2], the second half of the state. */
static const double *velocity(const struct sample *sample)
{
    return sample->y + sample->system->n / 2;
}

/* Returns the acceleration [m/s^2] of the first coordinate. */
static double acceleration(const struct sample *sample)
{
    double a[LIMIT_VARIABLES];
    system_acceleration(sample->system, sample->t, sample->y, a);
    return a[0];
}

/* Returns (E - E0 - work)/|E0|; NAN if E0 is 0. */
static double energy_error(const struct sample *s)
{
    const double error = system_energy(s->system, s->y) - s->initial - s->work;
    return s->initial != 0 ? error / fabs(s->initial) : NAN;
}

/* Returns the distance from the exact solution: over the positions, or over all variables of a
 * first-order scene. In one variable it has a sign. */
static double distance_from_exact(const struct sample *s)
{
    const int count = s->system->order == 2 ? s->system->n / 2 : s->system->n;
    double distance = s->y[0] - s->exact[0];
    for (int i = 1; i < count; i++)
        distance = fixed_hypot(distance, s->y[i] - s->exact[i]);
    return distance;
}

/* Point about the equilibrium: position [m], velocity over omega0 [m]. */
struct phase_point {
    double q, p;
};

/* Returns the state as a point of the phase plane around the equilibrium of a linear oscillator. */
static struct phase_point phase_point(const struct system *system, const double *y)
{
    const struct oscillator *o = &system->oscillator;
    return (struct phase_point){y[0] + o->gravity / o->stiffness,
                                y[system->n / 2] / sqrt(o->stiffness)};
}

/* Returns the phase of a minus that of b, from -pi to pi. The phase grows with time: q = A
 * cos(phase), p = -A sin(phase). */
static double phase_after(struct phase_point a, struct phase_point b)
{
    const double dot_product = a.q * b.q + a.p * b.p, cross_product = a.q * b.p - a.p * b.q;
    if (fabs(dot_product) + fabs(cross_product) > DBL_MIN / DBL_EPSILON)
        return fixed_atan2(cross_product, dot_product);
    /* The products are so small that they have lost digits. */
    return remainder(fixed_atan2(-a.p, a.q) - fixed_atan2(-b.p, b.q), 2 * M_PI);
}

/* Returns the angle [rad] plus the multiple of 2 pi that brings it nearest to the previous one, so
 * that a phase from -pi to pi is continued beyond these. */
static double phase_unwrap(double angle, double previous)
{
    return fabs(angle - previous) <= M_PI ? angle
                                          : previous + remainder(angle - previous, 2 * M_PI);
}

/* Returns the amplitude [m] of the oscillation through a state. */
static double amplitude_of(const struct system *system, const double *y)
{
    struct phase_point point = phase_point(system, y);
    return fixed_hypot(point.q, point.p);
}

/* ---- the table ---- */

#define OBSERVABLE(id, name, alias, unit, brief, quantity, needs, value)                           \
    static double value_##id(const struct sample *s)                                               \
    {                                                                                              \
        return value;                                                                              \
    }
#include "run/observables.def"
#undef OBSERVABLE
#define OBSERVABLE(id, name, alias, unit, brief, quantity, needs, value)                           \
    {{name, unit, brief, "", alias}, QUANTITY_##quantity, needs, value_##id},
static const struct observable observables[] = {
#include "run/observables.def"
};

const struct catalog observable_catalog = CATALOG("observable", observables);

const struct observable *observable_by_name(struct text name)
{
    return (const struct observable *)(const void *)catalog_find(&observable_catalog, name);
}

const struct observable *observable_at(size_t i)
{
    return (const struct observable *)(const void *)catalog_row(&observable_catalog, i);
}

const struct observable *observable_from(const struct row *row)
{
    return (const struct observable *)(const void *)row;
}

/* ---- what they are in a scene ---- */

/* Returns true if the first coordinate is a length. */
static bool is_on_line(const struct system *system)
{
    return system_variable(system, 0).quantity == QUANTITY_LENGTH;
}

/* Replaces lengths by angles for a pendulum, and everything by numbers in scenes without units. */
enum quantity observable_quantity(const struct observable *observable, const struct system *system)
{
    /* The first coordinate of a pendulum is an angle, so its velocity is an angular one. */
    static const enum quantity turning[QUANTITY_COUNT] = {
        [QUANTITY_LENGTH] = QUANTITY_ANGLE,
        [QUANTITY_VELOCITY] = QUANTITY_ANGULAR_FREQUENCY,
        [QUANTITY_ACCELERATION] = QUANTITY_ANGULAR_ACCELERATION};
    enum quantity declared = observable->quantity, first = system_variable(system, 0).quantity;
    if (first == QUANTITY_NUMBER && declared != QUANTITY_TIME)
        return QUANTITY_NUMBER;
    return first == QUANTITY_ANGLE && turning[declared] ? turning[declared] : declared;
}

const char *observable_unit(const struct observable *observable, const struct system *system)
{
    enum quantity quantity = observable_quantity(observable, system);
    return quantity == QUANTITY_OTHER ? observable->row.unit : quantity_unit(quantity);
}

bool run_centre(const struct run *run, double *centre)
{
    const struct oscillator *o = &run->system.oscillator;
    *centre = -o->gravity / o->stiffness;
    return run->system.n == 2 && o->whole && o->stiffness > 0 && o->drive == 0;
}

/* ---- asking ---- */

/* Returns the need that a run of this system does not meet, in words that follow "needs", or NULL
 * if the observable is defined. */
static const char *missing_need(const struct observable *observable, const struct system *system,
                                bool exact_known)
{
    if (observable->needs & NEED_EXACT && !exact_known)
        return "a scene with a closed-form solution";
    if (observable->needs & NEED_MECHANICS && system->order != 2)
        return "a scene with positions and velocities";
    if (observable->needs & NEED_ENERGY && !system->energy)
        return "forces that have a potential";
    if (observable->needs & NEED_LINE && !(system->n == 2 && is_on_line(system)))
        return "motion along a line";
    if (observable->needs & NEED_CENTRE && !system->oscillator.whole)
        return "a linear spring, with only drag, gravity and a drive besides";
    if (observable->needs & NEED_CENTRE && !(system->oscillator.stiffness > 0))
        return "an oscillation about an equilibrium (k > 0)";
    return NULL;
}

/* Sets the error that the run lacks what the observable needs. Returns false. */
static bool refuse_observable(const struct observable *observable, const char *missing,
                              struct error *error)
{
    error_set(error, ERROR_COMMAND, "%s needs %s, which this run does not have",
              observable->row.name, missing);
    return observable->needs & NEED_ENERGY
               ? error_hint(error, "its kinetic energy is called kinetic")
               : false;
}

bool observable_defined(const struct observable *observable, const struct system *system,
                        bool exact_known)
{
    return !missing_need(observable, system, exact_known);
}

const struct observable *observable_energy(const struct system *system)
{
    return observable_by_name(system->energy || system->order != 2 ? TEXT("energy")
                                                                   : TEXT("kinetic"));
}

/* Computes the observable at each row, with looks at Ctrl-C on the way. */
bool run_column(const struct run *run, const struct observable *observable, double *values,
                struct error *error)
{
    const char *missing = missing_need(observable, &run->system, run->plan.exact_known);
    if (missing)
        return refuse_observable(observable, missing, error);
    struct walk walk;
    walk_begin(&walk, run, observable->needs);
    for (size_t row = 0; walk_next(&walk); row++) {
        if (row % LOOK_EACH_ROWS == 0 && cancelled(run->cancel)) {
            walk_leave(&walk);
            return error_set(error, ERROR_CANCELLED, "stopped");
        }
        *values++ = observable->value(&walk.sample);
    }
    return true;
}

void run_variable_column(const struct run *run, int i, double *values)
{
    for (size_t row = 0; row < trace_count(run->trace); row++)
        values[row] = trace_state(run->trace, row)[i];
}

void run_observed_column(const struct run *run, int i, double *values)
{
    struct walk walk;
    walk_begin(&walk, run, 0);
    while (walk_next(&walk))
        *values++ = system_observe(walk.sample.system, i, walk.sample.t, walk.sample.y);
}

double run_observed(const struct run *run, int i)
{
    return system_observe(&run->system, i, run->t, run->y);
}

/* Returns the value at the present state; NAN if the observable is not defined. */
double run_observable(const struct run *run, const struct observable *observable)
{
    if (!observable_defined(observable, &run->system, run->plan.exact_known))
        return NAN;
    struct walk walk;
    walk_present(&walk, run, observable->needs);
    return observable->value(&walk.sample);
}

/* Compares all rows with the exact solution, and the end also with its floor. */
void run_errors(const struct run *run, struct run_errors *errors)
{
    *errors = (struct run_errors){NAN, NAN, NAN, NAN, NAN};
    if (!run->plan.exact_known)
        return;
    const struct system *system = &run->system;
    const bool oscillates = system->oscillator.whole && system->oscillator.stiffness > 0;
    const int judged = system->order == 2 && system->n == 2 ? 1 : system->n;
    double max[LIMIT_VARIABLES] = {0}, amplitude[LIMIT_VARIABLES] = {0},
           distance[LIMIT_VARIABLES] = {0}, phase = 0;
    struct walk walk;
    const struct sample *sample = &walk.sample;
    walk_begin(&walk, run, NEED_EXACT);
    for (size_t row = 0; walk_next(&walk); row++) {
        if (row % LOOK_EACH_ROWS == 0 && cancelled(run->cancel)) {
            walk_leave(&walk);
            return;
        }
        for (int i = 0; i < judged; i++) {
            distance[i] = fabs(sample->y[i] - sample->exact[i]);
            /* The comparisons ignore NAN, as fmax() does, which would be a call. */
            const double size = fabs(sample->exact[i]);
            max[i] = distance[i] > max[i] ? distance[i] : max[i];
            amplitude[i] = size > amplitude[i] ? size : amplitude[i];
        }
        if (!oscillates)
            continue;
        const struct phase_point here = phase_point(sample->system, sample->y),
                                 wanted = phase_point(sample->system, sample->exact);
        /* A motion that is at rest at the equilibrium has no phase, there and in all later rows. */
        if (here.q == 0 && here.p == 0 && (wanted.q != 0 || wanted.p != 0))
            phase = NAN;
        /* The phase changes by far less than pi from row to row, so its turns can be counted. */
        phase = phase_unwrap(phase_after(here, wanted), phase);
    }

    /* Error of the exact solution at the end because of rounding. */
    const struct epoch *epoch = run_epoch(run, run->steps);
    double exact[LIMIT_VARIABLES], floor[LIMIT_VARIABLES];
    system_exact(&epoch->system, epoch->t, epoch->start, run->t, exact, floor);
    for (int i = 0; i < judged; i++) {
        if (max[i] == 0 && amplitude[i] == 0) { /* the variable is exactly 0, as it should be */
            amplitude[i] = 1;
            floor[i] = 0;
        }
        if (amplitude[i] > 0) { /* fmax() ignores that the errors are NAN at first */
            errors->end = fmax(errors->end, distance[i] / amplitude[i]);
            errors->max = fmax(errors->max, max[i] / amplitude[i]);
            errors->floor = fmax(errors->floor, floor[i] / amplitude[i]);
        }
    }
    if (oscillates) {
        double wanted = amplitude_of(sample->system, sample->exact);
        errors->phase = phase;
        errors->amplitude = wanted > 0 ? amplitude_of(sample->system, sample->y) / wanted - 1 : NAN;
    }
}

/* ---- names in expressions ----
 *
 * Callbacks of run_scope(); slots are the state variables, then the observed quantities of a typed
 * scene, then the observables.
 */

/* Sets *slot to that of a name. Returns false if the run has no such name, or if it is an energy
 * and the forces have no potential. */
static bool scope_find(const void *context, struct text name, int *slot)
{
    const struct run *run = context;
    const struct model *model = run->system.model;
    *slot = model_state(model, name);
    for (int i = 0; *slot < 0 && i < model_observed(model); i++)
        if (text_is(name, model_observed_variable(model, i).name))
            *slot = model->n + i;
    if (*slot >= 0)
        return true;
    const struct row *row = catalog_find(&observable_catalog, name);
    if (row && (observable_from(row))->needs & NEED_ENERGY && run->system.order == 2 &&
        !run->system.energy)
        return false;
    if (row)
        *slot = model->n + model_observed(model) + (int)(observable_from(row) - observables);
    return row != NULL;
}

/* Returns the value of a slot at the run's present state; NAN if it is not defined. */
static double scope_load(const void *context, int slot)
{
    const struct run *run = context;
    const int n = run->system.n, observed = model_observed(run->system.model);
    if (slot < n)
        return run->y[slot];
    return slot < n + observed ? run_observed(run, slot - n)
                               : run_observable(run, &observables[slot - n - observed]);
}

/* Offers all names as corrections of a misspelled one. */
static void scope_offer(const void *context, struct suggestion *suggestion)
{
    const struct run *run = context;
    for (int i = 0; i < run->system.n; i++)
        suggestion_offer(suggestion, system_variable(&run->system, i).name);
    for (int i = 0; i < model_observed(run->system.model); i++)
        suggestion_offer(suggestion, model_observed_variable(run->system.model, i).name);
    for (size_t i = 0; i < COUNT_OF(observables); i++)
        suggestion_offer(suggestion, observables[i].row.alias ? observables[i].row.alias
                                                              : observables[i].row.name);
}

/* Returns the physical quantity of a slot; only those of state variables are known. */
static enum quantity scope_quantity(const void *context, int slot)
{
    const struct run *run = context;
    return slot < run->system.n ? system_variable(&run->system, slot).quantity : QUANTITY_OTHER;
}

bool run_scope(const struct run *run, struct expr_scope *scope)
{
    *scope = (struct expr_scope){run, scope_find, scope_load, scope_offer, NULL, scope_quantity};
    return run != NULL;
}

/* Slots of time, position and velocity are the columns that rows have of them. */
struct moving run_scope_moving(const struct run *run, int slot)
{
    const int n = run->system.n, observable_slot = slot - n - model_observed(run->system.model);
    if (slot < n)
        return (struct moving){MOVING_STATE, slot};
    double (*const value)(const struct sample *) =
        observable_slot < 0 ? NULL : observables[observable_slot].value;
    if (value == value_t)
        return (struct moving){MOVING_TIME, 0};
    if (value == value_y || (value == value_v && run->system.order == 2))
        return (struct moving){MOVING_STATE, value == value_v ? n / 2 : 0};
    return (struct moving){MOVING_OTHER, slot};
}

int run_scope_slots(const struct run *run)
{
    return run->system.n + model_observed(run->system.model) + (int)COUNT_OF(observables);
}

/* Returns the largest recorded speed of the first coordinate between two times. */
double run_speed_max(const struct run *run, double t_begin, double t_end)
{
    double max = 0;
    for (size_t i = 0; i < trace_count(run->trace); i++)
        if (trace_time(run->trace, i) >= t_begin && trace_time(run->trace, i) <= t_end)
            max = fmax(max, fabs(trace_state(run->trace, i)[run->system.n / 2]));
    return max;
}
