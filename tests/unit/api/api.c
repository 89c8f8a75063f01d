/* SPDX-License-Identifier: GPL-3.0-or-later */
/* hooke/api.h as other programs use it: nothing of the other layers is looked at here. */
#include <hooke/api.h>
#include <hooke/module.h>

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cmocka_testing.h"

static struct hooke *opened(unsigned flags)
{
    struct hooke *hooke = hooke_open(flags);
    assert_non_null(hooke);
    return hooke;
}

static void run_ok(struct hooke *hooke, const char *lines)
{
    if (hooke_run(hooke, lines) != 0)
        fail_msg("%s\n%s", lines, hooke_messages(hooke));
    assert_null(hooke_error(hooke));
}

/* ---- what lines say and find ---- */

TEST(test_lines)
{
    double value = 0, uncertainty = -1;
    (void)state;
    struct hooke *hooke = opened(0);
    run_ok(hooke, "m = 200 +- 2 g\n# a comment\nprint \\\n  2*m\nprint 3");
    assert_string_equal(hooke_output(hooke), "m = 200 +- 2 g\n0.4\n3\n");
    assert_string_equal(hooke_messages(hooke), "");
    assert_int_equal(hooke_value(hooke, "m", &value, &uncertainty), 1);
    assert_true(value == 0.2 && uncertainty == 0.002);
    assert_int_equal(hooke_value(hooke, "m", &value, NULL), 1);
    assert_int_equal(hooke_value(hooke, "nothing", &value, NULL), 0);
    run_ok(hooke, "");
    assert_string_equal(hooke_output(hooke), "");
    run_ok(hooke, "quit; print 1"); /* ends the lines, not the session */
    run_ok(hooke, "print 2");
    assert_string_equal(hooke_output(hooke), "2\n");
    hooke_close(hooke);
}

TEST(test_errors)
{
    struct hooke *hooke = opened(0);
    assert_int_equal(hooke_run(hooke, "m = 0.3\nk = 10; gamam = 2\nm = 0.4"), 1);
    const struct hooke_error *error = hooke_error(hooke);
    assert_non_null(error);
    assert_int_equal(error->status, 1);
    assert_int_equal(error->line, 2);
    assert_int_equal(error->column, 9);
    assert_null(error->file);
    assert_string_equal(error->code, "command");
    assert_non_null(strstr(error->message, "gamam"));
    assert_non_null(strstr(error->hint, "gamma"));
    assert_non_null(strstr(hooke_messages(hooke), "hooke_run:2:9: error:"));
    double m = 0;
    assert_int_equal(hooke_value(hooke, "m", &m, NULL), 1);
    assert_true(m == 0.3); /* what stood before it was executed, what stands behind was not */

    assert_int_equal(hooke_run(hooke, "source nowhere.hk"), 2);
    assert_int_equal(hooke_error(hooke)->status, 2);
    /* a run that leaves the numbers */
    assert_int_equal(hooke_run(hooke, "k = 1e6; method euler dt=1s; run 5000 s --force"), 3);
    assert_string_equal(hooke_error(hooke)->code, "numerical");
    run_ok(hooke, "print 1");
    hooke_close(hooke);
}

TEST(test_error_in_a_file)
{
    char path[] = "/tmp/hooke-api-XXXXXX", line[100];
    (void)state;
    const int file = mkstemp(path);
    assert_true(file >= 0 && write(file, "m = 1\nm = = 2\n", 14) == 14 && close(file) == 0);
    struct hooke *hooke = opened(0);
    snprintf(line, sizeof line, "print 1\nsource %s", path);
    assert_int_equal(hooke_run(hooke, line), 1);
    assert_string_equal(hooke_error(hooke)->file, path);
    assert_int_equal(hooke_error(hooke)->line, 2);
    hooke_close(hooke);
    unlink(path);
}

/* ---- tables ---- */

TEST(test_tables)
{
    struct hooke *hooke = opened(0);
    assert_null(hooke_table(hooke, "t y"));
    assert_non_null(strstr(hooke_error(hooke)->message, "run"));
    run_ok(hooke, "scene spring; method rk4 dt=10ms; run 1 s");
    struct hooke_table *run = hooke_table(hooke, "t y energy");
    assert_non_null(run);
    assert_null(hooke_error(hooke));
    assert_string_equal(hooke_output(hooke), "");
    assert_int_equal(hooke_rows(run), 101);
    assert_int_equal(hooke_columns(run), 3);
    assert_string_equal(hooke_column_name(run, 1), "y");
    assert_string_equal(hooke_column_unit(run, 1), "m");
    assert_null(hooke_column_name(run, 3));
    assert_null(hooke_column_unit(run, 3));
    assert_null(hooke_column(run, "v"));
    assert_null(hooke_text(run, "y", 0));
    double k = 0, m = 0, y0 = 0;
    assert_true(hooke_value(hooke, "k", &k, NULL) && hooke_value(hooke, "m", &m, NULL) &&
                hooke_value(hooke, "y0", &y0, NULL));
    hooke_close(hooke); /* a table is the caller's own */
    const double *t = hooke_column(run, "t"), *y = hooke_column(run, "y");
    for (size_t i = 0; i < 101; i++) {
        assert_true(fabs(t[i] - 0.01 * (double)i) < 1e-12);
        assert_true(fabs(y[i] - y0 * cos(sqrt(k / m) * t[i])) < 1e-4 * fabs(y0));
    }
    hooke_table_free(run);
}

