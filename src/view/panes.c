/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes and draws the panes: the plots on the screen. Each is a figure of the session whose axes
 * stay the same while a curve grows. panes_draw() is the entry. */
#include <hooke/run.h>
#include <hooke/base/unit.h>
#include <hooke/plot.h>
#include "view/internal.h"

#include <stdio.h>

/* [cell] width from which the phase plot shows its note in the upper frame */
#define CAPTION_WIDTH 40
#define LIVE_WINDOW_PARTS 4 /* A live view advances by one of this many parts of its window. */
#define PAGES_COLLECTED 2   /* the same during collection, where every advance redraws noise */

/* ---- requests for figures ---- */

/* Returns the time [s] at which a run with fixed steps will end, or NAN if that is not known. */
static double planned_end(const struct run *run)
{
    const double span =
        run->plan.adaptive ? NAN : (double)run->plan.whole * run->settings.dt + run->plan.partial;
    const double direction = run->t < run->system.t0 ? -1 : 1;
    return span > 0 ? run->system.t0 + direction * span : NAN;
}

/* Lists in placed[] the indices of the runs to draw: the current run, then its overlays with the
 * same model, as other models have other variables. Returns their number, which is 0 while a
 * recording is collected. */
static int list_shown_runs(const struct session *session, int placed[1 + LIMIT_OVERLAY])
{
    const struct run *present = session_run(session);
    int count = 0;
    if (!present || session_grows(session, session_recording(session)))
        return 0;
    placed[count++] = session->runs.current;
    for (int i = 0; i < session->view.overlays; i++) {
        for (int r = 0; r < session->runs.count; r++) {
            const struct run *run = session->runs.slot[r]->run;
            if (run->number == session->view.overlay[i] && run != present &&
                run->system.model == present->system.model) /* other models have other variables */
                placed[count++] = r;
        }
    }
    return count;
}

/* Returns the user's range as a request for an axis, or NULL if it is automatic (or out of memory).
 */
static const struct figure_range *requested_range(struct screen *screen, const double range[2])
{
    struct figure_range *fixed =
        is_range(range) ? arena_array(&screen->arena, 1, sizeof *fixed) : NULL;
    if (fixed)
        *fixed = (struct figure_range){.end = {range[0], range[1]}, .quantity = QUANTITY_OTHER};
    return fixed;
}

/* Returns the request for the figure of a pane, with the session's runs, recording and zoom.
 * `width` [cell] decides how much time is shown and is the same for all panes of a screen; `alone`
 * is true if there is one pane. runs[] receives the indices of the runs, which the request refers
 * to. */
static struct figure_request make_request(struct screen *screen, enum plot_kind pane, int width,
                                          bool alone, int runs[1 + LIMIT_OVERLAY])
{
    const struct session *session = screen->session;
    const struct view *view = &session->view;
    const struct run *run = session_run(session);
    int pages = LIVE_WINDOW_PARTS;
    if (!view->paging)
        pages = larger(width, 1);
    else if (session_grows(session, session_recording(session)))
        pages = PAGES_COLLECTED;
    struct figure_request request = {
        .kind = pane,
        .run = runs,
        .runs = list_shown_runs(session, runs),
        .recording = figure_recording(session, pane),
        .window = {NAN, NAN},
        .width = width,
        .charset = screen->charset,
        .trail = view->trail,
        .follow = true,
        .alone = alone,
        .running = session->live.state == LIVE_RUNNING,
        .stored_band = session->live.state != LIVE_RUNNING,
        .span = view->window,
        .pages = pages,
        .t_end = run && run_in_progress(session) ? planned_end(run) : NAN,
    };
    if (view_has_time_range(view)) {
        request.window[0] = view->x[0];
        request.window[1] = view->x[1];
    }
    if (view_focus(view) == pane) {
        request.y = requested_range(screen, view->y);
        request.x = plot_is_timed(pane) ? NULL : requested_range(screen, view->x);
    }
    return request;
}

