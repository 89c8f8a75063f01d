/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A run on its way. */
#pragma once

#include <hooke/command/handler.h>

/*
 * Continues along the last request. `steps` ends it early on purpose: the run then counts as
 * paused, and `continue` can complete the request.
 */
bool run_go_on(struct session *session, const struct arguments *args, int64_t steps, bool clocked,
               struct reply *reply, struct error *error);
