/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sets readline up for both prompts: settings, completion by the interpreter, and workarounds for
 * its faults. Its callbacks have no context, so what they need is stored here. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "terminal/panes.h"

#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <wchar.h>

#include <readline/history.h>
#include <readline/readline.h>
#include <readline/tilde.h>

/* Sets *function to readline's own function of this name. The bytes are copied, because ISO C has
 * no cast from an object pointer to a function pointer. */
static void line_find_own(void *function, const char *name)
{
    void *found = dlsym(RTLD_NEXT, name);
    memcpy(function, &found, sizeof found);
}

/* session whose names are completed */
static struct session *completing;
/* line_begin() was called */
static bool begun;

/* Completions of a word. */
struct candidates {
    char **match; /* as readline wants them: the common prefix first, NULL at the end */
    size_t count, capacity;
};

/* Adds a candidate (callback of completion); it is lost if out of memory. */
static void candidate_append(void *context, const char *candidate, const char *brief)
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

/* Returns the candidates as readline wants them, match[0] being their longest common prefix, or
 * NULL if there are none. Readline frees them. */
static char **candidates_finish(struct candidates *all)
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

/* Ignores a candidate, where only the beginning of the word is wanted. */
static void ignore_candidate(void *context, const char *candidate, const char *brief)
{
    (void)context;
    (void)candidate;
    (void)brief;
}

/* Returns the characters at which words end (readline callback), with the operator before the word
 * in a formula. */
static char *word_breaks(void)
{
    static char breaks[] = WORD_BREAKS " ";
    size_t start = 0;
    const struct text line = {rl_line_buffer, (size_t)rl_end};
    const char *file =
        command_complete(completing, line, (size_t)rl_point, &start, ignore_candidate, NULL);
    breaks[sizeof breaks - 2] = !file && start > 0 ? rl_line_buffer[start - 1] : ' ';
    return breaks;
}

/* ---- names of files ---- */

/* Returns true if a backslash before `next` escapes it, inside of `quote` (0 for none). */
static bool is_escaped(char next, char quote)
{
    if (quote == '\'')
        return false;
    return quote == '"' ? next == '"' || next == '\\' : next == ' ';
}

/* Appends the name that was typed, without its quotes and backslashes. */
static void put_plain(struct text typed, char quote, struct buffer *name)
{
    for (size_t i = quote ? 1 : 0; i < typed.len; i++) {
        const char next = i + 1 < typed.len ? typed.data[i + 1] : '\0';
        i += typed.data[i] == '\\' && is_escaped(next, quote);
        buffer_char(name, typed.data[i]);
    }
}

/* Appends a file name so that the line is read back as this name, in the quote that was begun; a
 * folder's name is not closed. Returns false if the quote cannot hold it. */
static bool put_quoted(const char *name, char quote, bool folder, struct buffer *output)
{
    const struct text all = text_of(name);
    for (size_t i = 0; i < all.len; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == '\177')
            return false;
    if (!quote && (strpbrk(name, ";#\"'=,:<>\\") || name[0] == '-'))
        quote = strchr(name, '\'') ? '"' : '\'';
    if (quote == '\'' && strchr(name, quote))
        return false;
    if (quote)
        buffer_char(output, quote);
    for (size_t i = 0; i < all.len; i++) {
        if (quote == '"' ? strchr("\"\\", name[i]) != NULL : !quote && name[i] == ' ')
            buffer_char(output, '\\');
        buffer_char(output, name[i]);
    }
    if (folder)
        buffer_char(output, '/');
    else if (quote)
        buffer_char(output, quote);
    return !output->failed;
}

static bool ends_in(const char *name, const char *ending)
{
    const size_t len = strlen(name), end = strlen(ending);
    return len >= end && strcmp(name + len - end, ending) == 0;
}

/* Adds the folders and files that begin with the typed name; files must end in `ending`. */
static void collect_files(struct text typed, const char *ending, struct candidates *all)
{
    const char quote = typed.len > 0 && strchr("'\"", typed.data[0]) ? typed.data[0] : '\0';
    struct buffer name = {0}, shown = {0};
    put_plain(typed, quote, &name);
    char *path = tilde_expand(buffer_view(&name)), *match;
    for (int state = 0; (match = rl_filename_completion_function(path, state)) != NULL; state = 1) {
        struct stat status;
        const bool folder = stat(match, &status) == 0 && S_ISDIR(status.st_mode);
        buffer_clear(&shown);
        if ((folder || ends_in(match, ending)) && put_quoted(match, quote, folder, &shown))
            candidate_append(all, buffer_view(&shown), "");
        free(match);
    }
    free(path);
    buffer_free(&name);
    buffer_free(&shown);
}

/* Shortens candidates by what precedes readline's own word, which is all that it replaces; those
 * that begin differently are dropped. `start` is where ours begin, `begin` where readline's word
 * does. */
