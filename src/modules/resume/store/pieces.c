/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Restores scenes, events, runs and recordings of a session file. */
#include <hooke/data.h>
#include <hooke/result.h>
#include <hooke/base/file.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include "modules/resume/store/reading.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- scenes and events: by the commands that made them ---- */

/* Returns the scene, or events, that were made by these commands, or NULL. */
static struct made *find_made(struct reader *reader, struct text script, bool is_events)
{
    for (size_t i = 0; i < reader->mades; i++)
        if (reader->made[i].is_events == is_events && text_equal(reader->made[i].script, script))
            return &reader->made[i];
    return NULL;
}

/* Remembers a scene or events with a copy of the commands. Without memory they are made again
 * later. */
static void add_made(struct reader *reader, const struct buffer *script, struct made made)
{
    struct made *more =
        realloc(reader->made, (reader->mades + 1) * sizeof *more); /* only a few, one per scene */
    if (!more)
        return; /* it is made again then */
    reader->made = more;
    made.script = buffer_text(script);
    made.script.data = arena_text(&reader->arena, made.script);
    reader->mades += made.script.data != NULL;
    more[reader->mades - (made.script.data != NULL)] = made;
}

/* Remembers a scene for later ones with the same commands. */
void reader_made_scene(struct reader *reader, const struct scene *scene)
{
    struct buffer script = {0};
    scene_kind_script(scene, &script);
    add_made(reader, &script, (struct made){.model = scene->model, .preset = scene->preset});
    buffer_free(&script);
}

/* Remembers events for later ones with the same commands. */
void reader_made_events(struct reader *reader, const struct events *events)
{
    struct buffer script = {0};
    events_save(events, &script);
    add_made(reader, &script, (struct made){.events = events, .is_events = true});
    buffer_free(&script);
}

/* Makes a scene by the commands in script, or takes one that the same commands have made before.
 * Its values are not set. Returns false with an error. */
static bool reader_scene_make(struct reader *reader, struct text script, struct scene *scene,
                              struct error *error)
{
    struct session *session = reader->session;
    const struct made *made = find_made(reader, script, false);
    if (made) {
        scene_init(scene, made->preset);
        scene->model = made->model;
        return true;
    }
    if (!reader_execute(reader, script, error))
        return false;
    *scene = session->setup.scene;
    reader_made_scene(reader, scene);
    return true;
}

/* Returns true if a stored scene is valid: each stored flag is 0 or 1, and the scene's commands
 * would accept each value. */
static bool is_sound(const struct scene *scene)
{
    const struct field flags[] = {FIELD_OF(struct scene, chosen),
                                  FIELD_CALLED("across", struct scene, steps_across_kinks, 0, 0)},
                       atol = FIELD_IN(struct scene, atol, 0, DBL_MAX);
    struct scene same = *scene;
    struct error ignored;
    bool sound = fields_sound(flags, COUNT_OF(flags), scene) && fields_sound(&atol, 1, scene);
    for (size_t i = 0; i < scene_params(scene)->count && sound; i++) {
        const struct measured value = {scene->value[i], scene->uncertainty[i]};
        sound = scene_set(&same, (int)i, value, &ignored);
    }
    return sound;
}

/* Reorders an array [PARAM_MAX] from the order of the file to that of the program. */
void reader_move(const struct field_places *places, void *array, size_t item)
{
    char saved[PARAM_MAX * sizeof(double)];
    memcpy(saved, array, PARAM_MAX * item);
    for (int i = 0; i < places->rows; i++) {
        char *target = (char *)array + (size_t)i * item;
        if (places->index[i] >= 0)
            memcpy(target, saved + (size_t)places->index[i] * item, item);
        else
            memset(target, 0, item);
    }
}

/* Notes, once each, the parameters of a scene in the file that this program does not have. */
static void note_unknown(struct reader *reader, struct text names,
                         const struct field_places *places)
{
    for (int i = 0; i < places->count; i++) {
        const struct text name = text_of(names.data);
        char line[LIMIT_NAME + 64];
        snprintf(line, sizeof line,
                 "the parameter %s is left out because this version does not have it", names.data);
        if (places->row[i] < 0 && !strstr(buffer_view(reader->notes), line))
            reader_note(reader, "%s", line);
        names = (struct text){name.data + name.len + 1, names.len - name.len - 1};
    }
}

