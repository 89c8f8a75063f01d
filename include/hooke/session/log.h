/* SPDX-License-Identifier: GPL-3.0-or-later */
/* log: the records by which a session can be repeated and taken back: the journal of each run (the
 * requests that it was given), the history of lines and statements, and undo. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* ---- the journal of a run (journal.c) ---- */

/* Requests that a run was given since its start, by which undo, saved sessions and `record` can
 * make it again, bit for bit. Slices and pauses do not change the rows; they appear only as the
 * step at which something else was requested. */

/* Kinds of requests. */
enum request_kind {
    REQUEST_GO,   /* Advance to a time, a step or a condition. */
    REQUEST_SET,  /* Change a parameter. */
    REQUEST_KICK, /* Change a variable of the state, as a step of its own. */
    /* Go back by recorded rows. Only runs for which run_remembers() have such requests; for others
     * the later requests are dropped. */
    REQUEST_BACK,
};

/* A request, linked to the one before it. Requests that several lists share do not change, so that
 * the run and all undo entries share their common beginning, and a new undo entry costs only a
 * reference. */
struct request {
    enum request_kind kind;
    int64_t start_step; /* Step of the run at which it was given. */
    double from_t;      /* Time [s] at which it was given. */
    /* Target time [s] of REQUEST_GO; T_UNREACHABLE with either sign if there is none. */
    double t;
    /* Step at which REQUEST_GO ends, INT64_MAX if none; step to which REQUEST_BACK led. */
    int64_t end;
    char *condition; /* Condition of REQUEST_GO as typed, or NULL; owned. */
    int64_t met;     /* Step at which the condition became true; 0 if it did not. */
    int param; /* Index of the parameter of REQUEST_SET, or of the variable of REQUEST_KICK. */
    /* New value [SI] of REQUEST_SET and REQUEST_KICK. */
    struct measured value;
    bool by_event; /* It was given by the commands of an event. */
    int64_t rows;  /* Number of rows of REQUEST_BACK. */

    /* Private to journal.c. */
    int references, count; /* Number of owners of this request, and of requests up to it. */
    bool backs;            /* One of them is a REQUEST_BACK. */
    struct request *previous;
    const struct request *go; /* The latest REQUEST_GO before it. */
};

/* Adds a request to the run's journal. Returns false, with `error` set, if there are too many or if
 * out of memory. */
bool journal_add(struct run_slot *slot, struct request request, struct text condition,
                 struct error *error);
void journal_drop(struct run_slot *slot); /* Removes the last request, which must exist. */
/* Adds an owner to the list that ends at `last`, and returns `last`; NULL is an empty list. */
struct request *journal_retain(struct request *last);
/* Removes an owner of the list; requests without owners are freed. NULL is allowed. */
void journal_release(struct request *last);
/* Returns the number of requests of the list, 0 for NULL. */
int journal_count(const struct request *last);
/* Sets *list to a new array of the requests from index `first` on, in order, and *count to their
 * number. The caller frees the array, not the requests. Returns false, with *count = 0, if out of
 * memory. */
bool journal_list(const struct request *last, int first, const struct request ***list, int *count);
/* Fills t with the times [s] of the latest changes of parameters, at most `max`, in order, without
 * those by events. Returns their number. */
int journal_changes(const struct request *last, double *t, int max);
/* Returns the last REQUEST_GO up to this request, or NULL if there is none. */
const struct request *journal_last_go(const struct request *last);
/* Returns the last REQUEST_GO of the run, complete or not, or NULL if there is none. After a pause
 * or an event a part of it remains to be done. */
const struct request *journal_pending(const struct run_slot *slot);
/* Returns the request of journal_pending(), which must exist, so that it may be changed: replaced
 * by a copy if it has other owners. Returns NULL, with `error` set and nothing changed, if out of
 * memory. */
struct request *journal_edit_pending(struct run_slot *slot, struct error *error);
/* Adds a request to continue to the target of the last REQUEST_GO after an event has stopped the
 * run; by_event tells that the event's commands, not `continue`, ask for it. Returns false, with
 * `error` set, if there are too many requests or if out of memory. */
bool journal_go_on(struct run_slot *slot, bool by_event, struct error *error);
/* Notes that the run was taken back by `rows` rows from step old_step at time before_t [s]. Returns
 * false, with `error` set, if out of memory. */
bool journal_back(struct run_slot *slot, int64_t old_step, double before_t, int64_t rows,
                  struct error *error);
/* Sets *scene to the scene of the run with the parameters now in force: those of the start and all
 * changes, with or without those by events. */
void journal_scene(const struct run_slot *slot, bool by_events, struct scene *scene);
/* Returns true if there is a request since index `first` that is not by an event. */
bool journal_changed(const struct run_slot *slot, int first);
/* Brings the run to the state at the end of the list that ends at `last`: step `steps` at time t
 * [s]. The list replaces the run's own, of which it may share the beginning. Returns false if out
 * of memory; the run then keeps its own. */
bool journal_restore(struct session *session, struct run_slot *slot, struct request *last,
                     int64_t steps, double t);
