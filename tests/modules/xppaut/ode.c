/* SPDX-License-Identifier: GPL-3.0-or-later */
/* .ode files as typed scenes: what each statement becomes, and what is refused, where and why. */
#include "unit/scene/testing.h"

#include "modules/xppaut/ode_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool taken(struct text name)
{
    return text_is(name, "dt") || text_is(name, "size");
}

struct read {
    struct arena arena;
    struct ode_scene scene;
    struct error error;
    struct buffer lines; /* as one types them, each with its newline */
};

static bool read_set(struct read *r, const char *file, const char *set)
{
    const struct ode_options options = {.set = text_of(set), .taken = taken};
    *r = (struct read){.lines = {0}};
    const bool fine = ode_read(text_of(file), &options, &r->arena, &r->scene, &r->error);
    for (int i = 0; fine && i < r->scene.lines; i++) {
        typed_describe(&r->scene.line[i], &r->lines);
        buffer_char(&r->lines, '\n');
    }
    return fine;
}

static void done(struct read *r)
{
    arena_reset(&r->arena);
    buffer_free(&r->lines);
}

static void becomes(const char *file, const char *lines)
{
    struct read r;
    if (!read_set(&r, file, ""))
        fail_msg("%s: %s", file, r.error.text);
    assert_string_equal(buffer_view(&r.lines), lines);
    done(&r);
}

static void refused(const char *file, const char *why)
{
    struct read r;
    if (read_set(&r, file, ""))
        fail_msg("taken: %s", file);
    if (!strstr(r.error.text, why))
        fail_msg("%s: '%s' instead of '%s'", file, r.error.text, why);
    done(&r);
}

/* The right-hand side of x' = FORMULA, with a, b and c as parameters and f, g as functions. */
static void formula(const char *there, const char *here)
{
    char file[600], line[600];
    struct read r;
    snprintf(file, sizeof file, "par a=1,b=2,c=3\nf(u)=u^2-a\ng(u,v)=f(u)*f(v)\nx'=%s\ndone",
             there);
    snprintf(line, sizeof line, "x' = %s\n", here);
    if (!read_set(&r, file, ""))
        fail_msg("%s: %s", there, r.error.text);
    const char *equation = strstr(buffer_view(&r.lines), "x' = ");
    assert_string_equal(equation ? equation : "", line);
    done(&r);
}

TEST(test_statements)
{
    becomes("# a comment\nPAR K=.5, M = 2 c=-1e-1,d\nX'=V\ndV/dt=-k*X/m\ninit "
            "X=3\nv(0)=-1\ndone\nx'=bad",
            "param k = 0.5\nparam m = 2\nparam c = -0.1\nparam d = 0\nvar x = 3\nvar v = -1\n"
            "x' = v\nv' = (-k)*x/m\n");
    becomes("number q=2\n!p=2*q\nx'=-h*p\nh=x+p\naux e=h^2\n\"a button {q=3}\nonly x\nd",
            "param q = 2\nvar x = 0\nobserve p = 2*q\nobserve h = x + p\nobserve e = h^2\n"
            "x' = (-h)*p\n");
    becomes("x'=1+ \\\n  2*x\ny'=x",
            "var x = 0\nvar y = 0\nx' = 1 + 2*x\ny' = x\n"); /* no `done` */
}

TEST(test_arrays)
{
    becomes("x[1..3]'=[j]*x[j]\ninit x[2..3]=4\nd",
            "var x1 = 0\nvar x2 = 4\nvar x3 = 4\nx1' = 1*x1\nx2' = 2*x2\nx3' = 3*x3\n");
    becomes("%[1..2]\nx[j]'=y[j+1]\ny[j*2]'=-x[j]\n%\ny3'=x[2]\nd",
            "var x1 = 0\nvar y2 = 0\nvar x2 = 0\nvar y4 = 0\nvar y3 = 0\nx1' = y2\ny2' = -x1\n"
            "x2' = y3\ny4' = -x2\ny3' = x2\n");
    becomes("x[2..1]'=0\nx[1..1](0)=7\nd", "var x2 = 0\nvar x1 = 7\nx2' = 0\nx1' = 0\n");
    becomes("x0'=x\nx'=x0\nd", "var x0_1 = 0\nvar x = 0\nx0_1' = x\nx' = x0_1\n");
    formula("sum(0,2)of(shift(a,i')*i')", "(a*0 + b*1 + c*2)");
    formula("sum(2,1)of(x)", "0");
}

