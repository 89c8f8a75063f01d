/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `stability`: growth per step and the longest stable step, from the method's
 * formulas, then verified by running. */
#include "modules/comparison/compute/verify.h"

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/run/step_limit.h>

#include <stdlib.h>

#define GROWTH_ROUNDING 1e-12 /* growth above 1 by less is rounding */
#define ON_AXIS 1e-7          /* the same at a double eigenvalue, known to the root of rounding */
#define RATE_TOLERANCE 1e-2   /* accepted relative error of the rate of growing modes */
#define GROWTH_WEAK 1e-3      /* growth - 1 below which it takes 700 steps to double */
#define STEPS_MOST 16384      /* largest number in a check */
#define HISTORY_STEPS 8       /* more than any method remembers */
#define RATE_EXTREME 1e20     /* [1/s] modes beyond this or its inverse run in units of omega */
#define HUGE_STEP 100         /* omega dt above which NAN means unbounded growth */
#define LOG_ROOM 600.0        /* a check grows or decays by at most exp(this) */
#define LIMIT_OFFSET 1e-2     /* relative distance of the checks on both sides from the limit */
#define ASIDE_NARROW 1e-4     /* the same at the start of a narrow resonance */
#define STATES_CHECKED 16     /* number of states along the run whose modes are examined */
#define WINDOW_MAX 0.02       /* relative width of a resonance that is called narrow */

static const struct row verdicts[] = {
    [STABILITY_STABLE] = {"stable", "", "no growth beyond that of the scene itself", "", NULL},
    [STABILITY_MARGINAL] = {"marginal", "",
                            "growth so slow that it is visible only after hundreds of steps", "",
                            NULL},
    [STABILITY_UNSTABLE] = {"unstable", "", "every step multiplies the amplitude", "", NULL},
};

const struct catalog stability_verdict_catalog = CATALOG("verdict", verdicts);

/* ---- growth of one mode ---- */

double mode_growth(const struct method_choice *choice, const struct mode *mode, double dt)
{
    const double x = mode->omega * dt, growth = method_growth_signed(choice->method, choice->drag,
                                                                     x, mode->zeta, mode->sign);
    return isnan(growth) && x > HUGE_STEP ? HUGE_VAL : growth;
}

double mode_limit(const struct method_choice *choice, const struct mode *mode)
{
    return method_stable_limit_signed(choice->method, choice->drag, mode->zeta, mode->sign) /
           mode->omega;
}

double stability_growth(const struct method_choice *choice, double re, double im)
{
    const double size = hypot(re, im);
    return size > 0
               ? method_growth(choice->method, choice->drag, size, fmax(-1, fmin(1, -re / size)))
               : 1;
}

/* Computes the two eigenvalues [1/s]: real parts, and the imaginary part of the first. */
void mode_eigenvalues(const struct mode *mode, double re[2], double *im)
{
    const double zeta = mode->zeta, product = stiffness_sign_value(mode->sign),
                 split = product > 0 ? (zeta - 1) * (zeta + 1) : zeta * zeta - product;
    *im = mode->omega * sqrt(fmax(0, -split));
    re[0] = re[1] = -zeta * mode->omega;
    if (split <= 0)
        return;
    /* The larger one first; their product gives the other without cancellation. Adding 0 makes +0
     * of -0. */
    const double fast = -copysign(fabs(zeta) + sqrt(split), zeta), slow = product / fast + 0.0;
    re[0] = mode->omega * fmax(fast, slow);
    re[1] = mode->omega * fmin(fast, slow);
}

/* Returns the rate [1/s] at which the exact solution of the mode grows. */
static double growth_rate(const struct mode *mode)
{
    double re[2], im;
    mode_eigenvalues(mode, re, &im);
    return re[0];
}

/* Returns true if the exact solution of the mode grows. */
static bool mode_grows(const struct mode *mode)
{
    return growth_rate(mode) > 0;
}

/* Binds the oscillator of a mode with frequency `omega`. Returns false if it cannot be bound. */
static bool mode_system(const struct mode *mode, double omega, struct system *system)
{
    const struct {
        const char *name;
        double value;
    } set[] = {{"m", 1},
               {"k", stiffness_sign_value(mode->sign) * omega * omega},
               {"gamma", 2 * mode->zeta * omega},
               {"y0", 1}};
    struct scene scene;
    struct error ignored;
    scene_init(&scene, NULL);
    for (size_t i = 0; i < COUNT_OF(set); i++)
        if (!scene_set(&scene, param_index(set[i].name), (struct measured){set[i].value, 0},
                       &ignored))
            return false;
    return scene_bind(&scene, system, &ignored);
}

