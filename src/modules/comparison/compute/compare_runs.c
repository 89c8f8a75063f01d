/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `compare`: the same scene integrated by several methods and step sizes, with
 * errors, energy, cost and a verdict in words. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include "modules/comparison/compute/errors.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Prediction from the method's one-step matrix, or its growth factor, for an undriven linear
 * oscillator. */
struct prediction {
    /* false for other scenes and adaptive runs, and if the method has no growth factor */
    bool known;
    double growth; /* amplitude factor per step (spectral radius) */
    /* ln of the amplitude factor after the run, whose last step may be shorter */
    double amplitude;
    double factor; /* E/E0 after the run, the square of the amplitude factor */
    double exact;  /* E/E0 of the exact solution */
    double swing;  /* largest |E - E0|/E0 that comes and goes within a period */
};

/* Returns the largest relative deviation of the energy q^2 + p^2 if a matrix [a b; c d] of
 * determinant 1 with complex eigenvalues is applied again and again: it keeps -c q^2 + (a - d) q p
 * + b p^2 constant, so that the energy stays within the ratio of that form's eigenvalues. Returns
 * NAN if the form is not definite. */
static double ellipse_swing(const double matrix[4])
{
    double p = -matrix[2];
    double r = matrix[1];
    double s = 0.5 * (matrix[0] - matrix[3]);
    double mean = 0.5 * (p + r);
    double half = hypot(0.5 * (p - r), s);
    return mean > half ? (mean + half) / (mean - half) - 1 : NAN;
}

/* Returns the Frobenius norm. */
static double matrix_norm(const double matrix[4])
{
    return hypot(hypot(matrix[0], matrix[1]), hypot(matrix[2], matrix[3]));
}

/* A last step that is shorter than dt by more than this fraction is a shorter step, not a rounded
 * one. */
#define LAST_STEP_SHORTER 1e-6

/* Returns E/E0 of the exact solution at the end of the run. With damping the energy falls in waves,
 * so that exp(-2 zeta omega t) would not do. */
static double exact_factor(const struct run *run, double omega)
{
    const double *start = trace_state(run->trace, 0);
    double y[LIMIT_VARIABLES], floor[LIMIT_VARIABLES];
    system_exact(&run->system, run->system.t0, start, run->t, y, floor);
    /* no square underflows */
    const double ratio = hypot(y[0], y[1] / omega) / hypot(start[0], start[1] / omega);
    return ratio * ratio;
}

/* Predicts growth and energy of a finished run. Returns known = false unless the scene is an
 * undriven oscillator without gravity and the steps are fixed. */
static struct prediction predict_energy(const struct run *run)
{
    const struct oscillator *o = &run->system.oscillator;
    struct prediction prediction = {
        .growth = run->plan.growth, .factor = NAN, .exact = NAN, .swing = NAN};
    bool oscillates = o->stiffness > 0 && fabs(o->damping) < 2 * sqrt(o->stiffness);
    if (!o->whole || !run->system.linear || !run->system.autonomous || o->gravity != 0 ||
        !oscillates || run->plan.adaptive || !system_has_potential(&run->system)) {
        return prediction;
    }
    double omega = sqrt(o->stiffness), x = omega * run->settings.dt,
           zeta = o->damping / (2 * omega);
    double matrix[4];
    bool one_step = method_amplification(run->method, run->settings.drag, x, zeta, matrix);
    if (isnan(prediction.growth)) { /* a method of several steps */
        prediction.growth = method_growth(run->method, run->settings.drag, x, zeta);
    }
    prediction.known = !isnan(prediction.growth);
    const double dt = fabs(run->settings.dt),
                 last = fabs(run->t - run->system.t0) - (double)(run->steps - 1) * dt;
    if (last > 0 && last < (1 - LAST_STEP_SHORTER) * dt) {
        const double end = method_growth(run->method, run->settings.drag, omega * last, zeta);
        prediction.amplitude = (double)(run->steps - 1) * log(prediction.growth) + log(end);
        if (run->steps == 1) {
            prediction.growth = end;
            one_step =
                method_amplification(run->method, run->settings.drag, omega * last, zeta, matrix);
        }
    } else {
        prediction.amplitude = (double)run->steps * log(prediction.growth);
    }
    prediction.factor = exp(2 * prediction.amplitude);
    prediction.exact = exact_factor(run, omega);
    prediction.swing = one_step ? ellipse_swing(matrix) : NAN;
    if (one_step && isnan(prediction.swing)) /* growth of single steps beyond the spectral radius */
        prediction.swing = fmax(2 * log(matrix_norm(matrix) / prediction.growth), 0);
    return prediction;
}

