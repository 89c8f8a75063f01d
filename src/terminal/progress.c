/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shows the progress of a long run or study, and the time left, on standard error. */
#include "terminal/terminal.h"
#include <hooke/run.h>
#include <hooke/base/cancel.h>

#include <stdio.h>

/* Progress that is shown at present. */
static struct progress_line {
    int64_t begun, shown; /* [ns] */
    bool visible;
} progress;

/* Returns true if the progress should be shown now: after the first second, at most four times a
 * second. fraction > 1 ends it: *is_finished is set if something was shown and must be erased. */
bool progress_due(double fraction, bool *is_finished)
{
    const int64_t now = clock_ns();
    *is_finished = fraction > 1 && progress.visible;
    if (fraction > 1) {
        progress = (struct progress_line){0};
        return false;
    }
    if (progress.begun == 0) {
        progress.begun = progress.shown = now;
    }
    if (now - progress.begun < 1000000000 || now - progress.shown < 250000000) {
        return false;
    }
    progress.shown = now;
    return progress.visible = true;
}

/* Appends the progress of a run or of a study (run NULL), with the time left if the fraction is
 * known. */
void progress_text(const struct session *session, const struct run *run, double fraction,
                   struct buffer *text)
{
    const double spent = clock_seconds(progress.begun);
    if (run) {
        buffer_format(text, "%s: t = %.6g s, %lld steps", run->method->row.name, run->t,
                      (long long)run->steps);
    }
    if (fraction > 0) {
        buffer_format(text, "%s%.0f %%, %.0f s left", run ? ", " : "", 100 * fraction,
                      spent * (1 - fraction) / fraction);
    } else if (!run) {
        buffer_format(text, "%.0f s", spent);
    }
    if (fraction > 0 && !run && session && session->studies.points > 0 && spent > 0)
        buffer_format(text, ", %.3g points/s", fraction * session->studies.points / spent);
    buffer_put(text, TEXT(" (Ctrl-C stops)"));
}

/* Writes to standard error, in one line that is erased at the end. */
void progress_print(void *context, const struct run *run, double fraction)
{
    struct buffer text = {0};
    bool is_finished;
    if (progress_due(fraction, &is_finished)) {
        progress_text(context, run, fraction, &text);
        fprintf(stderr, "\r%s\033[K", text.data ? text.data : "");
        buffer_free(&text);
    } else if (is_finished) {
        fputs("\r\033[K", stderr);
    }
}
