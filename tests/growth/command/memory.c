/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Long sessions need as much memory as short ones: each kind of command is repeated, and once undo
 * levels and logs are full the heap grows no more. The long form also plays a million commands of
 * all kinds: resident memory (least squares over the last half) and time for each stay the same.
 *   memory [KIND...]
 */
#include <hooke/command.h>
#include <hooke/session/log.h>

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "long_form.h"
#include "terminal/folder.h"
#include "unit/random_testing.h"

/* '#' in `each` stands for a number that changes from line to line. */
struct kind {
    const char *name, *first, *each; /* first: once, may be NULL */
    int times;                       /* it is repeated, after as many to get warm; 0: TIMES */
    double at_most;                  /* [byte] a repetition; 0: AT_MOST */
    bool fails;
};

#define TIMES 450
#define AT_MOST 64 /* [byte] the heap's own rounding over a window */
/* [byte] what a run keeps of each thing that was asked of it, up to LIMIT_REQUESTS, and of each
 * change of parameters, up to LIMIT_CHANGES */
#define OF_REQUEST 300
#define OF_CHANGE 32000

static const struct kind rows[] = {
    {.name = "print", .each = "print 2*#"},
    {.name = "set", .each = "m = # g"},
    {.name = "setting", .each = "dt = # ms; set digits 6; unset dt"},
    {.name = "method", .each = "method rk4 dt=# ms; method dop853 tol=1e-7"},
    {.name = "scene", .each = "scene damped; scene pendulum; m = # g"},
    {.name = "force", .each = "force -#*y"},
    {.name = "force off", .each = "force -#*y; force off"},
    {.name = "observe", .each = "observe twice = #*t; observe twice off"},
    {.name = "typed", .each = "scene new own; var x = #; var z = 0; x' = z; z' = -2*x"},
    {.name = "typed run",
     .first = "method rk4; duration = 20 ms",
     .each = "scene new own; var x = #; x' = -x; run; print x; drop all",
     .times = 220},
    {.name = "param", .first = "scene new; var q = 1; q'' = -q", .each = "param a = #; q'' = -a*q"},
    {.name = "event", .each = "event top when y > # do record; event off"},
    {.name = "let", .each = "let A = #"},
    {.name = "atol", .each = "atol y = # mm; atol off"},
    {.name = "run", .each = "run 20 ms; drop all"},
    {.name = "run typed", .first = "force -3*y", .each = "run 20 ms; drop all"},
    {.name = "run until", .each = "run until v < 0; drop all"},
    {.name = "step", .first = "run 20 ms", .each = "step"},
    {.name = "step back", .first = "run 20 ms", .each = "step; back", .at_most = OF_REQUEST},
    {.name = "continue", .first = "run 20 ms", .each = "continue 1 ms", .at_most = OF_REQUEST},
    {.name = "reset", .first = "run 20 ms", .each = "continue 3 ms; reset", .at_most = OF_REQUEST},
    {.name = "change", .first = "run 20 ms", .each = "change k #", .at_most = 3 * OF_REQUEST},
    {.name = "change step", .first = "run 20 ms", .each = "change k #; step", .at_most = OF_CHANGE},
    {.name = "kick", .first = "run 20 ms", .each = "change v #", .at_most = OF_REQUEST},
    {.name = "undo", .first = "run 20 ms", .each = "m = # g; change k #; undo; undo; redo"},
    {.name = "checkpoint", .first = "run 20 ms", .each = "m = # g; checkpoint a#; restore a#"},
    {.name = "name", .first = "run 20 ms", .each = "rename 1 a#; note 1 b#"},
    {.name = "use", .first = "run 20 ms; run 20 ms", .each = "use 1; use 2"},
    {.name = "measure",
     .first = "run 100 ms",
     .each = "measure energy; measure drift",
     .times = 516},
    {.name = "fit", .first = "run 10 s", .each = "fit damped; adopt", .times = 10},
    {.name = "compare",
     .first = "duration = 50 ms",
     .each = "compare euler verlet; drop all",
     .times = 150},
    {.name = "order", .first = "duration = 50 ms", .each = "order rk4", .times = 30},
    {.name = "sweep",
     .first = "duration = 20 ms; method rk4",
     .each = "sweep k=1:3:1 measure=max --threads 1",
     .times = 30},
    {.name = "plot", .first = "run 100 ms", .each = "plot position; describe energy", .times = 100},
    {.name = "export", .first = "run 100 ms", .each = "export a.csv --force", .times = 100},
    {.name = "print to file", .first = "run 100 ms", .each = "runs > a.csv --force", .times = 100},
    {.name = "save", .each = "save a.hk --force", .times = 60},
    {.name = "source", .each = "source some.hk"},
    {.name = "record", .each = "record r.hk; m = # g; record off"},
    {.name = "load", .each = "load some.txt; data drop some", .times = 200},
    {.name = "data",
     .first = "load some.txt",
     .each = "data window 0:0.#; data zero 0.1; data mass # g",
     .times = 200},
    {.name = "measure data", .first = "load some.txt", .each = "measure period", .times = 1030},
    {.name = "view",
     .first = "run 20 ms",
     .each = "layout duo; focus energy; range x 0:#; range x auto; window # s"},
    {.name = "cursor", .first = "run 100 ms", .each = "cursor A # ms; cursor off"},
    {.name = "show",
     .first = "run 20 ms",
     .each = "show; runs; list limits; help run; history 3",
     .times = 100},
    {.name = "errors", .each = "m = ; nothing #", .fails = true},
    {.name = "wrong", .each = "m = 3 s", .fails = true},
};

