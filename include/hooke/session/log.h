/* SPDX-License-Identifier: GPL-3.0-or-later */
/* log: the records by which a session can be repeated and taken back: the journal of each run (the
 * requests that it was given), the history of lines and statements, and undo. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* ---- the journal of a run (journal.c) ---- */

/* Requests that a run was given since its start, by which undo, saved sessions and `record` can
 * make the run again, bit for bit. A live run is advanced in short slices of time and may be paused
 * between them. Neither changes the recorded rows, so that slices and pauses are not in the
 * journal; the step of a pause is known only from the request that was given there (start_step). */

/* Kinds of requests. */
enum request_kind {
    REQUEST_GO,   /* Advance to a time, a step or a condition. */
    REQUEST_SET,  /* Change a parameter. */
    REQUEST_KICK, /* Change a variable of the state, as a step of its own. */
    /* Go back by recorded rows. Only for runs of which going back has to be repeated: adaptive
     * ones, those with rows at even times, and those for which run_remembers() is true. In other
     * runs going back removes the requests that were made after the row. */
    REQUEST_BACK,
};

/* A request, linked to the one before it, so that a list is known by its last request. Several
 * lists may begin with the same requests, which they share and which must not be changed: a run and
 * the undo entries that contain it have lists of their own for only the requests in which they
 * differ. A new undo entry therefore only costs a reference. */
struct request {
    enum request_kind kind;
    int64_t start_step; /* Step of the run at which the request was given. */
    double from_t;      /* Time [s] of the run at which the request was given. */
    /* Target time [s] of REQUEST_GO; T_UNREACHABLE with either sign if there is none. */
    double t;
    /* Step at which a REQUEST_GO ends, INT64_MAX if it has none; step to which a REQUEST_BACK went
     * back. */
    int64_t end;
    char *condition; /* Condition of REQUEST_GO as typed, or NULL; owned. */
    int64_t met;     /* Step at which the condition became true; 0 if it did not. */
    int param; /* Index of the parameter of REQUEST_SET, or of the variable of REQUEST_KICK. */
    /* New value [SI] of REQUEST_SET and REQUEST_KICK. */
    struct measured value;
    bool by_event; /* The request was given by the commands of an event. */
    int64_t rows;  /* Number of rows of REQUEST_BACK. */

    /* Private to journal.c. */
    /* `references` is the number of owners of this request, `count` the number of requests in the
     * list from the first one to this one. */
    int references, count;
    bool backs; /* One of the requests from the first one to this one is a REQUEST_BACK. */
    struct request *previous;
    const struct request *go; /* The latest REQUEST_GO before this request. */
};

/* Adds a request to the run's journal; `condition`, which may be empty, is copied as its condition.
 * Returns false, with `error` set, if there are too many requests or if out of memory. */
bool journal_add(struct run_slot *slot, struct request request, struct text condition,
                 struct error *error);
void journal_drop(struct run_slot *slot); /* Removes the last request, which must exist. */
/* Adds an owner to the list that ends at `last`, and returns `last`; NULL is an empty list. */
struct request *journal_retain(struct request *last);
/* Removes an owner of the list; requests without owners are freed. NULL is allowed. */
void journal_release(struct request *last);
/* Returns the number of requests of the list, 0 for NULL. */
int journal_count(const struct request *last);
/* Sets *list to a new array of the requests of the list that ends at `last`, from index `first` (0
 * for the first request) on, in order, and *count to their number. The caller frees the array, not
 * the requests. Returns false, with *count = 0, if out of memory. */
bool journal_list(const struct request *last, int first, const struct request ***list, int *count);
/* Fills t with the times [s] of the latest `max` changes of parameters at most, in the order of the
 * requests, without changes by events. Returns their number. */
int journal_changes(const struct request *last, double *t, int max);
/* Returns the last REQUEST_GO of the list that ends at `last`, or NULL if there is none. */
const struct request *journal_last_go(const struct request *last);
/* Returns the last REQUEST_GO of the run, or NULL if there is none. After a pause or an event the
 * run has not reached its target yet. */
const struct request *journal_pending(const struct run_slot *slot);
/* Returns the request of journal_pending(), which must exist, for the caller to change; if it has
 * other owners, the run first gets a copy of its own. Returns NULL, with `error` set and nothing
 * changed, if out of memory. */
struct request *journal_edit_pending(struct run_slot *slot, struct error *error);
/* Adds a request to continue to the target of the last REQUEST_GO after an event has stopped the
 * run; by_event tells that the event's commands, not `continue`, ask for it. Returns false, with
 * `error` set, if there are too many requests or if out of memory. */
bool journal_go_on(struct run_slot *slot, bool by_event, struct error *error);
/* Notes in the journal that the run, which was at step old_step and time before_t [s], went back by
 * `rows` rows to its current state. Returns false, with `error` set, if out of memory. */
bool journal_back(struct run_slot *slot, int64_t old_step, double before_t, int64_t rows,
                  struct error *error);
/* Sets *scene to the scene of the run with its current parameters: those at its start and all later
 * changes, of which changes by events count only with by_events. */
void journal_scene(const struct run_slot *slot, bool by_events, struct scene *scene);
/* Returns true if one of the requests from index `first` on was not made by an event. */
bool journal_changed(const struct run_slot *slot, int first);
/* Brings the run to the state, step `steps` at time t [s], that it had with the journal that ends
 * at `last`. That journal, which may begin with the same requests as the run's own one, replaces
 * it. Returns false if out of memory; the run then keeps its own journal. */
