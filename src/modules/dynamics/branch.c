/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command branch: reads which solution is followed over which parameters, follows and verifies
 * the branch, and replies its special points. */
#ifndef COMMAND_ROWS
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/run/timing.h>
#include <hooke/report.h>
#include <hooke/scene/poles.h>
#include <hooke/session/names.h>
#include <hooke/language/grid.h>
#include "modules/dynamics/handlers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- reading NAME=FROM:TO … [of WHAT] [from LABEL] [max=N] [step=V] [--forward] ---- */

/* The arguments as they were read. */
struct branch_words {
    int params, param[2];   /* number and indices of the parameters that vary */
    double low[2], high[2]; /* SI; their ranges */
    /* kind and number of the solution behind `of`, and special point behind `from` */
    struct text origin, number, label;
    double max, step; /* as in struct branch_request */
    bool forward;
};

/* Returns true if the text begins with that word, and a blank or the end follows. */
static bool is_word(struct text text, const char *word)
{
    const size_t len = strlen(word);
    return text_starts(text, text_of(word)) && (text.len == len || strchr(" \t", text.data[len]));
}

/* Removes the first word from *rest and returns it. */
static struct text take_word(struct text *rest)
{
    size_t end = 0;
    *rest = text_trim(*rest);
    while (end < rest->len && !strchr(" \t", rest->data[end]))
        end++;
    const struct text word = {rest->data, end};
    *rest = text_trim((struct text){rest->data + end, rest->len - end});
    return word;
}

/* Takes the argument up to the next NAME=, --option, "of" or "from" off *rest. */
static struct text take_argument(struct text *rest)
{
    struct text all = *rest, argument = next_key_argument(&all);
    for (size_t i = 1; i < argument.len; i++) {
        const struct text remaining = {argument.data + i, argument.len - i};
        if (strchr(" \t", argument.data[i - 1]) &&
            (is_word(remaining, "of") || is_word(remaining, "from")))
            argument.len = i;
    }
    *rest = text_trim((struct text){rest->data + argument.len, rest->len - argument.len});
    return text_trim(argument);
}

/* Reads NAME=FROM:TO of a parameter, with both ends, and appends it to words->param, low and high
 * (SI). `argument` is all of it, `name` its part before the equals sign. Returns false with *error,
 * such as for a third parameter. */
static bool read_range(struct session *session, const struct arguments *args, struct text argument,
                       struct text name, struct branch_words *words, struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    struct parser parser = {session, args->scope, args->arena, argument};
    struct item item = {0};
    const int param = scene_param_at(scene, name);
    if (param < 0)
        return unknown_parameter(session, name, TEXT(""), error);
    if (words->params == 2)
        return error_at(error, argument, "a branch has one or two parameters");
    for (int j = 0; j < words->params; j++)
        if (words->param[j] == param)
            return error_at(error, name, "'%.*s' is given twice", (int)name.len, name.data);
    take_equals(&parser, argument, name);
    const struct param_row *row = param_at(scene, param);
    if (!parse_range(&parser, row->row.name, row->quantity, &item, error) ||
        !refuse_rest(&parser, NULL, error))
        return false;
    if (!(item.range[0] < item.range[1]))
        return error_at(error, argument, "%s needs a range with both ends, as in %s=0:10",
                        row->row.name, row->row.name);
    const int j = words->params++;
    words->param[j] = param;
    words->low[j] = item.range[0];
    words->high[j] = item.range[1];
    return true;
}

/* Reads NAME=NUMBER, a number without unit above 0 and at most `most`, into *number. `argument` is
 * all of it, `name` its part before the equals sign. Returns false with *error. */
static bool read_number(struct session *session, const struct arguments *args, struct text argument,
                        struct text name, double most, double *number, struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, argument};
    struct item item = {0};
    char what[8];
    snprintf(what, sizeof what, "%.*s", (int)name.len, name.data);
    take_equals(&parser, argument, name);
    if (!read_value(&parser, what, QUANTITY_NUMBER, &item, error))
        return false;
    *number = item.value.value;
    return (*number > 0 && *number <= most) ||
           error_at(error, argument, "%s is more than 0 and at most %g", what, most);
}

