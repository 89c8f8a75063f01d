/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Readline under the panes: it takes its bytes from our input, draws nothing and leaves the
 * terminal's modes alone. Its callbacks have no context: panes_active is it.
 */
#include "terminal/panes.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include <readline/readline.h>

struct panes *panes_active;

/* ---- where readline 7 to 8.3 crashes or hangs
 * ---------------------------------------------------------------------------------------------- */

/*
 * These stand before functions of readline and have them do the rest. They are weak: where readline
 * is linked as an archive its own are taken, faults and all.
 *
 * A key that cannot be used is left by a jump to where readline_internal_char() began. But
 * rl_callback_read_char() goes on after that function has returned while there are keys in a queue
 * (what was put back of a sequence that means nothing, a macro), and the jump from there is into a
 * frame that is gone: ESC Enter ESC [ 1 Tab. Here every jump leads to edit_key().
 */
__attribute__((weak)) int _rl_abort_internal(void);
__attribute__((weak)) int _rl_forward_char_internal(int count);
__attribute__((weak)) int _rl_dispatch(int key, Keymap map);
__attribute__((weak)) void rl_redisplay(void);
__attribute__((weak)) int rl_newline(int count, int key);
__attribute__((weak)) int rl_insert_text(const char *text);
extern sigjmp_buf _rl_top_level __attribute__((weak));
int _rl_pushed_input_available(void) __attribute__((weak));

#define NARROWEST 12                    /* a prompt and some of a line */
#define COUNT_MOST 1000                 /* of a key that is repeated */
#define REPEATED_MOST ((size_t)1 << 14) /* [byte] of a line, by such keys */
#define KEY_TURNS 512                   /* more than the queue holds */

static struct {
    sigjmp_buf frame;
    bool valid;
} given_up;

int _rl_abort_internal(void)
{
    static int (*own)(void);
    if (!own)
        line_find_own(&own, "_rl_abort_internal");
    sigjmp_buf *top = &_rl_top_level;
    if (top && given_up.valid)
        memcpy(top, &given_up.frame, sizeof *top);
    return own ? own() : 0;
}

/* vi's put, and what it repeats, are done as often as is typed: a line of 1e6 times another took
 * minutes. A count that overflows is the least int, with which delete and rubout call each other
 * for ever. */
int _rl_dispatch(int key, Keymap map)
{
    static int (*own)(int, Keymap);
    if (!own)
        line_find_own(&own, "_rl_dispatch");
    if (rl_numeric_arg > COUNT_MOST)
        rl_numeric_arg = COUNT_MOST;
    if (rl_numeric_arg < -COUNT_MOST)
        rl_numeric_arg = -COUNT_MOST;
    return own ? own(key, map) : 0;
}

/* A cut that is put often is cut and put again: after three times its length is no int any more. No
 * line that is longer would be taken; and where a count makes it, it is no longer than searches for
 * a character, whose time grows with the square of the length, are done with at once. */
int rl_insert_text(const char *text)
{
    static int (*own)(const char *);
    if (!own)
        line_find_own(&own, "rl_insert_text");
    const size_t most = rl_numeric_arg > 1 ? REPEATED_MOST : LIMIT_LINE;
    if (text && strlen(text) + (size_t)rl_end > most) {
        rl_ding();
        return 0;
    }
    return own ? own(text) : 0;
}

/* In vi's command mode what follows the last character is the last one that has a width. It may
 * stand before the present one, where that has none: then the motions over words never ended. */
int _rl_forward_char_internal(int count)
{
    static int (*own)(int);
    if (!own)
        line_find_own(&own, "_rl_forward_char_internal");
    const int next = own ? own(count) : rl_end;
    return count > 0 && next < rl_point ? rl_point : next;
}

/* Where lines cannot be broken (TERM=dumb, a height of 1) it divides by a third of the width. */
void rl_redisplay(void)
{
    static void (*own)(void);
    int rows, columns;
    if (!own)
        line_find_own(&own, "rl_redisplay");
    line_mend();
    rl_get_screen_size(&rows, &columns);
    if (columns < NARROWEST)
        rl_set_screen_size(rows, NARROWEST);
    if (own)
        own();
}

/* A line that was left and come back to would be undone by a list of which parts are freed. It need
 * not be: the history keeps it as it is. */
int rl_newline(int count, int key)
{
    static int (*own)(int, int);
    if (!own)
        line_find_own(&own, "rl_newline");
    line_drop_undo();
    return own ? own(count, key) : 0;
}

/* What is still in readline's queue belongs to what was given up. */
static void drop_queue(void)
{
    while (_rl_pushed_input_available && _rl_pushed_input_available()) {
        rl_read_key();
    }
    panes_active->echo_stale = true;
}

static void on_line(char *typed);

/* A line that is entered behind a count (ESC 2 Enter) would be over with the next key only, which
 * were a key of that line. */
static void end_line(void)
{
    if (!rl_done)
        return;
    char *line = strndup(rl_line_buffer, (size_t)rl_end);
    rl_callback_handler_install(PANES_PROMPT, on_line);
    if (line)
        on_line(line);
}

