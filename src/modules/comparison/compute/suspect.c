/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compares the finest runs of several methods with the reference, to detect that it is wrong. */
#include "modules/comparison/compute/suspect.h"

#include <stdlib.h>
#include <string.h>

/* Runs that differ by more than this many times their known errors contradict each other. */
#define CONTRADICTION_FACTOR 100

/* Allocates room for `max` methods. */
bool witnesses_init(struct witnesses *witnesses, const struct system *system, int max)
{
    *witnesses = (struct witnesses){.size = (size_t)STUDY_TIMES * (size_t)system->n};
    witnesses->one = calloc((size_t)max + 1, sizeof *witnesses->one);
    witnesses->grid = calloc(((size_t)max + 1) * witnesses->size, sizeof *witnesses->grid);
    for (int i = 0; i < max && witnesses->one && witnesses->grid; i++)
        witnesses->one[i] =
            (struct witness){.grid = witnesses->grid + (size_t)i * witnesses->size, .moved = NAN};
    witnesses->count = max;
    if (witnesses->one && witnesses->grid)
        return true;
    witnesses_free(witnesses);
    return false;
}

void witnesses_free(struct witnesses *witnesses)
{
    free(witnesses->one);
    free(witnesses->grid);
    *witnesses = (struct witnesses){0};
}

/* Returns the largest distance over the grid, in amplitudes, at times that both solutions have
 * reached. */
static double grid_distance_max(const struct reference *reference, const double *a, const double *b)
{
    const int n = reference->n;
    double max = 0;
    for (int k = 0; k < STUDY_TIMES; k++)
        if (!isnan(a[k * n]) && !isnan(b[k * n]))
            max = fmax(max, grid_distance(reference, a + k * n, b + k * n));
    return max;
}

/* Stores a run of method i if it is finer than the one stored before, which it replaces. */
void witness_store(struct witnesses *witnesses, int i, const struct reference *reference,
                   const struct method *method, int64_t steps, const double *grid)
{
    struct witness *w = &witnesses->one[i];
    w->moved = w->method ? grid_distance_max(reference, w->grid, grid) : NAN;
    w->method = method;
    w->step = fabs(reference->span) / (double)steps;
    memcpy(w->grid, grid, witnesses->size * sizeof *grid);
}

/* Returns true if a witness has a known error and steps short enough to see the shortest burst that
 * the reference has found. */
static bool is_usable_witness(const struct witness *w, const struct reference *reference)
{
    return w->method && !isnan(w->moved) &&
           !(reference->shortest > 0 && w->step > reference->shortest);
}

/* Returns true if two witnesses contradict the reference. */
bool reference_suspect(struct reference *reference, const struct witnesses *witnesses, double *step)
{
    bool found = false;
    reference->dissenting_method[0] = reference->dissenting_method[1] = NULL;
    for (int i = 0; i < witnesses->count && !reference->exact; i++)
        for (int j = 0; j < i; j++) {
            const struct witness *a = &witnesses->one[j], *b = &witnesses->one[i];
            if (!is_usable_witness(a, reference) || !is_usable_witness(b, reference) ||
                a->method == b->method)
                continue;
            const double apart = fmin(grid_distance_max(reference, a->grid, reference->y),
                                      grid_distance_max(reference, b->grid, reference->y));
            const double known =
                fmax(fmax(a->moved, b->moved), grid_distance_max(reference, a->grid, b->grid));
            if (!(apart > CONTRADICTION_FACTOR * fmax(known, reference->accuracy)) ||
                (found && apart <= reference->apart))
                continue;
            found = true;
            reference->dissenting_method[0] = a->method;
            reference->dissenting_method[1] = b->method;
            reference->apart = apart;
            *step = fmin(a->step, b->step);
        }
    return found;
}
