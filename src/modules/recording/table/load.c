/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Loads a recording: container, text, format, columns, times, and the uncertainties that a file
 * gives. */
#include "modules/recording/clean/clean.h"
#include "modules/recording/container/container.h"
#include "modules/recording/table/table.h"

#include <hooke/base/catalog.h>
#include <hooke/base/numeric.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Adds a warning to the recording. Beyond WARNINGS_MAX, the last entry only counts further ones. If
 * out of memory it is dropped. */
void recording_warn(struct recording *recording, const char *format, ...)
{
    va_list args;
    struct buffer sentence = {0};
    if (!recording->warning)
        recording->warning =
            arena_array(&recording->arena, WARNINGS_MAX + 1, sizeof *recording->warning);
    if (!recording->warning)
        return;
    va_start(args, format);
    if (recording->warnings < WARNINGS_MAX)
        buffer_vformat(&sentence, format, args);
    else
        buffer_format(&sentence, "and %d more %s", recording->unsaid + 1,
                      recording->unsaid ? "kinds" : "kind");
    /* The last entry counts the warnings for which there is no space. */
    recording->unsaid += recording->warnings >= WARNINGS_MAX;
    va_end(args);
    char *copy = sentence.failed ? NULL : arena_text(&recording->arena, buffer_text(&sentence));
    if (copy) {
        recording->warnings += recording->unsaid < 2;
        recording->warning[recording->warnings - 1] = copy;
    }
    buffer_free(&sentence);
}

/* ---- loading ---- */

/* Splits the first lines of the text into text->head, in the arena, up to HEAD_LINES lines or
 * HEAD_BYTES bytes. Returns false if out of memory. */
bool table_head(struct table_text *text, struct arena *arena)
{
    struct text rest = text->text, line;
    size_t bytes = 0;
    text->heads = 0;
    text->head = arena_array(arena, HEAD_LINES, sizeof *text->head);
    while (text->head && text->heads < HEAD_LINES && bytes < HEAD_BYTES &&
           table_line(&rest, &line)) {
        line.len = line.len < HEAD_BYTES ? line.len : HEAD_BYTES;
        bytes += line.len;
        text->head[text->heads] = (struct table_line){line, text->first + text->heads};
        text->heads++;
    }
    return text->head != NULL;
}

static const struct format *format_row(size_t i)
{
    return format_at(i);
}

/* Returns the surest format; of equally sure ones the first. */
const struct format *format_of(const struct table_text *text, const struct format *but)
{
    const struct format *best = NULL;
    int max = 0;
    for (size_t i = 0; i < format_catalog.count; i++) {
        const int sure = format_row(i) == but ? 0 : format_row(i)->probe(text);
        best = sure > max ? format_row(i) : best;
        max = sure > max ? sure : max;
    }
    return best;
}

/* Names the recording after the file: without the suffix, and with '-' for characters other than
 * letters and digits, so that it can be typed. */
static void name_recording(struct recording *recording, struct text file)
{
    size_t len = 0, end = file.len;
    for (size_t i = file.len; i-- > 1 && end == file.len;)
        end = file.data[i] == '.' ? i : end;
    for (size_t i = 0; i < end && len < LIMIT_NAME; i++) {
        const char c = file.data[i];
        const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
                           (c >= 'a' && c <= 'z') || c == '_' || c == '.';
        if (plain || (len > 0 && recording->name[len - 1] != '-'))
            recording->name[len++] = plain ? c : '-';
    }
    while (len > 1 && recording->name[len - 1] == '-')
        len--;
    recording->name[len] = '\0';
    if (len == 0)
        snprintf(recording->name, sizeof recording->name, "data");
}

/* Reads a text by the format that recognises it with the most certainty, and chooses columns and
 * times unless the format does so itself. Returns false with the error. */
