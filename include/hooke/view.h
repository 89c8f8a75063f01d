/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * view: the screen as a pure function of a const session and a size. ncurses blits its cells,
 * `screenshot` and the tests print them.
 */
#pragma once

#include <hooke/figure.h>
#include <hooke/command.h>

/* The line being edited: what readline holds. Bytes of UTF-8 (or of the locale, made safe when
 * drawn). */
struct prompt_line {
    struct text prompt; /* "hooke> ", or "(reverse-i-search)`x': " */
    struct text line;
    size_t cursor; /* [byte] in line */
    /* hint shown instead of the numbers line ("PgUp log", cursor keys); empty if there is none */
    struct text hint;
};

/*
 * Draws the whole screen into the canvas (its size is the screen's size, from 1x1 up): state line,
 * panes of the layout, log, numbers, prompt. What does not fit is left out in the order numbers
 * line, second pane, log (one row at least), tick labels, frame, until only the prompt is left.
 * cursor_x, cursor_y [cell] receive the position of the terminal's cursor; both may be NULL. A long
 * line scrolls sideways with `<` and `>` marks. Allocates only scratch memory; returns false if
 * there was none and the canvas is blank.
 */
bool screen_draw(const struct session *session, const struct prompt_line *prompt,
                 struct canvas *canvas, int *cursor_x, int *cursor_y);
/* Draws the prompt alone, into the last row, and leaves the others as they are. */
void screen_draw_prompt(const struct session *session, const struct prompt_line *prompt,
                        struct canvas *canvas, int *cursor_x, int *cursor_y);

/* The size of the log pane at this screen size [rows]: how far one page scrolls. */
int screen_log_rows(const struct session *session, int width, int height);
/* [rows] the log can be scrolled up there: its oldest line is then at the top. */
int screen_log_max(const struct session *session, int width, int height);
/* Returns the time [s] that one column of the focused time plot spans, which is the distance
 * that a cursor key moves, or 0 if there is no such plot. */
double screen_column_time(const struct session *session, int width, int height);
/* Computes the extent of a cell in units of the focused plane's axes, horizontal and vertical
 * (SI). Returns false if it is not shown. */
bool screen_plane_cell(const struct session *session, int width, int height, double cell[2]);
/* Finds the range [s] of that plot's time axis. Returns false if there is no such plot. */
bool screen_time_shown(const struct session *session, int width, int height, double span[2]);

/* The screen as text lines, and the same in a file. */
bool screenshot_text(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, struct buffer *text, struct error *error);
bool screenshot_file(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, const char *path, struct write_policy policy, struct error *error);
/* The callbacks of front ends without a screen. */
void screenshot_offer(struct front *front);
