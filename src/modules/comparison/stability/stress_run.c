/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `stress`: every method in every stiff and extreme case, each with a verdict. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include "modules/comparison/stability/stress.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COST_MAX 1000000       /* evaluations, Jacobians and solves of one case */
#define STEPS_MOST 100000      /* largest number of fixed steps of one case */
#define REFERENCE_MAX 4000000  /* largest cost of a reference */
#define SCENE_MAX 400000       /* the same for the many cases of the caller's scene */
#define REFERENCE_TOL 1e-10    /* tolerance of a reference */
#define CASE_TOLERANCE 1e-6    /* tolerance where the case has none */
#define CASE_SPAN 10.0         /* [s] duration where the case has none */
#define CASE_STEPS 1024        /* number of fixed steps where the case has no dt */
#define ERROR_EXACT 1e-10      /* smaller errors are accumulated rounding */
#define ERROR_ACCURATE 1e-2    /* largest error that is called accurate */
#define AMPLITUDE_BOUNDED 10.0 /* largest size of a wrong motion that is called bounded */
/* fraction of the expected oscillation in the last quarter below which it is damped away */
#define DAMPED_FRACTION 0.1

static const struct row verdicts[] = {
    [STRESS_EXACT] = {"exact", "", "the error is rounding, or too small to be known", "", NULL},
    [STRESS_ACCURATE] = {"accurate", "", "error below 1 % of the amplitude throughout", "", NULL},
    [STRESS_BOUNDED] = {"bounded", "", "wrong in phase or shape, but not larger than the motion",
                        "", NULL},
    [STRESS_DAMPED] = {"damped away", "", "the oscillation has been damped away", "", NULL},
    [STRESS_SINGULAR] = {"singular", "",
                         "the solution itself ends before the end, or goes to infinity", "", NULL},
    [STRESS_REFUSED] = {"refused", "", "not computed, with a reason", "", NULL},
    [STRESS_DIVERGED] = {"diverged", "", "grew beyond the motion, or out of the range of numbers",
                         "", NULL},
    [STRESS_UNKNOWN] = {"unknown", "",
                        "reached the end, but no two references agree, so its error is unknown", "",
                        NULL},
    [STRESS_UNEXPLAINED] = {"unexplained", "", "none of these, which is a fault of the program", "",
                            NULL},
};

const struct catalog stress_verdict_catalog = CATALOG("verdict", verdicts);

/* ---- the cases ---- */

/* clang-format off */
#define UNIT_SCENE {"m", 1}, {"k", 1}, {"y0", 1}

