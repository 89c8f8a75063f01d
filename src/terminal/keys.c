/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Keys of the panes. Each is a row that makes a command line. They are bound in readline's keymaps,
 * so that the user's inputrc can bind them differently. */
#include <hooke/base/number.h>
#include <hooke/plot.h>
#include "terminal/panes.h"

#include <string.h>

#include <readline/history.h>
#include <readline/readline.h>

#define CTRL_X "\030" /* C-x */

/* A key that was pressed. */
struct press {
    const struct session *session;
    int count; /* the numeric prefix (M-3), 1 without one */
    int arg;   /* argument of the row */
};

/* Function of a row that appends a command line, or what follows the row's text. If the line
 * remains empty there is nothing to execute. */
typedef void make(const struct press *press, struct buffer *line);

/* Appends the command that explains the word at the cursor. */
static void say_help(const struct press *press, struct buffer *line)
{
    (void)press;
    help_line((struct text){rl_line_buffer, (size_t)rl_end}, (size_t)rl_point, line);
}

/* Appends the command of the run key: run, pause or continue, by the state of the live run. */
static void say_run(const struct press *press, struct buffer *line)
{
    const enum live_state state = press->session->live.state;
    struct text word;
    if (state == LIVE_RUNNING)
        word = TEXT("pause");
    else
        word = state == LIVE_PAUSED ? TEXT("continue") : TEXT("run");
    buffer_put(line, word);
}

static void say_step(const struct press *press, struct buffer *line)
{
    const int steps = press->count < 0 ? -press->count : press->count;
    buffer_format(line, press->count < 0 ? "back %d" : "step %d", steps);
}

/* Appends the command that chooses the next charset: braille, block, ascii, braille ... and back
 * from words. */
static void say_charset(const struct press *press, struct buffer *line)
{
    const struct charset *charset = session_charset(press->session);
    const char *next = "braille";
    if (charset->words)
        next = "auto";
    else if (charset == &charset_braille)
        next = "block";
    else if (charset == &charset_block)
        next = "ascii";
    buffer_format(line, "set charset %s", next);
}

static double column_time(const struct session *session)
{
    return screen_column_time(session, session->front.width, session->front.height);
}

/* Appends the command that moves the time axis by an eighth of the screen's width, in the direction
 * press->arg. */
static void say_pan(const struct press *press, struct buffer *line)
{
    const double time =
        press->arg * press->count * press->session->front.width / 8.0 * column_time(press->session);
    if (time != 0) {
        buffer_put(line, TEXT("pan "));
        buffer_short(line, time, 6);
    }
}

/* Appends the command that scrolls the log by a page. `scroll` may have gone beyond the oldest
 * line, so the page counts from that line. */
static void say_page(const struct press *press, struct buffer *line)
{
    const struct session *session = press->session;
    const int width = session->front.width, height = session->front.height,
              scroll = session->view.scroll;
    const int rows = screen_log_rows(session, width, height),
              max = screen_log_max(session, width, height);
    const int old_scroll = scroll < max ? scroll : max;
    const int new_scroll = old_scroll + press->arg * press->count * (rows > 1 ? rows - 1 : 1);
    buffer_format(line, "scroll %d", (new_scroll < max ? new_scroll : max) - scroll);
}

/* Appends the command that shows a pane alone, or all panes again if it is alone already. */
static void say_pane(const struct press *press, struct buffer *line)
{
    const bool full =
        press->session->view.full && (int)view_focus(&press->session->view) == press->arg;
    buffer_format(line, "focus %s %s", catalog_row(&plot_catalog, (size_t)press->arg)->name,
                  full ? "shared" : "full");
}

/* ---- on the plot ---- */

/* Appends a distance in units of the axis to `cursor left` and the like. */
static void add_step(double step, struct buffer *line)
{
    if (step > 0) {
        buffer_char(line, ' ');
        buffer_short(line, step, 6);
    }
}

/* Appends the time of as many columns as the prefix tells. */
static void add_columns(const struct press *press, struct buffer *line)
{
    add_step(press->count * column_time(press->session), line);
}

/* Appends as many cells as the prefix tells, in units of the axis press->arg of the portrait. */
static void add_cells(const struct press *press, struct buffer *line)
{
    const struct session *session = press->session;
    double cell[2];
    if (screen_plane_cell(session, session->front.width, session->front.height, cell))
        add_step(press->count * cell[press->arg], line);
}

static void say_start(const struct press *press, struct buffer *line)
{
    cursor_plane_start(press->session, line);
}

