/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A damaged file of a session: it is restored, with notes of what is missing, or refused; never a
 * crash, and what was restored can be drawn, used and kept again. Any bytes as they are; and whole
 * records and fields that are missing, doubled, cut or elsewhere, and numbers that are any, whose
 * checksums are made right: a checksum is no seal.
 */
#include <hooke/view.h>

#define CORPUS "session_file"
#define UNIT "session files"
#define FUZZ_SEEDS
#define FUZZ_MUTATOR
#include "fuzz/mend.h"
#include "fuzz/replay.h"
#include "fuzz/scripted.h"
#include "fuzz/stored.h"

static const char *const sessions[] = {
    "run 1 s; continue 0.3 s; note first; rename 1 a; k = 20; method verlet dt=3ms; run 0.2 s",
    "load swing.txt as=x; data window 1:4; data zero 0.2; measure period; fit damped; layout duo",
    ("scene pendulum; m = 200 +- 0.3 g; param q = 3.0(1); observe w = q*v; event top when v "
     "falling "
     "do record; run 0.5 s; change gamma 0.3; continue 0.2 s"),
    "compare euler verlet rk4 dt=10ms,5ms; let A = 4.2 +- 0.1 cm; undo; checkpoint c; back 2",
    "var z = 1; z' = -z; run 0.3 s until z < 0.8; cursor; range y 0:1; set record every 3; lesson",
    "load swing.txt as=one; load speed.txt as=two; data join two; data clean apply; atol y = 1e-9",
    "sweep k=10:20 3; stability; order; stress; precision; window 3; trail all; timing full",
};

/* The first byte of an input: what it is taken as. */
enum { AS_IT_IS, MENDED };

/* Played and kept. */
size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    struct buffer file = {0};
    struct reply reply;
    scripted_settle();
    const unsigned long units = fuzz_units;
    if (i >= COUNT_OF(sessions))
        return 0;
    struct session *session = scripted_create(1, &reply);
    if (!session)
        abort();
    scripted_play(session, &reply, text_of(sessions[i]), 0);
    fuzz_units = units;
    buffer_char(&file, MENDED);
    stored_put(session, &file);
    const size_t len = file.len < max ? file.len : max;
    memcpy(data, file.data, len);
    buffer_free(&file);
    scripted_destroy(session, &reply);
    return len;
}

/* ---- what is wrong with a file whose sums are right: parts are missing, doubled, cut ---- */

static size_t pick(uint64_t *random, size_t count)
{
    return (size_t)(fuzz_random(random) % count);
}

/* The numbers before the rows; the rows themselves stay. */
static void change_rows(struct text content, struct buffer *out, uint64_t *random)
{
    static const uint64_t edges[] = {0, 1, 2, 0x7fffffff, 1ull << 62, UINT64_MAX};
    struct rows_head head;
    buffer_put(out, content);
    if (content.len < sizeof head || out->failed)
        return;
    const uint64_t number = edges[pick(random, COUNT_OF(edges))];
    memcpy(out->data + out->len - content.len + 8 * pick(random, sizeof head / 8), &number, 8);
}

/* One of its fields. */
static void change_field(struct text content, struct buffer *out, uint64_t *random)
{
    struct text rest = content, name, value, before = content;
    size_t count = 0;
    while (field_next(&rest, &name, &value))
        count++;
    size_t chosen = count ? pick(random, count) : 0;
    for (rest = content; before = rest, field_next(&rest, &name, &value); chosen--) {
        const struct text whole = {before.data, before.len - rest.len};
        const size_t act = chosen == 0 ? pick(random, 4) : 4;
        if (act == 0)
            continue;
        if (act >= 2)
            buffer_put(out, whole);
        if (act == 2)
            buffer_put(out, whole);
        if (act == 3)
            buffer_put(out, content);
        if (act != 1)
            continue;
        buffer_char(out, (char)name.len);
        buffer_put(out, name);
        const uint32_t len = (uint32_t)pick(random, value.len + 1);
        buffer_put(out, (struct text){(const char *)&len, sizeof len});
        buffer_put(out, (struct text){value.data, len});
    }
}

/* One of its fields, or of those within it; no fields: all of it. */
static struct text some_field(struct text content, uint64_t *random)
{
    for (int depth = 0; depth < 4; depth++) {
        struct text rest = content, name, value;
        size_t count = 0;
        while (field_next(&rest, &name, &value))
            count++;
        if (count == 0 || rest.len > 0)
            break;
        size_t chosen = pick(random, count);
        for (rest = content; field_next(&rest, &name, &value) && chosen > 0;)
            chosen--;
        content = value;
    }
    return content;
}

