/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every model against what it claims, by way of every preset: names, scales, Jacobians, potentials,
 * power, drag. The checks see systems, not models, so a new one is tested as soon as it is listed.
 */
#include <hooke/base/unit.h>
#include "unit/scene/testing.h"

#include <math.h>
#include <string.h>

static struct scene scene_of(const struct preset *preset)
{
    struct scene scene;
    scene_init(&scene, preset);
    return scene;
}

static struct system bind_or_fail(const struct scene *scene)
{
    struct system system;
    struct error error = {0};
    if (!scene_bind(scene, &system, &error))
        fail_msg("%s: %s", scene->preset->row.name, error.text);
    return system;
}

/* Every optional term is switched on by a value for each parameter that is 0. */
static struct scene busy_scene(const struct preset *preset, uint64_t *seed)
{
    struct scene scene = scene_of(preset);
    for (size_t i = 0; i < scene_params(&scene)->count; i++)
        if (scene.value[i] == 0 && !strstr(catalog_row(scene_params(&scene), i)->name, "0"))
            scene.value[i] = random_between(seed, 0.1, 0.4);
    return scene;
}

TEST(test_tables)
{
    assert_true(scene_models[0] == &oscillator_model);
    for (size_t m = 0; scene_models[m]; m++) {
        const struct model *model = scene_models[m];
        bool used = false;
        for (size_t i = 0; i < preset_catalog.count; i++)
            used |= scene_of(preset_at(i)).model == model;
        assert_true(used && model->row.brief[0] && (model->order == 1 || model->n % 2 == 0));
        assert_true(model->n >= 1 && model->n <= LIMIT_VARIABLES &&
                    model->params->count <= PARAM_MAX);
        assert_true(model->terms->count <= TERM_MAX);
        for (size_t i = 0; i < model->params->count; i++) {
            const struct param_row *param = (const struct param_row *)catalog_row(model->params, i);
            assert_true(param->row.brief[0]);
            assert_string_equal(param->row.unit, quantity_unit(param->quantity));
            assert_true(param->min_excluded ? param->initial > param->min
                                            : param->initial >= param->min);
            for (int v = 0; v < model->n; v++) /* a name in an expression means one thing */
                assert_string_not_equal(param->row.name, model->variable[v].name);
            static const char *const observables[] = {
                "t",     "v",          "a",     "energy", "kinetic",  "potential",
                "work",  "dissipated", "power", "error",  "momentum", "amplitude",
                "exact", "dt",         "tol",   "y"};
            for (size_t o = 0; o < COUNT_OF(observables); o++)
                assert_string_not_equal(param->row.name, observables[o]);
            assert_null(catalog_find(model->derived, text_of(param->row.name)));
        }
        for (size_t i = 0; i < model->terms->count; i++) {
            const struct term_row *term = (const struct term_row *)catalog_row(model->terms, i);
            bool conservative = term->flags & TERM_CONSERVATIVE;
            assert_true(term->row.brief[0] && term->bind && term->add);
            assert_true(conservative == (term->potential != NULL));
        }
    }
}

/* ---- a bound system at a random state ---- */

struct sample {
    const char *name;
    struct system system;
    double t, y[LIMIT_VARIABLES];
};

/* Central differences over steps h_j, of the derivative or one term: relative to the sizes that
 * enter. */
static bool check_jacobian(const struct sample *s)
{
    const struct system *system = &s->system;
    int n = system->n;
    double jac[LIMIT_VARIABLES * LIMIT_VARIABLES];
    system_jacobian(system, s->t, s->y, jac);
    for (int j = 0; j < n; j++) {
        double up[LIMIT_VARIABLES], down[LIMIT_VARIABLES], f[LIMIT_VARIABLES], g[LIMIT_VARIABLES];
        memcpy(up, s->y, sizeof up);
        memcpy(down, s->y, sizeof down);
        double h = ldexp(system->scale[j], -17);
        up[j] += h;
        down[j] -= h;
        system_derivative(system, s->t, up, f);
        system_derivative(system, s->t, down, g);
        for (int i = 0; i < n; i++) {
            double slope = (f[i] - g[i]) / (up[j] - down[j]);
            double size = fabs(slope) + (fabs(f[i]) + fabs(g[i])) / system->scale[j];
            if (!(fabs(jac[i * n + j] - slope) <= 1e-6 * size))
                return false;
        }
    }
    return true;
}

