/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module dynamics: equilibria, periodic orbits, branches of both over parameters, Lyapunov
 * exponents, basins of attraction and phase portraits. This file has its row, and labels as
 * arguments of `use`. */
#include <hooke/base/number.h>
#include <hooke/language/complete.h>
#include "modules/dynamics/chaos.h"
#include "modules/dynamics/handlers.h"

#include <string.h>
#include <strings.h>

/* Returns true if the word looks like the label of a special point: two letters and a number. */
static bool is_label(struct text word)
{
    const struct row *row = NULL;
    double number;
    for (size_t i = 0; i < special_catalog.count && word.len > 2 && !row; i++)
        if (strncasecmp(word.data, catalog_row(&special_catalog, i)->name, 2) == 0)
            row = catalog_row(&special_catalog, i);
    return row && real_parse(text_after(word, 2), &number) == REAL_OK;
}

/* Offers the labels of stored special points to completion. */
static void complete_labels(struct completion *c)
{
    const struct dynamics *d = session_dynamics(c->session);
    for (int b = 0; d && b < d->branches; b++)
        for (int k = 0; k < d->branch[b]->specials; k++) {
            const struct stored_point *point = &d->branch[b]->special[k];
            char label[POINT_LABEL_SIZE];
            stored_point_label(point, label);
            complete_offer(c, label,
                           catalog_row(&special_catalog, (size_t)point->special - 1)->brief);
        }
}

/* Frees the module's part of a session. */
static void free_part(void *state)
{
    struct dynamics_part *part = state;
    dynamics_free(part->found);
    stored_portrait_clear(&part->portrait);
}

/* Returns true if the stored portrait needs that typed model. */
static bool part_uses(const void *state, const struct model *model)
{
    const struct stored_portrait *portrait = &((const struct dynamics_part *)state)->portrait;
    return portrait->known && scene_uses(&portrait->scene, model);
}

const struct module dynamics_module = {
    .row = {"dynamics", "", "equilibria, orbits, branches, exponents, basins, portraits", "", NULL},
    .needs = "lanes solving",
    .part_size = sizeof(struct dynamics_part),
    .part_free = free_part,
    .part_uses = part_uses,
    .store =
        {
            .put = dynamics_put_head,
            .put_next = dynamics_put_next,
            .forget = dynamics_forget,
            .read = dynamics_read,
        },
    .labels = {.is_label = is_label, .complete = complete_labels, .use = use_stored_solution},
    .attractor = attractor_of,
};
