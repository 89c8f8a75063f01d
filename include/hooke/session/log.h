/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log of a session: what was asked of its runs, what was typed, how to go back. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* ---- what was asked of a run (journal.c) ---- */

/*
 * Requests made of a run since its start, so that it can be made again bit for bit: by undo, by a
 * saved session, by `record`. Slices of the work and pauses leave no trace in the samples; they
 * appear here only as the step at which something else was requested.
 */

enum request_kind {
    REQUEST_GO,   /* towards a time, a step or a condition */
    REQUEST_SET,  /* a parameter changes */
    REQUEST_KICK, /* a variable of the state changes, in a step of its own */
    /* recorded states are dropped; of runs that remember their way, the others keep no memory of
     * it */
    REQUEST_BACK,
};

/*
 * The list is persistent: a request knows the one before it and never changes while two lists have
 * it, so that the run and all undo entries share what they have in common, and a new entry costs
 * nothing but a count.
 */
struct request {
    enum request_kind kind;
    int64_t start_step; /* step of the run at which it was asked for */
    double from_t;      /* [s] */
    /* target time [s] of REQUEST_GO; T_UNREACHABLE with either sign if there is none */
    double t;
    /* Step at which REQUEST_GO ends, INT64_MAX if there is none; step that REQUEST_BACK led to. */
    int64_t end;
    char *condition; /* condition of REQUEST_GO as typed; NULL if there is none */
    int64_t met;     /* step at which the condition became true; 0 if it did not */
    int param;       /* parameter of REQUEST_SET, variable of REQUEST_KICK */
    struct measured value;
    bool by_event; /* asked for by the commands of an event of the run */
    int64_t rows;  /* REQUEST_BACK */

    /* Private to journal.c. */
    int references, count; /* owners of this request; number of requests up to it */
    bool backs;            /* one of them is a REQUEST_BACK */
    struct request *previous;
    const struct request *go; /* the latest REQUEST_GO before it */
};

/* One more at the end of the run's list. */
bool journal_add(struct run_slot *slot, struct request request, struct text condition,
                 struct error *error);
void journal_drop(struct run_slot *slot); /* the last one */
/* Returns another owner of the list that ends there; NULL is an empty list. */
struct request *journal_fraction(struct request *last);
void journal_release(struct request *last);
int journal_count(const struct request *last);
/* Lists the requests from index `first` on, in order, *count of them. The caller frees the list,
 * not the requests. Returns false, with *count 0, if out of memory. */
bool journal_list(const struct request *last, int first, const struct request ***list, int *count);
/* The times [s] of the latest changes of parameters, at most `max`, in order; not those by events.
 * Returns how many. */
int journal_changes(const struct request *last, double *t, int max);
/* Returns the last REQUEST_GO up to this request, or NULL if there is none. */
const struct request *journal_last_go(const struct request *last);
/* Returns the last REQUEST_GO of the run, complete or not, or NULL if there is none. After a pause
 * or an event it is the request of which a part is left. */
const struct request *journal_pending(const struct run_slot *slot);
/* Returns the same request after it was replaced by a copy, if others own it too, so that it may be
 * changed. There has to be such a request. Returns NULL, with an error and nothing changed, if out
 * of memory. */
struct request *journal_edit_pending(struct run_slot *slot, struct error *error);
/* Adds a request to continue towards the target of the last REQUEST_GO, after an event has stopped
 * the run. With `by_event` the event's commands ask for it, else `continue`. Returns false, with an
 * error, if out of memory or if there are too many requests. */
bool journal_go_on(struct run_slot *slot, bool by_event, struct error *error);
/* The run has been taken back by `rows`, from step `old_step`. */
bool journal_back(struct run_slot *slot, int64_t old_step, double before_t, int64_t rows,
                  struct error *error);
/* The parameters in force now: those of the start and what was changed since, by events too or
 * without them. */
void journal_scene(const struct run_slot *slot, bool by_events, struct scene *scene);
/* Returns true if something has been changed since request `first`, other than by an event. */
bool journal_changed(const struct run_slot *slot, int first);
/*
 * Takes the run to the state at the end of the list that ends at `last`: `steps`, at time `t`. It
 * may share a beginning with the run's own, which it replaces; the run keeps its own without
 * memory.
 */
bool journal_restore(struct session *session, struct run_slot *slot, struct request *last,
                     int64_t steps, double t);
