// SPDX-License-Identifier: GPL-3.0-or-later
// The same problems by boost odeint, where it is installed.
#include <array>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <cmath>
#include <string>
#include <vector>

extern "C" {
#include "bench/problem.h"
}

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;
using pair = std::array<double, 2>;

// ---- fixed steps ----

// Each scene's terms, and no others, where the compiler sees them.
#define FORCE(scene, value)                                                                                            \
    struct scene {                                                                                                     \
        known f;                                                                                                       \
        void operator()(const pair &y, pair &dydt, double) const                                                       \
        {                                                                                                              \
            dydt[0] = y[1];                                                                                            \
            dydt[1] = value;                                                                                           \
        }                                                                                                              \
    };
FORCE(duffing, -f.k * y[0] - f.b * y[0] * y[0] * y[0])
FORCE(drag, -f.k * y[0] - f.c * std::fabs(y[1]) * y[1])
FORCE(vanderpol, -f.k * y[0] + f.mu * (1 - y[0] * f.narrow * (y[0] * f.narrow)) * y[1])

template <class stepper, class force>
static void loop(const known *f, double h, int64_t first, int64_t count, double *state, double *row)
{
    const force system{*f};
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

template <class stepper> static hand_loop *of_scene(const std::string &scene)
{
    return scene == "duffing" ? loop<stepper, duffing> : scene == "quadratic drag" ? loop<stepper, drag> : loop<stepper, vanderpol>;
}

hand_loop *boost_loop(const char *method, const char *scene)
{
    const std::string name = method;
    return name == "euler"    ? of_scene<odeint::euler<pair>>(scene)
           : name == "rk4"    ? of_scene<odeint::runge_kutta4<pair>>(scene)
           : name == "dopri5" ? of_scene<odeint::runge_kutta_dopri5<pair>>(scene)
                              : nullptr;
}

// ---- adaptive ----

template <std::size_t n> using values = std::array<double, n>;

struct oscillator {
    void operator()(const values<2> &y, values<2> &dydt, double) const
    {
        dydt[0] = y[1];
        dydt[1] = -y[0];
    }
};

struct kepler {
    void operator()(const values<4> &y, values<4> &dydt, double) const
    {
        const double square = y[0] * y[0] + y[1] * y[1], pull = 1 / (square * std::sqrt(square));
        dydt[0] = y[2];
        dydt[1] = y[3];
        dydt[2] = -pull * y[0];
        dydt[3] = -pull * y[1];
    }
};

template <class stepper, class slope, std::size_t n>
static bool controlled(const problem *p, double tol, const double *start, double *end)
{
    values<n> y;
    std::copy(start, start + n, y.begin());
    odeint::integrate_adaptive(odeint::make_controlled<stepper>(tol, tol), slope{}, y, 0.0, p->span, 0.01);
    std::copy(y.begin(), y.end(), end);
    return true;
}

template <class slope, std::size_t n> static bool recorded(const problem *p, double tol, const double *start, double *end)
{
    values<n> y;
    std::vector<double> rows;
    std::copy(start, start + n, y.begin());
    odeint::integrate_adaptive(odeint::make_controlled<odeint::runge_kutta_dopri5<values<n>>>(tol, tol), slope{}, y, 0.0, p->span, 0.01,
                               [&rows](const values<n> &state, double t) {
                                   rows.push_back(t);
                                   rows.insert(rows.end(), state.begin(), state.end());
                               });
    std::copy(y.begin(), y.end(), end);
    return !rows.empty();
}

bool boost_recorded(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? recorded<oscillator, 2>(p, tol, start, end) : recorded<kepler, 4>(p, tol, start, end);
}

bool boost_fehlberg78(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? controlled<odeint::runge_kutta_fehlberg78<values<2>>, oscillator, 2>(p, tol, start, end)
                     : controlled<odeint::runge_kutta_fehlberg78<values<4>>, kepler, 4>(p, tol, start, end);
}

bool boost_dopri5(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? controlled<odeint::runge_kutta_dopri5<values<2>>, oscillator, 2>(p, tol, start, end)
                     : controlled<odeint::runge_kutta_dopri5<values<4>>, kepler, 4>(p, tol, start, end);
}

using vector = ublas::vector<double>;
using matrix = ublas::matrix<double>;

struct relaxation {
    void operator()(const vector &y, vector &dydt, double) const
    {
        dydt[0] = y[1];
        dydt[1] = 1000 * (1 - y[0] * y[0]) * y[1] - y[0];
    }
    void operator()(const vector &y, matrix &jac, double, vector &dfdt) const
    {
        jac(0, 0) = 0;
        jac(0, 1) = 1;
        jac(1, 0) = -2000 * y[0] * y[1] - 1;
        jac(1, 1) = 1000 * (1 - y[0] * y[0]);
        dfdt[0] = dfdt[1] = 0;
    }
};

struct reaction {
    void operator()(const vector &y, vector &dydt, double) const
    {
        const double burn = 3e7 * y[1] * y[1];
        dydt[0] = 1e4 * y[1] * y[2] - 0.04 * y[0];
        dydt[1] = -dydt[0] - burn;
        dydt[2] = burn;
    }
    void operator()(const vector &y, matrix &jac, double, vector &dfdt) const
    {
        jac(0, 0) = -0.04;
        jac(0, 1) = 1e4 * y[2];
        jac(0, 2) = 1e4 * y[1];
        jac(1, 0) = 0.04;
        jac(1, 1) = -1e4 * y[2] - 6e7 * y[1];
        jac(1, 2) = -1e4 * y[1];
        jac(2, 0) = jac(2, 2) = 0;
        jac(2, 1) = 6e7 * y[1];
        dfdt[0] = dfdt[1] = dfdt[2] = 0;
    }
};

template <class slope> static bool rosenbrock(const problem *p, double tol, const double *start, double *end)
{
    const std::size_t n = std::size_t(p->n);
    vector y(n);
    double least = p->scale[0];
    for (std::size_t i = 0; i < n; i++) {
        y[i] = start[i];
        least = std::min(least, p->scale[i]);
    }
    try {
        odeint::integrate_adaptive(odeint::make_controlled<odeint::rosenbrock4<double>>(tol * least, tol),
                                   std::make_pair(slope{}, slope{}), y, 0.0, p->span, 1e-4);
    } catch (const std::exception &) {
        return false;
    }
    std::copy(y.begin(), y.end(), end);
    return true;
}

bool boost_rosenbrock4(const problem *p, double tol, const double *start, double *end)
{
    return p->n == 2 ? rosenbrock<relaxation>(p, tol, start, end) : rosenbrock<reaction>(p, tol, start, end);
}
