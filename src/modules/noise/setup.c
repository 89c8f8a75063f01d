/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads scenes with noise from the arguments of a command, and writes them as text, records and
 * keys of tables. */
#include "modules/noise/setup.h"

#include "modules/noise/compute/random.h"

#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>

/* [byte] Largest memory of an ensemble or of the Wiener paths of an order. */
static const double bytes_max = 512.0 * 1024 * 1024;
/* [J/K] Exact by the definition of the kelvin. */
static const double boltzmann_constant = 1.380649e-23;

/* Returns the value of an argument, or NAN if it was not given. */
static double setup_value(const struct arguments *args, const char *name)
{
    const struct argument_value *given = argument_value(args, name);
    return given->count ? given->item[0].value.value : NAN;
}

int64_t noise_integer(const struct arguments *args, const char *name, int64_t natural)
{
    const double value = setup_value(args, name);
    return isnan(value) ? natural : (int64_t)value;
}

/* Reads temperature, damping and strengths. Returns false with *error. */
static bool read_request(const struct arguments *args, struct noise_request *request,
                         struct error *error)
{
    const struct argument_value *noise = argument_value(args, "noise");
    *request = (struct noise_request){.energy = setup_value(args, "kT"),
                                      .gamma = setup_value(args, "gamma"),
                                      .strengths = noise->count};
    if (has_argument(args, "temperature"))
        request->energy = boltzmann_constant * setup_value(args, "temperature");
    if (isnan(request->energy) && noise->count == 0) {
        error_set(error, ERROR_COMMAND, "the strength of the noise is missing");
        return error_hint(error, "give kT=2mJ, temperature=300 (in kelvin) or noise=0.1");
    }
    if (noise->count > LIMIT_VARIABLES)
        return error_at(error, noise->where, "noise= has too many values");
    for (int i = 0; i < noise->count; i++) {
        request->strength[i] = noise->item[i].value.value;
        if (!(request->strength[i] >= 0))
            return error_at(error, noise->where, "noise must be at least 0");
    }
    return true;
}

/* Reads the arguments that all commands of noise share. Defaults are the session's duration and
 * step, and the method that suits the scene. Returns the set-up in args->arena, or NULL with an
 * error. */
const struct noise_setup *noise_setup_read(struct session *session, const struct arguments *args,
                                           struct error *error)
{
    const struct settings *settings = &session->setup.settings;
    struct noise_setup *setup = arena_alloc(args->arena, sizeof *setup);
    struct noise_request request;
    if (!setup)
        return error_memory(error), NULL;
    if (!read_request(args, &request, error) ||
        !noise_forcing_bind(&session->setup.scene, &request, &setup->forcing, error))
        return NULL;
    setup->scene = &session->setup.scene;
    setup->method = noise_method_natural(&setup->forcing);
    for (int i = 0; i < args->command->arguments; i++)
        if (text_is(text_of(args->command->argument[i].name), "method") && has_argument_at(args, i))
            setup->method = noise_method_at((size_t)args->value[i].item[0].index);
    setup->span =
        has_argument(args, "DURATION") ? setup_value(args, "DURATION") : settings->duration;
    setup->dt = has_argument(args, "dt") ? setup_value(args, "dt") : settings->dt;
    setup->seed = (uint64_t)noise_integer(args, "seed", 1);
    return setup;
}

enum quantity noise_energy_quantity(const struct noise_setup *setup)
{
    const struct system *system = &setup->forcing.system;
    return observable_quantity(observable_energy(system), system);
}

/* Returns how many of the values [count] have to be shown: one if all are equal. */
static int shown_count(const double *value, int count)
{
    for (int i = 1; i < count; i++)
        if (value[i] != value[0])
            return count;
    return 1;
}

/* Appends "NAME = VALUE" with one value, or with all if they differ. */
static void put_values(struct buffer *text, const char *name, const double *value, int count,
                       enum quantity quantity)
{
    buffer_format(text, "%s = ", name);
    for (int i = 0; i < shown_count(value, count); i++)
        buffer_format(text, "%s%s", i ? ", " : "", SHOWN_QUANTITY(value[i], quantity, 6));
}

