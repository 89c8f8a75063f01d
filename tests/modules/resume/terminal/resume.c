/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions that save themselves: a terminal that is closed, a program that is killed, files that
 * are not what they should be. */
#include "cmocka_testing.h"

#include <sys/resource.h>

#include <dirent.h>
#include <sys/file.h>
#include <time.h>

#include "modules/resume/terminal/autosave.h"
#include "terminal/person.h"

/* A folder for each test. */
static void new_state(void)
{
    snprintf(state_folder, sizeof state_folder, "%s", "/tmp/hooke-panes-XXXXXX");
    assert_non_null(make_folder(state_folder));
}

static void folder_path(char path[256], const char *name)
{
    snprintf(path, 256, "%s/hooke/%.180s", state_folder, name);
}

/* Saved sessions there are; name: of the last one seen. */
static int count_saved(char name[256])
{
    char path[256];
    int count = 0;
    folder_path(path, "");
    DIR *folder = opendir(path);
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        if (strncmp(entry->d_name, AUTOSAVE_PREFIX, strlen(AUTOSAVE_PREFIX)) == 0) {
            count++;
            snprintf(name, 256, "%s", entry->d_name);
        }
    }
    if (folder) {
        closedir(folder);
    }
    return count;
}

static void plant(const char *name, const char *text, time_t age)
{
    char path[256];
    mkdir(state_folder, 0700);
    folder_path(path, "");
    mkdir(path, 0700);
    folder_path(path, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    const struct timespec times[2] = {{time(NULL) - age, 0}, {time(NULL) - age, 0}};
    assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
}

static bool is_there(const char *name)
{
    char path[256];
    folder_path(path, name);
    return access(path, F_OK) == 0;
}

/* The session that expect_resumed() looks for. */
static void begin_work(struct person *p, const char *environment)
{
    begin(p, (struct start){.environment = environment});
    expect_prompt(p, EMPTY_PROMPT);
    enter(p, "m = 321 g; method verlet; let answer = 42");
    enter(p, "run 1000 s");
    expect(p, "RUNNING");
    wait_for(p, "t=0.00", false); /* some of it has been computed */
}

static void expect_resumed(const char *argument)
{
    struct person p;
    begin(&p, (struct start){.argument = {"--resume", argument}});
    expect_prompt(&p, EMPTY_PROMPT);
    expect(&p, "m=321 g");
    expect(&p, "verlet");
    enter(&p, "print answer + 1");
    expect(&p, "43");
    enter(&p, "print run_that_is_not_there"); /* the log goes on */
    enter(&p, "runs");
    expect(&p, "1  verlet");
    quit(&p);
}

/* So many milliseconds pass. */
static void goes_on(struct person *p, int ms)
{
    for (const int64_t until = clock_ns() + ms * 1000000LL; clock_ns() < until;)
        pump(p, 20);
}

static off_t saved_bytes(const char *name)
{
    char path[256];
    struct stat file = {.st_size = 0};
    folder_path(path, name);
    stat(path, &file);
    return file.st_size;
}

/* Until the run is in the file: that is there since the first line and grows with each save, of
 * which the second at least begins after the run has. */
static void await_saved_run(struct person *p, char name[256])
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    off_t size = 0;
    for (int grown = 0; grown < 3 && clock_ns() < deadline; pump(p, 20))
        if (count_saved(name) > 0 && saved_bytes(name) > size) {
            size = saved_bytes(name);
            grown++;
        }
    assert_true(clock_ns() < deadline);
}

TEST(test_closed_terminal)
{
    new_state();
    struct person p;
    begin_work(&p, NULL);
    close(p.fd);
    p.fd = -1;
    const int64_t begun = work_ns(p.program);
    struct rusage before, after;
    getrusage(RUSAGE_CHILDREN, &before);
    const int status = wait_end(&p);
    getrusage(RUSAGE_CHILDREN, &after);
    const int64_t work = (after.ru_utime.tv_sec - before.ru_utime.tv_sec) * 1000000000 +
                         (after.ru_utime.tv_usec - before.ru_utime.tv_usec) * 1000 - begun;
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 129);
    assert_true(work < 3 * work_most());
    forget(&p);
    expect_resumed(NULL);
}

