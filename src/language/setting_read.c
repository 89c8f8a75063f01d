/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads the value of a setting, as in `dt = 0.01`, by its row: its own parser, a choice from a
 * catalog, or a positive number with a unit. */
#include <hooke/language.h>

#include <string.h>

/* Reads the rest of the statement as the value of a setting into `settings`, at the setting's
 * offset: by its own function `parse`, as the name of one of its choices, or as a number with a
 * unit between `min` and `max`. Returns false with an error, which lists the choices if the name is
 * unknown, and leaves `settings` unchanged then. */
bool setting_read(const struct setting *setting, struct parser *parser, struct settings *settings,
                  struct error *error)
{
    const struct text value = text_trim(parser->rest);
    if (value.len == 0)
        return error_at(error, value, "%s needs a value", setting->row.name);
    if (setting->parse) {
        parser->rest = (struct text){value.data + value.len, 0};
        return setting->parse(settings, value, error);
    }
    if (setting->choices) {
        const struct row *row = catalog_choose(parser->session, setting->choices, value);
        if (!row && !choice_is_in(setting->choices, value, error))
            return false;
        if (!row) {
            struct buffer all = {0};
            for (size_t i = 0; i < setting->choices->count; i++)
                buffer_format(&all, "%s%s", i ? ", " : "", catalog_row(setting->choices, i)->name);
            catalog_unknown(setting->choices, value, error);
            error_hint(error, "%s is one of: %s", setting->row.name, buffer_view(&all));
            error->hint_kind = HINT_ADVICE;
            buffer_free(&all);
            return false;
        }
        const int index = catalog_index(setting->choices, row);
        memcpy((char *)settings + setting->offset, &index, sizeof index);
        parser->rest = (struct text){value.data + value.len, 0};
        return true;
    }
    struct item item = {0};
    if (!parse_value(parser, setting->row.name, setting->quantity, &item, error) ||
        !refuse_rest(parser, &item, error))
        return false;
    if (!(item.value.value > setting->min && item.value.value <= setting->max))
        return error_at(error, item.text, "%s must be more than 0, got '%.*s'", setting->row.name,
                        (int)item.text.len, item.text.data);
    if (item.value.uncertainty > 0)
        return error_at(error, item.text, "%s is exact and cannot have an uncertainty",
                        setting->row.name);
    memcpy((char *)settings + setting->offset, &item.value.value, sizeof item.value.value);
    return true;
}
