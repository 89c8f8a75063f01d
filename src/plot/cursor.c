/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/plot/cursor.h>

#include <hooke/base/numeric.h>
#include <hooke/plot.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OFF_BEAT 0.15 /* [periods] an up-crossing that is further off is none */
#define BEATS_TRIED 16
/* part of the up-crossings that may be off before the motion counts as not steady */
#define LATE_MAX 0.34
/* [periods] on each side of the highest sample that the parabola is fitted to */
#define PEAK_WIDTH 0.1

/* ---- what they stand on ---- */

/* How far t is off the up-crossings of a motion of this period [periods]. */
static double off_beat(const struct period *beat, double t)
{
    return fabs(remainder(t - beat->first, beat->period.value)) / beat->period.value;
}

static size_t count_late(const struct crossing *crossing, size_t count, const struct period *beat)
{
    size_t late = 0;
    for (size_t i = 0; i < count; i++)
        late += crossing[i].up && off_beat(beat, crossing[i].t) > OFF_BEAT;
    return late;
}

/*
 * Whether most up-crossings of a recording keep time; those that do not are then spikes of the
 * sensor, not crossings. The beat is that which fits most of them: the line of series_period, or
 * the estimate of the period from one of the first crossings, which may be a spike itself.
 */
static bool keeps_time(const struct ground *g, const struct crossing *crossing, size_t count,
                       struct period *beat)
{
    struct error ignored;
    if (!g->overview.oscillates || !series_period(&g->series, g->arena, beat, &ignored))
        return false;
    size_t all = 0, best = count_late(crossing, count, beat);
    for (size_t i = 0; i < count; i++) {
        const struct period other = {.period = {g->overview.period, 0}, .first = crossing[i].t};
        all += crossing[i].up;
        const size_t late =
            crossing[i].up && all <= BEATS_TRIED ? count_late(crossing, count, &other) : best;
        if (late < best) {
            best = late;
            *beat = other;
        }
    }
    return (double)best <= LATE_MAX * (double)all;
}

static bool find_hills(struct ground *g, struct error *error)
{
    const struct overview *o = &g->overview;
    size_t count = o->oscillates ? 2 * (size_t)o->periods + 16 : 64, capacity;
    struct crossing *crossing;
    do {
        capacity = count;
        if (!(crossing = arena_array(g->arena, capacity, sizeof *crossing)))
            return error_memory(error);
        count = series_crossings(&g->series, o, o->mean, crossing, capacity);
    } while (count > capacity);
    if (!(g->hill = arena_array(g->arena, count + 1, sizeof *g->hill)))
        return error_memory(error);
    struct period beat;
    const bool steady = g->data && keeps_time(g, crossing, count, &beat);
    for (size_t i = 0; i < count; i++) {
        const double t = crossing[i].t;
        if (!crossing[i].up || (steady && off_beat(&beat, t) > OFF_BEAT))
            continue;
        struct hill *hill = &g->hill[g->hills];
        *hill = (struct hill){
            .from = t, .uncertainty = crossing[i].uncertainty, .number = (int)g->hills + 1};
        hill->to = steady          ? t + 0.5 * beat.period.value
                   : i + 1 < count ? crossing[i + 1].t
                                   : (double)NAN;
        if (steady)
            hill->number = 1 + (int)nearbyint((t - g->hill[0].from) / beat.period.value);
        if (g->hills == 0 || hill->number > hill[-1].number)
            g->hills++;
    }
    return true;
}

bool ground_open(struct session *session, struct arena *arena, struct ground *ground,
                 struct error *error)
{
    struct cursors *cursors = &session->view.cursors;
    const struct run *run = session_run(session);
    struct recording *recording = session_recording(session);
    *ground = (struct ground){.arena = arena};
    if (!run && !recording) {
        error_set(error, ERROR_COMMAND, "there is neither a run nor a recording for the cursors");
        return error_hint(error, "type: run, or: load FILE");
    }
    cursors->on_data = recording && (cursors->on_data || !run);
    ground->data = cursors->on_data;
    if (cursors->on_data) {
        snprintf(ground->name, sizeof ground->name, "data %s", recording->name);
        if (!recording_series(recording, arena, 2, &ground->series, error))
            return false;
    } else {
        snprintf(ground->name, sizeof ground->name, "run %d", run->number);
        if (!run_series(run, false, arena, &ground->series, error))
            return false;
        if (ground->series.n < 2)
            return error_set(error, ERROR_COMMAND,
                             "run %d is at its start: there is nothing to measure yet",
                             run->number);
    }
    series_overview(&ground->series, arena, &ground->overview);
    return find_hills(ground, error);
}