/* Appends the change of a REQUEST_SET or REQUEST_KICK, such as "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct request *request, struct buffer *text);
/* Appends the commands that repeat all requests since index `first` and step first_step (0 and -1
 * for all of them): run, continue, change, back. `number` is the number of the run, or 0 for the
 * next one. With by_events the effects of the run's events are written, too; events that only stop
 * the run happen again by themselves. Returns false, with nothing appended, if a condition needs
 * names that no saved session knows, or if out of memory (text->failed). */
bool journal_write(const struct session *session, const struct run_slot *slot, int first,
                   int64_t first_step, int number, bool by_events, struct buffer *text);

/* ---- the history of lines and statements, and the file of `record` (history.c) ---- */

/* Adds a line that was read, by a statement that executes a file if `sourced`, and sets *index to
 * its entry. Returns false, with `error` set, if out of memory: then nothing of the line may be
 * executed. */
bool history_line(struct session *session, struct text line, bool sourced, size_t *index,
                  struct error *error);
/* Adds a statement of the line with entry `line`, whose text in memory is line_text and of which
 * `statement` is a slice, and sets *index to its entry. Entries of what it executes follow. Returns
 * false with `error` set. */
bool history_begin(struct session *session, size_t line, struct text line_text,
                   struct text statement, size_t *index, struct error *error);
/* Ends a statement. `full` is its text as a script needs it, whose last `output` bytes redirect the
 * result; session.history.happened, if not empty, replaces it. `flags` are added to those of the
 * entry. */
void history_end(struct session *session, size_t index, struct text full, size_t output,
                 unsigned flags);
/* Frees the history and closes the file of `record`. */
void history_free(struct session *session);
/* Drops the oldest entries if there are more than twice LIMIT_HISTORY entries or LIMIT_HISTORY_TEXT
 * bytes, so that the limits remain. Not while a statement is executed. */
void history_trim(struct session *session);
/* Returns the entry with this index, which is at least history.first. */
struct entry *history_entry(const struct session *session, size_t index);
/* Returns the text of an entry as typed, valid until the history changes. */
struct text history_text(const struct session *session, const struct entry *entry);
/* Returns true for a line that is not empty and was not read by a statement: the lines that
 * `history` counts. */
bool history_is_typed(const struct session *session, const struct entry *entry);

/* Ways of reading the history. */
enum history_reading {
    HISTORY_RECORD,   /* Statements that succeeded, as typed. */
    HISTORY_IN_FORCE, /* Those of HISTORY_RECORD without the ones that undo took back. */
    /* Statements that led to the current state, with the content of executed files instead of
     * these, without those that write files. */
    HISTORY_SCRIPT,
};

/* Appends the statements from entry `first` on that are read in this way, one per line. */
void history_put(const struct session *session, size_t first, enum history_reading reading,
                 struct buffer *text);
/* Returns the number of the line of the script that contains a statement (both from 1) and sets
 * *line to its first line; returns 0 if the script does not contain it. */
int history_script_line(const struct session *session, size_t statement, struct text *line);
/* Returns true if one of the script's statements ends in an error, as it did in the session. */
bool history_fails(const struct session *session);
/* Writes the label by which `undo` names a statement: its text as typed, shortened if necessary. */
void history_label(const struct session *session, size_t index, char label[LIMIT_NAME + 1]);
/* Begins to append executed statements to a file, and closes a previous one. Returns false with
 * `error` set. */
bool record_open(struct session *session, const char *path, struct error *error);
/* Writes the remaining statements to the disk and closes the file, if there is one. Returns false
 * with `error` set. */
bool record_close(struct session *session, struct error *error);
/* Appends the statements from entry `first` on to the file of `record`, if there is one; they are
 * forced to the disk once a second at most. Returns false, with `error` set and the file closed, on
 * failure. */
bool record_append(struct session *session, size_t first, struct error *error);

/* Appends the commands that choose the preset of a scene and type its lines, without parameters. */
void scene_kind_script(const struct scene *scene, struct buffer *text);

/* ---- fields of a recording that commands change, and that undo and saving restore (save.c) ----
 */

/* Number of periods that the phase plot shows in a new session; another number is saved. */
#define VIEW_TRAIL_PERIODS 2

#define RECORDING_FIELDS 5
/* One such field. */
struct recording_field {
    struct field field; /* The member of struct recording. */
    /* Appends the command that sets the field, if it needs one; NULL if the command refers to other
     * recordings. */
    void (*save)(const struct recording *recording, struct buffer *text);
};
extern const struct recording_field recording_fields[RECORDING_FIELDS];

/* ---- moving between snapshots: undo, redo, checkpoint, restore (undo.c) ---- */

/* Goes one step back, or forward again, and writes the command that was undone or redone to
 * `label`. Returns false, with `error` set, if there is nothing to undo or if out of memory. */
bool undo_move(struct session *session, bool back, char label[LIMIT_NAME + 1], struct error *error);
/* Makes a checkpoint with this name, in place of one of the same name. Returns false with `error`
 * set. */
bool checkpoint_make(struct session *session, const char *name, struct error *error);
/* Goes to the checkpoint with this name, or to the latest one if `name` is empty, and sets *label
 * to its name, owned by the session. Returns false, with `error` set, if there is none. */
bool checkpoint_restore(struct session *session, struct text name, const char **label,
                        struct error *error);
