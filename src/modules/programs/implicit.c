/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A step of backward Euler: in closed form for oscillators, else by Newton's iteration, as
 * src/method/step/newton_body.h has both. */
#include "modules/programs/program.h"

#include <math.h>
#include <string.h>

static bool closes(const struct scene_program *p)
{
    const struct system *system = &p->written.system;
    return system->order == 2 && system->n == 2 && system->oscillator.whole;
}

/* ---- closed form ---- */

void program_coefficient(struct scene_program *p, double value, const char *one, const char *over)
{
    const int a = scene_param(p->scene, one), b = over ? scene_param(p->scene, over) : -1;
    const double *param = p->scene->value;
    if (a < 0 || (over && b < 0) || (over ? param[a] / param[b] : param[a]) != value) {
        buffer_real(p->out, value);
        return;
    }
    p->reads[p->written.params + a] = true;
    buffer_put(p->out, text_of(p->name[p->written.params + a]));
    if (!over)
        return;
    p->reads[p->written.params + b] = true;
    buffer_format(p->out, "/%s", p->name[p->written.params + b]);
}

static void put_closed(struct scene_program *p, const char *indent)
{
    const struct oscillator *o = &p->written.system.oscillator;
    const struct syntax *s = p->syntax;
    const char *h = p->step, *y = program_state(p, 0), *v = program_state(p, 1), *in = s->constant,
               *abs = s->dialect == DIALECT_C ? "fabs" : "abs";
    program_comment(p, indent,
                    "v' = v + h (F - stiffness (y + h v') - damping v' ...) solved for v'");
    buffer_format(p->out, "%s%sforce = ", indent, in);
    struct buffer time = {0};
    buffer_format(&time, "t + %s", h);
    program_call(p, PART_FORCE, 0, buffer_view(&time), NULL);
    buffer_free(&time);
    buffer_format(p->out, "%s\n%s%sinverse = 1/(1 + damping*%s + stiffness*%s*%s)%s\n", s->stop,
                  indent, in, h, h, h, s->stop);
    if (o->quadratic != 0) {
        buffer_format(p->out, "%s%sbend = 4*(quadratic*%s*inverse)*inverse%s\n", indent, in, h,
                      s->stop);
        buffer_format(p->out, "%s%sv_free = %s + %s*force%s\n", indent, in, v, h, s->stop);
        buffer_format(p->out, "%s%sv_new = 2*(v_free*inverse)/(1 + sqrt(1 + bend*%s(v_free)))%s\n",
                      indent, in, abs, s->stop);
        buffer_format(p->out, "%s%slost = quadratic*%s*%s(v_new)%s\n", indent, in, h, abs, s->stop);
    } else {
        buffer_format(p->out, "%s%sv_new = (%s + %s*force)*inverse%s\n", indent, in, v, h, s->stop);
    }
    buffer_format(p->out, "%s%s = %s + %s*v_new%s\n", indent, y, y, h, s->stop);
    const char *lost = o->quadratic != 0 ? " - lost*v_new" : "",
               *size = o->quadratic != 0 ? " + lost" : "";
    /* the branch of newton_body.h: known where there is no quadratic drag */
    const double dt = p->settings.dt, a = 1 + o->damping * dt + o->stiffness * dt * dt;
    struct buffer small = {0};
    buffer_format(&small, "%s + ((%s*force - %s*(stiffness*%s + damping)*v_new)%s)", v, h, h, h,
                  lost);
    if (o->quadratic == 0 && !p->partial)
        buffer_format(p->out, "%s%s = %s%s\n", indent, v,
                      fabs(a - 1) < 1 ? buffer_view(&small) : "v_new", s->stop);
    else if (s->dialect == DIALECT_PYTHON)
        buffer_format(p->out,
                      "%s%s = %s if abs(1 + damping*%s + stiffness*%s*%s - 1%s) < 1 else v_new\n",
                      indent, v, buffer_view(&small), h, h, h, size);
    else if (s->dialect == DIALECT_C)
        buffer_format(
            p->out,
            "%s%s = fabs(1 + damping*%s + stiffness*%s*%s - 1%s) < 1\n%s    ? %s\n%s    : v_new;\n",
            indent, v, h, h, h, size, indent, buffer_view(&small), indent);
    else
        buffer_format(p->out, "%s%s = v_new;\n", indent, v);
    p->out->failed |= small.failed;
    buffer_free(&small);
}

