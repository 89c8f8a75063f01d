/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Each allocation of each kind of work fails once, and from there for ever: an error or a whole
 * result, no leak, no crash. */
#include "cmocka_testing.h"

#include "faults/failing_malloc.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[128];

/* Each piece of work returns whether it succeeded; if it did, its result was right. */

static bool work_arena(struct error *error)
{
    struct arena arena = {0};
    bool done = true;
    for (size_t i = 0; i < 200 && done; i++) {
        char *z = arena_text(&arena, TEXT("some text to be kept for a while"));
        void *array = arena_array(&arena, 50, i);
        done = z && array;
        if (z)
            assert_string_equal(z, "some text to be kept for a while");
    }
    arena_reset(&arena);
    return done || error_memory(error);
}

static bool work_buffer(struct error *error)
{
    struct buffer b = {0};
    for (int i = 0; i < 500; i++) {
        buffer_format(&b, "%d ", i);
        buffer_real(&b, 0.1);
        buffer_uncertain(&b, 1.5, 0.1);
        buffer_quantity(&b, 0.2, QUANTITY_MASS, 0);
        safe_text(&b, TEXT("\033\n"), false);
        buffer_codepoint(&b, 0x20AC);
    }
    const bool done = !b.failed;
    if (done)
        assert_int_equal(strncmp(b.data,
                                 "0 0.11.50 +- 0.10200 g\\x1b\\x0a\xE2\x82\xAC"
                                 "1 ",
                                 34),
                         0);
    if (b.data)
        assert_int_equal(b.data[b.len], '\0');
    buffer_clear(&b);
    assert_false(b.failed);
    buffer_free(&b);
    return done || error_memory(error);
}

static bool work_catalog(struct error *error)
{
    assert_false(catalog_unknown(&unit_catalog, TEXT("kgg"), error));
    assert_string_equal(error->hint, "did you mean 'kg'?");
    return true;
}

static bool work_write(struct error *error)
{
    char path[160];
    snprintf(path, sizeof path, "%s/file", folder);
    struct writer writer;
    if (!writer_open(&writer, path, (struct write_policy){.force = true, .confine = false}, error))
        return false;
    writer_put(&writer, TEXT("content\n"));
    return writer_commit(&writer, error);
}

static bool work_read(struct error *error)
{
    char path[160];
    snprintf(path, sizeof path, "%s/old", folder);
    struct buffer b = {0};
    const bool done = file_read(path, 1u << 20, &b, error);
    if (done) {
        assert_int_equal(b.len, 300000);
        for (size_t i = 0; i < b.len; i += 1000)
            assert_int_equal(b.data[i], 'x');
    } else {
        assert_int_equal(b.len, 0);
    }
    buffer_free(&b);
    return done;
}

static const struct {
    const char *name;
    bool (*work)(struct error *error);
    bool allocates;
    long last; /* so many at the end are of what may be left undone: sweeping strays */
} works[] = {
    {"arena", work_arena, true, 0},      {"buffer", work_buffer, true, 0},
    {"catalog", work_catalog, false, 0}, {"write", work_write, true, 1},
    {"read", work_read, true, 0},
};

TEST(every_allocation_fails)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    for (size_t i = 0; i < COUNT_OF(works); i++) {
        struct error error = {0};
        malloc_calls = 0;
        malloc_fail_at = -1;
        assert_true(works[i].work(&error));
        const long calls = malloc_calls;
        if ((calls > 0) != works[i].allocates)
            fail_msg("%s: %ld allocations", works[i].name, calls);
        for (int for_ever = 0; for_ever <= 1; for_ever++)
            for (long n = 0; n < calls; n++) {
                error = (struct error){0};
                malloc_fail_for_ever = for_ever;
                malloc_calls = 0;
                malloc_fail_at = n;
                const bool done = works[i].work(&error);
                malloc_fail_at = -1;
                if (done && n >= calls - works[i].last)
                    continue;
                if (done || error.code != ERROR_COMMAND || !strstr(error.text, "out of memory"))
                    fail_msg("%s: allocation %ld of %ld failed unnoticed: '%s'", works[i].name, n,
                             calls, error.text);
            }
    }
}

/* What the header promises never to allocate. */
TEST(these_never_allocate)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    char z[REAL_TEXT_SIZE];
    double value;
    size_t used;
    struct error error;
    malloc_calls = 0;
    for (int e = -320; e <= 308; e += 4) {
        snprintf(z, sizeof z, "1.2345678901234567e%d", e);
        real_parse(text_of(z), &value);
        real_format(value, z);
        text_codepoint(text_of(z), &used);
        unit_match(text_of(z));
        catalog_unknown(&unit_catalog, text_of(z), &error);
        clock_ns();
    }
    assert_int_equal(malloc_calls, 0);
}

static int set_up(void **state)
{
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/hooke-memory-XXXXXX", base && *base ? base : "/tmp");
    char path[160];
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/old", folder);
    FILE *file = fopen(path, "w");
    if (!file)
        return -1;
    for (int i = 0; i < 300000; i++)
        fputc('x', file);
    return fclose(file);
}

static int tear_down(void **state)
{
    (void)state;
    static const char *const names[] = {"old", "file"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        char path[160];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        unlink(path);
    }
    return rmdir(folder); /* fails if anything else was left behind */
}

RUN_TESTS(set_up, tear_down)
