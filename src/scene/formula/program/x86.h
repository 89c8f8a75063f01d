/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Instructions of an x86-64 as bytes: SSE2 on one double, into a page of code. */
#pragma once

#include "scene/formula/program/program.h"

/* Contents of the page before the code: 16-byte constants, then the program's numbers. */
enum { POOL_SIGN = 0, POOL_MAGNITUDE = 16, POOL_ONE = 32, POOL_NUMBERS = 48 };
enum { REGISTERS = 16, NOTHING = -1, TAKEN = -2 };
enum { RAX, RCX, RDX, RBX, RSP, RBP, RSI, RDI, R8, R14 = 14, R15 };
/* prefixes for one double and for all bits of the register */
enum { DOUBLE = 0xF2, PACKED = 0x66 };
enum {
    LOAD = 0x10,
    STORE = 0x11,
    MOVE = 0x28,
    ROOT = 0x51,
    AND = 0x54,
    AND_NOT,
    OR,
    XOR,
    COMPARE = 0xC2
};
enum { PLUS = 0x58, TIMES = 0x59, MINUS = 0x5C, OVER = 0x5E };
enum { LESS_THAN = 1, AT_MOST = 2, UNORDERED = 3 }; /* predicates of COMPARE */

struct emitter {
    const struct program *program;
    uint8_t *page;
    size_t position, size; /* [byte] next, of the page */
    bool full;
    int state, steady, output, frame; /* the registers that hold these addresses */
    int holds[REGISTERS];  /* place whose value it is, NOTHING, or TAKEN by the operation at hand */
    bool dirty[REGISTERS]; /* not in the frame */
    int64_t used[REGISTERS], clock;
    int *where; /* [places] register, or NOTHING if the value is in memory */
    /* [places] the value in it depends on the state, and so on more than t and what is given */
    bool *by_state;
    int remembered; /* calls that remember their last argument */
};

static inline void emitter_byte(struct emitter *e, int value)
{
    e->full = e->full || e->position == e->size;
    if (!e->full)
        e->page[e->position++] = (uint8_t)value;
}

static inline void emitter_word(struct emitter *e, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        emitter_byte(e, (int)(value >> 8 * i & 0xFF));
}

static inline void opcode(struct emitter *e, int prefix, int code, int reg, int base)
{
    emitter_byte(e, prefix);
    if (reg >= 8 || base >= 8)
        emitter_byte(e, 0x40 | reg >> 3 << 2 | base >> 3);
    emitter_byte(e, 0x0F);
    emitter_byte(e, code);
}

static inline void with_register(struct emitter *e, int prefix, int code, int reg, int other)
{
    opcode(e, prefix, code, reg, other);
    emitter_byte(e, 0xC0 | (reg & 7) << 3 | (other & 7));
}

static inline void with_address(struct emitter *e, int prefix, int code, int reg, int base,
                                int slot)
{
    const int64_t offset = 8 * (int64_t)slot;
    opcode(e, prefix, code, reg, base);
    emitter_byte(e, (offset < 128 ? 0x40 : 0x80) | (reg & 7) << 3 | (base & 7));
    emitter_word(e, (uint64_t)offset, offset < 128 ? 1 : 4);
}

/* Relative to the next instruction, which begins `trailing_bytes` bytes after the address. */
static inline void with_pool(struct emitter *e, int prefix, int code, int reg, size_t offset,
                             int trailing_bytes)
{
    opcode(e, prefix, code, reg, 0);
    emitter_byte(e, 0x05 | (reg & 7) << 3);
    emitter_word(e, offset - (e->position + 4 + (size_t)trailing_bytes), 4);
}
