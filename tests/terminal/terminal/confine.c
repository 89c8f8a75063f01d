/* SPDX-License-Identifier: GPL-3.0-or-later */
/* --safe kept by the kernel: what a program that has been taken over could not do, and that those
 * who use it notice nothing. */
#include "cmocka_testing.h"

#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <dirent.h>

#include "terminal/terminal.h"
#include "terminal/person.h"

static bool make(const char *path)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd >= 0)
        close(fd);
    return fd >= 0;
}

static bool can_export(const char *path)
{
    struct writer writer;
    struct error error;
    if (!writer_open(&writer, path, (struct write_policy){.force = true}, &error))
        return false;
    writer_put(&writer, TEXT("1\n"));
    return writer_commit(&writer, &error);
}

static bool can_connect(void)
{
    const struct sockaddr_in here = {
        .sin_family = AF_INET, .sin_port = htons(9), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    return fd >= 0 &&
           (connect(fd, (const struct sockaddr *)&here, sizeof here) == 0 || errno != EACCES);
}

/* The name of the first thing that is otherwise than it should be; NULL: none. */
static const char *look_around(int version)
{
    const struct {
        const char *what;
        bool done, wanted;
    } acts[] = {
        {"a new file inside", make("file"), true},
        {"writing it again", make("file"), true},
        {"an export", can_export("table.csv"), true},
        {"an export that replaces one", can_export("table.csv"), true},
        {"a folder", mkdir("folder", 0700) == 0, true},
        {"a name in another folder",
         rename("file", "folder/file") == 0 || version < 2 /* not even inside */, true},
        {"removing", version < 2 || unlink("folder/file") == 0, true},
        {"the state", make("../state/history"), true},
        {"/dev/null", make("/dev/null"), true},
        {"reading outside", open("../outside/treasure", O_RDONLY) >= 0, true},
        {"a new file outside", make("../outside/new"), false},
        {"writing to one outside", open("../outside/treasure", O_WRONLY) >= 0, false},
        {"cutting one outside", version >= 3 && truncate("../outside/treasure", 0) == 0, false},
        {"removing one outside", unlink("../outside/treasure") == 0, false},
        {"a folder outside", mkdir("../outside/folder", 0700) == 0, false},
        {"moving out", rename("table.csv", "../outside/table.csv") == 0, false},
        {"moving in", rename("../outside/treasure", "treasure") == 0, false},
        {"linking out", link("table.csv", "../outside/table.csv") == 0, false},
        {"an export outside", can_export("../outside/table.csv"), false},
        {"a symbolic link", symlink("/", "link") == 0, false},
        {"a pipe", mkfifo("pipe", 0600) == 0, false},
        {"the network", version >= 4 && can_connect(), false},
        {"a program", execl("/bin/sh", "sh", "-c", "exit 7", (char *)NULL) == 0, false},
    };
    for (size_t i = 0; i < COUNT_OF(acts); i++)
        if (acts[i].done != acts[i].wanted)
            return acts[i].what;
    return NULL;
}

static void skip_without(int version)
{
    if (version == 0) {
        print_message("# this kernel has no Landlock\n");
        skip();
    }
}

TEST(test_nothing_else_is_written)
{
    /* where lines are counted (scripts/coverage) their counts are written, too */
    const char *const counts = getenv("GCOV_PREFIX"), *const folders[] = {".", "../state", counts};
    char folder[] = "/tmp/hooke-panes-XXXXXX", line[128] = "";
    const int version = confine_version();
    int ends[2], status;
    skip_without(version);
    assert_non_null(make_folder(folder));
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct error error = {0};
        const char *wrong = "the beginning";
        if (chdir(folder) == 0 && mkdir("here", 0700) == 0 && mkdir("outside", 0700) == 0 &&
            mkdir("state", 0700) == 0 && make("outside/treasure") && chdir("here") == 0)
            wrong = confine_writing(folders, 3, &error) ? look_around(version) : error.text;
        dprintf(ends[1], "%s", wrong ? wrong : "");
        if (counts)
            exit(wrong ? 1 : 0);
        _exit(wrong ? 1 : 0);
    }
    close(ends[1]);
    assert_true(read(ends[0], line, sizeof line - 1) >= 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    close(ends[0]);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) /* 7: the program was run */
        fail_msg("status %d; otherwise than it should be: %s", status, line);
}

static bool is_confined(pid_t program)
{
    char path[64], line[128];
    bool found = false;
    snprintf(path, sizeof path, "/proc/%ld/status", (long)program);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file))
        found |= strcmp(line, "NoNewPrivs:\t1\n") == 0;
    if (file)
        fclose(file);
    return found;
}

static bool is_kept(const char *begin)
{
    char path[256];
    bool found = false;
    snprintf(path, sizeof path, "%s/hooke", state_folder);
    DIR *folder = opendir(path);
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        found |= strncmp(entry->d_name, begin, strlen(begin)) == 0;
    if (folder)
        closedir(folder);
    return found;
}

TEST(test_nobody_notices)
{
    struct person p;
    skip_without(confine_version());
    snprintf(state_folder, sizeof state_folder, "%s", "/tmp/hooke-panes-XXXXXX");
    assert_non_null(make_folder(state_folder));
    begin(&p, (struct start){.argument = {"--safe"}});
    expect_prompt(&p, EMPTY_PROMPT);
    assert_true(is_confined(p.program));
    enter(&p, "m = 321 g");
    expect(&p, "m=321 g");
    enter(&p, "save /tmp/hooke-outside.hk");
    expect(&p, "--safe");
    quit(&p);
    assert_true(is_kept("history") && is_kept("session-"));
    begin(&p, (struct start){0});
    expect_prompt(&p, EMPTY_PROMPT);
    assert_false(is_confined(p.program));
    quit(&p);
}

RUN_TESTS(NULL, NULL)
