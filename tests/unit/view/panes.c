/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Panes: which part of the time, how little a live frame changes, cursors and marks, the figures
 * behind them. */
#include <hooke/run.h>
#include <hooke/plot.h>
#include "unit/view/testing.h"

#include <unistd.h>

static struct session *live_session(bool utf8, const char *setup, const char *run)
{
    struct session *session = begin(utf8, setup);
    tell(session, run);
    session->view.paging = true;
    session->live.state = LIVE_RUNNING;
    session->live.speed = session->live.achieved = 1;
    return session;
}

static int changed_cells(const struct canvas *a, const struct canvas *b)
{
    int changed = 0;
    for (int i = 0; i < a->width * a->height; i++)
        changed +=
            a->cell[i].codepoint != b->cell[i].codepoint || a->cell[i].style != b->cell[i].style;
    return changed;
}

/* Steps of a tenth of a second; returns the mean number of cells that change, *most the largest. */
static double mean_change(struct session *session, int frames, int *max)
{
    struct canvas before = draw(session, 80, 24);
    int sum = 0;
    *max = 0;
    for (int i = 0; i < frames; i++) {
        struct run *run = current(session);
        run_advance(run, &(struct run_target){.t = run->t + 0.1, .steps = -1}, 0, NULL);
        struct canvas after = draw(session, 80, 24);
        int changed = changed_cells(&before, &after);
        sum += changed;
        *max = changed > *max ? changed : *max;
        canvas_free(&before);
        before = after;
    }
    canvas_free(&before);
    return (double)sum / frames;
}

/* A planned run sweeps over fixed axes: the curve's end, the point of the phase plot with the end
 * of its trail, and some digits. */
TEST(a_sweep_changes_few_cells)
{
    for (int utf8 = 0; utf8 < 2; utf8++) {
        struct session *session = live_session(utf8, swing, "run 9 s");
        int max;
        run_back(current(session), 890);
        assert_true(mean_change(session, 85, &max) < 20);
        assert_in_range(max, 3, 40);
        session_destroy(session);
    }
}

/* Beyond the window pages turn by a quarter of it: between the turns as little changes as before.
 */
TEST(pages_turn_rarely)
{
    struct session *session = live_session(true, swing, "run 1 s");
    session->view.window = 8;
    struct run *run = current(session);
    run_advance(run, &(struct run_target){.t = 20, .steps = -1}, 0, NULL);
    struct canvas before = draw(session, 80, 24);
    int turns = 0;
    for (int i = 0; i < 100; i++) {
        run_advance(run, &(struct run_target){.t = run->t + 0.1, .steps = -1}, 0, NULL);
        struct canvas after = draw(session, 80, 24);
        turns += changed_cells(&before, &after) > 50;
        canvas_free(&before);
        before = after;
    }
    canvas_free(&before);
    assert_int_equal(turns, 5); /* 10 s of 2 s each */
    session_destroy(session);
}

TEST(an_axis_reaches_to_the_planned_end)
{
    struct session *session = live_session(false, swing, "run 20 s");
    run_back(current(session), 1990);
    session->view.window = 100;
    session->view.full = true;
    double planned = screen_column_time(session, 80, 24);
    session->live.state = LIVE_IDLE;
    session->view.window = 0;
    double idle = screen_column_time(session, 80, 24);
    assert_true(planned > 10 * idle);
    session_destroy(session);
}

/* Of a run that goes backwards the earliest times are new; the mark of the present is on it. */
TEST(the_newest_part_may_be_the_earliest)
{
    struct session *session = begin(false, swing);
    tell(session, "run -60 s");
    assert_shows(session, 80, 24, "last 8 of 60 s");
    assert_shows(session, 80, 24, " -60 ");
    double shown[2];
    assert_true(screen_time_shown(session, 80, 24, shown));
    assert_true(shown[0] == -60 && shown[1] > -53 && shown[1] < -51);
    session_destroy(session);
}

/* Nothing is added to a recording: it is there from beginning to end, unless a window is asked for.
 */
TEST(a_recording_alone_is_whole)
{
    struct session *session = begin(false, NULL);
    char name[] = "/tmp/hooke-panes-XXXXXX", line[80];
    const int file = mkstemp(name);
    FILE *out = file < 0 ? NULL : fdopen(file, "w");
    assert_non_null(out);
    fprintf(out, "Time (s)\tDistance (cm)\n");
    for (int i = 0; i < 4000; i++)
        fprintf(out, "%.2f\t%.3f\n", 0.02 * i, 20 + 5 * cos(0.16 * i));
    assert_int_equal(fclose(out), 0);
    snprintf(line, sizeof line, "load %s", name);
    tell(session, line);
    assert_int_equal(unlink(name), 0);
    double shown[2];
    assert_true(screen_time_shown(session, 80, 24, shown));
    assert_true(shown[0] == 0 && shown[1] >= 79.98);
    tell(session, "window 5 s");
    assert_shows(session, 80, 24, "last 5 of 79.98 s");
    session_destroy(session);
}

