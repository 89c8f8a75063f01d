/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is offered at the prompt: the lab in few keys, counted, with its results; an Enter that was
 * typed before it could be seen takes nothing. */
#include "cmocka_testing.h"

#include <limits.h>

#include "terminal/person.h"

#include <hooke/base/file.h>
#include <hooke/module.h>

#define KEYS_WANTED 320
#define PROMPT "hooke> "

static char home[PATH_MAX]; /* the source tree */

static void copy(const char *name)
{
    char from[PATH_MAX + 64];
    struct buffer text = {0};
    struct error error;
    snprintf(from, sizeof from, "%s/examples/lab/%s", home, name);
    assert_true(file_read(from, 1u << 22, &text, &error));
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(text.data, 1, text.len, file), text.len);
    fclose(file);
    buffer_free(&text);
}

static void in_folder(char *folder)
{
    static char hooke[2 * PATH_MAX];
    if (!*home) {
        assert_non_null(getcwd(home, sizeof home));
        const char *path = getenv("HOOKE") ? getenv("HOOKE") : "build/hooke";
        snprintf(hooke, sizeof hooke, "%s%s%s", *path == '/' ? "" : home, *path == '/' ? "" : "/",
                 path);
        setenv("HOOKE", hooke, 1);
    }
    assert_non_null(make_folder(folder));
    assert_int_equal(chdir(folder), 0);
    copy("bare.txt");
    copy("disk.txt");
}

/* Waits until the prompt stands at the end of what was sent since `from`. */
static void await_prompt(struct person *p, size_t from)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    const size_t len = strlen(PROMPT);
    for (;;) {
        const char *sent = p->raw.data ? p->raw.data : "";
        const char *line = p->raw.len > from ? strchr(sent + from, '\n') : NULL;
        if ((line || from == 0) && p->raw.len >= from + len &&
            memcmp(sent + p->raw.len - len, PROMPT, len) == 0) {
            return;
        }
        if (clock_ns() > deadline || p->hung_up) {
            show_screen(p);
            fail_msg("no prompt");
        }
        pump(p, 200);
    }
}

/* A line of a file of keys, with its keys as the terminal sends them; returns how many. */
static int keys_of(struct text line, struct buffer *keys)
{
    int count = 0;
    for (buffer_clear(keys); line.len > 0; count++) {
        size_t len = 1;
        if (text_starts(line, TEXT("<Tab>"))) {
            len = 5;
            buffer_char(keys, '\t');
        } else if (text_starts(line, TEXT("<Enter>"))) {
            len = 7;
            buffer_char(keys, '\r');
        } else {
            buffer_char(keys, line.data[0]);
        }
        line = (struct text){line.data + len, line.len - len};
    }
    return count;
}

static void test_lab(void **state)
{
    (void)state;
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    struct buffer script = {0}, keys = {0};
    struct error error;
    int all = 0;
    size_t begun = 0;
    assert_true(file_read("tests/terminal/lab.keys", 1u << 16, &script, &error));
    in_folder(folder);
    begin(&p,
          (struct start){.argument = {"--plain", "--color", "never"}, .width = 120, .height = 40});
    await_prompt(&p, 0);
    struct text rest = buffer_text(&script), line;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        char wanted[200];
        snprintf(wanted, sizeof wanted, "%.*s", line.len > 2 ? (int)line.len - 2 : 0,
                 line.data + 2);
        if (line.len == 0 || line.data[0] == '#') {
            begun = p.raw.len;
        } else if (line.data[0] == '?') {
            if (!strstr(p.raw.data + begun, wanted)) {
                fail_msg("'%s' is not in %s", wanted, p.raw.data + begun);
            }
        } else if (line.data[0] == '!') {
            assert_int_equal(access(wanted, F_OK), 0);
        } else {
            const size_t before = p.raw.len;
            all += keys_of(line, &keys);
            type(&p, buffer_view(&keys));
            await_prompt(&p, before);
        }
    }
    assert_null(strstr(p.raw.data, "error: "));
    print_message("# the lab takes %d keys\n", all);
    assert_true(all <= KEYS_WANTED);
    quit(&p);
    buffer_free(&script);
    buffer_free(&keys);
    assert_int_equal(chdir(home), 0);
}

/* Of what was not seen nothing is executed: lines pasted into a terminal that does not mark pastes
 * may be empty; after another line, and after an error, there is another offer or none. */
