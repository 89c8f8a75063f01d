/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One step of a linear multistep method, and its growth. Source: Hairer, Norsett, Wanner 1993,
 * Solving ODEs I, III.1.
 *
 * A step without enough previous steps of the same length h (the first ones, a last shorter one) is
 * taken by a one-step method of higher order, the starter: radau5 for backward differentiation,
 * because it copes with stiffness, dop853 for the others; in shorter substeps if it has no
 * solution. So the beginning limits neither the order nor the step.
 */
#include "method/step/step.h"

#include <complex.h>

/* The work array holds the number of previous values, their h, then these values [steps][n] (f, or
 * y for backward differentiation), the newest first; then two states and the memory of the starter
 * or the solver. */
enum { COUNT, H, HEAD };

/* Degree of the characteristic polynomial, and iterations for its roots. */
enum { DEGREE_MAX = 6, ITERATIONS = 100 };

/* Largest move of a root after which its error is below rounding, since convergence is cubic. */
static const double ROOT_MOVE_MIN = 1e-9;

/* Limits of the substeps of a start. */
static const double SUBSTEP_MIN = 1e-9; /* shortest step as a part of h */
enum { SUBSTEPS = 1000 };
/* Largest estimated error of a substep, relative to the values. */
static const double SUBSTEP_ERROR_MAX = 1e-4;

/* Returns the one-step method that takes the first steps. */
static const struct method *starter(const struct method *method)
{
    const char *name = method->multistep->values ? "radau5" : "dop853";
    return method_find(name);
}

size_t multistep_work(const struct method *method, int n)
{
    size_t start_step = method_work_size(starter(method), n), solve = newton_work(method, n);
    return HEAD + (size_t)(method->multistep->steps + 2) * (size_t)n +
           (start_step > solve ? start_step : solve);
}

/* Values that a step changes, by which it can be taken back. */
struct step_backup {
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES];
};

/* Stores state and low parts of the step in *backup. */
static void history_store(const struct step *step, struct step_backup *backup)
{
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    memcpy(backup->y, step->y, size);
    if (step->low)
        memcpy(backup->low, step->low, size);
}

/* Restores state and low parts of the step from *backup. */
static void history_restore(struct step *step, const struct step_backup *backup)
{
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    memcpy(step->y, backup->y, size);
    if (step->low)
        memcpy(step->low, backup->low, size);
}

/* Steps from t over h by the starter: in one step if it succeeds, else in a quarter of it, and so
 * on; after each success the next substep is twice as long. A substep succeeds if its estimated
 * error, relative to the values, is at most max, because a step far beyond the limit of stability
 * is finite but wrong. Returns STEP_OK, or why the last substep failed. */
static enum step_status substeps(const struct method *one_step, struct step *one, double t,
                                 double h, double max)
{
    const double limit = max * max * one->system->n;
    double done = 0, length = 1; /* shares of h */
    enum step_status failure = STEP_NO_SOLUTION;
    for (int i = 0; i < SUBSTEPS && done < 1 && length >= SUBSTEP_MIN; i++) {
        const double fraction = fmin(length, 1 - done);
        struct step_backup backup;
        history_store(one, &backup);
        one->t = t + done * h;
        one->h = fraction * h;
        one->warm = false;
        const enum step_status status = method_step(one_step, one);
        if (status == STEP_OK &&
            scaled_square(one->system->n, step_scale(one), one->error, backup.y, one->y) <= limit) {
            done = fraction < 1 - done ? done + fraction : 1;
            length = 2 * fraction;
            continue;
        }
        failure = status == STEP_OK ? STEP_NONFINITE : status;
        length = fraction / 4;
        history_restore(one, &backup);
    }
    return done < 1 ? failure : STEP_OK;
}

/* Takes a step by the starter, with accurate substeps if possible, else with any that have a
 * solution. On failure the state is unchanged. */
static enum step_status start_step(const struct method *method, struct step *step, double *work)
{
    double error[LIMIT_VARIABLES];
    struct step one = *step;
    struct step_backup backup;
    one.error = error;
    one.work = work;
    one.again = false;             /* it has evaluated nothing yet */
    if (method->multistep->values) /* differences of states know nothing of compensated sums */
        one.low = NULL;
    history_store(&one, &backup);
    enum step_status status = substeps(starter(method), &one, step->t, step->h, SUBSTEP_ERROR_MAX);
    if (status != STEP_OK) { /* no better start exists in as many steps */
        history_restore(&one, &backup);
        status = substeps(starter(method), &one, step->t, step->h, HUGE_VAL);
    }
    if (status != STEP_OK)
        history_restore(&one, &backup);
    step->cost = one.cost;
    return status;
}

/* Computes f [n] at t and y, and counts the evaluation. */
static void derivative(struct step *step, double t, const double *y, double *f)
{
    system_derivative(step->system, t, y, f);
    step->cost.evals++;
}

/* Returns sum_j w_j past_j[i] over the weights that are not zero, the newest first. */
static double weighted_past(const double *w, int count, const double *past, int n, int i)
{
    double sum = -0.0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0)
            sum += w[j] * past[j * n + i];
    return sum;
}

