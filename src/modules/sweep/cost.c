/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `sweep … --dry-run`: estimates time and size of a shard by computing points spread over it. */
#include "modules/sweep/file.h"
#include "modules/sweep/handlers.h"

#include <math.h>

/* Number of places, evenly over the shard, at which points are timed. */
#define COST_SAMPLES 8
#define COST_SECONDS 1.0 /* time of all measurements, unless points take longer [s] */
#define HOUR_SECONDS 3600.0

/* Points that were computed, with their time [s] and size as CSV [byte]. */
struct cost_sample {
    int64_t points;
    double seconds, bytes;
};

/* Computes `each` points at each of up to COST_SAMPLES places of the shard, and sums points, time
 * and size of rows in *sample. Places lie in the middle of equal parts of the shard, so that slow
 * ends have no more than their share, and begin where batches of lanes do. Returns false with an
 * error if a point fails or if cancelled. */
static bool take_sample(struct session *session, const struct sweep_request *request,
                        const struct sweep *shard, int64_t each, struct cost_sample *sample,
                        struct error *error)
{
    struct sweep_request part = *request;
    const int64_t batch = study_sweep_batch(request);
    part.count = each < shard->count ? each : shard->count;
    part.progress = NULL;
    const int64_t fit = shard->count / part.count;
    const int places = fit < COST_SAMPLES ? (int)fit : COST_SAMPLES;
    bool ok = true;
    *sample = (struct cost_sample){.points = 0};
    for (int i = 0; i < places && ok; i++) {
        struct sweep sweep;
        struct buffer rows = {0};
        struct error why = {0};
        const double middle = (double)shard->count * (2 * i + 1) / (2 * places);
        const int64_t start = shard->first + (int64_t)fmax(0, middle - (double)part.count / 2);
        part.first = start - start % batch < shard->first ? start : start - start % batch;
        study_sweep(&part, &sweep, &why);
        ok = sweep.finished == part.count &&
             (sweep_rows(&part, &sweep, &rows) || error_memory(&why));
        if (!ok)
            *error = why;
        sample->points += part.count;
        sample->seconds += sweep.seconds;
        sample->bytes += (double)rows.len;
        buffer_free(&rows);
        sweep_free(&sweep);
        report_fraction(&session->front, -1);
    }
    return ok;
}

/* Executes `sweep ... --dry-run`: computes a sample of the sweep's points, in growing batches until
 * about COST_SECONDS have been measured, and replies with the estimated time, bytes and shards of
 * an hour. Returns false with *error if the shard is empty or a sample fails. */
bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error)
{
    struct sweep shard;
    struct cost_sample sample = {0};
    struct buffer seal = {0};
    int64_t each = study_sweep_batch(request);
    study_sweep_stretch(request, &shard);
    if (shard.count == 0)
        return error_set(error, ERROR_COMMAND, "this shard has no points");
    for (double wanted = 2; wanted >= 2; each = (int64_t)((double)each * fmin(wanted, 16))) {
        if (!take_sample(session, request, &shard, each, &sample, error))
            return false;
        wanted = COST_SAMPLES * each < shard.count ? COST_SECONDS / fmax(sample.seconds, 1e-3) : 0;
    }
    sweep_seal(TEXT(""), shard.total, 1, &seal);
    const double rate = (double)sample.points / fmax(sample.seconds, 1e-9),
                 seconds = (double)shard.count / rate, whole = (double)shard.total / rate,
                 bytes = (sample.bytes / (double)sample.points +
                          (double)seal.len / (double)sweep_cell(shard.total)) *
                         (double)shard.count,
                 shards = fmax(1, ceil(whole / HOUR_SECONDS));
    buffer_free(&seal);
    reply_begin(reply, "sweep-cost");
    reply_int(reply, "points", shard.count);
    reply_int(reply, "total", shard.total);
    reply_int(reply, "measured", sample.points);
    reply_quantity(reply, "rate", rate, "1/s");
    reply_quantity(reply, "seconds", seconds, "s");
    reply_real(reply, "bytes", bytes);
    reply_real(reply, "shards", shards);
    reply_line(reply, "%lld of %lld points: %.3g s at %.3g points per second, %.3g bytes of CSV",
               (long long)shard.count, (long long)shard.total, seconds, rate, bytes);
    reply_line(
        reply,
        "all %lld points: %.3g s, or %.0f shard%s of at most an hour each (estimated from %lld)",
        (long long)shard.total, whole, shards, shards > 1 ? "s" : "", (long long)sample.points);
    reply_end(reply);
    return true;
}
