/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The screen: sizes, layouts, what gives way, what the lines say. */
#include "long_form.h"
#include <hooke/language.h>
#include <hooke/plot.h>
#include "unit/view/testing.h"

TEST(every_size_can_be_drawn)
{
    static const int widths[] = {1,  2,  3,  7,  8,  9,   13,  20,  24,  39,
                                 40, 59, 60, 61, 80, 109, 110, 120, 200, 300};
    static const int heights[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                  11, 12, 13, 16, 24, 35, 36, 40, 60, 100};
    (void)state;
    for (int utf8 = 0; utf8 < 2; utf8++) {
        struct session *session = begin(utf8, swing);
        tell(session, "run 30 s");
        session->view.cursors.cursor[0].set = session->view.cursors.cursor[1].set = true;
        session->view.cursors.cursor[0].t = 25;
        session->view.cursors.cursor[1].t = 29;
        session->live.marks[session->live.mark_count++] = 27;
        for (size_t layout = 0; layout < layout_catalog.count; layout++) {
            session->view.layout = (enum layout)layout;
            session->view.cursors.shown = layout % 2;
            for (size_t w = 0; w < COUNT_OF(widths); w++) {
                for (size_t h = 0; h < COUNT_OF(heights); h++) {
                    if (!is_long() && (w + h + layout + (size_t)utf8) % 3 != 0)
                        continue;
                    struct canvas canvas;
                    struct prompt_line prompt = typed("set dt 5 ms");
                    int x = -1, y = -1;
                    assert_true(canvas_init(&canvas, widths[w], heights[h]));
                    assert_true(screen_draw(session, &prompt, &canvas, &x, &y));
                    assert_int_equal(y, heights[h] - 1);
                    assert_in_range(x, 0, widths[w] - 1);
                    canvas_free(&canvas);
                    assert_in_range(screen_log_rows(session, widths[w], heights[h]), 0, heights[h]);
                    assert_true(screen_column_time(session, widths[w], heights[h]) >= 0);
                }
            }
        }
        session_destroy(session);
    }
}

/* In this order: numbers line, second pane, log but one row, labels, frame; at last only the prompt
 * is left. */
TEST(parts_give_way_in_order)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    assert_shows(session, 80, 24, "E bal=");
    assert_shows(session, 80, 24, "energy [mJ]");
    assert_shows(session, 80, 24, "phase v/omega0 [cm]");
    assert_int_equal(screen_log_rows(session, 80, 24), 6);
    assert_shows(session, 40, 12, "E bal=");
    assert_hides(session, 40, 12, "phase");
    assert_shows(session, 40, 12, "t [s]");
    assert_int_equal(screen_log_rows(session, 40, 12), 1);
    assert_hides(session, 40, 11, "E bal=");
    assert_shows(session, 40, 10, " 7     8 "); /* under the axis */
    assert_hides(session, 40, 9, " 7     8 ");
    assert_shows(session, 40, 9, "+- y [cm]");
    assert_hides(session, 40, 6, "+- y [cm]");
    assert_shows(session, 40, 6, "verlet");
    assert_int_equal(screen_log_rows(session, 20, 6), 1);
    char *row = print_row(session, 40, 1, 0);
    assert_string_equal(row, "hooke>");
    free(row);
    session_destroy(session);
}

TEST(layouts_have_their_panes)
{
    static const struct {
        enum layout layout;
        const char *has, *lacks;
    } cases[] = {
        {LAYOUT_TRIO, "energy [mJ]", "v [cm/s]"}, {LAYOUT_DUO, "phase", "energy [mJ]"},
        {LAYOUT_SINGLE, "- y [cm] -", "phase"},   {LAYOUT_STACK, "v [cm/s]", "phase"},
        {LAYOUT_QUAD, "4 energy [mJ]", "- 5 "},   {LAYOUT_PLOT, "- y [cm] -", "run 9.6"},
        {LAYOUT_LOG, "960 steps", "y [cm]"},
    };
    (void)state;
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        session->view.layout = cases[i].layout;
        assert_shows(session, 120, 40, cases[i].has);
        assert_hides(session, 120, 40, cases[i].lacks);
    }
    session->view.layout = LAYOUT_QUAD; /* too small for it */
    assert_hides(session, 100, 30, "4 energy");
    assert_shows(session, 100, 30, "phase");
    session_destroy(session);
}

/* Whatever pane has the focus is on the screen, and alone on it when it is asked for full. */
TEST(the_focused_pane_is_shown)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    for (size_t i = 0; i < plot_catalog.count; i++) {
        static const char *const title[] = {
            [PLOT_POSITION] = "- y [", [PLOT_ENERGY] = "- energy [", [PLOT_PHASE] = "- phase ",
            [PLOT_VELOCITY] = "- v [", [PLOT_ERROR] = "- error [",   [PLOT_ORBIT] = "- orbit "};
        const struct plot_row *row = plot_row((enum plot_kind)i);
        char its[64];
        snprintf(its, sizeof its, "- %s",
                 i < COUNT_OF(title) ? title[i] + 2
                 : row->title        ? row->title
                                     : row->label);
        view_focus_on(&session->view, (enum plot_kind)i);
        session->view.full = false;
        bool offered = plot_offered(session, (enum plot_kind)i);
        assert_int_equal(shows(session, 80, 24, its), offered);
        session->view.full = true;
        assert_int_equal(shows(session, 80, 24, its), offered);
        if (offered && i != PLOT_PHASE)
            assert_hides(session, 80, 24, "phase");
    }
    session_destroy(session);
}