static void test_unseen(void **state)
{
    (void)state;
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    in_folder(folder);
    begin(&p,
          (struct start){.argument = {"--plain", "--color", "never"}, .width = 120, .height = 40});
    await_prompt(&p, 0);
    type(&p, "\r\rload bare.txt\r\r\rprint 7*13\r");
    while (!p.raw.data || !strstr(p.raw.data, "91\r")) {
        assert_true(pump(&p, 20000));
    }
    await_prompt(&p, 1);
    assert_null(strstr(p.raw.data, "T = "));
    assert_null(strstr(p.raw.data, "position data bare;")
                    ? strstr(strstr(p.raw.data, "position data bare;") + 1, "autocorrelation")
                    : NULL);
    size_t before = p.raw.len;
    type(&p, "nonsense\r");
    await_prompt(&p, before);
    before = p.raw.len;
    type(&p, "\r");
    await_prompt(&p, before);
    assert_null(strstr(p.raw.data + before, "T = "));
    before = p.raw.len;
    type(&p, "set format json\r");
    await_prompt(&p, before);
    assert_null(strstr(p.raw.data + before, "next (Enter)"));
    before = p.raw.len;
    type(&p, "\r");
    await_prompt(&p, before);
    assert_null(strstr(p.raw.data + before, "period"));
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

/* An offer that was passed over or not taken does not come again. */
static void test_passed_over(void **state)
{
    (void)state;
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    in_folder(folder);
    begin(&p,
          (struct start){.argument = {"--plain", "--color", "never"}, .width = 120, .height = 40});
    await_prompt(&p, 0);
    static const struct {
        const char *line, *offer;
    } steps[] = {
        {"load bare.txt\r", "next (Enter): plot position data bare; measure period"},
        {"print 7*13\r", NULL},
        {"measure period\r", "next (Enter): fit damped"},
        {"m = 200 g; fit damped\r", "next (Enter): adopt"},
        {"print 7*13\r", NULL},
        {"adopt\r", "next (Enter): method euler"},
        {"run 10 s\r", "next (Enter): plot position; plot velocity; plot phase"},
        {"compare euler verlet\r", NULL},
        {"print 7*13\r", NULL},
        {"fit damped\r", "next (Enter): adopt"}, /* again */
        {"load bare.txt\r", "next (Enter): plot position data"},
    };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        const size_t before = p.raw.len;
        type(&p, steps[i].line);
        await_prompt(&p, before);
        const char *shown = strstr(p.raw.data + before, "next (Enter)");
        if (steps[i].offer ? !shown || strncmp(shown, steps[i].offer, strlen(steps[i].offer)) != 0
                           : shown != NULL)
            fail_msg("%s: %.80s", steps[i].line, shown ? shown : "no offer");
    }
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

/* What is long is read on the whole screen: to its end, where the offer stands. A page is turned
 * once: a blank too many would be typed ahead, and then nothing is offered. `asks`: an Enter at the
 * end asks for the offer, once. */
static void read_to_offer(struct person *p, const char *offer, bool asks)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    struct buffer row = {0}, last = {0}, turned = {0};
    while (!shows(p, offer) && clock_ns() < deadline) {
        pump(p, 200);
        prompt_row(p, &row);
        /* on a slow machine a page comes in pieces: what stands still is all of it */
        const bool still = text_is(buffer_text(&last), row.data);
        const bool pages = strstr(row.data, "% (space") && !text_is(buffer_text(&turned), row.data);
        buffer_clear(&last);
        buffer_put(&last, text_of(row.data));
        if (still && pages) {
            buffer_clear(&turned);
            buffer_put(&turned, text_of(row.data));
            type(p, " ");
        } else if (still && asks && !shows(p, offer)) {
            asks = false;
            type(p, "\r");
        }
    }
    buffer_free(&row);
    buffer_free(&last);
    buffer_free(&turned);
    expect(p, offer);
}

static void await_offer(struct person *p, const char *offer)
{
    read_to_offer(p, offer, false);
}

/* Takes what is offered; what is next is offered after another Enter. */
static void take_offer(struct person *p, const char *next)
{
    type(p, "\r");
    read_to_offer(p, next, true);
}

