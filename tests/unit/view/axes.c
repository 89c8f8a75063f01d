/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every sample lies where the axes put it: a property of screens of random sessions.
 *
 * Two readings. Of the figures behind the panes: what a curve holds at a time is what the run or
 * the recording has then, and the axis of its own pane puts it where the printed one does. Of the
 * screen itself, as a person reads it: the numbers beside the ticks, interpolated in between, say
 * which cells may have ink and which must.
 */
#include "long_form.h"
#include <hooke/run.h>
#include <hooke/data.h>
#include "view/internal.h"
#include "unit/axes_testing.h"
#include "unit/view/testing.h"

#include <math.h>
#include <unistd.h>

/* ---- random sessions ---- */

struct trial {
    struct dice dice;
    struct session *session;
    char told[4000]; /* every command, for the message */
    int width, height;
};

static void say(struct trial *s, const char *line)
{
    struct reply reply;
    reply_init(&reply, (struct sink){take, take, &s->session->log});
    size_t used = strlen(s->told);
    snprintf(s->told + used, sizeof s->told - used, "%s\n", line);
    /* some are refused: it is as random as people are */
    command_exec(s->session, text_of(line), NULL, &reply);
    reply_free(&reply);
}

#define SAY(s, ...)                                                                                \
    do {                                                                                           \
        char line_[200];                                                                           \
        snprintf(line_, sizeof line_, __VA_ARGS__);                                                \
        say(s, line_);                                                                             \
    } while (0)

static void add_run(struct trial *s)
{
    static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4", "dopri5"};
    struct dice *dice = &s->dice;
    SAY(s, "method %s", methods[dice_below(dice, COUNT_OF(methods))]);
    SAY(s, "dt = %g ms", dice_between(dice, 2, 20));
    SAY(s, "run %.3g s",
        exp(dice_between(dice, log(0.5), log(60))) * (dice_below(dice, 5) ? 1 : -0.3));
}

static void make_session(struct trial *s, unsigned seed)
{
    static const char *const scenes[] = {"spring",   "spring",    "spring",
                                         "pendulum", "vanderpol", "kepler"};
    struct dice *dice = &s->dice;
    *s = (struct trial){.dice = {seed}, .session = begin(seed % 2, NULL)};
    const bool recorded = dice_below(dice, 10) < 6;
    SAY(s, "scene %s", scenes[dice_below(dice, COUNT_OF(scenes))]);
    if (dice_below(dice, 2))
        SAY(s, "k = %.3g N/m; gamma = %.2g", dice_between(dice, 1, 30), dice_between(dice, 0, 0.3));
    if (recorded) {
        write_swing(dice, "swing.txt");
        say(s, "load swing.txt");
    }
    for (int runs = dice_below(dice, 4), i = recorded ? 1 : 0; i <= runs; i++)
        add_run(s);
    if (dice_below(dice, 3) == 0)
        say(s, "overlay run all");
}

static void arrange(struct trial *s)
{
    struct dice *dice = &s->dice;
    SAY(s, "layout %s", catalog_row(&layout_catalog, (size_t)dice_below(dice, LAYOUT_LOG))->name);
    if (dice_below(dice, 3) == 0)
        SAY(s, "focus %s%s",
            catalog_row(&plot_catalog, (size_t)dice_below(dice, (int)plot_catalog.count))->name,
            dice_below(dice, 3) ? "" : " full");
    if (dice_below(dice, 4) == 0)
        SAY(s, "window %.2g s", dice_between(dice, 0.5, 30));
    if (dice_below(dice, 4) == 0)
        SAY(s, "range x %.2g:%.2g", dice_between(dice, 0, 3), dice_between(dice, 4, 20));
    for (int i = dice_below(dice, 3); i > 0; i--)
        SAY(s, "zoom %.2g", dice_between(dice, 0.4, 6));
    if (dice_below(dice, 3) == 0)
        SAY(s, "pan %.2g s", dice_between(dice, -5, 5));
    if (dice_below(dice, 4) == 0)
        say(s, "cursor");
    if (dice_below(dice, 4) == 0 && s->session->runs.current >= 0) {
        struct run *run = current(s->session);
        run_back(run, run->steps * dice_below(dice, 100) / 100);
        s->session->live.state = dice_below(dice, 2) ? LIVE_RUNNING : LIVE_PAUSED;
        s->session->view.paging = dice_below(dice, 2);
        strcat(s->told, "(live)\n");
    }
    static const char *const sets[] = {"ascii", "block", "braille"};
    SAY(s, "set charset %s", sets[dice_below(dice, 3)]);
    s->width = 20 + dice_below(dice, 181);
    s->height = 6 + dice_below(dice, 55);
}

/* ---- the figures ---- */

#define PARTS_MOST (PANELS_MAX * PLACED_MAX)

