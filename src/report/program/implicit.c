/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "report/program/program.h"
void program_implicit_functions(struct program *p)
{
    (void)p;
}
void program_implicit_step(struct program *p, const char *indent)
{
    (void)p;
    (void)indent;
}
bool program_xpp(struct program *p)
{
    (void)p;
    return true;
}
bool program_tex(struct program *p)
{
    (void)p;
    return true;
}
