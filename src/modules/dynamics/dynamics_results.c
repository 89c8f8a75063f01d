/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stores results for the present equations, finds them again, and drops them when the equations
 * change. */
#include "modules/solving/compute/start.h"
#include "modules/dynamics/dynamics_results.h"
#include <hooke/scene/poles.h>

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Two solutions are the same if they differ by less than this, relative to the sizes. */
#define SAME_SOLUTION_RELATIVE 1e-8

/* ---- the equations that results belong to ---- */

/* Returns a text that changes when the right-hand sides do, but not when only values do: the preset
 * and the typed lines, of variables and parameters only their names. Returns NULL if out of memory;
 * the caller frees it. */
static char *equations_of(const struct scene *scene)
{
    struct buffer text = {0};
    const bool all_typed = scene->model->typed && !typed_base(scene->model);
    buffer_put(&text, text_of(all_typed ? "typed" : scene->preset->row.name));
    for (int i = 0; i < typed_lines(scene->model); i++) {
        const struct typed_line *line = typed_line(scene->model, i);
        buffer_char(&text, '\n');
        if (line->kind == TYPED_VAR || line->kind == TYPED_PARAM)
            buffer_put(&text, line->name);
        else
            typed_describe(line, &text);
    }
    if (text.failed)
        buffer_free(&text);
    return text.data;
}

/* Compares the stored equations with those of the scene. */
const struct dynamics *session_dynamics(const struct session *session)
{
    const struct dynamics_part *part = session_part_if_made(session, &dynamics_module);
    const struct dynamics *dynamics = part ? part->found : NULL;
    if (!dynamics)
        return NULL;
    char *present = equations_of(&session->setup.scene);
    const bool same = present && strcmp(present, dynamics->equations) == 0;
    free(present);
    return same ? dynamics : NULL;
}

static void free_equilibria(struct stored_equilibria *stored)
{
    free(stored->value);
    free(stored->solution);
    free(stored->form);
    *stored = (struct stored_equilibria){.id = 0};
}

static void free_orbit(struct stored_orbit *orbit)
{
    free(orbit->value);
    free(orbit->sample);
}

static void free_branch(struct stored_branch *branch)
{
    branch_free(&branch->branch);
    free(branch->value);
    free(branch->special);
}

/* Frees all results; NULL is allowed. */
void dynamics_free(struct dynamics *dynamics)
{
    if (!dynamics)
        return;
    free_equilibria(&dynamics->equilibria);
    for (int i = 0; i < dynamics->orbits; i++)
        free_orbit(&dynamics->orbit[i]);
    for (int i = 0; i < dynamics->branches; i++) {
        free_branch(dynamics->branch[i]);
        free(dynamics->branch[i]);
    }
    free(dynamics->equations);
    free(dynamics);
}

/* Returns the results of the present equations, empty at first. Those of other equations are freed,
 * but identifiers continue, so that none is used twice in a file. Returns NULL if out of memory. */
static struct dynamics *dynamics_for(struct session *session)
{
    struct dynamics_part *part = session_part(session, &dynamics_module);
    if (!part || session_dynamics(session))
        return part ? part->found : NULL;
    struct dynamics *fresh = calloc(1, sizeof *fresh);
    char *equations = equations_of(&session->setup.scene);
    if (!fresh || !equations) {
        free(fresh);
        free(equations);
        return NULL;
    }
    fresh->equations = equations;
    fresh->params = (int)scene_params(&session->setup.scene)->count;
    fresh->n = session->setup.scene.model->n;
    fresh->next_orbit = fresh->next_branch = 1;
    fresh->next_id = part->found ? part->found->next_id : 1;
    for (int i = 0; i < SPECIAL_COUNT; i++)
        fresh->next_point[i] = 1;
    dynamics_free(part->found);
    return part->found = fresh; /* identifiers continue, so that none is used twice in a file */
}

/* Returns a copy of the values of all parameters, or NULL if out of memory. */
static double *copy_values(const struct session *session, const double *source)
{
    const size_t bytes = scene_params(&session->setup.scene)->count * sizeof(double);
    double *value = malloc(bytes + sizeof *value);
    if (value)
        memcpy(value, source, bytes);
    return value;
}

/* Returns true if both are the same solution within the tolerance, found from anywhere. */
static bool same_solution(const struct solution *a, const struct solution *b)
{
    bool same = a->kind == b->kind && a->n == b->n && a->multiple == b->multiple &&
                fabs(a->period - b->period) <= SAME_SOLUTION_RELATIVE * a->period;
    for (int i = 0; i < a->n && same; i++) {
        const double size = fmax(fmax(fabs(a->top[i]), fabs(a->bottom[i])), 1e-3);
        /* An orbit may begin anywhere along itself, but has the same extrema. */
        same = fabs(a->top[i] - b->top[i]) <= 1e2 * SAME_SOLUTION_RELATIVE * size &&
               fabs(a->bottom[i] - b->bottom[i]) <= 1e2 * SAME_SOLUTION_RELATIVE * size;
    }
    return same;
}

