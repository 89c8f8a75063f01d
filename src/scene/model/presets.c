/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Presets: scenes by name, with the parameters in which they differ from the defaults, and the
 * duration, tolerance or first step of their runs. A session begins with the first row. */
#include <hooke/base/catalog.h>
#include "scene/model/model.h"

#define UNIT_OSCILLATOR                                                                            \
    {"m", 1}, {"k", 1},                                                                            \
    {                                                                                              \
        "y0", 1                                                                                    \
    }
#define VAN_DER_POL                                                                                \
    {"m", 1}, {"k", 1},                                                                            \
    {                                                                                              \
        "y0", 2                                                                                    \
    }

/* Period of the Kepler problem with semi-major axis 1 [s]. */
#define KEPLER_PERIOD 6.283185307179586476925

static const struct preset rows[] = {
    {.row = {"spring", "", "mass on a spring, no damping: the lab's first session", "", NULL}},
    {.row = {"damped", "",
             "linear damping: amplitude falls as exp(-gamma t/2), energy as exp(-gamma t)", "",
             NULL},
     .value = {{"gamma", 0.25}}},
    /* Disk 12 cm across, face to the flow: drag coefficient 1.17 with the 1/2 (Hoerner 1965), 0.585
       without. */
    {.row = {"drag", "", "quadratic drag of a disk 12 cm across in air: the lab's second session",
             "", NULL},
     .value = {{"C", 0.585}, {"area", 1.131e-2}, {"length", 0.12}}},
    /* Amplitude less by 4 friction / k = 2.14 mm a period; at rest 0.357 mm off after 47 half
       swings, 27.9 s. */
    {.row = {"dry-friction", "",
             "the amplitude falls by 4 friction/k per period, until the body sticks",
             "Coulomb 1785", NULL},
     .value = {{"k", 5.6}, {"friction", 3e-3}},
     .duration = 30},
    {.row = {"driven", "", "driven from rest near resonance: beats die out into the forced motion",
             "", NULL},
     .value = {{"gamma", 0.3}, {"F0", 0.02}, {"omega", 8.2}, {"y0", 0}},
     .duration = 40},
    {.row = {"resonance", "", "driven from rest at resonance, undamped: the amplitude grows as t/2",
             "", NULL},
     .value = {{"m", 1}, {"k", 1}, {"F0", 1}, {"omega", 1}, {"y0", 0}},
     .duration = 60},
    {.row = {"critical", "", "critical damping: the fastest return without overshoot", "", NULL},
     .value = {{"k", 20}, {"gamma", 20}},
     .duration = 1},
    {.row = {"overdamped", "", "strong damping: a fast and a slow exponential, rates 1 : 131", "",
             NULL},
     .value = {{"gamma", 100}},
     .duration = 5},
    {.row = {"inverted", "", "k < 0: an unstable equilibrium; the distance grows as exp(omega0 t)",
             "", NULL},
     .value = {{"k", -15}, {"y0", 1e-6}},
     .duration = 1.5},

    {.row = {"duffing", "", "a hardening spring: wider swings are faster", "Duffing 1918", NULL},
     .value = {UNIT_OSCILLATOR, {"k3", 1}},
     .duration = 20},
    {.row = {"duffing-driven", "", "two wells and a drive: chaos", "Moon, Holmes 1979", NULL},
     .value =
         {{"m", 1}, {"k", -1}, {"k3", 1}, {"gamma", 0.25}, {"F0", 0.3}, {"omega", 1}, {"y0", 1}},
     .duration = 200,
     .tol = 1e-9},
    {.row = {"vanderpol", "", "a limit cycle that attracts every start", "van der Pol 1926", NULL},
     .value = {VAN_DER_POL, {"mu", 1}},
     .duration = 40},
    {.row = {"pendulum", "", "a pendulum from 90 degrees: 18 % slower than small swings",
             "Huygens 1673", NULL},
     .model = &pendulum_model,
     .value = {{"theta0", 1.5707963267948966}}},
    {.row = {"pendulum-driven", "",
             "damped and driven strongly enough to turn over irregularly: chaos",
             "Baker, Gollub 1990", NULL},
     .model = &pendulum_model,
     .value = {{"m", 1},
               {"g", 1},
               {"gamma", 0.5},
               {"F0", 1.15},
               {"omega", 0.66666666666666663},
               {"theta0", 0.2}},
     .duration = 200,
     .tol = 1e-9},
    {.row = {"elastic-pendulum", "",
             "a bob that swings on a spring, k/m = 1e2: energy wanders between the two", "", NULL},
     .model = &elastic_pendulum_model},
    {.row = {"kepler", "", "a planet on an ellipse of eccentricity 0.5", "Kepler 1609", NULL},
     .model = &kepler_model,
     .duration = 3 * KEPLER_PERIOD,
     .tol = 1e-8},
    {.row = {"kepler-eccentric", "",
             "eccentricity 0.9: fast near the sun, slow far out; needs step size control", "",
             NULL},
     .model = &kepler_model,
     .value = {{"e", 0.9}},
     .duration = 3 * KEPLER_PERIOD,
     .tol = 1e-9},
    {.row = {"henon-heiles", "", "a star in a galaxy at energy 0.08: regular motion",
             "Henon, Heiles 1964", NULL},
     .model = &henon_heiles_model,
     .duration = 100},
    {.row = {"henon-heiles-chaos", "", "a star in a galaxy at energy 1/8: mostly chaotic",
             "Henon, Heiles 1964", NULL},
     .model = &henon_heiles_model,
     .value = {{"vx0", 0.48}, {"vy0", 0.14}},
     .duration = 200,
     .tol = 1e-9},

    /* A stiff system: slow motion decides accuracy, fast motion limits an explicit step. */
    {.row = {"stiff-spring", "",
             "k/m = 1e12: 159155 swings per second, damped within a few seconds", "", NULL},
     .value = {{"m", 1}, {"k", 1e12}, {"y0", 1}, {"gamma", 1}},
     .duration = 1e-3,
     .first = 1e-8},
    {.row = {"stiff-damped", "", "gamma = 1e9: rates 1e9 and 1e-9 in one scene", "", NULL},
     .value = {UNIT_OSCILLATOR, {"gamma", 1e9}},
     .duration = 3e9,
     .first = 1e-10},
    {.row = {"stiff-vanderpol", "",
             "mu = 1000: drifts slowly for 807 s, then jumps within milliseconds",
             "van der Pol 1926", NULL},
     .value = {VAN_DER_POL, {"mu", 1e3}},
     .duration = 2000,
     .first = 1e-4},
    {.row = {"stiff-vanderpol-1e6", "",
             "mu = 1e6: drifts slowly for 9 days, then jumps within microseconds", "", NULL},
     .value = {VAN_DER_POL, {"mu", 1e6}},
     .duration = 2e6,
     .first = 1e-7},
    {.row = {"stiff-elastic-1e4", "", "the elastic pendulum with k/m = 1e4", "", NULL},
     .model = &elastic_pendulum_model,
     .value = {{"k", 1e4}}},
    {.row = {"stiff-elastic-1e6", "", "the elastic pendulum with k/m = 1e6: nearly a rigid rod", "",
             NULL},
     .model = &elastic_pendulum_model,
     .value = {{"k", 1e6}}},
    {.row = {"prothero-robinson", "", "stiff, with solution cos t: shows order reduction",
             "Prothero, Robinson 1974", NULL},
     .model = &prothero_robinson_model},
    {.row = {"robertson", "", "a stiff chemical reaction that takes 1e11 s", "Robertson 1966",
             NULL},
     .model = &robertson_model,
     .duration = 1e11,
     .first = 1e-4},
    {.row = {"orego", "", "a stiff chemical clock: spikes of 1e5, then quiet for five minutes",
             "Field, Noyes 1974", NULL},
     .model = &orego_model,
     .duration = 360,
     .first = 1e-4},

    /* Extremes of scale: what overflows, underflows or comes near a singularity. */
    {.row = {"extreme-small", "", "the lab's spring at 1e-200 m: squares underflow", "", NULL},
     .value = {{"y0", 1e-200}}},
    {.row = {"extreme-large", "", "the lab's spring at 1e145 m: squares nearly overflow", "", NULL},
     .value = {{"y0", 1e145}}},
    {.row = {"extreme-wall", "",
             "only a cubic spring, k3 = 1e9 N/m^3: no force in the middle, 300 m/s^2 at the ends",
             "", NULL},
     .value = {{"m", 1}, {"k", 0}, {"k3", 1e9}, {"y0", 0}, {"v0", 1}}},
    {.row = {"extreme-comet", "",
             "eccentricity 0.9999: the attraction varies by a factor of 4e8 along the orbit", "",
             NULL},
     .model = &kepler_model,
     .value = {{"e", 0.9999}},
     .duration = KEPLER_PERIOD,
     .tol = 1e-10,
     .first = 1e-6},
};

const struct catalog preset_catalog = CATALOG("scene", rows);

const struct preset *preset_by_name(struct text name)
{
    return (const struct preset *)(const void *)catalog_find(&preset_catalog, name);
}

const struct preset *preset_at(size_t i)
{
    return (const struct preset *)(const void *)catalog_row(&preset_catalog, i);
}

const struct preset *preset_from(const struct row *row)
{
    return (const struct preset *)(const void *)row;
}
