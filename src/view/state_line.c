/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the state line: the scene, its parameters, the method, and the progress of the run, in the
 * longest form that fits. */
#define _GNU_SOURCE /* memmem */
#include "view/internal.h"

#include <hooke/method.h>
#include <hooke/run.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/module.h>

#include <string.h>

/* Parts of one form of the line. The forms are ordered from the longest to the shortest. */
struct line_form {
    bool scene, start, parameters, method, step, steps, state;
    bool blanks; /* blanks between numbers and units, bars between the parts */
};

static const struct line_form forms[] = {
    {true, true, true, true, true, true, true, true},
    {true, false, true, true, true, true, true, true},
    {true, false, true, true, true, false, true, true},
    {true, false, false, true, true, false, true, true},
    {true, false, false, true, true, false, true, false},
    {false, false, false, true, true, false, true, false},
    {false, false, false, true, false, false, true, false},
    {false, false, false, false, false, false, true, false},
    {false, false, false, false, false, false, false, false},
};

/* Appends a quantity with three digits, without the blank before its unit unless `blanks` is set.
 */
static void put_quantity(struct buffer *output, double value, enum quantity quantity, bool blanks)
{
    struct buffer text = {0};
    buffer_quantity(&text, value, quantity, 3);
    for (size_t i = 0; i < text.len; i++)
        if (blanks || text.data[i] != ' ')
            buffer_char(output, text.data[i]);
    buffer_free(&text);
}

/* Appends "NAME=VALUE"; rates have no unit, because 1/s is understood. */
static void put_parameter(struct buffer *output, const struct scene *scene, int i, const char *gap)
{
    const struct param_row *param = param_at(scene, i);
    buffer_format(output, "%s%s=", gap, param->row.name);
    if (scene->value[i] == 0 || param->quantity == QUANTITY_RATE) /* the unit 1/s is left out */
        buffer_short(output, scene->value[i], 3);
    else
        buffer_quantity(output, scene->value[i], param->quantity, 3);
}

/* Appends at most `max` parameters that have an effect in the scene and, if `start` is set, its
 * initial values. */
static void put_parameters(struct buffer *output, const struct scene *scene, int max, bool start)
{
    const int count = (int)scene_params(scene)->count, t0 = scene_param(scene, "t0");
    for (int i = 0; i < count && max > 0; i++) {
        if (!param_matters(scene, i) || param_is_start(scene, i))
            continue;
        put_parameter(output, scene, i, "  ");
        max--;
    }
    const char *gap = "  ";
    for (int i = 0; i < count && start; i++) {
        if (i == t0 || !param_is_start(scene, i))
            continue;
        put_parameter(output, scene, i, gap);
        gap = " ";
    }
}

/* Returns the number of decimals of times: 2, or up to 4 if the step dt has more. */
static int time_decimals(double dt)
{
    int decimals = 2;
    for (double unit = 0.01;
         decimals < 4 && dt < 0.5 && fabs(dt / unit - floor(dt / unit + 0.5)) > 1e-6; unit /= 10)
        decimals++;
    return decimals;
}

/* Appends the state of the run (RUNNING with its speed, PAUSED, DIVERGED), its time and steps, or
 * the state of a module that is active, such as a collection. `form` tells which of these fit into
 * the line. "(CPU)" means that the computer cannot keep the chosen speed. */
static void put_progress(struct buffer *output, const struct session *session,
                         const struct line_form *form)
{
    const struct live *live = &session->live;
    const struct run *run = session_run(session);
    bool slow = live->achieved < 0.9 * live->speed && isfinite(live->speed);
    double speed = slow ? live->achieved : live->speed;

    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->prompt.state &&
            module_list[i]->prompt.state(session, form->steps, form->blanks, output))
            return;
    if (form->state && live->state == LIVE_RUNNING) {
        buffer_put(output, TEXT("RUNNING "));
        if (isinf(speed))
            buffer_put(output, TEXT("max"));
        else
            buffer_format(output, speed >= 0.095 ? "%.1fx" : "%.2gx", speed);
        if (slow && form->blanks)
            buffer_put(output, TEXT(" (CPU)"));
        buffer_put(output, form->blanks ? TEXT("  ") : TEXT(" "));
    } else if (form->state && live->state == LIVE_PAUSED) {
        buffer_put(output, TEXT("PAUSED "));
    } else if (form->state &&
               (live->state == LIVE_DIVERGED || (run && run->stop == STOP_DIVERGED))) {
        buffer_put(output, TEXT("DIVERGED "));
    }
    if (!run)
        return;
    buffer_format(output, "t=%.*f%s", time_decimals(run->settings.dt), run->t,
                  form->blanks ? " s" : "");
    if (form->steps)
        buffer_format(output, "  %lld step%s", (long long)run->steps, run->steps == 1 ? "" : "s");
}

