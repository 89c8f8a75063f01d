/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Exact solutions against the reference table (60-digit closed forms), against an integration by
 * Taylor series in long double that knows nothing of roots, and against what any flow must satisfy.
 */
#include <hooke/base/number.h>
#include "long_form.h"
#include "unit/scene/testing.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- an independent solution ---- */
/*
 * q'' = -w2 q - gamma q' - g + f cos(omega t + phase) by its Taylor coefficients:
 * (i+2)(i+1) q[i+2] = -w2 q[i] - gamma (i+1) q[i+1] + drive[i].
 */

enum { TERMS = 40 };

static void taylor_step(const struct oscillator *o, long double t, long double h, long double y[2])
{
    long double q[TERMS + 2] = {y[0], y[1]};
    long double angle = (long double)o->omega * t + (long double)o->phase,
                size = (long double)o->drive;
    for (int i = 0; i < TERMS; i++) {
        /* i-th Taylor coefficient of the drive: the i-th derivative of cos turns the angle by i
         * pi/2. */
        static const int sign[] = {1, -1, -1, 1};
        long double force = size * (long double)sign[i % 4] * (i % 2 ? sinl(angle) : cosl(angle));
        if (i == 0)
            force -= (long double)o->gravity;
        q[i + 2] = (force - (long double)o->stiffness * q[i] -
                    (long double)o->damping * (long double)(i + 1) * q[i + 1]) /
                   (long double)((i + 1) * (i + 2));
        size *= (long double)o->omega / (long double)(i + 1);
    }
    y[0] = y[1] = 0;
    for (int i = TERMS + 1; i >= 0; i--)
        y[0] = y[0] * h + q[i];
    for (int i = TERMS + 1; i >= 1; i--)
        y[1] = y[1] * h + q[i] * (long double)i;
}

/* Also returns the largest |q| and |v| on the way: what errors are measured against. */
static void integrate(const struct system *system, double t, long double y[2], long double top[2])
{
    const struct oscillator *o = &system->oscillator;
    double rate =
        fmax(fmax(sqrt(fabs(o->stiffness)), fabs(o->damping)), o->drive != 0 ? o->omega : 0);
    long double span = (long double)t - (long double)system->t0;
    long steps = (long)ceill(fabsl(span) * 2 * (long double)rate) + 1;
    long double h = span / (long double)steps;
    y[0] = top[0] = (long double)system->start[0];
    y[1] = top[1] = (long double)system->start[1];
    for (int j = 0; j < 2; j++)
        top[j] = fabsl(top[j]);
    for (long i = 0; i < steps; i++) {
        taylor_step(o, (long double)system->t0 + (long double)i * h, h, y);
        for (int j = 0; j < 2; j++)
            top[j] = fmaxl(top[j], fabsl(y[j]));
    }
}

static void check_against_integration(const struct system *system, double t, double tolerance)
{
    long double y[2], top[2];
    double exact[2], floor[2];
    integrate(system, t, y, top);
    system_exact(system, system->t0, system->start, t, exact, floor);
    for (int j = 0; j < 2; j++) {
        double error = (double)fabsl((long double)exact[j] - y[j]);
        if (!(error <= tolerance * (double)top[j])) {
            const struct oscillator *o = &system->oscillator;
            fail_msg("component %d at t = %.17g: %.17g, integrated %.20Lg, error %.3g of the "
                     "largest; w2 %.17g gamma %.17g "
                     "g %g f %g omega %.17g phase %g start %g %g t0 %g",
                     j, t, exact[j], y[j], error / (double)top[j], o->stiffness, o->damping,
                     o->gravity, o->drive, o->omega, o->phase, system->start[0], system->start[1],
                     system->t0);
        }
    }
}

/* A system straight from coefficients, with mass 1. */
static struct system oscillating(struct oscillator o, double q0, double v0, double t0)
{
    o.whole = true;
    return (struct system){.n = 2,
                           .order = 2,
                           .linear = true,
                           .mass = 1,
                           .oscillator = o,
                           .start = {q0, v0},
                           .t0 = t0};
}

