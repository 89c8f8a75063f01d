/* SPDX-License-Identifier: GPL-3.0-or-later */
/* cmocka, with the headers that it wants before its own. */
#ifndef HOOKE_TESTS_CMOCKA_TESTING_H
#define HOOKE_TESTS_CMOCKA_TESTING_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