/* Growth is measured as the largest amplitude in the last quarter of the steps over that in the
 * second, which eliminates the turning of the phase, the norm's change by skew eigenvectors, and
 * decaying parts. As many steps are made as the range of numbers allows. */
void mode_check(const struct method_choice *choice, const struct mode *mode, double dt,
                struct stability_check *check)
{
    struct system system;
    /* Extremes of scale leave no room for growth: then in units of the frequency. */
    const double unit =
                     mode->omega > RATE_EXTREME || mode->omega < 1 / RATE_EXTREME ? mode->omega : 1,
                 omega = mode->omega / unit;
    const double expected = log(mode_growth(choice, mode, dt));
    const double possible = expected == 0 ? STEPS_MOST : LOG_ROOM / fabs(expected);
    const int64_t quarter = (int64_t)fmax(4, fmin(STEPS_MOST, possible) / 4);
    *check = (struct stability_check){
        .dt = dt, .predicted = exp(expected), .measured = NAN, .steps = 4 * quarter};
    if (isnan(expected) || !mode_system(mode, omega, &system))
        return;
    double *work = malloc((method_work_size(choice->method, system.n) + 1) * sizeof *work);
    if (!work)
        return;
    /* Both eigenvectors take part; what grows starts small, what decays starts large. */
    const double start = expected > 0 ? exp(-LOG_ROOM / 2) : exp(LOG_ROOM / 2);
    double y[2] = {start, 0.5 * omega * start}, max[4] = {0};
    struct step step = {
        .system = &system, .drag = choice->drag, .h = dt * unit, .y = y, .work = work};
    enum step_status status = STEP_OK;
    for (int64_t i = 0; i < 4 * quarter && status == STEP_OK; i++) {
        /* A method that remembers must not only see its own start: a jump that the past knows
         * nothing of sets off the parasitic solutions too. */
        if (i == HISTORY_STEPS && choice->method->flags & METHOD_MULTISTEP)
            y[0] += 0.5 * start;
        status = method_step(choice->method, &step);
        if (isnan(y[0]) || isnan(y[1]))
            status = STEP_NONFINITE;
        max[i / quarter] = fmax(max[i / quarter], hypot(y[0], y[1] / omega));
    }
    free(work);
    check->measured = status != STEP_OK ? HUGE_VAL
                      : max[3] > 0      ? exp(log(max[3] / max[1]) / (double)(2 * quarter))
                                        : 0;
    if (isinf(check->measured) ||
        check->measured == 0) { /* so few steps that the numbers do not hold them */
        check->agrees = fabs(expected) * (double)(4 * quarter) >= LOG_ROOM &&
                        (expected > 0) == (check->measured > 0);
        return;
    }
    /* Envelopes are sampled to a few per cent; a double root grows like n mu^n, which shows as log
     * 2 / (2 quarter). */
    const double root = fabs(fabs(mode->zeta) - 1) < 1e-3 ? 1 : 0.1;
    check->agrees = fabs(log(check->measured) - expected) <=
                    0.1 * fabs(expected) + root / (double)(2 * quarter);
}

double mode_aside(const struct method_choice *choice, const struct mode *mode, double limit)
{
    return mode_growth(choice, mode, limit * (1 + LIMIT_OFFSET)) > 1 + GROWTH_ROUNDING
               ? LIMIT_OFFSET
               : ASIDE_NARROW;
}

/* ---- the scene's modes ---- */

/* Appends a mode with positive omega, if there is room. */
static void add_mode(struct mode *mode, int *count, int max, double omega, double zeta, double t,
                     enum stiffness_sign sign)
{
    if (*count < max && omega > 0 && isfinite(omega) && isfinite(zeta))
        mode[(*count)++] = (struct mode){omega, zeta, t, sign};
}

/* Returns the damping ratio of an eigenvalue, without rounding around 0. */
static double damping_ratio(double zeta)
{
    return zeta < 1e-12 ? 0 : fmin(1, zeta);
}

/* Appends the modes of the Jacobian jac [n x n] at time t to mode [*count of max], except those
 * near 0, which rounding leaves, and growing ones of a nonlinear system. Returns how many
 * eigenvalues grow. */
