/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Undo, redo and checkpoints: copies of the set-up, and the lists of runs and recordings as they
 * were. A run that has gone on since is taken back to its step by dropping rows; one that was taken
 * back is advanced again, which gives the same bits.
 */
#include <hooke/method.h>
#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* State of a run to which undo can return; all snapshots between which the run did not change share
 * one. */
struct run_mark {
    int references;
    int64_t steps;
    double t; /* [s] */
    enum stop stop;
    struct controller controller; /* proposal of an adaptive method for the next step */
    char name[LIMIT_NAME + 1];
    struct request *last; /* last request of its journal then */
};

/* A run in a snapshot's list. */
struct marked_run {
    struct run_slot *slot;
    struct run_mark *mark;
};

/* Copy of the set-up, shared by snapshots between which it did not change. */
struct shared_setup {
    int references;
    struct setup setup;
};

/* A recording in a snapshot's list, with its fields that users change. */
struct recording_mark {
    struct recording_slot *slot;
    struct recording then; /* only its recording_fields are used */
};

/* State of a session at the beginning of a statement, or at a checkpoint. */
struct snapshot {
    char label[LIMIT_NAME + 1]; /* name of a checkpoint */
    size_t statement;           /* statement of the history that is undone */
    struct shared_setup *setup;
    int current_run, current_recording, next_run;
    bool data_is_latest;
    int runs, recordings;
    struct marked_run *run;
    struct recording_mark *recording;
};

/* Returns true if the run is where the mark says; last is the end of the run's journal. */
static bool same_run(const struct run *run, const struct request *last, const struct run_mark *mark)
{
    return run->steps == mark->steps && run->t == mark->t && run->stop == mark->stop &&
           last == mark->last && strcmp(run->name, mark->name) == 0;
}

/* Gives up one reference to the mark, which may be NULL. */
static void release_mark(struct run_mark *mark)
{
    if (!mark || --mark->references > 0)
        return;
    journal_release(mark->last);
    free(mark);
}

void run_unmark(struct run_slot *slot)
{
    release_mark(slot->mark);
    slot->mark = NULL;
}

/* Returns true if the step-size control of the run is still as in `then`. Step sizes and switches
 * are compared only for runs that have them, since the comparison of all bytes is slow for many
 * runs. */
static bool same_controller(const struct run *run, const struct controller *then)
{
    const size_t offset_begin = offsetof(struct controller, elapsed),
                 offset_end = offsetof(struct controller, switches);
    const struct controller *now = &run->controller;
    if (run->plan.adaptive || run->system.switches > 0)
        return memcmp(now, then, sizeof *now) == 0;
    return now->tol == then->tol &&
           memcmp((const char *)now + offset_begin, (const char *)then + offset_begin,
                  offset_end - offset_begin) == 0;
}

/* Returns the mark of the run's present state with one more reference, made if the run has changed
 * since the last one; NULL if out of memory. */
static struct run_mark *mark_run(struct run_slot *slot)
{
    const struct run *run = slot->run;
    if (!slot->mark || !same_run(run, slot->last, slot->mark) ||
        !same_controller(run, &slot->mark->controller)) {
        run_unmark(slot);
        if (!(slot->mark = malloc(sizeof *slot->mark)))
            return NULL;
        *slot->mark =
            (struct run_mark){.references = 1, .steps = run->steps, .t = run->t, .stop = run->stop};
        slot->mark->controller = run->controller;
        memcpy(slot->mark->name, run->name, sizeof slot->mark->name);
        slot->mark->last = journal_retain(slot->last);
    }
    slot->mark->references++;
    return slot->mark;
}

/* Gives up one reference to the set-up, which may be NULL. */
static void release_setup(struct shared_setup *setup)
{
    if (setup && --setup->references == 0)
        free(setup);
}

/* Returns the set-up of the latest undo entry with one more reference if nothing was set since,
 * else a new copy; NULL if out of memory. */
static struct shared_setup *share_setup(const struct session *session)
{
    struct shared_setup *setup =
        session->undo.undos > 0 ? session->undo.state[session->undo.undos - 1]->setup : NULL;
    if (setup && memcmp(&setup->setup, &session->setup, sizeof setup->setup) == 0) {
        setup->references++;
        return setup;
    }
    if ((setup = malloc(sizeof *setup))) {
        setup->references = 1;
        memcpy(&setup->setup, &session->setup, sizeof setup->setup);
    }
    return setup;
}

/* Copies the fields of a recording that users change. */
static void copy_fields(const struct recording *source, struct recording *target)
{
    for (int i = 0; i < RECORDING_FIELDS; i++) {
        const struct field *field = &recording_fields[i].field;
        memcpy((char *)target + field->offset, (const char *)source + field->offset, field->bytes);
    }
}

/* Returns a copy of lists and set-up, in which runs and recordings get another owner; NULL if out
 * of memory. */