double ground_spacing(const struct ground *g)
{
    return (g->series.t[g->series.n - 1] - g->series.t[0]) / (double)(g->series.n - 1);
}

/* Last sample at or before t, one that has another after it. */
static size_t sample_before(const struct series *s, double t)
{
    const size_t at = first_from(s->t, s->n - 1, t);
    return at > 0 && (at == s->n - 1 || s->t[at] > t) ? at - 1 : at;
}

/* ---- places to snap to ---- */

struct snap_point {
    double t, uncertainty, y;
    int crossing; /* number, 0: none */
};

/* The vertex of the parabola through the samples around the highest one between two crossings
 * (least squares). */
static bool peak_between(const struct ground *g, double from, double to, struct snap_point *point)
{
    const struct series *s = &g->series;
    /* above it there are only spikes */
    const double ceiling = g->overview.high + 4 * g->overview.noise;
    size_t top = s->n;
    for (size_t i = sample_before(s, from); i < s->n && s->t[i] <= to; i++)
        if (s->t[i] >= from && s->y[i] <= ceiling && (top == s->n || s->y[i] > s->y[top]))
            top = i;
    if (top == s->n || top == 0 || top + 1 == s->n)
        return false;
    const double width = g->overview.oscillates ? PEAK_WIDTH * g->overview.period : 0;
    size_t a = top - 1, b = top + 1;
    while (a > 0 && s->t[top] - s->t[a - 1] <= width)
        a--;
    while (b + 1 < s->n && s->t[b + 1] - s->t[top] <= width)
        b++;
    /* half the amplitude down */
    const double bottom = s->y[top] - 0.25 * (g->overview.high - g->overview.low);
    /* y = p + q x + r x^2 with x counted from the mean, so that q is nearly independent of the
     * others. */
    double n = 0, sx = 0;
    for (size_t i = a; i <= b; i++) {
        if (!(s->y[i] >= bottom && s->y[i] <= ceiling))
            continue;
        n++;
        sx += s->t[i] - s->t[top];
    }
    const double mean = sx / n, scale = s->t[b] - s->t[a];
    double x2 = 0, x3 = 0, x4 = 0, y0 = 0, y1 = 0, y2 = 0;
    for (size_t i = a; i <= b; i++) {
        if (!(s->y[i] >= bottom && s->y[i] <= ceiling))
            continue;
        const double x = (s->t[i] - s->t[top] - mean) / scale, y = s->y[i] - s->y[top];
        x2 += x * x;
        x3 += x * x * x;
        x4 += x * x * x * x;
        y0 += y;
        y1 += x * y;
        y2 += x * x * y;
    }
    /* Normal equations [n 0 x2; 0 x2 x3; x2 x3 x4]. */
    const double det = n * (x2 * x4 - x3 * x3) - x2 * x2 * x2;
    const double q = (n * (y1 * x4 - y2 * x3) - x2 * x2 * y1 + x2 * x3 * y0) / det;
    const double r = (n * (x2 * y2 - x3 * y1) - x2 * x2 * y0) / det;
    const double p = (y0 - x2 * r) / n, x = -q / (2 * r);
    if (!(r < 0) || !(fabs(x) <= 0.5))
        return false;
    *point =
        (struct snap_point){.t = s->t[top] + mean + x * scale,
                            .uncertainty = g->overview.noise * scale / (2 * fabs(r) * sqrt(x2)),
                            .y = s->y[top] + p + q * x + r * x * x};
    return true;
}

