/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The screen of every scene: its panes, under the names of its variables. */
#include "unit/view/testing.h"
#include <hooke/run.h>

static void start(struct session *session, const char *preset)
{
    char line[120];
    snprintf(line, sizeof line, "scene %s; method rk4 dt=1e-9; run --steps 300", preset);
    tell(session, line);
}

/* Whatever the layout and the size: something is drawn, and no pane that the scene has not. */
TEST(every_scene_in_every_layout)
{
    static const int sizes[][2] = {{20, 6}, {40, 12}, {80, 24}, {130, 45}};
    for (size_t p = 0; p < preset_catalog.count; p++) {
        struct session *session = begin(p % 2, NULL);
        tell(session, "layout trio");
        start(session, catalog_row(&preset_catalog, p)->name);
        log_clear(&session->log); /* which names panes, too */
        const struct model *model = current(session)->system.model;
        char title[64];
        for (int l = 0; l < (int)layout_catalog.count; l++)
            for (size_t s = 0; s < COUNT_OF(sizes); s++) {
                session->view.layout = (enum layout)l;
                char *text = print(session, sizes[s][0], sizes[s][1]);
                if (model->order == 1)
                    assert_true((model->n > 1 || !strstr(text, "phase")) &&
                                !strstr(text, "energy"));
                free(text);
            }
        session->view.layout = LAYOUT_PLOT;
        snprintf(title, sizeof title, " %s%s", model->variable[0].name,
                 model == &oscillator_model ? " [" : "");
        assert_shows(session, 100, 24, title);
        session_destroy(session);
    }
}

TEST(an_orbit_where_there_are_two_coordinates)
{
    struct session *session = begin(false, "scene kepler; method verlet; run 10 s");
    assert_shows(session, 80, 24, "- x, y -");
    assert_shows(session, 80, 24, "- orbit y -");
    assert_hides(session, 80, 24, "phase");
    assert_hides(session, 80, 24, "[J]");
    tell(session, "focus phase");
    assert_shows(session, 80, 24, "- phase vx -");
    assert_hides(session, 80, 24, "orbit y -");
    tell(session, "focus orbit full");
    assert_shows(session, 80, 24, "- orbit y -");
    assert_hides(session, 80, 24, "energy -");
    tell(session, "focus velocity");
    assert_shows(session, 80, 24, "- vx, vy -");
    tell(session, "layout trio; focus position shared; scene elastic-pendulum; run 10 s");
    assert_shows(session, 80, 24, "- orbit y [");
    tell(session, "scene spring; run 10 s");
    assert_shows(session, 80, 24, "- phase v/omega0 [");
    session_destroy(session);
}

TEST(values_alone_of_first_order)
{
    struct session *session = begin(false, "scene robertson; method radau5 dt=100ms; run 4 s");
    assert_shows(session, 80, 24, "- y1, y3 -");
    assert_shows(session, 80, 24, "-- y1  x y3");
    assert_hides(session, 80, 24, "E=");
    tell(session, "layout stack");
    log_clear(&session->log);
    assert_hides(session, 80, 24, "energy");
    assert_hides(session, 80, 24, "velocity");
    session_destroy(session);
}

/* A run of another scene has other variables: it is not laid over this one. */
TEST(only_runs_of_the_same_kind_are_laid_over)
{
    struct session *session =
        begin(false, "scene kepler; run 5 s; scene pendulum; run 5 s; method verlet; run 5 s");
    tell(session, "overlay run 1 2");
    assert_shows(session, 80, 24, "- theta [rad] -");
    assert_shows(session, 80, 24, "-- verlet  # euler -");
    session_destroy(session);
}

/* Before the first run, too. */
TEST(axes_wait_for_the_run)
{
    struct session *session = begin(false, "scene pendulum; theta0 = 40 deg");
    assert_shows(session, 80, 24, "- theta [");
    tell(session, "scene kepler");
    assert_shows(session, 80, 24, "- x -");
    tell(session, "scene robertson");
    assert_shows(session, 80, 24, "- y1 -");
    assert_shows(session, 80, 24, " robertson  k1=0.04  k2=3e7  k3=10000 | ");
    session_destroy(session);
}

/* A drive that is not there has no frequency. */
TEST(the_state_line_says_what_acts)
{
    struct session *session = begin(false, "scene pendulum");
    assert_hides(session, 130, 24, "omega=");
    assert_shows(session, 130, 24, "theta0=");
    tell(session, "F0 = 1 N");
    assert_shows(session, 130, 24, "omega=2 rad/s");
    tell(session, "scene vanderpol");
    assert_shows(session, 80, 24, "mu=1");
    session_destroy(session);
}

RUN_TESTS(NULL, NULL)
