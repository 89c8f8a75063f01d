/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The figures of the module, drawn from the stored tables: a path, and an ensemble with its
 * band. */
#include "modules/noise/plots.h"

#include <hooke/plot/drawing.h>

#include <string.h>

bool noise_langevin_known(const struct session *session)
{
    return drawing_stored(session, "langevin") != NULL;
}

bool noise_ensemble_known(const struct session *session)
{
    return drawing_stored(session, "ensemble") != NULL;
}

/* Returns the name of the quantity whose mean an ensemble has. */
static const char *observed_name(const struct table *table)
{
    for (int i = 0; i < table->keys; i++)
        if (strcmp(table->key[i].key, "of") == 0)
            return table->key[i].value;
    return table->column[1].name;
}

/* Makes the figure of the last result of `langevin`, its first column over time, or with `ensemble`
 * of the last `ensemble`, the mean over time with its standard deviation as a band. Returns false
 * with d->error if there is no such result or if out of memory. */
static bool draw_table(struct drawing *d, bool ensemble, struct figure *figure)
{
    const char *command = ensemble ? "ensemble" : "langevin";
    const struct table *table = drawing_stored(d->session, command);
    if (!table) {
        error_set(d->error, ERROR_COMMAND, "there is no %s to plot", command);
        return error_hint(d->error, "type: %s%s 10 s kT=1mJ", command, ensemble ? " 500" : "");
    }
    const struct table_column *t = &table->column[0], *value = &table->column[1];
    const double *spread = ensemble ? table->column[2].value : NULL;
    const char *label = ensemble ? observed_name(table) : value->name;
    const enum quantity quantity[2] = {QUANTITY_TIME, column_quantity(value)};
    struct curve *curve = arena_alloc(d->arena, sizeof *curve);
    double size = 0;
    if (!curve)
        return error_memory(d->error);
    for (size_t i = 0; i < table->rows; i++)
        size = fmax(size, fabs(value->value[i]) + (spread ? spread[i] : 0));
    const char *const spread_label = ensemble ? "+- standard deviation" : NULL;
    *curve = (struct curve){.label = ensemble ? "mean" : label,
                            .x = t->value,
                            .y = value->value,
                            .n = table->rows,
                            .spread = spread,
                            .spread_label = spread_label,
                            .cancel = d->session->front.cancel};
    const double window[2] = {t->value[0], t->value[table->rows - 1]};
    *figure = (struct figure){.title = command,
                              .x = time_axis(window),
                              .y = quantity_axis(label, quantity[1], size),
                              .curve = curve,
                              .curves = 1};
    return drawing_ranges(d, figure, quantity);
}

bool noise_langevin_figure(struct drawing *d, struct figure *figure)
{
    return draw_table(d, false, figure);
}

bool noise_ensemble_figure(struct drawing *d, struct figure *figure)
{
    return draw_table(d, true, figure);
}
