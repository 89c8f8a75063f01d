/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations of the terminal layer, the only one that uses standard streams, signals, locales,
 * readline and curses. main() reads options, then runs batch_run() or a front end (prompt_run(),
 * panes_run()). */
#pragma once

#include <hooke/base/file.h>
#include <hooke/module.h>
#include <hooke/view.h>

#include <pthread.h>
#include <signal.h>

/* ---- what the command line of the program asks for ---- */

enum task_kind { TASK_FILE, TASK_COMMAND };

struct task { /* a file or commands of the command line, in the order given */
    enum task_kind kind;
    const char *text;
};

/* Options of the program's command line. */
struct options {
    struct task *task;
    int tasks;
    bool interactive, batch, plain, keep_going, norc, rc, safe, quiet, verbose, help, version;
    bool resume;
    int width, height;                            /* 0 if not given */
    const char *charset, *color, *format, *split; /* NULL if not given */
    const char *resume_name;                      /* NULL stands for the newest */
    /* option of a module that is all the program does, or NULL */
    const struct module_option *only;
    const char *first; /* first word of that option, or NULL if all of its words are tasks */
};

/* Reads the options. Returns false after a message to standard error, for exit status 2. */
bool options_read(struct options *options, int argc, char **argv);
void options_free(struct options *options);
/* Appends the text of --help. */
void options_help(struct buffer *text);

/* ---- standard streams ---- */

/* Standard output and standard error. */
struct streams {
    struct buffer output;
    bool broken;         /* standard output could not be written; remembered until exit */
    int failure;         /* errno of the failed write */
    struct log *log;     /* log that keeps messages for the screen as well, or NULL */
    struct split *split; /* takes the tables; NULL if they go to standard output */
    /* the output of a line is held back until it is known whether it needs the pager */
    bool holding;
};

/* --split DIR: each table of results in CSV as a file, DIR/001-run.csv and so on (split.c). */
struct split {
    struct folder folder;
    struct buffer content; /* content of the current file */
    char name[64];
    int count;
    bool open, failed;
    struct error error;
};

/* Opens the folder. Returns false with an error if it exists. */
bool split_begin(struct split *split, const char *path, bool safe, struct error *error);
/* Begins the file of the next table (callback of the reply). */
void split_part(void *streams, const char *kind); /* another begins */
/* Adds text to the current file. Returns false before the first table. */
bool split_takes(struct split *split, struct text text);
/* Writes the folder; all files appear or, with an error, none. */
bool split_end(struct split *split, struct error *error);

/* Reserves the numbers of standard streams before anything is opened: a closed stream keeps its
 * number, so that no file of the user receives messages. */
void streams_reserve(void);
/* Results are gathered and written in large pieces, always before a message; messages are written
 * at once. */
struct sink streams_sink(struct streams *streams);
/* Writes the gathered output. Returns false if standard output has failed. */
bool streams_flush(struct streams *streams);
void streams_free(struct streams *streams);
/* Stops holding output back: output that is longer than the screen is shown in $PAGER ("less" if
 * empty), a program with arguments separated by blanks, started without a shell. Shorter output, or
 * all if that fails, is written. */
void streams_page(struct streams *streams, int width, int height);
/* Writes all of the text, continuing after signals. On failure *failure is errno. */
bool write_all(int fd, struct text text, int *failure);

/* ---- --safe, enforced by the kernel (confine/landlock.c) ---- */

int confine_version(void); /* Returns the version of Landlock, or 0 if this kernel has none. */
/* Allows this program to write only beneath these folders (NULL if there is none), and to run no
 * program. Open files stay open. Returns false if the kernel does not support that. */
bool confine_writing(const char *const *folder, int folders, struct error *error);
/* Appends the line of --version that tells whether the kernel enforces --safe. */
void confine_say(struct buffer *text);

/* ---- signals ---- */

extern struct cancel interrupt; /* set by Ctrl-C */

