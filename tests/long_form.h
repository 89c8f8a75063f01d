/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tests have a quick form (make check) and a long one (LONG=1, make check-all). */
#pragma once

#include <stdbool.h>
#include <stdlib.h>

/* LONG may be set and empty: then it is the quick form. */
static inline bool is_long(void)
{
    const char *wanted = getenv("LONG");
    return wanted && *wanted;
}
