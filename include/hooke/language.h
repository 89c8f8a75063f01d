/* SPDX-License-Identifier: GPL-3.0-or-later */
/* language: what may stand after the name of a command, and how it is read. */
#pragma once

#include <hooke/result.h>
#include <hooke/session/subject.h>

struct unit;

/* ---- how the arguments of a command are described ---- */

enum argument_form {
    FORM_PLACE,  /* stands where it stands: DURATION */
    FORM_WORD,   /* introduced by its own name: to T, run N.. */
    FORM_KEY,    /* NAME=item */
    FORM_OPTION, /* --NAME [item] */
};

/* TYPE_VALUE, TYPE_CHOICE, ...: the rows of src/language/types.def. */
enum argument_type {
#define ARGUMENT_TYPE(name, ...) TYPE_##name,
#include "language/types.def"
};

enum type_flag {
    TYPE_IS_NUMBER = 1,        /* nothing may be glued to it */
    TYPE_GOES_ON = 2,          /* an expression, which goes on over blanks */
    TYPE_HAS_QUANTITY = 4,     /* that of the argument */
    TYPE_SHOWS_CHOICES = 8,    /* choices are shown in the line of usage if they are few */
    TYPE_SHOWS_BOTH = 16,      /* and what else it may be */
    TYPE_IS_LIST = 64,         /* several go on after a word without it */
    TYPE_BEFORE_WORDS = 128,   /* its rows come before words of the same name */
    TYPE_MAY_BE_SKIPPED = 256, /* a word that is none goes to the next place */
    TYPE_BEFORE_EQUALS = 512,  /* a = after it belongs to what follows */
    TYPE_IS_ANY_KEY = 1024,
    TYPE_IS_FILE = 2048,
    TYPE_TAKES_REST = 4096,
    TYPE_IS_FORMULA = 8192,
};

enum argument_flag {
    ARG_REQUIRED = 1,
    /* several items: blanks or commas between them in a place or after a word, commas after a
     * key */
    ARG_MANY = 2,
    ARG_ALL = 4, /* the word `all` stands for every run */
    /* TYPE_COLUMN may be any word if `of` follows it: a column of a table */
    ARG_OF = 16,
    ARG_NEGATIVE = 8, /* TYPE_INTEGER and TYPE_VALUE may be negative or zero */
};

struct argument {
    enum argument_form form;
    /* name for usage and messages, "DURATION", or the word as typed, "to", "dt", "force" */
    const char *name;
    enum argument_type type;
    /* Type that a module defines, instead of `type`; NULL if there is none. */
    const struct argument_type_row *own_type;
    unsigned flags;
    enum quantity quantity;
    const struct catalog *choices;
    const char *lead; /* a word that may stand before: "of" */
    const char *more; /* further forms of its text, for usage: "[from LABEL]" */
    int group;        /* those of the same group (not 0) exclude each other */
};

#define ARGUMENTS_MAX 24

struct parser;
struct item;
struct completion;

struct argument_type_row {
    const char *name, *shown; /* name; form in the line of usage */
    bool (*read)(struct parser *parser, const struct argument *argument, const char *stops,
                 struct item *item, struct error *error);
    void (*complete)(struct completion *c, const struct argument *argument, struct text preceding);
    unsigned flags;
};

const struct argument_type_row *argument_type(const struct argument *argument);
/* The row of src/language/types.def. */
const struct argument_type_row *argument_type_row(enum argument_type type);

static inline bool type_is(const struct argument *argument, unsigned flags)
{
    return (argument_type(argument)->flags & flags) != 0;
}

/* ---- commands ---- */

