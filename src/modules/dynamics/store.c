/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the stored results to a session's file and reads them. The equilibria, each orbit and each
 * branch are a record that is written once; the head lists which of them exist. */
#include "modules/dynamics/dynamics_results.h"
#include <hooke/session/read.h>

#include <stdlib.h>
#include <string.h>

/* ---- writing ---- */

/* Returns the number of results. */
static int result_count(const struct dynamics *d)
{
    return (d->equilibria.id != 0) + d->orbits + d->branches;
}

/* Returns the identifier of result i, in the order equilibria, orbits, branches. */
static uint64_t result_id(const struct dynamics *d, int i)
{
    i -= d->equilibria.id != 0;
    if (i < 0)
        return d->equilibria.id;
    return i < d->orbits ? d->orbit[i].id : d->branch[i - d->orbits]->id;
}

/* Writes the head of the results: equations, counters, and the identifiers of all results. */
void dynamics_put_head(const void *part, struct buffer *buffer)
{
    const struct dynamics *d = ((const struct dynamics_part *)part)->found;
    if (!d)
        return;
    const size_t begun = field_begin(buffer, "dynamics");
    field_text(buffer, "equations", text_of(d->equations));
    field_put(buffer, "params", &d->params, sizeof d->params);
    field_put(buffer, "n", &d->n, sizeof d->n);
    field_put(buffer, "next_id", &d->next_id, sizeof d->next_id);
    field_put(buffer, "next_orbit", &d->next_orbit, sizeof d->next_orbit);
    field_put(buffer, "next_branch", &d->next_branch, sizeof d->next_branch);
    field_put(buffer, "next_point", d->next_point, sizeof d->next_point);
    const size_t ids = field_begin(buffer, "ids");
    for (int i = 0; i < result_count(d); i++) {
        const uint64_t id = result_id(d, i);
        buffer_put(buffer, (struct text){(const char *)&id, sizeof id});
    }
    field_end(buffer, ids);
    field_end(buffer, begun);
}

/* Appends a field with `count` items of `item` bytes. */
static void put_array(struct buffer *buffer, const char *name, const void *array, int count,
                      size_t item)
{
    field_put(buffer, name, array, (size_t)count * item);
}

/* Appends the fields of a branch. */
static void put_branch(const struct stored_branch *b, struct buffer *buffer)
{
    field_put(buffer, "number", &b->number, sizeof b->number);
    field_put(buffer, "varies", &b->params, sizeof b->params);
    field_put(buffer, "param", b->param, sizeof b->param);
    field_put(buffer, "from", b->low, sizeof b->low);
    field_put(buffer, "to", b->high, sizeof b->high);
    field_text(buffer, "of", text_of(b->origin));
    field_put(buffer, "branch",
              &(struct branch){.kind = b->branch.kind,
                               .count = b->branch.count,
                               .evals = b->branch.evals,
                               .seconds = b->branch.seconds,
                               .closed = b->branch.closed,
                               .cancelled = b->branch.cancelled},
              offsetof(struct branch, ends));
    for (int k = 0; k < 2; k++)
        field_text(buffer, k ? "end1" : "end0", text_of(b->branch.ends[k]));
    put_array(buffer, "points", b->branch.point, b->branch.count, sizeof *b->branch.point);
    put_array(buffer, "specials", b->special, b->specials, sizeof *b->special);
}

/* Appends the record of result i to the buffer. The results are numbered as in result_id(): the
 * equilibria first, if there are any, then the closed orbits, then the branches. */
