/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Basins of attraction (basins_find): first a few starts, from which most of the attractors are
 * learned; then all starts, over threads, with that list, which remains unchanged; last, one after
 * another, those that have come to something else. So the result does not depend on which thread
 * computes what. */
#include "modules/dynamics/basins/basins.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <hooke/base/numeric.h>

#define POINTS_MOST 16000000   /* largest number of starts */
#define PILOT_STARTS 64        /* number of starts, 8 x 8, from which attractors are learned */
#define CHECKS_PER_ATTEMPT 64  /* number of checks between attempts to find an orbit */
#define SIZE_MIN_FRACTION 1e-3 /* Sizes below this part of the largest size are replaced by it. */
#define PROGRESS_INTERVAL_NS 50000000 /* [ns] time between two reports of progress */

double basins_value(const struct basins_request *request, int axis, int64_t place)
{
    const int count = request->axis[axis].count;
    const double first = request->axis[axis].low, last = request->axis[axis].high;
    return count < 2 ? first : first + (last - first) * (double)place / (count - 1);
}

double basins_error(int64_t count, int64_t total)
{
    const double share = (double)count / (double)total;
    return sqrt(share * (1 - share) / (double)total);
}

void basins_free(struct basins *basins)
{
    free(basins->fate);
    *basins = (struct basins){.count = 0};
}

/* Data that the threads share. */
struct basins_job {
    const struct basins_request *request;
    const struct basin_walk *walk;
    struct basins *basins;
    atomic_llong next, finished, checks; /* next start; numbers of finished ones and of checks */
    pthread_mutex_t lock;                /* protects `late` */
    struct late *late;  /* [lates] motions that have come to an unknown attractor */
    size_t lates, room; /* number and capacity */
    bool failed;        /* memory ran out */
};

/* A motion whose attractor has to be learned, and its start. */
struct late {
    int64_t point;
    struct walker walker;
};

/* Begins the motion of start number `point`. */
static void walker_begin_at(const struct basins_request *request, const struct basin_walk *walk,
                            int64_t point, struct walker *walker)
{
    double y[FIELD_VARIABLES];
    memcpy(y, walk->field.system.start, sizeof y);
    y[request->axis[0].variable] = basins_value(request, 0, point / request->axis[1].count);
    y[request->axis[1].variable] = basins_value(request, 1, point % request->axis[1].count);
    walker_start(walk, walker, y);
}

/* ---- sizes and times ---- */

/* Returns the time [s] between checks of an autonomous scene: 2 pi divided by the median rate of
 * the pilot starts. */
static double natural_time(struct basin_walk *walk, double (*start)[FIELD_VARIABLES])
{
    double speed[PILOT_STARTS], rate[FIELD_VARIABLES];
    for (int k = 0; k < PILOT_STARTS; k++) {
        field_rate(&walk->field, start[k], rate);
        speed[k] = 0;
        for (int i = 0; i < walk->n; i++)
            speed[k] = fmax(speed[k], fabs(rate[i]) / walk->field.size[i]);
    }
    const double middle = values_quantile(speed, PILOT_STARTS, 0.5);
    return middle > 0 && isfinite(middle) ? TWO_PI / middle : 1;
}

/* Returns true with *error if there are too many starts or if the drive has no period. */
static bool refuse_basins(const struct basin_walk *walk, const struct basins_request *request,
                          struct error *error)
{
    const double total = (double)request->axis[0].count * request->axis[1].count;
    if (total > POINTS_MOST)
        return !error_set(error, ERROR_COMMAND, "%.0f starts: %d are the most", total, POINTS_MOST);
    if (isnan(field_drive(&walk->field)))
        return !error_set(error, ERROR_COMMAND,
                          "the scene depends on time without a period, so its states cannot recur");
    return false;
}

/* Returns true if the divergence is 0 at all pilot starts, so that there are no attractors. */
static bool keeps_volume(struct basin_walk *walk, double (*start)[FIELD_VARIABLES])
{
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int k = 0; k < PILOT_STARTS; k++) {
        double trace = 0, size = 0;
        field_jacobian(&walk->field, start[k], jacobian);
        for (int i = 0; i < walk->n * walk->n; i++) {
            size = fmax(size, fabs(jacobian[i]));
            trace += i % (walk->n + 1) == 0 ? jacobian[i] : 0;
        }
        if (fabs(trace) > 1e-12 * size)
            return false;
    }
    return true;
}

