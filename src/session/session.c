/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The session: creating and freeing it, its lists of runs and recordings, results by name, and what
 * follows from its settings. */
#include <hooke/session.h>
#include <hooke/run.h>
#include <hooke/method.h>
#include <hooke/result.h>
#include <hooke/figure.h>
#include <hooke/base/file.h>
#include <hooke/data.h>
#include <hooke/base/number.h>
#include <hooke/base/numeric.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Creates a session with the defaults of a new one. Returns NULL if out of memory. */
struct session *session_create(const struct front *front)
{
    /* A block that large is pages of the system, which are zero and cost nothing until they are
     * touched; a smaller one would be cleared. */
    static const size_t pages_min = 1 << 18;
    struct session *session = calloc(1, sizeof *session < pages_min ? pages_min : sizeof *session);
    struct error ignored;
    if (!session)
        return NULL;
    session->front = *front;
    session->parts = calloc(1, sizeof *session->parts);
    if (!session->parts || !(session->definitions.models = typed_create(&ignored))) {
        free(session->parts);
        free(session);
        return NULL;
    }
    scene_init(&session->setup.scene, NULL);
    session_unset_method(&session->setup);
    session_default_settings(&session->setup.settings);
    session->runs.current = session->current_recording = -1;
    session->runs.next_number = 1;
    session->transcript.fd = -1;
    session->live.speed = 1;
    session->view = (struct view){.x = {NAN, NAN},
                                  .y = {NAN, NAN},
                                  .trail = VIEW_TRAIL_PERIODS,
                                  .paging = true,
                                  .cursors = {.periods = NAN}};
    return session;
}

/* Frees the session with all that it owns; NULL is allowed. */
void session_destroy(struct session *session)
{
    if (!session)
        return;
    session_free_parts(session);
    free(session->execution.meant);
    undo_clear(session);
    arena_reset(&session->execution.leftover);
    for (int i = 0; i < session->undo.checkpoints; i++)
        snapshot_free(session->undo.checkpoint[i]);
    while (session->runs.count > 0)
        session_drop_run(session, session->runs.count - 1);
    while (session->recordings > 0)
        session_drop_recording(session, session->recordings - 1);
    history_free(session);
    free(session->measurement);
    table_store_free(&session->studies.found);
    log_clear(&session->log);
    typed_destroy(session->definitions.models);
    events_destroy(session->definitions.events);
    free(session);
}

void session_changed(struct session *session)
{
    session->changes++;
    session->view.paging = session->setup.settings.view == VIEW_PAGE;
}

/* Restores the method of a new session, as not chosen by the user. */
void session_unset_method(struct setup *setup)
{
    setup->method = method_find("euler");
    setup->drag = DRAG_DEFAULT;
    setup->method_chosen = setup->fixed = false;
}

/* ---- runs and recordings ---- */

/* Gives up one owner; the last one frees the run. */
void run_slot_release(struct run_slot *slot)
{
    if (--slot->references > 0)
        return;
    run_unmark(slot);
    run_destroy(slot->run);
    journal_release(slot->last);
    free(slot->note);
    free(slot);
}

/* Gives up one owner; the last one frees the recording. */
void recording_slot_release(struct recording_slot *slot)
{
    if (--slot->references > 0)
        return;
    recording_destroy(slot->recording);
    free(slot->options);
    buffer_free(&slot->content);
    free(slot);
}

/* Makes the run the current one. On failure the run is destroyed, and false is returned with the
 * error set. */
