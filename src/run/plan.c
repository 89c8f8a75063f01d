/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plan of a run: what the scene and the method need to have computed, and which requests are
 * refused before anything starts. plan_make() is the entry; plan_stable_limit() finds the largest
 * stable step. */
#include <hooke/base/catalog.h>
#include <hooke/run/step_limit.h>
#include "run/private.h"

#include <float.h>
#include <math.h>

static const struct row kernels[] = {
    [KERNEL_PROPAGATOR] = {"propagator", "",
                           "linear scenes of two variables by powers of the one-step matrix, other "
                           "scenes by specialised code",
                           "", NULL},
    [KERNEL_SPECIALISED] = {"specialised", "",
                            "specialised steps for the method and the kind of scene, if they exist",
                            "", NULL},
    [KERNEL_GENERAL] = {"general", "", "the reference: every term is called at every stage", "",
                        NULL},
};

const struct catalog kernel_catalog = CATALOG("kernel", kernels);

/* Estimated times [ns] on a desktop of the 2020s, good to a factor of 3, which suffices to warn
 * before a run that takes hours. */
#define NS_STEP 30.0
#define NS_TERM 15.0  /* added per term of a force evaluation */
#define NS_SOLVE 20.0 /* added per variable in a step of an implicit method */

#define GROWTH_MARGIN 1e-12 /* excess of a spectral radius over 1 that counts as rounding */

/* Returns the estimated time [ns] of one step. */
static double step_ns(const struct system *system, const struct method *method)
{
    double ns = NS_STEP + NS_TERM * method->evals * system->terms * system->n / 2;
    return method->flags & METHOD_IMPLICIT ? ns + NS_SOLVE * system->n : ns;
}

/* Returns true if the rows fit into the memory budget. Otherwise sets an error whose hint has a
 * recording rule that fits. */
static bool check_memory(const struct run_settings *settings, double rows, double bytes,
                         struct error *error)
{
    double budget = (double)(settings->memory ? settings->memory : MEMORY_DEFAULT);
    if (bytes <= budget)
        return true;
    const bool timed = settings->record.rule == RECORD_TIMES;
    double every = ceil(bytes / budget);
    if (timed)
        every *= settings->record.interval;
    else if (settings->record.rule == RECORD_EVERY)
        every *= (double)settings->record.every;
    error_set(error, ERROR_COMMAND, "recording %.6g rows needs %.4g bytes; the limit is %.4g bytes",
              rows, bytes, budget);
    return error_hint(
        error,
        "'set record auto' keeps every peak in at most %u rows; 'set record every %.15g%s' fits",
        LIMIT_SAMPLES, every, timed ? " s" : "");
}

/* Returns true if the steps can be counted and each changes the time. Otherwise sets an error that
 * names the smallest dt. */
static bool check_grid(double t0, double dt, double span, const struct stretch *stretch,
                       struct error *error)
{
    double far = fmax(fabs(t0), isinf(span) ? 0 : fabs(t0 + span));
    if (isfinite(span) && stretch->ratio > LIMIT_STEPS) {
        error_set(error, ERROR_COMMAND,
                  "%.4g s in steps of %.4g s need %.4g steps; at most 2^53 can be counted",
                  fabs(span), dt, stretch->ratio);
        return error_hint(error, "dt must be at least %.2g s for this duration",
                          fabs(span) / LIMIT_STEPS * 1.05);
    }
    double spacing = far - nextafter(far, 0);
    if (dt < spacing) {
        error_set(error, ERROR_COMMAND,
                  "dt = %.4g s is below the rounding of the time, %.2g s near t = %.4g s", dt,
                  spacing, far);
        return error_hint(error, "increase dt, or choose t0 nearer to 0");
    }
    return true;
}

/* Sets omega0 [rad/s] and zeta, with which a scene enters the stability tables (x = omega0 dt).
 * Returns false, and the values mean nothing, if it is no linear oscillator. */
static bool oscillation(const struct system *system, double *omega0, double *zeta)
{
    const struct oscillator *o = &system->oscillator;
    *omega0 = sqrt(o->stiffness);
    *zeta = o->damping / (2 * *omega0);
    return system->linear && o->whole && *omega0 > 0 && isfinite(*zeta);
}

/* Finds the largest step that the method accepts for this system: 0 if none, infinity if all. */
double plan_step_limit(const struct system *system, const struct method *method, enum drag drag)
{
    struct error ignored;
    /* Bisection over the logarithm of the step. */
    double low = log(DBL_MIN), high = log(DBL_MAX);
    /* This replaces DRAG_DEFAULT by the variant that the method uses. */
    if (!method_applies(method, system, &drag, &ignored))
        return HUGE_VAL;
    if (method_fits(method, system, drag, exp(high), &ignored))
        return HUGE_VAL;
    if (!method_fits(method, system, drag, exp(low), &ignored))
        return 0;
    while (high - low > 1e-14 * fmax(1, fabs(low))) {
        const double middle = (low + high) / 2;
        if (middle <= low || middle >= high)
            break;
        if (method_fits(method, system, drag, exp(middle), &ignored))
            low = middle;
        else
            high = middle;
    }
    return exp(low);
}

