/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows motions from one check to the next: several at once in lanes by rk4, or one by one with
 * adaptive steps. */
#include "modules/dynamics/basins/basins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/numeric.h>

#define ALONE_TOL 1e-9 /* tolerance of adaptive steps */
#define STEPS_MIN 16   /* smallest and largest number of steps of rk4 between checks */
#define STEPS_MAX 2048
#define CANCEL_CHECK_STEPS 256 /* number of steps between two looks at Ctrl-C */
/* Largest change of the end, in sizes, if the number of steps is doubled: for nine starts out of
 * ten, and for any start. */
#define CHANGE_TYPICAL 1e-5
#define CHANGE_WORST 1e-2

struct stepper {
    struct vector_field field; /* integrates with adaptive steps */
    struct lanes *lanes;       /* NULL if the scene does not fit into lanes */
    struct system *system;     /* [LANE_COUNT] one for each lane, with its start */
    const struct method *method;
    enum drag drag;
    int n, steps;
    double strobe;
};

/* Sets up lanes if the walk has a number of steps and the scene fits, else only the field for
 * adaptive steps. */
struct stepper *stepper_create(const struct basin_walk *walk)
{
    struct stepper *s = calloc(1, sizeof *s);
    struct error ignored = {0};
    if (!s)
        return NULL;
    s->field = walk->field;
    s->field.variation = NULL;
    s->field.tol = ALONE_TOL;
    s->n = walk->n;
    s->strobe = walk->strobe;
    s->method = method_find("rk4");
    s->steps = walk->steps;
    const struct system *system = &walk->field.system;
    if (s->steps == 0 || !method_applies(s->method, system, &s->drag, &ignored) ||
        !lanes_fit(s->method, system, s->drag, s->strobe / s->steps))
        return s;
    s->lanes = lanes_create();
    s->system = malloc(LANE_COUNT * sizeof *s->system);
    for (int i = 0; s->system && i < LANE_COUNT; i++)
        s->system[i] = *system;
    if (s->lanes && s->system)
        return s;
    stepper_free(s);
    return NULL;
}

void stepper_free(struct stepper *s)
{
    if (s && s->lanes)
        lanes_destroy(s->lanes);
    if (s) {
        free(s->system);
        field_free(&s->field);
    }
    free(s);
}

/* Advances the motions to the next check, all in lanes (then count <= LANE_COUNT; idle lanes repeat
 * the first motion), or one after another with adaptive steps. Without lanes, the first variable of
 * a motion that cannot be followed becomes NAN, which walker_check() counts as an escape. If
 * cancelled, the motions may end before the check. */
void stepper_advance(struct stepper *s, struct walker *walker, int count)
{
    const size_t bytes = (size_t)s->n * sizeof(double);
    double end[LIMIT_VARIABLES];
    if (!s->lanes || !lanes_begin(s->lanes, s->method, s->drag, s->system, s->strobe / s->steps)) {
        for (int i = 0; i < count; i++)
            if (field_flow(&s->field, s->field.system.t0, walker[i].y, s->strobe, end, NULL))
                memcpy(walker[i].y, end, bytes);
            else
                walker[i].y[0] = NAN;
        return;
    }
    for (int i = 0; i < LANE_COUNT; i++) {
        memcpy(s->system[i].start, walker[i < count ? i : 0].y, bytes);
        lanes_set(s->lanes, i, &s->system[i]);
    }
    for (int done = 0; done < s->steps && !cancelled(s->field.cancel); done += CANCEL_CHECK_STEPS)
        lanes_march(s->lanes,
                    s->steps - done < CANCEL_CHECK_STEPS ? s->steps - done : CANCEL_CHECK_STEPS,
                    NULL);
    for (int i = 0; i < count; i++) {
        lanes_state(s->lanes, i, end);
        memcpy(walker[i].y, end, bytes);
    }
}

/* Sets difference[i] to the change of the end of start i, in sizes, if a check takes twice as many
 * steps as walk->steps, which is the same afterwards; HUGE_VAL if only the coarse motion diverges.
 * `count` is at most LANE_COUNT. Returns false if out of memory or if the system cannot go in
 * lanes. */
static bool step_differences(struct basin_walk *walk, double (*start)[FIELD_VARIABLES], int count,
                             double *difference)
{
    struct walker *walker = calloc(2 * LANE_COUNT, sizeof *walker);
    bool fine = walker != NULL;
    for (int pass = 0; fine && pass < 2; pass++, walk->steps *= 2) {
        struct stepper *stepper = stepper_create(walk);
        fine = stepper && stepper->lanes;
        for (int i = 0; i < count; i++)
            memcpy(walker[pass * LANE_COUNT + i].y, start[i], sizeof start[i]);
        if (fine)
            stepper_advance(stepper, walker + pass * LANE_COUNT, count);
        stepper_free(stepper);
    }
    walk->steps /= 4;
    for (int i = 0; fine && i < count; i++) {
        difference[i] = 0;
        for (int k = 0; k < walk->n; k++) {
            const double a = walker[i].y[k], b = walker[LANE_COUNT + i].y[k];
            /* A motion that escapes does so with either number of steps. */
            const double change = fabs(a - b) / fmax(walk->field.size[k], 1e-2 * fabs(b));
            if (isfinite(b))
                difference[i] = fmax(difference[i], isfinite(a) ? change : HUGE_VAL);
        }
    }
    free(walker);
    return fine;
}

/* Doubles the number of steps until doubling it once more changes the ends little enough: all by
 * less than CHANGE_WORST sizes, and nine of ten by less than CHANGE_TYPICAL. Sets walk->steps, to 0
 * (adaptive steps) if STEPS_MAX is reached or there are no lanes. */
int stepper_choose(struct basin_walk *walk, double (*start)[FIELD_VARIABLES], int count)
{
    double difference[LANE_COUNT];
    for (walk->steps = STEPS_MIN; walk->steps < STEPS_MAX; walk->steps *= 2) {
        if (!step_differences(walk, start, count, difference))
            break;
        double worst = 0;
        for (int i = 0; i < count; i++)
            worst = fmax(worst, difference[i]);
        if (worst < CHANGE_WORST &&
            values_quantile(difference, (size_t)count, 0.9) < CHANGE_TYPICAL)
            return walk->steps;
    }
    return walk->steps = 0;
}
