/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The prompt: widths, sideways scrolling, bytes that are no text. */
#include "unit/view/testing.h"

/* The last row of a screen of this width with `line` typed and the cursor at byte `cursor`. */
static char *edit(int width, const char *line, size_t cursor, int *x)
{
    struct session *session = begin(true, NULL);
    struct prompt_line prompt = typed(line);
    struct canvas canvas;
    struct buffer text = {0};
    prompt.cursor = cursor;
    assert_true(canvas_init(&canvas, width, 1));
    assert_true(screen_draw(session, &prompt, &canvas, x, NULL));
    canvas_print(&canvas, false, &text);
    canvas_free(&canvas);
    session_destroy(session);
    text.data[strcspn(text.data, "\n")] = '\0';
    return text.data;
}

static void check(int width, const char *line, size_t cursor, const char *shown, int at)
{
    int x;
    char *text = edit(width, line, cursor, &x);
    assert_string_equal(text, shown);
    assert_int_equal(x, at);
    free(text);
}

TEST(short_lines_stand_as_they_are)
{
    check(40, "", 0, "hooke>", 7);
    check(40, "run 10 s", 8, "hooke> run 10 s", 15);
    check(40, "run 10 s", 3, "hooke> run 10 s", 10);
}

TEST(wide_characters_move_the_cursor_by_two)
{
    check(40, "\xE6\x97\xA5\xE6\x9C\xAC", 6, "hooke> \xE6\x97\xA5\xE6\x9C\xAC", 11);
    check(40, "\xE6\x97\xA5\xE6\x9C\xAC", 3, "hooke> \xE6\x97\xA5\xE6\x9C\xAC", 9);
    check(40, "\xC5\xBC\xC3\xB3\xC5\x82\xC4\x87", 8, "hooke> \xC5\xBC\xC3\xB3\xC5\x82\xC4\x87", 11);
}

TEST(bytes_that_are_no_text_are_visible)
{
    check(40,
          "a\xFF"
          "b",
          2, "hooke> a\\xFFb", 12);
    check(40, "a\nb", 3, "hooke> a^Jb", 11);
    check(40, "\x1B[2J", 4, "hooke> ^[[2J", 12);
}

TEST(long_lines_scroll_with_marks)
{
    check(20, "abcdefghijklmnopqrstuvwxyz", 0, "hooke> abcdefghijkl>", 7);
    check(20, "abcdefghijklmnopqrstuvwxyz", 11, "hooke> abcdefghijkl>", 18);
    check(20, "abcdefghijklmnopqrstuvwxyz", 12, "hooke> <hijklmnopqr>", 13);
    check(20, "abcdefghijklmnopqrstuvwxyz", 26, "hooke> <tuvwxyz", 15);
}

/* Wherever it stands, the character under the cursor is on the screen. */
TEST(the_cursor_is_always_on_its_character)
{
    static const char line[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    (void)state;
    for (int width = 1; width < 64; width++) {
        for (size_t cursor = 0; cursor < sizeof line - 1; cursor++) {
            int x;
            char *text = edit(width, line, cursor, &x);
            assert_in_range(x, 0, width - 1);
            if (width > 1)
                assert_int_equal(text[x], line[cursor]);
            free(text);
        }
    }
}

RUN_TESTS(NULL, NULL)
