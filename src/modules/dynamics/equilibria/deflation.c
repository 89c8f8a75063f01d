/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Newton's method that does not go where it has been (Farrell, Birkisson, Funke 2015), with steps
 * that the natural test of Deuflhard (2004, 3.3) allows. */
#include <math.h>
#include <string.h>

#include "modules/dynamics/orbits/forms.h"

#define STEPS 100
#define SHORTEST 1e-3 /* of a step: then it is taken all the same */
#define LONGEST 0.5   /* of a range, a step */
#define ARRIVED 1e-13

struct search_from {
    const struct system *bounded;
    const double *width;
    const struct solution *known;
    int count;
};

static double longest(const struct search_from *from, const double *step)
{
    double most = 0;
    for (int i = 0; i < from->bounded->n; i++)
        most = fmax(most, fabs(step[i]) / from->width[i]);
    return most;
}

/* d ln M . step, M = product of (1 + 1/|y - known|^2) in units of the ranges. */
static double slope_along(const struct search_from *from, const double *y, const double *step)
{
    double sum = 0;
    for (int k = 0; k < from->count; k++) {
        double square = 0, along = 0;
        for (int i = 0; i < from->bounded->n; i++) {
            const double apart = (y[i] - from->known[k].state[i]) / from->width[i];
            square += apart * apart;
            along += apart * step[i] / from->width[i];
        }
        sum -= 2 * along / (square * (square + 1));
    }
    return sum;
}

/* How much longer the next correction, of the same Jacobian [n][n], is made by a step. */
static double growth(const struct search_from *from, const double *jacobian, const double *y,
                     const double *step, double part)
{
    const int n = from->bounded->n;
    double next[FIELD_VARIABLES], rate[FIELD_VARIABLES], copy[FIELD_VARIABLES * FIELD_VARIABLES];
    memcpy(copy, jacobian, (size_t)(n * n) * sizeof *copy);
    for (int i = 0; i < n; i++)
        next[i] = y[i] + part * step[i];
    mean_field(from->bounded, next, rate, NULL);
    return matrix_solve(n, copy, rate) ? longest(from, rate) / longest(from, step) : NAN;
}

bool deflated_newton(const struct system *bounded, const double *width,
                     const struct solution *known, int count, double *y)
{
    const struct search_from from = {bounded, width, known, count};
    const int n = bounded->n;
    for (int k = 0; k < STEPS; k++) {
        double step[FIELD_VARIABLES], jacobian[FIELD_VARIABLES * FIELD_VARIABLES],
            copy[FIELD_VARIABLES * FIELD_VARIABLES];
        mean_field(bounded, y, step, jacobian);
        memcpy(copy, jacobian, sizeof copy);
        if (!matrix_solve(n, copy, step))
            return false;
        for (int i = 0; i < n; i++)
            step[i] = -step[i];
        const double size = longest(&from, step), turned = 1 / (1 - slope_along(&from, y, step));
        double part = fmin(1, LONGEST / size);
        if (size < ARRIVED)
            return true;
        while (part > SHORTEST && !(growth(&from, jacobian, y, step, part) <= 1 - part / 4))
            part /= 2;
        part = count > 0 ? fmin(fmax(part * turned, -LONGEST / size), LONGEST / size) : part;
        if (!isfinite(part))
            return false;
        for (int i = 0; i < n; i++)
            y[i] += part * step[i];
    }
    return false;
}
