/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Private to the terminal layer: the only place that knows streams, signals, locales, readline and
 * curses. */
#ifndef HOOKE_TERMINAL_TERMINAL_H
#define HOOKE_TERMINAL_TERMINAL_H

#include <hooke/session/store.h>
#include <hooke/view.h>

#include <pthread.h>

/* ---- what the command line of the program asks for
 * -------------------------------------------------------- */

enum task_kind { TASK_FILE, TASK_COMMAND };

struct task { /* -f FILE, FILE, -c TEXT in the order given */
    enum task_kind kind;
    const char *text;
};

struct options {
    struct task *task;
    int tasks;
    bool interactive, batch, plain, keep_going, norc, rc, safe, quiet, verbose, help, version;
    bool resume, check_sweep;
    int width, height;                                             /* 0: not given */
    const char *charset, *color, *format, *split, *check, *sensor; /* NULL: not given */
    const char *resume_name;                                       /* NULL: the newest */
};

/* False: a message has been written to standard error; exit status 2. */
bool options_read(struct options *options, int argc, char **argv);
void options_free(struct options *options);
void options_help(struct buffer *text);

/* ---- standard streams
 * ------------------------------------------------------------------------------------- */

struct streams {
    struct buffer out;
    bool broken;         /* standard output cannot be written; remembered until exit */
    int failure;         /* errno of that */
    struct log *log;     /* where what is said is kept for the screen as well; NULL: nowhere */
    struct split *split; /* takes the tables; NULL: they go to standard output */
    bool holding;        /* what a line says waits until it is known how long it is */
};

/* --split DIR: each table of results in CSV as a file, DIR/001-run.csv and so on (split.c). */
struct split {
    struct folder folder;
    struct buffer content; /* of the present one */
    char name[64];
    int count;
    bool open, failed;
    struct error error;
};

bool split_begin(struct split *split, const char *path, bool safe, struct error *error);
void split_part(void *streams, const char *kind); /* another begins */
bool split_takes(struct split *split, struct text text);
bool split_end(struct split *split, struct error *error); /* all files appear, or none */

/* Before anything is opened: a standard stream that is closed keeps its number, so that no file of
 * the user gets it and what is said. */
void streams_reserve(void);
/* Results are gathered and written in large pieces, always before a message; messages are written
 * at once. */
struct sink streams_sink(struct streams *streams);
bool streams_flush(struct streams *streams);
void streams_free(struct streams *streams);
/* Ends the holding: what is longer than the screen goes through $PAGER (less where it is empty),
 * a program with arguments between blanks, without a shell; where that fails, and where it is
 * shorter, it is written. */
void streams_page(struct streams *streams, int width, int height);
bool write_all(int fd, struct text text, int *failure); /* goes on after signals; failure: errno */

/* ---- --safe, kept by the kernel (confine/landlock.c) ---- */

int confine_version(void); /* of Landlock; 0: this kernel has none */
/* From now on only what is beneath these folders (NULL: none) can be written by this program, and
 * no program run; what is open stays open. False: the kernel does not do that. */
bool confine_writing(const char *const *folder, int folders, struct error *error);
void confine_say(struct buffer *text); /* a line for --version */

/* ---- signals
 * ---------------------------------------------------------------------------------------------- */

extern struct cancel interrupt; /* set by Ctrl-C */

void signals_install(void);
int signals_ending(void);   /* SIGHUP or SIGTERM has arrived: its number; 0: none */
void signals_hang_up(void); /* the terminal is gone, without a signal: as if it had come */

/* What else can happen; each is noticed once. */
enum signalled {
    HAPPENED_RESIZE,
    HAPPENED_SUSPEND,
    HAPPENED_CONTINUE,
    HAPPENED_ALARM,
    HAPPENED_COUNT
};

/* Installs the handlers of those in the set (bits 1 << enum signalled), gives the others back: to
 * the system, an alarm to crash_signal(). */
void signals_watch(unsigned set);
bool signals_happened(enum signalled what); /* and forgets it */
/* While nobody looks because a command takes long, Ctrl-Z stops the program from inside the
 * handler. Returns what it was. */
bool signals_busy(bool now);
/* SIGALRM, which is to be watched, comes after that time; 0: none. Not once the end has begun. */
void signals_alarm(int64_t ns);
/* A descriptor that becomes readable with every signal; -1: no pipe could be made. Reading it empty
 * is signals_drain().
 */
