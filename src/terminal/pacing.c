/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "terminal/panes.h"

#include <limits.h>
#include <unistd.h>

#define STATUS_QUERY "\033[5n"
#define PATIENCE_NS 2000000000 /* an answer that has not come by then counts as missing */
#define MISSING_MAX 2          /* then the terminal is one that does not answer */
#define BLIND_FRAMES 2         /* frames a second without answers */
/* an answer that takes longer has come over a link that may be slow */
#define SLOW_NS 8000000
#define SLOW_BYTES 500

int pacing_bytes(const struct pacing *pacing)
{
    return pacing->delay > SLOW_NS ? SLOW_BYTES : INT_MAX;
}

static bool is_asking(const struct pacing *pacing, const struct session *session)
{
    const int sync = session->setup.settings.sync;
    return sync == SYNC_ON || (sync == SYNC_AUTO && pacing->missing < MISSING_MAX);
}

int64_t pacing_due(const struct pacing *pacing, const struct session *session)
{
    const bool waits = pacing->requested != 0 && is_asking(pacing, session);
    const int64_t patience = pacing->requested + PATIENCE_NS;
    return waits && patience > pacing->next ? patience : pacing->next;
}

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

void pacing_replied(struct pacing *pacing, int64_t now)
{
    if (pacing->requested != 0) {
        pacing->delay = now - pacing->requested;
    }
    pacing->requested = 0;
    pacing->missing = 0; /* also when it comes late: the terminal does answer */
}
