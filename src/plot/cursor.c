/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors of time plots: the points that they snap to (samples, crossings, peaks), their
 * moves, and what follows from their positions. ground_open() finds the points; then the functions
 * that move a cursor; then cursor_settle(). */
#include <hooke/plot/cursor.h>
#include <hooke/data.h>
#include <hooke/run.h>

#include <hooke/base/numeric.h>
#include <hooke/session/series_tools.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- samples ---- */

/* Returns the mean time [s] between two samples. */
double ground_spacing(const struct ground *g)
{
    return (g->series.t[g->series.n - 1] - g->series.t[0]) / (double)(g->series.n - 1);
}

/* Returns the last sample at or before t that has another after it. */
static size_t sample_before(const struct series *s, double t)
{
    const size_t index = first_from(s->t, s->n - 1, t);
    return index > 0 && (index == s->n - 1 || s->t[index] > t) ? index - 1 : index;
}

/* Returns the sample nearest to t, whose time is uncertain by the spacing, or the point
 * interpolated between two samples if `inside`. */
static struct snap_point sample_point(const struct ground *g, double t, bool inside)
{
    const struct series *s = &g->series;
    const size_t i = sample_before(s, t);
    const double x = (t - s->t[i]) / (s->t[i + 1] - s->t[i]);
    const size_t nearest = i + (x > 0.5);
    if (inside)
        return (struct snap_point){t, NAN, s->y[i] + x * (s->y[i + 1] - s->y[i]), 0};
    return (struct snap_point){s->t[nearest], ground_spacing(g) / sqrt(12), s->y[nearest], 0};
}

/* ---- peaks ---- */

/* Sums over the samples of a peak: of the powers 0 to 4 of x, and of y times the powers 0 to 2. */
struct peak_sums {
    double x[5], y[3];
};

/* Sums over the samples a to b that are neither spikes nor far down the flanks of the peak at
 * sample `top`; x is the time from `middle` in units of `scale`. */
static struct peak_sums sum_peak_samples(const struct ground *g, size_t top, size_t a, size_t b,
                                         double middle, double scale)
{
    const struct series *s = &g->series;
    const double flank = s->y[top] - 0.25 * (g->overview.high - g->overview.low);
    struct peak_sums sums = {{0}, {0}};
    for (size_t i = a; i <= b; i++) {
        if (!(s->y[i] >= flank && s->y[i] <= s->y[top]))
            continue;
        double power = 1;
        for (int k = 0; k < 5; k++, power *= (s->t[i] - middle) / scale) {
            sums.x[k] += power;
            if (k < 3)
                sums.y[k] += power * (s->y[i] - s->y[top]);
        }
    }
    return sums;
}

/* Finds the vertex of the least-squares parabola through the samples around the highest one between
 * t_begin and t_end. Returns false if that is at an end, or if the parabola has no maximum there.
 */
static bool peak_between(const struct ground *g, double t_begin, double t_end,
                         struct snap_point *point)
{
    static const double width_periods = 0.1; /* half the width of the fitted part, in periods */
    const struct series *s = &g->series;
    /* only spikes are above the ceiling */
    const double ceiling = g->overview.high + 4 * g->overview.noise,
                 width = g->overview.oscillates ? width_periods * g->overview.period : 0;
    size_t top = s->n;
    for (size_t i = sample_before(s, t_begin); i < s->n && s->t[i] <= t_end; i++)
        if (s->t[i] >= t_begin && s->y[i] <= ceiling && (top == s->n || s->y[i] > s->y[top]))
            top = i;
    if (top == s->n || top == 0 || top + 1 == s->n)
        return false;
    size_t a = top - 1, b = top + 1;
    while (a > 0 && s->t[top] - s->t[a - 1] <= width)
        a--;
    while (b + 1 < s->n && s->t[b + 1] - s->t[top] <= width)
        b++;
    /* y = p + q x + r x^2 with x counted from the mean: the sum of x is 0 in the equations. */
    const double scale = s->t[b] - s->t[a];
    struct peak_sums sums = sum_peak_samples(g, top, a, b, s->t[top], scale);
    const double mean = s->t[top] + scale * sums.x[1] / sums.x[0];
    sums = sum_peak_samples(g, top, a, b, mean, scale);
    const double *x = sums.x, *y = sums.y;
    const double det = x[0] * (x[2] * x[4] - x[3] * x[3]) - x[2] * x[2] * x[2];
    const double q =
        (x[0] * (y[1] * x[4] - y[2] * x[3]) - x[2] * x[2] * y[1] + x[2] * x[3] * y[0]) / det;
    const double r = (x[0] * (x[2] * y[2] - x[3] * y[1]) - x[2] * x[2] * y[0]) / det;
    const double p = (y[0] - x[2] * r) / x[0], vertex = -q / (2 * r);
    if (!(r < 0) || !(fabs(vertex) <= 0.5))
        return false;
    *point =
        (struct snap_point){.t = mean + vertex * scale,
                            .uncertainty = g->overview.noise * scale / (2 * fabs(r) * sqrt(x[2])),
                            .y = s->y[top] + p + q * vertex + r * vertex * vertex};
    return true;
}

