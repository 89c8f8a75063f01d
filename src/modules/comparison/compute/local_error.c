/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measures the local error of a method and finds the term of the Taylor expansion that it is. */
#include "modules/comparison/compute/local_error.h"
#include "modules/comparison/compute/verify.h"

#include <hooke/base/cancel.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum {
    STATES = 4,           /* states at which a multiple has to be the same */
    NODES = 9,            /* nodes of the polynomial whose derivatives are those of the solution */
    REFERENCE_STEPS = 48, /* steps of the reference inside one step of the method */
    SAMPLES = 22,
    STEPS_BETWEEN_LOOKS = 256, /* steps between two looks at Ctrl-C */
    STEPS_MAX = 1000000,       /* steps of the reference from the start to the state */
    DENOMINATOR_MAX = 20000
};
/* The longest step in units of the shortest time constant, and the distance of the nodes. */
static const double longest_step = 0.5, node_distance = 0.09;
/* Errors below this multiple of the rounding of the state do not count. */
static const double rounding_factor = 300;
/* A slope this close to a whole number is that exponent. */
static const double exponent_distance = 0.25;
/* A multiple has to be known this well before a fraction is named, and differ by less between
 * states. */
static const double multiple_accuracy = 1e-4;
/* Least relative error that a multiple is credited with, as bounds are estimates. */
static const double multiple_rounding = 1e-6 / 3;

/* Parameters that all measurements on one solution share. */
struct local_search {
    const struct system *system;
    const struct method *method, *reference;
    enum drag drag, reference_drag;
    double rate;  /* [1/s] fastest rate of the linearised scene */
    double *work; /* memory for the steps of both methods */
    const struct cancel *cancel;
};

/* Takes `steps` equal steps over h [s]; h may be negative. Returns false if one fails. */
static bool take_steps(const struct local_search *search, const struct method *method, double t,
                       double h, int steps, double *y)
{
    double low[LIMIT_VARIABLES] = {0};
    struct step step = {.system = search->system,
                        .drag = method == search->method ? search->drag : search->reference_drag,
                        .t = t,
                        .h = h / steps,
                        .y = y,
                        .low = steps > 1 ? low : NULL,
                        .work = search->work};
    for (int i = 0; i < steps; i++)
        if ((i % STEPS_BETWEEN_LOOKS == 0 && cancelled(search->cancel)) ||
            method_step(method, &step) != STEP_OK)
            return false;
    return true;
}

/* Computes the solution at t + h from the state y at t, in place. */
static bool follow_solution(const struct local_search *search, double t, double h, double *y)
{
    double start[LIMIT_VARIABLES];
    if (!system_has_exact(search->system))
        return take_steps(search, search->reference, t, h, REFERENCE_STEPS, y);
    for (int i = 0; i < search->system->n; i++)
        start[i] = y[i];
    system_exact(search->system, t, start, t + h, y, NULL);
    return isfinite(y[0]);
}

/* ---- derivatives of the solution ---- */

/* Differentiates the polynomial through values at -4 .. 4 (in units of the distance) at 0: order
 * times. Returns NAN if the two finest polynomials differ. */
static double central_derivative(const double value[NODES], int order)
{
    /* Newton's divided differences, then the coefficients of powers of x. */
    double table[NODES], power[NODES] = {0}, product[NODES + 1] = {1};
    for (int i = 0; i < NODES; i++)
        table[i] = value[i];
    for (int k = 1; k < NODES; k++)
        for (int i = NODES - 1; i >= k; i--)
            table[i] = (table[i] - table[i - 1]) / k;
    for (int k = 0; k < NODES; k++) {
        for (int i = 0; i <= k; i++)
            power[i] += table[k] * product[i];
        for (int i = k + 1; i >= 0; i--) /* times (x - node) */
            product[i] = (i > 0 ? product[i - 1] : 0) - (k - NODES / 2) * product[i];
    }
    double factorial = 1;
    for (int i = 2; i <= order; i++)
        factorial *= i;
    return power[order] * factorial;
}

