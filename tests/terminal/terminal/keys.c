/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Keys that mean nothing, in every state of readline: the program lives, Ctrl-C gets out. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "terminal/terminal.h"
#include "terminal/person.h"
#include "unit/random_testing.h"

/* ---- what readline 6.3 to 8.2 was known to die of, or to be stuck in: sequences that are cut or
 * mean nothing, in vi mode (ESC Enter), macros (Debian bug 799943), no history
 * ---------------------------------------------------------------------------------------------- */

static const char *const known[] = {
    "\033\r\033[1\t",
    "\033[200~print 1", /* a paste whose end is lost */
    "\033\r\033[5\t\033[2\t",
    "\022abc", /* a search */
    "\033\r\0333\t",
    "\0331\0332\033", /* a count without a key */
    "\030(\0333\030)\033\r\030e\t",
    "\035", /* a character to be found */
    "\030(a\rb\r\030)\030e",
    "\033\rd", /* an operator without a motion */
    "\030(\030e\030)\030e",
    "\033\ri\033\033\033.\033u",
    "aaa\033[A\033[A",
    "\033\r\033[1\t",
    "\033\r/x\r\033?y\rn",
    "\033\r\305\247\200\0330=",                  /* to the end of a word that is no UTF-8 */
    "r\rp\033\r\r\033[Ay\033./\a\033-\r\022p\r", /* a search left by Ctrl-G */
};

/* A Ctrl-C that is found late forgets what was typed after it: so more than once. */
static void answers(struct person *p)
{
    static int number = 1000;
    char line[64], wanted[16];
    snprintf(line, sizeof line, "print 7*%d\r", ++number);
    snprintf(wanted, sizeof wanted, "%d", 7 * number);
    for (int64_t deadline = clock_ns() + PATIENCE_NS; !shows(p, wanted);) {
        type(p, "\x03");
        settle(p, 20);
        type(p, line);
        for (int i = 0; i < 20 && !shows(p, wanted); i++) {
            pump(p, 50);
        }
        if (p->hung_up || clock_ns() > deadline) {
            expect(p, wanted); /* says what there is instead */
        }
    }
}

/* The quick form does each at one of the prompts only. */
static void test_known(void **state)
{
    (void)state;
    for (size_t plain = 0; plain < 2; plain++) {
        for (size_t i = is_long() ? 0 : plain; i < COUNT_OF(known); i += is_long() ? 1 : 2) {
            struct person p;
            begin(&p, (struct start){.argument = {plain ? "--plain" : NULL},
                                     .environment = "MALLOC_PERTURB_=165"});
            expect(&p, "hooke>");
            type(&p, known[i]);
            settle(&p, 20);
            answers(&p);
            type(&p, "quit\r");
            assert_int_equal(end(&p), 0);
        }
    }
}

/* A count before Enter: readline, driven by keys, ended such a line with the key after it. */
static void test_count_before_enter(void **state)
{
    (void)state;
    for (int plain = 0; plain < 2; plain++) {
        struct person p;
        begin(&p, (struct start){.argument = {plain ? "--plain" : NULL}});
        expect(&p, "hooke>");
        type(&p, "print 6*7\0332\r");
        expect(&p, "42");
        type(&p, "print 2*14\033-\r"); /* a sign alone */
        expect(&p, "28");
        type(&p, "quit\r");
        assert_int_equal(end(&p), 0);
    }
}

/* ---- at random
 * ---------------------------------------------------------------------------------------------- */

static const char *const pieces[] = {
    /* sequences, whole and cut */
    "\033\r", "\033", "\033[", "\033[1", "\033[1;", "\033O", "\033[A", "\033[B", "\033[C", "\033[D",
    "\033OA", "\033OB", "\033[1;5C", "\033[3~", "\033[5~", "\033[6~", "\033OP", "\033[15~",
    "\033[17~", "\033[18~", "\033[19~", "\033[H", "\033[F", "\033[Z", "\033[99;99;99x", "\033[0n",
    "\033[200~", "\033[201~", "abc\ndef", "\033_Gi=1;OK", "\033\\", "\033[?62;4c",
    /* UTF-8, whole and cut */
    "\303\251", "\342\202\254", "\360\237\230\200", "\303", "\342\202", "\377", "\200", "\360\237",
    "e\314\201",
    /* editing */
    "\030(", "\030)", "\030e", "\030\030", "\030\025", "\022", "\023", "\a", "\v", "\031", "\033y",
    "\033.", "\033\031", "\025", "\027", "\024", "\033t", "\033u", "\033c", "\033l", "\037",
    "\033<", "\033>", "\033p", "\033n", "\033#", "\033*", "\033?", "\033=", "\033~", "\033&",
    "\033\177", "\177", "\001", "\005", "\002", "\006", "\020", "\016", "\026", "\035", "\033\035",
    "\033 ", "\033g", "\017", "\0331", "\033-", "\t", "\t\t",
    /* panes */
    "\030", "\030h", "\030r", "\030l", "\030c", "\030s", "\0301", "\030+", "\030-", "\030a",
    /* vi, cursors, reading */
    "q", "/", "?", "n", "N", ":", "d", "c", "y", "w", "b", "$", "0", "3", "12", "f", "F", "x", "r",
    "R", "i", "a", "A", "I", "u", ".", "%", "|", "~", "=", "*", "@", "m", "`", "\"", "'", " ", "p",
    "C", "D", "G", "k", "j", "h", "l", "-", "+", ";", "^", "_", "!",
    /* commands */
    "scene ", "meth", "help", "set ", "plot ", "run 1 s\r", "print 1\r", "cursor\r",
    "help methods\r", "\r", "\r", "\n", "\x03"};