/* ---- equilibria and orbits ---- */

/* Copies the equilibria and the parameters with which they were found, in place of earlier ones. */
bool dynamics_store_equilibria(struct session *session, const struct equilibria *found,
                               struct error *error)
{
    struct dynamics *dynamics = dynamics_for(session);
    const size_t count = (size_t)found->count;
    double *value = copy_values(session, session->setup.scene.value);
    struct solution *solution = malloc((count + 1) * sizeof *solution);
    struct equilibrium_form *form = malloc((count + 1) * sizeof *form);
    if (!dynamics || !value || !solution || !form) {
        free(value);
        free(solution);
        free(form);
        return error_memory(error);
    }
    for (size_t i = 0; i < count; i++) {
        solution[i] = found->solution[i];
        form[i] = found->form[i];
    }
    free_equilibria(&dynamics->equilibria);
    dynamics->equilibria = (struct stored_equilibria){.id = dynamics->next_id++,
                                                      .value = value,
                                                      .count = found->count,
                                                      .solution = solution,
                                                      .form = form,
                                                      .forced = found->forced,
                                                      .complete = found->complete};
    session_changed(session);
    return true;
}

/* Returns the index of the same orbit, found with the same parameters, or -1 if it is new. */
static int find_same_orbit(const struct dynamics *dynamics, const double *value,
                           const struct solution *orbit)
{
    for (int i = 0; i < dynamics->orbits; i++) {
        const struct stored_orbit *stored = &dynamics->orbit[i];
        if (memcmp(stored->value, value, (size_t)dynamics->params * sizeof *value) == 0 &&
            same_solution(&stored->solution, orbit))
            return i;
    }
    return -1;
}

/* Copies an orbit behind the others, and removes the same one or, if all places are taken, the
 * oldest. */
const struct stored_orbit *dynamics_store_orbit(struct session *session,
                                                const struct solution *orbit, int samples,
                                                const double *sample, struct error *error)
{
    struct dynamics *dynamics = dynamics_for(session);
    const size_t bytes = (size_t)samples * (size_t)(orbit->n + 1) * sizeof *sample;
    double *value = copy_values(session, session->setup.scene.value),
           *copy = malloc(bytes + sizeof *copy);
    if (!dynamics || !value || !copy) {
        free(value);
        free(copy);
        error_memory(error);
        return NULL;
    }
    if (bytes > 0)
        memcpy(copy, sample, bytes);
    int index = find_same_orbit(dynamics, value, orbit);
    const int number = index >= 0 ? dynamics->orbit[index].number : dynamics->next_orbit++;
    if (index >= 0 || dynamics->orbits == LIMIT_ORBITS) {
        const int goes = index >= 0 ? index : 0;
        free_orbit(&dynamics->orbit[goes]);
        dynamics->orbits--;
        memmove(&dynamics->orbit[goes], &dynamics->orbit[goes + 1],
                (size_t)(dynamics->orbits - goes) * sizeof *dynamics->orbit);
    }
    struct stored_orbit *stored = &dynamics->orbit[dynamics->orbits++];
    *stored = (struct stored_orbit){.id = dynamics->next_id++,
                                    .number = number,
                                    .value = value,
                                    .solution = *orbit,
                                    .samples = samples,
                                    .sample = copy};
    session_changed(session);
    return stored;
}

const struct stored_orbit *dynamics_orbit(const struct dynamics *dynamics, int number)
{
    for (int i = 0; dynamics && i < dynamics->orbits; i++)
        if (dynamics->orbit[i].number == number)
            return &dynamics->orbit[i];
    return NULL;
}

/* ---- branches ---- */

/* Returns true if both branches vary the same parameters and all other values are the same. */
static bool same_setting(const struct dynamics *dynamics, const struct stored_branch *a,
                         const struct stored_branch *b)
{
    bool same = a->params == b->params;
    for (int j = 0; j < a->params && same; j++)
        same = a->param[j] == b->param[j];
    for (int i = 0; i < dynamics->params && same; i++)
        same =
            a->value[i] == b->value[i] || i == a->param[0] || (a->params > 1 && i == a->param[1]);
    return same;
}

