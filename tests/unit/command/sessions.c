/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random sessions: what is saved comes back, what is undone is as it was, what was recorded does it
 * again. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "unit/command/testing.h"
#include "unit/random_testing.h"

#include <hooke/session/events.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/session/log.h>

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
    events_save(setup->events, false, text);
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
    events_save(slot->events, true, text);
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

static void describe(const struct session *session, unsigned parts, struct buffer *text)
{
    buffer_clear(text);
    if (parts & PART_SETUP)
        put_setup(&session->setup, text);
    if (parts & PART_DISPLAY)
        put_settings(&session->setup.settings, true, text);
    for (int i = 0; i < session->recordings && (parts & PART_RECORDINGS); i++)
        put_recording(session->recording[i], text);
    for (int i = 0; i < session->runs && (parts & PART_RUNS); i++)
        put_run(session->run[i], parts, text);
    if (parts & PART_VIEW)
        put_view(&session->view, text);
    if (parts & PART_CURRENT)
        buffer_format(text, "current run %d recording %d%s\n", session->current_run,
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
        fail_msg("%s: was '%.*s', is '%.*s'", what, (int)(x.len < 300 ? x.len : 300), x.at,
                 (int)(y.len < 300 ? y.len : 300), y.at);
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
                        "observe twice off", "force -4*y; potential 2*y^2", "potential off"));
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
    const struct setting *setting = (const struct setting *)(const void *)catalog_row(
        &setting_catalog, (size_t)dice((int)setting_catalog.count));
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
                 ONE_OF("let A = 4.2 +- 0.1 cm", "let B = 1/3", "unset A", "let C1 = 2 kg",
                        "A = 3 s", "timing off", "timing full"));
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
    const int run = session->runs > 0 ? session->run[dice(session->runs)]->run->number : 1;
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
                    "data drop two", "data join off", "data mass off"));
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
    const int runs = b->session->next_run;
    const bool ok = type(b, line);
    if (ok)
        buffer_format(typed, "%s\n", line);
    else
        buffer_format(typed, "%s # fails\n", line);
    return ok || runs == b->session->next_run;
}

static void play(struct bench *b, uint64_t seed, struct buffer *typed)
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

static int sessions(void)
{
    return getenv("LONG") ? 60 : 20;
}

