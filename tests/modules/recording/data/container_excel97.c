/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Workbooks of Excel 97 (.xls), written here record by record: BIFF8 in a compound file ([MS-XLS],
 * [MS-CFB]). What was written is read; damaged ones are refused.
 */
#include "modules/recording/data/archives.h"

enum {
    SECTOR = 512,
    BIFF8 = 0x0600,
    FREE_SECTOR = -1,
    END_OF_CHAIN = -2,
    FAT_SECTOR = -3,
    RECORD_BOF = 0x0809,
    RECORD_EOF = 0x000A,
    RECORD_CODE_PAGE = 0x0042,
    RECORD_DATE_MODE = 0x0022,
    RECORD_XF = 0x00E0,
    RECORD_SHEET = 0x0085,
    RECORD_STRINGS = 0x00FC,
    RECORD_DIMENSIONS = 0x0200,
    RECORD_STRING_CELL = 0x00FD,
    RECORD_NUMBER = 0x0203,
    RECORD_RK = 0x027E,
    SHEET_GLOBALS = 0x0005,
    SHEET_CELLS = 0x0010
};

static void put_record(struct buffer *out, uint32_t kind, struct buffer *body)
{
    put_number(out, kind, 2);
    put_number(out, (uint32_t)body->len, 2);
    buffer_put(out, buffer_text(body));
    buffer_clear(body);
}

static void put_start(struct buffer *out, uint32_t what)
{
    struct buffer body = {0};
    put_number(&body, BIFF8, 2);
    put_number(&body, what, 2);
    put_number(&body, 0x07CC0DBB, 4); /* build, year */
    put_number(&body, 0, 4);
    put_number(&body, BIFF8, 4);
    put_record(out, RECORD_BOF, &body);
    buffer_free(&body);
}

static void put_cell_start(struct buffer *body, int row, int column)
{
    put_number(body, (uint32_t)row, 2);
    put_number(body, (uint32_t)column, 2);
    put_number(body, 0, 2); /* format */
}

static void put_real(struct buffer *out, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    put_number(out, (uint32_t)bits, 4);
    put_number(out, (uint32_t)(bits >> 32), 4);
}

/* Words in the first row; times as numbers, values as RK: integers divided by 100. */
static void put_sheet(struct buffer *out, const double *t, const int *hundredths, int rows,
                      int claimed)
{
    struct buffer body = {0};
    put_start(out, SHEET_CELLS);
    put_number(&body, 0, 4);
    put_number(&body, (uint32_t)claimed, 4);
    put_number(&body, 0, 2);
    put_number(&body, 2, 2);
    put_number(&body, 0, 2);
    put_record(out, RECORD_DIMENSIONS, &body);
    for (int column = 0; column < 2; column++) {
        put_cell_start(&body, 0, column);
        put_number(&body, (uint32_t)column, 4);
        put_record(out, RECORD_STRING_CELL, &body);
    }
    for (int i = 0; i < rows; i++) {
        put_cell_start(&body, i + 1, 0);
        put_real(&body, t[i]);
        put_record(out, RECORD_NUMBER, &body);
        put_cell_start(&body, i + 1, 1);
        put_number(&body, (uint32_t)hundredths[i] << 2 | 3, 4);
        put_record(out, RECORD_RK, &body);
    }
    put_record(out, RECORD_EOF, &body);
    buffer_free(&body);
}

