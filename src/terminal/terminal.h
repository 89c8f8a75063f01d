/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Private to the terminal layer: the only place that knows streams, signals, locales and readline. */
#ifndef HOOKE_TERMINAL_H
#define HOOKE_TERMINAL_H

#include <hooke/command.h>

/* ---- what the command line of the program asks for -------------------------------------------------------------------- */

enum task_kind { TASK_FILE, TASK_COMMAND };

struct task { /* -f FILE, FILE, -c TEXT in the order given */
    enum task_kind kind;
    const char *text;
};

struct options {
    struct task *task;
    int tasks;
    bool interactive, batch, plain, keep_going, norc, rc, safe, quiet, verbose, help, version;
    int width, height; /* 0: not given */
    const char *charset, *color, *format; /* NULL: not given */
};

/* False: a message has been written to standard error; exit status 2. */
bool options_read(struct options *options, int argc, char **argv);
void options_free(struct options *options);
void options_help(struct buffer *text);

/* ---- standard streams --------------------------------------------------------------------------------------------------- */

struct streams {
    struct buffer out;
    bool broken;       /* standard output cannot be written; remembered until exit */
    int failure;       /* errno of that */
};

/* Results are gathered and written in large pieces, always before a message; messages are written at once. */
struct sink streams_sink(struct streams *streams);
bool streams_flush(struct streams *streams);
void streams_free(struct streams *streams);

/* ---- signals ------------------------------------------------------------------------------------------------------------- */

extern struct cancel interrupt; /* set by Ctrl-C */

void signals_install(void);
int signals_ending(void); /* SIGHUP or SIGTERM has arrived: its number; 0: none */

/* ---- front ends ----------------------------------------------------------------------------------------------------------- */

/* What this output can show: charset from the locale, colour, size. `fd`: where figures go. */
void front_probe(struct front *front, const struct options *options, int fd);
/* Runs the tasks, then standard input where `input`. Returns when done, asked to quit, or stopped. */
void batch_run(struct session *session, const struct options *options, bool input, struct reply *reply, struct streams *streams);
void prompt_run(struct session *session, const struct options *options, struct reply *reply, struct streams *streams);
/* $XDG_CONFIG_HOME/hooke/rc.hk, if it is the user's own and nobody else can write it. */
void rc_run(struct session *session, struct reply *reply);

/* ---- files of the user ------------------------------------------------------------------------------------------------------ */

/* "$VARIABLE/hooke/NAME" or "$HOME/FALLBACK/hooke/NAME"; creates the folder where `create`. NULL: no place. Caller frees. */
char *user_path(const char *variable, const char *fallback, const char *name, bool create);

#define HISTORY_LINES 5000

void history_load(void);                /* readline's history from the file, the last HISTORY_LINES lines */
void history_append(const char *line);  /* to readline and, under a lock, to the file */

#endif
