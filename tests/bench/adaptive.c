/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Adaptive solves at the same achieved error, not at the same tolerance: the errors of each solver
 * are measured over ten decades of tolerances, and it is timed at the one where they pass the error
 * asked for.
 */
#include "bench/bench.h"
#include "modules/solving/compute/solve.h"

#include <stdio.h>
#include <string.h>

#define SOLVED_ERROR 1e-6
#define BATCH_NS 5e5
#define TOLERANCES 60

/* From 1e-2 on, six a decade. */
static double scanned(double i)
{
    return pow(10, -2 - i / 6);
}

/* ---- problems, as libraries want them ---- */

static void oscillator(double t, const double *y, double *dydt)
{
    (void)t;
    dydt[0] = y[1];
    dydt[1] = -y[0];
}

static void kepler(double t, const double *y, double *dydt)
{
    const double square = y[0] * y[0] + y[1] * y[1], pull = 1 / (square * sqrt(square));
    (void)t;
    dydt[0] = y[2];
    dydt[1] = y[3];
    dydt[2] = -pull * y[0];
    dydt[3] = -pull * y[1];
}

static void vanderpol(double t, const double *y, double *dydt)
{
    (void)t;
    dydt[0] = y[1];
    dydt[1] = 1000 * (1 - y[0] * y[0]) * y[1] - y[0];
}

static void vanderpol_jacobian(double t, const double *y, double *jac)
{
    (void)t;
    jac[0] = 0;
    jac[1] = 1;
    jac[2] = -2000 * y[0] * y[1] - 1;
    jac[3] = 1000 * (1 - y[0] * y[0]);
}

static void robertson(double t, const double *y, double *dydt)
{
    const double burn = 3e7 * y[1] * y[1];
    (void)t;
    dydt[0] = 1e4 * y[1] * y[2] - 0.04 * y[0];
    dydt[1] = -dydt[0] - burn;
    dydt[2] = burn;
}

static void robertson_jacobian(double t, const double *y, double *jac)
{
    const double row[] = {-0.04,       1e4 * y[2], 1e4 * y[1], 0.04, -1e4 * y[2] - 6e7 * y[1],
                          -1e4 * y[1], 0,          6e7 * y[1], 0};
    (void)t;
    memcpy(jac, row, sizeof row);
}

/* ---- solvers ---- */

#define SOLVERS_MAX 12

struct rival {
    const char *name;
    solve_function *solve; /* NULL: hooke's method of that name */
    /* hooke: of the ratio to the solver by hand, NAN: none; others: of hooke's to it */
    double goal;
    const char *absent;
    const char *mine; /* others: hooke's that is of the same kind; NULL: the best */
};

struct entry {
    struct problem problem; /* its span changes on the way to the checks */
    solve_function *solve;
    struct solver solver;
    double tol, error, start[LIMIT_VARIABLES];
    int64_t batch;
};

static bool solve_once(struct entry *e, double tol, const double *start, double *end)
{
    if (e->solve)
        return e->solve(&e->problem, tol, start, end);
    e->solver.tol = tol;
    e->solver.span = e->problem.span;
    solver_start(&e->solver);
    memcpy(e->solver.y, start, (size_t)e->problem.n * sizeof *start);
    const bool reached = solver_run(&e->solver, NULL, NULL) == STOP_END;
    memcpy(end, e->solver.y, (size_t)e->problem.n * sizeof *end);
    return reached;
}

static double run_entry(void *self)
{
    struct entry *e = self;
    double start[LIMIT_VARIABLES], end[LIMIT_VARIABLES] = {0};
    memcpy(start, e->start, sizeof start);
    const int64_t begin = clock_ns();
    for (int64_t i = 0; i < e->batch; i++) {
        if (!solve_once(e, e->tol, start, end))
            return NAN;
        start[0] = e->start[0] + 1e-300 * end[0]; /* the next waits for this one */
    }
    return (double)(clock_ns() - begin) / (double)e->batch * 1e-3;
}