enum command_flag {
    COMMAND_CHANGES = 1,    /* may change what undo restores: a snapshot is taken before */
    COMMAND_UNRECORDED = 2, /* not written by `record` */
    COMMAND_ANYTIME = 4,    /* also while a run goes on: it does not disturb it */
    /* executes other statements, which stand in the log of the session themselves */
    COMMAND_NESTS = 8,
    COMMAND_IN_EVENTS = 16, /* also what an event executes, although it changes the session */
    COMMAND_STARTS = 32,    /* starts a run, into which its conditions look */
    COMMAND_ASSIGNS = 64,   /* NAME = VALUE is short for it */
    COMMAND_EQUATES = 128,  /* NAME' = EXPR is */
    /* NAME' = EXPR during a run is short for it: a variable gets another value. */
    COMMAND_JUMPS = 256,
    COMMAND_TABLES = 512, /* its result is a table: > FILE may stand behind it */
    /* may stand in a session that saved itself, as may what undo takes back */
    COMMAND_RESTORES = 1024,
    COMMAND_BESIDE = 2048, /* also while a recording is collected */
};

/* Completion of the text after the command, if its arguments do not define it. */
enum completes {
    COMPLETES_ARGUMENTS,
    COMPLETES_GRID,     /* NAME=FROM:TO */
    COMPLETES_TOPICS,   /* topics of help */
    COMPLETES_ATOL,     /* variables, then values */
    COMPLETES_KINDS,    /* kinds of lists, then kinds of methods */
    COMPLETES_SHOWN,    /* groups and names */
    COMPLETES_VALUES,   /* a name, then its unit or choices */
    COMPLETES_EQUATION, /* NAME' = EXPR */
    COMPLETES_VARIABLE, /* NAME = VALUE [UNIT] */
    COMPLETES_PARAMETER,
    COMPLETES_OBSERVED, /* NAME = EXPR */
    COMPLETES_FORCE,    /* EXPR, or `off` */
    COMPLETES_POTENTIAL,
    COMPLETES_EVENT,
};

struct arguments;

struct command {
    struct row row;       /* name, "", brief, "", aliases that hold in files too */
    const char *group;    /* "SCENE", "RUN" … */
    const char *text;     /* a few lines for help */
    const char *examples; /* two lines that can be pasted */
    const char *see;      /* names separated by blanks */
    const struct argument *argument;
    int arguments;
    unsigned flags;
    enum completes completes;
    bool (*handler)(struct session *session, const struct arguments *value, struct reply *reply,
                    struct error *error);
};

#define USAGE_CHOICES 8 /* as many choices stand in the line of usage themselves */

/* "run [DURATION | to T | until COND] [--force]", made from the arguments. */
void command_usage(const struct command *command, struct buffer *text);
/* appends the usage of it, such as "dt=V" */
void argument_usage(const struct argument *argument, struct buffer *text);

/* A row of the command catalog. */
static inline const struct command *command_at(const struct row *row)
{
    return (const struct command *)(const void *)row;
}

/* ---- what was given ---- */

struct item {
    struct text text;        /* as typed, quotes and escapes resolved */
    struct measured value;   /* SI; the uncertainty is 0 unless given */
    const struct unit *unit; /* NULL if none was typed */
    /* Quantity of the value, if it is known by its unit or as a single name; else
     * QUANTITY_OTHER. */
    enum quantity quantity;
    bool is_string;
    double range[2];       /* NAN for an open end */
    const struct row *row; /* TYPE_CHOICE */
    /* Index of the choice in its catalog, or of the run or recording in the session; -1 for all. */
    int index;
    const struct condition *condition;
    const struct expr *expr;
};

struct argument_value {
    int count; /* 0 if not given */
    struct item *item;
    struct text where; /* all of it, in the line */
};

struct arguments {
    const struct command *command;
    struct text word;                           /* the command as typed; empty for an assignment */
    struct argument_value value[ARGUMENTS_MAX]; /* values in the order of the command's arguments */
    const struct expr_scope *scope;             /* scope of conditions and expressions */
    struct arena *arena;                        /* lives as long as the command */
    const struct source *where;
};

static inline bool has_argument_at(const struct arguments *arguments, int index)
{
    return arguments->value[index].count > 0;
}

/* Returns the value of the argument of this name, which the command has to have. */
const struct argument_value *argument_value(const struct arguments *arguments, const char *name);

static inline bool has_argument(const struct arguments *arguments, const char *name)
{
    return argument_value(arguments, name)->count > 0;
}

/* Returns the text of the argument of this name, which the command has to have, or an empty text
 * if it was not given. */
struct text argument_text(const struct arguments *arguments, const char *name);

