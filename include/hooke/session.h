/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * session: all that a user works with: set-up (scene, method, settings), runs, recordings, results,
 * undo, history, and what the screen shows.
 *
 * session_create() makes a session, command_exec() (<hooke/command.h>) is the only way in which
 * users change it, session_destroy() frees it with all that it owns. One thread owns a session.
 * Handlers of commands read the members directly and change them by the functions below.
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

/* A value with a name for expressions. */
struct named_value {
    char name[LIMIT_NAME + 1];
    double value, uncertainty; /* Value and standard uncertainty [SI]. */
    enum quantity quantity;    /* Quantity, or QUANTITY_OTHER if unknown. */
    /* Magnitude [SI] below which a state variable has no reliable digit because of the run's error;
     * else 0. */
    double error_floor;
};

/* A list of events to search for (<hooke/session/events.h>); it never changes and lives as long as
 * its session. */
struct events;

/* Everything of which a new run is made; plain data that undo copies. */
struct setup {
    struct scene scene;
    /* [owns] named scenes whose equations are all typed, as they were when last changed. */
    const struct preset *own[LIMIT_OWN];
    int owns;
    const struct events *events; /* Events of the next run, or NULL. */
    const struct method *method;
    bool method_chosen; /* The user has chosen the method. */
    enum drag drag;     /* Variant of drag; DRAG_DEFAULT stands for the method's. */
    bool fixed;         /* Fixed steps although the method could adapt: dt= was given with it. */
    struct settings settings;
    /* [lets] variables that the user has defined. */
    struct named_value let[LIMIT_LET];
    int lets;
    /* Number of the statement that gave each parameter its value, from 1; 0 if it is the scene's.
     */
    uint32_t origin[PARAM_MAX];
    /* Calibration of recordings that are collected from a sensor. */
    struct calibration calibration;
};

/* A request that a run was given: continue, change, go back (<hooke/session/log.h>). */
struct request;

/* A run with what the session knows of it. Session and undo entries share slots by counting
 * references. */
struct run_slot {
    /* The run, owned. */
    struct run *run;
    /* Number of owners of the slot. */
    int references;
    char *note; /* Note of the user, or NULL; owned. */
    /* Last request of the run's journal, by which it can be made again, bit for bit; shared with
     * undo entries. NULL if it is empty. */
    struct request *last;
    /* State of the run in the latest undo entry, private to undo.c; NULL if there is none. */
    struct run_mark *mark;
    const struct events *events; /* Events of the run, or NULL. */
    size_t statement;            /* Number of the statement that made the run, from 1. */
    uint32_t origin[PARAM_MAX];  /* setup.origin when the run began. */
    uint64_t id;                 /* Identifier in the session's file, unique among slots. */
};

struct run_row { /* A row of the list of runs. */
    const struct run_slot *slot;
    const struct run *run; /* The slot's run. */
    /* It is the current run. */
    bool current;
};

extern const struct result_columns run_columns; /* Columns of struct run_row. */

/* A recording with what the session knows of it; shared by counting references. */
struct recording_slot {
    struct recording *recording;
    int references;
    char *options; /* Options after the file name that load it again in the same way; owned. */
    /* bytes_sum() of the file, under which the session's file has its content; 0 if not computed.
     */
    uint64_t sum;
    /* Content of the file, if that may have been deleted; empty if the file is read again. */
    struct buffer content;
    size_t statement; /* Number of the statement that loaded it, from 1. */
    bool growing;     /* It is being collected: its file is safe, and is read again. */
};

/* Names of values that a result took as exact because no uncertainty was set; an empty name ends
 * the list. */
#define EXACT_NAMES 8
struct exact_names {
    char name[EXACT_NAMES][LIMIT_NAME + 1];
};

