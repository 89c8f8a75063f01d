/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The terminal under ncurses: its modes, its size, and the cells shown on it. ncurses only draws;
 * it never reads and catches no signal. */
#include <hooke/base/safe_text.h>
#include "terminal/panes.h"

#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>
#include <wchar.h>

#include <curses.h>
#include <term.h>

/* ---- the terminal's own sequences ---- */

const char *screen_capability(const char *name)
{
    const char *text = tigetstr(name);
    return text && text != (const char *)-1 ? text : "";
}

static struct buffer gathered; /* output of tputs(), whose callback has no context */

static int character_gather(int c)
{
    buffer_char(&gathered, (char)c);
    return c;
}

static void screen_send(const char *sequence)
{
    int ignored;
    write_all(STDOUT_FILENO, text_of(sequence), &ignored);
}

/* Arms the fatal handlers with the sequences that restore the terminal without ncurses. */
static void arm_crash(void)
{
    static const char *const names[] = {"BD", "sgr0", "op", "cnorm", "rmcup"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        if (*screen_capability(names[i])) {
            tputs(screen_capability(names[i]), 1, character_gather);
        }
    }
    /* a terminal without a second screen gets the cursor at the bottom */
    if (!*screen_capability("rmcup")) {
        tputs(tiparm(screen_capability("cup"), 998, 0), 1, character_gather);
    }
    buffer_put(&gathered, TEXT("\r\n"));
    crash_arm(gathered.failed ? TEXT("\r\n") : buffer_text(&gathered));
    buffer_free(&gathered);
}

/* ---- modes ---- */

/* Sets the modes in which every key arrives at once; only Ctrl-C, Ctrl-Z and Ctrl-\ are signals.
 * VMIN 0 makes reads return at once, whatever poll() reported. */
static void set_modes(void)
{
    struct termios modes;
    cbreak();
    noecho();
    nonl();
    if (tcgetattr(STDIN_FILENO, &modes) == 0) {
        modes.c_iflag &= ~(tcflag_t)(IXON | ICRNL);
        modes.c_cc[VMIN] = modes.c_cc[VTIME] = 0;
        modes.c_cc[VLNEXT] = modes.c_cc[VDISCARD] = _POSIX_VDISABLE;
        tcsetattr(STDIN_FILENO, TCSADRAIN, &modes);
    }
    def_prog_mode();
}

/* Reads the size of the terminal and makes canvases of that size, which stay empty if out of
 * memory. */
static void set_size(struct terminal_screen *screen)
{
    struct winsize size;
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
        screen->width = size.ws_col;
        screen->height = size.ws_row;
        resizeterm(screen->height, screen->width); /* not the size in LINES and COLUMNS */
    } else {
        getmaxyx(stdscr, screen->height, screen->width);
    }
    canvas_free(&screen->canvas);
    canvas_free(&screen->shown);
    if (!canvas_init(&screen->canvas, screen->width, screen->height)) {
        screen->canvas = (struct canvas){0};
    }
    if (!canvas_init(&screen->shown, screen->width, screen->height)) {
        screen->shown = (struct canvas){0};
    }
    screen->stale = true;
}

/* Usual terminals, with the value of TERMINFO that describes them. */
static const struct {
    const char *name, *compiled;
} terminals[] = {
#include "terminals.def"
    {NULL, NULL}};

/* Sets TERMINFO if the system has no description of a usual terminal. */
void describe_terminal(void)
{
    const char *term = getenv("TERM");
    int status;
    if (!term || !*term)
        return;
    if (setupterm(term, STDOUT_FILENO, &status) == OK) {
        del_curterm(cur_term);
        return;
    }
    for (size_t i = 0; terminals[i].name; i++)
        if (strcmp(terminals[i].name, term) == 0)
            setenv("TERMINFO", terminals[i].compiled, 1);
}

/* [cell] smallest screen on which panes are shown */
#define MIN_WIDTH 20
#define MIN_HEIGHT 6