/* A predicted factor over the whole run within this of 1 counts as bounded. */
#define BOUNDED_GROWTH_MAX 0.02

/* Returns the largest energy error of the last quarter of the rows over that of the first, or NAN
 * if the run has no energy or out of memory. */
static double energy_trend(const struct run *run)
{
    const struct observable *missing = observable_by_name(TEXT("energy-error"));
    const size_t n = trace_count(run->trace);
    double *value = malloc(n * sizeof *value), max[4] = {0};
    struct error ignored;
    const bool known = value && run_column(run, missing, value, &ignored);
    for (size_t i = 0; known && i < n; i++)
        max[4 * i / n] = fmax(max[4 * i / n], fabs(value[i]));
    free(value);
    return known ? max[3] / max[0] : NAN;
}

/* Largest number of steps of an adaptive run: in stiff scenes explicit methods take tiny ones. */
#define ADAPTIVE_STEPS 2000000
#define ENERGY_ROUNDING 1e-12 /* Energy errors below this are rounding. */
/* Flags of methods whose energy error is bounded. */
#define KEEPS_ENERGY (METHOD_SYMPLECTIC | METHOD_SYMMETRIC | METHOD_ENERGY)
/* energy_trend() above which the energy drifts: it is 4 for a steady drift, about 1 for a bounded
 * error. */
#define ENERGY_TREND_MAX 1.5

/* Appends "within 0.01 of E0" or "off by 1700 times E0". */
static void put_energy_off(double error, struct buffer *output)
{
    buffer_format(output, error < 1 ? "within %.2g of E0" : "off by %.2g times E0", error);
}

/* Appends a verdict from the observed energy alone, for runs without a prediction. */
static void put_observed_energy(const struct comparison *row, const char *span,
                                struct buffer *output)
{
    const struct run *run = row->run;
    const struct ledger *ledger = &row->ledger;
    const double peak = run_energy_peak(run, ledger);
    if (isnan(ledger->error_max)) {
        buffer_format(output, "reached %s", span);
        return;
    }
    if (ledger->error_max <= ENERGY_ROUNDING) {
        buffer_format(output, "energy%s kept to rounding", run->plan.ledger ? " balance" : "");
    } else if (row->energy_factor == 0) {
        buffer_put(output, TEXT("vanished: the energy is below the smallest positive number"));
    } else if (!run->system.conservative && isnan(peak)) {
        buffer_put(output, TEXT("energy balance "));
        put_energy_off(ledger->error_max, output);
    } else if (!run->system.conservative) {
        buffer_format(output, "energy balance within %.2g times the largest energy in %s (%.2g E0)",
                      ledger->error_max / peak, span, peak);
        return;
    } else if (energy_trend(run) <=
               /* the error of any method grows after an orbit or two if it drifts */
               ENERGY_TREND_MAX) {
        buffer_format(output, "energy %s",
                      run->method->flags & KEEPS_ENERGY && !run->plan.adaptive ? "bounded: " : "");
        put_energy_off(ledger->error_max, output);
    } else if (row->energy_factor > 2 || (row->energy_factor < 0.5 && row->energy_factor >= 0)) {
        buffer_format(output, "%s by the method: energy x %.4g",
                      row->energy_factor > 2 ? "driven up" : "damped away", row->energy_factor);
    } else {
        buffer_format(output, "energy drifts: by %.2g E0", ledger->error);
    }
    buffer_format(output, " in %s", span);
}

/* Appends the observed energy beside the predicted one and whether they agree; sets
 * predicted_factor, grows and shrinks of the row. */
