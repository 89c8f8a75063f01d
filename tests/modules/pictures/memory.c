/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Allocations fail one by one while a picture is drawn, in the library that draws it, too: it is
 * drawn, or an error says why not. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "faults/failing_malloc.h"

#include "modules/pictures/pictures.h"

#include <signal.h>
#include <sys/resource.h>

#define SAMPLES 200
#define CALLS 120 /* of which 31 crashed the program, or never ended */
#define CPU 2     /* [s] more than pictures need */

static bool draw(enum picture kind, long fail_at, struct buffer *out, struct error *error)
{
    static double x[SAMPLES], y[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        x[i] = 0.1 * i;
        y[i] = i % 20;
    }
    const struct curve curve = {.label = "verlet", .x = x, .y = y, .n = SAMPLES};
    const struct figure figure = {.title = "position",
                                  .x = {.label = "t", .unit = "s"},
                                  .y = {.label = "y", .unit = "cm"},
                                  .curve = &curve,
                                  .curves = 1};
    malloc_calls = 0;
    malloc_fail_at = fail_at;
    const bool drawn = figure_picture(&figure, kind, 300, 200, out, error);
    malloc_fail_at = -1;
    return drawn;
}

TEST(every_allocation_may_fail)
{
    struct error error = {0};
    struct rlimit limit;
    int drawn = 0, clean = 0, died = 0;
    (void)state;
    if (!MALLOC_CAN_FAIL || !picture_offered(PICTURE_PDF, &error)) {
        print_message("sanitizers have an allocator of their own, or cairo is not there\n");
        skip();
    }
    signal(SIGXCPU, SIG_IGN); /* but not in what never ends */
    getrlimit(RLIMIT_CPU, &limit);
    limit.rlim_cur = CPU;
    setrlimit(RLIMIT_CPU, &limit);
    for (long at = 0; at < 2 * CALLS; at += is_long() ? 1 : 13)
        for (enum picture kind = PICTURE_SVG; kind <= PICTURE_PNG; kind++) {
            struct buffer out = {0};
            error = (struct error){0};
            malloc_fail_for_ever = at % 2 != 0;
            const bool ok = draw(kind, at / 2, &out, &error);
            drawn += ok;
            clean += error.code == ERROR_COMMAND;
            died += error.code == ERROR_IO;
            if (ok ? out.len < 1000 || error.code : (kind && out.len > 0) || !*error.text)
                fail_msg("call %ld / 2 fails: %d, %zu bytes, '%s'", at, ok, out.len, error.text);
            if (error.code == ERROR_IO &&
                (!strstr(error.text, "the picture could not be drawn: its process") ||
                 !strstr(error.hint, ".svg")))
                fail_msg("call %ld / 2 fails: '%s', '%s'", at, error.text, error.hint);
            buffer_free(&out);
        }
    print_message("%d drawn, %d without memory, %d died\n", drawn, clean, died);
    assert_true(drawn > 0 && clean > 0);
    for (enum picture kind = PICTURE_SVG; kind <= PICTURE_PNG; kind++) {
        struct buffer out = {0};
        assert_true(draw(kind, -1, &out, &error)); /* nothing of it is left */
        buffer_free(&out);
    }
}

RUN_TESTS(NULL, NULL)
