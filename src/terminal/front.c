/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the abilities of the output and the user's folders, runs the rc file, and shows the next
 * command that a module suggests. */
#include <hooke/base/safe_text.h>
#include "terminal/terminal.h"

#include <langinfo.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

/* Returns true if the names of the locale in the environment end in UTF-8. Its tables are not
 * loaded. */
static bool environment_names_utf8(void)
{
    const char *wish = getenv("LC_ALL");
    wish = wish && *wish ? wish : getenv("LC_CTYPE");
    wish = wish && *wish ? wish : getenv("LANG");
    return wish && (strstr(wish, "UTF-8") || strstr(wish, "utf8"));
}

/* Loads the locale of the environment, or C.UTF-8 if it has no tables but is one of UTF-8. */
void front_load_locale(void)
{
    if (!setlocale(LC_CTYPE, "") && environment_names_utf8())
        setlocale(LC_CTYPE, "C.UTF-8");
}

/* Returns true if text is UTF-8. Loads the locale only if its name does not tell, because loading
 * takes a tenth of the start of the program. */
static bool text_is_utf8(void)
{
    const bool is_loaded = strcmp(setlocale(LC_CTYPE, NULL), "C") != 0;
    if (!is_loaded && environment_names_utf8())
        return true;
    if (!is_loaded)
        front_load_locale();
    return strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
}

/* Finds charset, colour and size of the output fd; options have priority. */
void front_probe(struct front *front, const struct options *options, int fd)
{
    const char *term = getenv("TERM");
    const char *no_color = getenv("NO_COLOR");
    bool terminal = isatty(fd);
    bool dumb = !term || strcmp(term, "dumb") == 0;
    front->utf8 = text_is_utf8() && !(term && strcmp(term, "linux") == 0);
    front->is_terminal = terminal;
    const char *more = getenv("COLORTERM");
    const bool shows_256 = (term && strstr(term, "256color")) || (more && *more);
    if (terminal && !dumb && !(no_color && *no_color))
        front->colors = shows_256 ? 256 : 8;
    struct winsize size;
    if (terminal && ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
        front->width = size.ws_col;
        front->height = size.ws_row;
    }
    if (options->width) {
        front->width = options->width;
        front->height = options->height;
    }
}

/* Creates the missing folders of a path, private to the user. The path is unchanged at the end. */
static void make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        mkdir(path, 0700);
        *slash = '/';
    }
}

/* Returns "$VARIABLE/hooke/NAME" or "$HOME/FALLBACK/hooke/NAME", and creates the folder if `create`
 * is set. Returns NULL if no folder can be used. The caller frees the result. */
static char *user_path(const char *variable, const char *fallback, const char *name, bool create)
{
    struct buffer path = {0};
    const char *base = getenv(variable);
    const char *home = getenv("HOME");
    if (base && base[0] == '/') {
        buffer_format(&path, "%s/hooke/%s", base, name);
    } else if (home && home[0] == '/') {
        buffer_format(&path, "%s/%s/hooke/%s", home, fallback, name);
    }
    if (path.failed || path.len == 0) {
        buffer_free(&path);
        return NULL;
    }
    if (create) {
        make_folders(path.data);
    }
    return path.data;
}

char *state_path(const char *name, bool create)
{
    return user_path("XDG_STATE_HOME", ".local/state", name, create);
}

/* Executes the user's rc file, if it belongs to the user and nobody else can write it. */
void rc_run(struct session *session, struct reply *reply)
{
    if (access("rc.hk", F_OK) == 0) {
        reply_note(reply, "note: ./rc.hk is not read; only rc.hk in the configuration folder is");
    }
    char *path = user_path("XDG_CONFIG_HOME", ".config", "rc.hk", false);
    struct stat status;
    if (path && stat(path, &status) == 0) {
        if (status.st_uid != geteuid() || (status.st_mode & (S_IWGRP | S_IWOTH))) {
            reply_warning(
                reply, "%s is not read; it must belong to you and must not be writable by others",
                path);
        } else {
            script_file(session, path, NULL, reply);
        }
    }
    free(path);
}

