/* SPDX-License-Identifier: GPL-3.0-or-later */
/* hooke: includes the layers of the library that need no session: base, result, scene, method, run,
 * data and figure. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>

#include <hooke/data.h>
#include <hooke/figure.h>
#include <hooke/method.h>
#include <hooke/result.h>
#include <hooke/run.h>
#include <hooke/scene.h>
