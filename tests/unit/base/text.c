/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Slices, arenas, buffers, errors, catalogs and suggestions. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>
#include <hooke/base/safe_text.h>

#include <string.h>

TEST(slices)
{
    assert_true(text_is(text_of(NULL), ""));
    assert_true(text_is(text_trim(TEXT(" \t a b\r ")), "a b"));
    assert_true(text_is(text_trim(TEXT(" \t\r ")), ""));
    assert_true(text_starts(TEXT("verlet"), TEXT("ver")));
    assert_false(text_starts(TEXT("ve"), TEXT("ver")));
    assert_true(text_starts(TEXT("ve"), TEXT("")));
    assert_false(text_equal(TEXT("ab"), TEXT("ac")));
    assert_false(text_equal(TEXT("ab"), TEXT("abc")));
    assert_true(text_equal((struct text){NULL, 0}, TEXT("")));
}

TEST(splitting_gives_every_field_once)
{
    static const char *const fields[] = {"a", "", "bc", ""};
    struct text rest = TEXT("a,,bc,"), head;
    for (size_t i = 0; i < COUNT_OF(fields); i++) {
        assert_true(text_split(&rest, ',', &head));
        assert_true(text_is(head, fields[i]));
    }
    assert_false(text_split(&rest, ',', &head));
    rest = TEXT("");
    assert_true(text_split(&rest, ',', &head)); /* an empty line has one empty field */
    assert_int_equal(head.len, 0);
    assert_false(text_split(&rest, ',', &head));
}

TEST(distances)
{
    static const struct {
        const char *a, *b;
        int distance;
    } cases[] = {
        {"", "", 0},
        {"", "abc", 3},
        {"abc", "", 3},
        {"gama", "gamma", 1},
        {"gmama", "gamma", 1},
        {"verlt", "verlet", 1},
        {"velret", "verlet", 1},
        {"kitten", "sitting", 3},
        {"ca", "abc", 3},
        {"abcd", "badc", 2},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        assert_int_equal(text_distance(text_of(cases[i].a), text_of(cases[i].b)),
                         cases[i].distance);
        assert_int_equal(text_distance(text_of(cases[i].b), text_of(cases[i].a)),
                         cases[i].distance);
    }
    char long_name[200];
    memset(long_name, 'x', sizeof long_name);
    /* too long to be a name: far */
    assert_int_equal(text_distance((struct text){long_name, 200}, TEXT("x")), 200);
    assert_int_equal(
        text_distance((struct text){long_name, LIMIT_NAME}, (struct text){long_name, LIMIT_NAME}),
        0);
}

TEST(arena_memory_is_zeroed_aligned_and_apart)
{
    struct arena arena = {0};
    unsigned char *last = NULL;
    size_t last_size = 0;
    for (size_t size = 0; size < 3000; size += 7) {
        unsigned char *at = arena_alloc(&arena, size);
        assert_non_null(at);
        assert_int_equal((uintptr_t)at % _Alignof(max_align_t), 0);
        for (size_t i = 0; i < size; i++)
            assert_int_equal(at[i], 0);
        memset(at, 0xAB, size);
        for (size_t i = 0; i < last_size; i++)
            assert_int_equal(last[i], 0xAB);
        last = at;
        last_size = size;
    }
    assert_non_null(arena_alloc(&arena, 10u << 20));
    assert_string_equal(arena_text(&arena, (struct text){"abcdef", 3}), "abc");
    assert_string_equal(arena_text(&arena, (struct text){NULL, 0}), "");
    assert_null(arena_array(&arena, SIZE_MAX / 2, 3));
    for (size_t less = 0; less < 100; less++)
        assert_null(arena_alloc(&arena, SIZE_MAX - less));
    arena_reset(&arena);
    assert_null(arena.blocks);
    assert_non_null(arena_alloc(&arena, 1));
    arena_reset(&arena);
}

/* Stopped, it leaves what another arena takes over, with what that has. */
TEST(arenas_are_given_back_until_stopped)
{
    struct cancel cancel = {0};
    struct arena one = {0}, two = {0}, none = {0};
    for (int i = 0; i < 5; i++)
        assert_non_null(arena_alloc(&one, 1u << 20));
    char *kept = arena_text(&two, TEXT("kept"));
    char *given = arena_text(&one, TEXT("given"));
    atomic_store(&cancel.requested, 1);
    arena_give_back(&one, &cancel);
    assert_non_null(one.blocks);
    arena_move(&one, &two);
    arena_move(&none, &two);
    assert_null(one.blocks);
    assert_string_equal(kept, "kept");
    assert_string_equal(given, "given");
    atomic_store(&cancel.requested, 0);
    arena_give_back(&two, &cancel);
    assert_null(two.blocks);
}

