// SPDX-License-Identifier: MIT
// Noise of poses and motion: one set of parameters for the estimator's filter and that on board. No
// heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>

namespace seatrial {

inline constexpr int kNoiseParameters = 12;
inline constexpr int kTurnParameter = 10;
inline constexpr double kNoColour = 1e-8;  // [m, rad] coloured pose noise below this: none
inline constexpr double kNoTurn = 1e-3;    // [rad/s] coloured pose noise below this: no oscillation

/// Transition over a time of a damped oscillator e'' + (2 / memory) e' + turn^2 e = white noise,
/// with the state (e, e' / turn). Both states have the variance s of e and are uncorrelated, so
/// that the process noise is s (I - F F'), F the transition.
struct Oscillator {
  double ee = 1.0, eo = 0.0, oe = 0.0, oo = 1.0;  // F; e: the error, o: e' / turn

  Oscillator() = default;
  /// memory [s], turn [rad/s], t [s].
  Oscillator(double memory, double turn, double t) {
    const double damping = 1.0 / memory;
    const double square = turn * turn - damping * damping;
    const double rate = std::sqrt(std::abs(square));
    const double left = std::exp(-t * damping);
    double c = 1.0;
    double s = t;  // sin(rate t) / rate
    if (rate * t > 1e-6) {
      c = square > 0.0 ? std::cos(rate * t) : std::cosh(rate * t);
      s = (square > 0.0 ? std::sin(rate * t) : std::sinh(rate * t)) / rate;
    }
    ee = left * (c + damping * s);
    oo = left * (c - damping * s);
    eo = left * turn * s;
    oe = -eo;
  }

  void turn(double& error, double& other) const {
    const double was = error;
    error = ee * was + eo * other;
    other = oe * was + oo * other;
  }
  /// I - F F': of the error, of both, of e' / turn.
  double noise_error() const { return 1.0 - ee * ee - eo * eo; }
  double noise_both() const { return -ee * oe - eo * oo; }
  double noise_other() const { return 1.0 - oe * oe - oo * oo; }
};

/// Standard deviations, spectra and time constants; the names are the model file's. The estimator's
/// noise parameters are their logarithms, in this order. An earth-fixed disturbance has a ratio
/// of 1.
struct NoiseParameters {
  double position = 1e-3;            // [m] white noise of the poses
  double heading = 1e-3;             // [rad]
  double walk_linear = 2e-3;         // [m/s / sqrt(s)] random walk of u and v
  double walk_yaw = 1e-2;            // [rad/s / sqrt(s)] random walk of r
  double disturbance_linear = 3e-2;  // [m/s^2] Gauss-Markov disturbance in surge and sway
  double disturbance_yaw = 5e-2;     // [rad/s^2]
  double memory = 2.0;               // [s] time constant of the disturbance
  double colour_position = 0.0;      // [m] Gauss-Markov noise of the poses, beside the white
  double colour_heading = 0.0;       // [rad]
  double colour_memory = 0.3;        // [s] its time constant
  double colour_turn = 0.0;          // [rad/s] its angular frequency, where waves make it oscillate
  // process noise of sway over that of surge, in body axes: a force moves unequal masses unequally
  double sway_ratio = 1.0;

  bool coloured() const { return colour_position > kNoColour || colour_heading > kNoColour; }
  bool oscillating() const { return coloured() && colour_turn > kNoTurn; }

  /// Standard deviations of the poses' x, y [m], psi [rad].
  double white(int i) const { return i < 2 ? position : heading; }
  double colour(int i) const { return i < 2 ? colour_position : colour_heading; }
  /// Variances of the same [m^2, rad^2].
  double white_variance(int i) const { return white(i) * white(i); }
  double colour_variance(int i) const { return colour(i) * colour(i); }
  /// Of surge, sway, yaw.
  double walk(int axis) const { return axis < 2 ? share(axis) * walk_linear : walk_yaw; }
  double disturbance(int axis) const {
    return axis < 2 ? share(axis) * disturbance_linear : disturbance_yaw;
  }

  double& parameter(int i) {
    double* const all[kNoiseParameters] = {
        &position,           &heading,         &walk_linear, &walk_yaw,
        &disturbance_linear, &disturbance_yaw, &memory,      &colour_position,
        &colour_heading,     &colour_memory,   &colour_turn, &sway_ratio};
    return *all[i];
  }

 private:
  double share(int axis) const { return axis == 1 ? sway_ratio : 1.0; }
};

/// The same power in surge and sway, the mean of both: the process noise of an earth-fixed
/// disturbance, and where other noise adds that has no direction.
inline NoiseParameters equal_in_plane(NoiseParameters n) {
  const double mean = std::sqrt(0.5 * (1.0 + n.sway_ratio * n.sway_ratio));
  n.walk_linear *= mean;
  n.disturbance_linear *= mean;
  n.sway_ratio = 1.0;
  return n;
}

/// Process noise no less than the default: for a model that poses contradicted.
inline NoiseParameters with_default_process_noise(const NoiseParameters& own) {
  NoiseParameters n = equal_in_plane(own);
  const NoiseParameters least;
  n.walk_linear = std::max(n.walk_linear, least.walk_linear);
  n.walk_yaw = std::max(n.walk_yaw, least.walk_yaw);
  n.disturbance_linear = std::max(n.disturbance_linear, least.disturbance_linear);
  n.disturbance_yaw = std::max(n.disturbance_yaw, least.disturbance_yaw);
  n.memory = std::max(n.memory, least.memory);
  return n;
}

}  // namespace seatrial
