/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study for programs and for the eye: records, a table to export, the log-log figure. */
#include <hooke/report.h>

#include <math.h>
#include <stdlib.h>

/* ---- records ---- */

static const char *status_of(const struct precision_point *point)
{
    return point->refused ? "refused" : point->stop == STOP_FULL ? "too-long" : stop_name(point->stop);
}

static void reply_point(const struct precision *precision, const struct precision_point *point, struct reply *reply)
{
    const struct precision_curve *curve = &precision->curve[point->curve];
    const struct study_errors *errors = &point->errors;
    reply_begin(reply, "precision");
    reply_string(reply, "method", curve->by.method->row.name);
    reply_real(reply, "dt", point->tol > 0 ? NAN : point->dt);
    reply_real(reply, "tol", point->tol > 0 ? point->tol : NAN);
    reply_int(reply, "steps", point->steps);
    reply_int(reply, "evals", point->cost.evals);
    reply_int(reply, "jacobians", point->cost.jacobians);
    reply_int(reply, "solves", point->cost.solves);
    reply_int(reply, "rejected", point->cost.rejected);
    reply_real(reply, "error", errors->max);
    reply_real(reply, "error_end", errors->end);
    reply_real(reply, "energy_error", errors->energy);
    reply_real(reply, "phase_error", errors->phase);
    reply_real(reply, "amplitude_error", errors->amplitude);
    reply_real(reply, "order", point->order);
    reply_real(reply, "time_min", point->time.minimum);
    reply_real(reply, "time_median", point->time.median);
    reply_real(reply, "ns_per_step", timing_step_ns(&point->time, point->steps));
    reply_string(reply, "path", path_name(point->path));
    reply_real(reply, "time_spread", point->time.spread);
    reply_int(reply, "samples", point->time.samples);
    reply_real(reply, "time_recording", point->recording);
    reply_string(reply, "status", status_of(point));
    reply_bool(reply, "below_reference", point->below);
    reply_bool(reply, "asymptotic", point->asymptotic);
    reply_real(reply, "reference_accuracy", precision->reference.accuracy);
    reply_bool(reply, "reference_kept", precision->reference.kept);
    reply_real(reply, "slope", curve->slope);
    reply_real(reply, "slope_expected", curve->expected);
    reply_bool(reply, "slope_differs", curve->differs);
    reply_real(reply, "evals_predicted",
               point->tol == 0 && precision_meaningful(point) ? precision_predict(precision, point->curve, errors->max)
                                                              : NAN);
    reply_end(reply);
}

/* The fastest for each error, all that tie with it, and what comes next. */
static void reply_fastest(const struct precision *precision, struct reply *reply)
{
    struct precision_cost *cost = calloc((size_t)precision->curves + 1, sizeof *cost);
    for (int level = 1; cost && level <= LEVELS; level++) {
        const double error = pow(10, -level);
        const int count = precision_fastest(precision, error, cost, NULL);
        int tied = 1;
        if (count == 0 || isnan(cost->minimum))
            continue;
        while (tied < count && cost[tied].tied)
            tied++;
        const bool follows = tied < count;
        reply_begin(reply, "fastest");
        reply_real(reply, "error", error);
        reply_string(reply, "method", precision->curve[cost->curve].by.method->row.name);
        reply_real(reply, "time_min", cost->minimum);
        reply_array(reply, "tied_with");
        for (int i = 1; i < tied; i++)
            reply_string(reply, NULL, precision->curve[cost[i].curve].by.method->row.name);
        reply_close(reply);
        reply_string(reply, "next",
                     follows ? precision->curve[cost[tied].curve].by.method->row.name : NULL);
        reply_real(reply, "next_times", follows ? cost[tied].minimum / cost->minimum : NAN);
        reply_end(reply);
    }
    free(cost);
}

void reply_precision(const struct precision *precision, struct reply *reply)
{
    if (reply->format == FORMAT_TEXT)
        return;
    for (int i = 0; i < precision->points; i++)
        reply_point(precision, &precision->point[i], reply);
    reply_fastest(precision, reply);
}

/* ---- table ---- */

static double count_value(int64_t count)
{
    return (double)count;
}

bool precision_table(const struct precision *precision, struct export *export, struct error *error)
{
    enum {
        DT,
        TOL,
        STEPS,
        EVALS,
        JACOBIANS,
        SOLVES,
        REJECTED,
        ERROR,
        END,
        ENERGY,
        PHASE,
        AMPLITUDE,
        ORDER,
        MINIMUM,
        MEDIAN,
        NS_PER_STEP,
        COLUMNS
    };
    static const char *const names[COLUMNS] = {
        "dt",        "tol",          "steps",       "evals",           "jacobians", "solves",   "rejected",   "error",
        "error_end", "energy_error", "phase_error", "amplitude_error", "order",     "time_min", "time_median", "ns_per_step"};
    static const char *const units[COLUMNS] = {[DT] = "s", [PHASE] = "rad", [MINIMUM] = "s", [MEDIAN] = "s"};
    const size_t n = (size_t)precision->points;
    struct arena *arena = export->arena;
    const char **method = arena_array(arena, n, sizeof *method), **status = arena_array(arena, n, sizeof *status);
    const char **path = arena_array(arena, n, sizeof *path);
    struct table_column *out = arena_array(arena, COLUMNS + 3, sizeof *out);
    double *value[COLUMNS];
    bool ok = method && status && path && out;
    for (int c = 0; c < COLUMNS; c++)
        ok = (value[c] = arena_array(arena, n, sizeof *value[c])) && ok;
    if (!ok)
        return error_memory(error);
    for (size_t i = 0; i < n; i++) {
        const struct precision_point *p = &precision->point[i];
        const double row[COLUMNS] = {p->tol > 0 ? NAN : p->dt,
                                     p->tol > 0 ? p->tol : NAN,
                                     count_value(p->steps),
                                     count_value(p->cost.evals),
                                     count_value(p->cost.jacobians),
                                     count_value(p->cost.solves),
                                     count_value(p->cost.rejected),
                                     p->errors.max,
                                     p->errors.end,
                                     p->errors.energy,
                                     p->errors.phase,
                                     p->errors.amplitude,
                                     p->order,
                                     p->time.minimum,
                                     p->time.median,
                                     timing_step_ns(&p->time, p->steps)};
        for (int c = 0; c < COLUMNS; c++)
            value[c][i] = row[c];
        method[i] = precision->curve[p->curve].by.method->row.name;
        path[i] = path_name(p->path);
        status[i] = status_of(p);
    }
    out[0] = (struct table_column){.name = "method", .unit = "", .text = method};
    for (int c = 0; c < COLUMNS; c++)
        out[c + 1] = (struct table_column){.name = names[c], .unit = units[c] ? units[c] : "", .value = value[c]};
    out[COLUMNS + 1] = (struct table_column){.name = "path", .unit = "", .text = path};
    out[COLUMNS + 2] = (struct table_column){.name = "status", .unit = "", .text = status};
    export->table = (struct table){.column = out, .columns = COLUMNS + 3, .rows = n};
    return true;
}