/* A row of `list measurements`. */
struct measurement {
    /* Name of the quantity, such as "period". */
    char quantity[24];
    struct exact_names exact;
    /* The result [SI]. */
    struct measured value;
    /* Its physical quantity. */
    enum quantity unit;
    double periods;               /* Number of periods that were used; NAN if it does not apply. */
    double t;                     /* Time [s] of an amplitude; else NAN. */
    bool energy;                  /* The energy was measured. */
    size_t statement;             /* Number of the statement that made it, from 1. */
    char source[LIMIT_NAME + 16]; /* The object measured, such as "run 1" or "data swing3". */
};

extern const struct result_columns measurement_columns; /* Columns of struct measurement. */

struct session;

/* ---- live runs and the front end ---- */

/* State of a live run, which continues while panes are drawn. */
enum live_state { LIVE_IDLE, LIVE_RUNNING, LIVE_PAUSED, LIVE_DIVERGED };

/* The live run, which is the current run. */
struct live {
    enum live_state state;
    double speed; /* Simulated seconds per second; HUGE_VAL for as fast as possible. */
    /* The same, measured over the last second; shown if it is below `speed`. */
    double achieved;
    double fraction;  /* Fraction of the way to the target; negative if unknown. */
    double marks[32]; /* [s] latest times at which the user changed parameters of the run */
    int mark_count;
    bool pausing;   /* It is to pause after the current slice. */
    bool changing;  /* The current command changes the current run (private). */
    bool advancing; /* The current run is advancing: its stop is not yet known. */
};

/* ---- the history of what was typed (history.c) ---- */

/* Properties of an entry of the history. */
enum entry_flag {
    ENTRY_LINE = 1,      /* A line as it was read; its statements follow. */
    ENTRY_SOURCED = 2,   /* Read from a file that a statement executes. */
    ENTRY_WITHIN = 4,    /* Executed during the run of an earlier statement. */
    ENTRY_DONE = 8,      /* It succeeded. */
    ENTRY_CHANGED = 16,  /* It changed the session, even if it failed. */
    ENTRY_HAPPENED = 32, /* Its full text describes what happened instead: a run that was paused. */
    ENTRY_UNRECORDED = 64, /* It is not recorded. */
    ENTRY_NESTS = 128,     /* The entries that it executed follow it. */
    ENTRY_WRITES = 256,    /* It only wrote a file. */
    ENTRY_LOST = 512,      /* There was no memory for its full text. */
    ENTRY_UNDONE = 1024,   /* Undo took its effect back, and redo did not bring it again. */
};

/* A line or a statement; offsets are bytes since the beginning of the session. */
struct entry {
    size_t text, len; /* Offset and length of the text as typed, see history_text(). */
    /* Offset and length of the text that a script needs; full_len = 0 if it is the same. */
    size_t full, full_len;
    size_t output; /* Number of bytes at its end that redirect the result to a file. */
    unsigned flags;
};

/* The latest lines and statements in the order in which they began; entries do not change after
 * their end, except that undo and redo mark them. Entries and bytes are counted from the beginning
 * of the session; the oldest that are stored are entry `first` and byte text_first. */
struct history {
    struct buffer text;
    struct entry *entry;
    size_t first, count, capacity, text_first;
    /* Number of lines that were not read from files, and of those among them that are no longer
     * stored. */
    int lines, lines_gone;
    int done;               /* Number of statements that succeeded. */
    struct buffer happened; /* Effect of the current statement as commands; private. */
};

struct run_target; /* <hooke/run.h> */
struct snapshot;   /* an entry of undo, redo or checkpoints; private to undo.c */

/* Facts that a module reports of a growing recording, for panes and figures: SI, NAN if unknown. */
struct growing {
    /* Values for axes, which do not change while the motion hardly does: the period [s], the mean
     * over the last periods, and an amplitude within which the motion stays and of which it reaches
     * at least half. */
    double steady, middle, swing;
    double t_end;      /* [s] end of the recording if it is known */
    double late;       /* [s] age of the newest velocity relative to the newest sample */
    struct run *model; /* Run of the scene from the first swing on; NULL if none matches. */
    double offset;     /* Position of the recording at which `model` is at rest. */
};

