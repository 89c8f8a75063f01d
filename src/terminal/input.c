/* SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE /* memmem */
#include "terminal/panes.h"
#include <hooke/base/cancel.h>

#include <errno.h>
#include <string.h>
#include <unistd.h>

#define PASTE_BEGIN "\033[200~"
#define PASTE_END "\033[201~"
#define INPUT_MAX (2 * (size_t)LIMIT_LINE) /* [byte] waiting; a longer paste is cut */

void input_read(struct input *input, bool gone)
{
    char chunk[4096];
    const ssize_t got = read(STDIN_FILENO, chunk, sizeof chunk);
    if (got <= 0) {
        input->closed |= gone || (got < 0 && errno != EINTR && errno != EAGAIN);
        return;
    }
    if (input->head > 0 && input->head == input->bytes.len) {
        input->head = 0;
        buffer_clear(&input->bytes);
    }
    if (input->bytes.len - input->head < INPUT_MAX) {
        buffer_put(&input->bytes, (struct text){chunk, (size_t)got});
    }
    if (input->bytes.failed) { /* the waiting bytes are lost, the keyboard is not */
        input_free(input);
    }
    input->arrived = clock_ns();
}

static struct text waiting(const struct input *input)
{
    return input->bytes.data
               ? (struct text){input->bytes.data + input->head, input->bytes.len - input->head}
               : TEXT("");
}

/* The text begins with the sequence, or could become it with what is still to come. */
static bool begins(struct text text, struct text sequence, bool *partly)
{
    const size_t len = text.len < sequence.len ? text.len : sequence.len;
    const bool same = memcmp(text.data, sequence.data, len) == 0;
    *partly |= same && len > 0 && len < sequence.len;
    return same && len == sequence.len;
}

enum input_item input_next(struct input *input, int64_t now, unsigned char *byte,
                           struct text *paste)
{
    const struct text text = waiting(input);
    bool partly = false;
    if (text.len == 0) {
        return INPUT_NONE;
    }
    if (begins(text, TEXT(REPLY_TEXT), &partly)) {
        input->head += sizeof REPLY_TEXT - 1;
        return INPUT_REPLY;
    }
    if (begins(text, TEXT(PASTE_BEGIN), &partly)) {
        const struct text inside = {text.data + sizeof PASTE_BEGIN - 1,
                                    text.len - (sizeof PASTE_BEGIN - 1)};
        const char *end = memmem(inside.data, inside.len, PASTE_END, sizeof PASTE_END - 1);
        if (!end && inside.len < INPUT_MAX / 2) {
            return INPUT_NONE; /* the rest is still to come */
        }
        *paste = (struct text){inside.data, end ? (size_t)(end - inside.data) : inside.len};
        input->head =
            end ? (size_t)(end - input->bytes.data) + sizeof PASTE_END - 1 : input->bytes.len;
        return INPUT_PASTE;
    }
    if (partly && now - input->arrived < HELD_NS) {
        return INPUT_NONE;
    }
    *byte = (unsigned char)text.data[0];
    input->head++;
    return INPUT_BYTE;
}

int64_t input_due(const struct input *input)
{
    const struct text text = waiting(input);
    bool partly = false;
    return text.len == 0 || begins(text, TEXT(PASTE_BEGIN), &partly) ||
                   clock_ns() - input->arrived >= HELD_NS
               ? INT64_MAX
               : input->arrived + HELD_NS;
}

bool input_pending(const struct input *input)
{
    const struct text text = waiting(input);
    bool partly = false;
    return text.len > 0 && !begins(text, TEXT(REPLY_TEXT), &partly) &&
           !begins(text, TEXT(PASTE_BEGIN), &partly) && !partly;
}

bool input_strip_reply(struct input *input)
{
    const struct text text = waiting(input);
    char *reply = text.len ? memmem(input->bytes.data + input->head, text.len, REPLY_TEXT,
                                    sizeof REPLY_TEXT - 1)
                           : NULL;
    if (reply) {
        const char *tail = reply + sizeof REPLY_TEXT - 1;
        input->bytes.len -= sizeof REPLY_TEXT - 1;
        memmove(reply, tail, (size_t)(input->bytes.data + input->bytes.len - reply) + 1);
    }
    return reply != NULL;
}

void input_clear(struct input *input)
{
    input->head = 0;
    buffer_clear(&input->bytes);
}

void input_free(struct input *input)
{
    buffer_free(&input->bytes);
    *input = (struct input){0};
}