/* ---- a session ---- */

static bool swallow(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool begin(struct session **session, struct reply *reply)
{
    static const struct front front = {.interactive = false};
    reply_init(reply, (struct sink){swallow, swallow, NULL});
    *session = session_create(&front);
    if (*session)
        (*session)->options.keep_going = true;
    return *session;
}

static bool play(struct session *session, struct reply *reply, const char *line, int number)
{
    char text[512];
    size_t used = 0;
    for (; *line && used + 16 < sizeof text; line++)
        used += (size_t)(*line == '#' ? snprintf(text + used, 16, "%d", number)
                                      : snprintf(text + used, 2, "%c", *line));
    return command_exec(session, (struct text){text, used}, NULL, reply);
}

static void play_first(struct session *session, struct reply *reply, const struct kind *kind)
{
    if (kind->first)
        play(session, reply, kind->first, 0);
}

static double heap(void)
{
    const struct mallinfo2 all = mallinfo2();
    return (double)(all.uordblks + all.hblkhd);
}

/* What was typed is kept, too, up to a bound that is reached later. */
static double typed(const struct session *session)
{
    const struct history *log = &session->history;
    return (double)(log->capacity * sizeof *log->entry + log->text.cap);
}

/* Returns the largest size [byte] of the heap while the line is repeated, without the log of typed
 * lines, or NAN if a repetition does not end as expected. */
static double most(struct session *session, struct reply *reply, const struct kind *kind)
{
    const int times = kind->times ? kind->times : TIMES;
    double bytes = 0;
    for (int i = 0; i < times; i++) {
        if (play(session, reply, kind->each, 1 + i % 9) == kind->fails)
            return NAN;
        bytes = fmax(bytes, heap() - typed(session));
    }
    return bytes;
}

/* Returns the growth of the heap [byte] for each repetition of a command, after it was repeated
 * until its memory is warm. Returns NAN if a command does not end as expected. */
static double growth(const struct kind *kind)
{
    struct session *session;
    struct reply reply;
    if (!begin(&session, &reply))
        return NAN;
    play_first(session, &reply, kind);
    const double warm = most(session, &reply, kind), before = most(session, &reply, kind),
                 more = most(session, &reply, kind) - before;
    session_destroy(session);
    reply_free(&reply);
    return (more + 0 * warm) / (kind->times ? kind->times : TIMES);
}

/* ---- all kinds ---- */

#define COMMANDS 1000000
#define SLOPE 1.0  /* [byte] a command, of resident memory */
#define SLOWER 1.5 /* times as much time as in the second tenth */

static double resident(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    long all = 0, pages = 0;
    const bool read = file && fscanf(file, "%ld %ld", &all, &pages) == 2;
    if (file)
        fclose(file);
    return read ? (double)pages * (double)sysconf(_SC_PAGESIZE) : NAN;
}

/* Plays command i of a long random session: any of the kinds, those with few repetitions (slow
 * ones) seldom, and at times a scene in which all kinds work. */
static void play_any(struct session *session, struct reply *reply, int i)
{
    const struct kind *kind = &rows[(int)(random_uniform() * (double)COUNT_OF(rows))];
    if (i % 100 == 0)
        play(session, reply, "drop all", 0);
    else if (i % 40 == 0)
        play(session, reply, "scene spring; method euler; dt = 10 ms; duration = 40 ms", 0);
    else if (i % 20 == 0)
        play_first(session, reply, kind);
    else if (kind->times == 0 || random_uniform() < 0.02)
        play(session, reply, kind->each, 1 + (int)(random_uniform() * 9));
    else
        play(session, reply, "print 2", 0);
}

/* Slope of the last half by least squares, and processor time of the last tenth over that of the
 * second. */
static bool judge_all(int number)
{
    enum { PARTS = 1000 };
    static double memory[PARTS];
    double tenth[10] = {0}, sum = 0, cross = 0, square = 0;
    struct session *session;
    struct reply reply;
    if (!begin(&session, &reply))
        return false;
    for (int part = 0; part < PARTS; part++) {
        const clock_t begun = clock();
        for (int i = 0; i < COMMANDS / PARTS; i++)
            play_any(session, &reply, i);
        tenth[part / (PARTS / 10)] += (double)(clock() - begun) / CLOCKS_PER_SEC;
        memory[part] = resident();
    }
    for (int part = PARTS / 2; part < PARTS; part++)
        sum += memory[part];
    for (int part = PARTS / 2; part < PARTS; part++) {
        const double x = part - 0.75 * PARTS + 0.5;
        cross += x * (memory[part] - sum / (PARTS / 2.0));
        square += x * x;
    }
    const double slope = cross / square / (COMMANDS / (double)PARTS), slower = tenth[9] / tenth[1];
    const bool good = slope < SLOPE && slower < SLOWER;
    printf("%s %d - %d commands of all kinds: %.3f byte each of %.1f MB, the last tenth takes %.2f "
           "times the second's %.1f s\n",
           good ? "ok" : "not ok", number, COMMANDS, slope, memory[PARTS - 1] / 1e6, slower,
           tenth[1]);
    session_destroy(session);
    reply_free(&reply);
    return good;
}

static bool wanted(const struct kind *row, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], row->name) == 0)
            return true;
    return argc <= 1;
}

