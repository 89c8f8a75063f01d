/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every force term against what its row claims: the force is the slope of the potential, its
 * text the same to the bit, the Jacobian is the slope of the acceleration, the flags say what it
 * depends on. The checks see rows, not terms, so a new row is tested as soon as it exists; broken
 * rows at the end show that each check can fail.
 */
#include <hooke/base/catalog.h>
#include "unit/scene/testing.h"

#include "scene/model/forces.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct sample {
    const struct term_row *row;
    double param[PARAM_MAX], mass, c[TERM_COEFFICIENTS], t, y[2];
};

static double acceleration(const struct sample *s, double t, double y, double v)
{
    double state[2] = {y, v}, a[1] = {0};
    s->row->add(s->c, t, state, a);
    return a[0];
}

static bool close_to(double a, double b, double size)
{
    return fabs(a - b) <= 1e-6 * size;
}

enum { STEP = 16384 }; /* 1/STEP: step of the central differences */

static bool check_potential(const struct sample *s)
{
    if (!s->row->potential)
        return term_has_power(s->row);
    if (!(s->row->flags & TERM_CONSERVATIVE))
        return false;
    double h = 1.0 / STEP, up[2] = {s->y[0] + h, s->y[1]}, down[2] = {s->y[0] - h, s->y[1]};
    double force = -(s->row->potential(s->c, up) - s->row->potential(s->c, down)) / (2 * h);
    double wanted = s->mass * acceleration(s, s->t, s->y[0], s->y[1]);
    return close_to(force, wanted, 1 + fabs(wanted)) && fabs(wanted) > 1e-3;
}

/* Outputs of the program of a term's text or of its derivatives. */
static bool evaluate_text(const struct sample *s, const struct system *system, bool slopes,
                          double *out)
{
    double input[3 + TERM_COEFFICIENTS] = {s->t, s->y[0], s->y[1]}, *frame;
    struct error error;
    struct program *program = terms_program(system, 0, 0, 3, slopes, &error);
    if (!program || !(frame = malloc(program_frame(program) * sizeof *frame)))
        return false;
    memcpy(input + 3, s->c, sizeof s->c);
    program_prepare(program, frame);
    program_eval(program, input, out, frame);
    free(frame);
    program_destroy(program);
    return true;
}

/* The text of a force gives the bits of the force and, derived, of its slopes. */
static bool check_text(const struct sample *s)
{
    static struct system system;
    double force, slopes[2], a = -0.0, jac[2] = {0, 0};
    if (!s->row->text)
        return s->row->flags & TERM_DRY;
    system = (struct system){.n = 2, .order = 2, .terms = 1, .term = {{.row = s->row}}};
    s->row->add(s->c, s->t, s->y, &a);
    s->row->jacobian(s->c, s->t, s->y, jac);
    return evaluate_text(s, &system, false, &force) && evaluate_text(s, &system, true, slopes) &&
           force == a && slopes[0] == jac[0] && slopes[1] == jac[1];
}

static bool check_jacobian(const struct sample *s)
{
    double jac[2] = {0, 0}, h = 1.0 / STEP, t = s->t, y = s->y[0], v = s->y[1];
    if (s->row->jacobian)
        s->row->jacobian(s->c, t, s->y, jac);
    double by_y = (acceleration(s, t, y + h, v) - acceleration(s, t, y - h, v)) / (2 * h);
    double by_v = (acceleration(s, t, y, v + h) - acceleration(s, t, y, v - h)) / (2 * h);
    double size = 1 + fabs(by_y) + fabs(by_v) + fabs(acceleration(s, t, y, v));
    return close_to(jac[0], by_y, size) && close_to(jac[1], by_v, size);
}

static bool check_flags(const struct sample *s)
{
    double t = s->t, y = s->y[0], v = s->y[1], here = acceleration(s, t, y, v);
    bool velocity = acceleration(s, t, y, v + 1) != here || acceleration(s, t, y, -v) != here,
         time = acceleration(s, t + 1, y, v) != here;
    /* Linear or constant: a(x) - a(0) is odd and doubles with x. */
    double zero = acceleration(s, t, 0, 0), once = here - zero,
           twice = acceleration(s, t, 2 * y, 2 * v) - zero;
    double back = acceleration(s, t, -y, -v) - zero;
    bool linear = close_to(twice, 2 * once, fabs(twice) + fabs(zero)) &&
                  close_to(back, -once, fabs(once) + fabs(zero));
    unsigned flags = s->row->flags;
    return velocity == !!(flags & TERM_VELOCITY) && time == !!(flags & TERM_TIME) &&
           linear == !!(flags & TERM_LINEAR);
}

/* What the term adds to the oscillator is the same force. */
static bool check_oscillator(const struct sample *s)
{
    struct oscillator o = {.whole = true, .drag_whole = true};
    double c[TERM_COEFFICIENTS];
    s->row->bind(s->param, c, &o);
    double y = s->y[0], v = s->y[1];
    if (o.whole && !o.drag_whole)
        return false;
    if (!o.whole) { /* then at least the drag is all there, or it says that it is not */
        double still = acceleration(s, s->t, y, 0), drag = acceleration(s, s->t, y, v) - still;
        return !o.drag_whole ||
               close_to(drag, -o.damping * v - o.quadratic * fabs(v) * v - copysign(o.friction, v),
                        fabs(still) + fabs(drag));
    }
    double a = -o.stiffness * y - o.damping * v - o.quadratic * fabs(v) * v -
               copysign(o.friction, v) - o.gravity + o.drive * cos(o.omega * s->t + o.phase);
    double wanted = acceleration(s, s->t, y, v);
    return fabs(a - wanted) <= 1e-14 * fabs(wanted);
}

