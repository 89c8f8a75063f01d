/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * cmocka, with the headers that it wants before its own, and tests that list themselves:
 * TEST(name) { ... } is a test, and RUN_TESTS(setup, teardown) as the last line of a file its
 * main(), which runs all tests in their order, or those whose names match its argument.
 */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { TESTS_MAX = 64 };

/* Constructors run in any order: each test is put in at its line. */
struct test_list {
    struct CMUnitTest test[TESTS_MAX + 1]; /* the last one has no name */
    int line[TESTS_MAX], count;
};

static inline void test_list_add(struct test_list *list, int line, struct CMUnitTest test)
{
    int i = list->count++;
    for (; i > 0 && list->line[i - 1] > line; i--) {
        list->test[i] = list->test[i - 1];
        list->line[i] = list->line[i - 1];
    }
    list->test[i] = test;
    list->line[i] = line;
}

__attribute__((__unused__)) static struct test_list test_list;

#define TEST(name)                                                                                 \
    static void name(void **state);                                                                \
    __attribute__((constructor)) static void name##_is_listed(void)                                \
    {                                                                                              \
        test_list_add(&test_list, __LINE__, (struct CMUnitTest)cmocka_unit_test(name));            \
    }                                                                                              \
    static void name(__attribute__((__unused__)) void **state)

#define RUN_TESTS(setup, teardown)                                                                 \
    int main(int argc, char **argv)                                                                \
    {                                                                                              \
        if (argc > 1)                                                                              \
            cmocka_set_test_filter(argv[1]);                                                       \
        return cmocka_run_group_tests_name("tests", test_list.test, setup, teardown);              \
    }
