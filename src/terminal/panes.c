/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Panes: one loop that waits for the terminal and for signals, feeds readline, executes what was typed and draws. A run that is watched calls back into
 * it between its slices. Readline edits and ncurses draws; neither reads or writes the terminal on its own.
 */
#include "panes.h"

#include <errno.h>
#include <fcntl.h>
#include <langinfo.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <readline/history.h>
#include <readline/readline.h>

#define PROMPT "hooke> "
#define MORE "     > " /* before the further lines of a paste */
#define LINES_HINT "several lines: Enter runs them, Ctrl-C drops them"
#define GONE (POLLHUP | POLLERR | POLLNVAL)
#define FAREWELL_NS 300000000 /* wait for an answer that is still under way before the shell gets to see it */

struct panes *panes_active;

static struct session *session_of(const struct panes *panes)
{
    return panes->program->session;
}

/* The person, the system or the terminal wants an end. */
static bool is_over(const struct panes *panes)
{
    return session_of(panes)->quit || panes->program->next != FRONT_END || signals_ending() || panes->input.closed;
}

/* ---- what is said ------------------------------------------------------------------------------------------------------------ */

static bool say(void *context, struct text text)
{
    log_add(&((struct session *)context)->log, text);
    return true;
}

struct sink panes_sink(struct session *session)
{
    return (struct sink){say, say, session};
}

/* The first line of a message, for where there is no room for the log. */
static bool note(void *context, struct text text)
{
    struct panes *panes = context;
    struct text first = TEXT("");
    if (panes->notice.len == 0 && text_split(&text, '\n', &first)) {
        safe_text(&panes->notice, first, false);
    }
    return true;
}

static bool say_here(void *context, struct text text)
{
    struct panes *panes = context;
    log_add(&session_of(panes)->log, text);
    return !keys_on_plot() || note(panes, text); /* the table of the cursors hides the log */
}

static struct sink sink_of(struct panes *panes)
{
    return (struct sink){say_here, say_here, panes};
}

static void warn(struct panes *panes, const struct error *error)
{
    reply_warning(panes->program->reply, "%s", error->text);
    panes->screen_stale = true;
}

static void log_typed(struct panes *panes, struct text typed)
{
    struct text line;
    for (const char *before = PROMPT; typed.len > 0 && text_split(&typed, '\n', &line); before = MORE) {
        struct buffer shown = {0};
        buffer_put(&shown, text_of(before));
        buffer_put(&shown, line);
        log_add(&session_of(panes)->log, buffer_text(&shown));
        buffer_free(&shown);
    }
}

/* ---- drawing --------------------------------------------------------------------------------------------------------------------- */

static void describe_prompt(const struct panes *panes, struct prompt_line *prompt, struct buffer *room)
{
    *prompt = (struct prompt_line){.prompt = text_of(rl_display_prompt),
                                   .line = {rl_line_buffer, (size_t)rl_end},
                                   .cursor = (size_t)rl_point,
                                   .hint = buffer_text(&panes->notice)};
    if (memchr(rl_line_buffer, '\n', (size_t)rl_end)) {
        prompt->hint = TEXT(LINES_HINT);
    }
    if (panes->question) {
        buffer_format(room, "%s [y/N] ", panes->question);
        *prompt = (struct prompt_line){.prompt = buffer_text(room)};
    } else if (keys_on_plot()) {
        prompt->prompt = TEXT("cursors (q leaves, : types a command)> ");
        prompt->line = TEXT("");
        prompt->cursor = 0;
    }
}

/* only_prompt: its row alone, so that an echo costs little on a slow link. */
static enum shown draw(struct panes *panes, bool only_prompt, int rows)
{
    struct prompt_line prompt;
    struct buffer room = {0};
    int x = 0, y = 0;
    describe_prompt(panes, &prompt, &room);
    struct canvas *canvas = &panes->screen.canvas;
    const int choice = session_of(panes)->setup.settings.color;
    screen_color(&panes->screen, choice == COLOR_ALWAYS || (choice == COLOR_AUTO && panes->color));
    enum shown shown = SHOWN_NOTHING;
    if (!canvas->cell || screen_draw(session_of(panes), &prompt, canvas, &x, &y)) {
        shown = screen_show(&panes->screen, only_prompt ? panes->screen.height - 1 : 0, rows, x, y);
    }
    buffer_free(&room);
    panes->echo_stale = false;
    panes->screen_stale &= only_prompt;
    return shown;
}

