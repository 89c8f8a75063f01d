/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scripts: joins lines that end in a backslash, counts lines, stops at the first error; and files
 * that source other files. */
#define _GNU_SOURCE /* memmem */
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/command/handler.h>
#include <hooke/session/log.h>

#include <string.h>
#include <unistd.h>

void script_begin(struct script *script, struct session *session, const char *name,
                  const struct source *parent)
{
    *script = (struct script){.where = {.name = name, .parent = parent},
                              .first = session->history.count,
                              .commands = session->history.done,
                              .ok = true};
}

/* Executes a joined line and decides if the script stops. */
static void script_execute(struct script *script, struct session *session, struct text line,
                           struct reply *reply)
{
    struct source where = script->where;
    where.line = script->piece[0].line;
    where.piece = script->piece;
    where.pieces = script->pieces;
    script->pieces = 0;
    if (command_exec(session, line, &where, reply) && !session->execution.halted)
        return;
    script->ok = false;
    script->stopped = !session->options.keep_going ||
                      session->execution.status == ERROR_CANCELLED || reply->failed ||
                      session->execution.halted;
}

/* Shows the line before it is executed, with -v. */
static void script_line_show(const struct session *session, struct text line, struct reply *reply)
{
    struct buffer safe = {0};
    safe_text(&safe, line, false);
    if (session->options.verbose)
        reply_note(reply, "+ %s", buffer_view(&safe));
    buffer_free(&safe);
}

/* Adds a line to the pending one, or executes it if it is complete. Returns false if the script has
 * stopped. */
bool script_feed(struct script *script, struct session *session, struct text line,
                 struct reply *reply)
{
    if (script->stopped || session->execution.quit)
        return false;
    script->where.line++;
    if (script->where.line == 1 && text_starts(line, TEXT("\xEF\xBB\xBF")))
        line = text_after(line, 3);
    script_line_show(session, line, reply);
    const struct text whole = line;
    line = text_trim(line);
    const bool comment = line.len > 0 && line.data[0] == '#';
    const bool joins = line.len > 0 && line.data[line.len - 1] == '\\' && !comment;
    struct buffer *pending = &script->pending;
    if (script->pieces < (int)COUNT_OF(script->piece))
        script->piece[script->pieces++] =
            (struct source_piece){pending->len, script->where.line, (int)(line.data - whole.data)};
    if (!joins && pending->len == 0) {
        script_execute(script, session, line, reply);
    } else {
        /* An endless joined line grows to just above the limit, where it is refused. */
        if (pending->len <= LIMIT_LINE)
            buffer_put(pending, (struct text){line.data, joins ? line.len - 1 : line.len});
        buffer_char(pending, ' ');
        if (!joins) {
            script_execute(script, session, text_trim(buffer_text(pending)), reply);
            buffer_clear(pending);
        }
    }
    return !script->stopped && !session->execution.quit;
}

/* Appends the numbers of the runs that a stopped script leaves. */
static void put_runs_left(const struct session *session, struct buffer *text)
{
    if (session->runs.count == 1)
        buffer_format(text, ", run %d kept", session->runs.slot[0]->run->number);
    else if (session->runs.count > 1)
        buffer_format(text, ", runs %d-%d kept", session->runs.slot[0]->run->number,
                      session->runs.slot[session->runs.count - 1]->run->number);
}

/* Notes that the script has set the frequency of a drive and left the drive off: the frequency of a
 * spring was probably meant. Scripts may set the force after the frequency. */
static void note_idle_drive(const struct script *script, const struct session *session,
                            struct reply *reply)
{
    const struct scene *scene = &session->setup.scene;
    const int omega = scene_param(scene, "omega"), force = scene_param(scene, "F0");
    if (scene->model != &oscillator_model || omega < 0 || force < 0 || scene->value[force] != 0)
        return;
    const size_t origin = session->setup.origin[omega];
    if (origin <= script->first || origin <= session->history.first)
        return;
    /* undo changes the value, too, but does not name it */
    const struct text typed = history_text(session, history_entry(session, origin - 1));
    if (memmem(typed.data, typed.len, "omega", 5))
        reply_note(reply, "  (omega is the frequency of the drive, which is off: F0 = 0; for a "
                          "spring with this frequency type: omega0 = VALUE)");
}

/* Executes what is pending and, for the outermost script, tells where it stopped. Returns true if
 * every command succeeded. */
