/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computations while a collection runs: the period, a fit of all data, and the scene integrated
 * beside the data. Each costs a bounded time per second, however long the collection is. */
#include "modules/solving/compute/start.h"
#include "modules/collect/handlers.h"
#include "modules/recording/fit_text.h"
#include "modules/recording/fits.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <string.h>

#define PERIOD_NS 500000000        /* [ns] interval between computations of the period */
#define FIT_NS 1000000000          /* [ns] interval between fits */
#define PERIOD_ROWS 1024           /* Largest number of rows that a period is read from. */
#define SHOWN_PERIODS 8            /* The live figure shows this many periods. */
#define MODEL_STEPS 100            /* steps per period of the scene's own run */
#define AXIS_CHANGE_MIN 0.02       /* Axes do not follow relative changes below this. */
#define PERIOD_UNCERTAINTY_MAX 0.3 /* A period with a larger relative uncertainty is not used. */
#define MODEL_NS 10000000          /* [ns] longest time for which the scene is integrated at once */
#define START_ROWS 8               /* smallest number of rows from which initial values are found */

/* Fills a series with the rows from t_begin [s] on, thinned to at most PERIOD_ROWS. Returns false
 * if there are too few. */
static bool read_last_rows(const struct recording *recording, double t_begin, struct arena *arena,
                           struct series *series)
{
    struct error ignored;
    if (!recording_series(recording, arena, 16, series, &ignored))
        return false;
    size_t first = first_from(series->t, series->n, t_begin), n = 0;
    const size_t each = (series->n - first) / PERIOD_ROWS + 1;
    double *t = arena_array(arena, PERIOD_ROWS + 1, sizeof *t),
           *y = arena_array(arena, PERIOD_ROWS + 1, sizeof *y);
    for (; t && y && first < series->n; first += each, n++) {
        t[n] = series->t[first];
        y[n] = series->y[first];
    }
    *series = (struct series){t, y, n, series->quantity, series->cancel, series->pace};
    return n >= 16;
}

/* Returns the mean over the last whole periods. */
static double mean_of_periods(const struct series *series, double period)
{
    const double end = series->t[series->n - 1], span = end - series->t[0];
    const size_t first =
        first_from(series->t, series->n, end - fmax(1, floor(span / period)) * period);
    return series_mean(&(struct series){
                           .t = series->t + first, .y = series->y + first, .n = series->n - first})
        .value;
}

/* Updates the values that the axes of panes follow, where they have changed noticeably. */
static void update_steady_values(struct collecting *now, double middle)
{
    if (!(fabs(now->period - now->growing.steady) < AXIS_CHANGE_MIN * now->growing.steady))
        now->growing.steady = now->period;
    if (!(fabs(middle - now->growing.middle) < AXIS_CHANGE_MIN * now->amplitude))
        now->growing.middle = middle;
    if (!(now->amplitude < now->growing.swing && now->amplitude > 0.5 * now->growing.swing))
        now->growing.swing = now->amplitude;
}

/* Computes the period and the amplitude of the last periods, NAN if there are none. */
static void find_period(struct collecting *now, const struct recording *recording)
{
    struct arena arena = {0};
    struct series series;
    struct error ignored;
    struct period period;
    struct period_reading reading;
    const double end = recording->t[recording->rows - 1],
                 t_begin = now->period > 0 ? end - (SHOWN_PERIODS + 0.5) * now->period : -HUGE_VAL;
    now->period = now->amplitude = NAN;
    now->quantity = recording->column[recording->value].quantity;
    if (read_last_rows(recording, t_begin, &arena, &series) &&
        series_period(&series, &arena, &period, &ignored)) {
        now->period = period.period.value;
        if (series_period_readings(&series, 1, &arena, &reading, &ignored))
            now->amplitude = reading.amplitude.value;
        update_steady_values(now, mean_of_periods(&series, now->period) + recording->zero);
    }
    arena_reset(&arena);
}

