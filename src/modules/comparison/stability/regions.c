/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Traces the boundaries of stability of methods: in the plane of z = lambda dt, as order stars, and
 * over damping and omega dt. */
#include "modules/comparison/stability/regions.h"
#include "modules/comparison/stability/contour.h"

#include <hooke/base/catalog.h>

#include <math.h>
#include <stdlib.h>

/* Growth above 1 by less counts as none: at a double eigenvalue it is known to the square root of
 * rounding only. */
static const double growth_rounding = 1e-8;
/* [1] Half the width of the plane for methods that are stable at every step. */
static const double unbounded_width = 6;
/* Regions are not examined beyond this |z|, as those of backward differentiation in the right half
 * plane extend far. */
static const double widest_plane = 40;
/* Largest damping ratio of the plane over zeta and omega dt. */
static const double zeta_max = 1.5;
/* Number of grid cells along an axis of the z plane, and of the plane over zeta and omega dt. */
enum { PLANE_CELLS = 110, DAMPED_CELLS = 120 };

static const struct row planes[] = {
    [REGION_Z] = {"boundary", "", "where a step does not grow, in the plane of lambda dt", "",
                  NULL},
    [REGION_STARS] = {"star-boundary", "", "order stars, in the plane of lambda dt", "", NULL},
    [REGION_DAMPED] = {"region-boundary", "",
                       "stability of a damped oscillator, by zeta and omega dt", "", NULL},
};
const struct catalog region_catalog = CATALOG("plane", planes);

/* ---- the columns ---- */

#define AT(member) .offset = offsetof(struct region_row, member)
/* clang-format off */
#define REGION_COLUMNS(horizontal, vertical) \
    {.name = "part", .kind = COLUMN_NAME, AT(part)}, \
    {.name = "curve", .kind = COLUMN_NAME, AT(curve)}, \
    {.name = horizontal, AT(x)}, \
    {.name = vertical, AT(y)}, \
    {.name = "dt_max", .quantity = QUANTITY_TIME, AT(dt_max)}
/* clang-format on */

static const struct result_column of_plane[] = {REGION_COLUMNS("re", "im")};
static const struct result_column of_damped[] = {REGION_COLUMNS("zeta", "omega_dt")};
static const struct result_columns plane_columns = RESULT_COLUMNS(of_plane, struct region_row),
                                   damped_columns = RESULT_COLUMNS(of_damped, struct region_row);

const struct result_columns *region_columns(enum region_plane plane)
{
    return plane == REGION_DAMPED ? &damped_columns : &plane_columns;
}

/* ---- the fields ---- */

/* Returns growth per step - 1 at z for the method_choice `context`; boundaries are where it is
 * 0. */
static double growth_in_z(const void *context, double re, double im)
{
    return stability_growth(context, re, im) - 1 - growth_rounding;
}

/* Returns growth per step relative to the exact solution, minus 1. */
static double growth_in_star(const void *context, double re, double im)
{
    return stability_growth(context, re, im) * exp(-re) - 1 - growth_rounding;
}

/* Returns growth per step - 1 of a damped oscillator, with x = omega dt. */
static double growth_in_damped(const void *context, double zeta, double x)
{
    const struct method_choice *choice = context;
    return x > 0 ? method_growth(choice->method, choice->drag, x, zeta) - 1 - growth_rounding : -1;
}

/* ---- how far the plane reaches ---- */

/* Returns the largest Re z at which a step of a method that is stable far to the left grows, or 0
 * if there is none. */
static double unstable_reach(const struct method_choice *choice)
{
    enum { PLACES = 54 };
    double reach = 0;
    for (int i = 0; i < PLACES; i++) {
        const double re = widest_plane * pow(1.1, i - PLACES);
        if (stability_growth(choice, re, 0) > 1)
            reach = re;
    }
    return reach;
}

