/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "command/handed_in.h"

#include <hooke/hooke.h>

#include <stdio.h>
#include <string.h>

#define MOST_BYTES (1u << 28)
#define FILE_DIGITS 12 /* of the numbers in a sensor's file, at most */

static struct text key_of(const struct table *table, const char *key)
{
    for (int i = 0; i < table->keys; i++)
        if (strcmp(table->key[i].key, key) == 0)
            return text_of(table->key[i].value);
    return TEXT("");
}

/* The zero was subtracted, and the values are in the SI unit: back to the file's own decimals, so
 * that the same numbers come of them bit for bit. */
static void undo_export(struct recording *recording, struct text zero)
{
    size_t used = 0;
    double off = 0;
    if (real_scan(zero, '.', &off, &used) != REAL_OK)
        return;
    const struct unit *unit = unit_find(text_trim((struct text){zero.at + used, zero.len - used}));
    const enum quantity quantity = recording->column[recording->value].quantity;
    for (size_t i = 0; i < recording->rows; i++) {
        char number[64];
        double value = recording->y[i] / (unit ? unit->factor : 1) + off;
        snprintf(number, sizeof number, "%.*g", FILE_DIGITS, value);
        if (real_parse(text_of(number), &value) == REAL_OK &&
            (!unit || unit_convert(unit, quantity, value, &value)))
            recording->y[i] = value;
    }
}

/* NULL: the file is not there, or of another recording. */
static struct recording *take(const char *file, const char *path,
                              const struct load_options *options, struct arena *arena)
{
    struct buffer text = {0};
    struct table table = {0};
    struct error error = {0};
    struct recording *recording = NULL;
    if (file_read(file, MOST_BYTES, &text, &error) &&
        table_parse(buffer_text(&text), options->cancel, arena, &table, &error)) {
        const struct text name = key_of(&table, "recording"), zero = key_of(&table, "zero");
        const struct load_options own = {.name = name, .cancel = options->cancel};
        if (text_equal(text_last_component(key_of(&table, "file")),
                       text_last_component(text_of(path))) &&
            (options->name.len == 0 || text_equal(name, options->name)))
            recording = recording_load(file, &own, &error);
        if (recording) {
            /* times that were smoothed once already */
            if (table.rows == recording->rows && table.columns > 0 && table.column[0].value)
                memcpy(recording->t, table.column[0].value, table.rows * sizeof *recording->t);
            undo_export(recording, zero);
            recording->path = arena_text(&recording->arena, text_of(path));
            snprintf(recording->format, sizeof recording->format, HANDED_IN);
        }
    }
    buffer_free(&text);
    if (recording && !recording->path) {
        recording_destroy(recording);
        recording = NULL;
    }
    return recording;
}

struct recording *recording_handed_in(const char *folder, const char *path,
                                      const struct load_options *options)
{
    struct recording *recording = NULL;
    struct arena arena = {0};
    for (int i = 1; i <= LIMIT_RECORDINGS && !recording; i++) {
        struct buffer file = {0};
        buffer_format(&file, "%s/recording-%d.csv", folder, i);
        recording = take(buffer_view(&file), path, options, &arena);
        buffer_free(&file);
        arena_reset(&arena);
    }
    return recording;
}