/* Installs the handlers that all front ends need. */
void signals_install(void);
/* Returns the number of the signal that ends the program (SIGHUP, SIGTERM), or 0. */
int signals_ending(void);
void signals_hang_up(void); /* Acts as on SIGHUP, for a terminal that is gone without a signal. */

/* Other events that signals report. */
enum signalled {
    HAPPENED_RESIZE,
    HAPPENED_SUSPEND,
    HAPPENED_CONTINUE,
    HAPPENED_ALARM,
    HAPPENED_COUNT
};

/* Installs handlers for the events in the set (bits 1 << enum signalled); the others get the
 * system's action, an alarm that of crash_signal(). */
void signals_watch(unsigned set);
/* Returns true if the event has happened, and forgets it. */
bool signals_happened(enum signalled what);
/* Tells whether a command is being executed, during which Ctrl-Z stops the program from inside the
 * handler. Returns the previous value. */
bool signals_busy(bool now);
/* Makes HAPPENED_ALARM happen after a time [ns]; 0 stops the alarm. No effect once the program is
 * ending. */
void signals_alarm(int64_t ns);
/* Returns a descriptor that becomes readable with every signal, or -1 if no pipe could be made.
 * signals_drain() reads it empty. */
int signals_pipe(void);
void signals_drain(void);
/* Stops the program the way the terminal's own Ctrl-Z does; returns when it is continued. */
void signals_stop(void);

/* ---- giving the terminal back, whatever happens (crash.c) ---- */

/* Notes the modes that the terminal has now, to be restored. */
void crash_modes(void);
/* Makes an abnormal end write `text` (escape sequences) and restore those modes. */
void crash_arm(struct text text);
void crash_disarm(void);
/* Gives a thread the stack on which its fatal signals are handled, in place of *previous, which is
 * to be given back at its end. */
void crash_stack(stack_t *previous);
void crash_restore(void); /* only write() and tcsetattr(): may be called from a signal handler */
/* Registers a serial line whose modes an abnormal end restores, too. NULL ends this. */
struct termios;
void crash_line(int fd, const struct termios *modes);
/* crash_restore() for the terminal and the serial line, before the program ends */
void crash_end(void);
/* Catches a signal that ends the program, so that it restores the modes first. crash_modes() and
 * crash_line() do so for all signals that are neither caught nor ignored. */
void crash_signal(int number);
/* Sets an action for the case that readline finds no memory, before the program ends with status 1.
 * NULL for nothing. */
void crash_last_act(void (*act)(void));

/* ---- front ends ---- */

/* Front end that reads what the user types: none (batch), the plain prompt, or the panes. */
enum front_kind { FRONT_NONE, FRONT_IS_PLAIN, FRONT_IS_PANES };

/* State shared by all front ends of one program. */
struct front_program {
    struct session *session;
    const struct options *options;
    struct streams *streams;
    struct reply *reply;
    enum front_kind next; /* front end that takes over, set by the commands `plain` and `panes` */
    struct buffer offer;  /* suggestion on the screen, which an empty Enter executes */
    struct buffer later;  /* rest of the suggestion, offered after the first part was taken */
    struct buffer passed; /* last suggestion, which is not shown a second time until it is taken */
    bool taken;           /* the line being executed is the suggestion */
    bool withheld;        /* a suggestion is held back, which an empty Enter shows */
};

/* Loads the locale of the environment, for the widths of characters only; numbers, messages and
 * sorting never depend on it. Only front ends that need character widths call this. */
void front_load_locale(void);
/* Finds charset, colour and size of the output `fd`, which receives figures. Options have priority.
 */
void front_probe(struct front *front, const struct options *options, int fd);
/* Executes the tasks, then standard input if `input` is set. Returns at their end, on `quit`, or at
 * the first error without --keep-going. */
void batch_run(struct session *session, const struct options *options, bool input,
               struct reply *reply, struct streams *streams);
