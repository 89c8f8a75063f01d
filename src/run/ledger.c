/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energy ledger: work along the recorded rows, and what the energy balance misses. */
#include "private.h"

#include <math.h>

double system_energy(const struct system *system, const double *y)
{
    return system_kinetic(system, y) + system_potential(system, y);
}

/* Neumaier, Zeitschrift fuer Angewandte Mathematik und Mechanik 54 (1974), 39. */
static void sum_add(struct sum *sum, double x)
{
    double total = sum->high + x;
    sum->low += fabs(sum->high) >= fabs(x) ? sum->high - total + x : x - total + sum->high;
    sum->high = total;
}

/*
 * Work between two states: Gauss-Legendre with 4 points (Abramowitz and Stegun, table 25.4) on the power along the
 * quintic through position, velocity and acceleration at both ends, its velocity being the derivative of its position.
 */
static void add_interval(struct balance *balance, const struct system *system, double t0, const double *y0, double t1,
                         const double *y1)
{
    static const double node[4] = {-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                   0.861136311594052575};
    static const double weight[4] = {0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                                     0.347854845137453857};
    int half = system->n / 2;
    double h = t1 - t0, a0[LIMIT_VARIABLES], a1[LIMIT_VARIABLES], y[LIMIT_VARIABLES], work = 0, drag = 0;
    system_acceleration(system, t0, y0, a0);
    system_acceleration(system, t1, y1, a1);
    for (int k = 0; k < 4; k++) {
        double s = (1 + node[k]) / 2, r = 1 - s, rs = r * s;
        for (int i = 0; i < half; i++) {
            double q0 = y0[i], q1 = y1[i], v0 = h * y0[i + half], v1 = h * y1[i + half], b0 = h * h * a0[i],
                   b1 = h * h * a1[i];
            double rise = s * s * s * (10 + s * (6 * s - 15)); /* 0 at s = 0, 1 at s = 1 */
            y[i] = q0 + rise * (q1 - q0) + rs * (r * r * (1 + 3 * s) * v0 - s * s * (1 + 3 * r) * v1) +
                   rs * rs / 2 * (r * b0 + s * b1);
            y[i + half] =
                (30 * rs * rs * (q1 - q0) + r * r * (1 + s * (2 - 15 * s)) * v0 + s * s * (1 + r * (2 - 15 * r)) * v1 +
                 rs / 2 * (r * (2 - 5 * s) * b0 - s * (2 - 5 * r) * b1)) /
                h;
        }
        work += weight[k] / 2 * system_power(system, t0 + s * h, y);
        drag += weight[k] / 2 * system_dissipation(system, t0 + s * h, y);
    }
    sum_add(&balance->work, h * work);
    sum_add(&balance->drag, h * drag);
}

/* [J] brought by kicks in steps after - upto. */
static double kicks_between(const struct run_private *p, int64_t after, int64_t upto)
{
    size_t low = 0, high = p->kicks;
    double energy = 0;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (p->kick[middle].step <= after)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < p->kicks && p->kick[low].step <= upto; low++)
        energy += p->kick[low].energy;
    return energy;
}

void balance_extend(struct balance *balance, const struct run *run, size_t i, int64_t step, double t, const double *y)
{
    double before[LIMIT_VARIABLES], factor = run->private_state->factor;
    const double *state = trace_state(run->trace, i);
    for (int k = 0; k < run->system.n; k++)
        before[k] = state[k] * factor;
    const struct epoch *from = run_epoch(run, trace_step(run->trace, i)), *to = run_epoch(run, step);
    if (from != to) /* changing a parameter changes the energy of a state: that is work too */
        sum_add(&balance->work, system_energy(&to->system, before) - system_energy(&from->system, before));
    sum_add(&balance->work, kicks_between(run->private_state, trace_step(run->trace, i), step));
    double t0 = trace_time(run->trace, i);
    if (!to->system.conservative && t != t0)
        add_interval(balance, &to->system, t0, before, t, y);
}

void run_ledger(const struct run *run, struct ledger *ledger)
{
    *ledger = (struct ledger){NAN, NAN, NAN, NAN, NAN, false};
    if (run->system.order != 2)
        return;
    struct walk walk;
    double scale = 0, missing = 0, most = 0, unit = run->private_state->factor * run->private_state->factor;
    int64_t step = 0;
    walk_begin(&walk, run, NEED_WORK | NEED_RATIO);
    for (size_t i = 0; walk_next(&walk); i++) {
        const struct sample *sample = &walk.sample;
        double energy = system_energy(sample->system, sample->y);
        missing = energy - sample->initial - sample->work;
        most = fmax(most, fabs(missing));
        scale = fmax(scale, fabs(energy));
        ledger->initial = sample->initial / unit;
        ledger->final = energy / unit;
        ledger->work = sample->work / unit;
        int64_t next = trace_step(run->trace, i);
        ledger->approximate |= run->plan.ledger && next > step + 1;
        step = next;
    }
    if (walk.sample.initial != 0)
        scale = fabs(walk.sample.initial);
    if (scale > 0) {
        ledger->error = missing / scale;
        ledger->error_max = most / scale;
    }
}
