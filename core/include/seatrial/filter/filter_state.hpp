// SPDX-License-Identifier: MIT
// State of the extended Kalman filter. No heap, no exceptions.
//
//   x, y [m], psi [rad], u, v [m/s], r [rad/s]     the boat
//   d_u, d_v [m/s^2], d_r [rad/s^2]                the disturbance, a Gauss-Markov process
//   3 x [m, m, rad]                                coloured pose noise, where the noise has any
//   3 x [m, m, rad]                                and, where it oscillates, its quadrature states
#pragma once
#include "seatrial/integration/sensitivities.hpp"

namespace seatrial {

inline constexpr int kPose = 3;                        // x, y [m], psi [rad] are measured
inline constexpr int kFilterStates = kStates + kAxes;  // boat and disturbance
inline constexpr int kColouredStates = kFilterStates + kPose;
inline constexpr int kOscillatingStates = kColouredStates + kPose;

/// States that the motion depends on: psi, u, v, r and the disturbance, not the position.
inline constexpr int kMoving = kFilterStates - 2;

/// d (boat's states after a step) / d (psi, u, v, r and disturbance before it).
using MotionSlopes = double[kStates][kMoving];

/// Mean, covariance and columns D of up to W states. The C columns are carried through predictions
/// and updates with the state: for the estimator the sensitivities d x / d parameters, on board
/// the cross-covariance of x with the errors of the model's parameters (Schmidt-Kalman). Aligned:
/// of an even width all rows are then read two numbers at once.
template <int W, int C>
struct FilterState {
  static constexpr int kWidth = W;
  static constexpr int kColumns = C;
  double x[W] = {};
  alignas(16) double p[W][W] = {};
  alignas(16) double d[W][C] = {};
};

}  // namespace seatrial
