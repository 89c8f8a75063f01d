/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The figure of branches over their parameter: stable parts as lines, unstable parts as dots,
 * special points as letters. */
#include <hooke/plot/drawing.h>
#include "modules/dynamics/plots.h"

#include "modules/dynamics/dynamics_results.h"

#include <math.h>
#include <string.h>

/* Returns true if a branch varies the same parameters as the last one, so that it is shown with
 * it. */
static bool is_shown(const struct stored_branch *last, const struct stored_branch *b)
{
    return b->params == last->params && b->param[0] == last->param[0] &&
           (b->params == 1 || b->param[1] == last->param[1]);
}

bool branches_known(const struct session *session)
{
    const struct dynamics *dynamics = session_dynamics(session);
    return dynamics && dynamics->branches > 0;
}

/* The figure while it is made. */
struct diagram {
    const struct dynamics *dynamics;
    const struct stored_branch *last;
    int variable; /* index of the variable that is shown upwards */
    struct curve *line, *dots;
    double *x[2], *y[2]; /* coordinates of lines and dots; NAN separates segments */
    double size[2];      /* largest magnitude across and up, which the units are chosen by */
};

/* Returns what is drawn upwards: the second parameter, the state, or an extremum of an orbit (side
 * 1 is the maximum). */
static double plotted_value(const struct diagram *g, const struct solution *s, int side)
{
    if (g->last->params == 2)
        return s->param[1];
    if (s->kind == SOLUTION_EQUILIBRIUM)
        return s->state[g->variable];
    return (side ? s->top : s->bottom)[g->variable];
}

/* Adds a point to the line of stable solutions or to the dots of unstable ones. */
static void diagram_point_put(struct diagram *g, bool stable, double x, double y)
{
    struct curve *curve = stable ? g->line : g->dots;
    g->x[!stable][curve->n] = x;
    g->y[!stable][curve->n++] = y;
    if (isfinite(x) && isfinite(y)) {
        g->size[0] = fmax(g->size[0], fabs(x));
        g->size[1] = fmax(g->size[1], fabs(y));
    }
}

/* Adds one line of a branch to the diagram: its equilibria or, for orbits, their maxima (side 1) or
 * minima (side 0). Stable and unstable parts are separate curves, and a stable part extends to the
 * first unstable point, so that no gap is seen between them. */
static void put_branch_line(struct diagram *g, const struct stored_branch *b, int side)
{
    bool was_stable = false;
    for (int i = 0; i < b->branch.count; i++) {
        const struct solution *s = &b->branch.point[i].solution;
        const bool stable = solution_stable(s);
        const double y = plotted_value(g, s, side);
        if (was_stable && !stable) { /* the line reaches to where it ends */
            diagram_point_put(g, true, s->param[0], y);
            diagram_point_put(g, true, NAN, NAN);
        }
        diagram_point_put(g, stable, s->param[0], y);
        was_stable = stable;
    }
    diagram_point_put(g, true, NAN, NAN);
}

/* Adds a curve for each kind of special point, drawn as the first letter of the kind and labelled
 * with its points' labels; a label that is on two branches is drawn once. `count` is at least the
 * number of points of all kinds. Returns false if out of memory. */
static bool put_specials(struct drawing *d, const struct diagram *g, int count)
{
    double *place = arena_array(d->arena, 2 * (size_t)(count * SPECIAL_COUNT) + 1, sizeof *place);
    for (int special = SPECIAL_NONE + 1; place && special < SPECIAL_COUNT; special++) {
        struct curve *curve = &d->curve[d->curves];
        struct buffer labels = {0};
        const char *name = catalog_row(&special_catalog, (size_t)special - 1)->name;
        *curve = (struct curve){.points = true, .mark = name[0], .x = place, .y = place + count};
        for (int k = 0; k < g->dynamics->branches && special != SPECIAL_END; k++) {
            const struct stored_branch *b = g->dynamics->branch[k];
            for (int i = 0; i < b->specials && is_shown(g->last, b); i++) {
                const struct solution *s = &stored_point_at(b, &b->special[i])->solution;
                char label[POINT_LABEL_SIZE + 1];
                if ((int)b->special[i].special != special)
                    continue;
                stored_point_label(&b->special[i], label);
                label[strlen(label) + 1] = 0;
                label[strlen(label)] = ' ';
                /* the same label on two branches */
                if (labels.len > 0 && strstr(buffer_view(&labels), label))
                    continue;
                buffer_put(&labels, text_of(label));
                place[curve->n] = s->param[0];
                place[count + (int)curve->n++] = plotted_value(g, s, 1);
            }
        }
        curve->label =
            labels.len > 0 ? arena_text(d->arena, text_trim(buffer_text(&labels))) : NULL;
        buffer_free(&labels);
        d->curves += curve->n > 0;
        place += 2 * count;
    }
    return place;
}