static uint64_t at_random;

static int below(int n)
{
    return (int)(uniform_from(&at_random) * n);
}

/* Some keys, or another size. Returns how many. */
static int press(struct person *p, struct buffer *keys)
{
    static const int sizes[][2] = {{80, 24}, {20, 6}, {40, 12}, {120, 40}, {200, 60}};
    if (below(50) == 0) {
        const int known_size = below(2 * (int)COUNT_OF(sizes));
        const bool other = known_size >= (int)COUNT_OF(sizes);
        resize(p, other ? 1 + below(250) : sizes[known_size][0],
               other ? 1 + below(80) : sizes[known_size][1]);
        return 1;
    }
    buffer_clear(keys);
    for (int n = 1 + below(12); n > 0; n--) {
        const int byte = below(256);
        if (below(100) < 85)
            buffer_put(keys, text_of(pieces[below((int)COUNT_OF(pieces))]));
        else if (byte != '\004' && byte != '\032' && byte != '\034') /* leave, stop, end */
            buffer_char(keys, (char)byte);
    }
    size_t done = 0;
    for (int64_t deadline = clock_ns() + PATIENCE_NS; done < keys->len;) {
        const ssize_t n = write(p->fd, keys->data + done, keys->len - done);
        done += n > 0 ? (size_t)n : 0;
        if (n < 0 && errno != EAGAIN)
            break; /* it has left */
        pump(p, n < 0 ? 20 : 0);
        assert_true(clock_ns() < deadline);
    }
    while (pump(p, 2)) {
    }
    buffer_clear(&p->raw);
    return (int)keys->len;
}

/* Whatever it is in, it can be left. Its wait status. */
static int leave(struct person *p)
{
    static const char *const ways[] = {"\x03",  "\033[201~\x03", "q\x03",
                                       "n\x03", "\x03\033i\025", "\a\025"};
    int status = 0;
    for (size_t i = 0; i < 4 * COUNT_OF(ways); i++) {
        /* The terminal forgets what is typed before a Ctrl-C. */
        const char *const keys[] = {"\x03", ways[i % COUNT_OF(ways)], "quit\r"};
        for (size_t k = 0; k < COUNT_OF(keys); k++) {
            if (write(p->fd, keys[k], strlen(keys[k])) < 0)
                break;
            settle(p, k == 2 ? 300 : 50);
        }
        poll(NULL, 0, 20); /* it may be on its way */
        if (waitpid(p->program, &status, WNOHANG) == p->program)
            return status;
    }
    show_screen(p);
    kill(p->program, SIGKILL);
    waitpid(p->program, &status, 0);
    return status;
}

static void at_keys(bool plain, int seed, int count)
{
    struct person p;
    struct buffer keys = {0};
    int pressed = 0, status = 0;
    at_random = (uint64_t)seed;
    begin(&p, (struct start){.argument = {plain ? "--plain" : NULL}});
    expect(&p, "hooke>");
    assert_int_equal(fcntl(p.fd, F_SETFL, O_NONBLOCK), 0);
    bool ended = false;
    while (pressed < count && !ended) {
        pressed += press(&p, &keys);
        ended = waitpid(p.program, &status, WNOHANG) == p.program;
    }
    status = ended ? status : leave(&p);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        fail_msg("%s, seed %d: wait status %d after %d keys", plain ? "plain" : "panes", seed,
                 status, pressed);
    same_modes(&p);
    buffer_free(&keys);
    forget(&p);
}

static void test_random(void **state)
{
    (void)state;
    const char *first = getenv("SEED"); /* to repeat one */
    const int begun = first ? atoi(first) : 1,
              sessions = first       ? 1
                         : is_long() ? 50
                                     : 1,
              count = is_long() || first ? 2000 : 300;
    signal(SIGPIPE, SIG_IGN);
    for (int i = 0; i < sessions; i++) {
        at_keys(false, begun + i, count);
        at_keys(true, begun + i, count);
    }
}

/* ---- on any terminal
 * ---------------------------------------------------------------------------------------------- */

