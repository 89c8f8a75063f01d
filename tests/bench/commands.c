/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What people type, as whole processes: the processor time (user and system) of the program with a
 * command, start and end included, against that of a program by hand that does the same job and is
 * linked with the same libraries.
 */
#include "bench/bench.h"

#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define WORDS 32
#define FOLDER "build/bench/"

struct command {
    char text[WORDS][4096];
    char *word[WORDS + 1];
    int count;
};

static const char *program(void)
{
    const char *build = getenv("BUILD");
    static char path[512];
    snprintf(path, sizeof path, "%s/hooke", build ? build : "build");
    return path;
}

__attribute__((format(printf, 2, 3))) static void put(struct command *command, const char *format,
                                                      ...)
{
    va_list args;
    va_start(args, format);
    if (command->count == WORDS)
        bench_die("command", "too many words");
    vsnprintf(command->text[command->count++], sizeof command->text[0], format, args);
    va_end(args);
}

/* Milliseconds of processor time; NAN: it failed. */
static double run_command(void *self)
{
    struct command *command = self;
    struct rusage usage;
    int status;
    for (int i = 0; i < command->count; i++)
        command->word[i] = command->text[i];
    command->word[command->count] = NULL;
    const pid_t child = fork();
    if (child == 0) {
        const int nowhere = open("/dev/null", O_RDWR);
        for (int i = 0; i < 3; i++)
            dup2(nowhere, i);
        execv(command->word[0], command->word);
        _exit(127);
    }
    if (child < 0 || wait4(child, &status, 0, &usage) != child || !WIFEXITED(status) ||
        WEXITSTATUS(status) != 0)
        return NAN;
    return 1e3 * (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-3 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static struct command typed(const char *line)
{
    struct command command = {.count = 0};
    put(&command, "%s", program());
    put(&command, "-n");
    put(&command, "-c");
    put(&command, "%s", line);
    return command;
}

static struct command by_hand(const char *job)
{
    struct command command = {.count = 0};
    put(&command, FOLDER "hand");
    put(&command, "%s", job);
    return command;
}

static void row_against(const char *what, struct command *hooke, const char *name,
                        struct command *other, double goal)
{
    struct arm arm[] = {ARM(run_command, hooke), ARM(run_command, other)};
    if (isnan(run_command(hooke)) || isnan(run_command(other))) {
        table_absent(what, "failed");
        return;
    }
    contest(arm, 2);
    table_row(what, &arm[0], name, &arm[1], goal);
}

static void row(const char *what, struct command *hooke, struct command *hand, double goal)
{
    row_against(what, hooke, "C program", hand, goal);
}

/* The words that hand programs want of a run: scene, method, steps, dt, start. */
static void put_run(struct command *command, const struct hand_scene *hand, const char *method,
                    long steps, double h)
{
    const struct scene scene = bench_scene(hand->preset, NULL, 0);
    struct system system;
    struct error error = {0};
    if (!scene_bind(&scene, &system, &error))
        bench_die(hand->name, error.text);
    put(command, "%s", hand->name);
    put(command, "%s", method);
    put(command, "%ld", steps);
    put(command, "%.17g", h);
    for (int i = 0; i < hand->n; i++)
        put(command, "%.17g", system.start[i]);
}

static void run_row(const struct hand_scene *scene, const char *method, double h, long steps,
                    const char *record, double goal)
{
    char line[256], what[64];
    if (!hand_find(scene, method))
        return;
    snprintf(line, sizeof line, "scene %s; method %s dt=%gs; set record %s; run %.17g s",
             scene->preset, method, h, record, (double)steps * h);
    struct command hooke = typed(line), hand = by_hand("run");
    put_run(&hand, scene, method, steps, h);
    snprintf(what, sizeof what, "run, %s, %s, %g ms", method, scene->name, h * 1e3);
    row(what, &hooke, &hand, goal);
}

/* At 1 ms and at the lab's own step, where what Euler's method makes leaves the range of numbers.
 */
static void runs(void)
{
    static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4"};
    static const double h[] = {1e-3, 1e-2};
    table_begin("Whole commands: run, 5e5 steps, all recorded", "ms of processor time");
    for (size_t i = 0; i < COUNT_OF(h); i++)
        for (const struct hand_scene *scene = hand_scenes; scene->name; scene++)
            for (size_t m = i; scene->n == 2 && m < COUNT_OF(methods); m++)
                run_row(scene, methods[m], h[i], 500000, "all",
                        strcmp(scene->name, "quadratic drag") == 0 ? 1.2 : 1.15);
    table_begin("Whole commands: run, 5e6 steps, rows apart", "ms of processor time");
    for (const struct hand_scene *scene = hand_scenes; scene->name; scene++)
        for (size_t m = 2; scene->n == 2 && m < COUNT_OF(methods); m++) {
            run_row(scene, methods[m], 1e-3, 5000000, "auto", 0.9);
            run_row(scene, methods[m], 1e-3, 5000000, "every 100", 0.9);
        }
}

/* A chain of typed oscillators, each bound to the next and to the walls by hardening springs. */
static void chain_row(const char *method, int n)
{
    char line[4096], what[64];
    size_t used = (size_t)snprintf(line, sizeof line, "scene new;");
    for (int i = 1; i <= n; i++)
        used += (size_t)snprintf(line + used, sizeof line - used, "var x%d = %g;", i,
                                 i == 1 ? 0.1 : 0.0);
    for (int i = 1; i <= n; i++) {
        char left[16] = "0", right[16] = "0";
        if (i > 1)
            snprintf(left, sizeof left, "x%d", i - 1);
        if (i < n)
            snprintf(right, sizeof right, "x%d", i + 1);
        used += (size_t)snprintf(line + used, sizeof line - used,
                                 "x%d''=100*(%s-2*x%d+%s)-30*x%d^3;", i, left, i, right, i);
    }
    snprintf(line + used, sizeof line - used, "method %s dt=1ms; set record all; run 200 s",
             method);
    struct command hooke = typed(line), hand = by_hand("chain");
    put(&hand, "%s", method);
    put(&hand, "%d", n);
    put(&hand, "200000");
    put(&hand, "0.001");
    snprintf(what, sizeof what, "run, %s, %d typed oscillators", method, n);
    row(what, &hooke, &hand, 2);
}

static void chains(void)
{
    static const int counts[] = {1, 4, 8, 20, 31};
    table_begin("Whole commands: run, 2e5 steps of a typed chain, all recorded",
                "ms of processor time");
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        chain_row("rk4", counts[i]);
        chain_row("verlet", counts[i]);
    }
}

/* Lines of a script, each of the same number of steps of h [s]. */
static void line_row(const char *what, const char *line, int count, long steps, const char *scene,
                     const char *method, double h)
{
    const struct hand_scene *scene_by_hand = hand_scene(scene);
    static const char name[] = FOLDER "lines.hk";
    FILE *file = fopen(name, "w");
    if (!file)
        bench_die(name, "cannot be written");
    fprintf(file, "scene %s; method %s dt=%gs\nrun %g s\n", scene_by_hand->preset, method, h, h);
    for (int i = 0; i < count; i++)
        fprintf(file, "%s\n", line);
    if (fclose(file) != 0)
        bench_die(name, "cannot be written");
    struct command hooke = {.count = 0}, hand = by_hand("lines");
    put(&hooke, "%s", program());
    put(&hooke, "-n");
    put(&hooke, "-f");
    put(&hooke, "%s", name);
    put(&hand, "%s", name);
    put_run(&hand, scene_by_hand, method, steps, h);
    row(what, &hooke, &hand, NAN);
}

/* Four methods over 1e5 steps at 1 ms, or 2e4 at 10 ms, before Euler's leave the range of numbers.
 */
static void compare_row(const char *what, const char *line, const char *steps, const char *h)
{
    const char *const words[] = {
        steps, h, "8.6602540378443873", "0.05", "euler", "symplectic-euler", "verlet", "rk4"};
    struct command hooke = typed(line), hand = by_hand("compare");
    for (size_t i = 0; i < COUNT_OF(words); i++)
        put(&hand, "%s", words[i]);
    row(what, &hooke, &hand, NAN);
}

static void export_row(const char *what, const char *line, double h)
{
    struct command hooke = typed(line), hand = by_hand("export");
    put(&hand, "%s", FOLDER "hand.csv");
    put_run(&hand, hand_scene("duffing"), "rk4", 200000, h);
    row(what, &hooke, &hand, 1);
}

#ifdef HAVE_BOOST
/* An adaptive run whose steps are all recorded, at 1e-9, against boost's where its error is the
 * same. */
static void adaptive_row(const char *what, const struct problem *problem, const struct scene *scene,
                         const char *set)
{
    char line[256];
    double error;
    const double tol = bench_tolerance(problem, scene, "dopri5", 1e-9, boost_dopri5, &error);
    snprintf(line, sizeof line, "%s; method dopri5 tol=1e-9; run %.17g s", set, problem->span);
    struct command hooke = typed(line), boost = {.count = 0};
    put(&hooke, "-q");
    put(&boost, FOLDER "boost");
    put(&boost, "%d", problem->n);
    put(&boost, "%.17g", tol);
    put(&boost, "%.17g", problem->span);
    row_against(what, &hooke, "boost dopri5", &boost, 1.05);
    table_note("%s: tol 1e-9, boost's %.1e, error %.1e", what, tol, error);
}

static void adaptive_rows(void)
{
    struct scene scene;
    table_begin("Whole commands: adaptive runs, recorded", "ms of processor time");
    const struct problem swing = bench_oscillator(1e4, &scene);
    adaptive_row("run, dopri5, oscillator to t = 1e4", &swing, &scene, "scene duffing; k3 = 0");
    const struct problem orbit = bench_kepler(500, &scene);
    adaptive_row("run, dopri5, Kepler, 500 orbits", &orbit, &scene, "scene kepler");
}
#else
static void adaptive_rows(void)
{
}
#endif

static void recording(const char *name, int count)
{
    FILE *file = fopen(name, "w");
    if (!file)
        bench_die(name, "cannot be written");
    for (int i = 0; i < count; i++)
        fprintf(file, "%.2f %.9f\n", 0.01 * i, 0.05 * exp(-1e-3 * i) * cos(0.0866 * i));
    if (fclose(file) != 0)
        bench_die(name, "cannot be written");
}

static void others(void)
{
    static const char name[] = FOLDER "recording.txt";
    table_begin("Whole commands", "ms of processor time");
    struct command hooke = typed("quit"), hand = by_hand("quit");
    row("quit: starting and ending", &hooke, &hand, 1.3);
    line_row("1000 lines 'step', rk4, quadratic drag", "step", 1000, 1, "quadratic drag", "rk4",
             1e-3);
    line_row("the same at 10 ms", "step", 1000, 1, "quadratic drag", "rk4", 1e-2);
    line_row("100 lines 'continue 1 s', rk4, duffing", "continue 1 s", 100, 1000, "duffing", "rk4",
             1e-3);
    line_row("'continue 10 s' at 10 ms", "continue 10 s", 100, 1000, "duffing", "rk4", 1e-2);
    compare_row("compare, four methods, 1e5 steps",
                "duration = 100 s; timing off; compare euler symplectic-euler verlet rk4 dt=1ms",
                "100000", "0.001");
    compare_row("the same, 2e4 steps at 10 ms",
                "duration = 200 s; timing off; compare euler symplectic-euler verlet rk4 dt=10ms",
                "20000", "0.01");

    hooke =
        typed("duration = 8 s; timing off; precision euler verlet rk4 dt=0.000244140625:0.0625");
    hand = by_hand("precision");
    const char *const words_of[] = {"8", "8.6602540378443873", "0.05", "euler", "verlet", "rk4"};
    for (size_t i = 0; i < COUNT_OF(words_of); i++)
        put(&hand, "%s", words_of[i]);
    row("precision, three methods, untimed", &hooke, &hand, NAN);

    hooke = typed("scene driven; method rk4 dt=10ms; duration = 20 s; "
                  "sweep F0=0.0002:1.024:0.0002 measure=max --threads 1");
    hand = by_hand("sweep");
    const char *const swept[] = {"5120", "2000", "0.01", "75", "0.3", "8.2", "0"};
    for (size_t i = 0; i < COUNT_OF(swept); i++)
        put(&hand, "%s", swept[i]);
    row("sweep, 5120 points of 2000 steps", &hooke, &hand, 1.25);

    recording(name, 100000);
    hooke = typed("load " FOLDER "recording.txt; measure period");
    hand = by_hand("measure");
    put(&hand, "%s", name);
    row("load and measure period, 1e5 rows", &hooke, &hand, NAN);
    recording(name, 12000);
    hooke = typed("load " FOLDER "recording.txt; fit damped");
    hand = by_hand("fit");
    put(&hand, "%s", name);
    put(&hand, "8.66");
    row("load and fit damped, 12000 rows", &hooke, &hand, NAN);

    export_row("run and export, 2e5 rows",
               "scene duffing; method rk4 dt=1ms; run 200 s; export " FOLDER
               "rows.csv t,y,v --force",
               1e-3);
    export_row("the same at 10 ms",
               "scene duffing; method rk4 dt=10ms; run 2000 s; export " FOLDER
               "rows.csv t,y,v --force",
               1e-2);
}

/* What is swept and what is measured, against the quickest: 30 001 points of 1000 steps. */
static void sweep_rows(void)
{
    static const struct {
        const char *what, *scene, *line;
        double goal;
    } sweeps[] = {
        {"the default measure", "scene driven", "sweep gamma=0.1:1:0.00003", 2},
        {"amplitude, period, mean", "scene driven",
         "sweep gamma=0.1:1:0.00003 measure=amplitude,period,mean", 2},
        {"over omega", "scene driven", "sweep omega=6:12:0.0002 measure=y", 1.25},
        {"quadratic drag", "scene drag", "sweep C=0.1:1:0.00003 measure=y", 2},
        {"quadratic drag, over k", "scene drag", "sweep k=10:40:0.001 measure=y", 2},
        {"implicit midpoint", "scene driven",
         "method implicit-midpoint; sweep gamma=0.1:1:0.00003 measure=y", 2.5},
        {"implicit midpoint, Duffing", "scene duffing",
         "method implicit-midpoint; sweep y0=0.1:1:0.00003 measure=y", NAN},
        {"dopri5 at 1e-6", "scene driven",
         "method dopri5; set tol 1e-6; sweep gamma=0.1:1:0.0003 measure=y", NAN},
        {"rodas5p at 1e-6, van der Pol", "scene vanderpol",
         "method rodas5p; set tol 1e-6; sweep mu=0.1:10:0.01 measure=y", NAN},
        {"max(v)", "scene driven", "sweep gamma=0.1:1:0.00003 measure=max(v)", NAN},
        {"energy_error", "scene driven", "sweep gamma=0.1:1:0.00003 measure=energy_error", NAN}};
    static const char set[] = "method rk4 dt=10ms; duration = 10 s;";
    char line[200], what[64];
    struct command quickest = typed("scene driven; method rk4 dt=10ms; duration = 10 s; "
                                    "sweep gamma=0.1:1:0.00003 measure=y");
    for (size_t i = 0; i < COUNT_OF(sweeps); i++) {
        snprintf(line, sizeof line, "%s; %s %s", sweeps[i].scene, set, sweeps[i].line);
        snprintf(what, sizeof what, "sweep, %s", sweeps[i].what);
        struct command hooke = typed(line);
        row_against(what, &hooke, "gamma, measure=y", &quickest, sweeps[i].goal);
    }
    struct command map = typed("scene driven; method rk4 dt=10ms; duration = 10 s; "
                               "sweep gamma=0.1:1:0.0009009009009 omega=6:12:0.006006006006 "
                               "measure=amplitude,period,mean");
    table_note("1000 x 1000 driven points, 1000 steps of rk4, amplitude, period and mean: %.2f s "
               "of processor time (goal 2.5 s on AVX-512, 5 s on AVX2)",
               run_command(&map) / 1000);
}

/* Whole commands with a limit of their own. */
static void diagram_rows(void)
{
    static const struct {
        const char *what, *line;
        double goal; /* [s] */
    } rows[] = {
        {"orbit diagram of 1000 values at the strobe, 200 points after 100 of each",
         "scene pendulum-driven; method rk4 dt=94.24777960769379ms; "
         "sweep F0=1:1.0999:0.0001 at period skip=100 keep=200",
         2},
        {"the same at v = 0",
         "scene pendulum-driven; method rk4 dt=94.24777960769379ms; "
         "sweep F0=1:1.0999:0.0001 at v = 0 falling skip=100 keep=200",
         2},
        {"the same at the strobe, into a file",
         "scene pendulum-driven; method rk4 dt=94.24777960769379ms; sweep F0=1:1.0999:0.0001 at "
         "period skip=100 keep=200 --resume " FOLDER "diagram.csv",
         2},
        {"what 1001 driven pendulums end in",
         "scene pendulum-driven; sweep F0=1.06:1.085:0.000025 measure=attractor", 6},
        {"basins of 400 x 400 starts of the double well",
         "var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v; "
         "basins x=-2:2:0.010025062656 v=-2:2:0.010025062656",
         5}};
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        struct command command = typed(rows[i].line);
        remove(FOLDER "diagram.csv");
        table_note("%s: %.2f s of processor time (goal %.0f s)", rows[i].what,
                   run_command(&command) / 1000, rows[i].goal);
    }
}

void bench_commands(void)
{
    runs();
    chains();
    adaptive_rows();
    others();
    sweep_rows();
    diagram_rows();
    table_note("C program: one for the job, with loops for this method and scene, same flags, same "
               "libraries linked.");
}