static void write_files(void)
{
    FILE *recording = fopen("some.txt", "w"), *script = fopen("some.hk", "w");
    if (!recording || !script)
        abort();
    for (int i = 0; i < 200; i++)
        fprintf(recording, "%.3f %.6f\n", i / 100.0, cos(i / 5.0));
    fputs("m = 3 g\nlet A = 3\n", script);
    if (fclose(recording) != 0 || fclose(script) != 0)
        abort();
}

int main(int argc, char **argv)
{
    static char folder[] = "/tmp/hooke-growth-XXXXXX";
    const char *config = getenv("CONFIG");
    if (config && strcmp(config, "asan") == 0) {
        puts("ok 1 - growth of memory # SKIP a build with sanitizers has a heap of its own\n1..1");
        return 0;
    }
    if (!make_folder(folder) || chdir(folder) != 0)
        return 2;
    write_files();
    bool good = true;
    int judged = 0;
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        if (!wanted(&rows[i], argc, argv))
            continue;
        const double more = growth(&rows[i]);
        const bool fits = more <= (rows[i].at_most > 0 ? rows[i].at_most : AT_MOST);
        printf("%s %d - %s: %.1f byte a repetition\n", fits ? "ok" : "not ok", ++judged,
               rows[i].name, more);
        good &= fits;
    }
    if (is_long() && argc <= 1)
        good &= judge_all(++judged);
    printf("1..%d\n", judged);
    return !good;
}
