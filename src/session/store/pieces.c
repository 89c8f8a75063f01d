/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes, events, runs and recordings of a session file. */
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/read.h>

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* [s] of computing: what takes longer is not done again where its rows are damaged */
#define SECONDS_MAX 2.0

/* ---- scenes and events: made by the commands that made them ---- */

static struct made *find_made(struct reader *reader, struct text script, bool is_events)
{
    for (size_t i = 0; i < reader->mades; i++)
        if (reader->made[i].is_events == is_events && text_equal(reader->made[i].script, script))
            return &reader->made[i];
    return NULL;
}

static void add_made(struct reader *reader, struct made made)
{
    struct made *more =
        realloc(reader->made, (reader->mades + 1) * sizeof *more); /* few: one a scene */
    if (!more)
        return; /* it is made again then */
    reader->made = more;
    more[reader->mades++] = made;
}

void reader_made(struct reader *reader, struct text script, const struct scene *scene)
{
    add_made(reader, (struct made){script, scene->model, scene->preset, NULL, false});
}

static bool make(struct reader *reader, struct text script, struct scene *scene,
                 struct error *error)
{
    struct session *session = reader->session;
    const struct made *made = find_made(reader, script, false);
    if (made) {
        scene_init(scene, made->preset);
        scene->model = made->model;
        return true;
    }
    if (!reader->restorer->execute(reader->restorer->context, session, script, error))
        return false;
    *scene = session->setup.scene;
    reader_made(reader, script, scene);
    return true;
}

/* Names what the file has of a scene and this program has not, once. */
static void note_unknown(struct reader *reader, struct text of, const struct field_places *places)
{
    struct text names;
    if (!field_find(of, "names", &names))
        return;
    for (int i = 0; i < places->count; i++) {
        const struct text name = text_of(names.at);
        char line[LIMIT_NAME + 64];
        snprintf(line, sizeof line, "the parameter %s is left out: this version has none",
                 names.at);
        if (places->row[i] < 0 && !strstr(buffer_view(reader->notes), line))
            reader_note(reader, "%s", line);
        names = (struct text){name.at + name.len + 1, names.len - name.len - 1};
    }
}

bool reader_scene(struct reader *reader, struct text in, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error)
{
    struct field_places found;
    struct text of, script;
    if (!field_find(in, name, &of) || !field_find(of, "script", &script))
        return error_set(error, ERROR_IO, "it has no scene");
    if (!make(reader, script, scene, error))
        return false;
    struct scene read = *scene;
    if (!reader_places(of, scene, &found) ||
        !field_get_placed(of, "value", &found, read.value, sizeof *read.value) ||
        !field_get_placed(of, "uncertainty", &found, read.uncertainty, sizeof *read.uncertainty) ||
        !field_get_placed(of, "chosen", &found, read.chosen, sizeof *read.chosen) ||
        !field_get(of, "across", &read.across, sizeof read.across) ||
        !field_get(of, "atol", read.atol, sizeof read.atol))
        return error_set(error, ERROR_IO, "its scene has other parameters in this version");
    if (!sound_scene(&read))
        return error_set(error, ERROR_IO, "its scene has values that no scene can have");
    note_unknown(reader, of, &found);
    if (places)
        *places = found;
    *scene = read;
    return true;
}

bool reader_events(struct reader *reader, struct text in, const struct events **events,
                   struct error *error)
{
    struct session *session = reader->session;
    struct text script;
    *events = NULL;
    if (!field_find(in, "events", &script) || script.len == 0)
        return true;
    const struct made *made = find_made(reader, script, true);
    session->setup.events = NULL;
    if (!made && !reader->restorer->execute(reader->restorer->context, session, script, error))
        return false;
    *events = made ? made->events : session->setup.events;
    if (!made)
        add_made(reader, (struct made){script, NULL, NULL, *events, true});
    return true;
}

/* ---- runs ---- */

static void get_flag(struct text in, const char *name, bool *flag)
{
    fields_get(in, &(struct field){name, 0, sizeof *flag, FIELD_BOOLS, 0, 0}, 1, flag);
}