static void test_panes(void **state)
{
    (void)state;
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    in_folder(folder);
    start_panes(&p, (struct start){.width = 80, .height = 24});
    enter(&p, "load bare.txt");
    await_offer(&p, "next (Enter): plot position");
    take_offer(&p, "next (Enter): measure amplitude");
    take_offer(&p, "next (Enter): fit damped");
    type(&p, "m = 200.0(1) g\r");
    await_offer(&p, "next (Enter): fit damped; measure k");
    take_offer(&p, "next (Enter): adopt");
    take_offer(&p, "next (Enter): method euler dt=10 ms; run 10 s");
    type(&p, "abc");
    expect_prompt(&p, EMPTY_PROMPT " abc");
    type(&p, "\x03"); /* leaves nothing behind */
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "print 7*13\r");
    expect(&p, "91");
    assert_false(shows(&p, "1000 steps"));
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

/* A row of the log: of a chain that cannot be read whole its first statements are offered, which
 * are what an Enter takes, then the next; what was typed ends it. */
static void test_small(void **state)
{
    (void)state;
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    in_folder(folder);
    start_panes(&p, (struct start){.width = 40, .height = 12});
    type(&p, "load bare.txt\r");
    await_offer(&p, "next (Enter): plot position data bare");
    assert_false(shows(&p, "bare;"));
    take_offer(&p, "next (Enter): measure period");
    assert_false(shows(&p, "13 periods")); /* not yet */
    take_offer(&p, "next (Enter): measure frequency");
    enter(&p, "print 7*13");
    await_offer(&p, "next (Enter): fit damped");
    assert_false(shows(&p, "measure amplitude"));
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

/* Lessons are those of a module. */
static bool has_report(void)
{
    struct error error;
    return module_is_in("lab", TEXT("lab"), &error);
}

/* Types it and waits until that stands at the end of what was sent. */
static void enter_lesson(struct person *p, const char *keys, const char *prompt)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    const size_t before = p->raw.len + strlen(keys) + 1, len = strlen(prompt);
    type(p, keys);
    while (
        (p->raw.len < before + len || memcmp(p->raw.data + p->raw.len - len, prompt, len) != 0) &&
        clock_ns() < deadline) {
        pump(p, 200);
    }
    assert_memory_equal(p->raw.data + p->raw.len - len, prompt, len);
}

/* A lesson at the prompt: it shows that it waits, Enter types what it says, Ctrl-C loses nothing.
 */
