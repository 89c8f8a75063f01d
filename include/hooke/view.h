/* SPDX-License-Identifier: GPL-3.0-or-later */
/* view: the screen as a function of a session and a size. ncurses shows its cells; `screenshot` and
 * tests print them. Nothing here changes the session. */
#pragma once

#include <hooke/figure.h>
#include <hooke/command.h>

/* The line being edited, as readline holds it: UTF-8, or bytes of the locale, which are made safe
 * when drawn. */
struct prompt_line {
    struct text prompt; /* The prompt: "hooke> ", or "(reverse-i-search)`x': ". */
    /* The text after it. */
    struct text line;
    size_t cursor; /* Position [byte] of the cursor in `line`. */
    /* Hint that replaces the line of numbers ("PgUp log", cursor keys); empty if there is none. */
    struct text hint;
};

/* Draws the whole screen into the canvas, whose size, from 1x1 up, is that of the screen: state
 * line, panes of the layout, log, numbers, prompt. What does not fit is left out in the order
 * numbers line, second pane, log (all but one row), tick labels, frame, until only the prompt is
 * left. cursor_x and cursor_y [cell] receive the position of the terminal's cursor; both may be
 * NULL. A long line scrolls sideways, with `<` and `>` at its ends. Returns false if out of memory,
 * with a blank canvas. */
bool screen_draw(const struct session *session, const struct prompt_line *prompt,
                 struct canvas *canvas, int *cursor_x, int *cursor_y);
/* Draws the prompt alone into the last row, and leaves the others unchanged. */
void screen_draw_prompt(const struct session *session, const struct prompt_line *prompt,
                        struct canvas *canvas, int *cursor_x, int *cursor_y);

/* Returns the height of the log pane [row] on a screen of this size [cell]: one page of scrolling.
 */
int screen_log_rows(const struct session *session, int width, int height);
/* Returns the number of rows by which the log can be scrolled up; its oldest line is then at the
 * top. */
int screen_log_max(const struct session *session, int width, int height);
/* Returns the time [s] per column of the focused time plot, by which a key moves a cursor, or 0 if
 * there is no such plot. */
double screen_column_time(const struct session *session, int width, int height);
/* Sets cell to the width and height of a cell [SI] on the axes of the focused plane. Returns false
 * if none is shown. */
bool screen_plane_cell(const struct session *session, int width, int height, double cell[2]);
/* Sets span to the range [s] of the time axis of the focused plot. Returns false if there is none.
 */
bool screen_time_shown(const struct session *session, int width, int height, double span[2]);

/* Append the screen as lines of text, or write it to a file. Return false with `error` set. */
bool screenshot_text(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, struct buffer *text, struct error *error);
bool screenshot_file(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, const char *path, struct write_policy policy, struct error *error);
/* Sets the callbacks for screenshots of a front end without a screen. */
void screenshot_offer(struct front *front);
