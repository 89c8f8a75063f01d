/* SPDX-License-Identifier: GPL-3.0-or-later */
/* view: the screen as a function of a session and a size. ncurses shows its cells; `screenshot` and
 * tests print them. Nothing here changes the session. */
#pragma once

#include <hooke/figure.h>
#include <hooke/command.h>

/* The line that the user is editing, as readline has it: in UTF-8 or the locale's encoding. Bytes
 * that cannot be shown are replaced when the line is drawn. */
struct prompt_line {
    struct text prompt; /* The prompt: "hooke> ", or "(reverse-i-search)`x': ". */
    struct text line;   /* The text after the prompt. */
    size_t cursor;      /* Position [byte] of the cursor in `line`. */
    /* Text that is shown in place of the numbers line, such as "PgUp log"; empty for none. */
    struct text hint;
};

/* Draws the whole screen into the canvas, whose size, from 1x1 on, is that of the screen. From top
 * to bottom there are the state line, the panes of the layout, the log, the numbers line (a row
 * with the current values of the run) and the prompt. On a small screen parts are left out in this
 * order: numbers line, second pane, all rows but one of the log, tick labels, frame, all but the
 * prompt. *cursor_x and *cursor_y [cell] receive the position of the terminal's cursor; either may
 * be NULL. A long line scrolls sideways, with `<` and `>` at its ends. Returns false if out of
 * memory, with a blank canvas. */
bool screen_draw(const struct session *session, const struct prompt_line *prompt,
                 struct canvas *canvas, int *cursor_x, int *cursor_y);
/* Draws the prompt alone into the last row, and leaves the others unchanged. */
void screen_draw_prompt(const struct session *session, const struct prompt_line *prompt,
                        struct canvas *canvas, int *cursor_x, int *cursor_y);

/* Returns the height [row] of the log pane on a screen of this size [cell], by which a page key
 * scrolls. */
int screen_log_rows(const struct session *session, int width, int height);
/* Returns the number of rows by which the log can be scrolled up; its oldest line is then at the
 * top. */
int screen_log_max(const struct session *session, int width, int height);
/* Returns the time [s] per column of the time plot that has the focus, by which an arrow key moves
 * a cursor; 0 if no time plot has the focus. */
double screen_column_time(const struct session *session, int width, int height);
/* Sets cell [2] to the change of the horizontal and vertical variable [SI] over one cell of the
 * plane that has the focus. Returns false if no plane is shown. */
bool screen_plane_cell(const struct session *session, int width, int height, double cell[2]);
/* Sets span [2] to begin and end [s] of the time axis of the plot that has the focus. Returns false
 * if that plot has none. */
bool screen_time_shown(const struct session *session, int width, int height, double span[2]);

/* Append the screen, drawn with width x height cells, as lines of text, or write it to a new file.
 * Return false with `error` set. */
bool screenshot_text(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, struct buffer *text, struct error *error);
bool screenshot_file(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, const char *path, struct write_policy policy, struct error *error);
/* Sets the callbacks of *front by which commands make screenshots; for front ends without a screen
 * of their own. */
void screenshot_offer(struct front *front);