/* Draws what has to be seen now. Of a run the frames come when it is their time; what was typed is shown at once. */
static void draw_due(struct panes *panes, int64_t now)
{
    struct session *session = session_of(panes);
    if (panes->running && now >= pacing_due(&panes->pacing, session)) {
        const enum shown shown = draw(panes, false, panes->screen_stale ? INT_MAX : pacing_rows(&panes->pacing));
        pacing_drawn(&panes->pacing, session, now, shown);
    } else if (panes->screen_stale) {
        draw(panes, false, INT_MAX);
    } else if (panes->echo_stale) {
        draw(panes, panes->running, INT_MAX);
    }
}

void panes_repaint(struct panes *panes)
{
    screen_repaint(&panes->screen);
    panes->screen_stale = true;
}

static void take_size(struct panes *panes)
{
    struct front *front = &session_of(panes)->front;
    front->width = panes->screen.width;
    front->height = panes->screen.height;
    rl_set_screen_size(front->height, front->width);
    panes->screen_stale = true;
}

/* ---- signals ------------------------------------------------------------------------------------------------------------------------ */

/* An answer that comes after we have left would appear at the shell's prompt. */
static void await_answer(struct panes *panes)
{
    const int64_t until = clock_ns() + FAREWELL_NS;
    struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
    while (panes->pacing.asked != 0 && !panes->input.closed) {
        if (input_strip_reply(&panes->input)) {
            pacing_replied(&panes->pacing, clock_ns());
            continue;
        }
        const int64_t left = until - clock_ns();
        if (left <= 0 || poll(&ready, 1, (int)(left / 1000000) + 1) == 0) {
            break;
        }
        input_read(&panes->input, (ready.revents & GONE) != 0);
    }
    panes->pacing.asked = 0;
}

static void suspend(struct panes *panes)
{
    await_answer(panes);
    screen_leave(&panes->screen);
    signals_stop();
    signals_happened(HAPPENED_CONTINUE);
    screen_return(&panes->screen);
    take_size(panes);
}

/* Whatever is being edited: gone, with every state readline may be in. */
static void clear_line(struct panes *panes)
{
    rl_callback_sigcleanup();
    rl_free_line_state();
    rl_clear_message();
    rl_replace_line("", 0);
    keys_choose(session_of(panes));
    panes->echo_stale = true;
}

static void heed_signals(struct panes *panes)
{
    signals_drain();
    if (signals_happened(HAPPENED_RESIZE)) {
        screen_resize(&panes->screen);
        take_size(panes);
    }
    if (signals_happened(HAPPENED_SUSPEND)) {
        suspend(panes);
    }
    if (signals_happened(HAPPENED_CONTINUE)) {
        panes_repaint(panes);
        screen_resize(&panes->screen);
        take_size(panes);
    }
    if (cancelled(&interrupt) && !signals_ending()) {
        atomic_store(&interrupt.requested, 0);
        panes->interrupted = true;
        /* With Ctrl-C the system has thrown away what was under way in both directions, and rightly what was typed before. */
        input_clear(&panes->input);
        panes->pacing.asked = 0;
        panes_repaint(panes);
        if (!panes->running && !panes->question) {
            clear_line(panes);
        }
    }
}

/* ---- waiting --------------------------------------------------------------------------------------------------------------------------- */

