/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lists of the stored results (list equilibria, orbits, branches, points), and how `use` takes them
 * into the scene. */
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/solving/compute/start.h"
#include "modules/dynamics/branches/verdict.h"
#include "modules/dynamics/handlers.h"

#include <math.h>

/* Types of special points, as text and in records. */
static const char *const special_types[SPECIAL_COUNT] = {
    [SPECIAL_FOLD] = "fold",
    [SPECIAL_HOPF] = "Hopf",
    [SPECIAL_CROSSING] = "branch point",
    [SPECIAL_DOUBLING] = "period doubling",
    [SPECIAL_TORUS] = "Neimark-Sacker",
    [SPECIAL_END] = "end",
    [SPECIAL_CUSP] = "cusp",
    [SPECIAL_DOUBLE] = "Bogdanov-Takens",
    [SPECIAL_BAUTIN] = "generalised Hopf",
};

static const char *const solution_kinds[] = {[SOLUTION_EQUILIBRIUM] = "equilibrium",
                                             [SOLUTION_ORBIT] = "orbit",
                                             [SOLUTION_RESPONSE] = "response"};

/* Adds a cell with the eigenvalues or multipliers. */
static void cell_values(struct text_table *table, const struct solution *s)
{
    struct buffer output = {0};
    put_eigenvalues(&output, s);
    cell_take(table, &output);
}

/* Adds a cell with the name and value of a parameter. */
static void cell_param(struct text_table *table, const struct scene *scene, int param, double value,
                       int digits)
{
    const struct param_row *row = param_at(scene, param);
    cell_format(table, "%s = %s", row->row.name, SHOWN_QUANTITY(value, row->quantity, digits));
}

/* ---- special points ---- */

/* Returns the criticality of a Hopf point as a word, or NULL if unknown. */
static const char *criticality_of(const struct branch_point *point)
{
    if (point->special != SPECIAL_HOPF || !isfinite(point->criticality))
        return NULL;
    if (point->criticality == 0)
        return "degenerate";
    return point->criticality < 0 ? "super" : "sub";
}

/* Adds a cell with the type of a special point: "Hopf, supercritical". */
static void cell_point_type(struct text_table *table, const struct branch_point *point)
{
    struct buffer output = {0};
    const char *way = criticality_of(point);
    buffer_put(&output, text_of(special_types[point->special]));
    if (way)
        buffer_format(&output, ", %s%s", way, point->criticality == 0 ? "" : "critical");
    cell_take(table, &output);
}

/* Returns the largest magnitude of variable i on the branch, relative to which rounding is shown as
 * 0. */
static double largest_state(const struct branch *branch, int i)
{
    double largest = 0;
    for (int k = 0; k < branch->count; k++)
        largest = fmax(largest, fabs(branch->point[k].solution.state[i]));
    return largest;
}

/* Adds the row of a special point to a table. `periods` is true if the table has that column. */
static void put_point(struct text_table *table, const struct scene *scene,
                      const struct system *system, const struct stored_branch *branch,
                      const struct stored_point *point, bool periods)
{
    const struct branch_point *special = stored_point_at(branch, point);
    char label[POINT_LABEL_SIZE];
    stored_point_label(point, label);
    cell_text(table, label);
    cell_point_type(table, special);
    struct buffer where = {0};
    for (int j = 0; j < branch->params; j++) {
        buffer_format(&where, "%s%s = ", j ? ", " : "",
                      param_at(scene, branch->param[j])->row.name);
        /* rounding of 0 is 0 */
        const double value = special->solution.param[j], range = branch->high[j] - branch->low[j];
        buffer_quantity(&where, fabs(value) < 1e-13 * range ? 0 : value,
                        param_at(scene, branch->param[j])->quantity, 10);
    }
    cell_take(table, &where);
    if (special->solution.period > 0)
        cell_quantity(table, special->solution.period, QUANTITY_TIME, 7);
    else if (periods)
        cell_text(table, "-");
    const char *contradicted = special->verified < 0 ? "NO" : "-";
    cell_text(table, special->verified > 0 ? "yes" : contradicted);
    for (int i = 0; i < system->n; i++) {
        const double value = special->solution.state[i],
                     range = fmax(special->solution.top[i] - special->solution.bottom[i],
                                  largest_state(&branch->branch, i));
        cell_quantity(table, fabs(value) < 1e-13 * range ? 0 : value,
                      system_variable(system, i).quantity, 5);
    }
}

