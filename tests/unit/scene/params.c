/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parameters, presets and derived quantities with their uncertainties. */
#include <hooke/base/unit.h>
#include "unit/scene/testing.h"

#include <math.h>
#include <string.h>

static const struct derived_row *derived(const char *name)
{
    const struct row *row = catalog_find(&derived_catalog, text_of(name));
    assert_non_null(row);
    return (const struct derived_row *)row;
}

static struct measured derive(const struct scene *scene, const char *name)
{
    return derived(name)->value(scene);
}

static void set(struct scene *scene, const char *param, double value, double uncertainty)
{
    struct error error = {0};
    if (!scene_set(scene, param_index(param), (struct measured){value, uncertainty}, &error))
        fail_msg("%s", error.text);
}

static void expect_near(double got, double wanted, double relative)
{
    if (!(fabs(got - wanted) <= relative * fabs(wanted)))
        fail_msg("%.17g, wanted %.17g", got, wanted);
}

TEST(test_tables)
{
    /* Name, unit and default of each parameter are an interface: scripts rely on them. */
    static const struct {
        const char *name, *unit;
        double initial;
    } wanted[] = {
        {"m", "kg", 0.2},      {"k", "N/m", 15},         {"gamma", "1/s", 0},
        {"C", "", 0},          {"rho", "kg/m^3", 1.204}, {"area", "m^2", 1.2566e-3},
        {"length", "m", 0.04}, {"eta", "Pa*s", 1.82e-5}, {"g", "m/s^2", 0},
        {"F0", "N", 0},        {"omega", "rad/s", 8},    {"phase", "rad", 0},
        {"y0", "m", 0.05},     {"v0", "m/s", 0},         {"t0", "s", 0},
        {"k3", "N/m^3", 0},    {"mu", "1/s", 0},         {"width", "m", 1},
    };
    for (size_t i = 0; i < COUNT_OF(wanted); i++) {
        const struct param_row *row = (const struct param_row *)catalog_row(
            &param_catalog, (size_t)param_index(wanted[i].name));
        assert_string_equal(row->row.unit, wanted[i].unit);
        assert_true(row->initial == wanted[i].initial);
        assert_true(row->row.brief[0]);
        if (row->quantity != QUANTITY_NUMBER)
            assert_string_equal(row->row.unit, quantity_unit(row->quantity));
    }
    for (size_t i = 0; i < derived_catalog.count; i++) {
        const struct derived_row *row =
            (const struct derived_row *)catalog_row(&derived_catalog, i);
        assert_null(catalog_find(&param_catalog, text_of(row->row.name)));
        assert_true(!row->inverse == !row->target);
        if (row->quantity != QUANTITY_NUMBER && row->quantity != QUANTITY_FREQUENCY)
            assert_string_equal(row->row.unit, quantity_unit(row->quantity));
    }
}

static void expect_refused(const char *param, double value, double uncertainty,
                           const char *sentence)
{
    struct scene scene, before;
    struct error error = {0};
    memset(&scene, 0, sizeof scene); /* padding too: compared below */
    scene_init(&scene, NULL);
    memcpy(&before, &scene, sizeof before);
    assert_false(
        scene_set(&scene, param_index(param), (struct measured){value, uncertainty}, &error));
    assert_string_equal(error.text, sentence);
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_memory_equal(scene.value, before.value, sizeof scene.value);
    assert_memory_equal(scene.uncertainty, before.uncertainty, sizeof scene.uncertainty);
    assert_memory_equal(scene.chosen, before.chosen, sizeof scene.chosen);
}

TEST(test_ranges)
{
    expect_refused("m", 0, 0, "m must be > 0 (got 0 kg)");
    expect_refused("m", -0.2, 0, "m must be > 0 (got -0.2 kg)");
    expect_refused("C", -1, 0, "C must be >= 0 (got -1)");
    expect_refused("eta", 0, 0, "eta must be > 0 (got 0 Pa*s)");
    expect_refused("omega", -1, 0, "omega must be >= 0 (got -1 rad/s)");
    expect_refused("k", NAN, 0, "k must be a finite number (got nan)");
    expect_refused("y0", -HUGE_VAL, 0, "y0 must be a finite number (got -inf)");
    expect_refused("k", 1, -1, "the uncertainty of k must be a finite number >= 0");
    expect_refused("k", 1, HUGE_VAL, "the uncertainty of k must be a finite number >= 0");
    expect_refused("k", 1e308, 0, "k/m overflows: k = 1e308 N/m, m = 0.2 kg");
    expect_refused("m", 1e-310, 0, "k/m overflows: k = 15 N/m, m = 1e-310 kg");
    struct scene scene;
    scene_init(&scene, NULL);
    set(&scene, "k", -3, 0);
    set(&scene, "gamma", -1, 0);
    set(&scene, "C", 0, 0);
    set(&scene, "k", 0, NAN);
    assert_true(scene.uncertainty[param_index("k")] == 0);
}

