/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Line editing by readline under the panes. Readline takes its bytes from our input, draws nothing
 * and leaves the terminal's modes alone. readline() returns only with a complete line, while the
 * panes have other things to do meanwhile; so it runs in a thread of its own, and the two threads
 * take turns: readline's waits whenever it wants a key or has a line. Its callbacks have no
 * context: panes_active is it. */
#include <hooke/base/safe_text.h>
#include "terminal/panes.h"

#include <errno.h>
#include <semaphore.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include <readline/readline.h>

struct panes *panes_active;

/* ---- turns ---- */

static struct {
    pthread_t thread;
    sem_t its_turn, our_turn;
    bool has_line; /* a line is complete, or NULL for the end of input; else readline wants a key */
    char *line;
    int key;
    bool gives_up, ends; /* gives_up asks to discard the line, ends asks the thread to return */
} editor;

/* Waits for a semaphore, also across signals. */
static void await_turn(sem_t *turn)
{
    while (sem_wait(turn) != 0 && errno == EINTR) {
    }
}

/* Gives the turn to readline until it wants a key or has a line. */
static void give_turn_to_readline(void)
{
    sem_post(&editor.its_turn);
    await_turn(&editor.our_turn);
}

/* Gives the turn to the panes, in readline's thread, and waits for the next. */
static void give_turn_to_panes(bool has_line)
{
    editor.has_line = has_line;
    sem_post(&editor.our_turn);
    await_turn(&editor.its_turn);
}

/* Readline's source of keys: waits until edit_key() has one. Discards the line if edit_clear() asks
 * for it. */
static int editor_get_key(FILE *ignored)
{
    (void)ignored;
    line_mend();
    give_turn_to_panes(false);
    if (editor.gives_up) {
        editor.gives_up = false;
        line_drop();
        line_leave();
    }
    return editor.key;
}

/* Readline's thread: reads lines until edit_end(). */
static void *editor_thread_run(void *ignored)
{
    stack_t previous_stack;
    crash_stack(&previous_stack);
    while (!editor.ends) {
        editor.line = readline(PANES_PROMPT);
        line_over();
        give_turn_to_panes(true);
    }
    sigaltstack(&previous_stack, NULL);
    return ignored;
}

/* Starts readline's thread with all signals blocked except those of program errors, so that the
 * panes' thread gets them. Returns false if there is no thread. */
static bool begin_thread(void)
{
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL};
    sigset_t others, previous_mask;
    sigfillset(&others);
    for (size_t i = 0; i < COUNT_OF(faults); i++)
        sigdelset(&others, faults[i]);
    pthread_sigmask(SIG_BLOCK, &others, &previous_mask);
    const bool ok = pthread_create(&editor.thread, NULL, editor_thread_run, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &previous_mask, NULL);
    return ok;
}

/* ---- lines ---- */

/* Sets the line that is executed next, and where it comes from. A line that does not fit into
 * memory is dropped. */
void panes_enqueue(struct panes *panes, struct text line, enum line_from origin)
{
    panes->line_from = origin;
    buffer_clear(&panes->line);
    buffer_put(&panes->line, line);
    panes->line_waits = !panes->line.failed;
    if (panes->line.failed) {
        buffer_free(&panes->line);
    }
}

/* Handles a line that readline has ended, or NULL for Ctrl-D: enqueues it as a command and adds it
 * to the history. An empty line takes or repeats the suggested command. Frees the line. */
static void handle_line(struct panes *panes, char *typed)
{
    panes->echo_stale = true;
    if (typed && !panes->running && !panes_session(panes)->view.reading) {
        typed = offer_take(panes->program, typed);
    }
    if (!typed) {
        panes_enqueue(panes, TEXT("quit"), LINE_KEY);
    } else if (panes_session(panes)->view.reading &&
               text_starts(text_of(typed), TEXT(READING_FIND))) {
        panes_enqueue(panes, text_of(typed), LINE_SILENT);
    } else if (text_trim(text_of(typed)).len > 0) {
        history_keep(typed, panes->program->reply);
        panes->screen_stale = true;
        panes_enqueue(panes, text_of(typed), LINE_TYPED);
    } else if (!panes->running) {
        offer_again(panes->program, input_pending(&panes->input));
        panes->screen_stale = true;
    }
    free(typed);
}

/* Handles the lines that readline has ended, until one waits to be executed. Returns true if there
 * was one. */
