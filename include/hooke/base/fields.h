/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Bytes with names: what a file keeps of a struct, so that a program whose struct has grown, or has
 * its members in another order, still reads it. A field is one byte length of the name, the name,
 * four bytes length of the value, the value; numbers in the byte order of the machine.
 */
#pragma once

#include <hooke/base/limit.h>
#include <hooke/base/text.h>

struct catalog;

/*
 * A member of a struct that has no pointers in it. A file may hold any bytes: bools have to be 0 or
 * 1, texts end, and where least < most numbers stand between them.
 */
struct field {
    const char *name;
    size_t offset, bytes;
    enum field_kind {
        FIELD_BYTES,
        FIELD_BOOLS,
        FIELD_TEXT, /* written without the zeros at its end */
        FIELD_INTS,
        FIELD_UNSIGNED, /* enums, too */
        FIELD_INT64S,
        FIELD_UINT64S,
        FIELD_REALS,
        FIELD_QUANTITY /* an enum quantity, in files by its name; one that is unknown is another */
    } kind;
    double least, most;
};

#define FIELD_KIND(member)                                                                         \
    _Generic((member), bool                                                                        \
             : FIELD_BOOLS, bool *                                                                 \
             : FIELD_BOOLS, char *                                                                 \
             : FIELD_TEXT, int                                                                     \
             : FIELD_INTS, int *                                                                   \
             : FIELD_INTS, unsigned                                                                \
             : FIELD_UNSIGNED, unsigned *                                                          \
             : FIELD_UNSIGNED, int64_t                                                             \
             : FIELD_INT64S, uint64_t                                                              \
             : FIELD_UINT64S, double                                                               \
             : FIELD_REALS, double *                                                               \
             : FIELD_REALS, default                                                                \
             : FIELD_BYTES)
/* Describes the member, whose numbers lie between least and most. `name` is its name in a file. */
#define FIELD_CALLED_AS(name, type, member, kind, least, most)                                     \
    {                                                                                              \
        name, offsetof(type, member), sizeof(((type *)0)->member), kind, least, most               \
    }
#define FIELD_CALLED(name, type, member, least, most)                                              \
    FIELD_CALLED_AS(name, type, member, FIELD_KIND(((type *)0)->member), least, most)
#define FIELD_IN(type, member, least, most) FIELD_CALLED(#member, type, member, least, most)
#define FIELD_OF(type, member) FIELD_IN(type, member, 0, 0)
#define FIELD_OF_QUANTITY(type, member) FIELD_CALLED_AS(#member, type, member, FIELD_QUANTITY, 0, 0)

void field_put(struct buffer *output, const char *name, const void *value, size_t bytes);
void field_text(struct buffer *output, const char *name, struct text value);
/* One that holds fields: what is put between begin and end. Returns what end wants. */
size_t field_begin(struct buffer *output, const char *name);
void field_end(struct buffer *output, size_t begun);
void fields_put(struct buffer *output, const struct field *field, size_t count, const void *object);

/* Finds a field; *value points into `text`. Returns false if it is missing or damaged. */
bool field_find(struct text text, const char *name, struct text *value);
/* The next of the fields, which is taken off them. Returns false if there is no more. */
bool field_next(struct text *text, struct text *name, struct text *value);
/* Exactly so many bytes, else false and *target as it was. */
bool field_get(struct text text, const char *name, void *target, size_t bytes);
/* All of them, each as it may be, or false. */
bool fields_get(struct text text, const struct field *field, size_t count, void *object);
/* Reads those that the file has in this length, each as it may be; others keep their values.
 * Returns false if one that it has cannot be. */
bool fields_get_known(struct text text, const struct field *field, size_t count, void *object);
/* Returns true if each of the values that were read is within its limits. */
bool fields_sound(const struct field *field, size_t count, const void *object);

/*
 * Positions of a catalog's rows in arrays of a file that has one item per row. A program whose
 * catalog has grown, or has another order, finds its own rows by their names.
 */
struct field_places {
    int rows, count;             /* length of the catalog; number of items in the file */
    int index[LIMIT_PARAMETERS]; /* [rows] position in the file, or -1 if the file has none */
    int row[LIMIT_PARAMETERS];   /* [count] of an item in the file; -1 if there is no such row */
};

/* Writes the names that arrays are counted by, as a field of that name. */
void field_put_names(struct buffer *output, const char *name, const struct catalog *catalog);
/* Finds the rows among names that end with a NUL each. Returns false if these are damaged. */
bool field_find_places(struct text names, const struct catalog *catalog,
                       struct field_places *places);
/* Copies the items that the file has to the rows [rows], others keep their values. Returns false,
 * and copies nothing, if the array is missing or has another length. */
bool field_get_placed(struct text text, const char *name, const struct field_places *places,
                      void *target, size_t item);

/* A checksum of bytes: differs with all but 2^-64 of what chance makes of them. Not against malice.
 */
uint64_t bytes_sum(struct text bytes);
