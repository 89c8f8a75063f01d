/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Arrays of a session file whose items have places: parameters of a scene, members of a struct. The
 * file names them, so that a program that has more of them, or in another order, finds its own.
 */
#include <hooke/session/read.h>

#include <string.h>

/* ---- parameters ---- */

/* Those of oscillators in files that do not name them (until November 2026), in that order. */
static const char unnamed_parameters[] =
    "m\0k\0gamma\0C\0rho\0area\0length\0eta\0g\0F0\0omega\0phase\0"
    "k3\0mu\0width\0friction\0y0\0v0\0t0\0";

/* Finds the parameters of a scene in a file that counts `count` of them and does not name them:
 * those of the built-in scene underneath, then the scene's own. */
static bool find_unnamed(const struct scene *scene, int count, struct field_places *places)
{
    const struct catalog *params = scene_params(scene);
    const struct text names = {unnamed_parameters, sizeof unnamed_parameters - 1};
    field_same_places(params, places);
    if (count == places->rows)
        return true;
    struct field_places built_in;
    if (!is_oscillator(scene) || !field_find_places(names, &param_catalog, &built_in))
        return false;
    const int more = built_in.rows - built_in.count;
    if (count != places->rows - more || count > LIMIT_PARAMETERS)
        return false;
    places->count = count;
    for (int i = 0; i < places->rows; i++)
        places->at[i] = i < built_in.rows ? built_in.at[i] : i - more;
    for (int i = 0; i < places->count; i++)
        places->row[i] = i < built_in.count ? built_in.row[i] : i + more;
    return true;
}

bool reader_places(struct text of, const struct scene *scene, struct field_places *places)
{
    struct text names, value;
    if (field_find(of, "names", &names))
        return field_find_places(names, scene_params(scene), places);
    return field_find(of, "value", &value) &&
           find_unnamed(scene, (int)(value.len / sizeof(double)), places);
}

void reader_move(const struct field_places *places, void *array, size_t item)
{
    char before[PARAM_MAX * sizeof(double)];
    const size_t bytes = PARAM_MAX * item;
    memcpy(before, array, bytes);
    for (int i = 0; i < places->rows; i++) {
        char *to = (char *)array + (size_t)i * item;
        if (places->at[i] >= 0)
            memcpy(to, before + (size_t)places->at[i] * item, item);
        else
            memset(to, 0, item);
    }
}

/* ---- members of structs ---- */

struct member_place {
    uint32_t offset, bytes;
};

void store_put_members(const struct field *member, size_t count, struct buffer *to)
{
    const size_t begun = field_begin(to, "members");
    for (size_t i = 0; i < count; i++) {
        const struct member_place place = {(uint32_t)member[i].offset, (uint32_t)member[i].bytes};
        field_put(to, member[i].name, &place, sizeof place);
    }
    field_end(to, begun);
    const size_t names = field_begin(to, "quantities");
    for (int i = 0; i < QUANTITY_COUNT; i++)
        buffer_put(to, (struct text){quantity_name((enum quantity)i),
                                     strlen(quantity_name((enum quantity)i)) + 1});
    field_end(to, names);
}

/* Returns the quantity whose name is number `index` of those that end with a NUL each. */
static enum quantity find_quantity(struct text names, unsigned index)
{
    while (names.len > 0) {
        const char *end = memchr(names.at, 0, names.len);
        if (!end)
            break;
        const struct text name = {names.at, (size_t)(end - names.at)};
        for (int i = 0; index == 0 && i < QUANTITY_COUNT; i++)
            if (text_is(name, quantity_name((enum quantity)i)))
                return (enum quantity)i;
        if (index-- == 0)
            break;
        names = (struct text){end + 1, names.len - name.len - 1};
    }
    return QUANTITY_OTHER;
}

size_t reader_item(struct text in, size_t item)
{
    size_t stored = item;
    field_get(in, "item", &stored, sizeof stored);
    return stored;
}

bool reader_members(struct text in, const struct field *member, size_t members, struct text stored,
                    size_t item, void *to)
{
    struct text places, names;
    if (!field_find(in, "members", &places)) {
        if (stored.len == item)
            memcpy(to, stored.at, item);
        return stored.len == item;
    }
    memset(to, 0, item);
    for (size_t i = 0; i < members; i++) {
        struct member_place place;
        if (field_get(places, member[i].name, &place, sizeof place) &&
            place.bytes == member[i].bytes && place.bytes <= stored.len &&
            place.offset <= stored.len - place.bytes)
            memcpy((char *)to + member[i].offset, stored.at + place.offset, place.bytes);
        unsigned quantity;
        if (member[i].kind != FIELD_QUANTITY || !field_find(in, "quantities", &names))
            continue;
        memcpy(&quantity, (char *)to + member[i].offset, sizeof quantity);
        const enum quantity found = find_quantity(names, quantity);
        memcpy((char *)to + member[i].offset, &found, sizeof found);
    }
    return true;
}
