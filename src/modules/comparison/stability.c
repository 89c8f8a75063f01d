/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command `stability`, which predicts and verifies growth per step and the longest stable step,
 * and the plots of stability regions. */
#ifndef COMMAND_ROWS
#include <hooke/base/numeric.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>
#include <hooke/report.h>
#include "modules/comparison/compute/stability.h"
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"
#include "modules/comparison/stability/regions.h"

#include <math.h>
#include <string.h>

/* ---- one method in words ---- */

/* Appends the predicted and measured growth per step at dt and on either side of the limit
 * dt_max. */
static void put_checks(struct buffer *output, const struct stability *s)
{
    static const char *const where[] = {"  at dt: growth per step ",
                                        "  just below dt_max: ", "  just above dt_max: "};
    for (int i = 0; i < s->checks; i++) {
        const struct stability_check *check = &s->check[i];
        buffer_put(output, text_of(where[i]));
        buffer_growth(output, check->predicted);
        buffer_put(output, TEXT(" predicted, "));
        buffer_growth(output, check->measured);
        buffer_format(output, " measured in %lld steps: %s\n", (long long)check->steps,
                      check->agrees ? "agrees" : "DOES NOT AGREE");
    }
}

/* Appends what is special about the stability limit: that it is the longest step the method
 * accepts, that growth beyond it is so weak that it shows late, or that it is a narrow resonance,
 * below and above which steps are stable. */
static void put_weakness(struct buffer *output, const struct stability *s)
{
    if (s->refused)
        buffer_format(output, "  dt_max is the longest step that %s accepts here, stable or not\n",
                      s->choice.method->row.name);
    if (!isnan(s->weak[1]))
        buffer_format(output,
                      "  weak instability: growth 1 + %.3g (omega dt)^%.3g, doubles the amplitude "
                      "after %.3g steps (%s)\n",
                      s->weak[0], s->weak[1], s->doubling,
                      SHOWN_QUANTITY(s->doubling * s->dt, QUANTITY_TIME, 3));
    else if (isfinite(s->doubling) && s->doubling >= 2)
        buffer_format(output, "  doubles the amplitude after %.3g steps\n", s->doubling);
    if (!isnan(s->window[0]))
        buffer_format(output,
                      "  narrow resonance: omega dt from %.7g to %.7g, growth at most %.6g per "
                      "step; stable above it\n",
                      s->window[0] * s->tightest.omega, s->window[1] * s->tightest.omega,
                      s->window[2]);
}

/* Appends the two eigenvalues of a linear scene that does not oscillate. */
static void put_eigenvalues(struct buffer *output, const struct stability *s)
{
    double re[2], im;
    mode_eigenvalues(&s->worst, re, &im);
    buffer_format(output, "  %s: eigenvalues %.6g and %.6g 1/s\n",
                  s->worst.sign == STIFFNESS_ZERO ? "no restoring force"
                                                  : "the force pushes away from equilibrium",
                  re[0], re[1]);
}

/* Returns what became of a run of the scene itself, in words. */
static const char *outcome_name(enum stop stop)
{
    if (stop == STOP_END)
        return "arrives";
    if (stop == STOP_FULL)
        return "still bounded, stopped";
    return stop == STOP_SINGULAR ? "its solution ends" : stop_name(stop);
}

/* Appends what was found about the scene that the stability study used: omega and zeta, or the rate
 * of a first-order equation, whether the motion itself grows and, for a scene that is not linear,
 * how far a run with this dt came. */
