/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading files whole with a limit, and writing them: what the user is told, what is on the disk
 * afterwards. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Every test runs in a new folder that is the current one. */

static int enter_folder(void **state)
{
    const char *base = getenv("TMPDIR");
    char *folder = malloc(256);
    if (!folder)
        return -1;
    snprintf(folder, 256, "%s/hooke-file-XXXXXX", base && *base ? base : "/tmp");
    *state = folder;
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state)
{
    static const char *const names[] = {"a", "b", "fifo", "link", "inner/a", "inner/out", "inner"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (unlink(names[i]) != 0)
            rmdir(names[i]);
    /* not empty if a temporary file was left behind */
    const int result = chdir("/") == 0 ? rmdir(*state) : -1;
    free(*state);
    return result;
}

static bool put(const char *path, const char *content, struct write_policy policy,
                struct error *error)
{
    struct writer writer;
    *error = (struct error){0};
    if (!writer_open(&writer, path, policy, error))
        return false;
    writer_put(&writer, text_of(content));
    return writer_commit(&writer, error);
}

static const struct write_policy gentle = {.force = false}, force = {.force = true},
                                 confine = {.confine = true};

static void assert_content(const char *path, const char *expected)
{
    struct buffer b = {0};
    struct error error = {0};
    if (!file_read(path, 1u << 24, &b, &error))
        fail_msg("%s", error.text);
    assert_string_equal(b.data, expected);
    buffer_free(&b);
}

static void written_files_are_read_back(void **state)
{
    (void)state;
    struct error error;
    assert_true(put("a", "", gentle, &error));
    assert_content("a", "");
    assert_true(put("./b", "one\ntwo\n", gentle, &error));
    assert_content("b", "one\ntwo\n");
    assert_int_equal(error.code, ERROR_NONE);
}

static void large_files_are_whole(void **state)
{
    (void)state;
    struct error error;
    struct writer writer;
    char *big = malloc(300001);
    struct buffer expected = {0}, b = {0};
    assert_non_null(big);
    memset(big, 'y', 300000);
    assert_true(writer_open(&writer, "a", gentle, &error));
    for (size_t len = 0; len <= 300000; len = len * 3 + 1) {
        writer_put(&writer, (struct text){big, len});
        writer_put(&writer, TEXT("\n"));
        buffer_put(&expected, (struct text){big, len});
        buffer_char(&expected, '\n');
    }
    assert_true(writer_commit(&writer, &error));
    assert_true(file_read("a", SIZE_MAX, &b, &error));
    assert_true(text_equal(buffer_text(&b), buffer_text(&expected)));
    buffer_free(&b);
    buffer_free(&expected);
    free(big);
}

static void nothing_is_there_before_commit(void **state)
{
    (void)state;
    struct error error = {0};
    struct writer writer;
    assert_true(writer_open(&writer, "a", gentle, &error));
    writer_put(&writer, TEXT("secret"));
    assert_int_equal(access("a", F_OK), -1);
    writer_abandon(&writer);
    writer_abandon(&writer); /* harmless */
    assert_int_equal(access("a", F_OK), -1);
    struct writer zeroed = {0};
    writer_abandon(&zeroed);
    assert_int_equal(fcntl(0, F_GETFD) < 0, 0); /* did not close descriptor 0 */
}

static void an_existing_file_needs_force(void **state)
{
    (void)state;
    struct error error;
    assert_true(put("a", "old", gentle, &error));
    assert_false(put("a", "new", gentle, &error));
    assert_int_equal(error.code, ERROR_IO);
    assert_string_equal(error.text, "a exists; add --force to replace it");
    assert_content("a", "old");
    assert_true(put("a", "new", force, &error));
    assert_content("a", "new");
    assert_true(put("b", "new", force, &error)); /* force does not need an old file */
    assert_content("b", "new");
}

static void one_created_meanwhile_is_kept(void **state)
{
    (void)state;
    struct error error = {0};
    struct writer writer;
    assert_true(writer_open(&writer, "a", gentle, &error));
    writer_put(&writer, TEXT("mine"));
    struct error other;
    assert_true(put("a", "theirs", gentle, &other));
    assert_false(writer_commit(&writer, &error));
    assert_string_equal(error.text, "a exists; add --force to replace it");
    assert_content("a", "theirs");
}

static void a_link_planted_meanwhile_is_not_followed(void **state)
{
    (void)state;
    struct error error = {0}, other;
    struct writer writer;
    assert_true(put("b", "victim", gentle, &other));
    assert_true(writer_open(&writer, "a", force, &error));
    writer_put(&writer, TEXT("mine"));
    assert_int_equal(symlink("b", "a"), 0);
    assert_false(writer_commit(&writer, &error));
    assert_string_equal(error.text, "cannot write a: it is a symbolic link");
    assert_content("b", "victim");
}

static void permissions(void **state)
{
    (void)state;
    struct error error;
    struct stat st;
    const mode_t old = umask(027);
    assert_true(put("a", "x", gentle, &error));
    assert_int_equal(stat("a", &st), 0);
    assert_int_equal(st.st_mode & 07777, 0640);
    assert_int_equal(chmod("a", 0604), 0);
    assert_true(put("a", "y", force, &error));
    assert_int_equal(stat("a", &st), 0);
    assert_int_equal(st.st_mode & 07777, 0604);
    umask(old);
}

static void refusals_say_why(void **state)
{
    (void)state;
    struct error error;
    assert_int_equal(mkdir("inner", 0777), 0);
    assert_int_equal(mkfifo("fifo", 0666), 0);
    assert_int_equal(symlink("nowhere", "link"), 0);
    static const struct {
        const char *path, *text;
    } cases[] = {
        {"", "cannot write : the name is empty"},
        {"inner", "cannot write inner: it is a directory"},
        {"inner/", "cannot write inner/: it is a directory"},
        {".", "cannot write .: it is a directory"},
        {"..", "cannot write ..: it is a directory"},
        {"/", "cannot write /: it is a directory"},
        {"fifo", "cannot write fifo: it is a named pipe"},
        {"link", "cannot write link: it is a symbolic link"},
        {"/dev/null", "cannot write /dev/null: it is a device"},
        {"no/a", "cannot write no/a: No such file or directory"},
        {"fifo/a", "cannot write fifo/a: Not a directory"},
        {"no\033/a", "cannot write no\\x1b/a: No such file or directory"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        for (int with = 0; with <= 1; with++) {
            assert_false(put(cases[i].path, "x", with ? force : gentle, &error));
            assert_int_equal(error.code, ERROR_IO);
            assert_string_equal(error.text, cases[i].text);
        }
}

static void confined_to_the_current_folder(void **state)
{
    struct error error;
    char path[600];
    assert_int_equal(mkdir("inner", 0777), 0);
    assert_int_equal(symlink("../..", "inner/out"), 0);
    const char *folder = *state;
    snprintf(path, sizeof path, "%s/inner/a", folder);
    assert_true(put("a", "x", confine, &error));
    assert_true(put("inner/../b", "x", confine, &error));
    assert_true(put(path, "x", confine, &error)); /* absolute, but inside */
    static const char *const outside[] = {"../a",   "inner/../../a",     "inner/out/a", "/a",
                                          "/tmp/a", "/proc/self/root/a", ".././a"};
    for (size_t i = 0; i < COUNT_OF(outside); i++) {
        assert_false(put(outside[i], "x", confine, &error));
        assert_non_null(strstr(error.text, "outside the current directory"));
    }
    /* a name that only starts like the folder's */
    snprintf(path, sizeof path, "%s-beside", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    strncat(path, "/a", sizeof path - strlen(path) - 1);
    assert_false(put(path, "x", confine, &error));
    *strrchr(path, '/') = '\0';
    assert_int_equal(rmdir(path), 0);
    snprintf(path, sizeof path, "../%s/a", strrchr(folder, '/') + 1); /* out and in again */
    assert_int_equal(unlink("a"), 0);
    assert_true(put(path, "x", confine, &error));
    assert_content("a", "x");
}

static void reading_refuses(void **state)
{
    (void)state;
    struct error error = {0};
    struct buffer b = {0};
    assert_false(file_read("missing", 100, &b, &error));
    assert_int_equal(error.code, ERROR_IO);
    assert_string_equal(error.text, "cannot read missing: No such file or directory");
    assert_string_equal(error.hint, "");
    assert_false(file_read("mis\033sing", 100, &b, &error));
    assert_string_equal(error.text, "cannot read mis\\x1bsing: No such file or directory");
    assert_false(file_read(".", 100, &b, &error));
    assert_string_equal(error.text, "cannot read .: it is a directory");
    assert_null(b.data);

    struct error other;
    assert_true(put("a", "0123456789", gentle, &other));
    assert_true(file_read("a", 10, &b, &error));
    assert_string_equal(b.data, "0123456789");
    assert_false(file_read("a", 9, &b, &error));
    assert_string_equal(error.text, "a has 10 bytes; at most 9 are read");
    assert_string_equal(b.data, "0123456789"); /* as it was */
    assert_true(file_read("/dev/null", 0, &b, &error));
    assert_false(file_read("/dev/zero", 100000, &b, &error)); /* endless, and without a size */
    assert_string_equal(error.text,
                        "/dev/zero is longer than 100000 bytes; at most 100000 can be read");
    assert_string_equal(b.data, "0123456789");
    buffer_free(&b);
    assert_true(put("b", "", gentle, &other));
    assert_true(file_read("b", 0, &b, &error));
    assert_string_equal(b.data, "");
    buffer_free(&b);
}

static void near_names_are_suggested(void **state)
{
    (void)state;
    struct error error = {0};
    struct buffer b = {0};
    assert_int_equal(mkdir("inner", 0777), 0);
    assert_true(put("inner/out", "", gentle, &error));
    assert_true(put("a", "", gentle, &error));
    assert_false(file_read("A", 9, &b, &error));
    assert_string_equal(error.hint, "did you mean 'a'?");
    assert_false(file_read("inner/Out.txt", 9, &b, &error));
    assert_string_equal(error.text, "cannot read inner/Out.txt: No such file or directory");
    assert_string_equal(error.hint, "");
    assert_false(file_read("inner/oud", 9, &b, &error));
    assert_string_equal(error.hint, "did you mean 'out'?");
    assert_false(file_read("neither/oud", 9, &b, &error));
    assert_string_equal(error.hint, "");
}

static void *feed(void *path)
{
    const int fd = open(path, O_WRONLY);
    for (int i = 0; i < 1000 && fd >= 0; i++)
        if (write(fd, "0123456789", 10) != 10)
            break;
    if (fd >= 0)
        close(fd);
    return NULL;
}

static void pipes_and_links_are_read(void **state)
{
    (void)state;
    char fifo[] = "fifo";
    pthread_t thread;
    struct buffer b = {0};
    struct error error = {0};
    assert_int_equal(mkfifo(fifo, 0666), 0);
    assert_int_equal(symlink(fifo, "link"), 0);
    assert_int_equal(pthread_create(&thread, NULL, feed, fifo), 0);
    assert_true(file_read("link", 1u << 20, &b, &error));
    pthread_join(thread, NULL);
    assert_int_equal(b.len, 10000);
    buffer_free(&b);
}

static void on_alarm(int number)
{
    (void)number;
}

static void a_pipe_without_writer_can_be_interrupted(void **state)
{
    (void)state;
    struct sigaction action = {.sa_handler = on_alarm}, old; /* without SA_RESTART */
    struct buffer b = {0};
    struct error error = {0};
    assert_int_equal(mkfifo("fifo", 0666), 0);
    sigaction(SIGALRM, &action, &old);
    ualarm(20000, 20000);
    assert_false(file_read("fifo", 100, &b, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_string_equal(error.text, "reading fifo was interrupted");
    ualarm(0, 0);
    sigaction(SIGALRM, &old, NULL);
    buffer_free(&b);
}

static void a_pipe_without_writer_is_refused_soon(void **state)
{
    (void)state;
    struct buffer b = {0};
    struct error error = {0};
    assert_int_equal(mkfifo("fifo", 0666), 0);
    assert_false(file_read("fifo", 100, &b, &error));
    assert_int_equal(error.code, ERROR_IO);
    assert_string_equal(error.text, "cannot read fifo: it is a pipe and no program writes to it");
    buffer_free(&b);
}

static bool append(void *context, struct text content, size_t from, uintmax_t size,
                   struct error *error)
{
    FILE *file = fopen(context, "ab");
    (void)content, (void)from, (void)error;
    assert_int_equal(size, 3);
    assert_non_null(file);
    fputs("more", file);
    return fclose(file) == 0;
}

/* One that is being written is read as it was when it was opened, or there were no end. */
static void a_file_that_grows_is_read_as_it_was(void **state)
{
    (void)state;
    struct buffer b = {0};
    struct error error = {0};
    char name[] = "a";
    assert_true(put(name, "one", gentle, &error));
    struct read_watch watch = {.context = name, .look = append};
    assert_true(file_read_watched(name, 1000, &watch, &b, &error));
    assert_string_equal(b.data, "one");
    assert_true(watch.grew);
    buffer_free(&b);
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(written_files_are_read_back),
        IN_FOLDER(large_files_are_whole),
        IN_FOLDER(nothing_is_there_before_commit),
        IN_FOLDER(an_existing_file_needs_force),
        IN_FOLDER(one_created_meanwhile_is_kept),
        IN_FOLDER(a_link_planted_meanwhile_is_not_followed),
        IN_FOLDER(permissions),
        IN_FOLDER(refusals_say_why),
        IN_FOLDER(confined_to_the_current_folder),
        IN_FOLDER(reading_refuses),
        IN_FOLDER(near_names_are_suggested),
        IN_FOLDER(pipes_and_links_are_read),
        IN_FOLDER(a_pipe_without_writer_can_be_interrupted),
        IN_FOLDER(a_pipe_without_writer_is_refused_soon),
        IN_FOLDER(a_file_that_grows_is_read_as_it_was),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
