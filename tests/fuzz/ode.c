/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an .ode file: a scene that can be bound, or an error with a text; never a crash. */
#include "modules/xppaut/ode_file.h"

#include <stdlib.h>

#define CORPUS "ode"
#include "fuzz/replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static bool is_taken(struct text name)
{
    return text_is(name, "dt");
}

/* What was taken is a scene, or too large for one. */
static void make(const struct ode_scene *from)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    const struct model *model =
        models ? typed_make(models, TEXT("fuzz"), from->line, from->lines, NULL, &error) : NULL;
    struct scene scene;
    static struct system system;
    if (model) {
        scene_init(&scene, typed_preset(model));
        if (scene_bind_motion(&scene, &system, &error)) {
            double rate[LIMIT_VARIABLES];
            system_derivative(&system, system.t0, system.start, rate);
        }
    }
    typed_destroy(models);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct ode_options options = {.set = size % 2 ? TEXT("one") : TEXT(""),
                                        .taken = is_taken};
    struct arena arena = {0};
    struct ode_scene scene;
    struct error error = {0};
    if (ode_read((struct text){(const char *)data, size}, &options, &arena, &scene, &error))
        make(&scene);
    else if (error.code == ERROR_NONE || !error.text[0])
        abort();
    arena_reset(&arena);
    fuzz_units++;
    return 0;
}
