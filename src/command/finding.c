/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What newcomers type, and what they mean by it. */
#include "command/finding.h"

#include <hooke/command.h>
#include <hooke/plot.h>

#include <string.h>
#include <strings.h>

/* ---- words that are no names here ---- */

#define MEANS(word, others, says)                                                                  \
    {                                                                                              \
        word, "", says, "", others                                                                 \
    }

static const struct row words[] = {
    MEANS("damping", "damp damped dissipation viscosity decay",
          "gamma is linear damping ('gamma = 0.2'), C quadratic drag, friction dry; 'fit drag' "
          "finds which, 'measure decay' how fast"),
    MEANS("resistance", "air-resistance airdrag",
          "'gamma = 0.2' is linear drag, 'C = 1' quadratic; 'scene drag'"),
    MEANS("freq", "frequencies omega_0 hertz", "'print f0', 'print omega0'; 'measure frequency'"),
    MEANS("oscillation", "oscillate oscillator vibration swing motion simulation",
          "'scene damped; run; plot position': 'help start'"),
    MEANS("table", "tables values csv columns results",
          "'export FILE.csv' writes the run, 'export FILE table' the last study's result"),
    MEANS("excel", "spreadsheet xlsx ods libreoffice",
          "'load FILE.xlsx' reads one ('help recording'), 'export FILE.csv' writes what it opens"),
    MEANS("picture", "image figure svg png pdf graphic",
          "'plot position > FILE.svg' writes a picture (.svg, .pdf, .png)"),
    MEANS("graph", "draw chart show-plot plots curve diagram",
          "'plot position', 'plot phase', 'plot energy': 'help plot'"),
    MEANS("open", "import read file txt upload",
          "'load FILE' reads a recording, 'source FILE' commands: 'help recording'"),
    MEANS("simulate", "integrate solve go calculate compute execute evolve",
          "'run' integrates the scene"),
    MEANS("begin", "initial start-values initial-conditions x0 position0",
          "the start of a run is y0 and v0: 'y0 = 5 cm; v0 = 0'"),
    MEANS("stop", "halt abort cancel interrupt", "'pause' or Ctrl-C stops a run that goes on"),
    MEANS("close", "bye logout leave end", "'quit' leaves"),
    MEANS("delete", "remove rm clear-runs erase",
          "'drop 1' forgets a run, 'drop all' all; 'undo' brings them back"),
    MEANS("fft", "fourier harmonics peaks",
          "'plot spectrum' draws it, 'measure spectrum' has its lines"),
    MEANS("tolerance", "accuracy rtol reltol abstol",
          "'tol = 1e-8', for methods that adapt; 'atol' for a variable"),
    MEANS("timestep", "time-step stepsize step-size delta interval", "'dt = 10 ms'"),
    MEANS("mass", "weight", "'m = 200 g'"),
    MEANS("stiffness", "spring-constant springconstant constant hooke",
          "'k = 15 N/m'; 'measure k' of a recording"),
    MEANS("time", "seconds", "'duration = 20 s', or 'run 20 s'"),
    MEANS("colour", "colours colors", "'set color'"),
    MEANS("E", "total-energy etot", "the energy of the run: 'print energy', 'plot energy'"),
    MEANS("dE/E0", "dE energy-drift conservation",
          "how far the energy balance is off: 'plot energy-error', 'measure drift'"),
    MEANS("T", "Tperiod",
          "the period: 'print T0' without damping, 'measure period' of what was run"),
    MEANS("solver", "solvers integrator integrators scheme schemes algorithm algorithms",
          "'method NAME' chooses it, 'list methods' has all: 'help methods'"),
    MEANS("best", "fastest which choose recommend",
          "'precision' finds the fastest method for an error: 'help methods'"),
    MEANS("model", "models preset presets system examples",
          "'scene NAME' chooses what moves, 'list scenes' has all"),
    MEANS("equation-of-motion", "eqn ode differential custom own",
          "'help equations': var, param, y'' = ..."),
    MEANS("chaos", "chaotic lyapunov poincare bifurcation portrait", "'help dynamics'"),
    MEANS("resonance", "frequency-response response",
          "'scene driven; sweep omega=6:12:0.1': 'help sweep'"),
    MEANS("uncertainty", "errorbar error-bars sigma deviation",
          "'m = 200.0 +- 0.1 g' states one; fits and 'measure' give theirs"),
    MEANS("sensor", "arduino labview recording-file measurement-file",
          "'load FILE' reads what it wrote: 'help recording'"),
    MEANS("tutorial", "manual docs guide demo intro example",
          "'help' has topics with lines that can be pasted"),
    MEANS("gui", "windows ui tui", "'panes' shows plots above the prompt: 'help screen'"),
    MEANS("script", "batch macro",
          "'hooke FILE.hk' or 'source FILE.hk' runs commands, 'record FILE.hk' writes them"),
    MEANS("handin", "hand-in submit protocol homework",
          "'report FOLDER' writes what the lab asks for"),
};
const struct catalog word_catalog = CATALOG("word", words);

