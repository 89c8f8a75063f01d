/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes and methods for the tests of studies. Included after <cmocka.h>. */
#pragma once

#include <hooke/base/catalog.h>
#include "modules/solving/compute/solve.h"

struct measured;
struct row;

static inline const struct method *method_named(const char *name)
{
    const struct row *row = catalog_find(&method_catalog, text_of(name));
    assert_non_null(row);
    return method_from(row);
}

struct setting {
    const char *param;
    double value;
};

#define NO_SETTINGS ((const struct setting[]){{NULL, 0}})
#define SETTINGS(...) ((const struct setting[]){__VA_ARGS__, {NULL, 0}})

/* A preset with some parameters set, up to the NULL. */
static inline struct scene scene_with(const char *preset, const struct setting *setting)
{
    const struct row *row = catalog_find(&preset_catalog, text_of(preset));
    struct scene scene;
    struct error error = {0};
    assert_non_null(row);
    scene_init(&scene, preset_from(row));
    for (; setting->param; setting++)
        if (!scene_set(&scene, scene_param(&scene, setting->param),
                       (struct measured){setting->value, 0}, &error))
            fail_msg("%s", error.text);
    return scene;
}

static inline void close_to(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance))
        fail_msg("%.17g is not %.17g within %g", value, wanted, tolerance);
}
