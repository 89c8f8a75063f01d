/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Recordings inside of archives, workbooks and XML documents, all made here byte by byte; and such files when they are
 * damaged, locked or hostile. Built without libarchive, expat or FreeXL: each has to be refused with the library's
 * name.
 */
#include "data_fixture.h"

#include <sys/resource.h>
#include <time.h>

#ifdef HAVE_ARCHIVE
#define ARCHIVES true
#else
#define ARCHIVES false
#endif
#ifdef HAVE_EXPAT
#define XML true
#else
#define XML false
#endif

static const char table[] = "Time (s),Position (cm)\n0.00,1.5\n0.02,2.5\n0.04,3.5\n0.06,2.5\n0.08,1.5\n";

/* ---- writers: entries and streams that are stored, not compressed ---- */

static uint32_t crc32(struct text bytes)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < bytes.len; i++) {
        crc ^= (unsigned char)bytes.at[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

static void put_number(struct buffer *out, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        buffer_char(out, (char)((uint64_t)value >> (8 * i) & 0xFF));
}

static void put_gzip(struct buffer *out, struct text bytes)
{
    buffer_put(out, (struct text){"\x1F\x8B\x08\0\0\0\0\0\0\xFF", 10});
    for (size_t at = 0; at < bytes.len;) {
        const size_t len = bytes.len - at < 65535 ? bytes.len - at : 65535;
        buffer_char(out, at + len == bytes.len);
        put_number(out, (uint32_t)len, 2);
        put_number(out, ~(uint32_t)len, 2);
        buffer_put(out, (struct text){bytes.at + at, len});
        at += len;
    }
    put_number(out, crc32(bytes), 4);
    put_number(out, (uint32_t)bytes.len, 4);
}

struct file {
    const char *path, *text;
};

static void put_zip(struct buffer *out, const struct file *file, size_t files)
{
    struct buffer directory = {0};
    for (size_t i = 0; i < files; i++) {
        const struct text bytes = text_of(file[i].text);
        const uint32_t at = (uint32_t)out->len, len = (uint32_t)bytes.len, name = (uint32_t)strlen(file[i].path);
        struct buffer common = {0};
        put_number(&common, 20, 2);
        put_number(&common, 0, 8);
        put_number(&common, crc32(bytes), 4);
        put_number(&common, len, 4);
        put_number(&common, len, 4);
        put_number(&common, name, 2);
        put_number(&common, 0, 2);
        buffer_put(out, (struct text){"PK\3\4", 4});
        buffer_put(out, buffer_text(&common));
        buffer_format(out, "%s", file[i].path);
        buffer_put(out, bytes);
        buffer_put(&directory, (struct text){"PK\1\2", 4});
        put_number(&directory, 20, 2);
        buffer_put(&directory, buffer_text(&common));
        put_number(&directory, 0, 4);
        put_number(&directory, 0, 2);
        put_number(&directory, 0, 4);
        put_number(&directory, at, 4);
        buffer_format(&directory, "%s", file[i].path);
        buffer_free(&common);
    }
    const uint32_t start = (uint32_t)out->len;
    buffer_put(out, buffer_text(&directory));
    buffer_put(out, (struct text){"PK\5\6\0\0\0\0", 8});
    put_number(out, (uint32_t)files, 2);
    put_number(out, (uint32_t)files, 2);
    put_number(out, (uint32_t)directory.len, 4);
    put_number(out, start, 4);
    put_number(out, 0, 2);
    buffer_free(&directory);
}

static struct recording *load_bytes(const struct buffer *bytes, const char *options, struct error *error)
{
    assert_false(bytes->failed);
    return fixture_load(bytes->data, bytes->len, options, error);
}

static bool refused(struct recording *recording, const struct error *error, const char *part)
{
    const bool right = !recording && error->code == ERROR_IO && strstr(error->text, part);
    if (!right)
        print_message("expected a refusal with '%s', got %s\n", part, recording ? "a recording" : error->text);
    recording_destroy(recording);
    return right;
}

static bool is_table(struct recording *recording, const struct error *error)
{
    const bool right = recording && recording->rows == 5 && near(recording->y[2], 0.035, 1e-15) &&
                       near(recording->t[4] - recording->t[0], 0.08, 1e-6);
    if (!right)
        print_message("not the table: %s\n", recording ? "other values" : error->text);
    return right;
}

/* ---- archives ---- */

static void a_gzip_file_is_read_as_what_is_in_it(void **state)
{
    (void)state;
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

static void tables_of_a_zip_archive_are_runs(void **state)
{
    (void)state;
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
        assert_true(!load_bytes(&bytes, "run=Third", &error) && strstr(error.text, "no run 'Third'"));
        bytes.len = 60;
        assert_true(refused(load_bytes(&bytes, "", &error), &error, "cut short"));
    }
    buffer_free(&bytes);
}

/* Deflate, fixed codes: a literal, then copies of 258 bytes from 1 back; 13 bits for each. */
static void put_bomb(struct buffer *out, size_t copies)
{
    uint64_t bits = 0;
    int count = 0;
    buffer_put(out, (struct text){"\x1F\x8B\x08\0\0\0\0\0\0\xFF", 10});
#define PUT(value, n)                                                                                                  \
    for (bits |= (uint64_t)(value) << count, count += (n); count >= 8; count -= 8, bits >>= 8)                         \
        buffer_char(out, (char)(bits & 0xFF));
    PUT(3, 3)    /* the last block, fixed codes */
    PUT(0x46, 8) /* a literal: which one does not matter */
    for (size_t i = 0; i < copies; i++) {
        PUT(0xA3, 8) /* length 258: 11000101, its first bit first */
        PUT(0, 5)
    }
    PUT(0, 7)
    PUT(0, 7)
#undef PUT
    put_number(out, 0, 8);
}

static void an_archive_that_grows_without_bound_is_refused(void **state)
{
    (void)state;
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

static const char cmbl[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<Document>\n<DataSet>\n<DataSetName>Latest</DataSetName>\n"
    "<DataColumn>\n<DataObjectName>Time</DataObjectName>\n<DataObjectShortName>t</DataObjectShortName>\n"
    "<ColumnUnits>s</ColumnUnits>\n<ColumnCells>\n0\n0.02\n0.04\n0.06\n0.08\n</ColumnCells>\n</DataColumn>\n"
    "<DataColumn>\n<DataObjectName>Position</DataObjectName>\n<ColumnUnits>cm</ColumnUnits>\n"
    "<ColumnCells>\n1.5\n2.5\n3.5\n2.5\nZ\n</ColumnCells>\n</DataColumn>\n</DataSet>\n</Document>\n";

static const char labx[] =
    "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<cassylab version=\"2.0\"><allchannels><channels count=\"2\">"
    "<channel><quantity>Zeit</quantity><symbol>t</symbol><unit>s</unit><values count=\"5\"><value>0</value>"
    "<value>0.02</value><value>0.04</value><value>0.06</value><value>0.08</value></values></channel>"
    "<channel><quantity>Weg</quantity><symbol>s</symbol><unit>cm</unit><values count=\"5\"><value>1.5</value>"
    "<value>2.5</value><value>3.5</value><value>2.5</value><value>1.5</value></values></channel>"
    "</channels></allchannels></cassylab>\n";

static void documents_of_instruments_are_read(void **state)
{
    (void)state;
    const struct file files[] = {{"cmbl", cmbl}, {"labx", labx}};
    for (size_t i = 0; i < COUNT_OF(files); i++) {
        struct error error;
        struct recording *recording = fixture_load(files[i].text, strlen(files[i].text), "", &error);
        if (!XML) {
            assert_true(refused(recording, &error, "built without expat"));
            continue;
        }
        assert_true(is_table(recording, &error));
        assert_string_equal(recording->container, files[i].path);
        recording_destroy(recording);
    }
}

static void hostile_documents_are_refused(void **state)
{
    (void)state;
    struct error error;
    static const char laughs[] = "<?xml version=\"1.0\"?>\n<!DOCTYPE Document [<!ENTITY a \"ha\"><!ENTITY b "
                                 "\"&a;&a;&a;&a;&a;&a;&a;&a;\">]>\n<Document><DataSet>&b;</DataSet></Document>";
    if (!XML) {
        skip();
        return;
    }
    assert_true(refused(fixture_load(laughs, strlen(laughs), "", &error), &error, "entities"));
    assert_true(refused(fixture_load(cmbl, 400, "", &error), &error, "no valid XML"));
    static const char other[] = "<?xml version=\"1.0\"?>\n<svg><path/></svg>\n";
    assert_true(refused(fixture_load(other, strlen(other), "", &error), &error, "neither Logger Pro"));
}

/* ---- workbooks ---- */

static void put_workbook(struct buffer *bytes, const char *sheet)
{
    const struct file files[] = {
        {"[Content_Types].xml", "<Types/>"},
        {"xl/workbook.xml", "<workbook xmlns:r=\"x\"><sheets><sheet name=\"Swing\" sheetId=\"1\" r:id=\"rId1\"/>"
                            "</sheets></workbook>"},
        {"xl/_rels/workbook.xml.rels", "<Relationships><Relationship Id=\"rId1\" Target=\"worksheets/sheet1.xml\"/>"
                                       "</Relationships>"},
        {"xl/styles.xml", "<styleSheet><numFmts><numFmt numFmtId=\"164\" formatCode=\"hh:mm:ss.000\"/></numFmts>"
                          "<cellStyleXfs><xf numFmtId=\"0\"/></cellStyleXfs><cellXfs><xf numFmtId=\"0\"/>"
                          "<xf numFmtId=\"164\"/></cellXfs></styleSheet>"},
        {"xl/sharedStrings.xml",
         "<sst><si><t>Time (s)</t></si><si><r><t>Position</t></r><r><t> (cm)</t></r></si></sst>"},
        {"xl/worksheets/sheet1.xml", sheet},
    };
    put_zip(bytes, files, COUNT_OF(files));
}

static void sheets_of_workbooks_are_read(void **state)
{
    (void)state;
    static const char plain[] =
        "<worksheet><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"s\"><v>1</v></c></row>"
        "<row r=\"2\"><c r=\"A2\"><v>0</v></c><c r=\"B2\"><v>1.5</v></c></row>"
        "<row r=\"3\"><c r=\"A3\"><v>0.02</v></c><c r=\"B3\"><v>2.5</v></c></row>"
        "<row r=\"4\"><c r=\"A4\"><v>0.04</v></c><c r=\"B4\"><v>3.5</v></c></row>"
        "<row r=\"5\"><c r=\"A5\"><v>0.06</v></c><c r=\"B5\"><v>2.5</v></c></row>"
        "<row r=\"6\"><c r=\"A6\"><v>0.08</v></c><c r=\"B6\"><f>B2</f><v>1.5</v></c></row></sheetData></worksheet>";
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
    buffer_format(&sheet, "<worksheet><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"s\">"
                          "<v>1</v></c></row>");
    for (int i = 0; i < 5; i++)
        buffer_format(&sheet, "<row r=\"%d\"><c r=\"A%d\" s=\"1\"><v>%.17g</v></c><c r=\"B%d\"><v>%g</v></c></row>",
                      i + 2, i + 2, 0.25 + 0.02 * i / 86400, i + 2, i < 3 ? 1.5 + i : 5.5 - i);
    buffer_format(&sheet, "</sheetData></worksheet>");
    put_workbook(&bytes, sheet.data);
    recording = load_bytes(&bytes, "", &error);
    assert_true(is_table(recording, &error));
    recording_destroy(recording);
    buffer_free(&sheet);
    buffer_free(&bytes);
}

static void an_old_workbook_is_refused_where_it_is_damaged(void **state)
{
    (void)state;
    struct error error;
    static const char start[] = "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1 and nothing behind it";
    struct recording *recording = fixture_load(start, sizeof start, "", &error);
#ifdef HAVE_FREEXL
    assert_true(refused(recording, &error, "no Excel workbook"));
#else
    assert_true(refused(recording, &error, "built without FreeXL"));
#endif
}

/* A file with a hole of 10 GB takes no room on the disk and must take none in memory. */
static void a_sparse_file_is_refused_by_its_size(void **state)
{
    (void)state;
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_gzip_file_is_read_as_what_is_in_it),
        cmocka_unit_test(tables_of_a_zip_archive_are_runs),
        cmocka_unit_test(an_archive_that_grows_without_bound_is_refused),
        cmocka_unit_test(documents_of_instruments_are_read),
        cmocka_unit_test(hostile_documents_are_refused),
        cmocka_unit_test(sheets_of_workbooks_are_read),
        cmocka_unit_test(an_old_workbook_is_refused_where_it_is_damaged),
        cmocka_unit_test(a_sparse_file_is_refused_by_its_size),
    };
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
