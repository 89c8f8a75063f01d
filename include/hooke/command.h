/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * command: the session and the language that changes it.
 *
 * A session changes only by executing command lines: scripts, keys, options, saved sessions and tests all go through
 * command_exec(). Handlers never print: they speak through a struct reply, which the front end connects to streams, a
 * log pane or a buffer.
 */
#ifndef HOOKE_COMMAND_H
#define HOOKE_COMMAND_H

#include <hooke/study.h>

/* ---- reply: what a command says ----
 *
 * Lines are for people, records for programs. FORMAT_TEXT writes lines and ignores records; FORMAT_JSON writes one
 * object a line, and the lines of a command that made no record as {kind, text}; FORMAT_CSV writes rows with a header
 * whenever the kind changes, lines without a record as comments.
 */

enum output_format { FORMAT_TEXT, FORMAT_CSV, FORMAT_JSON };

extern const struct catalog format_choice_catalog; /* struct row at the enum's place: text, csv, json */

struct sink {
    bool (*out)(void *context, struct text text); /* results; false: they cannot be written (closed, full device) */
    bool (*err)(void *context, struct text text); /* messages */
    void *context;
};

#define REPLY_DEPTH 8

struct reply {
    struct sink sink;
    bool quiet;                /* lines are left out (option -q); records, warnings and errors stay */
    enum output_format format; /* follows the session's setting, statement by statement */
    bool failed;               /* the sink refused results; nothing more is written there */
    struct buffer json;        /* the record under construction */
    struct buffer header, row; /* its CSV form */
    struct buffer lines;       /* lines of a command that may yet make a record */
    struct buffer last_header; /* what stands above the last CSV row */
    bool recorded;             /* this command made a record */
    int depth;                 /* objects and arrays open in the record */
    struct {
        const char *key;
        bool array, empty;
    } level[REPLY_DEPTH];
};

void reply_init(struct reply *reply, struct sink sink);
void reply_free(struct reply *reply);
void reply_line(struct reply *reply, const char *format, ...)
    PRINTF_LIKE(2, 3);                                  /* one or more lines, without the last newline */
void reply_text(struct reply *reply, struct text text); /* the same, ready-made */
/* What was asked for as it is: also when quiet, and among records in CSV. */
void reply_data(struct reply *reply, struct text text);
void reply_warning(struct reply *reply, const char *format, ...) PRINTF_LIKE(2, 3);
void reply_note(struct reply *reply, const char *format, ...)
    PRINTF_LIKE(2, 3); /* a message on the error stream, as it is */

/* A record. key NULL: the next element of an array. Numbers that are not finite become null. */
void reply_begin(struct reply *reply, const char *kind);
void reply_string(struct reply *reply, const char *key, const char *value); /* NULL: null */
void reply_real(struct reply *reply, const char *key, double value);
void reply_int(struct reply *reply, const char *key, int64_t value);
void reply_bool(struct reply *reply, const char *key, bool value);
void reply_null(struct reply *reply, const char *key);
void reply_in_unit(struct reply *reply, const char *key, struct measured value, const char *unit);
void reply_measured(struct reply *reply, const char *key, struct measured value, enum quantity quantity);
void reply_object(struct reply *reply, const char *key);
void reply_array(struct reply *reply, const char *key);
void reply_close(struct reply *reply); /* the innermost object or array */
void reply_end(struct reply *reply);   /* the record */

/* ---- where a line comes from ---- */

/* Of a line of a file, which may be continued on others: where a piece of it comes from. */
struct source_piece {
    size_t at; /* in the line as it is executed */
    int line, indent; /* indent: characters left out before it */
};

struct source {
    const char *name;            /* "lab1.hk", "-c", "-" ; NULL: typed at the prompt */
    int line;                    /* counted from 1 */
    const struct source *parent; /* who sourced it */
    const struct source_piece *piece;
    int pieces;
};

/* ---- settings ---- */