/* Calls for each place of this kind in order until it says stop. Samples are no places: there are
 * too many. */
static void each_position(const struct ground *g, enum snap snap,
                          bool (*visit)(void *context, const struct snap_point *point),
                          void *context)
{
    struct snap_point point;
    for (size_t i = 0; i < g->hills; i++) {
        const struct hill *hill = &g->hill[i];
        if (snap != SNAP_PEAK)
            point =
                (struct snap_point){hill->from, hill->uncertainty, g->overview.mean, hill->number};
        else if (!peak_between(g, hill->from, hill->to, &point))
            continue;
        if (!visit(context, &point))
            return;
    }
}

struct snap_search {
    double t;
    struct snap_point best;
    bool found, forward;
    int number;
};

static bool keep_nearest(void *context, const struct snap_point *point)
{
    struct snap_search *search = context;
    if (!search->found || fabs(point->t - search->t) < fabs(search->best.t - search->t))
        search->best = *point;
    search->found = true;
    return true;
}

static struct snap_point nearest_sample(const struct ground *g, double t)
{
    const struct series *s = &g->series;
    size_t i = sample_before(s, t);
    if (fabs(s->t[i + 1] - t) < fabs(t - s->t[i]))
        i++;
    return (struct snap_point){
        .t = s->t[i], .uncertainty = ground_spacing(g) / sqrt(12), .y = s->y[i]};
}

static struct snap_point no_snap(const struct ground *g, double t)
{
    const struct series *s = &g->series;
    const size_t i = sample_before(s, t);
    const double x = (t - s->t[i]) / (s->t[i + 1] - s->t[i]);
    return (struct snap_point){
        .t = t, .uncertainty = NAN, .y = s->y[i] + x * (s->y[i + 1] - s->y[i])};
}

static void put_point(struct cursors *cursors, int which, const struct snap_point *point)
{
    cursors->at[which].set = true;
    cursors->at[which].t = point->t;
    cursors->at[which].t_uncertainty = point->uncertainty;
    cursors->at[which].y = point->y;
    cursors->at[which].crossing = point->crossing;
    cursors->at[which].amplitude = NAN;
}

void cursor_put(struct cursors *cursors, const struct ground *g, int which, double t, double reach)
{
    const struct series *s = &g->series;
    if (s->n == 0)
        return;
    t = fmin(fmax(t, s->t[0]), s->t[s->n - 1]);
    struct snap_search search = {.t = t};
    if (cursors->snap == SNAP_CROSSING || cursors->snap == SNAP_PEAK)
        each_position(g, cursors->snap, keep_nearest, &search);
    const struct snap_point point = search.found && fabs(search.best.t - t) <= reach ? search.best
                                    : cursors->snap == SNAP_SAMPLE ? nearest_sample(g, t)
                                                                   : no_snap(g, t);
    put_point(cursors, which, &point);
}

/* ---- moves ---- */

static bool keep_next(void *context, const struct snap_point *point)
{
    struct snap_search *search = context;
    const bool beyond = search->forward ? point->t > search->t : point->t < search->t;
    if (beyond)
        search->best = *point;
    search->found |= beyond;
    return !(beyond && search->forward) && (beyond || search->forward);
}

bool cursor_jump(struct cursors *cursors, const struct ground *g, bool forward, struct error *error)
{
    const double t = cursors->at[cursors->active].t, near = 1e-6 * ground_spacing(g);
    const bool peak = cursors->snap == SNAP_PEAK;
    struct snap_search search = {.t = t + (forward ? near : -near), .forward = forward};
    each_position(g, peak ? SNAP_PEAK : SNAP_CROSSING, keep_next, &search);
    if (!search.found)
        return error_set(error, ERROR_COMMAND, "there is no %s %s t = %.6g s in %s",
                         peak ? "peak" : "up-crossing", forward ? "after" : "before", t, g->name);
    put_point(cursors, cursors->active, &search.best);
    return true;
}

static bool keep_number(void *context, const struct snap_point *point)
{
    struct snap_search *search = context;
    search->best = *point;
    search->found = point->crossing == search->number;
    return !search->found;
}

