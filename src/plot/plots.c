/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The catalog of plots, which are also the panes of the screen. A row holds everything that is
 * known of its plot; the functions below answer questions about a row. */
#include <hooke/run.h>
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>
#include <hooke/session/names.h>

/* ---- requirements of plots ---- */

static bool has_velocities(const struct model *model)
{
    return model->order == 2;
}

/* Returns true if there are two variables to plot against each other. */
static bool has_two(const struct model *model)
{
    return model->n > 1;
}

/* Returns true if the model moves in a plane: two coordinates of the same quantity. */
static bool has_plane(const struct model *model)
{
    return model->order == 2 && model->n == 4 && plot_coordinates(model) == 2;
}

/* Returns true if the current run has an exact solution to compare with. */
static bool exact_known(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && run->plan.exact_known;
}

/* ---- the rows ---- */

#define ROW(name, brief)                                                                           \
    {                                                                                              \
        name, "", brief, "", NULL                                                                  \
    }
#define MOTION_NEEDED "this needs positions and velocities"

/* Plots of modules: their functions here, their rows behind the others. */
#define PLOT_FUNCTIONS
#include "lists/plots.def"
#undef PLOT_FUNCTIONS
static const struct plot_row rows[] = {
    [PLOT_POSITION] = {.row = ROW("position", "y against t, or all coordinates"),
                       .label = "y",
                       .coordinates = true,
                       .recorded = RECORDED_POSITION,
                       .any_recording = true,
                       .in_layouts = true,
                       .periods = true},
    [PLOT_ENERGY] = {.row = ROW("energy", "energy against t"),
                     .observable = "energy",
                     .label = "E",
                     .pane_label = "energy",
                     .energy = true,
                     .of_motion = true,
                     .fits = has_velocities,
                     .needs = MOTION_NEEDED,
                     .in_layouts = true,
                     .positive = true,
                     .from_zero = true,
                     .flat = true},
    [PLOT_PHASE] = {.row = ROW("phase",
                               "v against y, for the last two periods unless a window is given; "
                               "for scenes of first order the second value against the first"),
                    .horizontal = ACROSS_STATE,
                    .vertical = VERTICAL_RATE,
                    .title = "phase",
                    .scaled = true,
                    .of_motion = true,
                    .data_curve = drawing_phase_data,
                    .fits = has_two,
                    .needs = MOTION_NEEDED,
                    .in_layouts = true},
    [PLOT_VELOCITY] = {.row = ROW("velocity", "v against t"),
                       .vertical = VERTICAL_RATE,
                       .coordinates = true,
                       .recorded = RECORDED_VELOCITY,
                       .of_motion = true,
                       .fits = has_velocities,
                       .needs = MOTION_NEEDED,
                       .in_layouts = true,
                       .periods = true},
    [PLOT_ERROR] = {.row = ROW("error", "distance from the exact solution against t"),
                    .observable = "error",
                    .label = "error",
                    .log_label = "|error|",
                    .pane_label = "error",
                    .offered = exact_known,
                    .positive = true},
    [PLOT_ORBIT] = {.row =
                        ROW("orbit",
                            "the second coordinate against the first, over the same time as phase"),
                    .horizontal = ACROSS_STATE,
                    .vertical = VERTICAL_SECOND,
                    .title = "orbit",
                    .equal = true,
                    .fits = has_plane,
                    .needs = "this needs two coordinates",
                    .in_layouts = true},
    [PLOT_ACCELERATION] = {.row = ROW("acceleration", "a against t"),
                           .observable = "a",
                           .label = "a",
                           .recorded = RECORDED_ACCELERATION,
                           .fits = has_velocities,
                           .needs = MOTION_NEEDED,
                           .periods = true},
#include "lists/plots.def"
};
const struct catalog plot_catalog = CATALOG("plot", rows);
const struct catalog pane_catalog = CATALOG("pane", rows);

/* ---- properties of a row ---- */

const struct plot_row *plot_row(enum plot_kind kind)
{
    return &rows[kind];
}

bool plot_is_timed(enum plot_kind kind)
{
    return rows[kind].horizontal == ACROSS_TIME;
}

bool plot_is_plane(enum plot_kind kind)
{
    return rows[kind].horizontal == ACROSS_STATE;
}

bool plot_shows_state(enum plot_kind kind)
{
    const struct plot_row *row = &rows[kind];
    return !row->observable && !row->residual && !row->run_curve && !row->figure && !row->picture;
}

bool plot_fits(enum plot_kind kind, const struct model *model)
{
    return !rows[kind].fits || rows[kind].fits(model);
}

bool plot_of_recordings(enum plot_kind kind)
{
    return rows[kind].any_recording || rows[kind].of_motion || rows[kind].recorded;
}

/* Returns true if the session has what the plot shows: its own condition, the table of its study, a
 * run that fits, or a recording. */
bool plot_offered(const struct session *session, enum plot_kind kind)
{
    const struct run *run = session_run(session);
    if (rows[kind].offered)
        return rows[kind].offered(session);
    if (rows[kind].picture)
        return drawing_stored(session, rows[kind].picture->table) != NULL;
    return run ? plot_fits(kind, run->system.model) : figure_recording(session, kind) >= 0;
}

/* Returns the first variable on the vertical axis of a plot. */
const struct variable *vertical_variable(const struct model *model, enum plot_kind kind)
{
    const enum plot_vertical vertical = rows[kind].vertical;
    int index;
    if (vertical == VERTICAL_FIRST)
        index = 0;
    else
        index = vertical == VERTICAL_SECOND || model->order == 1 ? 1 : model->n / 2;
    return &model->variable[index];
}

/* Returns the quantity on the horizontal (x) or vertical axis of a plot for the present run or
 * scene. */
enum quantity plot_quantity(const struct session *session, enum plot_kind kind, bool x)
{
    const struct run *run = session_run(session);
    const struct model *model = run ? run->system.model : session->setup.scene.model;
    const enum quantity first = model->variable[0].quantity;
    const struct plot_row *row = &rows[kind];
    if (row->horizontal == ACROSS_OTHER)
        return QUANTITY_NUMBER;
    if (x) {
        if (row->horizontal == ACROSS_STATE)
            return first;
        return row->horizontal == ACROSS_FREQUENCY ? QUANTITY_FREQUENCY : QUANTITY_TIME;
    }
    if (row->observable)
        return model_quantity(model, observable_named(row->observable));
    /* The phase plot of a spring has v/omega0. */
    const bool scaled = row->scaled && session->setup.settings.phase_axes == PHASE_SCALED &&
                        !(run && !(run->system.oscillator.stiffness > 0));
    return scaled || !plot_shows_state(kind) || !plot_fits(kind, model)
               ? first
               : vertical_variable(model, kind)->quantity;
}

/* ---- the pane that commands act on ---- */

enum plot_kind view_focus(const struct view *view)
{
    return view->focus ? (enum plot_kind)catalog_index(&plot_catalog, view->focus) : PLOT_POSITION;
}

void view_focus_on(struct view *view, enum plot_kind kind)
{
    view->focus = kind == PLOT_POSITION ? NULL : &rows[kind].row;
}
