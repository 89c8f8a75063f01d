/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as a script; the session that it leaves, kept and restored, is kept again as the same
 * bytes. */
#define CORPUS "kept"
#define UNIT "command lines"
#define FUZZ_SEEDS
#include <hooke/base/safe_text.h>
#include "fuzz/replay.h"
#include "fuzz/scripted.h"
#include "fuzz/stored.h"

size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    return scripted_seed(i, data, max);
}

static void compare(const struct buffer *one, const struct buffer *two)
{
    if (text_equal(buffer_text(one), buffer_text(two)))
        return;
    /* the last one: what is before may be a checksum */
    size_t at = one->len < two->len ? one->len : two->len;
    while (at > 0 && one->data[at - 1] == two->data[at - 1])
        at--;
    struct buffer before = {0};
    safe_text(&before, (struct text){one->data, at}, false);
    fprintf(stderr, "kept %zu bytes, then %zu, which differ up to byte %zu, behind %s\n", one->len,
            two->len, at, before.len > 200 ? before.data + before.len - 200 : buffer_view(&before));
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scripted_settle();
    const uint64_t choice = fuzz_hash(data, size);
    struct reply reply, reply_again;
    struct session *session = scripted_create(choice, &reply);
    struct session *again = scripted_create(choice, &reply_again);
    if (!session || !again)
        abort();
    scripted_play(session, &reply, (struct text){(const char *)data, size}, choice >> 8);
    struct buffer one = {0}, two = {0}, notes = {0};
    stored_put(session, &one);
    if (!stored_take(again, buffer_text(&one), &notes) || notes.len > 0) {
        fprintf(stderr, "it does not come back: %s\n", buffer_view(&notes));
        abort();
    }
    stored_put(again, &two);
    compare(&one, &two);
    buffer_free(&one);
    buffer_free(&two);
    buffer_free(&notes);
    scripted_destroy(session, &reply);
    scripted_destroy(again, &reply_again);
    return 0;
}
