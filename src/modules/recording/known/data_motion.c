/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Velocity and energy of a recording of positions (data_motion()). */
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Gap between two velocities of the sensor, in steps, across which no straight line is drawn. */
#define VELOCITY_GAP_STEPS 1.5

/* Compares the recording's name with that in the subject of the last fit, 'data NAME'. */
bool recording_is_fitted(const struct session *session, const struct recording *recording)
{
    const struct text subject = text_of(fits_of(session)->fit_of);
    return fits_of(session)->has_fit && text_starts(subject, TEXT("data ")) &&
           text_is(text_after(subject, 5), recording->name);
}

/* Prefers the fit, then the period of a growing recording, then the spectrum. */
double motion_frequency(const struct session *session, const struct recording *recording,
                        const struct series *series, struct arena *arena)
{
    if (recording_is_fitted(session, recording))
        return fits_of(session)->fit.omega.value;
    if (session_grows(session, recording)) /* recomputed at intervals while rows arrive */
        return TWO_PI / session->growing->steady;
    return series_peak_frequency(series, arena);
}

/* ---- velocities ---- */

/* Sets the velocities of *motion to those of the recording that was joined, interpolated between
 * its samples by straight lines. MotionSensor.vi writes backward differences, which belong to half
 * a step earlier. Returns false with the error if that recording is missing or has no times in
 * common. */
static bool sensor_velocity(const struct session *session, const struct recording *recording,
                            struct arena *arena, struct data_motion *motion, struct error *error)
{
    const int index = session_find_recording(session, text_of(recording->velocity));
    struct series s;
    if (index < 0) {
        error_set(error, ERROR_COMMAND, "the velocities of %s came from %s, which was dropped",
                  recording->name, recording->velocity);
        return error_hint(error, "'data restore' computes the velocities from the positions again");
    }
    struct recording whole = *session->recording[index]->recording; /* its arrays are shared */
    const bool backward = strcmp(whole.format, "motion-sensor") == 0;
    whole.window[0] = whole.t[0];
    whole.window[1] = whole.t[whole.rows - 1];
    if (!recording_series(&whole, arena, 2, &s, error))
        return false;
    const double shift = backward ? 0.5 * whole.dt : 0;
    size_t known = 0, row = 0;
    for (size_t i = 0; i < motion->n; i++) {
        const double t = motion->t[i] + shift;
        while (row + 2 < s.n && s.t[row + 1] < t)
            row++;
        const double step = s.t[row + 1] - s.t[row], part = (t - s.t[row]) / step;
        const bool there =
            part >= -1e-6 && part <= 1 + 1e-6 && step < VELOCITY_GAP_STEPS * whole.dt;
        motion->v[i] = there ? s.y[row] + part * (s.y[row + 1] - s.y[row]) : NAN;
        known += there;
    }
    if (known < 2)
        return error_set(error, ERROR_COMMAND,
                         "%s and %s have no times in common: %.6g..%.6g s and %.6g..%.6g s",
                         recording->name, whole.name, motion->t[0], motion->t[motion->n - 1],
                         s.t[0], s.t[s.n - 1]);
    motion->gain = sqrt(0.5) / whole.dt; /* the mean of two neighbouring differences */
    snprintf(motion->how_v, sizeof motion->how_v, "v of the sensor (%s%s)", whole.name,
             backward ? ", backward differences: half a step earlier" : "");
    return true;
}

/* Sets velocities, gain of their noise and loss of amplitude in *motion by parabolas through some
 * samples of the positions. Returns false with the error. */
static bool computed_velocity(const struct series *series, struct arena *arena,
                              struct data_motion *motion, struct error *error)
{
    struct derivative d;
    if (!series_derivative(series, DERIVATIVE_POINTS, arena, &d, error))
        return false;
    motion->v = d.value;
    motion->gain = d.gain;
    motion->loss = isfinite(motion->omega) ? derivative_loss(&d, motion->omega) : 0;
    snprintf(motion->how_v, sizeof motion->how_v,
             "v from parabolas through %d samples (%.2g %% too small)", d.points,
             100 * motion->loss);
    return true;
}

/* ---- energy ---- */

/* Sets mass and spring constant: the recording's or the scene's mass, the fit's or the scene's
 * constant. Returns false with the error if the scene has no spring. */
static bool find_spring(const struct session *session, const struct recording *recording,
                        struct data_motion *motion, struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    if (!needs_spring(scene, "the energy of a recording", error))
        return false;
    const int m = scene_param(scene, "m"), k = scene_param(scene, "k");
    const bool own = recording->mass.value > 0, fit = recording_is_fitted(session, recording);
    motion->mass =
        own ? recording->mass : (struct measured){scene->value[m], scene->uncertainty[m]};
    motion->k = fit ? fit_stiffness(&fits_of(session)->fit, motion->mass)
                    : (struct measured){scene->value[k], scene->uncertainty[k]};
    const char *of_scene = fit ? " of the scene" : "";
    const char *source = own ? " of the recording" : of_scene;
    snprintf(motion->how_k, sizeof motion->how_k,
             fit ? "m = %s%s, k = %s of the fit" : "m = %s%s, k = %s of the scene",
             SHOWN_MEASURED(motion->mass, QUANTITY_MASS, 5), source,
             SHOWN_MEASURED(motion->k, QUANTITY_STIFFNESS, 5));
    return true;
}