static int modes_of_matrix(const struct system *system, double t, const double *jac,
                           struct mode *mode, int *count, int max)
{
    const int n = system->n;
    struct eigenvalue value[LIMIT_VARIABLES];
    double largest = 0;
    int grows = 0;
    if (!matrix_eigenvalues(n, jac, value))
        return 0;
    for (int i = 0; i < n; i++)
        largest = fmax(largest, hypot(value[i].re, value[i].im));
    for (int i = 0; i < n; i++) {
        const double size = hypot(value[i].re, value[i].im), rounding = 1e-9 * largest;
        if (value[i].im < 0 || size <= rounding)
            continue;
        if (value[i].re > rounding) {
            grows++;
            if (system->linear)
                add_mode(mode, count, max, size, fmax(-1, -value[i].re / size), t,
                         STIFFNESS_POSITIVE);
        } else
            add_mode(mode, count, max, size, damping_ratio(-value[i].re / size), t,
                     STIFFNESS_POSITIVE);
    }
    return grows;
}

/* Appends modes of the linearised scene to mode [*count], up to `max`. Returns how many grow. */
int modes_at(const struct system *system, double t, const double *y, struct mode *mode, int *count,
             int max)
{
    double jac[LIMIT_VARIABLES * LIMIT_VARIABLES];
    system_jacobian(system, t, y, jac);
    if (system->order != 2 || system->n != 2)
        return modes_of_matrix(system, t, jac, mode, count, max);
    const double stiffness = 0 - jac[2], damping = 0 - jac[3], omega = sqrt(fabs(stiffness));
    if (stiffness > 0 && (damping >= 0 || system->linear)) {
        add_mode(mode, count, max, omega, damping / (2 * omega), t, STIFFNESS_POSITIVE);
        return damping < 0;
    }
    if (system->linear) {
        if (stiffness < 0)
            add_mode(mode, count, max, omega, damping / (2 * omega), t, STIFFNESS_NEGATIVE);
        else
            add_mode(mode, count, max, fabs(damping), copysign(0.5, damping), t, STIFFNESS_ZERO);
        return stiffness < 0 || damping < 0;
    }
    /* y'' = - damping y' + |stiffness| y has one growing and one decaying part; only the latter
     * counts */
    const double s = damping / 2, root = hypot(s, omega), fast = s + root;
    if (stiffness <= 0 && fast > 0)
        add_mode(mode, count, max, fast, 1, t, STIFFNESS_POSITIVE);
    return stiffness < 0 || damping < 0;
}

/* ---- along the run ---- */

/* If no method reaches the end, states beyond this many natural sizes are not used. */
#define RELIABLE_SIZES 10

/* Returns true if each |y_i| is within RELIABLE_SIZES times its natural or initial size. */
static bool is_sound(const struct system *system, const double *y)
{
    for (int i = 0; i < system->n; i++)
        if (!(fabs(y[i]) <= RELIABLE_SIZES * fmax(system->scale[i], fabs(system->start[i]))))
            return false;
    return true;
}

/* Adds the modes at STATES_CHECKED times along a run by the first method that reaches its end. */
static void modes_along(const struct system *system, const struct stability_request *request,
                        struct stability *stability)
{
    static const char *const able[] = {"rodas5p", "radau5", "dop853", "dopri5"};
    const int n = system->n, stride = (STUDY_TIMES - 1) / STATES_CHECKED;
    const struct run_settings settings = {.tol = 1e-6}; /* chooses its first step */
    double *grid = malloc((size_t)STUDY_TIMES * (size_t)n * sizeof *grid);
    for (size_t i = 0; grid && i < COUNT_OF(able); i++) {
        const struct method *method = method_find(able[i]);
        struct solver solver;
        if (!method || !solver_init(&solver, system, method, &settings, request->duration))
            continue;
        solver.max = 300000;
        const enum stop stop = solver_run(&solver, grid, request->cancel);
        solver_free(&solver);
        if (stop == STOP_CANCELLED)
            break;
        for (int k = stride; k < STUDY_TIMES && (stop == STOP_END || i + 1 == COUNT_OF(able));
             k += stride) {
            struct mode here[LIMIT_VARIABLES];
            int count = 0;
            if (isnan(grid[k * n]) || (stop != STOP_END && !is_sound(system, grid + k * n)))
                break;
            const double t = system->t0 + request->duration * k / (STUDY_TIMES - 1);
            stability->grows |=
                modes_at(system, t, grid + k * n, here, &count, LIMIT_VARIABLES) > 0;
            for (int m = 0; m < count && stability->modes < STABILITY_MODES; m++)
                stability->mode[stability->modes++] = here[m];
        }
        if (stop == STOP_END)
            break;
    }
    free(grid);
}

/* ---- the limit ---- */