static void test_lesson(void **state)
{
    (void)state;
    if (!has_report())
        skip();
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    struct person p;
    in_folder(folder);
    begin(&p, (struct start){.argument = {"--plain", "--color", "never"}});
    await_prompt(&p, 0);
    type(&p, "lab seed=7\r");
    expect(&p, "lab 1/13>");
    type(&p, "abc\x03");
    expect(&p, "^C");
    enter_lesson(&p, "again\r", "lab 1/13> ");
    enter_lesson(&p, "\r", "lab 1/13> ");
    assert_true(shows(&p, "next (Enter): load bare-7.txt"));
    enter_lesson(&p, "\r", "lab 2/13> ");
    assert_false(shows(&p, "next (Enter): measure period"));
    enter_lesson(&p, "\r", "lab 2/13> "); /* a second one executes nothing */
    assert_false(shows(&p, "13 periods"));
    assert_true(shows(&p, "next (Enter): measure period"));
    enter_lesson(&p, "\r", "lab 2/13> ");
    assert_true(shows(&p, "13 periods"));
    type(&p, "check 0.9 s\r");
    expect(&p, "not correct");
    quit(&p);
    begin(&p, (struct start){.argument = {"--plain", "--color", "never", "--resume"}});
    expect(&p, "lab 2/13>"); /* what was measured in that step counts */
    type(&p, "check 0.9 s\r");
    expect(&p, "not correct");
    type(&p, "skip\r");
    expect(&p, "lab 3/13>");
    type(&p, "lab off\r");
    expect(&p, "the lesson has ended");
    expect(&p, "hooke>");
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

/* The value that stands before `marker`, behind the last `name` before that. */
static void read_value(const char *said, const char *name, const char *marker, char value[40])
{
    const char *end = strstr(said, marker), *at = NULL;
    for (const char *next = said; end && (next = strstr(next, name)) && next < end; next++) {
        at = next + strlen(name);
    }
    if (!at) {
        fail_msg("no '%s .. %s' in %s", name, marker, said);
        return;
    }
    snprintf(value, 40, "%.*s", (int)strcspn(at, " \r\n"), at);
}

/* The whole guided lab: at each step what is offered is taken, what it prints is read and checked;
 * a step is asked again, one is skipped, and each hint is asked for. */
static void test_whole_lesson(void **state)
{
    (void)state;
    if (!has_report())
        skip();
    static const struct {
        const char *name, *marker, *unit; /* of what is to be checked; NULL: nothing */
    } steps[] = {
        {NULL, NULL, NULL},       {"T = ", "periods, phases", "s"},
        {"k = ", "(m = ", "N/m"}, {NULL, NULL, NULL},
        {NULL, NULL, NULL},       {"dE/E0 = ", "at the end", ""},
        {NULL, NULL, NULL},       {"Re = ", "at the largest speed", ""},
        {NULL, NULL, NULL},       {"gamma = ", "(amplitude falls as exp(-gamma t/2); 6", "1/s"},
        {NULL, NULL, NULL},       {"gamma = ", "(energy falls", "1/s"},
        {NULL, NULL, NULL},
    };
    static char folder[] = "/tmp/hooke-keys-XXXXXX";
    const int count = (int)COUNT_OF(steps), skipped = 4;
    struct person p;
    in_folder(folder);
    begin(&p,
          (struct start){.argument = {"--plain", "--color", "never"}, .width = 120, .height = 40});
    await_prompt(&p, 0);
    enter_lesson(&p, "lab seed=5\r", "lab 1/13> ");
    for (int i = 0; i < count; i++) {
        char here[24], next[24], line[80], value[40];
        snprintf(here, sizeof here, "lab %d/13> ", i + 1);
        snprintf(next, sizeof next, i + 1 < count ? "lab %d/13> " : PROMPT, i + 2);
        enter_lesson(&p, "hint\r", here);
        enter_lesson(&p, "again\r", here);
        const size_t begun = p.raw.len;
        if (i == skipped) {
            enter_lesson(&p, "skip\r", next);
            continue;
        }
        enter_lesson(&p, "\r", here); /* it was offered before */
        enter_lesson(&p, "\r", steps[i].name ? here : next);
        if (!steps[i].name) {
            continue;
        }
        read_value(p.raw.data + begun, steps[i].name, steps[i].marker, value);
        snprintf(line, sizeof line, "check %s %s\r", value, steps[i].unit);
        enter_lesson(&p, line, next);
        assert_non_null(strstr(p.raw.data + begun, "right"));
    }
    assert_true(shows(&p, "the lesson is finished"));
    assert_null(strstr(p.raw.data, "error: "));
    assert_null(strstr(p.raw.data, "not correct"));
    assert_int_equal(access("lab-report-5/report.html", F_OK), 0);
    quit(&p);
    assert_int_equal(chdir(home), 0);
}

static void test_lesson_in_panes(void **state)
{
    (void)state;
    static const struct start sizes[] = {{.width = 80, .height = 24}, {.width = 40, .height = 12}};
    static char folder[][24] = {"/tmp/hooke-keys-XXXXXX", "/tmp/hooke-keys-XXXXXX"};
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        struct person p;
        in_folder(folder[i]);
        start_panes(&p, sizes[i]);
        type(&p, "lab seed=7\r");
        expect(&p, "lab 1/13 waits");
        type(&p, "load bare-7.txt\r");
        const int64_t deadline = clock_ns() + PATIENCE_NS;
        struct buffer row = {0};
        while (!shows(&p, "lab 2/13 waits") && clock_ns() < deadline) {
            pump(&p, 200);
            prompt_row(&p, &row);
            if (strstr(row.data, "(space")) {
                type(&p, "q");
                wait_for(&p, "(space", false);
            }
        }
        buffer_free(&row);
        expect(&p, "lab 2/13 waits");
        type(&p, "lab off\r");
        wait_for(&p, "waits", false);
        quit(&p);
        assert_int_equal(chdir(home), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lab),
        cmocka_unit_test(test_unseen),
        cmocka_unit_test(test_passed_over),
        cmocka_unit_test(test_panes),
        cmocka_unit_test(test_small),
        cmocka_unit_test(test_lesson),
        cmocka_unit_test(test_lesson_in_panes),
        cmocka_unit_test(test_whole_lesson),
    };
    return make_folder(state_folder) ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
}