static const struct stress_case cases[] = {
    {"stiff-spring", "k/m = 1e12, 1 ms: 159 swings", "stiff-spring", .span = 1e-3},
    {"stiff-spring coarse", "k/m = 1e12, steps of 10 ms: 1600 swings each", "stiff-spring",
     .fixed = true, .dt = 0.01},
    {"stiff-vanderpol", "mu = 1000 to t = 2000", "stiff-vanderpol", .span = 2000},
    {"stiff-vanderpol-1e6", "mu = 1e6 to t = 2e6", "stiff-vanderpol-1e6",
     .span = 2e6},
    {"robertson", "to t = 1e11", "robertson", .span = 1e11},
    {"robertson short", "to t = 40", "robertson", .span = 40},
    {"orego", "to t = 360, across a spike", "orego", .span = 360},
    {"prothero-robinson", "lambda = -1e6", "prothero-robinson", .span = CASE_SPAN},
    {"kepler e=0.9", "three orbits", "kepler-eccentric", .span = 18.849555921538759},
    {"extreme-comet", "e = 0.9999, one orbit", "extreme-comet", .span = 6.2831853071795862},
    {"drag huge", "c |v| h = 1e6 at the start", "spring",
     .set = {UNIT_SCENE, {"v0", 1e3}, {"C", 1e5}, {"rho", 1}, {"area", 1}}},
    {"damping huge", "gamma = 1e9 in steps of 0.1 s", "stiff-damped", .fixed = true, .dt = 0.1},
    {"critical below", "zeta = 1 - 1e-12", "spring", .set = {UNIT_SCENE, {"gamma", 2 - 2e-12}}},
    {"critical", "zeta = 1", "spring", .set = {UNIT_SCENE, {"gamma", 2}}},
    {"critical above", "zeta = 1 + 1e-12", "spring", .set = {UNIT_SCENE, {"gamma", 2 + 2e-12}}},
    {"k < 0", "an unstable equilibrium", "spring", .set = {{"m", 1}, {"k", -1}, {"y0", 1}}},
    {"gamma < 0", "a motion that grows", "spring", .set = {UNIT_SCENE, {"gamma", -0.5}}},
    {"k = 0", "a free mass with drag", "spring",
     .set = {{"m", 1}, {"k", 0}, {"gamma", 0.5}, {"v0", 1}}},
    {"free", "no force at all", "spring", .set = {{"m", 1}, {"k", 0}, {"v0", 1}}},
    {"at rest", "y0 = v0 = 0, with drag", "spring",
     .set = {{"m", 1}, {"k", 1}, {"y0", 0}, {"C", 1}, {"rho", 1}, {"area", 1}}},
    {"denormal", "amplitude 1e-310", "spring", .set = {{"m", 1}, {"k", 1}, {"y0", 1e-310}}},
    {"squares overflow", "amplitude 1e150", "spring", .set = {{"m", 1}, {"k", 1}, {"y0", 1e149}}},
    {"k = 1e300", "omega0 dt = 1e148", "spring", .set = {{"m", 1}, {"k", 1e300}, {"y0", 1}}},
    {"m = 1e-310", "k/m overflows", "spring", .set = {{"m", 1e-310}}},
    {"m = 0", "no mass", "spring", .set = {{"m", 0}}},
    {"k = nan", "not a number", "spring", .set = {{"k", __builtin_nan("")}}},
    {"y0 = inf", "not finite", "spring", .set = {{"y0", __builtin_inf()}}},
    {"phase lost", "k/m = 1e28: 1e14 swings", "spring", .set = {{"m", 1}, {"k", 1e28}, {"y0", 1}}},
    {"undamped long", "200 periods of 20 steps", "spring",
     .set = {UNIT_SCENE}, .span = 1256.6370614359173, .fixed = true, .dt = 0.31415926535897931},
    {"dt above limit", "omega0 dt = 3", "spring",
     .set = {UNIT_SCENE}, .span = 3000, .fixed = true, .dt = 3},
    {"dt far above", "omega0 dt = 100", "spring",
     .set = {UNIT_SCENE}, .span = 1e5, .fixed = true, .dt = 100},
    {"dt > T", "one step of exactly T", "spring",
     .set = {UNIT_SCENE}, .span = 0.125, .fixed = true, .dt = 1},
    {"dt = 0", "no step", "spring", .set = {UNIT_SCENE}, .fixed = true, .dt = 0},
    {"dt < 0", "dt is always positive", "spring", .set = {UNIT_SCENE}, .fixed = true, .dt = -0.01},
    {"dt = nan", "not a number", "spring", .set = {UNIT_SCENE}, .fixed = true, .dt = __builtin_nan("")},
    {"dt = inf", "not finite", "spring", .set = {UNIT_SCENE}, .fixed = true, .dt = __builtin_inf()},
    {"dt below rounding", "t0 = 1e15 s", "spring",
     .set = {UNIT_SCENE, {"t0", 1e15}}, .fixed = true, .dt = 0.01},
    {"T/dt = 1e12", "predicted only", "spring",
     .set = {UNIT_SCENE}, .span = 1e10, .fixed = true, .dt = 0.01},
    {"T/dt = 1e300", "more than can be counted", "spring",
     .set = {UNIT_SCENE}, .span = 1e298, .fixed = true, .dt = 0.01},
    {"tol = 1e-20", "below rounding", "spring", .set = {UNIT_SCENE}, .tol = 1e-20},
    {"duration = nan", "not a number", "spring", .set = {UNIT_SCENE}, .span = __builtin_nan("")},
};
/* clang-format on */

