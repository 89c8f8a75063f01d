/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Keys: a row each, and each a command line. Readline's keymaps find them, so that the inputrc can
 * bind them otherwise.
 */
#include <hooke/plot.h>
#include "terminal/panes.h"

#include <stdio.h>
#include <string.h>

#include <readline/history.h>
#include <readline/readline.h>

#define CX "\030" /* C-x */

/* Appends the command line; none: the key has done what it does by itself. count: the prefix
 * argument, 1 without one.
 */
typedef void make(const struct session *session, int count, struct buffer *line);

static void say_help(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    (void)count;
    help_line((struct text){rl_line_buffer, (size_t)rl_end}, (size_t)rl_point, line);
}

static void say_run(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    const enum live_state state = session->live.state;
    buffer_put(line, state == LIVE_RUNNING  ? TEXT("pause")
                     : state == LIVE_PAUSED ? TEXT("continue")
                                            : TEXT("run"));
}

static void say_step(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    buffer_format(line, count < 0 ? "back %d" : "step %d", count < 0 ? -count : count);
}

static void say_charset(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    static const char *const after[] = {[CHARSET_BRAILLE] = "block",
                                        [CHARSET_BLOCK] = "ascii",
                                        [CHARSET_ASCII] = "braille",
                                        [CHARSET_WORDS] = "auto"};
    buffer_format(line, "set charset %s", after[session_charset(session)]);
}

static double column_time(const struct session *session)
{
    return screen_column_time(session, session->front.width, session->front.height);
}

/* A quarter of what a wide plot shows. */
static void pan(const struct session *session, double columns, struct buffer *line)
{
    const double time = columns * column_time(session);
    if (time != 0) {
        buffer_put(line, TEXT("pan "));
        buffer_short(line, time, 6);
    }
}

static void say_later(const struct session *session, int count, struct buffer *line)
{
    pan(session, count * session->front.width / 8.0, line);
}

static void say_earlier(const struct session *session, int count, struct buffer *line)
{
    pan(session, -count * session->front.width / 8.0, line);
}

/* Beyond the oldest line, where `scroll` may have gone, nothing moves: a page counts from that line
 * on. */
static void page(const struct session *session, int pages, struct buffer *line)
{
    const int width = session->front.width, height = session->front.height,
              scroll = session->view.scroll;
    const int rows = screen_log_rows(session, width, height),
              max = screen_log_max(session, width, height);
    const int from = scroll < max ? scroll : max, to = from + pages * (rows > 1 ? rows - 1 : 1);
    buffer_format(line, "scroll %d", (to < max ? to : max) - scroll);
}

static void say_page_up(const struct session *session, int count, struct buffer *line)
{
    page(session, count, line);
}

static void say_page_down(const struct session *session, int count, struct buffer *line)
{
    page(session, -count, line);
}

/* The pane alone; once more: all of them. */
static void fill(const struct session *session, enum plot_kind pane, struct buffer *line)
{
    const bool full = session->view.full && view_focus(&session->view) == pane;
    buffer_format(line, "focus %s %s", catalog_row(&plot_catalog, (size_t)pane)->name,
                  full ? "shared" : "full");
}

static void say_first(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    fill(session, PLOT_POSITION, line);
}

static void say_second(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    fill(session, PLOT_PHASE, line);
}

static void say_third(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    fill(session, PLOT_VELOCITY, line);
}

static void say_fourth(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    fill(session, PLOT_ENERGY, line);
}

/* ---- on the plot
 * ------------------------------------------------------------------------------------------ */

/* Behind `cursor left` and the like: so many columns, or rows, of what is shown there. */
static void add_step(double step, struct buffer *line)
{
    if (step > 0) {
        buffer_char(line, ' ');
        buffer_short(line, step, 6);
    }
}

static void add_columns(const struct session *session, int count, struct buffer *line)
{
    add_step(count * column_time(session), line);
}

static void add_cells(const struct session *session, int count, int axis, struct buffer *line)
{
    double cell[2];
    if (screen_plane_cell(session, session->front.width, session->front.height, cell))
        add_step(count * cell[axis], line);
}

