/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as a script: replies and errors, never a crash, and nothing written outside a folder of
 * its own. Tab and F1 anywhere in it, and the screen it leaves. */
#include <hooke/view.h>

#define CORPUS "command"
#define UNIT "command lines"
#define FUZZ_SEEDS
#include "fuzz/replay.h"
#include "fuzz/scripted.h"

size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    return scripted_seed(i, data, max);
}

static void offer(void *context, const char *candidate, const char *brief)
{
    *(size_t *)context += strlen(candidate) + strlen(brief);
}

static void complete(struct session *session, struct text line, size_t cursor)
{
    size_t start = 0, offered = 0;
    struct buffer help = {0};
    command_complete(session, line, cursor, &start, offer, &offered);
    help_line(line, cursor, &help);
    buffer_free(&help);
    if (start > cursor)
        abort();
}

static void draw(const struct session *session, struct text line, uint64_t choice)
{
    const struct prompt_line prompt = {
        .prompt = TEXT("hooke> "), .line = line, .cursor = (size_t)(choice % (line.len + 1))};
    struct canvas canvas;
    if (!canvas_init(&canvas, 1 + (int)(choice >> 8) % 130, 1 + (int)(choice >> 16) % 50))
        return;
    screen_draw(session, &prompt, &canvas, NULL, NULL);
    canvas_free(&canvas);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scripted_settle();
    const uint64_t choice = fuzz_hash(data, size);
    const struct text all = {(const char *)data, size};
    struct text rest = all, first = TEXT("");
    struct reply reply;
    struct session *session = scripted_create(choice, &reply);
    if (!session)
        return 0;
    scripted_play(session, &reply, all, choice >> 8);
    text_split(&rest, '\n', &first);
    if (choice % 8 == 0)
        complete(session, first, (size_t)(choice % (first.len + 1)));
    if (choice % 8 == 1)
        draw(session, first, choice >> 4);
    if (choice % 8 == 2) {
        struct buffer saved = {0};
        session_save(session, &saved);
        buffer_free(&saved);
    }
    scripted_destroy(session, &reply);
    return 0;
}
