/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The panes front end: one loop that waits for the terminal and for signals, feeds readline,
 * executes what was typed and draws. A live run calls back into it between its slices. Readline
 * edits and ncurses draws; neither reads or writes the terminal itself. */
#define _GNU_SOURCE /* fopencookie */
#include <hooke/base/cancel.h>
#include <hooke/base/safe_text.h>
#include "terminal/panes.h"
#include "terminal/parts.h"

#include <langinfo.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <unistd.h>
#include <string.h>

#include <readline/readline.h>

#define PASTE_PROMPT "     > " /* prompt before the second and later lines of a paste */
#define LINES_HINT "several lines: Enter runs them, Ctrl-C discards them"
#define POLL_CLOSED (POLLHUP | POLLERR | POLLNVAL)
/* [ns] time to wait at the end for an answer of the terminal, which the shell would get otherwise
 */
#define FAREWELL_NS 300000000

bool panes_over(const struct panes *panes)
{
    return panes_session(panes)->execution.quit || panes->program->next != FRONT_NONE ||
           signals_ending() || panes->input.closed;
}

/* ---- messages ---- */

static bool panes_say(void *context, struct text text)
{
    log_add(&((struct session *)context)->log, text);
    return true;
}

struct sink panes_sink(struct session *session)
{
    return (struct sink){panes_say, panes_say, session};
}

/* Sink function that shows the first line of a message while the log is hidden. */
static bool panes_note(void *context, struct text text)
{
    struct panes *panes = context;
    struct text first = TEXT("");
    if (panes->notice.len == 0 && text_split(&text, '\n', &first)) {
        safe_text(&panes->notice, first, false);
    }
    return true;
}

/* Sink function that adds text to the log and, while the log is hidden, shows it as a notice. */
static bool panes_write(void *context, struct text text)
{
    struct panes *panes = context;
    log_add(&panes_session(panes)->log, text);
    return !keys_on_plot() || panes_note(panes, text); /* the table of the cursors hides the log */
}

static struct sink panes_own_sink(struct panes *panes)
{
    return (struct sink){panes_write, panes_write, panes};
}

static void panes_warn(struct panes *panes, const struct error *error)
{
    reply_warning(panes->program->reply, "%s", error->text);
    panes->screen_stale = true;
}

/* Adds a typed line to the log, behind the prompt; a paste has several. */
static void log_typed(struct panes *panes, struct text typed)
{
    struct text line;
    for (const char *prompt = PANES_PROMPT; typed.len > 0 && text_split(&typed, '\n', &line);
         prompt = PASTE_PROMPT) {
        struct buffer shown = {0};
        buffer_put(&shown, text_of(prompt));
        buffer_put(&shown, line);
        log_add(&panes_session(panes)->log, buffer_text(&shown));
        buffer_free(&shown);
    }
}

/* Executes a line that only changes the view; failures appear as a notice. */
static void execute_silently(struct panes *panes, struct text line)
{
    const struct source nobody = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){sink_nothing, panes_note, panes});
    command_exec(panes_session(panes), line, &(struct source){.parent = &nobody}, &reply);
    reply_free(&reply);
}

/* ---- drawing ---- */

/* Fills in what the lowest row shows: readline's line, or the keys while the cursors or a page have
 * them. */
void panes_prompt(const struct panes *panes, struct prompt_line *prompt, struct buffer *scratch)
{
    *prompt = (struct prompt_line){.prompt = text_of(rl_display_prompt),
                                   .line = {rl_line_buffer, (size_t)rl_end},
                                   .cursor = (size_t)rl_point,
                                   .hint = buffer_text(&panes->notice)};
    if (memchr(rl_line_buffer, '\n', (size_t)rl_end)) {
        prompt->hint = TEXT(LINES_HINT);
    }
    if (keys_on_plot()) {
        prompt->prompt = TEXT("cursors (q leaves, : types a command)> ");
        prompt->line = TEXT("");
        prompt->cursor = 0;
    } else if (keys_on_text()) {
        reading_prompt(panes_session(panes), buffer_text(&panes->notice), scratch);
        *prompt = (struct prompt_line){.prompt = buffer_text(scratch)};
    }
}

