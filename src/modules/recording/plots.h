/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures of the module: spectra, envelopes, periods, residuals, bands of fits. */
#pragma once

#include <hooke/plot/drawing.h>

struct fit_band; /* modules/recording/fits.h */

/* The spectrum of a series, or of the window of a run, and its lines. */
bool drawing_data_spectrum(struct drawing *d, const struct series *series, struct curve *curve);
bool drawing_run_spectrum(struct drawing *d, const struct run *run, struct curve *curve);
struct axis spectrum_axis(const struct drawing *d);
/* Names the strongest line, where there is one. */
void spectrum_note(const struct drawing *d, struct buffer *text);
/* The lines in words and as records. */
void reply_spectrum(const struct session *session, const struct figure_request *request,
                    struct reply *reply);
/* Amplitudes of successive windows against their times. */
bool drawing_data_envelope(struct drawing *d, const struct series *series, struct curve *curve);
bool drawing_run_envelope(struct drawing *d, const struct run *run, struct curve *curve);
/* The period against the amplitude. */
bool period_figure(struct drawing *d, struct figure *figure);
/* Residuals of a recording beside its fit or a run. */
bool residual_known(const struct session *session);
bool drawing_residual(struct drawing *d, const struct recording *recording);

/* ---- the band of an adopted fit ---- */

/* series_tools.draw_band and draw_stored_band */
bool drawing_band(struct drawing *d);
bool drawing_stored_band(struct drawing *d);
/* Returns true if the run has a band: it is of the scene that was adopted, unchanged on its way,
 * forwards. `where` is the option as typed. ERROR_COMMAND tells what is missing. */
bool band_of_run(const struct session *session, const struct run *run, struct text where,
                 struct error *error);
/* Half the width [n] of a state variable's band at ascending times [s]. */
bool band_half(const struct session *session, const struct run *run, int variable, const double *t,
               size_t n, struct arena *arena, double *half, struct error *error);

/* The band that panes show, found once after a statement: 'set band on'. Nothing is done where it
 * is off, nothing was adopted, or it is known. */
void session_store_band(struct session *session);
/* Half the width of that band at a time, or NAN if there is none. */
double stored_band_at(const struct fit_band *band, int variable, double t);

/* Appends to the text of `plan` that the scene has a band, and its cost; nothing if it has none. */
void band_plan(const struct session *session, struct buffer *text);