/* The largest error at the checks. */
static double achieved(struct entry *e, double tol)
{
    const double span = e->problem.span;
    double max = 0;
    for (int k = 0; k < PROBLEM_CHECKS && e->problem.check[k].t > 0; k++) {
        const struct check *check = &e->problem.check[k];
        double end[LIMIT_VARIABLES] = {0};
        e->problem.span = check->t;
        if (!solve_once(e, tol, e->start, end))
            max = NAN;
        for (int i = 0; i < e->problem.n; i++) {
            const double error = fabs(end[i] - check->y[i]) / e->problem.unit[i];
            if (!(error <= max))
                max = error;
        }
    }
    e->problem.span = span;
    return max;
}

/*
 * Returns the tolerance below which there are as many larger errors as there are small ones above
 * it, which is where errors that fall steadily pass `wanted`. NAN means that there is none.
 */
static double tolerance_of(struct entry *e, double wanted)
{
    int large = 0, small = 0;
    for (int i = 0; i < TOLERANCES; i++) {
        const double error = achieved(e, scanned(i));
        if (small > 0 && isnan(error)) /* too fine for it */
            break;
        large += !(error <= wanted);
        small += error <= wanted;
    }
    return small == 0 || large == 0 ? NAN : scanned(large - 0.5);
}

/* Makes it ready to be timed. Returns false if it does not reach the error. */
static bool calibrate(struct entry *e)
{
    e->tol = tolerance_of(e, SOLVED_ERROR);
    if (isnan(e->tol))
        return false;
    e->error = achieved(e, e->tol);
    e->batch = 1;
    run_entry(e);
    const double once = run_entry(e) * 1e3;
    e->batch = once < BATCH_NS ? (int64_t)(BATCH_NS / once) + 1 : 1;
    return once > 0;
}

static void compete(const struct problem *p, const struct scene *scene, const struct rival *rival)
{
    struct system system;
    struct error error = {0};
    struct entry entry[SOLVERS_MAX];
    struct arm arm[SOLVERS_MAX];
    const char *name[SOLVERS_MAX], *missing[SOLVERS_MAX], *why[SOLVERS_MAX];
    double goal[SOLVERS_MAX];
    int kin[SOLVERS_MAX]; /* place of hooke's that it is measured against, -1: the best */
    int count = 0, gone = 0, hand = -1, best = -1;
    if (!scene_bind(scene, &system, &error))
        bench_die(p->name, error.text);
    for (const struct rival *c = rival; c->name; c++) {
        struct entry *e = &entry[count];
        const struct method *method = c->solve || c->absent ? NULL : bench_method(c->name);
        *e = (struct entry){.problem = *p, .solve = c->solve};
        memcpy(e->start, system.start, sizeof e->start);
        const struct run_settings settings = {.tol = 1e-6};
        const char *reason = c->absent ? c->absent : !c->solve && !method ? "not installed" : NULL;
        if (!reason && !c->solve && !solver_init(&e->solver, &system, method, &settings, p->span))
            reason = "cannot";
        if (!reason && !calibrate(e))
            reason = "does not reach the error";
        if (reason) {
            missing[gone] = c->name;
            why[gone++] = reason;
            continue;
        }
        name[count] = c->name;
        goal[count] = c->goal;
        kin[count] = -1;
        for (int i = 0; i < count && c->mine; i++)
            if (strcmp(name[i], c->mine) == 0)
                kin[count] = i;
        arm[count] = (struct arm)ARM(run_entry, e);
        count++;
    }
    for (int i = 0; i < count; i++)
        arm[i].self = &entry[i];
    contest(arm, count);
    for (int i = 0; i < count; i++) {
        if (entry[i].solve)
            hand = hand < 0 ? i : hand;
        else if (strncmp(name[i], "cvode", 5) != 0 &&
                 (best < 0 || arm[i].minimum < arm[best].minimum))
            best = i;
    }
    table_begin(p->name, "us a solve");
    char what[64];
    for (int i = 0; i < count && hand >= 0 && best >= 0; i++) {
        const bool own = !entry[i].solve && strncmp(name[i], "cvode", 5) != 0;
        const int mine = own ? i : kin[i] >= 0 ? kin[i] : best;
        snprintf(what, sizeof what, "%s, tol %.1e, error %.1e", name[mine], entry[mine].tol,
                 entry[mine].error);
        if (own)
            table_row(what, &arm[i], name[hand], &arm[hand], i == best ? goal[i] : NAN);
        else if (i != hand)
            table_row(name[mine], &arm[mine], name[i], &arm[i], goal[i]);
    }
    for (int i = 0; i < gone; i++)
        table_absent(missing[i], why[i]);
    for (int i = 0; i < count; i++)
        if (entry[i].solve || strncmp(name[i], "cvode", 5) == 0)
            table_note("%s: tol %.1e, error %.1e", name[i], entry[i].tol, entry[i].error);
    for (int i = 0; i < count; i++)
        if (!entry[i].solve)
            solver_free(&entry[i].solver);
}