/* mass times the acceleration of the conservative terms is minus the potential's slope. */
static bool check_potential(const struct sample *s)
{
    const struct system *system = &s->system;
    int half = system->n / 2;
    double a[LIMIT_VARIABLES] = {0};
    if (system->order != 2)
        return system_potential(system, s->y) == 0 && !system->conservative;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->potential)
            system->term[i].row->add(system->term[i].c, s->t, s->y, a);
    for (int i = 0; i < half; i++) {
        double up[LIMIT_VARIABLES], down[LIMIT_VARIABLES], h = ldexp(system->scale[i], -17);
        memcpy(up, s->y, sizeof up);
        memcpy(down, s->y, sizeof down);
        up[i] += h;
        down[i] -= h;
        double p = system_potential(system, up), q = system_potential(system, down);
        double force = (q - p) / (up[i] - down[i]), wanted = system->mass * a[i];
        double size = fabs(wanted) + (fabs(p) + fabs(q)) / system->scale[i];
        if (!(fabs(force - wanted) <= 1e-6 * size))
            return false;
    }
    return true;
}

/* What the other terms do: force times velocity, summed over the coordinates. */
static bool check_power(const struct sample *s)
{
    const struct system *system = &s->system;
    int half = system->n / 2;
    if (system->order != 2)
        return system_power(system, s->t, s->y) == 0;
    double wanted = 0, size = 0;
    for (int i = 0; i < system->terms; i++) {
        double a[LIMIT_VARIABLES] = {0};
        if (system->term[i].row->potential)
            continue;
        system->term[i].row->add(system->term[i].c, s->t, s->y, a);
        for (int k = 0; k < half; k++) {
            wanted += system->mass * a[k] * s->y[half + k];
            size += fabs(system->mass * a[k] * s->y[half + k]);
        }
    }
    return fabs(system_power(system, s->t, s->y) - wanted) <= 1e-13 * size;
}

/* dE/dt = P: the slope of the energy along the motion. */
static bool check_balance(const struct sample *s)
{
    const struct system *system = &s->system;
    if (system->order != 2)
        return true;
    double f[LIMIT_VARIABLES], later[LIMIT_VARIABLES], earlier[LIMIT_VARIABLES], rate = 0;
    system_derivative(system, s->t, s->y, f);
    for (int i = 0; i < system->n; i++)
        rate = fmax(rate, fabs(f[i]) / system->scale[i]);
    double h = ldexp(1, -17) / rate;
    for (int i = 0; i < system->n; i++) {
        later[i] = s->y[i] + h * f[i];
        earlier[i] = s->y[i] - h * f[i];
    }
    double kinetic = system_kinetic(system, s->y), potential = system_potential(system, s->y);
    double slope = (system_kinetic(system, later) - system_kinetic(system, earlier) +
                    system_potential(system, later) - system_potential(system, earlier)) /
                   (2 * h);
    double power = system_power(system, s->t, s->y);
    return fabs(slope - power) <= 1e-5 * (fabs(power) + rate * (kinetic + fabs(potential)));
}

/* The flags say what each term depends on; drag_whole, that all drag is in the oscillator. */
static bool check_flags(const struct sample *s)
{
    const struct system *system = &s->system;
    int n = system->n, half = n / 2, rows = system->order == 2 ? half : n;
    double moving[LIMIT_VARIABLES], turned[LIMIT_VARIABLES], drag[LIMIT_VARIABLES];
    memcpy(moving, s->y, sizeof moving);
    memcpy(turned, s->y, sizeof turned);
    for (int i = half; i < n; i++) {
        moving[i] += system->scale[i];
        turned[i] *= -1; /* dry friction knows the direction alone */
    }
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *term = &system->term[i];
        double here[LIMIT_VARIABLES] = {0}, later[LIMIT_VARIABLES] = {0},
               faster[LIMIT_VARIABLES] = {0}, back[LIMIT_VARIABLES] = {0};
        size_t size = (size_t)rows * sizeof *here;
        term->row->add(term->c, s->t, s->y, here);
        term->row->add(term->c, s->t + 1, s->y, later);
        term->row->add(term->c, s->t, moving, faster);
        term->row->add(term->c, s->t, turned, back);
        if ((memcmp(here, later, size) != 0) != !!(term->row->flags & TERM_TIME))
            return false;
        if (system->order == 2 &&
            (memcmp(here, faster, size) != 0 || memcmp(here, back, size) != 0) !=
                !!(term->row->flags & TERM_VELOCITY))
            return false;
    }
    if (system->order != 2)
        return !system->oscillator.whole && !system->oscillator.drag_whole;
    if (!system->oscillator.drag_whole)
        return !system->oscillator.whole;
    system_drag(system, s->t, s->y, drag);
    for (int i = 0; i < half; i++) {
        double v = s->y[half + i],
               wanted = -(system->oscillator.damping + system->oscillator.quadratic * fabs(v)) * v -
                        copysign(system->oscillator.friction, v);
        if (!(fabs(drag[i] - wanted) <= 1e-14 * fabs(wanted)))
            return false;
    }
    return true;
}