/* Returns true if panes can be shown; otherwise returns false with the reason as error. */
bool panes_possible(struct error *error)
{
    const char *term = getenv("TERM");
    struct winsize size;
    struct stat input_stat, output_stat;
    int status;
    if (fstat(STDIN_FILENO, &input_stat) != 0 || fstat(STDOUT_FILENO, &output_stat) != 0 ||
        input_stat.st_rdev != output_stat.st_rdev) {
        return error_set(error, ERROR_COMMAND, "input and output are different terminals");
    }
    if (!term || !*term || setupterm(term, STDOUT_FILENO, &status) != OK) {
        return error_set(error, ERROR_COMMAND, "the type of the terminal is unknown (TERM=%.40s)",
                         term ? term : "");
    }
    const bool moves = *screen_capability("cup") != '\0';
    del_curterm(cur_term);
    if (!moves) {
        return error_set(error, ERROR_COMMAND,
                         "the cursor cannot be moved on this terminal (TERM=%.40s)", term);
    }
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0 &&
        (size.ws_col < MIN_WIDTH || size.ws_row < MIN_HEIGHT)) {
        return error_set(error, ERROR_COMMAND, "the terminal is smaller than %dx%d", MIN_WIDTH,
                         MIN_HEIGHT);
    }
    return true;
}

/* Takes over the terminal with ncurses: sets its modes, finds its size, switches bracketed paste on
 * (BE), and arms the handlers that restore it after a crash. Returns false if ncurses cannot use
 * the terminal. */
bool screen_begin(struct terminal_screen *screen)
{
    crash_modes();
    screen->handle = newterm(NULL, stdout, stdin);
    if (!screen->handle) {
        return false;
    }
    arm_crash();
    set_modes();
    set_size(screen);
    screen_send(screen_capability("BE"));
    return true;
}

/* Gives the terminal back and frees the canvases. */
void screen_end(struct terminal_screen *screen)
{
    screen_send(screen_capability("BD"));
    endwin();
    delscreen(screen->handle);
    crash_disarm();
    canvas_free(&screen->canvas);
    canvas_free(&screen->shown);
    screen->handle = NULL;
}

void screen_leave(struct terminal_screen *screen)
{
    (void)screen;
    screen_send(screen_capability("BD"));
    endwin();
}

/* Takes the terminal again after the program was stopped. */
void screen_return(struct terminal_screen *screen)
{
    crash_modes(); /* the shell may have changed the modes */
    def_shell_mode();
    set_modes();
    set_size(screen);
    clearok(stdscr, TRUE);
    screen_send(screen_capability("BE"));
}

void screen_retake(struct terminal_screen *screen)
{
    reset_prog_mode();
    screen_send(screen_capability("smcup"));
    screen_send(screen_capability("BE"));
    screen_resize(screen);
}

void screen_repaint(struct terminal_screen *screen)
{
    clearok(stdscr, TRUE);
    screen->stale = true;
}

void screen_resize(struct terminal_screen *screen)
{
    set_size(screen);
    clearok(stdscr, TRUE);
}

/* ---- cells ---- */

/* Attributes of styles; their colours are those of printed figures, and backgrounds are never
 * painted. */
static const attr_t style_attributes[] = {
    [STYLE_DIM] = A_DIM, [STYLE_BOLD] = A_BOLD, [STYLE_ALERT] = A_NORMAL};

/* Sets colours up when they are wanted for the first time, because ncurses sends colour sequences
 * from then on. Returns false if there are none. */
static bool begin_colors(struct terminal_screen *screen)
{
    if (!screen->color_begun && has_colors() && start_color() == OK && use_default_colors() == OK) {
        for (size_t i = 0; i < COUNT_OF(style_attributes); i++) {
            const int color = style_color((enum style)i, COLORS);
            if (color >= 0) {
                init_pair((short)i, (short)color, -1);
            }
        }
        screen->color_begun = true;
    }
    return screen->color_begun;
}

