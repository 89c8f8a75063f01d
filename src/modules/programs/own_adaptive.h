/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steps whose size follows the error, for programs, as src/method/control/ takes them; no part of
 * hooke. The table of the method, `size` and derivatives() are the program's. */
#ifndef HOOKE_MODULES_PROGRAMS_OWN_ADAPTIVE_H
#define HOOKE_MODULES_PROGRAMS_OWN_ADAPTIVE_H

#define STAGES ((int)(sizeof(stage_time) / sizeof(stage_time[0])))
#define VARIABLES ((int)(sizeof(size) / sizeof(size[0])))

/* What is known on the way. */
struct adaptive {
    double h;           /* of the next try */
    double from, taken; /* where the last one began and how far it went, */
    double square;      /* and the square of its error by what is accepted */
    bool to_end, cut;   /* at the end of all, there or at a turning point */
    double last, aimed; /* the last accepted step, the square of its error by what is aimed at */
    double t_low;       /* what rounding took from t */
    int failures;       /* tries in a row that gave no number */
    bool rejected;      /* there was a try before that was too long */
    double origin, elapsed, excess[VARIABLES], scale[VARIABLES];
    double next[VARIABLES], slope[STAGES][VARIABLES];
};

static struct adaptive control = {0};

/* At the start of a step: the slope there, and the sizes along the run, which errors are parts of
 * (the mean of the fourth root, to the fourth power). */
static void adaptive_begin(double t, const double y[])
{
    if (control.h == 0) {
        control = (struct adaptive){.h = dt, .from = t, .origin = t};
        derivatives(t, y, control.slope[STAGES - 1]);
    }
    const double by = t - control.from;
    control.elapsed += by;
    const double rate = 1 / control.elapsed;
    for (int i = 0; i < VARIABLES; i++) {
        double mean = 1;
        if (fabs(y[i]) > size[i])
            control.excess[i] += by * (sqrt(sqrt(fabs(y[i]) / size[i])) - 1);
        if (control.excess[i] > 0)
            mean += control.excess[i] * rate;
        mean *= mean;
        mean *= mean;
        control.scale[i] = isfinite(size[i] * mean) ? size[i] * mean : size[i];
    }
    memcpy(control.slope[0], control.slope[STAGES - 1], sizeof control.slope[0]);
    control.from = t;
    control.failures = 0;
}

/* The state after a step of h; its error is the difference from the weights of lower order. */
static void adaptive_step(double h, const double y[])
{
    double sum[2] = {0, 0};
    const double *weight = stage_weight[STAGES - 1];
    for (int s = 1; s < STAGES; s++) {
        for (int i = 0; i < VARIABLES; i++) {
            double change = -0.0;
            for (int j = 0; j < s; j++)
                if (stage_weight[s][j] != 0)
                    change += h * stage_weight[s][j] * control.slope[j][i];
            control.next[i] = y[i] + change;
        }
        derivatives(control.from + stage_time[s] * h, control.next, control.slope[s]);
    }
    for (int i = 0; i < VARIABLES; i++) {
        double error = -0.0, largest = control.scale[i];
        for (int j = 0; j < STAGES; j++)
            if (weight[j] != weight_low[j])
                error += (weight[j] - weight_low[j]) * control.slope[j][i];
        largest = fabs(y[i]) > largest ? fabs(y[i]) : largest;
        largest = fabs(control.next[i]) > largest ? fabs(control.next[i]) : largest;
        sum[i % 2] += h * error / largest * (h * error / largest);
    }
    control.square = (sum[0] + sum[1]) * (1 / (VARIABLES * error_most * error_most));
    for (int i = 0; i < VARIABLES; i++)
        control.square = isfinite(control.next[i]) ? control.square : NAN;
    control.taken = h;
}

static void adaptive_try(double end, const double y[])
{
    const double rest = end - control.from;
    control.to_end = fabs(control.h) * 1.01 >= fabs(rest); /* no sliver remains */
    control.cut = control.to_end;
    adaptive_step(control.to_end ? rest : control.h, y);
}