/* Panes, those of two panels as two. */
struct panes {
    struct screen screen;
    struct placed_pane placed[PARTS_MOST];
    struct figure figure[PARTS_MOST];
    struct figure_layout layout[PARTS_MOST];
    int placed_count;
};

/* With the curves of this panel only. */
static struct figure part_of(struct panes *p, const struct figure *figure)
{
    struct figure part = *figure;
    struct curve *curve = arena_array(&p->screen.arena, (size_t)figure->curves + 1, sizeof *curve);
    assert_non_null(curve);
    part.curve = curve;
    part.curves = 0;
    for (int i = 0; i < figure->curves; i++)
        if (!figure->part || figure->curve[i].panel == figure->panel)
            curve[part.curves++] = figure->curve[i];
    return part;
}

static void add_panels(struct panes *p, const struct placed_pane *placed,
                       const struct figure *figure)
{
    struct figure_panel panel[PANELS_MAX];
    const int panels = figure_panels(figure, placed->area.width, pane_drawn_height(placed),
                                     p->screen.charset, panel);
    for (int i = 0; i < panels; i++) {
        /* the next one has the axis of both */
        const bool covered = i + 1 < panels && !figure->plane;
        const int seen = covered         ? panel[i + 1].y - panel[i].y
                         : figure->plane ? panel[i].height
                                         : placed->area.height - panel[i].y;
        struct placed_pane *part = &p->placed[p->placed_count];
        *part = *placed;
        part->area = (struct rectangle){placed->area.x + panel[i].x, placed->area.y + panel[i].y,
                                        panel[i].width, seen};
        part->open = covered || placed->open;
        p->figure[p->placed_count] = part_of(p, &panel[i].figure);
        figure_layout(&panel[i].figure, panel[i].width, panel[i].height, p->screen.charset,
                      &p->layout[p->placed_count++]);
    }
}

static void open_panes(struct panes *p, const struct trial *s)
{
    const struct division division = screen_division(s->session, s->height);
    *p = (struct panes){.screen = {.session = s->session, .charset = session_charset(s->session)}};
    if (division.plots) {
        const struct rectangle area = {0, division.state, s->width, division.plots};
        struct placed_pane placed[PLACED_MAX];
        struct figure figure[PLACED_MAX];
        const int placed_count = screen_panes(s->session, area, s->height, placed);
        assert_true(panes_figures(&p->screen, placed, placed_count, figure));
        for (int i = 0; i < placed_count; i++)
            add_panels(p, &placed[i], &figure[i]);
    }
}

/* The place whose time axis is printed below the pane. */
static int printed_by(const struct panes *p, int placed)
{
    while (p->placed[placed].open)
        placed++;
    return placed;
}

/* What the run has at one of its times; NAN: it was not recorded then. */
static double value_at(const struct run *run, enum plot_kind pane, double t)
{
    size_t low = 0, high = trace_count(run->trace);
    const double way = trace_time(run->trace, high - 1) < trace_time(run->trace, 0) ? -1 : 1;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (way * trace_time(run->trace, middle) < way * t)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == trace_count(run->trace) || trace_time(run->trace, low) != t)
        return NAN;
    const double *y = trace_state(run->trace, low);
    return pane == PLOT_POSITION ? y[0]
           : pane == PLOT_VELOCITY
               ? y[run->system.n / 2]
               : system_kinetic(&run->system, y) + system_potential(&run->system, y);
}

static bool is_recorded(const struct recording *recording, struct arena *arena, double t, double y)
{
    struct series series;
    struct error error;
    if (!recording || !recording_series(recording, arena, 1, &series, &error))
        return false;
    for (size_t i = 0; i < series.n; i++)
        if (series.t[i] == t)
            return series.y[i] == y;
    return false;
}

/* A few samples of each curve, of what is simply recorded. */
static void check_samples(const struct trial *s, struct panes *p, int placed)
{
    const enum plot_kind pane = p->placed[placed].pane;
    const struct figure *figure = &p->figure[placed];
    if (pane != PLOT_POSITION && pane != PLOT_VELOCITY && pane != PLOT_ENERGY)
        return;
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        /* a gap is wider, a step not */
        const double widest = curve->n ? (curve->x[curve->n - 1] - curve->x[0]) / 8 : 0;
        for (size_t i = 0; i < curve->n; i++) {
            const double t = curve->x[i], y = curve->y[i];
            bool own = false, known = false;
            for (int r = 0; r < s->session->runs.count; r++) {
                const struct run *run = s->session->runs.slot[r]->run;
                const double its =
                    run->system.order == 2 || pane == PLOT_POSITION ? value_at(run, pane, t) : NAN;
                known |= !isnan(its);
                own |= fabs(its - y) <= 1e-9 * fabs(y) || run->system.n > 2; /* other coordinates */
            }
            if (!curve->points && i + 1 < curve->n && curve->x[i + 1] - t > widest &&
                s->session->runs.current < 0)
                fail_msg("a line from t = %g to %g, where nothing was recorded\n%s", t,
                         curve->x[i + 1], s->told);
            own |= pane == PLOT_POSITION &&
                   is_recorded(session_recording(s->session), &p->screen.arena, t, y);
            if (known && !own)
                fail_msg("%s: nothing has %g at t = %g in\n%s",
                         catalog_row(&plot_catalog, (size_t)pane)->name, y, t, s->told);
        }
    }
}

