/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait as it is drawn: where its axes put it, and what it costs. */
#include <hooke/plot.h>
#include "modules/dynamics/stored_portrait.h"
#include "unit/view/testing.h"
#include "modules/dynamics/dynamics.h"

#include <math.h>

static char *drawn(const struct session *session, struct arena *arena,
                   const struct charset *charset, struct figure *figure)
{
    const struct figure_request request = {
        .kind = (enum plot_kind)catalog_index(&plot_catalog,
                                              catalog_find(&plot_catalog, TEXT("portrait"))),
        .recording = -1,
        .window = {NAN, NAN},
        .width = 80,
        .charset = charset};
    struct error error = {0};
    struct buffer text = {0};
    if (!session_figure(session, &request, arena, figure, &error))
        fail_msg("%s", error.text);
    assert_true(figure_print(figure, 80, 24, charset, false, &text));
    return text.data;
}

static char cell_of(const char *text, int column, int row)
{
    for (; row > 0; row--)
        text = strchr(text, '\n') + 1;
    return (int)strcspn(text, "\n") > column ? text[column] : ' ';
}

/* The symbols of equilibria stand in the cells where the axes say that they are. */
TEST(symbols_stand_where_they_belong)
{
    static const struct {
        const char *scene;
        double at[3][2];
        char symbol[3];
    } cases[] = {
        {"scene duffing-driven; F0 = 0", {{-1, 0}, {0, 0}, {1, 0}}, "FXF"},
        {"var x = 1; var y = 1; x' = (x-0.37)*(y+1.3); y' = 0.2-x*y", {{0.37, 0.2 / 0.37}}, "X"},
        {"var x = 1; var y = 1; x' = 1-x; y' = 2-3*y", {{1, 2.0 / 3}}, "N"},
        {"scene vanderpol; mu = 0.5", {{0, 0}}, "f"},
        {"scene spring", {{0, 0}}, "C"},
    };
    for (size_t c = 0; c < COUNT_OF(cases); c++) {
        struct session *session = begin(false, cases[c].scene);
        struct arena arena = {0};
        struct figure figure;
        struct figure_layout layout;
        char *text = drawn(session, &arena, &charset_ascii, &figure);
        figure_layout(&figure, 80, 24, &charset_ascii, &layout);
        for (int k = 0; k < 3 && cases[c].symbol[k]; k++) {
            int column, row;
            assert_true(figure_cell(&layout, cases[c].at[k][0], cases[c].at[k][1], &column, &row));
            assert_int_equal(cell_of(text, layout.left + column, layout.top + row),
                             cases[c].symbol[k]);
        }
        free(text);
        arena_reset(&arena);
        session_destroy(session);
    }
}

/* Every arrow points where the flow goes. */
TEST(arrows_point_along_the_flow)
{
    struct session *session = begin(false, "scene vanderpol");
    struct arena arena = {0};
    struct figure figure;
    free(drawn(session, &arena, &charset_ascii, &figure));
    const struct curve *arrows = &figure.curve[figure.curves - 1];
    assert_true(arrows->arrows && arrows->n > 60);
    for (size_t i = 0; i + 5 < arrows->n; i += 6) {
        const double x = (arrows->x[i] + arrows->x[i + 1]) / 2,
                     y = (arrows->y[i] + arrows->y[i + 1]) / 2;
        const double u = y, v = (1 - x * x) * y - x, du = arrows->x[i + 1] - arrows->x[i],
                     dv = arrows->y[i + 1] - arrows->y[i];
        assert_true(fabs(u * dv - v * du) <= 1e-12 * hypot(u, v) * hypot(du, dv));
        assert_true(u * du + v * dv > 0);
    }
    arena_reset(&arena);
    session_destroy(session);
}

/* Nothing is computed until it is shown, and then again only when something has changed. */
TEST(it_is_kept)
{
    struct session *session = begin(true, "scene pendulum; gamma = 0.2; run 5");
    free(print(session, 80, 24));
    assert_false(stored_portrait(session)->known);
    tell(session, "focus portrait full");
    free(print(session, 80, 24));
    assert_true(stored_portrait(session)->known);
    const double *made = stored_portrait(session)->portrait.line[PORTRAIT_SEPARATRIX].x;
    tell(session, "step 10");
    free(print(session, 80, 24));
    assert_ptr_equal(stored_portrait(session)->portrait.line[PORTRAIT_SEPARATRIX].x, made);
    assert_true(
        stored_portrait(session)->scene.value[scene_param(&session->setup.scene, "gamma")] == 0.2);
    tell(session, "gamma = 0.4");
    free(print(session, 80, 24));
    assert_true(
        stored_portrait(session)->scene.value[scene_param(&session->setup.scene, "gamma")] == 0.4);
    session_destroy(session);
}

RUN_TESTS(NULL, NULL)
