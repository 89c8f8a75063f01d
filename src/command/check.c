/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A hand-in, the folder of `report`, against what its session.hk gives when it is run again. */
#define _GNU_SOURCE /* memmem */
#include "command/handed_in.h"
#include "command/internal.h"

#include <hooke/report/lab.h>

#include <stdlib.h>
#include <string.h>

#define HANDED_MAX (1u << 28) /* [byte] a file of it */
#define SAME_DIGITS 1e-6      /* of values without uncertainty, relative */
#define SAME_UNCERTAINTY 0.05 /* uncertainties have two digits */

struct check {
    struct report report;
    struct arena arena;
    const char *folder;
    struct reply *reply;
    struct buffer failure; /* the first error of the session */
    int values, figures, files, differences;
};

static void differs(struct check *check, const char *file, const char *what, struct text detail)
{
    struct reply *reply = check->reply;
    struct buffer safe = {0};
    safe_text(&safe, detail, false);
    check->differences++;
    reply_line(reply, "differs: %s: %s%s%s", file, what, safe.len ? ": " : "", buffer_view(&safe));
    reply_object(reply, NULL);
    reply_string(reply, "file", file);
    reply_string(reply, "what", what);
    reply_string(reply, "detail", buffer_view(&safe));
    reply_close(reply);
    buffer_free(&safe);
}

/* ---- values ---- */

struct values { /* columns of values.csv; NULL: it has none of that name or kind */
    const char *const *name, *const *of, *const *source;
    const double *value, *uncertainty, *t;
    size_t rows;
};

static bool find_values(const struct table *table, struct values *values)
{
    *values = (struct values){.rows = table->rows};
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        const struct {
            const char *name;
            const char *const **text;
            const double **number;
        } wanted[] = {
            {"name", &values->name, NULL},
            {"of", &values->of, NULL},
            {"source", &values->source, NULL},
            {"value", NULL, &values->value},
            {"uncertainty", NULL, &values->uncertainty},
            {"t", NULL, &values->t},
        };
        for (size_t k = 0; k < COUNT_OF(wanted); k++) {
            if (strcmp(column->name, wanted[k].name) != 0)
                continue;
            if (wanted[k].text)
                *wanted[k].text = column->text;
            else
                *wanted[k].number = column->value;
        }
    }
    return values->name && values->of && values->source && values->value && values->uncertainty;
}

static double time_of(const struct values *values, size_t row)
{
    return values->t && isfinite(values->t[row]) ? values->t[row] : -HUGE_VAL;
}

static bool same_key(const struct values *a, size_t i, const struct values *b, size_t j)
{
    return strcmp(a->name[i], b->name[j]) == 0 && strcmp(a->of[i], b->of[j]) == 0 &&
           strcmp(a->source[i], b->source[j]) == 0 && !(time_of(a, i) < time_of(b, j)) &&
           !(time_of(a, i) > time_of(b, j));
}

/* What is named alike is counted: the row of `b` that is as many-th there as row i is in `a`. */
static size_t find_row(const struct values *a, size_t i, const struct values *b)
{
    size_t before = 0;
    for (size_t k = 0; k < i; k++)
        before += same_key(a, k, a, i);
    for (size_t j = 0; j < b->rows; j++)
        if (same_key(a, i, b, j) && before-- == 0)
            return j;
    return b->rows;
}

/* Within the uncertainty, which has to be the same; exact values in their digits. */
static bool agree(struct measured stated, struct measured computed)
{
    const double u = isfinite(computed.uncertainty) ? fabs(computed.uncertainty) : 0,
                 v = isfinite(stated.uncertainty) ? fabs(stated.uncertainty) : 0;
    return fabs(stated.value - computed.value) <= fmax(u, SAME_DIGITS * fabs(computed.value)) &&
           fabs(v - u) <= SAME_UNCERTAINTY * u;
}

static void compare_value(struct check *check, const struct values *handed, size_t i,
                          const struct values *again, size_t j)
{
    const struct measured stated = {handed->value[i], handed->uncertainty[i]};
    const struct measured computed = {again->value[j], again->uncertainty[j]};
    check->values++;
    if (agree(stated, computed))
        return;
    struct buffer detail = {0};
    buffer_format(&detail, "%s of %s (%s): it says %.9g +- %.2g, the session gives %.9g +- %.2g",
                  handed->name[i], handed->of[i], handed->source[i], stated.value,
                  stated.uncertainty, computed.value, computed.uncertainty);
    differs(check, "values.csv", "a value", buffer_text(&detail));
    buffer_free(&detail);
}

