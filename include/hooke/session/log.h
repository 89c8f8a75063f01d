/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log of a session: what was asked of its runs, what was typed, how to go back. */
#ifndef HOOKE_SESSION_LOG_H
#define HOOKE_SESSION_LOG_H

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* ---- what was asked of a run (journal.c) ---- */

/*
 * What was asked of a run since its start, so that it can be made again bit for bit: by undo, by a
 * saved session, by `record`. How the work was cut into slices, and where it was paused, leaves no
 * trace in the samples and stands here only as the step at which something else was asked.
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
    int64_t from;  /* step of the run at which it was asked for */
    double from_t; /* [s] */
    double t;      /* REQUEST_GO: the target [s], T_UNREACHABLE either way: none */
    /* REQUEST_GO: step at which it ends, INT64_MAX: none; REQUEST_BACK: step it led to */
    int64_t end;
    char *condition; /* REQUEST_GO: as typed, NULL: none */
    int64_t met;     /* step at which the condition became true, 0: it did not */
    int param;       /* REQUEST_SET; REQUEST_KICK: variable */
    struct measured value;
    bool by_event; /* asked for by the commands of an event of the run */
    int64_t rows;  /* REQUEST_BACK */

    /* Private to journal.c. */
    int references, count; /* of requests up to this one */
    bool backs;            /* one of them is a REQUEST_BACK */
    struct request *before;
    const struct request *go; /* the latest REQUEST_GO before it */
};

/* One more at the end of the run's list. */
bool journal_add(struct run_slot *slot, struct request request, struct text condition,
                 struct error *error);
void journal_drop(struct run_slot *slot); /* the last one */
/* another owner of the list that ends there; NULL: an empty one */
struct request *journal_fraction(struct request *last);
void journal_release(struct request *last);
int journal_count(const struct request *last);
/* The requests from place `first` on, in order, *count of them; free() the list, not them. False:
 * no memory, *count 0. */
bool journal_list(const struct request *last, int first, const struct request ***list, int *count);
/* The times [s] of the latest changes of parameters, at most `max`, in order; not those by events.
 * Returns how many. */
int journal_changes(const struct request *last, double *t, int max);
/* The last REQUEST_GO up to this request; NULL: none. */
const struct request *journal_last_go(const struct request *last);
/* What is still to be done after a pause: the last REQUEST_GO; NULL: nothing. */
const struct request *journal_pending(const struct run_slot *slot);
/* The same, of this run alone, so that it may be changed. NULL: no memory (there has to be one). */
struct request *journal_edit_pending(struct run_slot *slot, struct error *error);
/* Where an event has stopped the run: on towards the same. */
bool journal_go_on(struct run_slot *slot, bool by_event, struct error *error);
/* The run has been taken back by `rows`, from step `before`. */
bool journal_back(struct run_slot *slot, int64_t before, double before_t, int64_t rows,
                  struct error *error);
/* The parameters in force now: those of the start and what was changed since, by events too or
 * without them. */
void journal_scene(const struct run_slot *slot, bool by_events, struct scene *scene);
/* Has something been changed since request `first`, not by an event? */
bool journal_changed(const struct run_slot *slot, int first);
/*
 * Takes the run to the state at the end of the list that ends at `last`: `steps`, at time `t`. It
 * may share a beginning with the run's own, which it replaces; the run keeps its own without
 * memory.
 */
bool journal_restore(struct session *session, struct run_slot *slot, struct request *last,
                     int64_t steps, double t);
/* What a REQUEST_SET or REQUEST_KICK changed, and to what: "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct request *request, struct buffer *text);
/*
 * Appends the commands that do what was done since request `first` and step `since` (0, -1: all):
 * run, continue, change, back. number: of the run, 0: the next. by_events: also what the run's
 * events did, which does it again where they only stop. False: a condition needs names that no
 * saved session knows; then nothing is appended.
 */
bool journal_write(const struct session *session, const struct run_slot *slot, int first,
                   int64_t since, int number, bool by_events, struct buffer *text);

/* ---- lines and statements, and the file that `record` appends to (history.c) ---- */

/* A line was read, sourced: by a statement that reads a file. *index: of its entry. False: no
 * memory, and nothing of it may be executed. */
bool history_line(struct session *session, struct text line, bool sourced, size_t *index,
                  struct error *error);
/* A statement of that line begins, which is `within` in memory: all that is executed until its end
 * stands after it. */
bool history_begin(struct session *session, size_t line, struct text within, struct text statement,
                   size_t *index, struct error *error);
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
struct entry *history_entry(const struct session *session, size_t index); /* from first on */
struct text history_text(const struct session *session, const struct entry *entry);
/* A line of its own that is not empty, as `history` counts them. */
bool history_is_typed(const struct session *session, const struct entry *entry);

enum history_reading {
    HISTORY_RECORD, /* what succeeded, as it came */
    HISTORY_SCRIPT, /* what led here, without other files: what these held; nothing is written */
};

/* Appends those from `first` on that are read so, a line each. */
void history_put(const struct session *session, size_t first, enum history_reading reading,
                 struct buffer *text);
/* Line of the script on which a statement stands (both counted from 1), with its first line; 0: it
 * is not there. */
int history_script_line(const struct session *session, size_t statement, struct text *line);
/* One of the script's statements ends in an error, as it did. */
bool history_fails(const struct session *session);
/* What `undo` calls a statement: as it was typed, as much of it as fits. */
void history_label(const struct session *session, size_t index, char label[LIMIT_NAME + 1]);
bool record_open(struct session *session, const char *path, struct error *error);
/* Puts the rest on the disk; false: that failed. There need not be such a file. */
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
    struct field field; /* of struct recording */
    /* Its command, where there is something to say; NULL: it needs the other recordings. */
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

#endif