static void put_result(const struct dynamics *d, int i, struct buffer *buffer)
{
    const uint64_t id = result_id(d, i);
    const struct stored_equilibria *rests = &d->equilibria;
    const char *kind = "equilibria";
    const double *value = rests->value;
    i -= rests->id != 0;
    if (i >= 0) {
        kind = i < d->orbits ? "orbit" : "branch";
        value = i < d->orbits ? d->orbit[i].value : d->branch[i - d->orbits]->value;
    }
    field_put(buffer, "id", &id, sizeof id);
    field_text(buffer, "kind", text_of(kind));
    put_array(buffer, "value", value, d->params, sizeof *value);
    if (i < 0) {
        put_array(buffer, "of", rests->solution, rests->count, sizeof *rests->solution);
        put_array(buffer, "form", rests->form, rests->count, sizeof *rests->form);
        field_put(buffer, "forced", &rests->forced, sizeof rests->forced);
        field_put(buffer, "complete", &rests->complete, sizeof rests->complete);
    } else if (i < d->orbits) {
        field_put(buffer, "number", &d->orbit[i].number, sizeof d->orbit[i].number);
        put_array(buffer, "solution", &d->orbit[i].solution, 1, sizeof d->orbit[i].solution);
        put_array(buffer, "sample", d->orbit[i].sample, d->orbit[i].samples * (d->n + 1),
                  sizeof *d->orbit[i].sample);
    } else {
        put_branch(d->branch[i - d->orbits], buffer);
    }
}

/* Writes the next result that the file does not have yet. */
bool dynamics_put_next(const void *part, struct stored *stored, int *next)
{
    const struct dynamics *d = ((const struct dynamics_part *)part)->found;
    for (int i = *next; d && i < result_count(d); i++) {
        int k = 0;
        while (k < stored->found && stored->found_id[k] != result_id(d, i))
            k++;
        if (k < stored->found)
            continue;
        put_result(d, i, &stored->record);
        stored->found_id[k] = result_id(d, i);
        stored->found++;
        *next = i + 1;
        return true;
    }
    return false;
}

/* Keeps the identifiers of results that still exist. */
void dynamics_forget(const void *part, struct stored *stored)
{
    const struct dynamics *d = ((const struct dynamics_part *)part)->found;
    int remaining = 0;
    for (int k = 0; k < stored->found; k++) {
        bool there = false;
        for (int i = 0; d && i < result_count(d) && !there; i++)
            there = result_id(d, i) == stored->found_id[k];
        stored->found_id[remaining] = stored->found_id[k];
        remaining += there;
    }
    stored->found = remaining;
}

/* ---- reading ---- */

/* Returns a copy of an array of *count items; -1 allows any length, and becomes it. Returns NULL if
 * it is missing or has another length. */
static void *get_array(struct text text, const char *name, int *count, size_t item)
{
    struct text bytes;
    if (!field_find(text, name, &bytes) || bytes.len % item != 0 || bytes.len / item > INT32_MAX ||
        (*count >= 0 && bytes.len != (size_t)*count * item))
        return NULL;
    void *copy = malloc(bytes.len + item);
    if (copy && bytes.len > 0)
        memcpy(copy, bytes.data, bytes.len);
    *count = (int)(bytes.len / item);
    return copy;
}

/* Returns true if a solution that was read has possible values. */
static bool is_solution_sound(const struct dynamics *d, const struct solution *s)
{
    return s->kind <= SOLUTION_RESPONSE && s->n == d->n && s->values >= 0 &&
           s->values <= DYNAMICS_VARIABLES && s->multiple >= 0 && s->unstable >= 0 &&
           s->unstable <= s->values;
}

/* Returns true if the number of an orbit, branch or label is possible. */
static bool is_number_sound(int number)
{
    return number >= 0 && number <= INT32_MAX / 2;
}

/* Reads the equilibria. On success *d owns `value`. Returns false if the record is damaged. */
static bool get_equilibria(struct dynamics *d, struct text text, uint64_t id, double *value)
{
    struct stored_equilibria *rests = &d->equilibria;
    int count = -1;
    struct solution *solution = get_array(text, "of", &count, sizeof *solution);
    struct equilibrium_form *form = solution ? get_array(text, "form", &count, sizeof *form) : NULL;
    bool ok = form != NULL && rests->id == 0;
    for (int i = 0; i < count && ok; i++)
        ok = is_solution_sound(d, &solution[i]) && form[i].type < equilibrium_catalog.count;
    if (!ok) {
        free(solution);
        free(form);
        return false;
    }
    *rests = (struct stored_equilibria){
        .id = id, .value = value, .count = count, .solution = solution, .form = form};
    const struct field flags[] = {FIELD_OF(struct stored_equilibria, forced),
                                  FIELD_OF(struct stored_equilibria, complete)};
    for (size_t i = 0; i < COUNT_OF(flags); i++)
        fields_get(text, &flags[i], 1, rests);
    return true;
}

