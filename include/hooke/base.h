/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * base: text, errors, memory, catalogs, numbers, units, files, cancellation.
 *
 * Knows nothing of physics. Nothing here prints, exits, touches signals or keeps state between
 * calls; base/child.h makes processes.
 */
#ifndef HOOKE_BASE_H
#define HOOKE_BASE_H

#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <hooke/base/limit.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
/* As double: the float of <math.h> would trip -Wdouble-promotion at every use. */
#undef NAN
#define NAN (__builtin_nan(""))
#undef INFINITY
#define INFINITY (__builtin_inf())

#define PRINTF_LIKE(position, first) __attribute__((__format__(__printf__, position, first)))

/* ---- text: a slice that somebody else owns ---- */

struct text {
    const char *at; /* not NUL-terminated */
    size_t len;     /* [byte] */
};

#define TEXT(literal) ((struct text){(literal), sizeof(literal) - 1})

struct text text_of(const char *z); /* NULL gives the empty text */
bool text_equal(struct text a, struct text b);
bool text_is(struct text a, const char *z);
bool text_starts(struct text a, struct text prefix);
struct text text_trim(struct text a);              /* without blanks, tabs, CR at both ends */
struct text text_last_component(struct text path); /* behind the last / */
/* Returns what follows the last point of a file's name; nothing where it has none but at its begin.
 */
struct text text_ending(struct text path);
/* cuts the head off; false: nothing left */
bool text_split(struct text *rest, char separator, struct text *head);

/* ---- memory ----
 *
 * An arena hands out memory that is freed all at once. Every function that allocates may return
 * NULL; the caller then reports error_memory() and leaves its object as it was.
 */

struct cancel;

struct arena {
    struct arena_block *blocks;
};

/* zeroed, aligned for any type; NULL: no memory */
void *arena_alloc(struct arena *arena, size_t size);
void *arena_array(struct arena *arena, size_t count, size_t size); /* overflow-checked */
char *arena_text(struct arena *arena, struct text text);           /* NUL-terminated copy */
void arena_reset(struct arena *arena); /* frees everything; the arena can be used again */
/* All that `from` has handed out belongs to `to`. */
void arena_move(struct arena *from, struct arena *to);
/* The same as arena_reset() until it is stopped: gigabytes take 0.1 s. */
void arena_give_back(struct arena *arena, const struct cancel *cancel);

/* Text that grows. After a failed allocation `failed` is set and later writes are ignored: check
 * once at the end. */
struct buffer {
    char *data; /* always NUL-terminated when not NULL */
    size_t len, cap;
    bool failed;
};

void buffer_put(struct buffer *buffer, struct text text);
void buffer_char(struct buffer *buffer, char c);
void buffer_codepoint(struct buffer *buffer, uint32_t codepoint); /* as UTF-8 */
void buffer_format(struct buffer *buffer, const char *format, ...) PRINTF_LIKE(2, 3);
void buffer_vformat(struct buffer *buffer, const char *format, va_list args) PRINTF_LIKE(2, 0);
void buffer_base64(struct buffer *buffer, struct text bytes); /* RFC 4648, on one line */
void buffer_clear(struct buffer *buffer);
void buffer_free(struct buffer *buffer);
struct text buffer_text(const struct buffer *buffer);
/* A NUL-terminated view; "out of memory" if the buffer has failed, never NULL. */
const char *buffer_view(const struct buffer *buffer);

/* ---- shared libraries, looked up when they are needed ---- */

struct library {
    void *handle; /* NULL: not loaded */
};

struct library_symbol {
    const char *name;
    size_t offset; /* [byte] of the function pointer in the table */
};

/* Finds `count` functions of the shared library `name` (as dlopen takes it) for the table. False:
 * there is no such library (*missing NULL), or it has no function *missing. Allocates inside of the
 * dynamic linker only. */
bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing);
void library_unload(struct library *library);

/* ---- errors ----
 *
 * A fallible function returns bool and fills a caller-owned error: a sentence for the user that
 * names the input and what is allowed. The values of the codes are the exit statuses of the
 * program.
 */

