/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plots of the residuals of a recording: its values minus the fit or the run. */
#include "modules/recording/fits.h"
#include <hooke/base/cancel.h>
#include "modules/recording/known/known.h"
#include "modules/recording/plots.h"

bool residual_known(const struct session *session)
{
    return figure_recording(session,
                            (enum plot_kind)catalog_index(
                                &plot_catalog, catalog_find(&plot_catalog, TEXT("residual")))) >= 0;
}

/* Draws the recording, then subtracts the fit of it or, without one, the run from its values.
 * Returns false with the error if there is neither. */
bool drawing_residual(struct drawing *d, const struct recording *recording)
{
    const bool fitted = recording_is_fitted(d->session, recording);
    const struct run *run =
        d->request->runs ? d->session->runs.slot[d->request->run[0]]->run : NULL;
    if (!fitted && !run)
        return error_set(
            d->error, ERROR_COMMAND,
            "a residual needs a fit of this recording, or a run that covers the same times");
    if (!drawing_recording(d, recording))
        return false;
    struct curve *curve = &d->curve[d->curves - 1];
    double *left = arena_array(d->arena, curve->n + 1, sizeof *left);
    if (!left)
        return error_memory(d->error);
    /* The zero of the recording may have changed since the fit. */
    const double shift = recording->zero - fits_of(d->session)->fit_zero;
    struct data_distance data = {.gain = 1};
    if (fitted)
        session_fit_values(d->session, curve->x, curve->n, left);
    else
        data = run_data_distance(run, d->session->recording[d->request->recording]->recording);
    for (size_t i = 0; i < curve->n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(recording->cancel))
            return error_set(d->error, ERROR_CANCELLED, "stopped");
        left[i] =
            curve->y[i] -
            (fitted ? left[i] - shift
                    : (run_motion(run, curve->x[i], data.derivative) - data.at_zero) / data.gain);
    }
    curve->y = left;
    curve->label = fitted ? "data - fit" : "data - run";
    return true;
}
