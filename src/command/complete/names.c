/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of names that single commands take: variables of atol, values of set, topics of
 * help. */
#include <hooke/base/statement.h>
#include <hooke/command/complete.h>
#include "command/session/topics.h"

/* Offers the variables of the scene, and off; named means that a variable was typed already. */
void complete_atol(struct completion *c, bool named)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < model->n && !named; i++)
        complete_offer(c, model->variable[i].name, "variable of the scene");
    complete_offer(c, "off",
                   named ? "errors relative to its size (tol)"
                         : "all variables: errors relative to their size (tol)");
}

/* Offers choices of a setting, or values with units that suit the name. */
void complete_set(struct completion *c, struct text name, struct text preceding)
{
    const struct scene *scene = &c->session->setup.scene;
    const struct row *row;
    enum quantity quantity = QUANTITY_OTHER;
    if ((row = catalog_find(scene_params(scene), name)))
        quantity = ((const struct param_row *)(const void *)row)->quantity;
    else if ((row = catalog_find(scene_derived(scene), name)))
        quantity = ((const struct derived_row *)(const void *)row)->quantity;
    else if ((row = catalog_find(&setting_catalog, name))) {
        const struct setting *setting = setting_from(row);
        if (setting->choices) {
            complete_catalog(c, setting->choices);
            return;
        }
        quantity = setting->quantity;
    }
    struct text value = {name.data + name.len,
                         (size_t)(preceding.data + preceding.len - name.data) - name.len};
    text_skip_blanks(&value);
    if (value.len > 0 && value.data[0] == '=')
        value = text_after(value, 1);
    complete_value(c, value, quantity, complete_operands);
}

/* Offers the rows of all catalogs that help explains, and names of models. */
void complete_topics(struct completion *c)
{
    for (int i = 0; help_catalog(i); i++)
        complete_catalog(c, help_catalog(i));
    for (const struct model *const *model = scene_models; *model; model++) {
        const struct catalog *const own[] = {(*model)->params, (*model)->derived};
        for (size_t i = 0; i < COUNT_OF(own); i++)
            for (size_t j = 0; j < own[i]->count; j++)
                if (model_with(text_of(catalog_row(own[i], j)->name)) ==
                    *model) /* each name once */
                    complete_offer(c, catalog_row(own[i], j)->name, catalog_row(own[i], j)->brief);
    }
}
