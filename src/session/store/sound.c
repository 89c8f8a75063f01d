/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Whether what was read of a session can stand in one: anybody can write its file, checksums and
 * all. Values may be any, but those that a command would refuse; counts, places, flags and choices
 * are what the rest of the program goes by.
 */
#include <hooke/session/read.h>

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

/* ---- settings ---- */

#define SETTING_IN(member, least, most) FIELD_IN(struct settings, member, least, most)
static const struct field settings_sound[] = {
    SETTING_IN(duration, DBL_TRUE_MIN, FAR),
    SETTING_IN(dt, DBL_TRUE_MIN, FAR),
    SETTING_IN(tol, 0, 1),
    SETTING_IN(record.rule, RECORD_AUTO, RECORD_TIMES),
    SETTING_IN(record.every, 1, 1e15),
    SETTING_IN(record.interval, 0, FAR),
    SETTING_IN(digits, 1, 17),
    SETTING_IN(width, 0, 1000),
    SETTING_IN(height, 0, 1000),
    SETTING_IN(fps, 0.1, 60),
};

bool sound_setting(const struct setting *setting, const struct settings *settings)
{
    const size_t from = setting->offset, to = from + setting->bytes;
    const struct recording_rule *rule = &settings->record;
    int choice = 0;
    if (setting->choices && setting->bytes == sizeof choice)
        memcpy(&choice, (const char *)settings + from, sizeof choice);
    if (choice < 0 || (choice > 0 && (size_t)choice >= setting->choices->count))
        return false;
    for (size_t i = 0; i < COUNT_OF(settings_sound); i++)
        if (settings_sound[i].offset >= from && settings_sound[i].offset < to &&
            !fields_sound(&settings_sound[i], 1, settings))
            return false;
    return rule->rule != RECORD_TIMES || rule->interval > 0;
}

/* ---- arrays ---- */

#define ENDS(type, i) FIELD_OF(type, exact.name[i])
#define ALL_END(type)                                                                              \
    ENDS(type, 0), ENDS(type, 1), ENDS(type, 2), ENDS(type, 3), ENDS(type, 4), ENDS(type, 5),      \
        ENDS(type, 6), ENDS(type, 7)

static const struct field value_sound[] = {
    FIELD_OF(struct named_value, name),
    FIELD_IN(struct named_value, quantity, QUANTITY_NUMBER, QUANTITY_COUNT - 1),
};

static const struct field measurement_sound[] = {
    FIELD_OF(struct measurement, quantity),
    FIELD_OF(struct measurement, of),
    FIELD_OF(struct measurement, energy),
    ALL_END(struct measurement),
    FIELD_IN(struct measurement, unit, QUANTITY_NUMBER, QUANTITY_COUNT - 1),
};

static const struct field stored_fit_sound[] = {
    FIELD_OF(struct stored_fit, of),
    ALL_END(struct stored_fit),
    FIELD_IN(struct stored_fit, quantity, QUANTITY_NUMBER, QUANTITY_COUNT - 1),
};

bool sound_item(const struct store_array *array, const void *item)
{
    const struct stored_fit *fit = item;
    if (array->offset == offsetof(struct session, measurement))
        return fields_sound(measurement_sound, COUNT_OF(measurement_sound), item);
    if (array->offset == offsetof(struct session, stored_fit))
        return fields_sound(stored_fit_sound, COUNT_OF(stored_fit_sound), item) &&
               sound_fit(&fit->fit);
    return fields_sound(value_sound, COUNT_OF(value_sound), item);
}

/* ---- fits ---- */

#define FIT_IN(member, least, most) FIELD_IN(struct fit, member, least, most)
static const struct field fit_sound[] = {
    FIT_IN(preferred, LAW_NONE, LAW_UNDECIDED),
    FIT_IN(converged, 0, 1),
    FIT_IN(warnings, 0, 8),
    FIT_IN(drag.candidates, 0, DRAG_LAWS),
    FIT_IN(drag.best, LAW_NONE, LAW_UNDECIDED),
    FIT_IN(drag.remaining, 0, (1 << DRAG_LAWS) - 1),
    FIT_IN(drag.motion.order, 0, 2),
    FIT_IN(drag.motion.force, RESTORING_LINEAR, RESTORING_SINE),
    FIT_IN(drag.forces, 0, RESTORING_FORCES),
    FIT_IN(drag.force, RESTORING_LINEAR, RESTORING_SINE),
    FIT_IN(drag.forces_remaining, 0, (1 << RESTORING_FORCES) - 1),
    FIT_IN(drag.said, 0, 0),
    FIT_IN(covariance.n, 0, CURVE_PARAMETERS),
};

