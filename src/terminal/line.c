/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readline as both prompts use it: its settings and completion by the interpreter. It asks without
 * a context, so what it needs stands here. */
#include "terminal/panes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <readline/readline.h>

static struct session *completing;
static bool begun;

struct candidates {
    char **match; /* as readline wants them: the common prefix first, NULL at the end */
    size_t count, capacity;
};

static void collect(void *context, const char *candidate, const char *brief)
{
    (void)brief;
    struct candidates *all = context;
    if (all->count + 2 >= all->capacity) {
        size_t capacity = all->capacity ? 2 * all->capacity : 32;
        char **more = realloc(all->match, capacity * sizeof *more);
        if (!more) {
            return;
        }
        all->match = more;
        all->capacity = capacity;
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

#define WORD_BREAKS " \t\n;=,"

static void ignore(void *context, const char *candidate, const char *brief)
{
    (void)context;
    (void)candidate;
    (void)brief;
}

/*
 * Readline asks where words end, and only then looks for quotes. In a formula words end at
 * operators, too, and the ' of x' = y is no quote: only names of files have some.
 */
static char *word_breaks(void)
{
    static char breaks[] = WORD_BREAKS " ";
    size_t start = 0;
    const struct text line = {rl_line_buffer, (size_t)rl_end};
    bool file = !command_complete(completing, line, (size_t)rl_point, &start, ignore, NULL);
    rl_completer_quote_characters = file ? "'\"" : NULL;
    breaks[sizeof breaks - 2] = !file && start > 0 ? rl_line_buffer[start - 1] : ' ';
    return breaks;
}

static char **complete(const char *word, int begin, int end)
{
    (void)word;
    struct candidates all = {0};
    size_t start = (size_t)begin;
    size_t cursor = (size_t)end;
    rl_attempted_completion_over = 1;
    rl_completion_append_character = ' ';
    /* The interpreter knows where the argument begins; readline keeps what stands between there and
     * its own word. */
    if (!command_complete(completing, (struct text){rl_line_buffer, (size_t)rl_end}, cursor, &start,
                          collect, &all)) {
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

void line_begin(struct session *session)
{
    completing = session;
    if (begun) {
        return;
    }
    begun = true;
    rl_readline_name = "hooke";
    rl_catch_signals = 0;
    rl_catch_sigwinch = 0;
    rl_change_environment = 0;
    rl_attempted_completion_function = complete;
    rl_basic_word_break_characters = WORD_BREAKS;
    rl_completion_word_break_hook = word_breaks;
    rl_filename_quote_characters = " \t;#";
    rl_initialize();
    /* Text of any language can be typed in any locale. The inputrc is read once more, so that it
     * has the last word. */
    rl_variable_bind("input-meta", "on");
    rl_variable_bind("output-meta", "on");
    rl_variable_bind("convert-meta", "off");
    rl_variable_bind("enable-bracketed-paste", "on");
    keys_bind();
    rl_read_init_file(NULL);
    rl_set_keymap_from_edit_mode();
    history_load();
}