TEST(test_every_regime)
{
    uint64_t seed = 1;
    const int rounds = is_long() ? 20000 : 1000;
    for (int i = 0; i < rounds; i++) {
        double omega0 = pow(10, random_between(&seed, -2, 1));
        struct oscillator o = {.stiffness = omega0 * omega0};
        o.damping = pow(10, random_between(&seed, -4, 0.5)) * omega0;
        switch (i % 6) {
        case 0: /* zeta = 1 +- something tiny */
            o.damping = 2 * omega0 *
                        (1 + (random_unit(&seed) - 0.5) * pow(10, random_between(&seed, -16, -1)));
            break;
        case 1:
            o.damping = 0;
            break;
        case 2:
            o.damping = -0.3 * o.damping;
            break;
        case 3:
            o.stiffness = random_unit(&seed) < 0.5 ? 0 : -o.stiffness;
            break;
        default:
            break;
        }
        if (i % 5 == 0)
            o.gravity = random_between(&seed, -10, 10);
        if (i % 7 < 4) {
            o.drive = random_between(&seed, -2, 2);
            o.omega = omega0 * pow(10, random_between(&seed, -1, 1));
            o.phase = random_between(&seed, -4, 4);
            if (i % 7 == 1) /* resonance, exactly and nearly */
                o.omega = omega0 * (1 + (i % 2) * pow(10, random_between(&seed, -16, -1)));
            if (i % 7 == 2)
                o.omega = 0;
        }
        double slow = fmax(fmax(omega0, fabs(o.damping)), o.omega);
        double t0 = i % 3 ? 0 : random_between(&seed, -5, 5),
               t = t0 + random_between(&seed, i % 11 ? 0 : -3, 30) / slow;
        struct system system =
            oscillating(o, random_between(&seed, -1, 1), omega0 * random_between(&seed, -1, 1), t0);
        check_against_integration(&system, t, 4 * DBL_EPSILON);
    }
}

/* Nodes of the divided differences at every distance from each other: no branch may show. */
TEST(test_meeting_roots)
{
    for (int decade = -18; decade <= 0; decade++)
        for (int sign = -1; sign <= 1; sign += 2) {
            double off = sign * pow(10, decade);
            for (double t = 0.1; t < 60; t *= 3) {
                struct system critical = oscillating(
                    (struct oscillator){.stiffness = 1, .damping = 2 + off, .gravity = 1}, 1, -1,
                    0);
                check_against_integration(&critical, t, 4 * DBL_EPSILON);
                struct system resonant = oscillating(
                    (struct oscillator){.stiffness = 1, .drive = 1, .omega = 1 + off, .phase = 0.3},
                    0, 0, 0);
                check_against_integration(&resonant, t, 4 * DBL_EPSILON);
                struct system damped = oscillating(
                    (struct oscillator){
                        .stiffness = 1, .damping = fabs(off), .drive = 1, .omega = 1, .phase = -1},
                    0, 0, 0);
                check_against_integration(&damped, t, 4 * DBL_EPSILON);
                struct system soft =
                    oscillating((struct oscillator){.stiffness = off, .gravity = 9.81}, 1, 1, 0);
                check_against_integration(&soft, t, 4 * DBL_EPSILON);
                struct system thin =
                    oscillating((struct oscillator){.damping = off, .gravity = 9.81}, 1, 1, 0);
                check_against_integration(&thin, t, 4 * DBL_EPSILON);
            }
        }
}

/* ---- closed forms in the limits ---- */

static void expect_near(double got, double wanted, double tolerance)
{
    if (!(fabs(got - wanted) <= tolerance))
        fail_msg("%.17g, wanted %.17g within %.3g", got, wanted, tolerance);
}

static void exact_at(const struct system *system, double t, double y[2])
{
    system_exact(system, system->t0, system->start, t, y, NULL);
}

TEST(test_without_spring)
{
    double y[2];
    struct system free = oscillating((struct oscillator){0}, 2, 3, 1);
    exact_at(&free, 5, y);
    expect_near(y[0], 14, 0);
    expect_near(y[1], 3, 0);

    struct system parabola = oscillating((struct oscillator){.gravity = 9.81}, 2, 3, 0);
    exact_at(&parabola, 4, y);
    expect_near(y[0], 2 + 12 - 9.81 * 8, 1e-14);
    expect_near(y[1], 3 - 9.81 * 4, 1e-14);

    /* Falling against linear drag: v = -(g/gamma)(1 - exp(-gamma t)). */
    struct system fall = oscillating((struct oscillator){.gravity = 9.81, .damping = 0.5}, 0, 0, 0);
    exact_at(&fall, 3, y);
    expect_near(y[1], 9.81 / 0.5 * expm1(-1.5), 1e-14);
    expect_near(y[0], -9.81 / 0.5 * (3 + expm1(-1.5) / 0.5), 3e-14);
    fall.start[1] = 7;
    fall.oscillator.gravity = 0;
    exact_at(&fall, 3, y);
    expect_near(y[0], -7 * expm1(-1.5) / 0.5, 1e-14);
}

