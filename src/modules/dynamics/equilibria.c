/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command equilibria: reads the search region, finds all equilibria in it and replies them. */
#ifndef COMMAND_ROWS
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/report.h>
#include <hooke/scene/poles.h>
#include <hooke/language/grid.h>
#include "modules/dynamics/handlers.h"

#include <float.h>
#include <math.h>

/* ---- the search region ---- */

/* Reads one argument NAME=FROM:TO into the box; an end that is left out stays as it is. Returns
 * false with *error. */
static bool read_side(struct session *session, const struct arguments *args, struct text argument,
                      const struct system *system, double box[][2], struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, argument};
    struct item item = {0};
    const int i = read_variable(&parser, argument, system, "equilibria", "-1:1", error);
    if (i < 0)
        return false;
    const struct variable variable = system_variable(system, i);
    if (!parse_range(&parser, variable.name, variable.quantity, &item, error) ||
        !refuse_rest(&parser, NULL, error))
        return false;
    for (int k = 0; k < 2; k++)
        box[i][k] = isnan(item.range[k]) ? box[i][k] : item.range[k];
    return box[i][0] < box[i][1] ||
           error_at(error, argument,
                    "%s: the first value of a range must be smaller than the second",
                    variable.name);
}

/* ---- text and records ---- */

/* Returns the name of a type, such as "saddle". */
static const char *type_name(enum equilibrium_type type)
{
    return catalog_row(&equilibrium_catalog, (size_t)type)->name;
}

/* Appends an eigenvalue; `sign` stands before the imaginary part. */
static void put_eigenvalue(struct buffer *output, const struct eigenvalue *value, const char *sign)
{
    if (isnan(value->re))
        buffer_put(output, TEXT("not known"));
    else if (value->im == 0)
        buffer_format(output, "%.5g", value->re);
    else if (value->re == 0)
        buffer_format(output, "%s%.5gi", sign, fabs(value->im));
    else
        buffer_format(output, "%.5g %s %.5gi", value->re, sign, fabs(value->im));
}

/* The second one of a conjugate pair is left out. */
void put_eigenvalues(struct buffer *output, const struct solution *s)
{
    for (int i = 0; i < s->values; i++) {
        const bool pair = s->value[i].im != 0 && i + 1 < s->values;
        if (i > 0)
            buffer_put(output, TEXT(", "));
        put_eigenvalue(output, &s->value[i], "+-");
        i += pair;
    }
}

/* Returns the number of significant digits that states need to show that they differ: 7, or more if
 * two are close. n is the number of variables. */
static int distinguishing_digits(const struct equilibria *found, int n)
{
    int digits = 7;
    for (int k = 1; k < found->count; k++) {
        double difference = 0;
        for (int i = 0; i < n; i++) {
            const double a = found->solution[k - 1].state[i], b = found->solution[k].state[i];
            difference = fmax(difference, fabs(b - a) / fmax(fmax(fabs(a), fabs(b)), DBL_MIN));
        }
        if (difference > 0)
            digits = (int)fmax(digits, fmin(2 - floor(log10(difference)), 17));
    }
    return digits;
}

/* Appends a table: number, state, type and eigenvalues of each equilibrium. */
void put_equilibria(struct buffer *output, const struct system *system,
                    const struct equilibria *found, struct arena *arena)
{
    struct text_table table = {.arena = arena, .gap = 2, .indent = 2, .columns = system->n + 3};
    const int digits = distinguishing_digits(found, system->n);
    cell_text(&table, "");
    for (int i = 0; i < system->n; i++)
        cell_text(&table, system_variable(system, i).name);
    cell_text(&table, "type");
    cell_text(&table, "eigenvalues [1/s]");
    for (int k = 0; k < found->count; k++) {
        cell_count(&table, k + 1);
        for (int i = 0; i < system->n; i++)
            cell_quantity(&table, found->solution[k].state[i], system_variable(system, i).quantity,
                          digits);
        cell_text(&table, type_name(found->form[k].type));
        struct buffer values = {0};
        put_eigenvalues(&values, &found->solution[k]);
        cell_take(&table, &values);
    }
    text_table_put(&table, output);
}

/* Appends eigenvector k with its largest component scaled to 1: "(1, 2)" or, for a conjugate pair,
 * "(1, 2) +- i (3, 4)". */
