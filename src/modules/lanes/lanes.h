/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many trajectories at once, in vectors: for modules that step many systems of one kind, such as
 * sweeps and basins. The order is lanes_create(), lanes_begin(), lanes_set() of every lane,
 * lanes_march(), lanes_state(), lanes_destroy(). */
#pragma once

#include <hooke/method.h>
#include <hooke/scene/formula.h>

/* ---- many trajectories at once ----
 *
 * LANE_COUNT systems of one kind, stepped side by side in vectors: each gets the bits that
 * method_turning_march() would give it alone. Explicit Runge-Kutta methods and splittings, fixed
 * steps forward in time, oscillators, pendulums, typed scenes.
 */
#define LANE_COUNT 64

struct lanes;

/* Returns true if such a system can be stepped in lanes with this method, drag (as resolved by
 * method_applies()) and step. */
bool lanes_fit(const struct method *method, const struct system *system, enum drag drag, double h);
/* Returns true if both systems can be stepped in the same lanes. */
bool lanes_alike(const struct system *a, const struct system *b);
struct lanes *lanes_create(void); /* Returns NULL if out of memory */
/* Frees the lanes; NULL is allowed. */
void lanes_destroy(struct lanes *lanes);
/* Prepares lanes for systems like this one. Returns false if out of memory. */
bool lanes_begin(struct lanes *lanes, const struct method *method, enum drag drag,
                 const struct system *like, double h);
/* Starts this lane at the system's initial state, before the first step; the system must outlive
 * the lanes. Every lane has to be set, with a copy of another if necessary. */
void lanes_set(struct lanes *lanes, int lane, const struct system *system);
/* Does the same as lanes_set() with steps of h [s] in this lane. Its system may have another t0
 * than the other lanes, unless steps are adaptive. */
void lanes_set_step(struct lanes *lanes, int lane, const struct system *system, double h);
/* Makes `count` steps in all lanes, without any checks. row [count][2][LANE_COUNT] receives the
 * first variable and its derivative after each step, or is NULL. */
void lanes_march(struct lanes *lanes, int64_t count, double *row);
/* Writes the present first variable and its derivative, [2][LANE_COUNT]. */
void lanes_row(struct lanes *lanes, double *row);
/* Copies the state of a lane to y. */
void lanes_state(const struct lanes *lanes, int lane, double *y);
/* Returns the number of evaluations in a lane since lanes_set(). */
int64_t lanes_evals(const struct lanes *lanes, int lane);
/*
 * Adaptive steps in lanes as by method_adapt(). Each lane has its own controller, which starts with
 * the step of lanes_begin(). lanes_adapt_fit() returns true if such systems can be stepped in
 * lanes. After lanes_begin() and lanes_set() of all lanes, lanes_control() takes the first step of
 * the first `used` ones, with tolerances tol [used]. A lane whose next step becomes shorter than
 * the fraction `creep` of the time since the start stops, unless the system is linear. Then
 * lanes_adapt() attempts the given number of steps and returns false if all lanes have ended. row
 * [attempts][3][LANE_COUNT] receives t [s], the variable and its derivative after each attempt,
 * unchanged if that was rejected; it may be NULL.
 */
bool lanes_adapt_fit(const struct method *method, const struct system *system, enum drag drag,
                     double h);
void lanes_control(struct lanes *lanes, int used, const double *tol, double t_end, double creep);
bool lanes_adapt(struct lanes *lanes, int64_t attempts, double *row);
/* Writes the present values, [3][LANE_COUNT]. */
void lanes_adapted_row(const struct lanes *lanes, double *row);
/* Sets the numbers of steps and evaluations of a lane. Returns false if it has not arrived at t_end
 * in lanes; it may do so alone. */
bool lanes_adapted(const struct lanes *lanes, int lane, int64_t *steps, int64_t *evals);
/* Returns true if a step reuses an evaluation of the previous one. */
bool lanes_carry(const struct method *method, enum drag drag);

/* ---- programs of formulas on many lanes: the same bits as program_eval(), with PROGRAM_LANES
 * doubles for each name and output. Arrays should be aligned to 64 bytes. ---- */
#define PROGRAM_LANES LANE_COUNT

/* Knowledge about a program's names or values. */
enum program_lanes {
    LANES_ALIKE = 1, /* the same value in all lanes, whenever it is evaluated */
    LANES_FIXED = 2, /* the same values from here on */
};

/* Returns the size [double] of a program's frame. */
size_t program_frame_lanes(const struct program *program);
/* Prepares a frame for names at `input` [names][PROGRAM_LANES], which must not move. lanes [names]
 * tells what is known of them (enum program_lanes), or is NULL; fixed ones must have their values
 * already. */
void program_prepare_lanes(const struct program *program, const double *input,
                           const unsigned char *lanes, double *frame);
/* Evaluates the program with the prepared frame; output is [outputs][PROGRAM_LANES]. */
void program_eval_lanes(const struct program *program, double *output, double *frame);