static void tell_unmatched(struct check *check, const struct values *values, size_t i,
                           const char *what)
{
    struct buffer detail = {0};
    buffer_format(&detail, "%s of %s (%s) = %.9g", values->name[i], values->of[i],
                  values->source[i], values->value[i]);
    check->values++;
    differs(check, "values.csv", what, buffer_text(&detail));
    buffer_free(&detail);
}

static void compare_values(struct check *check, struct text handed_text, struct text again_text)
{
    struct table handed_table = {0}, again_table = {0};
    struct values handed, again;
    struct error error = {0};
    if (!table_parse(handed_text, NULL, &check->arena, &handed_table, &error) ||
        !find_values(&handed_table, &handed)) {
        differs(check, "values.csv", "it is no table of values", text_of(error.text));
        return;
    }
    if (!table_parse(again_text, NULL, &check->arena, &again_table, &error) ||
        !find_values(&again_table, &again))
        return;
    for (size_t i = 0; i < handed.rows; i++) {
        const size_t j = find_row(&handed, i, &again);
        if (j < again.rows)
            compare_value(check, &handed, i, &again, j);
        else
            tell_unmatched(check, &handed, i, "the session does not give");
    }
    for (size_t j = 0; j < again.rows; j++)
        if (find_row(&again, j, &handed) == handed.rows)
            tell_unmatched(check, &again, j, "it lacks");
}

/* ---- what is read ---- */

/* The recording that was taken from the folder, since its own file is not here; NULL: it is. */
static const struct recording *moved(const struct session *session, int index)
{
    const struct recording *recording = session->recording[index]->recording;
    return strcmp(recording->format, HANDED_IN) == 0 ? recording : NULL;
}

/* What is said of such a file: rows, separator. */
static bool is_of_moved(const struct session *session, struct text line)
{
    for (int i = 0; i < session->recordings; i++) {
        struct buffer about = {0};
        if (moved(session, i))
            recording_describe(moved(session, i), &about);
        const char *end = strchr(buffer_view(&about), ',');
        const bool found = end && memmem(line.at, line.len, about.data, (size_t)(end - about.data));
        buffer_free(&about);
        if (found)
            return true;
    }
    return false;
}

static bool has_line(struct text text, struct text wanted)
{
    struct text line;
    while (text.len > 0 && text_split(&text, '\n', &line))
        if (text_equal(text_trim(line), wanted))
            return true;
    return false;
}

/* What carries numbers, figures and commands has to be there as it was; answers, headings and words
 * are the student's. */
static void compare_lines(struct check *check, const char *file, struct text handed,
                          struct text again)
{
    struct text line;
    while (again.len > 0 && text_split(&again, '\n', &line)) {
        line = text_trim(line);
        bool digit = false;
        for (size_t i = 0; i < line.len; i++)
            digit |= line.at[i] >= '0' && line.at[i] <= '9';
        if (digit && line.at[0] != '#' && !text_starts(line, TEXT("<h")) &&
            !has_line(handed, line) && !is_of_moved(check->report.session, line))
            differs(check, file, "this line is not there", line);
    }
}

/* But for comments, which say where a file was. */
static bool next_row(struct text *text, struct text *line)
{
    while (text->len > 0 && text_split(text, '\n', line))
        if (!text_starts(*line, TEXT("#")))
            return true;
    return false;
}

static bool same_rows(struct text a, struct text b)
{
    struct text from_a = TEXT(""), from_b = TEXT("");
    bool more_a, more_b;
    do {
        more_a = next_row(&a, &from_a);
        more_b = next_row(&b, &from_b);
    } while (more_a && more_b && text_equal(from_a, from_b));
    return !more_a && !more_b;
}

static bool ends_in(const char *name, const char *end)
{
    const size_t n = strlen(name), m = strlen(end);
    return n >= m && strcmp(name + n - m, end) == 0;
}

/* A file of the report that the session gives again: with that of the folder. */
static bool compare_file(void *context, const char *name, struct text again, struct error *error)
{
    struct check *check = context;
    struct buffer path = {0}, handed = {0};
    const bool prose = ends_in(name, ".md") || ends_in(name, ".html") || ends_in(name, ".tex");
    const bool figure = text_starts(text_of(name), TEXT("figure-"));
    struct error missing = {0};
    (void)error;
    if (strcmp(name, "session.hk") == 0)
        return true;
    buffer_format(&path, "%s/%s", check->folder, name);
    check->files++;
    check->figures += figure && !ends_in(name, ".txt");
    if (!file_read(buffer_view(&path), HANDED_MAX, &handed, &missing)) {
        if (!prose) /* they may be handed in as another document */
            differs(check, name, "it is not there", TEXT(""));
    } else if (strcmp(name, "values.csv") == 0) {
        compare_values(check, buffer_text(&handed), again);
    } else if (prose) {
        compare_lines(check, name, buffer_text(&handed), again);
    } else if (figure ? !text_equal(buffer_text(&handed), again)
                      : !same_rows(buffer_text(&handed), again)) {
        differs(check, name,
                figure ? "it is not the figure that the session gives"
                       : "it is not the data that the session gives",
                TEXT(""));
    }
    buffer_free(&path);
    buffer_free(&handed);
    return true;
}

