/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Memory for the rows of a trace, freed all at once. The first blocks are as large as the request.
 * Once the pool is larger than SMALL_BLOCKS_BYTES, further blocks are large pages: the time that
 * the system takes to provide memory page by page is more than a step of a short method takes. */
#include "run/private.h"

#include <stdlib.h>
#include <sys/mman.h>

/* Total size up to which each request gets a block of its own. */
#define SMALL_BLOCKS_BYTES ((size_t)1 << 19)
#define LARGE_PAGE_BYTES ((size_t)1 << 21) /* Size of a large page. */

struct pool_block {
    struct pool_block *next; /* block that was allocated before */
    max_align_t data[];
};

/* Allocates a block with `size` bytes of data; returns NULL if out of memory. */
static struct pool_block *small_block(size_t size)
{
    return malloc(sizeof(struct pool_block) + size);
}

/* Allocates a block that is a large page, if the system has these; returns NULL if out of
 * memory. */
static struct pool_block *large_block(void)
{
    struct pool_block *block = aligned_alloc(LARGE_PAGE_BYTES, LARGE_PAGE_BYTES);
#ifdef MADV_HUGEPAGE
    /* The memory is usable without large pages, too. */
    if (block)
        madvise(block, LARGE_PAGE_BYTES, MADV_HUGEPAGE);
#endif
    return block;
}

/* Adds a block with at least `size` free bytes. Returns false if out of memory. */
static bool pool_grow(struct pool *pool, size_t size)
{
    const bool small = pool->bytes < SMALL_BLOCKS_BYTES || size > LARGE_PAGE_BYTES / 4;
    struct pool_block *block = small ? small_block(size) : large_block();
    if (!block)
        return false;
    block->next = pool->blocks;
    pool->blocks = block;
    pool->free = (char *)block->data;
    pool->left = small ? size : LARGE_PAGE_BYTES - sizeof *block;
    pool->bytes += pool->left + sizeof *block;
    return true;
}

/* Takes memory from the last block, or from a new one if it is full. */
void *pool_take(struct pool *pool, size_t size)
{
    if (pool->left < size && !pool_grow(pool, size))
        return NULL;
    void *taken = pool->free;
    pool->free += size;
    pool->left -= size;
    return taken;
}

/* Frees all blocks. */
void pool_release(struct pool *pool)
{
    while (pool->blocks) {
        struct pool_block *block = pool->blocks;
        pool->blocks = block->next;
        free(block);
    }
    *pool = (struct pool){0};
}

/* Doubles the capacity if the array is full. */
bool array_reserve(void *array, size_t bytes, size_t count, size_t *capacity)
{
    static const size_t large = 1024; /* [byte] arrays of larger elements mostly have only one */
    const size_t first = bytes < large ? 16 : 1;
    if (count < *capacity)
        return true;
    const size_t larger = *capacity > 0 ? 2 * *capacity : first;
    void *made = realloc(*(void **)array, larger * bytes);
    if (!made)
        return false;
    *(void **)array = made;
    *capacity = larger;
    return true;
}
