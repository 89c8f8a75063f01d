/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings that are read from a hand-in folder, from copies of their files or from their
 * exports. */
#include "modules/recording/known/handed_in.h"

#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/hooke.h>

#include <float.h>
#include <stdio.h>
#include <string.h>

/* [byte] Largest export that is read. */
#define MOST_BYTES (1u << 28)

/* Returns the value of a key of the table, or an empty text. */
static struct text key_of(const struct table *table, const char *key)
{
    for (int i = 0; i < table->keys; i++)
        if (strcmp(table->key[i].key, key) == 0)
            return text_of(table->key[i].value);
    return TEXT("");
}

/* Returns the SI value of the shortest decimal number, in `unit`, that equals `si` to rounding: the
 * number that was in the original file. Its SI value may be off by the subtraction of the zero.
 * `scale` is the larger of the two numbers that were subtracted. *digits is where the search
 * starts, and is set to where it ended, as neighbours have as many. */
static double number_in_file(double si, double scale, const struct unit *unit, int *digits)
{
    const double rounding = 2 * DBL_EPSILON * scale;
    for (int d = *digits; d <= DBL_DECIMAL_DIG; d++) {
        char text[64];
        double number, back;
        snprintf(text, sizeof text, "%.*f", d, si / unit->factor);
        if (real_parse(text_of(text), &number) == REAL_OK &&
            unit_convert(unit, unit->quantity, number, &back) && fabs(back - si) <= rounding) {
            *digits = d > 0 ? d - 1 : 0;
            return back;
        }
    }
    return si;
}

/* Adds the zero that `export` subtracted to the values, and searches the original file's decimals
 * in its own unit (of SI value `factor`), so that the same doubles result. */
static void undo_export(struct recording *recording, struct text zero, struct text factor)
{
    size_t used = 0;
    double zero_offset = 0;
    struct unit unit = {.quantity = recording->column[recording->value].quantity, .factor = 1};
    if (real_scan(zero, '.', &zero_offset, &used) != REAL_OK)
        return;
    const struct unit *of_zero = unit_find(text_trim(text_after(zero, used)));
    zero_offset *= of_zero ? of_zero->factor : 1;
    if (real_parse(factor, &unit.factor) != REAL_OK || !(fabs(unit.factor) > 0))
        unit.factor = 1;
    int digits = 0;
    for (size_t i = 0; i < recording->rows; i++) {
        const double si = recording->y[i] + zero_offset;
        recording->y[i] =
            number_in_file(si, fmax(fabs(recording->y[i]), fabs(zero_offset)), &unit, &digits);
    }
}

/* Loads a recording of this name from its export, the file and its parsed table. Returns NULL if it
 * cannot be read. */
static struct recording *load_export(const char *file, const struct table *table, struct text name,
                                     const struct load_options *options)
{
    const struct load_options own = {.name = name, .cancel = options->cancel};
    struct error error = {0};
    struct recording *recording = recording_load(file, &own, &error);
    if (!recording)
        return NULL;
    /* times that were smoothed once already */
    if (table->rows == recording->rows && table->columns > 0 && table->column[0].value)
        memcpy(recording->t, table->column[0].value, table->rows * sizeof *recording->t);
    undo_export(recording, key_of(table, "zero"), key_of(table, "factor"));
    snprintf(recording->format, sizeof recording->format, HANDED_IN);
    return recording;
}

/* Loads recording `index` of the folder from the copy of its file, or from its export. Returns NULL
 * if it does not exist or is another recording. */
static struct recording *handed_in_load(const char *folder, int index, const char *path,
                                        const struct load_options *options, struct arena *arena)
{
    struct buffer text = {0}, file = {0}, copy = {0};
    struct table table = {0};
    struct error error = {0};
    struct recording *recording = NULL;
    const struct text last = text_last_component(text_of(path));
    buffer_format(&file, "%s/recording-%d.csv", folder, index);
    buffer_format(&copy, "%s/recording-%d-%.*s", folder, index, (int)last.len, last.data);
    if (file_read(buffer_view(&file), MOST_BYTES, &text, &error) &&
        table_parse(buffer_text(&text), options->cancel, arena, &table, &error)) {
        struct load_options own = *options;
        own.name = key_of(&table, "recording");
        if (text_equal(text_last_component(key_of(&table, "file")), last) &&
            (options->name.len == 0 || text_equal(own.name, options->name))) {
            recording = recording_load(buffer_view(&copy), &own, &error);
            if (!recording)
                recording = load_export(buffer_view(&file), &table, own.name, options);
        }
        if (recording)
            recording->path = arena_text(&recording->arena, text_of(path));
    }
    buffer_free(&text);
    buffer_free(&file);
    buffer_free(&copy);
    if (recording && !recording->path) {
        recording_destroy(recording);
        recording = NULL;
    }
    return recording;
}

/* Finds the recording of the folder that was loaded from `path`, or NULL. */
static struct recording *find_handed(const char *folder, const char *path,
                                     const struct load_options *options)
{
    struct recording *recording = NULL;
    struct arena arena = {0};
    for (int i = 1; i <= LIMIT_RECORDINGS && !recording; i++) {
        recording = handed_in_load(folder, i, path, options, &arena);
        arena_reset(&arena);
    }
    return recording;
}

/* Returns `here`, loaded from `path`, unless it is NULL or the folder has a copy with other
 * contents; then returns the copy. An export (HANDED_IN) has no comparable sum, so `here` wins.
 * Destroys the other recording. */
struct recording *recording_checked(const char *folder, const char *path,
                                    const struct load_options *options, struct recording *here)
{
    struct recording *handed = find_handed(folder, path, options);
    const bool another =
        handed && here && handed->sum != here->sum && strcmp(handed->format, HANDED_IN) != 0;
    struct recording *unused = here && !another ? handed : here;
    recording_destroy(unused);
    return unused == here ? handed : here;
}
