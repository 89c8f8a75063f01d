/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Units in expressions: random ones with units, numbers and names against an evaluator of this
 * file's own, which knows each tree's value and dimension before it is written down.
 */
#include <hooke/base/number.h>
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"
#include "unit/random_testing.h"

enum { METRE, KILOGRAM, SECOND, RADIAN, BASES };

static const struct measure_unit {
    const char *name;
    double factor;
    signed char power[BASES];
} units[] = {{"m", 1, {1}},
             {"cm", 1e-2, {1}},
             {"mm", 1e-3, {1}},
             {"kg", 1, {0, 1}},
             {"g", 1e-3, {0, 1}},
             {"s", 1, {0, 0, 1}},
             {"ms", 1e-3, {0, 0, 1}},
             {"min", 60, {0, 0, 1}},
             {"N", 1, {1, 1, -2}},
             {"N/m", 1, {0, 1, -2}},
             {"cm/s", 1e-2, {1, 0, -1}},
             {"m/s^2", 1, {1, 0, -2}},
             {"1/s", 1, {0, 0, -1}},
             {"cm^2", 1e-4, {2}},
             {"rad", 1, {0, 0, 0, 1}},
             {"deg", 3.14159265358979323846 / 180, {0, 0, 0, 1}}};

static const struct {
    const char *name;
    double value;
    signed char power[BASES];
} names[] = {{"y0", 0.05, {1}},           {"v0", 0.3, {1, 0, -1}}, {"m", 0.2, {0, 1}},
             {"k", 15, {0, 1, -2}},       {"dt", 0.01, {0, 0, 1}}, {"gamma", 0.25, {0, 0, -1}},
             {"phase", 0.5, {0, 0, 0, 1}}};

enum sort { BARE, KNOWN, WRONG, UNDECIDED };

struct worth {
    enum sort sort;
    double value;
    int power[BASES];
    bool has_name, has_unit;
};

/* In the order of how tightly they bind. */
enum { SUM, PRODUCT, POWER, ATOM };

static int pick(int below)
{
    return (int)(random_uniform() * below);
}

static bool is_pure(const struct worth *a, int bases)
{
    bool pure = true;
    for (int i = 0; i < bases; i++)
        pure = pure && a->power[i] == 0;
    return pure;
}

static struct worth sum_of(struct worth a, struct worth b, double value)
{
    struct worth sum = a.sort == BARE ? b : a;
    const struct worth *known = a.sort == BARE ? &b : &a;
    sum.value = value;
    sum.has_name = a.has_name || b.has_name;
    sum.has_unit = a.has_unit || b.has_unit;
    if (a.sort == WRONG || b.sort == WRONG)
        sum.sort = WRONG;
    else if (a.sort == UNDECIDED || b.sort == UNDECIDED)
        sum.sort = UNDECIDED;
    else if (a.sort == BARE || b.sort == BARE) {
        if (known->sort == KNOWN && !known->has_name && known->has_unit && !is_pure(known, BASES))
            sum.sort = WRONG;
    } else if (memcmp(a.power, b.power, RADIAN * sizeof *a.power) != 0) {
        sum.sort = sum.has_unit ? WRONG : UNDECIDED;
    } else if (a.power[RADIAN] == 0) {
        sum.power[RADIAN] = b.power[RADIAN];
    }
    return sum;
}

static struct worth product_of(struct worth a, struct worth b, double value, int sign)
{
    struct worth product = a;
    product.value = value;
    product.has_name = a.has_name || b.has_name;
    product.has_unit = a.has_unit || b.has_unit;
    product.sort = a.sort > b.sort ? a.sort : b.sort;
    if (a.sort == WRONG || b.sort == WRONG)
        product.sort = WRONG;
    for (int i = 0; i < BASES; i++)
        product.power[i] += sign * b.power[i];
    return product;
}

static struct worth grow(struct buffer *out, int depth, int binds);