int signals_pipe(void);
void signals_drain(void);
/* Stops the program the way the terminal's own Ctrl-Z does; returns when it is continued. */
void signals_stop(void);

/* ---- giving the terminal back, whatever happens (crash.c)
 * ------------------------------------------------- */

/* Notes the modes that the terminal has now, to be restored. */
void crash_modes(void);
/* From now on an abnormal end writes `text` (escape sequences) and restores those modes. */
void crash_arm(struct text text);
void crash_disarm(void);
void crash_restore(void); /* only write() and tcsetattr(): may be called from a signal handler */
/* A serial line that an abnormal end gives back its modes, too; NULL: none any more. */
struct termios;
void crash_line(int fd, const struct termios *modes);
void crash_end(void); /* crash_restore() and the line: nothing goes on after it */
/* Signals that end the program: restore, then end as they would have. One of them; all. */
void crash_signal(int number);
void crash_install(void);
/* What is done when readline finds no memory, before the program ends with status 1. NULL: nothing.
 */
void crash_last_act(void (*act)(void));

/* ---- front ends
 * ------------------------------------------------------------------------------------------- */

enum front_kind { FRONT_END, FRONT_IS_PLAIN, FRONT_IS_PANES };

struct autosave;

/* What all front ends of one program share. */
struct front_program {
    struct session *session;
    const struct options *options;
    struct streams *streams;
    struct reply *reply;
    struct autosave *autosave;
    enum front_kind next; /* set by `plain` and `panes`: who takes over */
    struct buffer offer;  /* the line that an empty Enter takes: it is shown */
    struct buffer later;  /* what there was no room for, offered when that was taken */
    struct buffer passed; /* the last offer, as long as it is not taken: it is shown once */
};

/* What this output can show: charset from the locale, colour, size. `fd`: where figures go. */
void front_probe(struct front *front, const struct options *options, int fd);
/* Runs the tasks, then standard input where `input`. Returns when done, asked to quit, or stopped.
 */
void batch_run(struct session *session, const struct options *options, bool input,
               struct reply *reply, struct streams *streams);
/* Both return when the person leaves, the program is to end, or program->next says who takes over.
 */
void prompt_run(struct front_program *program);
void panes_run(struct front_program *program);
/* After a typed line: says what command_next() says, which an empty Enter then takes; `room`: for
 * so many cells of it, as all must be seen that is taken: where there is room for the first
 * statements only, those. 0 also where something was typed before it could be seen. Says nothing
 * where it would say the same as after the line before. */
void offer_next(struct front_program *program, int room);
/* The line to be executed: the offer where nothing was typed; there is none any more. `typed` is
 * malloc()ed, and so is the result, in its place. */
char *offer_take(struct front_program *program, char *typed);
/* Sees to it that ncurses and readline know a usual terminal where the system does not describe
 * it: TERMINFO says it then (terminfo(5), "Fetching Compiled Descriptions"). */
void describe_terminal(void);
/* Can panes be shown here? If not, why. */
bool panes_possible(struct error *error);
/* F1 at the plain prompt: what the word at the cursor is; the line stays. */
void prompt_explain(void);
/* What is said before the panes are there, and in them. */
struct sink panes_sink(struct session *session);
/* $XDG_CONFIG_HOME/hooke/rc.hk, if it is the user's own and nobody else can write it. */
void rc_run(struct session *session, struct reply *reply);
/* A typed or pasted text: several lines are a small script named "paste" that stops at its first
 * error. False: it did. */
bool typed_run(struct session *session, struct text typed, struct reply *reply);

/* ---- figures as pixels, in terminals that say that they show them (pixels.c)
 * ---------------------------------------------------- */

void pixels_offer(struct front *front, struct streams *streams);
/* An answer that came too late is still to come: what was typed is looked through for it. */
int pixels_skip_answer(int key); /* PIXELS_NO_KEY: this was one */
#define PIXELS_NO_KEY (-2)

/* ---- progress.c: of what takes long ---- */

bool progress_due(double fraction, bool *over);
void progress_text(const struct session *session, const struct run *run, double fraction,
                   struct buffer *text);
/* front.progress, on standard error; context: the session */
void progress_print(void *context, const struct run *run, double fraction);

