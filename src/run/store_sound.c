/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks of a run that was read from a file, which anybody can write, with valid checksums. Values
 * of the motion may be any numbers; counts, indices, flags and enums may not, because other parts
 * of the program rely on them. The tables give the limits of members. */
#include "run/store_private.h"

#include <float.h>

#define SETTING_IN(member, least, most) FIELD_IN(struct run_settings, member, least, most)
static const struct field settings_sound[] = {
    SETTING_IN(dt, DBL_TRUE_MIN, DBL_MAX),
    SETTING_IN(tol, 0, DBL_MAX),
    SETTING_IN(drag, DRAG_DEFAULT, DRAG_COUNT - 1),
    SETTING_IN(kernel, KERNEL_PROPAGATOR, KERNEL_GENERAL),
    SETTING_IN(compensated, 0, 1),
    SETTING_IN(record.rule, RECORD_AUTO, RECORD_TIMES),
    SETTING_IN(unbalanced, 0, 1),
    SETTING_IN(memory, 0, 0x1p50),
};

#define RUN_IN(member, least, most) FIELD_IN(struct run, member, least, most)
static const struct field run_sound[] = {
    RUN_IN(name, 0, 0),
    RUN_IN(steps, 0, LIMIT_STEPS),
    RUN_IN(t, -DBL_MAX, DBL_MAX),
    RUN_IN(seconds, 0, DBL_MAX),
    RUN_IN(stop, STOP_NONE, STOP_GIVEN_UP),
    RUN_IN(singular.finite, 0, 1),
    RUN_IN(controller.sampling, 0, 1),
    RUN_IN(controller.rejected, 0, 1),
    RUN_IN(controller.switches.known, 0, 1),
    RUN_IN(controller.switches.begins, 0, 1),
    RUN_IN(controller.switches.piled, 0, 1),
    RUN_IN(controller.switches.fresh, -1, LIMIT_SWITCHES - 1),
    RUN_IN(controller.switches.shorter, 0, INT32_MAX / 2),
    RUN_IN(controller.switches.recent, 0, 1),
    RUN_IN(controller.switches.slides_along, 0, 1),
    RUN_IN(controller.switches.released, -1, LIMIT_SWITCHES - 1),
    RUN_IN(controller.switches.slid_along, 0, 1),
    RUN_IN(controller.switches.slides, 0, LIMIT_STEPS),
    RUN_IN(controller.switches.piles, 0, LIMIT_STEPS),
    RUN_IN(controller.switches.crossings, 0, LIMIT_STEPS),
    RUN_IN(controller.switches.first, 0, LIMIT_SWITCHES - 1),
};

#define PLAN_IN(member) FIELD_OF(struct plan, member)
static const struct field plan_sound[] = {
    PLAN_IN(adaptive), PLAN_IN(propagates), PLAN_IN(exact_known),
    PLAN_IN(ledger),   PLAN_IN(exact_end),
};

#define PRIVATE_IN(member, least, most) FIELD_IN(struct run_private, member, least, most)
static const struct field private_sound[] = {
    PRIVATE_IN(step.warm, 0, 1),
    PRIVATE_IN(step.again, 0, 1),
    PRIVATE_IN(checks, 0, 0x1p50),
    PRIVATE_IN(factor, DBL_TRUE_MIN, DBL_MAX),
    PRIVATE_IN(balance.step, 0, LIMIT_STEPS),
};

#define TRACE_IN(member, least, most) FIELD_IN(struct trace, member, least, most)
static const struct field trace_sound[] = {
    TRACE_IN(every, 1, LIMIT_STEPS),    TRACE_IN(next, 0, 2 * LIMIT_STEPS),
    TRACE_IN(bucket, 1, LIMIT_STEPS),   TRACE_IN(tail_end, 0, 2 * LIMIT_STEPS),
    TRACE_IN(interval, 0, DBL_MAX),     TRACE_IN(ahead, -1, 1),
    TRACE_IN(now_step, 0, LIMIT_STEPS), TRACE_IN(count, 1, LIMIT_STEPS),
};

/* Reads the settings and checks their ranges. */
bool run_settings_take(struct text text, struct run_settings *settings)
{
    struct run_settings read;
    if (!field_get(text, "settings", &read, sizeof read) ||
        !fields_sound(settings_sound, COUNT_OF(settings_sound), &read))
        return false;
    const struct recording_rule *rule = &read.record;
    if ((rule->rule == RECORD_EVERY && !(rule->every >= 1 && (double)rule->every <= LIMIT_STEPS)) ||
        (rule->rule == RECORD_TIMES && !(rule->interval > 0 && rule->interval <= DBL_MAX)))
        return false;
    memcpy(settings, &read, sizeof read);
    return true;
}