/* Appends what contradicts a special point, if runs on both sides do. */
static void put_contradiction(const struct stored_branch *branch, const struct stored_point *point,
                              struct buffer *output)
{
    const char *contradiction = branch_contradiction(stored_point_at(branch, point)->verified);
    char label[POINT_LABEL_SIZE];
    stored_point_label(point, label);
    if (contradiction)
        buffer_format(output, "%s: NO, as %s\n", label, contradiction);
}

/* Appends one table with the special points of `count` branches, then what contradicts them;
 * nothing if there are none. The column of periods T is left out if no point has one. */
void put_points(const struct session *session, const struct stored_branch *const *branch, int count,
                struct arena *arena, struct buffer *output)
{
    const struct scene *scene = &session->setup.scene;
    const struct system system = {.model = scene->model, .n = scene->model->n};
    int specials = 0;
    bool periods = false;
    for (int b = 0; b < count; b++) {
        specials += branch[b]->specials;
        for (int k = 0; k < branch[b]->specials; k++)
            periods =
                periods || stored_point_at(branch[b], &branch[b]->special[k])->solution.period > 0;
    }
    if (specials == 0)
        return;
    struct text_table table = {
        .arena = arena, .gap = 2, .indent = 2, .columns = system.n + 4 + periods};
    static const char *const heads[] = {"", "", "at"};
    for (size_t i = 0; i < COUNT_OF(heads); i++)
        cell_text(&table, heads[i]);
    if (periods)
        cell_text(&table, "T");
    cell_text(&table, "verified");
    /* the state last: where a row is too long for a line, it is what goes on in the next */
    for (int i = 0; i < system.n; i++)
        cell_text(&table, system_variable(&system, i).name);
    for (int b = 0; b < count; b++)
        for (int k = 0; k < branch[b]->specials; k++)
            put_point(&table, scene, &system, branch[b], &branch[b]->special[k], periods);
    text_table_put(&table, output);
    for (int b = 0; b < count; b++)
        for (int k = 0; k < branch[b]->specials; k++)
            put_contradiction(branch[b], &branch[b]->special[k], output);
}

/* Adds the record `branch-point` of a special point on a branch: its label, type, parameters,
 * state, eigenvalues or multipliers, and whether it was verified. */
static void reply_point(const struct scene *scene, const struct system *system,
                        const struct stored_branch *branch, const struct stored_point *point,
                        struct reply *reply)
{
    const struct branch_point *special = stored_point_at(branch, point);
    const struct solution *s = &special->solution;
    char label[POINT_LABEL_SIZE];
    stored_point_label(point, label);
    reply_begin(reply, "branch-point");
    reply_string(reply, "label", label);
    reply_string(reply, "type", special_types[point->special]);
    reply_string(reply, "of", solution_kinds[branch->branch.kind]);
    reply_object(reply, "parameters");
    for (int j = 0; j < branch->params; j++)
        reply_real(reply, param_at(scene, branch->param[j])->row.name, s->param[j]);
    reply_close(reply);
    reply_state(reply, system, "state", s->state);
    reply_real(reply, "period", s->period > 0 ? s->period : NAN);
    reply_values(reply, s->kind == SOLUTION_EQUILIBRIUM ? "eigenvalues" : "multipliers", s);
    const char *way = criticality_of(special);
    reply_string(reply, "criticality", special->criticality != 0 ? way : NULL);
    reply_real(reply, "first_lyapunov", special->criticality);
    if (special->verified == 0)
        reply_null(reply, "verified");
    else
        reply_bool(reply, "verified", special->verified > 0);
    if (special->verified < 0)
        reply_string(reply, "contradicted", branch_contradiction(special->verified));
    reply_real(reply, "accuracy", special->accuracy);
    reply_end(reply);
}

