/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The session: its runs, recordings and results. */
#include <hooke/base/numeric.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct session *session_create(const struct front *front)
{
    struct session *session = calloc(1, sizeof *session);
    struct error ignored;
    if (!session)
        return NULL;
    session->front = *front;
    session->parts = calloc(1, sizeof *session->parts);
    if (!session->parts || !(session->models = typed_create(&ignored))) {
        free(session->parts);
        free(session);
        return NULL;
    }
    scene_init(&session->setup.scene, NULL);
    session_unset_method(&session->setup);
    session_default_settings(&session->setup.settings);
    session->current_run = session->current_recording = -1;
    session->next_run = 1;
    session->record_fd = -1;
    session->live.speed = 1;
    session->view = (struct view){.x = {NAN, NAN},
                                  .y = {NAN, NAN},
                                  .trail = VIEW_TRAIL_PERIODS,
                                  .paging = true,
                                  .cursors = {.periods = NAN}};
    return session;
}

void session_forget_sweep(struct session *session)
{
    if (!session->stopped)
        return;
    free(session->stopped->statement);
    buffer_free(&session->stopped->made);
    sweep_free(&session->stopped->found);
    free(session->stopped);
    session->stopped = NULL;
}

void session_destroy(struct session *session)
{
    if (!session)
        return;
    session_forget_sweep(session);
    session_free_parts(session);
    free(session->meant);
    undo_clear(session);
    arena_reset(&session->leftover);
    for (int i = 0; i < session->checkpoints; i++)
        snapshot_free(session->checkpoint[i]);
    while (session->runs > 0)
        session_drop_run(session, session->runs - 1);
    while (session->recordings > 0)
        session_drop_recording(session, session->recordings - 1);
    history_free(session);
    if (session->lesson)
        buffer_free(&session->lesson->text);
    free(session->lesson);
    free(session->measurement);
    free(session->stored_fit);
    free(session->fit_curve[0]);
    free(session->fit_curve[1]);
    session_drop_band(session);
    if (session->precision)
        precision_free(session->precision);
    free(session->precision);
    table_store_free(&session->found);
    references_free(&session->references);
    log_clear(&session->log);
    typed_destroy(session->models);
    events_destroy(session->events);
    free(session);
}

void session_changed(struct session *session)
{
    session->changes++;
    session->view.paging = session->setup.settings.view == VIEW_PAGE;
}

void session_unset_method(struct setup *setup)
{
    setup->method = method_find("euler");
    setup->drag = DRAG_DEFAULT;
    setup->method_chosen = setup->fixed = false;
}

/* ---- runs and recordings ---- */

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

void recording_slot_release(struct recording_slot *slot)
{
    if (--slot->references > 0)
        return;
    recording_destroy(slot->recording);
    free(slot->options);
    buffer_free(&slot->content);
    free(slot);
}

