/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits of the scene (fit scene) and of formulas (fit EXPR): arguments, report, and what is kept in
 * the session. */
#include <hooke/scene/formula.h>
#include "modules/recording/fit_text.h"
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what stays ---- */

/* Stores the fitted curve (samples minus residuals) in the session as the last fit, which owns the
 * copies. Returns false with the error if out of memory; the previous fit then remains. */
bool session_add_curve(const struct fit_request *call, const double *residual,
                       const struct fit *fit, struct error *error)
{
    struct session *session = call->session;
    const struct subject *subject = call->subject;
    const struct series *series = &subject->series;
    double *t = calloc(series->n, sizeof *t), *y = calloc(series->n, sizeof *y);
    if (!t || !y) {
        free(t);
        free(y);
        return error_memory(error);
    }
    for (size_t i = 0; i < series->n; i++) {
        t[i] = series->t[i];
        y[i] = series->y[i] - residual[i];
    }
    struct fits *fits = fits_made(session);
    fits_drop_curve(fits);
    fits->fit_curve[0] = t;
    fits->fit_curve[1] = y;
    fits->fit_samples = series->n;
    fits->fit = *fit;
    fits->has_fit = true;
    fits->fit_zero = subject->recording ? subject->recording->zero : 0;
    memcpy(fits->fit_of, subject->name, sizeof fits->fit_of);
    return true;
}

/* Returns the rms of the residuals of samples with weight, each with equal weight, as the rms of a
 * run is computed. */
static double plain_rms(const struct curve_fit *fit, size_t n)
{
    double sum = 0;
    size_t used = 0;
    for (size_t i = 0; i < n; i++) {
        if (!(fit->weight[i] > 0) || !isfinite(fit->residual[i]))
            continue;
        sum += fit->residual[i] * fit->residual[i];
        used++;
    }
    return sqrt(sum / (double)used);
}

/* Stores the curve at the samples as the last fit, and its parameters as results (fit_NAME).
 * `offset` is the fitted or stated offset. Returns false with the error if out of memory. */
static bool keep_curve(const struct fit_request *call, const struct fit_summary *summary,
                       const char *model, struct measured offset, struct error *error)
{
    static const struct measured none = {NAN, NAN};
    struct session *session = call->session;
    const struct series *series = &call->subject->series;
    const struct fit fit = {.model = model,
                            .period = none,
                            .omega = none,
                            .gamma = none,
                            .amplitude = none,
                            .phase = none,
                            .offset = offset,
                            .rms = plain_rms(summary->curve, series->n),
                            .used = summary->curve->used,
                            .converged = true,
                            .window = {series->t[0], series->t[series->n - 1]}};
    if (!session_add_curve(call, summary->curve->residual, &fit, error))
        return false;
    for (int j = 0; j < summary->curve->parameters; j++) {
        char name[LIMIT_NAME + 1];
        snprintf(name, sizeof name, "fit_%.*s", LIMIT_NAME - 4, summary->name[j]);
        session_set_result(session, name, summary->curve->value[j], summary->quantity[j]);
    }
    session_set_result(session, "fit_rms", (struct measured){summary->curve->sigma, 0},
                       series->quantity);
    return true;
}

/* Reports a fit and keeps it if it converged. Returns false with the error otherwise. */
static bool report_and_keep(const struct fit_request *call, struct fit_summary *summary,
                            const char *model, struct measured offset, struct error *error)
{
    fit_add_residuals(summary);
    if (summary->curve->converged && !keep_curve(call, summary, model, offset, error))
        return false;
    reply_fit(summary, call->args->arena, call->reply);
    if (summary->curve->converged)
        return true;
    error_set(error, ERROR_NUMERICAL, "the fit %s", summary->curve->said);
    return error_hint(error, "give other starts, free fewer parameters, or choose a window");
}

/* Returns the requested number of bootstrap samples, or 0. */
static int bootstrap_of(const struct arguments *args)
{
    return has_argument(args, "bootstrap")
               ? (int)fmin(argument_value(args, "bootstrap")->item->value.value, 1e6)
               : 0;
}

