/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module recording: reads, cleans, measures and fits files of sensors, and adopts fits into the
 * scene. Its functions for the core are in struct series_tools. */
#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"
#include "modules/recording/plots.h"

#include <math.h>

/* Returns the amplitude of a series at t [s], or NAN. */
static double amplitude_at(const struct series *series, double t, struct arena *arena)
{
    struct reading reading;
    struct error ignored;
    return series_amplitudes(series, arena, &t, 1, 0, &reading, &ignored) ? reading.amplitude.value
                                                                          : NAN;
}

/* Sets *used to the length of the formula at the start of the text. Returns false with the error if
 * there is none. */
static bool formula_length(struct text text, struct arena *arena, size_t *used, struct error *error)
{
    struct formula formula;
    return formula_compile(text, NULL, NULL, 0, arena, &formula, used, error);
}

static const struct series_tools tools = {
    .overview = series_overview,
    .crossings = series_crossings,
    .amplitude = amplitude_at,
    .period = series_period,
    .run_period = find_run_period,
    .describe = recording_describe,
    .errors = recording_errors,
    .motion = data_motion,
    .frequency = motion_frequency,
    .distance = find_distance,
    .is_fitted = recording_is_fitted,
    .table = export_recorded,
    .draw_band = drawing_band,
    .draw_stored_band = drawing_stored_band,
    .export_band = export_band,
    .unit = unit_spelled,
    .formula = formula_length,
};

/* Names that 'help NAME' knows. */
static const struct catalog *const catalogs[] = {&fit_catalog, &format_catalog, &drag_law_catalog,
                                                 NULL};

const struct module recording_module = {
    .row = {"recording", "", "load, clean, measure, fit and adopt recordings", "", NULL},
    .needs = "solving",
    .part_size = sizeof(struct fits),
    .part_free = fits_free,
    .part_uses = fits_use,
    .store = {.put = fits_put, .content = fits_content, .read = fits_read},
    .series = &tools,
    .statement_ended = session_store_band,
    .plan = band_plan,
    .catalogs = catalogs,
};
