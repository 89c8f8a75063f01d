/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The interpreter: command_exec() divides a line into statements, and executes each by its handler
 * so that it is atomic, can be undone and is recorded. */
#define _GNU_SOURCE /* memmem */
#include <hooke/base/cancel.h>
#include <hooke/base/statement.h>
#include <hooke/module.h>
#include <hooke/scene/formula.h>
#include <hooke/report.h>
#include "command/finding.h"
#include <hooke/command/handler.h>
#include "command/redirect.h"
#include "command/run/event_pass.h"
#include "command/in_full.h"
#include "command/short_form.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns true for NAME = value, but neither for NAME == … nor for NAME' = …. */
static bool is_assignment(struct text statement)
{
    struct text name = peek_name(statement);
    struct text rest = {statement.data + name.len, statement.len - name.len};
    text_skip_blanks(&rest);
    return name.len > 0 && rest.len > 0 && rest.data[0] == '=' &&
           (rest.len == 1 || rest.data[1] != '=');
}

/* Returns true for NAME' = … and NAME'' = …. */
static bool is_equation(struct text statement)
{
    const struct text name = peek_name(statement);
    struct text rest = {statement.data + name.len, statement.len - name.len};
    const size_t marked = rest.len;
    while (rest.len > 0 && rest.data[0] == '\'')
        rest = text_after(rest, 1);
    const bool marks = rest.len < marked;
    text_skip_blanks(&rest);
    return name.len > 0 && marks && rest.len > 0 && rest.data[0] == '=';
}

/* Sets the error for a word that is no command, with advice for words that are something else.
 * Returns false. */
static bool unknown_command(const struct session *session, struct text word, struct error *error)
{
    struct named_value value;
    char name[LIMIT_NAME + 1];
    snprintf(name, sizeof name, "%.*s", (int)word.len, word.data);
    if (!module_is_in(name, word, error))
        return false;
    catalog_unknown(&command_catalog, word, error);
    if (memmem(word.data, word.len, "\xe2\x80\x99", 3))
        return error_hint(error, "a derivative is marked with the ASCII sign: x' or x''");
    if (names_value(session, word, &value))
        return error_hint(error, "'print %.*s' shows it, '%.*s = VALUE' sets it", (int)word.len,
                          word.data, (int)word.len, word.data);
    if (error->hint[0])
        return error_hint(error, "('help' lists the commands)");
    error_hint(error, "'help' lists the commands");
    error->hint_kind = HINT_LIST;
    return false;
}

/* Sets *command to the command of the statement and moves the parser behind its word. Assignments
 * and equations have commands without a word; a single name is printed. Returns false with the
 * error set. */
static bool find_command(struct session *session, struct parser *parser,
                         const struct command **command, struct error *error)
{
    if (is_assignment(parser->rest)) {
        *command = command_with(COMMAND_ASSIGNS);
        return true;
    }
    if (is_equation(parser->rest)) {
        *command = command_with(COMMAND_EQUATES);
        return true;
    }
    const struct text word = peek_word(parser->rest, "");
    *command =
        (const struct command *)(const void *)catalog_choose(session, &command_catalog, word);
    struct named_value value;
    if (!*command && text_trim(parser->rest).len == word.len &&
        names_value(session, word, &value)) {
        *command =
            (const struct command *)(const void *)catalog_find(&command_catalog, TEXT("print"));
        return *command;
    }
    parser->rest = (struct text){word.data + word.len, parser->rest.len - word.len};
    return *command || unknown_command(session, word, error);
}

/* Runs the handler after taking a snapshot, and keeps the snapshot for undo if the command has
 * changed the session. */
static bool run_handler(struct session *session, const struct arguments *arguments, size_t entry,
                        struct reply *reply, struct error *error)
{
    const struct command *command = arguments->command;
    struct snapshot *previous = NULL;
    session->setup.scene.steps_across_kinks = session->setup.settings.turning == TURNING_OFF;
    /* Changes during a run, or by its events, are undone with the run. */
    if ((command->flags & COMMAND_CHANGES) && session->live.state != LIVE_RUNNING &&
        !session->execution.reacting && !session->growing &&
        !(previous = snapshot_take(session, "")))
        return error_memory(error);
    const uint64_t changes = session->changes;
    const bool ok = command->handler(session, arguments, reply, error);
    /* A cancelled command may report only that it failed. */
    if (!ok && cancelled(session->front.cancel) && error->code != ERROR_CANCELLED)
        error_set(error, ERROR_CANCELLED, "stopped");
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->statement_ended)
            module_list[i]->statement_ended(session);
    /* A run that diverged is an error, and a change all the same. */
    if (previous && session->changes != changes && undo_matters(session, previous))
        undo_push(session, previous, entry);
    else
        snapshot_free(previous);
    return ok;
}

