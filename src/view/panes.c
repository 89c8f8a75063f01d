/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Panes: the plots on the screen. Each is a figure of the session with axes that stay where they are while a curve
 * grows. */
#include "internal.h"

#include <stdio.h>

#define CAPTION_WIDTH 40 /* [cell] from here on the phase plot has it in its title */
#define TOUCH 0.01       /* of a range: so much more does not widen it */
#define NEAR 0.06        /* of a time axis: so far it is extended to the next label */
#define PAGES 4          /* a live view moves on by a quarter of its window */

/* How a pane is drawn; its name and when it is offered stand in pane_catalog. */
struct pane_kind {
    enum plot_kind plot;
    const char *title; /* beside the axis label */
    const char *label; /* of the vertical axis instead of the figure's; NULL: that */
    bool from_zero;    /* zero belongs to the range */
};

static const struct pane_kind kinds[] = {
    [PANE_POSITION] = {PLOT_POSITION, "", NULL, false},        [PANE_ENERGY] = {PLOT_ENERGY, "", "energy", true},
    [PANE_PHASE] = {PLOT_PHASE, "phase", NULL, false},         [PANE_VELOCITY] = {PLOT_VELOCITY, "", NULL, false},
    [PANE_ERROR] = {PLOT_ERROR, "", "error", false},           [PANE_RESIDUAL] = {PLOT_RESIDUAL, "", NULL, false},
    [PANE_SPECTRUM] = {PLOT_SPECTRUM, "spectrum", NULL, true}, [PANE_ORBIT] = {PLOT_ORBIT, "orbit", NULL, false},
};

/* ---- what is asked of the session ---- */

static double planned_end(const struct run *run)
{
    double span = run->plan.adaptive ? NAN : (double)run->plan.whole * run->settings.dt + run->plan.partial;
    return span > 0 ? run->system.t0 + span : NAN;
}

static bool in_progress(const struct session *session)
{
    return session->live.state == LIVE_RUNNING || session->live.state == LIVE_PAUSED;
}

static bool is_range(const double range[2])
{
    return range[0] < range[1];
}

/* The horizontal range of a focused time plot holds for all panes, so that they stay aligned. */
static bool has_time_range(const struct view *view)
{
    return is_range(view->x) && pane_is_timed(view->focus);
}

/* The present run, then those laid over it. */
static int shown_runs(const struct session *session, int place[1 + LIMIT_OVERLAY])
{
    const struct run *present = session_run(session);
    int count = 0;
    if (!present)
        return 0;
    place[count++] = session->current_run;
    for (int i = 0; i < session->view.overlays; i++) {
        for (int r = 0; r < session->runs; r++) {
            const struct run *run = session->run[r]->run;
            if (run->number == session->view.overlay[i] && run != present &&
                run->system.model == present->system.model) /* another has other variables */
                place[count++] = r;
        }
    }
    return count;
}

/* `width` [cell] decides how much time is shown: the same for all panes of a screen. */
static struct figure_request make_request(const struct screen *screen, const struct place *place, int width, bool alone,
                                          int runs[1 + LIMIT_OVERLAY])
{
    const struct session *session = screen->session;
    const struct view *view = &session->view;
    const struct run *run = session_run(session);
    enum plot_kind kind = kinds[place->pane].plot;
    struct figure_request request = {
        .kind = kind,
        .run = runs,
        .runs = shown_runs(session, runs),
        .recording = figure_recording(session, kind),
        .window = {NAN, NAN},
        .width = width,
        .charset = screen->charset,
        .trail = view->trail,
        .follow = true,
        .alone = alone,
        .running = session->live.state == LIVE_RUNNING,
        .span = view->window,
        .pages = view->paging ? PAGES : larger(width, 1),
        .until = run && in_progress(session) ? planned_end(run) : NAN,
    };
    if (has_time_range(view)) {
        request.window[0] = view->x[0];
        request.window[1] = view->x[1];
    }
    return request;
}

