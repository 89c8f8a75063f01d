/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Potentials that are formulas: of random forces against a quadrature of the force, to 1e-12. */
#include "cmocka_testing.h"
#include <hooke/scene.h>
#include <hooke/scene/typed.h>

#include "long_form.h"
#include "unit/scene/typing.h"

#include <math.h>
#include <stdlib.h>

#define PANELS 96
#define NODES 5
#define COORDINATES 3

static double between(double low, double high)
{
    return low + (high - low) * rand() / RAND_MAX;
}

/* Gauss and Legendre, ten points a panel (Abramowitz, Stegun 1964, table 25.4). The force along the
 * straight line from a to b; *size: of its magnitude. */
static double work(const struct system *system, const double *a, const double *b, double *size)
{
    static const double node[NODES] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244,
                                       0.8650633666889845, 0.9739065285171717},
                        weight[NODES] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820,
                                         0.1494513491505806, 0.0666713443086881};
    const int rows = system->n / 2;
    double sum = 0;
    *size = 0;
    for (int k = 0; k < PANELS; k++)
        for (int j = 0; j < 2 * NODES; j++) {
            const double s = (k + 0.5 + (j % 2 ? 0.5 : -0.5) * node[j / 2]) / PANELS;
            double y[LIMIT_VARIABLES] = {0}, force[LIMIT_VARIABLES], along = 0;
            for (int i = 0; i < rows; i++)
                y[i] = a[i] + s * (b[i] - a[i]);
            system_acceleration(system, 0, y, force);
            for (int i = 0; i < rows; i++)
                along += system->mass * (system->ratio[i] > 0 ? system->ratio[i] : 1) * force[i] *
                         (b[i] - a[i]);
            sum += along * weight[j / 2] / 2 / PANELS;
            *size += fabs(along) * weight[j / 2] / 2 / PANELS;
        }
    return sum;
}

/* Whether the potential of these lines is a formula, and minus the work of the force. */
static void check_lines(const char *const *lines, double low, double high)
{
    struct error error = {.code = ERROR_NONE};
    struct typed_models *models = typed_create(&error);
    struct scene scene;
    struct system *system = malloc(sizeof *system);
    assert_true(models && system);
    scene_init(&scene, NULL);
    scene_remodel(&scene, typed_new(models, TEXT(""), &error));
    assert_true(type_scene(models, &scene, lines));
    if (!scene_bind(&scene, system, &error))
        fail_msg("%s", error.text);
    bool fine = system->energy && !typed_potential_is_integrated(system);
    for (int pair = 0; pair < 4 && fine; pair++) {
        double a[LIMIT_VARIABLES] = {0}, b[LIMIT_VARIABLES] = {0}, size;
        for (int i = 0; i < system->n / 2; i++) {
            a[i] = between(low, high);
            b[i] = between(low, high);
        }
        const double fall = system_potential(system, a) - system_potential(system, b),
                     wanted = work(system, a, b, &size),
                     rounding = fabs(system_potential(system, a)) +
                                fabs(system_potential(system, b)) + size;
        fine = fabs(fall - wanted) <= 1e-12 * rounding;
    }
    for (int i = 0; lines[i] && !fine; i++)
        print_error("%s\n", lines[i]);
    assert_true(fine);
    free(system);
    typed_destroy(models);
}

/* One summand of a force along x; the last four of `kinds` are not defined for all x. */
#define KINDS 22
static int put_term(char *out, size_t size, const char *x, int kinds)
{
    const double k = between(-3, 3), a = between(0.5, 2) * (rand() % 2 ? 1 : -1),
                 b = between(-1, 1), c = between(0.5, 2);
    const int n = 2 + rand() % 6;
    switch (rand() % kinds) {
    case 0:
        return snprintf(out, size, "%+.3f*%s^%d", k, x, n);
    case 1:
        return snprintf(out, size, "%+.3f*sin(%.3f*%s%+.3f)", k, a, x, b);
    case 2:
        return snprintf(out, size, "%+.3f*cos(%s/%.3f%+.3f)", k, x, a, b);
    case 3:
        return snprintf(out, size, "%+.3f*exp(%.3f*%s)", k, a, x);
    case 4:
        return snprintf(out, size, "%+.3f*%s/(1+%s^2)", k, x, x);
    case 5:
        return snprintf(out, size, "%+.3f*%s/sqrt(%.3f+%s*%s)", k, x, c, x, x);
    case 6:
        return snprintf(out, size, "%+.3f*%s*exp(-%.3f*%s^2)", k, x, c, x);
    case 7:
        return snprintf(out, size, "%+.3f*(%s%+.3f)^2*%s", k, x, b, x);
    case 8:
        return snprintf(out, size, "%+.3f*(%s^2-1)*(%s-%.3f)", k, x, x, b);
    case 9:
        return snprintf(out, size, "%+.3f*tanh(%.3f*%s)", k, a, x);
    case 10:
        return snprintf(out, size, "%+.3f*%s*(%.3f - %.3f*%s^2)", k, x, a, b, x);
    case 11:
        return snprintf(out, size, "-p*%s+q*%s^3", x, x);
    case 12:
        return snprintf(out, size, "+p*sin(q*%s)*cos(q*%s)", x, x);
    case 13:
        return snprintf(out, size, "%+.3f*sinh(%s)-%.3f*cosh(%.3f*%s)", k, x, c, a, x);
    case 14:
        return snprintf(out, size, "+(%s%+.3f)^3/p", x, b);
    case 15:
        return snprintf(out, size, "%+.3f*(1-exp(-%.3f*%s))*exp(-%.3f*%s)", k, c, x, c, x);
    case 16:
        return snprintf(out, size, "%+.3f*atan(%.3f*%s)", k, a, x);
    case 17:
        return snprintf(out, size, "%+.3f*sin(%s)*cos(%s)^%d", k, x, x, n);
    case 18:
        return snprintf(out, size, "%+.3f/(%s+3)^%d", k, x, n);
    case 19:
        return snprintf(out, size, "%+.3f/(%s+3)", k, x);
    case 20:
        return snprintf(out, size, "-p*(%s+3)^q", x);
    default:
        return snprintf(out, size, "%+.3f*log(%s+3)", k, x);
    }
}