/* Returns what was given for an argument that a module adds to the command. Returns NULL if nothing
 * was given, or if the module is left out. */
const struct argument_value *added_argument(const struct arguments *arguments, const char *name);

/* ---- parsing ---- */

struct parser {
    struct session *session;
    const struct expr_scope *scope;
    struct arena *arena;
    struct text rest; /* remaining text of the statement */
};

/* A word or a string; *is_string says which. */
bool parse_word(struct parser *parser, const char *stops, struct item *item, struct error *error);
/* Returns the text before the first option: `1 --force` is no subtraction. */
struct text before_option(struct text text);
/* expr [+- expr]; `what` names the parameter in messages. wanted QUANTITY_OTHER: any. */
bool parse_value(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
bool parse_range(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
/* WIDTHxHEIGHT of a picture into range [m]; in cm unless the unit is said. */
bool parse_sides(struct parser *parser, const char *what, const char *stops, struct item *item,
                 struct error *error);
bool parse_integer(struct parser *parser, const char *what, bool negative, struct item *item,
                   struct error *error);
/* Refuses the remaining text, with the likely reason: decimal comma, unknown unit, word too many.
 * `number` is the last item read, or NULL if it was no number. Returns true if nothing remains. */
bool refuse_rest(const struct parser *parser, const struct item *number, struct error *error);
/* Reads all arguments of a command. */
bool parse_arguments(struct parser *parser, const struct command *command,
                     struct arguments *arguments, struct error *error);
/* find, or the only row that starts so at the prompt. */
const struct row *catalog_choose(const struct session *session, const struct catalog *catalog,
                                 struct text name);
/* Returns false with `error` filled if the name is that of a row which a module brings that this
 * program was built without. */
bool choice_is_in(const struct catalog *catalog, struct text name, struct error *error);

/* Reads the value of a setting from the parser into `settings`. */
bool setting_read(const struct setting *setting, struct parser *parser, struct settings *settings,
                  struct error *error);

/* ---- the series that arguments name ---- */

/* The series of another column of the subject's run, in the same window. */
bool subject_column(struct subject *subject, const struct argument_value *column,
                    const struct argument_value *window, struct arena *arena, struct error *error);
/* The run or recording that was given, else the latest; window: of TYPE_RANGE. At least `min`
 * samples. */
bool subject_open(struct session *session, const struct argument_value *run,
                  const struct argument_value *data, const struct argument_value *window,
                  bool energy, size_t min, struct arena *arena, struct subject *subject,
                  struct error *error);

/* ---- closed lists of words that only commands know ---- */

extern const struct catalog separator_catalog, decimal_catalog, quantity_catalog, show_catalog,
    list_catalog;

static const char separator_letters[] = "\t,; ";
static const char decimal_letters[] = ".,";

/* Order of the rows of quantity_catalog. */
enum measurable {
    MEASURE_PERIOD,
    MEASURE_FREQUENCY,
    MEASURE_AMPLITUDE,
    MEASURE_DECAY,
    MEASURE_ENERGY,
    MEASURE_DRIFT,
    MEASURE_REYNOLDS,
    MEASURE_K,
    MEASURE_SPRING,
    MEASURE_SPECTRUM,
    MEASURE_REPEAT
};

enum show_topic { SHOW_ALL, SHOW_SCENE, SHOW_RUN, SHOW_DATA, SHOW_PLOT, SHOW_FILES };

enum listed {
    LIST_COMMANDS,
    LIST_SCENES,
    LIST_METHODS,
    LIST_PARAMETERS,
    LIST_DERIVED,
    LIST_OBSERVABLES,
    LIST_SETTINGS,
    LIST_UNITS,
    LIST_FUNCTIONS,
    LIST_LIMITS,
    LIST_MEASUREMENTS,
    LIST_EVENTS,
    LIST_RUNS
};

/* A kind of thing that `list` lists. Kinds of modules follow those of the enum. */
struct list_kind {
    struct row row;
    /* Lists it, for kinds of modules. Returns false if out of memory. NULL for those of the enum.
     */
    bool (*list)(struct session *session, struct arena *arena, struct reply *reply);
};