enum charset_choice { CHOOSE_AUTO, CHOOSE_ASCII, CHOOSE_BLOCK, CHOOSE_BRAILLE };
enum color_choice { COLOR_AUTO, COLOR_ALWAYS, COLOR_NEVER };
enum phase_axes { PHASE_SCALED, PHASE_RAW };
enum sync_choice { SYNC_AUTO, SYNC_ON, SYNC_OFF }; /* whether the next frame waits until the terminal has answered */
enum view_choice { VIEW_PAGE, VIEW_SCROLL };       /* the live view sweeps, then pages; or scrolls by whole cells */

enum sums { SUMS_PLAIN, SUMS_COMPENSATED };
enum turning { TURNING_ON, TURNING_OFF };
enum band { BAND_OFF, BAND_ON };
enum opinion_choice { OPINIONS_AUTO, OPINIONS_FULL, OPINIONS_WARN, OPINIONS_OFF };

struct settings {
    double dt;       /* [s] */
    double tol;      /* 0: off */
    double duration; /* [s] */
    struct recording_rule record;
    int width, height;                              /* [cell] of plots, 0: the front end's */
    int digits;                                     /* significant, in text */
    int charset, color, format, timing, phase_axes; /* the enums above, enum output_format, enum timing */
    int sync, view;
    int kernel, sums, turning; /* enum kernel, enum sums, enum turning */
    int band;                  /* BAND_ON: panes show that of an adopted fit */
    int opinion;               /* enum opinion_choice */
    bool dt_given, tol_given, duration_given; /* by the user: else tol and duration are those of the scene */
    double fps; /* frames a second of the live view */
};

struct setting {
    struct row row;
    enum quantity quantity;
    size_t offset, bytes;          /* of the field in struct settings */
    size_t given;                  /* 0, or the offset of the bool that says the user has set it */
    double (*natural)(const struct preset *preset); /* its value where he has not; NULL: a new session's */
    bool display;                  /* how results look, not part of the experiment: neither saved nor undone */
    const struct catalog *choices; /* the field is an int at the choice's place; NULL: a double */
    double least, most;            /* of a number: allowed are least < x <= most; most 0: not a number */
    /* For those that are neither; NULL otherwise. */
    bool (*parse)(struct settings *settings, struct text value, struct error *error);
    void (*show)(const struct settings *settings, struct buffer *text);
};

extern const struct catalog setting_catalog;

/* ---- the session ---- */

#define LIMIT_LET 128     /* variables made by let */
#define LIMIT_RESULTS 128 /* names of results: measured_period, fit_gamma … */
#define LIMIT_CHECKPOINTS 64
#define LIMIT_OWN 32 /* scenes of the user's own, by name */

struct named_value {
    char name[LIMIT_NAME + 1];
    double value, uncertainty; /* SI */
    enum quantity quantity;    /* QUANTITY_OTHER: unknown */
    double below;              /* of a state: no digit is certain, it is less than that; 0: they are */
};

struct events; /* private: what is watched for on the way; a list never changes and lives as long as its session */

/* The part that is plain data: undo copies it. */
struct setup {
    struct scene scene;
    const struct preset *own[LIMIT_OWN]; /* scenes that are all typed, as they were when last changed */
    int owns;
    const struct events *events; /* of the next run; NULL: none */
    const struct method *method;
    bool method_chosen; /* by name */
    enum drag drag; /* DRAG_DEFAULT: the method's own */
    bool fixed;     /* dt= was given with the method: fixed steps although it could adapt */
    struct settings settings;
    struct named_value let[LIMIT_LET];
    int lets;
};

struct leg; /* private: one thing that was asked of a run (go there, change a parameter, go back) */

/* Runs and recordings are shared by the session and its undo entries. */
struct held_run {
    struct run *run;
    int references;
    char *note;      /* NULL: none */
    struct leg *last; /* the end of the list of what was asked of the run since its start, which recreates it bit for
                         bit; shared with undo entries. NULL: nothing yet */
    struct run_mark *mark; /* private to undo.c: as the latest entry has it, NULL: none */
    const struct events *events; /* as they were when it began; NULL: none */
};