static void put_predicted_energy(struct comparison *row, const struct prediction *prediction,
                                 const char *span, struct buffer *output)
{
    const bool conservative = row->run->system.conservative;
    const double predicted = 2 * prediction->amplitude, /* the factor may be below all numbers */
        swing = isnan(prediction->swing) ? 0 : prediction->swing;
    row->predicted_factor = prediction->factor;
    row->grows =
        prediction->growth > 1 && predicted > fmax(log(prediction->exact), 0) + BOUNDED_GROWTH_MAX;
    row->shrinks = predicted < log(prediction->exact) - log(10);
    /* no growth is predicted: the energy error should stay within the swing */
    if (conservative && fabs(predicted) <= BOUNDED_GROWTH_MAX) {
        buffer_format(output, "energy bounded, %s: ",
                      row->ledger.error_max <= 1.001 * swing + BOUNDED_GROWTH_MAX
                          ? "as predicted"
                          : "but NOT as predicted");
        put_energy_off(row->ledger.error_max, output);
        buffer_format(output, " in %s", span);
        return;
    }
    /* the predicted exponent may be wrong by a tenth, as the energy at the end swings, too */
    const bool vanished = row->energy_factor == 0,
               agrees = vanished ? 0.9 * predicted <= log(DBL_TRUE_MIN) - log(row->ledger.initial) +
                                                          swing + BOUNDED_GROWTH_MAX
                                 : fabs(predicted - log(row->energy_factor)) <=
                                       0.1 * fabs(predicted) + BOUNDED_GROWTH_MAX + swing;
    const char *as = agrees ? "as predicted" : "NOT as predicted";
    if (vanished)
        buffer_format(output, "vanished, %s: the energy is below the smallest number in %s, ", as,
                      span);
    else
        buffer_format(output, "energy x %.4g in %s, %s: ", row->energy_factor, span, as);
    buffer_format(output, "amplitude x %.6g per step", prediction->growth);
    if (!conservative || vanished)
        buffer_format(output, " (exact: energy x %.4g)", prediction->exact);
}

/* Writes the verdict on a finished run: why it stopped, or how its energy behaved and how large its
 * error is. */
static void comparison_verdict(struct comparison *row)
{
    const struct run *run = row->run;
    const double span = fabs(run->t - run->system.t0);
    struct buffer text = {0};
    const struct prediction prediction =
        run->stop == STOP_END ? predict_energy(run) : (struct prediction){0};
    if (run->stop == STOP_GIVEN_UP) {
        buffer_format(
            &text, "given up at t = %.4g s after %lld steps; all %.2g s would need about %.1g%s",
            run->t, (long long)run->steps, row->duration, (double)run->steps * row->duration / span,
            run->method->flags & METHOD_IMPLICIT
                ? ""
                : "; try an adaptive implicit method such as radau5");
    } else if (run->stop != STOP_END) {
        run_explain(run, &text);
    } else {
        const char *shown = SHOWN_QUANTITY(span, QUANTITY_TIME, 4);
        if (prediction.known)
            put_predicted_energy(row, &prediction, shown, &text);
        else
            put_observed_energy(row, shown, &text);
        if (!prediction.known && !isnan(row->errors.max))
            buffer_format(&text, ", error %.2g of the amplitude", row->errors.max);
    }
    snprintf(row->verdict, sizeof row->verdict, "%s", buffer_view(&text));
    buffer_free(&text);
}

/* Sets end and max error of a row whose scene has no closed form: solves once more, on the common
 * grid, and compares with the reference. Leaves them unchanged if out of memory or if the solve
 * fails. */
static void measure_errors(struct comparison *row, const struct reference *reference,
                           const struct cancel *cancel)
{
    const struct run *run = row->run;
    const size_t size = (size_t)STUDY_TIMES * (size_t)run->system.n;
    double *grid = malloc(size * sizeof *grid);
    struct solver solver;
    if (grid && solver_init(&solver, &run->system, run->method, &run->settings, reference->span)) {
        struct study_errors errors;
        if (solver_run(&solver, grid, cancel) == STOP_END) {
            grid_errors(&run->system, reference, grid, &errors);
            row->errors.end = errors.end;
            row->errors.max = errors.max;
        }
        solver_free(&solver);
    }
    free(grid);
}

