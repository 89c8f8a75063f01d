/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands undo, redo, checkpoint, restore and save. */
#ifndef COMMAND_ROWS
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/command/handler.h>
#include <hooke/report.h>

#include <math.h>
#include <string.h>

/* Goes back (or forward) by N statements and names each. Returns false with the error set if there
 * is none. */
static bool undo_or_redo(struct session *session, const struct arguments *args, bool back,
                         struct reply *reply, struct error *error)
{
    const struct argument_value *count = argument_value(args, "N");
    const int steps = count->count ? (int)fmin(count->item->value.value, 1e9) : 1;
    char label[LIMIT_NAME + 1];
    int done = 0;
    while (done < steps && undo_move(session, back, label, error)) {
        reply_line(reply, "%s: %s", back ? "undone" : "redone", label);
        done++;
    }
    if (done > 0 && done < steps)
        reply_warning(reply, "only %d could be %s", done, back ? "undone" : "redone");
    return done > 0;
}

HANDLER(undo)
{
    return undo_or_redo(session, args, true, reply, error);
}

HANDLER(redo)
{
    return undo_or_redo(session, args, false, reply, error);
}

/* Keeps the present state under a name. */
HANDLER(checkpoint)
{
    const struct argument_value *name = argument_value(args, "NAME");
    const struct text text = name->count ? name->item->text : TEXT("last");
    if (text.len == 0 || text.len > LIMIT_NAME)
        return error_at(error, text, "a name of 1 to %d letters", LIMIT_NAME);
    const char *label = arena_text(args->arena, text);
    if (!label)
        return error_memory(error);
    if (!checkpoint_make(session, label, error))
        return false;
    reply_line(reply, "checkpoint %s", label);
    return true;
}

/* Returns to a checkpoint, the latest one without a name. */
HANDLER(restore)
{
    const struct argument_value *name = argument_value(args, "NAME");
    const char *label;
    if (!checkpoint_restore(session, name->count ? name->item->text : TEXT(""), &label, error))
        return false;
    reply_line(reply, "restored %s", label);
    return true;
}

/* Returns true if a file of that name can hold a set-up; for endings of pictures and tables sets an
 * error that names the right command. */
static bool is_setup_file(struct text path, struct error *error)
{
    const struct text end = text_ending(path);
    const struct picture_writer *pictures = module_pictures();
    const bool picture = pictures && catalog_find(pictures->kinds, end),
               table = catalog_find(&table_format_catalog, end);
    if (!picture && !table)
        return true;
    error_at(error, path, "'save' writes the commands of the set-up, not a %s",
             picture ? "picture" : "table");
    return error_hint(
        error, picture ? "'plot position > %.*s' writes a picture" : "'export %.*s' writes the run",
        (int)path.len, path.data);
}

/* Writes the set-up as commands to a file. */
HANDLER(save)
{
    const struct item *file = argument_value(args, "FILE")->item;
    if (!is_setup_file(file->text, error))
        return false;
    char *path = arena_text(args->arena, file->text);
    struct buffer text = {0};
    session_save(session, &text);
    if (!path || text.failed) {
        buffer_free(&text);
        return error_memory(error);
    }
    const bool ok = file_write(path, buffer_text(&text),
                               session_policy(session, has_argument(args, "force")), error);
    buffer_free(&text);
    if (!ok && !error->where.data)
        error->where = file->text;
    struct buffer shown = {0};
    safe_text(&shown, file->text, false);
    if (ok)
        reply_line(reply,
                   memchr(file->text.data, ' ', file->text.len)
                       ? "set-up saved in %s (source \"%s\" brings it back)"
                       : "set-up saved in %s ('source %s' brings it back)",
                   buffer_view(&shown), buffer_view(&shown));
    buffer_free(&shown);
    return ok;
}
#endif

COMMAND(undo, .group = "STATE", ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(redo, .group = "STATE", ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(checkpoint, .group = "STATE", ARGUMENTS(PLACE("NAME", TYPE_TEXT)))

COMMAND(restore, .group = "STATE", .flags = COMMAND_CHANGES, ARGUMENTS(PLACE("NAME", TYPE_TEXT)))

COMMAND(save, .group = "STATE", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("FILE", TYPE_FILE, .flags = ARG_REQUIRED), OPTION("force", TYPE_NONE)))
