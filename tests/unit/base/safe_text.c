/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "cmocka_testing.h"

#include <hooke/base/safe_text.h>

#include <locale.h>
#include <wchar.h>

static const char *safe(struct buffer *b, struct text text, bool keep_layout)
{
    buffer_clear(b);
    safe_text(b, text, keep_layout);
    return b->data ? b->data : "";
}

TEST(what_is_shown)
{
    static const struct {
        const char *text, *shown;
    } cases[] = {
        {"plain text", "plain text"},
        {"gr\xC3\xB6\xC3\x9F"
         "e \xE2\x82\xAC \xF0\x9F\x98\x80",
         "gr\xC3\xB6\xC3\x9F"
         "e \xE2\x82\xAC \xF0\x9F\x98\x80"},
        {"\033[2J", "\\x1b[2J"},
        {"a\rb\177\b", "a\\x0db\\x7f\\x08"},
        {"\x9b"
         "31m",
         "\\x9b31m"},
        {"\xC2\x9B"
         "31m",
         "<U+009B>31m"},
        {"a\xE2\x80\xAE"
         "b",
         "a<U+202E>b"},
        {"\xE2\x80\xA8\xE2\x80\xA9", "<U+2028><U+2029>"},
        {"\xE2\x81\xA6\xE2\x80\x8B\xEF\xBB\xBF\xD8\x9C", "<U+2066><U+200B><U+FEFF><U+061C>"},
        {"\xC0\xAF", "\\xc0\\xaf"},                   /* overlong */
        {"\xED\xA0\x80", "\\xed\\xa0\\x80"},          /* surrogate */
        {"\xF4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"}, /* beyond U+10FFFF */
        {"\xE2\x82", "\\xe2\\x82"},                   /* cut off */
        {"\xEF\xBF\xBD", "\xEF\xBF\xBD"},             /* the replacement character itself */
        {"\xEF\xBF\xBF\xF3\xA0\x81\x81", "<U+FFFF><U+E0041>"},
    };
    struct buffer b = {0};
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        assert_string_equal(safe(&b, text_of(cases[i].text), false), cases[i].shown);
    assert_string_equal(safe(&b, TEXT("a\tb\nc\0d"), false), "a\\x09b\\x0ac\\x00d");
    assert_string_equal(safe(&b, TEXT("a\tb\nc\r"), true), "a\tb\nc\\x0d");
    buffer_free(&b);
}

static bool is_unsafe(uint32_t c)
{
    return c < 0x20 || (c >= 0x7F && c < 0xA0) || (c >= 0x200B && c <= 0x200F) ||
           (c >= 0x2028 && c <= 0x202E) || (c >= 0x2060 && c <= 0x2069) || c == 0x61C ||
           c == 0xFEFF || (c & 0xFFFE) == 0xFFFE || (c >= 0xFDD0 && c <= 0xFDEF);
}

/* Random bytes, and random mixtures of pieces that mean harm: nothing unsafe and nothing invalid
 * comes out; it is stable. */
TEST(nothing_unsafe_comes_out)
{
    static const char *const pieces[] = {"\033", "[31m",         "]0;title\a",  "\xE2\x80", "\xAE",
                                         "\xC2", "\x9B",         "\xF0\x9F",    "ok",       "\r",
                                         "\n",   "\xEF\xBB\xBF", "\xC3\xA9",    "P",        "\\",
                                         "\x80", "\xFF",         "\xE2\x80\x8E"};
    struct buffer raw = {0}, once = {0}, twice = {0};
    uint64_t r = 1;
    for (int i = 0; i < 20000; i++) {
        buffer_clear(&raw);
        for (int k = 0; k < 20; k++) {
            r = r * 6364136223846793005u + 1442695040888963407u;
            if (i % 2)
                buffer_char(&raw, (char)(r >> 56));
            else
                buffer_put(&raw, text_of(pieces[(r >> 40) % COUNT_OF(pieces)]));
        }
        safe(&once, buffer_text(&raw), false);
        for (struct text rest = buffer_text(&once); rest.len > 0;) {
            size_t used;
            const uint32_t c = text_codepoint(rest, &used);
            assert_false(c == CODEPOINT_INVALID && used == 1);
            assert_false(is_unsafe(c));
            rest = (struct text){rest.data + used, rest.len - used};
        }
        assert_string_equal(safe(&twice, buffer_text(&once), false), once.data);
    }
    buffer_free(&raw);
    buffer_free(&once);
    buffer_free(&twice);
}

