/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session's file that somebody has written, with right checksums: numbers that nothing can have
 * are left out by name, the rest is there and can be used. */
#include "cmocka_testing.h"

#include "fuzz/mend.h"
#include "modules/resume/testing.h"

#include <math.h>
#include <unistd.h>

static const char lines[] = "m = 200 +- 0.3 g; method verlet dt=10ms; run 4 s; "
                            "let A = 4 cm; measure period; change gamma 0.3; continue 0.2 s";

/* Every value of that name in the file, from a byte on. False: there is none. */
static bool put_number(struct buffer *file, const char *name, size_t at, const void *number,
                       size_t bytes)
{
    const size_t len = strlen(name);
    bool found = false;
    for (size_t i = 0; i + 1 + len + sizeof(uint32_t) < file->len; i++) {
        uint32_t has;
        const size_t value = i + 1 + len + sizeof has;
        if (file->data[i] != (char)len || memcmp(file->data + i + 1, name, len) != 0)
            continue;
        memcpy(&has, file->data + i + 1 + len, sizeof has);
        if (has < at + bytes || has > file->len - value)
            continue;
        memcpy(file->data + value + at, number, bytes);
        found = true;
    }
    return found;
}

/* The file of a session in which `lines` were typed. */
static void store_lines(struct buffer *whole)
{
    struct bench b;
    struct stored stored = {0};
    bench_open(&b, false);
    type_ok(&b, lines);
    bench_store(b.session, &stored, whole);
    bench_close(&b);
    stored_free(&stored);
}

/* Restores a session from a file in which `what` was damaged, which a note names; frees the file.
 */
static void restore_damaged(struct bench *again, struct buffer *file, const char *what,
                            const char *named)
{
    struct buffer notes = {0};
    mend((uint8_t *)file->data, file->len);
    assert_true(bench_restore(again, buffer_text(file), &notes));
    if (!strstr(said(&notes), named))
        fail_msg("%s: '%s' does not name it", what, said(&notes));
    buffer_free(file);
    buffer_free(&notes);
}

TEST(numbers_out_of_range_are_left_out_by_name)
{
    static const int64_t minus = -1, far = INT64_MAX / 2;
    static const double none = NAN, negative = -1;
    static const int seven = 7777;
    static const struct {
        const char *field;
        size_t at;
        const void *number;
        size_t bytes;
        const char *named; /* in the notes */
    } cases[] = {
        {"current_run", 0, &seven, sizeof seven, "some values are left out"},
        {"speed", 0, &none, sizeof none, "some values are left out"},
        {"steps", 0, &minus, sizeof minus, "run 1"},
        {"stop", 0, &seven, sizeof seven, "run 1"},
        {"settings", 0, &none, sizeof none, "run 1"},
        {"settings", offsetof(struct run_settings, kernel), &seven, sizeof seven, "run 1"},
        {"now_step", 0, &far, sizeof far, "run 1"},
        {"every", 0, &minus, sizeof minus, "run 1"},
        {"count", 0, &far, sizeof far, "run 1"},
        {"grids", 0, &minus, sizeof minus, "run 1"},
        {"drag", 0, &seven, sizeof seven, "run 1"},
        {"value", 0, &negative, sizeof negative, "impossible values"},
        {"layout", 0, &seven, sizeof seven, "the view is left out"},
        {"cursors.snap", 0, &seven, sizeof seven, "the view"},
        {"kind", 0, &seven, sizeof seven, "its requests are damaged"},
    };
    (void)state;
    struct buffer whole = {0};
    store_lines(&whole);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer file = {0};
        struct bench again;
        buffer_put(&file, buffer_text(&whole));
        if (!put_number(&file, cases[i].field, cases[i].at, cases[i].number, cases[i].bytes))
            fail_msg("%s: it is not in the file", cases[i].field);
        restore_damaged(&again, &file, cases[i].field, cases[i].named);
        type_ok(&again, "runs");
        type_ok(&again, "scene spring; run 3 s; measure period; show all; save z --force");
        bench_close(&again);
    }
    buffer_free(&whole);
}

/* The set-up is there as commands: others are not executed, and what is left is restored. */
TEST(only_what_makes_a_session_is_executed)
{
    static const char line[] = "let A = 4 cm\n";
    static const struct {
        const char *instead, *named;
    } cases[] = {
        {"export x.csv", "is not allowed"}, {"source x.hks", "is not allowed"},
        {"plot y > x.p", "is not allowed"}, {"k=20;quit   ", "is not allowed"},
        {"set gama 3  ", "gama"},           {"m = \033[2J   ", "\\x1b[2J"},
    };
    struct buffer whole = {0};
    store_lines(&whole);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer file = {0};
        struct bench again;
        buffer_put(&file, buffer_text(&whole));
        char *at = NULL;
        for (size_t k = 0; k + sizeof line < file.len; k++) /* the last one is read */
            if (memcmp(file.data + k, line, sizeof line - 1) == 0)
                at = file.data + k;
        assert_non_null(at);
        memcpy(at, cases[i].instead, sizeof line - 2);
        restore_damaged(&again, &file, cases[i].instead, cases[i].named);
        assert_false(again.session->execution.quit);
        type_ok(&again, "use 1; print y");
        bench_close(&again);
    }
    assert_int_not_equal(access("x.csv", F_OK), 0);
    buffer_free(&whole);
}

RUN_TESTS(enter_folder, leave_folder)
