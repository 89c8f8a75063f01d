/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readline's lists of undo: however they are left, they are freed, and once. */
#include "cmocka_testing.h"

#include <malloc.h>

#include "terminal/terminal.h"

#include <readline/history.h>
#include <readline/readline.h>

enum { LINES = 20000, MOST = 4096 /* [byte] that so many lines may leave */ };

static void edit(void)
{
    rl_replace_line("", 1);
    rl_insert_text("k = 20 N/m");
    rl_delete_text(0, 3);
    rl_point = 0;
    rl_insert_text("m");
}

/* As where a search begins. */
static void leave_list(void)
{
    edit();
    rl_undo_list = NULL;
}

/* As where the line, its entry of the history and the line that is put aside have the same list. */
static void free_twice(void)
{
    edit();
    UNDO_LIST *const list = rl_undo_list;
    rl_free_undo_list();
    rl_undo_list = list;
    rl_free_undo_list();
    rl_undo_list = list->next;
    rl_do_undo();
}

static void leave_to_history(void)
{
    edit();
    HIST_ENTRY *const entry = replace_history_entry(0, rl_line_buffer, (histdata_t)rl_undo_list);
    assert_non_null(entry);
    free_history_entry(entry);
}

TEST(test_lists)
{
    void (*const ways[])(void) = {edit, leave_list, free_twice, leave_to_history};
    rl_initialize();
    using_history();
    add_history("show");
    for (size_t way = 0; way < COUNT_OF(ways); way++) {
        size_t before = 0;
        for (int i = 0; i < LINES; i++) {
            ways[way]();
            line_over();
            assert_null(rl_undo_list);
            if (i == LINES / 10)
                before = mallinfo2().uordblks;
        }
        const size_t after = mallinfo2().uordblks;
        if (after > before + MOST)
            fail_msg("way %zu: %zu bytes more after %d lines", way, after - before, LINES);
    }
}

/* Nothing behind a NUL is of the line: there, and in undoing, readline would not find its end. */
TEST(test_end)
{
    edit();
    const int end = rl_end;
    rl_point = end;
    line_mend();
    assert_int_equal(rl_end, end);
    assert_non_null(rl_undo_list);
    rl_line_buffer[2] = '\0';
    line_mend();
    assert_int_equal(rl_end, 2);
    assert_int_equal(rl_point, 2);
    assert_null(rl_undo_list);
    line_over();
}

RUN_TESTS(NULL, NULL)