TEST(the_window_is_the_newest_part)
{
    struct session *session = begin(false, swing);
    tell(session, "run 60 s");
    session->view.paging = true;
    assert_shows(session, 80, 24, "last 8 of 60 s");
    view_focus_on(&session->view, PLOT_ENERGY); /* alone it can be seen from beginning to end */
    session->view.full = true;
    assert_hides(session, 80, 24, "last ");
    assert_shows(session, 80, 24, " 60 ");
    view_focus_on(&session->view, PLOT_POSITION);
    assert_shows(session, 80, 24, "last 16 of 60 s");
    session->view.full = false;
    session->view.window = 4;
    assert_shows(session, 80, 24, "last 4 of 60 s");
    assert_shows(session, 80, 24, " 59 ");
    double shown[2];
    assert_true(screen_time_shown(session, 80, 24, shown)); /* what zoom and pan start from */
    assert_true(shown[0] >= 56 && shown[0] <= 57 && shown[1] >= 60 && shown[1] < 62);
    session->view.window = 0;
    session->view.x[0] = 10;
    session->view.x[1] = 14;
    assert_hides(session, 80, 24, "last 8");
    assert_shows(session, 80, 24, " 12 ");
    assert_hides(session, 80, 24, " 59 ");
    session->view.trail = 3;
    session->view.x[0] = session->view.x[1] = NAN;
    assert_shows(session, 80, 24, "last 3 T");
    session->view.trail = HUGE_VAL;
    assert_hides(session, 80, 24, " T ");
    session_destroy(session);
}

TEST(the_vertical_range_of_the_focus_can_be_fixed)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    session->view.y[0] = -0.4;
    session->view.y[1] = 0.4;
    view_focus_on(&session->view, PLOT_POSITION);
    assert_shows(session, 80, 24, " 40+");
    view_focus_on(&session->view, PLOT_ENERGY);
    assert_hides(session, 80, 24, " 40+");
    /* no time: the other panes stay as they are */
    tell(session, "focus phase; range x -60 cm:60 cm; range y auto");
    assert_shows(session, 80, 24, "|  60+");
    assert_shows(session, 80, 24, " 10 |");
    tell(session, "focus position; range x 2 s:4 s");
    assert_hides(session, 80, 24, " 10 |");
    assert_shows(session, 80, 24, " 3.5 ");
    session_destroy(session);
}

static void set_cursors(struct session *session)
{
    struct cursors *cursors = &session->view.cursors;
    cursors->shown = true;
    cursors->cursor[0].set = cursors->cursor[1].set = true;
    cursors->cursor[0].t = 1.4530;
    cursors->cursor[1].t = 9.2022;
    cursors->cursor[0].t_uncertainty = cursors->cursor[1].t_uncertainty = 4e-4;
    cursors->cursor[0].amplitude = 0.04;
    cursors->cursor[1].amplitude = 0.04 * exp(-0.035 * (9.2022 - 1.4530));
    cursors->quantity = QUANTITY_LENGTH;
    cursors->cursor[0].crossing = 1;
    cursors->cursor[1].crossing = 5;
    cursors->periods = 4;
}

TEST(cursors_stand_in_frame_and_table)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    set_cursors(session);
    assert_shows(session, 80, 24, "[cm] -A---");
    assert_shows(session, 80, 24, ">A  t = 1.4530(4) s   y = 0.00 ");
    assert_shows(session, 80, 24, " B  t = 9.2022(4) s");
    assert_shows(session, 80, 24, "up-crossing #5");
    assert_shows(session, 80, 24,
                 " B-A = 7.7492 s / 4 periods   T = 1.9373(1) s   f = 0.51618(4) Hz");
    assert_shows(session, 80, 24,
                 " theory T_d = 1.9391 s  (T-T_d)/T_d = -0.095 %   log decrement 0.0678  Q = 46.3");
    assert_shows(session, 80, 24, "Enter keep as measurement");
    assert_shows(session, 40, 12, "B-A = 7.7492 s / 4 periods"); /* one row: the result */
    assert_hides(session, 40, 12, "Enter");
    session->view.cursors.active = 1;
    assert_shows(session, 80, 24, ">B  t = 9.2022(4) s");
    session->view.cursors.shown = false;
    assert_hides(session, 80, 24, "B-A");
    assert_hides(session, 80, 24, "A---");
    session_destroy(session);
}