/* Reads "of equilibrium N", "of orbit N" or "of response", where N may be missing. Returns false
 * with *error. */
static bool read_of(struct text *rest, struct branch_words *words, struct error *error)
{
    take_word(rest);
    words->origin = take_word(rest);
    if (rest->len > 0 && rest->data[0] >= '0' && rest->data[0] <= '9')
        words->number = take_word(rest);
    return text_is(words->origin, "equilibrium") || text_is(words->origin, "orbit") ||
           text_is(words->origin, "response") ||
           error_at(error, words->origin,
                    "a branch follows 'of equilibrium N', 'of orbit N' or 'of response'");
}

/* Reads the arguments of `branch` into *words: ranges NAME=FROM:TO of one or two parameters, `of`
 * and `from` a starting solution, max=, step= and --forward. --full is accepted, since it concerns
 * only the reply. Returns false with *error if anything is malformed or no parameter is given. */
static bool read_branch_words(struct session *session, const struct arguments *args,
                              struct branch_words *words, struct error *error)
{
    struct text rest = text_trim(argument_value(args, "NAME=FROM:TO")->item->text);
    while (rest.len > 0) {
        if (is_word(rest, "of")) {
            if (!read_of(&rest, words, error))
                return false;
            continue;
        }
        if (is_word(rest, "from")) {
            take_word(&rest);
            words->label = take_word(&rest);
            if (words->label.len == 0)
                return error_set(error, ERROR_COMMAND,
                                 "name a point after 'from'; 'list points' shows the labels");
            continue;
        }
        const struct text argument = take_argument(&rest), name = peek_name(argument),
                          remaining = text_trim(text_after(argument, name.len));
        if (text_is(argument, "--forward")) {
            words->forward = true;
            continue;
        }
        if (text_is(argument, "--full"))
            continue;
        if (text_starts(argument, TEXT("--")))
            return error_at(error, argument, "branch has no option '%.*s'",
                            (int)(argument.len < 64 ? argument.len - 2 : 62), argument.data + 2);
        if (name.len == 0 || !text_starts(remaining, TEXT("="))) {
            error_at(error, argument, "branch takes NAME=FROM:TO");
            return error_hint(error, "for example: branch r=0:30 of equilibrium 1, then branch "
                                     "r=0:30 from HB1");
        }
        bool ok;
        if (text_is(name, "max"))
            ok =
                read_number(session, args, argument, name, LIMIT_BRANCH_POINTS, &words->max, error);
        else if (text_is(name, "step"))
            ok = read_number(session, args, argument, name, 0.5, &words->step, error);
        else
            ok = read_range(session, args, argument, name, words, error);
        if (!ok)
            return false;
    }
    return words->params > 0 ||
           error_set(error, ERROR_COMMAND, "branch needs a parameter, as in branch r=0:30");
}

/* ---- the start of the branch ---- */

/* Returns the number that was typed behind `orbit` or `equilibrium`, in *item, or NULL if none
 * was. */
static const struct item *number_item(const struct branch_words *words, struct item *item)
{
    *item = (struct item){.text = words->number};
    return words->number.len > 0 && real_parse(words->number, &item->value.value) == REAL_OK ? item
                                                                                             : NULL;
}

/* Finds the periodic response to the drive that the motion settles on. Returns false with
 * *error. */
static bool find_response(struct session *session, struct stored_solution *found,
                          struct error *error)
{
    struct orbit_request request = {.scene = &session->setup.scene,
                                    .settles = true,
                                    .cancel = session->front.cancel,
                                    .progress = report_fraction,
                                    .context = &session->front};
    struct found_orbit orbit;
    struct system system;
    if (!scene_bind_motion(&session->setup.scene, &system, error))
        return false;
    if (system.n > DYNAMICS_VARIABLES)
        return error_set(error, ERROR_COMMAND, "responses can be followed for at most %d variables",
                         DYNAMICS_VARIABLES);
    orbit_begin(session, &system, &request);
    if (system_drive(&system) == 0)
        return error_set(error, ERROR_COMMAND, "a response needs a drive, and this scene has none");
    const bool fine = orbit_find(&request, &orbit, error);
    report_fraction(&session->front, 2);
    found->solution = orbit.solution;
    found->scene = session->setup.scene;
    orbit_free(&orbit);
    return fine;
}