bool session_add_run(struct session *session, struct run *run, struct error *error)
{
    struct run_slot *slot = NULL;
    if (session->runs.count == LIMIT_RUNS) {
        error_set(error, ERROR_COMMAND, "there are already %d runs", LIMIT_RUNS);
        error_hint(error, "delete some: drop N.. or drop all");
    } else if (!(slot = calloc(1, sizeof *slot))) {
        error_memory(error);
    } else {
        *slot = (struct run_slot){.run = run,
                                  .references = 1,
                                  .statement = session->history.count,
                                  .id = session->runs.next_id++};
        memcpy(slot->origin, session->setup.origin, sizeof slot->origin);
        run->cancel = session->front.cancel;
        /* a run that comes from a study has made steps already, which the journal has to know */
        const double t0 = run->system.t0,
                     t = run->stop == STOP_END ? run->t : copysign(T_UNREACHABLE, run->t - t0);
        if (run->steps > 0 &&
            !journal_add(
                slot, (struct request){.kind = REQUEST_GO, .from_t = t0, .t = t, .end = INT64_MAX},
                TEXT(""), error)) {
            free(slot);
            slot = NULL;
        }
    }
    if (!slot) {
        run_destroy(run);
        return false;
    }
    run->number = session->runs.next_number++;
    session->view.overlays = 0; /* a new run stands alone */
    session->runs.slot[session->runs.count] = slot;
    session->runs.current = session->runs.count++;
    session->data_is_latest = false;
    session_changed(session);
    return true;
}

/* Makes the recording the current one. On failure it is destroyed, and false is returned with the
 * error set. */
bool session_add_recording(struct session *session, struct recording *recording,
                           const char *options, struct error *error)
{
    struct recording_slot *slot = NULL;
    char *copy = NULL;
    if (session->recordings == LIMIT_RECORDINGS) {
        error_set(error, ERROR_COMMAND, "there are already %d recordings", LIMIT_RECORDINGS);
        error_hint(error, "delete one: data drop NAME");
    } else if (!(slot = calloc(1, sizeof *slot)) || !(copy = strdup(options))) {
        error_memory(error);
    }
    if (!copy) {
        free(slot);
        recording_destroy(recording);
        return false;
    }
    *slot = (struct recording_slot){.recording = recording,
                                    .references = 1,
                                    .options = copy,
                                    .statement = session->history.count};
    session->recording[session->recordings] = slot;
    session->current_recording = session->recordings++;
    session->data_is_latest = true;
    session_changed(session);
    return true;
}

/* Returns the index of the current item after item `dropped` was removed from a list that has count
 * items left; the last item becomes current if the current one was removed. */
static int index_after_drop(int current, int dropped, int count)
{
    if (current > dropped)
        return current - 1;
    return current == dropped ? count - 1 : current;
}

/* Removes a run from the list; undo may still own it. */
void session_drop_run(struct session *session, int index)
{
    run_slot_release(session->runs.slot[index]);
    session->runs.count--;
    memmove(&session->runs.slot[index], &session->runs.slot[index + 1],
            (size_t)(session->runs.count - index) * sizeof(session->runs.slot[0]));
    session->runs.current = index_after_drop(session->runs.current, index, session->runs.count);
    session_changed(session);
}

/* Removes a recording from the list; undo may still own it. */
void session_drop_recording(struct session *session, int index)
{
    recording_slot_release(session->recording[index]);
    session->recordings--;
    memmove(&session->recording[index], &session->recording[index + 1],
            (size_t)(session->recordings - index) * sizeof(session->recording[0]));
    session->current_recording =
        index_after_drop(session->current_recording, index, session->recordings);
    session_changed(session);
}

/* Returns the index of a run by number or name, or -1. */
int session_find_run(const struct session *session, struct text name)
{
    double number;
    const bool numeric = real_parse(name, &number) == REAL_OK;
    for (int i = 0; i < session->runs.count; i++) {
        const struct run *run = session->runs.slot[i]->run;
        if ((numeric && number == run->number) || (name.len > 0 && text_is(name, run->name)))
            return i;
    }
    return -1;
}

int session_find_recording(const struct session *session, struct text name)
{
    for (int i = 0; i < session->recordings; i++)
        if (text_is(name, session->recording[i]->recording->name))
            return i;
    return -1;
}

/* ---- results ---- */

/* Sets the result of that name and moves it to the end of the list, so that the oldest is the
 * first. */
void session_set_result(struct session *session, const char *name, struct measured value,
                        enum quantity quantity)
{
    struct named_value *value_list = session->results.value, *result;
    int replaced = 0;
    while (replaced < session->results.count && strcmp(value_list[replaced].name, name) != 0)
        replaced++;
    if (replaced == session->results.count && replaced == LIMIT_RESULTS)
        replaced = 0; /* the oldest: the newest is always the last */
    if (replaced < session->results.count)
        memmove(value_list + replaced, value_list + replaced + 1,
                (size_t)(--session->results.count - replaced) * sizeof *value_list);
    result = &value_list[session->results.count++];
    *result = (struct named_value){
        .value = value.value, .uncertainty = value.uncertainty, .quantity = quantity};
    snprintf(result->name, sizeof result->name, "%s", name);
}

