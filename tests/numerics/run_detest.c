/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The test problems of Hull, Enright, Fellen, Sedgwick 1972 (classes A, B, C) and the Arenstorf orbit, as models made
 * here: what a run gives for systems that hooke does not know, of up to ten variables, against references.csv.
 */
#include "numerics/references.h"

#define SYSTEM(name) static void name(const double *c, double t, const double *y, double *f)
#define UNUSED_ARGUMENTS (void)c, (void)t

SYSTEM(a1)
{
    UNUSED_ARGUMENTS;
    f[0] += -y[0];
}
SYSTEM(a2)
{
    UNUSED_ARGUMENTS;
    f[0] += -y[0] * y[0] * y[0] / 2;
}
SYSTEM(a3)
{
    UNUSED_ARGUMENTS;
    f[0] += y[0] * cos(t);
}
SYSTEM(a4)
{
    UNUSED_ARGUMENTS;
    f[0] += y[0] * (1 - y[0] / 20) / 4;
}
SYSTEM(a5)
{
    UNUSED_ARGUMENTS;
    f[0] += (y[0] - t) / (y[0] + t);
}

SYSTEM(b1)
{
    UNUSED_ARGUMENTS;
    f[0] += 2 * (y[0] - y[0] * y[1]);
    f[1] += -(y[1] - y[0] * y[1]);
}
SYSTEM(b2)
{
    UNUSED_ARGUMENTS;
    f[0] += -y[0] + y[1];
    f[1] += y[0] - 2 * y[1] + y[2];
    f[2] += y[1] - y[2];
}
SYSTEM(b3)
{
    UNUSED_ARGUMENTS;
    f[0] += -y[0];
    f[1] += y[0] - y[1] * y[1];
    f[2] += y[1] * y[1];
}
SYSTEM(b4)
{
    UNUSED_ARGUMENTS;
    double r = hypot(y[0], y[1]);
    f[0] += -y[1] - y[0] * y[2] / r;
    f[1] += y[0] - y[1] * y[2] / r;
    f[2] += y[0] / r;
}
SYSTEM(b5)
{
    UNUSED_ARGUMENTS;
    f[0] += y[1] * y[2];
    f[1] += -y[0] * y[2];
    f[2] += -0.51 * y[0] * y[1];
}

SYSTEM(c1)
{
    UNUSED_ARGUMENTS;
    for (int i = 0; i < 10; i++)
        f[i] += (i > 0 ? y[i - 1] : 0) - (i < 9 ? y[i] : 0);
}
SYSTEM(c2)
{
    UNUSED_ARGUMENTS;
    for (int i = 0; i < 10; i++)
        f[i] += (i > 0 ? i * y[i - 1] : 0) - (i < 9 ? (i + 1) * y[i] : 0);
}
SYSTEM(c3)
{
    UNUSED_ARGUMENTS;
    for (int i = 0; i < 10; i++)
        f[i] += (i > 0 ? y[i - 1] : 0) - 2 * y[i] + (i < 9 ? y[i + 1] : 0);
}

/* Restricted three bodies in the rotating frame; (x, y, x', y'), so of second order. */
SYSTEM(arenstorf)
{
    UNUSED_ARGUMENTS;
    const double mu = 0.012277471, rest = 1 - mu;
    double d1 = pow(hypot(y[0] + mu, y[1]), 3), d2 = pow(hypot(y[0] - rest, y[1]), 3);
    f[0] += y[0] + 2 * y[3] - rest * (y[0] + mu) / d1 - mu * (y[0] - rest) / d2;
    f[1] += y[1] - 2 * y[2] - rest * y[1] / d1 - mu * y[1] / d2;
}

#define SMOOTH(bound)                                                                                                  \
    {                                                                                                                  \
        {"dop853", 1e-14, bound}, {"gauss6", 0.01, bound}, {"odex", 1e-14, bound},                                     \
        {                                                                                                              \
            "cvode-adams", 1e-13, 1000 * (bound)                                                                       \
        }                                                                                                              \
    }
#define CLOSE(bound)                                                                                                   \
    {                                                                                                                  \
        {"dop853", 1e-14, bound}, {"odex", 1e-14, bound}, {"radau5", 1e-14, bound},                                    \
        {                                                                                                              \
            "cvode-adams", 1e-13, 1000 * (bound)                                                                       \
        }                                                                                                              \
    }

