/* SPDX-License-Identifier: GPL-3.0-or-later */
/* language: the arguments of commands: their description in the rows of commands (struct argument,
 * struct command), and their parsing into struct arguments. parse_arguments() reads all arguments
 * of a statement by the types in its row; handlers get the values by argument_value() and the
 * functions beside it. */
#pragma once

#include <hooke/result.h>
#include <hooke/session/subject.h>

struct unit;

/* ---- how the arguments of a command are described ---- */

/* Form of an argument in a statement. */
enum argument_form {
    FORM_PLACE,  /* Positional: DURATION. */
    FORM_WORD,   /* Its own name precedes it: to T, run N. */
    FORM_KEY,    /* NAME=item */
    FORM_OPTION, /* --NAME [item] */
};

/* Types of arguments: TYPE_VALUE, TYPE_CHOICE, …, the rows of src/language/types.def. */
enum argument_type {
#define ARGUMENT_TYPE(name, ...) TYPE_##name,
#include "language/types.def"
};

/* Properties of types, combined by |. */
enum type_flag {
    TYPE_IS_NUMBER = 1,     /* It is a number: nothing may follow it without a blank. */
    TYPE_GOES_ON = 2,       /* It is an expression, which continues over blanks. */
    TYPE_HAS_QUANTITY = 4,  /* It has the argument's quantity. */
    TYPE_SHOWS_CHOICES = 8, /* The line of usage shows the choices if they are few. */
    TYPE_SHOWS_BOTH = 16,   /* The line of usage shows the general form, too. */
    /* It is a list: several items may follow a word without repeating it. */
    TYPE_IS_LIST = 64,
    TYPE_BEFORE_WORDS = 128, /* Its choices take precedence over words of the same name. */
    /* A word that does not fit is read as the next positional argument. */
    TYPE_MAY_BE_SKIPPED = 256,
    TYPE_BEFORE_EQUALS = 512, /* A = after it belongs to the next item. */
    /* It accepts NAME=… for any name. */
    TYPE_IS_ANY_KEY = 1024,
    /* It is the name of a file. */
    TYPE_IS_FILE = 2048,
    /* It takes all remaining text. */
    TYPE_TAKES_REST = 4096,
    /* It is a formula. */
    TYPE_IS_FORMULA = 8192,
};

/* Properties of arguments, combined by |. */
enum argument_flag {
    /* It must be given. */
    ARG_REQUIRED = 1,
    /* Several items may be given: separated by blanks or commas if positional or after a word, by
     * commas after a key. */
    ARG_MANY = 2,
    ARG_ALL = 4, /* The word `all` stands for every run. */
    /* A TYPE_COLUMN may be any word if `of` follows it: a column of a table. */
    ARG_OF = 16,
    ARG_NEGATIVE = 8, /* A TYPE_INTEGER or TYPE_VALUE may be negative or zero. */
};

/* Description of an argument, in the row of its command. */
struct argument {
    enum argument_form form;
    /* Name for usage and messages, "DURATION", or the word as typed: "to", "dt", "force". */
    const char *name;
    enum argument_type type;
    /* Type of a module, in place of `type`, or NULL. */
    const struct argument_type_row *own_type;
    /* Flags of enum argument_flag. */
    unsigned flags;
    /* Quantity of its value. */
    enum quantity quantity;
    /* Choices of a TYPE_CHOICE. */
    const struct catalog *choices;
    const char *lead; /* Word that may precede it, such as "of", or NULL. */
    const char *more; /* More text for the line of usage, such as "[from LABEL]", or NULL. */
    int group;        /* Arguments of the same group (not 0) exclude each other. */
};

/* Largest number of arguments of a command. */
#define ARGUMENTS_MAX 24

struct parser;
struct item;
struct completion;

/* A type of arguments. */
struct argument_type_row {
    const char *name, *shown; /* Name, and form in the line of usage. */
    /* Reads one item from the parser, up to a blank or one of `stops`. Returns false with `error`
     * set. */
    bool (*read)(struct parser *parser, const struct argument *argument, const char *stops,
                 struct item *item, struct error *error);
    /* Offers completions of an item after the text `preceding`; NULL offers none. */
    void (*complete)(struct completion *c, const struct argument *argument, struct text preceding);
    /* Flags of enum type_flag. */
    unsigned flags;
};

/* Returns the row of an argument's type, a module's or one of types.def. */
const struct argument_type_row *argument_type(const struct argument *argument);
/* Returns the row of a type of src/language/types.def. */
const struct argument_type_row *argument_type_row(enum argument_type type);