/* Returns true if the table has a case named after the preset. */
static bool is_listed(const char *preset)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        if (strcmp(cases[i].preset, preset) == 0 && strcmp(cases[i].name, preset) == 0)
            return true;
    return false;
}

/* Returns built-in case `index`: of the table, then a preset "stiff-..." or "extreme-...". */
bool stress_case_at(size_t index, struct stress_case *result)
{
    if (index < COUNT_OF(cases)) {
        *result = cases[index];
        return true;
    }
    index -= COUNT_OF(cases);
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct row *row = catalog_row(&preset_catalog, i);
        const bool named = text_starts(text_of(row->name), TEXT("stiff-")) ||
                           text_starts(text_of(row->name), TEXT("extreme-"));
        if (named && !is_listed(row->name) && index-- == 0) {
            *result =
                (struct stress_case){.name = row->name, .brief = row->brief, .preset = row->name};
            return true;
        }
    }
    return false;
}

/* Lists the built-in cases. */
static void list_built_in_cases(struct stress *stress)
{
    while (stress->count < STRESS_MAX &&
           stress_case_at((size_t)stress->count, &stress->cases[stress->count]))
        stress->count++;
}

/* ---- one case ---- */

/* One case while all methods run it. */
struct stress_state {
    const struct stress_case *what;
    double *limit; /* [methods] limits for STRESS_STEP, NAN until known */
    struct system system;
    double span, tol, dt;
    struct reference reference;  /* y is NULL if there is none */
    char refused[200];           /* reason if the scene itself is invalid, or empty */
    struct singularity singular; /* end of the solution, searched for when a method fails */
    bool looked;                 /* it was searched for */
    double *grid;                /* [STUDY_TIMES][n] */
    const struct cancel *cancel;
};

/* Binds the scene of a case. Returns false with an error if a parameter cannot have its value. */
static bool set_scene(const struct stress_case *what, struct system *system, struct error *error)
{
    const struct row *row =
        what->stress_scene ? NULL : catalog_find(&preset_catalog, text_of(what->preset));
    const struct preset *preset = preset_from(row);
    struct scene scene;
    if (what->stress_scene)
        return stress_scene_set(what, &scene, error) && scene_bind(&scene, system, error);
    if (!preset)
        return error_set(error, ERROR_COMMAND, "there is no scene '%s'", what->preset);
    scene_init(&scene, preset);
    for (size_t i = 0; i < COUNT_OF(what->set) && what->set[i].param; i++)
        if (!scene_set(&scene, scene_param(&scene, what->set[i].param),
                       (struct measured){what->set[i].value, 0}, error))
            return false;
    return scene_bind(&scene, system, error);
}

/* Sets bench->reference to the closed form or, without one, to the solution of the first method of
 * able[] that reaches the end; its accuracy is the distance to the solution of the next one. Leaves
 * reference->y NULL if fewer than two methods reach the end. */
static void find_reference(struct stress_state *bench)
{
    static const char *const able[] = {"rodas5p", "radau5", "dop853", "odex"};
    struct reference *reference = &bench->reference;
    const struct system *system = &bench->system;
    const size_t size = (size_t)STUDY_TIMES * (size_t)system->n;
    struct error ignored;
    assert(system->n > 0);
    if (!(bench->span > 0) || !isfinite(bench->span) || !bench->grid)
        return;
    if (system_has_exact(system)) {
        study_reference(system, bench->span, bench->cancel, reference, &ignored);
        return;
    }
    *reference = (struct reference){.n = system->n, .span = bench->span, .meaning = bench->span};
    reference->scored = system->order == 2 ? system->n / 2 : system->n;
    reference->y = calloc(size, sizeof *reference->y);
    for (size_t i = 0; reference->y && i < COUNT_OF(able) && !reference->method[1]; i++) {
        const struct run_settings settings = {.tol = REFERENCE_TOL};
        const struct method *method = method_find(able[i]);
        struct solver solver;
        if (!method || !solver_init(&solver, system, method, &settings, bench->span))
            continue;
        solver.max = bench->what->stress_scene ? SCENE_MAX : REFERENCE_MAX;
        const enum stop stop = solver_run(&solver, bench->grid, bench->cancel);
        solver_free(&solver);
        if (stop != STOP_END)
            continue;
        reference->method[reference->method[0] != NULL] = method;
        if (!reference->method[1])
            memcpy(reference->y, bench->grid, size * sizeof *reference->y);
    }
    for (int i = 0; reference->y && i < system->n; i++) {
        for (int k = 0; k < STUDY_TIMES; k++)
            reference->amplitude[i] =
                fmax(reference->amplitude[i], fabs(reference->y[k * system->n + i]));
        if (!(reference->amplitude[i] > 1e-18 * system->scale[i]))
            reference->amplitude[i] = system->scale[i];
    }
    for (int k = 0; reference->method[1] && k < STUDY_TIMES; k++)
        reference->accuracy =
            fmax(reference->accuracy, grid_distance(reference, bench->grid + k * system->n,
                                                    reference->y + k * system->n));
    if (!reference->method[1])
        reference_free(reference);
}