bool session_add_run(struct session *session, struct run *run, struct error *error)
{
    struct run_slot *slot = NULL;
    if (session->runs == LIMIT_RUNS) {
        error_set(error, ERROR_COMMAND, "%d runs are kept already", LIMIT_RUNS);
        error_hint(error, "drop some: drop N.. or drop all");
    } else if (!(slot = calloc(1, sizeof *slot))) {
        error_memory(error);
    } else {
        *slot = (struct run_slot){.run = run,
                                  .references = 1,
                                  .statement = session->history.count,
                                  .id = session->next_id++};
        memcpy(slot->origin, session->setup.origin, sizeof slot->origin);
        run->cancel = session->front.cancel;
        /* A run that comes from a study has been somewhere already. */
        const double t0 = run->system.t0,
                     t = run->stop == STOP_END ? run->t : copysign(FAR, run->t - t0);
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
    run->number = session->next_run++;
    session->view.overlays = 0; /* a new run stands alone */
    session->run[session->runs] = slot;
    session->current_run = session->runs++;
    session->data_is_latest = false;
    session_changed(session);
    return true;
}

bool session_add_recording(struct session *session, struct recording *recording,
                           const char *options, struct error *error)
{
    struct recording_slot *slot = NULL;
    char *copy = NULL;
    if (session->recordings == LIMIT_RECORDINGS) {
        error_set(error, ERROR_COMMAND, "%d recordings are kept already", LIMIT_RECORDINGS);
        error_hint(error, "drop one: data drop NAME");
    } else if (!(slot = calloc(1, sizeof *slot)) || !(copy = strdup(options))) {
        error_memory(error);
    }
    if (!copy) {
        free(slot);
        recording_destroy(recording);
        return false;
    }
    *slot = (struct recording_slot){.recording = recording, .references = 1, .options = copy};
    session->recording[session->recordings] = slot;
    session->current_recording = session->recordings++;
    session->data_is_latest = true;
    session_changed(session);
    return true;
}

/* Where the current one is after place `dropped` has gone from a list of `count`. */
static int after_drop(int current, int dropped, int count)
{
    if (current > dropped)
        return current - 1;
    return current == dropped ? count - 1 : current;
}

void session_drop_run(struct session *session, int index)
{
    run_slot_release(session->run[index]);
    session->runs--;
    memmove(&session->run[index], &session->run[index + 1],
            (size_t)(session->runs - index) * sizeof(session->run[0]));
    session->current_run = after_drop(session->current_run, index, session->runs);
    session_changed(session);
}

void session_drop_recording(struct session *session, int index)
{
    recording_slot_release(session->recording[index]);
    session->recordings--;
    memmove(&session->recording[index], &session->recording[index + 1],
            (size_t)(session->recordings - index) * sizeof(session->recording[0]));
    session->current_recording = after_drop(session->current_recording, index, session->recordings);
    session_changed(session);
}

int session_find_run(const struct session *session, struct text name)
{
    double number;
    const bool numeric = real_parse(name, &number) == REAL_OK;
    for (int i = 0; i < session->runs; i++) {
        const struct run *run = session->run[i]->run;
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

void session_set_result(struct session *session, const char *name, struct measured value,
                        enum quantity quantity)
{
    struct named_value *result = NULL;
    for (int i = 0; i < session->results; i++)
        if (strcmp(session->result[i].name, name) == 0)
            result = &session->result[i];
    if (!result && session->results == LIMIT_RESULTS)
        memmove(session->result, session->result + 1,
                (size_t)--session->results * sizeof *session->result);
    if (!result)
        result = &session->result[session->results++];
    *result = (struct named_value){
        .value = value.value, .uncertainty = value.uncertainty, .quantity = quantity};
    snprintf(result->name, sizeof result->name, "%s", name);
}

void session_store_fit(struct session *session, const struct stored_fit *fit)
{
    struct stored_fit *stored = NULL;
    for (int i = 0; i < session->stored_fits; i++)
        if (strcmp(session->stored_fit[i].of, fit->of) == 0 &&
            strcmp(session->stored_fit[i].fit.model, fit->fit.model) == 0 &&
            memcmp(session->stored_fit[i].fit.window, fit->fit.window, sizeof fit->fit.window) == 0)
            stored = &session->stored_fit[i];
    if (!stored && session->stored_fits == LIMIT_FITS) {
        stored = &session->stored_fit[LIMIT_FITS - 1];
        memmove(session->stored_fit, session->stored_fit + 1,
                (LIMIT_FITS - 1) * sizeof *session->stored_fit);
    } else if (!stored) {
        struct stored_fit *larger = realloc(
            session->stored_fit, ((size_t)session->stored_fits + 1) * sizeof *session->stored_fit);
        if (!larger)
            return;
        session->stored_fit = larger;
        stored = &larger[session->stored_fits++];
    }
    *stored = *fit;
    stored->statement = session->history.count;
}

void session_trace(struct session *session, const struct scene *before, size_t statement)
{
    const struct scene *scene = &session->setup.scene;
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        if (scene->model != before->model || scene->chosen[i] != before->chosen[i] ||
            memcmp(&scene->value[i], &before->value[i], sizeof scene->value[i]) != 0 ||
            scene->uncertainty[i] != before->uncertainty[i])
            session->setup.origin[i] = (uint32_t)statement;
}

/* ---- what follows from the settings and the front end ---- */

struct write_policy session_policy(const struct session *session, bool force)
{
    return (struct write_policy){
        .force = force, .confine = session->safe, .refuse = session->checking != NULL};
}

double session_first_step(const struct session *session)
{
    const struct settings *settings = &session->setup.settings;
    const double first = session->setup.scene.preset->first;
    return settings->dt_chosen || !(first > 0) ? settings->dt : first;
}

struct run_settings session_run_settings(const struct session *session)
{
    const struct settings *settings = &session->setup.settings;
    const bool adaptive = (session->setup.method->flags & METHOD_ADAPTIVE) && !session->setup.fixed;
    return (struct run_settings){.dt = adaptive && settings->tol > 0 ? session_first_step(session)
                                                                     : settings->dt,
                                 .tol = adaptive ? settings->tol : 0,
                                 .drag = session->setup.drag,
                                 .kernel = (enum kernel)settings->kernel,
                                 .compensated = settings->sums == SUMS_COMPENSATED,
                                 .record = settings->record};
}

enum charset session_charset(const struct session *session)
{
    switch ((enum charset_choice)session->setup.settings.charset) {
    case CHOOSE_ASCII:
        return CHARSET_ASCII;
    case CHOOSE_BLOCK:
        return CHARSET_BLOCK;
    case CHOOSE_BRAILLE:
        return CHARSET_BRAILLE;
    case CHOOSE_WORDS:
        return CHARSET_WORDS;
    case CHOOSE_AUTO:
        break;
    }
    return session->front.utf8 ? CHARSET_BRAILLE : CHARSET_ASCII;
}

void session_size(const struct session *session, int *width, int *height)
{
    const struct settings *settings = &session->setup.settings;
    *width = settings->width ? settings->width : session->front.width ? session->front.width : 80;
    *height = settings->height        ? settings->height
              : session->front.height ? session->front.height
                                      : 24;
}

/* ---- text for people ---- */

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

void session_drop_band(struct session *session)
{
    free(session->band.half);
    session->band = (struct fit_band){.half = NULL};
}

static double curve_value(const struct session *session, double t)
{
    const double *time = session->fit_curve[0], *value = session->fit_curve[1];
    const size_t low = first_from(time, session->fit_samples, t);
    if (low < session->fit_samples && time[low] == t)
        return value[low];
    if (low == 0 || low == session->fit_samples)
        return NAN;
    const double fraction = (t - time[low - 1]) / (time[low] - time[low - 1]);
    return value[low - 1] + fraction * (value[low] - value[low - 1]);
}

void session_fit_values(const struct session *session, const double *t, size_t n, double *value)
{
    if (session->fit_samples == 0)
        fit_values(&session->fit, t, n, value);
    for (size_t i = 0; i < n && session->fit_samples > 0; i++)
        value[i] = curve_value(session, t[i]);
}