enum error_code {
    ERROR_NONE = 0,
    ERROR_COMMAND = 1,    /* the request makes no sense or is refused */
    ERROR_USAGE = 2,      /* bad option, script not readable */
    ERROR_NUMERICAL = 3,  /* diverged, did not converge */
    ERROR_IO = 4,         /* no such data file, malformed data, cannot write */
    ERROR_CANCELLED = 130 /* stopped by Ctrl-C */
};

struct error {
    enum error_code code;
    char text[600];    /* one sentence, lower case, no final full stop */
    char hint[300];    /* what to do, or "" */
    struct text where; /* the part of the caller's input that is meant; at == NULL: none */
};

/* All return false, so that `return error_set(…)` reads well. */
bool error_set(struct error *error, enum error_code code, const char *format, ...)
    PRINTF_LIKE(3, 4);
/* ERROR_COMMAND */
bool error_at(struct error *error, struct text where, const char *format, ...) PRINTF_LIKE(3, 4);
/* adds the hint to an error already set */
bool error_hint(struct error *error, const char *format, ...) PRINTF_LIKE(2, 3);
bool error_memory(struct error *error); /* "out of memory …" */
/* "command", "usage", "numerical", "io", "cancelled": the JSON `code` */
const char *error_name(enum error_code code);

/* ---- catalogs: everything that can be chosen by name is a row in a table ----
 *
 * Every row struct starts with a struct row; find, completion, help and suggestions are written
 * once, here.
 */

struct row {
    const char *name;     /* what users type */
    const char *unit;     /* unit of its value, "" if none */
    const char *brief;    /* one line for lists */
    const char *citation; /* author year equation, or "" */
    const char *alias;    /* other names, separated by blanks, or NULL */
};

struct catalog {
    const char *kind; /* "parameter", "method", …: used in messages */
    const void *rows;
    size_t count, stride;
    const struct row
        *absent; /* names that this build was made without; the brief says why and what to do */
    size_t absences;
};

#define CATALOG(kind_name, array)                                                                  \
    {                                                                                              \
        (kind_name), (array), COUNT_OF(array), sizeof((array)[0]), NULL, 0                         \
    }

const struct row *catalog_row(const struct catalog *catalog, size_t i);
int catalog_index(const struct catalog *catalog, const struct row *row); /* index of a row of it */
/* exact name or alias; NULL: none */
const struct row *catalog_find(const struct catalog *catalog, struct text name);
/* Exact, else the only row whose name starts with `name` (at least `min` letters). NULL: none or
 * ambiguous. */
const struct row *catalog_prefix(const struct catalog *catalog, struct text name, size_t min);
/* Of a name that this build was made without: says so; returns whether it did. */
bool catalog_absent(const struct catalog *catalog, struct text name, struct error *error);
/* "unknown KIND 'name'" with up to three suggestions ("did you mean …?") in the hint; always
 * returns false. */
bool catalog_unknown(const struct catalog *catalog, struct text name, struct error *error);

/* Optimal string alignment distance (Damerau–Levenshtein with adjacent transpositions), bytes;
 * beyond LIMIT_NAME: the length. */
int text_distance(struct text a, struct text b);

/* Suggestions over any set of names: offer candidates one by one, then read the best (INTERFACE.md
 * section 10). */
struct suggestion {
    struct text wanted;
    int distance[3];
    char name[3][64];
    int count;
};

void suggestion_offer(struct suggestion *suggestion, const char *name);
/* appends nothing when none is near */
void suggestion_hint(const struct suggestion *suggestion, struct error *error);

/* ---- numbers ----
 *
 * One reader and one writer, independent of the locale. The reader rounds correctly; hexadecimal,
 * nan and inf, trailing garbage, overflow and a decimal comma are refused. The writer gives the
 * shortest decimal that reads back to the same double (at most 17 digits, plain for 1e-4 <= |x| <
 * 1e17, else 1.5e-7), `nan`, `inf`, `-inf` for the rest.
 */

#define REAL_TEXT_SIZE 32

enum real_status {
    REAL_OK,
    REAL_EMPTY,
    REAL_MALFORMED,
    REAL_OVERFLOW,
    REAL_UNDERFLOW /* value is kept (denormal or 0) */
};