static bool read_text(struct table_text *text, const struct load_options *options,
                      struct recording *recording, struct error *error)
{
    struct arena scratch = {0};
    bool done = table_head(text, &scratch) || error_memory(error);
    if (done) {
        if (!text_starts(text->text, TEXT(COLLECTED_HEAD))) /* their table is inside of the lines */
            table_find(text, 0, options, &text->layout, &text->problem);
        recording->header_rate = table_rate(text);
        const struct format *format = format_of(text, NULL);
        snprintf(recording->format, sizeof recording->format, "%s", format->row.name);
        done = format->read(text, options, recording, error) &&
               (format->whole || (recording_choose(recording, options, error) &&
                                  recording_time(recording, options, error)));
    }
    arena_reset(&scratch);
    return done;
}

/* Reads one text, without its byte order mark. `shown` is the file's name for messages. */
static bool read_part(struct text content, const char *shown, const struct load_options *options,
                      struct recording *recording, struct error *error)
{
    struct table_text text = {.name = shown, .text = content, .first = 1, .header = 1};
    if (text_starts(text.text, TEXT("\xEF\xBB\xBF")))
        text.text = text_after(text.text, 3);
    return refuse_binary(text.text, text.name, error) &&
           read_text(&text, options, recording, error);
}

/* Returns true if a table begins in the content, or if a format recognises it without one;
 * otherwise sets the error. `shown` is the name for messages. */
bool table_begins(struct text content, const char *shown, const struct load_options *options,
                  struct error *error)
{
    struct arena scratch = {0};
    struct table_text text = {.name = shown, .text = content, .first = 1, .header = 1};
    if (text_starts(content, TEXT("\xEF\xBB\xBF")))
        text.text = text_after(content, 3);
    bool found = table_head(&text, &scratch) || error_memory(error);
    if (found && !table_find(&text, 0, options, &text.layout, error)) {
        const struct format *sure = format_of(&text, NULL);
        found = !sure->any && sure->probe(&text) > 0; /* it finds its table by itself */
    }
    arena_reset(&scratch);
    return found;
}

/* Returns true if a part of a container holds a table. */
static bool part_has_table(const struct container_part *part, const char *shown,
                           const struct load_options *options, struct error *error)
{
    return refuse_binary(buffer_text(&part->text), shown, error) &&
           table_begins(buffer_text(&part->text), shown, options, error);
}

/* Makes a run of the recording for each part of a container. Returns false if out of memory. */
static bool name_runs(const struct contents *contents, struct recording *recording,
                      struct error *error)
{
    recording->run = arena_array(&recording->arena, contents->parts, sizeof *recording->run);
    if (!recording->run)
        return error_memory(error);
    for (size_t i = 0; i < contents->parts; i++)
        snprintf(recording->run[i].name, sizeof recording->run[i].name, "%s",
                 contents->part[i].name);
    recording->runs = (int)contents->parts;
    return true;
}

/* Reads one part of several into the recording: the requested run, by default the first part with a
 * table. The runs of the recording are those that the part names itself, else the parts. Returns
 * false with the error. */
static bool read_parts(const struct contents *contents, const char *shown,
                       const struct load_options *options, struct recording *recording,
                       struct error *error)
{
    struct load_options part_options = *options;
    struct recording tables = {0};
    size_t taken = 0;
    bool done = name_runs(contents, &tables, error);
    if (done && options->run.len > 0) {
        int wanted;
        done = run_find(&tables, options->run, &wanted, error);
        taken = done ? (size_t)wanted : 0;
        part_options.run = TEXT("");
    } else {
        while (done && taken + 1 < contents->parts &&
               !part_has_table(&contents->part[taken], shown, options, error))
            taken++;
    }
    done = done && read_part(buffer_text(&contents->part[taken].text), shown, &part_options,
                             recording, error);
    if (done && recording->runs == 0) {
        done = name_runs(contents, recording, error);
        recording->taken = (int)taken;
    }
    arena_reset(&tables.arena);
    return done;
}

/* Loads the file into an empty recording, as recording_load() does. Returns false with the
 * error. */
