/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of this layer share: arguments and how they are described, names in expressions, changes of the
 * session. */
#ifndef HOOKE_COMMAND_INTERNAL_H
#define HOOKE_COMMAND_INTERNAL_H

#include <hooke/command.h>

/* ---- how the arguments of a command are described ---- */

enum argument_form {
    FORM_PLACE,  /* stands where it stands: DURATION */
    FORM_WORD,   /* introduced by its own name: to T, run N.. */
    FORM_KEY,    /* NAME=item */
    FORM_OPTION, /* --NAME [item] */
};

enum argument_type {
    TYPE_NONE,      /* nothing follows the name */
    TYPE_VALUE,     /* a number with a unit of `quantity`, an expression */
    TYPE_INTEGER,   /* a whole number */
    TYPE_RANGE,     /* [value]:[value] */
    TYPE_CONDITION, /* y < 1 cm */
    TYPE_EXPR,      /* an expression of any quantity, or a string */
    TYPE_CHOICE,    /* a row of `choices` */
    TYPE_SCENE,     /* a struct preset: a built-in scene, or one of the user's own; or `new`, then row is NULL */
    TYPE_COLUMN, /* a row of `choices`, if there are any (then index is its place); a state variable or an observable */
    TYPE_UNIT,   /* the name of a unit */
    TYPE_RUN,    /* number or name of a run; -1 for `all` where ARG_ALL allows it */
    TYPE_RECORDING, /* name of a recording */
    TYPE_NAME,      /* something that can be set or shown */
    TYPE_PARAM,     /* a name, completed as a parameter of the scene; index: its place there, -1 */
    TYPE_START,     /* after FORM_KEY: stands for any key that no other argument has; text: that name, value */
    TYPE_MODEL,     /* a row of `choices`, or a formula in t: a string, or as it stands (then row is NULL) */
    TYPE_TEXT,      /* a word or a string */
    TYPE_EVENT,     /* the name of an event, also of one that is watched for no more */
    TYPE_FILE,      /* the same, completed as a file name */
    TYPE_REST,      /* all that is left of the statement, as it is */
    TYPE_FORMULA,   /* the same: an expression in the names of the scene, and what belongs to it */
};

enum argument_flag {
    ARG_REQUIRED = 1,
    ARG_MANY = 2,     /* several items: blanks or commas between them in a place or after a word, commas after a key */
    ARG_ALL = 4,      /* the word `all` stands for every run */
    ARG_NEGATIVE = 8, /* TYPE_INTEGER and TYPE_VALUE may be negative or zero */
};

struct argument {
    enum argument_form form;
    const char *name; /* for usage and messages: "DURATION"; what is typed: "to", "dt", "force" */
    enum argument_type type;
    unsigned flags;
    enum quantity quantity;
    const struct catalog *choices;
    const char *lead; /* a word that may stand before: "of" */
    int group;        /* those of the same group (not 0) exclude each other */
};

#define ARGUMENTS_MOST 16

/* ---- what was given ---- */

struct item {
    struct text text;        /* as typed, quotes and escapes resolved */
    struct measured value;   /* SI; the uncertainty is 0 unless given */
    const struct unit *unit; /* NULL: none typed */
    enum quantity quantity; /* of the value, where it is known: by its unit, or as a single name; else QUANTITY_OTHER */
    bool is_string;
    double range[2];       /* NAN: open */
    const struct row *row; /* TYPE_CHOICE */
    int index;             /* place of the choice in its catalog, of the run or recording in the session; -1: all */
    const struct condition *condition;
    const struct expr *expr;
};

struct given {
    int count; /* 0: not given */
    struct item *item;
    struct text where; /* all of it, in the line */
};

struct arguments {
    const struct command *command;
    struct text word; /* the command as typed; empty: an assignment */
    struct given given[ARGUMENTS_MOST]; /* at the place of their struct argument */
    const struct expr_scope *scope;     /* of conditions and expressions */
    struct arena *arena;                /* lives as long as the command */
    const struct source *where;
};

static inline bool has(const struct arguments *arguments, int place)
{
    return arguments->given[place].count > 0;
}

/* What was given for the argument of this name, which the command has. */
const struct given *given_for(const struct arguments *arguments, const char *name);

static inline bool is_given(const struct arguments *arguments, const char *name)
{
    return given_for(arguments, name)->count > 0;
}

/* ---- how a command is written ----
 *
 * A file cmd_*.c holds, inside `#ifndef COMMAND_ROWS`, functions that begin with HANDLER(name), and below it their
 * rows, COMMAND(name, …). commands.c includes all of them again through commands.def to collect the rows.
 */