/* Records the statement as the origin of parameters that differ from the previous scene. */
void session_trace(struct session *session, const struct scene *previous, size_t statement)
{
    const struct scene *scene = &session->setup.scene;
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        if (scene->model != previous->model || scene->chosen[i] != previous->chosen[i] ||
            memcmp(&scene->value[i], &previous->value[i], sizeof scene->value[i]) != 0 ||
            scene->uncertainty[i] != previous->uncertainty[i])
            session->setup.origin[i] = (uint32_t)statement;
}

/* ---- what follows from the settings and the front end ---- */

/* Returns the rules for writing files that the options of the program ask for. */
struct write_policy session_policy(const struct session *session, bool force)
{
    return (struct write_policy){.force = force,
                                 .confine = session->options.safe,
                                 .refuse = session->options.checking != NULL};
}

/* Returns the first step [s] of adaptive methods: the setting dt if it was set, else the scene's
 * own. */
double session_first_step(const struct session *session)
{
    const struct settings *settings = &session->setup.settings;
    const double first = session->setup.scene.preset->first;
    return settings->dt_chosen || !(first > 0) ? settings->dt : first;
}

/* Returns the settings of a new run; tol is 0 unless the method adapts its steps. */
struct run_settings session_run_settings(const struct session *session)
{
    const struct settings *settings = &session->setup.settings;
    const bool adaptive = (session->setup.method->flags & METHOD_ADAPTIVE) && !session->setup.fixed;
    const double tol = adaptive ? settings->tol : 0;
    return (struct run_settings){.dt = adaptive && settings->tol > 0 ? session_first_step(session)
                                                                     : settings->dt,
                                 .tol = tol,
                                 .drag = session->setup.drag,
                                 .kernel = (enum kernel)settings->kernel,
                                 .compensated = settings->sums == SUMS_COMPENSATED,
                                 .record = settings->record};
}

/* Returns the characters for plots: those of the setting, or braille or ASCII by the terminal if it
 * is auto. */
const struct charset *session_charset(const struct session *session)
{
    const struct charset_choice *choice =
        (const void *)catalog_row(&charset_choice_catalog, (size_t)session->setup.settings.charset);
    if (choice->charset)
        return choice->charset;
    return session->front.utf8 ? &charset_braille : &charset_ascii;
}

/* Sets the size [cell] of plots: the setting, else the screen, else 80x24. */
void session_size(const struct session *session, int *width, int *height)
{
    const struct settings *settings = &session->setup.settings;
    if (settings->width)
        *width = settings->width;
    else
        *width = session->front.width ? session->front.width : 80;
    if (settings->height)
        *height = settings->height;
    else
        *height = session->front.height ? session->front.height : 24;
}

/* ---- text for people ---- */

/* Appends scene, parameters that matter, method, and the time of the current run. */
void session_state_line(const struct session *session, struct buffer *text)
{
    const struct setup *setup = &session->setup;
    buffer_put(text, text_of(setup->scene.preset->row.name));
    for (int i = 0; i < (int)scene_params(&setup->scene)->count; i++) {
        const struct param_row *param = param_at(&setup->scene, i);
        if (!param_matters(&setup->scene, i))
            continue;
        buffer_format(text, " %s=", param->row.name);
        buffer_measured(text, (struct measured){setup->scene.value[i], 0}, param->quantity, 4);
    }
    const struct run_settings settings = session_run_settings(session);
    buffer_format(text, " | %s %s=", setup->method->row.name, settings.tol > 0 ? "tol" : "dt");
    if (settings.tol > 0)
        buffer_short(text, settings.tol, 4);
    else
        buffer_measured(text, (struct measured){settings.dt, 0}, QUANTITY_TIME, 4);
    const struct run *run = session_run(session);
    if (run) {
        buffer_format(text, " | run %d t=", run->number);
        buffer_measured(text, (struct measured){run->t, 0}, QUANTITY_TIME, 4);
    }
}
