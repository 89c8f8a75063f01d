/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The report: its script gives the same bytes in a new session; nothing that users name becomes
 * markup. */
#include "cmocka_testing.h"

#include <hooke/base/file.h>

#include "unit/command/testing.h"

#include <sys/stat.h>

static void remove_folder(const char *path)
{
    DIR *list = opendir(path);
    char name[600];
    for (struct dirent *entry; list && (entry = readdir(list));) {
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.')
            assert_int_equal(unlink(name), 0);
    }
    if (list)
        closedir(list);
    rmdir(path);
}

static void read_whole(const char *folder, const char *name, struct buffer *content)
{
    struct error error = {0};
    char path[600];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    buffer_clear(content);
    if (!file_read(path, 1u << 26, content, &error))
        fail_msg("%s", error.text);
}

/* Both folders hold the same files with the same bytes; returns how many. */
static int compare_folders(const char *a, const char *b)
{
    int files = 0, others = 0;
    struct buffer one = {0}, two = {0};
    DIR *list = opendir(a);
    assert_non_null(list);
    for (struct dirent *entry; (entry = readdir(list));) {
        if (entry->d_name[0] == '.')
            continue;
        read_whole(a, entry->d_name, &one);
        read_whole(b, entry->d_name, &two);
        if (!text_equal(buffer_text(&one), buffer_text(&two)))
            fail_msg("%s/%s and %s/%s differ", a, entry->d_name, b, entry->d_name);
        files++;
    }
    closedir(list);
    list = opendir(b);
    for (struct dirent *entry; (entry = readdir(list));)
        others += entry->d_name[0] != '.';
    closedir(list);
    assert_int_equal(files, others);
    buffer_free(&one);
    buffer_free(&two);
    return files;
}

/* A decaying oscillation of 5 cm with a little noise. */
static void write_recording(const char *name, double gamma, double seconds)
{
    struct buffer text = {0};
    unsigned random = 7;
    buffer_put(&text, TEXT("Time (s)\tDistance (cm)\n"));
    for (int i = 0; i * 0.01 < seconds; i++) {
        random = random * 1103515245u + 12345u;
        const double t = i * 0.01, noise = ((random >> 16 & 1023) / 1023.0 - 0.5) * 0.05;
        buffer_format(&text, "%.2f\t%.3f\n", t,
                      20 + 5 * exp(-gamma * t / 2) * cos(8.66 * t) + noise);
    }
    write_file(name, text.data, text.len);
    buffer_free(&text);
}

static void replay(const char *folder, const char *into, bool keep_going)
{
    struct bench bench;
    char script[600], report[600];
    bench_open(&bench, false);
    bench.session->options.keep_going = keep_going;
    snprintf(script, sizeof script, "%s/session.hk", folder);
    snprintf(report, sizeof report, "report %s", into);
    const bool ok = script_file(bench.session, script, NULL, &bench.reply);
    if (ok == keep_going)
        fail_msg("%s", said(&bench.err));
    type_ok(&bench, report);
    bench_close(&bench);
}

static void says(const struct buffer *content, const char *wanted)
{
    if (!memmem(content->data, content->len, wanted, strlen(wanted)))
        fail_msg("'%s' is not in:\n%.3000s", wanted, content->data);
}

static void has_not(const struct buffer *content, const char *unwanted)
{
    if (memmem(content->data, content->len, unwanted, strlen(unwanted)))
        fail_msg("'%s' is there", unwanted);
}

/* Where the runs stand: which figures of the report come before and after a heading. */
static void stands_under(const struct buffer *report, const char *what, const char *heading,
                         const char *next)
{
    const char *from = strstr(report->data, heading), *to = from ? strstr(from, next) : NULL;
    const char *at = from ? strstr(from, what) : NULL;
    if (!from || !to || !at || at > to)
        fail_msg("'%s' is not between '%s' and '%s'", what, heading, next);
}

