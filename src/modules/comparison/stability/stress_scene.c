/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes the cases of `stress scene`: the caller's scene unchanged, with other steps, with each
 * parameter changed, and with extreme initial values. */
#include <hooke/base/catalog.h>
#include "modules/comparison/stability/stress.h"

#include <math.h>

/* Appends a case of the scene, whose name and description are copied. Returns NULL if out of memory
 * or if there are STRESS_MAX already. */
static struct stress_case *stress_case_add(struct stress *stress, const struct stress_scene *source,
                                           const char *name, const struct buffer *brief)
{
    if (stress->count == STRESS_MAX)
        return NULL;
    struct stress_case *what = &stress->cases[stress->count];
    *what = (struct stress_case){.name = arena_text(&stress->text, text_of(name)),
                                 .brief = arena_text(&stress->text, buffer_text(brief)),
                                 .stress_scene = source,
                                 .span = source->span};
    if (!what->name || !what->brief)
        return NULL;
    stress->count++;
    return what;
}

/* Appends cases with steps below and above the method's stability limit. */
static void add_steps(struct stress *stress, const struct stress_scene *source)
{
    static const double factors[] = {0.5, 0.99, 1.01, 2, 10, 1000};
    for (size_t i = 0; i < COUNT_OF(factors); i++) {
        struct buffer name = {0}, brief = {0};
        buffer_format(&name, "dt x %s", SHOWN_SHORT(factors[i], 4));
        buffer_put(
            &brief,
            TEXT("times the method's stability limit (if it has none, the fastest time constant)"));
        struct stress_case *what =
            name.failed || brief.failed ? NULL : stress_case_add(stress, source, name.data, &brief);
        if (what) {
            what->change = STRESS_STEP;
            what->fixed = true;
            what->value = factors[i];
        }
        buffer_free(&name);
        buffer_free(&brief);
    }
}

/* Appends cases with one parameter very small, very large, 0 and of opposite sign. */
static void add_param(struct stress *stress, const struct stress_scene *source, int index)
{
    static const struct {
        const char *sign;
        double factor;
    } change[] = {{" x 1e-6", 1e-6}, {" x 1e6", 1e6}, {" = 0", 0}, {" x -1", -1}};
    const struct row *row = catalog_row(scene_params(source->scene), (size_t)index);
    for (size_t i = 0; i < COUNT_OF(change); i++) {
        const double value = source->scene->value[index] * change[i].factor;
        struct buffer name = {0}, brief = {0};
        buffer_format(&name, "%s%s", row->name, change[i].sign);
        buffer_format(&brief, "%s = %s", row->name, SHOWN_SHORT(value, 6));
        if (*row->unit)
            buffer_format(&brief, " %s", row->unit);
        struct stress_case *what =
            name.failed || brief.failed ? NULL : stress_case_add(stress, source, name.data, &brief);
        if (what) {
            what->change = STRESS_PARAM;
            what->param = index;
            what->value = value;
        }
        buffer_free(&name);
        buffer_free(&brief);
    }
}

/* Appends cases with tiny and huge initial values. */
static void add_starts(struct stress *stress, const struct stress_scene *source)
{
    static const struct {
        const char *name;
        double value;
    } starts[] = {{"start 1e-310", 1e-310}, {"start 1e-150", 1e-150}, {"start 1e150", 1e150}};
    for (size_t i = 0; i < COUNT_OF(starts); i++) {
        struct buffer brief = {0};
        buffer_put(&brief, TEXT("initial values other than 0, or the first if all are 0"));
        struct stress_case *what =
            brief.failed ? NULL : stress_case_add(stress, source, starts[i].name, &brief);
        if (what) {
            what->change = STRESS_START;
            what->value = starts[i].value;
        }
        buffer_free(&brief);
    }
}

/* Adds the cases of a scene to stress->cases. */
bool stress_scene_cases(struct stress *stress, const struct stress_scene *source)
{
    const int params = (int)scene_params(source->scene)->count;
    struct buffer brief = {0};
    buffer_put(&brief, TEXT("nothing is changed"));
    if (!brief.failed)
        stress_case_add(stress, source, "as it is", &brief);
    buffer_free(&brief);
    add_steps(stress, source);
    for (int i = 0; i < params; i++)
        if (source->matter[i] && source->scene->value[i] != 0)
            add_param(stress, source, i);
    add_starts(stress, source);
    return stress->count > 0 && stress->cases[stress->count - 1].change == STRESS_START;
}

/* Makes *scene the caller's scene with the change of the case. */
bool stress_scene_set(const struct stress_case *what, struct scene *scene, struct error *error)
{
    const struct stress_scene *source = what->stress_scene;
    const int params = (int)scene_params(source->scene)->count;
    int first = -1, moved = 0;
    *scene = *source->scene;
    if (what->change == STRESS_PARAM)
        return scene_set(scene, what->param, (struct measured){what->value, 0}, error);
    for (int i = params - 1; i >= 0 && what->change == STRESS_START; i--) {
        if (!source->start[i])
            continue;
        first = i;
        if (scene->value[i] != 0 && ++moved &&
            !scene_set(scene, i, (struct measured){what->value, 0}, error))
            return false;
    }
    return moved > 0 || first < 0 ||
           scene_set(scene, first, (struct measured){what->value, 0}, error);
}

/* Returns the largest stable step [s] of the method for the fastest mode of the states. */
double stress_limit(const struct system *system, const double *y, int states, int every,
                    const struct method *method)
{
    const struct method_choice choice = {.method = method};
    struct mode fastest = {0};
    for (int k = 0; k < states; k += every) {
        struct mode mode[LIMIT_VARIABLES];
        int modes = 0;
        modes_at(system, system->t0, y + k * system->n, mode, &modes, LIMIT_VARIABLES);
        for (int i = 0; i < modes; i++)
            if (mode[i].omega > fastest.omega)
                fastest = mode[i];
    }
    const double limit = fastest.omega > 0 ? mode_limit(&choice, &fastest) : HUGE_VAL;
    /* The time constant is the unit without a positive finite limit. */
    return limit > 0 && isfinite(limit) ? limit : 1 / fastest.omega;
}