/* Draws the result of the statement into the file behind >, by executing the plot of that name. */
static bool draw_redirected(struct session *session, const struct arguments *arguments,
                            const struct redirect *redirect, struct reply *reply,
                            struct error *error)
{
    struct buffer statement = {0};
    redirect_put_plot(redirect, &statement);
    const char *line = arena_text(arguments->arena, buffer_text(&statement));
    struct arguments *plot = arena_alloc(arguments->arena, sizeof *plot);
    buffer_free(&statement);
    if (!line || !plot)
        return error_memory(error);
    struct parser parser = {session, arguments->scope, arguments->arena, text_of(line)};
    plot->scope = arguments->scope;
    plot->arena = arguments->arena;
    plot->where = arguments->where;
    if (find_command(session, &parser, &plot->command, error) &&
        parse_arguments(&parser, plot->command, plot, error) &&
        plot->command->handler(session, plot, reply, error))
        return true;
    error->where = redirect->file;
    return false;
}

/* Runs the command `entry` with its arguments and keeps the tables in its reply as results of the
 * session. With a redirection (`> FILE`) nothing is printed; the last table, or the picture for
 * redirect->plot, is written to the file, which is abandoned if the command fails. Returns false
 * with the error set if the command or writing fails. */
static bool run_collected(struct session *session, const struct arguments *arguments, size_t entry,
                          struct redirect *redirect, struct reply *reply, struct error *error)
{
    struct table_store said = {0}, *outer = reply->store;
    const bool muted = reply->muted, redirected = redirect->file.len > 0;
    if (redirected && !redirect_open(session, redirect, arguments->arena, error))
        return false;
    reply->store = &said;
    reply->muted |= redirected;
    struct short_form form;
    short_form_begin(&form, session, arguments, reply);
    bool ok = run_handler(session, arguments, entry, reply, error);
    reply_flush(reply);
    short_form_end(&form, reply);
    reply->store = outer;
    reply->muted = muted;
    const struct row *table_row =
        session_keep_results(session, &said, arguments->command->row.name);
    if (!redirected)
        return ok;
    if (!ok || redirect->plot)
        writer_abandon(&redirect->writer);
    if (!ok)
        return false;
    buffer_clear(&reply->lines);
    reply->recorded &= !redirect->plot; /* output of a study is dropped before drawing */
    if (redirect->plot)
        return draw_redirected(session, arguments, redirect, reply, error);
    return redirect_finish(session, redirect, table_row, reply, error);
}

/* Returns true if the statement sets a setting that only a person at a prompt may set. Such
 * statements are not recorded. */
static bool is_typed_only(const struct arguments *arguments)
{
    if (!(arguments->command->flags & COMMAND_ASSIGNS))
        return false;
    const struct argument_value *name = argument_value(arguments, "NAME"),
                                *value = argument_value(arguments, "VALUE");
    const struct row *row = name->count ? catalog_find(&setting_catalog, name->item->text) : NULL;
    const struct setting *setting = setting_from(row);
    const struct row *choice = row && value->count ? value->item->row : NULL;
    return choice && setting->typed &&
           catalog_find(setting->choices, text_of(choice->name)) == choice;
}

/* Adds the end of a statement to the history and to the file of `record`. A statement typed during
 * a run is recorded with the run, one of a sourced file with the file. Returns false with the error
 * set if recording failed. */
static bool log_statement(struct session *session, const struct arguments *arguments, size_t entry,
                          struct text typed, size_t output, unsigned flags, struct error *error)
{
    struct buffer full = {0};
    statement_in_full(session, arguments, typed, &full);
    if (arguments->command->flags & COMMAND_UNRECORDED || is_typed_only(arguments))
        flags |= ENTRY_UNRECORDED;
    if (arguments->command->flags & COMMAND_NESTS)
        flags |= ENTRY_NESTS;
    if (writes_file(arguments))
        flags |= ENTRY_WRITES;
    if (full.failed)
        flags |= ENTRY_LOST;
    history_end(session, entry, buffer_text(&full), output, flags);
    buffer_free(&full);
    return (history_entry(session, entry)->flags & (ENTRY_WITHIN | ENTRY_SOURCED)) ||
           record_append(session, entry, error);
}

