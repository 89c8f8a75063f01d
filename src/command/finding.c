/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What newcomers type, and what they mean by it. */
#include "command/finding.h"
#include "command/session/topics.h"

#include <hooke/command.h>
#include <hooke/plot.h>
#include <hooke/report.h>

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
    MEANS("harmonic", "harmonic-oscillator mass-spring shm sho spring-mass",
          "'scene spring' is one, 'scene damped' with damping"),
    MEANS("pendel", "simple mathematical simple-pendulum bob", "'scene pendulum'"),
    MEANS("table", "tables values csv columns results",
          "'export FILE.csv' writes the run, 'export FILE table' the last study's result"),
    MEANS("excel", "spreadsheet xlsx ods libreoffice",
          "'load FILE.xlsx' reads one ('help recording'), 'export FILE.csv' writes what it opens"),
    MEANS("picture", "image figure svg png pdf graphic term terminal savefig saveas print-plot",
          "'plot position > FILE.svg' writes a picture (.svg, .pdf, .png)"),
    MEANS("graph", "draw chart show-plot plots diagram plot3d splot replot refresh",
          "'plot position', 'plot phase', 'plot energy': 'help plot'"),
    MEANS("hold", "holdon subplot both",
          "'plot position run all' draws all runs in one plot, 'plot position run 1 2' these"),
    MEANS("legend", "key", "'plot position label=A,B' names the curves, label=\"\" none of them"),
    MEANS("xlim", "ylim xrange yrange axis axes xaxis yaxis limits scale",
          "'plot y x=0:5' and y=-5cm:5cm fix the axes of a plot, 'range x 0:5' those of a pane"),
    MEANS("grid", "gridlines", "'plot y --grid > FILE.svg' has lines at its ticks"),
    MEANS("xlabel", "ylabel title", "'plot y xlabel=TEXT ylabel=TEXT title=TEXT'"),
    MEANS("vs", "versus over against",
          "'plot COLUMN against COLUMN', as 'plot y against t'; a kind of plot stands alone: 'plot "
          "energy'"),
    MEANS("and", "plus", "each with a statement of its own: 'plot position; plot velocity'"),
    MEANS("curve", "curve-fit regression fitting polyfit lsqcurvefit curve_fit model-fit",
          "'fit damped' fits an oscillation, 'fit EXPR' any formula in t: 'help fit'"),
    MEANS("linear", "line straight linear-fit linear-regression slope polynomial linfit",
          "'fit a + b*t' is a straight line, 'fit damped' an oscillation"),
    MEANS("exp", "exponential gaussian gauss",
          "'fit a*exp(-t/b) b=1' is any formula in t, 'fit damped' an oscillation"),
    MEANS("collect", "acquire record-data datalogger zero-sensor",
          "'load FILE' reads what the sensor's program has recorded: 'help recording'"),
    MEANS("numpy", "math from using scipy pandas",
          "all functions are there: 'list functions'; 'load FILE' reads numbers"),
    MEANS("e", "euler-number", "'exp(1)' is Euler's number, 'print energy' the energy"),
    MEANS("disp", "printf cat puts display fprintf value", "'print EXPR' shows a value"),
    MEANS("clc", "cls clear-screen", "'clear' clears the screen, 'drop all' forgets the runs"),
    MEANS("whos", "who info variables workspace state",
          "'show all' has everything that has a name, 'show' the set-up"),
    MEANS("if", "while until when loop else elif",
          "'run until COND' runs up to there, 'event NAME when COND do ...' acts on the way"),
    MEANS("for", "foreach range-loop scan vary parameter-study parameter-scan",
          "'sweep NAME=FROM:TO:STEP' runs once for each value: 'help sweep'"),
    MEANS("samples", "sampling npoints resolution",
          "'record = all' keeps every step, 'record = 10 ms' a time step of its own"),
    MEANS("man", "info-on usage doc describe-command", "'help COMMAND' explains it"),
    MEANS("par", "parameter p constants const", "'param NAME = VALUE' makes a parameter"),
    MEANS("aux", "observable define derived-quantity", "'observe NAME = EXPR' makes a quantity"),
    MEANS("def", "function lambda odefun rhs",
          "a law is an equation: 'var x = 1; x' = EXPR': 'help equations'"),
    MEANS("done", "finish ready", "nothing ends a set-up: 'run' integrates it, 'quit' leaves"),
    MEANS("steps", "iterations", "'run --steps 1000' goes so many, 'step 10' goes on"),
    MEANS("import", "",
          "'load FILE' reads a recording, 'source FILE' commands; all functions are there: 'list "
          "functions'"),
    MEANS("open", "read file txt upload",
          "'load FILE' reads a recording, 'source FILE' commands: 'help recording'"),
    MEANS("simulate", "integrate solve go calculate compute execute evolve odeint solve_ivp",
          "'run' integrates the scene"),
    MEANS("begin", "initial init start-values initial-conditions ic x0 position0",
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
    MEANS("time", "t seconds tspan tmax t_max tend t_end tfinal total endtime maxtime",
          "'duration = 20 s', or 'run 20 s'"),
    MEANS("colour", "colours colors nocolor no-color monochrome",
          "'set color never', always or auto"),
    MEANS("E", "total-energy etot", "the energy of the run: 'print energy', 'plot energy'"),
    MEANS("dE/E0", "dE energy-drift conservation",
          "how far the energy, or its balance with drag or a drive, is off: "
          "'plot energy-error', 'measure drift'"),
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
          "'m = 200.0 +- 0.1 g' or 'm = 200.0(1) g' states one; fits and 'measure' give theirs"),
    MEANS("sensor", "arduino labview recording-file measurement-file",
          "'load FILE' reads what it wrote: 'help recording'"),
    MEANS("tutorial", "me manual docs guide demo intro example",
          "'help' has topics with lines that can be pasted"),
    MEANS("gui", "windows ui tui", "'panes' shows plots above the prompt: 'help screen'"),
    MEANS("script", "batch macro",
          "'hooke FILE.hk' or 'source FILE.hk' runs commands, 'record FILE.hk' writes them"),
    MEANS("formula", "theory analytic closed-form expected",
          "'list derived' has what follows from the values: 'print T0'; 'fit EXPR' fits one"),
    MEANS("efficiency", "performance benchmark work-precision cost nfev",
          "'precision euler rk4' is error against run time, 'sweep tol=1e-9:1e-3:x10 "
          "measure=evals' counts evaluations"),
    MEANS("convergence", "convergence-order error-scaling",
          "'order rk4' measures how the error falls with the step"),
    MEANS("json", "machine-readable ndjson xml",
          "'set format json' here, 'hooke --format json FILE.hk' from a shell, 'export FILE.json'"),
    MEANS("exit-status", "status exit-code exitcode return-code errorlevel",
          "of 'hooke FILE.hk': 0 done, 1 a command failed, 2 bad option, 3 numerical, 4 files"),
    MEANS("overwrite", "replace clobber", "'export FILE --force' replaces a file that is there"),
    MEANS("comment", "comments remark",
          "# begins one, also behind a command; 'note TEXT' stays with the run"),
    MEANS("preview", "header head", "'load FILE --preview' shows what is in a file"),
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
    {&result_catalog, "'plot COLUMN against COLUMN of %1' draws its result"},
    {&guide_catalog, "'help %1' shows how"},
    {&command_catalog,
     "'%1' is a command: 'help %1'"}, /* the last: who is near a name wants that */
};

