/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Ten times the work costs at most twelve times the instructions: what the last line, row or point
 * costs is what the first one cost. Counted by valgrind, not timed. One process plays the scripts
 * of all rows, each in a session of its own, and callgrind writes down the counts in between.
 *   instructions [ROW...]
 */
#include <hooke/command.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "long_form.h"
#include "terminal/folder.h"

#define AT_MOST 13.0 /* times as many instructions for ten times the work */

/* A script: `first`, then so many lines `each`. In `first` '#' stands for the amount of work and
 * `more`, in `each` for a number that changes from line to line. With 0 work it does what has to be
 * there before. */
struct growth {
    const char *name;
    int amount; /* of the work that is done once; then ten times that; LONG: ten times both */
    int more;
    const char *first, *each;
    bool recording;  /* of so many rows, in rows-#.txt */
    double each_max; /* instructions for each; 0: as many as it takes */
};

#define STEPS(scene, method) "scene " scene "; method " method " dt=1ms; run # ms"
#define PULSE                                                                                      \
    "var x = 0; var v = 0; x' = v; v' = exp(-((t - 500)/1e-4)^2) - x; method rk4 dt=1ms; run 1 ms"

static const struct growth rows[] = {
    {"steps_linear", 20000, 1, .first = STEPS("damped", "verlet")},
    {"steps", 5000, 1, .first = STEPS("drag", "rk4")},
    {"steps_driven", 5000, 1, .first = STEPS("driven", "verlet")},
    {"steps_thinned", 20000, 1, .first = "set record every 100; " STEPS("duffing", "rk4")},
    {"steps_even", 5000, 1, .first = "set record every 10 ms; " STEPS("drag", "rk4")},
    {"steps_typed", 5000, 1,
     .first = "var x = 1; var z = 0; x'' = z - 2*x; z'' = x - 2*z; method rk4 dt=1ms; run # ms"},
    {"steps_typed_cubic", 20000, 1, .each_max = 190,
     .first = "var y = 0.05; y'' = -75*y - 500*y^3; method verlet dt=1ms; run # ms"},
    {"steps_adaptive", 30, 1, .first = "scene kepler; method dop853; run # s"},
    {"step_lines", 50, 1, .first = "scene drag; method rk4 dt=1ms; run 1 ms", .each = "step"},
    {"step_lines_linear", 50, 1, .first = "scene damped; method verlet dt=1ms; run 1 ms",
     .each = "step"},
    {"step_lines_driven", 50, 1, .first = "scene driven; method rk4 dt=1ms; run 1 ms",
     .each = "step"},
    {"back_lines", 10, 1, .first = "scene drag; method rk4 dt=1ms; run 3001 ms", .each = "back"},
    {"continue_lines", 30, 1, .first = "scene duffing; method rk4 dt=1ms; run 1 ms",
     .each = "continue 3 ms"},
    {"continue_lines_linear", 30, 1, .first = "scene damped; method verlet dt=1ms; run 1 ms",
     .each = "continue 3 ms"},
    {"continue_lines_driven", 30, 1, .first = "scene driven; method rk4 dt=1ms; run 1 ms",
     .each = "continue 3 ms"},
    {"step_lines_pulse", 20, 0, .first = PULSE, .each = "step"},
    {"continue_lines_pulse", 10, 0, .first = PULSE, .each = "continue 3 ms"},
    {"step_lines_opinion", 30, 0, .first = "scene spring; method dop853; run 30 s", .each = "step"},
    {"continue_lines_opinion", 30, 0, .first = "scene damped; method dop853; run 30 s",
     .each = "continue 50 ms"},
    {"continue_lines_second", 30, 0, .first = "scene pendulum; method dop853; run 30 s",
     .each = "continue 50 ms"},
    {"change_lines", 30, 0, .first = "scene drag; method rk4 dt=1ms; run 11 ms",
     .each = "change k #"},
    {"runs", 20, 0, .first = "", .each = "run 20 ms"},
    {"set_lines", 50, 0, .first = "", .each = "set m #"},
    {"export_rows", 500, 1, .first = STEPS("drag", "rk4") "; export rows.csv t,y,v,energy --force"},
    {"export_json", 500, 1, .first = STEPS("damped", "verlet") "; export rows.json --force"},
    {"measure_rows", 4000, 10001,
     .first = STEPS("damped", "rk4") "; measure period; measure amplitude"},
    {"measure_growing", 4000, 4001, .each_max = 500,
     .first = "set record all; " STEPS("spring", "euler") "; measure period"},
    {"measure_damped", 4000, 4001, .each_max = 500,
     .first =
         "set record all; k = 1500; set gamma 9; " STEPS("damped", "verlet") "; measure period"},
    {"load_rows", 1000, 400, .first = "load rows-#.txt", .recording = true},
    {"fit_rows", 150, 400, .first = "load rows-#.txt; fit damped", .recording = true},
    {"fit_scene_rows", 150, 400, .first = "load rows-#.txt; scene damped; fit scene",
     .recording = true},
    {"fit_drag_rows", 150, 400, .first = "load rows-#.txt; fit drag", .recording = true},
    {"clean_rows", 300, 400, .first = "load rows-#.txt; data clean", .recording = true},
    {"measure_recording", 300, 400, .first = "load rows-#.txt; measure period", .recording = true},
    {"plot_rows", 3000, 1001, .first = STEPS("drag", "verlet") "; plot position; plot energy"},
    {"sweep_points", 50, 2,
     .first = "scene driven; method rk4 dt=10ms; duration = 1 s; sweep omega=1:#:1 measure=max "
              "--threads 1"},
    {"sweep_short", 640, 2, .each_max = 4500,
     .first = "scene spring; method rk4 dt=10ms; duration = 0.1 s; sweep k=1:#:1 --threads 1"},
};

