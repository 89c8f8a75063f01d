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

/* Returns the number of a question, "Q3", if the line is its heading, else an empty text. */
static struct text question_number(struct text line)
{
    size_t begin = 0, end;
    if (!is_heading(line))
        return TEXT("");
    while (line.data[begin] == '#' || line.data[begin] == ' ')
        if (++begin == line.len)
            return TEXT("");
    for (end = begin + 1; end < line.len && line.data[end] >= '0' && line.data[end] <= '9';)
        end++;
    const bool is_question =
        line.data[begin] == 'Q' && end > begin + 1 && end < line.len && line.data[end] == '.';
    return is_question ? (struct text){line.data + begin, end - begin} : TEXT("");
}

/* Returns true if the student has added the line: prose that is not in the report that the session
 * gives. Lines of tables, lists and figures are excluded, since their numbers may be changed. */
static bool is_added(const struct check *check, struct text line)
{
    const struct text repeated = buffer_text(&check->repeated);
    line = text_trim(line);
    return repeated.len > 0 && is_written(line) && !strchr("#|-!<", *line.data) &&
           !check_has_line(repeated, line) &&
           !check_describes_recording(check->report.session, line);
}

/* Reads from report.md (`report`) and report.html (`page`), empty if missing, the name, the number
 * of answers and those that are empty, and a checksum of all else into *check. Lines behind
 * "Answer:" belong to the answer up to the next heading that the report wrote, and so do lines that
 * the student has added anywhere before the next question; they, the student's own headings, the
 * name and the date are left out of the checksum. */
void check_answers(struct check *check, struct text report, struct text page)
{
    static const struct text name = {"Name:", 5}, date = {"Date:", 5}, answer = {"Answer:", 7};
    const struct text repeated = buffer_text(&check->repeated);
    struct text rest = report, line, question = TEXT("");
    struct buffer own = {0};
    bool written = false, is_answer = false;
    put_field_value(report, name, &check->name);
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const struct text number = question_number(line);
        const bool is_own_heading =
            is_heading(line) && repeated.len > 0 && !check_has_line(repeated, text_trim(line));
        bool is_left_out = is_answer || is_own_heading;
        if (number.len > 0) {
            count_answer(check, question, written, page);
            question = number;
            written = is_answer = is_left_out = false;
        } else if (is_heading(line)) {
            is_answer &= is_own_heading;
            is_left_out = is_own_heading;
        } else if (text_starts(line, answer) && question.len > 0) {
            is_answer = is_left_out = true;
            written |= is_written((struct text){line.data + answer.len, line.len - answer.len});
        } else if (question.len > 0 && (is_answer ? is_written(line) : is_added(check, line))) {
            written = is_left_out = true;
        }
        if (!is_left_out && !text_starts(line, name) && !text_starts(line, date)) {
            buffer_put(&own, text_trim(line)); /* an editor may add carriage returns */
            buffer_char(&own, '\n');
        }
    }
    count_answer(check, question, written, page);
    check->sum = own.len ? bytes_sum(buffer_text(&own)) : 0;
    buffer_free(&own);
}