/* What was asked of it, in order; false: damaged, or no memory. */
static bool add_asked(struct run_slot *slot, const struct field_places *places, struct text in,
                      struct error *error)
{
    const struct scene *scene = &slot->run->scene;
    while (in.len > 0) {
        struct asked asked;
        struct text condition = TEXT("");
        if (in.len < sizeof asked)
            return error_set(error, ERROR_IO, "what was asked of it is damaged");
        memcpy(&asked, in.at, sizeof asked);
        in = (struct text){in.at + sizeof asked, in.len - sizeof asked};
        if (asked.conditioned) {
            const char *end = memchr(in.at, 0, in.len);
            if (!end)
                return error_set(error, ERROR_IO, "what was asked of it is damaged");
            condition = (struct text){in.at, (size_t)(end - in.at)};
            in = (struct text){end + 1, in.len - condition.len - 1};
        }
        if (asked.kind == REQUEST_SET && asked.param >= 0 && asked.param < places->count)
            asked.param = places->row[asked.param];
        const struct request request = {.kind = (enum request_kind)asked.kind,
                                        .param = asked.param,
                                        .by_event = asked.by_event,
                                        .from = asked.from,
                                        .end = asked.end,
                                        .met = asked.met,
                                        .rows = asked.rows,
                                        .from_t = asked.from_t,
                                        .t = asked.t,
                                        .value = asked.value};
        if (!sound_asked(&asked, scene))
            return error_set(error, ERROR_IO, "what was asked of it is damaged");
        if (!journal_add(slot, request, condition, error))
            return false;
    }
    return true;
}

/* The run by what was asked of it, where its rows cannot be had. */
static struct run *compute(struct reader *reader, struct text state, const struct scene *scene,
                           const struct method *method, struct error *why)
{
    struct run_settings settings;
    double seconds;
    struct error error;
    (void)reader;
    if (!run_settings_take(state, &settings) ||
        !field_get(state, "seconds", &seconds, sizeof seconds) || seconds >= SECONDS_MAX)
        return NULL;
    struct run *run = run_create(scene, method, &settings, HUGE_VAL, &error);
    if (!run)
        *why = error;
    return run;
}

static bool replay(struct reader *reader, struct run_slot *slot, struct text state)
{
    struct request *last = slot->last;
    static const struct field name[] = {FIELD_OF(struct run, name)},
                              stop[] = {FIELD_IN(struct run, stop, STOP_NONE, STOP_GIVEN_UP)};
    int64_t steps;
    double t;
    if (!field_get(state, "steps", &steps, sizeof steps) || !field_get(state, "t", &t, sizeof t) ||
        !fields_get(state, name, 1, slot->run) || steps < 0)
        return false;
    slot->last = NULL;
    const bool ok = journal_restore(reader->session, slot, last, steps, t);
    journal_release(last);
    fields_get(state, stop, 1, slot->run);
    return ok && slot->run->steps == steps && slot->run->t == t;
}

struct run_parts {
    struct text in, state, asked, note;
    struct scene scene;
    struct field_places places;
    const struct events *events;
    const struct method *method;
    int number;
};

static bool read_parts(struct reader *reader, const struct read_run *of, struct run_parts *parts,
                       struct error *error)
{
    struct text method;
    parts->in = of->content;
    if (!field_get(parts->in, "number", &parts->number, sizeof parts->number) ||
        !field_find(parts->in, "state", &parts->state) ||
        !field_find(parts->in, "asked", &parts->asked) ||
        !field_find(parts->in, "method", &method) || parts->number < 1 ||
        parts->number > INT_MAX / 2)
        return error_set(error, ERROR_IO, "it is damaged");
    const struct row *row = catalog_find(&method_catalog, method);
    parts->method = (const struct method *)(const void *)row;
    if (!field_find(parts->in, "note", &parts->note))
        parts->note = TEXT("");
    if (!row)
        return error_set(error, ERROR_IO, "its method is not there");
    if (!reader_scene(reader, parts->in, "scene", &parts->scene, &parts->places, error))
        return false;
    reader->session->setup.scene = parts->scene; /* events are read in it */
    return reader_events(reader, parts->in, &parts->events, error);
}