/* ---- the session, run again ---- */

static bool drop(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool keep_error(void *context, struct text text)
{
    struct check *check = context;
    struct text line;
    const char *found = text.len ? memmem(text.at, text.len, "error: ", 7) : NULL;
    if (found && check->failure.len == 0 && text_split(&text, '\n', &line))
        buffer_put(&check->failure, line);
    return true;
}

/* Nothing is shown and nothing written; settings of the output are as they were. False: it cannot
 * be read. */
static bool run_again(struct check *check, struct session *session)
{
    struct buffer path = {0}, script = {0};
    struct error error = {0};
    struct reply silent;
    const int format = session->setup.settings.format;
    buffer_format(&path, "%s/session.hk", check->folder);
    const bool read = file_read(buffer_view(&path), HANDED_MAX, &script, &error);
    if (!read) {
        reply_error(check->reply, &error, NULL, (struct text){NULL, 0});
    } else {
        const bool fails = memmem(script.data, script.len, "hooke --keep-going", 18) != NULL;
        reply_init(&silent, (struct sink){drop, keep_error, check});
        session->checking = check->folder;
        session->keep_going = true;
        script_file(session, buffer_view(&path), NULL, &silent);
        reply_free(&silent);
        if (fails)
            buffer_clear(&check->failure);
    }
    session->setup.settings.format = format;
    buffer_free(&path);
    buffer_free(&script);
    return read;
}

static void conclude(struct check *check)
{
    struct reply *reply = check->reply;
    struct buffer safe = {0}, verdict = {0};
    const int n = check->differences;
    const struct session *session = check->report.session;
    int taken = 0;
    for (int i = 0; i < session->recordings; i++) {
        if (!moved(session, i))
            continue;
        taken++;
        reply_line(reply, "%s: its file is not here; recording-%d.csv was taken",
                   session->recording[i]->recording->name, i + 1);
    }
    safe_text(&safe, text_of(check->folder), false);
    if (n > 0)
        buffer_format(&verdict, "%d difference%s from what session.hk gives", n, n == 1 ? "" : "s");
    else
        buffer_put(&verdict, TEXT("they agree with session.hk"));
    reply_line(reply, "%s: %d values, %d figures, %d files: %s", buffer_view(&safe), check->values,
               check->figures, check->files, buffer_view(&verdict));
    reply_close(reply);
    reply_string(reply, "folder", buffer_view(&safe));
    reply_bool(reply, "agrees", n == 0);
    reply_int(reply, "values", check->values);
    reply_int(reply, "figures", check->figures);
    reply_int(reply, "files", check->files);
    reply_int(reply, "moved", taken);
    reply_end(reply);
    buffer_free(&safe);
    buffer_free(&verdict);
}

int hand_in_check(struct session *session, const char *folder, struct reply *reply)
{
    struct check *check = calloc(1, sizeof *check);
    struct session *view = malloc(sizeof *view);
    struct error error = {0};
    int status = ERROR_USAGE;
    if (check && view) {
        check->folder = folder;
        check->reply = reply;
        if (run_again(check, session)) {
            reply_command_begin(reply, (enum output_format)session->setup.settings.format);
            reply_begin(reply, "check");
            reply_array(reply, "differences");
            if (check->failure.len > 0)
                differs(check, "session.hk", "it ends in an error", buffer_text(&check->failure));
            *view = *session;
            check->report = (struct report){.session = session,
                                            .view = view,
                                            .arena = &check->arena,
                                            .put = compare_file,
                                            .context = check};
            if (session->runs == 0 && session->recordings == 0)
                differs(check, "session.hk", "it gives neither a run nor a recording", TEXT(""));
            else if (!report_write(&check->report, &error))
                differs(check, "session.hk", "it gives no report", text_of(error.text));
            document_free(&check->report.document);
            conclude(check);
            reply_command_end(reply, "check");
            status = check->differences ? ERROR_COMMAND : 0;
        }
        buffer_free(&check->failure);
        arena_reset(&check->arena);
    }
    free(view);
    free(check);
    return status;
}