/* Fits a damped sine to all data and stores period, damping and, if the mass is known, the spring
 * constant. */
static void find_fit(struct collection *c, const struct recording *recording)
{
    const struct fit_model *model = fit_model_at(0);
    const struct measured none = {NAN, NAN};
    struct collecting *now = &c->state;
    struct arena arena = {0};
    struct series series;
    struct error ignored;
    struct fit fit = {0};
    struct measured mass;
    now->fit.t = recording->t[recording->rows - 1];
    now->fit.period = now->fit.gamma = now->fit.k = none;
    if (recording_series(recording, &arena, 16, &series, &ignored) &&
        model->fit(&series, &arena, c->session->front.cancel, &fit, &ignored) && fit.converged &&
        fit.period.uncertainty < PERIOD_UNCERTAINTY_MAX * fit.period.value) {
        now->fit.period = fit.period;
        now->fit.gamma = fit.gamma;
        if (known_mass(&c->session->setup.scene, &mass))
            now->fit.k = fit_stiffness(&fit, mass);
    }
    arena_reset(&arena);
}

/* ---- the scene beside the data ---- */

/* Returns true if the user has set up a scene that moves in one coordinate of the recorded
 * quantity; binds it into *system. */
static bool scene_matches_recording(const struct session *session,
                                    const struct recording *recording, struct system *system)
{
    const struct scene *scene = &session->setup.scene;
    struct error ignored;
    bool said = (const void *)scene->preset != (const void *)catalog_row(&preset_catalog, 0);
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        said |= scene->chosen[i] && !param_is_start(scene, i);
    return said && scene_bind_motion(scene, system, &ignored) && system->order == 2 &&
           system->n == 2 &&
           system_variable(system, 0).quantity == recording->column[recording->value].quantity;
}

/* Finds position and velocity at t0 [s], and the offset of the recording, by least squares of a
 * damped sine with the scene's period and damping to the recording's first period. Returns false if
 * that is not complete or has too few samples. */
static bool find_start(const struct scene *scene, const struct recording *recording, double t0,
                       double state[2], double *offset)
{
    const double period = scene_period(scene), omega = TWO_PI / period;
    const int place = scene_param(scene, "gamma");
    const double rate = place >= 0 ? 0.5 * scene->value[place] : 0;
    /* normal equations of the offset and the two amplitudes */
    double a[9] = {0}, x[3] = {0};
    size_t row = first_from(recording->t, recording->rows, t0), n = 0;
    if (!(recording->t[recording->rows - 1] >= t0 + period))
        return false;
    for (; row < recording->rows && recording->t[row] <= t0 + period; row++) {
        const double t = recording->t[row] - t0, y = recording->y[row] - recording->zero,
                     fall = exp(-rate * t),
                     basis[3] = {1, fall * cos(omega * t), fall * sin(omega * t)};
        for (size_t i = 0; i < 3 && isfinite(y); i++) {
            x[i] += basis[i] * y;
            for (size_t k = 0; k < 3; k++)
                a[3 * i + k] += basis[i] * basis[k];
        }
        n += isfinite(y) ? 1 : 0;
    }
    if (n < START_ROWS || !matrix_cholesky(3, 3, a, 1e-14, a))
        return false;
    cholesky_forward(3, 3, a, x);
    cholesky_backward(3, 3, a, x);
    *offset = x[0];
    state[0] = x[1];
    state[1] = x[2] * omega - rate * x[1];
    return true;
}

/* Frees the run of the scene. */
static void free_scene_run(struct collecting *now)
{
    if (now->growing.model)
        run_destroy(now->growing.model);
    now->growing.model = NULL;
}

/* Creates the run of the scene from the recording's start, by the chosen method or else by rk4 with
 * small steps. Does nothing if the initial values are not known yet. */
