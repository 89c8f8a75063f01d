/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the screen can be made of: layouts, panes, what cursors snap to. */
#include "internal.h"

#define ROW(name, brief)                                                                                               \
    {                                                                                                                  \
        name, "", brief, "", NULL                                                                                      \
    }

static const struct layout_row layouts[] = {
    [LAYOUT_TRIO] = {ROW("trio", "position above energy, phase beside them"), 60, 0, LAYOUT_SINGLE},
    [LAYOUT_DUO] = {ROW("duo", "position and phase side by side"), 60, 0, LAYOUT_SINGLE},
    [LAYOUT_SINGLE] = {ROW("single", "the focused pane, and the log"), 0, 0, LAYOUT_SINGLE},
    [LAYOUT_STACK] = {ROW("stack", "position, velocity and energy above each other, one time axis"), 0, 0,
                      LAYOUT_STACK},
    [LAYOUT_QUAD] = {ROW("quad", "position, phase, velocity and energy"), 110, 36, LAYOUT_TRIO},
    [LAYOUT_PLOT] = {ROW("plot", "the focused pane alone"), 0, 0, LAYOUT_PLOT},
    [LAYOUT_LOG] = {ROW("log", "the log alone"), 0, 0, LAYOUT_LOG},
};
const struct catalog layout_catalog = CATALOG("layout", layouts);

enum layout layout_drawn(enum layout layout, int width, int height)
{
    while (width < layouts[layout].width || height < layouts[layout].height)
        layout = layouts[layout].smaller;
    return layout;
}

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
    return run ? run->system.order == 2 : figure_recording(session, PLOT_VELOCITY) >= 0;
}

static bool has_phase(const struct session *session)
{
    const struct run *run = session_run(session);
    return run ? plot_fits(PLOT_PHASE, run->system.model) : has_mechanics(session);
}

static bool has_orbit(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && plot_fits(PLOT_ORBIT, run->system.model);
}

static bool has_exact(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && run->plan.exact_known;
}

static bool has_residual(const struct session *session)
{
    return figure_recording(session, PLOT_RESIDUAL) >= 0;
}

static const struct pane_row panes[] = {
    [PANE_POSITION] = {{"position", "m", "y against t, with the recording", "", NULL}, has_series},
    [PANE_ENERGY] = {{"energy", "J", "energy against t", "", NULL}, has_mechanics},
    [PANE_PHASE] = {{"phase", "m", "v against y; of first order the second value against the first", "", NULL},
                    has_phase},
    [PANE_VELOCITY] = {{"velocity", "m/s", "v against t", "", NULL}, has_mechanics},
    [PANE_ERROR] = {{"error", "m", "distance from the exact solution against t", "", NULL}, has_exact},
    [PANE_RESIDUAL] = {{"residual", "m", "the recording minus its fit, or minus the run, against t", "", NULL},
                       has_residual},
    [PANE_SPECTRUM] = {{"spectrum", "m", "amplitude against frequency", "", NULL}, has_series},
    [PANE_ORBIT] = {{"orbit", "m", "the second coordinate against the first", "", NULL}, has_orbit},
};
const struct catalog pane_catalog = CATALOG("pane", panes);