void screen_color(struct terminal_screen *screen, bool wanted)
{
    screen->stale |= wanted != screen->color_wanted;
    screen->color_wanted = wanted;
}

/* Returns the character that is sent for a code point: '?' if the C library counts its width
 * differently, which would shift the rest of the row. */
static wchar_t sent_character(const struct terminal_screen *screen, uint32_t codepoint)
{
    const wchar_t c = (wchar_t)codepoint;
    if (codepoint < ' ' || codepoint == 127) {
        return L'?';
    }
    return codepoint < 128 || (screen->utf8 && wcwidth(c) == codepoint_width(codepoint)) ? c : L'?';
}

/* Writes row y of the canvas to ncurses. */
static void put_screen_row(struct terminal_screen *screen, int y)
{
    const struct cell *row = screen->canvas.cell + (size_t)y * (size_t)screen->width;
    const bool color = screen->color_wanted && begin_colors(screen);
    cchar_t *line = calloc((size_t)screen->width + 1, sizeof *line);
    int n = 0;
    for (int x = 0; line && x < screen->width; x++) {
        if (row[x].codepoint == 0) {
            continue;
        }
        const wchar_t wide[2] = {sent_character(screen, row[x].codepoint), L'\0'};
        const enum style style = row[x].codepoint == ' ' ? STYLE_PLAIN : (enum style)row[x].style;
        setcchar(&line[n++], wide, style_attributes[style],
                 color && style_color(style, COLORS) >= 0 ? (short)style : 0, NULL);
        if (wide[0] == L'?' && x + 1 < screen->width && row[x + 1].codepoint == 0) {
            setcchar(&line[n++], L" ", A_NORMAL, 0, NULL);
        }
    }
    if (line) {
        mvadd_wchnstr(y, 0, line, n);
    }
    free(line);
}

#define MOVE_COST 8 /* [byte] cost of moving the cursor */

/* Returns about how many bytes must be sent to make row b look like row a, 0 if they are equal. */
static int row_cost(const struct cell *a, const struct cell *b, int n)
{
    int cost = 0;
    for (int i = 0; i < n; i++) {
        if (a[i].codepoint != b[i].codepoint || a[i].style != b[i].style) {
            if (a[i].codepoint < 0x80)
                cost += 1;
            else
                cost += a[i].codepoint < 0x800 ? 2 : 3;
        }
    }
    return cost > 0 ? cost + MOVE_COST : 0;
}

/* Sends rows from first_row on that have changed, until about `bytes` bytes are sent; the next call
 * continues there. Returns how much was sent. */
enum shown screen_show(struct terminal_screen *screen, int first_row, int bytes, int cursor_x,
                       int cursor_y)
{
    if (!screen->canvas.cell || !screen->shown.cell) {
        set_size(screen); /* tries again to get memory */
        return SHOWN_NOTHING;
    }
    const int all = screen->height - first_row;
    int sent = 0, i = 0;
    for (; i < all && sent < bytes; i++) {
        /* continues where the last part ended */
        const int y = first_row + (screen->next + i) % all;
        const size_t offset = (size_t)y * (size_t)screen->width;
        const int cost =
            row_cost(screen->canvas.cell + offset, screen->shown.cell + offset, screen->width);
        if (screen->stale || cost > 0) {
            put_screen_row(screen, y);
            memcpy(screen->shown.cell + offset, screen->canvas.cell + offset,
                   (size_t)screen->width * sizeof(struct cell));
            sent += screen->stale ? screen->width : cost;
        }
    }
    screen->next = i < all ? (screen->next + i) % all : 0;
    screen->stale &= i < all;
    move(cursor_y, cursor_x);
    refresh();
    if (i < all)
        return SHOWN_PART;
    return sent > 0 ? SHOWN_ALL : SHOWN_NOTHING;
}
