/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The NIST Statistical Reference Datasets for nonlinear regression, both starts of each, typed as
 * formulas: correct digits of the worst parameter (log relative error against the certified
 * values), and standard deviations. HOOKE_NIST says where the files are.
 */
#include <hooke/base/file.h>
#include <hooke/base/number.h>

#include "cmocka_testing.h"

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The predictor is t; Nelson's second one is x2 and its response the logarithm. */
static const struct {
    const char *name, *formula;
} models[] = {
    {"Bennett5", "b1*(b2+t)^(-1/b3)"},
    {"BoxBOD", "b1*(1-exp(-b2*t))"},
    {"Chwirut1", "exp(-b1*t)/(b2+b3*t)"},
    {"Chwirut2", "exp(-b1*t)/(b2+b3*t)"},
    {"DanWood", "b1*t^b2"},
    {"ENSO",
     "b1+b2*cos(2*pi*t/12)+b3*sin(2*pi*t/12)+b5*cos(2*pi*t/b4)+b6*sin(2*pi*t/b4)+b8*cos(2*pi*t/b7)"
     "+b9*sin(2*pi*t/b7)"},
    {"Eckerle4", "b1/b2*exp(-0.5*((t-b3)/b2)^2)"},
    {"Gauss1", "b1*exp(-b2*t)+b3*exp(-(t-b4)^2/b5^2)+b6*exp(-(t-b7)^2/b8^2)"},
    {"Gauss2", "b1*exp(-b2*t)+b3*exp(-(t-b4)^2/b5^2)+b6*exp(-(t-b7)^2/b8^2)"},
    {"Gauss3", "b1*exp(-b2*t)+b3*exp(-(t-b4)^2/b5^2)+b6*exp(-(t-b7)^2/b8^2)"},
    {"Hahn1", "(b1+b2*t+b3*t^2+b4*t^3)/(1+b5*t+b6*t^2+b7*t^3)"},
    {"Kirby2", "(b1+b2*t+b3*t^2)/(1+b4*t+b5*t^2)"},
    {"Lanczos1", "b1*exp(-b2*t)+b3*exp(-b4*t)+b5*exp(-b6*t)"},
    {"Lanczos2", "b1*exp(-b2*t)+b3*exp(-b4*t)+b5*exp(-b6*t)"},
    {"Lanczos3", "b1*exp(-b2*t)+b3*exp(-b4*t)+b5*exp(-b6*t)"},
    {"MGH09", "b1*(t^2+t*b2)/(t^2+t*b3+b4)"},
    {"MGH10", "b1*exp(b2/(t+b3))"},
    {"MGH17", "b1+b2*exp(-t*b4)+b3*exp(-t*b5)"},
    {"Misra1a", "b1*(1-exp(-b2*t))"},
    {"Misra1b", "b1*(1-(1+b2*t/2)^-2)"},
    {"Misra1c", "b1*(1-(1+2*b2*t)^-0.5)"},
    {"Misra1d", "b1*b2*t*(1+b2*t)^-1"},
    {"Nelson", "b1-b2*t*exp(-b3*x2)"},
    {"Rat42", "b1/(1+exp(b2-b3*t))"},
    {"Rat43", "b1/(1+exp(b2-b3*t))^(1/b4)"},
    {"Roszman1", "b1-b2*t-atan(b3/(t-b4))/pi"},
    {"Thurber", "(b1+b2*t+b3*t^2+b4*t^3)/(1+b5*t+b6*t^2+b7*t^3)"},
};

enum { ROWS_MAX = 300, FIRST_PARAMETER_LINE = 41, FIRST_DATA_LINE = 61 };

struct dataset {
    int parameters;
    double start[2][CURVE_PARAMETERS], certified[CURVE_PARAMETERS], deviation[CURVE_PARAMETERS];
    double y[ROWS_MAX], t[ROWS_MAX], x2[ROWS_MAX];
    size_t n;
};

static const char *folder(void)
{
    const char *name = getenv("HOOKE_NIST");
    return name && *name ? name : "../shared/nist";
}

/* The numbers of a line, after what is not one. */
static int numbers(struct text line, double *out, int capacity)
{
    int count = 0;
    while (line.len > 0 && count < capacity) {
        size_t used = 0;
        double value;
        struct text rest = text_trim(line);
        if (real_scan(rest, '.', &value, &used) == REAL_OK && used > 0)
            out[count++] = value;
        used = used ? used : 1;
        line = (struct text){rest.data + (used < rest.len ? used : rest.len),
                             rest.len - (used < rest.len ? used : rest.len)};
    }
    return count;
}