bool journal_restore(struct session *session, struct run_slot *slot, struct request *last,
                     int64_t steps, double t);
/* Appends the change of a REQUEST_SET or REQUEST_KICK, such as "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct request *request, struct buffer *text);
/* Appends the commands run, continue, back and changes of parameters that repeat the requests from
 * index `first` and step first_step on (0 and -1 for all of them). `number` is the number of the
 * run in these commands, or 0 for the next new run. With by_events the effects of the run's events
 * are written, too; events that only stop the run happen again by themselves. Returns false, with
 * nothing appended, if a condition uses names that a saved session does not contain, or if out of
 * memory (text->failed). */
bool journal_write(const struct session *session, const struct run_slot *slot, int first,
                   int64_t first_step, int number, bool by_events, struct buffer *text);

/* ---- the history of lines and statements, and the file of `record` (history.c) ---- */

/* Adds a line that was read to the history, and sets *index to the index of its entry. `sourced`
 * tells that it comes from a file that a statement executes. Returns false, with `error` set, if
 * out of memory: then nothing of the line may be executed. */
bool history_line(struct session *session, struct text line, bool sourced, size_t *index,
                  struct error *error);
/* Adds an entry for a statement that begins to be executed, and sets *index to its index; entries
 * of lines that the statement executes follow. `line` is the index of the entry of its line,
 * line_text that line in memory, and `statement` a slice of line_text. Returns false with `error`
 * set. */
bool history_begin(struct session *session, size_t line, struct text line_text,
                   struct text statement, size_t *index, struct error *error);
/* Completes the entry of a statement that has ended. `full` is the statement as a script needs it,
 * such as with names in full; its last `output` bytes redirect the result to a file. If the
 * statement has described its effect as commands in session->history.happened, those commands
 * replace `full`. `flags` (enum entry_flag) are added to those of the entry. */
void history_end(struct session *session, size_t index, struct text full, size_t output,
                 unsigned flags);
/* Frees the history and closes the file of `record`. */
void history_free(struct session *session);
/* Drops the oldest entries until the history has at most LIMIT_HISTORY entries and
 * LIMIT_HISTORY_TEXT bytes; does nothing unless one of these is exceeded twofold. Must not be
 * called while a statement is executed. */
void history_trim(struct session *session);
/* Returns the entry with this index, which is at least history.first. */
struct entry *history_entry(const struct session *session, size_t index);
/* Returns the text of an entry as typed, valid until the history changes. */
struct text history_text(const struct session *session, const struct entry *entry);
/* Returns true for a line that is not empty and was not read by a statement: the lines that
 * `history` counts. */
bool history_is_typed(const struct session *session, const struct entry *entry);

/* Selections of statements from the history. */
enum history_reading {
    /* Statements that succeeded, in the form that the file of `record` has; an executed file
     * appears as the statement that executed it. */
    HISTORY_RECORD,
    HISTORY_IN_FORCE, /* Those of HISTORY_RECORD without the ones that undo took back. */
    /* Statements that led to the current state: statements of executed files replace those that
     * executed them; statements that only wrote a file are left out. */
    HISTORY_SCRIPT,
};

/* Appends the statements from entry `first` on that the selection `reading` includes, one per line.
 */
void history_put(const struct session *session, size_t first, enum history_reading reading,
                 struct buffer *text);
/* Returns the number of the line at which a statement begins in the script (HISTORY_SCRIPT of the
 * whole history), and sets *line to this line. `statement` is its number in the history; both
 * numbers count from 1. Returns 0 if the script does not contain the statement. */
int history_script_line(const struct session *session, size_t statement, struct text *line);
/* Returns true if a statement of the script (HISTORY_SCRIPT) failed, so that it will fail again
 * when the script is executed. */
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

/* ---- saving the session (save.c) ---- */

/* Number of periods that the phase plot shows in a new session (view.trail). Saving writes the
 * command `trail` only for another number. */
#define VIEW_TRAIL_PERIODS 2

/* Number of members of struct recording that commands change, and that undo and saving restore. */
#define RECORDING_FIELDS 5
/* One of these members, in the table recording_fields. */
struct recording_field {
    struct field field; /* The member of struct recording. */
    /* Appends the command that sets the field; NULL if the field has none because that command
     * refers to other recordings. */
    void (*save)(const struct recording *recording, struct buffer *text);
};
extern const struct recording_field recording_fields[RECORDING_FIELDS];

/* ---- moving between snapshots: undo, redo, checkpoint, restore (undo.c) ---- */

/* Undoes the last command (`back`) or redoes the one that was undone last, and writes its label to
 * `label`. Returns false, with `error` set, if there is none or if out of memory. */
bool undo_move(struct session *session, bool back, char label[LIMIT_NAME + 1], struct error *error);
/* Makes a checkpoint with this name, in place of one of the same name. Returns false with `error`
 * set. */
bool checkpoint_make(struct session *session, const char *name, struct error *error);
/* Goes to the checkpoint with this name, or to the latest one if `name` is empty, and sets *label
 * to its name, owned by the session. Returns false, with `error` set, if there is none. */
bool checkpoint_restore(struct session *session, struct text name, const char **label,
                        struct error *error);
