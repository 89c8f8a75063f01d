/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves of special points in two parameters. */
#ifndef HOOKE_MODULES_DYNAMICS_BRANCHES_TWO_PARAMETERS_H
#define HOOKE_MODULES_DYNAMICS_BRANCHES_TWO_PARAMETERS_H

#include "modules/dynamics/dynamics.h"

/* branch_follow() where there is a second parameter. */
bool special_follow(const struct branch_request *request, struct branch *branch,
                    struct error *error);
/* Its points in the opposite order. */
void branch_reverse(struct branch *branch);

#endif