TEST(every_code_point_decodes)
{
    struct buffer b = {0};
    for (uint32_t c = 0; c <= 0x10FFFF; c++) {
        if (c >= 0xD800 && c <= 0xDFFF)
            continue;
        buffer_clear(&b);
        buffer_codepoint(&b, c);
        size_t used;
        assert_int_equal(text_codepoint(buffer_text(&b), &used), c);
        assert_int_equal(used, b.len);
        for (size_t cut = 1; cut < b.len && c % 97 == 0; cut++) {
            assert_int_equal(text_codepoint((struct text){b.data, cut}, &used), CODEPOINT_INVALID);
            assert_int_equal(used, 1);
        }
    }
    size_t used = 9;
    assert_int_equal(text_codepoint(TEXT(""), &used), 0);
    assert_int_equal(used, 0);
    buffer_free(&b);
}

TEST(widths)
{
    assert_int_equal(text_width(TEXT("hooke")), 5);
    assert_int_equal(text_width(TEXT("")), 0);
    assert_int_equal(text_width(TEXT("gr\xC3\xBC\xC3\x9F")), 4);
    assert_int_equal(text_width(TEXT("e\xCC\x81")), 1);                /* e + combining acute */
    assert_int_equal(text_width(TEXT("\xE6\xBC\xA2\xE5\xAD\x97")), 4); /* two ideographs */
    assert_int_equal(text_width(TEXT("\xF0\x9F\x98\x80")), 2);         /* emoji */
    /* braille, box drawing, disc */
    assert_int_equal(text_width(TEXT("\xE2\xA0\xBF\xE2\x94\x80\xE2\x97\x8F")), 3);
    assert_int_equal(text_width(TEXT("\xFF\xFE")), 2); /* invalid bytes take a column each */
    assert_int_equal(text_width(TEXT("\n\033\177")), 0);
}

/* Against the C library where it has a UTF-8 locale; Unicode versions differ in few code points. */
TEST(widths_agree_with_the_library)
{
    if (!setlocale(LC_CTYPE, "C.UTF-8") && !setlocale(LC_CTYPE, "C.utf8")) {
        print_message("no C.UTF-8 locale\n");
        skip();
    }
    const struct {
        uint32_t first, last;
        int allowed; /* code points that may differ */
    } ranges[] = {
        {0x20, 0x7E, 0},       {0xA0, 0xAC, 0},       {0xAE, 0x2FF, 0},      {0x300, 0x36F, 0},
        {0x370, 0x5FF, 0},     {0x900, 0x97F, 0},     {0xE00, 0xE7F, 0},     {0x1100, 0x11FF, 2},
        {0x2010, 0x2027, 0},   {0x2030, 0x205F, 0},   {0x20A0, 0x20FF, 0},   {0x2190, 0x23FF, 0},
        {0x2500, 0x25FF, 0},   {0x2600, 0x27BF, 0},   {0x2800, 0x28FF, 0},   {0x3041, 0x30FF, 0},
        {0x4E00, 0x9FFF, 0},   {0xAC00, 0xD7A3, 0},   {0xFE20, 0xFE2F, 0},   {0xFF01, 0xFF5E, 0},
        {0x1F300, 0x1F64F, 0}, {0x1F680, 0x1F6FF, 4}, {0x1F900, 0x1F9FF, 4}, {0x20000, 0x2A6DF, 0},
        {0x300, 0x1FFFF, 300},
    };
    for (size_t i = 0; i < COUNT_OF(ranges); i++) {
        int differ = 0;
        for (uint32_t c = ranges[i].first; c <= ranges[i].last; c++) {
            const int expected = wcwidth((wchar_t)c);
            if (expected >= 0 && expected != codepoint_width(c))
                differ++;
        }
        if (differ > ranges[i].allowed)
            fail_msg("U+%04X..U+%04X: %d widths differ", (unsigned)ranges[i].first,
                     (unsigned)ranges[i].last, differ);
    }
    setlocale(LC_CTYPE, "C");
}

RUN_TESTS(NULL, NULL)
