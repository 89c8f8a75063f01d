/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A run as bytes, and back, for sessions that are kept in files. Rows are stored apart from
 * everything else, because there are many and they are appended. What follows from the scene and
 * the method (systems, kernels, powers of the one-step matrix) is computed again, with the same
 * bits; everything else is stored. The memory of an external solver library cannot be. */
#include <hooke/base/catalog.h>
#include "run/store_private.h"

#include <stdlib.h>

#define OF_RUN(member) FIELD_OF(struct run, member)
static const struct field run_fields[] = {
    OF_RUN(number),
    OF_RUN(name),
    OF_RUN(settings),
    OF_RUN(plan),
    OF_RUN(steps),
    OF_RUN(t),
    OF_RUN(y),
    OF_RUN(cost),
    OF_RUN(seconds),
    OF_RUN(stop),
    OF_RUN(singular),
    OF_RUN(unsound),
    OF_RUN(warned_growth),
    OF_RUN(warned_sliding),
    OF_RUN(warned_piling),
    OF_RUN(warned_unsound),
    OF_RUN(warned_doubt),
    OF_RUN(warned_error),
    OF_RUN(warned_burst),
    OF_RUN(missed),
    OF_RUN(controller),
    OF_RUN(opinion),
};

#define OF_PRIVATE(member) FIELD_OF(struct run_private, member)
static const struct field private_fields[] = {
    OF_PRIVATE(step.warm), OF_PRIVATE(step.t),      OF_PRIVATE(step.h),    OF_PRIVATE(step.again),
    OF_PRIVATE(step.tol),  OF_PRIVATE(step.square), OF_PRIVATE(step.cost), OF_PRIVATE(look),
    OF_PRIVATE(looked),    OF_PRIVATE(checks),      OF_PRIVATE(searched),  OF_PRIVATE(factor),
    OF_PRIVATE(balance),   OF_PRIVATE(doubt),
};

#define OF_TRACE(member) FIELD_OF(struct trace, member)
static const struct field trace_fields[] = {
    OF_TRACE(every),  OF_TRACE(next),     OF_TRACE(bucket),     OF_TRACE(tail_end),
    OF_TRACE(tail),   OF_TRACE(low),      OF_TRACE(high),       OF_TRACE(interval),
    OF_TRACE(origin), OF_TRACE(due),      OF_TRACE(ahead),      OF_TRACE(now),
    OF_TRACE(now_t),  OF_TRACE(now_step), OF_TRACE(mark_width), OF_TRACE(count),
};

#define OF_EPOCH(member) FIELD_OF(struct epoch, member)
static const struct field epoch_fields[] = {
    OF_EPOCH(first),
    OF_EPOCH(t),
    OF_EPOCH(plan),
    OF_EPOCH(drag),
};

/* ---- writing ---- */

/* Returns the number of doubles that are stored of p->work: the method's memory and the vectors
 * that allocate() in run.c has put behind it, but for those of side steps. */
static size_t work_size(const struct run *run)
{
    const size_t n = (size_t)run->system.n;
    return method_work_size(run->method, run->system.n) + 4 * n;
}

/* Appends an array of `count` elements of `bytes` each as a field. */
static void put_array(struct buffer *buffer, const char *name, const void *array, size_t count,
                      size_t bytes)
{
    field_put(buffer, name, count > 0 ? array : NULL, count * bytes);
}

/* Writes everything but the rows as fields. */
void run_store(const struct run *run, struct buffer *output)
{
    const struct run_private *p = run->private_state;
    const struct event_records *records = &p->event_records;
    const struct trace *trace = run->trace;
    const size_t n = (size_t)run->system.n, params = scene_params(&run->scene)->count;
    fields_put(output, run_fields, COUNT_OF(run_fields), run);
    field_text(output, "opinion_by",
               text_of(run->opinion.method ? run->opinion.method->row.name : ""));
    fields_put(output, private_fields, COUNT_OF(private_fields), p);
    put_array(output, "work", p->work, work_size(run), sizeof *p->work);
    for (size_t i = 0; i < p->epochs; i++) {
        const size_t begun = field_begin(output, "epoch");
        fields_put(output, epoch_fields, COUNT_OF(epoch_fields), &p->epoch[i]);
        put_array(output, "start", p->epoch[i].start, n, sizeof(double));
        put_array(output, "value", p->epoch[i].value, params, sizeof(double));
        field_end(output, begun);
    }
    put_array(output, "saved", p->saved, p->saves, sizeof *p->saved);
    put_array(output, "events", records->record, records->count, sizeof *records->record);
    put_array(output, "event_states", records->state, records->count * n, sizeof *records->state);
    put_array(output, "kicks", p->kick, p->kicks, sizeof *p->kick);
    put_array(output, "responses", p->responses.response, p->responses.count,
              sizeof *p->responses.response);
    put_array(output, "response_slopes", p->responses.slope, p->responses.count * (2 * n + 1),
              sizeof *p->responses.slope);
    if (p->propagator) {
        const struct propagator_place place = propagator_place(p->propagator);
        field_put(output, "propagator", &place, sizeof place);
    }
    fields_put(output, trace_fields, COUNT_OF(trace_fields), trace);
    put_array(output, "grids", trace->grid, trace->grids, sizeof *trace->grid);
}

