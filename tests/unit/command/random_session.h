/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random sessions, and a session as text. Included after <cmocka.h>. */
#pragma once

#include "unit/command/testing.h"
#include "unit/random_testing.h"

#include <hooke/data.h>
#include <hooke/session/events.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/session/log.h>

struct row;

enum { LINES = 40 }; /* of a session, of at most 4 statements */

/* ---- a session as text: every field on a line ---- */

enum parts {
    PART_SETUP = 1,
    PART_DISPLAY = 2,
    PART_RECORDINGS = 4,
    PART_RUNS = 8,
    PART_VIEW = 16,
    PART_CURRENT = 32,
    PART_NOTES = 64,  /* undo leaves them as they are */
    PART_STOPS = 128, /* why runs ended */
};

static void put_real(struct buffer *text, double value)
{
    buffer_format(text, " %a", value);
}

static void put_scene(const struct scene *scene, struct buffer *text)
{
    buffer_format(text, "scene %s\n", scene->preset->row.name);
    scene_script(scene, "\n", text);
    for (size_t i = 0; i < scene_params(scene)->count; i++) {
        buffer_format(text, "%s%s", catalog_row(scene_params(scene), i)->name,
                      scene->chosen[i] ? " (given)" : "");
        put_real(text, scene->value[i]);
        put_real(text, scene->uncertainty[i]);
        buffer_char(text, '\n');
    }
    atol_script(scene, "\n", text);
}

static void put_settings(const struct settings *settings, bool display, struct buffer *text)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        if (setting->display != display)
            continue;
        buffer_format(text, "%s%s", setting->row.name,
                      setting_is_chosen(setting, settings) ? " (given) " : " ");
        setting_exact(setting, settings, text);
        buffer_char(text, '\n');
    }
}

static void put_setup(const struct setup *setup, struct buffer *text)
{
    put_scene(&setup->scene, text);
    buffer_format(text, "method %s%s drag %d%s\n", setup->method->row.name,
                  setup->method_chosen ? " (chosen)" : "", (int)setup->drag,
                  setup->fixed ? " fixed" : "");
    put_settings(&setup->settings, false, text);
    events_save(setup->events, text);
    for (int i = 0; i < setup->lets; i++) {
        buffer_format(text, "let %s %d", setup->let[i].name, (int)setup->let[i].quantity);
        put_real(text, setup->let[i].value);
        put_real(text, setup->let[i].uncertainty);
        buffer_char(text, '\n');
    }
}

static void put_recording(const struct recording_slot *slot, struct buffer *text)
{
    const struct recording *recording = slot->recording;
    buffer_format(text, "recording %s joined '%s'%s", recording->name, recording->velocity,
                  recording->cleaned ? " cleaned" : "");
    put_real(text, recording->window[0]);
    put_real(text, recording->window[1]);
    put_real(text, recording->zero);
    put_real(text, recording->mass.value);
    put_real(text, recording->mass.uncertainty);
    buffer_char(text, '\n');
}

static void put_run(const struct run_slot *slot, unsigned parts, struct buffer *text)
{
    const struct run *run = slot->run;
    const size_t rows = trace_count(run->trace);
    buffer_format(text, "run %d '%s' '%s' %s %s step %lld rows %zu drag %d\n", run->number,
                  run->name, parts & PART_NOTES && slot->note ? slot->note : "",
                  run->method->row.name, parts & PART_STOPS ? stop_name(run->stop) : "",
                  (long long)run->steps, rows, (int)run->settings.drag);
    for (size_t i = 0; i < rows; i += 1 + rows / 50) {
        put_real(text, trace_time(run->trace, i));
        put_real(text, trace_state(run->trace, i)[0]);
    }
    put_real(text, run->t);
    for (int i = 0; i < run->system.n; i++)
        put_real(text, run->y[i]);
    buffer_char(text, '\n');
    events_save(slot->events, text);
}

static void put_view(const struct view *view, struct buffer *text)
{
    buffer_format(text, "view %d %s %d", (int)view->layout, view->focus ? view->focus->name : "",
                  view->full);
    const double reals[] = {view->x[0], view->x[1],   view->y[0],
                            view->y[1], view->window, view->trail};
    for (size_t i = 0; i < COUNT_OF(reals); i++)
        put_real(text, isnan(reals[i]) ? -1.25 : reals[i]);
    buffer_char(text, '\n');
}