static void begin_scene_run(struct collection *c, const struct recording *recording)
{
    const struct session *session = c->session;
    const struct row *rk4 = catalog_find(&method_catalog, TEXT("rk4"));
    struct scene scene = session->setup.scene;
    struct run_settings settings = session_run_settings(session);
    struct error ignored;
    double state[2];
    const double t0 = c->trigger.wanted ? fmax(c->trigger.t, recording->t[0]) : recording->t[0];
    const int start = scene_param(&scene, "t0");
    if (!find_start(&scene, recording, t0, state, &c->state.growing.offset) ||
        !scene_start_at(&scene, state, &ignored))
        return;
    if (start >= 0)
        scene.value[start] = t0;
    if (!session->setup.method_chosen) /* the error of a method is shown if one was chosen */
        settings = (struct run_settings){.dt = scene_period(&scene) / MODEL_STEPS};
    c->state.growing.model =
        run_create(&scene,
                   session->setup.method_chosen ? session->setup.method
                                                : (const struct method *)(const void *)rk4,
                   &settings, 1, &ignored);
}

/* Advances the run of the scene to the newest sample; begins anew if the scene or the method was
 * changed. */
static void advance_scene_run(struct collection *c, const struct recording *recording)
{
    const struct setup *setup = &c->session->setup;
    struct collect_live *live = &c->live;
    struct collecting *now = &c->state;
    struct system system;
    if (live->method != setup->method || live->laid.model != setup->scene.model ||
        memcmp(live->laid.value, setup->scene.value, sizeof setup->scene.value) != 0) {
        free_scene_run(now);
        live->laid = setup->scene;
        live->method = setup->method;
    }
    if (!now->growing.model && scene_matches_recording(c->session, recording, &system))
        begin_scene_run(c, recording);
    if (!now->growing.model || stop_is_failure(now->growing.model->stop))
        return;
    const struct run_target target = {.t = recording->t[recording->rows - 1], .steps = -1};
    run_advance(now->growing.model, &target, MODEL_NS, c->session->front.cancel);
}

/* Computes, when due, the period and the fit, and advances the scene to the newest sample. */
void collect_find(struct collection *c, struct recording *recording)
{
    struct collecting *now = &c->state;
    const int64_t begun = clock_ns();
    now->growing.late = (DERIVATIVE_POINTS / 2) * recording->dt;
    if (begun >= c->live.period_due) {
        c->live.period_due = begun + PERIOD_NS;
        find_period(now, recording);
    }
    if (fits_of(c->session)->live && begun >= c->live.fit_due) {
        c->live.fit_due = begun + FIT_NS;
        find_fit(c, recording);
    }
    advance_scene_run(c, recording);
}

/* Reports the last fit as a line and as a record. */
void collect_say_fit(const struct collection *c)
{
    const struct collecting *now = &c->state;
    struct buffer text = {0};
    if (!isfinite(now->fit.t))
        return;
    put_value(&text, "T", now->fit.period, QUANTITY_TIME, true);
    put_value(&text, ", gamma", now->fit.gamma, QUANTITY_RATE, true);
    if (isfinite(now->fit.k.value))
        put_value(&text, ", k", now->fit.k, QUANTITY_STIFFNESS, true);
    reply_line(c->reply, "live fit to t = %.6g s: %s", now->fit.t,
               isfinite(now->fit.period.value) ? buffer_view(&text) : "not determined");
    buffer_free(&text);
    reply_begin(c->reply, "live-fit");
    reply_real(c->reply, "t", now->fit.t);
    reply_measured(c->reply, "period", now->fit.period, QUANTITY_TIME);
    reply_measured(c->reply, "gamma", now->fit.gamma, QUANTITY_RATE);
    reply_measured(c->reply, "k", now->fit.k, QUANTITY_STIFFNESS);
    reply_end(c->reply);
}

void collect_live_free(struct collection *c)
{
    free_scene_run(&c->state);
    struct fits *fits = fits_made(c->session);
    if (fits)
        fits->live = false;
}