/* words: two or three, of which the last may be empty. */
static void put_globals(struct buffer *out, uint32_t sheet_at, size_t count)
{
    static const char *const words[] = {"Time (s)", "Position (cm)", ""};
    struct buffer body = {0};
    put_start(out, SHEET_GLOBALS);
    put_number(&body, 1200, 2); /* UTF-16 */
    put_record(out, RECORD_CODE_PAGE, &body);
    put_number(&body, 0, 2); /* days since 1900 */
    put_record(out, RECORD_DATE_MODE, &body);
    buffer_put(&body, (struct text){(char[20]){0}, 20});
    put_record(out, RECORD_XF, &body);
    put_number(&body, sheet_at, 4);
    put_number(&body, 0, 2); /* visible, a worksheet */
    put_number(&body, 5, 1);
    put_number(&body, 0, 1); /* one byte a letter */
    buffer_put(&body, TEXT("Swing"));
    put_record(out, RECORD_SHEET, &body);
    put_number(&body, (uint32_t)count, 4);
    put_number(&body, (uint32_t)count, 4);
    for (size_t i = 0; i < count; i++) {
        put_number(&body, (uint32_t)strlen(words[i]), 2);
        put_number(&body, 0, 1);
        buffer_put(&body, text_of(words[i]));
    }
    put_record(out, RECORD_STRINGS, &body);
    put_record(out, RECORD_EOF, &body);
    buffer_free(&body);
}

static void put_entry(struct buffer *out, const char *name, uint32_t kind, int child, int start,
                      size_t size)
{
    const size_t len = strlen(name);
    for (size_t i = 0; i < 32; i++)
        put_number(out, i < len ? (uint32_t)(unsigned char)name[i] : 0, 2);
    put_number(out, len ? (uint32_t)(2 * len + 2) : 0, 2);
    put_number(out, kind | 1 << 8, 2); /* black */
    put_number(out, 0xFFFFFFFFu, 4);   /* no neighbours */
    put_number(out, 0xFFFFFFFFu, 4);
    put_number(out, (uint32_t)child, 4);
    buffer_put(out, (struct text){(char[36]){0}, 36}); /* class, state, times */
    put_number(out, (uint32_t)start, 4);
    put_number(out, (uint32_t)size, 4);
    put_number(out, 0, 4);
}

/* Header, one sector of allocation table, one of directory, then the stream. */
static void put_compound(struct buffer *out, struct text stream)
{
    const int sectors = (int)((stream.len + SECTOR - 1) / SECTOR), entries = SECTOR / 4;
    assert_true(sectors + 2 <= entries);
    buffer_put(out, (struct text){"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", 8});
    buffer_put(out, (struct text){(char[16]){0}, 16});
    put_number(out, 0x0003003E, 4); /* versions */
    put_number(out, 0x0009FFFE, 4); /* byte order; sectors of 2^9 bytes */
    put_number(out, 6, 2);
    buffer_put(out, (struct text){(char[10]){0}, 10});
    put_number(out, 1, 4); /* sectors of the allocation table */
    put_number(out, 1, 4); /* the directory's first */
    put_number(out, 0, 4);
    put_number(out, 4096, 4);
    put_number(out, (uint32_t)END_OF_CHAIN, 4);
    put_number(out, 0, 4);
    put_number(out, (uint32_t)END_OF_CHAIN, 4);
    put_number(out, 0, 4);
    for (int i = 0; i < 109; i++)
        put_number(out, i == 0 ? 0 : (uint32_t)FREE_SECTOR, 4);
    for (int i = 0; i < entries; i++)
        put_number(out,
                   (uint32_t)(i == 0                       ? FAT_SECTOR
                              : i == 1 || i == sectors + 1 ? END_OF_CHAIN
                              : i <= sectors               ? i + 1
                                                           : FREE_SECTOR),
                   4);
    put_entry(out, "Root Entry", 5, 1, END_OF_CHAIN, 0);
    put_entry(out, "Workbook", 2, FREE_SECTOR, 2, (size_t)sectors * SECTOR);
    put_entry(out, "", 0, FREE_SECTOR, 0, 0);
    put_entry(out, "", 0, FREE_SECTOR, 0, 0);
    buffer_put(out, stream);
    while (out->len % SECTOR)
        buffer_char(out, '\0');
}

enum { ROWS = 200 };

