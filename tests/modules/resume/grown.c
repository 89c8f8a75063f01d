/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The file of a session, read by another version of the program. `grown keep FILE` writes one, and
 * what the session answers; `grown read FILE` wants the same answers of what it reads there.
 * tests/rows has the second done by a program with more parameters, settings, observables and
 * methods. Without arguments both are done by this one.
 */
#include "cmocka_testing.h"

#include "modules/resume/testing.h"

#include <hooke/base/file.h>
#include <hooke/base/unit.h>

static const char *session_path = "session.hks", *answers_path = "session.txt";

static const char *const typed[] = {
    "load swing.csv; m = 200 g; data window 0.1:3.9; fit damped; adopt; measure period",
    "let A = 4.2 +- 0.1 cm",
    "scene damped; gamma = 0.3 1/s; F0 = 0.1 N; k = 15.1 +- 0.2; method rk4 dt=20ms; run 2 s",
    "change gamma 0.5 1/s; change F0 0.2 N; continue 1 s; rename 1 first; note kept",
    "scene spring; param stiff = 3 N/m^3; force -stiff*y^3; event low when y < -1 cm do record",
    "method dop853; run 3 s; change stiff 5 N/m^3; continue 1 s",
    "scene duffing-driven; branch F0=0.3:0.305 of response; set opinion full; method dopri5",
    "run 5 s; measure energy",
    "range y -1:1; set digits 8; zoom 2; checkpoint here; start y=1,v=0",
};

static const char *const asked[] = {
    "show; scene; runs; data; print A; list measurements; list branches; list events",
    "print measured_period; print k; print F0; print fit_gamma",
    "use 1; print y; continue 1 s; print y; print gamma; back 60; continue 2 s; print y",
    "use 2; print y; continue 1 s; print y; print energy",
    "use 3; continue 1 s; print y; fit; adopt; show",
    "branch F0=0.3:0.31 of response; list branches",
};

/* Appends what the session says, errors among it. */
static void ask(struct bench *b, struct buffer *answers)
{
    for (size_t i = 0; i < COUNT_OF(asked); i++) {
        type(b, asked[i]);
        buffer_format(answers, "> %s\n%s%s", asked[i], said(&b->out), said(&b->err));
    }
    assert_false(answers->failed);
}

static void a_session_is_kept(void **state)
{
    (void)state;
    struct bench b;
    struct stored stored = {0};
    struct buffer file = {0}, answers = {0}, swing = {0};
    buffer_put(&swing, TEXT("time,distance\ns,cm\n"));
    for (int i = 0; i < 200; i++) {
        const double t = 0.02 * i;
        buffer_format(&swing, "%.2f,%.4f\n", t, 20 + 5 * exp(-0.1 * t) * cos(8.66 * t));
    }
    write_file("swing.csv", swing.data, swing.len);
    bench_open(&b, false);
    type_ok(&b, "timing off");
    for (size_t i = 0; i < COUNT_OF(typed); i++)
        type_ok(&b, typed[i]);
    bench_store(b.session, &stored, &file);
    write_file(session_path, file.data, file.len);
    ask(&b, &answers);
    write_file(answers_path, answers.data, answers.len);
    bench_close(&b);
    stored_free(&stored);
    buffer_free(&file);
    buffer_free(&answers);
    buffer_free(&swing);
}

static void a_kept_session_is_read(void **state)
{
    (void)state;
    struct bench b;
    struct error error;
    struct buffer file = {0}, wanted = {0}, answers = {0}, notes = {0};
    if (!file_read(session_path, 1 << 22, &file, &error) ||
        !file_read(answers_path, 1 << 22, &wanted, &error))
        fail_msg("%s", error.text);
    if (!bench_restore(&b, buffer_text(&file), &notes) || notes.len > 0)
        fail_msg("it does not come back: %s", said(&notes));
    ask(&b, &answers);
    assert_string_equal(said(&answers), said(&wanted));
    bench_close(&b);
    buffer_free(&file);
    buffer_free(&wanted);
    buffer_free(&answers);
    buffer_free(&notes);
}

/* A quantity is found by its name, wherever it stands among the others; one that this program does
 * not have is another. */
static void quantities_are_found_by_name(void **state)
{
    (void)state;
    static const struct field member[] = {FIELD_OF_QUANTITY(struct named_value, quantity)};
    struct named_value read;
    struct buffer in = {0};
    for (int i = 0; i < QUANTITY_COUNT; i++) {
        const struct named_value kept = {.quantity = (enum quantity)i};
        buffer_clear(&in);
        fields_put(&in, member, 1, &kept);
        assert_non_null(memmem(in.data, in.len, quantity_name(kept.quantity),
                               strlen(quantity_name(kept.quantity))));
        assert_true(fields_get(buffer_text(&in), member, 1, &read));
        assert_int_equal(read.quantity, i);
    }
    buffer_clear(&in);
    field_text(&in, "quantity", TEXT("a new one"));
    assert_true(fields_get(buffer_text(&in), member, 1, &read));
    assert_int_equal(read.quantity, QUANTITY_OTHER);
    buffer_free(&in);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_session_is_kept),
                                       cmocka_unit_test(a_kept_session_is_read),
                                       cmocka_unit_test(quantities_are_found_by_name)};
    char path[256];
    if (argc < 3)
        return cmocka_run_group_tests(tests, enter_folder, leave_folder);
    snprintf(path, sizeof path, "%s.txt", argv[2]);
    session_path = argv[2];
    answers_path = path;
    cmocka_set_test_filter(strcmp(argv[1], "keep") == 0 ? "a_session*" : "a_kept*");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