void reply_points(const struct session *session, const struct stored_branch *branch,
                  struct reply *reply)
{
    const struct scene *scene = &session->setup.scene;
    const struct system system = {.model = scene->model, .n = scene->model->n};
    for (int k = 0; k < branch->specials; k++)
        reply_point(scene, &system, branch, &branch->special[k], reply);
}

/* ---- list ---- */

/* Tells that no results of this kind exist, and what finds them. Returns true. */
static bool list_none(struct reply *reply, const char *what, const char *type)
{
    reply_line(reply, "no %s found yet for these equations ('%s' finds them)", what, type);
    return true;
}

/* Returns the system of the scene without its parameters bound, for names and units. */
static struct system unbound_system(const struct session *session)
{
    const struct model *model = session->setup.scene.model;
    return (struct system){.model = model, .n = model->n};
}

/* Lists the stored equilibria as a table and as records. */
bool dynamics_list_equilibria(struct session *session, struct arena *arena, struct reply *reply)
{
    const struct dynamics *d = session_dynamics(session);
    const struct system system = unbound_system(session);
    if (!d || d->equilibria.id == 0)
        return list_none(reply, "equilibria", "equilibria");
    const struct equilibria found = {.count = d->equilibria.count,
                                     .solution = d->equilibria.solution,
                                     .form = d->equilibria.form,
                                     .forced = d->equilibria.forced,
                                     .complete = d->equilibria.complete};
    if (found.count > 0)
        put_equilibria(reply_buffer(reply), &system, &found, arena);
    else
        reply_line(reply, "none in the search region");
    for (int k = 0; k < found.count; k++)
        reply_equilibrium(&system, &found, k, false, reply);
    return true;
}

/* Adds the row of an orbit to the table. */
static void put_orbit_row(struct text_table *table, const struct system *system,
                          const struct stored_orbit *orbit)
{
    const struct solution *s = &orbit->solution;
    cell_count(table, orbit->number);
    cell_quantity(table, s->period, QUANTITY_TIME, 9);
    for (int i = 0; i < system->n; i++)
        cell_text(table,
                  SHOWN_RANGE(s->bottom[i], s->top[i], system_variable(system, i).quantity, 5));
    const char *stability = solution_ones(s) > 0 ? "neutral" : "stable";
    if (!solution_stable(s))
        stability = "unstable";
    cell_text(table, solution_is_known(s) ? stability : "not known");
    cell_values(table, s);
}

/* Lists the stored orbits as a table and as records. */
bool dynamics_list_orbits(struct session *session, struct arena *arena, struct reply *reply)
{
    const struct dynamics *d = session_dynamics(session);
    const struct system system = unbound_system(session);
    if (!d || d->orbits == 0)
        return list_none(reply, "orbits", "orbit");
    struct text_table table = {.arena = arena, .gap = 2, .indent = 2, .columns = system.n + 4};
    cell_text(&table, "");
    cell_text(&table, "T");
    for (int i = 0; i < system.n; i++)
        cell_text(&table, system_variable(&system, i).name);
    cell_text(&table, "");
    cell_text(&table, "multipliers");
    for (int k = 0; k < d->orbits; k++)
        put_orbit_row(&table, &system, &d->orbit[k]);
    text_table_put(&table, reply_buffer(reply));
    for (int k = 0; k < d->orbits; k++) {
        const struct solution *s = &d->orbit[k].solution;
        reply_begin(reply, "kept-orbit");
        reply_int(reply, "n", d->orbit[k].number);
        reply_real(reply, "period", s->period);
        reply_state(reply, &system, "state", s->state);
        reply_values(reply, "multipliers", s);
        reply_stable(reply, s, solution_ones(s) > 0);
        reply_end(reply);
    }
    return true;
}

/* Appends the labels of all special points of a branch. */
static void put_labels(struct buffer *output, const struct stored_branch *b)
{
    for (int k = 0; k < b->specials; k++) {
        char label[POINT_LABEL_SIZE];
        stored_point_label(&b->special[k], label);
        buffer_format(output, "%s%s", k ? " " : "", label);
    }
}