static void candidates_cut(struct candidates *all, size_t start, size_t begin)
{
    const size_t skip = start < begin ? begin - start : 0, count = all->count;
    all->count = 0;
    for (size_t i = 1; i <= count; i++) {
        char *match = all->match[i];
        const size_t len = strlen(match);
        if (len < skip || memcmp(match, rl_line_buffer + start, skip) != 0) {
            free(match);
            continue;
        }
        memmove(match, match + skip, len - skip + 1);
        all->match[++all->count] = match;
    }
}

/* Returns the completions of the word before the cursor (readline callback), or NULL. */
static char **word_complete(const char *word, int begin, int end)
{
    (void)word;
    struct candidates all = {0};
    size_t start = (size_t)begin;
    const size_t cursor = (size_t)end;
    rl_attempted_completion_over = 1;
    rl_completion_append_character = ' ';
    /* The interpreter determines where the argument begins. */
    const char *const file =
        command_complete(completing, (struct text){rl_line_buffer, (size_t)rl_end}, cursor, &start,
                         candidate_append, &all);
    if (file) {
        while (cursor == start && all.count > 0) /* names of files replace other completions */
            free(all.match[all.count--]);
        collect_files((struct text){rl_line_buffer + start, cursor - start}, file, &all);
    }
    candidates_cut(&all, start, (size_t)begin);
    const char last =
        all.count == 1 && all.match[1][0] ? all.match[1][strlen(all.match[1]) - 1] : '\0';
    if (last == '=' || last == '/')
        rl_completion_append_character = 0;
    return candidates_finish(&all);
}

/* ---- workarounds for crashes and endless loops of readline 7 to 8.3 ---- */

/* Drops the undo list, so that editing cannot be undone. */
static void line_drop_undo(void)
{
    HIST_ENTRY *entry = current_history();
    rl_undo_list = NULL;
    if (entry)
        entry->data = NULL;
}

/* The weak functions replace those of readline and call them. If readline is linked as an archive
 * its own are used, with their faults. */
__attribute__((weak)) int rl_newline(int count, int key);
__attribute__((weak)) int rl_insert_text(const char *text);

#define COLUMNS_MIN 12                  /* columns that the prompt and a part of the line need */
#define COUNT_MOST 100                  /* largest numeric prefix before its last digit is typed */
#define REPEATED_MOST ((size_t)1 << 14) /* [byte] longest line that a repeated key makes */

/* Inserts text in place of readline's function, but refuses lines that become too long: text that
 * is yanked, cut and yanked again repeatedly would soon exceed an int. The limit is that of a line
 * of the interpreter or, for repeated keys, small enough for searches whose time grows with its
 * square. */
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

/* Ends a line without its undo list, of which parts would already be freed if the user had left the
 * line and come back. The history keeps the line unchanged. */
int rl_newline(int count, int key)
{
    static int (*own)(int, int);
    if (!own)
        line_find_own(&own, "rl_newline");
    line_drop_undo();
    return own ? own(count, key) : 0;
}

/* Corrects the end of the line if readline's lies behind the text, and limits the numeric prefix.
 */
void line_mend(void)
{
    const int end = (int)strlen(rl_line_buffer);
    /* vi's put is done as often as the prefix tells: a million times took minutes. A prefix that
     * overflows is the smallest int, with which delete and rubout call each other without end. */
    if (rl_numeric_arg > COUNT_MOST)
        rl_numeric_arg = COUNT_MOST;
    if (rl_numeric_arg < -COUNT_MOST)
        rl_numeric_arg = -COUNT_MOST;
    if (end == rl_end)
        return;
    rl_end = end;
    rl_point = rl_point < end ? rl_point : end;
    line_drop_undo();
}

/* Redisplays the line with a minimal width: readline divides by a third of it where lines cannot be
 * broken (TERM=dumb, a height of 1). */
void line_redisplay(void)
{
    int rows, columns;
    line_mend();
    rl_get_screen_size(&rows, &columns);
    if (columns < COLUMNS_MIN)
        rl_set_screen_size(rows, COLUMNS_MIN);
    rl_redisplay();
}

/* Returns true if the line has characters without a width (combining marks) or invalid bytes. */
static bool has_zero_width_characters(void)
{
    wchar_t c;
    for (int i = 0, used; i < rl_end; i += used) {
        used = mbtowc(&c, rl_line_buffer + i, (size_t)(rl_end - i));
        if (used < 1 || wcwidth(c) < 1)
            return true;
    }
    return false;
}

#define TO_WORD_ENDS "wWeE=*\\"

/* Replaces keys of vi's command mode that go to the end of a word. Readline's own never end if the
 * line ends in characters without a width, so words are moved by other functions then. */