size_t run_row_bytes(const struct run *run)
{
    const struct trace *trace = run->trace;
    return (trace->width + trace->mark_width) * sizeof(double) + sizeof(int64_t);
}

size_t run_recorded(const struct run *run)
{
    return run->trace->count;
}

size_t run_rows_stored(const struct run *run)
{
    return run->trace->stored;
}

void run_set_stored(struct run *run, size_t rows)
{
    run->trace->stored = rows;
}

/* Writes rows as their step, their numbers and their mark. */
void run_store_rows(const struct run *run, size_t first, size_t count, struct buffer *output)
{
    const struct trace *trace = run->trace;
    for (size_t i = first; i < first + count; i++) {
        const int64_t step = trace_row_step(trace, i);
        const struct energy_tally mark = trace_mark(trace, i);
        buffer_put(output, (struct text){(const char *)&step, sizeof step});
        buffer_put(output,
                   (struct text){(const char *)trace_row(trace, i), trace->width * sizeof(double)});
        buffer_put(output, (struct text){(const char *)&mark, trace->mark_width * sizeof(double)});
    }
}

/* ---- reading ---- */

/* Reads the field `name` into new memory, which replaces *(void **)array, and sets *count to its
 * number of elements. Returns false if it is missing, of a wrong size, or out of memory. */
static bool get_array(struct text text, const char *name, size_t bytes, void *array, size_t *count)
{
    struct text value;
    void *made = NULL;
    if (!field_find(text, name, &value) || value.len % bytes != 0 ||
        (value.len > 0 && !(made = malloc(value.len))))
        return false;
    if (made)
        memcpy(made, value.data, value.len);
    free(*(void **)array);
    *(void **)array = made;
    *count = value.len / bytes;
    return true;
}

/* Reads one epoch, binds its scene anew, and appends it to the run. Returns false if it is damaged
 * or if the scene refuses a parameter. */
static bool get_epoch(struct run *run, const struct field_places *places, struct text text)
{
    struct epoch epoch = {0};
    struct scene scene = run->scene;
    struct error ignored;
    struct text start;
    memcpy(epoch.value, scene.value, sizeof epoch.value);
    if (!fields_get(text, epoch_fields, COUNT_OF(epoch_fields), &epoch) ||
        !field_find(text, "start", &start) || start.len > sizeof epoch.start ||
        !field_get_placed(text, "value", places, epoch.value, sizeof *epoch.value))
        return false;
    memcpy(epoch.start, start.data, start.len);
    memcpy(scene.value, epoch.value, sizeof scene.value);
    struct scene same = scene; /* scene_set() checks the values */
    for (size_t i = 0; i < scene_params(&scene)->count; i++)
        if (!scene_set(&same, (int)i, (struct measured){scene.value[i], 0}, &ignored))
            return false;
    struct epoch *place = scene_bind(&scene, &epoch.system, &ignored) ? run_push_epoch(run) : NULL;
    if (place)
        *place = epoch;
    return place;
}

/* Reads all epochs, in order. Returns false if one is damaged or if there is none. */
static bool get_epochs(struct run *run, const struct field_places *places, struct text text)
{
    struct run_private *p = run->private_state;
    struct text name, value;
    bool ok = true;
    p->epochs = 0;
    while (ok && field_next(&text, &name, &value))
        if (text_is(name, "epoch"))
            ok = get_epoch(run, places, value);
    return ok && p->epochs > 0;
}

/* Reads the trace, but for its rows. Returns false if fields are missing or values are out of
 * range. */
static bool get_trace(struct trace *trace, int n, struct text text)
{
    size_t grids = 0;
    const bool ok = fields_get(text, trace_fields, COUNT_OF(trace_fields), trace) &&
                    get_array(text, "grids", sizeof *trace->grid, &trace->grid, &grids) &&
                    grids > 0 && trace->now_step >= 0 && trace->every > 0 && trace->bucket > 0 &&
                    trace->mark_width <= sizeof(struct energy_tally) / sizeof(double) && n > 0;
    if (grids > 0)
        trace->grids = trace->grid_capacity = grids;
    return ok;
}

/* Reads the rows of the trace from pieces, which have to follow each other and contain all rows of
 * trace->count. Returns false if they do not, or if out of memory. */
