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
    struct scene scene; /* Model and parameters. */
    /* [owns] scenes that the user has made by typing all equations, with the values of their last
     * change; `scene NAME` finds them. */
    const struct preset *own[LIMIT_OWN];
    int owns;                    /* Number of elements of `own`. */
    const struct events *events; /* Events of the next run, or NULL. */
    const struct method *method;
    bool method_chosen; /* The user has chosen the method. */
    enum drag drag;     /* Variant of drag; DRAG_DEFAULT stands for the default of the method. */
    /* Steps are fixed although the method can adapt them, because the user gave dt= with the
     * method. */
    bool fixed;
    struct settings settings;          /* Settings of `set`. */
    struct named_value let[LIMIT_LET]; /* [lets] values that the user has named by `let`. */
    int lets;
    /* [parameters of the scene] number, from 1, of the statement that last set the parameter; 0 if
     * no statement has set it. */
    uint32_t origin[PARAM_MAX];
    /* Calibration of recordings that are collected from a sensor. */
    struct calibration calibration;
};

/* A request to a run, such as to continue, to change a parameter or to go back
 * (<hooke/session/log.h>). */
struct request;

/* A run with what the session stores about it. The session and undo entries share slots by counting
 * references. */
struct run_slot {
    struct run *run; /* The run, owned. */
    int references;  /* Number of owners of the slot: the session and undo entries. */
    char *note;      /* Note of the user, or NULL; owned. */
    /* Newest request of the run's journal, the linked list of requests that make the same run
     * again, bit for bit. Shared with undo entries; NULL if the journal is empty. */
    struct request *last;
    /* Mark of the run in the latest undo entry: the step, time and name to which undo returns.
     * Private to undo.c; NULL if no undo entry contains the run. */
    struct run_mark *mark;
    const struct events *events; /* Events of the run, or NULL. */
    size_t statement;            /* Number of the statement that made the run, from 1. */
    uint32_t origin[PARAM_MAX];  /* Copy of setup.origin from the start of the run. */
    uint64_t id;                 /* Identifier of the slot in the session's file. */
};

/* A row of the list of runs. */
struct run_row {
    const struct run_slot *slot;
    const struct run *run; /* The slot's run. */
    bool current;          /* The run is the current one. */
};

extern const struct result_columns run_columns; /* Columns of struct run_row. */

/* A recording with what the session stores about it. The session and undo entries share slots by
 * counting references. */
struct recording_slot {
    struct recording *recording; /* The recording, owned. */
    int references;              /* Number of owners of the slot. */
    /* Options of `load`, after the file name, that load the same recording again; owned. */
    char *options;
    /* bytes_sum() of the recording's file. The session's file stores a copy of the content under
     * this sum. 0 if not computed. */
    uint64_t sum;
    /* Content of the recording's file, if the file may have been deleted; empty if saving can read
     * the file again. */
    struct buffer content;
    size_t statement; /* Number of the statement that loaded the recording, from 1. */
    /* The recording is being collected from a sensor. Its file remains, so that `content` is not
     * needed. */
    bool growing;
};

/* Largest number of names in struct exact_names. */
#define EXACT_NAMES 8
/* Names of the values without an uncertainty that a result was computed from, and that count as
 * exact. An empty name ends the list. */
struct exact_names {
    char name[EXACT_NAMES][LIMIT_NAME + 1];
};

/* A row of `list measurements`. */
struct measurement {
    char quantity[24];            /* Name of the quantity, such as "period". */
    struct exact_names exact;     /* Values that were taken as exact. */
    struct measured value;        /* The result [SI]. */
    enum quantity unit;           /* Physical quantity of `value`. */
    double periods;               /* Number of periods that were used, NAN if none were. */
    double t;                     /* Time [s] to which an amplitude belongs; else NAN. */
    bool energy;                  /* The series of the energy was measured, not the position. */
    size_t statement;             /* Number of the statement that measured, from 1. */
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
    /* Simulated seconds per second, averaged over the last second of wall time; the screen shows it
     * if it is below `speed`. */
    double achieved;
    double fraction; /* Fraction of the time to the target that is done; negative if unknown. */
    /* [mark_count] latest times [s] at which the user changed parameters of the run; panes mark
     * them on the time axis. */
    double marks[32];
    int mark_count;
    bool pausing; /* Pausing was requested: the run stops after the current slice. */
    /* The command `change` is being executed, which sets a value of the current run; private. */
    bool changing;
    bool advancing; /* The current run is being advanced; run->stop is not yet set. */
};

