/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stores the latest fits in the session's file, and reads them back with all checks that a foreign
 * file needs. */
#include "modules/recording/fits.h"

#include <hooke/session/read.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define OF_FITS(member) FIELD_OF(struct fits, member)
#define IN_FITS(member, least, most) FIELD_IN(struct fits, member, least, most)
/* Members of struct fits that are written as they are. */
static const struct field members[] = {
    OF_FITS(has_fit),
    OF_FITS(fit_of),
    IN_FITS(fit_zero, -DBL_MAX, DBL_MAX),
    OF_FITS(fit_free),
    IN_FITS(fit_modes, 0, MODES_MAX),
    OF_FITS(adopted.known),
    OF_FITS(adopted.exact),
    OF_FITS(adopted.subject),
    OF_FITS(adopted.statement),
};

#define OF_FIT(member) FIELD_OF(struct stored_fit, member)
/* Members of struct stored_fit that are written. */
static const struct field stored_fit_members[] = {
    OF_FIT(fit.period),
    OF_FIT(fit.omega),
    OF_FIT(fit.gamma),
    OF_FIT(fit.amplitude),
    OF_FIT(fit.phase),
    OF_FIT(fit.offset),
    OF_FIT(fit.rms),
    OF_FIT(fit.used),
    OF_FIT(fit.rejected),
    OF_FIT(fit.window),
    OF_FIT(fit.halves),
    OF_FIT(fit.half_periods),
    OF_FIT(fit.preferred),
    OF_FIT(fit.converged),
    OF_FIT(fit.iterations),
    OF_FIT(fit.autocorrelation),
    OF_FIT(fit.warning),
    OF_FIT(fit.warnings),
    OF_FIT(fit.t0),
    OF_FIT(fit.drift),
    OF_FIT(fit.drag),
    OF_FIT(fit.covariance),
    FIELD_OF_QUANTITY(struct stored_fit, quantity),
    OF_FIT(k),
    OF_FIT(exact),
    OF_FIT(statement),
    OF_FIT(subject),
};

/* ---- whether what was read can stand in a session ---- */

#define FIT_IN(member, least, most) FIELD_IN(struct fit, member, least, most)
/* Ranges that members of a fit must have in a session. */
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

/* Returns true if a fit that was read from a session file can be used: its enumerations, flags and
 * texts are valid. */
static bool sound_fit(const struct fit *fit)
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

/* Ranges that members of an adopted fit must have. */
static const struct field adopted_sound[] = {
    ALL_END(struct adopted_fit),
    FIELD_CALLED("of", struct adopted_fit, subject, 0, 0),
    FIELD_IN(struct adopted_fit, known.count, 0, CURVE_PARAMETERS),
    FIELD_IN(struct adopted_fit, known.index, 0, LIMIT_PARAMETERS - 1),
};

/* Returns true if an adopted fit that was read can be used in a session. */
static bool sound_adopted(const struct adopted_fit *adopted)
{
    bool sound = fields_sound(adopted_sound, COUNT_OF(adopted_sound), adopted);
    for (int i = 0; sound && adopted->scene.model && i < adopted->known.count; i++)
        sound = adopted->known.index[i] < (int)scene_params(&adopted->scene)->count;
    return sound;
}

static const struct field stored_fit_sound[] = {
    FIELD_CALLED("of", struct stored_fit, subject, 0, 0),
    ALL_END(struct stored_fit),
};

/* Returns true if a stored fit that was read can be used in a session. */
static bool sound_stored(const void *item)
{
    const struct stored_fit *fit = item;
    return fields_sound(stored_fit_sound, COUNT_OF(stored_fit_sound), item) && sound_fit(&fit->fit);
}

/* The array of stored fits; the name of each model is written separately. */
static const struct store_array stored_fits = {
    .name = "stored_fit",
    .offset = offsetof(struct fits, stored_fit),
    .item = sizeof(struct stored_fit),
    .count = offsetof(struct fits, stored_fits),
    .member = stored_fit_members,
    .members = COUNT_OF(stored_fit_members),
    .sound = sound_stored,
};

/* ---- writing ---- */

/* Gives the curve's times and values, which are stored as bytes. */
bool fits_content(void *part, struct text piece[2], uint64_t **sum)
{
    struct fits *fits = part;
    for (int i = 0; i < 2; i++)
        piece[i] = (struct text){(const char *)fits->fit_curve[i],
                                 fits->fit_samples * sizeof *fits->fit_curve[i]};
    *sum = &fits->fit_curve_sum;
    return fits->fit_samples > 0;
}

/* Appends the fits of a session for its file: last fit, stored fits, names of models, and the
 * fitted and adopted scenes. The curve is stored elsewhere and named by its checksum. */
void fits_put(const void *part, struct buffer *output)
{
    const struct fits *fits = part;
    fields_put(output, members, COUNT_OF(members), fits);
    store_tools()->put_array(&stored_fits, fits, output);
    if (fits->has_fit)
        field_text(output, "fit_model", text_of(fits->fit.model));
    struct stored_fit last = {.quantity = QUANTITY_NUMBER};
    memcpy(&last.fit, &fits->fit, sizeof last.fit);
    const size_t begun = field_begin(output, "last_fit");
    fields_put(output, stored_fit_members, COUNT_OF(stored_fit_members), &last);
    field_end(output, begun);
    for (int i = 0; i < fits->stored_fits; i++)
        field_text(output, "stored_model", text_of(fits->stored_fit[i].fit.model));
    if (fits->fit_samples > 0)
        field_put(output, "fit_curve", &fits->fit_curve_sum, sizeof fits->fit_curve_sum);
    if (fits->has_fit && fits->fit_scene.model)
        store_tools()->put_scene(&fits->fit_scene, "fit_scene", output);
    if (fits->adopted.scene.model)
        store_tools()->put_scene(&fits->adopted.scene, "adopted_scene", output);
}