TEST(test_equilibrium_is_kept)
{
    struct system system = BOUND({"g", 9.81}, {"gamma", 0.3}, {"y0", -0.2 * 9.81 / 15});
    double y[2];
    for (double t = 0; t < 100; t += 7.3) {
        exact_at(&system, t, y);
        expect_near(y[0], system.start[0], 1e-16);
        expect_near(y[1], 0, 1e-16);
    }
}

TEST(test_forced_amplitude)
{
    /* Long after the start only |f| / |w2 - omega^2 + i gamma omega| is left. */
    struct oscillator o = {.stiffness = 75, .damping = 0.3, .drive = 0.1, .omega = 8.2, .phase = 1};
    struct system system = oscillating(o, 0.05, 0, 0);
    double top = 0, y[2];
    for (double t = 400; t < 401; t += 1e-4) {
        exact_at(&system, t, y);
        top = fmax(top, fabs(y[0]));
    }
    expect_near(top / (0.1 / hypot(75 - 8.2 * 8.2, 0.3 * 8.2)), 1, 1e-6);
}

TEST(test_stiff_driven)
{
    /* Damping far beyond the spring: a slow drift and a small forced motion, both without
     * cancellation. */
    struct oscillator o = {.stiffness = 1, .damping = 1e9, .drive = 1, .omega = 1};
    struct system system = oscillating(o, 1, 0, 0);
    for (double t = 1; t < 1e10; t *= 7) {
        double y[2];
        exact_at(&system, t, y);
        double slow = 1e-9, decay = exp(-slow * t); /* roots -slow and -1e9, to 1e-18 */
        expect_near(y[0], decay + slow * sin(t), 4e-16 * (decay + slow));
        expect_near(y[1], slow * (cos(t) - decay), 1e-15 * slow);
    }
}

/* ---- extremes ---- */

TEST(test_any_amplitude)
{
    static const struct oscillator all[] = {{.stiffness = 75, .damping = 0.25},
                                            {.stiffness = 75, .damping = 40},
                                            {.stiffness = -3},
                                            {.damping = 0.25}};
    for (size_t i = 0; i < COUNT_OF(all); i++)
        for (int power = -1000; power <= 990; power += 199) {
            struct system one = oscillating(all[i], 0.75, -0.5, 0), other = one;
            double y[2], scaled[2];
            for (int j = 0; j < 2; j++)
                other.start[j] = ldexp(one.start[j], power);
            exact_at(&one, 2.5, y);
            exact_at(&other, 2.5, scaled);
            /* linear: powers of two pass through exactly */
            for (int j = 0; j < 2; j++)
                assert_true(scaled[j] == ldexp(y[j], power));
        }
    double y[2];
    struct system tiny = BOUND({"y0", 1e-310}), huge = BOUND({"y0", 1e300});
    exact_at(&tiny, 0.1, y);
    expect_near(y[0] / 1e-310, cos(sqrt(75) * 0.1), 1e-13);
    exact_at(&huge, 0.1, y);
    expect_near(y[0] / 1e300, cos(sqrt(75) * 0.1), 1e-15);
}

TEST(test_growth_ends_as_infinity)
{
    static const struct oscillator all[] = {{.stiffness = 1, .damping = -1e9},
                                            {.stiffness = -1e12},
                                            {.stiffness = 1, .damping = -1},
                                            {.stiffness = -1, .drive = 1, .omega = 2}};
    for (size_t i = 0; i < COUNT_OF(all); i++)
        for (double t = 1e4; t <= 1e12; t *= 100) {
            struct system system = oscillating(all[i], 1, 0, 0);
            double y[2], floor[2];
            system_exact(&system, 0, system.start, t, y, floor);
            assert_true(isinf(y[0]) && isinf(y[1]));
        }
    struct system rest = oscillating((struct oscillator){.stiffness = -1e12}, 0, 0, 0);
    double y[2];
    exact_at(&rest, 1e10, y);
    assert_true(y[0] == 0 && y[1] == 0);
}

/* ---- what every flow satisfies ---- */