TEST(test_formulas)
{
    formula("-x^2", "-(x^2)");
    formula("2^3^2", "(2^3)^2");     /* from the left: 64 */
    formula("1+x<2", "1 + (x < 2)"); /* comparisons bind as powers do */
    formula("2*x==a", "2*((x <= a)*(x >= a))");
    formula("-x<1", "-(x < 1)");
    formula("a-(b-c)", "a - (b - c)");
    formula("a/(b*c)/x", "a/(b*c)/x");
    formula("a*b**2", "a*b^2");
    formula("f(x)", "x^2 - a");
    formula("g(x+1,2*f(b))", "((x + 1)^2 - a)*((2*(b^2 - a))^2 - a)");
    formula("if(x>1)then(a)else(b)", "if((x > 1), a, b)");
    formula("if(x)then(a)else(b)", "if(abs(x), a, b)");
    formula("not(x>1)&a|b<=2", "max(((1 - (x > 1))*abs(sign(a))), (b <= 2))");
    formula("a!=b", "(1 - (a <= b)*(a >= b))");
    formula("heav(x)+ln(a)+flr(x)", "step(x) + log(a) + floor(x)");
    formula("mod(x,2*3)", "mod(x, 2*3)");
    formula("mod(x,a)", "(sign(x)*mod(abs(x), abs(a)) + a*(sign(x)*mod(abs(x), abs(a)) < 0))");
    formula("sin(T)*PI", "sin(t)*pi");
}

TEST(test_names)
{
    struct read r;
    assert_true(read_set(&r, "par dt=1,x0=2,step=3\nx'=dt+x0+step\naux p.e=x\naux x=1\nd", ""));
    assert_string_equal(buffer_view(&r.lines),
                        "param dt_1 = 1\nparam x0_1 = 2\nparam step_1 = 3\nvar x = 0\n"
                        "observe p_e = x\nobserve x_1 = 1\nx' = dt_1 + x0_1 + step_1\n");
    assert_int_equal(r.scene.notes, 5);
    assert_string_equal(r.scene.note[0].text, "line 1: dt is called dt_1 here");
    assert_false(r.scene.note[0].warns);
    done(&r);
}

TEST(test_settings)
{
    struct read r;
    const char *file =
        "x'=a\npar a=1\n@ total=5 dt=.1,meth=gear,tol=1e-5\n@ TOTAL=7, nout=4, xlo=3\n"
        "set other {a=3,x=2 total=9,meth=e}\nd";
    assert_true(read_set(&r, file, ""));
    assert_true(r.scene.total == 7 && r.scene.dt == 0.1 && r.scene.every == 4 &&
                r.scene.tol == 1e-5);
    assert_string_equal(r.scene.method, "radau5");
    assert_true(r.scene.adapts && r.scene.meant && r.scene.sets == 1);
    done(&r);
    assert_true(read_set(&r, file, "other"));
    assert_true(r.scene.total == 9 && r.scene.tol == 0 && !r.scene.adapts);
    assert_string_equal(r.scene.method, "euler");
    assert_non_null(strstr(buffer_view(&r.lines), "param a = 3\nvar x = 2\n"));
    done(&r);
    assert_false(read_set(&r, file, "othr"));
    assert_string_equal(r.error.hint, "did you mean 'other'?");
    done(&r);
    assert_true(read_set(&r, "x'=1\n", "")); /* XPPAUT's own */
    assert_true(r.scene.total == 20 && r.scene.dt == 0.05 && r.scene.every == 1);
    assert_string_equal(r.scene.method, "rk4");
    done(&r);
}