static struct worth grow_leaf(struct buffer *out)
{
    struct worth leaf = {.sort = BARE};
    const int kind = pick(10);
    if (kind < 3) {
        const int i = pick((int)COUNT_OF(names));
        leaf = (struct worth){.sort = KNOWN, .value = names[i].value, .has_name = true};
        for (int b = 0; b < BASES; b++)
            leaf.power[b] = names[i].power[b];
        buffer_put(out, text_of(names[i].name));
        return leaf;
    }
    leaf.value = 1 + pick(40) / 4.0;
    buffer_real(out, leaf.value);
    if (kind < 5)
        return leaf;
    const struct measure_unit *unit = &units[pick((int)COUNT_OF(units))];
    leaf.sort = KNOWN;
    leaf.has_unit = true;
    leaf.value *= unit->factor;
    for (int b = 0; b < BASES; b++)
        leaf.power[b] = unit->power[b];
    buffer_format(out, "%s%s", pick(2) || unit->name[0] == '1' ? " " : "", unit->name);
    return leaf;
}

/* (EXPR) UNIT: of bare numbers, or of the SI numbers of names. */
static struct worth grow_parenthesis(struct buffer *out, int depth)
{
    buffer_char(out, '(');
    struct worth inner = grow(out, depth - 1, SUM);
    const struct measure_unit *unit = &units[pick((int)COUNT_OF(units))];
    buffer_format(out, ")%s%s", pick(2) ? " " : "", unit->name);
    if (inner.sort == WRONG)
        return inner;
    struct worth made = {.sort = inner.has_unit ? WRONG : KNOWN,
                         .value = inner.value * unit->factor,
                         .has_unit = true};
    for (int b = 0; b < BASES; b++)
        made.power[b] = unit->power[b];
    return made;
}

static struct worth grow_call(struct buffer *out, int depth)
{
    const bool larger = pick(2);
    const int which = pick(3);
    if (which == 0) {
        buffer_put(out, TEXT("sqrt(("));
        struct worth a = grow(out, depth - 1, SUM);
        buffer_put(out, TEXT(")^2)"));
        a.value = fabs(a.value);
        return a;
    }
    if (which == 1) {
        buffer_put(out, TEXT("cos("));
        struct worth a = grow(out, depth - 1, SUM), made = {.sort = KNOWN};
        buffer_char(out, ')');
        made.value = cos(a.value);
        made.has_name = a.has_name;
        made.has_unit = a.has_unit;
        made.sort = a.sort != KNOWN ? a.sort : a.has_unit && !is_pure(&a, RADIAN) ? WRONG : KNOWN;
        return made;
    }
    buffer_put(out, larger ? TEXT("max(") : TEXT("min("));
    const struct worth a = grow(out, depth - 1, SUM);
    buffer_put(out, TEXT(", "));
    const struct worth b = grow(out, depth - 1, SUM);
    buffer_char(out, ')');
    return sum_of(a, b, larger == (a.value > b.value) ? a.value : b.value);
}

/* An expression that stands where what binds less tightly needs parentheses. */
static struct worth grow(struct buffer *out, int depth, int binds)
{
    const int kind = depth <= 0 ? 0 : pick(9);
    const int own = kind < 2 ? ATOM : kind < 5 ? SUM : kind < 7 ? PRODUCT : ATOM;
    struct worth made;
    if (kind == 7)
        return grow_parenthesis(out, depth);
    if (kind == 8)
        return grow_call(out, depth);
    if (own < binds)
        buffer_char(out, '(');
    if (own == ATOM) {
        made = grow_leaf(out);
    } else {
        const bool inverse = pick(2);
        const struct worth a = grow(out, depth - 1, own);
        buffer_put(out, own == SUM ? (inverse ? TEXT(" - ") : TEXT(" + "))
                                   : (inverse ? TEXT(" / ") : TEXT("*")));
        const struct worth b = grow(out, depth - 1, own + 1);
        made = own == SUM ? sum_of(a, b, inverse ? a.value - b.value : a.value + b.value)
                          : product_of(a, b, inverse ? a.value / b.value : a.value * b.value,
                                       inverse ? -1 : 1);
    }
    if (own < binds)
        buffer_char(out, ')');
    return made;
}