/* ---- readline, common to both prompts (line.c)
 * ------------------------------------------------------------ */

/* Settings and completion; once, before anything else of readline. */
void line_begin(struct session *session);
/* The function of that name before which ours stands; `function` points at a pointer to it. */
void line_find_own(void *function, const char *name);
/* What was edited cannot be undone any more. */
void line_drop_undo(void);
/* What readline takes for the line's end may lie behind it (in vi's command mode: a yank that is
 * repeated), where its searches never end. */
void line_mend(void);
/* Between two lines: what readline has freed since the last one is free now, and lists of undo. */
void line_over(void);

/* ---- files of the user
 * ------------------------------------------------------------------------------------ */

/* "$VARIABLE/hooke/NAME" or "$HOME/FALLBACK/hooke/NAME"; creates the folder where `create`. NULL:
 * no place. Caller frees. */
char *user_path(const char *variable, const char *fallback, const char *name, bool create);
char *state_path(const char *name, bool create); /* in $XDG_STATE_HOME, else ~/.local/state */

#define HISTORY_LINES 5000

void history_load(void); /* readline's history from the file, the last HISTORY_LINES lines */
/* To readline and, under a lock, to the file. False: it cannot be kept there. */
bool history_append(const char *line, struct error *error);

/* ---- autosave: session-DATE-TIME-PID.hks, a file of hooke/session/store.h ---- */

#define AUTOSAVE_PREFIX "session-"
#define AUTOSAVE_ENDING ".hks"
#define AUTOSAVE_SECONDS 0.5 /* unless HOOKE_AUTOSAVE says otherwise */
#define AUTOSAVE_KEPT 5

struct autosaved {
    char name[64];
    time_t time;
    bool old;    /* of a version that saved commands */
    bool living; /* the session is still there */
    bool empty;  /* it was killed before it had written anything */
};

struct saved_list {
    struct autosaved *item; /* the newest first */
    int count;
};

/* Caller frees item. */
struct saved_list saved_list(const char *folder);
/* So that others see that this session lives; false: the file system cannot say so. */
bool saved_lock(int fd);

/* With what is still read of a session's file, to take its place once it is on the disk. */
struct fresh_file {
    char *path;
    int fd;         /* -1: none */
    int64_t from;   /* of the file, the first byte that it has not got */
    uint64_t bytes; /* that it has */
};

struct autosave {
    struct session *session;
    char *path;           /* NULL: not yet */
    int fd;               /* -1: not yet */
    struct stored stored; /* what the file has */
    struct fresh_file fresh;
    uint64_t slack;   /* [byte] so many may be left over */
    int64_t interval; /* [ns] */
    bool wished;      /* that somebody asked for: lines wait for it, too */
    int64_t written;  /* [clock_ns] the last time, and */
    int64_t spent;    /* [ns] what it took */
    uint64_t saved;   /* session->changes then */
    bool warned;      /* that it cannot be written: said once */
    bool unlocked, said_unlocked, said_unsynced; /* likewise what the file system cannot do */
    pthread_t thread;                            /* where `syncing`: puts the file on the disk */
    bool syncing, unsynced;                      /* unsynced: there is more to put there */
    atomic_bool synced;
    atomic_int sync_failure; /* errno */
    int64_t sync_due;        /* [clock_ns] not before */
};

/* Clears away what dead sessions left: temporaries, and all but the last AUTOSAVE_KEPT files. */
void autosave_begin(struct autosave *autosave, struct session *session);
void autosave_end(struct autosave *autosave);
/* When autosave_write is wanted [clock_ns]; INT64_MAX: nothing has changed. */
int64_t autosave_due(const struct autosave *autosave);
/* Writes if that is due; line: one was executed, which makes it due unless writing takes long. A
 * Ctrl-C puts the rest off until it is called again. */
bool autosave_keep(struct autosave *autosave, bool line, struct error *error);
/* Writes now if anything changed. False: something is not in the file, and why; that it cannot be
 * written at all is said once a session. */
bool autosave_write(struct autosave *autosave, struct error *error);
/* Replaces the session by a saved one; unchanged unless all of it could be restored. name NULL: the
 * newest. told: what was done. */
bool autosave_resume(struct session **session, const char *name, struct buffer *messages,
                     struct error *error);

#endif