static void put_scene(struct buffer *output, const struct session *session,
                      const struct stability *s)
{
    const double seconds = session->setup.settings.duration;
    if (s->modes && s->linear && s->worst.sign != STIFFNESS_POSITIVE)
        put_eigenvalues(output, s);
    else if (s->modes && s->linear && s->scalar)
        buffer_format(output,
                      "  one equation of first order: lambda = %.6g 1/s, lambda dt = %.6g\n",
                      -s->worst.omega, -s->worst.omega * s->dt);
    else if (s->modes && s->scalar)
        buffer_format(output,
                      "  one equation, not linear: its rate at the start and along %.4g s;\n"
                      "  dt_max comes from t = %.4g s, where it is %.4g 1/s\n",
                      seconds, s->tightest.t, -s->tightest.omega);
    else if (s->modes && s->linear)
        buffer_format(output, "  omega = %.6g 1/s, zeta = %.6g: omega dt = %.6g\n", s->worst.omega,
                      s->worst.zeta, s->worst.omega * s->dt);
    else if (s->modes)
        buffer_format(output,
                      "  not linear: eigenvalues of the Jacobian at the start and along %.4g s;\n"
                      "  dt_max comes from t = %.4g s, where omega = %.4g 1/s, zeta = %.4g\n",
                      seconds, s->tightest.t, s->tightest.omega, s->tightest.zeta);
    else
        buffer_put(output, TEXT("  this scene has no restoring force, so no step is unstable\n"));
    if (s->grows && s->linear && s->modes)
        buffer_format(
            output,
            "  the scene itself grows by %.7g per step of dt; only additional growth counts\n",
            s->growth_exact);
    else if (s->grows)
        buffer_put(output, TEXT("  the scene itself grows (eigenvalues with positive real part); "
                                "the other eigenvalues are tested\n"));
    if (s->linear)
        return;
    buffer_format(
        output,
        "  the scene itself with this dt: %s at t = %.4g s; its largest state was %.3g times the "
        "natural size\n",
        outcome_name(s->stop), s->reached, s->largest);
}

/* ---- the region ---- */

#define REGION_COLUMNS 64
#define REGION_ROWS_MAX 17
#define REGION_ROWS_MIN 7

/* Draws the region of stability into width times height cells: the upper half of the plane of z =
 * lambda dt, whose lower half is its mirror image. Cells are # where |R(z)| <= 1 and o where an
 * eigenvalue of the scene at the start lies. */
static void put_region(struct buffer *output, const struct stability *s, int width, int height)
{
    enum {
        LABELS = 12 /* [cell] left of it */,
        BESIDE = 3 /* [row] the heading, the axis, and that it is outside */
    };
    const int columns = int_max(int_min(width - LABELS, REGION_COLUMNS), LABELS),
              rows = int_max(int_min(height - BESIDE, REGION_ROWS_MAX), REGION_ROWS_MIN);
    const double real = finite_or(method_stable_limit(s->choice.method, s->choice.drag, 1), 6),
                 high = finite_or(method_stable_limit(s->choice.method, s->choice.drag, 0), 0);
    /* a margin around the limits on the axes, with some of the unstable right half */
    const double left = -1.25 * real, right = 0.45 * real;
    const double top =
        1.25 * fmax(fmax(high, real * 0.7),
                    finite_or(method_stable_limit(s->choice.method, s->choice.drag, 0.3), 0));
    const double dx = (right - left) / columns, dy = top / (rows - 1);
    char line[REGION_COLUMNS + 1];
    bool shown = false;
    buffer_put(output, width < REGION_COLUMNS ? TEXT("  #: no step grows; o: this scene\n")
                                              : TEXT("  region of stability in the plane of z = "
                                                     "lambda dt (upper half); o: this scene\n"));
    for (int row = 0; row < rows; row++) {
        const double im = top - row * dy;
        for (int column = 0; column < columns; column++) {
            const double re = left + (column + 0.5) * dx;
            line[column] = fabs(re) <= dx / 2 ? '|' : '.';
            if (stability_growth(&s->choice, re, im) <= 1 + 1e-7)
                line[column] = '#';
        }
        for (int i = 0; i < s->at_start; i++) {
            double rate[2], turn;
            mode_eigenvalues(&s->mode[i], rate, &turn);
            for (int k = 0; k < 2; k++) {
                const double column = (rate[k] * s->dt - left) / dx,
                             height_row = (top - turn * s->dt) / dy;
                if (lround(fmin(height_row, 1e3)) == row && column >= 0 && column < columns) {
                    line[(int)column] = 'o';
                    shown = true;
                }
            }
        }
        line[columns] = '\0';
        buffer_format(output, "  %6.2f %s\n", im, line);
    }
    buffer_format(output, "         %-*.2f%*.2f\n", columns / 2, left, columns / 2, right);
    if (!shown && s->modes)
        buffer_put(output, TEXT("  z of this scene is outside the picture\n"));
}

