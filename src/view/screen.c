/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the screen from top to bottom: state line, panes, log (or table of the cursors), numbers,
 * prompt; and answers questions about its layout. */
#include "view/internal.h"

/* Draws everything but the prompt. Sets *ok to false if out of memory. */
static void draw_above_prompt(struct screen *screen, const struct prompt_line *prompt, bool *ok)
{
    const struct session *session = screen->session;
    const struct cursors *cursors = &session->view.cursors;
    int width = screen->canvas->width, y = 0;
    struct division division = screen_division(session, screen->canvas->height);

    if (division.state)
        state_line_draw(screen, y++);
    if (division.plots) {
        struct placed_pane placed[PLACED_MAX];
        int placed_count = screen_panes(session, (struct rectangle){0, y, width, division.plots},
                                        screen->canvas->height, placed);
        *ok = panes_draw(screen, placed, placed_count);
        y += division.plots;
    }
    struct rectangle log = {0, y, width, division.log};
    if (cursors->shown && division.plots && session->view.scroll == 0)
        cursors_table(screen, log);
    else
        log_draw(screen, log);
    y += division.log;
    if (division.numbers)
        numbers_draw(screen, prompt->hint, y);
}

/* Draws the whole screen into the canvas, blank above the prompt if out of memory, and returns
 * false then. Sets the position of the cursor; the pointers may be NULL. */
bool screen_draw(const struct session *session, const struct prompt_line *prompt,
                 struct canvas *canvas, int *cursor_x, int *cursor_y)
{
    struct screen screen = {
        .session = session, .canvas = canvas, .charset = session_charset(session)};
    bool ok = true;
    int x = 0;

    for (int i = 0; i < canvas->width * canvas->height; i++)
        canvas->cell[i] = (struct cell){' ', STYLE_PLAIN};
    draw_above_prompt(&screen, prompt, &ok);
    for (int i = 0; !ok && i < canvas->width * canvas->height; i++)
        canvas->cell[i] = (struct cell){' ', STYLE_PLAIN};
    if (ok)
        prompt_draw(&screen, prompt, canvas->height - 1, &x);
    if (cursor_x)
        *cursor_x = x;
    if (cursor_y)
        *cursor_y = canvas->height - 1;
    arena_reset(&screen.arena);
    return ok;
}

/* Draws only the last row, with the prompt. */
void screen_draw_prompt(const struct session *session, const struct prompt_line *prompt,
                        struct canvas *canvas, int *cursor_x, int *cursor_y)
{
    struct screen screen = {
        .session = session, .canvas = canvas, .charset = session_charset(session)};
    const int y = canvas->height - 1;
    for (int x = 0; x < canvas->width; x++)
        canvas->cell[y * canvas->width + x] = (struct cell){' ', STYLE_PLAIN};
    prompt_draw(&screen, prompt, y, cursor_x);
    *cursor_y = y;
    arena_reset(&screen.arena);
}

/* Returns the number of rows of the log on a screen of this size. */
int screen_log_rows(const struct session *session, int width, int height)
{
    (void)width;
    return screen_division(session, height).log;
}

/* Returns by how many rows the log can be scrolled back. */
int screen_log_max(const struct session *session, int width, int height)
{
    const int rows = log_rows_newest(&session->log, session->log.count, width);
    /* The table of the cursors gives way once the log is scrolled. */
    return larger(rows - screen_log_rows(session, width, height), session->view.cursors.shown);
}

/* Places the panes as screen_draw() does. Returns their number. */
static int place_panes(const struct session *session, int width, int height,
                       struct placed_pane placed[PLACED_MAX])
{
    const struct division division = screen_division(session, height);
    const struct rectangle area = {0, division.state, width, division.plots};
    return division.plots ? screen_panes(session, area, height, placed) : 0;
}

/* Computes the size of a cell in units of the axes of the focused pane. Returns false if it is not
 * shown. */
bool screen_plane_cell(const struct session *session, int width, int height, double cell[2])
{
    struct screen screen = {.session = session, .charset = session_charset(session)};
    struct placed_pane placed[PLACED_MAX];
    const int placed_count = place_panes(session, width, height, placed);
    const bool fine =
        panes_plane_cell(&screen, placed, placed_count, view_focus(&session->view), cell);
    arena_reset(&screen.arena);
    return fine;
}

/* Finds the time axis of the screen. Returns its columns, or 0 if there is none. */
static int time_axis(const struct session *session, int width, int height, double span[2])
{
    struct screen screen = {.session = session, .charset = session_charset(session)};
    struct placed_pane placed[PLACED_MAX];
    const int placed_count = place_panes(session, width, height, placed);
    int columns = panes_time_axis(&screen, placed, placed_count, span);
    arena_reset(&screen.arena);
    return columns;
}

double screen_column_time(const struct session *session, int width, int height)
{
    double span[2] = {0, 0};
    int columns = time_axis(session, width, height, span);
    return (span[1] - span[0]) / larger(columns - 1, 1);
}

bool screen_time_shown(const struct session *session, int width, int height, double span[2])
{
    return time_axis(session, width, height, span) > 0;
}