/* Prepares a case and its reference, or fills in `refused`. Returns false if out of memory. */
static bool bench_init(struct stress_state *bench, const struct stress_case *what,
                       const struct cancel *cancel)
{
    struct error error = {0};
    *bench = (struct stress_state){.what = what, .cancel = cancel};
    bench->span = what->span == 0 ? CASE_SPAN : what->span;
    bench->dt = what->fixed ? what->dt : bench->span / CASE_STEPS;
    bench->tol = what->tol == 0 ? CASE_TOLERANCE : what->tol;
    if (!set_scene(what, &bench->system, &error)) {
        snprintf(bench->refused, sizeof bench->refused, "%.150s", error.text);
        return true;
    }
    bench->grid = calloc((size_t)STUDY_TIMES * (size_t)bench->system.n + 1, sizeof *bench->grid);
    if (!bench->grid)
        return false;
    find_reference(bench);
    return true;
}

static void bench_free(struct stress_state *bench)
{
    free(bench->grid);
    if (bench->reference.y)
        reference_free(&bench->reference);
}

/* Returns the largest |variable i| from grid time `first` on, in amplitudes, without NAN states. */
static double grid_variable_max(const struct stress_state *bench, const double *grid, int first,
                                int i)
{
    double max = 0;
    for (int k = first; k < STUDY_TIMES; k++)
        if (!isnan(grid[k * bench->system.n + i]))
            max = fmax(max, fabs(grid[k * bench->system.n + i]) / bench->reference.amplitude[i]);
    return max;
}

/* Sets row->verdict, error and reason of a run that reached its end. */
static void judge_end(const struct stress_state *bench, struct stress_row *row)
{
    const struct reference *reference = &bench->reference;
    const int last_quarter = 3 * (STUDY_TIMES - 1) / 4;
    struct study_errors errors;
    double size = 0;
    bool gone = false;
    if (!reference->y) {
        row->verdict = STRESS_UNKNOWN;
        snprintf(row->reason, sizeof row->reason, "there is no reference to compare with");
        return;
    }
    grid_errors(&bench->system, reference, bench->grid, &errors);
    row->error = fmax(errors.max, errors.end);
    for (int i = 0; i < reference->scored; i++) {
        const double now = grid_variable_max(bench, bench->grid, last_quarter, i),
                     real = grid_variable_max(bench, reference->y, last_quarter, i);
        size = fmax(size, grid_variable_max(bench, bench->grid, 0, i));
        gone |= real > 0.05 && now < DAMPED_FRACTION * real;
    }
    const bool known = reference->accuracy < ERROR_ACCURATE;
    if (known && row->error <= fmax(ERROR_EXACT, reference->exact ? 10 * reference->accuracy : 0)) {
        row->verdict = STRESS_EXACT;
    } else if (known && row->error <= ERROR_ACCURATE) {
        row->verdict = STRESS_ACCURATE;
    } else if (!(size <= AMPLITUDE_BOUNDED)) {
        row->verdict = STRESS_DIVERGED;
        snprintf(row->reason, sizeof row->reason, "grew to %.2g times the motion", size);
    } else if (gone) {
        row->verdict = STRESS_DAMPED;
        snprintf(row->reason, sizeof row->reason,
                 "numerical damping removes the motion that these steps do not resolve");
    } else if (size <= AMPLITUDE_BOUNDED) {
        row->verdict = STRESS_BOUNDED;
        if (known)
            snprintf(row->reason, sizeof row->reason,
                     "these steps do not resolve the motion, so its phase or shape is wrong");
        else
            snprintf(row->reason, sizeof row->reason,
                     "no method can compute the phase: rounding the parameters changes it by %.2g "
                     "of the amplitude",
                     reference->accuracy);
    }
    if (isnan(row->error))
        row->verdict = STRESS_UNEXPLAINED;
}