/* Appends the command that chooses the next kind of points that cursors snap to. */
static void say_snap(const struct press *press, struct buffer *line)
{
    const size_t next = ((size_t)press->session->view.cursors.snap + 1) % snap_catalog.count;
    buffer_format(line, "cursor snap %s", catalog_row(&snap_catalog, next)->name);
}

/* Inserts the beginning of a line into the prompt, which then gets the keys until the line is
 * finished. */
static void prompt_text_insert(const char *text)
{
    rl_set_keymap_from_edit_mode();
    rl_insert_text(text);
}

/* Begins a command line with the text, and leaves the page for the panes. */
static void leave_reading(const char *text, struct buffer *line)
{
    prompt_text_insert(text);
    buffer_put(line, TEXT("scroll close"));
}

/* ---- reading ---- */

/* Appends the command that repeats a search; if nothing was searched the key begins a command. */
static void say_next(const struct press *press, struct buffer *line)
{
    if (*press->session->view.wanted)
        buffer_put(line, TEXT("scroll next"));
    else
        leave_reading("n", line);
}

/* Appends the command that runs the recipe on the page; if there is none the key begins a command.
 */
static void say_recipe(const struct press *press, struct buffer *line)
{
    if (press->session->view.recipe)
        buffer_format(line, "recipe %s", press->session->view.recipe);
    else
        leave_reading("!", line);
}

#define NEXT_ROW "scroll -1"

/* Executes the suggestion if the end of the page, where it is shown, is visible; else scrolls by a
 * row. */
static void say_enter(const struct press *press, struct buffer *line)
{
    struct front_program *program = panes_active->program;
    if (press->session->view.scroll > 0 || program->offer.len == 0) {
        if (press->session->view.scroll == 0)
            offer_again(program, input_pending(&panes_active->input));
        buffer_put(line, TEXT(NEXT_ROW));
        return;
    }
    program->taken = true;
    buffer_put(line, buffer_text(&program->offer));
    buffer_clear(&program->offer);
    buffer_clear(&program->passed);
}

/* ---- the table ---- */

/* Action of a key: a command that counts like a typed one (SAYS); one that only changes the view,
 * which is neither logged nor remembered (LOOKS); or the beginning of a line (TYPES). */
enum key_kind { SAYS, LOOKS, TYPES };

static const struct key {
    const char *keys[4];    /* bytes that the terminal sends */
    const char *capability; /* name in terminfo of further bytes, or NULL */
    enum key_kind kind;
    const char *text; /* command line or its beginning, or NULL if `make` writes it all */
    make *make;       /* function that appends to it, or NULL */
    int arg;
} keys[] = {
    {{CTRL_X "h"}, "kf1", SAYS, NULL, say_help, 0},
    {{CTRL_X "r"}, "kf5", SAYS, NULL, say_run, 0},
    {{CTRL_X "l"}, "kf6", SAYS, "layout next", NULL, 0},
    {{CTRL_X "c"}, "kf7", SAYS, "cursor", NULL, 0},
    {{CTRL_X "s"}, "kf8", SAYS, NULL, say_step, 0},
    {{CTRL_X "1"}, NULL, SAYS, NULL, say_pane, PLOT_POSITION},
    {{CTRL_X "2"}, NULL, SAYS, NULL, say_pane, PLOT_PHASE},
    {{CTRL_X "3"}, NULL, SAYS, NULL, say_pane, PLOT_VELOCITY},
    {{CTRL_X "4"}, NULL, SAYS, NULL, say_pane, PLOT_ENERGY},
    {{"\033[5~"}, "kpp", LOOKS, NULL, say_page, 1},
    {{"\033[6~"}, "knp", LOOKS, NULL, say_page, -1},
    {{CTRL_X "\033[H", CTRL_X "\033OH", CTRL_X "\033[1~"}, NULL, LOOKS, "scroll home", NULL, 0},
    {{CTRL_X "\033[F", CTRL_X "\033OF", CTRL_X "\033[4~"}, NULL, LOOKS, "scroll end", NULL, 0},
    {{CTRL_X "+"}, NULL, SAYS, "zoom 2", NULL, 0},
    {{CTRL_X "-"}, NULL, SAYS, "zoom 0.5", NULL, 0},
    {{CTRL_X ">"}, NULL, SAYS, NULL, say_pan, 1},
    {{CTRL_X "<"}, NULL, SAYS, NULL, say_pan, -1},
    {{CTRL_X "a"}, NULL, SAYS, NULL, say_charset, 0},
    {{"\014"}, NULL, LOOKS, "redraw", NULL, 0},
};