enum command_flag {
    COMMAND_CHANGES = 1,    /* may change what undo restores: a snapshot is taken before */
    COMMAND_UNRECORDED = 2, /* not written by `record` */
    COMMAND_ANYTIME = 4,    /* also while a run goes on: it does not disturb it */
    COMMAND_NESTS = 8,      /* executes other statements, which stand in the story of the session themselves */
};

#define HANDLER_PARAMETERS                                                                                             \
    struct session *session, const struct arguments *given, struct reply *reply, struct error *error
#define HANDLER(name)                                                                                                  \
    bool command_##name(HANDLER_PARAMETERS);                                                                           \
    bool command_##name(HANDLER_PARAMETERS)
#define UNUSED(thing) ((void)(thing))

#define ARGUMENTS(...)                                                                                                 \
    .argument = (const struct argument[]){__VA_ARGS__},                                                                \
    .arguments = (int)COUNT_OF(((const struct argument[]){__VA_ARGS__}))

/* name, type, then what else differs from zero: PLACE("N", TYPE_INTEGER, .flags = ARG_REQUIRED) */
#define PLACE(...)                                                                                                     \
    {                                                                                                                  \
        .form = FORM_PLACE, .name = __VA_ARGS__                                                                        \
    }
#define WORD(...)                                                                                                      \
    {                                                                                                                  \
        .form = FORM_WORD, .name = __VA_ARGS__                                                                         \
    }
#define KEY(...)                                                                                                       \
    {                                                                                                                  \
        .form = FORM_KEY, .name = __VA_ARGS__                                                                          \
    }
#define OPTION(...)                                                                                                    \
    {                                                                                                                  \
        .form = FORM_OPTION, .name = __VA_ARGS__                                                                       \
    }

#ifndef COMMAND_ROWS
#define COMMAND(...)
#endif

/* ---- parsing (lexer.c, value.c, arguments.c) ---- */

struct parser {
    struct session *session;
    const struct expr_scope *scope;
    struct arena *arena;
    struct text rest; /* what is left of the statement */
};

/* A word or a string; *is_string says which. */
bool parse_word(struct parser *parser, const char *stops, struct item *item, struct error *error);
/* What stands before the first option: `1 --force` is no subtraction. */
struct text before_option(struct text text);
/* expr [UNIT] [+- expr [UNIT]]; `what` names the parameter in messages. wanted QUANTITY_OTHER: any. */
bool parse_value(struct parser *parser, const char *what, enum quantity wanted, struct item *item, struct error *error);
bool parse_range(struct parser *parser, const char *what, enum quantity wanted, struct item *item, struct error *error);
bool parse_integer(struct parser *parser, const char *what, bool negative, struct item *item, struct error *error);
/* Refuses what is left, with the likely reason: decimal comma, unknown unit, word too many. number: what was read
 * before, NULL: no number. */
bool refuse_rest(const struct parser *parser, const struct item *number, struct error *error);
/* The argument VALUE of a statement NAME = VALUE, to be read with read_value() (cmd_scene.c). */
struct parser value_parser(struct session *session, const struct arguments *given);
bool read_value(struct parser *parser, const char *what, enum quantity quantity, struct item *item, struct error *error);
/* Both sides of a comparison must be of one quantity, where that is known. */
bool check_condition(struct parser *parser, struct text condition, struct error *error);
/* One item of this argument, which may end at one of `stops` (items.c). */
bool read_item(struct parser *parser, const struct argument *argument, const char *stops, struct item *item,
               struct error *error);
/* Reads all arguments of a command. */
bool parse_arguments(struct parser *parser, const struct command *command, struct arguments *arguments,
                     struct error *error);
/* find, or the only row that starts so at the prompt. */
const struct row *choose(const struct session *session, const struct catalog *catalog, struct text name);
/* ---- what a scene has, by name (parameters.c) ---- */

const struct param_row *param_at(const struct scene *scene, int place);
int scene_param_at(const struct scene *scene, struct text name); /* as scene_param() */
double param_value(const struct scene *scene, const char *name); /* NAN: the scene has no such parameter */
bool param_given(const struct scene *scene, const char *name);
bool is_oscillator(const struct scene *scene); /* also with forces that were typed */
bool is_pendulum(const struct scene *scene);   /* on a rigid rod */
/* What was typed, a line each after `before`. */
void scene_lines(const struct scene *scene, const char *before, struct buffer *text);
/* The same, each before `end`, in an order in which they can be typed: a line may use one that was typed after it,
 * where it has taken the place of another. */
