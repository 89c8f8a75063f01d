/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `plot --pixels` in terminals that answer as kitty, iTerm2, a sixel terminal or not at all: what
 * comes is the picture that a file would hold, and no answer gets into the line. */
#include "cmocka_testing.h"

#include <math.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utmp.h>

#include "modules/pixels/sixel.h"
#include "terminal/folder.h"

#include <hooke/base/cancel.h>

#define PATIENCE_NS 60000000000
#define PROMPT "hooke> "
#define DA1 "\033[?62;22c"
#define DA1_SIXEL "\033[?62;4;22c"

static char folder[] = "/tmp/hooke-pixels-XXXXXX";

struct terminal {
    pid_t program;
    int fd;
    struct buffer seen;
    size_t read; /* what was waited for lies before */
    const char *answer;
    bool answered;
};

static void begin(struct terminal *t, const char *answer)
{
    struct winsize size = {.ws_row = 24, .ws_col = 80, .ws_xpixel = 1280, .ws_ypixel = 960};
    int slave;
    *t = (struct terminal){.answer = answer};
    assert_int_equal(openpty(&t->fd, &slave, NULL, NULL, &size), 0);
    t->program = fork();
    if (t->program == 0) {
        const char *hooke = getenv("HOOKE");
        char path[4096];
        close(t->fd);
        if (!realpath(hooke ? hooke : "build/hooke", path) || chdir(folder) != 0)
            _exit(127);
        login_tty(slave);
        setenv("TERM", "xterm-256color", 1);
        setenv("LC_ALL", "C.UTF-8", 1);
        setenv("XDG_STATE_HOME", folder, 1);
        setenv("INPUTRC", "/dev/null", 1);
        execl(path, "hooke", "-n", "--plain", (char *)NULL);
        _exit(127);
    }
    close(slave);
}

static void say(struct terminal *t, const char *text)
{
    assert_int_equal(write(t->fd, text, strlen(text)), (ssize_t)strlen(text));
}

/* Where, behind what was waited for before, the text begins, or SIZE_MAX: the other came (NULL:
 * none); everything of a terminal is done. */
static size_t await_either(struct terminal *t, const char *text, const char *other)
{
    const int64_t until = clock_ns() + PATIENCE_NS;
    for (;;) {
        const char *from = t->seen.data ? t->seen.data + t->read : "", *at = strstr(from, text);
        if (at) {
            const size_t begins = (size_t)(at - t->seen.data);
            t->read = begins + strlen(text);
            return begins;
        }
        if (other && strstr(from, other))
            return SIZE_MAX;
        struct pollfd ready = {.fd = t->fd, .events = POLLIN};
        char chunk[4096];
        ssize_t got = 0;
        if (clock_ns() > until || poll(&ready, 1, (int)(PATIENCE_NS / 1000000)) <= 0 ||
            (got = read(t->fd, chunk, sizeof chunk)) <= 0) {
            kill(t->program, SIGKILL);
            fail_msg("waited in vain for '%s', saw '%s'", text, from);
        }
        buffer_put(&t->seen, (struct text){chunk, (size_t)got});
        if (!t->answered && t->answer && strstr(t->seen.data, "\033[c")) {
            t->answered = true;
            say(t, t->answer);
        }
    }
}

static size_t await(struct terminal *t, const char *text)
{
    return await_either(t, text, NULL);
}

static void end(struct terminal *t)
{
    int status;
    say(t, "quit\r");
    await(t, "quit");
    while (waitpid(t->program, &status, WNOHANG) == 0) {
        struct pollfd ready = {.fd = t->fd, .events = POLLIN};
        char chunk[4096];
        if (poll(&ready, 1, 20) > 0 && read(t->fd, chunk, sizeof chunk) < 0)
            poll(NULL, 0, 5);
    }
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    close(t->fd);
    buffer_free(&t->seen);
}

static void do_line(struct terminal *t, const char *line)
{
    say(t, line);
    say(t, "\r");
    await(t, "\n");
    await(t, PROMPT);
}

static void begin_with_run(struct terminal *t, const char *answer)
{
    begin(t, answer);
    await(t, PROMPT);
    do_line(t, "run 5 s");
    say(t, "plot phase --pixels\r");
    await(t, "\033[c");
}