bool edit_take_line(struct panes *panes)
{
    const bool any = editor.has_line;
    while (editor.has_line && !panes->line_waits && !panes_over(panes)) {
        handle_line(panes, editor.line);
        give_turn_to_readline();
    }
    return any;
}

/* Passes one byte to readline and handles the lines that it ends. */
void edit_key(struct panes *panes, unsigned char byte)
{
    editor.key = byte;
    give_turn_to_readline();
    edit_take_line(panes);
}

static int is_pending(void)
{
    return input_pending(&panes_active->input);
}

static void redisplay(void)
{
    line_mend();
    panes_active->echo_stale = true;
}

/* Keeps readline from changing the terminal's modes. */
static void leave_modes(void)
{
}

/* Keeps readline from changing the terminal's modes. */
static void enter_modes(int ignored)
{
    (void)ignored;
}

/* Writes the possible completions (match[1...count]) to the log, in columns. */
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
        log_add(&panes_session(panes)->log, buffer_text(&line));
        buffer_free(&line);
    }
    panes->screen_stale = true;
}

/* Inserts a paste into the line, where it waits for Enter. It is ignored while readline waits for a
 * key with another meaning, as in a search. */
void edit_paste(struct panes *panes, struct text paste)
{
    if (RL_ISSTATE(RL_STATE_ISEARCH | RL_STATE_NSEARCH | RL_STATE_MOREINPUT | RL_STATE_CHARSEARCH |
                   RL_STATE_METANEXT | RL_STATE_NUMERICARG | RL_STATE_VIMOTION)) {
        return;
    }
    char *text = strndup(paste.data, paste.len);
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

/* Discards the line, with the remaining lines of a macro and every state of readline. */
void edit_clear(struct panes *panes)
{
    for (; editor.has_line; give_turn_to_readline()) /* remaining lines of a macro */
        free(editor.line);
    editor.gives_up = true;
    give_turn_to_readline();
    keys_choose(panes_session(panes));
    panes->echo_stale = true;
}

/* Keeps a half typed line while the log is read on the whole screen, and brings it back afterwards.
 */
void edit_put_aside(struct panes *panes)
{
    const bool reading = panes_session(panes)->view.reading;
    struct buffer *aside = &panes->aside;
    if (reading && rl_end > 0 && aside->len == 0) {
        buffer_put(aside, (struct text){rl_line_buffer, (size_t)rl_end});
        panes->aside_point = rl_point;
        if (!aside->failed)
            rl_replace_line("", 1);
        else
            buffer_free(aside);
    } else if (!reading && aside->len > 0) {
        /* text typed on the page follows it */
        char *begun = strndup(rl_line_buffer, (size_t)rl_end);
        rl_replace_line(buffer_view(aside), 1);
        rl_point = panes->aside_point;
        if (begun)
            rl_insert_text(begun);
        free(begun);
        buffer_clear(aside);
        panes->echo_stale = true;
    }
}

/* ---- beginning and end ---- */

/* Sets readline's callbacks and starts its thread; `nowhere` receives its output. Returns false if
 * that fails. */
bool edit_begin(FILE *nowhere)
{
    rl_outstream = nowhere;
    rl_getc_function = editor_get_key;
    rl_input_available_hook = is_pending;
    rl_redisplay_function = redisplay;
    rl_prep_term_function = enter_modes;
    rl_deprep_term_function = leave_modes;
    rl_completion_display_matches_hook = list_matches;
    rl_catch_sigwinch = 0;
    memset(&editor, 0, sizeof editor);
    const bool ok = sem_init(&editor.its_turn, 0, 0) == 0 &&
                    sem_init(&editor.our_turn, 0, 0) == 0 && begin_thread();
    if (ok)
        await_turn(&editor.our_turn);
    return ok;
}

/* Ends readline's thread and restores its callbacks. */
void edit_end(void)
{
    editor.ends = true;
    editor.gives_up = !editor.has_line;
    editor.key = EOF;
    while (!editor.has_line)
        give_turn_to_readline();
    free(editor.line);
    sem_post(&editor.its_turn);
    pthread_join(editor.thread, NULL);
    rl_outstream = stdout;
    rl_getc_function = rl_getc;
    rl_input_available_hook = NULL;
    rl_redisplay_function = line_redisplay;
    rl_prep_term_function = rl_prep_terminal;
    rl_deprep_term_function = rl_deprep_terminal;
    rl_completion_display_matches_hook = NULL;
}
