/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every command that has a short form answers in one screen with its messages: 22 rows of 80
 * columns, studies also 12 of 40, and none of their lines is wider. --full and records leave
 * nothing out. A command without a line here fails.
 */
#include <hooke/base/safe_text.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"

struct screen_size {
    int width, height, rows_max; /* [cell, row], rows of an answer [row] */
};
static const struct screen_size usual = {80, 24, 22}, small = {40, 12, 12};

struct answer {
    const char *before, *line; /* only what the line says is measured */
};

static const struct answer studies[] = {
    {"scene spring", "precision"},
    {"scene spring; precision verlet rk4", "precision table"},
    {"scene spring; precision rk4 pefrl", "precision table pefrl"},
    {"", "stress exact"},
    {"", "stress case=orego"},
    {"scene pendulum", "stress scene rk4 dop853"},
    {"", "selftest"},
    {"scene spring", "order rk4"},
    {"scene kepler; duration = 3 s", "order dop853"},
    {"scene spring", "taylor euler"},
    {"scene pendulum", "stability rk4"},
    {"scene spring", "stability nystrom4"},
    {"scene spring", "stability euler midpoint heun rk4 verlet"},
    {"scene spring", "compare euler verlet rk4 dop853 radau5 gauss6"},
    {"scene spring", "compare euler heun midpoint rk4 verlet dt=1ms,2ms,5ms,10ms,20ms"},
    {"scene drag; method verlet; run 60 s", "fit drag"},
    {"scene drag; method verlet; run 60 s", "fit damped"},
    {"scene elastic-pendulum; method dop853; run 60 s", "fit modes 4"},
    {"scene driven; method rk4", "sweep omega=6:12:0.1"},
    {"scene driven; method rk4", "sweep omega=6:12:1 measure=amplitude,period,max,min"},
    {"scene driven; method rk4", "sweep omega=6:12:0.5 gamma=0.1:2:0.1"},
    {"scene driven; method rk4", "sweep omega=6:12:0.5 gamma=0.1:2:0.1 measure=amplitude,max"},
    {"scene driven; method rk4", "sweep omega=6:12:3"},
    {"scene pendulum-driven; method rk4", "sweep F0=1.3:1.6:0.01 at period skip=10 keep=20"},
    {"scene driven; duration = 20 s", "lyapunov over 200 s"},
    {"scene spring; method rk4; run 100 s", "lyapunov of y"},
    {"scene duffing-driven", "equilibria"},
    {"var x = 1; x' = sin(20*x)", "equilibria x=-5:5"},
    {"scene duffing-driven", "branch omega=0.9:1.6 of response"},
    {"var x = 0.1; var y = 0; param r = 0; x' = r*x-y-x^3; y' = x+r*y-y^3; equilibria x=-1:1 "
     "y=-1:1",
     "branch r=-1:1"},
    {"scene vanderpol", "orbit"},
    {"var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v", "basins x=-2:2:0.1 v=-2:2:0.1"},
    {"scene damped; method verlet; run 20 s", "measure spectrum"},
    {"scene damped; method verlet; run 100 s", "measure amplitude windows=40"},
    {"scene damped; method verlet; run 20 s", "measure period"},
    {"", "help"},
    {"scene spring; method verlet; run 2 s", "report answers-report --force"},
};

/* In the long form, too. */
static const struct answer slow[] = {
    {"", "stress"},
    {"scene drag", "precision"},
    {"timing off; scene kepler; duration = 5 s", "precision"},
    {"", "stress scene"},
    {"scene pendulum", "precision"},
    {"scene pendulum", "stress scene"},
};

static bool has_option(const struct command *command, const char *name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == FORM_OPTION &&
            strcmp(command->argument[i].name, name) == 0)
            return true;
    return false;
}

static bool is_study(const char *line)
{
    const struct row *row = catalog_find(&command_catalog, peek_word(text_of(line), ""));
    return row && strcmp(command_at(row)->group, "STUDY") == 0;
}

/* Counts the rows of the text, and sets *wraps if a line is wider than the screen. */
static int rows_on(const struct buffer *buffer, int width, bool *wraps)
{
    struct text rest = buffer_text(buffer), line;
    int rows = 0;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const int cells = text_width(line);
        rows += cells > width ? (cells + width - 1) / width : 1;
        *wraps |= cells > width;
    }
    return rows;
}

static int rows_of(const struct buffer *buffer)
{
    bool ignored = false;
    return rows_on(buffer, usual.width, &ignored);
}

static void open_screen(struct bench *bench, const struct screen_size *size)
{
    bench_open(bench, false);
    session_destroy(bench->session);
    bench->session = session_create(&(struct front){
        .width = size->width, .height = size->height, .utf8 = true, .is_terminal = true});
    assert_non_null(bench->session);
}

