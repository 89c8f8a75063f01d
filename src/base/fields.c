/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Named fields: members of structs written to files and read back, also by a program whose struct
 * has other members; and a checksum of bytes. */
#include <hooke/base/catalog.h>
#include <hooke/base/fields.h>
#include <hooke/base/unit.h>

#include <string.h>

/* ---- writing ---- */

/* Begins a field: writes its name and reserves four bytes for the length, which field_end() fills
 * in. Returns their position. */
size_t field_begin(struct buffer *output, const char *name)
{
    const uint32_t none = 0;
    buffer_char(output, (char)strlen(name));
    buffer_put(output, text_of(name));
    const size_t begun = output->len;
    buffer_put(output, (struct text){(const char *)&none, sizeof none});
    return begun;
}

/* Fills in the length [byte] of the field that begun = field_begin() started. Fails if it exceeds
 * 32 bits. */
void field_end(struct buffer *output, size_t begun)
{
    if (output->failed)
        return;
    const size_t bytes = output->len - begun - sizeof(uint32_t);
    const uint32_t len = (uint32_t)bytes;
    output->failed = bytes > UINT32_MAX;
    memcpy(output->data + begun, &len, sizeof len);
}

/* Writes a field with this value. */
void field_text(struct buffer *output, const char *name, struct text value)
{
    const size_t begun = field_begin(output, name);
    buffer_put(output, value);
    field_end(output, begun);
}

void field_put(struct buffer *output, const char *name, const void *value, size_t bytes)
{
    field_text(output, name, (struct text){value, bytes});
}

/* Writes the members of object that the table describes; quantities by name, texts without trailing
 * zeros. */
void fields_put(struct buffer *output, const struct field *field, size_t count, const void *object)
{
    for (size_t i = 0; i < count; i++) {
        const void *member = (const char *)object + field[i].offset;
        if (field[i].kind == FIELD_QUANTITY)
            field_text(output, field[i].name,
                       text_of(quantity_name(*(const enum quantity *)member)));
        else if (field[i].kind == FIELD_TEXT)
            field_text(output, field[i].name, text_of(member));
        else
            field_put(output, field[i].name, member, field[i].bytes);
    }
}

/* ---- reading ---- */

/* Takes the next field off the text. Returns false at the end, and for lengths beyond the text, as
 * damaged files have. */
bool field_next(struct text *text, struct text *name, struct text *value)
{
    uint32_t len;
    if (text->len == 0)
        return false;
    const size_t name_len = (unsigned char)text->data[0], header = 1 + name_len + sizeof len;
    if (text->len < header)
        return false;
    memcpy(&len, text->data + 1 + name_len, sizeof len);
    if (text->len - header < len)
        return false;
    *name = (struct text){text->data + 1, name_len};
    *value = (struct text){text->data + header, len};
    *text = (struct text){text->data + header + len, text->len - header - len};
    return true;
}

/* Finds a field by name. Returns false if the text lacks it or is damaged before it. */
bool field_find(struct text text, const char *name, struct text *value)
{
    struct text found;
    while (field_next(&text, &found, value))
        if (text_is(found, name))
            return true;
    return false;
}

/* Copies a field of exactly this length to target. Returns false, with target unchanged, for
 * others. */
bool field_get(struct text text, const char *name, void *target, size_t bytes)
{
    struct text value;
    if (!field_find(text, name, &value) || value.len != bytes)
        return false;
    if (bytes > 0)
        memcpy(target, value.data, bytes);
    return true;
}

/* Returns the number of that kind that begins at cursor, at any alignment. */
static double number_at(enum field_kind kind, const char *cursor)
{
    int whole;
    unsigned natural;
    int64_t large;
    uint64_t larger;
    double real;
    switch (kind) {
    case FIELD_INTS:
        return (double)*(int *)memcpy(&whole, cursor, sizeof whole);
    case FIELD_UNSIGNED:
        return (double)*(unsigned *)memcpy(&natural, cursor, sizeof natural);
    case FIELD_INT64S:
        return (double)*(int64_t *)memcpy(&large, cursor, sizeof large);
    case FIELD_UINT64S:
        return (double)*(uint64_t *)memcpy(&larger, cursor, sizeof larger);
    default:
        return *(double *)memcpy(&real, cursor, sizeof real);
    }
}

/* Returns true if bytes of a file are a valid value of the field: bools are 0 or 1, a text ends
 * within it, numbers lie between its limits. */
static bool value_is_allowed(const struct field *field, struct text value)
{
    const size_t bytes =
        field->kind == FIELD_INTS || field->kind == FIELD_UNSIGNED ? sizeof(int) : sizeof(double);
    bool allowed = true;
    for (size_t i = 0; i < value.len && field->kind == FIELD_BOOLS; i++)
        allowed &= (unsigned char)value.data[i] <= 1;
    if (field->kind == FIELD_TEXT)
        return memchr(value.data, 0, value.len);
    if (field->kind < FIELD_INTS || !(field->least < field->most))
        return allowed;
    for (size_t i = 0; i + bytes <= value.len && allowed; i += bytes) {
        const double number = number_at(field->kind, value.data + i);
        allowed = number >= field->least && number <= field->most;
    }
    return allowed;
}

/* Returns true if all members of object are valid values of their fields. */
bool fields_sound(const struct field *field, size_t count, const void *object)
{
    bool all = true;
    for (size_t i = 0; i < count && all; i++)
        all = value_is_allowed(
            &field[i], (struct text){(const char *)object + field[i].offset, field[i].bytes});
    return all;
}

