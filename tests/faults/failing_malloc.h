/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Include once in a test program: its malloc, calloc, realloc and aligned_alloc count the
 * allocations of the whole process (libc's own, in strdup and others, too) and fail on request.
 * Under AddressSanitizer, which has its own, nothing is replaced: skip() when !MALLOC_CAN_FAIL.
 */
#pragma once

#include <dlfcn.h>
#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define MALLOC_CAN_FAIL 0
#endif
#endif
#if !defined(MALLOC_CAN_FAIL) && defined(__SANITIZE_ADDRESS__)
#define MALLOC_CAN_FAIL 0
#endif
#ifndef MALLOC_CAN_FAIL
#define MALLOC_CAN_FAIL 1
#endif

static long malloc_calls; /* since it was last set to 0 */
/* this call fails (0 is the next after malloc_calls = 0); -1: none */
static long malloc_fail_at = -1;
__attribute__((unused)) static bool malloc_fail_for_ever; /* and all that follow it */

#if MALLOC_CAN_FAIL
void *malloc(size_t size);
void *calloc(size_t count, size_t size);
void *realloc(void *old, size_t size);
void *aligned_alloc(size_t alignment, size_t size);

static bool malloc_fails_now(void)
{
    const long call = malloc_calls++;
    if (malloc_fail_at < 0 ||
        (malloc_fail_for_ever ? call < malloc_fail_at : call != malloc_fail_at))
        return false;
    errno = ENOMEM;
    return true;
}

/* ISO C has no cast from an object pointer to a function pointer: the bytes are copied. */
static void malloc_find(void *function, const char *name)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

void *malloc(size_t size)
{
    static void *(*real)(size_t);
    if (!real)
        malloc_find(&real, "malloc");
    return malloc_fails_now() ? NULL : real(size);
}

void *calloc(size_t count, size_t size)
{
    static void *(*real)(size_t, size_t);
    if (!real)
        malloc_find(&real, "calloc");
    return malloc_fails_now() ? NULL : real(count, size);
}

void *realloc(void *old, size_t size)
{
    static void *(*real)(void *, size_t);
    if (!real)
        malloc_find(&real, "realloc");
    return malloc_fails_now() ? NULL : real(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    static void *(*real)(size_t, size_t);
    if (!real)
        malloc_find(&real, "aligned_alloc");
    return malloc_fails_now() ? NULL : real(alignment, size);
}
#endif