/* Keys while the cursors are shown on the time plots. */
static const struct key cursor_keys[] = {
    {{"\033[D", "\033OD", "<"}, "kcub1", LOOKS, "cursor left", add_columns, 0},
    {{"\033[C", "\033OC", ">"}, "kcuf1", LOOKS, "cursor right", add_columns, 0},
    {{","}, NULL, LOOKS, "cursor left", NULL, 0},
    {{"."}, NULL, LOOKS, "cursor right", NULL, 0},
    {{"\033[A", "\033OA", "\033[B", "\033OB"}, NULL, LOOKS, "cursor series", NULL, 0},
    {{"n"}, NULL, LOOKS, "cursor next", NULL, 0},
    {{"N"}, NULL, LOOKS, "cursor previous", NULL, 0},
    {{"+"}, NULL, LOOKS, "cursor more", NULL, 0},
    {{"-"}, NULL, LOOKS, "cursor less", NULL, 0},
    {{"\t"}, NULL, LOOKS, "cursor other", NULL, 0},
    {{"s"}, NULL, LOOKS, NULL, say_snap, 0},
    {{"l"}, NULL, LOOKS, "cursor lock", NULL, 0},
    {{"z"}, NULL, LOOKS, "zoom 2", NULL, 0},
    {{"Z"}, NULL, LOOKS, "zoom 0.5", NULL, 0},
    {{"g"}, NULL, TYPES, "cursor go ", NULL, 0},
    {{"e"}, NULL, TYPES, "export measurements.csv measurements", NULL, 0},
    {{":"}, NULL, TYPES, "", NULL, 0},
    {{"?"}, NULL, SAYS, "help cursor", NULL, 0},
    {{"\r", "\n"}, NULL, SAYS, "cursor keep", NULL, 0},
    {{"q", "\004"}, NULL, SAYS, "cursor off", NULL, 0},
};

/* Keys while the cursor is a point on the portrait. */
static const struct key point_keys[] = {
    {{"\033[D", "\033OD", "<"}, "kcub1", LOOKS, "cursor left", add_cells, 0},
    {{"\033[C", "\033OC", ">"}, "kcuf1", LOOKS, "cursor right", add_cells, 0},
    {{"\033[A", "\033OA"}, "kcuu1", LOOKS, "cursor up", add_cells, 1},
    {{"\033[B", "\033OB"}, "kcud1", LOOKS, "cursor down", add_cells, 1},
    {{"n"}, NULL, LOOKS, "cursor next", NULL, 0},
    {{"N"}, NULL, LOOKS, "cursor previous", NULL, 0},
    {{"x"}, NULL, SAYS, "start clear", NULL, 0},
    {{":"}, NULL, TYPES, "", NULL, 0},
    {{"?"}, NULL, SAYS, "help cursor", NULL, 0},
    {{"\r", "\n"}, NULL, SAYS, NULL, say_start, 0},
    {{"q", "\004"}, NULL, SAYS, "cursor off", NULL, 0},
};

/* Keys of the log while it is read on the whole screen; any other key begins a command. */
static const struct key reading_keys[] = {
    {{" "}, NULL, LOOKS, NULL, say_page, -1},
    {{"\033[A", "\033OA"}, "kcuu1", LOOKS, "scroll 1", NULL, 0},
    {{"\033[B", "\033OB"}, "kcud1", LOOKS, NEXT_ROW, NULL, 0},
    {{"\r", "\n"}, NULL, LOOKS, NULL, say_enter, 0},
    {{"\033[H", "\033OH", "\033[1~"}, "khome", LOOKS, "scroll home", NULL, 0},
    {{"\033[F", "\033OF", "\033[4~"}, "kend", LOOKS, "scroll end", NULL, 0},
    {{"/"}, NULL, TYPES, READING_FIND, NULL, 0},
    {{"n"}, NULL, LOOKS, NULL, say_next, 0},
    {{"!"}, NULL, LOOKS, NULL, say_recipe, 0},
    {{"q", "\004", "\007"}, NULL, LOOKS, "scroll close", NULL, 0},
};

/* ---- from a key to its row; readline only reports what was typed ---- */

static Keymap on_plot; /* keymap while the cursors have the keys */
static Keymap on_text; /* keymap while the log is read on the whole screen */

bool keys_on_plot(void)
{
    return on_plot && rl_get_keymap() == on_plot;
}