struct held_recording {
    struct recording *recording;
    int references;
    char *options; /* as they have to stand after the file name to load it again */
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
    char of[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
};

/* A fit that converged, for the report. */
struct kept_fit {
    struct fit fit;
    enum quantity quantity; /* of what was fitted */
    struct measured k;      /* NAN: nobody had said what the mass is */
    struct exact_names exact;
    char of[LIMIT_NAME + 16];
};

struct session;

/* ---- what the screen shows: changed by commands only, drawn by the view layer ---- */

enum layout { LAYOUT_TRIO, LAYOUT_DUO, LAYOUT_SINGLE, LAYOUT_STACK, LAYOUT_QUAD, LAYOUT_PLOT, LAYOUT_LOG };

extern const struct catalog layout_catalog; /* struct layout_row at the enum's place */

struct layout_row {
    struct row row;
    int width, height;   /* [cell] of a screen that has room for it */
    enum layout smaller; /* drawn on another one */
};

static inline const struct layout_row *layout_row(enum layout layout)
{
    return (const struct layout_row *)(const void *)catalog_row(&layout_catalog, (size_t)layout);
}

/* What a screen of that size shows of it. */
enum layout layout_drawn(enum layout layout, int width, int height);

enum pane {
    PANE_POSITION,
    PANE_ENERGY,
    PANE_PHASE,
    PANE_VELOCITY,
    PANE_ERROR,
    PANE_RESIDUAL,
    PANE_SPECTRUM,
    PANE_ORBIT,
    PANE_COUNT
};

/* What a pane is drawn of. */
enum pane_of {
    PANE_OF_SERIES,    /* a run or a recording */
    PANE_OF_MECHANICS, /* velocities */
    PANE_OF_PHASE,
    PANE_OF_ORBIT,    /* a second coordinate */
    PANE_OF_EXACT,    /* an exact solution */
    PANE_OF_RESIDUAL, /* a recording and what was fitted to it, or a run beside it */
};

/* A pane is a kind of plot. */
struct pane_row {
    struct row row; /* name, unit of the vertical axis, brief */
    enum pane_of of;
};

/* Whether it makes sense for this session: no error pane where nothing exact is known. */
bool pane_offered(const struct session *session, enum pane pane);

extern const struct catalog pane_catalog; /* at the enum's place */

enum snap { SNAP_CROSSING, SNAP_PEAK, SNAP_SAMPLE, SNAP_NONE };

extern const struct catalog snap_catalog; /* struct row at the enum's place */

struct cursors {
    bool shown;   /* the two cursors stand on the plot */
    bool on_data; /* they stand on the recording, else on the current run */
    int active;   /* 0: A, 1: B */
    bool locked;  /* both move together */
    struct {
        bool set;
        double t, t_uncertainty, y; /* [s] [s] SI */
        int crossing;               /* number of the up-crossing, 0: not on one */
        double amplitude;           /* of the motion there; NAN: not known */
    } at[2];
    enum snap snap;
    double periods;           /* between A and B, as counted; NAN: not known */
    char of[LIMIT_NAME + 16]; /* what they stand on: "run 2", "data swing3" */
    size_t samples;           /* it had then */
    enum quantity quantity;   /* of y */
};

/* What the two cursors say, made from what struct cursors holds. NAN: not known. */
struct cursor_reading {
    double dt;                 /* [s] B - A */
    double periods;            /* between them */
    struct measured period;    /* [s] */
    struct measured frequency; /* [Hz] */
    double theory;             /* [s] period of the scene, with its linear damping */
    const char *theory_name;   /* T0, T_d; period in other scenes than those of an oscillator */
    double deviation;          /* (period - theory)/theory */
    double decrement, quality; /* logarithmic decrement from the amplitudes at A and B, Q = pi/decrement */
};

/* False: the cursors are not shown or not both set. Cheap: a screen asks for each frame. */
bool session_cursor_reading(const struct session *session, struct cursor_reading *reading);
/* The same in four lines for people, as `cursor` prints them; without a newline at the end. */
void session_cursor_lines(const struct session *session, struct buffer *text);

#define LIMIT_OVERLAY 4 /* as many as have marks of their own */

struct view {
    enum layout layout;
    enum pane focus;            /* the pane that commands and zooming act on */
    bool full;                  /* the focused pane alone */
    double x[2], y[2];          /* fixed ranges of the focused pane (time [s], SI); NAN: automatic */
    double window;              /* [s] of time shown; 0: automatic */
    double trail;               /* periods of the phase trail; HUGE_VAL: all */
    int scroll;                 /* rows the log is scrolled up */
    bool paging;                /* the live view sweeps, then pages; otherwise it scrolls by whole cells */
    int overlay[LIMIT_OVERLAY]; /* numbers of the runs drawn besides the present one; those that are gone are passed
                                   over */
    int overlays;
    struct cursors cursors;
};

/* The last lines that commands said, for the log pane. A ring: line `first` is the oldest. */
#define LIMIT_LOG 2000

struct log {
    char **line; /* [LIMIT_LOG], allocated when the first line comes; each made safe, without newline */
    int first, count;
};

void log_add(struct log *log, struct text text);    /* one or more lines; without memory they are dropped */
const char *log_line(const struct log *log, int i); /* i = 0: the newest */
/*
 * The row of a line that begins at byte *from, as it stands in a pane of that width [cell]: whole words, unless one is
 * longer than a row. *indent [cell] goes before it; 0 in the first row. *from is then where the next row begins:
 * line.len after the last.
 */
struct text log_row(struct text line, size_t *from, int width, int *indent);
int log_rows(struct text line, int width); /* how many the line takes: 1 at least */
void log_clear(struct log *log);

/* A run that goes on while a person watches. */
enum live_state { LIVE_IDLE, LIVE_RUNNING, LIVE_PAUSED, LIVE_DIVERGED };

struct live {
    enum live_state state;
    double speed;     /* simulated seconds a second; HUGE_VAL: as fast as possible */
    double achieved;  /* the same, measured over the last second; below speed: "RUNNING 0.4x (CPU)" */
    double fraction;  /* of the way to the target, < 0: unknown */
    double marks[32]; /* [s] the latest times at which parameters were changed during the run */
    int mark_count;
    bool pausing;                /* asked to pause at the next look */
    bool changing;               /* private: the present command changes the current run */
    struct buffer record, typed; /* private: what `record` writes instead of the present statement, and after it */
};

struct snapshot; /* private: undo, redo, checkpoints */

enum front_change { FRONT_PANES, FRONT_PLAIN, FRONT_REDRAW };

/* What the front end offers; the session only calls it. Every callback may be NULL. */
struct front {
    bool interactive; /* a person types: prefixes of names are accepted, long runs are asked about instead of refused */
    bool utf8, color; /* what the output can show */
    int width, height; /* [cell] of the output, 0: 80x24 */
    const struct cancel *cancel;
    void *context;
    bool (*confirm)(void *context, const char *question);
    void (*progress)(void *context, const struct run *run,
                     double fraction); /* between slices; fraction < 0: unknown; > 1: over, erase; run NULL: a study */
    void (*clear)(void *context);
    /*
     * Live runs. `watched`: a person watches a screen of panes. Then run and continue advance in slices of at most 10
     * ms and call `slice` between them: it polls the terminal, executes what was typed (command_exec may be called
     * again from inside; what would disturb the run is refused) and draws. It returns at the latest at `until`
     * [clock_ns]; false: pause.
     */
    bool watched;
    bool (*slice)(void *context, struct session *session, int64_t until);
    /* Draws the present screen into a file, as ncurses would show it (batch: of front.width x height). */
    bool (*screenshot)(void *context, const struct session *session, const char *path, struct write_policy policy,
                       struct error *error);
    /* The same as lines of text, for `screenshot` without a file. */
    bool (*screen)(void *context, const struct session *session, struct buffer *text, struct error *error);
    /* [s] from, to of the time axis on that screen; false: it has none. */
    bool (*time_shown)(void *context, const struct session *session, double span[2]);
    /* Changes of the front end itself; false: not possible here, with the reason. */
    bool (*change)(void *context, enum front_change change, struct error *error);
};

/* What `adopt` took last: the scene as it became, and covariances of what is uncertain in it. */
struct adopted_fit {
    struct scene scene;                                     /* model NULL: nothing was adopted */
    int place[CURVE_PARAMETERS], count;                     /* of the parameters */
    double covariance[CURVE_PARAMETERS * CURVE_PARAMETERS]; /* [count][count] */
    struct exact_names exact;
    char of[LIMIT_NAME + 16]; /* "data swing3": what was fitted */
};

/* The band of an adopted fit about a run, for the panes. */
struct fit_band {
    int run; /* its number; 0: none was looked for */
    size_t rows;
    double end;             /* [s] rows and end of the run when it was */
    struct adopted_fit of;
    size_t n;               /* 0: it has none */
    int variables;
    double from, step;      /* [s] */
    double *half;           /* [variables][n] half the width */
};

struct session {
    struct front front;
    struct setup setup;
    struct typed_models *models; /* all that the user has typed: set-up, runs and undo point there */
    struct events *events;      /* likewise, the newest first */
    struct held_run *run[LIMIT_RUNS];
    int runs, current_run; /* index, -1: none */
    int next_run;          /* number of the next run */
    bool told_method;      /* that nobody has chosen one */
    bool told_assumed;     /* which duration and tolerance this scene gets */
    struct held_recording *recording[LIMIT_RECORDINGS];
    int recordings, current_recording; /* index, -1: none */
    bool data_is_latest;               /* the recording is more recent than the run: measure acts on it */

