/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Work on a stack of its own that is painted before: how deep it was used is read off it
 * afterwards. The C library takes a part of the stack for what belongs to the thread, which
 * counts; the frames of sanitizers are others: PAINTED_STACK is 0 there, and nothing is measured.
 */
#pragma once

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__SANITIZE_ADDRESS__)
#define PAINTED_STACK 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PAINTED_STACK 0
#endif
#endif
#ifndef PAINTED_STACK
#define PAINTED_STACK (1 << 20) /* [byte] */
#endif

#define PAINT 0xA5

/* [byte] of stack that work(context) used, or 0: it ran on the stack that there is. */
static inline size_t painted_run(void *(*work)(void *context), void *context)
{
#if PAINTED_STACK
    static _Alignas(4096) unsigned char stack[PAINTED_STACK];
    pthread_attr_t attributes;
    pthread_t thread;
    memset(stack, PAINT, sizeof stack);
    bool ran = pthread_attr_init(&attributes) == 0;
    ran = ran && pthread_attr_setstack(&attributes, stack, sizeof stack) == 0 &&
          pthread_create(&thread, &attributes, work, context) == 0;
    pthread_attr_destroy(&attributes);
    if (ran) {
        pthread_join(thread, NULL);
        size_t untouched = 0;
        while (untouched < sizeof stack && stack[untouched] == PAINT)
            untouched++;
        return sizeof stack - untouched;
    }
#endif
    work(context);
    return 0;
}
