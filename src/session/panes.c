/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Choices for the screen: layouts of panes, with the smallest screen [cell] for each, and the
 * points that cursors snap to. */
#include <hooke/session/subject.h>

#define ROW(name, brief)                                                                           \
    {                                                                                              \
        name, "", brief, "", NULL                                                                  \
    }

static const struct layout_row layouts[] = {
    [LAYOUT_TRIO] = {ROW("trio", "position above energy, phase beside them"), 60, 0, LAYOUT_SINGLE},
    [LAYOUT_DUO] = {ROW("duo", "position and phase side by side"), 60, 0, LAYOUT_SINGLE},
    [LAYOUT_SINGLE] = {ROW("single", "the focused pane, and the log"), 0, 0, LAYOUT_SINGLE},
    [LAYOUT_STACK] = {ROW("stack", "position, velocity and energy above each other, one time axis"),
                      0, 0, LAYOUT_STACK},
    [LAYOUT_QUAD] = {ROW("quad", "position, phase, velocity and energy"), 110, 36, LAYOUT_TRIO},
    [LAYOUT_PLOT] = {ROW("plot", "the focused pane alone"), 0, 0, LAYOUT_PLOT},
    [LAYOUT_LOG] = {ROW("log", "the log alone"), 0, 0, LAYOUT_LOG},
};
const struct catalog layout_catalog = CATALOG("layout", layouts);

/* Returns the layout, or the largest smaller one that the screen has room for. */
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
    [SNAP_NONE] = ROW("none", "exactly where it was placed"),
};
const struct catalog snap_catalog = CATALOG("snap mode", snaps);