/* Draws the panes, or only the lowest row, in about `bytes` bytes. Returns how much was sent. */
enum shown panes_show(struct panes *panes, bool only_prompt, int bytes)
{
    struct prompt_line prompt;
    struct buffer scratch = {0};
    int x = 0, y = 0;
    panes_prompt(panes, &prompt, &scratch);
    struct canvas *canvas = &panes->screen.canvas;
    const int choice = panes_session(panes)->setup.settings.color;
    screen_color(&panes->screen, choice == COLOR_ALWAYS || (choice == COLOR_AUTO && panes->color));
    enum shown shown = SHOWN_NOTHING;
    if (canvas->cell && only_prompt)
        screen_draw_prompt(panes_session(panes), &prompt, canvas, &x, &y);
    if (!canvas->cell || only_prompt ||
        screen_draw(panes_session(panes), &prompt, canvas, &x, &y)) {
        shown =
            screen_show(&panes->screen, only_prompt ? panes->screen.height - 1 : 0, bytes, x, y);
    }
    buffer_free(&scratch);
    panes->echo_stale = false;
    panes->screen_stale &= only_prompt;
    return shown;
}

/* Draws what has changed. Frames of a live run are drawn at the rate of pacing.c. */
static void draw_due(struct panes *panes, int64_t now)
{
    struct session *session = panes_session(panes);
    if (panes->running && now >= pacing_due(&panes->pacing, session)) {
        const enum shown shown =
            panes_show(panes, false, panes->screen_stale ? INT_MAX : pacing_bytes(&panes->pacing));
        pacing_drawn(&panes->pacing, session, now, shown);
    } else if (panes->screen_stale) {
        panes_show(panes, false, INT_MAX);
    } else if (panes->echo_stale) {
        panes_show(panes, panes->running, INT_MAX);
    }
}

void panes_repaint(struct panes *panes)
{
    screen_repaint(&panes->screen);
    panes->screen_stale = true;
}

/* Adapts session, readline and the page to the size of the screen. */
static void adapt_to_size(struct panes *panes)
{
    struct session *session = panes_session(panes);
    struct front *front = &session->front;
    const int line = session->view.reading ? reading_line(session) : 0;
    front->width = panes->screen.width;
    front->height = panes->screen.height;
    if (session->view.reading) { /* the page keeps its first line */
        const int scroll =
            log_rows_newest(&session->log, line + 1, front->width) - (front->height - 1);
        session->view.scroll = scroll > 0 ? scroll : 0;
    }
    rl_set_screen_size(front->height, front->width);
    panes->screen_stale = true;
}

/* ---- signals ---- */

/* Waits for the terminal's answer to the last request of `pacing`, at most FAREWELL_NS, because a
 * later answer would appear at the shell's prompt. */
static void await_answer(struct panes *panes)
{
    const int64_t deadline = clock_ns() + FAREWELL_NS;
    struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
    while (panes->pacing.requested != 0 && !panes->input.closed) {
        if (input_strip_reply(&panes->input)) {
            pacing_replied(&panes->pacing, clock_ns());
            continue;
        }
        const int64_t left = deadline - clock_ns();
        if (left <= 0 || poll(&ready, 1, (int)(left / 1000000) + 1) == 0) {
            break;
        }
        input_read(&panes->input, (ready.revents & POLL_CLOSED) != 0);
    }
    panes->pacing.requested = 0;
}

/* Stops the program on Ctrl-Z and takes the terminal back when it is continued. */
static void suspend_program(struct panes *panes)
{
    await_answer(panes);
    screen_leave(&panes->screen);
    signals_stop();
    signals_happened(HAPPENED_CONTINUE);
    screen_return(&panes->screen);
    adapt_to_size(panes);
}

/* Acts on signals that have arrived: size, stop, continue, Ctrl-C. With `forget` a Ctrl-C drops the
 * bytes that were read before it. */
static void heed_signals(struct panes *panes, bool forget)
{
    signals_drain();
    if (signals_happened(HAPPENED_RESIZE)) {
        screen_resize(&panes->screen);
        adapt_to_size(panes);
    }
    if (signals_happened(HAPPENED_SUSPEND)) {
        suspend_program(panes);
    }
    if (signals_happened(HAPPENED_CONTINUE)) {
        screen_retake(&panes->screen);
        adapt_to_size(panes);
    }
    if (cancelled(&interrupt) && !signals_ending()) {
        atomic_store(&interrupt.requested, 0);
        panes->interrupted = true;
        if (forget) {
            input_clear(&panes->input);
        }
        /* The terminal driver has discarded the bytes under way in both directions, also the
         * answer. */
        panes->pacing.requested = 0;
        panes_repaint(panes);
        if (!panes->running) {
            if (keys_on_text())
                panes_enqueue(panes, TEXT("scroll close"), LINE_SILENT);
            else
                edit_clear(panes);
        }
    }
}