bool sound_fit(const struct fit *fit)
{
    const struct field law = FIELD_IN(struct drag_candidate, law, LAW_NONE, LAW_UNDECIDED),
                       converged = FIELD_OF(struct drag_candidate, converged),
                       restored = FIELD_OF(struct restoring_candidate, converged);
    bool sound = fields_sound(fit_sound, COUNT_OF(fit_sound), fit);
    for (size_t i = 0; i < COUNT_OF(fit->warning); i++)
        sound = sound && memchr(fit->warning[i], 0, sizeof fit->warning[i]);
    for (size_t i = 0; i < DRAG_LAWS; i++)
        sound = sound && fields_sound(&law, 1, &fit->drag.candidate[i]) &&
                fields_sound(&converged, 1, &fit->drag.candidate[i]);
    for (size_t i = 0; i < RESTORING_FORCES; i++)
        sound = sound && fields_sound(&restored, 1, &fit->drag.restoring[i]);
    return sound;
}

static const struct field adopted_sound[] = {
    ALL_END(struct adopted_fit),
    FIELD_OF(struct adopted_fit, of),
    FIELD_IN(struct adopted_fit, known.count, 0, CURVE_PARAMETERS),
    FIELD_IN(struct adopted_fit, known.index, 0, LIMIT_PARAMETERS - 1),
};

bool sound_adopted(const struct adopted_fit *adopted)
{
    bool sound = fields_sound(adopted_sound, COUNT_OF(adopted_sound), adopted);
    for (int i = 0; sound && adopted->scene.model && i < adopted->known.count; i++)
        sound = adopted->known.index[i] < (int)scene_params(&adopted->scene)->count;
    return sound;
}

/* ---- scenes: what their commands would take ---- */

bool sound_scene(const struct scene *scene)
{
    const struct field flags[] = {FIELD_OF(struct scene, chosen), FIELD_OF(struct scene, across)},
                       atol = FIELD_IN(struct scene, atol, 0, DBL_MAX);
    struct scene same = *scene;
    struct error ignored;
    bool sound = fields_sound(flags, COUNT_OF(flags), scene) && fields_sound(&atol, 1, scene);
    for (size_t i = 0; i < scene_params(scene)->count && sound; i++) {
        const struct measured value = {scene->value[i], scene->uncertainty[i]};
        sound = scene_set(&same, (int)i, value, &ignored);
    }
    return sound;
}

/* ---- the view ---- */

#define CURSORS_IN(member, least, most) FIELD_IN(struct view, cursors.member, least, most)
static const struct field view_sound[] = {
    CURSORS_IN(shown, 0, 1),
    CURSORS_IN(plane, 0, 1),
    CURSORS_IN(on_data, 0, 1),
    CURSORS_IN(active, 0, 1),
    CURSORS_IN(locked, 0, 1),
    CURSORS_IN(at[0].set, 0, 1),
    CURSORS_IN(at[1].set, 0, 1),
    CURSORS_IN(at[0].crossing, 0, INT_MAX / 2),
    CURSORS_IN(at[1].crossing, 0, INT_MAX / 2),
    CURSORS_IN(snap, SNAP_CROSSING, SNAP_NONE),
    CURSORS_IN(of, 0, 0),
    CURSORS_IN(quantity, QUANTITY_NUMBER, QUANTITY_COUNT - 1),
};

static bool sound_range(const double range[2])
{
    return (isnan(range[0]) && isnan(range[1])) ||
           (isfinite(range[0]) && isfinite(range[1]) && range[0] < range[1]);
}

bool sound_view(const struct view *view)
{
    bool sound = fields_sound(view_sound, COUNT_OF(view_sound), view) && sound_range(view->x) &&
                 sound_range(view->y);
    for (int i = 0; i < view->starts && sound; i++)
        for (int j = 0; j < view->start_n && sound; j++)
            sound = isfinite(view->start[i][j]);
    return sound;
}

/* ---- recordings ---- */

bool sound_field(const struct recording_field *field, struct text value)
{
    struct recording of = {.cleaned = false};
    bool cleaned;
    if (value.len != field->bytes)
        return false;
    if (field->offset == offsetof(struct recording, cleaned))
        return fields_sound(&(struct field){"", 0, sizeof cleaned, FIELD_BOOLS, 0, 0}, 1, value.at);
    memcpy((char *)&of + field->offset, value.at, value.len);
    return isfinite(of.window[0]) && isfinite(of.window[1]) && of.window[0] <= of.window[1] &&
           isfinite(of.zero) && isfinite(of.mass.value) && of.mass.value >= 0 &&
           isfinite(of.mass.uncertainty) && of.mass.uncertainty >= 0 &&
           memchr(of.velocity, 0, sizeof of.velocity);
}

/* ---- what was asked of a run ---- */

bool sound_asked(const struct asked *asked, const struct scene *scene)
{
    const int params = (int)scene_params(scene)->count;
    return asked->kind >= REQUEST_GO && asked->kind <= REQUEST_BACK && asked->param >= 0 &&
           asked->param < (asked->kind == REQUEST_SET ? params : LIMIT_VARIABLES) &&
           asked->by_event >= 0 && asked->by_event <= 1 && asked->from >= 0 && asked->end >= 0 &&
           asked->met >= 0 && asked->rows >= 0 && !isnan(asked->t) && !isnan(asked->from_t);
}