/* ---- the scene ---- */

static bool is_offset(struct text name)
{
    return text_is(name, "offset");
}

/* Sets the scene's parameters to the given NAME=VALUE, and *offset to a given offset; it stays NAN
 * if the offset is to be fitted. Returns false with the error. */
static bool take_values(const struct fit_request *call, struct scene *scene, double *offset,
                        struct error *error)
{
    const struct argument_value *starts = argument_value(call->args, "NAME");
    for (int i = 0; i < starts->count; i++) {
        const struct item *item = &starts->item[i];
        const int index = scene_param_at(scene, item->text);
        if (is_offset(item->text)) {
            *offset = item->value.value;
            continue;
        }
        if (index < 0)
            return unknown_parameter(call->session, item->text, TEXT(""), error);
        if (!scene_set(scene, index, item->value, error)) {
            error->where = item->text;
            return false;
        }
    }
    return true;
}

/* Appends the parameters that free= names to index[] and increases *count. The offset is left out,
 * as it is always free unless a value is stated. Returns false with the error for unknown or
 * repeated names. */
static bool take_free(const struct fit_request *call, int *index, int *count, struct error *error)
{
    const struct argument_value *names = argument_value(call->args, "free");
    for (int i = 0; i < names->count; i++) {
        const struct item *item = &names->item[i];
        bool twice = false;
        /* The offset is always free, unless offset=VALUE holds it. */
        if (is_offset(item->text))
            continue;
        if (item->index < 0)
            return unknown_parameter(call->session, item->text, TEXT(""), error);
        for (int j = 0; j < *count; j++)
            twice = twice || index[j] == item->index;
        if (twice)
            return error_at(error, item->text, "'%.*s' is given twice", (int)item->text.len,
                            item->text.data);
        if (*count < PARAM_MAX)
            index[(*count)++] = item->index;
    }
    return true;
}

/* Returns the parameters that the fit held fixed, as inputs. */
static struct inputs exact_in(const struct scene *scene, const int *index, int count)
{
    struct inputs inputs = {.exacts = 0};
    bool is_free[PARAM_MAX] = {false};
    for (int i = 0; i < count; i++)
        is_free[index[i]] = true;
    inputs_use_motion(&inputs, scene, is_free);
    return inputs;
}

/* Returns a text such as "k = 15 N/m, m = 0.2 kg, as set (free=NAME,.. fits them)" from the arena,
 * or NULL if nothing is held. */
static const char *describe_fixed(const struct scene *scene, const int *fixed, int count,
                                  struct arena *arena)
{
    struct buffer text = {0};
    for (int i = 0; i < count; i++) {
        const struct param_row *row = param_at(scene, fixed[i]);
        const struct measured value = {scene->value[fixed[i]], scene->uncertainty[fixed[i]]};
        buffer_format(&text, "%s%s = %s", i ? ", " : "", row->row.name,
                      SHOWN_MEASURED(value, row->quantity, 6));
    }
    buffer_put(&text, count ? TEXT(", as set (free=NAME,.. fits them)") : TEXT(""));
    const char *copy = text.len ? arena_text(arena, buffer_text(&text)) : NULL;
    buffer_free(&text);
    return copy;
}

/* Subtracts an offset from a copy of the series. Returns false with the error if out of memory. */
static bool subtract_offset(struct series *series, double offset, struct arena *arena,
                            struct error *error)
{
    double *y = arena_array(arena, series->n, sizeof *y);
    if (!y)
        return error_memory(error);
    for (size_t i = 0; i < series->n; i++)
        y[i] = series->y[i] - offset;
    series->y = y;
    return true;
}

/* Copies the covariances of the `frees` free parameters, in ascending order of their indices in the
 * scene; result->n becomes 0 if one is not determined. Parameters at a bound have none (0). */
