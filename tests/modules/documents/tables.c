/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables as Markdown, HTML and LaTeX: what stands in a cell is never markup. */
#include "cmocka_testing.h"

#include "modules/documents/documents.h"

#include <math.h>
#include <string.h>

TEST(markdown_shows_text_as_text)
{
    static const struct table_key keys[] = {{"dt", "10 ms"}, {"note", "a *b*\nc"}};
    static const double y[] = {-0.5, NAN};
    static const char *const words[] = {"a|b", "<i>"};
    static const struct table_column column[] = {{.name = "y_0", .unit = "m", .value = y},
                                                 {.name = "word", .unit = "", .text = words}};
    struct buffer out = {0};
    const struct table table = {keys, 2, column, 2, 2, NULL, 0};
    table_put(&table, documents_markdown, &out);
    assert_string_equal(buffer_view(&out), "- dt: 10 ms\n- note: a \\*b\\*\\\\x0ac\n\n"
                                           "| y\\_0 (m) | word |\n| ---: | --- |\n"
                                           "| -0.5 | a\\|b |\n|  | \\<i\\> |\n");
    buffer_free(&out);
}

TEST(html_and_latex_show_text_as_text)
{
    static const struct table_key keys[] = {{"note", "5 % <b>"}};
    static const double y[] = {-0.5, 2.5e-17, NAN};
    static const char *const words[] = {"a&b", "[_{i}^2$", "--\\"};
    static const struct table_column column[] = {{.name = "y_0", .unit = "m/s^2", .value = y},
                                                 {.name = "word", .unit = "", .text = words}};
    const struct table table = {keys, 1, column, 2, 3, NULL, 0};
    struct buffer out = {0};
    table_put(&table, documents_latex, &out);
    assert_string_equal(buffer_view(&out),
                        "% \\usepackage{siunitx}\n"
                        "% note = 5 % <b>\n\\begin{tabular}{Sl}\n\\hline\n"
                        "{y\\_0 [m/s\\textasciicircum{}2]} & {word} \\\\\n\\hline\n"
                        "-0.5 & a\\&b \\\\\n"
                        "2.5e-17 & {[}\\_\\{i\\}\\textasciicircum{}2\\$ \\\\\n"
                        " & {-}{-}\\textbackslash{} \\\\\n\\hline\n\\end{tabular}\n");
    buffer_clear(&out);
    table_put(&table, documents_html, &out);
    assert_non_null(strstr(buffer_view(&out),
                           "<ul>\n<li>note: 5 % &lt;b&gt;</li>\n</ul>\n<table>\n<thead>\n"
                           "<tr><th>y_0 (m/s^2)</th><th>word</th></tr>\n</thead>\n<tbody>\n"
                           "<tr><td class=\"number\">-0.5</td><td>a&amp;b</td></tr>\n"));
    assert_non_null(strstr(buffer_view(&out), "<tr><td class=\"number\"></td><td>--\\</td></tr>\n"
                                              "</tbody>\n</table>\n</body>\n</html>\n"));
    buffer_free(&out);
}

RUN_TESTS(NULL, NULL)