/* Fills the figure with axes as the run will need them, before anything has run. */
static void empty_figure(const struct screen *screen, const struct placed_pane *placed,
                         struct figure *figure)
{
    const struct setup *setup = &screen->session->setup;
    const struct variable *first = &setup->scene.model->variable[0];
    struct system system;
    struct error ignored;
    *figure = (struct figure){
        .x = {.label = "t",
              .unit = "s",
              .first_value = 0,
              .last_value = setup->settings.duration,
              .fixed = true},
        .y = {.label = first->name, .unit = quantity_unit(first->quantity), .factor = 1},
        .zero_line = true};
    if (placed->pane == PLOT_POSITION && scene_bind(&setup->scene, &system, &ignored)) {
        const struct unit *unit = unit_display(first->quantity, system.scale[0]);
        if (unit) {
            figure->y.unit = unit->row.name;
            figure->y.factor = unit->factor;
        }
        figure->y.first_value = -system.scale[0];
        figure->y.last_value = system.scale[0];
        figure->y.fixed = true;
    }
}

/* ---- one pane ---- */

/* Returns the title of a pane, after its number if it has one, or the name of its plot if the
 * screen describes plots in words. The text lives as long as the screen's arena. Returns NULL if
 * out of memory. */
static const char *numbered_title(struct screen *screen, const struct placed_pane *placed)
{
    char text[64];
    const char *own = plot_row(placed->pane)->title, *title = own ? own : "";
    if (screen->charset->words)
        return plot_row(placed->pane)->row.name;
    if (!placed->number)
        return title;
    snprintf(text, sizeof text, "%d%s%s", placed->number, *title ? " " : "", title);
    return arena_text(&screen->arena, text_of(text));
}

int pane_drawn_height(const struct placed_pane *placed)
{
    /* these rows are covered by the pane below */
    return placed->area.height + (placed->open ? 3 : 0);
}

/* Time axis that the time plots of a screen share. */
struct shared_time {
    struct figure_window window;
    bool known;
    int width;  /* [cell] of the first pane */
    bool alone; /* there is one pane */
};

/* Chooses the window of time that all time plots of the screen share, for the first of them. */
static struct shared_time share_time(struct screen *screen, const struct placed_pane *placed,
                                     int placed_count)
{
    struct shared_time time = {.width = placed[0].area.width, .alone = placed_count == 1};
    if (screen->charset->words)
        time.width = WORDS_COLUMNS;
    int runs[1 + LIMIT_OVERLAY], first = 0;
    while (first < placed_count - 1 && !plot_is_timed(placed[first].pane))
        first++;
    const struct figure_request request =
        make_request(screen, placed[first].pane, time.width, time.alone, runs);
    time.known = session_window(screen->session, &request, &screen->arena, &time.window);
    if (time.known && !view_has_time_range(&screen->session->view))
        ranges_reach_label(&time.window.axis, placed[first].area.width);
    return time;
}

/* Makes the figure of one pane: the session's, or empty axes with the reason if there is none.
 * Adapts titles, labels and legend to the pane. Returns false if out of memory. */
static bool make_figure(struct screen *screen, const struct placed_pane *placed,
                        const struct shared_time *time, struct figure *figure)
{
    const struct plot_row *row = plot_row(placed->pane);
    int runs[1 + LIMIT_OVERLAY];
    struct figure_request request =
        make_request(screen, placed->pane, time->width, time->alone, runs);
    struct error error = {0};

    request.shared = time->known ? &time->window : NULL;
    if (!row->of_scene && !row->of_study && !request.runs && request.recording < 0) {
        empty_figure(screen, placed, figure);
    } else if (!session_figure(screen->session, &request, &screen->arena, figure, &error)) {
        empty_figure(screen, placed, figure);
        figure->note = arena_text(&screen->arena, text_of(error.text));
    } else {
        if (!ranges_settle(screen, placed, figure))
            return false;
        if (!request.runs && !curves_join_dense(&screen->arena, request.width, figure))
            return false;
    }
    if (time->known && plot_is_timed(placed->pane))
        figure->x = time->window.axis;
    if (row->pane_label) /* an energy has the figure's title, which may be "kinetic" */
        figure->y.label = row->energy ? figure->title : row->pane_label;
    figure->title = numbered_title(screen, placed);
    figure->has_point = figure->has_point && plot_is_plane(placed->pane);
    if (plot_is_plane(placed->pane) && placed->area.width >= CAPTION_WIDTH) {
        figure->caption = figure->note;
        figure->note = NULL;
    }
    /* Lower panes have no legend, because their curves are those of the first. */
    if (screen->charset->words)
        return figure->title != NULL;
    if (plot_is_plane(placed->pane) || (placed->joined && !plot_row(placed[-1].pane)->residual)) {
        struct curve *plain =
            arena_array(&screen->arena, (size_t)figure->curves + 1, sizeof *plain);
        for (int i = 0; plain && i < figure->curves; i++) {
            plain[i] = figure->curve[i];
            plain[i].label = NULL;
        }
        figure->curve = plain;
        figure->curves = plain ? figure->curves : 0;
    }
    if (figure->title && request.runs > 1)
        labels_shorten(screen, placed->area.width, pane_drawn_height(placed), &request, figure);
    return figure->title != NULL;
}

