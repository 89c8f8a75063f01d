/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Machine code for programs, on an x86-64 with the System V calling convention: native_create().
 * The operations are translated in their order, into the instructions that a compiler would choose
 * (SSE2, one double), so the bits are those of the interpreter. Values are kept in registers; if
 * none is free, the least recently used one is written to its place in the frame. The page is
 * written first and made executable afterwards, never both at once; where the system does not allow
 * that, there is no machine code. */
#include "scene/formula/program/x86.h"

#if defined(__x86_64__) && defined(__LP64__) && defined(__unix__)

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* A page with machine code. */
struct native {
    void *page;
    size_t size;
};

/* ---- values ---- */

/* Returns the offset in the page of the number in a place. */
static size_t pool_offset(const struct emitter *e, int slot)
{
    return POOL_NUMBERS + 8 * (size_t)(slot - e->program->names);
}

/* Writes an instruction on a register and the value of a place in memory: a steady name, a part of
 * the state, or the frame. */
static void with_memory(struct emitter *e, int code, int reg, int slot)
{
    const struct program *p = e->program;
    if (slot >= p->moving && slot < p->names)
        with_address(e, DOUBLE, code, reg, e->steady, slot - p->moving);
    else if (slot >= LEADING && slot < p->moving)
        with_address(e, DOUBLE, code, reg, e->state, slot - 1);
    else
        with_address(e, DOUBLE, code, reg, e->frame, slot);
}

/* Writes an SSE instruction (opcode `code`) on register `reg` and the value of a slot, which may be
 * in another register, in the pool of numbers or in memory. `immediate` is a byte that follows the
 * instruction, or negative for none. */
static void with_slot(struct emitter *e, int code, int reg, int slot, int immediate)
{
    const int trailing_bytes = immediate >= 0;
    if (e->where[slot] != NOTHING) {
        e->used[e->where[slot]] = ++e->clock;
        with_register(e, DOUBLE, code, reg, e->where[slot]);
    } else if (slot >= e->program->names && slot < e->program->names + e->program->numbers) {
        with_pool(e, DOUBLE, code, reg, pool_offset(e, slot), trailing_bytes);
    } else {
        with_memory(e, code, reg, slot);
    }
    if (trailing_bytes)
        emitter_byte(e, immediate);
}

/* Writes a register to its place in the frame, if it is not there yet. */
static void register_save(struct emitter *e, int reg)
{
    if (e->dirty[reg])
        with_address(e, DOUBLE, STORE, reg, e->frame, e->holds[reg]);
    e->dirty[reg] = false;
}

/* Marks a register as free. */
static void register_free(struct emitter *e, int reg)
{
    if (e->holds[reg] >= 0)
        e->where[e->holds[reg]] = NOTHING;
    e->holds[reg] = NOTHING;
    e->dirty[reg] = false;
}

/* Returns a free register for the result of the operation being written; if none is free, the least
 * recently used one, whose value is saved. */
static int register_take(struct emitter *e)
{
    int best = NOTHING;
    for (int r = 0; r < REGISTERS; r++) {
        if (e->holds[r] == NOTHING) {
            best = r;
            break;
        }
        if (e->holds[r] >= 0 && (best == NOTHING || e->used[r] < e->used[best]))
            best = r;
    }
    register_save(e, best);
    register_free(e, best);
    e->holds[best] = TAKEN;
    return best;
}

/* Returns a register with the value of a slot that the code may overwrite: the register that has
 * the value if it is not used any more (`last`), else a copy in another one. */
static int take_value(struct emitter *e, int slot, bool last)
{
    const int own = e->where[slot];
    if (own != NOTHING && last) {
        register_free(e, own);
        e->holds[own] = TAKEN;
        return own;
    }
    const int reg = register_take(e);
    if (e->where[slot] != NOTHING)
        with_register(e, PACKED, MOVE, reg, e->where[slot]);
    else
        with_slot(e, LOAD, reg, slot, -1);
    return reg;
}

/* ---- operations: each returns the register of the result ---- */

/* Writes an operation on two operands. Those of + and * may change places, so that the result
 * overwrites the one that is not used any more. */
static int binary_write(struct emitter *e, const struct instruction *i, int code)
{
    const int *slot = i->node.operand;
    /* x + y is y + x: what is needed no more takes the result. */
    const bool swap =
        (code == PLUS || code == TIMES) && slot[0] != slot[1] && i->last[1] && !i->last[0];
    const int reg = take_value(e, slot[swap], i->last[swap]);
    with_slot(e, code, reg, slot[!swap], -1);
    return reg;
}