/* Reads the scene in the field `name` of a text into *scene. *places, unless NULL, becomes the
 * order in which the file has its parameters. Returns false with an error, and *scene has then no
 * meaning. */
bool reader_scene(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error)
{
    struct field_places found;
    struct text content, script, names;
    if (!field_find(text, name, &content) || !field_find(content, "script", &script) ||
        !field_find(content, "names", &names))
        return error_set(error, ERROR_IO, "it has no scene");
    if (!reader_scene_make(reader, script, scene, error))
        return false;
    struct scene read = *scene;
    if (!field_find_places(names, scene_params(scene), &found) ||
        !field_get_placed(content, "value", &found, read.value, sizeof *read.value) ||
        !field_get_placed(content, "uncertainty", &found, read.uncertainty,
                          sizeof *read.uncertainty) ||
        !field_get_placed(content, "chosen", &found, read.chosen, sizeof *read.chosen) ||
        !field_get(content, "across", &read.steps_across_kinks, sizeof read.steps_across_kinks) ||
        !field_get(content, "atol", read.atol, sizeof read.atol))
        return error_set(error, ERROR_IO, "its scene has other parameters in this version");
    if (!is_sound(&read))
        return error_set(error, ERROR_IO, "its scene has impossible values");
    note_unknown(reader, names, &found);
    if (places)
        *places = found;
    *scene = read;
    return true;
}

/* Reads the events of a run from its record; *events becomes NULL if it has none. Events that the
 * same commands have made before are shared. Returns false with an error. */
static bool read_events(struct reader *reader, struct text text, const struct events **events,
                        struct error *error)
{
    struct session *session = reader->session;
    struct text script;
    *events = NULL;
    if (!field_find(text, "events", &script) || script.len == 0)
        return true;
    const struct made *made = find_made(reader, script, true);
    session->setup.events = NULL;
    if (!made && !reader_execute(reader, script, error))
        return false;
    *events = made ? made->events : session->setup.events;
    if (!made && *events)
        reader_made_events(reader, *events);
    return true;
}

/* ---- runs ---- */

/* Reads a flag, which is unchanged if the field is missing. */
static void get_flag(struct text text, const char *name, bool *flag)
{
    fields_get(text, &(struct field){name, 0, sizeof *flag, FIELD_BOOLS, 0, 0}, 1, flag);
}

/* Adds one request of the run's journal to the run. Parameters are renumbered by places, as this
 * version may have others. Returns false with an error if the request is damaged. */
static bool add_asked(struct run_slot *slot, const struct field_places *places, struct text text,
                      struct error *error)
{
    struct request asked = {.kind = REQUEST_GO};
    struct text condition;
    if (!field_find(text, "condition", &condition))
        condition = TEXT("");
    bool fine = fields_get(text, store_request, store_request_count, &asked);
    if (fine && asked.kind == REQUEST_SET) {
        asked.param = asked.param < places->count ? places->row[asked.param] : -1;
        fine = asked.param >= 0;
    }
    return fine && (asked.kind == REQUEST_SET || asked.param < slot->run->system.n)
               ? journal_add(slot, asked, condition, error)
               : error_set(error, ERROR_IO, "its requests are damaged");
}

/* Adds all requests of the run's journal, in order. Returns false with an error. */
static bool add_all_asked(struct run_slot *slot, const struct field_places *places,
                          struct text text, struct error *error)
{
    struct text name, value;
    bool ok = true;
    while (ok && field_next(&text, &name, &value))
        ok = !text_is(name, "asked") || add_asked(slot, places, value, error);
    return ok;
}

/* Everything that a run is restored from. */
struct run_parts {
    struct text text, state, note;
    struct scene scene;
    struct field_places places;
    const struct events *events;
    const struct method *method;
    int number;
};

/* Reads scene, events, method, number and note of a run into *parts. Returns false with an
 * error. */
static bool read_parts(struct reader *reader, const struct read_run *source,
                       struct run_parts *parts, struct error *error)
{
    struct text method;
    parts->text = source->content;
    if (!field_get(parts->text, "number", &parts->number, sizeof parts->number) ||
        !field_find(parts->text, "state", &parts->state) ||
        !field_find(parts->text, "method", &method) || parts->number < 1 ||
        parts->number > INT_MAX / 2)
        return error_set(error, ERROR_IO, "it is damaged");
    const struct row *row = catalog_find(&method_catalog, method);
    parts->method = method_from(row);
    if (!field_find(parts->text, "note", &parts->note))
        parts->note = TEXT("");
    if (!row)
        return error_set(error, ERROR_IO, "its method does not exist");
    if (!reader_scene(reader, parts->text, "scene", &parts->scene, &parts->places, error))
        return false;
    reader->session->setup.scene = parts->scene; /* events are read in it */
    return read_events(reader, parts->text, &parts->events, error);
}

