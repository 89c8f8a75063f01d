/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Random large scenes, which are run: as many variables, parameters, observed quantities, switches,
 * events, names and operations as the limits allow, some fewer or some more. The bytes choose the
 * counts: '=' the limit, '+' one more, '-' one less, any other a part of it.
 */
#define CORPUS "scene"
#define UNIT "runs"
#define QUICK_SECONDS 3
#define SCRIPTED_NS 30000000 /* of processor time: what is stopped has not run */
#define SCRIPTED_CLOCK CLOCK_PROCESS_CPUTIME_ID
#define FUZZ_SEEDS
#include "fuzz/replay.h"
#include "fuzz/scripted.h"

enum { READ_LIMIT = 62, SWITCH_LIMIT = 12, SEEDS = 32, STUDIES = 2 };

struct choices {
    const uint8_t *data;
    size_t size, used;
    uint64_t random;
    struct buffer out;
};

size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    uint64_t random = (i + 1) * 88172645463325252u;
    if (i >= SEEDS || max < 16)
        return 0;
    for (int k = 0; k < 16; k++)
        data[k] = fuzz_random(&random) % 2 ? (uint8_t) "=+-"[fuzz_random(&random) % 3]
                                           : (uint8_t)fuzz_random(&random);
    return 16;
}

static int below(struct choices *c, int count)
{
    return (int)(fuzz_random(&c->random) % (uint64_t)count);
}

static int count_near(struct choices *c, int limit)
{
    const uint8_t next = c->used < c->size ? c->data[c->used++] : (uint8_t)fuzz_random(&c->random);
    return next == '='   ? limit
           : next == '+' ? limit + 1
           : next == '-' ? limit - 1
                         : 1 + next % limit;
}

/* Begins an equation with a few summands, each of another kind. */
static void put_equation(struct choices *c, int i, bool second, int variables)
{
    buffer_format(&c->out, "x%d%s = -x%d", i, second ? "''" : "'", i);
    for (int k = below(c, 4); k >= 0; k--)
        switch (below(c, 4)) {
        case 0:
            buffer_put(&c->out, TEXT(" + 1e-3*p0"));
            break;
        case 1:
            buffer_format(&c->out, " + 1e-3*x%d*x%d", below(c, variables), below(c, variables));
            break;
        case 2:
            buffer_format(&c->out, " + exp(-((t - 0.%d)/1e-3)^2)", below(c, 9));
            break;
        default:
            buffer_format(&c->out, " + 1e-3*sin(x%d + t)", below(c, variables));
        }
}

static void put_nested(struct choices *c, int depth)
{
    buffer_put(&c->out, TEXT("observe deep = "));
    for (int i = 0; i < depth; i++)
        buffer_put(&c->out, i % 2 ? TEXT("(1 + ") : TEXT("sin("));
    buffer_put(&c->out, TEXT("x0"));
    for (int i = 0; i < depth; i++)
        buffer_char(&c->out, ')');
    buffer_char(&c->out, '\n');
}

/* Those at the limits come last: where they are refused, the scene before them runs. */
static void put_scene(struct choices *c)
{
    const bool second = below(c, 2);
    const int all_variables = count_near(c, second ? LIMIT_VARIABLES / 2 : LIMIT_VARIABLES);
    const int reads = count_near(c, READ_LIMIT), observed = count_near(c, LIMIT_OBSERVED);
    const int switches = count_near(c, SWITCH_LIMIT), width = count_near(c, LIMIT_SYMBOL);
    buffer_format(&c->out, "scene new %.*s\n", width, "large_scene_with_the_longest_name_");
    const int variables = all_variables <= LIMIT_VARIABLES ? all_variables : LIMIT_VARIABLES;
    for (int i = 0; i < all_variables; i++)
        buffer_format(&c->out, "var x%d = 0.%d\n", i, i);
    for (int i = 0; i < reads; i++)
        buffer_format(&c->out, "param p%d = 0.%d\n", i, i);
    put_nested(c, count_near(c, LIMIT_EXPR_DEPTH));
    for (int i = 1; i < observed; i++)
        buffer_format(&c->out, "observe o%d = x%d*%d\n", i, below(c, variables), i);
    for (int i = 0; i < variables; i++) {
        put_equation(c, i, second, variables);
        buffer_char(&c->out, '\n');
    }
    put_equation(c, 0, second, variables);
    for (int k = 0; k < switches; k++)
        buffer_format(&c->out, " + 1e-3*sign(x%d - 0.%d)", k % variables, k);
    buffer_char(&c->out, '\n');
    put_equation(c, 1, second, variables);
    for (int k = 0; k < reads; k++)
        buffer_format(&c->out, " + 1e-9*p%d", k);
    for (int k = 1; k < observed; k++)
        buffer_format(&c->out, " + 1e-9*o%d", k);
    buffer_char(&c->out, '\n');
    put_equation(c, 2, second, variables);
    for (int k = count_near(c, LIMIT_EXPR_SIZE / 8); k > 0; k--)
        buffer_format(&c->out, " + 1e-9*sin(x%d + t)", below(c, variables));
    buffer_char(&c->out, '\n');
    for (int i = (second ? 2 : 1) * variables + reads + 1, all = count_near(c, LIMIT_PARAMETERS);
         i < all; i++)
        buffer_format(&c->out, "param q%d = %d\n", i, i);
}