/* ---- the contests ---- */

static const char note[] = "Each at the tolerance where its error is 1e-6 (unit: the amplitudes); "
                           "hooke without recording.";
#ifdef HAVE_BOOST
#define BOOST(function) .solve = (function)
#else
#define BOOST(function) .absent = "not installed (libboost-dev)"
#endif

/* What is to come out, and scales, from the closed form of hooke's own scene. */
static void exact_end(struct problem *p, const struct scene *scene)
{
    struct system system;
    struct error error = {0};
    if (!scene_bind(scene, &system, &error))
        bench_die(p->name, error.text);
    p->check[0].t = p->span;
    system_exact(&system, system.t0, system.start, p->span, p->check[0].y, NULL);
    memcpy(p->scale, system.scale, sizeof p->scale);
}

struct problem bench_oscillator(double span, struct scene *scene)
{
    struct problem problem = {.name = "Harmonic oscillator to t = 100",
                              .n = 2,
                              .span = span,
                              .unit = {1, 1},
                              .slope = oscillator};
    *scene = bench_scene("duffing", "k3", 0); /* m = k = y0 = 1 */
    exact_end(&problem, scene);
    return problem;
}

struct problem bench_kepler(int orbits, struct scene *scene)
{
    struct problem problem = {.name = "Kepler, e = 0.5, 20 orbits",
                              .n = 4,
                              .span = orbits * 6.283185307179586477,
                              .unit = {1, 1, 1, 1},
                              .slope = kepler};
    *scene = bench_scene("kepler", NULL, 0);
    exact_end(&problem, scene);
    return problem;
}

double bench_tolerance(const struct problem *problem, const struct scene *scene, const char *method,
                       double tol, solve_function *other, double *error)
{
    struct system system;
    struct error failure = {0};
    struct entry own = {.problem = *problem}, rival = {.problem = *problem, .solve = other};
    const struct run_settings settings = {.tol = tol};
    if (!scene_bind(scene, &system, &failure) ||
        !solver_init(&own.solver, &system, bench_method(method), &settings, problem->span))
        bench_die(problem->name, "cannot be solved");
    memcpy(own.start, system.start, sizeof own.start);
    memcpy(rival.start, system.start, sizeof rival.start);
    *error = achieved(&own, tol);
    solver_free(&own.solver);
    return tolerance_of(&rival, *error);
}

void bench_adaptive(void)
{
    static const struct rival swings[] = {
        {"C dop853", hand_dop853_oscillator, NAN, NULL, NULL},
        {"dop853", NULL, 1.2, NULL, NULL},
        {"dopri5", NULL, 1.2, NULL, NULL},
        {"tsit5", NULL, 1.2, NULL, NULL},
        {"gsl rk8pd", gsl_rk8pd, 1, NULL, NULL},
        {"boost fehlberg78", BOOST(boost_fehlberg78), .goal = 1.05, .mine = "dop853"},
        {"boost dopri5", BOOST(boost_dopri5), .goal = 1.05, .mine = "dopri5"},
        {"cvode-adams", NULL, 1, NULL, NULL},
        {NULL, NULL, 0, NULL, NULL},
    };
    static const struct rival orbits[] = {
        {"C dop853", hand_dop853_kepler, NAN, NULL, NULL},
        {"dop853", NULL, 1.2, NULL, NULL},
        {"dopri5", NULL, 1.2, NULL, NULL},
        {"tsit5", NULL, 1.2, NULL, NULL},
        {"gsl rk8pd", gsl_rk8pd, 1, NULL, NULL},
        {"boost fehlberg78", BOOST(boost_fehlberg78), .goal = 1.05, .mine = "dop853"},
        {"boost dopri5", BOOST(boost_dopri5), .goal = 1.05, .mine = "dopri5"},
        {"cvode-adams", NULL, 1, NULL, NULL},
        {NULL, NULL, 0, NULL, NULL},
    };
    struct scene scene;
    const struct problem unit = bench_oscillator(100, &scene);
    compete(&unit, &scene, swings);
    table_note("%s", note);
    const struct problem orbit = bench_kepler(20, &scene);
    compete(&orbit, &scene, orbits);
    table_note("%s", note);
}