/* Where the velocity turns in the step it is taken again, up to there. */
static void adaptive_turn(const double y[])
{
    const double h = control.taken, t = control.from,
                 near = fmax(1e-8, 0.1 * sqrt(error_most)) * fabs(h);
    if (!isfinite(control.square) ||
        !((y[1] < 0 && control.next[1] > 0) || (y[1] > 0 && control.next[1] < 0)))
        return;
    struct moment first = moment_at(t, 0, y), last = moment_at(t, h, control.next);
    double x = turning_time(&first, &last);
    if (fabs(x) <= near || fabs(h - x) <= near)
        return;
    control.to_end = false;
    control.cut = true;
    for (int i = 0; i < 12; i++) {
        adaptive_step(x, y);
        const struct moment here = moment_at(t, x, control.next);
        if (!isfinite(control.square) || fabs(here.v) <= near * fabs(here.a))
            return;
        *((here.v < 0) == (first.v < 0) ? &first : &last) = here;
        x = turning_time(&first, &last);
    }
}

/* By how much the next step is longer: a filter of the errors of the last two (Soderlind 2003). */
static void adaptive_plan(double aimed)
{
    const double half = -0.5 / error_order, ratio = fabs(control.taken / control.last);
    double by = 1;
    aimed = aimed > 1e-8 * 1e-8 ? aimed : 1e-8 * 1e-8;
    if (control.aimed == 0)
        by = fmin(factor_exp2(factor_log2(aimed) * half), 10);
    else if (aimed < 0.7 * 0.7 || aimed > 1.3 * 1.3 || ratio < 0.9)
        by = factor_limited(
            factor_log2(aimed) * (half * 0.8) +
            (factor_log2(control.aimed) * (half * -0.4) - factor_log2(ratio) * -0.5));
    if (control.rejected)
        by = fmin(by, 1);
    if (control.cut && !(fabs(control.taken * by) > fabs(control.h)))
        return; /* a step that was cut says nothing against a longer one */
    control.aimed = aimed;
    control.last = control.taken;
    control.h = control.taken * by;
}

/* 1: the step was good, t and y are at its end; 0: the next try is shorter; -1: there is none. */
static int adaptive_accepts(double *t, double end, double y[])
{
    const double aimed = control.square * (1 / (0.35 * 0.35));
    if (!(control.square <= 1)) {
        if (isfinite(aimed)) {
            control.h =
                control.taken * fmax(factor_exp2(factor_log2(aimed) * (-0.5 / error_order)), 0.2);
        } else {
            control.h = control.taken / 4;
            control.failures++;
        }
        control.rejected = true;
        const double least = 4 * (nextafter(fabs(*t), HUGE_VAL) - fabs(*t));
        return control.failures > 20 || !(fabs(control.h) >= least) ? -1 : 0;
    }
    adaptive_plan(aimed);
    const double by = control.taken + control.t_low, sum = *t + by, part = sum - *t;
    control.t_low = (*t - (sum - part)) + (by - part);
    *t = control.to_end || sum > end ? end : sum;
    memcpy(y, control.next, sizeof control.next);
    control.rejected = false;
    return 1;
}

/* The state at a time in the step that ended at t with y, by the method's own polynomial; false:
 * the step does not go so far. */
static bool adaptive_row(double t, const double y[], double at, double row[])
{
    const double near = 8 * 0x1p-52 * fmax(fabs(t), fabs(control.origin)), h = control.taken,
                 share = (at - control.from) / h, rest = 1 - share;
    const double *weight = stage_weight[STAGES - 1];
    if (at - t > near)
        return false;
    for (int i = 0; i < VARIABLES; i++) {
        double rise = -0.0, bend = -0.0;
        for (int j = 0; j < STAGES; j++) {
            if (weight[j] != 0)
                rise += weight[j] * control.slope[j][i];
            if (weight_inside[j] != 0)
                bend += weight_inside[j] * control.slope[j][i];
        }
        const double first = control.slope[0][i] - rise, last = rise - control.slope[STAGES - 1][i];
        row[i] = y[i];
        if (fabs(at - t) > near)
            row[i] -= h * (rest * (rise - share * (first + share * (last - first + rest * bend))));
    }
    return true;
}

#endif