/* Runs one choice with one setting (tol 0 for fixed steps) and fills in the row with errors, energy
 * and verdict. Returns false with an error if the run cannot be created. If cancelled it returns
 * true with an incomplete row, whose run the caller destroys. */
static bool compare_one(const struct compare_request *request, const struct method_choice *choice,
                        double dt, double tol, const struct reference *reference,
                        struct comparison *row, struct error *error)
{
    *row = (struct comparison){
        .duration = request->duration, .order = NAN, .predicted_factor = NAN, .energy_factor = NAN};
    const bool adapts = choice->method->flags & METHOD_ADAPTIVE && tol > 0;
    struct run_settings settings = {
        .dt = adapts && request->first > 0 ? request->first : dt,
        .drag = choice->drag,
        /* methods are compared, not powers of their matrices: evaluations are counted */
        .kernel = KERNEL_SPECIALISED,
        .compensated = request->compensated,
        .record = request->record,
    };
    if (adapts)
        settings.tol = tol;
    row->run = run_create(request->scene, choice->method, &settings, request->duration, error);
    if (!row->run) {
        return false;
    }
    const struct run_target target = {.t = row->run->system.t0 + request->duration,
                                      .steps = adapts ? ADAPTIVE_STEPS : -1};
    while (run_advance(row->run, &target, 0, request->cancel)) {
    }
    /* the limit on adaptive steps was reached before the end */
    if (row->run->stop == STOP_END && row->run->t != target.t)
        row->run->stop = STOP_GIVEN_UP;
    run_diagnose(row->run);
    /* the run stepped over the end of the solution */
    if (row->run->stop == STOP_END && !isnan(reference->singular.t)) {
        row->run->stop = STOP_SINGULAR;
        row->run->singular = reference->singular;
    }
    if (cancelled(request->cancel)) {
        return true; /* the caller drops the row: nothing more is computed for it */
    }
    run_errors(row->run, &row->errors);
    if (reference->y) {
        memcpy(row->reference, reference->method, sizeof row->reference);
        row->reference_stored = reference->stored;
        row->errors.floor = reference->accuracy;
        if (row->run->stop == STOP_END)
            measure_errors(row, reference, request->cancel);
    }
    run_ledger(row->run, &row->ledger);
    row->energy_factor = row->ledger.factor;
    row->path = study_path(&row->run->system, choice->method, &row->run->settings);
    row->time = (struct timing_result){.minimum = NAN, .median = NAN, .spread = NAN};
    comparison_verdict(row);
    return true;
}

/* Returns the order seen between two rows of one method, from error ~ dt^p, or NAN if one of them
 * did not reach the end. */
static double observed_order(const struct comparison *coarse, const struct comparison *fine)
{
    double ratio = log(coarse->run->settings.dt / fine->run->settings.dt);
    double order = log(coarse->errors.max / fine->errors.max) / ratio;
    return fine->run->stop == STOP_END && coarse->run->stop == STOP_END && isfinite(order) ? order
                                                                                           : NAN;
}

/* Predicts steps and computing time [s] of the runs with fixed steps, before any of them runs. */
bool study_compare_plan(const struct compare_request *request, double *steps, double *seconds,
                        struct error *error)
{
    const bool by_tol = request->tols > 0;
    struct system system;
    *steps = *seconds = 0;
    if (!scene_bind(request->scene, &system, error)) {
        return false;
    }
    for (int c = 0; c < request->choices; c++) {
        enum drag drag = request->choice[c].drag;
        if (!method_applies(request->choice[c].method, &system, &drag, error)) {
            return false;
        }
        for (int s = 0; s < (by_tol ? request->tols : request->dts); s++) {
            struct run_settings each = {
                .dt = request->dt[by_tol ? 0 : s], .drag = drag, .record = request->record};
            if (by_tol && (request->choice[c].method->flags & METHOD_ADAPTIVE)) {
                each.tol = request->tol[s];
            }
            struct plan plan;
            if (!plan_make(&system, request->choice[c].method, &each, request->duration, &plan,
                           error)) {
                return false;
            }
            /* the steps of adaptive methods are unknown, which is no reason to leave out the
             * others */
            if (isnan(plan.steps))
                continue;
            *steps += plan.steps;
            *seconds += plan.seconds;
        }
    }
    return true;
}