static bool recording_load_file(const char *path, const struct load_options *options,
                                struct recording *recording, struct error *error)
{
    struct contents contents = {0};
    char shown[SHORT_NAME];
    struct text file = text_last_component(text_of(path));
    short_name(file, shown);
    bool done = contents_read(path, shown, options, &contents, error);
    if (done) {
        recording->path = arena_text(&recording->arena, text_of(path));
        recording->container = contents.container;
        recording->sum = contents.sum;
        if (options->name.len > 0)
            snprintf(recording->name, sizeof recording->name, "%.*s", (int)options->name.len,
                     options->name.data);
        else
            name_recording(recording, file);
        if (!recording->path)
            done = error_memory(error);
        else if (contents.parts == 1)
            done = read_part(buffer_text(&contents.part[0].text), shown, options, recording, error);
        else
            done = read_parts(&contents, shown, options, recording, error);
    }
    const bool grew = contents.grew;
    contents_free(&contents); /* the search below needs as much memory */
    done = done && (recording_leave_out_sentinels(recording) || error_memory(error));
    if (done && grew)
        recording_warn(recording, "the file was still being written: its last line and what was "
                                  "added later are left out; 'collect' reads a growing file");
    return done;
}

/* Returns a recording made of the text that was collected so far, or NULL with the error. Values
 * that a sensor reports without a signal become missing. */
struct recording *collected_read(struct text text, const struct load_options *options,
                                 struct error *error)
{
    struct recording *recording = calloc(1, sizeof *recording);
    if (!recording) {
        error_memory(error);
        return NULL;
    }
    recording->cancel = options->cancel;
    if (!read_part(text, "what has arrived", options, recording, error) ||
        !(recording_leave_out_sentinels(recording) || error_memory(error))) {
        recording_destroy(recording);
        return NULL;
    }
    return recording;
}

struct recording *recording_load(const char *path, const struct load_options *options,
                                 struct error *error)
{
    static const struct load_options none;
    struct recording *recording = calloc(1, sizeof *recording);
    if (!recording) {
        error_memory(error);
        return NULL;
    }
    recording->cancel = options ? options->cancel : NULL;
    if (!recording_load_file(path, options ? options : &none, recording, error)) {
        recording_destroy(recording);
        return NULL;
    }
    return recording;
}

/* ---- uncertainties ---- */

/* Smallest number of samples whose equal uncertainties are no scatter of single samples. */
#define SAME_MIN 100

/* Returns the column of uncertainties nearest after the value's column, else the first, or NULL. */
static const struct column *error_column(const struct recording *recording)
{
    const struct column *value = &recording->column[recording->value], *found = NULL;
    for (int i = recording->columns - 1; i >= 0; i--) {
        const struct column *column = &recording->column[i];
        if (i != recording->value && i != recording->time && column->run == value->run &&
            column->quantity == value->quantity && name_has_word(column->name, ERROR_WORDS) &&
            !name_has_word(column->name, ERROR_WORDS_ACROSS) &&
            (i > recording->value || !found || found < value))
            found = column;
    }
    return found;
}

/* Sets *half to the uncertainties of the series' samples from the recording's column of errors, in
 * the arena, or to NULL if it has none. Returns false if out of memory. */
bool recording_errors(const struct recording *recording, const struct series *series,
                      struct arena *arena, const double **half)
{
    const struct column *column = error_column(recording);
    double low = HUGE_VAL, high = -HUGE_VAL;
    *half = NULL;
    if (!column)
        return true;
    double *result = arena_array(arena, series->n + 1, sizeof *result);
    if (!result)
        return false;
    for (size_t i = 0, row = 0; i < series->n; i++) {
        while (row + 1 < recording->rows && !(recording->t[row] >= series->t[i]))
            row++;
        result[i] = column->value[row] >= 0 ? column->value[row] * column->factor : NAN;
        low = fmin(low, result[i]);
        high = fmax(high, result[i]);
    }
    if (high > 0 && (high > low || series->n < SAME_MIN))
        *half = result;
    return true;
}