/* Draws a mark on the time axis wherever a parameter was changed during the run. */
static void draw_marks(const struct screen *screen, const struct figure_layout *layout,
                       struct canvas *canvas, struct rectangle area)
{
    const struct live *live = &screen->session->live;
    uint32_t mark = screen->charset->plain ? '^' : 0x25B2;
    int column, row;
    for (int i = 0; i < live->mark_count && layout->x_labels; i++)
        if (figure_cell(layout, live->marks[i], layout->y.first_value, &column, &row))
            canvas_put(canvas, area.x + layout->left + column, area.y + layout->top + layout->rows,
                       mark, STYLE_BOLD);
}

/* Draws the upper corners of a pane as branches of the frame above, which it continues (in ASCII
 * corners and branches are the same sign). */
static void draw_branches(const struct screen *screen, struct rectangle area)
{
    if (screen->charset->plain)
        return;
    canvas_put(screen->canvas, area.x, area.y, 0x251C, STYLE_DIM);
    canvas_put(screen->canvas, area.x + area.width - 1, area.y, 0x2524, STYLE_DIM);
}

/* Copies a pane's visible rows from its own canvas to the screen. */
static void copy_rows(const struct canvas *source, struct canvas *target, struct rectangle area)
{
    for (int y = 0; y < area.height; y++)
        for (int x = 0; x < area.width; x++)
            target->cell[(size_t)(area.y + y) * (size_t)target->width + (size_t)(area.x + x)] =
                source->cell[(size_t)y * (size_t)source->width + (size_t)x];
}

/* Draws a pane in words, for screen readers: only its title while a run is in progress, because it
 * would change all the time. */
static void words_pane(struct screen *screen, const struct placed_pane *placed,
                       const struct figure *figure)
{
    const struct rectangle area = placed->area;
    const int width = area.x + area.width < screen->canvas->width ? area.width - 1 : area.width;
    if (screen->session->live.state == LIVE_RUNNING)
        canvas_text(screen->canvas, area.x, area.y, text_of(figure->title), STYLE_PLAIN);
    else
        figure_draw(figure, screen->canvas, area.x, area.y, width, area.height, screen->charset);
}

/* Draws the figure of a pane on a canvas of its own and copies the rows that are visible to the
 * screen. Time plots get the cursors, whose letters only the first of joined panes shows, and below
 * the last panel the marks of changed parameters. Returns false if out of memory. */
static bool draw_pane(struct screen *screen, const struct placed_pane *placed,
                      const struct figure *figure)
{
    struct rectangle area = {0, 0, placed->area.width, pane_drawn_height(placed)};
    if (screen->charset->words) {
        words_pane(screen, placed, figure);
        return true;
    }
    struct canvas sheet = {
        area.width, area.height,
        arena_array(&screen->arena, (size_t)area.width * (size_t)area.height, sizeof *sheet.cell)};
    struct figure_panel panel[PANELS_MAX];

    if (!sheet.cell || !figure_draw(figure, &sheet, 0, 0, area.width, area.height, screen->charset))
        return false;
    const int panels = figure_panels(figure, area.width, area.height, screen->charset, panel);
    for (int i = 0; i < panels && plot_is_timed(placed->pane); i++) {
        const struct rectangle part = {panel[i].x, panel[i].y, panel[i].width, panel[i].height};
        struct figure_layout layout;
        figure_layout(&panel[i].figure, part.width, part.height, screen->charset, &layout);
        cursors_draw(screen, &layout, &sheet, part, !placed->joined && i == 0);
        if (i == panels - 1)
            draw_marks(screen, &layout, &sheet, part);
    }
    copy_rows(&sheet, screen->canvas, placed->area);
    if (placed->joined)
        draw_branches(screen, placed->area);
    return true;
}

