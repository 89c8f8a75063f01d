/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Standard input and output that are no terminal, one or both: batch, byte for byte, whatever the
 * bytes are. */
#include "cmocka_testing.h"

#include "terminal/person.h"
#include "terminal/terminal.h"

static pid_t launch(int in, int out, int err)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        dup2(in, STDIN_FILENO);
        dup2(out, STDOUT_FILENO);
        dup2(err, STDERR_FILENO);
        for (int fd = STDERR_FILENO + 1; fd < 32; fd++) {
            close(fd);
        }
        setenv("TERM", "xterm-256color", 1);
        setenv("LC_ALL", "C.UTF-8", 1);
        setenv("XDG_STATE_HOME", state_folder, 1);
        const char *hooke = getenv("HOOKE");
        execl(hooke ? hooke : "build/hooke", "hooke", (char *)NULL);
        _exit(127);
    }
    return child;
}

static int status_of(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

/* Everything until the other side is closed. */
static void read_all(int fd, struct buffer *content)
{
    char chunk[4096];
    ssize_t got;
    while ((got = read(fd, chunk, sizeof chunk)) > 0) {
        buffer_put(content, (struct text){chunk, (size_t)got});
    }
    buffer_put(content, TEXT(""));
    close(fd);
}

/* A prompt, a colour or an echo by readline would be seen in what arrives. */
static void test_pipes(void **state)
{
    (void)state;
    for (int kind = 1; kind < 4; kind++) {
        const bool input_piped = kind & 1, output_piped = kind & 2;
        int master, slave, in[2], out[2];
        struct buffer said = {0};
        assert_int_equal(openpty(&master, &slave, NULL, NULL, NULL), 0);
        assert_int_equal(pipe(in), 0);
        assert_int_equal(pipe(out), 0);
        struct termios modes;
        tcgetattr(slave, &modes);
        modes.c_lflag &= ~(tcflag_t)ECHO; /* of the terminal's own */
        tcsetattr(slave, TCSANOW, &modes);
        const pid_t child =
            launch(input_piped ? in[0] : slave, output_piped ? out[1] : slave, out[1]);
        close(slave);
        close(in[0]);
        close(out[1]);
        /* a prefix: only at a prompt */
        static const char typed[] = "print\t6*7\nrun 1 s; pri y > 0\n\x04";
        const size_t len = sizeof typed - 1 - input_piped;
        assert_int_equal(write(input_piped ? in[1] : master, typed, len), (ssize_t)len);
        close(in[1]);
        if (output_piped) {
            read_all(out[0], &said);
            close(master);
        } else {
            read_all(master, &said); /* ends when nobody has the slave any more */
            close(out[0]);
        }
        assert_int_equal(status_of(child), 1);
        assert_int_equal(strncmp(said.data, output_piped ? "42\nt = 1 s" : "42\r\nt = 1 s", 9), 0);
        assert_null(strchr(said.data, '\033'));
        assert_null(strstr(said.data, "hooke>"));
        buffer_free(&said);
    }
}

/* What a file holds, as standard input: results and messages, exit status. */
static int run_bytes(struct text bytes, struct buffer *said)
{
    char path[] = "/tmp/hooke-input-XXXXXX";
    const int in = mkstemp(path);
    int out[2], ignored;
    assert_true(in >= 0);
    unlink(path);
    assert_true(write_all(in, bytes, &ignored));
    assert_int_equal(lseek(in, 0, SEEK_SET), 0);
    assert_int_equal(pipe(out), 0);
    const pid_t child = launch(in, out[1], out[1]);
    close(in);
    close(out[1]);
    buffer_clear(said);
    read_all(out[0], said);
    return status_of(child);
}

#define RUN(literal, said) run_bytes((struct text){(literal), sizeof(literal) - 1}, (said))

static void test_scripts_from_standard_input(void **state)
{
    (void)state;
    struct buffer said = {0}, line = {0};
    /* no final newline */
    assert_int_equal(RUN("\xEF\xBB\xBFm\t=\t300 g\r\nprint \\\r\n\tm\r\nprint 6*7", &said), 0);
    assert_string_equal(said.data, "m = 300 g\n300 g\n42\n");
    assert_int_equal(RUN("", &said), 0);
    assert_string_equal(said.data, "");
    assert_int_equal(RUN("print 1\nprint\0 2\nprint 3\n", &said), 1);
    assert_non_null(strstr(said.data, "-:2:"));
    assert_non_null(strstr(said.data, "NUL byte"));
    assert_null(strstr(said.data, "\n3\n"));
    for (size_t excess = 0; excess < 2; excess++) { /* the longest line, and one byte more */
        buffer_clear(&line);
        buffer_put(&line, TEXT("echo "));
        while (line.len < LIMIT_LINE + excess) {
            buffer_char(&line, 'x');
        }
        buffer_put(&line, TEXT("\nprint 6*7\n"));
        assert_int_equal(run_bytes(buffer_text(&line), &said), excess);
        if (excess) {
            assert_non_null(strstr(said.data, "the line is longer than 1048576 bytes"));
            assert_null(strstr(said.data, "42"));
        } else {
            assert_int_equal(said.len, LIMIT_LINE - 5 + 1 + 3);
        }
    }
    buffer_free(&line);
    buffer_free(&said);
}

int main(void)
{
    if (!make_folder(state_folder)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pipes),
        cmocka_unit_test(test_scripts_from_standard_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