/* Writes a comparison, which gives 1 or 0, or all bits set, which is a NaN, if an operand is
 * NaN. */
static int comparison_write(struct emitter *e, const struct instruction *i, int how)
{
    const int *slot = i->node.operand;
    const int unordered = take_value(e, slot[0], false);
    with_slot(e, COMPARE, unordered, slot[1], UNORDERED);
    const int reg = take_value(e, slot[0], i->last[0]);
    with_slot(e, COMPARE, reg, slot[1], how);
    with_pool(e, PACKED, AND, reg, POOL_ONE, 0);
    with_register(e, PACKED, OR, reg, unordered);
    return reg;
}

/* Writes the choice of the second operand if the first is above 0, else of the third, by masks; NaN
 * if the first is NaN. */
static int choice_write(struct emitter *e, const struct instruction *i)
{
    const int *slot = i->node.operand;
    const int unordered = take_value(e, slot[0], false), positive = register_take(e);
    with_register(e, PACKED, XOR, positive, positive);
    with_slot(e, COMPARE, positive, slot[0], LESS_THAN);
    with_register(e, DOUBLE, COMPARE, unordered, unordered);
    emitter_byte(e, UNORDERED);
    const int yes = take_value(e, slot[1], i->last[1]), no = take_value(e, slot[2], i->last[2]);
    with_register(e, PACKED, AND, yes, positive);
    with_register(e, PACKED, AND_NOT, positive, no);
    with_register(e, PACKED, OR, yes, positive);
    with_register(e, PACKED, OR, yes, unordered);
    return yes;
}

enum { REMEMBERED_MAX = 8 };

/* Writes an instruction on the place of the argument (value = 0) or of the result (value = 1) of
 * the present remembered call; the frame's address is in r15. */
static void with_remembered(struct emitter *e, uint32_t code, int bytes, int value)
{
    const int slot = e->program->slots + 2 * e->remembered + value;
    emitter_word(e, code, bytes);
    emitter_byte(e, 0x87);
    emitter_word(e, 8 * (uint64_t)slot, 4);
}

/* Writes the look-up before a call that depends on t only: if the argument is the remembered one,
 * its result is loaded and the call is skipped. Stages at the same time, and steps that begin where
 * the last one ended, skip it. The call that follows, with the move of its result, is 21 bytes
 * long, which the jumps rely on. */
static void write_remembered(struct emitter *e)
{
    emitter_word(e, 0xC07E0F4866, 5);      /* movq rax, xmm0 */
    with_remembered(e, 0x3B49, 2, 0);      /* cmp rax, [argument] */
    emitter_word(e, 0x0B75, 2);            /* jne over the next two */
    with_remembered(e, 0x100F41F2u, 4, 1); /* movsd xmm0, [value] */
    emitter_word(e, 0x1CEB, 2);            /* jmp over the call */
    with_remembered(e, 0x8949, 2, 0);      /* mov [argument], rax */
}

/* Writes a call of a function. Functions preserve no vector register, so values that are used
 * afterwards are saved in the frame first. */
static int call_emit(struct emitter *e, const struct instruction *i)
{
    const int *slot = i->node.operand, arity = node_arity(i->node.kind);
    for (int r = 0; r < REGISTERS; r++)
        if (e->holds[r] >= 0 && !(e->holds[r] == slot[0] && i->last[0]))
            register_save(e, r);
    const int first = e->where[slot[0]];
    if (first > 0)
        with_register(e, PACKED, MOVE, 0, first);
    if (first < 0)
        with_slot(e, LOAD, 0, slot[0], -1);
    for (int r = 0; r < REGISTERS; r++)
        register_free(e, r);
    if (arity == 2)
        with_slot(e, LOAD, 1, slot[1], -1);
    uint64_t address;
    memcpy(&address, &i->node.one, sizeof address);
    const bool remembers = arity == 1 && !e->by_state[slot[0]] && e->program->moving > 1 &&
                           e->remembered < REMEMBERED_MAX;
    if (remembers)
        write_remembered(e);
    emitter_word(e, 0xB848, 2); /* mov rax, address; call rax */
    emitter_word(e, address, 8);
    emitter_word(e, 0xD0FF, 2);
    if (remembers)
        with_remembered(e, 0x110F41F2u, 4, 1); /* movsd [value], xmm0 */
    e->remembered += remembers;
    e->holds[0] = TAKEN;
    return 0;
}

