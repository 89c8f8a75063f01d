/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of typed equations on a box of states, and of their derivatives (interval arithmetic,
 * Moore 1966), for searches for equilibria that must not miss one. */
#include <math.h>

#include <hooke/base/numeric.h>
#include <hooke/scene/poles.h>

#include "scene/formula/outer.h"
#include "scene/typed/typed.h"

/* Phases of a drive's period; the mean over them is exact for all lower harmonics. */
#define DRIVE_PHASES 32

/* Bounds of all names of a scene. */
struct box_names {
    const struct typed *typed;
    struct jet name[TYPED_NAMES_MAX];
};

/* Returns the bounds of a name, whose derivative is 1 if it `moves`, else 0. */
static struct jet of_unit(struct interval value, bool moves)
{
    struct jet jet = jet_number(0);
    jet.value = value;
    jet.slope = interval_point(moves);
    return jet;
}

/* Computes bounds of all names at time t, differentiated by variable `variable`, or not at all if
 * `variable` is -1. */
static void name_all(struct box_names *names, const double *c, const struct interval *box, double t,
                     int variable)
{
    const struct typed *typed = names->typed;
    const int n = typed->model.n, first = typed_first_observed(typed);
    names->name[0] = jet_number(t);
    for (int i = 0; i < n; i++)
        names->name[1 + i] = of_unit(box[i], i == variable);
    for (int i = 0; i <= typed->reads; i++)
        names->name[1 + n + i] = jet_number(c[1 + i]);
    for (int i = 0; i < typed->observes; i++)
        names->name[first + i] = expr_jet(typed->observe[i], names->name);
}

/* Returns the bounds of the typed acceleration or derivative `row`. */
static struct jet row_of(const struct box_names *names, int row)
{
    struct jet sum = jet_number(0);
    for (int g = 0; g < GROUPS; g++)
        if (names->typed->group[g] && names->typed->group[g][row])
            sum = jet_add(sum, expr_jet(names->typed->group[g][row], names->name));
    return sum;
}

static struct interval scaled(struct interval a, double factor)
{
    return interval_mul(a, interval_point(factor));
}

/* Bounds all rates, and with `jacobian` their derivatives, as means over the phases of a drive. */
bool system_bounds(const struct system *system, const struct interval *box, struct interval *rate,
                   struct interval *jacobian)
{
    const struct bound_term *whole = system_whole(system);
    const struct typed *typed = system->model->typed;
    if (!whole || !typed || typed->base)
        return false;
    const double drive = system_drive(system);
    if (drive != drive)
        return false;
    const int n = system->n, rows = typed_rows(typed), positions = n - rows,
              phases = drive > 0 ? DRIVE_PHASES : 1;
    struct box_names names = {.typed = typed};
    for (int i = 0; i < n; i++)
        rate[i] = i < positions ? box[positions + i] : interval_point(0);
    for (int i = 0; jacobian && i < n * n; i++)
        jacobian[i] = interval_point(i / n < positions && i % n == i / n + positions);
    for (int phase = 0; phase < phases; phase++)
        for (int k = jacobian ? 0 : -1; k < (jacobian ? n : 0); k++) {
            name_all(&names, system->typed.c, box, system->t0 + drive * phase / phases, k);
            for (int i = 0; i < rows; i++) {
                const struct jet jet = row_of(&names, i);
                struct interval *r = &rate[positions + i];
                if (k <= 0)
                    *r = interval_add(*r, scaled(jet.value, 1.0 / phases));
                if (jacobian) {
                    struct interval *d = &jacobian[(positions + i) * n + k];
                    *d = interval_add(*d, scaled(jet.slope, 1.0 / phases));
                }
            }
        }
    return true;
}

/* Returns true if one of the rates cannot be 0 in the box. */
bool system_excludes_zero(const struct system *system, const struct interval *box)
{
    const struct bound_term *whole = system_whole(system);
    const struct typed *typed = system->model->typed;
    if (!whole || !typed || typed->base || system_drive(system) != 0)
        return false;
    struct box_names names = {.typed = typed};
    name_all(&names, system->typed.c, box, system->t0, -1);
    bool excludes = false;
    for (int row = 0; row < typed_rows(typed) && !excludes; row++) {
        struct outer sum = outer_interval(interval_point(0));
        for (int g = 0; g < GROUPS; g++)
            if (typed->group[g] && typed->group[g][row])
                sum = outer_add(sum, expr_outer(typed->group[g][row], names.name));
        excludes = outer_excludes_zero(sum);
    }
    return excludes;
}

/* Binds the scene, if need be with a start inside of the box, where its equations have a value. */
bool scene_bind_inside(struct scene *scene, double (*box)[2], struct system *system,
                       struct error *error)
{
    enum { STARTS_TRIED = 64 };
    const struct typed *typed = scene->model->typed;
    struct error ignored;
    uint64_t seed = 3;
    if (scene_bind(scene, system, error))
        return true;
    struct scene moved = *scene;
    for (int k = 0; k < STARTS_TRIED && typed && !typed->base; k++) {
        for (int i = 0; i < scene->model->n; i++)
            if (!isnan(box[i][0]) && !isnan(box[i][1]))
                moved.value[typed->initial[i]] =
                    box[i][0] + (box[i][1] - box[i][0]) * (k == 0 ? 0.5 : random_fraction(&seed));
        if (scene_bind(&moved, system, &ignored)) {
            *scene = moved;
            return true;
        }
    }
    return false;
}
