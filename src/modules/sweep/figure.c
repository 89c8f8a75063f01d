/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `plot sweep`: the last sweep from its stored table, whose columns are point, the parameters, at a
 * section event and t, then the measures. */
#include "modules/sweep/plots.h"
#include <hooke/plot/drawing.h>

bool sweep_known(const struct session *session)
{
    return table_store_find(&session->studies.found, TEXT("sweep"));
}

/* Draws the last sweep: as a curve, as an orbit diagram if it has events of a section, or as a map
 * if two parameters were swept (its first two rows then have the same first parameter). Returns
 * false with an error. */
bool sweep_figure(struct drawing *d, struct figure *figure)
{
    const struct stored_table *found = table_store_find(&d->session->studies.found, TEXT("sweep"));
    struct figure_request *request = arena_alloc(d->arena, sizeof *request);
    struct text *name = arena_alloc(d->arena, sizeof *name);
    if (!found) {
        error_set(d->error, ERROR_COMMAND, "there is no sweep to plot");
        return error_hint(d->error, "type: sweep NAME=FROM:TO");
    }
    if (!request || !name)
        return error_memory(d->error);
    const struct table_column *column = found->table.column;
    const bool section = text_is(text_of(column[2].name), "event");
    *request = *d->request;
    request->table = &found->table;
    request->horizontal_column = text_of(column[1].name);
    *name = text_of(column[section ? 4 : 2].name);
    if (request->columns == 0) {
        request->column = name;
        request->columns = 1;
    }
    const bool map = !section && found->table.rows > 1 && column[1].value[0] == column[1].value[1];
    if (map && text_is(text_of(column[3].name), "event")) {
        error_set(d->error, ERROR_COMMAND,
                  "a sweep of a section over two parameters cannot be drawn as a map");
        return error_hint(d->error,
                          "'plot COLUMN against COLUMN of sweep' draws two of its columns");
    }
    if (map) {
        const char *shade =
            d->request->columns ? arena_text(d->arena, d->request->column[0]) : column[3].name;
        const struct study_picture picture = {.table = "sweep",
                                              .made_by = "sweep NAME=FROM:TO NAME=FROM:TO",
                                              .x = column[1].name,
                                              .layer = {{.y = column[2].name}},
                                              .shade = shade};
        return shade ? drawing_study(d, &picture, figure) : error_memory(d->error);
    }
    d->request = request;
    return drawing_table(d, figure);
}