static void put_lists(struct choices *c)
{
    for (int i = 0, events = count_near(c, LIMIT_EVENTS); i < events; i++)
        buffer_format(&c->out, "event e%d when x0 - 0.%d do record\n", i, i);
    for (int i = 0, lets = count_near(c, LIMIT_LET); i < lets; i++)
        buffer_format(&c->out, "let l%d = %d\n", i, i);
    for (int i = 0, points = count_near(c, LIMIT_CHECKPOINTS); i < points; i++)
        buffer_format(&c->out, "checkpoint c%d\n", i);
    buffer_put(&c->out, TEXT("print 0"));
    for (int i = 1, words = count_near(c, LIMIT_TOKENS); i < words; i++)
        buffer_put(&c->out, TEXT("+1"));
    buffer_char(&c->out, '\n');
}

static void put_runs(struct choices *c)
{
    static const char *const studies[] = {"list events",
                                          "list observables",
                                          "plot position",
                                          "plot phase",
                                          "plot all",
                                          "plot energy",
                                          "plot portrait",
                                          "show all",
                                          "plan",
                                          "scene",
                                          "equilibria",
                                          "stability rk4",
                                          "lyapunov",
                                          "basins",
                                          "orbit",
                                          "branch p0=0:1",
                                          "sweep p0=0:1:0.5",
                                          "order rk4",
                                          "compare rk4 verlet",
                                          "continue 0.1 s",
                                          "back 2",
                                          "step 3",
                                          "change x0 0.5",
                                          "undo",
                                          "export a.csv --force",
                                          "export a.py --force",
                                          "export a.tex --force",
                                          "export a.c --force",
                                          "save a.hk --force",
                                          "measure period",
                                          "data",
                                          "runs",
                                          "print o1, x0, energy",
                                          "potential x0^2/2",
                                          "atol x0=1e-9",
                                          "stress",
                                          "precision",
                                          "selftest",
                                          "describe",
                                          "fit p0"};
    for (int k = 0; k < STUDIES; k++) {
        const char *method =
            catalog_row(&method_catalog, (size_t)below(c, (int)method_catalog.count))->name;
        if (k == 0)
            method = "dopri5"; /* of which bursts are looked for */
        buffer_format(&c->out, "method %s%s\nrun 0.0%d s\n", method, below(c, 2) ? "" : " dt=10ms",
                      1 + below(c, 9));
        for (int i = below(c, 4); i >= 0; i--)
            buffer_format(&c->out, "%s\n", studies[below(c, (int)COUNT_OF(studies))]);
    }
    buffer_put(&c->out, TEXT("save last.hk --force\n"));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scripted_settle();
    struct choices c = {.data = data, .size = size, .random = fuzz_hash(data, size) | 1};
    put_scene(&c);
    put_lists(&c);
    put_runs(&c);
    struct reply reply;
    struct session *session = scripted_create(c.random, &reply);
    if (!session || c.out.failed)
        abort();
    const unsigned long before = fuzz_units;
    scripted_play(session, &reply, buffer_text(&c.out), 1);
    fuzz_units = before + (unsigned long)session->runs.count;
    if (size > 0 && data[0] == '=' && session->runs.count == 0)
        abort(); /* a scene at the limits has to run */
    scripted_destroy(session, &reply);
    buffer_free(&c.out);
    return 0;
}