/* The axis that is printed puts the samples of a pane where the pane has them. */
static void check_figure(const struct trial *s, struct panes *p, int placed)
{
    const int printed = printed_by(p, placed);
    const struct figure_layout *own = &p->layout[placed], *axis = &p->layout[printed];
    const struct figure *figure = &p->figure[placed];
    if (plot_is_timed(p->placed[placed].pane) != plot_is_timed(p->placed[printed].pane))
        fail_msg("a stack of two kinds of axes");
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        for (size_t i = 0; i < curve->n; i++) {
            int column, row, other;
            if (!figure_cell(own, curve->x[i], curve->y[i], &column, &row) ||
                !figure_cell(axis, curve->x[i], axis->y.first_value, &other, &row))
                continue;
            if (own->left + column != axis->left + other)
                fail_msg("%dx%d: a sample of pane %d at x = %g is in column %d, the axis has it in "
                         "%d\n%s",
                         s->width, s->height, placed, curve->x[i], own->left + column,
                         axis->left + other, s->told);
        }
        /* Nothing of a pane is shown that is outside of the axis printed below it. */
        for (size_t i = 0; i < curve->n; i++) {
            const double own_x = scale_fraction(&own->x, curve->x[i]),
                         its = scale_fraction(&axis->x, curve->x[i]);
            if (fabs(fmin(fmax(own_x, 0), 1) - fmin(fmax(its, 0), 1)) * own->columns > 0.5)
                fail_msg("%dx%d: x = %g is at %g of pane %d, at %g of the axis\n%s", s->width,
                         s->height, curve->x[i], own_x, placed, its, s->told);
        }
    }
}

/* ---- the screen ---- */

/* Reads both axes of a pane off the screen. False: it has no labels there. */
static bool read_pane(const struct panes *p, int placed, const struct canvas *canvas,
                      struct reader *reader)
{
    const struct placed_pane *bottom = &p->placed[printed_by(p, placed)];
    const struct rectangle at = p->placed[placed].area;
    const struct figure *figure = &p->figure[placed];
    *reader = (struct reader){.canvas = canvas,
                              .left = at.x,
                              .right = at.x + at.width - 1,
                              .top = at.y,
                              .bottom = at.y + at.height - (p->placed[placed].open ? 0 : 1),
                              .axis_row = bottom->area.y + bottom->area.height - 3};
    return p->layout[placed].y_labels && read_x_axis(reader, axis_unit(&figure->x)) &&
           read_y_axis(reader, axis_unit(&figure->y), p->layout[placed].y.log) &&
           p->layout[placed].y_decades == p->layout[placed].y.log;
}

static int check_screen(const struct trial *s, const struct panes *p, int placed,
                        const struct canvas *canvas)
{
    struct reader reader;
    const struct figure *figure = &p->figure[placed];
    if (!read_pane(p, placed, canvas, &reader))
        return 0;
    char problem[200];
    if (!reader_agrees(&reader, figure, problem)) {
        struct buffer text = {0};
        canvas_print(canvas, false, &text);
        fail_msg("%dx%d, pane %s: %s\n%s%s", s->width, s->height,
                 catalog_row(&plot_catalog, (size_t)p->placed[placed].pane)->name, problem, s->told,
                 text.data);
    }
    return 1;
}

static void every_sample_is_where_the_axes_put_it(void **state)
{
    (void)state;
    const unsigned sessions = is_long() ? 400 : 16;
    int figures = 0, read = 0;
    for (unsigned seed = 1; seed <= sessions; seed++) {
        struct trial s;
        make_session(&s, seed);
        for (int view = 0; view < 4; view++) {
            struct panes p;
            arrange(&s);
            struct canvas canvas = draw(s.session, s.width, s.height);
            open_panes(&p, &s);
            for (int i = 0; i < p.placed_count; i++) {
                check_figure(&s, &p, i);
                check_samples(&s, &p, i);
                read += check_screen(&s, &p, i, &canvas);
                figures++;
            }
            arena_reset(&p.screen.arena);
            canvas_free(&canvas);
        }
        session_destroy(s.session);
    }
    printf("# %d panes of %u sessions, %d of them read off the screen\n", figures, sessions, read);
    assert_true(read > figures / 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_sample_is_where_the_axes_put_it, axes_folder_enter,
                                        axes_folder_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