/* Finds the variable that was asked for, or the first. Returns false with d->error. */
static bool find_variable(struct drawing *d, int *variable)
{
    const struct model *model = d->session->setup.scene.model;
    *variable = 0;
    if (d->request->columns == 0)
        return true;
    const struct text name = d->request->column[0];
    *variable = model_state(model, name);
    return *variable >= 0 || error_at(d->error, name, "'%.*s' is not a variable of the scene",
                                      (int)name.len, name.data);
}

/* Makes the figure of all branches over the parameters of the last one: the values of a variable
 * over one parameter, or curves of special points in the plane of two. Returns false with
 * d->error. */
bool branches_figure(struct drawing *d, struct figure *figure)
{
    struct diagram g = {.dynamics = session_dynamics(d->session)};
    const struct scene *scene = &d->session->setup.scene;
    size_t rows = 0;
    int points = 1;
    if (!g.dynamics || g.dynamics->branches == 0) {
        error_set(d->error, ERROR_COMMAND, "there is no branch of these equations to plot");
        return error_hint(d->error, "type: branch NAME=FROM:TO");
    }
    g.last = g.dynamics->branch[g.dynamics->branches - 1];
    for (int k = 0; k < g.dynamics->branches; k++) {
        rows += 4 * (size_t)g.dynamics->branch[k]->branch.count + 4;
        points += g.dynamics->branch[k]->specials;
    }
    if (!find_variable(d, &g.variable))
        return false;
    d->curve = arena_array(d->arena, 2 + SPECIAL_COUNT, sizeof *d->curve);
    double *all = arena_array(d->arena, 4 * rows, sizeof *all);
    if (!d->curve || !all)
        return error_memory(d->error);
    for (int k = 0; k < 2; k++) {
        g.x[k] = all + (size_t)(2 * k) * rows;
        g.y[k] = all + (size_t)(2 * k + 1) * rows;
    }
    d->curves = 0; /* the first curve is drawn last, so that letters are above lines */
    if (!put_specials(d, &g, points))
        return error_memory(d->error);
    g.line = &d->curve[d->curves++];
    g.dots = &d->curve[d->curves++];
    *g.line = (struct curve){.label = "stable", .x = g.x[0], .y = g.y[0], .thinned = true};
    *g.dots = (struct curve){.label = "unstable",
                             .x = g.x[1],
                             .y = g.y[1],
                             .points = true,
                             .cloud = true,
                             .thinned = true};
    for (int k = 0; k < g.dynamics->branches; k++) {
        const struct stored_branch *b = g.dynamics->branch[k];
        const bool two = b->branch.kind != SOLUTION_EQUILIBRIUM && b->params == 1;
        for (int side = 0; side < (two ? 2 : 1) && is_shown(g.last, b); side++)
            put_branch_line(&g, b, side);
    }
    const struct param_row *param = param_at(scene, g.last->param[0]);
    const struct variable *variable = &scene->model->variable[g.variable];
    const char *name = variable->name;
    enum quantity quantity = variable->quantity;
    if (g.last->params == 2) {
        name = param_at(scene, g.last->param[1])->row.name;
        quantity = param_at(scene, g.last->param[1])->quantity;
    }
    *figure = (struct figure){.title = "branches",
                              .plane = true,
                              .curve = d->curve,
                              .curves = d->curves,
                              .x = quantity_axis(param->row.name, param->quantity, g.size[0]),
                              .y = quantity_axis(name, quantity, g.size[1])};
    return true;
}