static void write_recordings(void)
{
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

/* ---- what has to hold ---- */

static void save(const struct session *session, void (*as)(const struct session *, struct buffer *))
{
    struct buffer text = {0};
    as(session, &text);
    assert_false(text.failed);
    write_file("saved.hk", text.data, text.len);
    buffer_free(&text);
}

/* In a new session; restoring: as the program does it with one that saved itself. */
static void read_back(struct bench *again, bool restoring, const struct buffer *typed)
{
    struct buffer content = {0};
    struct error error;
    struct text rest, line;
    assert_true(file_read("saved.hk", 1 << 20, &content, &error));
    bench_open(again, false);
    again->session->restoring = restoring;
    rest = buffer_text(&content);
    while (text_split(&rest, '\n', &line))
        if (!command_exec(again->session, line, NULL, &again->reply)) {
            fprintf(stderr, "%s\n", said(typed));
            fail_msg("saved.hk: %s", said(&again->err));
        }
    again->session->restoring = false;
    buffer_free(&content);
}

static void what_is_saved_comes_back(void **state)
{
    (void)state;
    struct buffer typed = {0}, wanted = {0}, got = {0};
    write_recordings();
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        bench_open(&b, false);
        play(&b, (uint64_t)i, &typed);
        const unsigned view = !b.session->view.focus ? PART_VIEW : 0;
        save(b.session, session_save);
        read_back(&again, false, &typed);
        describe(b.session, PART_SETUP | PART_RECORDINGS | view, &wanted);
        describe(again.session, PART_SETUP | PART_RECORDINGS | view, &got);
        assert_same(&wanted, &got, "saved", &typed);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

static void assert_step(struct bench *b, const char *statement, unsigned parts,
                        const struct buffer *wanted, const struct buffer *typed)
{
    struct buffer now = {0};
    type_ok(b, statement);
    describe(b->session, parts, &now);
    if (wanted->len > 0)
        assert_same(wanted, &now, statement, typed);
    buffer_free(&now);
}

static void a_resumed_session_is_the_same(void **state)
{
    (void)state;
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_CURRENT | PART_NOTES;
    struct buffer typed = {0}, wanted = {0}, got = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        bench_open(&b, false);
        play(&b, 2000 + (uint64_t)i, &typed);
        const unsigned view = b.session->runs > 0 || !b.session->view.focus ? PART_VIEW : 0;
        save(b.session, session_autosave);
        read_back(&again, true, &typed);
        describe(b.session, parts | view, &wanted);
        describe(again.session, parts | view, &got);
        assert_same(&wanted, &got, "resumed", &typed);
        for (int r = 0; r < b.session->runs; r++)
            if (stop_is_pause(b.session->run[r]->run->stop) &&
                !stop_is_pause(again.session->run[r]->run->stop))
                fail_msg("run %d was paused", b.session->run[r]->run->number);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

static void undo_and_redo_go_through_the_same_states(void **state)
{
    (void)state;
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_CURRENT | PART_STOPS;
    static struct buffer at[LINES * 4 + 1];
    struct buffer typed = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b;
        bench_open(&b, false);
        random_state = 1000 + (uint64_t)i;
        buffer_clear(&typed);
        /* empty: in the middle of a line */
        for (int s = 0; s <= LINES * 4; s++)
            buffer_clear(&at[s]);
        describe(b.session, parts, &at[0]);
        for (int s = 0; s < LINES; s++) {
            play_statement(&b, &typed);
            describe(b.session, parts, &at[b.session->undos]);
        }
        const int steps = b.session->undos;
        for (int s = steps; s > 0; s--)
            assert_step(&b, "undo", parts, &at[s - 1], &typed);
        for (int s = 1; s <= steps; s++)
            assert_step(&b, "redo", parts, &at[s], &typed);
        bench_close(&b);
    }
    for (size_t i = 0; i < COUNT_OF(at); i++)
        buffer_free(&at[i]);
    buffer_free(&typed);
}

static void interrupt_it(void *context, const struct run *run, double fraction)
{
    (void)run;
    if (fraction <= 1) /* 2: it is over */
        atomic_store(&((struct cancel *)context)->requested, 1);
}

/* What a person abbreviates stands in the file as it was understood; a run that ended in an error
 * is not in it, and such sessions are left out here. */
static void what_was_recorded_does_it_again(void **state)
{
    (void)state;
    const unsigned parts = PART_SETUP | PART_RECORDINGS | PART_RUNS | PART_VIEW | PART_STOPS;
    struct buffer typed = {0}, wanted = {0}, got = {0};
    for (int i = 0; i < sessions(); i++) {
        struct bench b, again;
        remove("kept.hk");
        bench_open(&b, true);
        type_ok(&b, "record kept.hk");
        type_ok(&b, "meth verlet; set kernel gen");
        play(&b, 3000 + (uint64_t)i, &typed);
        type_ok(&b, "record off");
        bench_open(&again, false);
        if (!history_fails(b.session) && !type(&again, "source kept.hk")) {
            fprintf(stderr, "%s\n", said(&typed));
            fail_msg("kept.hk: %s", said(&again.err));
        }
        describe(b.session, parts, &wanted);
        describe(again.session, parts, &got);
        if (!history_fails(b.session))
            assert_same(&wanted, &got, "recorded", &typed);
        bench_close(&again);
        bench_close(&b);
    }
    buffer_free(&typed);
    buffer_free(&wanted);
    buffer_free(&got);
}

/* An interrupted run is an error that leaves a run: the file has it as far as it went, so that what
 * goes on with it does so. */
static void an_interrupted_run_is_recorded(void **state)
{
    (void)state;
    struct cancel cancel = {0};
    struct bench b, again;
    remove("kept.hk");
    bench_open(&b, false);
    b.session->front.cancel = &cancel;
    b.session->front.context = &cancel;
    b.session->front.progress = interrupt_it;
    type_ok(&b, "record kept.hk");
    assert_false(type(&b, "dt = 1e-6; run 1000 s --force"));
    atomic_store(&cancel.requested, 0);
    type_ok(&b, "step 3");
    type_ok(&b, "record off");
    bench_open(&again, false);
    type_ok(&again, "source kept.hk");
    assert_int_equal(again.session->run[0]->run->steps, b.session->run[0]->run->steps);
    bench_close(&again);
    bench_close(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_saved_comes_back),
        cmocka_unit_test(a_resumed_session_is_the_same),
        cmocka_unit_test(undo_and_redo_go_through_the_same_states),
        cmocka_unit_test(what_was_recorded_does_it_again),
        cmocka_unit_test(an_interrupted_run_is_recorded),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