/* Writes the instructions of an operation. Returns the register of the result. */
static int operation_write(struct emitter *e, const struct instruction *i)
{
    const int *slot = i->node.operand;
    int reg, other;
    switch (i->node.kind) {
    case NODE_NEG:
        reg = take_value(e, slot[0], i->last[0]);
        with_pool(e, PACKED, XOR, reg, POOL_SIGN, 0);
        return reg;
    case NODE_ABS:
        reg = take_value(e, slot[0], i->last[0]);
        with_pool(e, PACKED, AND, reg, POOL_MAGNITUDE, 0);
        return reg;
    case NODE_SQRT:
        reg = take_value(e, slot[0], i->last[0]);
        with_register(e, DOUBLE, ROOT, reg, reg);
        return reg;
    case NODE_ADD:
        return binary_write(e, i, PLUS);
    case NODE_SUB:
        return binary_write(e, i, MINUS);
    case NODE_MUL:
        return binary_write(e, i, TIMES);
    case NODE_DIV:
        return binary_write(e, i, OVER);
    case NODE_LESS:
        return comparison_write(e, i, LESS_THAN);
    case NODE_LESS_EQUAL:
        return comparison_write(e, i, AT_MOST);
    case NODE_IF:
        return choice_write(e, i);
    case NODE_MUL_ADD:
    case NODE_MUL_SUB:
        reg = binary_write(e, i, TIMES);
        with_slot(e, i->node.kind == NODE_MUL_ADD ? PLUS : MINUS, reg, slot[2], -1);
        return reg;
    case NODE_NEG_MUL:
        reg = binary_write(e, i, TIMES);
        with_pool(e, PACKED, XOR, reg, POOL_SIGN, 0);
        return reg;
    case NODE_SUB_MUL:
        other = binary_write(e, i, TIMES);
        reg = take_value(e, slot[2], i->last[2]);
        with_register(e, DOUBLE, MINUS, reg, other);
        return reg;
    default: /* NODE_ONE, NODE_TWO */
        return call_emit(e, i);
    }
}

/* Writes an operation and updates which values are in registers and depend on the state. */
static void instruction_write(struct emitter *e, const struct instruction *i)
{
    const int result = operation_write(e, i);
    for (int k = 0; k < node_arity(i->node.kind); k++)
        if (i->last[k] && e->where[i->node.operand[k]] != NOTHING)
            register_free(e, e->where[i->node.operand[k]]);
    for (int r = 0; r < REGISTERS; r++)
        if (e->holds[r] == TAKEN)
            e->holds[r] = NOTHING;
    bool by_state = false;
    for (int k = 0; k < node_arity(i->node.kind); k++)
        by_state = by_state || e->by_state[i->node.operand[k]];
    e->by_state[i->target_slot] = by_state;
    e->holds[result] = i->target_slot;
    e->where[i->target_slot] = result;
    e->dirty[result] = true;
    e->used[result] = ++e->clock;
}

/* ---- the whole ---- */

/* Writes the constants and the program's numbers before the code. */
static void write_pool(struct emitter *e)
{
    const uint64_t constants[] = {1ull << 63, 0, ~0ull >> 1, 0, 0x3FFull << 52, 0};
    for (size_t i = 0; i < COUNT_OF(constants); i++)
        emitter_word(e, constants[i], 8);
    for (int i = 0; i < e->program->numbers; i++) {
        uint64_t bits;
        memcpy(&bits, &e->program->number[i], sizeof bits);
        emitter_word(e, bits, 8);
    }
}

/* Writes the moves of outputs 0 and 1 into registers 0 and 1, in which they are returned; they may
 * be in these the other way round. */
static void write_leading(struct emitter *e)
{
    const struct program *p = e->program;
    const int first = p->output[0], second = p->output[p->outputs > 1];
    if (p->outputs > 1 && e->where[second] == 0) {
        const int spare = e->where[first] == 2 ? 3 : 2;
        with_register(e, PACKED, MOVE, spare, 0);
        if (first == second) {
            with_register(e, PACKED, MOVE, 1, 0);
            return;
        }
        e->where[second] = spare;
    }
    if (e->where[first] == NOTHING)
        with_slot(e, LOAD, 0, first, -1);
    else if (e->where[first] != 0)
        with_register(e, PACKED, MOVE, 0, e->where[first]);
    if (p->outputs < 2)
        return;
    if (e->where[second] == NOTHING)
        with_slot(e, LOAD, 1, second, -1);
    else if (e->where[second] != 1)
        with_register(e, PACKED, MOVE, 1, e->where[second]);
}

