/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Integrates a motion with its tangents in the same steps, and makes the tangents orthonormal (QR)
 * as soon as they become too long, short or parallel. */
#include "modules/dynamics/orbits/tangents.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/scene/typed.h>

/* Tangents are made orthonormal at this condition number or length. */
#define ORTHONORMAL_CONDITION_MAX 10.0
#define ESCAPE_SIZES 1e100       /* distance in sizes from which the motion does not come back */
#define STALLED_ESCAPE_SIZES 1e6 /* the same if it cannot continue, either */
/* Steps below this part of the remaining time do not get there, */
#define HOPELESS_STEP_FRACTION 1e-9
#define HOPELESS_STEPS_MAX 100 /* if this number of them follow each other. */
/* Jump relative to the rates, above what steps across a kink leave. */
#define RATE_JUMP_RELATIVE 1e-3

/* The tangents begin as unit vectors, in units of the variables' sizes. */
bool tangents_init(struct tangents *t, const struct scene *scene, int count,
                   const struct cancel *cancel, struct error *error)
{
    memset(t, 0, sizeof *t); /* a literal would be a copy of all its 440 KiB on the stack */
    t->method = method_find("dop853");
    if (!field_init(&t->field, scene, NULL, 0, error))
        return false;
    t->n = t->field.n;
    t->count = count > 0 && count < t->n ? count : t->n;
    t->field.cancel = cancel;
    enum drag drag = DRAG_DEFAULT;
    variation_of_tangents(&t->variation, &t->field.system, t->field.size, t->count);
    variation_add_trace(&t->variation);
    const struct system *whole = &t->variation.whole;
    memcpy(t->y, whole->start, (size_t)whole->n * sizeof *t->y);
    double *work = malloc(method_work_size(t->method, whole->n) * sizeof *work);
    if (!work || !method_applies(t->method, whole, &drag, error)) {
        free(work);
        return work ? false : error_memory(error);
    }
    t->step = (struct step){.system = whole, .drag = drag, .y = t->y, .work = work};
    t->controller = (struct controller){.tol = TANGENT_TOL};
    method_choose_kernels(t->method, &t->step, true);
    return true;
}

void tangents_free(struct tangents *t)
{
    free(t->step.work);
    t->step.work = NULL;
    field_free(&t->field);
}

int64_t tangents_evals(const struct tangents *t)
{
    return t->step.cost.evals;
}

/* Each vector loses its projections on the earlier ones twice, against rounding. */
void tangents_orthonormalise(int n, int count, double *column, double *diagonal)
{
    for (int j = 0; j < count; j++) {
        double *a = column + n * j, length = 0;
        for (int k = 0; k < 2 * j; k++) {
            const double *q = column + n * (k % j);
            double dot = 0;
            for (int i = 0; i < n; i++)
                dot += q[i] * a[i];
            for (int i = 0; i < n; i++)
                a[i] -= dot * q[i];
        }
        for (int i = 0; i < n; i++)
            length += a[i] * a[i];
        diagonal[j] = sqrt(length);
        for (int i = 0; i < n; i++)
            a[i] /= diagonal[j];
    }
}

/* Makes the tangents orthonormal and adds their growth to t->growth, if `wanted` or if their
 * condition or length exceeds ORTHONORMAL_CONDITION_MAX. */
static void tangents_straighten(struct tangents *t, bool wanted)
{
    const int n = t->n;
    double column[FIELD_VARIABLES * FIELD_VARIABLES], diagonal[FIELD_VARIABLES];
    for (int j = 0; j < t->count; j++)
        for (int i = 0; i < n; i++)
            column[n * j + i] = t->y[n * (j + 1) + i] / t->field.size[i];
    tangents_orthonormalise(n, t->count, column, diagonal);
    double least = HUGE_VAL, most = 0;
    for (int j = 0; j < t->count; j++) {
        least = fmin(least, diagonal[j]);
        most = fmax(most, diagonal[j]);
    }
    /* errors of steps are relative to lengths of 1 */
    if (!wanted && fmax(most / least, fmax(most, 1 / least)) < ORTHONORMAL_CONDITION_MAX)
        return;
    t->condition = fmax(t->condition, most / least);
    for (int j = 0; j < t->count; j++) {
        t->growth[j] += log(diagonal[j]);
        for (int i = 0; i < n; i++)
            t->y[n * (j + 1) + i] = column[n * j + i] * t->field.size[i];
    }
    double *divergence = &t->y[t->variation.whole.n - 1];
    t->divergence += *divergence;
    *divergence = 0;
    t->step.warm = false;
}