/* Written out: straight lines, and sums over neighbours, with parameters as the file has them. */
TEST(test_tables)
{
    becomes("table w % 3 0 2 b*t^2\npar a=4\n!b=a/2\nx'=w(x-1)+w(2)\nd",
            "param a = 4\nvar x = 0\nobserve b = a/2\n"
            "x' = 0 + 2*(x - 1 - 0) + 4*max(x - 1 - 1, 0) + (0 + 2*(2 - 0) + 4*max(2 - 1, 0))\n");
    becomes("table g % 3 -1 1 f(t)\nf(u)=u+2\nspecial k=conv(even,3,1,g,x0)\n"
            "special p=conv(per,3,1,g,x0)\nspecial z=conv(0,3,1,g,x0)\nx[0..2]'=k([j])\n"
            "aux p=p(0)-p(9)\naux z=z(2)\nd",
            "var x0 = 0\nvar x1 = 0\nvar x2 = 0\n"
            "observe p = 1*x2 + 2*x0 + 3*x1 - 0\nobserve z = 1*x1 + 2*x2\n"
            "x0' = 1*x1 + 2*x0 + 3*x1\nx1' = 1*x0 + 2*x1 + 3*x2\nx2' = 1*x1 + 2*x2 + 3*x1\n");
}

TEST(test_events)
{
    struct read r;
    assert_true(read_set(&r,
                         "x'=y\ny'=-1\npar b=.5\nf(u)=b*u\nglobal -1 x {x=0;y=-f(y)}\n"
                         "glob 1 {t-5} {b=1}\nglobal 1 y>2 {arret=1}\nd",
                         ""));
    assert_int_equal(r.scene.events, 3);
    assert_string_equal(r.scene.event[0].when, "x falling");
    assert_string_equal(r.scene.event[0].commands, "x = 0; y = -(b*y); continue");
    assert_string_equal(r.scene.event[1].commands, "b = 1; continue");
    assert_string_equal(r.scene.event[2].when, "(y > 2) rising");
    assert_string_equal(r.scene.event[2].commands, "");
    done(&r);
}

