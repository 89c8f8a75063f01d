/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * fit through the command: the NIST data sets typed as formulas, the lab's recordings by the
 * scene's equation, what stays in the session. HOOKE_NIST and HOOKE_DATA say where the files are.
 */
#include "cmocka_testing.h"

#include "modules/recording/fits.h"
#include "unit/command/testing.h"

static char home[4096]; /* where the test was started: relative folders count from there */

static bool find_file(const char *variable, const char *usual, const char *name, char *path,
                      size_t size)
{
    const char *folder = getenv(variable);
    folder = folder && *folder ? folder : usual;
    snprintf(path, size, "%s%s%s/%s", *folder == '/' ? "" : home, *folder == '/' ? "" : "/", folder,
             name);
    if (access(path, R_OK) == 0)
        return true;
    print_message("skipped: there is no %s (%s says where)\n", path, variable);
    return false;
}

static double value_named(const struct bench *bench, const char *name)
{
    for (int i = 0; i < bench->session->results.count; i++)
        if (strcmp(bench->session->results.value[i].name, name) == 0)
            return bench->session->results.value[i].value;
    fail_msg("there is no %s", name);
    return NAN;
}

/* ---- NIST StRD ---- */

enum { NIST_PARAMETERS = 41, NIST_DATA = 61, NIST_MAX = 9 };

static const struct {
    const char *name, *formula;
} sets[] = {
    {"Misra1a", "b1*(1-exp(-b2*t))"},
    {"DanWood", "b1*t^b2"},
    {"Eckerle4", "b1/b2*exp(-0.5*((t-b3)/b2)^2)"},
    {"Rat42", "b1/(1+exp(b2-b3*t))"},
    {"MGH17", "b1+b2*exp(-t*b4)+b3*exp(-t*b5)"},
    {"Thurber", "(b1+b2*t+b3*t^2+b4*t^3)/(1+b5*t+b6*t^2+b7*t^3)"},
};

struct nist {
    double start[2][NIST_MAX], certified[NIST_MAX], deviation[NIST_MAX];
    int parameters;
};

/* Writes the observations as a recording; rows in rising order of t. */
static bool read_nist(const char *name, struct nist *set)
{
    char path[8192], file[64], line[512];
    double t[300], y[300];
    int n = 0;
    snprintf(file, sizeof file, "%s.dat", name);
    if (!find_file("HOOKE_NIST", "../shared/nist", file, path, sizeof path))
        return false;
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    *set = (struct nist){.parameters = 0};
    for (int i = 1; fgets(line, sizeof line, in); i++) {
        const char *equals = strchr(line, '=');
        double x[4];
        if (i >= NIST_PARAMETERS && i < NIST_DATA && equals &&
            sscanf(equals + 1, "%lf %lf %lf %lf", &x[0], &x[1], &x[2], &x[3]) == 4) {
            const int j = set->parameters++;
            set->start[0][j] = x[0];
            set->start[1][j] = x[1];
            set->certified[j] = x[2];
            set->deviation[j] = x[3];
        } else if (i >= NIST_DATA && sscanf(line, "%lf %lf", &x[0], &x[1]) == 2) {
            int at = n++;
            for (; at > 0 && t[at - 1] > x[1]; at--) {
                t[at] = t[at - 1];
                y[at] = y[at - 1];
            }
            t[at] = x[1];
            y[at] = x[0];
        }
    }
    fclose(in);
    snprintf(file, sizeof file, "%s.csv", name);
    FILE *out = fopen(file, "w");
    assert_non_null(out);
    fprintf(out, "t (s),y\n");
    for (int i = 0; i < n; i++)
        fprintf(out, "%.17g,%.17g\n", t[i], y[i]);
    assert_int_equal(fclose(out), 0);
    return true;
}