/* Replies with the stored branches of the session, with their ends and the labels of their points,
 * as a table and as records `kept-branch`. Returns what list_none() returns if there are none. */
bool dynamics_list_branches(struct session *session, struct arena *arena, struct reply *reply)
{
    const struct dynamics *d = session_dynamics(session);
    if (!d || d->branches == 0)
        return list_none(reply, "branches", "branch NAME=FROM:TO");
    const struct scene *scene = &session->setup.scene;
    static const char *const heads[] = {"", "of", "from", "to", "points", "labels"};
    struct text_table table = {
        .arena = arena, .gap = 2, .indent = 2, .columns = (int)COUNT_OF(heads)};
    for (size_t i = 0; i < COUNT_OF(heads); i++)
        cell_text(&table, heads[i]);
    for (int k = 0; k < d->branches; k++) {
        const struct stored_branch *b = d->branch[k];
        struct buffer labels = {0};
        cell_count(&table, b->number);
        cell_text(&table, b->origin);
        const struct branch_point *last = &b->branch.point[b->branch.count - 1];
        cell_param(&table, scene, b->param[0], b->branch.point[0].solution.param[0], 6);
        cell_param(&table, scene, b->param[0], last->solution.param[0], 6);
        cell_count(&table, b->branch.count);
        put_labels(&labels, b);
        cell_take(&table, &labels);
    }
    text_table_put(&table, reply_buffer(reply));
    for (int k = 0; k < d->branches; k++) {
        const struct stored_branch *b = d->branch[k];
        struct buffer labels = {0};
        put_labels(&labels, b);
        reply_begin(reply, "kept-branch");
        reply_int(reply, "branch", b->number);
        reply_string(reply, "of", b->origin);
        reply_string(reply, "parameter", param_at(scene, b->param[0])->row.name);
        reply_real(reply, "from", b->low[0]);
        reply_real(reply, "to", b->high[0]);
        reply_int(reply, "rows", b->branch.count);
        reply_string(reply, "labels", buffer_view(&labels));
        reply_end(reply);
        buffer_free(&labels);
    }
    return true;
}

/* Lists the special points of all stored branches. */
bool dynamics_list_points(struct session *session, struct arena *arena, struct reply *reply)
{
    const struct dynamics *d = session_dynamics(session);
    int points = 0;
    for (int k = 0; d && k < d->branches; k++)
        points += d->branch[k]->specials;
    if (points == 0)
        return list_none(reply, "special points", "branch NAME=FROM:TO");
    put_points(session, (const struct stored_branch *const *)d->branch, d->branches, arena,
               reply_buffer(reply));
    for (int k = 0; k < d->branches; k++)
        reply_points(session, d->branch[k], reply);
    return true;
}

/* ---- use ---- */

/* Finds an equilibrium by its number; NULL stands for the first. Sets found->solution and
 * found->scene, with the parameters of the search. Returns false with *error if there is none. */
bool find_equilibrium(const struct session *session, const struct dynamics *d,
                      const struct item *number, struct stored_solution *found, struct error *error)
{
    const int count = d ? d->equilibria.count : 0;
    const double n = number ? number->value.value : 1;
    if (!(n >= 1 && n <= count)) {
        const struct text where = number ? number->text : TEXT("");
        error_at(error, where,
                 count > 0 ? "there are equilibria 1 to %d" : "no equilibria are kept", count);
        return error_hint(error, count > 0 ? "type: list equilibria" : "type: equilibria");
    }
    found->solution = d->equilibria.solution[(int)n - 1];
    dynamics_scene(session, d->equilibria.value, &found->scene);
    return true;
}

/* Finds an orbit by its number; NULL stands for the latest. Sets found->orbit, solution and scene,
 * with the parameters of the orbit. Returns false with *error if there is none. */