/* ---- the history of what was typed (history.c) ---- */

/* Properties of an entry of the history. */
enum entry_flag {
    ENTRY_LINE = 1,     /* A line as it was read; its statements follow. */
    ENTRY_SOURCED = 2,  /* Read from a file that a statement executes. */
    ENTRY_WITHIN = 4,   /* Executed while the run of an earlier statement was in progress. */
    ENTRY_DONE = 8,     /* The statement succeeded. */
    ENTRY_CHANGED = 16, /* The statement changed the session, even if it failed. */
    /* The full text is that of commands with the effect that the statement had, because it was
     * interrupted or other commands changed its run. */
    ENTRY_HAPPENED = 32,
    ENTRY_UNRECORDED = 64, /* `record` does not write the statement. */
    ENTRY_NESTS = 128,     /* The statement executed others, whose entries follow. */
    ENTRY_WRITES = 256,    /* The statement only wrote a file. */
    ENTRY_LOST = 512,      /* Memory for the full text was missing. */
    ENTRY_UNDONE = 1024,   /* Undo took the statement's effect back, and redo did not restore it. */
};

/* A line or a statement of the history. Offsets count the bytes of all texts that were added since
 * the beginning of the session. */
struct entry {
    size_t text, len; /* Offset and length of the text as typed, see history_text(). */
    /* Offset and length of the full text, by which a script repeats the statement (with names of
     * files, --force); full_len = 0 if the text as typed does. */
    size_t full, full_len;
    size_t output;  /* Number of bytes at the end of the full text that are `> FILE`. */
    unsigned flags; /* Flags of enum entry_flag. */
};

/* The latest lines and statements in the order in which they began. After its statement has
 * ended only undo and redo change an entry. Entries and bytes are counted from the beginning of the
 * session; older ones than entry `first` and byte text_first have been dropped. */
struct history {
    struct buffer text;  /* Texts of the entries, from byte text_first on. */
    struct entry *entry; /* Entries from `first` to count - 1, at index 0 and up; owned. */
    size_t first, count, capacity, text_first;
    /* Number of lines that were not read from files, and how many of these have been dropped. */
    int lines, lines_gone;
    int done;               /* Number of statements that succeeded. */
    struct buffer happened; /* Full text for ENTRY_HAPPENED of the current statement; private. */
};

struct run_target; /* <hooke/run.h> */
struct snapshot;   /* an entry of undo, redo or checkpoints; private to undo.c */

/* Facts about a recording that is being collected, which a module reports to panes and figures. In
 * SI units; NAN if unknown. */
struct growing {
    /* Period [s], mean and amplitude of the motion, for the axes of live plots: each is replaced
     * only when it has changed noticeably, so that axes do not move with each sample. The amplitude
     * `swing` is at least that of the motion and at most twice as large. */
    double steady, middle, swing;
    double t_end; /* [s] end of the recording if it is known */
    double late;  /* [s] time of the newest sample minus that of the newest velocity */
    /* Run of the session's scene from the recorded start on, for comparison; NULL if the scene does
     * not match the recording. */
    struct run *model;
    double offset; /* Recorded position that corresponds to the equilibrium of `model`. */
};

struct module;

/* The part of a module is its own state in a session, see session_part() in <hooke/module.h>. */
struct session_part {
    const struct module *module;
    void *state; /* module->part_size bytes, owned. */
};
/* The parts of all modules whose part has been made. */
struct session_parts {
    struct session_part item[LIMIT_MODULES]; /* [count] */
    int count;
};

/* Typed models and lists of events, to which set-up, runs and undo point; freed when nothing points
 * to them. */
struct definitions {
    struct typed_models *models; /* Models made by typing equations. */
    struct events *events;       /* Lists of events, linked, the newest first. */
    /* Number of lists, and how many of them the last session_sweep() left. */
    size_t event_lists, event_lists_left;
};

/* The runs of a session. */
struct runs {
    struct run_slot *slot[LIMIT_RUNS]; /* [count] */
    int count, current;                /* Number of runs, and index of the current one or -1. */
    int next_number;                   /* Number that users will see for the next run. */
    uint64_t next_id;                  /* Identifier of the next slot, see run_slot.id. */
};

/* Results of measurements and fits that expressions can use by name, the newest last. */
struct named_results {
    struct named_value value[LIMIT_RESULTS]; /* [count] */
    int count;
};

