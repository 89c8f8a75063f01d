/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The bytes that the terminal sends, before readline gets them: pastes and the terminal's replies
 * are taken out. input_read() adds bytes, input_next() takes items. */
#define _GNU_SOURCE /* memmem */
#include "terminal/panes.h"
#include <hooke/base/cancel.h>

#include <errno.h>
#include <string.h>
#include <unistd.h>

/* Sequences around a paste (bracketed paste mode). */
#define PASTE_BEGIN "\033[200~"
#define PASTE_END "\033[201~"
/* [byte] most bytes that wait; a longer paste is cut */
#define INPUT_MAX (2 * (size_t)LIMIT_LINE)

/* Reads the bytes that are available. `gone` means that poll() reported a hang-up. */
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
    if (input->bytes.failed) { /* the waiting bytes are lost if out of memory, later ones are not */
        input_free(input);
    }
    input->arrived = clock_ns();
}

/* Returns the bytes that wait, without copying. */
static struct text waiting_bytes(const struct input *input)
{
    return input->bytes.data
               ? (struct text){input->bytes.data + input->head, input->bytes.len - input->head}
               : TEXT("");
}

/* Returns true if the text begins with the sequence. Sets *partly if it ends within it, so that the
 * rest may still come. */
static bool begins_with_sequence(struct text text, struct text sequence, bool *partly)
{
    const size_t len = text.len < sequence.len ? text.len : sequence.len;
    const bool same = memcmp(text.data, sequence.data, len) == 0;
    *partly |= same && len > 0 && len < sequence.len;
    return same && len == sequence.len;
}

/* Takes the next item: a reply of the terminal, a paste (its text is valid until the next call), or
 * a byte. Returns INPUT_NONE if nothing waits or if a sequence is incomplete. */
enum input_item input_next(struct input *input, int64_t now, unsigned char *byte,
                           struct text *paste)
{
    const struct text text = waiting_bytes(input);
    bool partly = false;
    if (text.len == 0) {
        return INPUT_NONE;
    }
    if (begins_with_sequence(text, TEXT(REPLY_TEXT), &partly)) {
        input->head += sizeof REPLY_TEXT - 1;
        return INPUT_REPLY;
    }
    if (begins_with_sequence(text, TEXT(PASTE_BEGIN), &partly)) {
        const struct text inside = {text.data + sizeof PASTE_BEGIN - 1,
                                    text.len - (sizeof PASTE_BEGIN - 1)};
        const char *end = memmem(inside.data, inside.len, PASTE_END, sizeof PASTE_END - 1);
        if (!end && inside.len < INPUT_MAX / 2) {
            return INPUT_NONE; /* the end of the paste has not arrived */
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

/* Returns the time [clock_ns] at which an incomplete sequence counts as single bytes, or INT64_MAX.
 */
int64_t input_due(const struct input *input)
{
    const struct text text = waiting_bytes(input);
    bool partly = false;
    return text.len == 0 || begins_with_sequence(text, TEXT(PASTE_BEGIN), &partly) ||
                   clock_ns() - input->arrived >= HELD_NS
               ? INT64_MAX
               : input->arrived + HELD_NS;
}

/* Returns true if a key waits, not only a reply or a paste. */
bool input_pending(const struct input *input)
{
    const struct text text = waiting_bytes(input);
    bool partly = false;
    return text.len > 0 && !begins_with_sequence(text, TEXT(REPLY_TEXT), &partly) &&
           !begins_with_sequence(text, TEXT(PASTE_BEGIN), &partly) && !partly;
}

/* Removes the terminal's reply from the waiting bytes. Returns false if it is not there. */
bool input_strip_reply(struct input *input)
{
    const struct text text = waiting_bytes(input);
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