TEST(the_lab_comes_back_bit_for_bit)
{
    struct bench bench;
    struct buffer content = {0};
    write_recording("bare.txt", 0.01, 10);
    write_recording("disk.txt", 0.06, 60);
    write_file("inner.hk", "measure k\n", 10);
    bench_open(&bench, true);
    static const char *const lines[] = {
        "load bare.txt as=bare",
        "measure period; measure amplitude",
        "m = 200.0 +- 0.1 g",
        "fit damped",
        "source inner.hk",
        "adopt amplitude; gamma = 0",
        "meth backw; meth eule dt=10ms",
        "comp eule symplectic-euler",
        "run 3 s; undo",
        "load disk.txt as=disk",
        "m = 216 g",
        "measure amplitude at=5,15,25,35,45; measure decay",
        "measure reynolds",
        "fit damped",
        "adopt",
        "method rk4 dt=10ms",
        "run 20 s",
        "measure decay of energy",
        "export run.csv",
        "plot position > figure.txt",
    };
    for (size_t i = 0; i < COUNT_OF(lines); i++)
        type_ok(&bench, lines[i]);
    type_ok(&bench, "report first");
    assert_says(&bench.out, "report written to first");
    assert_null(strstr(said(&bench.out), "not included"));
    type_ok(&bench, "report again");
    bench_close(&bench);
    /* What a report writes has nothing to do with what the session wrote before it. */
    assert_true(compare_folders("first", "again") > 20);
    replay("first", "second", false);
    compare_folders("first", "second");

    read_whole("first", "session.hk", &content);
    says(&content, "\nmeasure k\n");
    says(&content, "\nmethod backward-euler\n");
    says(&content, "\ncompare euler symplectic-euler\n");
    has_not(&content, "export");
    has_not(&content, "figure.txt");
    has_not(&content, "source");
    read_whole("first", "report.md", &content);
    char question[32];
    for (int q = 1; q <= 10; q++) {
        snprintf(question, sizeof question, "#### Q%d. ", q);
        says(&content, question);
    }
    says(&content, "| amplitude A at t = 25 s |");
    read_whole("first", "values.csv", &content);
    says(&content, "name,value,uncertainty,unit,t [s],of,source,line,statement\n");
    buffer_free(&content);
    remove_folder("first");
    remove_folder("again");
    remove_folder("second");
}

/* A heading without anything says what makes it; a session without a spring has no such headings.
 */
TEST(what_is_missing_is_said)
{
    struct bench bench;
    struct buffer content = {0};
    bench_open(&bench, false);
    type_ok(&bench, "method rk4; run 2 s");
    type_ok(&bench, "report small");
    assert_says(&bench.out, "not included: the Reynolds number (measure reynolds)");
    read_whole("small", "report.md", &content);
    says(
        &content,
        "### 2. Forward Euler\n\nMissing: forward Euler without damping. Commands that produce it: "
        "`gamma = 0; method euler dt=10ms; run 10 s`\n");
    stands_under(&content, "position of run 1 (rk4)", "### 4.", "Missing: forward and symplectic");
    says(&content, "Missing: the recording without damping. Commands that produce it: `load FILE`");
    says(&content,
         "Missing: the spring constant. Commands that produce it: `m = 200 g; fit damped`");
    type_ok(&bench, "scene kepler; run 10 s");
    assert_false(type(&bench, "report small"));
    assert_says(&bench.err, "small exists; add --force");
    type_ok(&bench, "report small --force");
    read_whole("small", "report.md", &content);
    says(&content, "## Other systems");
    says(&content, ": orbit of run 2");
    type_ok(&bench, "drop 1; report orbits");
    read_whole("orbits", "report.md", &content);
    has_not(&content, "First session");
    has_not(&content, "Missing");
    remove_folder("orbits");
    /* What somebody put there is not lost. */
    write_file("small/answers.odt", "x", 1);
    assert_false(type(&bench, "report small --force"));
    assert_says(&bench.err, "it also holds answers.odt");
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("small");
}

/* The bare bob is damped, too: its fit is adopted with that, and its runs answer the questions of
 * the first session. */
TEST(runs_stand_under_their_questions)
{
    struct bench bench;
    struct buffer content = {0};
    write_recording("bare.txt", 0.01, 10);
    write_recording("disk.txt", 0.06, 60);
    bench_open(&bench, false);
    type_ok(&bench, "load disk.txt as=disk; load bare.txt as=bare; m = 200 g");
    type_ok(&bench, "fit damped to bare; adopt; method euler dt=10ms; run 8 s; method verlet; run");
    type_ok(&bench, "fit damped to disk; adopt; method symplectic-euler; run 20 s");
    type_ok(&bench, "method euler; run 20 s; scene drag; method rk4; run 5 s; F0 = 0.1 N; run 5 s");
    type_ok(&bench, "report placed");
    read_whole("placed", "report.md", &content);
    stands_under(&content, "position of run 1 (euler)", "### 2.", "### 3.");
    stands_under(&content, "| 2 | verlet |", "### 4.", "## Second");
    stands_under(&content, "position of run 3 (symplectic-euler) and recording `disk`", "### 7.",
                 "## Other");
    stands_under(&content, "position of run 4 (euler) and recording `disk`", "### 7.", "## Other");
    stands_under(&content, "position of run 5 (rk4)", "### 5.", "### 6.");
    stands_under(&content, "position of run 6 (rk4)", "## Other systems", "## All values");
    stands_under(&content, "position of recording `disk`", "### 6.", "### 7.");
    stands_under(&content, "position of recording `bare`", "### 1.", "### 2.");
    has_not(&content, "Missing: the damped simulation");
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("placed");
}

