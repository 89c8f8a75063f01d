/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait as a figure: choice of plane and region, curves, words for screen readers. */
#include <hooke/run.h>
#include <hooke/base/numeric.h>
#include <hooke/base/unit.h>
#include <hooke/scene/poles.h>
#include "modules/dynamics/dynamics_results.h"
#include "modules/dynamics/stored_portrait.h"

#include <hooke/plot/drawing.h>
#include "modules/dynamics/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ARROW_COLUMNS 6               /* [cell] distance between arrows in a text figure */
#define TEXT_ARROWS 8                 /* number of rows of arrows in a text figure */
#define PANE_COLUMNS 10               /* [cell] distance in a pane, which is redrawn often */
#define PANE_ARROWS 4                 /* number of rows in a pane */
#define PICTURE_ARROWS 22             /* number of columns of arrows in a picture */
#define ARROW_LENGTH 0.55             /* length as a part of the distance between arrows */
#define ARROW_HEAD 0.35               /* length of the head as a part of the arrow */
#define TRAJECTORY_NATURAL_TIMES 30.0 /* length of a trajectory each way, in natural times */
#define RUN_ROWS 20000                /* largest number of rows of the run that are drawn */
#define BOX_MARGIN_FRACTION 0.25      /* extension of the region on each side */

/* ---- choice of plane and region ---- */

/* Sets the variables across and up: those asked for, else position and velocity. */
static bool choose_variables(struct drawing *d, const struct system *system,
                             struct portrait_request *wanted)
{
    const struct figure_request *request = d->request;
    wanted->variable[0] = 0;
    wanted->variable[1] = system->order == 2 ? system->n / 2 : 1;
    if (request->sides == 1 && request->side[0].variable != 0 &&
        request->side[0].variable != wanted->variable[1])
        wanted->variable[1] = request->side[0].variable;
    for (int k = 0; k < request->sides && request->sides == 2; k++)
        wanted->variable[k] = request->side[k].variable;
    return wanted->variable[0] != wanted->variable[1] ||
           error_set(d->error, ERROR_COMMAND, "a portrait needs two different variables");
}

static bool inside(const double inner[2], const double outer[2])
{
    return inner[0] >= outer[0] && inner[1] <= outer[1];
}

/* Replaces the region all [n][2] by that of the pane's last portrait while the run stays inside, so
 * that the picture does not jump. */
static void keep_box(const struct drawing *d, struct portrait_request *wanted, double all[][2])
{
    const struct stored_portrait *stored = stored_portrait(d->session);
    bool keeps = d->request->follow && portrait_is_of(stored, wanted);
    for (int i = 0; i < wanted->scene->model->n && keeps; i++) {
        const double width = all[i][1] - all[i][0],
                     seen[2] = {all[i][0] + BOX_MARGIN_FRACTION * width,
                                all[i][1] - BOX_MARGIN_FRACTION * width},
                     *box = stored->request.all[i];
        keeps = inside(seen, box) && box[1] - box[0] < 3 * width;
    }
    for (int i = 0; i < wanted->scene->model->n && keeps; i++)
        memcpy(all[i], stored->request.all[i], sizeof stored->request.all[i]);
    if (keeps && d->request->running)
        memcpy(wanted->state, stored->request.state, sizeof wanted->state);
}

/* Sets the region: that of the search for equilibria, or the ranges asked for or zoomed to. */
static bool choose_box(struct drawing *d, const struct system *system,
                       struct portrait_request *wanted)
{
    const struct view *view = &d->session->view;
    double all[LIMIT_VARIABLES][2];
    if (!dynamics_search_box(d->session, system, d->arena, all, d->error))
        return false;
    keep_box(d, wanted, all);
    for (int k = 0; k < d->request->sides; k++)
        memcpy(all[d->request->side[k].variable], d->request->side[k].range, sizeof all[0]);
    for (int k = 0; k < 2 && d->request->follow; k++) {
        const double *range = k ? view->y : view->x;
        if (plot_row(view_focus(view))->figure == portrait_figure && !isnan(range[0]))
            memcpy(all[wanted->variable[k]], range, sizeof all[0]);
    }
    for (int i = 0; i < system->n; i++)
        memcpy(wanted->all[i], all[i], sizeof all[i]);
    for (int k = 0; k < 2; k++)
        memcpy(wanted->box[k], all[wanted->variable[k]], sizeof all[0]);
    return true;
}

