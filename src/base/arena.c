/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Arenas: memory allocated in blocks that double in size, and freed all at once. */
#include <hooke/base/cancel.h>
#include <hooke/base/text.h>

#include <stdlib.h>
#include <string.h>

/* [byte] Sizes of the first block, and at which doubling ends. */
#define BLOCK_FIRST 4096u
#define BLOCK_LARGEST (1u << 20)

/* A block of an arena; the newest is the first of the list. */
struct arena_block {
    struct arena_block *next;
    size_t size, used; /* [byte] of data */
    max_align_t data[];
};

/* Returns a block with size bytes of data, or NULL if out of memory. */
static struct arena_block *block_create(size_t size)
{
    struct arena_block *block = malloc(sizeof *block + size);
    if (block)
        *block = (struct arena_block){.size = size};
    return block;
}

/* Returns zeroed memory from the newest block, or from a new one if it does not fit. */
void *arena_alloc(struct arena *arena, size_t size)
{
    const size_t unit = sizeof(max_align_t);
    if (size > PTRDIFF_MAX / 2) /* no object is that large, and no sum below overflows */
        return NULL;
    size = size ? (size + unit - 1) / unit * unit : unit;

    struct arena_block *block = arena->blocks;
    if (!block || block->size - block->used < size) {
        size_t fresh;
        if (!block)
            fresh = BLOCK_FIRST;
        else
            fresh = block->size < BLOCK_LARGEST / 2 ? block->size * 2 : BLOCK_LARGEST;
        block = block_create(size > fresh ? size : fresh);
        if (!block)
            return NULL;
        block->next = arena->blocks;
        arena->blocks = block;
    }
    void *data = (char *)block->data + block->used;
    block->used += size;
    return memset(data, 0, size);
}

void *arena_array(struct arena *arena, size_t count, size_t size)
{
    size_t total;
    return __builtin_mul_overflow(count, size, &total) ? NULL : arena_alloc(arena, total);
}

/* Returns a copy of the text as a string, or NULL if out of memory. */
char *arena_text(struct arena *arena, struct text text)
{
    char *copy = arena_alloc(arena, text.len + 1);
    if (copy && text.len)
        memcpy(copy, text.data, text.len);
    return copy;
}

/* Gives all blocks of source to target; source is empty afterwards. */
void arena_move(struct arena *source, struct arena *target)
{
    struct arena_block **end = &source->blocks;
    while (*end)
        end = &(*end)->next;
    *end = target->blocks;
    target->blocks = source->blocks;
    source->blocks = NULL;
}

/* Frees block by block until none is left or the user cancels; a later call continues. */
void arena_give_back(struct arena *arena, const struct cancel *cancel)
{
    while (arena->blocks && !cancelled(cancel)) {
        struct arena_block *block = arena->blocks;
        arena->blocks = block->next;
        free(block);
    }
}

void arena_reset(struct arena *arena)
{
    arena_give_back(arena, NULL);
}