/* Computes the q-th derivative of each variable of the solution through y at t, NAN where it cannot
 * be found. */
static void solution_derivatives(const struct local_search *search, double t, const double *y,
                                 const int *q, double *derivative)
{
    const int n = search->system->n;
    const double distance = node_distance / search->rate;
    double slope[NODES][LIMIT_VARIABLES], values[NODES];
    bool ok = true;
    for (int k = 0; k < NODES; k++) {
        const double h = (k - NODES / 2) * distance;
        double state[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++)
            state[i] = y[i];
        ok = ok && (h == 0 || follow_solution(search, t, h, state));
        if (ok)
            system_derivative(search->system, t + h, state, slope[k]);
    }
    for (int i = 0; i < n; i++) {
        derivative[i] = NAN;
        if (!ok || q[i] < 1 || q[i] > NODES - 2)
            continue;
        for (int k = 0; k < NODES; k++)
            values[k] = slope[k][i];
        derivative[i] = central_derivative(values, q[i] - 1) / pow(distance, q[i] - 1);
    }
}

/* ---- the leading term ---- */

/* Measures the errors of `count` single steps from y at t. */
static void measure_steps(const struct local_search *search, double t, const double *y,
                          const double *dt, int count, double (*error)[LIMIT_VARIABLES])
{
    const int n = search->system->n;
    for (int k = 0; k < count; k++) {
        double stepped[LIMIT_VARIABLES], exact[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++)
            stepped[i] = exact[i] = y[i];
        const bool ok = take_steps(search, search->method, t, dt[k], 1, stepped) &&
                        follow_solution(search, t, dt[k], exact);
        for (int i = 0; i < n; i++)
            error[k][i] = ok ? stepped[i] - exact[i] : NAN;
    }
}

/* Returns the size of errors of variable i that are rounding. */
static double rounding_of(const struct local_search *search, double t, const double *y, int i)
{
    double slope[LIMIT_VARIABLES];
    system_derivative(search->system, t, y, slope);
    return DBL_EPSILON * fmax(fabs(y[i]), fabs(slope[i]) * fmax(1 / search->rate, fabs(t)));
}

/* Errors of single steps whose lengths fall by the square root of 2, for extrapolation. */
struct samples {
    double dt[SAMPLES], error[SAMPLES][LIMIT_VARIABLES];
};

/*
 * Extrapolates error/dt^q of variable i to dt = 0 by Neville's scheme, from sample `finest` on with
 * more and more longer steps. Improves *value and its error bound *bound where it is more accurate.
 */
static void extrapolate(const struct samples *samples, int i, int q, int finest, double rounding,
                        double *value, double *bound)
{
    const double *dt = samples->dt, noise = 4 * rounding / pow(dt[finest], q);
    double table[SAMPLES], before = NAN;
    for (int m = 0; m <= finest && isfinite(samples->error[finest - m][i]); m++) {
        const int k = finest - m;
        double below = m > 0 ? table[0] : 0;
        table[0] = samples->error[k][i] / pow(dt[k], q);
        /* table[j] becomes the value at 0 of the polynomial through the j + 1 latest samples. */
        for (int j = 1; j <= m; j++) {
            const double old = j < m ? table[j] : 0;
            table[j] = table[j - 1] + (table[j - 1] - below) * dt[k] / (dt[k + j] - dt[k]);
            below = old;
        }
        if (m > 0 && fmax(fabs(table[m] - before), noise) < *bound) {
            *bound = fmax(fabs(table[m] - before), noise);
            *value = table[m];
        }
        before = table[m];
    }
}

/* Finds the exponent and the coefficient of variable i. Returns the relative error of the
 * coefficient, or NAN if there is none. */
