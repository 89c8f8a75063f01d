/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readline without memory: its own handler would end the program without a word to the session. */
#include "cmocka_testing.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <readline/readline.h>

#include "terminal/terminal.h"

static int report;

static void last_act(void)
{
    char *some = malloc(100000); /* the reserve makes this possible */
    const char *said = some ? "saved" : "no memory";
    if (write(report, said, strlen(said)) < 0) {
        _exit(9);
    }
    free(some);
}

/* What the child that ran out of memory inside readline said, through its last act and on standard
 * error. */
static void run_out(int pipe_end)
{
    report = pipe_end;
    dup2(pipe_end, STDERR_FILENO);
    crash_last_act(last_act);
    const struct rlimit limit = {(rlim_t)256 << 20, (rlim_t)256 << 20};
    setrlimit(RLIMIT_AS, &limit);
    char *filler;
    for (size_t size = (size_t)128 << 20; size >= 4096;
         size /= 2) { /* until nothing is left but small change */
        while ((filler = malloc(size))) {
            filler[0] = 1;
        }
    }
    rl_extend_line_buffer(1 << 24);
    _exit(7);
}

TEST(test_readline_without_memory)
{
    const char *config = getenv("CONFIG");
    if (config && strcmp(config, "asan") == 0) {
        print_message("# sanitizers keep an address space of their own\n");
        skip();
    }
    int ends[2];
    char said[200] = "";
    int status;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        run_out(ends[1]);
    }
    close(ends[1]);
    size_t len = 0;
    for (ssize_t n; (n = read(ends[0], said + len, sizeof said - 1 - len)) > 0;) {
        len += (size_t)n;
    }
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 1);
    assert_string_equal(said, "savedhooke: error: out of memory\n");
}

RUN_TESTS(NULL, NULL)