/* Sets the verdict STRESS_SINGULAR and returns true if the solution itself ends before the span
 * does and the run failed, or passed that end without a reference to measure it. */
static bool judge_singular(struct stress_state *bench, enum stop stop, struct stress_row *row)
{
    const struct system *system = &bench->system;
    if (!stop_is_failure(stop) && !(stop == STOP_END && !bench->reference.y))
        return false;
    if (!bench->looked)
        bench->singular = system_singularity(system, system->t0, system->start,
                                             system->t0 + bench->span, bench->cancel);
    bench->looked = true;
    if (isnan(bench->singular.t))
        return false;
    row->verdict = STRESS_SINGULAR;
    snprintf(row->reason, sizeof row->reason, "the solution itself %s at t = %.6g s%s",
             singularity_text(&bench->singular), bench->singular.t,
             stop == STOP_END ? ", so later values are meaningless" : "");
    return true;
}

/* Sets the verdict on a run that did not reach its end, with the reason. */
static void judge_stop(const struct stress_state *bench, const struct solver *solver,
                       const struct run_settings *settings, const struct plan *plan, enum stop stop,
                       struct stress_row *row)
{
    if (stop == STOP_FULL) {
        const double part = (solver->step.t - bench->system.t0) / bench->span;
        row->verdict = STRESS_REFUSED;
        snprintf(row->reason, sizeof row->reason, "out of budget: about %.1e steps would be needed",
                 (double)solver->steps / part);
        return;
    }
    struct buffer why = {0};
    struct run run = {.system = bench->system,
                      .method = row->method,
                      .settings = *settings,
                      .plan = *plan,
                      .steps = solver->steps,
                      .t = solver->step.t,
                      .stop = stop};
    /* run_explain() is to use the rates at the start */
    memcpy(run.y, bench->system.start, sizeof run.y);
    run_explain(&run, &why);
    row->verdict = stop == STOP_DIVERGED ? STRESS_DIVERGED : STRESS_REFUSED;
    snprintf(row->reason, sizeof row->reason, "%s",
             why.data && !why.failed ? why.data : stop_name(stop));
    buffer_free(&why);
}

/* Sets the verdict STRESS_REFUSED with a reason. */
static void stress_row_refuse(struct stress_row *row, const char *why)
{
    row->verdict = STRESS_REFUSED;
    snprintf(row->reason, sizeof row->reason, "%.230s", why);
}

