/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log, and the commands that say what the screen shows. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>
#include <hooke/plot.h>
#include "unit/command/testing.h"

TEST(log_is_a_ring)
{
    struct log log = {0};
    assert_null(log_line(&log, 0));
    log_add(&log, TEXT("one\ntwo\n"));
    assert_int_equal(log.count, 2);
    assert_string_equal(log_line(&log, 0), "two");
    assert_string_equal(log_line(&log, 1), "one");
    assert_null(log_line(&log, 2));
    assert_null(log_line(&log, -1));
    log_add(&log, TEXT("a\033[31mb\n\n"));
    assert_string_equal(log_line(&log, 0), "");
    assert_null(strchr(log_line(&log, 1), '\033'));
    log_add(&log, TEXT(""));
    assert_int_equal(log.count, 5);
    char line[24];
    for (int i = 0; i < 3 * LIMIT_LOG / 2; i++) {
        snprintf(line, sizeof line, "line %d", i);
        log_add(&log, text_of(line));
    }
    assert_int_equal(log.count, LIMIT_LOG);
    assert_string_equal(log_line(&log, 0), line);
    snprintf(line, sizeof line, "line %d", LIMIT_LOG / 2);
    assert_string_equal(log_line(&log, LIMIT_LOG - 1), line);
    log_clear(&log);
    assert_int_equal(log.count, 0);
    assert_null(log_line(&log, 0));
}

/* The rows of a line, each with its indentation, joined by '|'. */
static void rows_of(const char *line, int width, char rows[200])
{
    const struct text text = text_of(line);
    size_t from = 0, n = 0;
    int indent;
    do {
        const struct text row = log_row(text, &from, width, &indent);
        n += (size_t)snprintf(rows + n, 200 - n, "%s%*s%.*s", n ? "|" : "", indent, "",
                              (int)row.len, row.data);
    } while (from < text.len);
}

TEST(long_lines_go_on_in_the_next_row)
{
    static const struct {
        const char *line;
        int width;
        const char *rows;
    } cases[] = {
        {"", 10, ""},
        {"as it is", 8, "as it is"},
        {"one two three four", 10, "one two|  three|  four"},
        {"one two three", 9, "one two|  three"},
        {"one two  and", 8, "one two|  and"}, /* the blanks at the break are gone */
        {"one two   ", 7, "one two"},
        {"  told:  a table", 12, "  told:  a|  table"}, /* others stay */
        {"abcdefghijklmnopqrstuvw", 10, "abcdefghij|  klmnopqr|  stuvw"},
        {"ab cdefghijklmnopq", 10, "ab|  cdefghij|  klmnopq"},
        {"one two", 3, "one|two"}, /* no room for an indentation */
        {"ab", 1, "a|b"},
        {"\xE6\x97\xA5\xE6\x9C\xAC\xE6\x97\xA5", 5,
         "\xE6\x97\xA5\xE6\x9C\xAC|\xE6\x97\xA5"},                    /* two cells each */
        {"\xE6\x97\xA5\xE6\x9C\xAC", 1, "\xE6\x97\xA5|\xE6\x9C\xAC"}, /* wider than the pane */
        {"se\xCC\x81 se\xCC\x81 se\xCC\x81 x", 8,
         "se\xCC\x81 se\xCC\x81 se\xCC\x81|  x"}, /* an accent has no width */
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char rows[200];
        rows_of(cases[i].line, cases[i].width, rows);
        assert_string_equal(rows, cases[i].rows);
        int bars = 1;
        for (const char *c = rows; *c; c++)
            bars += *c == '|';
        assert_int_equal(log_rows(text_of(cases[i].line), cases[i].width), bars);
    }
}

/* A screen whose automatic window is the newest 6 s at most, with the axis going on to 21 s. */
static bool newest_part(void *context, const struct session *session, double span[2])
{
    (void)context;
    const bool fixed = session->view.x[0] < session->view.x[1];
    span[0] = fixed ? session->view.x[0] : 15;
    span[1] = fixed ? session->view.x[1] : 21;
    return true;
}

TEST(zoom_starts_from_what_is_shown)
{
    struct bench b;
    bench_open(&b, false);
    b.session->front.time_shown = newest_part;
    const struct view *view = &b.session->view;
    type_ok(&b, "run 20 s; pan -2 s");
    assert_true(view->x[0] == 13 && view->x[1] == 19);
    type_ok(&b, "range x auto; zoom 2");
    assert_true(view->x[0] == 16.5 && view->x[1] == 19.5);
    type_ok(&b, "zoom 0.1"); /* automatic would not show all of it */
    assert_true(view->x[0] == 0 && view->x[1] == 20);
    type_ok(&b, "focus phase; zoom 2"); /* the time axis beside it */
    assert_true(view_focus(view) == PLOT_POSITION && view->x[0] == 16.5);
    bench_close(&b);
}

TEST(ranges_zoom_and_pan)
{
    struct bench b;
    bench_open(&b, false);
    const struct view *view = &b.session->view;
    assert_true(isnan(view->x[0]) && isnan(view->y[1]) && view->trail == 2 && view->paging);
    type_ok(&b, "run 8 s; zoom 2");
    assert_true(view->x[0] == 2 && view->x[1] == 6);
    type_ok(&b, "pan 1 s");
    assert_true(view->x[0] == 3 && view->x[1] == 7);
    type_ok(&b, "pan 5 s"); /* stops at the end */
    assert_true(view->x[0] == 4 && view->x[1] == 8);
    type_ok(&b, "pan -20 s");
    assert_true(view->x[0] == 0 && view->x[1] == 4);
    type_ok(&b, "zoom 0.1");
    assert_true(isnan(view->x[0]));
    type_ok(&b, "window 2 s; zoom 2");
    assert_true(view->x[0] == 6.5 && view->x[1] == 7.5);
    for (int i = 0; i < 60; i++)
        type_ok(&b, "zoom 10");
    assert_true(view->x[1] > view->x[0]);
    type_ok(&b, "range y -5cm:5 cm");
    assert_true(view->y[0] == -0.05 && view->y[1] == 0.05);
    type_ok(&b, "focus energy"); /* its axes are others */
    assert_true(isnan(view->x[0]) && isnan(view->y[0]));
    type_ok(&b, "focus phase full");
    assert_true(view->full && view_focus(view) == PLOT_PHASE);
    assert_false(type(&b, "zoom 2"));
    assert_says(&b.err, "no time axis");
    type_ok(&b, "set view scroll");
    assert_false(view->paging);
    assert_true(b.session->undo.undos == 1); /* run: the screen is not undone */
    bench_close(&b);
}

