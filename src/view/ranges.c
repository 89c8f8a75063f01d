/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ranges of the panes' axes that stay the same while a curve grows: ends are rounded to quarter
 * steps of the labels and include the values that are expected. */
#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/base/numeric.h>
#include <hooke/figure/layout.h>
#include <hooke/plot.h>
#include "view/internal.h"

/* A range is not widened for values that exceed it by less than this fraction. */
#define RANGE_TOLERANCE 0.01
/* A time axis is extended to the next label if that is within this fraction of its length. */
#define LABEL_REACH 0.06

bool run_in_progress(const struct session *session)
{
    return session->live.state == LIVE_RUNNING || session->live.state == LIVE_PAUSED;
}

bool is_range(const double range[2])
{
    return range[0] < range[1];
}

bool view_has_time_range(const struct view *view)
{
    return is_range(view->x) && plot_is_timed(view_focus(view));
}

/* Extends an extent to include a finite value. */
static void extent_include(struct extent *extent, double value)
{
    if (isfinite(value)) {
        extent->low = fmin(extent->low, value);
        extent->high = fmax(extent->high, value);
    }
}

/* Fixes the range of an automatic axis to the extent, rounded outwards to quarter steps of its
 * labels, so that it changes rarely and not in every frame. An oscillation about zero gets the same
 * room on both sides. An extent due to rounding errors leaves the axis automatic. `rows` is the
 * height of the pane. */
static void axis_settle(struct axis *axis, struct extent extent, int rows)
{
    if (extent.low < 0 && extent.high > 0 &&
        fmin(-extent.low, extent.high) > 0.5 * fmax(-extent.low, extent.high)) {
        extent.high = fmax(-extent.low, extent.high);
        extent.low = -extent.high;
    }
    double size = fmax(fabs(extent.low), fabs(extent.high)),
           factor = axis->factor > 0 ? axis->factor : 1;
    if (axis->log || axis->fixed || !(extent.high - extent.low > 1e-6 * size))
        return;
    struct ticks ticks =
        ticks_linear(extent.low / factor, extent.high / factor, 2 + rows / 4, larger(rows / 2, 3));
    double step = ticks.count > 1 ? ticks.step * factor / 4 : 0,
           touch = RANGE_TOLERANCE * (extent.high - extent.low);
    if (!(step > 0))
        return;
    axis->fixed = true;
    axis->first_value = floor((extent.low + touch) / step) * step;
    axis->last_value = ceil((extent.high - touch) / step) * step;
}

/* Extends a time axis of `columns` cells to the next label if that is within LABEL_REACH of its
 * length. */
void ranges_reach_label(struct axis *axis, int columns)
{
    double span = axis->last_value - axis->first_value,
           factor = axis->factor > 0 ? axis->factor : 1;
    struct ticks ticks = ticks_linear(axis->first_value / factor, axis->last_value / factor,
                                      2 + columns / 12, larger(columns / 4, 2));
    double next = (ticks.first + ticks.count * ticks.step) * factor;
    if (ticks.count > 1 && next > axis->last_value && next - axis->last_value < LABEL_REACH * span)
        axis->last_value = next;
}

/* Extends an extent to the amplitude of the recording that is being collected, as far as it is
 * known. */
static void extend_collected(const struct session *session, const struct figure *figure,
                             enum plot_kind pane, bool vertical, struct extent *extent)
{
    const struct growing *now = session->growing;
    const struct plot_row *row = plot_row(pane);
    if (row->energy || !plot_shows_state(pane) || !isfinite(now->swing))
        return;
    const bool rate =
        row->vertical == VERTICAL_RATE && (row->horizontal == ACROSS_TIME || vertical);
    const double size = now->swing * (rate && !figure->equal ? TWO_PI / now->steady : 1);
    const double middle =
        rate || row->horizontal != ACROSS_TIME ? 0 : now->middle - session_recording(session)->zero;
    extent_include(extent, middle - size);
    extent_include(extent, middle + size);
}

/* Extends the extent of an axis of the pane, while a run is in progress, to the amplitude or energy
 * that the scene is expected to have, so that the first frame already shows the final range. While
 * a recording is collected, extend_collected() does that. */