/* ---- names that are known, elsewhere ---- */

#define SETS "'%1 = VALUE', before it, sets it"

/* What to type with a name of it; %1 stands for the name. */
static const struct use {
    const struct catalog *catalog;
    const char *use;
} uses[] = {
    {&method_catalog, "'method %1' chooses it"},
    {&preset_catalog, "'scene %1' chooses it"},
    {&plot_catalog, "'plot %1' draws it"},
    {&quantity_catalog, "'measure %1' measures it"},
    {&setting_catalog, SETS},
    {&list_catalog, "'list %1' shows them"},
    {&layout_catalog, "'layout %1' shows it"},
    {&observable_catalog, "'print %1' shows it, of a run"},
    {&command_catalog,
     "'%1' is a command: 'help %1'"}, /* the last: who is near a name wants that */
};

static void put_use(const char *use, struct text name, struct buffer *text)
{
    for (const char *at = use; *at; at++)
        if (at[0] == '%' && at[1] == '1') {
            buffer_put(text, name);
            at++;
        } else {
            buffer_char(text, *at);
        }
}

/* At most two, by the catalogs' order; not that which was to be chosen from. */
static bool put_uses(struct text name, const char *kind, bool guessed, struct buffer *text)
{
    int count = 0;
    for (size_t i = 0; i < COUNT_OF(uses) - guessed && count < 2; i++) {
        const struct row *row = catalog_find(uses[i].catalog, name);
        if (!row || text_starts(text_of(kind), text_of(uses[i].catalog->kind)))
            continue;
        buffer_put(text, count++ ? TEXT(", ") : TEXT(""));
        put_use(uses[i].use, text_of(row->name), text);
    }
    return count > 0;
}

/* Is it a setting, or a parameter of the scene? */
static void put_setting(const struct session *session, struct text name, struct buffer *text)
{
    if (catalog_find(&setting_catalog, name) ||
        catalog_find(scene_params(&session->setup.scene), name))
        put_use(SETS, name, text);
}

bool mentions(const char *where, struct text word)
{
    for (const char *at = where; at && *at; at++)
        if (strncasecmp(at, word.at, word.len) == 0)
            return true;
    return false;
}

/* Does a row say something about it? */
static bool is_mentioned(struct text word)
{
    for (size_t i = 0; i < COUNT_OF(uses); i++)
        for (size_t j = 0; j < uses[i].catalog->count; j++)
            if (mentions(catalog_row(uses[i].catalog, j)->brief, word))
                return true;
    return false;
}

/* The whole of what was typed there: dE/E0, symplectic-euler. */
static struct text whole_word(struct text statement, struct text where)
{
    size_t len = (size_t)(where.at - statement.at);
    while (len < statement.len && !memchr(" \t=,;()'\"", statement.at[len], 9))
        len++;
    return (struct text){where.at, len - (size_t)(where.at - statement.at)};
}

