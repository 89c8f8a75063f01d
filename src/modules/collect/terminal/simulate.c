/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Simulates a cheap ultrasonic sensor that observes a scene, with missing echoes, lost, garbled and
 * delayed lines, for trying `collect` without hardware. */
#define _GNU_SOURCE /* ppoll */
#include "modules/collect/terminal/sensor.h"

#include <hooke/method.h>
#include <hooke/run.h>
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* tolerance of the run */
#define SENSOR_TOLERANCE 1e-9
/* probability that a sample has no echo; the sensor then sends 0 */
#define ECHO_MISSING_CHANCE 0.002
#define LINE_LOST_CHANCE 0.001     /* probability that a line is never sent */
#define LINE_GARBLED_CHANCE 0.0005 /* probability that a byte of a line is garbled */
#define LINE_DELAY_MAX 0.2         /* Largest delay of a line as a part of the interval. */
#define SENSOR_DISTANCE 0.3        /* Distance of the position y = 0 from the sensor [m]. */

/* The simulated sensor. */
struct sensor {
    /* rate [Hz], noise in SI of the measured quantity, length [s] (HUGE_VAL if endless) */
    double rate, noise, length;
    double quirks, jitter, silent; /* quirks is 1 or 0; silent [s] is the silence at the start */
    enum { STAMP_MS, STAMP_S, STAMP_NONE } stamp;
    enum quantity quantity;
    double scale; /* number sent = SI value * scale */
    uint64_t seed;
    struct run *run;
};

/* Writes an error about a word of the option. Returns false. */
static bool word_refuse(struct text word, const char *why)
{
    struct buffer safe = {0};
    safe_text(&safe, word, false);
    fprintf(stderr, "hooke: error: --simulate-sensor: %s: %s\n", buffer_view(&safe), why);
    buffer_free(&safe);
    return false;
}

/* Reads NUMBER or NUMBER UNIT and sets *si to it in the SI unit of the quantity; a bare number is
 * one in that unit. Returns false if it is malformed or the unit does not fit. */
static bool read_number(struct text value, enum quantity quantity, double *si)
{
    size_t used = 0;
    double number;
    if (real_scan(value, '.', &number, &used) != REAL_OK || used == 0)
        return false;
    const struct text name = text_trim(text_after(value, used));
    const struct unit *unit = name.len ? unit_find(name) : NULL;
    *si = number;
    return name.len == 0 || (unit && unit_convert(unit, quantity, number, si));
}

/* Sink function for errors of the session's commands. */
static bool write_sensor_error(void *context, struct text text)
{
    (void)context;
    return fwrite(text.data, 1, text.len, stderr) == text.len;
}

/* Executes a command of the session. Returns false after a message. */
static bool execute_command(struct session *session, const char *command, struct text rest)
{
    struct buffer line = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){sink_nothing, write_sensor_error, NULL});
    buffer_put(&line, text_of(command));
    buffer_put(&line, rest);
    const bool ok = command_exec(session, buffer_text(&line), NULL, &reply);
    reply_free(&reply);
    buffer_free(&line);
    return ok;
}

/* Applies one KEY=VALUE of the command line of the simulated sensor: a key of the sensor sets a
 * member of *sensor; any other word is executed as a parameter of the scene. Returns false after a
 * message if the value is malformed or out of range. */