/* Sets *use [n] to 0 for rows that the fit of a damped sine leaves out as bad samples, else to 1.
 * Returns false if out of memory. */
static bool find_good_rows(const struct session *session, const struct recording *recording,
                           const struct series *s, struct arena *arena, unsigned char **use)
{
    *use = arena_alloc(arena, s->n + 1);
    if (*use && (session_grows(session, recording) || !series_outliers(s, arena, *use)))
        memset(*use, 1, s->n);
    return *use;
}

/* Computes the velocities from the rows with use[row] set; those of the others are NAN. Returns
 * false with the error. */
static bool good_velocity(const struct series *all, const unsigned char *use, struct arena *arena,
                          struct data_motion *motion, struct error *error)
{
    double *t = arena_array(arena, all->n + 1, sizeof *t),
           *y = arena_array(arena, all->n + 1, sizeof *y);
    struct series good = *all;
    size_t k = 0;
    if (!t || !y)
        return error_memory(error);
    good.t = t;
    good.y = y;
    good.n = 0;
    for (size_t i = 0; i < all->n; i++)
        if (use[i]) {
            t[good.n] = all->t[i];
            y[good.n++] = all->y[i];
        }
    double *v = motion->v;
    if (!computed_velocity(&good, arena, motion, error))
        return false;
    for (size_t i = 0; i < all->n; i++)
        v[i] = use[i] ? motion->v[k++] : NAN;
    motion->v = v;
    return true;
}

/* Computes in *motion the velocities of a recording, from its sensor or its positions, and with
 * `energy` also its energies, by mass and spring constant. `series` holds the samples; NULL means
 * all in the window. The middle of the motion is the fitted offset, that of a growing recording, or
 * the mean. Arrays are in the arena; rejected samples are NAN. Returns false with the error. */
bool data_motion(const struct session *session, const struct recording *recording,
                 const struct series *series, bool energy, struct arena *arena,
                 struct data_motion *motion, struct error *error)
{
    struct series own;
    *motion = (struct data_motion){.omega = NAN};
    if (!series && !recording_series(recording, arena, 2, &own, error))
        return false;
    const struct series *s = series ? series : &own;
    if (s->quantity != QUANTITY_LENGTH)
        return error_set(error, ERROR_COMMAND, "%s needs positions, but %s is not a position",
                         energy ? "the energy" : "this", recording->name);
    motion->n = s->n;
    motion->t = s->t;
    motion->y = s->y;
    motion->quantity = QUANTITY_VELOCITY;
    motion->cancel = s->cancel;
    motion->v = arena_array(arena, s->n, sizeof *motion->v);
    motion->energy = energy ? arena_array(arena, s->n, sizeof *motion->energy) : NULL;
    unsigned char *use;
    if (!motion->v || (energy && !motion->energy) ||
        !find_good_rows(session, recording, s, arena, &use))
        return error_memory(error);
    motion->omega = motion_frequency(session, recording, s, arena);
    if (recording_is_fitted(session, recording))
        motion->middle =
            fits_of(session)->fit.offset.value - (recording->zero - fits_of(session)->fit_zero);
    else if (session_grows(session, recording) && isfinite(session->growing->middle))
        motion->middle = session->growing->middle - recording->zero;
    else
        for (size_t i = 0, used = 0; i < s->n; i++)
            motion->middle += use[i] ? (s->y[i] - motion->middle) / (double)++used : 0;
    if (!(recording->velocity[0] ? sensor_velocity(session, recording, arena, motion, error)
                                 : good_velocity(s, use, arena, motion, error)))
        return false;
    for (size_t i = 0; i < s->n; i++)
        motion->v[i] = use[i] ? motion->v[i] : NAN; /* makes the energy NAN, too */
    if (energy && !find_spring(session, recording, motion, error))
        return false;
    for (size_t i = 0; i < s->n && energy; i++) {
        if (cancelled_at(s->cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped");
        const double y = s->y[i] - motion->middle, v = motion->v[i];
        motion->energy[i] = 0.5 * (motion->mass.value * v * v + motion->k.value * y * y);
    }
    const double noise = energy ? series_noise(s, arena) : NAN;
    if (noise > 0)
        motion->noise = (struct energy_noise){
            0.5 * noise * noise *
                (motion->k.value + motion->mass.value * motion->gain * motion->gain),
            2 * noise * sqrt(motion->k.value)};
    return true;
}