/* Draws growth per step over omega dt, undamped, for methods that only apply to forces without
 * velocity and so have no region in the plane. Returns false if out of memory. */
static bool put_growth_figure(struct buffer *output, const struct session *session,
                              const struct stability *s, int height, struct arena *arena)
{
    enum { POINTS = 400, BETWEEN = 16 };
    double *x = arena_array(arena, POINTS, sizeof *x), *y = arena_array(arena, POINTS, sizeof *y);
    const double limit = finite_or(method_stable_limit(s->choice.method, s->choice.drag, 0), 4);
    int width, whole;
    if (!x || !y)
        return false;
    for (int i = 0; i < POINTS; i++) {
        x[i] = 1.3 * limit * (i + 1) / POINTS;
        for (int k = 0; k < BETWEEN; k++) { /* a resonance is narrower than a point */
            const double omega_dt = 1.3 * limit * (i + (double)(k + 1) / BETWEEN) / POINTS;
            y[i] = fmax(y[i], method_growth(s->choice.method, s->choice.drag, omega_dt, 0) - 1);
        }
    }
    const struct curve curve = {.label = s->choice.method->row.name, .x = x, .y = y, .n = POINTS};
    const struct figure figure = {.title = "growth - 1 per step",
                                  .x = {.label = "omega dt", .unit = ""},
                                  .y = {.label = "growth - 1",
                                        .unit = "",
                                        .log = true,
                                        .fixed = true,
                                        .first_value = 1e-8,
                                        .last_value = 10},
                                  .curve = &curve,
                                  .curves = 1,
                                  .note = "0 is below the axis"};
    session_size(session, &width, &whole);
    return figure_print(&figure, width, height, session_charset(session), false, output);
}

/* Appends the region of stability, or growth over omega dt, `height` rows high, at least 8 for the
 * latter. Returns false if out of memory. */
static bool put_picture(struct buffer *output, const struct session *session,
                        const struct stability *s, int height, struct arena *arena)
{
    int width, whole;
    session_size(session, &width, &whole);
    if (isnan(stability_growth(&s->choice, -0.5, 0.5)))
        return put_growth_figure(output, session, s, height > 8 ? height : 8, arena);
    put_region(output, s, width, height);
    return true;
}

/* ---- the table ---- */

/* Appends the table with a line for each method. */
static void stability_table_put(struct buffer *output, const struct stability *rows, int count,
                                int width, struct arena *arena)
{
    struct text_table table = {.arena = arena, .gap = 2, .max = width};
    columns_text(&stability_columns, rows, (size_t)count, true, &table);
    text_table_put(&table, output);
}

/* ---- the command ---- */

/* Studies the methods that the statement names, or the session's own, into rows [*count]. If there
 * are several, those that do not apply are skipped and appended to `absent` with the reason.
 * Returns false with an error if none is left or if cancelled. */
