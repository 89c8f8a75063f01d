/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * session: set-up, settings, runs, recordings, what the screen shows. It changes only by executing
 * command lines.
 */
#ifndef HOOKE_SESSION_H
#define HOOKE_SESSION_H

#include <hooke/analysis/fit.h>
#include <hooke/study/compare.h>
#include <hooke/study/fit.h>
#include <hooke/study/sweep.h>
#include <hooke/session/screen.h>
#include <hooke/session/settings.h>

/* ---- the session ---- */

struct named_value {
    char name[LIMIT_NAME + 1];
    double value, uncertainty; /* SI */
    enum quantity quantity;    /* QUANTITY_OTHER: unknown */
    double below; /* of a state: no digit is certain, errors may be that and more; 0: they are */
};

/* private: what is watched for on the way; a list never changes and lives as long as its session */
struct events;

/* The part that is plain data: undo copies it. */
struct setup {
    struct scene scene;
    const struct preset
        *own[LIMIT_OWN]; /* scenes that are all typed, as they were when last changed */
    int owns;
    const struct events *events; /* of the next run; NULL: none */
    const struct method *method;
    bool method_chosen; /* by name */
    enum drag drag;     /* DRAG_DEFAULT: the method's own */
    bool fixed;         /* dt= was given with the method: fixed steps although it could adapt */
    struct settings settings;
    struct named_value let[LIMIT_LET];
    int lets;
    /* which statement of the log gave each parameter its value, counted from 1; 0: the scene */
    uint32_t origin[PARAM_MAX];
    struct calibration calibration; /* of what is collected */
};

/* private: one thing that was asked of a run (go there, change a parameter, go back) */
struct request;

/* Runs and recordings are shared by the session and its undo entries. */
struct run_slot {
    struct run *run;
    int references;
    char *note; /* NULL: none */
    /* the end of the list of what was asked of the run since its start, which recreates it bit
     * for bit; shared with undo entries. NULL: nothing yet */
    struct request *last;
    struct run_mark *mark;       /* private to undo.c: as the latest entry has it, NULL: none */
    const struct events *events; /* as they were when it began; NULL: none */
    size_t statement;            /* of the log that made it, counted from 1 */
    uint32_t origin[PARAM_MAX];  /* that of the set-up when it began */
    uint64_t id;                 /* in the session's file: no other slot has it */
};

struct run_row { /* a run in the list of them */
    const struct run_slot *slot;
    bool current;
};

extern const struct result_columns run_columns; /* of struct run_row */

struct recording_slot {
    struct recording *recording;
    int references;
    char *options; /* as they have to stand after the file name to load it again */
    uint64_t sum;  /* of the file's bytes, as the session's file has it; 0: nobody has looked */
    struct buffer content; /* the file's bytes, where it may be gone; empty: it is read again */
    bool growing;          /* it is being collected: its file is safe, and read again */
};

/* Values that a result took as exact, since nobody stated an uncertainty; "": no more. */
#define EXACT_NAMES 8
struct exact_names {
    char name[EXACT_NAMES][LIMIT_NAME + 1];
};