static inline void describe(const struct session *session, unsigned parts, struct buffer *text)
{
    buffer_clear(text);
    if (parts & PART_SETUP)
        put_setup(&session->setup, text);
    if (parts & PART_DISPLAY)
        put_settings(&session->setup.settings, true, text);
    for (int i = 0; i < session->recordings && (parts & PART_RECORDINGS); i++)
        put_recording(session->recording[i], text);
    for (int i = 0; i < session->runs.count && (parts & PART_RUNS); i++)
        put_run(session->runs.slot[i], parts, text);
    if (parts & PART_VIEW)
        put_view(&session->view, text);
    if (parts & PART_CURRENT)
        buffer_format(text, "current run %d recording %d%s\n", session->runs.current,
                      session->current_recording, session->data_is_latest ? " (latest)" : "");
    assert_false(text->failed);
}

static void assert_same(const struct buffer *wanted, const struct buffer *got, const char *what,
                        const struct buffer *session)
{
    struct text a = buffer_text(wanted), b = buffer_text(got), x = {0}, y = {0};
    while (text_equal(x, y) && (a.len > 0 || b.len > 0)) {
        x = y = TEXT("");
        text_split(&a, '\n', &x);
        text_split(&b, '\n', &y);
    }
    if (!text_equal(x, y)) {
        fprintf(stderr, "%s\n", said(session));
        fail_msg("%s: was '%.*s', is '%.*s'", what, (int)(x.len < 300 ? x.len : 300), x.data,
                 (int)(y.len < 300 ? y.len : 300), y.data);
    }
}

/* ---- random statements ---- */

static int dice(int count)
{
    return (int)(random_uniform() * count);
}

static const char *one_of(const char *const *words, size_t count)
{
    return words[dice((int)count)];
}

#define ONE_OF(...)                                                                                \
    one_of((const char *const[]){__VA_ARGS__}, COUNT_OF(((const char *const[]){__VA_ARGS__})))

static const char *any_row(const struct catalog *catalog)
{
    return catalog_row(catalog, (size_t)dice((int)catalog->count))->name;
}

static void random_scene(char *line, size_t size)
{
    const struct row *param = NULL;
    switch (dice(6)) {
    case 0:
        snprintf(line, size, "scene %s",
                 ONE_OF("spring", "damped", "drag", "dry-friction", "driven", "duffing",
                        "vanderpol", "pendulum", "kepler"));
        break;
    case 1:
        snprintf(line, size, "%s",
                 ONE_OF("scene new own; var x = 1.5; var z = 0; x' = z; z' = -2*x",
                        "scene new; var q = 0.3; q'' = -q", "param stiff = 40; force -stiff*y^3",
                        "force -3*y + 0.1*cos(2*t)", "force off", "observe twice = 2*t",
                        "observe twice off", "force -4*y; potential 2*y^2", "potential off",
                        "param k = 3.0(1); param b = 2", "var z = 1; z' = -z", "param b off"));
        break;
    case 2:
        snprintf(line, size, "%s",
                 ONE_OF("event top when v falling do record", "event at when t > 0.7 do stop",
                        "event kick when t > 0.31 do 'k = 21; continue'", "event top off",
                        "event off"));
        break;
    case 3:
        snprintf(line, size, "%s",
                 ONE_OF("atol y = 0.01 mm", "atol x = 1e-9", "atol off", "unset m", "unset k",
                        "T0 = 0.7 s", "m = 210 +- 0.3 g", "y0 = 1/3", "unset y0"));
        break;
    default:
        param = catalog_row(&param_catalog, (size_t)dice((int)param_catalog.count));
        snprintf(line, size, "%s = %.17g", param->name, 0.1 + 3 * random_uniform());
    }
}