/* Reference values: __float128 Radau IIA of order 17 against order 13; IVP test set (Mazzia,
 * Magherini 2008). */
void bench_stiff(void)
{
    static const struct rival relaxations[] = {
        {"C rodas5p", hand_rodas5p_vanderpol, NAN, NULL, NULL},
        {"rodas5p", NULL, 1.3, NULL, NULL},
        {"radau5", NULL, 1.3, NULL, NULL},
        {"gsl msbdf", gsl_msbdf, 1, NULL, NULL},
        {"gsl bsimp", gsl_bsimp, 1, NULL, NULL},
        {"boost rosenbrock4", BOOST(boost_rosenbrock4), .goal = 1},
        {"cvode-bdf", NULL, 1, NULL, NULL},
        {NULL, NULL, 0, NULL, NULL},
    };
    static const struct rival reactions[] = {
        {"C rodas5p", hand_rodas5p_robertson, NAN, NULL, NULL},
        {"rodas5p", NULL, 1.3, NULL, NULL},
        {"radau5", NULL, 1.3, NULL, NULL},
        {"gsl msbdf", gsl_msbdf, 1, NULL, NULL},
        {"gsl bsimp", gsl_bsimp, 1, NULL, NULL},
        {"boost rosenbrock4", BOOST(boost_rosenbrock4), .goal = 1},
        {"cvode-bdf", NULL, 1, NULL, NULL},
        {NULL, NULL, 0, NULL, NULL},
    };
    static const struct problem vdp = {
        .name = "van der Pol, mu = 1000, to t = 2000",
        .n = 2,
        .span = 2000,
        .check = {{2000, {1.7061677321704650084781876, -8.9280970102481654778e-4}}},
        .unit = {2, 1333},
        .scale = {2, 2},
        .slope = vanderpol,
        .jacobian = vanderpol_jacobian};
    static const struct problem rober = {
        .name = "Robertson to t = 1e11",
        .n = 3,
        .span = 1e11,
        .check =
            {{1, {9.6645973733300350351e-1, 3.07462657857867473926e-5, 3.35095164012107097421e-2}},
             {100,
              {6.172348823960877560214e-1, 6.1535912746391229234e-6, 3.8275896401263760486e-1}},
             {1e4, {1.07300428537804041956e-1, 4.800166972571659793e-7, 8.92699091445498700879e-1}},
             {1e6, {2.03148392497341551292e-3, 8.142277783356161890e-9, 9.97968507932748801131e-1}},
             {1e8,
              {2.08241751217946066846e-5, 8.329841429908957698e-11, 9.99979175741579791094e-1}},
             {1e11,
              {2.08334014970129423057e-8, 8.333360770334783401e-14, 9.99999979166515169379e-1}}},
        .unit = {1, 3.6514837167011e-5, 1},
        .scale = {1, 3.6514837167011e-5, 1},
        .slope = robertson,
        .jacobian = robertson_jacobian};
    struct scene scene = bench_scene("stiff-vanderpol", NULL, 0);
    compete(&vdp, &scene, relaxations);
    table_note("%s", note);
    scene = bench_scene("robertson", NULL, 0);
    compete(&rober, &scene, reactions);
    table_note("%s", note);
}