TEST(changed_parameters_are_marked_on_the_axis)
{
    struct session *session = begin(false, swing);
    tell(session, "run 9.6 s");
    assert_hides(session, 80, 24, "^");
    session->live.marks[session->live.mark_count++] = 3.3;
    assert_shows(session, 80, 24, "-^-");
    session->live.marks[0] = 100;
    assert_hides(session, 80, 24, "^");
    session_destroy(session);
}

/* A run at its very start, with one row, and one step later. */
TEST(one_row_is_enough)
{
    struct session *session = begin(false, swing);
    tell(session, "run 1 s");
    run_back(current(session), INT64_MAX);
    assert_int_equal(trace_count(current(session)->trace), 1);
    assert_shows(session, 80, 24, "y [cm]");
    tell(session, "step");
    assert_shows(session, 80, 24, "y [cm]");
    session_destroy(session);
}

/* ---- figures ---- */

static enum plot_kind plot_named(const char *name)
{
    return (enum plot_kind)catalog_index(&plot_catalog, catalog_find(&plot_catalog, text_of(name)));
}

static struct figure figure_of(const struct session *session, enum plot_kind kind, bool follow,
                               struct arena *arena)
{
    struct figure_request request = {.kind = kind,
                                     .run = &session->runs.current,
                                     .runs = 1,
                                     .recording = figure_recording(session, kind),
                                     .window = {follow ? NAN : 0, NAN},
                                     .width = 60,
                                     .charset = &charset_braille,
                                     .follow = follow,
                                     .pages = 4,
                                     .span = follow ? 1000 : 0,
                                     .t_end = NAN};
    struct figure figure;
    struct error error;
    if (!session_figure(session, &request, arena, &figure, &error))
        fail_msg("%s", error.text);
    return figure;
}

static double largest(const double *y, size_t n)
{
    double max = 0;
    for (size_t i = 0; i < n; i++)
        max = fmax(max, fabs(y[i]));
    return max;
}

static const struct observable *observable(const char *name)
{
    return observable_by_name(text_of(name));
}

/* Of a hundred thousand rows a screen draws few, each with the value it has in the whole column,
 * and the extremes are among them. */
TEST(few_rows_stand_for_many)
{
    static const struct {
        enum plot_kind kind;
        const char *name;
    } cases[] = {
        {PLOT_POSITION, "y"}, {PLOT_VELOCITY, "v"}, {PLOT_ENERGY, "energy"}, {PLOT_ERROR, "error"}};
    (void)state;
    struct session *session = begin(false, "k = 2.1 N/m; y0 = 4.2 cm; method euler; dt = 1 ms");
    tell(session, "run 100 s");
    const struct run *run = current(session);
    size_t n = trace_count(run->trace);
    double *column = calloc(n, sizeof *column);
    assert_non_null(column);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        for (int follow = 0; follow < 2; follow++) {
            struct arena arena = {0};
            struct error error;
            struct figure figure = figure_of(session, cases[i].kind, follow, &arena);
            const struct curve *curve = &figure.curve[0];
            assert_in_range(curve->n, 200, follow ? 8200 : n);
            assert_true(run_column(run, observable(cases[i].name), column, &error));
            double max = largest(column, n), drawn = 0;
            for (size_t j = 0; j < curve->n; j++) {
                size_t row = (size_t)(curve->x[j] / 1e-3 + 0.5);
                drawn = fmax(drawn, fabs(curve->y[j]));
                assert_true(fabs(curve->y[j] - column[row]) <= 1e-12 * max);
            }
            assert_true(drawn >= max * (follow ? 0.99 : 1));
            arena_reset(&arena);
        }
    }
    free(column);
    session_destroy(session);
}

/* After a change of the spring the energy of earlier rows is still that of the spring they had. */
TEST(rows_before_a_change_keep_their_energy)
{
    struct session *session = begin(false, "k = 2.1 N/m; y0 = 4.2 cm; method rk4; dt = 1 ms");
    tell(session, "run 5 s");
    struct run *run = current(session);
    struct scene scene = run->scene;
    struct error error;
    assert_true(scene_set(&scene, param_index("k"), (struct measured){8.4, 0}, &error));
    assert_true(run_rebind(run, &scene, &error));
    run_advance(run, &(struct run_target){.t = 10, .steps = -1}, 0, NULL);
    struct arena arena = {0};
    struct figure figure = figure_of(session, PLOT_ENERGY, true, &arena);
    double start = 0.5 * 2.1 * 0.042 * 0.042;
    for (size_t i = 0; i < figure.curve[0].n && figure.curve[0].x[i] < 4.99; i++)
        assert_true(fabs(figure.curve[0].y[i] / start - 1) < 1e-6);
    assert_true(fabs(figure.curve[0].y[figure.curve[0].n - 1] / start - 1) > 0.1);
    arena_reset(&arena);
    session_destroy(session);
}

