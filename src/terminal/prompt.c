/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plain prompt: readline for editing, history and completion; everything typed goes to command_exec(). */
#include "terminal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <readline/history.h>
#include <readline/readline.h>

/* ---- completion: readline asks without a context, so what it needs stands here ------------------------------------------- */

static struct session *completing;

struct candidates {
    char **match; /* as readline wants them: the common prefix first, NULL at the end */
    size_t count, room;
};

static void collect(void *context, const char *candidate, const char *brief)
{
    (void)brief;
    struct candidates *all = context;
    if (all->count + 2 >= all->room) {
        size_t room = all->room ? 2 * all->room : 32;
        char **more = realloc(all->match, room * sizeof *more);
        if (!more) {
            return;
        }
        all->match = more;
        all->room = room;
    }
    char *copy = strdup(candidate);
    if (copy) {
        all->match[++all->count] = copy;
    }
}

/* match[0] is the longest common prefix of the others. */
static char **finish(struct candidates *all)
{
    if (all->count == 0) {
        free(all->match);
        return NULL;
    }
    size_t len = strlen(all->match[1]);
    for (size_t i = 2; i <= all->count; i++) {
        size_t same = 0;
        while (same < len && all->match[i][same] == all->match[1][same]) {
            same++;
        }
        len = same;
    }
    all->match[0] = strndup(all->match[1], len);
    all->match[all->count + 1] = NULL;
    if (all->match[0]) {
        return all->match;
    }
    for (size_t i = 1; i <= all->count; i++) {
        free(all->match[i]);
    }
    free(all->match);
    return NULL;
}

static char **complete(const char *word, int begin, int end)
{
    (void)word;
    struct candidates all = {0};
    size_t start = (size_t)begin;
    size_t cursor = (size_t)end;
    rl_attempted_completion_over = 1;
    rl_completion_append_character = ' ';
    /* The interpreter knows where the argument begins; readline keeps what stands between there and its own word. */
    if (!command_complete(completing, (struct text){rl_line_buffer, (size_t)rl_end}, cursor, &start, collect, &all)) {
        rl_attempted_completion_over = 0; /* a file name: readline's own */
        free(all.match);
        return NULL;
    }
    size_t skip = start < (size_t)begin ? (size_t)begin - start : 0;
    for (size_t i = 1; skip > 0 && i <= all.count; i++) {
        size_t len = strlen(all.match[i]);
        size_t cut = skip < len ? skip : len;
        memmove(all.match[i], all.match[i] + cut, len - cut + 1);
    }
    if (all.count == 1 && all.match[1][0] && all.match[1][strlen(all.match[1]) - 1] == '=') {
        rl_completion_append_character = 0;
    }
    return finish(&all);
}

/* ---- signals while editing -------------------------------------------------------------------------------------------------- */

/* Ctrl-C clears the line and never leaves; a hang-up ends the loop. */
static int on_signal(void)
{
    if (signals_ending()) {
        rl_done = 1;
    } else if (cancelled(&interrupt)) {
        atomic_store(&interrupt.requested, 0);
        rl_callback_sigcleanup();
        rl_free_line_state();
        rl_replace_line("", 0);
        fputs("^C", rl_outstream);
        rl_crlf();
        rl_on_new_line();
        rl_redisplay();
    }
    return 0;
}

/* ---- what a long run shows --------------------------------------------------------------------------------------------------- */

struct progress {
    int64_t begun, shown; /* [ns] */
    bool visible;
};

/* Four times a second at most, from one second on, with the time left; erased at the end. */
static void show_progress(void *context, const struct run *run, double fraction)
{
    struct progress *progress = context;
    int64_t now = clock_ns();
    if (fraction > 1) {
        if (progress->visible) {
            fputs("\r\033[K", stderr);
        }
        *progress = (struct progress){0};
        return;
    }
    if (progress->begun == 0) {
        progress->begun = progress->shown = now;
    }
    if (now - progress->begun < 1000000000 || now - progress->shown < 250000000) {
        return;
    }
    progress->shown = now;
    progress->visible = true;
    double spent = (double)(now - progress->begun) * 1e-9;
    fprintf(stderr, "\r%s: t = %.6g s, %lld steps", run->method->row.name, run->t, (long long)run->steps);
    if (fraction > 0) {
        fprintf(stderr, ", %.0f %%, %.0f s left", 100 * fraction, spent * (1 - fraction) / fraction);
    }
    fputs(" (Ctrl-C stops)\033[K", stderr);
}

static bool confirm(void *context, const char *question)
{
    (void)context;
    char *answer = NULL;
    size_t room = 0;
    fprintf(stderr, "%s [y/N] ", question);
    bool yes = getline(&answer, &room, stdin) > 0 && (answer[0] == 'y' || answer[0] == 'Y');
    clearerr(stdin);
    free(answer);
    return yes;
}

static void clear_screen(void *context)
{
    (void)context;
    fputs("\033[H\033[2J", stdout);
    fflush(stdout);
}

/* ---- the loop ----------------------------------------------------------------------------------------------------------------- */

static void start_readline(struct session *session)
{
    completing = session;
    rl_readline_name = "hooke";
    rl_catch_signals = 0;
    rl_change_environment = 0;
    rl_signal_event_hook = on_signal;
    rl_attempted_completion_function = complete;
    rl_basic_word_break_characters = " \t\n;=,";
    rl_completer_quote_characters = "'\"";
    rl_filename_quote_characters = " \t;#";
    rl_initialize();
    rl_variable_bind("enable-bracketed-paste", "on");
}

void prompt_run(struct session *session, const struct options *options, struct reply *reply, struct streams *streams)
{
    struct progress progress = {0};
    session->front.interactive = true;
    session->front.confirm = confirm;
    session->front.progress = show_progress;
    session->front.clear = clear_screen;
    session->front.context = &progress;
    start_readline(session);
    history_load();
    if (!reply->quiet) {
        reply_line(reply, "hooke %s: 'help' lists the commands, Tab completes, Ctrl-D leaves", HOOKE_VERSION);
    }
    while (!session->quit && !signals_ending()) {
        if (!streams_flush(streams)) {
            break;
        }
        front_probe(&session->front, options, STDOUT_FILENO);
        char *typed = readline("hooke> ");
        if (!typed || signals_ending()) {
            free(typed);
            if (!signals_ending()) {
                fputs("\n", stdout);
                fflush(stdout);
            }
            break;
        }
        if (text_trim(text_of(typed)).len > 0) {
            history_append(typed);
            /* A paste of several lines arrives as one: run it as a small script. */
            bool pasted = strchr(typed, '\n') != NULL;
            struct script script;
            script_begin(&script, session, pasted ? "paste" : NULL, NULL);
            struct text rest = text_of(typed);
            struct text line;
            while (text_split(&rest, '\n', &line) && script_feed(&script, session, line, reply)) {
            }
            script_end(&script, session, reply);
            atomic_store(&interrupt.requested, signals_ending() != 0);
        }
        free(typed);
    }
    session->front.interactive = false;
}