/* Returns the quantity of that name, or QUANTITY_OTHER if it is unknown. */
static enum quantity find_quantity(struct text name)
{
    int i = 0;
    while (i < QUANTITY_OTHER && !text_is(name, quantity_name((enum quantity)i)))
        i++;
    return (enum quantity)i;
}

/* Copies one field into its member. Sets *found if the file has the field in the right length.
 * Returns false if it has a value that the member cannot have. */
static bool field_read(struct text source, const struct field *field, void *object, bool *found)
{
    struct text value;
    char *member = (char *)object + field->offset;
    const bool quantity = field->kind == FIELD_QUANTITY, text = field->kind == FIELD_TEXT;
    *found =
        field_find(source, field->name, &value) && (quantity || text || value.len == field->bytes);
    if (!*found)
        return true;
    if (quantity) {
        const enum quantity known = find_quantity(value);
        memcpy(member, &known, sizeof known);
        return true;
    }
    if (text ? value.len >= field->bytes || memchr(value.data, 0, value.len)
             : !value_is_allowed(field, value))
        return false;
    if (text)
        memset(member, 0, field->bytes);
    if (value.len > 0)
        memcpy(member, value.data, value.len);
    return true;
}

/* Copies all fields into the members of object. Returns false at the first one that is missing or
 * invalid. */
bool fields_get(struct text text, const struct field *field, size_t count, void *object)
{
    bool all = true, found;
    for (size_t i = 0; i < count && all; i++)
        all = field_read(text, &field[i], object, &found) && found;
    return all;
}

/* Copies the fields that the file has; others keep their values. Returns false if one is
 * invalid. */
bool fields_get_known(struct text text, const struct field *field, size_t count, void *object)
{
    bool ok = true, found;
    for (size_t i = 0; i < count; i++)
        ok &= field_read(text, &field[i], object, &found);
    return ok;
}

/* ---- arrays that are counted by names ---- */

/* Writes the names of a catalog's rows, each ended by a NUL. */
void field_put_names(struct buffer *output, const char *name, const struct catalog *catalog)
{
    const size_t begun = field_begin(output, name);
    for (size_t i = 0; i < catalog->count; i++) {
        buffer_put(output, text_of(catalog_row(catalog, i)->name));
        buffer_char(output, '\0');
    }
    field_end(output, begun);
}

/* Finds which item of a file belongs to which row of the catalog, by their names. Returns false if
 * the names are damaged or too many. */
bool field_find_places(struct text names, const struct catalog *catalog,
                       struct field_places *places)
{
    *places = (struct field_places){.rows = (int)catalog->count};
    for (int i = 0; i < places->rows; i++)
        places->index[i] = -1;
    while (names.len > 0) {
        const char *end = memchr(names.data, 0, names.len);
        if (!end || places->count == LIMIT_PARAMETERS)
            return false;
        const struct text name = {names.data, (size_t)(end - names.data)};
        int row = -1;
        for (int i = 0; i < places->rows && row < 0; i++)
            if (text_is(name, catalog_row(catalog, (size_t)i)->name))
                row = i;
        if (row >= 0)
            places->index[row] = places->count;
        places->row[places->count++] = row;
        names = (struct text){end + 1, names.len - name.len - 1};
    }
    return true;
}

/* Copies the items of an array in a file to the rows of target that they belong to. Returns false,
 * with target unchanged, if the array is missing or has another length. */
bool field_get_placed(struct text text, const char *name, const struct field_places *places,
                      void *target, size_t item)
{
    struct text value;
    if (!field_find(text, name, &value) || value.len != (size_t)places->count * item)
        return false;
    for (int i = 0; i < places->rows; i++)
        if (places->index[i] >= 0)
            memcpy((char *)target + (size_t)i * item, value.data + (size_t)places->index[i] * item,
                   item);
    return true;
}

/* ---- checksums ---- */

/* Odd constants without a pattern in their bits: from the golden ratio, and from splitmix64
 * (Steele, Lea, Flood 2014). */
#define SPREAD_A 0x9E3779B97F4A7C15u
#define SPREAD_B 0xBF58476D1CE4E5B9u

/* Returns sum changed by a word of 64 bits so that every bit of the word affects the upper half. */
static uint64_t checksum_mix(uint64_t sum, uint64_t word)
{
    sum = (sum ^ word) * SPREAD_B;
    return sum ^ (sum >> 29);
}

/* Returns a checksum of 64 bits, mixed in four lanes, which the processor computes side by side. */
uint64_t bytes_sum(struct text bytes)
{
    uint64_t lane[4] = {1 * SPREAD_A, 2 * SPREAD_A, 3 * SPREAD_A, bytes.len * SPREAD_A}, word[4];
    for (; bytes.len >= sizeof word; bytes.data += sizeof word, bytes.len -= sizeof word) {
        memcpy(word, bytes.data, sizeof word);
        for (int i = 0; i < 4; i++)
            lane[i] = checksum_mix(lane[i], word[i]);
    }
    memset(word, 0, sizeof word);
    if (bytes.len > 0)
        memcpy(word, bytes.data, bytes.len);
    uint64_t sum = 0;
    for (int i = 0; i < 4; i++)
        sum = checksum_mix(sum, checksum_mix(lane[i], word[i]));
    return checksum_mix(sum, SPREAD_A);
}