TEST(certified_values_are_found)
{
    for (size_t i = 0; i < COUNT_OF(sets); i++) {
        struct nist set = {.parameters = 0};
        if (!read_nist(sets[i].name, &set))
            skip();
        for (int from = 0; from < 2; from++) {
            struct bench bench;
            char line[1024];
            bench_open(&bench, false);
            snprintf(line, sizeof line, "load %s.csv", sets[i].name);
            type_ok(&bench, line);
            int at = snprintf(line, sizeof line, "fit %s", sets[i].formula);
            for (int j = 0; j < set.parameters; j++)
                at += snprintf(line + at, sizeof line - (size_t)at, " b%d=%.17g", j + 1,
                               set.start[from][j]);
            type_ok(&bench, line);
            for (int j = 0; j < set.parameters; j++) {
                snprintf(line, sizeof line, "fit_b%d", j + 1);
                const double value = value_named(&bench, line);
                if (!(fabs(value / set.certified[j] - 1) < 1e-6))
                    fail_msg("%s from start %d: %s = %.12g, certified %.12g", sets[i].name,
                             from + 1, line, value, set.certified[j]);
            }
            bench_close(&bench);
        }
    }
}

/* ---- the lab's recordings ---- */

static double fitted_k(const char *file, const char *before)
{
    char path[8192], line[9000];
    struct bench bench;
    if (!find_file("HOOKE_DATA", "../shared/data", file, path, sizeof path))
        return NAN;
    bench_open(&bench, false);
    snprintf(line, sizeof line, "%s; load '%s' as=one; fit scene", before, path);
    type_ok(&bench, line);
    const double k = value_named(&bench, "fit_k");
    /* What was fitted runs over the data: better than a third of a millimetre where there is no
     * disk. */
    assert_true(value_named(&bench, "fit_rms") < 2e-3);
    type_ok(&bench, "adopt; run 5");
    type_ok(&bench, "plot residual");
    assert_says(&bench.out, "data - fit");
    bench_close(&bench);
    return k;
}

TEST(one_spring_has_one_stiffness)
{
    const double bare = fitted_k("uoft-pandhi/position data.txt", "m = 199.9 +- 0.1 g");
    const double disk =
        fitted_k("uoft-pandhi/damped position.txt", "scene drag; m = 216.6 +- 0.1 g");
    if (isnan(bare) || isnan(disk))
        skip();
    print_message("k = %.4f N/m bare, %.4f N/m with the disk\n", bare, disk);
    assert_true(fabs(bare - 15.11) < 0.03);
    assert_true(fabs(disk - 15.09) < 0.03);
    assert_true(fabs(disk / bare - 1) < 0.015);
}

/* ---- what stays ---- */

TEST(scene_fits_are_adopted)
{
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "scene duffing; k3 = 0.8 +- 0.1; k = 1.1 +- 0.1; gamma = 0.05 +- 0.01; y0 = "
                    "1.3; method rk4 dt=10ms");
    type_ok(&bench, "run 40 s");
    type_ok(&bench, "export truth.csv t,y; load truth.csv as=truth");
    type_ok(&bench, "scene duffing; y0 = 1; fit scene");
    assert_says(&bench.out, "k3");
    assert_true(fabs(value_named(&bench, "fit_k3") - 0.8) < 1e-4);
    assert_true(fabs(value_named(&bench, "fit_gamma") - 0.05) < 1e-5);
    type_ok(&bench, "adopt");
    const struct scene *scene = &bench.session->setup.scene;
    assert_true(fabs(scene->value[scene_param(scene, "k3")] - 0.8) < 1e-4);
    assert_true(scene->chosen[scene_param(scene, "k3")]);
    assert_true(fabs(scene->value[scene_param(scene, "y0")] - 1.3) < 1e-4);
    type_ok(&bench, "undo; print k3");
    assert_says(&bench.out, "1 N/m^3");
    type_ok(&bench, "scene pendulum");
    assert_false(type(&bench, "adopt"));
    assert_says(&bench.err, "the fit belongs to duffing");
    bench_close(&bench);
}

