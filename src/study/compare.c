/* SPDX-License-Identifier: GPL-3.0-or-later */
/* compare: the same scene integrated by several methods and step sizes, with error, energy, cost and a verdict in
 * words. */
#include <hooke/study.h>

#include <stdio.h>
#include <string.h>

/* What the one-step matrix of the method says of the energy of one undriven linear oscillator. */
struct prediction {
    bool known;
    double growth; /* spectral radius: amplitude factor a step */
    double factor; /* E/E0 after the run: the energy is quadratic in the state, so growth^2 a step */
    double exact;  /* the same for the exact solution */
    double swing;  /* largest |E - E0|/E0 of a method that only turns the state round an ellipse */
};

/*
 * A matrix [a b; c d] of determinant 1 with complex eigenvalues keeps -c q^2 + (a - d) q p + b p^2 constant. The energy
 * q^2 + p^2 then stays within the ratio of that form's eigenvalues.
 */
static double ellipse_swing(const double matrix[4])
{
    double p = -matrix[2];
    double r = matrix[1];
    double s = 0.5 * (matrix[0] - matrix[3]);
    double mean = 0.5 * (p + r);
    double half = hypot(0.5 * (p - r), s);
    return mean > half ? (mean + half) / (mean - half) - 1 : NAN;
}

static struct prediction predict(const struct run *run)
{
    const struct oscillator *o = &run->system.oscillator;
    struct prediction prediction = {.growth = run->plan.growth, .factor = NAN, .exact = NAN, .swing = NAN};
    bool oscillates = o->stiffness > 0 && fabs(o->damping) < 2 * sqrt(o->stiffness);
    if (!o->whole || !run->system.linear || !run->system.autonomous || o->gravity != 0 || !oscillates ||
        run->plan.adaptive || isnan(run->plan.growth)) {
        return prediction;
    }
    double omega = sqrt(o->stiffness);
    double matrix[4];
    prediction.known = method_amplification(run->method, run->settings.drag, omega * run->settings.dt,
                                            o->damping / (2 * omega), matrix);
    prediction.factor = exp(2 * (double)run->steps * log(run->plan.growth));
    prediction.exact = exp(-o->damping * (run->t - run->system.t0));
    prediction.swing = prediction.known ? ellipse_swing(matrix) : NAN;
    return prediction;
}

static const char *span_text(double seconds, char out[48])
{
    struct buffer text = {0};
    buffer_quantity(&text, seconds, QUANTITY_TIME, 4);
    snprintf(out, 48, "%s", text.data ? text.data : "?");
    buffer_free(&text);
    return out;
}

/* A predicted factor over the whole run within this of 1 counts as bounded. */
#define BOUNDED 0.02

static void judge(struct comparison *row)
{
    const struct run *run = row->run;
    char span[48];
    span_text(fabs(run->t - run->system.t0), span);
    if (run->stop != STOP_END) {
        struct buffer why = {0};
        run_explain(run, &why);
        snprintf(row->verdict, sizeof row->verdict, "%s", why.data ? why.data : stop_name(run->stop));
        buffer_free(&why);
        return;
    }
    struct prediction prediction = predict(run);
    if (prediction.known) {
        row->predicted_factor = prediction.factor;
        double predicted = log(prediction.factor);
        double swing = isnan(prediction.swing) ? 0 : prediction.swing;
        if (run->system.conservative && fabs(predicted) <= BOUNDED) {
            bool agrees = row->ledger.error_max <= 1.001 * swing + BOUNDED;
            snprintf(row->verdict, sizeof row->verdict, "energy bounded, %s: within %.2g of E0 in %s",
                     agrees ? "as predicted" : "but NOT as predicted", row->ledger.error_max, span);
        } else {
            bool agrees = fabs(predicted - log(row->energy_factor)) <= 0.1 * fabs(predicted) + BOUNDED + swing;
            int used =
                snprintf(row->verdict, sizeof row->verdict, "energy x %.4g in %s, %s: amplitude x %.6g a step",
                         row->energy_factor, span, agrees ? "as predicted" : "NOT as predicted", prediction.growth);
            if (!run->system.conservative && used > 0 && (size_t)used < sizeof row->verdict) {
                snprintf(row->verdict + used, sizeof row->verdict - (size_t)used, " (exact: energy x %.4g)",
                         prediction.exact);
            }
        }
    } else if (!isnan(row->ledger.error_max)) {
        snprintf(row->verdict, sizeof row->verdict, "energy balance within %.2g of E0 in %s", row->ledger.error_max,
                 span);
    } else {
        snprintf(row->verdict, sizeof row->verdict, "reached %s", span);
    }
}