TEST(test_set_and_unset)
{
    struct scene scene;
    int gamma = param_index("gamma");
    scene_init(&scene, (const struct preset *)catalog_find(&preset_catalog, TEXT("damped")));
    assert_true(scene.value[gamma] == 0.25 && !scene.chosen[gamma]);
    set(&scene, "gamma", 3, 0.1);
    assert_true(scene.value[gamma] == 3 && scene.chosen[gamma] && scene.uncertainty[gamma] == 0.1);
    scene_unset(&scene, gamma);
    assert_true(scene.value[gamma] == 0.25 && !scene.chosen[gamma] &&
                scene.uncertainty[gamma] == 0);
    scene_init(&scene, NULL);
    assert_string_equal(scene.preset->row.name, "spring");
}

TEST(test_presets)
{
    static const char *const names[] = {"spring",          "damped",  "drag",      "driven",
                                        "pendulum",        "duffing", "vanderpol", "stiff-spring",
                                        "stiff-vanderpol", "kepler"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        assert_non_null(catalog_find(&preset_catalog, text_of(names[i])));
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct preset *preset = (const struct preset *)catalog_row(&preset_catalog, i);
        struct scene scene;
        struct error error = {0};
        scene_init(&scene, preset);
        for (size_t p = 0; p < scene_params(&scene)->count;
             p++) /* every value of a preset could have been typed */
            if (!scene_set(&scene, (int)p, (struct measured){scene.value[p], 0}, &error))
                fail_msg("%s: %s", preset->row.name, error.text);
        for (size_t p = 0; p < COUNT_OF(preset->value) && preset->value[p].param; p++) {
            int index = scene_param(&scene, preset->value[p].param);
            if (index < 0 ||
                scene.value[index] != preset->value[p].value) /* unknown, or there twice */
                fail_msg("%s: %s", preset->row.name, preset->value[p].param);
        }
    }
}

TEST(test_derived)
{
    struct scene scene;
    scene_init(&scene, NULL);
    set(&scene, "gamma", 0.5, 0);
    set(&scene, "g", 9.81, 0);
    set(&scene, "v0", 0.3, 0);
    double omega = sqrt(75), rest = -0.2 * 9.81 / 15, swing = hypot(0.05 - rest, 0.3 / omega);
    static const double pi = 3.14159265358979323846;
    expect_near(derive(&scene, "omega0").value, omega, 1e-15);
    expect_near(derive(&scene, "T0").value, 2 * pi / omega, 1e-15);
    expect_near(derive(&scene, "f0").value, omega / (2 * pi), 1e-15);
    expect_near(derive(&scene, "zeta").value, 0.25 / omega, 1e-15);
    expect_near(derive(&scene, "Q").value, omega / 0.5, 1e-15);
    expect_near(derive(&scene, "tau").value, 4, 1e-15);
    expect_near(derive(&scene, "omega_d").value, sqrt(75 - 0.0625), 1e-15);
    expect_near(derive(&scene, "T_d").value, 2 * pi / sqrt(75 - 0.0625), 1e-15);
    expect_near(derive(&scene, "equilibrium").value, rest, 1e-15);
    expect_near(derive(&scene, "amplitude").value, swing, 1e-15);
    expect_near(derive(&scene, "E0").value, 0.1 * 0.09 + 7.5 * 0.0025 + 0.2 * 9.81 * 0.05, 1e-15);
    expect_near(derive(&scene, "Re").value, 1.204 * swing * omega * 0.04 / 1.82e-5, 1e-14);

    /* Nothing oscillates: no period, no damping ratio. */
    set(&scene, "k", -1, 0);
    static const char *const absent[] = {"omega0",  "T0",  "f0",        "zeta", "Q",
                                         "omega_d", "T_d", "amplitude", "Re"};
    for (size_t i = 0; i < COUNT_OF(absent); i++)
        assert_true(isnan(derive(&scene, absent[i]).value));
    set(&scene, "k", 0, 0);
    assert_true(isnan(derive(&scene, "equilibrium").value));
    set(&scene, "k", 15, 0);
    set(&scene, "k3", 15, 0);
    assert_true(isnan(derive(&scene, "equilibrium").value)); /* with gravity the root of a cubic */
    set(&scene, "k3", 0, 0);
    set(&scene, "gamma", 0, 0);
    assert_true(isnan(derive(&scene, "Q").value) && isnan(derive(&scene, "tau").value));
    set(&scene, "gamma", 20, 0);
    assert_true(isnan(derive(&scene, "T_d").value) && derive(&scene, "zeta").value > 1);
}

