/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The program hooke: reads the options of the command line, chooses a front end (batch, prompt or
 * panes) and runs one session in it. */
#include "terminal/parts.h"

#include <hooke/base/cancel.h>
#include <hooke/module.h>
#include <hooke/session/log.h>

#include <langinfo.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Sets the setting of the same name as an option (--charset, --color, --format); a NULL value
 * leaves it unchanged. Returns false after an error message if the value is not one of its
 * words. */
static bool option_setting(struct session *session, const char *name, const char *value)
{
    if (!value) {
        return true;
    }
    const struct setting *setting = setting_by_name(text_of(name));
    const struct row *choice = catalog_find(setting->choices, text_of(value));
    if (!choice) {
        struct error error = {0};
        catalog_unknown(setting->choices, text_of(value), &error);
        fprintf(stderr, "hooke: error: --%s: %s%s%s\n", name, error.text, *error.hint ? "; " : "",
                error.hint);
        return false;
    }
    for (size_t i = 0; i < setting->choices->count; i++) {
        if (catalog_row(setting->choices, i) == choice) {
            *(int *)(void *)((char *)&session->setup.settings + setting->offset) = (int)i;
        }
    }
    return true;
}

/* Returns true if standard input is not read for commands, so that a command may read data there:
 * in batch with tasks, none of which is "-", unless an option of a module does all. */
static bool input_is_free(const struct options *options, enum front_kind kind)
{
    bool is_free = kind == FRONT_NONE && options->tasks > 0 && !options->only;
    for (int i = 0; i < options->tasks; i++)
        is_free = is_free && strcmp(options->task[i].text, "-") != 0;
    return is_free;
}

/* Chooses the front end before anything is printed: FRONT_NONE (batch) without a terminal, with
 * tasks, or with an option of a module that is all the program does (options->only), else panes if
 * the terminal can show them, else the plain prompt. */
static enum front_kind choose_front(const struct options *options)
{
    struct error error = {0};
    const bool terminal = isatty(STDIN_FILENO) && isatty(STDOUT_FILENO);
    if (options->batch || options->only || !terminal ||
        (options->tasks > 0 && !options->interactive)) {
        return FRONT_NONE;
    }
    front_load_locale();
    describe_terminal();
    if (options->plain) {
        return FRONT_IS_PLAIN;
    }
    if (panes_possible(&error)) {
        return FRONT_IS_PANES;
    }
    fprintf(stderr, "hooke: no panes: %s\n", error.text);
    return FRONT_IS_PLAIN;
}

/* Writes the session to its file when the program crashes or memory runs out. */
static void save_without_memory(void)
{
    struct error error;
    if (session_keeper())
        session_keeper()->write(&error);
}

/* Writes the session a last time; errors go to standard error, where they remain readable after
 * panes. */
static void keep_at_end(const struct session_keeper *keeper)
{
    struct error error;
    if (!keeper->write(&error))
        fprintf(stderr, "hooke: warning: %s\n", error.text);
    keeper->end();
}

/* Runs the front end `kind`, and then others as long as the commands `plain` and `panes` switch to
 * them (program->next). */
static void prompts_run(struct front_program *program, enum front_kind kind)
{
    const struct session_keeper *keeper = session_keeper();
    if (keeper)
        keeper->begin(program->session);
    crash_last_act(save_without_memory);
    for (program->next = kind;
         program->next != FRONT_NONE && !program->session->execution.quit && !signals_ending();) {
        if (program->next == FRONT_IS_PANES) {
            panes_run(program);
        } else {
            prompt_run(program);
        }
    }
    crash_last_act(NULL);
    if (keeper)
        keep_at_end(keeper);
}

/* Prints the lines of the log, oldest first, to standard output. */
static void print_log(const struct session *session, struct streams *streams)
{
    for (int i = session->log.count - 1; i >= 0; i--) {
        buffer_put(&streams->output, text_of(log_line(&session->log, i)));
        buffer_char(&streams->output, '\n');
    }
}

/* Resumes a stored session if an option asks for it (*session is then another one), and applies
 * options that are settings. Returns false after an error message. */
static bool begin_session(struct session **session, const struct options *options,
                          struct buffer *messages)
{
    struct error error = {0};
    if (options->resume &&
        !session_keeper()->resume(session, options->resume_name, messages, &error)) {
        fprintf(stderr, "hooke: error: %s%s%s; nothing was restored\n", error.text,
                *error.hint ? "; " : "", error.hint);
        return false;
    }
    return option_setting(*session, "charset", options->charset) &&
           option_setting(*session, "color", options->color) &&
           option_setting(*session, "format", options->format);
}

/* Runs the option of a module that the user gave (options->only), such as one that checks a
 * hand-in. The command line may otherwise contain only its arguments: options->first and the tasks
 * of kind TASK_FILE, in order. Returns the exit status; ERROR_USAGE, after a message, if there is
 * no argument or another task. */
static int run_option(struct session *session, const struct options *options, struct reply *reply)
{
    const char **word = malloc(((size_t)options->tasks + 1) * sizeof *word);
    int count = 0, status = ERROR_USAGE, others = 0;
    if (word && options->first)
        word[count++] = options->first;
    for (int i = 0; word && i < options->tasks; i++) {
        if (options->task[i].kind == TASK_FILE)
            word[count++] = options->task[i].text;
        else
            others++;
    }
    if (count == 0 || others > 0) {
        reply_note(reply, "hooke: error: --%s takes only %s", options->only->word,
                   options->only->wants);
    } else {
        status = options->only->run(session, word, count, reply);
    }
    free(word);
    return status;
}