TEST(buffers_grow_and_stay_terminated)
{
    struct buffer b = {0};
    assert_int_equal(buffer_text(&b).len, 0);
    buffer_put(&b, TEXT(""));
    assert_string_equal(b.data, "");
    for (int i = 0; i < 10000; i++) {
        buffer_char(&b, (char)('a' + i % 26));
        assert_int_equal(b.data[b.len], '\0');
    }
    assert_int_equal(b.len, 10000);
    for (int i = 0; i < 10000; i++)
        assert_int_equal(b.data[i], 'a' + i % 26);
    buffer_clear(&b);
    assert_string_equal(b.data, "");
    buffer_format(&b, "%s has %d runs", "spring", 3);
    assert_string_equal(b.data, "spring has 3 runs");
    buffer_format(&b, "%500d", 1);
    assert_int_equal(b.len, 17 + 500);
    buffer_clear(&b);
    buffer_codepoint(&b, 'A');
    buffer_codepoint(&b, 0x7FF);
    buffer_codepoint(&b, 0x20AC);
    buffer_codepoint(&b, 0x1F600);
    buffer_codepoint(&b, 0xD800);
    assert_string_equal(b.data, "A\xDF\xBF\xE2\x82\xAC\xF0\x9F\x98\x80\xEF\xBF\xBD");
    buffer_free(&b);
    assert_null(b.data);
}

TEST(errors_carry_a_sentence)
{
    struct error e = {0};
    struct text line = TEXT("set gama 0.1");
    struct text word = {line.data + 4, 4};
    assert_false(error_at(&e, word, "unknown parameter '%s'", "gama"));
    assert_false(error_hint(&e, "did you mean '%s'?", "gamma"));
    error_hint(&e, "('show all' lists the parameters)");
    assert_int_equal(e.code, ERROR_COMMAND);
    assert_string_equal(e.text, "unknown parameter 'gama'");
    assert_string_equal(e.hint, "did you mean 'gamma'?  ('show all' lists the parameters)");
    assert_ptr_equal(e.where.data, word.data);
    assert_false(error_set(&e, ERROR_IO, "cannot read %s", "x"));
    assert_string_equal(e.hint, ""); /* a new error forgets the old hint and place */
    assert_null(e.where.data);
    assert_false(error_memory(&e));
    assert_non_null(strstr(e.text, "out of memory"));
    assert_string_equal(error_name(ERROR_IO), "io");
    assert_string_equal(error_name(ERROR_COMMAND), "command");
    assert_string_equal(error_name(ERROR_USAGE), "usage");
    assert_string_equal(error_name(ERROR_NUMERICAL), "numerical");
    assert_string_equal(error_name(ERROR_CANCELLED), "cancelled");
}

/* Whatever the cut falls on, what is left is whole UTF-8. */
TEST(long_errors_end_between_characters)
{
    char z[1000];
    for (size_t pad = 0; pad < 4; pad++) {
        struct error e = {0};
        memset(z, 'x', pad);
        for (size_t i = pad; i + 4 < sizeof z; i += 3)
            memcpy(z + i, "\xE2\x82\xAC", 4);
        error_set(&e, ERROR_IO, "%s", z);
        assert_true(strlen(e.text) > sizeof e.text - 5);
        for (struct text rest = text_of(e.text); rest.len > 0;) {
            size_t used;
            assert_int_not_equal(text_codepoint(rest, &used), CODEPOINT_INVALID);
            rest = (struct text){rest.data + used, rest.len - used};
        }
        for (int i = 0; i < 5; i++)
            error_hint(&e, "%s", z);
        assert_true(strlen(e.hint) < sizeof e.hint);
    }
}

struct thing {
    struct row row;
    int value;
};

static const struct thing things[] = {
    {{"gamma", "1/s", "damping", "", NULL}, 1},
    {{"euler", "", "forward", "", "explicit-euler fe"}, 2},
    {{"verlet", "", "", "", "leapfrog"}, 3},
    {{"velocity-verlet", "", "", "", NULL}, 4},
    {{"symplectic-euler", "", "", "", NULL}, 5},
    {{"symplectic-euler-kick", "", "", "", NULL}, 6},
    {{"m", "kg", "mass", "", NULL}, 7},
    {{"k", "N/m", "", "", NULL}, 8},
    {{"F0", "N", "", "", NULL}, 9},
    {{"T0", "s", "", "", NULL}, 10},
};
static const struct catalog catalog = CATALOG("thing", things);

static int found(const struct row *row)
{
    return row ? ((const struct thing *)(const void *)row)->value : 0;
}

TEST(catalogs_find)
{
    assert_int_equal(found(catalog_find(&catalog, TEXT("gamma"))), 1);
    assert_int_equal(found(catalog_find(&catalog, TEXT("fe"))), 2);
    assert_int_equal(found(catalog_find(&catalog, TEXT("explicit-euler"))), 2);
    assert_int_equal(found(catalog_find(&catalog, TEXT("explicit"))), 0);
    assert_int_equal(found(catalog_find(&catalog, TEXT("explicit-euler fe"))), 0);
    assert_int_equal(found(catalog_find(&catalog, TEXT(""))), 0);
    assert_int_equal(found(catalog_find(&catalog, TEXT("f0"))), 0); /* names are case-sensitive */
    assert_int_equal(found(catalog_find(&catalog, TEXT("gam"))), 0);

    assert_int_equal(found(catalog_prefix(&catalog, TEXT("gam"), 3)), 1);
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("ga"), 3)), 0);
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("ver"), 3)), 3);
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("ve"), 1)), 0); /* ambiguous */
    /* exact wins */
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("symplectic-euler"), 3)), 5);
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("symplectic"), 3)), 0);
    assert_int_equal(found(catalog_prefix(&catalog, TEXT("m"), 3)), 7); /* exact needs no length */
    assert_int_equal(found(catalog_prefix(&catalog, TEXT(""), 0)), 0);
}