/* Returns the width [cell] of the widest y label of a pane's panels. */
static int widest_gutter(const struct screen *screen, const struct placed_pane *placed,
                         const struct figure *figure)
{
    struct figure_panel panel[PANELS_MAX];
    const int panels = figure_panels(figure, placed->area.width, pane_drawn_height(placed),
                                     screen->charset, panel);
    int gutter = 0;
    for (int i = 0; i < panels; i++) {
        struct figure_layout layout;
        figure_layout(&panel[i].figure, panel[i].width, panel[i].height, screen->charset, &layout);
        gutter = larger(gutter, layout.gutter);
    }
    return gutter;
}

/* Makes the figures figure [placed_count] of all panes. Time plots in one column of panes get
 * labels of the same width (gutter), so that their axes are aligned. Returns false if out of
 * memory. */
bool panes_figures(struct screen *screen, const struct placed_pane *placed, int placed_count,
                   struct figure *figure)
{
    const struct shared_time time = share_time(screen, placed, placed_count);
    for (int i = 0; i < placed_count; i++)
        if (!make_figure(screen, &placed[i], &time, &figure[i]))
            return false;
    for (int i = 0; i < placed_count; i++) {
        int gutter = 0;
        for (int j = 0; j < placed_count && plot_is_timed(placed[i].pane); j++) {
            if (!plot_is_timed(placed[j].pane) || placed[j].area.x != placed[i].area.x)
                continue;
            gutter = larger(gutter, widest_gutter(screen, &placed[j], &figure[j]));
        }
        figure[i].gutter = gutter;
    }
    return true;
}

/* Makes and draws the figures of all panes. Returns false if out of memory. */
bool panes_draw(struct screen *screen, const struct placed_pane *placed, int placed_count)
{
    struct figure figure[PLACED_MAX];
    if (!panes_figures(screen, placed, placed_count, figure))
        return false;
    for (int i = 0; i < placed_count; i++)
        if (!draw_pane(screen, &placed[i], &figure[i]))
            return false;
    return true;
}

/* Computes the size of a cell in units of a pane's axes; cell[0] is horizontal. Returns false if
 * the pane is not shown. */
bool panes_plane_cell(struct screen *screen, const struct placed_pane *placed, int placed_count,
                      enum plot_kind pane, double cell[2])
{
    struct figure figure[PLACED_MAX];
    struct figure_layout layout;
    int found = 0;
    while (found < placed_count && placed[found].pane != pane)
        found++;
    if (found == placed_count || !panes_figures(screen, placed, placed_count, figure))
        return false;
    figure_layout(&figure[found], placed[found].area.width, pane_drawn_height(&placed[found]),
                  screen->charset, &layout);
    cell[0] = (layout.x.last_value - layout.x.first_value) / larger(layout.columns - 1, 1);
    cell[1] = (layout.y.last_value - layout.y.first_value) / larger(layout.rows - 1, 1);
    return true;
}

/* Finds the time axis of the focused time plot, or of the first one. Returns its columns, or 0 if
 * there is no time plot. */
int panes_time_axis(struct screen *screen, const struct placed_pane *placed, int placed_count,
                    double span[2])
{
    struct figure figure[PLACED_MAX];
    struct figure_panel panel[PANELS_MAX];
    struct figure_layout layout;
    int found = -1;
    for (int i = placed_count - 1; i >= 0; i--)
        if (plot_is_timed(placed[i].pane) &&
            (found < 0 || placed[found].pane != view_focus(&screen->session->view)))
            found = i;
    if (found < 0 || !panes_figures(screen, placed, placed_count, figure))
        return 0;
    figure_panels(&figure[found], placed[found].area.width, pane_drawn_height(&placed[found]),
                  screen->charset, panel);
    figure_layout(&panel[0].figure, panel[0].width, panel[0].height, screen->charset, &layout);
    span[0] = layout.x.first_value;
    span[1] = layout.x.last_value;
    return larger(layout.columns, 1);
}
