/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plain prompt: readline edits, keeps a history and completes; everything typed is executed by
 * the interpreter. */
#include "terminal/parts.h"
#include <hooke/base/cancel.h>

#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <readline/readline.h>

/* ---- signals while editing ---- */

static struct front_program *at_prompt; /* readline's callbacks have no context */

/* Saves the session if that is due, and warns if it fails; `line` tells that a line was executed.
 */
static void save_when_due(bool line)
{
    struct error error;
    if (!keeper_keep(line, &error)) {
        reply_warning(at_prompt->reply, "%s", error.text);
    }
}

/* Sets the alarm to the time at which the session must be saved next, or stops it. */
static void set_alarm(void)
{
    const int64_t due = keeper_due(), now = clock_ns();
    int64_t delay;
    if (due == INT64_MAX)
        delay = 0;
    else
        delay = due <= now ? 1000000 : due - now + 1000000;
    signals_alarm(delay);
}

/* Front end's callback after each statement: saves the session if that is due. */
static void executed(void *context)
{
    (void)context;
    save_when_due(true);
}

/* Acts on signals while readline waits: Ctrl-C clears the line, Ctrl-Z stops the program with the
 * terminal restored, the alarm saves the session. */
static void heed_signals(void)
{
    signals_drain();
    if (signals_happened(HAPPENED_ALARM)) {
        save_when_due(false);
        set_alarm();
    }
    if (signals_happened(HAPPENED_SUSPEND)) {
        rl_deprep_terminal();
        signals_stop();
        rl_prep_terminal(1);
        rl_forced_update_display();
    }
    if (cancelled(&interrupt) && !signals_ending()) {
        const bool inside = RL_ISSTATE(RL_STATE_MOREINPUT);
        atomic_store(&interrupt.requested, 0);
        line_drop();
        fputs("^C", rl_outstream);
        rl_crlf();
        rl_on_new_line();
        if (inside) {
            line_leave();
        }
        rl_redisplay();
    }
}

/* Returns the next key, or EOF if the program must end. Waits for keys and signals by poll(),
 * because a blocking read could miss a signal that arrives just before it. */
static int wait_for_key(FILE *stream)
{
    struct pollfd ready[2] = {{.fd = fileno(stream), .events = POLLIN},
                              {.fd = signals_pipe(), .events = POLLIN}};
    while (!signals_ending()) {
        const int count = poll(ready, 2, -1);
        rl_check_signals(); /* readline itself handles the size of the window */
        if (count < 0 || ready[1].revents) {
            heed_signals();
        } else {
            const int key = terminal_key(rl_getc(stream));
            if (key != NO_KEY) {
                return key;
            }
        }
    }
    return EOF;
}

/* Readline's source of keys. If the input ends within a paste, readline would copy the paste's
 * text, which has no NUL, beyond its end; so the line is discarded before. */
static int get_key(FILE *stream)
{
    const int key = wait_for_key(stream);
    if (key == EOF && RL_ISSTATE(RL_STATE_MOREINPUT)) {
        line_drop();
        line_leave();
    }
    return key;
}