/* Sets the error for commands that a saved session must not contain. Returns false. */
static bool refuse_in_saved(struct error *error)
{
    return error_set(error, ERROR_COMMAND, "this command is not allowed in a saved session");
}

/* Executes one statement of the line: finds the command, checks that it is allowed now, parses
 * arguments, runs it and logs it. log_line is the index of the line in the history. Returns false
 * with the error set; the session is then unchanged unless a run has made steps. */
static bool exec_statement(struct session *session, struct text line, size_t log_line,
                           struct text statement, const struct source *where, struct reply *reply,
                           struct arena *arena, struct error *error)
{
    if (cancelled(session->front.cancel))
        return error_set(error, ERROR_CANCELLED, "interrupted");
    struct names names = {.session = session, .expects_run = true};
    const struct expr_scope scope = names_scope(&names);
    struct parser parser = {session, &scope, arena, statement};
    struct arguments *arguments = arena_alloc(arena, sizeof *arguments);
    if (!arguments)
        return error_memory(error);
    arguments->scope = &scope;
    arguments->arena = arena;
    arguments->where = where;
    if (!find_command(session, &parser, &arguments->command, error))
        return false;
    arguments->word = (struct text){statement.data, (size_t)(parser.rest.data - statement.data)};
    const struct run *running = session->live.state == LIVE_RUNNING ? session_run(session) : NULL;
    if (running && !(arguments->command->flags & COMMAND_ANYTIME)) {
        error_set(error, ERROR_COMMAND, "%s is not possible now: run %d is still in progress",
                  arguments->command->row.name, running->number);
        return error_hint(error, "'pause' or Ctrl-C pauses it");
    }
    if (session->growing && !(arguments->command->flags & (COMMAND_ANYTIME | COMMAND_BESIDE))) {
        error_set(error, ERROR_COMMAND, "%s is not possible now: a recording is being collected",
                  arguments->command->row.name);
        return error_hint(error, "'stop' or Ctrl-C ends and keeps it");
    }
    if (session->execution.reacting && !event_executes(arguments->command))
        return refuse_in_event(arguments->command, arguments->word, error);
    if (session->execution.restoring &&
        !(arguments->command->flags & (COMMAND_CHANGES | COMMAND_RESTORES)))
        return refuse_in_saved(error);
    names.letters = text_is(text_of(arguments->command->row.name), "print");
    /* Only a condition looks into a run that is about to start. */
    names.expects_run = (arguments->command->flags & COMMAND_STARTS) != 0;
    reply_command_begin(reply, (enum output_format)session->setup.settings.format);
    const struct text typed = statement;
    struct redirect redirect;
    redirect_take(arguments->command, &statement, &redirect);
    parser.rest.len = (size_t)(statement.data + statement.len - parser.rest.data);
    if (!parse_arguments(&parser, arguments->command, arguments, error)) {
        if (redirect.file.len == 0) /* it was read as an argument */
            redirect_explain(arguments->command, typed, error);
        return false;
    }
    if (session->execution.restoring && redirect.file.len > 0)
        return refuse_in_saved(error);
    const uint64_t changes = session->changes;
    struct error lost = {0};
    size_t entry = 0;
    /* Statements that events execute are part of the statement that ran into them. */
    if (!session->execution.reacting &&
        !history_begin(session, log_line, line, typed, &entry, error))
        return false;
    session->execution.confirmed = false;
    free(session->execution.meant);
    session->execution.meant = NULL;
    const struct scene previous = session->setup.scene;
    const bool ok = run_collected(session, arguments, entry, &redirect, reply, error);
    if (!session->execution.reacting && !(arguments->command->flags & COMMAND_NESTS))
        session_trace(session, &previous, entry + 1);
    const unsigned flags =
        (ok ? ENTRY_DONE : 0) | (session->changes != changes ? ENTRY_CHANGED : 0) |
        (running || (session->growing && session->execution.nesting > 1) ? ENTRY_WITHIN : 0);
    const bool recorded =
        session->execution.reacting ||
        log_statement(session, arguments, entry, typed, typed.len - statement.len, flags, &lost);
    reply_command_end(reply, arguments->command->row.name);
    if (!recorded && !ok)
        reply_warning(reply, "%s", lost.text);
    else if (!recorded)
        *error = lost;
    if (!ok || !recorded)
        return false;
    if (reply->failed) {
        error_set(error, ERROR_IO,
                  "the results could not be written: the output is closed or its device is full");
        return false;
    }
    return true;
}