static void copy_covariances(const struct scene_fit *fit, int frees, struct fit_covariance *result)
{
    int order[CURVE_PARAMETERS];
    *result = (struct fit_covariance){.n = frees};
    for (int j = 0; j < frees; j++) {
        order[j] = 0;
        for (int l = 0; l < frees; l++)
            order[j] += fit->index[l] < fit->index[j];
    }
    for (int j = 0; j < frees; j++)
        for (int l = 0; l < frees; l++) {
            const bool bound = fit->curve.bound[j] || fit->curve.bound[l];
            const double value = bound ? 0 : fit->curve.covariance[j][l];
            result->entry[order[j]][order[l]] = value;
            result->n = isfinite(value) ? result->n : 0;
        }
}

/* Fits parameters of the scene to the subject by integrating it, replies with them and stores the
 * result. Returns false with the error. */
bool fit_the_scene(const struct fit_request *call, struct error *error)
{
    struct session *session = call->session;
    struct arena *arena = call->args->arena;
    struct scene scene = session->setup.scene;
    struct series series = call->subject->series;
    struct scene_fit fit;
    int index[PARAM_MAX], fixed[PARAM_MAX], count = 0, fixed_count = 0;
    double offset = NAN;
    if (!take_values(call, &scene, &offset, error) || !take_free(call, index, &count, error))
        return false;
    if (count == 0)
        count = scene_fit_usual(&session->setup.scene, index, fixed, &fixed_count);
    if (isfinite(offset) && !subtract_offset(&series, offset, arena, error))
        return false;
    const struct scene_fit_request request = {.scene = &scene,
                                              .series = &series,
                                              .free = index,
                                              .frees = count,
                                              .offset = isnan(offset),
                                              .robust = true,
                                              .bootstrap = bootstrap_of(call->args),
                                              .seed = 1,
                                              .cancel = session->front.cancel};
    if (!study_fit_scene(&request, arena, &fit, error))
        return false;
    enum quantity quantity[CURVE_PARAMETERS];
    for (int j = 0; j < fit.curve.parameters; j++)
        quantity[j] =
            fit.index[j] >= 0 ? param_at(&scene, fit.index[j])->quantity : series.quantity;
    struct fit_summary summary = {.subject = call->subject,
                                  .model = "scene",
                                  .curve = &fit.curve,
                                  .name = fit.name,
                                  .quantity = quantity,
                                  .fixed = describe_fixed(&scene, fixed, fixed_count, arena),
                                  .inputs = exact_in(&scene, index, count),
                                  .k = {NAN, NAN}};
    const int last = fit.curve.parameters - 1, friction = scene_param(&fit.scene, "friction");
    const bool sticks = friction >= 0 && fit.scene.value[friction] > 0;
    fit_add_window(&summary, sticks ? WINDOW_LAW_STICKS : WINDOW_LAW_SINE, arena);
    if (!report_and_keep(call, &summary, "scene",
                         request.offset ? fit.curve.value[last] : (struct measured){offset, 0},
                         error))
        return false;
    struct fits *fits = fits_made(session);
    fits->fit_scene = fit.scene;
    copy_covariances(&fit, count, &fits->fit.covariance);
    memset(fits->fit_free, 0, sizeof fits->fit_free);
    for (int j = 0; j < count; j++)
        fits->fit_free[index[j]] = true;
    return true;
}

/* ---- a formula ---- */

/* Names that are constants in a formula: all names of the session, except those that were made free
 * and the states of runs, which vary. */
struct known_names {
    const struct expr_scope *all;
    const struct arguments *args;
    struct buffer *fixed; /* receives the names that were used */
};

/* Returns true if the user named it in free= or NAME=. */
static bool is_named_by_user(const struct arguments *args, struct text name)
{
    static const char *const lists[] = {"free", "NAME"};
    for (size_t l = 0; l < COUNT_OF(lists); l++)
        for (int i = 0; i < argument_value(args, lists[l])->count; i++)
            if (text_equal(argument_value(args, lists[l])->item[i].text, name))
                return true;
    return false;
}