/* Methods run one by one on the same damped motion are a comparison of methods, as those of
 * 'compare'; without recording there is nothing else they could be. */
TEST(methods_one_by_one_are_compared)
{
    struct bench bench;
    struct buffer content = {0};
    bench_open(&bench, false);
    type_ok(&bench, "gamma = 0.2 1/s; method euler dt=10ms; run 3 s; method rk4; run 3 s");
    type_ok(&bench, "method verlet; run 3 s; measure reynolds; k = 16 N/m; run 3 s; report single");
    assert_says(&bench.out, "not included: forward Euler without damping");
    read_whole("single", "report.md", &content);
    stands_under(&content, "position of run 1 (euler)", "### 2.", "### 3.");
    stands_under(&content, "energy of run 1 (euler), run 2 (rk4), run 3 (verlet)", "### 4.",
                 "## Second");
    stands_under(&content, "- Reynolds number Re = 11", "### 5.", "### 6.");
    stands_under(&content, "position of run 4 (verlet)", "### 7.", "## All values");
    const char *measured = strstr(content.data, "Measured on run 3");
    assert_null(measured); /* its Reynolds number stands under drag */
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("single");
}

/* A recording goes to the section on the disk by its damping compared with the other recordings,
 * because a short one loses little amplitude even with a disk. */
TEST(two_springs_are_told_apart)
{
    struct bench bench;
    struct buffer content = {0};
    write_recording("one.txt", 0.008, 10);
    write_recording("two.txt", 0.01, 12);
    write_recording("slow.txt", 0.045, 10);
    bench_open(&bench, false);
    type_ok(&bench, "m = 200 g; load one.txt; load two.txt; load slow.txt");
    type_ok(&bench, "fit damped to one; fit damped to two; fit damped to slow; adopt");
    type_ok(&bench, "method rk4; run 9 s; report springs");
    read_whole("springs", "report.md", &content);
    stands_under(&content, "position of recording `one`", "### 1.", "### 2.");
    stands_under(&content, "position of recording `two`", "### 1.", "### 2.");
    stands_under(&content, "position of recording `slow`", "### 6.", "### 7.");
    stands_under(&content, "position of run 1 (rk4) and recording `slow`", "### 7.", "## All");
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("springs");
}

/* y0, k, gamma of somebody's equations are not those of the lab; what would make a spring's
 * sections begins with its scene. */
TEST(typed_scenes_have_their_own_names)
{
    struct bench bench;
    struct buffer content = {0};
    write_recording("bare.txt", 0.01, 10);
    bench_open(&bench, false);
    type_ok(&bench, "scene new tank; param gamma = 0.5; var y = 2 m; y' = -gamma*sqrt(abs(y))");
    type_ok(&bench, "method rk4; run 2 s; load bare.txt; report typed");
    assert_says(&bench.out, "(scene spring; gamma = 0; method euler dt=10ms; run 10 s)");
    assert_says(&bench.out, "(measure period of data bare)");
    read_whole("typed", "report.md", &content);
    says(&content, "| y0 (y at t0) | 2 m | parameter |");
    says(&content, "| gamma (typed by the user) | 0.5 | parameter |");
    has_not(&content, "initial position");
    has_not(&content, "damping gamma");
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("typed");
}

/* What a report says that makes what it lacks does so. */
TEST(what_it_says_to_type_is_enough)
{
    struct bench bench;
    write_recording("bare.txt", 0.01, 10);
    write_recording("disk.txt", 0.06, 60);
    bench_open(&bench, false);
    type_ok(&bench, "load bare.txt as=bob");
    for (int i = 0;; i++) {
        type_ok(&bench, "report lacking --force");
        const char *lack = strstr(said(&bench.out), "not included: "), *open = NULL;
        if (!lack)
            break;
        assert_true(i < 12);
        open = strchr(lack, '(');
        char line[200];
        snprintf(line, sizeof line, "%.*s", (int)(strstr(open, ")\n") - open - 1), open + 1);
        type_ok(&bench, strcmp(line, "load FILE") == 0 ? "load disk.txt as=disk" : line);
    }
    bench_close(&bench);
    remove_folder("lacking");
}