bool keys_on_text(void)
{
    return on_text && rl_get_keymap() == on_text;
}

/* Begins a command with a character typed on the page (readline callback). */
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

/* Returns sequence i of a key: one of its own, or at last that of terminfo; NULL if there is none.
 */
static const char *key_sequence(const struct key *key, size_t i)
{
    if (i < COUNT_OF(key->keys)) {
        return key->keys[i];
    }
    const char *typed = key->capability ? screen_capability(key->capability) : "";
    return *typed ? typed : NULL;
}

/* Returns the row whose sequence is the longest at the end of what was typed, if longer than
 * *longest, which it updates; NULL if there is none. Readline reports the digits of a prefix, too.
 */
static const struct key *find_key(const struct key *rows, size_t count, size_t *longest)
{
    const struct key *found = NULL;
    const size_t typed = strlen(rl_executing_keyseq);
    for (size_t r = 0; r < count; r++) {
        for (size_t i = 0; i <= COUNT_OF(rows[r].keys); i++) {
            const char *key = key_sequence(&rows[r], i);
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

/* Acts on a key of the tables, as a readline callback: executes its command line or inserts its
 * text. `count` is readline's numeric argument and `last` the key. At the plain prompt only help
 * and Ctrl-L have an effect; unknown keys ring the bell. Returns 0 for readline. */
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
    const struct key *on_cursors;
    if (keys_on_plot() && panes_active->program->session->view.cursors.plane)
        on_cursors = find_key(point_keys, COUNT_OF(point_keys), &longest);
    else if (keys_on_plot())
        on_cursors = find_key(cursor_keys, COUNT_OF(cursor_keys), &longest);
    else
        on_cursors =
            keys_on_text() ? find_key(reading_keys, COUNT_OF(reading_keys), &longest) : NULL;
    key = on_cursors ? on_cursors : key;
    if (!key) {
        return rl_ding();
    }
    if (key->kind == TYPES) {
        prompt_text_insert(key->text);
        return 0;
    }
    buffer_put(&line, text_of(key->text));
    if (key->make) {
        key->make(&(struct press){panes_active->program->session, count, key->arg}, &line);
    }
    if (line.len > 0) {
        /* a command of the page itself, unlike those that scroll it */
        const bool entered =
            on_cursors && keys_on_text() && !text_starts(buffer_text(&line), TEXT("scroll "));
        if (entered) {
            history_keep(buffer_view(&line), panes_active->program->reply);
            using_history(); /* moves to the end of the history */
        }
        enum line_from origin;
        if (entered)
            origin = LINE_TYPED;
        else
            origin = key->kind == LOOKS ? LINE_SILENT : LINE_KEY;
        panes_enqueue(panes_active, buffer_text(&line), origin);
    }
    buffer_free(&line);
    return 0;
}

/* Binds the sequences of all rows in a keymap. */
static void keymap_bind(const struct key *rows, size_t count, Keymap map)
{
    for (size_t r = 0; r < count; r++) {
        for (size_t i = 0; i <= COUNT_OF(rows[r].keys); i++) {
            const char *typed = key_sequence(&rows[r], i);
            if (typed) {
                rl_bind_keyseq_in_map(typed, on_key, map);
            }
        }
    }
}

/* Binds the keys in readline's keymaps, and makes the keymaps of the plot and of the page. */
void keys_bind(void)
{
    Keymap const maps[] = {emacs_standard_keymap, vi_insertion_keymap, vi_movement_keymap};
    for (size_t i = 0; i < COUNT_OF(maps); i++) {
        keymap_bind(keys, COUNT_OF(keys), maps[i]);
    }
    on_plot = rl_make_bare_keymap();
    if (on_plot) {
        keymap_bind(keys, COUNT_OF(keys), on_plot);
        keymap_bind(cursor_keys, COUNT_OF(cursor_keys), on_plot);
        keymap_bind(point_keys, COUNT_OF(point_keys), on_plot);
    }
    on_text = rl_make_bare_keymap();
    if (on_text) {
        keymap_bind(keys, COUNT_OF(keys), on_text);
        for (int c = ' ' + 1; c < KEYMAP_SIZE - 1; c++) {
            if (c != 127) {
                rl_bind_key_in_map(c, on_character, on_text);
            }
        }
        keymap_bind(reading_keys, COUNT_OF(reading_keys), on_text);
    }
}

/* Chooses the keymap for an empty line: that of the page, of the plot, or of the prompt. */
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