static void put_closed_constants(struct scene_program *p)
{
    const struct oscillator *o = &p->written.system.oscillator;
    const struct syntax *s = p->syntax;
    buffer_format(p->out, "%sstiffness = ", s->global);
    program_coefficient(p, o->stiffness, "k", "m");
    buffer_format(p->out, "%s %s[1/s^2]%s\n%sdamping = ", s->stop, s->comment, s->comment_end,
                  s->global);
    program_coefficient(p, o->damping, "gamma", NULL);
    buffer_format(p->out, "%s %s[1/s]%s\n", s->stop, s->comment, s->comment_end);
    if (o->quadratic != 0) {
        buffer_format(p->out, "%squadratic = ", s->global);
        buffer_real(p->out, o->quadratic);
        buffer_format(p->out, "%s %s[1/m] of |v| v%s\n", s->stop, s->comment, s->comment_end);
    }
    buffer_char(p->out, '\n');
}

/* ---- Newton's iteration ---- */

static void put_unpacked(struct scene_program *p)
{
    const bool c = p->syntax->dialect == DIALECT_C;
    for (int i = 0; i < program_n(p); i++)
        buffer_format(p->out, "%s%s%s = state[%d]",
                      i == 0 ? (c ? "    const double " : "    ")
                      : c    ? ", "
                             : "; ",
                      program_state(p, i), "", i);
    buffer_format(p->out, "%s\n", p->syntax->stop);
    for (int i = 0; c && i < program_n(p); i++)
        buffer_format(p->out, "%s(void)%s", i ? ", " : "    (void)t, ", program_state(p, i));
    buffer_put(p->out, c ? TEXT(";\n") : TEXT(""));
}

void program_derivatives(struct scene_program *p)
{
    const bool c = p->syntax->dialect == DIALECT_C;
    const int n = program_n(p), positions = n - p->written.rows;
    buffer_put(
        p->out,
        c ? TEXT(
                "static void derivatives(double t, const double state[], double derivative[])\n{\n")
          : TEXT("def derivatives(t, state):\n"));
    put_unpacked(p);
    buffer_put(p->out, c ? TEXT("") : TEXT("    return ["));
    for (int i = 0; i < n; i++) {
        if (c)
            buffer_format(p->out, "    derivative[%d] = ", i);
        if (i < positions)
            buffer_put(p->out, text_of(program_state(p, i + positions)));
        else
            program_call(p, PART_ALL, i - positions, "t", NULL);
        buffer_put(p->out, c ? TEXT(";\n") : i + 1 < n ? TEXT(", ") : TEXT("]\n"));
    }
    buffer_put(p->out, c ? TEXT("}\n\n") : TEXT("\n\n"));
}

