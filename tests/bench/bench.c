/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Contests, tables, the header and the choice of topics. Nothing here is a test. */
#include <hooke/base/catalog.h>
#include "bench/bench.h"

#include <malloc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- contests ---- */

/* Marsaglia, Journal of Statistical Software 8 (2003), 14: 64 bits, shifts 13, 7, 17. */
static uint64_t next_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void contest(struct arm *arm, int count)
{
    enum { ARMS = 16 };
    double sample[ARMS][ROUNDS];
    int order[ARMS];
    uint64_t state = 88172645463325252u; /* the same order on every machine */
    if (count > ARMS)
        bench_die("contest", "too many arms");
    for (int i = 0; i < count; i++) {
        order[i] = i;
        arm[i].run(arm[i].self); /* warm-up */
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = count - 1; i > 0; i--) {
            const int j = (int)(next_random(&state) % (uint64_t)(i + 1)), keep = order[i];
            order[i] = order[j];
            order[j] = keep;
        }
        for (int i = 0; i < count; i++)
            sample[order[i]][round] = arm[order[i]].run(arm[order[i]].self);
    }
    for (int i = 0; i < count; i++) {
        qsort(sample[i], ROUNDS, sizeof sample[i][0], by_value);
        arm[i].minimum = sample[i][0];
        arm[i].median = sample[i][ROUNDS / 2];
    }
}

double arm_spread(const struct arm *a, const struct arm *b)
{
    const double x = a->median / a->minimum, y = b->median / b->minimum;
    return (x > y ? x : y) - 1;
}

/* ---- tables ---- */

static int met, missed;

void table_begin(const char *title, const char *unit)
{
    printf("\n%s; times in %s\n", title, unit);
    printf("%-41s %7s %-17s %7s %5s %4s %-7s %s\n", "what", "hooke", "against", "other", "ratio",
           "goal", "verdict", "noise");
}

void table_row(const char *what, const struct arm *hooke, const char *other_name,
               const struct arm *other, double goal)
{
    const double ratio = hooke->minimum / other->minimum, spread = arm_spread(hooke, other);
    const bool good = ratio <= goal;
    char verdict[16] = "", wanted[16] = "-";
    if (!isnan(goal)) {
        met += good;
        missed += !good;
        snprintf(wanted, sizeof wanted, "%.2f", goal);
        snprintf(verdict, sizeof verdict, "%s%s", good ? "met" : "MISSED", spread > 0.1 ? "~" : "");
    }
    printf("%-41s %7.3g %-17s %7.3g %5.*f %4s %-7s %3.0f%%\n", what, hooke->minimum, other_name,
           other->minimum, ratio < 1 ? 3 : 2, ratio, wanted, verdict, 100 * spread);
    fflush(stdout);
}

void table_absent(const char *other_name, const char *why)
{
    printf("%-41s %7s %-17s %s\n", "", "", other_name, why);
}

void table_note(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fputs("  ", stdout);
    vprintf(format, args);
    putchar('\n');
    va_end(args);
}

void table_verdict(bool good, const char *format, ...)
{
    va_list args;
    met += good;
    missed += !good;
    printf("  %s: ", good ? "met" : "MISSED");
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    putchar('\n');
}

/* ---- scenes and methods ---- */

void bench_die(const char *what, const char *why)
{
    fprintf(stderr, "bench: %s: %s\n", what, why);
    exit(1);
}

const struct method *bench_method(const char *name)
{
    const struct row *row = catalog_find(&method_catalog, text_of(name));
    return (const void *)row;
}

struct scene bench_scene(const char *preset, const char *setting, double value)
{
    struct scene scene;
    struct error error = {0};
    const struct row *row = catalog_find(&preset_catalog, text_of(preset));
    if (!row)
        bench_die(preset, "no such scene");
    scene_init(&scene, (const void *)row);
    if (setting &&
        !scene_set(&scene, scene_param(&scene, setting), (struct measured){value, 0}, &error))
        bench_die(setting, error.text);
    return scene;
}

struct run *bench_run(const struct scene *scene, const struct method *method,
                      const struct run_settings *settings, double span)
{
    struct error error = {0};
    return run_create(scene, method, settings, span, &error);
}

void memory_cold(void)
{
    malloc_trim(0);
}

/* ---- what is measured ---- */

static const struct topic {
    const char *name;
    void (*run)(void);
} topics[] = {
    {"commands", bench_commands}, {"ranking", bench_ranking}, {"fixed", bench_fixed},
    {"linear", bench_linear},     {"cost", bench_cost},       {"text", bench_text},
    {"adaptive", bench_adaptive}, {"stiff", bench_stiff},     {"sweep", bench_sweep},
    {"forces", bench_forces},
};

static const char *instructions(void)
{
#ifdef __x86_64__
    return __builtin_cpu_supports("avx512f") ? "AVX-512"
           : __builtin_cpu_supports("avx2")  ? "AVX2"
                                             : "x86-64";
#else
    return "baseline";
#endif
}

int main(int argc, char **argv)
{
    bool found = argc < 2;
    /* The heap keeps what a run gives back, so that the next one finds warm memory, as the loops by
     * hand do. */
    mallopt(M_TRIM_THRESHOLD, 512 << 20);
    mallopt(M_TOP_PAD, 64 << 20);
    printf("instructions: %s; minimum of %d rounds, in random order; ~: a median more than 10 %% "
           "above\n",
           instructions(), ROUNDS);
    printf("memory that was freed stays warm: mallopt(M_TRIM_THRESHOLD, M_TOP_PAD)\n");
    for (size_t i = 0; i < COUNT_OF(topics); i++) {
        if (argc > 1 && strcmp(argv[1], topics[i].name) != 0)
            continue;
        found = true;
        topics[i].run();
    }
    if (!found)
        bench_die(argv[1], "topics are commands, ranking, fixed, linear, cost, text, adaptive, "
                           "stiff, sweep, forces");
    printf("\n%d goals met, %d missed\n", met, missed);
    return 0;
}
