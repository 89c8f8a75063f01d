/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * study: reports that run many. Here: several methods and step sizes on one scene, with error,
 * energy, cost and honest times.
 */
#ifndef HOOKE_STUDY_H
#define HOOKE_STUDY_H

#include <hooke/study/compare.h>
#include <hooke/study/stability.h>
#include <hooke/study/fit.h>
#include <hooke/study/sweep.h>

#endif