/* Sets the exit status after an error, unless an earlier error has set it. */
static void note_failure(struct session *session, const struct error *error)
{
    if (session->options.keep_going && error->code != ERROR_CANCELLED)
        session->execution.status = ERROR_COMMAND;
    else if (session->execution.status == 0)
        session->execution.status = (int)error->code;
}

/* Tells which statements behind a paused run on the same line were not executed. */
static void note_left_out(struct text rest, struct reply *reply)
{
    struct text statement = rest;
    struct error ignored;
    next_statement(&rest, &statement, &ignored);
    if (statement.len > 0) {
        const int shown = (int)(statement.len < 80 ? statement.len : 80);
        reply_note(reply, "not executed, because the run was paused: %.*s%s", shown, statement.data,
                   rest.len > 0 ? "; ..." : "");
    }
}

/* Frees the memory of a statement; what remains because the user cancels is freed by a later
 * statement. */
static void free_statement(struct session *session, struct arena *arena)
{
    arena_move(arena, &session->execution.leftover);
    arena_give_back(&session->execution.leftover, session->front.cancel);
}

/* Lets modules continue with what a statement of a script did; at a prompt they do so after the
 * line. */
static void continue_modules(struct session *session, struct reply *reply)
{
    if (session->front.interactive || session->execution.restoring || session->execution.reacting)
        return;
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->prompt.typed)
            module_list[i]->prompt.typed(session, reply);
}

/* Executes the statements of a line until one fails; replies with the error and sets the exit
 * status. Returns false on error. */
static bool exec_line(struct session *session, struct text line, const struct source *where,
                      struct reply *reply)
{
    struct error error = {0};
    struct text rest = line, statement = {0};
    bool ok = true;
    size_t entry = 0;
    if (line.len > LIMIT_LINE)
        ok = error_set(&error, ERROR_COMMAND, "the line is longer than %u bytes", LIMIT_LINE);
    else if (memchr(line.data, 0, line.len))
        ok = error_at(&error, (struct text){memchr(line.data, 0, line.len), 1},
                      "the command contains a NUL byte");
    else if (!session->execution.reacting)
        ok = history_line(session, line, where && where->parent, &entry, &error);
    while (ok && rest.len > 0 && !session->execution.quit && !session->execution.halted) {
        struct arena arena = {0};
        statement = rest; /* the error needs it if the statement has no end */
        ok = next_statement(&rest, &statement, &error) &&
             (statement.len == 0 ||
              exec_statement(session, line, entry, statement, where, reply, &arena, &error));
        if (ok && statement.len > 0)
            continue_modules(session, reply);
        /* An error without a code was reported where it happened: in a sourced file. */
        if (!ok && error.code != ERROR_NONE) {
            reply->format = (enum output_format)session->setup.settings.format;
            explain_unknown(session, statement, &error);
            /* several statements are on the line: name the one that failed */
            if (!error.where.data && statement.len < line.len)
                error.where = statement;
            reply_error(reply, &error, where, line);
            note_failure(session, &error);
        }
        free_statement(session, &arena);
        if (!ok && !session->execution.halted)
            return false;
    }
    if (session->execution.halted && !session->execution.quit) {
        note_left_out(rest, reply);
    } else if (!ok) {
        reply_error(reply, &error, where, error.where.data ? line : (struct text){NULL, 0});
        note_failure(session, &error);
    }
    return ok;
}

/* Executes a line; a line that is typed during a run or by a script inside it is nested. */
bool command_exec(struct session *session, struct text line, const struct source *where,
                  struct reply *reply)
{
    if (line.len == 0)
        return true;
    /* a line that is typed during a run needs its own reply, since that of the run is not complete
     */
    const bool inside = session->live.state == LIVE_RUNNING || session->growing;
    struct reply own;
    reply_init(&own, reply->sink);
    own.quiet = reply->quiet;
    const bool typed = session->execution.typed;
    session->execution.typed = session->front.interactive && !(where && where->name);
    if (session->execution.nesting++ == 0)
        session->execution.halted = false;
    const bool ok = exec_line(session, line, where, inside ? &own : reply);
    reply->failed |= own.failed;
    reply_free(&own);
    session->execution.nesting--;
    session->execution.typed = typed;
    /* a session that is being restored refers to some definitions only later */
    if (session->execution.nesting == 0 && !session->execution.restoring) {
        session_sweep(session);
        history_trim(session);
    }
    if (!inside) {
        live_refresh(session);
        cursors_refresh(session);
    }
    if (session->front.executed)
        session->front.executed(session->front.context);
    return ok;
}
