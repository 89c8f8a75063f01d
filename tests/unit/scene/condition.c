/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparisons of two expressions, with units. */
#include "unit/scene/names.h"

#include <string.h>

static struct condition condition_of(const char *source, struct arena *arena)
{
    struct condition condition = {0};
    struct error error = {0};
    size_t used = 0;
    if (!condition_compile(text_of(source), &scope, arena, &condition, &used, &error))
        fail_msg("'%s': %s", source, error.text);
    assert_int_equal(used, strlen(source));
    return condition;
}

TEST(test_conditions)
{
    static const struct {
        const char *source;
        double value;
        bool holds;
    } cases[] = {
        {"y < 3", -1, true},       {"y < 2", 0, false},          {"y <= 2", 0, true},
        {"y>3", 1, false},         {"y >= 2", 0, true},          {"y > 2", 0, false},
        {"v < -300 cm", 0, false}, {"v <= -300 cm", 0, true},    {"y*2 > 3 m", -1, true},
        {"100 cm < y", -1, true},  {"50 cm <= 500 mm", 0, true}, {"nan_ < 1", NAN, false},
        {"nan_ >= 1", NAN, false},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        struct condition condition = condition_of(cases[i].source, &arena);
        double value = condition_value(&condition, &scope);
        if (!(value == cases[i].value || (isnan(value) && isnan(cases[i].value))))
            fail_msg("'%s' gives %g", cases[i].source, value);
        assert_true(condition_holds(&condition, value) == cases[i].holds);
        arena_reset(&arena);
    }
    static const struct {
        const char *source, *sentence, *where;
    } wrong[] = {
        {"y", "a condition needs <, <=, > or >=", ""},
        {"y = 3", "a condition needs <, <=, > or >=", "="},
        {"y < ", "a number or a name is missing", ""},
        {"< 3", "a number or a name is missing", "<"},
        {"1 cm < 2 s", "'1 cm' (length) cannot be compared with '2 s' (time)", "2 s"},
        {"1 < 2 cm", "'1' (number) cannot be compared with '2 cm' (length)", "2 cm"},
        {"y m < 3", "a unit may follow a number or a parenthesis, not 'y'", "m"},
        {"y < gama", "unknown name 'gama'", "gama"},
    };
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        struct arena arena = {0};
        struct condition condition;
        struct error error = {0};
        size_t used;
        assert_false(
            condition_compile(text_of(wrong[i].source), &scope, &arena, &condition, &used, &error));
        assert_string_equal(error.text, wrong[i].sentence);
        assert_true(text_is(error.where, wrong[i].where));
        arena_reset(&arena);
    }
}

RUN_TESTS(NULL, NULL)