/* Writes the function: its beginning, all operations, the stores of outputs, and the return. If it
 * makes calls, the addresses of its arguments are moved to registers that calls preserve; the five
 * pushes also align the stack. */
static void write_code(struct emitter *e, bool calls)
{
    const struct program *p = e->program;
    emitter_word(e, 0xFA1E0FF3u, 4); /* endbr64 marks a target of jumps */
    if (calls) {
        emitter_word(e, 0x57415641555350, 7); /* push rax; push rbx; push rbp; push r14; push r15 */
        emitter_word(e, 0xF38948, 3);         /* mov rbx, rsi */
        emitter_word(e, 0xD58948, 3);         /* mov rbp, rdx */
        emitter_word(e, 0xCE8949, 3);         /* mov r14, rcx */
        emitter_word(e, 0xC7894D, 3);         /* mov r15, r8 */
    }
    e->state = calls ? RBX : RSI;
    e->steady = calls ? RBP : RDX;
    e->output = calls ? R14 : RCX;
    e->frame = calls ? R15 : R8;
    for (int i = 0; i < p->uses; i++)
        if (p->used[i] < LEADING && p->used[i] < p->moving) {
            e->holds[p->used[i]] = p->used[i];
            e->where[p->used[i]] = p->used[i];
            e->dirty[p->used[i]] = true;
        }
    for (int i = 0; i < p->count; i++)
        instruction_write(e, &p->code[i]);
    for (int i = 2; i < p->outputs; i++) {
        int reg = e->where[p->output[i]];
        if (reg == NOTHING) {
            reg = take_value(e, p->output[i], false);
            e->holds[reg] = NOTHING;
        }
        with_address(e, DOUBLE, STORE, reg, e->output, i);
    }
    write_leading(e);
    /* pop r15; pop r14; pop rbp; pop rbx; pop rcx */
    if (calls)
        emitter_word(e, 0x595B5D5E415F41, 7);
    emitter_byte(e, 0xC3);
}

struct native *native_create(const struct program *p, program_function **run, int *remembered)
{
    enum { LONGEST = 320 /* an operation with all that it saves */, OUTPUT = 24, REST = 256 };
    bool calls = false;
    for (int i = 0; i < p->count; i++)
        calls = calls || p->code[i].node.kind == NODE_ONE || p->code[i].node.kind == NODE_TWO;
    struct emitter e = {.program = p};
    e.size =
        8 * (size_t)p->numbers + LONGEST * (size_t)p->count + OUTPUT * (size_t)p->outputs + REST;
    for (int r = 0; r < REGISTERS; r++)
        e.holds[r] = NOTHING;
    struct native *native = malloc(sizeof *native);
    e.where = malloc(((size_t)p->slots + 1) * sizeof *e.where);
    e.by_state = calloc((size_t)p->slots + 1, sizeof *e.by_state);
    void *page = native && e.where && e.by_state ? mmap(NULL, e.size, PROT_READ | PROT_WRITE,
                                                        MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)
                                                 : MAP_FAILED;
    if (page != MAP_FAILED) {
        *native = (struct native){.page = page, .size = e.size};
        for (int i = 0; i < p->slots; i++)
            e.where[i] = NOTHING;
        for (int i = 1; i < p->moving; i++)
            e.by_state[i] = true;
        e.page = page;
        write_pool(&e);
        uint8_t *const begin = e.page + e.position;
        write_code(&e, calls);
        if (!e.full && mprotect(page, e.size, PROT_READ | PROT_EXEC) == 0) {
            memcpy(run, &begin, sizeof begin);
            *remembered = e.remembered;
            free(e.where);
            free(e.by_state);
            return native;
        }
    }
    free(e.where);
    free(e.by_state);
    if (page != MAP_FAILED)
        munmap(page, e.size);
    free(native);
    return NULL;
}

void native_destroy(struct native *native)
{
    if (native)
        munmap(native->page, native->size);
    free(native);
}

#else

struct native *native_create(const struct program *program, program_function **run, int *remembered)
{
    (void)program, (void)run, (void)remembered;
    return NULL;
}

void native_destroy(struct native *native)
{
    (void)native;
}

#endif