static int64_t earliest(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Draws, waits for something to happen, at most until then, and reads what there is. */
static void wait_event(struct panes *panes, int64_t until)
{
    struct session *session = session_of(panes);
    draw_due(panes, clock_ns());
    until = earliest(until, input_due(&panes->input));
    until = earliest(until, autosave_due(panes->program->autosave));
    if (panes->running) {
        until = earliest(until, pacing_due(&panes->pacing, session));
    }
    int timeout = -1;
    if (until < INT64_MAX) {
        const int64_t left = until - clock_ns();
        timeout = left <= 0 ? 0 : left > 3600000000000 ? 3600000 : (int)((left + 999999) / 1000000);
    }
    struct pollfd ready[2] = {{.fd = STDIN_FILENO, .events = POLLIN}, {.fd = signals_pipe(), .events = POLLIN}};
    const bool any = poll(ready, 2, timeout) > 0;
    heed_signals(panes); /* before what was typed after Ctrl-C is read */
    if (any && ready[0].revents) {
        input_read(&panes->input, (ready[0].revents & GONE) != 0);
    }
    struct error error;
    if (clock_ns() >= autosave_due(panes->program->autosave) && !autosave_write(panes->program->autosave, &error)) {
        warn(panes, &error);
    }
}

/* ---- what readline asks for --------------------------------------------------------------------------------------------------------------- */

/* Blocks in the middle of a key sequence; an end or Ctrl-C gets it out. */
static int get_byte(FILE *ignored)
{
    (void)ignored;
    struct panes *panes = panes_active;
    int byte = panes->next_byte;
    panes->next_byte = -1;
    while (byte < 0 && !is_over(panes) && !panes->interrupted) {
        unsigned char next;
        struct text paste; /* in the middle of a key sequence it means nothing */
        const enum input_item item = input_next(&panes->input, clock_ns(), &next, &paste);
        if (item == INPUT_BYTE) {
            byte = next;
        } else if (item == INPUT_REPLY) {
            pacing_replied(&panes->pacing, clock_ns());
        } else if (item == INPUT_NONE) {
            wait_event(panes, INT64_MAX);
        }
    }
    return byte < 0 ? EOF : byte;
}

static int is_pending(void)
{
    return panes_active->next_byte >= 0 || input_pending(&panes_active->input);
}

static void redisplay(void)
{
    panes_active->echo_stale = true;
}

static void leave_modes(void)
{
}

static void enter_modes(int ignored)
{
    (void)ignored;
}

void panes_enqueue(struct panes *panes, struct text line, enum line_from from)
{
    panes->line_from = from;
    buffer_clear(&panes->line);
    buffer_put(&panes->line, line);
    panes->line_waits = !panes->line.failed;
    if (panes->line.failed) {
        buffer_free(&panes->line);
    }
}

static void on_line(char *typed)
{
    struct panes *panes = panes_active;
    struct error error;
    panes->echo_stale = true;
    if (!typed) {
        panes_enqueue(panes, TEXT("quit"), LINE_KEY);
    } else if (text_trim(text_of(typed)).len > 0) {
        if (!history_append(typed, &error) && !panes->history_told) {
            panes->history_told = true;
            warn(panes, &error);
        }
        panes_enqueue(panes, text_of(typed), LINE_TYPED);
    }
    free(typed);
}

/* What can be completed goes into the log, in columns. */
static void list_matches(char **match, int count, int longest)
{
    struct panes *panes = panes_active;
    const int column = longest + 2;
    const int columns = panes->screen.width / column > 1 ? panes->screen.width / column : 1;
    const int rows = (count + columns - 1) / columns;
    for (int row = 0; row < rows; row++) {
        struct buffer line = {0};
        for (int i = row; i < count; i += rows) {
            const char *slash = rl_filename_completion_desired ? strrchr(match[i + 1], '/') : NULL;
            const struct text name = text_of(slash && slash[1] ? slash + 1 : match[i + 1]);
            buffer_put(&line, name);
            for (int pad = text_width(name); pad < column && i + rows < count; pad++) {
                buffer_char(&line, ' ');
            }
        }
        log_add(&session_of(panes)->log, buffer_text(&line));
        buffer_free(&line);
    }
    panes->screen_stale = true;
}

/* A paste goes into the line as it is and waits for Enter; in the middle of a search its bytes are keys. */
static void insert_paste(struct panes *panes, struct text paste)
{
    if (RL_ISSTATE(RL_STATE_ISEARCH | RL_STATE_NSEARCH | RL_STATE_MULTIKEY | RL_STATE_CHARSEARCH | RL_STATE_VIMOTION)) {
        return;
    }
    char *text = strndup(paste.at, paste.len);
    if (!text) {
        return;
    }
    for (char *c = text; *c; c++) {
        *c = *c == '\r' ? '\n' : *c;
    }
    rl_insert_text(text);
    free(text);
    panes->echo_stale = true;
}

/* ---- executing --------------------------------------------------------------------------------------------------------------------------- */

static bool say_nothing(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

/* What only looks at the screen says nothing, unless it could not. */
static void execute_silently(struct panes *panes, struct text line)
{
    const struct source nobody = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){say_nothing, note, panes});
    command_exec(session_of(panes), line, &(struct source){.parent = &nobody}, &reply);
    reply_free(&reply);
}