void scene_script(const struct scene *scene, const char *end, struct buffer *text);
/* "atol y = 0.1 mm", of one variable; the absolute tolerances that were given, as scene_script(). */
void atol_describe(const struct scene *scene, int variable, struct buffer *text);
void atol_script(const struct scene *scene, const char *end, struct buffer *text);
int model_variable(const struct model *model, struct text name); /* place, -1: none; y' is vy of a typed model */
int model_observation(const struct model *model, struct text name); /* place of what a typed model observes, -1: none */
const struct model *model_with(struct text name); /* the first with such a parameter, derived quantity or variable */
const char *model_scene(const struct model *model); /* name of a scene that is one */
enum quantity model_quantity(const struct model *model, const struct observable *observable);
/* NULL: none. In what a user has typed `y` is no other name of the first coordinate. */
const struct observable *model_observable(const struct model *model, struct text name);
bool model_offers(const struct model *model, const struct observable *observable); /* as far as the model decides it */
/* Says where the name belongs, if it is to another model; false: it does not. */
bool hint_other_model(const struct session *session, struct text name, struct error *error);
/* A scene of the user's own, by its name; NULL: there is none. */
const struct preset *own_scene(const struct setup *setup, struct text name);
bool unknown_parameter(const struct session *session, struct text name, struct error *error); /* false, always */

/* ---- names in expressions (names.c) ---- */

/* The scene of a run that goes on, with what was changed on the way. */
struct in_force {
    const struct held_run *held;
    bool known;             /* `scene` is there, as of this end of its journal */
    const struct leg *last;
    struct scene scene;
};

struct names {
    const struct session *session;
    struct in_force *in_force; /* whose parameters; NULL: those of the set-up */
    bool expects_run;      /* state and observables are known although there is no run yet: it is about to start */
    bool saved_only;       /* without variables and results: what means the same when a saved session is read again */
    const struct run *run; /* whose state and observables; NULL: those of the current run */
};

struct expr_scope names_scope(const struct names *names);
/* Value, uncertainty and quantity of one name; false: unknown. */
/* After a failed compilation: says what has to come first where the unknown name is that of something not there yet.
 * False, always. */
bool names_explain(const struct session *session, struct error *error);
bool names_value(const struct session *session, struct text name, struct named_value *value);
/* Of a name in a scope made by names_scope; QUANTITY_OTHER: unknown. */
enum quantity name_quantity(const struct expr_scope *scope, struct text name);
/* Everything that can be named: offers candidates for completion and help. */
void names_each(const struct session *session, void (*offer)(void *context, const char *name, const char *brief),
                void *context);
bool name_is_taken(const struct session *session, struct text name, const char **kind);

/* ---- text for people ---- */

/* "199.9 +- 0.1 g", "1.9373 +- 0.0002 s": in the unit that shows the value well. */
void buffer_measured(struct buffer *buffer, struct measured value, enum quantity quantity, int digits);
/* The value as a command that reads back exactly: "0.2 kg", "199.9 +- 0.1 g". */
void buffer_exact(struct buffer *buffer, struct measured value, enum quantity quantity);
/* A word of a command line, quoted where it has to be. */
void buffer_word(struct buffer *buffer, struct text word);
/* ---- the session (session.c, runs.c, undo.c) ---- */

void session_changed(struct session *session);
/* Takes the run over (also when it fails: then it is destroyed) and makes it the current one. */
bool session_add_run(struct session *session, struct run *run, struct error *error);
bool session_add_recording(struct session *session, struct recording *recording, const char *options,
                           struct error *error);
void session_drop_run(struct session *session, int place);
void session_drop_recording(struct session *session, int place);
void held_run_release(struct held_run *held);
void held_recording_release(struct held_recording *held);
int session_find_run(const struct session *session, struct text name);       /* number or name; -1: none */
int session_find_recording(const struct session *session, struct text name); /* -1: none */
/* The latest one of each model, recording or run, and window; without memory it is only not in the report. */
/* Values of the last fit at n ascending times [s]; NAN: outside of what it was fitted to. */
void session_fit_values(const struct session *session, const double *t, size_t n, double *value);
void session_keep_fit(struct session *session, const struct kept_fit *fit);
void session_set_result(struct session *session, const char *name, struct measured value, enum quantity quantity);
struct write_policy session_policy(const struct session *session, bool force);
void session_default_settings(struct settings *settings);
/* Whether the user has set it; what he has not may follow the scene: settings_of_scene(). */
bool setting_is_given(const struct setting *setting, const struct settings *settings);
void setting_give(const struct setting *setting, bool given, struct settings *settings);
/* Duration and tolerance of the scene, unless they were set. */
void settings_of_scene(struct settings *settings, const struct preset *preset);
/* Those that only show become as in `from`: no undo, no run depends on them. */
void settings_display(struct settings *settings, const struct settings *from);
void session_size(const struct session *session, int *width, int *height);

