/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What one would write instead of typing a command: a program for each, with the loops of hands.c,
 * in plain C. The first argument says which; it prints its result, as the command does.
 */
#include "bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void bench_die(const char *what, const char *why)
{
    fprintf(stderr, "hand program: %s: %s\n", what, why);
    exit(1);
}

static void *memory(size_t count)
{
    void *at = malloc(count * sizeof(double));
    if (!at)
        bench_die("memory", "there is none");
    return at;
}

/* ---- run SCENE METHOD STEPS H START..: t, y and v of every step in memory ---- */

struct recorded {
    const struct hand_scene *scene;
    hand_loop *loop;
    double h, state[PROBLEM_MAX], *t, *row;
    int64_t count;
};

static struct recorded given(char **word, int64_t capacity)
{
    struct recorded run = {
        .scene = hand_scene(word[0]), .h = strtod(word[3], NULL), .count = atoll(word[2])};
    run.loop = hand_find(run.scene, word[1]);
    if (!run.loop)
        bench_die(word[1], "no loop");
    for (int i = 0; i < run.scene->n; i++)
        run.state[i] = strtod(word[4 + i], NULL);
    capacity = capacity > run.count ? capacity : run.count;
    run.t = memory((size_t)capacity);
    run.row = memory((size_t)(capacity * run.scene->n));
    return run;
}

static void advance(struct recorded *run, int64_t first, int64_t count)
{
    run->loop(&run->scene->known, run->h, first, count, run->state,
              run->row + first * run->scene->n);
    for (int64_t i = first; i < first + count; i++)
        run->t[i] = (double)(i + 1) * run->h;
}

static void run(char **word)
{
    struct recorded all = given(word, 0);
    advance(&all, 0, all.count);
    printf("t = %g s, %lld steps, y = %g\n", all.t[all.count - 1], (long long)all.count,
           all.state[0]);
}

/* ---- chain METHOD COUNT STEPS H: masses and hardening springs between walls, y and v of every
 * step
 * ---- */

enum { CHAIN_MAX = 31 };

static void pull_chain(int n, const double *x, double *a)
{
    for (int i = 0; i < n; i++) {
        const double left = i > 0 ? x[i - 1] : 0, right = i < n - 1 ? x[i + 1] : 0;
        a[i] = 100 * (left - 2 * x[i] + right) - 30 * x[i] * x[i] * x[i];
    }
}

/* state: positions, then velocities */
static void chain_slope(int n, const double *state, double *slope)
{
    memcpy(slope, state + n, (size_t)n * sizeof *slope);
    pull_chain(n, state, slope + n);
}