struct measurement {
    char quantity[24];
    struct exact_names exact;
    struct measured value;
    enum quantity unit;
    double periods;           /* NAN: does not apply */
    double at;                /* [s] of an amplitude; NAN */
    bool energy;              /* of the energy */
    size_t statement;         /* of the log that made it, counted from 1 */
    char of[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
};

extern const struct result_columns measurement_columns; /* of struct measurement */

/* A fit that converged, for the report. */
struct stored_fit {
    struct fit fit;
    enum quantity quantity; /* of what was fitted */
    struct measured k;      /* NAN: nobody had said what the mass is */
    struct exact_names exact;
    size_t statement; /* of the log that made it, counted from 1: session_store_fit() says so */
    char of[LIMIT_NAME + 16];
};

struct session;

/* ---- live runs and the front end ---- */

/* A run that goes on while a person watches. */
enum live_state { LIVE_IDLE, LIVE_RUNNING, LIVE_PAUSED, LIVE_DIVERGED };

struct live {
    enum live_state state;
    double speed; /* simulated seconds a second; HUGE_VAL: as fast as possible */
    /* the same, measured over the last second; below speed: "RUNNING 0.4x (CPU)" */
    double achieved;
    double fraction;  /* of the way to the target, < 0: unknown */
    double marks[32]; /* [s] the latest times at which parameters were changed during the run */
    int mark_count;
    bool pausing;   /* asked to pause at the next look */
    bool changing;  /* private: the present command changes the current run */
    bool advancing; /* the current run is on its way: what it stopped at is not yet known */
};

/* ---- the log of what was typed (history.c) ---- */

enum entry_flag {
    ENTRY_LINE = 1,        /* a line as it came; its statements follow */
    ENTRY_SOURCED = 2,     /* of a file that a statement reads */
    ENTRY_WITHIN = 4,      /* while the run of the statement before went on */
    ENTRY_DONE = 8,        /* it succeeded */
    ENTRY_CHANGED = 16,    /* it changed the session, also if it failed */
    ENTRY_HAPPENED = 32,   /* its text in full is what happened: a run that was paused */
    ENTRY_UNRECORDED = 64, /* what it did leaves no trace */
    ENTRY_NESTS = 128,     /* what it read stands after it */
    ENTRY_WRITES = 256,    /* all it did was to write a file */
    ENTRY_LOST = 512,      /* there was no memory for what happened */
};

struct entry {
    size_t text, len;      /* as it came, in history.text: history_text() */
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
    struct buffer happened; /* private: what the statement in hand really did, as commands */
};

struct snapshot; /* private: undo, redo, checkpoints */

/* ---- lines as they come, for `collect` ---- */

enum feed_end {
    FEED_GOES_ON,
    FEED_ENDED,     /* whoever wrote there has closed it */
    FEED_UNPLUGGED, /* the device is gone */
    FEED_IN_TIME,   /* what comes now is not wanted any more */
    FEED_FULL,      /* as many lines as were wanted, or the file may have */
    FEED_FAILED     /* the file cannot be written: what is in it is whole */
};

struct feed_request {
    const char *source; /* a device, a pipe, a file that grows, STANDARD_INPUT */
    int file;           /* descriptor that each complete line is appended to; the feed closes it */
    long baud;          /* of a serial line */
    double from;        /* [s] time at which it begins */
    uint64_t max;       /* lines */
    bool safe;          /* devices are refused */
};

struct feed_look {
    enum feed_end end;
    uint64_t lines, bytes; /* lines in the file, bytes that came */
    double now;            /* [s] */
    double first, last;    /* [s] when these lines came; NAN: none has */
    uint64_t unwritten;    /* lines that came, and that the file did not take */
    char failure[80];      /* why FEED_FAILED, or FEED_UNPLUGGED: "", it hung up */
};

struct feed; /* private to the front end: reads in a thread of its own, so that none waits */

struct feed_access {
    struct feed *(*open)(const struct feed_request *request, struct error *error);
    void (*look)(struct feed *feed, struct feed_look *look);
    void (*pause)(struct feed *feed, bool pause); /* what comes meanwhile is dropped */
    /* [s] lines that come later are not wanted, and end it; HUGE_VAL: all are */
    void (*until)(struct feed *feed, double end);
    /* the device is as it was before; the last look is at all that came */
    void (*close)(struct feed *feed, struct feed_look *look);
    /* A Ctrl-C that ended the collecting ends nothing else. */
    void (*heeded)(void);
};

enum front_change { FRONT_PANES, FRONT_PLAIN, FRONT_REDRAW };

/* What the front end offers; the session only calls it. Every callback may be NULL. */
struct front {
    /* a person types: prefixes of names are accepted, long runs are asked about instead of
     * refused */
    bool interactive;
    bool utf8, color;  /* what the output can show */
    int width, height; /* [cell] of the output, 0: 80x24 */
    bool input; /* standard input is free for data: nobody types there, and no commands come */
    const struct feed_access *feed; /* NULL: none */
    const struct cancel *cancel;
    void *context;
    bool (*confirm)(void *context, const char *question);
    /* between slices; fraction < 0: unknown; > 1: over, erase; run NULL: a study */
    void (*progress)(void *context, const struct run *run, double fraction);
    void (*clear)(void *context);
    /* a line was executed, also one of a file: the session can be kept */
    void (*executed)(void *context);
    /*
     * Live runs. `watched`: a person watches a screen of panes. Then run and continue advance in
     * slices of at most 10 ms and call `slice` between them: it polls the terminal, executes what
     * was typed (command_exec may be called again from inside; what would disturb the run is
     * refused) and draws. It returns at the latest at `until` [clock_ns]; false: pause.
     */
    bool watched;
    bool (*slice)(void *context, struct session *session, int64_t until);
    /* Draws the present screen into a file, as ncurses would show it (batch: of front.width x
     * height). */
    bool (*screenshot)(void *context, const struct session *session, const char *path,
                       struct write_policy policy, struct error *error);
    /* The same as lines of text, for `screenshot` without a file. */
    bool (*screen)(void *context, const struct session *session, struct buffer *text,
                   struct error *error);
    /* Takes what `export -` would write; false: no memory. NULL: it is written. */
    bool (*table)(void *context, const struct table *table);
    /* [s] from, to of the time axis on that screen; false: it has none. */
    bool (*time_shown)(void *context, const struct session *session, double span[2]);
    /* Shows a figure as pixels, width x height cells; figure NULL: only asks whether that can be.
     * False: it cannot, for the reason in `error`. NULL: never here. */
    bool (*pixels)(const struct front *front, const struct figure *figure, int width, int height,
                   struct error *error);
    /* Changes of the front end itself; false: not possible here, with the reason. */
    bool (*change)(void *context, enum front_change change, struct error *error);
};

/* What `adopt` took last: the scene as it became, and covariances of what is uncertain in it. */
struct adopted_fit {
    struct scene scene; /* model NULL: nothing was adopted */
    struct scene_covariance known;
    struct exact_names exact;
    char of[LIMIT_NAME + 16]; /* "data swing3": what was fitted */
};

/* The band of an adopted fit about a run, for the panes. */
struct fit_band {
    int run; /* its number; 0: none was looked for */
    size_t rows;
    double end; /* [s] rows and end of the run when it was */
    struct adopted_fit of;
    size_t n; /* 0: it has none */
    int variables;
    double from, step; /* [s] */
    double *half;      /* [variables][n] half the width */
};

/* A lesson that waits (`lab`): what it says, and which of its steps is to be done. */
struct lesson {
    struct buffer text;
    int step, steps; /* counted from 0; step == steps: it is over */
    size_t begun;    /* place in the log at which the step began */
    long seed;       /* of its recordings */
};

/* What `collect` is doing, for the screen and for what is typed meanwhile. */
struct collecting {
    enum { COLLECT_WAITING, COLLECT_GOES_ON, COLLECT_PAUSED } state; /* waiting for its trigger */
    bool stop;                                                       /* asked to */
    uint64_t lines;
    double seconds;           /* [s] since the first line, or the trigger, without pauses */
    double period, amplitude; /* [s], SI of the last few periods; NAN: not known */
    enum quantity quantity;   /* of the amplitude */
    /* the same for axes, which stay where they are while it hardly changes, and the mean over the
     * last periods, SI; an amplitude that is not left, nor half of it, SI; NAN: not known */
    double steady, middle, swing;
    double until; /* [s] of the recording, where it is known to end; NAN */
    double late;  /* [s] the newest velocity is older than the newest sample */
    struct {
        double t;                         /* [s] of the newest sample; NAN: there is no fit */
        struct measured period, gamma, k; /* NAN: not determined, k: nobody has said the mass */
    } fit;
    struct run *model; /* the scene, from the first swing on to now; NULL: none that would match */
    double offset;     /* of the recording where the model is at rest, SI */
    struct {           /* a calibration that waits for its points */
        bool waits;
        int taken; /* of two */
        double truth[2], read[2], scatter[2];
        const struct unit *truth_unit[2], *read_unit; /* NULL: none */
    } aim;
    struct feed *feed;
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

struct session {
    struct front front;
    struct session_parts *parts;
    struct setup setup;
    struct typed_models
        *models;           /* all that the user has typed: set-up, runs and undo point there */
    struct events *events; /* likewise, the newest first */
    size_t event_lists, event_lists_left; /* so many, and after the last sweep */
    struct run_slot *run[LIMIT_RUNS];
    int runs, current_run; /* index, -1: none */
    int next_run;          /* number of the next run */
    uint64_t next_id;      /* of its slot */
    bool said_method;      /* that nobody has chosen one */
    bool said_assumed;     /* which duration and tolerance this scene gets */
    struct recording_slot *recording[LIMIT_RECORDINGS];
    int recordings, current_recording; /* index, -1: none */
    bool data_is_latest; /* the recording is more recent than the run: measure acts on it */