#define MEANINGS_SHOWN 3
#define USAGE_SHORT 48 /* [B] a line of usage that leaves room beside it */

/* How the word was typed. */
static enum argument_form form_of(struct text statement, struct text where)
{
    struct text rest = {where.at + where.len,
                        (size_t)(statement.at + statement.len - where.at) - where.len};
    text_skip_blanks(&rest);
    if (where.at - statement.at >= 2 && where.at[-1] == '-' && where.at[-2] == '-')
        return FORM_OPTION;
    return rest.len > 0 && rest.at[0] == '=' ? FORM_KEY : FORM_WORD;
}

/* What has this name elsewhere, what is meant by it, which commands take it; guessed: something was
 * suggested. */
static void put_meanings(const struct session *session, const struct command *command,
                         struct text statement, struct text where, const char *kind, bool guessed,
                         struct buffer *text)
{
    const struct text word = whole_word(statement, where), names[] = {word, where};
    for (size_t i = 0; kind && i < COUNT_OF(names) && text->len == 0; i++)
        if (names[i].len > 0 && !put_uses(names[i], kind, guessed, text)) {
            const struct row *row = catalog_find(&word_catalog, names[i]);
            buffer_put(text, row ? text_of(row->brief) : TEXT(""));
        }
    if (!command || where.at == statement.at)
        return;
    const enum argument_form form = form_of(statement, where);
    struct buffer takers = {0}, usage = {0};
    if (form == FORM_KEY && !kind) /* one of the other commands, or of the session */
        put_setting(session, where, text);
    if (put_takers(command, form == FORM_WORD ? word : where, form,
                   MEANINGS_SHOWN - (text->len > 0), &takers) &&
        (text->len == 0 || form != FORM_WORD)) {
        command_usage(command, &usage);
        if (form == FORM_WORD && usage.len < USAGE_SHORT)
            buffer_format(text, "usage: %s", buffer_view(&usage));
        buffer_format(text, "%s%s", text->len ? "; " : "", buffer_view(&takers));
    }
    buffer_free(&takers);
    buffer_free(&usage);
}

/* Is it a hint of its own, more than a guess or the line of usage? */
static bool advises(const char *hint)
{
    return strstr(hint, " is one of: ") ||
           (*hint && !strstr(hint, "did you mean") && !strstr(hint, "usage: ") &&
            !text_starts(text_of(hint), TEXT("'help' lists")));
}

void explain_unknown(const struct session *session, struct text statement, struct error *error)
{
    static const char unknown[] = "unknown ", absent[] = "there is no help on";
    const struct text says = text_of(error->text), where = error->where;
    const bool helping = text_starts(says, TEXT(absent));
    if (!where.at || where.at < statement.at || where.at > statement.at + statement.len ||
        error->code != ERROR_COMMAND)
        return;
    const char *kind = helping                            ? ""
                       : text_starts(says, TEXT(unknown)) ? error->text + sizeof unknown - 1
                                                          : NULL;
    struct buffer text = {0};
    text_skip_blanks(&statement);
    const struct command *command =
        command_at(helping || advises(error->hint)
                       ? NULL
                       : choose(session, &command_catalog, peek_word(statement, "")));
    put_meanings(session, command, statement, where, kind,
                 strstr(error->hint, "did you mean") != NULL, &text);
    if (text.len > 0) {
        error->hint[0] = '\0';
        error_hint(error, "%s", buffer_view(&text));
    } else if (kind && (!*error->hint || text_starts(text_of(error->hint), TEXT("'help' lists"))) &&
               where.len > 2 && is_mentioned(where)) {
        error_hint(error, "'apropos %.*s' finds where it is spoken of", (int)where.len, where.at);
    }
    buffer_free(&text);
}