TEST(test_extreme_amplitude)
{
    struct scene scene;
    scene_init(&scene, NULL);
    static const double sizes[] = {1e-300, 1e-200, 1e200, 1e300};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        set(&scene, "y0", sizes[i], 0);
        set(&scene, "v0", sizes[i], 0);
        expect_near(derive(&scene, "amplitude").value, sizes[i] * sqrt(1 + 1 / 75.0), 1e-14);
    }
    set(&scene, "k", 1e-300, 0);
    set(&scene, "m", 1e-300, 0);
    expect_near(derive(&scene, "omega0").value, 1, 1e-15);
    set(&scene, "k", 1e5, 0);
    expect_near(derive(&scene, "omega0").value, sqrt(1e305), 1e-15);
}

TEST(test_uncertainty)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(derive(&scene, "T0").uncertainty == 0);
    set(&scene, "k", 15, 0.3);
    expect_near(derive(&scene, "T0").uncertainty, derive(&scene, "T0").value * 0.01, 1e-8);
    set(&scene, "m", 0.2, 0.001);
    expect_near(derive(&scene, "T0").uncertainty, derive(&scene, "T0").value * hypot(0.01, 0.0025),
                1e-8);
    expect_near(derive(&scene, "f0").uncertainty, derive(&scene, "f0").value * hypot(0.01, 0.0025),
                1e-8);
    set(&scene, "gamma", 0.25, 0.005);
    expect_near(derive(&scene, "tau").uncertainty, 8 * 0.02, 1e-8);
    expect_near(derive(&scene, "Q").uncertainty,
                derive(&scene, "Q").value * sqrt(1e-4 + 6.25e-6 + 4e-4), 1e-8);
    set(&scene, "y0", 0.05, 0.002);
    set(&scene, "k", 15, 0);
    expect_near(derive(&scene, "E0").uncertainty, 15 * 0.05 * 0.002, 1e-8);
    set(&scene, "k", 15, 1e-13); /* far below what a naive difference over +-u could resolve */
    set(&scene, "m", 0.2, 0);
    expect_near(derive(&scene, "T0").uncertainty / derive(&scene, "T0").value, 1e-13 / 30, 1e-8);
}

TEST(test_setting_a_derived_quantity)
{
    struct scene scene;
    struct error error = {0};
    for (size_t i = 0; i < derived_catalog.count; i++) {
        const struct derived_row *row =
            (const struct derived_row *)catalog_row(&derived_catalog, i);
        scene_init(&scene, NULL);
        set(&scene, "m", 0.3, 0);
        bool fine = scene_set_derived(&scene, row, (struct measured){1.25, 0.01}, &error);
        assert_true(fine == (row->inverse != NULL));
        if (!fine) {
            assert_non_null(strstr(error.text, "cannot be set"));
            continue;
        }
        assert_true(scene.chosen[param_index(row->target)]);
        expect_near(row->value(&scene).value, 1.25, 1e-14);
        expect_near(row->value(&scene).uncertainty, 0.01, 1e-7);
    }
    scene_init(&scene, NULL);
    assert_false(scene_set_derived(&scene, derived("T0"), (struct measured){0, 0}, &error));
    assert_string_equal(error.text, "T0 cannot be 0 s here: no finite k gives this value");
    assert_false(scene_set_derived(&scene, derived("T0"), (struct measured){-1, 0}, &error));
    assert_false(scene_set_derived(&scene, derived("omega0"), (struct measured){1e200, 0}, &error));
    set(&scene, "k", -1, 0);
    assert_false(scene_set_derived(&scene, derived("zeta"), (struct measured){1, 0}, &error));
    assert_true(scene.value[param_index("gamma")] == 0);
}

TEST(test_reynolds)
{
    struct scene scene;
    scene_init(&scene, NULL);
    expect_near(scene_reynolds(&scene, 0.5), 1.204 * 0.5 * 0.04 / 1.82e-5, 1e-15);
    scene_init(&scene, (const struct preset *)catalog_find(&preset_catalog, TEXT("kepler")));
    assert_true(isnan(scene_reynolds(&scene, 0.5)));
    assert_string_equal(reynolds_regime(2299), "laminar");
    assert_string_equal(reynolds_regime(2300), "transitional");
    assert_string_equal(reynolds_regime(4000), "transitional");
    assert_string_equal(reynolds_regime(4001), "turbulent");
    assert_string_equal(reynolds_regime(NAN), "undefined");
}

RUN_TESTS(NULL, NULL)
