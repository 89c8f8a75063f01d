/*
 * damped: linear damping: amplitude falls as exp(-gamma t/2), energy as exp(-gamma t)
 *    y'' = -k/m*y - gamma*v
 * by symplectic-euler: symplectic Euler, position first (lab eq. 12; Cromer's own order is symplectic-euler-kick)
 * dt = 0.01 s, from t = 0 s to 10 s; written by hooke 0.1.0
 * hooke's bits by: gcc -O2 -ffp-contract=off FILE.c -lm && ./a.out >run.csv
 */
#include <math.h>
#include <stdio.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static void propagate_prepare(double h, bool symplectic);
static void propagate(long i, double state[2]);

static const double m = 0.2; /* [kg] mass of the bob */
static const double k = 15; /* [N/m] spring constant */
#define gamma gamma_ /* a function of the C library has its name */
static const double gamma = 0.25; /* [1/s] linear damping of y'' + gamma y' + omega0^2 y = 0 */

static const double dt = 0.01; /* [s] time step */
static const long steps = 1000;

static double force(double y)
{
    return -k/m*y;
}

static double drag(double v)
{
    return -gamma*v;
}

/* One step of symplectic-euler. */
static void step(double t, double h, double state[])
{
    double y = state[0], v = state[1];
    (void)t;
    y = y + h*v;
    double a = force(y);
    v = v + h*(a + drag(v));
    state[0] = y;
    state[1] = v;
}

/* The scene is linear: hooke takes 32 steps at once by powers of the matrix of one
 * ('set kernel specialised': one by one). */
int main(void)
{
    double t = 0; /* [s] */
    double y = 0.05; /* [m] */
    double v = 0; /* [m/s] */
    double state[] = {y, v};
    puts("t,y,v");
    printf("%.17g,%.17g,%.17g\n", t, y, v);
    propagate_prepare(dt, false);
    for (long i = 0; i < steps; i++) {
        propagate(i, state);
        y = state[0];
        v = state[1];
        if (!(fabs(y) <= 1e150 && fabs(v) <= 8.660254037844387e150)) {
            fprintf(stderr, "diverged after t = %g\n", t);
            return 3;
        }
        t = (double)(i + 1)*dt;
        printf("%.17g,%.17g,%.17g\n", t, y, v);
    }
    return 0;
}

/* ---- hooke's own functions: the same bits on every machine ---- */

#define BLOCK 32
static double propagate_row[BLOCK][2][3] = {{{0}}}; /* of j + 1 steps: by y, by v, what is added */

static long double propagate_last[2][3] = {{0}};    /* the last of them with all digits */

/* Powers of the matrix of one step, which is found by stepping unit vectors. */
static void propagate_prepare(double h, bool symplectic)
{
    double shift[2] = {0, 0}, column[2][2] = {{1, 0}, {0, 1}};
    long double m[2][2], taken[2][2] = {{1, 0}, {0, 1}}, sum[2] = {0, 0}, next[2][2], next_sum[2];
    step(0, h, shift);
    step(0, h, column[0]);
    step(0, h, column[1]);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
            m[i][j] = (long double)column[j][i] - (long double)shift[i];
    const long double determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    if (symplectic && fabsl(determinant - 1) < 1e-6L)
        for (int i = 0; i < 4; i++)
            m[i / 2][i % 2] *= 1 / sqrtl(determinant);
    for (int j = 0; j < BLOCK; j++) {
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < 2; k++)
                next[i][k] = m[i][0] * taken[0][k] + m[i][1] * taken[1][k];
            next_sum[i] = m[i][0] * sum[0] + m[i][1] * sum[1] + (long double)shift[i];
        }
        memcpy(taken, next, sizeof taken);
        memcpy(sum, next_sum, sizeof sum);
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < 2; k++) {
                propagate_last[i][k] = taken[i][k];
                propagate_row[j][i][k] = (double)taken[i][k];
            }
            propagate_last[i][2] = sum[i];
            propagate_row[j][i][2] = (double)sum[i];
        }
    }
}

/* The state after step i, from that where its block of steps began. */
static void propagate(long i, double state[2])
{
    static double y, v;
    if (i % BLOCK == 0) {
        y = state[0];
        v = state[1];
    }
    for (int k = 0; k < 2; k++) {
        const double *by = propagate_row[i % BLOCK][k];
        const long double *last = propagate_last[k];
        state[k] = i % BLOCK < BLOCK - 1 ? by[0] * y + by[1] * v + by[2]
                                         : (double)(last[0] * y + last[1] * v + last[2]);
    }
}