    struct named_value result[LIMIT_RESULTS]; /* of measurements and fits */
    int results;
    bool has_fit;
    struct fit fit;
    char fit_of[LIMIT_NAME + 16]; /* "data swing3", "run 2" */
    double fit_zero;              /* of the recording at that time: its offset counts from there */
    /* Where the last fit was one of the scene or of a formula: */
    double *fit_curve[2]; /* [fit_samples] its times and values; NULL: fit_values() */
    size_t fit_samples;
    uint64_t fit_curve_sum;   /* under which the session's file has it; 0: not yet */
    struct scene fit_scene;   /* as fitted; model NULL: it was no fit of the scene */
    bool fit_free[PARAM_MAX]; /* what was fitted there */
    struct adopted_fit adopted;
    struct fit_band band;
    int fit_modes; /* so many damped sines at once; 0: it was no fit of modes */
    struct measurement *measurement;
    int measurements;
    struct stored_fit *stored_fit;
    int stored_fits;
    struct precision *precision; /* the last study, for `plot precision`; NULL: none */
    struct table_store found;    /* the last of each kind */
    const char *studied;         /* kind of the last study; NULL: none */
    int studied_runs; /* next_run at that time: after a later run its table is the latest */

    struct references references; /* of the scenes that were studied last */

    struct snapshot *state[LIMIT_UNDO]; /* the first `undos` go back, the others forward again */
    int undos, redos;
    struct snapshot *checkpoint[LIMIT_CHECKPOINTS];
    int checkpoints;

