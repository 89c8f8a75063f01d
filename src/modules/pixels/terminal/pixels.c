/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shows figures as pictures in the terminal. The terminal is asked once which protocol it knows:
 * for kitty's graphics (with a picture of one pixel), for its name (XTVERSION, which iTerm2
 * answers), and for its attributes (DA1, in which 4 means sixel). Every terminal answers the last
 * question, and after the others. */
#define _GNU_SOURCE /* memmem */
#include "modules/pictures/pictures.h"
#include <hooke/base/cancel.h>
#include "modules/pixels/sixel.h"
#include "terminal/parts.h"

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <readline/readline.h>

/* The three questions: kitty's graphics, name, attributes. */
#define GRAPHICS_QUERY "\033_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\033\\\033[>q\033[c"
#define PATIENCE_NS 1000000000 /* [ns] time to wait for answers, enough for a slow link */
#define LATE_MS 100            /* [ms] largest time between two bytes of an answer */
/* [pixel] size of a cell if the terminal does not tell it: that of a VT340 */
#define CELL_WIDTH 10
#define CELL_HEIGHT 20
#define SEQUENCE_BYTES 4096 /* [byte] part of a picture in one escape sequence */

/* Protocols for pictures, the better ones first. */
enum protocol { PROTOCOL_UNKNOWN, PROTOCOL_NONE, PROTOCOL_KITTY, PROTOCOL_ITERM, PROTOCOL_SIXEL };

/* State of the program's terminal. */
static struct {
    enum protocol protocol;
    bool owed; /* answers may still come, because waiting for them has ended */
    struct streams *streams;
} pixels;

/* ---- answers ---- */

/*
 * Returns the length of the answer that the text begins with, 0 if it begins with none, or SIZE_MAX
 * if it could become one. Answers are ESC _ G ... ESC \, ESC P > | ... ESC \ and ESC [ ? ... c.
 */
static size_t answer_length(struct text text)
{
    static const char *const begins[] = {"\033_G", "\033P>|", "\033[?"};
    for (size_t i = 0; i < COUNT_OF(begins); i++) {
        const size_t whole = strlen(begins[i]), len = text.len < whole ? text.len : whole;
        if (len == 0 || memcmp(text.data, begins[i], len) != 0)
            continue;
        for (size_t k = whole; k < text.len; k++) {
            const char c = text.data[k];
            if (i < 2 ? c == '\\' && text.data[k - 1] == '\033' : c == 'c')
                return k + 1;
            if (i == 2 && !strchr("0123456789;", c))
                return 0;
        }
        return SIZE_MAX;
    }
    return 0;
}

/* Returns true if the attributes in a terminal's answer to DA1, "ESC [ ? 6x ; … c", contain 4,
 * which means sixel. The first number is the class of the terminal, no attribute. */
static bool has_sixels(struct text attributes)
{
    /* the numbers, between three characters (ESC [ ?) and the final c */
    const struct text inside = {attributes.data + 3, attributes.len - 4};
    struct text rest = inside, part;
    for (bool first = true; text_split(&rest, ';', &part); first = false)
        if (!first && text_is(part, "4"))
            return true;
    return false;
}

/* Updates *best, the best protocol so far, by an answer of the terminal. Returns true if it is the
 * answer to the last query, after which no more follow. */
static bool evaluate_answer(struct text answer, enum protocol *best)
{
    enum protocol says = PROTOCOL_NONE;
    if (answer.data[1] == '_' && answer.len > 5 && memmem(answer.data, answer.len, ";OK", 3))
        says = PROTOCOL_KITTY;
    else if (answer.data[1] == 'P' && memmem(answer.data, answer.len, "iTerm2", 6))
        says = PROTOCOL_ITERM;
    else if (answer.data[1] == '[' && has_sixels(answer))
        says = PROTOCOL_SIXEL;
    if (says != PROTOCOL_NONE && (*best == PROTOCOL_NONE || says < *best))
        *best = says;
    return answer.data[1] == '[';
}

/* Reads the terminal's answers until the last one or until PATIENCE_NS has passed, and raises *best
 * to the best protocol among them. Answers are removed from `bytes`; keys that were typed meanwhile
 * remain there. Returns false if the last answer does not come in time. */