struct snapshot *snapshot_take(const struct session *session, const char *label)
{
    struct snapshot *snapshot = calloc(1, sizeof *snapshot);
    if (!snapshot)
        return NULL;
    snapshot->run = calloc((size_t)session->runs.count + 1, sizeof *snapshot->run);
    snapshot->recording = calloc((size_t)session->recordings + 1, sizeof *snapshot->recording);
    if (!snapshot->run || !snapshot->recording || !(snapshot->setup = share_setup(session))) {
        snapshot_free(snapshot);
        return NULL;
    }
    snprintf(snapshot->label, sizeof snapshot->label, "%s", label);
    snapshot->current_run = session->runs.current;
    snapshot->current_recording = session->current_recording;
    snapshot->next_run = session->runs.next_number;
    snapshot->data_is_latest = session->data_is_latest;
    for (int i = 0; i < session->runs.count; i++) {
        struct run_mark *mark = mark_run(session->runs.slot[i]);
        if (!mark) {
            snapshot_free(snapshot);
            return NULL;
        }
        session->runs.slot[i]->references++;
        snapshot->run[snapshot->runs++] = (struct marked_run){session->runs.slot[i], mark};
    }
    for (int i = 0; i < session->recordings; i++) {
        struct recording_mark *mark = &snapshot->recording[snapshot->recordings++];
        mark->slot = session->recording[i];
        copy_fields(mark->slot->recording, &mark->then);
        session->recording[i]->references++;
    }
    return snapshot;
}

/* Gives up all that the snapshot shares; NULL is allowed. */
void snapshot_free(struct snapshot *snapshot)
{
    if (!snapshot)
        return;
    for (int i = 0; i < snapshot->runs; i++) {
        release_mark(snapshot->run[i].mark);
        run_slot_release(snapshot->run[i].slot);
    }
    for (int i = 0; i < snapshot->recordings; i++)
        recording_slot_release(snapshot->recording[i].slot);
    release_setup(snapshot->setup);
    free(snapshot->run);
    free(snapshot->recording);
    free(snapshot);
}

/* Returns true if the set-up or a run of the snapshot uses the model or the events. */
bool snapshot_uses(const struct snapshot *snapshot, const struct model *model,
                   const struct events *events)
{
    bool uses = setup_uses(&snapshot->setup->setup, model, events);
    for (int i = 0; i < snapshot->runs && !uses; i++)
        uses = run_slot_uses(snapshot->run[i].slot, model, events);
    return uses;
}

/* Takes a run back to its mark. If there is no memory for its journal, only the name is
 * restored. */
static void restore_run(struct session *session, struct run_slot *slot, const struct run_mark *mark)
{
    struct run *run = slot->run;
    if (journal_restore(session, slot, mark->last, mark->steps, mark->t)) {
        run->stop = mark->stop;
        run->controller = mark->controller;
    }
    memcpy(run->name, mark->name, sizeof run->name);
}

/* Returns true if the recording is the marked one and its fields are unchanged. */
static bool same_recording(const struct recording_slot *slot, const struct recording_mark *mark)
{
    bool same = slot == mark->slot;
    for (int i = 0; i < RECORDING_FIELDS; i++) {
        const struct field *field = &recording_fields[i].field;
        same &= memcmp((const char *)slot->recording + field->offset,
                       (const char *)&mark->then + field->offset, field->bytes) == 0;
    }
    return same;
}

/* Returns true if going back to the snapshot would change anything; settings of display do not
 * count, since they are not undone. */
bool undo_matters(const struct session *session, const struct snapshot *previous)
{
    if (session->runs.count != previous->runs || session->recordings != previous->recordings ||
        session->runs.current != previous->current_run ||
        session->current_recording != previous->current_recording ||
        session->data_is_latest != previous->data_is_latest)
        return true;
    for (int i = 0; i < session->runs.count; i++)
        if (session->runs.slot[i] != previous->run[i].slot ||
            !same_run(session->runs.slot[i]->run, session->runs.slot[i]->last,
                      previous->run[i].mark))
            return true;
    for (int i = 0; i < session->recordings; i++)
        if (!same_recording(session->recording[i], &previous->recording[i]))
            return true;
    if (memcmp(&previous->setup->setup, &session->setup, sizeof session->setup) == 0)
        return false;
    struct setup setup = previous->setup->setup;
    settings_display(&setup.settings, &session->setup.settings);
    /* padding was copied with the rest */
    return memcmp(&setup, &session->setup, sizeof setup) != 0;
}

/* Puts the session into the state of the snapshot, which stays valid. */
static void restore_snapshot(struct session *session, const struct snapshot *snapshot)
{
    for (int i = 0; i < snapshot->runs; i++)
        snapshot->run[i].slot->references++;
    for (int i = 0; i < snapshot->recordings; i++)
        snapshot->recording[i].slot->references++;
    while (session->runs.count > 0)
        session_drop_run(session, session->runs.count - 1);
    while (session->recordings > 0)
        session_drop_recording(session, session->recordings - 1);
    for (int i = 0; i < snapshot->runs; i++) {
        session->runs.slot[i] = snapshot->run[i].slot;
    }
    for (int i = 0; i < snapshot->recordings; i++) {
        const struct recording_mark *mark = &snapshot->recording[i];
        session->recording[i] = mark->slot;
        copy_fields(&mark->then, mark->slot->recording);
    }
    session->runs.count = snapshot->runs;
    session->recordings = snapshot->recordings;
    session->runs.current = snapshot->current_run;
    session->current_recording = snapshot->current_recording;
    session->runs.next_number = snapshot->next_run;
    session->data_is_latest = snapshot->data_is_latest;
    /* Options of the front end (form of results, characters) are not part of the experiment. */
    const struct settings now = session->setup.settings;
    memcpy(&session->setup, &snapshot->setup->setup, sizeof session->setup);
    settings_display(&session->setup.settings, &now);
    for (int i = 0; i < snapshot->runs; i++)
        restore_run(session, snapshot->run[i].slot, snapshot->run[i].mark);
    session_changed(session);
}