/* Asks a question; returns true if the answer begins with y. */
static bool confirm(void *context, const char *question)
{
    struct front_program *program = context;
    char *answer = NULL;
    size_t capacity = 0;
    streams_flush(program->streams); /* shows the text that the question refers to */
    fprintf(stderr, "%s [y/N] ", question);
    bool yes = getline(&answer, &capacity, stdin) > 0 && (answer[0] == 'y' || answer[0] == 'Y');
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

/* Front end's callback for `plain`, `panes` and `redraw`. Returns false with an error if the change
 * is not possible. */
static bool change(void *context, enum front_change change, struct error *error)
{
    struct front_program *program = context;
    if (change == FRONT_PLAIN) {
        return error_set(error, ERROR_COMMAND, "this is already the plain prompt");
    }
    if (change == FRONT_PANES) {
        if (!panes_possible(error)) {
            return false;
        }
        program->next = FRONT_IS_PANES;
    }
    return true;
}

/* Shows the progress of a computation, and saves the session meanwhile if that is due. */
static void progress(void *context, const struct run *run, double fraction)
{
    progress_print(((const struct front_program *)context)->session, run, fraction);
    if (fraction <= 1)
        save_when_due(false);
}

/* ---- the loop ---- */

/* Executes lines as a script. Returns false if it failed. */
bool lines_run(struct session *session, const char *name, struct text lines, struct reply *reply)
{
    struct script script;
    struct text line;
    script_begin(&script, session, name, NULL);
    while (lines.len > 0 && text_split(&lines, '\n', &line) &&
           script_feed(&script, session, line, reply)) {
    }
    return script_end(&script, session, reply);
}

bool typed_run(struct session *session, struct text typed, struct reply *reply)
{
    const bool pasted = typed.len > 0 && memchr(typed.data, '\n', typed.len) != NULL;
    return lines_run(session, pasted ? "paste" : NULL, typed, reply);
}

void front_greet(struct reply *reply)
{
    if (!reply->quiet)
        reply_line(reply,
                   "hooke %s: 'help' lists commands, Tab completes, F1 explains, Ctrl-D leaves",
                   HOOKE_VERSION);
}

/* Reads a line by readline, with the label of an active module as prompt. Returns NULL at the end
 * of input; the caller frees the line. */
static char *read_line(struct front_program *program)
{
    signals_watch(1u << HAPPENED_SUSPEND | 1u << HAPPENED_ALARM);
    set_alarm();
    struct buffer label = {0};
    char prompt[40];
    modules_label(program->session, &label);
    snprintf(prompt, sizeof prompt, "%.36s> ", label.len ? buffer_view(&label) : "hooke");
    buffer_free(&label);
    char *typed = readline(prompt);
    line_over();
    signals_alarm(0);
    signals_watch(0);
    return typed;
}

static bool is_typed_ahead(void)
{
    struct pollfd ahead = {.fd = STDIN_FILENO, .events = POLLIN};
    return poll(&ahead, 1, 0) > 0;
}

/* Executes a typed line, through the pager if that is on, and shows the next suggestion. */
static void execute_typed(struct front_program *program, const char *typed)
{
    if (text_trim(text_of(typed)).len == 0) {
        offer_again(program, is_typed_ahead());
        return;
    }
    history_keep(typed, program->reply);
    save_when_due(false); /* a Ctrl-C may have put this off, and the line may take long */
    struct session *session = program->session;
    program->streams->holding = session->setup.settings.pager == PAGER_ON;
    const bool ok = typed_run(session, text_of(typed), program->reply);
    if (program->streams->holding)
        streams_page(program->streams, session->front.width, session->front.height);
    atomic_store(&interrupt.requested, signals_ending() != 0);
    if (ok)
        offer_next(program, is_typed_ahead());
}

/* Explains the word at the cursor (F1) and shows the line again. */
void prompt_explain(void)
{
    struct front_program *program = at_prompt;
    struct buffer line = {0};
    help_line((struct text){rl_line_buffer, (size_t)rl_end}, (size_t)rl_point, &line);
    rl_crlf();
    rl_deprep_terminal();
    typed_run(program->session, buffer_text(&line), program->reply);
    streams_flush(program->streams);
    atomic_store(&interrupt.requested, signals_ending() != 0);
    rl_prep_terminal(1);
    rl_on_new_line();
    rl_redisplay();
    buffer_free(&line);
}

/* Sets the callbacks of the session for the plain prompt. */
static void set_front(struct front_program *program)
{
    struct front *front = &program->session->front;
    front->interactive = true;
    front->confirm = confirm;
    front->progress = progress;
    front->executed = executed;
    front->clear = clear_screen;
    front->change = change;
    screenshot_offer(front);
    terminal_offer(front, program->streams);
    front->context = program;
}

/* Runs the plain prompt until it ends or the panes take over (program->next). */
void prompt_run(struct front_program *program)
{
    struct session *session = program->session;
    const struct front saved = session->front;
    program->next = FRONT_NONE;
    program->reply->sink = streams_sink(program->streams);
    at_prompt = program;
    set_front(program);
    signals_pipe();
    line_begin(session);
    rl_catch_sigwinch = 1;
    rl_getc_function = get_key;
    crash_modes();
    crash_arm(TEXT("\033[?2004l\r\n")); /* ends a mode that readline switches on */
    front_greet(program->reply);
    while (!session->execution.quit && !signals_ending() && program->next == FRONT_NONE &&
           streams_flush(program->streams)) {
        front_probe(&session->front, program->options, STDOUT_FILENO);
        char *typed = read_line(program);
        if (!typed || signals_ending()) {
            free(typed);
            if (!signals_ending()) {
                fputs("\n", stdout);
                fflush(stdout);
            }
            break;
        }
        typed = offer_take(program, typed);
        execute_typed(program, typed);
        free(typed);
    }
    rl_getc_function = rl_getc;
    crash_disarm();
    session->front = saved;
}
