/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The 95 % band of an adopted fit's uncertainty about the run of what was adopted. */
#ifndef HOOKE_COMMAND_FIT_BAND_H
#define HOOKE_COMMAND_FIT_BAND_H

#include "internal.h"

/* Whether the run has one: it is of the scene that was adopted, unchanged on its way, forwards.
 * where: the option as typed. ERROR_COMMAND says what is missing. */
bool band_of_run(const struct session *session, const struct run *run, struct text where,
                 struct error *error);
/* Half the width [n] of a state variable's band at ascending times [s]. */
bool band_half(const struct session *session, const struct run *run, int variable, const double *t,
               size_t n, struct arena *arena, double *half, struct error *error);

/* The band that panes show, found once after a statement: 'set band on'. Nothing is done where it
 * is off, nothing was adopted, or it is known. */
void session_keep_band(struct session *session);
void session_drop_band(struct session *session);
/* Half the width of that band at a time; NAN: there is none. */
double kept_band_at(const struct fit_band *band, int variable, double t);

/* For `plan`: that the scene has a band, and what it takes; nothing: it has none. */
void band_plan(const struct session *session, const struct system *system, struct buffer *text);

#endif