TEST(drawing_changes_nothing)
{
    struct session *session = begin(true, swing);
    tell(session, "run 9.6 s");
    struct session before = *session;
    char *first = print(session, 80, 24), *second = print(session, 80, 24);
    assert_string_equal(first, second);
    assert_memory_equal(&before, session, sizeof before);
    free(first);
    free(second);
    session_destroy(session);
}

TEST(the_state_line_says_what_goes_on)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    char *row = print_row(session, 80, 24, 0);
    assert_string_equal(
        row, " spring  m=200 g  k=2.1 N/m  gamma=0.07 | verlet dt=10 ms | t=9.60 s  960 steps");
    free(row);
    session->live.state = LIVE_PAUSED;
    row = print_row(session, 80, 24, 0);
    assert_string_equal(
        row, " spring  m=200 g  k=2.1 N/m  gamma=0.07 | verlet dt=10 ms | PAUSED t=9.60 s");
    free(row);
    row = print_row(session, 40, 12, 0);
    assert_string_equal(row, "spring verlet dt=10ms PAUSED t=9.60");
    free(row);
    session->live.state = LIVE_RUNNING;
    session->live.speed = session->live.achieved = 1;
    assert_shows(session, 80, 24, "RUNNING 1.0x");
    session->live.achieved = 0.4;
    assert_shows(session, 80, 24, "RUNNING 0.4x (CPU)");
    session->live.state = LIVE_DIVERGED;
    assert_shows(session, 80, 24, "DIVERGED");
    session_destroy(session);
}

TEST(a_conservative_run_has_no_balance)
{
    struct session *session = begin(false, "gamma = 0; method euler");
    assert_hides(session, 80, 24, "dE/E0");
    tell(session, "run 1 s");
    assert_shows(session, 80, 24, "  dE/E0=+1.1e0 ");
    assert_hides(session, 80, 24, "E bal");
    session_destroy(session);
}

TEST(a_hint_takes_the_numbers_line)
{
    struct session *session = begin(false, NULL);
    struct prompt_line prompt = typed("");
    struct canvas canvas;
    struct buffer text = {0};
    prompt.hint = TEXT("cursor keys: q leaves");
    assert_true(canvas_init(&canvas, 80, 24));
    assert_true(screen_draw(session, &prompt, &canvas, NULL, NULL));
    canvas_print(&canvas, false, &text);
    assert_non_null(strstr(text.data, "-- cursor keys: q leaves ---"));
    assert_null(strstr(text.data, "F1 help"));
    buffer_free(&text);
    canvas_free(&canvas);
    session_destroy(session);
}

TEST(the_log_scrolls)
{
    struct session *session = begin(true, NULL);
    for (int i = 1; i <= 20; i++) {
        char line[120];
        snprintf(line, sizeof line, "line %d.%s", i,
                 i == 20 ? " is one that is longer than the eighty columns that the screen has, "
                           "and so it goes on"
                         : "");
        log_add(&session->log, text_of(line));
    }
    assert_shows(session, 80, 24, "line 16.");
    assert_hides(session, 80, 24, "line 15.");
    assert_shows(session, 80, 24,
                 "line 20. is one that is longer than the eighty columns that the screen has, and\n"
                 "  so it goes on\n");
    /* one row only */
    assert_shows(session, 40, 12, "line 20. is one that is longer than \xE2\x80\xA6");
    session->view.scroll = 1;
    assert_hides(session, 80, 24, "so it goes on");
    assert_shows(session, 80, 24, "line 20. is one");
    assert_shows(session, 80, 24, "line 15.");
    assert_hides(session, 80, 24, "line 14.");
    session->view.scroll = 4;
    assert_hides(session, 80, 24, "line 18.");
    assert_shows(session, 80, 24, "line 12.");
    session->view.scroll = 1000; /* the oldest stays at the top */
    assert_shows(session, 80, 24, "line 1.");
    assert_shows(session, 80, 24, "line 6.");
    /* one line has two rows */
    assert_int_equal(screen_log_max(session, 80, 24), 21 - screen_log_rows(session, 80, 24));
    session->view.scroll = screen_log_max(session, 80, 24);
    assert_shows(session, 80, 24, "line 1.");
    session->view.scroll--;
    assert_hides(session, 80, 24, "line 1.");
    assert_int_equal(screen_log_max(session, 80, 60), 21 - screen_log_rows(session, 80, 60));
    log_clear(&session->log);
    assert_int_equal(screen_log_max(session, 80, 24), 0);
    session->view.cursors.shown = true; /* their table gives way to the log */
    assert_int_equal(screen_log_max(session, 80, 24), 1);
    session_destroy(session);
}

/* A method or a step chosen after the run are those of the next one. */
TEST(the_state_line_names_what_the_curve_was_computed_with)
{
    struct session *session = begin(true, "method euler; run 4 s; method verlet");
    assert_shows(session, 80, 24, "| euler dt=10 ms, next verlet | t=4.00 s");
    tell(session, "dt = 5 ms");
    assert_shows(session, 80, 24, "| euler dt=10 ms, next verlet dt=5 ms | t=4.00 s");
    tell(session, "run 4 s");
    assert_shows(session, 80, 24, "| verlet dt=5 ms | t=4.000 s");
    session_destroy(session);
}

/* What 'layout' says is drawn is drawn, from the size on that it names. */
TEST(a_layout_needs_the_size_that_is_said)
{
    struct session *session = begin(true, "run 4 s; layout quad; clear");
    assert_shows(session, 110, 36, "4 energy");
    assert_hides(session, 109, 36, "4 energy");
    assert_hides(session, 110, 35, "4 energy");
    session_destroy(session);
}

RUN_TESTS(NULL, NULL)