static bool await_answers(struct buffer *bytes, enum protocol *best)
{
    const int64_t deadline = clock_ns() + PATIENCE_NS;
    size_t position = 0;
    for (;;) {
        const int64_t left = deadline - clock_ns();
        struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
        char chunk[256];
        if (left <= 0 || cancelled(&interrupt) || poll(&ready, 1, (int)(left / 1000000) + 1) <= 0)
            return false;
        const ssize_t got = read(STDIN_FILENO, chunk, sizeof chunk);
        if (got <= 0)
            return false;
        buffer_put(bytes, (struct text){chunk, (size_t)got});
        while (!bytes->failed && position < bytes->len) {
            const size_t len =
                answer_length((struct text){bytes->data + position, bytes->len - position});
            if (len == SIZE_MAX)
                break;
            if (len == 0) {
                position++;
                continue;
            }
            const bool last = evaluate_answer((struct text){bytes->data + position, len}, best);
            memmove(bytes->data + position, bytes->data + position + len,
                    bytes->len - position - len);
            bytes->len -= len;
            if (last)
                return true;
        }
    }
}

/* Asks the terminal which graphics protocols it supports and returns the best one, or PROTOCOL_NONE
 * if it does not answer or input or output is no terminal. The terminal is in raw mode while the
 * answer is awaited. `at_prompt` means that readline is active: it then receives keys that were
 * typed meanwhile. Sets pixels.owed if an answer is outstanding. */
static enum protocol protocol_query(bool at_prompt)
{
    struct termios saved, raw;
    struct buffer bytes = {0};
    enum protocol best = PROTOCOL_NONE;
    int failure;
    if (!isatty(STDIN_FILENO) || !isatty(STDOUT_FILENO) || tcgetattr(STDIN_FILENO, &saved) != 0)
        return PROTOCOL_NONE;
    raw = saved;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    if (!at_prompt) { /* the prompt has already done this */
        crash_modes();
        crash_arm(TEXT(""));
    }
    if (tcsetattr(STDIN_FILENO, TCSANOW, &raw) != 0)
        return PROTOCOL_NONE;
    pixels.owed =
        write_all(STDOUT_FILENO, TEXT(GRAPHICS_QUERY), &failure) && !await_answers(&bytes, &best);
    tcsetattr(STDIN_FILENO, TCSANOW, &saved);
    if (!at_prompt)
        crash_disarm();
    for (size_t i = 0; at_prompt && i < bytes.len; i++)
        rl_stuff_char((unsigned char)bytes.data[i]); /* keys of the next line */
    buffer_free(&bytes);
    return best;
}

/* Skips an answer that comes late, before readline gets it as keys. `key` is the first byte.
 * Returns NO_KEY if it began an answer, else the key. */
static int skip_late_answer(int key)
{
    if (!pixels.owed || key != '\033')
        return key;
    char text[256] = {(char)key};
    size_t len = 1, answer;
    while ((answer = answer_length((struct text){text, len})) == SIZE_MAX && len < sizeof text) {
        struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
        if (poll(&ready, 1, LATE_MS) <= 0 || read(STDIN_FILENO, text + len, 1) != 1)
            break;
        len++;
    }
    if (answer > 0 && answer != SIZE_MAX) {
        pixels.owed = text[1] != '[';
        return NO_KEY;
    }
    for (size_t i = 1; i < len; i++)
        rl_stuff_char((unsigned char)text[i]);
    return key;
}

/* ---- pictures ---- */

/* Appends a PNG picture (base64) for kitty: transmit and display, without an answer
 * (https://sw.kovidgoyal.net/kitty/graphics-protocol). */
static void put_kitty(struct text code, int columns, struct buffer *output)
{
    for (size_t i = 0; i < code.len; i += SEQUENCE_BYTES) {
        const size_t n = code.len - i < SEQUENCE_BYTES ? code.len - i : SEQUENCE_BYTES;
        buffer_put(output, TEXT("\033_G"));
        if (i == 0)
            buffer_format(output, "a=T,f=100,q=2,c=%d,", columns);
        buffer_format(output, "m=%d;", i + n < code.len);
        buffer_put(output, (struct text){code.data + i, n});
        buffer_put(output, TEXT("\033\\"));
    }
}

