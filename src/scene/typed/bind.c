/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Binding a typed scene to values of its parameters. Programs are made once for each set of
 * parameters that are 0 and kept with the model. Threads may bind at the same time: of two that
 * make the same programs, the second one destroys its own and uses the other's. */
#include <hooke/base/number.h>
#include "scene/typed/typed.h"

#include <stdlib.h>
#include <string.h>

#define PARTS_MOST 256 /* largest number of sets of parameters that are 0 */

/* List of the parts of a model; they are added at its beginning, and never removed. */
struct typed_parts {
    _Atomic(struct typed_part *) first;
    atomic_int count;
};

/* ---- keeping them ---- */

struct typed_parts *typed_parts_create(void)
{
    return calloc(1, sizeof(struct typed_parts));
}

/* Frees all parts. */
void typed_parts_destroy(struct typed_parts *parts)
{
    struct typed_part *part = parts ? atomic_load(&parts->first) : NULL;
    while (part) {
        struct typed_part *next = part->next;
        typed_part_destroy(part);
        part = next;
    }
    free(parts);
}

/* Returns the part for the set `zeros` among those from `part` to before `end`; NULL if there is
 * none. */
static struct typed_part *typed_part_find(struct typed_part *part, const struct typed_part *end,
                                          uint64_t zeros)
{
    while (part != end && part->zeros != zeros)
        part = part->next;
    return part == end ? NULL : part;
}

/* Returns the part for a set of parameters that are 0, which is made if there is none. Returns NULL
 * with an error. */
static struct typed_part *typed_part_get(const struct typed *typed, uint64_t zeros,
                                         struct error *error)
{
    struct typed_parts *parts = typed->parts;
    struct typed_part *seen = atomic_load(&parts->first),
                      *found = typed_part_find(seen, NULL, zeros);
    if (found)
        return found;
    if (atomic_load(&parts->count) >= PARTS_MOST) {
        error_set(error, ERROR_COMMAND,
                  "parameters of this scene were set to 0 in more than %d combinations",
                  PARTS_MOST);
        return NULL;
    }
    struct typed_part *made = typed_part_create(typed, zeros, error);
    if (!made)
        return NULL;
    made->next = seen;
    while (!atomic_compare_exchange_weak(&parts->first, &made->next, made)) {
        found = typed_part_find(made->next, seen, zeros);
        if (found) {
            typed_part_destroy(made);
            return found;
        }
        seen = made->next;
    }
    atomic_fetch_add(&parts->count, 1);
    return made;
}

/* ---- binding ---- */

/* Returns true if all variables have equations; otherwise sets an error. */
static bool typed_is_complete(const struct typed *typed, struct error *error)
{
    if (!typed->base && typed->model.n == 0) {
        error_set(error, ERROR_COMMAND, "the scene has no variable yet");
        return error_hint(error, "'var x = 1' declares a variable, and 'x' = EXPR' or 'x'' = EXPR' "
                                 "sets its equation");
    }
    if (typed->incomplete < 0)
        return true;
    const struct text name = typed->line[typed->incomplete].name;
    error_set(error, ERROR_COMMAND, "%.*s has no equation", (int)name.len, name.data);
    return error_hint(error, "type %.*s' = EXPR or %.*s'' = EXPR", (int)name.len, name.data,
                      (int)name.len, name.data);
}

/* Sets the values c that all terms of a part have in common: mass, parameters, retained values. */
static void set_values(const struct typed_part *part, const double *param, double mass, double *c)
{
    const struct typed *typed = part->all.typed;
    c[1] = mass;
    for (int i = 0; i < typed->reads; i++)
        c[2 + i] = param[typed->read[i]];
    for (int i = 0; i <= GROUPS; i++) {
        const struct typed_term *term = i < GROUPS ? &part->term[i] : &part->all;
        if (term->add)
            program_keep(term->add, c + 1);
        if (term->jacobian)
            program_keep(term->jacobian, c + 1);
    }
}

/* Returns a bound term with the values c. */
static struct bound_term bind_term(const struct typed_term *term, const double *c)
{
    struct bound_term bound = {.row = &term->row};
    memcpy(bound.c, c, sizeof bound.c);
    memcpy(bound.c, &term, sizeof term);
    return bound;
}