/* A line typed during a run is executed inside the command that runs: it speaks through a reply of its own. */
static void execute_line(struct panes *panes)
{
    struct program *program = panes->program;
    struct session *session = program->session;
    struct buffer line = panes->line;
    panes->line = (struct buffer){0};
    panes->line_waits = false;
    const enum line_from from = panes->line_from;
    if (from != LINE_SILENT) {
        session->view.scroll = 0;
        log_typed(panes, buffer_text(&line));
    }
    const bool nested = panes->running;
    struct reply own, *outer = program->reply;
    if (nested) {
        reply_init(&own, sink_of(panes));
        own.quiet = outer->quiet;
        program->reply = &own;
    } else {
        draw(panes, false, INT_MAX); /* what takes long is seen to have begun */
    }
    buffer_clear(&panes->notice);
    const bool busy = signals_busy(true);
    if (from == LINE_SILENT) {
        execute_silently(panes, buffer_text(&line));
    } else {
        typed_run(session, buffer_text(&line), program->reply);
    }
    signals_busy(busy);
    if (nested) {
        program->reply = outer;
        reply_free(&own);
    } else {
        atomic_store(&interrupt.requested, signals_ending() != 0);
        panes->interrupted = false;
    }
    panes->screen_stale = true;
    keys_choose(session);
    if (from != LINE_SILENT && !keys_on_plot()) {
        buffer_clear(&panes->notice); /* the log can be read */
    }
    buffer_free(&line);
}

/* Everything that has been typed: keys to readline, complete lines to the session, one after the other. */
static void process(struct panes *panes)
{
    if (!panes->running) {
        panes->interrupted = false; /* heeded: the line is cleared */
    }
    while (!is_over(panes) && !panes->interrupted) {
        if (panes->line_waits) {
            execute_line(panes);
            continue;
        }
        unsigned char byte;
        struct text paste;
        const enum input_item item = input_next(&panes->input, clock_ns(), &byte, &paste);
        if (item == INPUT_NONE) {
            break;
        }
        if (item == INPUT_BYTE) {
            panes->next_byte = byte;
            rl_callback_read_char();
        } else if (item == INPUT_PASTE) {
            insert_paste(panes, paste);
        } else {
            pacing_replied(&panes->pacing, clock_ns());
        }
    }
}

/* ---- what the session asks for -------------------------------------------------------------------------------------------------------------- */

static bool slice(void *context, struct session *session, int64_t until)
{
    struct panes *panes = context;
    (void)session;
    signals_busy(false);
    panes->running = true;
    do {
        wait_event(panes, until);
        process(panes);
    } while (clock_ns() < until && !is_over(panes) && !panes->interrupted);
    panes->running = false;
    signals_busy(true);
    const bool go_on = !is_over(panes) && !panes->interrupted;
    panes->interrupted = false;
    return go_on;
}

static bool confirm(void *context, const char *question)
{
    struct panes *panes = context;
    enum input_item item = INPUT_NONE;
    unsigned char byte = 0;
    struct text paste;
    const bool busy = signals_busy(false);
    panes->question = question;
    panes->screen_stale = true;
    panes->interrupted = false;
    while (item != INPUT_BYTE && !is_over(panes) && !panes->interrupted) {
        wait_event(panes, INT64_MAX);
        while ((item = input_next(&panes->input, clock_ns(), &byte, &paste)) == INPUT_PASTE || item == INPUT_REPLY) {
        }
    }
    signals_busy(busy);
    panes->interrupted = false;
    panes->question = NULL;
    panes->screen_stale = true;
    draw(panes, false, INT_MAX);
    return item == INPUT_BYTE && (byte == 'y' || byte == 'Y');
}

static void clear(void *context)
{
    log_clear(&session_of(context)->log);
}

static bool shot_text(void *context, const struct session *session, struct buffer *text, struct error *error)
{
    struct panes *panes = context;
    struct prompt_line prompt;
    struct buffer room = {0};
    describe_prompt(panes, &prompt, &room);
    return screenshot_text(session, &prompt, panes->screen.width, panes->screen.height, text, error);
}