/* What reads as another unit although it was not meant: 5 N / m. */
static bool reads_otherwise(const char *text)
{
    for (const char *sign = strpbrk(text, "*/"); sign; sign = strpbrk(sign + 1, "*/")) {
        const char *before = sign, *behind = sign + 1;
        while (before > text && before[-1] == ' ')
            before--;
        behind += strspn(behind, " ");
        if (before > text && strchr("Nngmsd2", before[-1]) && strchr("mgs", *behind) &&
            strcspn(behind, " )*/+-,") <= 2)
            return true;
    }
    return false;
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

static bool has_powers(const struct worth *w, int metre, int kilogram, int second)
{
    return w->sort != KNOWN || !w->has_unit ||
           (w->power[METRE] == metre && w->power[KILOGRAM] == kilogram &&
            w->power[SECOND] == second);
}

/* A statement that wants a quantity: it takes what fits, and says what does not. */
static void expect_set(struct bench *b, const char *name, const char *text, const struct worth *w,
                       bool fits)
{
    struct buffer line = {0};
    buffer_format(&line, "%s = %s", name, text);
    const bool done = type(b, line.data);
    if (done != fits)
        fail_msg("'%s' was %s: %s", line.data, done ? "taken" : "refused", said(&b->err));
    if (done && !is_near(let_value(b, name), w->value))
        fail_msg("'%s' gives %.17g, wanted %.17g", line.data, let_value(b, name), w->value);
    type_ok(b, "y0 = 0.05; v0 = 0.3; k = 15; set dt 0.01");
    buffer_free(&line);
}

/* A moment t - (EXPR) is noticed at EXPR. */
static void expect_event(struct bench *b, const char *text, const struct worth *w)
{
    struct buffer line = {0};
    buffer_format(&line, "event probe when t - (%s) do stop; run 1 s; event off", text);
    if (!type(b, line.data) || !is_near(let_value(b, "t"), w->value))
        fail_msg("'%s' stops at %.17g, wanted %.17g: %s", line.data, let_value(b, "t"), w->value,
                 said(&b->err));
    buffer_clear(&line);
    buffer_format(&line, "run until t > %s", text);
    if (!type(b, line.data) || !(fabs(let_value(b, "t") - w->value) <= 0.0101))
        fail_msg("'%s' stops at %.17g, wanted %.17g: %s", line.data, let_value(b, "t"), w->value,
                 said(&b->err));
    type_ok(b, "drop all");
    buffer_free(&line);
}

static void expect_let(struct bench *b, const char *text, const struct worth *w)
{
    struct buffer line = {0};
    buffer_format(&line, "let probe_1 = %s", text);
    const bool done = type(b, line.data);
    if (done == (w->sort == WRONG))
        fail_msg("'%s' was %s: %s", line.data, done ? "taken" : "refused", said(&b->err));
    if (done && !is_near(let_value(b, "probe_1"), w->value))
        fail_msg("'%s' gives %.17g, wanted %.17g", line.data, let_value(b, "probe_1"), w->value);
    buffer_free(&line);
}

TEST(test_random_expressions)
{
    const int rounds = is_long() ? 100000 : 10000;
    struct bench b;
    int taken = 0, refused = 0, events = 0;
    bench_open(&b, false);
    type_ok(&b, "scene spring; y0 = 5 cm; v0 = 30 cm/s; m = 200 g; k = 15 N/m; dt = 10 ms; "
                "gamma = 0.25 1/s; phase = 0.5; method exact");
    for (int round = 0; round < rounds; round++) {
        struct buffer text = {0};
        const struct worth w = grow(&text, 1 + round % 3, SUM);
        buffer_clear(&b.err);
        if (w.sort == UNDECIDED || !isfinite(w.value) || reads_otherwise(text.data)) {
            buffer_free(&text);
            continue;
        }
        expect_let(&b, text.data, &w);
        taken += w.sort != WRONG;
        refused += w.sort == WRONG;
        if (w.sort != WRONG && w.has_unit) {
            expect_set(&b, "y0", text.data, &w, has_powers(&w, 1, 0, 0));
            expect_set(&b, "v0", text.data, &w, has_powers(&w, 1, 0, -1));
            if (w.value > 0)
                expect_set(&b, "k", text.data, &w, has_powers(&w, 0, 1, -2));
        }
        if (w.sort == KNOWN && has_powers(&w, 0, 0, 1) && w.has_unit && w.value > 0.02 &&
            w.value < 0.98 && events < rounds / 20) {
            expect_event(&b, text.data, &w);
            events++;
        }
        buffer_free(&text);
    }
    assert_true(taken > rounds / 5 && refused > rounds / 5 && events > 3);
    bench_close(&b);
}

TEST(test_uncertainties)
{
    struct bench b;
    bench_open(&b, false);
    for (int round = 0; round < 300; round++) {
        const double value = 100 + pick(100), spread = 1 + pick(9);
        const bool first = pick(2), second = pick(2) || !first;
        struct buffer line = {0};
        struct named_value m = {.value = NAN};
        buffer_format(&line, "m = %g%s +- %g%s", value, first ? " g" : "", spread,
                      second ? " g" : "");
        type_ok(&b, line.data);
        assert_true(names_value(b.session, TEXT("m"), &m));
        if (!is_near(m.value, value / 1000) || !is_near(m.uncertainty, spread / 1000))
            fail_msg("'%s' gives %g +- %g", line.data, m.value, m.uncertainty);
        buffer_clear(&line);
        buffer_format(&line, "m = 0.1 kg; m = m + %g g +- %g", value, spread);
        assert_false(type(&b, line.data));
        buffer_put(&line, TEXT(" g"));
        type_ok(&b, line.data);
        assert_true(names_value(b.session, TEXT("m"), &m));
        if (!is_near(m.value, 0.1 + value / 1000) || !is_near(m.uncertainty, spread / 1000))
            fail_msg("'%s' gives %g +- %g", line.data, m.value, m.uncertainty);
        buffer_free(&line);
    }
    bench_close(&b);
}

/* Whatever is typed is a value that is said or an error that is said. */
TEST(test_token_soup)
{
    static const char *const token[] = {
        "5", "0.25", "cm",  " m", "kg",  "1/s", "N/m", "s",   "*",     "/",  "^",   "+",
        " ", "-",    "(",   ")",  "y0",  "m",   "pi",  "deg", "sqrt(", ",",  "T0",  "max(",
        "<", "+-",   "foo", "'",  "m/s", "if(", "Hz",  "2",   "(1)",   "e3", "rad", "y0 + 1 cm"};
    struct bench b;
    bench_open(&b, false);
    for (int round = 0; round < (is_long() ? 200000 : 10000); round++) {
        struct buffer line = {0};
        const int tokens = 1 + pick(9), kind = pick(4);
        buffer_put(&line, text_of((const char *[]){"print ",
                                                   "let q1 = ", "y0 = ", "event b when "}[kind]));
        for (int i = 0; i < tokens; i++)
            buffer_put(&line, text_of(token[pick((int)COUNT_OF(token))]));
        if (kind == 3)
            buffer_put(&line, TEXT(" do record"));
        const bool done = type(&b, line.data);
        if (done ? b.out.len == 0 : b.err.len == 0)
            fail_msg("'%s' %s without a word", line.data, done ? "is taken" : "fails");
        buffer_free(&line);
    }
    bench_close(&b);
}

/* A recording whose unit is unknown is adopted and compared as one that has none: what both say. */
static void adopt_with(const char *header, double omega, double amplitude, double noise,
                       double *start, double *rms)
{
    struct bench b;
    FILE *file = fopen("rec.csv", "w");
    assert_non_null(file);
    fprintf(file, "t (s),%s\n", header);
    random_state = 5;
    for (int i = 0; i < 400; i++)
        fprintf(file, "%.2f,%.9g\n", 0.02 * i,
                amplitude * (3 + cos(omega * 0.02 * i) + noise * random_normal()));
    assert_int_equal(fclose(file), 0);
    bench_open(&b, false);
    type_ok(&b, "m = 200 g; load rec.csv; fit damped");
    type_ok(&b, "adopt");
    assert_says(&b.err, "its numbers were taken as metres");
    *start = let_value(&b, "y0");
    type_ok(&b, "method exact; run 7 s");
    assert_says(&b.out, "compared with the run as if in m");
    const struct run *run = session_run(b.session);
    *rms = run_data_distance(run, b.session->recording[0]->recording).rms;
    bench_close(&b);
}

TEST(test_unknown_units)
{
    static const char *const unit[] = {"y (au)", "y (lux)", "y (counts)", "y (hPa)"};
    enter_folder(NULL);
    for (int round = 0; round < 12; round++) {
        const double omega = 4 + round, amplitude = pow(10, round % 5 - 2), noise = 0.01;
        double start[2], rms[2];
        adopt_with("y", omega, amplitude, noise, &start[0], &rms[0]);
        adopt_with(unit[round % 4], omega, amplitude, noise, &start[1], &rms[1]);
        assert_true(start[0] == start[1] && rms[0] == rms[1]);
        assert_true(fabs(start[0] / amplitude - 1) < 0.02);
        assert_true(rms[0] > 0.5 * noise * amplitude && rms[0] < 2 * noise * amplitude);
    }
    leave_folder(NULL);
}

RUN_TESTS(NULL, NULL)