/* Appends the change of a REQUEST_SET or REQUEST_KICK, such as "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct request *request, struct buffer *text);
/*
 * Appends the commands that repeat everything done since request `first` and step `first_step` (0
 * and -1 for all of it): run, continue, change, back. `number` is the number of the run, or 0 for
 * the next one. With `by_events` also the effects of the run's events are written; events that only
 * stop the run have them again. Returns false, with nothing appended, if a condition needs names
 * that no saved session knows, or if out of memory (text->failed).
 */
bool journal_write(const struct session *session, const struct run_slot *slot, int first,
                   int64_t first_step, int number, bool by_events, struct buffer *text);

/* ---- lines and statements, and the file that `record` appends to (history.c) ---- */

/* Adds a line that was read; `sourced` if by a statement that reads a file. Sets *index to that of
 * its entry. Returns false if out of memory; then nothing of the line may be executed. */
bool history_line(struct session *session, struct text line, bool sourced, size_t *index,
                  struct error *error);
/* A statement of that line begins, which is `line_text` in memory: all that is executed until its
 * end stands after it. */
bool history_begin(struct session *session, size_t line, struct text line_text,
                   struct text statement, size_t *index, struct error *error);
/* It is over. full: as a file has to say it, whose last `output` bytes are where its result went.
 * What session->history.happened has takes its place. flags: those that are added. */
void history_end(struct session *session, size_t index, struct text full, size_t output,
                 unsigned flags);
void history_free(struct session *session);
/*
 * The oldest go where there are more than twice LIMIT_HISTORY entries, or LIMIT_HISTORY_TEXT bytes:
 * as many are left. Not while a statement is executed.
 */
void history_trim(struct session *session);
/* Returns the entry with that index, which is at least history.first. */
struct entry *history_entry(const struct session *session, size_t index);
struct text history_text(const struct session *session, const struct entry *entry);
/* A line of its own that is not empty, as `history` counts them. */
bool history_is_typed(const struct session *session, const struct entry *entry);

enum history_reading {
    HISTORY_RECORD, /* statements that succeeded, as typed */
    /* statements that led here, with the content of other files instead of the files; nothing is
     * written */
    HISTORY_SCRIPT,
};

/* Appends those from `first` on that are read so, a line each. */
void history_put(const struct session *session, size_t first, enum history_reading reading,
                 struct buffer *text);
/* Returns the line of the script that contains a statement (both counted from 1), and its first
 * line; returns 0 if the script does not contain it. */
int history_script_line(const struct session *session, size_t statement, struct text *line);
/* One of the script's statements ends in an error, as it did. */
bool history_fails(const struct session *session);
/* Fills in the label by which `undo` names a statement: its text as typed, as much as fits. */
void history_label(const struct session *session, size_t index, char label[LIMIT_NAME + 1]);
bool record_open(struct session *session, const char *path, struct error *error);
/* Puts the remaining statements on the disk; returns false if that failed. There need not be such a
 * file. */
bool record_close(struct session *session, struct error *error);
/* Appends the statements from `first` on to the file of `record`, if there is one, at once; on the
 * disk they are put once a second at most. A failure ends the recording. */
bool record_append(struct session *session, size_t first, struct error *error);

/* The commands that choose a scene's preset and type its lines; no parameters. */
void scene_kind_script(const struct scene *scene, struct buffer *text);

/* ---- what a user changes of a recording (save.c): undo brings it back ---- */

/* Periods that the phase plot shows in a new session; another number is saved. */
#define VIEW_TRAIL_PERIODS 2

#define RECORDING_FIELDS 5
struct recording_field {
    struct field field; /* field of struct recording */
    /* Appends the command that sets the field, if one is needed; NULL if the command needs the
     * other recordings. */
    void (*save)(const struct recording *recording, struct buffer *text);
};
extern const struct recording_field recording_fields[RECORDING_FIELDS];

/* ---- moving between snapshots: undo, redo, checkpoint, restore (undo.c) ---- */

/* One step back (or forward again). label: the command that was undone. */
bool undo_move(struct session *session, bool back, char label[LIMIT_NAME + 1], struct error *error);
bool checkpoint_make(struct session *session, const char *name, struct error *error);
/* The latest one where name is empty. *label: its name, owned by the session. */
bool checkpoint_restore(struct session *session, struct text name, const char **label,
                        struct error *error);