TEST(test_killed)
{
    new_state();
    struct person p;
    char name[256] = "";
    begin_work(&p, "HOOKE_AUTOSAVE=0.2");
    await_saved_run(&p, name);
    kill(p.program, SIGKILL);
    wait_end(&p);
    forget(&p);
    *strrchr(name, '.') = '\0'; /* also without its ending */
    expect_resumed(name);
}

/* What a program that was killed after such lines has kept: true: all of them. */
static bool is_kept_when_killed(bool plain)
{
    struct person p;
    new_state();
    begin(&p, (struct start){.argument = {plain ? "--plain" : NULL}});
    expect(&p, plain ? "hooke>" : EMPTY_PROMPT);
    type(&p, "let early = 6\r");
    expect(&p, "early = 6");
    settle(&p, 800); /* so that the next one is not the first for long */
    type(&p, "let late = 7\rlet later = 35\rscene kepler\rprint 6*late\r");
    expect(&p, "42");
    type(&p, "stress\r");
    goes_on(&p, 50);
    kill(p.program, SIGKILL);
    wait_end(&p);
    forget(&p);
    begin(&p, (struct start){.argument = {"--resume"}});
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "print early*late + later");
    enter(&p, "print 1000+1");
    expect(&p, "1001");
    const bool kept = shows(&p, "77");
    quit(&p);
    return kept;
}

/* A line that was executed is in the file when its answer is seen: also one of several that were
 * pasted, before another that takes long, in panes and at the plain prompt. Where a write took
 * long, the next one waits as long: a machine that stands still meanwhile gets another try. */
TEST(test_killed_after_a_line)
{
    for (int plain = 0; plain < 2; plain++) {
        bool kept = false;
        for (int tries = 0; tries < 5 && !kept; tries++)
            kept = is_kept_when_killed(plain);
        assert_true(kept);
    }
}

/* Whose session is still there is seen by the lock of its file: no number of a process says it. */
TEST(test_living_by_lock)
{
    new_state();
    struct person p, other;
    char name[256] = "", from[256], to[256];
    begin_work(&p, "HOOKE_AUTOSAVE=0.2");
    await_saved_run(&p, name);
    begin(&other, (struct start){.argument = {"--resume"}, .width = 160});
    expect(&other, "no saved session");
    wait_end(&other);
    forget(&other);
    kill(p.program, SIGKILL);
    wait_end(&p);
    forget(&p);
    folder_path(from, name);
    folder_path(to, "session-20200101-000000-1" AUTOSAVE_ENDING); /* there always is a process 1 */
    assert_int_equal(rename(from, to), 0);
    expect_resumed(NULL);
}

TEST(test_plain_prompt_saves_too)
{
    new_state();
    struct person p;
    char name[256];
    begin(&p, (struct start){.argument = {"--plain"}, .environment = "HOOKE_AUTOSAVE=0.2"});
    expect(&p, "hooke>");
    type(&p, "m = 321 g; method verlet; let answer = 42; run 5 s\r");
    expect(&p, "t = 5 s");
    while (count_saved(name) == 0) { /* while it waits at the prompt */
        pump(&p, 100);
    }
    kill(p.program, SIGTERM);
    const int status = wait_end(&p);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 143);
    same_modes(&p);
    forget(&p);
    expect_resumed(NULL);
}

/* Options of the program hold for the session that is restored, too. */
TEST(test_options_of_what_resumes)
{
    new_state();
    struct person p;
    begin(&p, (struct start){.argument = {"--plain"}});
    expect(&p, "hooke>");
    type(&p, "method verlet; run 1 s\r");
    expect(&p, "t = 1 s");
    quit(&p);
    begin(&p, (struct start){.argument = {"--plain", "-v", "--resume"}});
    expect(&p, "hooke>");
    type(&p, "print 41 + 1\r");
    expect(&p, "+ print 41 + 1");
    quit(&p);
}