/* Runs one method in a case and sets its verdict. Returns false if out of memory. */
static bool run_case(struct stress_state *bench, int method, struct stress_row *row)
{
    const bool adaptive = row->method->flags & METHOD_ADAPTIVE && !bench->what->fixed;
    double *limit = &bench->limit[method];
    if (bench->what->change == STRESS_STEP && isnan(*limit) && !bench->refused[0])
        *limit = bench->reference.y
                     ? stress_limit(&bench->system, bench->reference.y, STUDY_TIMES,
                                    STUDY_TIMES / 32, row->method)
                     : stress_limit(&bench->system, bench->system.start, 1, 1, row->method);
    const double unit = isfinite(*limit) ? *limit : bench->span / CASE_STEPS;
    const double dt = bench->what->change == STRESS_STEP ? bench->what->value * unit : bench->dt;
    struct run_settings settings = {.dt = dt, .tol = adaptive ? bench->tol : 0};
    struct error error = {0};
    struct plan plan;
    struct solver solver;
    row->verdict = STRESS_UNEXPLAINED;
    row->error = NAN;
    if (bench->refused[0]) {
        stress_row_refuse(row, bench->refused);
        return true;
    }
    if (!method_applies(row->method, &bench->system, &settings.drag, &error) ||
        !plan_make(&bench->system, row->method, &settings, bench->span, &plan, &error)) {
        stress_row_refuse(row, error.text);
        return true;
    }
    if (!adaptive && plan.steps > STEPS_MOST) {
        char why[80];
        snprintf(why, sizeof why, "out of budget: %.3g steps would be needed", plan.steps);
        stress_row_refuse(row, why);
        return true;
    }
    if (!solver_init(&solver, &bench->system, row->method, &settings, bench->span))
        return false;
    /* the method chooses its first step */
    if (adaptive)
        solver.dt = 0;
    solver.max = COST_MAX;
    const enum stop stop = solver_run(&solver, bench->grid, bench->cancel);
    row->steps = solver.steps;
    if (judge_singular(bench, stop, row))
        ;
    else if (stop == STOP_END)
        judge_end(bench, row);
    else
        judge_stop(bench, &solver, &settings, &plan, stop, row);
    solver_free(&solver);
    return true;
}

/* ---- all of them ---- */

/* Keeps only the case of this name or number. Returns false with the error if there is none. */
static bool select_case(struct stress *stress, struct text only, struct error *error)
{
    double number;
    int index = 0;
    while (index < stress->count && !text_is(only, stress->cases[index].name))
        index++;
    if (index == stress->count && real_parse(only, &number) == REAL_OK && number >= 1 &&
        number <= stress->count && number == (int)number)
        index = (int)number - 1;
    if (index == stress->count) {
        error_at(error, only, "there is no case '%.*s' of %d", (int)(only.len < 64 ? only.len : 64),
                 only.data, stress->count);
        return error_hint(error, "'stress --full' lists them by number and name");
    }
    stress->cases[0] = stress->cases[index];
    stress->count = 1;
    return true;
}

/* Runs every method in every case, or only in the case `only`. */
bool study_stress(const struct stress_scene *scene, struct text only,
                  const struct method *const *methods, int count, const struct cancel *cancel,
                  struct stress *stress, struct error *error)
{
    const int64_t begin = clock_ns();
    memset(stress, 0, sizeof *stress);
    if (!scene)
        list_built_in_cases(stress);
    else if (!stress_scene_cases(stress, scene))
        return stress->count == STRESS_MAX
                   ? error_set(error, ERROR_COMMAND,
                               "too many parameters: they need more than %d cases", STRESS_MAX)
                   : error_memory(error);
    if (only.len > 0 && !select_case(stress, only, error))
        return false;
    double *limit = malloc(((size_t)count + 1) * sizeof *limit);
    stress->row = calloc((size_t)(stress->count * count) + 1, sizeof *stress->row);
    bool ok = stress->row && limit;
    for (int m = 0; m < count && ok; m++)
        limit[m] = NAN;
    for (int c = 0; c < stress->count && ok && !cancelled(cancel); c++) {
        struct stress_state bench;
        ok = bench_init(&bench, &stress->cases[c], cancel);
        bench.limit = limit;
        for (int m = 0; m < count && ok && !cancelled(cancel); m++) {
            struct stress_row row = {
                .index = c, .scene = stress->cases[c].name, .method = methods[m]};
            const int64_t start = clock_cpu_ns();
            ok = run_case(&bench, m, &row);
            row.seconds = (double)(clock_cpu_ns() - start) * 1e-9;
            if (!ok || cancelled(cancel))
                break;
            stress->count_of[row.verdict]++;
            stress->row[stress->rows++] = row;
        }
        bench_free(&bench);
    }
    free(limit);
    stress->seconds = clock_seconds(begin);
    if (!ok)
        return error_memory(error);
    return !cancelled(cancel) ||
           error_set(error, ERROR_CANCELLED, "stopped: %d of %d cases finished", stress->rows,
                     stress->count * count);
}

void stress_free(struct stress *stress)
{
    free(stress->row);
    arena_reset(&stress->text);
    stress->row = NULL;
    stress->rows = 0;
}