/* ---- waiting ---- */

static int64_t earliest(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

void panes_save(struct panes *panes, bool line)
{
    struct error error;
    if (!keeper_keep(line, &error)) {
        panes_warn(panes, &error);
    }
}

/* Waits until something is typed, a signal arrives, or `deadline` [clock_ns] or another due time
 * has come. Returns true if something was typed. */
bool panes_read(struct panes *panes, int64_t deadline)
{
    struct session *session = panes_session(panes);
    deadline = earliest(deadline, input_due(&panes->input));
    deadline = earliest(deadline, keeper_due());
    if (panes->running)
        deadline = earliest(deadline, pacing_due(&panes->pacing, session));
    int timeout = -1;
    if (deadline < INT64_MAX) {
        const int64_t left = deadline - clock_ns();
        if (left <= 0)
            timeout = 0;
        else
            timeout = left > 3600000000000 ? 3600000 : (int)((left + 999999) / 1000000);
    }
    struct pollfd ready[2] = {{.fd = STDIN_FILENO, .events = POLLIN},
                              {.fd = signals_pipe(), .events = POLLIN}};
    const bool any = poll(ready, 2, timeout) > 0;
    heed_signals(panes, true);
    const bool typed = any && ready[0].revents;
    if (typed) {
        input_read(&panes->input, (ready[0].revents & POLL_CLOSED) != 0);
        /* bytes left after a Ctrl-C were typed after it */
        heed_signals(panes, false);
    }
    return typed;
}

/* Draws, waits and, if nothing was typed, saves the session. */
void panes_wait(struct panes *panes, int64_t deadline)
{
    draw_due(panes, clock_ns());
    if (!panes_read(panes, deadline))
        panes_save(panes, false);
}

/* ---- executing ---- */

/* Executes the waiting line. During a live run it is executed inside the command `run`, with a
 * reply of its own. */
static void execute_line(struct panes *panes)
{
    struct front_program *program = panes->program;
    struct session *session = program->session;
    struct buffer line = panes->line;
    panes->line = (struct buffer){0};
    panes->line_waits = false;
    const enum line_from origin = panes->line_from;
    if (origin != LINE_SILENT) {
        session->view.scroll = 0;
        session->view.reading = false;
        session->view.recipe = NULL;
        log_typed(panes, buffer_text(&line));
    }
    const uint64_t said_before = session->log.said;
    const bool nested = panes->running;
    struct reply own, *outer = program->reply;
    if (nested) {
        reply_init(&own, panes_own_sink(panes));
        own.quiet = outer->quiet;
        program->reply = &own;
    } else {
        panes_show(panes, false, INT_MAX); /* shows the line before a long command begins */
    }
    buffer_clear(&panes->notice);
    const bool busy = signals_busy(true);
    bool ok = true;
    int unheeded = 0; /* a Ctrl-C that is not for a command which only changes the view */
    if (origin == LINE_SILENT) {
        unheeded = atomic_exchange(&interrupt.requested, 0);
        execute_silently(panes, buffer_text(&line));
    } else {
        ok = typed_run(session, buffer_text(&line), program->reply);
    }
    signals_busy(busy);
    if (origin != LINE_SILENT) {
        buffer_clear(&program->offer); /* a suggestion must be the last message */
    }
    if (ok && !nested && origin == LINE_TYPED) {
        struct pollfd ahead = {.fd = STDIN_FILENO, .events = POLLIN};
        if (poll(&ahead, 1, 0) > 0) {
            input_read(&panes->input, (ahead.revents & POLL_CLOSED) != 0);
        }
        offer_next(program, input_pending(&panes->input));
    }
    if (nested) {
        program->reply = outer;
        reply_free(&own);
        if (unheeded)
            atomic_store(&interrupt.requested, 1);
    } else {
        atomic_store(&interrupt.requested, unheeded || signals_ending() != 0);
        panes->interrupted = false;
    }
    panes->screen_stale = true;
    if (origin != LINE_SILENT && !nested) {
        struct buffer reading = {0};
        reading_command(panes, said_before, &reading);
        if (reading.len > 0)
            execute_silently(panes, buffer_text(&reading));
        buffer_free(&reading);
    }
    edit_put_aside(panes);
    keys_choose(session);
    if (origin != LINE_SILENT && !keys_on_plot()) {
        buffer_clear(&panes->notice); /* the log can be read */
    }
    buffer_free(&line);
}

/* Handles what has been typed until nothing is left or the panes must end: executes a waiting line,
 * else takes the next item of the input. */
void panes_process(struct panes *panes)
{
    if (!panes->running) {
        panes->interrupted = false; /* the line was cleared, nothing else has to stop */
    }
    while (!panes_over(panes) && !panes->interrupted) {
        if (panes->line_waits) {
            execute_line(panes);
            continue;
        }
        if (edit_take_line(panes)) {
            continue;
        }
        unsigned char byte;
        struct text paste;
        const enum input_item item = input_next(&panes->input, clock_ns(), &byte, &paste);
        if (item == INPUT_NONE) {
            break;
        }
        if (item == INPUT_BYTE) {
            edit_key(panes, byte);
        } else if (item == INPUT_PASTE) {
            edit_paste(panes, paste);
        } else {
            pacing_replied(&panes->pacing, clock_ns());
        }
    }
}

/* ---- beginning and end ---- */

/* Passes bytes that were typed ahead to readline, when `plain` leaves the panes. */
static void pass_input_to_readline(struct panes *panes)
{
    unsigned char byte;
    struct text paste;
    enum input_item item;
    while ((item = input_next(&panes->input, INT64_MAX, &byte, &paste)) != INPUT_NONE) {
        const struct text typed = item == INPUT_BYTE    ? (struct text){(const char *)&byte, 1}
                                  : item == INPUT_PASTE ? paste
                                                        : TEXT("");
        for (size_t i = 0; i < typed.len && rl_stuff_char(typed.data[i]); i++) {
        }
    }
}

/* Discards the output of readline, also where there is no /dev/null. */
static ssize_t ignore_output(void *nowhere, const char *bytes, size_t count)
{
    (void)nowhere;
    (void)bytes;
    return (ssize_t)count;
}

/* Runs the panes until they end or another front end takes over (program->next). If the terminal
 * cannot show them it warns, and the plain prompt takes over. */
void panes_run(struct front_program *program)
{
    struct session *session = program->session;
    struct panes panes = {.program = program, .screen_stale = true, .pacing = PACING_BEGIN};
    const struct front saved = session->front;
    FILE *nowhere = fopencookie(NULL, "w", (cookie_io_functions_t){.write = ignore_output});
    program->next = FRONT_NONE;
    line_begin(session); /* precedes ncurses, because both look up the terminal */
    panes.color = saved.colors > 0;
    panes.screen.utf8 = strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
    /* Handlers are set before ncurses, which would otherwise handle Ctrl-Z and ignore it while it
     * draws. */
    signals_watch(1u << HAPPENED_RESIZE | 1u << HAPPENED_SUSPEND | 1u << HAPPENED_CONTINUE);
    panes_active = &panes;
    const bool edits = nowhere && signals_pipe() >= 0 && edit_begin(nowhere);
    if (!edits || !screen_begin(&panes.screen)) {
        if (edits) {
            edit_end();
        }
        panes_active = NULL;
        signals_watch(0);
        if (nowhere) {
            fclose(nowhere);
        }
        program->reply->sink = streams_sink(program->streams);
        reply_warning(program->reply, "panes cannot be shown here");
        program->next = FRONT_IS_PLAIN;
        return;
    }
    watch_offer(&panes, &session->front);
    program->reply->sink = panes_own_sink(&panes);
    adapt_to_size(&panes);
    keys_choose(session);
    if (session->log.count == 0) {
        front_greet(program->reply);
    }
    while (!panes_over(&panes)) {
        panes_process(&panes);
        if (!panes_over(&panes)) {
            panes_wait(&panes, INT64_MAX);
        }
    }
    edit_end();
    panes_active = NULL;
    if (!panes.input.closed) {
        await_answer(&panes);
    }
    if (program->next == FRONT_IS_PLAIN) {
        pass_input_to_readline(&panes);
    }
    screen_end(&panes.screen);
    signals_watch(0);
    fclose(nowhere);
    session->front = saved;
    program->reply->sink = streams_sink(program->streams);
    if (panes.input.closed) {
        signals_hang_up();
    }
    input_free(&panes.input);
    buffer_free(&panes.line);
    buffer_free(&panes.notice);
    buffer_free(&panes.aside);
}