static void random_setting(char *line, size_t size)
{
    const struct setting *setting = setting_at((size_t)dice((int)setting_catalog.count));
    switch (dice(6)) {
    case 0:
        snprintf(line, size, "unset %s", setting->row.name);
        break;
    case 1:
        snprintf(line, size, "method %s%s", any_row(&method_catalog),
                 ONE_OF("", " dt=7 ms", " dt=1/70", " tol=3e-7", " drag=implicit"));
        break;
    case 2:
        snprintf(line, size, "%s",
                 ONE_OF("let A = 4.2 +- 0.1 cm", "let B = 1/3", "let k = 5", "unset A",
                        "let C1 = 2 kg", "A = 3 s", "timing off", "timing full"));
        break;
    default:
        /* How many values are computed is left alone: they could take long. */
        if (setting->choices && setting->choices != &opinion_catalog &&
            setting->choices != &format_choice_catalog && !setting->parse)
            snprintf(line, size, "set %s %s", setting->row.name, any_row(setting->choices));
        else
            snprintf(line, size, "%s",
                     ONE_OF("set record every 3", "set record every 30 ms", "set record all",
                            "duration = 1.3 s", "dt = 3 ms", "tol = 1e-7", "tol = off",
                            "set digits 9", "set size 40x12", "set fps 5", "opinion = off"));
    }
}

static void random_run(const struct session *session, char *line, size_t size)
{
    const int run =
        session->runs.count > 0 ? session->runs.slot[dice(session->runs.count)]->run->number : 1;
    switch (dice(9)) {
    case 0:
        snprintf(line, size, "continue %.3f s", random_uniform());
        break;
    case 1:
        snprintf(line, size, "step %d", 1 + dice(5));
        break;
    case 2:
        snprintf(line, size, "back %d", 1 + dice(5));
        break;
    case 3:
        snprintf(line, size, "%s",
                 ONE_OF("reset", "continue", "run until y < 0", "run 1 s --steps 7",
                        "continue until v > 0", "compare euler verlet dt=20ms"));
        break;
    case 4:
        snprintf(line, size, "change %s %.6g", ONE_OF("k", "gamma", "m", "mu", "v", "y"),
                 0.1 + random_uniform());
        break;
    case 5:
        snprintf(line, size, "use %d", run);
        break;
    case 6:
        if (dice(2))
            snprintf(line, size, "rename %d %s", run, ONE_OF("a1", "a2", "b1"));
        else
            snprintf(line, size, "%s %d", ONE_OF("note", "drop"), run);
        break;
    default:
        snprintf(line, size, "run %.3f s", 0.05 + random_uniform());
    }
}

static void random_recording(char *line, size_t size)
{
    snprintf(line, size, "%s",
             ONE_OF("load swing.txt as=one", "load speed.txt as=two", "data window 1:4",
                    "data window 0.5:7.25", "data zero 0.2", "data mass 200 +- 0.1 g",
                    "data use one", "data use two", "data join two", "data clean apply",
                    "data drop two", "data join off", "data mass off", "zero", "data restore",
                    "calibrate y 20 cm 15 cm at=0:0.04,0.34:0.38",
                    "calibrate y 19.6 cm 20 cm 39.1 cm 40 cm", "calibrate off"));
}

static void random_view(char *line, size_t size)
{
    switch (dice(4)) {
    case 0:
        snprintf(line, size, "layout %s", any_row(&layout_catalog));
        break;
    case 1:
        snprintf(line, size, "focus %s%s", any_row(&plot_catalog), ONE_OF("", " full", " shared"));
        break;
    default:
        snprintf(line, size, "%s",
                 ONE_OF("window 5 s", "window auto", "trail 3", "trail all", "trail 2",
                        "range x 0:1.5", "range x auto", "range y -0.1:0.2", "range y auto"));
    }
}

static void random_statement(const struct session *session, char *line, size_t size)
{
    const int kind = dice(20);
    if (kind < 6)
        random_scene(line, size);
    else if (kind < 11)
        random_setting(line, size);
    else if (kind < 16)
        random_run(session, line, size);
    else if (kind < 18)
        random_recording(line, size);
    else
        random_view(line, size);
}

/* Every statement that succeeds stands in `typed`; the others have changed nothing or are not
 * wanted. False: the session got into a state that is not followed (a run that failed half way). */
static bool play_statement(struct bench *b, struct buffer *typed)
{
    char line[160];
    random_statement(b->session, line, sizeof line);
    const int runs = b->session->runs.next_number;
    const bool ok = type(b, line);
    if (ok)
        buffer_format(typed, "%s\n", line);
    else
        buffer_format(typed, "%s # fails\n", line);
    return ok || runs == b->session->runs.next_number;
}

static inline void play(struct bench *b, uint64_t seed, struct buffer *typed)
{
    random_state = seed;
    buffer_clear(typed);
    if (dice(2)) {
        type_ok(b, "load swing.txt as=one; load speed.txt as=two");
        buffer_put(typed, TEXT("load swing.txt as=one; load speed.txt as=two\n"));
    }
    for (int i = 0; i < LINES; i++)
        play_statement(b, typed);
}