static bool study_each(const struct session *session, const struct arguments *args,
                       struct stability *rows, int *count, struct buffer *absent,
                       struct error *error)
{
    const struct argument_value *dt = argument_value(args, "dt");
    const int capacity = argument_value(args, "METHOD")->count + 1;
    struct method_choice *choice = arena_array(args->arena, (size_t)capacity, sizeof *choice);
    int wanted = 1;
    if (!choice)
        return error_memory(error);
    choice[0] = (struct method_choice){session->setup.method, session->setup.drag};
    if (!choose_methods(args, DRAG_DEFAULT, choice, &wanted, error))
        return false;
    for (int i = 0; i < wanted; i++) {
        const struct stability_request request = {
            .scene = &session->setup.scene,
            .choice = choice[i],
            .dt = dt->count ? dt->item->value.value : session->setup.settings.dt,
            .duration = session->setup.settings.duration,
            .cancel = session->front.cancel,
        };
        if (study_stability(&request, &rows[*count], error))
            (*count)++;
        else if (wanted == 1 || error->code != ERROR_COMMAND)
            return false;
        else
            buffer_format(absent, "left out: %s\n", error->text);
    }
    return *count > 0;
}

/* ---- its plots ---- */

/* Returns the methods of the latest `stability`, with their drag variants, and sets *dt to its step
 * [s]; without such a study the session's own method. *count grows by their number. Memory is from
 * the arena; returns NULL if out of memory. */
static struct method_choice *last_studied(const struct session *session, int *count, double *dt,
                                          struct arena *arena)
{
    const struct table *last = drawing_stored(session, "stability");
    const size_t rows = last ? last->rows : 0;
    struct method_choice *choice = arena_array(arena, rows + 1, sizeof *choice);
    const struct table_column *drags = last ? table_column_named(last, "drag") : NULL;
    const struct table_column *steps = last ? table_column_named(last, "dt") : NULL;
    for (size_t i = 0; choice && i < rows; i++) {
        const struct method *known = method_find(last->column[0].text[i]);
        const struct row *drag =
            drags && drags->text ? catalog_find(&drag_catalog, text_of(drags->text[i])) : NULL;
        if (known)
            choice[(*count)++] = (struct method_choice){
                known,
                drag ? (enum drag)(catalog_index(&drag_catalog, drag) + DRAG_EXACT) : DRAG_DEFAULT};
        if (steps && steps->value)
            *dt = steps->value[i];
    }
    if (choice && *count == 0)
        choice[(*count)++] = (struct method_choice){session->setup.method, session->setup.drag};
    return choice;
}

/* Returns true unless all points of a region are the origin, as for methods without a growth
 * function in this plane. */
static bool has_extent(const struct region *region)
{
    for (size_t i = 0; i < (size_t)region->rows; i++)
        if (fabs(region->row[i].x) > 0 || fabs(region->row[i].y) > 0)
            return true;
    return false;
}

/* Studies the methods choice [choices] with step dt into `studied`, traces the boundaries of their
 * regions in the plane, and stores these as a result. Of several methods, those that do not apply
 * are left out with a note. Returns false with an error if none is left, if out of memory, or if
 * cancelled. */
static bool trace_regions(struct session *session, enum region_plane plane,
                          const struct method_choice *choice, int choices, double dt,
                          struct stability *studied, struct reply *reply, struct error *error)
{
    struct stability_request request = {.scene = &session->setup.scene,
                                        .dt = dt,
                                        .duration = session->setup.settings.duration,
                                        .cancel = session->front.cancel};
    struct region region = {0};
    int count = 0;
    for (int i = 0; i < choices; i++) {
        request.choice = choice[i];
        if (study_stability(&request, &studied[count], error))
            count++;
        else if (choices == 1 || error->code != ERROR_COMMAND)
            return false;
        else
            reply_note(reply, "left out: %s", error->text);
    }
    const bool ok =
        count > 0 && region_trace(plane, studied, count, request.cancel, &region, error);
    const bool empty = ok && !has_extent(&region);
    if (ok && !empty)
        reply_result(session, reply, catalog_row(&region_catalog, plane)->name,
                     region_columns(plane), region.row, region.rows, NULL, NULL);
    region_free(&region);
    if (!empty)
        return ok;
    error_set(error, ERROR_COMMAND, "%s has no growth function of lambda dt to draw",
              choice[0].method->row.name);
    return error_hint(error, "'stability %s' measures its growth", choice[0].method->row.name);
}