struct module;

/* The part of a module: the state that it keeps in a session, see session_part() in
 * <hooke/module.h>. */
struct session_part {
    const struct module *module;
    void *state;
};
/* The parts of all modules that have one. */
struct session_parts {
    struct session_part item[LIMIT_MODULES];
    int count;
};

/* Typed models and lists of events, to which set-up, runs and undo point; freed when nothing points
 * to them. */
struct definitions {
    struct typed_models *models;
    struct events *events; /* Lists of events, linked, the newest first. */
    /* Number of lists, now and after the last session_sweep(). */
    size_t event_lists, event_lists_left;
};

/* The runs of a session. */
struct runs {
    struct run_slot *slot[LIMIT_RUNS];
    int count, current; /* Number of runs, and index of the current one or -1. */
    int next_number;    /* Number that users will see for the next run. */
    uint64_t next_id;   /* Identifier of its slot. */
};

/* Results of measurements and fits that expressions know by name, the newest last. */
struct named_results {
    struct named_value value[LIMIT_RESULTS];
    int count;
};

/* Results of studies, such as compare and sweep. */
struct studies {
    struct table_store found; /* Last table of each kind. */
    const char *last;         /* Kind of the last study, or NULL. */
    int at_run; /* runs.next_number at that time, by which one sees whether a run is more recent. */
    /* Number of points of the study in progress, for points per second; 0 if it reports none. */
    double points;
};

/* Undo, redo and checkpoints. */
struct undo {
    /* First `undos` entries to go back to, then `redos` entries to go forward to. */
    struct snapshot *state[LIMIT_UNDO];
    int undos, redos;
    struct snapshot *checkpoint[LIMIT_CHECKPOINTS];
    int checkpoints;
};

/* The file of `record FILE`, to which executed statements are appended. */
struct transcript {
    char *path; /* Path, or NULL if nothing is recorded. */
    int fd;
    /* clock_ns() when its content was last written to the disk; 0 if never. */
    int64_t synced;
    bool owed; /* More was appended since then. */
};

/* Options of the program that commands need. */
struct session_options {
    bool keep_going; /* -k: continue after errors */
    bool verbose;    /* -v: show lines of scripts before they are executed */
    bool safe;       /* --safe: write only below the current directory */
    /* Folder of a hand-in that is checked, while nothing may be written; or NULL. */
    const char *checking;
};

/* State of the statement that is executed, and of the whole execution. */
struct execution {
    bool confirmed; /* The user has confirmed it. */
    char *meant;    /* Text for the history instead of its own, or NULL; owned. */
    bool typed;     /* It was typed by a person. */
    int nesting;    /* Nesting of command_exec(). */
    /* A run was paused: the remaining statements of the line and file are not executed. */
    bool halted;
    bool reacting;  /* Commands of an event are executed, as a part of the statement that runs. */
    bool passing;   /* The run continues after them, so that changes are not reported each time. */
    bool restoring; /* A saved session is read: only statements that recreate it are allowed. */
    bool said_method; /* The user has been told that no method is set. */
    /* The user has been told the assumed duration and tolerance. */
    bool said_assumed;
    bool quit;             /* The user wants to leave. */
    int status;            /* Exit status so far. */
    struct arena leftover; /* Memory of statements that remained to be freed after Ctrl-C. */
};

/* A session; owns all of it but the objects of the front end. */
struct session {
    struct front front;
    struct session_parts *parts; /* State of modules. */
    struct setup setup;
    struct definitions definitions;
    struct runs runs;
    struct recording_slot *recording[LIMIT_RECORDINGS];
    /* Number of recordings, and index of the current one or -1. */
    int recordings, current_recording;
    /* The current recording is more recent than the run: `measure` acts on it. */
    bool data_is_latest;