bool cursor_span(struct cursors *cursors, const struct ground *g, double n, struct error *error)
{
    const struct series *s = &g->series;
    if (cursors->at[0].crossing > 0) {
        struct snap_search search = {.number = cursors->at[0].crossing + (int)fmin(n, 1e9)};
        each_position(g, SNAP_CROSSING, keep_number, &search);
        if (!search.found)
            return error_set(error, ERROR_COMMAND,
                             "%s has up-crossings up to #%d: from #%d that is %d period%s", g->name,
                             search.best.crossing, cursors->at[0].crossing,
                             search.best.crossing - cursors->at[0].crossing,
                             search.best.crossing - cursors->at[0].crossing == 1 ? "" : "s");
        put_point(cursors, 1, &search.best);
        return true;
    }
    if (!g->overview.oscillates)
        return error_set(error, ERROR_COMMAND, "%s has no period to count: %s", g->name,
                         g->overview.reason);
    const double t = cursors->at[0].t + n * g->overview.period;
    if (t > s->t[s->n - 1])
        return error_set(error, ERROR_COMMAND,
                         "%s ends at t = %.6g s, before %g periods from A have passed", g->name,
                         s->t[s->n - 1], n);
    cursor_put(cursors, g, 1, t, 0.25 * g->overview.period);
    return true;
}

void cursor_spread(struct cursors *cursors, const struct ground *g)
{
    const struct series *s = &g->series;
    cursor_put(cursors, g, 0, s->t[0], HUGE_VAL);
    cursor_put(cursors, g, 1, s->t[s->n - 1], HUGE_VAL);
    if (cursors->at[0].t < cursors->at[1].t)
        return;
    const struct snap_point first = no_snap(g, s->t[0]), last = no_snap(g, s->t[s->n - 1]);
    put_point(cursors, 0, &first);
    put_point(cursors, 1, &last);
}

void cursor_settle(struct cursors *cursors, const struct ground *g)
{
    const double dt = fabs(cursors->at[1].t - cursors->at[0].t);
    const int a = cursors->at[0].crossing, b = cursors->at[1].crossing;
    struct error ignored;
    snprintf(cursors->of, sizeof cursors->of, "%s", g->name);
    cursors->samples = g->series.n;
    cursors->quantity = g->series.quantity;
    double periods = a > 0 && b > 0           ? abs(b - a)
                     : g->overview.oscillates ? nearbyint(dt / g->overview.period)
                                              : 0;
    cursors->periods = periods >= 1 ? periods : NAN;
    for (int i = 0; i < 2; i++) {
        struct reading reading;
        const bool known =
            g->overview.oscillates &&
            series_amplitudes(&g->series, g->arena, &cursors->at[i].t, 1, 0, &reading, &ignored);
        cursors->at[i].amplitude = known ? reading.amplitude.value : NAN;
    }
}

void cursors_refresh(struct session *session)
{
    struct cursors *cursors = &session->view.cursors;
    struct arena arena = {0};
    struct ground ground;
    struct error ignored;
    struct plot_plane plane;
    if (cursors->plane && !cursor_plane(session, &plane))
        cursors->plane = cursors->shown = false;
    if (!cursors->shown || cursors->plane)
        return;
    /* Cheap where nothing has changed: the same run, as long as before. */
    const struct run *run = session_run(session);
    char name[LIMIT_NAME + 16] = "";
    if (run && !cursors->on_data)
        snprintf(name, sizeof name, "run %d", run->number);
    if (name[0] && strcmp(name, cursors->of) == 0 && trace_count(run->trace) == cursors->samples)
        return;
    if (ground_open(session, &arena, &ground, &ignored)) {
        if (strcmp(ground.name, cursors->of) != 0 || ground.series.n != cursors->samples) {
            for (int i = 0; i < 2; i++)
                cursor_put(cursors, &ground, i, cursors->at[i].t,
                           cursors->at[i].crossing > 0 ? HUGE_VAL : 0);
            cursor_settle(cursors, &ground);
        }
    } else {
        cursors->shown = false;
    }
    arena_reset(&arena);
}
