/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the screen as text, with the same cells that ncurses shows. Without a screen it has the
 * size that was asked for and an empty prompt. */
#include <hooke/base/file.h>
#include <hooke/view.h>

/* Appends the screen as lines of text. Returns false with an error if out of memory. */
bool screenshot_text(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, struct buffer *text, struct error *error)
{
    struct canvas canvas;
    bool ok = canvas_init(&canvas, width, height);
    if (ok) {
        ok = screen_draw(session, prompt, &canvas, NULL, NULL);
        if (ok) {
            canvas_print(&canvas, false, text);
        }
        canvas_free(&canvas);
    }
    return (ok && !text->failed) || error_memory(error);
}

/* Writes the screen as a text file. Returns false with an error. */
bool screenshot_file(const struct session *session, const struct prompt_line *prompt, int width,
                     int height, const char *path, struct write_policy policy, struct error *error)
{
    struct buffer text = {0};
    const bool ok = screenshot_text(session, prompt, width, height, &text, error) &&
                    file_write(path, buffer_text(&text), policy, error);
    buffer_free(&text);
    return ok;
}

/* ---- callbacks for a front end without a screen ---- */

static const struct prompt_line empty_prompt = {.prompt = {"hooke> ", 7}};

/* Sets the size of the front end, or 80x24 if it has none. */
static void choose_size(const struct session *session, int *width, int *height)
{
    *width = session->front.width ? session->front.width : 80;
    *height = session->front.height ? session->front.height : 24;
}

static bool screen_to_text(void *context, const struct session *session, struct buffer *text,
                           struct error *error)
{
    (void)context;
    int width, height;
    choose_size(session, &width, &height);
    return screenshot_text(session, &empty_prompt, width, height, text, error);
}

static bool screen_to_file(void *context, const struct session *session, const char *path,
                           struct write_policy policy, struct error *error)
{
    (void)context;
    int width, height;
    choose_size(session, &width, &height);
    return screenshot_file(session, &empty_prompt, width, height, path, policy, error);
}

static bool time_shown(void *context, const struct session *session, double span[2])
{
    (void)context;
    int width, height;
    choose_size(session, &width, &height);
    return screen_time_shown(session, width, height, span);
}

/* Sets the callbacks of a front end that draw a screen without a terminal. */
void screenshot_offer(struct front *front)
{
    front->time_shown = time_shown;
    front->screenshot = screen_to_file;
    front->screen = screen_to_text;
}