/* Returns true if a step up to dt may be unstable for this mode: a cheap test of a few sizes. */
static bool may_limit(const struct method_choice *choice, const struct mode *mode, double dt)
{
    static const double part[] = {1. / 64, 0.125, 0.25, 0.5, 0.75, 0.9, 0.99, 0.9999};
    for (size_t i = 0; i < COUNT_OF(part); i++)
        if (!(mode_growth(choice, mode, part[i] * dt) <= 1 + ON_AXIS))
            return true;
    return false;
}

/* Sets dt_max, the smallest limit of all modes that do not grow by themselves, and its mode. */
static void find_limit(struct stability *s)
{
    s->dt_max = NAN;
    for (int i = 0; i < s->modes; i++) {
        if (mode_grows(&s->mode[i]))
            continue;
        if (!isnan(s->dt_max) &&
            (s->dt_max == 0 ||
             !may_limit(&s->choice, &s->mode[i], fmin(s->dt_max, 1e4 / s->mode[i].omega))))
            continue;
        const double limit = mode_limit(&s->choice, &s->mode[i]);
        if (isnan(s->dt_max) || limit < s->dt_max) {
            s->dt_max = limit;
            s->tightest = s->mode[i];
        }
    }
}

/* Lowers dt_max to the longest step that the method accepts; longer ones are refused. */
static void bound_limit(const struct system *system, struct stability *s)
{
    const double longest = plan_step_limit(system, s->choice.method, s->choice.drag);
    if (!(longest < s->dt_max))
        return;
    s->dt_max = longest;
    s->refused = true;
}

/* Sets the largest growth per step at dt, the mode it belongs to, and its exact growth. */
static void find_growth(struct stability *s)
{
    s->growth_predicted = s->modes ? 0 : NAN;
    for (int i = 0; i < s->modes; i++) {
        const double growth = mode_growth(&s->choice, &s->mode[i], s->dt);
        if (growth > s->growth_predicted) {
            s->growth_predicted = growth;
            s->worst = s->mode[i];
        }
    }
    s->growth_exact = s->modes ? exp(growth_rate(&s->worst) * s->dt) : NAN;
    s->energy_factor = s->growth_predicted * s->growth_predicted;
}

/* Sets the doubling time, the law growth - 1 = c x^p of weak instability, and the window of a
 * narrow resonance beyond dt_max, after which steps are stable again. */
static void find_weakness(struct stability *s)
{
    s->weak[0] = s->weak[1] = s->window[0] = s->window[1] = s->window[2] = NAN;
    if (mode_grows(&s->worst)) {
        s->doubling = log(2) / log(s->growth_predicted);
        return;
    }
    s->doubling =
        s->growth_predicted > 1 + GROWTH_ROUNDING ? log(2) / log(s->growth_predicted) : HUGE_VAL;
    const double x = s->worst.omega * s->dt, g = s->growth_predicted - 1;
    if (g > GROWTH_ROUNDING && g < GROWTH_WEAK && s->dt_max == 0) {
        const double less = mode_growth(&s->choice, &s->worst, s->dt / 2) - 1;
        s->weak[1] = less > GROWTH_ROUNDING / 10 ? log2(g / less) : NAN;
        s->weak[0] = g / pow(x, s->weak[1]);
    }
    if (!(s->dt_max > 0) || isinf(s->dt_max) || s->refused)
        return;
    double max = 0, part = 0;
    while (part < WINDOW_MAX) {
        const double growth = mode_growth(&s->choice, &s->tightest, s->dt_max * (1 + part));
        if (max > 0 && growth <= 1 + GROWTH_ROUNDING) {
            s->window[0] = s->dt_max;
            s->window[1] = s->dt_max * (1 + part);
            s->window[2] = max;
            return;
        }
        max = growth > 1 + GROWTH_ROUNDING ? fmax(max, growth) : max;
        part += WINDOW_MAX / 2000;
    }
}

/* Runs the worst mode at dt, and the tightest one on both sides of dt_max. */
static void verify_limits(struct stability *s)
{
    mode_check(&s->choice, &s->worst, s->dt, &s->check[s->checks++]);
    s->growth_measured = s->check[0].measured;
    const double aside = mode_aside(&s->choice, &s->tightest, s->dt_max);
    for (int side = -1; side <= (s->refused ? -1 : 1) && s->dt_max > 0 && isfinite(s->dt_max);
         side += 2)
        mode_check(&s->choice, &s->tightest, s->dt_max * (1 + side * aside),
                   &s->check[s->checks++]);
    for (int i = 0; i < s->checks; i++)
        s->agrees &= s->check[i].agrees;
}