/* Makes the run from its parts and rows and adds it to the session. Returns false with an error,
 * and leaves the session without the run. */
static bool read_run(struct reader *reader, const struct read_run *source, struct run_parts *parts,
                     struct error *why)
{
    struct session *session = reader->session;
    const int next = session->runs.next_number;
    const uint64_t next_id = session->runs.next_id;
    struct run *run = run_restore(&parts->scene, parts->method, parts->state, &parts->places,
                                  source->piece, source->pieces, why);
    if (!run || !session_add_run(session, run, why))
        return false;
    struct run_slot *slot = session->runs.slot[session->runs.count - 1];
    bool going = false;
    get_flag(parts->text, "going", &going);
    if (going) /* it was advancing, and can be continued */
        run->stop = STOP_CANCELLED;
    journal_release(slot->last);
    slot->last = NULL;
    slot->events = parts->events;
    slot->id = source->id;
    field_get(parts->text, "statement", &slot->statement, sizeof slot->statement);
    if (field_get(parts->text, "origin", slot->origin, sizeof slot->origin))
        reader_move(&parts->places, slot->origin, sizeof *slot->origin);
    run->number = parts->number;
    session->runs.next_number = next;
    session->runs.next_id = next_id;
    if (parts->note.len > 0)
        slot->note = strndup(parts->note.data, parts->note.len);
    const bool ok = add_all_asked(slot, &parts->places, parts->text, why);
    if (!ok)
        session_drop_run(session, session->runs.count - 1);
    return ok;
}

/* Adds the runs with these ids (8 bytes each), in this order, to the session. A run that cannot be
 * restored is left out with a note. */
void reader_runs(struct reader *reader, struct text ids)
{
    uint64_t id;
    for (; ids.len >= sizeof id; ids.data += sizeof id, ids.len -= sizeof id) {
        struct run_parts parts = {.number = 0};
        struct error why = {0};
        bool left_out = false;
        memcpy(&id, ids.data, sizeof id);
        struct read_run *source = reader_run(reader, id);
        if (source)
            get_flag(source->content, "left_out", &left_out);
        if (!source || source->content.len == 0)
            error_set(&why, ERROR_IO, "it is damaged");
        else if (read_parts(reader, source, &parts, &why) && read_run(reader, source, &parts, &why))
            continue;
        if (left_out)
            error_set(&why, ERROR_IO, "there was no room for its rows");
        reader_note(reader, "run %d is left out: %s", parts.number, why.text);
    }
}

/* ---- recordings ---- */

/* Finds the bytes that the file has under that checksum. */
bool reader_bytes(const struct reader *reader, uint64_t sum, struct text *content)
{
    uint64_t stored_sum;
    for (size_t i = 0; i < reader->records; i++)
        if (reader->record[i].kind == RECORD_BYTES &&
            field_get(reader->record[i].content, "sum", &stored_sum, sizeof stored_sum) &&
            stored_sum == sum && field_find(reader->record[i].content, "content", content))
            return true;
    return false;
}

/* Accepts any file name, for folder_open(). */
static bool any_name(const char *name)
{
    (void)name;
    return true;
}

/* Writes the content to a file with the last component of path as its name, in a new folder within
 * `temporary` (/tmp if NULL or empty). Returns its path, which the caller frees, or NULL on
 * failure. The caller removes the folder by folder_abandon(). */
static char *put_file(const char *temporary, struct text path, struct text content,
                      struct folder *folder)
{
    const struct write_policy policy = {.force = true, .secret = true};
    struct buffer file_path = {0}, name = {0};
    struct error ignored;
    size_t begin = path.len;
    while (begin > 0 && path.data[begin - 1] != '/')
        begin--;
    buffer_format(&file_path, "%s/hooke-%ld", temporary && *temporary ? temporary : "/tmp",
                  (long)getpid());
    buffer_put(&name, text_after(path, begin));
    bool ok = !file_path.failed && !name.failed &&
              folder_open(folder, file_path.data, policy, any_name, &ignored);
    if (ok && !folder_put(folder, name.data, content, &ignored)) {
        folder_abandon(folder);
        ok = false;
    }
    const size_t up_to = ok ? (size_t)(folder->writer.base - folder->writer.path) : 0;
    buffer_clear(&file_path);
    if (ok)
        buffer_format(&file_path, "%.*s%s/%s", (int)up_to, folder->writer.path,
                      folder->writer.temporary, name.data);
    buffer_free(&name);
    if (ok && !file_path.failed)
        return file_path.data;
    if (ok)
        folder_abandon(folder);
    buffer_free(&file_path);
    return NULL;
}