static void put_jacobian(struct scene_program *p)
{
    const struct written *w = &p->written;
    const bool c = p->syntax->dialect == DIALECT_C;
    const int n = program_n(p), positions = n - w->rows;
    buffer_format(p->out,
                  c ? "/* the derivative of derivative[i] by state[k] is slopes[%d*i + k] */\n"
                      "static void jacobian(double t, const double state[], double slopes[])\n{\n"
                    : "def jacobian(t, state):  # the derivative of derivative[i] by state[k] is "
                      "slopes[%d*i + k]\n",
                  n);
    put_unpacked(p);
    if (c)
        buffer_format(p->out, "    for (int i = 0; i < %d; i++)\n        slopes[i] = 0;\n", n * n);
    else
        buffer_format(p->out, "    slopes = [0.0]*%d\n", n * n);
    for (int i = w->observed; i < w->names; i++) {
        buffer_format(p->out, "    %s%s = ", p->syntax->constant, p->name[i]);
        program_expr(p, w->observe[i - w->observed]);
        buffer_format(p->out, "%s\n", p->syntax->stop);
        if (c)
            buffer_format(p->out, "    (void)%s;\n", p->name[i]);
    }
    for (int i = 0; i < p->slopes.parts; i++) {
        if (w->zero[w->names + i])
            continue;
        buffer_format(p->out, "    %s%s = ", p->syntax->constant, p->name[w->names + i]);
        program_expr(p, p->slopes.part[i]);
        buffer_format(p->out, "%s\n", p->syntax->stop);
    }
    for (int i = 0; i < positions; i++)
        buffer_format(p->out, "    slopes[%d] = 1%s\n", i * n + positions + i, p->syntax->stop);
    for (int i = 0; i < w->rows * n; i++) {
        if (!p->slopes.entry[i] || expr_absent(p->slopes.entry[i], w->zero))
            continue;
        buffer_format(p->out, "    slopes[%d] = ", positions * n + i);
        program_expr(p, p->slopes.entry[i]);
        buffer_format(p->out, "%s\n", p->syntax->stop);
    }
    buffer_put(p->out, c ? TEXT("}\n\n") : TEXT("    return slopes\n\n\n"));
}

void program_sizes(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    const bool c = p->syntax->dialect == DIALECT_C;
    buffer_put(p->out, c ? TEXT("static const double size[] = {") : TEXT("size = ["));
    for (int i = 0; i < system->n; i++) {
        buffer_put(p->out, i ? TEXT(", ") : TEXT(""));
        buffer_real(p->out, system->scale[i]);
    }
    buffer_put(p->out, c ? TEXT("}; /* of the state, to compare errors with */\n")
                         : TEXT("]  # of the state, to compare errors with\n"));
}

/* ---- both ---- */

void program_implicit_functions(struct scene_program *p)
{
    if (closes(p)) {
        put_closed_constants(p);
        program_functions(p, PART_FORCE);
        return;
    }
    program_sizes(p);
    buffer_put(p->out, p->syntax->dialect == DIALECT_C ? TEXT("\n") : TEXT("\n\n"));
    program_functions(p, PART_ALL);
    program_derivatives(p);
    put_jacobian(p);
}

void program_implicit_step(struct scene_program *p, const char *indent)
{
    const struct system *system = &p->written.system;
    const bool c = p->syntax->dialect == DIALECT_C,
               motion = system->order == 2 && system->n == 2 && !system->linear;
    if (closes(p)) {
        put_closed(p, indent);
        return;
    }
    program_comment(p, indent, "change = h f(t + h, now + change), by Newton's iteration");
    buffer_format(p->out, c ? "%sconst double now[] = {" : "%schange = solve(t + %s, %s, [", indent,
                  p->step, p->step);
    for (int i = 0; i < system->n; i++)
        buffer_format(p->out, "%s%s", i ? ", " : "", program_state(p, i));
    if (c)
        buffer_format(
            p->out,
            "};\n%sdouble change[%d] = {0};\n%sif (!solve_%s(%st + %s, %s, now, change)) {\n"
            "%s    fprintf(stderr, \"no solution after t = %%g\\n\", t);\n"
            "%s    return 3;\n%s}\n",
            indent, system->n, indent, motion ? "motion" : "stage",
            motion           ? ""
            : system->linear ? "true, "
                             : "false, ",
            p->step, p->step, indent, indent, indent);
    else
        buffer_format(p->out,
                      "])\n%sif change is None:\n"
                      "%s    print(\"no solution after t =\", t, file=sys.stderr)\n%s    break\n",
                      indent, indent, indent);
    for (int i = 0; i < system->n; i++)
        buffer_format(p->out, "%s%s = %s + change[%d]%s\n", indent, program_state(p, i),
                      program_state(p, i), i, p->syntax->stop);
}