/* Widens box {left, right, top}, a part of the complex plane of lambda dt, so that the boundary of
 * the method's stability region is in it, with a margin. Methods that are stable at every step on
 * the real axis extend it to their unstable part, or by a fixed size if that is empty or too wide.
 */
static void include_method(const struct method_choice *choice, double box[3])
{
    const double real = method_stable_limit(choice->method, choice->drag, 1),
                 high = finite_or(method_stable_limit(choice->method, choice->drag, 0), 0),
                 middle = finite_or(method_stable_limit(choice->method, choice->drag, 0.3), 0);
    if (isinf(real)) {
        double reach = unstable_reach(choice);
        reach = reach < widest_plane / 1.2 ? reach : 0;
        box[0] = fmin(box[0], reach > 0 ? -0.5 * reach : -unbounded_width);
        box[1] = fmax(box[1], reach > 0 ? 1.25 * reach : unbounded_width);
        box[2] = fmax(box[2], reach > 0 ? 0.9 * reach : unbounded_width);
        return;
    }
    box[0] = fmin(box[0], -1.25 * finite_or(real, 1));
    box[1] = fmax(box[1], 0.45 * finite_or(real, 1));
    box[2] = fmax(box[2], 1.25 * fmax(fmax(high, middle), 0.7 * finite_or(real, 1)));
}

/* Returns the field (function, rectangle, number of cells) whose zero lines are the stability
 * boundaries in that plane, over a rectangle that contains those of all `count` methods. Its
 * context is left to the caller. */
static struct contour_field plane_field(enum region_plane plane, const struct stability *stability,
                                        int count)
{
    double box[3] = {0, 0, 0};
    for (int i = 0; i < count && plane != REGION_DAMPED; i++)
        include_method(&stability[i].choice, box);
    for (int i = 0; i < count && plane == REGION_DAMPED; i++)
        for (int k = 0; k <= 8; k++)
            box[2] = fmax(box[2],
                          finite_or(method_stable_limit(stability[i].choice.method,
                                                        stability[i].choice.drag, zeta_max * k / 8),
                                    0));
    if (plane == REGION_DAMPED)
        return (struct contour_field){
            .value = growth_in_damped,
            .upper = {zeta_max, 1.15 * finite_or(box[2], unbounded_width)},
            .cells = {DAMPED_CELLS, DAMPED_CELLS}};
    if (plane == REGION_STARS) {
        box[2] = fmin(fmax(-box[0], box[2]), widest_plane);
        box[0] = -box[2];
        box[1] = box[2];
    }
    /* No node lies on the imaginary axis, where the growth of many methods is 1. */
    const double cell = (box[1] - box[0]) / PLANE_CELLS, left = (floor(box[0] / cell) + 0.5) * cell;
    return (struct contour_field){
        .value = plane == REGION_Z ? growth_in_z : growth_in_star,
        .lower = {left, 0},
        .upper = {left + PLANE_CELLS * cell, box[2]},
        .cells = {PLANE_CELLS, (int)fmax(8, fmin(PLANE_CELLS, ceil(box[2] / cell)))}};
}

/* ---- rows ---- */

/* Appends a row. Returns false if out of memory. */
static bool region_add(struct region *region, const struct region_row *row)
{
    if (region->rows == region->capacity) {
        const size_t capacity = region->capacity ? 2 * region->capacity : 1024;
        struct region_row *larger = realloc(region->row, capacity * sizeof *larger);
        if (!larger)
            return false;
        region->row = larger;
        region->capacity = capacity;
    }
    region->row[region->rows++] = *row;
    return true;
}

/* Appends the boundary of one method, traced in the upper half plane and, if `mirrored`, repeated
 * below. Returns false if out of memory or cancelled. */