/* Run a front end. Both return when the user leaves, the program must end, or program->next names
 * the front end that takes over. */
void prompt_run(struct front_program *program);
void panes_run(struct front_program *program);
/* Shows, after a typed line, in one line the next command that a module suggests, which an empty
 * Enter then runs: the first statements of it, as many as fit. Shows nothing if something was typed
 * before it could be seen, if the suggestion has not changed since the previous line, and after a
 * suggestion that was taken. */
void offer_next(struct front_program *program, bool typed_ahead);
/* Shows, after an empty line that has taken nothing, the suggestion that was held back. */
void offer_again(struct front_program *program, bool typed_ahead);
/* Returns the line to execute: the suggestion if nothing was typed. `typed` is malloc()ed and
 * freed, or returned; the caller frees the result. */
char *offer_take(struct front_program *program, char *typed);
/* Sets TERMINFO (terminfo(5), "Fetching Compiled Descriptions") if the system does not describe a
 * usual terminal, so that ncurses and readline know it. */
void describe_terminal(void);
/* Returns true if panes can be shown; otherwise sets *error. */
bool panes_possible(struct error *error);
/* Explains the word at the cursor (F1 at the plain prompt); the line is unchanged. */
void prompt_explain(void);
/* Returns a sink that writes to the log, before and after the panes appear. */
struct sink panes_sink(struct session *session);
/* Executes $XDG_CONFIG_HOME/hooke/rc.hk, if it belongs to the user and nobody else can write it. */
void rc_run(struct session *session, struct reply *reply);
/* A typed or pasted text: several lines are a small script named "paste" that stops at its first
 * error. Returns false if it did. */
bool typed_run(struct session *session, struct text typed, struct reply *reply);
/* Executes lines as a script of this name, or as typed lines if name is NULL. Returns false if it
 * failed. */
bool lines_run(struct session *session, const char *name, struct text lines, struct reply *reply);
/* Writes the line that greets the user. */
void front_greet(struct reply *reply);

/* ---- progress of long computations (progress.c) ---- */

/* Returns true if the progress should be shown now; fraction > 1 ends it, and *is_finished is set
 * if it must be erased. */
bool progress_due(double fraction, bool *is_finished);
/* Appends the progress of a run, or of a study if run is NULL. */
void progress_text(const struct session *session, const struct run *run, double fraction,
                   struct buffer *text);
/* Writes the progress to standard error; meant for front.progress, with the session as context. */
void progress_print(void *context, const struct run *run, double fraction);

/* ---- readline, common to both prompts (line.c) ---- */

/* Sets readline up, before anything else of it is used; later calls only change the session. */
void line_begin(struct session *session);
/* Corrects readline's end of the line if it lies behind the text (after a repeated yank in vi's
 * command mode), where its searches would never end; limits numeric prefixes. */
void line_mend(void);
void line_redisplay(void); /* rl_redisplay_function where readline draws */
/* Empties the line. */
void line_drop(void);
/* Leaves a search, a key sequence, or a paste whose end was lost by a Ctrl-C, by readline's own
 * jump to where it reads a new key. Called in readline's source of keys; does not return. */
void line_leave(void);
/* Frees, between two lines, memory that readline has given up since the last one, and lists of
 * undo. */
void line_over(void);

/* ---- files of the user ---- */

/* Returns the path of a file in $XDG_STATE_HOME/hooke, else in ~/.local/state/hooke, and creates
 * the folder if `create` is set. Returns NULL if there is none; the caller frees it. */
char *state_path(const char *name, bool create);

/* lines that the history file keeps */
#define HISTORY_LINES 5000

/* Loads the last HISTORY_LINES lines of the file into readline's history. */
void history_load(void);
/* Adds a line to readline's history and, under a lock, to the file. Returns false if the file
 * cannot keep it. */
bool history_append(const char *line, struct error *error);
/* Adds a line to the history; warns at the first failure. */
void history_keep(const char *line, struct reply *reply);