TEST(test_semigroup)
{
    uint64_t seed = 2;
    for (int i = 0; i < 2000; i++) {
        struct oscillator o = {.stiffness = random_between(&seed, -2, 20),
                               .damping = random_between(&seed, -1, 8)};
        if (i % 3 == 0)
            o.gravity = 9.81;
        if (i % 4 == 0)
            o = (struct oscillator){.stiffness = o.stiffness,
                                    .damping = o.damping,
                                    .gravity = o.gravity,
                                    .drive = 1,
                                    .omega = random_between(&seed, 0, 9),
                                    .phase = 0.5,
                                    .whole = true};
        struct system system =
            oscillating(o, random_between(&seed, -1, 1), random_between(&seed, -1, 1), -1);
        double t1 = random_between(&seed, -1, 4), t2 = random_between(&seed, -1, 4);
        double half[2], whole[2], twice[2], back[2], floor[2];
        system_exact(&system, -1, system.start, t1, half, floor);
        system_exact(&system, t1, half, t2, twice, NULL);
        system_exact(&system, -1, system.start, t2, whole, NULL);
        system_exact(&system, t1, half, -1, back, NULL);
        /* Rounding to double half way is magnified by at most the growth of the flow. */
        double growth = exp(5 * (fabs(o.damping) + sqrt(fabs(fmin(o.stiffness, 0))))) * 20;
        double size = hypot(half[0], half[1]) + 10;
        for (int j = 0; j < 2; j++) {
            expect_near(twice[j], whole[j],
                        4 * DBL_EPSILON * fmin(growth, t2 < t1 ? growth : 1e3) * size);
            expect_near(back[j], system.start[j], 4 * DBL_EPSILON * growth * size);
        }
    }
}

TEST(test_start_is_exact)
{
    struct system system = BOUND({"gamma", 0.25}, {"F0", 1}, {"g", 9.81}, {"t0", 3}, {"v0", 0.1});
    double y[2], floor[2];
    system_exact(&system, system.t0, system.start, 3, y, floor);
    assert_true(y[0] == 0.05 && y[1] == 0.1);
}

/* One ulp in the coefficients must move the answer by no more than the floor, and the floor must
 * not hide real errors.
 */
TEST(test_floor)
{
    uint64_t seed = 3;
    double tightest = 0;
    for (int i = 0; i < 3000; i++) {
        struct oscillator o = {.stiffness = pow(10, random_between(&seed, -2, 4))};
        o.damping = i % 2 ? 0 : random_between(&seed, 0, 4) * sqrt(o.stiffness);
        if (i % 3 == 0)
            o = (struct oscillator){.stiffness = o.stiffness,
                                    .damping = o.damping,
                                    .drive = 1,
                                    .omega = random_between(&seed, 0, 50),
                                    .whole = true};
        double turn = sqrt(o.stiffness), t = random_between(&seed, 0, 40) / turn;
        struct system system =
            oscillating(o, random_between(&seed, -1, 1), turn * random_between(&seed, -1, 1), 0);
        struct system other = system;
        double y[2], moved[2], floor[2];
        system_exact(&system, 0, system.start, t, y, floor);
        other.oscillator.stiffness *= 1 + 0x1p-40;
        system_exact(&other, 0, system.start, t, moved, NULL);
        for (int j = 0; j < 2; j++) {
            double change = fabs(moved[j] - y[j]) * 0x1p-12; /* 2^-40 to 2^-52 */
            expect_near(change, 0, 5 * floor[j]);            /* a floor is an estimate */
            tightest = fmax(tightest, change / floor[j]);
        }
        if (o.drive == 0 && o.damping == 0) {
            double amplitude = hypot(system.start[0], system.start[1] / turn);
            assert_true(floor[0] > 0.5 * DBL_EPSILON * turn * t * amplitude);
            assert_true(floor[0] < 3 * DBL_EPSILON * (1 + turn * t) * amplitude);
        }
    }
    assert_true(tightest > 0.1);
}

/* Many times a step apart, with the rounding that a grid has, and one between: as found one by one,
 * to an ulp of the largest so far. Forwards and backwards, in every regime; where steps are coarse
 * there is no table. */