static int go_to_word_end(int count, int key)
{
    if (has_zero_width_characters())
        return strchr("wWeE", key) ? rl_forward_word(count, key) : rl_ding();
    if (key == 'w' || key == 'W')
        return rl_vi_next_word(count, key);
    return key == 'e' || key == 'E' ? rl_vi_end_word(count, key) : rl_vi_complete(count, key);
}

/* Empties the line and returns to the prompt's keymap. */
void line_drop(void)
{
    line_drop_undo();
    rl_free_line_state();
    rl_replace_line("", 0);
    rl_set_keymap_from_edit_mode(); /* insertion mode, in vi's */
}

/* Leaves a search, a key sequence or a paste by readline's own jump to a new key; does not return.
 */
void line_leave(void)
{
    if (RL_ISSTATE(RL_STATE_ISEARCH | RL_STATE_NSEARCH | RL_STATE_NUMERICARG)) {
        rl_restore_prompt();
    }
    const unsigned long inside = RL_STATE_ISEARCH | RL_STATE_NSEARCH | RL_STATE_NUMERICARG |
                                 RL_STATE_MULTIKEY | RL_STATE_VIMOTION | RL_STATE_CHARSEARCH |
                                 RL_STATE_METANEXT | RL_STATE_MOREINPUT | RL_STATE_COMPLETING;
    rl_readline_state &= ~inside;
    rl_abort(1, 0);
}

/* Sets readline up at the first call; later calls only change the session. */
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
    rl_attempted_completion_function = word_complete;
    rl_basic_word_break_characters = WORD_BREAKS;
    rl_completion_word_break_hook = word_breaks;
    rl_initialize();
    /* Text of any language can be typed in any locale. The inputrc is read once more afterwards, so
     * that the user's settings win. */
    rl_variable_bind("input-meta", "on");
    rl_variable_bind("output-meta", "on");
    rl_variable_bind("convert-meta", "off");
    rl_variable_bind("enable-bracketed-paste", "on");
    for (const char *key = TO_WORD_ENDS; *key; key++)
        rl_bind_key_in_map(*key, go_to_word_end, vi_movement_keymap);
    keys_bind();
    rl_redisplay_function = line_redisplay;
    rl_read_init_file(NULL);
    rl_set_keymap_from_edit_mode();
    history_load();
}

/* ---- memory that readline frees ---- */

/* Readline's undo lists have no owner: the line, its entry of the history and the copy that was
 * left for it share one, and free it one after the other, or none does. So their parts are noted
 * here, and what readline frees is freed only when the line is over, each part once. */
struct pointers {
    void **item;
    size_t count, capacity;
};

/* parts of undo lists, and memory that readline has freed */
static struct pointers parts, freed;

void xfree(void *memory); /* called by readline, as is xmalloc() in crash.c */

/* Adds a pointer, which is lost if out of memory. */
static void put_pointer(struct pointers *all, void *pointer)
{
    if (all->count == all->capacity) {
        const size_t capacity = all->capacity ? 2 * all->capacity : 256;
        void **more = realloc(all->item, capacity * sizeof *more);
        if (!more)
            return;
        all->item = more;
        all->capacity = capacity;
    }
    all->item[all->count++] = pointer;
}

void xfree(void *memory)
{
    if (memory)
        put_pointer(&freed, memory);
}

/* Notes each part of the undo list, so that line_over() can free it (in place of readline's). */
__attribute__((weak)) void rl_add_undo(enum undo_code what, int start, int end, char *text)
{
    static void (*own)(enum undo_code, int, int, char *);
    if (!own)
        line_find_own(&own, "rl_add_undo");
    if (own)
        own(what, start, end, text);
    put_pointer(&parts, rl_undo_list);
}

static int by_address(const void *a, const void *b)
{
    const uintptr_t one = (uintptr_t) * (void *const *)a, two = (uintptr_t) * (void *const *)b;
    return (one > two) - (one < two);
}

/* Frees what readline has given up since the last line: the parts of undo lists and noted memory,
 * each address once. */
void line_over(void)
{
    HIST_ENTRY **entry = history_list();
    rl_undo_list = NULL;
    rl_maybe_save_line(); /* readline rings a bell if no line was left for the history */
    rl_maybe_unsave_line();
    rl_undo_list = NULL;
    for (size_t i = 0; entry && entry[i]; i++)
        entry[i]->data = NULL;
    for (size_t i = 0; i < parts.count; i++) {
        const UNDO_LIST *part = parts.item[i];
        xfree(part && part->what == UNDO_DELETE ? part->text : NULL);
        xfree(parts.item[i]);
    }
    if (freed.count > 1)
        qsort(freed.item, freed.count, sizeof *freed.item, by_address);
    for (size_t i = 0; i < freed.count; i++)
        if (i == 0 || freed.item[i] != freed.item[i - 1])
            free(freed.item[i]);
    freed.count = parts.count = 0;
}
