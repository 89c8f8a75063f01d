/* How the period of a pendulum grows with its amplitude: hooke inside a program.
 *
 *     cc pendulum.c $(pkg-config --cflags --libs hooke) && ./a.out
 */
#include <hooke/api.h>

#include <stdio.h>

static int fail(const struct hooke *lab)
{
    const struct hooke_error *error = hooke_error(lab);
    fprintf(stderr, "line %d, column %d: %s\n%s\n", error->line, error->column, error->message,
            error->hint);
    return error->status;
}

int main(void)
{
    struct hooke *lab = hooke_open(0);
    double period, uncertainty;
    char line[80];

    if (hooke_run(lab, "scene pendulum\n"
                       "method rk4 dt=1ms") != 0)
        return fail(lab);
    for (int degrees = 10; degrees <= 170; degrees += 40) {
        snprintf(line, sizeof line, "theta0 = %d deg; run 20 s; measure period", degrees);
        if (hooke_run(lab, line) != 0)
            return fail(lab);
        if (hooke_value(lab, "measured_period", &period, &uncertainty))
            printf("%3d deg  T = %.6f +- %.1g s\n", degrees, period, uncertainty);
    }

    /* Columns of the last run, as `export` would write them. */
    struct hooke_table *run = hooke_table(lab, "t theta energy");
    if (!run)
        return fail(lab);
    const double *t = hooke_column(run, "t"), *theta = hooke_column(run, "theta");
    const size_t last = hooke_rows(run) - 1;
    printf("%zu rows; the last: t = %.17g s, theta = %.17g rad\n", last + 1, t[last], theta[last]);
    hooke_table_free(run);
    hooke_close(lab);
    return 0;
}
