/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Derivatives of the values that events set by the state of the run; run_set_jump_slopes() needs
 * them for error estimates. */
#include <hooke/command/handler.h>

#include <float.h>
#include <math.h>

/* Finds the derivatives of a value by each variable and by time: reads it at two states for each
 * and takes central differences. Returns false if it cannot be read there. */
bool find_slopes(const struct parser *initial, struct run *run, const char *what,
                 enum quantity quantity, double *slope)
{
    /* relative increment, at which errors by rounding and by curvature are about equal */
    static const double difference = 6e-6;
    const double t = run->t;
    bool ok = true;
    for (int i = 0; i <= run->system.n; i++) {
        double *moving = i < run->system.n ? &run->y[i] : &run->t, value[2] = {0, 0};
        const double was = *moving,
                     natural =
                         i < run->system.n ? run->controller.scale[i] : fabs(run->controller.h),
                     increment = fmax(difference * fmax(fabs(was), natural), DBL_MIN);
        for (int side = 0; side < 2 && ok; side++) {
            struct parser parser = *initial;
            struct item item = {0};
            struct error ignored;
            *moving = side ? was + increment : was - increment;
            ok = read_value(&parser, what, quantity, &item, &ignored);
            value[side] = item.value.value;
        }
        *moving = was;
        slope[i] = (value[1] - value[0]) / (2 * increment);
    }
    run->t = t;
    return ok;
}

/* Returns true if a value that an event sets in an adaptive run depends on the state. */
bool value_depends(struct session *session, const struct parser *value)
{
    struct run *run = session_run(session);
    double slope[LIMIT_VARIABLES + 1];
    if (!session->execution.reacting || !run || !run->plan.adaptive ||
        !find_slopes(value, run, "value", QUANTITY_OTHER, slope))
        return false;
    bool depends = false;
    for (int i = 0; i <= run->system.n; i++)
        depends = depends || slope[i] != 0;
    return depends;
}

/* Marks the slopes of the jump by an event as unknown (NAN). */
void forget_jump_slopes(struct session *session)
{
    double slope[LIMIT_VARIABLES + 1];
    for (int i = 0; i <= LIMIT_VARIABLES; i++)
        slope[i] = NAN;
    run_set_jump_slopes(session_run(session), slope);
}
