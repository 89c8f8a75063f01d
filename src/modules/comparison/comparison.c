/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module comparison: its row, the part that it keeps in a session, and functions that several
 * of its commands share. */
#include <hooke/base/statement.h>
#include <hooke/command/complete.h>
#include <hooke/plot.h>
#include "modules/comparison/comparison.h"

#include <hooke/base/safe_text.h>

#include <stdlib.h>
#include <string.h>

struct references *session_references(const struct session *session)
{
    struct comparison_part *part = session_part(session, &comparison_module);
    return part ? &part->references : NULL;
}

const struct precision *session_precision(const struct session *session)
{
    const struct comparison_part *part = session_part_if_made(session, &comparison_module);
    return part ? part->precision : NULL;
}

/* Fills choice [*count] with the methods that the statement names, or keeps those in it if none is
 * named. Each named one gets the drag variant `usual` if it has that, otherwise its own. drag=
 * replaces the variants: one value for all methods that know it, and for a single method in any
 * case, or one value for each method. Returns false with an error if the numbers differ. */
bool choose_methods(const struct arguments *args, enum drag usual, struct method_choice *choice,
                    int *count, struct error *error)
{
    const struct argument_value *methods = argument_value(args, "METHOD"),
                                *drag = argument_value(args, "drag");
    for (int i = 0; i < methods->count; i++) {
        const struct method *method = method_from(methods->item[i].row);
        choice[i] =
            (struct method_choice){method, method->drags & (1u << usual) ? usual : DRAG_DEFAULT};
    }
    *count = methods->count ? methods->count : *count;
    if (drag->count > 1 && drag->count != *count)
        return error_at(error, drag->where,
                        "drag= needs one variant for all methods, or one for each");
    for (int i = 0; i < *count && drag->count; i++) {
        const enum drag wanted = (enum drag)(drag->item[drag->count > 1 ? i : 0].index + 1);
        if (*count == 1 || drag->count > 1 || choice[i].method->drags & (1u << wanted))
            choice[i].drag = wanted;
    }
    return true;
}

/* Makes the list of methods of a plot from rows of the catalog, or from the session's method. */
struct method_choice *methods_choice(const struct session *session, const struct row *const *method,
                                     int *count, struct arena *arena)
{
    struct method_choice *choice = arena_array(arena, (size_t)*count + 1, sizeof *choice);
    for (int i = 0; choice && i < *count; i++)
        choice[i] = (struct method_choice){method_from(method[i]), DRAG_DEFAULT};
    if (choice && *count == 0)
        choice[(*count)++] = (struct method_choice){session->setup.method, session->setup.drag};
    return choice;
}

/* Drops methods that are named twice with the same drag. Returns how many are left. */
int drop_repeated(struct method_choice *choice, int count, struct reply *reply)
{
    int left = 0;
    for (int i = 0; i < count; i++) {
        bool repeated = false;
        for (int k = 0; k < left; k++)
            repeated |= choice[k].method == choice[i].method && choice[k].drag == choice[i].drag;
        if (repeated)
            reply_note(reply, "%s is named twice and used once; dt=10ms,5ms compares steps",
                       choice[i].method->row.name);
        else
            choice[left++] = choice[i];
    }
    return left;
}

/* Frees what the part of a session points to. */
static void free_part(void *state)
{
    struct comparison_part *part = state;
    if (part->precision)
        precision_free(part->precision);
    free(part->precision);
    references_free(&part->references);
}

/* Returns true if a stored study or reference belongs to a scene with this typed model, which then
 * must not be freed. */
static bool part_uses(const void *state, const struct model *model)
{
    const struct comparison_part *part = state;
    bool uses = part->precision && scene_uses(&part->precision->scene, model);
    for (int i = 0; i < REFERENCES_STORED && !uses; i++)
        uses = scene_uses(&part->references.stored[i].scene, model);
    return uses;
}

/* Tells `plan` that the reference of the present scene is stored, so that the next study need not
 * compute it. */
static void comparison_plan(const struct session *session, struct buffer *text)
{
    struct comparison_part *part = session_part_if_made(session, &comparison_module);
    const struct setup *setup = &session->setup;
    const struct reference *known =
        part ? references_find(&part->references, &setup->scene, setup->settings.duration) : NULL;
    if (!known || known->exact)
        return;
    buffer_put(text, TEXT("reference "));
    reference_describe(known, text);
    buffer_put(text, TEXT(": reference solution, shared by precision, compare and order\n"));
}

/* Offers methods as completions behind the name of a plot that makes a study, as in `plot order`;
 * `preceding` is the line between the command's name and the word at the cursor. Returns false, so
 * that others complete, for other plots or commands, and if an option or a file was begun. */
static bool complete_study_methods(struct completion *c, const struct command *command,
                                   struct text preceding)
{
    text_skip_blanks(&preceding);
    const struct row *plot = catalog_find(&plot_catalog, peek_name(preceding));
    const bool draws =
        strcmp(command->row.name, "plot") == 0 || strcmp(command->row.name, "describe") == 0;
    struct text key;
    if (!draws || !plot || !plot_row((enum plot_kind)catalog_index(&plot_catalog, plot))->study ||
        text_starts(c->word, TEXT("-")) || text_is(last_word(preceding), ">") ||
        complete_is_item(preceding, &key))
        return false;
    complete_catalog(c, &method_catalog);
    return true;
}

const struct module comparison_module = {
    .row = {"comparison", "", "methods compared: error, run time, order, stability", "", NULL},
    .needs = "solving",
    .part_size = sizeof(struct comparison_part),
    .part_free = free_part,
    .part_uses = part_uses,
    .plan = comparison_plan,
    .complete = complete_study_methods,
};
