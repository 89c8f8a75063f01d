/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A sweep that is stopped goes on with `continue`, in memory and in a file: the same bytes. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>
#include <hooke/base/cancel.h>

#include "modules/sweep/handlers.h"
#include "unit/command/testing.h"

/* Each point alone, more than 0.5 s in all, wherever this runs; it is stopped at the first
 * look that finds some of them finished, after a tenth of a second. */
#define SETUP "scene pendulum; method rodas5p; tol = 1e-9; duration = 20 s"
#define SWEEP "sweep theta0=0.1:3:0.01 gamma=0.1:0.5:0.1 measure=y --threads 1"

struct stopping {
    struct bench b;
    struct cancel cancel;
    double seen; /* of the sweep, when it was stopped */
};

static const struct stopped_sweep *stopped(const struct stopping *s)
{
    const struct sweep_part *part = session_part_if_made(s->b.session, &sweep_module);
    return part ? part->stopped : NULL;
}

/* Not before more is finished than the last time: a slow machine may have done nothing yet. */
static void stop(void *context, const struct run *run, double fraction)
{
    struct stopping *s = context;
    (void)run;
    if (fraction > s->seen && fraction <= 1) {
        s->seen = fraction;
        atomic_store(&s->cancel.requested, 1);
    }
}

static void begin(struct stopping *s, const char *setup)
{
    bench_open(&s->b, true);
    atomic_store(&s->cancel.requested, 0);
    s->b.session->front.cancel = &s->cancel;
    s->b.session->front.context = s;
    type_ok(&s->b, setup);
}

static void is_stopped(struct stopping *s, const char *line)
{
    s->seen = strcmp(line, "continue") == 0 ? s->seen : 0;
    s->b.session->front.progress = stop;
    assert_false(type(&s->b, line));
    s->b.session->front.progress = NULL;
    atomic_store(&s->cancel.requested, 0);
    assert_says(&s->b.err, "stopped: ");
    assert_says(&s->b.err, "'continue'");
}

static void table_is(struct bench *b, const char *file, const struct buffer *wanted)
{
    struct buffer text = {0};
    struct error error = {0};
    assert_true(file_read(file, 1 << 24, &text, &error));
    assert_int_equal(text.len, wanted->len);
    assert_memory_equal(text.data, wanted->data, wanted->len);
    buffer_free(&text);
    (void)b;
}

TEST(goes_on)
{
    struct stopping s;
    struct bench whole, again;
    struct buffer wanted = {0}, in_file = {0};
    struct error error = {0};
    bench_open(&whole, true);
    type_ok(&whole, SETUP "; " SWEEP "; export whole.csv table --force");
    type_ok(&whole, SWEEP " --resume whole-file.csv");
    assert_true(file_read("whole.csv", 1 << 24, &wanted, &error));
    assert_true(file_read("whole-file.csv", 1 << 24, &in_file, &error));
    bench_close(&whole);

    begin(&s, SETUP);
    type_ok(&s.b, "record kept.hk");
    is_stopped(&s, SWEEP);
    assert_non_null(stopped(&s));
    const int64_t found = stopped(&s)->found.finished;
    assert_true(found > 0 && found < 1455);
    is_stopped(&s, "continue"); /* again */
    assert_true(stopped(&s)->found.finished > found);
    /* What was looked at meanwhile is no obstacle, another set-up is one. */
    type_ok(&s.b, "print 2+2; gamma = 2");
    assert_false(type(&s.b, "continue"));
    assert_says(&s.b.err, "had another set-up");
    type_ok(&s.b, "undo; continue; record off; export table.csv table --force");
    assert_null(stopped(&s));
    table_is(&s.b, "table.csv", &wanted);
    assert_false(type(&s.b, "continue"));
    assert_says(&s.b.err, "there is no run yet");

    /* The record says the sweep, not that it was stopped. */
    bench_open(&again, false);
    type_ok(&again, SETUP "; source kept.hk; export again.csv table --force");
    table_is(&again, "again.csv", &wanted);
    bench_close(&again);

    is_stopped(&s, SWEEP " --resume file.csv");
    type_ok(&s.b, "continue");
    table_is(&s.b, "file.csv", &in_file);

    /* A run that was started since is what continue means. */
    is_stopped(&s, SWEEP);
    type_ok(&s.b, "run 1 s");
    assert_null(stopped(&s));
    type_ok(&s.b, "continue 1 s");
    is_stopped(&s, SWEEP);
    type_ok(&s.b, "continue 1 s"); /* this too */
    type_ok(&s.b, "sweep theta0=0.1:0.3:0.1");
    assert_null(stopped(&s));
    is_stopped(&s, SWEEP); /* and what is left at the end is freed */
    bench_close(&s.b);
    buffer_free(&wanted);
    buffer_free(&in_file);
}

RUN_TESTS(enter_folder, leave_folder)