    struct named_results results;
    /* [measurements] rows of `list measurements`. */
    struct measurement *measurement;
    int measurements;
    struct studies studies;
    struct undo undo;
    struct history history;
    struct execution execution;
    struct transcript transcript;
    struct session_options options;
    uint64_t changes; /* Number of changes, by which saving knows whether there is something new. */

    struct view view;
    struct log log;
    struct live live;
    /* State of a recording that grows, during which only some commands are allowed; else NULL. */
    const struct growing *growing;
};

/* Creates a session with the lab's defaults and a copy of *front. Returns NULL if out of memory. */
struct session *session_create(const struct front *front);
/* Frees a session with all that it owns; NULL is allowed. */
void session_destroy(struct session *session);
/* Frees the state of all modules. */
void session_free_parts(struct session *session);
/* Appends commands that recreate the set-up, except for settings of the display. */
void session_save(const struct session *session, struct buffer *text);
/* Appends those of the commands on which trajectories depend: neither recordings nor display. */
void session_save_motion(const struct session *session, struct buffer *text);
/* Appends commands for all of the set-up, as the session's own file needs it: with the display,
 * without recordings. */
void session_save_setup(const struct session *session, struct buffer *text);
/* Returns true if the parameter only sets the start of a run. */
bool param_is_start(const struct scene *scene, int index);
/* Returns true if a short description of the scene shows the parameter: for an oscillator m, k and
 * others that were set; for other models those with an effect; none that is 0. */
bool param_matters(const struct scene *scene, int index);
/* Returns the settings of a new run: dt, tol (0 unless the method adapts), drag, recording. */
struct run_settings session_run_settings(const struct session *session);
/* Returns the first step [s] of adaptive methods: the setting dt if the user has set it, else the
 * scene's. */
double session_first_step(const struct session *session);
/* Appends the state in one line: "spring m=200 g k=15 N/m | euler dt=10 ms | t=9.6 s". */
void session_state_line(const struct session *session, struct buffer *text);

/* Returns the current run, or NULL if there is none. */
static inline struct run *session_run(const struct session *session)
{
    return session->runs.current >= 0 ? session->runs.slot[session->runs.current]->run : NULL;
}

/* Returns true if the recording is being collected. */
static inline bool session_grows(const struct session *session, const struct recording *recording)
{
    for (int i = 0; session->growing && i < session->recordings; i++)
        if (session->recording[i]->growing && session->recording[i]->recording == recording)
            return true;
    return false;
}

/* Returns the current recording, or NULL if there is none. */
static inline struct recording *session_recording(const struct session *session)
{
    return session->current_recording >= 0
               ? session->recording[session->current_recording]->recording
               : NULL;
}

/* Returns the characters for figures: those of the setting, or those that suit the terminal. */
const struct charset *session_charset(const struct session *session);

/* Notes that a statement, by its number, has set the parameters that differ from those of
 * `previous`. */
void session_trace(struct session *session, const struct scene *previous, size_t statement);
/* Notes a change, for saving and drawing. */
void session_changed(struct session *session);
/* Adds a run, which the session then owns, and makes it the current one. Returns false, with
 * `error` set and the run destroyed, if that fails. session_add_recording() does the same with a
 * recording. */
bool session_add_run(struct session *session, struct run *run, struct error *error);
bool session_add_recording(struct session *session, struct recording *recording,
                           const char *options, struct error *error);
/* Remove a run or recording from the session; undo entries may still own it. */
void session_drop_run(struct session *session, int index);
void session_drop_recording(struct session *session, int index);
/* Give up one reference; the last one frees the slot with its run or recording. */
void run_slot_release(struct run_slot *slot);
void recording_slot_release(struct recording_slot *slot);
/* Return the index of the run with this number or name, or of the recording with this name; -1 if
 * there is none. */
