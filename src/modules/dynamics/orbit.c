/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command orbit: reads a guess, finds a periodic orbit from it and replies it. */
#ifndef COMMAND_ROWS
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/language/grid.h>
#include "modules/dynamics/handlers.h"

#include <math.h>
#include <string.h>

/* ---- reading [period=GUESS] [NAME=VALUE ...] ---- */

/* Reads one argument, period=T or NAME=VALUE, into the request. A guess of a state means that the
 * orbit near it is wanted, not the one that the motion settles on. Returns false with *error. */
static bool read_guess(struct session *session, const struct arguments *args, struct text argument,
                       const struct system *system, struct orbit_request *request,
                       struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, argument};
    struct item item = {0};
    if (text_is(peek_name(argument), "period")) {
        if (!take_equals(&parser, argument, TEXT("period")))
            return error_at(error, argument, "period needs a value, as in period=1");
        if (!read_value(&parser, "period", QUANTITY_TIME, &item, error))
            return false;
        request->period = item.value.value;
        return request->period > 0 || error_at(error, item.text, "period must be greater than 0");
    }
    const int i = read_variable(&parser, argument, system, "orbit", "1", error);
    if (i < 0)
        return false;
    const struct variable variable = system_variable(system, i);
    if (!read_value(&parser, variable.name, variable.quantity, &item, error))
        return false;
    request->state[i] = item.value.value;
    request->settles = false;
    return true;
}

/* The span is 20 times the shortest time in which a variable changes by its natural size. */
const char *orbit_begin(const struct session *session, const struct system *system,
                        struct orbit_request *request)
{
    const struct run *run = session_run(session);
    const struct scene *scene = &session->setup.scene;
    const double *size = system->scale;
    double rate[LIMIT_VARIABLES], fastest = 0;
    memcpy(request->state, system->start, (size_t)system->n * sizeof *request->state);
    request->t = system->t0;
    bool from_run = run && run->scene.model == scene->model && !stop_is_failure(run->stop);
    for (int i = 0; i < system->n && from_run; i++)
        from_run = isfinite(run->y[i]);
    if (from_run) {
        memcpy(request->state, run->y, (size_t)system->n * sizeof *request->state);
        request->t = run->t;
    }
    system_derivative(system, request->t, request->state, rate);
    for (int i = 0; i < system->n; i++)
        fastest = fmax(fastest, fabs(rate[i]) / size[i]);
    request->span = fastest > 0 && isfinite(fastest) ? 20 / fastest : 1;
    return from_run ? "the run's end" : "the scene's start";
}

/* ---- text and records ---- */

/* A start that is farther from the orbit than this part of its extent is not on it. */
#define ORBIT_DISTANCE_FRACTION 0.01

/* Writes where the search began, and whether the motion from there is on the orbit. */
static void put_search_start(struct buffer *output, const struct found_orbit *orbit,
                             const char *source)
{
    buffer_format(output, ", from %s", source);
    if (orbit->given_up)
        buffer_put(output, TEXT("; no stable orbit was found, so the motion may be chaotic"));
    if (orbit->family && orbit->away > ORBIT_DISTANCE_FRACTION)
        buffer_format(output,
                      ";\n  it passes there at a distance of %.2g of its size: the motion from "
                      "there is not on it, and did not close",
                      orbit->away);
}

/* Appends the energy that goes through the orbit per period, if there is any. */
static void put_energy(struct buffer *output, const struct found_orbit *orbit, bool driven)
{
    if (isfinite(orbit->energy_in) && orbit->energy_in != 0)
        buffer_format(output, "  energy %s put in %s per period\n",
                      SHOWN_QUANTITY(orbit->energy_in, QUANTITY_ENERGY, 6),
                      driven ? "by the drive" : "and taken out");
}

/* Appends the multipliers, and how accurate they are by the trivial one. */
static void put_multipliers(struct buffer *output, const struct solution *s)
{
    if (s->values > 0) {
        buffer_put(output, TEXT("\n  multipliers "));
        put_eigenvalues(output, s);
    }
    if (isfinite(s->trivial))
        buffer_format(output, "%s the trivial one differs from 1 by %.1e",
                      s->values > 0 ? ";" : "\n ", s->trivial);
}