/* Sets up the whole request and binds its scene. Returns false with d->error. */
static bool choose(struct drawing *d, struct system *system, struct portrait_request *wanted)
{
    struct scene *scene = arena_array(d->arena, 1, sizeof *scene);
    const struct run *run = session_run(d->session);
    double box[LIMIT_VARIABLES][2];
    if (!scene) {
        error_memory(d->error);
        return false;
    }
    *scene = d->session->setup.scene;
    *wanted = (struct portrait_request){.scene = scene, .cancel = d->session->front.cancel};
    for (int i = 0; i < scene->model->n; i++)
        box[i][0] = box[i][1] = NAN;
    for (int k = 0; k < d->request->sides; k++)
        memcpy(box[d->request->side[k].variable], d->request->side[k].range, sizeof box[0]);
    if (!scene_bind_inside(scene, box, system, d->error))
        return d->request->sides > 0 || scene->model->n < 2
                   ? false
                   : error_hint(d->error,
                                "with ranges no valid start is needed: plot portrait %s=FROM:TO",
                                scene->model->variable[0].name);
    if (system->n < 2 || system->n > DYNAMICS_VARIABLES)
        return error_set(d->error, ERROR_COMMAND,
                         "portraits work for scenes with 2 to %d variables, but %s has %d",
                         DYNAMICS_VARIABLES, scene->preset->row.name, system->n);
    const bool present = run && run->scene.model == scene->model;
    if (!choose_variables(d, system, wanted))
        return false;
    memcpy(wanted->state, present ? run->y : system->start, (size_t)system->n * sizeof(double));
    wanted->state[wanted->variable[0]] = wanted->state[wanted->variable[1]] = 0;
    if (!system->autonomous)
        wanted->t = present ? run->t : system->t0;
    /* text has no room for lines that nothing follows */
    wanted->energy =
        system->conservative || (system->energy && d->request->width == PICTURE_COLUMNS);
    if (d->request->running && portrait_is_of(stored_portrait(d->session), wanted))
        wanted->t = stored_portrait(d->session)->request.t;
    return choose_box(d, system, wanted);
}

/* ---- curves ---- */

static struct curve *portrait_curve_add(struct drawing *d, const char *label, char mark)
{
    struct curve *curve = &d->curve[d->curves++];
    *curve = (struct curve){.label = label, .mark = mark};
    return curve;
}

/* Adds a curve with a copy of the line's points, if it has any. False if out of memory. */
static bool add_line(struct drawing *d, const struct polyline *line, const char *label, char mark)
{
    if (line->n == 0)
        return true;
    struct curve *curve = portrait_curve_add(d, label, mark);
    double *x = arena_array(d->arena, 2 * line->n, sizeof *x);
    if (!x)
        return error_memory(d->error);
    memcpy(x, line->x, line->n * sizeof *x);
    memcpy(x + line->n, line->y, line->n * sizeof *x);
    curve->x = x;
    curve->y = x + line->n;
    curve->n = line->n;
    return true;
}

/* Adds a line and frees its points. */
static bool add_own_line(struct drawing *d, struct polyline *line, bool fine, const char *label,
                         char mark)
{
    fine = fine ? add_line(d, line, label, mark) : error_memory(d->error);
    free(line->x);
    free(line->y);
    return fine;
}

/* Adds the current run, with angles reduced to the turn that is shown and gaps where they jump. */
static bool add_run(struct drawing *d, const struct portrait_request *wanted)
{
    const struct run *run = session_run(d->session);
    if (!run || run->scene.model != wanted->scene->model)
        return true;
    const size_t all = trace_count(run->trace), each = all / RUN_ROWS + 1;
    struct polyline line = {NULL, NULL, 0, 0};
    double point[2] = {NAN, NAN};
    bool fine = true;
    for (size_t i = 0; i < all && fine; i += each) {
        bool jumps = false;
        for (int k = 0; k < 2; k++) {
            const double *range = wanted->box[k], width = range[1] - range[0], last = point[k];
            point[k] = trace_state(run->trace, i)[wanted->variable[k]];
            if (fabs(width - TWO_PI) < 1e-9)
                point[k] -= width * floor((point[k] - range[0]) / width);
            jumps = jumps || fabs(point[k] - last) > 0.5 * width;
        }
        fine = (!jumps || polyline_put(&line, NAN, NAN)) && polyline_put(&line, point[0], point[1]);
    }
    return add_own_line(d, &line, fine, drawing_run_label(d, run), 0);
}

