/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the screen can be made of: layouts, panes, what cursors snap to. */
#include "internal.h"

#include <math.h>

#define ROW(name, brief)                                                                                               \
    {                                                                                                                  \
        name, "", brief, "", NULL                                                                                      \
    }

static const struct row layouts[] = {
    [LAYOUT_TRIO] = ROW("trio", "position above energy, phase beside them"),
    [LAYOUT_DUO] = ROW("duo", "position and phase side by side"),
    [LAYOUT_SINGLE] = ROW("single", "the focused pane, and the log"),
    [LAYOUT_STACK] = ROW("stack", "position, velocity and energy above each other, one time axis"),
    [LAYOUT_QUAD] = ROW("quad", "position, phase, velocity and energy"),
    [LAYOUT_PLOT] = ROW("plot", "the focused pane alone"),
    [LAYOUT_LOG] = ROW("log", "the log alone"),
};
const struct catalog layout_catalog = CATALOG("layout", layouts);

static const struct row snaps[] = {
    [SNAP_CROSSING] = ROW("crossing", "up-crossings of the equilibrium, placed by a line fit"),
    [SNAP_PEAK] = ROW("peak", "maxima, placed by a parabola"),
    [SNAP_SAMPLE] = ROW("sample", "the nearest sample"),
    [SNAP_NONE] = ROW("none", "where it was put"),
};
const struct catalog snap_catalog = CATALOG("way to snap", snaps);

static bool has_series(const struct session *session)
{
    return session_run(session) || session_recording(session);
}

static bool has_mechanics(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && run->system.order == 2;
}

static bool has_exact(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && run->plan.exact_known;
}

static bool has_overlap(const struct session *session)
{
    const struct run *run = session_run(session);
    const struct recording *recording = session_recording(session);
    if (!run || !recording || recording->column[recording->value].quantity != QUANTITY_LENGTH)
        return false;
    const double a = trace_time(run->trace, 0), b = trace_time(run->trace, trace_count(run->trace) - 1);
    return fmin(a, b) < recording->window[1] && fmax(a, b) > recording->window[0];
}

static const struct pane_row panes[] = {
    [PANE_POSITION] = {{"position", "m", "y against t, with the recording", "", NULL}, has_series},
    [PANE_ENERGY] = {{"energy", "J", "energy against t", "", NULL}, has_mechanics},
    [PANE_PHASE] = {{"phase", "m", "v against y", "", NULL}, has_mechanics},
    [PANE_VELOCITY] = {{"velocity", "m/s", "v against t", "", NULL}, has_mechanics},
    [PANE_ERROR] = {{"error", "m", "distance from the exact solution against t", "", NULL}, has_exact},
    [PANE_RESIDUAL] = {{"residual", "m", "recording minus run against t", "", NULL}, has_overlap},
    [PANE_SPECTRUM] = {{"spectrum", "m", "amplitude against frequency", "", NULL}, has_series},
};
const struct catalog pane_catalog = CATALOG("pane", panes);
