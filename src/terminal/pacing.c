/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Frame rate of the panes: each frame is followed by a question to the terminal, and the next frame
 * waits for the answer, so that a slow link has only one frame under way. Terminals that do not
 * answer get few frames. */
#include "terminal/panes.h"

#include <limits.h>
#include <unistd.h>

/* Question that every terminal answers with REPLY_TEXT (device status report). */
#define STATUS_QUERY "\033[5n"
#define PATIENCE_NS 2000000000 /* [ns] time after which an answer counts as missing */
/* successive missing answers after which the terminal counts as one that does not answer */
#define MISSING_MAX 2
#define BLIND_FRAMES 2 /* [1/s] frames without answers */
/* [ns] an answer that takes longer has come over a slow link */
#define SLOW_NS 8000000
/* [byte] part of a frame that is sent at a time over a slow link */
#define SLOW_BYTES 500

/* Returns how many bytes a frame may send. */
int pacing_bytes(const struct pacing *pacing)
{
    return pacing->delay > SLOW_NS ? SLOW_BYTES : INT_MAX;
}

/* Returns true if frames are followed by questions: always, never, or while the terminal answers,
 * by the setting `sync`. */
static bool is_asking(const struct pacing *pacing, const struct session *session)
{
    const int sync = session->setup.settings.sync;
    return sync == SYNC_ON || (sync == SYNC_AUTO && pacing->missing < MISSING_MAX);
}

/* Returns the earliest time [clock_ns] of the next frame: by the frame rate and, while an answer is
 * missing, not before PATIENCE_NS have passed. */
int64_t pacing_due(const struct pacing *pacing, const struct session *session)
{
    const bool waits = pacing->requested != 0 && is_asking(pacing, session);
    const int64_t patience = pacing->requested + PATIENCE_NS;
    return waits && patience > pacing->next ? patience : pacing->next;
}

/* Notes that a frame was drawn and asks the terminal. A frame that was sent in part continues at
 * once. */
void pacing_drawn(struct pacing *pacing, const struct session *session, int64_t now,
                  enum shown shown)
{
    const struct settings *settings = &session->setup.settings;
    const bool blind = settings->sync == SYNC_AUTO && pacing->missing >= MISSING_MAX;
    const double frames = blind && settings->fps > BLIND_FRAMES ? BLIND_FRAMES : settings->fps;
    pacing->next = shown == SHOWN_PART ? now : now + (int64_t)(1e9 / frames);
    if (pacing->requested != 0) {
        pacing->missing++;
    }
    pacing->requested = 0;
    int ignored;
    if (shown != SHOWN_NOTHING && is_asking(pacing, session) &&
        write_all(STDOUT_FILENO, TEXT(STATUS_QUERY), &ignored)) {
        pacing->requested = now;
    }
}

/* Notes that the terminal has answered. */
void pacing_replied(struct pacing *pacing, int64_t now)
{
    if (pacing->requested != 0) {
        pacing->delay = now - pacing->requested;
    }
    pacing->requested = 0;
    pacing->missing = 0; /* also if it was late: the terminal does answer */
}