static void put_terms(char *out, size_t size, const char *x, int kinds)
{
    size_t length = 0;
    for (int terms = 1 + rand() % 3; terms > 0; terms--)
        length += (size_t)put_term(out + length, size - length, x, kinds);
}

static int cases(int quick)
{
    return is_long() ? 20 * quick : quick;
}

TEST(a_force_along_one_coordinate_has_a_formula)
{
    srand(1);
    for (int i = cases(400); i > 0; i--) {
        char line[1000] = "x'' = ";
        put_terms(line + 6, sizeof line - 6, "x", KINDS);
        const char *const lines[] = {
            "param p = 1.7", "param q = 0.6", "param m = 0.3", "var x = 0.8", line, NULL};
        check_lines(lines, -1.5, 1.5);
    }
}

TEST(springs_between_masses_have_a_formula)
{
    srand(2);
    for (int i = cases(100); i > 0; i--) {
        char spring[2][300], own[3][400], line[3][1200];
        for (int k = 0; k < 2; k++)
            snprintf(spring[k], sizeof spring[k],
                     rand() % 2 ? "%.3f*%s+%.3f*%s^3" : "%.3f*%s+sin(%.3f*%s)", between(1, 3),
                     k ? "(y-z)" : "(x-y)", between(0.5, 2), k ? "(y-z)" : "(x-y)");
        for (int k = 0; k < COORDINATES; k++)
            put_terms(own[k], sizeof own[k], k == 0 ? "x" : k == 1 ? "y" : "z", KINDS - 4);
        const double mass = rand() % 2 ? 1 : between(0.5, 4);
        snprintf(line[0], sizeof line[0], "x'' = %s-(%s)", own[0], spring[0]);
        snprintf(line[1], sizeof line[1], "y'' = (%s+%s-(%s))/%.3f", own[1], spring[0], spring[1],
                 mass);
        snprintf(line[2], sizeof line[2], "z'' = %s+%s", own[2], spring[1]);
        const char *const lines[] = {"param p = 1.7", "param q = 0.6", "var x = 0.5",
                                     "var y = 0.3",   "var z = -0.2",  line[0],
                                     line[1],         line[2],         NULL};
        check_lines(lines, -1, 1);
    }
}

/* Powers of the distance, also where that of the origin is a pole, and other forces beside them. */
TEST(a_force_towards_a_point_has_a_formula)
{
    srand(3);
    for (int i = cases(60); i > 0; i--) {
        char line[3][600];
        const double k = between(0.5, 3), n = rand() % 2 ? 1 + rand() % 5 : between(1, 5),
                     c = rand() % 2 ? 0 : between(0.1, 1), own = rand() % 2 ? 0 : between(0.2, 1);
        const bool root = rand() % 2;
        for (int j = 0; j < COORDINATES; j++)
            snprintf(line[j], sizeof line[j],
                     root ? "%c'' = -%.3f*%c/sqrt(x^2+y^2+z^2+%.3f)^%.4g-%.3f*%c"
                          : "%c'' = -%.3f*%c/(x^2+y^2+z^2+%.3f)^%.4g-%.3f*%c",
                     'x' + j, k, 'x' + j, c, n, own, 'x' + j);
        const char *const lines[] = {"var x = 1", "var y = 0.4", "var z = 0.3", "var y' = 1",
                                     line[0],     line[1],       line[2],       NULL};
        check_lines(lines, 0.4, 1.5);
    }
}

/* What has no formula keeps its quadrature; a force that is no gradient has no potential. */
TEST(what_is_not_found_is_integrated_along_a_path)
{
    static const char *const force[] = {
        "x'' = -x*sin(x)",  "x'' = -sin(x^2)",        "x'' = if(x > 0.2, -x, -4*x)",
        "x'' = -exp(-x^2)", "x'' = -mod(x, 0.3) - x", "x'' = -(x + floor(x))^3"};
    struct error error = {.code = ERROR_NONE};
    for (size_t i = 0; i < COUNT_OF(force); i++) {
        struct typed_models *models = typed_create(&error);
        struct scene scene;
        struct system *system = malloc(sizeof *system);
        const char *const lines[] = {"var x = 1", force[i], NULL};
        assert_true(models && system);
        scene_init(&scene, NULL);
        scene_remodel(&scene, typed_new(models, TEXT(""), &error));
        assert_true(type_scene(models, &scene, lines) && scene_bind(&scene, system, &error));
        assert_true(system->energy && typed_potential_is_integrated(system));
        free(system);
        typed_destroy(models);
    }
}

RUN_TESTS(NULL, NULL)