bool find_orbit(const struct session *session, const struct dynamics *d, const struct item *number,
                struct stored_solution *found, struct error *error)
{
    const double n = number ? number->value.value : 0;
    found->orbit = n >= 1 && n <= INT32_MAX ? dynamics_orbit(d, (int)n) : NULL;
    if (!number && d && d->orbits > 0)
        found->orbit = &d->orbit[d->orbits - 1];
    if (!found->orbit) {
        error_at(error, number ? number->text : TEXT(""), "no such orbit is kept");
        return error_hint(error, d && d->orbits > 0 ? "type: list orbits" : "type: orbit");
    }
    found->solution = found->orbit->solution;
    dynamics_scene(session, found->orbit->value, &found->scene);
    return true;
}

/* Finds a special point by its label, such as "HB1"; sets found->point, branch, solution and scene.
 * If there is none, returns false with *error, which suggests a label that is spelled alike. */
bool find_label(const struct session *session, const struct dynamics *d, struct text label,
                struct stored_solution *found, struct error *error)
{
    found->point = dynamics_point(d, label, &found->branch);
    if (found->point) {
        found->solution = stored_point_at(found->branch, found->point)->solution;
        dynamics_scene_at(session, found->branch, found->point->index, &found->scene);
        return true;
    }
    struct suggestion suggestion = {.wanted = label};
    bool any = false;
    error_at(error, label, "there is no point '%.*s'", (int)(label.len < 64 ? label.len : 64),
             label.data);
    for (int b = 0; d && b < d->branches; b++)
        for (int k = 0; k < d->branch[b]->specials; k++) {
            char candidate[POINT_LABEL_SIZE];
            stored_point_label(&d->branch[b]->special[k], candidate);
            suggestion_offer(&suggestion, candidate);
            any = true;
        }
    suggestion_hint(&suggestion, error);
    if (error->hint[0])
        return false;
    return error_hint(error, any ? "'list points' shows the existing labels"
                                 : "labels are made by a branch: branch NAME=FROM:TO");
}

/* Writes the parameters that differ between two scenes as one line. */
static void put_changes(const struct scene *previous, const struct scene *now,
                        struct buffer *output)
{
    for (int i = 0; i < (int)scene_params(now)->count; i++)
        if (now->value[i] != previous->value[i])
            buffer_format(output, "%s%s = %s", output->len > 0 ? "  " : "",
                          param_at(now, i)->row.name,
                          SHOWN_QUANTITY(now->value[i], param_at(now, i)->quantity, 9));
}

/* Handles "use" of a stored solution: takes its parameters and its state, as the start, into the
 * scene, and tells which have changed. */
bool use_stored_solution(HANDLER_PARAMETERS)
{
    const struct argument_value *label = argument_value(args, "N|LABEL"),
                                *orbit = argument_value(args, "orbit"),
                                *equilibrium = argument_value(args, "equilibrium");
    const struct dynamics *d = session_dynamics(session);
    struct stored_solution found = {.orbit = NULL};
    bool ok;
    if (label->count)
        ok = find_label(session, d, label->item->text, &found, error);
    else if (orbit->count)
        ok = find_orbit(session, d, orbit->item, &found, error);
    else if (equilibrium->count)
        ok = find_equilibrium(session, d, equilibrium->item, &found, error);
    else
        ok = error_set(error, ERROR_COMMAND,
                       "'use' needs a run, a label of 'list points', an orbit or an equilibrium");
    if (!ok)
        return false;
    const struct scene previous = session->setup.scene;
    if (!scene_start_at(&found.scene, found.solution.state, error))
        return false;
    session->setup.scene = found.scene;
    session_changed(session);
    struct buffer output = {0};
    put_changes(&previous, &found.scene, &output);
    reply_text(reply,
               output.len > 0 ? buffer_text(&output) : TEXT("the scene already has these values"));
    reply_begin(reply, "use");
    reply_object(reply, "parameters");
    for (int i = 0; i < (int)scene_params(&found.scene)->count; i++)
        if (found.scene.value[i] != previous.value[i])
            reply_real(reply, param_at(&found.scene, i)->row.name, found.scene.value[i]);
    reply_close(reply);
    reply_end(reply);
    buffer_free(&output);
    return true;
}