    struct history history;
    bool confirmed; /* the present statement was asked about, and allowed */
    char *meant;    /* what stands in the log for the present statement; NULL: itself */
    struct stopped_sweep *stopped; /* `continue` goes on with it; NULL: with the run */
    double study_points; /* of the study that goes on, for points a second; 0: it says none */
    char *record_path;   /* file that executed lines are appended to, NULL: none */
    int record_fd;
    int64_t record_synced; /* [ns] when what it holds was put on the disk; 0: never */
    bool record_owed;      /* more was written since then */
    bool keep_going;       /* option -k */
    bool verbose;          /* option -v: lines of scripts are shown before they are executed */
    bool safe;             /* option --safe: write only below the current directory */
    const char *checking;  /* the folder of a hand-in that is run again: nothing is written; NULL */
    bool quit;             /* the user asked to leave */
    int status;            /* exit status so far */
    uint64_t changes;      /* counts changes: autosave compares it */
    bool typed;            /* the statement being executed was typed by a person */
    int nesting;           /* command_exec inside command_exec */
    /* a run was paused: what stands after it on the line and in the file is not executed */
    bool halted;
    bool reacting; /* commands of an event are executed: part of the statement that ran into it */
    bool passing;  /* the run goes on after them: what they set is not told each time */
    struct arena leftover; /* of statements: what Ctrl-C left to be given back */
    bool restoring;        /* a session that saved itself is read: nothing but what recreates it */