/* Results of studies, such as compare and sweep. */
struct studies {
    struct table_store found; /* Last table of each kind. */
    const char *last;         /* Kind of the last study, or NULL. */
    /* runs.next_number when `last` was made: if it has changed, a run has been made since. */
    int at_run;
    /* Number of points of the study in progress, from which the progress line computes points per
     * second; 0 if the study reports no points. */
    double points;
};

/* Undo, redo and checkpoints. */
struct undo {
    /* [undos + redos] states to which undo returns, the oldest first, then those to which redo
     * returns. */
    struct snapshot *state[LIMIT_UNDO];
    int undos, redos;
    struct snapshot *checkpoint[LIMIT_CHECKPOINTS]; /* [checkpoints] */
    int checkpoints;
};

/* The file of `record FILE`, to which executed statements are appended. */
struct transcript {
    char *path; /* Path, or NULL if nothing is recorded. */
    int fd;     /* File descriptor, open while `path` is set. */
    /* clock_ns() when the content was last flushed to the disk; 0 if never. */
    int64_t synced;
    bool owed; /* Statements appended since `synced` have not been flushed. */
};

/* Options of the program that commands need. */
struct session_options {
    bool keep_going; /* Option -k, which continues scripts after errors. */
    bool verbose;    /* Option -v, which shows lines of scripts before they are executed. */
    bool safe;       /* Option --safe, which allows writing only below the current directory. */
    /* Folder of a student's hand-in that is being checked, or NULL. Commands may write no file
     * meanwhile. */
    const char *checking;
};

/* State of the statement that is executed, and of the whole execution. */
struct execution {
    bool confirmed; /* The user has confirmed that the statement may take long. */
    /* Statement that the history records instead of the one that was typed, or NULL; owned. */
    char *meant;
    bool typed;  /* The statement was typed by a person. */
    int nesting; /* Number of calls of command_exec() that have not returned. */
    /* A run was paused, so that the remaining statements of the line and file are skipped. */
    bool halted;
    bool reacting; /* Commands of an event are being executed, within the run's statement. */
    /* The event's commands end in `continue`, so that they do not report each change. */
    bool passing;
    /* A saved session is being read; only statements that recreate a session are allowed. */
    bool restoring;
    bool said_method;  /* reply_unchosen() has warned that no method was chosen. */
    bool said_assumed; /* reply_assumed() has reported the assumed duration and tolerance. */
    bool quit;         /* `quit` was executed: no further statements are. */
    int status;        /* Exit status so far. */
    /* Memory of statements that could not be freed before Ctrl-C stopped them; freed later. */
    struct arena leftover;
};

/* A session; owns all of it but the objects of the front end. */
struct session {
    struct front front;          /* The front end: its callbacks and properties. */
    struct session_parts *parts; /* State of each module in this session. */
    struct setup setup;          /* Scene, method and settings of the next run. */
    struct definitions definitions;
    struct runs runs;
    struct recording_slot *recording[LIMIT_RECORDINGS]; /* [recordings] */
    /* Number of recordings, and index of the current one or -1. */
    int recordings, current_recording;
    /* The current recording was chosen after the current run, so that `measure` acts on the
     * recording. */
    bool data_is_latest;

    struct named_results results; /* Results that expressions can use. */
    /* [measurements] rows of `list measurements`. */
    struct measurement *measurement;
    int measurements;
    struct studies studies;
    struct undo undo;
    struct history history;
    struct execution execution;
    struct transcript transcript;
    struct session_options options;
    uint64_t changes; /* Number of changes so far, by which saving detects new ones. */