/* A number, whatever it is the number of: a flag, a count, a place, a value. */
static void change_number(struct text content, struct buffer *out, uint64_t *random)
{
    static const double values[] = {0, 1, -1, 1e-300, 1e300, HUGE_VAL, -HUGE_VAL, NAN};
    static const uint64_t edges[] = {0,          1,          2,          7,          0xff,
                                     0x7fffffff, 0x80000000, 1ull << 62, UINT64_MAX, 1ull << 40};
    const struct text field = some_field(content, random);
    const size_t from = out->len + (size_t)(field.data - content.data),
                 bytes = 1u << pick(random, 4);
    uint64_t number = edges[pick(random, COUNT_OF(edges))];
    buffer_put(out, content);
    if (field.len < bytes || out->failed)
        return;
    if (bytes == 8 && pick(random, 2) == 0)
        memcpy(&number, &values[pick(random, COUNT_OF(values))], sizeof number);
    if (pick(random, 4) == 0)
        number = fuzz_random(random) >> pick(random, 64);
    memcpy(out->data + from + bytes * pick(random, field.len / bytes), &number, bytes);
}

/* A record that is missing, doubled, elsewhere, or has another content. */
static void change_record(struct text in, struct buffer *out, uint64_t *random)
{
    const uint8_t *data = (const uint8_t *)in.data;
    size_t from = next_record(data, in.len, 1), count = 0;
    for (size_t at = from; at < in.len; at = next_record(data, in.len, at + 1))
        count++;
    for (size_t skip = count > 1 ? pick(random, count) : 0; skip > 0; skip--)
        from = next_record(data, in.len, from + 1);
    const size_t end = from < in.len ? next_record(data, in.len, from + 1) : in.len;
    const size_t act = pick(random, 8);
    const struct text record = {in.data + from, end - from};
    const size_t head = sizeof(struct record_head);
    buffer_put(out, (struct text){in.data, from});
    if (act >= 1 && act <= 2)
        buffer_put(out, record);
    if (act >= 2 && act <= 7 && record.len >= head) {
        const struct text content = {record.data + head, record.len - head};
        buffer_put(out, (struct text){record.data, head});
        if (record.data[offsetof(struct record_head, kind)] == RECORD_ROWS)
            change_rows(content, out, random);
        else if (act >= 5)
            change_number(content, out, random);
        else
            change_field(content, out, random);
    }
    buffer_put(out, (struct text){in.data + end, in.len - end});
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
    uint64_t random = seed * 2654435761u + 88172645463325252u;
    if (size < 64 || pick(&random, 32) == 0)
        return fuzz_seed(pick(&random, COUNT_OF(sessions)), data, max);
    if (pick(&random, 16) == 0)
        data[0] = AS_IT_IS;
    if (data[0] == AS_IT_IS)
        return 1 + LLVMFuzzerMutate(data + 1, size - 1, max - 1);
    struct buffer out = {0};
    change_record((struct text){(const char *)data, size}, &out, &random);
    const size_t len = out.failed ? 0 : out.len < max ? out.len : max;
    if (len > 0)
        memcpy(data, out.data, len);
    buffer_free(&out);
    return len;
}

static void use(struct session *session, struct reply *reply)
{
    static const char lines[] =
        "runs\nshow all\ncontinue 0.1 s\nmeasure period\nexport a.csv --force\ndata\nundo\nredo\n"
        "run 0.1 s\nback 1\nplot\nreport r --force\nsave a.hk --force\n";
    const struct prompt_line prompt = {.prompt = TEXT("hooke> ")};
    struct canvas canvas;
    if (canvas_init(&canvas, 80, 24)) {
        screen_draw(session, &prompt, &canvas, NULL, NULL);
        canvas_free(&canvas);
    }
    const unsigned long units = fuzz_units;
    scripted_play(session, reply, TEXT(lines), 1);
    fuzz_units = units;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scripted_settle();
    const uint64_t choice = fuzz_hash(data, size);
    struct buffer file = {0}, notes = {0}, kept = {0};
    struct reply reply;
    struct session *session = scripted_create(choice, &reply);
    if (!session)
        abort();
    fuzz_units++;
    if (size > 0)
        buffer_put(&file, (struct text){(const char *)data + 1, size - 1});
    if (size > sizeof STORE_HEADER && data[0] == MENDED)
        mend((uint8_t *)file.data, file.len);
    scripted_time(20 * SCRIPTED_NS);
    if (stored_take(session, buffer_text(&file), &notes)) {
        if (choice % 2 == 0)
            use(session, &reply);
        scripted_time(20 * SCRIPTED_NS);
        stored_put(session, &kept);
    }
    scripted_time(0);
    buffer_free(&kept);
    buffer_free(&file);
    buffer_free(&notes);
    scripted_destroy(session, &reply);
    return 0;
}
