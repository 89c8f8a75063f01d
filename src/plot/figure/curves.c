/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the rows of a run that a figure draws (all, or those that look the same on the screen),
 * and computes values at them. choose_rows() comes first, then values_at_rows() or state_at_rows().
 */
#include <hooke/run.h>
#include <hooke/base/cancel.h>
#include <hooke/plot/curves.h>

#include <hooke/base/numeric.h>
#include <hooke/plot.h>

#include <math.h>
#include <string.h>

#define ROWS_ALL 4096 /* largest number of rows that a screen draws all */
/* Number of shares into which the rows of a figure that is drawn once are divided: more than a
 * screen or a page has columns. */
#define SHARES_DRAWN 8192
/* largest number of rows that a figure which is drawn once draws all */
#define ROWS_DRAWN_MAX (8 * SHARES_DRAWN)
#define VISITS_A_PERIOD 256 /* rows of each period that a screen examines */
/* rows in all that a screen examines */
#define VISITS_MAX (1 << 17)

/* ---- rows ---- */

#define VARIABLES_MAX 8 /* largest number of variables whose extremes are kept */
#define EXTREMES_MAX (2 * VARIABLES_MAX + 2)

/* Returns the row examined in the stride that begins at i, at a pseudo-random place: an oscillation
 * could be in step with a regular one. */
static size_t visited_row(size_t i, size_t stride)
{
    const uint64_t mixed = (uint64_t)(i / stride) * 0x9E3779B97F4A7C15u >> 40;
    return i + (stride > 1 ? (size_t)(mixed % stride) : 0);
}

/* Computes the quantities whose maxima are searched: each variable and its negative and, for second
 * order, q v of the first coordinate and its negative. Returns their number. */
static int compute_extreme_values(const struct run *run, const double *y,
                                  double value[EXTREMES_MAX])
{
    const int variables = run->system.n < VARIABLES_MAX ? run->system.n : VARIABLES_MAX;
    int count = 0;
    for (int i = 0; i < variables; i++) {
        value[count++] = y[i];
        value[count++] = -y[i];
    }
    if (run->system.order == 2) {
        value[count++] = y[0] * y[run->system.n / 2];
        value[count++] = -(y[0] * y[run->system.n / 2]);
    }
    return count;
}

/* Inserts a row into n ascending ones unless it is among them. Returns the new number. */
static size_t row_insert(size_t *row, size_t n, size_t next)
{
    size_t index = n;
    while (index > 0 && row[index - 1] > next)
        index--;
    if (index > 0 && row[index - 1] == next)
        return n;
    memmove(row + index + 1, row + index, (n - index) * sizeof *row);
    row[index] = next;
    return n + 1;
}

/* Chooses rows of the share [begin, end): the first, the last, and those where the variables, and q
 * v of the first coordinate, are least and largest. At these the positions, velocities and the
 * error of the energy have their extremes (the modified energy of a symplectic method differs by
 * terms in q v, q^2, v^2; Hairer, Lubich, Wanner IX.8). Returns their number. */
static size_t choose_rows_of_share(const struct run *run, size_t begin, size_t end, size_t stride,
                                   size_t *chosen_row)
{
    size_t extreme_row[EXTREMES_MAX + 2];
    double best[EXTREMES_MAX], value[EXTREMES_MAX];
    const int extremes = compute_extreme_values(run, trace_state(run->trace, begin), best);
    for (int e = 0; e <= extremes; e++)
        extreme_row[e] = begin;
    extreme_row[extremes + 1] = end - 1;
    for (size_t i = begin; i < end; i += stride) {
        const size_t row = visited_row(i, stride) < end ? visited_row(i, stride) : end - 1;
        compute_extreme_values(run, trace_state(run->trace, row), value);
        for (int e = 0; e < extremes; e++) {
            if (value[e] > best[e]) {
                best[e] = value[e];
                extreme_row[e] = row;
            }
        }
    }
    size_t n = 0;
    for (int i = 0; i < extremes + 2; i++)
        n = row_insert(chosen_row, n, extreme_row[i]);
    return n;
}

/* Chooses of each share of the rows the first, the last, and those where a drawn variable is least
 * and largest. A line through them covers the same pixels as one through all rows. Returns false
 * with an error if out of memory. */