static void add_across(const struct session *session, int count, struct buffer *line)
{
    add_cells(session, count, 0, line);
}

static void add_up(const struct session *session, int count, struct buffer *line)
{
    add_cells(session, count, 1, line);
}

static void say_start(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    cursor_plane_start(session, line);
}

static void say_snap(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    const size_t next = ((size_t)session->view.cursors.snap + 1) % snap_catalog.count;
    buffer_format(line, "cursor snap %s", catalog_row(&snap_catalog, next)->name);
}

/* The rest is typed: the prompt has the keys until the line is finished. */
static void type(const char *text)
{
    rl_set_keymap_from_edit_mode();
    rl_insert_text(text);
}

static void type_time(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    (void)count;
    (void)line;
    type("cursor go ");
}

static void type_export(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    (void)count;
    (void)line;
    type("export measurements.csv measurements");
}

/* What was typed goes into a line of its own, and the panes come back. */
static void leave_reading(const char *text, struct buffer *line)
{
    type(text);
    buffer_put(line, TEXT("scroll close"));
}

static void type_command(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    (void)count;
    (void)line;
    type("");
}

/* ---- reading ---- */

static void type_find(const struct session *session, int count, struct buffer *line)
{
    (void)session;
    (void)count;
    (void)line;
    type(READING_FIND);
}

/* Where nothing was looked for it is the beginning of a command. */
static void say_next(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    if (*session->view.wanted)
        buffer_put(line, TEXT("scroll next"));
    else
        leave_reading("n", line);
}

/* Where the page has none it is the beginning of a command. */
static void say_recipe(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    if (session->view.recipe)
        buffer_format(line, "recipe %s", session->view.recipe);
    else
        leave_reading("!", line);
}

#define NEXT_ROW "scroll -1"

/* At the end, where the offer stands, it is taken. */
static void say_enter(const struct session *session, int count, struct buffer *line)
{
    (void)count;
    if (session->view.scroll > 0 || panes_active->program->offer.len == 0) {
        buffer_put(line, TEXT(NEXT_ROW));
        return;
    }
    buffer_put(line, buffer_text(&panes_active->program->offer));
    buffer_clear(&panes_active->program->offer);
    buffer_clear(&panes_active->program->passed);
}

/* ---- the table
 * -------------------------------------------------------------------------------------------- */

static const struct key {
    const char *keys[4];    /* what the terminal sends */
    const char *capability; /* or what terminfo says; NULL: nothing more */
    const char *command;    /* NULL: made by `make` */
    make *make;             /* NULL: nothing follows */
    bool silent;            /* looks at the screen only: neither shown in the log nor remembered */
} keys[] = {
    {{CX "h"}, "kf1", NULL, say_help, false},
    {{CX "r"}, "kf5", NULL, say_run, false},
    {{CX "l"}, "kf6", "layout next", NULL, false},
    {{CX "c"}, "kf7", "cursor", NULL, false},
    {{CX "s"}, "kf8", NULL, say_step, false},
    {{CX "1"}, NULL, NULL, say_first, false},
    {{CX "2"}, NULL, NULL, say_second, false},
    {{CX "3"}, NULL, NULL, say_third, false},
    {{CX "4"}, NULL, NULL, say_fourth, false},
    {{"\033[5~"}, "kpp", NULL, say_page_up, true},
    {{"\033[6~"}, "knp", NULL, say_page_down, true},
    {{CX "\033[H", CX "\033OH", CX "\033[1~"}, NULL, "scroll home", NULL, true},
    {{CX "\033[F", CX "\033OF", CX "\033[4~"}, NULL, "scroll end", NULL, true},
    {{CX "+"}, NULL, "zoom 2", NULL, false},
    {{CX "-"}, NULL, "zoom 0.5", NULL, false},
    {{CX ">"}, NULL, NULL, say_later, false},
    {{CX "<"}, NULL, NULL, say_earlier, false},
    {{CX "a"}, NULL, NULL, say_charset, false},
    {{"\014"}, NULL, "redraw", NULL, true},
};

