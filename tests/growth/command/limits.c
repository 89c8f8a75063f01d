/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every limit of the program: as much as it says works; one more is an error that says how much
 * does, and nothing is changed by it; or the oldest goes, and nothing else. */
#include "cmocka_testing.h"

#include "modules/recording/fits.h"
#include "long_form.h"
#include "unit/command/random_session.h"

static double limit_of(const char *name)
{
    const struct row *row = catalog_find(&limit_catalog, text_of(name));
    if (!row)
        fail_msg("there is no limit %s", name);
    return ((const struct limit *)(const void *)row)->value;
}

/* ---- lines that are refused ---- */

/* After `first`, which has `before` of it already, `each` (# counts from 1) as often as it works,
 * and once more. */
static const struct counted {
    const char *limit, *first, *each;
    int before;
    bool dear; /* long form only */
} counted[] = {
    {.limit = "runs", .each = "run 1 ms"},
    {.limit = "recordings", .each = "load swing.txt as=r#"},
    {.limit = "checkpoints", .each = "checkpoint a#"},
    {.limit = "let", .each = "let A# = 1"},
    {.limit = "events", .each = "event a# when y > # do record"},
    {.limit = "own-scenes", .each = "scene new s#; var x = 1; x' = -x"},
    {.limit = "variables", .first = "scene new", .each = "var x# = 1; x#' = -x#"},
    {.limit = "parameters",
     .first = "scene new; var x = 1; x' = -x",
     .each = "param p# = 1",
     .before = 2},
    {.limit = "observed", .each = "observe o# = y"},
    {.limit = "requests", .first = "run 1 ms", .each = "continue 1 ms", .before = 1, .dear = true},
    {.limit = "changes",
     .first = "dt = 1e-6 s; run 1e-5 s; step",
     .each = "change k #; step",
     .dear = true},
};

/* One line: `first`, `each`, `last`; `each` as often as makes it of that size, and once more. */
static const struct sized {
    const char *limit, *first, *each, *last, *setup; /* setup: a line before it */
    int before, step;                                /* size without any, and of one (0: 1) */
    bool mirrored;                                   /* as many of `last` as of `each` */
} sized[] = {
    {.limit = "line", .first = "print 1", .each = " ", .last = "", .before = 7},
    {.limit = "tokens", .first = "drop", .each = " 1", .last = "", .setup = "run 1 ms"},
    {.limit = "expr-depth", .first = "print ", .each = "(", .last = "1)", .mirrored = true},
    {.limit = "expr-size", .first = "force -y", .each = "*y", .last = "", .before = 2, .step = 2},
    {.limit = "name", .first = "let A", .each = "a", .last = " = 1", .before = 1},
    {.limit = "symbol", .first = "scene new a", .each = "a", .last = "", .before = 1},
    {.limit = "event-text",
     .first = "event e when y > 0 do 'k = 3;",
     .each = " ",
     .last = "'",
     .before = 6},
};

/* Lines as they are. */
static const struct pair {
    const char *limit, *first, *works, *refused;
} pairs[] = {
    {"overlay", "run 1 ms; run 1 ms; run 1 ms; run 1 ms; run 1 ms; run 1 ms", "overlay run 1 2 3 4",
     "overlay run 1 2 3 4 5"},
    {"steps", "dt = 1 s; k = 1e-6 N/m", "run 9007199254740992 s --force --steps 1",
     "run 9007199254740996 s --force"},
    {"modes", "load swing.txt", NULL, "fit modes 6"},
    {"columns", "load wide1024.txt", "load wide1024.txt as=again", "load wide1025.txt"},
    {"source-depth", NULL, "source deep2.hk", "source deep1.hk"},
    {"file", NULL, NULL, "load huge.txt"}, /* what is read of that size takes seconds and 1 GiB */
    {"script", NULL, NULL, "source huge.txt"},
};

/* Of these the oldest goes. */
static const char *const sliding[] = {"undo",    "log",     "measurements", "fits",
                                      "results", "history", "history-text"};
/* Not tested here, and why. */
static const char *const elsewhere[] = {
    "samples",       /* the trace is thinned there: tests/unit/run */
    "event-records", /* a million events of a run take a minute */
    "orbits",        /* tests/modules/dynamics/kept_dynamics.c */
    "branches",      /* the same */
    "branch-points", /* tests/modules/dynamics/cli/branch.hk */
};

