/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What has no end is refused, at once or after two seconds in which no file would come so slowly;
 * pipes that end are read whole. */
#include <hooke/base/cancel.h>
#include "modules/recording/data/fixture.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#define MS 1000000

/* How long that takes [ns]. */
static int64_t refused(const char *path, const char *part)
{
    struct error error = {0};
    const int64_t begin = clock_ns();
    struct recording *recording = recording_load(path, NULL, &error);
    const int64_t took = clock_ns() - begin;
    assert_null(recording);
    assert_int_equal(error.code, ERROR_IO);
    if (!strstr(error.text, part) || !strstr(error.hint, "load -"))
        fail_msg("wanted '%s', got '%s' ('%s')", part, error.text, error.hint);
    return took;
}

/* Before it could have been waited for; again, where others had the processor. */
static void refused_at_once(const char *path, const char *part)
{
    int64_t took = INT64_MAX;
    for (int tries = 0; tries < 5 && took > 500 * (int64_t)MS; tries++)
        took = refused(path, part);
    if (took > 500 * (int64_t)MS)
        fail_msg("%s: said after %.2f s", part, 1e-9 * (double)took);
}

static void a_line_to_a_device_is_refused_at_once(void **state)
{
    (void)state;
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
    const char *name = ptsname(master);
    assert_non_null(name);
    refused_at_once(name, "a terminal or a serial line");
    close(master);
}

static void a_socket_is_refused_at_once(void **state)
{
    (void)state;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *path = fixture_path("socket");
    assert_true(strlen(path) < sizeof address.sun_path);
    memcpy(address.sun_path, path, strlen(path) + 1);
    const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (const void *)&address, sizeof address), 0);
    refused_at_once(address.sun_path, "it is a socket");
    close(fd);
}

/* Rows as a sensor writes them, until nobody reads any more. */
static void *sensor(void *path)
{
    const int fd = open(path, O_WRONLY | O_CLOEXEC);
    char row[40];
    for (int i = 0; fd >= 0; i++) {
        const int len = snprintf(row, sizeof row, "%.2f\t%.3f\n", 0.02 * i, 20 + 0.001 * (i % 50));
        const struct timespec step = {.tv_nsec = 20 * MS};
        if (write(fd, row, (size_t)len) != len)
            break;
        nanosleep(&step, NULL);
    }
    close(fd);
    return NULL;
}

static void a_pipe_that_goes_on_is_refused_soon(void **state)
{
    (void)state;
    pthread_t thread;
    char path[300];
    snprintf(path, sizeof path, "%s", fixture_path("sensor"));
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(pthread_create(&thread, NULL, sensor, path), 0);
    refused(path, "data keep arriving"); /* it would go on until the test is stopped */
    pthread_join(thread, NULL);
}

enum { ROWS = 20000 };

static void *file(void *path)
{
    FILE *out = fopen(path, "w");
    for (int i = 0; out && i < ROWS; i++)
        fprintf(out, "%.2f\t%.3f\n", 0.01 * i, 20 + 0.001 * (i % 50));
    if (out)
        fclose(out);
    return NULL;
}

static void a_pipe_that_ends_is_read_whole(void **state)
{
    (void)state;
    pthread_t thread;
    struct error error = {0};
    char path[300];
    snprintf(path, sizeof path, "%s", fixture_path("pipe"));
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(pthread_create(&thread, NULL, file, path), 0);
    struct recording *recording = recording_load(path, NULL, &error);
    pthread_join(thread, NULL);
    if (!recording)
        fail_msg("%s", error.text);
    else
        assert_int_equal(recording->rows, ROWS);
    recording_destroy(recording);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_to_a_device_is_refused_at_once),
        cmocka_unit_test(a_socket_is_refused_at_once),
        cmocka_unit_test(a_pipe_that_goes_on_is_refused_soon),
        cmocka_unit_test(a_pipe_that_ends_is_read_whole),
    };
    signal(SIGPIPE, SIG_IGN);
    return cmocka_run_group_tests(tests, fixture_setup, fixture_teardown);
}