/* Reads an orbit. On success *d owns `value`. Returns false if the record is damaged. */
static bool get_orbit(struct dynamics *d, struct text text, uint64_t id, double *value)
{
    struct stored_orbit orbit = {.id = id, .value = value};
    int numbers = -1;
    orbit.sample = get_array(text, "sample", &numbers, sizeof *orbit.sample);
    if (!orbit.sample || numbers % (d->n + 1) != 0 || d->orbits == LIMIT_ORBITS ||
        !field_get(text, "number", &orbit.number, sizeof orbit.number) ||
        !field_get(text, "solution", &orbit.solution, sizeof orbit.solution) ||
        !is_number_sound(orbit.number) || !is_solution_sound(d, &orbit.solution)) {
        free(orbit.sample);
        return false;
    }
    orbit.samples = numbers / (d->n + 1);
    d->orbit[d->orbits++] = orbit;
    return true;
}

/* Returns true if a branch that was read has possible values and indices. */
static bool is_branch_sound(const struct dynamics *d, const struct stored_branch *b)
{
    const struct field flags[] = {FIELD_OF(struct branch, closed),
                                  FIELD_OF(struct branch, cancelled)};
    bool ok = b->params >= 1 && b->params <= 2 && is_number_sound(b->number) &&
              b->branch.kind <= SOLUTION_RESPONSE &&
              fields_sound(flags, COUNT_OF(flags), &b->branch);
    for (int j = 0; j < 2 && ok; j++)
        ok = b->param[j] >= 0 && b->param[j] < d->params;
    for (int i = 0; i < b->branch.count && ok; i++)
        ok = is_solution_sound(d, &b->branch.point[i].solution) &&
             b->branch.point[i].special < SPECIAL_COUNT;
    for (int k = 0; k < b->specials && ok; k++)
        ok = b->special[k].index >= 0 && b->special[k].index < b->branch.count &&
             is_number_sound(b->special[k].number) && b->special[k].special > SPECIAL_NONE &&
             b->special[k].special < SPECIAL_COUNT;
    return ok;
}

/* Reads a stored branch from its record `text` and adds it to *d; id identifies the record. `value`
 * holds the parameter values it was computed with; on success *d owns it. Returns false, with *d
 * unchanged and `value` still owned by the caller, if the record is damaged or if out of memory. */
static bool get_branch(const struct reader *reader, struct dynamics *d, struct text text,
                       uint64_t id, double *value)
{
    struct stored_branch *b = calloc(1, sizeof *b);
    struct text origin, end[2];
    if (!b)
        return false;
    b->specials = -1;
    bool ok = field_get(text, "number", &b->number, sizeof b->number) &&
              field_get(text, "varies", &b->params, sizeof b->params) &&
              field_get(text, "param", b->param, sizeof b->param) &&
              field_get(text, "from", b->low, sizeof b->low) &&
              field_get(text, "to", b->high, sizeof b->high) && field_find(text, "of", &origin) &&
              origin.len < sizeof b->origin &&
              field_get(text, "branch", &b->branch, offsetof(struct branch, ends)) &&
              field_find(text, "end0", &end[0]) && field_find(text, "end1", &end[1]) &&
              end[0].len < sizeof b->branch.ends[0] && end[1].len < sizeof b->branch.ends[1] &&
              b->branch.count >= 0 && d->branches < LIMIT_BRANCHES;
    for (int j = 0; j < 2 && ok; j++) {
        const int row = b->param[j];
        b->param[j] = row >= 0 && row < reader->places.count ? reader->places.row[row] : -1;
    }
    b->branch.point = NULL;
    if (ok) {
        b->branch.point = get_array(text, "points", &b->branch.count, sizeof *b->branch.point);
        b->special = get_array(text, "specials", &b->specials, sizeof *b->special);
    }
    if (!ok || !b->branch.point || !b->special || !is_branch_sound(d, b)) {
        free(b->branch.point);
        free(b->special);
        free(b);
        return false;
    }
    memcpy(b->origin, origin.data, origin.len);
    for (int k = 0; k < 2; k++)
        memcpy(b->branch.ends[k], end[k].data, end[k].len);
    b->id = id;
    b->value = value;
    d->branch[d->branches++] = b;
    return true;
}