TEST(test_results)
{
    struct error error;
    bool compared = false;
    (void)state;
    if (!module_is_in("compare", TEXT("compare"), &error))
        skip();
    struct hooke *hooke = opened(0);
    assert_null(hooke_result(hooke, 0));
    run_ok(hooke, "set format json; duration = 2 s; compare euler rk4");
    for (size_t i = 0; hooke_result(hooke, i); i++)
        compared |= strcmp(hooke_result(hooke, i), "compare") == 0;
    assert_true(compared);
    struct hooke_table *table = hooke_table(hooke, "table of compare");
    assert_non_null(table);
    assert_int_equal(hooke_rows(table), 2);
    assert_string_equal(hooke_text(table, "method", 0), "euler");
    assert_null(hooke_text(table, "method", 2));
    assert_null(hooke_column(table, "method"));
    assert_true(hooke_column(table, "error")[1] < hooke_column(table, "error")[0]);
    hooke_table_free(table);

    /* one table, and nothing else */
    static const char *const refused[] = {"t; m = 5", "t\nm = 5", "t > /tmp/x.csv", "nothing"};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        double m = 0;
        assert_null(hooke_table(hooke, refused[i]));
        assert_true(hooke_error(hooke)->message[0] && hooke_value(hooke, "m", &m, NULL) && m != 5);
    }
    hooke_close(hooke);
}

TEST(test_nothing)
{
    double value;
    (void)state;
    hooke_close(NULL);
    hooke_cancel(NULL);
    hooke_table_free(NULL);
    assert_true(hooke_run(NULL, "print 1") != 0);
    assert_string_equal(hooke_error(NULL)->message, "out of memory");
    assert_string_equal(hooke_output(NULL), "");
    assert_null(hooke_table(NULL, ""));
    assert_null(hooke_result(NULL, 0));
    assert_int_equal(hooke_value(NULL, "m", &value, NULL), 0);
    assert_int_equal(hooke_rows(NULL) + hooke_columns(NULL), 0);
    assert_null(hooke_column(NULL, "t"));
    assert_null(hooke_text(NULL, "t", 0));
    assert_true(strchr(hooke_version(), '.') != NULL);
    struct hooke *hooke = opened(0);
    assert_int_equal(hooke_run(hooke, NULL), 0);
    assert_int_equal(hooke_value(hooke, NULL, &value, NULL), 0);
    assert_int_equal(hooke_value(hooke, "m", NULL, NULL), 1);
    hooke_close(hooke);
}

/* ---- others beside it ---- */

TEST(test_safe)
{
    struct hooke *hooke = opened(HOOKE_SAFE);
    run_ok(hooke, "scene spring; run 1 s");
    assert_true(hooke_run(hooke, "export /tmp/hooke-api.csv --force") != 0);
    assert_non_null(strstr(hooke_error(hooke)->message, "safe"));
    hooke_close(hooke);
}

struct canceller {
    struct hooke *hooke;
    atomic_bool done;
};

/* Again and again: one that comes before the run stops nothing. */
static void *cancel_soon(void *context)
{
    struct canceller *canceller = context;
    const struct timespec soon = {.tv_nsec = 100000000};
    while (!canceller->done) {
        nanosleep(&soon, NULL);
        hooke_cancel(canceller->hooke);
    }
    return NULL;
}

TEST(test_cancel)
{
    pthread_t other;
    (void)state;
    struct hooke *hooke = opened(0);
    struct canceller canceller = {.hooke = hooke};
    assert_int_equal(pthread_create(&other, NULL, cancel_soon, &canceller), 0);
    const int status = hooke_run(
        hooke, "set record every 100000; scene pendulum; method rk4 dt=0.001ms; run 1e5 s --force");
    canceller.done = true;
    pthread_join(other, NULL);
    assert_int_equal(status, 130);
    assert_int_equal(hooke_error(hooke)->status, 130);
    hooke_cancel(hooke); /* nothing goes on: nothing is stopped later */
    run_ok(hooke, "run 1 s");
    hooke_close(hooke);
}

struct worker {
    double theta0, end;
};

static void *work(void *context)
{
    struct worker *worker = context;
    struct hooke *hooke = hooke_open(0);
    char line[100];
    snprintf(line, sizeof line, "scene pendulum; method rk4 dt=1ms; theta0 = %.17g; run 5 s",
             worker->theta0);
    worker->end = NAN;
    if (hooke && hooke_run(hooke, line) == 0)
        hooke_value(hooke, "theta", &worker->end, NULL);
    hooke_close(hooke);
    return NULL;
}

TEST(test_threads)
{
    struct worker worker[4], alone;
    pthread_t thread[4];
    (void)state;
    for (int i = 0; i < 4; i++) {
        worker[i].theta0 = 0.5 * (i + 1);
        assert_int_equal(pthread_create(&thread[i], NULL, work, &worker[i]), 0);
    }
    for (int i = 0; i < 4; i++)
        pthread_join(thread[i], NULL);
    for (int i = 0; i < 4; i++) {
        alone = worker[i];
        work(&alone);
        assert_true(alone.end == worker[i].end);
    }
}

RUN_TESTS(NULL, NULL)