struct snapshot *snapshot_take(const struct session *session, const char *label); /* NULL: no memory */
void snapshot_free(struct snapshot *snapshot);
void run_unmark(struct held_run *held); /* forget how undo entries last saw it */
/* Whether going back to it would change anything. */
bool undo_matters(const struct session *session, const struct snapshot *before);
void undo_push(struct session *session, struct snapshot *before);
void undo_clear(struct session *session);

/* ---- runs in text (run_text.c, subject.c) ---- */

/* A prediction above a minute is refused, or asked about at the prompt, unless --force was given. */
bool allow_long(struct session *session, double seconds, double steps, bool force, struct error *error);
/* What a tolerance below 10 eps is really taken as; nothing for others. */
void put_tol_floor(struct buffer *text, double tol);
/* The line and the record of a run as it is now. */
void reply_run(const struct session *session, const struct run *run, struct reply *reply);
/* Warns of growth that the method made, not the scene: once a run, before it reaches the bounds of a double. */
void reply_growth(struct run *run, struct reply *reply);
/* Warns once if a step was nonsense. */
void reply_unsound(struct run *run, struct reply *reply);
void reply_sliding(struct run *run, struct reply *reply); /* along switches, or these pile up; once */
void reply_vanished(const struct run *run, struct reply *reply); /* every value is below the smallest number */
void reply_below_tolerance(const struct run *run, struct reply *reply);
void seek_opinion(const struct session *session, struct run *run); /* as `set opinion` says */
void plan_opinion(const struct session *session, const struct system *system, const struct plan *plan,
                  struct buffer *text); /* what it will cost */
/* Its line, and a warning where the error is large; false: nothing is right, which is an error. */
bool reply_opinion(const struct session *session, struct run *run, struct reply *reply, struct error *error);
void reply_opinion_values(const struct run *run, struct reply *reply); /* its keys in JSON */
void reply_missed_burst(struct run *run, struct reply *reply); /* once */
/* Of an exact solution so long that roundings of the parameters move its phase. */
void reply_phase_unknown(const struct run *run, struct reply *reply);
/* Warns of a state whose squares underflow. */
void reply_tiny(const struct run *run, struct reply *reply);
/* Says once which method a scene of the user's own gets where nobody has chosen one. */
void reply_unchosen(struct session *session, struct reply *reply);
/*
 * Says once of each scene of the user's own which duration, tolerance and first step are taken where nobody has set them:
 * those of the lab. adapts: a step control will use the last two; by_setting: 'duration' will be used.
 */
void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply);
/* Of a study: that it takes the setting, although the present run took longer. */
void reply_shorter(const struct session *session, struct reply *reply);
/* Warns where the scene rules out the method that is set, and says what to do. */
void reply_inapplicable(const struct session *session, struct reply *reply);
/* Warns of a step that is too coarse for the period. */
void reply_coarse(const struct session *session, const struct run *run, struct reply *reply);
/*
 * Rms distance of the run from the recording where they overlap in time and hold the same quantity. Which samples are
 * bad says the recording alone (find_faults(), once for each recording): a run that is far off is far off.
 */
struct data_distance {
    double rms; /* NAN: they do not overlap */
    size_t bad; /* samples left out: missed echoes would hide how well the run fits */
    int derivative; /* of what the recording holds: 0 position, 1 velocity, 2 acceleration */
    enum quantity quantity; /* of the rms: the recording's own */
    /* What was recorded as Y lies at gain Y + at_zero of the run's first variable. Of a voltage or a force (scaled)
     * both are fitted by least squares: NAN where it does not follow the run at all. */
    bool scaled;
    double gain, at_zero;
};
/* A sensor's quantity that moves with the position in a proportion that nobody knows: a voltage, a force. */
bool quantity_is_scaled(enum quantity quantity);
/* "1 V = 2.31 cm, 0 V at y = 1.2 cm" */
void put_scale(const struct data_distance *data, const struct run *run, struct buffer *text);
/* Numbers without a unit: taken as positions, in metres or radians, and said to be. */
bool recorded_bare(const struct recording *recording);
/* The same of a recording and the first coordinate of a run (NULL: by the quantity alone); -1: neither. */
int recorded_derivative(const struct recording *recording, const struct run *run);
struct variable run_derivative(const struct run *run, int derivative); /* its name and quantity */
struct data_distance run_data_distance(const struct run *run, struct recording *recording);

