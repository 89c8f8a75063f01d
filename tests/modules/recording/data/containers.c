/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Recordings inside of archives, workbooks and XML documents, all made here byte by byte; and such
 * files when they are damaged, locked or hostile. Built without libarchive, expat or FreeXL: each
 * has to be refused with the library's name.
 */
#include "modules/recording/data/archives.h"

#include <sys/resource.h>

static bool is_table(struct recording *recording, const struct error *error)
{
    const bool right = recording && recording->rows == 5 && near(recording->y[2], 0.035, 1e-15) &&
                       near(recording->t[4] - recording->t[0], 0.08, 1e-6);
    if (!right)
        print_message("not the table: %s\n", recording ? "other values" : error->text);
    return right;
}

/* ---- archives ---- */

TEST(a_gzip_file_is_read_as_what_is_in_it)
{
    struct buffer bytes = {0};
    struct error error;
    put_gzip(&bytes, text_of(table));
    struct recording *recording = load_bytes(&bytes, "", &error);
    if (!ARCHIVES) {
        assert_true(refused(recording, &error, "built without libarchive"));
    } else {
        assert_true(is_table(recording, &error));
        assert_string_equal(recording->container, "gzip");
        recording_destroy(recording);
        bytes.len -= 20; /* cut short */
        assert_true(refused(load_bytes(&bytes, "", &error), &error, "cut short"));
    }
    buffer_free(&bytes);
}

TEST(tables_of_a_zip_archive_are_runs)
{
    const struct file files[] = {{"meta/device.csv", "property,value\n1,2\n3,4\n5,6\n"},
                                 {"Remarks.txt", "nothing but words\n"},
                                 {"Raw Data.csv", table},
                                 {"Second.csv", "t [s];x [cm]\n0;1\n1;2\n2;4\n"}};
    struct buffer bytes = {0};
    struct error error;
    put_zip(&bytes, files, COUNT_OF(files));
    struct recording *recording = load_bytes(&bytes, "", &error);
    if (!ARCHIVES) {
        assert_true(refused(recording, &error, "built without libarchive"));
    } else {
        assert_true(is_table(recording, &error));
        assert_int_equal(recording->runs, 3);
        assert_string_equal(recording->run[recording->taken].name, "Raw Data");
        recording_destroy(recording);
        recording = load_bytes(&bytes, "run=Second", &error);
        assert_non_null(recording);
        assert_true(near(recording->y[2], 0.04, 0));
        recording_destroy(recording);
        assert_true(!load_bytes(&bytes, "run=Third", &error) &&
                    strstr(error.text, "no run 'Third'"));
        bytes.len = 60;
        assert_true(refused(load_bytes(&bytes, "", &error), &error, "cut short"));
    }
    buffer_free(&bytes);
}

TEST(an_archive_that_grows_without_bound_is_refused)
{
    struct buffer bytes = {0};
    struct error error;
    if (!ARCHIVES) {
        skip();
        return;
    }
    put_bomb(&bytes, 400000); /* 0.65 MB for 103 */
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    struct recording *recording = load_bytes(&bytes, "", &error);
    getrusage(RUSAGE_SELF, &after);
    assert_true(refused(recording, &error, "unpacks to more than"));
    assert_true(after.ru_maxrss - before.ru_maxrss < 160 * 1024); /* [KiB] */
    buffer_free(&bytes);
}

/* ---- XML ---- */

TEST(documents_of_instruments_are_read)
{
    const struct file files[] = {{"cmbl", cmbl}, {"labx", labx}};
    for (size_t i = 0; i < COUNT_OF(files); i++) {
        struct error error;
        struct recording *recording =
            fixture_load(files[i].text, strlen(files[i].text), "", &error);
        if (!XML) {
            assert_true(refused(recording, &error, "built without expat"));
            continue;
        }
        assert_true(is_table(recording, &error));
        assert_string_equal(recording->container, files[i].path);
        recording_destroy(recording);
    }
}

