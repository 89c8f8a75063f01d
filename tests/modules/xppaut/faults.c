/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Each allocation on the way from an .ode file to a scene fails once, and from there for ever: an
 * error that says so, or the whole scene. */
#include "unit/scene/testing.h"

#include "modules/xppaut/ode_file.h"

#include "faults/failing_malloc.h"

static const char file[] = "par a=1,b=2,size=3\nf(u,v)=if(u>v)then(mod(u,v))else(-u^2)\n"
                           "!p=a/b\nh[1..40]=f(x[j],[j])+p\n"
                           "x[1..40]'=sum(0,9)of(shift(h1,i'))-h[j]\n"
                           "init x[1..40]=.[j]\naux e.n=h1+h2\nbndry x1-1\nset other {a=3,x1=4}\n"
                           "global 1 {x1-1} {x1=0;a=a+1}\n@ total=5,dt=.1\ndone\n";

static bool taken(struct text name)
{
    return text_is(name, "size");
}

static bool whole_way(int *lines, struct error *error)
{
    const struct ode_options options = {.set = TEXT("other"), .taken = taken};
    struct arena arena = {0};
    struct ode_scene scene;
    const bool fine = ode_read(text_of(file), &options, &arena, &scene, error);
    *lines = fine ? scene.lines + scene.events + scene.notes : 0;
    arena_reset(&arena);
    return fine;
}

TEST(test_each_allocation)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    struct error error = {0};
    int whole, lines;
    malloc_calls = 0;
    malloc_fail_at = -1;
    if (!whole_way(&whole, &error))
        fail_msg("%s", error.text);
    const long calls = malloc_calls;
    assert_true(calls > 20 && whole > 100);
    for (int for_ever = 0; for_ever < 2; for_ever++)
        for (long i = 0; i < calls; i++) {
            error = (struct error){0};
            malloc_fail_for_ever = for_ever;
            malloc_calls = 0;
            malloc_fail_at = i;
            const bool fine = whole_way(&lines, &error);
            malloc_fail_at = -1;
            if (fine ? lines != whole : strncmp(error.text, "out of memory", 13) != 0)
                fail_msg("allocation %ld: '%s', %d of %d lines", i, error.text, lines, whole);
        }
}

RUN_TESTS(NULL, NULL)