static void read_dataset(const char *name, struct dataset *set)
{
    struct buffer content = {0};
    struct error error = {0};
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.dat", folder(), name);
    if (!file_read(path, LIMIT_FILE, &content, &error))
        fail_msg("%s", error.text);
    struct text rest = buffer_text(&content), line;
    *set = (struct dataset){0};
    for (int i = 1; text_split(&rest, '\n', &line); i++) {
        double x[8];
        struct text trimmed = text_trim(line);
        if (i >= FIRST_PARAMETER_LINE && i < FIRST_DATA_LINE && text_starts(trimmed, TEXT("b")) &&
            numbers((struct text){trimmed.data + 2, trimmed.len - 2}, x, 8) == 4) {
            int j = set->parameters++;
            set->start[0][j] = x[0];
            set->start[1][j] = x[1];
            set->certified[j] = x[2];
            set->deviation[j] = x[3];
        } else if (i >= FIRST_DATA_LINE && numbers(trimmed, x, 8) >= 2) {
            bool two = strcmp(name, "Nelson") == 0;
            set->y[set->n] = two ? log(x[0]) : x[0];
            set->t[set->n] = x[1];
            set->x2[set->n++] = two ? x[2] : 0;
        }
    }
    buffer_free(&content);
}

static double digits(double value, double certified)
{
    double relative = fabs(value - certified) / fabs(certified);
    return relative > 1e-11 ? -log10(relative) : 11; /* as many as are certified */
}

struct outcome {
    double digits;    /* of the worst parameter */
    double deviation; /* largest relative error of a standard deviation */
    bool converged;
    char said[200];
};

static struct outcome fit_dataset(size_t k, const struct dataset *set, int from, int iterations)
{
    struct arena arena = {0};
    struct error error = {0};
    struct formula formula;
    struct curve_fit fit;
    struct curve_options options = {.iterations = iterations};
    size_t used;
    const struct formula_column column = {"x2", set->x2};
    struct series series = {.t = set->t, .y = set->y, .n = set->n};
    if (!formula_compile(text_of(models[k].formula), NULL, &column, 1, &arena, &formula, &used,
                         &error))
        fail_msg("%s: %s", models[k].name, error.text);
    assert_int_equal(used, strlen(models[k].formula));
    assert_int_equal(formula.parameters, set->parameters);
    for (int j = 0; j < set->parameters; j++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", j + 1);
        assert_true(formula_start(&formula, text_of(name), set->start[from][j], &error));
    }
    if (!formula_fit(&formula, &series, &options, &arena, &fit, &error))
        fail_msg("%s start %d: %s", models[k].name, from + 1, error.text);
    struct outcome outcome = {.digits = 11, .converged = fit.converged};
    for (int j = 0; j < set->parameters; j++) {
        int b = formula.name[j][1] - '1';
        outcome.digits = fmin(outcome.digits, digits(fit.value[j].value, set->certified[b]));
        outcome.deviation = fmax(outcome.deviation, fabs(fit.formal[j] / set->deviation[b] - 1));
    }
    snprintf(outcome.said, sizeof outcome.said, "%s", fit.said);
    arena_reset(&arena);
    return outcome;
}

static void require_files(void)
{
    if (access(folder(), R_OK) != 0) {
        print_message("no NIST files at %s: set HOOKE_NIST\n", folder());
        skip();
    }
}

TEST(certified_values_from_both_starts)
{
    require_files();
    int good = 0, poor = 0;
    static struct dataset set;
    for (size_t k = 0; k < COUNT_OF(models); k++) {
        read_dataset(models[k].name, &set);
        assert_true(set.n > 5 && set.parameters >= 2);
        for (int from = 0; from < 2; from++) {
            struct outcome o = fit_dataset(k, &set, from, 0);
            print_message("%-9s start %d: %4.1f digits, deviations to %.1e, %s\n", models[k].name,
                          from + 1, o.digits, o.deviation, o.said);
            if (o.converged != (o.digits >= 6))
                fail_msg("%s start %d: %.1f digits, yet: %s", models[k].name, from + 1, o.digits,
                         o.said);
            if (strcmp(models[k].name, "Lanczos1") !=
                0) /* whose residuals are the rounding of its data */
                assert_true(o.deviation < 1e-4);
            good += o.digits >= 8;
            poor += o.digits < 6;
        }
    }
    print_message("8 digits or more: %d of %zu; fewer than 6: %d\n", good, 2 * COUNT_OF(models),
                  poor);
    assert_true(good >= 40);
    assert_int_equal(poor, 0);
}

/* Stopped on the way, the answer is called converged only where it is right. */
TEST(nothing_wrong_is_called_converged)
{
    require_files();
    static const int limits[] = {1, 2, 4, 8, 16};
    static struct dataset set;
    int unfinished = 0;
    for (size_t k = 0; k < COUNT_OF(models); k++) {
        read_dataset(models[k].name, &set);
        for (int run = 0; run < 2 * (int)COUNT_OF(limits); run++) {
            struct outcome o = fit_dataset(k, &set, run % 2, limits[run / 2]);
            unfinished += !o.converged;
            if (o.converged && o.digits < 6)
                fail_msg("%s start %d, %d iterations: %.1f digits, yet: %s", models[k].name,
                         run % 2 + 1, limits[run / 2], o.digits, o.said);
        }
    }
    assert_true(unfinished > 50);
}

RUN_TESTS(NULL, NULL)