    struct named_value result[LIMIT_RESULTS]; /* of measurements and fits */
    int results;
    bool has_fit;
    struct fit fit;
    char fit_of[LIMIT_NAME + 16]; /* "data swing3", "run 2" */
    double fit_zero;              /* of the recording at that time: its offset counts from there */
    /* Where the last fit was one of the scene or of a formula: */
    double *fit_curve[2]; /* [fit_samples] its times and values; NULL: fit_value() */
    size_t fit_samples;
    struct scene fit_scene; /* as fitted; model NULL: it was no fit of the scene */
    bool fit_free[PARAM_MAX]; /* what was fitted there */
    struct adopted_fit adopted;
    struct fit_band band;
    int fit_modes;            /* so many damped sines at once; 0: it was no fit of modes */
    struct measurement *measurement;
    int measurements;
    struct kept_fit *kept_fit;
    int kept_fits;
    struct precision *precision; /* the last study, for `plot precision` and `export FILE table`; NULL: none */
    int precision_runs;          /* next_run at that time: a later run makes the table of the runs the latest one */

    struct references references; /* of the scenes that were studied last */
    struct sweep *sweep; /* the last one, for `export FILE table`; NULL: none */
    struct sweep_measure sweep_measure[SWEEP_MEASURES];
    struct scene sweep_scene;
    int sweep_runs; /* as precision_runs; the later of both has precision_runs -1 or not */

