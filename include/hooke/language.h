/* SPDX-License-Identifier: GPL-3.0-or-later */
/* language: the arguments of commands. Rows of commands describe them (struct command, struct
 * argument), and parsing makes a struct arguments. parse_arguments() reads all arguments of a
 * statement by the types in the command's row; handlers get the values by argument_value(),
 * has_argument() and argument_text(). */
#pragma once

#include <hooke/result.h>
#include <hooke/session/subject.h>

struct unit;

/* ---- how the arguments of a command are described ---- */

/* Form of an argument in a statement. */
enum argument_form {
    FORM_PLACE,  /* Positional, such as DURATION. */
    FORM_WORD,   /* NAME item, such as `to T` or `run N`. */
    FORM_KEY,    /* NAME=item, such as dt=1ms. */
    FORM_OPTION, /* --NAME [item], such as --force. */
};

/* Types of arguments: TYPE_VALUE, TYPE_CHOICE, …, the rows of src/language/types.def. */
enum argument_type {
#define ARGUMENT_TYPE(name, ...) TYPE_##name,
#include "language/types.def"
};

/* Properties of types, combined by |. */
enum type_flag {
    TYPE_IS_NUMBER = 1,     /* The item is a number, after which a blank must follow. */
    TYPE_GOES_ON = 2,       /* The item is an expression, which may contain blanks. */
    TYPE_HAS_QUANTITY = 4,  /* The value has the quantity of its struct argument. */
    TYPE_SHOWS_CHOICES = 8, /* The line of usage shows the choices if they are few. */
    TYPE_SHOWS_BOTH = 16,   /* The line of usage shows the choices and the general form. */
    /* Several items may follow a FORM_WORD, which is not repeated. */
    TYPE_IS_LIST = 64,
    /* A word that is a choice of a positional argument is read as this choice even if the command
     * also has a FORM_WORD of that name, as in `measure energy`. */
    TYPE_BEFORE_WORDS = 128,
    /* A positional argument that may be left out: a word that is no item of the type is read as the
     * next positional argument. */
    TYPE_MAY_BE_SKIPPED = 256,
    /* A positional argument of this type accepts NAME=…, with a NAME that no FORM_KEY of the
     * command has: NAME is the item, and the text after it is that of the next argument, as in
     * `let NAME = VALUE`. */
    TYPE_BEFORE_EQUALS = 512,
    TYPE_IS_ANY_KEY = 1024, /* The argument accepts NAME=item with any name. */
    TYPE_IS_FILE = 2048,    /* The item is the name of a file. */
    TYPE_TAKES_REST = 4096, /* The item is all remaining text of the statement. */
    TYPE_IS_FORMULA = 8192, /* The item is a formula. */
};

/* Properties of arguments, combined by |. */
enum argument_flag {
    ARG_REQUIRED = 1, /* The argument must be given. */
    /* Several items may be given: separated by blanks or commas if positional or after a word, by
     * commas after a key. */
    ARG_MANY = 2,
    ARG_ALL = 4, /* The word `all` stands for every run. */
    /* A TYPE_COLUMN may name a column of a table: any word, if the word `of` and the name of the
     * table follow, as in `plot error of compare`. */
    ARG_OF = 16,
    ARG_NEGATIVE = 8, /* A TYPE_INTEGER or TYPE_VALUE may be negative or zero. */
};

/* Description of an argument, in the row of its command. */
struct argument {
    enum argument_form form;
    /* Name in usage and messages, such as "DURATION", for FORM_PLACE. Other forms have the word
     * that users type, such as "to", "dt" or "force". */
    const char *name;
    enum argument_type type;
    /* Type that a module defines, in place of `type`; or NULL. */
    const struct argument_type_row *own_type;
    /* Flags of enum argument_flag. */
    unsigned flags;
    /* Quantity of the value; QUANTITY_OTHER accepts any. */
    enum quantity quantity;
    /* Choices of a TYPE_CHOICE. */
    const struct catalog *choices;
    const char *lead; /* Word that may precede the argument, such as "of", or NULL. */
    const char *more; /* Text that follows in the line of usage, "[from LABEL]", or NULL. */
    int group;        /* Arguments of the same group (not 0) exclude each other. */
};

/* Largest number of arguments of a command. */
#define ARGUMENTS_MAX 24

struct parser;
struct item;
struct completion;