static bool take_word(struct session *session, struct sensor *sensor, struct text word)
{
    const char *mark = memchr(word.data, '=', word.len);
    if (!mark)
        return word_refuse(word, "KEY=VALUE is needed: rate= noise= seed= for= time= quirks=, or a "
                                 "parameter of the scene");
    const struct text key = {word.data, (size_t)(mark - word.data)},
                      value = {mark + 1, word.len - key.len - 1};
    static const char *const stamps[] = {[STAMP_MS] = "ms", [STAMP_S] = "s", [STAMP_NONE] = "none"};
    double seed = 0;
    bool ok = true;
    if (text_is(key, "rate"))
        ok = read_number(value, QUANTITY_FREQUENCY, &sensor->rate) && sensor->rate >= 0.01 &&
             sensor->rate <= 1e4;
    else if (text_is(key, "noise"))
        ok = read_number(value, sensor->quantity, &sensor->noise) && sensor->noise >= 0;
    else if (text_is(key, "for"))
        ok = read_number(value, QUANTITY_TIME, &sensor->length) && sensor->length > 0;
    else if (text_is(key, "silent"))
        ok = read_number(value, QUANTITY_TIME, &sensor->silent) && sensor->silent >= 0;
    else if (text_is(key, "seed")) {
        ok = real_parse(value, &seed) == REAL_OK && seed >= 0 && seed <= 0x1p53;
        sensor->seed = ok ? (uint64_t)seed : 0;
    } else if (text_is(key, "quirks")) {
        ok = text_is(value, "on") || text_is(value, "off");
        sensor->quirks = text_is(value, "on");
    } else if (text_is(key, "time")) {
        ok = false;
        for (int i = 0; i < (int)COUNT_OF(stamps); i++)
            if (text_is(value, stamps[i])) {
                sensor->stamp = (unsigned)i;
                ok = true;
            }
    } else {
        return execute_command(session, "", word);
    }
    return ok || word_refuse(word, "that value is not possible (rate=100 noise=0.03cm seed=1 "
                                   "for=10s time=ms|s|none quirks=on|off silent=2s)");
}

/* Returns a random number of the standard normal distribution. */
static double random_normal(uint64_t *state)
{
    const double size = sqrt(-2 * log(1 - random_fraction(state))); /* Box, Muller 1958 */
    return size * cos(2 * M_PI * random_fraction(state));
}

/* Sets up the scene and the sensor from the words, and creates the run. Returns false after a
 * message. */
static bool simulation_begin(struct session *session, const char *const *word, int words,
                             struct sensor *sensor)
{
    struct error error = {0};
    if (!execute_command(session, "scene ", text_of(word[0])))
        return false;
    struct system system;
    if (!scene_bind_motion(&session->setup.scene, &system, &error)) {
        fprintf(stderr, "hooke: error: %s\n", error.text);
        return false;
    }
    sensor->quantity = system_variable(&system, 0).quantity;
    if (sensor->quantity == QUANTITY_LENGTH)
        sensor->scale = 100;
    else
        sensor->scale = sensor->quantity == QUANTITY_ANGLE ? 180 / M_PI : 1;
    for (int i = 1; i < words; i++)
        if (!take_word(session, sensor, text_of(word[i])))
            return false;
    const struct run_settings settings = {.dt = 0.1 / sensor->rate,
                                          .tol = SENSOR_TOLERANCE,
                                          .record = {RECORD_EVERY, INT64_MAX / 2, 0}};
    const struct method *method = method_by_name(TEXT("dop853"));
    sensor->run = run_create(&session->setup.scene, method, &settings, 1, &error);
    if (!sensor->run)
        fprintf(stderr, "hooke: error: %s\n", error.text);
    return sensor->run != NULL;
}

/* Waits until `due` [clock_ns]. Returns false if interrupted. */
static bool wait_until(int64_t due)
{
    for (int64_t left = due - clock_ns(); left > 0; left = due - clock_ns()) {
        const struct timespec rest = {(time_t)(left / 1000000000), (long)(left % 1000000000)};
        if (cancelled(&interrupt) || (ppoll(NULL, 0, &rest, NULL) < 0 && errno != EINTR))
            return false;
    }
    return !cancelled(&interrupt);
}