/* Before anything has run: axes as the run will need them. */
static void empty_figure(const struct screen *screen, const struct place *place, struct figure *figure)
{
    const struct setup *setup = &screen->session->setup;
    const struct variable *first = &setup->scene.model->variable[0];
    struct system system;
    struct error ignored;
    *figure =
        (struct figure){.x = {.label = "t", .unit = "s", .from = 0, .to = setup->settings.duration, .fixed = true},
                        .y = {.label = first->name, .unit = quantity_unit(first->quantity), .factor = 1},
                        .zero_line = true};
    if (place->pane == PANE_POSITION && scene_bind(&setup->scene, &system, &ignored)) {
        const struct unit *unit = unit_display(first->quantity, system.scale[0]);
        if (unit) {
            figure->y.unit = unit->row.name;
            figure->y.factor = unit->factor;
        }
        figure->y.from = -system.scale[0];
        figure->y.to = system.scale[0];
        figure->y.fixed = true;
    }
}

/* ---- ranges that do not move with every sample ---- */

struct extent {
    double low, high; /* low > high: nothing */
};

static void extend(struct extent *extent, double value)
{
    if (isfinite(value)) {
        extent->low = fmin(extent->low, value);
        extent->high = fmax(extent->high, value);
    }
}

static struct extent extent_of(const struct figure *figure, bool vertical)
{
    struct extent extent = {HUGE_VAL, -HUGE_VAL};
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        for (size_t i = 0; i < curve->n && !curve->unbounded; i++)
            if (!vertical || !figure->x.fixed || (curve->x[i] >= figure->x.from && curve->x[i] <= figure->x.to))
                extend(&extent, vertical ? curve->y[i] : curve->x[i]);
    }
    return extent;
}

/*
 * Outward to quarter steps of the labels: the range jumps now and then instead of creeping. About zero an oscillation
 * gets as much room below as above. What varies by rounding only is left as it is.
 */
static void settle(struct axis *axis, struct extent extent, int rows)
{
    if (extent.low < 0 && extent.high > 0 && fmin(-extent.low, extent.high) > 0.5 * fmax(-extent.low, extent.high)) {
        extent.high = fmax(-extent.low, extent.high);
        extent.low = -extent.high;
    }
    double size = fmax(fabs(extent.low), fabs(extent.high)), factor = axis->factor > 0 ? axis->factor : 1;
    if (axis->log || axis->fixed || !(extent.high - extent.low > 1e-6 * size))
        return;
    struct ticks ticks = ticks_linear(extent.low / factor, extent.high / factor, 2 + rows / 4, larger(rows / 2, 3));
    double step = ticks.count > 1 ? ticks.step * factor / 4 : 0, touch = TOUCH * (extent.high - extent.low);
    if (!(step > 0))
        return;
    axis->fixed = true;
    axis->from = floor((extent.low + touch) / step) * step;
    axis->to = ceil((extent.high - touch) / step) * step;
}

/* A time axis that nearly reaches the next label is extended to it. */
static void reach_label(struct axis *axis, int columns)
{
    double span = axis->to - axis->from, factor = axis->factor > 0 ? axis->factor : 1;
    struct ticks ticks = ticks_linear(axis->from / factor, axis->to / factor, 2 + columns / 12, larger(columns / 4, 2));
    double next = (ticks.first + ticks.count * ticks.step) * factor;
    if (ticks.count > 1 && next > axis->to && next - axis->to < NEAR * span)
        axis->to = next;
}

/* While a run goes on the range holds the amplitude the scene is expected to have, from the first frame on. */
static void extend_expected(const struct session *session, const struct figure *figure, enum pane pane, bool vertical,
                            struct extent *extent)
{
    const struct run *run = session_run(session);
    if (!run || !in_progress(session) || pane == PANE_ERROR || pane == PANE_RESIDUAL || pane == PANE_SPECTRUM)
        return;
    const struct system *system = &run->system;
    if (pane == PANE_ENERGY) {
        if (system->order == 2)
            extend(extent, system_kinetic(system, system->start) + system_potential(system, system->start));
        return;
    }
    if (system->model->typed && system->oscillator.whole && !(system->oscillator.stiffness > 0))
        return; /* it falls: an event may catch it */
    bool speed = pane == PANE_VELOCITY || (pane == PANE_PHASE && vertical && !figure->equal);
    double size = system->scale[speed ? system->n / 2 : 0];
    extend(extent, size);
    extend(extent, system->order == 2 ? -size : 0);
}