/* Returns true if the state is farther from 0 than `bound` sizes, or not finite. */
static bool is_beyond(const struct tangents *t, double bound)
{
    bool far = false;
    for (int i = 0; i < t->n; i++)
        far = far || !(fabs(t->y[i]) < bound * t->field.size[i]);
    return far;
}

/* Returns false if the motion has escaped. With linear forces tangents do not depend on the motion,
 * which then begins anew at 0. */
static bool has_not_escaped(struct tangents *t)
{
    const bool far = is_beyond(t, ESCAPE_SIZES);
    if (!far || !t->field.system.linear)
        return !far;
    memset(t->y, 0, (size_t)t->n * sizeof *t->y);
    t->step.warm = false;
    return true;
}

/* Returns true if the last step has crossed a switch at which the right-hand sides jump. branch
 * [switches] are the states of the switches before the step, and are updated. */
static bool has_jumped(const struct tangents *t, double *branch)
{
    const struct system *system = &t->variation.base;
    double now[LIMIT_SWITCHES], rate[2][LIMIT_VARIABLES], size = 0, jump = 0;
    const size_t bytes = (size_t)system->switches * sizeof *now;
    system_branches(system, t->step.t, t->y, now);
    if (memcmp(now, branch, bytes) == 0)
        return false;
    struct system frozen;
    for (int s = 0; s < 2; s++) {
        system_freeze(system, s == 0 ? branch : now, &frozen);
        system_derivative(&frozen, t->step.t, t->y, rate[s]);
    }
    for (int i = 0; i < t->n; i++) {
        size = fmax(size, fabs(rate[1][i]) / t->field.size[i]);
        jump = fmax(jump, fabs(rate[1][i] - rate[0][i]) / t->field.size[i]);
    }
    memcpy(branch, now, bytes);
    return jump > RATE_JUMP_RELATIVE * size;
}

/* Steps that become ever shorter end the integration as well. */
enum tangents_end tangents_advance(struct tangents *t, double t_begin, double span)
{
    const double end = t_begin + span;
    double branch[LIMIT_SWITCHES];
    const bool switches = t->variation.base.switches > 0;
    t->controller.t_low = 0;
    if (t->step.t != t_begin)
        t->step.warm = t->controller.sampling = false;
    t->step.t = t_begin;
    if (switches)
        system_branches(&t->variation.base, t_begin, t->y, branch);
    for (int hopeless = 0; t->step.t != end;) {
        const enum step_status status = method_adapt(t->method, &t->step, &t->controller, end);
        if (status != STEP_OK)
            return status == STEP_NONFINITE ? TANGENTS_LEAVE : TANGENTS_STALL;
        if (!has_not_escaped(t))
            return TANGENTS_LEAVE;
        if (switches && has_jumped(t, branch))
            return TANGENTS_JUMP;
        hopeless = fabs(t->step.h) < HOPELESS_STEP_FRACTION * span ? hopeless + 1 : 0;
        if (hopeless > HOPELESS_STEPS_MAX && is_beyond(t, STALLED_ESCAPE_SIZES))
            return TANGENTS_LEAVE;
        if (hopeless > HOPELESS_STEPS_MAX)
            return switches ? TANGENTS_JUMP : TANGENTS_STALL;
        tangents_straighten(t, t->step.t == end);
        if ((++t->steps & 63) == 0 && cancelled(t->field.cancel))
            return TANGENTS_CANCELLED;
    }
    t->elapsed += span;
    return TANGENTS_OK;
}

/* Angles that have gone beyond a full turn would lose digits. */
void tangents_unwind(struct tangents *t)
{
    for (int i = 0; i < t->n; i++) {
        const double turn = t->field.turn[i];
        if (turn > 0 && fabs(t->y[i]) > turn) {
            t->y[i] = remainder(t->y[i], turn);
            t->step.warm = false;
        }
    }
}