static bool compare_one(const struct compare_request *request, const struct contender *contender, double dt, double tol,
                        struct comparison *row, struct error *error)
{
    *row = (struct comparison){.order = NAN, .predicted_factor = NAN, .energy_factor = NAN};
    struct run_settings settings = {
        .dt = dt,
        .tol = contender->method->flags & METHOD_ADAPTIVE ? tol : 0,
        .drag = contender->drag,
        .record = request->record,
    };
    row->run = run_create(request->scene, contender->method, &settings, request->duration, error);
    if (!row->run) {
        return false;
    }
    struct run_target target = {.t = row->run->system.t0 + request->duration, .steps = -1};
    while (run_advance(row->run, &target, 0, request->cancel)) {
    }
    if (cancelled(request->cancel)) {
        return true; /* the caller drops the row: nothing more is computed for it */
    }
    run_errors(row->run, &row->errors);
    run_ledger(row->run, &row->ledger);
    row->energy_factor = row->ledger.final / row->ledger.initial;
    if (row->run->stop == STOP_END) {
        time_solve(&row->run->system, contender->method, &row->run->settings, request->duration, request->timing,
                   request->cancel, &row->time);
    } else {
        row->time = (struct timing_result){NAN, NAN, NAN, 0};
    }
    judge(row);
    return true;
}

/* Observed order between two rows of one method: error ~ dt^p. */
static double observed_order(const struct comparison *coarse, const struct comparison *fine)
{
    double ratio = log(coarse->run->settings.dt / fine->run->settings.dt);
    double order = log(coarse->errors.max / fine->errors.max) / ratio;
    return fine->run->stop == STOP_END && coarse->run->stop == STOP_END && isfinite(order) ? order : NAN;
}

bool study_compare_plan(const struct compare_request *request, double *steps, double *seconds, struct error *error)
{
    const bool by_tol = request->tols > 0;
    struct system system;
    *steps = *seconds = 0;
    if (!scene_bind(request->scene, &system, error)) {
        return false;
    }
    for (int c = 0; c < request->contenders; c++) {
        enum drag drag = request->contender[c].drag;
        if (!method_applies(request->contender[c].method, &system, &drag, error)) {
            return false;
        }
        for (int s = 0; s < (by_tol ? request->tols : request->dts); s++) {
            struct run_settings each = {.dt = request->dt[by_tol ? 0 : s], .drag = drag, .record = request->record};
            if (by_tol && (request->contender[c].method->flags & METHOD_ADAPTIVE)) {
                each.tol = request->tol[s];
            }
            struct plan plan;
            if (!plan_make(&system, request->contender[c].method, &each, request->duration, &plan, error)) {
                return false;
            }
            *steps += plan.steps;
            *seconds += plan.seconds;
        }
    }
    return true;
}

bool study_compare(const struct compare_request *request, struct comparison *rows, int *count, struct error *error)
{
    *count = 0;
    bool by_tol = request->tols > 0;
    int settings = by_tol ? request->tols : request->dts;
    /* All refusals before any work: a setting that cannot be run would otherwise waste the ones before it. */
    double steps, seconds;
    if (!study_compare_plan(request, &steps, &seconds, error)) {
        return false;
    }
    for (int c = 0; c < request->contenders; c++) {
        for (int s = 0; s < settings; s++) {
            bool adaptive = by_tol && (request->contender[c].method->flags & METHOD_ADAPTIVE);
            if (by_tol && !adaptive && s > 0) {
                break; /* tolerances mean nothing to a fixed-step method: one row */
            }
            struct comparison *row = &rows[*count];
            if (!compare_one(request, &request->contender[c], request->dt[by_tol ? 0 : s],
                             adaptive ? request->tol[s] : 0, row, error)) {
                return false;
            }
            if (cancelled(request->cancel)) {
                comparison_free(row);
                return error_set(error, ERROR_CANCELLED, "stopped: %d of %d finished", *count,
                                 request->contenders * settings);
            }
            if (!by_tol && s > 0) {
                row->order = observed_order(row - 1, row);
            }
            (*count)++;
        }
    }
    return true;
}

void comparison_free(struct comparison *row)
{
    run_destroy(row->run);
    row->run = NULL;
}