#ifdef HAVE_CAIRO

/* Where the picture begins. A machine that stands still for a second answers too late: again. */
static size_t begin_with_picture(struct terminal *t, const char *answer, const char *begins)
{
    for (int tries = 0;; tries++) {
        begin_with_run(t, answer);
        const size_t at = await_either(t, begins, tries < 5 ? "does not report" : NULL);
        if (at != SIZE_MAX)
            return at;
        await(t, PROMPT);
        end(t);
    }
}

static void drop_base64(const char *code, size_t len, struct buffer *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned word = 0;
    int bits = 0;
    for (size_t i = 0; i < len; i++) {
        const char *digit = code[i] == '=' ? NULL : strchr(digits, code[i]);
        if (!digit)
            continue;
        word = word << 6 | (unsigned)(digit - digits);
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            buffer_char(out, (char)(word >> bits & 0xff));
        }
    }
}

static void same_as_file(const struct buffer *picture, const char *name)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *content = malloc(picture->len + 1);
    assert_int_equal(fread(content, 1, picture->len + 1, file), picture->len);
    assert_memory_equal(content, picture->data, picture->len);
    free(content);
    fclose(file);
}

static void test_kitty(void **state)
{
    (void)state;
    struct terminal t;
    struct buffer picture = {0};
    const size_t at = begin_with_picture(&t, "\033_Gi=31;OK\033\\\033P>|kitty(0.35)\033\\" DA1,
                                         "\033_Ga=T,f=100,q=2,c=80,m=1;");
    await(&t, "m=0;");
    await(&t, PROMPT);
    const char *piece = t.seen.data + at;
    while (strncmp(piece, "\033_G", 3) == 0) {
        const char *code = strchr(piece, ';') + 1, *stop = strstr(code, "\033\\");
        assert_true(stop - code <= 4096);
        drop_base64(code, (size_t)(stop - code), &picture);
        piece = stop + 2;
    }
    do_line(&t, "plot phase > kitty.png");
    same_as_file(&picture, "kitty.png");
    /* it is not asked again */
    const size_t before = t.seen.len;
    do_line(&t, "plot phase --pixels");
    assert_null(strstr(t.seen.data + before, "\033[c"));
    assert_non_null(strstr(t.seen.data + before, "\033_Ga=T"));
    buffer_free(&picture);
    end(&t);
}

static void test_iterm(void **state)
{
    (void)state;
    struct terminal t;
    struct buffer picture = {0};
    begin_with_picture(&t, "\033P>|iTerm2 3.5.0\033\\" DA1_SIXEL,
                       "\033]1337;File=inline=1;preserveAspectRatio=1;size=");
    const size_t number = t.read, at = await(&t, ";width=80:") + 10;
    const size_t size = strtoul(t.seen.data + number, NULL, 10);
    const size_t stop = await(&t, "\a");
    await(&t, PROMPT);
    drop_base64(t.seen.data + at, stop - at, &picture);
    assert_int_equal(picture.len, size);
    do_line(&t, "plot phase > iterm.png");
    same_as_file(&picture, "iterm.png");
    buffer_free(&picture);
    end(&t);
}

static void test_sixel(void **state)
{
    (void)state;
    struct terminal t;
    const size_t at = begin_with_picture(&t, DA1_SIXEL, "\033P0;1q\"1;1;1280;800#0;2;100;100;100");
    const size_t stop = await(&t, "\033\\");
    await(&t, PROMPT);
    int bands = 0;
    for (size_t i = at; i < stop; i++)
        bands += t.seen.data[i] == '-';
    assert_int_equal(bands, (800 + 5) / 6);
    end(&t);
}
#endif

/* The terminal says only that it is one; what was typed before it answered is not lost. */
static void test_none(void **state)
{
    (void)state;
    struct terminal t;
    begin_with_run(&t, "print 6*7" DA1 "\r");
    await(&t, "does not report that it can show pictures; '> FILE.png'");
    await(&t, "phase v");
    await(&t, "42\r\n");
    await(&t, PROMPT);
    end(&t);
}