/* Appends damping, temperature or strength, and seed. */
void noise_setup_put(const struct noise_setup *setup, struct buffer *text)
{
    const struct noise_forcing *forcing = &setup->forcing;
    if (forcing->system.order == 2) {
        put_values(text, "gamma", forcing->gamma, forcing->count, QUANTITY_RATE);
        buffer_format(text, ", ");
    }
    if (isnan(forcing->energy))
        put_values(text, "noise", forcing->strength, forcing->count, QUANTITY_NUMBER);
    else
        put_values(text, "kT", &forcing->energy, 1, noise_energy_quantity(setup));
    buffer_format(text, ", seed %lld", (long long)(int64_t)setup->seed);
}

/* Replies a number, or an array where the values [count] differ. */
static void reply_values(struct reply *reply, const char *key, const double *value, int count)
{
    if (shown_count(value, count) == 1) {
        reply_real(reply, key, value[0]);
        return;
    }
    reply_reals(reply, key, value, count, "");
}

/* Adds method, step, temperature, damping, strengths and seed to the record. */
void noise_setup_reply(const struct noise_setup *setup, const struct path_grid *grid,
                       struct reply *reply)
{
    const struct noise_forcing *forcing = &setup->forcing;
    reply_string(reply, "method", setup->method->row.name);
    reply_quantity(reply, "dt", grid->h, "s");
    reply_int(reply, "steps", grid->steps);
    reply_quantity(reply, "kT", forcing->energy, quantity_unit(noise_energy_quantity(setup)));
    if (forcing->system.order == 2)
        reply_values(reply, "gamma", forcing->gamma, forcing->count);
    else
        reply_null(reply, "gamma");
    reply_values(reply, "noise", forcing->strength, forcing->count);
    reply_int(reply, "seed", (int64_t)setup->seed);
}

/* Adds a key with a value in its unit. */
static void add_quantity(struct keys *keys, const char *name, double value, enum quantity quantity)
{
    struct buffer text = {0};
    buffer_exact(&text, (struct measured){value, 0}, quantity);
    keys_add(keys, name, &text);
}

/* Adds the key NAME_VARIABLE of the variable that noise number i acts on. */
static void add_of_variable(struct keys *keys, const char *name,
                            const struct noise_forcing *forcing, int i, struct arena *arena,
                            double value, enum quantity quantity)
{
    struct buffer key = {0};
    buffer_format(&key, "%s_%s", name, system_variable(&forcing->system, forcing->first + i).name);
    const char *full_name = arena_text(arena, buffer_text(&key));
    buffer_free(&key);
    if (full_name)
        add_quantity(keys, full_name, value, quantity);
}

/* Stores the table for plots, with the keys from which it can be made again; `kind` is the command,
 * `subject` the quantity or NULL, dt [s] is 0 if there is no single step. Empties the arena if it
 * cannot be stored. */
void noise_keep_table(const struct noise_setup *setup, double dt, const char *kind,
                      const char *subject, struct arena *arena, const struct table *table,
                      struct reply *reply)
{
    const struct noise_forcing *forcing = &setup->forcing;
    struct export export = {.arena = arena, .table = *table};
    struct keys keys;
    struct error ignored;
    if (reply->store && keys_begin(&keys, &export, &ignored)) {
        if (subject)
            keys_add_text(&keys, "of", subject);
        add_quantity(&keys, "duration", setup->span, QUANTITY_TIME);
        if (dt > 0) {
            keys_add_text(&keys, "method", setup->method->row.name);
            add_quantity(&keys, "dt", dt, QUANTITY_TIME);
        }
        if (!isnan(forcing->energy))
            add_quantity(&keys, "kT", forcing->energy, noise_energy_quantity(setup));
        for (int i = 0; i < forcing->count; i++)
            add_of_variable(&keys, "noise", forcing, i, arena, forcing->strength[i],
                            QUANTITY_NUMBER);
        const bool second = forcing->system.order == 2;
        const int gammas = second ? shown_count(forcing->gamma, forcing->count) : 0;
        if (gammas == 1)
            add_quantity(&keys, "noise_gamma", forcing->gamma[0], QUANTITY_RATE);
        for (int i = 0; i < gammas && gammas > 1; i++)
            add_of_variable(&keys, "noise_gamma", forcing, i, arena, forcing->gamma[i],
                            QUANTITY_RATE);
        add_quantity(&keys, "seed", (double)(int64_t)setup->seed, QUANTITY_NUMBER);
        keys_add_scene(&keys, setup->scene);
        if (keys_finish(&keys, &export, &ignored))
            table_store_put(reply->store, kind, arena, &export.table);
    }
    arena_reset(arena);
}