TEST(test_refused)
{
    static const struct {
        const char *file, *why;
    } cases[] = {
        {"x'=-x+w\nwiener w\nd", "line 2: scenes have no noise"},
        {"x'=delay(x,1)\nd", "line 1: scenes have no delays"},
        {"x'=del_shft(x,1,2)\nd", "line 1: scenes have no delays"},
        {"x'=ran(1)\nd", "line 1: scenes have no random numbers"},
        {"x'=1\nmarkov z 2\n{0} {1}\n{1} {0}\nd", "line 2: scenes have no Markov"},
        {"x[0..9]'=-x[j]\nspecial k=sparse(10,5,w,i,x0)\nd", "line 2: scenes have no networks"},
        {"special k=conv(even,10,12,w,x0)\nx'=1\nd", "line 1: write a network as special"},
        {"special k=conv(even,2,1,w,x)\nx'=k(0)\nd", "line 1: its weights must be a table of 3"},
        {"table w % 3 0 1 t\nspecial k=conv(even,9,1,w,x)\nx'=k(0)\nd",
         "line 2: there are fewer than 9"},
        {"table w % 3 0 1 t\nspecial k=conv(even,2,1,w,x)\nx'=k(x)\ny'=1\nd", "the index in 'k'"},
        {"table w values.tab\nx'=w(x)\nd", "line 1: the numbers of the table are in another file"},
        {"table w % 1 0 1 t\nx'=w(x)\nd", "line 1: write a table as table NAME"},
        {"table w % 5 0 1 w(t)\nx'=w(x)\nd", "line 1: the table depends on itself"},
        {"table w % 5 0 1 x*t\nx'=w(x)\nd", "line 1: a table has 'x', which changes"},
        {"table w % 5 0 1 ran(t)\nx'=w(x)\nd", "line 1: scenes have no random numbers"},
        {"table w % 5 0 1 1/t\nx'=w(x)\nd", "line 1: the table has no number at 0"},
        {"table w % 5 0 1 t\nx'=w(x,1)\nd", "line 2: w() is called with the wrong number"},
        {"table w % 5 0 1 t\nx'=w\nd", "line 2: w is a function"},
        {"x(t+1)=x/2\nd", "line 1: scenes have continuous time"},
        {"x'=x/2\n@ meth=discrete\nd", "line 2: method discrete: scenes have continuous time"},
        {"u(t)=sin(t)+int{exp(-t)#u}\nd", "line 1: scenes have no integral equations"},
        {"u'=-u+int{exp(-t)#u}\nd", "line 1: scenes have no integral equations"},
        {"volt u=1\nd", "line 1: scenes have no integral equations"},
        {"x'=y\n0=x+y\nsolve y=1\nd", "line 2: scenes have no algebraic equations"},
        {"x'=y\ny=0\nexport {x} {y}\nd", "line 3: scenes have no values computed by a C library"},
        {"x'=erf(x)\nd", "line 1: expressions have no function 'erf'"},
        {"2\nv x=1\nd", "line 1: this is a file of the old style"},
        {"#include other.ode\nx'=1", "line 1: included files are not read"},
        {"x'=z\nd", "line 1: there is no 'z'"},
        {"x'=1\nx'=2\nd", "line 2: 'x' is defined twice: in line 1"},
        {"x'=1\npar x=2\nd", "line 2: 'x' is defined twice"},
        {"x'=1\npar t=2\nd", "line 2: 't' already means something"},
        {"x'=1\ninit y=2\nd", "line 2: there is no variable 'y'"},
        {"x'=1\nx(0)=1-t\nd", "line 2: x(0)=1-t: an initial value must be a number"},
        {"x'=1\npar a=2*3\nd", "line 2: a=2*3: this needs a number"},
        {"x'=a\na=b\nb=x\nd", "line 2: 'b' is defined later"},
        {"x'=1\n!p=2*x\nd", "line 2: 'x' is not a parameter"},
        {"f(u)=g(u)\ng(u)=f(u)\nx'=f(x)\nd", "functions call each other"},
        {"f(u)=u\nx'=f(x,1)\nd", "line 2: f() is called with the wrong number of arguments"},
        {"x'=2*-3\nd", "line 1: a number or a name is missing"},
        {"x'=(1\nd", "line 1: a ')' is missing"},
        {"x'=if(x)then(1)\nd", "line 1: 'else' is missing"},
        {"x'=i'\nd", "line 1: i' is used outside of a sum"},
        {"x'=sum(0,x)of(i')\nd", "line 1: the limits of a sum"},
        {"x'=shift(x,1)\nd", "line 1: there is no such index after x"},
        {"x[0..2]'=[j\nd", "line 1: a ']' is missing"},
        {"x[0..30000]'=1\nd", "line 1: arrays expand to more than"},
        {"x'=[j]\nd", "line 1: [j] is used outside of an array"},
        {"%[1..2]\nx[j]'=1\nd", "line 1: the group of lines does not end"},
        {"x'=1\nglobal 0 x {x=1}\nd", "line 2: an event needs the sign 1 or -1"},
        {"x'=1\nglobal 1 x {t=1}\nd", "line 2: an event can set a variable or a parameter"},
        {"x'=1\nglobal 1 x\nd", "line 2: write an event as global 1"},
        {"x'=1\nwhatever this is\nd", "line 2: unknown statement"},
        {"par a=1\nd", "there is no equation"},
        {"x'=1\n@ total=-5\nd", "must be above 0"},
        {"x'=1\n@ dt=abc\nd", "line 2: dt=abc"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        refused(cases[i].file, cases[i].why);
}

/* What others may hand over: long lines, deep nesting, chains. */
TEST(test_large)
{
    struct read r;
    struct buffer file = {0};
    buffer_put(&file, TEXT("x'=0"));
    for (int i = 0; i < 1500; i++)
        buffer_put(&file, TEXT("+x"));
    assert_true(read_set(&r, buffer_view(&file), ""));
    done(&r);
    for (int i = 0; i < 20000; i++)
        buffer_put(&file, TEXT("+x"));
    refused(buffer_view(&file), "line 1: the formula has more than");
    buffer_clear(&file);
    buffer_put(&file, TEXT("x'="));
    for (int i = 0; i < 30000; i++)
        buffer_char(&file, '(');
    refused(buffer_view(&file), "line 1: nested too deeply");
    buffer_clear(&file);
    buffer_put(&file, TEXT("f0(u)=u+u\n"));
    for (int i = 1; i < 40; i++)
        buffer_format(&file, "f%d(u)=f%d(u)+f%d(u)\n", i, i - 1, i - 1);
    buffer_put(&file, TEXT("x'=f39(x)\n"));
    refused(buffer_view(&file), "the formula is too long");
    buffer_clear(&file);
    buffer_put(&file, TEXT("x'=1\npar "));
    for (int i = 0; i < 1025; i++)
        buffer_format(&file, "p%d ", i);
    refused(buffer_view(&file), "line 2: the file has more than 1024 names");
    buffer_free(&file);
}

RUN_TESTS(NULL, NULL)