/* *why: it had to be computed, or is left out. */
static bool read_run(struct reader *reader, const struct read_run *of, struct run_parts *parts,
                     struct error *why)
{
    struct session *session = reader->session;
    struct error error = {0};
    const int next = session->next_run;
    const uint64_t next_id = session->next_id;
    bool computed = false;
    struct run *run = run_restore(&parts->scene, parts->method, parts->state, &parts->places,
                                  of->piece, of->pieces, why);
    if (!run && (run = compute(reader, parts->state, &parts->scene, parts->method, why)))
        computed = true;
    if (!run)
        return false;
    if (!session_add_run(session, run, &error)) {
        *why = error;
        return false;
    }
    struct run_slot *slot = session->run[session->runs - 1];
    bool going = false;
    get_flag(parts->in, "going", &going);
    if (going) /* it was on its way, and can go on */
        run->stop = STOP_CANCELLED;
    journal_release(slot->last);
    slot->last = NULL;
    slot->events = parts->events;
    slot->id = of->id;
    field_get(parts->in, "statement", &slot->statement, sizeof slot->statement);
    if (field_get(parts->in, "origin", slot->origin, sizeof slot->origin))
        reader_move(&parts->places, slot->origin, sizeof *slot->origin);
    run->number = parts->number;
    session->next_run = next;
    session->next_id = next_id;
    if (parts->note.len > 0)
        slot->note = strndup(parts->note.at, parts->note.len);
    bool ok = add_asked(slot, &parts->places, parts->asked, why) &&
              (!computed || replay(reader, slot, parts->state));
    if (!ok)
        session_drop_run(session, session->runs - 1);
    else if (computed)
        reader_note(reader, "run %d was computed again: %s", parts->number, why->text);
    return ok;
}

void reader_runs(struct reader *reader, struct text ids)
{
    uint64_t id;
    for (; ids.len >= sizeof id; ids.at += sizeof id, ids.len -= sizeof id) {
        struct run_parts parts = {.number = 0};
        struct error why = {0};
        bool left_out = false;
        memcpy(&id, ids.at, sizeof id);
        struct read_run *of = reader_run(reader, id);
        if (of)
            get_flag(of->content, "left_out", &left_out);
        if (!of || of->content.len == 0)
            error_set(&why, ERROR_IO, "it is damaged");
        else if (read_parts(reader, of, &parts, &why) && read_run(reader, of, &parts, &why))
            continue;
        if (left_out)
            error_set(&why, ERROR_IO, "there was no room for its rows");
        reader_note(reader, "run %d is left out: %s", parts.number, why.text);
    }
}

/* ---- recordings ---- */

bool reader_bytes(const struct reader *reader, uint64_t sum, struct text *content)
{
    uint64_t of;
    for (size_t i = 0; i < reader->records; i++)
        if (reader->record[i].kind == RECORD_BYTES &&
            field_get(reader->record[i].content, "sum", &of, sizeof of) && of == sum &&
            field_find(reader->record[i].content, "content", content))
            return true;
    return false;
}

static bool any_name(const char *name)
{
    (void)name;
    return true;
}

/* The bytes in a file of the same name, in a folder of its own. Caller frees; NULL: no room. */
static char *put_file(const char *temporary, struct text path, struct text content,
                      struct folder *folder)
{
    const struct write_policy policy = {.force = true, .secret = true};
    struct buffer at = {0}, name = {0};
    struct error ignored;
    size_t begin = path.len;
    while (begin > 0 && path.at[begin - 1] != '/')
        begin--;
    buffer_format(&at, "%s/hooke-%ld", temporary && *temporary ? temporary : "/tmp",
                  (long)getpid());
    buffer_put(&name, (struct text){path.at + begin, path.len - begin});
    bool ok =
        !at.failed && !name.failed && folder_open(folder, at.data, policy, any_name, &ignored);
    if (ok && !folder_put(folder, name.data, content, &ignored)) {
        folder_abandon(folder);
        ok = false;
    }
    const size_t up_to = ok ? (size_t)(folder->at.base - folder->at.path) : 0;
    buffer_clear(&at);
    if (ok)
        buffer_format(&at, "%.*s%s/%s", (int)up_to, folder->at.path, folder->at.temporary,
                      name.data);
    buffer_free(&name);
    if (ok && !at.failed)
        return at.data;
    if (ok)
        folder_abandon(folder);
    buffer_free(&at);
    return NULL;
}