/* Looks a name up for the compiler of formulas and adds a constant to the list of fixed values.
 * Returns false for names that are to be fitted: those with a start value, observables, and
 * variables of scenes. */
static bool find_known(const void *context, struct text name, int *slot)
{
    const struct known_names *known = context;
    if (is_named_by_user(known->args, name) || catalog_find(&observable_catalog, name) ||
        text_is(name, "v"))
        return false;
    for (const struct model *const *model = scene_models; *model; model++)
        if (model_variable(*model, name) >= 0)
            return false;
    if (!known->all->find(known->all->context, name, slot))
        return false;
    const double value = known->all->load(known->all->context, *slot);
    buffer_format(known->fixed, "%s%.*s = %s", known->fixed->len ? ", " : "", (int)name.len,
                  name.data, SHOWN_VALUE(value, name_quantity(known->all, name), 6));
    return true;
}

/* Loads a name that find_known() found. */
static double load_known(const void *context, int slot)
{
    const struct known_names *known = context;
    return known->all->load(known->all->context, slot);
}

static bool has_parameter(const struct formula *formula, struct text name)
{
    for (int j = 0; j < formula->parameters; j++)
        if (text_is(name, formula->name[j]))
            return true;
    return false;
}

/* Compiles the formula and sets its starts. fixed receives the constants that it uses. Returns
 * false with the error. */
static bool read_formula(const struct fit_request *call, struct text text, struct buffer *fixed,
                         struct formula *formula, struct error *error)
{
    const struct known_names known = {call->args->scope, call->args, fixed};
    const struct expr_scope scope = {.context = &known, .find = find_known, .load = load_known};
    const struct argument_value *starts = argument_value(call->args, "NAME"),
                                *names = argument_value(call->args, "free");
    size_t used = 0;
    if (!formula_compile(text, &scope, NULL, 0, call->args->arena, formula, &used, error))
        return false;
    const struct text rest = text_trim(text_after(text, used));
    if (rest.len > 0)
        return error_at(error, rest, "the formula ends before '%.*s'",
                        (int)(rest.len < 40 ? rest.len : 40), rest.data);
    for (int i = 0; i < starts->count; i++)
        if (!formula_start(formula, starts->item[i].text, starts->item[i].value.value, error))
            return false;
    for (int i = 0; i < names->count; i++)
        if (!has_parameter(formula, names->item[i].text))
            return error_at(error, names->item[i].text, "the formula has no '%.*s'",
                            (int)names->item[i].text.len, names->item[i].text.data);
    return true;
}

/* Fits the parameters of the formula `text` to the subject, replies with them and stores the
 * result. Returns false with the error. */
bool fit_a_formula(const struct fit_request *call, struct text text, struct error *error)
{
    struct arena *arena = call->args->arena;
    struct formula formula;
    struct curve_fit fit;
    struct buffer fixed = {0};
    bool ok = read_formula(call, text, &fixed, &formula, error);
    const char *fixed_text = fixed.len ? arena_text(arena, buffer_text(&fixed)) : NULL;
    buffer_free(&fixed);
    const struct curve_options options = {.robust = has_argument(call->args, "robust"),
                                          .bootstrap = bootstrap_of(call->args),
                                          .seed = 1,
                                          .cancel = call->session->front.cancel};
    ok = ok && formula_fit(&formula, &call->subject->series, &options, arena, &fit, error);
    if (!ok)
        return false;
    enum quantity quantity[CURVE_PARAMETERS];
    for (int j = 0; j < formula.parameters; j++)
        quantity[j] = QUANTITY_OTHER;
    const char *model = arena_text(arena, text);
    struct fit_summary summary = {.subject = call->subject,
                                  .model = model ? model : "formula",
                                  .curve = &fit,
                                  .name = formula.name,
                                  .quantity = quantity,
                                  .fixed = fixed_text,
                                  .k = {NAN, NAN}};
    return report_and_keep(call, &summary, "formula", (struct measured){0, 0}, error);
}