/* Frees count snapshots from index first on; the caller adapts the counts. */
static void free_snapshots(struct session *session, int first, int count)
{
    for (int i = 0; i < count; i++)
        snapshot_free(session->undo.state[first + i]);
}

/* Adds a snapshot for undo; drops those of redo, and the oldest one if there are too many. */
void undo_push(struct session *session, struct snapshot *previous, size_t statement)
{
    free_snapshots(session, session->undo.undos, session->undo.redos);
    if (session->undo.undos == LIMIT_UNDO) {
        free_snapshots(session, 0, 1);
        session->undo.undos--;
        memmove(session->undo.state, session->undo.state + 1,
                (LIMIT_UNDO - 1) * sizeof(session->undo.state[0]));
    }
    previous->statement = statement;
    session->undo.state[session->undo.undos++] = previous;
    session->undo.redos = 0;
}

void undo_clear(struct session *session)
{
    free_snapshots(session, 0, session->undo.undos + session->undo.redos);
    session->undo.undos = session->undo.redos = 0;
}

/* Exchanges the present state with the latest snapshot of undo or redo, and marks the statement in
 * the history. Returns false with the error set. */
bool undo_move(struct session *session, bool back, char label[LIMIT_NAME + 1], struct error *error)
{
    if ((back ? session->undo.undos : session->undo.redos) == 0) {
        error_set(error, ERROR_COMMAND, "nothing to %s", back ? "undo" : "redo");
        return error_hint(error, "display settings are not undone; 'unset NAME' resets one");
    }
    /* the present state replaces the target, so that redo (or undo) can return to it */
    struct snapshot **slot = &session->undo.state[session->undo.undos - back], *target = *slot;
    struct snapshot *now = snapshot_take(session, "");
    if (!now)
        return error_memory(error);
    history_label(session, target->statement, label);
    now->statement = target->statement;
    *slot = now;
    session->undo.undos += back ? -1 : 1;
    session->undo.redos += back ? 1 : -1;
    if (target->statement >= session->history.first) {
        unsigned *flags = &history_entry(session, target->statement)->flags;
        *flags = back ? *flags | ENTRY_UNDONE : *flags & ~(unsigned)ENTRY_UNDONE;
    }
    restore_snapshot(session, target);
    snapshot_free(target);
    return true;
}

/* Keeps the present state; a checkpoint of the same name is replaced. Returns false with the error
 * set. */
bool checkpoint_make(struct session *session, const char *name, struct error *error)
{
    int index = 0;
    while (index < session->undo.checkpoints &&
           strcmp(session->undo.checkpoint[index]->label, name) != 0)
        index++;
    if (index == LIMIT_CHECKPOINTS)
        return error_set(error, ERROR_COMMAND, "there are already %d checkpoints",
                         LIMIT_CHECKPOINTS);
    struct snapshot *snapshot = snapshot_take(session, name);
    if (!snapshot)
        return error_memory(error);
    if (index < session->undo.checkpoints) {
        snapshot_free(session->undo.checkpoint[index]);
        memmove(&session->undo.checkpoint[index], &session->undo.checkpoint[index + 1],
                (size_t)(session->undo.checkpoints - index - 1) *
                    sizeof(session->undo.checkpoint[0]));
        session->undo.checkpoints--;
    }
    session->undo.checkpoint[session->undo.checkpoints++] = snapshot; /* the latest is the last */
    return true;
}

/* Restores the checkpoint of that name, or the latest for an empty name. Returns false with the
 * error set. */
bool checkpoint_restore(struct session *session, struct text name, const char **label,
                        struct error *error)
{
    if (session->undo.checkpoints == 0) {
        error_set(error, ERROR_COMMAND, "there is no checkpoint");
        return error_hint(error, "type: checkpoint [NAME]");
    }
    struct suggestion suggestion = {.wanted = name};
    for (int i = session->undo.checkpoints - 1; i >= 0; i--) {
        const struct snapshot *snapshot = session->undo.checkpoint[i];
        if (name.len == 0 || text_is(name, snapshot->label)) {
            restore_snapshot(session, snapshot);
            *label = snapshot->label;
            return true;
        }
        suggestion_offer(&suggestion, snapshot->label);
    }
    error_at(error, name, "there is no checkpoint '%.*s'", (int)(name.len < 64 ? name.len : 64),
             name.data);
    suggestion_hint(&suggestion, error);
    return false;
}
