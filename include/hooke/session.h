/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * session: set-up, settings, runs, recordings, what the screen shows. It changes only by executing
 * command lines.
 */
#pragma once

#include <hooke/data/calibration.h>
#include <hooke/method/drag.h>
#include <hooke/result/table.h>
#include <hooke/scene/model.h>
#include <hooke/session/front.h>
#include <hooke/session/screen.h>
#include <hooke/session/settings.h>

/* ---- the session ---- */

struct named_value {
    char name[LIMIT_NAME + 1];
    double value, uncertainty; /* SI */
    enum quantity quantity;    /* QUANTITY_OTHER if unknown */
    /* Size of a state below which no digit is certain, because the error may be that large; 0 if
     * digits are certain. */
    double error_floor;
};

/* The events to watch (private); a list never changes and lives as long as its session. */
struct events;

/* The part that is plain data: undo copies it. */
struct setup {
    struct scene scene;
    const struct preset
        *own[LIMIT_OWN]; /* scenes that are all typed, as they were when last changed */
    int owns;
    const struct events *events; /* events of the next run; NULL if there are none */
    const struct method *method;
    bool method_chosen; /* chosen by name */
    enum drag drag;     /* DRAG_DEFAULT for the method's own */
    bool fixed;         /* dt= was given with the method: fixed steps although it could adapt */
    struct settings settings;
    struct named_value let[LIMIT_LET];
    int lets;
    /* Statement of the log that gave each parameter its value, counted from 1; 0 if it is the
     * scene's. */
    uint32_t origin[PARAM_MAX];
    struct calibration calibration; /* calibration of collected data */
};

/* One request made of a run (advance, change a parameter, go back); private. */
struct request;

/* Runs and recordings are shared by the session and its undo entries. */
struct run_slot {
    struct run *run;
    int references;
    char *note; /* NULL if there is none */
    /* End of the list of requests made of the run since its start, which recreates the run bit for
     * bit; shared with undo entries. NULL if there are none yet. */
    struct request *last;
    /* Mark of the latest undo entry (private to undo.c); NULL if there is none. */
    struct run_mark *mark;
    const struct events *events; /* events at the start of the run; NULL if there were none */
    size_t statement;            /* statement of the log that made it, counted from 1 */
    uint32_t origin[PARAM_MAX];  /* that of the set-up when it began */
    uint64_t id;                 /* identifier in the session's file, unique among slots */
};

struct run_row { /* a run in the list of them */
    const struct run_slot *slot;
    const struct run *run; /* run of the slot */
    bool current;
};

extern const struct result_columns run_columns; /* columns of struct run_row */

struct recording_slot {
    struct recording *recording;
    int references;
    char *options; /* as they have to stand after the file name to load it again */
    /* Checksum of the file's bytes, as the session's file has it; 0 if it has not been computed. */
    uint64_t sum;
    /* The file's bytes, if the file may be gone; empty if it is read again. */
    struct buffer content;
    size_t statement; /* statement of the log that loaded it, counted from 1 */
    bool growing;     /* it is being collected: its file is safe, and read again */
};

/* Values that a result took as exact, since no uncertainty was stated; an empty name ends the
 * list. */
#define EXACT_NAMES 8
struct exact_names {
    char name[EXACT_NAMES][LIMIT_NAME + 1];
};

