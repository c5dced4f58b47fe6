// SPDX-License-Identifier: MIT
// Inputs and results of a run of the estimator's filter along a recording. Host side: uses heap.
#pragma once
#include <cmath>
#include <vector>

#include "seatrial/filter/ekf_update.hpp"
#include "seatrial/filter/gauss_markov.hpp"

namespace seatrial {

inline constexpr double kPoseSpread = 3.0;  // of the first pose, in standard deviations of one

/// Start of a recording: the state, and the standard deviations of its velocity. The pose has three
/// standard deviations of a measured one, the disturbance its stationary one.
struct FilterStart {
  double state[kStates];   // x, y [m], psi [rad], u, v [m/s], r [rad/s]
  double velocity[kAxes];  // [m/s, m/s, rad/s]
};

/// Sensor position, and what differs from one recording to the next.
struct Effects {
  double lever[2] = {0.0, 0.0};      // [m] the measured point, forward and left of the origin
  double current[2] = {0.0, 0.0};    // [m/s] earth-fixed; the velocity is then that in the water
  double bias[3] = {0.0, 0.0, 0.0};  // [m/s^2, rad/s^2] body-fixed: trim
  double wind[kWindParts] = {};      // earth-fixed: see Disturbing
  double position_delay = 0.0;       // [s] by which the position is older than its stamp
  double heading_delay = 0.0;        // [s] by which the heading is
  double later[2] = {0.0, 0.0};      // [s] further delays of both, to first order
  bool earth_fixed = false;          // the disturbance in surge and sway; else body-fixed
};
/// First parameter of each.
enum Effect { kLever = 0, kCurrent = 2, kBias = 4, kWind = 7, kDelay = kWind + kWindParts };
inline constexpr int kEffects = kDelay + 2;

/// Use of a pose.
enum Use : signed char {
  kNotMeasured = 0,
  kMeasured = 1,
  kJumped = 2,     // the first after a jump for good: it may be anywhere
  kGapped = 3,     // the first after a gap, in which the poses may have jumped
  kBeginning = 4,  // the first after a gap in the commands: the filter restarts
};

/// Poses of one recording, and asynchronous measurements: of sensors with stamps of their own.
struct PoseSeries {
  int n = 0;
  const double* time = nullptr;      // (n) [s], rising
  const double* eta = nullptr;       // (n, 3)
  const signed char* use = nullptr;  // (n) Use
  const double* velocity = nullptr;  // (n, 3) [m/s, m/s, rad/s] of those that are kBeginning
  double position_delay = 0.0;       // [s] the known part of the effect
  const Parts* parts = nullptr;      // (n) measured parts of each pose; null: all are whole
  int n_asynchronous = 0;
  const double* asynchronous_time =
      nullptr;  // (n_asynchronous) [s], rising, from the first pose on
  const double* asynchronous_value = nullptr;  // (n_asynchronous) heading [rad] or yaw rate [rad/s]
  const Parts* asynchronous_parts =
      nullptr;                  // (n_asynchronous) kHeadingPart, kRatePart, or kNoPart
  double rate_deviation = 0.0;  // [rad/s] standard deviation of the yaw rates' white noise
  int n_input_errors = 0;       // of the thrust, where the commands are samples
  const double* input_error_time = nullptr;  // (n_input_errors) [s], rising
  // (n_input_errors, 6) covariance of what they changed the velocity by up to then, linear between:
  // uu, uv, ur, vv, vr, rr
  const double* input_error = nullptr;
};

/// A prediction from one pose to the next, to repeat it with other noise. Long recordings have
/// many: the slopes are single precision, less the identity, which keeps their digits.
struct Transition {
  double to[kStates];             // the model's prediction
  float slope[kStates][kMoving];  // d to / d what it depends on, less 1 for the same state
};

/// A pose beside its prediction, with its part of the cost.
struct CostedInnovation : Innovation {
  double cost = 0.0;  // rho(e' S^-1 e) + log det S
};

/// Results of a run. Parameters: the chosen coefficients, then the chosen constants, then all
/// effects where they are parameters.
struct FilterRun {
  int parameters = 0;
  bool good = true;
  Effects effects;
  double cost = 0.0;                   // sum of rho(e' S^-1 e) + log det S over measured poses
  std::vector<double> information;     // (p, p) sum of J' S^-1 J
  std::vector<double> gradient;        // (p) sum of J' S^-1 e
  std::vector<double> score;           // (blocks, p) terms of the gradient
  std::vector<double> share;           // (blocks, p, p) terms of the information; optional
  std::vector<double> innovation;      // (n, 3)
  std::vector<float> spread;           // (n, 6) S: xx, xy, xpsi, yy, ypsi, psipsi
  std::vector<double> state;           // (n, 9) after the pose was used
  std::vector<float> deviation;        // (n, 3) standard deviations of the velocity after it
  std::vector<float> weight;           // (n) of each pose: 1, less for outliers, 0 for unused ones
  std::vector<Transition> transition;  // one fewer than updates; optional
  std::vector<float> gain;             // (the same, 6, p) d transition / d parameters; optional
  std::vector<double> update_state;    // (updates, 9) where they are not one a pose; optional
};

}  // namespace seatrial