/* Once for all numbers of a recording; what was stated is not among them. */
TEST(what_counts_as_exact_is_said_once)
{
    struct bench bench;
    struct buffer content = {0};
    bench_open(&bench, false);
    type_ok(&bench, "set timing off; m = 200 g; method rk4; run 6 s; export own.csv t,y; drop all");
    type_ok(&bench,
            "load own.csv; eta = 1.82e-5 +- 1e-7 Pa*s; fit; adopt; measure k; measure reynolds");
    type_ok(&bench, "report stated");
    read_whole("stated", "report.md", &content);
    says(&content, "Given without an uncertainty and taken as exact: m, rho, length. Results");
    const char *first = strstr(content.data, "taken as exact");
    assert_null(strstr(first + 1, "taken as exact"));
    buffer_free(&content);
    bench_close(&bench);
    remove_folder("stated");
}

TEST(a_run_that_diverged_comes_back)
{
    struct bench bench;
    struct buffer content = {0};
    bench_open(&bench, false);
    assert_false(type(&bench, "method euler dt=5s; run 10000 s"));
    type_ok(&bench, "report gone");
    bench_close(&bench);
    replay("gone", "back", true);
    compare_folders("gone", "back");
    read_whole("gone", "session.hk", &content);
    says(&content, "hooke --keep-going -f");
    read_whole("gone", "runs.csv", &content);
    says(&content, "diverged");
    buffer_free(&content);
    remove_folder("gone");
    remove_folder("back");
}

/* A scene without energy and without a closed form, and a run that left the range of numbers: no
 * cell is no number. */
TEST(what_is_not_known_is_no_number)
{
    static const char *const files[] = {"values.csv", "runs.csv", "report.md", "report.html"};
    static const char *const words[] = {",nan",   ",-nan", ",inf", ",-inf", "| nan",
                                        "| -nan", "| inf", ">nan", ">-nan", ">inf"};
    struct bench bench;
    struct buffer content = {0};
    bench_open(&bench, false);
    type_ok(&bench, "scene robertson; method radau5; run 1 s");
    assert_false(type(&bench, "scene spring; method euler dt=5s; run 10000 s"));
    type_ok(&bench, "report unknown");
    bench_close(&bench);
    for (size_t i = 0; i < COUNT_OF(files); i++) {
        read_whole("unknown", files[i], &content);
        for (size_t k = 0; k < COUNT_OF(words); k++)
            has_not(&content, words[k]);
    }
    read_whole("unknown", "values.csv", &content);
    has_not(&content, ",,0,");             /* a name without a value */
    says(&content, "energy at the start"); /* what is known is there */
    buffer_free(&content);
    remove_folder("unknown");
}

TEST(names_are_no_markup)
{
    static const char hostile[] =
        "<script>alert('1')<|script> `x` ```y``` | [a](b) &amp; ![i](j) **b** .txt";
    struct bench bench;
    struct buffer content = {0}, line = {0};
    write_recording(hostile, 0.05, 10);
    bench_open(&bench, false);
    buffer_format(&line, "load \"%s\"", hostile);
    type_ok(&bench, said(&line));
    type_ok(&bench, "run 1 s; note <img src=x onerror=y> `` ` | </code></pre> </script>");
    type_ok(&bench, "report hostile");
    bench_close(&bench);
    read_whole("hostile", "report.html", &content);
    has_not(&content, "<script");
    has_not(&content, "<img src=x");
    has_not(&content, "</code></pre>");
    has_not(&content, "alert('1')");
    says(&content, "&lt;script&gt;alert(&#39;1&#39;)");
    says(&content, "&amp;amp;");
    read_whole("hostile", "report.md", &content);
    /* Outside of code there is nothing of theirs: each stands between more backticks than it holds.
     */
    says(&content, "- ```` <script>alert");
    says(&content, "note: ``` <img src=x onerror=y> `` ` ");
    buffer_free(&content);
    buffer_free(&line);
    remove_folder("hostile");
}

RUN_TESTS(enter_folder, leave_folder)