static const struct key cursor_keys[] = {
    {{"\033[D", "\033OD", "<"}, "kcub1", "cursor left", add_columns, true},
    {{"\033[C", "\033OC", ">"}, "kcuf1", "cursor right", add_columns, true},
    {{","}, NULL, "cursor left", NULL, true},
    {{"."}, NULL, "cursor right", NULL, true},
    {{"\033[A", "\033OA", "\033[B", "\033OB"}, NULL, "cursor series", NULL, true},
    {{"n"}, NULL, "cursor next", NULL, true},
    {{"N"}, NULL, "cursor previous", NULL, true},
    {{"+"}, NULL, "cursor more", NULL, true},
    {{"-"}, NULL, "cursor less", NULL, true},
    {{"\t"}, NULL, "cursor other", NULL, true},
    {{"s"}, NULL, NULL, say_snap, true},
    {{"l"}, NULL, "cursor lock", NULL, true},
    {{"z"}, NULL, "zoom 2", NULL, true},
    {{"Z"}, NULL, "zoom 0.5", NULL, true},
    {{"g"}, NULL, NULL, type_time, true},
    {{"e"}, NULL, NULL, type_export, true},
    {{":"}, NULL, NULL, type_command, true},
    {{"?"}, NULL, "help cursor", NULL, false},
    {{"\r", "\n"}, NULL, "cursor keep", NULL, false},
    {{"q", "\004"}, NULL, "cursor off", NULL, false},
};

/* The same while a point stands on the portrait. */
static const struct key point_keys[] = {
    {{"\033[D", "\033OD", "<"}, "kcub1", "cursor left", add_across, true},
    {{"\033[C", "\033OC", ">"}, "kcuf1", "cursor right", add_across, true},
    {{"\033[A", "\033OA"}, "kcuu1", "cursor up", add_up, true},
    {{"\033[B", "\033OB"}, "kcud1", "cursor down", add_up, true},
    {{"n"}, NULL, "cursor next", NULL, true},
    {{"N"}, NULL, "cursor previous", NULL, true},
    {{"x"}, NULL, "start clear", NULL, false},
    {{":"}, NULL, NULL, type_command, true},
    {{"?"}, NULL, "help cursor", NULL, false},
    {{"\r", "\n"}, NULL, NULL, say_start, false},
    {{"q", "\004"}, NULL, "cursor off", NULL, false},
};

/* On the log while it has the whole screen; any other key begins a command. */
static const struct key reading_keys[] = {
    {{" "}, NULL, NULL, say_page_down, true},
    {{"\033[A", "\033OA"}, "kcuu1", "scroll 1", NULL, true},
    {{"\033[B", "\033OB"}, "kcud1", NEXT_ROW, NULL, true},
    {{"\r", "\n"}, NULL, NULL, say_enter, true},
    {{"\033[H", "\033OH", "\033[1~"}, "khome", "scroll home", NULL, true},
    {{"\033[F", "\033OF", "\033[4~"}, "kend", "scroll end", NULL, true},
    {{"/"}, NULL, NULL, type_find, true},
    {{"n"}, NULL, NULL, say_next, true},
    {{"!"}, NULL, NULL, say_recipe, true},
    {{"q", "\004", "\007"}, NULL, "scroll close", NULL, true},
};

/* ---- from a key to its row: readline only says what was typed
 * --------------------------------------------- */

static Keymap on_plot; /* while the cursors have the keys */
static Keymap on_text; /* while the log has the whole screen */

bool keys_on_plot(void)
{
    return on_plot && rl_get_keymap() == on_plot;
}

bool keys_on_text(void)
{
    return on_text && rl_get_keymap() == on_text;
}

/* The first character of a command. */
static int on_character(int count, int last)
{
    (void)count;
    struct buffer line = {0};
    leave_reading((const char[]){(char)last, '\0'}, &line);
    if (panes_active)
        panes_enqueue(panes_active, buffer_text(&line), LINE_SILENT);
    buffer_free(&line);
    return 0;
}

static const char *sequence(const struct key *key, size_t i)
{
    if (i < COUNT_OF(key->keys)) {
        return key->keys[i];
    }
    const char *typed = key->capability ? screen_capability(key->capability) : "";
    return *typed ? typed : NULL;
}