/* Finds the programs for the parameters that are 0, and binds the values of all groups. */
bool typed_bind(const struct typed *typed, const double *param, struct system *system,
                struct error *error)
{
    if (!typed_is_complete(typed, error))
        return false;
    uint64_t zeros = 0;
    for (int i = 0; i < typed->reads; i++)
        zeros |= (uint64_t)(param[typed->read[i]] == 0) << i;
    const struct typed_part *part = typed_part_get(typed, zeros, error);
    if (!part)
        return false;
    if (!typed->base) {
        system->mass = typed->mass >= 0 ? param[typed->mass] : 1;
        system->oscillator.whole = system->order == 2 && system->n == 2;
    }
    double c[TERM_VALUES] = {0};
    set_values(part, param, system->mass, c);
    system->typed = bind_term(&part->all, c);
    for (int g = 0; g < GROUPS; g++) {
        const struct typed_term *term = &part->term[g];
        if (!term->add)
            continue;
        if (system->terms == TERM_MAX)
            return error_set(error, ERROR_COMMAND, "a scene has at most %d terms", TERM_MAX);
        system->term[system->terms++] = bind_term(term, c);
        typed_recognise(term, c, &system->oscillator);
    }
    return true;
}

const struct bound_term *system_whole(const struct system *system)
{
    const struct bound_term *term = system->terms == 1 ? &system->term[0] : &system->typed;
    return system->typed.row && !typed_base(system->model) && term->row->add ? term : NULL;
}

/* Returns the program of a typed term and its number of values; NULL for a built-in term. */
const struct program *term_program(const struct bound_term *term, int *values)
{
    if (term->row->bind)
        return NULL;
    const struct typed_term *typed = typed_term_of(term->c);
    *values = typed->part->steady;
    return typed->add;
}

/* ---- force and potential ---- */

/* Sets the error that force and potential of coordinate i differ at the state y. Returns false. */
static bool refuse_potential(const struct system *system, const double *y, int i, double slope,
                             double force, struct error *error)
{
    struct buffer state_text = {0};
    for (int k = 0; k < system->n / 2; k++) {
        buffer_format(&state_text, "%s%s = ", k > 0 ? ", " : "", system->model->variable[k].name);
        buffer_short(&state_text, y[k], 4);
    }
    const char *name = system->model->variable[i].name;
    char got[REAL_TEXT_SIZE], wanted[REAL_TEXT_SIZE];
    real_format(slope, got);
    real_format(force, wanted);
    error_set(error, ERROR_COMMAND,
              "the potential does not match the force: at %s, -dV/d%s is %s but the force is %s",
              state_text.data ? state_text.data : "?", name, got, wanted);
    buffer_free(&state_text);
    return error_hint(error,
                      "-dV/dx (V in joules) must be the part of the force that depends only on "
                      "positions; without a typed potential, hooke adds up the work of the force");
}

/* Compares the slope of the potential with the force at random points, once for each part. */
bool typed_check(const struct system *system, struct error *error)
{
    enum { POINTS = 12 };
    const double tolerated = 1e-8;
    const struct typed_term *all = typed_term_of(system->typed.c);
    struct typed_part *part = all->part;
    const struct typed_term *force = &part->term[GROUP_FORCE];
    if (!all->slope || atomic_load(&part->checked))
        return true;
    const int rows = system->n / 2;
    uint64_t random = 1;
    for (int k = 0; k < POINTS; k++) {
        double y[LIMIT_VARIABLES] = {0}, a[LIMIT_VARIABLES] = {0}, slope[LIMIT_VARIABLES], size = 0;
        for (int i = 0; i < rows; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            y[i] = system->start[i] + system->scale[i] * ldexp((double)(int64_t)random, -63);
        }
        if (force->add)
            typed_evaluate(force->add, system->typed.c, 0, y, a);
        typed_evaluate(all->slope, system->typed.c, 0, y, slope);
        for (int i = 0; i < rows; i++)
            size = fmax(size, fmax(fabs(slope[i]), fabs(system->mass * a[i])));
        for (int i = 0; i < rows && isfinite(size); i++) /* skips points where they are infinite */
            if (fabs(system->mass * a[i] + slope[i]) > tolerated * size)
                return refuse_potential(system, y, i, -slope[i], system->mass * a[i], error);
    }
    atomic_store(&part->checked, true);
    return true;
}