    struct snapshot *undo[LIMIT_UNDO], *redo[LIMIT_UNDO];
    int undos, redos;
    struct snapshot *checkpoint[LIMIT_CHECKPOINTS];
    int checkpoints;

    char **history; /* lines executed, oldest first */
    int histories;
    struct buffer story; /* statements that lead here, as a script (private: story.h) */
    bool story_fails;    /* one of them ends in an error, as it did: a run that diverged */
    bool confirmed;      /* the present statement was asked about, and allowed */
    char *record_path; /* file that executed lines are appended to, NULL: none */
    int record_fd;
    bool keep_going;  /* option -k */
    bool safe;        /* option --safe: write only below the current directory */
    bool quit;        /* the user asked to leave */
    int status;       /* exit status so far */
    uint64_t changes; /* counts changes: autosave compares it */
    int commands;     /* statements executed */
    bool typed;       /* the statement being executed was typed by a person */
    int nesting;      /* command_exec inside command_exec */
    bool halted;      /* a run was paused: what stands after it on the line and in the file is not executed */
    bool reacting;    /* commands of an event are executed: part of the statement that ran into it */
    bool passing;     /* the run goes on after them: what they set is not told each time */

    struct view view;
    struct log log;
    struct live live;
};

/* A new session with the lab's defaults. NULL: no memory. */
struct session *session_create(const struct front *front);
void session_destroy(struct session *session);
/* Appends the commands that recreate the set-up; sourcing them gives the same state. */
void session_save(const struct session *session, struct buffer *text);
/*
 * The same with recordings by absolute path, the runs and the view: sourcing it in a new session gives the same
 * exports. Runs that took 2 s or more of computing, and those that stopped at a condition on names that are not saved,
 * are only mentioned in a comment. Measurements are not kept.
 */
void session_autosave(const struct session *session, struct buffer *text);
/* The parameter says where a run starts, and nothing else. */
bool param_is_start(const struct scene *scene, int place);
/* A short description of the scene holds it: m and k of an oscillator, of its many others those that the user or the
 * scene has set; of other models all that act; none that is 0. */
bool param_matters(const struct scene *scene, int place);
/* Of a new run: dt, tol (0 unless the method adapts), drag, recording. */
struct run_settings session_run_settings(const struct session *session);
/* [s] of methods that adapt: the setting dt where the user has set it, else the scene's own. */
double session_first_step(const struct session *session);
/* Short state for a prompt or a state line: "spring m=200 g k=15 N/m | euler dt=10 ms | t=9.6 s". */
void session_state_line(const struct session *session, struct buffer *text);

/* ---- executing ---- */

/*
 * Executes one line, which may hold several statements. Each statement is atomic: everything is checked before the
 * session changes. The first error ends the line: it is written to the reply, session->status is set, and the result is
 * false. May be called again from inside front.slice; what would disturb the run that goes on is then refused. A run
 * that was paused ends the line too, with a note if something stands after it.
 */
bool command_exec(struct session *session, struct text line, const struct source *where, struct reply *reply);

/* A script that arrives line by line: joins lines that end in a backslash, counts, stops at the first error unless
 * keep_going. */
struct script {
    struct source where;
    struct buffer pending;
    struct source_piece piece[64]; /* of the joined line; more count as the last */
    int pieces;
    int commands;     /* session->commands at the start */
    bool ok, stopped;
};

void script_begin(struct script *script, struct session *session, const char *name, const struct source *parent);
/* One line without its newline. False: the script has stopped (error, quit); feeding more does nothing. */
bool script_feed(struct script *script, struct session *session, struct text line, struct reply *reply);
/* End of the input: executes what is pending, says where it stopped. True if every command succeeded. */
bool script_end(struct script *script, struct session *session, struct reply *reply);
/* A whole file, "-" is not special here. ERROR_USAGE if it cannot be read or holds a NUL byte. */
bool script_file(struct session *session, const char *path, const struct source *parent, struct reply *reply);

/* Writes an error the way users see it: position, line, caret, hint; or as JSON. where may be NULL, line may be empty.
 */
void reply_error(struct reply *reply, const struct error *error, const struct source *where, struct text line);

/* ---- completion ---- */

/*
 * Candidates for the word that ends at `cursor`, by the type of the argument that stands there. *start: where that word
 * begins [byte]. `offer` gets each candidate with a line of explanation ("" if none). Returns false where a file name
 * is wanted: the front end completes it.
 */
bool command_complete(struct session *session, struct text line, size_t cursor, size_t *start,
                      void (*offer)(void *context, const char *candidate, const char *brief), void *context);

/* ---- figures of the session ---- */

static inline struct run *session_run(const struct session *session)
{
    return session->current_run >= 0 ? session->run[session->current_run]->run : NULL;
}

static inline struct recording *session_recording(const struct session *session)
{
    return session->current_recording >= 0 ? session->recording[session->current_recording]->recording : NULL;
}

enum charset session_charset(const struct session *session);

enum plot_kind {
    PLOT_POSITION,
    PLOT_VELOCITY,
    PLOT_ACCELERATION,
    PLOT_PHASE,
    PLOT_ORBIT, /* of two coordinates */
    PLOT_ENERGY,
    PLOT_ERROR,
    PLOT_RESIDUAL,
    PLOT_SPECTRUM,
    PLOT_ENVELOPE,  /* amplitudes read window by window */
    PLOT_PERIOD,    /* against the amplitude, window by window */
    PLOT_PRECISION, /* of the last precision study, not of runs */
};

extern const struct catalog plot_catalog;

/* The part of the time that plots over each other share. */
struct figure_window {
    struct axis axis;    /* of all of them, fixed */
    double shown, total; /* [s] of what there is: how long the window is, and all of it */
};

/* What an axis shall show. An open end is where the curves end; both open: as narrow as that. */
struct figure_range {
    double end[2];          /* NAN: open */
    enum quantity quantity; /* of the unit that was given; QUANTITY_OTHER: none, that of the axis */
    struct text text;       /* as typed, for messages */
};

#define PEAKS_EACH 3  /* lines that are named of one spectrum */
#define PEAKS_MOST 16 /* and in all */

struct figure_peak {
    const char *label; /* of the curve */
    struct spectrum_peak line;
    enum quantity quantity; /* of the amplitude */
};

struct figure_peaks {
    struct figure_peak peak[PEAKS_MOST];
    int count;
};

struct figure_request {
    enum plot_kind kind;
    const int *run; /* places in the session */
    int runs;
    int recording;    /* place, -1: none */
    /* Of PLOT_POSITION and PLOT_ORBIT: what is drawn instead, and for the latter against what. */
    const struct text *column; /* names of variables and observables; NULL: the kind says all */
    int columns;
    struct text against;
    struct text at; /* only at the moments of this event, as points; empty: all along */
    bool next;      /* then the columns at the event after the one where `against` is taken: a return map */
    double window[2]; /* [s] NAN: choose */
    const struct figure_range *x, *y; /* of the axes; NULL: automatic */
    struct text band; /* as typed: with the band of the adopted fit's uncertainty; empty: without */
    bool kept_band;   /* with the one that the session keeps, if that is of this run */
    bool full; /* all of it: the whole time, all curves on one axis */
    int width;        /* [cell] that will be drawn on */
    bool log;         /* vertical axis */
    enum charset charset;
    double trail; /* periods of phase plot and orbit, 0: 2; HUGE_VAL: all */
    /* Of a view that lasts: the newest part instead of the first, its time axis fixed. */
    bool follow;
    bool alone;   /* no other plot shares the time axis: each period has to be seen only where this one needs it */
    bool running; /* the end moves: nothing that is written depends on it */
    double span;  /* [s] of time shown, 0: as much as the width can show */
    int pages;    /* the window moves on by span / pages */
    double until; /* [s] the axis reaches to here at least, where known; NAN */
    struct figure_peaks *peaks; /* takes the lines of spectra; NULL: nobody asks */
    const struct figure_window *shared; /* of all time plots of a screen; NULL: chosen for this one */
};

/* Chooses the window for such a time plot and all that share it; false: there is nothing to show, or no memory. */
bool session_window(const struct session *session, const struct figure_request *request, struct arena *arena,
                    struct figure_window *window);

/* Builds the figure; all memory from the arena. */
bool session_figure(const struct session *session, const struct figure_request *request, struct arena *arena,
                    struct figure *figure, struct error *error);
/* Whether such a plot makes sense for a model: velocities, or a second coordinate, are not everywhere. */
bool plot_fits(enum plot_kind kind, const struct model *model);
/* Coordinates of the same quantity, which share the plot of the position: those of a second-order scene, the values of
 * one of first order; at most as many as have marks of their own. */
int plot_coordinates(const struct model *model);
/* Place of the recording that belongs into such a plot without being asked for: the current one, where it overlaps the
 * run; -1: none. */
int figure_recording(const struct session *session, enum plot_kind kind);

/* ---- the catalog of commands: the man page and the README are made from it ---- */

struct argument;  /* private: what may stand after the name */
struct arguments; /* private: what stood there */

struct command {
    struct row row;       /* name, "", brief, "", aliases that hold in files too */
    const char *group;    /* "SCENE", "RUN" … */
    const char *text;     /* a few lines for help */
    const char *examples; /* two lines that can be pasted */
    const char *see;      /* names separated by blanks */
    const struct argument *argument;
    int arguments;
    unsigned flags;
    bool (*handler)(struct session *session, const struct arguments *given, struct reply *reply, struct error *error);
};

extern const struct catalog command_catalog;

/* "run [DURATION | to T | until COND] [--force]", made from the arguments. */
void command_usage(const struct command *command, struct buffer *text);

#endif
