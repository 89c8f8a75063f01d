/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Private to the terminal layer: the only place that knows streams, signals, locales, readline and
 * curses. */
#pragma once

#include <hooke/base/file.h>
#include <hooke/module.h>
#include <hooke/view.h>

#include <pthread.h>
#include <signal.h>

/* ---- what the command line of the program asks for ---- */

enum task_kind { TASK_FILE, TASK_COMMAND };

struct task { /* -f FILE, FILE, -c TEXT in the order given */
    enum task_kind kind;
    const char *text;
};

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
void options_help(struct buffer *text);

/* ---- standard streams ---- */

struct streams {
    struct buffer output;
    bool broken;         /* standard output cannot be written; remembered until exit */
    int failure;         /* errno of that */
    struct log *log;     /* log that keeps messages for the screen as well, or NULL */
    struct split *split; /* takes the tables; NULL if they go to standard output */
    bool holding;        /* output of a line waits until its length is known */
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

bool split_begin(struct split *split, const char *path, bool safe, struct error *error);
void split_part(void *streams, const char *kind); /* another begins */
bool split_takes(struct split *split, struct text text);
bool split_end(struct split *split, struct error *error); /* all files appear, or none */

/* Reserves the numbers of standard streams before anything is opened: a closed stream keeps its
 * number, so that no file of the user receives messages. */
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
/* Writes all of the text, continuing after signals. On failure *failure is errno. */
bool write_all(int fd, struct text text, int *failure);

/* ---- --safe, kept by the kernel (confine/landlock.c) ---- */

int confine_version(void); /* version of Landlock; 0 if this kernel has none */
/* Allows this program to write only beneath these folders (NULL if there is none), and to run no
 * program. Open files stay open. Returns false if the kernel does not support that. */
bool confine_writing(const char *const *folder, int folders, struct error *error);
void confine_say(struct buffer *text); /* a line for --version */

/* ---- signals ---- */

extern struct cancel interrupt; /* set by Ctrl-C */

void signals_install(void);
int signals_ending(void);   /* SIGHUP or SIGTERM has arrived: its number; 0 if there is none */
void signals_hang_up(void); /* the terminal is gone, without a signal: as if it had come */

/* Other events; each is noticed once. */
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
/* SIGALRM, which is to be watched, comes after that time; 0 if there is none. Not once the end has
 * begun. */
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
void crash_end(void); /* crash_restore() and the line: nothing goes on after it */
/* Catches a signal that ends the program, so that it restores the modes first. crash_modes() and
 * crash_line() do so for all signals that are neither caught nor ignored. */
void crash_signal(int number);
/* Sets an action for the case that readline finds no memory, before the program ends with status 1.
 * NULL for nothing. */
void crash_last_act(void (*act)(void));

/* ---- front ends ---- */

enum front_kind { FRONT_END, FRONT_IS_PLAIN, FRONT_IS_PANES };

/* State shared by all front ends of one program. */
struct front_program {
    struct session *session;
    const struct options *options;
    struct streams *streams;
    struct reply *reply;
    enum front_kind next; /* set by `plain` and `panes`: who takes over */
    struct buffer offer;  /* the line that an empty Enter takes: it is shown */
    struct buffer later;  /* rest that did not fit, offered after the first part was taken */
    struct buffer passed; /* the last offer, as long as it is not taken: it is shown once */
    bool taken;           /* the line that is executed is an offer */
    bool withheld;        /* there may be an offer, which an empty Enter shows */
};

/* Takes the locale of the environment: character widths come from it; numbers, messages and the
 * order of names never do. For programs that talk: others need no tables. */
void front_load_locale(void);
/* Finds the abilities of this output: charset from the locale, colour, size. `fd` receives
 * figures. */
void front_probe(struct front *front, const struct options *options, int fd);
/* Runs the tasks, then standard input where `input`. Returns when done, asked to quit, or stopped.
 */
void batch_run(struct session *session, const struct options *options, bool input,
               struct reply *reply, struct streams *streams);
/* Both return when the person leaves, the program is to end, or program->next says who takes over.
 */
void prompt_run(struct front_program *program);
void panes_run(struct front_program *program);
/* Shows, after a typed line, in one line the next command that a module suggests, which an empty
 * Enter then runs: the first statements of it, as many as fit. Shows nothing if something was typed
 * before it could be seen, if the suggestion has not changed since the previous line, and after a
 * suggestion that was taken. */
void offer_next(struct front_program *program, bool typed_ahead);
/* Shows, after an empty line that has taken nothing, the suggestion that was held back. */
void offer_again(struct front_program *program, bool typed_ahead);
/* The line to be executed: the offer where nothing was typed; there is none any more. `typed` is
 * malloc()ed, and so is the result, in its place. */
char *offer_take(struct front_program *program, char *typed);
/* Sees to it that ncurses and readline know a usual terminal where the system does not describe
 * it: TERMINFO says it then (terminfo(5), "Fetching Compiled Descriptions"). */
void describe_terminal(void);
/* Returns true if panes can be shown; otherwise sets *error. */
bool panes_possible(struct error *error);
/* F1 at the plain prompt: what the word at the cursor is; the line stays. */
void prompt_explain(void);
/* Returns a sink that writes to the log, before and after the panes appear. */
struct sink panes_sink(struct session *session);
/* $XDG_CONFIG_HOME/hooke/rc.hk, if it is the user's own and nobody else can write it. */
void rc_run(struct session *session, struct reply *reply);
/* A typed or pasted text: several lines are a small script named "paste" that stops at its first
 * error. Returns false if it did. */
bool typed_run(struct session *session, struct text typed, struct reply *reply);
/* Runs lines as a script of that name, or typed ones where it is NULL. Returns false if it
 * failed. */
bool lines_run(struct session *session, const char *name, struct text lines, struct reply *reply);
void front_greet(struct reply *reply);

/* ---- progress of long computations (progress.c) ---- */

bool progress_due(double fraction, bool *is_finished);
void progress_text(const struct session *session, const struct run *run, double fraction,
                   struct buffer *text);
/* Writes the progress to standard error; meant for front.progress, with the session as context. */
void progress_print(void *context, const struct run *run, double fraction);

/* ---- readline, common to both prompts (line.c) ---- */

/* Settings and completion; once, before anything else of readline. */
void line_begin(struct session *session);
/* Corrects the end of the line if readline's own lies behind it (a repeated yank in vi's command
 * mode), where its searches never end; keeps a count small. */
void line_mend(void);
void line_redisplay(void); /* rl_redisplay_function where readline draws */
/* Empties the line. */
void line_drop(void);
/* Leaves a search, a sequence, or a paste whose end a Ctrl-C has made the terminal forget: readline
 * jumps to where it reads a new key. Called where it asks for one; does not return. */
void line_leave(void);
/* Frees, between two lines, memory that readline has given up since the last one, and lists of
 * undo. */
void line_over(void);

/* ---- files of the user ---- */

/* path in $XDG_STATE_HOME, else ~/.local/state */
char *state_path(const char *name, bool create);

#define HISTORY_LINES 5000

void history_load(void); /* readline's history from the file, the last HISTORY_LINES lines */
/* Adds a line to readline's history and, under a lock, to the file. Returns false if the file
 * cannot keep it. */
bool history_append(const char *line, struct error *error);
void history_keep(const char *line, struct reply *reply); /* the same; a failure is said once */
