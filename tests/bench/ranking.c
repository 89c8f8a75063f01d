/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The order in which `compare` puts methods by their time a step, beside the order of C loops of
 * the same methods. */
#include "bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEPS 40000
#define DT 0.001
#define NEAR 0.1 /* loops that differ by less have no order */

struct timed {
    const char *method;
    const struct hand_scene *scene;
    hand_loop *loop;
    double start[PROBLEM_MAX], *row;
    double loop_ns, compare_ns; /* a step */
    char path[32];              /* by which code compare timed it */
};

static double run_loop(void *self)
{
    const struct timed *timed = self;
    double state[PROBLEM_MAX];
    memcpy(state, timed->start, sizeof state);
    const int64_t begin = clock_ns();
    timed->loop(&timed->scene->known, DT, 0, STEPS, state, timed->row);
    return (double)(clock_ns() - begin) / STEPS + 1e-300 * state[0];
}

/* What `compare` says of each: its lines of JSON. */
static void ask(struct timed *timed, int count)
{
    const char *build = getenv("BUILD");
    char command[1024], line[8192];
    int used = snprintf(
        command, sizeof command,
        "%s/hooke -n -q -c 'set format json; scene %s; duration = %g s; timing full; compare",
        build ? build : "build", timed->scene->preset, STEPS * DT);
    for (int i = 0; i < count; i++)
        used += snprintf(command + used, sizeof command - (size_t)used, " %s", timed[i].method);
    snprintf(command + used, sizeof command - (size_t)used, " dt=%gs' 2>/dev/null", DT);
    FILE *said = popen(command, "r");
    while (said && fgets(line, sizeof line, said))
        for (int i = 0; i < count; i++) {
            char key[64];
            snprintf(key, sizeof key, "\"method\":\"%s\"", timed[i].method);
            const char *time = strstr(line, "\"ns_per_step\":");
            if (strstr(line, key) && time)
                timed[i].compare_ns = strtod(time + strlen("\"ns_per_step\":"), NULL);
            const char *path = strstr(line, "\"path\":\"");
            if (strstr(line, key) && path)
                snprintf(timed[i].path, sizeof timed[i].path, "%.*s", (int)strcspn(path + 8, "\""),
                         path + 8);
        }
    if (said)
        pclose(said);
}

static int by_loop(const void *a, const void *b)
{
    const struct timed *x = a, *y = b;
    return (x->loop_ns > y->loop_ns) - (x->loop_ns < y->loop_ns);
}

static void rank(const struct hand_scene *scene, double *row)
{
    static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4", "dopri5",
                                          "pefrl", "implicit-midpoint"};
    struct timed timed[COUNT_OF(methods)];
    struct arm arm[COUNT_OF(methods)];
    struct system system;
    struct error error = {0};
    const struct scene bound = bench_scene(scene->preset, NULL, 0);
    int count = 0, turned = 0, pairs = 0;
    if (!scene_bind(&bound, &system, &error))
        bench_die(scene->name, error.text);
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        hand_loop *loop = hand_find(scene, methods[i]);
        if (!loop)
            continue;
        timed[count] = (struct timed){
            .method = methods[i], .scene = scene, .loop = loop, .row = row, .compare_ns = NAN};
        memcpy(timed[count].start, system.start, sizeof timed[count].start);
        arm[count] = (struct arm)ARM(run_loop, &timed[count]);
        count++;
    }
    contest(arm, count);
    for (int i = 0; i < count; i++)
        timed[i].loop_ns = arm[i].minimum;
    ask(timed, count);
    qsort(timed, (size_t)count, sizeof *timed, by_loop);
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) {
            const bool apart = timed[i].loop_ns > (1 + NEAR) * timed[j].loop_ns &&
                               strcmp(timed[i].path, timed[j].path) == 0;
            pairs += apart;
            turned += apart && !(timed[i].compare_ns > timed[j].compare_ns);
        }
    printf("%s\n", scene->name);
    for (int i = 0; i < count; i++)
        printf("  %-20s C loop %6.2f   compare %6.2f  %s\n", timed[i].method, timed[i].loop_ns,
               timed[i].compare_ns, timed[i].path);
    table_verdict(turned == 0, "%d of %d pairs timed by the same code in the other order", turned,
                  pairs);
}

void bench_ranking(void)
{
    static const char *const scenes[] = {"spring",  "linear drag", "quadratic drag",
                                         "duffing", "driven",      "van der pol"};
    double *row = malloc(2 * STEPS * sizeof *row);
    if (!row)
        bench_die("rows", "out of memory");
    printf("\nMethods by their time a step [ns]: loops in C, and what compare says\n");
    for (size_t i = 0; i < COUNT_OF(scenes); i++)
        rank(hand_scene(scenes[i]), row);
    free(row);
}