/* Returns true if the argument's type has one of the flags. */
static inline bool type_is(const struct argument *argument, unsigned flags)
{
    return (argument_type(argument)->flags & flags) != 0;
}

/* ---- commands ---- */

/* Properties of commands, combined by |. */
enum command_flag {
    COMMAND_CHANGES = 1,    /* May change what undo restores: a snapshot is taken before. */
    COMMAND_UNRECORDED = 2, /* Not written by `record`. */
    COMMAND_ANYTIME = 4,    /* Allowed during a live run, which it does not disturb. */
    /* Executes other statements, which have their own entries in the history. */
    COMMAND_NESTS = 8,
    /* Allowed among the commands of an event, although it changes the session. */
    COMMAND_IN_EVENTS = 16,
    COMMAND_STARTS = 32,   /* Starts a run, to whose state its conditions refer. */
    COMMAND_ASSIGNS = 64,  /* A statement NAME = VALUE is its short form. */
    COMMAND_EQUATES = 128, /* A statement NAME' = EXPR is its short form. */
    /* NAME' = EXPR is its short form during a run: a variable gets another value. */
    COMMAND_JUMPS = 256,
    COMMAND_TABLES = 512, /* Its result is a table, which `> FILE` writes. */
    /* Allowed in a saved session, as are commands that undo takes back. */
    COMMAND_RESTORES = 1024,
    COMMAND_BESIDE = 2048, /* Allowed while a recording is collected. */
};

