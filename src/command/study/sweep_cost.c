/* SPDX-License-Identifier: GPL-3.0-or-later */
/* sweep … --dry-run: what a shard costs, by computing points from all over it. */
#include <hooke/report/sweep.h>
#include "command/study/sweep.h"

#include <math.h>
#include <time.h>
#include <unistd.h>

#define PLACES 8    /* evenly over the shard */
#define SECONDS 1.0 /* that are measured, unless one place takes longer */
#define HOUR 3600.0
/* Times the processor time that the clock has to show before the machine counts as busy. */
static const double busy_ratio = 1.3;
/* Beginning and ending threads may take that much of the time of less [s]. */
static const double busy_seconds_min = 0.05;

/* Seconds are processor time, which other processes do not change, of each thread. */
struct cost_sample {
    int64_t points;
    double seconds, elapsed, bytes;
    double rate[PLACES]; /* points a second, of the last look at each place */
    int places;
};

/* Returns the processor time of all threads of the process [s]. */
static double processor_seconds(void)
{
    struct timespec now = {0, 0};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

/* So many points at each place: in the middle of each of as many parts as there are places, so that
 * ends which take longer have no more than their share; where blocks of lanes begin. */
static bool look(struct session *session, const struct sweep_request *request,
                 const struct sweep *shard, int64_t each, struct cost_sample *sample,
                 struct error *error)
{
    const int64_t count = each < shard->count ? each : shard->count, fit = shard->count / count,
                  batch = study_sweep_batch(request);
    const int places = fit < PLACES ? (int)fit : PLACES;
    bool ok = true;
    *sample = (struct cost_sample){.places = places};
    for (int i = 0; i < places && ok; i++) {
        struct sweep_request part = *request;
        struct sweep sweep;
        struct buffer rows = {0};
        struct error why = {0};
        part.progress = NULL;
        part.count = count;
        const double middle = (double)shard->count * (2 * i + 1) / (2 * places);
        const int64_t at = shard->first + (int64_t)fmax(0, middle - (double)count / 2);
        part.first = at - at % batch < shard->first ? at : at - at % batch;
        const double begin = processor_seconds();
        study_sweep(&part, &sweep, &why);
        const long processors = sysconf(_SC_NPROCESSORS_ONLN);
        const double seconds =
            (processor_seconds() - begin) / fmax(1, fmin(sweep.threads, (double)processors));
        ok = sweep.finished == count && sweep_rows(&part, &sweep, &rows);
        if (!ok)
            *error = why.code ? why : (struct error){.code = ERROR_COMMAND};
        sample->points += count;
        sample->seconds += seconds;
        sample->elapsed += sweep.seconds;
        sample->bytes += (double)rows.len;
        sample->rate[i] = (double)count / fmax(seconds, 1e-9);
        buffer_free(&rows);
        sweep_free(&sweep);
        report_fraction(&session->front, -1);
    }
    if (!ok && !error->text[0])
        error_memory(error);
    return ok;
}

/* Relative standard deviation of the cost of a point, from place to place. */
static double scatter(const struct cost_sample *sample)
{
    double sum = 0, squares = 0;
    const int n = sample->places;
    for (int i = 0; i < n; i++) {
        sum += 1 / sample->rate[i];
        squares += 1 / (sample->rate[i] * sample->rate[i]);
    }
    const double mean = sum / n;
    return n > 1 ? sqrt(fmax(0, (squares / n - mean * mean) * n / (n - 1))) / mean : 0;
}

bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error)
{
    struct sweep shard;
    struct cost_sample sample;
    int64_t each = study_sweep_batch(request);
    study_sweep_stretch(request, &shard);
    if (shard.count == 0)
        return error_set(error, ERROR_COMMAND, "this shard has no points");
    for (;;) {
        if (!look(session, request, &shard, each, &sample, error))
            return false;
        const double wanted = SECONDS / fmax(sample.elapsed, 1e-3);
        if (wanted < 2 || PLACES * each >= shard.count)
            break;
        each = (int64_t)((double)each * fmin(wanted, 16));
    }
    const double rate = (double)sample.points / fmax(sample.seconds, 1e-9),
                 seconds = (double)shard.count / rate, whole = (double)shard.total / rate,
                 bytes =
                     (sample.bytes / (double)sample.points + sweep_file_mark_bytes(shard.total)) *
                     (double)shard.count,
                 shards = fmax(1, ceil(whole / HOUR)), spread = scatter(&sample);
    reply_begin(reply, "sweep-cost");
    reply_int(reply, "points", shard.count);
    reply_int(reply, "total", shard.total);
    reply_int(reply, "measured", sample.points);
    reply_quantity(reply, "rate", rate, "1/s");
    reply_real(reply, "scatter", spread);
    reply_quantity(reply, "seconds", seconds, "s");
    reply_real(reply, "bytes", bytes);
    reply_real(reply, "shards", shards);
    reply_line(reply, "%lld of %lld points: %.3g s at %.3g points a second%s, %.3g bytes of CSV",
               (long long)shard.count, (long long)shard.total, seconds, rate,
               spread > 0.2 ? " (very uneven from place to place)" : "", bytes);
    reply_line(reply, "all %lld: %.3g s; %.0f shard%s of an hour each at most (measured on %lld)",
               (long long)shard.total, whole, shards, shards > 1 ? "s" : "",
               (long long)sample.points);
    const double busy = sample.elapsed / fmax(sample.seconds, 1e-9);
    reply_real(reply, "busy", busy);
    if (busy > busy_ratio && sample.elapsed > busy_seconds_min)
        reply_line(reply, "the machine is busy: as it is now, %.1f times as long", busy);
    reply_end(reply);
    return true;
}
