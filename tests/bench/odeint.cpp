// SPDX-License-Identifier: GPL-3.0-or-later
// The same problems by boost odeint, where it is installed.
#include <array>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <cmath>

extern "C" {
#include "problem.h"
}

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;
using pair = std::array<double, 2>;

// ---- fixed steps ----

struct oscillator {
    known f;
    void operator()(const pair &y, pair &dydt, double) const
    {
        dydt[0] = y[1];
        dydt[1] = -f.k * y[0] - f.c * std::fabs(y[1]) * y[1] - f.b * y[0] * y[0] * y[0] +
                  f.mu * (1 - y[0] * f.narrow * (y[0] * f.narrow)) * y[1];
    }
};

template <class stepper>
static void loop(const known *f, double h, int64_t first, int64_t count, double *state, double *row)
{
    const oscillator system{*f};
    stepper step;
    pair y{state[0], state[1]};
    for (int64_t i = 0; i < count; i++) {
        step.do_step(system, y, double(first + i) * h, h);
        *row++ = y[0];
        *row++ = y[1];
    }
    state[0] = y[0];
    state[1] = y[1];
}

void boost_euler_loop(const known *f, double h, int64_t first, int64_t count, double *state, double *row)
{
    loop<odeint::euler<pair>>(f, h, first, count, state, row);
}

void boost_rk4_loop(const known *f, double h, int64_t first, int64_t count, double *state, double *row)
{
    loop<odeint::runge_kutta4<pair>>(f, h, first, count, state, row);
}

void boost_dopri5_loop(const known *f, double h, int64_t first, int64_t count, double *state, double *row)
{
    loop<odeint::runge_kutta_dopri5<pair>>(f, h, first, count, state, row);
}

// ---- adaptive ----

template <class stepper, std::size_t n>
static bool controlled(const problem *p, double tol, const double *start, double *end)
{
    std::array<double, n> y;
    std::copy(start, start + n, y.begin());
    const auto slope = [p](const std::array<double, n> &x, std::array<double, n> &dxdt, double t) {
        p->slope(t, x.data(), dxdt.data());
    };
    odeint::integrate_adaptive(odeint::make_controlled<stepper>(tol, tol), slope, y, 0.0, p->span, 0.01);
    std::copy(y.begin(), y.end(), end);
    return true;
}

template <std::size_t n> using values = std::array<double, n>;

bool boost_fehlberg78(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? controlled<odeint::runge_kutta_fehlberg78<values<2>>, 2>(p, tol, start, end)
                     : controlled<odeint::runge_kutta_fehlberg78<values<4>>, 4>(p, tol, start, end);
}

bool boost_dopri5(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? controlled<odeint::runge_kutta_dopri5<values<2>>, 2>(p, tol, start, end)
                     : controlled<odeint::runge_kutta_dopri5<values<4>>, 4>(p, tol, start, end);
}

bool boost_rosenbrock4(const problem *p, double tol, const double *start, double *end)
{
    using vector = ublas::vector<double>;
    const std::size_t n = std::size_t(p->n);
    vector y(n);
    double least = p->scale[0];
    for (std::size_t i = 0; i < n; i++) {
        y[i] = start[i];
        least = std::min(least, p->scale[i]);
    }
    const auto slope = [p](const vector &x, vector &dxdt, double t) { p->slope(t, &x[0], &dxdt[0]); };
    const auto jacobian = [p, n](const vector &x, ublas::matrix<double> &jac, double t, vector &dfdt) {
        p->jacobian(t, &x[0], &jac(0, 0));
        std::fill(dfdt.begin(), dfdt.end(), 0.0);
    };
    try {
        odeint::integrate_adaptive(odeint::make_controlled<odeint::rosenbrock4<double>>(tol * least, tol),
                                   std::make_pair(slope, jacobian), y, 0.0, p->span, 1e-4);
    } catch (const std::exception &) {
        return false;
    }
    std::copy(y.begin(), y.end(), end);
    return true;
}
