/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The library part of hooke: base, scene, method, run, data, analysis, figure, study. */
#ifndef HOOKE_H
#define HOOKE_H

#include <hooke/study.h>

#endif