/* Readline tells all that was typed, the digits of a prefix argument too: the row with the longest
 * sequence at its end.
 */
static const struct key *find_key(const struct key *rows, size_t count, size_t *longest)
{
    const struct key *found = NULL;
    const size_t typed = strlen(rl_executing_keyseq);
    for (size_t r = 0; r < count; r++) {
        for (size_t i = 0; i <= COUNT_OF(rows[r].keys); i++) {
            const char *key = sequence(&rows[r], i);
            const size_t len = key ? strlen(key) : 0;
            if (len > *longest && len <= typed &&
                memcmp(rl_executing_keyseq + typed - len, key, len) == 0) {
                *longest = len;
                found = &rows[r];
            }
        }
    }
    return found;
}

static int on_key(int count, int last)
{
    struct buffer line = {0};
    size_t longest = 0;
    const struct key *key = find_key(keys, COUNT_OF(keys), &longest);
    if (!panes_active && key && key->make == say_help) {
        prompt_explain();
        return 0;
    }
    if (!panes_active) {
        return last == '\f' ? rl_clear_screen(1, last) : rl_ding();
    }
    const struct key *on_cursors =
        keys_on_plot() && panes_active->program->session->view.cursors.plane
            ? find_key(point_keys, COUNT_OF(point_keys), &longest)
        : keys_on_plot() ? find_key(cursor_keys, COUNT_OF(cursor_keys), &longest)
        : keys_on_text() ? find_key(reading_keys, COUNT_OF(reading_keys), &longest)
                         : NULL;
    key = on_cursors ? on_cursors : key;
    if (!key) {
        return rl_ding();
    }
    buffer_put(&line, key->command ? text_of(key->command) : TEXT(""));
    if (key->make) {
        key->make(panes_active->program->session, count, &line);
    }
    if (line.len > 0) {
        /* what is offered on the page, against what looks at it */
        const bool entered =
            on_cursors && keys_on_text() && !text_starts(buffer_text(&line), TEXT("scroll "));
        struct error ignored;
        if (entered) {
            history_append(buffer_view(&line), &ignored);
            using_history(); /* the line being edited is behind it now */
        }
        panes_enqueue(panes_active, buffer_text(&line),
                      entered       ? LINE_TYPED
                      : key->silent ? LINE_SILENT
                                    : LINE_KEY);
    }
    buffer_free(&line);
    return 0;
}

static void bind(const struct key *rows, size_t count, Keymap map)
{
    for (size_t r = 0; r < count; r++) {
        for (size_t i = 0; i <= COUNT_OF(rows[r].keys); i++) {
            const char *typed = sequence(&rows[r], i);
            if (typed) {
                rl_bind_keyseq_in_map(typed, on_key, map);
            }
        }
    }
}

void keys_bind(void)
{
    Keymap const maps[] = {emacs_standard_keymap, vi_insertion_keymap, vi_movement_keymap};
    for (size_t i = 0; i < COUNT_OF(maps); i++) {
        bind(keys, COUNT_OF(keys), maps[i]);
    }
    on_plot = rl_make_bare_keymap();
    if (on_plot) {
        bind(keys, COUNT_OF(keys), on_plot);
        bind(cursor_keys, COUNT_OF(cursor_keys), on_plot);
        bind(point_keys, COUNT_OF(point_keys), on_plot);
    }
    on_text = rl_make_bare_keymap();
    if (on_text) {
        bind(keys, COUNT_OF(keys), on_text);
        for (int c = ' ' + 1; c < KEYMAP_SIZE - 1; c++) {
            if (c != 127) {
                rl_bind_key_in_map(c, on_character, on_text);
            }
        }
        bind(reading_keys, COUNT_OF(reading_keys), on_text);
    }
}

void keys_choose(const struct session *session)
{
    if (session->view.reading && on_text && rl_end == 0) {
        rl_set_keymap(on_text);
    } else if (session->view.cursors.shown && on_plot && rl_end == 0) {
        rl_set_keymap(on_plot);
    } else if (keys_on_plot() || keys_on_text()) {
        rl_set_keymap_from_edit_mode();
    }
}
