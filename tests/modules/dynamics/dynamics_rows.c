/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Special points, periods and multipliers of systems from the literature, each value known by two
 * ways (closed forms, or 30 digits and more), to the digits on which these agree, at most 12.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

static struct typed_models *models;

struct special_row {
    const char *name, *lines[16], *param;
    double from, to; /* of the parameter */
    enum solution_kind kind;
    double period, start; /* of the solution that the branch begins with; the parameter there */
    double state[4];
    enum special leave; /* the first such point is left for the branch that is looked at */
    enum special special;
    double value; /* of the parameter, or of the criticality */
    int digits;
    bool criticality;
};

/* clang-format off */
static const struct special_row special_rows[] = {
    {"trans-bp", {"var x = 0.1", "param m_p = 0.5", "x' = m_p*x-x^2"},
     "m_p", -1, 1, SOLUTION_EQUILIBRIUM, 0, -0.5, {0.0},
     SPECIAL_NONE, SPECIAL_CROSSING, 0.0, 12, false},
    {"rm-tc", {"var x = 0.1", "var y = 0.1", "param m_p = 0.5", "param K_p = 0.5",
      "x' = x*(1-x/K_p)-x*y/(1+x)", "y' = x*y/(1+x)-m_p*y"},
     "K_p", 0.5, 1.5, SOLUTION_EQUILIBRIUM, 0, 0.7, {0.7, 0.0},
     SPECIAL_NONE, SPECIAL_CROSSING, 1.0, 12, false},
    {"pend-sb", {"var q = 0.1", "var v = 0.1", "param Q_p = 2", "param g_p = 0.5", "q' = v",
      "v' = -v/Q_p-sin(q)+g_p*cos(2*t/3)"},
     "g_p", 0.95, 1.02, SOLUTION_RESPONSE, 0, 0.99, {-1.07195431488, 1.89723173328},
     SPECIAL_NONE, SPECIAL_CROSSING, 1.004319477426468, 12, false},
    {"pend-sb-2", {"var q = 0.1", "var v = 0.1", "param Q_p = 2", "param g_p = 0.5", "q' = v",
      "v' = -v/Q_p-sin(q)+g_p*cos(2*t/3)"},
     "g_p", 0.95, 1.02, SOLUTION_RESPONSE, 0, 0.9882, {-1.07195431488, 1.89723173328},
     SPECIAL_NONE, SPECIAL_CROSSING, 1.004319477426468, 12, false},
    {"pair-hopf-crit", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "var w = 0.1", "param a_p = 0.5",
      "x' = (a_p-1)*x", "y' = (a_p-1)*y", "z' = (a_p-0.001)*z-2*w-z*(z^2+w^2)",
      "w' = 2*z+(a_p-0.001)*w-w*(z^2+w^2)"},
     "a_p", -0.2, 0.2, SOLUTION_EQUILIBRIUM, 0, -0.1, {0.0, 0.0, 0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, -1.0, 8, true},
    {"brus-hopf-crit", {"var x = 0.1", "var y = 0.1", "param a_p = 1", "param b_p = 0.5",
      "x' = a_p-(b_p+1)*x+x^2*y", "y' = b_p*x-x^2*y"},
     "b_p", 0.5, 4, SOLUTION_EQUILIBRIUM, 0, 1, {1.0, 1.0},
     SPECIAL_NONE, SPECIAL_HOPF, -0.5, 7, true},
    {"cstr-hopf-crit", {"var u1 = 0.1", "var u2 = 0.1", "param p2_p = 14", "param p3_p = 2",
      "param p1_p = 0.5", "u1' = -u1+p1_p*(1-u1)*exp(u2)",
      "u2' = -u2+p1_p*p2_p*(1-u1)*exp(u2)-p3_p*u2"},
     "p1_p", 0, 0.3, SOLUTION_EQUILIBRIUM, 0, 0, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, -0.388954536, 7, true},
    {"jerk-hopf-crit", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param be_p = 1",
      "param al_p = 0.5", "x' = y", "y' = z", "z' = -al_p*z-be_p*y-x+x^2"},
     "al_p", 0.5, 2, SOLUTION_EQUILIBRIUM, 0, 0.7, {0.0, 0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, -0.3, 8, true},
    {"mls-hopf-crit", {"var v = 0.1", "var w = 0.1", "param gca_p = 4", "param phi_p = 0.067",
      "param v3_p = 12", "param v4_p = 17.4", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", -20, 130, SOLUTION_EQUILIBRIUM, 0, 60, {5.0, 0.35},
     SPECIAL_NONE, SPECIAL_HOPF, 0.002103692553, 8, true},
    {"rm-hopf-crit", {"var x = 0.1", "var y = 0.1", "param m_p = 0.5", "param K_p = 0.5",
      "x' = x*(1-x/K_p)-x*y/(1+x)", "y' = x*y/(1+x)-m_p*y"},
     "K_p", 1.5, 5, SOLUTION_EQUILIBRIUM, 0, 2, {1.0, 1.0},
     SPECIAL_NONE, SPECIAL_HOPF, -0.244948974, 7, true},
    {"selkov-hopf-hi-crit", {"var x = 0.1", "var y = 0.1", "param a_p = 0.08", "param b_p = 0.5",
      "x' = -x+a_p*y+x^2*y", "y' = b_p-a_p*y-x^2*y"},
     "b_p", 0.5, 1, SOLUTION_EQUILIBRIUM, 0, 0.5, {0.5, 1.5},
     SPECIAL_NONE, SPECIAL_HOPF, -0.283808628, 7, true},
    {"selkov-hopf-lo-crit", {"var x = 0.1", "var y = 0.1", "param a_p = 0.08", "param b_p = 0.5",
      "x' = -x+a_p*y+x^2*y", "y' = b_p-a_p*y-x^2*y"},
     "b_p", 0.1, 0.5, SOLUTION_EQUILIBRIUM, 0, 0.5, {0.5, 1.5},
     SPECIAL_NONE, SPECIAL_HOPF, -1.0541463, 6, true},
    {"subhopf-hopf-crit", {"var x = 0.1", "var y = 0.1", "param mu_p = 0.5",
      "x' = mu_p*x-2*y+x*(x^2+y^2)-x*(x^2+y^2)^2", "y' = 2*x+mu_p*y+y*(x^2+y^2)-y*(x^2+y^2)^2"},
     "mu_p", -1, 1, SOLUTION_EQUILIBRIUM, 0, -0.5, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, 1.0, 7, true},
    {"adler-fold", {"var q = 0.1", "param w_p = 0.5", "q' = w_p-sin(q)"},
     "w_p", 0, 2, SOLUTION_EQUILIBRIUM, 0, 0.5, {0.5},
     SPECIAL_NONE, SPECIAL_FOLD, 1.0, 12, false},
    {"cstr-fold-lo", {"var u1 = 0.1", "var u2 = 0.1", "param p2_p = 14", "param p3_p = 2",
      "param p1_p = 0.5", "u1' = -u1+p1_p*(1-u1)*exp(u2)",
      "u2' = -u2+p1_p*p2_p*(1-u1)*exp(u2)-p3_p*u2"},
     "p1_p", 0, 0.3, SOLUTION_EQUILIBRIUM, 0, 0, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_FOLD, 0.10573897827165065, 12, false},
    {"cusp-fold-p", {"var x = 0.1", "param r_p = 1", "param h_p = 0.5", "x' = h_p+r_p*x-x^3"},
     "h_p", -2, 2, SOLUTION_EQUILIBRIUM, 0, 0, {1.0},
     SPECIAL_NONE, SPECIAL_FOLD, 0.38490017945975051, 12, false},
    {"cusp-fold-r2", {"var x = 0.1", "param r_p = 2", "param h_p = 0.5", "x' = h_p+r_p*x-x^3"},
     "h_p", -2, 2, SOLUTION_EQUILIBRIUM, 0, 0, {1.4},
     SPECIAL_NONE, SPECIAL_FOLD, 1.0886621079036347, 12, false},
    {"ml-fold-lo", {"var v = 0.1", "var w = 0.1", "param gca_p = 4", "param phi_p = 0.067",
      "param v3_p = 12", "param v4_p = 17.4", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", -20, 130, SOLUTION_EQUILIBRIUM, 0, 60, {5.0, 0.35},
     SPECIAL_NONE, SPECIAL_FOLD, -9.9490393226230648, 12, false},
    {"ml-fold-snic", {"var v = 0.1", "var w = 0.1", "param gca_p = 4", "param phi_p = 0.067",
      "param v3_p = 12", "param v4_p = 17.4", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", -20, 130, SOLUTION_EQUILIBRIUM, 0, 60, {5.0, 0.35},
     SPECIAL_NONE, SPECIAL_FOLD, 39.963153092745353, 12, false},
    {"ros-fold", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param a_p = 0.2",
      "param b_p = 0.2", "param c_p = 0.5", "x' = -y-z", "y' = x+a_p*y", "z' = b_p+z*(x-c_p)"},
     "c_p", 0, 1, SOLUTION_EQUILIBRIUM, 0, 0.7, {0.06, -0.3, 0.3},
     SPECIAL_NONE, SPECIAL_FOLD, 0.4, 12, false},
    {"duff-hard-fold1", {"var x = 0.1", "var v = 0.1", "param d_p = 0.1", "param k_p = 1",
      "param b_p = 1", "param F_p = 0.3", "param w_p = 0.5", "x' = v",
      "v' = -d_p*v-k_p*x-b_p*x^3+F_p*cos(w_p*t)"},
     "w_p", 0.5, 2.5, SOLUTION_RESPONSE, 0, 0.5, {0.4, 0.0},
     SPECIAL_NONE, SPECIAL_FOLD, 1.3242362007705656, 12, false},
    {"duff-hard-fold2", {"var x = 0.1", "var v = 0.1", "param d_p = 0.1", "param k_p = 1",
      "param b_p = 1", "param F_p = 0.3", "param w_p = 0.5", "x' = v",
      "v' = -d_p*v-k_p*x-b_p*x^3+F_p*cos(w_p*t)"},
     "w_p", 0.5, 2.5, SOLUTION_RESPONSE, 0, 0.5, {0.4, 0.0},
     SPECIAL_NONE, SPECIAL_FOLD, 1.7797195242985731, 12, false},
    {"duff-soft-fold2", {"var x = 0.1", "var v = 0.1", "param d_p = 0.05", "param k_p = 1",
      "param b_p = -1", "param F_p = 0.025", "param w_p = 0.5", "x' = v",
      "v' = -d_p*v-k_p*x-b_p*x^3+F_p*cos(w_p*t)"},
     "w_p", 0.5, 1.5, SOLUTION_RESPONSE, 0, 1.4, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_FOLD, 0.93027616106107775, 12, false},
    {"fhn-fold-orbit", {"var v = 0.1", "var w = 0.1", "param a_p = 0.7", "param b_p = 0.8",
      "param eps_p = 0.08", "param Iext_p = 0.5", "v' = v-v^3/3-w+Iext_p",
      "w' = eps_p*(v+a_p-b_p*w)"},
     "Iext_p", 0, 2, SOLUTION_EQUILIBRIUM, 0, 0.1, {-1.1, -0.5},
     SPECIAL_HOPF, SPECIAL_FOLD, 0.324178522504, 10, false},
    {"lor-fold-orbit", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param b_p = 2.6666666666666665", "param r_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "r_p", 150, 180, SOLUTION_ORBIT, 1.1329, 165.7, {33.7678608, 77.95050488, 164.9919715},
     SPECIAL_NONE, SPECIAL_FOLD, 166.0614921038597, 12, false},
    {"ml-fold-orbit", {"var v = 0.1", "var w = 0.1", "param gca_p = 4.4", "param phi_p = 0.04",
      "param v3_p = 2", "param v4_p = 30", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", 60, 230, SOLUTION_EQUILIBRIUM, 0, 60, {-36.0, 0.06},
     SPECIAL_HOPF, SPECIAL_FOLD, 88.2932505430693, 12, false},
    {"mls-fold-orbit", {"var v = 0.1", "var w = 0.1", "param gca_p = 4", "param phi_p = 0.067",
      "param v3_p = 12", "param v4_p = 17.4", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", -20, 130, SOLUTION_EQUILIBRIUM, 0, 60, {5.0, 0.35},
     SPECIAL_HOPF, SPECIAL_FOLD, 115.94872148782961, 12, false},
    {"hh-hopf-hi", {"var v = 0.1", "var m = 0.1", "var h = 0.1", "var n = 0.1",
      "param Iext_p = 0.5", "v' = Iext_p-120*m^3*h*(v-115)-36*n^4*(v+12)-0.3*(v-10.599)",
      "m' = 0.1*(25-v)/(exp((25-v)/10)-1)*(1-m)-4*exp(-v/18)*m",
      "h' = 0.07*exp(-v/20)*(1-h)-h/(exp((30-v)/10)+1)",
      "n' = 0.01*(10-v)/(exp((10-v)/10)-1)*(1-n)-0.125*exp(-v/80)*n"},
     "Iext_p", 0, 200, SOLUTION_EQUILIBRIUM, 0, 0, {0.0, 0.05, 0.6, 0.32},
     SPECIAL_NONE, SPECIAL_HOPF, 154.526633665808, 12, false},
    {"hh-hopf-lo", {"var v = 0.1", "var m = 0.1", "var h = 0.1", "var n = 0.1",
      "param Iext_p = 0.5", "v' = Iext_p-120*m^3*h*(v-115)-36*n^4*(v+12)-0.3*(v-10.599)",
      "m' = 0.1*(25-v)/(exp((25-v)/10)-1)*(1-m)-4*exp(-v/18)*m",
      "h' = 0.07*exp(-v/20)*(1-h)-h/(exp((30-v)/10)+1)",
      "n' = 0.01*(10-v)/(exp((10-v)/10)-1)*(1-n)-0.125*exp(-v/80)*n"},
     "Iext_p", 0, 200, SOLUTION_EQUILIBRIUM, 0, 0, {0.0, 0.05, 0.6, 0.32},
     SPECIAL_NONE, SPECIAL_HOPF, 9.7796379953931263, 12, false},
    {"jerk-hopf", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param be_p = 1",
      "param al_p = 0.5", "x' = y", "y' = z", "z' = -al_p*z-be_p*y-x+x^2"},
     "al_p", 0.5, 2, SOLUTION_EQUILIBRIUM, 0, 0.7, {0.0, 0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, 1.0, 12, false},
    {"lor-hopf", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param b_p = 2.6666666666666665", "param r_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "r_p", 15, 30, SOLUTION_EQUILIBRIUM, 0, 20, {7.118, 7.118, 19.0},
     SPECIAL_NONE, SPECIAL_HOPF, 24.736842105263158, 12, false},
    {"lor-hopf-s16", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 16",
      "param b_p = 2.6666666666666665", "param r_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "r_p", 15, 30, SOLUTION_EQUILIBRIUM, 0, 20, {7.118, 7.118, 19.0},
     SPECIAL_NONE, SPECIAL_HOPF, 28.108108108108108, 12, false},
    {"ml-hopf-hi", {"var v = 0.1", "var w = 0.1", "param gca_p = 4.4", "param phi_p = 0.04",
      "param v3_p = 2", "param v4_p = 30", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", 60, 230, SOLUTION_EQUILIBRIUM, 0, 60, {-36.0, 0.06},
     SPECIAL_NONE, SPECIAL_HOPF, 212.01881610037437, 12, false},
    {"ml-hopf-lo", {"var v = 0.1", "var w = 0.1", "param gca_p = 4.4", "param phi_p = 0.04",
      "param v3_p = 2", "param v4_p = 30", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", 60, 230, SOLUTION_EQUILIBRIUM, 0, 60, {-36.0, 0.06},
     SPECIAL_NONE, SPECIAL_HOPF, 93.857618373725453, 12, false},
    {"mls-hopf", {"var v = 0.1", "var w = 0.1", "param gca_p = 4", "param phi_p = 0.067",
      "param v3_p = 12", "param v4_p = 17.4", "param Iext_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "Iext_p", -20, 130, SOLUTION_EQUILIBRIUM, 0, 60, {5.0, 0.35},
     SPECIAL_NONE, SPECIAL_HOPF, 97.646163921525908, 12, false},
    {"rm-hopf-m3", {"var x = 0.1", "var y = 0.1", "param m_p = 0.3", "param K_p = 0.5",
      "x' = x*(1-x/K_p)-x*y/(1+x)", "y' = x*y/(1+x)-m_p*y"},
     "K_p", 1.2, 3, SOLUTION_EQUILIBRIUM, 0, 1.5, {0.43, 1.0},
     SPECIAL_NONE, SPECIAL_HOPF, 1.8571428571428571, 12, false},
    {"selkov-hopf-hi", {"var x = 0.1", "var y = 0.1", "param a_p = 0.08", "param b_p = 0.5",
      "x' = -x+a_p*y+x^2*y", "y' = b_p-a_p*y-x^2*y"},
     "b_p", 0.1, 1, SOLUTION_EQUILIBRIUM, 0, 0.5, {0.5, 1.5},
     SPECIAL_NONE, SPECIAL_HOPF, 0.84852813742385703, 12, false},
    {"vdp-hopf", {"var x = 0.1", "var y = 0.1", "param mu_p = 0.5", "x' = y",
      "y' = mu_p*(1-x^2)*y-x"},
     "mu_p", -1, 1, SOLUTION_EQUILIBRIUM, 0, -0.5, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_HOPF, 0.0, 12, false},
    {"fvdp-ns", {"var x = 0.1", "var v = 0.1", "param mu_p = 0.3", "param w_p = 1.4",
      "param F_p = 0.5", "x' = v", "v' = mu_p*(1-x^2)*v-x+F_p*cos(w_p*t)"},
     "F_p", 1.2, 1.6, SOLUTION_RESPONSE, 0, 1.4, {-1.39, -0.36},
     SPECIAL_NONE, SPECIAL_TORUS, 1.39328681789244, 12, false},
    {"lang-ns3", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param be_p = 0.7",
      "param ga_p = 0.6", "param de_p = 3.5", "param ep_p = 0.25", "param ze_p = 0.3",
      "param al_p = 0.5", "x' = (z-be_p)*x-de_p*y", "y' = de_p*x+(z-be_p)*y",
      "z' = ga_p+al_p*z-z^3/3-(x^2+y^2)*(1+ep_p*z)+ze_p*z*x^3"},
     "al_p", 0.65, 0.75, SOLUTION_ORBIT, 1.795, 0.705, {0.899534295366, 0.0, 0.699478569058},
     SPECIAL_NONE, SPECIAL_TORUS, 0.700956188226551, 12, false},
    {"jerk-pd", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param be_p = 1",
      "param al_p = 0.5", "x' = y", "y' = z", "z' = -al_p*z-be_p*y-x+x^2"},
     "al_p", 0.6, 0.66, SOLUTION_ORBIT, 6.364, 0.635, {0.0, 0.572749907609, 0.221777898427},
     SPECIAL_NONE, SPECIAL_DOUBLING, 0.630302006159625, 12, false},
    {"mathd-pd", {"var x = 0.1", "var v = 0.1", "param a_p = 1", "param c_p = 0.2",
      "param q_p = 0.5", "x' = v", "v' = -c_p*v-(a_p-2*q_p*cos(2*t))*x-x^3"},
     "q_p", 0, 1, SOLUTION_RESPONSE, 0, 0.1, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_DOUBLING, 0.20043697629684266, 12, false},
    {"ros-pd1", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param a_p = 0.2",
      "param b_p = 0.2", "param c_p = 0.5", "x' = -y-z", "y' = x+a_p*y", "z' = b_p+z*(x-c_p)"},
     "c_p", 2.4, 3.2, SOLUTION_ORBIT, 5.77, 2.84, {5.10814917515, 0.0, 1.63840068895},
     SPECIAL_NONE, SPECIAL_DOUBLING, 2.83244502786254, 12, false},
    {"ros-pd3", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param a_p = 0.2",
      "param b_p = 0.2", "param c_p = 0.5", "x' = -y-z", "y' = x+a_p*y", "z' = b_p+z*(x-c_p)"},
     "c_p", 4.0, 4.15, SOLUTION_ORBIT, 23.2026, 4.12, {4.82129702743, 0.0, 0.332201022511},
     SPECIAL_NONE, SPECIAL_DOUBLING, 4.1242147320755, 12, false},
    {"mathieu-a0-q1", {"var x = 0.1", "var v = 0.1", "param q_p = 1", "param a_p = 0.5",
      "x' = v", "v' = -(a_p-2*q_p*cos(2*t))*x"},
     "a_p", -1, 3, SOLUTION_RESPONSE, 0, 0.5, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_CROSSING, -0.45513860410741355, 12, false},
    {"mathieu-a0-q5", {"var x = 0.1", "var v = 0.1", "param q_p = 5", "param a_p = 0.5",
      "x' = v", "v' = -(a_p-2*q_p*cos(2*t))*x"},
     "a_p", -7, 3, SOLUTION_RESPONSE, 0, -5.9, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_CROSSING, -5.8000460208515084, 12, false},
    {"mathieu-a1-q1", {"var x = 0.1", "var v = 0.1", "param q_p = 1", "param a_p = 0.5",
      "x' = v", "v' = -(a_p-2*q_p*cos(2*t))*x"},
     "a_p", -1, 3, SOLUTION_RESPONSE, 0, 0.5, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_DOUBLING, 1.8591080725143635, 12, false},
    {"mathieu-b2-q5", {"var x = 0.1", "var v = 0.1", "param q_p = 5", "param a_p = 0.5",
      "x' = v", "v' = -(a_p-2*q_p*cos(2*t))*x"},
     "a_p", 1, 4, SOLUTION_RESPONSE, 0, 2, {0.0, 0.0},
     SPECIAL_NONE, SPECIAL_CROSSING, 2.0994604454866654, 12, false},
};

struct orbit_row {
    const char *name, *lines[16], *param;
    enum solution_kind kind;
    double period, at; /* guess; of the parameter */
    double state[4], value;
    int digits;
    bool is_period; /* the value, not a multiplier */
};

static const struct orbit_row orbit_rows[] = {
    {"brus-b3-m1", {"var x = 0.1", "var y = 0.1", "param a_p = 1", "param b_p = 0.5",
      "x' = a_p-(b_p+1)*x+x^2*y", "y' = b_p*x-x^2*y"},
     "b_p", SOLUTION_ORBIT, 7.16, 3.0, {1.0, 4.468893056209}, 0.00025163757998897, 12, false},
    {"hh-I10-m1", {"var v = 0.1", "var m = 0.1", "var h = 0.1", "var n = 0.1",
      "param Iext_p = 0.5", "v' = Iext_p-120*m^3*h*(v-115)-36*n^4*(v+12)-0.3*(v-10.599)",
      "m' = 0.1*(25-v)/(exp((25-v)/10)-1)*(1-m)-4*exp(-v/18)*m",
      "h' = 0.07*exp(-v/20)*(1-h)-h/(exp((30-v)/10)+1)",
      "n' = 0.01*(10-v)/(exp((10-v)/10)-1)*(1-n)-0.125*exp(-v/80)*n"},
     "Iext_p", SOLUTION_ORBIT, 14.6, 10.0,
     {20.0, 0.2403560476911, 0.3858420625164, 0.4281967275305},
     0.0740473710862964, 12, false},
    {"lor-AB-m1", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param r_p = 28", "param b_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "b_p", SOLUTION_ORBIT, 1.5587, 2.6666666666666665, {-13.76361068213, -19.57875194245, 27.0},
     4.71294727342408, 12, false},
    {"lor-r20-m2", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param r_p = 20", "param b_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "b_p", SOLUTION_ORBIT, 0.877, 2.6666666666666665,
     {10.75568299201, 6.817386408907, 27.31669250605},
     4.47279187408e-6, 10, false},
    {"lor-r24-m1", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param r_p = 24", "param b_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "b_p", SOLUTION_ORBIT, 0.679, 2.6666666666666665,
     {9.360110963424, 7.500456456514, 27.00197082777},
     1.0320882978304, 12, false},
    {"mathieu-mult-u", {"var x = 0.1", "var v = 0.1", "param a_p = 1", "param q_p = 0.5",
      "x' = v", "v' = -(a_p-2*q_p*cos(2*t))*x"},
     "q_p", SOLUTION_RESPONSE, 0, 1.0, {0.0, 0.0}, -4.1560549385828014, 12, false},
    {"ml-I150-m1", {"var v = 0.1", "var w = 0.1", "param Iext_p = 150", "param gca_p = 4.4",
      "param phi_p = 0.04", "param v3_p = 2", "param v4_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "v4_p", SOLUTION_ORBIT, 66.2, 30.0, {0.0, 0.2116092500803}, 7.5687482491196e-5, 12, false},
    {"rm-K4-m1", {"var x = 0.1", "var y = 0.1", "param K_p = 4", "param m_p = 0.5",
      "x' = x*(1-x/K_p)-x*y/(1+x)", "y' = x*y/(1+x)-m_p*y"},
     "m_p", SOLUTION_ORBIT, 55.3, 0.5, {1.0, 0.3678229335251}, 0.000656607104198, 11, false},
    {"vdp-mu05-m1", {"var x = 0.1", "var y = 0.1", "param mu_p = 0.5", "x' = y",
      "y' = mu_p*(1-x^2)*y-x"},
     "mu_p", SOLUTION_ORBIT, 6.38, 0.5, {2.002487930447, 0.0}, 0.0391769202592733, 12, false},
    {"vdp-mu1-m1", {"var x = 0.1", "var y = 0.1", "param mu_p = 0.5", "x' = y",
      "y' = mu_p*(1-x^2)*y-x"},
     "mu_p", SOLUTION_ORBIT, 6.66, 1.0, {2.008619860875, 0.0}, 0.0008596950636038, 11, false},
    {"adler-T", {"var q = 0.1", "param w_p = 0.5", "q' = w_p-sin(q)"},
     "w_p", SOLUTION_ORBIT, 8.3776, 1.25, {0.0}, 8.377580409572782, 12, true},
    {"fhn-I05-T", {"var v = 0.1", "var w = 0.1", "param Iext_p = 0.5", "param a_p = 0.7",
      "param b_p = 0.8", "param eps_p = 0.5", "v' = v-v^3/3-w+Iext_p",
      "w' = eps_p*(v+a_p-b_p*w)"},
     "eps_p", SOLUTION_ORBIT, 39.5, 0.08, {0.0, -0.1566369868583}, 39.474414980241753, 12, true},
    {"lor-r24-T", {"var x = 0.1", "var y = 0.1", "var z = 0.1", "param s_p = 10",
      "param r_p = 24", "param b_p = 0.5", "x' = s_p*(y-x)", "y' = x*(r_p-z)-y",
      "z' = x*y-b_p*z"},
     "b_p", SOLUTION_ORBIT, 0.679, 2.6666666666666665,
     {9.360110963424, 7.500456456514, 27.00197082777},
     0.679336764198218, 12, true},
    {"mls-I42-T", {"var v = 0.1", "var w = 0.1", "param Iext_p = 42", "param gca_p = 4",
      "param phi_p = 0.067", "param v3_p = 12", "param v4_p = 0.5",
      "v' = (Iext_p-2*(v+60)-8*w*(v+84)-gca_p*0.5*(1+tanh((v+1.2)/18))*(v-120))/20",
      "w' = phi_p*(0.5*(1+tanh((v-v3_p)/v4_p))-w)*cosh((v-v3_p)/(2*v4_p))"},
     "v4_p", SOLUTION_ORBIT, 145.4, 17.4, {0.0, 0.03999034523277}, 145.3668347839493, 12, true},
    {"rm-K4-T", {"var x = 0.1", "var y = 0.1", "param K_p = 4", "param m_p = 0.5",
      "x' = x*(1-x/K_p)-x*y/(1+x)", "y' = x*y/(1+x)-m_p*y"},
     "m_p", SOLUTION_ORBIT, 55.3, 0.5, {1.0, 0.3678229335251}, 55.30888188002423, 12, true},
    {"vdp-mu1-T", {"var x = 0.1", "var y = 0.1", "param mu_p = 0.5", "x' = y",
      "y' = mu_p*(1-x^2)*y-x"},
     "mu_p", SOLUTION_ORBIT, 6.66, 1.0, {2.008619860875, 0.0}, 6.6632868593231302, 12, true},
};
/* clang-format on */

static struct scene typed(const char *const *lines)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    return scene;
}

static int variables(const char *const *lines)
{
    int n = 0;
    while (strncmp(lines[n], "var ", 4) == 0)
        n++;
    return n;
}

static double off(double value, double wanted)
{
    return fabs(value - wanted) / (wanted == 0 ? 1 : fabs(wanted));
}

static struct branch follow(const char *name, const struct branch_request *request)
{
    struct branch branch;
    struct error error = {0};
    if (!branch_follow(request, &branch, &error))
        fail_msg("%s: %s", name, error.text);
    return branch;
}

static const struct branch_point *first_of(const struct branch *branch, enum special special)
{
    for (int i = 0; i < branch->count; i++)
        if (branch->point[i].special == special)
            return &branch->point[i];
    return NULL;
}

static double nearest_special(const struct special_row *row, const struct branch *branch)
{
    double best = HUGE_VAL;
    for (int i = 0; i < branch->count; i++) {
        const struct branch_point *point = &branch->point[i];
        if (point->special == row->special)
            best = fmin(best, off(row->criticality ? point->criticality : point->solution.param[0],
                                  row->value));
    }
    return best;
}

static void test_specials(void **state)
{
    (void)state;
    int confirmed = 0;
    for (size_t k = 0; k < COUNT_OF(special_rows); k++) {
        const struct special_row *row = &special_rows[k];
        if (row->leave != SPECIAL_NONE && !is_long())
            continue; /* whole branches of orbits: seconds */
        const struct scene scene = typed(row->lines);
        struct solution start = {.kind = row->kind,
                                 .n = variables(row->lines),
                                 .param = {row->start},
                                 .period = row->period,
                                 .multiple = row->kind == SOLUTION_RESPONSE};
        memcpy(start.state, row->state, sizeof row->state);
        struct branch_request request = {.scene = &scene,
                                         .param = scene_param(&scene, row->param),
                                         .low = row->from,
                                         .high = row->to,
                                         .start = &start};
        struct branch branch = follow(row->name, &request);
        if (row->leave != SPECIAL_NONE) {
            struct branch_point left = {.special = SPECIAL_NONE};
            if (first_of(&branch, row->leave))
                left = *first_of(&branch, row->leave);
            branch_free(&branch);
            request.leave = &left;
            branch = follow(row->name, &request);
        }
        branch_verify(&request, &branch);
        for (int i = 0; i < branch.count; i++)
            if (branch.point[i].verified > 0)
                confirmed++;
            else if (branch.point[i].verified < 0)
                fail_msg("%s: runs contradict a point at %.17g", row->name,
                         branch.point[i].solution.param[0]);
        const double error = nearest_special(row, &branch);
        if (!(error <= (row->criticality ? 10 : 1) * pow(10, -row->digits)))
            fail_msg("%s: no such point within %g of %.17g", row->name, error, row->value);
        branch_free(&branch);
    }
    assert_true(confirmed >= 70);
}

/* A label that is put where nothing happens is not confirmed. */
static void test_false_labels(void **state)
{
    (void)state;
    const struct scene scene =
        typed((const char *const[]){"var x = 7", "var y = 7", "var z = 19", "param r = 20",
                                    "x' = 10*(y-x)", "y' = x*(r-z)-y", "z' = x*y-8/3*z", NULL});
    const struct solution start = {
        .kind = SOLUTION_EQUILIBRIUM, .n = 3, .param = {20}, .state = {7.118, 7.118, 19}};
    const struct branch_request request = {
        .scene = &scene, .param = scene_param(&scene, "r"), .low = 15, .high = 30, .start = &start};
    struct branch branch = follow("Lorenz", &request);
    static const enum special labels[] = {SPECIAL_FOLD, SPECIAL_HOPF, SPECIAL_CROSSING};
    int real = 0;
    for (int i = 0; i < branch.count; i++)
        if (branch.point[i].special == SPECIAL_NONE)
            branch.point[i].special = labels[i % 3];
        else
            real += branch.point[i].special == SPECIAL_HOPF;
    branch_verify(&request, &branch);
    int confirmed = 0;
    for (int i = 0; i < branch.count; i++)
        confirmed += branch.point[i].verified > 0;
    assert_int_equal(real, 1);
    assert_int_equal(confirmed, 1);
    branch_free(&branch);
}

static void test_orbits(void **state)
{
    (void)state;
    for (size_t k = 0; k < COUNT_OF(orbit_rows); k++) {
        const struct orbit_row *row = &orbit_rows[k];
        const struct scene scene = typed(row->lines);
        const double around = 1e-3 * fabs(row->at);
        struct solution start = {.kind = row->kind,
                                 .n = variables(row->lines),
                                 .param = {row->at},
                                 .period = row->period,
                                 .multiple = row->kind == SOLUTION_RESPONSE};
        memcpy(start.state, row->state, sizeof row->state);
        const struct branch_request request = {.scene = &scene,
                                               .param = scene_param(&scene, row->param),
                                               .low = row->at - around,
                                               .high = row->at + around,
                                               .start = &start,
                                               .max = 1,
                                               .forward = true};
        struct branch branch = follow(row->name, &request);
        const struct solution *s = &branch.point[0].solution;
        assert_true(s->param[0] == row->at);
        double best = row->is_period ? off(s->period, row->value) : HUGE_VAL;
        for (int i = 0; i < s->values && !row->is_period; i++)
            best = fmin(best, off(s->value[i].re, row->value));
        if (!(best <= pow(10, -row->digits)))
            fail_msg("%s: off by %g of %.17g", row->name, best, row->value);
        branch_free(&branch);
    }
}

/* Curves of special points in two parameters, from the first such point of a branch. */
static struct branch two(const char *name, const struct scene *scene, const char *param,
                         const struct branch_axis *second, const struct solution *start,
                         double from, double to, enum special kind)
{
    struct branch_request request = {.scene = scene,
                                     .param = scene_param(scene, param),
                                     .low = from,
                                     .high = to,
                                     .start = start};
    struct branch branch = follow(name, &request);
    assert_non_null(first_of(&branch, kind));
    const struct branch_point left = *first_of(&branch, kind);
    branch_free(&branch);
    request.leave = &left;
    request.second = second;
    return follow(name, &request);
}

/* h = 2 (r/3)^(3/2) on both sides of the cusp at 0. */
static void test_cusp(void **state)
{
    (void)state;
    const struct scene scene = typed(
        (const char *const[]){"var x = 1", "param h = 0", "param r = 1", "x' = h+r*x-x^3", NULL});
    const struct solution start = {.kind = SOLUTION_EQUILIBRIUM, .n = 1, .state = {1}};
    const struct branch_axis second = {scene_param(&scene, "r"), -1, 3};
    struct branch branch = two("cusp", &scene, "h", &second, &start, -2, 2, SPECIAL_FOLD);
    const struct branch_point *cusp = first_of(&branch, SPECIAL_CUSP);
    assert_non_null(cusp);
    close_to(cusp->solution.param[0], 0, 1e-12);
    close_to(cusp->solution.param[1], 0, 1e-12);
    for (int i = 0; i < branch.count; i++) {
        const double *p = branch.point[i].solution.param;
        close_to(fabs(p[0]), 2 * pow(fmax(p[1], 0) / 3, 1.5), 1e-10);
    }
    close_to(branch.point[0].solution.param[1], 3, 1e-9);
    close_to(branch.point[branch.count - 1].solution.param[1], 3, 1e-9);
    branch_free(&branch);
}

/* The same of a response, beside which a forced variable goes its way, and of circles, in x^2 + y^2
 * - 1. */
static void test_cusp_of_orbits(void **state)
{
    (void)state;
    static const char *const lines[][8] = {
        {"var x = 1", "var y = 0.5", "param h = 0", "param r = 1", "x' = h+r*x-x^3",
         "y' = cos(t)-y"},
        {"var x = 1.5", "var y = 0", "param h = 0", "param r = 1",
         "x' = x*(h+r*(x^2+y^2-1)-(x^2+y^2-1)^3)-y", "y' = y*(h+r*(x^2+y^2-1)-(x^2+y^2-1)^3)+x"}};
    const struct solution start[] = {
        {.kind = SOLUTION_RESPONSE, .n = 2, .multiple = 1, .state = {1, 0.5}},
        {.kind = SOLUTION_ORBIT, .n = 2, .period = 2 * acos(-1), .state = {sqrt(2), 0}}};
    for (int k = 0; k < 2; k++) {
        const struct scene scene = typed(lines[k]);
        const struct branch_axis second = {scene_param(&scene, "r"), -0.2, 1.5};
        struct branch branch = two("cusp", &scene, "h", &second, &start[k], -1, 1, SPECIAL_FOLD);
        const struct branch_point *cusp = first_of(&branch, SPECIAL_CUSP);
        assert_non_null(cusp);
        close_to(cusp->solution.param[0], 0, 1e-10);
        close_to(cusp->solution.param[1], 0, 1e-7);
        for (int i = 0; i < branch.count; i++) {
            const double *p = branch.point[i].solution.param;
            close_to(fabs(p[0]), 2 * pow(fmax(p[1], 0) / 3, 1.5), 1e-9);
        }
        branch_free(&branch);
    }
}

/* r = s (s + b + 3)/(s - b - 1) */
static void test_hopf_curve(void **state)
{
    (void)state;
    const struct scene scene = typed((const char *const[]){
        "var x = 7", "var y = 7", "var z = 19", "param s = 10", "param b = 2.6666666666666665",
        "param r = 20", "x' = s*(y-x)", "y' = x*(r-z)-y", "z' = x*y-b*z", NULL});
    const struct solution start = {
        .kind = SOLUTION_EQUILIBRIUM, .n = 3, .param = {20}, .state = {7.118, 7.118, 19}};
    const struct branch_axis second = {scene_param(&scene, "s"), 5, 30};
    struct branch branch = two("Lorenz", &scene, "r", &second, &start, 0, 100, SPECIAL_HOPF);
    assert_true(branch.count > 10);
    for (int i = 0; i < branch.count; i++) {
        const double r = branch.point[i].solution.param[0], s = branch.point[i].solution.param[1];
        close_to(r, s * (s + 8.0 / 3 + 3) / (s - 8.0 / 3 - 1), 1e-10 * r);
    }
    branch_free(&branch);
}

/* Bazykin's predator and prey (Kuznetsov 2004, 8.2): the fold and the Hopf curve meet. */
static void test_bogdanov_takens(void **state)
{
    (void)state;
    const struct scene scene = typed(
        (const char *const[]){"var x = 3", "var y = 2", "param al = 0.4", "param de = 0.17",
                              "x' = x-x*y/(1+al*x)-0.01*x^2", "y' = -y+x*y/(1+al*x)-de*y^2", NULL});
    const struct solution start = {
        .kind = SOLUTION_EQUILIBRIUM, .n = 2, .param = {0.4}, .state = {2.9941, 2.1318}};
    const struct branch_axis second = {scene_param(&scene, "de"), 0.02, 0.6};
    static const enum special kinds[] = {SPECIAL_FOLD, SPECIAL_HOPF};
    for (int k = 0; k < 2; k++) {
        struct branch branch = two("Bazykin", &scene, "al", &second, &start, 0.1, 0.9, kinds[k]);
        const struct branch_point *point = first_of(&branch, SPECIAL_DOUBLE);
        assert_non_null(point);
        close_to(point->solution.param[0], 0.45362432777812946, 1e-12);
        close_to(point->solution.param[1], 0.17512759295021742, 1e-12);
        branch_free(&branch);
    }
}

/* Mathieu's equation: at q = 0 the boundary of the first unstable tongue is a = 1. */
static void test_tongue(void **state)
{
    (void)state;
    const struct scene scene =
        typed((const char *const[]){"var x = 0", "var v = 0", "param a = 0.5", "param q = 1",
                                    "x' = v", "v' = -(a-2*q*cos(2*t))*x", NULL});
    const struct solution start = {
        .kind = SOLUTION_RESPONSE, .n = 2, .param = {1.5}, .multiple = 1};
    const struct branch_axis second = {scene_param(&scene, "q"), 0.01, 1.5};
    struct branch branch = two("Mathieu", &scene, "a", &second, &start, 1, 3, SPECIAL_DOUBLING);
    bool passes = false;
    for (int i = 0; i < branch.count; i++) {
        /* 1 + q - q^2/8 - q^3/64 - q^4/1536 (Abramowitz, Stegun 1964, 20.2.25) */
        const double a = branch.point[i].solution.param[0], q = branch.point[i].solution.param[1],
                     series = 1 + q - q * q / 8 - q * q * q / 64 - q * q * q * q / 1536;
        close_to(a, series, 1e-3 * q * q * q * q * q + 1e-10);
        passes = passes || q < 0.011;
    }
    assert_true(passes);
    branch_free(&branch);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_specials),        cmocka_unit_test(test_false_labels),
        cmocka_unit_test(test_orbits),          cmocka_unit_test(test_cusp),
        cmocka_unit_test(test_cusp_of_orbits),  cmocka_unit_test(test_hopf_curve),
        cmocka_unit_test(test_bogdanov_takens), cmocka_unit_test(test_tongue)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