TEST(test_plain_suspend)
{
    new_state();
    struct person p;
    begin(&p, (struct start){.argument = {"--plain"}, .shell = true});
    expect(&p, "hooke>");
    type(&p, "print 5");
    expect(&p, "print 5");
    type(&p, "\x1a");
    expect_stop(&p);
    same_modes(&p);
    continue_program(&p);
    type(&p, "*5\r");
    expect(&p, "25");
    type(&p, "quit\r");
    wait_end(&p);
    same_modes(&p);
    forget(&p);
}

TEST(test_nothing_changed_nothing_saved)
{
    new_state();
    struct person p;
    char name[256];
    begin(&p, (struct start){0});
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "print 1");
    quit(&p);
    assert_int_equal(count_saved(name), 0);
}

/* A session of its own, as a program leaves it, so old. */
static void plant_session(const char *name, time_t age)
{
    struct person p;
    char made[256], from[256], to[256];
    begin(&p, (struct start){.argument = {"--plain"}});
    expect(&p, "hooke>");
    type(&p, "m = 321 g; print 6*7\r"); /* the echo is no answer */
    expect(&p, "42");
    quit(&p);
    assert_int_equal(count_saved(made), 1);
    folder_path(from, made);
    folder_path(to, name);
    assert_int_equal(rename(from, to), 0);
    const struct timespec times[2] = {{time(NULL) - age, 0}, {time(NULL) - age, 0}};
    assert_int_equal(utimensat(AT_FDCWD, to, times, 0), 0);
}

/* Locked, as by a program that lives. Returns what keeps it so. */
static int hold(const char *name)
{
    char path[256];
    folder_path(path, name);
    const int fd = open(path, O_RDWR);
    assert_true(fd >= 0 && saved_lock(fd));
    return fd;
}

/* The last five are kept, those of living programs anyway; what killed writers left is cleared
 * away. */
TEST(test_old_ones_go)
{
    new_state();
    char name[256];
    for (int i = 0; i < 8; i++) {
        snprintf(name, sizeof name, "session-20200101-00000%d-4%d" AUTOSAVE_ENDING, i, i);
        plant(name, STORE_HEADER "something", 1000 + i);
    }
    plant("session-20200101-000000-1" AUTOSAVE_ENDING, STORE_HEADER "something", 5000);
    plant(".hooke-0badcafe.session-20200101-000000-1.hks", "m", 0);
    plant(".hooke-0badcaff.session-20200101-000001-1.hks", "m", 5000);
    plant("session-notes.hk", "mine", 5000);
    const int living = hold("session-20200101-000000-1" AUTOSAVE_ENDING),
              written = hold(".hooke-0badcaff.session-20200101-000001-1.hks");
    struct person p;
    begin(&p, (struct start){0});
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
    assert_true(is_there("session-20200101-000004-44" AUTOSAVE_ENDING));
    assert_false(is_there("session-20200101-000005-45" AUTOSAVE_ENDING));
    assert_true(is_there("session-20200101-000000-1" AUTOSAVE_ENDING));
    assert_false(is_there(".hooke-0badcafe.session-20200101-000000-1.hks"));
    assert_true(is_there(".hooke-0badcaff.session-20200101-000001-1.hks"));
    close(living);
    close(written);
    assert_true(is_there("session-notes.hk"));
    assert_int_equal(count_saved(name), 5 + 1 + 1);
}