/* Sets walk->centre to the middle of the ranges of starts, and the natural sizes of the variables,
 * by which distances are measured: half the range for the two axes. Another variable whose size is
 * negligible, since it is 0 at the scene's start, takes the larger of these two. */
static void choose_sizes(struct basin_walk *walk, const struct basins_request *request)
{
    double most = 0;
    for (int a = 0; a < 2; a++) {
        const int i = request->axis[a].variable;
        const double first = request->axis[a].low, last = request->axis[a].high;
        walk->centre[i] = (first + last) / 2;
        walk->field.size[i] = first != last ? fabs(last - first) / 2 : walk->field.size[i];
        most = fmax(most, walk->field.size[i]);
    }
    for (int i = 0; i < walk->n; i++)
        if (i != request->axis[0].variable && i != request->axis[1].variable)
            walk->field.size[i] =
                walk->field.size[i] < SIZE_MIN_FRACTION * most ? most : walk->field.size[i];
}

/* Binds the scene, chooses sizes, and finds the time between checks (walk->strobe: the period of
 * the drive, else a natural time) and, with `lanes`, the number of steps between checks. Both come
 * from 8 x 8 pilot starts, in the middles of equal cells of the grid. Scenes that conserve volumes
 * are refused. */
bool walk_init(struct basin_walk *walk, const struct basins_request *request, bool lanes,
               struct error *error)
{
    double start[PILOT_STARTS][FIELD_VARIABLES];
    *walk = (struct basin_walk){.n = 0};
    if (!field_init(&walk->field, request->scene, NULL, 0, error))
        return false;
    const double drive = field_drive(&walk->field);
    walk->n = walk->field.n;
    walk->forced = drive > 0;
    walk->field.cancel = request->cancel;
    if (refuse_basins(walk, request, error)) {
        field_free(&walk->field);
        return false;
    }
    choose_sizes(walk, request);
    for (int k = 0; k < PILOT_STARTS; k++) {
        memcpy(start[k], walk->field.system.start, sizeof start[k]);
        for (int a = 0; a < 2; a++) {
            const double share = ((a == 0 ? k / 8 : k % 8) + 0.5) / 8;
            start[k][request->axis[a].variable] =
                request->axis[a].low + share * (request->axis[a].high - request->axis[a].low);
        }
    }
    if (keeps_volume(walk, start)) {
        field_free(&walk->field);
        return error_set(error, ERROR_COMMAND,
                         "the scene conserves volumes, so it has no attractors");
    }
    walk->strobe = drive > 0 ? drive : natural_time(walk, start);
    if (lanes)
        stepper_choose(walk, start, PILOT_STARTS);
    return true;
}

void walk_free(struct basin_walk *walk)
{
    for (int k = 0; k < walk->attractors; k++) {
        free(walk->attractor[k].point);
        free(walk->attractor[k].cell);
    }
    field_free(&walk->field);
}

/* ---- attractors from a few starts ---- */

/* Follows the pilot starts until the fate of each is known, or for WALK_CHECKS_MAX checks, and
 * learns their attractors. All motions are offered to walk_learn() every CHECKS_PER_ATTEMPT checks,
 * since those on closed orbits need not repeat at checks. Counts the checks in basins->checks;
 * progress is reported up to 0.1. Returns false if out of memory. */
static bool learn_first(struct basin_walk *walk, const struct basins_request *request,
                        struct basins *basins)
{
    struct stepper *stepper = stepper_create(walk);
    struct walker *walker = malloc(PILOT_STARTS * sizeof *walker);
    int active = stepper && walker ? PILOT_STARTS : 0;
    const bool fine = active > 0;
    for (int k = 0; k < active; k++) {
        const int64_t a = request->axis[0].count * (int64_t)(2 * (k / 8) + 1) / 16,
                      b = request->axis[1].count * (int64_t)(2 * (k % 8) + 1) / 16;
        walker_begin_at(request, walk, a * request->axis[1].count + b, &walker[k]);
    }
    for (int check = 1; active > 0 && !cancelled(request->cancel); check++) {
        stepper_advance(stepper, walker, active);
        if (cancelled(request->cancel)) /* it may have ended anywhere */
            break;
        basins->checks += active;
        int left = 0;
        for (int k = 0; k < active; k++) {
            int fate = walker_check(walk, &walker[k]);
            if (fate == BASIN_UNDECIDED ||
                (fate == BASIN_MISSING && check % CHECKS_PER_ATTEMPT == 0))
                fate = walk_learn(walk, &walker[k]);
            if (fate == BASIN_MISSING && walker[k].checks < WALK_CHECKS_MAX)
                walker[left++] = walker[k];
        }
        active = left;
        if (request->progress)
            request->progress(request->context, 0.1 * fmin(1, 1.0 * check / WALK_CHECKS_MAX));
    }
    stepper_free(stepper);
    free(walker);
    return fine;
}