/* Runs the scene with dt, as modes are only estimates if it is not linear; false if out of
 * memory. */
static bool run_scene(const struct system *system, const struct stability_request *request,
                      struct stability *s)
{
    const struct run_settings settings = {.dt = request->dt, .drag = s->choice.drag};
    const int n = system->n;
    struct solver solver;
    double *grid = malloc((size_t)STUDY_TIMES * (size_t)n * sizeof *grid);
    if (!grid || !solver_init(&solver, system, s->choice.method, &settings, request->duration)) {
        free(grid);
        return false;
    }
    solver.max = 3000000;
    s->stop = solver_run(&solver, grid, request->cancel);
    s->reached = solver.step.t;
    struct singularity singular = {.t = NAN};
    if (stop_is_failure(s->stop))
        singular = system_singularity(system, system->t0, system->start,
                                      s->reached + 16 * request->dt, request->cancel);
    if (!isnan(singular.t)) {
        s->stop = STOP_SINGULAR;
        s->reached = singular.t;
    }
    s->largest = 0;
    for (int i = 0; i < STUDY_TIMES * n; i++)
        if (!isnan(grid[i]))
            s->largest = fmax(s->largest, fabs(grid[i]) / system->scale[i % n]);
    solver_free(&solver);
    free(grid);
    return true;
}

/* Returns the verdict on one mode. Growth of the scene itself is not the method's fault, nor is a
 * rate that is correct to RATE_TOLERANCE. */
static enum stability_verdict stability_judge(const struct stability *s, const struct mode *mode)
{
    const double growth = mode_growth(&s->choice, mode, s->dt), rate = growth_rate(mode) * s->dt,
                 margin = rate > 0                      ? exp((1 + RATE_TOLERANCE) * rate)
                          : fabs(mode->zeta - 1) < 1e-3 ? 1 + ON_AXIS
                                                        : 1 + GROWTH_ROUNDING;
    const double exact = rate > 0 ? exp(rate) : 1;
    if (growth <= margin)
        return STABILITY_STABLE;
    return growth < exact + GROWTH_WEAK ? STABILITY_MARGINAL : STABILITY_UNSTABLE;
}

/* Returns the worst verdict on all modes. */
static enum stability_verdict judge_all(const struct stability *s)
{
    enum stability_verdict worst = STABILITY_STABLE;
    for (int i = 0; i < s->modes; i++) {
        const enum stability_verdict verdict = stability_judge(s, &s->mode[i]);
        worst = verdict > worst ? verdict : worst;
    }
    return s->modes || !s->grows ? worst : STABILITY_UNSTABLE;
}

/* Predicts growth and limit from the method's formulas and verifies them by running. */
bool study_stability(const struct stability_request *request, struct stability *s,
                     struct error *error)
{
    struct system system;
    *s = (struct stability){.choice = request->choice,
                            .dt = request->dt,
                            .dt_max = NAN,
                            .growth_predicted = NAN,
                            .growth_measured = NAN,
                            .growth_exact = NAN,
                            .energy_factor = NAN,
                            .doubling = NAN,
                            .weak = {NAN, NAN},
                            .window = {NAN, NAN, NAN},
                            .reached = NAN,
                            .largest = NAN};
    if (!(request->dt > 0) || !isfinite(request->dt))
        return error_set(error, ERROR_COMMAND, "dt must be > 0 (got %.6g s)", request->dt);
    if (!scene_bind(request->scene, &system, error) ||
        !method_applies(request->choice.method, &system, &s->choice.drag, error) ||
        !method_fits(request->choice.method, &system, s->choice.drag, request->dt, error))
        return false;
    s->linear = system.linear;
    s->scalar = system.n == 1;
    s->grows = modes_at(&system, system.t0, system.start, s->mode, &s->modes, STABILITY_MODES) > 0;
    s->at_start = s->modes;
    if (!s->linear)
        modes_along(&system, request, s);
    find_limit(s);
    bound_limit(&system, s);
    find_growth(s);
    s->verdict = judge_all(s);
    s->agrees = true;
    if (s->modes) {
        find_weakness(s);
        verify_limits(s);
    }
    if (!s->linear && !cancelled(request->cancel)) {
        if (!run_scene(&system, request, s))
            return error_memory(error);
        s->agrees &= s->verdict == STABILITY_UNSTABLE || s->stop == STOP_END ||
                     s->stop == STOP_FULL || s->stop == STOP_SINGULAR;
    }
    return !cancelled(request->cancel) || error_set(error, ERROR_CANCELLED, "stopped");
}