/* Takes the first stored equilibrium. Returns false with *error and a hint if there is none. */
static bool find_first_equilibrium(struct session *session, struct stored_solution *found,
                                   struct error *error)
{
    const struct dynamics *d = session_dynamics(session);
    struct item first = {.value = {1, 0}};
    if (d && d->equilibria.count > 0)
        return find_equilibrium(session, d, &first, found, error);
    error_set(error, ERROR_COMMAND, "no equilibrium is known yet, so there is nothing to follow");
    return error_hint(error, "type: equilibria, or say 'of orbit' or 'of response'");
}

/* Finds the solution at which the branch begins, and writes its name (such as "HB1") to origin
 * [LIMIT_NAME + 1]. Without "of" or "from" it is equilibrium 1, or the last orbit if there are
 * orbits but no equilibria. Returns false with *error. */
static bool find_start(struct session *session, const struct branch_words *words,
                       struct stored_solution *found, char *origin, struct error *error)
{
    const struct dynamics *d = session_dynamics(session);
    struct item item;
    const struct item *number = number_item(words, &item);
    snprintf(origin, LIMIT_NAME + 1, "%.*s", (int)words->origin.len, words->origin.data);
    if (words->number.len > 0)
        snprintf(origin + words->origin.len, LIMIT_NAME + 1 - words->origin.len, " %.*s",
                 (int)fmin((double)words->number.len, 9), words->number.data);
    if (words->label.len > 0) {
        snprintf(origin, LIMIT_NAME + 1, "%.*s", (int)fmin((double)words->label.len, 15),
                 words->label.data);
        return find_label(session, d, words->label, found, error);
    }
    if (text_is(words->origin, "response"))
        return find_response(session, found, error);
    if (text_is(words->origin, "orbit"))
        return find_orbit(session, d, number, found, error);
    if (words->origin.len == 0) {
        const bool rests = (d && d->equilibria.count > 0) || !d || d->orbits == 0;
        snprintf(origin, LIMIT_NAME + 1, "%s", rests ? "equilibrium 1" : "orbit");
        return rests ? find_first_equilibrium(session, found, error)
                     : find_orbit(session, d, NULL, found, error);
    }
    return number ? find_equilibrium(session, d, number, found, error)
                  : find_first_equilibrium(session, found, error);
}

/* Binds the scene at the stored solution: the scene's own start may lie where it has no
 * derivatives, and is not needed. */
static bool bind_start(struct stored_solution *start, struct error *error)
{
    struct system system;
    double box[LIMIT_VARIABLES][2];
    for (int i = 0; i < start->scene.model->n; i++)
        box[i][0] = box[i][1] = start->solution.state[i];
    return scene_bind_inside(&start->scene, box, &system, error);
}

/* ---- text, records and table ---- */

/* Returns the longest step in the direction of the parameter; special points closer to each other
 * than that may be missed. */
static double longest_step(const struct branch *branch)
{
    double longest = 0;
    for (int i = 1; i < branch->count; i++)
        longest = fmax(longest, fabs(branch->point[i].solution.param[0] -
                                     branch->point[i - 1].solution.param[0]));
    return longest;
}

/* Appends the answer: number, extent and ends of the branch with the reasons for them, its special
 * points, effort, and the longest step, since it may miss special points. */
