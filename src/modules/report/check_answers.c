/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the student's name and the answers in report.md and report.html of a hand-in, and a
 * checksum of the rest, by which copies are recognized. */
#define _GNU_SOURCE /* memmem */
#include "modules/report/check.h"
#include <hooke/base/fields.h>

#include <string.h>

/* Appends the text behind `label` ("Name:") of the first line that begins with it, or nothing. */
static void put_field_value(struct text report, struct text label, struct buffer *output)
{
    struct text line;
    while (report.len > 0 && text_split(&report, '\n', &line))
        if (text_starts(line, label)) {
            buffer_put(output,
                       text_trim((struct text){line.data + label.len, line.len - label.len}));
            return;
        }
}

/* Returns true for a heading of Markdown, "## Energy", but not for "#1 is the reason". */
static bool is_heading(struct text line)
{
    size_t marks = 0;
    while (marks < line.len && line.data[marks] == '#')
        marks++;
    return marks > 0 && marks < line.len && line.data[marks] == ' ';
}

/* Returns true if a line of report.md holds something that the report does not leave there. */
static bool is_written(struct text line)
{
    line = text_trim(line);
    return line.len > 0 && !text_is(line, "&nbsp;");
}

/* Returns true if the answer with that number, counted from 0, holds something in report.html. */
static bool is_written_in_page(struct text page, int number)
{
    static const char begin[] = "<div class=\"answer\">", end[] = "</div>";
    const char *found = NULL;
    for (int i = 0; i <= number; i++) {
        found = page.len ? memmem(page.data, page.len, begin, sizeof begin - 1) : NULL;
        if (!found)
            return false;
        found += sizeof begin - 1;
        page = (struct text){found, page.len - (size_t)(found - page.data)};
    }
    const char *stop = memmem(page.data, page.len, end, sizeof end - 1);
    return stop && text_trim((struct text){found, (size_t)(stop - found)}).len > 0;
}

/* Counts the answer to `question` ("Q3", empty before the first one) as given or empty. An answer
 * may have been written in report.html (`page`) instead. */
static void count_answer(struct check *check, struct text question, bool written, struct text page)
{
    if (question.len == 0)
        return;
    written = written || is_written_in_page(page, check->answers + check->empty_answers);
    check->answers += written;
    check->empty_answers += !written;
    if (!written)
        buffer_format(&check->empty, "%s%.*s", check->empty.len ? " " : "", (int)question.len,
                      question.data);
}

/* Reads from report.md (`report`) and report.html (`page`), empty if missing, the name, the number
 * of answers and those that are empty, and a checksum of all else into *check. Lines between
 * "Answer:" and the next heading belong to the answer; they, the name and the date are left out of
 * the checksum. */
void check_answers(struct check *check, struct text report, struct text page)
{
    static const struct text name = {"Name:", 5}, date = {"Date:", 5}, answer = {"Answer:", 7};
    struct text rest = report, line, question = TEXT("");
    struct buffer unanswered = {0};
    bool written = false, is_answer = false;
    put_field_value(report, name, &check->name);
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        if (is_heading(line) && (is_answer || memmem(line.data, line.len, " Q", 2))) {
            count_answer(check, question, written, page);
            const char *number = memmem(line.data, line.len, " Q", 2);
            const char *point =
                number ? memchr(number, '.', line.len - (size_t)(number - line.data)) : NULL;
            question = point ? (struct text){number + 1, (size_t)(point - number - 1)} : TEXT("");
            written = is_answer = false;
        } else if (text_starts(line, answer) && question.len > 0) {
            is_answer = true;
            written = is_written((struct text){line.data + answer.len, line.len - answer.len});
        } else if (is_answer) {
            written |= is_written(line);
        }
        if (!is_answer && !text_starts(line, name) && !text_starts(line, date)) {
            buffer_put(&unanswered, text_trim(line)); /* an editor may add carriage returns */
            buffer_char(&unanswered, '\n');
        }
    }
    count_answer(check, question, written, page);
    check->sum = unanswered.len ? bytes_sum(buffer_text(&unanswered)) : 0;
    buffer_free(&unanswered);
}