struct measurement {
    char quantity[24];
    struct exact_names exact;
    struct measured value;
    enum quantity unit;
    double periods;               /* NAN if it does not apply */
    double t;                     /* [s] of an amplitude; NAN */
    bool energy;                  /* true if it measures the energy */
    size_t statement;             /* statement of the log that made it, counted from 1 */
    char source[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
};

extern const struct result_columns measurement_columns; /* columns of struct measurement */

struct session;

/* ---- live runs and the front end ---- */

/* A run that goes on while a person watches. */
enum live_state { LIVE_IDLE, LIVE_RUNNING, LIVE_PAUSED, LIVE_DIVERGED };

struct live {
    enum live_state state;
    double speed; /* simulated seconds per second; HUGE_VAL for as fast as possible */
    /* the same, measured over the last second; below speed: "RUNNING 0.4x (CPU)" */
    double achieved;
    double fraction;  /* part of the way to the target; negative if unknown */
    double marks[32]; /* [s] the latest times at which parameters were changed during the run */
    int mark_count;
    bool pausing;   /* asked to pause at the next look */
    bool changing;  /* the present command changes the current run (private) */
    bool advancing; /* the current run is on its way: what it stopped at is not yet known */
};

/* ---- the log of what was typed (history.c) ---- */

enum entry_flag {
    ENTRY_LINE = 1,        /* a line as it came; its statements follow */
    ENTRY_SOURCED = 2,     /* part of a file that a statement reads */
    ENTRY_WITHIN = 4,      /* while the run of the statement before went on */
    ENTRY_DONE = 8,        /* it succeeded */
    ENTRY_CHANGED = 16,    /* it changed the session, also if it failed */
    ENTRY_HAPPENED = 32,   /* its text in full is what happened: a run that was paused */
    ENTRY_UNRECORDED = 64, /* its effects are not recorded */
    ENTRY_NESTS = 128,     /* the entries that it read follow it */
    ENTRY_WRITES = 256,    /* all it did was to write a file */
    ENTRY_LOST = 512,      /* there was no memory for what happened */
};

struct entry {
    size_t text, len;      /* text as typed, in history.text; see history_text() */
    size_t full, full_len; /* as a file has to say it; full_len 0: the same */
    size_t output;         /* bytes at the end of that which send its result to a file */
    unsigned flags;
};

/*
 * The latest lines and statements of the session, in the order in which they began; none is changed
 * after its end. Entries and the bytes of their texts are counted from the session's beginning: of
 * both the first that are there are history_entry(first) and the byte text_first.
 */
struct history {
    struct buffer text;
    struct entry *entry;
    size_t first, count, capacity, text_first;
    int lines, lines_gone;  /* that were not sourced; those of them before the first */
    int done;               /* statements that succeeded */
    struct buffer happened; /* Effect of the current statement, written as commands; private. */
};

struct run_target; /* hooke/run.h */
struct snapshot;   /* Entry of undo, redo and checkpoints; private. */

/* Values that a module reports of a growing recording, for panes and figures, in SI; NAN if not
 * known. */
struct growing {
    /* Values for axes, which are unchanged while the motion hardly changes: the period [s], the
     * mean over the last periods, an amplitude that the motion stays within and reaches at least
     * half of. */
    double steady, middle, swing;
    double t_end;      /* [s] of the recording, where it is known to end */
    double late;       /* [s] the newest velocity is older than the newest sample */
    struct run *model; /* Run of the scene from the first swing on; NULL if none matches. */
    double offset;     /* position of the recording at which the model is at rest */
};

/* The parts of a session that modules keep: hooke/module.h. */
struct module;
struct session_part {
    const struct module *module;
    void *state;
};
struct session_parts {
    struct session_part item[LIMIT_MODULES];
    int count;
};

/* Everything that the user has typed and that set-up, runs and undo point to; freed when nothing
 * points to it. */
struct definitions {
    struct typed_models *models;
    struct events *events;                /* the newest first */
    size_t event_lists, event_lists_left; /* so many, and after the last session_sweep() */
};

struct runs {
    struct run_slot *slot[LIMIT_RUNS];
    int count, current; /* index of the current one; -1 if there is none */
    int next_number;    /* number of the next run */
    uint64_t next_id;   /* identifier of its slot */
};

/* Results of measurements and fits that expressions know by name. */
struct named_results {
    struct named_value value[LIMIT_RESULTS];
    int count;
};

/* Results of studies. */
struct studies {
    struct table_store found; /* the last of each kind */
    const char *last;         /* kind of the last study; NULL if there is none */
    int at_run; /* runs.next_number at that time: after a later run its table is the latest */
    /* Number of points of the study in progress, for points per second; 0 if it reports none. */
    double points;
};

struct undo {
    struct snapshot *state[LIMIT_UNDO]; /* the first `undos` go back, the others forward again */
    int undos, redos;
    struct snapshot *checkpoint[LIMIT_CHECKPOINTS];
    int checkpoints;
};

/* The file of `record FILE`, to which executed lines are appended. */
struct transcript {
    char *path; /* NULL if there is none */
    int fd;
    /* [ns] time at which its content was last put on the disk; 0 if never */
    int64_t synced;
    bool owed; /* more was written since then */
};

/* Options of the program that concern commands. */
struct session_options {
    bool keep_going;      /* -k */
    bool verbose;         /* -v: lines of scripts are shown before they are executed */
    bool safe;            /* --safe: write only below the current directory */
    const char *checking; /* the folder of a hand-in that is run again: nothing is written; NULL */
};

/* State of the statement that is being executed, and of those before it. */
struct execution {
    bool confirmed; /* it was asked about, and allowed */
    char *meant;    /* text for the log instead of its own; NULL if it is its own */
    bool typed;     /* typed by a person */
    int nesting;    /* command_exec inside command_exec */
    /* a run was paused: what stands after it on the line and in the file is not executed */
    bool halted;
    bool reacting;  /* commands of an event are executed: part of the statement that ran into it */
    bool passing;   /* the run goes on after them: what they set is not told each time */
    bool restoring; /* a session that saved itself is read: nothing but what recreates it */
    bool said_method; /* that nobody has chosen one */
    /* the assumed duration and tolerance of this scene have been reported */
    bool said_assumed;
    bool quit;             /* the user asked to leave */
    int status;            /* exit status so far */
    struct arena leftover; /* memory of statements that Ctrl-C left to be freed */
};

struct session {
    struct front front;
    struct session_parts *parts; /* parts of modules */
    struct setup setup;
    struct definitions definitions;
    struct runs runs;
    struct recording_slot *recording[LIMIT_RECORDINGS];
    int recordings, current_recording; /* index of the current one; -1 if there is none */
    bool data_is_latest; /* the recording is more recent than the run: measure acts on it */