/* Patience is over before the answer comes: it is taken out of what is typed. */
static void test_late(void **state)
{
    (void)state;
    struct terminal t;
    begin_with_run(&t, NULL);
    await(&t, "does not report");
    await(&t, PROMPT);
    const size_t before = t.seen.len;
    say(&t, "\033_Gi=31;OK\033\\\033P>|kitty(0.35)\033\\" DA1);
    say(&t, "print 6*7\r");
    await(&t, "42\r\n");
    await(&t, PROMPT);
    assert_null(strstr(t.seen.data + before, "kitty"));
    assert_null(strstr(t.seen.data + before, "62;"));
    assert_null(strstr(t.seen.data + before, "\a"));
    end(&t);
}

/* Without a terminal the bytes are those of a plot in text. */
static void test_no_terminal(void **state)
{
    (void)state;
    const char *hooke = getenv("HOOKE");
    char text[2][8192] = {"", ""};
    for (int i = 0; i < 2; i++) {
        struct buffer command = {0};
        buffer_format(&command, "%s -n -c 'run 5 s; plot phase%s' 2>/dev/null </dev/null",
                      hooke ? hooke : "build/hooke", i ? " --pixels" : "");
        FILE *out = popen(command.data, "r");
        assert_non_null(out);
        assert_true(fread(text[i], 1, sizeof text[i] - 1, out) > 1000);
        assert_int_equal(pclose(out), 0);
        buffer_free(&command);
    }
    assert_string_equal(text[0], text[1]);
}

/* ---- the encoder, against a decoder that knows nothing of it ---- */

static void test_sixels_decode(void **state)
{
    (void)state;
    enum { WIDTH = 37, HEIGHT = 23 };
    uint32_t pixel[HEIGHT][WIDTH];
    int percent[64][3], decoded[HEIGHT][WIDTH];
    unsigned seed = 1;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            seed = seed * 1103515245 + 12345;
            const uint32_t level = seed >> 16 & 3, other = seed >> 20 & 3;
            pixel[y][x] = x < 12 ? 0xffffff : level * 85 << 16 | other * 85 << 8 | 0x11;
            decoded[y][x] = -1;
        }
    struct buffer out = {0};
    assert_true(sixel_write((const unsigned char *)pixel, sizeof pixel[0], WIDTH, HEIGHT, &out));
    const char *at = strchr(out.data, '#');
    int x = 0, top = 0, color = 0, used;
    while (*at != '\033') {
        int count = 1, c, r, g, b;
        if (sscanf(at, "#%d;2;%d;%d;%d%n", &c, &r, &g, &b, &used) == 4) {
            percent[c][0] = r, percent[c][1] = g, percent[c][2] = b;
            at += used;
        } else if (sscanf(at, "#%d%n", &color, &used) == 1) {
            at += used;
        } else if (*at == '$' || *at == '-') {
            x = 0;
            top += *at++ == '-' ? 6 : 0;
        } else {
            if (sscanf(at, "!%d%n", &count, &used) == 1)
                at += used;
            const int bits = *at++ - 63;
            for (; count > 0; count--, x++)
                for (int y = 0; y < 6; y++)
                    if (bits >> y & 1) {
                        assert_true(x < WIDTH && top + y < HEIGHT);
                        decoded[top + y][x] = color;
                    }
        }
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int i = 0; i < WIDTH; i++) {
            assert_true(decoded[y][i] >= 0);
            for (int k = 0; k < 3; k++) {
                const int wanted = (int)(pixel[y][i] >> (16 - 8 * k) & 0xff);
                const int got = percent[decoded[y][i]][k];
                assert_true(abs(wanted * 100 - got * 255) <= 128);
            }
        }
    buffer_free(&out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef HAVE_CAIRO
        cmocka_unit_test(test_kitty),       cmocka_unit_test(test_iterm),
        cmocka_unit_test(test_sixel),
#endif
        cmocka_unit_test(test_none),        cmocka_unit_test(test_late),
        cmocka_unit_test(test_no_terminal), cmocka_unit_test(test_sixels_decode),
    };
    if (!make_folder(folder))
        return 2;
    return cmocka_run_group_tests_name("pixels", tests, NULL, NULL);
}