/* Appends the answer: period, stability, multipliers, ranges of the variables, accuracy. */
static void put_orbit(struct buffer *output, const struct system *system, int number,
                      const struct found_orbit *orbit)
{
    const struct solution *s = &orbit->solution;
    buffer_format(output, "orbit %d: T = %s", number, SHOWN_QUANTITY(s->period, QUANTITY_TIME, 12));
    if (s->multiple > 1)
        buffer_format(output, " (%d periods of the drive)", s->multiple);
    else if (s->multiple == 1)
        buffer_put(output, TEXT(" (the period of the drive)"));
    if (!solution_is_known(s))
        buffer_put(output, TEXT(", stability unknown because the equations jump"));
    else if (!orbit->family)
        buffer_put(output, solution_stable(s) ? TEXT(", stable") : TEXT(", unstable"));
    else
        buffer_put(output,
                   solution_stable(s)
                       ? TEXT(", neutral: a multiplier is 1, so other orbits lie next to it")
                       : TEXT(", unstable, and a multiplier is 1"));
    put_multipliers(output, s);
    for (int i = 0; i < system->n; i++) {
        const struct variable variable = system_variable(system, i);
        buffer_format(output, "\n  %s = %s", variable.name,
                      SHOWN_RANGE(s->bottom[i], s->top[i], variable.quantity, 8));
    }
    buffer_char(output, '\n');
    put_energy(output, orbit, s->multiple > 0);
    buffer_format(output, "  residual %.1e", s->residual);
    if (isfinite(orbit->error))
        buffer_format(output, ", error about %.0e", orbit->error);
    buffer_format(output, ", %lld evaluations", (long long)orbit->evals);
}

/* Adds the record `orbit` of a closed orbit to the reply, under its `number` in the session; max
 * and min are the extremes of the state along the orbit. */
static void reply_orbit(const struct system *system, int number, const struct found_orbit *orbit,
                        struct reply *reply)
{
    const struct solution *s = &orbit->solution;
    reply_begin(reply, "orbit");
    reply_int(reply, "n", number);
    reply_real(reply, "period", s->period);
    reply_state(reply, system, "state", s->state);
    reply_values(reply, "multipliers", s);
    reply_real(reply, "trivial", s->trivial);
    reply_stable(reply, s, orbit->family);
    reply_real(reply, "residual", s->residual);
    reply_real(reply, "error", orbit->error);
    reply_state(reply, system, "max", s->top);
    reply_state(reply, system, "min", s->bottom);
    reply_bool(reply, "family", orbit->family);
    reply_real(reply, "energy_in", orbit->energy_in);
    reply_real(reply, "away", orbit->away);
    reply_end(reply);
}

/* Stores the samples of one period, times and states, as the table `orbit`. */
static void store_samples(const struct system *system, const struct found_orbit *orbit,
                          struct reply *reply)
{
    struct table_builder table = {.rows = (size_t)orbit->samples};
    const size_t width = (size_t)system->n + 1;
    for (size_t c = 0; c < width; c++) {
        const struct variable variable =
            c > 0 ? system_variable(system, (int)c - 1) : (struct variable){"t", QUANTITY_TIME};
        double *value = table_add_reals(&table, variable.name, "", variable.quantity);
        for (size_t k = 0; value && k < table.rows; k++)
            value[k] = orbit->sample[k * width + c];
    }
    table_finish(&table, reply, "orbit");
}

/* Finds an orbit, stores it and replies it. */
HANDLER(orbit)
{
    const struct argument_value *guesses = argument_value(args, "NAME=VALUE");
    struct orbit_request request = {.scene = &session->setup.scene,
                                    .settles = true,
                                    .cancel = session->front.cancel,
                                    .progress = report_fraction,
                                    .context = &session->front};
    struct found_orbit found;
    struct system system;
    if (!scene_bind(&session->setup.scene, &system, error))
        return false;
    if (system.n > DYNAMICS_VARIABLES)
        return error_set(error, ERROR_COMMAND, "orbits can be found for at most %d variables",
                         DYNAMICS_VARIABLES);
    const char *source = orbit_begin(session, &system, &request);
    struct text rest = guesses->count ? guesses->item->text : TEXT("");
    for (rest = text_trim(rest); rest.len > 0; rest = text_trim(rest)) {
        const struct text guess = next_key_argument(&rest);
        if (!text_is(guess, "--full") &&
            !read_guess(session, args, guess, &system, &request, error))
            return false;
    }
    const bool fine = orbit_find(&request, &found, error);
    report_fraction(&session->front, 2);
    if (!fine) {
        orbit_free(&found);
        return false;
    }
    const struct stored_orbit *stored =
        dynamics_store_orbit(session, &found.solution, found.samples, found.sample, error);
    if (stored) {
        struct buffer *text = reply_buffer(reply);
        put_orbit(text, &system, stored->number, &found);
        put_seconds(text, session, found.seconds);
        if (found.family_from > 0)
            buffer_format(text, ",\n  along its family from T = %s",
                          SHOWN_QUANTITY(found.family_from, QUANTITY_TIME, 6));
        else
            put_search_start(text, &found, request.settles ? source : "the guess");
        reply_own_solver(session, FLOW_SOLVER, reply);
        reply_orbit(&system, stored->number, &found, reply);
        store_samples(&system, &found, reply);
    }
    orbit_free(&found);
    return stored != NULL;
}
#endif

COMMAND(orbit, .group = "DYNAMICS", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("NAME=VALUE", TYPE_REST, .more = "[period=T]"), OPTION("full", TYPE_NONE)))