    struct named_results results;
    struct measurement *measurement;
    int measurements;
    struct studies studies;
    struct undo undo;
    struct history history;
    struct execution execution;
    struct transcript transcript;
    struct session_options options;
    uint64_t changes; /* counts changes: autosave compares it */

    struct view view;
    struct log log;
    struct live live;
    const struct growing *growing; /* while a recording grows, only some commands are taken; NULL */
};

/* Creates a session with the lab's defaults. Returns NULL if out of memory. */
struct session *session_create(const struct front *front);
void session_destroy(struct session *session);
/* Frees what modules keep in it. */
void session_free_parts(struct session *session);
/* Appends the commands that recreate the set-up; sourcing them gives the same state. */
void session_save(const struct session *session, struct buffer *text);
/* Appends only those commands that trajectories depend on: neither recordings nor how things
 * look. */
void session_save_motion(const struct session *session, struct buffer *text);
/* All of the set-up, for the session's own file: without recordings, with how results look. */
void session_save_setup(const struct session *session, struct buffer *text);
/* The parameter says where a run starts, and nothing else. */
bool param_is_start(const struct scene *scene, int index);
/* A short description of the scene holds it: m and k of an oscillator, of its many others those
 * that the user or the scene has set; of other models all that act; none that is 0. */
bool param_matters(const struct scene *scene, int index);
/* Returns the settings of a new run: dt, tol (0 unless the method adapts), drag, recording. */
struct run_settings session_run_settings(const struct session *session);
/* [s] of methods that adapt: the setting dt where the user has set it, else the scene's own. */
double session_first_step(const struct session *session);
/* Short state for a prompt or a state line: "spring m=200 g k=15 N/m | euler dt=10 ms | t=9.6 s".
 */
void session_state_line(const struct session *session, struct buffer *text);

static inline struct run *session_run(const struct session *session)
{
    return session->runs.current >= 0 ? session->runs.slot[session->runs.current]->run : NULL;
}

/* It is the one that grows. */
static inline bool session_grows(const struct session *session, const struct recording *recording)
{
    for (int i = 0; session->growing && i < session->recordings; i++)
        if (session->recording[i]->growing && session->recording[i]->recording == recording)
            return true;
    return false;
}

static inline struct recording *session_recording(const struct session *session)
{
    return session->current_recording >= 0
               ? session->recording[session->current_recording]->recording
               : NULL;
}

const struct charset *session_charset(const struct session *session);

/* ---- the session ---- */

/* Records that the parameters that differ from the scene `previous` got their values by that
 * statement. */
void session_trace(struct session *session, const struct scene *previous, size_t statement);
void session_changed(struct session *session);
/* Takes the run over (also when it fails: then it is destroyed) and makes it the current one. */
bool session_add_run(struct session *session, struct run *run, struct error *error);
bool session_add_recording(struct session *session, struct recording *recording,
                           const char *options, struct error *error);
void session_drop_run(struct session *session, int index);
void session_drop_recording(struct session *session, int index);
void run_slot_release(struct run_slot *slot);
void recording_slot_release(struct recording_slot *slot);
/* Finds a run by number or name; returns -1 if there is none. */
int session_find_run(const struct session *session, struct text name);
/* returns -1 if there is none */
int session_find_recording(const struct session *session, struct text name);
void session_set_result(struct session *session, const char *name, struct measured value,
                        enum quantity quantity);
struct write_policy session_policy(const struct session *session, bool force);
/* That of a new session, which nobody has chosen. */
void session_unset_method(struct setup *setup);
void session_default_settings(struct settings *settings);
/* Returns true if the user has set it, or if it never follows the scene; others may do so, see
 * settings_of_scene(). */
bool setting_is_chosen(const struct setting *setting, const struct settings *settings);
void setting_choose(const struct setting *setting, bool chosen, struct settings *settings);
/* Appends the value that a tolerance below 10 eps is really taken as; appends nothing for
 * others. */
void put_tol_floor(struct buffer *text, double tol);
/* Duration and tolerance of the scene, unless they were set. */
void settings_of_scene(struct settings *settings, const struct preset *preset);
/* Those that only show become as in `source`: no undo, no run depends on them. */
void settings_display(struct settings *settings, const struct settings *source);
void session_size(const struct session *session, int *width, int *height);

/* Returns NULL if out of memory. */
struct snapshot *snapshot_take(const struct session *session, const char *label);
void snapshot_free(struct snapshot *snapshot);
void run_unmark(struct run_slot *slot); /* forget how undo entries last saw it */
/* Returns true if going back to it would change anything. */
bool undo_matters(const struct session *session, const struct snapshot *previous);
/* The state before that statement of the history. */
void undo_push(struct session *session, struct snapshot *previous, size_t statement);
void undo_clear(struct session *session);
/* Returns true if the set-up or a run of the snapshot uses the model or the events. Either may be
 * NULL, and is then not looked for. */
bool snapshot_uses(const struct snapshot *snapshot, const struct model *model,
                   const struct events *events);
/* The scene is one of that model, or of a preset of it. */
bool scene_uses(const struct scene *scene, const struct model *model);
bool setup_uses(const struct setup *setup, const struct model *model, const struct events *events);
bool run_slot_uses(const struct run_slot *slot, const struct model *model,
                   const struct events *events);
/* Frees what was typed and nothing uses any more; not while a statement is executed. */
void session_sweep(struct session *session);

/* ---- live runs ---- */

/*
 * Advances to the target in slices of at most 10 ms, with a look at the front end between them;
 * with `clocked`, simulated time follows the clock. Returns when the target is reached, or when the
 * run is paused: then run->stop is STOP_CANCELLED.
 */
void live_advance(struct session *session, struct run *run, const struct run_target *target,
                  bool clocked);
/* State and marks of session->live follow from the current run. */
void live_refresh(struct session *session);
/*
 * Takes a changed parameter of the scene over into the run that is in progress, is paused, or is to
 * be changed. Sets *t_start to the time [s] of the change, or to NAN if there is no such run. The
 * run is unchanged on error.
 */
bool live_bind(struct session *session, int param, double *t_start, struct error *error);
/* Gives a variable of the current run's state, which there is, another value. */
bool live_kick(struct session *session, int variable, double value, struct error *error);
/* " from t = 3.2 s on", nothing where `t_start` is NAN. */
void buffer_since(struct buffer *text, double t_start);