static void put_line(struct buffer *line, const char *text, int number)
{
    for (; text && *text; text++)
        if (*text == '#')
            buffer_format(line, "%d", number);
        else
            buffer_char(line, *text);
}

static bool type_line(struct bench *b, const struct buffer *line)
{
    buffer_clear(&b->out);
    buffer_clear(&b->err);
    return command_exec(b->session, buffer_text(line), NULL, &b->reply);
}

/* The line is refused: it names the limit's number, and the session is as it was. */
static void assert_refused(struct bench *b, const char *limit, const struct buffer *line)
{
    struct buffer before = {0}, after = {0}, number = {0};
    describe(b->session, (unsigned)-1, &before);
    if (type_line(b, line))
        fail_msg("%s: one more works", limit);
    const double value = limit_of(limit);
    if (value < 1e15)
        buffer_format(&number, "%.0f", value);
    if (!strstr(said(&b->err), said(&number)) && !strstr(said(&b->err), "GiB") &&
        !strstr(said(&b->err), "MiB"))
        fail_msg("%s: %.300s", limit, said(&b->err));
    describe(b->session, (unsigned)-1, &after);
    assert_same(&before, &after, limit, &after);
    buffer_free(&before);
    buffer_free(&after);
    buffer_free(&number);
}

TEST(counted_things_are_refused)
{
    for (size_t i = 0; i < COUNT_OF(counted); i++) {
        const struct counted *of = &counted[i];
        struct bench b;
        struct buffer line = {0};
        if (of->dear && !is_long())
            continue;
        bench_open(&b, false);
        if (of->first)
            type_ok(&b, of->first);
        const int limit = (int)limit_of(of->limit) - of->before;
        for (int k = 1; k <= limit + 1; k++) {
            buffer_clear(&line);
            put_line(&line, of->each, k);
            if (k > limit)
                assert_refused(&b, of->limit, &line);
            else if (!type_line(&b, &line))
                fail_msg("%s, %d of %d: %.300s", of->limit, k, limit, said(&b.err));
        }
        buffer_free(&line);
        bench_close(&b);
    }
}

TEST(sizes_are_refused)
{
    for (size_t i = 0; i < COUNT_OF(sized); i++) {
        const struct sized *of = &sized[i];
        const int step = of->step ? of->step : 1,
                  fits = ((int)limit_of(of->limit) - of->before) / step;
        for (int more = 0; more < 2; more++) {
            struct bench b;
            struct buffer line = {0};
            bench_open(&b, false);
            if (of->setup)
                type_ok(&b, of->setup);
            put_line(&line, of->first, 0);
            for (int k = 0; k < fits + more; k++)
                put_line(&line, of->each, 0);
            for (int k = 0; k < (of->mirrored ? fits + more : 1); k++)
                put_line(&line, of->mirrored && k > 0 ? ")" : of->last, 0);
            if (more)
                assert_refused(&b, of->limit, &line);
            else if (!type_line(&b, &line))
                fail_msg("%s: %.300s", of->limit, said(&b.err));
            buffer_free(&line);
            bench_close(&b);
        }
    }
}

static void write_files(void)
{
    for (int width = 1024; width <= 1025; width++) {
        struct buffer text = {0};
        char name[32];
        for (int row = 0; row < 4; row++)
            for (int column = 0; column < width; column++)
                buffer_format(&text, "%d%c", row + column, column + 1 < width ? '\t' : '\n');
        snprintf(name, sizeof name, "wide%d.txt", width);
        write_file(name, text.data, text.len);
        buffer_free(&text);
    }
    for (int depth = 1; depth <= 17; depth++) {
        char name[32], line[32];
        snprintf(name, sizeof name, "deep%d.hk", depth);
        snprintf(line, sizeof line, depth < 17 ? "source deep%d.hk\n" : "print %d\n", depth + 1);
        write_file(name, line, strlen(line));
    }
    write_file("huge.txt", "1 2\n", 4);
    assert_int_equal(truncate("huge.txt", (off_t)limit_of("file") + 1), 0);
}