static void put_vector(struct buffer *output, const struct equilibrium_form *form, int k, int n)
{
    int largest = 0;
    for (int i = 1; i < n; i++)
        if (hypot(form->re[k][i], form->im[k][i]) >
            (1 + 1e-9) * hypot(form->re[k][largest], form->im[k][largest]))
            largest = i;
    const double size = form->re[k][largest]; /* that component is real by its normalisation */
    bool turns = false;
    if (isnan(size)) {
        buffer_put(output, TEXT(" an unknown direction"));
        return;
    }
    for (int part = 0; part < (turns ? 2 : 1); part++) {
        buffer_put(output, part ? TEXT(" +- i (") : TEXT(" ("));
        for (int i = 0; i < n; i++) {
            double value = (part ? form->im : form->re)[k][i] / size;
            if (fabs(value) < 1e-12)
                value = 0;
            turns = turns || fabs(form->im[k][i]) > 1e-12 * size;
            buffer_format(output, "%s%.6g", i > 0 ? ", " : "", value);
        }
        buffer_char(output, ')');
    }
}

/* Appends index, eigenvalues and eigenvectors of each equilibrium. Of two conjugate eigenvalues one
 * line is written, with +-. */
static void put_vectors(struct buffer *output, const struct system *system,
                        const struct equilibria *found)
{
    for (int e = 0; e < found->count; e++) {
        const struct solution *s = &found->solution[e];
        buffer_format(output, "  %d: index ", e + 1);
        buffer_format(output, found->form[e].index ? "%+d\n" : "not known\n", found->form[e].index);
        for (int k = 0; k < s->values; k++) {
            buffer_put(output, TEXT("     "));
            put_eigenvalue(output, &s->value[k], "+-");
            buffer_put(output, TEXT(" along"));
            put_vector(output, &found->form[e], k, system->n);
            buffer_char(output, '\n');
            k += s->value[k].im != 0 && k + 1 < s->values;
        }
    }
}

/* Appends the search region. */
static void put_region(struct buffer *output, const struct system *system, double box[][2])
{
    for (int i = 0; i < system->n; i++) {
        const struct variable variable = system_variable(system, i);
        buffer_format(output, "%s%s = %s", i > 0 ? ", " : "", variable.name,
                      SHOWN_RANGE(box[i][0], box[i][1], variable.quantity, 3));
    }
}

/* Appends the number of equilibria, whether they are proven to be all, and their table. */
static void put_found(struct buffer *output, const struct system *system, double box[][2],
                      const struct equilibria *found, struct arena *arena)
{
    if (found->count == 0)
        buffer_put(output, found->complete ? TEXT("no equilibrium in ") : TEXT("none found in "));
    else
        buffer_format(output, "%d equilibri%s in ", found->count, found->count == 1 ? "um" : "a");
    put_region(output, system, box);
    if (found->complete)
        buffer_put(output,
                   found->count > 0 ? TEXT(": proven to be all of them\n") : TEXT(": proven\n"));
    else
        buffer_format(output, ": may be incomplete (%s)\n", found->reason);
    if (found->forced)
        buffer_put(
            output,
            TEXT(
                "of the mean over the drive's period, because a driven scene has no equilibria\n"));
    if (found->count > 0)
        put_equilibria(output, system, found, arena);
}

/* Adds the index and the eigenvectors, each as its real and its imaginary part. */
static void reply_form(const struct equilibrium_form *form, int n, struct reply *reply)
{
    reply_int(reply, "index", form->index);
    reply_array(reply, "eigenvectors");
    for (int k = 0; k < n; k++) {
        reply_array(reply, NULL);
        reply_reals(reply, NULL, form->re[k], n, "");
        reply_reals(reply, NULL, form->im[k], n, "");
        reply_close(reply);
    }
    reply_close(reply);
}

