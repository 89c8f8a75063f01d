/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coefficients as they are shown: every number of every method is read back with the bits that the
 * method steps with, and tableaus are consistent. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <hooke/base/catalog.h>
#include <hooke/method/coefficients.h>
#include <hooke/report.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reads "-\frac{1}{2}" or a decimal; *at is behind it. */
static double read_tex(const char **at)
{
    char *end;
    const double sign = **at == '-' ? -1 : 1;
    const char *start = *at + (**at == '-');
    if (strncmp(start, "\\frac{", 6) != 0) {
        const double value = strtod(start, &end);
        *at = end;
        return sign * value;
    }
    const double numerator = strtod(start + 6, &end), denominator = strtod(end + 2, &end);
    *at = end + 1;
    return sign * numerator / denominator;
}

static void test_every_number_is_that_of_the_method(void **state)
{
    (void)state;
    int methods = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct buffer tex = {0};
        struct coefficient_row row;
        if (!coefficients_tex(method, &tex))
            continue;
        const char *line = strstr(buffer_view(&tex), "\\begin{array}");
        methods++;
        for (int i = 0; method_coefficients(method, i, &row); i++) {
            line = strchr(line, '\n') + 1;
            if (strncmp(line, "\\hline", 6) == 0)
                line = strchr(line, '\n') + 1;
            const char *place = line;
            if (!isnan(row.time) && fabs(read_tex(&place) - row.time) > 2 * DBL_EPSILON)
                fail_msg("%s: row %d is at %.17g, not as in %.40s", method->row.name, i, row.time,
                         line);
            for (int k = 0; k < row.count; k++) {
                place = strchr(place, '&') + 2;
                const double shown = read_tex(&place);
                if (fabs(shown - row.value[k]) > 2 * DBL_EPSILON * fabs(row.value[k]))
                    fail_msg("%s: row %d, value %d is %.17g, shown as %.17g", method->row.name, i,
                             k, row.value[k], shown);
            }
        }
        buffer_free(&tex);
    }
    assert_in_range(methods, 40, 200);
}

/* Stages are where the sums of their rows say; weights sum to one. */
static void test_tableaus_are_consistent(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct coefficient_row row;
        if (!method->tableau && !method->implicit && !method->splitting)
            continue;
        for (int i = 0; method_coefficients(method, i, &row); i++) {
            double sum = 0;
            for (int k = 0; k < row.count; k++)
                sum += row.value[k];
            if (fabs(sum - (isnan(row.time) ? 1 : row.time)) > 1e-13)
                fail_msg("%s: row %d (%s) sums to %.17g", method->row.name, i, row.label, sum);
        }
    }
}

static void test_wide_tables_are_refused_and_others_fit(void **state)
{
    (void)state;
    struct buffer text = {0};
    struct text rest, line;
    assert_true(coefficients_text(method_find("dopri5"), 80, &text));
    rest = buffer_text(&text);
    while (text_split(&rest, '\n', &line))
        assert_in_range(line.len, 0, 80);
    assert_non_null(strstr(buffer_view(&text), "| 9017/3168  -355/33     46732/5247 49/176"));
    buffer_clear(&text);
    assert_false(coefficients_text(method_find("dopri5"), 60, &text));
    assert_false(coefficients_text(method_find("dop853"), 80, &text));
    assert_int_equal(text.len, 0);
    buffer_free(&text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_number_is_that_of_the_method),
        cmocka_unit_test(test_tableaus_are_consistent),
        cmocka_unit_test(test_wide_tables_are_refused_and_others_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