/* Returns true if the epochs follow each other, and each suits the method and the settings. */
static bool epochs_sound(const struct run *run)
{
    const struct run_private *p = run->private_state;
    const bool adapts = run->settings.tol > 0 && run->method->flags & METHOD_ADAPTIVE;
    bool sound = p->epoch[0].first == 0;
    for (size_t i = 0; i < p->epochs && sound; i++) {
        const struct epoch *epoch = &p->epoch[i];
        const struct plan *plan = &epoch->plan;
        enum drag drag = epoch->drag;
        struct error ignored;
        sound = drag < DRAG_COUNT && fields_sound(plan_sound, COUNT_OF(plan_sound), plan) &&
                method_applies(run->method, &epoch->system, &drag, &ignored) &&
                drag == epoch->drag && plan->adaptive == adapts &&
                (!plan->propagates ||
                 plan_propagates(&epoch->system, run->method, &run->settings, adapts)) &&
                (!plan->exact_known || system_has_exact(&epoch->system)) &&
                epoch->first <= run->steps && (i == 0 || epoch->first > p->epoch[i - 1].first);
    }
    return sound;
}

/* Returns true if row numbers, steps and grids of the trace are consistent with each other and with
 * the recording rule. */
static bool trace_places_sound(const struct run *run)
{
    const struct trace *trace = run->trace;
    const struct recording_rule *rule = &run->settings.record;
    const size_t count = trace->count;
    if (!fields_sound(trace_sound, COUNT_OF(trace_sound), trace) ||
        (trace->bucket & (trace->bucket - 1)) != 0 || (trace->bucket > 1 && !trace->decimates) ||
        (trace->bucket > 1 &&
         (trace->tail >= count || trace->low >= count || trace->high >= count)) ||
        (trace->interval > 0) != (rule->rule == RECORD_TIMES) ||
        (trace->interval > 0 && trace->ahead == 0) || trace->now_step > run->steps ||
        count > trace->cap ||
        (trace->every != 1 && rule->rule != RECORD_EVERY && rule->rule != RECORD_TIMES))
        return false;
    bool sound = trace->grid[0].first == 0;
    for (size_t i = 0; i < trace->grids && sound; i++)
        sound = trace->grid[i].first <= run->steps && isfinite(trace->grid[i].h) &&
                (i == 0 || trace->grid[i].first >= trace->grid[i - 1].first);
    return sound && (trace_indexed(trace) || (int64_t)(count - 1) <= run->steps / trace->every);
}

/* Checks all tables of limits, and what members have to agree on. */
bool run_is_sound(const struct run *run)
{
    const struct run_private *p = run->private_state;
    const struct event_records *records = &p->event_records;
    const size_t rows = run->trace->count;
    bool sound = fields_sound(run_sound, COUNT_OF(run_sound), run) &&
                 fields_sound(plan_sound, COUNT_OF(plan_sound), &run->plan) &&
                 fields_sound(private_sound, COUNT_OF(private_sound), p) &&
                 trace_places_sound(run) && epochs_sound(run) && run->unsound.variable >= 0 &&
                 run->unsound.variable < run->system.n && p->look >= 0 && p->searched <= rows &&
                 p->balance.step <= run->steps &&
                 p->saves <= (size_t)(run->steps >> CHUNK_SHIFT) + 1;
    for (size_t i = 0; i < COUNT_OF(p->doubt) && sound; i++)
        sound =
            fields_sound(&(struct field)FIELD_OF(struct event_doubt, is_close), 1, &p->doubt[i]);
    for (size_t i = 0; i < records->count && sound; i++) {
        const struct event_record *record = &records->record[i];
        sound = record->event >= 0 && record->event < LIMIT_EVENTS && record->direction >= -1 &&
                record->direction <= 1 && record->step >= 0 && record->step <= run->steps;
    }
    for (size_t i = 0; i < p->kicks && sound; i++)
        sound = p->kick[i].step >= 0 && p->kick[i].step <= run->steps &&
                (i == 0 || p->kick[i].step >= p->kick[i - 1].step);
    return sound;
}
