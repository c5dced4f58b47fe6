// SPDX-License-Identifier: MIT
// Noise that the on-board predictor counts with. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>

namespace seatrial {

inline constexpr double kNoTurn = 1e-3;  // [rad/s] errors of the poses below this do not swing

/// What a while leaves of a damped oscillation e'' + (2 / memory) e' + turn^2 e = white noise, its
/// state (e, e' / turn). Both have the variance s of e, and are not correlated; so what is new of
/// them after it is s (I - F F'), F this.
struct Swing {
  double ee = 1.0, eo = 0.0, oe = 0.0, oo = 1.0;  // F; e: the error, o: its other side

  Swing() = default;
  /// memory [s], turn [rad/s], t [s].
  Swing(double memory, double turn, double t) {
    const double fades = 1.0 / memory;
    const double square = turn * turn - fades * fades;
    const double rate = std::sqrt(std::abs(square));
    const double left = std::exp(-t * fades);
    double c = 1.0;
    double s = t;  // sin(rate t) / rate
    if (rate * t > 1e-6) {
      c = square > 0.0 ? std::cos(rate * t) : std::cosh(rate * t);
      s = (square > 0.0 ? std::sin(rate * t) : std::sinh(rate * t)) / rate;
    }
    ee = left * (c + fades * s);
    oo = left * (c - fades * s);
    eo = left * turn * s;
    oe = -eo;
  }

  void turn(double& error, double& other) const {
    const double was = error;
    error = ee * was + eo * other;
    other = oe * was + oo * other;
  }
  /// I - F F': of the error, of both, of the other side.
  double new_error() const { return 1.0 - ee * ee - eo * eo; }
  double new_both() const { return -ee * oe - eo * oo; }
  double new_other() const { return 1.0 - oe * oe - oo * oo; }
};

/// Noise of poses and motion; the names are the model file's.
struct MotionNoise {
  double position = 1e-3;            // [m]
  double heading = 1e-3;             // [rad]
  double walk_linear = 2e-3;         // [m/s / sqrt(s)] random walk of u and v
  double walk_yaw = 1e-2;            // [rad/s / sqrt(s)]
  double disturbance_linear = 3e-2;  // [m/s^2] that comes and goes
  double disturbance_yaw = 5e-2;     // [rad/s^2]
  double memory = 2.0;               // [s] time constant of the disturbance
  double colour_position = 0.0;      // [m] correlated errors of the poses, beside the white
  double colour_heading = 0.0;       // [rad]
  double colour_memory = 0.3;        // [s] time constant of these
  double colour_turn = 0.0;          // [rad/s] how fast they swing meanwhile

  bool coloured() const { return colour_position > 0.0 || colour_heading > 0.0; }
  bool swinging() const { return coloured() && colour_turn > kNoTurn; }
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