/* Returns the largest stable step of a linear oscillator; NAN for other scenes. */
double plan_stable_limit(const struct system *system, const struct method *method, enum drag drag)
{
    double omega0, zeta;
    if (!oscillation(system, &omega0, &zeta) ||
        zeta < 0) /* the true motion grows with negative damping */
        return NAN;
    return fmin(method_stable_limit(method, drag, zeta) / omega0,
                plan_step_limit(system, method, drag));
}

/* Returns the factor by which a step multiplies the amplitude of a linear oscillator; NAN for other
 * scenes. */
static double predicted_growth(const struct system *system, const struct method *method,
                               enum drag drag, double dt)
{
    double omega0, zeta;
    return oscillation(system, &omega0, &zeta) ? method_growth(method, drag, omega0 * dt, zeta)
                                               : NAN;
}

/* Plans fixed steps over the span; returns false with an error if they cannot be counted. */
bool plan_grid(const struct system *system, double dt, double span, struct plan *plan,
               struct error *error)
{
    const struct stretch stretch = stretch_measure(system->t0, system->t0 + span, dt);
    if (!check_grid(system->t0, dt, span, &stretch, error))
        return false;
    plan->whole = stretch.whole;
    plan->partial = fabs(stretch.partial);
    plan->exact_end = stretch.exact;
    plan->steps = (double)stretch.whole + (stretch.partial != 0);
    return true;
}

/* Returns true for linear scenes of two variables without drive, and methods whose step is a
 * matrix. */
bool plan_propagates(const struct system *system, const struct method *method,
                     const struct run_settings *settings, bool adaptive)
{
    const double interval = settings->record.interval;
    return settings->kernel == KERNEL_PROPAGATOR && !adaptive && !settings->compensated &&
           system->n == 2 && system->linear && system->autonomous && !method->growth &&
           (settings->record.rule != RECORD_TIMES ||
            fabs(remainder(interval, settings->dt)) <= 1e-14 * interval);
}

/* Checks the settings of a run over `span` [s], then sets *plan: what the run will compute, its
 * predicted steps, seconds, bytes and growth, NAN where they cannot be predicted. Returns false
 * with *error if a setting is invalid, the method does not apply, or the rows would take too much
 * memory. */
bool plan_make(const struct system *system, const struct method *method,
               const struct run_settings *settings, double span, struct plan *plan,
               struct error *error)
{
    double dt = settings->dt;
    if (!(dt > 0) || !isfinite(dt))
        return error_set(error, ERROR_COMMAND, "dt must be > 0 (got %.6g s)", dt);
    if (isnan(span))
        return error_set(error, ERROR_COMMAND, "the duration is not a number");
    if (!(settings->tol >= 0) || !isfinite(settings->tol))
        return error_set(error, ERROR_COMMAND, "tol must be >= 0 (got %.6g)", settings->tol);
    if (settings->record.rule == RECORD_EVERY && settings->record.every < 1)
        return error_set(error, ERROR_COMMAND, "record every N needs N >= 1 (got %lld)",
                         (long long)settings->record.every);
    const bool timed = settings->record.rule == RECORD_TIMES;
    if (timed && !(settings->record.interval > 0 && isfinite(settings->record.interval)))
        return error_set(error, ERROR_COMMAND, "record every TIME needs a time > 0 (got %.6g s)",
                         settings->record.interval);
    enum drag drag = settings->drag;
    if (!method_applies(method, system, &drag, error))
        return false;

    struct stretch stretch = stretch_measure(system->t0, system->t0 + span, dt);
    bool adaptive = settings->tol > 0 && method->flags & METHOD_ADAPTIVE;
    if (!adaptive && !method_fits(method, system, drag, copysign(dt, span), error))
        return false;
    *plan = (struct plan){
        .adaptive = adaptive,
        .exact_known = system_has_exact(system),
        .ledger = system->order == 2 && !system->conservative,
        .steps = NAN,
        .bytes = NAN,
        .seconds = NAN,
        .growth = adaptive ? NAN : predicted_growth(system, method, drag, fmin(dt, fabs(span))),
        .limit = NAN};
    plan->propagates = plan_propagates(system, method, settings, adaptive);
    if (plan->growth > 1 + GROWTH_MARGIN)
        plan->limit = plan_stable_limit(system, method, drag);
    double rows = floor(fabs(span) / settings->record.interval) + 2;
    if (timed && isfinite(span)) {
        plan->bytes = rows * (double)trace_row_bytes(system->n, true, true);
        if (!check_memory(settings, rows, plan->bytes, error))
            return false;
    }
    if (adaptive || isinf(span))
        return adaptive || check_grid(system->t0, dt, span, &stretch, error);
    if (!plan_grid(system, dt, span, plan, error))
        return false;
    plan->seconds = plan->steps * step_ns(system, method) * 1e-9;
    if (timed)
        return true;
    rows = plan->steps + 1;
    if (settings->record.rule == RECORD_AUTO)
        rows = fmin(rows, LIMIT_SAMPLES);
    else if (settings->record.rule == RECORD_EVERY)
        rows = floor(plan->steps / (double)settings->record.every) + 1;
    plan->bytes = rows * (double)trace_row_bytes(system->n, adaptive, false);
    return settings->record.rule == RECORD_AUTO || check_memory(settings, rows, plan->bytes, error);
}