static bool check_absent(const struct sample *s)
{
    /* With every parameter at 0 but the mass, no term is there, and what is not there adds nothing.
     */
    double param[PARAM_MAX] = {0}, c[TERM_COEFFICIENTS] = {0};
    struct oscillator o = {.whole = true};
    param[param_index("m")] = s->mass;
    param[param_index("width")] = 1; /* cannot be 0 either */
    struct sample none = *s;
    if (s->row->bind(param, c, &o))
        return false;
    memcpy(none.c, c, sizeof c);
    return acceleration(&none, s->t, s->y[0], s->y[1]) == 0;
}

static bool (*const checks[])(const struct sample *) = {
    check_potential, check_text, check_jacobian, check_flags, check_oscillator, check_absent};

/* Random parameters within their ranges, random state. */
static struct sample random_sample(const struct term_row *row, uint64_t *seed)
{
    struct sample s = {.row = row};
    for (size_t i = 0; i < param_catalog.count; i++) {
        const struct param_row *param = (const struct param_row *)catalog_row(&param_catalog, i);
        s.param[i] =
            random_between(seed, 0.2, 3) * (param->min < 0 && random_unit(seed) < 0.5 ? -1 : 1);
    }
    s.mass = s.param[param_index("m")];
    struct oscillator unused = {0};
    assert_true(row->bind(s.param, s.c, &unused));
    s.t = random_between(seed, 0, 10);
    s.y[0] = random_between(seed, 0.2, 2) * (random_unit(seed) < 0.5 ? -1 : 1);
    s.y[1] = random_between(seed, 0.2, 2) * (random_unit(seed) < 0.5 ? -1 : 1);
    return s;
}

static bool check_row(const struct term_row *row, size_t check)
{
    uint64_t seed = 7;
    for (int i = 0; i < 200; i++) {
        struct sample s = random_sample(row, &seed);
        if (!checks[check](&s))
            return false;
    }
    return true;
}

/* Every force term passes all checks above with random parameters and states. */
TEST(test_rows_keep_their_claims)
{
    assert_true(term_catalog.count >= 5);
    for (size_t i = 0; i < term_catalog.count; i++) {
        const struct term_row *row = (const struct term_row *)catalog_row(&term_catalog, i);
        assert_true(row->row.name[0] && row->row.brief[0]);
        for (size_t check = 0; check < COUNT_OF(checks); check++)
            if (!check_row(row, check))
                fail_msg("term %s fails check %zu", row->row.name, check);
    }
}

/* ---- rows that are wrong on purpose: each is caught by its check ---- */

static const struct term_row *term_named(const char *name)
{
    return (const struct term_row *)catalog_find(&term_catalog, text_of(name));
}

static double wrong_potential(const double *c, const double *y)
{
    return -term_named("spring")->potential(c, y);
}

static void wrong_jacobian(const double *c, double t, const double *y, double *jac)
{
    double once[2] = {0, 0};
    term_named("drag")->jacobian(c, t, y, once);
    jac[0] += once[0];
    jac[1] += once[1] / 2; /* the factor 2 of d(|v|v)/dv forgotten */
}

static bool wrong_bind(const double *param, double *c, struct oscillator *o)
{
    bool there = term_named("spring")->bind(param, c, o);
    o->stiffness *= param[param_index("m")]; /* k instead of k/m */
    return there;
}

static bool drag_forgotten(const double *param, double *c, struct oscillator *o)
{
    bool there = term_named("vanderpol")->bind(param, c, o);
    o->drag_whole = true;
    return there;
}

static bool always_there(const double *param, double *c, struct oscillator *o)
{
    (void)term_named("gravity")->bind(param, c, o);
    return true;
}

TEST(test_wrong_rows_are_caught)
{
    struct term_row row = *term_named("spring");
    row.potential = wrong_potential;
    assert_false(check_row(&row, 0));
    row = *term_named("spring");
    row.potential = NULL;
    assert_false(check_row(&row, 0));
    row = *term_named("damping");
    row.text = "-c0 * q";
    assert_false(check_row(&row, 1));
    row = *term_named("drag");
    row.jacobian = wrong_jacobian;
    assert_false(check_row(&row, 2));
    static const unsigned flags[] = {TERM_LINEAR, TERM_VELOCITY, TERM_TIME};
    for (size_t i = 0; i < term_catalog.count; i++)
        for (size_t j = 0; j < COUNT_OF(flags); j++) {
            row = *(const struct term_row *)catalog_row(&term_catalog, i);
            row.flags ^= flags[j];
            assert_false(check_row(&row, 3));
        }
    row = *term_named("spring");
    row.bind = wrong_bind;
    assert_false(check_row(&row, 4));
    row = *term_named("vanderpol");
    row.bind = drag_forgotten;
    assert_false(check_row(&row, 4));
    row = *term_named("gravity");
    row.bind = always_there;
    assert_false(check_row(&row, 5));
}

RUN_TESTS(NULL, NULL)