/* A method and the settings that it uses. */
struct solving {
    const struct method *method;
    struct run_settings settings;
};

/* Appends the step or the tolerance, such as " dt=10 ms". */
static void put_step(struct buffer *output, const struct solving *solving,
                     const struct line_form *form)
{
    const bool adaptive = solving->settings.tol > 0;
    buffer_put(output, adaptive ? TEXT(" tol=") : TEXT(" dt="));
    if (adaptive)
        buffer_short(output, solving->settings.tol, 2);
    else
        put_quantity(output, solving->settings.dt, QUANTITY_TIME, form->blanks);
}

/* Appends the method of the current run and, if it differs, that of the next run. */
static void put_method(struct buffer *output, const struct session *session,
                       const struct line_form *form)
{
    const struct run *run = session_run(session);
    const struct solving next = {session->setup.method, session_run_settings(session)};
    const struct solving solving = run ? (struct solving){run->method, run->settings} : next;
    const bool other = solving.settings.tol != next.settings.tol ||
                       (solving.settings.tol == 0 && solving.settings.dt != next.settings.dt);
    buffer_put(output, text_of(solving.method->row.name));
    if (form->step)
        put_step(output, &solving, form);
    if (solving.method == next.method && !(form->step && other))
        return;
    buffer_format(output, ", next %s", next.method->row.name);
    if (form->step && other)
        put_step(output, &next, form);
}

/* Appends the state line with the parts that `form` selects: scene, at most `parameters`
 * parameters, method and progress, with bars between them if form->blanks. */
static void put_line_form(struct buffer *output, const struct session *session,
                          const struct line_form *form, int parameters)
{
    const struct setup *setup = &session->setup;
    const struct text bar = form->blanks ? TEXT(" | ") : TEXT(" ");
    struct buffer progress = {0};

    if (form->scene)
        buffer_format(output, "%s%s", form->blanks ? " " : "", setup->scene.preset->row.name);
    if (form->parameters)
        put_parameters(output, &setup->scene, parameters, form->start);
    if (form->method) {
        buffer_put(output, form->scene ? bar : TEXT(""));
        put_method(output, session, form);
    }
    put_progress(&progress, session, form);
    if (progress.len && output->len)
        buffer_put(output, bar);
    buffer_put(output, buffer_text(&progress));
    buffer_free(&progress);
}

/* Draws a word of the line again in its own style; the word is readable without colours, too. */
static void mark_word(const struct screen *screen, int y, struct text line, const char *word,
                      enum style style)
{
    const char *cursor = line.len ? memmem(line.data, line.len, word, strlen(word)) : NULL;
    if (cursor)
        canvas_text(screen->canvas, (int)(cursor - line.data), y, text_of(word), style);
}

/* Replaces runs of blanks by single blanks. */
static void collapse_blanks(struct buffer *text)
{
    size_t n = 0;
    for (size_t i = 0; i < text->len; i++)
        if (i == 0 || text->data[i] != ' ' || text->data[i - 1] != ' ')
            text->data[n++] = text->data[i];
    text->len = n;
}

/* Draws the line of the state into row y of the screen, in the longest of `forms` that fits into
 * its width. A form with parameters and without steps drops the last parameters, down to two,
 * before the next form is tried. Words such as RUNNING are marked. */
void state_line_draw(const struct screen *screen, int y)
{
    struct buffer text = {0};
    int width = screen->canvas->width, parameters = PARAM_MAX;
    for (size_t i = 0; i < COUNT_OF(forms);) {
        buffer_clear(&text);
        modules_label(screen->session, &text);
        buffer_put(&text, text.len ? TEXT(" waits | ") : TEXT(""));
        put_line_form(&text, screen->session, &forms[i], parameters);
        if (text_width(buffer_text(&text)) > width)
            collapse_blanks(&text);
        if (text_width(buffer_text(&text)) <= width)
            break;
        if (forms[i].parameters && !forms[i].steps && parameters > 2) /* drops the last parameter */
            parameters =
                smaller(parameters, (int)scene_params(&screen->session->setup.scene)->count) - 1;
        else
            i++;
    }
    struct text line = buffer_text(&text);
    line_draw(screen, 0, y, screen->canvas->width, line, STYLE_PLAIN);
    mark_word(screen, y, line, "RUNNING", STYLE_BOLD);
    mark_word(screen, y, line, "PAUSED", STYLE_BOLD);
    mark_word(screen, y, line, "DIVERGED", STYLE_ALERT);
    buffer_free(&text);
}