TEST(lines_are_refused)
{
    write_files();
    for (size_t i = 0; i < COUNT_OF(pairs); i++) {
        struct bench b;
        struct buffer line = {0};
        bench_open(&b, false);
        if (pairs[i].first)
            type_ok(&b, pairs[i].first);
        if (pairs[i].works)
            type_ok(&b, pairs[i].works);
        put_line(&line, pairs[i].refused, 0);
        assert_refused(&b, pairs[i].limit, &line);
        buffer_free(&line);
        bench_close(&b);
    }
}

/* ---- what is forgotten ---- */

TEST(the_oldest_goes)
{
    struct bench b;
    char line[64];
    bench_open(&b, false);
    const int undo = (int)limit_of("undo"), kept = (int)limit_of("measurements");
    for (int i = 1; i <= undo + 1; i++) {
        snprintf(line, sizeof line, "let A%d = %d", i % 100, i);
        type_ok(&b, line);
    }
    for (int i = 0; i < undo; i++)
        type_ok(&b, "undo");
    assert_false(type(&b, "undo"));
    type_ok(&b, "print A1"); /* the first one stays done */
    assert_says(&b.out, "1");
    assert_false(type(&b, "print A2"));
    type_ok(&b, "run 10 ms");
    for (int i = 1; i <= kept; i++)
        type_ok(&b, i == 1 ? "measure drift" : "measure energy");
    assert_string_equal(b.session->measurement[0].quantity, "drift");
    type_ok(&b, "measure energy");
    assert_int_equal(b.session->measurements, kept);
    assert_string_equal(b.session->measurement[0].quantity, "energy");
    for (int i = 0; i <= (int)limit_of("fits"); i++)
        session_store_fit(
            b.session, &(struct stored_fit){.fit = {.model = "sine", .rms = i},
                                            .subject = {(char)(1 + i / 100), (char)(1 + i % 100)}});
    assert_int_equal(fits_of(b.session)->stored_fits, (int)limit_of("fits"));
    assert_true(fits_of(b.session)->stored_fit[0].fit.rms == 1);
    const int results = (int)limit_of("results");
    for (int i = b.session->results.count; i <= results; i++) {
        assert_int_equal(b.session->results.count, i); /* up to there nothing has gone */
        const struct named_value oldest = b.session->results.value[0],
                                 next = b.session->results.value[1];
        snprintf(line, sizeof line, "fit_of_%d", i);
        session_set_result(b.session, line, (struct measured){i, 0}, QUANTITY_NUMBER);
        assert_string_equal(b.session->results.value[0].name,
                            i < results ? oldest.name : next.name);
    }
    assert_int_equal(b.session->results.count, results);
    snprintf(line, sizeof line, "print fit_of_%d", results);
    type_ok(&b, line);
    assert_says(&b.out, "128");
    for (int i = 0; i <= (int)limit_of("log"); i++)
        log_add(&b.session->log, text_of(i ? "later" : "first"));
    assert_int_equal(b.session->log.count, (int)limit_of("log"));
    assert_string_equal(log_line(&b.session->log, b.session->log.count - 1), "later");
    bench_close(&b);
}

/* ---- all of them ---- */

static bool is_tested(const char *name)
{
    bool tested = false;
    for (size_t i = 0; i < COUNT_OF(counted); i++)
        tested |= strcmp(name, counted[i].limit) == 0;
    for (size_t i = 0; i < COUNT_OF(sized); i++)
        tested |= strcmp(name, sized[i].limit) == 0;
    for (size_t i = 0; i < COUNT_OF(pairs); i++)
        tested |= strcmp(name, pairs[i].limit) == 0;
    for (size_t i = 0; i < COUNT_OF(sliding); i++)
        tested |= strcmp(name, sliding[i]) == 0;
    for (size_t i = 0; i < COUNT_OF(elsewhere); i++)
        tested |= strcmp(name, elsewhere[i]) == 0;
    return tested;
}

TEST(every_limit_is_tested)
{
    for (size_t i = 0; i < limit_catalog.count; i++)
        if (!is_tested(catalog_row(&limit_catalog, i)->name))
            fail_msg("the limit %s is not tested", catalog_row(&limit_catalog, i)->name);
}

static int begin(void **state)
{
    const int status = enter_folder(state);
    write_recordings();
    return status;
}

RUN_TESTS(begin, leave_folder)