static void put_branch(const struct session *session, const struct stored_branch *b,
                       struct arena *arena, struct buffer *output)
{
    const struct branch *branch = &b->branch;
    const struct param_row *row = param_at(&session->setup.scene, b->param[0]);
    static const char *const kinds[] = {[SOLUTION_EQUILIBRIUM] = "equilibria",
                                        [SOLUTION_ORBIT] = "orbits",
                                        [SOLUTION_RESPONSE] = "responses"};
    int stable = 0;
    for (int i = 0; i < branch->count; i++)
        stable += solution_stable(&branch->point[i].solution);
    buffer_format(output, "branch %d: %d ", b->number, branch->count);
    if (b->params == 2)
        buffer_format(output, "special points like %s", b->origin);
    else
        buffer_format(output, "%s, %d of them stable", kinds[branch->kind], stable);
    buffer_format(output, ", %s", row->row.name);
    for (int side = 0; side < 2; side++) {
        const struct branch_point *end = &branch->point[side ? branch->count - 1 : 0];
        const char *reason = branch->ends[side][0] ? branch->ends[side] : "the start";
        buffer_format(output, " %s %s (%s)", side ? "to" : "from",
                      SHOWN_QUANTITY(end->solution.param[0], row->quantity, 8), reason);
    }
    buffer_char(output, '\n');
    put_points(session, &b, 1, arena, output);
    buffer_format(output, "%lld evaluations", (long long)branch->evals);
    put_seconds(output, session, branch->seconds);
    if (branch->count > 1)
        buffer_format(output,
                      ", steps of %s up to %s (special points closer than that may be missed)",
                      row->row.name, SHOWN_QUANTITY(longest_step(branch), row->quantity, 2));
    buffer_put(output, TEXT("; all points: 'export FILE table'"));
}

/* Adds the columns stability and label to the table of a branch. */
static void add_stability_and_labels(struct table_builder *table, const struct stored_branch *b)
{
    const char **stable = table_add_texts(table, "stability"),
               **label = table_add_texts(table, "label");
    for (size_t i = 0; !table->failed && i < table->rows; i++) {
        stable[i] = solution_stable(&b->branch.point[i].solution) ? "stable" : "unstable";
        label[i] = "";
    }
    for (int k = 0; !table->failed && k < b->specials; k++) {
        char text[POINT_LABEL_SIZE];
        stored_point_label(&b->special[k], text);
        const char *copy = arena_text(&table->arena, text_of(text));
        label[b->special[k].index] = copy ? copy : "";
    }
}

/* Stores the branch as a table with a row for each point: parameters, extrema of the states,
 * period, stability, label. */
static void store_branch_table(const struct session *session, const struct stored_branch *b,
                               struct reply *reply)
{
    const struct scene *scene = &session->setup.scene;
    const struct branch *branch = &b->branch;
    struct table_builder table = {.rows = (size_t)branch->count};
    const struct system system = {.model = scene->model, .n = scene->model->n};
    for (int j = 0; j < b->params; j++) {
        const struct param_row *row = param_at(scene, b->param[j]);
        double *value = table_add_reals(&table, row->row.name, "", row->quantity);
        for (int i = 0; value && i < branch->count; i++)
            value[i] = branch->point[i].solution.param[j];
    }
    const bool rests = branch->kind == SOLUTION_EQUILIBRIUM;
    for (int k = 0; k < system.n; k++) {
        const struct variable variable = system_variable(&system, k);
        double *low =
            table_add_reals(&table, variable.name, rests ? "" : "_min", variable.quantity);
        double *high =
            rests ? NULL : table_add_reals(&table, variable.name, "_max", variable.quantity);
        for (int i = 0; low && i < branch->count; i++)
            low[i] =
                rests ? branch->point[i].solution.state[k] : branch->point[i].solution.bottom[k];
        for (int i = 0; high && i < branch->count; i++)
            high[i] = branch->point[i].solution.top[k];
    }
    double *period = rests ? NULL : table_add_reals(&table, "period", "", QUANTITY_TIME);
    for (int i = 0; period && i < branch->count; i++)
        period[i] = branch->point[i].solution.period;
    add_stability_and_labels(&table, b);
    table_finish(&table, reply, "branch");
}

/* Adds the records of the special points and of the branch. */
static void reply_branch(const struct session *session, const struct stored_branch *b,
                         struct reply *reply)
{
    reply_points(session, b, reply);
    reply_begin(reply, "branch");
    reply_int(reply, "branch", b->number);
    reply_string(reply, "of", b->origin);
    reply_int(reply, "rows", b->branch.count);
    reply_real(reply, "from", b->branch.point[0].solution.param[0]);
    reply_real(reply, "to", b->branch.point[b->branch.count - 1].solution.param[0]);
    reply_real(reply, "step_max", longest_step(&b->branch));
    reply_int(reply, "evals", b->branch.evals);
    const bool timed = session->setup.settings.timing != TIMING_OFF;
    reply_real(reply, "time", timed ? b->branch.seconds : NAN);
    reply_end(reply);
}

