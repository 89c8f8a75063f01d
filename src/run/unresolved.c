/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds forces that change in time faster than fixed steps resolve: run_force_unresolved(). Where a
 * force repeats between the points of a step, every stage sees the same value, and the run is that
 * of another force (Shannon 1949, Proc. IRE 37:10). Pulses in single steps are found by comparing
 * the mean force in a step with what the method's quadrature rule sees of it. */
#include <hooke/run/unresolved.h>
#include "run/private.h"

#include <math.h>

/* Steps at which the force is compared; numbers of shorter steps that are tried for a force that is
 * too fast and for a pulse. */
enum { LOOKS = 64, SHORTER = 40, SHORTER_PULSE = 7 };
/* Factor from one step to the next that is tried; no simple fraction, so that it is unlikely to be
 * a multiple of the force's period. */
static const double SHORTER_BY = 0.37;

/* Share of the sum of squared differences above which the largest of them is taken for a pulse: a
 * force that repeats differs at all looks. */
static const double few_looks_share = 0.2;

/* Returns the sum over all rates of the squared difference of two derivatives, in units of their
 * sizes [n]. */
static double difference_squared(const struct system *system, const double *size, const double *a,
                                 const double *b)
{
    double sum = 0;
    for (int i = 0; i < system->n; i++)
        if (size[i] > 0)
            sum += (a[i] - b[i]) / size[i] * ((a[i] - b[i]) / size[i]);
    return sum;
}

/* Evaluates the derivatives of one state y at the beginning, middle and end of the step from t.
 * Fills parabola [n] with the value at theta of the parabola through them, and inside [n] with the
 * derivatives at theta; they are equal for a force that the step resolves. */
static void look_at_step(const struct system *system, const double *y, double t, double h,
                         double theta, double *parabola, double *inside)
{
    double f[3][LIMIT_VARIABLES];
    for (int k = 0; k < 3; k++)
        system_derivative(system, t + k * h / 2, y, f[k]);
    system_derivative(system, t + theta * h, y, inside);
    for (int i = 0; i < system->n; i++)
        parabola[i] = f[0][i] * (1 - theta) * (1 - 2 * theta) + f[1][i] * 4 * theta * (1 - theta) +
                      f[2][i] * theta * (2 * theta - 1);
}

/* Returns true if steps of h, at LOOKS points between t0 and the run's end, miss more than this
 * share of how the force changes in time. */
static bool misses_changes(const struct run *run, double h, double share)
{
    const struct system *system = &run->system;
    const double steps = floor((run->t - system->t0) / h);
    double parabola[LIMIT_VARIABLES], inside[2][LIMIT_VARIABLES], size[LIMIT_VARIABLES] = {0};
    double missed = 0, varies = 0, most = 0;
    /* The first pass finds the sizes. */
    for (int k = 0; k < 2 * LOOKS; k++) {
        /* Irrational multiples spread over the run and over the step. */
        const int look = k % LOOKS, now = k & 1;
        const double t = system->t0 + floor(fmod((look + 0.5) * 0.618033988749895, 1) * steps) * h,
                     theta = fmod((look + 0.5) * 0.754877666246693, 1);
        look_at_step(system, system->start, t, h, theta, parabola, inside[now]);
        for (int i = 0; i < system->n; i++) {
            if (!isfinite(inside[now][i]) || !isfinite(parabola[i]))
                return false;
            size[i] = fmax(size[i], fmax(fabs(inside[now][i]), fabs(parabola[i])));
        }
        if (k < LOOKS)
            continue;
        const double difference = difference_squared(system, size, inside[now], parabola);
        missed += difference;
        most = fmax(most, difference);
        varies += difference_squared(system, size, inside[now], inside[!now]);
    }
    /* Two independent values differ by sqrt 2 times what each varies by. */
    return varies > LOOKS * FORCE_VARIES_MIN * FORCE_VARIES_MIN &&
           missed > share * share * varies / 2 && most <= few_looks_share * missed;
}

/* ---- pulses in single steps ---- */

enum {
    PROBES_MIN = 6, /* points in a step at which a force is evaluated, beside those of the rule */
    PROBES_MAX = 62,
    PROBED_EVALS_MIN = 8192, /* evaluations for all steps that are examined, at least, */
    PROBED_EVALS_SHARE = 16  /* or one for this many evaluations of the run */
};

/* Share of a variable's size above which the force that a step misses counts as a pulse. */
static const double step_missed_share = 0.02;

/* Points and weights of rules that see a step as methods of low and of high order do. */
struct step_rule {
    double point[3], weight[3];
};
static const struct step_rule simpson = {{0, 0.5, 1}, {1. / 6, 4. / 6, 1. / 6}};
static const struct step_rule gauss = {{0.1127016653792583, 0.5, 0.8872983346207417},
                                       {5. / 18, 8. / 18, 5. / 18}};

/* Adds to missed [n] the change of the state by the force in the step from t, found by the mean
 * over `probes` points, minus the change that the rule gives. The state is that of the start, so
 * only changes in time are seen. */
static void add_missed(const struct system *system, double t, double h, int probes,
                       const struct step_rule *rule, double *missed)
{
    double f[LIMIT_VARIABLES];
    for (int k = 0; k < probes + 3; k++) {
        const int seen = k - probes;
        const double theta = seen < 0 ? (k + 0.5) / probes : rule->point[seen];
        const double weight = seen < 0 ? 1. / probes : -rule->weight[seen];
        system_derivative(system, t + theta * h, system->start, f);
        for (int i = 0; i < system->n; i++)
            missed[i] += weight * h * f[i];
    }
}