static double find_leading(const struct samples *samples, int i, double rounding,
                           struct leading_error *leading)
{
    int last = SAMPLES - 1;
    double bound = HUGE_VAL;
    *leading = (struct leading_error){.exponent = 0, .coefficient = NAN, .derivative = NAN};
    while (last >= 0 && !(fabs(samples->error[last][i]) > rounding_factor * rounding))
        last--;
    if (last < 0)
        return NAN;
    leading->exponent = -1;
    if (last < 1)
        return NAN;
    const double slope = log(fabs(samples->error[last][i] / samples->error[last - 1][i])) /
                         log(samples->dt[last] / samples->dt[last - 1]),
                 nearest = round(slope);
    if (!(fabs(slope - nearest) < exponent_distance) || nearest < 1)
        return NAN;
    leading->exponent = (int)nearest;
    for (int finest = 1; finest <= last; finest++)
        extrapolate(samples, i, leading->exponent, finest, rounding, &leading->coefficient, &bound);
    return bound / fabs(leading->coefficient);
}

/* Returns true if n has no prime factor above 7, as the denominators of expansions do. */
static bool is_smooth(int n)
{
    static const int primes[] = {2, 3, 5, 7};
    for (size_t i = 0; i < COUNT_OF(primes); i++)
        while (n % primes[i] == 0)
            n /= primes[i];
    return n == 1;
}

/* Sets *numerator and *denominator to the simplest fraction within `tolerance` of x, found by the
 * continued fraction of x. Leaves both unchanged if there is none, if the denominator has large
 * prime factors, or if it is so large that some fraction would be found for any number. */
static void find_fraction(double x, double tolerance, int *numerator, int *denominator)
{
    double rest = fabs(x), p = 1, q = 0, p_before = 0, q_before = 1;
    for (int i = 0; i < 12; i++) {
        const double whole = floor(rest + 1e-12), p_next = whole * p + p_before,
                     q_next = whole * q + q_before;
        p_before = p;
        q_before = q;
        p = p_next;
        q = q_next;
        if (q > DENOMINATOR_MAX || p > DENOMINATOR_MAX)
            return;
        if (fabs(fabs(x) - p / q) <= tolerance) {
            if (p < 1 || !is_smooth((int)q) || 20 * q * q * tolerance > 1)
                return;
            *numerator = (int)copysign(p, x);
            *denominator = (int)q;
            return;
        }
        rest = 1 / (rest - whole);
    }
}

/* Returns the state of the solution at t [s], from the scene's start. */
static bool state_at(const struct local_search *search, double t, double *y)
{
    const struct system *system = search->system;
    const double span = t - system->t0;
    for (int i = 0; i < system->n; i++)
        y[i] = system->start[i];
    if (span == 0)
        return true;
    if (system_has_exact(system))
        return follow_solution(search, system->t0, span, y);
    const double steps = ceil(fabs(span) * search->rate * REFERENCE_STEPS);
    return steps < STEPS_MAX &&
           take_steps(search, search->reference, system->t0, span, (int)fmax(steps, 1), y);
}

/* Returns the fastest rate [1/s] of the scene near its start, by which the local search chooses its
 * steps. The Jacobian at the start alone may hide it, as it is 0 for a pendulum that starts
 * horizontally, and a fast reaction may begin slowly. So the rate given by the natural sizes of
 * velocity and position counts, too, and those after a few steps by backward Euler, which is
 * A-stable. Returns at least the rate at the start, and 1 if none is known. */