/* Reads the longest number at the start of `text`; *used [byte] says how long it was (0: none).
 * `decimal` is '.' or
 * ','. */
enum real_status real_scan(struct text text, char decimal, double *value, size_t *used);
/* the whole text is the number, decimal point */
enum real_status real_parse(struct text text, double *value);
size_t real_format(double value, char out[REAL_TEXT_SIZE]); /* length without the NUL */
void buffer_real(struct buffer *buffer, double value);      /* shortest round trip */
/* for people: `digits` significant, no trailing zeros */
void buffer_short(struct buffer *buffer, double value, int digits);
/* "1.9373 +- 0.0002": the uncertainty to 1 digit (2 if it starts with 1), the value to match; no
 * uncertainty: 6 digits.
 */
void buffer_uncertain(struct buffer *buffer, double value, double uncertainty);
/* A phase [rad] in degrees; from a whole turn on the turns apart: "381 turns + 204.9 deg". "-"
 * where not finite. */
void buffer_phase(struct buffer *buffer, double radians);

/* A measured number. uncertainty: one standard uncertainty, >= 0, NAN if unknown. */
struct measured {
    double value, uncertainty;
};

/* ---- statements (statement.c) ---- */

/* Cuts the next statement off a line; comments are dropped. False: nothing is left. error: a quote
 * that does not end.
 */
bool next_statement(struct text *line, struct text *statement, struct error *error);
bool is_name_start(char c);
bool is_name_char(char c);
void text_skip_blanks(struct text *text);
/* The word at the start, up to a blank, quote, semicolon or one of `stops`. */
struct text peek_word(struct text text, const char *stops);
/* The name at the start: letter, then letters, digits, _ and -; empty if there is none. */
struct text peek_name(struct text text);
/* Bytes of the string that starts at text.at[0], both quotes included; 0: it does not end. */
size_t text_quoted(struct text text);

/* ---- units ----
 *
 * A closed table. A quantity is a kind of number (mass, length …); a unit belongs to one quantity
 * and has a factor to SI.
 */

enum quantity {
    QUANTITY_NUMBER,
    QUANTITY_LENGTH,
    QUANTITY_MASS,
    QUANTITY_TIME,
    QUANTITY_FORCE,
    QUANTITY_STIFFNESS,
    QUANTITY_CUBIC_STIFFNESS,
    QUANTITY_RATE,
    QUANTITY_MASS_RATE,
    QUANTITY_VELOCITY,
    QUANTITY_ACCELERATION,
    QUANTITY_AREA,
    QUANTITY_DENSITY,
    QUANTITY_VISCOSITY,
    QUANTITY_ANGLE,
    QUANTITY_ANGULAR_FREQUENCY,
    QUANTITY_ANGULAR_ACCELERATION,
    QUANTITY_FREQUENCY,
    QUANTITY_ENERGY,
    QUANTITY_POWER,
    QUANTITY_VOLTAGE,
    QUANTITY_OTHER,
    QUANTITY_COUNT
};

struct unit {
    struct row row; /* name "cm", unit: the SI name "m" */
    enum quantity quantity;
    double factor; /* value in SI = number * factor, up to rounding: convert with unit_convert */
    enum unit_use {
        UNIT_READ,  /* understood, never chosen for display */
        UNIT_SHOWN, /* chosen for display by size */
        UNIT_HOME   /* chosen by size, and for zero */
    } use;
};

extern const struct catalog unit_catalog;

const char *quantity_name(enum quantity quantity); /* "mass" */
/* How often a position or an angle is differentiated to give it: 0, 1, 2; -1: it is none of a
 * motion. */
int quantity_order(enum quantity quantity);
const char *quantity_article(enum quantity quantity); /* "a" mass, "an" angle */
const char *quantity_unit(enum quantity quantity);    /* SI unit "kg", "" for a pure number */
void quantity_units(enum quantity quantity, struct buffer *names); /* "kg, g, mg" */
/* longest unit at the start of text (not followed by a letter); NULL: none */
const struct unit *unit_match(struct text text);
const struct unit *unit_find(struct text name); /* exact name */
/*
 * The one place that decides whether a unit fits a quantity: its own, and Hz for rad/s or back by 2
 * pi. Decimal factors are exact: 5.7 cm gives the double nearest to 0.057.
 */
