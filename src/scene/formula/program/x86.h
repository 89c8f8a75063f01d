/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes instructions of an x86-64 as bytes: SSE2 operations on one double. native_x86.c uses
 * it. */
#pragma once

#include "scene/formula/program/program.h"

/* Offsets [byte] in the page before the code: masks of the sign and of the other bits, 1.0, each of
 * 16 bytes, then the program's numbers. */
enum { POOL_SIGN = 0, POOL_MAGNITUDE = 16, POOL_ONE = 32, POOL_NUMBERS = 48 };
enum { REGISTERS = 16 };           /* number of vector registers */
enum { NOTHING = -1, TAKEN = -2 }; /* contents of a register that is no place, see emitter.holds */
/* numbers of the integer registers that are used */
enum { RAX, RCX, RDX, RBX, RSP, RBP, RSI, RDI, R8, R14 = 14, R15 };
/* prefixes for one double and for all bits of the register */
enum { DOUBLE = 0xF2, PACKED = 0x66 };
/* operation codes after a prefix */
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

/* State while the code of a program is written. */
struct emitter {
    const struct program *program;
    uint8_t *page;
    size_t position, size;            /* [byte] next one; size of the page */
    bool full;                        /* the page is too small */
    int state, steady, output, frame; /* integer registers that hold these addresses */
    /* place whose value the register has; NOTHING; or TAKEN by the operation being written */
    int holds[REGISTERS];
    bool dirty[REGISTERS];   /* the value is not in the frame yet */
    int64_t used[REGISTERS]; /* `clock` at the last use */
    int64_t clock;           /* counts uses of registers */
    int *where; /* [slots] register of the value of a place, or NOTHING if it is in memory */
    /* [slots] the value of the place depends on the state, not only on t and steady names */
    bool *by_state;
    int remembered; /* calls that remember their last argument */
};

/* Writes a byte, or sets e->full if the page is full. */
static inline void emitter_byte(struct emitter *e, int value)
{
    e->full = e->full || e->position == e->size;
    if (!e->full)
        e->page[e->position++] = (uint8_t)value;
}

/* Writes the lower `bytes` bytes of a value, lowest first. */
static inline void emitter_word(struct emitter *e, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        emitter_byte(e, (int)(value >> 8 * i & 0xFF));
}

/* Writes the prefix and code of an instruction on a register and a base register or second
 * register. */
static inline void opcode(struct emitter *e, int prefix, int code, int reg, int base)
{
    emitter_byte(e, prefix);
    if (reg >= 8 || base >= 8)
        emitter_byte(e, 0x40 | reg >> 3 << 2 | base >> 3);
    emitter_byte(e, 0x0F);
    emitter_byte(e, code);
}

/* Writes an instruction on two vector registers; the first one gets the result. */
static inline void with_register(struct emitter *e, int prefix, int code, int reg, int other)
{
    opcode(e, prefix, code, reg, other);
    emitter_byte(e, 0xC0 | (reg & 7) << 3 | (other & 7));
}

/* Writes an instruction on a vector register and the double number `slot` from the address in
 * `base`. */
static inline void with_address(struct emitter *e, int prefix, int code, int reg, int base,
                                int slot)
{
    const int64_t offset = 8 * (int64_t)slot;
    opcode(e, prefix, code, reg, base);
    emitter_byte(e, (offset < 128 ? 0x40 : 0x80) | (reg & 7) << 3 | (base & 7));
    emitter_word(e, (uint64_t)offset, offset < 128 ? 1 : 4);
}

/* Writes an instruction on a vector register and the constant at `offset` in the page. The address
 * is relative to the next instruction, which begins trailing_bytes after it. */
static inline void with_pool(struct emitter *e, int prefix, int code, int reg, size_t offset,
                             int trailing_bytes)
{
    opcode(e, prefix, code, reg, 0);
    emitter_byte(e, 0x05 | (reg & 7) << 3);
    emitter_word(e, offset - (e->position + 4 + (size_t)trailing_bytes), 4);
}