static double scene_rate(const struct local_search *search)
{
    enum { LOOKS = 4 };
    const struct system *system = search->system;
    const struct method *method = method_find("backward-euler");
    const int half = system->n / 2;
    struct error ignored;
    enum drag drag = DRAG_DEFAULT;
    double rate = system_fastest_rate(system, system->t0, system->start);
    if (system->order == 2)
        rate = fmax(rate, system->scale[half] / system->scale[0]);
    if (!(rate > 0) || !isfinite(rate))
        rate = 1;
    double *work = malloc((method_work_size(method, system->n) + 1) * sizeof *work);
    for (int i = 0; i < LOOKS && work && method_applies(method, system, &drag, &ignored); i++) {
        double y[LIMIT_VARIABLES];
        struct step step = {
            .system = system, .drag = drag, .t = system->t0, .h = 0.1 / rate, .y = y, .work = work};
        for (int k = 0; k < system->n; k++)
            y[k] = system->start[k];
        if (method_step(method, &step) != STEP_OK)
            break;
        rate = fmax(rate, system_fastest_rate(system, step.t, y));
    }
    free(work);
    return rate;
}

/* Measures at one state: exponents, coefficients, and in multiple [n] the ratios to the derivatives
 * with their relative errors in accuracy [n]. */
static bool measure_state(const struct local_search *search, double t, struct local_error *result,
                          double *multiple, double *accuracy)
{
    const int n = search->system->n;
    int exponent[LIMIT_VARIABLES];
    double derivative[LIMIT_VARIABLES];
    struct samples samples;
    result->t = t;
    if (!state_at(search, t, result->state))
        return false;
    measure_steps(search, t, result->state, result->dt, result->points, result->error);
    for (int k = 0; k < SAMPLES; k++)
        samples.dt[k] = longest_step / search->rate * pow(2, -0.5 * k);
    measure_steps(search, t, result->state, samples.dt, SAMPLES, samples.error);
    for (int i = 0; i < n; i++) {
        const double rounding = rounding_of(search, t, result->state, i);
        accuracy[i] = find_leading(&samples, i, rounding, &result->leading[i]);
        exponent[i] = result->leading[i].exponent;
    }
    solution_derivatives(search, t, result->state, exponent, derivative);
    for (int i = 0; i < n; i++) {
        result->leading[i].derivative = derivative[i];
        multiple[i] = result->leading[i].coefficient / derivative[i];
    }
    return true;
}

/* Names the fraction of each variable that is the same at the state of `result` and at later
 * ones. */
static void name_fractions(const struct local_search *search, struct local_error *result,
                           const double *multiple, const double *accuracy)
{
    const int n = search->system->n;
    double spread[LIMIT_VARIABLES], other[LIMIT_VARIABLES], other_accuracy[LIMIT_VARIABLES];
    int confirmed[LIMIT_VARIABLES] = {0}; /* number of later states with the same exponent */
    struct local_error *later = malloc(sizeof *later);
    for (int i = 0; i < n; i++)
        spread[i] = accuracy[i];
    for (int s = 1; s < STATES && later; s++) {
        *later = *result;
        if (!measure_state(search, result->t + 0.37 * s / search->rate, later, other,
                           other_accuracy))
            continue;
        for (int i = 0; i < n; i++) {
            /* The exponent cannot be found where the derivative vanishes nearby. */
            if (later->leading[i].exponent != result->leading[i].exponent)
                continue;
            spread[i] = fmax(spread[i], fabs(other[i] / multiple[i] - 1));
            confirmed[i]++;
        }
    }
    for (int i = 0; i < n; i++)
        if (confirmed[i] > 0 && spread[i] < multiple_accuracy)
            find_fraction(multiple[i], 3 * fmax(spread[i], multiple_rounding) * fabs(multiple[i]),
                          &result->leading[i].numerator, &result->leading[i].denominator);
    free(later);
}

/* Chooses steps of 5, 2 and 1 times powers of ten [s], from the longest that is short beside the
 * scene's time constants. */
static void choose_steps(double rate, struct local_error *result)
{
    static const double digits[] = {5, 2, 1};
    const double longest = longest_step / rate;
    double decade = pow(10, floor(log10(longest)));
    for (; result->points < LOCAL_ERROR_POINTS; decade /= 10)
        for (int i = 0; i < 3 && result->points < LOCAL_ERROR_POINTS; i++)
            if (digits[i] * decade <= longest)
                result->dt[result->points++] = digits[i] * decade;
}