    struct view view; /* Panes, focus, zoom and cursors of the screen. */
    struct log log;   /* Lines of the log pane. */
    struct live live;
    /* Facts about the recording that is being collected, or NULL if none is. While it is set only
     * commands with COMMAND_ANYTIME or COMMAND_BESIDE are allowed. */
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
/* Does the same for the part of the set-up on which trajectories depend, without recordings and
 * display. */
void session_save_motion(const struct session *session, struct buffer *text);
/* Appends commands for all of the set-up, as the session's own file needs it: with the display,
 * without recordings. */
void session_save_setup(const struct session *session, struct buffer *text);
/* Returns true if parameter `index` of the scene only sets the start of a run, as y0 and t0 do. */
bool param_is_start(const struct scene *scene, int index);
/* Returns true if a short description of the scene shows parameter `index`. Parameters of value 0
 * are not shown; an oscillator shows m, k and those that were set, other models those with an
 * effect. */
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

/* Records statement number `statement` as the origin (setup.origin) of the parameters that differ
 * from those of the scene `previous`. */
void session_trace(struct session *session, const struct scene *previous, size_t statement);
/* Counts a change of the session, so that it is saved and drawn anew. */
void session_changed(struct session *session);
/* Add a run or recording, which the session then owns, and make it the current one. `options` are
 * those of `load` (recording_slot.options), copied. Return false, with `error` set and the object
 * destroyed, if that fails. */
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
/* Returns the policy for writing files under the options of the session; with `force` existing
 * files may be replaced. */
struct write_policy session_policy(const struct session *session, bool force);
/* Sets the method of a new session, as if the user had chosen none. */
void session_unset_method(struct setup *setup);
/* Sets all settings to those of a new session. */
void session_default_settings(struct settings *settings);
/* Returns false if the setting follows the scene (settings_of_scene()) and the user has not set it,
 * else true. */
bool setting_is_chosen(const struct setting *setting, const struct settings *settings);
/* Records in `settings` that the user has set the setting (`chosen`) or has not; has no effect on
 * settings that never follow the scene. */
void setting_choose(const struct setting *setting, bool chosen, struct settings *settings);
/* Appends the remark that 10 eps is used as the tolerance if tol is positive and smaller; otherwise
 * appends nothing. */
void put_tol_floor(struct buffer *text, double tol);
/* Sets the settings that follow the scene (duration, tolerance) to the values of the preset, except
 * for those that the user has set. */
void settings_of_scene(struct settings *settings, const struct preset *preset);
/* Copies the settings of the display, on which no run depends, from `source`. */
void settings_display(struct settings *settings, const struct settings *source);
/* Sets *width and *height to the size of the output [cell]: that of the settings or, if they have
 * none, of the front end, or else 80x24. */
void session_size(const struct session *session, int *width, int *height);

/* Takes a snapshot of the set-up and of the lists of runs and recordings, to which undo can return.
 * `label` is the name of a checkpoint, or "". Returns NULL if out of memory; free the snapshot by
 * snapshot_free() unless undo_push() takes it. */
struct snapshot *snapshot_take(const struct session *session, const char *label);
/* Frees a snapshot; NULL is allowed. */
void snapshot_free(struct snapshot *snapshot);
/* Releases slot->mark. */
void run_unmark(struct run_slot *slot);
/* Returns true if going back to the snapshot would change anything. */
bool undo_matters(const struct session *session, const struct snapshot *previous);
/* Adds a snapshot, which undo then owns, as the state before statement number `statement` of the
 * history. */
void undo_push(struct session *session, struct snapshot *previous, size_t statement);
/* Frees all entries of undo and redo. */
void undo_clear(struct session *session);
/* Return true if the snapshot, scene, set-up or run refers to the typed model or to the list of
 * events; `model` and `events` may be NULL and are then ignored. */
bool snapshot_uses(const struct snapshot *snapshot, const struct model *model,
                   const struct events *events);
bool scene_uses(const struct scene *scene, const struct model *model);
bool setup_uses(const struct setup *setup, const struct model *model, const struct events *events);
bool run_slot_uses(const struct run_slot *slot, const struct model *model,
                   const struct events *events);
/* Frees typed models and lists of events that nothing uses. Must not be called while a statement is
 * executed. */
void session_sweep(struct session *session);

/* ---- live runs ---- */

/* Advances a run to a target in slices of at most 10 ms, between which front.slice() polls the
 * front end; with `clocked`, simulated time follows the clock at live.speed. Returns when the
 * target is reached, or when the run is paused, with run->stop = STOP_CANCELLED. */
void live_advance(struct session *session, struct run *run, const struct run_target *target,
                  bool clocked);
/* Sets `state`, `marks` and mark_count of session->live from the current run. */
void live_refresh(struct session *session);
/* Applies parameter `param` of setup.scene to the current run from its current time on if the run
 * is in progress or is paused and the statement was typed, and in commands of events and `change`.
 * Sets *t_start to the time [s] of the change, or to NAN if no run is changed. Returns false, with
 * `error` set and the run unchanged, if the run does not allow the change. */
bool live_bind(struct session *session, int param, double *t_start, struct error *error);
/* Sets state variable `variable` of the current run, which must exist, to a value [SI] by
 * run_kick(). Returns false, with `error` set and the run unchanged, on failure. */
bool live_kick(struct session *session, int variable, double value, struct error *error);
/* Appends " from t = 3.2 s on", or nothing if t_start is NAN. */
void buffer_since(struct buffer *text, double t_start);
