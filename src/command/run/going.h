/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Advancing the current run, for run, continue and step. */
#pragma once

#include <hooke/command/handler.h>

/* Advances the current run along the last request of its journal and replies with the result. steps
 * >= 0 ends it early on purpose: the run then counts as paused, and `continue` can complete the
 * request. With clocked, a run that a person watches follows the clock. Returns false with the
 * error set. */
bool run_go_on(struct session *session, const struct arguments *args, int64_t steps, bool clocked,
               struct reply *reply, struct error *error);