/* The Jacobian is all of the difference between two states on either side of every zero, where
 * forces may jump. */
static bool is_straight(const struct sample *s, const double *jac)
{
    int n = s->system.n;
    double across[LIMIT_VARIABLES], f[LIMIT_VARIABLES], g[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        across[i] = -s->y[i];
    system_derivative(&s->system, s->t, s->y, f);
    system_derivative(&s->system, s->t, across, g);
    for (int i = 0; i < n; i++) {
        double wanted = 0, size = fabs(f[i]) + fabs(g[i]);
        for (int j = 0; j < n; j++) {
            wanted += jac[i * n + j] * (s->y[j] - across[j]);
            size += fabs(jac[i * n + j] * (s->y[j] - across[j]));
        }
        if (!(fabs(f[i] - g[i] - wanted) <= 1e-14 * size))
            return false;
    }
    return true;
}

/* The claim to be linear: the Jacobian is the same everywhere, and nothing jumps, as dry friction
 * does. */
static bool check_linear(const struct sample *s)
{
    int n = s->system.n;
    double here[LIMIT_VARIABLES * LIMIT_VARIABLES], there[LIMIT_VARIABLES * LIMIT_VARIABLES],
        away[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        away[i] = s->y[i] + 0.3 * s->system.scale[i];
    system_jacobian(&s->system, s->t, s->y, here);
    system_jacobian(&s->system, s->t, away, there);
    bool same = memcmp(here, there, (size_t)(n * n) * sizeof *here) == 0;
    return (same && is_straight(s, here)) == s->system.linear;
}

static bool (*const checks[])(const struct sample *) = {
    check_jacobian, check_potential, check_power, check_balance, check_flags, check_linear};

/* Some of the presets with every term on, some as they are. */
static bool check_preset(const struct preset *preset, size_t check, void (*spoil)(struct system *))
{
    uint64_t seed = 11;
    for (int i = 0; i < 60; i++) {
        struct scene scene = i % 2 ? busy_scene(preset, &seed) : scene_of(preset);
        struct sample s = {.name = preset->row.name,
                           .system = bind_or_fail(&scene),
                           .t = random_between(&seed, 0, 9)};
        for (int k = 0; k < s.system.n; k++)
            s.y[k] = s.system.scale[k] * random_between(&seed, 0.3, 1.2) *
                     (random_unit(&seed) < 0.5 ? -1 : 1);
        if (spoil)
            spoil(&s.system);
        if (!checks[check](&s))
            return false;
    }
    return true;
}

TEST(test_models_keep_their_claims)
{
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct preset *preset = preset_at(i);
        /* energies are out of range there: that is what they are for */
        if (strncmp(preset->row.name, "extreme-", 8) == 0 && !preset->model)
            continue;
        for (size_t check = 0; check < COUNT_OF(checks); check++)
            if (!check_preset(preset, check, NULL))
                fail_msg("%s fails check %zu", preset->row.name, check);
    }
}

/* ---- systems that are wrong on purpose ---- */

static void wrong_coefficient(
    struct system *system) /* acceleration and Jacobian alike, but not the potential */
{
    system->term[0].c[0] *= 1.001;
}

static void wrong_mass(struct system *system)
{
    system->mass *= 1.001;
}

static void wrong_damping(struct system *system)
{
    system->oscillator.damping += 1e-3;
}

static void wrong_linear(struct system *system)
{
    system->linear = !system->linear;
}

static struct term_row broken;

static void without_jacobian(struct system *system)
{
    broken = *system->term[0].row;
    broken.jacobian = NULL;
    system->term[0].row = &broken;
}

static void with_time(struct system *system)
{
    broken = *system->term[0].row;
    broken.flags ^= TERM_TIME;
    system->term[0].row = &broken;
}

TEST(test_wrong_models_are_caught)
{
    static const char *const names[] = {"duffing", "pendulum", "kepler", "elastic-pendulum"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        const struct preset *preset =
            (const struct preset *)catalog_find(&preset_catalog, text_of(names[i]));
        assert_non_null(preset);
        assert_false(check_preset(preset, 0, without_jacobian));
        if (preset->model != scene_of(preset_at(0)).model && strcmp(names[i], "kepler") != 0)
            assert_false(check_preset(preset, 1, wrong_coefficient));
        assert_false(check_preset(preset, 1, wrong_mass));
        assert_false(check_preset(preset, 3, wrong_mass));
        assert_false(check_preset(preset, 4, wrong_damping));
        assert_false(check_preset(preset, 4, with_time));
        assert_false(check_preset(preset, 5, wrong_linear));
    }
    const struct preset *dry =
        (const struct preset *)catalog_find(&preset_catalog, TEXT("dry-friction"));
    assert_false(check_preset(dry, 5, wrong_linear));
}

/* ---- starts and derived quantities ---- */

TEST(test_starts)
{
    for (size_t i = 0; i < preset_catalog.count; i++) {
        struct scene scene = scene_of(preset_at(i));
        struct error error = {0};
        scene.value[scene_param(&scene, "t0")] = 3.5;
        struct system system = bind_or_fail(&scene);
        assert_true(system.t0 == 3.5 && system.n == scene.model->n &&
                    system.order == scene.model->order);
        for (int k = 0; k < system.n; k++) {
            assert_true(isfinite(system.start[k]) && system.scale[k] > 0 &&
                        isfinite(system.scale[k]));
            /* a comet at the sun is the fastest */
            assert_true(fabs(system.start[k]) <= 2e4 * system.scale[k]);
            assert_string_equal(system_variable(&system, k).name, scene.model->variable[k].name);
        }
        for (size_t p = 0; p < scene_params(&scene)->count; p++) {
            const struct param_row *row =
                (const struct param_row *)catalog_row(scene_params(&scene), p);
            assert_false(scene_set(&scene, (int)p, (struct measured){NAN, 0}, &error));
            if (row->min > -HUGE_VAL)
                assert_false(scene_set(&scene, (int)p, (struct measured){row->min - 1, 0}, &error));
        }
    }
    struct scene kepler =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("kepler")));
    struct error error = {0};
    assert_false(scene_set(&kepler, scene_param(&kepler, "e"), (struct measured){1, 0}, &error));
    assert_non_null(strstr(error.text, "e must be < 1"));
    assert_int_equal(scene_param(&kepler, "gamma"), -1);
    struct scene robertson =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("robertson")));
    assert_int_equal(scene_derived(&robertson)->count, 0);
}