/* ---- crossings ---- */

/* Returns true if a time is far from the up-crossings that a periodic motion would have. */
static bool is_off_beat(const struct period *beat, double t)
{
    static const double deviation_limit = 0.15; /* [periods] */
    return fabs(remainder(t - beat->first, beat->period.value)) >
           deviation_limit * beat->period.value;
}

/* Returns the number of up-crossings that are off the beat. */
static size_t count_late(const struct crossing *crossing, size_t count, const struct period *beat)
{
    size_t late = 0;
    for (size_t i = 0; i < count; i++)
        late += crossing[i].rising && is_off_beat(beat, crossing[i].t);
    return late;
}

/* Finds period and phase (beat) of most up-crossings of a recording, so that the others can be left
 * out as spikes of the sensor. The phase is that of the line through all periods or of one of the
 * first crossings, whichever leaves fewer off the beat, because the first crossing may be a spike
 * itself. Returns false if too many are off. */
static bool find_beat(const struct ground *g, const struct crossing *crossing, size_t count,
                      struct period *beat)
{
    /* Number of crossings whose phase is tried, and the largest fraction of all up-crossings that
     * may be off. */
    enum { TRIED = 32 };
    static const double late_max = 0.34;
    struct error ignored;
    if (!g->overview.oscillates || !series_tools()->period(&g->series, g->arena, beat, &ignored))
        return false;
    size_t all = 0, best = count_late(crossing, count, beat);
    for (size_t i = 0; i < count; i++) {
        const struct period other = {.period = {g->overview.period, 0}, .first = crossing[i].t};
        all += crossing[i].rising;
        const size_t late =
            crossing[i].rising && i < TRIED ? count_late(crossing, count, &other) : best;
        if (late < best) {
            best = late;
            *beat = other;
        }
    }
    return (double)best <= late_max * (double)all;
}

/* Finds all crossings of the mean, in the arena. Returns NULL if out of memory. */
static struct crossing *find_crossings(const struct ground *g, size_t *count)
{
    const struct overview *o = &g->overview;
    const struct series_tools *tools = series_tools();
    size_t capacity = o->oscillates ? 2 * (size_t)o->periods + 16 : 64;
    struct crossing *crossing;
    *count = 0;
    while ((crossing = arena_array(g->arena, capacity, sizeof *crossing)) && tools &&
           (*count = tools->crossings(&g->series, o, o->mean, crossing, capacity)) > capacity)
        capacity = *count;
    return crossing;
}

/* Finds the points that cursors snap to: up-crossings, numbered in periods from the first, and the
 * peaks after them if wanted. Returns false if out of memory. */
static bool find_points(struct ground *g, bool peaks, struct error *error)
{
    size_t count;
    const struct crossing *crossing = find_crossings(g, &count);
    if (!crossing || !(g->crossing = arena_array(g->arena, count + 1, sizeof *g->crossing)) ||
        !(g->peak = arena_array(g->arena, count + 1, sizeof *g->peak)))
        return error_memory(error);
    struct period beat;
    const bool steady = g->data && find_beat(g, crossing, count, &beat);
    int number = 0;
    for (size_t i = 0; i < count; i++) {
        const double t = crossing[i].t;
        if (!crossing[i].rising || (steady && is_off_beat(&beat, t)))
            continue;
        /* Spikes and missed periods do not shift the numbers of a steady recording. */
        const int next = steady && g->crossings > 0
                             ? 1 + (int)nearbyint((t - g->crossing[0].t) / beat.period.value)
                             : number + 1;
        if (next <= number)
            continue;
        number = next;
        g->crossing[g->crossings++] =
            (struct snap_point){t, crossing[i].uncertainty, g->overview.mean, number};
        double t_falling;
        if (steady)
            t_falling = t + 0.5 * beat.period.value;
        else
            t_falling = i + 1 < count ? crossing[i + 1].t : (double)NAN;
        g->peaks += peaks && peak_between(g, t, t_falling, &g->peak[g->peaks]);
    }
    return true;
}