/* ---- the process that is counted ---- */

static bool swallow(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool keep(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

/* callgrind writes down what was counted before this. */
void script_counted(void);
__attribute__((noinline)) void script_counted(void)
{
    __asm__ volatile("");
}

static bool play(const char *path)
{
    struct front front = {.interactive = false};
    struct session *session = session_create(&front);
    if (!session)
        return false;
    struct reply reply;
    struct buffer said = {0};
    reply_init(&reply, (struct sink){swallow, keep, &said});
    reply.quiet = true;
    const bool fine = script_file(session, path, NULL, &reply) && session->execution.status == 0;
    if (!fine)
        fprintf(stderr, "%s", said.data ? said.data : "");
    buffer_free(&said);
    reply_free(&reply);
    session_destroy(session);
    return fine;
}

/* What is done only once in a process is done before the first count. */
static int play_all(char **path, int count)
{
    bool fine = play(path[0]);
    script_counted();
    for (int i = 0; fine && i < count; i++) {
        fine = play(path[i]);
        script_counted();
    }
    return !fine;
}

/* ---- the process that judges ---- */

static void put(FILE *file, const char *text, int number)
{
    for (; text && *text; text++) {
        if (*text == '#')
            fprintf(file, "%d", number);
        else
            fputc(*text, file);
    }
}

static void write_recording(int count)
{
    char path[64];
    snprintf(path, sizeof path, "rows-%d.txt", count);
    FILE *file = fopen(path, "w");
    for (int i = 0; file && i < count; i++)
        fprintf(file, "%.2f %.9f\n", i / 100.0, exp(-i / 4e4) * cos(i / 12.0));
    if (!file || fclose(file) != 0)
        abort();
}

static void write_script(const struct growth *row, int amount, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file)
        abort();
    put(file, row->first, amount + row->more);
    for (int i = 0; row->each && i < amount; i++) {
        fputc('\n', file);
        put(file, row->each, i % 97 + 1);
    }
    fputc('\n', file);
    if (fclose(file) != 0)
        abort();
    if (row->recording)
        write_recording(amount + row->more);
}

/* The instructions of the script with this number, from 2: the first is the rehearsal. */
static double counted(int number)
{
    char path[64], line[256];
    snprintf(path, sizeof path, "counts.%d", number);
    FILE *file = fopen(path, "r");
    double count = -1;
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "summary: %lf", &count) == 1)
            break;
    if (file)
        fclose(file);
    return count;
}

/* Plays the scripts under callgrind. False: it cannot, or a script failed; that has been told. */
static bool count_scripts(const char *program, char **path, int count)
{
    const pid_t child = fork();
    if (child == 0) {
        const char *command[9 + 3 * COUNT_OF(rows)] = {"valgrind",
                                                       "--tool=callgrind",
                                                       "--callgrind-out-file=counts",
                                                       "--dump-before=script_counted",
                                                       "-q",
                                                       "--log-file=said.txt",
                                                       program,
                                                       "--play"};
        for (int i = 0; i < count; i++)
            command[8 + i] = path[i];
        execvp(command[0], (char *const *)(uintptr_t)command);
        _exit(127);
    }
    int status = -1;
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

static bool wanted(const struct growth *row, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], row->name) == 0)
            return true;
    return argc <= 1;
}

static bool judge(const struct growth *row, int amount, int number, int first)
{
    const double none = counted(first), once = counted(first + 1), more = counted(first + 2);
    const double each = (once - none) / amount;
    const double times = (more - none) / (once - none);
    /* Less than an instruction for each is no measurement of anything. */
    const bool good =
        none > 0 && each >= 1 && times <= AT_MOST && !(row->each_max > 0 && each > row->each_max);
    printf("%s %d - %s: %.0f instructions each, ten times the work %.1f times as many\n",
           good ? "ok" : "not ok", number, row->name, each, times);
    return good;
}

int main(int argc, char **argv)
{
    if (argc > 2 && strcmp(argv[1], "--play") == 0)
        return play_all(argv + 2, argc - 2);
    const char *config = getenv("CONFIG");
    if ((config && strcmp(config, "asan") == 0) ||
        system("command -v valgrind >/dev/null") != 0) { /* a test may */
        puts("ok 1 - growth of instructions # SKIP no valgrind, or a build with sanitizers\n1..1");
        return 0;
    }
    static char folder[] = "/tmp/hooke-growth-XXXXXX";
    char program[4096];
    if (!realpath(argv[0], program) || !make_folder(folder) || chdir(folder) != 0)
        return 2;
    static char name[3 * COUNT_OF(rows)][64];
    char *path[3 * COUNT_OF(rows)];
    const int factor = is_long() ? 10 : 1;
    int count = 0;
    for (size_t r = 0; r < COUNT_OF(rows); r++)
        for (int part = 0; wanted(&rows[r], argc, argv) && part < 3; part++, count++) {
            snprintf(name[count], sizeof name[count], "%s-%d.hk", rows[r].name, part);
            path[count] = name[count];
            write_script(&rows[r], factor * rows[r].amount * (int[]){0, 1, 10}[part], path[count]);
        }
    if (count == 0 || !count_scripts(program, path, count)) {
        puts("not ok 1 - the scripts run under valgrind\n1..1");
        return 1;
    }
    bool good = true;
    int judged = 0;
    for (size_t r = 0; r < COUNT_OF(rows); r++)
        if (wanted(&rows[r], argc, argv)) {
            good &= judge(&rows[r], factor * rows[r].amount, judged + 1, 3 * judged + 2);
            judged++;
        }
    printf("1..%d\n", judged);
    return !good;
}