static struct measured derive(const struct scene *scene, const char *name)
{
    const struct row *row = catalog_find(scene_derived(scene), text_of(name));
    assert_non_null(row);
    return ((const struct derived_row *)(const void *)row)->value(scene);
}

TEST(test_derived)
{
    struct scene scene =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("pendulum")));
    struct error error;
    static const double pi = 3.14159265358979323846;
    scene.value[scene_param(&scene, "g")] = 1;
    /* references.csv */
    assert_true(fabs(derive(&scene, "period").value - 7.41629870920548767) < 2e-15 * 7);
    assert_true(fabs(derive(&scene, "T0").value - 2 * pi) < 1e-15);
    assert_true(fabs(derive(&scene, "E0").value - 0.2) < 1e-15);
    assert_true(
        scene_set(&scene, scene_param(&scene, "length"), (struct measured){1, 0.01}, &error));
    assert_true(fabs(derive(&scene, "T0").uncertainty - pi * 0.01) < 1e-8);
    const struct derived_row *row = (const void *)catalog_find(scene_derived(&scene), TEXT("T0"));
    assert_true(scene_set_derived(&scene, row, (struct measured){4 * pi, 0}, &error));
    assert_true(fabs(scene.value[scene_param(&scene, "length")] - 4) < 1e-14);
    /* The same swing from the bottom, where all its energy is speed; a little more, and it turns
     * over. */
    scene.value[scene_param(&scene, "length")] = 1;
    scene.value[scene_param(&scene, "theta0")] = 0;
    scene.value[scene_param(&scene, "rate0")] = sqrt(2);
    assert_true(fabs(derive(&scene, "period").value - 7.41629870920548767) < 1e-14);
    scene.value[scene_param(&scene, "rate0")] = 2;
    assert_true(isnan(derive(&scene, "period").value));
    scene =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("kepler-eccentric")));
    assert_true(fabs(derive(&scene, "period").value - 2 * pi) < 1e-15);
    assert_true(fabs(derive(&scene, "E0").value + 0.5) < 1e-14);
}

RUN_TESTS(NULL, NULL)