TEST(unknown_names_get_suggestions)
{
    static const struct {
        const char *name, *hint;
    } cases[] = {
        {"gama", "did you mean 'gamma'?"},
        {"velret", "did you mean 'verlet'?"},
        {"Gamma", "did you mean 'gamma'?"},
        {"M", "did you mean 'm'?"},
        {"f0", "did you mean 'F0', 'fe' or 'T0'?"},
        {"symplectic", "did you mean 'symplectic-euler' or 'symplectic-euler-kick'?"},
        {"symplektic-euler", "did you mean 'symplectic-euler'?"},
        {"leapfrig", "did you mean 'leapfrog'?"},
        {"q", ""},
        {"xylophone", ""},
        {"", ""},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct error e = {0};
        struct text name = text_of(cases[i].name);
        assert_false(catalog_unknown(&catalog, name, &e));
        assert_int_equal(e.code, ERROR_COMMAND);
        assert_ptr_equal(e.where.data, name.data);
        assert_string_equal(e.hint, cases[i].hint);
        assert_non_null(strstr(e.text, "unknown thing '"));
    }
    struct error e = {0};
    catalog_unknown(&catalog, TEXT("a\033[2Jb"), &e);
    assert_string_equal(e.text, "unknown thing 'a\\x1b[2Jb'");
    char z[5000];
    memset(z, 'y', sizeof z);
    catalog_unknown(&catalog, (struct text){z, sizeof z}, &e);
    assert_int_equal(strlen(e.text), strlen("unknown thing ''") + 159);
    assert_non_null(strstr(e.text, "...'"));
}

TEST(at_most_three_nearest_first)
{
    static const char *const names[] = {"abxy", "abcx", "abzz", "abcd", "abcy", "abcx", "zzzz"};
    struct suggestion s = {.wanted = TEXT("abce")};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        suggestion_offer(&s, names[i]);
    assert_int_equal(s.count, 3);
    struct error e = {0};
    suggestion_hint(&s, &e);
    assert_string_equal(e.hint, "did you mean 'abcx', 'abcd' or 'abcy'?");
}

TEST(limits_are_named_once)
{
    for (size_t i = 0; i < limit_catalog.count; i++) {
        const struct row *row = catalog_row(&limit_catalog, i);
        assert_ptr_equal(catalog_find(&limit_catalog, text_of(row->name)), row);
        assert_true(((const struct limit *)(const void *)row)->value >= 1);
        assert_true(row->brief[0] != '\0');
    }
}

TEST(the_clock_goes_forward)
{
    int64_t last = clock_ns();
    const int64_t begin = last;
    while (last - begin < 2000000) {
        const int64_t now = clock_ns();
        assert_true(now >= last);
        last = now;
    }
}

TEST(cancellation_is_seen)
{
    struct cancel cancel = {0};
    assert_false(cancelled(NULL));
    assert_false(cancelled(&cancel));
    atomic_store(&cancel.requested, 1);
    assert_true(cancelled(&cancel));
}

/* What is left out are whole items; else whole words, and it is said that something follows. */
TEST(test_lines_are_cut_between_items)
{
    static const struct {
        const char *text;
        int width;
        const char *shown;
        bool cut;
    } cases[] = {
        {"t = 10 s, 1000 steps", 20, "t = 10 s, 1000 steps", false},
        {"t = 10 s, 1000 steps, verlet", 24, "t = 10 s, 1000 steps", false},
        {"B-A = 2.9 s   T = 0.7252930 s   f = 1.3787 Hz", 30, "B-A = 2.9 s   T = 0.7252930 s",
         false},
        {"B-A = 2.9012 s   T = 0.725 s", 22, "B-A = 2.9012 s", false},
        {"warning: the energy has grown", 20, "warning: the", true},
        {"a list (of one, two, three) and more", 30, "a list (of one, two, three)", true},
        {"unbreakable", 5, "unbr", true},
        {"\xcf\x89\xcf\x89 \xcf\x89\xcf\x89\xcf\x89", 5, "\xcf\x89\xcf\x89", true},
        {"", 0, "", false},
        {"a", 0, "", true},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        bool cut;
        const struct text shown = text_in_room(text_of(cases[i].text), cases[i].width, &cut);
        if (!text_is(shown, cases[i].shown) || cut != cases[i].cut)
            fail_msg("'%s' in %d: '%.*s' %d", cases[i].text, cases[i].width, (int)shown.len,
                     shown.data, cut);
        assert_true(text_width(shown) <= cases[i].width);
    }
}

RUN_TESTS(NULL, NULL)