static void take_key(void)
{
    if (sigsetjmp(given_up.frame, 0) == 0) {
        given_up.valid = true;
        rl_callback_read_char();
        line_mend();
        end_line();
    } else {
        rl_readline_state &= ~(unsigned long)(RL_STATE_MOREINPUT | RL_STATE_METANEXT);
        drop_queue();
    }
    given_up.valid = false;
}

/* Readline takes what is in its queue first: the key may wait for its next turn. */
void edit_key(struct panes *panes, unsigned char byte)
{
    if (panes->line_ended)
        line_over();
    panes->line_ended = false;
    panes->next_byte = byte;
    for (int turns = 0; panes->next_byte >= 0 && turns < KEY_TURNS; turns++) {
        take_key();
    }
}

/* Blocks in the middle of a key sequence; an end or Ctrl-C gets it out. */
static int get_byte(FILE *ignored)
{
    (void)ignored;
    struct panes *panes = panes_active;
    int byte = panes->next_byte;
    panes->next_byte = -1;
    while (byte < 0 && !panes_over(panes) && !panes->interrupted) {
        unsigned char next;
        struct text paste; /* in the middle of a key sequence it means nothing */
        const enum input_item item = input_next(&panes->input, clock_ns(), &next, &paste);
        if (item == INPUT_BYTE) {
            byte = next;
        } else if (item == INPUT_REPLY) {
            pacing_replied(&panes->pacing, clock_ns());
        } else if (item == INPUT_NONE) {
            panes_wait(panes, INT64_MAX);
        }
    }
    if (byte < 0 && given_up.valid) {
        /* What readline was reading for may be cleared, and a paste that is cut is not ended. */
        siglongjmp(given_up.frame, 1);
    }
    return byte < 0 ? EOF : byte;
}

static int is_pending(void)
{
    return panes_active->next_byte >= 0 || input_pending(&panes_active->input);
}

static void redisplay(void)
{
    line_mend();
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
    panes->echo_stale = panes->line_ended = true;
    if (typed && !panes->running && !panes_session(panes)->view.reading) {
        typed = offer_take(panes->program, typed);
    }
    if (!typed) {
        panes_enqueue(panes, TEXT("quit"), LINE_KEY);
    } else if (panes_session(panes)->view.reading &&
               text_starts(text_of(typed), TEXT(READING_FIND))) {
        panes_enqueue(panes, text_of(typed), LINE_SILENT);
    } else if (text_trim(text_of(typed)).len > 0) {
        if (!history_append(typed, &error) && !panes->history_warned) {
            panes->history_warned = true;
            panes_warn(panes, &error);
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
        log_add(&panes_session(panes)->log, buffer_text(&line));
        buffer_free(&line);
    }
    panes->screen_stale = true;
}

void edit_paste(struct panes *panes, struct text paste)
{
    if (RL_ISSTATE(RL_STATE_ISEARCH | RL_STATE_NSEARCH | RL_STATE_MULTIKEY | RL_STATE_CHARSEARCH |
                   RL_STATE_VIMOTION)) {
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

/* Whatever is being edited: gone, with every state readline may be in. */
void edit_clear(struct panes *panes)
{
    rl_callback_sigcleanup();
    line_drop_undo();
    rl_free_line_state();
    rl_clear_message();
    rl_replace_line("", 0);
    rl_set_keymap_from_edit_mode(); /* vi's insertion mode */
    keys_choose(panes_session(panes));
    panes->echo_stale = panes->line_ended = true;
}

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
        char *begun = strndup(rl_line_buffer, (size_t)rl_end); /* with the key that left the page */
        rl_replace_line(buffer_view(aside), 1);
        rl_point = panes->aside_point;
        if (begun)
            rl_insert_text(begun);
        free(begun);
        buffer_clear(aside);
        panes->echo_stale = true;
    }
}

/* ---- beginning and end
 * ------------------------------------------------------------------------------------ */

void edit_begin(FILE *nowhere)
{
    rl_outstream = nowhere;
    rl_getc_function = get_byte;
    rl_input_available_hook = is_pending;
    rl_redisplay_function = redisplay;
    rl_prep_term_function = enter_modes;
    rl_deprep_term_function = leave_modes;
    rl_completion_display_matches_hook = list_matches;
    rl_catch_sigwinch = 0;
    rl_callback_handler_install(PANES_PROMPT, on_line);
}

void edit_end(void)
{
    rl_callback_sigcleanup(); /* a search would go on at the next prompt, in lines that are gone */
    rl_callback_handler_remove();
    line_over();
    rl_outstream = stdout;
    rl_getc_function = rl_getc;
    rl_input_available_hook = NULL;
    rl_redisplay_function = rl_redisplay;
    rl_prep_term_function = rl_prep_terminal;
    rl_deprep_term_function = rl_deprep_terminal;
    rl_completion_display_matches_hook = NULL;
}