/* Of what kind is the word that is not known? NULL: another error. */
static bool is_kind(const char *kind, const char *wanted)
{
    return kind && text_starts(text_of(kind), text_of(wanted));
}

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
        /* what print shows stands for no choice, and expressions know it where it is there */
        if (!row || text_starts(text_of(kind), text_of(uses[i].catalog->kind)) ||
            (uses[i].catalog == &result_catalog && !is_kind(kind, "plot")) ||
            (uses[i].catalog == &observable_catalog && *kind && !is_kind(kind, "command") &&
             !is_kind(kind, "plot") && !is_kind(kind, "quantity")))
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

/* Is it one of these, between blanks? */
static bool mentions_whole(const char *where, struct text word)
{
    const char *at = strchr(where, ' ');
    while (at && !(strncmp(at + 1, word.at, word.len) == 0 && at[1 + word.len] == ' '))
        at = strchr(at + 1, ' ');
    return at;
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

#define SENTENCE_MIN 3 /* blanks in what is no misspelt command */
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

/* In another form than it was typed. */
static bool takes_name(const struct command *command, struct text name)
{
    int i = 0;
    while (i < command->arguments && !text_is(name, command->argument[i].name))
        i++;
    return i < command->arguments;
}

/* collect: a sensor's lines come once. */
static bool overwrites_nothing(const struct command *command)
{
    int i = 0;
    while (i < command->arguments &&
           !(command->argument[i].type == TYPE_FILE && command->argument[i].form == FORM_KEY &&
             strcmp(command->argument[i].name, "to") == 0))
        i++;
    return i < command->arguments;
}

/* What has this name elsewhere, what is meant by it, which commands take it; guessed: something was
 * suggested. */
static void put_meanings(const struct session *session, const struct command *command,
                         struct text statement, struct text where, const char *kind, bool guessed,
                         struct buffer *text)
{
    const struct text word = whole_word(statement, where),
                      called = is_kind(kind, "command") ? called_word(statement) : TEXT(""),
                      names[] = {word, where, called};
    for (size_t i = 0; kind && i < COUNT_OF(names) && text->len == 0; i++)
        if (names[i].len > 0 && !put_uses(names[i], kind, guessed, text)) {
            const struct row *row = catalog_find(&word_catalog, names[i]);
            if (row)
                put_filled(row->brief, is_kind(kind, "command") ? statement : TEXT(""), text);
        }
    if (!command || where.at == statement.at)
        return;
    const enum argument_form form = form_of(statement, where);
    if (form == FORM_OPTION && text_is(where, "force") && overwrites_nothing(command))
        buffer_put(text, TEXT("to= takes a new file: what is there is not overwritten"));
    struct buffer takers = {0}, usage = {0};
    if (form == FORM_KEY && !kind) { /* one of the other commands, or of the session */
        const struct row *row =
            takes_name(command, where) ? NULL : catalog_find(&word_catalog, where);
        put_setting(session, where, text);
        buffer_put(text, row && text->len == 0 ? text_of(row->brief) : TEXT(""));
    }
    if (!(guessed && form == FORM_WORD) &&
        put_takers(command, form == FORM_WORD ? word : where, form,
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

/* np.sin(1), run for 10 s, plot y(t), plot run.csv */
static bool put_misplaced(const struct session *session, const char *kind, struct text statement,
                          struct text where, struct buffer *text)
{
    static const char fillers[] = " for with using the a an at by in ";
    const char *end = statement.at + statement.len, *next = where.at + where.len;
    const struct text rest = {next, (size_t)(end - next)}, called = called_word(where);
    if (is_kind(kind, "name") && rest.len > 1 && rest.at[0] == '.' && is_name_start(rest.at[1])) {
        const struct text name = peek_name((struct text){next + 1, rest.len - 1});
        buffer_format(text, "names stand alone: '%.*s'", (int)name.len, name.at);
    } else if (is_kind(kind, "name") && where.len < 6 && where.at > statement.at &&
               where.at[-1] == ' ' && mentions_whole(fillers, where) && text_trim(rest).len > 0) {
        const struct text before =
            text_trim((struct text){statement.at, (size_t)(where.at - statement.at)});
        const struct text after = text_trim(rest);
        buffer_format(text, "'%.*s %.*s'", (int)before.len, before.at, (int)after.len, after.at);
    } else if (is_kind(kind, "plot") && called.len > 0 &&
               (model_variable(session->setup.scene.model, called) >= 0 ||
                catalog_find(&observable_catalog, called))) {
        buffer_format(text, "'plot %.*s'", (int)called.len, called.at);
    } else if (is_kind(kind, "plot") && where.len > 2 && memchr(where.at, '.', where.len)) {
        buffer_put(text, text_of(catalog_find(&word_catalog, TEXT("open"))->brief));
    }
    return text->len > 0;
}

/* Is it an expression of a scene's law, which knows no variables of let? */
static bool is_law(const struct command *command, struct text statement)
{
    const struct text name = peek_name(statement);
    return command ? strcmp(command->group, "EQUATIONS") == 0 &&
                         command->completes != COMPLETES_VARIABLE &&
                         command->completes != COMPLETES_PARAMETER
                   : name.len < statement.len && name.at[name.len] == '\'';
}

/* "i have a spring and a recording": what is known of its other words, two at most; not of a few
 * words behind a command that was only misspelt. */
static void put_sentence(struct text statement, bool guessed, struct buffer *text)
{
    struct text rest = statement;
    int blanks = 0;
    for (size_t i = 0; i < statement.len; i++)
        blanks += statement.at[i] == ' ';
    if (guessed && blanks < SENTENCE_MIN)
        return;
    for (int count = 0; rest.len > 0 && count < 2;) {
        const struct text word = peek_word(rest, ",;?.!");
        struct buffer use = {0};
        if (word.len > 2 && word.at > statement.at && put_uses(word, "", false, &use) &&
            !(text->len > 0 && strstr(buffer_view(text), buffer_view(&use)))) {
            buffer_format(text, "%s%s", count++ ? "; " : "", buffer_view(&use));
        }
        buffer_free(&use);
        rest.at += word.len + (word.len < rest.len);
        rest.len -= word.len + (word.len < rest.len);
        text_skip_blanks(&rest);
    }
}

static void explain(const struct session *session, struct text statement, const char *kind,
                    struct error *error)
{
    const struct text where = error->where;
    struct buffer text = {0};
    const struct command *own =
        command_at(choose(session, &command_catalog, peek_word(statement, "")));
    const struct command *command = kind && !*kind ? NULL : advises(error->hint) ? NULL : own;
    const bool name = is_kind(kind, "name"), law = name && is_law(own, statement);
    const bool unit = is_kind(kind, "unit") && text_starts(text_of(error->hint), TEXT("write "));
    const bool known = unit ||
                       (is_kind(kind, "command") && put_rewritten(session, statement, &text)) ||
                       put_misplaced(session, kind, statement, where, &text);
    if (!kind && own && text_is(text_of(own->row.name), "save") && text_is(where, "plot"))
        buffer_put(&text, text_of(catalog_find(&word_catalog, TEXT("picture"))->brief));
    else if (!kind && own && text_is(where, ">"))
        buffer_format(&text, "%s makes no table; 'export FILE table' writes the last one",
                      own->row.name);
    else if (is_kind(kind, "method") && text_is(where, "all"))
        buffer_put(&text, TEXT("methods are named one by one: 'list methods' lists them"));
    else if (!known && !law)
        put_meanings(session, command, statement, where, kind,
                     strstr(error->hint, "did you mean") != NULL, &text);
    if (is_kind(kind, "command") && text.len == 0)
        put_sentence(statement, strstr(error->hint, "did you mean"), &text);
    if (!kind && own && text_is(text_of(own->row.name), "plot") &&
        catalog_find(&plot_catalog, where))
        put_use("'plot %1' is a plot of its own", where, &text);
    if (is_kind(kind, "method") && text.len == 0 && !error->hint[0])
        buffer_put(&text, TEXT("'list methods' lists them"));
    if (text.len > 0) {
        error->hint[0] = '\0';
        error_hint(error, "%s", buffer_view(&text));
    } else if (name) {
        put_named(session, law, where, &text);
        if (text.len > 0)
            error_hint(error, "%s", buffer_view(&text));
    } else if (kind && (!*error->hint || text_starts(text_of(error->hint), TEXT("'help' lists"))) &&
               where.len > 2 && is_mentioned(where)) {
        error_hint(error, "'apropos %.*s' finds where it is spoken of", (int)where.len, where.at);
    }
    buffer_free(&text);
}

void explain_unknown(const struct session *session, struct text statement, struct error *error)
{
    static const char unknown[] = "unknown ", absent[] = "there is no help on";
    const struct text says = text_of(error->text), where = error->where;
    const char *kind = text_starts(says, TEXT(absent))    ? ""
                       : text_starts(says, TEXT(unknown)) ? error->text + sizeof unknown - 1
                                                          : NULL;
    if (!where.at || where.at < statement.at || where.at > statement.at + statement.len ||
        error->code != ERROR_COMMAND)
        return;
    text_skip_blanks(&statement);
    explain(session, statement, kind, error);
}