TEST(offered_panes)
{
    struct bench b;
    bench_open(&b, false);
    static const struct {
        const char *line, *offered;
    } steps[] = {{"echo", ""},
                 {"C = 10; run 1 s", "peuvsanT"},
                 {"C = 0; run 1 s", "peuvxsanT"},
                 {"load swing.txt; cursor off", "peuvxrsanT"},
                 {"data window 2:4", "peuvxsanT"},
                 {"drop all", "peuvsnT"}}; /* velocity and energy of a recording */
    static const struct {
        char letter;
        const char *name;
    } panes[] = {{'p', "position"},     {'e', "energy"},   {'u', "phase"},    {'v', "velocity"},
                 {'x', "error"},        {'r', "residual"}, {'s', "spectrum"}, {'o', "orbit"},
                 {'a', "acceleration"}, {'n', "envelope"}, {'T', "period"},   {'q', "precision"}};
    struct buffer text = {0};
    buffer_put(&text, TEXT("t\ty\ns\tcm\n"));
    for (int i = 0; i < 200; i++)
        buffer_format(&text, "%.2f\t%.3f\n", 0.02 * i, sin(0.3 * i));
    write_file("swing.txt", text.data, text.len);
    buffer_free(&text);
    for (size_t i = 0; i < COUNT_OF(steps); i++) {
        char now[16];
        size_t n = 0;
        type_ok(&b, steps[i].line);
        for (size_t p = 0; p < COUNT_OF(panes); p++) {
            const struct row *row = catalog_find(&plot_catalog, text_of(panes[p].name));
            if (row && plot_offered(b.session, (enum plot_kind)catalog_index(&plot_catalog, row)))
                now[n++] = panes[p].letter;
        }
        now[n] = 0;
        assert_string_equal(now, steps[i].offered);
    }
    bench_close(&b);
}

TEST(scrolling)
{
    struct bench b;
    bench_open(&b, false);
    for (int i = 0; i < 50; i++)
        log_add(&b.session->log, TEXT("line"));
    type_ok(&b, "scroll 10");
    assert_int_equal(b.session->view.scroll, 10);
    type_ok(&b, "scroll -3");
    assert_int_equal(b.session->view.scroll, 7);
    type_ok(&b, "scroll home");
    assert_int_equal(b.session->view.scroll, 49);
    log_add(&b.session->log, TEXT("a line that has more to say than the eighty columns of a usual "
                                  "screen can show at once"));
    type_ok(&b, "scroll home"); /* rows, not lines */
    assert_int_equal(b.session->view.scroll, 51);
    type_ok(&b, "scroll -1000");
    assert_int_equal(b.session->view.scroll, 0);
    bench_close(&b);
}

struct drawn {
    struct bench bench;
    char path[64];
    struct write_policy policy;
    enum front_change change;
};

static bool draw_file(void *context, const struct session *session, const char *path,
                      struct write_policy policy, struct error *error)
{
    struct drawn *d = context;
    (void)session;
    snprintf(d->path, sizeof d->path, "%s", path);
    d->policy = policy;
    return policy.force || error_set(error, ERROR_IO, "%s exists", path);
}

static bool draw_text(void *context, const struct session *session, struct buffer *text,
                      struct error *error)
{
    (void)context;
    (void)session;
    (void)error;
    buffer_put(text, TEXT("the screen\n"));
    return true;
}

static bool change_front(void *context, enum front_change change, struct error *error)
{
    ((struct drawn *)context)->change = change;
    return change != FRONT_PANES || error_set(error, ERROR_COMMAND, "too small");
}

TEST(front_end_requests)
{
    struct drawn d = {.change = FRONT_PANES};
    bench_open(&d.bench, false);
    assert_false(type(&d.bench, "screenshot"));
    assert_false(type(&d.bench, "screenshot x.txt"));
    assert_false(type(&d.bench, "panes"));
    type_ok(&d.bench, "redraw");
    struct front *front = &d.bench.session->front;
    front->context = &d;
    front->screenshot = draw_file;
    front->screen = draw_text;
    front->change = change_front;
    assert_false(type(&d.bench, "screenshot x.txt"));
    assert_says(&d.bench.err, "x.txt exists");
    assert_int_equal(d.bench.session->execution.status, ERROR_COMMAND); /* of the first refusal */
    type_ok(&d.bench, "screenshot 'a b.txt' --force");
    assert_string_equal(d.path, "a b.txt");
    assert_true(d.policy.force && !d.policy.confine);
    type_ok(&d.bench, "screenshot");
    assert_string_equal(said(&d.bench.out), "the screen\n");
    type_ok(&d.bench, "plain");
    assert_int_equal(d.change, FRONT_PLAIN);
    assert_false(type(&d.bench, "panes"));
    assert_says(&d.bench.err, "too small");
    bench_close(&d.bench);
}

RUN_TESTS(enter_folder, leave_folder)