/* ---- reading ---- */

/* Returns the program's constant for a name of a model, which outlives the file's text. */
static const char *model_name(struct text name)
{
    static const char *const others[] = {"scene", "modes", "formula"};
    const struct row *row = catalog_find(&fit_catalog, name);
    for (size_t i = 0; i < COUNT_OF(others) && !row; i++)
        if (text_is(name, others[i]))
            return others[i];
    return row ? row->name : "fit";
}

/* Reads the curve of the last fit; leaves it empty if it is missing or out of memory. */
static void read_curve(const struct reader *reader, struct fits *fits)
{
    struct text times, values;
    uint64_t sum = 0;
    if (!field_get(reader->state, "fit_curve", &sum, sizeof sum) ||
        !store_tools()->bytes(reader, sum, &times))
        return;
    times.len /= 2;
    values = (struct text){times.data + times.len, times.len};
    if (times.len % sizeof(double) != 0)
        return;
    double *t = malloc(times.len + 1), *y = malloc(values.len + 1);
    if (!t || !y) {
        free(t);
        free(y);
        return;
    }
    memcpy(t, times.data, times.len);
    memcpy(y, values.data, values.len);
    fits->fit_curve[0] = t;
    fits->fit_curve[1] = y;
    fits->fit_samples = times.len / sizeof *t;
    fits->fit_curve_sum = sum;
}

/* Moves the indices of known parameters to those of the present program; drops the covariances if a
 * parameter does not exist. */
static void move_adopted(const struct field_places *places, struct adopted_fit *adopted)
{
    for (int i = 0; i < adopted->known.count; i++) {
        const int old = adopted->known.index[i], row = old < places->count ? places->row[old] : -1;
        adopted->known.index[i] = row;
        if (row < 0)
            adopted->known.count = 0;
    }
}

/* Reads the last fit. Returns false if it is missing or damaged. */
static bool read_last_fit(const struct reader *reader, struct fit *fit)
{
    struct text text;
    struct stored_fit last = {.quantity = QUANTITY_NUMBER};
    if (!field_find(reader->state, "last_fit", &text) ||
        !fields_get_known(text, stored_fit_members, COUNT_OF(stored_fit_members), &last))
        return false;
    memcpy(fit, &last.fit, sizeof *fit);
    return true;
}

/* Reads the last fit, its curve, the stored fits, and the fitted and the adopted scene; what is
 * damaged is left out with a note. */
void fits_read(struct reader *reader)
{
    struct session *session = reader->session;
    struct text text = reader->state, name, value;
    if (!field_find(text, "last_fit", &value))
        return;
    struct fits *fits = session_part(session, &recording_module);
    if (!fits)
        return;
    store_tools()->array(reader, &stored_fits, fits);
    if (!fields_get_known(text, members, COUNT_OF(members), fits))
        store_tools()->note(reader, "some values of fits are left out because they are damaged");
    struct error why = {0};
    int stored = 0;
    fits->has_fit &= read_last_fit(reader, &fits->fit);
    if (!sound_fit(&fits->fit)) {
        store_tools()->note(reader, "the last fit is left out because it is damaged");
        fits->has_fit = false;
        memset(&fits->fit, 0, sizeof fits->fit);
    }
    fits->fit.model = NULL;
    if (fits->has_fit)
        fits->fit.model = model_name(field_find(text, "fit_model", &value) ? value : TEXT(""));
    for (int i = 0; i < fits->stored_fits; i++)
        fits->stored_fit[i].fit.model = "fit";
    while (field_next(&text, &name, &value))
        if (text_is(name, "stored_model") && stored < fits->stored_fits)
            fits->stored_fit[stored++].fit.model = model_name(value);
    read_curve(reader, fits);
    struct setup setup;
    struct field_places places;
    /* store_tools()->scene() reads into the session's set-up, which is restored below. */
    memcpy(&setup, &session->setup, sizeof setup);
    bool fine = true;
    if (field_find(reader->state, "fit_scene", &value)) {
        fine = store_tools()->scene(reader, reader->state, "fit_scene", &fits->fit_scene, &places,
                                    &why);
        if (fine)
            store_tools()->move(&places, fits->fit_free, sizeof *fits->fit_free);
    }
    if (fine && field_find(reader->state, "adopted_scene", &value)) {
        fine = store_tools()->scene(reader, reader->state, "adopted_scene", &fits->adopted.scene,
                                    &places, &why);
        if (fine)
            move_adopted(&places, &fits->adopted);
    }
    if (!fine)
        store_tools()->note(reader, "the scene of the last fit is left out: %s", why.text);
    memcpy(&session->setup, &setup, sizeof setup);
    if (!sound_adopted(&fits->adopted)) {
        store_tools()->note(reader, "the adopted fit is left out because it is damaged");
        fits->adopted = (struct adopted_fit){.subject = ""};
    }
}
