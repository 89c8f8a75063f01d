/* SPDX-License-Identifier: GPL-3.0-or-later */
/* boost VARIABLES TOL SPAN: an adaptive run by boost odeint as a program, with all of its steps in
 * memory; of the oscillator, or of the orbit of Kepler's problem with e = 0.5. */
#include "bench/problem.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
#ifdef HAVE_BOOST
    if (argc == 4) {
        const int n = atoi(argv[1]);
        const struct problem problem = {.n = n, .span = strtod(argv[3], NULL)};
        const double swing[] = {1, 0}, orbit[] = {0.5, 0, 0, sqrt(3)};
        double end[PROBLEM_MAX];
        boost_recorded(&problem, strtod(argv[2], NULL), n == 2 ? swing : orbit, end);
        printf("t = %g s, %.17g %.17g\n", problem.span, end[0], end[1]);
        return 0;
    }
#endif
    (void)argc;
    (void)argv;
    return 2;
}