static bool fits(const struct answer *answer, const struct screen_size *size)
{
    struct bench bench;
    bool wraps = false;
    if (is_left_out(answer->before) || is_left_out(answer->line))
        return true;
    open_screen(&bench, size);
    assert_true(type(&bench, answer->before));
    if (!type(&bench, answer->line))
        fail_msg("%s: %s: %s", answer->before, answer->line, buffer_view(&bench.err));
    bool message_wraps = false;
    const int rows =
        rows_on(&bench.out, size->width, &wraps) + rows_on(&bench.err, size->width, &message_wraps);
    const bool ok =
        rows <= size->rows_max && !(wraps && is_study(answer->line)) && bench.out.len > 0;
    if (!ok)
        print_message("%dx%d: %s: %s: %d rows%s\n%s%s", size->width, size->height, answer->before,
                      answer->line, rows, wraps ? ", wraps" : "", buffer_view(&bench.out),
                      buffer_view(&bench.err));
    bench_close(&bench);
    return ok;
}

TEST(every_study_answers_in_one_screen)
{
    int too_long = 0;
    for (size_t i = 0; i < COUNT_OF(studies); i++)
        too_long +=
            !fits(&studies[i], &usual) + (is_study(studies[i].line) && !fits(&studies[i], &small));
    for (size_t i = 0; i < COUNT_OF(slow) && is_long(); i++)
        too_long += !fits(&slow[i], &usual);
    assert_int_equal(too_long, 0);
}

TEST(every_command_with_a_short_form_is_measured)
{
    int studied = 0;
    for (size_t c = 0; c < command_catalog.count; c++) {
        const struct command *command =
            (const struct command *)(const void *)catalog_row(&command_catalog, c);
        const bool study = strcmp(command->group, "STUDY") == 0;
        bool measured = false;
        if (!study && (!has_option(command, "full") || has_option(command, "log")))
            continue;
        for (size_t i = 0; i < COUNT_OF(studies) && !measured; i++)
            measured = text_is(peek_word(text_of(studies[i].line), ""), command->row.name);
        if (!measured)
            fail_msg("no line measures '%s'", command->row.name);
        studied++;
    }
    assert_true(module_left_out[0] || studied >= 13);
}

/* The rows that are left out are counted, and come back with --full. */
TEST(full_leaves_nothing_out)
{
    static const char *const lines[] = {"order rk4", "stress case=orego", "equilibria x=-5:5",
                                        "sweep x0=0:1:0.02 measure=max"};
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        struct bench bench;
        struct buffer line = {0};
        int brief;
        if (is_left_out(lines[i]))
            continue;
        open_screen(&bench, &usual);
        assert_true(type(&bench, "timing off; method rk4; var x = 1; x' = sin(20*x)"));
        assert_true(type(&bench, lines[i]));
        brief = rows_of(&bench.out);
        buffer_format(&line, "%s --full", lines[i]);
        assert_true(type(&bench, buffer_view(&line)));
        assert_null(memmem(bench.out.data, bench.out.len, "--full", 6));
        if (rows_of(&bench.out) < brief)
            fail_msg("%s: %d rows, %d with --full", lines[i], brief, rows_of(&bench.out));
        buffer_free(&line);
        bench_close(&bench);
    }
}

/* What stands in the middle is replaced; the heading, the first rows and the last ones stay. */
TEST(the_middle_is_left_out)
{
    struct bench bench;
    struct buffer full = {0};
    open_screen(&bench, &usual);
    assert_true(type(&bench, "timing off; var x = 1; x' = sin(20*x)"));
    assert_true(type(&bench, "equilibria x=-5:5 --full"));
    buffer_put(&full, buffer_text(&bench.out));
    assert_true(type(&bench, "equilibria x=-5:5"));
    struct text rest = buffer_text(&bench.out), line;
    int shown = 0, left_out = 0;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        if (sscanf(line.data, "... %d more rows: --full", &left_out) == 1)
            continue;
        shown++;
    }
    assert_true(left_out > 0);
    assert_int_equal(rows_of(&bench.out), usual.rows_max);
    buffer_free(&full);
    bench_close(&bench);
}

static int lines_of(const struct buffer *buffer)
{
    int lines = 0;
    for (size_t i = 0; i < buffer->len; i++)
        lines += buffer->data[i] == '\n';
    return lines;
}

TEST(records_are_whole)
{
    static const char *const form[] = {"csv", "json"};
    static const char *const line[] = {"sweep x0=0:1:0.02 measure=max",
                                       "sweep x0=0:1:0.02 measure=max --full"};
    if (is_left_out(line[0]))
        return;
    for (size_t i = 0; i < COUNT_OF(form); i++) {
        int lines[2];
        for (int full = 0; full < 2; full++) {
            struct bench bench;
            struct buffer begin = {0};
            open_screen(&bench, &usual);
            buffer_format(&begin, "method rk4; var x = 1; x' = sin(20*x); set format %s", form[i]);
            assert_true(type(&bench, buffer_view(&begin)));
            assert_true(type(&bench, line[full]));
            lines[full] = lines_of(&bench.out);
            buffer_free(&begin);
            bench_close(&bench);
        }
        assert_int_equal(lines[0], lines[1]);
        assert_true(lines[0] >= 51);
    }
}

RUN_TESTS(NULL, NULL)