static void chain_rk4(int n, double h, double *y)
{
    double k1[2 * CHAIN_MAX], k2[2 * CHAIN_MAX], k3[2 * CHAIN_MAX], k4[2 * CHAIN_MAX],
        z[2 * CHAIN_MAX];
    chain_slope(n, y, k1);
    for (int i = 0; i < 2 * n; i++)
        z[i] = y[i] + h / 2 * k1[i];
    chain_slope(n, z, k2);
    for (int i = 0; i < 2 * n; i++)
        z[i] = y[i] + h / 2 * k2[i];
    chain_slope(n, z, k3);
    for (int i = 0; i < 2 * n; i++)
        z[i] = y[i] + h * k3[i];
    chain_slope(n, z, k4);
    for (int i = 0; i < 2 * n; i++)
        y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

static void chain_verlet(int n, double h, double *y, double *a)
{
    for (int i = 0; i < n; i++) {
        y[n + i] += h / 2 * a[i];
        y[i] += h * y[n + i];
    }
    pull_chain(n, y, a);
    for (int i = 0; i < n; i++)
        y[n + i] += h / 2 * a[i];
}

static void chain(char **word)
{
    const bool is_verlet = strcmp(word[0], "verlet") == 0;
    const int n = atoi(word[1]);
    const long steps = atol(word[2]);
    const double h = strtod(word[3], NULL);
    double y[2 * CHAIN_MAX] = {0.1}, a[CHAIN_MAX], *t = memory((size_t)steps),
                 *row = memory((size_t)(steps * 2 * n));
    pull_chain(n, y, a);
    for (long step = 0; step < steps; step++) {
        if (is_verlet)
            chain_verlet(n, h, y, a);
        else
            chain_rk4(n, h, y);
        t[step] = (double)(step + 1) * h;
        memcpy(row + step * 2 * n, y, (size_t)(2 * n) * sizeof *y);
    }
    printf("t = %g s, %ld steps, x1 = %g\n", t[steps - 1], steps, y[0]);
}

/* ---- lines FILE SCENE METHOD STEPS H START..: so many steps for each line of the file ---- */

static void lines(char **word)
{
    enum { ROWS = 1 << 20 };
    struct recorded all = given(word + 1, ROWS);
    char line[256];
    int64_t done = 0;
    FILE *file = fopen(word[0], "r");
    while (file && fgets(line, sizeof line, file) && done + all.count <= ROWS) {
        if (strncmp(line, "step", 4) != 0 && strncmp(line, "continue", 8) != 0)
            continue;
        advance(&all, done, all.count);
        done += all.count;
        printf("t = %g s, %lld steps, y = %g\n", all.t[done - 1], (long long)done, all.state[0]);
    }
    if (file)
        fclose(file);
}

/* ---- compare STEPS H OMEGA Y0 METHOD..: of the spring; largest errors of the energy and of the
 * position ---- */

static void errors(const char *method, int64_t steps, double h, double omega, double y0)
{
    const struct hand_scene *scene = hand_scene("spring");
    hand_loop *const loop = hand_find(scene, method);
    double state[] = {y0, 0}, *row = memory((size_t)(2 * steps)), energy = 0, position = 0;
    loop(&scene->known, h, 0, steps, state, row);
    for (int64_t i = 0; i < steps; i++) {
        const double y = row[2 * i], v = row[2 * i + 1];
        energy = fmax(energy, fabs((v * v / (omega * omega) + y * y) / (y0 * y0) - 1));
        position = fmax(position, fabs(y - y0 * cos(omega * (double)(i + 1) * h)));
    }
    printf("%s: dE/E0 %g, error %g\n", method, energy, position);
    free(row);
}

static void compare(char **word)
{
    for (char **method = word + 4; *method; method++)
        errors(*method, atoll(word[0]), strtod(word[1], NULL), strtod(word[2], NULL),
               strtod(word[3], NULL));
}

/* The same for steps 2^-4 .. 2^-15 of a second, over a span. */
static void precision(char **word)
{
    for (char **method = word + 3; *method; method++)
        for (int k = 4; k < 16; k++)
            errors(*method, (int64_t)(strtod(word[0], NULL) * ldexp(1, k)), ldexp(1, -k),
                   strtod(word[1], NULL), strtod(word[2], NULL));
}

/* ---- sweep POINTS STEPS H K GAMMA OMEGA Y0: rk4 of the driven spring, amplitudes of the drive;
 * the largest y ---- */

enum { BLOCK = 32 };

#if defined(__x86_64__) && !defined(__clang__)
__attribute__((target_clones("default", "avx2", "avx512f")))
#endif
static void
swept(const double *restrict drive, double *restrict max, int64_t steps, const double *given)
{
    const double h = given[0], k = given[1], gamma = given[2], omega = given[3];
    double y[BLOCK], v[BLOCK], top[BLOCK];
    for (int i = 0; i < BLOCK; i++) {
        y[i] = top[i] = given[4];
        v[i] = 0;
    }
    for (int64_t n = 0; n < steps; n++) {
        const double t = (double)n * h;
        const double c1 = cos(omega * t), c2 = cos(omega * (t + h / 2)), c4 = cos(omega * (t + h));
        for (int i = 0; i < BLOCK; i++) {
            const double a1 = drive[i] * c1 - k * y[i] - gamma * v[i];
            const double v2 = v[i] + h / 2 * a1,
                         a2 = drive[i] * c2 - k * (y[i] + h / 2 * v[i]) - gamma * v2;
            const double v3 = v[i] + h / 2 * a2,
                         a3 = drive[i] * c2 - k * (y[i] + h / 2 * v2) - gamma * v3;
            const double v4 = v[i] + h * a3, a4 = drive[i] * c4 - k * (y[i] + h * v3) - gamma * v4;
            y[i] += h / 6 * (v[i] + 2 * v2 + 2 * v3 + v4);
            v[i] += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
            top[i] = y[i] > top[i] ? y[i] : top[i];
        }
    }
    memcpy(max, top, sizeof top);
}

static void sweep(char **word)
{
    const double given[] = {strtod(word[2], NULL), strtod(word[3], NULL), strtod(word[4], NULL),
                            strtod(word[5], NULL), strtod(word[6], NULL)};
    for (int64_t first = 0; first < atoll(word[0]); first += BLOCK) {
        double drive[BLOCK], max[BLOCK];
        for (int i = 0; i < BLOCK; i++)
            drive[i] = 1e-3 * (double)(first + i + 1);
        swept(drive, max, atoll(word[1]), given);
        for (int i = 0; i < BLOCK; i++)
            printf("%g %g\n", drive[i], max[i]);
    }
}

/* ---- recordings: two columns, t and y ---- */

static int64_t load(const char *name, double **t, double **y)
{
    char line[256];
    int64_t count = 0, capacity = 0;
    FILE *file = fopen(name, "r");
    *t = *y = NULL;
    if (!file)
        bench_die(name, "cannot be opened");
    while (fgets(line, sizeof line, file)) {
        char *next;
        if (count == capacity) {
            capacity = capacity ? 2 * capacity : 1024;
            *t = realloc(*t, (size_t)capacity * sizeof **t);
            *y = realloc(*y, (size_t)capacity * sizeof **y);
            if (!*t || !*y)
                bench_die(name, "out of memory");
        }
        (*t)[count] = strtod(line, &next);
        (*y)[count++] = strtod(next, NULL);
    }
    fclose(file);
    return count;
}

/* measure FILE: the period from upward crossings, by a straight line through their times */
static void measure(char **word)
{
    double *t, *y, number = 0, sum_t = 0, sum_n = 0, sum_nn = 0, sum_nt = 0;
    const int64_t count = load(word[0], &t, &y);
    for (int64_t i = 1; i < count; i++)
        if (y[i - 1] < 0 && y[i] >= 0) {
            const double at = t[i - 1] - y[i - 1] * (t[i] - t[i - 1]) / (y[i] - y[i - 1]);
            sum_t += at;
            sum_n += number;
            sum_nn += number * number;
            sum_nt += number * at;
            number++;
        }
    printf("period %.9g s\n",
           (number * sum_nt - sum_n * sum_t) / (number * sum_nn - sum_n * sum_n));
    free(t);
    free(y);
}

/* fit FILE OMEGA: A exp(-d t) cos(w t + phi) + c by Gauss and Newton's iteration, from a guess of w
 * alone */
static void fit(char **word)
{
    double *t, *y, p[] = {0.01, strtod(word[1], NULL), 1, 0, 0}; /* d, w, A cos phi, A sin phi, c */
    const int64_t count = load(word[0], &t, &y);
    for (int turn = 0; turn < 12; turn++) {
        double a[5][6] = {{0}};
        for (int64_t i = 0; i < count; i++) {
            const double fade = exp(-p[0] * t[i]), c = fade * cos(p[1] * t[i]),
                         s = fade * sin(p[1] * t[i]);
            const double model = p[2] * c - p[3] * s;
            const double slope[] = {-t[i] * model,      -t[i] * (p[2] * s + p[3] * c), c, -s, 1,
                                    y[i] - model - p[4]};
            for (int j = 0; j < 5; j++)
                for (int l = j; l < 6; l++)
                    a[j][l] += slope[j] * slope[l];
        }
        for (int j = 1; j < 5; j++)
            for (int l = 0; l < j; l++)
                a[j][l] = a[l][j];
        for (int j = 0; j < 5; j++) /* Gauss and Jordan's elimination: the matrix is positive */
            for (int l = 0; l < 5; l++) {
                const double factor = l == j ? 0 : a[l][j] / a[j][j];
                for (int m = j; m < 6; m++)
                    a[l][m] -= factor * a[j][m];
            }
        for (int j = 0; j < 5; j++)
            p[j] += a[j][5] / a[j][j];
    }
    printf("decay %.9g omega %.9g amplitude %.9g\n", p[0], p[1], hypot(p[2], p[3]));
    free(t);
    free(y);
}

/* ---- export FILE SCENE METHOD STEPS H START.. ---- */

static void export(char **word)
{
    struct recorded all = given(word + 1, 0);
    FILE *file = fopen(word[0], "w");
    advance(&all, 0, all.count);
    if (!file)
        bench_die(word[0], "cannot be written");
    fputs("t,y,v\n", file);
    for (int64_t i = 0; i < all.count; i++)
        fprintf(file, "%.17g,%.17g,%.17g\n", all.t[i], all.row[2 * i], all.row[2 * i + 1]);
    if (fclose(file) != 0)
        bench_die(word[0], "cannot be written");
}

/* ---- quit: starting and ending ---- */

static void quit(char **word)
{
    (void)word;
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*job)(char **word);
        int words;
    } jobs[] = {{"run", run, 6},
                {"chain", chain, 4},
                {"lines", lines, 7},
                {"compare", compare, 5},
                {"precision", precision, 4},
                {"sweep", sweep, 7},
                {"measure", measure, 1},
                {"fit", fit, 2},
                {"export", export, 7},
                {"quit", quit, 0}};
    for (size_t i = 0; i < COUNT_OF(jobs) && argc > 1; i++)
        if (strcmp(argv[1], jobs[i].name) == 0 && argc - 2 >= jobs[i].words) {
            jobs[i].job(argv + 2);
            return 0;
        }
    return 2;
}