static void work_at(const char *term, int width, int height)
{
    struct person p;
    begin(&p, (struct start){.term = term, .width = width, .height = height});
    for (int64_t deadline = clock_ns() + PATIENCE_NS; p.raw.len == 0 && clock_ns() < deadline;)
        pump(&p, 1000);
    type(&p, "pri\t\t 7\r");
    settle(&p, 5);
    type(&p, "\025print 6*7\r");
    for (int64_t deadline = clock_ns() + PATIENCE_NS;
         !p.raw.data || !memmem(p.raw.data, p.raw.len, "42", 2);) {
        if (!pump(&p, 100) && (p.hung_up || clock_ns() > deadline)) {
            fail_msg("TERM=%s, %dx%d: no answer", term, width, height);
        }
    }
    type(&p, "quit\r");
    const int status = wait_end(&p);
    if (status != 0) {
        fail_msg("TERM=%s, %dx%d: wait status %d", term, width, height, status);
    }
    same_modes(&p);
    forget(&p);
}

/* Each key that is a command line says which; those of the cursors are silent, and are seen in what
 * is typed next. */
static void test_lines_of_keys(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    enter(&p, "panes");
    expect(&p, "the panes are already shown");
    enter(&p, "speed max; run 5 s");
    expect(&p, "t=5.00 s");
    type(&p, "\030\063"); /* C-x 3 */
    expect(&p, "focus velocity full");
    type(&p, "\030\063");
    expect(&p, "focus velocity shared");
    type(&p, "\030\064");
    expect(&p, "focus energy full");
    type(&p, "\030\061\030+\030>");
    expect(&p, "hooke> pan ");
    type(&p, "\033[18~"); /* F7: the cursors have the keys */
    expect(&p, "cursors (q leaves");
    type(&p, "sq");
    expect_prompt(&p, EMPTY_PROMPT);
    type(&p, "cursor\r");
    expect(&p, "cursors (q leaves");
    type(&p, "g");
    expect_prompt(&p, "hooke> cursor go");
    type(&p, "2.5\r");
    expect(&p, "2.5");
    type(&p, "\033[D\033[Ce");
    expect_prompt(&p, "hooke> export measurements.csv measurements");
    type(&p, "\x15print 6*7\r");
    expect_prompt(&p, "cursors (q leaves, : types a command)>");
    type(&p, "q");
    expect(&p, "42");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
}

/* The point on the portrait: arrows by cells, Enter is the command `start X,Y`. */
static void test_point_on_portrait(void **state)
{
    (void)state;
    struct person p;
    start_panes(&p, (struct start){0});
    enter(&p, "var q = 1; var v = 0; q' = v; v' = -sin(q)-0.2*v");
    enter(&p, "focus portrait full; range x -4:4; range y -2:2");
    expect(&p, "portrait v");
    type(&p, "\033[18~");
    expect_prompt(&p, "cursors (q leaves, : types a command)>");
    expect(&p, "n/N next/previous equilibrium");
    type(&p, "n");
    expect(&p, "on equilibrium 3, saddle");
    type(&p, "N");
    expect(&p, "q = 0   v = 0");
    type(&p, "\033[A");
    expect(&p, "q = 0   v = 0.");
    type(&p, "\033[B");
    expect(&p, "on equilibrium 2, stable focus");
    type(&p, "\033[C\033[C\033[C\033OA\033OA\r");
    expect(&p, "starts: 1 of 16");
    expect(&p, "starts ");
    type(&p, "\033[D\r");
    expect(&p, "starts: 2 of 16");
    type(&p, "\t"); /* of the cursors over time: nothing here */
    type(&p, "?");
    expect(&p, "usage: cursor");
    type(&p, "q"); /* back to the point */
    expect(&p, "arrows move");
    type(&p, ":start v=0.5\r");
    expect(&p, "starts: 3 of 16");
    type(&p, "x");
    expect(&p, "starts: 0 of 16");
    type(&p, "q");
    expect_prompt(&p, EMPTY_PROMPT);
    expect(&p, "hooke> start clear");
    type(&p, "\033[18~");
    expect(&p, "starts: 0 of 16");
    type(&p, ":scene spring\r"); /* the portrait is gone, and the point with it */
    expect(&p, "hooke> scene spring");
    expect_prompt(&p, EMPTY_PROMPT);
    quit(&p);
}

/* Where lines cannot be broken readline divided by a third of the width. */
static void test_any_size(void **state)
{
    (void)state;
    static const char *const terms[] = {"dumb",   "xterm",    "vt100", "linux",
                                        "screen", "nonsense", ""};
    static const int some[][2] = {{1, 1}, {2, 1}, {3, 2}, {2, 24}, {24, 2}, {19, 6}};
    for (size_t t = 0; t < COUNT_OF(terms); t++) {
        for (size_t i = t % 2; i < COUNT_OF(some); i += 2) {
            work_at(terms[t], some[i][0], some[i][1]);
        }
        for (int width = 1; is_long() && width <= 60; width += width < 9 ? 1 : 7) {
            for (int height = 1; height <= 10; height += 3) {
                work_at(terms[t], width, height);
            }
        }
    }
}

int main(int argc, char **argv)
{
    if (!make_folder(state_folder)) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known),
        cmocka_unit_test(test_count_before_enter),
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_lines_of_keys),
        cmocka_unit_test(test_point_on_portrait),
        cmocka_unit_test(test_any_size),
    };
    if (argc > 1) {
        cmocka_set_test_filter(argv[1]);
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
