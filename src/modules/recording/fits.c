/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The latest fits, which a session keeps in this module's part. */
#include "modules/recording/fits.h"

#include <hooke/base/numeric.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns an empty set of fits if the session has made none. */
const struct fits *fits_of(const struct session *session)
{
    static const struct fits none;
    const struct fits *fits = session_part_if_made(session, &recording_module);
    return fits ? fits : &none;
}

struct fits *fits_made(const struct session *session)
{
    return session_part_if_made(session, &recording_module);
}

struct fits *fits_make(const struct session *session, struct error *error)
{
    struct fits *fits = session_part(session, &recording_module);
    if (!fits)
        error_memory(error);
    return fits;
}

/* Frees the curve of the last fit and forgets the scene and the modes to which it belongs. */
void fits_drop_curve(struct fits *fits)
{
    free(fits->fit_curve[0]);
    free(fits->fit_curve[1]);
    fits->fit_curve[0] = fits->fit_curve[1] = NULL;
    fits->fit_samples = 0;
    fits->fit_curve_sum = 0;
    fits->fit_scene.model = NULL;
    fits->fit_modes = 0;
}

void fits_free(void *part)
{
    struct fits *fits = part;
    free(fits->stored_fit);
    fits_drop_curve(fits);
    fits_drop_band(fits);
}

bool fits_use(const void *part, const struct model *model)
{
    const struct fits *fits = part;
    return scene_uses(&fits->fit_scene, model) || scene_uses(&fits->adopted.scene, model) ||
           scene_uses(&fits->band.adopted.scene, model);
}

/* Stores a fit for the report, replacing that of the same model, subject and window; beyond
 * LIMIT_FITS the oldest is dropped. */
void session_store_fit(struct session *session, const struct stored_fit *fit)
{
    struct error ignored;
    struct fits *fits = fits_make(session, &ignored);
    struct stored_fit *stored = NULL;
    if (!fits)
        return;
    for (int i = 0; i < fits->stored_fits; i++)
        if (strcmp(fits->stored_fit[i].subject, fit->subject) == 0 &&
            strcmp(fits->stored_fit[i].fit.model, fit->fit.model) == 0 &&
            memcmp(fits->stored_fit[i].fit.window, fit->fit.window, sizeof fit->fit.window) == 0)
            stored = &fits->stored_fit[i];
    if (!stored && fits->stored_fits == LIMIT_FITS) {
        stored = &fits->stored_fit[LIMIT_FITS - 1];
        memmove(fits->stored_fit, fits->stored_fit + 1,
                (LIMIT_FITS - 1) * sizeof *fits->stored_fit);
    } else if (!stored) {
        struct stored_fit *larger =
            realloc(fits->stored_fit, ((size_t)fits->stored_fits + 1) * sizeof *fits->stored_fit);
        if (!larger)
            return;
        fits->stored_fit = larger;
        stored = &larger[fits->stored_fits++];
    }
    *stored = *fit;
    stored->statement = session->history.count;
}

void fits_drop_band(struct fits *fits)
{
    free(fits->band.half);
    fits->band = (struct fit_band){.half = NULL};
}

/* Returns the value of the kept curve at t by linear interpolation, or NAN outside of its
 * samples. */
static double curve_value(const struct fits *fits, double t)
{
    const double *time = fits->fit_curve[0], *value = fits->fit_curve[1];
    const size_t low = first_from(time, fits->fit_samples, t);
    if (low < fits->fit_samples && time[low] == t)
        return value[low];
    if (low == 0 || low == fits->fit_samples)
        return NAN;
    const double fraction = (t - time[low - 1]) / (time[low] - time[low - 1]);
    return value[low - 1] + fraction * (value[low] - value[low - 1]);
}

/* Interpolates in the stored curve if there is one; else computes the fitted motion. */
void session_fit_values(const struct session *session, const double *t, size_t n, double *value)
{
    const struct fits *fits = fits_of(session);
    if (fits->fit_samples == 0)
        fit_values(&fits->fit, t, n, value);
    for (size_t i = 0; i < n && fits->fit_samples > 0; i++)
        value[i] = curve_value(fits, t[i]);
}