/* Executes `load` for a path with options. Returns false with an error. */
static bool reader_recording_load(struct reader *reader, struct text path, struct text options,
                                  struct error *error)
{
    struct buffer line = {0};
    buffer_put(&line, TEXT("load "));
    buffer_word(&line, path);
    buffer_put(&line, options);
    const int old_count = reader->session->recordings;
    const bool ok = reader_execute(reader, buffer_text(&line), error);
    buffer_free(&line);
    return ok && (reader->session->recordings == old_count + 1 ||
                  error_set(error, ERROR_IO, "it has another name now"));
}

/* Loads a recording from the bytes in the session file, or if these are missing from its original
 * path with a note that it may have changed. Returns false with an error. */
static bool load_kept(struct reader *reader, struct text text, struct text path,
                      struct error *error)
{
    struct text options, content, name;
    struct folder folder;
    uint64_t sum = 0;
    if (!field_find(text, "options", &options) || !field_find(text, "name", &name))
        return error_set(error, ERROR_IO, "it is damaged");
    field_get(text, "sum", &sum, sizeof sum);
    if (!reader_bytes(reader, sum, &content)) {
        if (!reader_recording_load(reader, path, options, error))
            return false;
        reader_note(reader, "recording %.*s was read again from its file, which may have changed",
                    (int)name.len, name.data);
        return true;
    }
    char *file = put_file(reader->temporary, path, content, &folder);
    bool ok = file ? reader_recording_load(reader, text_of(file), options, error)
                   : error_set(error, ERROR_IO, "there is no room for it in the folder TMPDIR");
    if (file)
        folder_abandon(&folder);
    free(file);
    if (!ok)
        return false;
    struct recording_slot *slot = reader->session->recording[reader->session->recordings - 1];
    struct recording *recording = slot->recording;
    char *copy = arena_text(&recording->arena, path);
    if (copy)
        recording->path = copy;
    slot->sum = sum;
    buffer_put(&slot->content, content);
    return copy && !slot->content.failed ? true : error_memory(error);
}

/* Restores a recording with its statement, window and other fields, except for window and fields if
 * the file that was read has another number of rows. Returns false with an error. */
static bool read_recording(struct reader *reader, struct text text, struct error *error)
{
    struct session *session = reader->session;
    struct text path;
    bool cleaned = false;
    size_t rows = 0;
    if (!field_find(text, "path", &path))
        return error_set(error, ERROR_IO, "it is damaged");
    if (!load_kept(reader, text, path, error))
        return false;
    struct recording_slot *slot = session->recording[session->recordings - 1];
    struct recording *recording = slot->recording;
    field_get(text, "statement", &slot->statement, sizeof slot->statement);
    field_get(text, "rows", &rows, sizeof rows);
    if (recording->rows != rows)
        return true; /* another file: its window and the like are not this one's */
    get_flag(text, "cleaned", &cleaned);
    if (cleaned && !reader_execute(reader, TEXT("data clean apply"), error))
        return false;
    const double window[2] = {recording->window[0], recording->window[1]};
    for (int i = 0; i < RECORDING_FIELDS; i++)
        fields_get_known(text, &recording_fields[i].field, 1, recording);
    if (recording->window[0] > recording->window[1])
        memcpy(recording->window, window, sizeof window);
    return true;
}

/* Adds the recordings of the state to the session. A recording that cannot be restored is left out
 * with a note. */
void reader_recordings(struct reader *reader)
{
    struct text text = reader->state, name, value;
    while (field_next(&text, &name, &value)) {
        struct error why = {0};
        struct text called = TEXT("");
        if (!text_is(name, "recording") || read_recording(reader, value, &why))
            continue;
        field_find(value, "name", &called);
        reader_note(reader, "recording %.*s is left out: %s", (int)called.len, called.data,
                    why.text);
    }
}