bool unit_convert(const struct unit *unit, enum quantity wanted, double number, double *si);
/* The unit that shows `value` (SI) with 1 to 999 before the point where there is one: 0.2 kg as g,
 * 0.05 m as cm. */
const struct unit *unit_display(enum quantity quantity, double value);
/* "200 g", "5 cm", "15 N/m": `digits` significant. Never writes a decimal that reads back
 * differently if digits is 0 (shortest). */
void buffer_quantity(struct buffer *buffer, double value, enum quantity quantity, int digits);

/* ---- text that came from outside ----
 *
 * Appends `text` with everything that could command a terminal made visible: C0, DEL, C1, invalid
 * UTF-8, line and paragraph separators, bidirectional and zero-width controls become \xNN or
 * <U+NNNN>. Newline and tab too, unless keep_layout.
 */
void safe_text(struct buffer *out, struct text text, bool keep_layout);
#define SAFE_NAME_SIZE 160
/* A name from outside for use inside a message: made visible as by safe_text, long ones cut with
 * "...". Returns `out`. */
const char *safe_name(struct text name, char out[SAFE_NAME_SIZE]);
/* "No space left on device", in English whatever the locale. */
const char *system_message(int number);
/* no letter: steers how the rest is shown, or is not seen at all (from U+0080) */
bool codepoint_hidden(uint32_t codepoint);

#define CODEPOINT_INVALID 0xFFFDu /* the replacement character */

/* UTF-8: decodes one code point from the start of text (CODEPOINT_INVALID with *used = 1 for an
 * invalid byte). */
uint32_t text_codepoint(struct text text, size_t *used);
/* columns on a terminal: 0, 1 or 2; a table of its own, no locale */
int codepoint_width(uint32_t codepoint);
int text_width(struct text text); /* columns */
/* What of a line is shown where there is room for `width` columns: whole items (between commas,
 * colons, bars, double blanks), or, where those would leave less than half, whole words; `cut`:
 * then the sentence goes on, and there is room for a blank and a mark. */
struct text text_in_room(struct text text, int width, bool *cut);
/* Appends the words of a text in lines of at most `width` columns, without the last newline. */
void buffer_folded(struct buffer *buffer, struct text text, int width);

/* ---- files ----
 *
 * Reading: appends the whole file, up to `limit` bytes, from regular files, pipes and links; a
 * failure leaves `content` as it was, a signal ends it with ERROR_CANCELLED (its handler must be
 * without SA_RESTART). Writing: into an unnamed temporary file of the same folder, put in place by
 * writer_commit after flush, fsync and close all succeeded. An existing name is refused without
 * `force`; a link, a directory or a device is never written through. A killed program leaves the
 * old file or none.
 */

bool file_read(const char *path, size_t limit, struct buffer *content, struct error *error);

/* Looks at what is read, as it comes in, so that a file that is not wanted costs no more than its
 * beginning. */
struct read_watch {
    void *context;
    /* After every piece: what there is by now, where the piece begins, and the size [byte] that the
     * file states; 0: it states none. False: no more of it, and the error is set. */
    bool (*look)(void *context, struct text content, size_t from, uintmax_t size,
                 struct error *error);
    /* [ns] that what may have no end (a pipe, a device) gets to end in, unless it is fast; 0: for
     * ever, also a terminal */
    int64_t patience;
    bool grew; /* set: more was written to the file meanwhile; content is what there was at first */
    bool endless; /* set: why it was refused */
};

/* What is read there is standard input itself, whatever it is. */
#define STANDARD_INPUT "/dev/stdin"

/* The same, watched. */
bool file_read_watched(const char *path, size_t limit, struct read_watch *watch,
                       struct buffer *content, struct error *error);

#define STRAY_NAME_SIZE 256                /* [byte] of a hidden name */
enum { STRAY_NEW = '.', STRAY_OLD = '~' }; /* is to come; is to go, once the new one is there */

/* ".hooke-" with a random number, `mark` and as much of `base` as fits: beside what it stands for,
 * and locked as long as somebody writes it. */