/* A type of arguments. */
struct argument_type_row {
    const char *name, /* Name of the type, such as "RANGE". */
        *shown;       /* Form of an item in the line of usage, such as "FROM:TO". */
    /* Reads one item at the beginning of parser->rest, up to a blank or a character of `stops`, and
     * removes the item from it. Returns false with `error` set. */
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

/* Returns true if the argument's type has at least one of these flags of enum type_flag. */
static inline bool type_is(const struct argument *argument, unsigned flags)
{
    return (argument_type(argument)->flags & flags) != 0;
}

/* ---- commands ---- */

/* Properties of commands, combined by |. */
enum command_flag {
    COMMAND_CHANGES = 1,    /* May change what undo restores, so that a snapshot is taken before. */
    COMMAND_UNRECORDED = 2, /* Not written by `record`. */
    COMMAND_ANYTIME = 4,    /* Allowed during a live run, which it does not disturb. */
    /* Executes other statements, each with an entry of its own in the history. */
    COMMAND_NESTS = 8,
    /* Allowed among the commands of an event, although it changes the session. */
    COMMAND_IN_EVENTS = 16,
    COMMAND_STARTS = 32, /* Starts a run; conditions among the arguments refer to this run. */
    /* The one command that executes statements NAME = VALUE. */
    COMMAND_ASSIGNS = 64,
    /* The one command that executes statements NAME' = EXPR, except during a run. */
    COMMAND_EQUATES = 128,
    /* The one command that executes NAME' = EXPR during a run: the variable jumps to the value. */
    COMMAND_JUMPS = 256,
    COMMAND_TABLES = 512, /* The result is a table, which `> FILE` writes. */
    /* Allowed in a saved session although undo does not take it back; commands with COMMAND_CHANGES
     * are allowed there anyway. */
    COMMAND_RESTORES = 1024,
    COMMAND_BESIDE = 2048, /* Allowed while a recording is collected. */
};

/* Candidates that are offered as completions of the text after a command's name. */
enum completes {
    COMPLETES_ARGUMENTS, /* Those of the command's arguments, by their types. */
    COMPLETES_GRID,      /* NAME=FROM:TO of a parameter, dt or tol. */
    COMPLETES_TOPICS,    /* Topics of help. */
    COMPLETES_ATOL,      /* Variables, then values, of `atol`. */
    COMPLETES_KINDS,     /* Kinds of lists; after `list methods` kinds of methods. */
    COMPLETES_SHOWN,     /* Topics of `show`, and names that have a value. */
    COMPLETES_VALUES,    /* A name that `set` can change, then its units or choices. */
    COMPLETES_EQUATION,  /* NAME' = EXPR of `equation`. */
    COMPLETES_VARIABLE,  /* NAME = VALUE [UNIT] of `var`. */
    COMPLETES_PARAMETER, /* NAME = VALUE [UNIT] of `param`. */
    COMPLETES_OBSERVED,  /* NAME = EXPR of `observe`. */
    COMPLETES_FORCE,     /* EXPR, or `off`, of `force`. */
    COMPLETES_POTENTIAL, /* EXPR of `potential`. */
    COMPLETES_EVENT,     /* The rule of an event. */
};

struct arguments;

/* A command: a row of command_catalog. */
struct command {
    struct row row;       /* Name, no unit, description, no source, aliases. */
    const char *group;    /* Heading under which help lists the command: "SCENE", "RUN", … */
    const char *text;     /* Text for help. */
    const char *examples; /* Two lines of examples. */
    const char *see;      /* Names of related commands, separated by blanks. */
    /* [arguments] descriptions of the arguments. */
    const struct argument *argument;
    int arguments;  /* Number of arguments. */
    unsigned flags; /* Flags of enum command_flag. */
    enum completes completes;
    /* Executes the command with its arguments `value`. Returns false, with `error` set and the
     * session unchanged, on failure. */
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

/* One item of an argument that was read. The argument's type decides which members are set. */
struct item {
    struct text text;        /* Text as typed, without quotes and escapes. */
    struct measured value;   /* Value [SI]; the uncertainty is 0 unless it was typed. */
    const struct unit *unit; /* Unit as typed, or NULL. */
    /* Quantity of the value, if the unit or a single name determines it; else QUANTITY_OTHER. */
    enum quantity quantity;
    bool is_string;        /* The text was quoted. */
    double range[2];       /* Ends of a range [SI], NAN if open. */
    const struct row *row; /* Row of a TYPE_CHOICE. */
    /* Index of a choice in its catalog, or of a run or recording in the session; -1 for the word
     * `all`. */
    int index;
    /* Compiled condition or expression, in the arena; NULL for other types. */
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
    const struct command *command; /* Command whose arguments these are. */
    struct text word;              /* Name of the command as typed; empty for an assignment. */
    struct argument_value value[ARGUMENTS_MAX]; /* Values in the order of command->argument. */
    const struct expr_scope *scope;             /* Names in conditions and expressions. */
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
    const struct expr_scope *scope; /* Names that expressions can use. */
    struct arena *arena;            /* Memory of items. */
    struct text rest;               /* Remaining text of the statement. */
};

/* Reads a word, which ends before a blank or a character of `stops`, or a quoted string, for which
 * item->is_string becomes true. Returns false with `error` set. */
bool parse_word(struct parser *parser, const char *stops, struct item *item, struct error *error);
/* Returns the part of the text before its first --option, so that `1 --force` is not read as a
 * subtraction. */
struct text before_option(struct text text);
/* Reads EXPR [+- EXPR] [UNIT] of the quantity `wanted`; QUANTITY_OTHER accepts any quantity. Here
 * and below `what` is the name of the value in messages. Returns false with `error` set. */
bool parse_value(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
/* Reads FROM:TO, either of which may be missing, into item->range. Returns false with `error` set.
 */
bool parse_range(struct parser *parser, const char *what, enum quantity wanted, struct item *item,
                 struct error *error);
/* Reads WIDTHxHEIGHT of a picture, up to a character of `stops`, into item->range [m]. Lengths
 * without a unit are in cm. Returns false with `error` set. */
bool parse_sides(struct parser *parser, const char *what, const char *stops, struct item *item,
                 struct error *error);
/* Reads an integer, which must be positive unless `negative` also allows 0 and negative ones.
 * Returns false with `error` set. */
bool parse_integer(struct parser *parser, const char *what, bool negative, struct item *item,
                   struct error *error);
/* Returns true if no text remains. Otherwise sets an error with the likely reason: decimal comma,
 * unknown unit, one word too many. `number` is the last item read, or NULL if it was no number. */
bool refuse_rest(const struct parser *parser, const struct item *number, struct error *error);
/* Reads all arguments of a command from the parser. Returns false with `error` set. */
bool parse_arguments(struct parser *parser, const struct command *command,
                     struct arguments *arguments, struct error *error);
/* Returns the row of this name or, for a statement typed at a prompt, the only row whose name
 * begins with `name`. Returns NULL if there is none. */
const struct row *catalog_choose(const struct session *session, const struct catalog *catalog,
                                 struct text name);
/* Returns false, with `error` set, if a module that this build leaves out would add a row of this
 * name to the catalog; else true. */
bool choice_is_in(const struct catalog *catalog, struct text name, struct error *error);

/* Reads the value of a setting from the parser into `settings`. Returns false with `error` set. */
bool setting_read(const struct setting *setting, struct parser *parser, struct settings *settings,
                  struct error *error);

/* ---- the series that arguments refer to ---- */

/* Replaces the series of a subject by that of another column of its run, in the same window.
 * Returns false, with `error` set, for a recording or an unknown column. */
bool subject_column(struct subject *subject, const struct argument_value *column,
                    const struct argument_value *window, struct arena *arena, struct error *error);
/* Fills *subject with the series of the run or recording that the arguments `run` and `data` name,
 * or of the latest one, within `window` (TYPE_RANGE). Each of the three arguments may be NULL. With
 * `energy` the series is the energy, else the position. Returns false, with `error` set,
 * if there are fewer than `min` samples. Memory is the arena's. */
bool subject_open(struct session *session, const struct argument_value *run,
                  const struct argument_value *data, const struct argument_value *window,
                  bool energy, size_t min, struct arena *arena, struct subject *subject,
                  struct error *error);

/* ---- words of commands ---- */

/* Choices of arguments: rows in the order of the letters and enums below. */
extern const struct catalog separator_catalog, decimal_catalog, quantity_catalog, show_catalog,
    list_catalog;

/* Characters at the index of the rows of separator_catalog and of decimal_catalog. */
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
    struct row row; /* Name of the kind, as in `list NAME`. */
    /* Replies with the items of a module's kind. Returns false if out of memory. NULL for kinds of
     * the enum. */
    bool (*list)(struct session *session, struct arena *arena, struct reply *reply);
};
