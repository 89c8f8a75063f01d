/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every allocation of a frame fails once, and with all that follow it: a frame is drawn or the
 * canvas is blank. */
#include "faults/failing_malloc.h"
#include "unit/view/testing.h"

static bool is_blank(const struct canvas *canvas)
{
    for (int i = 0; i < canvas->width * canvas->height; i++)
        if (canvas->cell[i].codepoint != ' ')
            return false;
    return true;
}

TEST(a_frame_survives_every_failure)
{
    if (!MALLOC_CAN_FAIL)
        skip();
    struct session *session = begin(true, swing);
    tell(session, "run 9.6 s");
    tell(session, "cursor periods 4");
    struct prompt_line prompt = typed("run");
    struct canvas canvas;
    assert_true(canvas_init(&canvas, 120, 40));
    for (size_t layout = 0; layout < layout_catalog.count; layout++) {
        session->view.layout = (enum layout)layout;
        malloc_fail_at = -1;
        malloc_calls = 0;
        assert_true(screen_draw(session, &prompt, &canvas, NULL, NULL));
        long calls = malloc_calls, blank = 0;
        for (int for_ever = 0; for_ever < 2; for_ever++) {
            for (long at = 0; at < calls; at++) {
                malloc_fail_for_ever = for_ever;
                malloc_calls = 0;
                malloc_fail_at = at;
                bool drawn = screen_draw(session, &prompt, &canvas, NULL, NULL);
                malloc_fail_at = -1;
                assert_int_equal(is_blank(&canvas), !drawn);
                blank += !drawn;
            }
        }
        if (layout != LAYOUT_LOG)
            assert_true(blank > 0);
    }
    canvas_free(&canvas);
    session_destroy(session);
}

RUN_TESTS(NULL, NULL)