static bool add_boundary(const struct contour_field *field, const struct stability *stability,
                         bool mirrored, const struct cancel *cancel, struct region *region)
{
    struct contour contour = {0};
    struct region_row row = {.part = "boundary",
                             .curve = stability->choice.method->row.name,
                             .dt_max = stability->dt_max};
    bool ok = contour_trace(field, cancel, &contour);
    for (int side = 1; side >= (mirrored ? -1 : 1); side -= 2)
        for (size_t i = 0; ok && i < contour.n; i++) {
            row.x = contour.x[i];
            row.y = side * contour.y[i];
            ok = region_add(region, &row);
        }
    contour_free(&contour);
    return ok;
}

/* Appends the stable interval of the imaginary axis of a method that does not apply to forces which
 * depend on velocity, and so has no region. `damped` selects the plane over zeta and omega dt.
 * Returns false if out of memory. */
static bool add_interval(const struct stability *stability, bool damped, struct region *region)
{
    const double limit = method_stable_limit(stability->choice.method, stability->choice.drag, 0);
    struct region_row row = {.part = "boundary",
                             .curve = stability->choice.method->row.name,
                             .dt_max = stability->dt_max};
    if (!isfinite(limit))
        return true;
    row.y = damped ? 0 : -limit;
    bool ok = region_add(region, &row);
    row.y = limit;
    ok = ok && region_add(region, &row);
    row.x = row.y = NAN;
    return ok && region_add(region, &row);
}

/* Appends the two eigenvalues of a mode times dt, or its damping ratio and omega dt. Returns false
 * if out of memory. */
static bool add_mode_points(enum region_plane plane, const struct mode *mode, double dt,
                            const char *part, const char *curve, struct region *region)
{
    struct region_row row = {.part = part, .curve = curve, .dt_max = NAN};
    double re[2], im;
    mode_eigenvalues(mode, re, &im);
    if (plane == REGION_DAMPED) {
        row.x = mode->zeta;
        row.y = mode->omega * dt;
        return mode->sign != STIFFNESS_POSITIVE || region_add(region, &row);
    }
    bool ok = true;
    for (int k = 0; k < 2; k++) {
        row.x = re[k] * dt;
        row.y = (k == 0 ? im : -im) * dt;
        ok = ok && region_add(region, &row);
    }
    return ok;
}

/* Appends points to the region's diagram: the modes of the scene at its start with the present dt
 * and, for each of `count` methods, the mode that limits it with dt_max. Returns false if out of
 * memory. */
static bool add_points(enum region_plane plane, const struct stability *stability, int count,
                       struct region *region)
{
    bool ok = true;
    for (int i = 0; i < stability->at_start; i++)
        ok = ok &&
             add_mode_points(plane, &stability->mode[i], stability->dt, "scene",
                             plane == REGION_DAMPED ? "omega dt here" : "lambda dt here", region);
    for (int i = 0; i < count; i++)
        if (stability[i].dt_max > 0 && isfinite(stability[i].dt_max))
            ok = ok && add_mode_points(plane, &stability[i].tightest, stability[i].dt_max, "limit",
                                       "at dt_max", region);
    return ok;
}

/* Finds the boundaries of the studied methods and the eigenvalues of the scene times dt. */
bool region_trace(enum region_plane plane, const struct stability *stability, int count,
                  const struct cancel *cancel, struct region *region, struct error *error)
{
    struct contour_field field = plane_field(plane, stability, count);
    bool ok = true;
    for (int i = 0; i < count && ok; i++) {
        field.context = &stability[i].choice;
        ok = isnan(stability_growth(&stability[i].choice, -0.5, 0.5))
                 ? add_interval(&stability[i], plane == REGION_DAMPED, region)
                 : add_boundary(&field, &stability[i], plane != REGION_DAMPED, cancel, region);
    }
    ok = ok && (plane == REGION_STARS || add_points(plane, stability, count, region));
    if (!ok && !cancelled(cancel))
        return error_memory(error);
    return ok || error_set(error, ERROR_CANCELLED, "stopped");
}

void region_free(struct region *region)
{
    free(region->row);
    *region = (struct region){NULL, 0, 0};
}