static void fix_axis(struct axis *axis, const double range[2])
{
    if (!is_range(range))
        return;
    axis->fixed = true;
    axis->from = range[0];
    axis->to = range[1];
}

static void settle_ranges(const struct screen *screen, const struct place *place, struct figure *figure)
{
    const struct view *view = &screen->session->view;
    struct extent extent = extent_of(figure, true);
    if (kinds[place->pane].from_zero && extent.low <= extent.high)
        extend(&extent, 0);
    extend_expected(screen->session, figure, place->pane, true, &extent);
    if (view->focus == place->pane) {
        fix_axis(&figure->y, view->y);
        if (!pane_is_timed(place->pane))
            fix_axis(&figure->x, view->x);
    }
    settle(&figure->y, extent, place->at.height);
    if (figure->x.fixed && pane_is_timed(place->pane) && !has_time_range(view))
        reach_label(&figure->x, place->at.width);
    if (!pane_is_plane(place->pane))
        return;
    struct extent across = extent_of(figure, false);
    extend_expected(screen->session, figure, place->pane, false, &across);
    settle(&figure->x, across, place->at.height);
    if (figure->equal && (!figure->x.fixed || !figure->y.fixed)) { /* at rest */
        double room = 0.1 * fmax(fabs(across.low), fabs(across.high));
        figure->x.fixed = figure->y.fixed = room > 0 && isfinite(room);
        figure->x.from = across.low - room;
        figure->x.to = across.high + room;
        figure->y.from = extent.low - room;
        figure->y.to = extent.high + room;
    }
}

/* A recording alone that is too dense for marks is drawn as a line. */
static void join_dense(struct screen *screen, const struct figure_request *request, struct figure *figure)
{
    if (request->runs || figure->curves != 1 || figure->curve[0].n < 2 * (size_t)request->width)
        return;
    struct curve *curve = arena_array(&screen->arena, 1, sizeof *curve);
    if (curve) {
        *curve = figure->curve[0];
        curve->points = false;
        figure->curve = curve;
    }
}

/* ---- one pane ---- */

static const char *numbered_title(struct screen *screen, const struct place *place)
{
    char text[64];
    const char *title = kinds[place->pane].title;
    if (!place->number)
        return title;
    snprintf(text, sizeof text, "%d%s%s", place->number, *title ? " " : "", title);
    return arena_text(&screen->arena, text_of(text));
}

static int drawn_height(const struct place *place)
{
    return place->at.height + (place->open ? 3 : 0); /* axis, labels and lower frame will not be seen */
}

static bool make_figure(struct screen *screen, const struct place *place, int width, bool alone, struct figure *figure)
{
    const struct pane_kind *kind = &kinds[place->pane];
    int runs[1 + LIMIT_OVERLAY];
    struct figure_request request = make_request(screen, place, width, alone, runs);
    struct error error = {0};

    if (!request.runs && request.recording < 0) {
        empty_figure(screen, place, figure);
    } else if (!session_figure(screen->session, &request, &screen->arena, figure, &error)) {
        empty_figure(screen, place, figure);
        figure->note = arena_text(&screen->arena, text_of(error.text));
    } else {
        settle_ranges(screen, place, figure);
        join_dense(screen, &request, figure);
    }
    figure->title = numbered_title(screen, place);
    if (kind->label)
        figure->y.label = kind->label;
    figure->has_point = figure->has_point && pane_is_plane(place->pane);
    if (pane_is_plane(place->pane) && place->at.width >= CAPTION_WIDTH) {
        figure->caption = figure->note;
        figure->note = NULL;
    }
    /* The curves are those of the first pane, unless that has none of a run. */
    if (pane_is_plane(place->pane) || (place->joined && place[-1].pane != PANE_RESIDUAL)) {
        struct curve *plain = arena_array(&screen->arena, (size_t)figure->curves + 1, sizeof *plain);
        for (int i = 0; plain && i < figure->curves; i++) {
            plain[i] = figure->curve[i];
            plain[i].label = NULL;
        }
        figure->curve = plain;
        figure->curves = plain ? figure->curves : 0;
    }
    if (figure->title && request.runs > 1)
        labels_shorten(screen, place->at.width, drawn_height(place), &request, figure);
    return figure->title != NULL;
}