static bool load(struct reader *reader, struct text path, struct text options, struct error *error)
{
    struct buffer line = {0};
    buffer_put(&line, TEXT("load "));
    buffer_word(&line, path);
    buffer_put(&line, options);
    const int before = reader->session->recordings;
    const bool ok = reader->restorer->execute(reader->restorer->context, reader->session,
                                              buffer_text(&line), error);
    buffer_free(&line);
    return ok && (reader->session->recordings == before + 1 ||
                  error_set(error, ERROR_IO, "it has another name now"));
}

/* From the session file, or from where it was: then it may be another. */
static bool load_kept(struct reader *reader, struct text in, struct text path, struct error *error)
{
    struct text options, content, name;
    struct folder folder;
    uint64_t sum = 0;
    if (!field_find(in, "options", &options) || !field_find(in, "name", &name))
        return error_set(error, ERROR_IO, "it is damaged");
    field_get(in, "sum", &sum, sizeof sum);
    if (!reader_bytes(reader, sum, &content)) {
        if (!load(reader, path, options, error))
            return false;
        reader_note(reader, "recording %.*s was read again from its file, which may have changed",
                    (int)name.len, name.at);
        return true;
    }
    char *file = put_file(reader->restorer->temporary, path, content, &folder);
    bool ok = file ? load(reader, text_of(file), options, error)
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

/* Until November 2026 they were counted: field0 to field4. */
static bool find_recording_field(struct text in, int i, struct text *value)
{
    char counted[] = "field0";
    counted[5] = (char)('0' + i);
    return field_find(in, recording_fields[i].name, value) || field_find(in, counted, value);
}

static bool read_recording(struct reader *reader, struct text in, struct error *error)
{
    struct session *session = reader->session;
    struct text path;
    bool cleaned = false;
    size_t rows = 0;
    if (!field_find(in, "path", &path))
        return error_set(error, ERROR_IO, "it is damaged");
    if (!load_kept(reader, in, path, error))
        return false;
    struct recording *recording = session->recording[session->recordings - 1]->recording;
    field_get(in, "rows", &rows, sizeof rows);
    if (recording->rows != rows)
        return true; /* another file: its window and the like are not this one's */
    for (int i = 0; i < RECORDING_FIELDS; i++) {
        struct text value;
        if (!find_recording_field(in, i, &value) || value.len != recording_fields[i].bytes)
            continue;
        if (recording_fields[i].offset == offsetof(struct recording, cleaned))
            cleaned = value.at[0] == 1;
    }
    if (cleaned && !reader->restorer->execute(reader->restorer->context, session,
                                              TEXT("data clean apply"), error))
        return false;
    for (int i = 0; i < RECORDING_FIELDS; i++) {
        struct text value;
        if (find_recording_field(in, i, &value) && sound_field(&recording_fields[i], value))
            memcpy((char *)recording + recording_fields[i].offset, value.at, value.len);
    }
    return true;
}

void reader_recordings(struct reader *reader)
{
    struct text in = reader->state, name, value;
    while (field_next(&in, &name, &value)) {
        struct error why = {0};
        struct text called = TEXT("");
        if (!text_is(name, "recording") || read_recording(reader, value, &why))
            continue;
        field_find(value, "name", &called);
        reader_note(reader, "recording %.*s is left out: %s", (int)called.len, called.at, why.text);
    }
}
