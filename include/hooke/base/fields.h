/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * fields: structs saved as named fields, so that a program whose struct has more members, or
 * another order of members, can still read the file.
 *
 * A field is the length of its name (1 byte), the name, the length of its value (4 bytes) and the
 * value; numbers have the byte order of the machine. To write, call field_put(), field_text() and
 * fields_put() in any order; a field that contains fields lies between field_begin() and
 * field_end(). To read, look fields up by name. Texts that readers return are slices of the bytes
 * read.
 */
#pragma once

#include <hooke/base/limit.h>
#include <hooke/base/text.h>

struct catalog;

/* Describes one member of a struct for writing and reading; it must not contain pointers. Because a
 * file may hold any bytes, readers accept only bools that are 0 or 1, texts that end within their
 * member and, if least < most, numbers from `least` to `most`. */
struct field {
    /* Name of the field in files. */
    const char *name;
    /* Offset and size [byte] of the member in its struct. */
    size_t offset, bytes;
    /* Kind of the values; a plural stands for one value or an array of them. */
    enum field_kind {
        /* Bytes without any check. */
        FIELD_BYTES,
        FIELD_BOOLS,
        FIELD_TEXT, /* Text in an array of char, written without the zeros at its end. */
        FIELD_INTS,
        FIELD_UNSIGNED, /* Unsigned integers and enums. */
        FIELD_INT64S,
        FIELD_UINT64S,
        FIELD_REALS,
        /* An enum quantity, written by its name; an unknown name is read as QUANTITY_OTHER. */
        FIELD_QUANTITY
    } kind;
    /* Range of allowed numbers; any number is allowed unless least < most. */
    double least, most;
};

/* The enum field_kind for the type of a member. */
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
/* Initialisers of a struct field for a member of `type`. FIELD_CALLED_AS takes the field's name,
 * the kind and the range; FIELD_CALLED derives the kind from the member's type; FIELD_IN takes the
 * member's name as the field's; FIELD_OF has no range either. */
#define FIELD_CALLED_AS(name, type, member, kind, least, most)                                     \
    {                                                                                              \
        name, offsetof(type, member), sizeof(((type *)0)->member), kind, least, most               \
    }
#define FIELD_CALLED(name, type, member, least, most)                                              \
    FIELD_CALLED_AS(name, type, member, FIELD_KIND(((type *)0)->member), least, most)
#define FIELD_IN(type, member, least, most) FIELD_CALLED(#member, type, member, least, most)
#define FIELD_OF(type, member) FIELD_IN(type, member, 0, 0)
#define FIELD_OF_QUANTITY(type, member) FIELD_CALLED_AS(#member, type, member, FIELD_QUANTITY, 0, 0)

/* Writers append one field to `output`; a failed allocation sets output->failed. field_put() writes
 * `bytes` bytes of any value. */
void field_put(struct buffer *output, const char *name, const void *value, size_t bytes);
/* Appends a field whose value is a text. */
void field_text(struct buffer *output, const char *name, struct text value);
/* Begins a field whose value is everything that is appended before field_end(). Returns the
 * position that field_end() needs. */
size_t field_begin(struct buffer *output, const char *name);
/* Ends the field that field_begin() began; `begun` is the value that it returned. */
void field_end(struct buffer *output, size_t begun);
/* Appends a field for each of the `count` described members of `object`. */
void fields_put(struct buffer *output, const struct field *field, size_t count, const void *object);

/* Finds the first field of this name in `text`, which is a sequence of fields; *value is its slice
 * of `text`. Returns false if the field is missing or the bytes are damaged. */
bool field_find(struct text text, const char *name, struct text *value);
/* Moves the first field of *text to *name and *value, both slices of it. Returns false if there is
 * no further field or if it is damaged. */
bool field_next(struct text *text, struct text *name, struct text *value);
/* Copies the value of the first field of this name in `text` to `target`. Returns false,
 * with *target unchanged, if the field is missing or does not have exactly `bytes` bytes. */
bool field_get(struct text text, const char *name, void *target, size_t bytes);
/* Reads the `count` members that field [count] describes from the fields in `text` into `object`.
 * Returns false if one is missing, has another length or has a value that is not allowed; members
 * before that one have then been changed. */
bool fields_get(struct text text, const struct field *field, size_t count, void *object);
/* Reads those of the `count` described members whose fields are in `text` with the right length
 * into `object`; the others keep their values. Returns false if one has a value that is not
 * allowed. */
bool fields_get_known(struct text text, const struct field *field, size_t count, void *object);
/* Returns true if the values of all described members of `object` are allowed. */
bool fields_sound(const struct field *field, size_t count, const void *object);

/* Maps rows of a catalog to items of an array in a file that has one item per row. The file lists
 * the names of its rows, so that a program whose catalog has more rows, or another order, finds
 * them. Made by field_find_places(), used by field_get_placed(). */
struct field_places {
    int rows, count; /* Number of rows of the catalog, and of items in the file. */
    /* [rows] index of the row's item in the file, or -1 if the file has none. */
    int index[LIMIT_PARAMETERS];
    /* [count] index of an item's row in the catalog, or -1 if the catalog has none. */
    int row[LIMIT_PARAMETERS];
};

/* Appends a field with the names of all rows of the catalog, each ended by a NUL. */
void field_put_names(struct buffer *output, const char *name, const struct catalog *catalog);
/* Fills *places from `names`, the value of a field that field_put_names() wrote. Returns false if
 * the value is damaged or has too many names. */
bool field_find_places(struct text names, const struct catalog *catalog,
                       struct field_places *places);
/* Finds the field of this name in `text`, whose value is an array of items of `item` bytes each in
 * the order of the file, and copies them to target [places->rows] in the order of the catalog; rows
 * that the file does not have keep their values. Returns false, and copies nothing, if the field is
 * missing or has another length. */
bool field_get_placed(struct text text, const char *name, const struct field_places *places,
                      void *target, size_t item);

/* Returns a checksum of bytes. Different contents have the same sum with probability 2^-64; the sum
 * does not detect deliberate forgery. */
uint64_t bytes_sum(struct text bytes);