    struct lesson *lesson; /* NULL: none */
    struct view view;
    struct log log;
    struct live live;
    struct collecting *collecting; /* NULL: nothing is collected now */
    bool fits_live;                /* what is collected next, or now, is fitted every second */
};

/* A sweep that Ctrl-C has stopped. */
struct stopped_sweep {
    char *statement;    /* what stood behind `sweep` */
    struct buffer made; /* session_save_motion() then */
    struct sweep found; /* value NULL: what there is is in a file */
};

void session_forget_sweep(struct session *session);

/* A new session with the lab's defaults. NULL: no memory. */
struct session *session_create(const struct front *front);
void session_destroy(struct session *session);
/* Frees what modules keep in it. */
void session_free_parts(struct session *session);
/* Appends the commands that recreate the set-up; sourcing them gives the same state. */
void session_save(const struct session *session, struct buffer *text);
/* Of those only what trajectories depend on: neither recordings nor how things look. */
void session_save_motion(const struct session *session, struct buffer *text);
/* The parameter says where a run starts, and nothing else. */
bool param_is_start(const struct scene *scene, int index);
/* A short description of the scene holds it: m and k of an oscillator, of its many others those
 * that the user or the scene has set; of other models all that act; none that is 0. */
bool param_matters(const struct scene *scene, int index);
/* Of a new run: dt, tol (0 unless the method adapts), drag, recording. */
struct run_settings session_run_settings(const struct session *session);
/* [s] of methods that adapt: the setting dt where the user has set it, else the scene's own. */
double session_first_step(const struct session *session);
/* Short state for a prompt or a state line: "spring m=200 g k=15 N/m | euler dt=10 ms | t=9.6 s".
 */
void session_state_line(const struct session *session, struct buffer *text);

static inline struct run *session_run(const struct session *session)
{
    return session->current_run >= 0 ? session->run[session->current_run]->run : NULL;
}

/* It is the one that is being collected. */
static inline bool session_grows(const struct session *session, const struct recording *recording)
{
    for (int i = 0; session->collecting && i < session->recordings; i++)
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

enum charset session_charset(const struct session *session);

/* ---- the session ---- */

/* What differs from the scene `before` got its value by that statement. */
void session_trace(struct session *session, const struct scene *before, size_t statement);
void session_changed(struct session *session);
/* Takes the run over (also when it fails: then it is destroyed) and makes it the current one. */
bool session_add_run(struct session *session, struct run *run, struct error *error);
bool session_add_recording(struct session *session, struct recording *recording,
                           const char *options, struct error *error);
void session_drop_band(struct session *session);
void session_drop_run(struct session *session, int index);
void session_drop_recording(struct session *session, int index);
void run_slot_release(struct run_slot *slot);
void recording_slot_release(struct recording_slot *slot);
/* number or name; -1: none */
int session_find_run(const struct session *session, struct text name);
int session_find_recording(const struct session *session, struct text name); /* -1: none */
/* The latest one of each model, recording or run, and window; without memory it is only not in the
 * report. */
/* Values of the last fit at n ascending times [s]; NAN: outside of what it was fitted to. */
void session_fit_values(const struct session *session, const double *t, size_t n, double *value);
void session_store_fit(struct session *session, const struct stored_fit *fit);
void session_set_result(struct session *session, const char *name, struct measured value,
                        enum quantity quantity);
struct write_policy session_policy(const struct session *session, bool force);
/* That of a new session, which nobody has chosen. */
void session_unset_method(struct setup *setup);
void session_default_settings(struct settings *settings);
/* Whether the user has set it; what he has not may follow the scene: settings_of_scene(). */
bool setting_is_chosen(const struct setting *setting, const struct settings *settings);
void setting_choose(const struct setting *setting, bool chosen, struct settings *settings);
/* What a tolerance below 10 eps is really taken as; nothing for others. */
void put_tol_floor(struct buffer *text, double tol);
/* Duration and tolerance of the scene, unless they were set. */
void settings_of_scene(struct settings *settings, const struct preset *preset);
/* Those that only show become as in `from`: no undo, no run depends on them. */
void settings_display(struct settings *settings, const struct settings *from);
void session_size(const struct session *session, int *width, int *height);

/* NULL: no memory */
struct snapshot *snapshot_take(const struct session *session, const char *label);
void snapshot_free(struct snapshot *snapshot);
void run_unmark(struct run_slot *slot); /* forget how undo entries last saw it */
/* Whether going back to it would change anything. */
bool undo_matters(const struct session *session, const struct snapshot *before);
/* The state before that statement of the history. */
void undo_push(struct session *session, struct snapshot *before, size_t statement);
void undo_clear(struct session *session);
/* Whether going there needs it; NULL: not asked. */
bool snapshot_uses(const struct snapshot *snapshot, const struct model *model,
                   const struct events *events);
bool setup_uses(const struct setup *setup, const struct model *model, const struct events *events);
bool run_slot_uses(const struct run_slot *slot, const struct model *model,
                   const struct events *events);
/* Frees what was typed and nothing uses any more; not while a statement is executed. */
void session_sweep(struct session *session);

/* ---- live runs ---- */

/*
 * Advances to the target in slices of at most 10 ms, with a look at the front end between them;
 * `clocked`: simulated time follows the clock. Back when it is there, or paused: then run->stop is
 * STOP_CANCELLED.
 */
void live_advance(struct session *session, struct run *run, const struct run_target *target,
                  bool clocked);
/* State and marks of session->live follow from the current run. */
void live_refresh(struct session *session);
/*
 * A parameter of the scene has changed: takes it over into the run that goes on, is paused, or is
 * to be changed. *from [s]: since when, NAN: there is no such run. The run is unchanged on error.
 */
bool live_bind(struct session *session, int param, double *from, struct error *error);
/* Gives a variable of the current run's state, which there is, another value. */
bool live_kick(struct session *session, int variable, double value, struct error *error);
/* " from t = 3.2 s on", nothing where `from` is NAN. */
void buffer_since(struct buffer *text, double from);

#endif