/* Takes a step and adds the newest value to the history; the starter takes it while the history is
 * too short. */
enum step_status multistep_step(const struct method *method, struct step *step)
{
    const struct multistep *multistep = method->multistep;
    const int n = step->system->n, steps = multistep->steps;
    const double h = step->h, *y = step->y;
    double *head = step->work, *past = head + HEAD, *z = past + steps * n, *next = z + n,
           *own = next + n;

    int count = step->warm && head[H] == h ? (int)head[COUNT] : 0;
    /* the oldest value is dropped */
    if (count == steps)
        count--;
    memmove(past + n, past, (size_t)(count * n) * sizeof *past);
    if (multistep->values)
        memcpy(past, y, (size_t)n * sizeof *y);
    else
        derivative(step, step->t, y, past);
    head[COUNT] = ++count;
    head[H] = h;
    if (count < steps)
        return start_step(method, step, own);

    if (multistep->values) { /* z = (- sum_j v_j y_n+1-j + h f(t + h, z)) / v_0 */
        const double *v = multistep->values;
        for (int i = 0; i < n; i++)
            next[i] = -weighted_past(v + 1, steps, past, n, i) / v[0];
        enum step_status status = implicit_euler_solve(step, step->t + h, h / v[0], next, z, own);
        return status == STEP_OK ? step_finish(step, z) : status;
    }
    for (int i = 0; i < n; i++)
        z[i] = h * weighted_past(multistep->predict, steps, past, n, i);
    if (multistep->correct) {
        for (int i = 0; i < n; i++)
            z[i] += y[i];
        derivative(step, step->t + h, z, next);
        for (int i = 0; i < n; i++)
            z[i] = h * (multistep->correct[0] * next[i] +
                        weighted_past(multistep->correct + 1, steps - 1, past, n, i));
    }
    return step_increase(step, z);
}

/* ---- growth per step, the largest root of the characteristic polynomial ---- */

/* Returns 1/z. */
static double complex reciprocal(double complex z)
{
    return conj(z) / (creal(z) * creal(z) + cimag(z) * cimag(z));
}

/* Returns the largest absolute value of the roots of p[0] mu^degree + … + p[degree], or NAN. Finds
 * all roots at once (Aberth 1973, Math. Comp. 27:339). */
static double largest_root(int degree, const double complex *p)
{
    double complex root[DEGREE_MAX];
    for (int i = 0; i < degree; i++)
        root[i] = cexp((2 * M_PI * i / degree + 0.4) * (double complex)_Complex_I);
    double move = 1;
    for (int iteration = 0; iteration < ITERATIONS && move > ROOT_MOVE_MIN; iteration++) {
        move = 0;
        for (int i = 0; i < degree; i++) {
            double complex value = p[0], slope = 0, push = 0;
            for (int j = 1; j <= degree; j++) {
                slope = slope * root[i] + value;
                value = value * root[i] + p[j];
            }
            for (int j = 0; j < degree; j++)
                if (j != i)
                    push += reciprocal(root[i] - root[j]);
            double complex step = value * reciprocal(slope - value * push);
            root[i] -= step;
            move = fmax(move, fabs(creal(step)) + fabs(cimag(step)));
        }
    }
    double largest = 0;
    for (int i = 0; i < degree; i++) {
        double size = cabs(root[i]);
        if (isnan(size))
            return NAN;
        largest = fmax(largest, size);
    }
    return largest;
}

/* Returns the growth per step on y' = lambda y, with z = h lambda (Hairer, Wanner 1996, Solving
 * ODEs II, V.1). */
static double growth_of(const struct multistep *multistep, double complex z)
{
    int steps = multistep->steps;
    double complex p[DEGREE_MAX + 1] = {0}; /* coefficients of y_n+1, y_n, … */
    if (multistep->values) {
        for (int j = 0; j <= steps; j++)
            p[j] = multistep->values[j];
        p[0] -= z;
    } else {
        const double *c = multistep->correct;
        double complex f = c ? z * c[0] : 1; /* factor of the predicted value */
        p[0] = 1;
        p[1] = c ? -1 - f : -1;
        for (int j = 0; j < steps; j++)
            p[1 + j] -= f * z * multistep->predict[j];
        for (int j = 1; c && j < steps; j++)
            p[j] -= z * c[j];
    }
    return largest_root(steps, p);
}

/* Returns the growth per step on an oscillation, by its two eigenvalues; a complex pair has the
 * same growth. */
double multistep_growth(const struct method *method, double x, double zeta,
                        enum stiffness_sign sign)
{
    /* product of the two eigenvalues, and the square of half their difference */
    const double product = stiffness_sign_value(sign),
                 split = product > 0 ? (zeta - 1) * (zeta + 1) : zeta * zeta - product;
    if (split < 0) /* a complex pair */
        return growth_of(method->multistep,
                         x * (-zeta + sqrt(-split) * (double complex)_Complex_I));
    const double fast = -copysign(fabs(zeta) + sqrt(split), zeta);
    return fmax(growth_of(method->multistep, x * fast),
                growth_of(method->multistep, fast != 0 ? x * (product / fast) : 0));
}
