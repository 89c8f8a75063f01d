/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Containers that are cut anywhere, grow without bound, nest, or declare what no instrument
 * declares: each is refused for the true reason, and costs little memory.
 */
#include "long_form.h"
#include "modules/recording/data/archives.h"

#include <sys/resource.h>

static long peak(void) /* [KiB] of memory, ever */
{
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return usage.ru_maxrss;
}

static bool runs_under_sanitizer(void)
{
#if defined(__SANITIZE_ADDRESS__)
    return true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
    return true;
#endif
#endif
    return false;
}

static void put_long_table(struct buffer *out)
{
    buffer_format(out, "Time (s),Position (cm)\n");
    for (int i = 0; i < 400; i++)
        buffer_format(out, "%.2f,%.3f\n", 0.02 * i, 20 + 5 * (i * 7 % 13) / 13.0);
}

static void put_long_sheet(struct buffer *out)
{
    buffer_format(out, "<worksheet><sheetData>");
    for (int i = 0; i < 400; i++)
        buffer_format(out,
                      "<row r=\"%d\"><c r=\"A%d\"><v>%.2f</v></c><c r=\"B%d\"><v>%d</v></c></row>",
                      i + 1, i + 1, 0.02 * i, i + 1, i % 9);
    buffer_format(out, "</sheetData></worksheet>");
}

/* At every tenth byte (every 160th unless LONG), and one before the end: never a part as if it were
 * all. */
static void cut_everywhere(const struct buffer *whole)
{
    const size_t step = is_long() ? 10 : 160;
    struct error error;
    assert_false(whole->failed);
    for (size_t len = 1, more = 1; more > 0; len += more) {
        more = len + step < whole->len ? step : whole->len - 1 - len;
        struct recording *r = fixture_load(whole->data, len, "", &error);
        if (r || error.code != ERROR_IO || !error.text[0])
            fail_msg("%zu of %zu bytes: %s", len, whole->len, r ? "read" : error.text);
    }
}

TEST(a_container_that_is_cut_is_refused)
{
    struct buffer text = {0}, sheet = {0}, bytes = {0};
    if (!ARCHIVES || !XML) {
        skip();
        return;
    }
    put_long_table(&text);
    put_long_sheet(&sheet);
    put_gzip(&bytes, buffer_text(&text));
    cut_everywhere(&bytes);
    buffer_clear(&bytes);
    put_zip(&bytes, &(struct file){"Raw Data.csv", text.data}, 1);
    cut_everywhere(&bytes);
    buffer_clear(&bytes);
    put_workbook(&bytes, sheet.data);
    cut_everywhere(&bytes);
    /* without its last \n */
    const struct buffer document = {.data = (char[sizeof cmbl]){0}, .len = sizeof cmbl - 2};
    memcpy(document.data, cmbl, sizeof cmbl);
    cut_everywhere(&document);
    const struct buffer other = {.data = (char[sizeof labx]){0}, .len = sizeof labx - 2};
    memcpy(other.data, labx, sizeof labx);
    cut_everywhere(&other);
    buffer_free(&text);
    buffer_free(&sheet);
    buffer_free(&bytes);
}

TEST(archives_in_archives_are_refused)
{
    struct buffer inner = {0}, outer = {0};
    struct error error;
    if (!ARCHIVES || !XML) {
        skip();
        return;
    }
    put_zip(&inner, &(struct file){"Raw Data.csv", table}, 1);
    put_gzip(&outer, buffer_text(&inner));
    assert_true(refused(load_bytes(&outer, "", &error), &error, "inside an archive"));
    buffer_clear(&inner);
    buffer_clear(&outer);
    put_workbook(&inner, "<worksheet/>");
    put_gzip(&outer, buffer_text(&inner));
    assert_true(refused(load_bytes(&outer, "", &error), &error, "inside an archive"));
    buffer_clear(&outer);
    put_gzip(&outer, TEXT("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"));
    assert_true(refused(load_bytes(&outer, "", &error), &error, "inside an archive"));
    buffer_clear(&outer);
    put_zip(&outer, &(struct file){"inner.zip", "PK"}, 1);
    assert_true(refused(load_bytes(&outer, "", &error), &error, "without a table of text"));
    buffer_free(&inner);
    buffer_free(&outer);
}

TEST(documents_that_declare_a_type_or_nest_without_end_are_refused)
{
    static const char *const declared[] = {
        "<?xml version=\"1.0\"?><!DOCTYPE Document [<!ENTITY x SYSTEM "
        "\"file:///etc/passwd\">]><Document>&x;</Document>",
        "<?xml version=\"1.0\"?><!DOCTYPE Document [<!ENTITY % p SYSTEM \"http://localhost/\"> "
        "%p;]><Document/>",
        "<?xml version=\"1.0\"?><!DOCTYPE Document SYSTEM "
        "\"http://localhost/x.dtd\"><Document>1&x;2</Document>",
        "<?xml version=\"1.0\"?><!DOCTYPE Document [<!ATTLIST DataSet a CDATA "
        "\"x\">]><Document><DataSet/></Document>",
    };
    struct error error;
    struct buffer deep = {0};
    if (!XML) {
        skip();
        return;
    }
    for (size_t i = 0; i < COUNT_OF(declared); i++)
        assert_true(refused(fixture_load(declared[i], strlen(declared[i]), "", &error), &error,
                            "document type"));
    buffer_format(&deep, "<?xml version=\"1.0\"?><Document>");
    for (int i = 0; i < 2000000; i++)
        buffer_put(&deep, TEXT("<a>"));
    const long before = peak();
    assert_true(refused(load_bytes(&deep, "", &error), &error, "without end"));
    assert_true(peak() - before < 64 * 1024 || runs_under_sanitizer());
    buffer_free(&deep);
}

