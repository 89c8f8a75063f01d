/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Files that hold no table, however large they say they are: refused from their beginning, in
 * milliseconds, with little memory. Sparse files: nothing of what they claim is on the disk.
 */
#include "modules/recording/data/archives.h"
#include "unit/cpu_time.h"

#include <sys/resource.h>
#include <sys/stat.h>

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED true
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED true
#endif
#endif
#ifndef SANITIZED
#define SANITIZED false
#endif

#define MIB ((size_t)1 << 20)

static long peak(void) /* [KiB] of memory, ever */
{
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return usage.ru_maxrss;
}

/* Refused with `part` in the reason, within 0.2 s of work (a release needs a quarter) and 48 MiB.
 */
static void refused_at_once(const char *path, const char *part)
{
    struct error error = {0};
    const long before = peak();
    const int64_t start = cpu_ns();
    struct recording *r = recording_load(path, NULL, &error);
    const double seconds = 1e-9 * (double)(cpu_ns() - start);
    assert_true(refused(r, &error, part));
    if (!SANITIZED && (seconds > 0.2 || peak() - before > 48 * 1024))
        fail_msg("%s: %.3f s, %ld KiB more", part, seconds, peak() - before);
}

static const char *sparse(const char *head, size_t len, size_t size)
{
    const char *path = fixture_file("sparse", head, len);
    assert_int_equal(truncate(path, (off_t)size), 0);
    return path;
}

TEST(sparse_files_are_refused_from_their_beginning)
{
    static const struct {
        const char *head;
        size_t len, mebibytes;
        const char *part;
    } cases[] = {
        {"", 0, 10240, "at most 1073741824 are read"},
        {"", 0, 900, "NUL byte in line 1, column 1"},
        {table, sizeof table - 1, 900, "NUL byte in line 7, column 1"},
        {"\xFF\xFEt\0,\0y\0\n\0", 10, 900, "NUL character at byte 11"},
        {"\xFE\xFF\0t\0\n", 6, 900, "NUL character at byte 7"},
        {"PK\3\4", 4, 900, "of archives, workbooks and XML documents at most"},
        {"\x1F\x8B\x08", 3, 900, "of archives, workbooks and XML documents at most"},
        {"\xD0\xCF\x11\xE0", 4, 900, "of archives, workbooks and XML documents at most"},
        {"<?xml version=\"1.0\"?>", 21, 900, "of archives, workbooks and XML documents at most"},
        {"\n\n <Document>", 13, 60, "NUL byte in line 3"},
        {"%PDF-1.4\n", 9, 900, "a PDF document"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        refused_at_once(sparse(cases[i].head, cases[i].len, cases[i].mebibytes * MIB),
                        cases[i].part);
}

TEST(devices_and_pipes_are_refused)
{
    refused_at_once("/dev/zero", "NUL byte in line 1, column 1");
    refused_at_once("/dev/urandom", "is not a text file");
    refused_at_once("/dev/null", "is empty");
    refused_at_once(fixture_folder, "it is a directory");
    const char *path = fixture_path("pipe");
    assert_int_equal(mkfifo(path, 0600), 0);
    refused_at_once(path, "no program writes to it");
}

/* 64 MB of the same again and again. */
static const char *repeated(const char *head, const char *again)
{
    enum { SIZE = 64 << 20 };
    const char *path = fixture_path("large");
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    char piece[65536];
    const size_t len = strlen(again), whole = sizeof piece / len * len;
    for (size_t i = 0; i < whole; i++)
        piece[i] = again[i % len];
    fputs(head, file);
    for (size_t size = 0; size < SIZE; size += whole)
        assert_int_equal(fwrite(piece, 1, whole, file), whole);
    assert_int_equal(fclose(file), 0);
    return path;
}

TEST(text_without_a_table_is_refused_from_its_beginning)
{
    refused_at_once(repeated("", "\n"), "no table of numbers");
    refused_at_once(repeated("", "# a remark\n"), "no table of numbers");
    refused_at_once(repeated("", "a word\n"), "no table of numbers");
    refused_at_once(repeated("", "a"), "no table starts there");
    refused_at_once(repeated("", "1,"), "more than 1024 columns");
    refused_at_once(repeated(table, "1"), "the line that begins at byte 69 is longer");
}

/* A stream that goes on: what came out of how much is known all the time. */
TEST(a_bomb_is_told_by_what_went_in)
{
    struct buffer bytes = {0};
    if (!ARCHIVES) {
        skip();
        return;
    }
    put_bomb(&bytes, 4000000); /* 1 GB from 6.5 MB */
    refused_at_once(fixture_file("bomb.gz", bytes.data, bytes.len),
                    "unpacks to more than 64 times its size");
    buffer_free(&bytes);
}

TEST(documents_without_end_are_refused)
{
    struct buffer bytes = {0};
    struct error error;
    if (!XML) {
        skip();
        return;
    }
    buffer_format(&bytes, "<?xml version=\"1.0\"?><Document><");
    for (int i = 0; i < 20000000; i++)
        buffer_char(&bytes, 'a');
    assert_true(refused(load_bytes(&bytes, "", &error), &error, "contains a name of more than"));
    buffer_clear(&bytes);
    buffer_format(&bytes, "<?xml version=\"1.0\"?><Document>");
    for (int i = 0; i < 1000000; i++)
        buffer_put(&bytes, TEXT("<a/>"));
    const int64_t start = cpu_ns();
    assert_true(refused(load_bytes(&bytes, "", &error), &error, "neither Logger Pro's"));
    assert_true(SANITIZED || cpu_ns() - start < 200000000);
    buffer_free(&bytes);
}

/* Text of any size whose table begins early is read as before: its end is not needed to know it. */
TEST(a_large_table_is_read)
{
    struct buffer text = {0};
    struct error error;
    buffer_put(&text, TEXT("Time (s),Position (cm)\n"));
    for (int i = 0; i < 400000; i++)
        buffer_format(&text, "%.2f,%.3f\n", 0.02 * i, 20 + 5 * (i * 7 % 13) / 13.0);
    assert_true(text.len > 5 * MIB);
    struct recording *r = load_bytes(&text, "", &error);
    if (!r)
        fail_msg("%s", error.text);
    assert_int_equal(r->rows, 400000);
    recording_destroy(r);
    buffer_free(&text);
}

RUN_TESTS(fixture_setup, fixture_teardown)