/* A session that was killed before it had written anything hides no other one. */
TEST(test_empty_ones_are_passed_over)
{
    struct person p;
    new_state();
    plant_session("session-20200101-000001-41" AUTOSAVE_ENDING, 1000);
    plant("session-20200101-000002-42" AUTOSAVE_ENDING, STORE_HEADER, 0);
    plant("session-20200101-000003-43" AUTOSAVE_ENDING, "", 100);
    begin(&p, (struct start){.argument = {"--resume"}});
    expect(&p, "m=321 g");
    quit(&p);
    assert_true(is_there("session-20200101-000002-42" AUTOSAVE_ENDING));
    assert_false(is_there("session-20200101-000003-43" AUTOSAVE_ENDING));
}

/* What is no session of this program is refused whole; what is in one: faults/command. */
TEST(test_bad_files)
{
    static const struct {
        const char *text, *said;
    } bad[] = {
        {"m = 0.3 kg\nexport stolen.csv\n", "another version"},
        {"hooke session 1\n\xF0HR\nS", "another version"},
        {STORE_HEADER "m = 0.3 kg\n", "nothing was restored"},
        {NULL, "no saved session"},
    };
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        new_state();
        if (bad[i].text)
            plant("session-20200101-000000-40" AUTOSAVE_ENDING, bad[i].text, 100);
        struct person p;
        begin(&p, (struct start){.argument = {"--resume"}, .width = 160});
        expect(&p, bad[i].said);
        const int status = wait_end(&p);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 2);
        forget(&p);
    }
}

TEST(test_no_place_to_save)
{
    new_state();
    struct person p;
    begin(&p, (struct start){.state = "/proc/nowhere", .environment = "HOOKE_AUTOSAVE=0.2"});
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "m = 321 g");
    expect(&p, "history cannot be saved");
    expect(&p, "cannot be saved");
    enter(&p, "clear; m = 322 g");
    expect(&p, "m=322 g");
    settle(&p, 500);
    assert_false(shows(&p, "cannot be saved")); /* said once */
    quit(&p);
}

/* A lock that another program never gives back, and a pipe that nobody writes to: neither keeps a
 * person waiting, both are told. */
TEST(test_history_in_the_way)
{
    char path[256];
    struct person p;
    new_state();
    plant("history", "show\n", 0);
    folder_path(path, "history");
    const int fd = open(path, O_RDWR);
    assert_true(fd >= 0 && flock(fd, LOCK_EX) == 0);
    begin(&p, (struct start){0});
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "m = 321 g");
    expect(&p, "has locked");
    enter(&p, "clear; m = 322 g");
    const int64_t begin_ns = clock_ns();
    for (int i = 0; i < 20; i++)
        enter(&p, "m = 323 g");
    expect(&p, "m=323 g");
    const double seconds = clock_seconds(begin_ns);
    assert_false(shows(&p, "has locked"));
    assert_true(flock(fd, LOCK_UN) == 0);
    const int64_t begin_again_ns = clock_ns();
    for (int i = 0; i < 20; i++)
        enter(&p, "m = 324 g");
    expect(&p, "m=324 g");
    /* The lock was waited for once only, not a second each time: what lines take is in both. */
    assert_true(seconds < 10 + 4 * clock_seconds(begin_again_ns));
    quit(&p);
    struct buffer content = {0}, wanted = {0};
    struct error error;
    assert_true(file_read(path, 1u << 20, &content, &error));
    buffer_put(&wanted, TEXT("show\nm = 321 g\nclear; m = 322 g\n"));
    for (int i = 0; i < 20; i++)
        buffer_put(&wanted, TEXT("m = 323 g\n"));
    for (int i = 0; i < 20; i++)
        buffer_put(&wanted, TEXT("m = 324 g\n"));
    buffer_put(&wanted, TEXT("quit\n"));
    assert_string_equal(content.data, wanted.data);
    buffer_free(&content);
    buffer_free(&wanted);
    close(fd);
    assert_true(unlink(path) == 0 && mkfifo(path, 0600) == 0);
    begin(&p, (struct start){0});
    expect_prompt(&p, EMPTY_PROMPT);
    enter(&p, "m = 321 g");
    expect(&p, "history cannot be saved");
    quit(&p);
}

RUN_TESTS(NULL, NULL)