TEST(records_hold_every_key)
{
    static const char *const keys[] = {
        "model",      "period",    "omega",    "gamma",    "amplitude", "phase",
        "offset",     "k",         "rms",      "used",     "rejected",  "window",
        "halves",     "preferred", "laws",     "delta",    "p_value",   "parameters",
        "correlated", "converged", "warnings", "remaining"};
    static const char *const fits[] = {"fit damped", "fit drag", "fit scene",
                                       "fit a*exp(-b*t)*cos(w*t+p)+c w=8.6"};
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "gamma = 0.2; run 20 s; m = 200 g; unset k; unset gamma; set format json");
    for (size_t f = 0; f < COUNT_OF(fits); f++) {
        type_ok(&bench, fits[f]);
        for (size_t i = 0; i < COUNT_OF(keys); i++) {
            char key[40];
            snprintf(key, sizeof key, "\"%s\":", keys[i]);
            assert_says(&bench.out, key);
        }
    }
    bench_close(&bench);
}

TEST(what_does_not_converge_says_so)
{
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "method rk4; gamma = 0.2; run 10 s");
    assert_false(type(&bench, "fit scene free=m,k,gamma,y0,v0"));
    assert_says(&bench.err, "the data cannot tell m and k apart");
    assert_says(&bench.err, "did not converge");
    assert_int_equal(bench.session->execution.status, ERROR_NUMERICAL);
    assert_false(fits_of(bench.session)->has_fit);
    bench_close(&bench);
}

struct offered {
    char all[4000];
};

static void take_offer(void *context, const char *candidate, const char *brief)
{
    struct offered *offered = context;
    (void)brief;
    const size_t len = strlen(offered->all);
    snprintf(offered->all + len, sizeof offered->all - len, "%s ", candidate);
}

TEST(names_after_free_complete)
{
    struct bench bench;
    bench_open(&bench, true);
    struct offered offered = {""};
    size_t start;
    const char *line = "fit scene free=k,ga";
    command_complete(bench.session, text_of(line), strlen(line), &start, take_offer, &offered);
    assert_string_equal(offered.all, "gamma ");
    assert_int_equal(start, strlen("fit scene free=k,"));
    offered.all[0] = 0;
    line = "fit ";
    command_complete(bench.session, text_of(line), strlen(line), &start, take_offer, &offered);
    assert_non_null(strstr(offered.all, "damped sine drag law scene modes "));
    assert_null(strstr(offered.all, "NAME="));
    bench_close(&bench);
}

/* A long recording is more precise than the digits that are usual: they follow the uncertainty. */
TEST(small_uncertainties_are_shown)
{
    FILE *out = fopen("long.txt", "w");
    assert_non_null(out);
    fprintf(out, "t (s)\ty (m)\n");
    for (int i = 0; i < 24000; i++)
        fprintf(out, "%.2f\t%.4f\n", 0.05 * i, 0.05 * exp(-5e-4 * 0.05 * i) * cos(8 * 0.05 * i));
    fclose(out);
    struct bench bench;
    bench_open(&bench, true);
    type_ok(&bench, "load long.txt");
    type_ok(&bench, "measure period"); /* pi/4 = 0.785398163 */
    assert_says(&bench.out, "T = 0.785398");
    assert_null(strstr(bench.out.data, "T = 0.785398 s"));
    type_ok(&bench, "m = 200 g; fit scene");
    double low = 0, high = 0, value = 0, off = 0;
    const char *row = strstr(bench.out.data, "\n  k ");
    assert_non_null(row);
    assert_int_equal(sscanf(row, " k %lf +- %lf N/m %lf N/m .. %lf N/m", &value, &off, &low, &high),
                     4);
    assert_true(fabs(high - low - 3.92 * off) < 0.4 * off && high < value + 3 * off &&
                low > value - 3 * off);
    assert_true(off < 1e-5 * value && fabs(value - 12.8) < 5 * off);
    bench_close(&bench);
}

static int enter(void **state)
{
    return getcwd(home, sizeof home) ? enter_folder(state) : -1;
}

RUN_TESTS(enter, leave_folder)
