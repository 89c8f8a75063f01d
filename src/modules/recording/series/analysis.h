/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Crossings, period, amplitude, decay, spectrum and fits of a series (t, y), measured or simulated:
 * includes all headers of the analysis. Everywhere y = c + A exp(-gamma t/2) cos(omega t + phi),
 * with t counted from the first sample of the window. The amplitude falls as exp(-gamma t/2), the
 * energy as exp(-gamma t); tau = 2/gamma is the 1/e time of the amplitude. A series whose samples
 * have no noise (a simulation) uses the same code; its uncertainties are then tiny, never 0/0. */
#pragma once

#include "modules/recording/period/period.h"
#include "modules/recording/fit/fit.h"
