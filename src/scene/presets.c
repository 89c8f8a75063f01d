/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes by name: what differs from the parameters' defaults. The first row is where a session begins. */
#include <hooke/scene.h>

static const struct preset rows[] = {
    {.row = {"spring", "", "mass on a spring, no damping: the lab's first session", "", NULL}},
    {.row = {"damped", "", "linear damping: amplitude falls as exp(-gamma t/2), energy as exp(-gamma t)", "", NULL},
     .value = {{"gamma", 0.25}}},
    /* Disk 12 cm across, face to the flow: drag coefficient 1.17 with the 1/2 (Hoerner 1965), 0.585 without. */
    {.row = {"drag", "", "quadratic drag of a disk 12 cm across in air: the lab's second session", "", NULL},
     .value = {{"C", 0.585}, {"area", 1.131e-2}, {"length", 0.12}}},
    {.row = {"driven", "", "driven from rest near resonance: beats that settle into the forced motion", "", NULL},
     .value = {{"gamma", 0.3}, {"F0", 0.02}, {"omega", 8.2}, {"y0", 0}}},
};

const struct catalog preset_catalog = CATALOG("scene", rows);