/* Runs all choices at all settings into rows [*count]. Returns false with an error if a run cannot
 * be created or if cancelled; rows before that are complete. */
static bool compare_all(const struct compare_request *request, const struct reference *reference,
                        struct comparison *rows, int *count, struct error *error)
{
    bool by_tol = request->tols > 0;
    int settings = by_tol ? request->tols : request->dts;
    for (int c = 0; c < request->choices; c++) {
        for (int s = 0; s < settings; s++) {
            bool adaptive = by_tol && (request->choice[c].method->flags & METHOD_ADAPTIVE);
            if (by_tol && !adaptive && s > 0) {
                break; /* tolerances mean nothing to a fixed-step method: one row */
            }
            struct comparison *row = &rows[*count];
            const double dt = request->dt[by_tol ? 0 : s];
            const double tol = adaptive ? request->tol[s] : 0;
            if (!compare_one(request, &request->choice[c], dt, tol, reference, row, error)) {
                return false;
            }
            if (cancelled(request->cancel)) {
                comparison_free(row);
                return error_set(error, ERROR_CANCELLED, "stopped: %d of %d finished", *count,
                                 request->choices * settings);
            }
            if (!by_tol && s > 0) {
                row->order = observed_order(row - 1, row);
            }
            (*count)++;
        }
    }
    return true;
}

/* Measures the computing times of those rows [count] whose runs reached the end, side by side, so
 * that whatever disturbs the machine affects all of them alike. Returns false with an error if out
 * of memory or cancelled. */
static bool time_rows(const struct compare_request *request, struct comparison *rows, int count,
                      struct error *error)
{
    struct solver *solver = calloc((size_t)count + 1, sizeof *solver);
    struct timing_result *result = calloc((size_t)count + 1, sizeof *result);
    int *index = calloc((size_t)count + 1, sizeof *index), timed = 0;
    bool ok = solver && result && index;
    for (int i = 0; i < count && ok; i++) {
        const struct run *run = rows[i].run;
        if (run->stop != STOP_END)
            continue;
        ok = solver_init(&solver[timed], &run->system, run->method, &run->settings,
                         request->duration);
        index[timed] = i;
        timed += ok;
    }
    if (ok)
        time_solvers(solver, result, timed, request->timing, 0, request->cancel);
    for (int i = 0; i < timed; i++) {
        if (ok)
            rows[index[i]].time = result[i];
        solver_free(&solver[i]);
    }
    free(solver);
    free(result);
    free(index);
    if (!ok)
        return error_memory(error);
    return !cancelled(request->cancel) ||
           error_set(error, ERROR_CANCELLED,
                     "stopped: all runs are finished, but not all are timed");
}

/* Runs every choice at every setting, in order. */
bool study_compare(const struct compare_request *request, struct comparison *rows, int *count,
                   struct error *error)
{
    *count = 0;
    /* Settings that cannot be run are refused before any work. */
    double steps, seconds;
    struct system system;
    struct error none = {0};
    struct reference reference = {.singular = {.t = NAN}};
    if (!study_compare_plan(request, &steps, &seconds, error) ||
        !scene_bind(request->scene, &system, error)) {
        return false;
    }
    /* Errors need a reference, but a comparison does not. */
    if (!system_has_exact(&system) &&
        !references_get(request->references, request->scene, &system, request->duration,
                        request->cancel, &reference, &none) &&
        none.code != ERROR_NUMERICAL) {
        *error = none;
        return false;
    }
    bool ok = compare_all(request, &reference, rows, count, error);
    reference_free(&reference);
    if (ok && request->timing != TIMING_OFF)
        ok = time_rows(request, rows, *count, error);
    return ok;
}

void comparison_free(struct comparison *row)
{
    run_destroy(row->run);
    row->run = NULL;
}