bool stray_name(char name[STRAY_NAME_SIZE], const char *base, char mark);
/* Removes what killed programs have left under such names in a folder. */
void strays_sweep_path(const char *path);

struct writer {
    int fd, folder;                  /* -1: closed */
    char *path;                      /* as the user gave it */
    char *base;                      /* last component (points into path) */
    char temporary[STRAY_NAME_SIZE]; /* name in the folder, "" while unnamed */
    bool force, failed;
    char *chunk; /* write-behind buffer */
    size_t used;
    int failure; /* errno of the first failure */
};

struct write_policy {
    bool force;   /* replace an existing regular file */
    bool confine; /* only below the current directory (--safe) */
    bool refuse;  /* nothing at all */
    bool secret;  /* a folder that only the user may look into */
};

bool writer_open(struct writer *writer, const char *path, struct write_policy policy,
                 struct error *error);
/* a failure is remembered and reported by commit */
void writer_put(struct writer *writer, struct text text);
bool writer_commit(struct writer *writer, struct error *error); /* closes in every case */
void writer_abandon(struct writer *writer);
/* All three in one. */
bool file_write(const char *path, struct text content, struct write_policy policy,
                struct error *error);

/* All of it, going on after signals and after a part; 0 or an errno, *text: what is left. */
int file_put(int fd, struct text *text);
/* The whole file for this program, until it is closed. wait: for another one, 0.2 s at most; a
 * signal ends it. */
bool file_lock(int fd, bool wait);
void file_unlock(int fd);

/*
 * A file that grows by whole lines. It is opened in the folder that was looked at, never through a
 * link, a pipe or a device; `mode` is for a new one. -1: the error says why.
 */
int append_open(const char *path, struct write_policy policy, unsigned mode, struct error *error);
/* At the end; sync: and on the disk. False: the file ends as before, and the error says why,
 * without the file's name. */
bool append_lines(int fd, struct text lines, bool sync, struct error *error);

/*
 * A folder of files, whole or not at all: filled under a hidden name beside its own, which
 * folder_commit gives it after every file is on the disk. An existing folder is refused without
 * `force`, and with it unless all that it holds are regular files whose names are its `own`;
 * nothing else is ever removed. A killed program leaves the old folder, the new one or none, and
 * maybe a hidden one beside it, which goes (or back to its place) when the next one begins.
 */
typedef bool folder_owns(const char *name);

struct folder {
    struct writer at; /* where it goes */
    int fd;           /* -1: closed */
    folder_owns *own;
};

/* Trailing slashes in the path do not matter. */
bool folder_open(struct folder *folder, const char *path, struct write_policy policy,
                 folder_owns *own, struct error *error);
bool folder_put(struct folder *folder, const char *name, struct text content, struct error *error);
bool folder_commit(struct folder *folder, struct error *error); /* closes in every case */
void folder_abandon(struct folder *folder);

/* ---- cancellation ----
 *
 * Set from a signal handler or another thread; long work asks between slices of at most 50 ms:
 * make CONFIG=watch builds a program that ends where it does not.
 */
struct cancel {
    atomic_int requested;
};

#ifdef HOOKE_WATCH
void watch_look(void);
#else
#define watch_look() ((void)0)
#endif

#define LOOK_EACH_ROWS 16384 /* rows between two looks, of what takes 1 us a row at most */

static inline bool cancelled(const struct cancel *cancel)
{
    if (cancel)
        watch_look();
    return cancel && atomic_load_explicit(&((struct cancel *)(uintptr_t)cancel)->requested,
                                          memory_order_relaxed) != 0;
}

/* The look of a loop, at its row i. */
static inline bool cancelled_at(const struct cancel *cancel, size_t i)
{
    return i % LOOK_EACH_ROWS == 0 && cancelled(cancel);
}

/* ---- limits ---- */

struct limit {
    struct row row; /* name, unit, brief */
    double value;
};

extern const struct catalog limit_catalog;

/* Wall clock that only goes forward [ns]. */
int64_t clock_ns(void);
double clock_seconds(int64_t begin); /* [s] since then [ns] */
int64_t clock_cpu_ns(void);          /* that this thread has used */

#endif