static bool shot_file(void *context, const struct session *session, const char *path, struct write_policy policy, struct error *error)
{
    struct panes *panes = context;
    struct prompt_line prompt;
    struct buffer room = {0};
    describe_prompt(panes, &prompt, &room);
    return screenshot_file(session, &prompt, panes->screen.width, panes->screen.height, path, policy, error);
}

static bool change(void *context, enum front_change change, struct error *error)
{
    struct panes *panes = context;
    switch (change) {
    case FRONT_PLAIN:
        panes->program->next = FRONT_IS_PLAIN;
        return true;
    case FRONT_REDRAW:
        panes_repaint(panes);
        return true;
    case FRONT_PANES:
        break;
    }
    return error_set(error, ERROR_COMMAND, "the panes are shown already");
}

/* ---- beginning and end ---------------------------------------------------------------------------------------------------------------------- */

static void take_readline(FILE *nowhere)
{
    rl_outstream = nowhere;
    rl_getc_function = get_byte;
    rl_input_available_hook = is_pending;
    rl_redisplay_function = redisplay;
    rl_prep_term_function = enter_modes;
    rl_deprep_term_function = leave_modes;
    rl_completion_display_matches_hook = list_matches;
    rl_catch_sigwinch = 0;
}

static void give_readline_back(void)
{
    rl_outstream = stdout;
    rl_getc_function = rl_getc;
    rl_input_available_hook = NULL;
    rl_redisplay_function = rl_redisplay;
    rl_prep_term_function = rl_prep_terminal;
    rl_deprep_term_function = rl_deprep_terminal;
    rl_completion_display_matches_hook = NULL;
}

static void run_loop(struct panes *panes)
{
    rl_callback_handler_install(PROMPT, on_line);
    keys_choose(session_of(panes));
    while (!is_over(panes)) {
        process(panes);
        if (!is_over(panes)) {
            wait_event(panes, INT64_MAX);
        }
    }
    rl_callback_handler_remove();
}

void panes_run(struct program *program)
{
    struct session *session = program->session;
    struct panes panes = {.program = program, .next_byte = -1, .screen_stale = true, .pacing = PACING_BEGIN};
    const struct front before = session->front;
    FILE *nowhere = fopen("/dev/null", "w");
    program->next = FRONT_END;
    line_begin(session); /* before ncurses: both look the terminal up */
    panes.color = before.color;
    panes.screen.utf8 = strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
    if (!nowhere || signals_pipe() < 0 || !screen_begin(&panes.screen)) {
        if (nowhere) {
            fclose(nowhere);
        }
        program->reply->sink = streams_sink(program->streams);
        reply_warning(program->reply, "panes cannot be shown here");
        program->next = FRONT_IS_PLAIN;
        return;
    }
    signals_watch(1u << HAPPENED_RESIZE | 1u << HAPPENED_SUSPEND | 1u << HAPPENED_CONTINUE);
    session->front = (struct front){.interactive = true,
                                    .utf8 = before.utf8,
                                    .cancel = &interrupt,
                                    .context = &panes,
                                    .confirm = confirm,
                                    .clear = clear,
                                    .watched = true,
                                    .slice = slice,
                                    .screenshot = shot_file,
                                    .screen = shot_text,
                                    .change = change};
    program->reply->sink = sink_of(&panes);
    take_size(&panes);
    panes_active = &panes;
    take_readline(nowhere);
    if (!program->reply->quiet && session->log.count == 0) {
        reply_line(program->reply, "hooke %s: 'help' lists the commands, Tab completes, F1 explains, Ctrl-D leaves", HOOKE_VERSION);
    }
    run_loop(&panes);
    give_readline_back();
    panes_active = NULL;
    if (!panes.input.closed) {
        await_answer(&panes);
    }
    screen_end(&panes.screen);
    signals_watch(0);
    fclose(nowhere);
    session->front = before;
    program->reply->sink = streams_sink(program->streams);
    if (panes.input.closed) {
        signals_hang_up();
    }
    input_free(&panes.input);
    buffer_free(&panes.line);
    buffer_free(&panes.notice);
}
