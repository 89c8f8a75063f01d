/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Long sessions need as much memory as short ones: each kind of command is repeated, and once undo
 * levels and logs are full the heap grows no more. The long form also plays a million commands of
 * all kinds: resident memory (least squares over the last half) and time for each stay the same.
 *   memory [ROW...]
 */
#include <hooke/command.h>
#include <hooke/session/log.h>

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "long_form.h"
#include "terminal/folder.h"
#include "unit/random_testing.h"

/* '#' in `each` stands for a number that changes from line to line; lines may fail. */
struct kind {
    const char *name, *first, *each;
    int times; /* in the short form, after as many to get warm; 0: TIMES */
};

#define TIMES 450

static const struct kind rows[] = {
    {"print", "", "print 2*#", 0},
    {"set", "", "m = # g", 0},
    {"setting", "", "dt = # ms; set digits 6; unset dt", 0},
    {"method", "", "method rk4 dt=# ms; method dop853 tol=1e-7", 0},
    {"scene", "", "scene damped; scene pendulum; m = # g", 0},
    {"force", "", "force -#*y", 0},
    {"force off", "", "force -#*y; force off", 0},
    {"observe", "", "observe twice = #*t; observe twice off", 0},
    {"typed", "", "scene new own; var x = #; var z = 0; x' = z; z' = -2*x", 0},
    {"typed run", "method rk4; duration = 20 ms",
     "scene new own; var x = #; x' = -x; run; measure max; drop all", 0},
    {"param", "scene new; var q = 1; q'' = -q", "param a = #; q'' = -a*q", 0},
    {"event", "", "event top when y > # do record; event off", 0},
    {"let", "", "let A = #", 0},
    {"atol", "", "atol y = # mm; atol off", 0},
    {"run", "", "run 20 ms; drop all", 0},
    {"run typed", "force -3*y", "run 20 ms; drop all", 0},
    {"run until", "", "run until v < 0; drop all", 0},
    {"step", "run 20 ms", "step", 0},
    {"step back", "run 20 ms", "step; back", 0},
    {"continue", "run 20 ms", "continue 1 ms", 0},
    {"reset", "run 20 ms", "continue 3 ms; reset", 0},
    {"change", "run 20 ms", "change k #", 0},
    {"change step", "run 20 ms", "change k #; step", 0},
    {"kick", "run 20 ms", "change v #", 0},
    {"undo", "run 20 ms", "m = # g; change k #; undo; undo; redo", 0},
    {"checkpoint", "run 20 ms", "m = # g; checkpoint a#; restore a#", 0},
    {"name", "run 20 ms", "rename 1 a#; note 1 b#", 0},
    {"use", "run 20 ms; run 20 ms", "use 1; use 2", 0},
    {"measure", "run 10 s", "measure period; measure amplitude", 60},
    {"fit", "run 10 s", "fit damped; adopt", 60},
    {"compare", "duration = 50 ms", "compare euler verlet; drop all", 100},
    {"order", "duration = 50 ms", "order rk4", 60},
    {"sweep", "duration = 20 ms; method rk4", "sweep k=1:3:1 measure=max --threads 1", 100},
    {"plot", "run 100 ms", "plot position; describe energy", 100},
    {"export", "run 100 ms", "export a.csv --force", 100},
    {"print to file", "run 100 ms", "runs > a.csv --force", 100},
    {"save", "", "save a.hk --force", 100},
    {"source", "", "source some.hk", 0},
    {"record", "", "record r.hk; m = # g; record off", 0},
    {"load", "", "load some.txt; data drop some", 0},
    {"data", "load some.txt", "data window 0:0.#; data zero 0.1; data mass # g", 0},
    {"measure data", "load some.txt", "measure period", 60},
    {"view", "run 20 ms", "layout duo; focus energy; range x 0:#; range x auto; window # s", 0},
    {"cursor", "run 100 ms", "cursor 1 # ms; cursor off", 0},
    {"show", "run 20 ms", "show; runs; results; state; settings; help run; history 3", 100},
    {"errors", "", "m = ; nothing #", 0},
    {"wrong", "", "m = 3 s", 0},
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
        (*session)->keep_going = true;
    return *session;
}

static void play(struct session *session, struct reply *reply, const char *line, int number)
{
    char text[512];
    size_t used = 0;
    for (; *line && used + 16 < sizeof text; line++)
        used += (size_t)(*line == '#' ? snprintf(text + used, 16, "%d", number)
                                      : snprintf(text + used, 2, "%c", *line));
    command_exec(session, (struct text){text, used}, NULL, reply);
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

/* The most that the heap needs while the line is repeated. */
static double most(struct session *session, struct reply *reply, const char *line, int times)
{
    double bytes = 0;
    for (int i = 0; i < times; i++) {
        play(session, reply, line, 1 + i % 9);
        bytes = fmax(bytes, heap() - typed(session));
    }
    return bytes;
}

/* [byte] more for a repetition. */
static double growth(const struct kind *kind)
{
    struct session *session;
    struct reply reply;
    const int times = kind->times ? kind->times : TIMES;
    if (!begin(&session, &reply))
        return HUGE_VAL;
    play(session, &reply, kind->first, 0);
    most(session, &reply, kind->each, times);
    const double before = most(session, &reply, kind->each, times);
    const double more = most(session, &reply, kind->each, times) - before;
    session_destroy(session);
    reply_free(&reply);
    return more / times;
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

#include <time.h>
int main(int argc, char **argv)
{
    static char folder[] = "/tmp/hooke-growth-XXXXXX";
    if (!make_folder(folder) || chdir(folder) != 0)
        return 2;
    write_files();
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        if (wanted(&rows[i], argc, argv)) {
            struct timespec a, b;
            clock_gettime(CLOCK_MONOTONIC, &a);
            double g = growth(&rows[i]);
            clock_gettime(CLOCK_MONOTONIC, &b);
            printf("%-15s %9.1f  %g ms\n", rows[i].name, g, (double)(b.tv_sec-a.tv_sec)*1e3+(double)(b.tv_nsec-a.tv_nsec)*1e-6);
            fflush(stdout);
        }
    return 0;
}