/* Computes the overview of a series (mean, extent, period), or only its extent if the module that
 * measures series is missing. */
static void compute_overview(const struct series *series, struct arena *arena,
                             struct overview *overview)
{
    const struct series_tools *tools = series_tools();
    if (tools) {
        tools->overview(series, arena, overview);
        return;
    }
    *overview = (struct overview){.low = HUGE_VAL,
                                  .high = -HUGE_VAL,
                                  .period = NAN,
                                  .periods = NAN,
                                  .reason = "this program cannot find periods"};
    for (size_t i = 0; i < series->n; i++) {
        overview->low = fmin(overview->low, series->y[i]);
        overview->high = fmax(overview->high, series->y[i]);
    }
    overview->mean = (overview->low + overview->high) / 2;
}

/* Opens the run or the recording under the cursors, and finds the points that they snap to. Returns
 * false with an error if there is none or if it has less than two samples. */
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
    compute_overview(&ground->series, arena, &ground->overview);
    return find_points(ground, cursors->snap == SNAP_PEAK, error);
}

/* ---- moves ---- */

/* Sets a cursor to a point. */
static void cursor_set_point(struct cursors *cursors, int which, const struct snap_point *point)
{
    cursors->cursor[which].set = true;
    cursors->cursor[which].t = point->t;
    cursors->cursor[which].t_uncertainty = point->uncertainty;
    cursors->cursor[which].y = point->y;
    cursors->cursor[which].crossing = point->crossing;
    cursors->cursor[which].amplitude = NAN;
}

/* Returns the points that cursors snap to, or the crossings if they snap to samples or nothing. */
static const struct snap_point *snap_points(const struct cursors *cursors, const struct ground *g,
                                            size_t *count)
{
    const bool peaks = cursors->snap == SNAP_PEAK;
    *count = peaks ? g->peaks : g->crossings;
    return peaks ? g->peak : g->crossing;
}

/* Sets a cursor to time t, or to the nearest point that it snaps to within `reach` [s]. */
void cursor_put(struct cursors *cursors, const struct ground *g, int which, double t, double reach)
{
    const struct series *s = &g->series;
    size_t count;
    const struct snap_point *points = snap_points(cursors, g, &count), *nearest = NULL;
    if (s->n == 0)
        return;
    t = fmin(fmax(t, s->t[0]), s->t[s->n - 1]);
    const bool snaps = cursors->snap == SNAP_CROSSING || cursors->snap == SNAP_PEAK;
    for (size_t i = 0; snaps && i < count; i++)
        if (fabs(points[i].t - t) <= (nearest ? fabs(nearest->t - t) : reach))
            nearest = &points[i];
    const struct snap_point other = sample_point(g, t, cursors->snap != SNAP_SAMPLE);
    cursor_set_point(cursors, which, nearest ? nearest : &other);
}

/* Moves the active cursor to the next or the previous point. Returns false with an error if there
 * is none. */
bool cursor_jump(struct cursors *cursors, const struct ground *g, bool forward, struct error *error)
{
    const double t = cursors->cursor[cursors->active].t, t_tolerance = 1e-6 * ground_spacing(g);
    size_t count, next = 0;
    const struct snap_point *points = snap_points(cursors, g, &count);
    while (next < count && points[next].t <= (forward ? t + t_tolerance : t - t_tolerance))
        next++;
    if (forward ? next == count : next == 0) {
        const char *const direction = forward ? "after" : "before";
        return error_set(error, ERROR_COMMAND, "there is no %s %s t = %.6g s in %s",
                         cursors->snap == SNAP_PEAK ? "peak" : "up-crossing", direction, t,
                         g->name);
    }
    cursor_set_point(cursors, cursors->active, &points[forward ? next : next - 1]);
    return true;
}

/* Sets cursor B to the up-crossing n periods after that of A. Returns false with an error if there
 * is none. */