/* A megabyte of a word in 3000 cells, and rows of which only the last column is filled. */
TEST(workbooks_that_grow_without_bound_are_refused)
{
    struct buffer sheet = {0}, word = {0}, words = {0}, bytes = {0};
    struct error error;
    if (!ARCHIVES || !XML) {
        skip();
        return;
    }
    const long before = peak();
    buffer_format(&sheet, "<worksheet><sheetData>");
    for (int i = 1; i <= 60000; i++)
        buffer_format(&sheet, "<row r=\"%d\"><c r=\"ALL%d\"><v>1</v></c></row>", i, i);
    buffer_format(&sheet, "</sheetData></worksheet>");
    put_workbook(&bytes, sheet.data);
    assert_true(refused(load_bytes(&bytes, "", &error), &error, "times their size"));
    buffer_clear(&sheet);
    buffer_clear(&bytes);
    for (int i = 0; i < 1000000; i++)
        buffer_char(&word, 'A');
    buffer_format(&words, "<sst><si><t>%s</t></si></sst>", word.data);
    buffer_format(&sheet, "<worksheet><sheetData>");
    for (int i = 1; i <= 3000; i++)
        buffer_format(&sheet, "<row r=\"%d\"><c r=\"A%d\" t=\"s\"><v>0</v></c></row>", i, i);
    buffer_format(&sheet, "</sheetData></worksheet>");
    const struct file files[] = {
        {"xl/workbook.xml",
         "<workbook xmlns:r=\"x\"><sheets><sheet name=\"S\" r:id=\"rId1\"/></sheets></workbook>"},
        {"xl/_rels/workbook.xml.rels", "<Relationships><Relationship Id=\"rId1\" "
                                       "Target=\"worksheets/sheet1.xml\"/></Relationships>"},
        {"xl/sharedStrings.xml", words.data},
        {"xl/worksheets/sheet1.xml", sheet.data},
    };
    put_zip(&bytes, files, COUNT_OF(files));
    assert_true(refused(load_bytes(&bytes, "", &error), &error, "times their size"));
    /* 3 GB of words, 60 MB of blanks */
    assert_true(peak() - before < 200 * 1024 || runs_under_sanitizer());
    buffer_free(&sheet);
    buffer_free(&word);
    buffer_free(&words);
    buffer_free(&bytes);
}

/* A sheet that a workbook names 250 times is one table. */
TEST(a_sheet_named_again_is_read_once)
{
    struct buffer sheet = {0}, book = {0}, bytes = {0};
    struct error error;
    if (!ARCHIVES || !XML) {
        skip();
        return;
    }
    put_long_sheet(&sheet);
    buffer_format(&book, "<workbook xmlns:r=\"x\"><sheets>");
    for (int i = 0; i < 250; i++)
        buffer_format(&book, "<sheet name=\"S%d\" r:id=\"rId1\"/>", i);
    buffer_format(&book, "</sheets></workbook>");
    const struct file files[] = {
        {"xl/workbook.xml", book.data},
        {"xl/_rels/workbook.xml.rels", "<Relationships><Relationship Id=\"rId1\" "
                                       "Target=\"worksheets/sheet1.xml\"/></Relationships>"},
        {"xl/worksheets/sheet1.xml", sheet.data},
    };
    put_zip(&bytes, files, COUNT_OF(files));
    struct recording *r = load_bytes(&bytes, "", &error);
    if (!r)
        fail_msg("%s", error.text);
    assert_int_equal(r->rows, 400);
    assert_true(r->runs <= 1);
    recording_destroy(r);
    buffer_free(&sheet);
    buffer_free(&book);
    buffer_free(&bytes);
}

/* UTF-16 and then UTF-8, and the other way round. */
TEST(a_file_that_mixes_encodings_is_refused)
{
    struct buffer text = {0}, wide = {0}, both = {0};
    struct error error;
    put_long_table(&text);
    for (size_t i = 0; i < text.len; i++)
        put_number(&wide, (uint32_t)text.data[i], 2);
    buffer_put(&both, TEXT("\xFF\xFE"));
    buffer_put(&both, buffer_text(&wide));
    struct recording *r = load_bytes(&both, "", &error);
    if (!r)
        fail_msg("%s", error.text);
    assert_int_equal(r->rows, 400);
    recording_destroy(r);
    buffer_put(&both, (struct text){text.data + 23, text.len - 23});
    assert_true(refused(load_bytes(&both, "", &error), &error, "begins in UTF-16"));
    buffer_clear(&both);
    buffer_put(&both, buffer_text(&text));
    buffer_put(&both, buffer_text(&wide));
    assert_true(refused(load_bytes(&both, "", &error), &error, "NUL byte in line 402"));
    buffer_free(&text);
    buffer_free(&wide);
    buffer_free(&both);
}

RUN_TESTS(fixture_setup, fixture_teardown)
