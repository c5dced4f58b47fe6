// SPDX-License-Identifier: MIT
// Noise that the on-board predictor counts with. No heap, no exceptions.
#pragma once
#include <algorithm>

namespace seatrial {

/// Noise of poses and motion; the names are the model file's.
struct MotionNoise {
  double position = 1e-3;            // [m]
  double heading = 1e-3;             // [rad]
  double walk_linear = 2e-3;         // [m/s / sqrt(s)] random walk of u and v
  double walk_yaw = 1e-2;            // [rad/s / sqrt(s)]
  double disturbance_linear = 3e-2;  // [m/s^2] that comes and goes
  double disturbance_yaw = 5e-2;     // [rad/s^2]
  double memory = 2.0;               // [s] time constant of the disturbance
  double colour_position = 0.0;      // [m] errors of the poses that hang together, beside the white
  double colour_heading = 0.0;       // [rad]
  double colour_memory = 0.3;        // [s] time constant of these

  bool coloured() const { return colour_position > 0.0 || colour_heading > 0.0; }
  /// Of the poses' x, y [m^2], psi [rad^2].
  double white_variance(int i) const { return i < 2 ? position * position : heading * heading; }
  double colour_variance(int i) const {
    return i < 2 ? colour_position * colour_position : colour_heading * colour_heading;
  }
};

/// Where the boat does what the model does not explain: process noise no less than the default.
inline MotionNoise wary(MotionNoise n) {
  const MotionNoise least;
  n.walk_linear = std::max(n.walk_linear, least.walk_linear);
  n.walk_yaw = std::max(n.walk_yaw, least.walk_yaw);
  n.disturbance_linear = std::max(n.disturbance_linear, least.disturbance_linear);
  n.disturbance_yaw = std::max(n.disturbance_yaw, least.disturbance_yaw);
  n.memory = std::max(n.memory, least.memory);
  return n;
}

}  // namespace seatrial