TEST(hostile_documents_are_refused)
{
    struct error error;
    static const char laughs[] =
        "<?xml version=\"1.0\"?>\n<!DOCTYPE Document [<!ENTITY a \"ha\"><!ENTITY b "
        "\"&a;&a;&a;&a;&a;&a;&a;&a;\">]>\n<Document><DataSet>&b;</DataSet></Document>";
    if (!XML) {
        skip();
        return;
    }
    assert_true(refused(fixture_load(laughs, strlen(laughs), "", &error), &error, "entities"));
    assert_true(refused(fixture_load(cmbl, 400, "", &error), &error, "not valid XML"));
    static const char other[] = "<?xml version=\"1.0\"?>\n<svg><path/></svg>\n";
    assert_true(
        refused(fixture_load(other, strlen(other), "", &error), &error, "neither Logger Pro"));
}

/* ---- workbooks ---- */

/* Workbooks with plain numbers, with a formula, with a heading in two runs of text, and with times
 * of day give a table; a build without libarchive or expat refuses them with an error. */
TEST(sheets_of_workbooks_are_read)
{
    static const char plain[] =
        "<worksheet><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" "
        "t=\"s\"><v>1</v></c></row>"
        "<row r=\"2\"><c r=\"A2\"><v>0</v></c><c r=\"B2\"><v>1.5</v></c></row>"
        "<row r=\"3\"><c r=\"A3\"><v>0.02</v></c><c r=\"B3\"><v>2.5</v></c></row>"
        "<row r=\"4\"><c r=\"A4\"><v>0.04</v></c><c r=\"B4\"><v>3.5</v></c></row>"
        "<row r=\"5\"><c r=\"A5\"><v>0.06</v></c><c r=\"B5\"><v>2.5</v></c></row>"
        "<row r=\"6\"><c r=\"A6\"><v>0.08</v></c><c "
        "r=\"B6\"><f>B2</f><v>1.5</v></c></row></sheetData></worksheet>";
    struct buffer bytes = {0};
    struct error error;
    put_workbook(&bytes, plain);
    struct recording *recording = load_bytes(&bytes, "", &error);
    if (!ARCHIVES || !XML) {
        assert_true(refused(recording, &error, "built without"));
    } else {
        assert_true(is_table(recording, &error));
        assert_string_equal(recording->container, "xlsx");
        assert_string_equal(recording->column[recording->value].name, "Position");
        recording_destroy(recording);
    }
    buffer_free(&bytes);
    if (!ARCHIVES || !XML)
        return;
    /* Times of day are numbers with a format; 0.25 is six o'clock. */
    buffer_clear(&bytes);
    struct buffer sheet = {0};
    buffer_format(&sheet,
                  "<worksheet><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" "
                  "t=\"inlineStr\"><is><r><t>Hei</t></r><r><t>ght (cm)</t></r></is></c></row>");
    for (int i = 0; i < 5; i++)
        buffer_format(
            &sheet,
            "<row r=\"%d\"><c r=\"A%d\" s=\"1\"><v>%.17g</v></c><c r=\"B%d\"><v>%g</v></c></row>",
            i + 2, i + 2, 0.25 + 0.02 * i / 86400, i + 2, i < 3 ? 1.5 + i : 5.5 - i);
    buffer_format(&sheet, "</sheetData></worksheet>");
    put_workbook(&bytes, sheet.data);
    recording = load_bytes(&bytes, "", &error);
    assert_true(is_table(recording, &error));
    assert_string_equal(recording->column[recording->value].name, "Height");
    recording_destroy(recording);
    buffer_free(&sheet);
    buffer_free(&bytes);
}

TEST(an_old_workbook_is_refused_where_it_is_damaged)
{
    struct error error;
    static const char start[] = "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1 and nothing behind it";
    struct recording *recording = fixture_load(start, sizeof start, "", &error);
#ifdef HAVE_FREEXL
    assert_true(refused(recording, &error, "not a readable Excel workbook"));
#else
    assert_true(refused(recording, &error, "built without FreeXL"));
#endif
}

/* A file with a hole of 10 GB takes no room on the disk and must take none in memory. */
TEST(a_sparse_file_is_refused_by_its_size)
{
    struct error error = {0};
    const char *path = fixture_path("sparse.csv");
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    const bool sparse = ftruncate(fileno(file), (off_t)10 << 30) == 0;
    fclose(file);
    if (!sparse) {
        skip();
        return;
    }
    assert_true(refused(recording_load(path, NULL, &error), &error, "at most"));
}

RUN_TESTS(fixture_setup, fixture_teardown)
