/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared between the files of base only. */
#ifndef HOOKE_BASE_INTERNAL_H
#define HOOKE_BASE_INTERNAL_H

#include "hooke/base.h"

#define SAFE_NAME_SIZE 160

/* A name from outside for use inside a message: made visible as by safe_text, long ones cut with "...". Returns `out`.
 */
const char *safe_name(struct text name, char out[SAFE_NAME_SIZE]);

/* "No space left on device", in English whatever the locale. */
const char *system_message(int number);

#endif