static bool choose_extremes(const struct run *run, const struct row_request *request, size_t first,
                            size_t end, struct arena *arena, struct chosen_rows *rows,
                            struct error *error)
{
    const size_t each = (end - first) / SHARES_DRAWN;
    const size_t most = 2 + 2 * (size_t)request->count;
    *rows = (struct chosen_rows){
        arena_array(arena, ((end - first) / each + 1) * most, sizeof *rows->row), 0};
    if (!rows->row)
        return error_memory(error);
    for (size_t bucket_begin = first, bucket_end; bucket_begin < end; bucket_begin = bucket_end) {
        size_t *row = rows->row + rows->n, n = 0;
        bucket_end = bucket_begin + each < end ? bucket_begin + each : end;
        n = row_insert(row, row_insert(row, n, bucket_begin), bucket_end - 1);
        for (int v = request->first; v < request->first + request->count; v++) {
            size_t low = bucket_begin, high = bucket_begin;
            double least = trace_state(run->trace, bucket_begin)[v], most_value = least;
            for (size_t i = bucket_begin; i < bucket_end; i++) {
                const double value = trace_state(run->trace, i)[v];
                if (value < least) {
                    least = value;
                    low = i;
                } else if (value > most_value) {
                    most_value = value;
                    high = i;
                }
            }
            n = row_insert(row, row_insert(row, n, low), high);
        }
        rows->n += n;
    }
    return true;
}

/* Returns the smallest power of two that is at least `min`. */
static size_t power_of_two(double min)
{
    size_t power = 1;
    while ((double)power < min)
        power *= 2;
    return power;
}

/* Finds the rows [*first, *end) in the window of time; for a screen with one neighbour on each
 * side. */
static void find_rows(const struct run *run, const struct row_request *request, size_t *first,
                      size_t *end)
{
    const size_t count = trace_count(run->trace);
    const bool backwards = trace_time(run->trace, count - 1) < trace_time(run->trace, 0);
    const double last = backwards ? request->t_begin : request->t_end;
    *first = trace_row_at(run->trace, backwards ? request->t_end : request->t_begin);
    *end = trace_row_at(run->trace, last);
    while (*end < count && trace_time(run->trace, *end) == last)
        ++*end;
    if (request->screen) {
        *first -= *first > 0;
        *end += *end < count;
    }
    if (*end < *first)
        *end = *first;
}

/* Chooses the rows of a run that a figure draws and stores their indices in *rows (in the arena):
 * all if they are few, else the extremes of each bucket of rows, about four buckets per column of
 * the screen. Strides and buckets are powers of two and begin at multiples of themselves, so that
 * rows once chosen stay chosen while a run grows. Returns false with an error if out of memory. */
bool choose_rows(const struct run *run, const struct row_request *request, struct arena *arena,
                 struct chosen_rows *rows, struct error *error)
{
    size_t first, end;
    find_rows(run, request, &first, &end);
    if (request->count > 0 && !request->screen && request->columns < SHARES_DRAWN &&
        end - first > ROWS_DRAWN_MAX)
        return choose_extremes(run, request, first, end, arena, rows, error);
    const double n = (double)(end - first),
                 buckets = 4.0 * (request->columns > 0 ? request->columns : 1);
    const double a_period =
        n * request->period / (request->t_end - request->t_begin) / VISITS_A_PERIOD;
    const double stride_period = a_period > 2 ? fmin(a_period / 2, n) : 1;
    const size_t stride = request->screen ? power_of_two(fmax(stride_period, n / VISITS_MAX)) : 1;
    const bool all = !request->screen || n / (double)stride <= ROWS_ALL;
    const size_t bucket = all ? stride : power_of_two(fmax(n / buckets, (double)stride));
    *rows = (struct chosen_rows){
        arena_array(arena,
                    (end - first) / bucket * (all ? 1 : EXTREMES_MAX + 2) + 3 * (EXTREMES_MAX + 2),
                    sizeof *rows->row),
        0};
    if (!rows->row)
        return error_memory(error);
    for (size_t bucket_begin = first, bucket_end; bucket_begin < end; bucket_begin = bucket_end) {
        bucket_end = bucket_begin - bucket_begin % bucket + bucket;
        bucket_end = bucket_end < end ? bucket_end : end;
        if (all)
            rows->row[rows->n++] = bucket_begin;
        else
            rows->n +=
                choose_rows_of_share(run, bucket_begin, bucket_end, stride, rows->row + rows->n);
    }
    if (rows->n > 0 && rows->row[rows->n - 1] < end - 1)
        rows->row[rows->n++] = end - 1;
    return true;
}

/* ---- values ---- */

/* Returns true if the run has the parameters and forces that it started with, as far as can be told
 * afterwards. */