/* Adds the trajectories, forwards and backwards, of the states of the command start. */
static bool add_starts(struct drawing *d, const struct system *system,
                       const struct portrait_request *wanted)
{
    const struct view *view = &d->session->view;
    struct polyline line = {NULL, NULL, 0, 0};
    double rate = 0;
    for (int i = 0; i < system->n / 2 && system->order == 2; i++)
        rate = fmax(rate, system->scale[system->n / 2 + i] / system->scale[i]);
    const double span = TRAJECTORY_NATURAL_TIMES / (rate > 0 ? rate : 1);
    bool fine = true;
    for (int k = 0; k < view->starts && view->start_n == system->n && fine; k++)
        fine = portrait_trajectory(wanted, view->start[k], span, &line) &&
               portrait_trajectory(wanted, view->start[k], -span, &line);
    /* as fine as a run where there is none */
    return add_own_line(d, &line, fine, "starts", d->curves > 0 ? '*' : '\0');
}

/* Adds stored orbits of the scene's present values: stable ones as lines, others as dots. */
static bool add_orbits(struct drawing *d, const struct portrait_request *wanted)
{
    const struct dynamics *kept = session_dynamics(d->session);
    const int n = wanted->scene->model->n;
    bool fine = true;
    for (int stable = 1; stable >= 0 && kept && fine; stable--) {
        struct polyline line = {NULL, NULL, 0, 0};
        const char *label = stable ? "neutral orbit" : "unstable orbit"; /* member of a family */
        for (int k = 0; k < kept->orbits && fine; k++) {
            const struct stored_orbit *orbit = &kept->orbit[k];
            if (solution_stable(&orbit->solution) != stable ||
                memcmp(orbit->value, wanted->scene->value,
                       (size_t)kept->params * sizeof *orbit->value) != 0)
                continue;
            if (stable && solution_ones(&orbit->solution) == 0)
                label = "stable orbit";
            for (int i = 0; i < orbit->samples && fine; i++) {
                const double *row = orbit->sample + i * (n + 1) + 1;
                fine = polyline_put(&line, row[wanted->variable[0]], row[wanted->variable[1]]);
            }
            fine = fine && polyline_put(&line, NAN, NAN);
        }
        const int first = d->curves;
        fine = add_own_line(d, &line, fine, label, stable ? '=' : ',');
        if (d->curves > first)
            d->curve[first].points = d->curve[first].cloud = !stable;
    }
    return fine;
}

/* Adds the cursor's point to the figure of a pane, in front of everything else. */
static bool add_cursor(struct drawing *d)
{
    const struct cursors *cursors = &d->session->view.cursors;
    if (!d->request->follow || !cursors->shown || !cursors->plane)
        return true;
    double *point = arena_array(d->arena, 2, sizeof *point);
    if (!point)
        return error_memory(d->error);
    memcpy(point, cursors->point, sizeof cursors->point);
    struct curve *curve = portrait_curve_add(d, "cursor", '+');
    curve->points = true;
    curve->x = point;
    curve->y = point + 1;
    curve->n = 1;
    return true;
}

/* Adds a curve of letters for each type of equilibrium; n and f are unstable nodes and foci. */
static bool add_equilibria(struct drawing *d, const struct portrait_request *wanted,
                           const struct equilibria *found)
{
    static const char letter[] = "NFnfXCDSU"; /* same order as enum equilibrium_type */
    for (size_t type = 0; type < equilibrium_catalog.count; type++) {
        size_t n = 0;
        double *x = arena_array(d->arena, 2 * (size_t)found->count + 1, sizeof *x);
        if (!x)
            return error_memory(d->error);
        for (int e = 0; e < found->count; e++)
            if (found->form[e].type == (enum equilibrium_type)type) {
                x[n] = found->solution[e].state[wanted->variable[0]];
                x[(size_t)found->count + n++] = found->solution[e].state[wanted->variable[1]];
            }
        if (n == 0)
            continue;
        struct curve *curve =
            portrait_curve_add(d, catalog_row(&equilibrium_catalog, type)->name, letter[type]);
        curve->points = true;
        curve->x = x;
        curve->y = x + found->count;
        curve->n = n;
    }
    return true;
}

/* Sets the 6 points of an arrow: tail, tip, barb, tip, barb, gap; `cell` scales the barbs. */
static void put_arrow(double *x, double *y, const double centre[2], const double step[2],
                      const double cell[2])
{
    const double u = step[0] / cell[0], v = step[1] / cell[1];
    const double tail[2] = {centre[0] - step[0] / 2, centre[1] - step[1] / 2},
                 tip[2] = {centre[0] + step[0] / 2, centre[1] + step[1] / 2};
    const double side[5][2] = {
        {0, 0}, {0, 0}, {-u + 0.5 * v, -v - 0.5 * u}, {0, 0}, {-u - 0.5 * v, -v + 0.5 * u}};
    for (int i = 0; i < 5; i++) {
        x[i] = i == 0 ? tail[0] : tip[0] + ARROW_HEAD * side[i][0] * cell[0];
        y[i] = i == 0 ? tail[1] : tip[1] + ARROW_HEAD * side[i][1] * cell[1];
    }
    x[5] = y[5] = NAN;
}

