/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Writes the records of state of a session file, and scenes and events, which runs have, too. The
 * set-up is stored as the commands that recreate it, as `save` writes them. State without a command
 * is described by tables with bounds, which reading checks, because a file with valid checksums may
 * still come from anybody.
 */
#include <hooke/data.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/module.h>
#include "modules/resume/store/reading.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* ---- tables ---- */

#define CALLED(name, member, least, most) FIELD_CALLED(name, struct session, member, least, most)
const struct field store_session[] = {
    CALLED("current_run", runs.current, -1, LIMIT_RUNS - 1),
    CALLED("next_run", runs.next_number, 0, 0),
    CALLED("next_id", runs.next_id, 0, 0x1p62),
    CALLED("said_method", execution.said_method, 0, 0),
    CALLED("said_assumed", execution.said_assumed, 0, 0),
    CALLED("current_recording", current_recording, -1, LIMIT_RECORDINGS - 1),
    CALLED("data_is_latest", data_is_latest, 0, 0),
    CALLED("studied_runs", studies.at_run, 0, 0),
    CALLED("speed", live.speed, DBL_TRUE_MIN, INFINITY),
    CALLED("origin", setup.origin, 0, 0),
};
const size_t store_session_count = COUNT_OF(store_session);

#define IN_VIEW(member, least, most) FIELD_IN(struct view, member, least, most)
#define OF_VIEW(member) FIELD_OF(struct view, member)
#define OF_CURSOR(i)                                                                               \
    OF_VIEW(cursors.cursor[i].set), OF_VIEW(cursors.cursor[i].t),                                  \
        OF_VIEW(cursors.cursor[i].t_uncertainty), OF_VIEW(cursors.cursor[i].y),                    \
        IN_VIEW(cursors.cursor[i].crossing, 0, INT_MAX / 2), OF_VIEW(cursors.cursor[i].amplitude)
const struct field store_view[] = {
    IN_VIEW(layout, 0, LAYOUT_LOG),
    OF_VIEW(full),
    OF_VIEW(x),
    OF_VIEW(y),
    IN_VIEW(window, 0, DBL_MAX),
    IN_VIEW(trail, 0, INFINITY),
    OF_VIEW(overlay),
    IN_VIEW(overlays, 0, LIMIT_OVERLAY),
    OF_VIEW(cursors.shown),
    OF_VIEW(cursors.plane),
    OF_VIEW(cursors.point),
    OF_VIEW(cursors.on_data),
    IN_VIEW(cursors.active, 0, 1),
    OF_VIEW(cursors.locked),
    OF_CURSOR(0),
    OF_CURSOR(1),
    IN_VIEW(cursors.snap, SNAP_CROSSING, SNAP_NONE),
    OF_VIEW(cursors.periods),
    OF_VIEW(cursors.subject),
    OF_VIEW(cursors.samples),
    FIELD_OF_QUANTITY(struct view, cursors.quantity),
    FIELD_CALLED_AS("start", struct view, start, FIELD_REALS, -DBL_MAX, DBL_MAX),
    IN_VIEW(starts, 0, LIMIT_STARTS),
    IN_VIEW(start_n, 0, STARTS_VARIABLES),
};
const size_t store_view_count = COUNT_OF(store_view);

#define OF_REQUEST(member, least, most) FIELD_IN(struct request, member, least, most)
const struct field store_request[] = {
    OF_REQUEST(kind, REQUEST_GO, REQUEST_BACK),
    OF_REQUEST(param, 0, INT_MAX / 2),
    OF_REQUEST(by_event, 0, 0),
    OF_REQUEST(start_step, 0, INFINITY),
    OF_REQUEST(end, 0, INFINITY),
    OF_REQUEST(met, 0, INFINITY),
    OF_REQUEST(rows, 0, INFINITY),
    OF_REQUEST(from_t, -INFINITY, INFINITY),
    OF_REQUEST(t, -INFINITY, INFINITY),
    OF_REQUEST(value, 0, 0),
};
const size_t store_request_count = COUNT_OF(store_request);

#define OF_VALUE(member) FIELD_OF(struct named_value, member)
static const struct field named_value_members[] = {
    OF_VALUE(name),        OF_VALUE(value),
    OF_VALUE(uncertainty), FIELD_OF_QUANTITY(struct named_value, quantity),
    OF_VALUE(error_floor),
};

#define OF_MEASUREMENT(member) FIELD_OF(struct measurement, member)
static const struct field measurement_members[] = {
    OF_MEASUREMENT(quantity), ALL_END(struct measurement),
    OF_MEASUREMENT(value),    FIELD_OF_QUANTITY(struct measurement, unit),
    OF_MEASUREMENT(periods),  OF_MEASUREMENT(t),
    OF_MEASUREMENT(energy),   OF_MEASUREMENT(statement),
    OF_MEASUREMENT(source),
};