/* Errors are absolute where a solution is below 1: A1, B3 and C2 decay. */
static const struct problem {
    const char *name;
    void (*f)(const double *c, double t, const double *y, double *f);
    int order, n;
    double start[10];
    struct attempt by[5];
} problems[] = {
    {"DETEST-A1", a1, 1, 1, {1}, SMOOTH(1e-13)},
    {"DETEST-A2", a2, 1, 1, {1}, SMOOTH(1e-13)},
    {"DETEST-A3", a3, 1, 1, {1}, SMOOTH(2e-13)},
    {"DETEST-A4", a4, 1, 1, {1}, SMOOTH(1e-13)},
    {"DETEST-A5", a5, 1, 1, {4}, SMOOTH(2e-13)},
    {"DETEST-B1", b1, 1, 2, {1, 3}, SMOOTH(1e-12)},
    {"DETEST-B2", b2, 1, 3, {2, 0, 1}, SMOOTH(1e-13)},
    {"DETEST-B3", b3, 1, 3, {1, 0, 0}, SMOOTH(1e-13)},
    {"DETEST-B4", b4, 1, 3, {3, 0, 0}, SMOOTH(8e-13)},
    {"DETEST-B5", b5, 1, 3, {0, 1, 1}, SMOOTH(1e-13)},
    {"DETEST-C1", c1, 1, 10, {1}, SMOOTH(1e-13)},
    {"DETEST-C2", c2, 1, 10, {1}, SMOOTH(1e-13)},
    {"DETEST-C3", c3, 1, 10, {1}, SMOOTH(1e-13)},
    /* Close encounters with the moon magnify every error, three of them by 1e6 together; till t = 10 there is one. */
    {"arenstorf", arenstorf, 2, 4, {0.994, 0, 0, -2.00158510637908252}, CLOSE(2e-9)},
    {"arenstorf_t10", arenstorf, 2, 4, {0.994, 0, 0, -2.00158510637908252}, CLOSE(4e-12)},
};

static const struct problem *current; /* what the model below is */

/* By central differences: methods iterate with it, so that it decides how fast they get there, not where. */
static void jacobian(const double *c, double t, const double *y, double *jac)
{
    const int n = current->n, rows = current->order == 2 ? n / 2 : n;
    for (int j = 0; j < n; j++) {
        double at[2][10], f[2][10] = {{0}}, away = 1e-6 * fmax(1, fabs(y[j]));
        for (int side = 0; side < 2; side++) {
            memcpy(at[side], y, (size_t)n * sizeof *y);
            at[side][j] += side ? away : -away;
            current->f(c, t, at[side], f[side]);
        }
        for (int i = 0; i < rows; i++)
            jac[i * n + j] += (f[1][i] - f[0][i]) / (at[1][j] - at[0][j]);
    }
}

static bool bind(const double *param, double *c, struct oscillator *oscillator)
{
    (void)param, (void)c;
    oscillator->drag_whole = false;
    return true;
}

static void begin(const double *param, struct system *system)
{
    (void)param;
    system->mass = 1;
    for (int i = 0; i < system->n; i++) {
        system->start[i] = current->start[i];
        system->scale[i] = 1;
    }
}

static void test_references_are_reached(void **state)
{
    (void)state;
    size_t count = 0;
    int wrong = 0;
    struct reference *table = read_table(&count);
    if (!table) {
        print_message("no references.csv beside HOOKE_DATA: nothing to compare with\n");
        skip();
    }
    struct variable variable[10] = {{"y1", QUANTITY_NUMBER}};
    for (int i = 0; i < 10; i++) {
        variable[i] = variable[0];
        snprintf(variable[i].name, sizeof variable[i].name, "y%d", i + 1);
    }
    for (size_t i = 0; i < COUNT_OF(problems); i++) {
        const struct problem *p = current = &problems[i];
        const struct term_row term = {.row = {p->name, "", "", "", NULL},
                                      .flags = TERM_VELOCITY | TERM_TIME,
                                      .bind = bind,
                                      .add = p->f,
                                      .jacobian = jacobian};
        const struct catalog terms = {"term", &term, 1, sizeof term, NULL, 0},
                             none = {"parameter", NULL, 0, 1, NULL, 0};
        const struct model model = {.row = {p->name, "", "", "", NULL},
                                    .order = p->order,
                                    .n = p->n,
                                    .variable = variable,
                                    .params = &none,
                                    .terms = &terms,
                                    .derived = &none,
                                    .begin = begin};
        const struct preset preset = {.row = {p->name, "", "", "", NULL}, .model = &model};
        struct scene scene;
        scene_init(&scene, &preset);
        for (size_t k = 0; k < COUNT_OF(p->by) && p->by[k].method; k++) {
            const struct attempt *by = &p->by[k];
            if (!is_there(by))
                continue;
            struct run *run = start(&scene, by->method, settings_of(by), HUGE_VAL);
            double worst = -1;
            for (size_t row = 0; row < count; row++) {
                if (!text_is(text_of(p->name), table[row].problem))
                    continue;
                go_to(run, table[row].t);
                assert_int_equal(run->stop, STOP_END);
                int at = place_of(&table[row]);
                assert_true(at < p->n);
                worst = fmax(worst, fabs(run->y[at] - table[row].value) / fmax(1, fabs(table[row].value)));
                table[row].reached |= family_of(run->method);
            }
            const bool good = worst >= 0 && worst <= by->error;
            if (!good || getenv("VERBOSE"))
                print_message("%-14s %-12s %6.0e  %.1e (%.0e)%s\n", p->name, by->method, by->by, worst, by->error,
                              good ? "" : ": wrong");
            wrong += !good;
            run_destroy(run);
        }
    }
    assert_int_equal(wrong, 0);
    assert_all_reached(table, count, true);
    free(table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_references_are_reached),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