/* Adds arrows of equal length on a grid, which show the direction of the flow. */
static bool add_directions(struct drawing *d, const struct system *system,
                           const struct portrait_request *wanted)
{
    const bool picture = d->request->width == PICTURE_COLUMNS, pane = d->request->follow;
    int column_count = int_max(d->request->width, 30) / (pane ? PANE_COLUMNS : ARROW_COLUMNS);
    int row_count = pane ? PANE_ARROWS : TEXT_ARROWS;
    if (picture) {
        column_count = PICTURE_ARROWS;
        row_count = PICTURE_ARROWS * 2 / 3;
    }
    const size_t n = 6 * (size_t)column_count * (size_t)row_count;
    double *x = arena_array(d->arena, 2 * n, sizeof *x), *y = x ? x + n : NULL;
    if (!x)
        return error_memory(d->error);
    const double cell[2] = {(wanted->box[0][1] - wanted->box[0][0]) / column_count,
                            (wanted->box[1][1] - wanted->box[1][0]) / row_count};
    size_t count = 0;
    for (int i = 0; i < column_count; i++)
        for (int j = 0; j < row_count; j++) {
            double state[LIMIT_VARIABLES], rate[LIMIT_VARIABLES];
            const double centre[2] = {wanted->box[0][0] + (i + 0.5) * cell[0],
                                      wanted->box[1][0] + (j + 0.5) * cell[1]};
            memcpy(state, wanted->state, sizeof wanted->state);
            state[wanted->variable[0]] = centre[0];
            state[wanted->variable[1]] = centre[1];
            system_derivative(system, wanted->t, state, rate);
            const double u = rate[wanted->variable[0]] / cell[0],
                         v = rate[wanted->variable[1]] / cell[1], size = hypot(u, v);
            if (!(size > 0) || !isfinite(size))
                continue;
            const double step[2] = {ARROW_LENGTH * u / size * cell[0],
                                    ARROW_LENGTH * v / size * cell[1]};
            put_arrow(x + count, y + count, centre, step, cell);
            count += 6;
        }
    struct curve *curve = portrait_curve_add(d, NULL, 0);
    curve->arrows = true;
    curve->plain = pane;
    curve->x = x;
    curve->y = y;
    curve->n = count;
    return true;
}

/* ---- words ---- */

static void put_axis_words(struct buffer *output, const struct variable *variable,
                           const double range[2])
{
    buffer_format(output, "%s from ", variable->name);
    buffer_quantity(output, range[0], variable->quantity, 3);
    buffer_put(output, TEXT(" to "));
    buffer_quantity(output, range[1], variable->quantity, 3);
}

/* Describes the portrait: region, equilibria and separatrices. */
static void put_words(struct buffer *output, const struct system *system,
                      const struct portrait_request *wanted, const struct portrait *portrait)
{
    buffer_put(output, TEXT("Phase portrait: "));
    for (int k = 0; k < 2; k++) {
        const struct variable variable = system_variable(system, wanted->variable[k]);
        put_axis_words(output, &variable, wanted->box[k]);
        buffer_put(output, k ? TEXT(" up.") : TEXT(" across, "));
    }
    for (int e = 0; e < portrait->found.count; e++) {
        buffer_format(output, "%s%s at (", e ? ", " : " It has a ",
                      catalog_row(&equilibrium_catalog, portrait->found.form[e].type)->name);
        for (int k = 0; k < 2; k++) {
            buffer_put(output, k ? TEXT(", ") : TEXT(""));
            buffer_quantity(output, portrait->found.solution[e].state[wanted->variable[k]],
                            system_variable(system, wanted->variable[k]).quantity, 4);
        }
        buffer_char(output, ')');
    }
    buffer_put(output,
               portrait->found.count ? TEXT(".") : TEXT(" No equilibrium was found in it."));
    for (int i = 0; i < portrait->separatrices; i++) {
        const struct separatrix *s = &portrait->separatrix[i];
        buffer_format(output,
                      s->stable ? " A separatrix ends at equilibrium %d, from "
                                : " A separatrix leaves equilibrium %d for ",
                      s->equilibrium + 1);
        if (s->target >= 0)
            buffer_format(output, "equilibrium %d.", s->target + 1);
        else
            buffer_put(output, strcmp(s->end, "frame") == 0 ? TEXT("the frame.")
                                                            : TEXT("outside the frame."));
    }
}