const struct store_array store_arrays[] = {
    STORE_ARRAY("result", struct session, results.value, results.count, LIMIT_RESULTS,
                named_value_members, NULL),
    STORE_ARRAY("measurement", struct session, measurement, measurements, 0, measurement_members,
                NULL),
};
const size_t store_array_count = COUNT_OF(store_arrays);

/* ---- scenes ---- */

/* Writes a scene as the field `name`. */
void store_put_scene(const struct scene *scene, const char *name, struct buffer *output)
{
    const size_t begun = field_begin(output, name), params = scene_params(scene)->count;
    const size_t script = field_begin(output, "script");
    scene_kind_script(scene, output);
    field_end(output, script);
    field_put_names(output, "names", scene_params(scene));
    field_put(output, "value", scene->value, params * sizeof *scene->value);
    field_put(output, "uncertainty", scene->uncertainty, params * sizeof *scene->uncertainty);
    field_put(output, "chosen", scene->chosen, params * sizeof *scene->chosen);
    field_put(output, "across", &scene->steps_across_kinks, sizeof scene->steps_across_kinks);
    field_put(output, "atol", scene->atol, sizeof scene->atol);
    field_end(output, begun);
}

void store_put_events(const struct events *events, struct buffer *output)
{
    const size_t begun = field_begin(output, "events");
    events_save(events, output);
    field_end(output, begun);
}

/* ---- recordings, lists, results ---- */

/* Appends what a recording is loaded from, and its fields. */
static void put_loaded(const struct recording_slot *slot, struct buffer *output)
{
    const struct recording *recording = slot->recording;
    char *path = realpath(recording->path, NULL);
    const size_t begun = field_begin(output, "recording");
    field_text(output, "name", text_of(recording->name));
    field_text(output, "path", text_of(path ? path : recording->path));
    field_text(output, "options", text_of(slot->options));
    field_put(output, "statement", &slot->statement, sizeof slot->statement);
    field_put(output, "sum", &slot->sum, sizeof slot->sum);
    field_put(output, "rows", &recording->rows, sizeof recording->rows);
    for (int i = 0; i < RECORDING_FIELDS; i++)
        fields_put(output, &recording_fields[i].field, 1, recording);
    field_end(output, begun);
    free(path);
}

/* Writes a field for each item of an array of `owner`. */
void store_put_array(const struct store_array *array, const void *owner, struct buffer *output)
{
    const char *cursor = (const char *)owner + array->offset;
    const int count = *(const int *)(const void *)((const char *)owner + array->count);
    if (array->max == 0)
        cursor = *(char *const *)(const void *)cursor;
    for (int k = 0; k < count; k++) {
        const size_t begun = field_begin(output, array->name);
        fields_put(output, array->member, array->members, cursor + (size_t)k * array->item);
        field_end(output, begun);
    }
}

/* Appends all tables of results as CSV, and which study was the last. */
static void put_tables(const struct session *session, struct buffer *output)
{
    for (int i = 0; i < session->studies.found.count; i++) {
        const struct stored_table *stored = session->studies.found.table[i];
        const size_t begun = field_begin(output, "table");
        field_text(output, "kind", text_of(stored->kind));
        const size_t text = field_begin(output, "csv");
        table_put(&stored->table, table_csv, output);
        field_end(output, text);
        field_end(output, begun);
    }
    if (session->studies.last)
        field_text(output, "studied", text_of(session->studies.last));
}

/* Writes the fields of the session's state. */
void store_put_state(const struct session *session, struct buffer *output)
{
    field_text(output, "version", text_of(HOOKE_VERSION));
    const size_t setup = field_begin(output, "setup");
    session_save_setup(session, output);
    field_end(output, setup);
    field_put_names(output, "names", scene_params(&session->setup.scene));
    fields_put(output, store_session, store_session_count, session);
    for (int i = 0; i < session->recordings; i++)
        put_loaded(session->recording[i], output);
    for (size_t i = 0; i < store_array_count; i++)
        store_put_array(&store_arrays[i], session, output);
    put_tables(session, output);
    for (int i = 0; i < session->parts->count; i++) {
        const struct session_part *part = &session->parts->item[i];
        if (part->module->store.put)
            part->module->store.put(part->state, output);
    }
    const size_t runs = field_begin(output, "runs");
    for (int i = 0; i < session->runs.count; i++)
        buffer_put(output, (struct text){(const char *)&session->runs.slot[i]->id,
                                         sizeof session->runs.slot[i]->id});
    field_end(output, runs);
    const size_t view = field_begin(output, "view");
    fields_put(output, store_view, store_view_count, &session->view);
    if (session->view.focus)
        field_text(output, "focus", text_of(session->view.focus->name));
    field_end(output, view);
}