TEST(test_table)
{
    uint64_t seed = 5;
    int tables = 0;
    for (int i = 0; i < 300; i++) {
        struct oscillator o = {.stiffness = pow(10, random_between(&seed, -2, 4))};
        const double turn = sqrt(o.stiffness);
        o.damping = i % 5 == 1   ? random_between(&seed, 0, 4) * turn
                    : i % 5 == 2 ? 2 * turn
                    : i % 5 == 3 ? -0.05 * turn
                                 : 0;
        o.gravity = i % 2 ? 9.81 : 0;
        o.drive = i % 3 == 0 ? 1 : 0;
        o.omega = random_between(&seed, 0.5, 2) * turn;
        o.stiffness = i % 7 == 6 ? -o.stiffness : o.stiffness;
        const double t0 = random_between(&seed, -1, 1) / turn;
        const double h = (i % 4 == 0 ? -1 : 1) * pow(10, random_between(&seed, -3, -0.5)) / turn;
        const struct system system =
            oscillating(o, random_between(&seed, -1, 1), turn * random_between(&seed, -1, 1), t0);
        struct exact_table *table = exact_table_create(&system, t0, system.start, h);
        double top[2] = {0, 0};
        assert_true(table || fabs(h) * turn > 0.1);
        for (int k = 0; table && k < 400; k++) {
            const double t = t0 + (k == 321 ? 320.25 : k) * h;
            double y[2], wanted[2];
            system_exact(&system, t0, system.start, t, wanted, NULL);
            exact_table_at(table, t, y);
            for (int j = 0; j < 2; j++) {
                top[j] = fmax(top[j], fabs(wanted[j]));
                expect_near(y[j], wanted[j], DBL_EPSILON * top[j]);
            }
        }
        tables += table != NULL;
        exact_table_free(table);
    }
    assert_true(tables > 200);
    const struct system coarse = oscillating((struct oscillator){.stiffness = 1}, 1, 0, 0);
    assert_null(exact_table_create(&coarse, 0, coarse.start, 1));
}

TEST(test_which_systems_have_one)
{
    struct system plain = BOUND({"gamma", 1}), drag = BOUND({"C", 0.5}),
                  driven = BOUND({"F0", 1}, {"g", 9.81});
    assert_true(system_has_exact(&plain));
    assert_true(system_has_exact(&driven));
    assert_false(system_has_exact(&drag));
    /* then only what does not depend on time, by the matrix exponential */
    driven.oscillator.whole = false;
    assert_false(system_has_exact(&driven));
    plain.oscillator.whole = false;
    assert_true(system_has_exact(&plain));
    plain.linear = false;
    assert_false(system_has_exact(&plain));
}

/* ---- the reference table ---- */

/* The number behind `key` in the parameters column; `other` where it is not there. */
static double keyed(const char *parameters, const char *key, double other)
{
    const char *at = strstr(parameters, key);
    double value = other;
    size_t used;
    if (at)
        (void)real_scan(text_of(at + strlen(key)), '.', &value, &used);
    return at ? value : other;
}

/* Fields of a line of comma-separated values with "quoted" ones, cut in place. */
static int split(char *line, char *field[], int max)
{
    int count = 0;
    while (count < max) {
        bool quoted = *line == '"';
        field[count++] = line += quoted;
        line = strpbrk(line, quoted ? "\"" : ",\n");
        if (!line)
            break;
        *line++ = '\0';
        line += quoted && *line == ',';
    }
    return count;
}

TEST(test_reference_table)
{
    const char *path = getenv("HOOKE_REFERENCES");
    FILE *file = fopen(path && *path ? path : "../shared/references.csv", "r");
    if (!file) {
        print_message("no reference table (HOOKE_REFERENCES): skipped\n");
        skip();
    }
    char line[2000], *field[12];
    int rows = 0;
    while (fgets(line, sizeof line, file)) {
        if (split(line, field, 12) < 6)
            continue;
        bool damped = strcmp(field[0], "damped_oscillator") == 0,
             forced = strcmp(field[0], "forced_oscillator") == 0;
        bool resonance = strcmp(field[0], "resonance") == 0;
        if (!damped && !forced && !resonance)
            continue;
        const char *p = field[1];
        struct oscillator o = {.stiffness = keyed(p, "Omega0^2=", 1),
                               .damping = keyed(p, "gamma=", 0)};
        if (forced)
            o = (struct oscillator){.stiffness = o.stiffness,
                                    .damping = o.damping,
                                    .drive = 0.5,
                                    .omega = 1.2,
                                    .whole = true};
        if (resonance)
            o = (struct oscillator){.stiffness = 1, .drive = 1, .omega = 1, .whole = true};
        struct system system = oscillating(o, keyed(p, "q0=", NAN), keyed(p, "v0=", NAN), 0);
        double t = 0, wanted = 0, y[2], floor[2];
        size_t used;
        assert_int_equal(real_parse(text_of(field[2]), &t), REAL_OK);
        assert_int_equal(real_scan(text_of(field[4]), '.', &wanted, &used), REAL_OK);
        system_exact(&system, 0, system.start, t, y, floor);
        int j = strcmp(field[3], "v") == 0;
        /* The floor, because not every gamma of the table is a double. */
        double tolerance = 2 * DBL_EPSILON * fabs(wanted) + floor[j];
        expect_near(y[j], wanted, tolerance);
        rows++;
    }
    fclose(file);
    assert_int_equal(rows, 21);
}

RUN_TESTS(NULL, NULL)
