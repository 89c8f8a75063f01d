/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ctrl-C while the session's file is written: that stops at once and goes on where it stopped. */
#include "cmocka_testing.h"

#include "modules/recording/fits.h"
#include <hooke/base/cancel.h>
#include <hooke/base/fields.h>
#include <hooke/run/store.h>

#include "modules/resume/testing.h"

/* A file, and a Ctrl-C that comes while its record number `at` is written; 0: none. */
struct stopped_file {
    struct buffer bytes;
    struct cancel cancel;
    int records, at;
};

static bool add_record(void *context, struct text record, struct error *error)
{
    struct stopped_file *file = context;
    if (++file->records == file->at)
        atomic_store(&file->cancel.requested, 1);
    return bench_add(&file->bytes, record, error);
}

/* How many records it wrote. */
static int store_until(struct session *session, struct stored *stored, struct stopped_file *file,
                       int at)
{
    struct error error;
    const struct store_sink sink = {file, add_record, &file->cancel, 0};
    file->at = at;
    file->records = 0;
    assert_true(session_store(session, stored, &sink, &error));
    atomic_store(&file->cancel.requested, 0);
    return file->records;
}

static void begin_runs(struct bench *b, struct stored *stored, struct stopped_file *file)
{
    bench_open(b, false);
    *stored = (struct stored){0};
    *file = (struct stopped_file){.at = 0};
    buffer_put(&file->bytes, TEXT(STORE_HEADER));
    type_ok(b, "scene damped; method verlet dt=1ms; set record all");
    type_ok(b, "run 20 s; run 10 s; run 30 s");
}

static void end_runs(struct bench *b, struct stored *stored, struct stopped_file *file)
{
    stored_free(stored);
    buffer_free(&file->bytes);
    bench_close(b);
}

static uint64_t rows_sum(const struct run *run)
{
    struct buffer rows = {0};
    run_store_rows(run, 0, run_recorded(run), &rows);
    const uint64_t sum = bytes_sum(buffer_text(&rows));
    buffer_free(&rows);
    return sum;
}

/* All runs are in the file, bit for bit. */
static void assert_whole(const struct bench *b, const struct stopped_file *file)
{
    struct bench again;
    struct buffer notes = {0};
    if (!bench_restore(&again, buffer_text(&file->bytes), &notes) || notes.len > 0)
        fail_msg("it does not come back: %s", said(&notes));
    assert_int_equal(again.session->runs.count, b->session->runs.count);
    for (int i = 0; i < b->session->runs.count; i++) {
        const struct run *is = again.session->runs.slot[i]->run,
                         *was = b->session->runs.slot[i]->run;
        assert_int_equal(run_recorded(is), run_recorded(was));
        assert_true(rows_sum(is) == rows_sum(was));
    }
    bench_close(&again);
    buffer_free(&notes);
}

TEST(writing_stops_and_goes_on)
{
    struct bench b;
    struct stored stored;
    struct stopped_file file;
    begin_runs(&b, &stored, &file);
    const int whole = store_until(b.session, &stored, &file, 0);
    const size_t bytes = file.bytes.len;
    assert_false(stored.unfinished);
    assert_true(whole > 15); /* 60000 rows, 4096 each */
    end_runs(&b, &stored, &file);

    begin_runs(&b, &stored, &file);
    int pieces = 0;
    for (bool ended = false; !ended; pieces++) {
        const int records = store_until(b.session, &stored, &file, 1);
        ended = !stored.unfinished;
        assert_true(ended || records <= 2); /* rows, and the rest of a run */
        assert_true(pieces < 2 * whole);
    }
    assert_true(pieces > 12);
    assert_true(file.bytes.len < bytes + bytes / 50); /* nothing is written twice */
    assert_whole(&b, &file);
    assert_int_equal(store_until(b.session, &stored, &file, 0), 0); /* there is no more */
    end_runs(&b, &stored, &file);
}

/* What changes before it goes on: rows that are in the file, and others that are not. */
TEST(what_changed_meanwhile_is_written)
{
    static const char *const change[] = {"back 15000", "continue 5 s", "drop 2", "undo",
                                         "drop all"};
    for (size_t i = 0; i < COUNT_OF(change); i++) {
        for (int at = 1; at < 15; at += 6) {
            struct bench b;
            struct stored stored;
            struct stopped_file file;
            begin_runs(&b, &stored, &file);
            store_until(b.session, &stored, &file, at);
            assert_true(stored.unfinished);
            type_ok(&b, change[i]);
            store_until(b.session, &stored, &file, 0);
            assert_false(stored.unfinished);
            assert_whole(&b, &file);
            end_runs(&b, &stored, &file);
        }
    }
}

/* Another file, given up in the middle, changes nothing for the first. */
TEST(a_file_given_up_leaves_the_other)
{
    struct bench b;
    struct stored stored, other = {0};
    struct stopped_file file, second = {.at = 0};
    begin_runs(&b, &stored, &file);
    store_until(b.session, &stored, &file, 0);
    store_until(b.session, &other, &second, 5);
    assert_true(other.unfinished);
    const size_t bytes = file.bytes.len;
    type_ok(&b, "continue 1 s");
    store_until(b.session, &stored, &file, 0);
    assert_true(file.bytes.len - bytes < bytes / 10);
    assert_whole(&b, &file);
    stored_free(&other);
    buffer_free(&second.bytes);
    end_runs(&b, &stored, &file);
}

/* A swing of so many rows, 1 ms apart. */
static void write_swing(const char *name, int rows)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs("t (s)\ty (cm)\n", file);
    for (int i = 0; i < rows; i++)
        fprintf(file, "%.3f\t%.5f\n", 0.001 * i, 20 + 5 * cos(0.0087 * i) + 0.01 * (i % 7 - 3));
    fclose(file);
}

/* A recording is one record, larger than what is written at once; so is a fitted curve, which is
 * written once, not each time. */
TEST(large_records_stop_in_the_middle)
{
    struct bench b, again;
    struct stored stored = {0};
    struct stopped_file file = {.at = 0};
    struct buffer notes = {0};
    write_swing("swing.txt", 80000); /* 1.3 MB, its curve 1.2 MB */
    bench_open(&b, false);
    buffer_put(&file.bytes, TEXT(STORE_HEADER));
    type_ok(&b, "load swing.txt; fit a*cos(w*t)+c w=8.7");
    int pieces = 0;
    do {
        const int writes = store_until(b.session, &stored, &file, 1);
        assert_true(!stored.unfinished || writes <= 2);
    } while (stored.unfinished && ++pieces < 20);
    assert_in_range(pieces, 2, 5);
    const size_t bytes = file.bytes.len;
    type_ok(&b, "m = 200 g");
    store_until(b.session, &stored, &file, 0);
    assert_in_range(file.bytes.len, bytes + 1, bytes + 100000);

    if (!bench_restore(&again, buffer_text(&file.bytes), &notes) || notes.len > 0)
        fail_msg("it does not come back: %s", said(&notes));
    const size_t n = fits_of(b.session)->fit_samples;
    assert_int_equal(n, 80000);
    assert_int_equal(fits_of(again.session)->fit_samples, n);
    for (int i = 0; i < 2; i++)
        assert_memory_equal(fits_of(again.session)->fit_curve[i], fits_of(b.session)->fit_curve[i],
                            n * sizeof(double));
    bench_close(&again);
    buffer_free(&notes);
    end_runs(&b, &stored, &file);
}

RUN_TESTS(enter_folder, leave_folder)