static bool get_rows(struct run *run, const struct stored_rows *piece, size_t pieces)
{
    struct trace *trace = run->trace;
    const size_t bytes = run_row_bytes(run), count = trace->count;
    int64_t previous_step = 0;
    trace_clear_rows(trace);
    for (size_t i = 0; i < pieces && trace->count < count; i++) {
        if (piece[i].first != trace->count || piece[i].row_bytes != bytes)
            return false;
        for (size_t k = 0; k < piece[i].count && trace->count < count; k++) {
            double row[LIMIT_VARIABLES + 1];
            struct energy_tally mark = {0};
            int64_t step;
            const char *cursor = piece[i].cursor + k * bytes;
            memcpy(&step, cursor, sizeof step);
            if (step < previous_step || step > run->steps)
                return false;
            previous_step = step;
            memcpy(row, cursor + sizeof step, trace->width * sizeof *row);
            memcpy(&mark, cursor + sizeof step + trace->width * sizeof *row,
                   trace->mark_width * sizeof(double));
            if (!trace_put_row(trace, step, row, &mark))
                return false;
        }
    }
    return trace->count == count && count > 0;
}

/* Reads the responses of events and jumps. Returns false if they are missing or inconsistent. */
static bool get_responses(struct run *run, struct text text)
{
    struct responses *all = &run->private_state->responses;
    size_t slopes = 0;
    if (!get_array(text, "responses", sizeof *all->response, &all->response, &all->count) ||
        !get_array(text, "response_slopes", sizeof *all->slope, &all->slope, &slopes) ||
        slopes != all->count * (2 * (size_t)run->system.n + 1))
        return false;
    all->capacity = all->count;
    for (size_t i = 0; i < all->count; i++)
        if (all->response[i].variable >= run->system.n || all->response[i].variable < RESPONSE_MISS)
            return false;
    return true;
}

/* Reads the private parts of a run beside its rows and its memory. Returns false if they are
 * missing or if arrays that belong together differ in length. */
static bool get_private(struct run *run, struct text text)
{
    struct run_private *p = run->private_state;
    struct event_records *records = &p->event_records;
    size_t states = 0;
    const bool ok =
        fields_get(text, private_fields, COUNT_OF(private_fields), p) &&
        get_array(text, "saved", sizeof *p->saved, &p->saved, &p->saves) &&
        get_array(text, "events", sizeof *records->record, &records->record, &records->count) &&
        get_array(text, "event_states", sizeof *records->state, &records->state, &states) &&
        get_array(text, "kicks", sizeof *p->kick, &p->kick, &p->kicks) &&
        get_responses(run, text) && states == records->count * (size_t)run->system.n;
    p->save_capacity = p->saves;
    p->kick_capacity = p->kicks;
    records->capacity = records->count;
    return ok;
}

/* Puts the last epoch into force, as run_use_epoch() does, and then restores the memory of the
 * method and the propagator, so that the next step has the same bits. Returns false if they are
 * missing. */
static bool get_work(struct run *run, struct text text)
{
    struct run_private *p = run->private_state;
    const struct plan plan = run->plan;
    struct propagator_place place;
    struct text method_name, work;
    if (!field_find(text, "work", &work) || !field_find(text, "opinion_by", &method_name) ||
        work.len < work_size(run) * sizeof *p->work)
        return false;
    run_use_epoch(run);
    run->plan = plan;
    fields_get(text, private_fields, COUNT_OF(private_fields), p);
    memcpy(p->work, work.data, work_size(run) * sizeof *p->work);
    p->step.warm &= !(run->method->flags & METHOD_EXTERNAL);
    const struct row *method =
        method_name.len > 0 ? catalog_find(&method_catalog, method_name) : NULL;
    run->opinion.method = (const struct method *)(const void *)method;
    if (field_get(text, "propagator", &place, sizeof place) &&
        (p->propagator = propagator_create(run, place.h)))
        propagator_set_place(p->propagator, &place);
    return true;
}

/* Creates the run anew, and replaces its state by the stored one after checking it. */
struct run *run_restore(const struct scene *scene, const struct method *method, struct text text,
                        const struct field_places *places, const struct stored_rows *piece,
                        size_t pieces, struct error *error)
{
    struct run_settings settings;
    if (!run_settings_take(text, &settings)) {
        error_set(error, ERROR_IO, "it was written by another version");
        return NULL;
    }
    struct run *run = run_create(scene, method, &settings, HUGE_VAL, error);
    if (run && fields_get(text, run_fields, COUNT_OF(run_fields), run) &&
        get_epochs(run, places, text) && get_private(run, text) &&
        get_trace(run->trace, run->system.n, text) && run_is_sound(run) &&
        get_rows(run, piece, pieces) && get_work(run, text))
        return run;
    run_destroy(run);
    if (run)
        error_set(error, ERROR_IO, "some of it is damaged, or was written by another version");
    return NULL;
}
