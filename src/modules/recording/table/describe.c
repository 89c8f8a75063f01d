/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Describes a loaded recording in lines of text: file, columns, runs, warnings. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/result.h>
#include "modules/recording/table/table.h"

#define COLUMNS_SHOWN 8

/* Returns the name of the separator for the description. */
static const char *separator_name(const struct recording *recording)
{
    if (recording->columns == 1)
        return "one column";
    switch (recording->separator) {
    case '\t':
        return "tab";
    case ';':
        return "semicolon";
    case ',':
        return "comma";
    default:
        return "blanks";
    }
}

/* Appends the name of a column, and its unit in brackets if it has one. */
static void put_column(struct buffer *text, const struct column *column)
{
    buffer_format(text, column->unit[0] ? "%s [%s]" : "%s%s", column->name, column->unit);
}

/* Appends the list of columns and the options that change their choice. */
static void put_columns(struct buffer *text, const struct recording *recording)
{
    buffer_put(text, TEXT("columns: "));
    for (int i = 0; i < recording->columns && i < COLUMNS_SHOWN; i++) {
        buffer_format(text, "%s%d ", i ? ", " : "", i + 1);
        put_column(text, &recording->column[i]);
        if (i == recording->time)
            buffer_put(text, TEXT(" = t"));
        else if (i == recording->value)
            buffer_put(text, TEXT(" = y"));
    }
    if (recording->columns > COLUMNS_SHOWN)
        buffer_format(text, " and %d more", recording->columns - COLUMNS_SHOWN);
    buffer_put(text, TEXT("  (change with t= y= unit= tunit= rate= decimal= sep=)\n"));
}

/* Appends a line with file, value, rows and span; then columns, runs and warnings, a line each. */
void recording_describe(const struct recording *recording, struct buffer *text)
{
    safe_text(text, text_last_component(text_of(recording->path)), false);
    buffer_put(text, TEXT(": "));
    if (recording->container)
        buffer_format(text, "%s, ", recording->container);
    put_column(text, &recording->column[recording->value]);
    buffer_format(text, ", %zu rows, ", recording->rows);
    buffer_short(text, recording->t[0], 6);
    buffer_put(text, TEXT(".."));
    buffer_short(text, recording->t[recording->rows - 1], 6);
    buffer_put(text, TEXT(" s, "));
    buffer_short(text, recording->rate, 4);
    buffer_format(text, " Hz; %s%s, %d header line%s", separator_name(recording),
                  recording->decimal == ',' ? ", decimal comma" : "", recording->header_lines,
                  plural_s(recording->header_lines));
    if (recording->dropped > 0)
        buffer_format(text, ", %zu %s dropped", recording->dropped,
                      recording->dropped == 1 ? "row" : "rows");
    buffer_char(text, '\n');
    put_columns(text, recording);
    if (recording->calibration.known) {
        buffer_put(text, TEXT("calibrated: "));
        calibration_put(&recording->calibration, text);
        buffer_put(text, TEXT(" (raw, and calibrated)\n"));
    }
    if (recording->runs > 1) {
        buffer_put(text, TEXT("runs: "));
        run_list(recording, text);
        buffer_put(text, TEXT("  (change with run=)\n"));
    }
    recording_describe_masked(recording, text);
    for (int i = 0; i < recording->warnings; i++)
        buffer_format(text, "warning: %s\n", recording->warning[i]);
}