/* Returns the note below the plot: "at t = 2 s, equilibria of the mean", "z = 3"; or NULL. */
static const char *put_note(struct drawing *d, const struct system *system,
                            const struct portrait_request *wanted, const struct portrait *portrait)
{
    struct buffer text = {0};
    if (!system->autonomous) {
        buffer_put(&text, TEXT("at t = "));
        buffer_quantity(&text, wanted->t, QUANTITY_TIME, 3);
        buffer_put(&text, TEXT(", equilibria of the mean"));
    }
    for (int i = 0; i < system->n; i++)
        if (i != wanted->variable[0] && i != wanted->variable[1]) {
            const struct variable variable = system_variable(system, i);
            buffer_format(&text, "%s%s = ", text.len ? ", " : "", variable.name);
            buffer_quantity(&text, wanted->state[i], variable.quantity, 3);
        }
    if (portrait->cancelled)
        buffer_format(&text, "%sstopped", text.len ? ", " : "");
    const char *note = text.len ? arena_text(d->arena, buffer_text(&text)) : NULL;
    buffer_free(&text);
    return note;
}

/* ---- the figure ---- */

/* Returns the axis of a variable with the limits `range`, which are fixed. */
static struct axis axis_of(const struct drawing *d, const struct system *system, int variable,
                           const double range[2])
{
    const struct variable v = system_variable(system, variable);
    struct axis axis = quantity_axis(arena_text(d->arena, text_of(v.name)), v.quantity,
                                     fmax(fabs(range[0]), fabs(range[1])));
    axis.first_value = range[0];
    axis.last_value = range[1];
    axis.fixed = true;
    return axis;
}

/* Adds nullclines, separatrices and lines of equal energy. */
static bool add_lines(struct drawing *d, const struct portrait_request *wanted,
                      const struct portrait *portrait, const struct system *system)
{
    static const struct {
        const char *label;
        char mark;
    } look[PORTRAIT_LINES] = {[PORTRAIT_NULLCLINE] = {NULL, ':'},
                              [PORTRAIT_NULLCLINE_UP] = {NULL, ';'},
                              [PORTRAIT_SEPARATRIX] = {"stable separatrix", '#'},
                              [PORTRAIT_SEPARATRIX_UNSTABLE] = {"unstable separatrix", '%'},
                              [PORTRAIT_ENERGY] = {"energy", '.'}};
    for (int i = 0; i < PORTRAIT_LINES; i++) {
        const char *label = look[i].label;
        struct buffer text = {0};
        if (!label) {
            buffer_format(
                &text, "%s' = 0",
                system_variable(system, wanted->variable[i == PORTRAIT_NULLCLINE_UP]).name);
            label = arena_text(d->arena, buffer_text(&text));
            buffer_free(&text);
        }
        const int first = d->curves;
        if (!label || !add_line(d, &portrait->line[i], label, look[i].mark))
            return label || error_memory(d->error);
        if (d->curves > first)
            d->curve[first].plain = true;
    }
    return true;
}

bool portrait_figure(struct drawing *d, struct figure *figure)
{
    struct portrait_request wanted;
    struct system system;
    if (!choose(d, &system, &wanted))
        return false;
    const struct portrait *portrait = session_portrait(d->session, &wanted, d->error);
    if (!portrait)
        return false;
    d->curve =
        arena_array(d->arena, PORTRAIT_LINES + 7 + equilibrium_catalog.count, sizeof *d->curve);
    if (!d->curve)
        return error_memory(d->error);
    if (!add_run(d, &wanted) || !add_starts(d, &system, &wanted) || !add_orbits(d, &wanted) ||
        !add_lines(d, &wanted, portrait, &system) || !add_cursor(d) ||
        !add_equilibria(d, &wanted, &portrait->found) || !add_directions(d, &system, &wanted))
        return false;
    struct buffer words = {0};
    put_words(&words, &system, &wanted, portrait);
    *figure = (struct figure){.title = "portrait",
                              .curve = d->curve,
                              .curves = d->curves,
                              .plane = true,
                              .x = axis_of(d, &system, wanted.variable[0], wanted.box[0]),
                              .y = axis_of(d, &system, wanted.variable[1], wanted.box[1]),
                              .note = put_note(d, &system, &wanted, portrait),
                              .words = arena_text(d->arena, buffer_text(&words))};
    buffer_free(&words);
    const struct run *run = session_run(d->session);
    if (run && run->scene.model == wanted.scene->model) {
        figure->has_point = true;
        for (int k = 0; k < 2; k++)
            figure->point[k] = run->y[wanted.variable[k]];
    }
    return figure->x.label && figure->y.label && figure->words ? true : error_memory(d->error);
}
