/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of the table of `stability` and of the checks by running, for programs, files and
 * people. */
#include <hooke/base/catalog.h>
#include "modules/comparison/compute/stability.h"

#include <math.h>

#define GROWTH_ROUNDING 1e-10 /* growth nearer to 1 is shown as 1, also if it was measured */

/* Returns a row of the table as what it is. */
static const struct stability *stability_of(const void *row)
{
    return row;
}

/* ---- values ---- */

/* Returns true if the worst mode is an oscillator, which has an omega and a zeta. */
static bool oscillates(const struct stability *s)
{
    return s->modes && s->worst.sign == STIFFNESS_POSITIVE && !s->scalar;
}

static double omega_of(const void *row)
{
    return oscillates(row) ? stability_of(row)->worst.omega : NAN;
}

static double zeta_of(const void *row)
{
    return oscillates(row) ? stability_of(row)->worst.zeta : NAN;
}

/* ---- for people ---- */

/* Writes a growth per step with digits that show a small deviation from 1: "1+2.3e-06". */
void buffer_growth(struct buffer *output, double growth)
{
    const double deviation = fabs(growth - 1);
    if (isnan(growth))
        buffer_char(output, '-');
    else if (isinf(growth))
        buffer_put(output, TEXT("overflow"));
    else if (deviation < 1e-4 && deviation > GROWTH_ROUNDING)
        buffer_format(output, "1%+.2e", growth - 1);
    else
        buffer_format(output, "%.7g", deviation > GROWTH_ROUNDING ? growth : 1);
}

/* Writes a growth per step. */
static void growth_cell(struct text_table *table, double growth)
{
    struct buffer text = {0};
    buffer_growth(&text, growth);
    cell_take(table, &text);
}

/* Writes dt_max: a time, "every step" or "none". */
static void limit_cell(struct text_table *table, double dt_max)
{
    if (isinf(dt_max))
        cell_text(table, "every step");
    else if (dt_max == 0)
        cell_text(table, "none");
    else
        cell_quantity(table, dt_max, QUANTITY_TIME, 6);
}

/* Writes whether all checks agree with the prediction, or nothing if there are none. */
static void agrees_cell(struct text_table *table, const void *row)
{
    const struct stability *s = row;
    if (!s->agrees)
        cell_text(table, "DOES NOT AGREE");
    else
        cell_text(table, s->checks || !s->linear ? "agrees" : "");
}

/* ---- the columns ---- */

#define IN(member) .offset = offsetof(struct stability_check, member)

static const struct result_column of_check[] = {
    {.name = "dt", IN(dt), .quantity = QUANTITY_TIME},
    {.name = "growth_predicted", IN(predicted)},
    {.name = "growth_measured", IN(measured)},
    {.name = "steps", .kind = COLUMN_COUNT, IN(steps)},
    {.name = "agrees", .kind = COLUMN_BOOL, IN(agrees)},
};

static const struct result_columns check_columns = RESULT_COLUMNS(of_check, struct stability_check);

/* Returns the checks of a row, for its column "checks". */
static const void *list_checks(const void *row, size_t *count)
{
    *count = (size_t)stability_of(row)->checks;
    return stability_of(row)->check;
}

#define AT(member) .offset = offsetof(struct stability, member)

/* clang-format off */
static const struct result_column of_method[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(choice.method), .index = 1, .heading = "method"},
    {.name = "drag", .kind = COLUMN_CHOICE, AT(choice.drag), .choices = &drag_catalog, .choice_first = DRAG_EXACT},
    {.name = "dt", AT(dt), .quantity = QUANTITY_TIME, .index = 2, .heading = "dt", .digits = 4},
    {.name = "dt_max", AT(dt_max), .quantity = QUANTITY_TIME,
     .index = 3, .heading = "dt_max", .look = limit_cell},
    {.name = "growth_predicted", AT(growth_predicted),
     .index = 4, .heading = "growth", .look = growth_cell},
    {.name = "growth_measured", AT(growth_measured),
     .index = 5, .rank = 3, .heading = "measured", .look = growth_cell},
    {.name = "growth_exact", AT(growth_exact)},
    {.name = "energy_factor", AT(energy_factor), .index = 6, .rank = 3, .heading = "energy", .digits = 6},
    {.name = "verdict", .kind = COLUMN_CHOICE, AT(verdict),
     .choices = &stability_verdict_catalog, .index = 7, .rank = 1, .heading = "verdict"},
    {.name = "agrees", .kind = COLUMN_BOOL, AT(agrees),
     .index = 8, .rank = 1, .heading = "", .cell = agrees_cell},
    {.name = "linear", .kind = COLUMN_BOOL, AT(linear)},
    {.name = "omega", .real = omega_of, .quantity = QUANTITY_ANGULAR_FREQUENCY},
    {.name = "zeta", .real = zeta_of},
    {.name = "doubling_steps", AT(doubling)},
    {.name = "refused_above", .kind = COLUMN_BOOL, AT(refused)},
    {.name = "checks", .kind = COLUMN_LIST, .part = &check_columns, .list = list_checks},
};
/* clang-format on */

const struct result_columns stability_columns = RESULT_COLUMNS(of_method, struct stability);