/* Appends a picture of `size` bytes (base64) for iTerm2
 * (https://iterm2.com/documentation-images.html). */
static void put_iterm(struct text code, size_t size, int columns, struct buffer *output)
{
    buffer_format(output, "\033]1337;File=inline=1;preserveAspectRatio=1;size=%zu;width=%d:", size,
                  columns);
    buffer_put(output, code);
    buffer_char(output, '\a');
}

/* Sets page {width, height} [pt, two pixels each] of a picture that is as wide as `columns` cells
 * and at most `rows` cells high. The size of a cell is what the terminal reports, else a usual one.
 */
static void choose_page(int columns, int rows, double page[2])
{
    struct winsize size = {0};
    double cell[2] = {CELL_WIDTH, CELL_HEIGHT};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_xpixel >= size.ws_col &&
        size.ws_ypixel >= size.ws_row && size.ws_col > 0 && size.ws_row > 0) {
        cell[0] = (double)size.ws_xpixel / size.ws_col;
        cell[1] = (double)size.ws_ypixel / size.ws_row;
    }
    page[0] = cell[0] * columns / 2;
    page[1] = fmin(cell[1] * rows / 2, page[0] * PICTURE_HEIGHT / PICTURE_WIDTH);
}

/* Appends a picture of raw pixels (PICTURE_PIXELS of that page) as sixels. Returns false if out of
 * memory. */
static bool put_sixel(const struct buffer *picture, const double page[2], struct buffer *output)
{
    const int width = (int)(PICTURE_PIXELS_EACH * page[0]);
    const size_t stride = 4 * (size_t)width;
    return sixel_write((const unsigned char *)picture->data, stride, width,
                       (int)(picture->len / stride), output);
}

/* Makes the picture of a figure in width x height cells and writes it to the terminal by its
 * protocol. Returns false with an error. */
static bool pixels_figure_show(const struct figure *figure, int width, int height,
                               struct error *error)
{
    struct buffer picture = {0}, code = {0}, output = {0};
    double page[2];
    const enum protocol protocol = pixels.protocol;
    const enum picture kind = protocol == PROTOCOL_SIXEL ? PICTURE_PIXELS : PICTURE_PNG;
    choose_page(width, height, page);
    bool ok = figure_picture(figure, kind, page[0], page[1], &picture, error);
    if (ok && kind == PICTURE_PNG)
        buffer_base64(&code, buffer_text(&picture));
    if (ok && protocol == PROTOCOL_KITTY)
        put_kitty(buffer_text(&code), width, &output);
    else if (ok && protocol == PROTOCOL_ITERM)
        put_iterm(buffer_text(&code), picture.len, width, &output);
    else if (ok)
        ok = put_sixel(&picture, page, &output) || error_memory(error);
    buffer_char(&output, '\n');
    if (ok && (code.failed || output.failed))
        ok = error_memory(error);
    if (ok && streams_flush(pixels.streams)) {
        int *failure = &pixels.streams->failure;
        pixels.streams->broken = !write_all(STDOUT_FILENO, buffer_text(&output), failure);
    }
    buffer_free(&picture);
    buffer_free(&code);
    buffer_free(&output);
    return ok;
}

/* Shows a figure as a picture of width x height cells; a NULL figure only finds out whether the
 * terminal can show pictures. Returns false with an error if it cannot. */
static bool pixels_show(const struct front *front, const struct figure *figure, int width,
                        int height, struct error *error)
{
    if (pixels.protocol == PROTOCOL_UNKNOWN && streams_flush(pixels.streams))
        pixels.protocol = protocol_query(front->interactive);
    if (pixels.protocol == PROTOCOL_NONE || pixels.protocol == PROTOCOL_UNKNOWN) {
        error_set(error, ERROR_COMMAND, "%s",
                  isatty(STDIN_FILENO) && isatty(STDOUT_FILENO)
                      ? "this terminal does not report that it can show pictures"
                      : "there is no terminal that could show pixels");
        return error_hint(error, "'> FILE.png' writes a picture");
    }
    return !figure || pixels_figure_show(figure, width, height, error);
}

static void offer(struct front *front, struct streams *streams)
{
    pixels.streams = streams;
    front->pixels = pixels_show;
}

const struct terminal_part pixels_terminal = {.offer = offer, .key = skip_late_answer};
