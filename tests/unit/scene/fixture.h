/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A typed scene for each test of a program. */
#pragma once

#include "unit/scene/typing.h"

#include <stdlib.h>

#define LINES(...)                                                                                 \
    (const char *const[])                                                                          \
    {                                                                                              \
        __VA_ARGS__, NULL                                                                          \
    }

struct fixture {
    struct typed_models *models;
    struct scene scene;
    struct system system;
    struct error error;
};

static inline int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    if (!f)
        return -1;
    *state = f;
    f->models = typed_create(&f->error);
    scene_init(&f->scene, NULL);
    srand(7); /* a test's random numbers do not depend on the tests before it */
    return f->models ? 0 : -1;
}

static inline int tear_down(void **state)
{
    struct fixture *f = *state;
    typed_destroy(f->models);
    free(f);
    return 0;
}