/* Appends the line of a sample: time stamp and noisy value, with the sensor's faults. */
static void put_sample_line(struct sensor *sensor, double t, double y, struct buffer *line)
{
    const double shown =
        (y + sensor->noise * random_normal(&sensor->seed)) * sensor->scale +
        (sensor->quantity == QUANTITY_LENGTH ? SENSOR_DISTANCE * sensor->scale : 0);
    const bool missed = sensor->quirks > 0 && random_fraction(&sensor->seed) < ECHO_MISSING_CHANCE;
    if (sensor->stamp == STAMP_MS)
        buffer_format(line, "%.0f,", t * 1000);
    else if (sensor->stamp == STAMP_S)
        buffer_format(line, "%.4f,", t);
    buffer_format(line, "%.3f\r\n", missed ? 0 : shown);
    if (sensor->quirks > 0 && random_fraction(&sensor->seed) < LINE_GARBLED_CHANCE && line->len > 3)
        line->data[(size_t)(random_fraction(&sensor->seed) * (double)(line->len - 2))] = '\xFF';
}

/* Appends the text that a sensor sends when it is switched on, and the heading. */
static void simulated_start_put(const struct sensor *sensor, struct buffer *text)
{
    static const char *const stamps[] = {
        [STAMP_MS] = "time (ms),", [STAMP_S] = "time (s),", [STAMP_NONE] = ""};
    const char *what;
    if (sensor->quantity == QUANTITY_LENGTH)
        what = "distance (cm)";
    else
        what = sensor->quantity == QUANTITY_ANGLE ? "angle (deg)" : "value";
    if (sensor->quirks > 0)
        buffer_format(text, "\r\nranging sensor, simulated by hooke\r\nwarming up ... ok\r\n");
    buffer_format(text, "%s%s\r\n", stamps[sensor->stamp], what);
}

/* Writes each line at its time to standard output, until the end, an interrupt or a failed write.
 * Returns false if the run failed; *failure is the errno of a failed write, or 0. */
static bool sensor_send_lines(struct sensor *sensor, int *failure)
{
    struct buffer line = {0};
    bool ok = true, open = wait_until(clock_ns() + (int64_t)(sensor->silent * 1e9));
    const int64_t start = clock_ns();
    simulated_start_put(sensor, &line);
    open = open && write_all(STDOUT_FILENO, buffer_text(&line), failure);
    for (int64_t i = 0; open && ok && (double)i < sensor->length * sensor->rate; i++) {
        const double t = (double)i / sensor->rate;
        const double late = sensor->quirks * LINE_DELAY_MAX * random_fraction(&sensor->seed);
        const struct run_target target = {.t = sensor->run->system.t0 + t, .steps = -1};
        run_advance(sensor->run, &target, 0, &interrupt);
        ok = !stop_is_failure(sensor->run->stop);
        buffer_clear(&line);
        put_sample_line(sensor, t, sensor->run->y[0], &line);
        const bool lost = sensor->quirks > 0 && random_fraction(&sensor->seed) < LINE_LOST_CHANCE;
        open = ok && wait_until(start + (int64_t)((t + late / sensor->rate) * 1e9)) &&
               (lost || write_all(STDOUT_FILENO, buffer_text(&line), failure));
    }
    buffer_free(&line);
    return ok;
}

/* Runs the simulated sensor until its end, an interrupt or a closed pipe. Returns the exit status.
 */
int simulate_sensor(struct session *session, const char *const *word, int words,
                    struct reply *reply)
{
    (void)reply; /* messages of the session are not shown */
    struct sensor sensor = {.rate = 100, .length = HUGE_VAL, .quirks = 1, .seed = 1};
    if (!simulation_begin(session, word, words, &sensor))
        return ERROR_USAGE;
    int failure = 0;
    const bool ok = sensor_send_lines(&sensor, &failure),
               is_lost = failure != 0 && failure != EPIPE;
    if (is_lost)
        fprintf(stderr, "hooke: error: cannot write standard output: %s\n", strerror(failure));
    else if (!ok)
        fprintf(stderr, "hooke: error: the scene cannot be simulated beyond t = %.6g s\n",
                sensor.run->t);
    run_destroy(sensor.run);
    if (!signals_ending())
        atomic_store(&interrupt.requested, 0); /* Ctrl-C is the usual end and no failure */
    if (is_lost)
        return ERROR_IO;
    return ok ? 0 : ERROR_NUMERICAL;
}
