/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the tests of the scene share: random numbers that are the same every time, and scenes from a
 * few values. */
#pragma once

#include "cmocka_testing.h"

#include <hooke/base/elementary.h>
#include <hooke/scene.h>

struct measured;

/* splitmix64 (Steele, Lea, Flood 2014), as a number in [0, 1). */
static inline double random_unit(uint64_t *seed)
{
    uint64_t z = (*seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static inline double random_between(uint64_t *seed, double a, double b)
{
    return a + (b - a) * random_unit(seed);
}

/* x^n with the rounding that is documented, in another way: the bits of |n| from the highest down.
 */
static inline double short_power(double x, double n)
{
    if (!(fabs(n) <= 16 && 2 * n == floor(2 * n)))
        return fixed_pow(x, n);
    const int whole = (int)fabs(n);
    double power = 1;
    bool begun = false;
    for (int bit = 4; bit >= 0; bit--) {
        power = begun ? power * power : power;
        if (whole >> bit & 1)
            power = begun ? power * x : x;
        begun = begun || (whole >> bit & 1);
    }
    if (fabs(n) != whole)
        power = whole ? power * sqrt(x) : sqrt(x);
    return n < 0 ? 1 / power : power;
}

struct setting {
    const char *param;
    double value;
};

/* The default scene with these settings, bound; fails the test where it does not bind. */
static inline struct system bound(const struct setting *settings, size_t count)
{
    struct scene scene;
    struct system system;
    struct error error = {0};
    scene_init(&scene, NULL);
    for (size_t i = 0; i < count; i++)
        if (!scene_set(&scene, param_index(settings[i].param),
                       (struct measured){settings[i].value, 0}, &error))
            fail_msg("%s", error.text);
    if (!scene_bind(&scene, &system, &error))
        fail_msg("%s", error.text);
    return system;
}

#define BOUND(...)                                                                                 \
    bound((const struct setting[]){__VA_ARGS__}, COUNT_OF(((const struct setting[]){__VA_ARGS__})))