/* A parameter was changed here while the run went on. */
static void draw_marks(const struct screen *screen, const struct figure_layout *layout, struct canvas *canvas,
                       struct rectangle at)
{
    const struct live *live = &screen->session->live;
    uint32_t mark = screen->charset == CHARSET_ASCII ? '^' : 0x25B2;
    int column, row;
    for (int i = 0; i < live->mark_count && layout->x_labels; i++)
        if (figure_cell(layout, live->marks[i], layout->y.from, &column, &row))
            canvas_put(canvas, at.x + layout->left + column, at.y + layout->top + layout->rows, mark, STYLE_BOLD);
}

/* Corners become branches where a pane continues the frame above. */
static void draw_branches(const struct screen *screen, struct rectangle at)
{
    if (screen->charset == CHARSET_ASCII)
        return;
    canvas_put(screen->canvas, at.x, at.y, 0x251C, STYLE_DIM);
    canvas_put(screen->canvas, at.x + at.width - 1, at.y, 0x2524, STYLE_DIM);
}

static void copy_rows(const struct canvas *from, struct canvas *to, struct rectangle at)
{
    for (int y = 0; y < at.height; y++)
        for (int x = 0; x < at.width; x++)
            to->cell[(size_t)(at.y + y) * (size_t)to->width + (size_t)(at.x + x)] =
                from->cell[(size_t)y * (size_t)from->width + (size_t)x];
}

static bool draw_pane(struct screen *screen, const struct place *place, const struct figure *figure)
{
    struct rectangle at = {0, 0, place->at.width, drawn_height(place)};
    struct canvas sheet = {at.width, at.height,
                           arena_array(&screen->arena, (size_t)at.width * (size_t)at.height, sizeof *sheet.cell)};
    struct figure_layout layout;

    if (!sheet.cell || !figure_draw(figure, &sheet, 0, 0, at.width, at.height, screen->charset))
        return false;
    figure_layout(figure, at.width, at.height, screen->charset, &layout);
    if (pane_is_timed(place->pane)) {
        cursors_draw(screen, &layout, &sheet, at, !place->joined);
        draw_marks(screen, &layout, &sheet, at);
    }
    copy_rows(&sheet, screen->canvas, place->at);
    if (place->joined)
        draw_branches(screen, place->at);
    return true;
}

/* All time plots over each other get labels of the same width, so that their axes are aligned. */
static bool make_figures(struct screen *screen, const struct place *place, int places, struct figure *figure)
{
    struct figure_layout layout;
    for (int i = 0; i < places; i++)
        if (!make_figure(screen, &place[i], place[0].at.width, places == 1, &figure[i]))
            return false;
    for (int i = 0; i < places; i++) {
        int gutter = 0;
        for (int j = 0; j < places && pane_is_timed(place[i].pane); j++) {
            if (!pane_is_timed(place[j].pane) || place[j].at.x != place[i].at.x)
                continue;
            figure_layout(&figure[j], place[j].at.width, drawn_height(&place[j]), screen->charset, &layout);
            gutter = larger(gutter, layout.gutter);
        }
        figure[i].gutter = gutter;
    }
    return true;
}

bool panes_draw(struct screen *screen, const struct place *place, int places)
{
    struct figure figure[PLACES_MOST];
    if (!make_figures(screen, place, places, figure))
        return false;
    for (int i = 0; i < places; i++)
        if (!draw_pane(screen, &place[i], &figure[i]))
            return false;
    return true;
}

int panes_time_axis(struct screen *screen, const struct place *place, int places, double span[2])
{
    struct figure figure[PLACES_MOST];
    struct figure_layout layout;
    int found = -1;
    for (int i = places - 1; i >= 0; i--)
        if (pane_is_timed(place[i].pane) && (found < 0 || place[found].pane != screen->session->view.focus))
            found = i;
    if (found < 0 || !make_figures(screen, place, places, figure))
        return 0;
    figure_layout(&figure[found], place[found].at.width, drawn_height(&place[found]), screen->charset, &layout);
    span[0] = layout.x.from;
    span[1] = layout.x.to;
    return larger(layout.columns, 1);
}