/* Makes the table of boundaries for a plot: of the given methods with the session's step, or if
 * there are none, of those that were studied last. Returns false with an error as trace_regions()
 * does. */
static bool study_plane(struct session *session, enum region_plane plane,
                        const struct row *const *method, int methods, struct reply *reply,
                        struct error *error)
{
    struct arena arena = {0};
    double dt = session->setup.settings.dt;
    struct method_choice *choice = methods ? methods_choice(session, method, &methods, &arena)
                                           : last_studied(session, &methods, &dt, &arena);
    struct stability *studied = arena_array(&arena, (size_t)methods + 1, sizeof *studied);
    const bool ok = choice && studied
                        ? trace_regions(session, plane, choice, methods, dt, studied, reply, error)
                        : error_memory(error);
    arena_reset(&arena);
    return ok;
}

/* Defines the function that plots.h declares for the plot of one plane. */
#define PLANE_STUDY(name, plane)                                                                   \
    bool name(struct session *session, const struct row *const *method, int methods,               \
              struct reply *reply, struct error *error)                                            \
    {                                                                                              \
        return study_plane(session, plane, method, methods, reply, error);                         \
    }
PLANE_STUDY(boundary_study, REGION_Z)
PLANE_STUDY(stars_study, REGION_STARS)
PLANE_STUDY(region_study, REGION_DAMPED)

/* Appends the table of all methods. One method is also described in words and, if `pictured`, with
 * a picture in the remaining height if that is enough; with --full all methods are described. */
static void put_study(const struct session *session, const struct arguments *args,
                      const struct stability *rows, int count, bool pictured,
                      const struct buffer *absent, struct buffer *text)
{
    enum { PICTURE_ROWS_MIN = 8 };
    int width, height;
    struct buffer lines = {0};
    session_size(session, &width, &height);
    stability_table_put(text, rows, count, width, args->arena);
    buffer_put(&lines, buffer_text(absent));
    for (int i = 0; i < count && (count == 1 || asks_full(args)); i++) {
        buffer_format(&lines, "%s:\n", rows[i].choice.method->row.name);
        put_scene(&lines, session, &rows[i]);
        put_checks(&lines, &rows[i]);
        put_weakness(&lines, &rows[i]);
    }
    if (count > 1 && !asks_full(args))
        buffer_put(
            &lines,
            TEXT("'stability METHOD' shows checks and region of one method, --full all checks\n"));
    put_folded_lines(&lines, width, text);
    buffer_free(&lines);
    if (!asks_full(args))
        height = answer_rows(session) - text_rows(buffer_text(text), width);
    if (count == 1 && pictured && height < PICTURE_ROWS_MIN && !asks_full(args))
        buffer_put(text, TEXT("'plot stability' draws its region\n"));
    else if (count == 1 && pictured && !put_picture(text, session, &rows[0], height, args->arena))
        text->failed = true;
}

/* Executes `stability`, for the named methods or the session's own. */
HANDLER(stability)
{
    const struct argument_value *methods = argument_value(args, "METHOD");
    struct stability *rows = arena_array(args->arena, (size_t)methods->count + 1, sizeof *rows);
    struct buffer absent = {0};
    int count = 0;
    if (!rows)
        return error_memory(error);
    const bool ok = study_each(session, args, rows, &count, &absent, error);
    if (count > 0 && reply_wants_text(reply))
        put_study(session, args, rows, count, ok && methods->count <= 1, &absent,
                  reply_buffer(reply));
    buffer_free(&absent);
    if (count > 0)
        reply_result(session, reply, "stability", &stability_columns, rows, (size_t)count, NULL,
                     NULL);
    reply_records(reply, "stability", &stability_columns, rows, (size_t)count);
    return ok;
}
#endif

COMMAND(stability, .group = "STUDY", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("METHOD", TYPE_CHOICE, .flags = ARG_MANY, .choices = &method_catalog),
                  KEY("dt", TYPE_VALUE, .quantity = QUANTITY_TIME),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog), OPTION("full", TYPE_NONE)))