/* Returns the change of the state that `count` steps of h from t on miss together, as a share of
 * the variable's size; the largest one of all variables. */
static double missed_share(const struct system *system, const double *size, double t, double h,
                           int64_t count, int probes, const struct step_rule *rule)
{
    double missed[LIMIT_VARIABLES] = {0}, most = 0;
    for (int64_t k = 0; k < count; k++)
        add_missed(system, t + (double)k * h, h, probes, rule, missed);
    for (int i = 0; i < system->n; i++)
        most = fmax(most, fabs(missed[i]) / size[i]);
    return most;
}

/* Returns true if a typed force depends on time. */
bool run_force_may_pulse(const struct system *system)
{
    bool has = false;
    for (int i = 0; i < system->terms; i++)
        has = has || (!system->term[i].row->bind && system->term[i].row->flags & TERM_TIME);
    return has;
}

bool run_force_is_slow(const struct system *system, double h)
{
    const struct oscillator *o = &system->oscillator;
    return system->autonomous ||
           (o->drive != 0 && fabs(o->omega * h) < 1 && !run_force_may_pulse(system));
}

/* Returns how many steps are searched for pulses, and sets the number of points in each. */
int64_t run_probed_steps(const struct system *system, int64_t steps, int64_t evals, int *probes)
{
    const int64_t share = evals / PROBED_EVALS_SHARE,
                  all = share > PROBED_EVALS_MIN ? share : PROBED_EVALS_MIN,
                  most = all / (PROBES_MIN + 2);
    const int64_t looks = steps < most ? steps : most;
    *probes = PROBES_MIN;
    if (looks <= 0 || !run_force_may_pulse(system))
        return 0;
    const int64_t each = all / looks - 2;
    *probes = each < PROBES_MAX ? (int)each : PROBES_MAX;
    return looks;
}

/* Returns true if the step of length h at t, alone and together with its neighbours, misses much of
 * the force in it, by Gauss's rule or, for methods up to order 4, also by Simpson's. The neighbours
 * are included because they may compensate the error. `size` holds the sizes of the variables, and
 * `probes` is the number of samples per step. */
static bool misses_pulse(const struct run *run, const double *size, double t, double h, int probes)
{
    const struct system *system = &run->system;
    const bool low = run->method->order <= 4;
    const struct step_rule *rule[] = {&gauss, &simpson};
    bool misses = false;
    for (int k = 0; k < 1 + low && !misses; k++)
        misses = missed_share(system, size, t, h, 1, probes, rule[k]) > step_missed_share &&
                 missed_share(system, size, t - h, h, 3, probes, rule[k]) > step_missed_share;
    return misses;
}

/* Returns the time [s] from which on the run has not been searched for pulses: the end of the last
 * search, or the present time if the run has been taken back since. */
static double probed_until(const struct run *run)
{
    const double start = run->system.t0, probed = run->private_state->probed;
    return fabs(probed - start) < fabs(run->t - start) ? probed : run->t;
}

/* Returns true if one of the steps that are examined misses a pulse; then sets *dt to a step that
 * resolves it, or leaves NAN if none was found. */
static bool step_misses_pulse(const struct run *run, double h, double *dt)
{
    const struct system *system = &run->system;
    const double begin = probed_until(run), steps = floor((run->t - begin) / h + 1e-6);
    int probes;
    const int64_t looks = run_probed_steps(system, (int64_t)steps, run->cost.evals, &probes);
    double size[LIMIT_VARIABLES], t = begin;
    int64_t look = 0;
    run->private_state->probed = run->t;
    for (int i = 0; i < system->n; i++)
        size[i] = fmax(system->scale[i], fabs(run->y[i]));
    for (; look < looks; look++) {
        t = begin + floor(((double)look + 0.5) * steps / (double)looks) * h;
        if (misses_pulse(run, size, t, h, probes))
            break;
    }
    for (int k = 1; look < looks && k <= SHORTER_PULSE && isnan(*dt); k++) {
        const double pieces = ceil(pow(1 / SHORTER_BY, k));
        if (missed_share(system, size, t, h / pieces, (int64_t)pieces, PROBES_MIN, &simpson) <
            step_missed_share / 10)
            *dt = fabs(h) / pieces;
    }
    return look < looks;
}

/* Returns true if the force changes faster than the steps; *dt is a step that resolves it, or
 * NAN. */
bool run_force_unresolved(const struct run *run, double *dt)
{
    const struct system *system = &run->system;
    const double h = copysign(run->settings.dt, run->t - system->t0);
    *dt = NAN;
    if (run->plan.adaptive || run->steps < 1 || run_force_is_slow(system, h) ||
        run->method->flags & METHOD_EXACT || method_meets_switches(run->method, system))
        return false;
    if (!misses_changes(run, h, FORCE_MISSED_SHARE))
        return step_misses_pulse(run, h, dt);
    for (int k = 1; k <= SHORTER && isnan(*dt); k++)
        if (!misses_changes(run, h * pow(SHORTER_BY, k), FORCE_MISSED_SHARE / 10))
            *dt = fabs(h) * pow(SHORTER_BY, k);
    return true;
}