int session_find_run(const struct session *session, struct text name);
int session_find_recording(const struct session *session, struct text name);
/* Stores a result [SI] under a name for expressions, in place of one of the same name or, if there
 * are too many, of the oldest. */
void session_set_result(struct session *session, const char *name, struct measured value,
                        enum quantity quantity);
/* Returns what the session may write, with `force` as given. */
struct write_policy session_policy(const struct session *session, bool force);
/* Sets the method of a new session, as if the user had chosen none. */
void session_unset_method(struct setup *setup);
/* Sets all settings to those of a new session. */
void session_default_settings(struct settings *settings);
/* Returns true unless the setting follows the scene, see settings_of_scene(), because the user has
 * not set it. */
bool setting_is_chosen(const struct setting *setting, const struct settings *settings);
/* Notes that the user has set the setting, or not; without effect for those that never follow the
 * scene. */
void setting_choose(const struct setting *setting, bool chosen, struct settings *settings);
/* Appends a remark on the tolerance that is used instead of one below 10 eps; nothing for others.
 */
void put_tol_floor(struct buffer *text, double tol);
/* Sets those settings to the preset's values that follow the scene and are not set: duration,
 * tolerance. */
void settings_of_scene(struct settings *settings, const struct preset *preset);
/* Copies the settings of the display, on which no run depends, from `source`. */
void settings_display(struct settings *settings, const struct settings *source);
/* Returns the size of the output: that of the settings, of the front end, or 80x24. */
void session_size(const struct session *session, int *width, int *height);

/* Takes a snapshot of set-up and lists, to which undo can return. Returns NULL if out of memory;
 * free it by snapshot_free() unless undo_push() takes it. */
struct snapshot *snapshot_take(const struct session *session, const char *label);
/* Frees a snapshot; NULL is allowed. */
void snapshot_free(struct snapshot *snapshot);
void run_unmark(struct run_slot *slot); /* Forgets the run's mark of the latest undo entry. */
/* Returns true if going back to the snapshot would change anything. */
bool undo_matters(const struct session *session, const struct snapshot *previous);
/* Adds a snapshot, which undo then owns, as the state before that statement of the history. */
void undo_push(struct session *session, struct snapshot *previous, size_t statement);
/* Frees all entries of undo and redo. */
void undo_clear(struct session *session);
/* Return true if the snapshot, scene, set-up or run uses the model or the events; either may be
 * NULL and is then ignored. */
bool snapshot_uses(const struct snapshot *snapshot, const struct model *model,
                   const struct events *events);
bool scene_uses(const struct scene *scene, const struct model *model);
bool setup_uses(const struct setup *setup, const struct model *model, const struct events *events);
bool run_slot_uses(const struct run_slot *slot, const struct model *model,
                   const struct events *events);
/* Frees typed models and lists of events that nothing uses. Not while a statement is executed. */
void session_sweep(struct session *session);

/* ---- live runs ---- */

/* Advances a run to a target in slices of at most 10 ms, between which front.slice() polls the
 * front end; with `clocked`, simulated time follows the clock. Returns when the target is reached
 * or the run is paused: then run->stop is STOP_CANCELLED. */
void live_advance(struct session *session, struct run *run, const struct run_target *target,
                  bool clocked);
/* Sets state and marks of session->live from the current run. */
void live_refresh(struct session *session);
/* Applies a changed parameter of the scene to the current run if that is in progress, paused, or
 * the current command changes it. Sets *t_start to the time [s] of the change, or to NAN if there
 * is no such run. Returns false, with `error` set and the run unchanged, if it cannot be changed.
 */
bool live_bind(struct session *session, int param, double *t_start, struct error *error);
/* Sets a variable of the current run, which must exist, to a value [SI]. Returns false, with
 * `error` set and the run unchanged, on failure. */
bool live_kick(struct session *session, int variable, double value, struct error *error);
/* Appends " from t = 3.2 s on", or nothing if t_start is NAN. */
void buffer_since(struct buffer *text, double t_start);