/* Measures the local error of a method at a state of the solution, in steps of several sizes. */
bool study_local_error(const struct local_error_request *request, struct local_error *result,
                       struct error *error)
{
    const struct method *method = request->choice.method;
    struct system system;
    struct error ignored;
    double multiple[LIMIT_VARIABLES], accuracy[LIMIT_VARIABLES];
    *result = (struct local_error){.choice = request->choice};
    if (method->flags & (METHOD_EXTERNAL | METHOD_MULTISTEP))
        return error_set(error, ERROR_COMMAND,
                         "%s has no local error of a single step, since it uses earlier steps or "
                         "chooses its own",
                         method->row.name);
    if (!scene_bind(request->scene, &system, error) ||
        !method_applies(method, &system, &result->choice.drag, error))
        return false;
    struct local_search search = {.system = &system,
                                  .method = method,
                                  .reference = method_find("dop853"),
                                  .drag = result->choice.drag,
                                  .cancel = request->cancel};
    method_applies(search.reference, &system, &search.reference_drag, &ignored);
    result->n = system.n;
    for (int i = 0; i < system.n; i++)
        result->variable[i] = system_variable(&system, i);
    const size_t work = method_work_size(method, system.n),
                 reference_work = method_work_size(search.reference, system.n);
    search.work = malloc(((work > reference_work ? work : reference_work) + 1) * sizeof(double));
    if (!search.work)
        return error_memory(error);
    search.rate = scene_rate(&search);
    choose_steps(search.rate, result);
    const double t = isnan(request->t) ? system.t0 + 0.25 * PI / search.rate : request->t;
    const bool ok = measure_state(&search, t, result, multiple, accuracy);
    if (ok)
        name_fractions(&search, result, multiple, accuracy);
    free(search.work);
    if (cancelled(request->cancel))
        return error_set(error, ERROR_CANCELLED, "stopped");
    return ok ||
           error_set(error, ERROR_NUMERICAL, "the solution cannot be followed to t = %.6g s", t);
}

/* ---- rows ---- */

/* Fills in a row for each variable and step, variable by variable. Returns how many. */
size_t local_error_rows(const struct local_error *result, struct local_error_row *rows)
{
    size_t count = 0;
    for (int i = 0; i < result->n; i++)
        for (int k = 0; k < result->points; k++) {
            struct local_error_row *row = &rows[count++];
            *row = (struct local_error_row){.method = result->choice.method,
                                            .variable = result->variable[i],
                                            .leading = result->leading[i],
                                            .dt = result->dt[k],
                                            .error = result->error[k][i],
                                            .slope = NAN};
            if (k > 0)
                row->slope = log(fabs(row->error / result->error[k - 1][i])) /
                             log(row->dt / result->dt[k - 1]);
        }
    return count;
}

/* Returns the unit's quantity of the errors, which is that of the row's variable. */
static enum quantity error_quantity(const void *row)
{
    return ((const struct local_error_row *)row)->variable.quantity;
}

#define AT(member) .offset = offsetof(struct local_error_row, member)

static const struct result_column of_local_error[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(method)},
    {.name = "variable", .kind = COLUMN_CHARS, AT(variable.name)},
    {.name = "dt", AT(dt), .quantity = QUANTITY_TIME},
    {.name = "error", AT(error), .quantity_of = error_quantity},
    {.name = "slope", AT(slope)},
    {.name = "exponent", .kind = COLUMN_INT, AT(leading.exponent)},
    {.name = "coefficient", AT(leading.coefficient)},
    {.name = "numerator", .kind = COLUMN_INT, AT(leading.numerator)},
    {.name = "denominator", .kind = COLUMN_INT, AT(leading.denominator)},
    {.name = "derivative", AT(leading.derivative)},
};

const struct result_columns local_error_columns =
    RESULT_COLUMNS(of_local_error, struct local_error_row);