/* claimed: rows that the sheet says it has. */
static void put_old_workbook(struct buffer *out, int claimed, size_t words)
{
    struct buffer stream = {0};
    double t[ROWS];
    int hundredths[ROWS];
    for (int i = 0; i < ROWS; i++) {
        t[i] = 0.02 * i;
        hundredths[i] = 150 + 7 * (i % 31);
    }
    put_globals(&stream, 0, words);
    const uint32_t at = (uint32_t)stream.len;
    buffer_clear(&stream);
    put_globals(&stream, at, words);
    put_sheet(&stream, t, hundredths, ROWS, claimed);
    put_compound(out, buffer_text(&stream));
    assert_false(out->failed);
    buffer_free(&stream);
}

TEST(a_workbook_of_excel_97_is_read)
{
    struct buffer bytes = {0};
    struct error error;
    put_old_workbook(&bytes, ROWS + 1, 2);
    struct recording *r = load_bytes(&bytes, "", &error);
#ifdef HAVE_FREEXL
    if (!r)
        fail_msg("%s", error.text);
    assert_string_equal(r->container, "xls");
    assert_string_equal(r->column[r->value].name, "Position");
    assert_int_equal(r->rows, ROWS);
    for (int i = 0; i < ROWS; i++)
        if (!near(r->t[i], 0.02 * i, 1e-12) || !near(r->y[i], 1e-4 * (150 + 7 * (i % 31)), 1e-15))
            fail_msg("row %d: %.17g %.17g", i, r->t[i], r->y[i]);
    recording_destroy(r);
#else
    assert_true(refused(r, &error, "built without FreeXL"));
#endif
    buffer_free(&bytes);
}

/* FreeXL 1.0.6 opens such a workbook without an error and without a handle; another version may
 * read it. */
TEST(an_empty_word_is_read_or_named)
{
    struct buffer bytes = {0};
    struct error error;
    put_old_workbook(&bytes, ROWS + 1, 3);
    struct recording *r = load_bytes(&bytes, "", &error);
#ifdef HAVE_FREEXL
    if (r) {
        print_message("this FreeXL reads it\n");
        assert_int_equal(r->rows, ROWS);
        recording_destroy(r);
    } else {
        assert_int_equal(error.code, ERROR_IO);
        assert_non_null(strstr(error.text, "FreeXL cannot read"));
        assert_non_null(strstr(error.hint, "export CSV"));
    }
#else
    assert_true(refused(r, &error, "built without FreeXL"));
#endif
    buffer_free(&bytes);
}

/* Cut anywhere, and with any word of its tables of sectors replaced: refused, or the rows that are
 * left are true. */
TEST(damaged_workbooks_of_excel_97_do_no_harm)
{
    struct buffer whole = {0};
    struct error error;
    put_old_workbook(&whole, ROWS + 1, 2);
    for (size_t part = 1; part < 16; part++) {
        const struct buffer cut = {.data = whole.data, .len = whole.len * part / 16};
        struct recording *r = load_bytes(&cut, "", &error);
#ifdef HAVE_FREEXL
        if (r)
            fail_msg("%zu sixteenths are read", part);
        assert_int_equal(error.code, ERROR_IO);
#else
        assert_true(refused(r, &error, "built without FreeXL"));
#endif
    }
    static const uint32_t wrong[] = {0, 1, 2, 0x7FFFFFFF, 0xFFFFFFFE};
    for (size_t at = SECTOR; at < SECTOR + 4 * 20; at += 4)
        for (size_t k = 0; k < COUNT_OF(wrong); k++) {
            struct buffer bytes = {0};
            buffer_put(&bytes, buffer_text(&whole));
            for (int i = 0; i < 4; i++)
                bytes.data[at + (size_t)i] = (char)(wrong[k] >> (8 * i) & 0xFF);
            struct recording *r = load_bytes(&bytes, "", &error);
            assert_true(r || error.code == ERROR_IO);
            for (size_t i = 0; r && i < r->rows; i++)
                assert_true(isfinite(r->t[i]));
            recording_destroy(r);
            buffer_free(&bytes);
        }
    buffer_free(&whole);
}

RUN_TESTS(fixture_setup, fixture_teardown)