TEST(the_spectrum_has_its_peak_at_the_frequency)
{
    struct session *session = begin(false, swing);
    tell(session, "run 60 s");
    struct arena arena = {0};
    struct figure figure = figure_of(session, plot_named("spectrum"), false, &arena);
    size_t peak = 0;
    for (size_t i = 0; i < figure.curve[0].n; i++)
        if (figure.curve[0].y[i] > figure.curve[0].y[peak])
            peak = i;
    assert_true(fabs(figure.curve[0].x[peak] - 1 / 1.9391) < 0.01);
    arena_reset(&arena);
    session_destroy(session);
}

/* A swing of 9 s and, loaded, a recording of it: every third value, in units of `by` from `zero`
 * on. */
static struct session *begin_recorded(const char *column, double zero, double by)
{
    char path[] = "/tmp/hooke-view-XXXXXX", line[80];
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    struct session *session = begin(false, swing);
    tell(session, "run 9 s");
    const struct run *run = current(session);
    dprintf(fd, "t [s]\t%s\n", column);
    for (size_t i = 0; i < trace_count(run->trace); i += 3)
        dprintf(fd, "%.17g\t%.17g\n", trace_time(run->trace, i),
                (trace_state(run->trace, i)[0] - zero) / by);
    close(fd);
    snprintf(line, sizeof line, "load '%s'", path);
    tell(session, line);
    unlink(path);
    return session;
}

TEST(a_residual_is_what_is_left_of_the_recording)
{
    struct session *session = begin_recorded("y [m]", -1e-3, 1);
    assert_shows(session, 80, 24, "o data");
    struct arena arena = {0};
    struct figure figure = figure_of(session, plot_named("residual"), false, &arena);
    assert_string_equal(figure.curve[0].label, "data - run");
    assert_int_equal(figure.curve[0].n, 301);
    for (size_t i = 0; i < figure.curve[0].n; i++)
        assert_true(fabs(figure.curve[0].y[i] - 1e-3) < 1e-9);
    tell(session, "fit damped");
    figure = figure_of(session, plot_named("residual"), false, &arena);
    assert_string_equal(figure.curve[0].label, "data - fit");
    assert_true(largest(figure.curve[0].y, figure.curve[0].n) < 1e-4);
    view_focus_on(&session->view, plot_named("residual"));
    assert_shows(session, 80, 24, "o data - fit");
    /* of the pane below: a run has its name somewhere */
    assert_shows(session, 80, 24, "-- verlet");
    arena_reset(&arena);
    session_destroy(session);
}

/* Volts are laid over the run in its own unit, in panes too: 1 V = 2.5 cm, 0 V at 1 cm. */
TEST(a_voltage_lies_on_the_run)
{
    struct session *session = begin_recorded("U [V]", 0.01, 0.025);
    const struct run *run = current(session);
    assert_shows(session, 80, 24, "o data");
    struct arena arena = {0};
    struct figure figure = figure_of(session, PLOT_POSITION, false, &arena);
    assert_int_equal(figure.curves, 2);
    assert_string_equal(figure.curve[1].label, "data");
    assert_int_equal(figure.curve[1].n, 301);
    for (size_t i = 0; i < figure.curve[1].n; i++)
        assert_true(fabs(figure.curve[1].y[i] - trace_state(run->trace, 3 * i)[0]) < 1e-12);
    figure = figure_of(session, plot_named("residual"), false, &arena);
    assert_non_null(strchr(figure.y.unit, 'V')); /* V or mV */
    assert_true(largest(figure.curve[0].y, figure.curve[0].n) < 1e-11);
    /* A run at rest gives no scale: nothing is drawn of the recording. */
    tell(session, "y0 = 0; v0 = 0; run 9 s");
    figure = figure_of(session, PLOT_POSITION, false, &arena);
    assert_true(figure.curves < 2 || figure.curve[1].n == 0);
    arena_reset(&arena);
    session_destroy(session);
}

RUN_TESTS(NULL, NULL)
