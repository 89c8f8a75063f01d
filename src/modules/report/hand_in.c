/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command report, which writes the folder that a student hands in. */
#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include <hooke/data.h>
#include <hooke/base/safe_text.h>
#include <hooke/command/handler.h>
#include "modules/report/lab.h"
#include <hooke/session/log.h>

#include <stdio.h>

/* Writes session.hk. Comments that say how to run it come first, then all statements of the
 * session. Adds the number of comment lines to *head. */
static void put_script(const struct session *session, int *head, struct buffer *output)
{
    buffer_put(
        output,
        TEXT("# The session of this report, by hooke " HOOKE_VERSION
             ". It gives the same numbers again\n# where its recordings have the same names:\n"));
    const bool fails = history_fails(session);
    buffer_format(output, "#   hooke %s-f session.hk -c 'report NEW'\n",
                  fails ? "--keep-going " : "");
    buffer_put(output,
               fails ? TEXT("# One of its commands ends in an error, as it did in the session.\n")
                     : TEXT(""));
    for (size_t i = 0; i < output->len; i++)
        *head += output->data[i] == '\n';
    history_put(session, 0, HISTORY_SCRIPT, output);
}

/* Ends the report's document with links to the other files of the folder and the text of session.hk
 * (`script`). */
static void put_report_end(struct report *report, const struct buffer *script)
{
    struct document *document = &report->document;
    static const char *const files[][2] = {
        {"values.csv", "every value with all its digits, uncertainty and unit"},
        {"session.hk", "the session as commands that reproduce the numbers"},
    };
    document_put(document, BLOCK_PART, "Files");
    document_open(document, BLOCK_LIST);
    for (size_t i = 0; i < COUNT_OF(files); i++) {
        document_open(document, BLOCK_ITEM);
        document_link(document, files[i][0], files[i][0]);
        document_say(document, ": %s", files[i][1]);
        document_close(document, BLOCK_ITEM);
    }
    if (report->session->runs.count > 0) {
        document_open(document, BLOCK_ITEM);
        document_link(document, "runs.csv", "runs.csv");
        document_say(document, ": a row for each run; the samples of those shown are in run-N.csv");
        document_close(document, BLOCK_ITEM);
    }
    for (int i = 0; i < report->session->recordings; i++) {
        char name[64];
        snprintf(name, sizeof name, "recording-%d.csv", i + 1);
        if (!report->recording_shown[i])
            continue;
        document_open(document, BLOCK_ITEM);
        document_link(document, name, name);
        document_say(document, ": the recording ");
        document_name(document, text_of(report->session->recording[i]->recording->name));
        document_close(document, BLOCK_ITEM);
    }
    document_close(document, BLOCK_LIST);
    document_put(document, BLOCK_PART, "The session");
    document_code(document, buffer_text(script));
    document_end(document);
}

/* Writes all files of the report by report->put or into its folder. The script is made first,
 * because values refer to its lines; figures are written by the sections, and tables after them, as
 * they contain what the figures show. Returns false with an error. */
bool report_write(struct report *report, struct error *error)
{
    struct document *document = &report->document;
    struct buffer script = {0};
    put_script(report->session, &report->head, &script);
    if (!collect_values(report, error) || !sort_material(report, error)) {
        buffer_free(&script);
        return false;
    }
    document_begin(document, report_of_lab(report) ? "Numerical integration of a spring and mass"
                                                   : "Numerical integration");
    document_put(document, BLOCK_PARAGRAPH, "Name:");
    document_put(document, BLOCK_PARAGRAPH, "Date:");
    bool ok = write_sections(report, error) && write_tables(report, error);
    if (ok)
        put_all_values(report);
    if (ok)
        put_report_end(report, &script);
    ok = ok && report_put(report, "session.hk", &script, error) &&
         report_put(report, "report.md", &document->md, error) &&
         report_put(report, "report.html", &document->html, error) &&
         (!report->latex || report_put(report, "report.tex", &document->tex, error));
    buffer_free(&script);
    return ok;
}

/* Tells one thing that the report lacks, as a line, or as an item of the list `missing` if that is
 * open. */
static void say_missing(void *context, const char *what, const char *type)
{
    struct reply *reply = context;
    struct buffer text = {0};
    buffer_format(&text, "%s (%s)", what, type);
    if (reply->depth > 0)
        reply_string(reply, NULL, buffer_view(&text));
    else
        reply_line(reply, "  not included: %s", buffer_view(&text));
    buffer_free(&text);
}

/* Replies with what was written, what the report lacks, and whether PDF figures failed. `path` is
 * the folder as given, folder->text the same as typed. */
static void hand_in_reply(const struct report *report, const struct item *folder, const char *path,
                          struct reply *reply)
{
    struct buffer shown = {0};
    safe_text(&shown, folder->text, false);
    const char *const next = report->latex ? ", or type: pdflatex report.tex" : " or report.md";
    reply_line(reply, "report written to %s: %d figure%s, %d values, %d files; open report.html%s",
               buffer_view(&shown), report->figures, report->figures == 1 ? "" : "s",
               report->values, report->files, next);
    report_missing(report, say_missing, reply);
    reply_begin(reply, "report");
    reply_string(reply, "folder", path);
    reply_int(reply, "figures", report->figures);
    reply_int(reply, "values", report->values);
    reply_int(reply, "files", report->files);
    reply_bool(reply, "pictures", true);
    reply_array(reply, "missing");
    report_missing(report, say_missing, reply);
    reply_close(reply);
    reply_end(reply);
    if (report->no_pdf[0])
        reply_warning(reply, "the figures in report.tex are text only: %s", report->no_pdf);
    buffer_free(&shown);
}

/* Writes the report into the folder DIR, which is replaced as a whole or, on failure, left as it
 * was. */
HANDLER(report)
{
    const struct item *item = argument_value(args, "DIR")->item;
    const char *path = arena_text(args->arena, item->text);
    struct report *report = arena_alloc(args->arena, sizeof *report);
    struct session *view = arena_alloc(args->arena, sizeof *view);
    struct folder folder;
    if (!path || !report || !view)
        return error_memory(error);
    if (session->runs.count == 0 && session->recordings == 0) {
        error_set(error, ERROR_COMMAND, "nothing to report yet: there is no run and no recording");
        return error_hint(error, "type: run, or: load FILE");
    }
    *view = *session;
    *report = (struct report){.session = session,
                              .view = view,
                              .arena = args->arena,
                              .folder = &folder,
                              .latex = has_argument(args, "latex")};
    bool ok = folder_open(&folder, path, session_policy(session, has_argument(args, "force")),
                          report_owns, error);
    /* the folder appears complete, or as it was before */
    if (ok && !(report_write(report, error) && !cancelled(session->front.cancel))) {
        folder_abandon(&folder);
        ok = false;
    }
    ok = ok && folder_commit(&folder, error);
    document_free(&report->document);
    if (ok)
        hand_in_reply(report, item, path, reply);
    else if (!error->where.data)
        error->where = item->text;
    return ok;
}
#endif

COMMAND(report, .group = "OUTPUT",
        ARGUMENTS(PLACE("DIR", TYPE_FILE, .flags = ARG_REQUIRED), OPTION("force", TYPE_NONE),
                  OPTION("latex", TYPE_NONE)))