#define OFFER_LABEL "next (Enter): "

/* Returns the number of bytes of the statements at the beginning of a line that fit into `room`
 * cells. A quoted semicolon does not end a statement. */
static size_t fitting_statements(struct text line, int room)
{
    size_t fits = 0;
    char quote = 0;
    for (size_t i = 0; i <= line.len; i++) {
        const bool end = i == line.len;
        if ((end || (!quote && line.data[i] == ';')) &&
            text_width((struct text){line.data, i}) <= room) {
            fits = i;
        }
        if (!end && (line.data[i] == '"' || line.data[i] == '\'')) {
            if (!quote)
                quote = line.data[i];
            else
                quote = quote == line.data[i] ? 0 : quote;
        }
    }
    return fits;
}

/* Shows the next command that a module suggests, which an empty Enter will execute: as many of its
 * statements as fit into a line; the others are kept for the next call. Shows nothing in quiet
 * mode, if the same suggestion was shown before, or with typed_ahead, when input is already
 * waiting. */
void offer_next(struct front_program *program, bool typed_ahead)
{
    struct buffer *offer = &program->offer;
    buffer_clear(offer);
    struct session *session = program->session;
    struct buffer *later = &program->later;
    program->withheld = program->taken;
    program->taken = false;
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->prompt.typed)
            module_list[i]->prompt.typed(session, program->reply);
    if (session->execution.quit || program->reply->quiet ||
        session->setup.settings.format != FORMAT_TEXT || program->withheld) {
        return;
    }
    bool is_found = later->len > 0;
    buffer_put(offer, buffer_text(later));
    for (size_t i = 0; module_list[i] && !is_found; i++)
        is_found = module_list[i]->prompt.next && module_list[i]->prompt.next(session, offer);
    buffer_clear(later);
    if (offer->len > 0 && text_is(buffer_text(offer), buffer_view(&program->passed))) {
        buffer_clear(offer); /* shown before, but something else was typed */
        program->withheld = true;
        return;
    }
    buffer_clear(&program->passed);
    buffer_put(&program->passed, buffer_text(offer));
    const int label = text_width(TEXT(OFFER_LABEL));
    const int width = session->front.width ? session->front.width : 80;
    const int room = typed_ahead ? 0 : width;
    size_t fits = fitting_statements(buffer_text(offer), room - label);
    if (fits == 0) /* a first statement longer than a line may take two */
        fits = fitting_statements(buffer_text(offer), 2 * room - label);
    if (fits > 0 && fits < offer->len) {
        const struct text whole = buffer_text(offer);
        buffer_put(later, text_trim(text_after(whole, fits + 1)));
    }
    if (fits == 0 || offer->failed || later->failed) {
        buffer_clear(offer);
        buffer_clear(&program->passed);
    } else {
        offer->len = fits;
        offer->data[fits] = '\0';
    }
    if (offer->len > 0) {
        reply_line(program->reply, OFFER_LABEL "%s", buffer_view(offer));
    }
}

void offer_again(struct front_program *program, bool typed_ahead)
{
    if (!program->withheld)
        return;
    buffer_clear(&program->passed);
    offer_next(program, typed_ahead);
}

/* Returns the line to execute: the suggestion if nothing was typed. Both lines are malloc()ed; the
 * one not returned is freed. */
char *offer_take(struct front_program *program, char *typed)
{
    struct buffer *offer = &program->offer;
    if (offer->len > 0 && text_trim(text_of(typed)).len == 0) {
        char *taken = strdup(buffer_view(offer));
        if (taken) {
            free(typed);
            typed = taken;
        }
        buffer_clear(&program->passed);
        program->taken = true;
    } else if (text_trim(text_of(typed)).len > 0) {
        buffer_clear(&program->later);
    }
    buffer_clear(offer);
    return typed;
}
