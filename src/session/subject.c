/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The scene that a run or a recording is measured against, its period, and measurements that are
 * kept. */

#include <hooke/run.h>
#include <hooke/base/cancel.h>
#include <hooke/session/subject.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <stdlib.h>

/* Returns the scene of a run; for a recording the present one if its spring was described, else
 * NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run)
{
    const struct scene *scene = &session->setup.scene;
    if (run)
        return &run->scene;
    return is_oscillator(scene) && (param_chosen(scene, "k") || param_chosen(scene, "m")) ? scene
                                                                                          : NULL;
}

double derived_value(const struct scene *scene, const char *name)
{
    const struct row *row = scene ? catalog_find(scene_derived(scene), text_of(name)) : NULL;
    return row ? ((const struct derived_row *)(const void *)row)->value(scene).value : NAN;
}

/* Returns the period [s] of the scene by the first of these derived quantities that it has and that
 * is finite, or NAN. */
double scene_period(const struct scene *scene)
{
    static const char *const names[] = {"T_d", "period", "T0"};
    double period = NAN;
    for (size_t i = 0; i < COUNT_OF(names) && !isfinite(period); i++)
        period = derived_value(scene, names[i]);
    return period;
}

/* Returns the period [s] of a pendulum that starts at rest from that amplitude [rad]; NAN for other
 * scenes. */
double scene_period_at(const struct scene *scene, double amplitude)
{
    const int angle = scene ? scene_param(scene, "theta0") : -1;
    const int rate = scene ? scene_param(scene, "rate0") : -1;
    if (angle < 0 || rate < 0)
        return NAN;
    struct scene turned = *scene;
    turned.value[angle] = amplitude;
    turned.value[rate] = 0;
    return derived_value(&turned, "period");
}

/* Adds a measurement, of which the oldest is dropped if there are too many. Returns false with the
 * error set. */
bool session_add_measurement(struct session *session, const char *name, const char *subject,
                             struct measured value, enum quantity unit, double periods,
                             struct error *error)
{
    /* the capacity is a power of two, and doubles when the list is full */
    if (session->measurements < LIMIT_MEASUREMENTS &&
        (session->measurements & (session->measurements - 1)) == 0) {
        const size_t capacity = session->measurements ? 2 * (size_t)session->measurements : 1;
        struct measurement *larger = realloc(session->measurement, capacity * sizeof *larger);
        if (!larger)
            return error_memory(error);
        session->measurement = larger;
    }
    if (session->measurements >= LIMIT_MEASUREMENTS) {
        const int gone = session->measurements - LIMIT_MEASUREMENTS + 1;
        session->measurements -= gone;
        memmove(session->measurement, session->measurement + gone,
                (size_t)session->measurements * sizeof *session->measurement);
    }
    struct measurement *row = &session->measurement[session->measurements++];
    *row = (struct measurement){.value = value,
                                .unit = unit,
                                .periods = periods,
                                .t = NAN,
                                .statement = session->history.count};
    snprintf(row->quantity, sizeof row->quantity, "%s", name);
    snprintf(row->source, sizeof row->source, "%s", subject);
    char result[LIMIT_NAME + 1];
    snprintf(result, sizeof result, "measured_%s", name);
    session_set_result(session, result, value, unit);
    return true;
}

/* Copies the rows in [t_begin, t_end] where velocity (or energy) is known. Returns false if out of
 * memory. */
bool motion_series(const struct data_motion *motion, bool energy, double t_begin, double t_end,
                   struct arena *arena, struct series *series, struct error *error)
{
    const double *value = energy ? motion->energy : motion->v;
    double *t = arena_array(arena, motion->n, sizeof *t),
           *y = arena_array(arena, motion->n, sizeof *y);
    size_t n = 0;
    if (!t || !y)
        return error_memory(error);
    for (size_t i = 0; i < motion->n && !cancelled_at(motion->cancel, i); i++)
        if (!isnan(value[i]) && motion->t[i] >= t_begin && motion->t[i] <= t_end) {
            t[n] = motion->t[i];
            y[n++] = value[i];
        }
    *series =
        (struct series){t, y, n, energy ? QUANTITY_ENERGY : motion->quantity, motion->cancel, 0};
    return true;
}