/* Adds the record `equilibrium`; `stable` is null if linear theory does not decide. */
void reply_equilibrium(const struct system *system, const struct equilibria *found, int k,
                       bool full, struct reply *reply)
{
    const struct solution *s = &found->solution[k];
    reply_begin(reply, "equilibrium");
    reply_int(reply, "n", k + 1);
    reply_state(reply, system, "state", s->state);
    reply_string(reply, "type", type_name(found->form[k].type));
    if (found->form[k].type == EQUILIBRIUM_DEGENERATE)
        reply_null(reply, "stable"); /* linear theory does not say */
    else
        reply_bool(reply, "stable", solution_stable(s));
    reply_values(reply, "eigenvalues", s);
    reply_real(reply, "residual", s->residual);
    if (full)
        reply_form(&found->form[k], s->values, reply);
    reply_end(reply);
}

/* Adds the records of all equilibria and one that tells whether they are complete. */
static void reply_equilibria(const struct system *system, const struct equilibria *found, bool full,
                             struct reply *reply)
{
    for (int k = 0; k < found->count; k++)
        reply_equilibrium(system, found, k, full, reply);
    reply_begin(reply, "equilibria");
    reply_int(reply, "count", found->count);
    reply_bool(reply, "complete", found->complete);
    reply_string(reply, "reason", found->complete ? NULL : found->reason);
    reply_end(reply);
}

/* Reads the sides of the box and --full. Sides that are not given are left unchanged. */
static bool read_sides(struct session *session, const struct arguments *args,
                       const struct system *system, double box[][2], bool *full,
                       struct error *error)
{
    const struct argument_value *sides = argument_value(args, "NAME=FROM:TO");
    struct text rest = sides->count ? sides->item->text : TEXT("");
    for (rest = text_trim(rest); rest.len > 0; rest = text_trim(rest)) {
        const struct text argument = next_key_argument(&rest);
        *full = *full || text_is(argument, "--full");
        if (!text_is(argument, "--full") && !read_side(session, args, argument, system, box, error))
            return false;
    }
    return true;
}

/* Binds *scene to *system. If its own start has no derivatives, a start inside the region that the
 * arguments request is used. Returns false with *error, with a hint if no region was requested. */
static bool bind_in_box(struct session *session, const struct arguments *args, struct scene *scene,
                        struct system *system, struct error *error)
{
    double box[LIMIT_VARIABLES][2];
    bool full = false;
    const struct system named = {.model = scene->model, .n = scene->model->n};
    for (int i = 0; i < named.n; i++)
        box[i][0] = box[i][1] = NAN;
    if (!read_sides(session, args, &named, box, &full, error))
        return false;
    if (scene_bind_inside(scene, box, system, error))
        return true;
    return named.n > 0 && isnan(box[0][0])
               ? error_hint(error, "with ranges no valid start is needed: equilibria %s=FROM:TO",
                            scene->model->variable[0].name)
               : false;
}

/* The region is read twice: once to bind the scene, which gives the natural region, then to
 * override that. */
HANDLER(equilibria)
{
    struct scene scene = session->setup.scene;
    struct equilibria_request request = {.scene = &scene,
                                         .cancel = session->front.cancel,
                                         .progress = report_fraction,
                                         .context = &session->front};
    struct system system;
    struct equilibria found;
    double box[LIMIT_VARIABLES][2];
    bool full = false;
    if (!bind_in_box(session, args, &scene, &system, error) ||
        !dynamics_search_box(session, &system, args->arena, box, error) ||
        !read_sides(session, args, &system, box, &full, error))
        return false;
    for (int i = 0; i < system.n && i < DYNAMICS_VARIABLES; i++)
        for (int k = 0; k < 2; k++)
            request.box[i][k] = box[i][k];
    const bool fine = equilibria_find(&request, &found, error);
    report_fraction(&session->front, 2);
    if (!fine)
        return false;
    if (reply_wants_text(reply)) {
        struct buffer *text = reply_buffer(reply);
        put_found(text, &system, box, &found, args->arena);
        if (full)
            put_vectors(text, &system, &found);
        buffer_format(text, "%d boxes examined", found.boxes);
        put_seconds(text, session, found.seconds);
    }
    reply_own_solver(session, NEWTON_SOLVER, reply);
    reply_equilibria(&system, &found, full, reply);
    const bool is_stored = dynamics_store_equilibria(session, &found, error);
    equilibria_free(&found);
    return is_stored;
}
#endif

COMMAND(equilibria, .group = "DYNAMICS", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("NAME=FROM:TO", TYPE_REST), OPTION("full", TYPE_NONE)))
