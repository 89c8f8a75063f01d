/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures of the module: spectra, envelopes, periods, residuals, bands of fits. Functions return
 * false with the error in the drawing unless stated otherwise. */
#pragma once

#include <hooke/plot/drawing.h>

struct fit_band; /* modules/recording/fits.h */

/* Fills the curve with the spectrum of a series, and notes its lines. */
bool drawing_data_spectrum(struct drawing *d, const struct series *series, struct curve *curve);
/* Fills the curve with the spectrum of a run's window. */
bool drawing_run_spectrum(struct drawing *d, const struct run *run, struct curve *curve);
/* Returns the frequency axis, which ends at a multiple of the main line. */
struct axis spectrum_axis(const struct drawing *d);
/* Appends the strongest line, if there is one, for the figure's note. */
void spectrum_note(const struct drawing *d, struct buffer *text);
/* Adds the lines to the reply in words and as records. */
void reply_spectrum(const struct session *session, const struct figure_request *request,
                    struct reply *reply);
/* Fills the curve with amplitudes of successive windows against their times. */
bool drawing_data_envelope(struct drawing *d, const struct series *series, struct curve *curve);
/* Does the same for the window of a run. */
bool drawing_run_envelope(struct drawing *d, const struct run *run, struct curve *curve);
/* Makes the figure of the period against the amplitude. */
bool period_figure(struct drawing *d, struct figure *figure);
/* Returns true if a recording can be drawn as residuals. */
bool residual_known(const struct session *session);
/* Adds the residuals of a recording to the figure: minus its fit or minus the run. */
bool drawing_residual(struct drawing *d, const struct recording *recording);

/* ---- the band of an adopted fit ---- */

/* Adds the band to the curves of an adopted fit's run, as option --band asks; drawing_stored_band()
 * adds the stored band if it belongs to the run, and else does nothing. Both are members of
 * series_tools. */
bool drawing_band(struct drawing *d);
bool drawing_stored_band(struct drawing *d);
/* Returns true if the run has a band: it is of the scene that was adopted, unchanged on its way,
 * and moves forward in time. `where` is the option as typed. Returns false with ERROR_COMMAND,
 * which tells what is missing. */
bool band_of_run(const struct session *session, const struct run *run, struct text where,
                 struct error *error);
/* Computes half the width [n] of the band of a state variable at ascending times [s]. Returns false
 * with the error. */
bool band_half(const struct session *session, const struct run *run, int variable, const double *t,
               size_t n, struct arena *arena, double *half, struct error *error);

/* Computes the band that panes show ('set band on') after a statement, unless it is off, known, or
 * nothing was adopted. */
void session_store_band(struct session *session);
/* Returns half the width of that band at a time, or NAN if there is none. */
double stored_band_at(const struct fit_band *band, int variable, double t);

/* Appends to the text of `plan` the cost of the scene's band; nothing if it has none. */
void band_plan(const struct session *session, struct buffer *text);