static inline const char *study_or_result(void)
{
    return ONE_OF("measure period", "fit damped", "measure amplitude", "fit sine", "order rk4",
                  "print 2*y", "fit scene k", "note good", "duration = 3 ms; run until v > 0",
                  "undo", "undo; redo", "checkpoint a", "checkpoint a; restore a",
                  "load swing.txt as=one; scene spring; fit sine; adopt",
                  "scene new; var x = 2; var z = 0; x' = z; z' = (1-x^2)*z-x; orbit; use orbit 1",
                  "scene new; var x = 0.5; param r = -1; x' = r*x-x^3; equilibria; branch r=-2:2",
                  "load scene pulse.ode", "load scene pulse.ode set=high; run 0.2 s",
                  "scene spring; run 2 s; fit drag", "measure decay", "measure period of v",
                  "compare euler rk4 dt=20ms", "fit a*cos(w*t)+c w=8.7",
                  "fit a*cos(w*t)+c w=8.7 --bootstrap 3", "measure frequency windows=2",
                  "load swing.txt as=one; data window 0:4; fit damped; adopt; run 0.3 s",
                  "event top when v falling do record; run 2 s; list events");
}

/* What looks, draws, writes files and reads them. */
static inline const char *other_command(void)
{
    return ONE_OF("plan", "show", "runs",
                  "scene new; var x = 0.5; var z = 0; x' = z; z' = -x - z; equilibria",
                  "use equilibrium 1", "scene spring; lyapunov over 5 s",
                  "lyapunov of y window=0:1", "scene damped; basins y=-0.1:0.1:0.05 v=-1:1:0.5",
                  "stability", "sweep k=1:3:1 measure=max --threads 1", "cursor A 0.1 s",
                  "cursor off", "plot position", "describe energy", "zoom 2", "pan 0.1 s",
                  "overlay all", "overlay off", "export e.csv --force", "echo hello",
                  "save s.hk --force", "source s.hk", "history 3", "help run", "apropos energy",
                  "list limits", "speed 2", "param own = 3", "observe two = 2*t",
                  "start y=0.02,v=0.1", "start clear; start v=0.3; plot portrait",
                  "export scene a.c --force", "export scene a.py --force",
                  "export scene a.m --force", "export scene a.ode --force",
                  "export scene a.tex --force", "export scene a.ode --force; load scene a.ode",
                  "scene damped; export scene a.ode --force; load scene a.ode; run 0.2 s",
                  "export e.csv data --force", "run 0.1 s; export e.csv table --force",
                  "export e.csv events --force", "export e.csv measurements --force",
                  "export e.json t,y every=2 --force", "plot position > p.svg --force",
                  "run 0.1 s; list runs > r.csv --force", "data", "data restore", "data clean",
                  "load swing.txt --preview", "describe phase", "plot v against y",
                  "cursor A 0.1 s; cursor B 0.2 s", "cursor next", "show all", "list recordings",
                  "measure period; list measurements", "calibrate",
                  "calibrate y 20 cm 15 cm at=0:0.04,0.34:0.38", "data clean apply; data restore");
}

/* Recordings, and a scene of XPPAUT. */
static void write_recordings(void)
{
    static const char pulse[] = "par k=20,b=0.1\nx'=v\nv'=-k*x-b*v\naux e=v^2/2\n"
                                "init x=0.1\nglobal 1 {x-0.05} {v=0.9*v}\nset high {k=40}\n"
                                "@ total=2,dt=0.01,meth=rk4\ndone\n";
    write_file("pulse.ode", pulse, sizeof pulse - 1);
    for (int speed = 0; speed < 2; speed++) {
        struct buffer text = {0};
        buffer_format(&text, "time\t%s\ns\t%s\n", speed ? "velocity" : "distance",
                      speed ? "cm/s" : "cm");
        for (int i = 0; i < 400; i++)
            buffer_format(&text, "%.2f\t%.4f\n", 0.02 * i,
                          speed ? -43.3 * sin(8.66 * 0.02 * i) : 20 + 5 * cos(8.66 * 0.02 * i));
        write_file(speed ? "speed.txt" : "swing.txt", text.data, text.len);
        buffer_free(&text);
    }
}