/* Completion of the text after a command, if its arguments do not define it. */
enum completes {
    /* The arguments define it. */
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

/* A command: a row of command_catalog. */
struct command {
    struct row row;       /* Name, "", description, "", aliases. */
    const char *group;    /* Heading under which help lists it: "SCENE", "RUN", … */
    const char *text;     /* Text for help. */
    const char *examples; /* Examples, two lines. */
    const char *see;      /* Names of related commands, separated by blanks. */
    /* [arguments] its arguments. */
    const struct argument *argument;
    int arguments;
    unsigned flags;
    enum completes completes;
    /* Executes the command. Returns false with `error` set; the session is then unchanged. */
    bool (*handler)(struct session *session, const struct arguments *value, struct reply *reply,
                    struct error *error);
};

/* Largest number of choices that the line of usage shows. */
#define USAGE_CHOICES 8

/* Appends the line of usage, made from the arguments: "run [DURATION | to T | until COND]
 * [--force]". */
void command_usage(const struct command *command, struct buffer *text);
/* Appends the usage of one argument, such as "dt=V". */
void argument_usage(const struct argument *argument, struct buffer *text);

/* Returns the command whose struct row this is; it must be in command_catalog. */
static inline const struct command *command_at(const struct row *row)
{
    return (const struct command *)(const void *)row;
}

/* ---- the arguments of a statement ---- */

/* One item of an argument, as it was read; the type decides which members are set. */
struct item {
    struct text text;        /* Text as typed, without quotes and escapes. */
    struct measured value;   /* Value [SI]; its uncertainty is 0 unless given. */
    const struct unit *unit; /* Unit as typed, or NULL. */
    /* Quantity of the value if it follows from its unit or a single name, else QUANTITY_OTHER. */
    enum quantity quantity;
    /* It was quoted. */
    bool is_string;
    double range[2];       /* Ends of a range [SI], NAN if open. */
    const struct row *row; /* Row of a TYPE_CHOICE. */
    /* Index of a choice in its catalog, or of a run or recording in the session; -1 for all. */
    int index;
    /* Condition and expression, in the arena. */
    const struct condition *condition;
    const struct expr *expr;
};

/* The items that were given for an argument. */
struct argument_value {
    int count; /* Number of items, 0 if the argument was not given. */
    /* [count] items, in the arena. */
    struct item *item;
    struct text where; /* The argument's text in the line, for errors. */
};

/* The arguments of a statement. */
struct arguments {
    const struct command *command;
    struct text word; /* Name of the command as typed; empty for an assignment. */
    struct argument_value value[ARGUMENTS_MAX]; /* Values in the order of command->argument. */
    const struct expr_scope *scope;             /* Scope of conditions and expressions. */
    struct arena *arena;                        /* Memory that lives until the command ends. */
    /* Origin of the line, or NULL. */
    const struct source *where;
};

/* Returns true if argument number `index` of the command was given. */
static inline bool has_argument_at(const struct arguments *arguments, int index)
{
    return arguments->value[index].count > 0;
}

/* Returns the value of the argument of this name, which the command must have. */
const struct argument_value *argument_value(const struct arguments *arguments, const char *name);

/* Returns true if the argument of this name, which the command must have, was given. */
static inline bool has_argument(const struct arguments *arguments, const char *name)
{
    return argument_value(arguments, name)->count > 0;
}

/* Returns the text of the argument of this name, which the command must have, or an empty text if
 * it was not given. */
struct text argument_text(const struct arguments *arguments, const char *name);

/* Returns the value of an argument that a module adds to the command, or NULL if it was not given
 * or the module is left out. */
const struct argument_value *added_argument(const struct arguments *arguments, const char *name);

/* ---- parsing ---- */

/* State of parsing a statement; readers move `rest` forward. */
struct parser {
    struct session *session;
    const struct expr_scope *scope;
    struct arena *arena;
    struct text rest; /* Remaining text of the statement. */
};

/* Reads a word, up to a blank or one of `stops`, or a quoted string: item->is_string tells which.
 * Returns false with `error` set. */
bool parse_word(struct parser *parser, const char *stops, struct item *item, struct error *error);
/* Returns the text before the first option, so that `1 --force` is not read as a subtraction. */
struct text before_option(struct text text);
/* Reads EXPR [+- EXPR] [UNIT] of the quantity `wanted`, or of any with QUANTITY_OTHER; `what` names
 * the value in messages. Returns false with `error` set. */
bool parse_value(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
/* Reads FROM:TO, either of which may be missing, into item->range. Returns false with `error` set.
 */
bool parse_range(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
/* Reads WIDTHxHEIGHT of a picture into item->range [m]; in cm without a unit. Returns false with
 * `error` set. */
bool parse_sides(struct parser *parser, const char *what, const char *stops, struct item *item,
                 struct error *error);
/* Reads an integer, > 0 unless `negative`. Returns false with `error` set. */
bool parse_integer(struct parser *parser, const char *what, bool negative, struct item *item,
                   struct error *error);
/* Returns true if no text remains. Otherwise sets an error with the likely reason: decimal comma,
 * unknown unit, one word too many. `number` is the last item read, or NULL if it was no number. */
bool refuse_rest(const struct parser *parser, const struct item *number, struct error *error);
/* Reads all arguments of a command from the parser. Returns false with `error` set. */
bool parse_arguments(struct parser *parser, const struct command *command,
                     struct arguments *arguments, struct error *error);
/* Returns the row of this name; for statements typed at a prompt also the only row whose name
 * begins so. NULL if there is none. */
const struct row *catalog_choose(const struct session *session, const struct catalog *catalog,
                                 struct text name);
/* Returns false, with `error` set, if the name is that of a row of a module that this build leaves
 * out. */
bool choice_is_in(const struct catalog *catalog, struct text name, struct error *error);

/* Reads the value of a setting from the parser into `settings`. Returns false with `error` set. */
bool setting_read(const struct setting *setting, struct parser *parser, struct settings *settings,
                  struct error *error);

/* ---- the series that arguments refer to ---- */

/* Replaces the series of a subject by that of another column of its run, in the same window.
 * Returns false, with `error` set, for a recording or an unknown column. */
bool subject_column(struct subject *subject, const struct argument_value *column,
                    const struct argument_value *window, struct arena *arena, struct error *error);
/* Opens the run or recording that was given, else the latest, within a window (TYPE_RANGE); any of
 * the three may be NULL. With `energy` the series is the energy. Returns false, with `error` set,
 * if there are fewer than `min` samples. Memory is the arena's. */
bool subject_open(struct session *session, const struct argument_value *run,
                  const struct argument_value *data, const struct argument_value *window,
                  bool energy, size_t min, struct arena *arena, struct subject *subject,
                  struct error *error);

/* ---- words of commands ---- */

/* Choices of arguments, struct row in the order of the constants below. */
extern const struct catalog separator_catalog, decimal_catalog, quantity_catalog, show_catalog,
    list_catalog;

/* Characters that the rows of separator_catalog and decimal_catalog stand for. */
static const char separator_letters[] = "\t,; ";
static const char decimal_letters[] = ".,";

/* Quantities of `measure`: rows of quantity_catalog. */
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

/* Topics of `show`: rows of show_catalog. */
enum show_topic { SHOW_ALL, SHOW_SCENE, SHOW_RUN, SHOW_DATA, SHOW_PLOT, SHOW_FILES };

/* Kinds of `list`: the first rows of list_catalog. */
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

/* A row of list_catalog. Kinds of modules follow those of the enum. */
struct list_kind {
    struct row row;
    /* Lists the items of a module's kind. Returns false if out of memory. NULL for kinds of the
     * enum. */
    bool (*list)(struct session *session, struct arena *arena, struct reply *reply);
};