void noise_setup_warn(const struct noise_setup *setup, struct reply *reply)
{
    if (setup->forcing.other_drag && !isnan(setup->forcing.energy))
        reply_warning(reply, "only linear damping has noise; the scene has other drag, too, so its "
                             "motion does not settle at the given temperature");
}

/* Returns the time that a step takes [s], measured with a few of them. */
static double step_seconds(const struct noise_setup *setup)
{
    enum { STEPS_TIMED = 200 };
    struct noise_stepper stepper;
    double y[LIMIT_VARIABLES], noise[LIMIT_VARIABLES];
    const struct system *system = &setup->forcing.system;
    for (int i = 0; i < system->n; i++)
        y[i] = system->start[i];
    noise_stepper_begin(&stepper, &setup->forcing, setup->method, setup->dt);
    const int64_t begun = clock_ns();
    for (int i = 0; i < STEPS_TIMED; i++) {
        noise_normal_numbers(setup->seed, 0, (uint64_t)i, setup->forcing.count, noise);
        noise_stepper_step(&stepper, system->t0, y, noise);
    }
    return clock_seconds(begun) / STEPS_TIMED;
}

/* Measures the time of a few steps to predict that of all. */
bool noise_check_cost(struct session *session, const struct arguments *args,
                      const struct noise_setup *setup, double bytes, double steps,
                      struct error *error)
{
    if (bytes > bytes_max) {
        error_set(error, ERROR_COMMAND, "this would need %.3g MB of memory; the limit is %.0f MB",
                  bytes / 1e6, bytes_max / 1e6);
        return error_hint(error, "fewer paths, fewer rows, or a larger dt");
    }
    return allow_long(session, steps * step_seconds(setup), steps, has_argument(args, "force"),
                      error);
}

/* Finds the quantity that `of` names, by default the first variable, as *column, and its name and
 * unit as *shown. Observables of a run's history, such as its error, are refused. Returns false
 * with an error. */
bool noise_column(struct session *session, const struct arguments *args,
                  const struct noise_setup *setup, struct path_column *column,
                  struct variable *shown, struct error *error)
{
    const struct system *system = &setup->forcing.system;
    const struct argument_value *subject = argument_value(args, "of");
    struct chosen_column chosen = {0};
    if (subject->count && !chosen_find(system->model, subject->item[0].text, &chosen, error))
        return false;
    *shown = chosen_variable(system, &chosen);
    *column = (struct path_column){.observable = chosen.observable, .variable = chosen.variable};
    if (!chosen.observable)
        return true;
    /* observables that depend on the steps of a run, not only on its state */
    static const unsigned of_the_way = NEED_EXACT | NEED_WORK | NEED_RATIO;
    if ((chosen.observable->needs & of_the_way) ||
        !observable_defined(chosen.observable, system, false))
        return error_at(error, subject->where, "%s cannot be computed for a state with noise",
                        chosen.observable->row.name);
    const struct run_settings run_settings = session_run_settings(session);
    /* a run at its start, as observables are functions of runs */
    column->run =
        run_create(&session->setup.scene, session->setup.method, &run_settings, setup->span, error);
    return column->run != NULL;
}

struct parallel noise_parallel(struct session *session, const struct arguments *args)
{
    return (struct parallel){.threads = (int)noise_integer(args, "threads", 0),
                             .cancel = session->front.cancel,
                             .progress = report_fraction,
                             .progress_context = &session->front};
}
