/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Hz and rad/s: every way of writing a frequency gives the same, or is refused with a word. */
#include "cmocka_testing.h"

#include "unit/command/testing.h"
#include "unit/random_testing.h"

static int pick(int below)
{
    return (int)(random_uniform() * below);
}

static bool is_near(double a, double b)
{
    return fabs(a - b) <= 1e-9 * fmax(fabs(a), fabs(b)) + 1e-300;
}

static double let_value(struct bench *b, const char *name)
{
    struct named_value value = {.value = NAN};
    assert_true(names_value(b->session, text_of(name), &value));
    return value.value;
}

/* Types NAME = `form`, a printf() format of the numbers behind it. If it `fits`, the name must get
 * the wanted value [SI], else it must be refused with a message. */
static void expect_frequency(struct bench *b, const char *name, double wanted, bool fits,
                             const char *form, ...)
{
    struct buffer line = {0};
    char typed[160];
    va_list numbers;
    va_start(numbers, form);
    vsnprintf(typed, sizeof typed, form, numbers);
    va_end(numbers);
    buffer_format(&line, "%s = %s", name, typed);
    const bool done = type(b, line.data);
    if (done != fits)
        fail_msg("'%s' was %s: %s", line.data, done ? "taken" : "refused", said(&b->err));
    if (done && !is_near(let_value(b, name), wanted))
        fail_msg("'%s' gives %.17g, wanted %.17g", line.data, let_value(b, name), wanted);
    if (!done && b->err.len == 0)
        fail_msg("'%s' fails without a word", line.data);
    buffer_free(&line);
}

/* Types random frequencies: omega and omega0 accept a frequency as 2*pi*f or as plain f Hz
 * (converted by 2 pi), also in sums and from a variable. f0, T0 and phase accept rad/s where that
 * is unambiguous. Forms that would be wrong by a factor of 2 pi are refused. */
TEST(test_cycles_and_radians)
{
    const double turn = 2 * 3.14159265358979323846;
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "scene driven");
    for (int round = 0; round < 100; round++) {
        const double f = 0.25 + pick(40) / 8.0, t = 0.125 + pick(16) / 8.0;
        char set[64];
        snprintf(set, sizeof set, "f0 = %g Hz; let f = %g Hz", f, f);
        type_ok(&b, set);
        for (int i = 0; i < 2; i++) {
            const char *name = i ? "omega" : "omega0";
            expect_frequency(&b, name, turn * f, true, "%g Hz", f);
            expect_frequency(&b, name, turn * f, true, "%g mHz", 1000 * f);
            expect_frequency(&b, name, turn * f, true, "2*pi*%g Hz", f);
            expect_frequency(&b, name, turn * f, true, "%g Hz*2*pi", f);
            expect_frequency(&b, name, turn * f, true, "2*pi*(%g Hz + %g mHz)", f / 2, 500 * f);
            expect_frequency(&b, name, turn * f, true, "2*pi*(%g Hz)*(%g s)/(%g s)", f, t, t);
            expect_frequency(&b, name, turn * f, true, "2*pi/(%.17g s)", 1 / f);
            expect_frequency(&b, name, turn * f, true, "2*pi*f");
            expect_frequency(&b, name, turn * (f + t), true, "2*pi*(%g Hz) + %g Hz*2*pi", f, t);
            expect_frequency(&b, name, turn * (f + t), true, "%g Hz + %.17g rad/s", f, turn * t);
            expect_frequency(&b, name, f, true, "%g rad/s", f);
            expect_frequency(&b, name, 0, false, "6.2831853*%g Hz", f);
            expect_frequency(&b, name, 0, false, "2*pi*%g Hz + %g Hz", f, t);
            expect_frequency(&b, name, turn * f, true, "f");
            expect_frequency(&b, name, 0, false, "3*f");
            expect_frequency(&b, name, 0, false, "sqrt(k/m) + %g Hz", f);
        }
        expect_frequency(&b, "f0", f, true, "(%.17g rad/s)/(2*pi)", turn * f);
        expect_frequency(&b, "f0", f, true, "%.17g rad/s", turn * f);
        expect_frequency(&b, "f0", f + t, true, "sqrt(k/m)/(2*pi) + %g Hz", t);
        snprintf(set, sizeof set, "f0 = %g Hz", f);
        type_ok(&b, set);
        expect_frequency(&b, "f0", f + t, true, "omega0/(2*pi) + %g Hz", t);
        snprintf(set, sizeof set, "f0 = %g Hz", f);
        type_ok(&b, set);
        expect_frequency(&b, "f0", f, true, "omega0");
        expect_frequency(&b, "f0", f, true, "%g*2*pi rad/s", f);
        expect_frequency(&b, "T0", 1 / f, true, "1/(%g Hz)", f);
        expect_frequency(&b, "T0", 1 / f, true, "2*pi/(2*pi*%g Hz)", f);
        expect_frequency(&b, "phase", turn * f * t, true, "2*pi*%g Hz*%g s", f, t);
        expect_frequency(&b, "phase", turn * f * t + 1, true, "1 rad + 2*pi*f*(%g s)", t);
        expect_frequency(&b, "phase", 0, false, "%g Hz*%g s", f, t);
        expect_frequency(&b, "let x", 0, false, "cos(%g Hz*%g s)", f, t);
        expect_frequency(&b, "let x", 0, false, "(%g rad/s)^2 + (%g Hz)^2", f, t);
        expect_frequency(&b, "k", let_value(&b, "m") * turn * turn * f * f, true,
                         "m*(2*pi*%g Hz)^2", f);
    }
    bench_close(&b);
}

RUN_TESTS(NULL, NULL)