bool run_never_changed(const struct run *run)
{
    struct system start;
    struct error ignored;
    if (!scene_bind(&run->scene, &start, &ignored) || start.terms != run->system.terms ||
        start.mass != run->system.mass || (run->plan.ledger && start.conservative))
        return false;
    for (int i = 0; i < start.terms; i++)
        if (!bound_term_equal(&start.term[i], &run->system.term[i]))
            return false;
    return true;
}

/* Returns true if the observable can be computed from a recorded row alone: it depends on the state
 * only, or the run is long and the system was the same all the time. */
static bool follows_from_row(const struct run *run, const struct observable *observable)
{
    for (int i = 0; i < run->system.n; i++)
        if (observable_named(system_variable(&run->system, i).name) == observable)
            return true;
    return observable->needs == 0 ||
           (trace_count(run->trace) > ROWS_ALL &&
            !(observable->needs & (NEED_WORK | NEED_RATIO | NEED_CENTRE)) &&
            run->system.order == 2 &&
            (run->plan.exact_known || !(observable->needs & NEED_EXACT)) && run_never_changed(run));
}

void state_at_rows(const struct run *run, int i, const struct chosen_rows *rows, double *values)
{
    for (size_t row = 0; row < rows->n; row++)
        values[row] = trace_state(run->trace, rows->row[row])[i];
}

/* Computes an observable at the chosen rows, from these rows alone if that is possible, else from
 * the whole run. Returns false with an error if out of memory or cancelled. */
bool values_at_rows(const struct run *run, const struct observable *observable,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error)
{
    if (!follows_from_row(run, observable)) {
        double *column = arena_array(arena, trace_count(run->trace), sizeof *column);
        if (!column)
            return error_memory(error);
        if (!run_column(run, observable, column, error))
            return false;
        for (size_t i = 0; i < rows->n; i++)
            values[i] = column[rows->row[i]];
        return true;
    }
    double exact[LIMIT_VARIABLES];
    struct sample sample = {.run = run, .exact = exact, .system = &run->system};
    for (size_t i = 0; i < rows->n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(run->cancel))
            return error_set(error, ERROR_CANCELLED, "stopped");
        sample.t = trace_time(run->trace, rows->row[i]);
        sample.y = trace_state(run->trace, rows->row[i]);
        if (observable->needs & NEED_EXACT)
            system_exact(&run->system, run->system.t0, run->system.start, sample.t, exact, NULL);
        values[i] = observable->value(&sample);
    }
    return true;
}

static double acceleration(const struct system *system, double t, const double *y)
{
    double a[LIMIT_VARIABLES];
    system_acceleration(system, t, y, a);
    return a[0];
}

/* Returns the acceleration at the state interpolated between two rows, at the fraction x of the
 * step h. */
static double acceleration_between(const struct system *system, double t, double x, double h,
                                   const double *left, const double *right)
{
    double state[LIMIT_VARIABLES];
    const int half = system->n / 2;
    for (int i = 0; i < half; i++) {
        state[i] = hermite(x, h, left[i], left[i + half], right[i], right[i + half]);
        state[i + half] = (1 - x) * left[i + half] + x * right[i + half];
    }
    return acceleration(system, t, state);
}

/* Returns a derivative of the first coordinate (0, 1 or 2) at t [s], interpolated between rows by
 * Hermite polynomials, or NAN outside of the run. */
double run_motion(const struct run *run, double t, int derivative)
{
    const size_t next_row = trace_row_at(run->trace, t), count = trace_count(run->trace);
    const int half = run->system.order == 2 ? run->system.n / 2 : 0;
    if (next_row == count || (half == 0 && derivative > 0))
        return NAN;
    const double *right = trace_state(run->trace, next_row);
    const double b = trace_time(run->trace, next_row);
    const struct system *system = run_system_to(run, next_row);
    if (b == t)
        return derivative == 2 ? acceleration(system, t, right) : right[derivative * half];
    if (next_row == 0)
        return NAN;
    const double *left = trace_state(run->trace, next_row - 1);
    const double a = trace_time(run->trace, next_row - 1), h = b - a, x = (t - a) / h;
    if (half == 0)
        return (1 - x) * left[0] + x * right[0];
    if (derivative == 0)
        return hermite(x, h, left[0], left[half], right[0], right[half]);
    if (derivative == 1)
        return hermite(x, h, left[half], acceleration(system, a, left), right[half],
                       acceleration(system, b, right));
    return acceleration_between(system, t, x, h, left, right);
}

double run_position(const struct run *run, double t)
{
    return run_motion(run, t, 0);
}