#define FAR 1e300 /* [s] no run gets there; finite, so that what is left of the way is a number */

/* ---- live runs (live.c) ---- */

/*
 * Advances to the target in slices of at most 10 ms, with a look at the front end between them; `clocked`: simulated
 * time follows the clock. Back when it is there, or paused: then run->stop is STOP_CANCELLED.
 */
void live_advance(struct session *session, struct run *run, const struct run_target *target, bool clocked);
/* State and marks of session->live follow from the current run. */
void live_refresh(struct session *session);
/*
 * A parameter of the scene has changed: takes it over into the run that goes on, is paused, or is to be changed. *from
 * [s]: since when, NAN: there is no such run. The run is unchanged on error.
 */
bool live_bind(struct session *session, int param, double *from, struct error *error);
/* Gives a variable of the current run's state, which there is, another value. */
bool live_kick(struct session *session, int variable, double value, struct error *error);
/* " from t = 3.2 s on", nothing where `from` is NAN. */
void buffer_since(struct buffer *text, double from);

extern const struct catalog cursor_action_catalog, axis_catalog, fit_kind_catalog;

bool command_set(HANDLER_PARAMETERS);

/* Where the present scene is all typed: `scene` finds it by its name as it is now. */
bool keep_own_scene(struct session *session, struct error *error);

/* ---- cursors (cursor.c) ---- */

/* After a command: cursors that stand on something that has changed find their places again. */
void cursors_refresh(struct session *session);

/* ---- settings (settings.c) ---- */

/* Reads the value of a setting from the parser into `settings`. */
bool setting_read(const struct setting *setting, struct parser *parser, struct settings *settings, struct error *error);
void setting_show(const struct setting *setting, const struct settings *settings, struct buffer *text);
/* As a command that reads back exactly. */
void setting_exact(const struct setting *setting, const struct settings *settings, struct buffer *text);

extern const struct catalog charset_choice_catalog, color_choice_catalog, phase_axes_catalog, turning_catalog;
extern const struct catalog opinion_catalog;

/* ---- what measure, fit, export and plot act on (source of a series) ---- */

struct subject {
    struct series series;
    char name[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
    bool energy;                /* the series is an energy */
    bool column;                /* it is a column that was asked for by name */
    struct run *run;            /* NULL: a recording */
    struct recording *recording;
    char how[340]; /* of the energy of a recording: whose m, k and v */
    struct measured mass, k; /* these */
    struct energy_noise noise; /* of the energy of a recording */
};

/* The scene that a run or a recording is measured against: its own; for a recording the present one, if somebody has
 * said what the spring is, else NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run);
/* Whether the scene is an oscillator; error if not, which says that `what` needs one. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error);
/* [s] of the oscillation with its linear damping, of another model as wide as it starts; NAN: it does not oscillate, or
 * there is no scene. */
double scene_period(const struct scene *scene);
/* [s] of a pendulum that swings so far [rad], without damping: complete elliptic integral; NAN: another scene. */
double scene_period_at(const struct scene *scene, double amplitude);
double derived_value(const struct scene *scene, const char *name); /* NAN: no scene, or not defined */
/* Keeps it as a row of `list measurements` and as the result measured_NAME. */
bool session_keep_measurement(struct session *session, const char *name, const char *of, struct measured value,
                              enum quantity unit, double periods, struct error *error);
/* The first variable, or energy, of a run over time; oldest first also where it went backwards. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series, struct error *error);
/* As of its position over all recorded rows, found the cheapest way that is sound for it; false: it has none. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period);
/* The series of another column of the subject's run, in the same window. */
bool subject_column(struct subject *subject, const struct given *column, const struct given *window,
                    struct arena *arena, struct error *error);
/* The run or recording that was given, else the latest; window: of TYPE_RANGE. At least `least` samples. */
bool subject_open(struct session *session, const struct given *run, const struct given *data,
                  const struct given *window, bool energy, size_t least, struct arena *arena, struct subject *subject,
                  struct error *error);

/* A row of the command catalog. */
static inline const struct command *command_at(const struct row *row)
{
    return (const struct command *)(const void *)row;
}

#endif