static void extend_expected(const struct session *session, const struct figure *figure,
                            enum plot_kind pane, bool vertical, struct extent *extent)
{
    const struct run *run = session_run(session);
    const struct plot_row *row = plot_row(pane);
    if (session_grows(session, session_recording(session))) {
        extend_collected(session, figure, pane, vertical, extent);
        return;
    }
    if (!run || !run_in_progress(session) || !(row->energy || plot_shows_state(pane)))
        return;
    const struct system *system = &run->system;
    if (row->energy) {
        if (system->order == 2)
            extent_include(extent, system_kinetic(system, system->start) +
                                       system_potential(system, system->start));
        return;
    }
    if (system->model->typed && system->oscillator.whole && !(system->oscillator.stiffness > 0))
        return; /* no restoring force: the position has no expected range */
    bool speed = row->vertical == VERTICAL_RATE &&
                 (row->horizontal == ACROSS_TIME || (vertical && !figure->equal));
    double size = system->scale[speed ? system->n / 2 : 0];
    extent_include(extent, size);
    extent_include(extent, system->order == 2 ? -size : 0);
}

/* Fixes a logarithmic axis to whole decades around the extent. */
static void settle_decades(struct axis *axis, struct extent extent)
{
    const double factor = axis->factor > 0 ? axis->factor : 1;
    const double low = log10(fmax(extent.low, axis->min) / factor),
                 high = log10(extent.high / factor);
    if (axis->fixed || !isfinite(low) || !isfinite(high) || fabs(low) > 290 || fabs(high) > 290)
        return;
    axis->fixed = true;
    axis->first_value = pow(10, floor(low + RANGE_TOLERANCE)) * factor;
    axis->last_value =
        pow(10, fmax(ceil(high - RANGE_TOLERANCE), floor(low + RANGE_TOLERANCE) + 1)) * factor;
}

/* Chooses the axes of one panel of a figure; expected values count for the panel of the first
 * curve, which is the run in progress. */
static void settle_panel(const struct screen *screen, const struct placed_pane *placed,
                         const struct figure *figure, int panel, struct axis *x, struct axis *y)
{
    const struct session *session = screen->session;
    const bool first = figure->curves == 0 || figure->curve[0].panel == panel;
    const double window[2] = {figure->x.first_value, figure->x.last_value};
    struct extent_window shown = {.panel = panel + 1};
    struct extent x_extent = curves_extent(figure->curve, figure->curves, &shown);
    shown.vertical = true;
    shown.other_range = figure->x.fixed ? window : NULL;
    struct extent extent = curves_extent(figure->curve, figure->curves, &shown);
    if (y->log) {
        settle_decades(y, extent);
        return;
    }
    if (plot_row(placed->pane)->from_zero && extent.low <= extent.high)
        extent_include(&extent, 0);
    if (first)
        extend_expected(session, figure, placed->pane, true, &extent);
    axis_settle(y, extent, placed->area.height);
    if (!plot_is_plane(placed->pane))
        return;
    if (first)
        extend_expected(session, figure, placed->pane, false, &x_extent);
    axis_settle(x, x_extent, placed->area.height);
    if (figure->equal && (!x->fixed || !y->fixed)) { /* a body at rest has no range */
        double margin = 0.1 * fmax(fabs(x_extent.low), fabs(x_extent.high));
        x->fixed = y->fixed = margin > 0 && isfinite(margin);
        x->first_value = x_extent.low - margin;
        x->last_value = x_extent.high + margin;
        y->first_value = extent.low - margin;
        y->last_value = extent.high + margin;
    }
}

/* Chooses the ranges of both axes, and of the second panel, that stay the same while curves grow.
 * Returns false if out of memory. */
bool ranges_settle(struct screen *screen, const struct placed_pane *placed, struct figure *figure)
{
    settle_panel(screen, placed, figure, 0, &figure->x, &figure->y);
    if (!figure->second)
        return true;
    struct axis *second = arena_array(&screen->arena, 2, sizeof *second);
    if (!second)
        return false;
    second[0] = figure->plane ? figure->second[0] : figure->x;
    second[1] = figure->second[1];
    settle_panel(screen, placed, figure, 1, &second[0], &second[1]);
    figure->second = second;
    return true;
}