bool script_end(struct script *script, struct session *session, struct reply *reply)
{
    if (script->pending.len > 0 && !script->stopped && !session->execution.quit)
        script_execute(script, session, text_trim(buffer_text(&script->pending)), reply);
    buffer_free(&script->pending);
    const struct source *parent = script->where.parent;
    const bool outermost = !parent || !parent->name;
    const char *const name_of_argument = script->where.name; /* NULL for one typed line */
    const bool one_line =
        !name_of_argument || (script->where.line <= 1 && strcmp(name_of_argument, "-c") == 0);
    if (script->stopped && outermost && !one_line && reply->format != FORMAT_JSON) {
        struct buffer saved = {0}, name = {0};
        put_runs_left(session, &saved);
        safe_text(&name, text_of(name_of_argument), false);
        const int done = session->history.done - script->commands;
        reply_note(reply, "%s: stopped at line %d (%d command%s run%s)", buffer_view(&name),
                   script->where.line, done, plural_s(done), buffer_view(&saved));
        buffer_free(&saved);
        buffer_free(&name);
    }
    if (!script->stopped && outermost)
        note_idle_drive(script, session, reply);
    return script->ok;
}

/* Returns the path of a file named in a script: in the folder of the command file if it is relative
 * and does not exist otherwise; NULL if out of memory. */
char *script_path(const struct source *where, struct text name, struct arena *arena)
{
    char *path = arena_text(arena, name);
    const char *slash = where && where->name ? strrchr(where->name, '/') : NULL;
    if (!path || !slash || *path == '/' || access(path, F_OK) == 0)
        return path;
    const size_t folder = (size_t)(slash + 1 - where->name);
    char *sibling_path = arena_alloc(arena, folder + name.len + 1);
    if (!sibling_path)
        return NULL;
    memcpy(sibling_path, where->name, folder);
    memcpy(sibling_path + folder, path, name.len + 1);
    return access(sibling_path, F_OK) == 0 ? sibling_path : path;
}

/* Returns true unless the file would source itself or is nested too deeply; then sets an error. */
static bool check_nesting(const char *path, const struct source *parent, struct error *error)
{
    struct buffer chain = {0};
    int depth = 0;
    bool cycle = false;
    for (const struct source *s = parent; s; s = s->parent) {
        if (!s->name)
            continue;
        depth++;
        cycle |= strcmp(s->name, path) == 0;
        buffer_format(&chain, "%s%s:%d", chain.len ? ", sourced at " : "", s->name, s->line);
    }
    if (cycle)
        error_set(error, ERROR_USAGE, "%s would source itself; it is already being read (%s)", path,
                  buffer_view(&chain));
    else if (depth >= LIMIT_SOURCE_DEPTH)
        error_set(error, ERROR_USAGE,
                  "depth of files that source other files: more than %d deep (%s)",
                  LIMIT_SOURCE_DEPTH, buffer_view(&chain));
    buffer_free(&chain);
    return !cycle && depth < LIMIT_SOURCE_DEPTH;
}

/* Returns true unless the file contains a NUL byte; then sets an error. */
static bool check_content(const char *path, struct text content, struct error *error)
{
    const char *nul = content.len ? memchr(content.data, 0, content.len) : NULL;
    int line = 1;
    for (const char *c = content.data; nul && c < nul; c++)
        line += *c == '\n';
    return !nul ||
           error_set(error, ERROR_USAGE,
                     "%s: line %d contains a NUL byte, so this is not a command file", path, line);
}

/* Executes the lines of a file. Returns false after an error, which has been reported. */
bool script_file(struct session *session, const char *path, const struct source *parent,
                 struct reply *reply)
{
    struct buffer content = {0};
    struct error error = {0};
    if (!check_nesting(path, parent, &error) || !file_read(path, LIMIT_SCRIPT, &content, &error) ||
        !check_content(path, buffer_text(&content), &error)) {
        error.code = ERROR_USAGE;
        reply->format = (enum output_format)session->setup.settings.format;
        reply_error(reply, &error, parent && parent->name ? parent : NULL, (struct text){NULL, 0});
        if (session->options.keep_going)
            session->execution.status = ERROR_COMMAND;
        else
            session->execution.status =
                session->execution.status ? session->execution.status : ERROR_USAGE;
        buffer_free(&content);
        return false;
    }
    struct script script;
    script_begin(&script, session, path, parent);
    struct text rest = buffer_text(&content), line;
    while (rest.len > 0 && text_split(&rest, '\n', &line) &&
           script_feed(&script, session, line, reply))
        ;
    const bool ok = script_end(&script, session, reply);
    buffer_free(&content);
    return ok;
}

/* Returns true if the setting may be set here: programs can be chosen only at a prompt, which each
 * source of the statement must be; else sets an error. */
bool check_typed(const struct session *session, const struct setting *setting,
                 const struct source *where, struct error *error)
{
    bool typed = session->front.interactive && !session->execution.reacting;
    for (; where; where = where->parent)
        typed &= where->name == NULL;
    if (setting->typed && session->options.safe)
        return error_set(error, ERROR_COMMAND, "--safe allows no other programs: %s stays off",
                         setting->row.name);
    return !setting->typed || typed ||
           error_set(error, ERROR_COMMAND,
                     "%s can be set only at a prompt; files and -c must not run programs",
                     setting->row.name);
}