/* Returns true if point p of branch a and point q of branch b are the same special point. */
static bool same_point(const struct stored_branch *a, const struct stored_point *p,
                       const struct stored_branch *b, const struct stored_point *q)
{
    const struct solution *s = &stored_point_at(a, p)->solution,
                          *t = &stored_point_at(b, q)->solution;
    bool same = p->special == q->special && same_solution(s, t);
    for (int j = 0; j < a->params && same; j++)
        same = fabs(s->param[j] - t->param[j]) <=
               SAME_SOLUTION_RELATIVE * fmax(fabs(s->param[j]), 1e-3);
    return same;
}

/* Returns the number in the label of the same point on a stored branch, or 0 if there is none. */
static int known_number(const struct dynamics *dynamics, const struct stored_branch *branch,
                        const struct stored_point *point)
{
    for (int b = dynamics->branches; b-- > 0;) {
        const struct stored_branch *other = dynamics->branch[b];
        for (int k = 0; k < other->specials && same_setting(dynamics, branch, other); k++)
            if (same_point(branch, point, other, &other->special[k]))
                return other->special[k].number;
    }
    return 0;
}

/* Fills branch->special with the special points and their numbers, from which labels such as "HB1"
 * are made: a point that an earlier branch has found keeps its number, others get the next one of
 * their kind. Returns false if out of memory. */
static bool label_points(struct dynamics *dynamics, struct stored_branch *branch)
{
    int count = 0;
    for (int i = 0; i < branch->branch.count; i++)
        count += branch->branch.point[i].special != SPECIAL_NONE;
    branch->special = malloc(((size_t)count + 1) * sizeof *branch->special);
    if (!branch->special)
        return false;
    for (int i = 0; i < branch->branch.count; i++) {
        const enum special special = branch->branch.point[i].special;
        if (special == SPECIAL_NONE)
            continue;
        struct stored_point *point = &branch->special[branch->specials];
        *point = (struct stored_point){.index = i, .special = special};
        point->number = known_number(dynamics, branch, point);
        if (point->number == 0)
            point->number = dynamics->next_point[special]++;
        branch->specials++;
    }
    return true;
}

/* Takes over a branch with labels for its special points, and removes the oldest if all places are
 * taken. */
struct stored_branch *dynamics_store_branch(struct session *session, struct stored_branch *like,
                                            const double *value, struct error *error)
{
    struct dynamics *dynamics = dynamics_for(session);
    struct stored_branch *stored = malloc(sizeof *stored);
    like->value = copy_values(session, value);
    like->special = NULL;
    like->specials = 0;
    if (!dynamics || !stored || !like->value || !label_points(dynamics, like)) {
        free_branch(like);
        free(stored);
        error_memory(error);
        return NULL;
    }
    if (dynamics->branches == LIMIT_BRANCHES) {
        free_branch(dynamics->branch[0]);
        free(dynamics->branch[0]);
        dynamics->branches--;
        memmove(dynamics->branch, dynamics->branch + 1,
                (LIMIT_BRANCHES - 1) * sizeof(dynamics->branch[0]));
    }
    *stored = *like;
    stored->id = dynamics->next_id++;
    stored->number = dynamics->next_branch++;
    dynamics->branch[dynamics->branches++] = stored;
    session_changed(session);
    return stored;
}

/* Searches the latest branch first, and compares labels without regard to case. */
const struct stored_point *dynamics_point(const struct dynamics *dynamics, struct text label,
                                          const struct stored_branch **branch)
{
    for (int b = dynamics ? dynamics->branches : 0; b-- > 0;)
        for (int k = 0; k < dynamics->branch[b]->specials; k++) {
            const struct stored_point *point = &dynamics->branch[b]->special[k];
            char candidate[POINT_LABEL_SIZE];
            stored_point_label(point, candidate);
            size_t i = 0;
            while (i < label.len && candidate[i] &&
                   toupper((unsigned char)label.data[i]) == candidate[i])
                i++;
            if (i == label.len && !candidate[i]) {
                *branch = dynamics->branch[b];
                return point;
            }
        }
    return NULL;
}

void stored_point_label(const struct stored_point *point, char label[POINT_LABEL_SIZE])
{
    snprintf(label, POINT_LABEL_SIZE, "%s%d",
             catalog_row(&special_catalog, (size_t)point->special - 1)->name, point->number);
}

/* ---- scenes of results ---- */

void dynamics_scene(const struct session *session, const double *value, struct scene *scene)
{
    *scene = session->setup.scene;
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        scene_take_value(scene, i, value[i]);
}

void dynamics_scene_at(const struct session *session, const struct stored_branch *branch, int index,
                       struct scene *scene)
{
    dynamics_scene(session, branch->value, scene);
    for (int j = 0; j < branch->params; j++)
        scene_take_value(scene, branch->param[j], branch->branch.point[index].solution.param[j]);
}