static bool span_crossings(struct cursors *cursors, const struct ground *g, int n,
                           struct error *error)
{
    const int first = cursors->cursor[0].crossing;
    for (size_t i = 0; i < g->crossings; i++)
        if (g->crossing[i].crossing == first + n) {
            cursor_set_point(cursors, 1, &g->crossing[i]);
            return true;
        }
    const int last = g->crossings > 0 ? g->crossing[g->crossings - 1].crossing : first;
    return error_set(error, ERROR_COMMAND,
                     "%s has up-crossings up to #%d: from #%d that is %d period%s", g->name, last,
                     first, last - first, last - first == 1 ? "" : "s");
}

/* Sets cursor B n periods after A, by counting crossings or by the mean period. Returns false with
 * an error if the data have no period or end before. */
bool cursor_span(struct cursors *cursors, const struct ground *g, double n, struct error *error)
{
    const struct series *s = &g->series;
    if (cursors->cursor[0].crossing > 0)
        return span_crossings(cursors, g, (int)fmin(n, 1e9), error);
    if (!g->overview.oscillates)
        return error_set(error, ERROR_COMMAND, "%s has no period to count: %s", g->name,
                         g->overview.reason);
    const double t = cursors->cursor[0].t + n * g->overview.period;
    if (t > s->t[s->n - 1])
        return error_set(error, ERROR_COMMAND,
                         "%s ends at t = %.6g s, before %g periods from A have passed", g->name,
                         s->t[s->n - 1], n);
    cursor_put(cursors, g, 1, t, 0.25 * g->overview.period);
    return true;
}

/* Sets the cursors to the first and the last point, or to both ends if these are the same. */
void cursor_spread(struct cursors *cursors, const struct ground *g)
{
    const double end[] = {g->series.t[0], g->series.t[g->series.n - 1]};
    for (int i = 0; i < 2; i++)
        cursor_put(cursors, g, i, end[i], HUGE_VAL);
    const bool apart = cursors->cursor[0].t < cursors->cursor[1].t;
    for (int i = 0; i < 2 && !apart; i++) {
        const struct snap_point point = sample_point(g, end[i], true);
        cursor_set_point(cursors, i, &point);
    }
}

/* Sets both cursors again at their times, after the data under them have changed. A cursor on a
 * crossing goes to the nearest crossing, however far. */
void cursors_put_again(struct cursors *cursors, const struct ground *g)
{
    for (int i = 0; i < 2; i++)
        cursor_put(cursors, g, i, cursors->cursor[i].t,
                   cursors->cursor[i].crossing > 0 ? HUGE_VAL : 0);
}

/* Updates what follows from the positions of both cursors: their distance in periods and the
 * amplitudes. */
void cursor_settle(struct cursors *cursors, const struct ground *g)
{
    const double dt = fabs(cursors->cursor[1].t - cursors->cursor[0].t);
    const int a = cursors->cursor[0].crossing, b = cursors->cursor[1].crossing;
    snprintf(cursors->subject, sizeof cursors->subject, "%s", g->name);
    cursors->samples = g->series.n;
    cursors->quantity = g->series.quantity;
    double periods;
    if (a > 0 && b > 0)
        periods = abs(b - a);
    else
        periods = g->overview.oscillates ? nearbyint(dt / g->overview.period) : 0;
    cursors->periods = periods >= 1 ? periods : NAN;
    for (int i = 0; i < 2; i++)
        cursors->cursor[i].amplitude =
            g->overview.oscillates
                ? series_tools()->amplitude(&g->series, cursors->cursor[i].t, g->arena)
                : NAN;
}

/* Finds the cursors' points again after a command that may have changed the data under them, and
 * hides them if there are no data any more. */
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
    /* Nothing is done for the same run of the same length. */
    const struct run *run = cursors->on_data ? NULL : session_run(session);
    char name[LIMIT_NAME + 16] = "";
    if (run)
        snprintf(name, sizeof name, "run %d", run->number);
    if (run && strcmp(name, cursors->subject) == 0 && trace_count(run->trace) == cursors->samples)
        return;
    cursors->shown = ground_open(session, &arena, &ground, &ignored);
    if (cursors->shown &&
        (strcmp(ground.name, cursors->subject) != 0 || ground.series.n != cursors->samples)) {
        cursors_put_again(cursors, &ground);
        cursor_settle(cursors, &ground);
    }
    arena_reset(&arena);
}