/* Follows a branch, compares its special points with runs, stores it and replies it. A branch that
 * was stopped is stored as far as it goes. */
HANDLER(branch)
{
    struct branch_words words = {.params = 0};
    struct stored_solution start = {.scene = session->setup.scene};
    struct stored_branch like = {.params = 1};
    if (!read_branch_words(session, args, &words, error) ||
        !find_start(session, &words, &start, like.origin, error) || !bind_start(&start, error))
        return false;
    const bool two = words.params == 2;
    if (two && !start.point)
        return error_set(
            error, ERROR_COMMAND,
            "a branch in two parameters must start from a special point, as in branch P=.. "
            "Q=.. from LP1");
    const struct branch_axis second = {words.param[1], words.low[1], words.high[1]};
    struct solution solution = start.solution;
    solution.param[0] = start.scene.value[words.param[0]];
    if (two)
        solution.param[1] = start.scene.value[words.param[1]];
    if (!(solution.param[0] >= words.low[0] && solution.param[0] <= words.high[0]))
        return error_set(error, ERROR_COMMAND, "the branch begins at %s = %.6g, outside this range",
                         param_at(&start.scene, words.param[0])->row.name, solution.param[0]);
    struct branch_point point = {.special = SPECIAL_NONE};
    if (start.point) {
        point = *stored_point_at(start.branch, start.point);
        point.solution = solution;
    }
    /* an end is a place on its branch like any other */
    const bool leave = start.point && point.special != SPECIAL_END;
    const struct branch_axis *axis = two ? &second : NULL;
    const struct branch_request request = {.scene = &start.scene,
                                           .param = words.param[0],
                                           .low = words.low[0],
                                           .high = words.high[0],
                                           .start = &solution,
                                           .leave = leave ? &point : NULL,
                                           .second = axis,
                                           .step = words.step,
                                           .max = (int)words.max,
                                           .forward = words.forward,
                                           .cancel = session->front.cancel,
                                           .progress = report_fraction,
                                           .context = &session->front};
    const bool followed = branch_follow(&request, &like.branch, error);
    if (followed && !like.branch.cancelled)
        branch_verify(&request, &like.branch);
    report_fraction(&session->front, 2);
    if (!followed)
        return false;
    const bool stopped = like.branch.cancelled || cancelled(session->front.cancel);
    for (int j = 0; j < words.params; j++) {
        like.param[j] = words.param[j];
        like.low[j] = words.low[j];
        like.high[j] = words.high[j];
    }
    like.params = words.params;
    const struct stored_branch *stored =
        like.branch.count > 0 ? dynamics_store_branch(session, &like, start.scene.value, error)
                              : NULL;
    if (!stored)
        return error->text[0] ? false : error_set(error, ERROR_CANCELLED, "cancelled");
    put_branch(session, stored, args->arena, reply_buffer(reply));
    reply_own_solver(
        session, stored->branch.kind == SOLUTION_EQUILIBRIUM ? NEWTON_SOLVER : FLOW_SOLVER, reply);
    reply_branch(session, stored, reply);
    store_branch_table(session, stored, reply);
    return !stopped ||
           error_set(error, ERROR_CANCELLED, "cancelled; the points found so far are kept");
}
#endif

COMMAND(branch, .group = "DYNAMICS", .flags = COMMAND_TABLES, .completes = COMPLETES_GRID,
        ARGUMENTS(PLACE("NAME=FROM:TO", TYPE_REST, .flags = ARG_REQUIRED,
                        .more = "[NAME=FROM:TO] [of equilibrium [N]|of orbit [N]|of response] "
                                "[from LABEL]"),
                  KEY("max", TYPE_INTEGER), KEY("step", TYPE_VALUE), OPTION("forward", TYPE_NONE),
                  OPTION("full", TYPE_NONE)))