/* Returns the values of the parameters in a record; parameters that the file does not know get the
 * scene's values. Returns NULL if out of memory or damaged; the caller frees them. */
static double *get_values(const struct reader *reader, const struct dynamics *d, struct text text)
{
    double *value = malloc(((size_t)d->params + 1) * sizeof *value);
    if (value)
        memcpy(value, reader->session->setup.scene.value, (size_t)d->params * sizeof *value);
    if (value && field_get_placed(text, "value", &reader->places, value, sizeof *value))
        return value;
    free(value);
    return NULL;
}

/* Reads one record into *d. Returns false if it is damaged. */
static bool get_result(const struct reader *reader, struct dynamics *d, struct text text,
                       uint64_t id)
{
    struct text kind;
    double *value = get_values(reader, d, text);
    bool ok = value && field_find(text, "kind", &kind);
    if (ok && text_is(kind, "equilibria"))
        ok = get_equilibria(d, text, id, value);
    else if (ok && text_is(kind, "orbit"))
        ok = get_orbit(d, text, id, value);
    else if (ok)
        ok = get_branch(reader, d, text, id, value);
    if (!ok)
        free(value);
    return ok;
}

/* Reads counters and equations, and finds the identifiers of the results. Returns NULL if damaged
 * or out of memory. */
static struct dynamics *get_head(struct text text, struct text *ids)
{
    static const struct field numbers[] = {
        FIELD_IN(struct dynamics, next_orbit, 0, INT32_MAX / 2),
        FIELD_IN(struct dynamics, next_branch, 0, INT32_MAX / 2),
        FIELD_IN(struct dynamics, next_point, 0, INT32_MAX / 2),
    };
    struct dynamics *d = calloc(1, sizeof *d);
    struct text equations;
    if (d && field_find(text, "equations", &equations) &&
        field_get(text, "params", &d->params, sizeof d->params) &&
        field_get(text, "n", &d->n, sizeof d->n) &&
        field_get(text, "next_id", &d->next_id, sizeof d->next_id) &&
        field_get(text, "next_orbit", &d->next_orbit, sizeof d->next_orbit) &&
        field_get(text, "next_branch", &d->next_branch, sizeof d->next_branch) &&
        field_get(text, "next_point", d->next_point, sizeof d->next_point) &&
        field_find(text, "ids", ids) && d->params >= 0 && d->params <= LIMIT_PARAMETERS &&
        d->n >= 0 && d->n <= DYNAMICS_VARIABLES && d->next_id <= UINT64_MAX / 2 &&
        fields_sound(numbers, COUNT_OF(numbers), d) &&
        (d->equations = strndup(equations.data, equations.len)))
        return d;
    free(d);
    return NULL;
}

/* Damaged results are left out; their labels are not used for other points. */
void dynamics_read(struct reader *reader)
{
    struct text text, ids;
    if (!field_find(reader->state, "dynamics", &text))
        return;
    struct dynamics *d = get_head(text, &ids);
    struct field_places *places = &reader->places;
    size_t lost = 0;
    if (d && d->params != places->count) { /* results of another scene */
        places->rows = places->count = d->params;
        for (int i = 0; i < d->params; i++)
            places->index[i] = places->row[i] = i;
    }
    if (d)
        d->params = places->rows;
    for (uint64_t id; d && ids.len >= sizeof id; ids.data += sizeof id, ids.len -= sizeof id) {
        bool ok = false;
        memcpy(&id, ids.data, sizeof id);
        for (size_t i = 0; i < reader->records && !ok; i++) {
            uint64_t record_id;
            const struct read_record *record = &reader->record[i];
            ok = record->kind == RECORD_FOUND &&
                 field_get(record->content, "id", &record_id, sizeof record_id) &&
                 record_id == id && get_result(reader, d, record->content, id);
        }
        lost += !ok;
    }
    if (!d)
        store_tools()->note(reader, "results for the equations are left out");
    else if (lost > 0)
        store_tools()->note(
            reader,
            "%zu orbits and branches are left out because they are damaged or from another version",
            lost);
    struct dynamics_part *part = session_part(reader->session, &dynamics_module);
    if (!part) {
        dynamics_free(d);
        return;
    }
    dynamics_free(part->found);
    part->found = d;
}