/* ---- all starts ---- */

/* Stores a motion whose attractor is not known yet, from start number `point` of the grid, for
 * learn_late(). Threads may call it at the same time. Sets job->failed if out of memory. */
static void keep_late(struct basins_job *job, int64_t point, const struct walker *walker)
{
    pthread_mutex_lock(&job->lock);
    if (job->lates == job->room) {
        const size_t room = job->room > 0 ? 2 * job->room : 64;
        struct late *late = realloc(job->late, room * sizeof *late);
        if (late) {
            job->late = late;
            job->room = room;
        } else {
            job->failed = true;
        }
    }
    if (job->lates < job->room)
        job->late[job->lates++] = (struct late){point, *walker};
    pthread_mutex_unlock(&job->lock);
}

/* Follows starts of the grid, LANE_COUNT at a time, until none is left, and stores the fate of
 * each; each thread runs this. A motion is checked in intervals; BASIN_MISSING means that its fate
 * is not known yet and it is followed further. `context` is the struct basins_job. Sets job->failed
 * if out of memory. Returns NULL, as pthreads want a result. */
static void *walk_all(void *context)
{
    struct basins_job *job = context;
    struct stepper *stepper = stepper_create(job->walk);
    struct walker *walker = malloc(LANE_COUNT * sizeof *walker);
    int64_t point[LANE_COUNT];
    int active = 0;
    bool more = stepper && walker;
    if (!more)
        job->failed = true;
    while ((more || active > 0) && !cancelled(job->request->cancel)) {
        while (more && active < LANE_COUNT) {
            const int64_t next = atomic_fetch_add(&job->next, 1);
            more = next < job->basins->total;
            if (more) {
                point[active] = next;
                walker_begin_at(job->request, job->walk, next, &walker[active++]);
            }
        }
        stepper_advance(stepper, walker, active);
        if (cancelled(job->request->cancel)) /* it may have ended anywhere */
            break;
        atomic_fetch_add(&job->checks, active);
        int left = 0;
        for (int k = 0; k < active; k++) {
            const int fate = walker_check(job->walk, &walker[k]);
            if (fate == BASIN_MISSING) {
                point[left] = point[k];
                walker[left++] = walker[k];
                continue;
            }
            job->basins->fate[point[k]] = (signed char)fate;
            if (fate == BASIN_UNDECIDED)
                keep_late(job, point[k], &walker[k]);
            atomic_fetch_add(&job->finished, 1);
        }
        active = left;
    }
    stepper_free(stepper);
    free(walker);
    return NULL;
}

/* Reports progress until all starts are finished. */
static void watch_over(struct basins_job *job)
{
    const struct basins_request *r = job->request;
    int64_t shown = clock_ns();
    while (atomic_load(&job->finished) < job->basins->total && !cancelled(r->cancel) &&
           !job->failed) {
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        if (r->progress && clock_ns() - shown > PROGRESS_INTERVAL_NS) {
            shown = clock_ns();
            r->progress(r->context, 0.1 + 0.9 * (double)atomic_load(&job->finished) /
                                              (double)job->basins->total);
        }
    }
}

#define THREADS_MAX 64
#define THREAD_STACK_BYTES ((size_t)1 << 20) /* independent of limits of the system */

/* Runs walk_all() in threads; in the calling one if none can be created. */
static void walk_by_threads(struct basins_job *job)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const int wanted = job->request->threads > 0 ? job->request->threads : (int)processors;
    pthread_t thread[THREADS_MAX];
    pthread_attr_t stack;
    int running = 0;
    pthread_attr_init(&stack);
    pthread_attr_setstacksize(&stack, THREAD_STACK_BYTES);
    while (running < wanted && running < THREADS_MAX &&
           running * (int64_t)LANE_COUNT < job->basins->total &&
           pthread_create(&thread[running], &stack, walk_all, job) == 0)
        running++;
    pthread_attr_destroy(&stack);
    if (running == 0) /* no threads to be had */
        walk_all(job);
    else
        watch_over(job);
    for (int i = 0; i < running; i++)
        pthread_join(thread[i], NULL);
    job->basins->threads = running > 0 ? running : 1;
}