/* Runs what the command line gives, without a prompt: either the option of a module
 * (options->only), with the words behind it as its arguments, or else the files and commands, and
 * standard input if there are none and no prompt follows. Sets session->execution.status, from
 * which the exit status of the program is made. */
static void tasks_run(struct session *session, const struct options *options, enum front_kind kind,
                      struct reply *reply, struct streams *streams)
{
    if (!options->only) {
        strays_sweep_path("."); /* files of killed programs */
    }
    if (options->only) {
        session->execution.status = run_option(session, options, reply);
    } else {
        batch_run(session, options, kind == FRONT_NONE && options->tasks == 0, reply, streams);
    }
}

/* Confines writing for --safe, after all files are open, to the current folder and, with a prompt,
 * to the folder with the states of sessions. */
static void confine(const struct options *options, bool prompt, struct reply *reply)
{
    struct error error = {0};
    if (!options->safe)
        return;
    char *state = prompt ? state_path("", true) : NULL;
    const char *const folders[] = {".", state};
    if (!confine_writing(folders, (int)COUNT_OF(folders), &error) && options->verbose)
        reply_note(reply, "note: --safe is enforced by hooke only, not by the system: %s",
                   error.text);
    free(state);
}

/* Runs the program after its options were read: creates the session, applies the options, runs the
 * rc file, the tasks of the command line and, unless the program is a batch, the prompt or the
 * panes until the user quits; then closes all files. Returns the exit status of the program. */
static int session_front_run(const struct options *options)
{
    const enum front_kind kind = choose_front(options);
    struct streams streams = {0};
    struct front front = {.cancel = &interrupt,
                          .input = input_is_free(options, kind),
                          .progress = isatty(STDERR_FILENO) ? progress_print : NULL};
    front_probe(&front, options, STDOUT_FILENO);
    screenshot_offer(&front);
    terminal_offer(&front, &streams);
    struct session *session = session_create(&front);
    if (!session) {
        fputs("hooke: error: out of memory\n", stderr);
        return ERROR_COMMAND;
    }
    session->options.keep_going = options->keep_going;
    session->options.safe = options->safe;
    session->options.verbose = options->verbose;
    struct reply reply;
    reply_init(&reply, streams_sink(&streams));
    reply.quiet = options->quiet;
    struct split split = {.open = false};
    struct error error = {0};
    bool ready = true;
    if (options->split) {
        ready = kind == FRONT_NONE
                    ? split_begin(&split, options->split, options->safe, &error)
                    : error_set(&error, ERROR_USAGE, "--split cannot be used with a prompt");
        streams.split = &split;
        reply.part = split_part;
    }

    int status = ERROR_USAGE;
    struct buffer messages = {0};
    if (ready && begin_session(&session, options, &messages)) {
        session->front.context = session; /* shows progress; other front ends set their own */
        streams.log = &session->log;
        if (kind == FRONT_IS_PANES) {
            reply.sink = panes_sink(session); /* messages appear in the log from here on */
        }
        if (messages.len > 0) {
            reply_note(&reply, "%s", messages.data);
        }
        confine(options, kind != FRONT_NONE, &reply);
        if (!options->norc && (kind != FRONT_NONE || options->rc)) {
            rc_run(session, &reply);
            /* a mistake in the rc file has been told; it does not make this run a failure */
            session->execution.status = 0;
        }
        tasks_run(session, options, kind, &reply, &streams);
        /* errors of lines typed at the prompt were shown there and do not change the status */
        status = session->execution.status;
        if (kind != FRONT_NONE && !session->execution.quit && !signals_ending()) {
            /* `withheld` delays the first suggestion until an empty line asks for one. */
            struct front_program program = {.session = session,
                                            .options = options,
                                            .streams = &streams,
                                            .reply = &reply,
                                            .withheld = true};
            prompts_run(&program, kind);
            buffer_free(&program.offer);
            buffer_free(&program.later);
            buffer_free(&program.passed);
        } else if (kind == FRONT_IS_PANES) {
            print_log(session, &streams); /* a file left before the panes came */
        }
    }
    buffer_free(&messages);
    if (!ready || !split_end(&split, &error)) {
        fprintf(stderr, "hooke: error: %s%s%s\n", error.text, *error.hint ? "; " : "", error.hint);
        status = ready ? ERROR_IO : ERROR_USAGE;
    }
    if (session && !record_close(session, &error)) {
        fprintf(stderr, "hooke: error: %s\n", error.text);
        status = ERROR_IO;
    }
    bool written = streams_flush(&streams);
    if (!written) {
        fprintf(stderr, "hooke: error: cannot write standard output: %s\n",
                strerror(streams.failure));
        status = ERROR_IO;
    }
    if (signals_ending()) {
        status = 128 + signals_ending();
    } else if (kind == FRONT_NONE && cancelled(&interrupt)) {
        status = ERROR_CANCELLED;
    }
    reply_free(&reply);
    session_destroy(session);
    streams_free(&streams);
    return status;
}

/* Runs the program: prints help or version, or hands over to the session's front end. Returns the
 * exit status, ERROR_USAGE if the command line is not understood. */
int main(int argc, char **argv)
{
    streams_reserve();
    signals_install();
    struct options options;
    int status = ERROR_USAGE;
    if (options_read(&options, argc, argv)) {
        struct buffer text = {0};
        if (options.help) {
            options_help(&text);
        } else if (options.version) {
            buffer_put(&text, TEXT("hooke " HOOKE_VERSION "\n"));
            modules_put(&text);
            confine_say(&text);
        }
        if (options.help || options.version) {
            status = fputs(buffer_view(&text), stdout) < 0 || fflush(stdout) ? ERROR_IO : 0;
        } else {
            status = session_front_run(&options);
        }
        buffer_free(&text);
    }
    options_free(&options);
    return status;
}