/* Compares two late motions by their starts, for qsort(). */
static int compare_late(const void *a, const void *b)
{
    const struct late *x = a, *y = b;
    return (x->point > y->point) - (x->point < y->point);
}

/* Decides the starts whose attractor was unknown when they were walked. */
static void learn_late(struct basins_job *job, struct basin_walk *walk)
{
    if (job->lates > 0 && !cancelled(job->request->cancel))
        qsort(job->late, job->lates, sizeof *job->late, compare_late);
    const int old_count = walk->attractors;
    for (size_t i = 0; i < job->lates && !cancelled(job->request->cancel); i++) {
        struct walker *w = &job->late[i].walker;
        /* Only a few of those that do not repeat are examined. */
        if (!w->found && i >= PILOT_STARTS && walk->attractors == old_count)
            continue;
        int fate = BASIN_UNDECIDED;
        if (w->found || i < PILOT_STARTS || walk->attractors > old_count)
            fate = walk_learn(walk, w);
        job->basins->fate[job->late[i].point] =
            (signed char)(fate == BASIN_MISSING ? BASIN_UNDECIDED : fate);
    }
}

/* ---- result ---- */

/* Counts the starts of each basin, sorts basins by size, and renumbers the fates. */
static void count_basins(struct basins *basins, const struct basin_walk *walk)
{
    int order[BASINS_MOST] = {0}, place[BASINS_MOST] = {0};
    int64_t count[BASINS_MOST] = {0};
    for (int64_t i = 0; i < basins->total; i++) {
        const int fate = basins->fate[i];
        basins->finished += fate != BASIN_MISSING;
        basins->escaping += fate == BASIN_ESCAPES;
        basins->undecided += fate == BASIN_UNDECIDED;
        if (fate >= 0)
            count[fate]++;
    }
    for (int k = 0; k < walk->attractors; k++) {
        if (count[k] == 0) {
            continue;
        }
        int j = basins->count++;
        for (; j > 0 && count[order[j - 1]] < count[k]; j--)
            order[j] = order[j - 1];
        order[j] = k;
    }
    for (int j = 0; j < basins->count; j++) {
        place[order[j]] = j;
        basins->basin[j] = walk->attractor[order[j]].basin;
        basins->basin[j].count = count[order[j]];
    }
    for (int64_t i = 0; i < basins->total; i++)
        if (basins->fate[i] >= 0)
            basins->fate[i] = (signed char)place[basins->fate[i]];
}

/* Computes for each start of a grid which attractor the motion comes to. Learns attractors from a
 * few pilot starts first, then follows all starts in threads, and decides last those whose
 * attractor was unknown to their thread. Calls request->progress (may be NULL) with 2 at the end.
 * The caller frees *basins with basins_free(). If cancelled, basins->cancelled is set and undecided
 * starts remain BASIN_MISSING. Returns false with *error if out of memory. */
bool basins_find(const struct basins_request *request, struct basins *basins, struct error *error)
{
    const int64_t start_time = clock_ns();
    struct basin_walk *walk = malloc(sizeof *walk);
    *basins = (struct basins){.total = (int64_t)request->axis[0].count * request->axis[1].count};
    if (!walk)
        return error_memory(error);
    if (!walk_init(walk, request, true, error)) {
        free(walk);
        return false;
    }
    struct basins_job job = {
        .request = request, .walk = walk, .basins = basins, .lock = PTHREAD_MUTEX_INITIALIZER};
    basins->strobe = walk->strobe;
    basins->steps = walk->steps;
    basins->fate = malloc((size_t)basins->total + 1);
    if (basins->fate)
        memset(basins->fate, BASIN_MISSING, (size_t)basins->total);
    if (!basins->fate || !learn_first(walk, request, basins))
        job.failed = true;
    else
        walk_by_threads(&job);
    if (!job.failed)
        learn_late(&job, walk);
    basins->checks += atomic_load(&job.checks);
    basins->cancelled = cancelled(request->cancel);
    if (!job.failed)
        count_basins(basins, walk);
    if (request->progress)
        request->progress(request->context, 2);
    free(job.late);
    pthread_mutex_destroy(&job.lock);
    walk_free(walk);
    free(walk);
    basins->seconds = clock_seconds(start_time);
    if (job.failed)
        basins_free(basins);
    return !job.failed || error_memory(error);
}
